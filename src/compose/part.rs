//! A user's part: what it declares, what it may use, and what is generated for it.

mod check;
mod fields;
mod generate;
mod interface;
mod kernel;

use std::fmt::Display;

use oneiro_shader_compiler as compiler;
use oneiro_shader_compiler::declarations::declarations;
use oneiro_shader_compiler::{Place, Refusal};

use super::{Kind, Refused, Scalar, Value};

pub(super) use kernel::compose;

impl Refused {
    fn at(place: &Place, problem: impl Display) -> Self {
        Self(vec![format!("{place}: {problem}")])
    }

    fn all(refusals: &[Refusal]) -> Self {
        Self(refusals.iter().map(ToString::to_string).collect())
    }
}

/// A user's sensors, controller or task.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    kind: Kind,
    path: String,
    text: String,
    /// Declarations that the kernel needs and the part leaves out.
    generated: String,
    values: Vec<Value>,
    readings: Vec<String>,
    memory: Vec<(String, Scalar)>,
}

impl Part {
    /// Reads a part. Messages call it `path`. What only shows when it is compiled together with others is checked when a
    /// world is made.
    ///
    /// # Errors
    /// Everything that is wrong with its declarations, each with line and column and what to write instead.
    pub fn new(kind: Kind, path: &str, text: &str) -> Result<Self, Refused> {
        // Some editors begin a file with a mark of its encoding.
        let text = text.trim_start_matches('\u{feff}');
        let part = compiler::Part {
            path: path.to_owned(),
            text: text.to_owned(),
        };
        let interface = interface::of(kind);
        let declared = declarations(&part);
        let mut problems = Vec::new();
        let mut collect = |refused: Refused| problems.extend(refused.0);
        let values = fields::values(&part, &interface)
            .map_err(&mut collect)
            .unwrap_or_default();
        let readings = fields::readings(&part, &interface)
            .map_err(&mut collect)
            .unwrap_or_default();
        let memory = fields::memory(&part, &interface)
            .map_err(&mut collect)
            .unwrap_or_default();
        let generated = generate::missing(&interface, &declared, &memory, &values, &readings);
        problems.extend(check::problems(&part, &interface, &declared, &generated));
        if !problems.is_empty() {
            return Err(Refused(problems));
        }
        Ok(Self {
            kind,
            path: path.to_owned(),
            text: text.to_owned(),
            generated,
            values,
            readings,
            memory: memory
                .into_iter()
                .flat_map(|field| field.scalars.into_iter().map(move |scalar| (scalar, field.scalar)))
                .collect(),
        })
    }

    /// Its kind.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// The path of its file.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// The values that it declares.
    pub fn values(&self) -> &[Value] {
        &self.values
    }

    /// Names of the readings of sensors; none of other kinds.
    pub fn readings(&self) -> &[String] {
        &self.readings
    }

    /// Its memory's scalars, such as `place.x`, and their types.
    pub fn memory(&self) -> &[(String, Scalar)] {
        &self.memory
    }
}
