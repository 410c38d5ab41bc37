use super::element::{Answer, Command, Cutter, answer, command, write_frame, write_send};
use super::*;
use crate::{Bus as _, BusError, now};
use proptest::prelude::*;
use protocol::frame::{Frame, Id};
use protocol::time::Micros;
use std::io::{Read as _, Write as _};
use std::net::{Ipv4Addr, SocketAddr, TcpStream};

fn frame(id: Id, data: &[u8]) -> Frame {
    Frame::classic(id, data).unwrap()
}

fn server(channels: &[&str]) -> HubServer {
    HubServer::bind(SocketAddr::from((Ipv4Addr::LOCALHOST, 0)), channels).unwrap()
}

fn in_ms(ms: u64) -> Micros {
    now() + Micros::from_millis(ms)
}

fn client(server: &HubServer, channel: &str) -> HubClient {
    HubClient::connect("127.0.0.1", server.address().port(), channel, in_ms(10_000)).unwrap()
}

/// A client that types.
struct Terminal(TcpStream);

impl Terminal {
    fn connect(server: &HubServer) -> Self {
        let stream = TcpStream::connect(server.address()).unwrap();
        stream
            .set_read_timeout(Some(Duration::from_secs(10)))
            .unwrap();
        Self(stream)
    }

    fn say(&mut self, text: &str) {
        self.0.write_all(text.as_bytes()).unwrap();
    }

    /// One packet, as python-can's handshake reads it.
    fn packet(&mut self) -> String {
        let mut bytes = [0; 256];
        let read = self.0.read(&mut bytes).unwrap();
        String::from_utf8(bytes[..read].to_vec()).unwrap()
    }

    fn expect(&mut self, text: &str) {
        let mut bytes = vec![0; text.len()];
        self.0.read_exact(&mut bytes).unwrap();
        assert_eq!(String::from_utf8(bytes).unwrap(), text);
    }

    /// Until the server closes.
    fn rest(&mut self) -> String {
        let mut text = String::new();
        let _ = self.0.read_to_string(&mut text);
        text
    }

    fn open(server: &HubServer, channel: &str) -> Self {
        let mut terminal = Self::connect(server);
        terminal.expect("< hi >");
        terminal.say(&format!("< open {channel} >"));
        terminal.expect("< ok >");
        terminal
    }
}

/// Waits until a frame is there; own patience, not a measured time.
fn next(bus: &mut impl crate::Bus) -> Frame {
    let deadline = in_ms(10_000);
    loop {
        if let Some(received) = bus.receive().unwrap() {
            return received.frame;
        }
        assert!(now() < deadline, "nothing came");
        bus.wait(deadline).unwrap();
    }
}

#[test]
fn the_handshake_of_python_can() {
    let server = server(&["mp"]);
    let mut tap = server.tap("mp").unwrap();
    let mut terminal = Terminal::connect(&server);
    assert_eq!(terminal.packet(), "< hi >");
    terminal.say("< open mp >");
    assert_eq!(terminal.packet(), "< ok >");
    terminal.say("< rawmode >");
    // Frames are under way already: none may share the packet of the acknowledgement.
    let quick = std::thread::spawn(move || {
        for _ in 0..50 {
            tap.send(&frame(Id::Standard(1), &[])).unwrap();
            std::thread::sleep(Duration::from_millis(1));
        }
        tap
    });
    assert_eq!(terminal.packet(), "< ok >");
    let mut tap = quick.join().unwrap();
    terminal.say("< send 123 2 1 F1 >");
    assert_eq!(next(&mut tap), frame(Id::Standard(0x123), &[1, 0xF1]));
    // python-can writes two spaces before the bracket of a frame without data.
    terminal.say("< send 1AAAAAAA 0  >");
    assert_eq!(next(&mut tap), frame(Id::Extended(0x1AAA_AAAA), &[]));
}

#[test]
fn frames_are_written_as_socketcand_writes_them() {
    let mut text = String::new();
    write_frame(
        &mut text,
        &frame(Id::Standard(0x23), &[0x11, 2]),
        23_424_242,
    );
    assert_eq!(text, "< frame 023 23.424242 1102 >");
    text.clear();
    write_frame(&mut text, &frame(Id::Extended(0x23), &[]), 1);
    assert_eq!(text, "< frame 00000023 0.000001  >");
    text.clear();
    write_send(&mut text, &frame(Id::Standard(0x7FF), &[0, 0xAB]));
    assert_eq!(text, "< send 7FF 2 00 AB >");
}

