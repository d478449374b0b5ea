//! Tests of what files of other simulators become. The files are invented.

use std::path::Path;

use oneiro_base::exit::Result;

use super::*;
use crate::mutations::mutant;
use crate::scratch::Scratch;

const ARENA: &str = r#"<?xml version="1.0" ?>
<argos-configuration>
  <framework>
    <experiment length="90" ticks_per_second="10" random_seed="7" />
  </framework>
  <controllers>
    <meander_controller id="meander" library="libmeander">
      <sensors><epuck_proximity implementation="default" /></sensors>
      <params turn="0.3" />
    </meander_controller>
  </controllers>
  <loop_functions library="libtask" label="task">
    <circle position="0.2,0.1" radius="0.15" color="black" />
    <rectangle center="-0.5,0.2" angle="30" width="0.4" height="0.2" color="white" />
    <circle position="0,0" radius="0.1" color="red" />
  </loop_functions>
  <arena size="4, 4, 1" center="0,0,0.5">
    <floor id="floor" source="loop_functions" pixels_per_meter="50" />
    <box id="north" size="2.2,0.1,0.5" movable="false"><body position="0,0.8,0" orientation="0,0,0" /></box>
    <box id="south" size="2.2,0.1,0.5" movable="false"><body position="0,-0.8,0" orientation="0,0,0" /></box>
    <box id="east" size="0.1,1.6,0.5" movable="false"><body position="1.05,0,0" orientation="0,0,0" /></box>
    <box id="west" size="1.6,0.1,0.5" movable="false"><body position="-1.05,0,0" orientation="90,0,0" /></box>
    <box id="crate" size="0.3,0.2,0.2" movable="true" mass="2"><body position="0.4,0.3,0" orientation="45,0,0" /></box>
    <box id="beam" size="0.3,0.2,0.2" movable="false"><body position="0.4,0.3,0.4" orientation="0,0,0" /></box>
    <cylinder id="post" radius="0.05" height="0.3" movable="false"><body position="-0.3,-0.2,0" orientation="0,0,0" /></cylinder>
    <light id="lamp" position="0.9,0,0.4" orientation="0,0,0" color="yellow" intensity="2.0" medium="leds" />
    <distribute>
      <position method="uniform" min="-0.5,-0.5,0" max="0.5,0.5,0" />
      <orientation method="uniform" min="0,0,0" max="360,0,0" />
      <entity quantity="6" max_trials="100">
        <e-puck id="robot"><controller config="meander" /></e-puck>
      </entity>
    </distribute>
    <foot-bot id="big"><body position="0,0,0" orientation="0,0,0" /><controller config="meander" /></foot-bot>
  </arena>
</argos-configuration>
"#;

const PLAYGROUND: &str = r#"<!DOCTYPE aseba-playground>
<aseba-playground>
  <author name="nobody" />
  <color name="blue" r="0" g="0" b="1" />
  <world w="120" h="80.5" color="blue" groundTexture="floor.png" />
  <wall x="60" y="40" l1="30" l2="2.5" h="10" angle="0.7853981634" color="blue" />
  <cylinder x="90" y="20" r="4" h="8" mass="3" color="blue" />
  <door name="gate" color="blue" />
  <robot type="thymio2" x="25" y="40" angle="1.570796327" name="one" port="33333" />
</aseba-playground>
"#;

const MAZES: &str = r#"from kheperax.simu.geoms import Pos, Segment

gap = 0.25  # of both
ys = [0.2, 0.4]
register_target_maze(
    "bends",
    segments=[
        Segment(Pos(0.0, gap), Pos(1 - gap, gap)),
        *[Segment(Pos(gap, y), Pos(2 * gap, y + 0.05)) for y in ys],
        Segment(Pos(wide, 0.1), Pos(0.2, 0.1)),
    ],
    target_pos=(0.9, 0.9),
    target_radius=0.05,
)
register_target_maze("empty", segments=[Segment(Pos(0.5, 0.0), Pos(0.5, 0.6))], target_pos=(0.9, 0.1), target_radius=0.1)
"#;

const MAZE: &str =
    "# walls\n5\n30 30\n90\n# goal\n150 90\n0 0 200 0\n200 0 200 120\n200 120 0 120\n0 120 0 0\n100 0 100 70\n";

const INI: &str = "[EXP]\nenvironment = ErDiscrim\n\n[ALGO]\nmaxmsteps = 350\n[POLICY]\nepisodes = 4\nmaxsteps = 300\nnhiddens = 8\nbias = 1\n";

fn converted(name: &str, text: &str, maze: Option<&str>) -> Result<Imported> {
    let options = Options {
        maze: maze.map(str::to_owned),
        ..Options::default()
    };
    of_text(Path::new(name), text, &options, Path::new("imported.toml"))
}

fn good(name: &str, text: &str) -> Imported {
    converted(name, text, None).unwrap_or_else(|failure| panic!("{name}: {failure}"))
}

fn bad(name: &str, text: &str) -> String {
    let failure = converted(name, text, None).expect_err("it is refused");
    assert_eq!(failure.code(), 3, "{failure}");
    failure.to_string()
}

/// The lines of a text with one of these words are all there.
fn has(text: &str, lines: &[&str]) {
    for line in lines {
        assert!(text.contains(line), "{line}\nis not in\n{text}");
    }
}

