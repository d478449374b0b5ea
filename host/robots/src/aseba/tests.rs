use super::super::script::{Random, Scripted, Step, hear, say, say_after};
use super::*;

/// The bytes of a node's message.
pub(crate) fn from(source: u16, kind: u16, payload: &[u8]) -> Vec<u8> {
    Message {
        source,
        kind,
        payload: payload.into(),
    }
    .frame()
}

/// The words of a payload.
pub(crate) fn words(words: &[u16]) -> Vec<u8> {
    words.iter().copied().flat_map(u16::to_le_bytes).collect()
}

fn text(text: &str) -> Vec<u8> {
    [&[text.len() as u8], text.as_bytes()].concat()
}

/// A description's head.
pub(crate) fn head(id: u16, name: &str, version: u16, size: u16, counts: [u16; 3]) -> Vec<u8> {
    let rest = [&[version, 1534, 32, size], &counts[..]].concat();
    from(id, DESCRIPTION, &[text(name), words(&rest)].concat())
}

/// A variable's description.
pub(crate) fn named(id: u16, size: u16, name: &str) -> Vec<u8> {
    from(id, VARIABLE, &[words(&[size]), text(name)].concat())
}

fn network(steps: impl IntoIterator<Item = Step>) -> Network {
    Network::new(Box::new(Scripted::new(steps)))
}

/// As seen at the simulator: version 5 asks who is there, node 1 answers.
const LIST: [u8; 8] = [2, 0, 0, 0, 0x11, 0xa0, 5, 0];
const PRESENT: [u8; 8] = [2, 0, 1, 0, 0x0c, 0x90, 5, 0];

#[test]
fn nodes_are_listed_as_at_the_simulator() {
    let wireless = from(33_084, NODE_PRESENT, &words(&[9]));
    let mut network = network([hear(LIST), say(PRESENT), say_after(250, wireless), say(PRESENT)]);
    assert_eq!(network.list().unwrap(), [(1, 5), (33_084, 9)]);
}

#[test]
fn a_network_without_nodes_ends_in_time() {
    let mut network = network(vec![hear(LIST); TRIES as usize]);
    let start = network.now();
    assert!(matches!(network.list(), Err(Error::TimedOut { .. })));
    assert!(network.now() < start + Duration::from_secs(2));
}

fn messages(chunks: &[&[u8]]) -> Vec<Message> {
    let mut messages = Messages::default();
    chunks.iter().flat_map(|chunk| messages.push(chunk).unwrap()).collect()
}

#[test]
fn messages_are_the_same_wherever_the_stream_is_cut() {
    let longest = from(7, VARIABLES, &[9; Message::LONGEST]);
    let stream = [
        &PRESENT[..],
        &from(2, 5, &[]),
        &named(1, 7, "prox.horizontal"),
        &longest,
        &PRESENT[..3],
    ]
    .concat();
    let whole = messages(&[&stream]);
    assert_eq!(whole.len(), 4);
    assert_eq!(
        whole[0],
        Message {
            source: 1,
            kind: NODE_PRESENT,
            payload: vec![5, 0]
        }
    );
    assert_eq!(
        whole[1],
        Message {
            source: 2,
            kind: 5,
            payload: vec![]
        }
    );
    assert_eq!(variable(&whole[2]), Some((7, "prox.horizontal".into())));
    for cut in 0..=stream.len() {
        assert_eq!(messages(&[&stream[..cut], &stream[cut..]]), whole, "cut at {cut}");
    }
    assert_eq!(messages(&stream.chunks(1).collect::<Vec<_>>()), whole);
}

#[test]
fn a_length_that_no_message_has_is_refused() {
    assert_eq!(Messages::default().push(&[5, 2, 1, 0, 0, 0]), Err(517));
    assert_eq!(Messages::default().push(&[4, 2, 1, 0, 0, 0]), Ok(vec![]));
}

#[test]
fn random_streams_never_panic_and_memory_is_bounded() {
    let mut random = Random(11);
    let valid = [
        head(1, "thymio-II", 5, 586, [2, 0, 0]),
        named(1, 7, "prox.horizontal"),
        PRESENT.into(),
    ]
    .concat();
    for _ in 0..5000 {
        let mut messages = Messages::default();
        for _ in 0..10 {
            let stream = match random.below(3) {
                0 => random.bytes(600),
                _ => random.mutated(&valid),
            };
            let Ok(complete) = messages.push(&stream) else { break };
            for message in complete {
                drop((Head::read(&message), variable(&message)));
                fill(&message, &[0, 65_535], &mut [None, None]);
            }
            assert!(messages.0.len() < 6 + Message::LONGEST);
        }
    }
}

