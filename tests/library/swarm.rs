//! The arena of a swarm: limits of its robots, their interactions, and the same bits everywhere.

use oneiro::batch::{Rollout, Trace, TraceRequest, Worlds};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::foraging::{Details, Foraging, GREATEST_ITEMS, Light};
use oneiro::random::Key;
use oneiro::swarm::{Arena, Behaviour, Differences, Lamp, Line, Order, Seen, Simulated, Swarm, World};

#[cfg(feature = "compose")]
mod driven;

/// Genes that seek the light with food and flee it without.
const GOOD: [f32; 2] = [0.99, 0.0];

fn worlds(count: usize, lamp: Lamp) -> Vec<World> {
    (0..count)
        .map(|index| World {
            swarm: 0,
            lamp,
            key: Key::rollout(1, 0, index as u64, 0),
        })
        .collect()
}

fn always(genes: [f32; 2], robots: u32, worlds: usize) -> Vec<Vec<Order>> {
    vec![vec![Order::always(genes); robots as usize]; worlds]
}

fn lived(evaluator: &mut dyn Evaluator, swarm: Swarm, worlds: &[World], genes: [f32; 2], until: u32) -> Vec<Vec<Line>> {
    let control = Control::new();
    let mut arena = Simulated::new(evaluator, &control, &[swarm], worlds).unwrap();
    let orders = always(genes, swarm.robots, worlds.len());
    arena.live(until, &orders, 10).unwrap()
}

#[test]
fn all_devices_agree_to_the_last_bit() {
    let swarm = Swarm::odowd2014(10);
    let worlds = worlds(20, Lamp::fixed(Light::OverNest));
    let expected = lived(
        &mut Cpu::new(Some(1)).unwrap().with_variant("scalarx1").unwrap(),
        swarm,
        &worlds,
        GOOD,
        600,
    );
    let total: u32 = expected
        .iter()
        .flatten()
        .flat_map(|line| &line.robots)
        .map(|r| r.brought)
        .sum();
    println!("{total} brought in {} robot-minutes", 200);
    for variant in Cpu::variants() {
        let mut cpu = Cpu::new(Some(2)).unwrap().with_variant(variant).unwrap();
        assert_eq!(lived(&mut cpu, swarm, &worlds, GOOD, 600), expected, "{variant}");
    }
    #[cfg(feature = "gpu")]
    {
        let mut gpu = oneiro::gpu::Gpu::open(&oneiro::gpu::Choice::Best).expect("these tests need an adapter");
        assert_eq!(lived(&mut gpu, swarm, &worlds, GOOD, 600), expected, "gpu");
    }
}

/// Swarms of 5 to 40 robots with the paper's food for each, at its density or in its arena, and one with all the food that there can be.
fn with_food_for_all() -> [Swarm; 5] {
    let swarm = |robots: u32, radius: f32, food_items: u32| {
        let swarm = Swarm::odowd2014(robots);
        let forager = Foraging {
            arena_radius: radius,
            food_items,
            ..swarm.forager
        };
        Swarm { forager, ..swarm }
    };
    [
        swarm(5, 424.0, 4),
        swarm(12, 600.0, 9),
        swarm(20, 849.0, 14),
        swarm(40, 1200.0, 28),
        swarm(40, 600.0, GREATEST_ITEMS),
    ]
}

/// The same lives on all devices with more food than eight items, and all of it is taken now and then.
#[test]
fn food_for_all_has_the_same_bits_on_all_devices() {
    let swarms = with_food_for_all();
    let worlds: Vec<World> = (0..swarms.len())
        .map(|index| World {
            swarm: index,
            lamp: Lamp::fixed(Light::OverNest),
            key: Key::rollout(3, 0, index as u64, 0),
        })
        .collect();
    let orders: Vec<Vec<Order>> = worlds
        .iter()
        .map(|world| vec![Order::always(SEARCH); swarms[world.swarm].robots as usize])
        .collect();
    let lived = |evaluator: &mut dyn Evaluator| {
        let control = Control::new();
        let mut arena = Simulated::new(evaluator, &control, &swarms, &worlds).unwrap();
        let first = arena.live(200, &orders, 10).unwrap();
        let then = arena.live(400, &orders, 10).unwrap();
        first
            .into_iter()
            .zip(then)
            .map(|(a, b)| [a, b].concat())
            .collect::<Vec<_>>()
    };
    let expected = lived(&mut Cpu::new(Some(1)).unwrap().with_variant("scalarx1").unwrap());
    let mut counts = [0, 0];
    for (world, lines) in worlds.iter().zip(&expected) {
        let items = swarms[world.swarm].forager.food_items as usize;
        assert!(lines.iter().all(|line| line.food.len() == items));
        let is_taken = |item: &usize| lines.windows(2).any(|pair| pair[0].food[*item] != pair[1].food[*item]);
        let taken: Vec<usize> = (0..items).filter(is_taken).collect();
        counts[0] += taken.len();
        counts[1] += items;
        assert!(
            items < 64 || taken.iter().any(|&item| item > 55),
            "no item of the last eight was taken"
        );
    }
    let [taken, items] = counts;
    assert!(3 * taken > items, "{taken} of {items} items were taken in 40 s");
    for variant in Cpu::variants() {
        let mut cpu = Cpu::new(Some(2)).unwrap().with_variant(variant).unwrap();
        assert_eq!(lived(&mut cpu), expected, "{variant}");
    }
    #[cfg(feature = "gpu")]
    {
        let mut gpu = oneiro::gpu::Gpu::open(&oneiro::gpu::Choice::Best).expect("these tests need an adapter");
        assert_eq!(lived(&mut gpu), expected, "gpu");
    }
}

