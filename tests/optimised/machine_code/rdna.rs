//! Runs machine code of AMD's RDNA 2, as Mesa disassembles it: a wave of 64 lanes, instruction by instruction. It shows which bits the
//! code of a card computes and what it issues, without the card.
//!
//! What instructions do is in AMD's "RDNA 2 Instruction Set Architecture" (2020). An instruction that is not known stops the run.

use std::collections::HashMap;
use std::num::FpCategory;

const LANES: usize = 64;
/// Numbers of scalar registers with names.
const VCC: usize = 106;
const EXEC: usize = 126;
/// Registers with which a wave begins: the address of the buffers' descriptors, and the workgroup.
const DESCRIPTORS: usize = 2;
const WORKGROUP: usize = 3;
/// Bytes of a descriptor, of which the third word is the buffer's length in bytes.
const DESCRIPTOR: usize = 16;
/// More instructions than any test's wave issues.
const PATIENCE: u64 = 50_000_000;

/// An operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Source {
    Vector(usize),
    Scalar(usize),
    Constant(u64),
    Scc,
}

#[derive(Clone, Copy, Debug)]
struct Operand {
    source: Source,
    negative: bool,
    absolute: bool,
}

#[derive(Debug)]
struct Instruction {
    name: String,
    operands: Vec<Operand>,
    /// Where a branch goes.
    target: usize,
    /// Added to a memory address, bytes.
    offset: usize,
    clamp: bool,
    /// What a float result is multiplied by.
    scale: f32,
    /// Halves of words that the sources are: 0 all of it, 1 the low one, 2 the high one.
    halves: [u8; 2],
}

/// A program.
pub(crate) struct Code(Vec<Instruction>);

/// Instructions that were issued.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Issued {
    /// On vectors.
    pub(crate) vector: u64,
    /// On scalars, branches among them, but for waiting and hints.
    pub(crate) scalar: u64,
    /// Loads and stores.
    pub(crate) memory: u64,
    /// Products of 32-bit integers, of vectors or scalars.
    pub(crate) products: u64,
}

impl Issued {
    pub(crate) fn all(self) -> u64 {
        self.vector + self.scalar + self.memory
    }
}

impl Code {
    /// Reads a disassembly.
    pub(crate) fn new(text: &str) -> Self {
        let mut all: Vec<String> = Vec::new();
        let mut labels = HashMap::new();
        for line in text.lines() {
            let line = line.split(';').next().unwrap_or_default().trim();
            if let Some(label) = line.strip_suffix(':') {
                labels.insert(label.to_owned(), all.len());
            } else if let Some(times) = line.strip_prefix("(then repeated ") {
                let times: usize = times.split(' ').next().unwrap().parse().unwrap();
                let last = all.last().unwrap().clone();
                all.extend(std::iter::repeat_n(last, times));
            } else if !line.is_empty() {
                all.push(line.to_owned());
            }
        }
        Self(all.iter().map(|line| instruction(line, &labels)).collect())
    }

    /// Runs the wave of a workgroup over buffers, by binding number.
    pub(crate) fn run(&self, buffers: &mut [Vec<u32>], workgroup: u32) -> Issued {
        let mut wave = Wave {
            scalars: [0; 128],
            vectors: vec![[0; LANES]; 256],
            scc: false,
            buffers,
            issued: Issued::default(),
        };
        wave.scalars[WORKGROUP] = workgroup;
        wave.set_wide(EXEC, u64::MAX);
        wave.vectors[0] = std::array::from_fn(|lane| lane as u32);
        let mut at = 0;
        for _ in 0..PATIENCE {
            let own = &self.0[at];
            if own.name == "s_endpgm" {
                return wave.issued;
            }
            at = if wave.step(own) { own.target } else { at + 1 };
        }
        panic!("it does not end");
    }
}

