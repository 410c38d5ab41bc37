//! The cell: which robots there are, how their loops are closed, and on which buses they hang.

mod wiring;

use super::board::{self, Board};
use super::document::{Document, Fields, Value};
use super::kind::{drive_groups, t_world_base};
use super::surface::{self, SurfaceSpec};
use crate::input::{DataError, Files, LoadError, Problem, shown};
use motion::pose::Pose;
use nalgebra::Vector3;
use protocol::budget::Rates;
use protocol::canopen::lss::Identity;
use protocol::message::{MAX_NAME, ServoLaw};
use robots::{RobotKind, TrackRule};
use std::path::Path;
use wiring::{bus_index, drives, fast_drives, force_bus, identities};

/// The velocity limit as a fraction of the motors' greatest, where the cell says nothing
/// (MRROC++ `velocity_limit_global_factor`).
pub const DEFAULT_VELOCITY_FACTOR: f64 = 0.2;

/// The bus towards the nodes, where the cell says nothing.
const DEFAULT_MP_BUS: &str = "mp";

/// Robots and buses.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// The robots, in the order of the file; names are unique.
    pub robots: Vec<RobotSpec>,
    /// The buses; names are unique. Those left to defaults come last.
    pub buses: Vec<BusSpec>,
    /// The board that is engraved, if there is one.
    pub board: Option<Board>,
    /// What stands in the way of tools, where the cell is simulated.
    pub surfaces: Vec<SurfaceSpec>,
}

/// A robot of the cell.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotSpec {
    /// Its name in the task; its kind's, if not said otherwise.
    pub name: String,
    /// What it is.
    pub kind: RobotKind,
    /// How its EDP closes the loops at the start.
    pub servo: ServoLaw,
    /// Velocity limit as a fraction (0, 1] of the motors' greatest.
    pub velocity_factor: f64,
    /// Where a robot on a track has its track; others have none.
    pub track: TrackRule,
    /// Its base in the world.
    pub t_world_base: Pose,
    /// Index in [`Cell::buses`] of the bus towards the MP.
    pub mp_bus: usize,
    /// Its drives; every axis on exactly one bus.
    pub drives: Vec<DriveGroup>,
    /// Node and drives speak the fast profile of CAN FD, which is experimental.
    pub fast_drives: bool,
    /// Index in [`Cell::buses`] of the bus of the force sensor in the wrist, number 0 there; of one that has one.
    pub force_bus: Option<usize>,
    /// The devices that drives of axes, from 0, must be; those without node id are given that of their axis.
    pub identities: Vec<(u8, Identity)>,
    /// A drive without node id that no axis names is looked for, and told.
    pub find_drives: bool,
    /// The drives store their set-up.
    pub stored_setup: bool,
}

impl RobotSpec {
    /// Number of axes.
    #[must_use]
    pub fn axes(&self) -> usize {
        self.kind.axes()
    }
}

/// Drives of one robot on one bus.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DriveGroup {
    /// Index in [`Cell::buses`].
    pub bus: usize,
    /// Axes from 0 (files count from 1).
    pub axes: Vec<usize>,
}

/// The two kinds of CAN.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BusKind {
    /// Classical CAN: 8 bytes a frame, one bit rate.
    Classic,
    /// CAN FD: 64 bytes a frame, a faster rate for data.
    Fd {
        /// Bits per second of the data phase.
        data_bit_rate: u32,
    },
}

/// A bus of the cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BusSpec {
    /// Its name.
    pub name: String,
    /// Classical or FD.
    pub kind: BusKind,
    /// Bits per second; of the arbitration phase for FD.
    pub bit_rate: u32,
}

