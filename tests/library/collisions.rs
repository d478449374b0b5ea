//! Effects of collisions compared with geometry: undone, with the turn kept, or sliding.

use std::sync::Arc;

use oneiro::arena::{Arena, Block, Field, Obstacle, Wall};
use oneiro::batch::{Batch, Record, Rollout, Trace, TraceRequest};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::{Key, pcg4d};
use oneiro::surrogate::{Differences, Surrogate};
use oneiro::tables::SensorTable;
use oneiro::world::{Collision, Start, World, WorldSpec};

const RADIUS: f64 = 27.5;
/// Gap in mm that a sliding body keeps to what it touches, minus the kernels' rounding errors.
const GAP: f64 = 1.0 / 256.0;
const ROUNDING: f64 = 1e-3;

fn wall(from: [f32; 2], to: [f32; 2]) -> Wall {
    Wall {
        from,
        to,
        class: "wall".into(),
    }
}

/// A spacious arena with these walls.
fn arena(walls: Vec<Wall>) -> Arena {
    Arena {
        name: "test".into(),
        field: Field {
            x: -500.0,
            y: -500.0,
            width: 1000.0,
            height: 1000.0,
        },
        walls,
        ..Arena::default()
    }
}

fn spec(arena: Arena, collision: Collision, [x, y, heading]: [f32; 3]) -> WorldSpec {
    let mut spec = WorldSpec {
        arena,
        start: Start::At { x, y, heading },
        cycles: 60,
        ..WorldSpec::miglino1995()
    };
    spec.robot.collision = collision;
    spec
}

fn lived(spec: &WorldSpec, genes: &[f32], rollouts: u64) -> Vec<Trace> {
    let world = World::new(spec.clone()).unwrap();
    let rollout = |index| Rollout {
        world: 0,
        genes,
        key: Key::rollout(3, 0, index, 0),
    };
    let rollouts: Vec<_> = (0..rollouts).map(rollout).collect();
    let batch = Batch::new(&[world], &rollouts, Some(TraceRequest { every: 1 })).unwrap();
    Cpu::new(None)
        .unwrap()
        .evaluate(&batch, &Control::new())
        .unwrap()
        .traces
}

/// Genes that command both wheels regardless of the sensors: 0 is full speed back, 1 full speed ahead.
fn driving(left: f32, right: f32) -> Vec<f32> {
    let bias = |share: f32| {
        if share >= 1.0 {
            50.0
        } else {
            (share / (1.0 - share)).ln()
        }
    };
    let mut genes = vec![0.0; 18];
    (genes[8], genes[17]) = (bias(left), bias(right));
    genes
}

/// Trace of a robot that drives straight ahead at full speed.
fn ahead(spec: &WorldSpec) -> Trace {
    lived(spec, &driving(1.0, 1.0), 1).remove(0)
}

/// Distance that a robot travels per cycle at full speed.
fn stride() -> f64 {
    let trace = ahead(&spec(arena(Vec::new()), Collision::Undo, [0.0, 0.0, 0.0]));
    f64::from(trace[1].x)
}

/// Distance of a point from the nearest point of a segment.
fn from_segment(at: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    let way = [to[0] - from[0], to[1] - from[1]];
    let along = (at[0] - from[0]) * way[0] + (at[1] - from[1]) * way[1];
    let share = (along / (way[0] * way[0] + way[1] * way[1])).clamp(0.0, 1.0);
    (at[0] - from[0] - share * way[0]).hypot(at[1] - from[1] - share * way[1])
}

/// Gap between a robot and the nearest object in its arena.
fn gap(arena: &Arena, record: &Record) -> f64 {
    let at = [record.x, record.y].map(f64::from);
    let walls = arena.walls.iter().map(|wall| {
        let [from, to] = [wall.from, wall.to].map(|end| end.map(f64::from));
        from_segment(at, from, to)
    });
    let obstacles = arena.obstacles.iter().map(|obstacle| {
        (at[0] - f64::from(obstacle.x)).hypot(at[1] - f64::from(obstacle.y)) - f64::from(obstacle.radius)
    });
    let blocks = arena.blocks.iter().map(|block| {
        let (sine, cosine) = (f64::from(block.heading) * std::f64::consts::TAU).sin_cos();
        let (x, y) = (at[0] - f64::from(block.x), at[1] - f64::from(block.y));
        let along = (x * cosine + y * sine).abs() - f64::from(block.length) / 2.0;
        let across = (y * cosine - x * sine).abs() - f64::from(block.width) / 2.0;
        along.max(0.0).hypot(across.max(0.0))
    });
    walls.chain(obstacles).chain(blocks).fold(f64::MAX, f64::min) - RADIUS
}

