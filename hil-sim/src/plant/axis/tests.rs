use super::super::receptors::floor;
use super::*;
use core::f64::consts::TAU;

const DT: f64 = 0.000_25;

fn parameters() -> PlantParameters {
    PlantParameters {
        torque_constant_nm_a: 0.105,
        inertia_kg_m2: 2.0e-4,
        viscous_nms_rad: 0.02,
        coulomb_nm: 0.02,
        stiction_nm: 0.0,
        stribeck_rad_s: 1.0,
        brake_nm: 2.0,
        current_limit_a: 20.0,
        current_time_s: 0.000_3,
        winding: None,
        increments_per_turn: 4000,
        index_increments: 1,
        absolute: false,
        switch_rad: -2.0,
        switch_hysteresis_rad: 0.05,
        bounce_s: 0.0015,
        limit_rad: [-50.0, 50.0],
        stop_rad: [-60.0, 60.0],
        brake_open_s: 0.02,
        brake_close_s: 0.03,
    }
}

fn plant(start: f64) -> AxisPlant {
    AxisPlant::new(parameters(), start, DT, SplitMix64::new(1))
}

fn run(plant: &mut AxisPlant, torque_nm: f64, release_brake: bool, load: f64, seconds: f64) {
    let steps = floor(seconds / DT + 0.5);
    for _ in 0..steps {
        plant.step(
            Drive {
                torque_nm,
                release_brake,
            },
            load,
        );
    }
}

#[test]
fn constant_torque_ends_at_the_speed_friction_allows() {
    let mut plant = plant(0.0);
    run(&mut plant, 0.52, true, 0.0, 1.0);
    // (0.52 − 0.02 N·m) / 0.02 N·m·s/rad, with the stops 60 rad away reached only later.
    let expected = 25.0;
    assert!(
        (plant.velocity_rad_s() - expected).abs() < 1e-6,
        "{}",
        plant.velocity_rad_s()
    );
}

#[test]
fn torque_below_the_coulomb_friction_moves_nothing() {
    let mut plant = plant(1.0);
    run(&mut plant, 0.019, true, 0.0, 1.0);
    assert_eq!(plant.sensed().count, 0);
    assert!((plant.angle_rad() - 1.0).abs() < 1e-12);
}

#[test]
fn the_brake_holds_the_load_until_it_is_open() {
    let mut plant = plant(1.0);
    run(&mut plant, 0.0, false, -0.5, 0.5);
    assert!(plant.is_braked());
    assert!((plant.angle_rad() - 1.0).abs() < 1e-12);
    run(&mut plant, 0.0, true, -0.5, 0.019);
    assert!(
        (plant.angle_rad() - 1.0).abs() < 1e-12,
        "opening takes 20 ms"
    );
    run(&mut plant, 0.0, true, -0.5, 0.1);
    assert!(plant.angle_rad() < 0.9, "{}", plant.angle_rad());
    run(&mut plant, 0.0, false, -0.5, 0.5);
    assert!(plant.is_braked() && plant.velocity_rad_s().abs() < 1e-12);
}

#[test]
fn the_current_follows_its_demand_in_its_time_constant() {
    let mut plant = plant(0.0);
    run(&mut plant, 1.05, false, 0.0, 0.000_25);
    // One substep of 0.25 ms with a 0.3 ms loop: 10 A · (1 − e^(−0.25/0.3)).
    assert!((plant.sensed().current_a - 5.654).abs() < 1e-3);
    run(&mut plant, 100.0, false, 0.0, 0.01);
    assert!((plant.sensed().current_a - 20.0).abs() < 1e-6, "limited");
}

#[test]
fn the_index_pulse_tells_the_same_count_from_both_sides() {
    let mut plant = plant(3.0);
    let mut seen = Vec::new();
    for torque_nm in [-0.3, 0.3] {
        for _ in 0..4000 {
            plant.step(
                Drive {
                    torque_nm,
                    release_brake: true,
                },
                0.0,
            );
            if plant.angle_rad().abs() < 5.0 {
                seen.extend(plant.sensed().index);
            }
        }
    }
    // 3 rad are 1909.86 increments: the index at angle 0 lies in the increment −1910.
    assert_eq!(seen, [-1910, -1910]);
}

#[test]
fn the_encoder_counts_whole_increments() {
    let mut plant = plant(0.0);
    run(&mut plant, 0.3, true, 0.0, 0.5);
    let exact = plant.angle_rad() / TAU * 4000.0;
    assert_eq!(plant.sensed().count, floor(exact));
    assert!(exact > 1000.0);
}

#[test]
fn the_home_switch_bounces_and_then_rests() {
    let mut plant = plant(0.0);
    let mut changes = 0;
    let mut last = plant.sensed().home;
    while plant.angle_rad() > -4.0 {
        plant.step(
            Drive {
                torque_nm: -0.3,
                release_brake: true,
            },
            0.0,
        );
        changes += i32::from(plant.sensed().home != last);
        last = plant.sensed().home;
    }
    assert!(last, "active below the switch angle");
    assert!(
        (1..=7).contains(&changes),
        "{changes} changes in six substeps of bounce"
    );
}

#[test]
fn hard_stops_end_the_travel() {
    let mut plant = plant(0.0);
    run(&mut plant, 2.0, true, 0.0, 5.0);
    assert!((plant.angle_rad() - 60.0).abs() < 1e-9);
    assert!(plant.sensed().positive_limit && !plant.sensed().negative_limit);
}