impl BusSpec {
    /// Classical CAN at 1 Mbit/s.
    #[must_use]
    pub fn classic(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            kind: BusKind::Classic,
            bit_rate: 1_000_000,
        }
    }

    /// CAN FD at 1 and 5 Mbit/s.
    #[must_use]
    pub fn fd(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            kind: BusKind::Fd {
                data_bit_rate: 5_000_000,
            },
            bit_rate: 1_000_000,
        }
    }

    /// Its bit rates; data of classical frames has the nominal one.
    #[must_use]
    pub const fn rates(&self) -> Rates {
        Rates {
            nominal: self.bit_rate,
            data: match self.kind {
                BusKind::Classic => self.bit_rate,
                BusKind::Fd { data_bit_rate } => data_bit_rate,
            },
        }
    }
}

/// The servo laws by the names task files use.
pub const SERVO_LAWS: [(&str, ServoLaw); 4] = [
    ("drive-position", ServoLaw::DrivePosition),
    ("original", ServoLaw::Original),
    ("feed-forward", ServoLaw::FeedForward),
    ("computed-torque", ServoLaw::ComputedTorque),
];

impl Cell {
    /// Robots named after their kinds, with every default: one FD bus towards the MP, and the
    /// drive buses of each kind.
    #[must_use]
    pub fn of(kinds: &[RobotKind]) -> Self {
        let mut cell = Self {
            robots: Vec::new(),
            buses: Vec::new(),
            board: None,
            surfaces: Vec::new(),
        };
        for kind in kinds {
            let name = kind.name().to_owned();
            let mp_bus = cell.bus_or_new(BusSpec::fd(DEFAULT_MP_BUS));
            let drives = cell.default_drives(&name, *kind);
            cell.robots.push(RobotSpec {
                name,
                kind: *kind,
                servo: ServoLaw::DrivePosition,
                velocity_factor: DEFAULT_VELOCITY_FACTOR,
                track: TrackRule::Keep,
                t_world_base: t_world_base(*kind),
                mp_bus,
                drives,
                fast_drives: false,
                force_bus: None,
                identities: Vec::new(),
                find_drives: false,
                stored_setup: false,
            });
        }
        cell
    }

    /// Reads a cell file: the tables `[[robot]]` and `[[bus]]`.
    ///
    /// # Errors
    /// The file cannot be read or is not a cell.
    pub fn load(path: &Path, files: &Files) -> Result<Self, LoadError> {
        Document::load(path, files, read)
    }

    /// Reads the cell of a cell file or of a task.
    ///
    /// # Errors
    /// The file cannot be read or is neither.
    pub fn load_any(path: &Path, files: &Files) -> Result<Self, LoadError> {
        Document::load(path, files, |document| {
            let table = document.parse()?;
            match table.get_ref().get("step") {
                Some(_) => super::read(document).map(|task| task.cell),
                None => read(document),
            }
        })
    }

    /// Reads a cell from text.
    ///
    /// # Errors
    /// The first mistake, with line and column.
    pub fn parse(text: &str) -> Result<Self, DataError> {
        read(&Document {
            path: None,
            text,
            files: &Files::on_disk(),
        })
    }

    /// Index of the robot of a name.
    #[must_use]
    pub fn robot(&self, name: &str) -> Option<usize> {
        self.robots.iter().position(|robot| robot.name == name)
    }

    fn bus_or_new(&mut self, spec: BusSpec) -> usize {
        if let Some(index) = self.buses.iter().position(|bus| bus.name == spec.name) {
            return index;
        }
        self.buses.push(spec);
        self.buses.len() - 1
    }

    fn default_drives(&mut self, robot: &str, kind: RobotKind) -> Vec<DriveGroup> {
        (0..)
            .zip(drive_groups(kind))
            .map(|(number, axes)| DriveGroup {
                bus: self.bus_or_new(BusSpec::classic(format!("{robot}.{number}"))),
                axes,
            })
            .collect()
    }
}

const KEYS: [&str; 4] = ["robot", "bus", "board", "surface"];

fn read(document: &Document<'_>) -> Result<Cell, DataError> {
    let table = document.parse()?;
    let fields = Fields::new(document, 0..0, table.get_ref(), "a cell", &KEYS)?;
    from_fields(&fields)
}

