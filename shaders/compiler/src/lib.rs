//! Compiles an exact subset of WGSL to SPIR-V, Rust lane code, C and host structs: the kernels that ship when Oneiro is built,
//! and those with a user-defined task at run time.
//!
//! A kernel is a list of parts ([`Part`]), concatenated. [`compile`] parses and validates it, refuses everything that could
//! give other bits on another device, and writes these forms. [`trees`] stops at the program from which lane code is
//! printed, so that machine code can be made from it.

mod assemble;
pub mod bounds;
pub mod c;
pub mod count;
pub mod declarations;
mod exact;
mod explain;
mod front;
pub mod generate;
mod hoist;
pub mod instances;
pub mod interpret;
mod isolation;
pub mod language;
mod layout;
mod lower;
mod ordinary;
mod print;
mod rules;
mod source;
pub mod specialise;
pub mod spirv;
mod syntax;
mod tidy;
pub mod tree;
pub mod uniform;
mod unroll;
mod words;

use std::collections::BTreeSet;

pub use bounds::Bound;
pub use exact::{GREATEST_LOCAL, check_part};
pub use isolation::{Allowed, Isolation};
pub use layout::{Binding, Constant};
pub use rules::Rule;
pub use source::{Part, Place, Refusal, Refusals, Source};
pub use spirv::Indices;
pub use tidy::{remove_unused, rename};

/// Largest number of lanes of any instance.
const LANES: u32 = 64;

/// A kernel's forms: SPIR-V, Rust lane code, and host structs.
#[derive(Clone, Debug)]
pub struct Compiled {
    /// Paths of its parts, in order.
    pub parts: Vec<String>,
    /// Joined WGSL.
    pub wgsl: String,
    /// SPIR-V words.
    pub spirv: Vec<u32>,
    /// Host structs as Rust items, or the reasons why a buffer's struct has no layout in Rust.
    pub structs: Result<String, Refusals>,
    /// Constants of its module.
    pub constants: Vec<Constant>,
    /// Buffers that it binds, in ascending order.
    pub bindings: Vec<Binding>,
    /// Invocations per workgroup.
    pub workgroup_size: u32,
    /// Lane function in Rust.
    pub lanes: String,
    /// Upper bound of the turns of its loops, or the loops that nothing bounds: see [`Compiled::bounded`].
    pub turns: Result<Bound, Refusals>,
    /// What would be refused if anything used it: see [`Compiled::used`].
    pub unused: Refusals,
}

impl Compiled {
    /// Refuses a kernel in which a local array has an index that differs between episodes, whose element nothing uses yet.
    ///
    /// # Errors
    /// A refusal for each of these indices.
    pub fn used(self) -> Result<Self, Refusals> {
        if self.unused.is_empty() {
            Ok(self)
        } else {
            Err(self.unused)
        }
    }

    /// Refuses a kernel with loops that nothing bounds. No kernel that ships has any.
    ///
    /// # Errors
    /// A refusal for each of these loops.
    pub fn bounded(self) -> Result<Self, Refusals> {
        match self.turns {
            Ok(_) => Ok(self),
            Err(refusals) => Err(refusals),
        }
    }
}

/// A kernel's program, before and after it is tidied, with the results of the analyses.
#[derive(Clone, Debug)]
pub struct Trees {
    /// The lowered program. Tests compare the tidied one with it.
    pub raw: tree::Program,
    /// Tidied program, from which code is made.
    pub tidied: tree::Program,
    /// Uniformity of the tidied program's values.
    pub shapes: uniform::Shapes,
    /// Words per element of each buffer.
    pub strides: Vec<u32>,
    /// Names of the buffers.
    pub buffers: Vec<String>,
    /// Upper bound of the turns of its loops, or the loops that nothing bounds.
    pub turns: Result<Bound, Refusals>,
    /// What would be refused if anything used it.
    pub unused: Refusals,
    /// Its text.
    pub source: Source,
}

impl Trees {
    /// Places of a value of the raw program: its own, and then those of the calls around it, the innermost first.
    pub fn places(&self, value: tree::Value) -> impl Iterator<Item = Place> {
        self.source.places(&self.raw, value)
    }

    /// Bytes of the local arrays of one invocation: those of each call of a function, whose elements have a word each.
    pub fn array_bytes(&self) -> u64 {
        let words: usize = self.tidied.arrays.iter().map(|array| array.init.len()).sum();
        words as u64 * 4
    }

