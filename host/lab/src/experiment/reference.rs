//! Reference of all settings: the commented experiment of `oneiro new`, the listing of `oneiro new --keys`, and
//! `docs/configuration.md`.

use oneiro::compose;
use oneiro::differential::SensorKind;
use oneiro::foraging::Forager;
use oneiro::parameter::Parameter;
use oneiro::world::WorldSpec;
use serde::Serialize;

use super::settings::Settings;
use super::swarm;
use super::values::{self, Described, unit_words};

/// A key of an experiment.
#[derive(Debug, Serialize)]
pub struct Entry {
    pub key: &'static str,
    pub unit: &'static str,
    /// Default as TOML; `None` if the key is optional.
    pub default: Option<String>,
    pub allowed: String,
    /// The allowed words with their meanings.
    pub choices: Vec<(&'static str, &'static str)>,
    /// The kind that the key requires, if it requires one.
    pub(crate) only_with: Option<String>,
    /// The key of that kind: `kind` for its table's.
    #[serde(skip)]
    kind: &'static str,
    pub source: &'static str,
    pub about: String,
}

/// All keys of an experiment with single robots.
pub fn single() -> Vec<Entry> {
    entries::<Settings>()
}

/// Keys of an experiment with a forager.
fn forager() -> Vec<Entry> {
    let forager = || {
        let mut own = Settings::default();
        own.arena.preset = None;
        own.world = WorldSpec::foraging(Forager::ODOWD2014);
        own
    };
    // A forager brings its body, noise and arena.
    let is_its = |row: &Parameter<Settings>| {
        let is_in = |mut own: Settings| (row.field)(&mut own, 0).is_some();
        match row.key.split_once('.') {
            Some(("arena", _)) => !is_in(Settings::default()),
            Some(("robot", key)) => is_in(forager()) && !["preset", "collision"].contains(&key),
            Some(("noise", _)) => false,
            _ => true,
        }
    };
    let rows = Settings::rows().iter().filter(|row| is_its(row));
    by_table(rows.map(|row| entry(row, forager())).collect())
}

/// The keys of an experiment with custom parts, in these files.
fn with_parts(mut entries: Vec<Entry>, parts: &[(compose::Kind, String)]) -> Vec<Entry> {
    for (kind, file) in parts {
        let word = kind.word();
        let [chosen, part] = ["kind", "part"].map(|key| format!("{word}.{key}"));
        let is_shipped = |entry: &Entry| entry.place().0 == word && entry.only_with.as_deref() != Some("\"own\"");
        entries.retain(|entry| !is_shipped(entry) || *kind == compose::Kind::Sensor || entry.key == chosen);
        // The values have a separate table.
        let values = format!("{word}.values");
        entries.retain(|entry| entry.key != values);
        for entry in &mut entries {
            if entry.key == chosen {
                entry.default = Some("\"own\"".into());
            } else if entry.key == part {
                (entry.only_with, entry.default) = (None, Some(format!("{file:?}")));
            }
        }
    }
    entries
}

/// All keys of an experiment of the foraging study.
pub fn swarm() -> Vec<Entry> {
    entries::<swarm::File>()
}

/// One entry for each row, table by table.
fn entries<T: Described>() -> Vec<Entry> {
    by_table(T::rows().iter().map(|row| entry(row, T::default())).collect())
}

/// Sorts entries by the order in which their tables are first named.
fn by_table(mut entries: Vec<Entry>) -> Vec<Entry> {
    let mut tables: Vec<&str> = Vec::new();
    for entry in &entries {
        let (table, _) = entry.place();
        if !tables.contains(&table) {
            tables.push(table);
        }
    }
    entries.sort_by_key(|entry| tables.iter().position(|table| *table == entry.place().0));
    entries
}

/// The entry of a row, with the default that it has in an experiment.
fn entry<T: Described>(row: &Parameter<T>, mut own: T) -> Entry {
    let (mut only_with, mut kind) = (None, "kind");
    values::grow(row, &mut own);
    if (row.field)(&mut own, 0).is_none()
        && let Some(((key, words), under)) = values::under(row, None)
    {
        (only_with, kind, own) = (Some(words), key, under);
    }
    let field = (row.field)(&mut own, 0).expect("every row has its field somewhere");
    let default = field.get().filter(|datum| !values::is_open(datum));
    Entry {
        key: row.key,
        unit: row.unit,
        default: default.map(|datum| values::value(&datum, None).to_string()),
        allowed: values::allowed(row, field),
        choices: field.choices(),
        only_with,
        kind,
        source: row.source,
        about: about(row.key, row.about),
    }
}

/// The meaning of a key, and the kinds of sensors that have it.
fn about(key: &str, words: &str) -> String {
    let kinds = key.strip_prefix("robot.sensors[].").map(SensorKind::with);
    match kinds.unwrap_or_default().split_last() {
        None => words.to_owned(),
        Some((kind, [])) => format!("{words} Only of the kind {kind}."),
        Some((last, kinds)) => format!("{words} Only of the kinds {} and {last}.", kinds.join(", ")),
    }
}

