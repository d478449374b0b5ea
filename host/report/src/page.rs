//! Just enough HTML: a document, sections, figures and tables. Arguments named text are escaped here; those named HTML
//! were escaped where they were made.

mod scheme;

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use oneiro_base::disk;
use oneiro_base::exit::Result;

use crate::bundle::bundle;
use crate::figures::escaped;
pub use scheme::dark_rules;

/// The folder beside a page that has its figures as files.
pub const FIGURES: &str = "figures";
/// What it holds, for descriptions of directories.
pub const FIGURES_ABOUT: &str = "the report's figures, each as a standalone SVG file, named as in the report";

/// Style of the page on screen and on paper.
const STYLE: &str = include_str!("page/style.css");

/// A section of the document.
pub struct Section {
    /// Target of links.
    id: Cow<'static, str>,
    title: Cow<'static, str>,
    /// Its content, as HTML.
    body: String,
}

impl Section {
    pub fn new(id: impl Into<Cow<'static, str>>, title: impl Into<Cow<'static, str>>, body: String) -> Self {
        Self {
            id: id.into(),
            title: title.into(),
            body,
        }
    }
}

/// The whole file: the title, the lead below it as HTML, and the sections with links to them.
pub fn document(title: &str, lead: &str, sections: &[Section]) -> String {
    let title = escaped(title);
    let dark = scheme::rules(&sections.iter().map(|own| own.body.as_str()).collect::<String>());
    let links = joined(sections, |section| {
        format!("<a href=\"#{}\">{}</a>\n", section.id, escaped(&section.title))
    });
    let body = joined(sections, |Section { id, title, body }| {
        format!("<section id=\"{id}\">\n<h2>{}</h2>\n{body}</section>\n", escaped(title))
    });
    let script = if sections.len() > 1 || body.contains(" data-plot=") {
        format!("<script type=\"module\">\n{}</script>\n", bundle("report"))
    } else {
        String::new()
    };
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <title>{title}</title>\n<style>\n{STYLE}{dark}</style>\n</head>\n<body>\n<header>\n<h1>{title}</h1>\n{lead}\
         </header>\n<nav>\n{links}</nav>\n<main>\n{body}</main>\n{script}</body>\n</html>\n"
    )
}

/// Writes a page that [`document`] made, and [its figures](figures) into a folder beside it. Returns their paths, the page's first.
///
/// # Errors
/// Exit 3 if a link or a file has the folder's name; exit 6 if writing fails.
pub fn write(directory: &Path, name: &str, html: &str) -> Result<Vec<PathBuf>> {
    let mut paths = vec![directory.join(name)];
    disk::write(&paths[0], html.as_bytes())?;
    let mut figures = figures(html).peekable();
    if figures.peek().is_some() {
        let folder = disk::make_folder(directory, FIGURES)?;
        for (name, svg) in figures {
            let path = folder.join(format!("{name}.svg"));
            disk::write(&path, svg.as_bytes())?;
            paths.push(path);
        }
    }
    Ok(paths)
}

/// The figures of a page: the target of each one's links, and its picture, an SVG file that needs nothing of the page.
pub fn figures(html: &str) -> impl Iterator<Item = (&str, &str)> {
    let figures = html.split(FIGURE).skip(1);
    figures.filter_map(|figure| {
        let (name, rest) = figure.split_once("\">\n")?;
        let (svg, _) = rest.split_once(CAPTION)?;
        Some((name, svg))
    })
}

/// How a figure begins, and its caption.
const FIGURE: &str = "<figure id=\"";
const CAPTION: &str = "<figcaption>";

/// A paragraph of text.
pub fn paragraph(text: &str) -> String {
    format!("<p>{}</p>\n", escaped(text))
}

/// Text that may break after the dots and slashes of a long name; copying it leaves the name intact.
pub fn breakable(text: &str) -> String {
    let mut html = String::new();
    let mut rest = text;
    while let Some(place) = rest.find(['_', '.', '/']) {
        let (before, after) = rest.split_at(place + 1);
        html.push_str(&escaped(before));
        // Numbers and abbreviations aren't broken.
        let letters = |side: &[u8]| side.len() == 2 && side.iter().all(u8::is_ascii_alphabetic);
        let (left, right) = (&before.as_bytes()[place.saturating_sub(2)..place], after.as_bytes());
        if letters(left) && letters(&right[..right.len().min(2)]) {
            html.push_str("<wbr/>");
        }
        rest = after;
    }
    html + &escaped(rest)
}

