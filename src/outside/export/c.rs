//! A controller as a C99 file.

use std::fmt::Write;

use oneiro_shader_compiler::c;
use oneiro_shader_compiler::language;
use oneiro_shader_compiler::tree::{Program, Ty};

use super::pieces::{Field, buffers, fields, full_speed, head, is_seed, name_of, places};
use super::{Controller, PERIOD, Recorded, State, Table};

/// Prints a controller as a file that stands by itself. `name` begins all names in it; `origin` says where it is from; `cycles` are those
/// that it checks itself by.
pub fn c(controller: &Controller, name: &str, origin: &[String], cycles: &[Recorded]) -> String {
    let file = "Include this file where it is used, or compile it and declare its functions. It needs no library.";
    format!(
        "{}\n{}",
        comment(controller, name, origin, file),
        code(controller, name, cycles, "")
    )
}

/// The controller's code. `linkage` begins its functions.
pub(super) fn code(controller: &Controller, name: &str, cycles: &[Recorded], linkage: &str) -> String {
    let fields = fields(controller);
    let places = places(controller, &fields, &c::C, "state->");
    let of_wheels = format!("{name}_wheels");
    let print = |program: &Program, tables: &[Table], name: &str| {
        language::print(program, &c::C, &buffers(tables, name, &places), 1)
    };
    let [begin, cycle] = [&controller.begin, &controller.cycle].map(|program| print(program, &controller.tables, name));
    let wheels = print(&controller.wheels, &controller.tables_of_wheels, &of_wheels);
    let tables = tables(&controller.tables, name) + &tables(&controller.tables_of_wheels, &of_wheels);
    let check = linkage.to_owned() + &check(controller, name, &fields, cycles);
    let world = match &controller.simulator {
        Some(simulator) => simulator.c(controller, name),
        None => String::new(),
    };
    let helpers = c::helpers(&format!("{begin}{cycle}{wheels}{check}{world}"));
    let preamble = c::PREAMBLE;
    let types = types(controller, name, &fields);
    let reset = declaration_of_reset(controller, name);
    let unused = |body: &str, argument: &str| {
        let used = body.contains(&format!("{argument}[")) || body.contains(&format!("{argument}->"));
        if used {
            String::new()
        } else {
            format!("    (void){argument};\n")
        }
    };
    let mut seeds = String::new();
    for field in fields.iter().filter(|field| is_seed(field)) {
        let _ = writeln!(seeds, "    state->{0} = {0};", field.name);
    }
    let period = (1000.0 * PERIOD).round();
    let text = format!(
        "{preamble}
{types}
/* Begins an episode. */
{linkage}void {reset};

/* A cycle of {period} ms: from what the sensors read to the commands of the left and the right wheel, 0 to 1. */
{linkage}void {name}_step({name}_state *state, const float *inputs, float *outputs);

/* The speeds of the left and the right wheel that outputs command, -1 to 1: fractions of {}. */
{linkage}void {name}_wheels(const float *outputs, float *speeds);

/* 0 if recorded cycles have the same bits here, else the number of the first that differs, from 1. */
{linkage}int {name}_check(void);

{helpers}{tables}{linkage}void {reset}
{{
{seeds}{begin}}}

{linkage}void {name}_step({name}_state *state, const float *inputs, float *outputs)
{{
{}{cycle}}}

{linkage}void {name}_wheels(const float *outputs, float *speeds)
{{
{}{wheels}}}

{check}{world}",
        full_speed(controller),
        unused(&cycle, "inputs"),
        unused(&wheels, "outputs"),
    );
    c::with_own_helpers(&text, name)
}

/// The comment at the top; its last words say what to do with the file.
pub(super) fn comment(controller: &Controller, name: &str, origin: &[String], file: &str) -> String {
    let mut text = String::new();
    for (index, line) in head(controller, name, origin).iter().enumerate() {
        let line = line.replace("*/", "* /").replace("/*", "/ *");
        let begin = if index == 0 { "/*" } else { " *" };
        let _ = writeln!(text, "{}", format!("{begin} {line}").trim_end());
    }
    text + " *\n * " + file + " */\n"
}

/// Tables that are read at places that vary.
pub(super) fn tables(tables: &[Table], name: &str) -> String {
    let mut text = String::new();
    for table in tables.iter().filter(|table| !table.words.is_empty()) {
        let _ = writeln!(
            text,
            "static const uint32_t {name}_{}[{}] ONEIRO_FLASH = {{",
            name_of(table),
            table.words.len()
        );
        for words in table.words.chunks(8) {
            let words: Vec<_> = words.iter().map(|word| format!("0x{word:08x}u")).collect();
            let _ = writeln!(text, "    {},", words.join(", "));
        }
        text += "};\n\n";
    }
    text
}

