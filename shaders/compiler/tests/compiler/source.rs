//! Messages name the part, the line and the column.

use oneiro_shader_compiler::{Indices, Part, Source, compile};

fn parts(texts: &[&str]) -> Vec<Part> {
    let part = |(at, text): (usize, &&str)| Part {
        path: format!("part_{at}"),
        text: (*text).into(),
    };
    texts.iter().enumerate().map(part).collect()
}

#[test]
fn bytes_map_to_lines_of_parts() {
    // A part may be empty, or end without a line break.
    let source = Source::new(&parts(&["a\nb\n", "", "c", "\nd\n"]));
    assert_eq!(source.text, "a\nb\n\nc\n\nd\n");
    let places: Vec<_> = (0..=source.text.len())
        .map(|byte| source.place(byte).to_string())
        .collect();
    assert_eq!(
        places,
        [
            "part_0:1:1",
            "part_0:1:2",
            "part_0:2:1",
            "part_0:2:2",
            "part_1:1:1",
            "part_2:1:1",
            "part_2:1:2",
            "part_3:1:1",
            "part_3:2:1",
            "part_3:2:2",
            "part_3:3:1"
        ]
    );
    assert_eq!(source.place(1000), source.place(source.text.len()));
}

#[test]
fn names_of_several_bytes_do_not_shift_lines() {
    let main = "// é∑\n@compute @workgroup_size(64)\nfn main() {\n    /* é\n */ let é = sin(1.0f);\n}";
    let refusals = compile("kernel", &parts(&["// ü\n", main]), Indices::Clamped).unwrap_err();
    assert_eq!(refusals.len(), 1);
    assert_eq!(refusals[0].place.to_string(), "part_1:5:13");
}

#[test]
fn each_stage_names_the_part() {
    let main = "@compute @workgroup_size(64)\nfn main(@builtin(local_invocation_index) lane: u32) {}\n";
    for (part, problem) in [
        (
            "// the text\nfn f() {\n    _ = quantizeToF16(1.0f);\n}",
            "quantizeToF16",
        ),
        ("// the parser\nfn f() {\n    let x = ;\n}", "expected expression"),
        (
            "// the types\nfn f() {\n    var x = 1u; x = 1.0f;\n}",
            "the value is f32",
        ),
        ("// the IR\nfn f() -> f32 {\n    return 1e-40;\n}", "subnormal"),
    ] {
        let refusals = compile("kernel", &parts(&["const one = 1u;\n", part, main]), Indices::Clamped).unwrap_err();
        let refusal = refusals[0].to_string();
        assert!(
            refusal.starts_with("part_1:3:") && refusal.contains(problem),
            "{refusal}"
        );
    }
}
