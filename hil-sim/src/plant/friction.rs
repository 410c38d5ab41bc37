//! Velocities after an impulse on axes that are coupled by a mass matrix, with dry friction, brakes
//! and stops.
//!
//! With w the velocities that weight and inertia alone would leave, A = M + dt·B (mass matrix and viscous
//! friction), p = dt·(torques − B·w) and d = dt·(dry friction with the brake's), the velocities v sought are
//! those at which friction opposes every motion and holds, within its bound, what stands; a stop takes what
//! would go beyond it. These are the conditions of the one least value of
//!
//! ```text
//!   ½·(v − w)ᵀ·A·(v − w) − pᵀ·v + Σ d·|v|,   low ≤ v ≤ high
//! ```
//!
//! which exists since A is positive definite. So friction never turns a motion round and never adds energy,
//! a brake that is overloaded slips, and an axis that is held passes on what it is held with.
//!
//! Found by an active set: every axis is taken to slide one way, to stick or to be at a stop, the rest is a
//! system of linear equations, and axes that contradict what they were taken for change. What they were
//! in the last substep is nearly always right, and its factors are kept while A is the same. Where that does not end in [`ROUNDS`], [`SWEEPS`] rounds of
//! coordinate descent follow, which can only get nearer, and the active set once more.

/// Rounds of the active set; two are the most in ordinary motion.
const ROUNDS: u32 = 16;
/// Rounds of coordinate descent where the active set does not settle.
const SWEEPS: u32 = 50;

/// What holds an axis back in one substep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Restraint {
    /// d: impulse of dry friction and brake, N·m·s; not negative.
    pub(crate) dry: f64,
    /// Least velocity that does not pass the lower stop, rad/s; not positive.
    pub(crate) low: f64,
    /// Greatest velocity that does not pass the upper stop, rad/s; not negative.
    pub(crate) high: f64,
}

impl Restraint {
    /// Nothing holds it.
    pub(crate) const NONE: Self = Self {
        dry: 0.0,
        low: f64::NEG_INFINITY,
        high: f64::INFINITY,
    };
}

/// What an axis is taken to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Contact {
    /// It stands, friction holds it.
    Stuck,
    Forward,
    Backward,
    /// It is at its lower or upper stop by the end of the substep.
    Low,
    High,
}

impl Contact {
    /// The velocity it has by that, rad/s, if it has one.
    const fn fixed(self, restraint: &Restraint) -> Option<f64> {
        match self {
            Self::Stuck => Some(0.0),
            Self::Low => Some(restraint.low),
            Self::High => Some(restraint.high),
            Self::Forward | Self::Backward => None,
        }
    }

    /// Is its velocity that of what holds it?
    pub(crate) const fn is_held(self) -> bool {
        match self {
            Self::Stuck | Self::Low | Self::High => true,
            Self::Forward | Self::Backward => false,
        }
    }

    /// The impulse of friction on it, N·m·s, where it slides.
    const fn friction(self, dry: f64) -> f64 {
        match self {
            Self::Forward => -dry,
            Self::Backward => dry,
            Self::Stuck | Self::Low | Self::High => 0.0,
        }
    }

    /// What it must be where it has the velocity `v`, and `rest` = p − A·(v − w) is left to friction and stop.
    fn corrected(self, v: f64, rest: f64, r: &Restraint) -> Self {
        match self {
            Self::Forward if v < 0.0 => Self::Stuck,
            Self::Forward if v > r.high => Self::High,
            Self::Backward if v > 0.0 => Self::Stuck,
            Self::Backward if v < r.low => Self::Low,
            Self::Stuck if rest > r.dry && r.high > 0.0 => Self::Forward,
            Self::Stuck if rest < -r.dry && r.low < 0.0 => Self::Backward,
            // a stop pushes away from it only; at rest at the stop, friction helps
            Self::High if rest < r.dry => Self::released(r.high, Self::Forward),
            Self::Low if rest > -r.dry => Self::released(r.low, Self::Backward),
            kept => kept,
        }
    }

    fn released(at: f64, sliding: Self) -> Self {
        // exact: the bound of an axis that is at its stop is the number 0
        if at == 0.0 { Self::Stuck } else { sliding }
    }
}

/// A, and its factors without the axes whose velocity is known.
#[derive(Clone, Debug)]
pub(crate) struct System<const N: usize> {
    a: [[f64; N]; N],
    factors: Option<Factors<N>>,
}

/// L·D·Lᵀ of A with the rows and columns of known axes replaced by those of the identity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Factors<const N: usize> {
    known: [bool; N],
    /// Below the diagonal.
    l: [[f64; N]; N],
    /// The inverse of D.
    inverse: [f64; N],
}

impl<const N: usize> System<N> {
    /// `a` is symmetric and positive definite.
    pub(crate) const fn new(a: [[f64; N]; N]) -> Self {
        Self { a, factors: None }
    }

    /// Adds dt·`drag`, symmetric and positive semidefinite, to A.
    pub(crate) fn resist(&mut self, drag: &[[f64; N]; N], dt_s: f64) {
        self.factors = None;
        for (row, drag) in self.a.iter_mut().zip(drag) {
            for (a, drag) in row.iter_mut().zip(drag) {
                *a += dt_s * drag;
            }
        }
    }

