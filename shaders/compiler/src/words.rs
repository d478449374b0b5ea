//! The words of WGSL.

/// The text with comments turned to spaces, byte for byte.
pub(crate) fn blank_comments(text: &str) -> String {
    let mut bytes = text.as_bytes().to_vec();
    let mut at = 0;
    let mut depth = 0;
    while at < bytes.len() {
        if depth == 0 && bytes[at..].starts_with(b"//") {
            while at < bytes.len() && !ends_line(&bytes[at..]) {
                bytes[at] = b' ';
                at += 1;
            }
        } else if bytes[at..].starts_with(b"/*") {
            depth += 1;
            bytes[at..at + 2].fill(b' ');
            at += 2;
        } else if depth > 0 && bytes[at..].starts_with(b"*/") {
            depth -= 1;
            bytes[at..at + 2].fill(b' ');
            at += 2;
        } else {
            if depth > 0 && bytes[at] != b'\n' {
                bytes[at] = b' ';
            }
            at += 1;
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Whether a text starts with a line break. WGSL has more kinds than `\n`, and each ends a comment.
fn ends_line(bytes: &[u8]) -> bool {
    matches!(bytes[0], b'\n'..=b'\r')
        || ["\u{85}", "\u{2028}", "\u{2029}"]
            .iter()
            .any(|end| bytes.starts_with(end.as_bytes()))
}

/// Identifiers and numbers with their places.
pub(crate) fn words(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut rest = 0;
    std::iter::from_fn(move || {
        let after = &text[rest..];
        let digit = |at: usize| after[at..].starts_with(|c: char| c.is_ascii_digit());
        let is_start =
            |(at, c): (usize, char)| (c.is_alphanumeric() || c == '_' || c == '.' && digit(at + 1)).then_some(at);
        let start = rest + after.char_indices().find_map(is_start)?;
        let number = is_number(&text[start..]);
        let mut before = ' ';
        let length = text[start..]
            .find(|c: char| {
                let exponent_sign = number && matches!(c, '+' | '-') && matches!(before, 'e' | 'E' | 'p' | 'P');
                let hex_e = is_hex(&text[start..]) && matches!(before, 'e' | 'E');
                let inside = c.is_alphanumeric() || c == '_' || (number && c == '.') || (exponent_sign && !hex_e);
                before = c;
                !inside
            })
            .unwrap_or(text.len() - start);
        rest = start + length;
        Some((start, &text[start..rest]))
    })
}

pub(crate) fn is_hex(number: &str) -> bool {
    number.starts_with("0x") || number.starts_with("0X")
}

pub(crate) fn is_number(word: &str) -> bool {
    word.starts_with(|c: char| c.is_ascii_digit() || c == '.')
}

/// Whether what follows a word makes it a call: `(`, or template arguments and `(`.
pub(crate) fn is_call(after: &str) -> bool {
    let after = after.trim_start();
    if !after.starts_with('<') {
        return after.starts_with('(');
    }
    let mut depth = 0;
    for (at, c) in after.char_indices() {
        match c {
            '<' => depth += 1,
            '>' => depth -= 1,
            c if c.is_alphanumeric() || matches!(c, '_' | ',' | ' ') => {}
            _ => return false,
        }
        if depth == 0 {
            return after[at + 1..].trim_start().starts_with('(');
        }
    }
    false
}
