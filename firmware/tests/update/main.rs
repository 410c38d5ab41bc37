//! The transfer of an image into the other slot, and what starts after the power went at any byte of it.
#![forbid(unsafe_code)]
#![expect(clippy::cast_possible_truncation, reason = "a flash of a few pages")]

mod flash;

use firmware::update::boot::{Choice, Phase, RECORD, Record, TRIALS};
use firmware::update::image::{CRC, HEADER};
use firmware::update::slots::{Layout, LayoutError, Slots};
use firmware::update::stm32g474::LAYOUT;
use firmware::update::{Updater, image};
use flash::{Flash, PAGE};
use proptest::prelude::*;
use protocol::maintenance::{
    IMAGE_CHUNK, ImageHeader, ImagePhase, MaintenanceRefusal, Slot, Standing,
};

const P: u32 = PAGE as u32;
/// Two slots of five pages, the log between them.
const SMALL: Layout = Layout {
    slot_a: 0,
    slot_b: 7 * P,
    slot: 5 * P,
    log: [5 * P, 6 * P],
};
const PAGES: usize = 12;
const ROBOT: &str = "irp6-postument";
const TARGET: &str = "test";

fn payload(length: usize, seed: u8) -> Vec<u8> {
    let byte = |k: usize| (k.wrapping_mul(31) >> 3) as u8 ^ seed;
    (0..length).map(byte).collect()
}

fn header(payload: &[u8], version: (u8, u8, u8)) -> ImageHeader {
    ImageHeader {
        robot: ROBOT.try_into().unwrap(),
        target: TARGET.try_into().unwrap(),
        version,
        schema_hash: 1,
        length: payload.len().try_into().unwrap(),
        crc: CRC.checksum(payload),
    }
}

/// As it comes from the factory: an image in slot A, nothing else.
fn factory() -> Flash {
    let mut flash = Flash::new(PAGES);
    let old = payload(3000, 1);
    flash.bytes[..HEADER].copy_from_slice(&image::write(&header(&old, (0, 1, 0))));
    flash.bytes[PAGE..PAGE + old.len()].copy_from_slice(&old);
    flash
}

fn start(flash: Flash) -> (Slots<Flash>, Choice) {
    let mut slots = Slots::new(flash, SMALL).unwrap();
    let choice = slots.start().unwrap();
    (slots, choice)
}

fn updater(flash: Flash) -> Updater<Flash> {
    let (slots, choice) = start(flash);
    Updater::new(slots, choice).unwrap()
}

/// Everything a host does; ends at the first error.
fn transfer(updater: &mut Updater<Flash>, new: &[u8]) -> Result<(), MaintenanceRefusal> {
    let header = header(new, (0, 2, 0));
    updater.begin(ROBOT, TARGET, &header)?;
    for (k, part) in new.chunks(IMAGE_CHUNK).enumerate() {
        let offset = (k * IMAGE_CHUNK) as u32;
        updater.write(header.crc, offset, part)?;
    }
    updater.verify(header.crc)?;
    updater.activate(header.crc)?;
    Ok(())
}

fn flash_of(mut updater: Updater<Flash>) -> Flash {
    let slots = updater.slots();
    let empty = Slots::new(Flash::new(PAGES), SMALL).unwrap();
    std::mem::replace(slots, empty).into_flash()
}

fn set_power(updater: &mut Updater<Flash>, power: usize) {
    let slots = updater.slots();
    let empty = Slots::new(Flash::new(PAGES), SMALL).unwrap();
    let mut flash = std::mem::replace(slots, empty).into_flash();
    flash.power = Some(power);
    *slots = Slots::new(flash, SMALL).unwrap();
}

fn version(slots: &mut Slots<Flash>, choice: Choice) -> (u8, u8, u8) {
    let slot = choice.slot.expect("something starts");
    assert!(slots.whole(slot), "what starts is whole");
    slots.header(slot).unwrap().version
}

#[test]
fn an_update_starts_on_trial_is_confirmed_and_stays() {
    let new = payload(8000, 2);
    let mut first = updater(factory());
    assert_eq!(first.running().unwrap().standing, Standing::Confirmed);
    transfer(&mut first, &new).unwrap();
    assert_eq!(first.status().phase, ImagePhase::Activated);
    assert_eq!(first.running().unwrap().version, (0, 1, 0), "it runs on");

    let mut second = updater(flash_of(first));
    let running = second.running().unwrap();
    assert_eq!((running.slot, running.version), (Slot::B, (0, 2, 0)));
    assert_eq!(running.standing, Standing::Trial);
    let refused = second.begin(ROBOT, TARGET, &header(&payload(10, 3), (0, 3, 0)));
    assert_eq!(refused, Err(MaintenanceRefusal::Unconfirmed));
    second.confirm().unwrap();
    assert_eq!(second.confirm(), Err(MaintenanceRefusal::NotOnTrial));

    for _ in 0..5 {
        let mut later = updater(flash_of(std::mem::replace(&mut second, updater(factory()))));
        let running = later.running().unwrap();
        assert_eq!(
            (running.version, running.standing),
            ((0, 2, 0), Standing::Confirmed)
        );
        second = later;
    }
}

