//! Parts as a user might write them, drawn at random: what they compute stays within the range in which every device must agree.

use std::fmt::Write;

use oneiro::compose::Kind;
use oneiro::random::pcg4d;

/// Random choices, the same for a seed.
pub(crate) struct Draw {
    seed: u32,
    next: u32,
}

impl Draw {
    pub(crate) fn new(seed: u32) -> Self {
        Self { seed, next: 0 }
    }

    /// A number below another.
    pub(crate) fn below(&mut self, end: u32) -> u32 {
        self.next += 1;
        pcg4d([self.seed, self.next, 0x6f6e_6531, 0])[0] % end
    }

    /// Whether one of so many cases is drawn.
    pub(crate) fn one_in(&mut self, many: u32) -> bool {
        self.below(many) == 0
    }

    fn pick<'a>(&mut self, list: &[&'a str]) -> &'a str {
        list[self.below(list.len() as u32) as usize]
    }
}

/// Where a part is used.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Setting {
    /// A Khepera by its tables, or a robot by its numbers.
    Alone,
    Swarm,
    Forager,
}

/// Stands for a float that is often a zero with a sign.
const SIGNED: &str = "-0";

/// The types of a part's memory and how one is made of two floats and an unsigned number.
const FIELDS: [(&str, &str); 6] = [
    ("f32", "A"),
    ("f32", SIGNED),
    ("u32", "U"),
    ("i32", "bitcast<i32>(U)"),
    ("vec2<f32>", "vec2<f32>(A, B)"),
    ("vec3<f32>", "vec3<f32>(A, B, A - B)"),
];

/// The fixed text of parts: floats are kept between 0.001 and 100, so that no result is subnormal, infinite or
/// out of a function's range.
const PRELUDE: &str = "
fn PREFIX_ranged(x: f32) -> f32 {
    let y = clamp(x, -100.0f, 100.0f);
    return select(0.0f, y, abs(y) > 0.001f);
}
fn PREFIX_bump(x: ptr<function, f32>, by: f32) -> bool {
    *x = PREFIX_ranged(*x + by);
    return *x > by;
}
struct PREFIX_Pair {
    near: f32,
    far: vec2<f32>,
}
";

/// A part that is being written.
pub(crate) struct Writer {
    draw: Draw,
    kind: Kind,
    setting: Setting,
    /// Names of what it remembers, with their types' indices.
    memory: Vec<usize>,
    /// Floats that may be read here, and unsigned numbers.
    floats: Vec<String>,
    unsigned: Vec<String>,
    /// Whether there is a `episode` here, and a controller's `readings`.
    has_life: bool,
    has_readings: bool,
    helpers: u32,
    locals: u32,
    /// Branches and loops around this.
    around: u32,
    /// How deep statements and expressions are, 1 or 2.
    size: u32,
    /// Elements of an array that all of this passes through; 0 for none. Code has fewer lanes where it is large.
    filler: u32,
}

/// A part of a kind, `size` 1 or 2.
pub(crate) fn part(kind: Kind, setting: Setting, seed: u32, filler: u32, size: u32) -> String {
    let mut writer = Writer {
        draw: Draw::new(seed),
        kind,
        setting,
        memory: Vec::new(),
        floats: Vec::new(),
        unsigned: Vec::new(),
        has_life: false,
        has_readings: false,
        helpers: 0,
        locals: 0,
        around: 0,
        filler,
        size,
    };
    writer.write()
}

