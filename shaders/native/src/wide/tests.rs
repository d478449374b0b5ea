//! By binutils' disassembler: the bytes of each kind of instruction are what they should be, with random registers, distances and numbers; and
//! kernels have none that would change a bit or leave the function.

use std::fs;
use std::process::Command;
use std::sync::atomic::{AtomicU32, Ordering};

use oneiro_shader_compiler::trees;

use super::encode::{Bytes, Condition, Instruction, Memory, Place, Register, Under, Vectors};
use super::operations::{Arithmetic, Logic, Shift, instructions as x86};
use super::write::destinations;

#[allow(dead_code, reason = "the build script uses the rest")]
#[path = "../../../catalogue.rs"]
mod catalogue;

/// Random numbers.
struct Random(u64);

impl Random {
    fn below(&mut self, end: u64) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % end
    }

    fn of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len() as u64) as usize]
    }

    /// A register of a kind, see [`SHARED`].
    fn register(&mut self, vectors: Vectors, kind: u8) -> Register {
        match (kind, vectors) {
            (b'k' | b'm', Vectors::Avx512) => 1 + self.below(7) as Register,
            (b'd' | b'q', _) | (_, Vectors::Avx2) => self.below(16) as Register,
            _ => self.below(32) as Register,
        }
    }

    fn general(&mut self) -> Register {
        self.below(16) as Register
    }

    /// A distance in whole words.
    fn distance(&mut self) -> i32 {
        let sizes = [1, 64, 4096, 1 << 20];
        let size = self.of(&sizes);
        4 * (self.below(2 * size) as i32 - size as i32)
    }
}

const LONG: [&str; 16] = [
    "rax", "rcx", "rdx", "rbx", "rsp", "rbp", "rsi", "rdi", "r8", "r9", "r10", "r11", "r12", "r13", "r14", "r15",
];
const SHORT: [&str; 16] = [
    "eax", "ecx", "edx", "ebx", "esp", "ebp", "esi", "edi", "r8d", "r9d", "r10d", "r11d", "r12d", "r13d", "r14d",
    "r15d",
];

const BYTES: [&str; 16] = [
    "al", "cl", "dl", "bl", "spl", "bpl", "sil", "dil", "r8b", "r9b", "r10b", "r11b", "r12b", "r13b", "r14b", "r15b",
];

fn long(register: Register) -> &'static str {
    LONG[register as usize]
}

fn short(register: Register) -> &'static str {
    SHORT[register as usize]
}

/// A distance as the disassembler writes it.
fn signed(distance: i32) -> String {
    match distance {
        0 => String::new(),
        1.. => format!("+{distance:#x}"),
        _ => format!("-{:#x}", distance.unsigned_abs()),
    }
}

/// Bytes and their text, one line for each instruction.
struct Both {
    bytes: Bytes,
    text: Vec<String>,
}

impl Both {
    fn new(vectors: Vectors) -> Self {
        Self {
            bytes: Bytes::new(vectors, 0),
            text: Vec::new(),
        }
    }

    /// Adds what should read like this.
    fn add(&mut self, text: String, write: impl FnOnce(&mut Bytes)) {
        self.text.push(text);
        write(&mut self.bytes);
    }
}

