//! Velocities after an impulse on axes that are coupled by a mass matrix, with dry friction, brakes
//! and stops.
//!
//! With A = M + dt·B (mass matrix and viscous friction), b = M·v + dt·(torques − bias) and d = dt·(dry
//! friction with the brake's), the velocities v sought are those at which friction opposes every motion
//! and holds, within its bound, what stands; a stop takes what would go beyond it. These are the conditions
//! of the one least value of
//!
//! ```text
//!   ½·vᵀ·A·v − bᵀ·v + Σ d·|v|,   low ≤ v ≤ high
//! ```
//!
//! which exists since A is positive definite. So friction never turns a motion round and never adds energy,
//! a brake that is overloaded slips, and an axis that is held passes on what it is held with.
//!
//! Found by an active set: every axis is taken to slide one way, to stick or to be at a stop, the rest is a
//! system of linear equations, and axes that contradict what they were taken for change. What they were
//! in the last substep is nearly always right. Where that does not end in [`ROUNDS`], [`SWEEPS`] rounds of
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

    /// The impulse of friction on it, N·m·s, where it slides.
    const fn friction(self, dry: f64) -> f64 {
        match self {
            Self::Forward => -dry,
            Self::Backward => dry,
            Self::Stuck | Self::Low | Self::High => 0.0,
        }
    }

    /// What it must be where it has the velocity `v`, and `rest` = b − A·v is left to friction and stop.
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

/// The velocities, rad/s. `a` is symmetric and positive definite; `contacts` is what the axes did last and
/// becomes what they do now.
pub(crate) fn velocities<const N: usize>(
    a: &[[f64; N]; N],
    b: &[f64; N],
    restraints: &[Restraint; N],
    contacts: &mut [Contact; N],
) -> [f64; N] {
    let mut v = match settled(a, b, restraints, contacts) {
        Ok(v) => return v,
        Err(v) => v,
    };
    descend(a, b, restraints, &mut v);
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
    settled(a, b, restraints, &mut near).map_or(v, |exact| {
        *contacts = near;
        exact
    })
}

/// The velocities once no axis contradicts what it was taken for; the last ones if that is not so in
/// [`ROUNDS`].
fn settled<const N: usize>(
    a: &[[f64; N]; N],
    b: &[f64; N],
    restraints: &[Restraint; N],
    contacts: &mut [Contact; N],
) -> Result<[f64; N], [f64; N]> {
    let mut v = [0.0; N];
    for _ in 0..ROUNDS {
        v = with_contacts(a, b, restraints, contacts);
        let mut settled = true;
        for k in 0..N {
            let rest = b[k] - dot(&a[k], &v);
            let corrected = contacts[k].corrected(v[k], rest, &restraints[k]);
            settled &= corrected == contacts[k];
            contacts[k] = corrected;
        }
        if settled {
            return Ok(v);
        }
    }
    Err(v)
}

fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The velocities if every axis does what it is taken to do: A = L·D·Lᵀ without the axes whose velocity is
/// known.
fn with_contacts<const N: usize>(
    a: &[[f64; N]; N],
    b: &[f64; N],
    restraints: &[Restraint; N],
    contacts: &[Contact; N],
) -> [f64; N] {
    let mut v = [0.0; N];
    let mut free = [0; N];
    let mut count = 0;
    for k in 0..N {
        if let Some(known) = contacts[k].fixed(&restraints[k]) {
            v[k] = known;
        } else {
            free[count] = k;
            count += 1;
        }
    }
    let free = &free[..count];
    let mut l = [[0.0; N]; N];
    let mut y = [0.0; N];
    for (i, &row) in free.iter().enumerate() {
        // what axes of known velocity take; free ones are still 0 in v
        let mut right = b[row] + contacts[row].friction(restraints[row].dry) - dot(&a[row], &v);
        let mut diagonal = a[row][row];
        for (j, &column) in free.iter().enumerate().take(i) {
            let mut entry = a[row][column];
            for (k, pivot) in l.iter().enumerate().take(j) {
                entry -= l[i][k] * l[j][k] * pivot[k];
            }
            let ratio = entry / l[j][j];
            l[i][j] = ratio;
            diagonal -= ratio * entry;
            right -= ratio * y[j];
        }
        l[i][i] = diagonal;
        y[i] = right;
    }
    for i in (0..count).rev() {
        let mut x = y[i] / l[i][i];
        for j in i + 1..count {
            x -= l[j][i] * v[free[j]];
        }
        v[free[i]] = x;
    }
    v
}

/// Coordinate descent: every step is the least value along one axis.
fn descend<const N: usize>(
    a: &[[f64; N]; N],
    b: &[f64; N],
    restraints: &[Restraint; N],
    v: &mut [f64; N],
) {
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
