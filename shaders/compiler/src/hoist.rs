//! Computes once, before a loop, what would be the same in each of its turns: genes are loaded once a dispatch, and a key is mixed once.

use std::collections::{BTreeMap, BTreeSet};

use crate::tree::{Array, Binary, Block, Op, Program, Statement, Ty, Unary, Value, Variable, visit};

/// Most values that stay in registers throughout a loop because of this.
const KEPT: usize = 48;
/// Most statements of a loop that is changed. In a longer one the registers are worth more than the time: a surrogate's episode would need
/// 136 instead of 88 for a fiftieth of its instructions.
const LONGEST: usize = 2_500;

/// Moves what does not change in a loop before it, unless another loop is around it. Loads are moved even if some turns do without them:
/// they have no effect.
pub(crate) fn hoist(program: &mut Program) {
    let mut body = std::mem::take(&mut program.body);
    hoist_all(program, &mut body);
    program.body = body;
}

fn hoist_all(program: &Program, block: &mut Block) {
    let mut at = 0;
    while at < block.len() {
        let mut moved = Vec::new();
        match &mut block[at] {
            Statement::Loop { body, .. } => {
                let mut statements = 0;
                visit(body, &mut |_| statements += 1);
                if statements <= LONGEST {
                    let values = Hoisting::new(program, body).values(body);
                    take(body, &values, &mut moved);
                }
            }
            other => other.blocks_mut().for_each(|inner| hoist_all(program, inner)),
        }
        let count = moved.len();
        block.splice(at..at, moved);
        at += count + 1;
    }
}

/// What a loop changes.
struct Changing {
    variables: BTreeSet<Variable>,
    arrays: BTreeSet<Array>,
    buffers: BTreeSet<u32>,
}

impl Changing {
    fn of(body: &Block) -> Self {
        let mut changes = Self {
            variables: BTreeSet::new(),
            arrays: BTreeSet::new(),
            buffers: BTreeSet::new(),
        };
        visit(body, &mut |statement| match statement {
            Statement::Write(variable, _) | Statement::Declare(variable) => _ = changes.variables.insert(*variable),
            Statement::WriteElement { array, .. } | Statement::DeclareArray(array) => _ = changes.arrays.insert(*array),
            Statement::Store { address, .. } => _ = changes.buffers.insert(address.buffer),
            _ => {}
        });
        changes
    }
}

struct Hoisting<'a> {
    program: &'a Program,
    changing: Changing,
    /// Statements of the loop that set values, in order; then those of them that set the same in each turn.
    statements: Vec<&'a Statement>,
    /// Values that are set in the loop and differ between turns.
    varying: BTreeSet<Value>,
    /// Those that are worth a register.
    chosen: BTreeSet<Value>,
}

impl<'a> Hoisting<'a> {
    fn new(program: &'a Program, body: &'a Block) -> Self {
        let mut statements = Vec::new();
        collect(body, &mut statements);
        let mut scope = Self {
            program,
            changing: Changing::of(body),
            statements,
            varying: BTreeSet::new(),
            chosen: BTreeSet::new(),
        };
        visit(body, &mut |statement| scope.varying.extend(statement.results()));
        scope
    }

    fn is_same(&self, statement: &Statement) -> bool {
        let operands_are = statement
            .operands(self.program)
            .iter()
            .all(|operand| !self.varying.contains(operand));
        let reads_same = match statement {
            Statement::Let(value) => match self.program.op(*value) {
                Op::Read(variable) => !self.changing.variables.contains(&variable),
                Op::ReadElement(array, _) => !self.changing.arrays.contains(&array),
                _ => true,
            },
            Statement::Load { address, .. } => !self.changing.buffers.contains(&address.buffer),
            _ => false,
        };
        operands_are && reads_same
    }

    /// Whether a value costs more to compute again than to keep: it is loaded, multiplied, converted, or made of what is.
    fn is_dear(&self, statement: &Statement) -> bool {
        let Statement::Let(value) = statement else { return true };
        let program = self.program;
        let of_floats = |operand: Value| program.ty(operand) == Ty::F32;
        match program.op(*value) {
            Op::Constant(_) | Op::Lane | Op::Workgroup | Op::Read(_) | Op::ReadElement(..) | Op::Loaded => false,
            Op::Bitcast(from) | Op::Unary(Unary::Negate | Unary::Not | Unary::Abs, from) => self.chosen.contains(&from),
            Op::Convert(_) | Op::Unary(..) | Op::Binary(Binary::Multiply | Binary::Divide | Binary::Remainder, ..) => {
                true
            }
            Op::Binary(_, a, _) if of_floats(a) => true,
            op => op.operands().any(|operand| self.chosen.contains(&operand)),
        }
    }

    /// Chooses values as long as there are registers: in the order of the program.
    fn choose(&mut self) {
        for statement in std::mem::take(&mut self.statements) {
            if !self.is_same(statement) {
                continue;
            }
            for result in statement.results() {
                self.varying.remove(result);
            }
            if self.is_dear(statement) {
                self.chosen.extend(statement.results());
            }
            self.statements.push(statement);
        }
    }

    /// Values to move: those that are chosen and used by what stays, up to the number of registers, and all that they are made of.
    fn values(mut self, body: &Block) -> BTreeSet<Value> {
        self.choose();
        let mut used = BTreeSet::new();
        visit(body, &mut |statement| {
            if !statement.results().iter().any(|result| self.chosen.contains(result)) {
                used.extend(statement.operands(self.program));
            }
        });
        let mut kept: Vec<Value> = self.chosen.intersection(&used).copied().collect();
        kept.truncate(KEPT);
        let setters: BTreeMap<Value, &Statement> = self
            .statements
            .iter()
            .flat_map(|statement| statement.results().iter().map(|result| (*result, *statement)))
            .collect();
        let mut moved = BTreeSet::new();
        while let Some(value) = kept.pop() {
            if let Some(setter) = setters.get(&value)
                && moved.insert(value)
            {
                kept.extend(setter.operands(self.program));
            }
        }
        moved
    }
}

/// Statements that set values in a loop's turn, except for those in loops within it.
fn collect<'a>(block: &'a Block, all: &mut Vec<&'a Statement>) {
    for statement in block {
        match statement {
            Statement::Let(_) | Statement::Load { .. } => all.push(statement),
            Statement::If { .. } | Statement::Labeled { .. } => {
                statement.blocks().for_each(|inner| collect(inner, all));
            }
            _ => {}
        }
    }
}

/// Takes the statements that set these values out of a loop's turn.
fn take(block: &mut Block, values: &BTreeSet<Value>, moved: &mut Block) {
    for mut statement in std::mem::take(block) {
        let is_moved = statement.results().iter().any(|result| values.contains(result));
        if is_moved {
            moved.push(statement);
            continue;
        }
        if !matches!(statement, Statement::Loop { .. }) {
            statement.blocks_mut().for_each(|inner| take(inner, values, moved));
        }
        block.push(statement);
    }
}
