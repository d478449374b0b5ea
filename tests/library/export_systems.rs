//! Controllers as programs of ARGoS and Webots and as a node of ROS 2: with stand-ins for these systems, whose robots read what is drawn
//! here, the wheels turn as the controller's outputs for these readings say. The readings of reference models are computed here anew, from
//! `docs/reference-models.md`.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;
use std::{env, fs, process};

use oneiro::arena::Arena;
use oneiro::cpu::Cpu;
use oneiro::differential::{Build, Differential, Response, Sensor, SensorKind};
use oneiro::export::{Controller, Fitted, Recorded, argos, aseba, ros2, webots};
use oneiro::parameter::Invalid;
use oneiro::random::{Key, pcg4d};
use oneiro::reference::{Model, Reference};
use oneiro::world::{self, Robot, World, WorldSpec};

use crate::epucks::epucks;
use crate::modules;
use crate::skips::skipped;

/// Directions of the rings of ARGoS's e-puck, degrees.
const RING: [f64; 8] = [17.0, 50.0, 90.0, 150.0, 210.0, 270.0, 310.0, 343.0];
const CYCLES: u32 = 120;
const ORIGIN: &[String] = &[];

/// A random number for a cycle, 0 to 1.
fn drawn(cycle: u32, what: u32) -> f64 {
    f64::from(pcg4d([cycle, what, 5, 77])[0] >> 8) / 16_777_216.0
}

/// A folder with files, of which a program is run; what it prints, by lines.
struct Bench(std::path::PathBuf);