    /// Refuses arrays for which a processor's stack has no room, even if few invocations run side by side.
    fn check_arrays(&self) -> Result<(), Refusals> {
        let bytes = self.array_bytes();
        let largest = self.tidied.arrays.iter().max_by_key(|array| array.init.len());
        match largest {
            Some(largest) if bytes > u64::from(GREATEST_LOCAL) => Err(vec![Refusal {
                place: self.source.place_of(largest.span),
                function: None,
                rule: Rule::LargeVariable,
                message: format!(
                    "the arrays of all functions, counted again at each call, take {bytes} bytes; allowed: {GREATEST_LOCAL}. `{}` is \
                     the largest",
                    largest.name
                ),
            }]),
            _ => Ok(()),
        }
    }

    /// Lane function in Rust, for one [instance](instances).
    pub fn lanes(&self, name: &str) -> String {
        print::print(&self.tidied, &self.shapes, name, &self.strides)
    }
}

/// Compiles a kernel. `indices` are those of its SPIR-V; its other forms keep any index within its buffer.
///
/// # Errors
/// Everything that is refused, with its place.
pub fn compile(name: &str, parts: &[Part], indices: Indices) -> Result<Compiled, Refusals> {
    compile_isolated(name, parts, indices, &Isolation::default())
}

/// Compiles a kernel in which some parts are users'.
///
/// # Errors
/// As [`compile`]; and whatever a user's part does by which it could reach another episode.
pub fn compile_isolated(
    name: &str,
    parts: &[Part],
    indices: Indices,
    isolation: &Isolation<'_>,
) -> Result<Compiled, Refusals> {
    let checked = Checked::new(parts, isolation)?;
    let trees = checked.trees()?;
    trees.check_arrays()?;
    let lanes = trees.lanes(name);
    let Trees { turns, unused, .. } = trees;
    let Checked { source, module, info } = &checked;
    let refuse = |message: String| refused(source, Rule::Internal, message);
    let bindings = layout::bindings(module).map_err(refuse)?;
    let written = Source::new(parts);
    Ok(Compiled {
        parts: written.paths(),
        wgsl: written.text,
        spirv: spirv::write(module, info, indices).map_err(refuse)?,
        structs: layout::structs(module).map_err(refuse),
        constants: layout::constants(module),
        bindings,
        workgroup_size: module.entry_points[0].workgroup_size[0],
        lanes,
        turns,
        unused,
    })
}

/// What [`compile_isolated`] refuses by a kernel's compiled form, whatever its text looks like.
///
/// # Errors
/// A kernel that naga doesn't parse, or all that is refused.
pub fn check_compiled(parts: &[Part], isolation: &Isolation<'_>) -> Result<(), Refusals> {
    let source = Source::new(parts);
    let (checked, refusals) = Checked::parsed(&source, isolation).map_err(|refusal| vec![refusal])?;
    if !refusals.is_empty() {
        return Err(in_order(refusals, &source));
    }
    let trees = checked.trees()?;
    trees.check_arrays()?;
    trees.turns.map(|_| ())
}

/// Lowers, tidies and analyses a kernel.
///
/// # Errors
/// As [`compile`].
pub fn trees(parts: &[Part]) -> Result<Trees, Refusals> {
    Checked::new(parts, &Isolation::default())?.trees()
}

/// A kernel from which variants for certain worlds are made.
#[derive(Clone, Debug)]
pub struct Generic {
    checked: Checked,
    raw: tree::Program,
    /// Buffers that it binds, in ascending order.
    pub bindings: Vec<Binding>,
}

impl Generic {
    /// Parses and lowers a kernel.
    ///
    /// # Errors
    /// As [`compile`].
    pub fn new(parts: &[Part]) -> Result<Self, Refusals> {
        let checked = Checked::new(parts, &Isolation::default())?;
        let Checked { source, module, info } = &checked;
        let bindings = layout::bindings(module).map_err(|message| refused(source, Rule::Internal, message))?;
        let raw = lower::lower(source, module, info)?;
        Ok(Self { checked, raw, bindings })
    }

    /// The program for any world.
    pub fn any(&self) -> &tree::Program {
        &self.raw
    }

