//! The classes of cases. Positions, dynamics and limits are distributed as in Ruckig's own tests:
//! positions N(0, 4), velocities and accelerations N(0, 0.8), limits U(0.08, 16). So that an end
//! is inside its limits, the limits of velocity and acceleration are widened by |v1| and |a1|.
//!
//! Every fourth case of every class has lower limits of its own, U(−16, −0.08), widened likewise;
//! otherwise they mirror the upper ones.

use crate::case::{Axis, Case};
use crate::random::Random;
use std::fmt;
use std::str::FromStr;

/// Tries to draw an end that can be asked for, before one without acceleration is taken.
const END_TRIES: usize = 16;

/// What kind of question is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Rest to rest: positions only.
    R,
    /// Re-targeted in motion: any velocity (9 of 10) and acceleration (8 of 10) at the start, rest
    /// at the end. The start may be outside the limits.
    T,
    /// Any state to any state: as T, and a velocity (7 of 10) and an acceleration (6 of 10) at the
    /// end; ends that cannot be asked for are drawn again.
    S,
    /// Servoing near the target: the distance is ±10^−x, x uniform in \[0, 15\] for each axis;
    /// velocity and acceleration at the start, where not zero, are dynamics times 10^−x with an x
    /// of their own each. Every second case ends at rest, the others with a velocity made likewise.
    N,
    /// High limits: U(10, 10⁶), lower limits of their own U(−10⁶, −10); cases as T and as S in turn.
    H,
    /// Exact and degenerate: small integers everywhere. Half of the cases may start on a limit or
    /// at twice a limit, with acceleration in any direction; ends may lie on limits; one in eight
    /// may have an acceleration at the end that cannot be asked for. One in eight has all axes equal,
    /// one in eight is at its end from the beginning.
    E,
}

impl Class {
    /// All of them, in the order of reports.
    pub const ALL: [Self; 6] = [Self::R, Self::T, Self::S, Self::N, Self::H, Self::E];

    /// Its letter.
    #[must_use]
    pub fn letter(self) -> &'static str {
        match self {
            Self::R => "R",
            Self::T => "T",
            Self::S => "S",
            Self::N => "N",
            Self::H => "H",
            Self::E => "E",
        }
    }

    /// One line about it.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::R => "rest to rest",
            Self::T => "any state to rest",
            Self::S => "any state to any state",
            Self::N => "near the target",
            Self::H => "high limits",
            Self::E => "exact and degenerate",
        }
    }

    /// The case of a number; the same bits for the same arguments, whoever asks.
    #[must_use]
    pub fn case<const N: usize>(self, seed: u64, index: u64) -> Case<N> {
        let stream = u64::from(self.letter().as_bytes()[0]);
        let mut random = Random::new(seed, stream, index);
        let own_lower = index % 4 == 3;
        let even = index % 8 < 4; // not in step with `own_lower`
        let wide = (0.08, 16.0);
        match self {
            Self::R => {
                [(); N].map(|()| positions(&mut random).limited(&mut random, wide, own_lower))
            }
            Self::T => [(); N].map(|()| started(&mut random).limited(&mut random, wide, own_lower)),
            Self::S => [(); N].map(|()| ended(&mut random, wide, own_lower)),
            Self::H => [(); N].map(|()| {
                let high = (10.0, 1e6);
                if even {
                    started(&mut random).limited(&mut random, high, own_lower)
                } else {
                    ended(&mut random, high, own_lower)
                }
            }),
            Self::N => {
                [(); N].map(|()| near(&mut random, even).limited(&mut random, wide, own_lower))
            }
            Self::E => exact(&mut random, own_lower),
        }
    }
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.letter())
    }
}

impl FromStr for Class {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|class| class.letter() == text);
        found.ok_or_else(|| format!("no class {text} (R, T, S, N, H, E)"))
    }
}

/// A velocity or an acceleration, or none.
fn dynamic(random: &mut Random, probability: f64) -> f64 {
    if random.chance(probability) {
        random.normal(0.8)
    } else {
        0.0
    }
}

fn positions(random: &mut Random) -> Axis {
    Axis {
        p0: random.normal(4.0),
        p1: random.normal(4.0),
        ..Axis::default()
    }
}

