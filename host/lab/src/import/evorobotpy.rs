//! evorobotpy: an `.ini` with the environment's name and its values, next to `.sample` files with its robot's sensors.

use std::collections::BTreeMap;
use std::path::Path;

use oneiro::network::GREATEST_UNITS;
use oneiro_base::exit::Result;

use super::draft::{Draft, Outline, Thing, failure};

/// The environment that Oneiro can be: a Khepera, walls and a cylinder.
const ENVIRONMENT: &str = "ErDiscrim";
/// Sensors' files of that environment, of walls and of its cylinder. A file's name is its class.
const TABLES: [&str; 2] = ["khepera-wall", "khepera-scylinder"];

/// Reads a file.
///
/// # Errors
/// Exit 3: the line, what is wrong, what is allowed.
pub(super) fn read(path: &Path, name: &str, text: &str, out: &Path) -> Result<Draft> {
    let mut values: BTreeMap<(String, String), (usize, String)> = BTreeMap::new();
    let mut section = String::new();
    for (index, line) in text.lines().enumerate() {
        let (line, number) = (line.trim(), index + 1);
        if line.is_empty() || line.starts_with(['#', ';']) {
            continue;
        }
        if let Some(title) = line.strip_prefix('[').and_then(|line| line.strip_suffix(']')) {
            title.clone_into(&mut section);
            continue;
        }
        let Some((key, value)) = line.split_once(['=', ':']) else {
            return Err(failure(
                name,
                number,
                "is no value; allowed: [SECTION], KEY = VALUE, # for comments",
            ));
        };
        // Python's reader ignores the case of keys.
        let key = (section.clone(), key.trim().to_lowercase());
        let shown = key.1.clone();
        if values.insert(key, (number, value.trim().to_owned())).is_some() {
            return Err(failure(
                name,
                number,
                format_args!("[{section}] {shown}: is given twice; allowed: once"),
            ));
        }
    }
    let mut take = |sections: &[&str], key: &str| {
        let found = sections
            .iter()
            .find_map(|section| values.remove_entry(&((*section).to_owned(), key.to_owned())));
        found.map(|((section, _), (line, value))| (line, value, format!("[{section}] {key}")))
    };
    let Some((line, environment, what)) = take(&["EXP"], "environment") else {
        let problem = "has no environment; allowed: [EXP] with environment = ErDiscrim";
        return Err(failure(name, 1, problem));
    };
    if environment != ENVIRONMENT {
        let shown: String = environment.chars().take(40).collect();
        let problem = format_args!(
            "{what}: is `{shown}`, whose robots and arena are a program; allowed: {ENVIRONMENT} (a Khepera, walls and a cylinder)"
        );
        return Err(failure(name, line, problem));
    }
    let mut draft = Draft::new(name, "Lengths are mm in both.");
    // Its program, not this file, has the arena.
    let size = [400.0; 2];
    let arena = format!("{what}: {ENVIRONMENT}'s program has walls around 400 x 400 mm");
    draft.enclose(Outline::Rectangle { low: [0.0; 2], size }, line, arena)?;
    let cylinder = Thing::Obstacle {
        at: [200.0, 150.0],
        radius: 12.5,
    };
    draft.add(
        cylinder,
        line,
        format!("{what}: a cylinder; its program draws its place for each episode, Oneiro does not"),
    )?;
    draft.leave_out(
        line,
        &*what,
        "the task is a program; `oneiro new --example discrimination` has one in WGSL",
    );
    draft.set(
        ("robot", "states"),
        "\"evorobot\"",
        line,
        format!("{what}: 21 speeds of a wheel"),
    );
    tables(path, out, line, &mut draft);
    for (key, to, [least, most]) in [
        ("maxsteps", ("", "cycles"), [1, 1_000_000]),
        ("episodes", ("", "trials"), [1, 10_000]),
    ] {
        if let Some((line, value, what)) = take(&["POLICY", "ADAPT"], key) {
            match value.parse() {
                Ok(number) if (least..=most).contains(&number) => draft.set(to, format!("{number}"), line, what),
                _ => {
                    return Err(failure(
                        name,
                        line,
                        format_args!("{what}: is `{value}`; allowed: {least} to {most}"),
                    ));
                }
            }
        }
    }
    let layers = take(&["POLICY"], "nlayers");
    if let Some((line, value, what)) = take(&["POLICY"], "nhiddens") {
        match value.parse::<u32>() {
            Ok(0) => (),
            Ok(units) if units <= GREATEST_UNITS => {
                draft.set(("controller", "kind"), "\"network\"", line, &*what);
                let count = layers
                    .as_ref()
                    .and_then(|(_, value, _)| value.parse::<usize>().ok())
                    .unwrap_or(1);
                let layer = format!("{{ units = {units} }}");
                let count = count.clamp(1, 4);
                draft.set(
                    ("controller", "layers"),
                    format!("[{}]", vec![layer; count].join(", ")),
                    line,
                    what,
                );
            }
            _ => {
                return Err(failure(
                    name,
                    line,
                    format_args!("{what}: is `{value}`; allowed: 0 to {GREATEST_UNITS}"),
                ));
            }
        }
    }
    for ((section, key), (line, _)) in values {
        let why = match section.as_str() {
            "ALGO" | "ADAPT" => "optimisers differ; [evolution] chooses one: docs/optimisers.md",
            "POLICY" => "[controller] chooses a network: docs/controllers.md",
            _ => "Oneiro has nothing like it",
        };
        draft.leave_out(line, format!("[{section}] {key}"), why);
    }
    Ok(draft)
}

/// Names the sensors' files that lie next to the file; without them Oneiro's Khepera stands there.
fn tables(path: &Path, out: &Path, line: usize, draft: &mut Draft) {
    let [folder, beside] = [path, out].map(|path| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        folder.unwrap_or(Path::new("."))
    });
    let files = TABLES.map(|class| format!("{class}.sample"));
    if !files.iter().all(|file| folder.join(file).is_file()) {
        let why = "they are not next to this file; Oneiro's Khepera has its own";
        draft.leave_out(line, files.join(", "), why);
        return;
    }
    let [folder, beside] = [folder, beside].map(|folder| folder.canonicalize().ok());
    let paths = files.map(|file| match &folder {
        Some(folder) if folder.to_str().is_some() && Some(folder) != beside.as_ref() => {
            folder.join(&file).display().to_string()
        }
        _ => file,
    });
    draft.set(
        ("robot", "tables"),
        format!("{paths:?}"),
        line,
        "its sensors, next to this file",
    );
    draft.classes = Some(TABLES);
}
