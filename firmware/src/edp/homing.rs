//! Synchronisation (homing): serial, one axis after the other in the robot's order.
//!
//! Each axis: **coarse** towards the home switch → ramp down and **settle** on it → **back off**
//! slowly until it releases → go on to the encoder **index**, whose latched position becomes motor
//! angle 0 → return to 0. Every phase has its own error. Velocities change with limited acceleration
//! and jerk, as in any motion. An axis without a switch does not move: its zero is where it stands, or
//! where its absolute encoder has it.

use motion::profile::{AxisLimits, Profile};
use motion::ramp::{Ramp, RampState};
use protocol::fault::Cause;
use protocol::message::HomingPhase;
use robots::AxisHoming as Way;

/// What homing needs to know of an axis; motor shaft, rad and seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HomingParameters {
    /// How the axis finds its reference.
    pub way: Way,
    /// The farthest the axis may travel looking for its switch, rad.
    pub travel_rad: f64,
    /// Limits for ramps and for the return to zero.
    pub limits: AxisLimits,
}

/// How long the axis stands on the switch before it backs off, s: 250 steps of 2 ms as in MRROC++.
const SETTLE_S: f64 = 0.5;
/// The switch must be seen for so many consecutive samples: MRROC++'s debounce.
const DEBOUNCE: u8 = 3;
/// Backing off so much farther than the way in without release is an error, rad of the motor shaft:
/// two turns.
const RELEASE_TRAVEL_RAD: f64 = 4.0 * core::f64::consts::PI;
/// The index comes once a turn; a quarter is allowed for the ramp.
const INDEX_TRAVEL_RAD: f64 = 2.5 * core::f64::consts::PI;

/// What homing sees of an axis in one servo step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inputs {
    /// Home switch, raw.
    pub switch: bool,
    /// The position latched at the index, once the drive reports it; rad from the same origin as
    /// the set-points.
    pub index_rad: Option<f64>,
    /// Where the drive counts from; rad from the same origin as the set-points.
    pub origin_rad: f64,
}

/// What homing asks of the EDP.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// Nothing special.
    None,
    /// Tell the drive to latch the next index pulse.
    ArmIndex,
    /// The index is at this position: count from there. From now on positions are relative to it.
    SetZero {
        /// Position of the index, rad from the old origin.
        index_rad: f64,
    },
    /// The axis is homed and rests, at 0 if it had to look for it.
    Finished,
}

/// The set-point of the axis being homed and what else is to be done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output {
    /// Position, rad.
    pub position: f64,
    /// Velocity, rad/s.
    pub velocity: f64,
    /// Acceleration, rad/s².
    pub acceleration: f64,
    /// What else.
    pub action: Action,
}

/// A change of velocity under way, from any state of motion.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Change {
    from: f64,
    velocity: Ramp,
    t: f64,
}

impl Change {
    fn new((position, velocity, acceleration): State, to: f64, limits: &AxisLimits) -> Self {
        Self {
            from: position,
            velocity: Ramp::new(velocity, acceleration, to, limits.a, limits.j),
            t: 0.0,
        }
    }

    fn advance(&mut self, ts: f64) -> State {
        self.t += ts;
        let RampState { integral, x, dx } = self.velocity.at(self.t);
        (self.from + integral, x, dx)
    }

    fn finished(&self) -> bool {
        self.t >= self.velocity.duration()
    }
}

/// Position (rad), velocity, acceleration.
type State = (f64, f64, f64);

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    Coarse {
        ramp: Change,
        from: f64,
    },
    /// `seen` is where the switch was.
    Settle {
        ramp: Change,
        rested: f64,
        seen: f64,
    },
    BackOff {
        ramp: Change,
        from: f64,
        way: f64,
    },
    Index {
        ramp: Change,
        from: f64,
    },
    SlowDown {
        ramp: Change,
        index: f64,
    },
    Return {
        profile: Profile,
        from: f64,
        t: f64,
    },
    /// No motion: the zero is set, then homing is done.
    Known {
        zeroed: bool,
    },
    Done {
        at: f64,
    },
    Aborted {
        ramp: Change,
    },
}

/// Homing of one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisHoming {
    parameters: HomingParameters,
    phase: Phase,
    seen: u8,
    switch: bool,
    /// The last set-point: position, velocity, acceleration.
    last: State,
}

