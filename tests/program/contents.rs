//! That a directory holds what its `README.md` says, and nothing else.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// What a README says: all files, and the columns of tables.
struct Readme {
    files: BTreeMap<String, String>,
    columns: BTreeMap<String, Vec<String>>,
}

impl Readme {
    fn read(directory: &Path) -> Self {
        let text = fs::read_to_string(directory.join("README.md")).unwrap();
        let mut own = Self {
            files: BTreeMap::new(),
            columns: BTreeMap::new(),
        };
        let mut table = None;
        for line in text.lines() {
            let cells: Vec<&str> = line.split('|').map(str::trim).collect();
            match cells[..] {
                [name] if is_table(name) => table = Some(name.to_owned()),
                ["", name, about, ""] if name.starts_with('`') => {
                    own.files.insert(name.trim_matches('`').to_owned(), about.to_owned());
                }
                ["", name, _, about, ""] if name.starts_with('`') => {
                    assert!(!about.is_empty(), "{line}");
                    let columns = own.columns.entry(table.clone().unwrap()).or_default();
                    columns.push(name.trim_matches('`').to_owned());
                }
                _ => (),
            }
        }
        assert!(own.files.values().all(|about| !about.is_empty()), "{text}");
        own
    }

    /// The columns of a table: its own, or those of another that it names.
    fn columns_of(&self, table: &str) -> &[String] {
        let other = self.files[table]
            .split_once("the columns of `")
            .map(|(_, other)| other.trim_end_matches('`'));
        &self.columns[other.unwrap_or(table)]
    }
}

fn is_table(name: &str) -> bool {
    Path::new(name).extension().is_some_and(|extension| extension == "csv")
}

/// A file's name with letters in place of the numbers that the README leaves open.
fn general(name: &str) -> String {
    let numbers = |text: &str| text.chars().all(|c| c.is_ascii_digit());
    if name.strip_prefix("checkpoint-").is_some_and(numbers) {
        return "checkpoint-N".into();
    }
    let replay = name.strip_prefix("replay-").and_then(|name| name.split_once('.'));
    if let Some((what, extension)) = replay {
        return match what.split_once('-') {
            None if numbers(what) => format!("replay-K.{extension}"),
            Some((number, _)) if numbers(number) => format!("replay-K-WHAT.{extension}"),
            _ => format!("replay-WHAT.{extension}"),
        };
    }
    let shard = name.strip_prefix("shard-").and_then(|name| name.split_once("-of-"));
    match shard {
        Some((index, of)) if numbers(index) && numbers(of) => "shard-I-of-N".into(),
        _ => name.into(),
    }
}

/// What is there, by general names; of shards also what is in them.
fn there(directory: &Path) -> BTreeSet<String> {
    let mut all = BTreeSet::new();
    for entry in fs::read_dir(directory).unwrap() {
        let path = entry.unwrap().path();
        let name = general(path.file_name().unwrap().to_str().unwrap());
        if !path.is_dir() {
            all.insert(name);
            continue;
        }
        if name == "shard-I-of-N" {
            all.extend(there(&path).into_iter().map(|inner| format!("{name}/{inner}")));
        }
        all.insert(name + "/");
    }
    all
}

/// Whether a table has the columns. One whose name is in capitals stands for one or more.
fn fits(columns: &[String], head: &[&str]) -> bool {
    let is_open = |name: &str| name.bytes().any(|byte| byte.is_ascii_uppercase());
    match (columns, head) {
        ([], []) => true,
        ([own, rest @ ..], [name, others @ ..]) if is_open(own) => {
            let start = own.trim_end_matches(|c: char| c.is_ascii_uppercase());
            name.starts_with(start) && (fits(rest, others) || fits(columns, others))
        }
        ([own, rest @ ..], [name, others @ ..]) => own == name && fits(rest, others),
        _ => false,
    }
}

/// Panics with what the README does not name, or names and is not there.
#[track_caller]
pub(crate) fn check(directory: &Path) {
    let readme = Readme::read(directory);
    let named: BTreeSet<String> = readme.files.keys().cloned().collect();
    assert_eq!(there(directory), named, "{}", directory.display());
    let tables: Vec<&String> = named.iter().filter(|name| is_table(name)).collect();
    assert!(readme.columns.keys().all(|table| tables.contains(&table)));
    for table in tables {
        let mut names = fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().file_name());
        let name = names.find(|name| general(name.to_str().unwrap()) == *table).unwrap();
        let text = fs::read_to_string(directory.join(name)).unwrap();
        let head: Vec<&str> = text.lines().next().unwrap().split(',').collect();
        let columns = readme.columns_of(table);
        assert!(
            fits(columns, &head),
            "{table} has {head:?}, its description {columns:?}"
        );
    }
}
