//! The on-board simulator of a foraging e-puck: its behaviour and its limits, its light, and the same bits everywhere.

use oneiro::batch::{Batch, Outcome, Record, Rollout, Trace, TraceRequest, Worlds};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::foraging::{Details, Foraging, Light};
use oneiro::random::{Key, pcg4d};

/// Behaviours as traces number them.
const FLEE_LIGHT: f32 = 0.0;
const SEARCH: f32 = 1.0;
const SEEK_LIGHT: f32 = 2.0;
const AVOID: f32 = 3.0;

const SCENARIOS: [Light; 3] = [Light::OverNest, Light::Nowhere, Light::OppositeNest];

fn batch(foragers: &[Foraging], genomes: &[[f32; 2]], every: u32) -> Batch {
    let rollouts: Vec<_> = genomes
        .iter()
        .zip(0..)
        .map(|(genes, life)| Rollout {
            world: life % foragers.len(),
            genes,
            key: Key::rollout(1, 0, life as u64, 0),
        })
        .collect();
    let trace = (every > 0).then_some(TraceRequest { every });
    Worlds::new(foragers).unwrap().batch(&rollouts, trace).unwrap()
}

fn evaluated(evaluator: &mut dyn Evaluator, batch: &Batch) -> Outcome {
    evaluator.evaluate(batch, &Control::new()).unwrap()
}

fn lived(foragers: &[Foraging], genomes: &[[f32; 2]], every: u32) -> Outcome {
    evaluated(&mut Cpu::new(None).unwrap(), &batch(foragers, genomes, every))
}

/// Genes from 0 to 0.99 in hundredths.
fn genomes(count: u32) -> Vec<[f32; 2]> {
    (0..count)
        .map(|life| {
            let [a, b, ..] = pcg4d([life, 0, 0, 2014]);
            [a, b].map(|word| (word % 100) as f32 / 100.0)
        })
        .collect()
}

/// All lane codes agree, including the one that traps NaN, infinities and subnormals, with lives cut anywhere, and so
/// does the first adapter.
#[test]
fn all_devices_agree_to_the_last_bit() {
    let mut foragers: Vec<Foraging> = SCENARIOS.map(Foraging::odowd2014).into();
    foragers.push(Foraging {
        light_noise: 0.0,
        wheel_noise: 0.0,
        food_items: 8,
        escape: 0.0,
        start: Some([100.0, -50.0, 0.3]),
        ..foragers[0]
    });
    agree(&foragers);
}

/// The same with more food than eight items, which has another kernel.
#[test]
fn all_devices_agree_about_many_items() {
    let food = |food_items| Foraging {
        food_items,
        ..Foraging::odowd2014(Light::OverNest)
    };
    agree(&[9, 28, 64].map(food));
    // Each eight of them is found.
    let mean = |items| lived(&[food(items)], &genomes(6000), 0).fitness.iter().sum::<f32>() / 6000.0;
    let means = [8, 16, 24, 32, 40, 48, 56, 64].map(mean);
    println!("mean fitness with 8 to 64 items: {means:?}");
    assert!(means.is_sorted_by(|few, many| few < many), "{means:?}");
}

fn agree(foragers: &[Foraging]) {
    let batch = batch(foragers, &genomes(600), 7);
    let scalar = || Cpu::new(Some(1)).unwrap().with_variant("scalarx1").unwrap();
    let expected = evaluated(&mut scalar(), &batch);
    assert!(expected.fitness.iter().any(|&fitness| fitness > 0.0));
    let check = |name: &str, evaluator: &mut dyn Evaluator| {
        let found = evaluated(evaluator, &batch);
        let bits = |outcome: &Outcome| outcome.fitness.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&found), bits(&expected), "{name}");
        assert_eq!(found.traces, expected.traces, "{name}");
    };
    for variant in Cpu::variants() {
        let mut cpu = Cpu::new(Some(2)).unwrap().with_variant(variant).unwrap();
        check(variant, &mut cpu);
    }
    check("cut lives", &mut scalar().with_chunk(7));
    #[cfg(feature = "gpu")]
    {
        let mut gpu = oneiro::gpu::Gpu::open(&oneiro::gpu::Choice::Best).expect("these tests need an adapter");
        check("gpu", &mut gpu);
    }
}

