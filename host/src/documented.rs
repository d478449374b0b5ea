//! Tests: the pages describe what the program writes.

mod imports;
mod words;

use std::fs;
use std::path::Path;

use oneiro::compose::Scalar;
use oneiro_base::contents::{Column, Entry, table, tables};
use oneiro_fleet::fleet;
use oneiro_lab::lives::measures;
use oneiro_lab::reality::wired::logbook;
use oneiro_lab::record;
use oneiro_lab::runs;
use oneiro_lab::sweep;
use oneiro_studies as studies;
use toml::{Table, Value};

use crate::commands;
use crate::scratch::holds;

/// All directories, each with all that it may hold.
fn page() -> String {
    let single = runs::single::all_contents();
    let swarm = runs::swarm::all_contents();
    let of_single = sweep::contents::all_entries(runs::single::all_outcomes(), runs::single::all_steps(), true);
    let of_swarms = sweep::contents::all_entries(runs::swarm::all_outcomes(), runs::swarm::all_steps(), false);
    let [of_1995, second_of_1995, of_2014, second_of_2014] = studies::all_contents();
    let directories = [
        ("A run of a single robot", record::contents(single, true)),
        ("A run of a swarm", record::contents(swarm, false)),
        ("A sweep of single robots", of_single),
        ("A sweep of swarms", of_swarms),
        ("A comparison", oneiro_lab::compare::contents()),
        ("Episodes on a robot", logbook::all_contents()),
        ("A calibration", commands::robot::calibrate::contents()),
        #[cfg(all(unix, feature = "compose"))]
        (
            "A robot that evolves on board",
            oneiro_fleet::daemon::single::transfers::contents(),
        ),
        ("A fleet", fleet::collect::contents()),
        #[cfg(feature = "twin")]
        ("A fleet's twin", fleet::twin::all_contents()),
        ("The 1995 study", of_1995),
        ("The second edition of the 1995 study", second_of_1995),
        ("The 2014 study", of_2014),
        ("The second edition of the 2014 study", second_of_2014),
    ];
    let section = |(title, entries): (&str, Vec<Entry>)| format!("\n## {title}\n{}", tables(&entries, "###"));
    directories.map(section).concat()
}

#[test]
#[cfg_attr(not(feature = "twin"), ignore = "the page has the files of twins too")]
fn the_page_on_files_is_that_of_the_writers() {
    const MARK: &str = "move it here. -->\n";
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/files.md");
    let text = fs::read_to_string(&path).unwrap();
    let (head, _) = text.split_once(MARK).unwrap();
    holds(&path, &format!("{head}{MARK}{}", page())).unwrap();
}

#[test]
fn the_page_on_measures_is_that_of_the_writers() {
    const MARK: &str = "move it here. -->\n";
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/measures.md");
    let text = fs::read_to_string(&path).unwrap();
    let (head, _) = text.split_once(MARK).unwrap();
    let own = [measures::remembered_as("NAME", Scalar::Float), measures::score_of("N")];
    let columns = measures::LIFE.iter().map(|(column, ..)| column).chain(&own);
    let rows =
        columns.map(|Column { name, unit, about, .. }| [format!("`{name}`"), (*unit).to_owned(), about.to_string()]);
    let table = table(["measure", "unit", "meaning"], &rows.collect::<Vec<_>>());
    holds(&path, &format!("{head}{MARK}{table}")).unwrap();
}

/// The names of a manifest's dependencies.
fn dependencies(manifest: &Path) -> Vec<String> {
    let manifest: Table = fs::read_to_string(manifest).unwrap().parse().unwrap();
    manifest["dependencies"].as_table().unwrap().keys().cloned().collect()
}

/// Those after `oneiro-`.
fn uses(manifest: &Path) -> Vec<String> {
    let mut uses: Vec<String> = dependencies(manifest)
        .iter()
        .filter_map(|name| name.strip_prefix("oneiro-").filter(|name| *name != "shaders"))
        .map(str::to_owned)
        .collect();
    uses.sort();
    uses
}

#[test]
fn what_architecture_says_is_what_manifests_say() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let text = fs::read_to_string(root.join("docs/architecture.md")).unwrap();
    let (_, section) = text.split_once("## Crates of the program").unwrap();
    let (section, _) = section.split_once("\n## ").unwrap();
    let rows = section.lines().filter_map(|line| line.strip_prefix("| `host/"));
    let mut crates = 0;
    for row in rows {
        let (name, rest) = row.split_once("` |").unwrap();
        let said = rest.trim_end().trim_end_matches('|').rsplit('|').next().unwrap().trim();
        let manifest = root.join("host").join(name).join("Cargo.toml");
        assert_eq!(uses(&manifest).join(", "), said, "{name}");
        crates += 1;
    }
    let folders = fs::read_dir(root.join("host")).unwrap();
    let have_manifests = folders.filter(|folder| folder.as_ref().unwrap().path().join("Cargo.toml").exists());
    assert_eq!(crates, 1 + have_manifests.count());
}

/// The package `oneiro` is no member of the workspace, so that it repeats what all members have.
#[test]
fn the_package_that_is_published_as_oneiro_has_the_version_of_the_others() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let read = |path: &str| -> Table { fs::read_to_string(root.join(path)).unwrap().parse().unwrap() };
    let (workspace, published) = (read("Cargo.toml"), read("packaging/oneiro/Cargo.toml"));
    let common = &workspace["workspace"]["package"];
    for key in [
        "version",
        "edition",
        "rust-version",
        "license",
        "repository",
        "keywords",
    ] {
        assert_eq!(published["package"][key], common[key], "{key}");
    }
    let exact = format!("={}", common["version"].as_str().unwrap());
    let parts = workspace["workspace"]["dependencies"].as_table().unwrap();
    let parts = parts.iter().chain(published["dependencies"].as_table().unwrap());
    let versions: Vec<_> = parts.filter(|(_, part)| part.get("path").is_some()).collect();
    assert!(versions.len() > 15);
    for (name, part) in versions {
        // What is not published needs none.
        let version = part.get("version").and_then(Value::as_str);
        assert!(
            version == Some(&exact) || name == "oneiro-shader-corpus",
            "{name}: {version:?}"
        );
    }
    // The placeholder.
    let repository = common["repository"].as_str().unwrap();
    let python = read("python/pyproject.toml");
    assert_eq!(python["project"]["urls"]["Repository"].as_str(), Some(repository));
    for file in [
        "packaging/part.md",
        "packaging/debian/control",
        "packaging/debian/copyright",
    ] {
        assert!(
            fs::read_to_string(root.join(file)).unwrap().contains(repository),
            "{file}"
        );
    }
}
