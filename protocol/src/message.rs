//! Every message between MP and node: the interface document.
//!
//! Positions of joints are rad or m, of motors rad of the motor shaft; times are bus time.
//! Floats travel as they are, so what the MP computed is what the node executes, bit for bit.

mod event;

pub use event::{DriveFinding, DriveIdentity, Event, HomingPhase};

use crate::fault::{Fault, Refusal};
use crate::time::Micros;
use crate::units::PerAxis;
use serde::{Deserialize, Serialize};

// schema: begin

/// The node's state machine as seen from outside (payload-free mirror of the EDP's).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum NodeState {
    /// Started; drives not yet configured.
    Boot,
    /// Drives are being identified and configured.
    Configuring,
    /// Drives are configured and torque is off.
    Disabled,
    /// Torque is being switched on.
    Enabling,
    /// Torque on, not homed: only relative motor moves.
    Unsynchronised,
    /// Homing.
    Synchronising,
    /// Torque on, homed, at rest.
    Holding,
    /// Executing an instruction.
    Moving,
    /// Coming to rest because of a stop or a fault.
    Stopping,
    /// A fault is latched.
    Faulted,
}

/// The two spaces in which knots are exchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Space {
    /// Motor-shaft angles, rad.
    Motors,
    /// Joint positions, rad or m.
    Joints,
}

/// A knot of the trajectory: what must hold at one instant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct KnotMessage {
    /// The instant, bus time.
    pub at: Micros,
    /// The space of the coordinates.
    pub space: Space,
    /// Position.
    pub position: PerAxis<f64>,
    /// Velocity per second.
    pub velocity: PerAxis<f32>,
    /// Acceleration per second²; empty where a small frame has no room: then the segment is cubic.
    pub acceleration: PerAxis<f32>,
}

/// An item of a finite set: what loose coordination transmits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Decision {
    /// Which decision.
    pub label: u16,
    /// Its variant, as in MRROC++'s `NEXT_STATE`.
    pub variant: i32,
}

/// `c_0` on the wire: what the coordinator says in this macrostep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Coordination {
    /// Nothing: the effector runs on its own. Still renews the lease.
    None,
    /// A decision from a finite set.
    Loose(Decision),
    /// The next location to be attained.
    Tight(KnotMessage),
}

/// The cyclic message MP → node; class A. Valid ones renew the command lease.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Command {
    /// The epoch of the lease.
    pub epoch: u32,
    /// Counts cyclic messages; a gap is a loss.
    pub sequence: u16,
    /// Not to be acted upon after this instant.
    pub valid_until: Micros,
    /// `c_0`.
    pub coordination: Coordination,
}

/// A pose on the wire: position in m, orientation as angle·axis in rad.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoseMessage {
    /// x, y, z in m.
    pub position_m: [f64; 3],
    /// Rotation vector (axis times angle), rad.
    pub rotation_rad: [f64; 3],
}

/// What a pose target is relative to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum PoseReference {
    /// Absolute, in the robot's base frame.
    Base,
    /// Relative to the tool frame at the start: `t_base_goal = t_base_tool · target`.
    Tool,
}

/// The shape of the way to a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum PosePath {
    /// Straight in joint space.
    Joint,
    /// Straight line of the tool's origin, slerp of its orientation.
    Line,
}

/// Speeds of a motor or joint move, as fractions (0, 1] of the robot's planning ceilings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AxisSpeeds {
    /// Velocity, one per axis.
    pub velocity: PerAxis<f32>,
    /// Acceleration, one per axis.
    pub acceleration: PerAxis<f32>,
}

/// Speeds of a Cartesian move; what the joints cannot follow is slowed down.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoseSpeeds {
    /// m/s
    pub velocity_m_s: f32,
    /// rad/s
    pub angular_velocity_rad_s: f32,
    /// m/s²
    pub acceleration_m_s2: f32,
    /// rad/s²
    pub angular_acceleration_rad_s2: f32,
}