/// A picture with its name, such as `Figure 6`, and a caption.
pub fn figure(name: &str, words: &str, svg: &str) -> String {
    format!(
        "{FIGURE}{}\">\n{svg}{CAPTION}<b>{}.</b> {}</figcaption>\n</figure>\n",
        id(name),
        escaped(name),
        escaped(words)
    )
}

/// Converts a name into the target of a link.
pub fn id(name: &str) -> String {
    let words = name
        .split(|c: char| !c.is_ascii_alphanumeric())
        .filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join("-").to_ascii_lowercase()
}

/// Text after a dot in the given colour, as HTML.
pub fn dotted(colour: &str, text: &str) -> String {
    format!(
        "<span class=\"condition\"><span class=\"dot\" style=\"background:{colour}\"></span>{}</span>",
        escaped(text)
    )
}

/// A list of texts.
pub fn list(items: &[&str]) -> String {
    let items = joined(items, |item| format!("<li>{}</li>\n", escaped(item)));
    format!("<ul>\n{items}</ul>\n")
}

/// Names with their values, as HTML.
pub fn facts(facts: &[(&str, String)]) -> String {
    let facts = joined(facts, |(name, value)| {
        format!("<dt>{}</dt><dd>{}</dd>\n", escaped(name), escaped(value))
    });
    format!("<dl class=\"facts\">\n{facts}</dl>\n")
}

/// A cell of a table.
pub struct Cell {
    html: String,
    class: &'static str,
    /// Number of columns that it spans.
    columns: usize,
}

impl Cell {
    /// Text.
    pub fn text(text: &str) -> Self {
        Self::html(escaped(text))
    }

    /// A name: short ones aren't broken, long ones may be.
    pub fn name(text: &str) -> Self {
        const SHORT: usize = 24;
        let is_short = text.chars().count() <= SHORT;
        Self {
            class: if is_short { "short" } else { "long" },
            ..Self::html(breakable(text))
        }
    }

    /// HTML, aligned like text.
    pub fn html(html: String) -> Self {
        Self {
            html,
            class: "",
            columns: 1,
        }
    }

    /// HTML, aligned like a number.
    pub fn number(html: String) -> Self {
        Self {
            class: "number",
            ..Self::html(html)
        }
    }

    /// Text that spans several columns.
    pub fn across(columns: usize, text: &str) -> Self {
        Self {
            columns,
            ..Self::text(text)
        }
    }

    /// A name in a program.
    pub fn code(text: &str) -> Self {
        Self::html(format!("<code>{}</code>", escaped(text)))
    }
}

/// A row of a table.
pub struct Row {
    pub cells: Vec<Cell>,
    /// Whether the row sums up others.
    pub sum: bool,
}

impl Row {
    fn html(&self) -> String {
        let class = if self.sum { " class=\"sum\"" } else { "" };
        let cells = joined(&self.cells, |Cell { html, class, columns }| {
            let class = if class.is_empty() {
                String::new()
            } else {
                format!(" class=\"{class}\"")
            };
            let columns = if *columns == 1 {
                String::new()
            } else {
                format!(" colspan=\"{columns}\"")
            };
            format!("<td{class}{columns}>{html}</td>")
        });
        format!("<tr{class}>{cells}</tr>\n")
    }
}

impl From<Vec<Cell>> for Row {
    fn from(cells: Vec<Cell>) -> Self {
        Self { cells, sum: false }
    }
}