/// With food for each robot, robots of a crowd in an arena that grows with it bring as much as the paper's ten; with seven items for
/// all they bring less.
#[test]
fn robots_starve_without_food_for_all() {
    let rate = |robots: u32, items: u32| {
        let swarm = Swarm::odowd2014(robots);
        let forager = Foraging {
            arena_radius: swarm.forager.arena_radius * (robots as f32 / 10.0).sqrt(),
            food_items: items,
            ..swarm.forager
        };
        let lines = over_nest(Swarm { forager, ..swarm }, SEARCH, 16, 1800);
        let brought: u32 = lines
            .iter()
            .flatten()
            .flat_map(|line| &line.robots)
            .map(|own| own.brought)
            .sum();
        f64::from(brought) / f64::from(16 * 3 * robots)
    };
    let [few, enough] = [7, 28].map(|items| rate(40, items));
    println!(
        "40 robots bring {few:.3} items a robot-minute with 7 items, {enough:.3} with 28; 10 with 7 {:.3}",
        rate(10, 7)
    );
    assert!(enough > 1.5 * few, "{enough}, {few}");
}

const SEARCH: [f32; 2] = [0.5, 0.5];
const CONTROLLERS: [[f32; 2]; 4] = [GOOD, SEARCH, [0.99, 0.99], [0.0, 0.0]];

/// Every cycle of some worlds, on this machine's processor.
fn watched(swarm: Swarm, worlds: &[World], orders: &[Vec<Order>], until: u32) -> Vec<Vec<Line>> {
    let mut cpu = Cpu::new(None).unwrap();
    let control = Control::new();
    let mut arena = Simulated::new(&mut cpu, &control, &[swarm], worlds).unwrap();
    arena.live(until, orders, 1).unwrap()
}

/// Every cycle of some worlds with the lamp over the nest and one controller for all robots.
fn over_nest(swarm: Swarm, genes: [f32; 2], count: usize, until: u32) -> Vec<Vec<Line>> {
    let orders = always(genes, swarm.robots, count);
    watched(swarm, &worlds(count, Lamp::fixed(Light::OverNest)), &orders, until)
}

/// In darkness no sensor in the arena reads 0.16 either: No Light is Random Movement there, whatever controllers evolve.
#[test]
fn with_a_threshold_all_controllers_search_alike_in_darkness() {
    let dark = |threshold: f32, light: Light, genes: [f32; 2]| {
        let mut swarm = Swarm::odowd2014(10);
        swarm.forager.phototaxis_threshold = threshold;
        let orders = always(genes, swarm.robots, 3);
        watched(swarm, &worlds(3, Lamp::fixed(light)), &orders, 300)
    };
    let searching = dark(0.16, Light::Nowhere, SEARCH);
    for genes in CONTROLLERS {
        assert_eq!(dark(0.16, Light::Nowhere, genes), searching, "{genes:?}");
    }
    // Controls: they differ without the threshold, and with a lamp.
    assert_ne!(dark(0.0, Light::Nowhere, GOOD), searching);
    assert_ne!(dark(0.16, Light::OverNest, GOOD), dark(0.16, Light::OverNest, SEARCH));
}

fn apart(one: &Seen, other: &Seen) -> f32 {
    (one.x - other.x).hypot(one.y - other.y)
}

fn distance(robot: &Seen, [x, y]: [f32; 2]) -> f32 {
    (robot.x - x).hypot(robot.y - y)
}

fn from_nest(swarm: &Swarm, [x, y]: [f32; 2]) -> f32 {
    (x + swarm.forager.arena_radius).hypot(y)
}

fn mean_and_error(sample: &[f64]) -> (f64, f64) {
    let count = sample.len() as f64;
    let mean = sample.iter().sum::<f64>() / count;
    let variance = sample.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}

/// Robots that see nothing in front of them and drive into each other and the wall; others seldom touch anything.
fn blind(robots: u32) -> Swarm {
    let swarm = Swarm::odowd2014(robots);
    let forager = Foraging {
        near: 0.0,
        ..swarm.forager
    };
    Swarm { forager, ..swarm }
}

/// Greatest distance that wheels move a robot in a cycle: no wheel is commanded faster than cruising, plus noise and
/// three standard deviations of both wheels' gains, which are never exceeded.
fn farthest_way(swarm: &Swarm) -> f32 {
    let forager = &swarm.forager;
    0.1 * forager.cruise * (1.0 + forager.wheel_noise) * (1.0 + 3.0 * swarm.differences.wheels)
}

