//! Objects on the command line.

use oneiro_base::exit::{Failure, Result};
use oneiro_lab::reality::{Object, Shape};

/// Longest side of an object, mm.
const LONGEST: f32 = 10_000.0;

/// Objects by their names, or of the user's own: `CLASS:round:RADIUS` and `CLASS:block:LENGTHxWIDTH`.
///
/// # Errors
/// Exit 3 with the first that is not valid, and what is allowed.
pub(super) fn objects(given: &[String]) -> Result<Vec<Object>> {
    let mut objects: Vec<Object> = Vec::new();
    for text in given {
        let invalid = |problem: &str| Failure::input(format_args!("--objects {text}: {problem}"));
        let object = object(text).map_err(|problem| invalid(&problem))?;
        if objects.iter().any(|known| known.class == object.class) {
            return Err(invalid("is given twice; allowed: each once"));
        }
        objects.push(object);
    }
    Ok(objects)
}

fn object(text: &str) -> std::result::Result<Object, String> {
    let Some((class, rest)) = text.split_once(':') else {
        let own = "CLASS:wall, CLASS:round:RADIUS and CLASS:block:LENGTHxWIDTH in mm";
        let names = Object::NAMES.join(", ");
        return Object::named(text).ok_or_else(|| format!("no such object; allowed: {names}, {own}"));
    };
    let is_name = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-');
    if !(1..=64).contains(&class.len())
        || !class.bytes().all(is_name)
        || ["motor", "motors", "turning"].contains(&class)
    {
        return Err(format!(
            "the class is `{class}`; allowed: 1 to 64 letters, digits, `_` and `-`, but not motor, motors and turning"
        ));
    }
    let shape = match rest.split_once(':') {
        None if rest == "wall" => Some(Shape::Wall),
        Some(("round", radius)) => length(radius).map(|radius| Shape::Round { radius }),
        Some(("block", sides)) => sides.split_once('x').and_then(|(one, other)| {
            Some(Shape::Block {
                length: length(one)?,
                width: length(other)?,
            })
        }),
        _ => None,
    };
    let shape = shape.ok_or_else(|| {
        format!("`{rest}` is no shape; allowed: wall, round:RADIUS, block:LENGTHxWIDTH, each 1 to {LONGEST} mm")
    })?;
    Ok(Object {
        class: class.into(),
        shape,
    })
}

fn length(text: &str) -> Option<f32> {
    let length = text.parse().ok()?;
    (1.0..=LONGEST).contains(&length).then_some(length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_have_names_and_sizes() {
        let given = ["wall", "round", "can:round:33", "box:block:110x55.5", "hall:wall"].map(String::from);
        let objects = objects(&given).unwrap();
        let classes: Vec<&str> = objects.iter().map(|object| object.class.as_str()).collect();
        assert_eq!(classes, ["wall", "round", "can", "box", "hall"]);
        assert_eq!(objects[2].shape, Shape::Round { radius: 33.0 });
        let block = Shape::Block {
            length: 110.0,
            width: 55.5,
        };
        assert_eq!((objects[3].shape, objects[4].shape), (block, Shape::Wall));
    }

    #[test]
    fn what_is_no_object_is_refused() {
        for (given, words) in [
            (&["lamp"][..], "no such object; allowed: wall, round, block, CLASS:wall"),
            (&["can:round"], "`round` is no shape; allowed: wall, round:RADIUS"),
            (&["can:round:0.5"], "is no shape"),
            (&["can:round:NaN"], "each 1 to 10000 mm"),
            (&["can:round:33x3"], "is no shape"),
            (&["box:block:110"], "is no shape"),
            (&["box:block:110x-1"], "is no shape"),
            (&["wall:wall:3"], "is no shape"),
            (&[":round:33"], "the class is ``; allowed: 1 to 64 letters"),
            (&["../can:round:33"], "the class is `../can`"),
            (&["motor:round:33"], "but not motor"),
            (&["wall", "wall"], "is given twice"),
            (&["can:round:33", "can:round:30"], "is given twice"),
        ] {
            let given: Vec<String> = given.iter().copied().map(String::from).collect();
            let failure = objects(&given).unwrap_err();
            assert_eq!(failure.code(), 3);
            assert!(failure.to_string().contains(words), "{failure}");
        }
    }
}
