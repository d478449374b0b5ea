//! A client of the Aseba protocol that shares no code with the program's. All numbers are 16 bits, lowest byte first.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::ops::Range;
use std::time::Duration;

const DESCRIPTION: u16 = 0x9000;
const VARIABLE: u16 = 0x9001;
const EVENT: u16 = 0x9002;
const VARIABLES: u16 = 0x9005;
const PRESENT: u16 = 0x900c;
const SET_BYTECODE: u16 = 0xa001;
const RUN: u16 = 0xa003;
const GET: u16 = 0xa00b;
const SET: u16 = 0xa00c;
const DESCRIBE: u16 = 0xa010;
const LIST: u16 = 0xa011;

/// A connection to one robot.
pub(crate) struct Client {
    stream: TcpStream,
    node: u16,
    /// Names of variables and their addresses.
    variables: Vec<(String, Range<u16>)>,
    /// Names of events.
    events: Vec<String>,
}

impl Client {
    pub(crate) fn connect(port: u16) -> Self {
        let stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        stream.set_nodelay(true).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(5))).unwrap();
        let mut client = Self {
            stream,
            node: 0,
            variables: Vec::new(),
            events: Vec::new(),
        };
        client.send(LIST, &[5]);
        client.node = client.receive(PRESENT).0;
        client.send(DESCRIBE, &[client.node, 5]);
        let head = client.receive(DESCRIPTION).1;
        // Behind the name: version, sizes of bytecode, stack and variables, and the numbers of variables and events.
        let at = 1 + usize::from(head[0]) + 8;
        let [variables, events] = [at, at + 2].map(|at| u16::from_le_bytes([head[at], head[at + 1]]));
        let mut next = 0;
        for _ in 0..variables {
            let variable = client.receive(VARIABLE).1;
            let end = next + u16::from_le_bytes([variable[0], variable[1]]);
            let name = String::from_utf8(variable[3..].into()).unwrap();
            client.variables.push((name, next..end));
            next = end;
        }
        for _ in 0..events {
            let event = client.receive(EVENT).1;
            let name = &event[1..][..event[0].into()];
            client.events.push(String::from_utf8(name.into()).unwrap());
        }
        client
    }

    /// Starts a program that counts an event in a variable behind the others, which gets a name.
    pub(crate) fn count(&mut self, event: &str, counter: &str) {
        let address = self.variables.last().unwrap().1.end;
        let index = self.events.iter().position(|known| known == event).unwrap() as u16;
        // A table of 3 words: its length, the event, and where its code begins; then load, 1, add, store, stop.
        let code = [
            3,
            0xfffe - index,
            3,
            0x3000 | address,
            0x1001,
            0x8002,
            0x4000 | address,
            0,
        ];
        self.send(SET_BYTECODE, &[&[self.node, 0][..], &code].concat());
        self.send(RUN, &[self.node]);
        self.variables.push((counter.into(), address..address + 1));
    }

    fn send(&mut self, kind: u16, words: &[u16]) {
        let head = [2 * words.len() as u16, 0, kind];
        let frame: Vec<u8> = head.iter().chain(words).flat_map(|word| word.to_le_bytes()).collect();
        self.stream.write_all(&frame).unwrap();
    }

    /// The next message of a type: its source and its payload.
    fn receive(&mut self, kind: u16) -> (u16, Vec<u8>) {
        loop {
            let mut head = [0; 6];
            self.stream.read_exact(&mut head).unwrap();
            let [length, source, found] = [0, 2, 4].map(|at| u16::from_le_bytes([head[at], head[at + 1]]));
            let mut payload = vec![0; length.into()];
            self.stream.read_exact(&mut payload).unwrap();
            if found == kind {
                return (source, payload);
            }
        }
    }

    fn address(&self, name: &str) -> Range<u16> {
        let variable = self.variables.iter().find(|(known, _)| known == name);
        variable.unwrap_or_else(|| panic!("no {name}")).1.clone()
    }

    /// Asks for a variable, without waiting for the answer.
    pub(crate) fn ask(&mut self, name: &str) {
        self.ask_all(name, name);
    }

    /// The same for all variables from one to another.
    pub(crate) fn ask_all(&mut self, first: &str, last: &str) {
        let (start, end) = (self.address(first).start, self.address(last).end);
        self.send(GET, &[self.node, start, end - start]);
    }

    /// The answer to a question.
    pub(crate) fn answer(&mut self) -> Vec<i16> {
        let words = self.receive(VARIABLES).1;
        let words = words.chunks(2).map(|word| i16::from_le_bytes([word[0], word[1]]));
        // Behind the address.
        words.skip(1).collect()
    }

    /// All variables from one to another, behind a switch, where answers to others are heard too.
    pub(crate) fn get_among(&mut self, first: &str, last: &str) -> Vec<i16> {
        let (start, end) = (self.address(first).start, self.address(last).end);
        self.ask_all(first, last);
        loop {
            let (_, words) = self.receive(VARIABLES);
            let mut words = words.chunks(2).map(|word| i16::from_le_bytes([word[0], word[1]]));
            if words.next() == Some(start as i16) && words.len() == usize::from(end - start) {
                return words.collect();
            }
        }
    }

    pub(crate) fn get(&mut self, name: &str) -> Vec<i16> {
        self.ask(name);
        self.answer()
    }

    pub(crate) fn set(&mut self, name: &str, values: &[i16]) {
        let start = self.address(name).start;
        let words: Vec<u16> = values.iter().map(|value| *value as u16).collect();
        self.send(SET, &[&[self.node, start][..], &words].concat());
    }
}
