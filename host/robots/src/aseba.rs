//! The Aseba protocol: messages between a computer and the nodes of a network, over a serial line or TCP.
//!
//! A message has a length, a source, a type and a payload; all numbers are 16 bits, lowest byte first (Aseba,
//! common/consts.h and transport/buffer/vm-buffer.c). A node of version 4 or less does not answer to the request for a list of
//! nodes, so it is not found.

use std::collections::VecDeque;
use std::ops::Range;
use std::slice;
use std::time::Duration;

use super::error::{Error, Result};
use super::link::{self, Link};
use super::talk::{Stepped, garbage, persistently};

/// The version that is claimed to nodes; all of them answer to it.
const VERSION: u16 = 5;
/// From this version on, a node describes one variable at a time when asked.
const FRAGMENTS: u16 = 8;
/// A node answers within 31 ms, a wireless one later.
const PATIENCE: Duration = Duration::from_millis(300);
/// No two parts of an answer are as far from each other.
const SILENCE: Duration = Duration::from_millis(50);
const SEND: Duration = Duration::from_millis(200);
/// Longest wait for a silence.
const BABBLE: Duration = Duration::from_millis(800);
/// Longest wait for further nodes: a stream of them must end.
const ROLL_CALL: Duration = Duration::from_secs(3);
/// A wireless dongle can lose many messages (Aseba, issue 538).
const TRIES: u32 = 4;
/// Longest time in which all nodes describe themselves: a radio's dongle takes some seconds for a Thymio II.
pub(crate) const DESCRIBING: Duration = Duration::from_secs(30);
/// Most nodes of a network, and most variables, events or functions of one: a Thymio II has about 60 of each.
const MOST_NODES: usize = 128;
const MOST_NAMES: u16 = 1000;

/// A Thymio II sends as many variables in one message.
const MOST_WORDS: u16 = 47;

const DESCRIPTION: u16 = 0x9000;
const VARIABLE: u16 = 0x9001;
const LOCAL_EVENT: u16 = 0x9002;
const NATIVE_FUNCTION: u16 = 0x9003;
const VARIABLES: u16 = 0x9005;
/// Messages from the first to the last of these say that a program has failed.
const PROGRAM_FAILURES: [u16; 2] = [0x9006, 0x9009];
const EXECUTION_STATE: u16 = 0x900a;
const NODE_PRESENT: u16 = 0x900c;
const SET_BYTECODE: u16 = 0xa001;
const RUN: u16 = 0xa003;
const STOP: u16 = 0xa006;
const GET_EXECUTION_STATE: u16 = 0xa007;
const GET_VARIABLES: u16 = 0xa00b;
const SET_VARIABLES: u16 = 0xa00c;
const GET_DESCRIPTION: u16 = 0xa010;
const LIST_NODES: u16 = 0xa011;
const GET_FRAGMENT: u16 = 0xa015;

/// A message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Message {
    /// The node that sent it; 0 is the computer.
    pub source: u16,
    /// Its type.
    pub kind: u16,
    /// What depends on the type.
    pub(crate) payload: Vec<u8>,
}

impl Message {
    /// The longest payload.
    const LONGEST: usize = 516;

    /// A message to nodes.
    fn new(kind: u16, words: impl IntoIterator<Item = u16>) -> Self {
        Self {
            source: 0,
            kind,
            payload: words.into_iter().flat_map(u16::to_le_bytes).collect(),
        }
    }

    /// The message's bytes.
    fn frame(&self) -> Vec<u8> {
        let head = [self.payload.len() as u16, self.source, self.kind].map(u16::to_le_bytes);
        [&head.concat(), &self.payload[..]].concat()
    }

    /// Whether a program sent it, unasked.
    fn is_event(&self) -> bool {
        self.kind < 0x8000
    }

    fn reader(&self) -> Reader<'_> {
        Reader(&self.payload)
    }
}

