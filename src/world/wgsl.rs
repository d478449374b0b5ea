//! Generates WGSL for a parametric robot: its memory, its motion and its readings.

use std::fmt::Write;

use oneiro_shader_compiler::declarations::is_reserved;

use crate::parameter::Invalid;
use crate::world::arena::{Arena, Patch};
use crate::world::described::{Battery, Described, Drive, GREATEST_SEEN_MEMBERS, Genomes, Together, WheelNoise};
use crate::world::discs::Discs;
use crate::world::reference::Reference;
use crate::world::sensors::{APART, Each, Feature, Planes, Sensor, Text, of_bumpers, of_rays};
use crate::world::spec::WorldSpec;
use crate::world::start::Start;
use crate::world::tables::SensorTables;

/// Generates the WGSL of a world's parametric robot, or of an individual that differs from it.
///
/// # Errors
/// Names of sensors that can't be fields.
pub(super) fn of(robot: &Described, spec: &WorldSpec, is_individual: bool) -> Result<String, Invalid> {
    check_names(robot)?;
    let arena = &spec.arena;
    let mut text = readings(robot, &spec.robot.sensors, arena, is_individual) + &drive(robot, arena);
    if let Some(together) = &robot.together {
        text += &constants(robot, together, spec);
    }
    if robot.grids.objects {
        let _ = writeln!(text, "const NEAR_CELL: u32 = {}u;", robot.own_cells(arena));
    }
    if robot.grids.patches {
        let _ = writeln!(text, "const PATCHES_CELL: u32 = {}u;", robot.patches_cell(arena));
    }
    if spec.arena.picture.is_some() {
        let _ = writeln!(text, "const PICTURE_CELL: u32 = {}u;", robot.picture_cell(arena));
    }
    Ok(text)
}

/// Refuses names of sensors that no field of `Readings` can have: words of WGSL, and the one that holds a user's sensors.
fn check_names(robot: &Described) -> Result<(), Invalid> {
    const OWN: &str = "own";
    let is_taken = |name: &str| name == OWN || is_reserved(name);
    match robot.sensors.iter().position(|sensor| is_taken(&sensor.name)) {
        None => Ok(()),
        Some(index) => {
            let name = &robot.sensors[index].name;
            let problem = format!("is `{name}`; allowed: a name that is neither `{OWN}` nor a reserved word of WGSL");
            Err(Invalid::new(format!("robot.sensors[{index}].name"), problem))
        }
    }
}

