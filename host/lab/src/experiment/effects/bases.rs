//! Small experiments in which, all together, every key has an effect.

use std::sync::LazyLock;

use oneiro::parameter::Choice;
use oneiro_evolve::Kind;

/// Name, and text. Files are looked for from `experiments/`. An optimiser that none of those below has gets a base here.
pub(super) static BASES: LazyLock<Vec<(&str, &str)>> = LazyLock::new(|| {
    let names = Kind::entries().map(|entry| entry.name);
    let is_missing = |name: &&str| {
        let kind = format!("kind = '{name}'");
        *name != Kind::default().word() && !WRITTEN.iter().any(|(_, text)| text.contains(&kind))
    };
    let base = |name: &'static str| {
        let text = format!(
            "cycles = 40\n[evolution]\nkind = '{name}'\npopulation = 8\ngenerations = 4\nfinalists = 2\nfinalist_lives = 2\n"
        );
        (name, &*text.leak())
    };
    let missing = names.filter(is_missing).map(base);
    WRITTEN.iter().copied().chain(missing).collect()
});

const WRITTEN: &[(&str, &str)] = &[
    ("khepera", KHEPERA),
    ("files", FILES),
    ("start", START),
    ("several worlds", SEVERAL_WORLDS),
    ("rectangle", RECTANGLE),
    ("vast", VAST),
    ("ring", RING),
    ("nest", NEST),
    ("uniform", UNIFORM),
    ("rank", RANK),
    ("roulette", ROULETTE),
    ("tournament", TOURNAMENT),
    ("cma-es", CMA_ES),
    ("sep-cma-es", SEP_CMA_ES),
    ("open-es", OPEN_ES),
    ("centroids", CENTROIDS),
    ("grid-elites", GRID_ELITES),
    ("novelty", NOVELTY),
    ("random", RANDOM),
    ("grid", GRID),
    ("race", RACE),
    ("recurrent", RECURRENT),
    ("surrogate", SURROGATE),
    ("sampled from reality", FROM_REALITY),
    ("preset", PRESET),
    ("parametric", PARAMETRIC),
    ("learning network", LEARNING),
    ("picture", PICTURE),
    ("sampled wheels", SAMPLED_WHEELS),
    ("parametric surrogate", PARAMETRIC_SURROGATE),
    ("polygon", POLYGON),
    ("swarm", SWARM),
    ("pucks", PUCKS),
    ("drawn pucks", DRAWN_PUCKS),
    ("model", MODEL),
    ("state machine", STATE_MACHINE),
    ("coevolution", COEVOLUTION),
    ("forager", FORAGER),
    ("forager with a network", FORAGER_NETWORK),
    ("custom", CUSTOM),
    ("genes with ranges", RANGED),
    ("flat", FLAT),
    ("flat, diagonal", FLAT_DIAGONAL),
    ("foragers", FORAGERS),
    ("two cases", TWO_CASES),
    ("random case", RANDOM_CASE),
    ("right simulators", RIGHT_SIMULATORS),
    ("no light", NO_LIGHT),
];

const KHEPERA: &str = "
cycles = 60
trials = 2
trial_score = 'least'
[arena]
width_mm = 200
height_mm = 180
obstacles = [{ x_mm = 95, y_mm = 80, radius_mm = 10 }]
walls = [
    { from_mm = [0, 0], to_mm = [200, 0] }, { from_mm = [200, 0], to_mm = [200, 180] },
    { from_mm = [200, 180], to_mm = [0, 180] }, { from_mm = [0, 180], to_mm = [0, 0] },
]
[noise]
sensor = [-0.1, 0.2]
walk_range_mm = 10
walk_step_mm = 3
motor = 0.1
gain = 0.1
veer_turns_per_m = 0.2
delay_cycles = 0.3
[controller]
kind = 'hidden'
units = 2
[task]
new_cell = 1
[evolution]
population = 8
parents = 4
elite = 1
generations = 3
initial = [-2, 2]
limits = [-2.5, 2.5]
finalists = 2
finalist_lives = 3
crossover = { kind = 'uniform', rate = 0.6, share = 0.3 }
mutation = { kind = 'add_normal', per = 'gene', rate = 0.5, amount = 0.5 }
";

