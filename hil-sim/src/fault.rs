//! Faults somebody asks for: what, where and when, as text and as data.
//!
//! `ROBOT/AXIS:FAULT@SECONDS` is a fault of a drive or its receptors, axes numbered from 1 as on every command line;
//! `ROBOT/force:FAULT@SECONDS` one of the force sensor in the wrist;
//! `ROBOT.BUS:FAULT@SECONDS` one of a drive bus, numbered from 0 as the hub's channels are. Seconds are those the
//! simulation has run. `none` for a fault mends what was broken.

use crate::drive::DriveFault;
use crate::plant::force_sensor::ForceFault;
use bus::wire::BusFault;
use core::fmt;
use core::str::FromStr;

/// The text for who is to say what can be asked for.
pub const EXPECTED: &str = "ROBOT/AXIS:FAULT@SECONDS with silent, trip, frozen, jumping, reversed, drifting, garbage, \
     switch-on, switch-off, no-index, blank or none, ROBOT/force:FAULT@SECONDS with silent, saturated, over-force, failed, \
     frozen, repeating, torn or none, or ROBOT.BUS:FAULT@SECONDS with stuck-dominant, short, cut:TAP, \
     wrecked:TAP or none";

/// What breaks, in a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Broken {
    /// A drive, or a receptor of its axis, from 0; or nothing there any more.
    Axis(usize, Option<DriveFault>),
    /// The force sensor in the wrist; or nothing there any more.
    Force(Option<ForceFault>),
    /// One of the robot's drive buses, from 0; or nothing there any more.
    Bus(u8, Option<BusFault>),
}

/// A fault that is asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FaultSpec {
    /// The robot.
    pub robot: String,
    /// What breaks.
    pub broken: Broken,
    /// When, ns since the simulation began.
    pub at_ns: u64,
}

/// A text that asks for no fault.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FaultSpecError {
    /// It is not of the form.
    #[error("no fault is asked for by {0:?} (expected {EXPECTED})")]
    Form(String),
    /// The fault has no such name.
    #[error("no such fault: {0:?} (expected {EXPECTED})")]
    Name(String),
    /// The instant is none.
    #[error(
        "not an instant: {0:?} (expected seconds from 0 to 1e6 behind the @, as in frozen@12.5)"
    )]
    Instant(String),
}

/// The latest instant, s.
const LATEST_S: f64 = 1e6;
/// The place of a force sensor.
const FORCE: &str = "force";
/// What mends.
const NONE: &str = "none";

impl FromStr for FaultSpec {
    type Err = FaultSpecError;

    fn from_str(text: &str) -> Result<Self, FaultSpecError> {
        let form = || FaultSpecError::Form(text.to_owned());
        let (what, at) = text.rsplit_once('@').ok_or_else(form)?;
        let (place, fault) = what.split_once(':').ok_or_else(form)?;
        let name = || FaultSpecError::Name(fault.to_owned());
        let (robot, broken) = if let Some((robot, FORCE)) = place.rsplit_once('/') {
            let fault = match fault {
                NONE => None,
                _ => Some(ForceFault::from_name(fault).ok_or_else(name)?),
            };
            (robot, Broken::Force(fault))
        } else if let Some((robot, axis)) = place.rsplit_once('/') {
            let axis = axis.parse::<usize>().ok().and_then(|k| k.checked_sub(1));
            let fault = match fault {
                NONE => None,
                _ => Some(DriveFault::from_name(fault).ok_or_else(name)?),
            };
            (robot, Broken::Axis(axis.ok_or_else(form)?, fault))
        } else {
            let (robot, bus) = place.rsplit_once('.').ok_or_else(form)?;
            let fault = match fault {
                NONE => None,
                _ => Some(fault.parse().map_err(|_| name())?),
            };
            (robot, Broken::Bus(bus.parse().map_err(|_| form())?, fault))
        };
        if robot.is_empty() {
            return Err(form());
        }
        let seconds = at.parse::<f64>().ok();
        let seconds = seconds.filter(|s| (0.0..=LATEST_S).contains(s));
        let seconds = seconds.ok_or_else(|| FaultSpecError::Instant(at.to_owned()))?;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0 to 1e15"
        )]
        let at_ns = (seconds * 1e9) as u64;
        Ok(Self {
            robot: robot.to_owned(),
            broken,
            at_ns,
        })
    }
}

