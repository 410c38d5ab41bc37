//! The images of boards that one can buy: built, and examined; nothing is run.

use crate::image::{Board, Built};
use crate::report::Findings;
use crate::shell::run_cargo;
use anyhow::Result;

/// A board with what its processor has.
struct Bought {
    board: Board,
    /// Bytes of flash for the image.
    flash: &'static str,
    /// Bytes of RAM.
    ram: &'static str,
}

/// All of them.
const BOARDS: &[Bought] = &[Bought {
    board: Board {
        folder: "firmware/boards/nucleo-g474re",
        image: "mrroc-nucleo",
    },
    flash: "520192",
    ram: "131072",
}];

/// Builds every image and lets `image` of the tests examine it.
pub(crate) fn check(bless: bool) -> Result<Findings> {
    let mut findings = vec![];
    for Bought { board, flash, ram } in BOARDS {
        println!("{}", board.folder);
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
