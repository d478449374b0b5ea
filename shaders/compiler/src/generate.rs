//! Generates random kernels for tests, from all constructs that the compiler accepts. Their loops end, their floats stay
//! ordinary, and each invocation writes to different words, so that there is one right result.

use std::fmt::Write;

/// First part of every generated kernel.
pub const PRELUDE: &str = include_str!("generate.wgsl");

/// Invocations per workgroup.
pub const WORKGROUP: u32 = 64;
/// Words of `results` per invocation.
const RESULTS: u32 = 16;
/// Words of `shared_words` per workgroup.
const SHARED: u32 = 16;
/// Words per `Note`.
const NOTE: u32 = 3;

/// Fills the buffers of a dispatch of a generated kernel, by binding number.
pub fn buffers(seed: u64, workgroups: u32) -> Vec<Vec<u32>> {
    let mut random = Random(seed ^ 0x6275_6666_6572_7321);
    let mut float = |steps: u32, step: f32| (random.below(2 * steps + 1) as f32 - steps as f32) * step;
    let mut settings = vec![0; 4];
    settings.extend((0..4).map(|_| float(512, 0.015_625).to_bits()));
    let floats = (0..97).map(|_| float(100_000, 0.001_3).to_bits()).collect();
    let quads = (0..4 * 23).map(|_| float(4096, 0.031_25).to_bits()).collect();
    let items: Vec<_> = (0..19)
        .flat_map(|k| [float(999, 0.1), float(999, 0.01), float(30_000, 0.003), k as f32])
        .enumerate()
        .map(|(at, x)| if at % 4 == 3 { x as u32 } else { x.to_bits() })
        .collect();
    settings[..4].fill_with(|| random.below(1 << 16));
    let words = (0..101).map(|_| random.next() as u32).collect();
    let zeros = |count: u32| vec![0; (count * workgroups) as usize];
    vec![
        settings,
        floats,
        words,
        quads,
        items,
        zeros(WORKGROUP * RESULTS),
        zeros(WORKGROUP * NOTE),
        zeros(SHARED),
    ]
}

/// Writes a kernel with at most the given number of statements, where those of a function count at each call. The text
/// belongs after [`PRELUDE`].
pub fn kernel(seed: u64, statements: u32) -> String {
    let mut generator = Generator {
        most: statements,
        random: Random(seed),
        text: String::new(),
        depth: 0,
        named: 0,
        scope: Vec::new(),
        functions: Vec::new(),
        shared: 0,
        weight: 0,
        around: Around::default(),
    };
    let functions = generator.random.below(4);
    for _ in 0..functions {
        generator.function();
    }
    generator.entry();
    generator.text
}

/// The generator `SplitMix64`.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    fn below(&mut self, bound: u32) -> u32 {
        (((self.next() >> 32) * u64::from(bound)) >> 32) as u32
    }

    /// True once in `times` on average.
    fn once_in(&mut self, times: u32) -> bool {
        self.below(times) == 0
    }

    fn pick<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[self.below(all.len() as u32) as usize]
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ty {
    F32,
    I32,
    U32,
    Bool,
    Vec2,
    Vec3u,
    Local,
    Array,
}

impl Ty {
    fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::I32 => "i32",
            Self::U32 => "u32",
            Self::Bool => "bool",
            Self::Vec2 => "vec2<f32>",
            Self::Vec3u => "vec3<u32>",
            Self::Local => "Local",
            Self::Array => "array<f32, 5>",
        }
    }
}

/// Types of variables, arguments and results.
const VALUES: [Ty; 7] = [Ty::F32, Ty::F32, Ty::U32, Ty::I32, Ty::Bool, Ty::Vec2, Ty::Vec3u];

/// A variable or constant.
#[derive(Clone, Debug)]
struct Named {
    /// Expression that reads it, or to which values are assigned.
    text: String,
    ty: Ty,
    assignable: bool,
    /// Expression for a pointer to it, if there can be one.
    pointer: Option<String>,
    /// Whether it should be the same in all invocations.
    uniform: bool,
}

struct Function {
    name: String,
    /// Types, and whether they are passed by pointer.
    parameters: Vec<(Ty, bool)>,
    result: Option<Ty>,
    weight: u32,
}

/// Ways in which a function may return early.
#[derive(Clone, Copy, Debug, Default)]
enum Returns {
    #[default]
    Never,
    WithoutValue,
    Of(Ty),
}

/// Jumps that are allowed here, and the depth of nesting.
#[derive(Clone, Copy, Debug, Default)]
struct Around {
    loops: u32,
    blocks: u32,
    can_break: bool,
    can_continue: bool,
    returns: Returns,
    /// Outside of functions and loops, where each statement runs at most once.
    once: bool,
}

