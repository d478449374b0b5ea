//! A checked world, with its kernel.

use std::ops::Range;
use std::sync::Arc;

use oneiro_shaders::{Kernel, episode};

use crate::batch::{Buffers, Variants, WorldKind, Worlds};
use crate::genes::{Gene, GeneLayout};
use crate::parameter::{Datum, Invalid};
use crate::parts::compose::{self, Composed, Detail, EpisodeKind, GREATEST_GENES, Kind, OwnPart, OwnParts};
use crate::random::Key;
use crate::world::described::{Battery, Genomes, Together};
use crate::world::physics::Physics;
use crate::world::robot::Build;
use crate::world::spec::{Controller, Task, WorldSpec};
use crate::world::{check, near, pack, reach};

/// A checked world, ready for episodes. Cheap to clone. If numbers of it vary, it has several variants, and each episode takes one.
#[derive(Clone, Debug)]
pub struct World(Arc<Checked>);

#[derive(Clone, Debug)]
struct Checked {
    spec: WorldSpec,
    kernel: &'static Kernel,
    genes: GeneLayout,
    details: Vec<Detail>,
    /// Words of a world of several robots.
    words: Option<u32>,
    /// Lines of a record in its traces.
    lines: u32,
    physics: Physics,
    packed: pack::Packed,
    /// Its variants; none if it is the only one.
    variants: Vec<World>,
    /// How an episode chooses one.
    choice: Variants,
}

/// The drawn numbers of a world's variants.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnNumbers {
    /// The numbers' keys, such as `arena.obstacles[0].x_mm`, and of a pair of numbers `noise.sensor[0]` and `[1]`; and their units.
    pub keys: Vec<(String, &'static str)>,
    /// Their values in each of [`World::variants`].
    pub values: Vec<Vec<Datum>>,
}

impl World {
    /// Checks every number and prepares the kernels' data.
    ///
    /// ```
    /// use oneiro::world::{World, WorldSpec};
    ///
    /// let world = World::new(WorldSpec { cycles: 100, ..WorldSpec::miglino1995() })?;
    /// assert_eq!(world.genes(), 18);
    ///
    /// let error = World::new(WorldSpec { cycles: 0, ..WorldSpec::miglino1995() }).unwrap_err();
    /// assert_eq!(error.to_string(), "cycles: is 0; allowed: 1 to 1000000");
    /// # Ok::<(), oneiro::parameter::Invalid>(())
    /// ```
    ///
    /// # Errors
    /// The first invalid value: its path, the value itself, and the allowed values.
    pub fn new(spec: WorldSpec) -> Result<Self, Invalid> {
        let episodes = if spec.surrogate.is_some() && spec.robot.build.described().is_some() {
            EpisodeKind::Individual
        } else {
            EpisodeKind::Simulated
        };
        Self::composed(spec, episodes, None)
    }

