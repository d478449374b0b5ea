//! A controller as a C99 file.

use std::collections::BTreeSet;
use std::fmt::Write;

use oneiro_shader_compiler::c::{self, Memory};
use oneiro_shader_compiler::tree::{Program, Ty};

use super::{Controller, PERIOD, Recorded, State, Table};
use crate::parts::compose::{HEAD, Scalar};

/// A field of the state: its place in the words of a [`State`], its name and its type.
struct Field {
    word: usize,
    name: String,
    ty: Ty,
}

/// Prints a controller as a file that stands by itself. `name` begins all names in it; `origin` says where it is from; `cycles` are those
/// that it checks itself by.
pub fn c(controller: &Controller, name: &str, origin: &[String], cycles: &[Recorded]) -> String {
    let fields = fields(controller);
    let places = places(controller, &fields);
    let of_wheels = format!("{name}_wheels");
    let print = |program: &Program, tables: &[Table], name: &str| c::print(program, &buffers(tables, name, &places));
    let [begin, cycle] = [&controller.begin, &controller.cycle].map(|program| print(program, &controller.tables, name));
    let wheels = print(&controller.wheels, &controller.tables_of_wheels, &of_wheels);
    let tables = tables(&controller.tables, name) + &tables(&controller.tables_of_wheels, &of_wheels);
    let check = check(controller, name, &fields, cycles);
    let helpers = c::helpers(&format!("{begin}{cycle}{wheels}{check}"));
    let preamble = c::PREAMBLE;
    let head = head(controller, name, origin);
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
    for field in &fields {
        if HEAD[..3].contains(&field.name.as_str()) {
            let _ = writeln!(seeds, "    state->{0} = {0};", field.name);
        }
    }
    let period = (1000.0 * PERIOD).round();
    let text = format!(
        "{head}
{preamble}
{types}
/* Begins an episode. */
void {reset};

/* A cycle of {period} ms: from what the sensors read to the commands of the left and the right wheel, 0 to 1. */
void {name}_step({name}_state *state, const float *inputs, float *outputs);

/* The speeds of the left and the right wheel that outputs command, -1 to 1: fractions of {}. */
void {name}_wheels(const float *outputs, float *speeds);

/* 0 if recorded cycles have the same bits here, else the number of the first that differs, from 1. */
int {name}_check(void);

{helpers}{tables}void {reset}
{{
{seeds}{begin}}}

void {name}_step({name}_state *state, const float *inputs, float *outputs)
{{
{}{cycle}}}

void {name}_wheels(const float *outputs, float *speeds)
{{
{}{wheels}}}

{check}",
        full_speed(controller),
        unused(&cycle, "inputs"),
        unused(&wheels, "outputs"),
    );
    c::with_own_helpers(&text, name)
}

fn full_speed(controller: &Controller) -> String {
    match controller.full_speed {
        Some(speed) => format!("{speed} mm/s, the robot's full speed"),
        None => "the robot's full speed".to_owned(),
    }
}

/// Text that ends no comment.
fn comment(text: &str) -> String {
    text.replace("*/", "* /")
        .replace("/*", "/ *")
        .replace(['\r', '\n'], " ")
}

fn head(controller: &Controller, name: &str, origin: &[String]) -> String {
    let mut text = format!(
        "/* {name}: a controller ({}), made by Oneiro {}.\n",
        comment(&controller.kind),
        env!("CARGO_PKG_VERSION")
    );
    for line in origin {
        let _ = writeln!(text, " * {}", comment(line));
    }
    text += " *\n * Inputs, in order:\n";
    for (index, input) in controller.inputs.iter().enumerate() {
        let _ = writeln!(
            text,
            " *   {index}: {}, {}",
            comment(&input.name),
            comment(&input.about)
        );
    }
    text += " * Outputs: commands of the left and the right wheel, from 0, full speed backwards, to 1, full speed forwards.\n";
    text += " * Genes:\n";
    for (name, gene) in &controller.genes {
        let _ = writeln!(text, " *   {} = {gene:?}", comment(name));
    }
    text +=
        " *\n * Include this file where it is used, or compile it and declare its functions. It needs no library. */\n";
    text
}

