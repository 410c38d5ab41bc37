//! A hub by itself, for tools that want a bus without a simulator behind it; prints what passes in
//! candump's format.
//!
//! `cargo run -p mrroc-bus --example hub -- 29536 mp drives`

use bus::hub::{HubServer, HubTap};
use bus::{Bus, BusError, candump, now};
use protocol::time::Micros;
use std::net::{Ipv4Addr, SocketAddr};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (Some(port), Some(names)) = (arguments.first(), arguments.get(1..)) else {
        return Err("usage: hub PORT CHANNEL...".into());
    };
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let server = HubServer::bind(
        SocketAddr::from((Ipv4Addr::LOCALHOST, port.parse()?)),
        &names,
    )?;
    eprintln!("listening on {}", server.address());
    let mut taps: Vec<(&str, HubTap)> = names
        .iter()
        .filter_map(|name| Some((*name, server.tap(name)?)))
        .collect();
    loop {
        for (name, tap) in &mut taps {
            print_waiting(name, tap)?;
        }
    }
}

fn print_waiting(name: &str, tap: &mut HubTap) -> Result<(), BusError> {
    tap.wait(now() + Micros::from_millis(10))?;
    while let Some(received) = tap.receive()? {
        let channel = name.to_owned();
        println!(
            "{}",
            candump::Entry {
                at: received.at,
                channel,
                frame: received.frame
            }
        );
    }
    Ok(())
}
