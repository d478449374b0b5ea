//! Just enough SVG: elements with attributes, numbers with two decimals, escaped text.

use std::fmt::Write;

use crate::numbers::fixed;

/// Fonts of all text.
const FONT: &str = "system-ui, -apple-system, 'Segoe UI', 'Helvetica Neue', 'DejaVu Sans', Arial, sans-serif";
/// Colour of text and axes.
pub const INK: &str = "#33363f";
/// Colour of secondary text.
pub const SOFT_INK: &str = "#6b6e76";
/// Styles of text: a heading, other text, and secondary text.
pub const BOLD: &str = "fill=\"#33363f\" font-weight=\"600\"";
pub const PLAIN: &str = "fill=\"#33363f\"";
pub const SOFT: &str = "fill=\"#6b6e76\"";

/// Alignment of a text relative to its point.
#[derive(Clone, Copy)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

/// A picture in the making, in pixels, with y down.
pub struct Svg {
    text: String,
}

impl Svg {
    /// A white sheet; screen readers read its title aloud.
    pub fn new(width: f64, height: f64, title: &str) -> Self {
        let mut text = String::new();
        let (width, height) = (number(width), number(height));
        // Writing to a string can't fail.
        let _ = write!(
            text,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" role=\"img\" font-family=\"{FONT}\">\n<title>{}</title>\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n",
            escaped(title),
        );
        Self { text }
    }

    /// Adds raw markup, such as `<g ..>` or its end tag.
    pub fn raw(&mut self, element: &str) {
        self.text.push_str(element);
        self.text.push('\n');
    }

    /// Draws a plot that a page's reader may exchange for others: a file shows the first. `draw` gets each one's place.
    pub fn choices(&mut self, names: &[&str], mut draw: impl FnMut(&mut Self, usize)) {
        for (place, name) in names.iter().enumerate() {
            let hidden = if place > 0 { " display=\"none\"" } else { "" };
            self.raw(&format!("<g data-choice=\"{}\"{hidden}>", escaped(name)));
            draw(self, place);
            self.raw("</g>");
        }
    }

    /// Draws what keeps its colours in the dark scheme of a page: shades of a scale, and what is written on them.
    pub fn kept(&mut self, draw: impl FnOnce(&mut Self)) {
        self.raw("<g data-kept=\"\">");
        draw(self);
        self.raw("</g>");
    }

    /// Draws a straight line.
    pub fn line(&mut self, from: (f64, f64), to: (f64, f64), style: &str) {
        self.raw(&format!(
            "<line x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\" {style}/>",
            number(from.0),
            number(from.1),
            number(to.0),
            number(to.1),
        ));
    }

    /// Draws a rectangle from its upper left corner.
    pub fn rectangle(&mut self, at: (f64, f64), size: (f64, f64), style: &str) {
        self.raw(&format!(
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" {style}/>",
            number(at.0),
            number(at.1),
            number(size.0),
            number(size.1),
        ));
    }

    /// Draws a circle with a tooltip.
    pub fn circle(&mut self, at: (f64, f64), radius: f64, style: &str, hint: &str) {
        let (x, y, radius) = (number(at.0), number(at.1), number(radius));
        if hint.is_empty() {
            self.raw(&format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" {style}/>"));
        } else {
            let hint = escaped(hint);
            self.raw(&format!(
                "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" {style}><title>{hint}</title></circle>"
            ));
        }
    }

    /// Draws a line through points, unfilled.
    pub fn polyline(&mut self, points: impl IntoIterator<Item = (f64, f64)>, style: &str) {
        let points = joined(points);
        self.raw(&format!("<polyline points=\"{points}\" fill=\"none\" {style}/>"));
    }

    /// Draws a filled polygon.
    pub fn polygon(&mut self, points: impl IntoIterator<Item = (f64, f64)>, style: &str) {
        let points = joined(points);
        self.raw(&format!("<polygon points=\"{points}\" {style}/>"));
    }

    /// Draws a line of text.
    pub fn words(&mut self, at: (f64, f64), size: f64, anchor: Anchor, style: &str, words: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        self.raw(&format!(
            "<text x=\"{}\" y=\"{}\" font-size=\"{}\" text-anchor=\"{anchor}\" {style}>{}</text>",
            number(at.0),
            number(at.1),
            number(size),
            escaped(words),
        ));
    }

    /// Draws a vertical line of text that reads upwards, centred on its point.
    pub fn turned(&mut self, (x, y): (f64, f64), size: f64, style: &str, words: &str) {
        let style = format!("{style} transform=\"rotate(-90 {} {})\"", number(x), number(y));
        self.words((x, y), size, Anchor::Middle, &style, words);
    }

    /// Draws a slanted line of text that rises to its point and ends there.
    pub fn askew(&mut self, (x, y): (f64, f64), size: f64, style: &str, words: &str) {
        let style = format!("{style} transform=\"rotate(-35 {} {})\"", number(x), number(y));
        self.words((x, y), size, Anchor::End, &style, words);
    }

    /// Returns the file's text.
    pub fn finish(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }
}