const FILES: &str = "
cycles = 40
[robot]
tables = 'surrogate:1'
motors = 'surrogate:1'
states = 'asymmetric'
turn_before_move = 0.3
collision = 'keep_turn'
[arena]
width_mm = 200
height_mm = 160
blocks = [{ x_mm = 90, y_mm = 80, length_mm = 30, width_mm = 20, heading_turns = 0.1 }]
[evolution]
population = 2
parents = 2
generations = 3
finalists = 1
finalist_lives = 2
init = '../tests/resolved/genomes.csv'
mutation = { kind = 'flip_bits', bits = 5, rate = 0.2 }
";

const START: &str = "
cycles = 200
[start]
kind = 'at'
x_mm = 60
y_mm = 70
heading_turns = 0.2
[evolution]
population = 4
parents = 2
generations = 3
finalists = 0
common_random_numbers = true
mutation.kind = 'replace'
";

const SEVERAL_WORLDS: &str = "
cycles = 60
trials = 4
[arena]
width_mm = 300
height_mm = 260
obstacles = [{ x_mm = 150, y_mm = 130, radius_mm = 20 }]
[start]
kind = 'poses'
poses = [[60, 60, 0.1], [240, 60, 0.2], [60, 200, 0.8]]
[worlds]
count = 3
seed = 1
[worlds.vary]
'arena.obstacles[0].x_mm' = [120, 180]
[worlds.choose]
'arena.obstacles[0].radius_mm' = [10, 30]
[evolution]
population = 4
parents = 2
generations = 2
finalists = 0
";

const VAST: &str = "
cycles = 10
[arena]
width_mm = 100000
height_mm = 100000
[start]
kind = 'zone'
x_mm = 50000
y_mm = 50000
sides_mm = [120, 90]
[evolution]
population = 4
parents = 2
generations = 2
finalists = 0
";

const RECTANGLE: &str = "
cycles = 60
[arena]
width_mm = 400
height_mm = 350
[start]
kind = 'zone'
x_mm = 190
y_mm = 170
sides_mm = [120, 90]
[evolution]
population = 4
parents = 2
generations = 2
finalists = 0
";

const RING: &str = "
cycles = 60
[arena]
width_mm = 400
height_mm = 350
[start]
kind = 'zone'
x_mm = 190
y_mm = 170
radius_mm = 100
inner_radius_mm = 50
[evolution]
population = 4
parents = 2
generations = 2
finalists = 0
";

const NEST: &str = "
cycles = 40
trials = 2
[robot]
preset = 'epuck'
count = 2
[arena]
width_mm = 700
height_mm = 500
patches = [{ x_mm = 200, y_mm = 250, radius_mm = 150 }, { x_mm = 500, y_mm = 250, radius_mm = 150, grey = 0.5 }]
[start]
kind = 'zone'
patch = 0
[task]
kind = 'reach'
values.goal = 1
[evolution]
population = 4
parents = 2
generations = 2
finalists = 0
";

const UNIFORM: &str = "
cycles = 200
[evolution]
population = 6
parents = 3
elite = 1
generations = 3
finalists = 0
selection.kind = 'uniform'
mutation = { kind = 'add_vector', rate = 0.9, amount = 2 }
";

const RANK: &str = "
cycles = 200
[evolution]
population = 6
elite = 1
generations = 3
finalists = 0
selection = { kind = 'rank', pressure = 1.5 }
mutation = { kind = 'evostick', rate = 0.4, amount = 2 }
crossover = { kind = 'one_point', rate = 0.5 }
";

const ROULETTE: &str = "
cycles = 200
[evolution]
population = 6
generations = 3
finalists = 0
selection = { kind = 'roulette', scaling = 1.5 }
crossover = { kind = 'two_point', rate = 0.5 }
";

const TOURNAMENT: &str = "
cycles = 200
[evolution]
population = 6
generations = 3
finalists = 0
selection = { kind = 'tournament', size = 3 }
";

const CMA_ES: &str = "
cycles = 200
[evolution]
kind = 'cma-es'
population = 8
generations = 4
finalists = 0
limits = [-1, 1]
";

