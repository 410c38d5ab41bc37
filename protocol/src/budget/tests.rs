use super::*;
use proptest::prelude::*;
use std::vec::Vec;

fn frame(id: Id, fd: bool, data: &[u8]) -> Frame {
    if fd {
        Frame::fd(id, data).unwrap()
    } else {
        Frame::classic(id, data).unwrap()
    }
}

const fn worst_us(bits: Bits, rates: Rates) -> u64 {
    rates.duration_ns(bits) / 100 // tenths of a microsecond
}

/// Davis et al. 2007: 55 + 10n and 80 + 10n bits; as can-utils' canframelen with worst-case
/// stuffing.
#[test]
fn worst_classical_lengths() {
    for len in 0..=8 {
        assert_eq!(
            worst_classic(IdFormat::Standard, len).nominal,
            55 + 10 * u32::from(len)
        );
        assert_eq!(
            worst_classic(IdFormat::Extended, len).nominal,
            80 + 10 * u32::from(len)
        );
    }
}

/// Tenths of µs at 1/5 and 1/8 Mbit/s, 11-bit and 29-bit, computed by hand from the layout above.
#[test]
fn worst_fd_lengths() {
    use IdFormat::{Extended, Standard};
    for (len, std5, ext5, std8, ext8) in [
        (8, 566, 798, 481, 712),
        (16, 726, 958, 581, 812),
        (64, 1696, 1928, 1187, 1418),
    ] {
        let got = [
            worst_us(worst_fd(Standard, len), Rates::FD_1M_5M),
            worst_us(worst_fd(Extended, len), Rates::FD_1M_5M),
            worst_us(worst_fd(Standard, len), Rates::FD_1M_8M),
            worst_us(worst_fd(Extended, len), Rates::FD_1M_8M),
        ];
        assert_eq!(got, [std5, ext5, std8, ext8], "{len} bytes");
    }
}

/// The rule of stuffing, bit by bit, as the slow oracle of the tables.
fn stuff_bits(bits: &[bool], after_last: bool) -> Vec<usize> {
    let mut places = Vec::new();
    let (mut last, mut run) = (None, 0);
    for (k, bit) in bits.iter().enumerate() {
        if run == 5 {
            places.push(k);
            last = last.map(|b: bool| !b);
            run = 1;
        }
        run = if Some(*bit) == last { run + 1 } else { 1 };
        last = Some(*bit);
    }
    if run == 5 && after_last {
        places.push(bits.len());
    }
    places
}

fn push(bits: &mut Vec<bool>, value: u64, len: u32) {
    bits.extend((0..len).rev().map(|k| value >> k & 1 == 1));
}

fn slow_crc15(bits: &[bool]) -> u64 {
    let mut register = 0u16;
    for bit in bits {
        let next = (register >> 14 & 1 == 1) ^ bit;
        register = register << 1 & 0x7FFF;
        if next {
            register ^= 0x4599;
        }
    }
    u64::from(register)
}

/// All bits from SOF to the data, and how many of them are sent at the nominal rate.
fn slow_header(frame: &Frame) -> (Vec<bool>, usize) {
    let mut bits = Vec::from([false]);
    match frame.id() {
        Id::Standard(id) => {
            push(&mut bits, u64::from(id), 11);
            push(&mut bits, 0b00, 2); // RTR or RRS, IDE
        }
        Id::Extended(id) => {
            push(&mut bits, u64::from(id >> 18), 11);
            push(&mut bits, 0b11, 2); // SRR, IDE
            push(&mut bits, u64::from(id & 0x3_FFFF), 18);
            push(&mut bits, 0, 1); // RTR or RRS
            if !frame.is_fd() {
                push(&mut bits, 0, 1); // r1
            }
        }
    }
    if frame.is_fd() {
        push(&mut bits, 0b101, 3); // FDF, res, BRS
    } else {
        push(&mut bits, 0, 1); // r0
    }
    let arbitration = bits.len();
    if frame.is_fd() {
        push(&mut bits, 0, 1); // ESI
    }
    push(&mut bits, u64::from(dlc(frame.data().len())), 4);
    for byte in frame.data() {
        push(&mut bits, u64::from(*byte), 8);
    }
    (bits, arbitration)
}

