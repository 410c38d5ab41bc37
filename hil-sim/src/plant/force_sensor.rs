//! A force sensor in the wrist, with its own node on a drive bus.
//!
//! It feels what all beyond it exerts on it: the contact of the tool's tip, and the weight and inertia of
//! the tool, which is taken as a point mass at its centre (its turning adds nothing). Of that it makes, 500 times a
//! second, a mix by its coupling matrix, adds bias and noise, cuts at the end of its range, and averages the last
//! two samples, as MRROC++ did with its ATI cards.

mod fault;

pub use fault::ForceFault;

use firmware::config::ForceAddress;
use motion::Pose;
use nalgebra::{SMatrix, SVector, Vector3};
use protocol::force_torque::{Reading, Status};
use protocol::frame::Frame;
use robots::RobotKind;

use super::mechanics::Wrist;
use super::random::SplitMix64;

/// A sample every so many ns. MRROC++ (`edp_force_sensor.h`).
pub const PERIOD_NS: u64 = 2_000_000;
const PERIOD_S: f64 = 0.002;

/// Force x, y, z, N, then moment x, y, z about the sensor's origin, N·m, along its axes.
pub type Six = SVector<f64, 6>;

/// A sensor and the tool beyond it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceSensorParameters {
    /// The sensor in the flange's frame.
    pub placement: Pose,
    /// Mass of the tool beyond the sensor, kg.
    pub tool_kg: f64,
    /// Its centre in the flange's frame, m.
    pub tool_centre_m: Vector3<f64>,
    /// What is told of each component by each: the identity for a sensor that is calibrated.
    pub coupling: SMatrix<f64, 6, 6>,
    /// Told where there is nothing, N and N·m.
    pub bias: Six,
    /// Standard deviation of a sample's noise, N and N·m.
    pub noise: Six,
    /// Greatest value told, either way, N and N·m.
    pub range: Six,
    /// Greatest value the sensor may bear, either way, N and N·m.
    pub limit: Six,
}

impl ForceSensorParameters {
    /// The IRp-6's. MRROC++ (`configs/common.ini`, `edp_s.cc` of the ATI 3084 and 6284): placement, weight and centre of
    /// the tool, over-force limits. ASSUMED: range a quarter beyond the limits, noise of 0.05 N and 2 mN·m, a
    /// bias of up to 5 N and 0.2 N·m that the seed decides, a calibrated matrix.
    #[must_use]
    pub fn irp6(track: bool, seed: u64) -> Self {
        let (turn, weight_n, centre_z) = if track {
            (-1.571, 13.18, 0.13)
        } else {
            (core::f64::consts::PI, 10.8, 0.156)
        };
        let (s, c) = libm::sincos(turn);
        let limit = Six::new(65.0, 65.0, 130.0, 5.0, 5.0, 5.0);
        let mut random = SplitMix64::stream(seed, "force sensor bias", 0);
        let mut bias = Six::new(5.0, 5.0, 5.0, 0.2, 0.2, 0.2);
        for most in &mut bias {
            *most *= random.between(-1.0, 1.0);
        }
        Self {
            placement: Pose {
                position: Vector3::new(0.0, 0.0, 0.09),
                rotation: nalgebra::Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0),
            },
            tool_kg: weight_n / 9.806_65,
            tool_centre_m: Vector3::new(0.004, 0.0, centre_z),
            coupling: SMatrix::identity(),
            bias,
            noise: Six::new(0.05, 0.05, 0.05, 0.002, 0.002, 0.002),
            range: limit * 1.25,
            limit,
        }
    }
}

/// A force sensor in operation.
#[derive(Clone, Debug)]
pub struct ForceSensor {
    p: ForceSensorParameters,
    random: SplitMix64,
    /// Where the tool's centre was at the last sample and at the one before, m in the base frame.
    centres: [Option<Vector3<f64>>; 2],
    last: Option<Six>,
    number: u8,
}

