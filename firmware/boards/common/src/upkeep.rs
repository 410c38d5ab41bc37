//! Those who keep a node on a board: the recorder within the servo steps, the librarian below them.
//!
//! A request that the recorder cannot answer goes to the librarian's desk, and its answer comes back with a later servo step:
//! erasing a page of flash takes longer than many of them. One request is at the desk at a time; who gets no answer
//! asks again.

use crate::tandem::Tray;
use embedded_storage::nor_flash::NorFlash;
use firmware::maintenance::black_box::Memory;
use firmware::maintenance::{Asked, Librarian, Maintainable, Recorder};
use firmware::{NodeProcess, Port, Received};
use protocol::frame::Frame;
use protocol::maintenance::MaintenanceReply;
use protocol::message::{Identity, NodeState};
use protocol::time::Micros;

/// Between the priorities: what is asked, and what is answered.
#[derive(Debug)]
pub struct Desk {
    asked: Tray<(Asked, Identity)>,
    answered: Tray<(Asked, MaintenanceReply)>,
}

impl Desk {
    /// Empty.
    #[expect(clippy::new_without_default, reason = "a static")]
    #[must_use]
    pub const fn new() -> Self {
        Self {
            asked: Tray::new(),
            answered: Tray::new(),
        }
    }
}

/// A node whose servo steps are recorded.
pub struct Recorded<'a, M> {
    node: &'a mut (dyn Maintainable + Send),
    recorder: Recorder<M>,
    desk: &'a Desk,
}

impl<'a, M: Memory> Recorded<'a, M> {
    /// By this recorder.
    pub fn new(
        node: &'a mut (dyn Maintainable + Send),
        recorder: Recorder<M>,
        desk: &'a Desk,
    ) -> Self {
        Self {
            node,
            recorder,
            desk,
        }
    }
}

/// It does not tell what is inside it: texts can panic.
impl<M> core::fmt::Debug for Recorded<'_, M> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("recorded node")
    }
}

impl<M: Memory> NodeProcess for Recorded<'_, M> {
    fn step(&mut self, now: Micros, rx: &[Received], tx: &mut dyn FnMut(Port, Frame)) {
        let Self {
            node,
            recorder,
            desk,
        } = self;
        let before = node.servo_step();
        node.step(now, rx, tx);
        if node.servo_step() != before {
            recorder.record(&node.signals(), node.identity().servo_step_us);
            // behind the set-points of this step, and once: there is half a servo period for it
            recorder.seal();
        }
        if let Some((asked, reply)) = desk.answered.take() {
            node.answer(&asked, &reply, tx);
        }
        if let Some(asked) = node.take_asked() {
            let identity = node.identity();
            match recorder.answer(&asked, &identity, node.servo_step()) {
                Some(reply) => node.answer(&asked, &reply, tx),
                None => desk.asked.put((asked, identity)),
            }
        }
    }

    fn next_wake(&self) -> Micros {
        self.node.next_wake()
    }

    fn state(&self) -> NodeState {
        self.node.state()
    }

    fn identity(&self) -> Identity {
        self.node.identity()
    }

    fn wants_time(&mut self) -> bool {
        self.node.wants_time()
    }
}

/// The librarian at the desk.
#[derive(Debug)]
pub struct Clerk<'a, F> {
    librarian: Librarian<F>,
    desk: &'a Desk,
}

impl<'a, F: NorFlash> Clerk<'a, F> {
    /// Of this desk.
    pub const fn new(librarian: Librarian<F>, desk: &'a Desk) -> Self {
        Self { librarian, desk }
    }