impl fmt::Display for FaultSpec {
    /// What [`FromStr`] reads.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let robot = &self.robot;
        match self.broken {
            Broken::Axis(axis, fault) => {
                let name = fault.map_or(NONE, DriveFault::name);
                write!(f, "{robot}/{}:{name}", axis + 1)?;
            }
            Broken::Force(fault) => {
                let name = fault.map_or(NONE, ForceFault::name);
                write!(f, "{robot}/{FORCE}:{name}")?;
            }
            Broken::Bus(bus, None) => write!(f, "{robot}.{bus}:{NONE}")?,
            Broken::Bus(bus, Some(fault)) => write!(f, "{robot}.{bus}:{fault}")?,
        }
        #[expect(clippy::cast_precision_loss, reason = "below 2^53")]
        let seconds = self.at_ns as f64 * 1e-9;
        write!(f, "@{seconds}")
    }
}

/// A fault for a robot or a bus that is not there.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{spec}: expected {expected}")]
pub struct Misplaced {
    /// What was asked for.
    pub spec: FaultSpec,
    /// What there is.
    pub expected: String,
}

/// The faults of one or several robots that are still to come, in order of time.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Schedule(Vec<(u64, usize, Broken)>);

/// A robot for which faults can be asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Breakable<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its axes.
    pub axes: usize,
    /// Its drive buses.
    pub buses: u8,
    /// Has it a force sensor?
    pub force: bool,
}