/// What a parametric robot remembers and how it moves, instead of `robot/differential.wgsl`.
fn drive(robot: &Described, arena: &Arena) -> String {
    let latency = robot.latency;
    // Fields besides `stuck`: the commands that are yet to take effect, the oldest first; the wheels' speeds; and the cycles since
    // the battery was full.
    let mut pairs: Vec<String> = (0..latency).map(|age| format!("command_{age}")).collect();
    let mut steps = String::new();
    if latency > 0 {
        steps += "    let due = robot.command_0;\n";
        for age in 1..latency {
            let _ = writeln!(steps, "    robot.command_{} = robot.command_{age};", age - 1);
        }
        let _ = writeln!(steps, "    robot.command_{} = speeds;\n    speeds = due;", latency - 1);
    }
    if robot.acceleration > 0.0 {
        pairs.push("speeds".to_owned());
        steps += "    let drive = drive_of(episode.world);
    let left = accelerated(drive, robot.speeds.x, speeds.x);
    let right = accelerated(drive, robot.speeds.y, speeds.y);
    robot.speeds = vec2<f32>(left.end, right.end);
    speeds = vec2<f32>(left.mean, right.mean);
";
    }
    let (mut members, mut kept) = (String::new(), String::new());
    for pair in pairs {
        let _ = writeln!(members, "    {pair}: vec2<f32>,");
        let _ = write!(kept, ", vec2<f32>(stored(robot.{pair}.x), stored(robot.{pair}.y))");
    }
    if robot.battery.is_some() {
        members += "    used: u32,\n";
        kept += ", robot.used";
    }
    if let Some((_, law)) = robot.wheel_noise() {
        let [drawn, left, right] = match law {
            WheelNoise::Uniform => ["units", "(2.0f * slips.x - 1.0f)", "(2.0f * slips.y - 1.0f)"],
            WheelNoise::Normal => ["normal_pair", "slips.x", "slips.y"],
        };
        let _ = writeln!(
            steps,
            "    let slips = {drawn}(random_words(episode.key, STREAM_ACTUATOR, step, 1u));
    let noise = numbers(episode.world, {}u).x;
    speeds.x *= 1.0f + noise * {left};
    speeds.y *= 1.0f + noise * {right};",
            robot.noise_cell(arena)
        );
    }
    let motion = match (&robot.drive, steps.is_empty()) {
        (Drive::Motors { .. }, true) => {
            "    return Driven(noisy_motion(episode, step, commanded(episode.world, outputs)), before);\n".to_owned()
        }
        (Drive::Motors { .. }, false) => format!(
            "    var robot = before;
    var speeds = commanded_speeds(episode.world, outputs);
{steps}    var moved = motion_between(episode.world, speeds);
    // Samples may have no speed 0.
    if (step < {latency}u) {{
        moved = Motion();
    }}
    return Driven(noisy_motion(episode, step, moved), robot);
"
        ),
        (Drive::Wheels(_), _) => format!(
            "    let wheels = wheels_of(episode.world);
    var robot = before;
    var speeds = vec2<f32>(speed_of(wheels, outputs.x), speed_of(wheels, outputs.y));
{steps}    return Driven(noisy_motion(episode, step, rolled(wheels, speeds)), robot);
"
        ),
    };
    let after = charged(robot, arena);
    let ends = if matches!(robot.battery, Some(Battery { ends_life: true, .. })) {
        "f32(robot.used) >= drive_of(world).cycles"
    } else {
        "false"
    };
    format!(
        "struct RobotState {{
    stuck: u32,
{members}}}
fn robot_kept(robot: RobotState) -> RobotState {{
    return RobotState(robot.stuck{kept});
}}
fn motion(episode: Episode, step: u32, outputs: vec2<f32>, before: RobotState) -> Driven {{
{motion}}}
fn robot_after(world: u32, end: vec3<f32>, before: RobotState) -> RobotState {{
    var robot = before;
{after}    return robot;
}}
fn robot_ends(world: u32, robot: RobotState) -> bool {{
    return {ends};
}}
"
    )
}

/// A cycle's use of the battery, and the floor's charge at its end.
fn charged(robot: &Described, arena: &Arena) -> String {
    let charges = |(_, patch): &(usize, &Patch)| patch.charges == Some(true);
    let charging = arena.patches.iter().enumerate().filter(charges);
    let is_on = |(index, _): (usize, &Patch)| format!("is_on_patch(world, {index}u, vec2<f32>(end.x, end.y))");
    let is_on: Vec<_> = charging.map(is_on).collect();
    match (robot.battery, &is_on[..]) {
        (None, _) => String::new(),
        (Some(_), []) => "    robot.used += 1u;\n".to_owned(),
        (Some(_), _) if robot.grids.patches => {
            "    robot.used = select(robot.used + 1u, 0u, is_charged(world, vec2<f32>(end.x, end.y)));\n".to_owned()
        }
        (Some(_), is_on) => format!("    robot.used = select(robot.used + 1u, 0u, {});\n", is_on.join(" | ")),
    }
}

/// The first cell of sensors; before it are those of the wheels and of the drive.
const FIRST_SENSOR: usize = 2;

/// The cell with the floor's grey; each sensor has two before it.
fn floor_cell(robot: &Described) -> usize {
    FIRST_SENSOR + 2 * robot.sensors.len()
}

/// The first cell of a sensor's response and the number of its points.
fn response_cells(robot: &Described, arena: &Arena, sensor: &Sensor) -> Option<[usize; 2]> {
    let response = sensor.response.as_ref()?;
    let responses = robot.responses().into_iter();
    let before: usize = responses
        .take_while(|other| *other != response)
        .map(|other| other.0.len())
        .sum();
    let first = floor_cell(robot) + 1 + arena.lights.len() + 2 * arena.patches.len();
    Some([first + before, response.0.len()])
}

