//! Declarations of a part, found in its text alone: a part by itself can't be parsed, since it uses what other parts declare.

use std::collections::BTreeSet;

use crate::exact::{CALLS, CONSTRUCTORS, is_built_in};
use crate::ordinary;
use crate::source::{Part, Place, Source};
use crate::words::{blank_comments, is_call, words};

/// Whether WGSL keeps a word for itself, so that nothing can be named by it.
pub fn is_reserved(word: &str) -> bool {
    naga::keywords::wgsl::RESERVED.contains(&word)
}

/// A declaration outside of functions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Declaration {
    /// `fn`, `struct`, `const`, `alias`, `override` or `var`.
    pub keyword: String,
    /// Its name.
    pub name: String,
    /// Place of its name.
    pub place: Place,
    /// For a function, the types of its parameters and its result without blanks, such as `(f32,vec2<f32>)->u32`; for a
    /// constant, its type if it says one.
    pub signature: String,
}

/// A field of a struct.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Member {
    /// Its name.
    pub name: String,
    /// Its type without blanks; `vec2f` and its like are written `vec2<f32>`.
    pub ty: String,
    /// The comment after it on its line; empty if there is none.
    pub comment: String,
    /// Place of its name.
    pub place: Place,
}

/// Words before the name of a declaration outside of functions.
const KEYWORDS: [&str; 6] = ["fn", "struct", "const", "alias", "override", "var"];

/// The declarations of a part, in order.
pub fn declarations(part: &Part) -> Vec<Declaration> {
    let text = blank_comments(&part.text);
    let source = Source::new(std::slice::from_ref(part));
    let (mut found, mut depth, mut seen, mut previous, mut in_space) = (Vec::new(), 0_i64, 0, "", false);
    for (at, word) in words(&text) {
        let between = &text[seen..at];
        depth += between.bytes().map(nesting).sum::<i64>();
        seen = at;
        // The address space of a variable comes before its name.
        in_space = (in_space || previous == "var" && between.contains('<')) && !between.contains('>');
        if in_space {
            continue;
        }
        if depth == 0 && KEYWORDS.contains(&previous) {
            let after = &text[at + word.len()..];
            found.push(Declaration {
                keyword: previous.to_owned(),
                name: word.to_owned(),
                place: source.place(at),
                signature: match previous {
                    "fn" => signature(after),
                    "const" => type_of_constant(after),
                    _ => String::new(),
                },
            });
        }
        previous = word;
    }
    found
}

fn nesting(byte: u8) -> i64 {
    i64::from(byte == b'{') - i64::from(byte == b'}')
}

/// The types of a function's parameters and its result, given what follows its name.
pub fn signature(after: &str) -> String {
    let (parameters, result) = head(after);
    let types: Vec<_> = parameters.map(|(_, ty)| type_of(ty)).collect();
    format!("({})->{}", types.join(","), type_of(result))
}

/// A function's parameters, each with its name and type, and its result, given what follows its name.
fn head(after: &str) -> (impl Iterator<Item = (&str, &str)>, &str) {
    let header = after.split('{').next().unwrap_or_default();
    let (parameters, result) = header.rsplit_once("->").unwrap_or((header, ""));
    let parameters = parameters.trim().trim_start_matches('(').trim_end_matches(')');
    (
        split(parameters).filter_map(|(_, parameter)| parameter.split_once(':')),
        result,
    )
}

/// The parameters of the function that a place is in, each with its name and type.
pub fn parameters_at(part: &Part, place: &Place) -> Vec<(String, String)> {
    let text = blank_comments(&part.text);
    let source = Source::new(std::slice::from_ref(part));
    let is_before = |at: usize| {
        let head = source.place(at);
        (head.line, head.column) < (place.line, place.column)
    };
    let heads = words(&text).filter(|(at, word)| *word == "fn" && is_before(*at));
    let after = heads
        .last()
        .and_then(|(at, _)| text[at..].find('(').map(|open| &text[at + open..]));
    let (parameters, _) = head(after.unwrap_or_default());
    parameters
        .map(|(name, ty)| (name.trim().to_owned(), type_of(ty)))
        .collect()
}

/// The type of a constant, given what follows its name.
fn type_of_constant(after: &str) -> String {
    let (ty, _) = after.split_once('=').unwrap_or_default();
    ty.trim().strip_prefix(':').map(type_of).unwrap_or_default()
}

/// Splits a list at the commas that are in no type's arguments; each item with its offset.
fn split(list: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut depth = 0_i32;
    let mut start = 0;
    list.split_inclusive(move |c| {
        depth += i32::from(c == '<') - i32::from(c == '>');
        c == ',' && depth == 0
    })
    .map(move |item| {
        let at = start;
        start += item.len();
        (at, item.strip_suffix(',').unwrap_or(item))
    })
}