impl AxisHoming {
    /// Start at a position (rad) and rest. An axis that already stands on its switch backs off.
    #[must_use]
    pub fn new(parameters: HomingParameters, position: f64, switch: bool) -> Self {
        let ramp = |v1| Change::new((position, 0.0, 0.0), v1, &parameters.limits);
        let phase = match parameters.way {
            Way::Switch { .. } if switch => Phase::Settle {
                ramp: ramp(0.0),
                rested: 0.0,
                seen: position,
            },
            Way::Switch {
                coarse_velocity, ..
            } => Phase::Coarse {
                ramp: ramp(coarse_velocity),
                from: position,
            },
            Way::InPlace | Way::Absolute => Phase::Known { zeroed: false },
        };
        Self {
            parameters,
            phase,
            seen: 0,
            switch,
            last: (position, 0.0, 0.0),
        }
    }

    /// The phase as reported.
    #[must_use]
    pub const fn phase(&self) -> HomingPhase {
        match self.phase {
            Phase::Coarse { .. } => HomingPhase::Coarse,
            Phase::Settle { .. } => HomingPhase::Settle,
            Phase::BackOff { .. } => HomingPhase::BackOff,
            Phase::Index { .. }
            | Phase::SlowDown { .. }
            | Phase::Return { .. }
            | Phase::Known { .. } => HomingPhase::Index,
            Phase::Done { .. } | Phase::Aborted { .. } => HomingPhase::Done,
        }
    }

    /// Slow down to rest, whatever the phase.
    pub fn abort(&mut self) {
        if !matches!(self.phase, Phase::Aborted { .. } | Phase::Done { .. }) {
            let limits = &self.parameters.limits;
            self.phase = Phase::Aborted {
                ramp: Change::new(self.last, 0.0, limits),
            };
        }
    }

    /// After [`AxisHoming::abort`]: has it come to rest?
    #[must_use]
    pub fn at_rest(&self) -> bool {
        match self.phase {
            Phase::Aborted { ramp } => ramp.finished(),
            Phase::Done { .. } => true,
            _ => false,
        }
    }

    /// The switch, debounced: a change counts once it was seen [`DEBOUNCE`] times in a row.
    fn debounce(&mut self, raw: bool) -> bool {
        if raw == self.switch {
            self.seen = 0;
        } else {
            self.seen = self.seen.saturating_add(1);
            if self.seen >= DEBOUNCE {
                self.switch = raw;
                self.seen = 0;
            }
        }
        self.switch
    }

    /// One servo step of `ts` seconds.
    ///
    /// # Errors
    /// The [`Cause`] that ends homing; the axis must then be stopped.
    #[expect(clippy::too_many_lines, reason = "one arm per phase")]
    pub fn step(&mut self, inputs: Inputs, ts: f64) -> Result<Output, Cause> {
        let switch = self.debounce(inputs.switch);
        let HomingParameters {
            way: method,
            travel_rad,
            limits,
        } = self.parameters;
        let mut action = Action::None;
        let (position, velocity, acceleration) = match &mut self.phase {
            Phase::Coarse { ramp, from } => {
                let s = ramp.advance(ts);
                if switch {
                    self.phase = Phase::Settle {
                        ramp: Change::new(s, 0.0, &limits),
                        rested: 0.0,
                        seen: s.0,
                    };
                } else if libm::fabs(s.0 - *from) > travel_rad {
                    return Err(Cause::HomingSwitchNotFound);
                }
                s
            }
            Phase::Settle { ramp, rested, seen } => {
                let s = ramp.advance(ts);
                if ramp.finished() {
                    *rested += ts;
                    if !switch {
                        return Err(Cause::HomingSwitchUnstable);
                    }
                    if *rested >= SETTLE_S {
                        action = Action::ArmIndex;
                        let fine = match method {
                            Way::Switch { fine_velocity, .. } => fine_velocity,
                            Way::InPlace | Way::Absolute => 0.0,
                        };
                        self.phase = Phase::BackOff {
                            ramp: Change::new(s, fine, &limits),
                            from: s.0,
                            way: libm::fabs(s.0 - *seen) + RELEASE_TRAVEL_RAD,
                        };
                    }
                }
                s
            }
            Phase::BackOff { ramp, from, way } => {
                let s = ramp.advance(ts);
                if !switch {
                    // an index passed while the switch was still active is not the one meant
                    action = Action::ArmIndex;
                    self.phase = Phase::Index {
                        ramp: *ramp,
                        from: s.0,
                    };
                } else if libm::fabs(s.0 - *from) > *way {
                    return Err(Cause::HomingSwitchStuck);
                }
                s
            }
            Phase::Index { ramp, from } => {
                let s = ramp.advance(ts);
                if let Some(index) = inputs.index_rad {
                    self.phase = Phase::SlowDown {
                        ramp: Change::new(s, 0.0, &limits),
                        index,
                    };
                } else if libm::fabs(s.0 - *from) > INDEX_TRAVEL_RAD {
                    return Err(Cause::HomingIndexNotFound);
                }
                s
            }
            Phase::SlowDown { ramp, index } => {
                let s = ramp.advance(ts);
                if ramp.finished() {
                    action = Action::SetZero { index_rad: *index };
                    let from = s.0 - *index;
                    self.phase = match Profile::new(libm::fabs(from), &limits) {
                        Ok(profile) => Phase::Return {
                            profile,
                            from,
                            t: 0.0,
                        },
                        Err(_) => return Err(Cause::NotFinite),
                    };
                    // from here on positions count from the index
                    (from, 0.0, 0.0)
                } else {
                    s
                }
            }
            Phase::Return { profile, from, t } => {
                *t += ts;
                let direction = if *from > 0.0 { -1.0 } else { 1.0 };
                let s = profile.at(*t);
                if *t >= profile.duration() {
                    action = Action::Finished;
                    self.phase = Phase::Done { at: 0.0 };
                    (0.0, 0.0, 0.0)
                } else {
                    (*from + direction * s.p, direction * s.v, direction * s.a)
                }
            }
            Phase::Known { zeroed: false } => {
                let (here, ..) = self.last;
                let index_rad = match method {
                    Way::Absolute => inputs.origin_rad,
                    Way::InPlace | Way::Switch { .. } => here,
                };
                action = Action::SetZero { index_rad };
                self.phase = Phase::Known { zeroed: true };
                (here - index_rad, 0.0, 0.0)
            }
            Phase::Known { zeroed: true } => {
                let (at, ..) = self.last;
                action = Action::Finished;
                self.phase = Phase::Done { at };
                (at, 0.0, 0.0)
            }
            Phase::Done { at } => (*at, 0.0, 0.0),
            Phase::Aborted { ramp } => ramp.advance(ts),
        };
        self.last = (position, velocity, acceleration);
        Ok(Output {
            position,
            velocity,
            acceleration,
            action,
        })
    }
}