#[test]
fn no_robot_is_ever_outside_the_wall() {
    for robots in [10, 60] {
        for (swarm, comes_to_it) in [(Swarm::odowd2014(robots), false), (blind(robots), true)] {
            let room = swarm.forager.arena_radius - swarm.forager.body_radius;
            for genes in CONTROLLERS {
                let worlds = over_nest(swarm, genes, 4, 600);
                let farthest = worlds
                    .iter()
                    .flatten()
                    .flat_map(|line| &line.robots)
                    .map(|robot| robot.x.hypot(robot.y))
                    .fold(0.0, f32::max);
                // Allows for a few roundings of one number.
                assert!(farthest <= room * (1.0 + 4.0 * f32::EPSILON), "{genes:?}: {farthest}");
                assert!(
                    !comes_to_it || farthest > room - 0.01,
                    "{genes:?}: nobody came to the wall"
                );
            }
        }
    }
}

/// Greatest overlap of two bodies.
fn greatest_overlap(swarm: &Swarm, worlds: &[Vec<Line>]) -> f32 {
    let overlap = |robots: &[Seen]| {
        let pairs = robots
            .iter()
            .enumerate()
            .flat_map(|(index, one)| robots[..index].iter().map(move |other| (one, other)));
        let nearest = pairs.map(|(one, other)| apart(one, other)).fold(f32::MAX, f32::min);
        2.0 * swarm.forager.body_radius - nearest
    };
    worlds
        .iter()
        .flatten()
        .map(|line| overlap(&line.robots))
        .fold(0.0, f32::max)
}

/// Robots that see turn away before they touch, and a touching pair is separated at once. Robots that don't see press
/// on: in a queue at a wall, each gains 8.4 mm per cycle and loses, four times, half of the amount by which the overlap
/// in front of it exceeds the one behind it, so overlaps grow by 4.2 mm with each robot in the queue. Ten around one
/// point at the wall stand at most five deep, with four overlaps. Sixty press the innermost from all sides, but even
/// then no two come closer than a robot's travel per cycle, so none can pass through another.
#[test]
fn bodies_overlap_no_more_than_pushing_leaves() {
    for genes in CONTROLLERS {
        for robots in [10, 60] {
            let swarm = Swarm::odowd2014(robots);
            let seeing = greatest_overlap(&swarm, &over_nest(swarm, genes, 4, 600));
            assert!(seeing < 0.01, "{robots} robots, {genes:?}: {seeing} mm");
        }
        let few = greatest_overlap(&blind(10), &over_nest(blind(10), genes, 8, 1200));
        assert!(few < 4.0 * 4.2, "{genes:?}: {few} mm");
        let many = greatest_overlap(&blind(60), &over_nest(blind(60), genes, 4, 600));
        assert!(many < 70.0 - farthest_way(&blind(60)), "{genes:?}: {many} mm");
    }
    // Pushing is active.
    let pressed = greatest_overlap(&blind(60), &over_nest(blind(60), [0.99; 2], 4, 600));
    assert!(pressed > 5.0, "{pressed} mm");
}

/// A robot whose neighbours are out of reach goes where its wheels take it. One of two also gives way by half of their
/// previous overlap and of what they have driven into each other since.
#[test]
fn no_robot_moves_farther_than_wheels_and_neighbours_take_it() {
    let swarm = blind(10);
    let own = farthest_way(&swarm);
    let (mut alone, mut pairs, mut pushed) = (0, 0, 0);
    for lines in CONTROLLERS.map(|genes| over_nest(swarm, genes, 4, 600)).concat() {
        for pair in lines.windows(2) {
            let [before, after] = [&pair[0].robots, &pair[1].robots];
            // No robot comes from farther away, pushed or not.
            let reach = 70.0 + 6.0 * own;
            let neighbours = |robot: usize| -> Vec<usize> {
                (0..before.len())
                    .filter(|&other| other != robot && apart(&before[robot], &before[other]) < reach)
                    .collect()
            };
            for robot in 0..before.len() {
                let moved = apart(&before[robot], &after[robot]);
                match neighbours(robot)[..] {
                    [] => {
                        alone += 1;
                        assert!(moved <= own, "{moved} mm");
                    }
                    [other] if neighbours(other).len() == 1 => {
                        pairs += 1;
                        let overlap = (70.0 - apart(&before[robot], &before[other])).max(0.0);
                        assert!(moved <= 2.0 * own + 0.5 * overlap, "{moved} mm");
                        pushed += u32::from(moved > 1.01 * own);
                    }
                    _ => (),
                }
            }
        }
    }
    assert!(
        alone > 1_000 && pairs > 1_000 && pushed > 0,
        "{alone} alone, {pairs} in pairs, {pushed} pushed"
    );
}

