//! What is the same for all lanes. A fixpoint over data and control together: it starts with everything
//! uniform and takes back what can't be.

use std::collections::BTreeSet;

use crate::source::{Place, Refusal, Refusals};
use crate::tree::{Array, Binary, Block, Label, Op, Program, Statement, Ty, Value, Variable};

/// How a value differs between lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Shape {
    /// It does not.
    Uniform,
    /// By one from lane to lane: a uniform integer plus the lane's number.
    Linear,
    /// In any way.
    Varying,
}

/// What the analysis found.
#[derive(Clone, Debug, Default)]
pub struct Shapes {
    values: Vec<Option<Shape>>,
    variables: BTreeSet<Variable>,
    arrays: BTreeSet<Array>,
    /// Labels that some lanes leave for while others stay.
    left_by_some: BTreeSet<Label>,
    /// Loops that some lanes leave, to whatever label.
    loops: BTreeSet<Label>,
}

/// Something that encloses a statement.
#[derive(Clone, Copy, Debug)]
pub enum Region {
    /// A branch of an `if`, and whether its condition varies.
    Branch(bool),
    /// A labelled block or loop.
    Label(Label),
}

impl Shapes {
    /// How a value differs.
    pub fn shape(&self, value: Value) -> Shape {
        self.values
            .get(value.0 as usize)
            .copied()
            .flatten()
            .unwrap_or(Shape::Uniform)
    }

    /// Whether a value is the same for all lanes.
    pub fn is_uniform(&self, value: Value) -> bool {
        self.shape(value) == Shape::Uniform
    }

    /// Whether a variable's content differs.
    pub fn variable_varies(&self, variable: Variable) -> bool {
        self.variables.contains(&variable)
    }

    /// Whether an array's content differs.
    pub fn array_varies(&self, array: Array) -> bool {
        self.arrays.contains(&array)
    }

    /// Whether some lanes leave for a label while others stay.
    pub fn is_left_by_some(&self, label: Label) -> bool {
        self.left_by_some.contains(&label)
    }

    /// Whether a loop must watch that any lane is still in it.
    pub fn loop_is_left_by_some(&self, label: Label) -> bool {
        self.loops.contains(&label)
    }

    /// Whether lanes that are active outside of these regions may be idle inside.
    pub fn diverges(&self, regions: &[Region]) -> bool {
        regions.iter().any(|region| match region {
            Region::Branch(varying) => *varying,
            Region::Label(label) => self.left_by_some.contains(label),
        })
    }

    /// Whether an exit is taken by some of the lanes of its label's block only.
    pub fn exit_diverges(&self, regions: &[Region], label: Label) -> bool {
        self.diverges(&regions[depth_of(regions, label) + 1..])
    }

    /// Whether all active lanes leave a labelled block together somewhere in its body; `regions` enclose the body.
    pub fn is_left_by_all(&self, label: Label, body: &Block, regions: &mut Vec<Region>) -> bool {
        body.iter().any(|statement| {
            let region = match statement {
                Statement::Exit(own) => return *own == label && !self.exit_diverges(regions, label),
                Statement::If { condition, .. } => Region::Branch(!self.is_uniform(*condition)),
                Statement::Loop { label, .. } | Statement::Labeled { label, .. } => Region::Label(*label),
                _ => return false,
            };
            regions.push(region);
            let found = statement
                .blocks()
                .any(|inner| self.is_left_by_all(label, inner, regions));
            regions.pop();
            found
        })
    }
}

/// Where a label's block is among the enclosing regions.
///
/// # Panics
/// If it is not among them.
pub fn depth_of(regions: &[Region], label: Label) -> usize {
    regions
        .iter()
        .position(|region| matches!(region, Region::Label(own) if *own == label))
        .expect("an exit stands in its label's block")
}

/// Analyses a program.
///
/// # Errors
/// A varying value stored at a uniform address of a buffer, a varying index into a local array.
pub fn analyse(program: &Program, place: &dyn Fn(naga::Span) -> Place) -> Result<Shapes, Refusals> {
    let mut analysis = Analysis {
        program,
        shapes: Shapes {
            values: vec![None; program.values.len()],
            ..Shapes::default()
        },
        homes: vec![0; program.variables.len()],
        array_homes: vec![0; program.arrays.len()],
        changed: true,
        refusals: Vec::new(),
        place,
    };
    while std::mem::take(&mut analysis.changed) {
        analysis.refusals.clear();
        analysis.block(&program.body, &mut Vec::new());
    }
    if analysis.refusals.is_empty() {
        Ok(analysis.shapes)
    } else {
        Err(analysis.refusals)
    }
}

