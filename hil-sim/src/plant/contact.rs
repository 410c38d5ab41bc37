//! Contact of a tool's tip with stiff bodies.
//!
//! The tip is a sphere at a point of the flange. Where it is p > 0 deep in a body, the surface pushes it along its
//! normal with the force of Hunt and Crossley ("Coefficient of restitution interpreted as damping in vibroimpact",
//! J. Appl. Mech. 42, 1975), here with exponent 1,
//!
//! ```text
//!   f = k·p·(1 + a·ṗ),   never less than 0
//! ```
//!
//! and holds it against sliding at velocity v with μ·f·v/max(|v|, v₀): Coulomb's law, made a steep slope below v₀.
//! The law's energy loss is that of a restitution of about 1 − 2/3·a·v for an impact at v.

mod shape;

pub use shape::{Distance, Shape};

use motion::Pose;
use nalgebra::{Matrix3, Vector3};
use robots::{Robot, RobotKind, RobotVisitor, TrackRule};

/// What a surface does to a tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// k, N/m.
    pub stiffness_n_m: f64,
    /// a, s/m.
    pub damping_s_m: f64,
    /// μ.
    pub friction: f64,
    /// v₀, m/s: below it sliding is resisted in proportion.
    pub creep_m_s: f64,
}

impl Surface {
    /// A metal surface. ASSUMED.
    pub const METAL: Self = Self {
        stiffness_n_m: 1.0e5,
        damping_s_m: 3.0,
        friction: 0.2,
        creep_m_s: 0.001,
    };
}

/// A body with its surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obstacle {
    /// What it is.
    pub shape: Shape,
    /// How it feels.
    pub surface: Surface,
}

/// A square plate that a tool can touch, as thick as a tenth of its edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plate {
    /// The middle of the face that is touched, in the robot's base frame, m.
    pub point_m: Vector3<f64>,
    /// Out of that face, of length 1.
    pub normal: Vector3<f64>,
    /// Its edge, m.
    pub edge_m: f64,
    /// N/m
    pub stiffness_n_m: f64,
}

impl Plate {
    /// The body it is, with the damping and friction of metal.
    #[must_use]
    pub fn obstacle(&self) -> Obstacle {
        let half = 0.5 * self.edge_m;
        let normal = self.normal;
        // any direction across it, for it is square
        let other = if normal.x.abs() < 0.5 {
            Vector3::x()
        } else {
            Vector3::y()
        };
        let side = normal.cross(&other).normalize();
        Obstacle {
            shape: Shape::Box {
                frame: Pose {
                    position: self.point_m - normal * (0.1 * half),
                    rotation: Matrix3::from_columns(&[side, normal.cross(&side), normal]),
                },
                half: Vector3::new(half, half, 0.1 * half),
            },
            surface: Surface {
                stiffness_n_m: self.stiffness_n_m,
                ..Surface::METAL
            },
        }
    }
}

/// The sphere at the end of a tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tip {
    /// Its centre in the flange's frame, m.
    pub centre_m: Vector3<f64>,
    /// m; 0 for a point.
    pub radius_m: f64,
}

impl Tip {
    /// The point at the end of the tool that a robot of this kind has where nothing else is said.
    #[must_use]
    pub fn of(kind: RobotKind) -> Self {
        struct Tool;
        impl RobotVisitor for Tool {
            type Output = Vector3<f64>;
            fn visit<R: Robot<N>, const N: usize>(self, robot: R) -> Vector3<f64> {
                robot.description().default_tool().position
            }
        }
        Self {
            centre_m: kind.visit(TrackRule::Keep, Tool),
            radius_m: 0.0,
        }
    }
}

/// How one body pushes a tip at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Touch {
    /// Outwards.
    pub(super) normal: Vector3<f64>,
    /// Along the normal, N; not negative.
    pub(super) push_n: f64,
    /// Resistance to sliding, N·s/m; not negative.
    pub(super) drag_ns_m: f64,
}

