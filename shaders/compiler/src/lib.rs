//! Compiles an exact subset of WGSL, at build time, to SPIR-V, to Rust lane code and to host structs.
//!
//! A kernel is a list of parts ([`Part`]), concatenated. [`compile`] parses and validates it, refuses what
//! would not come out the same bits on every device, and writes its three forms.

mod exact;
mod front;
pub mod instances;
mod layout;
mod lower;
mod print;
mod source;
pub mod spirv;
mod tidy;
pub mod tree;
pub mod uniform;

pub use source::{Part, Place, Refusal, Refusals, Source};

/// A kernel's three forms.
#[derive(Clone, Debug)]
pub struct Compiled {
    /// The joined WGSL.
    pub wgsl: String,
    /// SPIR-V words.
    pub spirv: Vec<u32>,
    /// Rust items: host structs.
    pub structs: String,
    /// Rust: a constant slice expression of bindings.
    pub bindings: String,
    /// Invocations a workgroup.
    pub workgroup_size: u32,
    /// Rust: the lane function.
    pub lanes: String,
}

/// Compiles a kernel.
///
/// # Errors
/// Everything that was refused, each with its place.
pub fn compile(name: &str, parts: &[Part]) -> Result<Compiled, Refusals> {
    let source = Source::new(parts);
    exact::check_source(&source)?;
    let (module, info) = front::parse(&source)?;
    exact::check_module(&source, &module, &info)?;
    let refuse = |message: String| {
        vec![Refusal {
            place: source.place(source.text.len()),
            function: None,
            message,
        }]
    };
    let [entry] = module.entry_points.as_slice() else {
        return Err(refuse(format!(
            "a kernel has one entry point, this has {}",
            module.entry_points.len()
        )));
    };
    if entry.name != "main" || entry.workgroup_size[1..] != [1, 1] {
        return Err(refuse(
            "the entry point must be `main` with a one-dimensional workgroup".into(),
        ));
    }
    let workgroup_size = entry.workgroup_size[0];
    let program = program(&source, &module, &info)?;
    let shapes = uniform::analyse(&program, &|span| source.place_of(span))?;
    let bound = layout::bindings(&module).map_err(refuse)?;
    let bindings = bound
        .iter()
        .map(|b| {
            format!(
                "Binding {{ binding: {}, name: \"{}\", kind: BindingKind::{}, stride: {} }},\n",
                b.binding, b.name, b.kind, b.stride
            )
        })
        .collect();
    Ok(Compiled {
        wgsl: source.text.clone(),
        spirv: spirv::write(&module, &info).map_err(refuse)?,
        structs: layout::structs(&module).map_err(refuse)?,
        bindings,
        workgroup_size,
        lanes: print::print(
            &program,
            &shapes,
            name,
            &bound.iter().map(|b| b.stride / 4).collect::<Vec<_>>(),
        ),
    })
}

/// Lowers and tidies.
fn program(source: &Source, module: &naga::Module, info: &naga::valid::ModuleInfo) -> Result<tree::Program, Refusals> {
    let mut program = lower::lower(source, module, info)?;
    tidy::carry_values_out(&mut program);
    tidy::remove_unused(&mut program);
    tidy::sink_declarations(&mut program);
    let shapes = uniform::analyse(&program, &|span| source.place_of(span))?;
    tidy::select_short_branches(&mut program, &shapes);
    tidy::remove_unused(&mut program);
    Ok(program)
}