#[test]
fn what_is_not_confirmed_is_rolled_back_and_can_be_sent_again() {
    let new = payload(8000, 2);
    let mut first = updater(factory());
    transfer(&mut first, &new).unwrap();
    let trial = updater(flash_of(first));
    let mut back = updater(flash_of(trial));
    let running = back.running().unwrap();
    assert_eq!(
        (running.version, running.standing),
        ((0, 1, 0), Standing::RolledBack)
    );
    transfer(&mut back, &new).unwrap();
    let mut again = updater(flash_of(back));
    assert_eq!(again.running().unwrap().standing, Standing::Trial);
    again.confirm().unwrap();
}

#[test]
fn after_a_power_loss_at_any_byte_the_old_or_the_whole_new_image_starts() {
    let new = payload(4500, 2);
    let mut whole = updater(factory());
    let before = whole.slots().last();
    assert_eq!(before, None);
    transfer(&mut whole, &new).unwrap();
    let total = flash_of(whole).changed;
    // three pages of image, a header page twice, a record: each page is erased byte by byte here
    assert!(total > 5 * PAGE + 4500, "{total}");
    let mut trials = 0;
    for torn in [0x00, 0xA5] {
        // every byte near an end, and a prime distance between them
        let points = (0..total).filter(|k| k % 7 == 0 || total - k < 300 || *k < 300);
        for power in points {
            let mut cut = updater(Flash { torn, ..factory() });
            set_power(&mut cut, power);
            let ended = transfer(&mut cut, &new);
            assert_eq!(ended, Err(MaintenanceRefusal::Storage), "{power}");
            let mut flash = flash_of(cut);
            flash.power = None;
            let (mut slots, choice) = start(flash);
            match version(&mut slots, choice) {
                (0, 1, 0) => assert_ne!(choice.standing, Standing::Trial, "{power}"),
                got => {
                    assert_eq!(
                        (got, choice.standing),
                        ((0, 2, 0), Standing::Trial),
                        "{power}"
                    );
                    trials += 1;
                }
            }
            // and the transfer can be done again, from the beginning
            let mut again = Updater::new(slots, choice).unwrap();
            if choice.standing == Standing::Trial {
                again.confirm().unwrap();
            } else {
                transfer(&mut again, &new).unwrap();
            }
        }
    }
    // the record is the last thing written: only when all of it is there does the new image start
    assert_eq!(trials, 0);
}

#[test]
fn after_a_power_loss_at_any_byte_of_the_trials_record_an_image_starts() {
    let new = payload(600, 2);
    let mut sent = updater(factory());
    transfer(&mut sent, &new).unwrap();
    let activated = flash_of(sent);
    for power in 1..=RECORD + 2 {
        let mut flash = activated.clone();
        flash.power = Some(power);
        let mut slots = Slots::new(flash, SMALL).unwrap();
        let choice = slots.start();
        let mut flash = slots.into_flash();
        flash.power = None;
        // an image must not be started if the try could not be written down
        assert_eq!(choice.is_ok(), power > RECORD, "{power}");
        let (mut slots, choice) = start(flash);
        let expected = if power < RECORD { (0, 2, 0) } else { (0, 1, 0) };
        assert_eq!(version(&mut slots, choice), expected, "{power}");
    }
}

#[test]
fn the_log_goes_on_from_page_to_page() {
    let (mut slots, _) = start(factory());
    let records = 3 * (PAGE / RECORD) + 5;
    for k in 1..=records {
        let left = (k % 250) as u8;
        let record = Record {
            slot: if k % 2 == 0 { Slot::A } else { Slot::B },
            phase: Phase::Trial { left },
        };
        slots.append(record).unwrap();
        let last = slots.last().unwrap();
        assert_eq!((last.number as usize, last.record), (k, record));
    }
}

#[test]
fn every_power_loss_in_the_log_leaves_the_last_or_the_new_record() {
    let (mut slots, _) = start(factory());
    let confirmed = Record {
        slot: Slot::A,
        phase: Phase::Confirmed,
    };
    for _ in 0..PAGE / RECORD {
        slots.append(confirmed).unwrap();
    }
    let full = slots.into_flash();
    let new = Record {
        slot: Slot::A,
        phase: Phase::RolledBack,
    };
    // the next record is behind an erasure
    for power in 1..PAGE + RECORD {
        let mut flash = full.clone();
        flash.power = Some(power);
        let mut slots = Slots::new(flash, SMALL).unwrap();
        assert!(
            slots.append(new).is_err() || power >= PAGE + RECORD,
            "{power}"
        );
        let mut flash = slots.into_flash();
        flash.power = None;
        let mut slots = Slots::new(flash, SMALL).unwrap();
        assert_eq!(slots.last().unwrap().record, confirmed, "{power}");
        slots.append(new).unwrap();
        assert_eq!(slots.last().unwrap().record, new, "{power}");
    }
}

