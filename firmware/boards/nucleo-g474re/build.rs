//! Puts the memory of the image where the linker looks for it: all of the flash, or a slot of it.

use std::path::PathBuf;
use std::{env, fs};

fn main() {
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    let memory = if env::var_os("CARGO_FEATURE_SLOT").is_some() {
        include_str!("slot.x")
    } else {
        include_str!("whole.x")
    };
    fs::write(out.join("memory.x"), memory).expect("a writable folder");
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rerun-if-changed=whole.x");
    println!("cargo:rerun-if-changed=slot.x");
}
