//! A controller as a C++ header with a class around its C, and as an Arduino library.

use super::c::{code, comment};
use super::pieces::{fields, is_seed};
use super::{Controller, Recorded};

/// Prints a controller as a C++ header, which may be included in several files.
pub fn cpp(controller: &Controller, name: &str, origin: &[String], cycles: &[Recorded]) -> String {
    let seeds: Vec<String> = fields(controller)
        .into_iter()
        .filter(is_seed)
        .map(|field| field.name)
        .collect();
    let parameters: Vec<_> = seeds.iter().map(|seed| format!("uint32_t {seed}")).collect();
    let parameters = parameters.join(", ");
    let explicit = if seeds.is_empty() { "" } else { "explicit " };
    let arguments = seeds.join(", ");
    let of_state = seeds.iter().fold(String::new(), |all, seed| all + ", " + seed);
    let guard = format!("{}_HPP", name.to_uppercase());
    let head = comment(controller, name, origin, "Include this header. It needs no library.");
    let code = code(controller, name, cycles, "static inline ");
    format!(
        "{head}
#ifndef {guard}
#define {guard}

/* What the code below asks of GCC holds for nothing else. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC push_options
#endif
{code}
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC pop_options
#endif

/* The controller with its state. */
class {name} {{
public:
    enum {{ INPUTS = {name}_INPUTS, OUTPUTS = {name}_OUTPUTS, PERIOD_MS = {name}_PERIOD_MS }};

    {explicit}{name}({parameters}) {{ reset({arguments}); }}

    /* Begins an episode. */
    void reset({parameters}) {{ {name}_reset(&state{of_state}); }}

    /* A cycle: from what the sensors read to the commands of the left and the right wheel, 0 to 1. */
    void step(const float *inputs, float *outputs) {{ {name}_step(&state, inputs, outputs); }}

    /* The speeds of the left and the right wheel that outputs command, -1 to 1. */
    static void wheels(const float *outputs, float *speeds) {{ {name}_wheels(outputs, speeds); }}

    /* 0 if recorded cycles have the same bits here, else the number of the first that differs, from 1. */
    static int check() {{ return {name}_check(); }}

private:
    {name}_state state;
}};

#endif
"
    )
}

/// Prints a controller as an Arduino library with an example.
pub fn arduino(controller: &Controller, name: &str, origin: &[String], cycles: &[Recorded]) -> Vec<(String, String)> {
    let seeds: Vec<_> = fields(controller).into_iter().filter(is_seed).map(|_| "0").collect();
    let arguments = if seeds.is_empty() {
        String::new()
    } else {
        format!("({})", seeds.join(", "))
    };
    let properties = format!(
        "name={name}
version={}
author=Oneiro
maintainer=Oneiro
sentence=A robot's controller, evolved in simulation.
paragraph=It has the bits of the simulator: {name}::check() compares them.
category=Device Control
url=
architectures=*
",
        env!("CARGO_PKG_VERSION")
    );
    let sketch = format!(
        "#include <{name}.h>

{name} controller{arguments};
unsigned long next_cycle;

void setup() {{
    Serial.begin(115200);
    // 0 if this board has the bits of the simulator.
    Serial.println({name}::check());
    next_cycle = millis();
}}

// Replace it: reads your sensors, in the order that {name}.h lists, in the same units.
void read_sensors(float *inputs) {{
    for (int i = 0; i < {name}::INPUTS; i++) {{
        inputs[i] = 0.0f;
    }}
}}

// Replace it: drives your wheels at these fractions of full speed, -1 to 1.
void drive(float left, float right) {{
    Serial.print(left);
    Serial.print(' ');
    Serial.println(right);
}}

void loop() {{
    if ((long)(millis() - next_cycle) < 0) {{
        return;
    }}
    next_cycle += {name}::PERIOD_MS;
    float inputs[{name}::INPUTS + 1], outputs[2], speeds[2];
    read_sensors(inputs);
    controller.step(inputs, outputs);
    {name}::wheels(outputs, speeds);
    drive(speeds[0], speeds[1]);
}}
"
    );
    vec![
        ("library.properties".to_owned(), properties),
        (format!("src/{name}.h"), cpp(controller, name, origin, cycles)),
        (format!("examples/{name}/{name}.ino"), sketch),
    ]
}
