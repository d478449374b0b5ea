//! `oneiro watch`: it serves its list of pages to whoever has the token, and changes nothing.

use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::Child;
use std::time::{Duration, Instant};

use oneiro::foraging::Light;
use oneiro::swarm::{Lamp, Swarm};
use oneiro_report::figures::{BEHAVIOURS, ForagersReplay, Teller, live_page, live_script};
use serde_json::{Value, json};

use crate::mutations::mutant;
use crate::place::{Place, wait_for};

const EXPERIMENT: &str = "
    name = \"small\"
    cycles = 40
    [evolution]
    population = 20
    parents = 4
    generations = 30
";

/// A server that ends with the test.
struct Served {
    program: Child,
    port: u16,
    token: String,
    edit: String,
}

impl Served {
    fn start(place: &Place, more: &[&str]) -> Self {
        let mut program = place.start(&[&["--json", "watch", "--port", "0"], more].concat());
        let output = program.stdout.take().unwrap();
        let mut said = serde_json::Deserializer::from_reader(output).into_iter::<Value>();
        let said = said.next().unwrap().unwrap();
        let link = said["url"].as_str().unwrap();
        let value = |name: &str| {
            let after = link.split_once(name).map_or("", |(_, after)| after);
            after.split('&').next().unwrap().to_owned()
        };
        Self {
            port: said["port"].as_u64().unwrap() as u16,
            token: value("?token="),
            edit: value("&edit="),
            program,
        }
    }

    /// What comes back for these bytes: the status, the head and the body.
    fn send(&self, bytes: &[u8]) -> (u16, String, Vec<u8>) {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        // A refusal may come before everything is sent.
        let _ = stream.write_all(bytes);
        let _ = stream.shutdown(std::net::Shutdown::Write);
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        let end = answer
            .windows(4)
            .position(|four| four == b"\r\n\r\n")
            .map_or(answer.len(), |end| end + 4);
        let body = answer.split_off(end);
        let head = String::from_utf8(answer).unwrap();
        let status = head.get(9..12).and_then(|status| status.parse().ok()).unwrap_or(0);
        (status, head, body)
    }

    /// The head of a request with everything that it needs.
    fn head(&self, method: &str, path: &str, more: &str) -> String {
        let Self { port, token, .. } = self;
        format!("{method} {path} HTTP/1.1\r\nHost: localhost:{port}\r\nCookie: oneiro-{port}={token}\r\n{more}\r\n")
    }

    fn get(&self, path: &str) -> (u16, String) {
        let (status, _, body) = self.send(self.head("GET", path, "").as_bytes());
        (status, String::from_utf8(body).unwrap())
    }

    /// The first event that is as wanted.
    fn event(&self, is_wanted: impl Fn(&Value) -> bool) -> Value {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_mins(1))).unwrap();
        stream.write_all(self.head("GET", "/events", "").as_bytes()).unwrap();
        for line in BufReader::new(stream).lines() {
            let line = line.unwrap();
            let event = line
                .strip_prefix("data: ")
                .map(|data| serde_json::from_str(data).unwrap());
            if let Some(event) = event.filter(&is_wanted) {
                return event;
            }
        }
        panic!("the events have ended");
    }

    /// The id of the one source that is there, when it is as wanted.
    fn id(&self, state: &str) -> String {
        let event = self.event(|event| event["sources"][0]["state"] == state);
        event["sources"][0]["id"].as_str().unwrap().to_owned()
    }

    fn post(&self, path: &str, edit: &str, body: &Value) -> (u16, String) {
        let (port, body) = (self.port, body.to_string());
        let more = format!(
            "Origin: http://localhost:{port}\r\nContent-Type: application/json\r\nX-Oneiro-Edit: {edit}\r\nContent-Length: {}\r\n",
            body.len()
        );
        let (status, _, answer) = self.send((self.head("POST", path, &more) + &body).as_bytes());
        (status, String::from_utf8(answer).unwrap())
    }

    /// Memory of the process, kB.
    #[cfg(target_os = "linux")]
    fn memory(&self) -> u64 {
        let status = fs::read_to_string(format!("/proc/{}/status", self.program.id())).unwrap();
        let line = status.lines().find(|line| line.starts_with("VmRSS:")).unwrap();
        line.split_whitespace().nth(1).unwrap().parse().unwrap()
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

/// All files below a directory with their contents.
fn files(directory: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(directory).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.extend(files(&path));
        } else {
            all.insert(path.display().to_string(), fs::read(&path).unwrap());
        }
    }
    all
}