/// The readings of a parametric robot, instead of those of `sensor/readings.wgsl` and `sensor/sampled.wgsl`. Those of an individual
/// differ from the description.
fn readings(robot: &Described, tables: &SensorTables, arena: &Arena, is_individual: bool) -> String {
    let (all, listed) = (robot.readings(), robot.sensors.len());
    let count = all.len();
    let each = |names: &[String], line: &dyn Fn(usize, &str) -> String| -> String {
        let lines = names.iter().enumerate();
        lines.map(|(index, name)| line(index, name)).collect()
    };
    let fields = each(&all, &|_, name| format!("    {name}: f32,\n"));
    let sum = each(&all, &|index, name| {
        format!("    sum += gene(episode, index + {index}u) * r.{name};\n")
    });
    // Four numbers are drawn at a time.
    let mut draws = String::new();
    for draw in 0..listed.div_ceil(4) {
        let words = format!("random_words(episode.key, STREAM_SENSOR, step, {draw}u)");
        let _ = writeln!(draws, "        let n{draw} = units({words}) * span + low;");
    }
    let noisy = each(&all[..listed], &|index, name| {
        let noise = format!("n{}.{}", index / 4, ["x", "y", "z", "w"][index % 4]);
        format!("        noisy.{name} = clamp(readings.{name} + {noise}, 0.0f, 1.0f);\n")
    });
    // One loop over all objects serves all sensors that measure objects.
    let mut text = Text {
        widest: "0.0f".to_owned(),
        ..Text::default()
    };
    let (mut read, mut highest, mut readings) = (String::new(), "0.0f".to_owned(), String::new());
    if is_individual {
        text.numbers += "    let gain = illumination(world, at);\n";
    }
    let (columns, planes) = (&robot.columns, Planes::new(tables.sensors(), &robot.columns));
    for (index, sensor) in robot.sensors.iter().enumerate() {
        let (kind, name) = (sensor.kind.entry(), &sensor.name);
        let each = Each {
            sensor,
            index,
            cell: FIRST_SENSOR + 2 * index,
            response: response_cells(robot, arena, sensor),
            column: columns[index].unwrap_or(0) as usize,
            is_individual,
        };
        let _ = writeln!(text.numbers, "    let s{index} = sensor_of(world, {}u);", each.cell);
        let _ = writeln!(text.numbers, "    let looks{index} = pose.z + s{index}.heading;");
        let reading = (kind.write)(&mut text, &each);
        if is_individual && kind.has(Feature::Analogue) {
            let ambient = if kind.has(Feature::SeesLight) {
                "cell.ambient"
            } else {
                "0.0f"
            };
            let word = format!("w{}.{}", index / 4, ["x", "y", "z", "w"][index % 4]);
            let _ = writeln!(
                read,
                "    read.{name} = read_with_noise(cell, readings.{name}, {ambient}, {word});"
            );
        }
        if kind.has(Feature::SeesNearness) {
            highest = format!("max({highest}, r.{name})");
        }
        let _ = writeln!(readings, "        {reading},");
    }
    let Text {
        mut numbers,
        mut objects,
        bumpers,
        rays,
        others,
        pressing,
        pucks,
        widest,
    } = text;
    objects += &of_rays(&rays);
    objects += &of_bumpers(&bumpers, &widest);
    if !objects.is_empty() {
        objects = format!(
            "        let to = toward(shape, at);
        let squared = squared_length(to);
        if (squared < shapes[shape].reach_squared) {{
{objects}        }}
"
        );
    }
    if let Some(first) = columns.iter().position(Option::is_some) {
        numbers += &planes.sums();
        objects += &planes.of_an_object(first);
    }
    if !objects.is_empty() {
        objects = format!(
            "    let first = near_first(world, at);
    let near = near_count(world, at);
    for (var index = 0u; index < near; index++) {{
        let shape = near_shape(world, first + index);
{objects}    }}
"
        );
    }
    if let Some((model, _)) = robot.model() {
        numbers += "    let given = given_to(episode, step, pose);\n";
        for reading in model.expressions() {
            let _ = writeln!(readings, "        {reading},");
        }
    }
    let among = among(robot, [&others, &pucks, &pressing], &widest);
    let (whose, world) = match robot.together {
        None => ("world: u32", ""),
        Some(_) => ("episode: Episode, step: u32", "    let world = episode.world;\n"),
    };
    let (floor, lights, patches) = (floor_cell(robot), arena.lights.len(), arena.patches.len());
    let individual = if is_individual {
        individual(robot, arena, &read)
    } else {
        String::new()
    };
    let counted = if planes.read.is_empty() {
        String::new()
    } else {
        format!("const PLANES: u32 = {}u;\n", planes.count)
    };
    format!(
        "struct Readings {{
{fields}    own: SensorReadings,
}}
const INPUTS: u32 = {count}u + OWN_READINGS;
const FLOOR_CELL: u32 = {floor}u;
const LIGHT_COUNT: u32 = {lights}u;
const PATCH_COUNT: u32 = {patches}u;
{counted}fn sense({whose}, pose: vec3<f32>, at: vec2<f32>, robot: RobotState) -> Readings {{
{world}{numbers}{objects}{among}    return Readings(
{readings}        SensorReadings(),
    );
}}
fn with_noise(episode: Episode, step: u32, readings: Readings) -> Readings {{
    let low = worlds[episode.world].sensor_noise_low;
    let span = worlds[episode.world].sensor_noise_span;
    var noisy = readings;
    if (span > 0.0f) {{
{draws}{noisy}    }}
    return noisy;
}}
fn highest(r: Readings) -> f32 {{
    return {highest};
}}
fn weighed(episode: Episode, index: u32, r: Readings) -> f32 {{
    var sum = 0.0f;
{sum}    return plus_weighed(episode, index + {count}u, r.own, sum);
}}
{individual}"
    )
}

