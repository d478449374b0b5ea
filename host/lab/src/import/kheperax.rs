//! Mazes of Kheperax: Python files with `Segment(Pos(x, y), Pos(x, y))`. Numbers, names of numbers and of lists, sums and products are
//! understood, and `for` over a list; the rest is reported. The walls of a list, of a dictionary's key, of a keyword or of a function are a maze
//! with its name, unless the file names them in another one.

use std::collections::{BTreeMap, BTreeSet};

use oneiro_base::exit::{Failure, Result};

use super::draft::{Draft, Outline, Start, Thing, failure};

/// mm for the side of a maze.
const SIDE: f64 = 1000.0;

/// A word, a sign or a text.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Token<'a> {
    line: usize,
    word: &'a str,
    /// The number of characters before it on its line if these are blanks.
    indent: Option<usize>,
}

/// What a name stands for.
#[derive(Clone, Debug)]
enum Value {
    Number(f64),
    List(Vec<f64>),
}

/// A maze of a file.
#[derive(Debug, Default)]
struct Maze {
    /// Empty if the file gives it none.
    name: String,
    line: usize,
    /// Line, and both ends.
    segments: Vec<(usize, [[f64; 2]; 2])>,
    /// Lines, what is not understood, and why.
    left_out: Vec<(usize, &'static str, String)>,
}

/// Reads the maze of a name, or the file's only one.
///
/// # Errors
/// Exit 3: the line, what is wrong, what is allowed.
pub(super) fn read(name: &str, text: &str, wanted: Option<&str>) -> Result<Draft> {
    let tokens = tokens(text);
    let mut mazes = mazes(&tokens);
    mazes.retain(|maze| !maze.segments.is_empty() || !maze.left_out.is_empty());
    let names: Vec<&str> = mazes.iter().map(|maze| &*maze.name).collect();
    let names = names.join(", ");
    let maze = match (wanted, mazes.len()) {
        (_, 0) => {
            let problem = "has no walls; allowed: mazes of Segment(Pos(X, Y), Pos(X, Y))";
            return Err(failure(name, 1, problem));
        }
        (None, 1) => &mazes[0],
        (None, _) => {
            return Err(Failure::input(format_args!(
                "{name}: has {} mazes; allowed: --maze with one of {names}",
                mazes.len()
            )));
        }
        (Some(wanted), _) => mazes.iter().find(|maze| maze.name == wanted).ok_or_else(|| {
            let allowed = if names.is_empty() {
                "none, since its only one has no name"
            } else {
                &names
            };
            Failure::input(format_args!(
                "--maze {wanted}: is no maze of {name}; allowed: {allowed}"
            ))
        })?,
    };
    if maze.segments.is_empty() {
        let (line, what, why) = &maze.left_out[0];
        return Err(failure(
            name,
            *line,
            format_args!("{what}: {why}; no wall of the maze is understood"),
        ));
    }
    let mut draft = Draft::new(name, "1 there, the side of a maze, is 1000 mm here.");
    for (line, what, why) in &maze.left_out {
        draft.leave_out(*line, *what, why.clone());
    }
    let outline = Outline::Rectangle {
        low: [0.0; 2],
        size: [SIDE; 2],
    };
    let what = match maze.name.as_str() {
        "" => "the maze".to_owned(),
        name => format!("the maze `{name}`"),
    };
    draft.enclose(outline, maze.line, what)?;
    for (line, ends) in &maze.segments {
        let [from, to] = ends.map(|end| end.map(|value| SIDE * value));
        if from == to {
            draft.leave_out(*line, "Segment", "it has no length");
        } else {
            draft.add(Thing::Wall { from, to }, *line, "Segment")?;
        }
    }
    draft.choose(("robot", "preset"), "\"kheperax\"", "The robot of Kheperax.");
    draft.choose(
        ("", "cycles"),
        "250",
        "The default of Kheperax, whose steps are cycles here.",
    );
    // Where Kheperax starts, if nothing else is said.
    let start = Start {
        line: maze.line,
        at: [150.0; 2],
        degrees: Some(90.0),
    };
    draft.start_at(vec![start], false);
    Ok(draft)
}

/// The words, signs and texts of a Python file, without comments.
fn tokens(text: &str) -> Vec<Token<'_>> {
    let mut tokens = Vec::new();
    let (mut at, mut line) = (0, 1);
    let mut indent = Some(0);
    let bytes = text.as_bytes();
    while at < bytes.len() {
        let rest = &text[at..];
        let first = rest.chars().next().unwrap_or(' ');
        let length = if first == '#' {
            rest.find('\n').unwrap_or(rest.len())
        } else if let Some(quotes) = ["\"\"\"", "'''", "\"", "'"]
            .iter()
            .find(|quotes| rest.starts_with(**quotes))
        {
            rest[quotes.len()..]
                .find(quotes)
                .map_or(rest.len(), |end| end + 2 * quotes.len())
        } else if first.is_ascii_digit() || first == '.' && bytes.get(at + 1).is_some_and(u8::is_ascii_digit) {
            let mut before = ' ';
            let end = rest.find(|c: char| {
                let is_sign = (c == '+' || c == '-') && (before == 'e' || before == 'E');
                before = c;
                !(c.is_ascii_alphanumeric() || c == '.' || c == '_' || is_sign)
            });
            end.unwrap_or(rest.len())
        } else if first.is_alphanumeric() || first == '_' {
            rest.find(|c: char| !(c.is_alphanumeric() || c == '_'))
                .unwrap_or(rest.len())
        } else {
            first.len_utf8()
        };
        let word = &rest[..length];
        if first == '\n' {
            indent = Some(0);
        } else if first.is_whitespace() {
            indent = indent.map(|indent| indent + 1);
        } else if first != '#' {
            let indent = indent.take();
            tokens.push(Token { line, word, indent });
        }
        line += word.matches('\n').count();
        at += length;
    }
    tokens
}

