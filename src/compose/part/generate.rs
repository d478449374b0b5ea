//! WGSL that is generated for a part.

use std::fmt::Write;

use oneiro_shader_compiler::declarations::Declaration;

use super::interface::Interface;
use crate::compose::{Kind, Value};

/// Declarations that a kernel needs and a part leaves out.
pub(super) fn missing(
    interface: &Interface,
    declared: &[Declaration],
    kept: &[String],
    values: &[Value],
    readings: &[String],
) -> String {
    let (word, title) = (interface.kind.word(), interface.title);
    let mut text = String::new();
    let is_declared = |name: &str| declared.iter().any(|own| own.name == name);
    if is_declared(&format!("{title}State")) {
        let kept = kept.join(", ");
        let _ = writeln!(
            text,
            "fn {word}_kept(own: {title}State) -> {title}State {{ return {title}State({kept}); }}"
        );
    } else {
        // No struct is empty.
        let _ = writeln!(text, "struct {title}State {{ unused: u32 }}");
        let _ = writeln!(
            text,
            "fn {word}_kept(own: {title}State) -> {title}State {{ return own; }}"
        );
    }
    for function in interface.functions {
        if let Some(body) = function.default.filter(|_| !is_declared(function.name())) {
            let _ = writeln!(text, "{} {{ {body} }}", function.text);
        }
    }
    if !values.is_empty() {
        let first = interface.first_value();
        let _ = writeln!(text, "fn {word}_values(life: Life) -> {title}Values {{");
        let _ = writeln!(text, "    let first = worlds[life.world].own_values + {first};");
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

/// What stands between a user's controller and the kernel. Beyond a rollout's own genes are those of others.
const CONTROLLER: &str = "\
fn gene(life: Life, index: u32) -> f32 {
    return bitcast<f32>(inputs[life.genes + min(index, CONTROLLER_GENES - 1u) * LANES]);
}
fn commands(life: Life, step: u32, readings: Readings, before: ControllerState) -> Command {
    let now = controller_cycle(life, step, readings, before);
    return Command(vec2<f32>(limited(now.outputs.x, 0.0f, 1.0f), limited(now.outputs.y, 0.0f, 1.0f)), now.state);
}
";

/// What stands between a user's sensors and the kernel.
fn sensor(readings: &[String]) -> String {
    let (mut bounded, mut sum) = (Vec::new(), String::new());
    for (index, name) in readings.iter().enumerate() {
        // A gene times a reading stays finite.
        bounded.push(format!("limited(now.readings.{name}, -1000.0f, 1000.0f)"));
        let _ = writeln!(sum, "    total += gene(life, index + {index}u) * own.{name};");
    }
    format!(
        "const OWN_READINGS: u32 = {}u;
fn sensors_read(life: Life, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {{
    let now = sensor_cycle(life, step, pose, before);
    return Sensed(SensorReadings({}), now.state);
}}
fn plus_weighed(life: Life, index: u32, own: SensorReadings, sum: f32) -> f32 {{
    var total = sum;
{sum}    return total;
}}
",
        readings.len(),
        bounded.join(", "),
    )
}