/// The import takes each value of the robots' devices, or says that it doesn't.
#[test]
fn devices_of_other_controllers_are_not_silent() {
    let devices = r#"<actuators><epuck_wheels implementation="default" noise_std_dev="0.2" /></actuators>
      <sensors><epuck_proximity implementation="default" show_rays="true" noise_level="0.3" />
      <epuck_range_and_bearing implementation="medium" nois_std_deviation="1.5" check_occlusions="false" /></sensors>"#;
    let own = r#"<sensors><epuck_proximity implementation="default" /></sensors>"#;
    assert!(ARENA.contains(own));
    let text = ARENA
        .replace(own, devices)
        .replace("label=\"task\">", "label=\"task\"><params number_robots=\"20\" />");
    let made = good("arena.argos", &text);
    let left = made.not_taken();
    has(
        &left,
        &[
            "<epuck_wheels noise_std_dev>: not taken: set robot.wheel_noise",
            "<epuck_proximity noise_level>: not taken: a plain e-puck has no such value",
            "<epuck_range_and_bearing nois_std_deviation>: not taken: Oneiro has nothing like it",
            "<epuck_range_and_bearing check_occlusions>: ",
            "<params number_robots>, 20: not taken: the arena has 6, which are here",
        ],
    );
    assert!(
        !left.contains("implementation") && !left.contains("show_rays"),
        "{left}"
    );
}

#[test]
fn an_arena_of_argos_becomes_an_experiment() {
    let made = good("arena.argos", ARENA);
    has(
        &made.text,
        &[
            "# arena.argos:4: <experiment length>, in cycles of 100 ms\ncycles = 900\n",
            "preset = \"epuck\"\n# arena.argos:31: their number\ncount = 6\n",
            "# arena.argos:19: the inner faces of the boxes of lines",
            "width_mm = 2000.0\nheight_mm = 1500.0\n",
            "Places are moved by 1000.0 mm in x and 750.0 mm in y.",
            "[[arena.blocks]]\nx_mm = 1400.0\ny_mm = 1050.0\nlength_mm = 300.0\nwidth_mm = 200.0\nheading_deg = 45.0\n",
            "[[arena.obstacles]]\nx_mm = 700.0\ny_mm = 550.0\nradius_mm = 50.0\n",
            "[[arena.lights]]\nx_mm = 1900.0\ny_mm = 750.0\n",
            "[[arena.patches]]\nx_mm = 1200.0\ny_mm = 850.0\nradius_mm = 150.0\ngrey = 0.0\n",
            "sides_mm = [400.0, 200.0]\nheading_deg = 30.0\ngrey = 1.0\n",
        ],
    );
    has(
        &made.not_taken(),
        &[
            "arena.argos:4: <experiment random_seed>: not taken: ",
            "arena.argos:7: <meander_controller>: not taken: ",
            "arena.argos:15: <circle>: not taken: its colour is `red`; allowed: black, gray, white",
            "arena.argos:18: <floor>: not taken: ",
            "arena.argos:23: <box movable>: not taken: it stands there; of things only pucks, which are round, move: docs/pucks.md",
            "arena.argos:24: <box id=\"beam\">: not taken: it is above the floor",
            "arena.argos:34: <foot-bot>: not taken: Oneiro has no such robot",
        ],
    );
    assert_eq!(made.lists()["not_taken"][0]["lines"][0], 4);
    assert_eq!(made.text.matches("[[arena.blocks]]").count(), 1, "{}", made.text);
    // Each line of the list is a comment of the file.
    for line in made.not_taken().lines() {
        has(&made.text, &[&format!("# {}", line.replace("not taken: ", ""))]);
    }
}

#[test]
fn thin_boxes_around_a_polygon_are_its_sides() {
    let boxes: Vec<String> = (0..6)
        .map(|side| {
            let angle = 60.0 * f64::from(side);
            let (sine, cosine) = angle.to_radians().sin_cos();
            format!(
                "<box id=\"w{side}\" size=\"0.01,0.75,0.1\" movable=\"false\"><body position=\"{:.4},{:.4},0\" orientation=\"{angle},0,0\"/></box>",
                0.605 * cosine,
                0.605 * sine
            )
        })
        .collect();
    let boxes = boxes.concat();
    let functions = "<loop_functions><params dist_radius=\"0.5\" number_robots=\"4\"/></loop_functions>";
    let controllers = "<controllers><automode_controller id=\"a\"><sensors><epuck_light/></sensors><params fsm-config=\"--nstates 1\"/>\
                       </automode_controller></controllers>";
    let text = |boxes: &str| {
        format!(
            "<argos-configuration>{controllers}{functions}<arena size=\"3,3,1\" center=\"0,0,0\">{boxes}</arena></argos-configuration>"
        )
    };
    let made = good("hexagon.xml", &text(&boxes));
    has(
        &made.text,
        &[
            "corners_mm = [\n",
            "[600.0, ",
            "start_radius_mm = 500.0",
            "count = 4\n",
            "preset = \"epuck-rm1.1\"",
            "model = \"rm1.1-vectors\"",
            "kind = \"state-machine\"",
        ],
    );
    assert!(!made.text.contains("blocks"), "{}", made.text);
    has(
        &made.not_taken(),
        &["<params fsm-config>: not taken: put it into a text file"],
    );
    // With a gap, the boxes are blocks.
    let open = boxes.split_inclusive("</box>").skip(1).collect::<String>();
    let made = good("open.xml", &text(&open));
    assert_eq!(made.text.matches("[[arena.blocks]]").count(), 5);
    has(&made.text, &["width_mm = 3000.0\n", "its four sides are walls here"]);
}

