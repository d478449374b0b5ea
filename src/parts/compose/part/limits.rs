//! Limits of a part's text: its characters, its depth and its length. They are checked before anything parses it: parsers read
//! ASCII and recurse into each nested level, and would run out of stack.

use std::slice;

use oneiro_shader_compiler as compiler;
use oneiro_shader_compiler::{Refusal, Rule, Source};

use super::refusal;

/// Most words and signs of a part.
const GREATEST_PART: u32 = 100_000;
/// Most words and signs between two of `;`, `,` and braces.
const GREATEST_STATEMENT: u32 = 1_000;
/// Most open brackets of all kinds.
const GREATEST_DEPTH: u32 = 100;
/// Most `else` and `case` of a function.
const GREATEST_BRANCHES: u32 = 250;

/// Most functions, structs and constants of a part, each of which may use the one before.
const GREATEST_DECLARATIONS: u32 = 500;

/// The first character outside of comments that isn't ASCII, or is a control character other than a tab or a line break.
pub(super) fn foreign(part: &compiler::Part) -> Option<Refusal> {
    let is_foreign = |c: char| !(c.is_ascii_graphic() || matches!(c, ' ' | '\t' | '\n' | '\r'));
    let (at, character) = code(&part.text)
        .flat_map(|(at, text)| text.char_indices().map(move |(offset, c)| (at + offset, c)))
        .find(|(_, c)| is_foreign(*c))?;
    let name = named(character).map_or_else(String::new, |name| format!(", {name}"));
    let shown = if character.is_alphanumeric() {
        format!("`{character}`, ")
    } else {
        String::new()
    };
    let code = u32::from(character);
    let message = format!(
        "the character {shown}U+{code:04X}{name}; allowed outside of comments: ASCII, such as a to z, digits and blanks"
    );
    let place = Source::new(slice::from_ref(part)).place(at);
    Some(refusal(&place, Rule::AsciiSource, message))
}

/// The names of characters that nobody sees.
fn named(character: char) -> Option<&'static str> {
    Some(match character {
        '\0' => "a null character",
        '\u{b}' => "a vertical tab",
        '\u{c}' => "a form feed",
        '\u{85}' => "a next line",
        '\u{a0}' => "a no-break space",
        '\u{ad}' => "a soft hyphen",
        '\u{200b}' => "a zero width space",
        '\u{200c}' => "a zero width non-joiner",
        '\u{200d}' => "a zero width joiner",
        '\u{200e}' => "a left-to-right mark",
        '\u{200f}' => "a right-to-left mark",
        '\u{2028}' => "a line separator",
        '\u{2029}' => "a paragraph separator",
        '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => "which changes the direction of text",
        '\u{2060}' => "a word joiner",
        '\u{feff}' => "a byte order mark",
        _ if character.is_control() => "a control character",
        _ if character.is_whitespace() => "a blank",
        _ => return None,
    })
}

/// The first place where a part is too deep or too long.
pub(super) fn problem(part: &compiler::Part) -> Option<Refusal> {
    let (mut all, mut statement, mut depth, mut branches, mut declarations) = (0, 0, 0_u32, 0, 0);
    for (at, token) in tokens(&part.text) {
        all += 1;
        statement += 1;
        match token {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth = depth.saturating_sub(1),
            "else" | "case" => branches += 1,
            "fn" | "struct" | "const" | "alias" if depth == 0 => declarations += 1,
            _ => (),
        }
        if matches!(token, ";" | "," | "{" | "}") {
            statement = 0;
        }
        if depth == 0 {
            branches = 0;
        }
        let too_many = [
            (all, GREATEST_PART, "words and signs in a part"),
            (statement, GREATEST_STATEMENT, "words and signs in a statement"),
            (depth, GREATEST_DEPTH, "nested brackets"),
            (branches, GREATEST_BRANCHES, "`else` and `case` in a function"),
            (
                declarations,
                GREATEST_DECLARATIONS,
                "functions, structs and constants in a part",
            ),
        ];
        if let Some((_, most, what)) = too_many.into_iter().find(|(count, most, _)| count > most) {
            let place = Source::new(slice::from_ref(part)).place(at);
            let message = format!("there are too many {what}; allowed: {most}");
            return Some(refusal(&place, Rule::LargeKernel, message));
        }
    }
    None
}

