//! Estimates the duration of runs on each device of this machine by timing short batches of their episodes.

use std::time::{Duration, Instant};

use oneiro::backend::Options;
use oneiro::batch::{Batch, Rollout, Worlds};
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::Key;
use oneiro_base::console::Bars;
use oneiro_base::exit::Result;
use oneiro_base::progress::meanwhile;
use serde::Serialize;

use super::{Plan, Sweep};
use crate::device::{self, Backend};
use crate::runs::{Experiment, Work};

/// A device and its speed.
#[derive(Clone, Debug, Serialize)]
pub struct Estimate {
    /// Name for `--backend`, with a description.
    pub name: String,
    /// Duration of all runs in seconds.
    pub seconds: f64,
    pub steps_per_second: f64,
    /// Duration of each cell's runs in seconds.
    pub cells: Vec<f64>,
}

/// Episodes to time, and what they stand for.
#[derive(Debug)]
pub struct Timed {
    worlds: Worlds,
    /// Maximum number of episodes that a device gets at a time.
    lives: usize,
    /// Robot-steps of a run of each cell that these episodes stand for, with the cell and its number of runs.
    cells: Vec<(usize, u64, u64)>,
}

impl Timed {
    /// Some runs of an experiment, at the same time: in its simulator, and in what stands for reality.
    ///
    /// # Errors
    /// Errors of packing its worlds.
    pub fn of(experiment: &dyn Experiment, runs: u64) -> Result<Vec<Self>> {
        let timed = |work: Work| Self {
            worlds: work.worlds,
            lives: work.at_a_time.saturating_mul(runs).min(MOST as u64) as usize,
            cells: vec![(0, work.steps, runs)],
        };
        Ok(experiment.work()?.into_iter().map(timed).collect())
    }

    /// The cells of a sweep, of which some are timed: the first with each kernel, and others at equal distances. Each of the rest is
    /// taken to be as fast as the nearest with its kernel, and to have as large a share in reality.
    ///
    /// # Errors
    /// Exit 3 if a cell is invalid.
    pub fn of_sweep(sweep: &Sweep, plan: &Plan) -> Result<Vec<Self>> {
        /// Cells that are timed.
        const TIMED: usize = 12;
        let cells = plan.steps.len();
        let mut timed: Vec<usize> = Vec::new();
        for cell in 0..cells {
            let is_known = timed.iter().any(|&own| plan.kernels[own] == plan.kernels[cell]);
            if !is_known && timed.len() < TIMED {
                timed.push(cell);
            }
        }
        let step = cells.div_ceil(TIMED);
        let others: Vec<usize> = (0..cells).step_by(step).filter(|cell| !timed.contains(cell)).collect();
        timed.extend(others.into_iter().take(TIMED - timed.len()));
        timed.sort_unstable();
        let runs = sweep.file().seeds.len() as u64;
        let mut all = timed
            .iter()
            .map(|&cell| Self::of(&*sweep.cell(cell)?, sweep.runs() as u64))
            .collect::<Result<Vec<_>>>()?;
        // The fraction of each work in the planned steps of its cell.
        let shares: Vec<Vec<f64>> = timed
            .iter()
            .zip(&all)
            .map(|(&cell, works)| {
                let all = plan.steps[cell].max(1) as f64;
                works.iter().map(|work| work.cells[0].1 as f64 / all).collect()
            })
            .collect();
        for work in all.iter_mut().flatten() {
            work.cells.clear();
        }
        for cell in 0..cells {
            let distance = |&(_, own): &(usize, usize)| (plan.kernels[own] != plan.kernels[cell], own.abs_diff(cell));
            let nearest = timed.iter().copied().enumerate().min_by_key(distance);
            let (nearest, _) = nearest.expect("a sweep has a cell");
            for (work, share) in all[nearest].iter_mut().zip(&shares[nearest]) {
                work.cells.push((cell, (plan.steps[cell] as f64 * share) as u64, runs));
            }
        }
        Ok(all.into_iter().flatten().collect())
    }
}

/// The estimate of the fastest device.
pub fn fastest(estimates: &[Estimate]) -> Option<&Estimate> {
    estimates.iter().min_by(|a, b| a.seconds.total_cmp(&b.seconds))
}

/// Devices by their names for `--backend`.
#[derive(Clone, Copy, Debug)]
pub enum Devices<'a> {
    /// One, which has to be there.
    Named(&'a str),
    Cpu,
    /// Exact GPUs that can be opened.
    Gpus,
}

