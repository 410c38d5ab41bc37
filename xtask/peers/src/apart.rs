//! Ruckig in a process of its own, for cases of which nobody knows what they do to it: in version 0.19.4
//! it writes beyond an array on its stack where an axis has more possible profiles than it expects
//! (`PositionThirdOrderStep1::add_profile`), and is killed, with whoever called it.
//!
//! The child is this same program, started by [`Apart`]: it plans a range of cases and writes each
//! outcome to its standard output before it begins the next.

use crate::class::Class;
use crate::plan::{Batch as _, Outcome, Phase, Plan};
use crate::ruckig::Ruckig;
use crate::with_axes;
use std::ffi::OsStr;
use std::io::{self, BufReader, Read, Write};
use std::ops::Range;
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};

/// The first argument of a child; class, seed, axes, first case and the one after the last follow.
const APART: &str = "--plan-apart";
/// No text and no list in an outcome is longer.
const MOST: u64 = 1024;

/// The outcomes of Ruckig, case by case, from a child.
#[derive(Debug)]
pub struct Apart<'a> {
    program: &'a Path,
    class: Class,
    seed: u64,
    axes: usize,
    cases: Range<u64>,
    child: Option<(Child, BufReader<ChildStdout>)>,
}

impl<'a> Apart<'a> {
    /// To ask a range of cases of a class; `program` calls [`serve`] first of all.
    #[must_use]
    pub fn new(program: &'a Path, class: Class, seed: u64, axes: usize, cases: Range<u64>) -> Self {
        Self {
            program,
            class,
            seed,
            axes,
            cases,
            child: None,
        }
    }

    fn start(&self) -> io::Result<(Child, BufReader<ChildStdout>)> {
        let mut child = Command::new(self.program)
            .args([APART, self.class.letter()])
            .args(
                [
                    self.seed,
                    self.axes as u64,
                    self.cases.start,
                    self.cases.end,
                ]
                .map(|x| x.to_string()),
            )
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()?;
        let out = child.stdout.take().ok_or(io::ErrorKind::BrokenPipe)?;
        Ok((child, BufReader::new(out)))
    }

    /// The outcome of the next case. If the child is killed over it, that is the outcome, and the
    /// case after it gets a new child.
    ///
    /// # Errors
    /// The child cannot be started, or ended by itself without an outcome.
    pub fn ask_next(&mut self) -> io::Result<Outcome> {
        let (mut child, mut out) = match self.child.take() {
            Some(running) => running,
            None => self.start()?,
        };
        self.cases.start += 1;
        match read(&mut out) {
            Ok(outcome) => {
                if self.cases.is_empty() {
                    child.wait()?;
                } else {
                    self.child = Some((child, out));
                }
                Ok(outcome)
            }
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                let status = child.wait()?;
                if status.code().is_none() {
                    Ok(Outcome::Failed(format!("crash ({status})")))
                } else {
                    Err(io::Error::other(format!("Ruckig's own process: {status}")))
                }
            }
            Err(error) => Err(error),
        }
    }
}

