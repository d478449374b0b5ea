use super::super::aseba::tests::{from, head, named, words};
use super::super::script::{Scripted, Step, hear, say};
use super::*;

const VARIABLES: u16 = 0x9005;

/// Variables of a small Thymio II: names, sizes, and so addresses.
const NAMES: [(&str, u16); 7] = [
    ("_id", 1),
    ("_vbat", 2),
    ("motor.left.target", 1),
    ("motor.right.target", 1),
    ("motor.left.speed", 1),
    ("motor.right.speed", 1),
    ("prox.horizontal", 7),
];

fn to(kind: u16, payload: &[u16]) -> Vec<u8> {
    from(0, kind, &words(payload))
}

fn listed(nodes: &[u16]) -> Vec<Step> {
    let present: Vec<u8> = nodes.iter().flat_map(|id| from(*id, 0x900c, &words(&[5]))).collect();
    vec![hear(to(0xa011, &[5])), say(present)]
}

fn described(id: u16, name: &str, names: &[(&str, u16)]) -> Vec<Step> {
    let variables = names.iter().flat_map(|(name, size)| named(id, *size, name));
    let description = head(id, name, 5, 586, [names.len() as u16, 0, 0]);
    vec![
        hear(to(0xa010, &[id, 5])),
        say(description.into_iter().chain(variables).collect::<Vec<_>>()),
    ]
}

/// Setting the targets at 3 and 4, and reading them back.
fn driven(id: u16, left: i16, right: i16) -> Vec<Step> {
    let (left, right) = (left as u16, right as u16);
    let sent = [to(0xa00c, &[id, 3, left, right]), to(0xa00b, &[id, 3, 2])];
    let held = from(id, VARIABLES, &words(&[3, left, right]));
    vec![hear(sent.concat()), say(held)]
}

/// Programs are ended, whatever the nodes are. The answers may come late.
fn halted(nodes: &[u16]) -> Vec<Step> {
    nodes.iter().map(|id| hear(to(0xa006, &[*id]))).collect()
}

/// The program is ended, and the wheels stop.
fn start(id: u16) -> Vec<Step> {
    let halted = [to(0xa006, &[id]), to(0xa007, &[id])].concat();
    let state = from(id, 0x900a, &words(&[0, 2]));
    [vec![hear(halted), say(state)], driven(id, 0, 0)].concat()
}

/// The dialogue until the robot is ready.
pub(crate) fn opening(id: u16) -> Vec<Step> {
    let described = described(id, "thymio-II", &NAMES);
    [listed(&[id]), halted(&[id]), described, start(id)].concat()
}

fn connect(steps: Vec<Step>, node: Option<u16>) -> Result<Thymio> {
    Thymio::connect(Box::new(Scripted::new(steps)), node)
}

fn robot(steps: Vec<Step>) -> Thymio {
    connect([opening(1), steps].concat(), None).unwrap()
}

#[test]
fn it_senses_and_drives() {
    let proximity = [0, 1000, 4500, 0, 0, 7, 8];
    let values = [&[5, 100, (-100_i16) as u16], &proximity[..]].concat();
    let battery = [
        hear(to(0xa00b, &[1, 1, 2])),
        say(from(1, VARIABLES, &words(&[1, 676, 676]))),
    ];
    let steps = [
        vec![hear(to(0xa00b, &[1, 5, 9])), say(from(1, VARIABLES, &words(&values)))],
        driven(1, 600, -600),
        driven(1, 301, 0),
        battery.to_vec(),
    ];
    let mut robot = robot(steps.concat());
    assert_eq!(robot.description().robot, "Thymio II");
    assert_eq!(robot.description().firmware, "thymio-II, node 1, protocol 5");
    let reading = robot.sense(&[Kind::Proximity, Kind::WheelSpeed]).unwrap();
    assert_eq!(reading.values, [0., 1000., 4500., 0., 0., 7., 8., 100., -100.]);
    robot.drive(9999, -9999).unwrap();
    robot.drive_mm_s(100.0, 0.1).unwrap();
    let battery = robot.battery().unwrap();
    assert!(battery.low && (battery.volts.unwrap() - 3.3987).abs() < 1e-3);
    // It has no such variable, so it has no such sensor.
    assert!(
        matches!(robot.sense(&[Kind::Ground]), Err(Error::Unsupported { allowed, .. })
        if allowed == "proximity, wheel_speed")
    );
    assert!(matches!(robot.odometry(), Err(Error::Unsupported { .. })));
    assert!(matches!(robot.light(0, true), Err(Error::Unsupported { allowed, .. }) if allowed == "none"));
}

