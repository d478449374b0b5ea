//! Clients that others wrote read, drive and stop the robots that are scripted here, and the program reads the same of them.
//! `tests/peers.sh` installs the clients.
#![cfg(unix)]

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::Duration;

use serde_json::{Value, json};

use crate::peers::{Body, EPuck2};
use crate::place::Place;
use crate::robots;

/// A client. It says a line, and waits for one before it goes on.
struct Client(Child, Box<dyn BufRead>);

impl Client {
    /// Starts a script of `tests/clients` with a robot's port.
    fn start(script: &str, address: &str) -> Self {
        let python = std::env::var_os("ONEIRO_CLIENTS").expect("tests/peers.sh says which Python has the clients");
        let mut command = Command::new(python);
        command.arg(format!("{}/../tests/clients/{script}", env!("CARGO_MANIFEST_DIR")));
        command.arg(address.rsplit_once(':').unwrap().1);
        let mut process = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let lines = BufReader::new(process.stdout.take().unwrap());
        Self(process, Box::new(lines))
    }

    fn hear(&mut self) -> Value {
        let mut line = String::new();
        self.1.read_line(&mut line).unwrap();
        serde_json::from_str(&line).unwrap()
    }

    fn go_on(&mut self) {
        writeln!(self.0.stdin.as_mut().unwrap()).unwrap();
    }

    fn end(mut self) {
        self.go_on();
        assert!(self.0.wait().unwrap().success());
    }
}

/// What the program reads of the robot.
fn watched(address: &str) -> Value {
    let text = Place::new("watched").good(&["robot", "watch", address, "--json", "--cycles", "1"]);
    serde_json::from_str::<Value>(&text).unwrap()["values"].take()
}

/// Names of sensors, and what the client reads of them.
fn assert_same(program: &Value, names: &[&str], client: &Value) {
    // It takes all words as unsigned.
    let signed = |value: &Value| value.as_i64().unwrap() as u16 as i16;
    let list = client.as_array().cloned().unwrap_or_else(|| vec![client.clone()]);
    assert_eq!(names.len(), list.len(), "{names:?}");
    for (name, value) in names.iter().zip(list) {
        assert_eq!(signed(&program[name]), signed(&value), "{name}");
    }
}

#[test]
#[ignore = "tests/peers.sh runs it, with the client thymiodirect from PyPI"]
fn thymiodirect_has_a_thymio() {
    let body = Body::default();
    let address = robots::thymio(&body);
    let mut client = Client::start("thymio.py", &address);
    let said = client.hear();
    assert_eq!(body.wheels().0, [100, -100], "it only reads");
    assert_eq!(said["node"], 1);
    assert_eq!(said["events"], json!(["buttons", "motor"]));
    assert_eq!(said["functions"], json!(["leds.top", "sound.system"]));
    client.go_on();
    assert_eq!(client.hear(), json!([120, 65456]));
    assert_eq!(body.wheels().0, [120, -80]);
    client.go_on();
    assert_eq!(client.hear(), json!([0, 0]));
    assert_eq!(body.wheels().0, [0, 0]);
    client.end();

    body.set([100, -100]);
    let (values, program) = (&said["values"], watched(&address));
    for (names, variable) in [
        (
            &["prox_0", "prox_1", "prox_2", "prox_3", "prox_4", "prox_5", "prox_6"][..],
            "prox.horizontal",
        ),
        (&["ground_left", "ground_right"], "prox.ground.delta"),
        (&["acceleration_x", "acceleration_y", "acceleration_z"], "acc"),
        (&["button_backward"], "button.backward"),
        (&["button_left"], "button.left"),
        (&["button_center"], "button.center"),
        (&["button_forward"], "button.forward"),
        (&["button_right"], "button.right"),
    ] {
        assert_same(&program, names, &values[variable]);
    }
    // The program stops a robot before it reads.
    assert_eq!(values["motor.left.speed"], 100);
    assert_eq!(program["wheel_speed_left"], 0);
}

#[test]
#[ignore = "tests/peers.sh runs it, with the client unifr-api-epuck from PyPI"]
fn unifr_api_epuck_has_an_e_puck2() {
    let robot = EPuck2::default();
    let address = robot.start();
    let mut client = Client::start("epuck.py", &address);
    let said = client.hear();
    // Its first command stops it.
    assert_eq!(robot.0.wheels().0, [0, 0]);
    assert_eq!(said["floats"], json!([9.5, 120.25, 3.75]));
    assert_eq!(said["remote"], json!([1, 8, 5]));
    assert_eq!(said["battery"], 3195);
    client.go_on();
    let steps = client.hear();
    assert_eq!(robot.0.wheels().0, [212, -106]);
    let (left, right) = (steps[0].as_i64().unwrap(), steps[1].as_i64().unwrap());
    assert!(left > 0 && right < 0, "{steps}");
    client.go_on();
    client.hear();
    assert_eq!(robot.0.wheels().0, [0, 0]);
    client.end();
    // The client has gone, and the next one is served.
    thread::sleep(Duration::from_millis(100));
    let program = watched(&address);
    for (names, kind) in [
        (
            &[
                "prox_0", "prox_1", "prox_2", "prox_3", "prox_4", "prox_5", "prox_6", "prox_7",
            ][..],
            "proximity",
        ),
        (&["distance_front"], "distance"),
        (&["ground_left", "ground_centre", "ground_right"], "ground"),
        (&["rotation_x", "rotation_y", "rotation_z"], "rotation"),
        (&["acceleration_x", "acceleration_y", "acceleration_z"], "acceleration"),
        (&["sound_front", "sound_right", "sound_back", "sound_left"], "sound"),
        (&["temperature"], "temperature"),
    ] {
        assert_same(&program, names, &said[kind]);
    }
}
