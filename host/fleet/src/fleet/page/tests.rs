use std::sync::Arc;

use oneiro::swarm::SECOND;
use oneiro_lab::exchange::radio::Status;
use oneiro_report::figures::browser;
use serde_json::{Value, json};

use super::super::live::tests::fleet;
use super::*;

/// A robot that spoke `age` ms ago, and has brought this much.
fn known(age: u64, brought: u32) -> Known {
    Known {
        heard: Instant::now().checked_sub(Duration::from_millis(age)),
        status: Some(Status {
            start: 1,
            milliseconds: 0,
            state: 3,
            interval: 2,
            simulator: 0.25,
            real: 12.34,
            simulated: -1.0,
            controller: [0.5, 0.75],
            brought,
            carries: true,
            pose: [100.0, -250.0, 0.25],
            volts: -1.0,
            problems: 0b1000,
            ignored: 0,
        }),
        ..Known::default()
    }
}

/// What a script brings.
fn brought(script: &str) -> Value {
    let data = script.strip_prefix("window.oneiro.take(").unwrap();
    serde_json::from_str(data.trim_end().strip_suffix(");").unwrap()).unwrap()
}

fn script_of(fleet: &Fleet) -> Value {
    brought(&std::fs::read_to_string(fleet.directory.join(SCRIPT)).unwrap())
}

/// A fleet's directory, as `start` has it before it makes the page.
fn with_directory(name: &str) -> Arc<Fleet> {
    let (fleet, _) = fleet(name);
    std::fs::create_dir_all(&fleet.directory).unwrap();
    fleet
}

/// Robot 0 falls silent after two seconds; robot 1 is never heard.
fn silent(fleet: &Fleet) -> Result {
    let mut page = Page::open(fleet, 0)?;
    for (second, age, total) in [(1, 200, 3), (2, 400, 5), (3, 5_000, 5)] {
        let robots = BTreeMap::from([(0, known(age, total)), (1, Known::default())]);
        page.look(&robots, Some(1000 * second));
        // The second look in a second has no news.
        page.look(&BTreeMap::new(), Some(1000 * second + 20));
    }
    page.end("The end.".to_owned())
}

#[test]
fn a_robot_that_falls_silent_has_no_pose_and_keeps_its_food() {
    let fleet = with_directory("silent");
    silent(&fleet).unwrap();
    let rows = statuses::rows(&fleet.directory).unwrap();
    let shown: Vec<_> = rows.iter().map(|row| (row.second, row.robot, &*row.state)).collect();
    let expected = [
        (1, 0, "living"),
        (1, 1, "silent"),
        (2, 0, "living"),
        (2, 1, "silent"),
        (3, 0, "away"),
        (3, 1, "silent"),
    ];
    assert_eq!(shown, expected);
    assert_eq!((rows[0].s0, rows[0].simulated, rows[0].volts), (Some(0.25), None, None));
    assert_eq!((rows[2].brought, rows[4].brought, rows[4].x), (Some(5), None, None));
    assert_eq!((&*rows[2].problems, &*rows[4].problems), ("disk", ""));
    assert!((5.0..10.0).contains(&rows[4].age_s.unwrap()) && rows[5].age_s.is_none());

    let story = Story::of(vec![0, 1], MOST, rows);
    let moments = story.moments();
    let of_first: Vec<_> = moments
        .iter()
        .map(|moment| {
            (
                moment.cycle,
                moment.robots[0].pose,
                moment.robots[0].brought,
                moment.robots[0].act,
            )
        })
        .collect();
    let place = Some([100.0, -250.0, 0.25]);
    assert_eq!(of_first, [(10, place, 3, 3), (20, place, 2, 3), (30, None, 0, 8)]);
    assert!(
        moments
            .iter()
            .all(|moment| moment.robots[1].pose.is_none() && moment.robots[1].act == 9)
    );
    let [genes, none] = &story.genes()[..] else {
        panic!("two robots")
    };
    let expected = Genes {
        cycle: 10,
        s0: 0.25,
        g0: 0.5,
        g1: 0.75,
    };
    assert_eq!((&genes[..], none.len()), (&[expected][..], 0));

    let script = script_of(&fleet);
    assert_eq!(
        (&script["times"], &script["names"]),
        (&json!([10, 20, 30]), &json!([0, 1]))
    );
    assert_eq!(
        (&script["end"], &script["problems"]),
        (&json!("The end."), &json!(["", "disk"]))
    );
    std::fs::remove_dir_all(fleet.directory.parent().unwrap()).unwrap();
}

