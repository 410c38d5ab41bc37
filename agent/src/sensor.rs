//! Virtual sensors: receptor readings aggregated into what motion control needs.

/// A virtual sensor `f_v`: `v = f_v(c, e, r)`. \[Z1\] (3), (13); \[Z2\] (3).
///
/// `c` is what the control subsystem sends to the sensor, its configuration `yc_V`; `e` is the
/// image of the effector the receptors may be mounted on; `r` is the bundle of receptor readings
/// (\[Z2\] (4)). `self` is constant; what the sensor remembers between readings is `Own`.
pub trait VirtualSensor {
    /// `c`: configuration and commands, `yc_V`.
    type Configuration;
    /// `e`: the image of the effector, as far as the sensor reads it; `()` if it does not.
    type Effector: ?Sized;
    /// `r`: the readings of the receptors, raw.
    type Receptors: ?Sized;
    /// What is remembered between readings, such as the state of a filter.
    type Own: Default;
    /// `v`: the aggregate reading.
    type Reading;

    /// `f_v`: the reading, or `None` while the receptors do not suffice for one.
    fn aggregate(
        &self,
        own: &mut Self::Own,
        c: &Self::Configuration,
        e: &Self::Effector,
        r: &Self::Receptors,
    ) -> Option<Self::Reading>;
}

/// The process of one virtual sensor: its function, configuration and latest reading.
///
/// Without bus or clock: whoever owns the receptors calls [`step`](Self::step).
#[derive(Clone, Copy, Debug)]
pub struct Vsp<F: VirtualSensor> {
    f: F,
    own: F::Own,
    configuration: F::Configuration,
}

impl<F: VirtualSensor> Vsp<F> {
    /// A process with the initial configuration `c`.
    pub fn new(f: F, c: F::Configuration) -> Self {
        Self {
            f,
            own: F::Own::default(),
            configuration: c,
        }
    }

    /// A new configuration `yc_V`, valid from the next reading on. What was remembered stays.
    pub fn configure(&mut self, c: F::Configuration) {
        self.configuration = c;
    }

    /// The configuration that is valid.
    pub const fn configuration(&self) -> &F::Configuration {
        &self.configuration
    }

    /// One reading from the receptors as they are now.
    pub fn step(&mut self, e: &F::Effector, r: &F::Receptors) -> Option<F::Reading> {
        self.f.aggregate(&mut self.own, &self.configuration, e, r)
    }
}

/// What an image of a virtual sensor tells at an instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading<T> {
    /// Not older than the reader allows.
    Fresh {
        /// The reading.
        value: T,
        /// Its age in steps.
        age: u32,
    },
    /// Too old: the last thing known, for an error message rather than for motion.
    Stale {
        /// The last reading.
        value: T,
        /// Its age in steps.
        age: u32,
    },
    /// Nothing was ever received.
    Absent,
}

impl<T> Reading<T> {
    /// The value, if it is fresh.
    pub fn fresh(self) -> Option<T> {
        match self {
            Self::Fresh { value, .. } => Some(value),
            Self::Stale { .. } | Self::Absent => None,
        }
    }

    /// The age in steps, if anything was received.
    pub const fn age(&self) -> Option<u32> {
        match self {
            Self::Fresh { age, .. } | Self::Stale { age, .. } => Some(*age),
            Self::Absent => None,
        }
    }

    /// The same reading with the value converted.
    pub fn map<U>(self, f: impl FnOnce(T) -> U) -> Reading<U> {
        match self {
            Self::Fresh { value, age } => Reading::Fresh {
                value: f(value),
                age,
            },
            Self::Stale { value, age } => Reading::Stale {
                value: f(value),
                age,
            },
            Self::Absent => Reading::Absent,
        }
    }
}

/// The image of a virtual sensor in the process that uses it: its latest reading, and from when.
///
/// ```
/// use agent::{Image, Reading};
///
/// let mut distance = Image::lasting(2); // steps
/// assert_eq!(distance.at(5), Reading::Absent);
/// distance.receive(5, 0.25);
/// assert_eq!(distance.at(7), Reading::Fresh { value: &0.25, age: 2 });
/// assert_eq!(distance.at(8), Reading::Stale { value: &0.25, age: 3 });
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Image<T> {
    latest: Option<(u32, T)>,
    lifetime: u32,
}

impl<T> Image<T> {
    /// An image whose readings are fresh up to the age of `lifetime` steps.
    #[must_use]
    pub const fn lasting(lifetime: u32) -> Self {
        Self {
            latest: None,
            lifetime,
        }
    }

    /// A reading that was taken at the instant `i`; an older one than the last is dropped.
    pub fn receive(&mut self, i: u32, value: T) {
        // Instants wrap: `i` is later if it lies in the half of the circle ahead.
        let later = |last: u32| i.wrapping_sub(last) <= u32::MAX / 2;
        if self.latest.as_ref().is_none_or(|(last, _)| later(*last)) {
            self.latest = Some((i, value));
        }
    }

    /// The reading at the instant `i`.
    pub fn at(&self, i: u32) -> Reading<&T> {
        let Some((taken, value)) = &self.latest else {
            return Reading::Absent;
        };
        // A stamp from ahead, by a clock that is ahead, is of age 0.
        let age = match i.wrapping_sub(*taken) {
            ahead if ahead > u32::MAX / 2 => 0,
            age => age,
        };
        if age <= self.lifetime {
            Reading::Fresh { value, age }
        } else {
            Reading::Stale { value, age }
        }
    }
}
