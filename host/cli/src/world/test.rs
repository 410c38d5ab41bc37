//! The simulated cell is the one its file describes.

use super::*;
use bus::hub::HubServer;
use host::program::config_of;
use protocol::budget::{self, Rates};

/// What a bus has carried: how often, how long, and the longest frame, ns.
#[derive(Clone, Copy, Debug, Default)]
struct Carried {
    frames: u64,
    busy_ns: u64,
    longest_ns: u64,
}

/// Adds up how long the frames of each bus last at the rates its cell file gives.
struct Meter(Vec<(Rates, Carried)>);

impl Observer for Meter {
    fn frame(&mut self, bus: usize, _at_ns: u64, frame: &Frame) {
        let (rates, carried) = &mut self.0[bus];
        let lasts = rates.duration_ns(budget::exact(frame));
        carried.frames += 1;
        carried.busy_ns += lasts;
        carried.longest_ns = carried.longest_ns.max(lasts);
    }
}

#[test]
fn every_bus_of_a_cell_file_has_its_bit_rates() {
    let cell = Cell::parse(
        r#"
        bus = [
            { name = "arm", kind = "classic", bit_rate_kbit_s = 500 },
            { name = "wrist", kind = "classic", bit_rate_kbit_s = 250 },
            { name = "wire", kind = "fd", bit_rate_kbit_s = 500, data_bit_rate_kbit_s = 2000 },
        ]
        [[robot]]
        kind = "irp6-postument"
        mp_bus = "wire"
        drives = [{ bus = "arm", axes = [1, 2, 3] }, { bus = "wrist", axes = [4, 5, 6] }]
    "#,
    )
    .unwrap();
    let nodes: Vec<NodeId> = config_of(&cell)
        .unwrap()
        .robots
        .iter()
        .map(|r| r.node)
        .collect();
    let mut world = Virtual::new(&cell, &nodes, 1, false).unwrap();
    let rates = [(500_000, 2_000_000), (500_000, 500_000), (250_000, 250_000)];
    let unused = |(nominal, data)| (Rates { nominal, data }, Carried::default());
    let mut meter = Meter(rates.map(unused).to_vec());
    world.cell.advance(Micros::from_millis(500), &mut meter);
    for ((name, statistics), (_, carried)) in world.buses().iter().zip(&meter.0) {
        assert_eq!(statistics.frames, carried.frames, "{name}");
        assert!(carried.frames >= 10, "{name}: {carried:?}");
        // at its last look the wire may have begun one frame more, no longer than any before:
        // with other rates the difference would be that of ten frames at least
        let begun = statistics.busy_ns.checked_sub(carried.busy_ns);
        assert!(
            begun.is_some_and(|begun| begun <= carried.longest_ns),
            "{name}: {statistics:?} {carried:?}"
        );
    }
    let names: Vec<String> = world.buses().into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["wire", "arm", "wrist"]);
}

#[test]
fn frames_on_a_hub_are_short_whatever_the_cell_says() {
    let hub = HubServer::bind("127.0.0.1:0".parse().unwrap(), &["mp"]).unwrap();
    let place = format!("hub:{}", hub.address().port()).parse().unwrap();
    assert_eq!(Remote::connect(&place).unwrap().mtu(), Mtu::Classic);
}
