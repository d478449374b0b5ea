//! The common parts of pages that replay robots: self-contained HTML, its data as JSON in which long lists of numbers
//! are Base64 of little-endian 16-bit integers, and its script.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::svg::escaped;
use crate::bundle::bundle;

/// The page, with `{{name}}` as placeholders.
const PAGE: &str = include_str!("../components/page.html");
const STYLE: &str = include_str!("../components/page.css");

/// A page that plays robots.
pub(super) struct Player<'a> {
    pub(super) title: &'a str,
    /// The text below the title.
    pub(super) lead: &'a str,
    /// The arena's content in words, for those who can't see it.
    pub(super) drawn: &'a str,
    /// HTML of switches below the arena, of a strip below the time line, and of the panel next to the arena.
    pub(super) switches: &'a str,
    pub(super) strip: &'a str,
    pub(super) panel: &'a str,
    /// Data, by name: keys are in alphabetical order, so that a page is always the same.
    pub(super) facts: &'a BTreeMap<&'a str, Value>,
    /// The name of the page's module.
    pub(super) script: &'a str,
}

/// Makes the page.
pub(super) fn page(player: &Player<'_>) -> String {
    // In a script element, a less-than sign could begin the end tag.
    let data = json!(player.facts).to_string().replace('<', "\\u003c");
    filled(
        PAGE,
        &[
            ("title", &escaped(player.title)),
            ("lead", &escaped(player.lead)),
            ("drawn", player.drawn),
            ("switches", player.switches),
            ("strip", player.strip),
            ("panel", player.panel),
            ("style", STYLE),
            ("data", &data),
            ("script", &bundle(player.script)),
        ],
    )
}

/// The element of a page's script, as [`page`] has it.
pub(super) fn script_element(name: &str) -> String {
    let (_, after) = PAGE.rsplit_once("<script>").unwrap_or_default();
    let (script, _) = after.split_once("</script>").unwrap_or_default();
    format!("<script>{}</script>", filled(script, &[("script", &bundle(name))]))
}

/// Replaces each `{{name}}` of a template. Placeholders in replacements are unchanged.
pub(super) fn filled(template: &str, parts: &[(&str, &str)]) -> String {
    let mut rest = template;
    let mut text = String::new();
    while let Some((before, after)) = rest.split_once("{{") {
        let (name, after) = after.split_once("}}").unwrap_or((after, ""));
        text.push_str(before);
        text.extend(parts.iter().filter(|part| part.0 == name).map(|part| part.1));
        rest = after;
    }
    text + rest
}

/// Converts a heading to 1/65536 turn.
pub fn turns(heading: f32) -> u16 {
    (f64::from(heading).rem_euclid(1.0) * 65_536.0).round() as u32 as u16
}

/// Encodes little-endian integers as Base64.
pub fn packed(words: impl Iterator<Item = u16>) -> String {
    base64(&words.flat_map(u16::to_le_bytes).collect::<Vec<_>>())
}

/// Encodes bytes as Base64.
pub(super) fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let at = |i: usize| u32::from(three.get(i).copied().unwrap_or(0));
        let bits = at(0) << 16 | at(1) << 8 | at(2);
        for digit in 0..4 {
            if digit <= three.len() {
                let six = bits >> (18 - 6 * digit) & 63;
                text.push(char::from(DIGITS[six as usize]));
            } else {
                text.push('=');
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_rfc_4648() {
        let text = |bytes: &[u8]| packed(bytes.as_chunks().0.iter().map(|&two| u16::from_le_bytes(two)));
        assert_eq!(text(b""), "");
        assert_eq!(text(b"fo"), "Zm8=");
        assert_eq!(text(b"foob"), "Zm9vYg==");
        assert_eq!(text(b"foobar"), "Zm9vYmFy");
        assert_eq!(text(&[0xfb, 0xff]), "+/8=");
    }

    #[test]
    fn headings_wrap() {
        assert_eq!(turns(0.25), 16_384);
        assert_eq!(turns(-0.25), 49_152);
        assert_eq!(turns(0.999_999), 0);
        assert_eq!(turns(3.5), 32_768);
    }

    #[test]
    fn replacements_are_not_expanded_again() {
        let parts = [("a", "{{b}}"), ("b", "2")];
        assert_eq!(filled("x {{a}} y {{b}}{{none}} z", &parts), "x {{b}} y 2 z");
    }
}