    /// Answers what is at the desk. Then, is the board to restart? The answer to that wish has yet to be sent.
    pub fn attend(&mut self) -> bool {
        if let Some((asked, identity)) = self.desk.asked.take() {
            let reply = self.librarian.answer(&asked, &identity);
            self.desk.answered.put((asked, reply));
        }
        self.librarian.restarts()
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use crate::store::test::Torn;
    use firmware::maintenance::Start;
    use firmware::maintenance::black_box::{BlackBox, Signals, bytes};
    use protocol::id::NodeId;
    use protocol::maintenance::{MaintenanceRefusal, MaintenanceRequest, ResetCause};
    use protocol::transfer::TransferId;
    use std::vec;
    use std::vec::Vec;

    /// A node that makes a servo step whenever it is called, and is asked what its test wants to know.
    #[derive(Debug, Default)]
    struct Scripted {
        step: u32,
        to_ask: Vec<MaintenanceRequest>,
        asked: usize,
        answers: Vec<(MaintenanceRequest, MaintenanceReply)>,
    }

    impl NodeProcess for Scripted {
        fn step(&mut self, _: Micros, _: &[Received], _: &mut dyn FnMut(Port, Frame)) {
            self.step += 1;
        }
        fn next_wake(&self) -> Micros {
            Micros(0)
        }
        fn state(&self) -> NodeState {
            NodeState::Disabled
        }
        fn identity(&self) -> Identity {
            Identity {
                robot: "conveyor".try_into().unwrap(),
                axes: 1,
                unique_id: 7,
                protocol: (1, 1),
                schema_hash: 3,
                config_crc: 4,
                firmware: (0, 1, 0),
                macrostep: 10,
                servo_step_us: 2000,
            }
        }
    }

    impl Maintainable for Scripted {
        fn servo_step(&self) -> u32 {
            self.step
        }
        fn signals(&self) -> Signals {
            Signals {
                step: self.step,
                state: NodeState::Disabled,
                fault: None,
                instruction: 0,
                axes: [protocol::maintenance::AxisSample {
                    actual: 0,
                    error: 0,
                    current_ma: 0,
                }]
                .into_iter()
                .collect(),
            }
        }
        fn take_asked(&mut self) -> Option<Asked> {
            // one after the other, as by a client
            if self.answers.len() < self.asked {
                return None;
            }
            self.asked += 1;
            Some(Asked {
                from: NodeId::new(3).unwrap(),
                transfer_id: TransferId::default(),
                allowed: Ok(()),
                request: self.to_ask.pop()?,
            })
        }
        fn answer(
            &mut self,
            asked: &Asked,
            reply: &MaintenanceReply,
            _: &mut dyn FnMut(Port, Frame),
        ) {
            self.answers.push((asked.request.clone(), reply.clone()));
        }
    }

    #[test]
    fn what_is_quick_is_answered_at_once_and_the_rest_when_the_clerk_had_time() {
        let start = Start {
            target: "stm32g474".try_into().unwrap(),
            cause: ResetCause::Watchdog,
            boots: 4,
        };
        let clerks = Librarian::<Torn>::new(start.target.clone(), None);
        let desk = Desk::new();
        let mut clerk = Clerk::new(clerks, &desk);
        let to_ask = vec![
            MaintenanceRequest::Restart { epoch: 1 },
            MaintenanceRequest::Image,
            MaintenanceRequest::Identify,
            MaintenanceRequest::FirstFault,
            MaintenanceRequest::ResetCause,
        ];
        let mut node = Scripted {
            to_ask,
            ..Scripted::default()
        };
        let memory = vec![0; bytes(1)].leak();
        let black_box = BlackBox::open(memory, 1).unwrap();
        let recorder = Recorder::new(start, black_box);
        let mut restarts = vec![];
        {
            let mut recorded = Recorded::new(&mut node, recorder, &desk);
            for step in 0..12 {
                recorded.step(Micros(0), &[], &mut |_, _| {});
                // the clerk comes by every second step
                if step % 2 == 1 {
                    restarts.push(clerk.attend());
                }
            }
        }
        let reply = |k: usize| &node.answers[k].1;
        assert_eq!(node.answers.len(), 5, "{:?}", node.answers);
        assert!(
            matches!(reply(0), MaintenanceReply::Reset(r) if (r.cause, r.boots, r.steps) == (ResetCause::Watchdog, 4, 1))
        );
        assert_eq!(*reply(1), MaintenanceReply::NoFault);
        assert!(
            matches!(reply(2), MaintenanceReply::Identity(i) if i.target == "stm32g474" && i.robot == "conveyor")
        );
        let refused = MaintenanceReply::Refused(MaintenanceRefusal::NoSlots);
        assert_eq!(*reply(3), refused);
        // the wish is granted, and its answer is on its way a step before anything comes of it
        assert_eq!(*reply(4), MaintenanceReply::Done);
        let granted = restarts.iter().position(|r| *r);
        assert!(
            granted.is_some_and(|k| k < restarts.len() - 1),
            "{restarts:?}"
        );
    }
}
