//! The e-puck's reference models: every reading beside a second program, written from `docs/reference-models.md` in double
//! precision, the distributions of the noise, and refusals.

use oneiro::arena::{Arena, Block, Patch, Wall};
use oneiro::batch::{Batch, Rollout, TraceRequest};
use oneiro::compose::DetailKind;
use oneiro::cpu::Cpu;
use oneiro::differential::{Build, Differential};
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::{Key, pcg4d};
use oneiro::reference::{Model, Reference};
use oneiro::world::{Controller, World, WorldSpec};

use crate::epucks::{QUIET, disc, dodecagon, epucks, lamp};

const BODY: f64 = 35.0;

/// A dodecagon with a lamp, patches, an inner wall and a block.
fn arena() -> Arena {
    let mut arena = dodecagon(1226.0, 1200.0);
    let wall = Wall {
        from: [-300.0, 400.0],
        to: [300.0, 250.0],
        ..Wall::default()
    };
    arena.walls.insert(0, wall);
    arena.blocks.push(Block {
        x: -500.0,
        y: -300.0,
        length: 300.0,
        width: 100.0,
        heading: 0.1,
        ..Block::default()
    });
    arena.lights = vec![lamp(0.0, -1250.0, 750.0, 5.0), lamp(1300.0, 300.0, 200.0, 2.0)];
    arena.wall_height = Some(80.0);
    arena.floor = Some(0.498);
    arena.patches = vec![disc(500.0, 500.0, 400.0, 0.0), disc(-500.0, 500.0, 400.0, 1.0)];
    arena
}

fn spec(model: Model, reference: Reference, count: u32, arena: Arena) -> WorldSpec {
    WorldSpec {
        robot: epucks(model, reference, count),
        arena,
        controller: Controller::Perceptron,
        cycles: 60,
        ..WorldSpec::miglino1995()
    }
}

fn genome(life: u32, genes: usize) -> Vec<f32> {
    let word = |gene: usize| pcg4d([life, gene as u32, 0, 2027])[0];
    (0..genes)
        .map(|gene| (word(gene) % 2001) as f32 / 1000.0 - 1.0)
        .collect()
}

/// What the first robot read in each cycle, the speeds of its wheels and its outputs, and all poses.
struct Cycle {
    readings: Vec<f64>,
    speeds: [f64; 2],
    outputs: [f64; 2],
    poses: Vec<[f64; 3]>,
}

fn lived(world: &World, lives: u32) -> Vec<Vec<Cycle>> {
    let genomes: Vec<_> = (0..lives).map(|life| genome(life, world.genes())).collect();
    let rollouts: Vec<_> = (0_u64..)
        .zip(&genomes)
        .map(|(life, genes)| Rollout {
            world: 0,
            genes,
            key: Key::rollout(5, 0, life, 0),
        })
        .collect();
    let batch = Batch::new(std::slice::from_ref(world), &rollouts, Some(TraceRequest { every: 1 })).unwrap();
    let outcome = Cpu::new(Some(2)).unwrap().evaluate(&batch, &Control::new()).unwrap();
    let places = |kind: DetailKind| -> Vec<usize> {
        let all = (0..).zip(world.details());
        all.filter(|(_, own)| own.kind == kind)
            .map(|(index, _)| index)
            .collect()
    };
    let (perceived, others) = (places(DetailKind::Perceived), places(DetailKind::Other));
    let each = outcome.traces.iter().map(|trace| {
        let cycles = trace.lines().map(|(record, details)| {
            let number = |place: &usize| f64::from(f32::from_bits(details[*place]));
            let first = [record.x, record.y, record.heading].map(f64::from);
            let others = others.chunks(3).map(|pose| [0, 1, 2].map(|part| number(&pose[part])));
            Cycle {
                readings: perceived.iter().map(number).collect(),
                speeds: [record.speed_left, record.speed_right].map(f64::from),
                outputs: [record.left, record.right].map(f64::from),
                poses: std::iter::once(first).chain(others).collect(),
            }
        });
        cycles.collect()
    });
    each.collect()
}