#[cfg(test)]
mod test {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    const TS: f64 = 0.002;
    const LIMITS: AxisLimits = AxisLimits {
        v: 50.0,
        a: 150.0,
        j: 1500.0,
    };
    const COLUMN: HomingParameters = HomingParameters {
        way: Way::Switch {
            coarse_velocity: -15.0,
            fine_velocity: 3.5,
        },
        travel_rad: 1000.0,
        limits: LIMITS,
    };

    /// A perfect axis: switch below `edge`, index at every whole turn of the shaft.
    struct Bench {
        edge: f64,
        origin: f64,
        armed: bool,
        latched: Option<f64>,
        last: f64,
        positions: Vec<f64>,
        phases: Vec<HomingPhase>,
    }

    impl Bench {
        fn run(&mut self, mut switch: impl FnMut(f64, HomingPhase) -> bool) -> Result<f64, Cause> {
            let start = self.last;
            let mut homing = AxisHoming::new(COLUMN, start, switch(start, HomingPhase::Coarse));
            for _ in 0..100_000 {
                let inputs = Inputs {
                    switch: switch(self.last + self.origin, homing.phase()),
                    index_rad: self.latched,
                    origin_rad: -self.origin,
                };
                let out = homing.step(inputs, TS)?;
                match out.action {
                    Action::ArmIndex => {
                        self.armed = true;
                        self.latched = None;
                    }
                    Action::SetZero { index_rad } => {
                        self.origin += index_rad;
                        self.latched = None;
                    }
                    Action::Finished => return Ok(self.origin),
                    Action::None => {}
                }
                let (a, b) = (self.last, out.position);
                if out.action == Action::None {
                    let turn = core::f64::consts::TAU;
                    let next = ((a + self.origin) / turn).ceil() * turn - self.origin;
                    if self.armed && b > a && next >= a && next < b {
                        self.latched = Some(next);
                        self.armed = false;
                    }
                }
                self.positions.push(b + self.origin);
                if self.phases.last() != Some(&homing.phase()) {
                    self.phases.push(homing.phase());
                }
                self.last = b;
            }
            panic!("homing does not end");
        }
    }

    fn bench() -> Bench {
        Bench {
            edge: -2.0,
            origin: 17.3,
            armed: false,
            latched: None,
            last: 0.0,
            positions: Vec::new(),
            phases: Vec::new(),
        }
    }

