//! The image of a board, examined: started by `cargo xtask boards`, which builds it. Nothing is run.

use clap::Parser;
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
    let forbidden = image.forbidden();
    if !forbidden.is_empty() {
        return Err(format!("the image contains {}", forbidden.join(", ")));
    }
    println!("no panic, no heap: {} symbols", image.symbols.len());
    for (size, name) in image.frames.iter().take(5) {
        println!("frame of {size} bytes: {name}");
    }
    let mut figures = vec![
        Figure::new("flash_bytes", image.flash, 3).at_most(args.flash),
        Figure::new("ram_bytes_without_stack", image.ram, 0)
            .at_most(args.ram.saturating_sub(STACK)),
    ];
    if let Some((largest, _)) = image.frames.first() {
        let left = args.ram.saturating_sub(image.ram);
        figures.push(Figure::new("largest_frame_bytes", *largest, 10).at_most(left));
    }
    let text = std::fs::read_to_string(&args.golden).unwrap_or_default();
    let accepted = golden::read(&text);
    print!("{}", golden::table(&figures, &accepted));
    if args.bless {
        return golden::bless(&figures, &image.compiler, &args.golden)
            .map_err(|error| error.to_string());
    }
    let outside = golden::outside(&figures, &accepted);
    if outside.is_empty() {
        return Ok(());
    }
    Err(format!(
        "{} (made by {}, accepted of {}; --bless accepts what is meant)",
        outside.join("; "),
        image.compiler,
        golden::compiler(&text).unwrap_or("nobody")
    ))
}
