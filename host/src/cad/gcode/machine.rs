//! What words do: the modes they set, and the steps they make.

mod motion;

use super::block::Block;
use super::cursor::Cursor;
use super::curve;
use super::expression::whole;
use crate::cad::step::{Action, Keeping, Step, What, distance};
use crate::input::{DataError, Problem};

/// Metres in an inch.
const INCH: f64 = 0.0254;
/// The greatest coordinate, m; nothing that a robot does is anywhere near.
const FARTHEST_M: f64 = 1e4;
/// The greatest feed, m/s.
const FASTEST: f64 = 100.0;
/// The longest dwell, s.
const LONGEST_S: f64 = 86_400.0;

/// The modal group of motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Motion {
    /// G80
    None,
    /// G0
    Rapid,
    /// G1
    Line,
    /// G2, or G3
    Arc { clockwise: bool },
    /// G5
    Cubic,
    /// G5.1
    Quadratic,
    /// G5.2
    Nurbs,
}

/// Where a line leads to, by axis, and its first axis.
type Target<'a> = ([Option<f64>; 3], Option<Cursor<'a>>);

/// Control points between G5.2 and G5.3.
#[derive(Clone, Debug)]
struct Open {
    line: u32,
    order: Option<usize>,
    control: Vec<([f64; 3], f64)>,
}

/// What holds until a word says otherwise.
#[derive(Clone, Debug)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is a mode of its own in RS-274"
)]
pub(super) struct Machine {
    /// Metres in a unit of length.
    pub(super) unit_m: f64,
    motion: Motion,
    /// The axes of the plane and the one across.
    plane: [usize; 3],
    absolute: bool,
    absolute_centre: bool,
    inverse_time: bool,
    /// m/s, or the inverse of seconds.
    feed: Option<f64>,
    speed_rev_s: f64,
    keeping: Keeping,
    /// Where the tool is, m, by axis; none where no word has said.
    at: [Option<f64>; 3],
    /// The other two control points of the cubic before, for one that goes on smoothly, m.
    smooth: Option<[f64; 3]>,
    open: Option<Open>,
    /// The work offset that the program uses, in tenths; none before anything moved.
    offset: Option<u32>,
    chosen_offset: u32,
    /// Is the program over?
    pub(super) over: bool,
    /// What has no effect here: the first time.
    pub(super) ignored: Option<&'static str>,
    /// Did a word say the unit?
    pub(super) unit_said: bool,
}

impl Machine {
    pub(super) const fn new(unit_m: f64) -> Self {
        Self {
            unit_m,
            motion: Motion::None,
            plane: [0, 1, 2],
            absolute: true,
            absolute_centre: false,
            inverse_time: false,
            feed: None,
            speed_rev_s: 0.0,
            keeping: Keeping::Task,
            at: [None; 3],
            smooth: None,
            open: None,
            offset: None,
            chosen_offset: 540,
            over: false,
            ignored: None,
            unit_said: false,
        }
    }

    /// Does what a line says, in the order of RS-274.
    pub(super) fn run(
        &mut self,
        block: &mut Block<'_>,
        line: u32,
        out: &mut impl FnMut(Step),
    ) -> Result<(), DataError> {
        let mut act = |action| {
            out(Step {
                line,
                what: What::Action(action),
            });
        };
        if let Some(open) = &self.open
            && let Some((_, cursor)) = block.m().first()
        {
            let what = format!("an M word within the spline of line {}", open.line);
            return Err(cursor.error(Problem::Conflict, what, "G5.3 before it", "M"));
        }
        let (mut dwell, mut motion, mut closes) = (false, None, false);
        for (code, cursor) in block.g() {
            match code {
                40 => dwell = true,
                53 => closes = true,
                0 | 10 | 20 | 30 | 50..=52 | 800 => motion = Some((*code, *cursor)),
                _ => {}
            }
        }
        self.feed(block)?;
        if let Some((speed, cursor)) = block.value(b's') {
            if !(0.0..=1e6).contains(&speed) {
                return Err(out_of_range(
                    &cursor,
                    "a spindle speed",
                    "0 to 1000000",
                    speed,
                ));
            }
            self.speed_rev_s = speed / 60.0;
        }
        self.tool(block, &mut act)?;
        self.modes(block)?;
        if dwell {
            let Some((seconds, cursor)) = block.value(b'p') else {
                let (_, cursor) = block
                    .g()
                    .first()
                    .copied()
                    .unwrap_or_else(|| (0, Cursor::new("", line)));
                return Err(cursor.wrong("a dwell", "P and seconds"));
            };
            if !(0.0..=LONGEST_S).contains(&seconds) {
                return Err(out_of_range(&cursor, "a dwell", "0 to 86400 s", seconds));
            }
            act(Action::Dwell(seconds));
        }
        if let Some((code, cursor)) = motion {
            self.mode(code, &cursor)?;
        }
        if closes {
            self.close(block, line, out)?;
        } else {
            self.moves(block, line, out)?;
        }
        let mut act = |action| {
            out(Step {
                line,
                what: What::Action(action),
            });
        };
        for (code, _) in block.m() {
            match code {
                0 | 10 => act(Action::Stop {
                    optional: *code == 10,
                }),
                20 | 300 => {
                    self.over = true;
                    act(Action::Spindle {
                        clockwise: None,
                        speed_rev_s: 0.0,
                    });
                }
                _ => {}
            }
        }
        block.all_used()
    }

