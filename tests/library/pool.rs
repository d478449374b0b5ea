//! Evaluators made of others: the pool, the audit, the choice between two devices, and backends by name.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, mpsc};
use std::time::Duration;

use oneiro::audit::Audited;
use oneiro::auto::Auto;
use oneiro::backend::{Options, open};
use oneiro::batch::{Batch, Part, PartResult, Rollout};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Device, Error, Evaluator};
use oneiro::pool::Pool;
use oneiro::random::{Key, pcg4d};
use oneiro::world::{World, WorldSpec};

fn cpu() -> Cpu {
    Cpu::new(Some(1)).unwrap()
}

fn batch(rollouts: usize) -> Batch {
    batch_of(50, rollouts)
}

fn batch_of(cycles: u32, rollouts: usize) -> Batch {
    let world = World::new(WorldSpec {
        cycles,
        ..WorldSpec::miglino1995()
    })
    .unwrap();
    let gene = |at: usize| pcg4d([at as u32, 0, 0, 0])[3] as f32 / 2.0_f32.powi(31) - 1.0;
    let genes: Vec<f32> = (0..rollouts * 18).map(gene).collect();
    let rollout = |(index, genes)| Rollout {
        world: 0,
        genes,
        key: Key::rollout(3, 1, index as u64, 4),
    };
    let rollouts: Vec<Rollout<'_>> = genes.chunks(18).enumerate().map(rollout).collect();
    Batch::new(&[world], &rollouts, None).unwrap()
}

fn fitness(evaluator: &mut dyn Evaluator, batch: &Batch) -> Result<Vec<u32>, Error> {
    let outcome = evaluator.evaluate(batch, &Control::new())?;
    Ok(outcome.fitness.iter().map(|fitness| fitness.to_bits()).collect())
}

/// A device with the CPU's results that can fail.
struct Device1995 {
    cpu: Cpu,
    exact: bool,
    /// Number of parts after which it is lost.
    life: usize,
    /// Slot of each part whose result has a wrong last bit.
    wrong: Option<usize>,
}

impl Device1995 {
    fn new() -> Self {
        Self {
            cpu: cpu(),
            exact: true,
            life: usize::MAX,
            wrong: None,
        }
    }
}

impl Evaluator for Device1995 {
    fn device(&self) -> Device {
        Device {
            name: "a device".into(),
            detail: "of 1995".into(),
            exact: self.exact,
        }
    }

    fn evaluate_part(&mut self, part: &Part<'_>, control: &Control) -> Result<PartResult, Error> {
        if self.life == 0 {
            return Err(Error::Lost {
                device: "a device".into(),
                reason: "it is old".into(),
            });
        }
        self.life -= 1;
        let mut result = self.cpu.evaluate_part(part, control)?;
        if let Some(slot) = self.wrong {
            result.fitness[slot] = f32::from_bits(result.fitness[slot].to_bits() ^ 1);
        }
        Ok(result)
    }
}

#[test]
fn a_pool_gives_the_same_bits() {
    let batch = batch(5000);
    let expected = fitness(&mut cpu(), &batch).unwrap();
    let mut pool = Pool::new(vec![Box::new(cpu()), Box::new(Device1995::new()), Box::new(cpu())]).unwrap();
    for _ in 0..3 {
        let control = Control::new();
        let outcome = pool.evaluate(&batch, &control).unwrap();
        assert_eq!(
            outcome
                .fitness
                .iter()
                .map(|fitness| fitness.to_bits())
                .collect::<Vec<_>>(),
            expected
        );
        assert_eq!(control.steps(), batch.steps());
    }
    assert_eq!(pool.warnings(), Vec::<String>::new());
    assert_eq!(pool.device().name, "cpu + a device + cpu");
}

#[test]
fn a_lost_member_leaves_its_piece_to_the_others() {
    let batch = batch(5000);
    let expected = fitness(&mut cpu(), &batch).unwrap();
    for life in 0..3 {
        let old = Device1995 {
            life,
            ..Device1995::new()
        };
        let mut pool = Pool::new(vec![Box::new(cpu()), Box::new(old)]).unwrap();
        // A member may be too late for a piece of a batch.
        for _ in 0..1000 {
            assert_eq!(fitness(&mut pool, &batch).unwrap(), expected);
            if !pool.warnings().is_empty() {
                break;
            }
        }
        assert_eq!(pool.warnings().len(), 1, "{:?}", pool.warnings());
        assert!(
            pool.warnings()[0].contains("a device was lost: it is old"),
            "{:?}",
            pool.warnings()
        );
        assert_eq!(pool.device().name, "cpu");
    }
}

#[test]
fn a_pool_that_has_lost_all_says_so() {
    let old = || {
        Box::new(Device1995 {
            life: 1,
            ..Device1995::new()
        })
    };
    let mut pool = Pool::new(vec![old(), old()]).unwrap();
    let error = fitness(&mut pool, &batch(5000)).unwrap_err();
    assert!(
        matches!(&error, Error::NoDevice(reason) if reason.contains("it is old")),
        "{error}"
    );
}