/// The sides of all walls and blocks, as segments.
fn segments(arena: &Arena) -> Vec<[[f64; 2]; 2]> {
    let mut all: Vec<_> = arena
        .walls
        .iter()
        .map(|wall| [wall.from, wall.to].map(|end| end.map(f64::from)))
        .collect();
    for block in &arena.blocks {
        let corners = block.corners().map(|corner| [f64::from(corner.x), f64::from(corner.y)]);
        all.extend((0..4).map(|side| [corners[side], corners[(side + 1) % 4]]));
    }
    all
}

/// Where a ray meets a segment, as a distance.
fn meets([a, b]: &[[f64; 2]; 2], at: [f64; 2], ahead: [f64; 2]) -> Option<f64> {
    let span = [b[0] - a[0], b[1] - a[1]];
    let to = [a[0] - at[0], a[1] - at[1]];
    let across = ahead[0] * span[1] - ahead[1] * span[0];
    let distance = (to[0] * span[1] - to[1] * span[0]) / across;
    let share = (to[0] * ahead[1] - to[1] * ahead[0]) / across;
    ((0.0..=1.0).contains(&share) && distance >= 0.0).then_some(distance)
}

/// Where a ray meets a disc, as a distance; nowhere from inside it.
fn meets_disc(centre: [f64; 3], at: [f64; 2], ahead: [f64; 2]) -> Option<f64> {
    let to = [centre[0] - at[0], centre[1] - at[1]];
    let along = to[0] * ahead[0] + to[1] * ahead[1];
    let half = BODY * BODY - (to[0] * ahead[1] - to[1] * ahead[0]).powi(2);
    let near = along - half.max(0.0).sqrt();
    (half > 0.0 && near >= 0.0).then_some(near)
}

fn direction(degrees: f64) -> [f64; 2] {
    let angle = degrees.to_radians();
    [angle.cos(), angle.sin()]
}

const DECLARED: [f64; 8] = [17.0, 50.0, 90.0, 150.0, 210.0, 270.0, 310.0, 343.0];

/// Whether something is in the way of light from a lamp, and of messages, by this robot's number.
struct Witness<'a> {
    arena: &'a Arena,
    segments: Vec<[[f64; 2]; 2]>,
    sides: usize,
    range: f64,
    /// Whether bodies hide anything: the negative control.
    bodies_hide: bool,
}

