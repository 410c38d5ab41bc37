//! A connection to a hub, ours or any socketcand.

use super::element::{self, Answer, Cutter};
use crate::{Bus, BusError, Received, now, until};
use protocol::frame::Frame;
use protocol::time::Micros;
use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::thread;
use std::time::Duration;

/// Bytes not yet taken by the operating system; more is [`BusError::Full`].
const MAX_UNSENT: usize = 64 * 1024;

/// Between two attempts to connect.
const RETRY: Duration = Duration::from_millis(50);

/// A channel of a hub.
#[derive(Debug)]
pub struct HubClient {
    label: String,
    stream: TcpStream,
    cutter: Cutter,
    received: VecDeque<Received>,
    unsent: Vec<u8>,
    refused: Option<String>,
}

impl HubClient {
    /// Connects to `host:port` and opens a channel; tries again until `deadline`
    /// ([`crate::now`]) while nobody listens there.
    ///
    /// # Errors
    /// When nobody listens until the deadline, or the hub refuses.
    pub fn connect(
        host: &str,
        port: u16,
        channel: &str,
        deadline: Micros,
    ) -> Result<Self, BusError> {
        let label = format!("hub {host}:{port} channel {channel}");
        let stream = dial(&label, host, port, deadline)?;
        let mut client = Self {
            label,
            stream,
            cutter: Cutter::default(),
            received: VecDeque::new(),
            unsent: Vec::new(),
            refused: None,
        };
        client.handshake(channel, deadline)?;
        let quiet = client.stream.set_nonblocking(true);
        quiet.map_err(|source| client.io(source))?;
        Ok(client)
    }

    fn handshake(&mut self, channel: &str, deadline: Micros) -> Result<(), BusError> {
        let nodelay = self.stream.set_nodelay(true);
        nodelay.map_err(|source| self.io(source))?;
        let mut answers = VecDeque::new();
        for (expected, say) in [
            (Answer::Hi, format!("< open {channel} >")),
            (Answer::Ok, "< rawmode >".to_owned()),
            (Answer::Ok, String::new()),
        ] {
            match self.next_answer(&mut answers, deadline)? {
                answer if answer == expected => {}
                Answer::Error(reason) => return Err(self.open(format!("refused: {reason}"))),
                other => {
                    return Err(self.open(format!(
                        "not a socketcand server: expected {expected:?}, got {other:?}"
                    )));
                }
            }
            let said = self.stream.write_all(say.as_bytes());
            said.map_err(|source| self.io(source))?;
        }
        Ok(())
    }

    /// The next answer; frames that come after the last one are kept.
    fn next_answer(
        &mut self,
        answers: &mut VecDeque<Answer>,
        deadline: Micros,
    ) -> Result<Answer, BusError> {
        loop {
            if let Some(answer) = answers.pop_front() {
                // Frames may follow the last acknowledgement at once.
                for later in answers.drain(..) {
                    if let Answer::Frame(frame) = later {
                        self.received.push_back(Received { frame, at: now() });
                    }
                }
                return Ok(answer);
            }
            let left = until(deadline);
            if left.is_zero() {
                return Err(self.open("the server does not answer as a socketcand does".into()));
            }
            let timeout = self.stream.set_read_timeout(Some(left));
            timeout.map_err(|source| self.io(source))?;
            let mut bytes = [0; 4096];
            match self.stream.read(&mut bytes) {
                Ok(0) => return Err(self.lost("closed by the server")),
                Ok(read) => {
                    let bytes = bytes.get(..read).unwrap_or(&[]);
                    let cut = self.cutter.feed(bytes, &mut |text| {
                        answers.push_back(element::answer(text));
                        true
                    });
                    cut.map_err(|_| self.lost("an element is too long"))?;
                }
                Err(error) if is_not_ready(&error) => {}
                Err(source) => return Err(self.io(source)),
            }
        }
    }

    /// The last thing the hub refused, if any: told once.
    pub fn take_refusal(&mut self) -> Option<String> {
        self.refused.take()
    }

    fn io(&self, source: io::Error) -> BusError {
        BusError::Io {
            bus: self.label.clone(),
            source,
        }
    }

