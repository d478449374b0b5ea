//! Where naga sees a call in ASCII text, the compiler also sees it: whatever stands before its name, and between that and its bracket.
//! What naga folds leaves nothing else to check.

use oneiro_shader_compiler::{Indices, Part, Rule, compile};

/// Whether naga takes a text.
fn is_wgsl(text: &str) -> bool {
    naga::front::wgsl::parse_str(text).is_ok()
}

/// The texts that naga takes and in which nobody sees a call that isn't allowed; and how many of them it takes.
fn unseen(texts: impl Iterator<Item = String>) -> (Vec<String>, usize) {
    let taken: Vec<_> = texts.filter(|text| is_wgsl(text)).collect();
    let is_seen = |text: &String| {
        let part = |text: &str| Part {
            path: "part.wgsl".into(),
            text: text.into(),
        };
        let parts = [part(text), part("@compute @workgroup_size(64) fn main() {}")];
        let refusals = compile("kernel", &parts, Indices::Clamped).err().unwrap_or_default();
        refusals.iter().any(|refusal| refusal.rule == Rule::ExactFunctions)
    };
    let count = taken.len();
    (taken.into_iter().filter(|text| !is_seen(text)).collect(), count)
}

/// All texts of up to `most` of these characters.
fn texts(characters: &str, most: usize) -> Vec<String> {
    let mut all = vec![String::new()];
    let mut last = all.clone();
    for _ in 0..most {
        last = last
            .iter()
            .flat_map(|text| characters.chars().map(move |c| format!("{text}{c}")))
            .collect();
        all.extend(last.clone());
    }
    all
}

#[test]
fn calls_are_seen_whatever_is_before_their_brackets() {
    let ascii: String = (0..128_u8).map(char::from).collect();
    let between = texts(&ascii, 2).into_iter().chain(texts("/*\n\r \u{b}<>", 5));
    let (unseen, count) = unseen(between.map(|text| format!("const C = sin{text}(1.0f);")));
    assert!(unseen.is_empty(), "{unseen:?}");
    // Blanks and comments.
    assert!(count > 100, "{count}");
}

#[test]
fn calls_are_seen_whatever_is_before_their_names() {
    let before = texts("019.efhilpuxEPX_+-*/~!(<>&| \n", 3);
    let (unseen, count) = unseen(before.into_iter().map(|text| format!("const C = {text}sin(1.0f);")));
    assert!(unseen.is_empty(), "{unseen:?}");
    // Such as `0xE+` and `.1-`.
    assert!(count > 100, "{count}");
}

/// A blank that isn't ASCII shows that the tests above can fail.
#[test]
fn a_blank_that_is_not_ascii_hides_a_call() {
    let (unseen, count) = unseen(["const C = sin\u{200e}(1.0f);".to_owned()].into_iter());
    assert_eq!((unseen.len(), count), (1, 1));
}