const SEP_CMA_ES: &str = "
cycles = 200
[evolution]
kind = 'sep-cma-es'
population = 8
generations = 4
finalists = 0
";

const FLAT: &str = "
cycles = 2
robot.kind = 'forager'
controller.kind = 'behaviours'
task.kind = 'foraging'
[evolution]
kind = 'cma-es'
population = 8
generations = 30
finalists = 0
";

const FLAT_DIAGONAL: &str = "
cycles = 2
robot.kind = 'forager'
controller.kind = 'behaviours'
task.kind = 'foraging'
[evolution]
kind = 'sep-cma-es'
population = 8
generations = 30
finalists = 0
";

const OPEN_ES: &str = "
cycles = 200
[evolution]
kind = 'open-es'
population = 8
generations = 3
finalists = 0
strategy.sigma = 0.02
strategy.learning_rate = 0.01
strategy.weight_decay = 0.1
";

const GRID_ELITES: &str = "
cycles = 40
[evolution]
kind = 'map-elites'
population = 8
generations = 4
finalists = 0
descriptors = [{ measure = 'end_x_mm', least = 0, greatest = 600, cells = 4 }, { measure = 'end_y_mm', least = 0, greatest = 350, cells = 4 }]
archive = { reevaluated = 2, offset = -1 }
";

const CENTROIDS: &str = "
cycles = 40
[evolution]
kind = 'map-elites'
population = 8
generations = 4
finalists = 1
finalist_lives = 2
descriptors = [{ measure = 'end_x_mm', least = 0, greatest = 600 }]
archive = { cells = 'centroidal', centroids = 5, reevaluated = 2, acceptance = 'mean' }
";

const NOVELTY: &str = "
cycles = 40
[evolution]
kind = 'novelty'
population = 6
parents = 3
generations = 4
finalists = 0
descriptors = [{ measure = 'end_x_mm', least = 0, greatest = 600 }, { measure = 'end_y_mm', least = 0, greatest = 350 }]
novelty = { neighbours = 2, added = 2 }
";

const RANDOM: &str = "
cycles = 200
[evolution]
kind = 'random'
population = 4
episodes = 12
finalists = 1
finalist_lives = 2
";

const GRID: &str = "
cycles = 200
robot.kind = 'forager'
arena.radius_mm = 300
controller.kind = 'behaviours'
task.kind = 'foraging'
[evolution]
kind = 'grid'
grid.levels = 3
finalists = 0
";

const RACE: &str = "
cycles = 40
[evolution]
kind = 'race'
race = { lives = 400, first_test = 2, confidence = 0.9 }
finalists = 0
";

const RECURRENT: &str = "
cycles = 40
controller.kind = 'recurrent'
[task]
speed = 'signed'
difference = 'square'
activation = 'perceived'
[noise]
sensor = [0.0, 0.3]
[evolution]
population = 4
parents = 2
generations = 2
finalists = 0
";

const SURROGATE: &str = "
cycles = 200
[evolution]
population = 4
parents = 2
generations = 3
finalists = 1
finalist_lives = 2
[reality]
robot = 'surrogate:1'
generations = 1
severity = 1.0
motion_severity = 0.8
[reality.differences]
geometry = 0.5
";

const FROM_REALITY: &str = "
cycles = 200
robot.tables = 'reality'
robot.motors = 'reality'
[evolution]
population = 4
parents = 2
generations = 2
finalists = 0
[reality]
robot = 'surrogate:1'
generations = 1
";

const PRESET: &str = "
cycles = 40
robot.preset = 'epuck'
[arena]
width_mm = 250
height_mm = 220
lights = [{ x_mm = 100, y_mm = 90 }]
patches = [{ x_mm = 50, y_mm = 60, sides_mm = [80, 50], grey = 0.5 }]
[evolution]
population = 4
parents = 2
generations = 2
finalists = 0
";