/// Reads tokens one after another.
struct Reader<'t, 'a> {
    tokens: &'t [Token<'a>],
    at: usize,
    values: BTreeMap<&'a str, Value>,
    /// How many walls are still read: loops have many.
    room: usize,
}

impl<'a> Reader<'_, 'a> {
    fn word(&self, ahead: usize) -> &'a str {
        self.tokens.get(self.at + ahead).map_or("", |token| token.word)
    }

    fn take(&mut self, word: &str) -> Option<()> {
        (self.word(0) == word).then(|| self.at += 1)
    }

    /// A sum.
    fn number(&mut self, depth: usize) -> Option<f64> {
        let mut sum = self.product(depth)?;
        loop {
            match self.word(0) {
                "+" => {
                    self.at += 1;
                    sum += self.product(depth)?;
                }
                "-" => {
                    self.at += 1;
                    sum -= self.product(depth)?;
                }
                _ => return sum.is_finite().then_some(sum),
            }
        }
    }

    fn product(&mut self, depth: usize) -> Option<f64> {
        let mut product = self.factor(depth)?;
        loop {
            match self.word(0) {
                "*" if self.word(1) != "*" => {
                    self.at += 1;
                    product *= self.factor(depth)?;
                }
                "/" if self.word(1) != "/" => {
                    self.at += 1;
                    product /= self.factor(depth)?;
                }
                _ => return Some(product),
            }
        }
    }

    fn factor(&mut self, depth: usize) -> Option<f64> {
        /// Deepest brackets.
        const DEEPEST: usize = 32;
        if depth > DEEPEST {
            return None;
        }
        match self.word(0) {
            "-" => {
                self.at += 1;
                Some(-self.factor(depth + 1)?)
            }
            "(" => {
                self.at += 1;
                let number = self.number(depth + 1)?;
                self.take(")")?;
                Some(number)
            }
            word if word.starts_with(|c: char| c.is_ascii_digit() || c == '.') => {
                self.at += 1;
                word.parse().ok().filter(|number: &f64| number.is_finite())
            }
            word => {
                let Value::Number(number) = self.values.get(word)? else {
                    return None;
                };
                let number = *number;
                self.at += 1;
                Some(number)
            }
        }
    }

    /// A list of numbers in brackets.
    fn list(&mut self) -> Option<Vec<f64>> {
        if let Some(Value::List(list)) = self.values.get(self.word(0)) {
            let list = list.clone();
            self.at += 1;
            return Some(list);
        }
        self.take("[").or_else(|| self.take("("))?;
        let mut list = Vec::new();
        while !["]", ")"].contains(&self.word(0)) {
            list.push(self.number(0)?);
            if !["]", ")"].contains(&self.word(0)) {
                self.take(",")?;
            }
        }
        self.at += 1;
        Some(list)
    }

    /// `Pos(x, y)`.
    fn place(&mut self) -> Option<[f64; 2]> {
        self.take("Pos")?;
        self.take("(")?;
        let x = self.number(0)?;
        self.take(",")?;
        let y = self.number(0)?;
        // A last comma is allowed.
        let _ = self.take(",");
        self.take(")")?;
        Some([x, y])
    }

    /// `Segment(Pos(..), Pos(..))`.
    fn segment(&mut self) -> Option<[[f64; 2]; 2]> {
        self.room = self.room.checked_sub(1)?;
        self.take("Segment")?;
        self.take("(")?;
        let from = self.place()?;
        self.take(",")?;
        let to = self.place()?;
        let _ = self.take(",");
        self.take(")")?;
        Some([from, to])
    }

    /// A segment for each value of `for NAME in LIST` after it; one if there is none.
    fn segments(&mut self) -> Option<Vec<[[f64; 2]; 2]>> {
        let begin = self.at;
        let end = self.closed(begin + 1);
        let loops = self.tokens.get(end).is_some_and(|token| token.word == "for");
        if !loops {
            return Some(vec![self.segment()?]);
        }
        self.at = end + 1;
        let name = self.word(0);
        self.at += 1;
        self.take("in")?;
        let list = self.list()?;
        let after = self.at;
        let before = self.values.get(name).cloned();
        let (mut segments, mut is_understood) = (Vec::new(), true);
        for value in list {
            self.values.insert(name, Value::Number(value));
            self.at = begin;
            let Some(segment) = self.segment() else {
                is_understood = false;
                break;
            };
            segments.push(segment);
        }
        match before {
            Some(before) => self.values.insert(name, before),
            None => self.values.remove(name),
        };
        self.at = after;
        is_understood.then_some(segments)
    }

    /// The index after the bracket that closes the one at `open`.
    fn closed(&self, open: usize) -> usize {
        let mut depth = 0_usize;
        for (index, token) in self.tokens.iter().enumerate().skip(open) {
            match token.word {
                "(" | "[" | "{" => depth += 1,
                ")" | "]" | "}" => depth = depth.saturating_sub(1),
                _ => (),
            }
            if depth == 0 {
                return index + 1;
            }
        }
        self.tokens.len()
    }
}