#[test]
fn a_robot_at_a_wall_slides_along_it() {
    // Walls at any angle: the robot approaches from their left side at 45 degrees.
    for turns in [0.0, 0.1, 0.3, 0.77_f64] {
        let (sine, cosine) = (turns * std::f64::consts::TAU).sin_cos();
        let end = [(900.0 * cosine) as f32, (900.0 * sine) as f32];
        let start = [(-60.0 * sine) as f32, (60.0 * cosine) as f32];
        let heading = (turns - 0.125).rem_euclid(1.0) as f32;
        let arena = arena(vec![wall(end.map(|x| -x), end)]);
        let trace = ahead(&spec(arena.clone(), Collision::Slide, [start[0], start[1], heading]));
        let part = stride() * 0.5_f64.sqrt();
        let mut touched = 0;
        for (cycle, record) in trace.iter().enumerate() {
            let (x, y) = (f64::from(record.x), f64::from(record.y));
            let (along, across) = (x * cosine + y * sine, y * cosine - x * sine);
            // It slides all of the way along the wall, and moves towards it as far as there is room.
            let far = cycle as f64 * part;
            assert!(
                (along - far).abs() < 60.0 * ROUNDING,
                "{turns}, cycle {cycle}: {along} mm along, not {far}"
            );
            let near = (60.0 - far).max(RADIUS + GAP);
            assert!(
                (across - near).abs() < 60.0 * ROUNDING,
                "{turns}, cycle {cycle}: {across} mm off, not {near}"
            );
            assert!(gap(&arena, record) >= -1e-4, "{turns}, cycle {cycle}");
            assert_eq!(record.heading, heading, "it goes straight on");
            assert_eq!(
                record.collided == 1.0,
                60.0 - far - part < RADIUS,
                "{turns}, cycle {cycle}"
            );
            assert!(
                record.collided == 0.0 || record.reward == 0.0,
                "a collision earns nothing"
            );
            touched += u32::from(record.collided == 1.0);
        }
        assert!(touched > 40, "{touched} cycles");
    }
}

#[test]
fn a_robot_in_a_corner_stops() {
    // Corners at the origin that open to the upper right, with right angles and 60 degrees.
    for second in [[0.0, 900.0], [450.0, 779.4229_f32]] {
        let arena = arena(vec![wall([0.0, 0.0], [900.0, 0.0]), wall([0.0, 0.0], second)]);
        let (sine, cosine) = (f64::from(second[1]).atan2(f64::from(second[0])) / 2.0).sin_cos();
        let start = [(150.0 * cosine) as f32, (150.0 * sine) as f32];
        let back = (0.5 + sine.atan2(cosine) / std::f64::consts::TAU) as f32;
        for off in [-0.03, 0.0, 0.03] {
            let trace = ahead(&spec(arena.clone(), Collision::Slide, [start[0], start[1], back + off]));
            let last = trace[59];
            let at = |record: &Record| [record.x, record.y];
            assert!(
                trace[50..].iter().all(|record| at(record) == at(&last)),
                "it stops: {last:?}"
            );
            assert!(trace.iter().all(|record| gap(&arena, record) >= -1e-4));
            // As deep as it gets, to within a cycle's travel.
            let depth = f64::from(last.x).hypot(f64::from(last.y));
            assert!(
                (depth - RADIUS / sine).abs() < stride(),
                "{depth} mm from the corner, off {off}"
            );
        }
    }
    // Driven straight into a right corner, it touches both walls.
    let arena = arena(vec![wall([0.0, 0.0], [900.0, 0.0]), wall([0.0, 0.0], [0.0, 900.0])]);
    let last = ahead(&spec(arena, Collision::Slide, [120.0, 100.0, 0.62]))[59];
    for side in [last.x, last.y] {
        assert!((f64::from(side) - RADIUS - GAP).abs() < ROUNDING, "{last:?}");
    }
}