const PARAMETRIC: &str = "
cycles = 60
[robot]
kind = 'differential'
body_radius_mm = 30
wheel_base_mm = 50
greatest_speed_mm_s = 200
speeds = 20
acceleration_mm_s2 = 500
latency_cycles = 1
battery_s = 3
battery_ends_life = true
wheel_noise = 0.1
wheel_noise_law = 'normal'
collision = 'slide'
sensors = [
    { name = 'a', kind = 'distance', heading_turns = 0.05, bearing_turns = 0.02, offset_mm = 25, range_mm = 150 },
    { name = 'b', kind = 'proximity', heading_turns = -0.1, bearing_turns = -0.12, offset_mm = 28, range_mm = 100, response = [[0, 1], [40, 0.3]] },
    { name = 'c', kind = 'bumper', heading_turns = 0.1, range_mm = 20, width_turns = 0.4 },
    { name = 'd', kind = 'light', heading_turns = 0.2, bearing_turns = 0.18, offset_mm = 20, range_mm = 300, law = 'exponential' },
    { name = 'e', kind = 'ground', heading_turns = 0.1, offset_mm = 20 },
    { name = 'f', kind = 'battery' },
]
[arena]
width_mm = 300
height_mm = 260
floor = 0.8
obstacles = [{ x_mm = 200, y_mm = 150, radius_mm = 20 }]
blocks = [{ x_mm = 90, y_mm = 180, length_mm = 30, width_mm = 20, heading_turns = 0.1 }]
walls = [
    { from_mm = [0, 0], to_mm = [300, 0] }, { from_mm = [300, 0], to_mm = [300, 260] },
    { from_mm = [300, 260], to_mm = [0, 260] }, { from_mm = [0, 260], to_mm = [0, 0] },
]
lights = [{ x_mm = 100, y_mm = 90, brightness = 0.8 }]
patches = [
    { x_mm = 150, y_mm = 100, radius_mm = 70, grey = 0.3, charges = true },
    { x_mm = 150, y_mm = 200, sides_mm = [120, 60], heading_turns = 0.1, grey = 0.6 },
]
[controller]
kind = 'network'
outputs = 'weighted'
activation = 'tanh'
slope = 0.7
layers = [
    { kind = 'dense', units = 2, activation = 'tanh', slope = 0.8, biases = false },
    { kind = 'elman', units = 2, activation = 'logistic', slope = 1.2 },
    { kind = 'ctrnn', units = 3, time_constants_s = [0.2, 2] },
    { kind = 'lstm', units = 2 },
]
[evolution]
population = 4
parents = 2
generations = 2
finalists = 0
initial = [-3, 3]
initial_shares = []
";

const LEARNING: &str = "
cycles = 200
[controller]
kind = 'network'
outputs = 'first_two'
layers = [{ kind = 'plastic', units = 2, slope = 1.5, initial_strengths = [0.1, 0.6] }]
[evolution]
population = 4
parents = 2
generations = 2
finalists = 0
initial = [-10, 10]
";

const PICTURE: &str = "
cycles = 60
[robot]
kind = 'differential'
body_radius_mm = 20
wheel_base_mm = 30
greatest_speed_mm_s = 250
collision = 'slide'
sensors = [
    { name = 'a', kind = 'ground', heading_turns = 0.1, offset_mm = 15 },
    { name = 'b', kind = 'ground', heading_turns = -0.1, offset_mm = 15 },
    { name = 'c', kind = 'proximity', range_mm = 60 },
]
[arena]
width_mm = 300
height_mm = 260
floor = 0.6
picture = { file = 'line-follower/track.png', x_mm = 140, y_mm = 120, sides_mm = [220, 190], cell_mm = 7 }
[evolution]
population = 6
parents = 2
generations = 2
finalists = 0
initial = [-3, 3]
";

const SAMPLED_WHEELS: &str = "
cycles = 40
[robot]
kind = 'differential'
tables = 'khepera'
motors = 'khepera'
states = 'evorobot'
turn_before_move = 0.4
sensors = [{ name = 'left', kind = 'sampled', column = 0 }, { name = 'front', kind = 'sampled', column = 3 }, { name = 'near', range_mm = 50 }]
[controller]
kind = 'network'
interleaved = true
[evolution]
population = 4
parents = 2
generations = 2
finalists = 0
";

const PARAMETRIC_SURROGATE: &str = "
cycles = 40
[robot]
preset = 'khepera'
[evolution]
population = 4
parents = 2
generations = 2
finalists = 0
[reality]
robot = 'surrogate:1'
generations = 1
";

