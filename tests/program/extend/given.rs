//! What an experiment gives to its parts besides their values, and robots that are described from the start.

use std::path::Path;

use oneiro::tasks::READY;

use super::*;

/// Sums up all that a part can ask of the experiment, so that each number shows.
const TASK: &str = "
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var sum = body_radius(episode) + 0.25f * f32(cycles(episode));
    for (var i = 0u; i < arena_lights(episode); i++) {
        let light = arena_light(episode, i);
        let lamp: ArenaLight = light;
        sum += 1000.0f * f32(i + 1u) * (light.place.x + 2.0f * light.place.y + 4.0f * lamp.height + lamp.brightness + 8.0f * lamp.intensity);
    }
    // Beyond the last is the last.
    sum += 0.5f * arena_light(episode, 9u).place.x;
    return Reward(select(0.0f, sum, now.step == 0u), before);
}
";

/// The fitness of one life of random genes on a device.
fn fitness(place: &Place, experiment: &str, backend: &str, set: &[&str]) -> f32 {
    let one = ["evaluate", experiment, "--random", "1", "--trials", "1", "--seed", "1"];
    let set = set.iter().flat_map(|value| ["--set", value]);
    let arguments: Vec<&str> = one
        .into_iter()
        .chain(["--backend", backend, "--quiet"])
        .chain(set)
        .collect();
    let table = place.good(&arguments);
    let mut lines = table.lines().map(|line| line.split(','));
    let column = lines.next().unwrap().position(|name| name == "fitness").unwrap();
    lines.next().unwrap().nth(column).unwrap().parse().unwrap()
}

/// The radius, the cycles and the lights of a described robot, of several that live together, and of a Khepera, which has no
/// lights, are those of the experiment, on every device.
#[test]
fn parts_read_what_the_experiment_has() {
    let place = Place::new("given");
    place.write("ask.wgsl", TASK);
    let own = "[task]\nkind = \"own\"\npart = \"ask.wgsl\"\n";
    let lights = "[arena]\nwidth_mm = 2000.0\nheight_mm = 2000.0\n\
                  lights = [{ x_mm = 3.0, y_mm = 5.0, brightness = 0.5 }, { x_mm = 7.0, y_mm = 11.0 }]\n";
    place.write(
        "one.toml",
        format!("cycles = 40\n[robot]\npreset = \"epuck\"\n{lights}{own}"),
    );
    let high = lights.replace("brightness = 0.5", "height_mm = 13.0, intensity = 5.0");
    place.write(
        "two.toml",
        format!("cycles = 40\n[robot]\npreset = \"epuck-rm1.1\"\ncount = 2\n{high}{own}"),
    );
    place.write("khepera.toml", format!("cycles = 40\n{own}"));
    let one = 35.0 + 10.0 + 1000.0 * (3.0 + 10.0 + 0.5 + 8.0) + 2000.0 * (7.0 + 22.0 + 1.0 + 8.0) + 3.5;
    let two = 35.0 + 10.0 + 1000.0 * (3.0 + 10.0 + 52.0 + 1.0 + 40.0) + 2000.0 * (7.0 + 22.0 + 1.0 + 8.0) + 3.5;
    let devices = ["cpu:native128x16", "cpu:interpretedx1", "gpu:llvmpipe"];
    for device in &devices[..if cfg!(feature = "gpu") { 3 } else { 2 }] {
        let found = ["one.toml", "two.toml", "khepera.toml"].map(|own| fitness(&place, own, device, &[]));
        assert_eq!(found, [one, 2.0 * two, 27.5 + 10.0], "{device}");
    }
    // An element of a list is set by itself, and values that change nothing in the kernel change what the part reads.
    let set = [
        "arena.lights[1].x_mm=9.0",
        "arena.lights.0.brightness=0.25",
        "robot.body_radius_mm=34.0",
        "cycles=44",
    ];
    let changed = one + 4000.0 + 1.0 - 250.0 - 1.0 + 1.0;
    assert_eq!(fitness(&place, "one.toml", devices[0], &set), changed);
}