    /// The program for what is known of the buffers.
    pub fn program(&self, known: &specialise::Known<'_>) -> tree::Program {
        specialise::specialise(&self.raw, known)
    }

    /// The kernel with its loops unrolled, so that all of them turn at most `most` times in both of two cases, which are given by words of
    /// buffers; and the most turns in each. `None` if it would get too long.
    pub fn unrolled(&self, cases: [&bounds::WordOf<'_>; 2], most: u64) -> Option<(Self, [u64; 2])> {
        let buffers = buffers_of(&self.bindings);
        let (_, loops) = bounds::bounds(&self.raw, &buffers, &self.checked.source).ok()?;
        let unroll::Unrolled { program, turns } = unroll::unroll(&self.raw, &unroll::turns(&loops, cases), most)?;
        let unrolled = Self {
            raw: program,
            ..self.clone()
        };
        Some((unrolled, turns))
    }

    /// Places of a value of a program of this kernel: its own, and then those of the calls around it, the innermost first.
    pub fn places(&self, program: &tree::Program, value: tree::Value) -> Vec<Place> {
        self.checked.source.places(program, value).collect()
    }

    /// A program of this kernel tidied and analysed, from which lane code is made.
    ///
    /// # Errors
    /// A mistake of this compiler.
    pub fn trees(&self, program: tree::Program) -> Result<Trees, Refusals> {
        self.checked.trees_of(program)
    }

    /// A program of this kernel for one lane, from which C is printed.
    pub fn alone(&self, mut program: tree::Program) -> tree::Program {
        c::compare_limits(&mut program);
        tidy::take_constant_branches(&mut program);
        tidy::carry_values_out(&mut program);
        remove_unused(&mut program);
        tidy::sink_declarations(&mut program);
        tidy::part_variables(&mut program);
        remove_unused(&mut program);
        program
    }

    /// SPIR-V of a program of this kernel.
    ///
    /// # Errors
    /// A mistake of this compiler or of naga.
    pub fn spirv(&self, program: &tree::Program, indices: Indices) -> Result<Vec<u32>, String> {
        let module = assemble::module(program, &self.checked.module)?;
        let info = front::validate(&module).map_err(|error| format!("{:?}", error.into_inner()))?;
        spirv::write(&module, &info, indices)
    }
}

/// A kernel that has been parsed and found exact.
#[derive(Clone, Debug)]
struct Checked {
    source: Source,
    module: naga::Module,
    info: naga::valid::ModuleInfo,
}

impl Checked {
    fn new(parts: &[Part], isolation: &Isolation<'_>) -> Result<Self, Refusals> {
        let source = Source::new(parts);
        let mut refusals = exact::check_source(&source);
        if refusals
            .iter()
            .any(|refusal| matches!(refusal.rule, Rule::BuiltInName | Rule::SupportedTypes))
        {
            // Every use of these names would also be refused.
            return Err(in_order(refusals, &source));
        }
        let (checked, of_module) = match Self::parsed(&source, isolation) {
            Ok(parsed) => parsed,
            Err(refusal) => {
                if refusals.iter().all(|other| other.place != refusal.place) {
                    refusals.push(refusal);
                }
                return Err(in_order(refusals, &source));
            }
        };
        // The module often repeats a refusal of the text: by the same rule, or by one that no part can break.
        let of_text: BTreeSet<_> = refusals.iter().map(|refusal| refusal.rule).collect();
        let is_new = |rule| !of_text.contains(&rule) && (rule != Rule::Internal || of_text.is_empty());
        refusals.extend(of_module.into_iter().filter(|refusal| is_new(refusal.rule)));
        if refusals.is_empty() {
            return Ok(checked);
        }
        if refusals.iter().all(|refusal| refusal.rule.is_of_values())
            && let Err(others) = checked.trees().and_then(|trees| trees.turns)
        {
            refusals.extend(others.into_iter().filter(|other| other.rule != Rule::Internal));
        }
        Err(in_order(refusals, &checked.source))
    }