/// Reads a payload from its front; `None` beyond its end.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn word(&mut self) -> Option<u16> {
        let (word, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(u16::from_le_bytes(*word))
    }

    /// A string: its length in a byte, then UTF-8.
    fn text(&mut self) -> Option<String> {
        let (length, rest) = self.0.split_first()?;
        let (text, rest) = rest.split_at_checked(usize::from(*length))?;
        self.0 = rest;
        String::from_utf8(text.into()).ok()
    }
}

/// Splits a stream into messages. Holds less than one message between calls.
#[derive(Debug, Default)]
pub(crate) struct Messages(Vec<u8>);

impl Messages {
    /// Adds bytes, and returns the messages that they complete.
    ///
    /// # Errors
    /// A length that no message has: the stream is out of step, and has no mark to find the next message by.
    pub(crate) fn push(&mut self, bytes: &[u8]) -> std::result::Result<Vec<Message>, u16> {
        self.0.extend_from_slice(bytes);
        let (mut rest, mut messages) = (&self.0[..], Vec::new());
        while let Some((head, after)) = rest.split_first_chunk::<6>() {
            let [length, source, kind] =
                [[head[0], head[1]], [head[2], head[3]], [head[4], head[5]]].map(u16::from_le_bytes);
            if usize::from(length) > Message::LONGEST {
                self.0.clear();
                return Err(length);
            }
            let Some((payload, next)) = after.split_at_checked(usize::from(length)) else {
                break;
            };
            messages.push(Message {
                source,
                kind,
                payload: payload.into(),
            });
            rest = next;
        }
        let left = rest.len();
        self.0.drain(..self.0.len() - left);
        Ok(messages)
    }
}

/// A node of a network.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Node {
    /// Its number.
    pub id: u16,
    /// Version of its protocol.
    pub version: u16,
    /// Its name, such as `thymio-II`.
    pub name: String,
    /// Names of its variables and their addresses.
    pub variables: Vec<(String, Range<u16>)>,
    /// Words of memory without a name, behind the variables.
    pub free: Range<u16>,
    /// Number of its local events, and their names if they have come with the rest.
    event_count: u16,
    events: Vec<String>,
}

impl Node {
    /// Addresses of a variable.
    pub(crate) fn variable(&self, name: &str) -> Option<Range<u16>> {
        let variable = self.variables.iter().find(|(known, _)| known == name);
        variable.map(|(_, addresses)| addresses.clone())
    }
}

/// Head of a description.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Head {
    name: String,
    version: u16,
    /// Words of all variables, named and free.
    words: u16,
    /// Numbers of variables, local events and native functions.
    counts: [u16; 3],
}

impl Head {
    fn read(message: &Message) -> Option<Self> {
        let mut reader = message.reader();
        let name = reader.text()?;
        let [version, _bytecode, _stack, words, variables, events, functions] = {
            let mut words = [0; 7];
            for word in &mut words {
                *word = reader.word()?;
            }
            words
        };
        let counts = [variables, events, functions];
        let is_whole = reader.0.is_empty() && !name.is_empty() && counts.iter().all(|count| *count <= MOST_NAMES);
        is_whole.then_some(Self {
            name,
            version,
            words,
            counts,
        })
    }
}

/// A network.
pub(crate) struct Network {
    link: Box<dyn Link>,
    messages: Messages,
    /// Messages received, until they are looked at.
    queue: VecDeque<Message>,
    in_step: bool,
}

impl Network {
    /// The network at the end of a link.
    pub(crate) fn new(link: Box<dyn Link>) -> Self {
        Self {
            link,
            messages: Messages::default(),
            queue: VecDeque::new(),
            in_step: false,
        }
    }

    /// The time on the link's clock.
    pub(crate) fn now(&self) -> Duration {
        self.link.now()
    }

    /// The link's address.
    pub(crate) fn name(&self) -> &str {
        self.link.name()
    }

    /// Opens the link again.
    ///
    /// # Errors
    /// It can't be opened.
    pub(crate) fn reopen(&mut self) -> Result {
        self.clear();
        self.in_step = false;
        self.link.reopen()
    }

