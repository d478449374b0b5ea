//! `oneiro reproduce miglino1995 --robot` of a Khepera that always reads the same, so that fitness does not depend on time.

use std::fs::{self, File};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, Command};
use std::thread::JoinHandle;

use super::run::{status, stops, wait_for_cycles};
use super::*;
use crate::place::Ran;
use crate::robots;

/// Lives of a run of each condition: two of the transferred generation, another generation, and the champions.
const LIVES: usize = 3 * (3 * 2 + 1);

/// A small study, and the samples of a robot.
fn placed(name: &str) -> Place {
    let place = Place::new(name);
    let experiments = Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments");
    let mut study = fs::read_to_string(experiments.join("miglino1995/study.toml")).unwrap();
    let small = "[set]\ncycles = 6\nevolution = { generations = 3, population = 2, parents = 1 }\n";
    // On a busy machine the robot answers late.
    let wire = "walk_s = 0\nguard.link_ms = 400\n";
    for (from, to) in [
        ("experiment = \"../khepera-avoidance.toml\"\n", ""),
        ("[set]\n", small),
        ("generations = 20\n", "generations = 2\n"),
        ("walk_s = 10.0\n", wire),
    ] {
        assert_eq!(study.matches(from).count(), 1, "{from}");
        study = study.replace(from, to);
    }
    place.write("own.toml", study);
    place.good(&["robot", "sample", "--backend", "cpu", "--quiet", "--out", "samples"]);
    place
}

fn study<'a>(address: &'a str, out: &'a str) -> Vec<&'a str> {
    // Conditions of the second edition share their random numbers: in so few generations they have the same controllers, and what was
    // done with one is on record for the others.
    let own = "reproduce miglino1995 --edition first --study own.toml --runs 1 --backend cpu";
    let tables = "--tables samples/wall.sam,samples/round.sam,samples/motor.sam";
    let words = own.split(' ').chain(tables.split(' '));
    words.chain(["--robot", address, "--out", out]).collect()
}

/// The program with somebody at its terminal who does what is asked for.
struct Session {
    program: Child,
    said: JoinHandle<String>,
}

impl Session {
    fn start(place: &Place, arguments: &[&str]) -> Self {
        let (mut terminal, mut slave) = serialport::TTYPort::pair().unwrap();
        let path = slave.name().unwrap();
        slave.set_exclusive(false).unwrap();
        let stty = Command::new("stty").args(["-F", &path, "sane"]).status();
        assert!(stty.unwrap().success());
        let input = File::options().read(true).write(true).open(&path).unwrap();
        let mut command = place.command(arguments);
        let command = command.stdin(input).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut program = command.spawn().unwrap();
        let lines = BufReader::new(program.stderr.take().unwrap()).lines();
        let said = thread::spawn(move || {
            // The terminal is closed when the program has ended.
            let _slave = slave;
            let mut said = String::new();
            for line in lines.map_while(Result::ok) {
                if line.contains("then press Enter") {
                    thread::sleep(Duration::from_millis(200));
                    terminal.write_all(b"\n").unwrap();
                }
                said += &(line + "\n");
            }
            said
        });
        Self { program, said }
    }

    fn signal(&self, signal: &str) {
        let id = self.program.id().to_string();
        assert!(Command::new("kill").args([signal, &id]).status().unwrap().success());
    }

    fn ended(self, arguments: &[&str]) -> Ran {
        let mut ran = Ran::new(arguments, &self.program.wait_with_output().unwrap());
        ran.stderr = self.said.join().unwrap();
        ran
    }
}

/// Killed in the middle of a life, and stopped by Ctrl-C in another: the wheels stand, the same command continues, only the lives that
/// were cut short are lived again, and the outcome is that of an undisturbed study.
#[test]
fn a_study_on_a_robot_goes_on() {
    let place = placed("study");
    let bodies = [Body::default(), Body::default()];
    let addresses = bodies.each_ref().map(robots::khepera);
    let whole = study(&addresses[0], "whole");
    let undisturbed = Session::start(&place, &whole);

    let (body, address) = (&bodies[1], &addresses[1]);
    let arguments = study(address, "out");
    let session = Session::start(&place, &arguments);
    wait_for_cycles(&place, "out/lives/life-5.csv", 3);
    let event = Instant::now();
    session.signal("-KILL");
    stops(&place, body, address, event);
    session.ended(&arguments);
    let session = Session::start(&place, &arguments);
    wait_for_cycles(&place, "out/lives/life-14.csv", 3);
    let event = Instant::now();
    session.signal("-INT");
    stops(&place, body, address, event);
    let ran = session.ended(&arguments).exits(75);
    ran.says(&[
        "21 episodes of 0.6 s, each after 0 s of driving about: 0.2 robot-minutes, less for those that are on record; for 3 of \
         them, those of the champions, somebody has to put the robot at the start",
        "no noise, run 0: generation 3, individual 0 (0 to 1), again",
        "run the same command again to continue",
    ]);
    assert!(!place.at("out/claims.json").exists());
    let ran = Session::start(&place, &arguments).ended(&arguments).exits(0);
    ran.says(&[
        "conservative noise, run 0: generation 4, individual 1 (0 to 1)\n",
        "run 0, champions of generation 3, each from the same start: no noise, individual ",
        "put the robot at x = 100 mm and y = 90 mm, 45 degrees counter-clockwise from the x axis; then press Enter",
    ]);
    assert!(body.stands());
    let status = status(&place, "out");
    assert_eq!(status.len(), LIVES + 2);
    assert_eq!((&*status[4], &*status[13]), ("the program ended", "stopped"));
    assert_eq!(status.iter().filter(|status| *status == "complete").count(), LIVES);
    let index = Table::read(&place, "out/lives/lives.csv");
    let keys = index.column("key");
    assert_eq!((keys[4], keys[13]), (keys[5], keys[14]));
    let lived: std::collections::BTreeSet<&str> = keys.into_iter().collect();
    assert_eq!(lived.len(), LIVES);

    undisturbed.ended(&whole).exits(0);
    assert!(bodies[0].stands());
    for name in ["generations.csv", "transferred.csv", "last.csv"] {
        assert_eq!(
            place.text(format!("out/{name}")),
            place.text(format!("whole/{name}")),
            "{name}"
        );
    }
    for out in ["out", "whole"] {
        let page = place.text(format!("{out}/report.html"));
        assert!(page.contains("Not measured: ") && !page.contains("NaN"));
        assert!(place.text(format!("{out}/README.md")).contains("| `lives/` "));
    }
    // It is whole, and needs no robot any more.
    let since = body.wheels().1;
    body.is_deaf.store(true, Ordering::SeqCst);
    let ran = place.run(&arguments).exits(0);
    assert!(!ran.stderr.contains("lives of"), "{}", ran.stderr);
    assert_eq!(body.wheels().1, since);
}
