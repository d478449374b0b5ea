//! Prints a program as the body of a C99 function for one lane, with the same bits: floats are single, integers wrap, and nothing is
//! called but the functions of [`helpers`]. An exit is a `break` from the innermost loop, or a jump to the end of the block that it leaves.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use crate::print::INLINE;
use crate::tree::{Address, Array, Binary, Block, Label, Op, Program, Statement, Ty, Unary, Value, Variable, visit};

/// A buffer as the C function has it.
#[derive(Clone, Debug)]
pub enum Memory {
    /// An array of `uint32_t` with this name; the expression of its number of elements, 1 or more.
    Words(String, String),
    /// The same, of constants, which lie in the flash memory of processors with another one for data.
    Constants(String, String),
    /// A place with a type for each word. All are read and written at constant places.
    Places(Vec<(String, Ty)>),
}

/// What a file begins with: it refuses to be compiled with arithmetic that gives other bits, and keeps products from being fused with sums,
/// which GCC does by default on processors that can, whatever the pragma of the C standard says. Constants are marked `ONEIRO_FLASH`.
pub const PREAMBLE: &str = "#include <float.h>
#include <stdbool.h>
#include <stdint.h>

#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) || defined(_M_FP_FAST)
#error \"fast-math changes the bits: compile without -ffast-math, -Ofast and /fp:fast\"
#endif
#if defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__ > 0
#error \"fast-math changes the bits: compile without -ffinite-math-only\"
#endif
#if !defined(FLT_EVAL_METHOD) && defined(__FLT_EVAL_METHOD__)
#define FLT_EVAL_METHOD __FLT_EVAL_METHOD__
#endif
#if !defined(FLT_EVAL_METHOD) || FLT_EVAL_METHOD != 0
#error \"floats must be computed as floats, FLT_EVAL_METHOD 0: on 32-bit x86 compile with -msse2 -mfpmath=sse\"
#endif
#if FLT_RADIX != 2 || FLT_MANT_DIG != 24 || FLT_MAX_EXP != 128
#error \"floats must have 32 bits as in IEEE 754\"
#endif
#ifdef __AVR__
#include <avr/pgmspace.h>
#define ONEIRO_FLASH PROGMEM
#else
#define ONEIRO_FLASH
#endif
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize (\"fp-contract=off\")
#elif defined(_MSC_VER) && !defined(__clang__)
#pragma fp_contract (off)
#else
#pragma STDC FP_CONTRACT OFF
#endif
";

/// Functions that printed code calls, each after those that it calls.
const HELPERS: [(&str, &str); 7] = [
    (
        "constant_of",
        "static uint32_t constant_of(const uint32_t *word)
{
#ifdef __AVR__
    return pgm_read_dword(word);
#else
    return *word;
#endif
}
",
    ),
    (
        "divisor_of",
        "static uint32_t divisor_of(uint32_t x)
{
    return x == 0 ? 1u : x;
}
",
    ),
    (
        "bits_of",
        "static uint32_t bits_of(float x)
{
    union { float number; uint32_t bits; } word;
    word.number = x;
    return word.bits;
}
",
    ),
    (
        "number_of",
        "static float number_of(uint32_t bits)
{
    union { float number; uint32_t bits; } word;
    word.bits = bits;
    return word.number;
}
",
    ),
    (
        "whole_of",
        "/* Rounded towards zero; beyond all integers the nearest one, and 0 for what is no number. */
static int32_t whole_of(float x)
{
    if (x >= 2147483648.0f) {
        return 2147483647;
    }
    if (x > -2147483648.0f) {
        return (int32_t)x;
    }
    return x <= -2147483648.0f ? -2147483647 - 1 : 0;
}
",
    ),
    (
        "truncated",
        "/* From 2^23 on all numbers are whole. */
static float truncated(float x)
{
    return x < 8388608.0f && x > -8388608.0f ? (float)whole_of(x) : x;
}
",
    ),
    (
        "rounded_down",
        "static float rounded_down(float x)
{
    const float whole = truncated(x);
    return whole > x ? whole - 1.0f : whole;
}
",
    ),
];

/// The functions that printed code calls, for its file.
pub fn helpers(code: &str) -> String {
    let mut all = String::new();
    for (name, text) in HELPERS.iter().rev() {
        let call = format!("{name}(");
        if code.contains(&call) || all.contains(&call) {
            all = format!("{text}\n{all}");
        }
    }
    all
}

/// Code with its helpers, whose names begin with `name` then: several files can be included in one.
pub fn with_own_helpers(code: &str, name: &str) -> String {
    let mut text = code.to_owned();
    for (helper, _) in HELPERS {
        let call = format!("{helper}(");
        let mut pieces = text.split(&call);
        let mut named = pieces.next().unwrap_or_default().to_owned();
        for piece in pieces {
            // Another name may end with the helper's.
            if !named.ends_with(|last: char| last.is_alphanumeric() || last == '_') {
                named = named + name + "_";
            }
            named = named + &call + piece;
        }
        text = named;
    }
    text
}

/// The name of a type.
pub fn type_name(ty: Ty) -> &'static str {
    match ty {
        Ty::F32 => "float",
        Ty::I32 => "int32_t",
        Ty::U32 => "uint32_t",
        Ty::Bool => "bool",
    }
}

