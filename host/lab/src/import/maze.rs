//! Mazes of novelty search as texts: the number of walls, a start, a heading, a goal, and the ends of each wall. A line that begins
//! with `#` is a comment.

use oneiro_base::exit::Result;

use super::draft::{Draft, Outline, Start, Thing, failure, turned};

/// mm for a unit: the maze's robot has a radius of 8 units, that of Kheperax of 15 mm.
const UNIT: f64 = 2.0;
/// Places that are allowed, units.
const PLACES: f64 = 50_000.0;

/// Reads a file.
///
/// # Errors
/// Exit 3: the line, what is wrong, what is allowed.
pub(super) fn read(name: &str, text: &str) -> Result<Draft> {
    let mut draft = Draft::new(
        name,
        "1 unit there is 2 mm here: the maze's robot has a radius of 8 units, that of Kheperax of 15 mm.",
    );
    let mut lines = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        let mut numbers = Vec::new();
        for word in line
            .split(|c: char| c == ',' || c.is_whitespace())
            .filter(|word| !word.is_empty())
        {
            let parsed = word.parse().ok().filter(|number: &f64| number.abs() <= PLACES);
            let Some(number) = parsed else {
                let shown: String = word.chars().take(24).collect();
                let problem = format_args!("`{shown}` is no number of a maze; allowed: -{PLACES} to {PLACES}");
                return Err(failure(name, index + 1, problem));
            };
            numbers.push(number);
        }
        if !numbers.is_empty() {
            lines.push((index + 1, numbers));
        }
    }
    let ended = text.lines().count().max(1);
    let mut rest = lines.into_iter().peekable();
    let mut heads = Vec::new();
    while let Some(head) = rest.next_if(|(_, numbers)| numbers.len() == 1) {
        heads.push(head);
    }
    let Some((count_line, count)) = heads.pop() else {
        let line = rest.peek().map_or(ended, |(line, _)| *line);
        return Err(failure(
            name,
            line,
            "is no maze; allowed: first the number of walls, in a line",
        ));
    };
    for (line, _) in heads {
        draft.leave_out(
            line,
            "a number before that of walls",
            "it is no part of the maze; set cycles",
        );
    }
    let mut line_of = |wanted: usize, what: &str| match rest.next() {
        Some((line, numbers)) if numbers.len() == wanted => Ok((line, numbers)),
        Some((line, numbers)) => Err(failure(
            name,
            line,
            format_args!("has {} numbers; allowed: {wanted}, {what}", numbers.len()),
        )),
        None => Err(failure(name, ended, format_args!("ends early; missing: {what}"))),
    };
    let (line, at) = line_of(2, "x and y of the start")?;
    let (_, heading) = line_of(1, "the heading in degrees")?;
    let start = Start {
        line,
        at: [UNIT * at[0], UNIT * at[1]],
        degrees: Some(turned(heading[0])),
    };
    while let Some((line, goal)) = rest.next_if(|(_, numbers)| numbers.len() == 2) {
        let why = format!(
            "the task has the goal, here at {} and {} mm: docs/classics/kheperax.md",
            UNIT * goal[0],
            UNIT * goal[1]
        );
        draft.leave_out(line, "the goal", why);
    }
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let mut walls = Vec::new();
    for (line, ends) in rest {
        let [a, b, c, d] = ends[..] else {
            let problem = format_args!("has {} numbers; allowed: 4, x and y of both ends of a wall", ends.len());
            return Err(failure(name, line, problem));
        };
        let [from, to] = [[a, b], [c, d]].map(|end| end.map(|value| UNIT * value));
        for end in [from, to] {
            low = [0, 1].map(|axis| low[axis].min(end[axis]));
            high = [0, 1].map(|axis| high[axis].max(end[axis]));
        }
        if from == to {
            draft.leave_out(line, "a wall", "it has no length");
        } else {
            walls.push((line, from, to));
        }
    }
    let found = walls.len();
    if found == 0 {
        return Err(failure(
            name,
            ended,
            "has no walls; allowed: lines with x and y of both ends",
        ));
    }
    if count[0] != found as f64 {
        let why = format!("the number is {}, but {found} walls follow; these are taken", count[0]);
        draft.leave_out(count_line, "the number of walls", why);
    }
    let size = [0, 1].map(|axis| high[axis] - low[axis]);
    draft.enclose(
        Outline::Walled { low, size },
        walls[0].0,
        "all walls are within this rectangle",
    )?;
    for (line, from, to) in walls {
        draft.add(Thing::Wall { from, to }, line, "a wall")?;
    }
    draft.choose(
        ("robot", "preset"),
        "\"kheperax\"",
        "The file names no robot: that of Kheperax stands here, another with lasers in a maze.",
    );
    draft.leave_out(
        line,
        "the robot",
        "the file doesn't describe it; that of Kheperax stands there: set robot.preset",
    );
    draft.start_at(vec![start], false);
    Ok(draft)
}