/// A type without blanks, its short name written out.
fn type_of(text: &str) -> String {
    let ty: String = text.split_whitespace().collect();
    let ty = ty.replace(",>", ">");
    match ty.strip_prefix("vec").map(str::as_bytes) {
        Some([size @ b'2'..=b'4', scalar @ (b'f' | b'u' | b'i')]) => {
            format!("vec{}<{}32>", char::from(*size), char::from(*scalar))
        }
        _ => ty,
    }
}

/// The fields of a part's struct with this name, if it has one.
pub fn members(part: &Part, name: &str) -> Option<Vec<Member>> {
    let text = blank_comments(&part.text);
    let mut previous = "";
    let after = words(&text).find_map(|(at, word)| {
        let is_found = previous == "struct" && word == name;
        previous = word;
        is_found.then_some(at + word.len())
    })?;
    let open = after + text[after..].find('{')? + 1;
    let close = open + text[open..].find('}').unwrap_or(text.len() - open);
    let source = Source::new(std::slice::from_ref(part));
    let member = |(offset, field): (usize, &str)| {
        let (name, ty) = field.split_once(':')?;
        let start = open + offset;
        let line = part.text[start + field.trim_end().len()..]
            .lines()
            .next()
            .unwrap_or_default();
        let comment = line
            .trim_start_matches([',', ' ', '\t'])
            .strip_prefix("//")
            .unwrap_or_default();
        // Attributes may come before it.
        let word = name.split_whitespace().last().unwrap_or_default();
        Some(Member {
            name: word.to_owned(),
            ty: type_of(ty),
            comment: comment.trim().to_owned(),
            place: source.place(start + name.rfind(word).unwrap_or(0)),
        })
    };
    Some(split(&text[open..close]).filter_map(member).collect())
}

/// Names that a part calls and neither declares itself nor has from WGSL, with their places.
pub fn calls(part: &Part) -> Vec<(String, Place)> {
    let text = blank_comments(&part.text);
    let declared = declarations(part);
    let source = Source::new(std::slice::from_ref(part));
    let is_foreign = |word: &str| !is_built_in(word) && declared.iter().all(|declaration| declaration.name != word);
    words(&text)
        .filter(|(at, word)| !text[..*at].ends_with('@') && is_call(&text[at + word.len()..]) && is_foreign(word))
        .map(|(at, word)| (word.to_owned(), source.place(at)))
        .collect()
}

/// All names that a part gives to anything: functions, structs, constants, variables, parameters and fields.
pub fn names(part: &Part) -> BTreeSet<String> {
    let text = blank_comments(&part.text);
    let mut previous = "";
    let declared = words(&text).filter(|(at, word)| {
        let follows = KEYWORDS.contains(&previous) || previous == "let";
        previous = word;
        follows || text[at + word.len()..].trim_start().starts_with(':')
    });
    declared.map(|(_, word)| word.to_owned()).collect()
}

/// Functions and types that WGSL has and a part may use.
pub fn built_in() -> impl Iterator<Item = &'static str> {
    CALLS.into_iter().chain(CONSTRUCTORS)
}

/// Functions that WGSL has and this compiler's library computes. A part may declare others with their names.
pub fn ordinary() -> impl Iterator<Item = &'static str> {
    ordinary::CALLS.into_iter()
}

/// A part's text with another name for what is declared by this one. Fields of structs keep theirs.
pub fn renamed(part: &Part, name: &str, other: &str) -> String {
    let text = blank_comments(&part.text);
    let mut renamed = String::with_capacity(part.text.len());
    let (mut done, mut is_struct, mut depth) = (0, false, 0);
    let mut seen = 0;
    for (at, word) in words(&text) {
        for c in text[seen..at].chars() {
            match c {
                '{' if is_struct => depth = 1,
                '}' => (is_struct, depth) = (false, 0),
                _ => {}
            }
        }
        seen = at + word.len();
        is_struct |= word == "struct";
        let is_field = text[..at].trim_end().ends_with('.') || depth > 0 && text[seen..].trim_start().starts_with(':');
        if word == name && !is_field {
            renamed.push_str(&part.text[done..at]);
            renamed.push_str(other);
            done = seen;
        }
    }
    renamed + &part.text[done..]
}

/// The word at a place in a part.
pub fn word_at(part: &Part, place: &Place) -> Option<String> {
    let text = blank_comments(&part.text);
    let source = Source::new(std::slice::from_ref(part));
    let found = words(&text).find(|(at, _)| source.place(*at) == *place);
    found.map(|(_, word)| word.to_owned())
}

/// The names in a part that an index follows, with their places.
pub fn indexed(part: &Part) -> Vec<(String, Place)> {
    let text = blank_comments(&part.text);
    let source = Source::new(std::slice::from_ref(part));
    let found = words(&text).filter(|(at, word)| text[at + word.len()..].trim_start().starts_with('['));
    found.map(|(at, word)| (word.to_owned(), source.place(at))).collect()
}

/// The uses of these names in a part, other than as a field's name.
pub fn uses<'a>(part: &Part, names: &[&'a str]) -> Vec<(Place, &'a str)> {
    find(part, names, |before, after| {
        !before.trim_end().ends_with('.') && !after.trim_start().starts_with(':')
    })
}

