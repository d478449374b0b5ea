//! Tasks of the user's own: checked, completed, and composed with the parts that ship.

use std::collections::BTreeMap;
use std::fmt::{Display, Write};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use oneiro_shader_compiler::declarations::{declares, members, use_of};
use oneiro_shader_compiler::{Compiled, Part, Place, Refusal, compile};
use oneiro_shaders::kernel::Turns;
use oneiro_shaders::{Binding, BindingKind, Kernel, LIFE_PERCEPTRON, PARTS, WordOf};

use super::{Refused, Value, shortest};
use crate::parameter::{Allowed, Datum};

/// Prefix of the paths of tasks.
const TASK: &str = "task/";
/// The function that every task has.
const CYCLE: &str = "fn task_cycle(life: Life, now: Experience, before: TaskState) -> Reward";
/// Buffers that only the kernel itself may touch.
const OUTPUTS: [&str; 3] = ["state", "fitness", "trace"];

impl Refused {
    fn at(place: &Place, problem: impl Display) -> Self {
        Self(vec![format!("{place}: {problem}")])
    }

    fn all(refusals: &[Refusal]) -> Self {
        Self(refusals.iter().map(ToString::to_string).collect())
    }
}

/// A task of the user's own, checked: it compiles together with the shipped parts.
#[derive(Clone, Debug, PartialEq)]
pub struct TaskPart {
    path: String,
    text: String,
    /// What the part leaves out: `task_values`, `task_kept`, and defaults for the rest.
    rest: String,
    values: Vec<Value>,
}

impl TaskPart {
    /// Checks a part. Messages call it `path`.
    ///
    /// # Errors
    /// Everything that is wrong with it, each with line and column and what to write instead.
    pub fn new(path: &str, text: &str) -> Result<Self, Refused> {
        let part = Part {
            path: path.to_owned(),
            text: text.to_owned(),
        };
        if !declares(&part, "fn", "task_cycle") {
            return Err(Refused(vec![format!(
                "{path}: has no function `task_cycle`; allowed: `{CYCLE} {{ .. }}`"
            )]));
        }
        if let Some((place, name)) = use_of(&part, &OUTPUTS) {
            let problem = format!("`{name}` is a buffer that only the kernel may use; give your own another name");
            return Err(Refused::at(&place, problem));
        }
        let values = values(&part)?;
        let own = Self {
            path: path.to_owned(),
            text: text.to_owned(),
            rest: rest(&part, &values)?,
            values,
        };
        own.kernel(&LIFE_PERCEPTRON)?;
        Ok(own)
    }

    /// The path of its file.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// The values that it declares.
    pub fn values(&self) -> &[Value] {
        &self.values
    }