/// So are elements of a list that the experiment has from a robot by name.
#[test]
fn an_element_of_a_robot_by_name_is_set() {
    let place = Place::new("named");
    place.write("named.toml", "[robot]\npreset = \"epuck\"\n");
    let checked = |set: &str| {
        let checked = place.good(&["check", "named.toml", "--json", "--set", set]);
        let checked: serde_json::Value = serde_json::from_str(&checked).unwrap();
        checked["settings"]["robot"]["sensors"].clone()
    };
    let (one, whole) = (checked("robot.sensors[2].range_mm=60"), checked("cycles=10"));
    assert_eq!(one[2]["range_mm"], 60.0);
    let others = |list: &serde_json::Value| {
        let mut list = list.as_array().unwrap().clone();
        list[2]["range_mm"] = 0.into();
        list
    };
    assert!(
        whole[2]["range_mm"] != 60.0 && others(&one) == others(&whole),
        "{whole}"
    );
    place
        .run(&["check", "named.toml", "--set", "robot.sensors[99].range_mm=60"])
        .exits(3)
        .says(&["--set robot.sensors[99].range_mm=60: robot.sensors.99: is no element of the robot's list; allowed: 0 to 18"]);
}

/// The values of a list's element are swept, and are those of the same settings.
#[test]
fn an_element_of_a_list_is_swept() {
    let place = Place::new("elements");
    place.write("ask.wgsl", TASK);
    place.write(
        "one.toml",
        "cycles = 4\n[robot]\npreset = \"epuck\"\n[arena]\nwidth_mm = 2000.0\nheight_mm = 2000.0\n\
         lights = [{ x_mm = 3.0, y_mm = 5.0 }, { x_mm = 7.0, y_mm = 11.0 }]\n\
         [task]\nkind = \"own\"\npart = \"ask.wgsl\"\n[evolution]\npopulation = 4\nparents = 2\ngenerations = 1\nfinalists = 0\n",
    );
    let sweep = "experiment = \"one.toml\"\nseeds = [1]\n[grid]\narena.lights.1.x_mm = [7.0, 9.0]\n";
    place.write("sweep.toml", sweep);
    place.good(&[&["sweep", "run", "sweep.toml", "--out", "all", "--yes"], &CPU[..]].concat());
    let table = place.text("all/results.csv");
    let mut lines = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().unwrap();
    let column = |name: &str| {
        head.iter()
            .position(|own| *own == name)
            .unwrap_or_else(|| panic!("{table}"))
    };
    let (swept, best) = (column("arena.lights.1.x_mm"), column("best"));
    let number = |text: &str| text.parse::<f32>().unwrap();
    let cells: Vec<_> = lines.map(|line| (number(line[swept]), number(line[best]))).collect();
    let expected = |x: f32| 35.0 + 1.0 + 1000.0 * (3.0 + 10.0 + 9.0) + 2000.0 * (x + 22.0 + 9.0) + 0.5 * x;
    assert_eq!(cells, [(7.0, expected(7.0)), (9.0, expected(9.0))]);
    place.write("sweep.toml", sweep.replace("lights.1", "lights.2"));
    place.run(&["sweep", "plan", "sweep.toml"]).exits(3).says(&[
        "sweep.toml:4:24",
        "arena.lights.2: is no element of the list; allowed: 0 to 1",
    ]);
}

