//! A Khepera, an e-puck and a Thymio II, each on a pseudo-terminal or over TCP.

use std::io::{ErrorKind, Read, Write};
use std::thread;
use std::time::Duration;

use serialport::{SerialPort, TTYPort};

use crate::peers::{Body, Mouth, listen, with_a_processor_of_its_own};

/// How long a robot waits for bytes before it looks at what is wrong with it.
const GLANCE: Duration = Duration::from_millis(5);

/// Serves a robot at the end of a pseudo-terminal. Returns its path.
fn at_a_port(serve: impl FnOnce(TTYPort) + Send + 'static) -> String {
    let (mut port, slave) = TTYPort::pair().unwrap();
    let path = slave.name().unwrap();
    // One at a time can open it; until then, reading fails.
    drop(slave);
    thread::spawn(move || {
        with_a_processor_of_its_own();
        port.set_timeout(GLANCE).unwrap();
        serve(port);
    });
    path
}

/// Serves a robot over TCP. Returns its address.
fn over_tcp(serve: impl Fn(std::net::TcpStream) + Send + 'static) -> String {
    listen(move |stream| {
        with_a_processor_of_its_own();
        stream.set_read_timeout(Some(GLANCE)).unwrap();
        stream.set_write_timeout(Some(GLANCE)).unwrap();
        serve(stream);
    })
}

/// Reads what has come; none if the other end is gone for good. A port without another end has one again.
fn heard(link: &mut impl Read, buffer: &mut [u8]) -> Option<usize> {
    match link.read(buffer) {
        Ok(0) => None,
        Ok(count) => Some(count),
        Err(error) => {
            if !matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock) {
                thread::sleep(GLANCE);
            }
            Some(0)
        }
    }
}

/// Starts a Khepera with turning wheels. It answers each line with a line.
pub(crate) fn khepera(body: &Body) -> String {
    khepera_at(38_400, false, body)
}

/// The same at some baud rate. If it is slow, its lines take the time that they have at this rate, with 11 bits for each byte.
pub(crate) fn khepera_at(baud: u32, is_slow: bool, body: &Body) -> String {
    body.set([5, -5]);
    let body = body.clone();
    let rate = is_slow.then_some(baud);
    format!(
        "serial:{}@{baud}",
        at_a_port(move |port| lines(&body, port, rate, answer))
    )
}

/// The same behind a server that forwards its line.
pub(crate) fn khepera_over_tcp(body: &Body) -> String {
    body.set([5, -5]);
    let body = body.clone();
    over_tcp(move |stream| lines(&body, stream, None, answer))
}

/// Starts an e-puck with turning wheels, whose firmware understands text alone.
pub(crate) fn epuck(body: &Body) -> String {
    body.set([50, -50]);
    let body = body.clone();
    format!(
        "serial:{}@115200",
        at_a_port(move |port| lines(&body, port, None, epuck_answer))
    )
}

/// The same behind a server that forwards its line.
pub(crate) fn epuck_over_tcp(body: &Body) -> String {
    body.set([50, -50]);
    let body = body.clone();
    over_tcp(move |stream| lines(&body, stream, None, epuck_answer))
}

/// Answers lines, each at once or as slowly as its bytes take at a rate.
fn lines(body: &Body, mut link: impl Read + Write, rate: Option<u32>, answer: fn(&Body, &str) -> String) {
    let (mut line, mut mouth, mut byte) = (Vec::new(), Mouth::of(body), [0]);
    loop {
        if Body::is(&body.is_deaf) {
            thread::sleep(GLANCE);
            continue;
        }
        // Unread bytes are lost: a port may have no other end.
        let _ = mouth.speak(&mut link);
        match heard(&mut link, &mut byte) {
            None => return,
            Some(0) => continue,
            Some(_) => {}
        }
        if !matches!(byte[0], b'\r' | b'\n') {
            line.push(byte[0]);
            continue;
        }
        let heard = String::from_utf8_lossy(&std::mem::take(&mut line)).into_owned();
        let answer = answer(body, &heard);
        if let Some(rate) = rate {
            let bits = 11 * (heard.len() + 1 + answer.len());
            thread::sleep(Duration::from_secs_f64(bits as f64 / f64::from(rate)));
        }
        mouth.say(answer.as_bytes());
        let _ = mouth.speak(&mut link);
    }
}

