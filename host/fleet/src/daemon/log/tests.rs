use std::io::Read;
use std::sync::Mutex;
use std::time::Instant;

use super::*;

struct Place(PathBuf);

impl Place {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("oneiro-log-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn lines(&self, name: &str) -> Vec<Value> {
        let text = fs::read_to_string(self.0.join(name)).unwrap();
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.0).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn at(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

#[test]
fn a_line_has_its_times_and_what_there_is_to_say() {
    let place = Place::new("line");
    let log = Log::open(&place.0, 3, 2, Limits::default());
    log.event(
        at(123_456),
        Some(60_123),
        "heard",
        json!({ "sender": 5, "sequence": 4_294_967_300_u64 }),
    );
    log.event(at(123_500), None, "end", json!({ "stopped": true }));
    drop(log);
    let lines = place.lines(FILE);
    assert_eq!(lines.len(), 2);
    let utc = lines[0]["utc"].as_str().unwrap().to_owned();
    assert_eq!(
        lines[0],
        json!({
            "at_ms": 123_456, "experiment_ms": 60_123, "utc": utc, "robot": 3, "boot": 2, "event": "heard", "sender": 5,
            "sequence": 4_294_967_300_u64,
        })
    );
    assert_eq!(lines[1]["experiment_ms"], Value::Null);
}

/// Of a log that is much longer than allowed, the newest files are kept, each within its limit, and a restart continues them.
#[test]
fn files_are_bounded_in_size_and_number() {
    let place = Place::new("bounds");
    let limits = Limits { bytes: 2000, files: 3 };
    let mut sequence = 0;
    for boot in 0..4 {
        let log = Log::open(&place.0, 0, boot, limits);
        for _ in 0..50 {
            log.event(at(sequence), None, "said", json!({ "sequence": sequence }));
            sequence += 1;
        }
    }
    let names = place.names();
    assert_eq!(names.len(), 3, "{names:?}");
    assert!(names.contains(&FILE.to_owned()), "{names:?}");
    let mut kept = Vec::new();
    for name in &names {
        let size = fs::metadata(place.0.join(name)).unwrap().len();
        assert!(size <= limits.bytes, "{name}: {size}");
        kept.extend(place.lines(name).iter().map(|line| line["sequence"].as_u64().unwrap()));
    }
    // Without a hole, to the last.
    kept.sort_unstable();
    assert_eq!(kept, (sequence - kept.len() as u64..sequence).collect::<Vec<_>>());
    assert!(kept.len() > 30, "{}", kept.len());
}

/// After a power cut in the middle of a line, what follows is whole.
#[test]
fn a_torn_line_damages_no_other() {
    let place = Place::new("torn");
    fs::write(place.0.join(FILE), "{\"at_ms\":1,\"ev").unwrap();
    drop(Log::open(&place.0, 0, 1, Limits::default()));
    let log = Log::open(&place.0, 0, 1, Limits::default());
    log.event(at(5), None, "start", json!({}));
    drop(log);
    let text = fs::read_to_string(place.0.join(FILE)).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next().unwrap(), "{\"at_ms\":1,\"ev");
    assert_eq!(
        serde_json::from_str::<Value>(lines.next().unwrap()).unwrap()["event"],
        "start"
    );
}

/// A journal whose reader hangs, or fails.
struct Stuck(Arc<Mutex<()>>);

impl Write for Stuck {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        drop(self.0.lock().unwrap());
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// While nothing can be written, ten times as many events as the queue holds are logged without waiting, and what is missing is
/// counted in the file.
#[test]
fn nobody_waits_for_a_log_and_what_is_missing_is_counted() {
    let place = Place::new("stuck");
    let gate = Arc::new(Mutex::new(()));
    let held = gate.lock().unwrap();
    let log = Log::with(
        Pages::new(&place.0, Limits::default()),
        Some(Box::new(Stuck(Arc::clone(&gate)))),
        0,
        1,
    );
    let all = 10 * QUEUE as u64;
    // A waiting caller would wait for ever.
    for number in 0..all {
        log.event(at(number), None, "said", json!({ "sequence": number }));
    }
    let lost = log.lost();
    assert!(lost >= all - QUEUE as u64 - 2, "{lost}");
    drop(held);
    drop(log);
    let lines = place.lines(FILE);
    let said = lines.iter().filter(|line| line["event"] == "said").count() as u64;
    let counted: u64 = lines
        .iter()
        .filter(|line| line["event"] == "dropped")
        .map(|line| line["count"].as_u64().unwrap())
        .sum();
    assert_eq!((said + counted, counted), (all, lost));
}

/// A closed standard error is given up; the file continues.
#[test]
fn a_closed_journal_does_not_keep_the_file_from_being_written() {
    let place = Place::new("closed");
    let (mut reader, writer) = io::pipe().unwrap();
    let log = Log::with(Pages::new(&place.0, Limits::default()), Some(Box::new(writer)), 0, 1);
    log.event(at(1), None, "start", json!({}));
    let mut first = [0; 10];
    reader.read_exact(&mut first).unwrap();
    assert_eq!(&first, b"{\"at_ms\":1");
    drop(reader);
    for number in 0..100 {
        log.event(at(number), None, "said", json!({}));
    }
    drop(log);
    assert_eq!(place.lines(FILE).len(), 101);
}

/// An unwritable directory, as on a full disk: nothing fails or waits, lost lines are counted, and when there is room
/// again, a line has their number.
#[test]
fn a_disk_without_room_costs_lines_and_nothing_else() {
    let place = Place::new("full");
    let directory = place.0.join("state");
    let log = Log::open(&directory, 0, 1, Limits::default());
    for number in 0..10 {
        log.event(at(number), None, "said", json!({}));
    }
    let until = Instant::now() + at(5000);
    while log.lost() < 10 && Instant::now() < until {
        thread::sleep(at(2));
    }
    assert_eq!(log.lost(), 10);
    fs::create_dir(&directory).unwrap();
    log.event(at(11), Some(7), "said", json!({}));
    drop(log);
    let lines = place.lines("state/log.jsonl");
    assert_eq!(lines.len(), 2);
    assert_eq!(
        (&lines[0]["event"], &lines[0]["count"]),
        (&json!("dropped"), &json!(10))
    );
    assert_eq!(
        (&lines[0]["at_ms"], &lines[0]["experiment_ms"]),
        (&json!(11), &json!(7))
    );
    assert_eq!(lines[1]["event"], "said");
}