#[test]
fn a_playground_becomes_an_experiment() {
    let made = good("play.playground", PLAYGROUND);
    has(
        &made.text,
        &[
            "width_mm = 1200.0\nheight_mm = 805.0\n",
            "x_mm = 600.0\ny_mm = 400.0\nlength_mm = 300.0\nwidth_mm = 25.0\nheading_deg = 45.0\n",
            "x_mm = 900.0\ny_mm = 200.0\nradius_mm = 40.0\n",
            "preset = \"thymio2\"",
            "kind = \"at\"\nx_mm = 250.0\ny_mm = 400.0\nheading_deg = 90.0\n",
        ],
    );
    has(
        &made.not_taken(),
        &[
            "play.playground:5: <world groundTexture>: not taken: it is a picture",
            "play.playground:6: <wall color>: not taken: ",
            "play.playground:7: <cylinder mass>: not taken: ",
            "play.playground:8: <door>: not taken: Oneiro has no doors",
        ],
    );
    // Two robots are a swarm, in their places.
    let robot = "<robot type=\"thymio2\" x=\"95\" y=\"60\" angle=\"0\"/>";
    let two = good(
        "two.playground",
        &PLAYGROUND.replace("</aseba", &format!("{robot}</aseba")),
    );
    has(
        &two.text,
        &[
            "count = 2\n",
            "headings in turns\n[start]\nkind = \"poses\"\nposes = [[250.0, 400.0, 0.25], [950.0, 600.0, 0.0]]",
        ],
    );
    // Older files name robots by their kind.
    let old = good(
        "old.playground",
        &PLAYGROUND.replace("<robot type=\"thymio2\"", "<e-puck"),
    );
    has(&old.text, &["preset = \"epuck\"", "kind = \"at\"\nx_mm = 250.0\n"]);
    // A start in a wall becomes a random one.
    let stuck = good("stuck.playground", &PLAYGROUND.replace("x=\"25\"", "x=\"60\""));
    assert!(!stuck.text.contains("[start]"));
    has(
        &stuck.not_taken(),
        &["the robot's start: not taken: starts are random, since Oneiro refuses these: "],
    );
}

/// Robots in ARGoS's grids stand where ARGoS puts them, beginning at the maximum x and y, and lost orientations are listed.
#[test]
fn distributed_robots_stand_where_argos_puts_them() {
    let distributed = |file: &str, position: &str, orientation: &str, count: u32| {
        let robots = format!(
            "<distribute><position {position}/><orientation {orientation}/><entity quantity=\"{count}\"><e-puck id=\"e\">\
             <controller config=\"c\"/></e-puck></entity></distribute>"
        );
        good(
            file,
            &format!(
                "<argos-configuration><arena size=\"2,2,1\" center=\"0,0,0.5\">{robots}</arena></argos-configuration>"
            ),
        )
    };
    let grid = "method=\"grid\" center=\"0.1,0.2,0\" distances=\"0.3,0.2,0\" layout=\"3,2,1\"";
    let constant = "method=\"constant\" values=\"30,0,0\"";
    let uniform = "method=\"uniform\" min=\"0,0,0\" max=\"360,0,0\"";
    let all = distributed("g.argos", grid, constant, 5);
    has(
        &all.text,
        &[
            "poses = [[1400.0, 1300.0, 0.083333], [1100.0, 1300.0, 0.083333], [800.0, 1300.0, 0.083333], [1400.0, 1100.0, 0.083333], ",
        ],
    );
    assert!(!all.not_taken().contains("rientation"), "{}", all.not_taken());
    let random = distributed("u.argos", grid, uniform, 5);
    has(&random.text, &["random headings\nstarts_mm = [[1400.0, 1300.0], "]);
    assert!(!random.not_taken().contains("rientation"), "{}", random.not_taken());
    for (file, position, orientation, count, said) in [
        ("one.argos", grid, uniform, 1, "the robot's random heading: not taken"),
        (
            "seven.argos",
            grid,
            constant,
            7,
            "the robots' starts: not taken: there are 7 for fewer places",
        ),
        (
            "turned.argos",
            grid,
            "method=\"uniform\" min=\"0,0,0\" max=\"90,0,0\"",
            5,
            "<orientation>: not taken",
        ),
        (
            "normal.argos",
            grid,
            "method=\"gaussian\" mean=\"90,0,0\" std_dev=\"9,0,0\"",
            5,
            "<orientation>: not taken",
        ),
        (
            "drawn.argos",
            "method=\"uniform\" min=\"-1,-1,0\" max=\"1,1,0\"",
            constant,
            5,
            "<orientation>: not taken",
        ),
        (
            "high.argos",
            "method=\"grid\" center=\"0,0,0\" distances=\"0.3,0.3,0.3\" layout=\"2,2,2\"",
            constant,
            4,
            "several layers",
        ),
    ] {
        let not_taken = distributed(file, position, orientation, count).not_taken();
        assert!(not_taken.contains(said), "{file}: {not_taken}");
    }
    // Rectangles.
    let within = |min: &str, max: &str| format!("method=\"uniform\" min=\"{min},0\" max=\"{max},0\"");
    let zone = distributed("zone.argos", &within("-0.6,-0.5", "0.2,0.9"), uniform, 5);
    has(
        &zone.text,
        &["kind = \"zone\"\nx_mm = 800.0\ny_mm = 1200.0\nsides_mm = [800.0, 1400.0]\n"],
    );
    assert!(!zone.not_taken().contains("position"), "{}", zone.not_taken());
    let alone = distributed("alone.argos", &within("-0.6,-0.5", "0.2,0.9"), uniform, 1);
    has(&alone.text, &["kind = \"zone\"\nx_mm = 800.0\n"]);
    let outside = distributed("outside.argos", &within("-0.6,-0.5", "0.2,1.9"), uniform, 5);
    assert!(
        outside.not_taken().contains("not within the arena"),
        "{}",
        outside.not_taken()
    );
    assert!(!outside.text.contains("[start]"), "{}", outside.text);
    let small = distributed("small.argos", &within("-0.1,-0.1", "0.1,0.1"), uniform, 5);
    assert!(
        small.not_taken().contains("is a zone half of which"),
        "{}",
        small.not_taken()
    );
    let group = |min: &str, max: &str| {
        format!(
            "<distribute><position {}/><orientation {uniform}/><entity quantity=\"2\"><e-puck id=\"{min}\"/></entity></distribute>",
            within(min, max)
        )
    };
    let two = [group("-0.9,-0.9", "-0.1,0.9"), group("0.1,-0.9", "0.9,0.9")].concat();
    let two =
        format!("<argos-configuration><arena size=\"2,2,1\" center=\"0,0,0.5\">{two}</arena></argos-configuration>");
    let two = converted("two.argos", &two, None).unwrap();
    assert!(
        two.not_taken().contains("robots start in one zone"),
        "{}",
        two.not_taken()
    );
    assert!(!two.text.contains("[start]"), "{}", two.text);
}

