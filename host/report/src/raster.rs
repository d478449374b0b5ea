//! Drawings as pixels: PNG, and films as GIF. Text isn't drawn, since fonts differ between machines.

use std::collections::HashMap;

use gif::{DisposalMethod, Encoder, Frame, Repeat};
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree};

/// Colours of a GIF; one more stands for "as in the frame before".
const COLOURS: usize = 255;
const UNCHANGED: u8 = 255;
/// Frames whose colours make the palette.
const SAMPLES: usize = 12;

/// A colour's red, green and blue.
type Colour = [u8; 3];

/// Draws an SVG of ours, each of its pixels as `scale` by `scale` pixels.
fn drawn(svg: &str, scale: f32) -> Pixmap {
    let tree = Tree::from_str(svg, &Options::default()).expect("a drawing of ours is SVG");
    let side = |length: f32| ((scale * length).ceil() as u32).clamp(1, 16_384);
    let (width, height) = (side(tree.size().width()), side(tree.size().height()));
    let mut pixels = Pixmap::new(width, height).expect("it has a side of 1 to 16,384 pixels");
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut pixels.as_mut());
    pixels
}

/// A drawing as PNG, each of its pixels as four.
pub fn png(svg: &str) -> Vec<u8> {
    drawn(svg, 2.0).encode_png().expect("memory takes any PNG")
}

/// A film as GIF that begins again at its end: `count` drawings of one size, each shown for `hundredths` of a second. `frame` draws one.
pub fn gif(count: usize, hundredths: u16, frame: impl Fn(usize) -> String) -> Vec<u8> {
    let image = |number: usize| -> (u16, u16, Vec<Colour>) {
        let pixels = drawn(&frame(number), 1.0);
        // A sheet is white: no pixel is transparent.
        let colours = pixels.pixels().iter().map(|own| [own.red(), own.green(), own.blue()]);
        (pixels.width() as u16, pixels.height() as u16, colours.collect())
    };
    let mut palette = Palette::new((0..SAMPLES).map(|sample| image(sample * (count - 1) / (SAMPLES - 1)).2));
    let (width, height, _) = image(0);
    let mut file = Vec::new();
    let mut before: Vec<u8> = Vec::new();
    {
        let encoder = Encoder::new(&mut file, width, height, &palette.colours.concat());
        let mut encoder = encoder.expect("memory takes any GIF");
        encoder.set_repeat(Repeat::Infinite).expect("memory takes any GIF");
        for number in 0..count {
            let (_, _, colours) = image(number);
            let own: Vec<u8> = colours.into_iter().map(|colour| palette.index(colour)).collect();
            let mut frame = changed(&own, &before, width.into());
            frame.delay = if number + 1 == count { 100 } else { hundredths };
            encoder.write_frame(&frame).expect("memory takes any GIF");
            before = own;
        }
    }
    file
}

/// What differs from the frame before: the smallest rectangle around it, in which other pixels are transparent.
fn changed(own: &[u8], before: &[u8], width: usize) -> Frame<'static> {
    let differs = |at: usize| before.get(at) != Some(&own[at]);
    let (mut left, mut right, mut top, mut bottom) = (usize::MAX, 0, usize::MAX, 0);
    for at in (0..own.len()).filter(|&at| differs(at)) {
        let (x, y) = (at % width, at / width);
        (left, right, top, bottom) = (left.min(x), right.max(x), top.min(y), bottom.max(y));
    }
    // A frame has at least one pixel.
    let (left, top) = if left == usize::MAX { (0, 0) } else { (left, top) };
    let inside = (top..=bottom).flat_map(|y| (left..=right).map(move |x| y * width + x));
    let pixels: Vec<u8> = inside.map(|at| if differs(at) { own[at] } else { UNCHANGED }).collect();
    Frame {
        left: left as u16,
        top: top as u16,
        width: (right - left + 1) as u16,
        height: (bottom - top + 1) as u16,
        transparent: Some(UNCHANGED),
        dispose: DisposalMethod::Keep,
        buffer: pixels.into(),
        ..Frame::default()
    }
}

/// The commonest colours of a film. Areas of one colour are exact, edges get the nearest.
struct Palette {
    colours: Vec<Colour>,
    known: HashMap<Colour, u8>,
}

