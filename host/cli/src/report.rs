//! What a person sees of a run while it runs: on stderr, one line a thing.

use host::error::fault_text;
use host::mp::event::What;
use host::program::{Progress, Run};
use protocol::message::HomingPhase;
use protocol::time::Micros;
use std::io::{IsTerminal, Write};

/// Prints progress, or nothing.
#[derive(Debug)]
pub(crate) struct Reporter {
    quiet: bool,
    terminal: bool,
    checklist_shown: bool,
}

impl Reporter {
    pub(crate) fn new(quiet: bool) -> Self {
        Self {
            quiet,
            terminal: std::io::stderr().is_terminal(),
            checklist_shown: false,
        }
    }

    fn line(now: Micros, text: &str) {
        // a closed stderr is no reason to stop a robot
        let _ = writeln!(std::io::stderr(), "{:9.3} s  {text}", now.as_secs_f64());
    }

    pub(crate) fn progress(&mut self, run: &Run, now: Micros, progress: &Progress) {
        if self.quiet {
            return;
        }
        let name = |robot: usize| {
            run.mp()
                .robots()
                .get(robot)
                .map_or("?", |image| image.config().name.as_str())
        };
        match progress {
            Progress::Ready => {
                self.checklist(run);
            }
            Progress::StepBegan { step, of, name } => {
                Self::line(now, &format!("step {step}/{of}: {name}"));
            }
            Progress::Node {
                robot, node, of, ..
            } if *of > 1 => {
                Self::line(now, &format!("    {}: node {node}/{of}", name(*robot)));
            }
            Progress::Path {
                robot,
                tenths,
                length_m,
            } => {
                let (share, of) = (10 * tenths, name(*robot));
                Self::line(now, &format!("    {of}: {share:3} % of {length_m:.3} m"));
            }
            Progress::AtRest => Self::line(now, "at rest"),
            Progress::Robot(event) => match &event.what {
                What::Homing { robot, axis, phase } => {
                    let axes = run.mp().robots().get(*robot).map(|i| i.arm().axes());
                    let axis = axes
                        .and_then(|a| a.get(usize::from(*axis)))
                        .map_or("?", |a| a.name);
                    // the phases in between are for terminals, where lines are cheap to read
                    if *phase == HomingPhase::Done || self.terminal {
                        Self::line(
                            now,
                            &format!("    {}: {axis}: {}", name(*robot), homing(*phase)),
                        );
                    }
                }
                What::Fault { robot, fault } => {
                    Self::line(now, &format!("{}: {}", name(*robot), fault_text(fault)));
                }
                What::DriveFound { robot, found } => {
                    Self::line(now, &format!("{}: {found}", name(*robot)));
                }
                What::Lost { robot } => {
                    Self::line(now, &format!("{}: its node is silent", name(*robot)));
                }
                What::StopAll { by_other: true, .. } => {
                    Self::line(now, "another participant stopped everyone");
                }
                _ => {}
            },
            _ => {}
        }
    }

    fn checklist(&mut self, run: &Run) {
        if core::mem::replace(&mut self.checklist_shown, true) {
            return;
        }
        for checklist in run.checklists() {
            let _ = writeln!(std::io::stderr(), "{checklist}");
        }
    }
}

/// The words for a phase of homing.
const fn homing(phase: HomingPhase) -> &'static str {
    match phase {
        HomingPhase::Coarse => "to the switch",
        HomingPhase::Settle => "settles on the switch",
        HomingPhase::BackOff => "backs off",
        HomingPhase::Index => "looks for the index",
        HomingPhase::Done => "homed",
    }
}
