//! Bytes of instructions: Intel's "Software Developer's Manual", volume 2, chapters 2.1 (legacy), 2.3 (VEX) and 2.7 (EVEX).

use std::collections::HashMap;

use super::operations::{Arithmetic, Logic, Shift};

/// The number of a general, vector or mask register.
pub(super) type Register = u8;
pub(super) const RAX: Register = 0;
pub(super) const RCX: Register = 1;
pub(super) const RDX: Register = 2;
pub(super) const RBX: Register = 3;
pub(super) const RSP: Register = 4;
pub(super) const RBP: Register = 5;
pub(super) const RSI: Register = 6;
pub(super) const RDI: Register = 7;

/// The state of the flags after a comparison, by its number in x86's instructions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub(super) enum Condition {
    Below = 2,
    AboveEqual = 3,
    Equal = 4,
    NotEqual = 5,
    BelowEqual = 6,
    Above = 7,
    Negative = 8,
    Less = 12,
    GreaterEqual = 13,
    LessEqual = 14,
    Greater = 15,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub(super) enum Prefix {
    None,
    P66,
    PF3,
    PF2,
}

/// Kinds of vectors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Vectors {
    /// 16 registers of 256 bits. Instructions have a VEX prefix. Masks are vectors, whose lanes have all bits or none.
    #[default]
    Avx2,
    /// 32 registers of 512 bits. Instructions have an EVEX prefix, which has room for a mask.
    Avx512,
}

impl Vectors {
    pub(super) fn lanes(self) -> u32 {
        match self {
            Self::Avx2 => 8,
            Self::Avx512 => 16,
        }
    }
}

/// How much of a vector an instruction uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Width {
    /// All of it; with an EVEX prefix, one word in memory can stand for all.
    Full,
    /// All of it in registers, one word in memory.
    Word,
    /// One word.
    Scalar,
    /// All of it, and half of the last operand.
    Half,
    /// All of it, and 128 bits of the last operand.
    Row,
    /// 128 bits.
    OnlyRow,
    /// All of it, and as many indices of words in memory.
    Indices,
}

/// An instruction on vectors, without its operands. Those that both kinds of vectors have differ in the prefix alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Instruction {
    map: u8,
    prefix: Prefix,
    is_wide: bool,
    width: Width,
    opcode: u8,
    /// A byte that follows the operands.
    last: Option<u8>,
}

impl Instruction {
    pub(super) const fn new(map: u8, prefix: Prefix) -> Self {
        Self {
            map,
            prefix,
            is_wide: false,
            width: Width::Full,
            opcode: 0,
            last: None,
        }
    }
    pub(super) const fn code(self, opcode: u8) -> Self {
        Self { opcode, ..self }
    }
    pub(super) const fn scalar(self) -> Self {
        let width = Width::Scalar;
        Self { width, ..self }
    }
    pub(super) const fn narrow(self) -> Self {
        let width = Width::Word;
        Self { width, ..self }
    }
    pub(super) const fn half(self) -> Self {
        let width = Width::Half;
        Self { width, ..self }
    }
    pub(super) const fn row(self) -> Self {
        let width = Width::Row;
        Self { width, ..self }
    }
    pub(super) const fn only_row(self) -> Self {
        let width = Width::OnlyRow;
        Self { width, ..self }
    }
    pub(super) const fn indices(self) -> Self {
        let width = Width::Indices;
        Self { width, ..self }
    }
    pub(super) const fn wide(self) -> Self {
        let is_wide = true;
        Self { is_wide, ..self }
    }
    /// Whether all of a vector's lanes are words, each of which a mask can leave out.
    pub(super) fn is_of_words(self) -> bool {
        self.width == Width::Full && !self.is_wide
    }
    /// Whether constants of one word can be an operand.
    pub(super) fn takes_constants(self) -> bool {
        matches!(self.width, Width::Full | Width::Scalar) && !self.is_wide
    }
    /// The comparison that holds where this one doesn't, for those whose number stands in their last byte.
    pub(super) fn inverted(self) -> Option<Self> {
        self.last.map(|test| self.with(test ^ 4))
    }
    pub(super) const fn with(self, last: u8) -> Self {
        let last = Some(last);
        Self { last, ..self }
    }
}

/// An instruction with a VEX prefix, without its operands.
#[derive(Clone, Copy, Debug)]
struct Vex {
    map: u8,
    prefix: Prefix,
    is_wide: bool,
    is_long: bool,
    opcode: u8,
}