impl ForceSensor {
    /// A sensor whose noise is that of the seed.
    #[must_use]
    pub fn new(p: ForceSensorParameters, seed: u64) -> Self {
        Self {
            p,
            random: SplitMix64::stream(seed, "force sensor noise", 0),
            centres: [None; 2],
            last: None,
            number: 0,
        }
    }

    /// What the sensor feels, before all its errors.
    fn felt(&mut self, wrist: &Wrist) -> Six {
        let p = &self.p;
        let sensor = wrist.flange * p.placement;
        let centre = wrist.flange.position + wrist.flange.rotation * p.tool_centre_m;
        let acceleration = match self.centres {
            [Some(one), Some(two)] => (centre - one * 2.0 + two) / (PERIOD_S * PERIOD_S),
            _ => Vector3::zeros(),
        };
        self.centres = [Some(centre), self.centres[0]];
        let mut force = (wrist.gravity - acceleration) * p.tool_kg;
        let mut moment = (centre - sensor.position).cross(&force);
        if let Some((push, at)) = wrist.touch {
            force += push;
            moment += (at - sensor.position).cross(&push);
        }
        let (f, m) = (
            sensor.rotation.tr_mul(&force),
            sensor.rotation.tr_mul(&moment),
        );
        Six::new(f.x, f.y, f.z, m.x, m.y, m.z)
    }

    /// The next sample.
    pub fn sample(&mut self, wrist: &Wrist) -> Reading {
        let felt = self.felt(wrist);
        let mut status = Status::default();
        let mut told = self.p.coupling * felt + self.p.bias;
        for k in 0..6 {
            told[k] += self.p.noise[k] * self.random.normal();
            let range = self.p.range[k];
            status.saturated |= told[k].abs() > range;
            told[k] = told[k].clamp(-range, range);
            status.over_force |= (told[k] - self.p.bias[k]).abs() > self.p.limit[k];
        }
        let mean = (told + self.last.unwrap_or(told)) * 0.5;
        self.last = Some(told);
        let number = self.number;
        self.number = number.wrapping_add(1);
        let [fx, fy, fz, mx, my, mz] = mean.into();
        Reading::new([fx, fy, fz], [mx, my, mz], number, status)
    }
}

/// A force sensor on a bus.
#[derive(Clone, Debug)]
pub struct ForceNode {
    /// Where it hangs.
    address: ForceAddress,
    /// What it measures with.
    sensor: ForceSensor,
    fault: Option<ForceFault>,
    /// The last sample before the fault, or at all.
    last: Option<Reading>,
}

impl ForceNode {
    /// A sensor on a drive bus of the robot.
    #[must_use]
    pub const fn new(address: ForceAddress, sensor: ForceSensor) -> Self {
        Self {
            address,
            sensor,
            fault: None,
            last: None,
        }
    }

    /// That of a robot of this kind, with the bias and the noise of the seed.
    #[must_use]
    pub fn of(kind: RobotKind, address: ForceAddress, seed: u64) -> Self {
        let parameters = ForceSensorParameters::irp6(kind == RobotKind::Irp6Track, seed);
        Self::new(address, ForceSensor::new(parameters, seed))
    }

    /// The robot's drive bus it hangs on, from 0.
    #[must_use]
    pub const fn bus(&self) -> u8 {
        self.address.bus
    }

    /// Something is wrong with it from now on, or nothing any more.
    pub const fn set_fault(&mut self, fault: Option<ForceFault>) {
        self.fault = fault;
    }

    /// The frames of the next sample; none while it is silent.
    pub(super) fn publish(&mut self, wrist: &Wrist) -> Option<[Frame; 2]> {
        let reading = self.sensor.sample(wrist);
        let sensor = self.address.number;
        let Some(fault) = self.fault else {
            self.last = Some(reading);
            return Some(reading.frames(sensor));
        };
        let last = *self.last.get_or_insert(reading);
        let [force, moment] = fault.told(reading, last, &self.sensor.p.range)?;
        let ([force, _], [_, moment]) = (force.frames(sensor), moment.frames(sensor));
        Some([force, moment])
    }
}

#[cfg(test)]
mod tests;