impl Entry {
    /// The entry's table, and its name in that table; elements of a list belong to their list's table.
    fn place(&self) -> (&'static str, &'static str) {
        let list = self.key.split('[').next().unwrap_or_default();
        let table = list.rsplit_once('.').map_or("", |(table, _)| table);
        (table, self.key[table.len()..].trim_start_matches('.'))
    }

    /// A line of a file; without a default, the user has to fill it in.
    fn line(&self, entries: &[Self]) -> String {
        let (_, key) = self.place();
        let elements = format!("{}[].", self.key);
        let elements: Vec<String> = entries
            .iter()
            .filter_map(|entry| Some((entry.key.strip_prefix(&elements)?, entry.default.as_deref())))
            .map(|(key, default)| format!("{key} = {}", default.unwrap_or("...")))
            .collect();
        match &self.default {
            Some(default) if self.only_with.is_none() => format!("{key} = {default}\n"),
            Some(default) => format!("# {key} = {default}\n"),
            None if elements.is_empty() => format!("# {key} = ...\n"),
            None => format!("# {key} = [{{ {} }}]\n", elements.join(", ")),
        }
    }

    /// Description of the key and its allowed values.
    pub fn words(&self) -> String {
        let allowed = if self.choices.is_empty() {
            self.allowed.clone()
        } else {
            let words: Vec<String> = self
                .choices
                .iter()
                .map(|(word, about)| format!("{word:?} ({about})"))
                .collect();
            words.join(", ")
        };
        let only = self
            .only_with
            .as_ref()
            .map_or_else(String::new, |words| format!("; only with {} = {words}", self.kind));
        format!(
            "{} Allowed: {allowed}{}{only}.",
            self.about,
            unit_words(self.key, self.unit)
        )
    }
}

/// A part to start from, in WGSL.
pub fn part(kind: compose::Kind, is_foragers: bool) -> &'static str {
    match kind {
        compose::Kind::Sensor => include_str!("parts/sensor.wgsl"),
        compose::Kind::Controller => include_str!("parts/controller.wgsl"),
        compose::Kind::Task if is_foragers => include_str!("parts/forager_task.wgsl"),
        compose::Kind::Task => include_str!("parts/task.wgsl"),
    }
}