impl Obstacle {
    /// How it pushes a tip whose centre is at `centre` and moves at `velocity`, m and m/s in the base frame; none
    /// where they do not touch.
    pub(super) fn touch(
        &self,
        centre: &Vector3<f64>,
        velocity: &Vector3<f64>,
        radius_m: f64,
    ) -> Option<Touch> {
        let Distance { metres, normal } = self.shape.distance(centre);
        let depth = radius_m - metres;
        if depth > 0.0 {
            let surface = &self.surface;
            let away = normal.dot(velocity);
            let push = surface.stiffness_n_m * depth * (1.0 - surface.damping_s_m * away);
            let push_n = if push > 0.0 { push } else { 0.0 };
            let slide = velocity - normal * away;
            let speed = libm::sqrt(slide.dot(&slide));
            let least = if speed > surface.creep_m_s {
                speed
            } else {
                surface.creep_m_s
            };
            return Some(Touch {
                normal,
                push_n,
                drag_ns_m: surface.friction * push_n / least,
            });
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const FLOOR: Obstacle = Obstacle {
        shape: Shape::HalfSpace {
            point: Vector3::new(0.0, 0.0, 0.0),
            normal: Vector3::new(0.0, 0.0, 1.0),
        },
        surface: Surface::METAL,
    };

    #[test]
    fn a_tip_feels_nothing_above_the_surface_and_a_spring_below() {
        let still = Vector3::zeros();
        assert_eq!(
            FLOOR.touch(&Vector3::new(0.0, 0.0, 0.011), &still, 0.01),
            None
        );
        let touch = FLOOR
            .touch(&Vector3::new(5.0, 0.0, 0.009), &still, 0.01)
            .unwrap();
        // 1 mm deep in 1e5 N/m
        assert!((touch.push_n - 100.0).abs() < 1e-9);
        assert!((touch.drag_ns_m - 0.2 * 100.0 / 0.001).abs() < 1e-6);
        assert!((touch.normal - Vector3::z()).norm() < 1e-15);
    }

    #[test]
    fn a_plate_is_touched_at_its_face_within_its_edges_and_nowhere_else() {
        let normal = Vector3::new(0.6, 0.0, 0.8);
        let plate = Plate {
            point_m: Vector3::new(1.0, 2.0, 3.0),
            normal,
            edge_m: 0.2,
            stiffness_n_m: 5000.0,
        };
        let obstacle = plate.obstacle();
        let push = |at: Vector3<f64>| {
            let touch = obstacle.touch(&(plate.point_m + at), &Vector3::zeros(), 0.0);
            touch.map(|touch| (touch.push_n, touch.normal))
        };
        // 1 mm deep in 5000 N/m
        let (push_n, out) = push(normal * -0.001).unwrap();
        assert!((push_n - 5.0).abs() < 1e-9 && (out - normal).norm() < 1e-12);
        assert_eq!(push(normal * 0.001), None);
        // 20 mm thick
        assert_eq!(push(normal * -0.021), None);
        let across = Vector3::new(0.0, 1.0, 0.0);
        assert!(push(normal * -0.001 + across * 0.099).is_some());
        assert_eq!(push(normal * -0.001 + across * 0.101), None);
    }

    proptest! {
        #[test]
        fn contact_never_attracts_and_friction_stays_in_its_cone(
            z in -0.01..0.01f64,
            v in prop::array::uniform3(-5.0..5.0f64),
        ) {
            let velocity = Vector3::from(v);
            if let Some(touch) = FLOOR.touch(&Vector3::new(0.0, 0.0, z), &velocity, 0.0) {
                prop_assert!(touch.push_n >= 0.0 && touch.drag_ns_m >= 0.0);
                let slide = Vector3::new(v[0], v[1], 0.0);
                prop_assert!(touch.drag_ns_m * slide.norm() <= 0.2 * touch.push_n * (1.0 + 1e-12));
            }
        }
    }

    /// A mass that falls on the floor comes back with the restitution the law is known for.
    #[test]
    fn an_impact_returns_as_hunt_and_crossley_say() {
        for (speed, damping) in [(0.05, 1.0), (0.1, 2.0)] {
            let mut floor = FLOOR;
            floor.surface.damping_s_m = damping;
            let (mass, dt) = (2.0, 1e-6);
            let (mut z, mut v) = (0.0, -speed);
            loop {
                z += 0.5 * dt * v;
                let at = Vector3::new(0.0, 0.0, z);
                let Some(touch) = floor.touch(&at, &Vector3::new(0.0, 0.0, v), 0.0) else {
                    break;
                };
                v += dt * touch.push_n / mass;
                z += 0.5 * dt * v;
            }
            let restitution = v / speed;
            let expected = 1.0 - 2.0 / 3.0 * damping * speed;
            // of first order in a·v: its square is left out
            let square = damping * speed * damping * speed;
            assert!(
                (restitution - expected).abs() < square && restitution < 1.0,
                "{restitution} {expected}"
            );
        }
    }
}