/// Which robot may take which item, by position: each robot without food requests the first item within its reach, and
/// the nearest one that requests it gets it. `None` if rounding decides.
fn expected_takers(before: &Line, after: &Line, radius: f32) -> Option<Vec<(usize, usize)>> {
    let mut claims: Vec<Vec<(f32, usize)>> = vec![Vec::new(); before.food.len()];
    for (index, robot) in after.robots.iter().enumerate() {
        if before.robots[index].carries {
            continue;
        }
        let distances = before.food.iter().map(|&item| distance(robot, item));
        if distances.clone().any(|distance| (distance - radius).abs() < 1e-3) {
            return None;
        }
        if let Some((item, distance)) = distances.enumerate().find(|&(_, distance)| distance < radius) {
            claims[item].push((distance, index));
        }
    }
    let mut takers = Vec::new();
    for (item, mut own) in claims.into_iter().enumerate() {
        own.sort_by(|one, other| one.0.total_cmp(&other.0));
        if own.len() > 1 && own[1].0 - own[0].0 < 1e-3 {
            return None;
        }
        takers.extend(own.first().map(|&(_, robot)| (robot, item)));
    }
    Some(takers)
}

/// Forty robots, most of which compete with others for an item whenever food appears among them.
#[test]
fn the_nearer_of_two_robots_gets_an_item() {
    let ours = Swarm::odowd2014(40);
    let swarm = Swarm {
        forager: Foraging {
            food_radius: 120.0,
            ..ours.forager
        },
        differences: Differences {
            tracking_loss: 0.0,
            ..ours.differences
        },
        ..ours
    };
    let (mut taken, mut contested) = (0, 0);
    for lines in over_nest(swarm, [0.99, 0.5], 8, 600) {
        for pair in lines.windows(2) {
            let Some(takers) = expected_takers(&pair[0], &pair[1], swarm.forager.food_radius) else {
                continue;
            };
            let carriers: Vec<usize> = (0..40)
                .filter(|&robot| pair[1].robots[robot].carries && !pair[0].robots[robot].carries)
                .collect();
            let mut robots: Vec<usize> = takers.iter().map(|&(robot, _)| robot).collect();
            robots.sort_unstable();
            assert_eq!(carriers, robots);
            for (item, places) in pair[0].food.iter().zip(&pair[1].food).enumerate() {
                assert_eq!(places.0 != places.1, takers.iter().any(|&(_, other)| other == item));
            }
            taken += takers.len();
            for (_, item) in takers {
                let reach = |robot: &&Seen| distance(robot, pair[0].food[item]) < swarm.forager.food_radius;
                let without = |index: &usize| !pair[0].robots[*index].carries;
                let asking = (0..40).filter(without).filter(|&index| reach(&&pair[1].robots[index]));
                contested += u32::from(asking.count() > 1);
            }
        }
    }
    assert!(
        taken > 100 && contested > 20,
        "{taken} taken, {contested} by one of several"
    );
}

#[test]
fn food_is_conserved() {
    let mut crowd = Swarm::odowd2014(40);
    crowd.forager.food_items = 28;
    for swarm in [Swarm::odowd2014(10), blind(60), crowd] {
        let forager = &swarm.forager;
        let (mut taken, mut brought) = (0, 0);
        for lines in over_nest(swarm, [0.99, 0.5], 4, 900) {
            let (mut moved, mut here) = (0, 0);
            for pair in lines.windows(2) {
                let [before, after] = [&pair[0], &pair[1]];
                assert_eq!(after.food.len(), forager.food_items as usize);
                let gone: Vec<[f32; 2]> = before
                    .food
                    .iter()
                    .zip(&after.food)
                    .filter(|(old, new)| old != new)
                    .map(|(&old, _)| old)
                    .collect();
                moved += gone.len();
                for &[x, y] in &after.food {
                    assert!(x.hypot(y) <= forager.arena_radius * (1.0 + f32::EPSILON), "{x}, {y}");
                    assert!(from_nest(&swarm, [x, y]) >= forager.nest_radius - 1e-3, "{x}, {y}");
                }
                let mut gained = 0;
                for (old, new) in before.robots.iter().zip(&after.robots) {
                    match (old.carries, new.carries) {
                        (false, true) => {
                            gained += 1;
                            let nearest = gone.iter().map(|&item| distance(new, item)).fold(f32::MAX, f32::min);
                            assert!(nearest < forager.food_radius + 1e-3, "{nearest} mm from food");
                        }
                        (true, false) => {
                            let off = from_nest(&swarm, [new.x, new.y]);
                            assert!(off < forager.nest_radius + 1e-3, "{off} mm from the nest");
                        }
                        _ => (),
                    }
                    assert_eq!(new.brought, u32::from(old.carries && !new.carries));
                    here += new.brought;
                }
                assert_eq!(gained, gone.len());
            }
            let carried = |line: &Line| line.robots.iter().filter(|robot| robot.carries).count();
            let first = carried(&lines[0]);
            assert_eq!(here as usize + carried(lines.last().unwrap()), moved + first);
            taken += moved;
            brought += here;
        }
        assert!(taken > 30 && brought > 10, "{taken} taken, {brought} brought");
    }
}

