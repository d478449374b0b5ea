//! What README's table "Extend it" says of things that ship: which files they are in.

use std::path::{Path, PathBuf};

use super::*;

/// Files and folders that a row of the table names.
fn named(row: &str) -> Vec<PathBuf> {
    let table = include_str!("../../../README.md").split("## Extend it").nth(1).unwrap();
    let line = table.lines().find(|line| line.starts_with(&format!("| {row} |")));
    let line = line.unwrap_or_else(|| panic!("no row `{row}`"));
    let paths = line.split('`').skip(1).step_by(2).filter(|own| !own.contains(".md"));
    let paths: Vec<_> = paths.map(|path| root().join(path)).collect();
    assert!(paths.iter().all(|path| path.exists()), "{paths:?}");
    paths
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

/// All sources of Rust, Python and WGSL outside of tests that contain one of some words.
fn sources(words: &[&str]) -> Vec<PathBuf> {
    fn walk(folder: &Path, words: &[&str], found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap();
            if path.is_dir() {
                if !["target", "tests"].contains(&name) {
                    walk(&path, words, found);
                }
            } else if [".rs", ".py", ".pyi", ".wgsl"].iter().any(|end| name.ends_with(end)) && name != "tests.rs" {
                let text = fs::read_to_string(&path).unwrap();
                if words.iter().any(|word| text.contains(word)) {
                    found.push(path);
                }
            }
        }
    }
    let mut found = Vec::new();
    for folder in ["host", "src", "shaders", "python"] {
        walk(&root().join(folder), words, &mut found);
    }
    found.sort();
    found
}

/// An optimiser is in its file and in the registry, of which each line is a kind of the program, and in no other source.
#[test]
fn an_optimiser_is_a_file_and_its_lines_in_the_registry() {
    let place = Place::new("shipped-optimiser");
    let [folder, registry] = &named("optimiser that ships with Oneiro")[..] else {
        panic!("a folder and the registry");
    };
    let text = fs::read_to_string(registry).unwrap();
    let lines = text.split("\noptimisers! {\n").nth(1).unwrap();
    let lines: Vec<&str> = lines.split("\n}\n").next().unwrap().lines().collect();
    let keys: serde_json::Value =
        serde_json::from_str(&place.good(&["new", "--keys", "evolution.kind", "--json"])).unwrap();
    let kinds = keys["single"][0]["choices"].as_array().unwrap();
    assert_eq!(kinds.len(), lines.len());
    for (line, kind) in lines.iter().zip(kinds) {
        let (_, entry) = line.trim().split_once(": ").unwrap();
        let module = entry.split("::").next().unwrap();
        assert!(text.contains(&format!("mod {module};")), "{line}");
        let file = fs::read_to_string(folder.join(module).with_extension("rs")).unwrap();
        let name = kind[0].as_str().unwrap();
        assert!(file.contains(&format!("\"{name}\"")), "{line}: {name}");
    }
    // The one that was added last: by its name, its name in Rust, its file's and its table's.
    let words = [
        "differential-evolution",
        "DifferentialEvolution",
        "differential_evolution",
        "evolution.differential",
    ];
    let mut expected = [folder.join("differential_evolution.rs"), registry.clone()];
    expected.sort();
    assert_eq!(sources(&words), expected);
    // CONTROL: one of which other rooms know, since it has files of its own.
    assert!(sources(&["map-elites"]).len() > 4);
    place.write(
        "own.toml",
        "cycles = 40\n[evolution]\nkind = \"differential-evolution\"\npopulation = 6\ngenerations = 3\nfinalists = 2\n\
         finalist_lives = 2\n[evolution.differential]\nstrategy = \"best/1/bin\"\n",
    );
    place.good(&[&["run", "own.toml", "--seed", "1", "--out", "run"], &CPU[..]].concat());
    place.good(&["verify", "run", "--recompute"]);
}
