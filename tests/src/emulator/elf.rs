//! What an image is made of, by its file: sizes, symbols, stack frames.

use object::{Object, ObjectSection, ObjectSymbol, SectionFlags, SectionKind, elf};
use std::path::Path;

/// RAM begins here on every Cortex-M.
const RAM: u64 = 0x2000_0000;
/// So many of the largest stack frames are shown.
const SHOWN_FRAMES: usize = 5;
/// The lowest bit of a function's address says that its code is Thumb.
const THUMB: u64 = 1;

/// Parts of the names of what no image may contain: panics, and memory taken at run time.
const FORBIDDEN: [&str; 6] = [
    "panicking",
    "rust_begin_unwind",
    "__rust_alloc",
    "__rust_dealloc",
    "__rg_",
    "__rdl_",
];

/// An image.
#[derive(Clone, Debug)]
pub struct Image {
    /// Bytes of flash: code, constants, and the first values of variables.
    pub flash: u64,
    /// Bytes of RAM that are taken from the start, the stack not among them.
    pub ram: u64,
    /// The version of the compiler, as the compiler says it; empty if it does not.
    pub compiler: String,
    /// Functions and variables, with their addresses.
    pub symbols: Vec<(String, u64)>,
    /// Stack frames in bytes with the names of their functions, the largest first; none if the
    /// compiler was not asked for them.
    pub frames: Vec<(u64, String)>,
}

impl Image {
    /// Reads an ELF file.
    ///
    /// # Errors
    /// A line that says why it cannot be.
    pub fn read(path: &Path) -> Result<Self, String> {
        let bytes = std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
        let file =
            object::File::parse(&*bytes).map_err(|error| format!("{}: {error}", path.display()))?;
        let (mut flash, mut ram) = (0, 0);
        for section in file.sections() {
            let SectionFlags::Elf { sh_flags } = section.flags() else {
                continue;
            };
            if sh_flags & u64::from(elf::SHF_ALLOC) == 0 {
                continue;
            }
            let zero = matches!(section.kind(), SectionKind::UninitializedData);
            if section.address() >= RAM {
                ram += section.size();
            }
            if !zero {
                flash += section.size();
            }
        }
        let symbols: Vec<_> = file
            .symbols()
            .filter_map(|symbol| {
                let name = symbol.name().ok()?;
                Some((name.to_owned(), symbol.address() & !THUMB))
            })
            .collect();
        let comment = file.section_by_name(".comment");
        let comment = comment.and_then(|section| section.data().ok());
        let sizes = file.section_by_name(".stack_sizes");
        let sizes = sizes.and_then(|section| section.data().ok().map(<[u8]>::to_vec));
        let frames = frames(&sizes.unwrap_or_default(), &symbols);
        Ok(Self {
            flash,
            ram,
            compiler: compiler(comment.unwrap_or_default()),
            symbols,
            frames,
        })
    }

    /// Where a function begins.
    #[must_use]
    pub fn address(&self, name: &str) -> Option<u64> {
        self.symbols
            .iter()
            .find(|(symbol, _)| symbol == name)
            .map(|(_, address)| *address)
    }

    /// Says what the image is made of: its symbols and its largest stack frames.
    ///
    /// # Errors
    /// It contains a panic or a heap.
    pub fn examine(&self) -> Result<(), String> {
        let forbidden = self.forbidden();
        if !forbidden.is_empty() {
            return Err(format!("the image contains {}", forbidden.join(", ")));
        }
        println!("no panic, no heap: {} symbols", self.symbols.len());
        for (size, name) in self.frames.iter().take(SHOWN_FRAMES) {
            println!("frame of {size} bytes: {name}");
        }
        Ok(())
    }

    /// Symbols that no image may contain.
    #[must_use]
    pub fn forbidden(&self) -> Vec<&str> {
        let names = self.symbols.iter().map(|(name, _)| name.as_str());
        names
            .filter(|name| FORBIDDEN.iter().any(|part| name.contains(part)))
            .collect()
    }
}

/// The compiler's among texts that each end with a zero.
fn compiler(comment: &[u8]) -> String {
    let mut texts = comment.split(|byte| *byte == 0);
    let ours = texts.find(|text| text.starts_with(b"rustc"));
    String::from_utf8_lossy(ours.unwrap_or_default()).into_owned()
}

/// The compiler's table: address of a function (4 bytes), size of its frame (LEB128).
fn frames(mut table: &[u8], symbols: &[(String, u64)]) -> Vec<(u64, String)> {
    let mut out = Vec::new();
    while let Some((address, rest)) = table.split_first_chunk() {
        let address = u64::from(u32::from_le_bytes(*address)) & !THUMB;
        let Some((size, rest)) = leb128(rest) else {
            break;
        };
        table = rest;
        // the linker leaves 0 where it has dropped the function
        let of = symbols
            .iter()
            .find(|(name, at)| *at == address && !name.starts_with('$'));
        if let (true, Some((name, _))) = (address != 0, of) {
            out.push((size, name.clone()));
        }
    }
    out.sort_by(|a, b| b.cmp(a));
    out
}

fn leb128(bytes: &[u8]) -> Option<(u64, &[u8])> {
    let (mut value, mut shift) = (0_u64, 0_u32);
    for (k, byte) in bytes.iter().enumerate().take(10) {
        value |= u64::from(byte & 0x7F).checked_shl(shift)?;
        shift += 7;
        if byte & 0x80 == 0 {
            return Some((value, &bytes[k + 1..]));
        }
    }
    None
}

#[cfg(test)]
mod test {
    use super::*;

    #[test]
    fn frames_are_read_and_dropped_functions_left_out() {
        let symbols = vec![
            ("$t".to_owned(), 0x100),
            ("small".to_owned(), 0x100),
            ("large".to_owned(), 0x200),
        ];
        let table = [
            [0x01, 1, 0, 0].as_slice(),
            &[0x10],
            &[0, 0, 0, 0, 0x20],
            &[0x01, 2, 0, 0, 0x90, 0x01],
        ]
        .concat();
        assert_eq!(
            frames(&table, &symbols),
            [(144, "large".to_owned()), (16, "small".to_owned())]
        );
        assert_eq!(frames(&table[..4], &symbols), []);
    }

    #[test]
    fn the_compiler_is_found_among_the_linkers_and_absent_in_none() {
        assert_eq!(
            compiler(b"Linker: LLD 14\0rustc version 1.96.0\0"),
            "rustc version 1.96.0"
        );
        assert_eq!(compiler(b"Linker: LLD 14\0"), "");
        assert_eq!(compiler(b""), "");
    }

    #[test]
    fn panics_and_heaps_are_forbidden() {
        let image = |name: &str| Image {
            flash: 0,
            ram: 0,
            compiler: String::new(),
            symbols: vec![("main".into(), 0), (name.into(), 0)],
            frames: vec![],
        };
        assert_eq!(image("step").forbidden(), [""; 0]);
        for name in [
            "_RNvNtCs_4core9panicking5panic",
            "__rust_alloc",
            "__rg_dealloc",
        ] {
            assert_eq!(image(name).forbidden(), [name]);
        }
    }
}
