//! Rational B-splines: the splines of every format.

use super::step::{distance, get};

/// The highest order, degree + 1: DXF files have up to 4, and G5.2 hardly more.
pub const MOST_ORDER: usize = 12;
/// The most control points of one spline.
pub const MOST_CONTROL: usize = 10_000;

/// A rational B-spline: control points with weights, and knots.
#[derive(Clone, Debug, PartialEq)]
pub struct Nurbs {
    order: usize,
    /// x·w, y·w, z·w (m) and w.
    control: Vec<[f64; 4]>,
    knots: Vec<f64>,
}

/// Why there is no such spline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NurbsError {
    /// The order is not from 2 to [`MOST_ORDER`], or there are fewer control points, or more than
    /// [`MOST_CONTROL`].
    Count,
    /// There are not as many knots as order and control points together.
    Knots,
    /// Knots decrease, or leave no span.
    Falling,
    /// A weight is not greater than 0.
    Weight,
    /// A number is not finite.
    NotFinite,
}

impl core::fmt::Display for NurbsError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Count => {
                "at least as many control points as its order, at most 10000, order 2 to 12"
            }
            Self::Knots => "as many knots as order and control points together",
            Self::Falling => "knots that do not fall, and some that rise",
            Self::Weight => "weights greater than 0",
            Self::NotFinite => "finite numbers",
        })
    }
}

impl core::error::Error for NurbsError {}

impl Nurbs {
    /// From control points x, y, z (m), their weights, and knots.
    ///
    /// # Errors
    /// [`NurbsError`]
    pub fn new(
        order: usize,
        control: impl IntoIterator<Item = ([f64; 3], f64)>,
        knots: Vec<f64>,
    ) -> Result<Self, NurbsError> {
        let control: Vec<[f64; 4]> = control
            .into_iter()
            .map(|([x, y, z], w)| [x * w, y * w, z * w, w])
            .collect();
        if !(2..=MOST_ORDER).contains(&order) || !(order..=MOST_CONTROL).contains(&control.len()) {
            return Err(NurbsError::Count);
        }
        if knots.len() != order + control.len() {
            return Err(NurbsError::Knots);
        }
        let mut numbers = control.iter().flatten().chain(&knots);
        if !numbers.all(|x| x.is_finite()) {
            return Err(NurbsError::NotFinite);
        }
        if !control.iter().all(|[.., w]| *w > 0.0) {
            return Err(NurbsError::Weight);
        }
        let this = Self {
            order,
            control,
            knots,
        };
        let (first, last) = this.range();
        let rising = this.knots.iter().zip(this.knots.iter().skip(1));
        if rising.into_iter().any(|(a, b)| a > b) || first >= last {
            return Err(NurbsError::Falling);
        }
        Ok(this)
    }

    /// With the knots 0 … 0, 1, 2, … n, n … n: it begins at the first control point and ends at the last.
    ///
    /// # Errors
    /// [`NurbsError`]
    pub fn clamped(
        order: usize,
        control: impl IntoIterator<Item = ([f64; 3], f64)>,
    ) -> Result<Self, NurbsError> {
        let control: Vec<_> = control.into_iter().collect();
        let spans = (control.len() + 1).saturating_sub(order);
        let count = control.len().min(MOST_CONTROL) + order.min(MOST_ORDER);
        let knot = |k: usize| {
            let knot = (k + 1).saturating_sub(order).min(spans);
            f64::from(u32::try_from(knot).unwrap_or(u32::MAX))
        };
        Self::new(order, control, (0..count).map(knot).collect())
    }

    /// A cubic Bézier curve.
    ///
    /// # Errors
    /// [`NurbsError::NotFinite`]
    pub fn bezier(points: [[f64; 3]; 4]) -> Result<Self, NurbsError> {
        Self::clamped(4, points.map(|point| (point, 1.0)))
    }

    /// The range of the parameter.
    fn range(&self) -> (f64, f64) {
        let knot = |k: usize| self.knots.get(k).copied().unwrap_or_default();
        (knot(self.order - 1), knot(self.control.len()))
    }

    /// Spans between knots.
    pub(super) fn spans(&self) -> u32 {
        u32::try_from(self.control.len() + 1 - self.order).unwrap_or(u32::MAX)
    }

    /// Intervals of its polygon.
    pub(super) fn polygon(&self) -> u32 {
        Self::POLYGON * self.spans()
    }

    /// Intervals of the polygon of a span.
    pub const POLYGON: u32 = 32;