#[test]
fn broken_receptors_lie() {
    let mut plant = plant(3.0);
    plant.set_broken(Broken {
        encoder: Some(EncoderFault::Frozen),
        switch: Some(true),
        ..Broken::default()
    });
    run(&mut plant, 0.3, true, 0.0, 1.0);
    assert_eq!((plant.sensed().count, plant.sensed().home), (0, true));
    assert!(plant.angle_rad() > 5.0);
    plant.set_broken(Broken::default());
    run(&mut plant, 0.3, true, 0.0, DT);
    assert!(plant.sensed().count > 0 && !plant.sensed().home);
}

#[test]
fn equal_seeds_give_equal_runs() {
    let trace = || {
        let mut plant = plant(0.0);
        let mut trace = Vec::new();
        for k in 0..20_000_i32 {
            let torque_nm = if k % 4000 < 2000 { -0.4 } else { 0.4 };
            plant.step(
                Drive {
                    torque_nm,
                    release_brake: true,
                },
                0.01,
            );
            trace.push((plant.angle_rad().to_bits(), plant.sensed().home));
        }
        trace
    };
    assert_eq!(trace(), trace());
}

#[test]
fn an_absolute_encoder_counts_from_the_angle_zero_and_without_end() {
    let unlimited = PlantParameters {
        absolute: true,
        limit_rad: [f64::NEG_INFINITY, f64::INFINITY],
        stop_rad: [f64::NEG_INFINITY, f64::INFINITY],
        ..parameters()
    };
    for start in [-7.3, 0.1, 12_345.6] {
        let random = SplitMix64::stream(1, "axis", 0);
        let plant = AxisPlant::new(unlimited, start, 1e-4, random);
        let count = start * f64::from(unlimited.increments_per_turn) / TAU;
        let sensed = f64::from(i32::try_from(plant.sensed().count).unwrap());
        assert_eq!(sensed.to_bits(), count.floor().to_bits(), "{start}");
        assert!(!plant.sensed().negative_limit && !plant.sensed().positive_limit);
    }
}

#[test]
fn an_index_wider_than_an_increment_is_met_at_either_end() {
    let wide = PlantParameters {
        index_increments: 5,
        ..parameters()
    };
    let mut plant = AxisPlant::new(wide, 3.0, DT, SplitMix64::new(1));
    let mut seen = Vec::new();
    for torque_nm in [-0.3, 0.3, -0.3] {
        for _ in 0..4000 {
            let command = Drive {
                torque_nm,
                release_brake: true,
            };
            plant.step(command, 0.0);
            if plant.angle_rad().abs() < 5.0 {
                seen.extend(plant.sensed().index);
            }
        }
    }
    // as above: it begins in the increment −1910, and from above it begins four increments later
    assert_eq!(seen, [-1906, -1910, -1906]);
}

#[test]
fn a_motor_that_turns_back_inside_a_pulse_tells_it_once() {
    let wide = PlantParameters {
        index_increments: 100,
        absolute: true,
        ..parameters()
    };
    let mut plant = AxisPlant::new(wide, -0.01, DT, SplitMix64::new(1));
    let mut seen = Vec::new();
    // 100 increments are 0.157 rad
    for angle in [0.01, 0.1, 0.05, 0.15, -0.01, 0.02, 0.2, 0.1, 0.3] {
        plant.moved(angle, 0.0);
        seen.push(plant.sensed().index);
    }
    let (up, down) = (Some(0), Some(99));
    assert_eq!(seen, [up, None, None, None, None, up, None, down, None]);
}

#[test]
fn an_encoder_that_jumps_or_flips_a_bit_says_so_ever_after() {
    let mut plant = plant(3.0);
    plant.set_broken(Broken {
        jump: 4000,
        ..Broken::default()
    });
    run(&mut plant, 0.0, false, 0.0, DT);
    assert_eq!(plant.sensed().count, 4000, "off by a turn");
    plant.set_broken(Broken {
        flipped_bit: Some(12),
        ..Broken::default()
    });
    run(&mut plant, 0.0, false, 0.0, DT);
    assert_eq!(plant.sensed().count, 4096);
}

#[test]
fn friction_at_rest_is_overcome_once_and_falls_with_velocity() {
    let sticky = PlantParameters {
        stiction_nm: 0.03,
        ..parameters()
    };
    let mut plant = AxisPlant::new(sticky, 0.0, DT, SplitMix64::new(1));
    run(&mut plant, 0.049, true, 0.0, 0.5);
    assert!(plant.velocity_rad_s().abs() < 1e-12, "it sticks");
    run(&mut plant, 0.06, true, 0.0, 1.0);
    // e^(−4): 0.02·v + 0.02 + 0.03·e^(−v²) = 0.06 at v = 1.97
    assert!(
        (plant.velocity_rad_s() - 1.97).abs() < 0.01,
        "{}",
        plant.velocity_rad_s()
    );
    let energy = |plant: &AxisPlant| plant.velocity_rad_s() * plant.velocity_rad_s();
    let mut before = energy(&plant);
    for _ in 0..400 {
        run(&mut plant, 0.0, true, 0.0, DT);
        assert!(energy(&plant) <= before, "friction never accelerates");
        before = energy(&plant);
    }
    assert!(before < 1e-12);
}