struct Generator {
    random: Random,
    text: String,
    depth: usize,
    named: u32,
    scope: Vec<Named>,
    functions: Vec<Function>,
    shared: u32,
    most: u32,
    /// Number of statements so far.
    weight: u32,
    around: Around,
}

impl Generator {
    fn line(&mut self, text: &str) {
        let _ = writeln!(self.text, "{:indent$}{text}", "", indent = 4 * self.depth);
    }

    fn name(&mut self, stem: &str) -> String {
        self.named += 1;
        format!("{stem}_{}", self.named)
    }

    fn add(&mut self, text: &str, ty: Ty, assignable: bool, uniform: bool) {
        self.scope.push(Named {
            text: text.to_owned(),
            ty,
            assignable,
            pointer: None,
            uniform,
        });
    }

    fn variable(&mut self, name: &str, ty: Ty) {
        self.add(name, ty, true, false);
        if let Some(last) = self.scope.last_mut() {
            last.pointer = Some(format!("&{name}"));
        }
    }

    /// Picks one of the names that fulfil a condition.
    fn one(&mut self, take: impl Fn(&Named) -> bool) -> Option<Named> {
        let fitting: Vec<_> = self.scope.iter().filter(|named| take(named)).collect();
        if fitting.is_empty() {
            return None;
        }
        Some((*self.random.pick(&fitting)).clone())
    }

    // Expressions.

    fn expression(&mut self, ty: Ty, depth: u32) -> String {
        if depth == 0 || self.random.once_in(6) {
            return self.leaf(ty);
        }
        if self.random.once_in(10)
            && let Some(call) = self.call(Some(ty))
        {
            return call;
        }
        if self.random.once_in(8) && !matches!(ty, Ty::Local | Ty::Array) {
            let (a, b) = (self.expression(ty, depth - 1), self.expression(ty, depth - 1));
            let condition = self.expression(Ty::Bool, depth - 1);
            return format!("select({a}, {b}, {condition})");
        }
        match ty {
            Ty::F32 => self.float(depth - 1),
            Ty::U32 => self.unsigned(depth - 1),
            Ty::I32 => self.signed(depth - 1),
            Ty::Bool => self.truth(depth - 1),
            Ty::Vec2 => self.vector(depth - 1),
            Ty::Vec3u => self.words(depth - 1),
            Ty::Local => {
                let (f, u, v) = (
                    self.tamed(depth - 1),
                    self.expression(Ty::U32, depth - 1),
                    self.expression(Ty::Vec2, depth - 1),
                );
                format!("Local({f}, {u}, tame2({v}))")
            }
            Ty::Array => self.leaf(ty),
        }
    }

    fn leaf(&mut self, ty: Ty) -> String {
        if !self.random.once_in(4)
            && let Some(named) = self.one(|named| named.ty == ty && ty != Ty::Array)
        {
            return named.text;
        }
        let member = |named: Option<Named>, fields: &[&str], random: &mut Random| {
            named.map(|named| format!("{}.{}", named.text, random.pick(fields)))
        };
        match ty {
            Ty::F32 => {
                let found = match self.random.below(6) {
                    0 => {
                        let vector = self.one(|named| named.ty == Ty::Vec2);
                        member(vector, &["x", "y"], &mut self.random)
                    }
                    1 => {
                        let local = self.one(|named| named.ty == Ty::Local);
                        member(local, &["f", "v.x", "v.y"], &mut self.random)
                    }
                    2 => self.element(),
                    3 => Some((*self.random.pick(&["settings.x", "settings.y", "settings.w", "total"])).to_owned()),
                    _ => None,
                };
                found.unwrap_or_else(|| {
                    let all = [
                        "0.0f",
                        "1.0f",
                        "-1.0f",
                        "2.0f",
                        "0.5f",
                        "-0.3f",
                        "3.1415927f",
                        "100.25f",
                        "0.1f",
                        "1e-3f",
                    ];
                    (*self.random.pick(&all)).to_owned()
                })
            }
            Ty::U32 => {
                let found = match self.random.below(5) {
                    0 => {
                        let local = self.one(|named| named.ty == Ty::Local);
                        member(local, &["u"], &mut self.random)
                    }
                    1 => {
                        let vector = self.one(|named| named.ty == Ty::Vec3u);
                        member(vector, &["x", "y", "z"], &mut self.random)
                    }
                    2 => Some((*self.random.pick(&["settings.a", "settings.b", "settings.d", "count"])).to_owned()),
                    _ => None,
                };
                found.unwrap_or_else(|| {
                    let all = [
                        "0u",
                        "1u",
                        "2u",
                        "3u",
                        "7u",
                        "31u",
                        "1000u",
                        "0x9e3779b9u",
                        "0xffffffffu",
                    ];
                    (*self.random.pick(&all)).to_owned()
                })
            }
            Ty::I32 => {
                let all = ["0i", "1i", "-1i", "2i", "-7i", "1000i", "2147483647i", "-123456i"];
                (*self.random.pick(&all)).to_owned()
            }
            Ty::Bool => {
                let (a, b) = (self.leaf(Ty::U32), self.leaf(Ty::U32));
                format!("({a} < {b})")
            }
            Ty::Vec2 => format!("vec2<f32>({}, {})", self.leaf(Ty::F32), self.leaf(Ty::F32)),
            Ty::Vec3u => format!(
                "vec3<u32>({}, {}, {})",
                self.leaf(Ty::U32),
                self.leaf(Ty::U32),
                self.leaf(Ty::U32)
            ),
            Ty::Local => format!(
                "Local({}, {}, vec2<f32>({}, 0.5f))",
                self.tamed(0),
                self.leaf(Ty::U32),
                self.tamed(0)
            ),
            Ty::Array => "array<f32, 5>(1.0f, -2.5f, 0.25f, 0.0f, 8.0f)".into(),
        }
    }

