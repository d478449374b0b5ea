//! What CONTRIBUTING's table of new things says of things that ship: which files they are in.

use std::path::{Path, PathBuf};

use super::*;

/// Files and folders that a row of the table names.
fn named(row: &str) -> Vec<PathBuf> {
    let table = include_str!("../../../CONTRIBUTING.md")
        .split("## Add a thing")
        .nth(1)
        .unwrap();
    let line = table.lines().find(|line| line.starts_with(&format!("| {row} |")));
    let line = line.unwrap_or_else(|| panic!("no row `{row}`"));
    let paths = line
        .split('`')
        .skip(1)
        .step_by(2)
        .filter(|own| !own.contains(".md") && own.contains('/'));
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
                let text = text.split("mod tests {").next().unwrap();
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

/// Lines of a source from one that begins a list to the one that ends it.
fn list<'a>(text: &'a str, begin: &str, end: &str) -> Vec<&'a str> {
    let (_, rest) = text.split_once(begin).unwrap_or_else(|| panic!("no {begin}"));
    rest.split(end).next().unwrap().lines().map(str::trim).collect()
}

/// Checks that a registry declares a module, which is a file in a folder, and returns its text.
fn room(folder: &Path, registry: &str, module: &str) -> String {
    assert!(registry.contains(&format!("mod {module};")), "{module}");
    fs::read_to_string(folder.join(module).with_extension("rs")).unwrap()
}

/// The words that a key of experiments has, with their meanings.
fn choices(place: &Place, key: &str) -> Vec<String> {
    let keys: serde_json::Value = serde_json::from_str(&place.good(&["new", "--keys", key, "--json"])).unwrap();
    let choices = keys["single"][0]["choices"].as_array().unwrap();
    choices
        .iter()
        .map(|choice| choice[0].as_str().unwrap().to_owned())
        .collect()
}

fn sorted<const N: usize>(mut paths: [PathBuf; N]) -> [PathBuf; N] {
    paths.sort();
    paths
}

