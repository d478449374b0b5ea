//! Stands in for threads where none can be started, as in WebAssembly: the caller's thread computes.

use crate::evaluator::Error;

#[derive(Debug)]
pub(super) struct Workers {}

#[allow(
    clippy::unused_self,
    clippy::unnecessary_wraps,
    reason = "as the threads that it stands in for"
)]
impl Workers {
    pub(super) fn start(_: usize) -> Result<Self, Error> {
        Ok(Self {})
    }

    pub(super) fn count(&self) -> usize {
        1
    }

    pub(super) fn all(&self, is_true: fn() -> bool) -> bool {
        is_true()
    }

    pub(super) fn install<T>(&self, work: impl FnOnce() -> T) -> T {
        work()
    }
}
