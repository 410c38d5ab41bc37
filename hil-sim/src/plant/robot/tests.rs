use protocol::canopen::node::frame;

use super::super::axis::{AxisPlant, Drive};
use super::super::parameters::{irp6_postument, irp6_track};
use super::*;

mod cst;

#[test]
fn setups_that_cannot_be_are_refused() {
    let with = |change: fn(&mut RobotSetup)| {
        let mut setup = irp6_postument(1);
        change(&mut setup);
        SimRobot::new(setup, 1).unwrap_err()
    };
    let zero = with(|setup| setup.axes[2].node = 0);
    assert_eq!(zero, SetupError::Node { axis: 2, node: 0 });
    assert_eq!(
        zero.to_string(),
        "node identifier 0 of axis 2 is outside 1 to 127"
    );
    let double = with(|setup| setup.axes[3].node = 1);
    assert_eq!(double, SetupError::Double { bus: 0, node: 1 });
    let short = with(|setup| {
        setup.axes.pop();
    });
    assert_eq!(
        short,
        SetupError::Axes {
            expected: 6,
            got: 5
        }
    );
    let still = SimRobot::with_substep(irp6_postument(1), 1, 0).unwrap_err();
    assert_eq!(still, SetupError::Substep);
}

#[test]
fn every_drive_boots_on_its_bus() {
    let mut robot = SimRobot::new(irp6_track(1), 1).unwrap();
    let mut seen = Vec::new();
    robot.advance(200_000_000, &mut |sent| {
        seen.push((sent.bus, sent.frame.id()));
    });
    let id = |node: u16| protocol::frame::Id::Standard(0x700 + node);
    let expected = [(0, 1_u16), (0, 2), (0, 3), (0, 4), (1, 5), (1, 6), (1, 7)];
    assert_eq!(seen, expected.map(|(bus, node)| (bus, id(node))));
}

#[test]
fn a_frame_reaches_its_bus_only() {
    let mut robot = SimRobot::new(irp6_track(1), 1).unwrap();
    robot.advance(200_000_000, &mut |_| ());
    let mut answers = Vec::new();
    let mut out = |sent: Sent| answers.push(sent.bus);
    robot.on_frame(1, 200_000_000, &frame(0, [1, 0]), &mut out);
    robot.on_frame(0, 200_000_000, &frame(0x80, []), &mut out);
    assert!(answers.is_empty(), "bus 0 is not operational");
    let mut out = |sent: Sent| answers.push(sent.bus);
    robot.on_frame(1, 200_000_000, &frame(0x80, []), &mut out);
    assert_eq!(answers, [1, 1, 1]);
}