/// Where an individual's differences are, and how its sensors are read out: `read` has a line for each.
fn individual(robot: &Described, arena: &Arena, read: &str) -> String {
    let mut words = String::new();
    for draw in 0..robot.sensors.len().div_ceil(4) {
        let _ = writeln!(
            words,
            "    let w{draw} = random_words(episode.key, STREAM_SENSOR, step, {draw}u);"
        );
    }
    format!(
        "const DIFFERENCE_CELL: u32 = {}u;
fn read_out(episode: Episode, step: u32, readings: Readings) -> Readings {{
    let cell = reading_cell(episode.world);
{words}    var read = readings;
{read}    return read;
}}
",
        robot.own_cells(arena)
    )
}

/// A robot's sensing of other robots and of pucks, given the code for each other robot, for each puck, and for those that press
/// bumpers, and the widest range of a bumper. None of a single robot's.
fn among(robot: &Described, [others, pucks, pressing]: [&str; 3], widest: &str) -> String {
    if robot.together.is_none() || others.is_empty() && pressing.is_empty() {
        return String::new();
    }
    let pressed = |apart: &str| {
        if pressing.is_empty() {
            return String::new();
        }
        let pressing = pressing.replace(APART, apart);
        format!(
            "            let near = {apart} + {widest};
            if (squared < near * near) {{
                let bearing = direction(to);
{pressing}            }}
"
        )
    };
    // Robots have the numbers before `count`, and pucks those after.
    let has_squares = robot.together.as_ref().is_some_and(|swarm| swarm.squares() > 0);
    let each = |from: &str, end: &str| {
        if !has_squares {
            return (
                format!("    for (var other = {from}; other < {end}; other++) {{\n"),
                String::new(),
            );
        }
        let search = format!(
            "    var search_to_{end} = search_for_sensors(episode, at);
    for (var turn = 0u; turn < SEARCH_TURNS; turn++) {{
        search_to_{end} = search_on(episode, search_to_{end});
        if (search_to_{end}.is_over) {{
            break;
        }}
        let other = search_to_{end}.body;
"
        );
        let found = format!("search_to_{end}.is_found & (other >= {from}) & (other < {end}) & ");
        (search, found)
    };
    let (search, found) = each("0u", "count");
    let mut text = format!(
        "    let members = members_of(world);
    let body_squared = members.body * members.body;
    let count = member_count(world);
{search}        let there = place_in(member_at(episode, other), MEMBER_X);
        let to = vec2<f32>(there.x - at.x, there.y - at.y);
        let squared = squared_length(to);
        if ({found}(other != episode.member) & (squared < members.reach_squared)) {{
{others}{}        }}
    }}
",
        pressed("2.0f * members.body")
    );
    if robot.pucks().is_some() {
        let pressed = pressed("apart");
        let (search, found) = each("count", "bodies");
        let _ = write!(
            text,
            "    let puck = pucks_of(world).radius;
    let apart = members.body + puck;
    let bodies = body_count(world);
{search}        let there = place_in(member_at(episode, other), MEMBER_X);
        let to = vec2<f32>(there.x - at.x, there.y - at.y);
        let squared = squared_length(to);
        if ({found}is_on_floor(episode, other) & (squared < members.reach_squared)) {{
            let body_squared = puck * puck;
{pucks}{pressed}        }}
    }}
"
        );
    }
    text
}