    /// Writes an element of a local array.
    fn element(&mut self) -> Option<String> {
        let array = self.one(|named| named.ty == Ty::Array)?;
        Some(format!("{}[{}]", array.text, self.uniform_index()))
    }

    /// Writes an index that is likely to be the same in all invocations. It may be too large.
    fn uniform_index(&mut self) -> String {
        let named = self.one(|named| named.uniform && named.ty == Ty::U32);
        match (self.random.below(4), named) {
            (0, _) => format!("{}u", self.random.below(5)),
            (1, Some(named)) => named.text,
            (2, Some(named)) => format!("({} + {}u) & 7u", named.text, self.random.below(9)),
            _ => format!("(settings.c >> {}u) & 3u", self.random.below(12)),
        }
    }

    fn uniform(&mut self, depth: u32) -> String {
        if depth == 0 {
            if let (false, Some(named)) = (
                self.random.once_in(3),
                self.one(|named| named.uniform && named.ty == Ty::U32),
            ) {
                return named.text;
            }
            let all = [
                "settings.a",
                "settings.b",
                "settings.c",
                "settings.d",
                "3u",
                "1u",
                "12u",
            ];
            return (*self.random.pick(&all)).to_owned();
        }
        let (a, b) = (self.uniform(depth - 1), self.uniform(depth - 1));
        match self.random.below(5) {
            0 => format!("({a} + {b})"),
            1 => format!("({a} * {b})"),
            2 => format!("({a} >> ({b} & 31u))"),
            3 => format!("words[{a} % 50u]"),
            _ => format!("whole(floats[({a} ^ {b}) & 127u])"),
        }
    }

    /// Writes a float that may be multiplied.
    fn tamed(&mut self, depth: u32) -> String {
        format!("tame({})", self.expression(Ty::F32, depth))
    }

    fn float(&mut self, depth: u32) -> String {
        let a = self.expression(Ty::F32, depth);
        match self.random.below(20) {
            0 | 1 => format!("({a} + {})", self.expression(Ty::F32, depth)),
            2 | 3 => format!("({a} - {})", self.expression(Ty::F32, depth)),
            4..=6 => format!("(tame({a}) * {})", self.tamed(depth)),
            7 => format!(
                "(tame({a}) * {} + {})",
                self.tamed(depth),
                self.expression(Ty::F32, depth)
            ),
            8 => format!("(-({a}))"),
            9 => format!("abs({a})"),
            10 => format!("floor({a})"),
            11 => format!("trunc({a})"),
            12 => format!("min({a}, {})", self.expression(Ty::F32, depth)),
            13 => format!("max({a}, {})", self.expression(Ty::F32, depth)),
            14 => format!("clamp({a}, -2.5f, 40.0f)"),
            15 => format!("f32({} & 0xffffu)", self.expression(Ty::U32, depth)),
            16 => format!("f32(clamp({}, -70000i, 70000i))", self.expression(Ty::I32, depth)),
            17 => format!("f32({})", self.expression(Ty::Bool, depth)),
            18 => {
                let u = self.expression(Ty::U32, depth);
                format!("bitcast<f32>(({u} & 0x007fffffu) | 0x3f800000u)")
            }
            _ => {
                let index = self.expression(Ty::U32, depth);
                let (buffer, rest) = *self.random.pick(&[
                    ("floats", ""),
                    ("quads", ".x"),
                    ("quads", ".w"),
                    ("items", ".weight"),
                    ("items", ".at.y"),
                ]);
                format!("{buffer}[{}]{rest}", self.index(&index))
            }
        }
    }

