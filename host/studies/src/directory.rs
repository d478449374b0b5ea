//! Code shared by all studies: a directory that keeps finished work, the study under each arm, and the files and
//! messages it produces.

use std::fs::File;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

use oneiro_base::answer::Answer;
use oneiro_base::console::{Console, wrapped};
use oneiro_base::contents::{Column, Entry, describe};
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files::directory::{self, Form, Found, Holds};
use oneiro_base::sealed::{self, Problem};
use oneiro_lab::device::Backend;
use oneiro_report::csv::Csv;
use oneiro_report::page;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::assumptions::Assumption;
use super::claims::Claim;
use super::file::{Arm, Edition, StudyFile};
use super::verdict::brief;
use super::verdicts::{Assumed, Sensitivity, power};
use crate::Findings;

/// File that records the settings of the study in a directory.
const SETTINGS: &str = "study.json";
const RESULTS: &str = "results.json";
const CLAIMS: &str = "claims.json";
const REPORT: &str = "report.html";
const SENSITIVITY: &str = "sensitivity.csv";
/// The directory of the study under each other arm.
const ARMS: &str = "arms";

static ARM: Column = Column::text("arm", "the arm: which assumption is changed");
static CLAIM: Column = Column::text("CLAIM", "the verdict on a claim, one column per claim");

/// The files of a study's directory: its own, among those that every study has.
pub(super) fn contents(of_study: Vec<Entry>, sensitivity: bool) -> Vec<Entry> {
    let mut all = vec![
        Entry::file(REPORT, "the report: a verdict on each claim, with figures and tables"),
        Entry::file(format!("{}/", page::FIGURES), page::FIGURES_ABOUT),
        Entry::file(CLAIMS, "each claim with its verdict, its figures and its tests"),
        Entry::file(RESULTS, "the study's results, before they are judged"),
    ];
    all.extend(of_study);
    if sensitivity {
        let verdicts = "with `--sensitivity`: one row per arm";
        all.push(Entry::table(SENSITIVITY, verdicts, [&ARM, &CLAIM]));
        all.push(Entry::file(
            format!("{ARMS}/"),
            "with `--sensitivity`: the study's directory under each other arm",
        ));
    }
    all.extend([
        Entry::file(SETTINGS, "the arguments that the study was started with"),
        Entry::file("cohorts/", "finished runs, from which a stopped study continues"),
        Entry::file(disk::LOCK, "locked by the process that is writing"),
    ]);
    all
}

/// A study under one arm.
pub(super) trait Reproduction {
    /// Name of the study.
    const NAME: &'static str;

    /// Results of the study.
    type Found;

    /// Seed of everything random except the robots.
    fn seed(&self) -> u64;

    /// Record of the settings, kept in the directory to recognise the study again.
    fn record(&self) -> String;

    /// All values in force.
    fn assumptions(&self) -> Vec<Assumption>;

    /// Runs the study, except for results that the directory already has.
    fn run(&self, directory: &Directory, console: Console) -> Result<Self::Found>;

    fn judge(&self, found: &Self::Found) -> Vec<Claim>;

    /// The results as JSON.
    fn json(&self, found: &Self::Found) -> Result<Vec<u8>>;

    /// The files of its directory that other studies don't have.
    fn contents(&self) -> Vec<Entry>;

    /// Names and contents of the CSV files.
    fn csv(&self, found: &Self::Found) -> Vec<(&'static str, String)>;

    /// The report as HTML.
    fn html(&self, found: &Self::Found, claims: &[Claim], arms: Option<&Sensitivity>) -> String;
}

/// What the command line asks of any study.
pub struct Request<'a> {
    /// The study's file, instead of the compiled-in one.
    pub file: Option<&'a Path>,
    pub edition: Edition,
    pub arm: &'a str,
    /// Whether to repeat the study under every other arm.
    pub sensitivity: bool,
    /// The study's directory, instead of the usual one.
    pub out: Option<&'a Path>,
    /// The device that evaluates.
    pub backend: &'a Backend,
}