/// Instructions on vectors: name, kinds of the registers (`v` for vectors, `h` for half of one, `x` for a quarter or a word, `k` for a mask,
/// `d` and `q` for an integer of 32 and 64 bits, `-` for none): the result, the other, and the one that may be in memory; and the byte that
/// follows.
const SHARED: [(Instruction, &str, &str, &str); 42] = [
    (x86::VADDPS, "vaddps", "vvv", ""),
    (x86::VMULPS, "vmulps", "vvv", ""),
    (x86::VSUBPS, "vsubps", "vvv", ""),
    (x86::VMINPS, "vminps", "vvv", ""),
    (x86::VMAXPS, "vmaxps", "vvv", ""),
    (x86::VADDSS, "vaddss", "xxx", ""),
    (x86::VMULSS, "vmulss", "xxx", ""),
    (x86::VSUBSS, "vsubss", "xxx", ""),
    (x86::VMINSS, "vminss", "xxx", ""),
    (x86::VMAXSS, "vmaxss", "xxx", ""),
    (x86::VPADDD, "vpaddd", "vvv", ""),
    (x86::VPSUBD, "vpsubd", "vvv", ""),
    (x86::VPMULLD, "vpmulld", "vvv", ""),
    (x86::VPMINUD, "vpminud", "vvv", ""),
    (x86::VPMINSD, "vpminsd", "vvv", ""),
    (x86::VPMAXUD, "vpmaxud", "vvv", ""),
    (x86::VPMAXSD, "vpmaxsd", "vvv", ""),
    (x86::VPSLLVD, "vpsllvd", "vvv", ""),
    (x86::VPSRLVD, "vpsrlvd", "vvv", ""),
    (x86::VPSRAVD, "vpsravd", "vvv", ""),
    (x86::VPSLLD, "vpslld", "vvx", ""),
    (x86::VPSRLD, "vpsrld", "vvx", ""),
    (x86::VPSRAD, "vpsrad", "vvx", ""),
    (x86::VDIVPD, "vdivpd", "vvv", ""),
    (x86::VUNPCKLPS, "vunpcklps", "vvv", ""),
    (x86::VUNPCKHPS, "vunpckhps", "vvv", ""),
    (x86::VUNPCKLPD, "vunpcklpd", "vvv", ""),
    (x86::VUNPCKHPD, "vunpckhpd", "vvv", ""),
    (x86::VCMPPS.with(17), "vcmplt_oqps", "kvv", ""),
    (x86::VCMPPS.with(29), "vcmpge_oqps", "kvv", ""),
    (x86::VCMPSS.with(4), "vcmpneqss", "mxx", ""),
    (x86::VPABSD, "vpabsd", "v-v", ""),
    (x86::VCVTDQ2PS, "vcvtdq2ps", "v-v", ""),
    (x86::VCVTTPS2DQ, "vcvttps2dq", "v-v", ""),
    (x86::VMOVAPS, "vmovaps", "v-v", ""),
    (x86::VMOVUPS, "vmovups", "v-v", ""),
    (x86::VBROADCASTSS, "vbroadcastss", "v-x", ""),
    (x86::VMOVD, "vmovd", "x-d", ""),
    (x86::VCVTSI2SS, "vcvtsi2ss", "xxd", ""),
    (x86::VCVTTSS2SI, "vcvttss2si", "d-x", ""),
    (x86::VCVTSI2SS_LONG, "vcvtsi2ss", "xxq", ""),
    (x86::VCVTTSS2SI_LONG, "vcvttss2si", "q-x", ""),
];

const OF_AVX512: [(Instruction, &str, &str, &str); 18] = [
    (x86::VPANDD, "vpandd", "vvv", ""),
    (x86::VPORD, "vpord", "vvv", ""),
    (x86::VPXORD, "vpxord", "vvv", ""),
    (x86::VBLENDMPS, "vblendmps", "vvv", ""),
    (x86::VPTESTMD, "vptestmd", "kvv", ""),
    (x86::VPCMPD.with(1), "vpcmpltd", "kvv", ""),
    (x86::VPCMPUD.with(6), "vpcmpnleud", "kvv", ""),
    (x86::VCVTUDQ2PS, "vcvtudq2ps", "v-v", ""),
    (x86::VCVTTPS2UDQ, "vcvttps2udq", "v-v", ""),
    (x86::VCVTUDQ2PD, "vcvtudq2pd", "v-h", ""),
    (x86::VCVTTPD2UDQ, "vcvttpd2udq", "h-v", ""),
    (x86::VPBROADCASTD, "vpbroadcastd", "v-d", ""),
    (x86::VCVTUSI2SS, "vcvtusi2ss", "xxd", ""),
    (x86::VCVTTSS2USI, "vcvttss2usi", "d-x", ""),
    (x86::VRNDSCALEPS.with(9), "vrndscaleps", "v-v", ",0x9"),
    (x86::VRNDSCALESS.with(11), "vrndscaless", "xxx", ",0xb"),
    (x86::VINSERTI64X4.with(1), "vinserti64x4", "vvh", ",0x1"),
    (x86::VINSERTF32X4.with(3), "vinsertf32x4", "vvx", ",0x3"),
];