/// What an e-puck answers to a line. It skips bytes that are none of a text.
fn epuck_answer(body: &Body, line: &str) -> String {
    let line = line.trim_matches(|letter: char| !letter.is_ascii_graphic());
    let fields: Vec<&str> = line.split(',').collect();
    let listed = |letter: &str, numbers: &[i16]| {
        let numbers: Vec<String> = numbers.iter().map(i16::to_string).collect();
        format!("{letter},{}\r\n", numbers.join(","))
    };
    match fields[..] {
        [""] => String::new(),
        ["D", left, right] => {
            body.obey([left, right].map(|speed| speed.parse().unwrap_or_default()));
            "d\r\n".into()
        }
        ["E"] => listed("e", &body.wheels().0),
        ["V"] => "v,Version 1.2.2 August 2008 GCtronic\r\nHW version: FFFF\r\n".into(),
        ["N"] => listed("n", &[11, 12, 13, 14, 15, 16, 17, 18]),
        ["O"] => listed("o", &[3000; 8]),
        ["A"] => listed("a", &[2048, 2048, 2800]),
        ["U"] => listed("u", &[12; 3]),
        ["Q"] => listed("q", &body.turned().map(|turned| turned as i64 as i16)),
        ["b"] => "b,1\r\n".into(),
        _ => "z,Command not found\r\n".into(),
    }
}

fn answer(body: &Body, line: &str) -> String {
    let fields: Vec<&str> = line.split(',').collect();
    match fields[..] {
        [""] => String::new(),
        ["B"] => "b,5.02,5.01\r\n".into(),
        ["D", left, right] => match (left.parse(), right.parse()) {
            (Ok(left), Ok(right)) => {
                body.obey([left, right]);
                "d\r\n".into()
            }
            _ => "z,Protocol error\r\n".into(),
        },
        ["N"] => "n,11,12,13,14,15,16,17,18\r\n".into(),
        ["O"] => "o,501,502,503,504,505,506,507,508\r\n".into(),
        // Pulses, of which a unit of speed has one in 10 ms.
        ["H"] => {
            let [left, right] = body.turned().map(|turned| (100.0 * turned) as i64);
            format!("h,{left},{right}\r\n")
        }
        ["E"] => format!("e,{},{}\r\n", body.wheels().0[0], body.wheels().0[1]),
        _ => "z,Protocol error\r\n".into(),
    }
}

/// Variables of a Thymio II, with their sizes.
const VARIABLES: [(&str, u16); 13] = [
    ("_vbat", 2),
    ("motor.left.target", 1),
    ("motor.right.target", 1),
    ("motor.left.speed", 1),
    ("motor.right.speed", 1),
    ("prox.horizontal", 7),
    ("prox.ground.delta", 2),
    ("acc", 3),
    ("button.backward", 1),
    ("button.left", 1),
    ("button.center", 1),
    ("button.forward", 1),
    ("button.right", 1),
];
/// Some of its events and of its native functions. A client may wait for the last function.
const EVENTS: [&str; 2] = ["buttons", "motor"];
const FUNCTIONS: [&str; 2] = ["leds.top", "sound.system"];

/// Starts a Thymio II with turning wheels, behind a switch. It is node 1.
pub(crate) fn thymio(body: &Body) -> String {
    body.set([100, -100]);
    let body = body.clone();
    over_tcp(move |stream| messages(&body, stream)).replace("tcp:", "aseba:")
}

/// The same at a cable.
pub(crate) fn thymio_at_a_port(body: &Body) -> String {
    body.set([100, -100]);
    let body = body.clone();
    format!("aseba:serial:{}", at_a_port(move |port| messages(&body, port)))
}