/// Only if both sensors of the ground see nothing: one alone is at an edge.
#[test]
fn it_is_lifted_where_there_is_no_ground() {
    let names = [&NAMES[..], &[("prox.ground.delta", 2)]].concat();
    let asked = |left: u16, right: u16| {
        let ground = from(1, VARIABLES, &words(&[14, left, right]));
        vec![hear(to(0xa00b, &[1, 14, 2])), say(ground)]
    };
    let steps = [
        [listed(&[1]), halted(&[1]), described(1, "thymio-II", &names), start(1)].concat(),
        asked(130, 20),
        asked(129, 20),
    ];
    let mut robot = connect(steps.concat(), None).unwrap();
    assert_eq!([robot.lifted(), robot.lifted()], [Ok(false), Ok(true)]);
    assert!(matches!(self::robot(vec![]).lifted(), Err(Error::Unsupported { .. })));
}

#[test]
fn the_playground_s_e_puck_is_another_body() {
    let names = [("id", 1), ("x", 2), ("speed.left", 1), ("speed.right", 1), ("prox", 8)];
    let steps = [listed(&[2]), halted(&[2]), described(2, "e-puck0", &names), start(2)];
    let robot = connect(steps.concat(), None).unwrap();
    assert_eq!(robot.description().robot, "e-puck (Aseba)");
    assert_eq!(robot.description().sensors.len(), 1);
}

#[test]
fn of_several_robots_one_has_to_be_named() {
    let described = |id| described(id, "thymio-II", &NAMES);
    let steps = [listed(&[1, 2]), halted(&[1, 2]), described(1), described(2)];
    let words = connect(steps.concat(), None).err().unwrap().to_string();
    assert!(
        words.contains("add one of these to the address: #1 (thymio-II), #2 (thymio-II)"),
        "{words}"
    );
    let steps = [listed(&[1, 2]), halted(&[2]), described(2), start(2)];
    assert!(connect(steps.concat(), Some(2)).is_ok());
    let words = connect(listed(&[1, 2]), Some(3)).err().unwrap().to_string();
    assert!(
        words.contains("no robot has the number 3, but there are node 1, node 2"),
        "{words}"
    );
}

#[test]
fn what_can_not_drive_is_no_robot() {
    let steps = [listed(&[1]), halted(&[1]), described(1, "dummynode", &[("a", 1)])];
    let words = connect(steps.concat(), None).err().unwrap().to_string();
    assert!(
        words.contains("has no known robot, but node 1, \"dummynode\""),
        "{words}"
    );
    let steps = [listed(&[1]), halted(&[1]), described(1, "thymio-II", &NAMES[..3])];
    assert!(matches!(connect(steps.concat(), None), Err(Error::Unknown { .. })));
}

#[test]
fn targets_that_stay_are_no_stop() {
    let [sent, _] = &driven(1, 0, 0)[..] else {
        unreachable!()
    };
    let held = say(from(1, VARIABLES, &words(&[3, 0, 200])));
    let mut robot = robot(vec![[sent.clone(), held]; 4].concat());
    assert!(matches!(robot.stop(), Err(Error::StillTurning { seen }) if seen.ends_with("are [0, 200]")));
}

/// A stop whose answer nobody waits for.
fn stopped_blindly() -> Step {
    hear(to(0xa00c, &[1, 3, 0, 0]))
}

/// Out of step, and the link babbles on: the robot may hear of the stop all the same.
#[test]
fn a_stop_is_sent_before_order_is_restored() {
    let steps = [vec![stopped_blindly()], (0..90).map(|_| say([0xff; 8])).collect()];
    let mut robot = robot(steps.concat());
    *robot.network.in_step() = false;
    assert!(matches!(robot.stop(), Err(Error::Garbage { .. })));
    robot.network.resynchronise().unwrap();
}