/// A condition the wire can name, for `Wait` on the ECP.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum WireCondition {
    /// The coordinator's latest decision has this label.
    Decided {
        /// The label.
        label: u16,
    },
    /// A joint is on the far side of a value (rad or m).
    Joint {
        /// Axis from 0.
        axis: u8,
        /// The bound.
        value: f64,
        /// Hold when above (true) or below (false).
        above: bool,
    },
    /// Every axis is within this following error (rad of the motor shaft).
    Settled {
        /// The window.
        window_rad: f32,
    },
}

/// How far a path may pass by a corner: the corner is rounded within both tolerances.
///
/// A zero in either: the tool goes to the corner and rests there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Corner {
    /// Distance of the tool's origin from the corner's path, m.
    pub metres: f32,
    /// Deviation of the orientation, rad.
    pub radians: f32,
}

/// An element of a path that is streamed to a node; it begins where the one before ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum PathElement {
    /// A point that a smooth curve goes through, as do the points before and after it.
    Through(PoseMessage),
    /// A straight line; the orientation takes the shortest way.
    Line {
        /// Where it ends.
        to: PoseMessage,
        /// The corner it begins with.
        corner: Corner,
    },
    /// A circular arc; the orientation takes the shortest way.
    Arc {
        /// A point on the way, m.
        via_m: [f64; 3],
        /// Where it ends.
        to: PoseMessage,
        /// The corner it begins with.
        corner: Corner,
    },
    /// Nothing more comes: the path ends where it is.
    End,
    /// From here on the tool goes no faster than this, and never faster than the instruction allows.
    Feed {
        /// Speed of the tool's origin, m/s; greater than 0.
        metres_per_second: f32,
    },
}

/// Elements in one [`Request::Path`].
pub const PATH_BATCH: usize = 4;

/// The instruction library of the ECP: what a coordinator can ask a node to do by itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Instruction {
    /// Stay for a while.
    Hold {
        /// How long, ms.
        duration_ms: u32,
    },
    /// Move the motors. The only move allowed before synchronisation, and then only relative.
    MoveMotors {
        /// Motor angles or increments, rad.
        target: PerAxis<f64>,
        /// Is the target an increment?
        relative: bool,
        /// How fast.
        speeds: AxisSpeeds,
    },
    /// Move the joints, straight in joint space.
    MoveJoints {
        /// Joint positions or increments, rad or m.
        target: PerAxis<f64>,
        /// Is the target an increment?
        relative: bool,
        /// How fast.
        speeds: AxisSpeeds,
    },
    /// Move the tool to a pose.
    MovePose {
        /// The pose of the tool.
        target: PoseMessage,
        /// What it is relative to.
        reference: PoseReference,
        /// The way.
        path: PosePath,
        /// How fast.
        speeds: PoseSpeeds,
    },
    /// Follow the knots of tight coordination until [`Request::EndMotion`].
    Follow,
    /// Wait until a condition holds.
    Wait {
        /// The condition `f_I`.
        until: WireCondition,
        /// Give up after this time, ms; 0 = never.
        timeout_ms: u32,
    },
    /// Run a program linked into the node.
    Program {
        /// Its number.
        program: u16,
        /// Its argument.
        argument: f64,
    },
    /// Follow the path that is streamed by [`Request::Path`], from where the tool is.
    FollowPath {
        /// How fast at most; what the joints cannot follow is slowed down.
        speeds: PoseSpeeds,
    },
    /// Move the tool along a straight line to its end, or until the force at the wrist has changed by so much.
    MoveUntilForce {
        /// The pose of the tool.
        target: PoseMessage,
        /// What it is relative to.
        reference: PoseReference,
        /// How fast.
        speeds: PoseSpeeds,
        /// The change of the force that ends it, N.
        newtons: f32,
    },
}

/// How the EDP closes the loop of every axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ServoLaw {
    /// csp: the drive closes the position loop.
    DrivePosition,
    /// cst: MRROC++'s second-order difference equation on increments.
    Original,
    /// cst: PID on position with velocity and acceleration feed-forward.
    FeedForward,
    /// cst: the torques of the arm's equation of motion.
    ComputedTorque,
}

