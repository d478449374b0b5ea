//! A controller as an object in languages that have some: a file is a text with places to fill in, and the functions that its code calls.

use std::collections::BTreeSet;

use oneiro_shader_compiler::language::{self, Language};
use oneiro_shader_compiler::tree::{Program, Ty};

use super::pieces::{buffers, fields, full_speed, head, is_seed, name_of, places};
use super::rust::{Rust, type_name};
use super::scripts::Dynamic;
use super::{Controller, PERIOD, Recorded, State, Table};

/// How a file in a language is written.
struct Manner {
    language: &'static dyn Language,
    /// The file. Names between `@` are filled in.
    file: &'static str,
    /// Functions for its code, each after those that it calls, with an empty line between them. The first word of each that has a `(`
    /// behind it is its name.
    helpers: &'static str,
    comment: &'static str,
    /// What begins the names of the state's fields.
    state: &'static str,
    /// How deep statements of functions are.
    depth: usize,
    /// A table of words.
    table: fn(&str, &[String]) -> String,
    /// A recorded cycle.
    row: fn(&[String]) -> String,
    /// A parameter, and a field of the state with its first value, in a line.
    parameter: fn(&str) -> String,
    field: fn(&str, Ty) -> String,
}

/// Prints a controller as a Rust module, without the standard library.
pub fn rust(controller: &Controller, name: &str, origin: &[String], cycles: &[Recorded]) -> String {
    let manner = Manner {
        language: &Rust,
        file: include_str!("objects/rust.txt"),
        helpers: include_str!("objects/rust-helpers.txt"),
        comment: "//!",
        state: "self.",
        depth: 2,
        table: |name, words| format!("static {name}: [u32; {}] = [{}];\n", words.len(), lines(words)),
        row: |words| format!("    [{}],\n", words.join(", ")),
        parameter: |name| format!("{name}: u32"),
        field: |name, ty| format!("    {name}: {},\n", type_name(ty)),
    };
    manner.print(controller, name, origin, cycles)
}

/// Prints a controller as a JavaScript module.
pub fn javascript(controller: &Controller, name: &str, origin: &[String], cycles: &[Recorded]) -> String {
    let manner = Manner {
        language: &Dynamic::JavaScript,
        file: include_str!("objects/javascript.txt"),
        helpers: include_str!("objects/javascript-helpers.txt"),
        comment: "//",
        state: "this.",
        depth: 2,
        table: |name, words| format!("const {name} = [{}];\n", lines(words)),
        row: |words| format!("    [{}],\n", words.join(", ")),
        parameter: str::to_owned,
        field: |_, _| String::new(),
    };
    manner.print(controller, name, origin, cycles)
}

/// Prints a controller as a Python module without packages.
pub fn python(controller: &Controller, name: &str, origin: &[String], cycles: &[Recorded]) -> String {
    let manner = Manner {
        language: &Dynamic::Python,
        file: include_str!("objects/python.txt"),
        helpers: include_str!("objects/python-helpers.txt"),
        comment: "#",
        state: "self.",
        depth: 2,
        table: |name, words| format!("{name} = ({},)\n", lines(words)),
        row: |words| format!("    ({},),\n", words.join(", ")),
        parameter: str::to_owned,
        field: |_, _| String::new(),
    };
    let text = manner.print(controller, name, origin, cycles);
    // Its constants by their bits.
    let mut constants = BTreeSet::new();
    for piece in text.split("k_").skip(1) {
        if let Some(bits) = piece.get(..8).and_then(|bits| u32::from_str_radix(bits, 16).ok()) {
            constants.insert(bits);
        }
    }
    let constants = constants.iter().fold(String::new(), |all, bits| {
        let x = f32::from_bits(*bits);
        all + &format!("k_{bits:08x} = number_of(0x{bits:08x})  # {x:?}\n")
    });
    text.replace("@constants@", &constants)
}

/// Prints a controller as a Lua module, for Lua 5.1 and newer.
pub fn lua(controller: &Controller, name: &str, origin: &[String], cycles: &[Recorded]) -> String {
    let manner = Manner {
        language: &Dynamic::Lua,
        file: include_str!("objects/lua.txt"),
        helpers: include_str!("objects/lua-helpers.txt"),
        comment: "--",
        state: "self.",
        depth: 1,
        table: |name, words| format!("local {name} = {{{}}}\n", lines(words)),
        row: |words| format!("    {{{}}},\n", words.join(", ")),
        parameter: str::to_owned,
        field: |_, _| String::new(),
    };
    manner.print(controller, name, origin, cycles)
}

/// Words of a table, eight in a line.
fn lines(words: &[String]) -> String {
    let lines: Vec<_> = words.chunks(8).map(|words| words.join(", ")).collect();
    format!("\n    {}\n", lines.join(",\n    "))
}