/// A constant, such as `1.5f`.
pub fn constant(bits: u32, ty: Ty) -> String {
    let x = f32::from_bits(bits);
    match ty {
        Ty::F32 if !x.is_finite() => format!("number_of({bits}u)"),
        Ty::F32 if x.is_sign_negative() => format!("({x:?}f)"),
        Ty::F32 => format!("{x:?}f"),
        Ty::I32 if bits == 1 << 31 => "(-2147483647 - 1)".to_owned(),
        Ty::I32 if bits > 1 << 31 => format!("({})", bits as i32),
        Ty::I32 => bits.to_string(),
        Ty::U32 if bits >= 1 << 24 => format!("0x{bits:x}u"),
        Ty::U32 => format!("{bits}u"),
        Ty::Bool => (bits != 0).to_string(),
    }
}

/// Numbers of the buffers that a program reads or writes.
pub fn touched(program: &Program) -> BTreeSet<u32> {
    let mut touched = BTreeSet::new();
    visit(&program.body, &mut |statement| {
        if let Statement::Load { address, .. } | Statement::Store { address, .. } = statement {
            touched.insert(address.buffer);
        }
    });
    touched
}

/// Whether a program reads a word of a buffer that is a struct.
pub fn loads(program: &Program, buffer: u32, word: u32) -> bool {
    let uses = program.uses();
    let mut is_loaded = false;
    visit(&program.body, &mut |statement| {
        if let Statement::Load { targets, address } = statement {
            let used = (0..).zip(targets).filter(|(_, target)| uses.contains_key(target));
            is_loaded |= address.buffer == buffer && used.into_iter().any(|(at, _)| address.offset + at == word);
        }
    });
    is_loaded
}

/// Prints a program as statements of a function, which `memory` has the buffers of, by binding number. Its own place among others is in the
/// parameters `workgroup` and `lane`, if it asks for it.
pub fn print(program: &Program, memory: &[Memory]) -> String {
    let mut printer = Printer {
        program,
        memory,
        uses: program.uses(),
        texts: BTreeMap::new(),
        around: Vec::new(),
        left: BTreeSet::new(),
        out: String::new(),
        depth: 1,
    };
    printer.block(&program.body);
    printer.out
}