/// Mazes by the names of their lists, of keys, keywords and functions.
const NAMED_MAZES: [&str; 5] = [
    "one = [#1]\ntwo = [#2]\nregister_target_maze('first', segments=one, target_pos=(1, 1))\nregister_target_maze(name='second', segments=two)\n",
    "ALL = {\n  'first': {'segments': [#1], 'target_pos': (0, 1)},\n  'second': {'segments': [#2]},\n}\n",
    "ALL = dict(\n  first=[#1],\n  second=[#2])\n",
    "def first():\n    return Maze(segments_list=[#1])\ndef second():\n    walls = []\n    walls.append(#2)\n    return walls\n",
    "ALL['first'] = {'walls': [#1]}\nALL['second'] = {'walls': [#2]}\n",
];

#[test]
fn mazes_become_experiments() {
    let made = converted("mazes.py", MAZES, Some("bends")).unwrap();
    assert_eq!(made.text.matches("[[arena.walls]]").count(), 4 + 3, "{}", made.text);
    has(
        &made.text,
        &[
            "preset = \"kheperax\"",
            "from_mm = [0.0, 250.0]\nto_mm = [750.0, 250.0]\n",
            "from_mm = [250.0, 400.0]\nto_mm = [500.0, 450.0]\n",
        ],
    );
    has(
        &made.not_taken(),
        &[
            "mazes.py:10: Segment: not taken: its numbers are not understood",
            "mazes.py:12: target_pos: not taken: the task has the target, here 900.0, 900.0 mm",
        ],
    );
    assert_eq!(
        bad("mazes.py", MAZES),
        "mazes.py: has 2 mazes; allowed: --maze with one of bends, empty"
    );
    let other = converted("mazes.py", MAZES, Some("other")).unwrap_err().to_string();
    assert_eq!(other, "--maze other: is no maze of mazes.py; allowed: bends, empty");

    // None has another's walls.
    let [first, second] = [0.25, 0.5].map(|x| format!("Segment(Pos({x}, 0), Pos({x}, 1))"));
    let walls = |made: &Imported| [250, 500].map(|x| made.text.contains(&format!("from_mm = [{x}.0, 0.0]")));
    for text in NAMED_MAZES {
        let text = text.replace("#1", &first).replace("#2", &second);
        for (name, expected) in [("first", [true, false]), ("second", [false, true])] {
            let made = converted("others.py", &text, Some(name)).unwrap_or_else(|refused| panic!("{text}{refused}"));
            assert_eq!(walls(&made), expected, "{text}{}", made.text);
        }
        let refused = bad("others.py", &text);
        assert!(
            refused.ends_with("allowed: --maze with one of first, second"),
            "{text}{refused}"
        );
    }
    let border = format!("border = [{first}]\nmaze = border + [{second}]\n");
    let made = good("border.py", &border);
    assert_eq!(
        (walls(&made), made.text.matches("[[arena.walls]]").count()),
        ([true; 2], 6)
    );
    // Conditions and methods of walls are reported.
    let text = format!(
        "x = 0.5\nif False:\n    x = 0.75\n    {first}\n{second}.rotate(90)\nSegment(Pos(x, 0), Pos(0.1, 1))\n"
    );
    let made = good("odd.py", &text);
    assert_eq!(walls(&made), [true, false], "{}", made.text);
    has(
        &made.not_taken(),
        &[
            "odd.py:4: Segment's condition: not taken: whether it is there, by `if`",
            "odd.py:5: Segment: not taken: its method after `.`",
            "odd.py:6: Segment: not taken: its numbers are not understood",
        ],
    );
    let unknown = converted("odd.py", &text, Some("snake")).unwrap_err().to_string();
    assert!(
        unknown.ends_with("allowed: none, since its only one has no name"),
        "{unknown}"
    );

    let made = good("maze.txt", MAZE);
    assert_eq!(made.text.matches("[[arena.walls]]").count(), 5);
    has(
        &made.text,
        &[
            "width_mm = 400.0\nheight_mm = 240.0",
            "x_mm = 60.0\ny_mm = 60.0\nheading_deg = 90.0",
        ],
    );
    has(
        &made.not_taken(),
        &["maze.txt:6: the goal: not taken: the task has the goal, here at 300 and 180 mm"],
    );
}