#[test]
fn parts_may_come_twice_in_any_order_and_with_gaps() {
    let new = payload(3000, 2);
    let head = header(&new, (0, 2, 0));
    let mut updater = updater(factory());
    updater.begin(ROBOT, TARGET, &head).unwrap();
    let part = |k: usize| &new[k * IMAGE_CHUNK..((k + 1) * IMAGE_CHUNK).min(new.len())];
    let offset = |k: usize| (k * IMAGE_CHUNK) as u32;
    for (k, next) in [
        (1, 0),
        (0, 1),
        (0, 1),
        (3, 1),
        (1, 2),
        (0, 2),
        (2, 3),
        (11, 3),
    ] {
        let status = updater.write(head.crc, offset(k), part(k)).unwrap();
        assert_eq!(status.next, offset(next), "part {k}");
    }
    // the same image begun again goes on where it was
    assert_eq!(updater.begin(ROBOT, TARGET, &head).unwrap().next, offset(3));
    for k in 3..12 {
        updater.write(head.crc, offset(k), part(k)).unwrap();
    }
    assert_eq!(
        updater.verify(head.crc).unwrap().phase,
        ImagePhase::Verified
    );
    assert_eq!(
        updater.verify(head.crc).unwrap().phase,
        ImagePhase::Verified
    );
    assert_eq!(
        updater.activate(head.crc).unwrap().phase,
        ImagePhase::Activated
    );
    assert_eq!(
        updater.activate(head.crc).unwrap().phase,
        ImagePhase::Activated
    );
    // aborted after all: the old one starts
    assert_eq!(updater.abort().unwrap().phase, ImagePhase::None);
    let (mut slots, choice) = start(flash_of(updater));
    assert_eq!(version(&mut slots, choice), (0, 1, 0));
}

#[test]
fn everything_illegal_is_refused_and_changes_nothing() {
    use MaintenanceRefusal as R;
    let new = payload(1000, 2);
    let head = header(&new, (0, 2, 0));
    let mut updater = updater(factory());
    assert_eq!(
        updater.write(head.crc, 0, &new[..IMAGE_CHUNK]),
        Err(R::NoTransfer)
    );
    assert_eq!(updater.verify(head.crc), Err(R::NoTransfer));
    assert_eq!(updater.activate(head.crc), Err(R::NoTransfer));
    assert_eq!(
        updater.begin("irp6-track", TARGET, &head),
        Err(R::WrongRobot)
    );
    assert_eq!(
        updater.begin(ROBOT, "stm32g474", &head),
        Err(R::WrongTarget)
    );
    let capacity = 4 * P;
    for length in [0, capacity + 1, u32::MAX] {
        let long = ImageHeader {
            length,
            ..head.clone()
        };
        assert_eq!(
            updater.begin(ROBOT, TARGET, &long),
            Err(R::WrongLength { capacity })
        );
    }
    assert_eq!(updater.status().phase, ImagePhase::None);
    assert_eq!(updater.slots().last(), None);

    updater.begin(ROBOT, TARGET, &head).unwrap();
    let other = header(&payload(900, 9), (0, 2, 1));
    assert_eq!(
        updater.begin(ROBOT, TARGET, &other),
        Err(R::OtherImage { image: head.crc })
    );
    assert_eq!(
        updater.write(7, 0, &new[..IMAGE_CHUNK]),
        Err(R::OtherImage { image: head.crc })
    );
    updater.write(head.crc, 0, &new[..IMAGE_CHUNK]).unwrap();
    let next = IMAGE_CHUNK as u32;
    for (offset, length) in [
        (256, 0),
        (256, 8),
        (256, 255),
        (8, 256),
        (1024, 256),
        (768, 233),
        (u32::MAX - 255, 256),
    ] {
        let refused = updater.write(head.crc, offset, &vec![0; length]);
        assert_eq!(refused, Err(R::WrongPart { next }), "{offset} {length}");
    }
    let mut damaged = new[..IMAGE_CHUNK].to_vec();
    damaged[255] ^= 1;
    assert_eq!(
        updater.write(head.crc, 0, &damaged),
        Err(R::Differs { offset: 0 })
    );
    assert_eq!(updater.verify(head.crc), Err(R::Incomplete { next }));
    assert_eq!(updater.activate(head.crc), Err(R::NotVerified));
    assert_eq!(updater.confirm(), Err(R::NotOnTrial));
    assert_eq!(updater.status().next, next);
}

