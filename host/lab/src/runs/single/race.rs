//! The table of a race: who dropped out, generation by generation.

use std::path::Path;

use oneiro_base::contents::{Column, Entry};
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_evolve::race::Round;

/// The file.
pub(super) const FILE: &str = "race.csv";

static COLUMNS: [Column; 5] = [
    Column::whole("generation", "", "its number, from 0"),
    Column::whole(
        "race",
        "",
        "the number of the race that it belongs to, from 1: an iteration of the iterated race",
    ),
    Column::whole("candidates", "", "candidates that were evaluated"),
    Column::whole(
        "survivors",
        "",
        "candidates left after its test; after a race's last generation, those around which the next race samples",
    ),
    Column::whole(EPISODES, "", "episodes that all candidates have spent so far"),
];
const EPISODES: &str = "episodes";

/// Its description in a run's directory, and its first line.
pub(super) fn entry() -> Entry {
    let about = "with `evolution.kind = \"race\"`: candidates and survivors, one row per generation";
    Entry::table(FILE, about, &COLUMNS)
}

pub(super) fn head() -> Vec<u8> {
    oneiro_base::contents::head(&COLUMNS).into_bytes()
}

/// The last row of these rounds.
pub(super) fn line(rounds: &[Round], trials: u32) -> String {
    let Some(Round {
        race,
        candidates,
        survivors,
    }) = rounds.last()
    else {
        return String::new();
    };
    let (generation, spent) = (rounds.len() - 1, spent(rounds, trials).last().unwrap_or(0));
    format!("{generation},{race},{candidates},{survivors},{spent}\n")
}

/// Episodes spent after each round.
pub(super) fn spent(rounds: &[Round], trials: u32) -> impl Iterator<Item = u64> {
    rounds.iter().scan(0, move |spent, round| {
        *spent += u64::from(round.candidates) * u64::from(trials);
        Some(*spent)
    })
}

/// Episodes that a run's race had spent after each generation; none if its directory has no such table, as that of another optimiser.
///
/// # Errors
/// Exit 5 if the table isn't what was written.
pub(crate) fn recorded(directory: &Path) -> Result<Option<Vec<u64>>> {
    let path = directory.join(FILE);
    let Some(bytes) = disk::read_if_there(&path)? else {
        return Ok(None);
    };
    let mut table = csv::Reader::from_reader(&bytes[..]);
    let rows = table.deserialize::<std::collections::BTreeMap<String, u64>>();
    let spent = rows.map(|row| row.ok()?.get(EPISODES).copied()).collect::<Option<_>>();
    let damaged = || Failure::corrupt(format_args!("{}: is not what was written", path.display()));
    spent.map(Some).ok_or_else(damaged)
}