fn started(random: &mut Random) -> Axis {
    Axis {
        v0: dynamic(random, 0.9),
        a0: dynamic(random, 0.8),
        ..positions(random)
    }
}

fn ended(random: &mut Random, range: (f64, f64), own_lower: bool) -> Axis {
    let start = started(random);
    for _ in 0..END_TRIES {
        let axis = Axis {
            v1: dynamic(random, 0.7),
            a1: dynamic(random, 0.6),
            ..start
        }
        .limited(random, range, own_lower);
        if axis.has_valid_end() {
            return axis;
        }
    }
    let v1 = dynamic(random, 0.7);
    Axis { v1, ..start }.limited(random, range, own_lower)
}

/// 10^−x with x uniform in [0, 15].
fn small(random: &mut Random) -> f64 {
    libm::pow(10.0, -random.uniform(0.0, 15.0))
}

fn near(random: &mut Random, rest: bool) -> Axis {
    let p0 = random.normal(4.0);
    let distance = random.pick([-1.0, 1.0]) * small(random);
    Axis {
        p0,
        v0: dynamic(random, 0.9) * small(random),
        a0: dynamic(random, 0.8) * small(random),
        p1: p0 + distance,
        v1: if rest {
            0.0
        } else {
            dynamic(random, 0.7) * small(random)
        },
        ..Axis::default()
    }
}

fn exact<const N: usize>(random: &mut Random, own_lower: bool) -> Case<N> {
    let kind = random.pick([
        Kind::Equal,
        Kind::Arrived,
        Kind::Free,
        Kind::Free,
        Kind::Free,
        Kind::Free,
        Kind::Free,
        Kind::EndAccelerated,
    ]);
    let outside = random.chance(0.5);
    let mut axes = [(); N].map(|()| exact_axis(random, kind, outside, own_lower));
    if let (Kind::Equal, Some(first)) = (kind, axes.first().copied()) {
        axes = [first; N];
    }
    axes
}

/// What is special of all axes of an exact case together.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Equal,
    Arrived,
    EndAccelerated,
    Free,
}

fn exact_axis(random: &mut Random, kind: Kind, outside: bool, own_lower: bool) -> Axis {
    let mut limit = || random.pick([1.0, 1.0, 2.0, 3.0, 4.0]);
    let (v_max, a_max, j_max) = (limit(), limit(), limit());
    let (v_min, a_min) = if own_lower {
        (-limit(), -limit())
    } else {
        (-v_max, -a_max)
    };
    let mut position = || random.pick([-2.0, -1.0, 0.0, 1.0, 2.0]);
    let (p0, p1) = (position(), position());
    let axis = Axis {
        p0,
        p1,
        v_min,
        v_max,
        a_min,
        a_max,
        j_max,
        ..Axis::default()
    };
    if kind == Kind::Arrived {
        return Axis { p1: p0, ..axis };
    }
    let (v0, a0) = if outside {
        (
            random.pick([0.0, v_max, v_min, 2.0 * v_max, 2.0 * v_min, 1.0, -1.0]),
            random.pick([0.0, a_max, a_min, 2.0 * a_max, 2.0 * a_min, 1.0, -1.0]),
        )
    } else {
        (random.pick([0.0, 0.0, v_max, v_min, 0.5 * v_max]), 0.0)
    };
    let a1 = if kind == Kind::EndAccelerated {
        random.pick([0.0, 0.0, 0.0, a_max, a_min, 0.5 * a_max])
    } else {
        0.0
    };
    Axis {
        v0,
        a0,
        v1: random.pick([0.0, 0.0, 0.0, v_max, v_min, 0.5 * v_max, 0.5 * v_min]),
        a1,
        ..axis
    }
}

impl Axis {
    /// The same motion with limits drawn for it.
    fn limited(self, random: &mut Random, (least, most): (f64, f64), own_lower: bool) -> Self {
        let v_max = random.uniform(least, most) + self.v1.abs();
        let a_max = random.uniform(least, most) + self.a1.abs();
        let j_max = random.uniform(least, most);
        let (v_min, a_min) = if own_lower {
            (
                -random.uniform(least, most) - self.v1.abs(),
                -random.uniform(least, most) - self.a1.abs(),
            )
        } else {
            (-v_max, -a_max)
        };
        Self {
            v_min,
            v_max,
            a_min,
            a_max,
            j_max,
            ..self
        }
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "numbers drawn, not computed")]
mod test {
    use super::*;

