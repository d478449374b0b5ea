//! WGSL that is generated for a part.

use std::fmt::Write;

use oneiro_shader_compiler::declarations::Declaration;

use super::fields::{GeneField, Remembered};
use super::interface::{Function, GENE_COUNT, Interface, MISSION};
use crate::parts::compose::{Detail, DetailKind, Kind, OF_EACH, Scalar, Value};

/// Declarations that a kernel needs and a part leaves out.
pub(super) fn missing(
    interface: &Interface,
    declared: &[Declaration],
    memory: &[Remembered],
    values: &[Value],
    readings: &[String],
) -> String {
    let (word, title) = (interface.kind.word(), interface.title);
    let mut text = String::new();
    let is_declared = |name: &str| declared.iter().any(|item| item.name == name);
    if is_declared(&format!("{title}State")) {
        let kept = memory.iter().map(|field| {
            let scalars: Vec<_> = field
                .scalars
                .iter()
                .map(|scalar| field.scalar.stored(&format!("memory.{scalar}")))
                .collect();
            format!("{}({})", field.ty, scalars.join(", "))
        });
        let kept = kept.collect::<Vec<_>>().join(", ");
        let _ = writeln!(
            text,
            "fn {word}_kept(memory: {title}State) -> {title}State {{ return {title}State({kept}); }}"
        );
    } else {
        // No struct is empty.
        let _ = writeln!(text, "struct {title}State {{ {UNUSED}: u32 }}");
        let _ = writeln!(
            text,
            "fn {word}_kept(memory: {title}State) -> {title}State {{ return memory; }}"
        );
    }
    // A part with a mission need not reward each robot.
    let default = |function: &Function| match function.default {
        None if is_declared(MISSION) && function.name() == OF_EACH => Some("return Reward(0.0f, before);"),
        default => default,
    };
    for function in interface.functions {
        if let Some(body) = default(function).filter(|_| !is_declared(function.name())) {
            let _ = writeln!(text, "{} {{ {body} }}", function.text);
        }
    }
    if !values.is_empty() {
        let first = interface.first_value();
        let _ = writeln!(text, "fn {word}_values(episode: Episode) -> {title}Values {{");
        let _ = writeln!(text, "    let first = worlds[episode.world].own_values + {first};");
        for cell in 0..values.len().div_ceil(4) {
            let _ = writeln!(text, "    let cell_{cell} = tables[first + {cell}u];");
        }
        let read = |index: usize| format!("bitcast<f32>(cell_{}.{})", index / 4, ["x", "y", "z", "w"][index % 4]);
        let list: Vec<_> = (0..values.len()).map(read).collect();
        let _ = writeln!(text, "    return {title}Values({});\n}}", list.join(", "));
    }
    match interface.kind {
        Kind::Sensor => text.push_str(&sensor(readings)),
        Kind::Controller => text.push_str(CONTROLLER),
        Kind::Task => {}
    }
    text
}

/// What stands between a user's controller and the kernel. Beyond an episode's own genes are those of others.
const CONTROLLER: &str = "\
fn gene(episode: Episode, index: u32) -> f32 {
    return bitcast<f32>(inputs[episode.genes + min(index, CONTROLLER_GENES - 1u) * LANES]);
}
fn commands(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let now = controller_cycle(episode, step, readings, before);
    return Command(vec2<f32>(limited(now.outputs.x, 0.0f, 1.0f), limited(now.outputs.y, 0.0f, 1.0f)), now.state);
}
";

/// Constants of named genes: the index of each field's first gene, and their number.
pub(super) fn gene_constants(genes: &[GeneField]) -> String {
    let (mut text, mut next) = (String::new(), "0u".to_owned());
    for gene in genes {
        let constant = gene.constant();
        let _ = writeln!(text, "const {constant}: u32 = {next};");
        let count = gene.count.as_deref().unwrap_or("1");
        next = format!("{constant} + u32({count})");
    }
    if !genes.is_empty() {
        let _ = writeln!(text, "const {GENE_COUNT}: u32 = {next};");
    }
    text
}

