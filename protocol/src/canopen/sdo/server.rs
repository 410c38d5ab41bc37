//! The SDO server: the drive's side.

mod block;

use block::Block;
use heapless::Vec;

use super::{
    ABORT, Abort, Address, CAPACITY, DEFAULT_TIMEOUT, ObjectAccess, abort_bytes, block::head, ccs,
    scs, segment, segment_tail, tail, with_address,
};
use crate::time::Micros;

#[derive(Clone, Debug, PartialEq, Eq)]
enum State {
    Idle,
    /// Segments come in; `announced` is the length the client promised.
    Receiving {
        at: Address,
        announced: Option<usize>,
        toggle: bool,
    },
    /// Segments go out; `sent` bytes of the buffer are gone.
    Sending {
        at: Address,
        sent: usize,
        toggle: bool,
    },
    /// A block transfer.
    Block(Address, Block),
}

/// One SDO server channel for objects of up to `N` bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Server<const N: usize = CAPACITY> {
    state: State,
    buffer: Vec<u8, N>,
    timeout: Micros,
    deadline: Micros,
}

impl<const N: usize> Default for Server<N> {
    fn default() -> Self {
        Self::new(DEFAULT_TIMEOUT)
    }
}

impl<const N: usize> Server<N> {
    /// A server that gives a segmented transfer up after `timeout` without the next segment.
    #[must_use]
    pub const fn new(timeout: Micros) -> Self {
        Self {
            state: State::Idle,
            buffer: Vec::new(),
            timeout,
            deadline: Micros(0),
        }
    }

    /// Forgets a transfer in progress.
    pub fn reset(&mut self) {
        self.state = State::Idle;
        self.buffer.clear();
    }

    /// When [`Self::poll`] has something to do, `None` while idle.
    #[must_use]
    pub fn deadline(&self) -> Option<Micros> {
        (self.state != State::Idle).then_some(self.deadline)
    }

    /// Gives up a transfer whose client fell silent: the abort to send.
    pub fn poll(&mut self, now: Micros) -> Option<[u8; 8]> {
        let at = match self.state {
            State::Idle => return None,
            State::Receiving { at, .. } | State::Sending { at, .. } | State::Block(at, _) => at,
        };
        (now >= self.deadline).then(|| self.abort(at, Abort::Timeout))
    }

    /// Answers a request; `None` if it needs no answer. Frames of another length than 8 are void.
    pub fn on_request(
        &mut self,
        now: Micros,
        data: &[u8],
        objects: &mut impl ObjectAccess,
    ) -> Option<[u8; 8]> {
        let request = <[u8; 8]>::try_from(data).ok()?;
        let [head, ..] = request;
        self.deadline = now + self.timeout;
        if let State::Block(at, block) = self.state
            && head != ABORT
            && let Some(answer) = self.on_block(at, block, request, objects)
        {
            return answer.unwrap_or_else(|(at, abort)| Some(self.abort(at, abort)));
        }
        let answer = match head >> 5 {
            ccs::DOWNLOAD => self.download(request, objects).map(Some),
            ccs::DOWNLOAD_SEGMENT => self.receive(request, objects).map(Some),
            ccs::UPLOAD => self.upload(request, objects).map(Some),
            ccs::UPLOAD_SEGMENT => self.send(request).map(Some),
            ccs::ABORT => {
                self.reset();
                return None;
            }
            head::CLIENT_DOWNLOAD => self.block_download(request, objects),
            head::CLIENT_UPLOAD => self.block_upload(request, objects),
            _ => Err((Address::in_frame(request), Abort::Command)),
        };
        answer.unwrap_or_else(|(at, abort)| Some(self.abort(at, abort)))
    }

    fn abort(&mut self, at: Address, abort: Abort) -> [u8; 8] {
        self.reset();
        abort_bytes(at, abort)
    }

