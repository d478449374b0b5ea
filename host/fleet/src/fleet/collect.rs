//! Copies of robots' records, and all logs as one timeline.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use oneiro_base::contents::{Entry, describe, head};
use oneiro_base::disk;
use oneiro_base::exit::{Code, Failure, Result};
use oneiro_base::files::by_numbers;
use oneiro_base::plain;
use oneiro_lab::swarm::tables::INTERVALS;

use super::file::{Computers, Fleet, Robot, STATE};
use super::page::{PAGE, REPLAY, SCRIPT};
use super::remote::Remote;
use super::sha256_hex;
use super::statuses::{STATUSES, STATUSES_COLUMNS};
use super::timeline::{self, By, CLOCKS, CLOCKS_COLUMNS, Clock, Line, MOST_CLOCKS};

/// All logs as one.
pub const TIMELINE: &str = "timeline.jsonl";
/// Attempts at a file that changes while it is read.
const ATTEMPTS: u32 = 3;
/// Maximum of what is copied of a robot: bytes of a file (a daemon's log has at most 16 MiB), of all, files, and time. A computer that
/// is not what it was can fill neither the memory nor the disk.
const FILE: usize = 64 << 20;
const RECORD: usize = 512 << 20;
const FILES: usize = 10_000;
const TIME: Duration = Duration::from_hours(1);

/// What came of a robot's record.
#[derive(Debug)]
pub struct Collected {
    pub files: usize,
    pub bytes: usize,
}

/// The files of the directory of a fleet whose robots live by themselves.
pub fn contents_alone() -> Vec<Entry> {
    vec![Entry::file(
        "robot-N/",
        "a copy of robot N's directory, with its `README.md`",
    )]
}

/// The files of a fleet's directory.
pub fn contents() -> Vec<Entry> {
    vec![
        Entry::file(
            "robot-N/",
            "a copy of robot N's directory: its log, its checkpoint, its table of intervals",
        ),
        Entry::file(
            TIMELINE,
            "the events of all logs in the order of `time_ms`, the experiment's time in ms, one line of JSON each; \
             null where the clock is unknown, at the end",
        ),
        Entry::table(
            CLOCKS,
            "one row per start of a daemon: how its clock was aligned",
            &CLOCKS_COLUMNS,
        ),
        Entry::file(INTERVALS, "the tables of intervals of all robots, one below the other"),
        Entry::file(
            "operator.json",
            "written by `oneiro fleet start`: the experiment's time so far, how often it was started, and the accepted \
             datagrams",
        ),
        Entry::table(
            STATUSES,
            "one row per second and robot: robots' reports while `oneiro fleet start` ran",
            &STATUSES_COLUMNS,
        ),
        Entry::file(
            PAGE,
            "written by `oneiro fleet start`: a page that shows the robots while it runs; open it in a browser",
        ),
        Entry::file(SCRIPT, "that page's data, written every second"),
        Entry::file(
            REPLAY,
            "written by `oneiro fleet replay`: a page that plays `statuses.csv`",
        ),
    ]
}

/// Copies a robot's directory. Existing files of it are replaced one by one.
///
/// # Errors
/// Exit 4: the computer can't be reached or has no record; a file changes faster than it can be read; or there is more
/// than a robot's maximum record. Exit 3: a link is in the way here. Exit 6: it can't be written here.
pub fn copy(fleet: &Computers, robot: &Robot, remote: Remote<'_>) -> Result<Collected> {
    let there = format!("{}/{STATE}", fleet.place(robot));
    let list = remote.text(&format!("cd {there} && find . -type f"))?;
    let here = fleet.collected(robot.number);
    plain::make_directory(&fleet.directory).map_err(|error| Failure::storage(&fleet.directory, &error))?;
    let relative = here.strip_prefix(&fleet.directory).unwrap_or(&here);
    let began = Instant::now();
    let mut collected = Collected { files: 0, bytes: 0 };
    for name in list.lines().filter_map(|line| line.trim().strip_prefix("./")) {
        if !is_of_daemon(name) {
            continue;
        }
        let bytes = file(remote, &there, name).map_err(|failure| failure.at(name))?;
        collected.files += 1;
        collected.bytes += bytes.len();
        if collected.files > FILES || collected.bytes > RECORD || began.elapsed() > TIME {
            return Err(Failure::of(
                Code::Device,
                format_args!(
                    "has more than a robot's record; allowed: {FILES} files, {RECORD} bytes and {} min. Copied: {} files",
                    TIME.as_secs() / 60,
                    collected.files - 1
                ),
            ));
        }
        let path = relative.join(name);
        let folder = disk::make_folder(&fleet.directory, path.parent().unwrap_or(relative))?;
        disk::write(&folder.join(path.file_name().unwrap_or_default()), &bytes)?;
    }
    Ok(collected)
}

