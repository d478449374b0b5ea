//! How long a sweep takes on each device here: a short batch of its first cell is timed.

use std::time::{Duration, Instant};

use oneiro::batch::{Rollout, Worlds};
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::Key;
use serde::Serialize;

use super::Sweep;
use crate::device::{self, Backend};
use crate::exit::Result;

/// A device, and how fast it is.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Estimate {
    /// What `--backend` calls it, and what it is.
    pub(crate) name: String,
    pub(crate) steps_per_second: f64,
    /// For all runs.
    pub(crate) seconds: f64,
}

/// For the CPU and each exact adapter that can be opened.
///
/// # Errors
/// Exit 3 when the first cell is not valid.
pub(crate) fn estimates(sweep: &Sweep, steps: u64) -> Result<Vec<Estimate>> {
    let worlds = sweep.cell(0)?.sample()?;
    let mut names = vec!["cpu".to_owned()];
    names.extend((0..device::adapters_here()).map(|index| format!("gpu:{index}")));
    let mut found = Vec::new();
    for name in names {
        let backend = Backend {
            name: name.clone(),
            threads: None,
            recheck: 0.0,
        };
        // What can't be opened is no way to run it.
        let Ok(mut evaluator) = device::open(&backend) else {
            continue;
        };
        let Some(rate) = rate(evaluator.as_mut(), &worlds) else {
            continue;
        };
        found.push(Estimate {
            name: format!("{name}, {}", device::name(evaluator.as_ref())),
            steps_per_second: rate,
            seconds: steps as f64 / rate,
        });
    }
    Ok(found)
}

/// Robot-steps per second: batches grow until one takes long enough to be timed.
fn rate(evaluator: &mut dyn Evaluator, worlds: &Worlds) -> Option<f64> {
    const LONG: Duration = Duration::from_millis(40);
    const MOST: usize = 1 << 18;
    let genes = vec![0.25; worlds.genes()[0]];
    let mut count = 256;
    loop {
        let rollouts: Vec<Rollout<'_>> = (0..count as u64)
            .map(|individual| Rollout {
                world: 0,
                genes: &genes,
                key: Key::rollout(0, 0, individual, 0),
            })
            .collect();
        let batch = worlds.batch(&rollouts, None).ok()?;
        let start = Instant::now();
        evaluator.evaluate(&batch, &Control::new()).ok()?;
        let took = start.elapsed();
        // The first batch pays for what is prepared once.
        if count > 256 && (took >= LONG || count >= MOST) {
            return Some(batch.steps() as f64 / took.as_secs_f64());
        }
        count *= 4;
    }
}
