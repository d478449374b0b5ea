//! `oneiro on-board` of a Thymio II that lives in Aseba's simulator by itself.

use std::f64::consts::TAU;
use std::net::UdpSocket;

use super::*;
use crate::aseba::world;
use crate::place::Ran;
use crate::place::table::Table;

const ON_BOARD: [&str; 2] = ["on-board", "robot.toml"];
/// Side of the arena, mm.
const SIDE: f64 = 800.0;
const GENERATIONS: usize = 3;

/// What the simulator's robot does: at which time its wheels had which targets and speeds, in its units.
type Seen = (Instant, [i16; 4]);

/// A client beside the daemon's that reads the wheels, and reports as a tracker where they have brought the robot.
struct Tracker {
    is_over: Arc<AtomicBool>,
    seen: Arc<Mutex<Vec<Seen>>>,
    thread: JoinHandle<()>,
}

impl Tracker {
    fn start() -> Self {
        let (is_over, seen) = (Arc::<AtomicBool>::default(), Arc::<Mutex<Vec<Seen>>>::default());
        let (end, wheels) = (Arc::clone(&is_over), Arc::clone(&seen));
        let mut robot = Client::connect(SWITCH);
        let thread = thread::spawn(move || {
            let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
            let (start, mut last) = (Instant::now(), Instant::now());
            let [mut x, mut y, mut heading] = [SIDE / 2.0, SIDE / 2.0, 0.0];
            while !end.load(Ordering::SeqCst) {
                // Others on the network wait for a silence of 50 ms before they begin.
                thread::sleep(Duration::from_millis(60));
                let motors = robot.get_among("motor.left.target", "motor.right.speed");
                let (Some(targets), Some(speeds)) = (motors.first_chunk::<2>(), motors.last_chunk::<2>()) else {
                    panic!("{motors:?}");
                };
                let now = Instant::now();
                wheels
                    .lock()
                    .unwrap()
                    .push((now, [targets[0], targets[1], speeds[0], speeds[1]]));
                // The simulator's numbers: 500 units are 166 mm/s, and 94 mm between the wheels.
                let [left, right] = [speeds[0], speeds[1]].map(|speed| f64::from(speed) * 0.332);
                let time = (now - last).as_secs_f64();
                last = now;
                heading += time * (right - left) / 94.0;
                let way = time * f64::midpoint(left, right);
                (x, y) = (x + way * heading.cos(), y + way * heading.sin());
                let t = start.elapsed().as_secs_f64();
                let line = json!({ "id": 1, "t": t, "x": x, "y": y, "heading": heading / TAU });
                // Nobody may listen.
                let _ = socket.send_to(line.to_string().as_bytes(), ("127.0.0.1", 5005));
            }
        });
        Self { is_over, seen, thread }
    }

    fn newest(&self) -> Seen {
        *self.seen.lock().unwrap().last().unwrap()
    }

    /// When the wheels began to stand, of those at the end.
    fn stood(&self) -> Instant {
        let seen = self.seen.lock().unwrap();
        let moving = seen.iter().rposition(|(_, wheels)| *wheels != [0; 4]);
        seen[moving.unwrap() + 1].0
    }

    fn end(self) {
        self.is_over.store(true, Ordering::SeqCst);
        self.thread.join().unwrap();
    }
}

/// A Thymio II evolves on board and is killed in a life: its wheels stand in time, and it goes on where it was. The simulator of the
/// daemon proposes what a run from its seed has as the best of each generation.
#[test]
fn a_thymio_evolves_on_board_in_the_simulator() {
    let name = "a_thymio_evolves_on_board_in_the_simulator";
    if !in_a_network(name, "a Thymio II that evolves on board in Aseba's simulator") {
        return;
    }
    let robot = format!(
        r#"<robot type="thymio2" x="{0}" y="{0}" angle="0" port="{1}" name="r1" nodeId="1"/>"#,
        SIDE / 20.0,
        driven(0)
    );
    live(&world(SIDE / 10.0, SIDE / 10.0, &robot), 1, 1, |playground| {
        let _switch = Switch::start(&[format!("tcp:localhost;{}", driven(0))]);
        lives(&playground.place);
    });
}