/// Reads `cell = "FILE"` or `cell = { … }` of a task.
pub(super) fn of_task(document: &Document<'_>, value: &Value<'_, '_>) -> Result<Cell, DataError> {
    if !value.is_text() {
        return from_fields(&value.fields("a cell", &KEYS)?);
    }
    let path = document.resolve(value.text()?);
    Cell::load(&path, document.files).map_err(|error| match error {
        LoadError::Data(error) => error,
        LoadError::Input(error) => value.error(
            Problem::Unreadable,
            "cannot read the cell",
            "a cell file",
            error.to_string(),
        ),
    })
}

fn from_fields(fields: &Fields<'_, '_>) -> Result<Cell, DataError> {
    let mut cell = Cell {
        robots: Vec::new(),
        buses: Vec::new(),
        board: None,
        surfaces: Vec::new(),
    };
    if let Some(buses) = fields.optional("bus") {
        for value in buses.list()? {
            let bus = bus(&value)?;
            if cell.buses.iter().any(|other| other.name == bus.name) {
                return Err(value.error(
                    Problem::Conflict,
                    "two buses of one name",
                    "unique names",
                    format!("{} again", shown(&bus.name)),
                ));
            }
            cell.buses.push(bus);
        }
    }
    let robots = fields.required("robot")?;
    for value in robots.list()? {
        let robot = robot(&mut cell, &value)?;
        if cell.robot(&robot.name).is_some() {
            return Err(value.error(
                Problem::Conflict,
                "two robots of one name",
                "unique names",
                format!("{} again", shown(&robot.name)),
            ));
        }
        cell.robots.push(robot);
    }
    if cell.robots.is_empty() {
        return Err(robots.error(
            Problem::WrongCount,
            "a cell without robots",
            "at least one",
            "none",
        ));
    }
    if let Some(value) = fields.optional("board") {
        cell.board = Some(board::read(&cell, &value)?);
    }
    if let Some(surfaces) = fields.optional("surface") {
        for value in surfaces.list()? {
            cell.surfaces.push(surface::read(&cell, &value)?);
        }
    }
    Ok(cell)
}

fn name<'d>(value: &Value<'d, '_>) -> Result<&'d str, DataError> {
    let name = value.text()?;
    let good = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if name.len() > MAX_NAME || !name.chars().all(good) {
        return Err(value.error(
            Problem::OutOfRange,
            "not a name",
            format!("at most {MAX_NAME} letters, digits, `-` and `_`"),
            shown(name),
        ));
    }
    Ok(name)
}

fn bus(value: &Value<'_, '_>) -> Result<BusSpec, DataError> {
    let fields = value.fields(
        "a bus",
        &["name", "kind", "bit_rate_kbit_s", "data_bit_rate_kbit_s"],
    )?;
    let name = name(&fields.required("name")?)?.to_owned();
    let fd = fields
        .required("kind")?
        .choice("kind of bus", &[("classic", false), ("fd", true)])?;
    let rate = |key, greatest: u64, default: u64| match fields.optional(key) {
        None => Ok(default),
        Some(value) => value.integer(&format!("10 to {greatest} kbit/s"), |rate| {
            (10..=greatest).contains(&rate)
        }),
    };
    let bits = |kbit: u64| u32::try_from(kbit.saturating_mul(1000)).unwrap_or(u32::MAX);
    let bit_rate = rate("bit_rate_kbit_s", 1000, 1000)?;
    let kind = if fd {
        let data = rate("data_bit_rate_kbit_s", 8000, 5000)?;
        if data < bit_rate {
            return Err(fields.document.error(
                &fields.span,
                Problem::Conflict,
                "data slower than arbitration",
                format!("at least {bit_rate} kbit/s"),
                format!("{data} kbit/s"),
            ));
        }
        BusKind::Fd {
            data_bit_rate: bits(data),
        }
    } else if let Some(rate) = fields.optional("data_bit_rate_kbit_s") {
        return Err(rate.error(
            Problem::Conflict,
            "a data bit rate on classical CAN",
            "kind = \"fd\"",
            "kind = \"classic\"",
        ));
    } else {
        BusKind::Classic
    };
    Ok(BusSpec {
        name,
        kind,
        bit_rate: bits(bit_rate),
    })
}