impl Writer {
    /// What the names of this part's functions begin with: with the kind's word, they would have to be those that Oneiro calls.
    fn word(&self) -> &'static str {
        match self.kind {
            Kind::Sensor => "of_sensor",
            Kind::Controller => "of_controller",
            Kind::Task => "of_task",
        }
    }

    fn number(&mut self) -> String {
        let list = [
            "0.0f", "1.0f", "-1.0f", "0.5f", "2.0f", "-0.25f", "7.5f", "0.001f", "31.0f", "0x1p-3f",
        ];
        self.draw.pick(&list).to_owned()
    }

    /// A call of this part's function that keeps a float in range.
    fn ranged(&self, of: &str) -> String {
        format!("{}_ranged({of})", self.word())
    }

    fn float(&mut self, depth: u32) -> String {
        if depth == 0 {
            return match self.draw.below(8) {
                0 => self.number(),
                1 if self.has_life => {
                    let stream = match self.kind {
                        Kind::Sensor => "STREAM_OWN_SENSOR",
                        Kind::Controller => "STREAM_CONTROLLER",
                        Kind::Task => "STREAM_TASK",
                    };
                    let (step, number) = (self.unsigned(0), self.draw.below(70_000));
                    format!(
                        "random(episode, {stream}, {step}, {number}u).{}",
                        self.draw.pick(&["x", "y", "z", "w"])
                    )
                }
                2 if self.has_life => self.asked(),
                _ if self.floats.is_empty() => self.number(),
                _ => self.floats[self.draw.below(self.floats.len() as u32) as usize].clone(),
            };
        }
        let (a, b) = (self.float(depth - 1), self.float(depth - 1));
        let (a, b) = (self.ranged(&a), self.ranged(&b));
        match self.draw.below(34) {
            0 => format!("({a} + {b})"),
            1 => format!("({a} - {b})"),
            2..5 => format!("({a} * {b})"),
            5 => format!("select({a}, {b}, {})", self.truth(depth - 1)),
            6 => format!("min({a}, {b})"),
            7 => format!("max({a}, -{b})"),
            8 => format!("clamp({a}, -abs({b}), abs({b}))"),
            9 => format!("floor({a})"),
            10 => format!("({a} - trunc({a}))"),
            11 => format!("reciprocal(1.0f + abs({a}))"),
            12 => format!("root(abs({a}))"),
            13 => format!("exponential(clamp({a}, -5.0f, 5.0f))"),
            14 => format!("logistic({a})"),
            15 => format!("logarithm(0.001f + abs({a}))"),
            16 => format!("hyperbolic_tangent({a})"),
            17 => format!("cosine_sine({a}).{}", self.draw.pick(&["x", "y"])),
            18 => format!("direction(vec2<f32>({a}, {b}))"),
            19 => format!("squared_length(vec2f({a}, {b}))"),
            20 => format!("f32({} & 1023u)", self.unsigned(depth - 1)),
            21 => format!("reciprocal_root(0.01f + abs({a}))"),
            24 => format!("({a} / (1.5 + abs({b})))"),
            25 => format!("({a} % (1.5 + abs({b})))"),
            26 => format!("sqrt(abs({a}))"),
            27 => format!("length(vec2({a}, {b}))"),
            28 => format!("sin(clamp({a}, -9.0, 9.0))"),
            29 => format!("atan2({a}, 0.1 + abs({b}))"),
            30 => format!("pow(0.5 + fract({a}), 1.5)"),
            31 => format!("mix({a}, {b}, 0.25)"),
            32 => format!("array<f32, 3>({a}, {b}, 1.0)[{} % 3u]", self.unsigned(depth - 1)),
            22 if self.helpers > 0 && self.has_life => {
                let helper = self.draw.below(self.helpers);
                format!("{}_helper_{helper}(episode, {a}, {b})", self.word())
            }
            _ => format!("{0}_Pair({a}, vec2<f32>({b}, 1.0f)).far.x", self.word()),
        }
    }

    /// What a part may ask of its world.
    fn asked(&mut self) -> String {
        let index = self.draw.below(12);
        let mut list = vec![
            format!("select(0.0f, 1.0f, blocked(episode, vec2<f32>(50.0f * f32({index}u), 100.0f)))"),
            format!("0.01f * distance_along(episode, vec2<f32>(200.0f, 150.0f), 0.1f * f32({index}u), 400.0f)"),
            "0.01f * body_radius(episode)".to_owned(),
            "f32(cycles(episode))".to_owned(),
            format!("arena_light(episode, {index}u).brightness"),
            "f32(arena_lights(episode))".to_owned(),
        ];
        if self.kind == Kind::Controller {
            let far = self
                .draw
                .pick(&["0u", "3u", "4294967295u", "INPUTS", "CONTROLLER_GENES"]);
            list.push(format!("gene(episode, {far} + {index}u)"));
            list.push(format!("gene(episode, {})", self.unsigned(0)));
            if self.has_readings {
                list.push(format!("0.1f * weighed(episode, {index}u, readings)"));
            }
        }
        if self.setting == Setting::Swarm {
            let robot = self.unsigned(0);
            list.push(format!(
                "0.01f * robot_pose(episode, {robot}).{}",
                self.draw.pick(&["x", "y", "z"])
            ));
            list.push("f32(robots(episode) + robot_number(episode))".to_owned());
            list.push(format!("floor_at(episode, vec2<f32>(40.0f * f32({index}u), 90.0f))"));
            if self.kind == Kind::Task {
                list.push(format!("f32(clusters_within(episode, 20.0f * f32({index}u)).largest)"));
            }
        }
        list.swap_remove(self.draw.below(list.len() as u32) as usize)
    }

    fn unsigned(&mut self, depth: u32) -> String {
        if depth == 0 {
            return match self.draw.below(4) {
                0 => format!(
                    "{}u",
                    self.draw
                        .pick(&["0", "1", "3", "255", "65536", "2147483648", "4294967295"])
                ),
                _ if self.unsigned.is_empty() => "5u".to_owned(),
                _ => self.unsigned[self.draw.below(self.unsigned.len() as u32) as usize].clone(),
            };
        }
        let (a, b) = (self.unsigned(depth - 1), self.unsigned(depth - 1));
        match self.draw.below(12) {
            0..3 => format!("({a} {} {b})", self.draw.pick(&["+", "-", "*", "^", "&", "|"])),
            3 => format!("({a} / ({b} | 1u))"),
            4 => format!("({a} % ({b} | 1u))"),
            5 => format!("({a} >> {}u)", self.draw.below(32)),
            6 => format!("({a} << ({b} & 31u))"),
            7 => format!("{}({a}, {b})", self.draw.pick(&["min", "max"])),
            8 => format!("select({a}, {b}, {})", self.truth(depth - 1)),
            9 => format!(
                "u32(bitcast<f32>(({a} & 0x3fffffffu) | 0x20000000u) > {})",
                self.number()
            ),
            10 => format!("u32(abs({}))", {
                let float = self.float(depth - 1);
                self.ranged(&float)
            }),
            _ => format!("bitcast<u32>(-bitcast<i32>({a}))"),
        }
    }

    fn truth(&mut self, depth: u32) -> String {
        let (a, b) = (self.float(depth.min(1)), self.float(0));
        match self.draw.below(6) {
            0 if depth > 0 => format!("({} && {})", self.truth(depth - 1), self.truth(0)),
            1 if depth > 0 => format!("({} || !{})", self.truth(depth - 1), self.truth(0)),
            2 => format!("(({} & 1u) == 0u)", self.unsigned(1)),
            _ => format!("({a} {} {b})", self.draw.pick(&["<", "<=", ">", ">=", "==", "!="])),
        }
    }

    /// Statements that change `x` and `n`, which are declared.
    fn statements(&mut self, depth: u32, text: &mut String) {
        self.around += 1;
        for _ in 0..=self.draw.below(3) {
            match self.draw.below(if depth == 0 { 4 } else { 11 }) {
                0..3 => {
                    let value = self.float(self.size);
                    let _ = writeln!(text, "x = {};", self.ranged(&value));
                }
                3 => {
                    let value = self.unsigned(self.size);
                    let _ = writeln!(text, "n {} {value};", self.draw.pick(&["=", "+=", "^="]));
                }
                4 => {
                    let _ = writeln!(text, "if {} {{", self.truth(1));
                    self.statements(depth - 1, text);
                    if self.draw.one_in(2) {
                        let _ = writeln!(text, "}} else {{");
                        self.statements(depth - 1, text);
                    }
                    let _ = writeln!(text, "}}");
                }
                5 | 6 => self.repeated(depth, text),
                7 => {
                    let subject = self.unsigned(1);
                    let _ = writeln!(text, "switch {subject} & 3u {{\ncase 0u, 2u {{");
                    self.statements(depth - 1, text);
                    let _ = writeln!(text, "}}\ncase 1u {{ x = -x; }}\ndefault {{");
                    self.statements(depth - 1, text);
                    let _ = writeln!(text, "}}\n}}");
                }
                8 => {
                    let by = self.float(1);
                    let _ = writeln!(text, "if {}_bump(&x, {}) {{ n += 1u; }}", self.word(), self.ranged(&by));
                }
                9 => {
                    let (local, value) = (self.locals, self.float(self.size));
                    self.locals += 1;
                    let _ = writeln!(text, "let v{local} = vec2<f32>(x, {});", self.ranged(&value));
                    let _ = writeln!(
                        text,
                        "x = {};",
                        self.ranged(&format!("v{local}.y * 0.5f + v{local}.yx.x"))
                    );
                }
                _ => {
                    let pair = self.locals;
                    self.locals += 1;
                    let _ = writeln!(text, "var p{pair} = {}_Pair(x, vec2<f32>(x, 2.0f));", self.word());
                    let value = self.float(1);
                    let _ = writeln!(text, "p{pair}.far.y = {};", self.ranged(&value));
                    let _ = writeln!(text, "x = {};", self.ranged(&format!("p{pair}.near - p{pair}.far.y")));
                }
            }
        }
        self.around -= 1;
    }

    /// A loop, over an array or not.
    fn repeated(&mut self, depth: u32, text: &mut String) {
        let local = self.locals;
        self.locals += 1;
        let most = 2 + self.draw.below(5);
        let end = match self.draw.below(3) {
            0 => format!("min({}, {most}u)", self.unsigned(1)),
            _ => format!("{most}u"),
        };
        // Where only some lives get to, counters aren't the same in all.
        if self.around == 1 && self.draw.one_in(2) {
            let _ = writeln!(text, "var a{local}: array<f32, {most}>;");
            let _ = writeln!(text, "for (var i{local} = 0u; i{local} < {most}u; i{local}++) {{");
            let value = self.float(1);
            let _ = writeln!(text, "a{local}[i{local}] = {};", self.ranged(&value));
            let _ = writeln!(text, "}}\nfor (var i{local} = 0u; i{local} < {most}u; i{local}++) {{");
            let _ = writeln!(
                text,
                "x = {};\n}}",
                self.ranged(&format!("0.5f * x + a{local}[i{local}]"))
            );
            return;
        }
        let _ = writeln!(text, "for (var i{local} = 0u; i{local} < {end}; i{local} += 1u) {{");
        self.unsigned.push(format!("i{local}"));
        self.statements(depth - 1, text);
        if self.draw.one_in(2) {
            let _ = writeln!(
                text,
                "if {} {{ {}; }}",
                self.truth(0),
                self.draw.pick(&["break", "continue"])
            );
            self.statements(0, text);
        }
        self.unsigned.pop();
        let _ = writeln!(text, "}}");
    }

    /// Begins a function in which these may be read.
    fn begin(&mut self, floats: &[&str], unsigned: &[&str], has_life: bool) {
        self.floats = floats.iter().map(|name| (*name).to_owned()).collect();
        self.unsigned = unsigned.iter().map(|name| (*name).to_owned()).collect();
        self.has_life = has_life;
        self.has_readings = false;
    }

    /// The body of the function that has begun: a float `x` and a number `n`.
    fn body(&mut self) -> String {
        let (start, count) = (self.float(1), self.unsigned(1));
        let mut text = format!("var x = {};\nvar n = {count};\n", self.ranged(&start));
        self.floats.push("x".to_owned());
        self.unsigned.push("n".to_owned());
        self.statements(self.size, &mut text);
        text + &self.filled()
    }

    /// Declares a memory, if it has fields, and adds what is in it to what may be read.
    fn state(&mut self, name: &str, text: &mut String) {
        self.memory = (0..self.draw.below(4))
            .map(|_| self.draw.below(FIELDS.len() as u32) as usize)
            .collect();
        if self.memory.is_empty() {
            return;
        }
        let _ = writeln!(text, "struct {name} {{");
        for (index, field) in self.memory.iter().enumerate() {
            // Those of a task and of its mission have different names.
            let _ = writeln!(text, "{}{index}: {},", name.to_lowercase(), FIELDS[*field].0);
        }
        let _ = writeln!(text, "}}");
    }

    /// Lets what is remembered be read, by the name of the memory.
    fn remember(&mut self, name: &str, before: &str) {
        for (index, field) in self.memory.iter().enumerate() {
            let own = format!("{before}.{}{index}", name.to_lowercase());
            match FIELDS[*field].0 {
                "f32" => self.floats.push(own),
                "u32" => self.unsigned.push(own),
                "i32" => self.unsigned.push(format!("bitcast<u32>({own})")),
                _ => self.floats.push(format!("{own}.y")),
            }
        }
    }

    /// The next memory, of `x` and `n`.
    fn next(&self, name: &str, before: &str) -> String {
        if self.memory.is_empty() {
            return before.to_owned();
        }
        let other = self.ranged("x + 0.125f");
        let of = |field: &usize| match FIELDS[*field].1 {
            SIGNED => "(x * select(0.0f, 1.0f, n == 7u))".to_owned(),
            form => form.replace('A', "x").replace('B', &other).replace('U', "n"),
        };
        let fields: Vec<_> = self.memory.iter().map(of).collect();
        format!("{name}({})", fields.join(", "))
    }

    /// Lets `x` pass through the array that is there for its size.
    fn filled(&mut self) -> String {
        // Otherwise each function has another array.
        match std::mem::take(&mut self.filler) {
            0 => String::new(),
            count => format!(
                "var filler: array<f32, {count}>;
for (var f = {}u; f < {count}u; f++) {{
filler[f] = x;
x = filler[f];
}}
",
                count - 2
            ),
        }
    }

    fn write(&mut self) -> String {
        let (word, title) = match self.kind {
            Kind::Sensor => ("sensor", "Sensor"),
            Kind::Controller => ("controller", "Controller"),
            Kind::Task => ("task", "Task"),
        };
        let mut text = PRELUDE.replace("PREFIX", self.word());
        let mut values = Vec::new();
        if self.draw.one_in(2) {
            values = ["weight", "other"]
                .map(|value| format!("{word}_values(episode).{value}"))
                .into();
            let _ = writeln!(
                text,
                "struct {title}Values {{
weight: f32, // 0.75, 0 to 2: of something
other: f32, // 3, 0 to 9 mm: of something else
}}"
            );
        }
        let filler = std::mem::take(&mut self.filler);
        for helper in 0..self.draw.below(self.size + 1) {
            self.begin(&["a", "b"], &[], true);
            self.floats.extend(values.clone());
            let early = self.truth(1);
            let body = self.body();
            let _ = writeln!(
                text,
                "fn of_{word}_helper_{helper}(episode: Episode, a: f32, b: f32) -> f32 {{
if {early} {{ return a; }}
{body}return x + f32(n & 7u);
}}"
            );
            self.helpers = helper + 1;
        }
        self.filler = filler;
        let state = format!("{title}State");
        self.state(&state, &mut text);
        match self.kind {
            Kind::Sensor => self.sensor(&values, &mut text),
            Kind::Controller => self.controller(&values, &mut text),
            Kind::Task => self.task(&values, &mut text),
        }
        text
    }

    fn sensor(&mut self, values: &[String], text: &mut String) {
        self.begin(&["0.01f * pose.x", "0.01f * pose.y", "pose.z"], &["step"], true);
        self.floats.extend_from_slice(values);
        self.remember("SensorState", "before");
        let (body, next) = (self.body(), self.next("SensorState", "before"));
        let _ = writeln!(
            text,
            "struct SensorReadings {{ odd_one: f32, odd_two: f32 }}
fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {{
{body}return Sensed(SensorReadings(x, 0.01f * f32(n & 255u)), {next});
}}"
        );
        if self.draw.one_in(2) {
            self.begin(&["0.01f * pose.x", "pose.z"], &[], true);
            let (body, next) = (self.body(), self.next("SensorState", "SensorState()"));
            let _ = writeln!(
                text,
                "fn sensor_begin(episode: Episode, pose: vec3<f32>) -> SensorState {{\n{body}return {next};\n}}"
            );
        }
    }

    fn controller(&mut self, values: &[String], text: &mut String) {
        let genes = if self.draw.one_in(2) {
            let many = self.draw.below(5) + 1;
            format!(
                "struct ControllerGenes {{ alone: f32, all_weights: array<f32, INPUTS>, more_genes: array<f32, {many}> }}"
            )
        } else {
            format!("const CONTROLLER_GENES: u32 = INPUTS + {}u;", self.draw.below(4))
        };
        let readings = [
            "highest(readings)",
            "reading(readings, 0u)",
            "reading(readings, n)",
            "reading(readings, 4000000000u)",
        ];
        self.begin(
            &[
                readings[0],
                readings[1],
                readings[3],
                "gene(episode, 0u)",
                "gene(episode, 2u)",
            ],
            &["step"],
            true,
        );
        self.floats.extend_from_slice(values);
        self.has_readings = true;
        self.remember("ControllerState", "before");
        let (body, next) = (self.body(), self.next("ControllerState", "before"));
        let other = self.float(1);
        let _ = writeln!(
            text,
            "{genes}
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {{
{body}x += {};
return Command(vec2<f32>(0.5f + x, logistic({other})), {next});
}}",
            readings[2]
        );
        if self.draw.one_in(2) {
            self.begin(&["gene(episode, 1u)"], &[], true);
            let (body, next) = (self.body(), self.next("ControllerState", "ControllerState()"));
            let _ = writeln!(
                text,
                "fn controller_begin(episode: Episode) -> ControllerState {{\n{body}return {next};\n}}"
            );
        }
    }

    fn task(&mut self, values: &[String], text: &mut String) {
        let mut now = vec![
            "now.moved.left",
            "now.moved.right",
            "now.moved.turn",
            "now.outputs.x",
            "0.01f * now.end.x",
            "now.start.z",
            "highest(now.real)",
            "reading(now.perceived, now.step)",
            "select(0.0f, 1.0f, now.collided)",
        ];
        if self.setting == Setting::Forager {
            now.extend(["0.01f * now.to_food", "now.worth", "select(0.0f, 1.0f, now.took)"]);
        }
        let has_mission = self.setting == Setting::Swarm;
        if !has_mission || self.draw.one_in(2) {
            self.begin(&now, &["now.step"], true);
            self.floats.extend_from_slice(values);
            self.remember("TaskState", "before");
            let (body, next) = (self.body(), self.next("TaskState", "before"));
            let _ = writeln!(
                text,
                "fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {{
{body}return Reward(x + 0.001f * f32(n & 65535u), {next});
}}"
            );
            if self.draw.one_in(2) {
                self.begin(&["0.01f * pose.x", "pose.z"], &[], true);
                let (body, next) = (self.body(), self.next("TaskState", "TaskState()"));
                let _ = writeln!(
                    text,
                    "fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {{\n{body}return {next};\n}}"
                );
            }
        }
        if has_mission {
            self.state("MissionState", text);
            self.begin(
                &["0.01f * robot_pose(episode, step).x", "f32(robots(episode))"],
                &["step"],
                true,
            );
            self.floats.extend_from_slice(values);
            self.remember("MissionState", "before");
            let (body, next) = (self.body(), self.next("MissionState", "before"));
            let _ = writeln!(
                text,
                "fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {{
{body}return Tally(x, {next});
}}"
            );
        }
        let (name, state) = if has_mission {
            ("mission", "MissionState")
        } else {
            ("task", "TaskState")
        };
        if self.draw.one_in(3) {
            self.begin(&[], &[], true);
            self.remember(state, "own");
            let (over, often) = (self.truth(1), self.unsigned(1));
            let _ = writeln!(
                text,
                "fn {name}_ends(episode: Episode, own: {state}) -> bool {{ return {over} && ({often} & 7u) == 5u; }}"
            );
        }
        if self.draw.one_in(2) {
            self.begin(&["0.1f * sum"], &[], true);
            self.remember(state, "own");
            let body = self.body();
            let _ = writeln!(
                text,
                "fn {name}_score(episode: Episode, own: {state}, sum: f32) -> f32 {{\n{body}return x + f32(n & 255u);\n}}"
            );
        }
    }
}
