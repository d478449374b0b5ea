//! What shows how far runs are, and hears when the user wants them to stop.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::ProgressBar;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::console::Console;
use crate::exit::{Code, Failure, Result};
use crate::experiment::Experiment;
use crate::progress;
use crate::run::{Follow, Run};
use crate::worker::Watch;

/// Whether the user wants the program to stop: after the first Ctrl-C, or SIGTERM. The next Ctrl-C then ends it at
/// once, exit 130.
pub(crate) fn stop_signal() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    let register = || {
        // In this order: the first Ctrl-C finds the flag unset.
        flag::register_conditional_shutdown(SIGINT, Code::Aborted as i32, Arc::clone(&stop))?;
        flag::register(SIGINT, Arc::clone(&stop))?;
        flag::register(SIGTERM, Arc::clone(&stop))
    };
    register().map_err(|error| Failure::failed(format_args!("can't listen for Ctrl-C: {error}")))?;
    Ok(stop)
}

/// Watches runs for the user.
pub(crate) struct Watcher {
    console: Console,
    stop: Arc<AtomicBool>,
    bar: ProgressBar,
    /// The best score of any run.
    best: f32,
    told: Instant,
}

impl Watcher {
    /// Begins to listen and to show.
    pub(crate) fn new(console: Console) -> Result<Self> {
        Ok(Self {
            console,
            stop: stop_signal()?,
            bar: progress::bar(0, "", console),
            best: f32::NEG_INFINITY,
            told: Instant::now(),
        })
    }

    /// Tells it that so many generations are to come.
    pub(crate) fn expect(&self, experiment: &Experiment, generations: u64) {
        let settings = experiment.settings();
        let lives = u64::from(settings.evolution.population) * u64::from(settings.trials);
        self.bar.inc_length(
            generations
                .saturating_mul(lives)
                .saturating_mul(u64::from(settings.cycles)),
        );
    }

    /// Clears the line, and tells what the evaluator had to say.
    pub(crate) fn finish(self, warnings: &[String]) {
        self.bar.finish_and_clear();
        for warning in warnings {
            self.console.say(format!("warning: {warning}"));
        }
    }
}

impl Watch for Watcher {
    fn stops(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    fn steps(&mut self, done: u64) {
        if !self.bar.is_hidden() {
            self.bar.set_position(done);
        }
    }
}

impl Follow for Watcher {
    fn lived(&mut self, run: &Run) {
        const BLINK: Duration = Duration::from_millis(50);
        let best = run.evolution().champion().map_or(f32::NAN, |champion| champion.fitness);
        self.best = self.best.max(best);
        if !self.bar.is_hidden() && self.told.elapsed() >= BLINK {
            self.told = Instant::now();
            let generation = run.evolution().generation();
            self.bar
                .set_prefix(format!("generation {generation:>4}, best {:>6.1}", self.best));
        }
    }
}