const OF_AVX2: [(Instruction, &str, &str, &str); 18] = [
    (x86::VINSERTF32X4.with(1), "vinsertf128", "vvx", ",0x1"),
    (x86::VPANDD, "vpand", "vvv", ""),
    (x86::VPORD, "vpor", "vvv", ""),
    (x86::VPXORD, "vpxor", "vvv", ""),
    (x86::VPANDN, "vpandn", "vvv", ""),
    (x86::VPCMPEQD, "vpcmpeqd", "vvv", ""),
    (x86::VPCMPGTD, "vpcmpgtd", "vvv", ""),
    (x86::VTESTPS, "vtestps", "v-v", ""),
    (x86::VRNDSCALEPS.with(9), "vroundps", "v-v", ",0x9"),
    (x86::VRNDSCALESS.with(11), "vroundss", "xxx", ",0xb"),
    (x86::VPBROADCASTD_WORD, "vpbroadcastd", "v-x", ""),
    (x86::VPMOVZXDQ, "vpmovzxdq", "v-h", ""),
    (x86::VADDPD, "vaddpd", "vvv", ""),
    (x86::VSUBPD, "vsubpd", "vvv", ""),
    (x86::VPOR_DOUBLE, "vpor", "vvv", ""),
    (x86::VROUNDPD.with(11), "vroundpd", "v-v", ",0xb"),
    (x86::VSHUFPS.with(0x88), "vshufps", "vvv", ",0x88"),
    (x86::VPERMQ.with(0xd8), "vpermq", "v-v", ",0xd8"),
];

/// A register as the disassembler writes it.
fn named(vectors: Vectors, kind: u8, register: Register) -> String {
    let letter = match (kind, vectors) {
        (b'd', _) => return short(register).to_owned(),
        (b'q', _) => return long(register).to_owned(),
        (b'k' | b'm', Vectors::Avx512) => return format!("k{register}"),
        (b'v', Vectors::Avx512) => 'z',
        (b'v' | b'k', Vectors::Avx2) | (b'h', Vectors::Avx512) => 'y',
        _ => 'x',
    };
    format!("{letter}mm{register}")
}

fn vectors(both: &mut Both, random: &mut Random, kind: Vectors) {
    let others: &[_] = match kind {
        Vectors::Avx2 => &OF_AVX2,
        Vectors::Avx512 => &OF_AVX512,
    };
    for &(op, name, kinds, number) in SHARED.iter().chain(others) {
        let kinds = kinds.as_bytes();
        let [result, other, last] = [0, 1, 2].map(|at| random.register(kind, kinds[at]));
        let has_other = kinds[1] != b'-';
        let other_number = if has_other { other } else { 0 };
        let mut text = format!("{name} {},", named(kind, kinds[0], result));
        if has_other {
            text = format!("{text}{},", named(kind, kinds[1], other));
        }
        both.add(format!("{text}{}{number}", named(kind, kinds[2], last)), |bytes| {
            bytes.vector(op, result, other_number, Place::In(last));
        });
        if matches!(kinds[2], b'v' | b'h' | b'x') && !matches!(kinds[0], b'd' | b'q') {
            let (base, distance) = (random.general(), random.distance());
            let size = match (kinds[2], name) {
                (b'v' | b'h', _) => match named(kind, kinds[2], 0).as_bytes()[0] {
                    b'z' => "ZMMWORD",
                    b'y' => "YMMWORD",
                    _ => "XMMWORD",
                },
                (_, "vpslld" | "vpsrld" | "vpsrad" | "vinsertf32x4" | "vinsertf128") => "XMMWORD",
                _ => "DWORD",
            };
            let place = format!("{size} PTR [{}{}]", long(base), signed(distance));
            both.add(format!("{text}{place}{number}"), |bytes| {
                bytes.vector(op, result, other_number, Place::At(Memory::At(base, distance)));
            });
        }
    }
    let [a, b] = [(); 2].map(|()| random.register(kind, b'v'));
    let (to, count) = (random.general(), random.below(32) as u8);
    let (base, distance) = (random.general(), random.distance());
    let place = format!("[{}{}]", long(base), signed(distance));
    let (letter, size) = match kind {
        Vectors::Avx2 => ('y', "YMMWORD"),
        Vectors::Avx512 => ('z', "ZMMWORD"),
    };
    for (op, text) in [
        (x86::VMOVAPS_STORE, format!("vmovaps {size} PTR {place},{letter}mm{a}")),
        (x86::VMOVUPS_STORE, format!("vmovups {size} PTR {place},{letter}mm{a}")),
        (x86::VMOVSS_STORE, format!("vmovss DWORD PTR {place},xmm{a}")),
        (x86::VMOVSS, format!("vmovss xmm{a},DWORD PTR {place}")),
        (x86::VMOVUPS_ROW, format!("vmovups xmm{a},XMMWORD PTR {place}")),
    ] {
        both.add(text, |bytes| {
            bytes.vector(op, a, 0, Place::At(Memory::At(base, distance)));
        });
    }
    both.add(format!("vmovd {},xmm{a}", short(to)), |bytes| {
        bytes.vector(x86::VMOVD_STORE, a, 0, Place::In(to));
    });
    for (number, name) in [(6, "vpslld"), (2, "vpsrld"), (4, "vpsrad")] {
        both.add(format!("{name} {letter}mm{a},{letter}mm{b},{count:#x}"), |bytes| {
            bytes.vector(x86::VPSHIFTD.with(count), number, a, Place::In(b));
        });
    }
}

