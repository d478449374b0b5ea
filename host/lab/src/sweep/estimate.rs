//! Estimates the duration of a sweep on each device of this machine by timing a short batch of its first cell.

use std::time::{Duration, Instant};

use oneiro::backend::Options;
use oneiro::batch::{Rollout, Worlds};
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::Key;
use oneiro_base::console::Bars;
use oneiro_base::exit::Result;
use oneiro_base::progress::meanwhile;
use serde::Serialize;

use super::Sweep;
use crate::device::{self, Backend};

/// A device and its speed.
#[derive(Clone, Debug, Serialize)]
pub struct Estimate {
    /// Name for `--backend`, with a description.
    pub name: String,
    /// Duration of all runs in seconds.
    pub seconds: f64,
    pub steps_per_second: f64,
}

/// Estimates for the named device, or else for the CPU and for each exact GPU that can be opened.
///
/// # Errors
/// Exit 3 if the first cell is invalid, exit 4 if the named device can't be opened.
pub fn estimates(
    sweep: &Sweep,
    steps: u64,
    (named, threads): (Option<&str>, Option<u16>),
    bars: Bars,
) -> Result<Vec<Estimate>> {
    let worlds = sweep.cell(0)?.sample()?;
    // `auto` is whichever of them is faster.
    let named = named.filter(|name| *name != "auto");
    let names = named.map_or_else(
        || {
            let gpus = device::gpus_here().into_iter().map(|index| format!("gpu:{index}"));
            std::iter::once("cpu".to_owned()).chain(gpus).collect()
        },
        |name| vec![name.to_owned()],
    );
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
            Err(failure) if named.is_some() => return Err(failure),
            // A device that can't be opened can't run the sweep.
            Err(_) => continue,
        };
        let Some(rate) = meanwhile(&format!("timing {name}"), bars, || rate(evaluator.as_mut(), &worlds)) else {
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

/// Robot-steps per second. Batches grow until one takes long enough to be timed.
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
        // The first batch includes one-time preparation.
        if count > 256 && (took >= LONG || count >= MOST) {
            return Some(batch.steps() as f64 / took.as_secs_f64());
        }
        count *= 4;
    }
}
