//! The structs that a part declares: its values, readings and memory.

use oneiro_shader_compiler as compiler;
use oneiro_shader_compiler::declarations::{Member, members};
use oneiro_shader_compiler::{Place, Refusals, Rule};

use super::interface::{GENES, Interface};
use super::refusal;
use crate::batch::GREATEST_GENE;
use crate::genes::{PREVIOUS, SENSOR_NAMES};
use crate::parameter::is_identifier;
use crate::parameter::{Allowed, Datum};
use crate::parts::compose::{Scalar, Value, shortest};

/// A field of a part's memory.
pub(super) struct Remembered {
    /// Its type in WGSL.
    pub(super) ty: String,
    pub(super) scalar: Scalar,
    /// Its scalars, such as `place.x`, `place.y`.
    pub(super) scalars: Vec<String>,
}

/// A field of a controller's genes: one gene, or an array of them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct GeneField {
    pub(super) name: String,
    /// Number of an array's elements, an expression in WGSL.
    pub(super) count: Option<String>,
    /// Minimum and maximum value, if it has a range.
    pub(super) range: Option<[f32; 2]>,
    pub(super) place: Place,
}

impl GeneField {
    /// The constant with the index of its first gene.
    pub(super) fn constant(&self) -> String {
        self.name.to_ascii_uppercase()
    }

    /// Reads the number and the range of its genes, or says what is wrong with them.
    fn read(&mut self, Member { name, ty, comment, .. }: &Member) -> Result<(), String> {
        if !is_identifier(name) {
            return Err("its name is not letters from a to z, digits and _, a letter first".to_owned());
        }
        let elements = ty.strip_prefix("array<f32,").and_then(|ty| ty.strip_suffix('>'));
        if ty != "f32" && elements.is_none() {
            return Err("isn't an f32 or an array of them, such as `array<f32, INPUTS>`".to_owned());
        }
        if elements.is_some_and(|count| count.contains("/*") || count.contains("//")) {
            return Err("has a number of elements that isn't a constant".to_owned());
        }
        self.count = elements.map(str::to_owned);
        if comment.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) {
            self.range = Some(gene_range(comment)?);
        }
        Ok(())
    }
}

impl Scalar {
    /// The expression of a stored scalar: zero has one sign.
    pub(super) fn stored(self, expression: &str) -> String {
        match self {
            Self::Float => format!("stored({expression})"),
            Self::Unsigned | Self::Signed => expression.to_owned(),
        }
    }
}

/// The fields of a struct that a part declares; none if it declares none.
fn fields(part: &compiler::Part, name: &str, problems: &mut Refusals) -> Vec<Member> {
    let is_name = |name: &str| {
        name.starts_with(|c: char| c.is_alphabetic() || c == '_')
            && name.chars().all(|c| c.is_alphanumeric() || c == '_')
    };
    let mut fields = members(part, name).unwrap_or_default();
    fields.retain(|field| {
        let problem = if !is_name(&field.name) || field.ty.is_empty() {
            "isn't a field; write `NAME: TYPE`".to_owned()
        } else if field.ty.ends_with(';') {
            let ty = field.ty.trim_end_matches(';');
            format!("`{0}`: a field ends with a comma; write `{0}: {ty},`", field.name)
        } else if field.ty.contains(':') {
            // The next field is taken for a part of its type.
            let ty = ["f32", "u32", "i32"].into_iter().find(|ty| field.ty.starts_with(ty));
            let ty = ty.unwrap_or("TYPE");
            format!(
                "`{0}`: a comma is missing after its type; write `{0}: {ty},`",
                field.name
            )
        } else {
            return true;
        };
        problems.push(refusal(
            &field.place,
            Rule::ValidWgsl,
            format!("in `{name}`: {problem}"),
        ));
        false
    });
    fields
}

/// The values that a part declares.
pub(super) fn values(part: &compiler::Part, interface: &Interface, problems: &mut Refusals) -> Vec<Value> {
    const FORM: &str = "f32, // DEFAULT, LEAST to GREATEST UNIT: MEANING";
    let name = format!("{}Values", interface.title);
    let mut values = Vec::new();
    for member in fields(part, &name, problems) {
        match value(&member) {
            Ok(value) => values.push(value),
            Err(problem) => {
                let field = &member.name;
                let problem = format!("in `{name}`: `{field}`: {problem}; write `{field}: {FORM}`");
                problems.push(refusal(&member.place, Rule::ValueForm, problem));
            }
        }
    }
    values
}

/// The value that a field declares, or what is wrong with it.
fn value(member: &Member) -> Result<Value, String> {
    if member.ty != "f32" {
        return Err("isn't an f32".to_owned());
    }
    let value = described(member)?;
    let checked = value.allowed.check(&Datum::Single(value.default), |_| None);
    checked.map_err(|problem| format!("the default {problem}"))?;
    Ok(value)
}

/// Reads `DEFAULT, LEAST to GREATEST UNIT: MEANING`; else what it lacks.
fn described(member: &Member) -> Result<Value, String> {
    let comment = &member.comment;
    if comment.trim().is_empty() {
        return Err("has no comment that says which values are allowed".to_owned());
    }
    let (head, about) = comment
        .split_once(':')
        .ok_or("its comment lacks its end, a colon and the value's meaning")?;
    let (default, range) = head
        .split_once(',')
        .ok_or("its comment lacks a comma between the default and the range")?;
    let default = number(default).ok_or_else(|| format!("its default `{}` is not a number", default.trim()))?;
    let ([least, greatest], unit) = span(range)?;
    Ok(Value {
        name: member.name.clone(),
        default,
        allowed: Allowed::Number(shortest(least), shortest(greatest)),
        unit: unit.to_owned(),
        about: about.trim().to_owned(),
    })
}