    fn download(
        &mut self,
        request: [u8; 8],
        objects: &mut impl ObjectAccess,
    ) -> Result<[u8; 8], (Address, Abort)> {
        let [head, ..] = request;
        let at = Address::in_frame(request);
        self.reset();
        let (expedited, sized) = (head & 2 != 0, head & 1 != 0);
        if expedited {
            let unused = if sized { usize::from(head >> 2 & 3) } else { 0 };
            let mut len = 4_usize.saturating_sub(unused);
            if !sized {
                // Without a size the object's own length counts.
                len = objects.len(at).map_err(|abort| (at, abort))?;
            }
            let value = tail(request);
            let value = value.get(..len).ok_or((at, Abort::TooShort))?;
            objects.write(at, value).map_err(|abort| (at, abort))?;
        } else {
            let announced = u32::from_le_bytes(tail(request));
            let announced = usize::try_from(announced).ok().filter(|_| sized);
            if announced.is_some_and(|len| len > N) {
                return Err((at, Abort::Memory));
            }
            objects.len(at).map_err(|abort| (at, abort))?;
            self.state = State::Receiving {
                at,
                announced,
                toggle: false,
            };
        }
        Ok(with_address(scs::DOWNLOAD << 5, at, [0; 4]))
    }

    fn receive(
        &mut self,
        request: [u8; 8],
        objects: &mut impl ObjectAccess,
    ) -> Result<[u8; 8], (Address, Abort)> {
        let State::Receiving {
            at,
            announced,
            toggle,
        } = self.state
        else {
            return Err((Address::new(0, 0), Abort::Command));
        };
        let [head, ..] = request;
        if (head & 0x10 != 0) != toggle {
            return Err((at, Abort::Toggle));
        }
        let len = 7_usize.saturating_sub(usize::from(head >> 1 & 7));
        let chunk = segment_tail(request);
        let chunk = chunk.get(..len).unwrap_or_default();
        self.buffer
            .extend_from_slice(chunk)
            .map_err(|_| (at, Abort::Memory))?;
        if announced.is_some_and(|announced| self.buffer.len() > announced) {
            return Err((at, Abort::TooLong));
        }
        self.state = State::Receiving {
            at,
            announced,
            toggle: !toggle,
        };
        if head & 1 != 0 {
            if announced.is_some_and(|announced| self.buffer.len() != announced) {
                return Err((at, Abort::TooShort));
            }
            objects
                .write(at, &self.buffer)
                .map_err(|abort| (at, abort))?;
            self.reset();
        }
        Ok([
            scs::DOWNLOAD_SEGMENT << 5 | u8::from(toggle) << 4,
            0,
            0,
            0,
            0,
            0,
            0,
            0,
        ])
    }

    fn upload(
        &mut self,
        request: [u8; 8],
        objects: &impl ObjectAccess,
    ) -> Result<[u8; 8], (Address, Abort)> {
        let at = Address::in_frame(request);
        self.reset();
        self.fill(at, objects)?;
        let value = &self.buffer;
        let len = value.len();
        if let (1..=4, Ok(size)) = (len, u8::try_from(len)) {
            let mut rest = [0; 4];
            for (to, from) in rest.iter_mut().zip(value) {
                *to = *from;
            }
            let unused = 4_u8.saturating_sub(size);
            self.buffer.clear();
            return Ok(with_address(
                scs::UPLOAD << 5 | unused << 2 | 0b11,
                at,
                rest,
            ));
        }
        self.state = State::Sending {
            at,
            sent: 0,
            toggle: false,
        };
        let size = u32::try_from(len).unwrap_or(u32::MAX).to_le_bytes();
        Ok(with_address(scs::UPLOAD << 5 | 1, at, size))
    }

    /// The object's value into the empty buffer.
    fn fill(&mut self, at: Address, objects: &impl ObjectAccess) -> Result<(), (Address, Abort)> {
        let len = objects.len(at).map_err(|abort| (at, abort))?;
        self.buffer
            .resize_default(len)
            .map_err(|_| (at, Abort::Memory))?;
        let len = objects
            .read(at, &mut self.buffer)
            .map_err(|abort| (at, abort))?;
        self.buffer.truncate(len);
        Ok(())
    }

    fn send(&mut self, request: [u8; 8]) -> Result<[u8; 8], (Address, Abort)> {
        let State::Sending { at, sent, toggle } = self.state else {
            return Err((Address::new(0, 0), Abort::Command));
        };
        let [head, ..] = request;
        if (head & 0x10 != 0) != toggle {
            return Err((at, Abort::Toggle));
        }
        let rest = self.buffer.get(sent..).unwrap_or_default();
        let chunk = rest.get(..7).unwrap_or(rest);
        let last = chunk.len() == rest.len();
        let answer = segment(scs::UPLOAD_SEGMENT << 5, toggle, chunk, last);
        if last {
            self.reset();
        } else {
            self.state = State::Sending {
                at,
                sent: sent.saturating_add(7),
                toggle: !toggle,
            };
        }
        Ok(answer)
    }
}