/// Whether a daemon writes a file of this name; one that is being written is none.
fn is_of_daemon(name: &str) -> bool {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "._-/".contains(c);
    let is_name = |part: &str| !part.is_empty() && part != ".." && !part.starts_with('-');
    name.chars().all(is_plain) && name.split('/').all(is_name) && !name.ends_with(disk::TEMPORARY)
}

/// Reads a file and its hash. A log may grow meanwhile, so both are of its length at the start.
fn file(remote: Remote<'_>, directory: &str, name: &str) -> Result<Vec<u8>> {
    let command = format!(
        "cd {directory} && n=$(wc -c < {name}) && h=$(head -c $n {name} | sha256sum) && echo \"${{h%% *}}\" && head -c $n {name}"
    );
    for _ in 0..ATTEMPTS {
        let mut answer = remote.bytes(&command, FILE)?;
        let end = answer.iter().position(|byte| *byte == b'\n').unwrap_or(answer.len());
        let hash = answer[..end].trim_ascii().to_owned();
        answer.drain(..answer.len().min(end + 1));
        if sha256_hex(&answer).as_bytes() == hash {
            return Ok(answer);
        }
    }
    let problem = format!("arrived {ATTEMPTS} times with another hash than it has there");
    Err(Failure::of(Code::Device, problem))
}

/// The merged record's content.
#[derive(Debug)]
pub struct Merged {
    pub lines: usize,
    pub clocks: Vec<Clock>,
    /// What is not as one would like it.
    pub warnings: Vec<String>,
}

/// Merges what was collected of these robots.
///
/// # Errors
/// Exit 6 when reading or writing fails.
pub fn merge(fleet: &Fleet, robots: &[u32]) -> Result<Merged> {
    let (mut lines, mut torn, mut warnings) = (Vec::new(), 0, Vec::new());
    let (mut starts, mut left_out) = (BTreeSet::new(), 0);
    for &robot in robots {
        for path in logs(&fleet.collected(robot)) {
            let text = disk::read(&path)?;
            for line in String::from_utf8_lossy(&text).lines() {
                match Line::read(robot, line) {
                    Some(line) if starts.len() < MOST_CLOCKS || starts.contains(&(robot, line.boot)) => {
                        starts.insert((robot, line.boot));
                        lines.push(line);
                    }
                    Some(_) => left_out += 1,
                    None => torn += 1,
                }
            }
        }
    }
    let clocks = timeline::align(&lines);
    write_timeline(&fleet.directory, &lines, &clocks)?;
    let table: String = clocks.iter().map(Clock::row).collect();
    disk::write(
        &fleet.directory.join(CLOCKS),
        (head(&CLOCKS_COLUMNS) + &table).as_bytes(),
    )?;
    warnings.extend(intervals(fleet, robots)?);
    warnings.extend(clocks.iter().filter_map(|clock| match clock.by {
        By::Beacon => Some(format!(
            "robot {}, boot {}: was in contact with no other robot; its clock is aligned by the beacon alone",
            clock.robot, clock.boot
        )),
        By::Nothing => Some(format!(
            "robot {}, boot {}: was in contact with no other robot and received no beacon; its lines have no time",
            clock.robot, clock.boot
        )),
        By::Reference | By::Contacts => None,
    }));
    if left_out > 0 {
        warnings.push(format!(
            "{left_out} lines of logs were left out: daemons have started more than {MOST_CLOCKS} times"
        ));
    }
    if torn > 0 {
        warnings.push(format!("{torn} torn lines of logs were left out"));
    }
    describe(&fleet.directory, "A fleet's record", &contents())?;
    Ok(Merged {
        lines: lines.len(),
        clocks,
        warnings,
    })
}

