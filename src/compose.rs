//! Kernels composed when the program runs: a shipped kernel with a task of the user's own in place of its task. Nothing is
//! rebuilt, and the results are the same bits on every device, as those of the kernels that ship.
//!
//! A task is one WGSL part, see `docs/extend.md`:
//!
//! ```
//! use std::sync::Arc;
//! use oneiro::compose::{OwnTask, TaskPart};
//! use oneiro::world::{Task, World, WorldSpec};
//!
//! let part = TaskPart::new("turn.wgsl", "
//!     struct TaskValues {
//!         most: f32, // 0.1, 0 to 0.5 turns: how much of a turn counts in a cycle
//!     }
//!     fn task_cycle(life: Life, now: Experience, before: TaskState) -> Reward {
//!         return Reward(min(abs(now.moved.turn), task_values(life.world).most), before);
//!     }")?;
//! let task = OwnTask::new(Arc::new(part), &[("most", 0.2)])?;
//! let world = World::new(WorldSpec {
//!     task: Task::Own,
//!     own_task: Some(Arc::new(task)),
//!     ..WorldSpec::miglino1995()
//! })?;
//! assert_eq!(world.genes(), 18);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[cfg_attr(
    not(all(feature = "native", any(target_arch = "x86_64", target_arch = "aarch64"))),
    path = "compose/absent.rs"
)]
mod part;

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::parameter::{Allowed, Datum, Invalid};

pub use part::TaskPart;

/// Reasons why a part is refused: one line for each problem, with file, line, column, and what to write instead.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", .0.join("\n"))]
pub struct Refused(Vec<String>);

/// A value that a part declares: a field of its struct `TaskValues`, with the comment
/// `DEFAULT, LEAST to GREATEST UNIT: MEANING`.
#[derive(Clone, Debug, PartialEq)]
pub struct Value {
    /// Its name.
    pub name: String,
    /// Its default.
    pub default: f32,
    /// The allowed values.
    pub allowed: Allowed,
    /// Its unit; empty for counts and shares.
    pub unit: String,
    /// Its meaning.
    pub about: String,
}

/// A task of the user's own, and its values.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnTask {
    part: Arc<TaskPart>,
    values: Vec<f32>,
}

impl OwnTask {
    /// Sets values by name; the others have their defaults.
    ///
    /// # Errors
    /// A value that the part doesn't declare, or that isn't allowed.
    pub fn new(part: Arc<TaskPart>, given: &[(&str, f64)]) -> Result<Self, Invalid> {
        for (name, _) in given {
            if !part.values().iter().any(|value| value.name == *name) {
                let names: Vec<_> = part.values().iter().map(|value| value.name.as_str()).collect();
                let allowed = if names.is_empty() {
                    "none".to_owned()
                } else {
                    names.join(", ")
                };
                let problem = format!("is no value of {}; allowed: {allowed}", part.path());
                return Err(Invalid::new(format!("task.values.{name}"), problem));
            }
        }
        let value = |value: &Value| {
            let given = given.iter().find(|(name, _)| *name == value.name);
            let own = given.map_or(value.default, |(_, own)| *own as f32);
            let checked = value.allowed.check(&Datum::Single(own), |_| None);
            checked.map_err(|problem| Invalid::new(format!("task.values.{}", value.name), problem))?;
            // Zero has one sign.
            Ok(if own == 0.0 { 0.0 } else { own })
        };
        let values = part.values().iter().map(value).collect::<Result<_, Invalid>>()?;
        Ok(Self { part, values })
    }

    /// The part.
    pub fn part(&self) -> &TaskPart {
        &self.part
    }

    /// Each value by its name.
    pub fn named_values(&self) -> BTreeMap<String, f64> {
        let names = self.part.values().iter().map(|value| value.name.clone());
        names.zip(self.values.iter().map(|value| shortest(*value))).collect()
    }

    /// The values as cells of four words.
    pub(crate) fn cells(&self) -> Vec<[u32; 4]> {
        let cell = |values: &[f32]| std::array::from_fn(|at| values.get(at).map_or(0, |value| value.to_bits()));
        self.values.chunks(4).map(cell).collect()
    }
}

/// The number with the fewest digits that is this one in single precision.
fn shortest(value: f32) -> f64 {
    value.to_string().parse().unwrap_or_else(|_| value.into())
}
