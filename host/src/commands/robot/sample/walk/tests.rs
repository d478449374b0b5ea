use std::fs;
use std::path::PathBuf;

use oneiro_base::console::Output;
use oneiro_lab::reality::turning::mock::{Hands, Mock};

use super::super::person::Nobody;
use super::*;

pub(super) static GOES_ON: AtomicBool = AtomicBool::new(false);

/// A directory that is removed at the end.
pub(super) struct Scratch(pub(super) PathBuf);

impl Scratch {
    pub(super) fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("oneiro-walk-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub(super) fn files(&self) -> Vec<(String, Vec<u8>)> {
        let mut files: Vec<_> = [self.0.clone(), self.0.join("rows")]
            .iter()
            .flat_map(|directory| fs::read_dir(directory).unwrap())
            .map(|entry| entry.unwrap().path())
            .filter(|path| path.is_file())
            .map(|path| {
                (
                    path.file_name().unwrap().display().to_string(),
                    fs::read(&path).unwrap(),
                )
            })
            .collect();
        files.sort();
        files
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

pub(super) fn quiet() -> Console {
    Console::new(Output {
        json: false,
        quiet: true,
        verbose: false,
    })
}

pub(super) fn plan(classes: &[&str], rows: u32, full_mm_s: Option<f64>) -> Plan {
    Plan {
        objects: classes.iter().copied().filter_map(Object::named).collect(),
        grid: Grid { rows, ..Grid::USUAL },
        turns: 1,
        full_mm_s,
    }
}

/// Puts the mock where it has to be, and notes all questions and messages.
#[derive(Default)]
struct Hand {
    hands: Hands,
    /// Answers to the first questions; all others are answered by Enter.
    answers: Vec<Answer>,
    placed: Vec<String>,
    judged: Vec<(String, bool)>,
    heard: Vec<String>,
    /// After as many places it stops.
    patience: Option<usize>,
}

impl Hand {
    fn answer(&mut self) -> Answer {
        if self.answers.is_empty() {
            Answer::Go
        } else {
            self.answers.remove(0)
        }
    }
}

impl Person for Hand {
    fn place(&mut self, _: &mut dyn Vehicle, place: &Place<'_>, words: &str) -> Result<Answer> {
        if self.patience == Some(self.placed.len()) {
            return Ok(Answer::Quit);
        }
        self.placed.push(words.to_owned());
        let put = match place {
            Place::Before { object, gap, .. } => {
                let class = usize::from(object.class == "round");
                Some((class, ((gap - 5.0) / 2.0) as usize))
            }
            Place::Open(_) => None,
        };
        *self.hands.lock().unwrap() = Some(put);
        Ok(self.answer())
    }

    fn decide(&mut self, _: &mut dyn Vehicle, words: &str, is_useless: bool) -> Result<Answer> {
        self.judged.push((words.to_owned(), is_useless));
        Ok(self.answer())
    }

    fn troubled(&mut self, trouble: Trouble) -> Result {
        self.heard.push(trouble.to_string());
        Ok(())
    }
}

type Sampled = (SensorTables, Option<MotorSamples>);

/// Goes the whole way with a mock, or as far as the hand does.
fn walk(mock: &mut Mock, hand: &mut Hand, plan: &Plan, at: &Scratch) -> Result<Sampled> {
    mock.hands = hand.hands.clone();
    Walk::new(mock, hand, plan, &at.0, &GOES_ON, quiet())?.go()
}

/// Each reading is that of the table within a bearing.
fn assert_like(sampled: &SensorTables, rows: usize) {
    let mock = Mock::new();
    for (table, known) in sampled.classes.iter().zip(&mock.tables.classes) {
        assert_eq!((table.sensors, table.bearings, table.rows), (8, 180, rows as u32));
        for row in 0..rows {
            for bearing in 0..180 {
                let cell = table.cell(row * 180 + bearing);
                let mut near = [179, 0, 1]
                    .map(|aside| known.cell(row * 180 + (bearing + aside) % 180))
                    .into_iter();
                assert!(near.any(|near| near == cell), "{} {row} {bearing}", table.class);
            }
        }
    }
}

#[test]
fn a_person_is_told_where_to_put_the_robot() {
    let scratch = Scratch::new("told");
    let mut hand = Hand::default();
    let plan = plan(&["wall", "round"], 3, Some(82.0));
    let (sensors, motors) = walk(&mut Mock::new(), &mut hand, &plan, &scratch).unwrap();
    assert_like(&sensors, 3);
    let motors = motors.unwrap();
    let [turn, way] = [motors.degrees[20], motors.centimetres[440]];
    // Left -10 and right 10 turn counter-clockwise; 82 mm/s is 0.82 cm in a cycle.
    assert!(
        (f64::from(turn) + 16.4 / 53.0 * 360.0 / std::f64::consts::TAU).abs() < 0.05,
        "{turn}"
    );
    assert!((way - 0.82).abs() < 0.001, "{way}");
    assert_eq!(
        hand.placed[0],
        "row 1 of 27, 27 min left: put the robot's rim 5 mm from the wall, a wall, heading straight at it. Nothing else \
         near it. First it turns three times, to measure its turns; then place it again"
    );
    let words = "put the robot's rim 9 mm from the round, a cylinder of 27.5 mm radius, heading straight at its middle";
    assert!(hand.placed[6].contains(words), "{}", hand.placed[6]);
    assert!(hand.placed[7].contains("motors: put the robot on the floor with 0.5 m free on all sides"));
    assert_eq!((hand.placed.len(), hand.judged.len()), (8, 0));
    for class in ["wall", "round"] {
        assert!(
            fs::read_to_string(scratch.0.join(format!("{class}.svg")))
                .unwrap()
                .contains("Readings of eight")
        );
    }
}

/// Killed after any row, or in the middle of one, it ends in the same files.
#[test]
fn what_was_stopped_ends_in_the_same_files() {
    let plan = plan(&["wall", "round"], 5, None);
    let whole = Scratch::new("whole");
    walk(&mut Mock::new(), &mut Hand::default(), &plan, &whole).unwrap();
    let pieces = Scratch::new("pieces");
    // One of them measures how it turns.
    for piece in 0..10 {
        let mut hand = Hand {
            patience: Some(1),
            ..Hand::default()
        };
        let mut mock = Mock::new();
        if piece == 4 {
            // Gone for good in the middle of a turn.
            mock.failing = |look| look > 100;
            hand.patience = None;
            mock.is_broken = true;
        }
        let code = walk(&mut mock, &mut hand, &plan, &pieces).map_or_else(|failure| failure.code(), |_| 0);
        assert_eq!(code, if piece == 4 { 4 } else { 75 }, "{piece}");
    }
    let (sensors, motors) = walk(&mut Mock::new(), &mut Hand::default(), &plan, &pieces).unwrap();
    assert_like(&sensors, 5);
    assert!(motors.is_none());
    assert_eq!(pieces.files(), whole.files());
}

#[test]
fn a_person_goes_back_and_repeats() {
    let scratch = Scratch::new("back");
    let mut hand = Hand {
        answers: vec![Answer::Go, Answer::Go, Answer::Go, Answer::Back, Answer::Go],
        ..Hand::default()
    };
    walk(&mut Mock::new(), &mut hand, &plan(&["wall"], 3, None), &scratch).unwrap();
    let rows: Vec<&str> = hand
        .placed
        .iter()
        .map(|words| words.split(' ').nth(1).unwrap())
        .collect();
    assert_eq!(rows, ["1", "1", "2", "3", "2", "3"]);
    // Nothing is left: there is no one to place it.
    let mut hand = Hand::default();
    walk(&mut Mock::new(), &mut hand, &plan(&["wall"], 3, None), &scratch).unwrap();
    assert!(hand.placed.is_empty());
}

#[test]
fn bad_rows_are_offered_for_repetition() {
    let scratch = Scratch::new("bad");
    let mut mock = Mock {
        slippery: [0.5, 0.505],
        ..Mock::new()
    };
    let measured = Turning {
        wheel_mm_s: 8.2,
        apparent: 1.0,
    };
    Notebook::open(&scratch.0, "").unwrap();
    fs::remove_file(scratch.0.join("rows/robot.txt")).unwrap();
    fs::write(
        scratch.0.join("rows/turning.json"),
        serde_json::to_vec(&measured).unwrap(),
    )
    .unwrap();
    let mut hand = Hand {
        answers: vec![Answer::Go, Answer::Again, Answer::Go, Answer::Quit],
        ..Hand::default()
    };
    let plan = plan(&["wall"], 2, None);
    assert_eq!(walk(&mut mock, &mut hand, &plan, &scratch).unwrap_err().code(), 75);
    assert_eq!((hand.placed.len(), hand.judged.len()), (2, 2));
    let (words, is_useless) = &hand.judged[0];
    assert!(
        words.contains("wall-00: a whole turn was 7 degrees off; allowed: 4") && *is_useless,
        "{words}"
    );
    assert!(!scratch.0.join("rows/wall-00.json").exists());

    // Unattended, three such rows are the end.
    let mut nobody = Nobody::new(quiet());
    let failure = Walk::new(&mut mock, &mut nobody, &plan, &scratch.0, &GOES_ON, quiet())
        .unwrap()
        .go()
        .unwrap_err();
    assert_eq!(failure.code(), 4);
    assert!(
        failure.to_string().contains("degrees off; allowed: 4, three times"),
        "{failure}"
    );
}

#[test]
fn saturated_dead_and_noisy_rows_are_doubted() {
    let names: Vec<String> = ["one", "two"].map(String::from).into();
    let of = |overlap, row: Vec<Vec<u16>>, is_near| -> Vec<String> {
        doubts(overlap, &row, &names, is_near)
            .into_iter()
            .map(|(words, _)| words)
            .collect()
    };
    let good = Overlap::Late {
        drift: 1.0 / 360.0,
        difference: 20.0,
    };
    let row = |one, two| vec![vec![one, two]; 180];
    assert!(of(good, row(3, 1022), true).is_empty());
    assert_eq!(
        of(good, row(3, 1023), true),
        ["the maximum reading at more than half of the bearings: two"]
    );
    assert_eq!(of(Overlap::Blank, row(0, 0), true), ["all readings are 0"]);
    assert!(of(Overlap::Blank, row(0, 0), false).is_empty());
    let noisy = Overlap::Late {
        drift: 0.0,
        difference: 80.4,
    };
    assert!(of(noisy, row(1, 1), true)[0].contains("differ by 80 on average; allowed: 60 of 1023"));
    assert!(of(Overlap::Unlike, row(1, 1), true)[0].contains("it has not turned exactly once, or something has moved"));
}

#[test]
fn troubles_in_a_row_are_told_and_it_is_taken_again() {
    let scratch = Scratch::new("troubles");
    let mut mock = Mock {
        failing: |look| matches!(look, 30 | 2000 | 3500),
        ..Mock::new()
    };
    let mut hand = Hand::default();
    let (sensors, _) = walk(&mut mock, &mut hand, &plan(&["wall"], 4, None), &scratch).unwrap();
    assert_like(&sensors, 4);
    assert_eq!((hand.heard.len(), hand.placed.len()), (3, 8));
    assert!(hand.heard[0].contains("the sensors can't be read: no answer"));
    // Unattended, it gives up after three in one row.
    let mut mock = Mock {
        failing: |look| look % 50 == 0,
        ..Mock::new()
    };
    let scratch = Scratch::new("given-up");
    let mut nobody = Nobody::new(quiet());
    let plan = plan(&["wall"], 4, None);
    let failure = Walk::new(&mut mock, &mut nobody, &plan, &scratch.0, &GOES_ON, quiet())
        .unwrap()
        .go()
        .unwrap_err();
    assert_eq!(failure.code(), 4);
}

#[test]
fn rows_of_others_are_not_mixed() {
    let scratch = Scratch::new("others");
    let go = |plan: &Plan, robot: &str| {
        let mut mock = Mock::new();
        mock.profile.robot = robot.into();
        walk(&mut mock, &mut Hand::default(), plan, &scratch)
            .map_or_else(|failure| failure.to_string(), |_| String::new())
    };
    let mut first = plan(&["round"], 1, None);
    assert_eq!(go(&first, "mock"), "");
    assert!(go(&first, "another").contains("holds samples of another robot, mock 1, 1 turns"));
    first.objects[0].shape = Shape::Round { radius: 33.0 };
    assert!(go(&first, "mock").contains("has rows of `round` as Round { radius: 27.5 }, 1 rows from 5 mm"));
    // Other objects may follow.
    assert_eq!(go(&plan(&["round", "wall"], 1, None), "mock"), "");
    assert!(go(&plan(&["round"], 2, None), "mock").contains("1 rows from 5 mm in steps of 2 mm; allowed: the same"));
}

#[test]
fn bars_show_readings_by_bearing() {
    let names: Vec<String> = ["a", "long"].map(String::from).into();
    let mut row = vec![vec![0, 0]; 180];
    (row[1][0], row[179][1], row[90][0]) = (1023, 1, 512);
    let text = lines(&names, &row);
    let [first, second] = text.lines().collect::<Vec<_>>()[..] else {
        panic!("{text}")
    };
    assert!(first.starts_with("   a |█ ") && first.chars().count() == 67, "{first}");
    assert_eq!(first.chars().nth(6 + 30), Some('▅'));
    assert!(second.starts_with("long |  ") && second.ends_with("▁|"), "{second}");
}