/// The kinds of commanded stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum StopKind {
    /// R1: on the path, torque stays on.
    Path,
    /// R2: quick stop, then torque off.
    Quick,
    /// R3: torque off and brakes at once.
    TorqueOff,
}

/// An acyclic request MP → node; every one is answered by one [`Reply`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Request {
    /// Who are you? Always answered, by every version (message set v0).
    Identify,
    /// Take the command lease.
    Acquire {
        /// A number chosen by the sender; folded into the epoch.
        nonce: u32,
        /// How long the lease lasts without a valid [`Command`], ms (20 to 2000).
        lease_ms: u16,
        /// Take it although another holds it (only at standstill).
        takeover: bool,
    },
    /// Give the lease back.
    Release {
        /// The epoch of the lease.
        epoch: u32,
    },
    /// Switch torque on.
    Enable {
        /// The epoch of the lease.
        epoch: u32,
    },
    /// Switch torque off (only at rest).
    Disable {
        /// The epoch of the lease.
        epoch: u32,
    },
    /// Home every axis that is not homed.
    Synchronise {
        /// The epoch of the lease.
        epoch: u32,
    },
    /// Run one instruction.
    Execute {
        /// The epoch of the lease.
        epoch: u32,
        /// Strictly increasing within the epoch.
        id: u32,
        /// Start at this instant, so that several robots start in the same step; 0 = at once.
        start_at: Micros,
        /// What to do.
        instruction: Instruction,
    },
    /// End the running instruction at the next rest or, for [`Instruction::Follow`], when the queue has run empty.
    EndMotion {
        /// The epoch of the lease.
        epoch: u32,
    },
    /// Stop. Needs no lease.
    Stop {
        /// How.
        kind: StopKind,
    },
    /// Acknowledge the latched fault: possible once its cause is gone.
    Acknowledge {
        /// The epoch of the lease.
        epoch: u32,
    },
    /// Choose the servo law (only while holding or disabled).
    SelectServo {
        /// The epoch of the lease.
        epoch: u32,
        /// The law for all axes.
        law: ServoLaw,
    },
    /// Set the pose of the tool in the flange frame.
    SetTool {
        /// The epoch of the lease.
        epoch: u32,
        /// `t_flange_tool`
        t_flange_tool: PoseMessage,
    },
    /// Publish the demand every n-th servo step; 0 = never.
    Trace {
        /// The epoch of the lease.
        epoch: u32,
        /// n
        every: u16,
    },
    /// More of the path of the running [`Instruction::FollowPath`]; answered by [`Reply::Path`].
    ///
    /// What is known already is skipped, what is beyond a gap or has no room is left: the answer says what is wanted.
    Path {
        /// The epoch of the lease.
        epoch: u32,
        /// Number of the first element, counted from 0 in each instruction.
        first: u32,
        /// The elements.
        elements: heapless::Vec<PathElement, PATH_BATCH>,
    },
    /// The feed rate on a path, as a share of the programmed one, from the next macrostep on.
    FeedOverride {
        /// The epoch of the lease.
        epoch: u32,
        /// From -1 (back along the path) over 0 (feed hold) to 1.
        share: f32,
    },
    /// Switch digital outputs. A fault, torque off or a lost lease switches all of them off.
    Outputs {
        /// The epoch of the lease.
        epoch: u32,
        /// The outputs that change.
        mask: u16,
        /// Those of them that are switched on; [`OUTPUT_SPINDLE`] and the like.
        on: u16,
    },
}

/// The output of a tool's spindle.
pub const OUTPUT_SPINDLE: u16 = 1;

/// The longest robot name, bytes.
pub const MAX_NAME: usize = 24;

