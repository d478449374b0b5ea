//! Reference of all settings: the listing of `oneiro new --keys`, `docs/configuration.md`, and the comments of `oneiro new --all-keys`.

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
pub(super) fn forager() -> Vec<Entry> {
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
    pub(super) fn place(&self) -> (&'static str, &'static str) {
        let list = self.key.split('[').next().unwrap_or_default();
        let table = list.rsplit_once('.').map_or("", |(table, _)| table);
        (table, self.key[table.len()..].trim_start_matches('.'))
    }

    /// The line of a file that doesn't set the key: a comment with its default. Without a default, the user has to fill it in.
    pub(super) fn line(&self, entries: &[Self]) -> String {
        let (_, key) = self.place();
        let elements = format!("{}[].", self.key);
        let elements: Vec<String> = entries
            .iter()
            .filter_map(|entry| Some((entry.key.strip_prefix(&elements)?, entry.default.as_deref())))
            .map(|(key, default)| format!("{key} = {}", default.unwrap_or("...")))
            .collect();
        match &self.default {
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
