//! Stands in for tasks of the user's own in builds without the feature `native`, and on processors that code can't be
//! generated for.

use oneiro_shaders::Kernel;

use super::{Refused, Value};

/// A task of the user's own. This program has none.
#[derive(Clone, Debug, PartialEq)]
pub enum TaskPart {}

impl TaskPart {
    /// Refuses every part.
    ///
    /// # Errors
    /// Always.
    pub fn new(path: &str, _: &str) -> Result<Self, Refused> {
        Err(Refused(vec![format!(
            "{path}: this program can't compose kernels; allowed: the tasks that ship with it"
        )]))
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