impl Schedule {
    /// The faults that are asked for, in robots that are numbered as they are listed.
    ///
    /// # Errors
    /// [`Misplaced`]: there is no such robot (or several of that name), axis or bus.
    pub fn new(specs: &[FaultSpec], robots: &[Breakable<'_>]) -> Result<Self, Misplaced> {
        let mut all = Vec::with_capacity(specs.len());
        for spec in specs {
            let misplaced = |expected: String| Misplaced {
                spec: spec.clone(),
                expected,
            };
            let named = |robot: &&Breakable<'_>| robot.name == spec.robot;
            let Some(number) = robots.iter().position(|robot| named(&robot)) else {
                let names: Vec<&str> = robots.iter().map(|robot| robot.name).collect();
                return Err(misplaced(format!("a fault of {}", names.join(" or "))));
            };
            if robots.iter().filter(named).count() > 1 {
                return Err(misplaced("a robot that is there once".to_owned()));
            }
            let Some(robot) = robots.get(number) else {
                continue;
            };
            match spec.broken {
                Broken::Axis(axis, _) if axis >= robot.axes => {
                    return Err(misplaced(format!("an axis from 1 to {}", robot.axes)));
                }
                Broken::Bus(bus, _) if bus >= robot.buses => {
                    return Err(misplaced(format!("a bus from 0 to {}", robot.buses - 1)));
                }
                Broken::Force(_) if !robot.force => {
                    return Err(misplaced("a robot with a force sensor on a bus".to_owned()));
                }
                Broken::Axis(..) | Broken::Force(_) | Broken::Bus(..) => {}
            }
            all.push((spec.at_ns, number, spec.broken));
        }
        // the last first; of one instant in the order in which they were asked for
        all.reverse();
        all.sort_by_key(|(at_ns, ..)| core::cmp::Reverse(*at_ns));
        Ok(Self(all))
    }

    /// Those of one robot alone.
    #[must_use]
    pub fn of(&self, robot: usize) -> Self {
        let own = self.0.iter().filter(|(_, number, _)| *number == robot);
        Self(own.copied().collect())
    }

    /// When the next one is due, ns.
    #[must_use]
    pub fn next_ns(&self) -> Option<u64> {
        self.0.last().map(|(at_ns, ..)| *at_ns)
    }

    /// The next one that is due at `now_ns`, with the number of its robot.
    pub fn take(&mut self, now_ns: u64) -> Option<(usize, Broken)> {
        let due = self.next_ns().is_some_and(|at_ns| at_ns <= now_ns);
        let (_, robot, broken) = if due { self.0.pop() } else { None }?;
        Some((robot, broken))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::axis::EncoderFault;

    const ROBOTS: [Breakable<'_>; 2] = [
        Breakable {
            name: "a.b",
            axes: 6,
            buses: 1,
            force: false,
        },
        Breakable {
            name: "c",
            axes: 7,
            buses: 2,
            force: true,
        },
    ];

    #[test]
    fn a_fault_is_read_as_it_is_written() {
        let names = DriveFault::NAMED.map(|(name, _)| format!("irp6-track/3:{name}@0.25"));
        let buses = [
            "stuck-dominant",
            "short",
            "cut:0",
            "cut:12",
            "wrecked:3",
            "none",
        ];
        let buses = buses.map(|name| format!("a.b.1:{name}@7"));
        let forces = ForceFault::ALL.map(|fault| format!("c/force:{}@1.5", fault.name()));
        for text in names.iter().chain(&buses).chain(&forces) {
            let spec: FaultSpec = text.parse().unwrap();
            assert_eq!(spec.to_string(), *text);
        }
        let spec: FaultSpec = "c/7:frozen@12.5".parse().unwrap();
        let frozen = Some(DriveFault::Encoder(EncoderFault::Frozen));
        assert_eq!(
            (spec.robot.as_str(), spec.broken, spec.at_ns),
            ("c", Broken::Axis(6, frozen), 12_500_000_000)
        );
    }

    #[test]
    fn what_asks_for_no_fault_is_told_in_one_line_with_what_is_expected() {
        for text in [
            "",
            "frozen",
            "c:frozen@1",
            "c/0:frozen@1",
            "c/x:frozen@1",
            "c/1:frozen",
            "c/1@1",
            "/1:frozen@1",
            "c.x:short@1",
            "c.1:short@",
            "c.1:short@-1",
            "c.1:short@nan",
            "c.1:short@inf",
            "c.1:short@1e7",
            "c/1:Frozen@1",
            "c/1:cut:1@1",
            "c.1:frozen@1",
            "c.1:cut@1",
            "c/force:trip@1",
            "/force:frozen@1",
        ] {
            let error = text.parse::<FaultSpec>().unwrap_err().to_string();
            assert!(
                error.contains("expected") && !error.contains('\n'),
                "{text}: {error}"
            );
        }
        let forces = ForceFault::ALL.map(ForceFault::name);
        for name in DriveFault::NAMED
            .iter()
            .map(|(name, _)| name)
            .chain(&forces)
        {
            assert!(EXPECTED.contains(name), "{name}");
        }
    }

    #[test]
    fn a_fault_of_what_is_not_there_says_what_is() {
        for (text, word) in [
            ("d/1:frozen@1", "a.b or c"),
            ("c/8:frozen@1", "1 to 7"),
            ("a.b.1:short@1", "0 to 0"),
            ("a.b/force:failed@1", "with a force sensor"),
        ] {
            let spec = [text.parse().unwrap()];
            let error = Schedule::new(&spec, &ROBOTS).unwrap_err().to_string();
            assert!(error.contains(word) && error.contains(text), "{error}");
        }
        let twice = [ROBOTS[1], ROBOTS[1]];
        let spec = ["c/1:frozen@1".parse().unwrap()];
        assert!(Schedule::new(&spec, &twice).is_err());
    }

    #[test]
    fn faults_come_in_order_of_time_and_those_of_one_instant_as_they_were_asked_for() {
        let specs = ["c/1:frozen@2", "a.b/2:silent@1", "c.0:short@2"].map(|t| t.parse().unwrap());
        let mut schedule = Schedule::new(&specs, &ROBOTS).unwrap();
        assert_eq!(schedule.of(0).next_ns(), Some(1_000_000_000));
        assert_eq!(schedule.of(1).next_ns(), Some(2_000_000_000));
        assert_eq!(schedule.take(999_999_999), None);
        assert_eq!(
            schedule.take(1_000_000_000),
            Some((0, Broken::Axis(1, Some(DriveFault::Silent))))
        );
        assert_eq!(schedule.take(1_999_999_999), None);
        assert!(matches!(
            schedule.take(u64::MAX),
            Some((1, Broken::Axis(..)))
        ));
        assert!(matches!(
            schedule.take(u64::MAX),
            Some((1, Broken::Bus(..)))
        ));
        assert_eq!(schedule.take(u64::MAX), None);
    }
}