/// Instructions on vectors of 256 bits with their masks.
fn masked_by_vectors(both: &mut Both, random: &mut Random) {
    let [a, b, c, d] = [(); 4].map(|()| random.register(Vectors::Avx2, b'v'));
    let (to, base, distance) = (random.general(), random.general(), random.distance());
    let place = format!("[{}{}]", long(base), signed(distance));
    both.add(format!("vblendvps ymm{a},ymm{b},ymm{c},ymm{d}"), |bytes| {
        bytes.vector(x86::VBLENDVPS.with(d << 4), a, b, Place::In(c));
    });
    both.add(format!("vblendvps ymm{a},ymm{b},YMMWORD PTR {place},ymm{d}"), |bytes| {
        bytes.vector(x86::VBLENDVPS.with(d << 4), a, b, Place::At(Memory::At(base, distance)));
    });
    both.add(format!("vmaskmovps YMMWORD PTR {place},ymm{b},ymm{a}"), |bytes| {
        bytes.vector(x86::VMASKMOVPS_STORE, a, b, Place::At(Memory::At(base, distance)));
    });
    let others = [1, 2].map(|more| (b + more) % 16);
    let words = format!("[{}+ymm{b}*4{}]", long(base), signed(distance));
    both.add(
        format!("vpgatherdd ymm{},DWORD PTR {words},ymm{}", others[0], others[1]),
        |bytes| {
            let from = Place::At(Memory::Indexed(base, b, distance));
            bytes.vector(x86::VPGATHERDD, others[0], others[1], from);
        },
    );
    both.add(format!("vmovmskps {},ymm{a}", short(to)), |bytes| {
        bytes.vector(x86::VMOVMSKPS, to, 0, Place::In(a));
    });
    both.add(format!("vextracti128 xmm{a},ymm{b},0x1"), |bytes| {
        bytes.vector(x86::VEXTRACTI128.with(1), b, 0, Place::In(a));
    });
    both.add(format!("tzcnt {},{}", short(to), short(base)), |bytes| {
        bytes.first_bit(to, base);
    });
    both.add(format!("blsr {},{}", short(to), short(to)), |bytes| {
        bytes.drop_first_bit(to);
    });
}

