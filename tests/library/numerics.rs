//! The kernels' functions are as accurate as their comments in `lib/numerics.wgsl` and `lib/user.wgsl` say, and the same in
//! every lane code.

use std::f64::consts::TAU;
use std::sync::Arc;

use oneiro::batch::{Batch, GREATEST_GENE, LEAST_GENE, Rollout, TraceRequest};
use oneiro::compose::{Kind, OwnPart, OwnParts, Part};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::probe::{Case, Subject, functions};
use oneiro::random::Key;
use oneiro::world::{Controller, World, WorldSpec};

/// Arguments of each function: a strided subset of all floats, for which `docs/numerics.md` has the errors.
const ARGUMENTS: usize = 1 << 17;

fn name(case: &Case) -> &'static str {
    match case.subject {
        Subject::Function(name) => name,
        Subject::Operation { .. } => panic!("{} is no function", case.subject),
    }
}

fn case(wanted: &str, arguments: usize) -> Case {
    functions(arguments)
        .into_iter()
        .find(|case| name(case) == wanted)
        .unwrap()
}

/// The arguments and results of the first lane code.
fn values(case: &Case) -> impl Iterator<Item = [f32; 3]> {
    let variant = case.lane_codes().next().unwrap();
    let results = case.run(variant).unwrap();
    let arguments = case.left.clone().into_iter().zip(case.right.clone());
    arguments
        .zip(results)
        .map(|((x, y), result)| [x, y, result].map(f32::from_bits))
}

#[test]
fn every_lane_code_gives_the_same_bits() {
    for case in functions(ARGUMENTS) {
        let variants: Vec<_> = case.lane_codes().collect();
        assert!(variants.len() > 1);
        let first = case.run(variants[0]).unwrap();
        for variant in &variants[1..] {
            let results = case.run(variant).unwrap();
            let differ = first.iter().zip(&results).position(|(a, b)| a != b);
            assert_eq!(differ, None, "{} in {} and {}", case.subject, variants[0], variant);
        }
    }
}

/// Greatest relative error of a function.
fn relative(name: &str, truth: impl Fn(f64) -> f64) -> f64 {
    let error = |[x, _, y]: [f32; 3]| {
        let truth = truth(f64::from(x));
        if truth == 0.0 {
            f64::from(y).abs()
        } else {
            (f64::from(y) / truth - 1.0).abs()
        }
    };
    values(&case(name, ARGUMENTS)).map(error).fold(0.0, f64::max)
}

/// Greatest absolute error of a function.
fn absolute(name: &str, truth: impl Fn(f64) -> f64) -> f64 {
    let error = |[x, _, y]: [f32; 3]| (f64::from(y) - truth(f64::from(x))).abs();
    values(&case(name, ARGUMENTS)).map(error).fold(0.0, f64::max)
}

/// Asserts that the greatest error is the one measured over every float: no more, and not so much less that the
/// arguments would miss the worst ones.
fn assert_error(what: &str, error: f64, measured: f64) {
    assert!(
        error <= measured && error > 0.5 * measured,
        "{what}: {error:e}, stated: {measured:e}"
    );
}

#[test]
fn errors_are_as_stated() {
    let turn = |turns: f64| TAU * (turns - turns.floor());
    assert_error("reciprocal", relative("reciprocal", |x| 1.0 / x), 1.2e-7);
    assert_error(
        "reciprocal_root",
        relative("reciprocal_root", |x| 1.0 / x.sqrt()),
        1.6e-7,
    );
    assert_error("root", relative("root", f64::sqrt), 2.0e-7);
    assert_error("cosine", absolute("cosine", |x| turn(x).cos()), 1.9e-7);
    assert_error("sine", absolute("sine", |x| turn(x).sin()), 1.9e-7);
    assert_error("exponential", relative("exponential", f64::exp), 1.9e-7);
    assert_error("logistic", absolute("logistic", |x| 1.0 / (1.0 + (-x).exp())), 1.5e-7);
    assert_error("logarithm", relative("logarithm", f64::ln), 1.0e-7);
}

