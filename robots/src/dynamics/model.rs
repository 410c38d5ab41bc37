//! Motor torques of a motion in f32, for every servo step: the same equations as
//! [`Posture::motor_inverse_dynamics`](super::Posture::motor_inverse_dynamics), which are f64, with what is constant found once.
//!
//! Gravity is [`STANDARD_GRAVITY`](super::STANDARD_GRAVITY) and the flange touches nothing. How far f32 is off is measured against f64 by a test over
//! every robot: below 1e-4 of what a motor can.

use motion::Angle;

use super::STANDARD_GRAVITY;
use super::chain::{Chain, Link};
use crate::description::{AxisDescription, Gearing, JointKind, Reference, RobotDescription};
use crate::narrow::{Axis, Geared, narrow, sine_cosine};

type Triple = [f32; 3];
type Columns = [Triple; 3];

/// One link with its joint, gear and motor.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Driven {
    axis: Axis,
    /// Quanta of the motor's angle in one turn of a joint that turns without end, of which only the rest counts.
    turn: Option<i64>,
    kind: JointKind,
    axes: Columns,
    offset: Triple,
    /// ∫dm, ∫r dm, and the columns of ∫r·rᵀ dm.
    mass: f32,
    first: Triple,
    second: Columns,
    /// Of the rotor and what turns with it, kg·m².
    rotor: f32,
}

/// The equation of motion of a robot whose gears are an axis' own, seen at its motors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorModel<const N: usize> {
    /// Each of them is there: only so a model is made.
    links: [Option<Driven>; N],
}

/// A link in one step: its frame in that of the link before it, and the rates of its momentum, force and moment.
#[derive(Clone, Copy)]
struct Step {
    axes: Columns,
    offset: Triple,
    force: Triple,
    moment: Triple,
    reduction: f32,
}

impl<const N: usize> MotorModel<N> {
    /// Of a robot's chain and description; `None` with legs or quadratic gears, which are not in f32.
    #[must_use]
    pub fn new(description: &RobotDescription<N>, chain: &Chain<N>) -> Option<Self> {
        let axes = &description.axes;
        let model = Self {
            links: core::array::from_fn(|k| {
                let after = axes.get(k.saturating_add(1));
                Driven::new(axes.get(k)?, after, chain.links.get(k)?)
            }),
        };
        let all = model.links.iter().all(Option::is_some);
        all.then_some(model)
    }

    /// Torques of the motors, N·m, that give them `acceleration`, rad/s², while they turn at `velocity`, rad/s, at these
    /// angles; without friction. `None` near a screw's dead centre.
    #[must_use]
    pub fn torques(
        &self,
        motors: &[Angle; N],
        velocity: &[f32; N],
        acceleration: &[f32; N],
    ) -> Option<[f32; N]> {
        let mut steps = [Step::NONE; N];
        let mut motion = Motion::BASE;
        let mut before = Before::default();
        let rates = velocity.iter().zip(acceleration);
        for ((step, link), (motor, (dm, ddm))) in steps
            .iter_mut()
            .zip(&self.links)
            .zip(motors.iter().zip(rates))
        {
            let link = link.as_ref()?;
            let [q, dq, ddq] = link.joint(*motor, *dm, *ddm, &mut before)?;
            *step = link.carried(&mut motion, q, dq, ddq);
            step.reduction = before.reduction;
        }
        self.gather(&steps, acceleration)
    }

    /// Inwards: forces and moments, and from the joints' torques those of the motors.
    fn gather(&self, steps: &[Step; N], acceleration: &[f32; N]) -> Option<[f32; N]> {
        let mut torques = [0.0; N];
        let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
        let (mut link_after, mut motor_after) = (0.0, 0.0);
        for (((torque, step), link), ddm) in torques
            .iter_mut()
            .zip(steps)
            .zip(&self.links)
            .zip(acceleration)
            .rev()
        {
            let link = link.as_ref()?;
            (force, moment) = (add(force, step.force), add(moment, step.moment));
            let joint = match link.kind {
                JointKind::Revolute => moment[2],
                JointKind::Prismatic => force[2],
            };
            force = outward(&step.axes, force);
            moment = add(outward(&step.axes, moment), cross(step.offset, force));
            let own = step.reduction * (joint - link_after);
            *torque = own - motor_after + link.rotor * ddm;
            link_after = if link.axis.in_plane { joint } else { 0.0 };
            motor_after = if link.axis.on_previous() { own } else { 0.0 };
        }
        Some(torques)
    }
}

/// What the axis before gives: travel and gear coordinate with their rates.
#[derive(Clone, Copy, Default)]
struct Before {
    travel: [f32; 3],
    x: [f32; 3],
    reduction: f32,
}

/// Where the frame of the last link goes: turning, its rate, and the acceleration of its origin.
#[derive(Clone, Copy)]
struct Motion {
    w: Triple,
    alpha: Triple,
    a: Triple,
    /// The rows of E: see [`super::body::field`].
    field: Columns,
}

impl Motion {
    const BASE: Self = Self {
        w: [0.0; 3],
        alpha: [0.0; 3],
        a: [0.0, 0.0, narrow(-STANDARD_GRAVITY.data.0[0][2])],
        field: [[0.0; 3]; 3],
    };
}

impl Step {
    const NONE: Self = Self {
        axes: [[0.0; 3]; 3],
        offset: [0.0; 3],
        force: [0.0; 3],
        moment: [0.0; 3],
        reduction: 0.0,
    };
}

