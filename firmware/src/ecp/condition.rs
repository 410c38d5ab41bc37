//! The conditions every node has: initial conditions of `Wait`, guards and predicates.

use crate::ecp::{EcpOf, Sensors};
use agent::args::{C0, E, F, V};
use agent::{Condition, X};
use protocol::message::{Coordination, WireCondition};

/// `f^4(c_0, c_j)`: the coordinator's latest decision has this label.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decided {
    /// The label.
    pub label: u16,
}

impl<const N: usize> Condition<EcpOf<N>> for Decided {
    type Args = F<C0, (), ()>;
    fn holds(&self, x: X<'_, EcpOf<N>, Self::Args>) -> bool {
        matches!(x.c0().says, Coordination::Loose(decision) if decision.label == self.label)
    }
}

/// `f^2(c_j, e_j)`: a joint is beyond a bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointBeyond {
    /// The axis, from 0.
    pub axis: usize,
    /// The bound, rad or m.
    pub bound: f64,
    /// Above it, or below it.
    pub above: bool,
}

impl<const N: usize> Condition<EcpOf<N>> for JointBeyond {
    type Args = F<(), E, ()>;
    fn holds(&self, x: X<'_, EcpOf<N>, Self::Args>) -> bool {
        let value = x.e().joints.as_ref().and_then(|q| q.0.get(self.axis));
        value.is_some_and(|q| {
            if self.above {
                *q > self.bound
            } else {
                *q < self.bound
            }
        })
    }
}

/// `f^2(c_j, e_j)`: every axis follows its demand within a window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settled {
    /// rad of the motor shaft.
    pub window_rad: f64,
}

impl<const N: usize> Condition<EcpOf<N>> for Settled {
    type Args = F<(), E, ()>;
    fn holds(&self, x: X<'_, EcpOf<N>, Self::Args>) -> bool {
        x.e()
            .following_error
            .iter()
            .all(|e| libm::fabs(*e) <= self.window_rad)
    }
}

/// `f^1(c_j, v_j)`: a motor works harder than free motion needs: the arm touches something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Fraction of the current limit.
    pub effort: f64,
}

impl<const N: usize> Condition<EcpOf<N>> for Contact {
    type Args = F<(), (), V>;
    fn holds(&self, x: X<'_, EcpOf<N>, Self::Args>) -> bool {
        x.v().effort.iter().any(|e| *e > self.effort)
    }
}

/// `f^1(c_j, v_j)`: the force at the wrist has changed by more than this since the motion began. A `MoveUntilForce` ends by
/// it in the servo step in which it is felt; in the ECP it is there for programs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceAbove {
    /// N
    pub newtons: f64,
}

impl ForceAbove {
    /// By these readings? Where none can be read it is not.
    #[must_use]
    pub fn exceeded<const N: usize>(&self, v: &Sensors<N>) -> bool {
        v.force_n.is_some_and(|force| force > self.newtons)
    }
}

impl<const N: usize> Condition<EcpOf<N>> for ForceAbove {
    type Args = F<(), (), V>;
    fn holds(&self, x: X<'_, EcpOf<N>, Self::Args>) -> bool {
        self.exceeded(x.v())
    }
}

/// `f^6(c_0, c_j, e_j)`: a condition that came over the wire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FromWire(pub WireCondition);

impl<const N: usize> Condition<EcpOf<N>> for FromWire {
    type Args = F<C0, E, ()>;
    fn holds(&self, x: X<'_, EcpOf<N>, Self::Args>) -> bool {
        match self.0 {
            WireCondition::Decided { label } => Decided { label }.holds(x.narrow()),
            WireCondition::Joint { axis, value, above } => JointBeyond {
                axis: usize::from(axis),
                bound: value,
                above,
            }
            .holds(x.narrow()),
            WireCondition::Settled { window_rad } => Settled {
                window_rad: f64::from(window_rad),
            }
            .holds(x.narrow()),
        }
    }
}