/// What `lib/user.wgsl` adds, in a kernel that is composed: a controller that remembers the value at each of its genes.
#[test]
fn the_error_of_the_hyperbolic_tangent_is_as_stated() {
    const GENES: usize = 1000;
    let text = format!(
        "const CONTROLLER_GENES: u32 = {GENES}u;
        struct ControllerValues {{
            factor: f32, // 1, 1 to 1e33: of the genes
        }}
        struct ControllerState {{ x: f32, y: f32 }}
        fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {{
            let x = gene(episode, step) * controller_values(episode).factor;
            return Command(vec2<f32>(0.5f, 0.5f), ControllerState(x, hyperbolic_tangent(x)));
        }}"
    );
    let part = Arc::new(Part::new(Kind::Controller, "tanh.wgsl", &text).unwrap());
    let values = |factor: f64, least: f32| {
        let own = OwnPart::new(Arc::clone(&part), &[("factor", factor)]).unwrap();
        let world = World::new(WorldSpec {
            controller: Controller::Own,
            own: OwnParts::from([own]),
            cycles: GENES as u32,
            ..WorldSpec::miglino1995()
        });
        let span = GREATEST_GENE.to_bits() - least.to_bits();
        let lives = ARGUMENTS / GENES;
        let gene = |index: usize| {
            let size = least.to_bits() + (u64::from(span) * (index / 2) as u64 / (ARGUMENTS / 2) as u64) as u32;
            f32::from_bits(size | (index as u32 % 2) << 31)
        };
        let genes: Vec<f32> = (0..lives * GENES).map(gene).collect();
        let rollout = |genes| Rollout {
            world: 0,
            genes,
            key: Key::rollout(1, 0, 0, 0),
        };
        let rollouts: Vec<_> = genes.chunks(GENES).map(rollout).collect();
        let batch = Batch::new(&[world.unwrap()], &rollouts, Some(TraceRequest { every: 1 })).unwrap();
        let traces = Cpu::new(Some(2))
            .unwrap()
            .evaluate(&batch, &Control::new())
            .unwrap()
            .traces;
        let pair = |details: &[u32]| [16, 17].map(|word| f32::from_bits(details[word]));
        let pairs: Vec<_> = traces
            .iter()
            .flat_map(|trace| trace.lines().map(|(_, details)| pair(details)))
            .collect();
        assert_eq!(pairs.len(), genes.len());
        for ([x, _], gene) in pairs.iter().zip(&genes) {
            assert_eq!(*x, gene * factor as f32);
        }
        pairs
    };
    let error = |[x, y]: &[f32; 2]| (f64::from(*y) - f64::from(*x).tanh()).abs();
    let greatest = values(1.0, LEAST_GENE).iter().map(error).fold(0.0, f64::max);
    assert_error("hyperbolic_tangent", greatest, 3.0e-7);
    for [x, y] in values(3e32, 1.0) {
        assert_eq!(y, x.signum(), "{x:e}");
    }
}

#[test]
fn directions_are_as_stated() {
    let mut greatest: f64 = 0.0;
    for [x, y, direction] in values(&case("direction", ARGUMENTS)) {
        assert!((0.0..1.0).contains(&direction), "({x:e}, {y:e}): {direction:e}");
        let turns = f64::from(y).atan2(f64::from(x)) / TAU;
        let difference = f64::from(direction) - turns;
        greatest = greatest.max((difference - difference.round()).abs());
    }
    assert_error("direction", greatest, 4.5e-7);
}

/// Results of a function for given arguments; f32 results are given by their bits.
fn results(function: &str, arguments: &[(u32, u32)]) -> Vec<u32> {
    let mut case = case(function, 0);
    (case.left, case.right) = arguments.iter().copied().unzip();
    case.parameters[1] = arguments.len() as u32;
    case.run("scalarx1").unwrap()
}

/// Result of a function for a number.
fn value(function: &str, x: f32) -> f32 {
    f32::from_bits(results(function, &[(x.to_bits(), 0)])[0])
}

