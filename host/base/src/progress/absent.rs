//! Stands in for progress bars where there is no terminal: nothing is shown.

use oneiro::evaluator::Control;

use crate::console::Bars;

/// A bar that is never shown.
#[derive(Clone, Debug)]
pub struct ProgressBar {}

#[allow(clippy::unused_self, reason = "as the bar that it stands in for")]
impl ProgressBar {
    pub fn is_hidden(&self) -> bool {
        true
    }

    pub fn set_position(&self, _: u64) {}

    pub fn inc(&self, _: u64) {}

    pub fn set_prefix(&self, _: String) {}

    pub fn finish_and_clear(&self) {}
}

pub fn bar(_: u64, _: &str, _: Bars) -> ProgressBar {
    ProgressBar {}
}

pub fn rows(_: u64, _: &str, _: Bars) -> ProgressBar {
    ProgressBar {}
}

pub fn watched<T>(_: u64, _: &str, _: Bars, _: &Control, work: impl FnOnce() -> T) -> T {
    work()
}

pub fn meanwhile<T>(_: &str, _: Bars, work: impl FnOnce() -> T) -> T {
    work()
}