impl Bench {
    fn new(name: &str) -> Self {
        let path = env::temp_dir().join(format!("oneiro-systems-{name}-{}", process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn write(&self, file: impl AsRef<Path>, text: impl AsRef<[u8]>) {
        let path = self.0.join(file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }

    /// `None` where the program isn't there.
    fn printed(&self, program: &str, arguments: &[&str]) -> Option<Vec<String>> {
        let mut command = Command::new(program);
        let Ok(output) = command.args(arguments).current_dir(&self.0).output() else {
            skipped("compilers", &format!("exported controllers by {program}"));
            return None;
        };
        let messages = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{program} {arguments:?}: {messages}");
        let text = String::from_utf8(output.stdout).unwrap();
        Some(text.lines().map(str::to_owned).collect())
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn numbers(line: &str) -> Vec<f64> {
    line.split_whitespace().map(|number| number.parse().unwrap()).collect()
}

/// The speeds that a controller wants for readings, cycle by cycle, as fractions of full speed.
fn wanted(controller: &Controller, key: [u32; 2], readings: &[Vec<f64>]) -> Vec<[f64; 2]> {
    let mut state = controller.reset(key, 0);
    let cycle = |readings: &Vec<f64>| {
        let readings: Vec<f32> = readings.iter().map(|reading| *reading as f32).collect();
        let outputs = controller.step(&mut state, &readings).unwrap();
        controller.wheels(outputs).unwrap().map(f64::from)
    };
    readings.iter().map(cycle).collect()
}

/// Whether a robot drove as it should.
fn assert_driven(what: &str, lines: &[String], wanted: &[[f64; 2]], full_speed: f64) {
    assert_eq!(lines.len(), wanted.len(), "{what}");
    for (cycle, (line, wanted)) in lines.iter().zip(wanted).enumerate() {
        for (found, wanted) in numbers(line).into_iter().zip(wanted) {
            let away = (found / full_speed - wanted).abs();
            assert!(away < 2e-5, "{what}, cycle {cycle}: {line} for {wanted:?}");
        }
    }
}

/// Whether that is not the same all the time.
fn assert_varied(what: &str, wanted: &[[f64; 2]]) {
    let [least, most] = [f64::min, f64::max].map(|of| wanted.iter().map(|speeds| speeds[0]).reduce(of).unwrap());
    assert!(most - least > 0.05, "{what}: {least} to {most}");
}

/// What ARGoS's e-puck reads in a cycle.
struct Sensed {
    proximity: [f64; 8],
    light: [f64; 8],
    /// Left, middle, right.
    ground: [f64; 3],
    /// Distance between the bodies, cm, and direction, turns.
    packets: Vec<[f64; 2]>,
}

fn sensed(cycle: u32) -> Sensed {
    // Some floors are black or white for long enough that the vote says so.
    let floor = [0.0, 0.5, 1.0][(cycle / 12 % 3) as usize];
    Sensed {
        proximity: std::array::from_fn(|place| drawn(cycle, place as u32)),
        // Dark for a while.
        light: std::array::from_fn(|place| drawn(cycle, 10 + place as u32) * if cycle < 20 { 0.19 } else { 1.0 }),
        ground: std::array::from_fn(|place| (floor + 0.04 * (drawn(cycle, 20 + place as u32) - 0.5)).clamp(0.0, 1.0)),
        packets: (0..cycle % 4)
            .map(|packet| [80.0 * drawn(cycle, 30 + packet), drawn(cycle, 40 + packet)])
            .collect(),
    }
}

fn sum(ring: &[f64; 8]) -> [f64; 2] {
    let parts = ring.iter().zip(RING);
    parts.fold([0.0, 0.0], |[x, y], (value, degrees)| {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        [x + value * cosine, y + value * sine]
    })
}

fn quarters([x, y]: [f64; 2]) -> [f64; 4] {
    [45.0_f64, 135.0, 225.0, 315.0].map(|degrees| {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        (x * cosine + y * sine).max(0.0)
    })
}

fn long([x, y]: [f64; 2], length: impl Fn(f64) -> f64) -> [f64; 2] {
    let now = x.hypot(y);
    if now == 0.0 {
        [0.0, 0.0]
    } else {
        [x, y].map(|part| part / now * length(now))
    }
}

/// The readings of a model, by docs/reference-models.md.
fn readings(model: Model, all: &[Sensed], reach: f64, memory: usize, factor: f64) -> Vec<Vec<f64>> {
    let cycle = |now: usize| {
        let Sensed {
            proximity,
            light,
            packets,
            ..
        } = &all[now];
        let voters: Vec<f64> = all[now.saturating_sub(4)..=now]
            .iter()
            .flat_map(|one| one.ground)
            .collect();
        let votes = |is: &dyn Fn(f64) -> bool| voters.iter().filter(|reading| is(**reading)).count() > 10;
        let floor = |grey: f64| match (votes(&|reading| reading < 0.03), votes(&|reading| reading > 0.85)) {
            (true, _) => 0.0,
            (_, true) => 1.0,
            _ => grey,
        };
        let heard = |packet: &&[f64; 2]| packet[0] < reach;
        let number = packets.iter().filter(heard).count() as f64;
        let messages = all[(now + 1).saturating_sub(memory)..=now]
            .iter()
            .flat_map(|one| &one.packets)
            .filter(heard);
        let attraction = messages.fold([0.0, 0.0], |[x, y], [range, turns]| {
            let (sine, cosine) = (TAU * turns).sin_cos();
            [x + factor * cosine / (1.0 + range), y + factor * sine / (1.0 + range)]
        });
        let neighbours = 1.0 - 2.0 / (1.0 + number.exp());
        let mut list = Vec::new();
        match model {
            Model::Rm11 => {
                list.extend(proximity.iter().chain(light));
                list.extend([0.41 + 0.5 * 0.18, 0.34 + 0.5 * 0.12, 0.42 + 0.5 * 0.18].map(floor));
                list.push(neighbours);
                list.extend(quarters(long(attraction, |length| 2.0 / (1.0 + (-length).exp()) - 1.0)));
            }
            Model::Rm12 => {
                list.extend(quarters(long(sum(proximity), |length| length.min(1.0))));
                let is_light = light.iter().any(|reading| *reading > 0.2);
                list.extend(quarters(long(sum(light), |_| f64::from(u8::from(is_light)))));
                list.push(floor(0.41 + 0.5 * 0.18));
                list.push(neighbours);
                list.extend(quarters(attraction));
            }
            Model::Vectors => {
                list.extend(sum(proximity));
                list.extend(sum(light));
                list.push(floor(0.5));
                list.push(number);
                list.extend(attraction);
            }
        }
        list
    };
    (0..all.len()).map(cycle).collect()
}

/// A program that runs `script.lua` as ARGoS does, with what the robot reads in each cycle; it prints the speeds of the wheels, cm/s.
fn of_argos(all: &[Sensed]) -> String {
    let ring = |values: &[f64; 8]| {
        let readings = values.iter().zip(RING);
        let readings: Vec<_> = readings
            .map(|(value, degrees)| format!("{{value={value:?},angle={:?}}}", degrees.to_radians()))
            .collect();
        readings.join(",")
    };
    let mut text = "local sent = 0
local function set_data(data)
    assert(#data == 4)
    sent = sent + 1
end
robot = {
    random = { uniform = function() return 0.25 end, gaussian = function(deviation) return 0.5 * deviation end },
    wheels = { set_velocity = function(left, right) print(string.format('%.9g %.9g', left, right)) end },
}
function log(text) error(text) end
local function sense(proximity, light, ground, packets)
    packets.set_data = set_data
    robot.proximity, robot.light, robot.ground, robot.range_and_bearing = proximity, light, ground, packets
    step()
end
dofile('script.lua')
init()
-- An episode before leaves nothing.
sense({}, {}, { left = 0, center = 0, right = 0 }, {{ range = 1, bearing = 1, data = {} }})
io.write('begin\\n')
reset()
"
    .to_owned();
    // Without rings, inputs are nothing: a whole robot.
    text = text.replace("sense({}, {},", &format!("sense({{{0}}}, {{{0}}},", ring(&[0.0; 8])));
    for one in all {
        let packets: Vec<_> = one
            .packets
            .iter()
            .map(|[range, turns]| format!("{{range={range:?},bearing={:?},data={{}}}}", TAU * turns))
            .collect();
        let [left, middle, right] = one.ground;
        let _ = writeln!(
            text,
            "sense({{{}}}, {{{}}}, {{left={left:?},center={middle:?},right={right:?}}}, {{{}}})",
            ring(&one.proximity),
            ring(&one.light),
            packets.join(",")
        );
    }
    text + "destroy()\n"
}

fn of_lua(bench: &Bench) -> Vec<Vec<String>> {
    let interpreters = ["lua5.1", "lua5.4"].iter();
    let printed = interpreters.filter_map(|lua| bench.printed(lua, &["driver.lua"]));
    printed
        .map(|lines| lines.into_iter().skip_while(|line| line != "begin").skip(1).collect())
        .collect()
}

/// A controller, printed with cycles that it checks itself by.
fn exported(world: &World, genome: u32, print: Print) -> (Controller, Vec<u8>) {
    let controller = Controller::new(world, &modules::genome(world, genome), 0).unwrap();
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let cycles = controller.record(&mut cpu, Key::rollout(3, 0, 0, 0)).unwrap();
    let text = print(&controller, "made", ORIGIN, &cycles[..4]).unwrap().bytes;
    (controller, text)
}

type Print = fn(&Controller, &str, &[String], &[Recorded]) -> Result<Fitted, Invalid>;

fn hall() -> Arena {
    let mut arena = Arena::polygon(
        &[[-900.0, -900.0], [900.0, -900.0], [900.0, 900.0], [-900.0, 900.0]],
        None,
    );
    arena.floor = Some(0.5);
    arena
}

#[test]
fn a_script_of_argos_reads_what_reference_models_read() {
    let bench = Bench::new("models");
    let all: Vec<_> = (0..CYCLES).map(sensed).collect();
    bench.write("driver.lua", of_argos(&all));
    let mut found = 0;
    for model in [Model::Rm11, Model::Rm12, Model::Vectors] {
        let reference = Reference {
            signal_range: Some(600.0),
            signal_cycles: Some(7),
            attraction: Some(3.0),
            ..Reference::DEFAULT
        };
        let spec = WorldSpec {
            robot: epucks(model, reference, 4),
            arena: hall(),
            controller: world::Controller::Recurrent,
            cycles: 20,
            ..WorldSpec::miglino1995()
        };
        let world = World::new(spec).unwrap();
        let (controller, text) = exported(&world, 4, argos);
        bench.write("script.lua", text);
        let body = f64::from(world.spec().robot.body_radius);
        let readings = readings(model, &all, (600.0 - 2.0 * body) / 10.0, 7, 3.0);
        let wanted = wanted(&controller, [0, 0], &readings);
        assert_varied("models", &wanted);
        for lines in of_lua(&bench) {
            assert_driven(
                &format!("{model:?}"),
                &lines,
                &wanted,
                f64::from(controller.full_speed.unwrap()) / 10.0,
            );
            found += 1;
        }
    }
    assert!(found == 6 || env::var_os("ONEIRO_MAY_SKIP").is_some());
}

#[test]
fn a_script_of_argos_gives_each_listed_sensor_its_own_place() {
    let sensor = |name: &str, kind, degrees: f32| Sensor {
        name: name.to_owned(),
        kind,
        heading: degrees / 360.0,
        range: (kind != SensorKind::Ground).then_some(50.0),
        offset: (kind == SensorKind::Ground).then_some(30.0),
        ..Sensor::default()
    };
    // As on the robot: clockwise from front right.
    let clockwise = [-17.0, -50.0, -90.0, -150.0, 150.0, 90.0, 50.0, 17.0];
    let mut sensors: Vec<_> = clockwise
        .iter()
        .enumerate()
        .map(|(place, degrees)| sensor(&format!("prox_{place}"), SensorKind::Proximity, *degrees))
        .collect();
    sensors.push(sensor("ahead_right", SensorKind::Light, 341.0));
    sensors.extend(
        [("right", -17.0), ("middle", 0.0), ("left", 17.0)].map(|(name, at)| sensor(name, SensorKind::Ground, at)),
    );
    let described = |sensors: &[Sensor]| WorldSpec {
        robot: Robot {
            build: Build::Differential(Differential {
                sensors: sensors.to_vec(),
                ..Differential::new(53.0, 128.0)
            }),
            body_radius: 35.0,
            ..Robot::khepera()
        },
        arena: hall(),
        controller: world::Controller::Perceptron,
        cycles: 20,
        ..WorldSpec::miglino1995()
    };
    let world = World::new(described(&sensors)).unwrap();
    let bench = Bench::new("listed");
    let all: Vec<_> = (0..CYCLES).map(sensed).collect();
    bench.write("driver.lua", of_argos(&all));
    let (controller, text) = exported(&world, 4, argos);
    bench.write("script.lua", text);
    let readings: Vec<Vec<f64>> = all
        .iter()
        .map(|one| {
            let [left, middle, right] = one.ground;
            let near = one.proximity.iter().rev();
            near.copied().chain([one.light[7], right, middle, left]).collect()
        })
        .collect();
    let wanted = wanted(&controller, [0, 0], &readings);
    assert_varied("listed", &wanted);
    for lines in of_lua(&bench) {
        assert_driven("listed", &lines, &wanted, 12.8);
    }
    // What it has no place for.
    let refused = |change: &dyn Fn(&mut Vec<Sensor>)| {
        let mut changed = sensors.clone();
        change(&mut changed);
        let world = World::new(described(&changed)).unwrap();
        let controller = Controller::new(&world, &modules::genome(&world, 4), 0).unwrap();
        argos(&controller, "made", ORIGIN, &[]).unwrap_err().to_string()
    };
    assert_eq!(
        refused(&|sensors| sensors[0].heading = -30.0 / 360.0),
        "robot.sensors: prox_0: looks to 330.0 degrees; allowed for argos: 17, 50, 90, 150, 210, 270, 310, 343, up to 5 beside"
    );
    assert_eq!(
        refused(&|sensors| sensors[2].kind = SensorKind::Distance),
        "robot.sensors: prox_2: is a distance sensor; allowed for argos: proximity, light, ground"
    );
    let sampled = World::new(WorldSpec::miglino1995()).unwrap();
    let controller = Controller::new(&sampled, &[0.5; 18], 0).unwrap();
    for refused in [
        argos(&controller, "made", ORIGIN, &[]).unwrap_err(),
        webots(&controller, "made", ORIGIN, &[]).unwrap_err(),
    ] {
        assert!(refused.to_string().starts_with("robot: was sampled"), "{refused}");
    }
}

/// A program of a Thymio II reads the Thymio's own sensors, and fits into it.
#[test]
fn a_program_of_aseba_is_for_a_thymio() {
    let sensor = |name: String, kind, degrees: f32| Sensor {
        name,
        kind,
        heading: degrees / 360.0,
        range: (kind == SensorKind::Proximity).then_some(140.0),
        offset: (kind == SensorKind::Ground).then_some(70.0),
        ..Sensor::default()
    };
    let near = [40.0, 20.0, 0.0, -20.0, -40.0, 180.0, 180.0].into_iter().enumerate();
    let mut sensors: Vec<_> = near
        .map(|(number, degrees)| sensor(format!("prox_{number}"), SensorKind::Proximity, degrees))
        .collect();
    sensors.extend(
        [("left", 9.0), ("right", -9.0)].map(|(side, at)| sensor(format!("ground_{side}"), SensorKind::Ground, at)),
    );
    let printed = |sensors: &[Sensor], speed: f32, speeds: u32, units: u32| {
        let world = World::new(WorldSpec {
            robot: Robot {
                build: Build::Differential(Differential {
                    sensors: sensors.to_vec(),
                    speeds,
                    ..Differential::new(94.0, speed)
                }),
                body_radius: 80.0,
                ..Robot::khepera()
            },
            arena: hall(),
            controller: world::Controller::Hidden { units },
            cycles: 20,
            ..WorldSpec::miglino1995()
        })
        .unwrap();
        let controller = Controller::new(&world, &modules::genome(&world, 4), 0).unwrap();
        aseba(&controller, "made", ORIGIN, &[])
    };
    let text = String::from_utf8(printed(&sensors, 166.0, 0, 12).unwrap().bytes).unwrap();
    assert!(
        text.contains("x0[6], prox.horizontal[6]") && text.contains("x0[8] = prox.ground.delta[1]"),
        "{text}"
    );
    let wrong = |change: &dyn Fn(&mut Vec<Sensor>)| {
        let mut changed = sensors.clone();
        change(&mut changed);
        printed(&changed, 166.0, 0, 12).unwrap_err().to_string()
    };
    let allowed = "; allowed for aseba: prox_0 to prox_6, ground_left and ground_right of `robot.preset = \"thymio2\"`";
    for (refused, expected) in [
        (
            wrong(&|sensors| sensors[2].kind = SensorKind::Distance),
            "prox_2: is a distance sensor",
        ),
        (wrong(&|sensors| sensors[0].heading = 0.5), "prox_0: looks elsewhere"),
        (
            wrong(&|sensors| sensors[1].name = "nose".to_owned()),
            "nose: is a proximity sensor",
        ),
    ] {
        assert_eq!(refused, format!("{expected}{allowed}"));
    }
    for (refused, expected) in [
        (
            printed(&sensors, 400.0, 0, 4),
            "robot.greatest_speed_mm_s: is 400; allowed for aseba: up to 166",
        ),
        (
            printed(&sensors, 100.0, 5, 4),
            "robot.speeds: is 5; allowed for aseba: 0",
        ),
        (
            printed(&sensors, 100.0, 0, 20),
            "words of code; allowed for aseba: 1534",
        ),
    ] {
        let refused = refused.unwrap_err().to_string();
        assert!(refused.contains(expected), "{refused}");
    }
}

/// A script that draws random numbers begins with ARGoS's.
#[test]
fn a_machine_of_argos_draws() {
    let machine = world::Controller::StateMachine(oneiro::automode::Modules::DEFAULT);
    let world = World::new(modules::spec(machine, 4)).unwrap();
    let bench = Bench::new("machine");
    let all: Vec<_> = (0..CYCLES).map(sensed).collect();
    let driver = of_argos(&all);
    let body = f64::from(world.spec().robot.body_radius);
    let readings = readings(Model::Vectors, &all, (700.0 - 2.0 * body) / 10.0, 11, 1.0);
    let (mut found, mut others) = (0, 0);
    for genome in 0..6 {
        let (controller, text) = exported(&world, genome, argos);
        bench.write("script.lua", text);
        let of_quarter = wanted(&controller, [1 << 30; 2], &readings);
        for (share, key) in [("0.25", 1 << 30), ("0.75", 3 << 30)] {
            bench.write("driver.lua", driver.replace("return 0.25", &format!("return {share}")));
            let wanted = wanted(&controller, [key, key], &readings);
            others += u32::from(wanted != of_quarter);
            for lines in of_lua(&bench) {
                assert_driven("machine", &lines, &wanted, 12.0);
                found += 1;
            }
        }
    }
    assert!(others > 2, "{others}");
    assert!(found == 24 || env::var_os("ONEIRO_MAY_SKIP").is_some());
}

/// Webots's interface, as far as the program calls it.
const WEBOTS: &str = "#ifndef STAND_IN
#define STAND_IN
#include <stdint.h>
typedef uint16_t WbDeviceTag;
int wb_robot_init(void);
int wb_robot_step(int duration);
double wb_robot_get_basic_time_step(void);
void wb_robot_cleanup(void);
const char *wb_robot_get_name(void);
int wb_robot_get_number_of_devices(void);
WbDeviceTag wb_robot_get_device_by_index(int index);
const char *wb_device_get_name(WbDeviceTag tag);
void wb_distance_sensor_enable(WbDeviceTag tag, int period);
double wb_distance_sensor_get_value(WbDeviceTag tag);
int wb_distance_sensor_get_lookup_table_size(WbDeviceTag tag);
const double *wb_distance_sensor_get_lookup_table(WbDeviceTag tag);
void wb_light_sensor_enable(WbDeviceTag tag, int period);
double wb_light_sensor_get_value(WbDeviceTag tag);
int wb_light_sensor_get_lookup_table_size(WbDeviceTag tag);
const double *wb_light_sensor_get_lookup_table(WbDeviceTag tag);
void wb_motor_set_position(WbDeviceTag tag, double position);
void wb_motor_set_velocity(WbDeviceTag tag, double velocity);
double wb_motor_get_max_velocity(WbDeviceTag tag);
#endif
";

/// Sensors of Webots whose values fall with the distance, one of them in the other sense, and what they read in each cycle: distances, m; the
/// values of two ground sensors; and the irradiances of a light sensor whose values fall, W/m^2.
const STAND_IN: &str = "#include <stdio.h>
#include <webots/robot.h>
static const char *const NAMES[] = {\"leds\", \"right wheel motor\", \"left wheel motor\", \"PREFIX1\", \"PREFIX0\", \"nose\", \"LEFT\", \"RIGHT\", \"LIGHT\"};
static const double FALLING[] = {0.0, 4095.0, 0.1, 0.01, 2000.0, 0.1, 0.03, 200.0, 0.1, 0.07, 60.0, 0.1};
static const double RISING[] = {0.0, 0.0, 0.0, 0.2, 1000.0, 0.0};
static const double DIMMING[] = {0.0, 4095.0, 0.0, 0.5, 1000.0, 0.0, 2.0, 0.0, 0.0};
static int cycle = -1;
static double speeds[2];
int wb_robot_init(void) { return 1; }
double wb_robot_get_basic_time_step(void) { return 20.0; }
int wb_robot_step(int duration)
{
    if (duration != 100) {
        return -1;
    }
    if (cycle >= 0) {
        printf(\"%.9g %.9g\\n\", speeds[0], speeds[1]);
    }
    return ++cycle < CYCLES ? 0 : -1;
}
void wb_robot_cleanup(void) {}
const char *wb_robot_get_name(void) { return \"robot\"; }
int wb_robot_get_number_of_devices(void) { return 9; }
WbDeviceTag wb_robot_get_device_by_index(int index) { return (WbDeviceTag)(index + 1); }
const char *wb_device_get_name(WbDeviceTag tag) { return NAMES[tag - 1]; }
void wb_distance_sensor_enable(WbDeviceTag tag, int period) { (void)tag; (void)period; }
int wb_distance_sensor_get_lookup_table_size(WbDeviceTag tag) { return tag == 6 ? 2 : 4; }
const double *wb_distance_sensor_get_lookup_table(WbDeviceTag tag) { return tag == 6 ? RISING : FALLING; }
static double value_of(const double *table, int rows, double quantity)
{
    int row;
    for (row = 1; row < rows - 1 && quantity > table[3 * row]; row++) {
    }
    return table[3 * row - 2]
        + (table[3 * row + 1] - table[3 * row - 2]) * (quantity - table[3 * row - 3]) / (table[3 * row] - table[3 * row - 3]);
}
double wb_distance_sensor_get_value(WbDeviceTag tag)
{
    const double read = READ[cycle][tag - 4];
    return tag > 6 ? read : value_of(wb_distance_sensor_get_lookup_table(tag), wb_distance_sensor_get_lookup_table_size(tag), read);
}
void wb_light_sensor_enable(WbDeviceTag tag, int period) { (void)tag; (void)period; }
int wb_light_sensor_get_lookup_table_size(WbDeviceTag tag) { (void)tag; return 3; }
const double *wb_light_sensor_get_lookup_table(WbDeviceTag tag) { (void)tag; return DIMMING; }
double wb_light_sensor_get_value(WbDeviceTag tag) { return tag == 9 ? value_of(DIMMING, 3, READ[cycle][5]) : -1.0; }
void wb_motor_set_position(WbDeviceTag tag, double position) { (void)tag; (void)position; }
void wb_motor_set_velocity(WbDeviceTag tag, double velocity) { speeds[tag == 2] = velocity; }
double wb_motor_get_max_velocity(WbDeviceTag tag) { (void)tag; return 5.0; }
";

#[test]
fn a_program_of_webots_reads_distances_by_its_lookup_tables() {
    let sensor = |name: &str, kind, range, response: Option<Vec<[f32; 2]>>| Sensor {
        name: name.to_owned(),
        kind,
        range: Some(range),
        response: response.map(Response),
        heading: if name == "nose" { 0.0 } else { 0.1 },
        ..Sensor::default()
    };
    let points = vec![[2.0, 1.0], [20.0, 0.5], [40.0, 0.0]];
    let sensors = vec![
        sensor("prox_0", SensorKind::Proximity, 50.0, Some(points)),
        sensor("prox_1", SensorKind::Proximity, 100.0, None),
        sensor("nose", SensorKind::Distance, 150.0, None),
        Sensor {
            range: None,
            ..sensor("ground_left", SensorKind::Ground, 0.0, None)
        },
        Sensor {
            range: None,
            ..sensor("ground_right", SensorKind::Ground, 0.0, None)
        },
        sensor("light_2", SensorKind::Light, 500.0, None),
    ];
    let spec = WorldSpec {
        robot: Robot {
            build: Build::Differential(Differential {
                sensors,
                ..Differential::new(53.0, 128.8)
            }),
            body_radius: 35.0,
            ..Robot::khepera()
        },
        arena: hall(),
        controller: world::Controller::Perceptron,
        cycles: 20,
        ..WorldSpec::miglino1995()
    };
    let world = World::new(spec).unwrap();
    // Of prox_0, prox_1 and nose, mm; of both ground sensors; and of light_2, W/m^2.
    let most = [60.0, 95.0, 190.0, 1100.0, 1100.0, 2.0];
    let read: Vec<[f64; 6]> = (0..CYCLES)
        .map(|cycle| [0, 1, 2, 3, 4, 5].map(|sensor| most[sensor as usize] * drawn(cycle, 50 + sensor)))
        .collect();
    let ground = |value: f64| ((value - 300.0) / 700.0).clamp(0.0, 1.0);
    // The second sensor's table ends before its range: there nothing is near.
    let response = |distance: f64| match distance {
        ..2.0 => 1.0,
        2.0..20.0 => 1.0 - 0.5 * (distance - 2.0) / 18.0,
        20.0..40.0 => 0.5 - 0.5 * (distance - 20.0) / 20.0,
        _ => 0.0,
    };
    let readings: Vec<Vec<f64>> = read
        .iter()
        .map(|[first, second, nose, left, right, light]| {
            vec![
                response(*first),
                if *second < 70.0 { 1.0 - second / 100.0 } else { 0.0 },
                (nose / 150.0).min(1.0),
                ground(*left),
                ground(*right),
                light.min(1.0),
            ]
        })
        .collect();
    let bench = Bench::new("webots");
    let (controller, text) = exported(&world, 4, webots);
    bench.write("made.c", text);
    for header in ["robot", "device", "motor", "distance_sensor", "light_sensor"] {
        bench.write(format!("webots/{header}.h"), WEBOTS);
    }
    let mut table = format!("enum {{ CYCLES = {CYCLES} }};\nstatic const double READ[][6] = {{\n");
    for [first, second, nose, left, right, light] in &read {
        // By their tags.
        let _ = writeln!(
            table,
            "    {{{:?}, {:?}, {:?}, {left:?}, {right:?}, {light:?}}},",
            second / 1000.0,
            first / 1000.0,
            nose / 1000.0
        );
    }
    table += "};\n";
    let build = [
        "-std=c99",
        "-Wall",
        "-Wextra",
        "-pedantic",
        "-Werror",
        "-I.",
        "made.c",
        "simulator.c",
        "-lm",
        "-o",
        "made",
    ];
    let mut found = 0;
    for (prefix, left, right, light) in [
        ("ps", "gs0", "gs2", "ls2"),
        ("prox.horizontal.", "prox.ground.0", "prox.ground.1", "light_2"),
        ("prox_", "ground_left", "ground_right", "light_2"),
    ] {
        let stand_in = STAND_IN.replace("PREFIX", prefix).replace("LEFT", left);
        let stand_in = stand_in
            .replace("RIGHT", right)
            .replace("\"LIGHT", &format!("\"{light}"));
        bench.write("simulator.c", table.clone() + &stand_in);
        if bench.printed("gcc", &build).is_none() {
            return;
        }
        let lines = bench.printed("./made", &[]).unwrap();
        // Wheels of 20.5 mm that turn by 5 rad/s at most.
        let full_speed = 128.8 / 20.5;
        let mut wanted = wanted(&controller, [0, 0], &readings);
        for speed in wanted.iter_mut().flatten() {
            *speed = speed.clamp(-5.0 / full_speed, 5.0 / full_speed);
        }
        assert_varied("webots", &wanted);
        assert_driven("webots", &lines, &wanted, full_speed);
        found += 1;
    }
    assert_eq!(found, 3);
    bench.write("simulator.c", table + &STAND_IN.replace("PREFIX", "sonar"));
    bench.printed("gcc", &build).unwrap();
    let ended = Command::new(bench.0.join("made")).output().unwrap();
    let message = String::from_utf8(ended.stderr).unwrap();
    assert!(
        ended.status.code() == Some(1) && message.contains("no sensor for the input prox_0"),
        "{message}"
    );
}

/// What stands in for the packages of ROS 2 that the node uses, and drives it: the last line says what it logged.
const ROS: &str = r#"
import sys, types

class Logger:
    said = []
    def warning(self, text, **_): Logger.said.append(text)
    def error(self, text, **_): Logger.said.append(text)
class Node:
    given = {}
    def __init__(self, name): self.name, self.values = name, {}
    def declare_parameter(self, name, value): self.values[name] = Node.given.get(name, value)
    def get_parameter(self, name): return types.SimpleNamespace(value=self.values[name])
    def get_logger(self): return Logger()
    def get_fully_qualified_name(self): return "/" + self.name
    def create_publisher(self, kind, topic, depth):
        assert topic == "cmd_vel"
        self.sent = []
        return types.SimpleNamespace(publish=self.sent.append)
    def create_subscription(self, kind, topic, callback, depth): assert topic == "inputs"
    def create_timer(self, period, callback): self.period = period
    def destroy_node(self): Node.last = self.sent[-1]
class Twist:
    def __init__(self):
        self.linear = types.SimpleNamespace(x=0.0)
        self.angular = types.SimpleNamespace(z=0.0)
def module(name, **members):
    made = types.ModuleType(name)
    made.__dict__.update(members)
    sys.modules[name] = made
module("rclpy", init=lambda signal_handler_options: None, shutdown=lambda: None); module("rclpy.node", Node=Node)
module("rclpy.signals", SignalHandlerOptions=types.SimpleNamespace(NO=0))
module("geometry_msgs"); module("geometry_msgs.msg", Twist=Twist)
module("std_msgs"); module("std_msgs.msg", Float32MultiArray=object)

import made.node
from made.node import Driver
now_s = 0.0
made.node.monotonic = lambda: now_s
node = Driver()
assert node.period == 0.1 and Logger.said == [], Logger.said
message = lambda data: types.SimpleNamespace(data=data)
def twist():
    node.act()
    sent = node.sent[-1]
    return sent.linear.x, sent.angular.z
# Before anything was read, it stands.
assert twist() == (0.0, 0.0)
for readings in READINGS:
    now_s += 0.1
    node.receive(message(readings))
    print("%.9g %.9g" % twist())
# Other messages are refused, and readings that are too old don't count.
node.receive(message([1.0]))
node.receive(message([float("nan")] * len(READINGS[0])))
assert len(Logger.said) == 2, Logger.said
now_s += 0.29
assert twist() != (0.0, 0.0)
now_s += 0.02
assert twist() == (0.0, 0.0)
# Whoever ends it stops the robot.
import os, signal
def spin(node):
    node.receive(message(READINGS[0]))
    node.act()
    assert node.sent[-1].linear.x != 0.0 or node.sent[-1].angular.z != 0.0
    os.kill(os.getpid(), number)
    time.sleep(5)
import time
sys.modules["rclpy"].spin = spin
for number in (signal.SIGINT, signal.SIGTERM):
    Node.last = None
    made.node.main()
    assert (Node.last.linear.x, Node.last.angular.z) == (0.0, 0.0)
try:
    Node.given = {"wheel_base_m": 0.0}
    Driver()
except ValueError as error:
    assert "wheel_base_m" in str(error)
else:
    raise AssertionError("a wheel base of 0 was taken")
"#;

#[test]
fn a_node_of_ros_drives_by_fresh_readings() {
    let world = World::new(WorldSpec {
        robot: epucks(Model::Rm12, Reference::DEFAULT, 2),
        arena: hall(),
        controller: world::Controller::Recurrent,
        cycles: 20,
        ..WorldSpec::miglino1995()
    })
    .unwrap();
    let genome = modules::genome(&world, 4);
    let controller = Controller::new(&world, &genome, 0).unwrap();
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let recorded = controller.record(&mut cpu, Key::rollout(3, 0, 0, 0)).unwrap();
    let bench = Bench::new("ros");
    for (file, text) in ros2(&controller, "made", ORIGIN, &recorded[..4]) {
        assert!(
            !text.contains('@') || file == "package.xml" || file.ends_with("controller.py"),
            "{file}: {text}"
        );
        bench.write(file, text);
    }
    let readings: Vec<Vec<f64>> = recorded
        .iter()
        .map(|cycle| cycle.readings.iter().map(|reading| f64::from(*reading)).collect())
        .collect();
    bench.write("driver.py", format!("READINGS = {readings:?}\n{ROS}"));
    let Some(lines) = bench.printed("python3", &["-B", "driver.py"]) else {
        return;
    };
    let full_speed = f64::from(controller.full_speed.unwrap()) / 1000.0;
    let base = f64::from(world.spec().robot.build.described().unwrap().wheel_base.unwrap()) / 1000.0;
    let wheels: Vec<String> = lines
        .iter()
        .map(|line| {
            let [ahead, turn] = numbers(line)[..] else {
                panic!("{line}")
            };
            format!("{} {}", ahead - 0.5 * base * turn, ahead + 0.5 * base * turn)
        })
        .collect();
    let wanted = wanted(&controller, [0, 0], &readings);
    assert_varied("ros2", &wanted);
    assert_driven("ros2", &wheels, &wanted, full_speed);
    // The package is one that ROS's tools read.
    bench.printed(
        "python3",
        &[
            "-B",
            "-c",
            "import xml.dom.minidom as m; m.parse('package.xml'); compile(open('setup.py').read(), 's', 'exec')",
        ],
    );
    assert!(bench.0.join("resource/made").exists() && bench.0.join("made/__init__.py").exists());
}