/// Computes what compares an unsigned number with the minimum or the maximum: compilers warn of comparisons that always come out alike.
pub(crate) fn compare_limits(program: &mut Program) {
    for at in 0..program.values.len() {
        if let Op::Convert(a) = program.values[at].op
            && let (Op::Constant(bits), Ty::Bool, Ty::U32) = (program.op(a), program.ty(a), program.values[at].ty)
        {
            program.values[at].op = Op::Constant(bits);
        }
        let Op::Binary(op, a, b) = program.values[at].op else {
            continue;
        };
        let bits = |value| match program.op(value) {
            Op::Constant(bits) if program.ty(value) == Ty::U32 => Some(bits),
            _ => None,
        };
        let [least, greatest] = [0, u32::MAX].map(|limit| [a, b].map(|value| bits(value) == Some(limit)));
        let op = match (op, least, greatest) {
            (Binary::GreaterEqual, [_, true], _)
            | (Binary::LessEqual, [true, _], _)
            | (Binary::LessEqual, _, [_, true])
            | (Binary::GreaterEqual, _, [true, _]) => Op::Constant(1),
            (Binary::Less, [_, true], _)
            | (Binary::Greater, [true, _], _)
            | (Binary::Greater, _, [_, true])
            | (Binary::Less, _, [true, _]) => Op::Constant(0),
            (Binary::Min, [true, _], _)
            | (Binary::Max, [_, true], _)
            | (Binary::Max, _, [true, _])
            | (Binary::Min, _, [_, true]) => Op::Bitcast(a),
            (Binary::Min, [_, true], _)
            | (Binary::Max, [true, _], _)
            | (Binary::Max, _, [_, true])
            | (Binary::Min, _, [true, _]) => Op::Bitcast(b),
            _ => continue,
        };
        program.values[at].op = op;
    }
}

struct Printer<'a> {
    program: &'a Program,
    memory: &'a [Memory],
    uses: BTreeMap<Value, u32>,
    /// Expressions of values that are printed at their use.
    texts: BTreeMap<Value, String>,
    /// Blocks that can be left around the statement, and whether each is a loop.
    around: Vec<(Label, bool)>,
    /// Blocks that jumps leave.
    left: BTreeSet<Label>,
    out: String,
    depth: usize,
}