/// Equation 1: food earns the time that remains of a robot's own interval, and each interval starts from zero.
#[test]
fn fitness_is_the_time_that_was_left() {
    let swarm = Swarm::odowd2014(10);
    let begins = |robot: usize| 100 + 37 * robot as u32;
    let orders: Vec<Order> = (0..10)
        .map(|robot| Order {
            begins: Some(begins(robot)),
            ..Order::always([0.99, 0.5])
        })
        .collect();
    let lamp = Lamp::fixed(Light::OverNest);
    let (mut in_time, mut late) = (0, 0);
    for lines in watched(swarm, &worlds(20, lamp), &vec![orders; 20], 1_200) {
        let mut expected = [(0.0, 0); 10];
        for (cycle, line) in (0..).zip(&lines) {
            for (robot, seen) in line.robots.iter().enumerate() {
                let (earned, since) = &mut expected[robot];
                if cycle == begins(robot) {
                    (*earned, *since) = (0.0, cycle);
                }
                if seen.brought > 0 {
                    let left = 60.0 - 0.1 * (cycle + 1 - *since) as f32;
                    *earned += left.max(0.0);
                    *if left > 0.0 { &mut in_time } else { &mut late } += 1;
                }
                assert!((seen.earned - *earned).abs() < 1e-3, "{seen:?}, not {earned}");
            }
        }
    }
    assert!(in_time > 50 && late > 10, "{in_time} in time, {late} late");
}

/// Half of the robots are switched on later; the others change their genes. Each does so exactly in its cycle.
#[test]
fn orders_take_effect_in_their_cycle() {
    let swarm = Swarm {
        heard: 1.0,
        ..Swarm::odowd2014(10)
    };
    let at = |robot: usize| 150 + 10 * robot as u32 + 3;
    let is_late = |robot: usize| robot.is_multiple_of(2);
    let orders: Vec<Order> = (0..10)
        .map(|robot| Order {
            before: (!is_late(robot)).then_some(SEARCH),
            after: [0.99; 2],
            at: at(robot),
            begins: None,
        })
        .collect();
    let worlds = worlds(10, Lamp::fixed(Light::OverNest));
    let (mut still, mut reached) = (0, 0);
    let mut seeks = [0; 10];
    for lines in watched(swarm, &worlds, &vec![orders; 10], 400) {
        for (cycle, line) in lines.iter().enumerate() {
            for (robot, seen) in line.robots.iter().enumerate() {
                if cycle as u32 >= at(robot) {
                    assert!(
                        matches!(seen.behaviour, Behaviour::SeekLight | Behaviour::Avoid),
                        "{seen:?}"
                    );
                    seeks[robot] += u32::from(cycle as u32 == at(robot) && seen.behaviour == Behaviour::SeekLight);
                    continue;
                }
                if !is_late(robot) {
                    assert!(
                        matches!(seen.behaviour, Behaviour::Search | Behaviour::Avoid),
                        "{seen:?}"
                    );
                    continue;
                }
                assert_eq!(seen.behaviour, Behaviour::Off);
                assert!(!seen.carries && seen.heard == 0 && seen.brought == 0, "{seen:?}");
                assert!(line.robots.iter().all(|other| other.heard >> robot & 1 == 0));
                reached += line.food.iter().filter(|&&item| distance(seen, item) < 50.0).count();
                if let Some(before) = cycle.checked_sub(1).map(|cycle| &lines[cycle].robots) {
                    assert_eq!(seen.heading, before[robot].heading);
                    let others = (0..10).filter(|&other| other != robot);
                    let nearest = others.map(|other| apart(&before[other], seen)).fold(f32::MAX, f32::min);
                    if nearest > 90.0 {
                        still += 1;
                        assert_eq!([seen.x, seen.y], [before[robot].x, before[robot].y]);
                    }
                }
            }
        }
    }
    assert!(
        still > 1_000 && reached > 100,
        "{still} cycles still, {reached} with food in reach"
    );
    assert!(seeks.iter().all(|&count| count > 0), "{seeks:?}");
}

/// In one stretch, in several, by another arena that continues from the first one's state, and by an evaluator that
/// stops every seven cycles.
#[test]
fn a_life_in_stretches_is_the_same_life() {
    let swarm = Swarm::odowd2014(10);
    let lamp = Lamp {
        first: Light::OverNest,
        then: Light::OppositeNest,
        moves: 250,
    };
    let worlds = worlds(5, lamp);
    let orders: Vec<Order> = (0..10)
        .map(|robot| Order {
            before: (robot > 2).then_some(SEARCH),
            after: GOOD,
            at: 31 * robot,
            begins: Some(45 * robot),
        })
        .collect();
    let orders = vec![orders; 5];
    let control = Control::new();
    let expected = watched(swarm, &worlds, &orders, 600);
    let together = |stretches: Vec<Vec<Vec<Line>>>| -> Vec<Vec<Line>> {
        (0..5)
            .map(|world| stretches.iter().flat_map(|lines| lines[world].clone()).collect())
            .collect()
    };
    for chunk in [7, 1_000] {
        let mut cpu = Cpu::new(Some(2)).unwrap().with_chunk(chunk);
        let mut arena = Simulated::new(&mut cpu, &control, &[swarm], &worlds).unwrap();
        let stretches = [10, 50, 170, 240, 260, 600].map(|until| arena.live(until, &orders, 1).unwrap());
        assert!(together(stretches.into()) == expected, "cut each {chunk} cycles");
    }
    let mut cpu = Cpu::new(None).unwrap();
    let mut one = Simulated::new(&mut cpu, &control, &[swarm], &worlds).unwrap();
    let first = one.live(300, &orders, 1).unwrap();
    let (now, states) = one.state();
    let states = states.to_vec();
    let mut cpu = Cpu::new(None).unwrap();
    let mut other = Simulated::new(&mut cpu, &control, &[swarm], &worlds)
        .unwrap()
        .at(now, states);
    let then = other.live(600, &orders, 1).unwrap();
    assert!(together(vec![first, then]) == expected, "gone on from a state");
}