#[test]
fn an_ini_of_evorobotpy_becomes_an_experiment() {
    let made = good("ErDiscrim.ini", INI);
    has(
        &made.text,
        &[
            "cycles = 300",
            "trials = 4",
            "layers = [{ units = 8 }]",
            "width_mm = 400.0",
            "radius_mm = 12.5",
        ],
    );
    has(
        &made.not_taken(),
        &[
            "ErDiscrim.ini:2: khepera-wall.sample, khepera-scylinder.sample: not taken: they are not next to this file",
            "ErDiscrim.ini:5: [ALGO] maxmsteps: not taken: ",
            "ErDiscrim.ini:10: [POLICY] bias: not taken: ",
        ],
    );
    // With the sensors' files next to it, these are the robot's.
    let place = Scratch::new("import-tables");
    let table = oneiro::tables::SensorTables::khepera();
    let ini = place.write("ErDiscrim.ini", INI);
    for (class, table) in ["khepera-wall", "khepera-scylinder"].iter().zip(&table.classes) {
        let path = place.path().join(format!("{class}.sample"));
        table.write(&path).unwrap();
    }
    let made = import(&ini, &Options::default(), &place.path().join("made.toml")).unwrap();
    has(
        &made.text,
        &[
            "tables = [\"khepera-wall.sample\", \"khepera-scylinder.sample\"]",
            "class = \"khepera-wall\"",
            "class = \"khepera-scylinder\"",
        ],
    );
}

#[test]
fn things_for_which_there_is_no_room_are_named() {
    let walls: Vec<String> = (0..4100)
        .map(|wall| {
            format!(
                "<wall x=\"{}\" y=\"{}\" l1=\"2\" l2=\"1\" h=\"5\"/>\n",
                10 + 10 * (wall % 70),
                10 + 8 * (wall / 70)
            )
        })
        .collect();
    let walls = walls.concat();
    let made = good(
        "many.playground",
        &format!("<aseba-playground><world w=\"800\" h=\"600\"/>\n{walls}</aseba-playground>"),
    );
    assert_eq!(
        made.text.matches("[[arena.blocks]]").count(),
        oneiro::arena::GREATEST_OBJECTS - 4
    );
    has(
        &made.not_taken(),
        &["many.playground:4094: <wall>: not taken: 4100 walls, obstacles and blocks; allowed: 4096 together"],
    );
}

#[test]
fn wrong_files_are_refused_with_their_place() {
    let arena = |change: (&str, &str)| {
        assert!(ARENA.contains(change.0), "{}", change.0);
        bad("arena.argos", &ARENA.replace(change.0, change.1))
    };
    for (change, words) in [
        (
            ("4, 4, 1", "4"),
            "arena.argos:17: <arena size>: is `4`; allowed: 2 numbers, separated by commas",
        ),
        (
            ("4, 4, 1", "4, -4, 1"),
            "arena.argos:17: <arena size>: is -4 m; allowed: more than 0",
        ),
        (
            ("4, 4, 1", "4, NaN, 1"),
            "arena.argos:17: <arena size>: is `4, NaN, 1`; allowed: 2 numbers",
        ),
        (
            ("0.3,0.2,0.2\" movable=\"true\"", "-0.3,0.2,0.2\""),
            "arena.argos:23: <box size>: is -0.3 x 0.2 m; allowed: more than 0",
        ),
        (
            ("radius=\"0.05\"", "radius=\"1e300\""),
            "arena.argos:25: <cylinder id=\"post\">: its radius is",
        ),
        (
            ("quantity=\"6\"", "quantity=\"6.5\""),
            "arena.argos:30: <entity quantity>: is 6.5; allowed: a whole number",
        ),
        (
            ("length=\"90\"", "length=\"-1\""),
            "arena.argos:4: <experiment length>: is -1 s; allowed: 0, or 0.1 to 100000 s",
        ),
        (("</arena>", "</arna>"), "is no XML: "),
        (
            ("argos-configuration", "svg"),
            "arena.argos:2: the first element is <svg>; allowed: <argos-configuration>",
        ),
    ] {
        let said = arena(change);
        assert!(said.contains(words), "{change:?}: {said}");
    }
    for (name, text, words) in [
        (
            "a.argos",
            "nothing",
            "a.argos:1: is not XML; allowed: a file that begins with `<`",
        ),
        (
            "a.csv",
            "x,y\n",
            "a.csv: is of no known format; allowed: ARGoS (.argos, .xml), ",
        ),
        (
            "m.txt",
            "--nstates 1 --s0 1",
            "m.txt:1: is a controller of AutoMoDe; allowed: ",
        ),
        ("m.txt", "1\n5\n", "m.txt:2: ends early; missing: x and y of the start"),
        (
            "m.txt",
            "1\n5 5\n0\n1 2 3\n",
            "m.txt:4: has 3 numbers; allowed: 4, x and y of both ends of a wall",
        ),
        (
            "m.txt",
            "1\n5 inf\n",
            "m.txt:2: `inf` is no number of a maze; allowed: -50000 to 50000",
        ),
        (
            "m.py",
            "x = 1\n",
            "m.py:1: has no walls; allowed: mazes of Segment(Pos(X, Y), Pos(X, Y))",
        ),
        (
            "e.ini",
            "[EXP]\nenvironment = AntBullet\n",
            "e.ini:2: [EXP] environment: is `AntBullet`, whose",
        ),
        ("e.ini", "[EXP]\nenvironment\n", "e.ini:2: is no value; allowed: "),
        (
            "p.playground",
            "<aseba-playground/>",
            "p.playground:1: has no <world>; allowed: ",
        ),
    ] {
        let said = bad(name, text);
        assert!(said.starts_with(words), "{said}");
    }
    let maze = converted("arena.argos", ARENA, Some("x")).unwrap_err().to_string();
    assert_eq!(
        maze,
        "--maze: arena.argos is ARGoS; allowed: with mazes of Kheperax (.py)"
    );
}