#[test]
fn clients_and_taps_of_a_channel_hear_each_other_and_no_other_channel() {
    let server = server(&["mp", "drives"]);
    let mut a = client(&server, "mp");
    let mut b = client(&server, "mp");
    let mut tap = server.tap("mp").unwrap();
    let mut elsewhere = client(&server, "drives");
    for (k, id) in [Id::Standard(0), Id::Extended(0x1FFF_FFFF)]
        .into_iter()
        .enumerate()
    {
        let sent = frame(id, &[1, 2, 3, 4, 5, 6, 7, 8][..=k]);
        a.send(&sent).unwrap();
        assert_eq!(next(&mut b), sent);
        assert_eq!(next(&mut tap), sent);
        tap.send(&sent).unwrap();
        assert_eq!(next(&mut a), sent);
        assert_eq!(next(&mut b), sent);
    }
    assert_eq!(a.receive().unwrap(), None);
    assert_eq!(elsewhere.receive().unwrap(), None);
    assert_eq!(
        (server.frames(), server.dropped(), server.clients()),
        (4, 0, 3)
    );
    assert!(server.tap("none").is_none());
}

#[test]
fn order_is_kept_in_bulk() {
    let server = server(&["mp"]);
    let mut a = client(&server, "mp");
    let mut b = client(&server, "mp");
    let mut expected = 0u32;
    for k in 0..3000u32 {
        a.send(&frame(Id::Extended(k), &k.to_le_bytes())).unwrap();
        while let Some(received) = b.receive().unwrap() {
            assert_eq!(received.frame.id(), Id::Extended(expected));
            expected += 1;
        }
    }
    while expected < 3000 {
        assert_eq!(next(&mut b).id(), Id::Extended(expected));
        expected += 1;
    }
    assert_eq!(server.dropped(), 0);
}

#[test]
fn bad_commands_get_an_error_line_and_harm_nobody() {
    let server = server(&["mp"]);
    let mut tap = server.tap("mp").unwrap();
    let mut terminal = Terminal::connect(&server);
    terminal.expect("< hi >");
    terminal.say("< send 123 0 >");
    terminal.expect("< error open a bus first >");
    terminal.say("<open mp>");
    terminal.expect("< ok >");
    for (said, part) in [
        ("< fdsend 123 1 0 >", "CAN FD"),
        ("< send 123 9 1 2 3 4 5 6 7 8 9 >", "CAN FD"),
        ("< sendrtr 123 0 >", "remote"),
        ("< subscribe 0 0 123 >", "rawmode"),
        ("< isotpmode >", "rawmode"),
        ("< open mp >", "already"),
        ("< send 123 2 1 >", "syntax"),
        ("< send 123 1 1 2 >", "syntax"),
        ("< send 123 1 100 >", "syntax"),
        ("< send 123 1 +1 >", "syntax"),
        ("< send 800 0 >", "syntax"),
        ("< send 20000000 0 >", "syntax"),
        ("< send 1234 0 >", "syntax"),
        ("< send >", "unknown"),
        ("< >", "unknown"),
        ("<<<< open mp x >", "unknown"),
        ("\u{0}é < é >", "unknown"),
    ] {
        terminal.say(said);
        let answer = terminal.packet();
        assert!(
            answer.starts_with("< error ") && answer.contains(part),
            "{said}: {answer}"
        );
        assert!(answer.ends_with(" >") && answer.matches('<').count() == 1);
    }
    terminal.say("noise < echo > noise");
    terminal.expect("< echo >");
    terminal.say("< bcmmode >< rawmode >< rawmode >< bcmmode >< rawmode >");
    terminal.expect(&"< ok >".repeat(5));
    terminal.say("< send 001 1 FF >");
    assert_eq!(next(&mut tap), frame(Id::Standard(1), &[0xFF]));
    assert_eq!(tap.receive().unwrap(), None);
}

#[test]
fn an_unknown_channel_and_an_endless_command_end_the_connection() {
    let server = server(&["mp", "drives"]);
    let mut terminal = Terminal::connect(&server);
    terminal.say("< open can0 >");
    let said = terminal.rest();
    assert!(
        said.ends_with("< error could not open bus: this hub has mp, drives >"),
        "{said}"
    );
    let mut terminal = Terminal::open(&server, "mp");
    terminal.say(&format!("< send {}", "1".repeat(5000)));
    assert!(terminal.rest().contains("too long"));
    let refused = HubClient::connect("127.0.0.1", server.address().port(), "can0", in_ms(10_000));
    let line = refused.unwrap_err().to_string();
    assert!(
        line.contains("refused") && line.contains("mp, drives"),
        "{line}"
    );
}

#[test]
fn the_hub_has_room_for_so_many() {
    let server = server(&["mp"]);
    let clients: Vec<Terminal> = (0..MAX_CLIENTS)
        .map(|_| Terminal::open(&server, "mp"))
        .collect();
    let mut one_more = Terminal::connect(&server);
    assert!(one_more.rest().contains("too many clients"));
    drop(clients);
    let deadline = in_ms(10_000);
    while server.clients() > 0 {
        assert!(now() < deadline);
        std::thread::sleep(Duration::from_millis(1));
    }
    Terminal::open(&server, "mp");
}