#[test]
fn exact_values_are_exact() {
    for exponent in -125..=125 {
        let power = 2.0_f32.powi(exponent);
        assert_eq!(value("reciprocal", power), 2.0_f32.powi(-exponent));
        assert_eq!(value("reciprocal", -power), -2.0_f32.powi(-exponent));
    }
    for exponent in -63..=63 {
        let power = 2.0_f32.powi(2 * exponent);
        assert_eq!(value("reciprocal_root", power), 2.0_f32.powi(-exponent));
        if exponent >= -50 {
            assert_eq!(value("root", power), 2.0_f32.powi(exponent));
        }
    }
    assert_eq!(value("root", 0.0), 0.0);
    for (turns, cosine, sine) in [(0.0, 1.0, 0.0), (0.25, 0.0, 1.0), (0.5, -1.0, 0.0), (0.75, 0.0, -1.0)] {
        for whole in [0.0, 1.0, -1.0, 1000.0, -1_000_000.0] {
            assert_eq!(value("cosine", turns + whole), cosine);
            assert_eq!(value("sine", turns + whole), sine);
        }
    }
    assert_eq!(value("exponential", 0.0), 1.0);
    assert_eq!(value("logistic", 0.0), 0.5);
    assert_eq!(value("logarithm", 1.0), 0.0);
    let axes: [(f32, f32, f32); 6] = [
        (0.0, 0.0, 0.0),
        (2.0, 0.0, 0.0),
        (0.0, 3.0, 0.25),
        (-1e18, 0.0, 0.5),
        (0.0, -1e-18, 0.75),
        (7.0, -1e-17, 0.0),
    ];
    for (x, y, turns) in axes {
        let direction = results("direction", &[(x.to_bits(), y.to_bits())])[0];
        assert_eq!(f32::from_bits(direction), turns, "({x}, {y})");
    }
}

#[test]
fn beyond_its_range_the_exponential_stays() {
    for (beyond, end) in [(1e4, 87.0), (-1e4, -87.0), (f32::MAX, 87.0), (f32::MIN, -87.0)] {
        assert_eq!(value("exponential", beyond), value("exponential", end));
        assert_eq!(value("logistic", beyond), value("logistic", end));
    }
    assert_eq!(value("logistic", f32::MAX), 1.0);
}

#[test]
fn units_are_the_upper_24_bits() {
    for [word, _, unit] in values(&case("unit", ARGUMENTS)) {
        assert_eq!(f64::from(unit), f64::from(word.to_bits() >> 8) / f64::from(1 << 24));
    }
    assert_eq!(
        f32::from_bits(results("unit", &[(u32::MAX, 0)])[0]),
        1.0 - 2.0_f32.powi(-24)
    );
}

/// Computed from the definition of the hash with arbitrary-precision integers, for stream 1.
#[test]
fn random_words_are_known() {
    let known = [
        ((0, 0), [0, 0], [0xe3fc_1caf, 0x2db4_f515, 0x4a8e_acd3, 0x412e_3d69]),
        ((1, 0), [0, 0], [0x50f2_1eb6, 0xd84a_1704, 0x5755_a764, 0xd244_4ed8]),
        (
            (0xffff_ffff, 0x8000_0000),
            [4_999, 1],
            [0x5b79_19e6, 0x1eb2_1ca5, 0x69ad_33d5, 0x6104_a4d1],
        ),
        (
            (0x1234_5678, 0x9abc_def0),
            [77, 65_535],
            [0x0348_315f, 0x9ed2_7338, 0x3e1c_3450, 0x0955_def1],
        ),
    ];
    for (key, [step, block], words) in known {
        for (number, word) in words.into_iter().enumerate() {
            let mut case = case(&format!("random word {number}"), 0);
            (case.left, case.right) = (vec![key.0], vec![key.1]);
            (case.parameters[1], case.parameters[2], case.parameters[3]) = (1, step, block);
            for variant in case.lane_codes() {
                assert_eq!(case.run(variant).unwrap(), [word], "{key:x?} in {variant}");
            }
        }
    }
}

/// A control: arguments that differ in the last bit that is used give other results.
#[test]
fn the_last_bit_shows() {
    for case in functions(ARGUMENTS) {
        let bit = if name(&case) == "unit" { 1 << 8 } else { 1 };
        let mut next = case.clone();
        next.left.iter_mut().for_each(|word| *word ^= bit);
        let [first, next] = [&case, &next].map(|case| case.run("scalarx1").unwrap());
        let differ = first.iter().zip(&next).filter(|(a, b)| a != b).count();
        assert!(
            differ > first.len() / 100,
            "{}: {differ} of {}",
            case.subject,
            first.len()
        );
    }
}