/// The formats' small files.
const ALL: [(&str, &str, Option<&str>); 5] = [
    ("arena.argos", ARENA, None),
    ("play.playground", PLAYGROUND, None),
    ("mazes.py", MAZES, Some("bends")),
    ("maze.txt", MAZE, None),
    ("ErDiscrim.ini", INI, None),
];

#[test]
fn a_byte_order_mark_and_line_ends_of_windows_change_nothing() {
    for (name, text, maze) in ALL {
        let plain = converted(name, text, maze).unwrap().text;
        let windows = format!("\u{feff}{}", text.replace('\n', "\r\n"));
        assert_eq!(converted(name, &windows, maze).unwrap().text, plain, "{name}");
    }
}

/// Whatever is cut off or changed, there is an experiment that Oneiro accepts, or a refusal with exit 3.
#[test]
fn broken_files_end_with_a_sentence() {
    let odd = [
        "<",
        "\"",
        "NaN",
        "1e400",
        "-1",
        "&lol;",
        "]]>",
        "99999999999999999999",
        "((((",
        "id=\"\"",
        "0",
    ];
    let ends = |name: &str, text: &str, maze: Option<&str>| {
        if let Err(failure) = converted(name, text, maze) {
            assert_eq!(failure.code(), 3, "{failure}");
        }
    };
    for (name, text, maze) in ALL {
        for end in (0..=text.len()).filter(|end| text.is_char_boundary(*end)) {
            ends(name, &text[..end], maze);
        }
        for seed in 0..100 {
            ends(name, &mutant(text, &odd, seed), maze);
        }
    }
}

#[test]
fn deep_and_wide_files_end_with_a_sentence() {
    let deep = "<a>".repeat(100_000);
    bad("deep.argos", &deep);
    let closed = format!(
        "<argos-configuration>{}{}</argos-configuration>",
        "<a>".repeat(50_000),
        "</a>".repeat(50_000)
    );
    bad("closed.argos", &closed);
    let inside = closed
        .replacen("<a>", "<arena size=\"1,1,1\"><a>", 1)
        .replacen("</argos", "</arena></argos", 1);
    good("inside.argos", &inside);
    bad("deep.py", &format!("Segment(Pos({}", "(".repeat(100_000)));
    bad("lists.py", &format!("x = {}", "[".repeat(100_000)));
    let laughs = "<!DOCTYPE a [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;&a;&a;\"><!ENTITY c \"&b;&b;&b;&b;&b;&b;&b;&b;\">]>\
                  <argos-configuration x=\"&c;&c;\"/>";
    bad("laughs.argos", laughs);
    // Loops of loops, grids of grids, more walls than anything has.
    let loops = format!(
        "ys = [{}]\n{}",
        "0.5,".repeat(20_000),
        "Segment(Pos(0, y), Pos(1, y)) for y in ys\n".repeat(10_000)
    );
    bad("loops.py", &loops);
    let some = format!(
        "Segment(Pos(0, 0), Pos(1, 0))\nys = [{}]\n{}",
        "0.5,".repeat(9_000),
        "Segment(Pos(0, y), Pos(1, z)) for y in ys\n".repeat(10_000)
    );
    good("some.py", &some);
    let grid = "<distribute><position method=\"grid\" distances=\"1,1\" layout=\"90,90\"/><entity quantity=\"8000\"><box size=\"1,1,1\"/></entity></distribute>";
    let grids = format!(
        "<argos-configuration><arena size=\"9,9,9\">{}</arena></argos-configuration>",
        grid.repeat(2_000)
    );
    bad("grids.argos", &grids);
    let walls = "<wall x=\"5\" y=\"5\" l1=\"1\" l2=\"1\"/>".repeat(20_000);
    let many = format!("<aseba-playground><world w=\"120\" h=\"80\"/>{walls}</aseba-playground>");
    bad("wide.playground", &many);
}

/// Files of a map of ROS: a room of 12 x 9 pixels of 100 mm with a pillar, and unknown pixels to its right.
const MAP: &str = "# A room\nimage: 'room.pgm' # drawn\nresolution: 0.1\norigin: [-1.5, 0.25, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";