/// Robots of another version take no part, whatever they send; robots that the tracker does not see have no pose.
#[test]
fn what_is_not_known_is_left_out() {
    let refused = Known {
        refused: Some("has oneiro 0.0.1".to_owned()),
        ..known(0, 1)
    };
    let row = Row::of(7, 0, &refused);
    assert_eq!(
        (&*row.state, &*row.problems, row.x),
        ("refused", "has oneiro 0.0.1", None)
    );
    let mut lost = known(0, 1);
    lost.status.as_mut().unwrap().pose = [0.0; 3];
    let row = Row::of(7, 0, &lost);
    assert_eq!(
        (&*row.state, row.brought, row.x, row.heading),
        ("living", Some(1), None, None)
    );
}

/// The table continues after a stop, and after a crash in the middle of a row. Stopped time is not recorded.
#[test]
fn the_record_goes_on() {
    let fleet = with_directory("goes-on");
    silent(&fleet).unwrap();
    let path = fleet.directory.join(statuses::STATUSES);
    let before = std::fs::read_to_string(&path).unwrap();
    assert!(before.starts_with(&oneiro_base::contents::head(&statuses::STATUSES_COLUMNS)));
    std::fs::write(&path, format!("{before}4,0,liv")).unwrap();

    let mut page = Page::open(&fleet, 3_700).unwrap();
    page.look(&BTreeMap::from([(0, known(0, 5))]), None);
    page.look(&BTreeMap::from([(0, known(0, 6))]), Some(4_100));
    page.end("The end.".to_owned()).unwrap();
    let after = std::fs::read_to_string(&path).unwrap();
    let added: Vec<&str> = after.strip_prefix(&*before).unwrap().lines().collect();
    assert!(added.len() == 1 && added[0].starts_with("4,0,living,"), "{added:?}");
    assert_eq!(script_of(&fleet)["times"], json!([10, 20, 30, 40]));

    let page = std::fs::read_to_string(replay(&fleet).unwrap()).unwrap();
    assert!(page.contains("\"times\":[10,20,30,40]") && !page.contains("\"live\":"));
    assert!(page.contains("2 e-pucks forage for food") && page.contains("4 s, a line each second"));

    std::fs::write(&path, after.replace("2,0,living", "2,zero,living")).unwrap();
    for failure in [replay(&fleet).unwrap_err(), Page::open(&fleet, 0).err().unwrap()] {
        assert!(
            failure.code() == 5 && failure.to_string().contains("line: 4"),
            "{failure}"
        );
    }
    std::fs::remove_file(&path).unwrap();
    assert_eq!(replay(&fleet).unwrap_err().code(), 3);
    std::fs::remove_dir_all(fleet.directory.parent().unwrap()).unwrap();
}

/// Ten hours of ten robots whose genes change every second: the script stays small, and its last line is the newest.
#[test]
fn a_long_life_is_thinned() {
    let robots: Vec<u32> = (0..10).collect();
    let line = |second: u32| -> Vec<Row> {
        let row = |&robot: &u32| Row {
            s0: Some((second % 99) as f32 / 100.0),
            brought: Some(second / 100),
            ..Row::of(second, robot, &known(0, 0))
        };
        robots.iter().map(row).collect()
    };
    let mut story = Story::of(robots.clone(), MOST, Vec::new());
    for second in 0..36_001 {
        story.add(line(second));
    }
    story.add(line(36_001));
    let (moments, genes) = (story.moments(), story.genes());
    assert!((MOST / 20..=MOST / 10).contains(&moments.len()), "{}", moments.len());
    let cycles: Vec<u32> = moments.iter().map(|moment| moment.cycle / SECOND).collect();
    let (last, others) = cycles.split_last().unwrap();
    assert_eq!(*last, 36_001);
    let expected: Vec<u32> = (0..=36_000).step_by(32).collect();
    assert_eq!(others, expected);
    let food: u32 = moments.iter().map(|moment| moment.robots[9].brought).sum();
    assert_eq!(food, 360);

    let fleet = with_directory("long");
    let scene = Scene {
        robots,
        ..Scene::of(&fleet)
    };
    let script = live_script(&scene.replay(&moments, &genes), 0, None);
    assert!(script.len() < 1 << 20, "{}", script.len());
    std::fs::remove_dir_all(fleet.directory.parent().unwrap()).unwrap();
}

