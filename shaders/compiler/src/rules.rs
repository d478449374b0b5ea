//! The rules that a kernel's parts keep: why each exists, an example that breaks it, and one that keeps it.

use std::fmt;

/// Makes [`Rule`] of its table.
macro_rules! rules {
    ($($rule:ident $name:literal $about:literal why: $why:literal wrong: $wrong:literal right: $right:literal)*) => {
        /// A rule that a refused kernel breaks.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Rule {
            $(#[doc = $about] $rule,)*
        }

        impl Rule {
            /// All rules.
            pub const ALL: &[Self] = &[$(Self::$rule),*];

            /// Its name, by which refusals end and `oneiro check --explain` finds it. Names don't change.
            pub fn name(self) -> &'static str {
                match self { $(Self::$rule => $name,)* }
            }

            /// What it says, in one line.
            pub fn about(self) -> &'static str {
                match self { $(Self::$rule => $about,)* }
            }

            /// Why it exists, in one paragraph.
            pub fn why(self) -> &'static str {
                match self { $(Self::$rule => $why,)* }
            }

            /// WGSL that breaks it and no other rule, and the same as it should be; `None` if no part can break it. Each is
            /// a part, except for its function `.._cycle` where that has nothing to do with the rule.
            pub fn examples(self) -> Option<[&'static str; 2]> {
                let examples = match self { $(Self::$rule => [$wrong, $right],)* };
                (!examples[0].is_empty()).then_some(examples)
            }
        }
    };
}

impl Rule {
    /// Whether it is about how values are computed: the loops of a kernel that breaks it can be bounded nevertheless.
    pub(crate) fn is_of_values(self) -> bool {
        matches!(self, Self::ExactFunctions | Self::FiniteConstants)
    }
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

rules! {
    ExactFunctions "exact-functions"
        "No `pack4x8unorm`, `extractBits` and their like; no `sin` of a constant."
        why: "WGSL only limits the errors of functions such as `sin`, and each device computes them in its own way. \
              Oneiro computes most of them itself, with operations that every device rounds alike. A few that robots \
              seldom need are missing: those that pack floats or bits, and derivatives. A function such as `sin` of a constant would be computed while the kernel is \
              compiled, by a library that differs between machines."
        wrong: "const QUARTER: f32 = sin(0.25);\n"
        right: "\
fn quarter() -> f32 {
    let angle = 0.25;
    return sin(angle);
}
"

    FiniteConstants "finite-constants"
        "Constants are finite, and 0 or at least 1.2e-38 in size."
        why: "WGSL lets a device assume that no float is infinite or NaN, and drop what tests for them. Floats nearer \
              to zero than 1.2e-38 (subnormal ones) count as zero on some devices and not on others."
        wrong: "const TINY: f32 = 1e-40f;\n"
        right: "const TINY: f32 = 1e-30f;\n"

