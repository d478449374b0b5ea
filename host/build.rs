//! Tells the program which commit it was built from, for what runs record, and has the program for a robot linked without what only
//! unwinding needs.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

/// Names the commit of sources without a repository, such as Python's.
const GIVEN: &str = "ONEIRO_BUILT_FROM";

fn main() {
    // Files that determine the commit, and whether the build differs from it.
    let fixed = ["build.rs", "src", "../src", "../shaders", "../.git/logs/HEAD"].map(PathBuf::from);
    let folders = Path::new(".").read_dir().into_iter().flatten().flatten();
    let crates = folders.map(|folder| folder.path().join("src"));
    for path in fixed.into_iter().chain(crates).filter(|path| path.exists()) {
        println!("cargo::rerun-if-changed={}", path.display());
    }
    println!("cargo::rustc-check-cfg=cfg(no_unwinding)");
    if is_for_robot() {
        let script = Path::new(&env::var("CARGO_MANIFEST_DIR").unwrap_or_default()).join("no-unwinding.ld");
        println!("cargo::rerun-if-changed={}", script.display());
        println!("cargo::rustc-link-arg-bins=-Wl,-T,{}", script.display());
        println!("cargo::rustc-cfg=no_unwinding");
    }
    println!(
        "cargo::rustc-env=ONEIRO_COMMIT={}",
        commit().unwrap_or_else(|| "unknown".into())
    );
}

/// Whether this is the profile `robot`, on a system whose linkers take the script. Cargo tells a build script neither its profile nor
/// what a panic does, only a folder, PROFILE/build/PACKAGE/out.
fn is_for_robot() -> bool {
    let is_linux = env::var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "linux");
    let folder = env::var("OUT_DIR").unwrap_or_default();
    let profile = Path::new(&folder).ancestors().nth(3).and_then(Path::file_name);
    is_linux && profile.is_some_and(|profile| profile == "robot")
}

/// The commit that whoever builds gives, that is checked out, or that the package was made from; `-modified` if the files are not its own.
/// Nothing where there is no repository.
fn commit() -> Option<String> {
    println!("cargo::rerun-if-env-changed={GIVEN}");
    if let Ok(given) = env::var(GIVEN) {
        return Some(given);
    }
    // Cargo writes the first of these files into packages, and the second into those made from a repository.
    if Path::new("Cargo.toml.orig").exists() {
        let origin = fs::read_to_string(".cargo_vcs_info.json").ok()?;
        let (_, rest) = origin.split_once("\"sha1\": \"")?;
        let is_modified = origin.contains("\"dirty\": true");
        return Some(marked(rest.get(..12)?, is_modified));
    }
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).output().ok()?;
        output
            .status
            .success()
            .then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    // A copy of the sources inside another repository is not of its commits.
    let top = git(&["rev-parse", "--show-toplevel"])?;
    if Path::new(&top).canonicalize().ok()? != Path::new("..").canonicalize().ok()? {
        return None;
    }
    let commit = git(&["rev-parse", "--short=12", "HEAD"])?;
    let is_modified = !git(&["status", "--porcelain"])?.is_empty();
    Some(marked(&commit, is_modified))
}

fn marked(commit: &str, is_modified: bool) -> String {
    format!("{commit}{}", if is_modified { "-modified" } else { "" })
}