/// The accesses to fields with these names in a part.
pub fn accesses<'a>(part: &Part, fields: &[&'a str]) -> Vec<(Place, &'a str)> {
    find(part, fields, |before, _| before.trim_end().ends_with('.'))
}

/// Where these names stand in a part and their surrounding text passes a test.
fn find<'a>(part: &Part, names: &[&'a str], fits: impl Fn(&str, &str) -> bool) -> Vec<(Place, &'a str)> {
    let text = blank_comments(&part.text);
    let source = Source::new(std::slice::from_ref(part));
    let found = words(&text).filter_map(|(at, word)| {
        let name = names.iter().find(|name| **name == word)?;
        fits(&text[..at], &text[at + word.len()..]).then(|| (source.place(at), *name))
    });
    found.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(text: &str) -> Part {
        Part {
            path: "own.wgsl".into(),
            text: text.into(),
        }
    }

    #[test]
    fn members_have_their_comments_and_places() {
        let part = part(
            "// struct Values { no: u32 }\nstruct Other { a: u32 }\nstruct Values {\n    // before\n    a: f32,\t// 1, of it\n    @align(8) at: vec2 < f32, >,\n    b: vec3f,\n    c: u32 // the last\n}\n",
        );
        let members = members(&part, "Values").unwrap();
        let shown: Vec<_> = members
            .iter()
            .map(|member| format!("{} {}: {} ({})", member.place, member.name, member.ty, member.comment))
            .collect();
        assert_eq!(
            shown,
            [
                "own.wgsl:5:5 a: f32 (1, of it)",
                "own.wgsl:6:15 at: vec2<f32> ()",
                "own.wgsl:7:5 b: vec3<f32> ()",
                "own.wgsl:8:5 c: u32 (the last)"
            ]
        );
        assert_eq!(super::members(&part, "State"), None);
    }

    #[test]
    fn all_but_fields_are_renamed() {
        let part = part(
            "// near\nstruct Near { near: f32, at: array<f32, near> }\nfn near(near: f32) -> Near { return Near(near.near, nearer); }\n",
        );
        assert_eq!(
            renamed(&part, "near", "far"),
            "// near\nstruct Near { near: f32, at: array<f32, far> }\nfn far(far: f32) -> Near { return Near(far.near, nearer); }\n"
        );
        assert_eq!(renamed(&part, "absent", "far"), part.text);
    }

    #[test]
    fn declarations_outside_of_functions_and_comments_are_found() {
        let part = part(
            "// fn a() {}\nfn b(at: vec2f, state: array<u32, 3>,) -> f32 { var x = 1u; }\nvar<storage, read_write> mine: u32;\n// x\u{85}const C: u32 = 1u;",
        );
        let shown: Vec<_> = declarations(&part)
            .iter()
            .map(|declaration| {
                format!(
                    "{} {} {} {}",
                    declaration.place, declaration.keyword, declaration.name, declaration.signature
                )
            })
            .collect();
        assert_eq!(
            shown,
            [
                "own.wgsl:2:4 fn b (vec2<f32>,array<u32,3>)->f32",
                "own.wgsl:3:26 var mine ",
                "own.wgsl:4:12 const C u32"
            ]
        );
    }

    #[test]
    fn uses_accesses_and_calls_are_found() {
        let part = part("// fitness\nfn b(state: u32) { c.fitness = abs(1u); }\nfn d() { b(state[0]); root(2.0f); }");
        let shown = |found: Vec<(Place, &str)>| -> Vec<String> {
            let shown = found.into_iter().map(|(place, name)| format!("{place} {name}"));
            shown.collect()
        };
        assert_eq!(shown(uses(&part, &["fitness", "state"])), ["own.wgsl:3:12 state"]);
        assert_eq!(shown(uses(&part, &["b", "root"])).len(), 3);
        assert_eq!(shown(accesses(&part, &["state", "fitness"])), ["own.wgsl:2:22 fitness"]);
        assert!(accesses(&part, &["state"]).is_empty());
        let called: Vec<_> = calls(&part)
            .into_iter()
            .map(|(name, place)| (name, place.line))
            .collect();
        assert_eq!(called, [("root".to_owned(), 3)]);
        let indexed: Vec<_> = indexed(&part)
            .into_iter()
            .map(|(name, place)| (name, place.column))
            .collect();
        assert_eq!(indexed, [("state".to_owned(), 12)]);
        let names: Vec<_> = names(&part).into_iter().collect();
        assert_eq!(names, ["b", "d", "state"]);
        let place = |column| Place {
            path: "own.wgsl".into(),
            line: 3,
            column,
        };
        assert_eq!(word_at(&part, &place(23)).as_deref(), Some("root"));
        assert_eq!(word_at(&part, &place(24)), None);
        assert!(parameters_at(&part, &place(23)).is_empty());
        let second = Place { line: 2, ..place(20) };
        assert_eq!(parameters_at(&part, &second), [("state".to_owned(), "u32".to_owned())]);
    }
}