    const COUNT: u64 = 2000;

    fn axes(class: Class) -> impl Iterator<Item = Axis> {
        (0..COUNT).flat_map(move |index| class.case::<3>(1, index))
    }

    #[test]
    fn a_case_depends_on_nothing_but_its_name() {
        for class in Class::ALL {
            let case = class.case::<7>(5, 77);
            assert_eq!(class.case::<7>(5, 77), case);
            assert_ne!(class.case::<7>(6, 77), case);
            assert_ne!(class.case::<7>(5, 81), case);
        }
    }

    #[test]
    fn limits_are_limits() {
        for class in Class::ALL {
            for x in axes(class) {
                let upper = [x.v_max, x.a_max, x.j_max];
                assert!(
                    upper.iter().all(|x| *x > 0.0 && x.is_finite()),
                    "{class} {x:?}"
                );
                assert!(x.v_min < 0.0 && x.a_min < 0.0, "{class} {x:?}");
            }
        }
    }

    #[test]
    fn each_fourth_case_has_lower_limits_of_its_own() {
        for class in Class::ALL {
            let symmetric = |index| {
                let case = class.case::<3>(1, index);
                case.iter().all(Axis::is_symmetric)
            };
            assert!((0..400).filter(|i| i % 4 < 3).all(symmetric), "{class}");
            // an exact case may have the same small integers by chance
            let own = (0..400).filter(|i| i % 4 == 3 && !symmetric(*i)).count();
            assert!(own > 80, "{class}: {own} of 100");
        }
    }

    #[test]
    fn starts_and_ends_are_those_of_the_class() {
        assert!(axes(Class::R).all(|x| [x.v0, x.a0, x.v1, x.a1] == [0.0; 4]));
        assert!(axes(Class::T).all(|x| [x.v1, x.a1] == [0.0; 2]));
        // 0.9 and 0.8 of 6000, ± five deviations of a binomial
        let moving = axes(Class::T).filter(|x| x.v0.abs() > 0.0).count();
        assert!((5284..=5516).contains(&moving), "{moving}");
        let accelerated = axes(Class::T).filter(|x| x.a0.abs() > 0.0).count();
        assert!((4645..=4955).contains(&accelerated), "{accelerated}");
        assert!(axes(Class::S).any(|x| x.a1.abs() > 0.0));
        assert!(axes(Class::N).all(|x| (x.p1 - x.p0).abs() <= 1.0 && x.a1.abs() == 0.0));
        assert!(axes(Class::N).any(|x| (x.p1 - x.p0).abs() < 1e-12));
        assert!(axes(Class::H).any(|x| x.j_max > 9e5) && axes(Class::H).all(|x| x.j_max >= 10.0));
    }

    #[test]
    fn ends_can_be_asked_for_except_in_some_exact_cases() {
        for class in [Class::R, Class::T, Class::S, Class::N, Class::H] {
            assert!(axes(class).all(|x| x.has_valid_end()), "{class}");
        }
        let invalid = axes(Class::E).filter(|x| !x.has_valid_end()).count();
        assert!((1..600).contains(&invalid), "{invalid}");
    }

    #[test]
    fn exact_cases_have_all_their_kinds() {
        let cases = || (0..COUNT).map(|index| Class::E.case::<3>(1, index));
        let some = |is: fn(&Case<3>) -> bool| cases().filter(is).count() > 100;
        assert!(some(|case| case.iter().all(|x| *x == case[0])));
        assert!(some(|case| case
            .iter()
            .all(|x| x.p1 == x.p0 && x.v0 == 0.0 && x.v1 == 0.0)));
        assert!(some(|case| case
            .iter()
            .any(|x| x.v0 > x.v_max && x.a0 > 0.0)));
        assert!(some(|case| case.iter().any(|x| x.a0 < x.a_min)));
        assert!(some(|case| case.iter().any(|x| x.v1 == x.v_max)));
    }

    #[test]
    fn a_class_is_read_by_its_letter() {
        for class in Class::ALL {
            assert_eq!(class.letter().parse(), Ok(class));
        }
        assert!("r".parse::<Class>().is_err() && "RT".parse::<Class>().is_err());
    }
}
