//! Prints a program as the body of a function for one lane, in any language that says how it writes each operation: one walk over the tree
//! for all of them, with the same bits.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use crate::print::INLINE;
use crate::tree::{Address, Array, Binary, Block, Label, Op, Program, Statement, Ty, Unary, Value, Variable, visit};

/// A buffer as the function has it.
#[derive(Clone, Debug)]
pub enum Memory {
    /// An array of words with this name; its number of elements, 1 or more.
    Words(String, u32),
    /// The same, of constants.
    Constants(String, u32),
    /// A place with a type for each word. All are read and written at constant places.
    Places(Vec<(String, Ty)>),
}

/// An expression, and its bits if it is a constant.
#[derive(Clone, Debug)]
pub struct Operand {
    /// The expression.
    pub text: String,
    /// Bits of a constant.
    pub bits: Option<u32>,
}

/// What begins a block of statements.
#[derive(Clone, Copy, Debug)]
pub enum Opening<'a> {
    /// If this condition is true.
    If(&'a str),
    /// If the condition before is false.
    Else,
    /// Until it is left.
    Loop(Label),
    /// Once, and it can be left.
    Once(Label),
}

/// How a language leaves a block that isn't the innermost loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exits {
    /// It jumps to the block's end.
    Jumps,
    /// It names the block: each has its name.
    Names,
    /// It can't: blocks are loops, each is left by itself, and the variable `left` says for which one.
    Flags,
}