    /// Lists the nodes that answer, with their protocols' versions.
    ///
    /// # Errors
    /// None answers, or the link fails.
    pub(crate) fn list(&mut self) -> Result<Vec<(u16, u16)>> {
        self.persistently(|network| {
            network.send(&[Message::new(LIST_NODES, [VERSION])])?;
            let (mut nodes, mut until) = (Vec::new(), network.now() + PATIENCE);
            let end = network.now() + ROLL_CALL;
            while let Some(message) = network.message(until)? {
                let version = message.reader().word().filter(|_| message.kind == NODE_PRESENT);
                let node = version.map(|version| (message.source, version));
                if let Some(node) = node.filter(|node| !nodes.contains(node)) {
                    nodes.push(node);
                    until = end.min(network.now() + PATIENCE);
                }
            }
            nodes.sort_unstable();
            if nodes.len() > MOST_NODES {
                return Err(garbage("the list of nodes", &format!("{} nodes", nodes.len())));
            }
            if nodes.is_empty() {
                Err(late("the list of nodes"))
            } else {
                Ok(nodes)
            }
        })
    }

    /// Asks a node for its description, which must have come by a time. A lost message must not shift the addresses of
    /// variables: a node of version 8 or later is asked for one after the other; of another, all has to come.
    ///
    /// # Errors
    /// The node does not answer in time, or the link fails.
    pub(crate) fn describe(&mut self, id: u16, version: u16, end: Duration) -> Result<Node> {
        let (head, variables, events) = if version >= FRAGMENTS {
            let head = self.fragment(id, -1, end, DESCRIPTION, Head::read)?;
            let variables = (0..head.counts[0]).map(|index| self.fragment(id, index as i16, end, VARIABLE, variable));
            let variables = variables.collect::<Result<Vec<_>>>()?;
            (head, variables, Vec::new())
        } else {
            self.persistently(|network| network.whole(id, end))?
        };
        let (mut named, mut next) = (Vec::new(), 0_u16);
        for (size, name) in variables {
            let end = next.checked_add(size).filter(|end| *end <= head.words);
            let end = end.ok_or_else(|| garbage("the description", "more variables than it has room for"))?;
            named.push((name, next..end));
            next = end;
        }
        Ok(Node {
            id,
            version: head.version,
            name: head.name,
            variables: named,
            free: next..head.words,
            event_count: head.counts[1],
            events,
        })
    }

    /// Names of a node's local events, in order. A node that describes one thing at a time numbers them on from its variables.
    ///
    /// # Errors
    /// The node does not answer, or the link fails.
    pub(crate) fn events(&mut self, node: &Node) -> Result<Vec<String>> {
        if node.version < FRAGMENTS {
            return Ok(node.events.clone());
        }
        let first = node.variables.len() as i16;
        let end = self.now() + DESCRIBING;
        (first..first + node.event_count as i16)
            .map(|index| self.fragment(node.id, index, end, LOCAL_EVENT, event))
            .collect()
    }

    /// A part of a description by its index; -1 is the head.
    fn fragment<T>(
        &mut self,
        id: u16,
        index: i16,
        end: Duration,
        kind: u16,
        read: impl Fn(&Message) -> Option<T>,
    ) -> Result<T> {
        self.persistently(|network| {
            network.send(&[Message::new(GET_FRAGMENT, [id, VERSION, index as u16])])?;
            network.part(id, end, kind, &read)
        })
    }

    /// A whole description: the head, then variables, local events and native functions. Each message resets the time.
    fn whole(&mut self, id: u16, end: Duration) -> Result<(Head, Vec<Variable>, Vec<String>)> {
        self.send(&[Message::new(GET_DESCRIPTION, [id, VERSION])])?;
        let head = self.part(id, end, DESCRIPTION, Head::read)?;
        let [variables, events, functions] = head.counts;
        let variables = (0..variables).map(|_| self.part(id, end, VARIABLE, variable));
        let variables = variables.collect::<Result<Vec<_>>>()?;
        let events = (0..events).map(|_| self.part(id, end, LOCAL_EVENT, event));
        let events = events.collect::<Result<Vec<_>>>()?;
        for _ in 0..functions {
            self.part(id, end, NATIVE_FUNCTION, |_| Some(()))?;
        }
        Ok((head, variables, events))
    }