    #[test]
    fn finds_the_index_above_the_switch_and_rests_there() {
        let mut b = bench();
        let edge = b.edge;
        let origin = b.run(|p, _| p < edge).unwrap();
        assert!(origin.abs() < 1e-9, "true angle of the new zero: {origin}");
        assert_eq!(
            b.phases,
            [
                HomingPhase::Coarse,
                HomingPhase::Settle,
                HomingPhase::BackOff,
                HomingPhase::Index,
                HomingPhase::Done
            ][..b.phases.len()]
        );
        // set-points obey the limits by differences; 2 % for the difference quotient
        for w in b.positions.windows(4) {
            let (d1, d2) = (w[1] - w[0], w[2] - 2.0 * w[1] + w[0]);
            let d3 = w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0];
            assert!(d1.abs() / TS < 15.0 * 1.02 + 10.0);
            assert!(d2.abs() / TS / TS < LIMITS.a * 1.02, "{}", d2 / TS / TS);
            assert!(
                d3.abs() / TS / TS / TS < LIMITS.j * 2.02,
                "{}",
                d3 / TS / TS / TS
            );
        }
    }

    #[test]
    fn an_axis_without_a_switch_is_homed_where_it_stands() {
        for (way, origin) in [(Way::InPlace, 5.0), (Way::Absolute, 5.0)] {
            let parameters = HomingParameters { way, ..COLUMN };
            // a switch that is active, if there is one, is nothing to it
            let mut homing = AxisHoming::new(parameters, 12.5, true);
            let inputs = Inputs {
                switch: true,
                index_rad: None,
                origin_rad: origin,
            };
            let zero = if way == Way::InPlace { 12.5 } else { 5.0 };
            let first = homing.step(inputs, TS).unwrap();
            assert_eq!(first.action, Action::SetZero { index_rad: zero });
            for (k, action) in [Action::Finished, Action::None, Action::None]
                .iter()
                .enumerate()
            {
                let out = homing.step(inputs, TS).unwrap();
                assert_eq!(out.action, *action, "{k}");
                // it rests, counted from its new zero
                assert!((out.position - (12.5 - zero)).abs() < 1e-12, "{k} {out:?}");
                assert!(out.velocity.abs() < 1e-12 && out.acceleration.abs() < 1e-12);
            }
            assert!(homing.at_rest());
            assert_eq!(homing.phase(), HomingPhase::Done);
        }
    }

    #[test]
    fn a_fast_axis_has_as_far_to_come_back_as_it_took_to_stop() {
        let fast = HomingParameters {
            way: Way::Switch {
                coarse_velocity: -250.0,
                fine_velocity: 25.0,
            },
            travel_rad: 7000.0,
            limits: AxisLimits {
                v: 910.0,
                a: 1500.0,
                j: 15_000.0,
            },
        };
        let mut homing = AxisHoming::new(fast, 300.0, false);
        let (mut p, mut lowest) = (300.0, 300.0);
        let mut released = false;
        for _ in 0..5_000 {
            let inputs = Inputs {
                switch: p < -2.0,
                index_rad: (released && p > 0.0).then_some(0.0),
                origin_rad: 0.0,
            };
            let out = homing.step(inputs, TS).unwrap();
            released |= homing.phase() == HomingPhase::Index;
            p = out.position;
            lowest = if p < lowest { p } else { lowest };
            if out.action == Action::Finished {
                // farther below the switch than the two turns of a slow axis
                assert!(lowest < -2.0 - RELEASE_TRAVEL_RAD, "{lowest}");
                return;
            }
        }
        panic!("homing does not end at {p}");
    }

    #[test]
    fn bounce_is_ignored_and_each_phase_has_its_error() {
        let mut n = 0;
        let mut b = bench();
        let bouncing = b.run(|p, _| {
            n += 1;
            if (p + 2.0).abs() < 0.05 {
                n % 2 == 0
            } else {
                p < -2.0
            }
        });
        assert!(bouncing.unwrap().abs() < 1e-9);

        assert_eq!(bench().run(|_, _| false), Err(Cause::HomingSwitchNotFound));
        assert_eq!(bench().run(|_, _| true), Err(Cause::HomingSwitchStuck));
        assert_eq!(
            bench().run(|p, phase| p < -2.0 && phase == HomingPhase::Coarse),
            Err(Cause::HomingSwitchUnstable)
        );
        let mut b = bench();
        b.origin = 17.3;
        // no index: the drive never latches
        let mut homing = AxisHoming::new(COLUMN, 0.0, false);
        let mut p = 0.0;
        let error = loop {
            match homing.step(
                Inputs {
                    switch: p < -2.0,
                    index_rad: None,
                    origin_rad: 0.0,
                },
                TS,
            ) {
                Ok(out) => p = out.position,
                Err(cause) => break cause,
            }
        };
        assert_eq!(error, Cause::HomingIndexNotFound);
    }
}
