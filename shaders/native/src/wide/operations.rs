//! Instructions of 64-bit x86 with AVX2 or AVX-512, before they have registers. None of them fuses two float operations into one.

use super::encode::{Condition, Instruction, Prefix};

/// Kinds of registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Class {
    /// An integer, a truth value that is 0 or 1, or a pointer.
    Int,
    /// A truth value for each lane of a vector.
    Mask,
    /// A vector, or a float in its first lane.
    Vector,
}

/// Operations on integers that overwrite their first operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Arithmetic {
    Add,
    Or,
    And,
    Subtract,
    Xor,
}

impl Arithmetic {
    /// The number of the operation in x86's instructions.
    pub(super) fn number(self) -> u8 {
        match self {
            Self::Add => 0,
            Self::Or => 1,
            Self::And => 4,
            Self::Subtract => 5,
            Self::Xor => 6,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Shift {
    Left,
    /// Fills with zeros.
    Right,
    /// Fills with the sign.
    SignedRight,
}

/// Operations on masks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Logic {
    And,
    /// Not the first operand, and the second.
    AndNot,
    Or,
    Xor,
    /// Equal.
    Same,
}

/// An operation. Offsets are in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Op {
    /// Gives its operands the values of the function's parameters.
    Parameters,

    // Integers of 32 bits.
    Int(u32),
    /// The lower 32 bits.
    Low,
    Arithmetic(Arithmetic),
    Multiply,
    Shift(Shift),
    Negate,
    Invert,
    Size,
    /// The first operand if it compares so with the second one, else that.
    Extreme(Condition),
    /// Compares, to 0 or 1.
    Compare(Condition),
    /// The second operand if the first isn't zero, else the third.
    Choose,
    /// Divides without signs.
    Divide,
    Remainder,

    // Memory.
    /// Loads 64 bits.
    LoadPointer(i32),
    Load(i32),
    LoadFloat(i32),
    LoadVector(i32),
    /// A vector with the same word in each lane.
    LoadSpread(i32),
    /// Stores the second operand where the first one points to.
    Store(i32),
    StoreFloat(i32),
    StoreVector(i32),
    /// Stores lanes of a mask: pointer, words, mask.
    StoreMasked(i32),
    /// Points to a word, given a pointer and a number of words.
    Address,
    /// Points to a word of a local array, given its index.
    Place(u32),
    /// A word for each lane, given a pointer and numbers of words.
    Gather(i32),
    /// The four words of every fourth lane from this one on, one lane's after another's, given a pointer and numbers of words.
    Rows(u32, i32),
    /// Stores words in lanes of a mask: pointer, numbers of words, words, mask.
    Scatter(i32),

    // Between kinds.
    /// The bits of a float.
    BitsOfFloat,
    FloatOfBits,
    /// A float, to which an integer is converted.
    FloatOfInt(Instruction),
    IntOfFloat(Instruction),
    MaskOfBits,
    BitsOfMask,
    /// A vector with the same integer in each lane.
    Spread,
    /// Whether any lane is set, as 0 or 1.
    Any,

    // Masks.
    Logic(Logic),
    InvertMask,
    /// All lanes, or none.
    Lanes(bool),

    // Vectors.
    /// The same bits in each lane.
    Constant(u32),
    /// The same bits in each two lanes.
    Double(u64),
    /// The numbers from this one on.
    Ramp(u32),
    /// An instruction with one operand.
    One(Instruction),
    /// An instruction with two operands.
    Two(Instruction),
    /// The same in the lanes of a mask, the fourth operand, and the first operand in the others.
    TwoUnder(Instruction),
    /// An instruction with two operands that makes a mask.
    Test(Instruction),
    /// The same in the lanes of a mask, its third operand; the others are not set.
    TestUnder(Instruction),
    /// An instruction with one operand and a number that stands in it.
    ByNumber(Instruction, u8),
    /// The second operand where the mask is set, else the third.
    Blend,
    /// The second operand where the mask is set, else zeros.
    Masked,
    /// All ones where the mask is set, else zeros.
    Words,
    /// The upper half of a vector.
    Upper,

    // Control flow.
    /// Sets the number of turns left, which is in an array.
    SetTurns(u32),
    /// Takes one off; ends the function if there was none.
    Turn(u32),
    Jump,
    /// Goes to the first block if the operand isn't zero, else to the second.
    IfTrue,
    /// The same if the first operand compares so with the second.
    IfCompare(Condition),
    /// The same if any lane is set.
    IfAny,
    Return,
}

impl Op {
    /// Whether it does more than compute a result.
    pub(super) fn acts(self) -> bool {
        matches!(
            self,
            Self::Parameters
                | Self::Store(_)
                | Self::StoreFloat(_)
                | Self::StoreVector(_)
                | Self::StoreMasked(_)
                | Self::Scatter(_)
                | Self::SetTurns(_)
                | Self::Turn(_)
        ) || self.ends()
    }