/// The disk is busy for two seconds: the operator does not wait, and the delayed lines are written later.
#[cfg(unix)]
#[test]
fn a_slow_disk_keeps_nobody_waiting() {
    let fleet = with_directory("slow");
    let mut writer = Writer::begin(&fleet).unwrap();
    let mut wait = Duration::from_secs(2);
    let slow = move |told| {
        thread::sleep(std::mem::take(&mut wait));
        writer.take(told)
    };
    let mut page = Page::written_by(slow, 0).unwrap();
    let began = Instant::now();
    for second in 1..=20 {
        page.look(
            &BTreeMap::from([(0, known(0, 0)), (1, known(0, 0))]),
            Some(1000 * second),
        );
    }
    let waited = began.elapsed();
    assert!(waited < Duration::from_secs(1), "{waited:?}");
    page.end("The end.".to_owned()).unwrap();
    let rows = statuses::rows(&fleet.directory).unwrap();
    assert!(
        (2 * WAITING..=2 * WAITING + 4).contains(&rows.len()),
        "{} rows",
        rows.len()
    );
    assert_eq!(script_of(&fleet)["end"], "The end.");
    std::fs::remove_dir_all(fleet.directory.parent().unwrap()).unwrap();
}

/// The page is opened as a file: it loads the script again and again, shows the newest line unless the user looks back,
/// and reports when nothing new comes.
#[test]
fn a_browser_shows_what_is_new() {
    let fleet = with_directory("browser");
    let script = || std::fs::read_to_string(fleet.directory.join(SCRIPT)).unwrap();
    silent(&fleet).unwrap();
    let first = script();
    let mut page = Page::open(&fleet, 3_000).unwrap();
    page.look(&BTreeMap::from([(0, known(300, 7)), (1, known(0, 1))]), Some(4_000));
    page.end("Later.".to_owned()).unwrap();
    let second = script();
    // What a fleet would write one after the other.
    let both = format!(
        "switch (window.now ?? 1) {{ case 1: {first} break; case 2: {second} break; \
         case 3: window.oneiro.take({{ written: 3, end: null }}); }}"
    );
    std::fs::write(browser::folder("live-page").join(SCRIPT), both).unwrap();
    let ask = "\
        const soon = (ms) => new Promise((then) => setTimeout(then, ms));\n\
        const until = async (test) => { for (let look = 0; look < 400 && !test(); look++) await soon(50); };\n\
        const at = (id) => document.getElementById(id).textContent;\n\
        const age = (text) => (parseFloat(text) < 4 ? ' heard ' : ' not heard ');\n\
        const row = (moment) => moment.textContent.replace(/(\\d+\\.\\d) s ago/, age);\n\
        const rows = () => Array.from(document.querySelectorAll('#robots tbody tr'), row);\n\
        const drawn = () => window.oneiro.drawn(Number(document.getElementById('when').value)).robots.map(({ name }) => name);\n\
        const press = (key) => document.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));\n\
        const acts = [];\n\
        // News are there at once, a drawing with the next frame.\n\
        const tell = async () => { await soon(50); acts.push([at('clock'), at('news'), rows(), drawn()]); };\n\
        await until(() => at('news') === 'The end.'); await tell();\n\
        press('ArrowLeft'); await until(() => at('clock') === '0:02 of 0:03'); await soon(1200); await tell();\n\
        document.querySelectorAll('.who')[0].click(); await until(() => at('robot').startsWith('Robot 0')); acts.push(at('robot'));\n\
        window.now = 2; await until(() => at('clock').endsWith('0:04')); acts.push(at('clock'));\n\
        window.now = 1; await until(() => at('clock').endsWith('0:03')); press('End'); window.now = 2; await until(() => at('news') === 'Later.'); await tell();\n\
        window.now = 3; await until(() => at('news') === 'Live.'); acts.push(at('news'));\n\
        const now = performance.now.bind(performance); performance.now = () => now() + 60000;\n\
        await until(() => at('news') !== 'Live.'); acts.push(at('news').replace(/[0-9]+/, 'N'));\n\
        return acts;";
    let page = std::fs::read_to_string(fleet.directory.join(PAGE)).unwrap();
    std::fs::remove_dir_all(fleet.directory.parent().unwrap()).unwrap();
    let Some(told) = browser::told("live-page", &page, ask) else {
        return;
    };
    let expected = json!([
        [
            "0:03 of 0:03",
            "The end.",
            ["All5", "0away not heard 5", "1silentnever0"],
            []
        ],
        [
            "0:02 of 0:03",
            "The end. You are looking back: End shows what is now.",
            ["All5", "0livingdisk heard 5", "1silentnever0"],
            [0]
        ],
        "Robot 0 living, with food; disk; fitness in this interval 12.3.",
        "0:02 of 0:04",
        [
            "0:04 of 0:04",
            "Later.",
            ["All8", "0livingdisk heard 7", "1livingdisk heard 1"],
            [0, 1]
        ],
        "Live.",
        "Nothing new for N s: robots stand unless \u{201c}oneiro fleet start\u{201d} runs."
    ]);
    assert_eq!(told, expected);
}