fn instruction(line: &str, labels: &HashMap<String, usize>) -> Instruction {
    let (name, rest) = line.split_once(' ').unwrap_or((line, ""));
    let mut own = Instruction {
        name: name
            .trim_end_matches("_e32")
            .trim_end_matches("_e64")
            .trim_end_matches("_sdwa")
            .to_owned(),
        operands: Vec::new(),
        target: 0,
        offset: 0,
        clamp: false,
        scale: 1.0,
        halves: [0; 2],
    };
    if name.starts_with("s_waitcnt") || ["s_clause", "s_nop", "s_inst_prefetch"].contains(&name) {
        return own;
    }
    if name.contains("branch") {
        own.target = labels[rest.trim()];
        return own;
    }
    for token in rest.split([',', ' ']).filter(|token| !token.is_empty()) {
        let half = |text: &str| match text {
            "DWORD" => 0,
            "WORD_0" => 1,
            "WORD_1" => 2,
            other => panic!("{line}: {other}"),
        };
        match token.split_once(':') {
            Some(("offset", bytes)) => {
                own.offset = match bytes.strip_prefix("0x") {
                    Some(hex) => usize::from_str_radix(hex, 16).unwrap(),
                    None => bytes.parse().unwrap(),
                };
            }
            Some(("mul", factor)) => own.scale = factor.parse().unwrap(),
            Some(("div", by)) => own.scale = 1.0 / by.parse::<f32>().unwrap(),
            Some(("src0_sel", which)) => own.halves[0] = half(which),
            Some(("src1_sel", which)) => own.halves[1] = half(which),
            Some(("dst_sel", which)) => assert_eq!(half(which), 0, "{line}"),
            Some(("dst_unused", _)) => {}
            _ => match token {
                "clamp" => own.clamp = true,
                "offen" | "glc" | "slc" | "dlc" => {}
                _ => own.operands.push(operand(token, line)),
            },
        }
    }
    own
}

fn operand(token: &str, line: &str) -> Operand {
    // Of an integer's bits.
    let (token, is_negated) = match token.strip_prefix("neg(") {
        Some(rest) => (rest.trim_end_matches(')'), true),
        None => (token, false),
    };
    // A number has a sign of its own.
    let is_number = token
        .trim_start_matches('-')
        .starts_with(|first: char| first.is_ascii_digit());
    let negative = !is_number && token.starts_with('-');
    let inner = if negative { &token[1..] } else { token };
    let absolute = inner.starts_with('|');
    let inner = inner.trim_matches('|');
    let register = |kind: char| {
        let rest = inner.strip_prefix(kind)?;
        let first = rest.trim_start_matches('[').split([':', ']']).next()?;
        first.parse::<usize>().ok()
    };
    let source = match inner {
        "vcc" | "vcc_lo" => Source::Scalar(VCC),
        "vcc_hi" => Source::Scalar(VCC + 1),
        "exec" | "exec_lo" => Source::Scalar(EXEC),
        "exec_hi" => Source::Scalar(EXEC + 1),
        "src_scc" => Source::Scc,
        "null" | "off" => Source::Constant(0),
        _ if register('v').is_some() => Source::Vector(register('v').unwrap()),
        _ if register('s').is_some() => Source::Scalar(register('s').unwrap()),
        _ => {
            let number = inner.trim_matches('|');
            let constant = if let Some(hex) = number.strip_prefix("0x") {
                u64::from_str_radix(hex, 16).ok()
            } else if number.contains('.') {
                number.parse::<f32>().ok().map(|float| u64::from(float.to_bits()))
            } else {
                number.parse::<i64>().ok().map(i64::cast_unsigned)
            };
            Source::Constant(constant.unwrap_or_else(|| panic!("{line}: {token}")))
        }
    };
    Operand {
        source,
        negative: negative != is_negated,
        absolute,
    }
}

struct Wave<'a> {
    scalars: [u32; 128],
    vectors: Vec<[u32; LANES]>,
    scc: bool,
    buffers: &'a mut [Vec<u32>],
    issued: Issued,
}