/// The fields of the state: the number of the cycle, and the others that the controller asks for.
fn fields(controller: &Controller) -> Vec<Field> {
    let is_kept = [
        controller.draws(),
        controller.draws(),
        controller.asks_for_trial(),
        true,
    ];
    let head = HEAD.iter().zip(is_kept).enumerate();
    let mut taken: BTreeSet<String> = HEAD.iter().map(|name| (*name).to_owned()).collect();
    let mut fields: Vec<Field> = head
        .filter(|(_, (_, is_kept))| *is_kept)
        .map(|(word, (name, _))| Field {
            word,
            name: (*name).to_owned(),
            ty: Ty::U32,
        })
        .collect();
    for (at, (name, scalar)) in controller.memory.iter().enumerate() {
        // Names of WGSL may be words of C.
        let mut name = name.replace('.', "_");
        if KEYWORDS.split_whitespace().any(|word| word == name) || !name.is_ascii() {
            name = format!("memory_{at}");
        }
        while !taken.insert(name.clone()) {
            name += "_";
        }
        fields.push(Field {
            word: HEAD.len() + at,
            name,
            ty: match scalar {
                Scalar::Float => Ty::F32,
                Scalar::Unsigned => Ty::U32,
                Scalar::Signed => Ty::I32,
            },
        });
    }
    fields
}

/// Words of C and C++ that a field of a controller's memory may have as its name.
const KEYWORDS: &str = "alignas alignof and and_eq asm auto bitand bitor bool break case catch char class compl const constexpr continue \
                        decltype default delete do double dynamic_cast else enum explicit export extern false float for friend goto if \
                        inline int int32_t long mutable namespace new noexcept not not_eq nullptr operator or or_eq private protected \
                        public register restrict return short signed sizeof static static_assert struct switch template this \
                        thread_local throw true try typedef typeid typename uint32_t union unsigned using virtual void volatile wchar_t \
                        while xor xor_eq";

/// Names of the caller's words in the functions, and their types.
fn places(controller: &Controller, fields: &[Field]) -> Vec<(String, Ty)> {
    let mut places: Vec<(String, Ty)> = vec![(String::new(), Ty::U32); HEAD.len() + controller.memory.len()];
    for field in fields {
        places[field.word] = (format!("state->{}", field.name), field.ty);
    }
    places.extend((0..controller.inputs.len()).map(|input| (format!("inputs[{input}]"), Ty::F32)));
    places.extend(["outputs[0]", "outputs[1]", "speeds[0]", "speeds[1]"].map(|place| (place.to_owned(), Ty::F32)));
    places
}

/// The last buffer is the caller's.
fn buffers(tables: &[Table], name: &str, places: &[(String, Ty)]) -> Vec<Memory> {
    let table = |table: &Table| {
        let elements = (table.words.len() as u32).checked_div(table.stride).unwrap_or(0);
        Memory::Constants(format!("{name}_{}", name_of(table)), format!("{elements}u"))
    };
    let (_, others) = tables.split_last().expect("a kernel has buffers");
    others
        .iter()
        .map(table)
        .chain([Memory::Places(places.to_vec())])
        .collect()
}

fn name_of(table: &Table) -> &str {
    if table.name == "inputs" { "genes" } else { &table.name }
}

/// Tables that are read at places that vary.
fn tables(tables: &[Table], name: &str) -> String {
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
    let key = if controller.draws() {
        ", uint32_t key_0, uint32_t key_1"
    } else {
        ""
    };
    let trial = if controller.asks_for_trial() {
        ", uint32_t trial"
    } else {
        ""
    };
    format!("{name}_reset({name}_state *state{key}{trial})")
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
        let seeds = fields.iter().filter(|field| HEAD[..3].contains(&field.name.as_str()));
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
