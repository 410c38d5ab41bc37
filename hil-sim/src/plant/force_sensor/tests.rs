use super::*;
use protocol::force_torque::{Receiver, SensorNumber};
use robots::dynamics::STANDARD_GRAVITY;

fn quiet() -> ForceSensorParameters {
    ForceSensorParameters {
        bias: Six::zeros(),
        noise: Six::zeros(),
        ..ForceSensorParameters::irp6(false, 1)
    }
}

/// A flange that looks down: its z is the base's −z, its x the base's x.
fn looking_down() -> Wrist {
    Wrist {
        flange: Pose {
            position: Vector3::new(0.7, 0.0, 0.3),
            rotation: nalgebra::Matrix3::new(1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0),
        },
        gravity: STANDARD_GRAVITY,
        touch: None,
    }
}

fn close(got: [f64; 3], expected: [f64; 3], within: f64) {
    for (got, expected) in got.iter().zip(expected) {
        assert!((got - expected).abs() < within, "{got} {expected}");
    }
}

#[test]
fn a_tool_at_rest_weighs() {
    let mut sensor = ForceSensor::new(quiet(), 1);
    let reading = sensor.sample(&looking_down());
    // z of the sensor is down, as is the weight of 10.8 N; half a unit
    close(reading.force_n(), [0.0, 0.0, 10.8], 0.006);
    // the centre is 4 mm off the axis, on the side of −x of a sensor that is turned by half a turn:
    // (−0.004, 0, 0.066) × (0, 0, 10.8) = (0, 0.043, 0)
    close(reading.moment_nm(), [0.0, 0.0432, 0.0], 0.000_6);
    assert_eq!(reading.status, Status::default());
}

#[test]
fn contact_is_felt_where_it_acts() {
    let mut sensor = ForceSensor::new(quiet(), 1);
    let mut wrist = looking_down();
    // a push of 20 N upwards on a point 0.25 m below the flange, and 5 N along the base's x
    let at = wrist.flange.position - Vector3::new(0.0, 0.0, 0.25);
    wrist.touch = Some((Vector3::new(5.0, 0.0, 20.0), at));
    let reading = sensor.sample(&wrist);
    close(reading.force_n(), [-5.0, 0.0, 10.8 - 20.0], 0.006);
    // lever of 0.16 m along the sensor's z: (0, 0, 0.16) × (−5, 0, −20) = (0, −0.8, 0)
    close(reading.moment_nm(), [0.0, 0.0432 - 0.8, 0.0], 0.000_6);
}

#[test]
fn a_falling_tool_weighs_nothing() {
    let mut sensor = ForceSensor::new(quiet(), 1);
    let mut wrist = looking_down();
    let mut reading = None;
    for k in 0..10 {
        let t = f64::from(k) * PERIOD_S;
        wrist.flange.position.z = 0.3 - 0.5 * 9.806_65 * t * t;
        reading = Some(sensor.sample(&wrist));
    }
    // differences of numbers of order 1, over 4e-6 s²: 1e-9 m/s²
    close(reading.unwrap().force_n(), [0.0; 3], 0.006);
}

#[test]
fn a_step_is_there_by_half_in_the_first_sample() {
    let mut sensor = ForceSensor::new(quiet(), 1);
    let mut wrist = looking_down();
    sensor.sample(&wrist);
    wrist.touch = Some((Vector3::new(0.0, 0.0, 20.0), wrist.flange.position));
    close(sensor.sample(&wrist).force_n(), [0.0, 0.0, 0.8], 0.006);
    close(sensor.sample(&wrist).force_n(), [0.0, 0.0, -9.2], 0.006);
}

#[test]
fn too_much_force_is_told_and_cut() {
    let mut sensor = ForceSensor::new(quiet(), 1);
    let mut wrist = looking_down();
    let push = |n: f64| Some((Vector3::new(n, 0.0, 0.0), Vector3::new(0.7, 0.0, 0.21)));
    wrist.touch = push(60.0);
    assert_eq!(sensor.sample(&wrist).status, Status::default());
    wrist.touch = push(70.0);
    let status = sensor.sample(&wrist).status;
    assert!(status.over_force && !status.saturated);
    wrist.touch = push(1000.0);
    sensor.sample(&wrist);
    let reading = sensor.sample(&wrist);
    assert!(reading.status.over_force && reading.status.saturated);
    // a quarter beyond 65 N
    assert!((reading.force_n()[0] + 81.25).abs() < 0.006);
}

#[test]
fn each_fault_of_a_sensor_on_a_bus_tells_what_it_says() {
    let number = SensorNumber::new(4).unwrap();
    let mut node = ForceNode::new(
        ForceAddress { bus: 0, number },
        ForceSensor::new(ForceSensorParameters::irp6(true, 1), 1),
    );
    let wrist = looking_down();
    let mut receiver = Receiver::new(number);
    let mut next = |fault: Option<ForceFault>| {
        node.set_fault(fault);
        let frames = node.publish(&wrist).into_iter().flatten();
        frames.filter_map(|frame| receiver.take(&frame)).last()
    };
    let before = next(None).unwrap();
    assert_eq!((before.number, before.status), (0, Status::default()));
    assert_eq!(next(Some(ForceFault::Silent)), None);
    assert_eq!(next(Some(ForceFault::Torn)), None);
    assert_eq!(next(Some(ForceFault::Repeating)), Some(before));
    let frozen = Reading {
        number: 4,
        ..before
    };
    assert_eq!(next(Some(ForceFault::Frozen)), Some(frozen));
    let failed = next(Some(ForceFault::Failed)).unwrap();
    assert!(failed.status.failed && failed.force == [0; 3] && failed.number == 5);
    let over = next(Some(ForceFault::OverForce)).unwrap();
    assert!(over.status.over_force && !over.status.saturated);
    let saturated = next(Some(ForceFault::Saturated)).unwrap();
    // a quarter beyond 65 N, 130 N, 5 N·m
    assert!(saturated.status.saturated);
    assert_eq!(
        (saturated.force, saturated.moment),
        ([8125, 8125, 16250], [6250; 3])
    );
    let mended = next(None).unwrap();
    assert_eq!((mended.number, mended.status), (8, Status::default()));
    assert_ne!(mended.force, before.force, "it has noise");
    for fault in ForceFault::ALL {
        assert_eq!(ForceFault::from_name(fault.name()), Some(fault));
    }
    assert_eq!(ForceFault::from_name("none"), None);
}

#[test]
fn noise_and_bias_are_those_of_the_seed_and_of_their_size() {
    let p = ForceSensorParameters::irp6(true, 7);
    let samples = |seed| {
        let mut sensor = ForceSensor::new(p, seed);
        let wrist = looking_down();
        (0..2000)
            .map(|_| sensor.sample(&wrist).force_n()[0])
            .collect::<Vec<_>>()
    };
    let first = samples(1);
    assert_eq!(first, samples(1));
    assert_ne!(first, samples(2));
    let mean = first.iter().sum::<f64>() / 2000.0;
    let variance = first.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / 2000.0;
    // averaging two samples halves the variance of 0.05 N; a standard error of 2 %, units of 0.01 N
    let deviation = libm::sqrt(2.0 * variance);
    assert!((deviation - 0.05).abs() < 0.005, "{deviation}");
    assert!((mean - p.bias[0]).abs() < 0.01, "{mean}");
    assert!(p.bias != ForceSensorParameters::irp6(true, 8).bias);
}
