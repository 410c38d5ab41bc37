//! Bodies that stand in the way: the distance of a point from their surface, and where the surface faces.

use libm::sqrt;
use motion::Pose;
use nalgebra::Vector3;

/// A rigid body fixed in the robot's base frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// All that is behind a plane.
    HalfSpace {
        /// A point of the plane, m.
        point: Vector3<f64>,
        /// Away from the body; a unit vector.
        normal: Vector3<f64>,
    },
    /// A box about the origin of its frame, along its axes.
    Box {
        /// Its frame in the base frame.
        frame: Pose,
        /// Half of its edges, m.
        half: Vector3<f64>,
    },
    /// A cylinder about the origin of its frame, along its z.
    Cylinder {
        /// Its frame in the base frame.
        frame: Pose,
        /// m.
        radius: f64,
        /// Half of its length, m.
        half_length: f64,
    },
    /// A round edge, or a taut wire: all within a radius of a line without end.
    Edge {
        /// A point of the line, m.
        point: Vector3<f64>,
        /// A unit vector along it.
        direction: Vector3<f64>,
        /// m.
        radius: f64,
    },
}

/// Where a point is to a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Distance from the surface, m; negative inside the body.
    pub metres: f64,
    /// The direction in which it grows fastest: a unit vector, outwards.
    pub normal: Vector3<f64>,
}

impl Shape {
    /// The signed distance of a point, m in the base frame, and its gradient. On an edge of the body, or in its very
    /// middle, one of the possible directions.
    #[must_use]
    pub fn distance(&self, point: &Vector3<f64>) -> Distance {
        match self {
            Self::HalfSpace {
                point: foot,
                normal,
            } => Distance {
                metres: normal.dot(&(point - foot)),
                normal: *normal,
            },
            Self::Box { frame, half } => {
                let inside = frame.rotation.tr_mul(&(point - frame.position));
                let Distance { metres, normal } = of_box(&inside, half);
                Distance {
                    metres,
                    normal: frame.rotation * normal,
                }
            }
            Self::Cylinder {
                frame,
                radius,
                half_length,
            } => {
                let p = frame.rotation.tr_mul(&(point - frame.position));
                // in the half plane of the axis and the point: a rectangle
                let from_axis = sqrt(p.x * p.x + p.y * p.y);
                let flat = of_box(
                    &Vector3::new(from_axis, 0.0, p.z),
                    &Vector3::new(*radius, f64::INFINITY, *half_length),
                );
                let (x, y) = unit(p.x, p.y, from_axis);
                let n = flat.normal;
                Distance {
                    metres: flat.metres,
                    normal: frame.rotation * Vector3::new(x * n.x, y * n.x, n.z),
                }
            }
            Self::Edge {
                point: foot,
                direction,
                radius,
            } => {
                let off = point - foot;
                let across = off - direction * direction.dot(&off);
                let length = sqrt(across.dot(&across));
                Distance {
                    metres: length - radius,
                    normal: if length > 0.0 {
                        across / length
                    } else {
                        perpendicular(direction)
                    },
                }
            }
        }
    }
}

fn unit(x: f64, y: f64, length: f64) -> (f64, f64) {
    if length > 0.0 {
        (x / length, y / length)
    } else {
        (1.0, 0.0)
    }
}

/// Any unit vector at a right angle to a unit vector.
fn perpendicular(direction: &Vector3<f64>) -> Vector3<f64> {
    let other = if libm::fabs(direction.x) < 0.5 {
        Vector3::x()
    } else {
        Vector3::y()
    };
    let across = direction.cross(&other);
    across / sqrt(across.dot(&across))
}