impl Vex {
    /// `is_long` here means three operands.
    fn of_masks(is_long: bool, opcode: u8) -> Self {
        Self {
            map: 1,
            prefix: Prefix::None,
            is_wide: false,
            is_long,
            opcode,
        }
    }
}

/// Constants behind the code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Constant {
    /// For a vector that can't be made of one word, as many as it has lanes.
    Word(u32),
    /// The same 64 bits for each two lanes.
    Double(u64),
    /// Consecutive numbers.
    Ramp(u32),
}

/// A place in memory.
#[derive(Clone, Copy, Debug)]
pub(super) enum Memory {
    /// After a pointer.
    At(Register, i32),
    /// After a pointer and words, whose number a general or vector register has.
    Indexed(Register, Register, i32),
    /// A constant.
    Constant(Constant),
}

/// The operand that may be in memory.
#[derive(Clone, Copy, Debug)]
pub(super) enum Place {
    In(Register),
    At(Memory),
}

/// The mask under which an instruction runs.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Under {
    pub(super) mask: Register,
    /// Other lanes become zero.
    pub(super) zeroes: bool,
}

impl Under {
    pub(super) fn lanes_of(mask: Register) -> Self {
        Self { mask, zeroes: false }
    }
}

impl Memory {
    /// What stands so many bytes after it.
    pub(super) fn after(self, bytes: i32) -> Self {
        match self {
            Self::At(base, distance) => Self::At(base, distance + bytes),
            Self::Indexed(base, index, distance) => Self::Indexed(base, index, distance + bytes),
            Self::Constant(_) => unreachable!("nothing is read after a constant"),
        }
    }

    /// The word after it whose number a general register has.
    pub(super) fn word(self, number: Register) -> Self {
        match self {
            Self::At(base, distance) => Self::Indexed(base, number, distance),
            other => unreachable!("{other:?} has no words after it"),
        }
    }
}

/// A place in the code that jumps go to.
pub(super) type Label = usize;

/// The bytes of one function.
#[derive(Debug, Default)]
pub(super) struct Bytes {
    vectors: Vectors,
    code: Vec<u8>,
    labels: Vec<Option<usize>>,
    /// Distances to labels that are yet to be written.
    jumps: Vec<(usize, Label)>,
    /// Distances to constants: their place, the end of their instruction, and the constant.
    references: Vec<(usize, usize, Constant)>,
}

const LOW: u8 = 7;

fn bit(register: Register, number: u32) -> u8 {
    register >> number & 1
}

impl Bytes {
    pub(super) fn new(vectors: Vectors, labels: usize) -> Self {
        Self {
            vectors,
            labels: vec![None; labels],
            ..Self::default()
        }
    }

    fn byte(&mut self, byte: u8) {
        self.code.push(byte);
    }

    fn number(&mut self, number: u32) {
        self.code.extend(number.to_le_bytes());
    }

    // General instructions.

    /// An instruction of one or two opcodes on general registers. `is_long`: of 64 bits.
    fn general(&mut self, is_long: bool, opcodes: &[u8], register: Register, place: Place) {
        self.with_prefix(is_long, false, opcodes, register, place);
    }

    fn with_prefix(&mut self, is_long: bool, is_byte: bool, opcodes: &[u8], register: Register, place: Place) {
        let (base, index) = match place {
            Place::In(other) | Place::At(Memory::At(other, _)) => (other, 0),
            Place::At(Memory::Indexed(base, index, _)) => (base, index),
            Place::At(Memory::Constant(_)) => (0, 0),
        };
        let rex = u8::from(is_long) << 3 | bit(register, 3) << 2 | bit(index, 3) << 1 | bit(base, 3);
        // Without it, some numbers mean parts of other registers where a byte is meant.
        if rex != 0 || is_byte {
            self.byte(0x40 | rex);
        }
        self.code.extend(opcodes);
        self.operand(register, place, 1, 0);
    }

    pub(super) fn set_number(&mut self, to: Register, number: u32) {
        if bit(to, 3) == 1 {
            self.byte(0x41);
        }
        self.byte(0xb8 | to & LOW);
        self.number(number);
    }

    pub(super) fn copy(&mut self, is_long: bool, to: Register, from: Place) {
        self.general(is_long, &[0x8b], to, from);
    }

    pub(super) fn save(&mut self, is_long: bool, to: Memory, from: Register) {
        self.general(is_long, &[0x89], from, Place::At(to));
    }

    pub(super) fn arithmetic(&mut self, is_long: bool, op: Arithmetic, to: Register, with: Place) {
        self.general(is_long, &[op.number() << 3 | 3], to, with);
    }