impl Witness<'_> {
    fn proximity(&self, poses: &[[f64; 3]]) -> [f64; 8] {
        let own = poses[0];
        std::array::from_fn(|ray| {
            let ahead = direction(11.25 + 45.0 * ray as f64 + 360.0 * own[2]);
            let begin = [own[0] + 36.0 * ahead[0], own[1] + 36.0 * ahead[1]];
            let walls = self.segments.iter().filter_map(|wall| meets(wall, begin, ahead));
            let bodies = poses[1..].iter().filter_map(|other| meets_disc(*other, begin, ahead));
            let distance = walls.chain(bodies).fold(f64::INFINITY, f64::min) / 1000.0;
            if distance < 0.05 {
                (298.701 * distance * distance - 36.8961 * distance + 1.08212).clamp(0.0, 1.0)
            } else {
                0.0
            }
        })
    }

    fn light(&self, poses: &[[f64; 3]]) -> [f64; 8] {
        let own = poses[0];
        let mut readings = [0.0; 8];
        for lamp in &self.arena.lights {
            let to = [f64::from(lamp.x) - own[0], f64::from(lamp.y) - own[1]];
            let (flat, height) = (to[0].hypot(to[1]), f64::from(lamp.height.unwrap()));
            let ahead = to.map(|part| part / flat);
            let rise = height / flat;
            let bodies = poses[1..]
                .iter()
                .filter_map(|other| meets_disc(*other, [own[0], own[1]], ahead));
            let low = bodies.fold(f64::INFINITY, f64::min) * rise;
            let walls = self
                .segments
                .iter()
                .filter_map(|wall| meets(wall, [own[0], own[1]], ahead));
            let low_wall = walls.filter(|distance| *distance < flat).fold(f64::INFINITY, f64::min) * rise;
            let distance = flat.hypot(height) / f64::from(lamp.intensity.unwrap()) / 1000.0;
            if self.bodies_hide && low < 76.0 || low_wall < 80.0 || distance > 2.5 {
                continue;
            }
            for (reading, looks) in readings.iter_mut().zip(DECLARED) {
                let angle = ahead[1].atan2(ahead[0]).to_degrees() - 360.0 * own[2] - looks;
                let angle = (angle - 360.0 * (angle / 360.0).round()).abs();
                *reading += (-2.0 * distance).exp() * (1.0 - angle / 90.0).max(0.0);
            }
        }
        readings.map(|reading| reading.min(1.0))
    }

    /// The readings of the floor of a cycle.
    fn floor(&self, own: [f64; 3]) -> [f64; 3] {
        [9.0, 0.0, -9.0].map(|aside| {
            let [c, s] = direction(360.0 * own[2]);
            let at = [own[0] + 30.0 * c - aside * s, own[1] + 30.0 * s + aside * c];
            let on = |patch: &&Patch| {
                let away = (at[0] - f64::from(patch.x)).hypot(at[1] - f64::from(patch.y));
                away < f64::from(patch.radius.unwrap())
            };
            let patch = self.arena.patches.iter().rev().find(on);
            patch.map_or(0.498, |patch| f64::from(patch.grey))
        })
    }

    /// The messages of a cycle: their number, and their sum as the robot has it.
    fn messages(&self, poses: &[[f64; 3]]) -> (u32, [f64; 2]) {
        let own = poses[0];
        let (mut number, mut sum) = (0, [0.0; 2]);
        let inner = &self.segments[..self.segments.len()];
        for (index, other) in poses.iter().enumerate().skip(1) {
            let to = [other[0] - own[0], other[1] - own[1]];
            let distance = to[0].hypot(to[1]);
            let ahead = to.map(|part| part / distance);
            let is_between = |(at, body): (usize, &[f64; 3])| {
                let near = meets_disc(*body, [own[0], own[1]], ahead);
                at != 0 && at != index && near.is_some_and(|near| near < distance)
            };
            let hidden = self.bodies_hide && poses.iter().enumerate().any(is_between)
                || inner
                    .iter()
                    .any(|wall| meets(wall, [own[0], own[1]], ahead).is_some_and(|near| near < distance));
            if distance < self.range && !hidden {
                let share = 1.0 / (1.0 + (distance - 70.0) / 10.0);
                let [c, s] = direction(360.0 * own[2]);
                sum[0] += share * (ahead[0] * c + ahead[1] * s);
                sum[1] += share * (ahead[1] * c - ahead[0] * s);
                number += 1;
            }
        }
        (number, sum)
    }
}

fn quarters(v: [f64; 2]) -> [f64; 4] {
    [45.0, 135.0, 225.0, 315.0].map(|degrees| {
        let along = direction(degrees);
        (v[0] * along[0] + v[1] * along[1]).max(0.0)
    })
}

fn sum_of(ring: [f64; 8]) -> [f64; 2] {
    let mut sum = [0.0; 2];
    for (reading, looks) in ring.into_iter().zip(DECLARED) {
        let along = direction(looks);
        sum[0] += reading * along[0];
        sum[1] += reading * along[1];
    }
    sum
}