fn room() -> Vec<u8> {
    let rows = [
        "############",
        "#.........??",
        "#.........??",
        "#...##....??",
        "#...##....??",
        "#.........??",
        "#.........??",
        "#.........??",
        "############",
    ];
    let grey = |pixel| match pixel {
        b'.' => 254,
        b'#' => 0,
        _ => 205,
    };
    [
        &b"P5\n12 9\n255\n"[..],
        &rows.concat().bytes().map(grey).collect::<Vec<_>>(),
    ]
    .concat()
}

/// A map in a separate folder.
fn mapped(scratch: &Scratch, yaml: &str, options: &Options) -> Result<Imported> {
    scratch.write("room.pgm", room());
    import(&scratch.write("map.yaml", yaml), options, Path::new("imported.toml"))
}

/// Walls of an experiment, as pairs of places in mm.
fn walls(text: &str) -> Vec<[[f64; 2]; 2]> {
    let values: toml::Table = text.parse().unwrap();
    let place = |wall: &toml::Value, key: &str| [0, 1].map(|axis| wall[key][axis].as_float().unwrap());
    let walls = values["arena"]["walls"].as_array().unwrap().iter();
    walls
        .map(|wall| ["from_mm", "to_mm"].map(|key| place(wall, key)))
        .collect()
}

#[test]
fn a_map_of_ros_becomes_walls() {
    let scratch = Scratch::new("map");
    let made = mapped(&scratch, MAP, &Options::default()).unwrap();
    has(
        &made.text,
        &[
            "A pixel is 100.0 mm wide. Walls are within 100.0 mm of the edges of free pixels.",
            "occupied by less than 0.196, and unknown from there to 0.65; unknown ones count as occupied.",
            "The place (0, 0) here is (-1500.0, 250.0) mm in the map's frame",
            "map.yaml:2: 12 x 9 pixels: 59 free, 35 occupied, 14 unknown\nwidth_mm = 1200.0\nheight_mm = 900.0\n",
            "map.yaml:2: a wall of outline 1, which begins at pixel 2 of row 8\n[[arena.walls]]\n",
            "kind = \"zone\"",
        ],
    );
    let mut sides = walls(&made.text);
    sides.truncate(4);
    assert_eq!(
        sides,
        [
            [[100.0, 100.0], [1000.0, 100.0]],
            [[1000.0, 100.0], [1000.0, 800.0]],
            [[1000.0, 800.0], [100.0, 800.0]],
            [[100.0, 800.0], [100.0, 100.0]],
        ]
    );
    // With no tolerance there is a wall for each side of the pillar.
    let exact = Options {
        tolerance: Some(0.0),
        ..Options::default()
    };
    assert_eq!(walls(&mapped(&scratch, MAP, &exact).unwrap().text).len(), 8);
    // As PyYAML writes it, in another order, with an angle, and with more.
    let other = "free_thresh: 0.196\nimage: room.pgm\nmode: trinary\nnegate: 0\noccupied_thresh: 0.65\norigin:\n- -1.5\n- 0.25\n- 0.5\n\
                 resolution: 0.1\nauthor: nobody\n";
    let turned = mapped(&scratch, other, &Options::default()).unwrap();
    assert_eq!(walls(&turned.text), walls(&made.text));
    has(
        &turned.not_taken(),
        &[
            "map.yaml:6: the angle of the origin: not taken: the map is not turned by 0.5 rad: walls are as in the picture\n",
            "map.yaml:11: `author`: not taken: it is no key of a map that this reads\n",
        ],
    );
    // Free and occupied pixels have changed places.
    let negated = mapped(&scratch, &MAP.replace("negate: 0", "negate: 1"), &Options::default()).unwrap();
    has(&negated.text, &["12 x 9 pixels: 35 free, 73 occupied, 0 unknown"]);
}

#[test]
fn a_picture_becomes_walls() {
    let scratch = Scratch::new("picture-map");
    let path = scratch.write("room.pgm", room());
    let options = Options {
        mm_per_pixel: Some(50.0),
        threshold: Some(0.9),
        ..Options::default()
    };
    let of = |options: &Options| import(&path, options, Path::new("imported.toml"));
    let made = of(&options).unwrap();
    has(
        &made.text,
        &[
            "(a map as picture)",
            "Pixels are free from a grey of 0.9 on",
            "room.pgm:8: a wall of outline 1",
            "width_mm = 600.0\nheight_mm = 450.0\n",
        ],
    );
    assert_eq!(walls(&made.text)[0], [[50.0, 50.0], [500.0, 50.0]]);
    // Half-white pixels are also free.
    let more = of(&Options {
        threshold: None,
        ..options.clone()
    })
    .unwrap();
    assert_eq!(walls(&more.text)[0], [[50.0, 50.0], [600.0, 50.0]]);
    for (options, words) in [
        (
            Options {
                mm_per_pixel: None,
                ..options.clone()
            },
            "lacks the size of its pixels; allowed: with --mm-per-pixel MM",
        ),
        (
            Options {
                mm_per_pixel: Some(0.0),
                ..options.clone()
            },
            "--mm-per-pixel: is 0; allowed: 0.01 to 10000 mm",
        ),
        (
            Options {
                mm_per_pixel: Some(f64::NAN),
                ..options.clone()
            },
            "--mm-per-pixel: is NaN; allowed",
        ),
        (
            Options {
                threshold: Some(1.5),
                ..options.clone()
            },
            "--threshold: is 1.5; allowed: 0 to 1",
        ),
        (
            Options {
                tolerance: Some(-1.0),
                ..options.clone()
            },
            "--tolerance: is -1; allowed: 0 to 10000 mm",
        ),
        (
            Options {
                maze: Some("x".into()),
                ..options.clone()
            },
            "--maze: ",
        ),
        (
            Options {
                threshold: Some(1.0),
                ..options.clone()
            },
            "has no free pixel: 12 x 9 pixels: 0 free, 108 occupied, 0 unknown",
        ),
    ] {
        let failure = of(&options).unwrap_err();
        assert!(failure.code() == 3 && failure.to_string().contains(words), "{failure}");
    }
}