    /// The length of its polygon, m.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        let count = self.polygon();
        let mut last = self.at(0.0);
        let mut sum = 0.0;
        for k in 1..=count {
            let next = self.at(f64::from(k) / f64::from(count));
            sum += distance(&last, &next);
            last = next;
        }
        sum
    }

    /// The point at a share of the parameter, from 0 to 1, m: de Boor's algorithm in homogeneous
    /// coordinates.
    #[must_use]
    pub fn at(&self, share: f64) -> [f64; 3] {
        let (first, last) = self.range();
        let t = first + (last - first) * share.clamp(0.0, 1.0);
        let knot = |k: usize| self.knots.get(k).copied().unwrap_or_default();
        let degree = self.order - 1;
        // the span of t: the last knot that is not above it, before the end
        let above = self.knots.partition_point(|knot| *knot <= t);
        let mut span = above
            .saturating_sub(1)
            .clamp(degree, self.control.len() - 1);
        while span > degree && knot(span) >= knot(span + 1) {
            span -= 1;
        }
        let mut d = [[0.0; 4]; MOST_ORDER];
        for (j, place) in d.iter_mut().enumerate().take(self.order) {
            let control = self.control.get(span + j - degree);
            *place = control.copied().unwrap_or_default();
        }
        for r in 1..self.order {
            let mut after = d.get(degree).copied().unwrap_or_default();
            for j in (r..self.order).rev() {
                let before = d.get(j - 1).copied().unwrap_or_default();
                let (low, high) = (knot(span + j - degree), knot(span + 1 + j - r));
                let width = high - low;
                let share = if width > 0.0 { (t - low) / width } else { 0.0 };
                if let Some(place) = d.get_mut(j) {
                    for (k, value) in place.iter_mut().enumerate() {
                        let (a, b) = (before.get(k), after.get(k));
                        let (a, b) = (a.copied().unwrap_or(0.0), b.copied().unwrap_or(0.0));
                        *value = a * (1.0 - share) + b * share;
                    }
                }
                after = before;
            }
        }
        let [x, y, z, w] = d.get(degree).copied().unwrap_or_default();
        if w > 0.0 {
            [x / w, y / w, z / w]
        } else {
            [0.0; 3]
        }
    }

    /// The same curve elsewhere.
    #[must_use]
    pub fn moved(&self, by: &[f64; 3]) -> Self {
        let control = self.control.iter().map(|[x, y, z, w]| {
            let [dx, dy, dz] = *by;
            [x + dx * w, y + dy * w, z + dz * w, *w]
        });
        Self {
            control: control.collect(),
            ..self.clone()
        }
    }

    /// Where its polynomials begin and end: shares of the parameter, from 0 to 1.
    pub fn breaks(&self) -> impl Iterator<Item = f64> + '_ {
        let (first, last) = self.range();
        let mut before = f64::NEG_INFINITY;
        let inner = self
            .knots
            .iter()
            .filter(move |knot| (first..=last).contains(*knot));
        inner.filter_map(move |knot| {
            let rises = *knot > before;
            before = *knot;
            rises.then_some((knot - first) / (last - first))
        })
    }
}

/// The rational quadratic of an elliptic arc: its ends, and where their tangents meet, by an angle
/// (rad, less than π) of the circle that the ellipse is an image of. The weight of the middle is the
/// cosine of half that angle.
///
/// # Errors
/// [`NurbsError`]
pub fn elliptic(
    from: [f64; 3],
    corner: [f64; 3],
    to: [f64; 3],
    angle: f64,
) -> Result<Nurbs, NurbsError> {
    let weight = libm::cos(0.5 * angle);
    Nurbs::clamped(3, [(from, 1.0), (corner, weight), (to, 1.0)])
}

/// An elliptic arc as rational quadratics of at most a quarter: `centre + cos t·a + sin t·b`.
///
/// # Errors
/// [`NurbsError`]
pub fn ellipse(
    centre: &[f64; 3],
    a: &[f64; 3],
    b: &[f64; 3],
    from: f64,
    angle: f64,
) -> Result<Vec<Nurbs>, NurbsError> {
    let at = |t: f64, stretch: f64| -> [f64; 3] {
        let (sin, cos) = (libm::sin(t) * stretch, libm::cos(t) * stretch);
        core::array::from_fn(|k| get(centre, k) + cos * get(a, k) + sin * get(b, k))
    };
    let count = super::step::steps(angle.abs() / core::f64::consts::FRAC_PI_2 - 1e-9);
    let part = angle / f64::from(count);
    (0..count)
        .map(|k| {
            let t = from + part * f64::from(k);
            let stretch = 1.0 / libm::cos(0.5 * part);
            elliptic(
                at(t, 1.0),
                at(t + 0.5 * part, stretch),
                at(t + part, 1.0),
                part,
            )
        })
        .collect()
}
