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

use nalgebra::Vector3;

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

/// The sphere at the end of a tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tip {
    /// Its centre in the flange's frame, m.
    pub centre_m: Vector3<f64>,
    /// m; 0 for a point.
    pub radius_m: f64,
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
