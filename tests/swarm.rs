//! The arena of a swarm: what robots may not do, what they share, and the same bits everywhere.

use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::foraging::Light;
use oneiro::random::Key;
use oneiro::swarm::{Arena, Lamp, Line, Order, Simulated, Swarm, World};

/// To the light with food, away from it without.
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

/// Worlds of different sizes in one batch live as they do alone.
#[test]
fn worlds_live_the_same_in_any_company() {
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