    /// Whether its result depends on its operands alone.
    pub(super) fn is_pure(self) -> bool {
        let reads = matches!(
            self,
            Self::LoadPointer(_)
                | Self::Load(_)
                | Self::LoadFloat(_)
                | Self::LoadSpread(_)
                | Self::LoadVector(_)
                | Self::Gather(_)
                | Self::Rows(..)
        );
        !reads && !self.acts()
    }

    pub(super) fn is_constant(self) -> bool {
        matches!(
            self,
            Self::Int(_) | Self::Constant(_) | Self::Double(_) | Self::Ramp(_) | Self::Lanes(_)
        )
    }

    /// Whether it is computed before a loop that does not change it. For most integers, which have few registers, this would take longer
    /// than to compute them again.
    pub(super) fn is_lifted(self, class: Option<Class>) -> bool {
        let is_slow = class != Some(Class::Int) || matches!(self, Self::Multiply);
        is_slow && self.is_pure() && !self.is_constant()
    }

    /// The operand that may be in memory.
    pub(super) fn takes_memory(self) -> Option<usize> {
        match self {
            Self::One(_) | Self::ByNumber(..) => Some(0),
            Self::Two(_)
            | Self::Test(_)
            | Self::TestUnder(_)
            | Self::Blend
            | Self::Masked
            | Self::Arithmetic(_)
            | Self::Compare(_)
            | Self::IfCompare(_) => Some(1),
            Self::TwoUnder(_) => Some(2),
            _ => None,
        }
    }

    /// Whether it ends a block.
    pub(super) fn ends(self) -> bool {
        matches!(
            self,
            Self::Jump | Self::IfTrue | Self::IfCompare(_) | Self::IfAny | Self::Return
        )
    }
}

/// Instructions, as Intel's manual names them.
pub(super) mod instructions {
    use super::{Instruction, Prefix};

    const PLAIN: Instruction = Instruction::new(1, Prefix::None);
    const P66: Instruction = Instruction::new(1, Prefix::P66);
    const PF3: Instruction = Instruction::new(1, Prefix::PF3);
    const PF2: Instruction = Instruction::new(1, Prefix::PF2);
    const MAP2: Instruction = Instruction::new(2, Prefix::P66);
    const MAP3: Instruction = Instruction::new(3, Prefix::P66);

