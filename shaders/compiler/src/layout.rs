//! Writes host structs from WGSL structs, so that no layout is defined twice.

use std::collections::BTreeSet;
use std::fmt::Write;

use naga::{AddressSpace, ArraySize, Expression, Handle, Literal, Module, ScalarKind, Type, TypeInner};

/// A buffer that a kernel binds, in group 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Binding {
    /// Number in `@binding`.
    pub binding: u32,
    /// Name in the WGSL.
    pub name: String,
    /// `Uniform`, `Read` or `ReadWrite`, as in `oneiro_shaders::BindingKind`.
    pub kind: &'static str,
    /// Bytes of one element of its array, or of the whole buffer if it isn't an array.
    pub stride: u32,
}

impl Binding {
    /// Writes it as an element of a slice of `Binding`s.
    pub fn as_rust(&self) -> String {
        let Self {
            binding,
            name,
            kind,
            stride,
        } = self;
        format!("Binding {{ binding: {binding}, name: \"{name}\", kind: BindingKind::{kind}, stride: {stride} }},\n")
    }
}

/// Lists a kernel's bindings in ascending order.
///
/// # Errors
/// A group other than 0, a gap in the numbers, or an array of fixed length.
pub(crate) fn bindings(module: &Module) -> Result<Vec<Binding>, String> {
    let mut bound = Vec::new();
    for (_, variable) in module.global_variables.iter() {
        let Some(binding) = variable.binding else { continue };
        let name = variable.name.clone().unwrap_or_default();
        if binding.group != 0 {
            return Err(format!(
                "`{name}` is in group {}; all bindings are in group 0",
                binding.group
            ));
        }
        let kind = match variable.space {
            AddressSpace::Uniform => "Uniform",
            AddressSpace::Storage { access } if access.contains(naga::StorageAccess::STORE) => "ReadWrite",
            _ => "Read",
        };
        let stride = match &module.types[variable.ty].inner {
            // A GPU would clamp its index to the array's length, and lane code to the buffer's.
            TypeInner::Array {
                size: ArraySize::Constant(_),
                ..
            } => {
                return Err(format!(
                    "`{name}`: an array in a buffer has the buffer's length; write `array<T>`"
                ));
            }
            TypeInner::Array { stride, .. } => *stride,
            other => other.size(module.to_ctx()),
        };
        bound.push(Binding {
            binding: binding.binding,
            name,
            kind,
            stride,
        });
    }
    bound.sort_by_key(|b| b.binding);
    for (index, b) in bound.iter().enumerate() {
        if b.binding as usize != index {
            return Err(format!("`{}` is binding {}, but {index} comes next", b.name, b.binding));
        }
    }
    Ok(bound)
}

/// A module-level constant as a Rust item.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Constant {
    /// Name in the WGSL.
    pub name: String,
    /// Value in Rust.
    pub value: String,
    /// Definition in Rust.
    pub item: String,
}

/// Writes a kernel's constants in Rust: numbers, truth values, and vectors of which each component is given.
pub(crate) fn constants(module: &Module) -> Vec<Constant> {
    let constant = |constant: &naga::Constant| {
        let name = constant.name.clone()?;
        let (ty, value) = value(module, constant.init)?;
        let item = format!("/// The WGSL constant `{name}`.\npub const {name}: {ty} = {value};\n");
        Some(Constant { name, value, item })
    };
    module
        .constants
        .iter()
        .filter_map(|(_, declared)| constant(declared))
        .collect()
}

/// Writes a constant's type and value in Rust.
fn value(module: &Module, init: Handle<Expression>) -> Option<(String, String)> {
    let (ty, value) = match &module.global_expressions[init] {
        Expression::Literal(Literal::F32(x)) => ("f32", format!("{x:?}")),
        Expression::Literal(Literal::U32(x)) => ("u32", x.to_string()),
        Expression::Literal(Literal::I32(x)) => ("i32", x.to_string()),
        Expression::Literal(Literal::Bool(x)) => ("bool", x.to_string()),
        Expression::Compose { ty, components } => {
            let TypeInner::Vector { size, scalar } = module.types[*ty].inner else {
                return None;
            };
            let components = components.iter().map(|&component| Some(value(module, component)?.1));
            let components = components.collect::<Option<Vec<_>>>()?;
            let ty = format!("[{}; {}]", rust_scalar(scalar), size as u32);
            return Some((ty, format!("[{}]", components.join(", "))));
        }
        _ => return None,
    };
    Some((ty.into(), value))
}