/// Messages of a Thymio that has the event `buttons`, the second of three.
fn with_events() -> Vec<Step> {
    let variables = NAMES.iter().flat_map(|(name, size)| named(1, *size, name));
    let event = |name: &str| from(1, 0x9002, &[&[name.len() as u8], name.as_bytes(), &[0]].concat());
    let description = head(1, "thymio-II", 5, 586, [NAMES.len() as u16, 3, 0]);
    let events = ["prox", "buttons", "tap"].map(event).concat();
    let all = description
        .into_iter()
        .chain(variables)
        .chain(events)
        .collect::<Vec<_>>();
    let described = vec![hear(to(0xa010, &[1, 5])), say(all)];
    [listed(&[1]), halted(&[1]), described, start(1)].concat()
}

/// The fuse is uploaded, and runs. Behind the variables there are free words from 14 on.
fn loaded() -> Vec<Step> {
    let targets = [3, 4];
    let (_, program) = Fuse::of(&(14..586), targets, &["prox".into(), "buttons".into()]).unwrap();
    let sent = [
        to(0xa001, &[&[1, 0], &program[..]].concat()),
        to(0xa003, &[1]),
        to(0xa007, &[1]),
    ];
    vec![hear(sent.concat()), say(from(1, 0x900a, &words(&[0, 0])))]
}

/// The fuse is lit; the robot holds what was wanted, and its program runs, or not.
fn lit(left: i16, right: i16, flags: u16) -> Vec<Step> {
    let (left, right) = (left as u16, right as u16);
    let sent = [
        to(0xa00c, &[1, 14, left, right, 10]),
        to(0xa00b, &[1, 14, 2]),
        to(0xa007, &[1]),
    ];
    let held = from(1, VARIABLES, &words(&[14, left, right]));
    vec![
        hear(sent.concat()),
        say([held, from(1, 0x900a, &words(&[3, flags]))].concat()),
    ]
}

#[test]
fn a_robot_that_can_stop_by_itself_gets_a_fuse_before_it_moves() {
    let put_out = vec![hear(to(0xa00c, &[1, 14, 0, 0, 0]))];
    let steps = [
        with_events(),
        loaded(),
        lit(100, -100, 0),
        lit(5, 5, 1),
        put_out,
        driven(1, 0, 0),
    ];
    let mut robot = connect(steps.concat(), None).unwrap();
    robot.arm().unwrap();
    robot.drive(100, -100).unwrap();
    robot.drive(5, 5).unwrap();
    robot.stop().unwrap();
}

/// Somebody has stopped the program, or it has failed: it gets another.
#[test]
fn a_fuse_that_does_not_burn_is_a_restart() {
    let failed = from(1, 0x9006, &words(&[3, 1, 2]));
    let mut broken = lit(5, 5, 2);
    broken[1] = say([from(1, VARIABLES, &words(&[14, 5, 5])), failed].concat());
    for broken in [lit(5, 5, 2), broken] {
        let steps = [with_events(), loaded(), broken, start(1), loaded(), lit(6, 6, 0)];
        let mut robot = connect(steps.concat(), None).unwrap();
        robot.arm().unwrap();
        assert_eq!(robot.drive(5, 5), Err(Error::Restarted));
        robot.drive(6, 6).unwrap();
    }
}

#[test]
fn a_lost_link_is_opened_again() {
    let sent = driven(1, 5, 5).remove(0);
    let mut robot = robot([vec![sent, Step::HangUp, Step::Reopen, stopped_blindly()], opening(1)].concat());
    assert!(matches!(robot.drive(5, 5), Err(Error::Disconnected { .. })));
    robot.reconnect().unwrap();
}

#[test]
fn another_kind_of_robot_is_not_taken_for_the_one_before() {
    let names = [("motor.a", 3), ("speed.left", 1), ("speed.right", 1)];
    let steps = [
        vec![Step::Reopen, stopped_blindly()],
        listed(&[1]),
        halted(&[1]),
        described(1, "e-puck0", &names),
        start(1),
    ];
    let words = robot(steps.concat()).reconnect().unwrap_err().to_string();
    assert!(
        words.contains("Thymio II was there, and now e-puck (Aseba) answers"),
        "{words}"
    );
}