    pub(in super::super) const VADDPS: Instruction = PLAIN.code(0x58);
    pub(in super::super) const VMULPS: Instruction = PLAIN.code(0x59);
    pub(in super::super) const VSUBPS: Instruction = PLAIN.code(0x5c);
    pub(in super::super) const VMINPS: Instruction = PLAIN.code(0x5d);
    pub(in super::super) const VMAXPS: Instruction = PLAIN.code(0x5f);
    pub(in super::super) const VADDSS: Instruction = PF3.scalar().code(0x58);
    pub(in super::super) const VMULSS: Instruction = PF3.scalar().code(0x59);
    pub(in super::super) const VSUBSS: Instruction = PF3.scalar().code(0x5c);
    pub(in super::super) const VMINSS: Instruction = PF3.scalar().code(0x5d);
    pub(in super::super) const VMAXSS: Instruction = PF3.scalar().code(0x5f);
    pub(in super::super) const VCMPPS: Instruction = PLAIN.code(0xc2);
    pub(in super::super) const VCMPSS: Instruction = PF3.scalar().code(0xc2);
    pub(in super::super) const VPADDD: Instruction = P66.code(0xfe);
    pub(in super::super) const VPSUBD: Instruction = P66.code(0xfa);
    pub(in super::super) const VPMULLD: Instruction = MAP2.code(0x40);
    pub(in super::super) const VPANDD: Instruction = P66.code(0xdb);
    pub(in super::super) const VPORD: Instruction = P66.code(0xeb);
    pub(in super::super) const VPXORD: Instruction = P66.code(0xef);
    pub(in super::super) const VPMINUD: Instruction = MAP2.code(0x3b);
    pub(in super::super) const VPMINSD: Instruction = MAP2.code(0x39);
    pub(in super::super) const VPMAXUD: Instruction = MAP2.code(0x3f);
    pub(in super::super) const VPMAXSD: Instruction = MAP2.code(0x3d);
    pub(in super::super) const VPCMPD: Instruction = MAP3.code(0x1f);
    pub(in super::super) const VPCMPUD: Instruction = MAP3.code(0x1e);
    pub(in super::super) const VPTESTMD: Instruction = MAP2.code(0x27);
    pub(in super::super) const VPSLLD: Instruction = P66.row().code(0xf2);
    pub(in super::super) const VPSRLD: Instruction = P66.row().code(0xd2);
    pub(in super::super) const VPSRAD: Instruction = P66.row().code(0xe2);
    /// Shifts by a number; which one stands in the field of a register.
    pub(in super::super) const VPSHIFTD: Instruction = P66.code(0x72);
    pub(in super::super) const VPSLLVD: Instruction = MAP2.code(0x47);
    pub(in super::super) const VPSRLVD: Instruction = MAP2.code(0x45);
    pub(in super::super) const VPSRAVD: Instruction = MAP2.code(0x46);
    pub(in super::super) const VPABSD: Instruction = MAP2.code(0x1e);
    pub(in super::super) const VRNDSCALEPS: Instruction = MAP3.code(0x08);
    pub(in super::super) const VRNDSCALESS: Instruction = MAP3.scalar().code(0x0a);
    pub(in super::super) const VCVTDQ2PS: Instruction = PLAIN.code(0x5b);
    pub(in super::super) const VCVTUDQ2PS: Instruction = PF2.code(0x7a);
    pub(in super::super) const VCVTTPS2DQ: Instruction = PF3.code(0x5b);
    pub(in super::super) const VCVTTPS2UDQ: Instruction = PLAIN.code(0x78);
    pub(in super::super) const VCVTSI2SS: Instruction = PF3.scalar().code(0x2a);
    pub(in super::super) const VCVTUSI2SS: Instruction = PF3.scalar().code(0x7b);
    pub(in super::super) const VCVTTSS2SI: Instruction = PF3.scalar().code(0x2c);
    pub(in super::super) const VCVTTSS2USI: Instruction = PF3.scalar().code(0x78);
    pub(in super::super) const VBLENDMPS: Instruction = MAP2.code(0x65);
    pub(in super::super) const VMOVAPS: Instruction = PLAIN.code(0x28);
    pub(in super::super) const VMOVAPS_STORE: Instruction = PLAIN.code(0x29);
    pub(in super::super) const VMOVUPS: Instruction = PLAIN.code(0x10);
    pub(in super::super) const VMOVUPS_STORE: Instruction = PLAIN.code(0x11);
    /// 128 bits.
    pub(in super::super) const VMOVUPS_ROW: Instruction = PLAIN.only_row().code(0x10);
    pub(in super::super) const VMOVSS: Instruction = PF3.scalar().code(0x10);
    pub(in super::super) const VMOVSS_STORE: Instruction = PF3.scalar().code(0x11);
    pub(in super::super) const VMOVD: Instruction = P66.scalar().code(0x6e);
    pub(in super::super) const VMOVD_STORE: Instruction = P66.scalar().code(0x7e);
    pub(in super::super) const VBROADCASTSS: Instruction = MAP2.narrow().code(0x18);
    pub(in super::super) const VPBROADCASTD: Instruction = MAP2.code(0x7c);
    pub(in super::super) const VPMOVM2D: Instruction = Instruction::new(2, Prefix::PF3).code(0x38);
    pub(in super::super) const VPTERNLOGD: Instruction = MAP3.code(0x25);
    pub(in super::super) const VPGATHERDD: Instruction = MAP2.indices().code(0x90);
    pub(in super::super) const VPSCATTERDD: Instruction = MAP2.indices().code(0xa0);
    pub(in super::super) const VCVTUDQ2PD: Instruction = PF3.half().code(0x7a);
    pub(in super::super) const VDIVPD: Instruction = P66.wide().code(0x5e);
    pub(in super::super) const VCVTTPD2UDQ: Instruction = PLAIN.wide().code(0x78);
    pub(in super::super) const VEXTRACTI64X4: Instruction = MAP3.wide().half().code(0x3b);
    pub(in super::super) const VINSERTI64X4: Instruction = MAP3.wide().half().code(0x3a);
    /// Of AVX2 with another name.
    pub(in super::super) const VINSERTF32X4: Instruction = MAP3.row().code(0x18);
    pub(in super::super) const VUNPCKLPS: Instruction = PLAIN.code(0x14);
    pub(in super::super) const VUNPCKHPS: Instruction = PLAIN.code(0x15);
    pub(in super::super) const VUNPCKLPD: Instruction = P66.wide().code(0x14);
    pub(in super::super) const VUNPCKHPD: Instruction = P66.wide().code(0x15);