#[test]
fn pools_are_of_exact_devices() {
    assert!(matches!(Pool::new(Vec::new()), Err(Error::NoDevice(_))));
    let inexact = Device1995 {
        exact: false,
        ..Device1995::new()
    };
    let error = Pool::new(vec![Box::new(cpu()), Box::new(inexact)]).err().unwrap();
    assert!(error.to_string().contains("a device is not exact"), "{error}");
}

#[test]
fn a_cancelled_pool_stops() {
    let control = Control::new();
    control.cancel();
    let mut pool = Pool::new(vec![Box::new(cpu()), Box::new(cpu())]).unwrap();
    assert!(matches!(pool.evaluate(&batch(200), &control), Err(Error::Cancelled)));
}

#[test]
fn an_audit_of_all_finds_one_wrong_bit() {
    let batch = batch(500);
    for wrong in [0, 63, 64, 499] {
        let device = Device1995 {
            wrong: Some(wrong),
            ..Device1995::new()
        };
        let error = fitness(&mut Audited::new(Box::new(device), cpu(), 1.0), &batch).unwrap_err();
        let Error::Differs {
            rollout,
            device,
            there,
            here,
        } = &error
        else {
            panic!("{error}")
        };
        assert_eq!((*rollout, device.as_str()), (wrong, "a device"));
        assert_eq!(there.to_bits() ^ here.to_bits(), 1);
        assert!(
            error.to_string().contains(&format!("{:08x}", here.to_bits())),
            "{error}"
        );
    }
}

#[test]
fn an_audit_passes_right_results() {
    let batch = batch(500);
    let expected = fitness(&mut cpu(), &batch).unwrap();
    for share in [0.0, 0.1, 1.0] {
        let mut audited = Audited::new(Box::new(Device1995::new()), cpu(), share);
        assert_eq!(fitness(&mut audited, &batch).unwrap(), expected);
        // An idle slot may hold anything.
        let device = Device1995 {
            wrong: Some(511),
            ..Device1995::new()
        };
        assert_eq!(
            fitness(&mut Audited::new(Box::new(device), cpu(), share), &batch).unwrap(),
            expected
        );
    }
    // Without an audit nobody notices.
    let device = Device1995 {
        wrong: Some(0),
        ..Device1995::new()
    };
    assert!(fitness(&mut Audited::new(Box::new(device), cpu(), 0.0), &batch).is_ok());
}

/// With a small share, one group per call is audited, and the groups vary with the keys.
#[test]
fn an_audit_of_a_share_looks_at_that_share() {
    let found = |share: f64, first_lane: usize, batch: &Batch| {
        let groups = 0..batch.groups() as usize;
        let looked_at = groups.filter(|group| {
            let device = Device1995 {
                wrong: Some(group * 64 + first_lane),
                ..Device1995::new()
            };
            fitness(&mut Audited::new(Box::new(device), cpu(), share), batch).is_err()
        });
        looked_at.count()
    };
    assert_eq!(found(1e-9, 5, &batch(640)), 1);
    let half = found(0.5, 0, &batch(64 * 40));
    assert!((10..=30).contains(&half), "{half} of 40 groups");
}

#[test]
fn an_audit_does_not_count_as_progress() {
    let batch = batch(300);
    let control = Control::new();
    Audited::new(Box::new(Device1995::new()), cpu(), 1.0)
        .evaluate(&batch, &control)
        .unwrap();
    assert_eq!(control.steps(), batch.steps());
}

#[test]
fn backends_open_by_name() {
    let options = Options {
        threads: Some(1),
        chunk: Some(9),
        audit_share: 0.0,
        ..Options::default()
    };
    let batch = batch(100);
    let expected = fitness(&mut cpu(), &batch).unwrap();
    let narrow = format!("cpu:{}", Cpu::variants().last().unwrap());
    for name in ["auto", "cpu", "pool:cpu+cpu", &narrow] {
        let mut evaluator = open(name, options).unwrap();
        assert_eq!(fitness(&mut *evaluator, &batch).unwrap(), expected, "{name}");
    }
}

#[test]
fn unknown_backends_are_refused_by_name() {
    let refused = |name: &str, options| match open(name, options) {
        Err(Error::NoDevice(problem)) => problem,
        Err(error) => panic!("{name}: {error}"),
        Ok(_) => panic!("{name} was opened"),
    };
    for name in ["", "tpu", "auto:1", "CPU", "pool:pool", "pool:cpu+auto", "pool:cpu+tpu"] {
        let problem = refused(name, Options::default());
        assert!(
            problem.contains("no backend `") && problem.contains("; allowed: auto, cpu"),
            "{name}: {problem}"
        );
    }
    assert!(refused("cpu:abacus", Options::default()).contains("allowed: "));
    let gpu = refused("gpu:no such adapter", Options::default());
    let reason = if cfg!(feature = "gpu") {
        "no "
    } else {
        "built without GPUs"
    };
    assert!(gpu.contains(reason), "{gpu}");
    let share = refused(
        "cpu",
        Options {
            audit_share: 1.5,
            ..Options::default()
        },
    );
    assert!(share.contains("allowed: 0 to 1"), "{share}");
}

