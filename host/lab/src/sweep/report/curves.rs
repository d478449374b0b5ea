//! Means over runs at each time, from the table of generations, which is read row by row.

use std::collections::{BTreeMap, BTreeSet};

use oneiro_base::exit::Result;
use oneiro_report::figures::Spread;

use super::Tables;
use super::runs::Runs;
use super::sample::{Critical, Moments};
use super::table::Table;

/// Maximum number of a line's values; more couldn't be distinguished.
const MOST_POINTS: usize = 300;

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

/// A run's best score at shared times up to its budget, from its first generation on. `best` has the best score of each generation, which
/// have equal numbers of episodes.
pub(crate) fn best_at(best: &[f64], end: u64, times: &BTreeSet<u64>) -> Vec<(u64, f64)> {
    let generations = best.len() as u64;
    let mut all = best.iter().copied();
    let (mut done, mut best) = (0, f64::NAN);
    let mut values = Vec::new();
    for &time in times.range(..=end) {
        // A generation is over when its part of all episodes is spent.
        while done < generations && u128::from(end) * u128::from(done + 1) <= u128::from(time) * u128::from(generations)
        {
            best = all.next().map_or(best, |score| best.max(score));
            done += 1;
        }
        if done > 0 {
            values.push((time, best));
        }
    }
    values
}

/// A line: times with the mean and its interval at each.
pub(super) type Line = Vec<(f64, Spread)>;

/// Means over runs by time.
pub(super) struct Curves {
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
    all: Vec<Moments>,
    /// By factor and group.
    groups: Vec<Vec<Vec<Moments>>>,
}

/// One run at one time: the values of its robots become one.
struct Moment {
    run: usize,
    time: u64,
    sum: f64,
    count: u32,
}

impl Curves {
    /// Reads the table. Several rows of one run and time, such as those of robots, count as their mean; values that
    /// aren't numbers are left out.
    ///
    /// # Errors
    /// Exit 3 if there is no table. Exit 5 with the line that is invalid, belongs to no run, or isn't in order of time
    /// within its run. Exit 6 if reading fails.
    pub(super) fn read(tables: &Tables<'_>, runs: &Runs) -> Result<Self> {
        let mut table = Table::open(tables.generations)?;
        let number = table.column("run")?;
        let (time, value) = (table.column(tables.time.0)?, table.column(tables.value.0)?);
        let mut sums = Sums::new(runs);
        let mut times = Times::default();
        let mut seen = vec![false; runs.all.len()];
        let mut now: Option<Moment> = None;
        let shared = shared_times(tables.spent.unwrap_or_default().iter().copied());
        // The best value of each generation of a run, if lines are by episodes.
        let mut best = Vec::new();
        let mut add = |moment: Moment, is_last: bool| {
            let run = moment.run;
            let Some(ends) = tables.spent else {
                return sums.add(runs, &moment, times.place(moment.time));
            };
            best.push(moment.sum / f64::from(moment.count));
            if is_last {
                let end = ends.get(runs.all[run].number as usize).copied().unwrap_or(0);
                for (time, sum) in best_at(&std::mem::take(&mut best), end, &shared) {
                    let count = 1;
                    sums.add(runs, &Moment { run, time, sum, count }, times.place(time));
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
                sum: 0.0,
                count: 0,
            });
            let value = table.number(value)?;
            if value.is_finite() {
                moment.sum += value;
                moment.count += 1;
            }
        }
        if let Some(moment) = now {
            add(moment, true);
        }
        Ok(sums.curves(&times))
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
            all: Vec::new(),
            groups: groups.collect(),
        }
    }

    fn add(&mut self, runs: &Runs, moment: &Moment, time: usize) {
        let value = moment.sum / f64::from(moment.count);
        let run = &runs.all[moment.run];
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

    fn curves(&self, times: &Times) -> Curves {
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