/// A place with a finished run in `runs/small-1`.
fn with_run(name: &str) -> Place {
    let place = Place::new(name);
    place.write("small.toml", EXPERIMENT);
    place.evolved("small.toml", "1", "runs/small-1", &[]);
    place
}

#[test]
fn a_run_is_the_same_with_a_page_beside_it() {
    let place = with_run("beside");
    let ran = place
        .run(&[
            "run",
            "small.toml",
            "--seed",
            "1",
            "--backend",
            "cpu",
            "--watch",
            "--out",
            "watched",
        ])
        .exits(0);
    assert!(ran.stderr.contains("watch: http://127.0.0.1:"), "{}", ran.stderr);
    assert!(!ran.stdout.contains("http"), "{}", ran.stdout);
    let results = ["generations.csv", "individuals.npy", "champion.json"];
    for file in results {
        let read = |run: &str| place.read(Path::new(run).join(file));
        assert!(read("runs/small-1") == read("watched"), "{file}");
    }
    assert_eq!(
        place.json("runs/small-1", "DONE")["result"],
        place.json("watched", "DONE")["result"]
    );
}

#[test]
fn the_page_has_what_the_run_has_written() {
    let place = with_run("page");
    let before = files(&place.at("runs"));
    let served = Served::start(&place, &[]);
    let id = served.id("done");
    let (status, head, page) = served.send(served.head("GET", "/", "").as_bytes());
    assert_eq!(status, 200);
    assert!(
        head.contains("Content-Security-Policy: default-src 'none'") && head.contains("X-Frame-Options: SAMEORIGIN")
    );
    assert!(String::from_utf8(page).unwrap().contains("watch.js"));
    let (status, curve) = served.get(&format!("/curve/{id}?width=500"));
    assert!(
        status == 200 && curve.starts_with("<svg") && curve.contains("width=\"500\""),
        "{curve}"
    );
    // The newest generation's best, as recorded, with the same bits.
    let (_, scene) = served.get(&format!("/scene/{id}"));
    let scene: Value = serde_json::from_str(&scene).unwrap();
    let table = place.text("runs/small-1/generations.csv");
    let last: Vec<&str> = table.lines().last().unwrap().split(',').collect();
    assert_eq!(scene["generation"], 29);
    assert_eq!(
        scene["fitness"].as_f64().unwrap() as f32,
        last[1].parse::<f32>().unwrap()
    );
    assert_eq!(scene["paths"].as_str().unwrap().matches("<polyline").count(), 20);
    let (_, head, episode) = served.send(served.head("GET", &format!("/episode/{id}/3"), "").as_bytes());
    assert!(head.contains("script-src 'self' 'sha256-"), "{head}");
    assert!(
        String::from_utf8(episode)
            .unwrap()
            .contains("small, seed 1: generation 3")
    );
    let (status, head, body) = served.send(served.head("HEAD", "/", "").as_bytes());
    assert!(status == 200 && body.is_empty() && head.contains("Content-Length: "));
    for (path, wanted) in [
        ("/scene/none", 404),
        ("/edit", 200),
        (&*format!("/scene/{id}?generation=99"), 200),
    ] {
        assert_eq!(served.get(path).0, wanted, "{path}");
    }
    // A run that appears later, and one that can't be read.
    place.write("runs/small-1/other", "no file of the run");
    fs::create_dir(place.at("runs/broken")).unwrap();
    place.write("runs/broken/config.toml", "nothing = 1");
    place.evolved("small.toml", "2", "runs/small-2", &[]);
    let event = served.event(|event| event["sources"].as_array().unwrap().len() == 3);
    let kinds: Vec<_> = event["sources"]
        .as_array()
        .unwrap()
        .iter()
        .map(|source| source["kind"].clone())
        .collect();
    assert!(
        kinds.contains(&json!("unreadable")) && kinds.iter().filter(|kind| **kind == "run").count() == 2,
        "{kinds:?}"
    );
    let after = files(&place.at("runs/small-1"));
    assert!(
        before.iter().all(|(path, bytes)| after.get(path) == Some(bytes)),
        "a file has changed"
    );
    assert_eq!(after.len(), before.len() + 1);
}

