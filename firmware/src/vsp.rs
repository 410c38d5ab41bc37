//! Virtual sensors on the node: aggregation near the receptors ([Z1] (3), (13)).

use crate::ecp::Sensors;

/// `f_v`: motor effort from the drives' currents, without a force sensor.
///
/// The reading is the low-pass filtered |current| over the drive's current limit; what moves
/// freely stays well below what is held back. The filter's time constant is one macrostep, so a
/// reading is neither older nor noisier than the ECP's own cadence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffortSensor<const N: usize> {
    limit_ma: [f64; N],
    weight: f64,
    reading: Sensors<N>,
}

impl<const N: usize> EffortSensor<N> {
    /// For drives with these current limits (mA); `steps` servo steps make a macrostep.
    #[must_use]
    pub fn new(limit_ma: [f64; N], steps: u32) -> Self {
        let steps = f64::from(if steps == 0 { 1 } else { steps });
        Self {
            limit_ma,
            weight: 1.0 / steps,
            reading: Sensors { effort: [0.0; N] },
        }
    }

    /// One servo step: `r_j`, the currents in mA.
    pub fn aggregate(&mut self, current_ma: &[f64; N]) {
        let Self {
            limit_ma,
            weight,
            reading,
        } = self;
        for ((effort, i), limit) in reading.effort.iter_mut().zip(current_ma).zip(limit_ma) {
            *effort += *weight * (libm::fabs(*i) / *limit - *effort);
        }
    }

    /// `v_j`
    #[must_use]
    pub const fn reading(&self) -> Sensors<N> {
        self.reading
    }
}
