//! Several robots that share episodes.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Condvar, Mutex};

use oneiro_base::console::Output;

use super::tests::{Mock, Place, Troubles, genes, life, spec};
use super::*;

/// Time limit for events that must happen, however long they take.
const LONG: Duration = Duration::from_secs(20);
const QUIET: Output = Output {
    json: false,
    quiet: true,
    verbose: false,
};

/// Values of episodes that start where the last one stopped, recorded in a place.
fn values(place: &Place) -> Values {
    Values {
        starts: Starts::Walk,
        walk: 0,
        speed_mm_s: None,
        sensors: Vec::new(),
        directory: place.0.clone(),
        trackers: Vec::new(),
    }
}

/// Robots that share a record, and episodes of five cycles there.
fn robots<const N: usize>(place: &Place, mocks: [Mock; N]) -> WiredRobots {
    let values = values(place);
    let mut robots = WiredRobots::default();
    for (number, mock) in mocks.into_iter().enumerate() {
        let address = format!("tcp:robot:{number}");
        let added = robots.add(&Shared::of(mock), &address, &spec(5), &values, Console::new(QUIET));
        added.unwrap();
    }
    robots.label();
    robots
}

fn robot() -> Mock {
    Mock::new(vec![[40; 8]])
}

/// A robot that sends when its first episode has begun, and continues it when it receives.
fn held(until: Receiver<()>, begun: Sender<()>) -> Mock {
    let mut mock = robot();
    let mut is_first = true;
    mock.meanwhile = Box::new(move |look| {
        if look == 0 && std::mem::take(&mut is_first) {
            // The receiver may have gone.
            let _ = begun.send(());
            assert_ne!(until.recv_timeout(LONG), Err(RecvTimeoutError::Timeout));
        }
    });
    mock
}

/// An episode of each genome.
fn lives(genomes: &[Vec<f32>]) -> Vec<Life<'_>> {
    genomes
        .iter()
        .zip(0..)
        .map(|(genes, number)| life(genes, number))
        .collect()
}

fn bits(lived: &[Lived]) -> Vec<u32> {
    lived.iter().map(|life| life.fitness.to_bits()).collect()
}

