//! What an adapter hangs on: a serial device or a TCP connection.

use super::is_not_ready;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs as _};
use std::time::Duration;

/// For a TCP connection to be made.
const CONNECT: Duration = Duration::from_secs(5);

/// Of a serial line; adapters on USB take any.
const BAUD: u32 = 115_200;

/// The least that a read with a deadline waits: a socket's deadline must not be zero.
const LEAST: Duration = Duration::from_micros(1);

/// A line in both directions.
pub trait Line: Send {
    /// Gives bytes to the line; how many it took, 0 if it has no room now. Never waits long.
    ///
    /// # Errors
    /// When the line has failed.
    fn give(&mut self, bytes: &[u8]) -> io::Result<usize>;

    /// Takes bytes from the line; how many, 0 if none came in time.
    ///
    /// # Errors
    /// When the line has failed or ended.
    fn take(&mut self, bytes: &mut [u8], patience: Duration) -> io::Result<usize>;
}

/// A read that came to nothing is none of an error, but the end of the line is one.
fn taken(result: io::Result<usize>, end: bool) -> io::Result<usize> {
    match result {
        Ok(0) if end => Err(ErrorKind::UnexpectedEof.into()),
        Err(error) if is_not_ready(&error) => Ok(0),
        result => result,
    }
}

fn given(result: io::Result<usize>) -> io::Result<usize> {
    match result {
        Ok(0) => Err(ErrorKind::WriteZero.into()),
        Err(error) if is_not_ready(&error) => Ok(0),
        result => result,
    }
}

struct Tcp(TcpStream);

impl Line for Tcp {
    fn give(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.set_nonblocking(true)?;
        given(self.0.write(bytes))
    }

    fn take(&mut self, bytes: &mut [u8], patience: Duration) -> io::Result<usize> {
        self.0.set_nonblocking(patience.is_zero())?;
        if !patience.is_zero() {
            self.0.set_read_timeout(Some(patience.max(LEAST)))?;
        }
        taken(self.0.read(bytes), true)
    }
}

struct Serial(Box<dyn serialport::SerialPort>);

impl Line for Serial {
    fn give(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.set_timeout(Duration::ZERO)?;
        given(self.0.write(bytes))
    }

    fn take(&mut self, bytes: &mut [u8], patience: Duration) -> io::Result<usize> {
        self.0.set_timeout(patience)?;
        taken(self.0.read(bytes), false)
    }
}

pub(super) fn tcp(host: &str, port: u16) -> io::Result<Box<dyn Line>> {
    let mut last = io::Error::from(ErrorKind::AddrNotAvailable);
    for address in (host, port).to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, CONNECT) {
            Ok(stream) => {
                stream.set_nodelay(true)?;
                return Ok(Box::new(Tcp(stream)));
            }
            Err(error) => last = error,
        }
    }
    Err(last)
}

pub(super) fn device(path: &str) -> io::Result<Box<dyn Line>> {
    let port = serialport::new(path, BAUD).timeout(Duration::ZERO).open()?;
    Ok(Box::new(Serial(port)))
}
