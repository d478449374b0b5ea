//! A sweep's cells: how many of their runs are finished, and with what result.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use oneiro_base::exit::Result;
use oneiro_lab::sweep::Sweep;
use oneiro_lab::sweep::store::{AllFinished, Store};
use oneiro_report::numbers::significant;
use oneiro_report::page::{Cell, Head, table};
use oneiro_statistics::quantile;
use serde_json::{Value as Json, json};

/// How often journals are read.
const PAUSE: Duration = Duration::from_secs(2);
/// Rows of the table; cells beyond it are not shown.
const ROWS: usize = 200;

/// A sweep.
#[derive(Debug)]
pub(crate) struct Cells {
    store: Store,
    sweep: Sweep,
    /// The outcome that compares cells: column and meaning.
    by: (&'static str, &'static str),
    runs: usize,
    /// The outcomes of each cell's finished runs.
    outcomes: Vec<Vec<f64>>,
    done: usize,
    /// Size of all journals at the last look, and when that was.
    read: u64,
    looked: Option<Instant>,
    /// The first look and the runs finished by then, for the remaining time.
    first: Option<(Instant, usize)>,
    problem: Option<String>,
    version: u64,
}

impl Cells {
    pub(crate) fn open(directory: &Path) -> Result<Self> {
        let store = Store::open(directory)?;
        let (sweep, plan) = store.sweep()?;
        Ok(Self {
            outcomes: vec![Vec::new(); sweep.file().cells()],
            runs: sweep.runs(),
            by: plan.shown.by,
            done: 0,
            read: u64::MAX,
            looked: None,
            first: None,
            problem: None,
            version: 0,
            sweep,
            store,
        })
    }

    pub(crate) fn look(&mut self) {
        let is_due = self.looked.is_none_or(|at| at.elapsed() > PAUSE);
        if !is_due || self.is_done() {
            return;
        }
        self.looked = Some(Instant::now());
        let size = self.size();
        if size == self.read {
            return;
        }
        self.read = size;
        let mut finished = AllFinished::default();
        self.problem = self
            .store
            .finished(None, &mut finished)
            .err()
            .map(|failure| failure.to_string());
        let mut outcomes = vec![Vec::new(); self.outcomes.len()];
        for (run, own) in &finished.runs {
            let value = own.line.outcomes.get(self.by.0).and_then(|text| text.parse().ok());
            outcomes[self.sweep.cell_of(*run)].push(value.unwrap_or(f64::NAN));
        }
        self.outcomes = outcomes;
        self.done = finished.runs.len();
        self.first.get_or_insert((Instant::now(), self.done));
        self.version += 1;
    }

    /// Bytes of all journals.
    fn size(&self) -> u64 {
        let files = |folder: PathBuf| std::fs::read_dir(folder).into_iter().flatten().flatten();
        let journals = self.store.journals().unwrap_or_default();
        let all = journals.into_iter().flat_map(|(_, folder)| files(folder));
        all.filter_map(|file| Some(file.metadata().ok()?.len())).sum()
    }

    /// Remaining seconds at the pace so far, if runs were finished since the first look.
    fn left(&self) -> Option<f64> {
        let (since, then) = self.first?;
        let new = self.done.checked_sub(then).filter(|new| *new > 0)?;
        Some(since.elapsed().as_secs_f64() / new as f64 * (self.runs - self.done) as f64)
    }

    pub(crate) fn summary(&self) -> Json {
        json!({
            "name": self.store.what().name,
            "state": if self.is_done() { "done" } else { "unfinished" },
            "steps": self.done,
            "length": self.runs,
            "left": self.left(),
            "problem": self.problem,
            "version": self.version,
        })
    }

    pub(crate) fn is_done(&self) -> bool {
        self.done == self.runs
    }

    /// A table with a row for each cell.
    pub(crate) fn table(&self) -> String {
        let file = self.sweep.file();
        let seeds = file.seeds.len();
        let keys: Vec<&str> = file.keys().collect();
        let mut head: Vec<Head<'_>> = keys.iter().map(|key| Head::Text(key)).collect();
        head.extend([
            Head::Number("finished"),
            Head::Number("median"),
            Head::Number("quartiles"),
        ]);
        let row = |(cell, own): (usize, &Vec<f64>)| {
            let mut row: Vec<Cell> = self.sweep.levels(cell).iter().map(|level| Cell::name(level)).collect();
            row.push(Cell::number(format!("{} of {seeds}", own.len())));
            let numbers: Vec<f64> = own.iter().copied().filter(|own| own.is_finite()).collect();
            let quantile = |share| match &numbers[..] {
                [] => "\u{2013}".to_owned(),
                numbers => significant(quantile(numbers, share), 4),
            };
            row.push(Cell::number(quantile(0.5)));
            row.push(Cell::number(format!("{} to {}", quantile(0.25), quantile(0.75))));
            row.into()
        };
        let rows: Vec<_> = self.outcomes.iter().enumerate().take(ROWS).map(row).collect();
        let more = match self.outcomes.len().saturating_sub(ROWS) {
            0 => String::new(),
            more => format!(" {more} further cells are not shown."),
        };
        table("", &format!("Finished runs: {}.{more}", self.by.1), &head, &rows)
    }
}