    /// Parses a kernel, and checks its module.
    fn parsed(source: &Source, isolation: &Isolation<'_>) -> Result<(Self, Refusals), Refusal> {
        let (module, info) = front::parse(source)?;
        let mut refusals = isolation::check(isolation, source, &module, &info);
        refusals.extend(ordinary::folded(source, &module));
        let lowered = ordinary::lowered(source, &module, &info)?;
        let (source, module, info) = lowered.unwrap_or_else(|| (source.clone(), module, info));
        refusals.extend(exact::check_module(&source, &module, &info));
        refusals.extend(entry_point(&source, &module));
        let checked = Self { source, module, info };
        Ok((checked, refusals))
    }

    /// Lowers, tidies and analyses it.
    fn trees(&self) -> Result<Trees, Refusals> {
        self.trees_of(lower::lower(&self.source, &self.module, &self.info)?)
    }

    /// Tidies and analyses a program of it.
    fn trees_of(&self, raw: tree::Program) -> Result<Trees, Refusals> {
        let Self { source, module, .. } = self;
        let place = |span| source.place_of(span);
        let bound = layout::bindings(module).map_err(|message| refused(source, Rule::Internal, message))?;
        let mut tidied = raw.clone();
        tidy::take_constant_branches(&mut tidied);
        tidy::carry_values_out(&mut tidied);
        let unused = uniform::analyse(&tidied, &place).err().unwrap_or_default();
        remove_unused(&mut tidied);
        tidy::sink_declarations(&mut tidied);
        let shapes = match uniform::analyse(&tidied, &place) {
            Ok(shapes) if !tidy::go_through_arrays(&mut tidied, &shapes) => shapes,
            Ok(_) => uniform::analyse(&tidied, &place)?,
            Err(mut refusals) => {
                refusals.extend(unused);
                refusals.extend(self.turns(&raw, &bound).err().unwrap_or_default());
                return Err(in_order(refusals, source));
            }
        };
        tidy::select_short_branches(&mut tidied, &shapes);
        remove_unused(&mut tidied);
        Ok(Trees {
            turns: self.turns(&raw, &bound),
            unused: in_order(
                unused
                    .into_iter()
                    .filter(|refusal| refusal.rule == Rule::SameIndex)
                    .collect(),
                source,
            ),
            buffers: bound.iter().map(|buffer| buffer.name.clone()).collect(),
            shapes: uniform::analyse(&tidied, &place)?,
            raw,
            tidied,
            source: source.clone(),
            strides: bound.iter().map(|b| b.stride / 4).collect(),
        })
    }

    /// Bounds the loops of its program.
    fn turns(&self, raw: &tree::Program, bound: &[Binding]) -> Result<Bound, Refusals> {
        bounds::turns(raw, &buffers_of(bound), &self.source).map_err(|refusals| in_order(refusals, &self.source))
    }
}

/// Buffers as bounds need them.
fn buffers_of(bindings: &[Binding]) -> Vec<bounds::Buffer> {
    let buffer = |bound: &Binding| bounds::Buffer {
        name: bound.name.clone(),
        is_constant: bound.kind != "ReadWrite",
        is_uniform: bound.kind == "Uniform",
    };
    bindings.iter().map(buffer).collect()
}

/// Refuses a kernel that doesn't begin at one `main`.
fn entry_point(source: &Source, module: &naga::Module) -> Refusals {
    let [entry] = module.entry_points.as_slice() else {
        let count = module.entry_points.len();
        let message = format!("a kernel has one entry point, this has {count}");
        return refused(source, Rule::EntryPoint, message);
    };
    if entry.name != "main" || entry.workgroup_size[1..] != [1, 1] {
        let message = "the entry point must be `main` with a one-dimensional workgroup";
        return refused(source, Rule::Internal, message.into());
    }
    if entry.workgroup_size[0] % LANES != 0 {
        let message = format!("a workgroup has a multiple of {LANES} invocations, the most lanes that run together");
        return refused(source, Rule::Internal, message);
    }
    Refusals::new()
}

/// Refuses the kernel as a whole.
fn refused(source: &Source, rule: Rule, message: String) -> Refusals {
    vec![Refusal {
        place: source.place(source.text.len()),
        function: None,
        rule,
        message,
    }]
}

/// Refusals in the order of their places, each once: a function has a body at each of its calls.
fn in_order(mut refusals: Refusals, source: &Source) -> Refusals {
    let paths = source.paths();
    refusals.sort_by_key(|Refusal { place, .. }| {
        let part = paths.iter().position(|path| *path == place.path);
        (part, place.line, place.column)
    });
    refusals.dedup();
    refusals
}