impl Driven {
    fn new(axis: &AxisDescription, after: Option<&AxisDescription>, link: &Link) -> Option<Self> {
        let moments = link.moments();
        let alone = after.is_none_or(|after| {
            matches!(after.reference, Reference::Joint)
                && !matches!(after.gearing, Gearing::OnPrevious { .. })
        });
        let turn = match axis.gearing {
            Gearing::Linear { ratio }
                if alone
                    && !axis.joint_position.is_bounded()
                    && link.kind == JointKind::Revolute =>
            {
                Some(Angle::bound(ratio * core::f64::consts::TAU).quanta())
            }
            _ => None,
        };
        Some(Self {
            axis: Axis::new(axis)?,
            turn,
            kind: link.kind,
            axes: link.placement.axes.map(|column| column.map(narrow)),
            offset: link.placement.position_m.map(narrow),
            mass: narrow(moments.mass),
            first: moments.first.map(narrow),
            second: moments.second.columns().map(|column| column.map(narrow)),
            rotor: narrow(axis.motor.rotor_kg_m2 + axis.motor.gear_kg_m2),
        })
    }

    /// Joint position and its rates from those of the motor; `before` becomes this axis'.
    #[inline]
    fn joint(&self, motor: Angle, dm: f32, ddm: f32, before: &mut Before) -> Option<[f32; 3]> {
        let motor = match self.turn {
            Some(turn) => Angle::of_quanta(motor.quanta().checked_rem(turn)?),
            None => motor,
        };
        let travel = [self.axis.travel(motor), dm, ddm];
        let [previous, previous_dm, previous_ddm] = before.travel;
        let Geared {
            x,
            reduction,
            curvature,
        } = self.axis.gear.at(self.axis.travel(motor), previous)?;
        let (dm, ddm) = if self.axis.on_previous() {
            (dm - previous_dm, ddm - previous_ddm)
        } else {
            (dm, ddm)
        };
        let dx = reduction * dm;
        let ddx = reduction * (ddm - curvature * dx * dx);
        let [previous_x, previous_dx, previous_ddx] = before.x;
        let q = self.axis.joint(x, previous_x);
        *before = Before {
            travel,
            x: [x, dx, ddx],
            reduction,
        };
        Some(if self.axis.in_plane {
            [q, dx - previous_dx, ddx - previous_ddx]
        } else {
            [q, dx, ddx]
        })
    }

    /// Outwards: the link's frame, its motion, and the rates of its momentum.
    #[inline]
    fn carried(&self, motion: &mut Motion, q: f32, dq: f32, ddq: f32) -> Step {
        let [x, y, z] = self.axes;
        let (axes, offset) = match self.kind {
            JointKind::Revolute => {
                let (s, c) = sine_cosine(q);
                let turned = [
                    add(scale(c, x), scale(s, y)),
                    add(scale(c, y), scale(-s, x)),
                    z,
                ];
                (turned, self.offset)
            }
            JointKind::Prismatic => (self.axes, add(self.offset, scale(q, z))),
        };
        let mut a = inward(&axes, add(motion.a, inward(&motion.field, offset)));
        let mut w = inward(&axes, motion.w);
        let mut alpha = inward(&axes, motion.alpha);
        // ω × z·q̇
        let [along, across, up] = [w[1] * dq, -w[0] * dq, ddq];
        match self.kind {
            JointKind::Revolute => {
                w[2] += dq;
                alpha = add(alpha, [along, across, up]);
            }
            JointKind::Prismatic => a = add(a, [2.0 * along, 2.0 * across, up]),
        }
        let field = field(w, alpha);
        let [ex, ey, ez] = field;
        let [sx, sy, sz] = self.second;
        let twist = [
            dot(ez, sy) - dot(ey, sz),
            dot(ex, sz) - dot(ez, sx),
            dot(ey, sx) - dot(ex, sy),
        ];
        *motion = Motion { w, alpha, a, field };
        Step {
            axes,
            offset,
            force: add(scale(self.mass, a), inward(&field, self.first)),
            moment: add(twist, cross(self.first, a)),
            reduction: 0.0,
        }
    }
}

fn add([a, b, c]: Triple, [x, y, z]: Triple) -> Triple {
    [a + x, b + y, c + z]
}

fn scale(by: f32, [x, y, z]: Triple) -> Triple {
    [by * x, by * y, by * z]
}

fn dot([a, b, c]: Triple, [x, y, z]: Triple) -> f32 {
    a * x + b * y + c * z
}

fn cross([a, b, c]: Triple, [x, y, z]: Triple) -> Triple {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

/// R·v, by columns.
fn outward([a, b, c]: &Columns, [x, y, z]: Triple) -> Triple {
    add(add(scale(x, *a), scale(y, *b)), scale(z, *c))
}

/// Rᵀ·v, by columns; a matrix times v, by rows.
fn inward([a, b, c]: &Columns, v: Triple) -> Triple {
    [dot(*a, v), dot(*b, v), dot(*c, v)]
}

/// The rows of \[α×\] + \[ω×\]².
fn field([x, y, z]: Triple, [ax, ay, az]: Triple) -> Columns {
    let (xx, yy, zz) = (x * x, y * y, z * z);
    let (xy, xz, yz) = (x * y, x * z, y * z);
    [
        [-yy - zz, xy - az, xz + ay],
        [xy + az, -xx - zz, yz - ax],
        [xz - ay, yz + ax, -xx - yy],
    ]
}