/// Where in the file the walls that are being read stand.
#[derive(Default)]
struct Around<'a> {
    /// For each open bracket its line, and the name that it has: of a list, a dictionary's key, a keyword or a maze.
    brackets: Vec<(usize, Option<&'a str>)>,
    /// The list that the statement is about.
    target: Option<(usize, &'a str)>,
    function: Option<(usize, &'a str)>,
    /// The word that begins a statement on which it depends whether others are run.
    condition: Option<&'a str>,
}

impl<'a> Around<'a> {
    /// The maze's line and name; none if nothing names it.
    fn maze(&self) -> (usize, &'a str) {
        // `segments=[..]` of a maze that has a name.
        let is_name = |name: &str| {
            let name = name.to_lowercase();
            !(name.contains("segment") || name.contains("wall"))
        };
        let brackets = self.brackets.iter().rev();
        let bracket = brackets
            .filter_map(|(line, name)| Some((*line, (*name)?)))
            .find(|(_, name)| is_name(name));
        bracket
            .or(self.target.filter(|(_, name)| is_name(name)))
            .or(self.function)
            .or(self.target)
            .unwrap_or((1, ""))
    }

    /// Begins a statement.
    fn statement(&mut self, reader: &Reader<'_, 'a>, indent: usize) {
        let token = reader.tokens[reader.at];
        self.target = None;
        if indent == 0 {
            self.function = None;
            if !["elif", "else", "except", "finally"].contains(&token.word) {
                self.condition = None;
            }
        }
        match token.word {
            "def" => self.function = Some((token.line, reader.word(1))),
            "if" | "elif" | "else" | "while" | "try" | "except" => self.condition = Some(token.word),
            word if is_identifier(word) => {
                // `NAME =`, `NAME +=`, `NAME.append(`
                let is_set = reader.word(1) == "=" || reader.word(1) == "+" && reader.word(2) == "=";
                let is_added = reader.word(1) == "." && ["append", "extend"].contains(&reader.word(2));
                // `MAZES["name"] =`
                let key = quoted(reader.word(2)).filter(|_| reader.word(1) == "[" && reader.word(4) == "=");
                self.target = key
                    .or((is_set || is_added).then_some(word))
                    .map(|name| (token.line, name));
            }
            _ => {}
        }
    }

    /// Opens a bracket.
    fn open(&mut self, reader: &Reader<'_, 'a>) {
        let before = |back: usize| reader.at.checked_sub(back).map_or("", |at| reader.tokens[at].word);
        let name = match (before(2), before(1)) {
            (key, ":") => quoted(key),
            (word, "=") if is_identifier(word) => Some(word),
            (_, callee) if callee.starts_with("register") && reader.word(0) == "(" => {
                let named = usize::from(reader.word(1) == "name" && reader.word(2) == "=") * 2;
                let word = reader.word(1 + named);
                Some(quoted(word).unwrap_or(word))
            }
            _ => None,
        };
        self.brackets.push((reader.tokens[reader.at].line, name));
    }
}

fn is_identifier(word: &str) -> bool {
    word.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// The maze with a name, which is a new one if there is none yet.
fn named<'m>(mazes: &'m mut Vec<Maze>, (line, name): (usize, &str)) -> &'m mut Maze {
    let at = mazes.iter().position(|maze| maze.name == name).unwrap_or_else(|| {
        mazes.push(Maze {
            name: name.to_owned(),
            line,
            ..Maze::default()
        });
        mazes.len() - 1
    });
    &mut mazes[at]
}

fn mazes(tokens: &[Token<'_>]) -> Vec<Maze> {
    /// Most walls of a file.
    const MOST: usize = 10_000;
    let mut reader = Reader {
        tokens,
        at: 0,
        values: BTreeMap::new(),
        room: MOST,
    };
    let mut around = Around::default();
    let mut mazes: Vec<Maze> = Vec::new();
    // Lists and functions, which others may name; and those that others have named.
    let (mut variables, mut used) = (BTreeSet::new(), BTreeSet::new());
    while let Some(token) = tokens.get(reader.at) {
        let begin = reader.at;
        if let (Some(indent), true) = (token.indent, around.brackets.is_empty()) {
            around.statement(&reader, indent);
            variables.extend(around.function.map(|(_, name)| name));
            variables.extend(around.target.map(|(_, name)| name));
        }
        let is_call = reader.word(1) == "(";
        let is_set = reader.word(1) == "=" && reader.word(2) != "=";
        match token.word {
            // Where the class is defined or imported it is no wall.
            "class" | "def" | "import" => {
                // Parameters have no known numbers.
                let end = reader.closed(begin + 2);
                for word in tokens[begin..end.min(tokens.len())].iter().map(|token| token.word) {
                    reader.values.remove(word);
                }
                reader.at += 2;
            }
            "for" => {
                reader.values.remove(reader.word(1));
                reader.at += 1;
            }
            "Segment" if is_call => {
                let found = reader.segments();
                let maze = named(&mut mazes, around.maze());
                let mut leave_out = |why: &str| maze.left_out.push((token.line, "Segment", why.to_owned()));
                if found.is_some() && reader.word(0) == "." {
                    leave_out("its method after `.` is not understood");
                } else if let Some(found) = found {
                    if let Some(word) = around.condition {
                        let why = format!("whether it is there, by `{word}`, is not understood; it is here");
                        maze.left_out.push((token.line, "Segment's condition", why));
                    }
                    maze.segments.extend(found.into_iter().map(|ends| (token.line, ends)));
                } else {
                    leave_out(
                        "its numbers are not understood; allowed: numbers, names of numbers, + - * /, `for` over a list",
                    );
                    reader.at = reader.closed(begin + 1);
                }
            }
            "target_pos" | "target_radius" | "\"target_pos\"" | "\"target_radius\""
                if ["=", ":"].contains(&reader.word(1)) =>
            {
                let is_place = token.word.contains("pos");
                reader.at += 2;
                let found = if is_place {
                    reader.list()
                } else {
                    reader.number(0).map(|number| vec![number])
                };
                let what = if is_place { "target_pos" } else { "target_radius" };
                let shown = found.map_or(String::new(), |found| {
                    let values: Vec<String> = found.iter().map(|value| super::draft::number(SIDE * value)).collect();
                    format!(", here {} mm", values.join(", "))
                });
                let why = format!("the task has the target{shown}: docs/classics/kheperax.md");
                let (_, name) = around.maze();
                if let Some(maze) = mazes.iter_mut().find(|maze| maze.name == name) {
                    maze.left_out.push((token.line, what, why));
                }
            }
            "(" | "[" | "{" => {
                around.open(&reader);
                reader.at += 1;
            }
            ")" | "]" | "}" => {
                around.brackets.pop();
                reader.at += 1;
            }
            word if is_identifier(word) && is_set && around.brackets.is_empty() => {
                reader.at += 2;
                let value = reader.at;
                let found = reader.list().map(Value::List);
                let found = found.or_else(|| {
                    reader.at = value;
                    reader.number(0).map(Value::Number)
                });
                // A number is the whole value, whatever the file decides.
                let is_whole = tokens.get(reader.at).is_none_or(|next| next.indent.is_some());
                if let Some(found) = found.filter(|_| is_whole && around.condition.is_none()) {
                    reader.values.insert(word, found);
                } else {
                    reader.values.remove(word);
                    reader.at = value;
                }
            }
            // The walls of another list.
            word if variables.contains(word) && !is_set && around.maze().1 != word => {
                let other = mazes.iter().find(|maze| maze.name == word);
                if let Some((segments, left_out)) = other.map(|maze| (maze.segments.clone(), maze.left_out.clone())) {
                    let maze = named(&mut mazes, around.maze());
                    if let Some(room) = reader.room.checked_sub(segments.len()) {
                        reader.room = room;
                        maze.segments.extend(segments);
                        maze.left_out.extend(left_out);
                    } else {
                        let why = format!("there are more than {MOST} walls");
                        maze.left_out.push((token.line, "another maze's walls", why));
                    }
                    used.insert(word);
                }
                reader.at += 1;
            }
            _ => reader.at += 1,
        }
        // Each token is read once.
        reader.at = reader.at.max(begin + 1);
    }
    mazes.retain(|maze| !used.contains(&*maze.name));
    mazes
}

/// The text between quotation marks.
fn quoted(word: &str) -> Option<&str> {
    let quote = word.chars().next().filter(|c| *c == '"' || *c == '\'')?;
    word.strip_prefix(quote)?.strip_suffix(quote)
}