/// The point nearest to a box outside it is that of clamped coordinates; inside, the nearest face decides.
fn of_box(p: &Vector3<f64>, half: &Vector3<f64>) -> Distance {
    let beyond = Vector3::from_fn(|k, _| libm::fabs(p[k]) - half[k]);
    let out = beyond.map(|b| if b > 0.0 { b } else { 0.0 });
    let sign = p.map(|x| if x < 0.0 { -1.0 } else { 1.0 });
    let length = sqrt(out.dot(&out));
    if length > 0.0 {
        return Distance {
            metres: length,
            normal: out.component_mul(&sign) / length,
        };
    }
    let mut nearest = 0;
    for k in 1..3 {
        if beyond[k] > beyond[nearest] {
            nearest = k;
        }
    }
    let mut normal = Vector3::zeros();
    normal[nearest] = sign[nearest];
    Distance {
        metres: beyond[nearest],
        normal,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix3;
    use proptest::prelude::*;

    fn frame() -> Pose {
        let (s, c) = libm::sincos(0.5);
        Pose {
            position: Vector3::new(0.1, -0.2, 0.3),
            rotation: Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0),
        }
    }

    fn shapes() -> [Shape; 4] {
        let (s, c) = libm::sincos(0.3);
        [
            Shape::HalfSpace {
                point: Vector3::new(0.0, 0.0, 0.1),
                normal: Vector3::new(s, 0.0, c),
            },
            Shape::Box {
                frame: frame(),
                half: Vector3::new(0.3, 0.2, 0.1),
            },
            Shape::Cylinder {
                frame: frame(),
                radius: 0.2,
                half_length: 0.3,
            },
            Shape::Edge {
                point: Vector3::new(0.1, 0.0, 0.0),
                direction: Vector3::new(0.0, s, c),
                radius: 0.05,
            },
        ]
    }

    #[test]
    fn distances_of_known_points() {
        let at = |shape: &Shape, x, y, z| shape.distance(&Vector3::new(x, y, z)).metres;
        let cube = Shape::Box {
            frame: Pose::identity(),
            half: Vector3::new(1.0, 1.0, 1.0),
        };
        let can = Shape::Cylinder {
            frame: Pose::identity(),
            radius: 1.0,
            half_length: 2.0,
        };
        let cases = [
            (at(&cube, 0.0, 0.0, 0.9), -0.1),
            (at(&cube, 2.0, 0.0, 0.0), 1.0),
            (at(&cube, 2.0, 2.0, 2.0), sqrt(3.0)),
            (at(&can, 0.0, 0.0, 0.0), -1.0),
            (at(&can, 0.0, 3.0, 0.0), 2.0),
            (at(&can, 0.0, 0.0, 2.5), 0.5),
            (at(&can, 4.0, 0.0, 6.0), 5.0),
        ];
        for (k, (got, expected)) in cases.iter().enumerate() {
            assert!((got - expected).abs() < 1e-12, "{k}: {got} {expected}");
        }
    }

    proptest! {
        /// The normal is a unit vector, and walking the distance back along it ends on the surface, from outside
        /// and from just inside.
        #[test]
        fn the_normal_leads_to_the_surface(p in prop::array::uniform3(-1.0..1.0f64)) {
            let point = Vector3::from(p);
            for shape in shapes() {
                let Distance { metres, normal } = shape.distance(&point);
                prop_assert!((normal.dot(&normal) - 1.0).abs() < 1e-12);
                let foot = shape.distance(&(point - normal * metres));
                prop_assert!(foot.metres.abs() < 1e-9, "{shape:?} {metres} {}", foot.metres);
            }
        }

        /// A signed distance changes by no more than one walks.
        #[test]
        fn nearby_points_have_nearby_distances(
            p in prop::array::uniform3(-1.0..1.0f64),
            by in prop::array::uniform3(-0.1..0.1f64),
        ) {
            let (point, step) = (Vector3::from(p), Vector3::from(by));
            for shape in shapes() {
                let change = shape.distance(&(point + step)).metres - shape.distance(&point).metres;
                prop_assert!(change.abs() <= sqrt(step.dot(&step)) + 1e-12);
            }
        }
    }
}