    // Of AVX2 alone, or used with it alone.
    pub(in super::super) const VPANDN: Instruction = P66.code(0xdf);
    pub(in super::super) const VPCMPEQD: Instruction = P66.code(0x76);
    pub(in super::super) const VPCMPGTD: Instruction = P66.code(0x66);
    pub(in super::super) const VTESTPS: Instruction = MAP2.code(0x0e);
    pub(in super::super) const VMOVMSKPS: Instruction = PLAIN.code(0x50);
    /// The register with the mask is the upper half of the last byte.
    pub(in super::super) const VBLENDVPS: Instruction = MAP3.code(0x4a);
    pub(in super::super) const VMASKMOVPS_STORE: Instruction = MAP2.code(0x2e);
    /// From a vector register, unlike [`VPBROADCASTD`].
    pub(in super::super) const VPBROADCASTD_WORD: Instruction = MAP2.narrow().code(0x58);
    pub(in super::super) const VEXTRACTI128: Instruction = MAP3.half().code(0x39);
    pub(in super::super) const VPMOVZXDQ: Instruction = MAP2.half().code(0x35);
    pub(in super::super) const VADDPD: Instruction = P66.wide().code(0x58);
    pub(in super::super) const VSUBPD: Instruction = P66.wide().code(0x5c);
    pub(in super::super) const VPOR_DOUBLE: Instruction = P66.wide().code(0xeb);
    pub(in super::super) const VROUNDPD: Instruction = MAP3.wide().code(0x09);
    pub(in super::super) const VSHUFPS: Instruction = PLAIN.code(0xc6);
    pub(in super::super) const VPERMQ: Instruction = MAP3.wide().code(0x00);
    pub(in super::super) const VCVTSI2SS_LONG: Instruction = PF3.scalar().wide().code(0x2a);
    pub(in super::super) const VCVTTSS2SI_LONG: Instruction = PF3.scalar().wide().code(0x2c);
}
