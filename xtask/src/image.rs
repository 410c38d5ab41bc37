//! The image of a board, built for its processor.

use crate::no_std::{BareMetal, TARGET, bare_metal};
use crate::report::Findings;
use crate::shell::{root, run};
use anyhow::Result;
use std::path::PathBuf;

/// Where images are built, in the root.
const BUILD: &str = "target/boards";

/// A board.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Board {
    /// Its folder.
    pub(crate) folder: &'static str,
    /// Its binary.
    pub(crate) image: &'static str,
    /// Features beside the default ones; with them it is another image, with accepted figures of its own.
    pub(crate) features: &'static [&'static str],
}

/// What came of the building.
pub(crate) struct Built {
    /// The image, if there is one.
    pub(crate) image: PathBuf,
    /// The folder in which it was built.
    pub(crate) build: PathBuf,
    /// Its accepted figures.
    pub(crate) golden: PathBuf,
}

impl Board {
    /// Builds the image, by the target's installed library or with `core` from its sources.
    pub(crate) fn build(self) -> Result<std::result::Result<Built, Findings>> {
        let Some(BareMetal {
            mut cargo,
            more,
            name,
        }) = bare_metal()?
        else {
            return Ok(Err(vec![format!(
                "the target is missing: rustup target add {TARGET}"
            )]));
        };
        let build = root().join(BUILD).join(name);
        // the sizes of stack frames are asked of any compiler by a flag that is not stable yet
        let flags = format!("target.{TARGET}.rustflags=['-Zemit-stack-sizes']");
        let mut line = vec!["build", "--release", "--locked", "--config", flags.as_str()];
        line.extend(more);
        let features = self.features.join(",");
        if !features.is_empty() {
            line.extend(["--features", &features]);
        }
        cargo
            .current_dir(root().join(self.folder))
            .env("RUSTC_BOOTSTRAP", "1")
            .args(&line)
            .arg("--target-dir")
            .arg(&build);
        let findings = run(&mut cargo, &line)?;
        if !findings.is_empty() {
            let of = |finding| format!("{}: {finding}", self.folder);
            return Ok(Err(findings.into_iter().map(of).collect()));
        }
        Ok(Ok(Built {
            image: build.join(TARGET).join("release").join(self.image),
            golden: root()
                .join(self.folder)
                .join("golden")
                .join([&[name], self.features].concat().join("-")),
            build,
        }))
    }
}
