//! `fleet.toml` of robots without a swarm, each with its file for `oneiro on-board`.
//!
//! ```toml
//! binary = "oneiro-aarch64"
//!
//! [[robots]]
//! number = 1
//! host = "pi@10.0.0.11"
//! robot = "khepera-1.toml"                # relative to this file
//! ```

use std::path::Path;

use oneiro_base::exit::{Failure, Result};
use oneiro_lab::experiment::source::{Parsed, Source};
#[cfg(feature = "compose")]
use oneiro_lab::kinds::FileKind;
use serde::Deserialize;

use super::file::{Computers, Robot, Service, Ssh, check_host, directory, remote};

/// Keys of the file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    #[serde(default = "directory")]
    directory: String,
    binary: String,
    #[serde(default = "remote")]
    remote: String,
    #[serde(default)]
    service: Service,
    #[serde(default)]
    ssh: Ssh,
    robots: Vec<WrittenRobot>,
}

/// Keys of a robot.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenRobot {
    number: u32,
    host: String,
    robot: String,
}

/// Reads and checks a fleet's file, the robots' own files, and their experiments with all files that these name.
///
/// # Errors
/// Exit 3: the file, the line and column in it, the key, the problem and the allowed values.
pub(super) fn read(path: &Path, file: &Parsed<'_>) -> Result<Computers> {
    let (written, source): (Written, _) = Source::read(file, &[])?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let paths = [written.directory, written.binary, written.remote];
    let mut computers = Computers::new(folder, paths, written.service, written.ssh, &source)?;
    let numbers: Vec<u32> = written.robots.iter().map(|robot| robot.number).collect();
    Computers::check_numbers(&numbers, &source)?;
    for (index, WrittenRobot { number, host, robot }) in written.robots.into_iter().enumerate() {
        let at = |key: &str| format!("robots[{index}].{key}");
        check_host(&host, &at("host"), &source)?;
        let refused = |failure: Failure| source.invalid(&at("robot"), failure);
        let computer = of_file(&folder.join(robot), number, host).map_err(refused)?;
        computers.robots.push(computer);
    }
    computers.robots.sort_by_key(|robot| robot.number);
    Ok(computers)
}

/// A robot by its own file. On its computer that has the experiment as a run's directory has it, with all files below.
#[cfg(feature = "compose")]
fn of_file(path: &Path, number: u32, host: String) -> Result<Robot> {
    use super::file::{EXPERIMENT, STATE};
    use crate::daemon::settings::Settings as Member;
    use crate::daemon::single::settings::Settings;

    let refused = |problem: &str| Failure::input(format_args!("{}: {problem}", path.display()));
    let text = FileKind::Robot.text(path)?;
    let parsed = FileKind::Robot.parsed(path, &text)?;
    if Member::is_of_member(&parsed) {
        return Err(refused(
            "is of a member of a swarm; allowed: a file without robot, key and [radio], or `experiment` of a swarm in the fleet's file",
        ));
    }
    let settings = Settings::of(path, &parsed)?;
    let mut files = vec![(
        EXPERIMENT.to_owned(),
        settings.experiment.resolved_toml(settings.seed).into_bytes(),
    )];
    for input in settings.experiment.inputs() {
        // It goes into commands of a shell.
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "._-/".contains(c);
        if !input.name.chars().all(is_plain) || input.name.contains("/-") {
            return Err(refused(&format!(
                "its experiment names {}; allowed on other computers: files whose names are of letters, digits, `.`, `_` and `-`",
                input.named
            )));
        }
        files.push((input.name.clone(), input.content.bytes.clone()));
    }
    let mut table: toml::Table = text.parse().map_err(Failure::input)?;
    table.insert("experiment".into(), EXPERIMENT.into());
    table.insert("directory".into(), STATE.into());
    Ok(Robot {
        number,
        host,
        address: table["address"].as_str().unwrap_or_default().to_owned(),
        radio: None,
        share: Some(settings.evolution.share),
        time: Some(settings.time()),
        toml: toml::to_string(&table).map_err(Failure::input)?,
        files,
    })
}

/// The robot's file can't be checked by this program.
#[cfg(not(feature = "compose"))]
fn of_file(path: &Path, _: u32, _: String) -> Result<Robot> {
    Err(Failure::input(format_args!(
        "{}: this program was built without the feature `compose`, which robots without a swarm need; allowed: a program \
         built with it (docs/robots-on-the-wire.md)",
        path.display()
    )))
}