/// An optimiser is in its file and in the registry, of which each line is a kind of the program, and in no other source.
#[test]
fn an_optimiser_is_a_file_and_its_lines_in_the_registry() {
    let place = Place::new("shipped-optimiser");
    let [folder, registry] = &named("optimiser that ships with Oneiro")[..] else {
        panic!("a folder and the registry");
    };
    let text = fs::read_to_string(registry).unwrap();
    let lines = list(&text, "\noptimisers! {\n", "\n}\n");
    let kinds = choices(&place, "evolution.kind");
    assert_eq!(kinds.len(), lines.len());
    for (line, name) in lines.iter().zip(kinds) {
        let (_, entry) = line.split_once(": ").unwrap();
        let module = entry.split("::").next().unwrap();
        let file = room(folder, &text, module);
        assert!(file.contains(&format!("\"{name}\"")), "{line}: {name}");
    }
    // The one that was added last: by its name, its name in Rust, its file's and its table's.
    let words = [
        "differential-evolution",
        "DifferentialEvolution",
        "differential_evolution",
        "evolution.differential",
    ];
    let expected = [folder.join("differential_evolution.rs"), registry.clone()];
    assert_eq!(sources(&words), sorted(expected));
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

/// A driver is in its file and in the registry, of which each line is a driver, and in no other source.
#[test]
fn a_driver_is_a_file_and_its_lines_in_the_registry() {
    let place = Place::new("shipped-driver");
    let [folder, registry] = &named("real robot")[..] else {
        panic!("a folder and the registry");
    };
    let text = fs::read_to_string(registry).unwrap();
    let listed = place.good(&["robot", "list", "--json"]);
    let lines = list(&text, "const DRIVERS: &[&Driver] = &[\n", "\n];");
    let modules: Vec<&str> = lines
        .iter()
        .filter_map(|line| line.strip_prefix('&')?.strip_suffix("::DRIVER,"))
        .collect();
    assert!(modules.len() > 4, "{lines:?}");
    for module in modules {
        let file = room(folder, &text, module);
        let robots = list(&file, "robots: &[", "],").concat();
        for robot in robots
            .split(", ")
            .filter_map(|name| name.strip_prefix('"')?.strip_suffix('"'))
        {
            // The smallest driver is for tests.
            assert_eq!(listed.contains(robot), module != "rover", "{robot}: {listed}");
        }
    }
    let expected = [folder.join("rover.rs"), registry.clone()];
    assert_eq!(sources(&["rover", "Rover"]), sorted(expected));
}

/// The page's table is the registry of drivers.
#[test]
fn the_page_lists_all_addresses() {
    const HEAD: &str = "| address | robots |\n|---|---|\n";
    let place = Place::new("shipped-addresses");
    let listed: serde_json::Value = serde_json::from_str(&place.good(&["robot", "list", "--json"])).unwrap();
    let row = |row: &serde_json::Value| {
        let [form, robots] = ["form", "robots"].map(|key| row[key].as_str().unwrap());
        format!("| `{form}` | {robots} |\n")
    };
    let rows: String = listed["addresses"].as_array().unwrap().iter().map(row).collect();
    let path = root().join("docs/robots-on-the-wire.md");
    let page = fs::read_to_string(&path).unwrap();
    let (before, rest) = page.split_once(HEAD).expect("the table's head");
    let (_, after) = rest.split_once("\n\n").expect("the table's end");
    let written = format!("{before}{HEAD}{rows}\n{after}");
    if page != written {
        let new = path.with_extension("md.new");
        fs::write(&new, written).unwrap();
        panic!("{} differs from the registry: read {}", path.display(), new.display());
    }
}

/// A picture is in its file and in the list, and in no other source; a run has it, and says what it shows.
#[test]
fn a_picture_of_a_run_is_a_file_and_its_lines_in_the_list() {
    let place = Place::new("shipped-picture");
    let [folder, pictures] = &named("picture of a run of single robots")[..] else {
        panic!("a folder and the list");
    };
    let text = fs::read_to_string(pictures).unwrap();
    place.write(
        "elites.toml",
        "cycles = 40\n[evolution]\nkind = \"map-elites\"\npopulation = 6\ngenerations = 2\nfinalists = 2\nfinalist_lives = 2\n\
         [[evolution.descriptors]]\nmeasure = \"end_x_mm\"\nleast = 0.0\ngreatest = 1000.0\n\
         [[evolution.descriptors]]\nmeasure = \"end_y_mm\"\nleast = 0.0\ngreatest = 1000.0\n",
    );
    place.write(
        "race.toml",
        "cycles = 40\n[evolution]\nkind = \"race\"\nfinalists = 2\nfinalist_lives = 2\nrace.lives = 300\n",
    );
    for kind in ["elites", "race"] {
        place.good(
            &[
                &["run", &format!("{kind}.toml"), "--seed", "1", "--out", kind],
                &CPU[..],
            ]
            .concat(),
        );
    }
    let modules = list(&text, "const PICTURES: &[Picture] = &[", "];").concat();
    for module in modules
        .split(',')
        .filter_map(|line| line.trim().strip_suffix("::PICTURE"))
    {
        let file = room(folder, &text, module);
        let name = list(&file, "name: \"", "\",").concat();
        let kind = if module.ends_with("race") { "race" } else { "elites" };
        assert!(place.text(format!("{kind}/{name}")).starts_with("<svg"), "{name}");
        let contents = place.text(format!("{kind}/README.md"));
        assert!(contents.contains(&format!("`{name}`")), "{name}: {contents}");
    }
    assert_eq!(sources(&["archive.svg"]), [folder.join("archive.rs")]);
    assert_eq!(sources(&["archive::PICTURE"]), std::slice::from_ref(pictures));
}

/// The columns of a run's generations are in one file.
#[test]
fn a_column_of_generations_is_in_a_file() {
    let [file] = &named("column of a run's `generations.csv`")[..] else {
        panic!("one file");
    };
    assert_eq!(sources(&["\"best_bits\""]), std::slice::from_ref(file));
}

/// A result of a sweep's runs is a line beside its value.
#[test]
fn a_result_of_a_sweeps_runs_is_a_line() {
    let [of_single, of_foragers] = &named("result of a sweep's runs")[..] else {
        panic!("two files");
    };
    for (file, column) in [(of_single, "best_individual"), (of_foragers, "late_rate")] {
        assert_eq!(
            sources(&[&format!("\"{column}\"")]),
            std::slice::from_ref(file),
            "{column}"
        );
        assert!(
            include_str!("../../../docs/files.md").contains(&format!("`{column}`")),
            "{column}"
        );
    }
}

/// A kind of sensors is in its file, in the registry and in the WGSL of readings, and in no other source.
#[test]
fn a_kind_of_sensor_is_a_file_and_its_lines_in_the_registry_and_a_function() {
    let place = Place::new("shipped-sensor");
    let [folder, registry, kernels] = &named("kind of sensor of a parametric robot")[..] else {
        panic!("a folder, the registry and the functions");
    };
    let text = fs::read_to_string(registry).unwrap();
    let lines = list(&text, "\nkinds! {\n", "\n}\n");
    let lines: Vec<&str> = lines.into_iter().filter(|line| !line.starts_with("//")).collect();
    let kinds = choices(&place, "robot.sensors[].kind");
    assert_eq!(kinds.len(), lines.len());
    for (line, name) in lines.iter().zip(kinds) {
        let (_, entry) = line.split_once(": ").unwrap();
        let file = room(folder, &text, entry.split("::").next().unwrap());
        assert!(file.contains(&format!("\"{name}\"")), "{line}: {name}");
    }
    let words = ["SensorKind::Bumper", "bumper::", "\"bumper\"", "fn bumper_at("];
    let expected = [folder.join("bumper.rs"), registry.clone(), kernels.clone()];
    assert_eq!(sources(&words), sorted(expected));
}
