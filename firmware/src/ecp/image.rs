//! What the ECP perceives and what it demands.

use crate::capacity::PATH_ELEMENTS_PER_MACROSTEP;
use protocol::fault::Refusal;
use protocol::message::{Coordination, PathElement};
use protocol::time::Micros;
use robots::{JointMotion, Joints, MotorMotion, Motors};

/// `c_0`: what the coordinator says, as the ECP received it.
#[derive(Clone, Debug, PartialEq)]
pub struct Coordinator {
    /// The latest cyclic message's content; tight knots are offered one after the other, in time.
    pub says: Coordination,
    /// The coordinator asked to end the motion (MRROC++'s `END_MOTION`).
    pub end_motion: bool,
    /// Elements of a streamed path that are to be taken in this macrostep, with their numbers.
    pub path: heapless::Vec<(u32, PathElement), PATH_ELEMENTS_PER_MACROSTEP>,
    /// The feed rate on a path as a share of the programmed one, -1 to 1.
    pub feed_override: f64,
}

/// `e_j`: the image of the effector, in the ontologies of \[Z2\] Fig. 1 (the third, the pose of the
/// end-effector, follows from the joints by the robot's forward kinematics).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectorImage<const N: usize> {
    /// Measured motor angles, rad.
    pub motors: Motors<N>,
    /// Measured joint positions, rad or m; `None` before synchronisation.
    pub joints: Option<Joints<N>>,
    /// Where the set-points stand at the end of the queue: motor angles, rad.
    pub demanded_motors: Motors<N>,
    /// The same as joint positions; `None` before synchronisation.
    pub demanded_joints: Option<Joints<N>>,
    /// Demand minus actual of the last step, rad of the motor shaft.
    pub following_error: [f64; N],
}

/// What of `e_j` the servo step hands over: the joints follow from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectorAtMotors<const N: usize> {
    /// Measured motor angles, rad.
    pub motors: Motors<N>,
    /// Where the set-points stand at the end of the queue: motor angles, rad.
    pub demanded_motors: Motors<N>,
    /// Demand minus actual of the last step, rad of the motor shaft.
    pub following_error: [f64; N],
    /// Are all axes homed? Else there are no joints.
    pub homed: bool,
}

/// `v_j`: the bundle of virtual sensor readings on the node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensors<const N: usize> {
    /// Motor effort: |current| as a fraction of the drive's limit, low-pass filtered over a
    /// macrostep. Gravity and friction are part of it.
    pub effort: [f64; N],
    /// How much the force at the wrist has changed since the motion began, N; none where none can be read.
    pub force_n: Option<f64>,
}

impl<const N: usize> Sensors<N> {
    /// Nothing read yet.
    pub const NONE: Self = Self {
        effort: [0.0; N],
        force_n: None,
    };
}

/// `yc_e`: what the ECP demands of the EDP for the next macrostep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Demand<const N: usize> {
    /// e^{i+1} = e^i.
    Stay,
    /// A motion state of the motor shafts.
    Motors(MotorMotion<N>),
    /// A motion state of the joints.
    Joints(JointMotion<N>),
    /// Two of them, half a macrostep and a macrostep on: for a way that is more curved than one can tell.
    JointsTwice([JointMotion<N>; 2]),
    /// A motion state of the motor shafts at an instant of the coordinator's choice.
    At {
        /// Bus time.
        at: Micros,
        /// The state.
        motion: MotorMotion<N>,
        /// Did the coordinator send an acceleration? If not, the segment is cubic.
        has_acceleration: bool,
    },
    /// The same for the joints.
    JointsAt {
        /// Bus time.
        at: Micros,
        /// The state.
        motion: JointMotion<N>,
        /// Did the coordinator send an acceleration? If not, the segment is cubic.
        has_acceleration: bool,
    },
    /// The generator cannot go on: the instruction ends with this refusal and nothing moves.
    Refuse(Refusal),
}
