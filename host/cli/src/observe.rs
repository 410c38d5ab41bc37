//! Looking on: what a run is measured, recorded and drawn by. Observers see frames and the true
//! mechanics; they take no part.

mod engraving;
mod follow;

use crate::record::Recorder;
pub(crate) use engraving::Engraving;
pub(crate) use follow::Following;
use hil_sim::cell::Observer;
use host::error::Error;
use host::mp::arm::{Arm, motor_angles, unit_rad};
use host::plot::{AxisPlot, PlotData, RobotPlot, StepMark};
use host::program::Segment;
use host::program::progress::Followed;
use host::record::MasterStep;
use host::task::Cell;
use motion::Pose;
use nalgebra::Vector3;
use protocol::frame::Frame;
use protocol::id::NodeId;
use protocol::link::{Endpoint, Message, Role};
use protocol::message::{Feedback, NodeState, ServoLaw};
use protocol::time::Micros;
use protocol::transfer::Mtu;
use protocol::units::PerAxis;
use robots::AxisHoming;

/// A tool on a streamed path goes no farther than this between two SYNCs, m, or lags no more than
/// this behind its set-points.
const PATH_REACH_M: f64 = 5e-3;

/// A plot keeps one sample in this many SYNCs: 50 a second at 2 ms.
const PLOT_EVERY: u32 = 10;

/// What is known of one robot.
#[derive(Debug)]
pub(crate) struct Watched {
    pub(crate) arm: &'static dyn Arm,
    node: NodeId,
    t_world_base: Pose,
    t_flange_tool: Pose,
    /// The share of the motors' hard velocity limits in force.
    velocity_factor: f64,
    pub(crate) segment: Segment,
    share: f64,
    /// The streamed paths so far; the last may be under way.
    pub(crate) paths: Vec<Following>,
    servo: ServoLaw,
    /// The last two demands, newest first.
    setpoint: Option<PerAxis<f64>>,
    setpoint_before: Option<PerAxis<f64>>,
    /// The motor angles at the SYNC before.
    motors_before: Vec<f64>,
    /// The true motor angles where the node counts from, rad; known once it is homed.
    origin_rad: Option<Vec<f64>>,
    pub(crate) feedback: Option<Feedback>,
    pub(crate) following_error_rad: Vec<f64>,
    pub(crate) setpoint_error_m: Option<f64>,
    pub(crate) actual_error_m: Option<f64>,
    plot: Option<RobotPlot>,
    since_plot: u32,
}

impl Watched {
    pub(crate) fn new(image: &host::mp::robot::Image, plot: bool) -> Self {
        let (config, arm) = (image.config(), image.arm());
        let axes = arm.axes().iter();
        Self {
            arm,
            servo: config.servo,
            node: config.node,
            t_world_base: config.t_world_base,
            t_flange_tool: config.t_flange_tool,
            velocity_factor: config.velocity_factor.value(),
            segment: Segment::None,
            share: 0.0,
            paths: Vec::new(),
            setpoint: None,
            setpoint_before: None,
            motors_before: Vec::new(),
            origin_rad: None,
            feedback: None,
            following_error_rad: vec![0.0; arm.axes().len()],
            setpoint_error_m: None,
            actual_error_m: None,
            plot: plot.then(|| RobotPlot {
                name: config.name.clone(),
                axes: axes
                    .map(|axis| AxisPlot {
                        name: match axis.kind {
                            robots::JointKind::Prismatic => format!("{} [m]", axis.name),
                            robots::JointKind::Revolute => axis.name.to_owned(),
                        },
                        ..AxisPlot::default()
                    })
                    .collect(),
                ..RobotPlot::default()
            }),
            since_plot: 0,
        }
    }

    fn homed(&self) -> bool {
        let all = (1_u16 << self.arm.axes().len()) - 1;
        self.feedback
            .as_ref()
            .is_some_and(|f| u16::from(f.synchronised) & all == all)
    }

