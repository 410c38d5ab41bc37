//! Indices of the objects, by name.

/// Error register.
pub const ERROR_REGISTER: u16 = 0x1001;
/// Error history.
pub const ERROR_HISTORY: u16 = 0x1003;
/// Identifier of SYNC.
pub const SYNC_COB: u16 = 0x1005;
/// Communication cycle period, µs.
pub const CYCLE_PERIOD: u16 = 0x1006;
/// SYNC window, µs: how long after SYNC a synchronous PDO counts.
pub const SYNC_WINDOW: u16 = 0x1007;
/// Store parameters.
pub const STORE: u16 = 0x1010;
/// Restore default parameters.
pub const RESTORE: u16 = 0x1011;
/// Identifier of EMCY.
pub const EMERGENCY_COB: u16 = 0x1014;
/// Least time between two emergencies, 100 µs.
pub const EMERGENCY_INHIBIT: u16 = 0x1015;
/// Heartbeat consumed: node and window in ms.
pub const CONSUMER_HEARTBEAT: u16 = 0x1016;
/// Heartbeat produced: period in ms.
pub const PRODUCER_HEARTBEAT: u16 = 0x1017;
/// Identity: vendor, product, revision, serial number.
pub const IDENTITY: u16 = 0x1018;
/// Overflow of the SYNC counter.
pub const SYNC_OVERFLOW: u16 = 0x1019;
/// Verify configuration: date and time of the last one.
pub const VERIFY_CONFIGURATION: u16 = 0x1020;
/// Error behaviour: the NMT state after a communication error.
pub const ERROR_BEHAVIOUR: u16 = 0x1029;
/// Communication parameters of the first RPDO.
pub const RPDO_COMMUNICATION: u16 = 0x1400;
/// Mapping of the first RPDO.
pub const RPDO_MAPPING: u16 = 0x1600;
/// Communication parameters of the first TPDO.
pub const TPDO_COMMUNICATION: u16 = 0x1800;
/// Mapping of the first TPDO.
pub const TPDO_MAPPING: u16 = 0x1A00;
/// Program data.
pub const PROGRAM_DATA: u16 = 0x1F50;
/// Program control.
pub const PROGRAM_CONTROL: u16 = 0x1F51;
/// Program software identification: here the CRC-32 of the program.
pub const PROGRAM_IDENTIFICATION: u16 = 0x1F56;
/// Flash status identification.
pub const FLASH_STATUS: u16 = 0x1F57;
/// What the person who commissioned the axis wants to remember.
pub const NOTE: u16 = 0x2000;
/// The slot in the group of the fast profile; 0: none.
pub const FAST_SLOT: u16 = 0x2010;
/// Abort-connection option code.
pub const ABORT_CONNECTION: u16 = 0x6007;
/// Error code.
pub const ERROR_CODE: u16 = 0x603F;
/// Controlword.
pub const CONTROLWORD: u16 = 0x6040;
/// Statusword.
pub const STATUSWORD: u16 = 0x6041;
/// Quick-stop option code.
pub const QUICK_STOP_OPTION: u16 = 0x605A;
/// Shutdown option code.
pub const SHUTDOWN_OPTION: u16 = 0x605B;
/// Disable-operation option code.
pub const DISABLE_OPTION: u16 = 0x605C;
/// Halt option code.
pub const HALT_OPTION: u16 = 0x605D;
/// Fault-reaction option code.
pub const FAULT_OPTION: u16 = 0x605E;
/// Mode of operation.
pub const MODE: u16 = 0x6060;
/// Mode of operation display.
pub const MODE_DISPLAY: u16 = 0x6061;
/// Position demand value, units.
pub const POSITION_DEMAND: u16 = 0x6062;
/// Position actual value, units.
pub const POSITION_ACTUAL: u16 = 0x6064;
/// Following-error window, units.
pub const FOLLOWING_WINDOW: u16 = 0x6065;
/// Following-error time-out, ms.
pub const FOLLOWING_TIMEOUT: u16 = 0x6066;
/// Position window, units: within it the target counts as reached.
pub const POSITION_WINDOW: u16 = 0x6067;
/// For how long it must be, ms.
pub const POSITION_WINDOW_TIME: u16 = 0x6068;
/// Velocity demand value, units/s.
pub const VELOCITY_DEMAND: u16 = 0x606B;
/// Velocity actual value, units/s.
pub const VELOCITY_ACTUAL: u16 = 0x606C;
/// Velocity window, units/s.
pub const VELOCITY_WINDOW: u16 = 0x606D;
/// For how long it must be, ms.
pub const VELOCITY_WINDOW_TIME: u16 = 0x606E;
/// Velocity threshold, units/s: below it the axis stands.
pub const VELOCITY_THRESHOLD: u16 = 0x606F;
/// For how long it must be, ms.
pub const VELOCITY_THRESHOLD_TIME: u16 = 0x6070;
/// Target torque, per mille.
pub const TARGET_TORQUE: u16 = 0x6071;
/// Maximum torque, per mille.
pub const MAX_TORQUE: u16 = 0x6072;
/// Motor rated current, mA.
pub const RATED_CURRENT: u16 = 0x6075;
/// Motor rated torque, mN·m.
pub const RATED_TORQUE: u16 = 0x6076;
/// Torque actual value, per mille.
pub const TORQUE_ACTUAL: u16 = 0x6077;
/// Current actual value, per mille of the rated current.
pub const CURRENT_ACTUAL: u16 = 0x6078;
/// DC-link voltage, mV.
pub const DC_LINK: u16 = 0x6079;
/// Target position, units.
pub const TARGET_POSITION: u16 = 0x607A;
/// Home offset, units.
pub const HOME_OFFSET: u16 = 0x607C;
/// Software position limits, units.
pub const SOFT_LIMITS: u16 = 0x607D;
/// Greatest velocity of a profile, units/s.
pub const MAX_PROFILE_VELOCITY: u16 = 0x607F;
/// Maximum motor speed, turns per minute.
pub const MAX_SPEED: u16 = 0x6080;
/// Profile velocity, units/s.
pub const PROFILE_VELOCITY: u16 = 0x6081;
/// Profile acceleration, units/s².
pub const PROFILE_ACCELERATION: u16 = 0x6083;
/// Profile deceleration, units/s².
pub const PROFILE_DECELERATION: u16 = 0x6084;
/// Quick-stop deceleration, units/s².
pub const QUICK_STOP_DECELERATION: u16 = 0x6085;
/// Motion profile type: 0, trapezoids of velocity.
pub const PROFILE_TYPE: u16 = 0x6086;
/// Position encoder resolution: increments per motor turns.
pub const ENCODER_RESOLUTION: u16 = 0x608F;
/// Gear ratio: motor turns per shaft turns.
pub const GEAR_RATIO: u16 = 0x6091;
/// Feed constant: units per shaft turns.
pub const FEED_CONSTANT: u16 = 0x6092;
/// Homing method.
pub const HOMING_METHOD: u16 = 0x6098;
/// Homing speeds, units/s: search for the switch, search for the index.
pub const HOMING_SPEEDS: u16 = 0x6099;
/// Homing acceleration, units/s².
pub const HOMING_ACCELERATION: u16 = 0x609A;
/// Position offset, units.
pub const POSITION_OFFSET: u16 = 0x60B0;
/// Velocity offset, units/s.
pub const VELOCITY_OFFSET: u16 = 0x60B1;
/// Torque offset, per mille.
pub const TORQUE_OFFSET: u16 = 0x60B2;
/// Touch-probe function.
pub const TOUCH_PROBE: u16 = 0x60B8;
/// Touch-probe status.
pub const TOUCH_PROBE_STATUS: u16 = 0x60B9;
/// Touch probe 1, position at the positive edge, units.
pub const TOUCH_PROBE_POSITIVE: u16 = 0x60BA;
/// Touch probe 1, position at the negative edge, units.
pub const TOUCH_PROBE_NEGATIVE: u16 = 0x60BB;
/// Touch probe 2, position at the positive edge, units.
pub const TOUCH_PROBE_2_POSITIVE: u16 = 0x60BC;
/// Touch probe 2, position at the negative edge, units.
pub const TOUCH_PROBE_2_NEGATIVE: u16 = 0x60BD;
/// What triggers each touch probe.
pub const TOUCH_PROBE_SOURCE: u16 = 0x60D0;
/// When the latched positive edge of touch probe 1 was, ns of the drive's own clock modulo 2³².
pub const PROBE_1_POSITIVE_TIME: u16 = 0x60D1;
/// When the latched negative edge of touch probe 1 was, ns of the drive's own clock modulo 2³².
pub const PROBE_1_NEGATIVE_TIME: u16 = 0x60D2;
/// When the latched positive edge of touch probe 2 was, ns of the drive's own clock modulo 2³².
pub const PROBE_2_POSITIVE_TIME: u16 = 0x60D3;
/// When the latched negative edge of touch probe 2 was, ns of the drive's own clock modulo 2³².
pub const PROBE_2_NEGATIVE_TIME: u16 = 0x60D4;
/// Positive edges of touch probe 1.
pub const PROBE_1_POSITIVE_EDGES: u16 = 0x60D5;
/// Negative edges of touch probe 1.
pub const PROBE_1_NEGATIVE_EDGES: u16 = 0x60D6;
/// Positive edges of touch probe 2.
pub const PROBE_2_POSITIVE_EDGES: u16 = 0x60D7;
/// Negative edges of touch probe 2.
pub const PROBE_2_NEGATIVE_EDGES: u16 = 0x60D8;
/// Interpolation time period: value and power of ten of a second.
pub const INTERPOLATION_PERIOD: u16 = 0x60C2;
/// Supported homing methods.
pub const HOMING_METHODS: u16 = 0x60E3;
/// Following error, units.
pub const FOLLOWING_ERROR: u16 = 0x60F4;
/// Position demand, increments.
pub const POSITION_DEMAND_INCREMENTS: u16 = 0x60FC;
/// Digital inputs.
pub const DIGITAL_INPUTS: u16 = 0x60FD;
/// Digital outputs: levels and which of them are driven.
pub const DIGITAL_OUTPUTS: u16 = 0x60FE;
/// Target velocity, units/s.
pub const TARGET_VELOCITY: u16 = 0x60FF;
/// Supported drive modes.
pub const SUPPORTED_MODES: u16 = 0x6502;
