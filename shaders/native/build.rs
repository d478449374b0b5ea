//! Hashes everything that turns WGSL into machine code: this crate, the shader compiler, and the versions of their
//! dependencies. The hash is part of the key of cached code.

use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() {
    let own = PathBuf::from(env::var("CARGO_MANIFEST_DIR").expect("cargo sets it"));
    let mut hasher = blake3::Hasher::new();
    for path in ["src", "../compiler/src", "../../Cargo.lock"] {
        add(&mut hasher, &own.join(path));
    }
    println!("cargo::rustc-env=ONEIRO_SHADER_NATIVE={}", hasher.finalize().to_hex());
}

/// Adds a file, or all files of a directory.
fn add(hasher: &mut blake3::Hasher, path: &Path) {
    println!("cargo::rerun-if-changed={}", path.display());
    if path.is_dir() {
        let mut files: Vec<_> = fs::read_dir(path)
            .and_then(Iterator::collect)
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        files.sort_by_key(fs::DirEntry::path);
        for file in files {
            add(hasher, &file.path());
        }
    } else if let Ok(text) = fs::read(path) {
        hasher.update(blake3::hash(&text).as_bytes());
    }
}