    /// G93, G94 and F, with the units that the line asks for.
    fn feed(&mut self, block: &mut Block<'_>) -> Result<(), DataError> {
        for (code, _) in block.g() {
            match code {
                200 | 210 => {
                    self.unit_m = if *code == 200 { INCH } else { 1e-3 };
                    self.unit_said = true;
                }
                930 | 940 => {
                    let inverse = *code == 930;
                    if inverse != self.inverse_time {
                        self.inverse_time = inverse;
                        self.feed = None;
                    }
                }
                _ => {}
            }
        }
        if self.inverse_time {
            // holds for its line only
            self.feed = None;
        }
        let Some((feed, cursor)) = block.value(b'f') else {
            return Ok(());
        };
        let feed = if self.inverse_time {
            feed / 60.0
        } else {
            feed * self.unit_m / 60.0
        };
        if !(feed > 0.0 && feed <= FASTEST) {
            let expected = "greater than 0, at most 100 m/s";
            return Err(out_of_range(&cursor, "a feed", expected, feed));
        }
        self.feed = Some(feed);
        Ok(())
    }

    /// T, M3 to M9.
    fn tool(
        &mut self,
        block: &mut Block<'_>,
        act: &mut impl FnMut(Action),
    ) -> Result<(), DataError> {
        let changes = block.m().iter().any(|(code, _)| *code == 60);
        let chosen = block.value(b't');
        if let Some((tool, cursor)) = chosen {
            let Some(tool) = whole(tool) else {
                return Err(out_of_range(&cursor, "a tool", "a number from 0", tool));
            };
            if changes {
                act(Action::Tool(tool));
            } else {
                self.ignored = Some("T without M6");
            }
        } else if let Some((_, cursor)) = block.m().iter().find(|(code, _)| *code == 60) {
            return Err(cursor.wrong("a tool change", "T and a number in the same line"));
        }
        for (code, cursor) in block.m() {
            let clockwise = match code {
                30 => Some(true),
                40 => Some(false),
                50 => None,
                0 | 10 | 20 | 300 | 60 => continue,
                70 | 80 | 90 => {
                    self.ignored = Some("coolant (M7, M8, M9)");
                    continue;
                }
                480 | 490 => {
                    self.ignored = Some("override switches (M48, M49)");
                    continue;
                }
                _ => {
                    let expected = "M0 to M9, M30, M48 or M49";
                    return Err(cursor.wrong("an M code that is not known", expected));
                }
            };
            act(Action::Spindle {
                clockwise,
                speed_rev_s: if clockwise.is_some() {
                    self.speed_rev_s
                } else {
                    0.0
                },
            });
        }
        Ok(())
    }