impl Printer<'_> {
    fn line(&mut self, text: &str) {
        let _ = writeln!(self.out, "{:indent$}{text}", "", indent = 4 * self.depth);
    }

    fn block(&mut self, block: &Block) {
        for statement in block {
            self.statement(statement);
        }
    }

    fn indented(&mut self, block: &Block) {
        self.depth += 1;
        self.block(block);
        self.depth -= 1;
    }

    fn statement(&mut self, statement: &Statement) {
        match statement {
            Statement::Let(value) => self.computed(*value),
            Statement::Load { targets, address } => self.load(targets, address),
            Statement::Declare(variable) => {
                let info = &self.program.variables[variable.0 as usize];
                let (ty, init) = (type_name(info.ty), constant(info.init, info.ty));
                let name = self.variable(*variable);
                self.line(&format!("{ty} {name} = {};", bare(&init)));
            }
            Statement::DeclareArray(array) => {
                let info = &self.program.arrays[array.0 as usize];
                let elements: Vec<_> = info.init.iter().map(|bits| constant(*bits, info.ty)).collect();
                let (ty, name) = (type_name(info.ty), self.array(*array));
                let (count, elements) = (elements.len(), elements.join(", "));
                self.line(&format!("{ty} {name}[{count}] = {{{elements}}};"));
            }
            Statement::Write(variable, value) => {
                let (name, value) = (self.variable(*variable), self.text(*value));
                self.line(&format!("{name} = {};", bare(&value)));
            }
            Statement::WriteElement {
                array, index, value, ..
            } => {
                let (element, value) = (self.element(*array, *index), self.text(*value));
                self.line(&format!("{element} = {};", bare(&value)));
            }
            Statement::Store { address, value, .. } => self.store(address, *value),
            Statement::If {
                condition,
                accept,
                reject,
            } => self.branch(*condition, accept, reject),
            Statement::Loop { label, body, .. } => {
                self.around.push((*label, true));
                self.line("for (;;) {");
                self.indented(body);
                self.line("}");
                self.end(*label);
            }
            Statement::Labeled { label, body, .. } => {
                self.around.push((*label, false));
                let mut is_left = false;
                visit(body, &mut |statement| {
                    is_left |= matches!(statement, Statement::Exit(left) if left == label);
                });
                if is_left {
                    self.line("{");
                    self.indented(body);
                    self.line("}");
                } else {
                    self.block(body);
                }
                self.end(*label);
            }
            Statement::Exit(label) => {
                let innermost = self.around.iter().rev().find(|(_, is_loop)| *is_loop);
                if innermost.is_some_and(|(innermost, _)| innermost == label) {
                    self.line("break;");
                } else {
                    self.left.insert(*label);
                    self.line(&format!("goto end_{};", label.0));
                }
            }
        }
    }

    /// Ends a block that can be left.
    fn end(&mut self, label: Label) {
        self.around.pop();
        if self.left.contains(&label) {
            self.line(&format!("end_{}:;", label.0));
        }
    }

    fn branch(&mut self, condition: Value, accept: &Block, reject: &Block) {
        let test = self.text(condition);
        if accept.is_empty() {
            self.line(&format!("if (!{test}) {{"));
            self.indented(reject);
        } else {
            self.line(&format!("if ({}) {{", bare(&test)));
            self.indented(accept);
            if !reject.is_empty() {
                self.line("} else {");
                self.indented(reject);
            }
        }
        self.line("}");
    }

    /// Prints a value, or keeps its expression for its only use.
    fn computed(&mut self, value: Value) {
        let op = self.program.op(value);
        let text = match op {
            Op::Constant(_) => return,
            _ => self.expression(value),
        };
        let is_pure = !matches!(op, Op::Read(_) | Op::ReadElement(..));
        if is_pure && self.uses.get(&value) == Some(&1) && text.len() <= INLINE {
            self.texts.insert(value, text);
        } else {
            self.named(value, &text);
        }
    }

    fn named(&mut self, value: Value, text: &str) {
        let (ty, name) = (type_name(self.program.ty(value)), self.program.name(value));
        self.line(&format!("const {ty} {name} = {};", bare(text)));
    }

    fn variable(&self, variable: Variable) -> String {
        self.program.variable_name(variable)
    }

    fn array(&self, array: Array) -> String {
        format!("{}_a{}", self.program.arrays[array.0 as usize].name, array.0)
    }

    /// An element; beyond the last, the last one.
    fn element(&self, array: Array, index: Value) -> String {
        let last = self.program.arrays[array.0 as usize].init.len() as u32 - 1;
        format!("{}[{}]", self.array(array), self.clamped(index, last))
    }

    /// An index of at most `last`.
    fn clamped(&self, index: Value, last: u32) -> String {
        if let Op::Constant(bits) = self.program.op(index) {
            return bits.min(last).to_string();
        }
        let text = self.text(index);
        let text = match self.program.ty(index) {
            Ty::I32 => format!("(uint32_t){text}"),
            _ => text,
        };
        format!("{text} < {last}u ? {} : {last}u", bare(&text))
    }

    /// Expression of a value at its use.
    fn text(&self, value: Value) -> String {
        match self.program.op(value) {
            Op::Constant(bits) => constant(bits, self.program.ty(value)),
            _ => self
                .texts
                .get(&value)
                .cloned()
                .unwrap_or_else(|| self.program.name(value)),
        }
    }

    fn is_constant(&self, value: Value) -> bool {
        matches!(self.program.op(value), Op::Constant(_))
    }

    fn expression(&self, value: Value) -> String {
        let ty = self.program.ty(value);
        match self.program.op(value) {
            Op::Constant(_) | Op::Loaded => self.text(value),
            Op::Lane => "lane".to_owned(),
            Op::Workgroup => "workgroup".to_owned(),
            Op::Read(variable) => self.variable(variable),
            Op::ReadElement(array, index) => self.element(array, index),
            Op::Unary(op, a) => unary(op, ty, &self.text(a)),
            Op::Binary(op, a, b) => self.binary(op, a, b),
            Op::Select {
                condition,
                accept,
                reject,
            } => {
                let [test, yes, no] = [condition, accept, reject].map(|value| self.text(value));
                // An `unsigned` has 16 bits on small processors.
                let is_short = ty == Ty::U32 && self.is_constant(accept) && self.is_constant(reject);
                let cast = if is_short { "(uint32_t)" } else { "" };
                format!("({test} ? {cast}{yes} : {cast}{no})")
            }
            Op::Convert(a) => {
                let x = self.text(a);
                match (self.program.ty(a), ty) {
                    (from, to) if from == to => x,
                    (Ty::Bool, Ty::F32) => format!("({x} ? 1.0f : 0.0f)"),
                    (Ty::Bool, Ty::I32) => format!("({x} ? 1 : 0)"),
                    (Ty::Bool, _) => format!("({x} ? (uint32_t)1u : (uint32_t)0u)"),
                    (Ty::F32, Ty::Bool) => format!("({x} != 0.0f)"),
                    (_, Ty::Bool) => format!("({x} != 0)"),
                    (Ty::F32, Ty::I32) => format!("whole_of({})", bare(&x)),
                    (Ty::F32, Ty::U32) => format!("((uint32_t)whole_of({}))", bare(&x)),
                    (Ty::U32, Ty::F32) => format!("((float)(int32_t){x})"),
                    (_, ty) => format!("(({}){x})", type_name(ty)),
                }
            }
            Op::Bitcast(a) => {
                let x = self.text(a);
                match (self.program.ty(a), ty) {
                    (from, to) if from == to => x,
                    (Ty::F32, Ty::I32) => format!("((int32_t)bits_of({}))", bare(&x)),
                    (Ty::F32, _) => format!("bits_of({})", bare(&x)),
                    (Ty::I32, Ty::F32) => format!("number_of((uint32_t){x})"),
                    (_, Ty::F32) => format!("number_of({})", bare(&x)),
                    (_, ty) => format!("(({}){x})", type_name(ty)),
                }
            }
        }
    }

    fn binary(&self, op: Binary, a: Value, b: Value) -> String {
        let ty = self.program.ty(a);
        let (mut x, y) = (self.text(a), self.text(b));
        if ty == Ty::U32 && self.is_constant(a) && self.is_constant(b) {
            x = format!("(uint32_t){x}");
        }
        let shifted_by = || match self.program.op(b) {
            Op::Constant(bits) => (bits & 31).to_string(),
            _ => format!("({y} & 31u)"),
        };
        // Unsigned integers wrap.
        let wrapping = |symbol: &str| match ty {
            Ty::I32 => format!("((int32_t)((uint32_t){x} {symbol} (uint32_t){y}))"),
            _ => format!("({x} {symbol} {y})"),
        };
        let divisor = || match self.program.op(b) {
            Op::Constant(bits) => format!("{}u", bits.max(1)),
            _ if ty == Ty::I32 => format!("divisor_of((uint32_t){y})"),
            _ => format!("divisor_of({})", bare(&y)),
        };
        let divided = |symbol: &str| match ty {
            Ty::I32 => format!("((int32_t)((uint32_t){x} {symbol} {}))", divisor()),
            _ => format!("({x} {symbol} {})", divisor()),
        };
        match op {
            Binary::Add => wrapping("+"),
            Binary::Subtract => wrapping("-"),
            Binary::Multiply => wrapping("*"),
            Binary::Divide => divided("/"),
            Binary::Remainder => divided("%"),
            Binary::Min => format!("({x} < {y} ? {x} : {y})"),
            Binary::Max => format!("({x} > {y} ? {x} : {y})"),
            Binary::And if ty == Ty::Bool => format!("({x} && {y})"),
            Binary::Or if ty == Ty::Bool => format!("({x} || {y})"),
            Binary::Xor if ty == Ty::Bool => format!("({x} != {y})"),
            Binary::And => format!("({x} & {y})"),
            Binary::Or => format!("({x} | {y})"),
            Binary::Xor => format!("({x} ^ {y})"),
            Binary::ShiftLeft if ty == Ty::I32 => format!("((int32_t)((uint32_t){x} << {}))", shifted_by()),
            Binary::ShiftLeft => format!("({x} << {})", shifted_by()),
            Binary::ShiftRight => format!("({x} >> {})", shifted_by()),
            Binary::Equal => format!("({x} == {y})"),
            Binary::NotEqual => format!("({x} != {y})"),
            Binary::Less => format!("({x} < {y})"),
            Binary::LessEqual => format!("({x} <= {y})"),
            Binary::Greater => format!("({x} > {y})"),
            Binary::GreaterEqual => format!("({x} >= {y})"),
        }
    }

    /// A word's place and type.
    fn place(&self, address: &Address, word: u32) -> (String, Ty) {
        let offset = address.offset + word;
        match &self.memory[address.buffer as usize] {
            Memory::Places(places) => {
                let element = match address.element.map(|element| self.program.op(element)) {
                    None => 0,
                    Some(Op::Constant(bits)) => bits,
                    Some(_) => unreachable!("places are known"),
                };
                places[(element * address.stride + offset) as usize].clone()
            }
            Memory::Words(name, elements) => (format!("{name}[{}]", self.at(address, offset, elements)), Ty::U32),
            Memory::Constants(name, elements) => (
                format!("constant_of(&{name}[{}])", self.at(address, offset, elements)),
                Ty::U32,
            ),
        }
    }

    /// The index of a word in an array with so many elements.
    fn at(&self, address: &Address, offset: u32, elements: &str) -> String {
        let Some(element) = address.element else {
            return offset.to_string();
        };
        let index = self.text(element);
        let index = match self.program.ty(element) {
            Ty::I32 => format!("(uint32_t){index}"),
            _ => index,
        };
        let clamped = format!("({index} < {elements} ? {index} : {elements} - 1u)");
        match (address.stride, offset) {
            (1, 0) => bare(&clamped).to_owned(),
            (1, _) => format!("{clamped} + {offset}u"),
            (stride, 0) => format!("{clamped} * {stride}u"),
            (stride, _) => format!("{clamped} * {stride}u + {offset}u"),
        }
    }

    fn load(&mut self, targets: &[Value], address: &Address) {
        for (word, target) in (0..).zip(targets) {
            if self.uses.contains_key(target) {
                let (place, ty) = self.place(address, word);
                let text = recast(&place, ty, self.program.ty(*target));
                self.named(*target, &text);
            }
        }
    }

    fn store(&mut self, address: &Address, value: Value) {
        let (place, ty) = self.place(address, 0);
        let text = recast(&self.text(value), self.program.ty(value), ty);
        self.line(&format!("{place} = {};", bare(&text)));
    }
}