#[test]
fn bytes_that_are_not_those_announced_never_become_an_image() {
    let new = payload(1000, 2);
    let head = header(&new, (0, 2, 0));
    let mut updater = updater(factory());
    updater.begin(ROBOT, TARGET, &head).unwrap();
    let mut wrong = new;
    wrong[700] ^= 4;
    for (k, part) in wrong.chunks(IMAGE_CHUNK).enumerate() {
        updater
            .write(head.crc, (k * IMAGE_CHUNK) as u32, part)
            .unwrap();
    }
    let got = CRC.checksum(&wrong);
    assert_eq!(
        updater.verify(head.crc),
        Err(MaintenanceRefusal::WrongCrc { got })
    );
    assert_eq!(updater.status().phase, ImagePhase::None);
    let (mut slots, choice) = start(flash_of(updater));
    assert!(!slots.whole(Slot::B));
    assert_eq!(version(&mut slots, choice), (0, 1, 0));
}

#[test]
fn a_page_that_could_not_be_written_is_wanted_again() {
    let new = payload(3000, 2);
    let head = header(&new, (0, 2, 0));
    let mut updater = updater(factory());
    updater.begin(ROBOT, TARGET, &head).unwrap();
    updater.write(head.crc, 0, &new[..256]).unwrap();
    // something is in the way: an STM32 does not write over it
    let slots = updater.slots();
    let mut flash =
        std::mem::replace(slots, Slots::new(Flash::new(PAGES), SMALL).unwrap()).into_flash();
    flash.bytes[SMALL.slot_b as usize + PAGE + 256 + 16] = 0;
    *slots = Slots::new(flash, SMALL).unwrap();
    let failed = updater.write(head.crc, 256, &new[256..512]);
    assert_eq!(failed, Err(MaintenanceRefusal::Storage));
    assert_eq!(updater.status().next, 0, "from the beginning of the page");
    transfer(&mut updater, &new).unwrap();
}

#[test]
fn layouts_that_cannot_be_are_refused() {
    let of = |layout| Slots::new(Flash::new(PAGES), layout).map(|_| ());
    assert_eq!(of(SMALL), Ok(()));
    for (layout, error) in [
        (Layout { slot_a: 8, ..SMALL }, LayoutError::Alignment),
        (Layout { slot: P, ..SMALL }, LayoutError::Alignment),
        (
            Layout {
                slot: 5 * P + 256,
                ..SMALL
            },
            LayoutError::Alignment,
        ),
        (
            Layout {
                slot_b: 8 * P,
                ..SMALL
            },
            LayoutError::Capacity,
        ),
        (
            Layout {
                slot_b: u32::MAX - P + 1,
                ..SMALL
            },
            LayoutError::Capacity,
        ),
        (
            Layout {
                slot_b: 4 * P,
                ..SMALL
            },
            LayoutError::Overlap,
        ),
        (
            Layout {
                log: [5 * P, 5 * P],
                ..SMALL
            },
            LayoutError::Overlap,
        ),
        (
            Layout {
                log: [0, 6 * P],
                ..SMALL
            },
            LayoutError::Overlap,
        ),
    ] {
        assert_eq!(of(layout), Err(error), "{layout:?}");
    }
    // the chip's: 512 KiB
    assert!(Slots::new(Flash::new(256), LAYOUT).is_ok());
    assert_eq!(TRIALS, 1);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Any sequence of parts, sent in any order and number, ends as the image or as not complete.
    #[test]
    fn any_order_of_parts_is_the_image_or_incomplete(
        length in 1_usize..8000, order in proptest::collection::vec(0_usize..40, 0..200), tidy: bool,
    ) {
        let new = payload(length, 5);
        let head = header(&new, (1, 0, 0));
        let mut updater = updater(factory());
        updater.begin(ROBOT, TARGET, &head).unwrap();
        let parts = length.div_ceil(IMAGE_CHUNK);
        let rest = if tidy { 0..parts } else { 0..0 };
        for k in order.into_iter().chain(rest) {
            if k < parts {
                let part = &new[k * IMAGE_CHUNK..((k + 1) * IMAGE_CHUNK).min(length)];
                let before = updater.status().next;
                let status = updater.write(head.crc, (k * IMAGE_CHUNK) as u32, part).unwrap();
                prop_assert!(status.next >= before);
            }
        }
        let complete = updater.status().next as usize == length;
        match updater.verify(head.crc) {
            Ok(status) => prop_assert!(complete && status.phase == ImagePhase::Verified),
            Err(error) => prop_assert_eq!(error, MaintenanceRefusal::Incomplete { next: updater.status().next }),
        }
        prop_assert!(complete || !tidy);
        prop_assert_eq!(updater.slots().whole(Slot::B), complete);
    }
}