    pub(super) fn arithmetic_with_number(&mut self, is_long: bool, op: Arithmetic, to: Register, number: u32) {
        self.with_number(is_long, op.number(), to, number);
    }

    fn with_number(&mut self, is_long: bool, number_of_op: u8, to: Register, number: u32) {
        if let Ok(short) = i8::try_from(number as i32) {
            self.general(is_long, &[0x83], number_of_op, Place::In(to));
            self.byte(short as u8);
        } else {
            self.general(is_long, &[0x81], number_of_op, Place::In(to));
            self.number(number);
        }
    }

    /// Takes one off 64 bits in memory. The flag of a borrow is set if there was none.
    pub(super) fn take_one_off(&mut self, place: Memory) {
        self.general(true, &[0x83], Arithmetic::Subtract.number(), Place::At(place));
        self.byte(1);
    }

    pub(super) fn compare(&mut self, a: Register, b: Place) {
        self.general(false, &[0x3b], a, b);
    }

    pub(super) fn compare_with_number(&mut self, a: Register, number: u32) {
        self.with_number(false, 7, a, number);
    }

    /// Compares with zero.
    pub(super) fn test(&mut self, a: Register) {
        self.general(false, &[0x85], a, Place::In(a));
    }

    pub(super) fn multiply(&mut self, to: Register, with: Register) {
        self.general(false, &[0x0f, 0xaf], to, Place::In(with));
    }

    pub(super) fn multiply_by(&mut self, to: Register, from: Register, number: u32) {
        self.general(false, &[0x69], to, Place::In(from));
        self.number(number);
    }

    pub(super) fn negate(&mut self, to: Register) {
        self.general(false, &[0xf7], 3, Place::In(to));
    }

    pub(super) fn invert(&mut self, to: Register) {
        self.general(false, &[0xf7], 2, Place::In(to));
    }

    /// Divides `RDX` and `RAX`, without signs.
    pub(super) fn divide(&mut self, by: Register) {
        self.general(false, &[0xf7], 6, Place::In(by));
    }

    pub(super) fn shift_by(&mut self, op: Shift, to: Register, number: u8) {
        let op = match op {
            Shift::Left => 4,
            Shift::Right => 5,
            Shift::SignedRight => 7,
        };
        self.general(false, &[0xc1], op, Place::In(to));
        self.byte(number & 31);
    }

    /// Shifts by a count modulo 32.
    pub(super) fn shift(&mut self, op: Shift, to: Register, from: Register, count: Register) {
        let prefix = match op {
            Shift::Left => Prefix::P66,
            Shift::Right => Prefix::PF2,
            Shift::SignedRight => Prefix::PF3,
        };
        let op = Vex {
            map: 2,
            prefix,
            is_wide: false,
            is_long: false,
            opcode: 0xf7,
        };
        self.vex(op, to, count, Place::In(from), None);
    }

    /// The number of the first bit that is set.
    pub(super) fn first_bit(&mut self, to: Register, of: Register) {
        self.byte(0xf3);
        self.general(false, &[0x0f, 0xbc], to, Place::In(of));
    }

    /// Clears the first bit that is set, and sets the flag of zero if there is no other.
    pub(super) fn drop_first_bit(&mut self, of: Register) {
        let op = Vex {
            map: 2,
            prefix: Prefix::None,
            is_wide: false,
            is_long: false,
            opcode: 0xf3,
        };
        self.vex(op, 1, of, Place::In(of), None);
    }

    /// Replaces a register by another if the condition holds.
    pub(super) fn copy_if(&mut self, condition: Condition, to: Register, from: Register) {
        self.general(false, &[0x0f, 0x40 | condition as u8], to, Place::In(from));
    }

    /// Sets a register to 0 or 1.
    pub(super) fn set_if(&mut self, condition: Condition, to: Register) {
        self.with_prefix(false, true, &[0x0f, 0x90 | condition as u8], 0, Place::In(to));
        self.with_prefix(false, true, &[0x0f, 0xb6], to, Place::In(to));
    }

    pub(super) fn address(&mut self, to: Register, of: Memory) {
        self.general(true, &[0x8d], to, Place::At(of));
    }

    pub(super) fn push(&mut self, register: Register) {
        if bit(register, 3) == 1 {
            self.byte(0x41);
        }
        self.byte(0x50 | register & LOW);
    }

    pub(super) fn pop(&mut self, register: Register) {
        if bit(register, 3) == 1 {
            self.byte(0x41);
        }
        self.byte(0x58 | register & LOW);
    }