/// Reads `LEAST to GREATEST UNIT`; else what is wrong with it.
fn span(text: &str) -> Result<([f32; 2], &str), String> {
    let (least, after) = text
        .split_once(" to ")
        .ok_or_else(|| format!("its range `{}` is not `LEAST to GREATEST`", text.trim()))?;
    let (greatest, unit) = after.trim().split_once(' ').unwrap_or((after.trim(), ""));
    let end = |text: &str| number(text).ok_or_else(|| format!("`{}` in its range is not a number", text.trim()));
    let (least, greatest) = (end(least)?, end(greatest)?);
    if least > greatest {
        return Err(format!("its range begins with {least}, which is above {greatest}"));
    }
    Ok(([least, greatest], unit.trim()))
}

fn number(text: &str) -> Option<f32> {
    text.trim().parse::<f32>().ok().filter(|number| number.is_finite())
}

/// The genes that a controller names; none if it doesn't, or is no controller.
pub(super) fn genes(part: &compiler::Part, interface: &Interface, problems: &mut Refusals) -> Vec<GeneField> {
    const FORM: &str = "f32, // LEAST to GREATEST UNIT: MEANING";
    if !interface.structs.contains(&GENES) {
        return Vec::new();
    }
    let mut genes = Vec::new();
    for member in fields(part, GENES, problems) {
        let mut field = GeneField {
            name: member.name.clone(),
            count: None,
            range: None,
            place: member.place.clone(),
        };
        if let Err(problem) = field.read(&member) {
            let field = &member.name;
            let problem = format!("in `{GENES}`: `{field}`: {problem}; write `{field}: {FORM}`");
            problems.push(refusal(&member.place, Rule::GeneForm, problem));
        }
        genes.push(field);
    }
    genes
}

/// Reads `LEAST to GREATEST UNIT: MEANING`.
fn gene_range(comment: &str) -> Result<[f32; 2], String> {
    let (head, _) = comment
        .split_once(':')
        .ok_or("its comment begins with a number, and lacks its end, a colon and the gene's meaning")?;
    let ([least, greatest], _) = span(head)?;
    let allowed = Allowed::Number(f64::from(-GREATEST_GENE), f64::from(GREATEST_GENE));
    for end in [least, greatest] {
        let checked = allowed.check(&Datum::Single(end), |_| None);
        checked.map_err(|problem| format!("an end of its range {problem}"))?;
    }
    if least == greatest {
        return Err(format!("its range has one value, {least}; make it a constant"));
    }
    Ok([least, greatest])
}

/// Names of the readings that a part declares.
pub(super) fn readings(part: &compiler::Part, interface: &Interface, problems: &mut Refusals) -> Vec<String> {
    const NAME: &str = "SensorReadings";
    if !interface.structs.contains(&NAME) {
        return Vec::new();
    }
    // Genes are named by what they weigh.
    let is_taken = |name: &str| SENSOR_NAMES.contains(&name) || PREVIOUS.contains(&name);
    let mut readings = Vec::new();
    for Member { name, ty, place, .. } in fields(part, NAME, problems) {
        if ty != "f32" {
            let problem = format!("in `{NAME}`: `{name}` isn't an f32; allowed: one f32 per reading");
            problems.push(refusal(&place, Rule::ReadingForm, problem));
        } else if is_taken(&name) {
            let problem = format!("in `{NAME}`: `{name}` is a name of a shipped reading; choose another");
            problems.push(refusal(&place, Rule::ReservedName, problem));
        }
        readings.push(name);
    }
    readings
}

/// The fields of a part's memory: of its struct with this name.
pub(super) fn memory(part: &compiler::Part, name: &str, problems: &mut Refusals) -> Vec<Remembered> {
    let mut memory = Vec::new();
    for Member {
        name: field, ty, place, ..
    } in fields(part, name, problems)
    {
        let (vector, scalar) = match ty.strip_suffix('>').and_then(|ty| ty.split_once('<')) {
            Some((vector, scalar)) => (vector, scalar),
            None => ("", ty.as_str()),
        };
        let components: Option<&[&str]> = match vector {
            "" => Some(&[""]),
            "vec2" => Some(&[".x", ".y"]),
            "vec3" => Some(&[".x", ".y", ".z"]),
            "vec4" => Some(&[".x", ".y", ".z", ".w"]),
            _ => None,
        };
        let scalar = [Scalar::Float, Scalar::Unsigned, Scalar::Signed]
            .into_iter()
            .find(|known| known.wgsl() == scalar);
        let (Some(components), Some(scalar)) = (components, scalar) else {
            let hint = match ty.as_str() {
                "bool" => "; write `u32`, 0 for false and 1 for true",
                "float" | "double" => "; write `f32`",
                "int" => "; write `i32`",
                "uint" | "unsigned" => "; write `u32`",
                _ if ty.starts_with("mat") => "; keep its columns",
                _ => "",
            };
            let problem =
                format!("in `{name}`: `{field}`: {ty} can't be kept; allowed: f32, u32, i32 and vectors of them{hint}");
            problems.push(refusal(&place, Rule::StateTypes, problem));
            continue;
        };
        memory.push(Remembered {
            ty,
            scalar,
            scalars: components
                .iter()
                .map(|component| format!("{field}{component}"))
                .collect(),
        });
    }
    memory
}
