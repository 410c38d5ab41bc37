//! Every example prints what its `.out` file and the README say.
//!
//! `BLESS=1 cargo test -p mrroc-examples` accepts what is printed now into the `.out` files.

#[path = "../examples/02_same_generator_on_the_mp.rs"]
#[expect(dead_code, reason = "its main")]
mod same_generator_on_the_mp;

#[path = "../examples/03_loose.rs"]
#[expect(dead_code, reason = "its main")]
mod loose;

#[path = "../examples/04_tight.rs"]
#[expect(dead_code, reason = "its main")]
mod tight;

use same_generator_on_the_mp::own_generator;
use std::fs;
use std::path::Path;

fn check(name: &str, example: fn() -> anyhow::Result<String>) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = folder.join("examples").join(name).with_extension("out");
    let printed = example().unwrap_or_else(|error| panic!("{name}: {error:#}"));
    if std::env::var_os("BLESS").is_some() {
        fs::write(&path, &printed).unwrap();
    }
    let expected = fs::read_to_string(&path).unwrap();
    assert_eq!(
        printed,
        expected,
        "{name} prints something else than {}",
        path.display()
    );
    let readme = fs::read_to_string(folder.join("README.md")).unwrap();
    assert!(
        readme.contains(&expected),
        "README.md says something else than {name} prints"
    );
    assert!(
        readme.contains(&format!("--example {name}")),
        "README.md does not tell of {name}"
    );
}

#[test]
fn own_generator_prints_what_it_says() {
    check("01_own_generator", own_generator::example);
}

#[test]
fn same_generator_on_the_mp_prints_what_it_says() {
    check(
        "02_same_generator_on_the_mp",
        same_generator_on_the_mp::example,
    );
}

#[test]
fn loose_prints_what_it_says() {
    check("03_loose", loose::example);
}

#[test]
fn tight_prints_what_it_says() {
    check("04_tight", tight::example);
}

#[test]
fn no_example_is_forgotten() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let mut stems: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "rs"))
        .map(|path| path.file_stem().unwrap().to_string_lossy().into_owned())
        .collect();
    stems.sort();
    let known = [
        "01_own_generator",
        "02_same_generator_on_the_mp",
        "03_loose",
        "04_tight",
    ];
    assert_eq!(stems, known);
}
