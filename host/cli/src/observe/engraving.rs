//! A board that the simulated mechanics cut: what is left of it, and how near to the path it was done.

use super::Watched;
use hil_sim::workpiece::{Board, CELL_M, Cutter as Cutting, Shank, Tool};
use host::error::Error;
use host::path::Streamed;
use host::plot::{BoardPicture, PathError, Picture, ProgrammedLine};
use host::summary::EngravingSummary;
use host::task::{Board as Spec, Cutter};
use motion::Pose;
use protocol::message::OUTPUT_SPINDLE;

/// A programmed line is drawn by points this far apart, m, and errors are noted as often.
const DRAWN_M: f64 = 2.5e-4;
/// Above the board's surface by more than this the tool does not cut, m.
const TOUCH_M: f64 = 1e-6;
/// ASSUMED of the cutters: their edges and how far they stick out, m.
const CUTTING_LENGTH_M: f64 = 0.02;
const STICK_OUT_M: f64 = 0.04;
/// ASSUMED: the shank of an engraving cutter and the collet that holds it, m.
const SHANK_M: f64 = 6e-3;
const HOLDER_M: f64 = 0.04;

/// A board being engraved.
#[derive(Debug)]
pub(crate) struct Engraving {
    robot: usize,
    t_board_base: Pose,
    board: Board,
    tool: Tool,
    spins: bool,
    /// The pose at the SYNC before, in the frame of the board.
    before: Option<Pose>,
    summary: EngravingSummary,
    lines: Vec<ProgrammedLine>,
    errors: Vec<PathError>,
    /// Since the last error was noted: the way, m, and the greatest error on it.
    since: (f64, f64),
    motors_before: Vec<f64>,
}

impl Engraving {
    /// An uncut board, and its cutter.
    pub(crate) fn new(spec: &Spec) -> Result<Self, Error> {
        let wrong = |error: &dyn ToString| Error::Usage {
            what: "the board of the cell".into(),
            expected: "one that can be cut, and a cutter for it".into(),
            got: error.to_string(),
        };
        let (cutter, shank) = match spec.cutter {
            Cutter::Flat(diameter_m) => (Cutting::Flat { diameter_m }, diameter_m),
            Cutter::Ball(diameter_m) => (Cutting::Ball { diameter_m }, diameter_m),
            Cutter::V { tip_m, angle_rad } => (Cutting::V { tip_m, angle_rad }, SHANK_M),
        };
        let shank = Shank {
            cutting_length_m: CUTTING_LENGTH_M,
            diameter_m: shank,
            stick_out_m: STICK_OUT_M,
            holder_diameter_m: HOLDER_M,
        };
        Ok(Self {
            robot: spec.robot,
            t_board_base: spec.t_base_board.inverse(),
            board: Board::new(spec.size_m, spec.thickness_m, CELL_M).map_err(|e| wrong(&e))?,
            tool: Tool::new(cutter, shank).map_err(|e| wrong(&e))?,
            spins: false,
            before: None,
            summary: EngravingSummary {
                joint_margin: (1.0, 0),
                ..EngravingSummary::default()
            },
            lines: Vec::new(),
            errors: Vec::new(),
            since: (0.0, 0.0),
            motors_before: Vec::new(),
        })
    }

    /// A path that a robot is about to follow.
    pub(crate) fn programmed(&mut self, robot: usize, streamed: &Streamed) {
        if robot != self.robot {
            return;
        }
        let mut line: Option<ProgrammedLine> = None;
        for s in streamed.course.samples(DRAWN_M) {
            let Some(point) = streamed.course.at(s) else {
                continue;
            };
            let at = (self.t_board_base * point.pose).position;
            let cutting = at.z < -TOUCH_M;
            let to = [at.x, at.y];
            match &mut line {
                Some(line) if line.cutting == cutting => line.points_m.push(to),
                _ => {
                    let from = line.as_ref().and_then(|line| line.points_m.last().copied());
                    let points_m = from.into_iter().chain([to]).collect();
                    self.lines
                        .extend(line.replace(ProgrammedLine { points_m, cutting }));
                }
            }
        }
        self.lines.extend(line);
    }

    /// The outputs at a robot's tool.
    pub(crate) fn outputs(&mut self, robot: usize, levels: u16) {
        if robot == self.robot {
            self.spins = levels & OUTPUT_SPINDLE != 0;
        }
    }

    /// A set-point on a path, so far from it.
    pub(crate) fn setpoint(&mut self, robot: usize, deviation: Option<f64>) {
        if let Some(deviation) = deviation.filter(|_| robot == self.robot) {
            self.summary.setpoints.add(deviation);
        }
    }