/// Ending of the name of a struct that describes four words of a buffer whose type in WGSL is a plain vector. Its fields are
/// in the order in which the host fills them.
const CELL: &str = "Cell";

/// A buffer that the host copies without reading it: its struct may differ from kernel to kernel, and be padded.
const STATE: &str = "state";

/// Writes a Rust struct for each struct in a buffer other than [`STATE`], and for each cell.
///
/// # Errors
/// A struct whose layout in WGSL isn't that of Rust's `repr(C)`; a cell that isn't four words.
pub(crate) fn structs(module: &Module) -> Result<String, String> {
    let mut out = String::new();
    let mut written = BTreeSet::new();
    for (_, variable) in module.global_variables.iter() {
        if variable.binding.is_none() || variable.name.as_deref() == Some(STATE) {
            continue;
        }
        let ty = match module.types[variable.ty].inner {
            TypeInner::Array { base, .. } => base,
            _ => variable.ty,
        };
        if matches!(module.types[ty].inner, TypeInner::Struct { .. }) {
            one(module, ty, &mut written, &mut out)?;
        }
    }
    for (handle, ty) in module.types.iter() {
        let Some(name) = ty.name.as_ref().filter(|name| name.ends_with(CELL)) else {
            continue;
        };
        if !matches!(ty.inner, TypeInner::Struct { span: 16, .. }) {
            return Err(format!("`{name}`: a cell has four words"));
        }
        one(module, handle, &mut written, &mut out)?;
    }
    Ok(out)
}

/// Writes a struct after those that it contains, unless it is already written.
fn one(
    module: &Module,
    ty: Handle<Type>,
    written: &mut BTreeSet<Handle<Type>>,
    out: &mut String,
) -> Result<(), String> {
    let TypeInner::Struct { members, span } = &module.types[ty].inner else {
        return Ok(());
    };
    if !written.insert(ty) {
        return Ok(());
    }
    let name = module.types[ty].name.clone().unwrap_or_default();
    let mut fields = String::new();
    let mut names = Vec::new();
    let mut offset = 0;
    for member in members {
        let field = member.name.clone().unwrap_or_default();
        let inner = &module.types[member.ty].inner;
        let rust = match inner {
            TypeInner::Scalar(scalar) | TypeInner::Vector { scalar, .. } if scalar.kind == ScalarKind::Bool => {
                return Err(format!("`{name}.{field}`: a bool has no layout"));
            }
            TypeInner::Scalar(scalar) => rust_scalar(*scalar),
            TypeInner::Vector { size, scalar } => format!("[{}; {}]", rust_scalar(*scalar), *size as u32),
            TypeInner::Struct { .. } => {
                one(module, member.ty, written, out)?;
                module.types[member.ty].name.clone().unwrap_or_default()
            }
            _ => {
                return Err(format!(
                    "`{name}.{field}`: host structs hold only scalars, vectors and structs"
                ));
            }
        };
        if member.offset != offset {
            return Err(format!(
                "`{name}.{field}` is preceded by padding; fill it with a named field"
            ));
        }
        offset += inner.size(module.to_ctx());
        let _ = writeln!(
            fields,
            "    /// `{field}` of the WGSL struct, at byte {}.\n    pub {field}: {rust},",
            member.offset
        );
        names.push(format!("\"{field}\""));
    }
    if offset != *span {
        return Err(format!("`{name}` ends in padding; fill it with a named field"));
    }
    let _ = write!(
        out,
        "/// The WGSL struct `{name}`, {span} bytes.\n\
         #[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]\n\
         #[repr(C)]\npub struct {name} {{\n{fields}}}\n\
         impl {name} {{\n    /// Its fields' names, in order.\n    pub const FIELDS: [&'static str; {}] = [{}];\n}}\n",
        names.len(),
        names.join(", "),
    );
    Ok(())
}

fn rust_scalar(scalar: naga::Scalar) -> String {
    match scalar.kind {
        ScalarKind::Float => "f32",
        ScalarKind::Sint => "i32",
        _ => "u32",
    }
    .into()
}