    /// Writes an index that is less than a buffer's length, or a little greater, so that it is clamped.
    fn index(&mut self, index: &str) -> String {
        match self.random.below(3) {
            0 => format!("({index}) & 127u"),
            1 => format!("({index}) % 19u"),
            // Not a constant, since naga refuses those that are too large.
            _ => format!("({index}) + settings.c"),
        }
    }

    fn unsigned(&mut self, depth: u32) -> String {
        let a = self.expression(Ty::U32, depth);
        match self.random.below(20) {
            0 | 1 => format!("({a} + {})", self.expression(Ty::U32, depth)),
            2 => format!("({a} - {})", self.expression(Ty::U32, depth)),
            3 => format!("({a} * {})", self.expression(Ty::U32, depth)),
            4 => format!("({a} & {})", self.expression(Ty::U32, depth)),
            5 => format!("({a} | {})", self.expression(Ty::U32, depth)),
            6 => format!("({a} ^ {})", self.expression(Ty::U32, depth)),
            // Never of constants: naga refuses those that overflow, and the rules refuse floats made of quotients.
            7 => format!("(({a} ^ settings.b) << ({} & 31u))", self.expression(Ty::U32, depth)),
            8 => format!("({a} >> ({} & 31u))", self.expression(Ty::U32, depth)),
            9 => format!("({a} >> {}u)", self.random.below(32)),
            10 => format!("(~{a})"),
            11 => format!("min({a}, {})", self.expression(Ty::U32, depth)),
            12 => format!("max({a}, {})", self.expression(Ty::U32, depth)),
            13 => format!("(({a} ^ settings.b) / ({} | 1u))", self.expression(Ty::U32, depth)),
            14 => format!("(({a} ^ settings.b) % {}u)", 1 + self.random.below(40)),
            15 => format!("whole({})", self.expression(Ty::F32, depth)),
            16 => format!("bits({})", self.expression(Ty::F32, depth)),
            17 => {
                let (from, ty) = *self
                    .random
                    .pick(&[("u32", Ty::I32), ("u32", Ty::Bool), ("bitcast<u32>", Ty::I32)]);
                format!("{from}({})", self.expression(ty, depth))
            }
            18 => format!("results[base + ({a} & 15u)]"),
            _ => {
                let (buffer, rest) = *self.random.pick(&[("words", ""), ("items", ".kind")]);
                format!("{buffer}[{}]{rest}", self.index(&a))
            }
        }
    }

    fn signed(&mut self, depth: u32) -> String {
        let a = self.expression(Ty::I32, depth);
        match self.random.below(13) {
            0 => format!("({a} + {})", self.expression(Ty::I32, depth)),
            1 => format!("({a} - {})", self.expression(Ty::I32, depth)),
            2 => format!("({a} * {})", self.expression(Ty::I32, depth)),
            3 => format!("({a} ^ {})", self.expression(Ty::I32, depth)),
            4 => format!("(-({a}))"),
            5 => format!("abs({a})"),
            6 => format!("min({a}, {})", self.expression(Ty::I32, depth)),
            7 => format!("max({a}, {})", self.expression(Ty::I32, depth)),
            8 => format!("({a} >> ({} & 31u))", self.expression(Ty::U32, depth)),
            9 => format!("(({a} ^ i32(settings.b)) << {}u)", self.random.below(32)),
            10 => format!("whole_signed({})", self.expression(Ty::F32, depth)),
            11 => format!("i32({})", self.expression(Ty::U32, depth)),
            _ => format!("clamp({a}, -100i, 5000i)"),
        }
    }

    fn truth(&mut self, depth: u32) -> String {
        let ty = *self.random.pick(&[Ty::F32, Ty::U32, Ty::I32]);
        match self.random.below(10) {
            0..=3 => {
                let (a, b) = (self.expression(ty, depth), self.expression(ty, depth));
                let op = self.random.pick(&["<", "<=", ">", ">=", "==", "!="]);
                format!("({a} {op} {b})")
            }
            4..=7 => {
                let (a, b) = (self.expression(Ty::Bool, depth), self.expression(Ty::Bool, depth));
                let op = self.random.pick(&["&&", "||", "&", "|", "==", "!="]);
                format!("({a} {op} {b})")
            }
            8 => format!("!({})", self.expression(Ty::Bool, depth)),
            _ => format!("bool({} & 1u)", self.expression(Ty::U32, depth)),
        }
    }