    /// A kernel with this task instead of its own. Each is composed once and stays for the rest of the program.
    ///
    /// # Errors
    /// As [`TaskPart::new`].
    pub(crate) fn kernel(&self, base: &'static Kernel) -> Result<&'static Kernel, Refused> {
        static COMPOSED: Mutex<BTreeMap<String, &'static Kernel>> = Mutex::new(BTreeMap::new());
        let stem = Path::new(&self.path).file_stem().unwrap_or_default().to_string_lossy();
        let hash = blake3::hash(self.text.as_bytes()).to_hex();
        let name = format!("{}+{stem}-{}", base.name, &hash[..16]);
        let known = || COMPOSED.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(kernel) = known().get(&name) {
            return Ok(kernel);
        }
        let kernel = self.compose(base, name.clone())?;
        Ok(known().entry(name).or_insert_with(|| Box::leak(Box::new(kernel))))
    }

    fn compose(&self, base: &'static Kernel, name: String) -> Result<Kernel, Refused> {
        let part = |path: &str, text: &str| Part {
            path: path.to_owned(),
            text: text.to_owned(),
        };
        let shipped = |path: &&str| {
            let found = PARTS.iter().find(|(shipped, _)| shipped == path);
            let (path, text) = found.expect("the parts of a kernel ship with it");
            part(path, text)
        };
        // The user's part comes last, so that a mistake in it changes no place in another.
        let others = base.parts.iter().filter(|path| !path.starts_with(TASK));
        let own = [part("what Oneiro adds", &self.rest), part(&self.path, &self.text)];
        let parts: Vec<Part> = others.map(shipped).chain(own).collect();
        let compiled = compile("task", &parts).and_then(Compiled::bounded);
        let compiled = compiled.map_err(|refusals| Refused::all(&refusals))?;
        let bindings: Vec<Binding> = compiled.bindings.iter().map(binding).collect();
        let alike = |own: &Binding, other: &Binding| {
            let has_own_layout = own.name == "state";
            (own.name, own.kind) == (other.name, other.kind) && (has_own_layout || own.stride == other.stride)
        };
        let is_alike = bindings.len() == base.bindings.len()
            && bindings.iter().zip(base.bindings).all(|(own, other)| alike(own, other));
        if !is_alike {
            return Err(Refused(vec![format!(
                "{}: declares a buffer; allowed: structs, constants and functions",
                self.path
            )]));
        }
        let turns = compiled.turns.map_err(|refusals| Refused::all(&refusals))?;
        Ok(Kernel {
            name: name.leak(),
            parts: leaked(compiled.parts.into_iter().map(|path| &*path.leak())),
            wgsl: compiled.wgsl.leak(),
            spirv: compiled.spirv.leak(),
            entry_point: base.entry_point,
            workgroup_size: compiled.workgroup_size,
            bindings: leaked(bindings),
            turns: Turns(Box::leak(Box::new(move |word: &WordOf<'_>| turns.value(word)))),
            variants: &[],
        })
    }
}

fn leaked<T>(items: impl IntoIterator<Item = T>) -> &'static [T] {
    items.into_iter().collect::<Vec<_>>().leak()
}

fn binding(own: &oneiro_shader_compiler::Binding) -> Binding {
    Binding {
        binding: own.binding,
        name: own.name.clone().leak(),
        kind: match own.kind {
            "Uniform" => BindingKind::Uniform,
            "Read" => BindingKind::Read,
            _ => BindingKind::ReadWrite,
        },
        stride: own.stride,
    }
}

/// The values that a part declares.
fn values(part: &Part) -> Result<Vec<Value>, Refused> {
    const FORM: &str = "f32, // DEFAULT, LEAST to GREATEST UNIT: MEANING";
    let mut values = Vec::new();
    for member in members(part, "TaskValues").unwrap_or_default() {
        let refused = |problem: &str| {
            let name = &member.name;
            Refused::at(
                &member.place,
                format!("in `TaskValues`: `{name}`: {problem}; write `{name}: {FORM}`"),
            )
        };
        if member.ty != "f32" {
            return Err(refused("is no f32"));
        }
        let value =
            value(&member.name, &member.comment).ok_or_else(|| refused("its comment doesn't say what it may be"))?;
        let checked = value.allowed.check(&Datum::Single(value.default), |_| None);
        checked.map_err(|problem| refused(&format!("the default {problem}")))?;
        values.push(value);
    }
    Ok(values)
}

/// Reads `DEFAULT, LEAST to GREATEST UNIT: MEANING`.
fn value(name: &str, comment: &str) -> Option<Value> {
    let (head, about) = comment.split_once(':')?;
    let (default, range) = head.split_once(',')?;
    let (least, rest) = range.split_once(" to ")?;
    let (greatest, unit) = rest.trim().split_once(' ').unwrap_or((rest.trim(), ""));
    let number = |text: &str| text.trim().parse::<f32>().ok().filter(|number| number.is_finite());
    let (least, greatest) = (shortest(number(least)?), shortest(number(greatest)?));
    (least <= greatest).then_some(())?;
    Some(Value {
        name: name.to_owned(),
        default: number(default)?,
        allowed: Allowed::Number(least, greatest),
        unit: unit.trim().to_owned(),
        about: about.trim().to_owned(),
    })
}

/// What a task must have and a part leaves out.
fn rest(part: &Part, values: &[Value]) -> Result<String, Refused> {
    let mut text = String::new();
    let add = |text: &mut String, name: &str, item: &str| {
        if !declares(part, "fn", name) {
            let _ = writeln!(text, "fn {name}{item}");
        }
    };
    // No struct is empty.
    let state = members(part, "TaskState");
    if state.is_none() {
        text.push_str("struct TaskState { unused: u32 }\n");
    }
    let (mut first, mut kept) = (Vec::new(), Vec::new());
    for member in state.unwrap_or_default() {
        let (name, ty) = (&member.name, &member.ty);
        let vector = ["vec2", "vec3", "vec4"]
            .iter()
            .position(|vector| ty.starts_with(vector));
        let scalar = ty.trim_start_matches(|c| c != '<').trim_matches(['<', '>']);
        let (scalar, size) = match vector {
            Some(at) => (scalar, at + 2),
            None => (ty.as_str(), 1),
        };
        if !["f32", "u32", "i32"].contains(&scalar) {
            let problem =
                format!("in `TaskState`: `{name}`: {ty} can't be kept; allowed: f32, u32, i32 and vectors of them");
            return Err(Refused::at(&member.place, problem));
        }
        first.push(format!("{ty}()"));
        kept.push(match (scalar, size) {
            ("f32", 1) => format!("stored(own.{name})"),
            ("f32", size) => {
                let components = ["x", "y", "z", "w"][..size].iter();
                let stored: Vec<_> = components
                    .map(|component| format!("stored(own.{name}.{component})"))
                    .collect();
                format!("{ty}({})", stored.join(", "))
            }
            _ => format!("own.{name}"),
        });
    }
    if kept.is_empty() {
        (first, kept) = (vec!["0u".to_owned()], vec!["own.unused".to_owned()]);
    }
    let [first, kept] = [first, kept].map(|list| list.join(", "));
    add(
        &mut text,
        "task_begin",
        &format!("(life: Life, pose: vec3<f32>) -> TaskState {{ return TaskState({first}); }}"),
    );
    add(
        &mut text,
        "task_kept",
        &format!("(own: TaskState) -> TaskState {{ return TaskState({kept}); }}"),
    );
    add(&mut text, "task_ends", "(own: TaskState) -> bool { return false; }");
    add(
        &mut text,
        "task_score",
        "(own: TaskState, sum: f32) -> f32 { return sum; }",
    );
    if !values.is_empty() {
        let _ = writeln!(text, "fn task_values(world: u32) -> TaskValues {{");
        let _ = writeln!(text, "    let first = worlds[world].task_values;");
        for cell in 0..values.len().div_ceil(4) {
            let _ = writeln!(text, "    let cell_{cell} = tables[first + {cell}u];");
        }
        let read = |index: usize| format!("bitcast<f32>(cell_{}.{})", index / 4, ["x", "y", "z", "w"][index % 4]);
        let list: Vec<_> = (0..values.len()).map(read).collect();
        let _ = writeln!(text, "    return TaskValues({});\n}}", list.join(", "));
    }
    Ok(text)
}