/// Obstruction between two robots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    Free,
    Hidden,
    TooFar,
    /// Rounding decides.
    Unclear,
}

fn way(robots: &[Seen], listener: usize, talker: usize, range: f32) -> Way {
    let [one, other] = [&robots[listener], &robots[talker]];
    let length = apart(one, other);
    if (length - range).abs() < 1e-2 {
        return Way::Unclear;
    }
    if length > range {
        return Way::TooFar;
    }
    let axis = [(other.x - one.x) / length, (other.y - one.y) / length];
    let mut found = Way::Free;
    for (index, third) in robots.iter().enumerate() {
        if index == listener || index == talker {
            continue;
        }
        let to = [third.x - one.x, third.y - one.y];
        let along = to[0] * axis[0] + to[1] * axis[1];
        let aside = (to[1] * axis[0] - to[0] * axis[1]).abs();
        if (-1e-2..length + 1e-2).contains(&along) && aside < 35.01 {
            if !(1e-2..length - 1e-2).contains(&along) || aside > 34.99 {
                return Way::Unclear;
            }
            found = Way::Hidden;
        }
    }
    found
}

/// A robot listens once a second: robot i when the sum of the cycle and i is a multiple of ten.
#[test]
fn robots_hear_half_of_those_in_sight_and_nobody_else() {
    for (heard, line_of_sight) in [(0.5, true), (0.5, false), (1.0, true), (0.0, true)] {
        let swarm = Swarm {
            heard,
            line_of_sight,
            ..Swarm::odowd2014(10)
        };
        let (mut in_sight, mut got, mut hidden, mut through) = (0_u32, 0_u32, 0_u32, 0_u32);
        for lines in over_nest(swarm, SEARCH, 10, 1_200) {
            for (cycle, line) in lines.iter().enumerate() {
                for (listener, robot) in line.robots.iter().enumerate() {
                    assert_eq!(robot.heard >> 10, 0);
                    if !(cycle + listener).is_multiple_of(10) {
                        assert_eq!(robot.heard, 0, "robot {listener} in cycle {cycle}");
                        continue;
                    }
                    for talker in 0..10 {
                        let hears = robot.heard >> talker & 1 == 1;
                        if talker == listener {
                            assert!(!hears, "itself");
                            continue;
                        }
                        match way(&line.robots, listener, talker, swarm.range) {
                            Way::Free => {
                                in_sight += 1;
                                got += u32::from(hears);
                            }
                            Way::Hidden => {
                                hidden += 1;
                                through += u32::from(hears);
                            }
                            Way::TooFar => assert!(!hears, "{talker} from too far"),
                            Way::Unclear => (),
                        }
                    }
                }
            }
        }
        assert!(in_sight > 5_000 && hidden > 200, "{in_sight} in sight, {hidden} not");
        // Four standard deviations; zero for what always or never happens.
        let is_likely = |count: u32, of: u32, chance: f64| {
            let [count, of] = [count, of].map(f64::from);
            (count - chance * of).abs() <= 4.0 * (of * chance * (1.0 - chance)).sqrt()
        };
        assert!(
            is_likely(got, in_sight, f64::from(heard)),
            "{got} of {in_sight} at {heard}"
        );
        let chance = if line_of_sight { 0.0 } else { f64::from(heard) };
        assert!(
            is_likely(through, hidden, chance),
            "{through} of {hidden} hidden ones at {heard}"
        );
    }
}