    /// The same, with a kernel for such episodes.
    /// Variants have the kernel of the `first` one.
    pub(crate) fn composed(mut spec: WorldSpec, episodes: EpisodeKind, first: Option<&Self>) -> Result<Self, Invalid> {
        if let Some(ready) = spec.task.ready().filter(|_| spec.own.get(Kind::Task).is_none()) {
            spec.own.insert(Arc::new(OwnPart::new(Arc::new(ready.part()?), &[])?));
        }
        let mut physics = check::check(&mut spec)?;
        near::decide(&mut physics, &spec, first.map(|first| &first.0.physics), |physics| {
            pack::shapes(&spec, physics)
        });
        let choice = spec.variants()?;
        if spec.varies() {
            return Self::varied(spec, choice, episodes);
        }
        let readings = spec.readings();
        let parts = match &spec.controller {
            Controller::Network(network) => spec.own.with_network(network, &spec.robot.build.fields())?,
            Controller::StateMachine(modules) => spec.own.with_state_machine(modules)?,
            Controller::BehaviourTree(modules) => spec.own.with_behaviour_tree(modules)?,
            _ => spec.own.clone(),
        };
        if physics.together().is_some() && ![EpisodeKind::Simulated, EpisodeKind::Observed].contains(&episodes) {
            let problem = "is set; allowed: only in the simulator";
            return Err(Invalid::new("robot.count", problem));
        }
        let owner = spec.owner(&physics, episodes)?;
        let Composed {
            kernel, genes, words, ..
        } = parts.compose(kernel(&spec, &physics), &owner)?;
        let members = physics.together().map_or(0, |swarm| swarm.count);
        let bodies = physics.together().map_or(0, Together::bodies);
        let genes = match (&spec.controller, genes) {
            (Controller::Own, Some(parts)) => parts.to_vec(),
            (controller, _) => controller.genes(&readings),
        };
        let packed = pack::Packed::new(&spec, &physics, &parts, genes.len())?;
        let world = Self(Arc::new(Checked {
            genes: layout(genes, physics.together())?.or_equal(first.map(|first| &first.0.genes)),
            details: parts.details(&owner),
            lines: if episodes == EpisodeKind::Observed || parts.are_commanded() {
                members.max(1)
            } else {
                1
            },
            words: words.map(|[world, body]| world + bodies * body),
            spec,
            kernel,
            physics,
            packed,
            variants: Vec::new(),
            choice,
        }));
        if world.kernel().variants.is_empty() {
            // The turns of its loops depend on the world.
            Worlds::new(&[&world]).map_err(|invalid| {
                let key = key_of_turns(world.spec(), &parts);
                Invalid::new(key, compose::too_many_turns(&invalid.problem))
            })?;
        }
        Ok(world)
    }

    /// A world with these variants.
    fn varied(spec: WorldSpec, choice: Variants, episodes: EpisodeKind) -> Result<Self, Invalid> {
        let variant = |index: usize, first: Option<&Self>| {
            let pose = index % choice.starts as usize;
            let own = spec.variant(choice, index)?;
            Self::composed(own, episodes, first).map_err(|invalid| {
                if choice.drawn == 1 || index < choice.starts as usize && spec.varied.vary.0.is_empty() {
                    let problem = match spec.robot.count() as usize {
                        1 => format!("has an invalid pose {pose}: {invalid}"),
                        robots => format!(
                            "has invalid poses {} to {}, those of robots 0 to {} in a trial: {}",
                            pose * robots,
                            (pose + 1) * robots - 1,
                            robots - 1,
                            invalid.problem
                        ),
                    };
                    return Invalid::new("start.poses", problem);
                }
                let world = index / choice.starts as usize;
                let problem = format!("makes world {world} of {} invalid: {invalid}", choice.drawn);
                Invalid::new("worlds", problem)
            })
        };
        let first = &variant(0, None)?;
        let others = (1..choice.count()).map(|index| variant(index, Some(first)));
        let variants: Vec<Self> = std::iter::once(Ok(first.clone()))
            .chain(others)
            .collect::<Result<_, _>>()?;
        if variants.iter().any(|other| other.kernel().name != first.kernel().name) {
            let problem = "changes more than numbers: some worlds need another kernel; allowed: ranges that leave out 0 where it \
                           turns something off";
            return Err(Invalid::new("worlds", problem));
        }
        Ok(Self(Arc::new(Checked {
            spec,
            choice,
            variants: variants.clone(),
            ..(*first.0).clone()
        })))
    }

    /// The world of an episode with this key: a variant, or this one. Its [`World::spec`] has the numbers of the episode.
    pub fn of(&self, key: Key) -> &Self {
        self.0.variants.get(self.0.choice.of(key)).unwrap_or(self)
    }

    /// The number of that variant.
    pub fn variant(&self, key: Key) -> usize {
        self.0.choice.of(key)
    }

    /// All its variants, of which each episode takes one; only itself if nothing varies.
    pub fn variants(&self) -> &[Self] {
        if self.0.variants.is_empty() {
            std::slice::from_ref(self)
        } else {
            &self.0.variants
        }
    }