impl Palette {
    fn new(images: impl Iterator<Item = Vec<Colour>>) -> Self {
        let mut counts: HashMap<Colour, usize> = HashMap::new();
        for colour in images.flatten() {
            *counts.entry(colour).or_default() += 1;
        }
        let mut ranked: Vec<(Colour, usize)> = counts.into_iter().collect();
        // The same film has the same bytes.
        ranked.sort_by_key(|&(colour, count)| (std::cmp::Reverse(count), colour));
        ranked.truncate(COLOURS);
        Self {
            colours: ranked.into_iter().map(|(colour, _)| colour).collect(),
            known: HashMap::new(),
        }
    }

    /// The number of the nearest colour.
    fn index(&mut self, colour: Colour) -> u8 {
        let distance = |other: &Colour| -> u32 {
            let of = |channel: usize| u32::from(other[channel].abs_diff(colour[channel])).pow(2);
            of(0) + of(1) + of(2)
        };
        let colours = &self.colours;
        *self.known.entry(colour).or_insert_with(|| {
            let nearest = colours.iter().enumerate().min_by_key(|(_, other)| distance(other));
            nearest.map_or(0, |(number, _)| number as u8)
        })
    }
}

#[cfg(test)]
mod tests {
    use gif::{ColorOutput, DecodeOptions};

    use super::*;

    /// A white sheet with a square.
    fn sheet(x: u32) -> String {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"40\" height=\"20\"><rect width=\"40\" height=\"20\" fill=\"#fff\"/>\
             <rect x=\"{x}\" y=\"4\" width=\"6\" height=\"6\" fill=\"#2a9d8f\"/></svg>"
        )
    }

    /// Decodes a film: the indices of each frame's own pixels, put over the frame before, as colours.
    fn decoded(film: &[u8]) -> Vec<(u16, Vec<Colour>)> {
        let mut options = DecodeOptions::new();
        options.set_color_output(ColorOutput::Indexed);
        let mut decoder = options.read_info(film).unwrap();
        let palette: Vec<Colour> = decoder.global_palette().unwrap().as_chunks().0.to_vec();
        let width = usize::from(decoder.width());
        let mut shown = vec![[0; 3]; width * usize::from(decoder.height())];
        let mut frames = Vec::new();
        while let Some(frame) = decoder.read_next_frame().unwrap() {
            for (at, &index) in frame.buffer.iter().enumerate() {
                let (x, y) = (at % usize::from(frame.width), at / usize::from(frame.width));
                if frame.transparent != Some(index) {
                    shown[(usize::from(frame.top) + y) * width + usize::from(frame.left) + x] =
                        palette[usize::from(index)];
                }
            }
            frames.push((frame.delay, shown.clone()));
        }
        frames
    }

    #[test]
    fn a_film_has_the_drawings() {
        let places = [2, 9, 9, 30];
        let film = gif(places.len(), 4, |frame| sheet(places[frame]));
        let frames = decoded(&film);
        let delays: Vec<u16> = frames.iter().map(|(delay, _)| *delay).collect();
        assert_eq!(delays, [4, 4, 4, 100]);
        for ((_, frame), place) in frames.iter().zip(places) {
            for (at, colour) in frame.iter().enumerate() {
                let (x, y) = (at as u32 % 40, at as u32 / 40);
                let is_square = (place..place + 6).contains(&x) && (4..10).contains(&y);
                let expected = if is_square { [0x2a, 0x9d, 0x8f] } else { [0xff; 3] };
                assert_eq!(*colour, expected, "{x} {y} of {place}");
            }
        }
    }

    #[test]
    fn colours_beyond_the_palette_get_the_nearest() {
        let shades = (0..=255).map(|shade| vec![[shade, 0, 0]; if shade == 7 { 1 } else { 2 }]);
        let mut palette = Palette::new(shades);
        assert_eq!(palette.colours.len(), COLOURS);
        let nearest = palette.index([7, 0, 0]);
        assert_eq!(palette.colours[usize::from(nearest)], [6, 0, 0]);
    }

    #[test]
    fn pictures_have_twice_the_pixels() {
        let picture = png(&sheet(3));
        assert_eq!(&picture[..8], b"\x89PNG\r\n\x1a\n");
        let side = |at: usize| u32::from_be_bytes(picture[at..at + 4].try_into().unwrap());
        assert_eq!((side(16), side(20)), (80, 40));
    }
}
