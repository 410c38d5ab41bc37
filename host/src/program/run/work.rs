//! The work of one step: as a job of the Master Process, and what is told of it.

use super::{NEXT_NODE, Phase, Run, RunError};
use crate::mp::Job;
use crate::mp::behaviour::{self, sequence};
use crate::mp::failure::Failure;
use crate::mp::generator::{AsPlanned, Carried, Carry, Course, Stream, Together};
use crate::mp::subsystem::BoxedBehaviour;
use crate::mp::watch::Watch;
use crate::path::Streamed;
use crate::program::plan::SAME_RAD;
use crate::program::plan::{Motion, Work};
use crate::program::progress::{Followed, Progress, Segment};
use crate::task::{PathStep, Tight};
use agent::Move;
use protocol::message::{Decision, OUTPUT_SPINDLE, StopKind};
use protocol::time::Micros;
use protocol::units::PerAxis;
use std::sync::Arc;

/// A tool goes no farther than this between two macrosteps, m: 5 m/s, the fastest a task can ask for.
const PATH_REACH_M: f64 = 0.1;

/// So much of a tenth of a path is not waited for: at its end units of the drives are missing.
const NEARLY: f64 = 1e-3;

impl Run {
    /// Notes which motions every robot gets in this step, in their order.
    pub(super) fn give(&mut self, work: &Work) {
        for ((issued, motions), image) in self.given.iter_mut().zip(self.mp.robots()) {
            *issued = image.issued();
            motions.clear();
        }
        self.told.iter_mut().for_each(|told| *told = 0);
        let lists = match work {
            Work::Groups(lists) | Work::Streams(lists) => lists,
            Work::Home(_)
            | Work::Wait(_)
            | Work::Carry { .. }
            | Work::Path { .. }
            | Work::Servo(..)
            | Work::Spindle(..) => return,
        };
        for motion in lists.iter().flatten() {
            if let Some((_, motions)) = self.given.get_mut(motion.robot) {
                motions.push(motion.clone());
            }
        }
    }