    /// The drawn numbers of its variants; no keys if none is drawn.
    pub fn drawn(&self) -> DrawnNumbers {
        // The world was made with them.
        let keys = self.spec().drawn(self.0.choice).unwrap_or_default();
        let mut drawn = DrawnNumbers {
            keys: Vec::new(),
            values: vec![Vec::new(); self.variants().len()],
        };
        for key in keys {
            for (number, variant) in self.variants().iter().enumerate() {
                let Some((datum, unit)) = variant.spec().number_of(&key) else {
                    continue;
                };
                let (keys, values) = match datum {
                    Datum::List(pair) => ((0..pair.len()).map(|index| format!("{key}[{index}]")).collect(), pair),
                    single => (vec![key.clone()], vec![single]),
                };
                drawn.values[number].extend(values);
                if number == 0 {
                    drawn.keys.extend(keys.into_iter().map(|key| (key, unit)));
                }
            }
        }
        drawn
    }

    /// The same world of a swarm, observed: its episodes have the same bits, and each record of their traces has a
    /// line for each robot, which [`Trace::by_robot`](crate::batch::Trace::by_robot) takes apart. The records' fitness is that of a
    /// episode that ends there.
    ///
    /// # Errors
    /// A single robot's world; loops that turn too often, as for [`World::new`].
    pub fn observed(&self) -> Result<Self, Invalid> {
        if self.0.physics.together().is_none() {
            let problem = "is not set; allowed: only swarms are observed";
            return Err(Invalid::new("robot.count", problem));
        }
        Self::composed(self.0.spec.clone(), EpisodeKind::Observed, None)
    }

    /// Specification that it was made from.
    pub fn spec(&self) -> &WorldSpec {
        &self.0.spec
    }

    /// Number of genes of its robot's controller.
    pub fn genes(&self) -> usize {
        self.0.genes.genes()
    }

    /// Details of each record in a trace of its episodes.
    pub fn details(&self) -> &[Detail] {
        &self.0.details
    }

    /// Genes of its controller.
    pub fn gene_layout(&self) -> &GeneLayout {
        &self.0.genes
    }

    /// A robot's part of a genome; robots of a team have the same.
    pub fn genes_of(&self, robot: u32) -> Range<usize> {
        let genes = self.0.genes.controller().len();
        let genome = self.0.physics.together().map_or(0, |swarm| swarm.genomes.of(robot));
        let first = genome as usize * genes;
        first..first + genes
    }

    /// Number of cycles of an episode.
    pub fn cycles(&self) -> u32 {
        self.0.spec.cycles
    }

    /// Number of robots.
    pub fn robots(&self) -> u32 {
        self.0.physics.together().map_or(1, |swarm| swarm.count)
    }

    /// Whether its task has a score that need not be the sum of all rewards.
    pub(crate) fn is_scored(&self) -> bool {
        let task = self.0.spec.own.get(Kind::Task).map(OwnPart::part);
        let score = if self.0.words.is_some() {
            "mission_score"
        } else {
            "task_score"
        };
        task.is_some_and(|part| part.functions().contains(&score))
    }

    /// Number of pucks.
    pub fn pucks(&self) -> u32 {
        self.0
            .physics
            .together()
            .map_or(0, |swarm| swarm.bodies() - swarm.count)
    }

    /// Whether walls and objects keep a robot within the arena, as far as a grid of half the body's radius shows; `None` if the
    /// arena is too large for such a grid.
    pub fn is_enclosed(&self) -> Option<bool> {
        let of_each = self
            .a_few()
            .map(|world| reach::is_enclosed(world.spec(), &world.0.physics));
        of_each.reduce(|all, one| Some(all? && one?))?
    }

    /// Keys of the walls, obstacles, blocks and patches that no robot gets near enough to notice, such as `arena.patches[2]`, and of
    /// starts outside of the arena (`start`, `robot.starts_mm`), as far as the same grid shows. None in an arena that is too large for
    /// it, and none of a forager's.
    pub fn unreached(&self) -> Vec<String> {
        let of_each = self
            .a_few()
            .map(|world| reach::unreached(world.spec(), &world.0.physics));
        of_each
            .reduce(|all, one| all.into_iter().filter(|key| one.contains(key)).collect())
            .unwrap_or_default()
    }

    /// Enough variants to judge all.
    fn a_few(&self) -> impl Iterator<Item = &Self> {
        const FEW: usize = 8;
        let variants = self.variants();
        variants.iter().step_by(variants.len().div_ceil(FEW))
    }

    /// Estimated share of the field, 0 to 1, where a robot's body touches nothing.
    pub fn free_share(&self) -> f32 {
        self.0.packed.free_share
    }