    /// The next part of a description, which must be of this type.
    fn part<T>(&mut self, id: u16, end: Duration, kind: u16, read: impl Fn(&Message) -> Option<T>) -> Result<T> {
        let until = end.min(self.now() + PATIENCE);
        while let Some(message) = self.message(until)? {
            if message.source == id && (DESCRIPTION..=NATIVE_FUNCTION).contains(&message.kind) {
                let part = read(&message).filter(|_| message.kind == kind);
                return part.ok_or_else(|| garbage("a request for the description", &format!("{message:?}")));
            }
        }
        Err(late("the description"))
    }

    /// Reads the words at some addresses.
    ///
    /// # Errors
    /// The node does not answer, or the link fails.
    pub(crate) fn get(&mut self, id: u16, addresses: &[u16]) -> Result<Vec<i16>> {
        self.persistently(|network| network.exchange(id, &[], addresses))
    }

    /// Sets words by their addresses, and reads them back: a message that sets has no answer.
    ///
    /// # Errors
    /// The node does not answer or holds other values, or the link fails.
    pub(crate) fn set(&mut self, id: u16, values: &[(u16, i16)]) -> Result {
        let addresses: Vec<u16> = values.iter().map(|(address, _)| *address).collect();
        self.persistently(|network| {
            let held = network.exchange(id, values, &addresses)?;
            if held.iter().eq(values.iter().map(|(_, value)| value)) {
                return Ok(());
            }
            Err(Error::Refused {
                command: format!("the values {values:?} of variables"),
                answer: format!("{held:?}"),
            })
        })
    }

    /// Replaces a node's program, and runs it. Its variables are then 0, or unchanged.
    ///
    /// # Errors
    /// The node does not confirm that it runs, or the link fails.
    pub(crate) fn load(&mut self, id: u16, bytecode: &[u16]) -> Result {
        let set = Message::new(SET_BYTECODE, [id, 0].into_iter().chain(bytecode.iter().copied()));
        self.persistently(|network| {
            let others = [RUN, GET_EXECUTION_STATE].map(|kind| Message::new(kind, [id]));
            network.send(&[slice::from_ref(&set), &others[..]].concat())?;
            let until = network.now() + PATIENCE;
            while let Some(message) = network.message(until)? {
                if message.source == id && runs(&message) == Some(true) {
                    return Ok(());
                }
            }
            Err(late("the beginning of a program"))
        })
    }

    /// Sets words of a node by their addresses, and reads the first `count` of them back. Returns whether the node's program runs.
    ///
    /// # Errors
    /// The node does not answer or holds other values, or the link fails.
    pub(crate) fn set_running(&mut self, id: u16, values: &[(u16, i16)], count: usize) -> Result<bool> {
        let addresses: Vec<u16> = values[..count].iter().map(|(address, _)| *address).collect();
        self.persistently(|network| {
            let get = |span: Range<u16>| Message::new(GET_VARIABLES, [id, span.start, span.end - span.start]);
            let asked = spans(&addresses).into_iter().map(get);
            let state = Message::new(GET_EXECUTION_STATE, [id]);
            network.send(&sets(id, values).chain(asked).chain([state]).collect::<Vec<_>>())?;
            let (mut held, mut is_running) = (vec![None; count], None);
            let until = network.now() + PATIENCE;
            while is_running.is_none() || held.contains(&None) {
                let message = network.message(until)?.ok_or_else(|| late("the state of a program"))?;
                if message.source != id {
                    continue;
                }
                is_running = runs(&message).or(is_running);
                if message.kind == VARIABLES {
                    fill(&message, &addresses, &mut held);
                }
            }
            let is_held = held.iter().zip(values).all(|(held, (_, value))| *held == Some(*value));
            match is_running {
                Some(true) if !is_held => Err(Error::Refused {
                    command: format!("the values {:?} of variables", &values[..count]),
                    answer: format!("{held:?}"),
                }),
                state => Ok(state == Some(true)),
            }
        })
    }

