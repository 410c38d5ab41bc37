//! Seeded random numbers: one stream per purpose, so that a new purpose changes no old run.

/// `SplitMix64` (Steele, Lea, Flood: *Fast splittable pseudorandom number generators*, 2014).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SplitMix64(u64);

impl SplitMix64 {
    /// The stream of `seed`.
    #[must_use]
    pub const fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The stream of `seed` for the purpose `name` and the instance `number`.
    #[must_use]
    pub fn stream(seed: u64, name: &str, number: u64) -> Self {
        // FNV-1a over the name: any function of the name that spreads would do.
        let hash = name.bytes().fold(0xCBF2_9CE4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3)
        });
        let mut mixed = Self(seed ^ hash);
        let start = mixed.next_u64() ^ number.wrapping_mul(0xD134_2543_DE82_EF95);
        Self(start)
    }

    /// 64 random bits.
    pub const fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// One of 0 to `n` − 1; `n` must not be 0, and is small beside 2⁶⁴.
    pub const fn below(&mut self, n: u64) -> u64 {
        self.next_u64() % n
    }

    /// A coin.
    pub const fn coin(&mut self) -> bool {
        self.next_u64() >> 63 == 1
    }

    /// Uniform in [0, 1), with 53 random bits.
    #[expect(clippy::cast_precision_loss, reason = "53 bits are exact")]
    pub const fn unit(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in [`low`, `high`).
    pub const fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Normally distributed, with mean 0 and standard deviation 1 (Box and Muller, 1958).
    pub fn normal(&mut self) -> f64 {
        // 1 − u is never 0
        let radius = libm::sqrt(-2.0 * libm::log(1.0 - self.unit()));
        radius * libm::cos(core::f64::consts::TAU * self.unit())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first outputs for seed 1234567, as published with the reference implementation.
    #[test]
    fn reference_values() {
        let mut random = SplitMix64::new(1_234_567);
        let first = [(); 3].map(|()| random.next_u64());
        let expected = [
            6_457_827_717_110_365_317,
            3_203_168_211_198_807_973,
            9_817_491_932_198_370_423,
        ];
        assert_eq!(first, expected);
    }

    #[test]
    fn streams_differ_by_seed_name_and_number() {
        let first = |mut random: SplitMix64| random.next_u64();
        let base = first(SplitMix64::stream(1, "bounce", 0));
        assert_eq!(base, first(SplitMix64::stream(1, "bounce", 0)));
        for other in [
            SplitMix64::stream(2, "bounce", 0),
            SplitMix64::stream(1, "start", 0),
            SplitMix64::stream(1, "bounce", 1),
        ] {
            assert_ne!(base, first(other));
        }
    }

    #[test]
    fn numbers_stay_in_their_range_and_fill_it() {
        let mut random = SplitMix64::stream(7, "range", 0);
        let values: Vec<f64> = (0..1000).map(|_| random.between(5.0, 40.0)).collect();
        assert!(values.iter().all(|value| (5.0..40.0).contains(value)));
        // Mean of 1000 uniform values: 22.5 with a standard error of 35/sqrt(12·1000) = 0.32.
        let mean = values.iter().sum::<f64>() / 1000.0;
        assert!((mean - 22.5).abs() < 1.6, "{mean}");
    }

    #[test]
    fn normal_numbers_have_their_moments() {
        let mut random = SplitMix64::stream(7, "normal", 0);
        let values: Vec<f64> = (0..10_000).map(|_| random.normal()).collect();
        let moment = |n: i32| {
            let power = |x: &f64| (0..n).fold(1.0, |p, _| p * x);
            values.iter().map(power).sum::<f64>() / 10_000.0
        };
        // standard errors of 0.01, 0.014 and 0.1 about 0, 1 and 3
        assert!(moment(1).abs() < 0.05, "{}", moment(1));
        assert!((moment(2) - 1.0).abs() < 0.07, "{}", moment(2));
        assert!((moment(4) - 3.0).abs() < 0.5, "{}", moment(4));
    }
}
