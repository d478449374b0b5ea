//! What a part declares, from its text alone: a part by itself can't be parsed, since it uses what other parts declare.

use crate::exact::{blank_comments, words};
use crate::source::{Part, Place, Source};

/// A field of a struct.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Member {
    /// Its name.
    pub name: String,
    /// Its type, without blanks.
    pub ty: String,
    /// The comment after it on its line; empty if there is none.
    pub comment: String,
    /// Where its name stands.
    pub place: Place,
}

/// Whether a part declares a function (`fn`) or a struct (`struct`) with a name.
pub fn declares(part: &Part, keyword: &str, name: &str) -> bool {
    declaration(&blank_comments(&part.text), keyword, name).is_some()
}

/// The place after a declaration's name.
fn declaration(text: &str, keyword: &str, name: &str) -> Option<usize> {
    let mut previous = "";
    words(text).find_map(|(at, word)| {
        let is_found = previous == keyword && word == name;
        previous = word;
        is_found.then_some(at + word.len())
    })
}

/// The fields of a part's struct with this name, if it has one.
pub fn members(part: &Part, name: &str) -> Option<Vec<Member>> {
    let text = blank_comments(&part.text);
    let after = declaration(&text, "struct", name)?;
    let open = after + text[after..].find('{')? + 1;
    let close = open + text[open..].find('}').unwrap_or(text.len() - open);
    let source = Source::new(std::slice::from_ref(part));
    let mut members = Vec::new();
    let mut start = open;
    for field in text[open..close].split_inclusive(',') {
        if let Some((name, ty)) = field.trim_end_matches(',').split_once(':') {
            let at = start + (name.len() - name.trim_start().len());
            let written = start + field.trim_end_matches(',').trim_end().len();
            let line = part.text[written..].lines().next().unwrap_or_default();
            let comment = line
                .trim_start_matches([',', ' '])
                .strip_prefix("//")
                .unwrap_or_default();
            members.push(Member {
                name: name.split_whitespace().last().unwrap_or_default().to_owned(),
                ty: ty.split_whitespace().collect(),
                comment: comment.trim().to_owned(),
                place: source.place(at),
            });
        }
        start += field.len();
    }
    Some(members)
}

/// The first use of one of these names in a part, other than as a field's name.
pub fn use_of<'a>(part: &Part, names: &[&'a str]) -> Option<(Place, &'a str)> {
    let text = blank_comments(&part.text);
    let used = words(&text).find_map(|(at, word)| {
        let name = names.iter().find(|name| **name == word)?;
        let is_field = text[..at].trim_end().ends_with('.') || text[at + word.len()..].trim_start().starts_with(':');
        (!is_field).then_some((at, *name))
    });
    used.map(|(at, name)| (Source::new(std::slice::from_ref(part)).place(at), name))
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
        let own = part(
            "// struct Values { no: u32 }\nstruct Other { a: u32 }\nstruct Values {\n    // before\n    a: f32, // 1, of it\n    at: vec2 < f32 >,\n    c: u32 // the last\n}\n",
        );
        let members = members(&own, "Values").unwrap();
        let told: Vec<_> = members
            .iter()
            .map(|own| format!("{} {}: {} ({})", own.place, own.name, own.ty, own.comment))
            .collect();
        assert_eq!(
            told,
            [
                "own.wgsl:5:5 a: f32 (1, of it)",
                "own.wgsl:6:5 at: vec2<f32> ()",
                "own.wgsl:7:5 c: u32 (the last)"
            ]
        );
        assert_eq!(super::members(&own, "State"), None);
    }

    #[test]
    fn declarations_and_uses_are_found_outside_of_comments() {
        let own = part("// fn a() fitness\nfn b(state: u32) { c.fitness = 1u; }\nfn d() { state[0] = 1u; }");
        assert!(!declares(&own, "fn", "a") && declares(&own, "fn", "b"));
        let (place, name) = use_of(&own, &["fitness", "state"]).unwrap();
        assert_eq!((place.to_string().as_str(), name), ("own.wgsl:3:10", "state"));
        assert_eq!(use_of(&own, &["fitness"]), None);
    }
}