    fn vector(&mut self, depth: u32) -> String {
        let a = self.expression(Ty::Vec2, depth);
        match self.random.below(11) {
            0 => format!("({a} + {})", self.expression(Ty::Vec2, depth)),
            1 => format!("({a} - {})", self.expression(Ty::Vec2, depth)),
            2 => format!("(tame2({a}) * tame2({}))", self.expression(Ty::Vec2, depth)),
            3 => format!("(tame2({a}) * {})", self.tamed(depth)),
            4 => format!("(-({a}))"),
            5 => format!("({a}).yx"),
            6 => format!("abs({a})"),
            7 => {
                let b = self.expression(Ty::Vec2, depth);
                format!("select({a}, {b}, {a} < {b})")
            }
            8 => {
                let index = self.expression(Ty::U32, depth);
                let (buffer, rest) = *self
                    .random
                    .pick(&[("quads", ".xz"), ("quads", ".wy"), ("items", ".at")]);
                format!("{buffer}[{}]{rest}", self.index(&index))
            }
            9 => format!("max({a}, {})", self.expression(Ty::Vec2, depth)),
            _ => format!(
                "vec2<f32>({}, {})",
                self.expression(Ty::F32, depth),
                self.expression(Ty::F32, depth)
            ),
        }
    }

    fn words(&mut self, depth: u32) -> String {
        let a = self.expression(Ty::Vec3u, depth);
        match self.random.below(5) {
            0 => format!("({a} + {})", self.expression(Ty::Vec3u, depth)),
            1 => format!("({a} * {})", self.expression(Ty::Vec3u, depth)),
            2 => format!("({a} ^ {})", self.expression(Ty::Vec3u, depth)),
            3 => format!("({a}).zxy"),
            _ => format!("vec3<u32>({})", self.expression(Ty::U32, depth)),
        }
    }

    /// Writes a call of a function with this type of result.
    fn call(&mut self, result: Option<Ty>) -> Option<String> {
        let fitting: Vec<_> = (0..self.functions.len())
            .filter(|at| self.functions[*at].result == result && self.weight + self.functions[*at].weight < self.most)
            .collect();
        if fitting.is_empty() {
            return None;
        }
        let at = *self.random.pick(&fitting);
        let parameters = self.functions[at].parameters.clone();
        let mut arguments = vec!["base".to_owned()];
        let mut pointed: Vec<String> = Vec::new();
        for (ty, by_pointer) in parameters {
            if by_pointer {
                let named = self.one(|named| {
                    named.ty == ty && named.pointer.as_ref().is_some_and(|pointer| !pointed.contains(pointer))
                })?;
                let pointer = named.pointer?;
                arguments.push(pointer.clone());
                pointed.push(pointer);
            } else {
                arguments.push(self.expression(ty, 1));
            }
        }
        self.weight += self.functions[at].weight;
        Some(format!("{}({})", self.functions[at].name, arguments.join(", ")))
    }

    /// Writes a value for a variable. Floats are tamed, so that they stay ordinary from one loop to the next.
    fn kept(&mut self, ty: Ty, depth: u32) -> String {
        let value = self.expression(ty, depth);
        match ty {
            Ty::F32 => format!("tame({value})"),
            Ty::Vec2 => format!("tame2({value})"),
            _ => value,
        }
    }

    fn condition(&mut self) -> String {
        if self.random.once_in(4) {
            return format!("({} & 3u) < 2u", self.uniform(1));
        }
        self.expression(Ty::Bool, 2)
    }

    // Statements.

    fn block(&mut self, around: Around) {
        let (outer, names) = (self.around, self.scope.len());
        self.around = Around {
            blocks: outer.blocks + 1,
            ..around
        };
        self.depth += 1;
        let statements = 1 + self.random.below(4);
        for _ in 0..statements {
            self.statement();
        }
        if self.random.once_in(7) {
            self.jump();
        }
        self.depth -= 1;
        self.scope.truncate(names);
        self.around = outer;
    }

    /// Writes a jump as the last statement of a block.
    fn jump(&mut self) {
        match self.random.below(3) {
            0 if self.around.can_break => self.line("break;"),
            1 if self.around.can_continue => self.line("continue;"),
            _ => match self.around.returns {
                Returns::Of(ty) => {
                    let value = self.kept(ty, 1);
                    self.line(&format!("return {value};"));
                }
                // Seldom, since an invocation that returns tests nothing more.
                Returns::WithoutValue if !self.random.once_in(3) => self.line("return;"),
                _ => {}
            },
        }
    }