/// The same bits as another type.
fn recast(text: &str, from: Ty, to: Ty) -> String {
    match (from, to) {
        _ if from == to => text.to_owned(),
        (Ty::F32, Ty::U32) => format!("bits_of({})", bare(text)),
        (Ty::F32, _) => format!("({})bits_of({})", type_name(to), bare(text)),
        (Ty::U32, Ty::F32) => format!("number_of({})", bare(text)),
        (_, Ty::F32) => format!("number_of((uint32_t){text})"),
        (_, Ty::Bool) => format!("{text} != 0"),
        _ => format!("({}){text}", type_name(to)),
    }
}

fn unary(op: Unary, ty: Ty, x: &str) -> String {
    match (op, ty) {
        (Unary::Negate, Ty::F32) => format!("(-{x})"),
        (Unary::Negate, Ty::I32) => format!("((int32_t)(0u - (uint32_t){x}))"),
        (Unary::Negate, _) => format!("(0u - {x})"),
        (Unary::Not, Ty::Bool) => format!("(!{x})"),
        (Unary::Not, _) => format!("(~{x})"),
        (Unary::Abs, Ty::F32) => format!("number_of(bits_of({}) & 0x7fffffffu)", bare(x)),
        (Unary::Abs, Ty::I32) => format!("({x} < 0 ? (int32_t)(0u - (uint32_t){x}) : {x})"),
        (Unary::Abs, _) => x.to_owned(),
        (Unary::Floor, _) => format!("rounded_down({})", bare(x)),
        (Unary::Trunc, _) => format!("truncated({})", bare(x)),
    }
}

/// An expression without the parentheses around it.
fn bare(text: &str) -> &str {
    let Some(inner) = text.strip_prefix('(').and_then(|text| text.strip_suffix(')')) else {
        return text;
    };
    let mut depth = 0_i32;
    for c in inner.chars() {
        depth += i32::from(c == '(') - i32::from(c == ')');
        if depth < 0 {
            return text;
        }
    }
    inner
}
