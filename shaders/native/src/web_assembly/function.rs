//! The steps of a function, and how they are written: without those that nothing needs, with results on the engine's stack if the next
//! step takes them, and in as few local variables as their lifetimes allow.

use std::collections::HashMap;

use wasm_encoder::{Instruction, ValType};

/// A constant, by its bits, or the result of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Value {
    Int(u32),
    Float(u32),
    Vector([u32; 4]),
    Result(u32),
}

/// A variable that may be written several times.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Variable {
    number: u32,
    ty: ValType,
}

/// What a step does with its operands.
#[derive(Clone, Debug)]
pub(crate) enum Code {
    /// Computes a value, and nothing else.
    Pure(Instruction<'static>),
    Effect(Instruction<'static>),
    Get(Variable),
    Set(Variable),
    /// Control flow, at which nothing may wait on the engine's stack.
    Control(Instruction<'static>),
}

#[derive(Clone, Debug)]
struct Step {
    code: Code,
    operands: [Option<Value>; 3],
    result: Option<u32>,
}

impl Step {
    fn operands(&self) -> impl DoubleEndedIterator<Item = Value> {
        self.operands.iter().copied().flatten()
    }

    /// Results among the operands.
    fn taken(&self) -> impl Iterator<Item = usize> {
        self.operands().filter_map(|operand| match operand {
            Value::Result(number) => Some(number as usize),
            _ => None,
        })
    }

    /// Whether it only computes its result.
    fn is_pure(&self) -> bool {
        matches!(self.code, Code::Pure(_) | Code::Get(_))
    }
}

/// A function so far.
#[derive(Debug, Default)]
pub(crate) struct Steps {
    all: Vec<Step>,
    /// Types of results and of variables.
    results: Vec<ValType>,
    variables: Vec<ValType>,
    /// Blocks that are open.
    depth: u32,
}

impl Steps {
    /// A value that an instruction computes.
    pub(crate) fn value(&mut self, instruction: Instruction<'static>, ty: ValType, operands: &[Value]) -> Value {
        self.push(Code::Pure(instruction), operands, Some(ty))
    }

    pub(crate) fn act(&mut self, code: Code, operands: &[Value]) {
        self.push(code, operands, None);
    }

    pub(crate) fn variable(&mut self, ty: ValType) -> Variable {
        self.variables.push(ty);
        Variable {
            number: self.variables.len() as u32 - 1,
            ty,
        }
    }

    pub(crate) fn get(&mut self, variable: Variable) -> Value {
        self.push(Code::Get(variable), &[], Some(variable.ty))
    }

    /// Begins a block, a loop or an `if`, and returns how many were open.
    pub(crate) fn open(&mut self, instruction: Instruction<'static>, operands: &[Value]) -> u32 {
        self.act(Code::Control(instruction), operands);
        self.depth += 1;
        self.depth - 1
    }

    pub(crate) fn close(&mut self) {
        self.act(Code::Control(Instruction::End), &[]);
        self.depth -= 1;
    }

    pub(crate) fn depth(&self) -> u32 {
        self.depth
    }

    pub(crate) fn type_of(&self, value: Value) -> ValType {
        match value {
            Value::Int(_) => ValType::I32,
            Value::Float(_) => ValType::F32,
            Value::Vector(_) => ValType::V128,
            Value::Result(number) => self.results[number as usize],
        }
    }

    fn push(&mut self, code: Code, operands: &[Value], ty: Option<ValType>) -> Value {
        let number = self.results.len() as u32;
        self.results.extend(ty);
        self.all.push(Step {
            code,
            operands: std::array::from_fn(|at| operands.get(at).copied()),
            result: ty.map(|_| number),
        });
        Value::Result(number)
    }

    /// The types of local variables, and the instructions.
    pub(crate) fn written(mut self, parameters: &[ValType]) -> (Vec<ValType>, Vec<Instruction<'static>>) {
        let uses = self.remove_unused();
        let ends = self.ends();
        let steps = std::mem::take(&mut self.all);
        let mut writer = Writer {
            first_variable: parameters.len() as u32,
            results: &self.results,
            uses: &uses,
            locals: self.variables.clone(),
            places: vec![None; self.results.len()],
            free: HashMap::new(),
            waiting: Vec::new(),
            instructions: Vec::new(),
        };
        for (step, ended) in steps.iter().zip(&ends) {
            writer.step(step);
            for number in ended {
                writer.release(*number);
            }
        }
        (writer.locals, writer.instructions)
    }

    /// Leaves out what computes unused results. Returns how often each result is used.
    fn remove_unused(&mut self) -> Vec<u32> {
        let mut uses = vec![0; self.results.len()];
        for step in &self.all {
            step.taken().for_each(|number| uses[number] += 1);
        }
        let mut needed = Vec::with_capacity(self.all.len());
        for step in std::mem::take(&mut self.all).into_iter().rev() {
            let is_used = step.result.is_none_or(|number| uses[number as usize] > 0);
            if is_used || !step.is_pure() {
                needed.push(step);
            } else {
                step.taken().for_each(|number| uses[number] -= 1);
            }
        }
        needed.reverse();
        self.all = needed;
        uses
    }

    /// For each step, the results of which it is the last that may need them. What a loop takes from before it is needed until it ends.
    fn ends(&self) -> Vec<Vec<usize>> {
        // The block that each step opens, up to its end.
        let mut closed = HashMap::new();
        let mut open = Vec::new();
        for (at, step) in self.all.iter().enumerate() {
            match step.code {
                Code::Control(Instruction::Block(_) | Instruction::Loop(_) | Instruction::If(_)) => open.push(at),
                Code::Control(Instruction::End) => _ = open.pop().map(|begin| closed.insert(begin, at)),
                _ => {}
            }
        }
        let mut made = vec![0; self.results.len()];
        let mut last = vec![None; self.results.len()];
        // Where each open block began, and whether it is a loop.
        let mut blocks: Vec<(usize, bool)> = Vec::new();
        for (at, step) in self.all.iter().enumerate() {
            for number in step.taken() {
                let entered = |(begin, is_loop): &&(usize, bool)| *is_loop && *begin > made[number];
                let end = blocks.iter().find(entered).map_or(at, |(begin, _)| closed[begin]);
                last[number] = last[number].max(Some(end));
            }
            if let Some(number) = step.result {
                made[number as usize] = at;
            }
            match step.code {
                Code::Control(Instruction::Loop(_)) => blocks.push((at, true)),
                Code::Control(Instruction::Block(_) | Instruction::If(_)) => blocks.push((at, false)),
                Code::Control(Instruction::End) => _ = blocks.pop(),
                _ => {}
            }
        }
        let mut ends = vec![Vec::new(); self.all.len()];
        for (number, last) in last.into_iter().enumerate() {
            if let Some(last) = last {
                ends[last].push(number);
            }
        }
        ends
    }
}

struct Writer<'a> {
    /// Variables come after the parameters.
    first_variable: u32,
    results: &'a [ValType],
    uses: &'a [u32],
    /// Types of local variables: those that may be written several times, then those of results.
    locals: Vec<ValType>,
    places: Vec<Option<u32>>,
    free: HashMap<ValType, Vec<u32>>,
    /// Results on the engine's stack.
    waiting: Vec<usize>,
    instructions: Vec<Instruction<'static>>,
}

impl Writer<'_> {
    fn step(&mut self, step: &Step) {
        let on_stack = self.matched(step);
        self.waiting.truncate(self.waiting.len() - on_stack);
        for operand in step.operands().skip(on_stack) {
            let instruction = match operand {
                Value::Int(bits) => Instruction::I32Const(bits.cast_signed()),
                Value::Float(bits) => Instruction::F32Const(f32::from_bits(bits).into()),
                Value::Vector(words) => Instruction::V128Const(vector(words)),
                Value::Result(number) => {
                    Instruction::LocalGet(self.places[number as usize].expect("it is no longer on the stack"))
                }
            };
            self.instructions.push(instruction);
        }
        self.instructions.push(match &step.code {
            Code::Pure(instruction) | Code::Effect(instruction) | Code::Control(instruction) => instruction.clone(),
            Code::Get(variable) => Instruction::LocalGet(self.first_variable + variable.number),
            Code::Set(variable) => Instruction::LocalSet(self.first_variable + variable.number),
        });
        if let Some(number) = step.result {
            self.waiting.push(number as usize);
            if self.uses[number as usize] > 1 {
                self.store_waiting();
            }
        }
    }

    /// How many of a step's first operands are on top of the stack. None of its others is on it, and nothing at all at a jump.
    fn matched(&mut self, step: &Step) -> usize {
        let operands: Vec<Value> = step.operands().collect();
        let is_waiting =
            |operand: &Value| matches!(operand, Value::Result(number) if self.waiting.contains(&(*number as usize)));
        let count = operands.iter().take_while(|operand| is_waiting(operand)).count();
        let top = self.waiting.len() - count.min(self.waiting.len());
        let in_order = self.waiting[top..]
            .iter()
            .zip(&operands)
            .all(|(number, operand)| *operand == Value::Result(*number as u32));
        let others = operands[count..].iter().any(is_waiting);
        let is_alone = top == 0 || !matches!(step.code, Code::Control(_));
        if in_order && !others && is_alone {
            return count;
        }
        self.store_waiting();
        0
    }

    /// Moves what is on the stack to local variables.
    fn store_waiting(&mut self) {
        while let Some(number) = self.waiting.pop() {
            let ty = self.results[number];
            let place = self.free.entry(ty).or_default().pop().unwrap_or_else(|| {
                self.locals.push(ty);
                self.first_variable + self.locals.len() as u32 - 1
            });
            self.places[number] = Some(place);
            self.instructions.push(Instruction::LocalSet(place));
        }
    }

    /// Frees the variable of a result that nothing needs any more.
    fn release(&mut self, number: usize) {
        if let Some(place) = self.places[number].take() {
            self.free.entry(self.results[number]).or_default().push(place);
        }
    }
}

/// Four words as the bits of a constant.
fn vector(words: [u32; 4]) -> i128 {
    let bits = (0..).zip(words).map(|(at, word)| u128::from(word) << (32 * at));
    bits.fold(0, |all, word| all | word).cast_signed()
}
