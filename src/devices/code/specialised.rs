//! CPU code compiled at run time for one world, like the GPU's variants of kernels.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::{LaneCode, native};
use crate::batch::Part;
use crate::devices::variants::{Setting, Specialise, Variants};
use crate::evaluator::Control;

/// How many times as long as compiling takes the code for any world works before a world gets its own. What it saves is some fifth, and
/// compiling takes time from the same processors.
const PATIENCE: u32 = 8;
/// Most worlds of a batch that may get their own, unless all must.
const WORLDS: usize = 8;

/// Codes by worlds.
#[derive(Debug)]
pub(crate) struct Specialised(Mutex<Variants<native::Code>>);

impl Default for Specialised {
    fn default() -> Self {
        let mut variants = Variants::default();
        variants.patience = PATIENCE;
        Self(Mutex::new(variants))
    }
}

impl Specialised {
    /// Sets when code is specialised.
    pub(crate) fn set(&mut self, when: Specialise) {
        self.lock().when = when;
    }

    /// Of each group, the code for its world, where it is ready. Empty if there is none for any.
    pub(crate) fn ready(&self, code: &LaneCode, groups: &[Part<'_>], control: &Control) -> Vec<Option<LaneCode>> {
        let mut variants = self.lock();
        let LaneCode::Native(code) = code else {
            return Vec::new();
        };
        if variants.when == Specialise::Auto && worlds(groups).count() > WORLDS {
            return Vec::new();
        }
        let of_world = |(world, groups): (u32, &[Part<'_>])| {
            let variant = variants.ready(&Setting::of(&groups[0], world), control, || code.specialise());
            vec![variant.map(LaneCode::Native); groups.len()]
        };
        worlds(groups).flat_map(of_world).collect()
    }

    /// Runs groups on the codes that are ready, or else on this one, and notes the time that this takes.
    pub(crate) fn timed<E>(
        &self,
        code: &LaneCode,
        groups: &[Part<'_>],
        ready: &[Option<LaneCode>],
        run: impl FnOnce() -> Result<(), E>,
    ) -> Result<(), E> {
        let began = Instant::now();
        run()?;
        self.spend(code, groups, ready, began.elapsed());
        Ok(())
    }

    /// Notes that groups ran on the codes that were ready, or else on this one, and their total time.
    fn spend(&self, code: &LaneCode, groups: &[Part<'_>], mut ready: &[Option<LaneCode>], time: Duration) {
        let (LaneCode::Native(code), false) = (code, ready.is_empty()) else {
            return;
        };
        let mut variants = self.lock();
        for (world, groups_of_world) in worlds(groups) {
            if ready[0].is_some() {
                variants.steps += groups_of_world.iter().map(Part::steps).sum::<u64>();
            } else {
                let share = time.mul_f64(groups_of_world.len() as f64 / groups.len() as f64);
                variants.spend(Setting::of(&groups_of_world[0], world), share, || code.specialise());
            }
            ready = &ready[groups_of_world.len()..];
        }
    }

    /// Robot-steps by code for one world.
    pub(crate) fn steps(&self) -> u64 {
        self.lock().steps
    }

    fn lock(&self) -> MutexGuard<'_, Variants<native::Code>> {
        // A poisoned lock is fine: variants are added complete or not at all.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Groups by worlds. Those of a world lie together.
fn worlds<'a, 'b>(groups: &'a [Part<'b>]) -> impl Iterator<Item = (u32, &'a [Part<'b>])> {
    let world = |group: &Part<'_>| group.group_table()[0].world;
    groups
        .chunk_by(move |a, b| world(a) == world(b))
        .map(move |groups| (world(&groups[0]), groups))
}