    fn statement(&mut self) {
        if self.weight >= self.most {
            return;
        }
        self.weight += 1;
        let nested = self.around.blocks < 5;
        match self.random.below(30) {
            0..=2 => self.declare_let(),
            3..=6 => self.declare_variable(),
            14..=18 if nested => self.branch(),
            19..=22 if nested && self.around.loops < 3 => self.repeat(),
            23 if nested => self.switch(),
            24 | 25 => self.store(),
            26 => self.guarded_jump(),
            27 => {
                if let Some(call) = self.call(None) {
                    self.line(&format!("{call};"));
                }
            }
            28 => self.share(),
            _ => self.assign(),
        }
    }

    fn declare_let(&mut self) {
        let uniform = self.random.once_in(3);
        let ty = if uniform { Ty::U32 } else { *self.random.pick(&VALUES) };
        let value = if uniform { self.uniform(2) } else { self.kept(ty, 3) };
        let name = self.name("v");
        self.line(&format!("let {name} = {value};"));
        self.add(&name, ty, false, uniform);
    }

    fn declare_variable(&mut self) {
        let mut ty = *self.random.pick(&VALUES);
        if self.random.once_in(4) {
            ty = *self.random.pick(&[Ty::Local, Ty::Array]);
        }
        let name = self.name("m");
        if self.random.once_in(4) {
            self.line(&format!("var {name}: {};", ty.name()));
        } else {
            let value = self.kept(ty, 2);
            self.line(&format!("var {name} = {value};"));
        }
        self.variable(&name, ty);
    }

    fn assign(&mut self) {
        let Some(named) = self.one(|named| named.assignable) else {
            return self.declare_variable();
        };
        let target = named.text;
        match named.ty {
            Ty::Vec2 if self.random.once_in(2) => {
                let (component, value) = (*self.random.pick(&["x", "y"]), self.tamed(2));
                self.line(&format!("{target}.{component} = {value};"));
            }
            Ty::Local if !self.random.once_in(4) => {
                let (member, ty) =
                    *self
                        .random
                        .pick(&[("f", Ty::F32), ("u", Ty::U32), ("v", Ty::Vec2), ("v.y", Ty::F32)]);
                let value = self.kept(ty, 2);
                self.line(&format!("{target}.{member} = {value};"));
            }
            Ty::Array => {
                let (index, value) = (self.uniform_index(), self.tamed(2));
                self.line(&format!("{target}[{index}] = {value};"));
            }
            Ty::U32 | Ty::I32 if self.random.once_in(3) => {
                let (op, value) = (
                    *self.random.pick(&["+", "-", "*", "^", "|"]),
                    self.expression(named.ty, 2),
                );
                self.line(&format!("{target} {op}= {value};"));
            }
            ty => {
                let value = self.kept(ty, 3);
                self.line(&format!("{target} = {value};"));
            }
        }
    }

    fn branch(&mut self) {
        let condition = self.condition();
        self.line(&format!("if ({condition}) {{"));
        self.block(self.around);
        if self.random.once_in(4) {
            let condition = self.condition();
            self.line(&format!("}} else if ({condition}) {{"));
            self.block(self.around);
        }
        if self.random.once_in(2) {
            self.line("} else {");
            self.block(self.around);
        }
        self.line("}");
    }

    fn guarded_jump(&mut self) {
        let condition = self.condition();
        self.line(&format!("if ({condition}) {{"));
        self.depth += 1;
        self.jump();
        self.depth -= 1;
        self.line("}");
    }