fn lives(place: &Place) {
    let side = format!("width_mm = {SIDE:?}\nheight_mm = {SIDE:?}\n");
    place.write(
        "experiment.toml",
        format!(
            "cycles = 12\n[robot]\npreset = \"thymio2\"\n[arena]\n{side}\
             [evolution]\npopulation = 20\nparents = 4\ngenerations = {GENERATIONS}\nfinalists = 0\n"
        ),
    );
    place.write(
        "robot.toml",
        format!(
            "experiment = \"experiment.toml\"\naddress = \"aseba:127.0.0.1:{SWITCH}\"\nseed = 3\ndirectory = \"state\"\n\
             [transfers]\ngenerations = 1\nagain_every = 0\nleast_lives = 1\nfinal_lives = 1\n\
             [lives]\nwalk_s = 0\ntracker = \"udp:127.0.0.1:5005#1\"\n"
        ),
    );
    // What the playground's crash has left of a try before.
    let _ = fs::remove_dir_all(place.at("state"));
    let tracker = Tracker::start();
    let began = Instant::now();

    // In the second life, while it moves.
    let mut daemon = place.start(&ON_BOARD);
    let cycles = |life: u32| {
        let text = fs::read_to_string(place.at(format!("state/lives/life-{life}.csv")));
        text.map_or(0, |text| text.lines().count())
    };
    while cycles(2) < 6 || tracker.newest().1 == [0; 4] {
        let is_over = daemon.try_wait().unwrap().is_some() || began.elapsed() > LONG;
        if is_over {
            let _ = daemon.kill();
            Ran::ended(&ON_BOARD, daemon).exits(0);
            panic!("no second life");
        }
        thread::sleep(Duration::from_millis(5));
    }
    let event = Instant::now();
    daemon.kill().unwrap();
    daemon.wait().unwrap();
    thread::sleep(Duration::from_secs(1));
    let took = tracker.stood().saturating_duration_since(event);
    assert_eq!(tracker.newest().1, [0; 4]);
    assert!(took <= LIMIT, "{took:?}");
    let kept = place.text("state/transfers.csv");
    assert_eq!(kept.lines().count(), 2, "{kept}");

    place.run(&ON_BOARD).exits(0);
    let lived = began.elapsed();
    assert_eq!(tracker.newest().1, [0; 4]);
    tracker.end();
    assert!(place.text("state/transfers.csv").starts_with(&kept));
    let transfers = Table::read(place, "state/transfers.csv");
    let lives = Table::read(place, "state/lives/lives.csv");
    assert!(lives.column("status").contains(&"the program ended"));
    let lives = lives.complete();
    assert_eq!(transfers.column("bits"), lives.column("bits"));
    let text = place.text("state/log.jsonl");
    assert_eq!(text.matches("\"event\":\"simulated\"").count(), GENERATIONS);
    assert_eq!(transfers.column("why").last(), Some(&"final"));

    // It has driven, and has seen that.
    let greatest = |columns: &[&str]| {
        let spread = |life: &str| {
            let table = Table::read(place, &format!("state/lives/life-{life}.csv"));
            let spread = |column: &&str| {
                let numbers = table.numbers(column);
                let [least, greatest] = [f32::min, f32::max].map(|pick| numbers.iter().copied().fold(f32::NAN, pick));
                greatest - least
            };
            columns.iter().map(spread).fold(0.0, f32::max)
        };
        lives.column("life").into_iter().map(spread).fold(0.0, f32::max)
    };
    let way = greatest(&["x_mm", "y_mm"]);
    let seen = greatest(&["raw_prox_0", "raw_prox_2", "raw_prox_4"]);
    assert!(way > 60.0 && seen > 500.0, "{way} mm, {seen}");

    place.good(&[
        "run",
        "experiment.toml",
        "--seed",
        "3",
        "--out",
        "run",
        "--backend",
        "cpu",
        "--quiet",
    ]);
    let run = Table::read(place, "run/generations.csv");
    assert_eq!(transfers.column("why")[..GENERATIONS], ["new"; GENERATIONS]);
    for (own, name) in [
        ("generation", "generation"),
        ("individual", "individual"),
        ("simulated", "best"),
    ] {
        assert_eq!(transfers.column(own)[..GENERATIONS], run.column(name), "{own}");
    }
    let late = ["late_median_ms", "late_max_ms"].map(|name| lives.column(name).join(", "));
    eprintln!(
        "{} lives in {lived:.1?}, {way:.0} mm in one; after the kill it stood in {} ms; late by {} ms (median), {} ms (greatest)",
        lives.rows.len(),
        took.as_millis(),
        late[0],
        late[1]
    );
}