impl Drop for Apart<'_> {
    fn drop(&mut self) {
        if let Some((mut child, _)) = self.child.take() {
            // it has ended, or nobody wants the rest
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// Plans and writes outcomes, if the arguments of this process ask for it: then nothing else is to be
/// done.
///
/// # Errors
/// The arguments are not understood, or whoever asked has gone.
pub fn serve() -> io::Result<bool> {
    let mut arguments = std::env::args_os().skip(1);
    if arguments.next().as_deref() != Some(OsStr::new(APART)) {
        return Ok(false);
    }
    let rest: Vec<_> = arguments.filter_map(|x| x.into_string().ok()).collect();
    let [class, numbers @ ..] = rest.as_slice() else {
        return Err(io::ErrorKind::InvalidInput.into());
    };
    let class: Class = class.parse().map_err(io::Error::other)?;
    let numbers: Vec<u64> = numbers.iter().filter_map(|x| x.parse().ok()).collect();
    let [seed, axes, first, end] = numbers[..] else {
        return Err(io::ErrorKind::InvalidInput.into());
    };
    with_axes!(axes, N => answer::<N>(class, seed, first..end))?;
    Ok(true)
}

fn answer<const N: usize>(class: Class, seed: u64, cases: Range<u64>) -> io::Result<()> {
    let mut out = io::stdout().lock();
    for index in cases {
        let outcome = Ruckig::new(&[class.case::<N>(seed, index)]).plan(0);
        let mut bytes = Vec::new();
        write(&outcome, &mut bytes);
        // at once: the next case may be the last
        out.write_all(&bytes)?;
        out.flush()?;
    }
    Ok(())
}

const PLANNED: u64 = 0;
const REFUSED: u64 = 1;
const FAILED: u64 = 2;

fn write(outcome: &Outcome, out: &mut Vec<u8>) {
    let mut put = |word: u64| out.extend(word.to_le_bytes());
    match outcome {
        Outcome::Planned(plan) => {
            put(PLANNED);
            put(plan.duration.to_bits());
            put(plan.axes.len() as u64);
            for axis in &plan.axes {
                put(axis.len() as u64);
                for phase in axis {
                    for number in [phase.t, phase.j, phase.a0, phase.v0, phase.p0] {
                        put(number.to_bits());
                    }
                }
            }
        }
        Outcome::Refused(why) | Outcome::Failed(why) => {
            let refused = matches!(outcome, Outcome::Refused(_));
            put(if refused { REFUSED } else { FAILED });
            put(why.len() as u64);
            out.extend(why.as_bytes());
        }
    }
}

fn read(from: &mut impl Read) -> io::Result<Outcome> {
    let kind = word(from)?;
    if kind == PLANNED {
        let duration = f64::from_bits(word(from)?);
        let axes = (0..length(from)?).map(|_| {
            let phases = (0..length(from)?).map(|_| phase(from));
            phases.collect()
        });
        let axes = axes.collect::<io::Result<_>>()?;
        return Ok(Outcome::Planned(Plan { duration, axes }));
    }
    let mut why = vec![0; usize::try_from(length(from)?).map_err(io::Error::other)?];
    from.read_exact(&mut why)?;
    let why = String::from_utf8(why).map_err(io::Error::other)?;
    match kind {
        REFUSED => Ok(Outcome::Refused(why)),
        FAILED => Ok(Outcome::Failed(why)),
        _ => Err(io::ErrorKind::InvalidData.into()),
    }
}

fn phase(from: &mut impl Read) -> io::Result<Phase> {
    let mut number = || Ok::<_, io::Error>(f64::from_bits(word(from)?));
    Ok(Phase {
        t: number()?,
        j: number()?,
        a0: number()?,
        v0: number()?,
        p0: number()?,
    })
}

fn word(from: &mut impl Read) -> io::Result<u64> {
    let mut bytes = [0; 8];
    from.read_exact(&mut bytes)?;
    Ok(u64::from_le_bytes(bytes))
}

fn length(from: &mut impl Read) -> io::Result<u64> {
    match word(from)? {
        length @ ..=MOST => Ok(length),
        _ => Err(io::ErrorKind::InvalidData.into()),
    }
}

#[cfg(test)]
mod test {
    use super::*;

    fn outcomes() -> [Outcome; 4] {
        let phase = Phase {
            t: 1.0,
            j: -0.0,
            a0: 3.5,
            v0: f64::MIN_POSITIVE,
            p0: f64::INFINITY,
        };
        [
            Outcome::Planned(Plan {
                duration: 2.5,
                axes: vec![vec![phase, phase], vec![]],
            }),
            Outcome::Planned(Plan::default()),
            Outcome::Refused(String::new()),
            Outcome::Failed("a reason".into()),
        ]
    }

    #[test]
    fn outcomes_go_through_a_pipe_unchanged() {
        let mut bytes = Vec::new();
        for outcome in &outcomes() {
            write(outcome, &mut bytes);
        }
        let mut from = bytes.as_slice();
        for outcome in outcomes() {
            assert_eq!(read(&mut from).unwrap(), outcome);
        }
        assert!(from.is_empty());
    }

    #[test]
    fn half_an_outcome_is_an_end_and_nonsense_is_an_error() {
        for outcome in outcomes() {
            let mut bytes = Vec::new();
            write(&outcome, &mut bytes);
            for cut in 0..bytes.len() {
                let error = read(&mut &bytes[..cut]).unwrap_err();
                assert_eq!(error.kind(), io::ErrorKind::UnexpectedEof);
            }
        }
        let bad = [
            [9_u64, 0].map(u64::to_le_bytes),
            [FAILED, MOST + 1].map(u64::to_le_bytes),
        ];
        for bytes in bad {
            let error = read(&mut bytes.as_flattened()).unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::InvalidData);
        }
    }
}