/// Logs of a robot, the oldest first: `log-1.jsonl`, `log-2.jsonl`, and `log.jsonl`, which is written now.
fn logs(directory: &Path) -> Vec<PathBuf> {
    let is_log = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let rest = name.strip_prefix("log").and_then(|rest| rest.strip_suffix(".jsonl"));
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('-'))
    };
    let entries = fs::read_dir(directory).into_iter().flatten().flatten();
    let mut logs: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(is_log).collect();
    logs.sort_by(|a, b| by_numbers(a, b));
    logs
}

/// Writes all lines in the order of their times; those of one time in the order of robots and of their logs.
fn write_timeline(directory: &Path, lines: &[Line], clocks: &[Clock]) -> Result {
    let time = |line: &Line| {
        let clock = clocks
            .iter()
            .find(|clock| (clock.robot, clock.boot) == (line.robot, line.boot));
        clock.and_then(|clock| clock.time(line.at_ms))
    };
    let mut placed: Vec<(Option<f64>, &Line)> = lines.iter().map(|line| (time(line), line)).collect();
    placed.sort_by(|(a, _), (b, _)| a.unwrap_or(f64::INFINITY).total_cmp(&b.unwrap_or(f64::INFINITY)));
    let mut text = String::new();
    for (time, line) in placed {
        // Writing to a string can't fail.
        let _ = writeln!(text, "{}", line.placed(time));
    }
    disk::write(&directory.join(TIMELINE), text.as_bytes())
}

/// Whether a cell is empty or a number.
fn is_number(cell: &str) -> bool {
    cell.is_empty() || cell.parse::<f64>().is_ok()
}

/// Joins the robots' tables of intervals. Returns a warning for each robot whose table is missing, or has other columns than the first.
fn intervals(fleet: &Fleet, robots: &[u32]) -> Result<Vec<String>> {
    let (mut warnings, mut table, mut heads) = (Vec::new(), String::new(), BTreeSet::new());
    for &robot in robots {
        let path = fleet.collected(robot).join(INTERVALS);
        let Some(text) = disk::read_if_there(&path)? else {
            warnings.push(format!("robot {robot}: has no {INTERVALS}"));
            continue;
        };
        let text = String::from_utf8_lossy(&text);
        let (head, rows) = text.split_once('\n').unwrap_or((&text, ""));
        // A daemon writes no cell that a spreadsheet takes for a formula.
        let is_name = |name: &str| name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
        let strange = rows.lines().find(|row| !row.split(',').all(is_number));
        if let Some(row) = strange.or((!head.split(',').all(is_name)).then_some(head)) {
            let row: String = row.chars().take(40).collect();
            warnings.push(format!(
                "robot {robot}: its {INTERVALS} has a row that is not all numbers, {row}; it was left out"
            ));
            continue;
        }
        if heads.is_empty() {
            table = format!("{head}\n");
        }
        heads.insert(head.to_owned());
        if heads.len() > 1 {
            heads.remove(head);
            warnings.push(format!(
                "robot {robot}: its {INTERVALS} has other columns than the first; it was left out"
            ));
            continue;
        }
        table += rows;
        if !table.ends_with('\n') {
            table.push('\n');
        }
    }
    if !heads.is_empty() {
        disk::write(&fleet.directory.join(INTERVALS), table.as_bytes())?;
    }
    Ok(warnings)
}