/// Instructions on vectors of 512 bits with their masks.
fn masked(both: &mut Both, random: &mut Random) {
    let kind = Vectors::Avx512;
    let [a, b] = [(); 2].map(|()| random.register(kind, b'v'));
    let (mask, zeroes) = (random.register(kind, b'k'), random.below(2) == 1);
    let z = if zeroes { "{z}" } else { "" };
    both.add(format!("vmovups zmm{a}{{k{mask}}}{z},zmm{b}"), |bytes| {
        bytes.vector_under(x86::VMOVUPS, a, 0, Place::In(b), Under { mask, zeroes });
    });
    let c = random.register(kind, b'v');
    both.add(format!("vaddps zmm{a}{{k{mask}}},zmm{b},zmm{c}"), |bytes| {
        bytes.vector_under(x86::VADDPS, a, b, Place::In(c), Under::lanes_of(mask));
    });
    let to = random.register(kind, b'k');
    both.add(format!("vcmplt_oqps k{to}{{k{mask}}},zmm{b},zmm{c}"), |bytes| {
        let test = x86::VCMPPS.with(17);
        bytes.vector_under(test, to, b, Place::In(c), Under::lanes_of(mask));
    });
    let (base, distance) = (random.general(), random.distance());
    let place = format!("[{}{}]", long(base), signed(distance));
    both.add(format!("vmovups ZMMWORD PTR {place}{{k{mask}}},zmm{a}"), |bytes| {
        let to = Place::At(Memory::At(base, distance));
        bytes.vector_under(x86::VMOVUPS_STORE, a, 0, to, Under::lanes_of(mask));
    });
    let words = format!("[{}+zmm{b}*4{}]", long(base), signed(distance));
    let to = (b + 1) % 32;
    both.add(format!("vpgatherdd zmm{to}{{k{mask}}},DWORD PTR {words}"), |bytes| {
        let from = Place::At(Memory::Indexed(base, b, distance));
        bytes.vector_under(x86::VPGATHERDD, to, 0, from, Under::lanes_of(mask));
    });
    both.add(format!("vpscatterdd DWORD PTR {words}{{k{mask}}},zmm{a}"), |bytes| {
        let to = Place::At(Memory::Indexed(base, b, distance));
        bytes.vector_under(x86::VPSCATTERDD, a, 0, to, Under::lanes_of(mask));
    });
    both.add(format!("vpmovm2d zmm{a},k{mask}"), |bytes| {
        bytes.vector(x86::VPMOVM2D, a, 0, Place::In(mask));
    });
    both.add(format!("vextracti64x4 ymm{a},zmm{b},0x1"), |bytes| {
        bytes.vector(x86::VEXTRACTI64X4.with(1), b, 0, Place::In(a));
    });
    both.add(format!("vpternlogd zmm{a},zmm{a},zmm{a},0xff"), |bytes| {
        bytes.vector(x86::VPTERNLOGD.with(0xff), a, a, Place::In(a));
    });
}

/// Instructions on integers.
fn integers(both: &mut Both, random: &mut Random) {
    let (a, b, c) = (random.general(), random.general(), random.general());
    let number = random.below(1 << 31) as u32;
    let (base, distance) = (random.general(), random.distance());
    let place = format!("[{}{}]", long(base), signed(distance));
    let memory = Memory::At(base, distance);
    both.add(format!("mov {},{number:#x}", short(a)), |bytes| {
        bytes.set_number(a, number);
    });
    both.add(format!("mov {},{}", long(a), long(b)), |bytes| {
        bytes.copy(true, a, Place::In(b));
    });
    both.add(format!("mov {},DWORD PTR {place}", short(a)), |bytes| {
        bytes.copy(false, a, Place::At(memory));
    });
    both.add(format!("mov QWORD PTR {place},{}", long(a)), |bytes| {
        bytes.save(true, memory, a);
    });
    for (op, name) in [
        (Arithmetic::Add, "add"),
        (Arithmetic::Or, "or"),
        (Arithmetic::And, "and"),
        (Arithmetic::Subtract, "sub"),
        (Arithmetic::Xor, "xor"),
    ] {
        both.add(format!("{name} {},{}", short(a), short(b)), |bytes| {
            bytes.arithmetic(false, op, a, Place::In(b));
        });
        both.add(format!("{name} {},DWORD PTR {place}", short(a)), |bytes| {
            bytes.arithmetic(false, op, a, Place::At(memory));
        });
        both.add(format!("{name} {},{number:#x}", short(a)), |bytes| {
            bytes.arithmetic_with_number(false, op, a, number);
        });
    }
    both.add(format!("cmp {},{}", short(a), short(b)), |bytes| {
        bytes.compare(a, Place::In(b));
    });
    both.add(format!("cmp {},{number:#x}", short(a)), |bytes| {
        bytes.compare_with_number(a, number);
    });
    both.add(format!("test {},{}", short(a), short(a)), |bytes| bytes.test(a));
    both.add(format!("imul {},{}", short(a), short(b)), |bytes| bytes.multiply(a, b));
    both.add(format!("imul {},{},{number:#x}", short(a), short(b)), |bytes| {
        bytes.multiply_by(a, b, number);
    });
    both.add(format!("neg {}", short(a)), |bytes| bytes.negate(a));
    both.add(format!("not {}", short(a)), |bytes| bytes.invert(a));
    both.add(format!("div {}", short(a)), |bytes| bytes.divide(a));
    for (op, by_number, name) in [
        (Shift::Left, "shl", "shlx"),
        (Shift::Right, "shr", "shrx"),
        (Shift::SignedRight, "sar", "sarx"),
    ] {
        let count = 2 + random.below(30) as u8;
        both.add(format!("{by_number} {},{count:#x}", short(a)), |bytes| {
            bytes.shift_by(op, a, count);
        });
        both.add(format!("{name} {},{},{}", short(a), short(b), short(c)), |bytes| {
            bytes.shift(op, a, b, c);
        });
    }
    for (condition, name) in [
        (Condition::Below, "b"),
        (Condition::AboveEqual, "ae"),
        (Condition::Equal, "e"),
        (Condition::NotEqual, "ne"),
        (Condition::BelowEqual, "be"),
        (Condition::Above, "a"),
        (Condition::Negative, "s"),
        (Condition::Less, "l"),
        (Condition::GreaterEqual, "ge"),
        (Condition::LessEqual, "le"),
        (Condition::Greater, "g"),
    ] {
        both.add(format!("cmov{name} {},{}", short(a), short(b)), |bytes| {
            bytes.copy_if(condition, a, b);
        });
        both.add(format!("set{name} {}", BYTES[a as usize]), |bytes| {
            bytes.set_if(condition, a);
        });
        both.text.push(format!("movzx {},{}", short(a), BYTES[a as usize]));
    }
    let index = random.of(&[0, 1, 2, 3, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15]);
    both.add(
        format!("lea {},[{}+{}*4{}]", long(a), long(base), long(index), signed(distance)),
        |bytes| {
            bytes.address(a, Memory::Indexed(base, index, distance));
        },
    );
    both.add(format!("push {}", long(a)), |bytes| bytes.push(a));
    both.add(format!("pop {}", long(a)), |bytes| bytes.pop(a));
    both.add(format!("test DWORD PTR {place},eax"), |bytes| bytes.touch(memory));
    both.add(format!("sub QWORD PTR {place},0x1"), |bytes| bytes.take_one_off(memory));
}