    fn repeat(&mut self) {
        let uniform = self.random.once_in(3);
        let turns = if uniform {
            self.uniform(1)
        } else {
            self.expression(Ty::U32, 2)
        };
        let turns = format!("(({turns}) & 3u) + {}u", self.random.below(2));
        let counter = self.name("i");
        let names = self.scope.len();
        let inside = Around {
            loops: self.around.loops + 1,
            can_break: true,
            can_continue: true,
            once: false,
            ..self.around
        };
        match (self.random.below(9), self.around.returns) {
            (0, returns @ (Returns::WithoutValue | Returns::Of(_))) => {
                // This loop ends only by a return.
                let condition = self.condition();
                self.line(&format!("if ({condition}) {{"));
                self.line(&format!("var {counter} = 0u;"));
                self.line("loop {");
                self.line(&format!("    {counter} += 1u;"));
                let value = match returns {
                    Returns::Of(ty) => self.kept(ty, 1),
                    _ => String::new(),
                };
                self.line(&format!("    if ({counter} > {turns}) {{ return {value}; }}"));
                self.add(&counter, Ty::U32, false, uniform);
                self.block(Around {
                    can_break: false,
                    ..inside
                });
                self.line("}");
            }
            (0..=4, _) => {
                self.line(&format!(
                    "for (var {counter} = 0u; {counter} < {turns}; {counter}++) {{"
                ));
                self.add(&counter, Ty::U32, false, uniform);
                self.block(inside);
            }
            (5 | 6, _) => {
                let condition = self.condition();
                self.line(&format!("var {counter} = 0u;"));
                self.line(&format!("while ({counter} < {turns} && ({condition})) {{"));
                self.line(&format!("    {counter} += 1u;"));
                self.add(&counter, Ty::U32, false, uniform);
                self.block(inside);
            }
            _ => {
                self.line(&format!("var {counter} = 0u;"));
                self.line("loop {");
                self.depth += 1;
                self.line(&format!("if ({counter} >= {turns}) {{ break; }}"));
                self.add(&counter, Ty::U32, false, uniform);
                // Computed in the body, used in `continuing`.
                let early = self.name("v");
                let value = self.tamed(2);
                self.line(&format!("let {early} = {value};"));
                self.add(&early, Ty::F32, false, false);
                self.depth -= 1;
                self.block(inside);
                self.depth += 1;
                self.line("continuing {");
                self.depth += 1;
                self.line(&format!("{counter} += 1u;"));
                if let Some(kept) = self.one(|named| named.assignable && named.ty == Ty::F32) {
                    self.line(&format!("{0} = tame({0} + {early});", kept.text));
                }
                if self.random.once_in(2) {
                    self.line(&format!("break if {early} > 30.0f;"));
                }
                self.depth -= 1;
                self.line("}");
                self.depth -= 1;
            }
        }
        self.line("}");
        self.scope.truncate(names);
    }

    fn switch(&mut self) {
        let uniform = self.random.once_in(4);
        let (selector, suffix) = match (uniform, self.random.once_in(3)) {
            (true, _) => (self.uniform(1), "u"),
            (_, true) => (self.expression(Ty::I32, 2), "i"),
            _ => (self.expression(Ty::U32, 2), "u"),
        };
        self.line(&format!("switch (({selector}) & 3{suffix}) {{"));
        self.depth += 1;
        let inside = Around {
            can_break: true,
            ..self.around
        };
        let mut cases = vec![format!("case 0{suffix}"), format!("case 1{suffix}, 2{suffix}")];
        if self.random.once_in(2) {
            cases.push(format!("case 3{suffix}, default"));
        } else {
            cases.insert(self.random.below(3) as usize, "default".to_owned());
        }
        for case in cases {
            self.line(&format!("{case}: {{"));
            self.block(inside);
            self.line("}");
        }
        self.depth -= 1;
        self.line("}");
    }

    fn store(&mut self) {
        match self.random.below(5) {
            0 => {
                let value = self.expression(Ty::F32, 2);
                self.line(&format!("notes[base / 16u].second = stored({value});"));
            }
            1 => {
                let (u, f, i) = (
                    self.expression(Ty::U32, 1),
                    self.expression(Ty::F32, 1),
                    self.expression(Ty::I32, 1),
                );
                self.line(&format!("notes[base / 16u] = Note({u}, stored({f}), {i});"));
            }
            2 => {
                let value = self.expression(Ty::U32, 2);
                self.line(&format!("results[base + {}u] = {value};", self.random.0 % 16));
            }
            _ => {
                let (index, value) = (self.expression(Ty::U32, 1), self.expression(Ty::F32, 2));
                self.line(&format!("results[base + (({index}) & 15u)] = bits({value});"));
            }
        }
    }

    /// Writes a store of a uniform value at a uniform address. Each address is stored to once, since otherwise the order of
    /// invocations would matter.
    fn share(&mut self) {
        if !self.around.once || self.shared == SHARED {
            return self.assign();
        }
        let address = format!("shared_words[workgroup.x * {SHARED}u + {}u]", self.shared);
        self.shared += 1;
        let value = self.uniform(2);
        self.line(&format!("{address} = {value};"));
    }

