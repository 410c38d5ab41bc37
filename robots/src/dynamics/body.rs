//! Rigid bodies: simple shapes, their inertia, and the moments the equations of motion need.

use super::algebra::{Symmetric, Triple, add, cross, dot, scale, subtract};

/// A homogeneous body of simple shape, in the frame of its link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A solid cylinder whose axis runs from one point to another.
    Cylinder {
        /// Centre of one end, m.
        from: [f64; 3],
        /// Centre of the other end, m; not the same point.
        to: [f64; 3],
        /// m.
        radius: f64,
    },
    /// A solid box along the axes of the frame.
    Box {
        /// Its centre, m.
        centre: [f64; 3],
        /// Its edges along x, y and z, m.
        size: [f64; 3],
    },
}

/// The entries of an inertia matrix, kg·m²: `xx` = ∫(y² + z²) dm, `xy` = −∫x·y dm, and so on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia {
    /// About the x axis.
    pub xx: f64,
    /// About the y axis.
    pub yy: f64,
    /// About the z axis.
    pub zz: f64,
    /// Off the diagonal.
    pub xy: f64,
    /// Off the diagonal.
    pub xz: f64,
    /// Off the diagonal.
    pub yz: f64,
}

/// Mass, centre and inertia of a rigid body in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// kg.
    pub mass_kg: f64,
    /// Centre of mass, m.
    pub centre_m: [f64; 3],
    /// About the centre of mass, along the frame's axes.
    pub inertia: Inertia,
}

impl Body {
    /// A homogeneous body.
    ///
    /// With u the unit vector of a cylinder's axis, L its length and r its radius,
    /// I = m(3r² + L²)/12·(1 − u·uᵀ) + m·r²/2·u·uᵀ; for a box of edges a, b, c,
    /// I = m/12·diag(b² + c², a² + c², a² + b²) (any table of moments of inertia).
    #[must_use]
    pub const fn homogeneous(mass_kg: f64, shape: &Shape) -> Self {
        match *shape {
            Shape::Cylinder { from, to, radius } => {
                let d = subtract(to, from);
                let (length2, radius2) = (dot(d, d), radius * radius);
                let across = mass_kg * (3.0 * radius2 + length2) / 12.0;
                let along = mass_kg * radius2 / 2.0;
                let (of_u, [x, y, z]) = ((along - across) / length2, d);
                Self {
                    mass_kg,
                    centre_m: scale(0.5, add(from, to)),
                    inertia: Inertia {
                        xx: across + of_u * x * x,
                        yy: across + of_u * y * y,
                        zz: across + of_u * z * z,
                        xy: of_u * x * y,
                        xz: of_u * x * z,
                        yz: of_u * y * z,
                    },
                }
            }
            Shape::Box { centre, size } => {
                let (part, [a, b, c]) = (mass_kg / 12.0, size);
                Self {
                    mass_kg,
                    centre_m: centre,
                    inertia: Inertia {
                        xx: part * (b * b + c * c),
                        yy: part * (a * a + c * c),
                        zz: part * (a * a + b * b),
                        xy: 0.0,
                        xz: 0.0,
                        yz: 0.0,
                    },
                }
            }
        }
    }

    /// The body's moments about the origin of its frame.
    pub(super) const fn moments(&self) -> Moments {
        let Inertia {
            xx,
            yy,
            zz,
            xy,
            xz,
            yz,
        } = self.inertia;
        let half = 0.5 * (xx + yy + zz);
        let first = scale(self.mass_kg, self.centre_m);
        let about_centre = Symmetric {
            xx: half - xx,
            yy: half - yy,
            zz: half - zz,
            xy: -xy,
            xz: -xz,
            yz: -yz,
        };
        Moments {
            mass: self.mass_kg,
            first,
            second: about_centre.plus(Symmetric::outer(scale(0.5, first), self.centre_m)),
        }
    }
}

/// The ten integrals over a body: ∫dm, ∫r dm and ∫r·rᵀ dm, r from the origin of its frame; kg, kg·m,
/// kg·m². The inertia about that origin is tr(Σ)·1 − Σ with Σ the last of them. They add up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Moments {
    pub(super) mass: f64,
    pub(super) first: Triple,
    pub(super) second: Symmetric,
}

impl Moments {
    /// Of both bodies.
    #[inline]
    pub(super) const fn plus(self, other: Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            first: add(self.first, other.first),
            second: self.second.plus(other.second),
        }
    }

    /// The body these are the moments of; a massless one has its centre at the origin.
    pub(super) fn body(&self) -> Body {
        let centre_m = if self.mass > 0.0 {
            scale(1.0 / self.mass, self.first)
        } else {
            [0.0; 3]
        };
        let Symmetric {
            xx,
            yy,
            zz,
            xy,
            xz,
            yz,
        } = self
            .second
            .plus(Symmetric::outer(scale(-0.5, self.first), centre_m));
        Body {
            mass_kg: self.mass,
            centre_m,
            inertia: Inertia {
                xx: yy + zz,
                yy: xx + zz,
                zz: xx + yy,
                xy: -xy,
                xz: -xz,
                yz: -yz,
            },
        }
    }

    /// Rate of the linear momentum and of the angular momentum about the origin, N and N·m, where the
    /// origin accelerates by `a` and the points around it by E·r in addition (see [`field`]):
    /// f = ∫(a + E·r) dm = m·a + E·h, n = ∫r × (a + E·r) dm = h × a + axial(E·Σ), with
    /// axial(A) = (`A_zy` − `A_yz`, `A_xz` − `A_zx`, `A_yx` − `A_xy`).
    #[inline]
    pub(super) const fn rates(&self, a: Triple, e: &[Triple; 3]) -> (Triple, Triple) {
        let h = self.first;
        let [ex, ey, ez] = *e;
        let f = [
            self.mass * a[0] + dot(ex, h),
            self.mass * a[1] + dot(ey, h),
            self.mass * a[2] + dot(ez, h),
        ];
        let [sx, sy, sz] = self.second.columns();
        let n = [
            dot(ez, sy) - dot(ey, sz),
            dot(ex, sz) - dot(ez, sx),
            dot(ey, sx) - dot(ex, sy),
        ];
        (f, add(n, cross(h, a)))
    }
}

/// The rows of E = \[α×\] + \[ω×\]²: a point at r from the origin of a frame that turns by ω, rad/s, and
/// α, rad/s², accelerates by E·r more than the origin.
#[inline]
pub(super) const fn field([x, y, z]: Triple, [ax, ay, az]: Triple) -> [Triple; 3] {
    let (xx, yy, zz) = (x * x, y * y, z * z);
    let (xy, xz, yz) = (x * y, x * z, y * z);
    [
        [-yy - zz, xy - az, xz + ay],
        [xy + az, -xx - zz, yz - ax],
        [xz - ay, yz + ax, -xx - yy],
    ]
}