/// What the second program says of a life, cycle by cycle.
fn witnessed(witness: &Witness<'_>, model: Model, life: &[Cycle]) -> Vec<Vec<f64>> {
    let floors: Vec<_> = life.iter().map(|cycle| witness.floor(cycle.poses[0])).collect();
    let messages: Vec<_> = life.iter().map(|cycle| witness.messages(&cycle.poses)).collect();
    let each = life.iter().enumerate().map(|(step, cycle)| {
        let (near, bright) = (witness.proximity(&cycle.poses), witness.light(&cycle.poses));
        let votes = floors[(step + 1).saturating_sub(5)..=step].iter().flatten();
        let black = votes.clone().filter(|grey| **grey < 0.03).count();
        let white = votes.filter(|grey| **grey > 0.85).count();
        let ground = [0.41, 0.34, 0.42].map(|grey| match (black, white) {
            (11.., _) => 0.0,
            (_, 11..) => 1.0,
            _ => grey,
        });
        let neighbours = 1.0 - 2.0 / (1.0 + f64::from(messages[step].0).exp());
        let mut v = [0.0; 2];
        for (_, sum) in &messages[(step + 1).saturating_sub(11)..=step] {
            v[0] += sum[0];
            v[1] += sum[1];
        }
        let length = v[0].hypot(v[1]).max(1e-9);
        match model {
            Model::Rm11 => {
                let short = (2.0 / (1.0 + (-length).exp()) - 1.0) / length;
                let attraction = quarters(v.map(|part| short * part));
                [&near[..], &bright, &ground, &[neighbours], &attraction].concat()
            }
            Model::Rm12 => {
                let sum = sum_of(near);
                let near = quarters(sum.map(|part| part / sum[0].hypot(sum[1]).max(1.0)));
                let sum = sum_of(bright);
                let is_bright = bright.iter().any(|reading| *reading > 0.2);
                let share = if is_bright { 1.0 / sum[0].hypot(sum[1]) } else { 0.0 };
                let bright = quarters(sum.map(|part| share * part));
                [&near[..], &bright, &ground[..1], &[neighbours], &quarters(v)].concat()
            }
            Model::Vectors => {
                let floor = match (black, white) {
                    (11.., _) => 0.0,
                    (_, 11..) => 1.0,
                    _ => 0.5,
                };
                let number = f64::from(messages[step].0);
                [&sum_of(near)[..], &sum_of(bright), &[floor, number], &v].concat()
            }
        }
    });
    each.collect()
}

/// The share of readings that are off by more than 0.002, of cycles in which something changes suddenly: an edge of the floor, of a
/// body or of a shadow between two roundings.
fn off(model: Model, bodies_hide: bool) -> f64 {
    let spec = spec(model, QUIET, 20, arena());
    let arena = spec.arena.clone();
    let world = World::new(spec).unwrap();
    let witness = Witness {
        segments: segments(&arena),
        sides: arena.sides,
        arena: &arena,
        range: 700.0,
        bodies_hide,
    };
    assert_eq!(witness.sides, 12);
    let (mut all, mut wrong) = (0, 0);
    for life in lived(&world, 40) {
        for (cycle, expected) in life.iter().zip(witnessed(&witness, model, &life)) {
            assert_eq!(cycle.readings.len(), expected.len());
            for (index, (found, expected)) in cycle.readings.iter().zip(&expected).enumerate() {
                all += 1;
                if (found - expected).abs() > 0.002 {
                    wrong += 1;
                    if std::env::var_os("ONEIRO_WITNESS").is_some() && bodies_hide {
                        println!("{model:?} reading {index}: {found} {expected}");
                    }
                }
            }
        }
    }
    f64::from(wrong) / f64::from(all)
}

#[test]
fn readings_are_those_of_the_second_program() {
    for model in [Model::Rm11, Model::Rm12, Model::Vectors] {
        let own = off(model, true);
        assert!(own < 3e-4, "{model:?}: {own} of the readings are off");
        // Bodies that hide nothing are seen at once.
        let control = off(model, false);
        assert!(control > 0.01, "{model:?}: {control}");
    }
}

fn mean_and_deviation(numbers: &[f64]) -> [f64; 2] {
    let count = numbers.len() as f64;
    let mean = numbers.iter().sum::<f64>() / count;
    let variance = numbers.iter().map(|number| (number - mean).powi(2)).sum::<f64>() / count;
    [mean, variance.sqrt()]
}

