//! Progress bars on standard error.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

pub use indicatif::ProgressBar;
use indicatif::{ProgressDrawTarget, ProgressStyle};
use oneiro::evaluator::Control;

use crate::console::{Bars, Console, shown};

/// Time between two redraws of a bar.
const TICK: Duration = Duration::from_millis(100);

/// A progress bar of robot-steps.
pub fn bar(steps: u64, label: &str, bars: Bars) -> ProgressBar {
    let target = if bars == Bars::Hidden {
        ProgressDrawTarget::hidden()
    } else {
        ProgressDrawTarget::stderr()
    };
    let style = ProgressStyle::with_template("{prefix} {bar:32} {percent:>3} %  {per_sec}  {eta} left");
    let bar = ProgressBar::with_draw_target(Some(steps.max(1)), target).with_prefix(shown(label).into_owned());
    match style {
        Ok(style) => bar.with_style(style.with_key("per_sec", rate)),
        Err(_) => bar,
    }
}

/// A progress bar of rows. Hidden like [`bar`].
pub fn rows(count: u64, label: &str, bars: Bars) -> ProgressBar {
    let bar = bar(count, label, bars);
    match ProgressStyle::with_template("{prefix} {bar:32} {pos}/{len}  {eta} left") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// Robot-steps per second in millions.
fn rate(state: &indicatif::ProgressState, text: &mut dyn std::fmt::Write) {
    // Writing to the bar's own text can't fail.
    let _ = write!(text, "{:.1} M steps/s", state.per_sec() / 1e6);
}

/// Runs `work`, and shows the steps that `control` counts.
pub fn watched<T>(steps: u64, label: &str, bars: Bars, control: &Control, work: impl FnOnce() -> T) -> T {
    let bar = bar(steps, label, bars);
    if bar.is_hidden() {
        return work();
    }
    let done = AtomicBool::new(false);
    thread::scope(|scope| {
        let watcher = scope.spawn(|| {
            while !done.load(Ordering::Relaxed) {
                bar.set_position(control.steps().min(steps));
                thread::park_timeout(TICK);
            }
        });
        let result = work();
        done.store(true, Ordering::Relaxed);
        watcher.thread().unpark();
        bar.finish_and_clear();
        result
    })
}

/// Does work of unknown length, and shows from time to time how long it has taken: in place on a terminal, else in
/// lines.
pub fn meanwhile<T>(label: &str, bars: Bars, work: impl FnOnce() -> T) -> T {
    /// Time before the first line, and between two.
    const SHORT: Duration = Duration::from_secs(2);
    const LINES: Duration = Duration::from_secs(30);
    if bars == Bars::Hidden {
        return work();
    }
    let began = Instant::now();
    let done = AtomicBool::new(false);
    thread::scope(|scope| {
        let watcher = scope.spawn(|| {
            let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
            let style = ProgressStyle::with_template("{msg}");
            let bar = style.map_or(bar.clone(), |style| bar.with_style(style));
            let mut next = SHORT;
            while !done.load(Ordering::Relaxed) {
                thread::park_timeout(TICK);
                if began.elapsed() < next || done.load(Ordering::Relaxed) {
                    continue;
                }
                let text = format!("{label}, {} s so far", began.elapsed().as_secs());
                if bar.is_hidden() {
                    Console::default().ask(text);
                    next = began.elapsed() + LINES;
                } else {
                    bar.set_message(shown(&text).into_owned());
                }
            }
            bar.finish_and_clear();
        });
        let result = work();
        done.store(true, Ordering::Relaxed);
        watcher.thread().unpark();
        result
    })
}