    /// Touches memory, so that the stack can't grow past the page that guards its end.
    pub(super) fn touch(&mut self, place: Memory) {
        self.general(false, &[0x85], RAX, Place::At(place));
    }

    pub(super) fn return_(&mut self) {
        // The upper parts of vectors are zeroed, since other code would else be slow.
        self.code.extend([0xc5, 0xf8, 0x77, 0xc3]);
    }

    // Control flow.

    pub(super) fn new_label(&mut self) -> Label {
        self.labels.push(None);
        self.labels.len() - 1
    }

    pub(super) fn label(&mut self, label: Label) {
        self.labels[label] = Some(self.code.len());
    }

    fn distance(&mut self, label: Label) {
        self.jumps.push((self.code.len(), label));
        self.number(0);
    }

    pub(super) fn jump(&mut self, to: Label) {
        self.byte(0xe9);
        self.distance(to);
    }

    pub(super) fn jump_if(&mut self, condition: Condition, to: Label) {
        self.code.extend([0x0f, 0x80 | condition as u8]);
        self.distance(to);
    }

    // Masks.

    /// An instruction with VEX prefix. `last`: a byte that follows the operands.
    fn vex(&mut self, op: Vex, register: Register, other: Register, place: Place, last: Option<u8>) {
        let (base, index) = match place {
            Place::In(other) | Place::At(Memory::At(other, _)) => (other, 0),
            Place::At(Memory::Indexed(base, index, _)) => (base, index),
            Place::At(Memory::Constant(_)) => (0, 0),
        };
        let extensions = bit(register, 3) << 7 | bit(index, 3) << 6 | bit(base, 3) << 5;
        let rest = (!other & 15) << 3 | u8::from(op.is_long) << 2 | op.prefix as u8;
        if op.map == 1 && !op.is_wide && extensions & 0x60 == 0 {
            self.code.extend([0xc5, extensions ^ 0x80 | rest]);
        } else {
            self.code
                .extend([0xc4, extensions ^ 0xe0 | op.map, u8::from(op.is_wide) << 7 | rest]);
        }
        self.byte(op.opcode);
        self.operand(register, place, 1, usize::from(last.is_some()));
        self.code.extend(last);
    }

    pub(super) fn logic(&mut self, op: Logic, to: Register, a: Register, b: Register) {
        let opcode = match op {
            Logic::And => 0x41,
            Logic::AndNot => 0x42,
            Logic::Or => 0x45,
            Logic::Same => 0x46,
            Logic::Xor => 0x47,
        };
        self.vex(Vex::of_masks(true, opcode), to, a, Place::In(b), None);
    }

    pub(super) fn invert_mask(&mut self, to: Register, from: Register) {
        self.vex(Vex::of_masks(false, 0x44), to, 0, Place::In(from), None);
    }

    /// Sets the flag of zero if no lane is set.
    pub(super) fn test_mask(&mut self, mask: Register) {
        self.vex(Vex::of_masks(false, 0x98), mask, 0, Place::In(mask), None);
    }

    pub(super) fn copy_mask(&mut self, to: Register, from: Place) {
        self.vex(Vex::of_masks(false, 0x90), to, 0, from, None);
    }

    pub(super) fn save_mask(&mut self, to: Memory, from: Register) {
        self.vex(Vex::of_masks(false, 0x91), from, 0, Place::At(to), None);
    }

    pub(super) fn mask_of_bits(&mut self, to: Register, from: Register) {
        self.vex(Vex::of_masks(false, 0x92), to, 0, Place::In(from), None);
    }

    pub(super) fn bits_of_mask(&mut self, to: Register, from: Register) {
        self.vex(Vex::of_masks(false, 0x93), to, 0, Place::In(from), None);
    }

    // Vectors.

    /// An instruction: `register` is the one in ModR/M's field of this name, `other` the one in the prefix. A vector of indices is the index
    /// of its memory.
    pub(super) fn vector(&mut self, op: Instruction, register: Register, other: Register, place: Place) {
        if self.vectors == Vectors::Avx512 {
            return self.vector_under(op, register, other, place, Under::default());
        }
        let vex = Vex {
            map: op.map,
            prefix: op.prefix,
            is_wide: op.is_wide,
            is_long: !matches!(op.width, Width::Scalar | Width::OnlyRow),
            opcode: op.opcode,
        };
        self.vex(vex, register, other, place, op.last);
    }