impl Wave<'_> {
    fn wide(&self, register: usize) -> u64 {
        u64::from(self.scalars[register]) | u64::from(self.scalars[register + 1]) << 32
    }

    fn set_wide(&mut self, register: usize, value: u64) {
        self.scalars[register] = value as u32;
        self.scalars[register + 1] = (value >> 32) as u32;
    }

    /// A scalar source.
    fn scalar(&self, operand: Operand) -> u32 {
        match operand.source {
            Source::Scalar(register) => self.scalars[register],
            Source::Constant(bits) => bits as u32,
            Source::Scc => u32::from(self.scc),
            Source::Vector(register) => panic!("v{register} is no scalar"),
        }
    }

    fn scalar_wide(&self, operand: Operand) -> u64 {
        match operand.source {
            Source::Scalar(register) => self.wide(register),
            Source::Constant(bits) => bits,
            other => panic!("{other:?} is no pair of scalars"),
        }
    }

    /// A lane's word of a source.
    fn word(&self, operand: Operand, lane: usize) -> u32 {
        let bits = match operand.source {
            Source::Vector(register) => self.vectors[register][lane],
            _ => self.scalar(operand),
        };
        let bits = if operand.absolute { bits & 0x7fff_ffff } else { bits };
        if operand.negative { bits ^ 0x8000_0000 } else { bits }
    }

    fn is_active(&self, lane: usize) -> bool {
        self.wide(EXEC) >> lane & 1 != 0
    }

    /// Runs one instruction. Returns whether it branches.
    fn step(&mut self, own: &Instruction) -> bool {
        let name = own.name.as_str();
        if name.starts_with("buffer_") || name.starts_with("s_load") || name.starts_with("s_buffer_load") {
            self.issued.memory += 1;
            self.access(own);
            return false;
        }
        if name.starts_with("v_") {
            self.issued.vector += 1;
            self.issued.products += u64::from(name.starts_with("v_mul_lo") || name.starts_with("v_mul_hi"));
            self.vector(own);
            return false;
        }
        if name.starts_with("s_waitcnt") || ["s_clause", "s_nop", "s_inst_prefetch"].contains(&name) {
            return false;
        }
        self.issued.scalar += 1;
        self.issued.products += u64::from(name.starts_with("s_mul"));
        match name {
            "s_branch" => true,
            "s_cbranch_scc0" => !self.scc,
            "s_cbranch_scc1" => self.scc,
            "s_cbranch_execz" => self.wide(EXEC) == 0,
            "s_cbranch_execnz" => self.wide(EXEC) != 0,
            "s_cbranch_vccz" => self.wide(VCC) == 0,
            "s_cbranch_vccnz" => self.wide(VCC) != 0,
            _ => {
                self.scalar_operation(own);
                false
            }
        }
    }

    fn scalar_operation(&mut self, own: &Instruction) {
        let name = own.name.as_str();
        let at = |index: usize| own.operands[index];
        let register = |index: usize| match at(index).source {
            Source::Scalar(register) => register,
            other => panic!("{name}: {other:?} is no scalar register"),
        };
        if let Some(compared) = name.strip_prefix("s_cmp_").or_else(|| name.strip_prefix("s_cmpk_")) {
            let (a, b) = (self.scalar(at(0)), self.scalar(at(1)));
            self.scc = compare(compared, a, b);
            return;
        }
        if let "s_bitcmp0_b32" | "s_bitcmp1_b32" = name {
            let bit = self.scalar(at(0)) >> (self.scalar(at(1)) & 31) & 1;
            self.scc = bit == u32::from(name == "s_bitcmp1_b32");
            return;
        }
        if let Some(kind) = name.strip_suffix("_b64") {
            let value = match kind {
                "s_andn2_wrexec" => {
                    let left = self.scalar_wide(at(1)) & !self.wide(EXEC);
                    self.set_wide(EXEC, left);
                    left
                }
                "s_mov" => self.scalar_wide(at(1)),
                "s_not" => !self.scalar_wide(at(1)),
                "s_and_saveexec" => {
                    let exec = self.wide(EXEC);
                    let kept = exec & self.scalar_wide(at(1));
                    self.set_wide(EXEC, kept);
                    self.scc = kept != 0;
                    self.set_wide(register(0), exec);
                    return;
                }
                _ => {
                    let (a, b) = (self.scalar_wide(at(1)), self.scalar_wide(at(2)));
                    match kind {
                        "s_and" => a & b,
                        "s_or" => a | b,
                        "s_xor" => a ^ b,
                        "s_andn2" => a & !b,
                        "s_orn2" => a | !b,
                        "s_nor" => !(a | b),
                        "s_nand" => !(a & b),
                        "s_cselect" => {
                            let value = if self.scc { a } else { b };
                            self.set_wide(register(0), value);
                            return;
                        }
                        _ => panic!("{name} is not known"),
                    }
                }
            };
            self.set_wide(register(0), value);
            if kind != "s_mov" {
                self.scc = value != 0;
            }
            return;
        }
        let immediate = |own: Operand| match own.source {
            Source::Constant(bits) => i32::from(bits as u16 as i16) as u32,
            other => panic!("{name}: {other:?} is no constant"),
        };
        let old = self.scalars[register(0)];
        let value = match name {
            "s_mov_b32" => self.scalar(at(1)),
            "s_movk_i32" => immediate(at(1)),
            "s_brev_b32" => self.scalar(at(1)).reverse_bits(),
            "s_mulk_i32" => old.wrapping_mul(immediate(at(1))),
            "s_addk_i32" => {
                let (sum, overflows) = old.cast_signed().overflowing_add(immediate(at(1)).cast_signed());
                self.scc = overflows;
                sum.cast_unsigned()
            }
            _ => {
                let (a, b) = (self.scalar(at(1)), self.scalar(at(2)));
                match name {
                    "s_add_u32" => {
                        let (sum, carry) = a.overflowing_add(b);
                        self.scc = carry;
                        sum
                    }
                    "s_add_i32" => {
                        self.scc = a.cast_signed().overflowing_add(b.cast_signed()).1;
                        a.wrapping_add(b)
                    }
                    "s_sub_u32" => {
                        self.scc = b > a;
                        a.wrapping_sub(b)
                    }
                    "s_sub_i32" => {
                        self.scc = a.cast_signed().overflowing_sub(b.cast_signed()).1;
                        a.wrapping_sub(b)
                    }
                    "s_mul_i32" => a.wrapping_mul(b),
                    "s_pack_hh_b32_b16" => a >> 16 | b & 0xffff_0000,
                    "s_mul_hi_u32" => ((u64::from(a) * u64::from(b)) >> 32) as u32,
                    "s_cselect_b32" => {
                        if self.scc {
                            a
                        } else {
                            b
                        }
                    }
                    "s_bfm_b32" => low_bits(a & 31) << (b & 31),
                    "s_min_u32" => {
                        self.scc = a < b;
                        a.min(b)
                    }
                    "s_max_u32" => {
                        self.scc = a > b;
                        a.max(b)
                    }
                    "s_lshl1_add_u32" | "s_lshl2_add_u32" | "s_lshl3_add_u32" | "s_lshl4_add_u32" => {
                        let shift = u32::from(name.as_bytes()[6] - b'0');
                        let sum = (u64::from(a) << shift) + u64::from(b);
                        self.scc = sum > u64::from(u32::MAX);
                        sum as u32
                    }
                    _ => {
                        let value = match name {
                            "s_and_b32" => a & b,
                            "s_or_b32" => a | b,
                            "s_xor_b32" => a ^ b,
                            "s_andn2_b32" => a & !b,
                            "s_lshl_b32" => a << (b & 31),
                            "s_lshr_b32" => a >> (b & 31),
                            "s_bfe_u32" => a >> (b & 31) & low_bits(b >> 16 & 0x7f),
                            _ => panic!("{name} is not known"),
                        };
                        self.scc = value != 0;
                        value
                    }
                }
            }
        };
        self.scalars[register(0)] = value;
    }

    /// A load or a store.
    fn access(&mut self, own: &Instruction) {
        let name = own.name.as_str();
        let at = |index: usize| own.operands[index];
        let words = match name.rsplit_once("dword").unwrap().1 {
            "" => 1,
            more => more[1..].parse::<usize>().unwrap(),
        };
        if name.starts_with("s_load") {
            assert_eq!(
                at(1).source,
                Source::Scalar(DESCRIPTORS),
                "only descriptors lie in memory"
            );
            assert_eq!(words, DESCRIPTOR / 4);
            let binding = self.scalar(at(2)) as usize / DESCRIPTOR;
            let Source::Scalar(to) = at(0).source else {
                panic!("{name}")
            };
            self.scalars[to..to + 4].copy_from_slice(&[binding as u32, 0, 4 * self.buffers[binding].len() as u32, 0]);
            return;
        }
        let descriptor = |wave: &Self, index: usize| match at(index).source {
            Source::Scalar(register) => (wave.scalars[register] as usize, wave.scalars[register + 2] as usize),
            other => panic!("{name}: {other:?}"),
        };
        if name.starts_with("s_buffer_load") {
            let (buffer, bytes) = descriptor(self, 1);
            let Source::Scalar(to) = at(0).source else {
                panic!("{name}")
            };
            let first = self.scalar(at(2)) as usize + own.offset;
            for word in 0..words {
                let address = first + 4 * word;
                self.scalars[to + word] = if address + 4 <= bytes {
                    self.buffers[buffer][address / 4]
                } else {
                    0
                };
            }
            return;
        }
        let (buffer, bytes) = descriptor(self, 2);
        let Source::Vector(data) = at(0).source else {
            panic!("{name}")
        };
        for lane in (0..LANES).filter(|lane| self.is_active(*lane)).collect::<Vec<_>>() {
            let first = self.word(at(1), lane) as usize + self.scalar(at(3)) as usize + own.offset;
            for word in 0..words {
                let address = first + 4 * word;
                let is_within = address + 4 <= bytes;
                if name.starts_with("buffer_store") {
                    if is_within {
                        self.buffers[buffer][address / 4] = self.vectors[data + word][lane];
                    }
                } else {
                    self.vectors[data + word][lane] = if is_within {
                        self.buffers[buffer][address / 4]
                    } else {
                        0
                    };
                }
            }
        }
    }

    fn vector(&mut self, own: &Instruction) {
        let name = own.name.as_str();
        let at = |index: usize| own.operands[index];
        if let Some(compared) = name.strip_prefix("v_cmp") {
            // `v_cmpx` sets the mask of active lanes, and names no result.
            let (to, compared, first) = match compared.strip_prefix("x_") {
                Some(compared) => (EXEC, compared, 0),
                None => match at(0).source {
                    Source::Scalar(register) => (register, &compared[1..], 1),
                    other => panic!("{name}: {other:?}"),
                },
            };
            let mut found = 0;
            for lane in (0..LANES).filter(|lane| self.is_active(*lane)) {
                let (a, b) = (self.word(at(first), lane), self.word(at(first + 1), lane));
                found |= u64::from(compare(compared, a, b)) << lane;
            }
            self.set_wide(to, found);
            return;
        }
        match name {
            "v_readfirstlane_b32" => {
                let first = self.wide(EXEC).trailing_zeros() as usize % LANES;
                let Source::Scalar(to) = at(0).source else {
                    panic!("{name}")
                };
                self.scalars[to] = self.word(at(1), first);
                return;
            }
            "v_readlane_b32" => {
                let Source::Scalar(to) = at(0).source else {
                    panic!("{name}")
                };
                self.scalars[to] = self.word(at(1), self.scalar(at(2)) as usize % LANES);
                return;
            }
            "v_writelane_b32" => {
                let Source::Vector(to) = at(0).source else {
                    panic!("{name}")
                };
                let lane = self.scalar(at(2)) as usize % LANES;
                self.vectors[to][lane] = self.scalar(at(1));
                return;
            }
            _ => {}
        }
        let Source::Vector(to) = at(0).source else {
            panic!("{name}: {:?}", at(0))
        };
        for lane in (0..LANES).filter(|lane| self.is_active(*lane)).collect::<Vec<_>>() {
            match name {
                "v_swap_b32" => {
                    let Source::Vector(other) = at(1).source else {
                        panic!("{name}")
                    };
                    let (a, b) = (self.vectors[to][lane], self.vectors[other][lane]);
                    (self.vectors[to][lane], self.vectors[other][lane]) = (b, a);
                }
                "v_lshrrev_b64" => {
                    let wide = match at(2).source {
                        Source::Vector(register) => {
                            u64::from(self.vectors[register][lane]) | u64::from(self.vectors[register + 1][lane]) << 32
                        }
                        _ => self.scalar_wide(at(2)),
                    };
                    let shifted = wide >> (self.word(at(1), lane) & 63);
                    self.vectors[to][lane] = shifted as u32;
                    self.vectors[to + 1][lane] = (shifted >> 32) as u32;
                }
                "v_cndmask_b32" => {
                    let chosen = self.scalar_wide(at(3)) >> lane & 1 != 0;
                    self.vectors[to][lane] = self.word(at(if chosen { 2 } else { 1 }), lane);
                }
                _ => {
                    let mut sources = [0; 3];
                    for (index, (source, operand)) in sources.iter_mut().zip(&own.operands[1..]).enumerate() {
                        *source = self.word(*operand, lane);
                        match own.halves.get(index) {
                            Some(1) => *source &= 0xffff,
                            Some(2) => *source >>= 16,
                            _ => {}
                        }
                    }
                    if name == "v_fmac_f32" {
                        sources[2] = self.vectors[to][lane];
                    }
                    self.vectors[to][lane] = computed(own, sources);
                }
            }
        }
    }
}

