use super::*;
use proptest::prelude::*;

fn hub(host: &str, port: u16) -> BusSpec {
    BusSpec::Place(Place::hub(host, port))
}

fn can(interface: &str) -> BusSpec {
    BusSpec::Place(Place::Can {
        interface: interface.to_owned(),
    })
}

fn slcan(adapter: Adapter) -> BusSpec {
    BusSpec::Place(Place::Slcan(adapter))
}

#[test]
fn what_names_a_bus() {
    for (text, bus) in [
        ("virtual", BusSpec::Virtual),
        ("hub", hub("127.0.0.1", 29536)),
        ("hub:30000", hub("127.0.0.1", 30000)),
        ("hub:localhost:1", hub("localhost", 1)),
        ("hub:[::1]:65535", hub("::1", 65535)),
        ("can:can0", can("can0")),
        ("can:vcan-mp.0", can("vcan-mp.0")),
        (
            "slcan:/dev/ttyACM0",
            slcan(Adapter::Device("/dev/ttyACM0".into())),
        ),
        ("slcan:COM3", slcan(Adapter::Device("COM3".into()))),
        (
            "slcan:[::1]:3333",
            slcan(Adapter::Tcp {
                host: "::1".into(),
                port: 3333,
            }),
        ),
    ] {
        let place = match &bus {
            BusSpec::Virtual => Err(SpecError::Virtual),
            BusSpec::Place(place) => Ok(place.clone()),
        };
        assert_eq!(text.parse(), place, "{text}");
        assert_eq!(text.parse(), Ok(bus), "{text}");
    }
    let far = BusSpec::parse("hub:lab-pc.example:29536", Reach::Remote);
    assert_eq!(far, Ok(hub("lab-pc.example", 29536)));
}

#[test]
fn what_does_not() {
    for text in [
        "",
        "Virtual",
        "virtual:",
        "hub:",
        "hub:0",
        "hub:65536",
        "hub:+1",
        "hub:1x",
        "hub::29536",
        "hub:::1:5",
        "hub:[::1]",
        "hub:[::1:5",
        "hub:a b:5",
        "hub:host:",
        "hub:192.168.0.1:5",
        "hub:lab-pc:5",
        "can",
        "can:",
        "can:a b",
        "can:a/b",
        "can:sixteen-letters!",
        "can:..",
        "can:a:b",
        "slcan",
        "slcan:",
        "slcan:a b",
        "slcan:lab-pc:5",
        "slcan:localhost:0",
        "slcan:[::1]",
        "vcan0",
        "can:\u{7f}",
    ] {
        let error = text.parse::<BusSpec>().unwrap_err().to_string();
        assert!(
            !error.contains('\n') && error.contains("bus"),
            "{text}: {error}"
        );
    }
}

#[test]
fn virtual_is_offered_where_it_is_possible() {
    let unknown = |expected: &str| format!("unknown bus \"tcp:1\": expected {expected}");
    let bus = "tcp:1".parse::<BusSpec>().unwrap_err().to_string();
    assert_eq!(
        bus,
        unknown(
            "virtual, hub, hub:PORT, hub:HOST:PORT, can:INTERFACE, slcan:DEVICE or slcan:HOST:PORT"
        )
    );
    let place = "tcp:1".parse::<Place>().unwrap_err().to_string();
    assert_eq!(
        place,
        unknown("hub, hub:PORT, hub:HOST:PORT, can:INTERFACE, slcan:DEVICE or slcan:HOST:PORT")
    );
    assert_eq!(
        "virtual".parse::<Place>().unwrap_err().to_string(),
        "bus \"virtual\": it lives inside one process (expected hub, hub:PORT, hub:HOST:PORT, \
         can:INTERFACE, slcan:DEVICE or slcan:HOST:PORT)"
    );
}

proptest! {
    #[test]
    fn any_text_is_a_bus_or_a_short_line(text in "(hub|can|slcan|virtual)?:?\\PC{0,200}") {
        match BusSpec::parse(&text, Reach::Remote) {
            Ok(bus) => prop_assert_eq!(BusSpec::parse(&bus.to_string(), Reach::Remote), Ok(bus)),
            Err(error) => {
                let line = error.to_string();
                prop_assert!(!line.contains('\n') && line.chars().count() < 1600);
            }
        }
    }
}