/// A column's heading.
#[derive(Clone, Copy)]
pub enum Head<'a> {
    /// Heading of a column of text.
    Text(&'a str),
    /// Heading of a column of numbers.
    Number(&'a str),
    /// Heading of two columns of numbers: simulated and real.
    Pair(&'a str),
}

impl Head<'_> {
    fn columns(&self) -> usize {
        if let Self::Pair(_) = self { 2 } else { 1 }
    }
}

/// A table of more rows scrolls in its box, below its head.
const MANY: usize = 24;

/// A table with a name and a text above it, either of which may be empty. An empty table has a line that explains it.
pub fn table(name: &str, words: &str, head: &[Head<'_>], rows: &[Row]) -> String {
    let (id, name) = if name.is_empty() {
        (String::new(), String::new())
    } else {
        (format!(" id=\"{}\"", id(name)), format!("<b>{}.</b> ", escaped(name)))
    };
    let caption = if name.is_empty() && words.is_empty() {
        String::new()
    } else {
        format!("<caption>{name}{}</caption>\n", escaped(words))
    };
    let columns: usize = head.iter().map(Head::columns).sum();
    let body = if rows.is_empty() {
        format!("<tr><td colspan=\"{columns}\" class=\"nothing\">nothing recorded</td></tr>\n")
    } else {
        joined(rows, Row::html)
    };
    let head = headings(head);
    let many = if rows.len() > MANY { " many" } else { "" };
    format!("<div class=\"scroll{many}\">\n<table{id}>\n{caption}{head}<tbody>\n{body}</tbody>\n</table>\n</div>\n")
}

/// Joins the HTML of all items.
pub fn joined<T>(items: &[T], html: impl Fn(&T) -> String) -> String {
    items.iter().map(html).collect::<Vec<_>>().concat()
}

/// One row of headings, or two if there are pairs.
fn headings(head: &[Head<'_>]) -> String {
    let pairs = head.iter().any(|head| matches!(head, Head::Pair(_)));
    let rows = if pairs { " rowspan=\"2\"" } else { "" };
    let first = joined(head, |head| match head {
        Head::Text(words) => format!("<th{rows}>{}</th>", breakable(words)),
        Head::Number(words) => format!("<th{rows} class=\"number\">{}</th>", breakable(words)),
        Head::Pair(words) => format!("<th colspan=\"2\" class=\"pair\">{}</th>", escaped(words)),
    });
    let second = joined(head, |head| match head {
        Head::Pair(_) => "<th class=\"number\">sim.</th><th class=\"number\">real</th>".to_owned(),
        Head::Text(_) | Head::Number(_) => String::new(),
    });
    if pairs {
        format!("<thead>\n<tr>{first}</tr>\n<tr>{second}</tr>\n</thead>\n")
    } else {
        format!("<thead>\n<tr>{first}</tr>\n</thead>\n")
    }
}

/// Checks that the tests of all reports share.
#[cfg(any(test, feature = "testing"))]
pub mod check {
    /// The page without the text of its scripts, and that text.
    fn without_scripts(html: &str) -> (String, String) {
        let mut pieces = html.split("<script");
        let (mut page, mut scripts) = (pieces.next().unwrap_or_default().to_owned(), String::new());
        for piece in pieces {
            let (attributes, rest) = piece.split_once('>').unwrap_or((piece, ""));
            let (script, rest) = rest.split_once("</script>").unwrap_or((rest, ""));
            page.extend(["<script", attributes, "></script>", rest]);
            scripts += script;
        }
        (page, scripts)
    }

    /// The first tag that isn't closed or doesn't close anything, or that is shown as text, since it was escaped.
    pub fn unbalanced(html: &str) -> Option<String> {
        const SHOWN: [&str; 5] = [
            "&lt;/b&gt;",
            "&lt;/i&gt;",
            "&lt;/code&gt;",
            "&lt;/a&gt;",
            "&lt;/span&gt;",
        ];
        let html = &without_scripts(html).0;
        if let Some(shown) = SHOWN.iter().find(|tag| html.contains(**tag)) {
            return Some((*shown).to_owned());
        }
        let mut open = Vec::new();
        for piece in html.split('<').skip(1) {
            let Some((tag, _)) = piece.split_once('>') else {
                return Some(piece.to_owned());
            };
            let name = tag.split_whitespace().next().unwrap_or_default().trim_end_matches('/');
            if tag.starts_with('!') || tag.ends_with('/') {
                continue;
            }
            if let Some(closed) = name.strip_prefix('/') {
                if open.pop() != Some(closed) {
                    return Some(tag.to_owned());
                }
            } else {
                open.push(name);
            }
        }
        open.pop().map(str::to_owned)
    }

    /// Content of the element with an id, up to its end tag.
    pub fn part<'a>(html: &'a str, element: &str, id: &str) -> &'a str {
        let start = html
            .find(&format!("<{element} id=\"{id}\""))
            .unwrap_or_else(|| panic!("no {element} {id}"));
        let end = html[start..].find(&format!("</{element}>")).expect("it ends");
        &html[start..start + end]
    }

    /// The first thing on the page that would be fetched from elsewhere. Scripts may be on the page itself.
    pub fn outside(html: &str) -> Option<&'static str> {
        let (page, scripts) = without_scripts(html);
        let fetches = ["<img", "<link", "src=", "url(", "@import"];
        let loads = [
            "import ",
            "import(",
            "fetch(",
            "Request",
            "WebSocket",
            "EventSource",
            ".src",
        ];
        let of_page = fetches.into_iter().find(|outside| page.contains(outside));
        of_page.or_else(|| loads.into_iter().find(|outside| scripts.contains(outside)))
    }

    #[test]
    fn only_scripts_on_the_page_itself_are_allowed() {
        assert_eq!(
            outside("<p>a</p><script type=\"module\">a < b; 'url(#a)'</script>"),
            None
        );
        assert_eq!(outside("<script src=\"a.js\"></script>"), Some("src="));
        assert_eq!(outside("<script>fetch('a')</script>"), Some("fetch("));
        assert_eq!(outside("<script>let a;</script><img/>"), Some("<img"));
        assert_eq!(unbalanced("<p><script>a < b</script></p>"), None);
    }

    #[test]
    fn long_names_may_be_broken_and_numbers_not() {
        assert_eq!(super::breakable("noise.sensor_range"), "noise.<wbr/>sensor_<wbr/>range");
        assert_eq!(super::breakable("s.d. 0.25 a/b"), "s.d. 0.25 a/b");
        assert_eq!(
            super::breakable("<in>/\u{e9}t\u{e9}.toml"),
            "&lt;in&gt;/\u{e9}t\u{e9}.toml"
        );
        assert_eq!(super::breakable("my/files.toml"), "my/<wbr/>files.<wbr/>toml");
    }

    #[test]
    fn unbalanced_tags_are_detected() {
        assert_eq!(unbalanced("<p>a <b>c</b><br/></p>"), None);
        assert_eq!(unbalanced("<p><b>c</p></b>"), Some("/p".into()));
        assert_eq!(unbalanced("<p><b>c</b>"), Some("p".into()));
        assert_eq!(unbalanced("<p>&lt;b&gt;c&lt;/b&gt;</p>"), Some("&lt;/b&gt;".into()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::{Band, Panel, Series, Spread, bands, browser, evenly, learning_curve};

    /// Each figure is a file by itself: SVG with its name space, size, font and colours, and no style of the page.
    #[test]
    fn figures_of_a_page_are_files() {
        let line = Series {
            label: "a < b",
            values: vec![1.0, 2.0],
        };
        let svg = learning_curve("t", "fitness", &[line], None);
        let body =
            figure("Figure 1", "A <figure id=\"x\">.", &svg) + &paragraph("between") + &figure("Pair 2, n", "B.", &svg);
        let html = document("t", "", &[Section::new("all", "All", body)]);
        let found: Vec<(&str, &str)> = figures(&html).collect();
        assert_eq!(found, [("figure-1", svg.as_str()), ("pair-2-n", svg.as_str())]);
        assert!(svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\" width=") && svg.contains("font-family="));
        assert!(!svg.contains("class=") && svg.ends_with("</svg>\n"));
        assert_eq!(figures(&document("t", "", &[])).count(), 0);
    }

    /// Hidden lines leave their room to the shown ones, as long as the reader does not zoom.
    #[test]
    fn short_lines_get_the_room_of_hidden_ones() {
        let line = |label, count: u32| Series {
            label,
            values: (0..count).map(f64::from).collect(),
        };
        let curve = learning_curve("t", "fitness", &[line("long", 101), line("short", 3)], None);
        let html = document("t", "", &[Section::new("one", "One", figure("Figure 1", "A.", &curve))]);
        let ask = "
            await new Promise((then) => setTimeout(then, 100));
            const svg = document.querySelector('svg');
            const box = document.querySelector('.chart-values');
            const right = Number(svg.querySelector('[data-plot]').dataset.plot.split(' ')[1]);
            const read = () => {
                const place = new DOMPoint(right, 100).matrixTransform(svg.getScreenCTM());
                svg.dispatchEvent(new PointerEvent('pointermove', { clientX: place.x, clientY: place.y, pointerType: 'mouse', bubbles: true }));
                const ends = svg.querySelectorAll('polyline')[1].getAttribute('points').split(' ').pop().split(',')[0];
                return [box.textContent, Number(ends) === right];
            };
            const toggle = () => svg.querySelector('text[data-series=long]').dispatchEvent(new MouseEvent('click', { bubbles: true }));
            const all = read();
            toggle();
            const short = read();
            toggle();
            return { all, short, again: read() };";
        let Some(told) = browser::told("room", &html, ask) else {
            return;
        };
        let expected = serde_json::json!({
            "all": ["generation 100long: 100", false],
            "short": ["generation 2short: 2", true],
            "again": ["generation 100long: 100", false],
        });
        assert_eq!(told, expected);
    }

    /// A pointer reads the values of visible lines and bands; names hide lines; a drag zooms, and Escape shows everything again.
    #[test]
    fn charts_answer_a_pointer_and_the_keyboard() {
        let line = |label, values: [f64; 5]| Series {
            label,
            values: values.to_vec(),
        };
        let curve = learning_curve(
            "t",
            "fitness",
            &[
                line("best", [0.0, 25.0, 50.0, 75.0, 100.0]),
                line("mean", [0.0, 10.0, 20.0, f64::NAN, 40.0]),
            ],
            Some(&[30, 50, 60, 65, 70]),
        );
        let spread = |mean| Spread {
            low: mean - 1.0,
            mean,
            high: mean + 2.0,
        };
        let band = bands(
            "b",
            &[Panel {
                across: "time",
                up: "food",
                to: 2.0,
                high: 10.0,
                bands: vec![Band {
                    label: "",
                    colour: "#123456",
                    dash: "",
                    values: evenly(0.0, 1.0, [4.0, 6.0, 8.0].map(spread)),
                }],
                ..Panel::default()
            }],
        );
        let body = figure("Figure 1", "A.", &curve) + &figure("Figure 2", "B.", &band);
        let sections = ["one", "two"].map(|id| Section::new(id, id, body.replace("figure-", id)));
        let html = document("t", "", &sections);
        assert_eq!(html.matches("<script").count(), 1);
        assert_eq!((check::unbalanced(&html), check::outside(&html)), (None, None));
        let ask = "
            await new Promise((then) => setTimeout(then, 100));
            const charts = document.querySelectorAll('svg');
            const box = document.querySelector('.chart-values');
            const at = (svg, kind, x, y) => {
                const place = new DOMPoint(x, y).matrixTransform(svg.getScreenCTM());
                svg.setPointerCapture = () => {};
                svg.dispatchEvent(new PointerEvent(kind, { clientX: place.x, clientY: place.y, pointerType: 'mouse', bubbles: true }));
            };
            const [left, right] = charts[0].querySelector('[data-plot]').dataset.plot.split(' ').map(Number);
            const x = (part) => left + part * (right - left);
            const read = () => (box.hidden ? 'hidden' : [...box.children].map((row) => row.textContent).join('; '));
            at(charts[0], 'pointermove', x(0.24), 100);
            const values = read();
            at(charts[0], 'pointermove', x(0.75), 100);
            const gap = read();
            const name = charts[0].querySelector('text[data-series=best]');
            name.dispatchEvent(new KeyboardEvent('keydown', { key: 'Enter', bubbles: true }));
            at(charts[0], 'pointermove', x(0.24), 100);
            const without = read();
            const pressed = name.getAttribute('aria-pressed');
            name.dispatchEvent(new MouseEvent('click', { bubbles: true }));
            const points = () => charts[0].querySelector('polyline').getAttribute('points');
            const before = points();
            at(charts[0], 'pointerdown', x(0.5), 100);
            at(charts[0], 'pointermove', x(0.75), 100);
            at(charts[0], 'pointerup', x(1), 100);
            const isZoomed = points() !== before;
            at(charts[0], 'pointermove', x(0), 100);
            const zoomed = read();
            document.dispatchEvent(new KeyboardEvent('keydown', { key: 'Escape' }));
            const isReset = points() === before;
            const plot = charts[1].querySelector('[data-plot]');
            for (const key of ['End', 'ArrowLeft']) plot.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));
            const bandRead = read();
            const axes = [...charts[0].querySelectorAll('.chart-axis')].reverse();
            const toggles = axes.map((own) => `${own.textContent} ${own.getAttribute('aria-pressed')}`).join();
            charts[2].querySelector('.chart-axis').dispatchEvent(new KeyboardEvent('keydown', { key: 'Enter', bubbles: true }));
            at(charts[0], 'pointermove', x(0), 100);
            at(charts[0], 'pointermove', x(50 / 70), 100);
            const spent = read();
            const current = document.querySelector('nav [aria-current]').textContent;
            return { values, gap, without, pressed, isZoomed, zoomed, isReset, band: bandRead, toggles, spent, current };";
        let Some(told) = browser::told("charts", &html, ask) else {
            return;
        };
        let expected = serde_json::json!({
            "values": "generation 1; best: 25; mean: 10",
            "gap": "generation 3; best: 75",
            "without": "generation 1; mean: 10",
            "pressed": "false",
            "isZoomed": true,
            "zoomed": "generation 2; best: 50; mean: 20",
            "isReset": true,
            "band": "time 1; food: 6 (5 to 8)",
            "toggles": "generation true,episodes spent false",
            "spent": "episodes spent 50; best: 25; mean: 10",
            "current": "one",
        });
        assert_eq!(told, expected);
    }
}