fn messages(body: &Body, mut link: impl Read + Write) {
    let (mut bytes, mut mouth, mut buffer) = (Vec::new(), Mouth::of(body), [0; 512]);
    loop {
        if Body::is(&body.is_deaf) {
            thread::sleep(GLANCE);
            continue;
        }
        let _ = mouth.speak(&mut link);
        match heard(&mut link, &mut buffer) {
            None => return,
            Some(count) => bytes.extend_from_slice(&buffer[..count]),
        }
        while let Some((kind, words)) = take(&mut bytes) {
            let answer = message(body, kind, &words);
            mouth.say(&answer);
        }
        let _ = mouth.speak(&mut link);
    }
}

/// The next whole message: its type and its payload.
fn take(heard: &mut Vec<u8>) -> Option<(u16, Vec<u16>)> {
    let word = |at: usize| Some(u16::from_le_bytes([*heard.get(at)?, *heard.get(at + 1)?]));
    let (length, kind) = (usize::from(word(0)?), word(4)?);
    if heard.len() < 6 + length {
        return None;
    }
    let words = (0..length / 2).map_while(|at| word(6 + 2 * at)).collect();
    heard.drain(..6 + length);
    Some((kind, words))
}

/// Does what a message says. Returns the answer.
fn message(body: &Body, kind: u16, words: &[u16]) -> Vec<u8> {
    let frame = |kind: u16, payload: &[u8]| {
        let head = [payload.len() as u16, 1, kind].map(u16::to_le_bytes).concat();
        [&head[..], payload].concat()
    };
    let bytes = |words: &[u16]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
    let text = |text: &str| [&[text.len() as u8], text.as_bytes()].concat();
    match (kind, words) {
        (0xa011, _) => frame(0x900c, &bytes(&[5])),
        (0xa010, _) => {
            let size: u16 = VARIABLES.iter().map(|(_, size)| size).sum();
            let head = bytes(&[
                5,
                100,
                32,
                size,
                VARIABLES.len() as u16,
                EVENTS.len() as u16,
                FUNCTIONS.len() as u16,
            ]);
            let mut answer = frame(0x9000, &[text("thymio-II"), head].concat());
            for (name, size) in VARIABLES {
                answer.extend(frame(0x9001, &[bytes(&[size]), text(name)].concat()));
            }
            for name in EVENTS {
                answer.extend(frame(0x9002, &[text(name), text("an event")].concat()));
            }
            for name in FUNCTIONS {
                let argument = [bytes(&[1, 1]), text("value")].concat();
                answer.extend(frame(0x9003, &[text(name), text("a function"), argument].concat()));
            }
            answer
        }
        (0xa00b, [_, start, count]) => {
            let memory = memory(body);
            let words = &memory[usize::from(*start)..][..usize::from(*count)];
            frame(0x9005, &bytes(&[&[*start], words].concat()))
        }
        (0xa00c, [_, start, values @ ..]) => {
            let mut speeds = body.wheels().0;
            for (address, value) in (usize::from(*start)..).zip(values) {
                // The targets are behind the battery's two words.
                speeds[address - 2] = *value as i16;
            }
            body.obey(speeds);
            Vec::new()
        }
        // Its program is stopped, which changes nothing else.
        (0xa007, _) => frame(0x900a, &bytes(&[0, 2])),
        _ => Vec::new(),
    }
}

/// All variables: 4.0 V or 3.3 V, a pale floor or none. The wheels have the speeds that they are told.
fn memory(body: &Body) -> Vec<u16> {
    let half = if Body::is(&body.is_low) { 656 } else { 796 };
    let ground = if Body::is(&body.is_lifted) { 20 } else { 800 };
    let [left, right] = body.wheels().0.map(|speed| speed as u16);
    let (proximity, acceleration, buttons) = (
        [1, 2, 1500, 4, 5, 6, 7],
        [-1_i16, 2, 22].map(|word| word as u16),
        [0, 1, 0, 0, 1],
    );
    let wheels = [left, right];
    [
        &[half, half][..],
        &wheels,
        &wheels,
        &proximity,
        &[ground; 2],
        &acceleration,
        &buttons,
    ]
    .concat()
}