    /// The true motor angles as the node counts them, once homed. An axis that was homed in place
    /// counts from wherever it stood; the others from where the machine has its zero.
    fn counted(&mut self, motor_rad: &[f64]) -> Vec<f64> {
        let axes = self.arm.axes();
        if self.origin_rad.is_none()
            && self.homed()
            && let Some(feedback) = &self.feedback
            && let Some(actual) = motor_angles(axes, &feedback.actual)
        {
            let each = axes.iter().zip(motor_rad).zip(actual);
            let origin = each.map(|((axis, motor), actual)| match axis.homing {
                AxisHoming::InPlace => motor - actual,
                AxisHoming::Switch { .. } | AxisHoming::Absolute => 0.0,
            });
            self.origin_rad = Some(origin.collect());
        }
        match &self.origin_rad {
            Some(origin) => motor_rad.iter().zip(origin).map(|(m, o)| m - o).collect(),
            None => motor_rad.to_vec(),
        }
    }

    fn tool(&self, joints: &[f64]) -> Option<Pose> {
        Some(self.arm.forward(joints).ok()? * self.t_flange_tool)
    }

    /// Distance of the tool, at these motor angles, from the way of the present segment, m.
    fn deviation(&mut self, motors: &[f64]) -> Option<f64> {
        let joints = self.arm.joints(motors).ok()?;
        match &self.segment {
            Segment::None | Segment::Homing => None,
            Segment::Joints { from, to } => {
                let nearest = project(from, to, &joints);
                let (a, b) = (self.tool(&joints)?, self.tool(&nearest)?);
                Some(distance(&a.position, &b.position))
            }
            Segment::Motors { from, to } => {
                let nearest = self.arm.joints(&project(from, to, motors)).ok()?;
                let (a, b) = (self.tool(&joints)?, self.tool(&nearest)?);
                Some(distance(&a.position, &b.position))
            }
            Segment::Line { from, to } => {
                let at = self.tool(&joints)?.position;
                let (from, to) = (from.position, to.position);
                let way = to - from;
                let square = way.dot(&way);
                let s = if square > 0.0 {
                    within_unit((at - from).dot(&way) / square)
                } else {
                    0.0
                };
                Some(distance(&at, &(from + way * s)))
            }
            Segment::Path(Followed(streamed)) => {
                let tool = self.tool(&joints)?;
                let (s, least) = streamed.course.nearest(&tool, self.share, PATH_REACH_M)?;
                self.share = s;
                Some(least)
            }
            Segment::Carry { start, tight } => {
                let at = (self.t_world_base * self.tool(&joints)?).position;
                let off = |s: f64| distance(&at, &(tight.displacement(s) * *start).position);
                let (share, least) = nearest_share(off, self.share);
                self.share = share;
                Some(least)
            }
        }
    }

    /// The distance, where it is one from a streamed path.
    fn on_path(&self, deviation: Option<f64>) -> Option<f64> {
        deviation.filter(|_| matches!(self.segment, Segment::Path(_)))
    }

    /// A set-point on a streamed path.
    fn follow(&mut self, at: Micros, step: u32, setpoint: &[f64], deviation: Option<f64>) {
        if !matches!(self.segment, Segment::Path(_)) {
            return;
        }
        let tool = self.arm.joints(setpoint).ok();
        let Some(tool) = tool.and_then(|joints| self.tool(&joints)) else {
            return;
        };
        let step_s = f64::from(self.arm.servo_step_us()) * 1e-6;
        if let Some(path) = self.paths.last_mut() {
            path.setpoint(at, step, step_s, &tool.position, deviation);
        }
    }

    /// A demand and the angles that belong to it, at SYNC n with angles `motors`: the latest demand
    /// is of cycle n − 1. In csp the drive latches it at this SYNC and attains it at the next, so
    /// these angles belong to the one before; in cst it was compared with the angles of SYNC n − 1.
    fn pair(&self, motors: &[f64]) -> Option<(PerAxis<f64>, PerAxis<f64>)> {
        let (demand, angles) = match self.servo {
            ServoLaw::DrivePosition => (&self.setpoint_before, motors),
            ServoLaw::Original | ServoLaw::FeedForward | ServoLaw::ComputedTorque => {
                (&self.setpoint, &*self.motors_before)
            }
        };
        let angles: PerAxis<f64> = angles.iter().copied().collect();
        Some((demand.clone()?, angles)).filter(|(demand, angles)| demand.len() == angles.len())
    }

