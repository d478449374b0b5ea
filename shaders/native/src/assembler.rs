//! The instruction set that the emitter writes to: scalars, vectors and masks of their lanes; [`Structured`] adds control flow.

use oneiro_shader_compiler::tree::{Binary, Ty, Unary};

use crate::control::Structured;

/// The form of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    /// A scalar.
    One(Ty),
    /// A vector; of truth values, a mask.
    Vector(Ty),
}

/// Writes one function. Its parameters are the buffers, the workgroup, the first lane, and the budget of loop turns.
/// Integer arithmetic wraps; floats are rounded after each operation. Memory accesses aren't checked: the emitter clamps indices.
pub(crate) trait Assembler: Structured {
    /// Lanes of a vector.
    const LANES: u32;
    /// Whether vectors are stored under a mask in one instruction.
    const STORES_MASKED: bool;
    /// A local variable of one form.
    type Variable: Copy;
    /// Pointers to a word for each lane of a vector.
    type Pointers: Clone;
    /// Memory that belongs to one call.
    type Array: Copy;

    fn workgroup(&mut self) -> Self::Value;
    fn first_lane(&mut self) -> Self::Value;
    /// Number of elements in a buffer, given the words per element.
    fn elements(&mut self, buffer: u32, stride: u32) -> Self::Value;

    /// A constant; a vector holds it in every lane.
    fn constant(&mut self, form: Form, bits: u32) -> Self::Value;
    /// The words `first`, `first + 1`, ..
    fn ramp(&mut self, first: u32) -> Self::Value;
    /// A vector with the same scalar in every lane.
    fn splat(&mut self, ty: Ty, scalar: Self::Value) -> Self::Value;
    fn unary(&mut self, op: Unary, form: Form, a: Self::Value) -> Self::Value;
    /// `form` is the form of the operands, and of the result unless the operation is a comparison. A vector is shifted by a
    /// scalar. Shift counts are taken modulo 32. Only unsigned integers are divided, and never by zero. The minimum of two
    /// floats is `a < b ? a : b`, the maximum `a > b ? a : b`.
    fn binary(&mut self, op: Binary, form: Form, a: Self::Value, b: Self::Value) -> Self::Value;
    /// Shifts each lane of a vector by its own count.
    fn shift_each(&mut self, op: Binary, ty: Ty, a: Self::Value, counts: Self::Value) -> Self::Value;
    /// `condition ? accept : reject`, with a scalar condition.
    fn select(&mut self, condition: Self::Value, accept: Self::Value, reject: Self::Value) -> Self::Value;
    /// The same for vectors, lane by lane.
    fn blend(&mut self, ty: Ty, mask: Self::Value, accept: Self::Value, reject: Self::Value) -> Self::Value;
    /// The words where the mask is set, else 0.
    fn masked(&mut self, mask: Self::Value, words: Self::Value) -> Self::Value;
    /// The mask of words that [`Self::masked`] made of all ones.
    fn mask_of(&mut self, words: Self::Value) -> Self::Value;
    /// Converts between numbers, or a scalar truth value to a word. Integers are rounded to the nearest float, and to even
    /// ones between two. Floats are rounded towards zero, after `min(max(a, low), high)`, where the bounds are the minimum and
    /// maximum floats that are integers of the type; this is WGSL's rule.
    fn convert(&mut self, from: Form, to: Ty, a: Self::Value) -> Self::Value;
    /// Reinterprets the bits as another type.
    fn bitcast(&mut self, from: Form, to: Ty, a: Self::Value) -> Self::Value;
    /// Returns whether any lane of a mask is set, as a scalar.
    fn any(&mut self, mask: Self::Value) -> Self::Value;

    /// Pointer to a word in a buffer.
    fn buffer_pointer(&mut self, buffer: u32, index: Self::Value) -> Self::Value;
    /// Pointers for each lane's index. Lanes outside the mask are not stored to.
    fn buffer_pointers(&mut self, buffer: u32, indices: Self::Value, mask: Option<Self::Value>) -> Self::Pointers;
    /// Reserves this many words of memory.
    fn array(&mut self, words: u32) -> Self::Array;
    /// Pointer to a word in an array.
    fn array_pointer(&mut self, array: Self::Array, index: Self::Value) -> Self::Value;
    /// Loads one number, or as many consecutive ones as a vector has lanes, from `offset` words after a pointer.
    fn load(&mut self, form: Form, pointer: Self::Value, offset: u32) -> Self::Value;
    fn store(&mut self, form: Form, pointer: Self::Value, offset: u32, value: Self::Value);
    /// Stores those words of a vector whose lanes are set, if [`Self::STORES_MASKED`].
    fn store_masked(&mut self, pointer: Self::Value, offset: u32, words: Self::Value, mask: Self::Value);
    /// Loads the word at `offset` after each pointer.
    fn gather(&mut self, pointers: &Self::Pointers, offset: u32) -> Self::Value;
    /// Loads the four words from `offset` after each pointer, as four vectors: the first words of all lanes, and so on.
    fn gather_four(&mut self, pointers: &Self::Pointers, offset: u32) -> [Self::Value; 4];
    /// Stores a word at `offset` after each pointer, in the order of the lanes.
    fn scatter(&mut self, pointers: &Self::Pointers, offset: u32, words: Self::Value);

    fn variable(&mut self, form: Form) -> Self::Variable;
    /// Declares a variable that holds a pointer.
    fn pointer_variable(&mut self) -> Self::Variable;
    /// Reads a variable, which must have been set on every path to this point.
    fn get(&mut self, variable: Self::Variable) -> Self::Value;
    fn set(&mut self, variable: Self::Variable, value: Self::Value);

    /// Takes one turn off the budget. If none is left, the function returns and reports that.
    fn count_turn(&mut self);
    /// Returns from the function.
    fn finish(&mut self);
}
