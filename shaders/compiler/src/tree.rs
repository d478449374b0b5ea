//! The compiler's own program: one structured body over scalars. Functions are inlined, vectors and structs
//! are taken apart, and every jump is an exit from a labelled block, so that what follows needs no special
//! case for `break`, `continue` or `return`.

/// A scalar type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ty {
    /// 32-bit float
    F32,
    /// 32-bit signed integer
    I32,
    /// 32-bit unsigned integer
    U32,
    /// truth value
    Bool,
}

/// An index into [`Program::values`]: a value that is computed once where its statement stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Value(pub u32);
/// An index into [`Program::variables`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Variable(pub u32);
/// An index into [`Program::arrays`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Array(pub u32);
/// A block that can be left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Label(pub u32);

/// One operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unary {
    /// `-x`, wrapping on integers
    Negate,
    /// `!x` on bool, `~x` on integers
    Not,
    /// absolute value, wrapping on integers
    Abs,
    /// towards minus infinity
    Floor,
    /// towards zero
    Trunc,
}

/// Two operands of one type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
    /// Whether the result is a bool whatever the operands are.
    pub fn compares(self) -> bool {
        matches!(
            self,
            Self::Equal | Self::NotEqual | Self::Less | Self::LessEqual | Self::Greater | Self::GreaterEqual
        )
    }
}

/// How a value is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Op {
    /// The bits of a constant; 0 or 1 for a bool.
    Constant(u32),
    /// `local_invocation_index`
    Lane,
    /// `workgroup_id.x`
    Workgroup,
    /// One operand.
    Unary(Unary, Value),
    /// Two operands.
    Binary(Binary, Value, Value),
    /// `condition ? accept : reject`
    Select {
        /// A bool.
        condition: Value,
        /// If it is true.
        accept: Value,
        /// If not.
        reject: Value,
    },
    /// A conversion of the number.
    Convert(Value),
    /// The same bits as another type.
    Bitcast(Value),
    /// A variable's content.
    Read(Variable),
    /// An array element's content.
    ReadElement(Array, Value),
    /// Set by a [`Statement::Load`].
    Loaded,
}

/// A value.
#[derive(Clone, Debug)]
pub struct Node {
    /// How it is computed.
    pub op: Op,
    /// Its type.
    pub ty: Ty,
    /// What the WGSL calls it, if it does.
    pub name: Option<String>,
    /// Where in the WGSL, for what may be refused.
    pub span: naga::Span,
}

/// A scalar local variable.
#[derive(Clone, Debug)]
pub struct VariableInfo {
    /// Its type.
    pub ty: Ty,
    /// The bits it starts with, each time its function is entered.
    pub init: u32,
    /// What the WGSL calls it.
    pub name: String,
}

/// A local array of scalars.
#[derive(Clone, Debug)]
pub struct ArrayInfo {
    /// Its elements' type.
    pub ty: Ty,
    /// The bits they start with.
    pub init: Vec<u32>,
    /// What the WGSL calls it.
    pub name: String,
}

/// Where in a buffer a word lies: word `element * stride + offset`, the element clamped into the buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Address {
    /// Binding number.
    pub buffer: u32,
    /// The element of the buffer's array; none if the buffer is no array.
    pub element: Option<Value>,
    /// Words an element.
    pub stride: u32,
    /// Word within the element.
    pub offset: u32,
}

/// A statement.
#[derive(Clone, Debug)]
pub enum Statement {
    /// Computes a value.
    Let(Value),
    /// Loads consecutive words.
    Load {
        /// What they become.
        targets: Vec<Value>,
        /// The first word.
        address: Address,
    },
    /// Where a variable begins to exist, with its initial value, each time this is passed.
    Declare(Variable),
    /// The same for an array.
    DeclareArray(Array),
    /// Writes a variable.
    Write(Variable, Value),
    /// Writes an array element.
    WriteElement {
        /// The array.
        array: Array,
        /// Which.
        index: Value,
        /// What.
        value: Value,
        /// Where in the WGSL.
        span: naga::Span,
    },
    /// Stores a word.
    Store {
        /// Where.
        address: Address,
        /// What.
        value: Value,
        /// Where in the WGSL.
        span: naga::Span,
    },
    /// One of two blocks.
    If {
        /// A bool.
        condition: Value,
        /// If it is true.
        accept: Block,
        /// If not.
        reject: Block,
    },
    /// A block again and again, until it is left.
    Loop {
        /// Its own label.
        label: Label,
        /// Its statements.
        body: Block,
        /// Where in the WGSL.
        span: naga::Span,
    },
    /// A block that can be left early.
    Labeled {
        /// Its label.
        label: Label,
        /// Its statements.
        body: Block,
        /// What the inlined function is called, if it is one.
        function: Option<String>,
    },
    /// Leaves the block of that label.
    Exit(Label),
}

/// Statements in order.
pub type Block = Vec<Statement>;

/// A kernel's entry point.
#[derive(Clone, Debug, Default)]
pub struct Program {
    /// Every value.
    pub values: Vec<Node>,
    /// Every variable.
    pub variables: Vec<VariableInfo>,
    /// Every local array.
    pub arrays: Vec<ArrayInfo>,
    /// Labels given out.
    pub labels: u32,
    /// The whole body.
    pub body: Block,
    /// Number of bindings.
    pub buffers: u32,
}

impl Program {
    /// A value's type.
    pub fn ty(&self, value: Value) -> Ty {
        self.values[value.0 as usize].ty
    }

    /// How a value is computed.
    pub fn op(&self, value: Value) -> Op {
        self.values[value.0 as usize].op
    }

    /// A new value, not yet in any block.
    pub fn add(&mut self, op: Op, ty: Ty) -> Value {
        self.values.push(Node {
            op,
            ty,
            name: None,
            span: naga::Span::UNDEFINED,
        });
        Value(self.values.len() as u32 - 1)
    }
}

impl Op {
    /// The values it is computed from.
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
    /// The values that it uses itself, those of its blocks left out.
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

    /// The values that it sets itself.
    pub fn results(&self) -> &[Value] {
        match self {
            Self::Let(value) => std::slice::from_ref(value),
            Self::Load { targets, .. } => targets,
            _ => &[],
        }
    }

    /// Its blocks.
    pub fn blocks(&self) -> impl Iterator<Item = &Block> {
        let blocks = match self {
            Self::If { accept, reject, .. } => [Some(accept), Some(reject)],
            Self::Loop { body, .. } | Self::Labeled { body, .. } => [Some(body), None],
            _ => [None, None],
        };
        blocks.into_iter().flatten()
    }

    /// Its blocks, to be changed.
    pub fn blocks_mut(&mut self) -> impl Iterator<Item = &mut Block> {
        let blocks = match self {
            Self::If { accept, reject, .. } => [Some(accept), Some(reject)],
            Self::Loop { body, .. } | Self::Labeled { body, .. } => [Some(body), None],
            _ => [None, None],
        };
        blocks.into_iter().flatten()
    }
}

/// Visits every statement, outer before inner, in order.
pub fn visit(block: &[Statement], see: &mut impl FnMut(&Statement)) {
    for statement in block {
        see(statement);
        for inner in statement.blocks() {
            visit(inner, see);
        }
    }
}
