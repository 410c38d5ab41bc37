//! Three-vectors and rotations as plain arrays, so that a chain can be a constant.

/// A vector's coordinates along the axes of the frame it is given in.
pub(super) type Triple = [f64; 3];

/// A rotation by its columns: the axes of the inner frame along those of the outer one.
pub(super) type Columns = [Triple; 3];

pub(super) const IDENTITY: Columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

#[inline]
pub(super) const fn add([a, b, c]: Triple, [x, y, z]: Triple) -> Triple {
    [a + x, b + y, c + z]
}

#[inline]
pub(super) const fn subtract([a, b, c]: Triple, [x, y, z]: Triple) -> Triple {
    [a - x, b - y, c - z]
}

#[inline]
pub(super) const fn scale(by: f64, [x, y, z]: Triple) -> Triple {
    [by * x, by * y, by * z]
}

#[inline]
pub(super) const fn dot([a, b, c]: Triple, [x, y, z]: Triple) -> f64 {
    a * x + b * y + c * z
}

#[inline]
pub(super) const fn cross([a, b, c]: Triple, [x, y, z]: Triple) -> Triple {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

/// R·v: from the inner frame to the outer one.
#[inline]
pub(super) const fn outward([a, b, c]: &Columns, [x, y, z]: Triple) -> Triple {
    [
        a[0] * x + b[0] * y + c[0] * z,
        a[1] * x + b[1] * y + c[1] * z,
        a[2] * x + b[2] * y + c[2] * z,
    ]
}

/// Rᵀ·v: from the outer frame to the inner one.
#[inline]
pub(super) const fn inward([a, b, c]: &Columns, v: Triple) -> Triple {
    [dot(*a, v), dot(*b, v), dot(*c, v)]
}

/// R·S.
#[inline]
pub(super) const fn product(r: &Columns, [a, b, c]: &Columns) -> Columns {
    [outward(r, *a), outward(r, *b), outward(r, *c)]
}

/// A symmetric matrix by its six entries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Symmetric {
    pub(super) xx: f64,
    pub(super) yy: f64,
    pub(super) zz: f64,
    pub(super) xy: f64,
    pub(super) xz: f64,
    pub(super) yz: f64,
}

impl Symmetric {
    /// The columns, which are the rows.
    #[inline]
    pub(super) const fn columns(self) -> Columns {
        [
            [self.xx, self.xy, self.xz],
            [self.xy, self.yy, self.yz],
            [self.xz, self.yz, self.zz],
        ]
    }

    #[inline]
    pub(super) const fn plus(self, other: Self) -> Self {
        Self {
            xx: self.xx + other.xx,
            yy: self.yy + other.yy,
            zz: self.zz + other.zz,
            xy: self.xy + other.xy,
            xz: self.xz + other.xz,
            yz: self.yz + other.yz,
        }
    }

    /// k·pᵀ + p·kᵀ.
    #[inline]
    pub(super) const fn outer(k: Triple, p: Triple) -> Self {
        Self {
            xx: 2.0 * k[0] * p[0],
            yy: 2.0 * k[1] * p[1],
            zz: 2.0 * k[2] * p[2],
            xy: k[0] * p[1] + p[0] * k[1],
            xz: k[0] * p[2] + p[0] * k[2],
            yz: k[1] * p[2] + p[1] * k[2],
        }
    }

    /// R·S·Rᵀ: the same matrix along the axes of the outer frame.
    #[inline]
    pub(super) const fn turned(self, r: &Columns) -> Self {
        // columns of R·S; entry (i, j) of R·S·Rᵀ is row i of it times row j of R
        let [p, q, s] = product(r, &self.columns());
        let [a, b, c] = r;
        Self {
            xx: p[0] * a[0] + q[0] * b[0] + s[0] * c[0],
            yy: p[1] * a[1] + q[1] * b[1] + s[1] * c[1],
            zz: p[2] * a[2] + q[2] * b[2] + s[2] * c[2],
            xy: p[0] * a[1] + q[0] * b[1] + s[0] * c[1],
            xz: p[0] * a[2] + q[0] * b[2] + s[0] * c[2],
            yz: p[1] * a[2] + q[1] * b[2] + s[1] * c[2],
        }
    }
}