fn masks(both: &mut Both, random: &mut Random) {
    let [a, b, c] = [(); 3].map(|()| random.register(Vectors::Avx512, b'k'));
    for (op, name) in [
        (Logic::And, "kandw"),
        (Logic::AndNot, "kandnw"),
        (Logic::Or, "korw"),
        (Logic::Xor, "kxorw"),
        (Logic::Same, "kxnorw"),
    ] {
        both.add(format!("{name} k{a},k{b},k{c}"), |bytes| bytes.logic(op, a, b, c));
    }
    let (general, base, distance) = (random.general(), random.general(), random.distance());
    let place = format!("WORD PTR [{}{}]", long(base), signed(distance));
    both.add(format!("knotw k{a},k{b}"), |bytes| bytes.invert_mask(a, b));
    both.add(format!("kortestw k{a},k{a}"), |bytes| bytes.test_mask(a));
    both.add(format!("kmovw k{a},k{b}"), |bytes| bytes.copy_mask(a, Place::In(b)));
    both.add(format!("kmovw k{a},{place}"), |bytes| {
        bytes.copy_mask(a, Place::At(Memory::At(base, distance)));
    });
    both.add(format!("kmovw {place},k{a}"), |bytes| {
        bytes.save_mask(Memory::At(base, distance), a);
    });
    both.add(format!("kmovw k{a},{}", short(general)), |bytes| {
        bytes.mask_of_bits(a, general);
    });
    both.add(format!("kmovw {},k{a}", short(general)), |bytes| {
        bytes.bits_of_mask(general, a);
    });
}

