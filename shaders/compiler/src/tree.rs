//! The compiler's intermediate representation of a program: one structured body over scalars. Functions are inlined, vectors
//! and structs are split, and every jump is an exit from a labelled block, so that later passes need no special cases for
//! `break`, `continue` and `return`.

use std::collections::BTreeMap;

/// A scalar type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Ty {
    /// 32-bit float.
    F32,
    /// 32-bit signed integer.
    I32,
    /// 32-bit unsigned integer.
    U32,
    /// Truth value.
    Bool,
}

/// Index into [`Program::values`]. A value is computed once, by its statement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Value(pub u32);
/// Index into [`Program::variables`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Variable(pub u32);
/// Index into [`Program::arrays`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Array(pub u32);
/// Name of a block that can be left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Label(pub u32);

/// An operation on one operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Unary {
    /// `-x`; wraps for integers.
    Negate,
    /// `!x` of a truth value, `~x` of an integer.
    Not,
    /// Absolute value; wraps for integers.
    Abs,
    /// Rounds down.
    Floor,
    /// Rounds towards zero.
    Trunc,
}

/// An operation on two operands of one type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "they are WGSL's operators")]
pub enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
    Remainder,
    Min,
    Max,
    And,
    Or,
    Xor,
    ShiftLeft,
    ShiftRight,
    Equal,
    NotEqual,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
}

impl Binary {
    /// Returns whether the result is a truth value for all types of operands.
    pub fn compares(self) -> bool {
        matches!(
            self,
            Self::Equal | Self::NotEqual | Self::Less | Self::LessEqual | Self::Greater | Self::GreaterEqual
        )
    }
}

/// Operation that computes a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Op {
    /// Bits of a constant; 0 or 1 for a truth value.
    Constant(u32),
    /// `local_invocation_index`
    Lane,
    /// `workgroup_id.x`
    Workgroup,
    /// An operation on one operand.
    Unary(Unary, Value),
    /// An operation on two operands.
    Binary(Binary, Value, Value),
    /// `condition ? accept : reject`
    Select {
        /// Truth value.
        condition: Value,
        /// Taken if it is true.
        accept: Value,
        /// Taken if it is false.
        reject: Value,
    },
    /// Converts between types.
    Convert(Value),
    /// Reinterprets the bits as another type.
    Bitcast(Value),
    /// Reads a variable.
    Read(Variable),
    /// Reads an element of an array.
    ReadElement(Array, Value),
    /// Set by a [`Statement::Load`].
    Loaded,
}

/// A value.
#[derive(Clone, Debug)]
pub struct Node {
    /// How it is computed.
    pub op: Op,
    /// Type.
    pub ty: Ty,
    /// Name in the WGSL, if it has one.
    pub name: Option<String>,
    /// Place in the WGSL.
    pub span: naga::Span,
    /// The call that it is computed in, an index into [`Program::calls`]; `None` in the entry point.
    pub call: Option<u32>,
}

/// A call of a function, which was inlined.
#[derive(Clone, Copy, Debug)]
pub struct CallInfo {
    /// Place in the WGSL.
    pub span: naga::Span,
    /// The call around it.
    pub within: Option<u32>,
}

/// A scalar local variable.
#[derive(Clone, Debug)]
pub struct VariableInfo {
    /// Type.
    pub ty: Ty,
    /// Initial bits, at each call of its function.
    pub init: u32,
    /// Name in the WGSL.
    pub name: String,
}

/// A local array of scalars.
#[derive(Clone, Debug)]
pub struct ArrayInfo {
    /// Type of its elements.
    pub ty: Ty,
    /// Initial bits of the elements.
    pub init: Vec<u32>,
    /// Name in the WGSL.
    pub name: String,
    /// Place in the WGSL.
    pub span: naga::Span,
}

/// Place of a word in a buffer: `element * stride + offset`, with the element clamped to those of the buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Address {
    /// Binding number.
    pub buffer: u32,
    /// Element of the buffer's array. `None` if the buffer isn't an array.
    pub element: Option<Value>,
    /// Words per element.
    pub stride: u32,
    /// Index of the word in the element.
    pub offset: u32,
}

/// A statement.
#[derive(Clone, Debug)]
pub enum Statement {
    /// Computes a value.
    Let(Value),
    /// Loads consecutive words.
    Load {
        /// Values that they become.
        targets: Vec<Value>,
        /// Address of the first word.
        address: Address,
    },
    /// Creates a variable with its initial value.
    Declare(Variable),
    /// Creates an array with its initial values.
    DeclareArray(Array),
    /// Writes a variable.
    Write(Variable, Value),
    /// Writes an element of an array.
    WriteElement {
        /// Array.
        array: Array,
        /// Index of the element; beyond the last, the last one.
        index: Value,
        /// Value to write.
        value: Value,
        /// Place in the WGSL.
        span: naga::Span,
    },
    /// Stores a word.
    Store {
        /// Address of the word.
        address: Address,
        /// Value to write.
        value: Value,
        /// Place in the WGSL.
        span: naga::Span,
    },
    /// Runs one of two blocks.
    If {
        /// Truth value.
        condition: Value,
        /// Taken if it is true.
        accept: Block,
        /// Taken if it is false.
        reject: Block,
    },
    /// Repeats a block until it is left.
    Loop {
        /// Label that exits name.
        label: Label,
        /// Statements in it.
        body: Block,
        /// Place in the WGSL.
        span: naga::Span,
    },
    /// Runs a block that can be left early.
    Labeled {
        /// Label that exits name.
        label: Label,
        /// Statements in it.
        body: Block,
        /// Name of the inlined function, if it is one.
        function: Option<String>,
    },
    /// Leaves the block or loop with this label.
    Exit(Label),
}

