//! In place of kernels composed at run time, where there are none: without the feature `native`, and on processors that no
//! code is generated for.

use std::collections::BTreeMap;
use std::sync::Arc;

use oneiro_shaders::Kernel;

use crate::parameter::{Allowed, Invalid};

/// Why a part is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("this program can't compose kernels; allowed: the tasks that ship with it")]
pub struct Refused;

/// A value that a part declares; there is none.
#[derive(Clone, Debug, PartialEq)]
pub struct Value {
    /// Its name.
    pub name: String,
    /// Its default.
    pub default: f32,
    /// The allowed values.
    pub allowed: Allowed,
    /// Its unit.
    pub unit: String,
    /// Its meaning.
    pub about: String,
}

/// A task of the user's own; there is none.
#[derive(Clone, Debug, PartialEq)]
pub enum TaskPart {}

impl TaskPart {
    /// Refuses every part.
    ///
    /// # Errors
    /// Always.
    pub fn new(_: &str, _: &str) -> Result<Self, Refused> {
        Err(Refused)
    }

    /// The path of its file.
    pub fn path(&self) -> &str {
        match *self {}
    }

    /// The values that it declares.
    pub fn values(&self) -> &[Value] {
        match *self {}
    }

    pub(crate) fn kernel(&self, _: &'static Kernel) -> Result<&'static Kernel, Refused> {
        match *self {}
    }
}

/// A task of the user's own, and its values; there is none.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnTask(TaskPart);

impl OwnTask {
    /// Sets values by name.
    ///
    /// # Errors
    /// There is no part to give.
    pub fn new(part: Arc<TaskPart>, _: &[(&str, f64)]) -> Result<Self, Invalid> {
        match *part {}
    }

    /// The part.
    pub fn part(&self) -> &TaskPart {
        &self.0
    }

    /// Each value by its name.
    pub fn named_values(&self) -> BTreeMap<String, f64> {
        match self.0 {}
    }

    pub(crate) fn cells(&self) -> Vec<[u32; 4]> {
        match self.0 {}
    }
}