    pub(super) fn begin_work(&mut self, now: Micros, name: &str, work: &Work) {
        let (grid, timing, i) = (self.mp.grid(), self.mp.config().timing, self.mp.instant());
        let (behaviour, robots): (BoxedBehaviour, Vec<usize>) = match work {
            Work::Home(robots) => {
                self.show_homing(robots);
                (behaviour::home(robots.clone(), timing), robots.clone())
            }
            Work::Groups(groups) => {
                let group = groups.get(self.group).cloned().unwrap_or_default();
                let robots = group.iter().map(|motion| motion.robot).collect();
                let items = group
                    .into_iter()
                    .map(|m| (m.robot, m.instruction))
                    .collect();
                let mut together = Together::new(items, grid, timing.start_lead_steps);
                if groups.len() > 1 {
                    let variant = i32::try_from(self.group + 1).unwrap_or(i32::MAX);
                    together = together.deciding(Decision {
                        label: NEXT_NODE,
                        variant,
                    });
                }
                (Box::new(Move::new(together)), robots)
            }
            Work::Streams(streams) => {
                let start = i.saturating_add(timing.start_lead_steps + 1);
                let together = streams.len() > 1;
                let one = |stream: &Vec<Motion>| {
                    let nodes = stream.iter().enumerate().map(|(k, motion)| {
                        let item = vec![(motion.robot, motion.instruction.clone())];
                        let node = Together::new(item, grid, timing.start_lead_steps);
                        let node = if k == 0 && together {
                            node.starting_at(start)
                        } else {
                            node
                        };
                        Box::new(Move::new(node)) as BoxedBehaviour
                    });
                    sequence(nodes.collect())
                };
                let robots = streams
                    .iter()
                    .filter_map(|s| Some(s.first()?.robot))
                    .collect();
                (
                    behaviour::in_parallel(streams.iter().map(one).collect()),
                    robots,
                )
            }
            Work::Wait(seconds) => {
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a task waits at most an hour; the conversion saturates"
                )]
                let steps = libm::ceil(seconds / grid.macrostep_s()) as u32;
                let until = i.saturating_add(steps).saturating_add(1);
                // whoever has a lease is watched while nothing moves
                let robots = (0..self.mp.robots().len()).collect();
                (behaviour::wait_until(until), robots)
            }
            Work::Path { step, streamed } => (self.stream(step, streamed), vec![step.robot]),
            Work::Spindle(robot, on) => {
                let levels = if *on { OUTPUT_SPINDLE } else { 0 };
                let switch = behaviour::outputs(*robot, OUTPUT_SPINDLE, levels);
                (switch, vec![*robot])
            }
            Work::Servo(robot, law) => (behaviour::select_servo(*robot, *law), vec![*robot]),
            Work::Carry { tight, start } => match self.carry(tight, start) {
                Ok(carry) => (behaviour::carry(carry, grid), tight.robots.clone()),
                Err(failure) => {
                    let step = self.step_name();
                    self.fail(now, RunError::Failure { step, failure });
                    return;
                }
            },
        };
        let watch = Watch::work(robots, timing.silence_ms);
        self.mp.begin(Job::new(name, behaviour, watch));
    }

    fn show_homing(&mut self, robots: &[usize]) {
        for robot in robots {
            let image = self.mp.robots().get(*robot);
            if image.is_some_and(|image| !image.is_homed()) {
                self.set_segment(*robot, Segment::Homing);
            }
        }
    }

    /// A path as planned.
    fn stream(&self, step: &PathStep, streamed: &Arc<Streamed>) -> BoxedBehaviour {
        let macrostep_s = self.mp.grid().macrostep_s();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "at most an hour in macrosteps, and a share from -1 to 1"
        )]
        let overrides = step.overrides.iter().map(|(time, share)| {
            let steps = libm::ceil(time / macrostep_s) as u32;
            (steps, *share as f32)
        });
        let overrides = overrides.collect();
        let elements = streamed.elements.clone();
        let stream = Stream::new(step.robot, step.speeds, elements);
        behaviour::stream(stream.overriding(overrides))
    }

    /// A carry from where the set-points are.
    fn carry(
        &mut self,
        tight: &Tight,
        start: &[PerAxis<f64>],
    ) -> Result<Carry<AsPlanned>, Failure> {
        let mut carried = Vec::new();
        for robot in &tight.robots {
            let Some(image) = self.mp.robots().get(*robot) else {
                continue;
            };
            let failed = |error| Failure::Kinematics {
                who: image.who(),
                at: "the beginning".to_owned(),
                error,
            };
            let motors = image.demanded_motors().ok_or(Failure::Lost {
                who: image.who(),
                span_ms: 0,
            })?;
            let joints = image.arm().joints(&motors).map_err(failed)?;
            carried.push(Carried::new(*robot, image.config(), joints).map_err(failed)?);
        }
        for one in &carried {
            let segment = Segment::Carry {
                start: *one.start(),
                tight: tight.clone(),
            };
            self.set_segment(one.robot, segment);
        }
        let who = carried.first().map(|one| one.who.clone());
        let course = Course::new(tight.clone(), carried).map_err(|error| match who {
            Some(who) => Failure::Kinematics {
                who,
                at: "the timing".to_owned(),
                error,
            },
            None => Failure::Stopped {
                kind: StopKind::Path,
            },
        })?;
        let (grid, timing) = (self.mp.grid(), self.mp.config().timing);
        let as_planned = course.robots().iter().zip(start).all(|(carried, start)| {
            carried
                .joints()
                .iter()
                .zip(start)
                .all(|(a, b)| (a - b).abs() < SAME_RAD)
        });
        if as_planned {
            Ok(Carry::checked(course, AsPlanned, grid, &timing))
        } else {
            Carry::new(course, AsPlanned, grid, &timing)
        }
    }

    /// How far robots have come on their paths.
    pub(super) fn watch_paths(&mut self) {
        self.find_path();
        for (robot, segment) in self.segments.iter().enumerate() {
            let Segment::Path(Followed(streamed)) = segment else {
                continue;
            };
            let (Some(image), Some((s, tenths))) =
                (self.mp.robots().get(robot), self.on_path.get_mut(robot))
            else {
                continue;
            };
            let tool = image.demanded_joints().and_then(|joints| {
                Some(image.arm().forward(&joints).ok()? * image.config().t_flange_tool)
            });
            let course = &streamed.course;
            let Some((now, _)) = tool.and_then(|tool| course.nearest(&tool, *s, PATH_REACH_M))
            else {
                continue;
            };
            *s = now;
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "from 0 to 10"
            )]
            let done = libm::floor(10.0 * now / course.end() + NEARLY) as u32;
            if done > *tenths {
                *tenths = done;
                self.progress.push(Progress::Path {
                    robot,
                    tenths: done,
                    length_m: course.length_m(),
                });
            }
        }
    }

    /// The segment of a path begins when its instruction runs: before, the last set-points of the
    /// motion before it are still on their way.
    fn find_path(&mut self) {
        let (Phase::Step(index), Some(plan)) = (&self.phase, &self.plan) else {
            return;
        };
        let Some(Work::Path { step, streamed }) = plan.steps.get(*index).map(|s| &s.work) else {
            return;
        };
        let (robot, segment) = (step.robot, Segment::Path(Followed(streamed.clone())));
        let runs =
            self.mp.robots().get(robot).is_some_and(|image| {
                image.progress() == Some(protocol::message::Progress::Running)
            });
        if runs {
            self.set_segment(robot, segment);
        }
    }

    /// Which node every robot was sent to last.
    pub(super) fn watch_nodes(&mut self) {
        let Phase::Step(index) = self.phase else {
            return;
        };
        for robot in 0..self.given.len() {
            let Some(image) = self.mp.robots().get(robot) else {
                continue;
            };
            let Some((before, motions)) = self.given.get(robot) else {
                continue;
            };
            let node = usize::try_from(image.issued().saturating_sub(*before)).unwrap_or(0);
            let of = motions.len();
            let Some(motion) = node.checked_sub(1).and_then(|k| motions.get(k)) else {
                continue;
            };
            let segment = motion.segment.clone();
            if let Some(told) = self.told.get_mut(robot)
                && *told != node
            {
                *told = node;
                self.progress.push(Progress::Node {
                    step: index + 1,
                    robot,
                    node,
                    of,
                });
                self.set_segment(robot, segment);
            }
        }
    }
}