const POLYGON: &str = "
cycles = 40
[robot]
preset = 'epuck'
count = 3
sensors = [{ name = 'near', range_mm = 300 }, { name = 'sees', kind = 'sight', range_mm = 200, heading_turns = 0.1 }]
[arena]
corners_mm = [[0, 0], [500, 0], [500, 480], [0, 480]]
start_radius_mm = 220
patches = [{ x_mm = 250, y_mm = 240, radius_mm = 100 }]
[task]
kind = 'own'
part = 'evostick/cues.wgsl'
[evolution]
population = 4
parents = 2
generations = 2
finalists = 0
initial = [-3, 3]
";

const SWARM: &str = "
cycles = 40
[robot]
preset = 'epuck'
count = 3
genomes = [0, 1, 1]
contact = 'push'
starts_mm = [[60, 60], [150, 60], [60, 150]]
sensors = [{ name = 'sees', kind = 'sight', range_mm = 200, heading_turns = 0.1 }, { name = 'near', range_mm = 60 }, { name = 'floor', kind = 'ground', offset_mm = 20 }]
[arena]
width_mm = 220
height_mm = 210
patches = [{ x_mm = 110, y_mm = 110, radius_mm = 60 }]
[task]
kind = 'own'
part = 'evostick/cues.wgsl'
[evolution]
population = 4
parents = 2
generations = 2
finalists = 0
initial = [-3, 3]
";

const PUCKS: &str = "
cycles = 60
[robot]
preset = 'epuck'
count = 3
starts_mm = [[60, 60], [200, 60], [60, 200]]
sensors = [{ name = 'sees', kind = 'puck', range_mm = 400 }, { name = 'near', range_mm = 60 }, { name = 'has', kind = 'gripper' }]
[pucks]
count = 3
radius_mm = 20
yields = 0.7
grip_mm = 5
places_mm = [[130, 60], [60, 130], [220, 220]]
[arena]
width_mm = 320
height_mm = 310
patches = [{ x_mm = 110, y_mm = 110, radius_mm = 100 }]
[task]
kind = 'bring-pucks'
[evolution]
population = 6
parents = 2
generations = 2
finalists = 0
initial = [-3, 3]
";

const DRAWN_PUCKS: &str = "
cycles = 60
[robot]
preset = 'epuck'
count = 1
sensors = [{ name = 'sees', kind = 'puck', range_mm = 4000 }]
[pucks]
count = 20
radius_mm = 30
[arena]
width_mm = 3000
height_mm = 2000
[task]
kind = 'gather-pucks'
[evolution]
population = 6
parents = 2
generations = 2
finalists = 0
initial = [-3, 3]
";

const MODEL: &str = "
cycles = 40
[robot]
preset = 'epuck-rm1.1'
model = 'rm1.1'
count = 4
proximity_noise = 0.1
light_noise = 0.1
ground_noise = 0.1
grey_left = [0.4, 0.2]
grey_middle = [0.3, 0.1]
grey_right = [0.4, 0.2]
signal_range_mm = 300
signal_loss = 0.5
signal_cycles = 5
attraction = 2
body_height_mm = 80
[arena]
width_mm = 520
height_mm = 500
start_radius_mm = 240
wall_height_mm = 50
floor = 0.5
obstacles = [{ x_mm = 260, y_mm = 250, radius_mm = 20 }]
lights = [{ x_mm = -60, y_mm = 250, height_mm = 90, intensity = 0.4 }]
patches = [{ x_mm = 110, y_mm = 110, radius_mm = 90 }]
[controller]
kind = 'network'
layers = [{ units = 2 }]
[task]
kind = 'own'
part = 'evostick/cues.wgsl'
[evolution]
population = 4
parents = 2
generations = 2
finalists = 0
initial = [-3, 3]
";

