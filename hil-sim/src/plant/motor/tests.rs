use super::*;

const DT: f64 = 0.000_25;

const WINDING: Winding = Winding {
    resistance_ohm: 1.0,
    inductance_h: 0.001,
    supply_v: 48.0,
    winding_j_k: 40.0,
    housing_j_k: 600.0,
    winding_housing_k_w: 0.8,
    housing_air_k_w: 2.2,
    air_c: 20.0,
    trip_c: 130.0,
};

fn motor(winding: Option<Winding>) -> Motor {
    Motor::new(0.105, 100.0, 0.000_3, winding, DT)
}

#[test]
fn within_the_voltage_the_current_loop_is_all_one_sees() {
    let (mut known, mut unknown) = (motor(Some(WINDING)), motor(None));
    for k in 0..4000 {
        // 10 A take 10 V, 100 rad/s take 10.5 V, a rise by 12 A in 0.25 ms nearly 48 V more
        let torque = if k % 8 < 4 { 0.1 } else { 0.4 };
        let (a, b) = (known.step(torque, 100.0), unknown.step(torque, 100.0));
        assert_eq!(a.to_bits(), b.to_bits());
    }
}

#[test]
fn the_supply_limits_current_by_resistance_and_back_emf() {
    for (velocity, expected) in [(0.0, 48.0), (200.0, 48.0 - 21.0), (-200.0, 48.0 + 21.0)] {
        let mut motor = motor(Some(WINDING));
        for _ in 0..200 {
            motor.step(100.0, velocity);
        }
        // (48 V − k·ω)/1 Ω; 50 ms warm the winding by no tick of 0.1 s
        assert!(
            (motor.current_a() - expected).abs() < 1e-9,
            "{velocity}: {}",
            motor.current_a()
        );
    }
    // beyond the speed at which the back-EMF is the supply, there is no torque forwards
    let mut motor = motor(Some(WINDING));
    for _ in 0..200 {
        motor.step(1.0, 48.0 / 0.105 * 1.01);
    }
    assert!(motor.current_a() < 0.0 && motor.current_a() > -1.0);
}

#[test]
fn the_current_rises_as_the_inductance_lets_it() {
    let mut motor = motor(Some(WINDING));
    motor.step(100.0, 0.0);
    // 48 A·(1 − exp(−0.25)), less than the 56.5 A of the current loop
    let expected = 48.0 * (1.0 - libm::exp(-0.25));
    assert!((motor.current_a() - expected).abs() < 1e-9);
}

#[test]
fn a_motor_becomes_as_warm_as_both_masses_say() {
    let mut motor = motor(Some(WINDING));
    let warm = |motor: &mut Motor, seconds: u32| {
        for _ in 0..4000 * seconds {
            motor.step(0.42, 0.0);
        }
    };
    warm(&mut motor, 10);
    // 16 W·10 s on 40 J/K, of which the housing has taken a little: (1 − e^(−10/32))·32 s·16 W/40 J/K = 3.4 K
    let early = motor.winding_c().unwrap() - 20.0;
    assert!(early > 3.3 && early < 3.6, "{early}");
    warm(&mut motor, 8000);
    // ΔT = 3.0 K/W·16 W·(1 + 0.00393·ΔT): 59.2 K, six time constants of the housing later
    let late = motor.winding_c().unwrap() - 20.0;
    assert!((late - 59.2).abs() < 0.5, "{late}");
    assert!(!motor.is_hot());
}

#[test]
fn overload_opens_the_thermal_switch_and_rest_closes_it() {
    let mut motor = motor(Some(WINDING));
    let mut seconds = 0;
    while !motor.is_hot() && seconds < 100 {
        for _ in 0..4000 {
            motor.step(2.1, 0.0);
        }
        seconds += 1;
    }
    // 400 W on 40 J/K are 10 K/s; R grows, the housing takes some: 110 K in 9 to 11 s
    assert!((9..=11).contains(&seconds), "{seconds}");
    for _ in 0..4000 * 10 {
        motor.step(0.0, 0.0);
    }
    assert!(!motor.is_hot());
}

#[test]
fn a_demand_that_is_no_number_is_no_torque() {
    for winding in [None, Some(WINDING)] {
        let mut motor = motor(winding);
        motor.step(f64::NAN, 0.0);
        assert_eq!(motor.current_a().to_bits() << 1, 0);
        for _ in 0..100 {
            motor.step(f64::INFINITY, 0.0);
        }
        assert!(motor.current_a() > 40.0 && motor.current_a() <= 100.0);
    }
}
