//! The images of boards that one can buy: built, and examined. Only the bootloader is run, on another processor.

use crate::image::{Board, Built};
use crate::report::Findings;
use crate::shell::run_cargo;
use anyhow::Result;

/// An image, and what its processor has for it.
struct Bought {
    board: Board,
    /// Bytes of flash for the image.
    flash: &'static str,
    /// Bytes of RAM.
    ram: &'static str,
    /// It starts others: it is run too, emulated.
    is_bootloader: bool,
}

const NUCLEO: Board = Board {
    folder: "firmware/boards/nucleo-g474re",
    image: "mrroc-nucleo",
    features: &[],
};

/// All of them.
const BOARDS: &[Bought] = &[
    Bought {
        board: NUCLEO,
        flash: "520192",
        ram: "131072",
        is_bootloader: false,
    },
    Bought {
        board: Board {
            features: &["slot"],
            ..NUCLEO
        },
        flash: "243712",
        ram: "131072",
        is_bootloader: false,
    },
    Bought {
        board: Board {
            folder: "firmware/boards/bootloader-g474re",
            image: "mrroc-bootloader",
            features: &[],
        },
        flash: "12288",
        ram: "131072",
        is_bootloader: true,
    },
];

/// Builds every image and lets `image` of the tests examine it.
pub(crate) fn check(bless: bool) -> Result<Findings> {
    let mut findings = vec![];
    for bought in BOARDS {
        let Bought {
            board, flash, ram, ..
        } = bought;
        println!("{} {}", board.folder, board.features.join(" "));
        match board.build()? {
            Ok(Built { image, golden, .. }) => {
                let (image, golden) = (image.display().to_string(), golden.display().to_string());
                let mut line = vec![
                    "run",
                    "--release",
                    "-p",
                    "mrroc-tests",
                    "--bin",
                    "image",
                    "--",
                    &image,
                    "--golden",
                    &golden,
                    "--flash",
                    flash,
                    "--ram",
                    ram,
                ];
                if bought.is_bootloader {
                    line.push("--bootloader");
                }
                if bless {
                    line.push("--bless");
                }
                findings.extend(run_cargo(&line)?);
            }
            Err(failed) => findings.extend(failed),
        }
    }
    Ok(findings)
}