/// A directory may be somebody else's. Its pages' scripts run apart from the server's pages; only a fleet's page of this program is an exception.
#[test]
fn scripts_of_directories_are_kept_apart() {
    let place = with_run("foreign");
    place.write(
        "runs/small-1/report.html",
        "<p>report</p><script>stolen = sessionStorage.edit;</script>",
    );
    let foragers = Swarm::odowd2014(2);
    let fleet = ForagersReplay {
        title: "fleet",
        foragers: &foragers,
        lamp: Lamp::fixed(Light::OverNest),
        names: &[1, 2],
        acts: &BEHAVIOURS,
        teller: Teller::Robots,
        lines: &[],
        genes: &[],
    };
    fs::create_dir(place.at("runs/fleet")).unwrap();
    place.write("runs/fleet/live.html", live_page(&fleet, "live.js"));
    place.write("runs/fleet/live.js", live_script(&fleet, 1, None));
    let served = Served::start(&place, &["runs"]);
    let event = served.event(|event| event["sources"].as_array().unwrap().len() == 2);
    let id = |kind: &str| {
        let mut sources = event["sources"].as_array().unwrap().iter();
        sources.find(|source| source["kind"] == kind).unwrap()["id"]
            .as_str()
            .unwrap()
            .to_owned()
    };
    let policy = |path: &str| {
        let (status, head, _) = served.send(served.head("GET", path, "").as_bytes());
        assert_eq!(status, 200, "{path}");
        head.split_once("Content-Security-Policy: ")
            .unwrap()
            .1
            .lines()
            .next()
            .unwrap()
            .to_owned()
    };
    assert!(policy(&format!("/file/{}/report.html", id("run"))).starts_with("sandbox allow-scripts allow-downloads;"));
    let (page, script) = (
        format!("/fleet/{}/live.html", id("fleet")),
        format!("/fleet/{}/live.js", id("fleet")),
    );
    let own = policy(&page);
    assert!(
        own.starts_with("default-src 'none'; script-src 'self' 'sha256-"),
        "{own}"
    );
    assert_eq!(served.get(&script).0, 200);
    // The same page with another script in it, and a script that does more.
    let changed = place
        .text("runs/fleet/live.html")
        .replace("</body>", "<script>alert(1)</script></body>");
    place.write("runs/fleet/live.html", changed);
    assert!(policy(&page).starts_with("sandbox"));
    let more = place.text("runs/fleet/live.js") + "alert(1);\n";
    place.write("runs/fleet/live.js", more);
    assert_eq!(served.get(&script).0, 404);
}