#[test]
fn wrong_maps_are_refused() {
    let scratch = Scratch::new("wrong-maps");
    for (from, to, words) in [
        ("'room.pgm'", "'none.pgm'", "map.yaml:2: image: "),
        (
            "'room.pgm' # drawn",
            "",
            "map.yaml:7: lacks `image`; allowed: a map's file has image and resolution",
        ),
        ("image", "picture", "map.yaml:7: lacks `image`"),
        ("0.1\n", "0\n", "map.yaml:3: resolution: is 0; allowed: 0.00001 to 10"),
        ("0.1\n", "wide\n", "map.yaml:3: resolution: is wide; allowed: "),
        (
            "0.25, 0.0]",
            "0.25]",
            "map.yaml:4: origin: is -1.5  0.25; allowed: three numbers",
        ),
        ("negate: 0", "negate: 2", "map.yaml:5: negate: is 2; allowed: 0 and 1"),
        (
            "negate: 0",
            "mode: raw",
            "map.yaml:5: mode: is raw; allowed: trinary and scale",
        ),
        (
            "negate: 0",
            "image: a.png",
            "map.yaml:5: image: is given at line 2 too; allowed: once",
        ),
        (
            "negate: 0",
            "? negate",
            "map.yaml:5: is no line of a map's file; allowed: a key, `:` and its value",
        ),
        ("0.65", "1.5", "map.yaml:6: occupied_thresh: is 1.5; allowed: 0 to 1"),
    ] {
        assert!(MAP.contains(from));
        let failure = mapped(&scratch, &MAP.replace(from, to), &Options::default()).unwrap_err();
        assert!(failure.code() == 3 && failure.to_string().contains(words), "{failure}");
    }
    let wide = Options {
        mm_per_pixel: Some(1.0),
        ..Options::default()
    };
    let failure = mapped(&scratch, MAP, &wide).unwrap_err().to_string();
    assert!(
        failure.ends_with("map.yaml is a map of ROS; allowed: with maps as pictures (.png, .pgm)"),
        "{failure}"
    );
}

/// An error that names a tolerance names one that is enough.
#[test]
fn too_many_walls_are_refused() {
    let scratch = Scratch::new("many-walls");
    let mut state = 7_u32;
    let mut grey = |at: u32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        // A room with rough walls all over, in one piece.
        let (x, y) = (at % 200, at / 200);
        let is_rough = x % 4 == 1 && y % 50 > 2 && state >> 29 > 1;
        if x == 0 || is_rough && y % 50 < 47 { 0 } else { 255 }
    };
    let pixels: Vec<u8> = (0..200 * 200).map(&mut grey).collect();
    let path = scratch.write("rough.pgm", [&b"P5 200 200 255 "[..], &pixels].concat());
    let of = |tolerance| {
        let options = Options {
            mm_per_pixel: Some(20.0),
            tolerance: Some(tolerance),
            ..Options::default()
        };
        import(&path, &options, Path::new("imported.toml"))
    };
    let failure = of(0.0).unwrap_err().to_string();
    let words = "has more than 4096 walls at a tolerance of 0 mm; allowed: --tolerance of ";
    assert!(failure.contains(words), "{failure}");
    let enough = failure.split(words).nth(1).unwrap().split_whitespace().next().unwrap();
    let made = of(enough.parse().unwrap()).unwrap();
    assert!(walls(&made.text).len() <= 4096);
}

/// Whatever is changed in a map's files, there is an experiment or a refusal.
#[test]
fn broken_maps_end_with_a_sentence() {
    let scratch = Scratch::new("broken-maps");
    let odd = [
        "NaN",
        "1e400",
        "-1",
        "[",
        "]",
        "'",
        "\"",
        "#",
        ":",
        "- ",
        "\n",
        "99999999999999999999",
        "..",
        "/",
    ];
    for seed in 0..300 {
        if let Err(failure) = mapped(&scratch, &mutant(MAP, &odd, seed), &Options::default()) {
            assert_eq!(failure.code(), 3, "{failure}");
        }
    }
    for end in 0..MAP.len() {
        if let Err(failure) = mapped(&scratch, &MAP[..end], &Options::default()) {
            assert_eq!(failure.code(), 3, "{failure}");
        }
    }
}

/// The walls of `map-maze` are those of its map.
#[test]
fn the_maze_that_ships_has_the_walls_of_its_map() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments");
    let made = import(
        &folder.join("map-maze/map.yaml"),
        &Options::default(),
        Path::new("imported.toml"),
    )
    .unwrap();
    let ships = std::fs::read_to_string(folder.join("map-maze.toml")).unwrap();
    assert_eq!(walls(&made.text), walls(&ships));
}