/// Of a node before version 8, all comes at once.
fn all_of(id: u16) -> Vec<Vec<u8>> {
    vec![
        head(id, "thymio-II", 5, 586, [3, 1, 1]),
        named(id, 1, "_id"),
        named(id, 7, "prox.horizontal"),
        named(id, 2, "prox.ground.delta"),
        from(id, LOCAL_EVENT, &[text("prox"), text("new readings")].concat()),
        from(id, NATIVE_FUNCTION, &[text("leds"), text(""), words(&[0])].concat()),
    ]
}

/// The description of a node, for which there is time.
fn described(network: &mut Network, id: u16, version: u16) -> Result<Node> {
    let end = network.now() + DESCRIBING;
    network.describe(id, version, end)
}

#[test]
fn addresses_are_the_sums_of_sizes() {
    let ask = hear(Message::new(GET_DESCRIPTION, [1, 5]).frame());
    let other = from(2, VARIABLE, &[]);
    let mut network = network([ask, say(other), say(all_of(1).concat())]);
    let node = described(&mut network, 1, 5).unwrap();
    assert_eq!(node.name, "thymio-II");
    assert_eq!(node.variable("prox.horizontal"), Some(1..8));
    assert_eq!(node.variable("prox.ground.delta"), Some(8..10));
    assert_eq!(node.variable("acc"), None);
}

/// A message lost from the middle would shift all addresses after it.
#[test]
fn a_description_with_a_gap_is_asked_for_again() {
    for lost in 0..6 {
        let ask = || hear(Message::new(GET_DESCRIPTION, [1, 5]).frame());
        let mut rest = all_of(1);
        rest.remove(lost);
        let mut network = network([ask(), say(rest.concat()), ask(), say(all_of(1).concat())]);
        let node = described(&mut network, 1, 5).unwrap();
        assert_eq!(node.variable("prox.ground.delta"), Some(8..10), "lost {lost}");
    }
}

#[test]
fn a_node_of_version_8_is_asked_for_one_variable_after_the_other() {
    let ask = |index: i16| hear(Message::new(GET_FRAGMENT, [3, 5, index as u16]).frame());
    let steps = [
        ask(-1),
        say(head(3, "thymio-II", 9, 586, [2, 17, 52])),
        ask(0),
        say(named(3, 1, "_id")),
        // Lost once.
        ask(1),
        ask(1),
        say(named(3, 7, "prox.horizontal")),
    ];
    let node = described(&mut network(steps), 3, 9).unwrap();
    assert_eq!((node.version, node.variable("prox.horizontal")), (9, Some(1..8)));
}

#[test]
fn more_variables_than_room_are_refused() {
    let ask = || hear(Message::new(GET_FRAGMENT, [3, 5, u16::MAX]).frame());
    let variable = hear(Message::new(GET_FRAGMENT, [3, 5, 0]).frame());
    let answer = say(named(3, 11, "x"));
    let mut network = network([ask(), say(head(3, "x", 9, 10, [1, 0, 0])), variable, answer]);
    assert!(matches!(described(&mut network, 3, 9), Err(Error::Garbage { received, .. }) if received.contains("room")));
}

/// No robot has so many.
#[test]
fn more_names_than_any_robot_has_are_refused() {
    for counts in [[1001, 0, 0], [0, u16::MAX, 0], [0, 0, 1001]] {
        // Four attempts.
        let ask = || hear(Message::new(GET_FRAGMENT, [3, 5, u16::MAX]).frame());
        let steps = (0..TRIES).flat_map(|_| [ask(), say(head(3, "x", 9, u16::MAX, counts))]);
        let refusal = described(&mut network(steps), 3, 9).unwrap_err();
        assert!(matches!(refusal, Error::Garbage { .. }), "{refusal}");
    }
}

/// A node may answer in parts, in any order, between other messages.
#[test]
fn values_are_put_together_from_parts() {
    let ask = [(10, 47), (57, 45)].map(|(start, count)| Message::new(GET_VARIABLES, [1, start, count]).frame());
    let part = |start: u16, values: Range<u16>| {
        let values: Vec<u16> = [start].into_iter().chain(values).collect();
        from(1, VARIABLES, &words(&values))
    };
    let steps = [
        hear(ask.concat()),
        say(part(57, 47..92)),
        say(from(1, 3, &words(&[1, 2]))),
        say(from(2, VARIABLES, &words(&[10, 99]))),
        say(part(10, 0..20)),
        say(part(30, 20..47)),
    ];
    let addresses: Vec<u16> = (100..102).chain(10..70).collect();
    let values = network(steps).get(1, &addresses).unwrap();
    assert_eq!(values, [90, 91].into_iter().chain(0..60).collect::<Vec<_>>());
}

