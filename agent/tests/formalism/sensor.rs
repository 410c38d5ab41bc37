//! Virtual sensors: aggregation, configuration, and the age of readings.

use agent::{Image, Reading, VirtualSensor, Vsp};
use proptest::prelude::*;

/// The weight on a hook, from three load cells and the angle of the arm that carries them.
struct Weight;

/// `yc_V`: the tare, N, and over how many samples the reading is averaged.
struct Setting {
    tare: f64,
    samples: u32,
}

impl VirtualSensor for Weight {
    type Configuration = Setting;
    type Effector = f64;
    type Receptors = [f64; 3];
    type Own = (u32, f64);
    type Reading = f64;

    fn aggregate(
        &self,
        (n, sum): &mut (u32, f64),
        c: &Setting,
        cos_of_tilt: &f64,
        r: &[f64; 3],
    ) -> Option<f64> {
        *sum += r.iter().sum::<f64>() / cos_of_tilt - c.tare;
        *n += 1;
        if *n < c.samples {
            return None;
        }
        let mean = *sum / f64::from(*n);
        (*n, *sum) = (0, 0.0);
        Some(mean)
    }
}

#[test]
fn a_reading_depends_on_c_e_and_r() {
    let mut vsp = Vsp::new(
        Weight,
        Setting {
            tare: 0.0,
            samples: 1,
        },
    );
    assert_eq!(vsp.step(&1.0, &[1.0, 2.0, 3.0]), Some(6.0));
    assert_eq!(vsp.step(&0.5, &[1.0, 2.0, 3.0]), Some(12.0));
    vsp.configure(Setting {
        tare: 2.0,
        samples: 2,
    });
    assert_eq!(vsp.step(&1.0, &[1.0, 2.0, 3.0]), None);
    assert_eq!(vsp.step(&1.0, &[3.0, 2.0, 3.0]), Some(5.0));
    assert!((vsp.configuration().tare - 2.0).abs() <= 0.0);
}

#[test]
fn an_image_tells_its_age() {
    let mut image = Image::lasting(1);
    assert_eq!(image.at(0), Reading::<&u8>::Absent);
    assert_eq!(image.at(0).age(), None);
    image.receive(10, 7_u8);
    assert_eq!(image.at(11).fresh(), Some(&7));
    assert_eq!(image.at(12).fresh(), None);
    assert_eq!(
        image.at(12).map(|&v| v + 1),
        Reading::Stale { value: 8, age: 2 }
    );
    // A reading from a clock that is ahead, and one that comes late.
    assert_eq!(image.at(9), Reading::Fresh { value: &7, age: 0 });
    image.receive(9, 6);
    assert_eq!(image.at(10), Reading::Fresh { value: &7, age: 0 });
    image.receive(10, 8);
    assert_eq!(image.at(10).fresh(), Some(&8));
}

proptest! {
    /// Ages do not care where the count of instants wraps.
    #[test]
    fn ages_wrap(taken in any::<u32>(), age in 0..=u32::MAX / 2, lifetime in any::<u32>()) {
        let mut image = Image::lasting(lifetime);
        image.receive(taken, ());
        let reading = image.at(taken.wrapping_add(age));
        prop_assert_eq!(reading.age(), Some(age));
        prop_assert_eq!(reading.fresh().is_some(), age <= lifetime);
    }
}