#[test]
fn each_difference_changes_lives() {
    let lines = |differences, individuals| {
        let swarm = Swarm {
            differences,
            individuals,
            ..Swarm::odowd2014(10)
        };
        over_nest(swarm, [0.99, 0.0], 4, 300)
    };
    let (none, all) = (Differences::NONE, Differences::ODOWD2014);
    let plain = lines(none, 1);
    for (name, one) in [
        (
            "wheels",
            Differences {
                wheels: all.wheels,
                ..none
            },
        ),
        (
            "proximity",
            Differences {
                proximity: all.proximity,
                ..none
            },
        ),
        (
            "light",
            Differences {
                light: all.light,
                ..none
            },
        ),
        ("slip", Differences { slip: all.slip, ..none }),
        ("latency", Differences { latency: true, ..none }),
        ("beam", Differences { beam: all.beam, ..none }),
        (
            "reflection",
            Differences {
                reflection: all.reflection,
                ..none
            },
        ),
        (
            "shadows",
            Differences {
                shadows: all.shadows,
                ..none
            },
        ),
        (
            "tracking_loss",
            Differences {
                tracking_loss: all.tracking_loss,
                ..none
            },
        ),
    ] {
        assert!(lines(one, 1) != plain, "{name}");
    }
    assert!(lines(none, 2) == plain, "robots that are alike");
    assert!(lines(all, 2) != lines(all, 1), "robots that are not");
    // Wheels that obey a cycle late do nothing in the first one.
    let late = lines(Differences { latency: true, ..none }, 1);
    let moved = |worlds: &[Vec<Line>], cycle: usize| {
        let pairs = worlds
            .iter()
            .flat_map(|lines| lines[0].robots.iter().zip(&lines[cycle].robots));
        pairs.map(|(one, other)| apart(one, other)).fold(0.0, f32::max)
    };
    let starts: Vec<[f32; 2]> = late
        .iter()
        .flat_map(|lines| &lines[0].robots)
        .map(|r| [r.x, r.y])
        .collect();
    let orders = vec![
        vec![
            Order {
                before: None,
                after: GOOD,
                at: 1,
                begins: None
            };
            10
        ];
        4
    ];
    let off = watched(
        Swarm {
            differences: none,
            ..Swarm::odowd2014(10)
        },
        &worlds(4, Lamp::fixed(Light::OverNest)),
        &orders,
        1,
    );
    let stands: Vec<[f32; 2]> = off
        .iter()
        .flat_map(|lines| &lines[0].robots)
        .map(|r| [r.x, r.y])
        .collect();
    assert_eq!(starts, stands);
    assert!(moved(&late, 2) > 1.0);
}

/// Food that one robot collects in a minute, in the arena without differences and on board. Their walls differ: the
/// arena's lets a robot slide, the other stops it. The margin, 10 %, was fixed before looking at either.
#[test]
fn one_robot_alone_forages_as_on_board() {
    const LIVES: usize = 4_096;
    const AT_ONCE: usize = 512;
    let swarm = Swarm {
        differences: Differences::NONE,
        ..Swarm::odowd2014(1)
    };
    for (genes, light) in [
        ([0.99, 0.0], Light::OverNest),
        (SEARCH, Light::Nowhere),
        ([0.99, 0.5], Light::OverNest),
        ([0.0, 0.5], Light::OppositeNest),
    ] {
        let mut shared: Vec<f64> = Vec::new();
        let lives = worlds(LIVES, Lamp::fixed(light));
        let orders = always(genes, 1, AT_ONCE);
        for part in lives.chunks(AT_ONCE) {
            let lines = watched(swarm, part, &orders, 600);
            let brought = |lines: &Vec<Line>| lines.iter().map(|line| line.robots[0].brought).sum::<u32>();
            shared.extend(lines.iter().map(brought).map(f64::from));
        }
        let worlds = Worlds::new(&[Foraging::odowd2014(light)]).unwrap();
        let mut alone: Vec<f64> = Vec::new();
        for part in 0..LIVES / AT_ONCE {
            let rollouts: Vec<_> = (0..AT_ONCE)
                .map(|life| Rollout {
                    world: 0,
                    genes: &genes,
                    key: Key::rollout(2, part as u64, life as u64, 0),
                })
                .collect();
            let batch = worlds.batch(&rollouts, Some(TraceRequest { every: 1 })).unwrap();
            let outcome = Cpu::new(None).unwrap().evaluate(&batch, &Control::new()).unwrap();
            let brought = |trace: &Trace| {
                let carries = |cycle: usize| trace.details_as::<Details>(cycle).carries > 0.0;
                // The last cycle's deposit would show one cycle later, which is in neither minute.
                (1..trace.len())
                    .filter(|&cycle| carries(cycle - 1) && !carries(cycle))
                    .count()
            };
            alone.extend(outcome.traces.iter().map(brought).map(|count| count as f64));
        }
        let [(here, here_error), (board, board_error)] = [mean_and_error(&shared), mean_and_error(&alone)];
        let ratio = here / board;
        let error = ratio * (here_error / here).hypot(board_error / board);
        println!(
            "{genes:?} {light:?}: {here:.4}, on board {board:.4}, ratio {ratio:.3} +- {:.3}",
            1.96 * error
        );
        let within = (ratio - 1.96 * error, ratio + 1.96 * error);
        assert!(
            within.0 > 0.9 && within.1 < 1.1,
            "{genes:?} {light:?}: {ratio}, {within:?}"
        );
    }
}

/// Food that ten robots collect with the light over the nest, per robot-minute and world.
fn rates(genes: [f32; 2], minutes: u32, count: usize) -> Vec<f64> {
    let swarm = Swarm::odowd2014(10);
    let lines = lived(
        &mut Cpu::new(None).unwrap(),
        swarm,
        &worlds(count, Lamp::fixed(Light::OverNest)),
        genes,
        600 * minutes,
    );
    let brought = |lines: &Vec<Line>| -> u32 {
        let robots = lines.iter().flat_map(|line| &line.robots);
        robots.map(|robot| robot.brought).sum()
    };
    lines
        .iter()
        .map(|lines| f64::from(brought(lines)) / f64::from(10 * minutes))
        .collect()
}

