//! Worlds that each differ in one choice, for tests that compare lives with a witness or with pinned results.

use std::sync::Arc;

use oneiro::arena::Arena;
use oneiro::tables::{SensorTable, SensorTables};
use oneiro::world::{Activation, Collision, Controller, Difference, Drawn, Noise, Speed, Start, Task, WorldSpec};

/// Tables with one for blocks, which look different from each of five sides.
pub(crate) fn with_blocks(sensors: &SensorTables) -> Arc<SensorTables> {
    let mut own = sensors.clone();
    let wall = &sensors.classes[0];
    let from = |view: usize| wall.readings.iter().map(move |reading| reading / (1 + view as u16));
    own.classes.push(SensorTable {
        class: "block".into(),
        views: 5,
        readings: (0..5).flat_map(from).collect(),
        ..wall.clone()
    });
    Arc::new(own)
}

/// Puts a world's robot into an arena with a block.
pub(crate) fn beside_a_block(spec: &mut WorldSpec) {
    spec.arena = Arena::miglino1995_block();
    spec.robot.sensors = with_blocks(&spec.robot.sensors);
}

/// The terms of equation 1.
pub(crate) fn task(speed: Speed, difference: Difference, activation: Activation) -> Task {
    Task::Avoidance {
        speed,
        difference,
        activation,
        new_cell: 0.0,
    }
}

/// The three conditions of the 1995 paper, every controller, and every choice that moves a number.
pub(crate) fn specs() -> Vec<(String, WorldSpec)> {
    let base = WorldSpec::miglino1995();
    let mut specs = vec![("no noise".to_owned(), base.clone())];
    let mut with = |name: &str, change: &dyn Fn(&mut WorldSpec)| {
        let mut spec = base.clone();
        change(&mut spec);
        specs.push((name.to_owned(), spec));
    };
    with("sensor noise", &|spec| spec.noise.sensor = (0.0, 0.4));
    with("symmetric noise", &|spec| spec.noise.sensor = (-0.2, 0.2));
    with("conservative noise", &|spec| {
        (spec.noise.walk_range, spec.noise.walk_step) = (30.0, 1.5);
    });
    with("motor noise", &|spec| spec.noise.motor = 0.1);
    with("hidden layer", &|spec| {
        spec.controller = Controller::Hidden { units: 3 }
    });
    with("recurrent outputs", &|spec| spec.controller = Controller::Recurrent);
    with("mean heading", &|spec| spec.robot.turn_before_move = 0.5);
    with("fixed start", &|spec| {
        spec.start = Start::At {
            x: 100.0,
            y: 100.0,
            heading: 0.125,
        }
    });
    with("signed, square, perceived", &|spec| {
        spec.noise.sensor = (0.0, 0.4);
        spec.task = task(Speed::Signed, Difference::Square, Activation::Perceived);
    });
    with("a block", &beside_a_block);
    with("a block, conservative noise", &|spec| {
        beside_a_block(spec);
        (spec.noise.walk_range, spec.noise.walk_step) = (60.0, 10.0);
    });
    with("two terms", &|spec| {
        spec.task = task(Speed::Unsigned, Difference::Root, Activation::None);
    });
    with("cells that are new", &|spec| {
        spec.task = Task::AVOIDANCE.with_new_cell(2.5);
    });
    specs
}

/// Effects of collisions other than undoing moves.
pub(crate) fn collisions() -> Vec<(String, WorldSpec)> {
    let with = |name: &str, collision, change: &dyn Fn(&mut WorldSpec)| {
        let mut spec = WorldSpec::miglino1995();
        spec.robot.collision = collision;
        change(&mut spec);
        (name.to_owned(), spec)
    };
    vec![
        with("turns that collisions keep", Collision::KeepTurn, &|_| ()),
        with("sliding", Collision::Slide, &|_| ()),
        with("sliding, motor noise", Collision::Slide, &|spec| spec.noise.motor = 0.2),
        with("sliding along a block", Collision::Slide, &beside_a_block),
        with("sticking", Collision::Stick, &|_| ()),
    ]
}

/// Noise that the kernels that ship don't have: each value, alone and with others.
pub(crate) fn varied() -> Vec<(String, WorldSpec)> {
    let with = |name: &str, change: &dyn Fn(&mut WorldSpec)| {
        let mut spec = WorldSpec::miglino1995();
        change(&mut spec);
        (name.to_owned(), spec)
    };
    let all = Noise {
        sensor: (-0.1, 0.1),
        motor: 0.1,
        gain: Some(0.5),
        veer: Some(0.5),
        delay: Some(0.6),
        ..Noise::CONSERVATIVE
    };
    let of_life = Noise {
        drawn: Some(Drawn::Life),
        ..all
    };
    vec![
        with("gain", &|spec| spec.noise.gain = Some(0.5)),
        with("veer", &|spec| spec.noise.veer = Some(0.5)),
        with("delay", &|spec| spec.noise.delay = Some(1.0)),
        with("sensor noise of a life", &|spec| {
            spec.noise.sensor = (0.0, 0.4);
            spec.noise.drawn = Some(Drawn::Life);
        }),
        with("motor noise of a life, sliding", &|spec| {
            spec.noise.motor = 0.2;
            spec.noise.drawn = Some(Drawn::Life);
            spec.robot.collision = Collision::Slide;
        }),
        with("all", &|spec| spec.noise = all),
        with("all of a life, sliding, recurrent", &|spec| {
            spec.noise = of_life;
            spec.controller = Controller::Recurrent;
            spec.robot.collision = Collision::Slide;
        }),
        with("all of a life, sticking, hidden", &|spec| {
            spec.noise = of_life;
            spec.controller = Controller::Hidden { units: 3 };
            spec.robot.collision = Collision::Stick;
        }),
    ]
}
