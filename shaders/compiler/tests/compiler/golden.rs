//! The code printed for small kernels is kept in files, to be read and compared. See [`pinned`] for how to accept changes.

use std::fs;
use std::path::PathBuf;

use crate::pinned;
use oneiro_shader_compiler::{Binding, Indices, Part, compile};

const KERNELS: [&str; 3] = ["branches", "buffers", "loops"];

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden")
}

/// Compares the code of each kernel `tests/golden/NAME.wgsl` with `tests/golden/NAME.lanes`.
#[test]
fn kernels_become_what_is_pinned() {
    let problems: Vec<String> = KERNELS
        .iter()
        .filter_map(|name| {
            let path = format!("{name}.wgsl");
            let text = fs::read_to_string(folder().join(&path)).unwrap();
            let compiled = compile(name, &[Part { path, text }], Indices::Clamped)
                .unwrap_or_else(|refusals| panic!("{}", refusals[0]));
            let found = format!(
                "// bindings\n{}\n// structs\n{}\n// lanes\n{}",
                compiled.bindings.iter().map(Binding::as_rust).collect::<String>(),
                compiled.structs.unwrap(),
                compiled.lanes
            );
            pinned::problem(&folder().join(format!("{name}.lanes")), &found)
        })
        .collect();
    assert!(problems.is_empty(), "{}", problems.join("\n"));
    let files = KERNELS.map(|name| [format!("{name}.wgsl"), format!("{name}.lanes")]);
    pinned::check_folder(&folder(), &files.concat());
}
