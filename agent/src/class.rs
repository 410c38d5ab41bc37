//! The classes of generators and conditions, and the census that none is neglected.
//!
//! \[Z1\] §VI and §VII classify by argument lists: 5 + 8 classes of generators, 4 + 8 of conditions.
//! Completeness is the point (\[Z1\] §VIII), so the lists are here as constants, and [`missing`]
//! finds the classes without an inhabitant.

use core::fmt;

use crate::args::{Args, Level, Role};
use crate::condition::Condition;
use crate::generator::Generator;
use crate::subsystem::Subsystem;

/// Which function is classified.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// `f*`: a motion generator; its `f_T` is of the same class.
    Generator,
    /// `f_P`: a condition or predicate.
    Condition,
}

/// The class of a generator or condition. Prints as the papers write it.
///
/// ```
/// use agent::Class;
///
/// let names: Vec<_> = Class::MP_GENERATORS.iter().map(ToString::to_string).collect();
/// assert_eq!(names, ["f^0(c_0)", "f^1(c_0, v_0)", "f^2(c_0, e_c)", "f^3(c_0, e_c, v_0)", "f**() = const"]);
/// assert_eq!(Class::ECP_CONDITIONS[6].to_string(), "f_P^6(c_0, c_j, e_j)");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Class {
    role: Role,
    kind: Kind,
    q: Option<u8>,
    transmissions: bool,
}

impl Class {
    /// The five classes of generators of the MP, `f**` last.
    pub const MP_GENERATORS: [Self; 5] = [
        Self::numbered(Role::Mp, Kind::Generator, 0),
        Self::numbered(Role::Mp, Kind::Generator, 1),
        Self::numbered(Role::Mp, Kind::Generator, 2),
        Self::numbered(Role::Mp, Kind::Generator, 3),
        Self {
            role: Role::Mp,
            kind: Kind::Generator,
            q: None,
            transmissions: false,
        },
    ];

    /// The eight classes of generators of an ECP.
    pub const ECP_GENERATORS: [Self; 8] = Self::of_ecp(Kind::Generator);

    /// The four classes of conditions of the MP.
    pub const MP_CONDITIONS: [Self; 4] = [
        Self::numbered(Role::Mp, Kind::Condition, 0),
        Self::numbered(Role::Mp, Kind::Condition, 1),
        Self::numbered(Role::Mp, Kind::Condition, 2),
        Self::numbered(Role::Mp, Kind::Condition, 3),
    ];

    /// The eight classes of conditions of an ECP.
    pub const ECP_CONDITIONS: [Self; 8] = Self::of_ecp(Kind::Condition);

    /// All 25 classes of \[Z1\], in the order of the four lists above.
    pub fn all() -> impl Iterator<Item = Self> + Clone {
        Self::MP_GENERATORS
            .into_iter()
            .chain(Self::ECP_GENERATORS)
            .chain(Self::MP_CONDITIONS)
            .chain(Self::ECP_CONDITIONS)
    }

    const fn numbered(role: Role, kind: Kind, q: u8) -> Self {
        Self {
            role,
            kind,
            q: Some(q),
            transmissions: false,
        }
    }

    const fn of_ecp(kind: Kind) -> [Self; 8] {
        [
            Self::numbered(Role::Ecp, kind, 0),
            Self::numbered(Role::Ecp, kind, 1),
            Self::numbered(Role::Ecp, kind, 2),
            Self::numbered(Role::Ecp, kind, 3),
            Self::numbered(Role::Ecp, kind, 4),
            Self::numbered(Role::Ecp, kind, 5),
            Self::numbered(Role::Ecp, kind, 6),
            Self::numbered(Role::Ecp, kind, 7),
        ]
    }

    const fn of<A: Args, L: Level>(kind: Kind) -> Self {
        Self {
            role: L::ROLE,
            kind,
            q: A::CLASS,
            transmissions: A::TRANSMISSIONS,
        }
    }