/// Who a node is; sent as reply and announced at boot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identity {
    /// The robot, e.g. `irp6-track`.
    pub robot: heapless::String<MAX_NAME>,
    /// Unique id of the hardware, or of the process on a host.
    pub unique_id: u64,
    /// Protocol version: equal major numbers understand the v0 set.
    pub protocol: (u8, u8),
    /// Hash of every message type.
    pub schema_hash: u64,
    /// CRC of the configuration the node runs with.
    pub config_crc: u32,
    /// Firmware version: major, minor, patch.
    pub firmware: (u8, u8, u8),
    /// Number of axes.
    pub axes: u8,
    /// Servo step, µs.
    pub servo_step_us: u32,
    /// Servo steps per macrostep.
    pub macrostep: u16,
}

/// The answer to a [`Request`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Reply {
    /// Done, or accepted and under way: watch [`Feedback`].
    Accepted,
    /// The lease is yours.
    Lease {
        /// Its epoch.
        epoch: u32,
    },
    /// To [`Request::Identify`].
    Identity(Identity),
    /// Refused; nothing changed.
    Refused(Refusal),
    /// To [`Request::Path`].
    Path {
        /// Number of the element wanted next.
        next: u32,
        /// How many are welcome now.
        room: u16,
    },
}

/// How far the latest instruction is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Progress {
    /// No instruction yet in this epoch.
    Idle,
    /// Accepted; waits for its start time or is being planned.
    Pending,
    /// Running.
    Running,
    /// Complete.
    Done,
    /// Ended without completing; why.
    Failed(Refusal),
}

/// The image of an effector: `e_j` and the state of its node; class A, cyclic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Feedback {
    /// Servo steps since boot.
    pub step: u32,
    /// Bus time of the SYNC at which the actual values were sampled.
    pub sampled_at: Micros,
    /// The state.
    pub state: NodeState,
    /// The first latched fault.
    pub fault: Option<Fault>,
    /// Axis k is homed if bit k is set.
    pub synchronised: u8,
    /// The epoch of the lease now valid; 0 = none.
    pub epoch: u32,
    /// The latest instruction's id.
    pub instruction: u32,
    /// Its progress.
    pub progress: Progress,
    /// How far ahead of now the set-point queue reaches, µs.
    pub horizon_us: u32,
    /// Actual motor positions in position units (`units::UNITS_PER_INCREMENT` per increment).
    pub actual: PerAxis<i64>,
    /// Demanded motor positions in the same units and of the same instant.
    pub demand: PerAxis<i64>,
    /// Motor currents, mA.
    pub current_ma: PerAxis<i16>,
    /// Greatest following error since the last message, position units.
    pub following_error: PerAxis<u32>,
    /// Set-points that broke a limit since boot (each was stopped before it was sent).
    pub limit_violations: u32,
    /// Greatest step of acceleration since the last message, rad/s² of a motor; 0 unless a knot brought none.
    pub acceleration_step: f32,
    /// Cyclic messages lost since the lease began.
    pub lost: u32,
    /// The force at the wrist, N along its sensor's axes, the tool's weight included; none if none can be read.
    pub force_n: Option<[f32; 3]>,
}

/// The demand of one servo step; published when [`Request::Trace`] asked for it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DemandTrace {
    /// The servo step.
    pub step: u32,
    /// Demanded motor positions, position units.
    pub demand: PerAxis<i64>,
}

/// Stop everyone; broadcast, needs no lease; class A.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StopAll {
    /// How.
    pub kind: StopKind,
}

/// Two-step time synchronisation: carries the transmission time of the *previous* one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TimeSync {
    /// Counts, so that a loss is noticed.
    pub sequence: u8,
    /// When the previous message left, bus time of the master.
    pub previous_sent_at: Micros,
}

// schema: end

impl NodeState {
    /// All of them, in the order of the wire: the number of each is its place.
    pub const ALL: [Self; 10] = [
        Self::Boot,
        Self::Configuring,
        Self::Disabled,
        Self::Enabling,
        Self::Unsynchronised,
        Self::Synchronising,
        Self::Holding,
        Self::Moving,
        Self::Stopping,
        Self::Faulted,
    ];
}
