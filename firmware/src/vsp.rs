//! Virtual sensors on the node: aggregation near the receptors (\[Z1\] (3), (13)).

mod wrist;

pub use wrist::Wrist;

use crate::ecp::Sensors;
use agent::VirtualSensor;

/// `f_v`: motor effort from the drives' currents, without a force sensor.
///
/// The reading is the low-pass filtered |current| over the drive's current limit; what moves
/// freely stays well below what is held back. The filter's time constant is one macrostep, so a
/// reading is neither older nor noisier than the ECP's own cadence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffortSensor<const N: usize> {
    /// Shares of the current limits in 1 mA.
    per_ma: [f32; N],
    weight: f32,
}

/// What the filter remembers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filtered<const N: usize>([f32; N]);

impl<const N: usize> Default for Filtered<N> {
    fn default() -> Self {
        Self([0.0; N])
    }
}

impl<const N: usize> EffortSensor<N> {
    /// For drives with these current limits (mA); `steps` servo steps make a macrostep.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "some tens")]
    pub fn new(limit_ma: [f32; N], steps: u32) -> Self {
        let steps = if steps == 0 { 1 } else { steps } as f32;
        Self {
            per_ma: limit_ma.map(|limit| 1.0 / limit),
            weight: 1.0 / steps,
        }
    }
}

impl<const N: usize> VirtualSensor for EffortSensor<N> {
    type Configuration = ();
    type Effector = ();
    /// Motor currents, mA.
    type Receptors = [f32; N];
    type Own = Filtered<N>;
    type Reading = Sensors<N>;

    fn aggregate(
        &self,
        own: &mut Filtered<N>,
        (): &(),
        (): &(),
        current_ma: &[f32; N],
    ) -> Option<Sensors<N>> {
        for ((effort, i), per_ma) in own.0.iter_mut().zip(current_ma).zip(&self.per_ma) {
            *effort += self.weight * (libm::fabsf(*i) * *per_ma - *effort);
        }
        Some(Sensors {
            effort: own.0.map(f64::from),
            force_n: None,
        })
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use agent::Vsp;

    #[test]
    fn a_step_of_current_shows_within_a_macrostep() {
        let mut vsp = Vsp::new(EffortSensor::<2>::new([1000.0, 500.0], 10), ());
        let mut reading = None;
        for _ in 0..10 {
            reading = vsp.step(&(), &[-1000.0, 0.0]);
        }
        let [a, b] = reading.unwrap().effort;
        // (1 − 1/10)¹⁰ = 0.349 is still missing
        assert!((a - 0.651).abs() < 1e-3 && b.abs() < 1e-15, "{a} {b}");
    }
}