/// The text of code, an instruction a line, or `None` if there is no disassembler.
fn disassembled(code: &[u8]) -> Option<Vec<String>> {
    static MADE: AtomicU32 = AtomicU32::new(0);
    let number = MADE.fetch_add(1, Ordering::Relaxed);
    let path = std::env::temp_dir().join(format!("oneiro-wide-{}-{number}.bin", std::process::id()));
    fs::write(&path, code).expect("there is room");
    let mut command = Command::new("objdump");
    command.args("-D -b binary -m i386:x86-64 -M intel --no-show-raw-insn -w".split(' '));
    let output = command.arg(&path).output();
    fs::remove_file(&path).expect("it was written");
    let text = String::from_utf8(output.ok()?.stdout).expect("it is text");
    let instruction = |line: &str| {
        let text = line.split_once(":\t")?.1.split('#').next()?;
        // It also names the encoding, where there are two, and an unneeded prefix.
        let words: Vec<_> = text
            .split_whitespace()
            .filter(|word| !["{evex}", "rex"].contains(word))
            .collect();
        // A base that needs a distance may have one of 0.
        Some(words.join(" ").replace("+0x0]", "]"))
    };
    Some(text.lines().filter_map(instruction).collect())
}

#[test]
fn bytes_are_what_a_disassembler_reads() {
    for kind in [Vectors::Avx2, Vectors::Avx512] {
        let mut random = Random(1);
        let mut both = Both::new(kind);
        for _ in 0..200 {
            vectors(&mut both, &mut random, kind);
            integers(&mut both, &mut random);
            match kind {
                Vectors::Avx2 => masked_by_vectors(&mut both, &mut random),
                Vectors::Avx512 => {
                    masked(&mut both, &mut random);
                    masks(&mut both, &mut random);
                }
            }
        }
        let read = disassembled(&both.bytes.finish()).expect("binutils is there, which Rust needs to link programs");
        let differ = read.iter().zip(&both.text).filter(|(read, written)| read != written);
        assert_eq!(differ.take(20).collect::<Vec<_>>(), [], "{kind:?}");
        assert!(
            read.len() >= both.text.len() && both.text.len() > 30_000,
            "{kind:?}: {}",
            both.text.len()
        );
    }
}

/// Code ends before its constants.
const LAST: [u8; 4] = [0xc5, 0xf8, 0x77, 0xc3];

#[test]
fn nothing_is_fused_or_approximate_and_nothing_is_called() {
    for entry in catalogue::CATALOGUE {
        let trees = trees(&catalogue::parts(entry)).expect("it is exact");
        let both = [Vectors::Avx2, Vectors::Avx512];
        let all = both
            .into_iter()
            .flat_map(|vectors| vectors.numbers().iter().map(move |lanes| (vectors, *lanes)));
        for (vectors, lanes) in all {
            let code = vectors.compile(&trees, lanes, false).expect("it compiles");
            let end = code.windows(4).position(|bytes| bytes == LAST).expect("it returns");
            let read = disassembled(&code[..end + LAST.len()]).expect("binutils is there");
            for text in read {
                let name = text.split(' ').next().expect("an instruction has a name");
                let is_fused = ["vfm", "vfnm", "vp4", "vdp"]
                    .iter()
                    .any(|fused| name.starts_with(fused));
                let is_approximate = ["rcp", "rsqrt", "exp2", "scalef", "reduce", "range"]
                    .iter()
                    .any(|part| name.contains(part));
                let leaves = ["call", "syscall", "int", "(bad)"].contains(&name);
                assert!(
                    !is_fused && !is_approximate && !leaves,
                    "{}: {text} ({vectors:?})",
                    entry.name
                );
            }
        }
    }
}

/// Every way in which up to five blocks jump: whoever follows the jumps comes to the same block, which is left in.
#[test]
fn blocks_that_only_jump_are_left_out() {
    for blocks in 1..=5_usize {
        for way in 0..(blocks + 1).pow(blocks as u32) {
            let choice = |block: usize| way / (blocks + 1).pow(block as u32) % (blocks + 1);
            let jumps: Vec<_> = (0..blocks).map(|block| choice(block).checked_sub(1)).collect();
            let labels = destinations(&jumps);
            for (block, label) in labels.iter().enumerate() {
                assert_eq!(labels[*label], *label, "{jumps:?}: {labels:?}");
                let followed = std::iter::successors(Some(block), |block| jumps[*block]).take(blocks + 1);
                let followed: Vec<_> = followed.collect();
                assert!(followed.contains(label), "{jumps:?}: {labels:?}");
                // Only a loop without any code ends at a block that jumps.
                assert!(
                    jumps[*label].is_none() || followed.len() > blocks,
                    "{jumps:?}: {labels:?}"
                );
            }
        }
    }
}