#[test]
fn who_does_not_read_loses_frames_and_delays_nobody() {
    let server = server(&["mp"]);
    let mut deaf = server.tap("mp").unwrap();
    let mut a = server.tap("mp").unwrap();
    let extra = 100;
    for k in 0..QUEUE + extra {
        a.send(&frame(Id::Standard(1), &k.to_le_bytes())).unwrap();
    }
    assert_eq!(server.dropped(), extra as u64);
    assert_eq!(next(&mut deaf).data(), 0usize.to_le_bytes());
}

#[test]
fn what_cannot_be_sent_or_bound_is_told_in_one_line() {
    let server = server(&["mp"]);
    let fd = Frame::fd(Id::Standard(1), &[0; 12]).unwrap();
    let mut a = client(&server, "mp");
    let mut tap = server.tap("mp").unwrap();
    assert!(matches!(a.send(&fd), Err(BusError::FdUnsupported { .. })));
    assert!(matches!(tap.send(&fd), Err(BusError::FdUnsupported { .. })));
    let errors = [
        HubServer::bind(server.address(), &["mp"]).unwrap_err(),
        HubServer::bind(SocketAddr::from(([0, 0, 0, 0], 0)), &["mp"]).unwrap_err(),
        HubServer::bind(SocketAddr::from((Ipv4Addr::LOCALHOST, 0)), &["a", "a"]).unwrap_err(),
        HubServer::bind(SocketAddr::from((Ipv4Addr::LOCALHOST, 0)), &["a b"]).unwrap_err(),
        HubServer::bind(SocketAddr::from((Ipv4Addr::LOCALHOST, 0)), &[""]).unwrap_err(),
    ];
    for error in errors {
        let line = error.to_string();
        assert!(line.starts_with("hub ") && !line.contains('\n'), "{line}");
    }
}

#[test]
fn the_end_of_the_hub_is_noticed() {
    let server = server(&["mp"]);
    let port = server.address().port();
    let mut a = client(&server, "mp");
    drop(server);
    let deadline = in_ms(10_000);
    let error = loop {
        match a.wait(deadline).and_then(|()| a.receive()) {
            Ok(None) => assert!(now() < deadline),
            Ok(Some(frame)) => panic!("{frame:?}"),
            Err(error) => break error,
        }
    };
    assert!(error.to_string().contains("hub 127.0.0.1"), "{error}");
    let none = HubClient::connect("127.0.0.1", port, "mp", in_ms(120)).unwrap_err();
    assert!(none.to_string().contains("no hub is listening"), "{none}");
}

#[test]
fn a_client_may_come_before_the_hub() {
    let port = server(&["mp"]).address().port();
    let early = std::thread::spawn(move || {
        HubClient::connect("127.0.0.1", port, "mp", in_ms(10_000)).map(|_| ())
    });
    std::thread::sleep(Duration::from_millis(60));
    let address = SocketAddr::from((Ipv4Addr::LOCALHOST, port));
    let _server = HubServer::bind(address, &["mp"]).unwrap();
    early.join().unwrap().unwrap();
}

proptest! {
    #[test]
    fn frames_survive_both_texts(
        extended: bool, id in 0u32..=0x1FFF_FFFF, epoch_us: u64,
        data in proptest::collection::vec(any::<u8>(), 0..=8),
    ) {
        let id = if extended { Id::Extended(id) } else { Id::Standard((id % 0x800) as u16) };
        let sent = frame(id, &data);
        let (mut server, mut client) = (String::new(), String::new());
        write_frame(&mut server, &sent, epoch_us);
        write_send(&mut client, &sent);
        prop_assert!(server.len() < MAX_ELEMENT && client.len() < MAX_ELEMENT);
        let inner = |text: &str| text[1..text.len() - 1].trim().to_owned();
        prop_assert_eq!(answer(&inner(&server)), Answer::Frame(sent));
        prop_assert_eq!(command(&inner(&client)), Command::Send(sent));
    }

    /// However the stream is cut into packets, the elements are the same.
    #[test]
    fn packets_do_not_matter(text in "[<> a-z]{0,80}", cut in 0usize..80) {
        let all = |pieces: &[&[u8]]| {
            let (mut cutter, mut found) = (Cutter::default(), Vec::new());
            for piece in pieces {
                cutter.feed(piece, &mut |element| {
                    found.push(element.to_owned());
                    true
                }).unwrap();
            }
            found
        };
        let bytes = text.as_bytes();
        let (head, tail) = bytes.split_at(cut.min(bytes.len()));
        prop_assert_eq!(all(&[bytes]), all(&[head, tail]));
    }

    #[test]
    fn any_bytes_are_cut_and_read(bytes in proptest::collection::vec(any::<u8>(), 0..1000)) {
        let mut cutter = Cutter::default();
        let _ = cutter.feed(&bytes, &mut |element| {
            let _ = (command(element), answer(element));
            element.len() < MAX_ELEMENT
        });
    }
}