/// Runs or resumes a study, and returns its verdicts. `under` constructs the study from the name of an arm.
pub(super) fn reproduce<S: Reproduction>(
    request: &Request<'_>,
    file: &StudyFile,
    under: impl Fn(&str) -> Result<S>,
    console: Console,
) -> Result<Answer<Findings>> {
    let main = under(request.arm)?;
    let out = match request.out {
        Some(out) => out.to_owned(),
        None => usual(&main, console)?,
    };
    let (found, claims) = run_study(&main, &out, request.sensitivity, console)?;
    if request.sensitivity {
        let mut arms = Sensitivity {
            main: Assumed {
                arm: Arm::main(),
                claims: claims.clone(),
            },
            groups: Vec::new(),
        };
        for group in file.groups()? {
            let mut group_arms = Vec::new();
            for arm in group.arms {
                console.say(format!("arm {}", arm.name));
                let folder = disk::make_folder(&out, Path::new(ARMS).join(&arm.name))?;
                let (_, claims) = run_study(&under(&arm.name)?, &folder, false, console)?;
                group_arms.push(Assumed { arm, claims });
            }
            arms.groups.push((group.about, group_arms));
        }
        disk::write(&out.join(SENSITIVITY), sensitivity(&arms).as_bytes())?;
        write_report(&main, &out, &found, &claims, Some(&arms))?;
    }
    Ok(verdicts(claims, &out))
}

/// The directory of a study that nobody has named. It is taken, so that no other study gets it.
fn usual<S: Reproduction>(study: &S, console: Console) -> Result<PathBuf> {
    let name = PathBuf::from(format!("runs/{}-{}", S::NAME, study.seed()));
    let record = study.record();
    let look = |directory: &Path| match FORM.look(directory)? {
        Holds::Nothing => Ok(Found::Free),
        Holds::Other(file) => Ok(Found::Other(format!("holds other files, such as {file}"))),
        Holds::Mark if disk::read(&directory.join(SETTINGS))? == record.as_bytes() => Ok(Found::Own(())),
        Holds::Mark => Ok(Found::Other("holds the study with other arguments".into())),
    };
    let mut refused: Option<(PathBuf, Failure)> = None;
    loop {
        let named = directory::named(&name, look)?;
        if let Some((directory, failure)) = refused.take()
            && directory == named.directory
        {
            return Err(failure);
        }
        match Directory::open(&named.directory, study) {
            Ok(_) => {
                if let Some(why) = named.why {
                    console.say(why);
                }
                return Ok(named.directory);
            }
            // Another process has just taken it, and is about to write for which study.
            Err(failure) => {
                thread::sleep(Duration::from_millis(200));
                refused = Some((named.directory, failure));
            }
        }
    }
}

/// Runs one study in its directory and writes all of its files.
fn run_study<S: Reproduction>(
    study: &S,
    path: &Path,
    sensitivity: bool,
    console: Console,
) -> Result<(S::Found, Vec<Claim>)> {
    let directory = Directory::open(path, study)?;
    describe(path, "A study of oneiro", &contents(study.contents(), sensitivity))?;
    let found = study.run(&directory, console)?;
    let claims = study.judge(&found);
    disk::write(&path.join(RESULTS), &study.json(&found)?)?;
    let text = serde_json::to_vec_pretty(&claims).map_err(Failure::failed)?;
    disk::write(&path.join(CLAIMS), &text)?;
    for (name, csv) in study.csv(&found) {
        disk::write(&path.join(name), csv.as_bytes())?;
    }
    write_report(study, path, &found, &claims, None)?;
    Ok((found, claims))
}

fn write_report<S: Reproduction>(
    study: &S,
    path: &Path,
    found: &S::Found,
    claims: &[Claim],
    arms: Option<&Sensitivity>,
) -> Result {
    page::write(path, REPORT, &study.html(found, claims, arms)).map(drop)
}

/// Claims by assumption as CSV: one row per assumption, one column per claim.
fn sensitivity(arms: &Sensitivity) -> String {
    let ids = arms.main.claims.iter().map(|claim| claim.id.as_str());
    let claim = |id: &str| CLAIM.clone().named(id.to_owned());
    let columns: Vec<Column> = std::iter::once(ARM.clone()).chain(ids.map(claim)).collect();
    let mut table = Csv::new(&columns);
    for Assumed { arm, claims } in arms.all() {
        let verdicts = claims.iter().map(|claim| claim.verdict.to_string());
        table.row(std::iter::once(arm.name.clone()).chain(verdicts));
    }
    table.text()
}