/// How a language writes what programs do. Expressions are names, numbers, calls, or have parentheses around them.
pub trait Language {
    /// How it leaves blocks.
    fn exits(&self) -> Exits;
    /// A constant.
    fn constant(&self, bits: u32, ty: Ty) -> String;
    /// An operation on one operand.
    fn unary(&self, op: Unary, ty: Ty, x: &str) -> String;
    /// An operation on two operands, of this type each.
    fn binary(&self, op: Binary, ty: Ty, x: &Operand, y: &Operand) -> String;
    /// One of two operands.
    fn select(&self, ty: Ty, test: &str, accept: &Operand, reject: &Operand) -> String;
    /// The number as another type.
    fn convert(&self, from: Ty, to: Ty, x: &str) -> String;
    /// The bits as another type.
    fn bitcast(&self, from: Ty, to: Ty, x: &str) -> String;
    /// An element of a local array.
    fn element(&self, array: &str, index: &str) -> String;
    /// A word of a table of constants.
    fn word(&self, table: &str, index: &str) -> String;
    /// The name of a local value, variable or array.
    fn local(&self, name: String) -> String {
        name
    }
    /// Declares a local value, which may be `changed` later.
    fn declaration(&self, name: &str, ty: Ty, value: &str, changed: bool) -> String;
    /// Declares a local array.
    fn array(&self, name: &str, ty: Ty, elements: &[String]) -> String;
    /// Sets a variable or an element.
    fn assignment(&self, place: &str, value: &str) -> String;
    /// Begins a block.
    fn open(&self, opening: Opening) -> String;
    /// Ends a block, by the indented line and the line after it that there are.
    fn close(&self, opening: Opening) -> [Option<&'static str>; 2];
    /// Leaves the innermost loop, or in a language with names this block.
    fn leave(&self, label: Label) -> String;
    /// The only line of a block in which nothing happens.
    fn nothing(&self) -> Option<&'static str> {
        None
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

/// Prints a program as statements of a function, `depth` levels deep, which `memory` has the buffers of, by binding number. Its own place
/// among others is in the parameters `workgroup` and `lane`, if it asks for it.
pub fn print(program: &Program, language: &dyn Language, memory: &[Memory], depth: usize) -> String {
    let mut printer = Printer {
        program,
        language,
        memory,
        uses: program.uses(),
        texts: BTreeMap::new(),
        around: Vec::new(),
        left: BTreeSet::new(),
        out: String::new(),
        depth,
    };
    printer.block(&program.body);
    if language.exits() == Exits::Flags && printer.out.contains(LEFT) {
        let flag = language.declaration(&printer.flag(), Ty::U32, &language.constant(0, Ty::U32), true);
        return format!("{:indent$}{flag}\n{}", "", printer.out, indent = 4 * depth);
    }
    printer.out
}

/// The variable of [`Exits::Flags`]: the block that is left, or 0.
const LEFT: &str = "left_block";

struct Printer<'a> {
    program: &'a Program,
    language: &'a dyn Language,
    memory: &'a [Memory],
    uses: BTreeMap<Value, u32>,
    /// Expressions of values that are printed at their use.
    texts: BTreeMap<Value, String>,
    /// Blocks that can be left around the statement, and whether each is a loop.
    around: Vec<(Label, bool)>,
    /// Blocks that exits leave from within others.
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

    /// A block with what begins and ends it.
    fn enclosed(&mut self, opening: Opening, block: &Block) {
        self.line(&self.language.open(opening));
        self.depth += 1;
        let begin = self.out.len();
        self.block(block);
        let [within, after] = self.language.close(opening);
        let nothing = self.language.nothing().filter(|_| self.out.len() == begin);
        if let Some(last) = within.or(nothing) {
            self.line(last);
        }
        self.depth -= 1;
        if let Some(end) = after {
            self.line(end);
        }
    }

    fn statement(&mut self, statement: &Statement) {
        match statement {
            Statement::Let(value) => self.computed(*value),
            Statement::Load { targets, address } => self.load(targets, address),
            Statement::Declare(variable) => {
                let info = &self.program.variables[variable.0 as usize];
                let init = self.language.constant(info.init, info.ty);
                let declared = self
                    .language
                    .declaration(&self.variable(*variable), info.ty, bare(&init), true);
                self.line(&declared);
            }
            Statement::DeclareArray(array) => {
                let info = &self.program.arrays[array.0 as usize];
                let element = |bits: &u32| self.language.constant(*bits, info.ty);
                let elements: Vec<_> = info.init.iter().map(element).collect();
                let declared = self.language.array(&self.array(*array), info.ty, &elements);
                self.line(&declared);
            }
            Statement::Write(variable, value) => self.set(&self.variable(*variable), &self.text(*value)),
            Statement::WriteElement {
                array, index, value, ..
            } => self.set(&self.element(*array, *index), &self.text(*value)),
            Statement::Store { address, value, .. } => {
                let (place, ty) = self.place(address, 0);
                let text = self.recast(&self.text(*value), self.program.ty(*value), ty);
                self.set(&place, &text);
            }
            Statement::If {
                condition,
                accept,
                reject,
            } => self.branch(*condition, accept, reject),
            Statement::Loop { label, body, .. } => {
                self.around.push((*label, true));
                self.enclosed(Opening::Loop(*label), body);
                self.end(*label);
            }
            Statement::Labeled { label, body, .. } => {
                let is_loop = self.language.exits() == Exits::Flags;
                let mut is_left = false;
                visit(body, &mut |statement| {
                    is_left |= matches!(statement, Statement::Exit(left) if left == label);
                });
                if is_left {
                    self.around.push((*label, is_loop));
                    self.enclosed(Opening::Once(*label), body);
                    self.end(*label);
                } else {
                    self.block(body);
                }
            }
            Statement::Exit(label) => self.exit(*label),
        }
    }

    fn exit(&mut self, label: Label) {
        let innermost = self.around.iter().rev().find(|(_, is_loop)| *is_loop);
        let is_innermost = innermost.is_some_and(|(innermost, _)| *innermost == label);
        let leave = self.language.leave(label);
        if is_innermost || self.language.exits() == Exits::Names {
            self.line(&leave);
            return;
        }
        self.left.insert(label);
        if self.language.exits() == Exits::Jumps {
            self.line(&format!("goto end_{};", label.0));
        } else {
            let number = self.language.constant(label.0 + 1, Ty::U32);
            self.set(&self.flag(), &number);
            self.line(&leave);
        }
    }

    fn flag(&self) -> String {
        self.language.local(LEFT.to_owned())
    }

    /// Ends a block that can be left.
    fn end(&mut self, label: Label) {
        self.around.pop();
        let is_left = self.left.remove(&label);
        match self.language.exits() {
            Exits::Jumps if is_left => self.line(&format!("end_{}:;", label.0)),
            Exits::Flags => {
                // Exits from within it to blocks around it come by here.
                let none = Operand {
                    text: self.language.constant(0, Ty::U32),
                    bits: Some(0),
                };
                let flag = Operand {
                    text: self.flag(),
                    bits: None,
                };
                if is_left {
                    let own = Operand {
                        text: self.language.constant(label.0 + 1, Ty::U32),
                        bits: Some(label.0 + 1),
                    };
                    let test = self.language.binary(Binary::Equal, Ty::U32, &flag, &own);
                    self.when(&test, |printer| printer.set(&flag.text, &none.text));
                }
                if !self.left.is_empty() {
                    let test = self.language.binary(Binary::NotEqual, Ty::U32, &flag, &none);
                    let leave = self.language.leave(label);
                    self.when(&test, |printer| printer.line(&leave));
                }
            }
            _ => {}
        }
    }

    fn when(&mut self, test: &str, then: impl FnOnce(&mut Self)) {
        let opening = Opening::If(bare(test));
        self.line(&self.language.open(opening));
        self.depth += 1;
        then(self);
        self.depth -= 1;
        if let [_, Some(end)] = self.language.close(opening) {
            self.line(end);
        }
    }

    fn branch(&mut self, condition: Value, accept: &Block, reject: &Block) {
        let test = self.text(condition);
        if accept.is_empty() {
            let test = self.language.unary(Unary::Not, Ty::Bool, &test);
            self.enclosed(Opening::If(bare(&test)), reject);
            return;
        }
        self.enclosed(Opening::If(bare(&test)), accept);
        if !reject.is_empty() {
            // Its first line takes the last one's place.
            if let [_, Some(end)] = self.language.close(Opening::If("")) {
                let end = format!("{:indent$}{end}\n", "", indent = 4 * self.depth);
                self.out.truncate(self.out.len() - end.len());
            }
            self.enclosed(Opening::Else, reject);
        }
    }

    fn set(&mut self, place: &str, value: &str) {
        let set = self.language.assignment(place, bare(value));
        self.line(&set);
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
        let declared = self
            .language
            .declaration(&self.name(value), self.program.ty(value), bare(text), false);
        self.line(&declared);
    }

    fn name(&self, value: Value) -> String {
        self.language.local(self.program.name(value))
    }

    fn variable(&self, variable: Variable) -> String {
        self.language.local(self.program.variable_name(variable))
    }

    fn array(&self, array: Array) -> String {
        let name = format!("{}_a{}", self.program.arrays[array.0 as usize].name, array.0);
        self.language.local(name)
    }

    /// An element; beyond the last, the last one.
    fn element(&self, array: Array, index: Value) -> String {
        let last = self.program.arrays[array.0 as usize].init.len() as u32 - 1;
        self.language
            .element(&self.array(array), bare(&self.clamped(index, last)))
    }

    /// An index of at most `last`.
    fn clamped(&self, index: Value, last: u32) -> String {
        if let Op::Constant(bits) = self.program.op(index) {
            return bits.min(last).to_string();
        }
        let index = Operand {
            text: self.recast(&self.text(index), self.program.ty(index), Ty::U32),
            bits: None,
        };
        let last = Operand {
            text: self.language.constant(last, Ty::U32),
            bits: Some(last),
        };
        self.language.binary(Binary::Min, Ty::U32, &index, &last)
    }

    /// Expression of a value at its use.
    fn text(&self, value: Value) -> String {
        match self.program.op(value) {
            Op::Constant(bits) => self.language.constant(bits, self.program.ty(value)),
            _ => self.texts.get(&value).cloned().unwrap_or_else(|| self.name(value)),
        }
    }

    fn operand(&self, value: Value) -> Operand {
        Operand {
            text: self.text(value),
            bits: match self.program.op(value) {
                Op::Constant(bits) => Some(bits),
                _ => None,
            },
        }
    }

    fn expression(&self, value: Value) -> String {
        let ty = self.program.ty(value);
        match self.program.op(value) {
            Op::Constant(_) | Op::Loaded => self.text(value),
            Op::Lane => "lane".to_owned(),
            Op::Workgroup => "workgroup".to_owned(),
            Op::Read(variable) => self.variable(variable),
            Op::ReadElement(array, index) => self.element(array, index),
            Op::Unary(op, a) => self.language.unary(op, ty, &self.text(a)),
            Op::Binary(op, a, b) => {
                let [x, y] = [a, b].map(|value| self.operand(value));
                self.language.binary(op, self.program.ty(a), &x, &y)
            }
            Op::Select {
                condition,
                accept,
                reject,
            } => {
                let [accept, reject] = [accept, reject].map(|value| self.operand(value));
                self.language.select(ty, &self.text(condition), &accept, &reject)
            }
            Op::Convert(a) => match self.program.ty(a) {
                from if from == ty => self.text(a),
                from => self.language.convert(from, ty, &self.text(a)),
            },
            Op::Bitcast(a) => self.recast(&self.text(a), self.program.ty(a), ty),
        }
    }

    /// The same bits as another type.
    fn recast(&self, text: &str, from: Ty, to: Ty) -> String {
        match (from, to) {
            _ if from == to => text.to_owned(),
            (Ty::Bool, _) | (_, Ty::Bool) => self.language.convert(from, to, text),
            _ => self.language.bitcast(from, to, text),
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
            Memory::Words(name, elements) | Memory::Constants(name, elements) => {
                let index = match address.element {
                    None => offset.to_string(),
                    Some(element) => self.index(element, address.stride, offset, elements - 1),
                };
                let word = match &self.memory[address.buffer as usize] {
                    Memory::Constants(..) => self.language.word(name, &index),
                    _ => self.language.element(name, &index),
                };
                (word, Ty::U32)
            }
        }
    }

    /// The index of a word in a table, which is too small for sums and products to wrap.
    fn index(&self, element: Value, stride: u32, offset: u32, last: u32) -> String {
        if let Op::Constant(element) = self.program.op(element) {
            return (element.min(last) * stride + offset).to_string();
        }
        let index = self.clamped(element, last);
        let [stride_text, offset_text] = [stride, offset].map(|number| self.language.constant(number, Ty::U32));
        match (stride, offset) {
            (1, 0) => bare(&index).to_owned(),
            (1, _) => format!("{index} + {offset_text}"),
            (_, 0) => format!("{index} * {stride_text}"),
            _ => format!("{index} * {stride_text} + {offset_text}"),
        }
    }

    fn load(&mut self, targets: &[Value], address: &Address) {
        for (word, target) in (0..).zip(targets) {
            if self.uses.contains_key(target) {
                let (place, ty) = self.place(address, word);
                let text = self.recast(&place, ty, self.program.ty(*target));
                self.named(*target, &text);
            }
        }
    }
}

/// An expression without the parentheses around it.
pub fn bare(text: &str) -> &str {
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
