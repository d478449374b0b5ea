//! The directories that are watched, and what is known of each.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime};

use oneiro_base::exit::Result;
use oneiro_lab::experiment::Difference;
use oneiro_lab::experiment::kinds::{begun, is_run, is_sweep};
use oneiro_lab::record::{SavedRun, State};
use oneiro_lab::runs::Recording;
use serde_json::{Value as Json, json};

use crate::curve::{Curve, Value};
use crate::sweeps::Cells;

/// Shown directories, the newest.
const MOST: usize = 500;
/// Named keys where settings differ.
const DIFFERENCES: usize = 2;
/// How often the lock of a run that doesn't grow is tried, and a directory that can't be read is read again.
const PATIENCE: Duration = Duration::from_secs(2);
/// The page of a fleet and its script.
pub(crate) const LIVE_SCRIPT: &str = "live.js";
pub(crate) const LIVE_PAGE: &str = "live.html";
pub(crate) const FLEET: [&str; 2] = [LIVE_PAGE, LIVE_SCRIPT];

/// A directory of a run, a sweep or a fleet.
#[derive(Debug)]
pub(crate) struct Source {
    /// By which the page calls it.
    pub(crate) id: String,
    pub(crate) directory: PathBuf,
    pub(crate) kind: Kind,
}

#[derive(Debug)]
pub(crate) enum Kind {
    Run(Box<Run>),
    Sweep(Box<Cells>),
    Fleet,
    /// The problem, and when it was found.
    Unreadable(String, Instant),
}

/// A run.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) saved: Arc<SavedRun>,
    /// Runs of one experiment have the same.
    pub(crate) group: String,
    pub(crate) curve: Curve,
    pub(crate) state: State,
    /// When it last grew, and when its state was last looked at.
    grown: Option<Instant>,
    looked: Option<Instant>,
    /// Whether it was running at some look.
    was_running: bool,
    /// Counts its changes.
    version: u64,
}

impl Run {
    fn open(directory: &Path) -> Result<Self> {
        const BEST: [Value; 3] = [
            Value {
                column: "best",
                label: "best",
                is_maximum: true,
            },
            Value {
                column: "peak",
                label: "mean of parents",
                is_maximum: false,
            },
            Value {
                column: "mean",
                label: "mean",
                is_maximum: false,
            },
        ];
        let saved = SavedRun::open(directory)?;
        let experiment = saved.experiment();
        let shown = experiment.shown();
        let file = experiment.tables(Recording::Tables)[0].file;
        let values = if experiment.columns().iter().any(|column| column.name == BEST[0].column) {
            BEST.to_vec()
        } else {
            vec![Value {
                column: shown.value.0,
                label: shown.value.1,
                is_maximum: false,
            }]
        };
        Ok(Self {
            group: experiment.identities().of(0).to_hex()[..16].to_owned(),
            curve: Curve::new(directory, file, shown.time.0, values),
            state: State::Running,
            grown: None,
            looked: None,
            was_running: false,
            version: 0,
            saved: Arc::new(saved),
        })
    }

    /// Looks at what has changed. A finished run is left alone.
    fn look(&mut self) {
        if self.state == State::Done {
            return;
        }
        let now = Instant::now();
        if self.looked.is_none() {
            // What is there at the first look may be old.
            while self.curve.update() {}
            self.version += 1;
        } else if self.curve.update() {
            self.grown = Some(now);
            self.version += 1;
        }
        // A run that grows has a process; to try its lock could be in the way of another one that begins.
        let is_still = self.grown.is_none_or(|at| now - at > PATIENCE);
        let is_due = self.looked.is_none_or(|at| now - at > PATIENCE);
        let is_done = self.saved.recorded().is_ok_and(|run| run.is_done);
        let state = match (is_done, is_still, is_due) {
            (true, ..) => State::Done,
            (false, false, _) => State::Running,
            (false, true, false) => return,
            (false, true, true) => {
                self.looked = Some(now);
                self.saved.state(false)
            }
        };
        if state != self.state {
            self.state = state;
            self.version += 1;
        }
        if state == State::Done {
            while self.curve.update() {}
        }
        self.was_running |= state == State::Running;
    }