/// Worlds of several robots, including states passed from stretch to stretch.
#[test]
fn swarms_live_the_same_on_a_pool() {
    use oneiro::foraging::Light;
    use oneiro::swarm::{Arena, Lamp, Order, Simulated, Swarm, World};

    let lived = |evaluator: &mut dyn Evaluator| {
        let control = Control::new();
        let world = |index: u64| World {
            swarm: 0,
            lamp: Lamp::fixed(Light::OverNest),
            key: Key::rollout(index, 0, 0, 0),
        };
        let worlds: Vec<World> = (0..150).map(world).collect();
        let orders = vec![vec![Order::always([0.99, 0.5]); 5]; worlds.len()];
        let mut arena = Simulated::new(evaluator, &control, &[Swarm::odowd2014(5)], &worlds).unwrap();
        let first = arena.live(60, &orders, 10).unwrap();
        (first, arena.live(100, &orders, 10).unwrap())
    };
    let mut pool = Pool::new(vec![Box::new(cpu()), Box::new(cpu())]).unwrap();
    assert!(lived(&mut pool) == lived(&mut cpu()));
}

/// A device with the CPU's results that takes a while for every part, and counts them.
struct Slow {
    name: &'static str,
    cpu: Cpu,
    time: Duration,
    parts: Arc<AtomicUsize>,
}

/// Such a device, and its count.
fn slow(name: &'static str, milliseconds: u64) -> (Box<dyn Evaluator>, Arc<AtomicUsize>) {
    let parts = Arc::new(AtomicUsize::new(0));
    let device = Slow {
        name,
        cpu: cpu(),
        time: Duration::from_millis(milliseconds),
        parts: Arc::clone(&parts),
    };
    (Box::new(device), parts)
}

impl Evaluator for Slow {
    fn device(&self) -> Device {
        Device {
            name: self.name.into(),
            ..self.cpu.device()
        }
    }

    fn evaluate_part(&mut self, part: &Part<'_>, control: &Control) -> Result<PartResult, Error> {
        std::thread::sleep(self.time);
        self.parts.fetch_add(1, Ordering::Relaxed);
        self.cpu.evaluate_part(part, control)
    }
}

#[test]
fn the_cpu_works_while_a_gpu_is_being_opened() {
    let (open, opens) = mpsc::channel::<()>();
    let (here, of_cpu) = slow("cpu", 50);
    let (there, of_gpu) = slow("a card", 5);
    let opener = move || {
        let _ = opens.recv_timeout(Duration::from_mins(1));
        Ok(there)
    };
    let mut auto = Auto::new(here, 1, "a card".into(), Box::new(opener));
    let batch = batch(100);
    for _ in 0..20 {
        fitness(&mut auto, &batch).unwrap();
    }
    let [cpu, gpu] = [&of_cpu, &of_gpu].map(|parts| parts.load(Ordering::Relaxed));
    assert!(cpu >= 20 && gpu == 0, "{cpu} and {gpu}");
    drop(open);
    let mut later = (0..1000).map(|_| fitness(&mut auto, &batch).unwrap());
    assert!(later.any(|_| of_gpu.load(Ordering::Relaxed) > 0));
}

#[test]
fn a_long_batch_opens_the_gpu_at_once() {
    let (there, parts) = slow("a card", 0);
    let mut auto = Auto::new(Box::new(cpu()), 1, "a card".into(), Box::new(move || Ok(there)));
    let large = batch_of(150, 200_000);
    assert_eq!(
        fitness(&mut auto, &large).unwrap(),
        fitness(&mut Cpu::new(None).unwrap(), &large).unwrap()
    );
    assert_eq!(parts.load(Ordering::Relaxed), 1);
}

#[test]
fn the_cpu_does_what_a_gpu_can_not() {
    let failing = |error: fn() -> Error| -> (Vec<String>, String) {
        let mut auto = Auto::new(
            Box::new(cpu()),
            1,
            "a card".into(),
            Box::new(move || Ok(Box::new(Failing(error)))),
        );
        let large = batch_of(150, 200_000);
        assert_eq!(
            fitness(&mut auto, &large).unwrap(),
            fitness(&mut Cpu::new(None).unwrap(), &large).unwrap()
        );
        (auto.warnings().to_vec(), auto.device().name)
    };
    let (warnings, name) = failing(|| Error::TooLarge("a card: too large".into()));
    assert_eq!(warnings, ["a card: too large; the CPU evaluates this batch"]);
    assert_eq!(name, "cpu or a card");
    let (warnings, name) = failing(|| Error::NoDevice("a card refuses the kernel".into()));
    assert_eq!(
        warnings,
        ["a card refuses the kernel; from now on the CPU evaluates everything"]
    );
    assert_eq!(name, "cpu");
}

/// A device that always fails.
struct Failing(fn() -> Error);

impl Evaluator for Failing {
    fn device(&self) -> Device {
        Device {
            name: "a card".into(),
            detail: String::new(),
            exact: true,
        }
    }

    fn evaluate_part(&mut self, _: &Part<'_>, _: &Control) -> Result<PartResult, Error> {
        Err((self.0)())
    }
}