#[test]
fn a_robot_slides_around_a_cylinder() {
    let mut arena = arena(Vec::new());
    arena.obstacles.push(Obstacle {
        x: 100.0,
        y: 10.0,
        radius: 27.5,
        class: "round".into(),
    });
    let start = [0.0, 0.0, 0.0];
    let trace = ahead(&spec(arena.clone(), Collision::Slide, start));
    assert!(trace.iter().all(|record| gap(&arena, record) >= -1e-4));
    assert!(trace.iter().any(|record| record.collided == 1.0));
    let last = trace[59];
    assert!(
        last.x > 155.0 && last.y < -30.0,
        "it is past it, on the side where its centre was: {last:?}"
    );
    let stopped = ahead(&spec(arena, Collision::KeepTurn, start))[59];
    assert!(stopped.x < 100.0, "{stopped:?}");
}

#[test]
fn what_is_not_made_of_a_move_is_undone() {
    let arena = arena(vec![wall([-900.0, 0.0], [900.0, 0.0])]);
    // Down towards the wall, turning left.
    let start = [0.0, 40.0, 0.75];
    let lives = [Collision::Undo, Collision::KeepTurn, Collision::Slide]
        .map(|collision| lived(&spec(arena.clone(), collision, start), &driving(0.75, 1.0), 1).remove(0));
    let [undone, kept, slid] = &lives;
    let first = undone.iter().position(|record| record.collided == 1.0).unwrap();
    assert!(
        first > 0
            && undone[first + 1..].iter().all(|record| {
                (record.x, record.y, record.heading) == (undone[first].x, undone[first].y, undone[first].heading)
            })
    );
    assert_eq!((kept[first + 1].x, kept[first + 1].y), (kept[first].x, kept[first].y));
    assert!(kept[first + 1].heading > kept[first].heading);
    assert!(kept[59].y > 60.0, "it turns away and leaves");
    assert!(slid[first + 1].x > slid[first].x && slid[first + 1].heading == kept[first + 1].heading);
    for (collision, trace) in lives.iter().enumerate() {
        for (cycle, record) in trace.iter().enumerate() {
            assert_eq!(
                (record.x, record.y),
                if cycle <= first {
                    (undone[cycle].x, undone[cycle].y)
                } else {
                    (record.x, record.y)
                }
            );
            assert!(gap(&arena, record) >= -1e-4, "{collision}, cycle {cycle}");
        }
    }
}

/// A table of blocks that has the same readings as walls.
fn with_blocks(spec: &mut WorldSpec) {
    let mut own = (*spec.robot.sensors).clone();
    let wall = own.classes[own.class("wall").unwrap()].clone();
    own.classes.push(SensorTable {
        class: "block".into(),
        ..wall
    });
    spec.robot.sensors = Arc::new(own);
}

#[test]
fn bodies_never_overlap_anything() {
    let mut crowded = Arena::miglino1995();
    crowded.blocks.push(Block {
        x: 300.0,
        y: 330.0,
        length: 90.0,
        width: 40.0,
        heading: 0.07,
        class: "block".into(),
    });
    let mut touched = 0;
    for collision in [Collision::Undo, Collision::KeepTurn, Collision::Slide] {
        let mut spec = spec(crowded.clone(), collision, [0.0; 3]);
        with_blocks(&mut spec);
        spec.start = Start::Random;
        spec.noise.motor = 0.3;
        spec.cycles = 300;
        for genome in 0..20 {
            let word = |gene| pcg4d([genome, gene, 9, 9])[0] as f32 / 2.0_f32.powi(32);
            let genes: Vec<f32> = (0..18).map(|gene| 10.0 * word(gene) - 5.0).collect();
            for trace in lived(&spec, &genes, 20) {
                for record in &trace {
                    assert!(gap(&spec.arena, record) >= -1e-3, "{collision:?}: {record:?}");
                }
                touched += trace.iter().filter(|record| record.collided == 1.0).count();
            }
        }
    }
    assert!(touched > 10_000, "{touched} collisions");
}

#[test]
fn a_surrogate_has_collisions_of_its_own() {
    let mut spec = WorldSpec::miglino1995();
    spec.surrogate = Some(Arc::new(Surrogate::drawn(1, Differences::all(1.0))));
    assert!(World::new(spec.clone()).is_ok());
    spec.robot.collision = Collision::Slide;
    let invalid = World::new(spec).unwrap_err();
    assert_eq!(invalid.field, "robot.collision");
    assert!(invalid.problem.contains("allowed: `Undo`"), "{invalid}");
}