impl Manner {
    fn print(&self, controller: &Controller, name: &str, origin: &[String], cycles: &[Recorded]) -> String {
        let language = self.language;
        let fields = fields(controller);
        let mut places = places(controller, &fields, language, self.state);
        let printed = |program: &Program, tables: &[Table], name: &str, places: &[(String, Ty)], depth| {
            language::print(program, language, &buffers(tables, name, places), depth)
        };
        let wheels = printed(
            &controller.wheels,
            &controller.tables_of_wheels,
            "wheels",
            &places,
            self.depth,
        );
        let begin = printed(&controller.begin, &controller.tables, "table", &places, self.depth);
        // Numbers of such languages are doubles: what the caller has read is rounded.
        let is_single = |place: &str| place.starts_with("inputs[") && self.comment != "//!";
        for (place, _) in places.iter_mut().filter(|(place, _)| is_single(place)) {
            *place = format!("f({place})");
        }
        let cycle = printed(&controller.cycle, &controller.tables, "table", &places, self.depth);
        let indent = " ".repeat(4 * self.depth);
        let all = |line: &dyn Fn(usize) -> String| {
            (0..fields.len()).fold(String::new(), |text, field| text + &indent + &line(field) + "\n")
        };
        let place = |field: usize| format!("{}{}", self.state, fields[field].name);
        let word = |field: usize| language.element("words", &field.to_string());
        let seeds: Vec<_> = fields.iter().filter(|field| is_seed(field)).collect();
        let listed = |text: &dyn Fn(&str) -> String| {
            let texts: Vec<_> = seeds.iter().map(|seed| text(&seed.name)).collect();
            texts.join(", ")
        };
        let first = cycles.first().filter(|cycle| cycle.before.cycle() == 0);
        let of_first = |seed: &&super::pieces::Field| first.map_or(0, |first| first.before.0[seed.word]).to_string();
        let tables: String = [("table", &controller.tables), ("wheels", &controller.tables_of_wheels)]
            .iter()
            .flat_map(|(name, tables)| tables.iter().map(move |table| (name, table)))
            .filter(|(_, table)| !table.words.is_empty())
            .map(|(name, table)| {
                let words: Vec<_> = table.words.iter().map(u32::to_string).collect();
                (self.table)(&format!("{name}_{}", name_of(table)), &words) + "\n"
            })
            .collect();
        let rows: String = cycles
            .iter()
            .map(|cycle| {
                let state = |state: &State| fields.iter().map(|field| state.0[field.word]).collect::<Vec<_>>();
                let numbers = |numbers: &[f32]| numbers.iter().map(|number| number.to_bits()).collect::<Vec<_>>();
                let words = [
                    state(&cycle.before),
                    numbers(&cycle.readings),
                    numbers(&cycle.outputs),
                    state(&cycle.after),
                ];
                (self.row)(&words.concat().iter().map(u32::to_string).collect::<Vec<_>>())
            })
            .collect();
        let head = head(controller, name, origin).iter().fold(String::new(), |text, line| {
            text + format!("{} {line}", self.comment).trim_end() + "\n"
        });
        let filled = [
            ("inputs", controller.inputs.len().to_string()),
            ("period", (1000.0 * PERIOD).round().to_string()),
            ("full speed", full_speed(controller)),
            (
                "fields",
                fields.iter().map(|field| (self.field)(&field.name, field.ty)).collect(),
            ),
            ("count", fields.len().to_string()),
            ("cycles", cycles.len().to_string()),
            (
                "zeros",
                all(&|field| format!("{}: {},", fields[field].name, language.constant(0, fields[field].ty))),
            ),
            ("parameters", listed(&self.parameter)),
            (
                "more parameters",
                listed(&|seed| format!(", {}", (self.parameter)(seed))).replace(", , ", ", "),
            ),
            ("arguments", listed(&str::to_owned)),
            (
                "seeds",
                seeds.iter().fold(String::new(), |text, seed| {
                    let set = language.assignment(&format!("{}{}", self.state, seed.name), &seed.name);
                    text + &indent + &set + "\n"
                }),
            ),
            ("begin", begin),
            ("cycle", cycle),
            ("wheels", wheels),
            (
                "words",
                all(&|field| language.bitcast(fields[field].ty, Ty::U32, &place(field)) + ","),
            ),
            (
                "restored",
                all(&|field| {
                    language.assignment(
                        &place(field),
                        &language.bitcast(Ty::U32, fields[field].ty, &word(field)),
                    )
                }),
            ),
            ("first seeds", seeds.iter().map(of_first).collect::<Vec<_>>().join(", ")),
            ("is first", language.constant(u32::from(first.is_some()), Ty::Bool)),
            ("tables", tables),
            ("rows", rows),
            ("head", head),
        ];
        let mut text = self.file.to_owned();
        for (place, content) in &filled {
            text = text.replace(&format!("@{place}@"), content);
        }
        let helpers = self.helpers(&text);
        text.replace("@helpers@", &helpers)
    }

    /// The functions that code calls.
    fn helpers(&self, code: &str) -> String {
        let mut all = String::new();
        for helper in self.helpers.split("\n\n").collect::<Vec<_>>().into_iter().rev() {
            let (before, _) = helper.split_once('(').expect("it has parameters");
            let before = before.trim_end_matches([' ', '=']);
            let name = before.rsplit([' ', '\n']).next().unwrap_or_default();
            let call = format!("{name}(");
            if code.contains(&call) || all.contains(&call) {
                all = format!("{}\n\n{all}", helper.trim_end());
            }
        }
        all
    }
}
