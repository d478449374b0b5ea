//! Random kernels, one per seed, compared on all processors for a limited time.

use std::time::{Duration, Instant};

use oneiro_shader_compiler::{Refusals, Rule};

/// Result of comparing a kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// All ways to run it gave the same bits.
    Same,
    /// The compiler refused it.
    Refused,
    /// It ran for too long.
    Endless,
}

/// Returns what was compiled from a generated kernel, or `None` if it was refused for the one reason that the generator
/// can't foresee.
///
/// # Panics
/// If it was refused for another reason.
pub(crate) fn unless_refused<T>(seed: u64, text: &str, compiled: Result<T, Refusals>) -> Option<T> {
    let refused = |refusals: Refusals| {
        // Loops without a bound are no reason, but named with one.
        let mut reasons = refusals
            .iter()
            .filter(|own| own.rule != Rule::LoopWithoutBound)
            .peekable();
        let is_expected = reasons.peek().is_some() && reasons.all(|own| own.rule == Rule::SameIndex);
        assert!(is_expected, "seed {seed}: {refusals:?}\n{text}");
    };
    compiled.map_err(refused).ok()
}

/// Number of kernels to compare.
pub(crate) struct Plan {
    /// Number of kernels if there is enough time.
    pub(crate) kernels: u64,
    /// Number of kernels that are compared however long it takes.
    pub(crate) least: u64,
    /// Time after which no more kernels are begun.
    pub(crate) patience: Duration,
    /// Factor on number and time in `tests/long.sh`.
    pub(crate) long: u32,
}

impl Plan {
    /// Compares kernels. `compare` panics if one differs.
    ///
    /// # Panics
    /// If a quarter of them or more could not be compared.
    pub(crate) fn run(&self, compare: impl Fn(u64) -> Outcome + Sync) {
        let start = Instant::now();
        let is_long = std::env::var_os("ONEIRO_LONG").is_some();
        let times = if is_long { self.long } else { 1 };
        let kernels = self.kernels * u64::from(times);
        let threads = std::thread::available_parallelism().map_or(1, |threads| threads.get() as u64);
        let work = |first: u64| {
            let seeds = (first..kernels).step_by(threads as usize);
            let in_time = |seed: &u64| *seed < self.least || start.elapsed() < self.patience * times;
            seeds.take_while(in_time).map(&compare).collect::<Vec<_>>()
        };
        let work = &work;
        let outcomes: Vec<_> = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..threads).map(|first| scope.spawn(move || work(first))).collect();
            threads
                .into_iter()
                .flat_map(|thread| thread.join().expect("the message is above"))
                .collect()
        });
        let same = outcomes.iter().filter(|outcome| **outcome == Outcome::Same).count();
        eprintln!(
            "{same} of {} kernels do what they mean, in {:.1?}",
            outcomes.len(),
            start.elapsed()
        );
        assert!(
            same > outcomes.len() * 3 / 4,
            "too many kernels are refused or run for too long"
        );
    }
}