    /// The class of the generator `G` of the subsystem `S`.
    #[must_use]
    pub const fn generator<S: Subsystem, G: Generator<S> + ?Sized>() -> Self {
        Self::of::<G::Args, S::Level>(Kind::Generator)
    }

    /// The class of the condition `P` of the subsystem `S`.
    #[must_use]
    pub const fn condition<S: Subsystem, P: Condition<S> + ?Sized>() -> Self {
        Self::of::<P::Args, S::Level>(Kind::Condition)
    }

    /// The class of a generator by its value, for closures whose type has no name.
    #[must_use]
    pub const fn of_generator<S: Subsystem, G: Generator<S> + ?Sized>(_: &G) -> Self {
        Self::generator::<S, G>()
    }

    /// The class of a condition by its value, for closures whose type has no name.
    #[must_use]
    pub const fn of_condition<S: Subsystem, P: Condition<S> + ?Sized>(_: &P) -> Self {
        Self::condition::<S, P>()
    }

    /// MP or ECP.
    #[must_use]
    pub const fn role(self) -> Role {
        self.role
    }

    /// Generator or condition.
    #[must_use]
    pub const fn kind(self) -> Kind {
        self.kind
    }

    /// The superscript `q`; `None` for `f**`.
    #[must_use]
    pub const fn q(self) -> Option<u8> {
        self.q
    }

    /// Are transmissions of other agents read, beyond the arguments of \[Z1\]?
    #[must_use]
    pub const fn transmissions(self) -> bool {
        self.transmissions
    }
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(q) = self.q else {
            return f.write_str("f**() = const");
        };
        f.write_str(match self.kind {
            Kind::Generator => "f^",
            Kind::Condition => "f_P^",
        })?;
        write!(f, "{q}(")?;
        let (e, v, t) = match self.role {
            Role::Mp => (", e_c", ", v_0", ", T_0"),
            Role::Ecp => (", e_j", ", v_j", ", T_j"),
        };
        f.write_str(match (self.role, q & 4 != 0) {
            (Role::Mp, _) => "c_0",
            (Role::Ecp, false) => "c_j",
            (Role::Ecp, true) => "c_0, c_j",
        })?;
        for (read, symbol) in [(q & 2 != 0, e), (q & 1 != 0, v), (self.transmissions, t)] {
            if read {
                f.write_str(symbol)?;
            }
        }
        f.write_str(")")
    }
}

/// A generator or condition that exists, as an entry of a census.
///
/// ```
/// # use agent::{args, Constant, Inhabitant, Subsystem};
/// # struct Mp;
/// # impl Subsystem for Mp {
/// #     type Level = args::Coordinator;
/// #     type Coordination = ();
/// #     type Effector = ();
/// #     type Sensors = ();
/// #     type Transmissions = ();
/// #     type Command = u8;
/// # }
/// const START: Inhabitant = Inhabitant::generator::<Mp, Constant<u8>>("Constant");
/// assert_eq!(START.to_string(), "Constant: f**() = const");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Inhabitant {
    /// Its class.
    pub class: Class,
    /// Its name.
    pub name: &'static str,
}

impl Inhabitant {
    /// The generator `G` of the subsystem `S`.
    #[must_use]
    pub const fn generator<S: Subsystem, G: Generator<S> + ?Sized>(name: &'static str) -> Self {
        Self {
            class: Class::generator::<S, G>(),
            name,
        }
    }

    /// The condition `P` of the subsystem `S`.
    #[must_use]
    pub const fn condition<S: Subsystem, P: Condition<S> + ?Sized>(name: &'static str) -> Self {
        Self {
            class: Class::condition::<S, P>(),
            name,
        }
    }
}

impl fmt::Display for Inhabitant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.name, self.class)
    }
}

/// The classes of \[Z1\] that have no inhabitant in `census`.
///
/// A function that reads transmissions is in none of these classes: \[Z1\] has no such argument.
pub fn missing(census: &[Inhabitant]) -> impl Iterator<Item = Class> {
    Class::all().filter(|class| !census.iter().any(|entry| entry.class == *class))
}