    fn summary(&self, label: Option<&str>) -> Json {
        let state = match self.state {
            State::Done => "done",
            State::Running => "running",
            State::Stopped => "stopped",
            State::Interrupted => "interrupted",
        };
        json!({
            "name": self.saved.experiment().name(),
            "seed": self.saved.seed().to_string(),
            "label": label,
            "state": state,
            "steps": self.curve.steps().min(self.saved.experiment().length()),
            "length": self.saved.experiment().length(),
            "best": self.curve.best().filter(|best| best.is_finite()),
            "version": self.version,
        })
    }
}

/// All that is watched.
#[derive(Debug)]
pub(crate) struct Sources {
    folders: Vec<PathBuf>,
    all: BTreeMap<PathBuf, Source>,
    /// Directories in the order in which they are shown, the newest first, and the number of others.
    shown: Vec<PathBuf>,
    more: usize,
    /// By the group of a run: the group of the oldest of the same name, and what differs from it, in words.
    labels: BTreeMap<String, (String, String)>,
}

impl Sources {
    /// The folders are directories of runs, sweeps or fleets, or hold some.
    pub(crate) fn new(folders: Vec<PathBuf>) -> Self {
        Self {
            folders,
            all: BTreeMap::new(),
            shown: Vec::new(),
            more: 0,
            labels: BTreeMap::new(),
        }
    }

    /// Looks at all directories.
    pub(crate) fn look(&mut self) {
        let mut found = BTreeSet::new();
        for folder in &self.folders {
            if kind(folder) {
                found.insert(folder.clone());
                continue;
            }
            let entries = fs::read_dir(folder).into_iter().flatten().flatten();
            found.extend(entries.map(|entry| entry.path()).filter(|path| kind(path)));
        }
        let mut newest: Vec<(SystemTime, PathBuf)> = found
            .into_iter()
            .map(|path| (begun(&path).unwrap_or(SystemTime::UNIX_EPOCH), path))
            .collect();
        newest.sort_by(|a, b| b.cmp(a));
        self.more = newest.len().saturating_sub(MOST);
        self.shown = newest.into_iter().take(MOST).map(|(_, path)| path).collect();
        self.all.retain(|path, _| self.shown.contains(path));
        for path in &self.shown {
            let source = self.all.entry(path.clone()).or_insert_with(|| Source::open(path));
            source.look();
        }
        self.label();
    }

    /// Names what differs between runs of the same name.
    fn label(&mut self) {
        // By name, the oldest run, and whether others have other settings.
        let mut names: BTreeMap<&str, (&Run, bool)> = BTreeMap::new();
        for run in self.runs().rev() {
            let (oldest, differs) = names.entry(run.saved.experiment().name()).or_insert((run, false));
            *differs |= run.group != oldest.group;
        }
        let mut labels = BTreeMap::new();
        for run in self.runs() {
            let (oldest, differs) = names[run.saved.experiment().name()];
            if differs && !labels.contains_key(&run.group) {
                let known = self.labels.get(&run.group).filter(|(of, _)| *of == oldest.group);
                let text = known.map_or_else(|| label(oldest, run), |(_, text)| text.clone());
                labels.insert(run.group.clone(), (oldest.group.clone(), text));
            }
        }
        self.labels = labels;
    }

    /// All runs, the newest first.
    fn runs(&self) -> impl DoubleEndedIterator<Item = &Run> {
        let all = self.shown.iter().filter_map(|path| self.all.get(path));
        all.filter_map(|source| match &source.kind {
            Kind::Run(run) => Some(&**run),
            _ => None,
        })
    }

    /// What differs in a run from the oldest one of the same name; none where all have the same settings.
    fn label_of(&self, run: &Run) -> Option<&str> {
        self.labels.get(&run.group).map(|(_, text)| text.as_str())
    }

    pub(crate) fn find(&self, id: &str) -> Option<&Source> {
        self.all.values().find(|source| source.id == id)
    }

    /// Whether each folder is a finished run or sweep, or a run that was running and has stopped.
    pub(crate) fn have_ended(&self) -> bool {
        let has_ended = |folder| match self.all.get(folder).map(|source| &source.kind) {
            Some(Kind::Run(run)) => run.state == State::Done || run.was_running && run.state != State::Running,
            Some(Kind::Sweep(cells)) => cells.is_done(),
            _ => false,
        };
        self.folders.iter().all(has_ended)
    }

    pub(crate) fn sweeps(&self) -> impl Iterator<Item = &Cells> {
        let all = self.shown.iter().filter_map(|path| self.all.get(path));
        all.filter_map(|source| match &source.kind {
            Kind::Sweep(cells) => Some(&**cells),
            _ => None,
        })
    }

