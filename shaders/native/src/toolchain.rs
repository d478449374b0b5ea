//! Compiles kernels by a Rust toolchain: their lane code, as for the kernels that ship, becomes a library with an instance
//! for every instruction set of this machine.

use std::ffi::OsString;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::{env, fs, io};

use oneiro_shader_compiler::Trees;
use oneiro_shader_compiler::instances::{self, TARGETS};

use crate::library::{Instance, LibraryError, Made};
use crate::stack::check_arrays;

/// Oldest Rust that compiles lane code.
const OLDEST: &str = env!("CARGO_PKG_RUST_VERSION");

/// Name of the lane function.
const NAME: &str = "kernel";

/// Sources of the library besides the lane code: those of the lanes, and what they need of `oneiro-shaders`.
const SOURCES: [(&str, &str); 9] = [
    ("kernel.rs", KERNEL),
    ("lanes/mod.rs", include_str!("../../src/lanes/mod.rs")),
    ("lanes/avx2.rs", include_str!("../../src/lanes/avx2.rs")),
    ("lanes/avx512.rs", include_str!("../../src/lanes/avx512.rs")),
    ("lanes/checked.rs", include_str!("../../src/lanes/checked.rs")),
    ("lanes/neon.rs", include_str!("../../src/lanes/neon.rs")),
    ("lanes/pair.rs", include_str!("../../src/lanes/pair.rs")),
    ("lanes/scalar.rs", include_str!("../../src/lanes/scalar.rs")),
    ("lanes/uniform.rs", include_str!("../../src/lanes/uniform.rs")),
];

/// Stands in for `oneiro-shaders`' module `kernel`. The layout of `Words` is fixed here, since another compiler than this
/// program's reads it.
const KERNEL: &str = "#[derive(Clone, Copy)]
#[repr(C)]
pub struct Words {
    pub start: *mut u32,
    pub len: usize,
}
pub struct Variant {
    pub name: &'static str,
    pub lanes: u32,
    pub available: fn() -> bool,
    pub run: unsafe fn(&[Words], u32, u32),
}
";