/// Statements in order.
pub type Block = Vec<Statement>;

/// A kernel's entry point.
#[derive(Clone, Debug, Default)]
pub struct Program {
    /// Values of all statements.
    pub values: Vec<Node>,
    /// Local variables.
    pub variables: Vec<VariableInfo>,
    /// Local arrays.
    pub arrays: Vec<ArrayInfo>,
    /// Number of labels.
    pub labels: u32,
    /// Statements.
    pub body: Block,
    /// Number of bindings.
    pub buffers: u32,
    /// Calls of functions.
    pub calls: Vec<CallInfo>,
}

impl Program {
    /// Returns the type of a value.
    pub fn ty(&self, value: Value) -> Ty {
        self.values[value.0 as usize].ty
    }

    /// Operation that computes a value.
    pub fn op(&self, value: Value) -> Op {
        self.values[value.0 as usize].op
    }

    /// How often each value is used, if it is.
    pub fn uses(&self) -> BTreeMap<Value, u32> {
        let mut uses = BTreeMap::new();
        visit(&self.body, &mut |statement| {
            for operand in statement.operands(self) {
                *uses.entry(operand).or_insert(0) += 1;
            }
        });
        uses
    }

    /// Name of a value in printed code.
    pub fn name(&self, value: Value) -> String {
        match &self.values[value.0 as usize].name {
            Some(name) => format!("{}_{}", name.to_lowercase(), value.0),
            None => format!("v{}", value.0),
        }
    }

    /// Name of a variable in printed code.
    pub fn variable_name(&self, variable: Variable) -> String {
        let name = &self.variables[variable.0 as usize].name;
        format!("{}_m{}", name.to_lowercase(), variable.0)
    }

    /// Adds a value, which is not yet in any block.
    pub fn add(&mut self, op: Op, ty: Ty) -> Value {
        self.values.push(Node {
            op,
            ty,
            name: None,
            span: naga::Span::UNDEFINED,
            call: None,
        });
        Value(self.values.len() as u32 - 1)
    }
}

impl Op {
    /// Values that it is computed from.
    pub fn operands(self) -> impl Iterator<Item = Value> {
        let operands = match self {
            Self::Constant(_) | Self::Lane | Self::Workgroup | Self::Read(_) | Self::Loaded => [None; 3],
            Self::Unary(_, a) | Self::Convert(a) | Self::Bitcast(a) | Self::ReadElement(_, a) => [Some(a), None, None],
            Self::Binary(_, a, b) => [Some(a), Some(b), None],
            Self::Select {
                condition,
                accept,
                reject,
            } => [Some(condition), Some(accept), Some(reject)],
        };
        operands.into_iter().flatten()
    }
}

impl Statement {
    /// Values that it uses, without those that only its blocks use.
    pub fn operands(&self, program: &Program) -> Vec<Value> {
        match self {
            Self::Let(value) => program.op(*value).operands().collect(),
            Self::Load { address, .. } => address.element.into_iter().collect(),
            Self::Write(_, value) => vec![*value],
            Self::WriteElement { index, value, .. } => vec![*index, *value],
            Self::Store { address, value, .. } => address.element.into_iter().chain([*value]).collect(),
            Self::If { condition, .. } => vec![*condition],
            Self::Loop { .. } | Self::Labeled { .. } | Self::Exit(_) | Self::Declare(_) | Self::DeclareArray(_) => {
                Vec::new()
            }
        }
    }

    /// Values that it sets, without those of its blocks.
    pub fn results(&self) -> &[Value] {
        match self {
            Self::Let(value) => std::slice::from_ref(value),
            Self::Load { targets, .. } => targets,
            _ => &[],
        }
    }

    /// Blocks in it.
    pub fn blocks(&self) -> impl Iterator<Item = &Block> {
        let blocks = match self {
            Self::If { accept, reject, .. } => [Some(accept), Some(reject)],
            Self::Loop { body, .. } | Self::Labeled { body, .. } => [Some(body), None],
            _ => [None, None],
        };
        blocks.into_iter().flatten()
    }

    /// Blocks in it, to be changed.
    pub fn blocks_mut(&mut self) -> impl Iterator<Item = &mut Block> {
        let blocks = match self {
            Self::If { accept, reject, .. } => [Some(accept), Some(reject)],
            Self::Loop { body, .. } | Self::Labeled { body, .. } => [Some(body), None],
            _ => [None, None],
        };
        blocks.into_iter().flatten()
    }
}

/// Visits all statements in order, each before those of its blocks.
pub fn visit(block: &[Statement], see: &mut impl FnMut(&Statement)) {
    for statement in block {
        see(statement);
        for inner in statement.blocks() {
            visit(inner, see);
        }
    }
}