    fn sample_plot(&mut self, at: Micros, motors: &[f64]) {
        if !self.homed() || self.plot.is_none() {
            return;
        }
        self.since_plot += 1;
        if self.since_plot < PLOT_EVERY {
            return;
        }
        self.since_plot = 0;
        let Some((setpoint, motors)) = self.pair(motors) else {
            return;
        };
        let (Ok(actual), Ok(wanted)) = (self.arm.joints(&motors), self.arm.joints(&setpoint))
        else {
            return;
        };
        let (Some(tool), Some(wanted_tool)) = (self.tool(&actual), self.tool(&wanted)) else {
            return;
        };
        let Some(plot) = &mut self.plot else { return };
        plot.time_s.push(at.as_secs_f64());
        for (k, axis) in plot.axes.iter_mut().enumerate() {
            let at = |values: &[f64]| values.get(k).copied().unwrap_or(f64::NAN);
            axis.setpoint.push(at(&wanted));
            axis.actual.push(at(&actual));
            axis.following_error_rad.push(at(&setpoint) - at(&motors));
        }
        plot.tool_setpoint_m.push(wanted_tool.position.into());
        plot.tool_actual_m.push(tool.position.into());
    }
}

/// The nearest point of the straight line between two points, in any number of dimensions.
fn project(from: &[f64], to: &[f64], at: &[f64]) -> PerAxis<f64> {
    let (mut along, mut square) = (0.0, 0.0);
    for ((a, b), q) in from.iter().zip(to).zip(at) {
        along += (q - a) * (b - a);
        square += (b - a) * (b - a);
    }
    let s = if square > 0.0 {
        within_unit(along / square)
    } else {
        0.0
    };
    from.iter().zip(to).map(|(a, b)| a + s * (b - a)).collect()
}

fn within_unit(s: f64) -> f64 {
    s.clamp(0.0, 1.0)
}

fn distance(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    let d = a - b;
    libm::sqrt(d.dot(&d))
}

/// The share of the way at which a distance is least, looked for near the last one.
fn nearest_share(off: impl Fn(f64) -> f64, last: f64) -> (f64, f64) {
    const REACH: f64 = 0.05;
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    const ROUNDS: u32 = 40;
    let (mut a, mut b) = (within_unit(last - REACH), within_unit(last + REACH));
    for _ in 0..ROUNDS {
        let (c, d) = (b - GOLDEN * (b - a), a + GOLDEN * (b - a));
        if off(c) < off(d) {
            b = d;
        } else {
            a = c;
        }
    }
    let s = 0.5 * (a + b);
    (s, off(s))
}

fn raise(worst: &mut Option<f64>, value: Option<f64>) {
    if let Some(value) = value
        && worst.is_none_or(|worst| value > worst)
    {
        *worst = Some(value);
    }
}

/// Everything that looks on.
pub(crate) struct Observers {
    link: Endpoint<64>,
    pub(crate) robots: Vec<Watched>,
    /// The board that is engraved, if the mechanics are simulated.
    pub(crate) engraving: Option<Engraving>,
    recorder: Option<Recorder>,
}

impl Observers {
    /// Observers of these robots; `plot` keeps samples to draw.
    pub(crate) fn new(
        images: &[host::mp::robot::Image],
        recorder: Option<Recorder>,
        plot: bool,
    ) -> Self {
        Self {
            link: Endpoint::new(NodeId::MP, Role::Observer, Mtu::Fd),
            robots: images
                .iter()
                .map(|image| Watched::new(image, plot))
                .collect(),
            engraving: None,
            recorder,
        }
    }

    /// Cuts the board of the cell, if there is one.
    pub(crate) fn watch_board(&mut self, cell: &Cell) -> Result<(), Error> {
        self.engraving = cell.board.as_ref().map(Engraving::new).transpose()?;
        Ok(())
    }

    /// What a robot executes from now on.
    pub(crate) fn set_segment(&mut self, robot: usize, segment: &Segment) {
        if let Some(watched) = self.robots.get_mut(robot)
            && watched.segment != *segment
        {
            watched.segment = segment.clone();
            watched.share = 0.0;
            if let Segment::Path(Followed(streamed)) = segment {
                if let Some(engraving) = &mut self.engraving {
                    engraving.programmed(robot, streamed);
                }
                watched.paths.push(Following::new(streamed.clone()));
            }
        }
    }

