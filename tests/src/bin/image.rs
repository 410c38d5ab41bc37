//! The image of a board, examined: started by `cargo xtask boards`, which builds it. Only a bootloader is run.

use clap::Parser;
use mrroc_tests::emulator::bootloader;
use mrroc_tests::emulator::elf::Image;
use mrroc_tests::emulator::golden::{self, Figure};
use std::path::PathBuf;
use std::process::ExitCode;

/// What the stack of a servo step may take.
const STACK: u64 = 4 * 1024;

/// Looks for panics and a heap in an image, and compares its sizes with the accepted ones.
#[derive(Debug, Parser)]
struct Args {
    /// The image
    image: PathBuf,
    /// The accepted figures
    #[arg(long)]
    golden: PathBuf,
    /// Bytes of flash of the board
    #[arg(long)]
    flash: u64,
    /// Bytes of RAM of the board
    #[arg(long)]
    ram: u64,
    /// It is the bootloader: run it, emulated
    #[arg(long)]
    bootloader: bool,
    /// Accept the figures
    #[arg(long)]
    bless: bool,
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("image: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(args: &Args) -> Result<(), String> {
    let image = Image::read(&args.image)?;
    image.examine()?;
    let mut figures = vec![
        Figure::new("flash_bytes", image.flash, 3).at_most(args.flash),
        Figure::new("ram_bytes_without_stack", image.ram, 0)
            .at_most(args.ram.saturating_sub(STACK)),
    ];
    if let Some((largest, _)) = image.frames.first() {
        let left = args.ram.saturating_sub(image.ram);
        figures.push(Figure::new("largest_frame_bytes", *largest, 10).at_most(left));
    }
    if args.bootloader {
        bootloader::check(&args.image)?;
    }
    golden::judge(&figures, &image.compiler, &args.golden, args.bless)
}