    fn exchange(&mut self, id: u16, values: &[(u16, i16)], addresses: &[u16]) -> Result<Vec<i16>> {
        let get = |span: Range<u16>| Message::new(GET_VARIABLES, [id, span.start, span.end - span.start]);
        let gets = spans(addresses).into_iter().map(get);
        self.send(&sets(id, values).chain(gets).collect::<Vec<_>>())?;
        let mut held: Vec<Option<i16>> = vec![None; addresses.len()];
        let until = self.now() + PATIENCE;
        while held.contains(&None) {
            let message = self.message(until)?.ok_or_else(|| late("the values of variables"))?;
            if message.source == id && message.kind == VARIABLES {
                fill(&message, addresses, &mut held);
            }
        }
        Ok(held.into_iter().flatten().collect())
    }

    /// Stops the program that a node runs. Its variables keep their values, the motors' targets among them.
    ///
    /// # Errors
    /// The node does not confirm it, or the link fails.
    pub(crate) fn halt(&mut self, id: u16) -> Result {
        self.persistently(|network| {
            let request = [STOP, GET_EXECUTION_STATE].map(|kind| Message::new(kind, [id]));
            network.send(&request)?;
            let until = network.now() + PATIENCE;
            while let Some(message) = network.message(until)? {
                if message.source == id && is_stopped(&message) {
                    return Ok(());
                }
            }
            Err(late("the end of its program"))
        })
    }

    /// Tells a node to stop its program, without waiting for an answer.
    ///
    /// # Errors
    /// The link fails.
    pub(crate) fn tell_to_halt(&mut self, id: u16) -> Result {
        self.send(&[Message::new(STOP, [id])])
    }

    /// Sets words of a node by their addresses, without a look at what it holds then.
    ///
    /// # Errors
    /// The link fails.
    pub(crate) fn put(&mut self, id: u16, values: &[(u16, i16)]) -> Result {
        self.send(&sets(id, values).collect::<Vec<_>>())
    }

    fn persistently<T>(&mut self, attempt: impl FnMut(&mut Self) -> Result<T>) -> Result<T> {
        persistently(self, TRIES, attempt)
    }

    /// Sends messages in one piece: half a message would hold some nodes up.
    fn send(&mut self, messages: &[Message]) -> Result {
        // What came before answers nothing, whether it makes sense or not.
        let mut buffer = [0; 1024];
        for _ in 0..128 {
            match self.link.waiting(&mut buffer)? {
                0 => break,
                count => drop(self.messages.push(&buffer[..count])),
            }
        }
        self.queue.clear();
        let bytes: Vec<u8> = messages.iter().flat_map(Message::frame).collect();
        link::send_whole(&mut *self.link, &bytes, SEND)
    }

    fn take(&mut self, bytes: &[u8]) -> Result {
        let messages = self.messages.push(bytes);
        self.queue
            .extend(messages.map_err(|length| garbage("a message", &format!("a message of {length} bytes")))?);
        Ok(())
    }

    /// The next message; none once the time has passed.
    fn message(&mut self, until: Duration) -> Result<Option<Message>> {
        let mut buffer = [0; 1024];
        loop {
            if let Some(message) = self.queue.pop_front() {
                return Ok(Some(message));
            }
            match self.link.read(&mut buffer, until)? {
                0 => return Ok(None),
                count => self.take(&buffer[..count])?,
            }
        }
    }

    fn clear(&mut self) {
        self.messages = Messages::default();
        self.queue.clear();
    }
}

impl Stepped for Network {
    fn in_step(&mut self) -> &mut bool {
        &mut self.in_step
    }