/// A constant that differs in its last place is detected, so the test above can fail.
#[test]
fn one_constant_changed_by_one_ulp_is_seen() {
    let one = Foraging::odowd2014(Light::OverNest);
    let other = Foraging {
        cruise: one.cruise.next_up(),
        ..one
    };
    let fitness = |forager| lived(&[forager], &genomes(500), 0).fitness;
    assert_ne!(fitness(one), fitness(other));
}

/// No robot leaves the arena or exceeds its wheels' speed, food is taken and delivered only where allowed, and it earns
/// the time that remains.
#[test]
fn food_and_motion_have_their_causes() {
    let forager = Foraging::odowd2014(Light::OverNest);
    let outcome = lived(&[forager], &genomes(300), 1);
    let room = forager.arena_radius - forager.body_radius;
    let fastest = 0.1 * forager.greatest_speed * (1.0 + forager.wheel_noise) * 1.0001;
    let (mut taken, mut brought) = (0, 0);
    for (trace, &fitness) in outcome.traces.iter().zip(&outcome.fitness) {
        let mut total = 0.0;
        for (cycle, pair) in trace.windows(2).enumerate() {
            let [now, next] = [&pair[0], &pair[1]];
            let carries = |cycle: usize| trace.details_as::<Details>(cycle).carries > 0.0;
            let (carried, carries) = (carries(cycle), carries(cycle + 1));
            assert!(next.x.hypot(next.y) <= room, "{next:?}");
            assert!((next.x - now.x).hypot(next.y - now.y) <= fastest, "{now:?} {next:?}");
            let from_nest = (next.x + forager.arena_radius).hypot(next.y);
            match (carried, carries) {
                (false, true) => taken += 1,
                (true, false) => {
                    brought += 1;
                    assert!(from_nest < forager.nest_radius, "{next:?}");
                    let left = 60.0 - 0.1 * (cycle as f32 + 1.0);
                    assert!((now.reward - left).abs() < 1e-4, "{} for {left} s", now.reward);
                }
                (true, true) => assert!(from_nest >= forager.nest_radius, "{next:?}"),
                (false, false) => (),
            }
            if carried == carries {
                assert_eq!(now.reward, 0.0);
            }
            total += now.reward;
        }
        assert!((total + trace.last().unwrap().reward - fitness).abs() < 1e-2);
        assert!(fitness >= 0.0);
    }
    assert!(taken > 200 && brought > 100, "{taken} items taken, {brought} brought");
}

/// Table 1: genes act by thirds of their hundredths, each in its own food state; obstacle avoidance takes precedence.
#[test]
fn genes_select_behaviours_by_the_food_state() {
    let values = [
        (0.0, FLEE_LIGHT),
        (0.32, FLEE_LIGHT),
        (0.33, SEARCH),
        (0.65, SEARCH),
        (0.66, SEEK_LIGHT),
        (0.99, SEEK_LIGHT),
    ];
    let forager = Foraging::odowd2014(Light::OverNest);
    for (with, expected_with) in values {
        for (without, expected_without) in values {
            let outcome = lived(&[forager], &[[with, without]; 20], 1);
            let mut avoided = 0;
            let details = |trace: &Trace| (0..trace.len()).map(|record| trace.details_as(record)).collect();
            for record in outcome
                .traces
                .iter()
                .flat_map(|trace| -> Vec<Details> { details(trace) })
            {
                let expected = if record.carries > 0.0 {
                    expected_with
                } else {
                    expected_without
                };
                let near = [record.front_0, record.front_1, record.front_2, record.front_3]
                    .into_iter()
                    .fold(0.0, f32::max)
                    > 235.0 / 4095.0;
                assert!(record.behaviour == expected || record.behaviour == AVOID, "{record:?}");
                assert!(!near || record.behaviour == AVOID, "{record:?}");
                avoided += u32::from(near);
            }
            assert!(avoided > 0, "no robot of 20 came to the wall in a minute");
        }
    }
}