/// What `oneiro new --robot` writes is valid and lives, with a part of one's own too.
#[test]
fn a_described_robot_is_written() {
    let place = Place::new("robots");
    for robot in ["khepera", "epuck", "thymio2", "kheperax", "epuck-rm1.1", "epuck-rm1.2"] {
        place.good(&["new", robot, "--robot", robot, "--task", &format!("{robot}-task")]);
        let path = format!("{robot}.toml");
        let checked = place.run(&["check", &path]).exits(0);
        assert!(!checked.stderr.contains("warning"), "{}", checked.stderr);
        assert!(checked.stdout.contains(", radius "), "{}", checked.stdout);
        fitness(&place, &path, "cpu", &[]);
    }
    place.good(&["new", "alone", "--robot", "epuck"]);
    place.good(&["check", "alone.toml"]);
    place
        .run(&["new", "other", "--robot", "epuk"])
        .exits(3)
        .says(&["--robot epuk: is unknown; did you mean epuck? (allowed: khepera, epuck, thymio2, kheperax, epuck-rm1.1, epuck-rm1.2)"]);
    place.run(&["new", "other", "--robot", "epuck", "--forager"]).exits(2);
    assert!(!place.at("other.toml").exists());
}

/// A task's file is that task, with every robot that may have it; otherwise nothing is written.
#[test]
fn tasks_are_written_with_robots_that_may_have_them() {
    let place = Place::new("tasks");
    let written = |task: &str, more: &[&str]| {
        let name = [&[task], more].concat().join("-").replace("--", "");
        let new = [&["new", &*name, "--task", task], more].concat();
        let ran = place.run(&new);
        if ran.code == Some(3) {
            assert!(!place.at(format!("{name}.toml")).exists(), "{name}");
            return false;
        }
        let ran = ran.exits(0);
        assert!(ran.stderr.contains("next: "), "{}", ran.stderr);
        place.good(&["check", &format!("{name}.toml")]);
        fs::remove_file(place.at(format!("{task}.wgsl"))).unwrap();
        true
    };
    for ready in READY {
        assert!(written(ready.word, &[]), "{}", ready.word);
        assert!(!written(ready.word, &["--forager"]), "{}", ready.word);
    }
    for task in ["stay-together", "gather-pucks", "bring-pucks"] {
        let robots = ["khepera", "epuck", "thymio2", "kheperax", "epuck-rm1.1", "epuck-rm1.2"];
        let found = robots.map(|robot| written(task, &["--robot", robot]));
        let has_model = task == "stay-together";
        assert_eq!(found, [true, true, true, false, has_model, has_model], "{task}");
    }
    for task in ["avoidance", "foraging.wgsl"] {
        place
            .run(&["new", "other", "--task", task])
            .exits(3)
            .says(&["has no file in WGSL; allowed: task.kind"]);
    }
}

/// Values that number a patch, poses that no episode has, and floors that nothing reads.
#[test]
fn what_would_have_no_effect_is_said() {
    let place = Place::new("effects");
    let arena = "[robot]\npreset = \"kheperax\"\n[arena]\nwidth_mm = 900.0\nheight_mm = 600.0\n";
    let patch = "patches = [{ x_mm = 450.0, y_mm = 300.0, radius_mm = 90.0, grey = 0.0 }]\n";
    place.write("reach.toml", format!("{arena}{patch}[task]\nkind = \"reach\"\n"));
    for goal in ["1", "0.5"] {
        let set = format!("task.values.goal={goal}");
        let ran = place.run(&["check", "reach.toml", "--set", &set]).exits(3);
        ran.says(&[&format!(
            "task.values.goal: is {goal}; allowed: the number of a patch, whole numbers from 0 to 0"
        )]);
    }
    let checked = place.run(&["check", "reach.toml"]).exits(0);
    assert!(!checked.stderr.contains("floor"), "{}", checked.stderr);
    place.write("floor.toml", format!("{arena}{patch}"));
    let checked = place.run(&["check", "floor.toml"]).exits(0);
    checked.says(&["arena.patches: has no effect: no sensor, task or other part reads the floor"]);
    let poses = "[start]\nkind = \"poses\"\nposes = [[200, 200, 0], [300, 200, 0], [400, 200, 0]]\n";
    place.write("poses.toml", format!("trials = 2\n{arena}{poses}"));
    let checked = place.run(&["check", "poses.toml"]).exits(0);
    checked.says(&["start.poses: has 3 poses, of which the 2 episodes of a genome take the first 2"]);
    let all = place.run(&["check", "poses.toml", "--set", "trials=3"]).exits(0);
    assert!(!all.stderr.contains("start.poses"), "{}", all.stderr);
}

