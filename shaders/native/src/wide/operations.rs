//! Instructions of 64-bit x86 with AVX-512, before they have registers. None of them fuses two float operations into one.

use super::encode::{Condition, Evex, Prefix};

/// Kinds of registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Class {
    /// An integer, a truth value that is 0 or 1, or a pointer.
    Int,
    /// A bit for each lane of a vector.
    Mask,
    /// A vector of 512 bits, or a float in its first lane.
    Vector,
}

/// Operations on integers that overwrite their first operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shift {
    Left,
    /// Fills with zeros.
    Right,
    /// Fills with the sign.
    SignedRight,
}

/// Operations on masks of 16 lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
#[derive(Clone, Copy, Debug, PartialEq)]
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
    /// Stores words in lanes of a mask: pointer, numbers of words, words, mask.
    Scatter(i32),

    // Between kinds.
    /// The bits of a float.
    BitsOfFloat,
    FloatOfBits,
    /// A float, to which an integer is converted.
    FloatOfInt(Evex),
    IntOfFloat(Evex),
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
    /// The numbers from this one on.
    Ramp(u32),
    /// An instruction with one operand.
    One(Evex),
    /// An instruction with two operands.
    Two(Evex),
    /// An instruction with two operands that makes a mask.
    Test(Evex),
    /// An instruction with one operand and a number that stands in it.
    ByNumber(Evex, u8),
    /// The second operand where the mask is set, else the third.
    Blend,
    /// The second operand where the mask is set, else zeros.
    Masked,
    /// All ones where the mask is set, else zeros.
    Words,
    /// The upper half of a vector.
    Upper,

    // Control flow.
    /// Takes one off; ends the function if there was none.
    Turn,
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
                | Self::Turn
        ) || self.ends()
    }

    /// The operand that may be in memory.
    pub(super) fn takes_memory(self) -> Option<usize> {
        match self {
            Self::One(_) | Self::ByNumber(..) => Some(0),
            Self::Two(_)
            | Self::Test(_)
            | Self::Blend
            | Self::Masked
            | Self::Arithmetic(_)
            | Self::Compare(_)
            | Self::IfCompare(_) => Some(1),
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
    use super::{Evex, Prefix};

    const PLAIN: Evex = Evex::new(1, Prefix::None);
    const P66: Evex = Evex::new(1, Prefix::P66);
    const PF3: Evex = Evex::new(1, Prefix::PF3);
    const PF2: Evex = Evex::new(1, Prefix::PF2);
    const MAP2: Evex = Evex::new(2, Prefix::P66);
    const MAP3: Evex = Evex::new(3, Prefix::P66);

    pub(in super::super) const VADDPS: Evex = PLAIN.code(0x58);
    pub(in super::super) const VMULPS: Evex = PLAIN.code(0x59);
    pub(in super::super) const VSUBPS: Evex = PLAIN.code(0x5c);
    pub(in super::super) const VMINPS: Evex = PLAIN.code(0x5d);
    pub(in super::super) const VMAXPS: Evex = PLAIN.code(0x5f);
    pub(in super::super) const VADDSS: Evex = PF3.scalar().code(0x58);
    pub(in super::super) const VMULSS: Evex = PF3.scalar().code(0x59);
    pub(in super::super) const VSUBSS: Evex = PF3.scalar().code(0x5c);
    pub(in super::super) const VMINSS: Evex = PF3.scalar().code(0x5d);
    pub(in super::super) const VMAXSS: Evex = PF3.scalar().code(0x5f);
    pub(in super::super) const VCMPPS: Evex = PLAIN.code(0xc2);
    pub(in super::super) const VCMPSS: Evex = PF3.scalar().code(0xc2);
    pub(in super::super) const VPADDD: Evex = P66.code(0xfe);
    pub(in super::super) const VPSUBD: Evex = P66.code(0xfa);
    pub(in super::super) const VPMULLD: Evex = MAP2.code(0x40);
    pub(in super::super) const VPANDD: Evex = P66.code(0xdb);
    pub(in super::super) const VPORD: Evex = P66.code(0xeb);
    pub(in super::super) const VPXORD: Evex = P66.code(0xef);
    pub(in super::super) const VPMINUD: Evex = MAP2.code(0x3b);
    pub(in super::super) const VPMINSD: Evex = MAP2.code(0x39);
    pub(in super::super) const VPMAXUD: Evex = MAP2.code(0x3f);
    pub(in super::super) const VPMAXSD: Evex = MAP2.code(0x3d);
    pub(in super::super) const VPCMPD: Evex = MAP3.code(0x1f);
    pub(in super::super) const VPCMPUD: Evex = MAP3.code(0x1e);
    pub(in super::super) const VPTESTMD: Evex = MAP2.code(0x27);
    pub(in super::super) const VPSLLD: Evex = P66.quarter().code(0xf2);
    pub(in super::super) const VPSRLD: Evex = P66.quarter().code(0xd2);
    pub(in super::super) const VPSRAD: Evex = P66.quarter().code(0xe2);
    /// Shifts by a number; which one stands in the field of a register.
    pub(in super::super) const VPSHIFTD: Evex = P66.code(0x72);
    pub(in super::super) const VPSLLVD: Evex = MAP2.code(0x47);
    pub(in super::super) const VPSRLVD: Evex = MAP2.code(0x45);
    pub(in super::super) const VPSRAVD: Evex = MAP2.code(0x46);
    pub(in super::super) const VPABSD: Evex = MAP2.code(0x1e);
    pub(in super::super) const VRNDSCALEPS: Evex = MAP3.code(0x08);
    pub(in super::super) const VRNDSCALESS: Evex = MAP3.scalar().code(0x0a);
    pub(in super::super) const VCVTDQ2PS: Evex = PLAIN.code(0x5b);
    pub(in super::super) const VCVTUDQ2PS: Evex = PF2.code(0x7a);
    pub(in super::super) const VCVTTPS2DQ: Evex = PF3.code(0x5b);
    pub(in super::super) const VCVTTPS2UDQ: Evex = PLAIN.code(0x78);
    pub(in super::super) const VCVTSI2SS: Evex = PF3.scalar().code(0x2a);
    pub(in super::super) const VCVTUSI2SS: Evex = PF3.scalar().code(0x7b);
    pub(in super::super) const VCVTTSS2SI: Evex = PF3.scalar().code(0x2c);
    pub(in super::super) const VCVTTSS2USI: Evex = PF3.scalar().code(0x78);
    pub(in super::super) const VBLENDMPS: Evex = MAP2.code(0x65);
    pub(in super::super) const VMOVAPS: Evex = PLAIN.code(0x28);
    pub(in super::super) const VMOVAPS_STORE: Evex = PLAIN.code(0x29);
    pub(in super::super) const VMOVUPS: Evex = PLAIN.code(0x10);
    pub(in super::super) const VMOVUPS_STORE: Evex = PLAIN.code(0x11);
    pub(in super::super) const VMOVSS: Evex = PF3.scalar().code(0x10);
    pub(in super::super) const VMOVSS_STORE: Evex = PF3.scalar().code(0x11);
    pub(in super::super) const VMOVD: Evex = P66.scalar().code(0x6e);
    pub(in super::super) const VMOVD_STORE: Evex = P66.scalar().code(0x7e);
    pub(in super::super) const VBROADCASTSS: Evex = MAP2.narrow().code(0x18);
    pub(in super::super) const VPBROADCASTD: Evex = MAP2.code(0x7c);
    pub(in super::super) const VPMOVM2D: Evex = Evex::new(2, Prefix::PF3).code(0x38);
    pub(in super::super) const VPTERNLOGD: Evex = MAP3.code(0x25);
    pub(in super::super) const VPGATHERDD: Evex = MAP2.indices().code(0x90);
    pub(in super::super) const VPSCATTERDD: Evex = MAP2.indices().code(0xa0);
    pub(in super::super) const VCVTUDQ2PD: Evex = PF3.half().code(0x7a);
    pub(in super::super) const VDIVPD: Evex = P66.wide().code(0x5e);
    pub(in super::super) const VCVTTPD2UDQ: Evex = PLAIN.wide().code(0x78);
    pub(in super::super) const VEXTRACTI64X4: Evex = MAP3.wide().half().code(0x3b);
    pub(in super::super) const VINSERTI64X4: Evex = MAP3.wide().half().code(0x3a);
}
