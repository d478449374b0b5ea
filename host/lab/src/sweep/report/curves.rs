//! Means over runs at each time, from the table of generations, which is read row by row.

use std::collections::{BTreeMap, BTreeSet};

use oneiro_base::exit::Result;
use oneiro_report::figures::Spread;
use oneiro_report::figures::plot::EPISODES;

use super::Tables;
use super::runs::Runs;
use super::sample::{Critical, Moments};
use super::table::Table;

/// Maximum number of a line's values; more couldn't be distinguished.
const MOST_POINTS: usize = 300;

/// Column of the best score of a generation, and the name of an axis of the best so far.
const BEST: (&str, &str) = ("best", "best score so far");

/// Number of times on an axis of episodes.
const TIMES: u64 = 200;

/// Times on an axis of episodes that all runs share, so that means can be taken over runs; `ends` are the runs' budgets.
pub(crate) fn shared_times(ends: impl Iterator<Item = u64> + Clone) -> BTreeSet<u64> {
    let most = ends.clone().max().unwrap_or(0);
    (1..=TIMES)
        .map(|time| (most * time).div_ceil(TIMES))
        .chain(ends)
        .collect()
}

/// Episodes spent after each of so many generations, as if these had equal parts of a budget.
pub(crate) fn in_equal_parts(budget: u64, generations: usize) -> Vec<u64> {
    let generations = generations as u128;
    let after = |done: u128| (u128::from(budget) * done).div_ceil(generations) as u64;
    (1..=generations).map(after).collect()
}

/// A run's best score at shared times up to its budget, from its first generation on. `best` has the best score of each generation, and
/// `spent` the episodes after it.
pub(crate) fn best_at(best: &[f64], spent: &[u64], end: u64, times: &BTreeSet<u64>) -> Vec<(u64, f64)> {
    let mut all = spent.iter().zip(best).peekable();
    let mut best = None;
    let mut values = Vec::new();
    for &time in times.range(..=end) {
        while let Some((_, score)) = all.next_if(|(spent, _)| **spent <= time) {
            best = Some(best.map_or(*score, |best: f64| best.max(*score)));
        }
        values.extend(best.map(|best| (time, best)));
    }
    values
}

/// A line: times with the mean and its interval at each.
pub(super) type Line = Vec<(f64, Spread)>;

/// Means over runs by time.
pub(super) struct Curves {
    /// Names of the axes.
    pub(super) across: String,
    pub(super) up: String,
    /// Mean of all runs.
    pub(super) all: Line,
    /// Means of each factor's groups of levels.
    pub(super) groups: Vec<Vec<Line>>,
    /// Most and fewest runs behind a mean of all runs.
    pub(super) runs: (u32, u32),
    /// Every `stride`th time is drawn.
    pub(super) stride: usize,
}

/// Sums, indexed by times in the order of their first occurrence.
struct Sums {
    times: Times,
    all: Vec<Moments>,
    /// By factor and group.
    groups: Vec<Vec<Vec<Moments>>>,
}

/// One run at one time: the mean of its robots' values, and of their best scores.
struct Moment {
    run: usize,
    time: u64,
    value: Mean,
    best: Mean,
}

#[derive(Default)]
struct Mean {
    sum: f64,
    count: u32,
}

impl Mean {
    fn add(&mut self, value: f64) {
        if value.is_finite() {
            self.sum += value;
            self.count += 1;
        }
    }

    fn value(&self) -> f64 {
        self.sum / f64::from(self.count)
    }
}

