//! Whole studies of papers, from one command to a report. Experiments and claims stand in files under `experiments`;
//! only the arithmetic of judging is here.

pub(crate) mod assumptions;
pub(crate) mod claims;
mod contrasts;
mod directory;
pub(crate) mod file;
pub(crate) mod miglino1995;
pub(crate) mod odowd2014;
mod sweep_results;
pub(crate) mod verdict;
mod verdicts;

/// The files of any directory of the 1995 study and of the 2014 study, and of their second editions.
#[cfg(test)]
pub(crate) fn all_contents() -> [Vec<crate::contents::Entry>; 4] {
    let of = |own| directory::contents(own, true);
    let [of_1995, of_2014] = [miglino1995::contents(true, true, true), odowd2014::contents(true)].map(of);
    [
        of_1995,
        miglino1995::contents_of_second(),
        of_2014,
        odowd2014::contents_of_second(),
    ]
}

/// The claims of the papers.
const MIGLINO1995_CLAIMS: &str = include_str!("../../../experiments/miglino1995/claims.toml");
const ODOWD2014_CLAIMS: &str = include_str!("../../../experiments/odowd2014/claims.toml");