fn robot(cell: &mut Cell, value: &Value<'_, '_>) -> Result<RobotSpec, DataError> {
    let fields = value.fields(
        "a robot",
        &[
            "kind",
            "name",
            "servo",
            "velocity_factor",
            "track",
            "base",
            "mp_bus",
            "drives",
            "fast_drives",
            "force_bus",
            "identities",
            "find_drives",
            "stored_setup",
        ],
    )?;
    let kinds = RobotKind::ALL.map(|kind| (kind.name(), kind));
    let kind = fields.required("kind")?.choice("kind of robot", &kinds)?;
    let name = match fields.optional("name") {
        Some(value) => name(&value)?.to_owned(),
        None => kind.name().to_owned(),
    };
    let servo = match fields.optional("servo") {
        Some(value) => value.choice("servo law", &SERVO_LAWS)?,
        None => ServoLaw::DrivePosition,
    };
    let velocity_factor = match fields.optional("velocity_factor") {
        Some(value) => value.number("greater than 0, at most 1", |v| v > 0.0 && v <= 1.0)?,
        None => DEFAULT_VELOCITY_FACTOR,
    };
    let track = track(kind, &fields)?;
    let t_world_base = match fields.optional("base") {
        Some(value) => {
            let pose = value.fields("a pose", &["position_m", "rotation_rad"])?;
            let rotation = match pose.optional("rotation_rad") {
                Some(value) => value.triple()?,
                None => [0.0; 3],
            };
            Pose::from_rotation_vector(
                Vector3::from(pose.required("position_m")?.triple()?),
                Vector3::from(rotation),
            )
        }
        None => t_world_base(kind),
    };
    let mp_bus = match fields.optional("mp_bus") {
        Some(value) => bus_index(cell, &value)?,
        None => cell.bus_or_new(BusSpec::fd(DEFAULT_MP_BUS)),
    };
    let drives = match fields.optional("drives") {
        Some(value) => drives(cell, &value, kind)?,
        None => cell.default_drives(&name, kind),
    };
    let fast_drives = fast_drives(cell, &fields, &drives)?;
    let force_bus = match fields.optional("force_bus") {
        None => None,
        Some(value) => Some(force_bus(cell, &value, kind, &drives)?),
    };
    let identities = match fields.optional("identities") {
        None => Vec::new(),
        Some(value) => identities(&value, kind)?,
    };
    Ok(RobotSpec {
        name,
        kind,
        servo,
        velocity_factor,
        track,
        t_world_base,
        mp_bus,
        drives,
        fast_drives,
        force_bus,
        identities,
        find_drives: is_set(&fields, "find_drives")?,
        stored_setup: is_set(&fields, "stored_setup")?,
    })
}

/// Is it there, and true?
fn is_set(fields: &Fields<'_, '_>, key: &'static str) -> Result<bool, DataError> {
    match fields.optional(key) {
        None => Ok(false),
        Some(value) => value.boolean(),
    }
}

/// Where a robot on a track has its track.
fn track(kind: RobotKind, fields: &Fields<'_, '_>) -> Result<TrackRule, DataError> {
    Ok(match fields.optional("track") {
        Some(value) if kind != RobotKind::Irp6Track => {
            return Err(value.error(
                Problem::Conflict,
                "a rule for a track",
                format!("`kind = \"{}\"`", RobotKind::Irp6Track),
                kind.name(),
            ));
        }
        Some(value) => value.choice(
            "rule for the track",
            &TrackRule::ALL.map(|rule| (rule.name(), rule)),
        )?,
        None => TrackRule::Keep,
    })
}
