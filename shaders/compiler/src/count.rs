//! Counts what a program does: the operations that a group of invocations issues, by class, if they run together as on a GPU. What some of
//! them do, all wait for.

use std::collections::{BTreeMap, HashMap};
use std::ops::{AddAssign, Sub};

use crate::interpret::{Buffers, Trap, Watch, run_watched};
use crate::tree::{Binary, Block, Op, Program, Statement, Ty, Unary, Value};

/// A class of operations that cost a processor about the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Class {
    /// Sums, differences and products of floats, their signs, minimum and maximum, and roundings.
    Float,
    /// Sums, differences, shifts and bits of integers and truth values.
    Integer,
    /// Products of integers.
    Product,
    /// Quotients and remainders of integers.
    Quotient,
    /// Comparisons, and selections by them.
    Selection,
    /// Conversions between integers and floats.
    Conversion,
    /// Words loaded.
    Load,
    /// Words stored.
    Store,
    /// Branches, and turns of loops.
    Branch,
}

impl Class {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Float,
        Self::Integer,
        Self::Product,
        Self::Quotient,
        Self::Selection,
        Self::Conversion,
        Self::Load,
        Self::Store,
        Self::Branch,
    ];

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Float => "float",
            Self::Integer => "integer",
            Self::Product => "integer product",
            Self::Quotient => "integer quotient",
            Self::Selection => "comparison or selection",
            Self::Conversion => "conversion",
            Self::Load => "word loaded",
            Self::Store => "word stored",
            Self::Branch => "branch or turn",
        }
    }

    /// The class of a value's operation; none if it costs nothing.
    fn of(program: &Program, value: Value) -> Option<Self> {
        let operand_is_float = |operand: Value| program.ty(operand) == Ty::F32;
        Some(match program.op(value) {
            Op::Constant(_)
            | Op::Lane
            | Op::Workgroup
            | Op::Bitcast(_)
            | Op::Read(_)
            | Op::ReadElement(..)
            | Op::Loaded => {
                return None;
            }
            Op::Unary(Unary::Negate | Unary::Abs | Unary::Floor | Unary::Trunc, a) if operand_is_float(a) => {
                Self::Float
            }
            Op::Binary(op, ..) if op.compares() => Self::Selection,
            Op::Binary(_, a, _) if operand_is_float(a) => Self::Float,
            Op::Binary(Binary::Multiply, ..) => Self::Product,
            Op::Binary(Binary::Divide | Binary::Remainder, _, by) => match program.op(by) {
                Op::Constant(bits) if bits.is_power_of_two() => Self::Integer,
                _ => Self::Quotient,
            },
            Op::Unary(..) | Op::Binary(..) => Self::Integer,
            Op::Select { .. } => Self::Selection,
            Op::Convert(_) => Self::Conversion,
        })
    }
}

/// Numbers of operations by class.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Operations(pub BTreeMap<Class, u64>);

impl Operations {
    /// All operations.
    pub fn sum(&self) -> u64 {
        self.0.values().sum()
    }

    fn add(&mut self, class: Class, count: u64) {
        if count > 0 {
            *self.0.entry(class).or_default() += count;
        }
    }
}

impl AddAssign<&Self> for Operations {
    fn add_assign(&mut self, other: &Self) {
        for (class, count) in &other.0 {
            self.add(*class, *count);
        }
    }
}

impl Sub for &Operations {
    type Output = Operations;

    /// The first minus the second, class by class, and at least 0.
    fn sub(self, other: Self) -> Operations {
        let mut more = Operations::default();
        for (class, count) in &self.0 {
            more.add(
                *class,
                count.saturating_sub(other.0.get(class).copied().unwrap_or_default()),
            );
        }
        more
    }
}

/// A loop of a program, and how often a group that runs together turns it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Turns {
    /// Number of loops around it.
    pub depth: usize,
    /// All its turns.
    pub turns: u64,
}

/// What a group of invocations does.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Counted {
    /// Operations that are issued.
    pub operations: Operations,
    /// Those of each value that costs something.
    pub values: BTreeMap<Value, u64>,
    /// Loops, in the order in which the program has them.
    pub loops: Vec<Turns>,
}

impl Counted {
    /// What was done since less of it was done by the same program.
    #[must_use]
    pub fn since(&self, before: &Self) -> Self {
        let loops = self.loops.iter().zip(&before.loops);
        let of = |value: &Value| before.values.get(value).copied().unwrap_or_default();
        let values = self.values.iter().map(|(value, count)| (*value, count - of(value)));
        Self {
            operations: &self.operations - &before.operations,
            values: values.filter(|(_, count)| *count > 0).collect(),
            loops: loops
                .map(|(all, before)| Turns {
                    turns: all.turns - before.turns,
                    ..*all
                })
                .collect(),
        }
    }
}

/// Counts what invocations `0..lanes` of a workgroup do if they run together.
///
/// # Errors
/// A program that uses a value that isn't set, which the compiler makes none of.
pub fn count(program: &Program, memory: &mut impl Buffers, workgroup: u32, lanes: u32) -> Result<Counted, Trap> {
    let mut watch = Watch::default();
    for lane in 0..lanes {
        run_watched(program, memory, workgroup, lane, &mut watch)?;
    }
    let mut times: HashMap<usize, u64> = HashMap::new();
    for statement in watch.statements() {
        *times.entry(statement).or_default() += 1;
    }
    let mut counted = Counted::default();
    add(program, &program.body, &times, 0, &mut counted);
    Ok(counted)
}

fn add(program: &Program, block: &Block, times: &HashMap<usize, u64>, depth: usize, counted: &mut Counted) {
    for statement in block {
        let times_of = |statement: &Statement| {
            times
                .get(&std::ptr::from_ref(statement).addr())
                .copied()
                .unwrap_or_default()
        };
        let count = times_of(statement);
        let operations = &mut counted.operations;
        let mut inner = depth;
        match statement {
            Statement::Let(value) => {
                if let Some(class) = Class::of(program, *value) {
                    operations.add(class, count);
                    counted.values.insert(*value, count);
                }
            }
            Statement::Load { targets, .. } => operations.add(Class::Load, count * targets.len() as u64),
            Statement::Store { .. } => operations.add(Class::Store, count),
            Statement::If { .. } => operations.add(Class::Branch, count),
            Statement::Loop { body, .. } => {
                let turns = body.first().map_or(0, times_of);
                operations.add(Class::Branch, turns);
                counted.loops.push(Turns { depth, turns });
                inner += 1;
            }
            Statement::Declare(_)
            | Statement::DeclareArray(_)
            | Statement::Write(..)
            | Statement::WriteElement { .. }
            | Statement::Labeled { .. }
            | Statement::Exit(_) => {}
        }
        for block in statement.blocks() {
            add(program, block, times, inner, counted);
        }
    }
}