/// The result of a comparison, named by its condition and type.
fn compare(name: &str, a: u32, b: u32) -> bool {
    let (condition, ty) = name.rsplit_once('_').unwrap();
    match ty {
        "f32" if condition == "class" => b >> class(a) & 1 != 0,
        // Of a constant that signals, to look at the lowest bit of the other.
        "f16" if condition == "class" && a == 0x7c01 => b & 1 != 0,
        "f32" => {
            let (a, b) = (f32::from_bits(a), f32::from_bits(b));
            match condition {
                "lt" => a < b,
                "le" => a <= b,
                "gt" => a > b,
                "ge" => a >= b,
                "eq" => a == b,
                "neq" => a != b,
                "lg" => a.partial_cmp(&b).is_some_and(std::cmp::Ordering::is_ne),
                "nlt" => !matches!(a.partial_cmp(&b), Some(std::cmp::Ordering::Less)),
                _ => panic!("{name} is not known"),
            }
        }
        _ => {
            let order = match ty {
                "u32" => a.cmp(&b),
                "i32" => a.cast_signed().cmp(&b.cast_signed()),
                _ => panic!("{name} is not known"),
            };
            match condition {
                "lt" => order.is_lt(),
                "le" => order.is_le(),
                "gt" => order.is_gt(),
                "ge" => order.is_ge(),
                "eq" => order.is_eq(),
                "ne" | "lg" => order.is_ne(),
                _ => panic!("{name} is not known"),
            }
        }
    }
}

