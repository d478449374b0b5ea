//! XML with the line of each attribute, and a record of what has been read: the rest is reported.

use std::borrow::Cow;
use std::cell::RefCell;
use std::collections::BTreeSet;

use oneiro_base::exit::{Failure, Result};
use roxmltree::{Document, Node, ParsingOptions};

use super::Format;
use super::draft::{Note, failure};

/// A file.
pub(super) struct Xml<'a> {
    /// Its path, for errors.
    name: &'a str,
    document: Document<'a>,
    /// The first byte of each line.
    lines: Vec<usize>,
    /// First bytes of the elements that were read.
    elements: RefCell<BTreeSet<usize>>,
    /// First bytes of the attributes that were read.
    attributes: RefCell<BTreeSet<usize>>,
}

/// An element.
#[derive(Clone, Copy)]
pub(super) struct Element<'a> {
    file: &'a Xml<'a>,
    node: Node<'a, 'a>,
}

/// The file's format, by its first element.
///
/// # Errors
/// Exit 3: it is not XML, or of another kind.
pub(super) fn root(name: &str, text: &str) -> Result<Format> {
    let file = Xml::parse(name, text)?;
    let root = file.document.root_element();
    match root.tag_name().name() {
        "argos-configuration" => Ok(Format::Argos),
        "aseba-playground" => Ok(Format::Playground),
        other => Err(failure(
            name,
            file.line(root.range().start),
            format_args!(
                "the first element is <{other}>; allowed: <argos-configuration> (ARGoS), <aseba-playground> (Aseba)"
            ),
        )),
    }
}

/// A text without the names of characters that XML doesn't know, such as `&ndash;`, which the simulators let pass. Nothing else moves.
pub(super) fn plain(text: &str) -> Cow<'_, str> {
    /// Those that XML knows.
    const KNOWN: [&str; 5] = ["amp", "lt", "gt", "quot", "apos"];
    if text.contains("<!ENTITY") || !text.contains('&') {
        return Cow::Borrowed(text);
    }
    let mut plain = String::with_capacity(text.len());
    let mut pieces = text.split('&');
    plain += pieces.next().unwrap_or_default();
    for piece in pieces {
        let name = piece
            .split(|c: char| !c.is_ascii_alphanumeric())
            .next()
            .unwrap_or_default();
        let is_unknown = !name.is_empty() && piece[name.len()..].starts_with(';') && !KNOWN.contains(&name);
        if is_unknown {
            // As long as the name.
            plain.extend(std::iter::repeat_n('?', name.len() + 2));
            plain += &piece[name.len() + 1..];
        } else {
            plain.extend(["&", piece]);
        }
    }
    Cow::Owned(plain)
}

impl<'a> Xml<'a> {
    /// Parses a file's text, made [`plain`].
    ///
    /// # Errors
    /// Exit 3: the place that is not XML.
    pub(super) fn parse(name: &'a str, text: &'a str) -> Result<Self> {
        let options = ParsingOptions {
            // Playgrounds have one. Entities are no danger: their depth and number are limited.
            allow_dtd: true,
            ..ParsingOptions::default()
        };
        let document = Document::parse_with_options(text, options).map_err(|error| {
            let place = error.pos();
            let problem = error.to_string();
            let problem = problem.strip_suffix(&format!(" at {place}")).unwrap_or(&problem);
            Failure::input(format_args!(
                "{name}:{}:{}: is no XML: {problem}; allowed: a complete file, as the simulator reads it",
                place.row, place.col
            ))
        })?;
        let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        Ok(Self {
            name,
            document,
            lines: std::iter::once(0).chain(ends.map(|(at, _)| at + 1)).collect(),
            elements: RefCell::default(),
            attributes: RefCell::default(),
        })
    }

    fn line(&self, at: usize) -> usize {
        self.lines.partition_point(|start| *start <= at)
    }

    /// The first element, as one that is read.
    pub(super) fn root(&'a self) -> Element<'a> {
        Element::read(self, self.document.root_element())
    }

    /// A note for each element and attribute that was not read. `reasons` are by `element`, `element.attribute` or `*.attribute`; nothing is
    /// said where the reason is empty.
    pub(super) fn rest(&self, reasons: &[(&str, &str)]) -> Vec<Note> {
        const UNKNOWN: &str = "Oneiro has nothing like it";
        let reason = |keys: &[&str]| {
            let found = keys
                .iter()
                .find_map(|key| reasons.iter().find(|(known, _)| known == key));
            found.map_or(UNKNOWN, |(_, reason)| *reason)
        };
        let mut notes = Vec::new();
        let mut add = |at: usize, what: String, why: &str| {
            if !why.is_empty() {
                notes.push(Note::new(self.line(at), what, why));
            }
        };
        let mut open = vec![self.document.root_element()];
        while let Some(node) = open.pop() {
            let (tag, at) = (node.tag_name().name(), node.range().start);
            if !self.elements.borrow().contains(&at) {
                add(at, format!("<{tag}>"), reason(&[tag]));
                continue;
            }
            for attribute in node.attributes() {
                let (name, at) = (attribute.name(), attribute.range().start);
                if !self.attributes.borrow().contains(&at) {
                    let why = reason(&[&format!("{tag}@{name}"), &format!("*@{name}")]);
                    add(at, format!("<{tag} {name}>"), why);
                }
            }
            open.extend(node.children().filter(Node::is_element));
        }
        notes
    }
}

impl<'a> Element<'a> {
    fn read(file: &'a Xml<'a>, node: Node<'a, 'a>) -> Self {
        file.elements.borrow_mut().insert(node.range().start);
        Self { file, node }
    }