#[test]
fn requests_are_few() {
    assert_eq!(spans(&[]), []);
    assert_eq!(spans(&[52, 5, 5, 6, 51]), [5..52, 52..53]);
}

#[test]
fn what_is_set_is_read_back() {
    let sent = [
        Message::new(SET_VARIABLES, [1, 30, 200, (-200_i16) as u16]).frame(),
        Message::new(GET_VARIABLES, [1, 30, 2]).frame(),
    ];
    let held = |left: i16, right: i16| say(from(1, VARIABLES, &words(&[30, left as u16, right as u16])));
    let ask = || hear(sent.concat());
    let values = [(30, 200), (31, -200)];
    // It was lost at first.
    network([ask(), held(0, 0), ask(), held(200, -200)])
        .set(1, &values)
        .unwrap();
    let never = [
        ask(),
        held(0, 0),
        ask(),
        held(0, 0),
        ask(),
        held(0, 0),
        ask(),
        held(0, 0),
    ];
    let error = network(never).set(1, &values).unwrap_err();
    assert!(matches!(error, Error::Refused { answer, .. } if answer == "[0, 0]"));
}

#[test]
fn half_a_message_before_silence_is_forgotten() {
    let ask = || hear(Message::new(GET_VARIABLES, [1, 5, 1]).frame());
    let steps = [ask(), say([4, 0, 1]), ask(), say(from(1, VARIABLES, &words(&[5, 42])))];
    assert_eq!(network(steps).get(1, &[5]), Ok(vec![42]));
    let steps = [ask(), say([0xff; 9]), ask(), say(from(1, VARIABLES, &words(&[5, 42])))];
    assert_eq!(network(steps).get(1, &[5]), Ok(vec![42]));
}

/// Events of a program that never rests must neither keep a request waiting for ever nor spoil it.
#[test]
fn events_do_not_hold_a_request() {
    let ask = || hear(Message::new(GET_VARIABLES, [1, 5, 1]).frame());
    let event = || say(from(1, 0, &[]));
    let events = |count: usize| (0..count).map(|_| event());
    // 300 ms for the answer and 50 ms of silence, except for events.
    let lost = [ask()].into_iter().chain(events(34));
    let answered = [ask(), event(), say(from(1, VARIABLES, &words(&[5, 42])))];
    assert_eq!(network(lost.chain(answered)).get(1, &[5]), Ok(vec![42]));
}

/// What is sent to stop a program, and an answer with its flags.
fn halted(flags: u16) -> [Step; 2] {
    let sent = [STOP, GET_EXECUTION_STATE].map(|kind| Message::new(kind, [1]).frame());
    [hear(sent.concat()), say(from(1, EXECUTION_STATE, &words(&[0, flags])))]
}

/// The dongle loses messages, and a state may be from before the stop.
#[test]
fn a_program_is_stopped_once_its_node_says_so() {
    let [sent, runs] = halted(0);
    let [_, stands] = halted(2);
    let other = say(from(2, EXECUTION_STATE, &words(&[0, 2])));
    let steps = [sent.clone(), other, runs.clone(), sent.clone(), runs.clone(), stands];
    network(steps).halt(1).unwrap();
    for flags in [0, 1, 3] {
        let [sent, runs] = halted(flags);
        let error = network(vec![[sent, runs]; TRIES as usize].concat())
            .halt(1)
            .unwrap_err();
        assert!(matches!(error, Error::TimedOut { command, .. } if command.contains("end of its program")));
    }
    let short = [halted(2)[0].clone(), say(from(1, EXECUTION_STATE, &words(&[2])))];
    assert!(network(vec![short; TRIES as usize].concat()).halt(1).is_err());
}

#[test]
fn nonsense_that_waits_does_not_hold_a_stop() {
    let [sent, stands] = halted(2);
    let link = Scripted::new([say([0xff; 8]), sent, stands]);
    let hand = link.hand();
    let mut network = Network::new(Box::new(link));
    network.in_step = true;
    hand.advance(10);
    network.halt(1).unwrap();
}

/// Where order was not restored, that comes first.
#[test]
fn a_late_answer_does_not_pass_for_the_next() {
    let ask = || hear(Message::new(GET_VARIABLES, [1, 5, 1]).frame());
    let values = |value: u16| from(1, VARIABLES, &words(&[5, value]));
    let babble = (0..85).map(|_| say([0xff; 8]));
    let steps = [ask()]
        .into_iter()
        .chain(babble)
        .chain([say(values(7)), ask(), say(values(42))]);
    let mut network = network(steps);
    network.in_step = true;
    assert!(matches!(network.get(1, &[5]), Err(Error::Garbage { .. })));
    assert_eq!(network.get(1, &[5]), Ok(vec![42]));
}