/// Formats points for the attribute `points`.
pub fn joined(points: impl IntoIterator<Item = (f64, f64)>) -> String {
    let points: Vec<String> = points
        .into_iter()
        .map(|(x, y)| format!("{},{}", number(x), number(y)))
        .collect();
    points.join(" ")
}

/// Formats a number with at most two decimals; a number that isn't finite becomes 0.
pub fn number(x: f64) -> String {
    if !x.is_finite() {
        return "0".to_owned();
    }
    let text = fixed(x, 2);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Escapes text for use in an element.
pub fn escaped(text: &str) -> String {
    text.chars().fold(String::with_capacity(text.len()), |mut escaped, c| {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            c if c.is_control() => escaped.push(' '),
            c => escaped.push(c),
        }
        escaped
    })
}

/// Colour at `share` (0 to 1) of evenly spaced red-green-blue stops.
pub fn ramp(stops: &[[u8; 3]], share: f64) -> String {
    let Some(last) = stops.len().checked_sub(1) else {
        return INK.to_owned();
    };
    let place = share.clamp(0.0, 1.0) * last as f64;
    let below = (place.floor() as usize).min(last);
    let above = (below + 1).min(last);
    let part = place - below as f64;
    let mixed = |i: usize| {
        let (a, b) = (f64::from(stops[below][i]), f64::from(stops[above][i]));
        (a + (b - a) * part).round() as u8
    };
    format!("#{:02x}{:02x}{:02x}", mixed(0), mixed(1), mixed(2))
}

/// A step of 1, 2 or 5 times a power of ten that divides a span into about `count` parts.
pub fn tick_step(span: f64, count: u32) -> f64 {
    if !span.is_finite() || span <= 0.0 {
        return 1.0;
    }
    let wanted = span / f64::from(count.max(1));
    let mut power = 1.0_f64;
    while power > wanted {
        power /= 10.0;
    }
    while power * 10.0 <= wanted {
        power *= 10.0;
    }
    [1.0, 2.0, 5.0]
        .into_iter()
        .map(|factor| factor * power)
        .find(|&step| step >= wanted)
        .unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        assert_eq!(number(1.0), "1");
        assert_eq!(number(-0.001), "0");
        assert_eq!(number(2.346), "2.35");
        assert_eq!(number(f64::NAN), "0");
    }

    #[test]
    fn text_is_escaped() {
        assert_eq!(escaped("a<b>&\"\u{7}"), "a&lt;b&gt;&amp;&quot; ");
    }

    #[test]
    fn ramps_go_from_first_to_last() {
        let stops = [[0, 0, 0], [10, 20, 30], [255, 255, 255]];
        assert_eq!(ramp(&stops, -1.0), "#000000");
        assert_eq!(ramp(&stops, 0.25), "#050a0f");
        assert_eq!(ramp(&stops, 0.5), "#0a141e");
        assert_eq!(ramp(&stops, 7.0), "#ffffff");
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(tick_step(500.0, 5), 100.0);
        assert_eq!(tick_step(199.0, 6), 50.0);
        assert_eq!(tick_step(0.9, 5), 0.2);
        assert_eq!(tick_step(f64::INFINITY, 5), 1.0);
        assert_eq!(tick_step(0.0, 5), 1.0);
    }
}