    fn open(&self, reason: String) -> BusError {
        BusError::Open {
            bus: self.label.clone(),
            reason,
        }
    }

    fn lost(&self, reason: &str) -> BusError {
        BusError::Lost {
            bus: self.label.clone(),
            reason: reason.to_owned(),
        }
    }

    /// Writes what is left, as far as the operating system takes it.
    fn flush(&mut self) -> Result<(), BusError> {
        while !self.unsent.is_empty() {
            match self.stream.write(&self.unsent) {
                Ok(0) => return Err(self.lost("closed by the server")),
                Ok(written) => {
                    self.unsent.drain(..written);
                }
                Err(error) if is_not_ready(&error) => break,
                Err(source) => return Err(self.io(source)),
            }
        }
        Ok(())
    }

    /// Reads once; `false` if nothing was there.
    fn fill(&mut self) -> Result<bool, BusError> {
        let mut bytes = [0; 4096];
        let read = match self.stream.read(&mut bytes) {
            Ok(0) => return Err(self.lost("closed by the server")),
            Ok(read) => read,
            Err(error) if is_not_ready(&error) => return Ok(false),
            Err(source) => return Err(self.io(source)),
        };
        let at = now();
        let (received, refused) = (&mut self.received, &mut self.refused);
        let cut = self
            .cutter
            .feed(bytes.get(..read).unwrap_or(&[]), &mut |text| {
                match element::answer(text) {
                    Answer::Frame(frame) => received.push_back(Received { frame, at }),
                    Answer::Error(reason) => *refused = Some(reason),
                    Answer::Hi | Answer::Ok | Answer::Echo | Answer::Other => {}
                }
                true
            });
        cut.map_err(|_| self.lost("an element is too long"))?;
        Ok(true)
    }
}

fn is_not_ready(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
    )
}

fn dial(label: &str, host: &str, port: u16, deadline: Micros) -> Result<TcpStream, BusError> {
    let fail = |reason: String| BusError::Open {
        bus: label.to_owned(),
        reason,
    };
    loop {
        let addresses: Vec<SocketAddr> = (host, port)
            .to_socket_addrs()
            .map_err(|error| fail(format!("no such host: {error}")))?
            .collect();
        let mut last = "no address".to_owned();
        for address in addresses {
            let left = until(deadline).max(Duration::from_millis(1));
            match TcpStream::connect_timeout(&address, left) {
                Ok(stream) => return Ok(stream),
                Err(error) => last = error.to_string(),
            }
        }
        if until(deadline).is_zero() {
            return Err(fail(format!(
                "no hub is listening ({last}); is mrroc-hil-sim running?"
            )));
        }
        thread::sleep(RETRY.min(until(deadline)));
    }
}

impl Bus for HubClient {
    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        if frame.is_fd() {
            return Err(BusError::FdUnsupported {
                bus: self.label.clone(),
            });
        }
        if self.unsent.len() >= MAX_UNSENT {
            self.flush()?;
            if self.unsent.len() >= MAX_UNSENT {
                return Err(BusError::Full {
                    bus: self.label.clone(),
                });
            }
        }
        let mut text = String::with_capacity(48);
        element::write_send(&mut text, frame);
        self.unsent.extend_from_slice(text.as_bytes());
        self.flush()
    }

    fn receive(&mut self) -> Result<Option<Received>, BusError> {
        if self.received.is_empty() {
            self.flush()?;
            self.fill()?;
        }
        Ok(self.received.pop_front())
    }

    fn wait(&mut self, deadline: Micros) -> Result<(), BusError> {
        self.flush()?;
        while self.received.is_empty() {
            let left = until(deadline);
            if left.is_zero() || self.fill()? {
                break;
            }
            // The only way std offers to wait for a socket with a deadline.
            let blocked = self
                .stream
                .set_nonblocking(false)
                .and_then(|()| self.stream.set_read_timeout(Some(left)));
            let filled = match blocked {
                Ok(()) => self.fill(),
                Err(source) => Err(self.io(source)),
            };
            let quiet = self.stream.set_nonblocking(true);
            quiet.map_err(|source| self.io(source))?;
            filled?;
        }
        Ok(())
    }
}