/// A sanity check of the arena, and no more. Seeking the nest's light with food helps permanently. Fleeing it without
/// food also helps a robot that starts anywhere in its first minute, until it stays in the dark.
#[test]
fn light_over_the_nest_helps() {
    let mean = |genes, minutes| mean_and_error(&rates(genes, minutes, 64));
    for (genes, minutes) in [([0.99, 0.5], 10), (GOOD, 1)] {
        let [(guided, error), (random, random_error)] = [mean(genes, minutes), mean(SEARCH, minutes)];
        let difference = guided - random;
        println!("{genes:?}: {guided:.3}, at random {random:.3}");
        assert!(
            difference > 3.0 * error.hypot(random_error),
            "{genes:?}: {guided}, at random {random}"
        );
    }
}

#[test]
fn invalid_values_are_refused_by_name() {
    let good = Swarm::odowd2014(10);
    let with = |change: fn(&mut Swarm)| {
        let mut swarm = good;
        change(&mut swarm);
        swarm
    };
    for (field, wrong) in [
        ("robots", with(|swarm| swarm.robots = 0)),
        ("robots", with(|swarm| swarm.robots = 129)),
        ("arena.food_items", with(|swarm| swarm.forager.food_items = 65)),
        ("robot.cruise_mm_s", with(|swarm| swarm.forager.cruise = f32::NAN)),
        ("start", with(|swarm| swarm.forager.start = Some([0.0; 3]))),
        ("interval", with(|swarm| swarm.interval = 0)),
        ("messages.range_mm", with(|swarm| swarm.range = -1.0)),
        ("messages.range_mm", with(|swarm| swarm.range = f32::INFINITY)),
        ("messages.heard", with(|swarm| swarm.heard = 1.5)),
        ("differences.wheels", with(|swarm| swarm.differences.wheels = 0.3)),
        ("differences.proximity", with(|swarm| swarm.differences.proximity = 0.3)),
        ("differences.light", with(|swarm| swarm.differences.light = f32::NAN)),
        ("differences.slip", with(|swarm| swarm.differences.slip = 1.1)),
        ("differences.beam", with(|swarm| swarm.differences.beam = -0.1)),
        (
            "differences.reflection",
            with(|swarm| swarm.differences.reflection = 2.0),
        ),
        ("differences.shadows", with(|swarm| swarm.differences.shadows = 1.1)),
        (
            "differences.tracking_loss",
            with(|swarm| swarm.differences.tracking_loss = -1.0),
        ),
    ] {
        let invalid = Worlds::new(&[good, wrong]).unwrap_err();
        assert_eq!(invalid.field, format!("worlds[1].{field}"));
        assert!(invalid.problem.contains("; allowed"), "{invalid}");
    }
    assert!(Worlds::new::<Swarm>(&[]).is_err());
    // The greatest number allowed.
    assert!(Worlds::new(&[with(|swarm| swarm.robots = 128)]).is_ok());
}

/// Food never appears exactly where other food lies.
#[test]
fn no_two_items_lie_at_one_place() {
    let swarm = |robots| Swarm {
        differences: Differences::NONE,
        ..Swarm::odowd2014(robots)
    };
    let mut many = swarm(40);
    many.forager.food_items = GREATEST_ITEMS;
    let mut taken_at_once = 0;
    for lines in [over_nest(swarm(10), SEARCH, 200, 2), over_nest(many, SEARCH, 50, 2)].concat() {
        taken_at_once += lines[0].robots.iter().filter(|robot| robot.carries).count();
        for line in &lines {
            for (index, item) in line.food.iter().enumerate() {
                assert!(!line.food[..index].contains(item), "{:?}", line.food);
            }
        }
    }
    assert!(taken_at_once > 200, "{taken_at_once} taken in the first cycle");
}

/// Worlds of different sizes in one batch have the same lives as alone.
#[test]
fn worlds_have_the_same_lives_in_any_batch() {
    let sizes = [1, 10, 40];
    let mut cpu = Cpu::new(Some(2)).unwrap();
    let control = Control::new();
    let world = |swarm: usize| World {
        swarm,
        lamp: Lamp::fixed(Light::OverNest),
        key: Key::rollout(1, 0, 7, 0),
    };
    let swarms = sizes.map(Swarm::odowd2014);
    let orders: Vec<Vec<Order>> = sizes.map(|robots| vec![Order::always(GOOD); robots as usize]).into();
    let lived = |cpu: &mut Cpu, swarms: &[Swarm], worlds: &[World], orders: &[Vec<Order>]| {
        let mut arena = Simulated::new(cpu, &control, swarms, worlds).unwrap();
        let first = arena.live(100, orders, 10).unwrap();
        let then = arena.live(200, orders, 10).unwrap();
        first
            .into_iter()
            .zip(then)
            .map(|(a, b)| [a, b].concat())
            .collect::<Vec<_>>()
    };
    let together = lived(&mut cpu, &swarms, &[0, 1, 2].map(world), &orders);
    for (index, lines) in together.iter().enumerate() {
        let alone = lived(&mut cpu, &swarms[index..=index], &[world(0)], &orders[index..=index]);
        assert_eq!(alone[0], *lines, "{} robots", sizes[index]);
    }
}
