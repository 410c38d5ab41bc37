//! Random numbers that are the same bits on every machine.

/// `SplitMix64` (Steele, Lea, Flood: "Fast splittable pseudorandom number generators", 2014).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The stream of one case: any of them can be drawn without those before it.
    #[must_use]
    pub fn new(seed: u64, class: u64, index: u64) -> Self {
        let mut state = 0;
        for part in [seed, class, index] {
            state = mix(state ^ mix(part.wrapping_add(GAMMA)));
        }
        Self(state)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(GAMMA);
        mix(self.0)
    }

    /// Uniform in \[0, 1).
    pub fn unit(&mut self) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "53 bits fit")]
        let bits = (self.next() >> 11) as f64;
        bits / 9_007_199_254_740_992.0 // 2^53
    }

    /// Uniform in \[from, to).
    pub fn uniform(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.unit()
    }

    /// Normal with mean 0 (Box and Muller, 1958).
    pub fn normal(&mut self, deviation: f64) -> f64 {
        let radius = libm::sqrt(-2.0 * libm::log(1.0 - self.unit()));
        deviation * radius * libm::cos(core::f64::consts::TAU * self.unit())
    }

    /// True with a probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// One of a few.
    pub fn pick<T: Copy, const N: usize>(&mut self, from: [T; N]) -> T {
        const { assert!(N > 0) };
        let at = self.next() % N as u64;
        from[usize::try_from(at).unwrap_or_default()]
    }
}

const GAMMA: u64 = 0x9e37_79b9_7f4a_7c15;

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod test {
    use super::*;

    #[test]
    fn the_generator_gives_the_published_numbers() {
        // the first outputs of the reference implementation for the state 1234567
        let mut random = Random(1_234_567);
        let first: [u64; 3] = core::array::from_fn(|_| random.next());
        assert_eq!(
            first,
            [
                6_457_827_717_110_365_317,
                3_203_168_211_198_807_973,
                9_817_491_932_198_370_423
            ]
        );
    }

    #[test]
    fn moments_are_those_of_the_distributions() {
        const COUNT: usize = 100_000;
        let mut random = Random::new(1, 2, 3);
        let moments = |draw: &mut dyn FnMut() -> f64| {
            let (mut sum, mut squares) = (0.0, 0.0);
            for _ in 0..COUNT {
                let x = draw();
                (sum, squares) = (sum + x, squares + x * x);
            }
            (sum / 1e5, squares / 1e5)
        };
        // five standard errors: 5·4/√1e5 of the mean, 5·16·√2/√1e5 of the square
        let (mean, square) = moments(&mut || random.normal(4.0));
        assert!(
            mean.abs() < 0.064 && (square - 16.0).abs() < 0.36,
            "{mean} {square}"
        );
        let (mean, square) = moments(&mut || random.uniform(-1.0, 3.0));
        assert!(
            (mean - 1.0).abs() < 0.019 && (square - 7.0 / 3.0).abs() < 0.05,
            "{mean} {square}"
        );
    }

    #[test]
    fn streams_differ_in_seed_class_and_index() {
        let first = |s, c, i| Random::new(s, c, i).next();
        let base = first(1, 1, 1);
        assert_eq!(base, first(1, 1, 1));
        assert!(
            [first(2, 1, 1), first(1, 2, 1), first(1, 1, 2)]
                .iter()
                .all(|x| *x != base)
        );
    }
}