/// Whatever comes, nothing is served but what is on the list, and memory doesn't grow.
#[test]
fn hostile_requests_get_nothing() {
    let place = with_run("hostile");
    place.write("secret", "nobody may read this");
    fs::write(place.at("runs/small-1/secret.html"), "nobody may read this").unwrap();
    let served = Served::start(&place, &[]);
    let id = served.id("done");
    for path in [
        format!("/file/{id}/secret.html"),
        format!("/file/{id}/config.toml"),
        format!("/file/{id}/..%2f..%2fsecret"),
        format!("/file/{id}/../../secret"),
        format!("/fleet/{id}/secret"),
        "/../secret".to_owned(),
        "//secret".to_owned(),
        format!("/episode/{id}/4294967296"),
        format!("/episode/{id}/-1"),
    ] {
        let (status, body) = served.get(&path);
        assert!(status == 404 && !body.contains("nobody may"), "{path}: {status}");
    }
    assert_eq!(served.post("/evolve", "", &json!({ "seed": "1", "set": [] })).0, 405);
    let whole = served.head(
        "GET",
        &format!("/scene/{id}?generation=3"),
        "Accept: */*\r\nConnection: keep-alive\r\n",
    );
    let odd = [
        "POST",
        "DELETE",
        "\r\n",
        "\r\n\r\n",
        "%00",
        "../",
        "Host: evil.example",
        "Content-Length: 99999999999",
        "Transfer-Encoding: chunked",
    ];
    let many = if std::env::var_os("ONEIRO_LONG").is_some() {
        100_000
    } else {
        1_500
    };
    let first = served.send(whole.as_bytes());
    assert_eq!(first.0, 200);
    #[cfg(target_os = "linux")]
    let mut memory = 0;
    for seed in 0..many {
        let (status, _, body) = served.send(mutant(&whole, &odd, seed).as_bytes());
        assert!([0, 200, 400, 403, 404, 405].contains(&status), "seed {seed}: {status}");
        assert!(!body.windows(10).any(|piece| piece == b"nobody may"), "seed {seed}");
        #[cfg(target_os = "linux")]
        if seed == many / 2 {
            memory = served.memory();
        }
    }
    #[cfg(target_os = "linux")]
    assert!(
        served.memory() < memory + 8_000,
        "{memory} kB, and then {}",
        served.memory()
    );
    // Many connections that say nothing: others are refused for a while, and then served again.
    let silent: Vec<_> = (0..100)
        .map(|_| TcpStream::connect(("127.0.0.1", served.port)).unwrap())
        .collect();
    let begun = Instant::now();
    wait_for(|| served.send(whole.as_bytes()).0 == 200);
    assert!(begun.elapsed() < Duration::from_secs(15));
    drop(silent);
}