/// The class of a float, by number, as `v_cmp_class` has them.
fn class(bits: u32) -> u32 {
    let float = f32::from_bits(bits);
    let (negative, positive) = match float.classify() {
        FpCategory::Nan => return u32::from(bits >> 22 & 1 != 0),
        FpCategory::Infinite => (2, 9),
        FpCategory::Normal => (3, 8),
        FpCategory::Subnormal => (4, 7),
        FpCategory::Zero => (5, 6),
    };
    if float.is_sign_negative() { negative } else { positive }
}

/// So many bits.
fn low_bits(count: u32) -> u32 {
    1_u32.checked_shl(count).map_or(u32::MAX, |next| next - 1)
}

/// The result of an operation on a lane's words.
#[expect(
    clippy::many_single_char_names,
    reason = "the operands' words, and the numbers that those are"
)]
fn computed(own: &Instruction, operands: [u32; 3]) -> u32 {
    let float = |result: f32| {
        let result = if own.scale == 1.0 { result } else { result * own.scale };
        let result = if own.clamp { result.clamp(0.0, 1.0) } else { result };
        assert!(!result.is_nan(), "{own:?}: {operands:#x?}");
        result.to_bits()
    };
    let [a, b, c] = operands;
    let [x, y, z] = operands.map(f32::from_bits);
    // Of zeros, the one of the negative sign is the lesser.
    let least = |x: f32, y: f32| if x.total_cmp(&y).is_lt() { x } else { y };
    let greatest = |x: f32, y: f32| if x.total_cmp(&y).is_lt() { y } else { x };
    let whole = |x: f32, low: f64, high: f64| f64::from(x).trunc().clamp(low, high);
    match own.name.as_str() {
        "v_mov_b32" => a,
        "v_add_f32" => float(x + y),
        "v_sub_f32" => float(x - y),
        "v_subrev_f32" => float(y - x),
        "v_mul_f32" => float(x * y),
        "v_fma_f32" | "v_fmac_f32" | "v_fmaak_f32" | "v_fmamk_f32" => float(x.mul_add(y, z)),
        "v_min_f32" => float(least(x, y)),
        "v_max_f32" => float(greatest(x, y)),
        "v_min3_f32" => float(least(least(x, y), z)),
        "v_max3_f32" => float(greatest(greatest(x, y), z)),
        "v_med3_f32" => float(greatest(least(x, y), least(greatest(x, y), z))),
        "v_floor_f32" => float(x.floor()),
        "v_trunc_f32" => float(x.trunc()),
        // Integer division corrects what it estimates by it.
        "v_rcp_f32" => float(1.0 / x),
        "v_cvt_f32_u32" => float(a as f32),
        "v_cvt_f32_i32" => float(a.cast_signed() as f32),
        "v_cvt_u32_f32" => whole(x, 0.0, f64::from(u32::MAX)) as u32,
        "v_cvt_i32_f32" => (whole(x, f64::from(i32::MIN), f64::from(i32::MAX)) as i32).cast_unsigned(),
        "v_add_nc_u32" => a.wrapping_add(b),
        "v_sub_nc_u32" => a.wrapping_sub(b),
        "v_subrev_nc_u32" => b.wrapping_sub(a),
        "v_add3_u32" => a.wrapping_add(b).wrapping_add(c),
        "v_mul_lo_u32" => a.wrapping_mul(b),
        "v_mul_hi_u32" => ((u64::from(a) * u64::from(b)) >> 32) as u32,
        "v_mul_u32_u24" => (a & 0xff_ffff).wrapping_mul(b & 0xff_ffff),
        "v_mad_u32_u24" => (a & 0xff_ffff).wrapping_mul(b & 0xff_ffff).wrapping_add(c),
        "v_min_u32" => a.min(b),
        "v_max_u32" => a.max(b),
        "v_min3_u32" => a.min(b).min(c),
        "v_max3_u32" => a.max(b).max(c),
        "v_and_b32" => a & b,
        "v_or_b32" => a | b,
        "v_xor_b32" => a ^ b,
        "v_not_b32" => !a,
        "v_or3_b32" => a | b | c,
        "v_and_or_b32" => a & b | c,
        "v_bfe_u32" => a >> (b & 31) & low_bits(c & 31),
        "v_bfi_b32" => a & b | !a & c,
        "v_bfrev_b32" => a.reverse_bits(),
        "v_lshlrev_b32" => b << (a & 31),
        "v_lshrrev_b32" => b >> (a & 31),
        "v_ashrrev_i32" => (b.cast_signed() >> (a & 31)).cast_unsigned(),
        "v_add_lshl_u32" => a.wrapping_add(b) << (c & 31),
        "v_lshl_add_u32" => (a << (b & 31)).wrapping_add(c),
        "v_lshl_or_b32" => a << (b & 31) | c,
        other => panic!("{other} is not known"),
    }
}
