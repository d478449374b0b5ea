//! A fleet: robots with a computer each on which `oneiro on-board` runs, and the operator's machine, which installs, starts, watches
//! and stops them and collects their records.
//!
//! | file | content |
//! |---|---|
//! | [`mod@file`] | `fleet.toml`, and the `robot.toml` of each robot |
//! | [`alone`] | the same for robots without a swarm |
//! | [`remote`] | commands and files for robots' computers, by the system's `ssh` |
//! | [`install`] | what a robot's computer gets, and how it is checked there |
//! | [`service`] | how the daemon is started and stopped there: by systemd, or as a process |
//! | [`operator`] | the beacon, without which robots stand, and what robots report |
//! | [`live`] | a fleet's run, from the first robot's answer to the experiment's end |
//! | [`table`] | the robots' known states, for a terminal and as JSON |
//! | [`statuses`] | robots' reports, as a table and for a page |
//! | [`page`] | the page that shows it in a browser, during the experiment and afterwards |
//! | [`collect`] | copies of robots' directories |
//! | [`compare`] | a fleet or its twins compared with the batched study |
//! | [`twin`] | a fleet's daemons on this machine, in one arena and on one virtual clock |
//! | [`timeline`] | all logs as one, with clocks aligned by what robots heard of each other |

mod alone;
pub mod collect;
pub mod compare;
pub mod file;
pub mod install;
pub mod live;
pub mod operator;
pub mod page;
pub mod remote;
pub mod service;
mod statuses;
pub mod table;
pub mod timeline;
#[cfg(unix)]
pub mod twin;

use std::fmt::Display;

use oneiro_base::console::counted;
use oneiro_base::exit::{Code, Failure, Result};
use sha2::{Digest, Sha256};

/// The hash that `sha256sum` prints: all that robots' computers can check before they have our program.
fn sha256_hex(bytes: &[u8]) -> String {
    let digits = Sha256::digest(bytes)
        .into_iter()
        .flat_map(|byte| [byte >> 4, byte & 15]);
    digits.filter_map(|digit| char::from_digit(digit.into(), 16)).collect()
}

/// What came of each robot: its number, and the problem if there was one.
pub type Outcomes<T> = Vec<(u32, std::result::Result<T, Failure>)>;

/// Says whether enough robots did what all were asked to.
///
/// # Errors
/// Exit 4 with the number of those that failed, if fewer than `min` did it (without `min`: if any failed).
pub fn enough<T>(outcomes: &Outcomes<T>, min: Option<u32>, what: impl Display) -> Result {
    let failed = outcomes.iter().filter(|(_, outcome)| outcome.is_err()).count();
    let done = outcomes.len() - failed;
    if failed == 0 || min.is_some_and(|min| done >= min as usize) {
        return Ok(());
    }
    let needed = min.map_or_else(String::new, |min| format!(", and --min asks for {min}"));
    let robots = counted(outcomes.len(), "robot", "robots");
    let problem = format!("{what}: {failed} of {robots} failed{needed}");
    Err(Failure::of(Code::Device, problem))
}

#[cfg(all(test, unix))]
mod tests;