    /// An instruction on vectors of 512 bits that runs `under` a mask, where that isn't 0.
    pub(super) fn vector_under(
        &mut self,
        op: Instruction,
        register: Register,
        other: Register,
        place: Place,
        under: Under,
    ) {
        // Bits of numbers beyond 7 stand inverted in the prefix.
        let (x, b) = match place {
            Place::In(other) => (bit(other, 4), bit(other, 3)),
            Place::At(Memory::At(base, _)) => (0, bit(base, 3)),
            Place::At(Memory::Indexed(base, index, _)) => (bit(index, 3), bit(base, 3)),
            Place::At(Memory::Constant(_)) => (0, 0),
        };
        let v = match (op.width, place) {
            (Width::Indices, Place::At(Memory::Indexed(_, index, _))) => bit(index, 4),
            _ => bit(other, 4),
        };
        let spreads = op.width == Width::Full && matches!(place, Place::At(Memory::Constant(Constant::Word(_))));
        let (length, unit) = match op.width {
            Width::Full if spreads => (2, 4),
            Width::Full => (2, 64),
            Width::Word | Width::Indices => (2, 4),
            Width::Half => (2, 32),
            Width::Row => (2, 16),
            Width::OnlyRow => (0, 16),
            Width::Scalar => (0, 4),
        };
        self.byte(0x62);
        self.byte((bit(register, 3) << 7 | x << 6 | b << 5 | bit(register, 4) << 4) ^ 0xf0 | op.map);
        self.byte(u8::from(op.is_wide) << 7 | (!other & 15) << 3 | 1 << 2 | op.prefix as u8);
        self.byte(u8::from(under.zeroes) << 7 | length << 5 | u8::from(spreads) << 4 | (v ^ 1) << 3 | under.mask);
        self.byte(op.opcode);
        self.operand(register, place, unit, usize::from(op.last.is_some()));
        self.code.extend(op.last);
    }

    /// Writes the bytes for a register and a place. Short distances are in `unit` bytes; `after` bytes follow.
    fn operand(&mut self, register: Register, place: Place, unit: i32, after: usize) {
        let field = (register & LOW) << 3;
        let (base, index, distance) = match place {
            Place::In(other) => return self.byte(0xc0 | field | other & LOW),
            Place::At(Memory::Constant(constant)) => {
                self.byte(field | 5);
                let at = self.code.len();
                self.references.push((at, at + 4 + after, constant));
                return self.number(0);
            }
            Place::At(Memory::At(base, distance)) => (base, None, distance),
            Place::At(Memory::Indexed(base, index, distance)) => (base, Some(index), distance),
        };
        let short = i8::try_from(distance / unit).ok().filter(|_| distance % unit == 0);
        // A base that could be taken for none always has a distance.
        let mode = match short {
            Some(0) if base & LOW != RBP => 0,
            Some(_) => 1,
            None => 2,
        };
        let needs_index = index.is_some() || base & LOW == RSP;
        self.byte(mode << 6 | field | if needs_index { 4 } else { base & LOW });
        if needs_index {
            // Words, or no index.
            let index = index.map_or(RSP << 3, |index| 2 << 6 | (index & LOW) << 3);
            self.byte(index | base & LOW);
        }
        match (mode, short) {
            (1, Some(short)) => self.byte(short as u8),
            (2, _) => self.number(distance as u32),
            _ => {}
        }
    }

    /// The code, with its constants behind it.
    pub(super) fn finish(mut self) -> Vec<u8> {
        for (at, label) in self.jumps {
            let to = self.labels[label].expect("every label has its place");
            let distance = (to as i32 - (at as i32 + 4)).to_le_bytes();
            self.code[at..at + 4].copy_from_slice(&distance);
        }
        // Instructions that are never reached.
        self.code.resize(self.code.len().next_multiple_of(64), 0xcc);
        let mut places = HashMap::new();
        for (at, end, constant) in self.references {
            let to = *places.entry(constant).or_insert_with(|| {
                let place = self.code.len();
                let lanes = self.vectors.lanes();
                let copies = if self.vectors == Vectors::Avx512 { 1 } else { lanes };
                match constant {
                    Constant::Word(word) => self.code.extend((0..copies).flat_map(|_| word.to_le_bytes())),
                    Constant::Double(bits) => self.code.extend((0..lanes / 2).flat_map(|_| bits.to_le_bytes())),
                    Constant::Ramp(first) => self.code.extend((first..first + lanes).flat_map(u32::to_le_bytes)),
                }
                place
            });
            let distance = (to as i32 - end as i32).to_le_bytes();
            self.code[at..at + 4].copy_from_slice(&distance);
        }
        self.code
    }
}