/// A study's directory.
pub(super) struct Directory {
    path: PathBuf,
    /// Hash of everything that decides the contents of the directory.
    owner: blake3::Hash,
    _lock: File,
}

/// A study's directory.
const FORM: Form<'_> = Form {
    mark: SETTINGS,
    before: &[],
    option: "--out",
};

impl Directory {
    /// Creates the directory, or checks that an existing one belongs to this study.
    ///
    /// # Errors
    /// Exit 3 if it holds anything else, or if another process works on it; exit 6.
    pub(super) fn open(path: &Path, study: &impl Reproduction) -> Result<Self> {
        let busy = || {
            let path = path.display();
            Failure::input(format_args!(
                "{path}: another process is working on this study; allowed: one at a time"
            ))
        };
        let (lock, holds) = FORM.take(path, busy)?;
        let settings = path.join(SETTINGS);
        let text = study.record();
        if holds == Holds::Nothing {
            disk::write(&settings, text.as_bytes())?;
        } else if disk::read(&settings)? != text.as_bytes() {
            return Err(Failure::input(format_args!(
                "{}: is another study's; allowed: the arguments that it was begun with, or another --out",
                settings.display()
            )));
        }
        let decides = format!("{text}{:?}", study.assumptions());
        Ok(Self {
            path: path.to_owned(),
            owner: blake3::hash(decides.as_bytes()),
            _lock: lock,
        })
    }

    /// Path of a file or directory in it.
    pub(super) fn join(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// A folder in it, which is made.
    ///
    /// # Errors
    /// Exit 3 if a link or a file has its name, exit 6.
    pub(super) fn folder(&self, name: impl AsRef<Path>) -> Result<PathBuf> {
        disk::make_folder(&self.path, name)
    }

    /// Loads a file of the directory, or makes its contents and saves them there.
    pub(super) fn kept<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        make: impl FnOnce() -> Result<T>,
    ) -> Result<T> {
        const NAME: &str = "part of a study";
        /// Version 1 had means of ratios of paths.
        const VERSION: u32 = 2;
        let path = self.join(name);
        if let Some(bytes) = disk::read_if_there(&path)? {
            return sealed::open(NAME, VERSION, &self.owner, &bytes).map_err(|problem| match problem {
                Problem::Other(words) => Failure::input(format_args!(
                    "{}: {words}; allowed: finish the study with the program that began it, or begin again in another --out",
                    path.display()
                )),
                Problem::Damaged | Problem::Owner => {
                    Failure::corrupt(format_args!("{}: {problem}", path.display()))
                }
            });
        }
        let made = make()?;
        self.folder(Path::new(name).parent().unwrap_or(Path::new("")))?;
        disk::write(&path, &sealed::seal(NAME, VERSION, &self.owner, &made))?;
        Ok(made)
    }
}

/// Refuses a number of runs that is too small to have a spread, unless one is allowed, or too large.
pub(super) fn check_runs(runs: u32, allowed: &RangeInclusive<u32>) -> Result {
    if allowed.contains(&runs) {
        return Ok(());
    }
    let (least, most) = (allowed.start(), allowed.end());
    Err(Failure::input(format_args!(
        "--runs {runs}: a test of runs needs at least two; allowed: {least} to {most}"
    )))
}

/// The verdicts, which are also in the study's directory.
fn verdicts(claims: Vec<Claim>, directory: &Path) -> Answer<Findings> {
    let mut messages = vec![format!("wrote {}: {REPORT}, {CLAIMS}", directory.display())];
    let mut head = vec!["claim", "verdict"];
    let has_power = claims.iter().any(|claim| claim.power.is_some());
    if has_power {
        head.extend(["30 robots", "chance"]);
        let words = "30 robots: the verdict of 8 runs of each; chance: how often five runs of one robot give it";
        messages.push(words.to_owned());
    }
    head.push("reason");
    let row = |claim: &Claim| {
        let mut row = vec![claim.id.clone(), claim.verdict.to_string()];
        if has_power {
            row.extend(power(claim.power));
        }
        row.push(brief(&claim.reasons));
        row
    };
    let rows: Vec<Vec<String>> = claims.iter().map(row).collect();
    Answer {
        messages,
        ..Answer::new(wrapped(&head, &rows), Findings::Claims(claims))
    }
}