/// A forager's clearance is that of its round wall.
#[test]
fn a_forager_sees_its_round_wall() {
    let place = Place::new("round");
    let task = "fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let gap = clearance(episode, now.end.xy, 2000.0);
    let along = distance_along(episode, now.end.xy, atan2(now.end.y, now.end.x) / 6.2831855, 2000.0) - body_radius(episode);
    return Reward(select(0.0, 1.0, abs(gap - along) < 0.05 && gap < 1000.0 && clearance(episode, now.end.xy, 1.5) <= 1.5), before);
}
struct TaskState { unused: f32 }
";
    place.write("gap.wgsl", task);
    place.write(
        "gap.toml",
        "cycles = 40\n[robot]\nkind = \"forager\"\n[controller]\nkind = \"behaviours\"\n[task]\nkind = \"own\"\npart = \"gap.wgsl\"\n",
    );
    let table = place.good(&[
        "evaluate",
        "gap.toml",
        "--random",
        "4",
        "--seed",
        "1",
        "--backend",
        "cpu",
        "--quiet",
    ]);
    let fitness: Vec<&str> = table
        .lines()
        .skip(1)
        .map(|line| line.split(',').nth(2).unwrap())
        .collect();
    assert_eq!(fitness, ["40"; 4], "{table}");
}

/// Rows of two genomes in two episodes, up to their fitness, by how the episodes are watched.
fn rows(place: &Place, experiment: &str, watched: &[&str]) -> Vec<String> {
    let all = [
        &["evaluate", experiment, "--random", "2", "--trials", "2", "--seed", "1"][..],
        &["--set", "cycles=30", "--backend", "cpu", "--quiet"],
        watched,
    ];
    let table = place.good(&all.concat());
    let until_bits = |line: &str| line.split(',').take(4).collect::<Vec<_>>().join(",");
    table.lines().map(until_bits).collect()
}

/// Who watches an episode to its end, for measures or a trace, changes nothing: its parts are told the cycles that it has. With the
/// tasks that ship, and experiments that ship; all of them in `tests/long.sh`.
#[test]
fn watching_changes_no_fitness() {
    let place = Place::new("watched");
    let robot = "[robot]\npreset = \"epuck\"\n[arena]\nwidth_mm = 900.0\nheight_mm = 600.0\n\
                 lights = [{ x_mm = 700.0, y_mm = 500.0 }]\n\
                 patches = [{ x_mm = 450.0, y_mm = 300.0, radius_mm = 200.0, grey = 0.0 }]\n\
                 obstacles = [{ x_mm = 200.0, y_mm = 300.0, radius_mm = 40.0 }]\n";
    let mut files = Vec::new();
    for (task, swarm) in [("reach", ""), ("phototaxis", ""), ("stay-together", "count = 4\n")] {
        let file = format!("{task}.toml");
        let robot = robot.replace("[arena]", &format!("{swarm}[arena]"));
        place.write(&file, format!("{robot}[task]\nkind = \"{task}\"\n"));
        files.push(file);
    }
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments");
    let mut names: Vec<_> = fs::read_dir(&shipped)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    names.retain(|path| path.extension().is_some_and(|extension| extension == "toml") && !path.ends_with("Cargo.toml"));
    names.sort();
    let step = if std::env::var_os("ONEIRO_LONG").is_some() {
        1
    } else {
        12
    };
    files.extend(names.iter().step_by(step).map(|path| path.display().to_string()));
    for (number, file) in files.iter().enumerate() {
        let plain = rows(&place, file, &[]);
        assert_eq!(plain.len(), 5, "{file}");
        assert_eq!(rows(&place, file, &["--measures"]), plain, "{file}");
        let traces = format!("traces-{number}");
        assert_eq!(rows(&place, file, &["--traces", &traces]), plain, "{file}");
    }
}