impl Curves {
    /// Reads the table: curves by its times, and by episodes spent if those are known, in the order in which they are shown. Several rows of one run and time, such as those of robots, count as their mean; values that
    /// aren't numbers are left out.
    ///
    /// # Errors
    /// Exit 3 if there is no table. Exit 5 with the line that is invalid, belongs to no run, or isn't in order of time
    /// within its run. Exit 6 if reading fails.
    pub(super) fn read(tables: &Tables<'_>, runs: &Runs) -> Result<Vec<Self>> {
        let mut table = Table::open(tables.generations)?;
        let number = table.column("run")?;
        let (time, value) = (table.column(tables.time.0)?, table.column(tables.value.0)?);
        let score = tables.spent.as_ref().map(|_| table.column(BEST.0)).transpose()?;
        let [mut by_time, mut by_episodes] = [Sums::new(runs), Sums::new(runs)];
        let mut seen = vec![false; runs.all.len()];
        let mut now: Option<Moment> = None;
        let ends = tables.spent.as_ref().map_or(&[][..], |spent| spent.ends);
        let shared = shared_times(ends.iter().copied());
        // The best score of each generation of a run.
        let mut best = Vec::new();
        let mut add = |moment: Moment, is_last: bool| {
            let run = moment.run;
            by_time.add(runs, run, moment.time, moment.value.value());
            best.push(moment.best.value());
            if is_last {
                let end = ends.get(runs.all[run].number as usize).copied().unwrap_or(0);
                let best = std::mem::take(&mut best);
                let spent = in_equal_parts(end, best.len());
                for (time, best) in best_at(&best, &spent, end, &shared) {
                    by_episodes.add(runs, run, time, best);
                }
            }
        };
        while table.advance()? {
            let (number, at) = (table.whole(number)?, table.whole(time)?);
            let run = match &now {
                Some(now) if runs.all[now.run].number == number => now.run,
                _ => {
                    let run = runs.place(number);
                    let run = run.ok_or_else(|| {
                        table.corrupt(format_args!("run {number} is not in {}", tables.results.display()))
                    })?;
                    if std::mem::replace(&mut seen[run], true) {
                        return Err(table.corrupt(format_args!("run {number} has rows in two places")));
                    }
                    run
                }
            };
            match &now {
                Some(now) if now.run == run && now.time == at => {}
                Some(before) if before.run == run && before.time > at => {
                    return Err(table.corrupt(format_args!(
                        "{} {at} of run {number} comes after {}",
                        tables.time.0, before.time
                    )));
                }
                _ => {
                    if let Some(moment) = now.take() {
                        let is_last = moment.run != run;
                        add(moment, is_last);
                    }
                }
            }
            let moment = now.get_or_insert(Moment {
                run,
                time: at,
                value: Mean::default(),
                best: Mean::default(),
            });
            moment.value.add(table.number(value)?);
            if let Some(score) = score {
                moment.best.add(table.number(score)?);
            }
        }
        if let Some(moment) = now {
            add(moment, true);
        }
        let mut all = vec![by_time.curves(tables.time.1, tables.value.1)];
        if let Some(spent) = &tables.spent {
            let by_episodes = by_episodes.curves(EPISODES, BEST.1);
            all.insert(usize::from(!spent.is_first), by_episodes);
        }
        Ok(all)
    }

    /// First and last time.
    pub(super) fn ends(&self) -> (f64, f64) {
        let ends = self.all.first().zip(self.all.last());
        ends.map_or((0.0, 1.0), |((first, _), (last, _))| (*first, *last))
    }
}

/// Times that occur in the table.
#[derive(Default)]
struct Times {
    /// In the order of their first occurrence.
    all: Vec<u64>,
    places: BTreeMap<u64, usize>,
    /// Index found last.
    last: usize,
}

impl Times {
    fn place(&mut self, time: u64) -> usize {
        // Usually the time after that of the previous row.
        let next = self.last + 1;
        self.last = if self.all.get(next) == Some(&time) {
            next
        } else {
            let all = &mut self.all;
            *self.places.entry(time).or_insert_with(|| {
                all.push(time);
                all.len() - 1
            })
        };
        self.last
    }
}

impl Sums {
    fn new(runs: &Runs) -> Self {
        let groups = runs.factors.iter().map(|factor| vec![Vec::new(); factor.groups.len()]);
        Self {
            times: Times::default(),
            all: Vec::new(),
            groups: groups.collect(),
        }
    }

    fn add(&mut self, runs: &Runs, run: usize, time: u64, value: f64) {
        let time = self.times.place(time);
        let run = &runs.all[run];
        let groups = self.groups.iter_mut().enumerate();
        let own = groups.map(|(factor, groups)| &mut groups[runs.group(run, factor)]);
        for line in std::iter::once(&mut self.all).chain(own) {
            if line.len() <= time {
                line.resize(time + 1, Moments::default());
            }
            if value.is_finite() {
                line[time].add(value);
            }
        }
    }

    fn curves(&self, across: &str, up: &str) -> Curves {
        let times = &self.times;
        let stride = times.all.len().div_ceil(MOST_POINTS).max(1);
        let last = times.all.len().saturating_sub(1);
        let drawn = times.places.iter().enumerate();
        // The last time is included: it shows the final values.
        let drawn = drawn.filter(|(i, _)| i.is_multiple_of(stride) || *i == last);
        let drawn: Vec<(f64, usize)> = drawn.map(|(_, (&time, &place))| (time as f64, place)).collect();
        let mut critical = Critical::default();
        let mut line = |moments: &Vec<Moments>| -> Line {
            let spread = |place: usize| moments.get(place).copied().unwrap_or_default();
            drawn
                .iter()
                .map(|&(time, place)| (time, spread(place).spread(&mut critical)))
                .collect()
        };
        let counts = || self.all.iter().map(|moments| moments.count);
        Curves {
            across: across.to_owned(),
            up: up.to_owned(),
            all: line(&self.all),
            groups: self
                .groups
                .iter()
                .map(|groups| groups.iter().map(&mut line).collect())
                .collect(),
            runs: (counts().max().unwrap_or(0), counts().min().unwrap_or(0)),
            stride,
        }
    }
}
