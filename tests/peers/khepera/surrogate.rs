//! A surrogate of a Khepera as an emulated robot's body: a life of the library, one cycle at a time, with its wheels'
//! speeds from outside.

use std::sync::Arc;
use std::time::Duration;

use oneiro::arena::Arena;
use oneiro::batch::{Rollout, TraceRequest, Worlds};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::Key;
use oneiro::surrogate::{Differences, Surrogate};
use oneiro::tables::{MotorCell, MotorTable};
use oneiro::world::{Start, World, WorldSpec};

use super::Body;

/// A robot of its own in an arena. It has no sensors of light, and reads darkness. Its readings change once a cycle.
pub struct Simulated {
    spec: WorldSpec,
    worlds: Worlds,
    cpu: Cpu,
    /// Draws its noise, from the next placing on.
    pub key: Key,
    /// The next cycle, and the state before it; none at the start.
    cycle: u32,
    state: Option<Vec<u32>>,
    /// The pose before it: mm, mm, and turns.
    pub pose: [f32; 3],
    proximity: [u16; 8],
    /// How much of the next cycle is over, and the speeds in it so far, summed over ns.
    spent: Duration,
    sums: [i64; 2],
}

impl Simulated {
    const CYCLE: Duration = Duration::from_millis(100);
    /// The surrogate's wheels go no faster, pulses / 10 ms.
    pub const GREATEST: i32 = 10;
    /// The mean speed of a cycle is rounded to as many parts of a pulse / 10 ms.
    const PARTS: i64 = 10;

    /// A robot at a pose (mm, mm, turns) in an arena, which must be free there. The seed draws its body, its surroundings
    /// and its noise.
    pub fn new(seed: u64, arena: Arena, pose: [f32; 3]) -> Self {
        let mut spec = WorldSpec {
            surrogate: Some(Arc::new(Surrogate::drawn(seed, Differences::all(1.0)))),
            arena,
            cycles: 1_000_000,
            ..WorldSpec::miglino1995()
        };
        spec.robot.motors = Arc::new(motors());
        let mut own = Self {
            worlds: Self::worlds(&mut spec, pose),
            spec,
            cpu: Cpu::new(Some(1)).unwrap(),
            key: Key::rollout(seed, 0, 0, 0),
            cycle: 0,
            state: None,
            pose,
            proximity: [0; 8],
            spent: Duration::ZERO,
            sums: [0; 2],
        };
        own.look();
        own
    }

    fn worlds(spec: &mut WorldSpec, [x, y, heading]: [f32; 3]) -> Worlds {
        spec.start = Start::At { x, y, heading };
        Worlds::new(&[World::new(spec.clone()).unwrap()]).unwrap()
    }

    /// Takes the robot up and puts it down at another pose.
    pub fn place(&mut self, pose: [f32; 3]) {
        self.worlds = Self::worlds(&mut self.spec, pose);
        (self.cycle, self.state, self.spent, self.sums) = (0, None, Duration::ZERO, [0; 2]);
        self.look();
    }

    /// Takes it to a pose in another arena.
    pub fn bring(&mut self, arena: Arena, pose: [f32; 3]) {
        self.spec.arena = arena;
        self.place(pose);
    }

    /// Lives the next cycle with these speeds, in parts of a pulse / 10 ms. Returns the state after it, and the pose and the
    /// activations at its beginning.
    fn live(&mut self, speeds: [i64; 2]) -> (Vec<u32>, [f32; 3], [f32; 8]) {
        let genes = genes(speeds);
        let rollout = Rollout {
            world: 0,
            genes: &genes,
            key: self.key,
        };
        let cycles = self.cycle..self.cycle + 1;
        let trace = Some(TraceRequest { every: 1 });
        let batch = self
            .worlds
            .stretch(&[rollout], cycles, self.state.as_slice(), trace)
            .unwrap();
        let mut outcome = self.cpu.evaluate(&batch, &Control::new()).unwrap();
        let trace = &outcome.traces[0];
        let pose = [trace[0].x, trace[0].y, trace[0].heading];
        (outcome.states.remove(0), pose, outcome.traces[0].activations(0))
    }

    /// Reads the sensors: those of a cycle do not depend on its speeds.
    fn look(&mut self) {
        let (_, pose, activations) = self.live([0; 2]);
        self.pose = pose;
        self.proximity = activations.map(|activation| (1023.0 * activation).round() as u16);
    }
}

/// Genes of a perceptron that reads nothing, and whose biases select these speeds.
pub fn genes(speeds: [i64; 2]) -> [f32; 18] {
    let mut genes = [0.0; 18];
    for (bias, speed) in [8, 17].into_iter().zip(speeds) {
        let most = i64::from(Simulated::GREATEST) * Simulated::PARTS;
        let output = 0.5 + 0.5 * speed as f64 / most as f64;
        genes[bias] = (output / (1.0 - output)).ln().clamp(-50.0, 50.0) as f32;
    }
    genes
}

/// Speeds in parts of a pulse / 10 ms. A surrogate takes nothing else from the table.
pub fn motors() -> MotorTable {
    let most = i64::from(Simulated::GREATEST) * Simulated::PARTS;
    let speeds = || (-most..=most).map(|speed| speed as f32 / most as f32);
    let cells = speeds().flat_map(|left| {
        speeds().map(move |right| MotorCell {
            left,
            right,
            ..MotorCell::default()
        })
    });
    MotorTable {
        states: 2 * most as u32 + 1,
        cells: cells.collect(),
        scale: 2.0 * most as f32,
        offset: 0.5,
    }
}

impl Body for Simulated {
    fn greatest(&self) -> i32 {
        Self::GREATEST
    }

    fn advance(&mut self, mut time: Duration, speeds: [i32; 2]) {
        while !time.is_zero() {
            let step = time.min(Self::CYCLE.saturating_sub(self.spent));
            for (sum, speed) in self.sums.iter_mut().zip(speeds) {
                *sum += i64::from(speed) * step.as_nanos() as i64;
            }
            self.spent += step;
            time = time.saturating_sub(step);
            if self.spent == Self::CYCLE {
                let cycle = Self::CYCLE.as_nanos() as f64;
                let means = self
                    .sums
                    .map(|sum| (Self::PARTS as f64 * sum as f64 / cycle).round() as i64);
                let (state, ..) = self.live(means);
                (self.state, self.spent, self.sums) = (Some(state), Duration::ZERO, [0; 2]);
                self.cycle += 1;
                self.look();
            }
        }
    }

    fn proximity(&self) -> [u16; 8] {
        self.proximity
    }

    fn light(&self) -> [u16; 8] {
        // About what it reads in the dark.
        [500; 8]
    }
}