    /// Discards what comes until neither an answer nor nonsense has come for a while. Programs may emit events for ever.
    fn resynchronise(&mut self) -> Result {
        let end = self.now() + BABBLE;
        let mut until = self.now() + SILENCE;
        let mut buffer = [0; 1024];
        loop {
            match self.link.read(&mut buffer, until.min(end))? {
                0 if until <= end => break,
                0 => return Err(garbage("a pause", "a stream that does not end")),
                count => match self.messages.push(&buffer[..count]) {
                    Ok(messages) if messages.iter().all(Message::is_event) => {}
                    _ => until = self.now() + SILENCE,
                },
            }
        }
        self.clear();
        Ok(())
    }
}

/// The size in words and the name of a variable.
type Variable = (u16, String);

/// A named variable: its size in words, and its name.
fn variable(message: &Message) -> Option<Variable> {
    let mut reader = message.reader();
    let (size, name) = (reader.word()?, reader.text()?);
    (reader.0.is_empty() && size > 0 && !name.is_empty()).then_some((size, name))
}

/// A local event: its name.
fn event(message: &Message) -> Option<String> {
    message.reader().text().filter(|name| !name.is_empty())
}

/// The bytes of messages that set words of a node by their addresses.
pub(crate) fn set(id: u16, values: &[(u16, i16)]) -> Vec<u8> {
    sets(id, values).flat_map(|message| message.frame()).collect()
}

/// Messages that set words by their addresses, one for words that follow one another.
fn sets(id: u16, values: &[(u16, i16)]) -> impl Iterator<Item = Message> + '_ {
    let set = move |words: &[(u16, i16)]| {
        let values = words.iter().map(|(_, value)| *value as u16);
        Message::new(SET_VARIABLES, [id, words[0].0].into_iter().chain(values))
    };
    values.chunk_by(|(one, _), (next, _)| *next == one + 1).map(set)
}

/// Whether a message says that its node runs its program, if it says anything of that: it does not if it was stopped, or has failed.
fn runs(message: &Message) -> Option<bool> {
    let [first, last] = PROGRAM_FAILURES;
    if (first..=last).contains(&message.kind) {
        return Some(false);
    }
    let mut reader = message.reader();
    let (_counter, flags) = (reader.word(), reader.word());
    flags
        .filter(|_| message.kind == EXECUTION_STATE)
        .map(|flags| flags & 2 == 0)
}

/// Whether a message says that its node runs no program: of the flags, 1 stands for a running event and 2 for a stop.
fn is_stopped(message: &Message) -> bool {
    let mut reader = message.reader();
    let (_counter, flags) = (reader.word(), reader.word());
    message.kind == EXECUTION_STATE && flags.is_some_and(|flags| flags & 3 == 2)
}

/// Few requests that cover addresses: each has an answer, and over TCP a second one may wait until the first is
/// acknowledged. None is for more than a Thymio II sends in one message.
fn spans(addresses: &[u16]) -> Vec<Range<u16>> {
    let mut sorted = addresses.to_vec();
    sorted.sort_unstable();
    let mut spans: Vec<Range<u16>> = Vec::new();
    for address in sorted {
        match spans.last_mut() {
            Some(span) if address - span.start < MOST_WORDS => span.end = address + 1,
            _ => spans.push(address..address + 1),
        }
    }
    spans
}

/// Puts the words of an answer, an address and what stands from there on, where they are wanted.
fn fill(message: &Message, addresses: &[u16], held: &mut [Option<i16>]) {
    let mut reader = message.reader();
    let Some(start) = reader.word() else { return };
    for address in start..=u16::MAX {
        let Some(word) = reader.word() else { return };
        for (_, held) in addresses
            .iter()
            .zip(&mut *held)
            .filter(|(wanted, _)| **wanted == address)
        {
            *held = Some(word as i16);
        }
    }
}

fn late(what: &str) -> Error {
    Error::TimedOut {
        command: format!("a request for {what}"),
        limit: PATIENCE,
    }
}

#[cfg(test)]
pub(super) mod tests;