/// The first brace that is missing or closes nothing. What comes after it would be read as something else.
pub(super) fn unbalanced(part: &compiler::Part) -> Option<Refusal> {
    let source = Source::new(slice::from_ref(part));
    let refuse = |at, message: String| Some(refusal(&source.place(at), Rule::ValidWgsl, message));
    let mut open: Vec<usize> = Vec::new();
    let missing = |open: &[usize]| {
        let line = source.place(open[0]).line;
        format!("a `}}` is missing before this: a `{{` of line {line} or below is still open")
    };
    for (at, token) in tokens(&part.text) {
        match token {
            "{" => open.push(at),
            "}" if open.pop().is_none() => return refuse(at, "this `}` closes nothing; leave it out".into()),
            "fn" | "struct" if !open.is_empty() => return refuse(at, missing(&open)),
            _ => (),
        }
    }
    let end = part.text.trim_end().len();
    open.first().and_then(|_| refuse(end, missing(&open)))
}

/// Words, numbers and signs with their places, without blanks and comments.
fn tokens(text: &str) -> impl Iterator<Item = (usize, &str)> {
    code(text).filter(|(_, token)| !token.starts_with(char::is_whitespace))
}

/// Words, numbers, signs and blanks with their places, without comments.
fn code(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut at = 0;
    std::iter::from_fn(move || {
        loop {
            let rest = &text[at..];
            let first = rest.chars().next()?;
            let length = if rest.starts_with("//") {
                rest.find(ends_line).unwrap_or(rest.len())
            } else if rest.starts_with("/*") {
                comment(rest)
            } else if is_word(first) {
                rest.find(|c| !is_word(c)).unwrap_or(rest.len())
            } else {
                first.len_utf8()
            };
            let start = at;
            at += length;
            let is_comment = first == '/' && length > 1;
            if !is_comment {
                return Some((start, &text[start..at]));
            }
        }
    })
}

/// WGSL has more kinds of line breaks than `\n`, and each ends a comment.
fn ends_line(c: char) -> bool {
    matches!(c, '\n'..='\r' | '\u{85}' | '\u{2028}' | '\u{2029}')
}

/// Length of the comment that a text begins with, with those inside of it.
fn comment(text: &str) -> usize {
    let (mut at, mut depth) = (0, 0);
    while at < text.len() {
        let (change, length) = match &text.as_bytes()[at..] {
            [b'/', b'*', ..] => (1, 2),
            [b'*', b'/', ..] => (-1, 2),
            _ => (0, 1),
        };
        depth += change;
        at += length;
        if depth == 0 {
            break;
        }
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_blanks_are_no_tokens() {
        let text = "fn f /* a /* b */ c */ () { // d\n x /= y\u{e9}; }/* \u{e9} ";
        let found: Vec<_> = tokens(text).map(|(_, token)| token).collect();
        assert_eq!(found, ["fn", "f", "(", ")", "{", "x", "/", "=", "y\u{e9}", ";", "}"]);
        assert!(tokens(text).all(|(at, token)| text[at..].starts_with(token)));
    }

    #[test]
    fn each_limit_is_the_last_that_is_allowed() {
        let problem = |text: String| {
            let path = "task.wgsl".to_owned();
            problem(&compiler::Part { path, text }).map(|refusal| refusal.to_string())
        };
        for (head, middle, most, message) in [
            (
                "",
                "fn g() {}",
                500,
                "4501: there are too many functions, structs and constants in a part; allowed: 500",
            ),
            (
                "",
                "a;",
                50_000,
                "100001: there are too many words and signs in a part; allowed: 100000",
            ),
            (
                "",
                "-",
                1_000,
                "1001: there are too many words and signs in a statement; allowed: 1000",
            ),
            ("{", "(", 99, "101: there are too many nested brackets; allowed: 100"),
            (
                "{",
                "else{}",
                250,
                "1502: there are too many `else` and `case` in a function; allowed: 250",
            ),
            (
                "{} else {} {",
                "case ",
                250,
                "1263: there are too many `else` and `case` in a function; allowed: 250",
            ),
        ] {
            assert_eq!(problem(format!("{head}{}", middle.repeat(most))), None, "{middle}");
            let found = problem(format!("{head}{}", middle.repeat(most + 1)));
            assert_eq!(found, Some(format!("task.wgsl:1:{message} [large-kernel]")), "{middle}");
        }
    }
}