struct Analysis<'a> {
    program: &'a Program,
    shapes: Shapes,
    /// How many regions enclose each declaration.
    homes: Vec<usize>,
    array_homes: Vec<usize>,
    changed: bool,
    refusals: Refusals,
    place: &'a dyn Fn(naga::Span) -> Place,
}

impl Analysis<'_> {
    fn refuse(&mut self, span: naga::Span, message: &str) {
        self.refusals.push(Refusal {
            place: (self.place)(span),
            function: None,
            message: message.into(),
        });
    }

    fn set(&mut self, value: Value, shape: Shape) {
        let slot = &mut self.shapes.values[value.0 as usize];
        // Monotone: a shape never goes back.
        let new = slot.map_or(shape, |old| old.max(shape));
        if *slot != Some(new) {
            *slot = Some(new);
            self.changed = true;
        }
    }

    fn block(&mut self, block: &Block, regions: &mut Vec<Region>) {
        for statement in block {
            match statement {
                Statement::Let(value) => {
                    let shape = self.computed(*value);
                    self.set(*value, shape);
                }
                Statement::Load { targets, address } => {
                    let uniform = address.element.is_none_or(|element| self.shapes.is_uniform(element));
                    for target in targets {
                        self.set(*target, if uniform { Shape::Uniform } else { Shape::Varying });
                    }
                }
                Statement::Declare(variable) => self.homes[variable.0 as usize] = regions.len(),
                Statement::DeclareArray(array) => self.array_homes[array.0 as usize] = regions.len(),
                Statement::Write(variable, value) => {
                    let home = self.homes[variable.0 as usize];
                    if !self.shapes.is_uniform(*value) || self.shapes.diverges(&regions[home..]) {
                        self.changed |= self.shapes.variables.insert(*variable);
                    }
                }
                Statement::WriteElement {
                    array,
                    index,
                    value,
                    span,
                } => {
                    let home = self.array_homes[array.0 as usize];
                    if !self.shapes.is_uniform(*index) {
                        self.refuse(
                            *span,
                            "a local array can't be indexed by what differs between invocations",
                        );
                    }
                    if !self.shapes.is_uniform(*value) || self.shapes.diverges(&regions[home..]) {
                        self.changed |= self.shapes.arrays.insert(*array);
                    }
                }
                Statement::Store { address, value, span } => {
                    let fixed = address.element.is_none_or(|element| self.shapes.is_uniform(element));
                    if fixed && !self.shapes.is_uniform(*value) {
                        self.refuse(
                            *span,
                            "invocations store different values at one address; the last would win",
                        );
                    }
                }
                Statement::If {
                    condition,
                    accept,
                    reject,
                } => {
                    regions.push(Region::Branch(!self.shapes.is_uniform(*condition)));
                    self.block(accept, regions);
                    self.block(reject, regions);
                    regions.pop();
                }
                Statement::Loop { label, body, .. } | Statement::Labeled { label, body, .. } => {
                    regions.push(Region::Label(*label));
                    self.block(body, regions);
                    regions.pop();
                }
                Statement::Exit(label) => {
                    if self.shapes.exit_diverges(regions, *label) {
                        self.changed |= self.shapes.left_by_some.insert(*label);
                        for region in &regions[depth_of(regions, *label)..] {
                            if let Region::Label(inner) = region {
                                self.changed |= self.shapes.loops.insert(*inner);
                            }
                        }
                    }
                }
            }
        }
    }

    fn computed(&mut self, value: Value) -> Shape {
        let uniform_or_varying = |uniform: bool| if uniform { Shape::Uniform } else { Shape::Varying };
        match self.program.op(value) {
            Op::Constant(_) | Op::Workgroup => Shape::Uniform,
            Op::Lane => Shape::Linear,
            Op::Read(variable) => uniform_or_varying(!self.shapes.variables.contains(&variable)),
            Op::ReadElement(array, index) => {
                if !self.shapes.is_uniform(index) {
                    let span = self.program.values[value.0 as usize].span;
                    self.refuse(
                        span,
                        "a local array can't be indexed by what differs between invocations",
                    );
                }
                uniform_or_varying(!self.shapes.arrays.contains(&array))
            }
            Op::Binary(op @ (Binary::Add | Binary::Subtract), a, b) if self.program.ty(value) == Ty::U32 => {
                match (self.shapes.shape(a), self.shapes.shape(b)) {
                    (Shape::Uniform, Shape::Uniform) => Shape::Uniform,
                    (Shape::Linear, Shape::Uniform) => Shape::Linear,
                    (Shape::Uniform, Shape::Linear) if op == Binary::Add => Shape::Linear,
                    _ => Shape::Varying,
                }
            }
            op => uniform_or_varying(op.operands().all(|operand| self.shapes.is_uniform(operand))),
        }
    }
}
