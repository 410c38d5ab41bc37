//! What stands around an arm, and what its tool's tip feels of it.

use nalgebra::Vector3;
use robots::dynamics::Chain;
use robots::{KinematicError, Motors, Robot};

use super::super::contact::{Obstacle, Tip};

/// Bodies around an arm, and its tip.
#[derive(Clone, Debug)]
pub(super) struct Surroundings {
    pub(super) obstacles: Vec<Obstacle>,
    pub(super) tip: Tip,
    /// Force on the tip, N, and where it acts, m, in the last substep, in the base frame; none without touch.
    pub(super) felt: Option<(Vector3<f64>, Vector3<f64>)>,
}

/// What contact does in one substep, at the motors: the torques are `push` − `drag`·(velocities after it).
#[derive(Clone, Copy, Debug)]
pub(super) struct Felt<const N: usize> {
    /// N·m.
    pub(super) push: [f64; N],
    /// N·m·s/rad, symmetric and positive semidefinite.
    pub(super) drag: [[f64; N]; N],
    /// How the tip moves with the motors, m/rad: rows x, y, z of the base frame.
    rows: [[f64; N]; 3],
    centre: Vector3<f64>,
    /// N along the normals, summed.
    push_n: Vector3<f64>,
    /// N·s/m on the tip, rows.
    drag_ns_m: [[f64; 3]; 3],
}

impl Surroundings {
    /// What the tip feels where the links are at these motor angles, rad, and turn at these rates, rad/s; none
    /// where it touches nothing.
    #[inline(never)]
    pub(super) fn feel<R: Robot<N>, const N: usize>(
        &self,
        robot: &R,
        chain: &Chain<N>,
        motors: &Motors<N>,
        rates: &[f64; N],
    ) -> Result<Option<Felt<N>>, KinematicError> {
        let joints = robot.joints(motors)?;
        let posture = chain.at(&joints);
        let flange = posture.flange();
        let lever = flange.rotation * self.tip.centre_m;
        let centre = flange.position + lever;
        let radius = self.tip.radius_m;
        let mut near = self
            .obstacles
            .iter()
            .filter(|obstacle| obstacle.shape.distance(&centre).metres < radius)
            .peekable();
        if near.peek().is_none() {
            return Ok(None);
        }
        let jacobian = posture.jacobian();
        let transmission = robot.transmission(&joints)?;
        let mut rows = [[0.0; N]; 3];
        for k in 0..N {
            let turn = Vector3::new(jacobian[(3, k)], jacobian[(4, k)], jacobian[(5, k)]);
            let arm = turn.cross(&lever);
            for i in 0..3 {
                rows[i][k] = jacobian[(i, k)] + arm[i];
            }
        }
        let rows = rows.map(|row| transmission.motor_torques(&row));
        let velocity = Vector3::from(moved(&rows, rates));
        let mut felt = Felt {
            push: [0.0; N],
            drag: [[0.0; N]; N],
            rows,
            centre,
            push_n: Vector3::zeros(),
            drag_ns_m: [[0.0; 3]; 3],
        };
        for obstacle in near {
            let Some(touch) = obstacle.touch(&centre, &velocity, radius) else {
                continue;
            };
            let n = touch.normal;
            felt.push_n += n * touch.push_n;
            // across the normal only: 1 − n·nᵀ
            for i in 0..3 {
                felt.drag_ns_m[i][i] += touch.drag_ns_m;
                for j in 0..3 {
                    felt.drag_ns_m[i][j] -= touch.drag_ns_m * n[i] * n[j];
                }
            }
        }
        felt.at_the_motors();
        Ok(Some(felt))
    }
}

impl<const N: usize> Felt<N> {
    /// Jᵀ·f and Jᵀ·D·J.
    fn at_the_motors(&mut self) {
        for (row, force) in self.rows.iter().zip(self.push_n.iter()) {
            for (push, x) in self.push.iter_mut().zip(row) {
                *push += x * force;
            }
        }
        for i in 0..3 {
            for j in 0..3 {
                let drag = self.drag_ns_m[i][j];
                for k in 0..N {
                    for m in 0..N {
                        self.drag[k][m] += self.rows[i][k] * drag * self.rows[j][m];
                    }
                }
            }
        }
    }

    /// The force on the tip, N, once the velocities after the substep are known, and where it acts, m.
    pub(super) fn force(&self, after: &[f64; N]) -> (Vector3<f64>, Vector3<f64>) {
        let velocity = Vector3::from(moved(&self.rows, after));
        let held = self.drag_ns_m.map(|row| Vector3::from(row).dot(&velocity));
        (self.push_n - Vector3::from(held), self.centre)
    }
}

fn moved<const N: usize>(rows: &[[f64; N]; 3], rates: &[f64; N]) -> [f64; 3] {
    rows.each_ref()
        .map(|row| row.iter().zip(rates).map(|(x, v)| x * v).sum())
}