    /// Kernel that simulates it.
    pub fn kernel(&self) -> &'static Kernel {
        self.0.kernel
    }
}

/// Genes of all controllers of a world.
fn layout(controller: Vec<Gene>, together: Option<&Together>) -> Result<GeneLayout, Invalid> {
    let names = together.map_or_else(Vec::new, |swarm| swarm.genomes.names(swarm.count));
    if names.is_empty() {
        return Ok(GeneLayout::new(controller));
    }
    let [genomes, genes] = [names.len(), controller.len()];
    if genomes * genes > GREATEST_GENES as usize {
        let problem = format!(
            "makes {genomes} genomes of {genes} genes each, {}; allowed: up to {GREATEST_GENES} genes in all, with fewer teams or a \
             smaller controller",
            genomes * genes
        );
        return Err(Invalid::new("robot.genomes", problem));
    }
    Ok(GeneLayout::several(controller, &names))
}

/// The key of what makes a cycle's loops turn too often: the robot's sensors, if they do so without these parts, which are a
/// user's and a network.
fn key_of_turns(spec: &WorldSpec, parts: &OwnParts) -> String {
    let without = || {
        let mut spec_without = WorldSpec {
            controller: Controller::Perceptron,
            task: Task::AVOIDANCE,
            own: OwnParts::default(),
            ..spec.clone()
        };
        if let Build::Differential(robot) = &mut spec_without.robot.build {
            robot.genomes = Genomes::Homogeneous;
        }
        spec_without
    };
    match spec.own.iter().last().or(parts.iter().last()) {
        Some(part) if World::new(without()).is_ok() => part.key(),
        _ => "robot.sensors".to_owned(),
    }
}

/// The shipped kernel of a world, with a perceptron instead of a controller that is composed.
fn kernel(spec: &WorldSpec, physics: &Physics) -> &'static Kernel {
    // A parametric robot's surrogate is composed from the simulator's parts.
    match (&spec.controller, physics) {
        (Controller::Hidden { .. }, Physics::Individual(_)) => &oneiro_shaders::SURROGATE_HIDDEN,
        (Controller::Recurrent, Physics::Individual(_)) => &oneiro_shaders::SURROGATE_RECURRENT,
        (_, Physics::Individual(_)) => &oneiro_shaders::SURROGATE_PERCEPTRON,
        (Controller::Hidden { .. }, _) => &oneiro_shaders::LIFE_HIDDEN,
        (Controller::Recurrent, _) => &oneiro_shaders::LIFE_RECURRENT,
        (_, _) => &oneiro_shaders::LIFE_PERCEPTRON,
    }
}

impl WorldKind for World {
    /// A world was checked when it was made.
    fn check(&self) -> Result<(), Invalid> {
        Ok(())
    }

    fn kernel(&self) -> &'static Kernel {
        self.kernel()
    }

    fn genes(&self) -> usize {
        self.genes()
    }

    fn robots(&self) -> u32 {
        self.robots()
    }

    fn state_words(&self) -> u32 {
        let words = (self.0.kernel.stride("state") / size_of::<u32>()) as u32;
        self.0.words.unwrap_or(words)
    }

    fn record_words(&self) -> u32 {
        self.0.lines * (self.0.kernel.stride("trace") / size_of::<u32>()) as u32
    }

    fn may_end_early(&self) -> bool {
        let task = self.0.spec.own.get(Kind::Task).map(OwnPart::part);
        if self.0.words.is_some() {
            return task.is_some_and(|part| part.functions().contains(&"mission_ends"));
        }
        let battery = self.0.physics.described().and_then(|robot| robot.battery);
        let ends = self.0.spec.own.iter().any(|own| own.part().end_function().is_some());
        ends || task.is_some() || matches!(battery, Some(Battery { ends_life: true, .. }))
    }

    fn variants(&self) -> Variants {
        self.0.choice
    }

    fn pack(&self, variant: usize, buffers: &mut Buffers) -> episode::World {
        let own = self.0.variants.get(variant).unwrap_or(self);
        let Checked {
            spec, physics, packed, ..
        } = &*own.0;
        packed.in_buffers(spec, physics, buffers)
    }
}