/// Experiments to start from.
#[derive(Clone, Copy, Debug)]
pub enum Template<'a> {
    /// Single robots and a task that ships.
    Single,
    /// Single robots and custom parts, in these files.
    Own(&'a [(compose::Kind, String)]),
    /// A forager, and custom parts, in these files.
    Forager(&'a [(compose::Kind, String)]),
    /// The foraging study.
    Swarm,
}

/// Parts and their files in words.
fn named(parts: &[(compose::Kind, String)]) -> String {
    let parts = parts
        .iter()
        .map(|(kind, file)| format!("the {} of {file}", kind.word()));
    parts.collect::<Vec<_>>().join(" and ")
}

/// An experiment with every value at its default, each with a comment.
pub fn example(name: &str, template: Template<'_>) -> String {
    let (what, entries) = match template {
        Template::Swarm => (
            "E-pucks learn to forage: the study of O'Dowd, Studley and Winfield, \"The distributed co-evolution of an \
             on-board simulator and controller for swarm robot behaviours\", 2014."
                .to_owned(),
            swarm(),
        ),
        Template::Single => (
            "A Khepera learns to avoid obstacles: the study of Miglino, Lund and Nolfi, \"Evolving mobile robots in \
             simulated and real environments\", Artificial Life 2(4), 1995, in its condition without noise."
                .to_owned(),
            single(),
        ),
        Template::Own(parts) => {
            let about = format!("A Khepera with {} (docs/extend.md).", named(parts));
            (about, with_parts(single(), parts))
        }
        Template::Forager([]) => (
            "An e-puck learns when to seek the light and when to flee it, to bring food to its nest: the on-board simulator of \
             O'Dowd, Studley and Winfield, 2014 (docs/epuck.md)."
                .to_owned(),
            forager(),
        ),
        Template::Forager(parts) => {
            let about = format!("An e-puck that brings food to its nest, with {} (docs/extend.md).", named(parts));
            (about, with_parts(forager(), parts))
        }
    };
    let but = match template {
        Template::Forager(_) => "the name, the kinds of robot, controller and task, and the cycles",
        Template::Own(_) => "the name and the parts that are your own",
        Template::Single | Template::Swarm => "the name",
    };
    let rest = format!(
        "Each value but {but} is the default: without its line it would be the same. Any of them can be changed for one \
         run, such as --set seed=3. Files are looked for from where this file lies. `oneiro new --keys` and \
         docs/configuration.md list all keys, and where each default is from."
    );
    let mut text = format!(
        "{}#\n#     oneiro run {name}.toml --seed 1\n#\n{}\n",
        comment(&what),
        comment(&rest)
    );
    let mut table = "";
    for entry in &entries {
        let (own, _) = entry.place();
        // Elements are in the line of their list; hashes of files are added by runs.
        if entry.key.contains("[]") || entry.key == "files" {
            continue;
        }
        if own != table {
            text += &values_of(table, template);
            text.extend(["\n[", own, "]\n"]);
            table = own;
        }
        text += &comment(&entry.words());
        if entry.key == "name" {
            text.extend(["name = \"", name, "\"\n"]);
        } else {
            text += &entry.line(&entries);
        }
    }
    text + &values_of(table, template)
}

/// An experiment with a parametric robot, given in full by the text of one that ships, in a custom arena.
pub fn described(name: &str, robot: &str, parts: &[(compose::Kind, String)]) -> String {
    let with = if parts.is_empty() {
        String::new()
    } else {
        format!(", with {}", named(parts))
    };
    let about = format!(
        "A robot that is described by numbers, to be changed (docs/robots.md){with}. What is not here has its default: `oneiro new --keys` and \
         docs/configuration.md list all keys. Files are looked for from where this file lies."
    );
    let lights = if robot.contains("kind = \"light\"") {
        "lights = [{ x_mm = 500.0, y_mm = 500.0 }]\n"
    } else {
        ""
    };
    let own = parts.iter().map(|(kind, file)| {
        let own = if *kind == compose::Kind::Sensor {
            ""
        } else {
            "kind = \"own\"\n"
        };
        format!("\n[{}]\n{own}part = \"{file}\"\n", kind.word())
    });
    format!(
        "{}#\n#     oneiro run {name}.toml --seed 1\n\nname = \"{name}\"\n\n{robot}\n[arena]\nwidth_mm = 1000.0\nheight_mm = 1000.0\n{lights}{}",
        comment(&about),
        own.collect::<String>()
    )
}

/// The table of the values that a table's custom part declares, as comments; nothing for a table without a custom part.
fn values_of(table: &str, template: Template<'_>) -> String {
    let is_foragers = matches!(template, Template::Forager(_));
    let parts = match template {
        Template::Own(parts) | Template::Forager(parts) => parts,
        Template::Single | Template::Swarm => &[],
    };
    let own = parts.iter().find(|(kind, _)| kind.word() == table);
    let part = own.and_then(|(kind, file)| compose::Part::new(*kind, file, part(*kind, is_foragers)).ok());
    let Some(part) = part.filter(|part| !part.values().is_empty()) else {
        return String::new();
    };
    let value = |value: &compose::Value| {
        let compose::Value {
            name,
            default,
            allowed,
            unit,
            about,
        } = value;
        let space = if unit.is_empty() { "" } else { " " };
        format!("# {name} = {default:?} # {allowed}{space}{unit}: {about}\n")
    };
    let values: String = part.values().iter().map(value).collect();
    let head = comment(&format!("Values that {} declares, with their defaults.", part.path()));
    format!("\n[{table}.values]\n{head}{values}")
}

/// Formats text as lines of a comment.
fn comment(words: &str) -> String {
    const WIDTH: usize = 118;
    let mut lines = String::new();
    let mut line = String::new();
    for word in words.split(' ') {
        if !line.is_empty() && line.len() + 1 + word.len() > WIDTH {
            lines.extend(["# ", &line, "\n"]);
            line.clear();
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line += word;
    }
    lines + &format!("# {line}\n")
}

/// The tables of the reference page.
#[cfg(test)]
pub fn tables() -> String {
    let mut page = String::new();
    for (title, entries) in [
        ("Experiments with single robots", single()),
        ("Experiments with swarms", swarm()),
    ] {
        page.extend(["\n## ", title, "\n"]);
        let mut table = None;
        for entry in &entries {
            let (own, _) = entry.place();
            if table != Some(own) {
                let title = if own.is_empty() {
                    "Before all tables".to_owned()
                } else {
                    format!("`[{own}]`")
                };
                page.extend([
                    "\n### ",
                    &title,
                    "\n\n| key | default | allowed | meaning | default from |\n|---|---|---|---|---|\n",
                ]);
                table = Some(own);
            }
            page += &line(entry);
        }
    }
    page
}

#[cfg(test)]
fn line(entry: &Entry) -> String {
    let words = entry.choices.iter().map(|(word, about)| format!("`{word}`: {about}"));
    let allowed = if entry.choices.is_empty() {
        format!("{}{}", entry.allowed, unit_words(entry.key, entry.unit))
    } else {
        words.collect::<Vec<_>>().join("; ")
    };
    let default = entry
        .default
        .as_ref()
        .map_or(String::new(), |default| format!("`{default}`"));
    let only = entry
        .only_with
        .as_ref()
        .map_or_else(String::new, |words| format!(" Only with `{} = {words}`.", entry.kind));
    let cells = [
        format!("`{}`", entry.key),
        default,
        allowed,
        format!("{}{only}", entry.about),
        entry.source.into(),
    ];
    format!("| {} |\n", cells.map(|cell| cell.replace('|', "\\|")).join(" | "))
}
