//! Random numbers that can be replayed.

/// A source of deviates uniform in `[0, 1)`.
///
/// Always seeded by whoever builds the behaviour, so that a run can be repeated to the byte.
pub trait Uniform {
    /// The next deviate.
    fn draw(&mut self) -> f64;
}

impl<U: Uniform + ?Sized> Uniform for &mut U {
    fn draw(&mut self) -> f64 {
        (**self).draw()
    }
}

/// Steele, Lea and Flood's `SplitMix64`: 64 bits of state, period 2⁶⁴, every seed is good.
///
/// For choices among behaviours, not for secrets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SplitMix64 {
    state: u64,
}

impl SplitMix64 {
    /// The generator of this seed.
    #[must_use]
    pub const fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// The next 64 bits.
    pub const fn next_u64(&mut self) -> u64 {
        // Constants of the reference implementation: the golden ratio, and Stafford's mix 13.
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = self.state;
        let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }
}

impl Uniform for SplitMix64 {
    fn draw(&mut self) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "53 bits are exact")]
        let bits = (self.next_u64() >> 11) as f64;
        bits * (0.5 * f64::EPSILON)
    }
}

#[cfg(test)]
mod tests {
    use super::{SplitMix64, Uniform};

    #[test]
    fn known_sequence() {
        // The published sequence of the seed 1234567.
        let mut random = SplitMix64::new(1_234_567);
        let known = [
            6_457_827_717_110_365_317,
            3_203_168_211_198_807_973,
            9_817_491_932_198_370_423,
            4_593_380_528_125_082_431,
            16_408_922_859_458_223_821,
        ];
        assert_eq!(core::array::from_fn(|_| random.next_u64()), known);
    }

    #[test]
    fn deviates_fill_the_unit_interval() {
        const N: u32 = 10_000;
        let mut random = SplitMix64::new(7);
        let mut tenths = [0_u32; 10];
        for _ in 0..N {
            let u = random.draw();
            assert!((0.0..1.0).contains(&u));
            let tenth = (1..10).filter(|&t| u >= f64::from(t) * 0.1).count();
            tenths[tenth] += 1;
        }
        // 1000 expected, σ = 30: five σ either way.
        assert!(
            tenths.iter().all(|n| (850..=1150).contains(n)),
            "{tenths:?}"
        );
    }
}
