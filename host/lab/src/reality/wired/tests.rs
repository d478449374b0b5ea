//! Episodes on a vehicle with a virtual clock.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use oneiro::arena::Arena;
use oneiro::random::Key;
use oneiro_base::console::Output;
use oneiro_base::exit::Code;

use super::*;

/// What goes wrong, and at which look.
pub(super) type Troubles = BTreeMap<u32, Trouble>;

/// A robot with given readings whose wheels take any speed at once, on a clock that only its calls advance.
pub(super) struct Mock {
    pub(super) profile: Profile,
    now: Duration,
    /// Speeds, and travel until `now`, mm/s and mm.
    speeds: [f64; 2],
    travel: [f64; 2],
    /// Readings of each look, in turn.
    readings: Vec<[u16; 8]>,
    pub(super) looks: u32,
    /// Duration of looks that take time.
    slow: BTreeMap<u32, Duration>,
    pub(super) troubles: Troubles,
    /// Called at each look.
    pub(super) meanwhile: Box<dyn FnMut(u32) + Send>,
    /// The trouble of the next stop, if it fails.
    stop: Option<Trouble>,
    pub(super) recovered: u32,
    /// All commanded speeds other than 0.
    commands: Vec<[f64; 2]>,
}

impl Mock {
    pub(super) fn new(readings: Vec<[u16; 8]>) -> Self {
        Self {
            profile: senses::tests::khepera(),
            now: Duration::from_secs(1000),
            speeds: [0.0; 2],
            travel: [500.0, -500.0],
            readings,
            looks: 0,
            slow: BTreeMap::new(),
            troubles: Troubles::new(),
            meanwhile: Box::new(|_| {}),
            stop: None,
            recovered: 0,
            commands: Vec::new(),
        }
    }

    fn pass(&mut self, time: Duration) {
        self.now += time;
        for (travel, speed) in self.travel.iter_mut().zip(self.speeds) {
            *travel += speed * time.as_secs_f64();
        }
    }
}

impl Vehicle for Mock {
    fn profile(&self) -> &Profile {
        &self.profile
    }

    fn now(&self) -> Duration {
        self.now
    }

    fn look(&mut self) -> std::result::Result<Moment, Trouble> {
        let look = self.looks;
        self.looks += 1;
        (self.meanwhile)(look);
        if let Some(trouble) = self.troubles.remove(&look) {
            self.speeds = [0.0; 2];
            return Err(trouble);
        }
        self.pass(self.slow.get(&look).copied().unwrap_or_default());
        let readings = self.readings[look as usize % self.readings.len()];
        Ok(Moment {
            at: self.now,
            age: Duration::from_millis(20),
            readings: readings.map(f64::from).into(),
            travel: Some(self.travel),
        })
    }

    fn drive(&mut self, speeds: [f64; 2]) -> std::result::Result<(), Trouble> {
        if speeds != [0.0; 2] {
            self.commands.push(speeds);
        }
        self.speeds = speeds;
        Ok(())
    }

    fn keep_until(&mut self, until: Duration) -> std::result::Result<(), Trouble> {
        self.pass(until.saturating_sub(self.now));
        Ok(())
    }

    fn stop(&mut self) -> std::result::Result<(), Trouble> {
        self.speeds = [0.0; 2];
        self.stop.take().map_or(Ok(()), Err)
    }

    fn recover(&mut self) -> std::result::Result<(), Trouble> {
        self.recovered += 1;
        Ok(())
    }
}

/// A directory that is removed at the end.
pub(super) struct Place(pub(super) PathBuf);

impl Place {
    pub(super) fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("oneiro-wired-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        Self(path)
    }

    pub(super) fn text(&self, name: &str) -> String {
        fs::read_to_string(self.0.join(name)).unwrap()
    }

