//! Block transfer, the server's side.

use super::super::block::{self, Incoming, MAX_BLOCK, Outgoing, Taken, head};
use super::super::{Abort, Address, ObjectAccess, tail, with_address};
use super::{Server, State};

/// Where a block transfer is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Block {
    /// Segments come in.
    Receiving {
        announced: Option<usize>,
        crc: bool,
        incoming: Incoming,
        /// Bytes that came, the last segment's unused ones too.
        taken: usize,
    },
    /// All segments are here; the end is awaited.
    Ending {
        announced: Option<usize>,
        crc: bool,
        taken: usize,
    },
    /// The upload is agreed; the client's start is awaited.
    Promised { size: u8, crc: bool },
    /// Segments go out.
    Sending { outgoing: Outgoing, crc: bool },
    /// The end is out; the client's is awaited.
    Confirming,
}

/// The answer to a request, if any.
type Answer = Result<Option<[u8; 8]>, (Address, Abort)>;

impl<const N: usize> Server<N> {
    /// A client wants to write in blocks.
    pub(super) fn block_download(
        &mut self,
        request: [u8; 8],
        objects: &impl ObjectAccess,
    ) -> Answer {
        let [first, ..] = request;
        let at = Address::in_frame(request);
        if first & 1 != head::INITIATE {
            return Err((at, Abort::Command));
        }
        self.reset();
        let announced = u32::from_le_bytes(tail(request));
        let announced = usize::try_from(announced)
            .ok()
            .filter(|_| first & head::SIZED != 0);
        if announced.is_some_and(|len| len > N) {
            return Err((at, Abort::Memory));
        }
        objects.len(at).map_err(|abort| (at, abort))?;
        self.state = State::Block(
            at,
            Block::Receiving {
                announced,
                crc: first & head::CRC != 0,
                incoming: Incoming::new(MAX_BLOCK),
                taken: 0,
            },
        );
        let answer = head::SERVER_DOWNLOAD << 5 | head::CRC | head::INITIATE;
        Ok(Some(with_address(answer, at, [MAX_BLOCK, 0, 0, 0])))
    }

    /// A client wants to read in blocks.
    pub(super) fn block_upload(&mut self, request: [u8; 8], objects: &impl ObjectAccess) -> Answer {
        let [first, _, _, _, size, protocol_switch, ..] = request;
        let at = Address::in_frame(request);
        if first & 3 != head::INITIATE {
            return Err((at, Abort::Command));
        }
        self.reset();
        if !block::valid(size) {
            return Err((at, Abort::BlockSize));
        }
        let len = objects.len(at).map_err(|abort| (at, abort))?;
        if protocol_switch > 0 && len <= usize::from(protocol_switch) {
            // Short values go the other way: the client said so.
            return self.upload(request, objects).map(Some);
        }
        self.fill(at, objects)?;
        let crc = first & head::CRC != 0;
        self.state = State::Block(at, Block::Promised { size, crc });
        let answer = head::SERVER_UPLOAD << 5 | head::CRC | head::SIZED | head::INITIATE;
        let len = u32::try_from(self.buffer.len()).unwrap_or(u32::MAX);
        Ok(Some(with_address(answer, at, len.to_le_bytes())))
    }

    /// A request while a block transfer is under way; `None`: it is none of it.
    pub(super) fn on_block(
        &mut self,
        at: Address,
        block: Block,
        request: [u8; 8],
        objects: &mut impl ObjectAccess,
    ) -> Option<Answer> {
        let [first, second, third, ..] = request;
        let specifier = first >> 5;
        let subcommand = first & 3;
        match block {
            Block::Receiving {
                announced,
                crc,
                incoming,
                taken,
            } => Some(
                self.receive_block(at, request, (announced, crc), (incoming, taken))
                    .map_err(|abort| (at, abort)),
            ),
            Block::Ending {
                announced,
                crc,
                taken,
            } => {
                if specifier != head::CLIENT_DOWNLOAD || subcommand != head::END {
                    // The last segment once more: a frame was doubled.
                    return (first > 0x80 && specifier != head::CLIENT_UPLOAD).then_some(Ok(None));
                }
                let done = block::finish(request, taken, &mut self.buffer, announced, crc)
                    .and_then(|()| objects.write(at, &self.buffer));
                if let Err(abort) = done {
                    return Some(Err((at, abort)));
                }
                self.reset();
                let answer = head::SERVER_DOWNLOAD << 5 | head::END;
                Some(Ok(Some([answer, 0, 0, 0, 0, 0, 0, 0])))
            }
            Block::Promised { size, crc } => {
                if specifier != head::CLIENT_UPLOAD || subcommand != head::START {
                    return None;
                }
                let outgoing = Outgoing::new(size);
                self.state = State::Block(at, Block::Sending { outgoing, crc });
                Some(Ok(None))
            }
            Block::Sending { mut outgoing, crc } => {
                if specifier != head::CLIENT_UPLOAD || subcommand == head::INITIATE {
                    return None;
                }
                if subcommand == head::START {
                    return Some(Ok(None));
                }
                if subcommand != head::ACKNOWLEDGE {
                    return Some(Err((at, Abort::Command)));
                }
                Some(match outgoing.acknowledged(second, third, &self.buffer) {
                    Ok(true) => {
                        self.state = State::Block(at, Block::Confirming);
                        Ok(Some(block::end(head::SERVER_UPLOAD, &self.buffer, crc)))
                    }
                    Ok(false) => {
                        self.state = State::Block(at, Block::Sending { outgoing, crc });
                        Ok(None)
                    }
                    Err(abort) => Err((at, abort)),
                })
            }
            Block::Confirming => {
                if specifier != head::CLIENT_UPLOAD || subcommand == head::INITIATE {
                    return None;
                }
                if subcommand == head::END {
                    self.reset();
                }
                Some(Ok(None))
            }
        }
    }

    fn receive_block(
        &mut self,
        at: Address,
        request: [u8; 8],
        (announced, crc): (Option<usize>, bool),
        (mut incoming, taken): (Incoming, usize),
    ) -> Result<Option<[u8; 8]>, Abort> {
        let before = incoming.sequence();
        let outcome = incoming.take(request, &mut self.buffer)?;
        let came = match outcome {
            Taken::More => incoming.sequence() > before,
            Taken::Block(sequence) | Taken::All(sequence) => sequence > before,
        };
        let taken = taken.saturating_add(if came { 7 } else { 0 });
        let (next, answer) = match outcome {
            Taken::More => (None, None),
            Taken::Block(sequence) => (None, Some(sequence)),
            Taken::All(sequence) => (
                Some(Block::Ending {
                    announced,
                    crc,
                    taken,
                }),
                Some(sequence),
            ),
        };
        let next = next.unwrap_or(Block::Receiving {
            announced,
            crc,
            incoming,
            taken,
        });
        self.state = State::Block(at, next);
        Ok(answer.map(|sequence| block::acknowledge(head::SERVER_DOWNLOAD, sequence, MAX_BLOCK)))
    }

    /// The next segment of a block upload: to be asked for after each request until it is `None`, at
    /// most [`MAX_BLOCK`] times.
    pub fn next_segment(&mut self) -> Option<[u8; 8]> {
        let State::Block(_, Block::Sending { outgoing, .. }) = &mut self.state else {
            return None;
        };
        outgoing.next(&self.buffer)
    }
}