/// The results of episodes on one robot.
fn alone(lives: &[Life<'_>]) -> Vec<u32> {
    // Concurrent tests must not share a record.
    static CALLS: AtomicU32 = AtomicU32::new(0);
    let place = Place::new(&format!("several-alone-{}", CALLS.fetch_add(1, Ordering::Relaxed)));
    bits(&robots(&place, [robot()]).live(lives, false).unwrap())
}

/// Robots that each wait in the middle of their first episode until all others have also reached it.
fn together<const N: usize>() -> [Mock; N] {
    let gate = Arc::new((Mutex::new(0), Condvar::new()));
    [(); N].map(|()| {
        let (mut mock, gate) = (robot(), Arc::clone(&gate));
        mock.meanwhile = Box::new(move |look| {
            if look == 3 {
                let (there, changed) = &*gate;
                let mut there = there.lock().unwrap();
                *there += 1;
                changed.notify_all();
                let (_there, waited) = changed.wait_timeout_while(there, LONG, |there| *there < N).unwrap();
                assert!(!waited.timed_out(), "the others don't come");
            }
        });
        mock
    })
}

/// Three robots run three episodes at once: each waits in the middle of its first episode until the others have also reached it.
#[test]
fn robots_live_at_the_same_time() {
    let place = Place::new("several-at-once");
    let all: Vec<Vec<f32>> = (0..6).map(genes).collect();
    let lives = lives(&all);
    let lived = robots(&place, together::<3>()).live(&lives, false).unwrap();
    assert_eq!(bits(&lived), alone(&lives));
    let mut who = place.column("lives.csv", "robot");
    assert_eq!(who.len(), 6);
    who.sort();
    who.dedup();
    assert_eq!(who, ["tcp:robot:0", "tcp:robot:1", "tcp:robot:2"]);
    assert_eq!(place.column("lives.csv", "status"), ["complete"; 6]);
}

/// Results are in the order of the episodes: the robot that got the first one ends it last.
#[test]
fn the_order_in_which_lives_end_does_not_show() {
    let place = Place::new("several-order");
    let all: Vec<Vec<f32>> = (0..6).map(genes).collect();
    let lives = lives(&all);
    let expected = alone(&lives);
    // They differ, so that swapped results would be noticed.
    assert!((1..6).all(|other| expected[other] != expected[0]), "{expected:?}");
    let (go, until) = mpsc::channel();
    let (begun, other_has_begun) = mpsc::channel();
    let mut robots = robots(&place, [held(until, begun), held(other_has_begun, mpsc::channel().0)]);
    let order = Mutex::new(Vec::new());
    let on_lived = |number: usize, _: &Lived| {
        let mut order = order.lock().unwrap();
        order.push(number);
        if order.len() == 5 {
            go.send(()).unwrap();
        }
    };
    let lived = robots.live_each(&lives, false, &on_lived).unwrap();
    assert_eq!(bits(&lived), expected);
    let order = order.into_inner().unwrap();
    let held = order[5];
    assert!(held < 2 && order[..5].is_sorted(), "{order:?}");
    // The record gives the same results, though it has another order.
    drop(robots);
    let mut nobody = self::robots(&place, [held_for_ever(), held_for_ever()]);
    assert_eq!(bits(&nobody.live(&lives, false).unwrap()), expected);
    assert_eq!(place.column("lives.csv", "status").len(), 6);
}

/// A robot that must not run an episode.
fn held_for_ever() -> Mock {
    let mut mock = robot();
    mock.meanwhile = Box::new(|_| panic!("it has lived"));
    mock
}

/// Whatever stops a robot, another one runs its episode; the stopped robot returns when it can.
#[test]
fn the_life_of_a_robot_that_stops_goes_to_another() {
    let all: Vec<Vec<f32>> = (0..4).map(genes).collect();
    let lives = lives(&all);
    let expected = alone(&lives);
    for trouble in [
        Trouble::Displaced("it was lifted".into()),
        Trouble::Discharged("3.3 V".into()),
        Trouble::Halted("it has restarted".into()),
        Trouble::Runaway("no answer".into()),
        Trouble::Unreadable("late".into()),
        Trouble::Broken("the guard is gone".into()),
    ] {
        let place = Place::new("several-stops");
        let mut stops = robot();
        stops.troubles = Troubles::from([(2, trouble.clone())]);
        // The other robot begins once this one has stopped.
        let (go, until) = mpsc::channel();
        stops.meanwhile = Box::new(move |look| {
            if look == 2 {
                let _ = go.send(());
            }
        });
        let mut robots = robots(&place, [stops, held(until, mpsc::channel().0)]);
        let lived = robots.live(&lives, false).unwrap();
        assert_eq!(bits(&lived), expected, "{trouble}");
        let status = place.column("lives.csv", "status");
        let who = place.column("lives.csv", "robot");
        let of = |which: &str| {
            (0..5)
                .filter(|&row| (status[row] == "complete") == (which == "complete"))
                .collect::<Vec<_>>()
        };
        assert_eq!((of("complete").len(), of("cut").len()), (4, 1), "{status:?}");
        let cut = of("cut")[0];
        assert_eq!((&*who[cut], &*status[cut]), ("tcp:robot:0", &*trouble.to_string()));
        let is_gone = matches!(trouble, Trouble::Broken(_));
        if is_gone {
            assert!(of("complete").iter().all(|&row| who[row] == "tcp:robot:1"), "{who:?}");
        }
        let standings: Vec<Standing> = robots.0.iter().map(|own| own.standing).collect();
        assert_eq!(standings[0] == Standing::Gone, is_gone, "{standings:?}");
        // A robot that has failed for good stays so.
        let more = [life(&all[0], 9), life(&all[1], 9)];
        assert!(robots.live(&more, false).is_ok());
        let who = place.column("lives.csv", "robot");
        assert!(!is_gone || who[5..] == ["tcp:robot:1"; 2], "{who:?}");
    }
}

/// The last robot's failure is the failure of all. A stop by the user, or a failure to record, ends all at once.
#[test]
fn without_a_robot_nothing_goes_on() {
    let all: Vec<Vec<f32>> = (0..4).map(genes).collect();
    let lives = lives(&all);
    let failing = |trouble: Trouble| {
        let mut mock = robot();
        mock.troubles = (2..40).map(|look| (look, trouble.clone())).collect();
        mock
    };
    let broken = || failing(Trouble::Broken("the guard is gone".into()));
    let late = || failing(Trouble::Unreadable("late".into()));
    for mocks in [[broken(), broken()], [late(), late()], [broken(), late()]] {
        let place = Place::new("several-none");
        let mut robots = robots(&place, mocks);
        let trouble = robots.live(&lives, false).unwrap_err();
        assert!(
            matches!(trouble, Trouble::Broken(_) | Trouble::Unreadable(_)),
            "{trouble}"
        );
        let status = place.column("lives.csv", "status");
        assert!(!status.iter().any(|status| status == "complete"), "{status:?}");
        // Three looks in a row without readings are one too many for each.
        assert!((2..=6).contains(&status.len()), "{status:?}");
        assert!(robots.live(&lives, false).is_err());
    }
    let place = Place::new("several-stopped");
    let mut stopped = robot();
    stopped.troubles = Troubles::from([(2, Trouble::Stopped)]);
    let (go, until) = mpsc::channel();
    stopped.meanwhile = Box::new(move |look| {
        if look == 2 {
            let _ = go.send(());
        }
    });
    let mut robots = robots(&place, [stopped, held(until, mpsc::channel().0)]);
    // The other robot may finish a few episodes before it notices that the run has stopped.
    let all: Vec<Vec<f32>> = (0..400).map(genes).collect();
    let trouble = robots.live(&self::lives(&all), false).unwrap_err();
    assert!(matches!(trouble, Trouble::Stopped), "{trouble}");
    let status = place.column("lives.csv", "status");
    assert!(status.iter().any(|status| status == "stopped"), "{status:?}");
    assert!(status.len() < 400, "{status:?}");
}

/// Clones with the same random numbers are one episode, on several robots as on one.
#[test]
fn the_same_life_is_lived_once() {
    let place = Place::new("several-twins");
    let [one, other] = [genes(1), genes(2)];
    let lives = [
        life(&one, 0),
        life(&one, 0),
        life(&other, 0),
        life(&one, 1),
        life(&one, 0),
    ];
    // While one robot runs the first, the other one is free.
    let lived = robots(&place, together::<2>()).live(&lives, false).unwrap();
    assert_eq!(bits(&lived), alone(&lives));
    assert_eq!(place.column("lives.csv", "status"), ["complete"; 3]);
}

/// A generation is selected by episodes on all robots, so these must have the same sensors.
#[test]
fn robots_that_differ_are_refused() {
    let place = Place::new("several-differ");
    let values = values(&place);
    let mut other = robot();
    other.profile.sensors[0].range.1 = 2047.0;
    let mut robots = WiredRobots::default();
    let mut add = |mock, address| robots.add(&Shared::of(mock), address, &spec(5), &values, Console::new(QUIET));
    add(robot(), "tcp:one:1").unwrap();
    let refused = add(other, "tcp:two:1").unwrap_err();
    assert_eq!(refused.code(), 3);
    let words = "the Khepera at tcp:two:1 has other sensors than the robot at tcp:one:1";
    assert!(refused.to_string().contains(words), "{refused}");
}