    /// The mechanics at a SYNC.
    pub(super) fn mechanics(
        &mut self,
        robot: usize,
        watched: &Watched,
        motors: &[f64],
        deviation: Option<f64>,
    ) {
        if robot != self.robot {
            return;
        }
        let Ok(joints) = watched.arm.joints(motors) else {
            return;
        };
        let Some(tool) = watched.tool(&joints) else {
            return;
        };
        let step_s = f64::from(watched.arm.servo_step_us()) * 1e-6;
        if deviation.is_some() {
            self.margins(watched, &joints, motors, step_s);
        }
        self.motors_before.clear();
        self.motors_before.extend_from_slice(motors);
        let now = self.t_board_base * tool;
        let Some(before) = self.before.replace(now) else {
            return;
        };
        let Ok(cut) = self.board.cut(&self.tool, &before, &now) else {
            return;
        };
        if let Some(error) = deviation {
            self.summary.mechanics.add(error);
        }
        self.summary.collisions += u64::from(cut.collision.or(cut.through).is_some());
        if cut.depth_m <= TOUCH_M {
            self.since = (0.0, 0.0);
            if self
                .errors
                .last()
                .is_some_and(|last| last.error_m.is_finite())
            {
                // the line of errors ends here
                self.errors.push(PathError {
                    at_m: [now.position.x, now.position.y],
                    error_m: f64::NAN,
                });
            }
            return;
        }
        let summary = &mut self.summary;
        summary.stalled += u64::from(!self.spins);
        if cut.depth_m > summary.depth_m {
            summary.depth_m = cut.depth_m;
        }
        let way = (now.position - before.position).norm();
        summary.cut_m += way;
        summary.cut_s += step_s;
        if way / step_s > summary.feed_max_m_s {
            summary.feed_max_m_s = way / step_s;
        }
        let (gone, worst) = &mut self.since;
        *gone += way;
        if let Some(error) = deviation.filter(|error| *error > *worst) {
            *worst = error;
        }
        if *gone >= DRAWN_M {
            self.errors.push(PathError {
                at_m: [now.position.x, now.position.y],
                error_m: *worst,
            });
            self.since = (0.0, 0.0);
        }
    }

    fn margins(&mut self, watched: &Watched, joints: &[f64], motors: &[f64], step_s: f64) {
        let axes = watched.arm.axes();
        for ((axis, q), number) in axes.iter().zip(joints).zip(1..) {
            let range = axis.joint_position;
            let half = 0.5 * (range.upper - range.lower);
            let margin = (half - (q - range.centre()).abs()) / half;
            if margin < self.summary.joint_margin.0 {
                self.summary.joint_margin = (margin, number);
            }
        }
        let each = axes.iter().zip(motors).zip(&self.motors_before).zip(1..);
        for (((axis, now), before), number) in each {
            let limit = axis.hard_limits.velocity * watched.velocity_factor;
            let share = (now - before).abs() / (step_s * limit);
            if share > self.summary.motor_velocity_share.0 {
                self.summary.motor_velocity_share = (share, number);
            }
        }
    }

    /// What has become of the board.
    pub(crate) fn summary(&self) -> EngravingSummary {
        EngravingSummary {
            removed_m3: self.board.removed_m3(),
            digest: format!("{:016x}", self.board.digest()),
            ..self.summary.clone()
        }
    }

    /// The board, the path, and how near to it the mechanics were.
    pub(crate) fn picture(&self, title: &str) -> Picture {
        let s = self.summary();
        let summary = vec![
            format!(
                "{:.2} m in the wood in {:.0} s, at most {:.0} mm/s  ·  {:.2} cm³ removed, {:.2} mm deep",
                s.cut_m,
                s.cut_s,
                1e3 * s.feed_max_m_s,
                1e6 * s.removed_m3,
                1e3 * s.depth_m
            ),
            format!(
                "path error: set-points at most {:.3} µm, mechanics at most {:.1} µm, rms {:.1} µm",
                1e6 * s.setpoints.max_m,
                1e6 * s.mechanics.max_m,
                1e6 * s.mechanics.rms_m
            ),
        ];
        Picture::from(&BoardPicture {
            title: title.to_owned(),
            summary,
            size_m: self.board.size_m(),
            heights_m: self.board.heights(),
            columns: self.board.columns(),
            programmed: &self.lines,
            errors: &self.errors,
        })
    }
}
