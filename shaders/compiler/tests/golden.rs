//! What is printed for small kernels, to be read and compared. `BLESS=1 cargo test --test golden` writes the
//! files anew; then read the difference.

use std::path::PathBuf;
use std::{env, fs};

use oneiro_shader_compiler::{Part, compile};

/// The kernel `tests/golden/NAME.wgsl` and what it becomes, `tests/golden/NAME.lanes`.
fn check(name: &str) {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    let path = folder.join(format!("{name}.lanes"));
    let text = fs::read_to_string(folder.join(format!("{name}.wgsl"))).unwrap();
    let part = Part {
        path: format!("{name}.wgsl"),
        text,
    };
    let compiled = compile(name, &[part]).unwrap_or_else(|refusals| panic!("{}", refusals[0]));
    let found = format!(
        "// bindings\n{}\n// structs\n{}\n// lanes\n{}",
        compiled.bindings, compiled.structs, compiled.lanes
    );
    if env::var_os("BLESS").is_some() {
        fs::write(&path, found).unwrap();
        return;
    }
    let expected = fs::read_to_string(&path).unwrap_or_default();
    let differs = found.lines().zip(expected.lines()).position(|(a, b)| a != b);
    let line = differs.unwrap_or_else(|| found.lines().count().min(expected.lines().count()));
    assert!(
        found == expected,
        "{} differs from line {} on, `{}`: see the comment at the top of this test",
        path.display(),
        line + 1,
        found.lines().nth(line).unwrap_or_default(),
    );
}

#[test]
fn buffers() {
    check("buffers");
}

#[test]
fn branches() {
    check("branches");
}

#[test]
fn loops() {
    check("loops");
}
