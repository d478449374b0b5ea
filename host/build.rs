//! Tells the program which commit it was built from, for what runs record.

use std::path::Path;
use std::process::Command;

fn main() {
    // Files that determine the commit, and whether the build differs from it.
    for path in ["build.rs", "src", "../src", "../shaders", "../.git/logs/HEAD"] {
        if Path::new(path).exists() {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    println!(
        "cargo::rustc-env=ONEIRO_COMMIT={}",
        commit().unwrap_or_else(|| "unknown".into())
    );
}

/// The commit that is checked out, `-modified` if the files are not its own; nothing where there is no repository.
fn commit() -> Option<String> {
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
    Some(commit + if is_modified { "-modified" } else { "" })
}