const STATE_MACHINE: &str = "
cycles = 60
[robot]
preset = 'epuck-rm1.1'
model = 'rm1.1-vectors'
count = 3
[arena]
width_mm = 400
height_mm = 380
wall_height_mm = 50
lights = [{ x_mm = -60, y_mm = 190, height_mm = 90, intensity = 0.4 }]
patches = [{ x_mm = 110, y_mm = 110, radius_mm = 90 }]
[controller]
kind = 'state-machine'
obstacle = 0.2
avoidance = 4
attraction_avoidance = 5
least_vector = 0.2
slowest_wheel = -0.3
[task]
kind = 'own'
part = 'evostick/cues.wgsl'
[evolution]
population = 12
parents = 6
generations = 2
finalists = 0
";

const COEVOLUTION: &str = "
cycles = 40
[robot]
preset = 'khepera'
greatest_speed_mm_s = 160
count = 2
starts_mm = [[70, 100], [200, 100]]
[arena]
width_mm = 270
height_mm = 200
[sensor]
part = 'predator-prey/sensors.wgsl'
[controller]
kind = 'own'
part = 'predator-prey/controller.wgsl'
[task]
kind = 'own'
part = 'predator-prey/mission.wgsl'
[evolution]
kind = 'coevolution'
population = 4
parents = 2
generations = 4
initial = [-10, 10]
limits = [-10, 10]
finalists = 1
finalist_lives = 2
opponents = { first_gene = 'prey_to_left_0', kind = 'recent', generations = 2, contests = 2, total = 1 }
mutation = { kind = 'flip_bits', bits = 5, rate = 0.2 }
";

const FORAGER: &str = "
cycles = 300
[robot]
kind = 'forager'
[arena]
radius_mm = 300
nest_radius_mm = 150
food_items = 5
food_earns_s = 20
[controller]
kind = 'behaviours'
[task]
kind = 'foraging'
[evolution]
population = 6
parents = 3
generations = 2
finalists = 0
";

const FORAGER_NETWORK: &str = "
cycles = 100
robot.kind = 'forager'
arena.radius_mm = 250
arena.nest_radius_mm = 150
task.kind = 'foraging'
start = { kind = 'at', x_mm = 0, y_mm = 0 }
[evolution]
population = 6
parents = 3
generations = 2
finalists = 0
initial = [-10, 10]
";

const CUSTOM: &str = "
cycles = 40
[sensor]
part = 'homing/sensors.wgsl'
values.radius = 100
[controller]
kind = 'own'
part = 'homing/controller.wgsl'
[task]
kind = 'own'
part = 'homing/task.wgsl'
values.cycles = 40
[evolution]
population = 4
parents = 2
generations = 2
finalists = 0
";

const RANGED: &str = "
cycles = 40
robot.count = 3
robot.kind = 'differential'
robot.wheel_base_mm = 51
robot.greatest_speed_mm_s = 128
robot.sensors = [{ name = 'sees', kind = 'sight', range_mm = 100000 }]
arena = { width_mm = 500, height_mm = 500 }
[controller]
kind = 'own'
part = 'aggregation/controller.wgsl'
[task]
kind = 'own'
part = 'aggregation/mission.wgsl'
[evolution]
kind = 'cma-es'
population = 6
generations = 3
finalists = 0
";

const FORAGERS: &str = "
[swarm]
case = 'over'
robots = 16
minutes = 4
clock.interval_s = 20
clock.offset_s = 10
clock.installed_s = 20
messages = { range_mm = 600, heard = 0.9 }
simulators = { pairs = 2, leaves = 'oldest' }
arena = { radius_mm = 400, food_items = 8, food_scales = 'with_robots' }
";

const TWO_CASES: &str = "
[swarm]
case = 'over-then-opposite'
robots = 6
minutes = 3
messages = { range_mm = 600, heard = 0.9 }
simulators.pairs = 2
light_moves_minute = 1
control = 'fitness-shuffled'
";

const RANDOM_CASE: &str = "
[swarm]
case = 'random'
robots = 4
minutes = 2
";

const RIGHT_SIMULATORS: &str = "
[swarm]
case = 'opposite'
robots = 6
minutes = 3
messages = { range_mm = 600, heard = 0.9 }
simulators.pairs = 2
control = 'simulator-right'
";

const NO_LIGHT: &str = "
[swarm]
case = 'no-light'
robots = 6
minutes = 3
messages = { range_mm = 600, heard = 0.9 }
simulators.pairs = 2
arena.radius_mm = 400
";