/// The field of a struct that a part doesn't declare: WGSL has no struct without a field.
pub(super) const UNUSED: &str = "unused";

/// The constant with the first cell of what an experiment gives its parts besides their values.
pub(super) const GIVEN_CELL: &str = "GIVEN_CELL";

/// Constants of a parametric robot.
pub(super) const COUNTS: [&str; 5] = ["FLOOR_CELL", "LIGHT_COUNT", "PATCH_COUNT", "PLANES", "DIFFERENCE_CELL"];

/// The function that `reading` declares.
pub(super) const READING: &str = "reading";

/// A reading by its index; beyond the last it is the last. `fields` are those of `Readings`, in order.
pub(super) fn reading(fields: &[String]) -> String {
    // A robot may have none.
    let first = fields
        .first()
        .map_or_else(|| "0.0f".to_owned(), |field| format!("readings.{field}"));
    let mut text = format!("fn {READING}(readings: Readings, index: u32) -> f32 {{\n    var reading = {first};\n");
    for (index, field) in fields.iter().enumerate().skip(1) {
        let _ = writeln!(
            text,
            "    reading = select(reading, readings.{field}, index >= {index}u);"
        );
    }
    text + "    return reading;\n}\n"
}

/// Numbers of a pose: x and y in mm, heading in turns.
const POSE: usize = 3;

/// Where reports stand before the genes of an episode: the readings, the pose at the start of an episode, and the pose at the end of
/// a cycle.
pub(super) fn reports(fields: &[String]) -> String {
    let count = fields.len();
    let mut text = format!(
        "const REPORTED_START: u32 = {count}u;
const REPORTED_END: u32 = {}u;
const REPORTS: u32 = {}u;
fn reported_readings(episode: Episode) -> Readings {{
    var readings = Readings();
",
        count + POSE,
        count + 2 * POSE
    );
    for (index, field) in fields.iter().enumerate() {
        let _ = writeln!(text, "    readings.{field} = report(episode, {index}u);");
    }
    text + "    return readings;\n}\n"
}

/// What stands between a user's sensors and the kernel.
fn sensor(readings: &[String]) -> String {
    let (mut bounded, mut sum) = (Vec::new(), String::new());
    for (index, name) in readings.iter().enumerate() {
        // A gene times a reading stays finite.
        bounded.push(format!("limited(now.readings.{name}, -1000.0f, 1000.0f)"));
        let _ = writeln!(sum, "    total += gene(episode, index + {index}u) * custom.{name};");
    }
    format!(
        "const OWN_READINGS: u32 = {}u;
fn sensors_read(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {{
    let now = sensor_cycle(episode, step, pose, before);
    return Sensed(SensorReadings({}), now.state);
}}
fn plus_weighed(episode: Episode, index: u32, custom: SensorReadings, sum: f32) -> f32 {{
    var total = sum;
{sum}    return total;
}}
",
        readings.len(),
        bounded.join(", "),
    )
}

/// The struct of a trace's details, and the functions that fill and store it.
pub(super) fn details(details: &[Detail]) -> String {
    // No struct is empty.
    let unused = [Detail {
        name: String::new(),
        kind: DetailKind::Real,
        scalar: Scalar::Unsigned,
        expression: "0u".into(),
    }];
    let details = if details.is_empty() { &unused } else { details };
    let member = |(index, detail): (usize, &Detail)| format!("    d{index}: {},\n", detail.scalar.wgsl());
    let members: String = details.iter().enumerate().map(member).collect();
    let now: Vec<_> = details.iter().map(|detail| detail.expression.as_str()).collect();
    let kept = |(index, detail): (usize, &Detail)| detail.scalar.stored(&format!("values.d{index}"));
    let kept: Vec<_> = details.iter().enumerate().map(kept).collect();
    format!(
        "struct Details {{
{members}}}
fn details(after: EpisodeState, real: Readings, perceived: Readings) -> Details {{
    return Details({});
}}
fn details_kept(values: Details) -> Details {{
    return Details({});
}}
",
        now.join(", "),
        kept.join(", "),
    )
}