/// Reasons why a toolchain made no library.
#[derive(Debug, thiserror::Error)]
pub enum ToolchainError {
    /// There is no compiler.
    #[error(
        "the Rust compiler `{0}` can't be started: {1}; install Rust {OLDEST} or newer, or name its compiler in the environment \
         variable RUSTC"
    )]
    Missing(String, io::Error),
    /// It isn't known what the compiler is.
    #[error(
        "`{0} -vV` doesn't tell a version of Rust; allowed: a compiler of Rust {OLDEST} or newer in the environment variable RUSTC"
    )]
    Unknown(String),
    /// The compiler is too old.
    #[error("`{0}` is of Rust {1}; allowed: {OLDEST} or newer")]
    TooOld(String, String),
    /// The processor has no vectors that are worth it.
    #[error("this processor has none of the instruction sets that lane code is compiled for: AVX-512, AVX2, NEON")]
    Narrow,
    /// The local arrays of the lanes of every instance don't fit on a thread's stack.
    #[error("{0}")]
    Arrays(crate::Error),
    /// The compiler failed.
    #[error("`{0}` can't compile the kernel's lane code:\n{1}")]
    Failed(String, String),
    /// The library can't be loaded.
    #[error(transparent)]
    Library(#[from] LibraryError),
    /// The cache can't be written.
    #[error("the cache of compiled kernels can't be written: {0}")]
    Storage(#[from] io::Error),
}

/// A Rust compiler.
#[derive(Clone, Debug)]
pub struct Toolchain {
    rustc: PathBuf,
    version: String,
}

impl Toolchain {
    /// Finds the compiler that the environment variable `RUSTC` names, or else `rustc`.
    ///
    /// # Errors
    /// [`ToolchainError::Missing`], [`ToolchainError::Unknown`] or [`ToolchainError::TooOld`].
    pub fn find() -> Result<Self, ToolchainError> {
        let named = env::var_os("RUSTC").filter(|name| !name.is_empty());
        Self::at(named.unwrap_or_else(|| OsString::from("rustc")).into())
    }

    /// The compiler with this path or name.
    ///
    /// # Errors
    /// As [`Self::find`].
    pub fn at(rustc: PathBuf) -> Result<Self, ToolchainError> {
        let name = rustc.display().to_string();
        let told = match Command::new(&rustc).arg("-vV").stdin(Stdio::null()).output() {
            Ok(told) => told,
            Err(error) => return Err(ToolchainError::Missing(name, error)),
        };
        let told = String::from_utf8_lossy(&told.stdout).into_owned();
        let release = told.lines().find_map(|line| line.strip_prefix("release: "));
        let version = told.lines().find_map(|line| line.strip_prefix("rustc "));
        let (Some(version), Some(number)) = (version, release.and_then(number)) else {
            return Err(ToolchainError::Unknown(name));
        };
        if Some(number) < self::number(OLDEST) {
            return Err(ToolchainError::TooOld(name, release.unwrap_or_default().to_owned()));
        }
        let version = version.to_owned();
        Ok(Self { rustc, version })
    }

    /// The compiler's version, such as `1.95.0 (59807616e 2026-04-14)`.
    pub fn version(&self) -> &str {
        &self.version
    }

    /// Compiles a program's lane code in an empty folder.
    pub(crate) fn compile(&self, trees: &Trees, folder: &Path) -> Result<Made, ToolchainError> {
        let targets: Vec<_> = TARGETS.iter().filter(|target| runs_here(target)).copied().collect();
        let mut text = String::from("mod kernel;\nmod lanes;\n");
        text += &instances::lanes("crate", NAME, &trees.lanes(NAME), &targets);
        let mut made = Vec::new();
        let mut too_large = None;
        for target in &targets {
            for (vectors, width) in target.shapes {
                if let Err(error) = check_arrays(trees, vectors * width) {
                    too_large = Some(error);
                    continue;
                }
                let instance = Instance::new(target.name, vectors * width);
                // Writing to a string can't fail.
                let _ = writeln!(
                    text,
                    "#[unsafe(no_mangle)]\n\
                     pub unsafe extern \"C\" fn {}(b: *const Words, n: usize, w: u32, l: u32) {{\n    \
                     {NAME}_{}(core::slice::from_raw_parts(b, n), w, l)\n}}",
                    instance.symbol(),
                    instance.name(),
                );
                made.push(instance);
            }
        }
        if made.is_empty() {
            return Err(too_large.map_or(ToolchainError::Narrow, ToolchainError::Arrays));
        }
        fs::create_dir(folder.join("lanes"))?;
        let root = (OsString::from("library.rs"), text.as_str());
        let sources = SOURCES.iter().map(|(path, text)| (OsString::from(path), *text));
        for (path, text) in sources.chain([root]) {
            fs::write(folder.join(path), text)?;
        }
        // Each instance is one function that holds all it calls: as many can be compiled at a time.
        let units = format!("codegen-units={}", made.len());
        let ended = Command::new(&self.rustc)
            .args(["--edition", "2024", "--crate-type", "cdylib", "--crate-name", NAME])
            .args(["--target", env!("ONEIRO_TARGET"), "--cap-lints", "allow"])
            .args([
                "-C",
                "opt-level=3",
                "-C",
                "panic=abort",
                "-C",
                "strip=symbols",
                "-C",
                &units,
            ])
            .args(["-o", "library", "library.rs"])
            .current_dir(folder)
            .stdin(Stdio::null())
            .output()?;
        if !ended.status.success() {
            let said = String::from_utf8_lossy(&ended.stderr).trim().to_owned();
            return Err(ToolchainError::Failed(self.rustc.display().to_string(), said));
        }
        Ok(Made {
            library: fs::read(folder.join("library"))?,
            instances: made,
            compiler: self.version.clone(),
        })
    }
}

/// The first two numbers of a version.
fn number(version: &str) -> Option<(u32, u32)> {
    let mut numbers = version.split(['.', '-']).map(str::parse);
    match (numbers.next(), numbers.next()) {
        (Some(Ok(first)), Some(Ok(second))) => Some((first, second)),
        _ => None,
    }
}

/// Whether this processor runs the code for an instruction set with vectors.
fn runs_here(target: &instances::Target) -> bool {
    !target.features.is_empty() && target.features.iter().all(|feature| has(feature))
}

/// Whether this processor has a feature.
#[cfg(target_arch = "x86_64")]
fn has(feature: &str) -> bool {
    match feature {
        "avx2" => is_x86_feature_detected!("avx2"),
        "avx512f" => is_x86_feature_detected!("avx512f"),
        "avx512bw" => is_x86_feature_detected!("avx512bw"),
        "avx512dq" => is_x86_feature_detected!("avx512dq"),
        "avx512vl" => is_x86_feature_detected!("avx512vl"),
        _ => false,
    }
}

/// Whether this processor has a feature.
#[cfg(not(target_arch = "x86_64"))]
fn has(feature: &str) -> bool {
    // Of 64-bit ARM all have it that this program runs on.
    cfg!(target_arch = "aarch64") && feature == "neon"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_compared_as_numbers() {
        assert_eq!(number("1.95.0"), Some((1, 95)));
        assert_eq!(number("1.100.0-nightly"), Some((1, 100)));
        assert!(number("1.100.0") > number("1.95"));
        assert_eq!(number("nightly"), None);
        assert!(number(OLDEST).is_some());
    }

    /// Every instruction set that has several lanes can be detected.
    #[test]
    fn features_are_known() {
        for target in TARGETS.iter().filter(|target| !target.features.is_empty()) {
            let is_known = cfg!(target_arch = "x86_64") == target.arch.contains("x86_64");
            let detected = target.features.iter().all(|feature| has(feature));
            assert!(is_known || !detected, "{}", target.name);
        }
    }

    #[test]
    fn what_is_no_compiler_is_refused() {
        let missing = Toolchain::at("no-such-compiler".into()).unwrap_err();
        assert!(matches!(missing, ToolchainError::Missing(..)), "{missing}");
    }
}
