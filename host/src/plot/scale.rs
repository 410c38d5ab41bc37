//! Ranges of values and round numbers in them.

/// Is the number one to draw? Beyond 1e12 nothing sensible can be.
pub(super) fn finite(value: f64) -> bool {
    value.abs() < 1e12
}

/// A range of values, never empty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range {
    pub(super) lower: f64,
    pub(super) upper: f64,
}

impl Range {
    /// The range of the finite values; −1 to 1 if there are none.
    pub(super) fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut range: Option<Self> = None;
        for value in values.filter(|value| finite(*value)) {
            let r = range.get_or_insert(Self {
                lower: value,
                upper: value,
            });
            if value < r.lower {
                r.lower = value;
            }
            if value > r.upper {
                r.upper = value;
            }
        }
        range.unwrap_or(Self {
            lower: -1.0,
            upper: 1.0,
        })
    }

    pub(super) fn span(self) -> f64 {
        self.upper - self.lower
    }

    /// Wider by a share on both sides, and at least `least` wide.
    pub(super) fn padded(self, share: f64, least: f64) -> Self {
        let span = self.span() * (1.0 + 2.0 * share);
        self.to_span(if span < least { least } else { span })
    }

    /// Of this span, about the same middle.
    pub(super) fn to_span(self, span: f64) -> Self {
        let middle = 0.5 * (self.lower + self.upper);
        Self {
            lower: middle - 0.5 * span,
            upper: middle + 0.5 * span,
        }
    }

    /// The round numbers inside, about `count` of them, as they are written.
    pub(super) fn ticks(self, count: u32) -> Vec<(f64, String)> {
        let rough = self.span() / f64::from(count);
        if rough <= 0.0 {
            return Vec::new();
        }
        let exponent = libm::floor(libm::log10(rough));
        let decade = libm::pow(10.0, exponent);
        let step = [1.0, 2.0, 5.0, 10.0]
            .into_iter()
            .map(|digit| digit * decade)
            .find(|step| *step >= rough * 0.999)
            .unwrap_or(10.0 * decade);
        let decimals = (0_u8..12)
            .find(|n| {
                let scaled = step * libm::pow(10.0, f64::from(*n));
                (scaled - libm::round(scaled)).abs() < 1e-6 * scaled
            })
            .unwrap_or(12);
        let first = libm::ceil(self.lower / step - 1e-9);
        (0_u32..=64)
            .map(|n| (first + f64::from(n)) * step)
            .take_while(|value| *value <= self.upper + 1e-9 * step)
            .map(|value| (value, written(value, decimals, step)))
            .collect()
    }
}

/// A tick with a real minus sign, and none on zero.
fn written(value: f64, decimals: u8, step: f64) -> String {
    let value = if value.abs() < 1e-9 * step {
        0.0
    } else {
        value
    };
    format!("{value:.*}", usize::from(decimals)).replace('-', "−")
}

#[cfg(test)]
mod test {
    use super::*;
    use proptest::prelude::*;

    fn labels(lower: f64, upper: f64, count: u32) -> Vec<String> {
        let ticks = Range { lower, upper }.ticks(count);
        ticks.into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(labels(-0.3, 0.31, 4), ["−0.2", "0.0", "0.2"]);
        assert_eq!(
            labels(0.0, 60.0, 6),
            ["0", "10", "20", "30", "40", "50", "60"]
        );
        assert_eq!(labels(1.0, 1.05, 3), ["1.00", "1.02", "1.04"]);
        assert_eq!(
            labels(-2e-6, 2e-6, 2),
            ["−0.000002", "0.000000", "0.000002"]
        );
    }

    proptest! {
        #[test]
        fn ticks_lie_inside_and_are_few(lower in -1e6..1e6f64, span in 1e-6..1e6f64, count in 2u32..12) {
            let range = Range { lower, upper: lower + span };
            let ticks = range.ticks(count);
            prop_assert!(ticks.len() <= count as usize + 1);
            for (value, _) in &ticks {
                prop_assert!(*value >= range.lower - 1e-6 * span && *value <= range.upper + 1e-6 * span);
            }
        }
    }

    #[test]
    fn what_is_not_finite_has_no_range() {
        let range = Range::of([f64::NAN, 3.0, f64::INFINITY, -1.0].into_iter());
        assert_eq!(
            range,
            Range {
                lower: -1.0,
                upper: 3.0
            }
        );
        assert_eq!(
            Range::of(std::iter::empty()),
            Range {
                lower: -1.0,
                upper: 1.0
            }
        );
        assert!(
            (Range {
                lower: 2.0,
                upper: 2.0
            }
            .padded(0.1, 0.5)
            .span()
                - 0.5)
                .abs()
                < 1e-12
        );
    }
}