    fn function(&mut self) {
        let name = self.name("f");
        let mut parameters = Vec::new();
        let mut list = vec!["base: u32".to_owned()];
        self.globals();
        for _ in 0..self.random.below(4) {
            let by_pointer = self.random.once_in(2);
            let all = [Ty::F32, Ty::U32, Ty::Vec2, Ty::Local, Ty::Array, Ty::Bool];
            let mut ty = *self.random.pick(&all);
            if ty == Ty::Array && !by_pointer {
                ty = Ty::I32;
            }
            let parameter = self.name("p");
            if by_pointer {
                list.push(format!("{parameter}: ptr<function, {}>", ty.name()));
                self.add(&format!("(*{parameter})"), ty, true, false);
                if let Some(last) = self.scope.last_mut() {
                    last.pointer = Some(parameter);
                }
            } else {
                list.push(format!("{parameter}: {}", ty.name()));
                self.add(&parameter, ty, false, false);
            }
            parameters.push((ty, by_pointer));
        }
        let result = if self.random.once_in(4) {
            None
        } else {
            Some(
                *self
                    .random
                    .pick(&[Ty::F32, Ty::F32, Ty::U32, Ty::Vec2, Ty::Bool, Ty::Local]),
            )
        };
        let returned = result.map_or(String::new(), |ty| format!(" -> {}", ty.name()));
        self.line(&format!("fn {name}({}){returned} {{", list.join(", ")));
        let before = std::mem::take(&mut self.weight);
        self.around = Around {
            returns: result.map_or(Returns::WithoutValue, Returns::Of),
            blocks: 1,
            loops: 1,
            ..Around::default()
        };
        self.depth = 1;
        for _ in 0..2 + self.random.below(4) {
            if self.weight < self.most / 8 {
                self.statement();
            }
        }
        if let Some(ty) = result {
            let value = self.kept(ty, 2);
            self.line(&format!("return {value};"));
        }
        self.depth = 0;
        self.line("}\n");
        self.scope.clear();
        self.functions.push(Function {
            name,
            parameters,
            result,
            weight: self.weight,
        });
        self.weight = before;
    }

    /// Declares variables that differ between invocations.
    fn starting_values(&mut self) {
        let all = [
            (Ty::F32, "floats[slot % 97u]"),
            (Ty::U32, "words[slot]"),
            (Ty::I32, "i32(words[slot + 7u]) >> 3u"),
            (Ty::Bool, "(words[slot ^ 21u] & 4u) != 0u"),
            (Ty::Vec2, "tame2(quads[slot % 23u].zy)"),
            (Ty::Local, "Local(tame(quads[lane].x), lane % 5u, items[lane % 19u].at)"),
            (Ty::Array, "array<f32, 5>(0.5f, 1.5f, -3.0f, 9.75f, -0.1f)"),
        ];
        for (ty, value) in all {
            if self.random.once_in(3) {
                continue;
            }
            let name = self.name("m");
            self.line(&format!("var {name} = {value};"));
            self.variable(&name, ty);
        }
    }

    fn globals(&mut self) {
        self.add("total", Ty::F32, true, false);
        self.add("count", Ty::U32, true, false);
    }

    fn entry(&mut self) {
        self.globals();
        self.line(&format!("@compute @workgroup_size({WORKGROUP})"));
        self.line("fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {");
        self.depth = 1;
        self.line(&format!("let slot = workgroup.x * {WORKGROUP}u + lane;"));
        self.line(&format!("let base = slot * {RESULTS}u;"));
        self.add("slot", Ty::U32, false, false);
        self.add("lane", Ty::U32, false, false);
        self.add("workgroup.x", Ty::U32, false, true);
        self.around = Around {
            returns: Returns::WithoutValue,
            once: true,
            ..Around::default()
        };
        self.starting_values();
        for _ in 0..6 + self.random.below(8) {
            self.statement();
        }
        let kept: Vec<_> = self.scope.iter().filter(|named| named.assignable).cloned().collect();
        for (at, named) in kept.iter().rev().take(RESULTS as usize).enumerate() {
            let text = &named.text;
            let value = match named.ty {
                Ty::F32 => format!("bits({text})"),
                Ty::U32 => text.clone(),
                Ty::I32 | Ty::Bool => format!("u32({text})"),
                Ty::Vec2 => format!("bits({text}.x) ^ bits({text}.y)"),
                Ty::Vec3u => format!("{text}.x ^ {text}.y ^ {text}.z"),
                Ty::Local => format!("bits({text}.f) ^ {text}.u ^ bits({text}.v.x) ^ bits({text}.v.y)"),
                Ty::Array => format!("bits({text}[0]) ^ bits({text}[1]) ^ bits({text}[2]) ^ bits({text}[4])"),
            };
            self.line(&format!("results[base + {at}u] ^= {value};"));
        }
        self.depth = 0;
        self.line("}");
    }
}
