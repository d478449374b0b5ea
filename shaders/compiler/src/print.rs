//! Prints a program as Rust lane code in SPMD style. Uniform values are scalars, varying values hold all lanes, and a branch
//! on a varying condition runs under a mask if any lane takes it.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::tree::{Address, Binary, Block, Label, Op, Program, Statement, Ty, Unary, Value, Variable};
use crate::uniform::{Region, Shape, Shapes, depth_of};

/// Prints a program as one Rust function that is generic over the type of the lanes.
pub(crate) fn print(program: &Program, shapes: &Shapes, name: &str, strides: &[u32]) -> String {
    let mut printer = Printer {
        program,
        shapes,
        uses: program.uses(),
        texts: BTreeMap::new(),
        regions: Vec::new(),
        masks: Vec::new(),
        homes: vec![0; program.variables.len()],
        array_homes: vec![0; program.arrays.len()],
        out: String::new(),
        depth: 1,
        masks_made: 0,
    };
    printer.line("let _ = (workgroup, first_lane);");
    for buffer in 0..program.buffers {
        printer.line(&format!("let b{buffer} = *buffers.get_unchecked({buffer});"));
        let stride = strides[buffer as usize];
        printer.line(&format!("let n{buffer} = (b{buffer}.len / {stride}) as u32;"));
    }
    printer.block(&program.body);
    format!(
        "#[inline(always)]\npub(crate) unsafe fn {name}<L: Lanes>(buffers: &[Words], workgroup: u32, first_lane: u32) {{\n{}}}\n",
        printer.out
    )
}

/// Mask of the lanes that are active in a region.
#[derive(Clone, Debug)]
struct Mask {
    name: String,
    /// Number of regions around that one.
    depth: usize,
}

struct Printer<'a> {
    program: &'a Program,
    shapes: &'a Shapes,
    uses: BTreeMap<Value, u32>,
    /// Expressions of values that are printed at their use.
    texts: BTreeMap<Value, String>,
    regions: Vec<Region>,
    masks: Vec<Mask>,
    homes: Vec<usize>,
    array_homes: Vec<usize>,
    out: String,
    depth: usize,
    masks_made: u32,
}

/// Characters of the longest expression that is printed at its use.
pub(crate) const INLINE: usize = 60;