/// Estimates for devices, with this many threads of the CPU or one for each processor.
///
/// # Errors
/// Exit 4 if a named device can't be opened.
pub fn estimates(all: &[Timed], devices: &[Devices<'_>], threads: Option<u16>, bars: Bars) -> Result<Vec<Estimate>> {
    let names = devices.iter().flat_map(|devices| match devices {
        Devices::Named(name) => vec![(*name).to_owned()],
        Devices::Cpu => vec!["cpu".to_owned()],
        Devices::Gpus => device::gpus_here()
            .into_iter()
            .map(|index| format!("gpu:{index}"))
            .collect(),
    });
    let is_needed = devices.iter().any(|devices| matches!(devices, Devices::Named(_)));
    let of_works = all.iter().flat_map(|work| &work.cells);
    let cells = of_works.map(|&(cell, ..)| cell + 1).max().unwrap_or(0);
    let mut found = Vec::new();
    for name in names {
        let backend = Backend {
            name: name.clone(),
            options: Options {
                threads: threads.map(usize::from),
                ..Options::default()
            },
        };
        let mut evaluator = match device::open(&backend) {
            Ok(evaluator) => evaluator,
            Err(failure) if is_needed => return Err(failure),
            // A device that can't be opened can't do the runs.
            Err(_) => continue,
        };
        let budget = WHOLE / all.len().max(1) as u32;
        let rates: Option<Vec<f64>> = meanwhile(&format!("timing {name}"), bars, || {
            all.iter().map(|work| rate(evaluator.as_mut(), work, budget)).collect()
        });
        let Some(rates) = rates else { continue };
        let mut estimate = Estimate {
            name: format!("{name}, {}", device::name(evaluator.as_ref())),
            seconds: 0.0,
            steps_per_second: 0.0,
            cells: vec![0.0; cells],
        };
        let mut steps = 0.0;
        for (work, rate) in all.iter().zip(rates) {
            for &(cell, of_run, runs) in &work.cells {
                let own = of_run as f64 * runs as f64;
                estimate.cells[cell] += own / rate;
                estimate.seconds += own / rate;
                steps += own;
            }
        }
        estimate.steps_per_second = steps / estimate.seconds;
        found.push(estimate);
    }
    Ok(found)
}

/// Time of all batches of a device, without preparation.
const WHOLE: Duration = Duration::from_millis(400);
/// Episodes that are timed at most.
const MOST: usize = 1 << 18;

/// Robot-steps per second. Batches grow until one takes long enough to be timed: first in cycles, then in episodes.
fn rate(evaluator: &mut dyn Evaluator, work: &Timed, budget: Duration) -> Option<f64> {
    const LONG: Duration = Duration::from_millis(40);
    let Timed {
        worlds, lives: most, ..
    } = work;
    let genes = vec![0.25; worlds.genes()[0]];
    let batch = |lives: usize, cycles: u32| {
        let rollouts: Vec<Rollout<'_>> = (0..lives as u64)
            .map(|individual| Rollout {
                world: 0,
                genes: &genes,
                key: Key::rollout(0, 0, individual, 0),
            })
            .collect();
        worlds.stretch(&rollouts, 0..cycles, &[], None).ok()
    };
    let mut timed = |batch: &Batch| {
        let began = Instant::now();
        evaluator.evaluate(batch, &Control::new()).ok()?;
        Some(began.elapsed())
    };
    let whole = worlds
        .batch(
            &[Rollout {
                world: 0,
                genes: &genes,
                key: Key::rollout(0, 0, 0, 0),
            }],
            None,
        )
        .ok()?;
    let whole = whole.cycles().end;
    let (mut lives, mut cycles) = (256.min(*most), 8.min(whole));
    // The first batch includes one-time preparation.
    timed(&batch(lives, cycles)?)?;
    let began = Instant::now();
    loop {
        let batch = batch(lives, cycles)?;
        let took = timed(&batch)?;
        let is_all = cycles == whole && lives == *most;
        if took >= LONG.min(budget / 2) || is_all || began.elapsed() >= budget {
            return Some(batch.steps() as f64 / took.as_secs_f64());
        }
        if cycles < whole {
            cycles = cycles.saturating_mul(8).min(whole);
        } else {
            lives = lives.saturating_mul(4).min(*most);
        }
    }
}

impl Plan {
    /// The cells with the fewest and with the most episodes a run, if comparing cells compares budgets.
    pub fn unequal_budgets(&self) -> Option<[(usize, u64); 2]> {
        /// What two numbers of whole generations may differ by.
        const TOLERANCE: f64 = 0.01;
        let all = || {
            self.episodes
                .iter()
                .copied()
                .enumerate()
                .filter_map(|(cell, own)| Some((cell, own?)))
        };
        let least = all().min_by_key(|(_, episodes)| *episodes)?;
        let most = all().rev().max_by_key(|(_, episodes)| *episodes)?;
        ((most.1 - least.1) as f64 > TOLERANCE * most.1 as f64).then_some([least, most])
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// Kernel and robot-steps of a run of a sweep's first cell, by the worlds that they are done in.
    fn works(path: &str) -> (u64, Vec<(&'static str, u64)>) {
        let cell = Sweep::read(Path::new(path)).unwrap().cell(0).unwrap();
        let works = cell.work().unwrap();
        let work = |work: &Work| (work.worlds.kernel().name, work.steps);
        (cell.steps(), works.iter().map(work).collect())
    }

    /// A surrogate is slower than the simulator, and is timed separately.
    #[test]
    fn reality_is_timed_separately() {
        // Of 220 generations of 100 individuals with an episode of 500 cycles each, the last twenty are in reality.
        let (all, works) = works("../../studies/miglino1995/plastic/severity-1.toml");
        let steps: Vec<u64> = works.iter().map(|(_, steps)| *steps).collect();
        assert_eq!((steps[1], steps[0] + steps[1], steps.len()), (20 * 100 * 500, all, 2));
        assert_ne!(works[0].0, works[1].0);
        // The last generation is evaluated in one reality more.
        let (all, works) = self::works("../../experiments/sweeps/khepera-sensor-noise.toml");
        assert!(works.len() == 2 && works[0].1 == all, "{works:?}");
        assert_eq!(works[1].1, 100 * 500);
        // A foragers' arena is one world at a time, and slower than their simulators.
        let (all, works) = self::works("../../experiments/sweeps/odowd2014-density.toml");
        assert!(
            works.len() == 2 && works[0].1 > 0 && works[0].1 + works[1].1 == all,
            "{works:?}"
        );
        assert_ne!(works[0].0, works[1].0);
    }
}
