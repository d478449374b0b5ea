//! Hashes everything that turns WGSL into machine code: this crate, the shader compiler, the lanes, and the versions of their
//! dependencies. The hash is part of the key of cached code.
//!
//! A package from a registry has none of the others' files, but its manifest and commit say which they are: all packages of Oneiro have the
//! same version, and what makes machine code is pinned to one.

use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() {
    let package = PathBuf::from(env::var("CARGO_MANIFEST_DIR").expect("cargo sets it"));
    let mut hasher = blake3::Hasher::new();
    // Cargo writes this file into packages.
    let paths: &[&str] = if package.join("Cargo.toml.orig").exists() {
        let commit = ".cargo_vcs_info.json";
        let has_commit = package.join(commit).exists();
        if has_commit {
            &["src", "Cargo.toml", commit]
        } else {
            &["src", "Cargo.toml"]
        }
    } else {
        &[
            "src",
            "../compiler/src",
            "../src/lanes",
            "../wgsl/lib",
            "../../Cargo.lock",
        ]
    };
    for path in paths {
        add(&mut hasher, &package.join(path));
    }
    println!("cargo::rustc-env=ONEIRO_SHADER_NATIVE={}", hasher.finalize().to_hex());
    let target = env::var("TARGET").expect("cargo sets it");
    println!("cargo::rustc-env=ONEIRO_TARGET={target}");
}

/// Adds a file, or all files of a directory.
fn add(hasher: &mut blake3::Hasher, path: &Path) {
    println!("cargo::rerun-if-changed={}", path.display());
    if path.is_dir() {
        let mut files: Vec<_> = existing(path, fs::read_dir(path).and_then(Iterator::collect));
        files.sort_by_key(fs::DirEntry::path);
        for file in files {
            add(hasher, &file.path());
        }
    } else {
        hasher.update(blake3::hash(&existing(path, fs::read(path))).as_bytes());
    }
}

/// Stops the build if a path can't be read: with a hash of less, code of other compilers could be loaded from the cache.
fn existing<T>(path: &Path, content: io::Result<T>) -> T {
    content.unwrap_or_else(|error| {
        let path = path.display();
        panic!("{path}: {error}; cached code is named by a hash of it, so it must be there")
    })
}