#[test]
fn an_unpowered_robot_keeps_still_under_its_weight() {
    let mut robot = SimRobot::new(irp6_track(3), 3).unwrap();
    let before = robot.motor_rad().to_vec();
    robot.advance(1_000_000_000, &mut |_| ());
    for (before, after) in before.iter().zip(robot.motor_rad()) {
        assert!((before - after).abs() < 1e-12);
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    let trace = |seed| {
        let mut robot = SimRobot::new(irp6_track(seed), seed).unwrap();
        let mut bytes = Vec::new();
        let mut out = |sent: Sent| bytes.extend_from_slice(sent.frame.data());
        robot.on_frame(0, 200_000_000, &frame(0, [1, 0]), &mut out);
        for k in 0..500 {
            robot.on_frame(0, 200_000_000 + k * 2_000_000, &frame(0x80, []), &mut out);
        }
        (
            bytes,
            robot
                .motor_rad()
                .iter()
                .map(|angle| angle.to_bits())
                .collect::<Vec<_>>(),
        )
    };
    assert_eq!(trace(5), trace(5));
    assert_ne!(trace(5).1, trace(6).1);
}

#[test]
fn faults_reach_their_axis() {
    let mut robot = SimRobot::new(irp6_postument(1), 1).unwrap();
    assert!(robot.inject(5, Some(DriveFault::SwitchStuck(true))));
    assert!(!robot.inject(6, None));
    robot.advance(1_000_000, &mut |_| ());
    assert!(robot.plant(5).unwrap().sensed().home);
    assert!(!robot.plant(4).unwrap().sensed().home);
    assert!(robot.drive(6).is_none() && robot.plant(6).is_none());
}

#[test]
fn halving_the_substep_changes_a_move_little() {
    let run = |substep_ns: u64| {
        let setup = irp6_postument(1).axes[0];
        #[expect(clippy::cast_precision_loss, reason = "small")]
        let dt = substep_ns as f64 * 1e-9;
        let mut plant = AxisPlant::new(setup.plant, 5.0, dt, SplitMix64::new(1));
        for _ in 0..200_000_000 / substep_ns {
            let command = Drive {
                torque_nm: 0.4,
                release_brake: true,
            };
            plant.step(command, 0.0);
        }
        plant.angle_rad()
    };
    let (coarse, fine) = (run(250_000), run(25_000));
    // Semi-implicit Euler is of first order: 19 rad/s and a 17 ms time constant at 0.25 ms.
    assert!((coarse - fine).abs() < 0.02, "{coarse} {fine}");
    assert!(fine > 6.0, "{fine}");
}

/// A motor with a light winding.
#[test]
fn an_overheated_motor_trips_its_drive_until_it_has_cooled() {
    use protocol::canopen::emcy::Emergency;
    let mut setup = irp6_postument(1);
    let mut winding = setup.axes[1].plant.winding.unwrap();
    (winding.winding_j_k, winding.housing_j_k) = (1.0, 100.0);
    setup.axes[1].plant.winding = Some(winding);
    let mut robot = SimRobot::new(setup, 1).unwrap();
    robot.advance(200_000_000, &mut |_| ());
    robot.on_frame(0, 200_000_000, &frame(0, [1, 0]), &mut |_| ());
    let mut codes = Vec::new();
    let mut out = |sent: Sent| {
        codes.extend(Emergency::decode(&sent.frame).map(|(_, emergency)| emergency.code));
    };
    let hot = Drive {
        torque_nm: 2.0,
        release_brake: false,
    };
    // 19 A in 1 Ω are 363 W on 1 J/K, of which 1.25 W/K flow off: 115 K in less than a second
    for _ in 0..4000 {
        robot.plants[1].actuate(hot);
    }
    assert!(robot.plant(1).unwrap().is_hot());
    robot.advance(210_000_000, &mut out);
    // the housing has taken the heat after some seconds
    robot.advance(10_000_000_000, &mut out);
    assert!(!robot.plant(1).unwrap().is_hot());
    assert_eq!(codes, [ErrorCode::OVER_TEMPERATURE]);
    assert!(!robot.drives[1].hot && robot.drives[1].injected.is_none());
}

#[test]
fn receptors_break_as_they_are_told() {
    let mut robot = SimRobot::new(irp6_postument(1), 1).unwrap();
    let turn = Broken {
        jump: 4000,
        ..Broken::default()
    };
    assert!(robot.set_broken(2, turn) && !robot.set_broken(6, turn));
    robot.advance(1_000_000, &mut |_| ());
    assert_eq!(robot.plant(2).unwrap().sensed().count, 4000);
    assert_eq!(robot.plant(2).unwrap().broken(), turn);
    assert_eq!(robot.plant(1).unwrap().sensed().count, 0);
}

#[test]
fn a_force_sensor_publishes_every_two_milliseconds_on_its_bus() {
    use crate::plant::force_sensor::{ForceSensor, ForceSensorParameters};
    use firmware::config::ForceAddress;
    use protocol::force_torque::{Receiver, SensorNumber};
    let mut robot = SimRobot::new(irp6_track(1), 1).unwrap();
    let number = SensorNumber::new(2).unwrap();
    let sensor = ForceSensor::new(ForceSensorParameters::irp6(true, 1), 1);
    let address = ForceAddress { bus: 1, number };
    robot.set_force_node(Some(ForceNode::new(address, sensor)));
    let mut receiver = Receiver::new(number);
    let mut numbers = Vec::new();
    robot.advance(20_000_000, &mut |sent| {
        assert_eq!((sent.bus, sent.at_ns % 2_000_000), (1, 0));
        numbers.extend(receiver.take(&sent.frame).map(|reading| reading.number));
    });
    assert_eq!(numbers, [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]);
    robot.set_force_node(None);
    robot.advance(40_000_000, &mut |_| panic!("nobody sends"));
}

#[test]
fn the_links_of_a_gear_that_gives_hang_below_their_motor() {
    use crate::plant::gear::Gear;
    let mut robot = SimRobot::new(irp6_postument(1), 1).unwrap();
    let gear = Gear {
        stiffness_nm_rad: 5.0,
        damping_nms_rad: 0.05,
        backlash_rad: 0.02,
    };
    assert_eq!(robot.set_gear(1, Some(gear)), Ok(()));
    robot.advance(1_000_000_000, &mut |_| ());
    let sag = robot.links_rad()[1] - robot.motor_rad()[1];
    // half of the backlash, and the twist of a weight of some tenths of 1 N·m
    assert!(sag.abs() > 0.01 && sag.abs() < 0.2, "{sag}");
    assert_eq!(
        robot.links_rad()[0].to_bits(),
        robot.motor_rad()[0].to_bits()
    );
}

#[test]
fn a_braked_arm_that_touches_something_feels_it_in_its_wrist() {
    use crate::plant::contact::{Obstacle, Shape, Surface, Tip};
    use crate::plant::force_sensor::{ForceSensor, ForceSensorParameters, Six};
    use firmware::config::ForceAddress;
    use nalgebra::Vector3;
    use protocol::force_torque::{Receiver, SensorNumber};
    let mut robot = SimRobot::new(irp6_postument(1), 1).unwrap();
    robot.advance(1_000_000, &mut |_| ());
    let tip = Tip {
        centre_m: Vector3::new(0.0, 0.0, 0.25),
        radius_m: 0.0,
    };
    let flange = robot.wrist().unwrap().flange;
    let end = flange.position + flange.rotation * tip.centre_m;
    // a wall across the tool's axis, 0.1 mm before the tip's end
    let along = flange.rotation.column(2).into_owned();
    let wall = Obstacle {
        shape: Shape::HalfSpace {
            point: end - along * 0.000_1,
            normal: -along,
        },
        surface: Surface::METAL,
    };
    let number = SensorNumber::new(0).unwrap();
    let p = ForceSensorParameters {
        bias: Six::zeros(),
        noise: Six::zeros(),
        ..ForceSensorParameters::irp6(false, 1)
    };
    let address = ForceAddress { bus: 0, number };
    robot.set_force_node(Some(ForceNode::new(address, ForceSensor::new(p, 1))));
    let mut receiver = Receiver::new(number);
    let mut last = None;
    let mut take = |sent: Sent| last = receiver.take(&sent.frame).or(last);
    robot.advance(50_000_000, &mut take);
    assert!(robot.surround(vec![wall], tip));
    let mut after = None;
    let mut receiver = Receiver::new(number);
    let mut take = |sent: Sent| after = receiver.take(&sent.frame).or(after);
    robot.advance(100_000_000, &mut take);
    let (before, after) = (last.unwrap().force_n(), after.unwrap().force_n());
    // 1e5 N/m · 0.1 mm along the axis, and nothing across it; brakes hold
    let change: [f64; 3] = core::array::from_fn(|k| after[k] - before[k]);
    assert!(
        change[0].abs() < 0.03 && change[1].abs() < 0.03,
        "{change:?}"
    );
    assert!((change[2] + 10.0).abs() < 0.03, "{change:?}");
}