fn count(bits: usize) -> u32 {
    u32::try_from(bits).unwrap()
}

fn slow(frame: &Frame) -> Bits {
    let (mut bits, arbitration) = slow_header(frame);
    if frame.is_fd() {
        let places = stuff_bits(&bits, false);
        let nominal = places.iter().filter(|place| **place < arbitration).count();
        let long = frame.data().len() > 16;
        let check = if long { 4 + 21 + 7 } else { 4 + 17 + 6 };
        Bits {
            nominal: count(arbitration + nominal + 13),
            data: count(bits.len() - arbitration + places.len() - nominal + check),
        }
    } else {
        let crc = slow_crc15(&bits);
        push(&mut bits, crc, 15);
        let stuffed = stuff_bits(&bits, true).len();
        Bits {
            nominal: count(bits.len() + stuffed + 13),
            data: 0,
        }
    }
}

/// Identifier 0 without data: all 19 bits up to the DLC are dominant and the CRC-15 of zeros is
/// zero. 34 zeros carry a stuff bit after every fifth: 6.
#[test]
fn the_frame_of_zeros() {
    let zeros = frame(Id::Standard(0), false, &[]);
    assert_eq!(
        exact(&zeros),
        Bits {
            nominal: 34 + 6 + 13,
            data: 0
        }
    );
    // A frame that needs no stuffing at all has the minimum of the literature: 47 + 8n bits.
    let none = (0..0x800u16)
        .map(|id| exact(&frame(Id::Standard(id), false, &[0x55; 8])).nominal)
        .min();
    assert_eq!(none, Some(47 + 64));
}

#[test]
fn durations_round_up_and_never_divide_by_zero() {
    let bits = Bits {
        nominal: 3,
        data: 1,
    };
    assert_eq!(
        Rates {
            nominal: 1_000_000,
            data: 3
        }
        .duration_ns(bits),
        3000 + 333_333_334
    );
    assert_eq!(
        Rates {
            nominal: 0,
            data: 1
        }
        .duration_ns(bits),
        4_000_000_000
    );
}

fn any_frame() -> impl Strategy<Value = Frame> {
    let id = prop_oneof![
        (0u16..0x800).prop_map(Id::Standard),
        (0u32..=0x1FFF_FFFF).prop_map(Id::Extended),
    ];
    // Bytes with long runs are likely, so that stuffing is really exercised.
    let byte = prop_oneof![
        Just(0u8),
        Just(0xFF),
        Just(0x0F),
        Just(0x1F),
        Just(0xF8),
        any::<u8>()
    ];
    let lengths =
        prop::sample::select(&[0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64][..]);
    (
        id,
        any::<bool>(),
        lengths,
        proptest::collection::vec(byte, 64),
    )
        .prop_map(|(id, fd, len, data): (Id, bool, usize, Vec<u8>)| {
            let len = if fd { len } else { len.min(8) };
            frame(id, fd, &data[..len])
        })
}

proptest! {
    #[test]
    fn tables_agree_with_the_rule(frame in any_frame()) {
        prop_assert_eq!(exact(&frame), slow(&frame));
    }

    #[test]
    fn no_frame_is_longer_than_the_worst(frame in any_frame()) {
        let (exact, worst) = (exact(&frame), worst(&frame));
        prop_assert!(exact.nominal <= worst.nominal);
        prop_assert!(exact.nominal + exact.data <= worst.nominal + worst.data);
        for rates in [Rates::CLASSIC_1M, Rates::FD_1M_5M, Rates::FD_1M_8M] {
            prop_assert!(rates.duration_ns(exact) <= rates.duration_ns(worst));
        }
    }
}