    /// The newest run, and by what the page calls it.
    pub(crate) fn newest_run(&self) -> Option<(&str, &Run)> {
        let all = self.shown.iter().filter_map(|path| self.all.get(path));
        let mut runs = all.filter_map(|source| match &source.kind {
            Kind::Run(run) => Some((&*source.id, &**run)),
            _ => None,
        });
        runs.next()
    }

    /// Runs of the same experiment as this one, by their seeds.
    pub(crate) fn group(&self, group: &str) -> Vec<&Run> {
        let mut runs: Vec<&Run> = self
            .all
            .values()
            .filter_map(|source| match &source.kind {
                Kind::Run(run) if run.group == group => Some(&**run),
                _ => None,
            })
            .collect();
        runs.sort_by_key(|run| run.saved.seed());
        runs
    }

    /// Runs of the same name by their settings, the newest first and the given run's first of all: each group with what differs from the
    /// oldest one's settings, in words.
    pub(crate) fn groups(&self, own: &Run) -> Vec<(String, Vec<&Run>)> {
        let name = own.saved.experiment().name();
        let mut firsts: Vec<&Run> = Vec::new();
        for run in self.runs() {
            let is_new = firsts.iter().all(|first| first.group != run.group);
            if is_new && run.saved.experiment().name() == name {
                firsts.push(run);
            }
        }
        let label = |run: &Run| self.label_of(run).unwrap_or("as first").to_owned();
        firsts.sort_by_key(|run| run.group != own.group);
        firsts
            .into_iter()
            .map(|run| (label(run), self.group(&run.group)))
            .collect()
    }

    /// All in brief, for the page's list.
    pub(crate) fn summary(&self) -> Json {
        let entry = |path: &PathBuf| {
            let source = self.all.get(path)?;
            let (kind, mut own) = match &source.kind {
                Kind::Run(run) => ("run", run.summary(self.label_of(run))),
                Kind::Sweep(cells) => ("sweep", cells.summary()),
                Kind::Fleet => ("fleet", json!({})),
                Kind::Unreadable(problem, _) => ("unreadable", json!({ "problem": problem })),
            };
            own["id"] = source.id.clone().into();
            own["kind"] = kind.into();
            own["directory"] = path.display().to_string().into();
            Some(own)
        };
        let all: Vec<Json> = self.shown.iter().filter_map(entry).collect();
        json!({ "sources": all, "more": self.more })
    }
}

/// What differs in a run from another, in words.
fn label(oldest: &Run, run: &Run) -> String {
    let [oldest, own] = [oldest, run].map(|run| run.saved.experiment().resolved_toml(0));
    let all = Difference::of_runs(&oldest, &own);
    let words = all.iter().map(|own| format!("{} {}", own.key, own.values[1]));
    let words: Vec<String> = words.take(DIFFERENCES).collect();
    match all.len() {
        0 => "as first".to_owned(),
        count if count > DIFFERENCES => format!("{}, ..", words.join(", ")),
        _ => words.join(", "),
    }
}

/// Whether a directory is a run's, a sweep's or a fleet's.
fn kind(path: &Path) -> bool {
    is_run(path) || is_sweep(path) || is_fleet(path)
}

fn is_fleet(path: &Path) -> bool {
    FLEET.iter().all(|name| path.join(name).is_file())
}

impl Source {
    fn open(path: &Path) -> Self {
        let kind = if is_run(path) {
            Run::open(path).map(|run| Kind::Run(Box::new(run)))
        } else if is_sweep(path) {
            Cells::open(path).map(|cells| Kind::Sweep(Box::new(cells)))
        } else {
            Ok(Kind::Fleet)
        };
        Self {
            id: blake3::hash(path.as_os_str().as_encoded_bytes()).to_hex()[..12].to_owned(),
            directory: path.to_owned(),
            kind: kind.unwrap_or_else(|failure| Kind::Unreadable(failure.to_string(), Instant::now())),
        }
    }

    fn look(&mut self) {
        match &mut self.kind {
            Kind::Run(run) => run.look(),
            Kind::Sweep(cells) => cells.look(),
            Kind::Unreadable(_, since) if since.elapsed() > PATIENCE => *self = Self::open(&self.directory),
            Kind::Fleet | Kind::Unreadable(..) => {}
        }
    }
}
