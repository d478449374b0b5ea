//! A study's directory, and what every study writes and says.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::claims::Claim;
use crate::console::{Console, columns};
use crate::exit::{Failure, Result};
use crate::record::write_whole;
use crate::report::csv::Csv;

/// What a study's directory says of it.
const SETTINGS: &str = "study.json";

/// Where a study goes whose user names no place.
pub(super) fn usual(name: &str, seed: u64, settings: &impl std::fmt::Debug) -> PathBuf {
    let hash = blake3::hash(format!("{settings:?}").as_bytes()).to_hex();
    PathBuf::from(format!("runs/{name}-{seed}-{}", &hash[..8]))
}

/// Makes the study's directory, or recognises it.
pub(super) fn open(directory: &Path, settings: &impl Serialize) -> Result {
    let path = directory.join(SETTINGS);
    fs::create_dir_all(directory).map_err(|error| Failure::storage(directory, &error))?;
    let text = serde_json::to_string_pretty(settings).map_err(Failure::failed)?;
    match fs::read_to_string(&path) {
        Ok(known) if known == text => Ok(()),
        Ok(_) => Err(Failure::input(format_args!(
            "{}: is another study's; allowed: the arguments that it was begun with, or another --out",
            path.display()
        ))),
        Err(_) if fs::read_dir(directory).is_ok_and(|mut entries| entries.next().is_some()) => {
            Err(Failure::input(format_args!(
                "{}: is not empty and holds no study; allowed: a new directory, or one of a study",
                directory.display()
            )))
        }
        Err(_) => write_whole(&path, text.as_bytes()),
    }
}

/// Writes the claims.
pub(super) fn write_claims(directory: &Path, claims: &[Claim]) -> Result {
    let text = serde_json::to_vec_pretty(claims).map_err(Failure::failed)?;
    write_whole(&directory.join("claims.json"), &text)
}

/// Writes which claims hold under which assumptions: a row an assumption, a column a claim.
pub(super) fn write_sensitivity(directory: &Path, arms: &[(String, Vec<Claim>)]) -> Result {
    let first = arms.first().map_or(&[][..], |(_, claims)| claims);
    let mut table = Csv::new(std::iter::once("arm").chain(first.iter().map(|claim| claim.id.as_str())));
    for (arm, claims) in arms {
        let verdicts = claims.iter().map(|claim| claim.verdict.to_string());
        table.row(std::iter::once(arm.clone()).chain(verdicts));
    }
    write_whole(&directory.join("sensitivity.csv"), table.text().as_bytes())
}

/// Refuses a number of runs that has no spread to hold a difference against, or too many.
pub(super) fn check_runs(runs: u32, most: u32) -> Result {
    if (2..=most).contains(&runs) {
        return Ok(());
    }
    Err(Failure::input(format_args!(
        "--runs {runs}: a test of runs needs two at the least; allowed: 2 to {most}"
    )))
}

/// Tells the user what came out.
pub(super) fn tell(claims: &[Claim], directory: &Path, console: Console) -> Result {
    let verdicts: Vec<Vec<String>> = claims
        .iter()
        .map(|claim| vec![claim.id.clone(), claim.verdict.to_string()])
        .collect();
    if console.json() {
        console.json_data(&claims)?;
    } else {
        console.data(columns(&["claim", "verdict"], &verdicts))?;
    }
    console.say(format!("wrote {}", directory.display()));
    Ok(())
}