/// Where a robot starts: at its own place, or at a drawn one.
fn start_place(robot: &Described, together: &Together, spec: &WorldSpec) -> String {
    let arena = &spec.arena;
    if let Start::Zone(_) = spec.start {
        return "    return place_in_zone(world, u);\n".to_owned();
    }
    if together.starts.is_some() {
        let first = robot.differing_cell(arena);
        return format!("    let cell = numbers(world, {first}u + member);\n    return vec2<f32>(cell.x, cell.y);\n");
    }
    place_in_field(arena)
}

/// A robot's heading at the start: its own, or the drawn one.
fn start_heading(robot: &Described, together: &Together, spec: &WorldSpec) -> String {
    if together.headings.is_empty() {
        return "drawn".to_owned();
    }
    format!("numbers(world, {}u + member).w", robot.differing_cell(&spec.arena))
}

/// A random place in the field.
fn place_in_field(arena: &Arena) -> String {
    let place = if arena.is_field_round {
        "vec2<f32>(0.5f, 0.5f) + (0.5f * root(u.x)) * cosine_sine(u.y)"
    } else {
        "vec2<f32>(u.x, u.y)"
    };
    format!(
        "    let place = {place};
    return vec2<f32>(
        worlds[world].field_x + place.x * worlds[world].field_width,
        worlds[world].field_y + place.y * worlds[world].field_height,
    );
"
    )
}

/// Constants of pucks, and where one starts: at its own place, or at a drawn one.
fn pucks(robot: &Described, discs: &Discs, arena: &Arena) -> String {
    let cell = robot.pucks_cell(arena);
    let are_placed = !discs.places().is_empty();
    let place = if are_placed {
        format!(
            "    let cell = numbers(world, {}u + puck);\n    return vec2<f32>(cell.x, cell.y);\n",
            cell + 1
        )
    } else {
        place_in_field(arena)
    };
    // Those with a place of their own get it before a place is drawn for others.
    let are_first = are_placed && robot.start_places().is_empty();
    format!(
        "const PUCKS_CELL: u32 = {cell}u;
const PUCKS_FIRST: bool = {are_first};
fn puck_start(world: u32, puck: u32, u: vec4<f32>) -> vec2<f32> {{
{place}}}
"
    )
}

/// The index of a robot's first gene.
fn first_gene(robot: &Described, together: &Together, arena: &Arena) -> String {
    match together.genomes {
        Genomes::Homogeneous => "episode.genes".to_owned(),
        Genomes::Heterogeneous | Genomes::Teams(_) => {
            let first = robot.differing_cell(arena);
            format!("episode.genes + u32(numbers(episode.world, {first}u + member).z) * LANES")
        }
    }
}

/// Constants of a robot's world.
fn constants(robot: &Described, together: &Together, spec: &WorldSpec) -> String {
    let (arena, body_radius) = (&spec.arena, spec.robot.body_radius);
    let has_squares = together.squares() > 0;
    let greatest = together.bodies().max(GREATEST_SEEN_MEMBERS);
    let mut text = format!(
        "const GREATEST_MEMBERS: u32 = {greatest}u;
const MEMBERS_CELL: u32 = {}u;
fn start_place(world: u32, member: u32, u: vec4<f32>) -> vec2<f32> {{
{}}}
fn start_heading(world: u32, member: u32, drawn: f32) -> f32 {{
    return {};
}}
fn first_gene(episode: Episode, member: u32) -> u32 {{
    return {};
}}
",
        robot.members_cell(arena),
        start_place(robot, together, spec),
        start_heading(robot, together, spec),
        first_gene(robot, together, arena)
    );
    if let Some(discs) = &together.pucks {
        text += &pucks(robot, discs, arena);
    }
    if has_squares {
        let _ = writeln!(text, "const SQUARES_CELL: u32 = {}u;", robot.squares_cell(arena));
    }
    if together.model.is_some() {
        let (cell, sides) = (robot.reference_cell(arena), arena.sides);
        let inner = arena.walls.len() - sides + arena.obstacles.len() + arena.blocks.len();
        let hiding = inner + if arena.sides_hide_lamps(body_radius) { sides } else { 0 };
        let _ = write!(
            text,
            "const REFERENCE_CELL: u32 = {cell}u;
const LAMP_CELL: u32 = {}u;
const INNER_COUNT: u32 = {inner}u;
const SIDE_COUNT: u32 = {sides}u;
const HIDING_COUNT: u32 = {hiding}u;
",
            cell + Reference::CELLS,
        );
    }
    text
}
