//! A user's part: its declarations, the names that it may use, and the code generated for it.

mod check;
mod exported;
mod fields;
mod generate;
#[cfg(test)]
mod hostile;
mod interface;
mod kernel;
mod limits;
mod members;
#[cfg(test)]
mod names;

use oneiro_shader_compiler as compiler;
use oneiro_shader_compiler::declarations::declarations;
use oneiro_shader_compiler::{Place, Refusal, Refusals, check_part};

pub use oneiro_shader_compiler::Rule;

pub(super) use oneiro_shader_parts::{BEHAVIOUR_TREE, STATE_MACHINE};

use super::{Kind, Refused, Scalar, Value};

pub(crate) use exported::{Exported, HEAD, TAIL};
pub(super) use exported::{exported, simulated};
pub(super) use kernel::{compose, driven};
pub(crate) use kernel::{is_of_user, parts_of};

use fields::GeneField;

impl Refused {
    fn all(refusals: &[Refusal]) -> Self {
        Self(refusals.iter().map(ToString::to_string).collect())
    }
}

/// Refuses what stands at a place outside of functions.
fn refusal(place: &Place, rule: Rule, message: impl Into<String>) -> Refusal {
    Refusal {
        place: place.clone(),
        function: None,
        rule,
        message: message.into(),
    }
}

/// The problem with a kernel whose loops turn too often, with the rule that it breaks.
pub(crate) fn too_many_turns(problem: &str) -> String {
    format!("{problem} [{}]", Rule::TooManyTurns)
}

/// A user's sensors, controller or task.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    kind: Kind,
    path: String,
    text: String,
    /// Whether Oneiro wrote it.
    is_of_oneiro: bool,
    /// Declarations that the kernel needs and the part leaves out.
    generated: String,
    values: Vec<Value>,
    readings: Vec<String>,
    genes: Vec<GeneField>,
    memory: Vec<(String, Scalar)>,
    /// Memory of its mission.
    mission: Vec<(String, Scalar)>,
    functions: Vec<&'static str>,
}

/// The scalars of fields, and their types.
fn scalars(fields: Vec<fields::Remembered>) -> Vec<(String, Scalar)> {
    let each = fields.into_iter();
    each.flat_map(|field| field.scalars.into_iter().map(move |scalar| (scalar, field.scalar)))
        .collect()
}

impl Part {
    /// Reads a part. Messages call it `path`. Mistakes that only show when it is compiled with others are found when a
    /// world is made.
    ///
    /// # Errors
    /// Everything that is wrong with its declarations, each with line and column and what to write instead; and then also
    /// all else that its text shows.
    pub fn new(kind: Kind, path: &str, text: &str) -> Result<Self, Refused> {
        // Some editors begin a file with a mark of its encoding.
        let text = text.trim_start_matches('\u{feff}');
        let part = compiler::Part {
            path: path.to_owned(),
            text: text.to_owned(),
        };
        let unreadable = limits::foreign(&part).or_else(|| limits::problem(&part));
        let unreadable = unreadable.or_else(|| limits::unbalanced(&part));
        if let Some(refusal) = unreadable.or_else(|| check::renamed(&part)) {
            return Err(Refused::all(&[refusal]));
        }
        let (read, mut problems) = Self::read(kind, &part);
        if !problems.is_empty() {
            problems.extend(check_part(&part));
            problems.sort_by_key(|refusal| (refusal.place.line, refusal.place.column));
            return Err(Refused::all(&problems));
        }
        Ok(read)
    }

    /// A controller that Oneiro wrote.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(super) fn of_oneiro(path: &str, text: &str) -> Result<Self, Refused> {
        let part = Self::new(Kind::Controller, path, text)?;
        Ok(Self {
            is_of_oneiro: true,
            ..part
        })
    }

    /// Reads a part, and says all that is wrong with its declarations.
    fn read(kind: Kind, part: &compiler::Part) -> (Self, Refusals) {
        let interface = interface::of(kind);
        let declared = declarations(part);
        let mut problems = Vec::new();
        let values = fields::values(part, &interface, &mut problems);
        let readings = fields::readings(part, &interface, &mut problems);
        let memory = fields::memory(part, &format!("{}State", interface.title), &mut problems);
        let has_mission = declared.iter().any(|item| item.name == interface::MISSION) && !interface.mission.is_empty();
        let mission = if has_mission {
            fields::memory(part, interface::MISSION_STATE, &mut problems)
        } else {
            Vec::new()
        };
        let is_twice = |field: &&fields::Remembered| {
            memory
                .iter()
                .any(|remembered| remembered.scalars[0] == field.scalars[0])
        };
        if let Some(field) = mission.iter().find(is_twice)
            && let Some(item) = declared.iter().find(|item| item.name == interface::MISSION_STATE)
        {
            let message = format!(
                "in `{}`: `{}` is also in `{}State`; choose another name, since both are columns of traces",
                item.name, field.scalars[0], interface.title
            );
            problems.push(refusal(&item.place, Rule::StateTypes, message));
        }
        let genes = fields::genes(part, &interface, &mut problems);
        let mut generated = generate::missing(&interface, &declared, &memory, &values, &readings);
        problems.extend(check::gene_problems(&genes));
        generated += &generate::gene_constants(&genes);
        problems.extend(check::problems(part, &interface, &declared, &generated));
        let read = Self {
            kind,
            path: part.path.clone(),
            text: part.text.clone(),
            is_of_oneiro: false,
            generated,
            values,
            readings,
            genes,
            functions: interface
                .known()
                .map(interface::Function::name)
                .filter(|name| declared.iter().any(|item| item.name == *name))
                .collect(),
            memory: scalars(memory),
            mission: scalars(mission),
        };
        (read, problems)
    }

    /// Its path and its text.
    fn source(&self) -> compiler::Part {
        compiler::Part {
            path: self.path.clone(),
            text: self.text.clone(),
        }
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

    /// The functions that the kernel calls and that it has, such as `task_cycle`; the others have their defaults.
    pub fn functions(&self) -> &[&'static str] {
        &self.functions
    }

    /// The function by which it may end a single robot's episode, if it has that.
    pub fn end_function(&self) -> Option<&'static str> {
        let end = format!("{}_ends", self.kind.word());
        self.functions.iter().copied().find(|name| *name == end)
    }

    /// Whether it has a mission, for swarms.
    pub fn has_mission(&self) -> bool {
        self.functions.contains(&interface::MISSION)
    }

    /// Scalars of its mission's memory, and their types.
    pub fn mission(&self) -> &[(String, Scalar)] {
        &self.mission
    }

    /// Its memory's scalars, such as `place.x`, and their types.
    pub fn memory(&self) -> &[(String, Scalar)] {
        &self.memory
    }
}