    FloatBits "float-bits"
        "`bitcast` turns bits into floats, but not floats into bits."
        why: "Devices agree about floats, except about the sign of zero and about the bits of a result that \
              is not a number. A driver may drop `x * 0.0f`, and with it the sign. No other operation shows these bits."
        wrong: "\
fn is_negative(x: f32) -> bool {
    return (bitcast<u32>(x) >> 31u) == 1u;
}
"
        right: "\
fn is_negative(x: f32) -> bool {
    return x < 0.0f;
}
"

    SupportedTypes "supported-types"
        "No f16, textures, samplers or atomics."
        why: "Types are f32, u32, i32, bool, vectors, arrays and structs of them, and matrices of f32. Not every device \
              has floats of 16 bits. What textures and samplers return depends on the hardware, and what atomic \
              variables hold depends on which episode comes first."
        wrong: "fn gain(x: f32) -> f32 { return f32(f16(x)); }\n"
        right: "fn gain(x: f32) -> f32 { return x; }\n"

    NoOverride "no-override"
        "`const` instead of `override`; an experiment sets a part's struct of values."
        why: "An `override` gets its value when a driver compiles the kernel. The CPU's code is not compiled by a \
              driver, so nothing would set its value there."
        wrong: "override factor: f32 = 2.0f;\n"
        right: "const FACTOR: f32 = 2.0f;\n"

    LargeVariable "large-variable"
        "A variable has at most 64 KB, and so have all arrays of a kernel together."
        why: "Up to 64 episodes run side by side on a processor, and each has its own copy of every variable. Larger ones \
              would overflow the stack, which ends the program. Where arrays are large, fewer episodes run side by side. An \
              array of a function counts again at each call of it, since the function's body replaces each call."
        wrong: "\
fn first() -> f32 {
    var all: array<f32, 20000>;
    return all[0];
}
"
        right: "\
fn first() -> f32 {
    var all: array<f32, 200>;
    return all[0];
}
"

    LargeKernel "large-kernel"
        "At most 100,000 values and calls, with functions' bodies instead of calls."
        why: "Each call is replaced by the body of its function, since episodes that run side by side can't call \
              different ones. Functions that call others many times multiply the kernel again and again, and compiling \
              would not end."
        wrong: "\
fn a(x: f32) -> f32 { return 0.5f * x + 1.0f; }
fn b(x: f32) -> f32 { return a(a(a(a(a(a(a(a(a(a(x)))))))))); }
fn c(x: f32) -> f32 { return b(b(b(b(b(b(b(b(b(b(x)))))))))); }
fn d(x: f32) -> f32 { return c(c(c(c(c(c(c(c(c(c(x)))))))))); }
fn e(x: f32) -> f32 { return d(d(d(d(d(d(d(d(d(d(x)))))))))); }
fn f(x: f32) -> f32 { return e(e(e(e(e(e(e(e(e(e(x)))))))))); }
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    return Reward(f(now.end.x), before);
}
"
        right: "\
fn a(x: f32) -> f32 { return 0.5f * x + 1.0f; }
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var sum = now.end.x;
    for (var i = 0u; i < 100u; i++) { sum = a(sum); }
    return Reward(sum, before);
}
"

    IndexedArrays "indexed-arrays"
        "Readings have no index: write `reading(readings, i)`."
        why: "Readings are the fields of a struct, which has no index in WGSL. Arrays and vectors may be indexed by any \
              number."
        wrong: "\
fn second(readings: Readings) -> f32 {
    return readings[1];
}
"
        right: "\
fn second(readings: Readings) -> f32 {
    return reading(readings, 1u);
}
"

    SameIndex "same-index"
        "An index into more than 256 elements is a constant, or a loop's counter."
        why: "On a processor, 4 to 64 episodes run side by side in one vector, and an element is loaded for all of them \
              together. If the index differs, the kernel goes through the whole array, which takes long where that has \
              many elements."
        wrong: "\
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var earned: array<f32, 300>;
    earned[299] = 5.0;
    let zone = u32(clamp(now.end.x, 0.0, 299.0));
    return Reward(earned[zone], before);
}
"
        right: "\
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var earned: array<f32, 30>;
    earned[29] = 5.0;
    let zone = u32(clamp(0.1 * now.end.x, 0.0, 29.0));
    return Reward(earned[zone], before);
}
"

    WholePointers "whole-pointers"
        "A pointer that is passed to a function points to a whole variable."
        why: "SPIR-V, the form in which GPUs get a kernel, passes no pointer to a part of a variable. Return the new \
              value, or pass a pointer to the whole."
        wrong: "\
struct Two { a: f32, b: f32 }
fn double(p: ptr<function, f32>) { *p = 2.0f * *p; }
fn sum(a: f32, b: f32) -> f32 {
    var two = Two(a, b);
    double(&two.a);
    return two.a + two.b;
}
"
        right: "\
struct Two { a: f32, b: f32 }
fn double(x: f32) -> f32 { return 2.0f * x; }
fn sum(a: f32, b: f32) -> f32 {
    var two = Two(a, b);
    two.a = double(two.a);
    return two.a + two.b;
}
"

    LoopWithoutBound "loop-without-bound"
        "A loop counts from a constant to a constant, or to such as `min(x, 8u)`."
        why: "Nothing can stop a kernel on a GPU. A loop that doesn't end freezes the screen until the driver resets \
              the device, and the run is lost. Software drivers leave long loops without saying so, and results \
              differ. So Oneiro must know before the first cycle how often each loop turns at most. A `for`, a `while` \
              or a `loop` has a counter that is set before it and changed once in each turn, by a constant, outside of \
              `if` and before any `continue`; its test may have more conditions, such as `i < 9u && !found`. Besides `min(x, 8u)`, the end of a u32 may be `x % 8u`, \
              `x & 7u`, a `select` of such, the counter of a loop around it, and sums and products of these. With `<=` \
              or a step above 1, the maximum of the end plus the step must be below 2^32 - 1, or the counter could \
              begin again from 0."
        wrong: "\
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var sum = 0.0f;
    var x = abs(now.end.x);
    while (x > 1.0f) { x *= 0.5f; sum += 1.0f; }
    return Reward(sum, before);
}
"
        right: "\
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var sum = 0.0f;
    var x = abs(now.end.x);
    for (var i = 0u; i < 40u && x > 1.0f; i++) { x *= 0.5f; sum += 1.0f; }
    return Reward(sum, before);
}
"

    TooManyTurns "too-many-turns"
        "All loops of a cycle, the simulator's too, turn at most 100,000 times."
        why: "A run is stopped between cycles, and an episode is cut between cycles into pieces that are short enough for \
              a GPU: drivers reset a device whose work takes longer than some seconds. So no cycle may take long."
        wrong: "\
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var sum = 0.0f;
    for (var i = 0u; i < 1000000u; i++) { sum = 0.5f * sum + 1.0f; }
    return Reward(sum, before);
}
"
        right: "\
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var sum = 0.0f;
    for (var i = 0u; i < 100u; i++) { sum = 0.5f * sum + 1.0f; }
    return Reward(sum, before);
}
"

    EntryPoint "entry-point"
        "No `@compute` and its like."
        why: "A kernel begins at one place, Oneiro's own, which gives each episode its number, its genes and its random \
              numbers. What a part's entry point could read depends on how the work was cut."
        wrong: "\
@compute @workgroup_size(64)
fn prepare() {}
"
        right: "fn prepare() {}\n"

    BuiltInName "built-in-name"
        "Nothing has the name of a WGSL type or function that parts use."
        why: "A function with the name of one that is known to be exact would pass for it, and a struct with the name \
              of a type for that type."
        wrong: "fn clamp(x: f32) -> f32 { return max(x, 0.0f); }\n"
        right: "fn not_negative(x: f32) -> f32 { return max(x, 0.0f); }\n"

    ReservedName "reserved-name"
        "Nothing has the name of Oneiro's structs, or of functions for parts."
        why: "A part is put together with Oneiro's own files into one kernel, in which each name is declared once. \
              These names mean the same in all parts; other names of Oneiro's files are free, and theirs give way. \
              Names of readings also name genes, so a custom reading can't have the name of one of the robot's."
        wrong: "fn blocked(x: f32) -> bool { return x < 27.5f; }\n"
        right: "fn is_blocked(x: f32) -> bool { return x < 27.5f; }\n"

    OwnBuffers "own-buffers"
        "No buffers, and no variables outside of functions: memory is in the state."
        why: "Oneiro makes and fills a kernel's buffers; another one would stay empty. A variable outside of functions \
              begins anew in each piece that an episode is cut into, so that results would depend on the cuts. The \
              state goes from cycle to cycle on every device."
        wrong: "var<private> cycles: u32;\n"
        right: "\
struct TaskState { cycles: u32 }
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    return Reward(0.0f, TaskState(before.cycles + 1u));
}
"

    KernelBuffers "kernel-buffers"
        "The kernel's buffers, such as `worlds` and `fitness`, are not named."
        why: "They hold the genes, states and results of all episodes of a batch. A part that reads or writes there \
              reaches other episodes, and results depend on what else is in the batch."
        wrong: "fn best() -> f32 { return fitness[0]; }\n"
        right: "fn best(memory: TaskState, sum: f32) -> f32 { return sum; }\n"

    BatchPlace "batch-place"
        "The fields of an `Episode` are not read."
        why: "They say where in its batch an episode is. The same episode has another place on another device, or next to \
              other runs, so a result that depends on its place could not be repeated."
        wrong: "\
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    return Reward(f32(episode.world), before);
}
"
        right: "\
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    return Reward(random(episode, STREAM_TASK, now.step, 0u).x, before);
}
"

    EpisodeAsGiven "episode-as-given"
        "An `Episode` is passed on as given: not made, not changed and not kept."
        why: "An `Episode` has indices into the kernel's buffers. Every function that takes one, such as `gene` and \
              `robot_pose`, reads there. With other indices it would read or write another episode of the batch, and \
              results would depend on what else is in the batch. `let same = episode;` is fine."
        wrong: "\
fn draw(step: u32) -> f32 {
    var nobody: Episode;
    return random(nobody, STREAM_TASK, step, 0u).x;
}
"
        right: "\
fn draw(episode: Episode, step: u32) -> f32 {
    return random(episode, STREAM_TASK, step, 0u).x;
}
"

    AllowedCalls "allowed-calls"
        "Of Oneiro's functions, parts call only those that docs/extend.md lists."
        why: "The others take indices into the kernel's buffers, with which a part could reach other episodes, and they \
              change from version to version."
        wrong: "fn is_free(x: f32, y: f32) -> bool { return !touches(0u, vec2<f32>(x, y)); }\n"
        right: "fn is_free(episode: Episode, x: f32, y: f32) -> bool { return !blocked(episode, vec2<f32>(x, y)); }\n"

    MissingDeclaration "missing-declaration"
        "Parts declare `.._cycle`, controllers also genes, and sensors readings."
        why: "The kernel calls these functions by their names and uses these constants and structs. Other functions \
              have a default, but none makes sense here."
        wrong: "\
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    return Command(vec2<f32>(gene(episode, 0u), gene(episode, 1u)), before);
}
"
        right: "\
const CONTROLLER_GENES: u32 = 2u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    return Command(vec2<f32>(gene(episode, 0u), gene(episode, 1u)), before);
}
"

    DeclaredForm "declared-form"
        "Functions that Oneiro calls have the form that docs/extend.md gives."
        why: "The kernel passes these arguments and takes this result. With others it could not be compiled, and the \
              message would be about one of Oneiro's files."
        wrong: "\
fn task_cycle(now: Experience) -> f32 {
    return now.moved.left;
}
"
        right: "\
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    return Reward(now.moved.left, before);
}
"

    UncalledFunction "uncalled-function"
        "Functions named `task_..`, `controller_..` or `sensor_..` are called."
        why: "Oneiro calls the functions of a part by their names and has a default for each that is missing. A name that \
              is misspelt would be a missing function, and the run would go on with the default without saying so."
        wrong: "\
fn task_end(episode: Episode, memory: TaskState) -> bool { return true; }
"
        right: "\
fn task_ends(episode: Episode, memory: TaskState) -> bool { return true; }
"

    ValueForm "value-form"
        "Values are `NAME: f32, // DEFAULT, LEAST to GREATEST UNIT: MEANING`."
        why: "From this comment come the default, the check of what an experiment sets, and what `oneiro check` shows. \
              Without limits a typing error would run for hours."
        wrong: "\
struct TaskValues {
    radius: f32, // mm
}
"
        right: "\
struct TaskValues {
    radius: f32, // 150, 50 to 1000 mm: of the circle
}
"

    ReadingForm "reading-form"
        "A reading of a custom sensor is one f32."
        why: "The controllers that ship weigh each reading by its gene and name the gene after it, so each \
              field must be one number."
        wrong: "\
struct SensorReadings { ahead: vec2<f32> }
fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    return Sensed(SensorReadings(cosine_sine(pose.z)), before);
}
"
        right: "\
struct SensorReadings { east: f32, north: f32 }
fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    let ahead = cosine_sine(pose.z);
    return Sensed(SensorReadings(ahead.x, ahead.y), before);
}
"

    GeneForm "gene-form"
        "Genes are f32 or arrays of them: `// LEAST to GREATEST UNIT: MEANING`."
        why: "Tables have a column for each gene, and its name in capitals is the constant of its index, so the name itself \
              is in lower case. A comment that begins with a number has to be a whole range: with half of one, a gene would \
              evolve in the range of all others, and nothing would show it."
        wrong: "\
struct ControllerGenes {
    gain: f32, // 0 to: of the sensors
    biases: vec2<f32>,
}
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    return Command(vec2<f32>(gene(episode, 0u), gene(episode, 1u)), before);
}
"
        right: "\
struct ControllerGenes {
    gain: f32, // 0 to 5: of the sensors
    biases: array<f32, 2>,
}
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let near = gene(episode, GAIN) * highest(readings);
    return Command(vec2<f32>(near + gene(episode, BIASES), near + gene(episode, BIASES + 1u)), before);
}
"

    StateTypes "state-types"
        "A part's memory has fields of f32, u32, i32 and vectors of them."
        why: "Between two pieces of an episode its memory is words in a buffer, and each word is a column of the trace. A \
              bool has no form in a buffer, and an array no name for each column."
        wrong: "struct TaskState { found: bool }\n"
        right: "struct TaskState { found: u32 }\n"

    GeneCount "gene-count"
        "A controller has 1 to 65536 genes, a constant number."
        why: "The optimiser needs the number of genes before it creates the first individual."
        wrong: "\
const CONTROLLER_GENES: u32 = 0u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    return Command(vec2<f32>(gene(episode, 0u), gene(episode, 1u)), before);
}
"
        right: "\
const CONTROLLER_GENES: u32 = 2u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    return Command(vec2<f32>(gene(episode, 0u), gene(episode, 1u)), before);
}
"

    UnknownName "unknown-name"
        "Each name is declared in a part of the experiment or in docs/extend.md."
        why: "A name that nothing declares is usually misspelt; the message then has the one that is most like it."
        wrong: "fn half_of(x: f32) -> f32 { return x * recirpocal(2.0f); }\n"
        right: "fn half_of(x: f32) -> f32 { return x * reciprocal(2.0f); }\n"

    AsciiSource "ascii-source"
        "Outside of comments, a part is written in ASCII."
        why: "Many other characters look like a letter or a blank, or like nothing at all. Tools disagree about which of \
              them end a line or a name, so you and a compiler could read different programs. Comments may have any \
              characters."
        wrong: "fn twice(gr\u{f6}\u{df}e: f32) -> f32 { return 2.0f * gr\u{f6}\u{df}e; }\n"
        right: "fn twice(size: f32) -> f32 { return 2.0f * size; }\n"

    ValidWgsl "valid-wgsl"
        "A part is WGSL: its syntax and its types are those of the language."
        why: "Parts are read by naga, the WGSL compiler that Firefox has, and the message is naga's. The language is \
              described at https://www.w3.org/TR/WGSL/. A mistake in syntax hides what comes after it."
        wrong: "fn count(x: f32) -> u32 { return x; }\n"
        right: "fn count(x: f32) -> u32 { return u32(max(x, 0.0f)); }\n"

    Internal "internal"
        "Oneiro's files keep these rules; no part can break them."
        why: "Some of what the compiler refuses can't be written in a part: it concerns Oneiro's own buffers and its \
              entry point. If a part is refused with this rule, the mistake is Oneiro's: please report it with the \
              part."
        wrong: ""
        right: ""
}