    /// A frame of the MP's bus.
    pub(crate) fn mp_frame(&mut self, at: Micros, frame: &Frame) {
        let Some(incoming) = self.link.receive(frame, at) else {
            return;
        };
        let from = incoming.from;
        let found = self.robots.iter_mut().enumerate();
        let Some((robot, watched)) = found.into_iter().find(|(_, w)| w.node == from) else {
            return;
        };
        match incoming.message {
            Message::DemandTrace(trace) => {
                let axes = watched.arm.axes();
                watched.setpoint_before = watched.setpoint.take();
                watched.setpoint = motor_angles(axes, &trace.demand);
                if watched.homed()
                    && let Some(setpoint) = watched.setpoint.clone()
                {
                    let deviation = watched.deviation(&setpoint);
                    raise(&mut watched.setpoint_error_m, deviation);
                    watched.follow(at, trace.step, &setpoint, deviation);
                    if let Some(engraving) = &mut self.engraving {
                        engraving.setpoint(robot, watched.on_path(deviation));
                    }
                }
            }
            Message::Feedback(feedback) => {
                let axes = watched.arm.axes();
                let errors = watched.following_error_rad.iter_mut();
                for ((worst, units), axis) in errors.zip(&feedback.following_error).zip(axes) {
                    let error = f64::from(*units) * unit_rad(axis);
                    if error > *worst {
                        *worst = error;
                    }
                }
                if let Some(recorder) = &mut self.recorder
                    && let Some(motors) = motor_angles(axes, &feedback.actual)
                    && let Ok(joints) = watched.arm.joints(&motors)
                {
                    recorder.joints(robot, at, joints.to_vec());
                }
                watched.feedback = Some(feedback);
            }
            _ => {}
        }
    }

    /// A frame of a bus, for the record.
    pub(crate) fn record(&mut self, bus: usize, at_ns: u64, frame: &Frame) {
        if let Some(recorder) = &mut self.recorder {
            recorder.frame(bus, at_ns, frame);
        }
    }

    /// A step of the Master Process, for the record.
    pub(crate) fn master_steps(&mut self, now: Micros, step: MasterStep) {
        if let Some(recorder) = &mut self.recorder {
            recorder.step(now, step);
        }
    }

    /// Time has passed on every bus.
    pub(crate) fn passed(&mut self) {
        if let Some(recorder) = &mut self.recorder {
            recorder.passed();
        }
    }

    /// Finish the record.
    pub(crate) fn close(&mut self) -> Result<(), Error> {
        self.recorder.take().map_or(Ok(()), Recorder::close)
    }

    /// What can be drawn.
    pub(crate) fn plot(&mut self, title: String, steps: Vec<StepMark>) -> PlotData {
        let robots = self
            .robots
            .iter_mut()
            .filter_map(|w| w.plot.take())
            .collect();
        PlotData {
            title,
            robots,
            steps,
        }
    }
}

impl Observer for Observers {
    fn frame(&mut self, bus: usize, at_ns: u64, frame: &Frame) {
        self.record(bus, at_ns, frame);
        if bus == 0 {
            self.mp_frame(Micros(at_ns / 1000), frame);
        }
    }

    fn outputs(&mut self, station: usize, _: u64, levels: u16) {
        if let Some(engraving) = &mut self.engraving {
            engraving.outputs(station, levels);
        }
    }

    fn motors(&mut self, station: usize, at_ns: u64, motor_rad: &[f64]) {
        let Some(watched) = self.robots.get_mut(station) else {
            return;
        };
        let moving = watched.feedback.as_ref().is_some_and(|f| {
            matches!(
                f.state,
                NodeState::Moving | NodeState::Holding | NodeState::Stopping
            )
        });
        let motors = watched.counted(motor_rad);
        if moving && watched.homed() {
            let deviation = watched.deviation(&motors);
            raise(&mut watched.actual_error_m, deviation);
            if let Some(engraving) = &mut self.engraving {
                let deviation = watched.on_path(deviation);
                engraving.mechanics(station, watched, &motors, deviation);
            }
        }
        watched.sample_plot(Micros(at_ns / 1000), &motors);
        watched.motors_before = motors;
    }
}