impl Printer<'_> {
    fn line(&mut self, text: &str) {
        let _ = writeln!(self.out, "{:indent$}{text}", "", indent = 4 * self.depth);
    }

    /// Mask of the lanes that are active here. `None` if all are.
    fn active(&self) -> Option<&str> {
        self.masks.last().map(|mask| mask.name.as_str())
    }

    fn name(&self, value: Value) -> String {
        self.program.name(value)
    }

    fn variable(&self, variable: Variable) -> String {
        self.program.variable_name(variable)
    }

    fn mask_name(&mut self, stem: &str) -> String {
        self.masks_made += 1;
        format!("{stem}{}", self.masks_made)
    }

    /// Expression of a uniform value, or of a linear value in lane 0.
    fn scalar(&self, value: Value) -> String {
        if let Op::Constant(bits) = self.program.op(value) {
            return constant(bits, self.program.ty(value));
        }
        self.texts.get(&value).cloned().unwrap_or_else(|| self.name(value))
    }

    /// Expression of a value for all lanes.
    fn lanes(&self, value: Value) -> String {
        match (self.shapes.shape(value), self.program.ty(value)) {
            (Shape::Varying, _) => self.texts.get(&value).cloned().unwrap_or_else(|| self.name(value)),
            (Shape::Linear, _) => format!("L::iota({})", self.scalar(value)),
            (Shape::Uniform, Ty::F32) => format!("L::f({})", self.scalar(value)),
            (Shape::Uniform, Ty::U32) => format!("L::i({})", self.scalar(value)),
            (Shape::Uniform, Ty::I32) => format!("L::i({} as u32)", self.scalar(value)),
            (Shape::Uniform, Ty::Bool) => format!("L::m({})", self.scalar(value)),
        }
    }

    /// Expression of a varying value's bits in a buffer.
    fn bits(&self, value: Value) -> String {
        let lanes = self.lanes(value);
        match self.program.ty(value) {
            Ty::F32 => format!("L::bits({lanes})"),
            Ty::Bool => format!("L::isel({lanes}, L::i(1), L::i(0))"),
            _ => lanes,
        }
    }

    fn block(&mut self, block: &Block) {
        for statement in block {
            self.statement(statement);
        }
    }

    fn statement(&mut self, statement: &Statement) {
        match statement {
            Statement::Let(value) => self.computed(*value),
            Statement::Load { targets, address } => self.load(targets, address),
            Statement::Declare(variable) => {
                self.homes[variable.0 as usize] = self.regions.len();
                let info = &self.program.variables[variable.0 as usize];
                let init = constant(info.init, info.ty);
                let init = if self.shapes.variable_varies(*variable) {
                    splat(&init, info.ty)
                } else {
                    init
                };
                let name = self.variable(*variable);
                self.line(&format!("let mut {name} = {init};"));
            }
            Statement::DeclareArray(array) => {
                self.array_homes[array.0 as usize] = self.regions.len();
                let info = &self.program.arrays[array.0 as usize];
                let varies = self.shapes.array_varies(*array);
                let element = |bits: &u32| {
                    let init = constant(*bits, info.ty);
                    if varies { splat(&init, info.ty) } else { init }
                };
                let elements: Vec<_> = info.init.iter().map(element).collect();
                self.line(&format!(
                    "let mut {}_a{} = [{}];",
                    info.name,
                    array.0,
                    elements.join(", ")
                ));
            }
            Statement::Write(variable, value) => {
                let name = self.variable(*variable);
                let ty = self.program.variables[variable.0 as usize].ty;
                let new = if self.shapes.variable_varies(*variable) {
                    let masked = self.shapes.diverges(&self.regions[self.homes[variable.0 as usize]..]);
                    self.blended(masked, *value, ty, &name)
                } else {
                    self.scalar(*value)
                };
                self.line(&format!("{name} = {new};"));
            }
            Statement::WriteElement {
                array, index, value, ..
            } => {
                let info = &self.program.arrays[array.0 as usize];
                let last = info.init.len() - 1;
                let element = format!(
                    "{}_a{}[(({}) as usize).min({last})]",
                    info.name,
                    array.0,
                    self.scalar(*index)
                );
                let ty = info.ty;
                let new = if self.shapes.array_varies(*array) {
                    let masked = self
                        .shapes
                        .diverges(&self.regions[self.array_homes[array.0 as usize]..]);
                    self.blended(masked, *value, ty, &element)
                } else {
                    self.scalar(*value)
                };
                self.line(&format!("{element} = {new};"));
            }
            Statement::Store { address, value, .. } => self.store(address, *value),
            Statement::If {
                condition,
                accept,
                reject,
            } => self.branch(*condition, accept, reject),
            Statement::Loop { label, body, .. } => {
                self.regions.push(Region::Label(*label));
                if self.shapes.loop_is_left_by_some(*label) {
                    let live = self.mask_name("live");
                    let start = self.active().map_or_else(|| "L::m(true)".to_owned(), str::to_owned);
                    self.line(&format!("let mut {live} = {start};"));
                    self.line(&format!("'l{}: while L::any({live}) {{", label.0));
                    self.masks.push(Mask {
                        name: live,
                        depth: self.regions.len() - 1,
                    });
                    self.indented(body);
                    self.masks.pop();
                } else {
                    self.line(&format!("'l{}: loop {{", label.0));
                    self.indented(body);
                }
                self.line("}");
                self.regions.pop();
            }
            Statement::Labeled { label, body, function } => {
                if let Some(function) = function {
                    self.line(&format!("// {function}"));
                }
                self.regions.push(Region::Label(*label));
                let masked = self.shapes.is_left_by_some(*label);
                if masked {
                    let live = self.mask_name("live");
                    let start = self.active().map_or_else(|| "L::m(true)".to_owned(), str::to_owned);
                    self.line(&format!("let mut {live} = {start};"));
                    self.masks.push(Mask {
                        name: live,
                        depth: self.regions.len() - 1,
                    });
                }
                if self.shapes.is_left_by_all(*label, body, &mut self.regions.clone()) {
                    self.line(&format!("'l{}: {{", label.0));
                    self.indented(body);
                    self.line("}");
                } else {
                    self.block(body);
                }
                if masked {
                    self.masks.pop();
                }
                self.regions.pop();
            }
            Statement::Exit(label) => self.exit(*label),
        }
    }

    fn indented(&mut self, block: &Block) {
        self.depth += 1;
        self.block(block);
        self.depth -= 1;
    }

    fn branch(&mut self, condition: Value, accept: &Block, reject: &Block) {
        if self.shapes.is_uniform(condition) {
            self.regions.push(Region::Branch(false));
            self.line(&format!("if {} {{", self.scalar(condition)));
            self.indented(accept);
            if !reject.is_empty() {
                self.line("} else {");
                self.indented(reject);
            }
            self.line("}");
            self.regions.pop();
            return;
        }
        let condition = self.lanes(condition);
        self.regions.push(Region::Branch(true));
        let both = !accept.is_empty() && !reject.is_empty();
        let test = if both {
            let test = self.mask_name("test");
            self.line(&format!("let {test} = {condition};"));
            test
        } else {
            condition
        };
        let outer = self.active().map(str::to_owned);
        for (block, inverted) in [(accept, false), (reject, true)] {
            if block.is_empty() {
                continue;
            }
            let mask = self.mask_name("mask");
            let lanes = match (&outer, inverted) {
                (None, false) => test.clone(),
                (None, true) => format!("L::mnot({test})"),
                (Some(outer), false) => format!("L::mand({outer}, {test})"),
                (Some(outer), true) => format!("L::mandnot({outer}, {test})"),
            };
            self.line(&format!("let mut {mask} = {lanes};"));
            self.line(&format!("if L::any({mask}) {{"));
            self.masks.push(Mask {
                name: mask,
                depth: self.regions.len() - 1,
            });
            self.indented(block);
            self.masks.pop();
            self.line("}");
        }
        self.regions.pop();
        if self.shapes.ends_early(&self.regions, [accept, reject])
            && let Some(active) = self.active()
        {
            let text = format!("if !L::any({active}) {{ return; }}");
            self.line(&text);
        }
    }

    fn exit(&mut self, label: Label) {
        if !self.shapes.exit_diverges(&self.regions, label) {
            self.line(&format!("break 'l{};", label.0));
            return;
        }
        let depth = depth_of(&self.regions, label);
        let gone = self.mask_name("gone");
        let active = self.active().expect("a varying exit stands under a mask").to_owned();
        self.line(&format!("let {gone} = {active};"));
        for mask in self.masks.clone() {
            if mask.depth >= depth {
                self.line(&format!("{name} = L::mandnot({name}, {gone});", name = mask.name));
            }
        }
    }

    fn blended(&self, masked: bool, value: Value, ty: Ty, old: &str) -> String {
        let new = self.lanes(value);
        match (masked, self.active()) {
            (true, Some(active)) => format!("{}({active}, {new}, {old})", select(ty)),
            _ => new,
        }
    }

    /// Prints a value, or keeps its expression for its only use.
    fn computed(&mut self, value: Value) {
        let shape = self.shapes.shape(value);
        let text = if shape == Shape::Varying {
            self.varying(value)
        } else {
            self.uniform(value)
        };
        let pure = !matches!(self.program.op(value), Op::Read(_) | Op::ReadElement(..));
        if pure && self.uses.get(&value) == Some(&1) && text.len() <= INLINE {
            self.texts.insert(value, text);
        } else {
            let name = self.name(value);
            self.line(&format!("let {name} = {text};"));
        }
    }

    fn uniform(&self, value: Value) -> String {
        let ty = self.program.ty(value);
        match self.program.op(value) {
            Op::Constant(bits) => constant(bits, ty),
            Op::Lane => "first_lane".into(),
            Op::Workgroup => "workgroup".into(),
            Op::Loaded => self.name(value),
            Op::Read(variable) => self.variable(variable),
            Op::ReadElement(array, index) => self.element(array, index),
            Op::Unary(op, a) => {
                let x = self.scalar(a);
                match (op, ty) {
                    (Unary::Negate, Ty::F32) => format!("(-({x}))"),
                    (Unary::Negate, _) => format!("({x}).wrapping_neg()"),
                    (Unary::Not, _) => format!("(!({x}))"),
                    (Unary::Abs, Ty::F32) => format!("({x}).abs()"),
                    (Unary::Abs, Ty::I32) => format!("({x}).wrapping_abs()"),
                    (Unary::Abs, _) => x,
                    (Unary::Floor, _) => format!("uniform::floor({x})"),
                    (Unary::Trunc, _) => format!("uniform::trunc({x})"),
                }
            }
            Op::Binary(op, a, b) => self.uniform_binary(op, a, b),
            Op::Select {
                condition,
                accept,
                reject,
            } => format!(
                "(if {} {{ {} }} else {{ {} }})",
                self.scalar(condition),
                self.scalar(accept),
                self.scalar(reject)
            ),
            Op::Convert(a) => {
                let x = self.scalar(a);
                match (self.program.ty(a), ty) {
                    (Ty::Bool, Ty::F32) => format!("(u32::from({x}) as f32)"),
                    (Ty::Bool, ty) => format!("(u32::from({x}) as {})", rust_type(ty)),
                    (Ty::F32, Ty::Bool) => format!("(({x}) != 0.0)"),
                    (_, Ty::Bool) => format!("(({x}) != 0)"),
                    (_, ty) => format!("(({x}) as {})", rust_type(ty)),
                }
            }
            Op::Bitcast(a) => {
                let x = self.scalar(a);
                match (self.program.ty(a), ty) {
                    (Ty::F32, Ty::U32) => format!("({x}).to_bits()"),
                    (Ty::F32, _) => format!("(({x}).to_bits() as i32)"),
                    (_, Ty::F32) => format!("f32::from_bits(({x}) as u32)"),
                    (_, ty) => format!("(({x}) as {})", rust_type(ty)),
                }
            }
        }
    }

    fn uniform_binary(&self, op: Binary, a: Value, b: Value) -> String {
        let ty = self.program.ty(a);
        let (x, y) = (self.scalar(a), self.scalar(b));
        let float = ty == Ty::F32;
        match op {
            Binary::Add if float => format!("({x} + {y})"),
            Binary::Subtract if float => format!("({x} - {y})"),
            Binary::Multiply if float => format!("({x} * {y})"),
            Binary::Add => format!("({x}).wrapping_add({y})"),
            Binary::Subtract => format!("({x}).wrapping_sub({y})"),
            Binary::Multiply => format!("({x}).wrapping_mul({y})"),
            Binary::Divide => format!("uniform::divide({x}, {y})"),
            Binary::Remainder => format!("uniform::remainder({x}, {y})"),
            Binary::Min => format!("uniform::min({x}, {y})"),
            Binary::Max => format!("uniform::max({x}, {y})"),
            Binary::And => format!("({x} & {y})"),
            Binary::Or => format!("({x} | {y})"),
            Binary::Xor => format!("({x} ^ {y})"),
            Binary::ShiftLeft => format!("({x}).wrapping_shl({y})"),
            Binary::ShiftRight => format!("({x}).wrapping_shr({y})"),
            Binary::Equal => format!("({x} == {y})"),
            Binary::NotEqual => format!("({x} != {y})"),
            Binary::Less => format!("({x} < {y})"),
            Binary::LessEqual => format!("({x} <= {y})"),
            Binary::Greater => format!("({x} > {y})"),
            Binary::GreaterEqual => format!("({x} >= {y})"),
        }
    }

    fn element(&self, array: crate::tree::Array, index: Value) -> String {
        let info = &self.program.arrays[array.0 as usize];
        format!(
            "{}_a{}[(({}) as usize).min({})]",
            info.name,
            array.0,
            self.scalar(index),
            info.init.len() - 1
        )
    }

    fn varying(&self, value: Value) -> String {
        let ty = self.program.ty(value);
        match self.program.op(value) {
            Op::Constant(_) | Op::Lane | Op::Workgroup | Op::Loaded => self.lanes(value),
            Op::Read(variable) => self.variable(variable),
            Op::ReadElement(array, index) => self.element(array, index),
            Op::Unary(op, a) => {
                let x = self.lanes(a);
                match (op, ty) {
                    (Unary::Negate, Ty::F32) => format!("L::neg({x})"),
                    (Unary::Negate, _) => format!("L::isub(L::i(0), {x})"),
                    (Unary::Not, Ty::Bool) => format!("L::mnot({x})"),
                    (Unary::Not, _) => format!("L::ixor({x}, L::i(!0))"),
                    (Unary::Abs, Ty::F32) => format!("L::abs({x})"),
                    (Unary::Abs, Ty::I32) => format!("L::smax({x}, L::isub(L::i(0), {x}))"),
                    (Unary::Abs, _) => x,
                    (Unary::Floor, _) => format!("L::floor({x})"),
                    (Unary::Trunc, _) => format!("L::trunc({x})"),
                }
            }
            Op::Binary(op, a, b) => self.varying_binary(op, a, b),
            Op::Select {
                condition,
                accept,
                reject,
            } => {
                let (accept, reject) = (self.lanes(accept), self.lanes(reject));
                if self.shapes.is_uniform(condition) {
                    format!("(if {} {{ {accept} }} else {{ {reject} }})", self.scalar(condition))
                } else {
                    format!("{}({}, {accept}, {reject})", select(ty), self.lanes(condition))
                }
            }
            Op::Convert(a) => {
                let x = self.lanes(a);
                match (self.program.ty(a), ty) {
                    (Ty::Bool, Ty::F32) => format!("L::fsel({x}, L::f(1.0), L::f(0.0))"),
                    (Ty::Bool, _) => format!("L::isel({x}, L::i(1), L::i(0))"),
                    (Ty::F32, Ty::Bool) => format!("L::mnot(L::eq({x}, L::f(0.0)))"),
                    (_, Ty::Bool) => format!("L::mnot(L::ieq({x}, L::i(0)))"),
                    (Ty::I32, Ty::F32) => format!("L::f_of_i({x})"),
                    (_, Ty::F32) => format!("L::f_of_u({x})"),
                    (_, Ty::I32) => format!("L::i_of_f({x})"),
                    (_, Ty::U32) => format!("L::u_of_f({x})"),
                }
            }
            Op::Bitcast(a) => {
                let x = self.lanes(a);
                match (self.program.ty(a), ty) {
                    (Ty::F32, _) => format!("L::bits({x})"),
                    (_, Ty::F32) => format!("L::float({x})"),
                    _ => x,
                }
            }
        }
    }

    fn varying_binary(&self, op: Binary, a: Value, b: Value) -> String {
        let ty = self.program.ty(a);
        let (x, y) = (self.lanes(a), self.lanes(b));
        let call = |name: &str| format!("L::{name}({x}, {y})");
        let swapped = |name: &str| format!("L::{name}({y}, {x})");
        let by_type = |float: &str, signed: &str, unsigned: &str| match ty {
            Ty::F32 => format!("L::{float}"),
            Ty::I32 => format!("L::{signed}"),
            _ => format!("L::{unsigned}"),
        };
        let args = format!("({x}, {y})");
        let args_swapped = format!("({y}, {x})");
        match (op, ty) {
            (Binary::And, Ty::Bool) => call("mand"),
            (Binary::Or, Ty::Bool) => call("mor"),
            (Binary::Xor | Binary::NotEqual, Ty::Bool) => call("mxor"),
            (Binary::Equal, Ty::Bool) => format!("L::mnot({})", call("mxor")),
            (Binary::Add, _) => by_type("add", "iadd", "iadd") + &args,
            (Binary::Subtract, _) => by_type("sub", "isub", "isub") + &args,
            (Binary::Multiply, _) => by_type("mul", "imul", "imul") + &args,
            (Binary::Min, _) => by_type("min", "smin", "umin") + &args,
            (Binary::Max, _) => by_type("max", "smax", "umax") + &args,
            (Binary::Divide, _) => call("udiv"),
            (Binary::Remainder, _) => call("urem"),
            (Binary::And, _) => call("iand"),
            (Binary::Or, _) => call("ior"),
            (Binary::Xor, _) => call("ixor"),
            (Binary::ShiftLeft | Binary::ShiftRight, _) => {
                let name = match (op, ty) {
                    (Binary::ShiftLeft, _) => "shl",
                    (_, Ty::I32) => "sar",
                    _ => "shr",
                };
                if self.shapes.is_uniform(b) {
                    format!("L::{name}({x}, ({}) & 31)", self.scalar(b))
                } else {
                    format!("L::{name}_each({x}, {y})")
                }
            }
            (Binary::Equal, Ty::F32) => call("eq"),
            (Binary::NotEqual, Ty::F32) => format!("L::mnot({})", call("eq")),
            (Binary::Equal, _) => call("ieq"),
            (Binary::NotEqual, _) => format!("L::mnot({})", call("ieq")),
            (Binary::Less, _) => by_type("lt", "slt", "ult") + &args,
            (Binary::LessEqual, Ty::F32) => call("le"),
            (Binary::GreaterEqual, Ty::F32) => swapped("le"),
            (Binary::Greater, _) => by_type("lt", "slt", "ult") + &args_swapped,
            (Binary::LessEqual, _) => format!("L::mnot({})", by_type("", "slt", "ult") + &args_swapped),
            (Binary::GreaterEqual, _) => format!("L::mnot({})", by_type("", "slt", "ult") + &args),
        }
    }

    fn stride(address: &Address) -> String {
        format!(
            "{}, {}",
            if address.element.is_some() { address.stride } else { 0 },
            address.offset
        )
    }

    fn load(&mut self, targets: &[Value], address: &Address) {
        let b = address.buffer;
        let place = Self::stride(address);
        let uniform = address.element.is_none_or(|element| self.shapes.is_uniform(element));
        if uniform {
            let element = address
                .element
                .map_or_else(|| "0".to_owned(), |element| self.scalar(element));
            for (k, target) in targets.iter().enumerate() {
                if !self.uses.contains_key(target) {
                    continue;
                }
                let at = Address {
                    offset: address.offset + k as u32,
                    ..*address
                };
                let word = format!("L::word(b{b}, {element}, n{b}, {})", Self::stride(&at));
                let text = match self.program.ty(*target) {
                    Ty::F32 => format!("f32::from_bits({word})"),
                    Ty::I32 => format!("{word} as i32"),
                    _ => word,
                };
                let name = self.name(*target);
                self.line(&format!("let {name} = {text};"));
            }
            return;
        }
        let element = address.element.expect("only an element's index varies");
        if let [target] = targets {
            let linear = self.shapes.shape(element) == Shape::Linear && address.stride == 1;
            let words = if linear {
                format!("L::load(b{b}, {}, n{b}, {})", self.scalar(element), address.offset)
            } else {
                format!("L::gather(b{b}, {}, n{b}, {place})", self.lanes(element))
            };
            self.loaded(*target, &words);
        } else {
            self.masks_made += 1;
            let quad = format!("quad{}", self.masks_made);
            self.line(&format!(
                "let {quad} = L::quad(b{b}, {}, n{b}, {place});",
                self.lanes(element)
            ));
            for (k, target) in targets.iter().enumerate() {
                self.loaded(*target, &format!("{quad}[{k}]"));
            }
        }
    }

    fn loaded(&mut self, target: Value, words: &str) {
        let name = self.name(target);
        let text = if self.program.ty(target) == Ty::F32 {
            format!("L::float({words})")
        } else {
            words.to_owned()
        };
        self.line(&format!("let {name} = {text};"));
    }

    fn store(&mut self, address: &Address, value: Value) {
        let b = address.buffer;
        let place = Self::stride(address);
        let mask = self.active().map_or_else(|| "L::m(true)".to_owned(), str::to_owned);
        let uniform = address.element.is_none_or(|element| self.shapes.is_uniform(element));
        let text = if uniform {
            let element = address
                .element
                .map_or_else(|| "0".to_owned(), |element| self.scalar(element));
            let x = self.scalar(value);
            let bits = match self.program.ty(value) {
                Ty::F32 => format!("({x}).to_bits()"),
                Ty::Bool => format!("u32::from({x})"),
                _ => format!("({x}) as u32"),
            };
            format!("L::store_word(b{b}, {element}, n{b}, {place}, {bits}, {mask});")
        } else {
            let element = address.element.expect("only an element's index varies");
            let bits = self.bits(value);
            if self.shapes.shape(element) == Shape::Linear && address.stride == 1 {
                let first = self.scalar(element);
                format!("L::save(b{b}, {first}, n{b}, {}, {bits}, {mask});", address.offset)
            } else {
                format!(
                    "L::store(b{b}, {}, n{b}, {place}, {bits}, {mask});",
                    self.lanes(element)
                )
            }
        };
        self.line(&text);
    }
}

fn constant(bits: u32, ty: Ty) -> String {
    match ty {
        Ty::F32 => {
            let x = f32::from_bits(bits);
            if x.is_sign_negative() {
                format!("({x:?}_f32)")
            } else {
                format!("{x:?}_f32")
            }
        }
        Ty::I32 => format!("({}_i32)", bits as i32),
        Ty::U32 => format!("{bits}_u32"),
        Ty::Bool => format!("{}", bits != 0),
    }
}

fn splat(scalar: &str, ty: Ty) -> String {
    match ty {
        Ty::F32 => format!("L::f({scalar})"),
        Ty::I32 => format!("L::i({scalar} as u32)"),
        Ty::U32 => format!("L::i({scalar})"),
        Ty::Bool => format!("L::m({scalar})"),
    }
}

fn select(ty: Ty) -> &'static str {
    match ty {
        Ty::F32 => "L::fsel",
        Ty::Bool => "L::msel",
        _ => "L::isel",
    }
}

fn rust_type(ty: Ty) -> &'static str {
    match ty {
        Ty::F32 => "f32",
        Ty::I32 => "i32",
        Ty::U32 => "u32",
        Ty::Bool => "bool",
    }
}