/// A robot's first movement by phototaxis, and the reading of its brightest sensor, computed in double precision from the documented
/// laws.
fn first_drive(forager: &Foraging, [x, y, heading]: [f64; 3], sign: f64) -> (f64, f64, f64) {
    let lamp = f64::from(forager.arena_radius + forager.lamp_behind_wall);
    let lamp_x = if forager.light == Light::OverNest { -lamp } else { lamp };
    let turn = 2.0 * std::f64::consts::PI;
    let (mut ahead, mut aside, mut brightest) = (0.0, 0.0, 0.0_f64);
    for degrees in [17.0_f64, 50.0, 90.0, 150.0, 210.0, 270.0, 310.0, 343.0] {
        let bearing = degrees.to_radians();
        let axis = turn * heading + bearing;
        let (sensor_x, sensor_y) = (x + 35.0 * axis.cos(), y + 35.0 * axis.sin());
        let (to_x, to_y) = (lamp_x - sensor_x, -sensor_y);
        let off = (to_y.atan2(to_x) - axis + std::f64::consts::PI).rem_euclid(turn) - std::f64::consts::PI;
        let shine = (-2.0 * to_x.hypot(to_y) / 1000.0).exp() * (1.0 - 2.0 * off.abs() / std::f64::consts::PI).max(0.0);
        let seen = (shine + 0.1).clamp(0.0, 1.0);
        ahead += seen * bearing.cos();
        aside += seen * bearing.sin();
        brightest = brightest.max(seen);
    }
    let off = (sign * aside).atan2(sign * ahead);
    let forward = 80.0 * off.cos().max(0.0);
    let turned = (3.0 * off).clamp(-2.4, 2.4);
    // Limit of the wheels.
    let wheels = [-1.0, 1.0].map(|side| (forward + side * 0.5 * 53.0 * turned).clamp(-128.8, 128.8));
    (
        0.05 * (wheels[0] + wheels[1]),
        0.1 * (wheels[1] - wheels[0]) / 53.0 / turn,
        brightest,
    )
}

#[test]
fn phototaxis_follows_its_law() {
    let moved = |forager: Foraging, gene: f32| -> Record { lived(&[forager], &[[gene; 2]], 1).traces[0][1] };
    for light in [Light::OverNest, Light::OppositeNest] {
        for index in 0..40 {
            let start = [
                -300.0 + 15.0 * index as f32,
                203.0 - 10.0 * index as f32,
                0.025 * (index * 7 % 40) as f32,
            ];
            let forager = Foraging {
                light,
                light_noise: 0.0,
                wheel_noise: 0.0,
                food_items: 0,
                start: Some(start),
                cycles: 2,
                ..Foraging::odowd2014(light)
            };
            for (gene, sign) in [(0.99, 1.0), (0.0, -1.0)] {
                let (forward, turned, _) = first_drive(&forager, start.map(f64::from), sign);
                let next = moved(forager, gene);
                let mean = 2.0 * std::f64::consts::PI * (f64::from(start[2]) + 0.5 * turned);
                let expected = [
                    f64::from(start[0]) + forward * mean.cos(),
                    f64::from(start[1]) + forward * mean.sin(),
                    (f64::from(start[2]) + turned).rem_euclid(1.0),
                ];
                for (found, expected) in [next.x, next.y, next.heading].into_iter().zip(expected) {
                    let off = (f64::from(found) - expected).abs();
                    assert!(
                        off < 1e-3 || (off - 1.0).abs() < 1e-3,
                        "{start:?}, gene {gene}: {found}, not {expected}"
                    );
                }
            }
        }
    }
}

/// Phototaxis acts from its threshold on, by the brightest sensor.
#[test]
fn phototaxis_gives_way_below_its_threshold() {
    for index in 0..40 {
        let start = [
            -300.0 + 15.0 * index as f32,
            203.0 - 10.0 * index as f32,
            0.025 * (index * 7 % 40) as f32,
        ];
        let base = Foraging {
            light_noise: 0.0,
            start: Some(start),
            cycles: 2,
            near: 0.0,
            ..Foraging::odowd2014(Light::OppositeNest)
        };
        let (.., brightest) = first_drive(&base, start.map(f64::from), 1.0);
        for (off, gene, expected) in [
            (-1e-3, 0.99, SEEK_LIGHT),
            (-1e-3, 0.0, FLEE_LIGHT),
            (1e-3, 0.99, SEARCH),
            (1e-3, 0.0, SEARCH),
        ] {
            let forager = Foraging {
                phototaxis_threshold: (brightest + off) as f32,
                ..base
            };
            let trace = &lived(&[forager], &[[gene; 2]], 1).traces[0];
            let found = trace.details_as::<Details>(0).behaviour;
            assert_eq!(found, expected, "{start:?}, {off} from {brightest}, gene {gene}");
        }
    }
}