fn types(controller: &Controller, name: &str, fields: &[Field]) -> String {
    let mut text = format!(
        "enum {{\n    {name}_INPUTS = {},\n    {name}_OUTPUTS = 2,\n    {name}_PERIOD_MS = {},\n    {name}_STATE_BYTES = {}\n}};\n\n",
        controller.inputs.len(),
        (1000.0 * PERIOD).round(),
        4 * fields.len()
    );
    text += "/* What it keeps from cycle to cycle. */\ntypedef struct {\n";
    for Field { name, ty, .. } in fields {
        let _ = writeln!(text, "    {} {name};", c::type_name(*ty));
    }
    let _ = writeln!(
        text,
        "}} {name}_state;\n\ntypedef char {name}_state_has_its_size[sizeof({name}_state) == {name}_STATE_BYTES ? 1 : -1];"
    );
    text
}

/// Whoever draws random numbers begins with a key.
fn declaration_of_reset(controller: &Controller, name: &str) -> String {
    let arguments = arguments_of_reset(controller).replace(", ", ", uint32_t ");
    format!("{name}_reset({name}_state *state{arguments})")
}

/// What an episode begins with, each after a comma.
pub(super) fn arguments_of_reset(controller: &Controller) -> String {
    let key = if controller.draws() { ", key_0, key_1" } else { "" };
    let trial = if controller.asks_for_trial() { ", trial" } else { "" };
    format!("{key}{trial}")
}

fn state(state: &State, fields: &[Field]) -> String {
    let words: Vec<_> = fields
        .iter()
        .map(|field| c::constant(state.0[field.word], field.ty))
        .collect();
    format!("{{{}}}", words.join(", "))
}

fn numbers(numbers: &[f32]) -> String {
    let numbers: Vec<_> = numbers
        .iter()
        .map(|number| c::constant(number.to_bits(), Ty::F32))
        .collect();
    format!("{{{}}}", numbers.join(", "))
}

/// The function that runs recorded cycles, and compares the bits.
fn check(controller: &Controller, name: &str, fields: &[Field], cycles: &[Recorded]) -> String {
    let mut text = format!(
        "int {name}_check(void)
{{
    static const struct {name}_recorded {{
        {name}_state before;
        float inputs[{}];
        float outputs[2];
        {name}_state after;
    }} cycles[{}] ONEIRO_FLASH = {{
",
        controller.inputs.len().max(1),
        cycles.len()
    );
    for cycle in cycles {
        let readings = if cycle.readings.is_empty() {
            &[0.0][..]
        } else {
            &cycle.readings
        };
        let _ = writeln!(
            text,
            "        {{{}, {}, {}, {}}},",
            state(&cycle.before, fields),
            numbers(readings),
            numbers(&cycle.outputs),
            state(&cycle.after, fields)
        );
    }
    let _ = writeln!(
        text,
        "    }};
    struct {name}_recorded cycle;
    {name}_state state;
    float outputs[2];
    int i;
    for (i = 0; i < {}; i++) {{
#ifdef __AVR__
        memcpy_P(&cycle, &cycles[i], sizeof cycle);
#else
        cycle = cycles[i];
#endif
        state = cycle.before;",
        cycles.len()
    );
    let differ = |a: &str, b: &str, ty: Ty| match ty {
        Ty::F32 => format!("bits_of({a}) != bits_of({b})"),
        _ => format!("{a} != {b}"),
    };
    if let Some(first) = cycles.first().filter(|cycle| cycle.before.cycle() == 0) {
        let seeds = fields.iter().filter(|field| is_seed(field));
        let arguments = seeds.fold(String::new(), |all, field| {
            all + ", " + &c::constant(first.before.0[field.word], Ty::U32)
        });
        let _ = writeln!(
            text,
            "        if (i == 0) {{\n            {name}_reset(&state{arguments});\n        }}"
        );
    }
    let _ = writeln!(text, "        {name}_step(&state, cycle.inputs, outputs);");
    let outputs = (0..2).map(|output| {
        differ(
            &format!("outputs[{output}]"),
            &format!("cycle.outputs[{output}]"),
            Ty::F32,
        )
    });
    let states = fields
        .iter()
        .map(|Field { name, ty, .. }| differ(&format!("state.{name}"), &format!("cycle.after.{name}"), *ty));
    for differ in outputs.chain(states) {
        let _ = writeln!(text, "        if ({differ}) {{\n            return i + 1;\n        }}");
    }
    text += "    }\n    return 0;\n}\n";
    text
}