    /// A column of a table.
    pub(super) fn column(&self, name: &str, column: &str) -> Vec<String> {
        let text = self.text(name);
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let at = reader.headers().unwrap().iter().position(|own| own == column).unwrap();
        reader.records().map(|row| row.unwrap()[at].to_owned()).collect()
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// A wide field, in which short episodes touch nothing.
pub(super) fn spec(cycles: u32) -> WorldSpec {
    WorldSpec {
        arena: Arena::rectangle(1500.0, 1500.0),
        cycles,
        ..WorldSpec::miglino1995()
    }
}

pub(super) fn opened(spec: &WorldSpec, directory: &Path, walk: u32) -> Lives {
    let values = Values {
        starts: Starts::Walk,
        walk,
        speed_mm_s: None,
        sensors: Vec::new(),
        directory: directory.into(),
        trackers: Vec::new(),
    };
    let quiet = Console::new(Output {
        json: false,
        quiet: true,
        verbose: false,
    });
    Lives::new(spec, &Mock::new(Vec::new()), &values, quiet, "tcp:robot:1", None).unwrap()
}

impl Lives {
    /// Runs episodes on one robot.
    pub(super) fn live(
        &mut self,
        vehicle: &mut (impl Vehicle + Send),
        lives: &[Life<'_>],
        traced: bool,
    ) -> std::result::Result<Vec<Lived>, Trouble> {
        let taker = Taker {
            vehicle,
            lives: self,
            standing: &mut Standing::default(),
        };
        shared(vec![taker], lives, traced, &|_, _| {})
    }
}

pub(super) fn genes(life: u32) -> Vec<f32> {
    (0..18)
        .map(|gene| ((life * 31 + gene * 17) % 41) as f32 * 0.25 - 5.0)
        .collect()
}

pub(super) fn life(genes: &[f32], number: u64) -> Life<'_> {
    Life {
        genes,
        key: Key::rollout(7, 0, number, 0),
        start: None,
    }
}

/// A simulated episode: the readings of each cycle as integers, its trace, and its fitness.
fn simulated(spec: &WorldSpec, life: &Life<'_>) -> (Vec<[u16; 8]>, Trace, f32) {
    let world = World::new(spec.clone()).unwrap();
    let rollout = Rollout {
        world: 0,
        genes: life.genes,
        key: life.key,
    };
    let batch = Batch::new(&[world], &[rollout], Some(TraceRequest { every: 1 })).unwrap();
    let outcome = Cpu::new(Some(1)).unwrap().evaluate(&batch, &Control::new()).unwrap();
    let trace = outcome.traces[0].clone();
    let integers = |record| {
        trace
            .activations(record)
            .map(|activation| (activation * 1023.0).round() as u16)
    };
    ((0..trace.len()).map(integers).collect(), trace, outcome.fitness[0])
}

/// Given the readings of a simulated robot, a robot gets the same commands and bit-identical fitness, also when computed again
/// from the record only.
#[test]
fn the_simulators_readings_give_its_commands_and_its_fitness() {
    let spec = spec(60);
    let place = Place::new("same");
    let mut compared = 0;
    for number in 0..16 {
        let genes = genes(number);
        let life = life(&genes, number.into());
        let (readings, trace, fitness) = simulated(&spec, &life);
        // A real robot does not notice a simulated collision.
        if trace.iter().any(|record| record.collided > 0.0) {
            continue;
        }
        compared += 1;
        let mut mock = Mock::new(readings);
        let lived = opened(&spec, &place.0, 0).live(&mut mock, &[life], true).unwrap();
        assert_eq!(lived[0].fitness.to_bits(), fitness.to_bits());
        let commands: Vec<[f64; 2]> = trace
            .iter()
            .map(|record| [record.speed_left, record.speed_right].map(|share| 80.0 * f64::from(share)))
            .filter(|speeds| *speeds != [0.0; 2])
            .collect();
        assert_eq!(mock.commands, commands);
        // The trace's last record has the pose at the end of the episode.
        assert_eq!(lived[0].trace.len(), 61);
        assert_eq!(lived[0].trace[59].fitness.to_bits(), fitness.to_bits());
        let mut nobody = Mock::new(Vec::new());
        let again = opened(&spec, &place.0, 0).live(&mut nobody, &[life], true).unwrap();
        assert_eq!(again[0].fitness.to_bits(), fitness.to_bits());
        assert_eq!(again[0].trace, lived[0].trace);
        assert_eq!((nobody.looks, nobody.commands.len()), (0, 0));
    }
    assert!(compared >= 6, "{compared} lives without a collision");
    assert_eq!(place.column("lives.csv", "status"), vec!["complete"; compared]);
}

/// Ticks are 100 ms apart. A late tick shortens its cycle, and a missed tick is not made up for.
#[test]
fn late_ticks_are_counted_and_do_not_add_up() {
    let place = Place::new("late");
    let mut mock = Mock::new(vec![[0; 8]]);
    // The first look is before the clock of the episode.
    for (look, ms) in [(0, 70), (3, 30), (6, 250)] {
        mock.slow.insert(look, Duration::from_millis(ms));
    }
    let genes = [2.0; 18];
    opened(&spec(10), &place.0, 0)
        .live(&mut mock, &[life(&genes, 0)], false)
        .unwrap();
    let late = ["0", "0", "0", "30", "0", "0", "250", "0", "0", "0"];
    assert_eq!(place.column("life-1.csv", "late_ms"), late);
    let times = ["0", "0.1", "0.2", "0.33", "0.4", "0.5", "0.85", "0.95", "1.05", "1.15"];
    assert_eq!(place.column("life-1.csv", "time_s"), times);
    assert_eq!(place.column("life-1.csv", "age_ms"), ["20"; 10]);
    let index = ["late_min_ms", "late_median_ms", "late_99_ms", "late_max_ms"];
    let index = index.map(|name| place.column("lives.csv", name)[0].clone());
    assert_eq!(index, ["0", "0", "250", "250"]);
}

/// Troubles that a person ends, any number of them: the episode is marked and repeated. Missing readings are tolerated twice in a
/// row.
#[test]
fn a_life_that_is_cut_short_is_lived_again() {
    let place = Place::new("cut");
    let genes = genes(3);
    let life = life(&genes, 1);
    let alone = Place::new("alone");
    let fitness = opened(&spec(8), &alone.0, 0)
        .live(&mut Mock::new(vec![[40; 8]]), &[life], false)
        .unwrap()[0]
        .fitness;
    let mut mock = Mock::new(vec![[40; 8]]);
    mock.troubles = Troubles::from([
        (0, Trouble::Displaced("it was lifted".into())),
        (5, Trouble::Discharged("3.3 V".into())),
        (10, Trouble::Halted("it has restarted".into())),
        (13, Trouble::Runaway("no answer".into())),
        (20, Trouble::Unreadable("late".into())),
    ]);
    let mut lives = opened(&spec(8), &place.0, 0);
    let lived = lives.live(&mut mock, &[life], false).unwrap();
    assert_eq!(lived[0].fitness.to_bits(), fitness.to_bits());
    assert_eq!((mock.recovered, mock.speeds), (5, [0.0; 2]));
    let status = place.column("lives.csv", "status");
    assert_eq!(
        status[..2],
        [
            "the robot has to be put back: it was lifted",
            "the robot has to be charged: 3.3 V"
        ]
    );
    assert_eq!((status.len(), &*status[5]), (6, "complete"));
    assert_eq!(place.column("lives.csv", "cycles"), ["0", "3", "3", "1", "5", "8"]);
    assert_eq!(place.column("life-2.csv", "cycle"), ["0", "1", "2"]);
    // Troubles that persist or stop the run are returned to the caller.
    let other = Life {
        key: Key::of_words([1, 2]),
        ..life
    };
    mock.troubles = (mock.looks..mock.looks + 3)
        .map(|look| (look, Trouble::Unreadable("late".into())))
        .collect();
    let trouble = lives.live(&mut mock, &[other], false).unwrap_err();
    assert!(matches!(trouble, Trouble::Unreadable(_)) && mock.recovered == 7);
    mock.troubles = Troubles::from([(mock.looks + 4, Trouble::Stopped)]);
    assert!(matches!(lives.live(&mut mock, &[other], false), Err(Trouble::Stopped)));
    assert_eq!((mock.recovered, mock.speeds), (7, [0.0; 2]));
    assert_eq!(place.column("lives.csv", "status")[9], "stopped");
}

/// An episode is complete even if the robot does not stop after it.
#[test]
fn a_complete_life_counts_also_if_the_stop_after_it_fails() {
    let place = Place::new("after");
    let genes = genes(2);
    let mut mock = Mock::new(vec![[0; 8]]);
    mock.stop = Some(Trouble::Runaway("no answer".into()));
    let mut lives = opened(&spec(5), &place.0, 0);
    lives.live(&mut mock, &[life(&genes, 0)], false).unwrap();
    assert_eq!((mock.recovered, mock.looks), (1, 6));
    assert_eq!(place.column("lives.csv", "status"), ["complete"]);
}

/// The program is killed at any time: within an episode, and between the index and its table.
#[test]
fn what_was_under_way_when_the_program_ended_is_cut_short() {
    let place = Place::new("killed");
    let genes = genes(1);
    let all = [life(&genes, 0), life(&genes, 1)];
    let mut mock = Mock::new(vec![[7; 8]]);
    let mut lives = opened(&spec(5), &place.0, 0);
    let first = lives.live(&mut mock, &all[..1], false).unwrap()[0].fitness;
    // As if this process had ended.
    let identity = Identity::new(all[1].key, &genes, &lives.world);
    let begin = |identity| lock(&lives.logbook).begin(identity, &genes, [0.0; 3], "tcp:robot:1");
    begin(identity.clone()).unwrap();
    let lines: String = place
        .text("life-1.csv")
        .lines()
        .take(4)
        .map(|line| line.to_owned() + "\n")
        .collect();
    fs::write(place.0.join("life-2.csv"), lines + "3,0.3,0.0").unwrap();
    begin(identity).unwrap();
    fs::remove_file(place.0.join("life-3.csv")).unwrap();
    drop(lives);
    let looks = mock.looks;
    let lived = opened(&spec(5), &place.0, 0).live(&mut mock, &all, false).unwrap();
    assert_eq!(lived[0].fitness.to_bits(), first.to_bits());
    assert_eq!(mock.looks, looks + 6);
    let status = place.column("lives.csv", "status");
    assert_eq!(
        status,
        ["complete", "the program ended", "the program ended", "complete"]
    );
    assert_eq!(place.column("lives.csv", "cycles"), ["5", "4", "0", "5"]);
    // Another world, and other genes, make other episodes.
    let other = self::genes(4);
    opened(&spec(6), &place.0, 0).live(&mut mock, &all[..1], false).unwrap();
    opened(&spec(5), &place.0, 0)
        .live(&mut mock, &[life(&other, 0)], false)
        .unwrap();
    assert_eq!(place.column("lives.csv", "status").len(), 6);
}

/// Changes on disk are refused, with their place.
#[test]
fn records_that_are_not_what_was_written_are_refused() {
    let place = Place::new("changed");
    let genes = [2.0; 18];
    let lives = [life(&genes, 0)];
    let mut mock = Mock::new(vec![[7; 8]]);
    opened(&spec(5), &place.0, 0).live(&mut mock, &lives, false).unwrap();
    let [index, table] = ["lives.csv", "life-1.csv"].map(|name| place.text(name));
    let mut refused = || {
        let failure = opened(&spec(5), &place.0, 0)
            .live(&mut mock, &lives, false)
            .unwrap_err();
        let Trouble::Unrecorded(Code::Corrupt, words) = failure else {
            panic!("{failure}");
        };
        words
    };
    let write = |name: &str, text: &str| fs::write(place.0.join(name), text).unwrap();
    let cut = table.trim_end().rsplit_once('\n').unwrap().0;
    write("life-1.csv", &format!("{cut}\n4,0.4,0,20\n"));
    assert!(refused().contains("life-1.csv: has a torn line"));
    write("life-1.csv", cut);
    assert!(refused().contains("has another number of cycles than the index says"));
    write("life-1.csv", &table.replace("left_90", "left"));
    assert!(refused().contains("has other columns"));
    write("life-1.csv", &table);
    let bits = place.column("lives.csv", "bits")[0].clone();
    write("lives.csv", &index.replace(&bits, "3f800000"));
    assert!(refused().contains("episode 1: its table gives the fitness"));
    write("lives.csv", &index.replace(&bits, "bits"));
    let values = Values {
        starts: Starts::Walk,
        walk: 0,
        speed_mm_s: None,
        sensors: Vec::new(),
        directory: place.0.clone(),
        trackers: Vec::new(),
    };
    let console = Console::new(Output::default());
    let failure = Lives::new(&spec(5), &Mock::new(Vec::new()), &values, console, "", None).unwrap_err();
    assert_eq!(failure.code(), 5);
    assert!(
        failure.to_string().contains("lives.csv: line 2 isn't what was written"),
        "{failure}"
    );
}

/// A robot drives about for the given time, stops, and starts its episode there, unless the episode has a given start.
#[test]
fn lives_start_where_the_driving_about_has_ended() {
    let place = Place::new("walk");
    let genes = vec![0.0; 18];
    let mut mock = Mock::new(vec![[0; 8]]);
    let mut lives = opened(&spec(3), &place.0, 20);
    let begin = mock.now;
    lives
        .live(&mut mock, &[life(&genes, 0), life(&genes, 1)], false)
        .unwrap();
    assert_eq!(mock.now.saturating_sub(begin), Duration::from_millis(2 * (2000 + 300)));
    let starts = ["start_x_mm", "start_y_mm"].map(|name| place.column("lives.csv", name));
    assert_ne!(starts[0][0], starts[0][1]);
    assert!(starts.iter().all(|start| start[0] != "750"));
    // An episode from the robot's position starts at once; from another one, a person would have to place the robot.
    let here = lives.pose.map(|number| number as f32);
    let begin = mock.now;
    let at = |start, number| Life {
        start: Some(start),
        ..life(&genes, number)
    };
    lives.live(&mut mock, &[at(here, 2)], false).unwrap();
    assert_eq!(mock.now.saturating_sub(begin), Duration::from_millis(300));
    let trouble = lives
        .live(&mut mock, &[at([100.0, 200.0, 0.25], 3)], false)
        .unwrap_err();
    let words = "put the robot at x = 100 mm and y = 200 mm, 90 degrees counter-clockwise from the x axis";
    assert!(trouble.to_string().contains(words), "{trouble}");
}

/// The wheels' travel for arcs computed by hand: a quarter to the left, straight on, a turn on the spot, and back.
#[test]
fn poses_follow_arcs() {
    let quarter = TAU / 4.0;
    let close = |pose: [f64; 3], expected: [f64; 3]| {
        for (own, expected) in pose.into_iter().zip(expected) {
            assert!((own - expected).abs() < 1e-9, "{pose:?}");
        }
    };
    // About a centre 100 mm to the left.
    let way = [100.0 - 26.5, 100.0 + 26.5].map(|radius| radius * quarter);
    let pose = moved([10.0, 20.0, 0.0], way, 53.0);
    close(pose, [110.0, 120.0, 0.25]);
    let pose = moved(pose, [30.0, 30.0], 53.0);
    close(pose, [110.0, 150.0, 0.25]);
    let turn = 26.5 * TAU * 0.75;
    close(moved(pose, [-turn, turn], 53.0), [110.0, 150.0, 0.0]);
    close(
        moved(moved([5.0, 5.0, 0.9], [70.0, 20.0], 53.0), [-70.0, -20.0], 53.0),
        [5.0, 5.0, 0.9],
    );
    // A heading is never a whole turn, also as a float32.
    let [.., heading] = moved([0.0; 3], [1e-12, 0.0], 53.0);
    assert_eq!(heading, 0.0);
}
