//! The structs that a part declares: its values, readings and memory.

use oneiro_shader_compiler as compiler;
use oneiro_shader_compiler::declarations::{Member, members};

use super::interface::Interface;
use crate::compose::{Refused, Scalar, Value, shortest};
use crate::parameter::{Allowed, Datum};
use crate::tables::{PREVIOUS, SENSOR_NAMES};

/// A field of a part's memory.
pub(super) struct Remembered {
    /// Its type in WGSL.
    pub(super) ty: String,
    pub(super) scalar: Scalar,
    /// Its scalars, such as `place.x`, `place.y`.
    pub(super) scalars: Vec<String>,
}

impl Scalar {
    /// The expression of a scalar as it is stored: zero has one sign.
    pub(super) fn stored(self, expression: &str) -> String {
        match self {
            Self::Float => format!("stored({expression})"),
            Self::Unsigned | Self::Signed => expression.to_owned(),
        }
    }
}

/// The fields of a struct that a part declares; none if it declares none.
fn fields(part: &compiler::Part, name: &str) -> Result<Vec<Member>, Refused> {
    let fields = members(part, name).unwrap_or_default();
    let is_name = |name: &str| {
        name.starts_with(|c: char| c.is_alphabetic() || c == '_')
            && name.chars().all(|c| c.is_alphanumeric() || c == '_')
    };
    match fields.iter().find(|field| !is_name(&field.name) || field.ty.is_empty()) {
        Some(other) => Err(Refused::at(
            &other.place,
            format!("in `{name}`: isn't a field; write `NAME: TYPE`"),
        )),
        None => Ok(fields),
    }
}

/// The values that a part declares.
pub(super) fn values(part: &compiler::Part, interface: &Interface) -> Result<Vec<Value>, Refused> {
    const FORM: &str = "f32, // DEFAULT, LEAST to GREATEST UNIT: MEANING";
    let name = format!("{}Values", interface.title);
    let mut values = Vec::new();
    for member in fields(part, &name)? {
        let refused = |problem: &str| {
            let field = &member.name;
            Refused::at(
                &member.place,
                format!("in `{name}`: `{field}`: {problem}; write `{field}: {FORM}`"),
            )
        };
        if member.ty != "f32" {
            return Err(refused("isn't an f32"));
        }
        let value = value(&member).ok_or_else(|| refused("its comment doesn't say which values are allowed"))?;
        let checked = value.allowed.check(&Datum::Single(value.default), |_| None);
        checked.map_err(|problem| refused(&format!("the default {problem}")))?;
        values.push(value);
    }
    Ok(values)
}

/// Reads `DEFAULT, LEAST to GREATEST UNIT: MEANING`.
fn value(member: &Member) -> Option<Value> {
    let (head, about) = member.comment.split_once(':')?;
    let (default, range) = head.split_once(',')?;
    let (least, after) = range.split_once(" to ")?;
    let (greatest, unit) = after.trim().split_once(' ').unwrap_or((after.trim(), ""));
    let number = |text: &str| text.trim().parse::<f32>().ok().filter(|number| number.is_finite());
    let (least, greatest) = (shortest(number(least)?), shortest(number(greatest)?));
    (least <= greatest).then_some(())?;
    Some(Value {
        name: member.name.clone(),
        default: number(default)?,
        allowed: Allowed::Number(least, greatest),
        unit: unit.trim().to_owned(),
        about: about.trim().to_owned(),
    })
}

/// Names of the readings that a part declares.
pub(super) fn readings(part: &compiler::Part, interface: &Interface) -> Result<Vec<String>, Refused> {
    const NAME: &str = "SensorReadings";
    if !interface.structs.contains(&NAME) {
        return Ok(Vec::new());
    }
    let list = fields(part, NAME)?;
    if let Some(other) = list.iter().find(|member| member.ty != "f32") {
        let problem = format!(
            "in `{NAME}`: `{}` isn't an f32; allowed: one f32 per reading",
            other.name
        );
        return Err(Refused::at(&other.place, problem));
    }
    // Genes are named by what they weigh.
    let is_taken = |name: &str| SENSOR_NAMES.contains(&name) || PREVIOUS.contains(&name);
    if let Some(other) = list.iter().find(|member| is_taken(&member.name)) {
        let problem = format!(
            "in `{NAME}`: `{}` is a name of a shipped reading; choose another",
            other.name
        );
        return Err(Refused::at(&other.place, problem));
    }
    Ok(list.into_iter().map(|member| member.name).collect())
}

/// The fields of a part's memory.
pub(super) fn memory(part: &compiler::Part, interface: &Interface) -> Result<Vec<Remembered>, Refused> {
    let name = format!("{}State", interface.title);
    let mut memory = Vec::new();
    for Member {
        name: field, ty, place, ..
    } in fields(part, &name)?
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
            let problem =
                format!("in `{name}`: `{field}`: {ty} can't be kept; allowed: f32, u32, i32 and vectors of them");
            return Err(Refused::at(&place, problem));
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
    Ok(memory)
}
