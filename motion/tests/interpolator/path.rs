//! An interpolator and the limits by which pieces are made for it: knots go straight into the queue.
use motion::interpolator::{Braking, PathLimits, PushError};
use motion::knot::EnvelopeError;
use motion::{Angle, AxisEnvelope, Interpolator, Knot};
use std::ops::{Deref, DerefMut};

#[derive(Clone, Debug)]
pub(crate) struct Path<const N: usize, const Q: usize> {
    pub(crate) limits: PathLimits<N>,
    edp: Interpolator<N, Q>,
}

impl<const N: usize, const Q: usize> Path<N, Q> {
    pub(crate) fn new(axes: [AxisEnvelope; N], hold: [Angle; N]) -> Result<Self, EnvelopeError> {
        let limits = PathLimits::new(axes)?;
        let mut edp = Interpolator::new(Braking::new(&axes));
        edp.hold_anew(&limits.ranges(), hold);
        Ok(Self { limits, edp })
    }

    /// Steps of acceleration where the piece begins.
    pub(crate) fn push(&mut self, knot: Knot<N>, now_us: u64) -> Result<[f64; N], PushError> {
        let made = self.limits.piece(&self.edp.tip(), &knot)?;
        self.edp.push(&made.piece, now_us)?;
        Ok(made.acceleration_step)
    }
}

impl<const N: usize, const Q: usize> Deref for Path<N, Q> {
    type Target = Interpolator<N, Q>;
    fn deref(&self) -> &Self::Target {
        &self.edp
    }
}

impl<const N: usize, const Q: usize> DerefMut for Path<N, Q> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.edp
    }
}