#[test]
fn the_page_changes_values_only_with_its_secret() {
    let place = Place::new("edit");
    place.write("small.toml", EXPERIMENT);
    let served = Served::start(&place, &["--edit", "small.toml"]);
    let (_, form) = served.get("/edit");
    let form: Value = serde_json::from_str(&form).unwrap();
    let keys: Vec<_> = form["fields"]
        .as_array()
        .unwrap()
        .iter()
        .map(|field| field["key"].as_str().unwrap())
        .collect();
    assert!(
        keys.contains(&"cycles") && keys.contains(&"evolution.generations") && !keys.contains(&"name"),
        "{keys:?}"
    );
    let wish = json!({ "seed": "7", "set": [["evolution.generations", "5"]] });
    assert_eq!(
        served.post("/evolve", &served.token, &wish).0,
        403,
        "the page's secret is another one"
    );
    assert_eq!(served.post("/evolve", "", &wish).0, 403);
    assert!(!place.at("runs").exists());
    for (key, value, problem) in [
        ("record.checkpoint_every", "1", "no key of the form"),
        ("cycles", "0", "{\"problem\":\"cycles: is 0; allowed: 1 to"),
        ("cycles", "40\n[evil]", "several lines"),
        ("name", "\"other\"", "no key of the form"),
    ] {
        let wish = json!({ "seed": "1", "set": [[key, value]] });
        let (status, answer) = served.post("/evolve", &served.edit, &wish);
        assert!(status == 200 && answer.contains(problem), "{key}: {answer}");
    }
    let (_, answer) = served.post("/evolve", &served.edit, &json!({ "seed": "-1", "set": [] }));
    assert!(
        answer.contains("seed: is -1; allowed: a whole number, 0 to"),
        "{answer}"
    );
    assert!(!place.at("runs").exists());
    assert_eq!(
        served.post("/evolve", &served.edit, &wish),
        (200, r#"{"problem":null}"#.to_owned())
    );
    wait_for(|| place.at("runs/small-7/DONE").exists());
    assert!(place.text("runs/small-7/config.toml").contains("generations = 5"));
    assert_eq!(place.text("small.toml"), EXPERIMENT, "the file stays as it is");
    // A run's values of the form's keys, and only where there is a form. Differences from the oldest run have names.
    place.evolved("small.toml", "8", "runs/other", &["--set", "noise.motor=0.3"]);
    let all = served.event(|event| event["sources"].as_array().unwrap().len() == 2);
    let [newer, older] = [&all["sources"][0], &all["sources"][1]];
    let label = newer["label"].as_str().unwrap();
    assert!(
        label.contains("noise.motor 0.3") && older["label"] == "as first",
        "{all}"
    );
    let path = format!("/values/{}", newer["id"].as_str().unwrap());
    let values: Value = serde_json::from_str(&served.get(&path).1).unwrap();
    assert_eq!([&values["noise.motor"], &values["seed"]], ["0.3", "8"]);
    assert!(
        values.get("name").is_none() && keys.iter().all(|key| values.get(key).is_some()),
        "{values}"
    );
    assert_eq!(Served::start(&place, &[]).get(&path).0, 404);
}

#[test]
fn a_snapshot_is_one_file() {
    let place = with_run("snapshot");
    place.good(&["watch", "--snapshot", "now.html"]);
    let page = place.text("now.html");
    assert!(
        page.contains("<svg") && page.contains("srcdoc=\"<!DOCTYPE"),
        "{}",
        page.len()
    );
    assert!(page.contains("small") && !page.contains("src=\"watch.js\"") && !page.contains("<link"));
}

#[test]
fn a_snapshot_says_how_far_everything_is() {
    let place = Place::new("snapshots");
    let snapshot = |place: &Place| {
        place.good(&["watch", "--snapshot", "now.html"]);
        place.text("now.html")
    };
    let page = snapshot(&place);
    assert!(page.contains("Runs appear here when they begin") && !page.contains("<table"));
    place.write("small.toml", EXPERIMENT);
    place.evolved("small.toml", "1", "runs/small-1", &[]);
    assert!(snapshot(&place).contains("<td>done</td><td>30</td><td>30</td>"));
    // As if its process had been killed at the end: it has a table, but nobody adds to it.
    fs::remove_file(place.at("runs/small-1/DONE")).unwrap();
    assert!(snapshot(&place).contains("<td>interrupted</td><td>30</td><td>30</td>"));
    place.write(
        "sweep.toml",
        "name = \"few\"\nexperiment = \"small.toml\"\nseeds = \"1..2\"\n[grid]\nevolution.population = [20, 40]\n",
    );
    place.good(&["sweep", "run", "sweep.toml", "--out", "sweeps/few"]);
    let page = snapshot(&place);
    assert!(page.contains("<td>done</td><td>4</td><td>4</td>") && page.matches("2 of 2").count() == 2);
}

#[test]
fn what_can_not_be_watched_is_refused() {
    let place = Place::new("refused");
    place.write("file", "");
    let refused = |arguments: &[&str], problem: &str| {
        let ran = place.run(arguments).exits(3);
        assert!(ran.stderr.contains(problem), "{}", ran.stderr);
    };
    refused(&["watch", "file"], "file: is a file; allowed: directories of runs");
    refused(&["watch", "--edit", "none.toml"], "none.toml");
    fs::create_dir_all(place.at("runs/small-1")).unwrap();
    refused(
        &["watch", "smal-1"],
        "smal-1: does not exist; did you mean runs/small-1?",
    );
    let taken = std::net::TcpListener::bind(("127.0.0.1", 0)).unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    refused(&["watch", "--port", &port], "allowed: a free port, or 0");
}
