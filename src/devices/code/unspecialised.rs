//! Stands in for code for one world in builds that compile none at run time.

use super::LaneCode;
use crate::batch::Part;
use crate::devices::variants::Specialise;
use crate::evaluator::Control;

#[derive(Debug, Default)]
pub(crate) struct Specialised {}

#[allow(clippy::unused_self, reason = "as the one that it stands in for")]
impl Specialised {
    pub(crate) fn set(&mut self, _: Specialise) {}

    pub(crate) fn ready(&self, _: &LaneCode, _: &[Part<'_>], _: &Control) -> Vec<Option<LaneCode>> {
        Vec::new()
    }

    /// Runs groups. WebAssembly has no clock that could time them.
    pub(crate) fn timed<E>(
        &self,
        _: &LaneCode,
        _: &[Part<'_>],
        _: &[Option<LaneCode>],
        run: impl FnOnce() -> Result<(), E>,
    ) -> Result<(), E> {
        run()
    }

    pub(crate) fn steps(&self) -> u64 {
        0
    }
}