/// In darkness no sensor reads 0.16: what controllers would do with light makes no difference then, to the last bit.
#[test]
fn with_a_threshold_all_controllers_search_alike_in_darkness() {
    let genomes = genomes(40);
    let all = |light: Light, threshold: f32, genomes: &[[f32; 2]]| {
        let forager = Foraging {
            phototaxis_threshold: threshold,
            ..Foraging::odowd2014(light)
        };
        lived(&[forager], genomes, 1).traces
    };
    let searching = vec![[0.495; 2]; genomes.len()];
    let dark = all(Light::Nowhere, 0.16, &genomes);
    assert!(dark == all(Light::Nowhere, 0.16, &searching));
    // Controls: without the threshold, and with a lamp, they differ.
    assert!(all(Light::Nowhere, 0.0, &genomes) != all(Light::Nowhere, 0.0, &searching));
    assert!(all(Light::OverNest, 0.16, &genomes) != all(Light::OverNest, 0.16, &searching));
}

/// Straight ahead for 3 s on average, followed by a turn of up to 90 degrees to either side.
#[test]
fn random_search_turns_as_often_and_as_far_as_said() {
    let forager = Foraging {
        arena_radius: 10_000.0,
        cycles: 6_000,
        ..Foraging::odowd2014(Light::Nowhere)
    };
    let outcome = lived(&[forager], &[[0.5; 2]; 100], 1);
    let (mut straight, mut turns, mut turned) = (0_u32, 0_u32, 0.0);
    for trace in &outcome.traces {
        let is_turning = |record: &Record| (record.speed_right - record.speed_left).abs() > 0.3;
        let searches = |record: usize| trace.details_as::<Details>(record).behaviour == SEARCH;
        for (first, pair) in trace.windows(2).enumerate() {
            if !searches(first) || !searches(first + 1) {
                continue;
            }
            straight += u32::from(!is_turning(&pair[0]));
            turns += u32::from(!is_turning(&pair[0]) && is_turning(&pair[1]));
            if is_turning(&pair[0]) {
                let turn = pair[1].heading - pair[0].heading;
                turned += (turn - (turn + 0.5).floor()).abs();
            }
        }
    }
    // 3 s, less half a cycle that is cut off on average; turns too short to distinguish from noise aren't counted.
    let seconds = 0.1 * f64::from(straight) / f64::from(turns);
    assert!((2.8..3.6).contains(&seconds), "a turn each {seconds} s");
    let degrees = 360.0 * f64::from(turned) / f64::from(turns);
    assert!((40.0..52.0).contains(&degrees), "by {degrees} degrees on average");
}

/// A sanity check of the arena, and no more: with the light over the nest, robots that seek it with food and flee it
/// without bring more food than robots that search at random.
#[test]
fn light_over_the_nest_helps() {
    let forager = Foraging::odowd2014(Light::OverNest);
    let mean = |genes| {
        let fitness = lived(&[forager], &[genes; 2_000], 0).fitness;
        fitness.iter().map(|&f| f64::from(f)).sum::<f64>() / 2_000.0
    };
    let (guided, random) = (mean([0.99, 0.0]), mean([0.5, 0.5]));
    assert!(guided > 1.2 * random, "{guided}, at random {random}");
}

#[test]
fn invalid_values_are_refused_by_name() {
    let good = Foraging::odowd2014(Light::OverNest);
    for (field, wrong) in [
        ("arena.food_items", Foraging { food_items: 65, ..good }),
        ("cycles", Foraging { cycles: 0, ..good }),
        ("robot.cruise_mm_s", Foraging { cruise: 200.0, ..good }),
        ("robot.near_mm", Foraging { near: f32::NAN, ..good }),
        (
            "start",
            Foraging {
                start: Some([590.0, 0.0, 0.0]),
                ..good
            },
        ),
        (
            "start",
            Foraging {
                start: Some([f32::NAN, 0.0, 0.0]),
                ..good
            },
        ),
        (
            "arena.nest_radius_mm",
            Foraging {
                nest_radius: 700.0,
                ..good
            },
        ),
    ] {
        let invalid = Worlds::new(&[good, wrong]).unwrap_err();
        assert_eq!(invalid.field, format!("worlds[1].{field}"));
        assert!(invalid.problem.contains("; allowed"), "{invalid}");
    }
    assert!(Worlds::new::<Foraging>(&[]).is_err());
    let worlds = Worlds::new(&[good]).unwrap();
    let rollout = Rollout {
        world: 0,
        genes: &[0.5; 3],
        key: Key::default(),
    };
    assert_eq!(worlds.batch(&[rollout], None).unwrap_err().field, "rollouts[0].genes");
}
