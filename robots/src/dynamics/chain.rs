//! A serial chain of rigid bodies, and where its links are.

use motion::Pose;
use nalgebra::{Matrix3, SMatrix, Vector3};

use super::algebra::{Columns, IDENTITY, Triple, add, outward, product, scale};
use super::body::{Body, Moments, Shape};
use crate::description::JointKind;
use crate::space::Joints;

/// A fixed pose of one frame in another, as a constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Origin of the inner frame in the outer one, m.
    pub position_m: [f64; 3],
    /// Axes of the inner frame along those of the outer one: x, y, z; orthonormal, right-handed.
    pub axes: [[f64; 3]; 3],
}

impl Placement {
    /// The same frame.
    pub const IDENTITY: Self = Self {
        position_m: [0.0; 3],
        axes: IDENTITY,
    };

    /// The same axes, moved.
    #[must_use]
    pub const fn at(x: f64, y: f64, z: f64) -> Self {
        Self {
            position_m: [x, y, z],
            axes: IDENTITY,
        }
    }

    /// As a pose.
    #[must_use]
    pub fn pose(&self) -> Pose {
        Pose {
            position: self.position_m.into(),
            rotation: self.axes.into(),
        }
    }
}

/// A link with the joint that carries it. The joint's axis is the link's z: it turns about it, or
/// slides along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// What people call it.
    pub name: &'static str,
    /// How its joint moves.
    pub kind: JointKind,
    /// The link's frame in that of the link before it (the base for the first), at joint position 0.
    pub placement: Placement,
    /// What it is taken to look like.
    pub shape: Shape,
    body: Body,
    moments: Moments,
}

impl Link {
    /// A homogeneous link of a mass, kg.
    #[must_use]
    pub const fn new(
        name: &'static str,
        kind: JointKind,
        placement: Placement,
        mass_kg: f64,
        shape: Shape,
    ) -> Self {
        let body = Body::homogeneous(mass_kg, &shape);
        Self {
            name,
            kind,
            placement,
            shape,
            body,
            moments: body.moments(),
        }
    }

    /// Its mass, centre and inertia in its frame, with any payload.
    #[must_use]
    pub const fn body(&self) -> &Body {
        &self.body
    }

    pub(super) const fn moments(&self) -> &Moments {
        &self.moments
    }

    /// The link's frame in that of the link before it.
    #[inline]
    fn placed(&self, q: f64) -> Placed {
        let Placement { position_m, axes } = self.placement;
        let [x, y, z] = axes;
        match self.kind {
            JointKind::Revolute => {
                let (s, c) = libm::sincos(q);
                Placed {
                    axes: [
                        add(scale(c, x), scale(s, y)),
                        add(scale(c, y), scale(-s, x)),
                        z,
                    ],
                    offset: position_m,
                }
            }
            JointKind::Prismatic => Placed {
                axes,
                offset: add(position_m, scale(q, z)),
            },
        }
    }
}

/// A serial chain of rigid bodies: N links, each on the one before it, and a flange on the last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chain<const N: usize> {
    /// The links, base first.
    pub links: [Link; N],
    /// The flange in the frame of the last link.
    pub flange: Placement,
}

impl<const N: usize> Chain<N> {
    /// The same chain with a body bolted to its flange; `body` is given in the flange's frame.
    ///
    /// It becomes part of the last link, so it costs nothing afterwards.
    #[must_use]
    pub fn with_payload(&self, body: &Body) -> Self {
        let mut loaded = *self;
        let Placement { position_m, axes } = self.flange;
        if let Some(last) = loaded.links.last_mut() {
            let added = body.moments().moved(&axes, position_m);
            last.moments = last.moments.plus(added);
            last.body = last.moments.body();
        }
        loaded
    }

    /// The chain at joint positions, rad or m: every sine and cosine is taken here, once.
    #[must_use]
    pub fn at(&self, joints: &Joints<N>) -> Posture<'_, N> {
        let mut joints = joints.0.into_iter();
        let placed = self
            .links
            .each_ref()
            .map(|link| link.placed(joints.next().unwrap_or(0.0)));
        Posture {
            chain: self,
            placed,
        }
    }
}

impl Moments {
    /// The moments in a frame in which theirs has these axes and this origin. With h' = R·h:
    /// ∫(p + R·r)(p + R·r)ᵀ dm = R·Σ·Rᵀ + h'·pᵀ + p·h'ᵀ + m·p·pᵀ.
    #[inline]
    pub(super) const fn moved(&self, axes: &Columns, origin: Triple) -> Self {
        let first = outward(axes, self.first);
        let k = add(first, scale(0.5 * self.mass, origin));
        Self {
            mass: self.mass,
            first: add(first, scale(self.mass, origin)),
            second: self
                .second
                .turned(axes)
                .plus(super::algebra::Symmetric::outer(k, origin)),
        }
    }
}

/// A link's frame in that of the link before it, at a joint position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placed {
    pub(super) axes: Columns,
    pub(super) offset: Triple,
}

/// A chain at fixed joint positions: what all its equations share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posture<'a, const N: usize> {
    pub(super) chain: &'a Chain<N>,
    pub(super) placed: [Placed; N],
}

impl<const N: usize> Posture<'_, N> {
    /// The frame of every link in the base frame.
    #[must_use]
    pub fn link_poses(&self) -> [Pose; N] {
        let mut poses = [Pose::identity(); N];
        let (mut axes, mut origin) = (IDENTITY, [0.0; 3]);
        for (pose, placed) in poses.iter_mut().zip(&self.placed) {
            origin = add(origin, outward(&axes, placed.offset));
            axes = product(&axes, &placed.axes);
            *pose = Pose {
                position: Vector3::from(origin),
                rotation: Matrix3::from(axes),
            };
        }
        poses
    }

    /// The flange in the base frame.
    #[must_use]
    pub fn flange(&self) -> Pose {
        let last = self.link_poses().last().copied();
        last.unwrap_or_else(Pose::identity) * self.chain.flange.pose()
    }

    /// Geometric Jacobian of the flange in the base frame: rows 0–2 linear velocity, m/s, rows 3–5
    /// angular velocity, rad/s, per rad/s or m/s of each joint.
    ///
    /// A joint that turns about the unit vector w through the point o moves the flange's origin p at
    /// w × (p − o); one that slides along w at w.
    #[must_use]
    pub fn jacobian(&self) -> SMatrix<f64, 6, N> {
        let poses = self.link_poses();
        let last = poses.last().copied().unwrap_or_else(Pose::identity);
        let tip = (last * self.chain.flange.pose()).position;
        let mut jacobian = SMatrix::<f64, 6, N>::zeros();
        for ((mut column, pose), link) in jacobian
            .column_iter_mut()
            .zip(&poses)
            .zip(&self.chain.links)
        {
            let [.., axis] = pose.rotation.data.0.map(Vector3::from);
            let (linear, angular) = match link.kind {
                JointKind::Revolute => (axis.cross(&(tip - pose.position)), axis),
                JointKind::Prismatic => (axis, Vector3::zeros()),
            };
            for (entry, value) in column.iter_mut().zip(linear.iter().chain(angular.iter())) {
                *entry = *value;
            }
        }
        jacobian
    }
}