#[test]
fn noise_has_its_distributions() {
    let noisy = Reference {
        signal_range: Some(1e4),
        ..Reference::DEFAULT
    };
    let mut spec = spec(
        Model::Rm11,
        noisy,
        2,
        Arena::polygon(
            &[[-500.0, -500.0], [500.0, -500.0], [500.0, 500.0], [-500.0, 500.0]],
            None,
        ),
    );
    spec.cycles = 400;
    spec.arena.floor = Some(0.498);
    let world = World::new(spec).unwrap();
    let lives = lived(&world, 60);
    let cycles: Vec<_> = lives.iter().flatten().collect();
    // A wheel's speed over what was commanded, where that is not near 0.
    let slips = |wheel: usize| {
        let each = cycles.iter().filter_map(move |cycle| {
            let commanded = 2.0 * cycle.outputs[wheel] - 1.0;
            (commanded.abs() > 0.2).then(|| cycle.speeds[wheel] / commanded - 1.0)
        });
        each.collect::<Vec<_>>()
    };
    for wheel in [0, 1] {
        let slips = slips(wheel);
        let [mean, deviation] = mean_and_deviation(&slips);
        assert!(
            slips.len() > 10_000 && mean.abs() < 0.0015 && (deviation - 0.05).abs() < 0.001,
            "{mean} {deviation}"
        );
        // Normal: 4.55 % are beyond two deviations, where a uniform distribution has none.
        let far = slips.iter().filter(|slip| slip.abs() > 0.1).count() as f64 / slips.len() as f64;
        assert!((far - 0.0455).abs() < 0.006, "{far}");
    }
    // One neighbour in sight, heard in 15 of 100 cycles.
    let heard = cycles.iter().filter(|cycle| cycle.readings[19] > 0.3).count() as f64 / cycles.len() as f64;
    assert!((heard - 0.15).abs() < 0.01, "{heard}");
    // No lamp: half of the readings of light are noise from 0 to 0.05.
    let dark: Vec<_> = cycles.iter().map(|cycle| cycle.readings[8]).collect();
    let lit: Vec<_> = dark.iter().copied().filter(|reading| *reading > 0.0).collect();
    let [mean, _] = mean_and_deviation(&lit);
    assert!(
        (mean - 0.025).abs() < 0.0005 && lit.iter().all(|reading| *reading <= 0.05),
        "{mean}"
    );
    assert!((lit.len() as f64 / dark.len() as f64 - 0.5).abs() < 0.015);
    for (reading, mean, deviation) in [(16, 0.41, 0.18), (17, 0.34, 0.12), (18, 0.42, 0.18)] {
        let greys: Vec<_> = cycles.iter().map(|cycle| cycle.readings[reading]).collect();
        let found = mean_and_deviation(&greys);
        assert!(
            (found[0] - mean).abs() < 0.005 && (found[1] - deviation).abs() < 0.005,
            "{found:?}"
        );
    }
}

/// The described robot of a world.
fn robot(spec: &mut WorldSpec) -> &mut Differential {
    match &mut spec.robot.build {
        Build::Differential(own) => own,
        _ => unreachable!(),
    }
}

/// A change of a world.
type Change<'a> = &'a dyn Fn(&mut WorldSpec);

#[test]
fn what_does_not_fit_is_refused() {
    let refused = |change: Change<'_>| {
        let mut spec = spec(Model::Rm12, Reference::DEFAULT, 20, arena());
        change(&mut spec);
        World::new(spec).unwrap_err().to_string()
    };
    let cases: [(Change<'_>, &str); 9] = [
        (
            &|spec| robot(spec).count = None,
            "robot.model: is given; allowed: only with robot.count",
        ),
        (
            &|spec| {
                robot(spec).model = None;
                robot(spec).reference.signal_loss = Some(0.5);
            },
            "robot.signal_loss: is given; allowed: only with robot.model",
        ),
        (
            &|spec| robot(spec).model = None,
            "arena.wall_height_mm: is given; allowed: only with robot.model",
        ),
        (
            &|spec| robot(spec).reference.signal_loss = Some(1.5),
            "robot.signal_loss: is 1.5; allowed: 0 to 1",
        ),
        (
            &|spec| robot(spec).wheel_noise = None,
            "robot.wheel_noise_law: is given; allowed: only with robot.wheel_noise",
        ),
        (
            &|spec| robot(spec).wheel_noise = Some(0.45),
            "robot.greatest_speed_mm_s: robots move",
        ),
        (
            &|spec| spec.arena.walls.swap(1, 2),
            "arena.corners_mm: has a corner on the other side",
        ),
        (
            &|spec| spec.arena = Arena::polygon(&[[0.0, 0.0], [0.0, 900.0], [900.0, 0.0]], Some(100.0)),
            "arena.corners_mm: has a corner on the other side",
        ),
        (
            &|spec| spec.arena = dodecagon(1226.0, 1200.0).starting_within([0.0, 0.0], 1300.0),
            "arena.start_radius_mm: is 1300; allowed: up to 1226",
        ),
    ];
    for (change, expected) in cases {
        let found = refused(change);
        assert!(found.starts_with(expected), "{found:?}, not {expected:?}");
    }
}