    pub(super) fn tag(self) -> &'a str {
        self.node.tag_name().name()
    }

    /// From 1.
    pub(super) fn line(self) -> usize {
        self.file.line(self.node.range().start)
    }

    /// Its name in comments: `<box id="a">`.
    pub(super) fn what(self) -> String {
        match self.word("id") {
            Some(id) => format!("<{} id=\"{id}\">", self.tag()),
            None => format!("<{}>", self.tag()),
        }
    }

    /// Its children that are elements, not read yet.
    pub(super) fn unread(self) -> impl Iterator<Item = Unread<'a>> {
        let file = self.file;
        self.node
            .children()
            .filter(Node::is_element)
            .map(move |node| Unread(Element { file, node }))
    }

    /// Its children with this name.
    pub(super) fn children(self, tag: &'a str) -> impl Iterator<Item = Self> {
        self.unread().filter(move |child| child.tag() == tag).map(Unread::read)
    }

    /// Its first child with this name.
    pub(super) fn child(self, tag: &'a str) -> Option<Self> {
        self.children(tag).next()
    }

    /// Reads all that is in it: something else says why it is not taken.
    pub(super) fn read_all(self) {
        for node in self.node.descendants().filter(Node::is_element) {
            Self::read(self.file, node);
            let starts = node.attributes().map(|own| own.range().start);
            self.file.attributes.borrow_mut().extend(starts);
        }
    }

    /// An attribute's text.
    pub(super) fn word(self, name: &str) -> Option<&'a str> {
        let attribute = self.node.attribute_node(name)?;
        self.file.attributes.borrow_mut().insert(attribute.range().start);
        Some(attribute.value())
    }

    /// An error about one of its attributes.
    pub(super) fn failure(self, name: &str, problem: impl std::fmt::Display) -> Failure {
        let at = self
            .node
            .attribute_node(name)
            .map_or(self.node.range().start, |own| own.range().start);
        failure(
            self.file.name,
            self.file.line(at),
            format_args!("<{} {name}>: {problem}", self.tag()),
        )
    }

    /// An attribute's numbers, separated by commas or blanks.
    ///
    /// # Errors
    /// Exit 3: it has fewer than `N`, or one that is no finite number.
    pub(super) fn numbers<const N: usize>(self, name: &str) -> Result<Option<[f64; N]>> {
        let Some(text) = self.word(name) else {
            return Ok(None);
        };
        let refused = || {
            let shown: String = text.chars().take(40).collect();
            let allowed = if N == 1 {
                "a number".to_owned()
            } else {
                format!("{N} numbers, separated by commas")
            };
            self.failure(name, format_args!("is `{shown}`; allowed: {allowed}"))
        };
        let mut numbers = text
            .split(|c: char| c == ',' || c.is_whitespace())
            .filter(|word| !word.is_empty());
        let mut found = [0.0; N];
        for number in &mut found {
            let parsed = numbers.next().and_then(|word| word.parse().ok());
            *number = parsed.filter(|number: &f64| number.is_finite()).ok_or_else(refused)?;
        }
        // ARGoS places things on the plane with two numbers or three.
        if numbers.any(|word| !word.parse::<f64>().is_ok_and(f64::is_finite)) {
            return Err(refused());
        }
        Ok(Some(found))
    }

    /// As [`Self::numbers`], of an attribute that must be there.
    ///
    /// # Errors
    /// Exit 3: also if it isn't.
    pub(super) fn needed<const N: usize>(self, name: &str) -> Result<[f64; N]> {
        let missing = || {
            let allowed = if N == 1 {
                "a number".to_owned()
            } else {
                format!("{N} numbers")
            };
            self.failure(name, format_args!("is missing; allowed: {allowed}"))
        };
        self.numbers(name)?.ok_or_else(missing)
    }

    /// A length that must be there and be positive.
    ///
    /// # Errors
    /// Exit 3.
    pub(super) fn length(self, name: &str) -> Result<f64> {
        let [length] = self.needed(name)?;
        if length > 0.0 {
            return Ok(length);
        }
        Err(self.failure(name, format_args!("is {length}; allowed: more than 0")))
    }
}

/// An element that is not read yet.
#[derive(Clone, Copy)]
pub(super) struct Unread<'a>(Element<'a>);

impl<'a> Unread<'a> {
    pub(super) fn tag(self) -> &'a str {
        self.0.tag()
    }

    /// Reads it.
    pub(super) fn read(self) -> Element<'a> {
        Element::read(self.0.file, self.0.node)
    }

    /// Whether it has a child with this name.
    pub(super) fn has(self, tag: &str) -> bool {
        self.0.node.children().any(|child| child.tag_name().name() == tag)
    }

    /// Whether an element with such a name is in it, at any depth.
    pub(super) fn has_within(self, is_meant: impl Fn(&str) -> bool) -> bool {
        self.0
            .node
            .descendants()
            .any(|node| node.is_element() && is_meant(node.tag_name().name()))
    }
}