    /// The velocities, rad/s, from `free` = w and `push` = p; `contacts` is what the axes did last and becomes
    /// what they do now.
    pub(crate) fn velocities(
        &mut self,
        free: &[f64; N],
        push: &[f64; N],
        restraints: &[Restraint; N],
        contacts: &mut [Contact; N],
    ) -> [f64; N] {
        let mut v = match self.settled(free, push, restraints, contacts) {
            Ok(v) => return v,
            Err(v) => v,
        };
        descend(&self.a, free, push, restraints, &mut v);
        for ((contact, v), r) in contacts.iter_mut().zip(v).zip(restraints) {
            *contact = if v >= r.high && v > 0.0 {
                Contact::High
            } else if v <= r.low && v < 0.0 {
                Contact::Low
            } else if v > 0.0 {
                Contact::Forward
            } else if v < 0.0 {
                Contact::Backward
            } else {
                Contact::Stuck
            };
        }
        // from so near it nearly always ends; what it found is exact then
        let mut near = *contacts;
        match self.settled(free, push, restraints, &mut near) {
            Ok(exact) => {
                *contacts = near;
                exact
            }
            Err(_) => v,
        }
    }

    /// The velocities once no axis contradicts what it was taken for; the last ones if that is not so in
    /// [`ROUNDS`].
    fn settled(
        &mut self,
        free: &[f64; N],
        push: &[f64; N],
        restraints: &[Restraint; N],
        contacts: &mut [Contact; N],
    ) -> Result<[f64; N], [f64; N]> {
        let mut v = [0.0; N];
        for _ in 0..ROUNDS {
            let gain = self.gains(free, push, restraints, contacts);
            let mut settled = true;
            for k in 0..N {
                let (rest, at) = match contacts[k].fixed(&restraints[k]) {
                    Some(known) => (push[k] - dot(&self.a[k], &gain), known),
                    None => (0.0, free[k] + gain[k]),
                };
                v[k] = at;
                let corrected = contacts[k].corrected(at, rest, &restraints[k]);
                settled &= corrected == contacts[k];
                contacts[k] = corrected;
            }
            if settled {
                return Ok(v);
            }
        }
        Err(v)
    }

    /// v − w if every axis does what it is taken to do.
    fn gains(
        &mut self,
        free: &[f64; N],
        push: &[f64; N],
        restraints: &[Restraint; N],
        contacts: &[Contact; N],
    ) -> [f64; N] {
        let mut known = [false; N];
        let mut x = [0.0; N];
        let mut any = false;
        for k in 0..N {
            match contacts[k].fixed(&restraints[k]) {
                Some(velocity) => {
                    (known[k], any) = (true, true);
                    x[k] = velocity - free[k];
                }
                None => x[k] = push[k] + contacts[k].friction(restraints[k].dry),
            }
        }
        if any {
            let fixed: [f64; N] = core::array::from_fn(|k| if known[k] { x[k] } else { 0.0 });
            for k in 0..N {
                if !known[k] {
                    x[k] -= dot(&self.a[k], &fixed);
                }
            }
        }
        let factors = match &self.factors {
            Some(factors) if factors.known == known => factors,
            _ => self.factors.insert(Factors::new(&self.a, known)),
        };
        factors.solve(x)
    }
}

impl<const N: usize> Factors<N> {
    /// Of `a`, symmetric and positive definite, without the `known` axes.
    pub(crate) fn new(a: &[[f64; N]; N], known: [bool; N]) -> Self {
        let mut l = *a;
        if known.contains(&true) {
            for i in 0..N {
                for k in 0..N {
                    if known[i] || known[k] {
                        l[i][k] = 0.0;
                    }
                }
                if known[i] {
                    l[i][i] = 1.0;
                }
            }
        }
        let mut inverse = [0.0; N];
        for j in 0..N {
            let pivot = 1.0 / l[j][j];
            inverse[j] = pivot;
            let column: [f64; N] = core::array::from_fn(|i| l[i][j]);
            for i in j + 1..N {
                let ratio = column[i] * pivot;
                // entries after the diagonal change too, and are never read
                for k in j + 1..N {
                    l[i][k] -= ratio * column[k];
                }
                l[i][j] = ratio;
            }
        }
        Self { known, l, inverse }
    }

    /// A⁻¹·x; the entries of known axes stay.
    pub(crate) fn solve(&self, mut x: [f64; N]) -> [f64; N] {
        for j in 0..N {
            for i in j + 1..N {
                x[i] -= self.l[i][j] * x[j];
            }
        }
        for (x, inverse) in x.iter_mut().zip(self.inverse) {
            *x *= inverse;
        }
        for j in (0..N).rev() {
            for i in 0..j {
                x[i] -= self.l[j][i] * x[j];
            }
        }
        x
    }
}

fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Coordinate descent: every step is the least value along one axis.
fn descend<const N: usize>(
    a: &[[f64; N]; N],
    free: &[f64; N],
    push: &[f64; N],
    restraints: &[Restraint; N],
    v: &mut [f64; N],
) {
    let b: [f64; N] = core::array::from_fn(|k| push[k] + dot(&a[k], free));
    for (v, r) in v.iter_mut().zip(restraints) {
        *v = v.clamp(r.low, r.high);
    }
    for _ in 0..SWEEPS {
        for k in 0..N {
            let r = restraints[k];
            let pull = b[k] - dot(&a[k], v) + a[k][k] * v[k];
            let slides = if pull > r.dry {
                pull - r.dry
            } else if pull < -r.dry {
                pull + r.dry
            } else {
                0.0
            };
            v[k] = (slides / a[k][k]).clamp(r.low, r.high);
        }
    }
}

#[cfg(test)]
mod tests;
