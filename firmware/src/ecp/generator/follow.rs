//! `f^4(c_0, c_j)`: tight coordination. The coordinator computes where to be and when; the node
//! interpolates between. MRROC++'s transparent generator.

use crate::ecp::{Coordinator, Demand, EcpOf};
use agent::args::{C0, F};
use agent::{Generator, X};
use protocol::fault::Refusal;
use protocol::message::{Coordination, KnotMessage, Space};
use protocol::time::Micros;
use robots::{JointMotion, Joints, MotorMotion, Motors};

/// Follow the coordinator's knots until it ends the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Follow;

/// The last knot's instant: no knot is demanded twice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Followed {
    last: Option<Micros>,
}

fn axes<const N: usize>(values: &[f32]) -> Option<[f64; N]> {
    let mut out = [0.0; N];
    if values.len() != N {
        return None;
    }
    for (out, value) in out.iter_mut().zip(values) {
        *out = f64::from(*value);
    }
    Some(out)
}

fn demand<const N: usize>(knot: &KnotMessage) -> Demand<N> {
    let got = u8::try_from(knot.position.len()).unwrap_or(u8::MAX);
    let count = Refusal::AxisCount {
        expected: u8::try_from(N).unwrap_or(u8::MAX),
        got,
    };
    let Ok(position) = <[f64; N]>::try_from(knot.position.as_slice()) else {
        return Demand::Refuse(count);
    };
    let Some(velocity) = axes(&knot.velocity) else {
        return Demand::Refuse(count);
    };
    let has_acceleration = !knot.acceleration.is_empty();
    let acceleration = if has_acceleration {
        let Some(acceleration) = axes(&knot.acceleration) else {
            return Demand::Refuse(count);
        };
        acceleration
    } else {
        [0.0; N]
    };
    match knot.space {
        Space::Motors => Demand::At {
            at: knot.at,
            motion: MotorMotion {
                position: Motors(position),
                velocity,
                acceleration,
            },
            has_acceleration,
        },
        Space::Joints => Demand::JointsAt {
            at: knot.at,
            motion: JointMotion {
                position: Joints(position),
                velocity,
                acceleration,
            },
            has_acceleration,
        },
    }
}

impl Follow {
    fn demand<const N: usize>(c: &mut Followed, c0: &Coordinator) -> Demand<N> {
        match &c0.says {
            Coordination::Tight(knot) if c.last.is_none_or(|last| last < knot.at) => {
                c.last = Some(knot.at);
                demand(knot)
            }
            Coordination::None | Coordination::Loose(_) | Coordination::Tight(_) => Demand::Stay,
        }
    }
}

impl<const N: usize> Generator<EcpOf<N>> for Follow {
    type Own = Followed;
    type Args = F<C0, (), ()>;

    fn first(&self, x: X<'_, EcpOf<N>, Self::Args>) -> (Followed, Demand<N>) {
        let mut c = Followed::default();
        let y = Self::demand(&mut c, x.c0());
        (c, y)
    }

    fn next(&self, c: &mut Followed, x: X<'_, EcpOf<N>, Self::Args>) -> Demand<N> {
        Self::demand(c, x.c0())
    }

    fn terminal(&self, _: &Followed, x: X<'_, EcpOf<N>, Self::Args>) -> bool {
        x.c0().end_motion && !matches!(x.c0().says, Coordination::Tight(_))
    }
}