    /// Every mode but that of motion.
    fn modes(&mut self, block: &mut Block<'_>) -> Result<(), DataError> {
        let codes: heapless::Vec<_, 14> = block.g().iter().copied().collect();
        for (code, cursor) in codes {
            match code {
                0 | 10 | 20 | 30 | 40 | 50..=53 | 800 | 200 | 210 | 930 | 940 => {}
                170 => self.plane = [0, 1, 2],
                180 => self.plane = [2, 0, 1],
                190 => self.plane = [1, 2, 0],
                400 => {
                    // cutter compensation off: a tool number may stand beside it
                    block.value(b'd');
                }
                430 | 490 => {
                    block.value(b'h');
                    self.ignored =
                        Some("tool length offset (G43, G49): the robot's tool has its own");
                }
                540..=593 if code % 10 == 0 || code > 590 => self.chosen_offset = code,
                610 | 611 => self.keeping = Keeping::Exact,
                640 => self.keeping = self.tolerance(block)?,
                900 | 910 => self.absolute = code == 900,
                901 | 911 => self.absolute_centre = code == 901,
                970 | 980 | 990 => self.ignored = Some("G97, G98, G99"),
                _ => return Err(refused(code, &cursor)),
            }
        }
        Ok(())
    }

    /// G64: P is the tolerance, Q that of joining lines, which is done within P.
    fn tolerance(&mut self, block: &mut Block<'_>) -> Result<Keeping, DataError> {
        if block.value(b'q').is_some() {
            self.ignored = Some("Q of G64: lines are joined within P");
        }
        let Some((within, cursor)) = block.value(b'p') else {
            return Ok(Keeping::Task);
        };
        let within = within * self.unit_m;
        if !(0.0..=0.1).contains(&within) {
            return Err(out_of_range(
                &cursor,
                "a path tolerance",
                "0 to 0.1 m",
                within,
            ));
        }
        Ok(if within > 0.0 {
            Keeping::Within(within)
        } else {
            Keeping::Exact
        })
    }

    fn mode(&mut self, code: u32, cursor: &Cursor<'_>) -> Result<(), DataError> {
        self.motion = match code {
            0 => Motion::Rapid,
            10 => Motion::Line,
            20 | 30 => Motion::Arc {
                clockwise: code == 20,
            },
            50 => Motion::Cubic,
            51 => Motion::Quadratic,
            52 => Motion::Nurbs,
            _ => Motion::None,
        };
        if let Some(open) = &self.open
            && code != 52
        {
            let what = format!("a motion within the spline of line {}", open.line);
            return Err(cursor.wrong(&what, "G5.3 before it"));
        }
        Ok(())
    }

    /// The program ends here.
    pub(super) fn end(&self) -> Result<(), DataError> {
        match &self.open {
            None => Ok(()),
            Some(open) => Err(DataError::at(
                (open.line, 1),
                Problem::Missing,
                "a spline without an end",
                "G5.3",
                "the end of the program",
            )),
        }
    }
}

pub(super) fn out_of_range(cursor: &Cursor<'_>, what: &str, expected: &str, got: f64) -> DataError {
    cursor.error(Problem::OutOfRange, what, expected, got.to_string())
}

fn tenths(code: u32) -> String {
    let (whole, tenth) = (code / 10, code % 10);
    if tenth == 0 {
        whole.to_string()
    } else {
        format!("{whole}.{tenth}")
    }
}

/// Why a code is not for a robot.
fn refused(code: u32, cursor: &Cursor<'_>) -> DataError {
    let why = match code {
        280 | 281 | 300 | 301 => "no G28, G30: the machine's own places are not the robot's",
        410..=429 => "no G41, G42: a path that is compensated already",
        100 | 101 | 520..=529 | 920..=929 => "no G10, G52, G92: the task places the program",
        530 => "no G53: the machine's coordinates are not the robot's",
        730 | 740 | 760 | 810..=890 => "no canned cycle: its moves written out",
        330..=339 => "no G33: the spindle and the robot are not coupled",
        380..=389 => "no G38: there is no probe",
        431..=439 => "G43 or G49",
        950 | 960 => "G94, or G93",
        _ => "G0 to G5.3, G17 to G21, G40, G43, G49, G54 to G59.3, G61, G64, G80, G90 to G94",
    };
    cursor.error(
        Problem::UnknownName,
        "a G code that cannot be done",
        why,
        format!("G{}", tenths(code)),
    )
}

/// Whether two points are the same to the micrometre.
pub(super) fn same(a: &[f64; 3], b: &[f64; 3]) -> bool {
    distance(a, b) <= 1e-6
}
