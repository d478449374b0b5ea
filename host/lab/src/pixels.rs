//! Pictures that experiments and imports read: PNG and PGM, as greys.

use std::io::Cursor;

use oneiro::picture::GREATEST_PIXELS;
use png::{BitDepth, ColorType, Decoder, Limits, Transformations};

/// Most bytes of a picture's file.
const GREATEST_BYTES: usize = 32 << 20;
/// Most memory of a decoder besides its result, bytes.
const WORKING_BYTES: usize = 64 << 20;

/// Greys of a picture, row after row from the upper left pixel: 0 for black to 65,535 for white.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pixels {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) greys: Vec<u16>,
}

/// Reads the content of a file. Colours count by their luma, and what is transparent lies over white.
///
/// # Errors
/// The problem and the allowed values, without the file's name.
pub(crate) fn read(bytes: &[u8]) -> Result<Pixels, String> {
    if bytes.len() > GREATEST_BYTES {
        let (megabytes, most) = (bytes.len() >> 20, GREATEST_BYTES >> 20);
        return Err(format!("has {megabytes} MiB; allowed: pictures of up to {most} MiB"));
    }
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => png(bytes),
        [b'P', b'2', ..] => pgm(bytes, false),
        [b'P', b'5', ..] => pgm(bytes, true),
        _ => Err("is no picture that can be read; allowed: PNG, and PGM of the kinds P2 and P5".to_owned()),
    }
}

/// Checks a number of pixels before there is memory for them.
fn sized(width: u32, height: u32) -> Result<usize, String> {
    let count = u64::from(width) * u64::from(height);
    if (1..=u64::from(GREATEST_PIXELS)).contains(&count) {
        return Ok(count as usize);
    }
    Err(format!(
        "has {width} x {height} pixels; allowed: 1 to {GREATEST_PIXELS} in all"
    ))
}

fn png(bytes: &[u8]) -> Result<Pixels, String> {
    let broken =
        |error: png::DecodingError| format!("is no whole PNG: {error}; allowed: a PNG that other programs open");
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: WORKING_BYTES });
    // Texts and profiles may be packed ever so small.
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    // Palettes become colours, and less than eight bits become eight.
    decoder.set_transformations(Transformations::EXPAND);
    let header = decoder.read_header_info().map_err(broken)?;
    let (width, height) = (header.width, header.height);
    let count = sized(width, height)?;
    let mut reader = decoder.read_info().map_err(broken)?;
    let (colour, depth) = reader.output_color_type();
    let samples = colour.samples();
    let bytes_each = if depth == BitDepth::Sixteen { 2 } else { 1 };
    let mut decoded = vec![0; count * samples * bytes_each];
    reader.next_frame(&mut decoded).map_err(broken)?;
    let sample = |bytes: &[u8]| match *bytes {
        [high, low] => u32::from(u16::from_be_bytes([high, low])),
        [byte, ..] => 257 * u32::from(byte),
        [] => 0,
    };
    let grey = |pixel: &[u8]| {
        let mut all = [0; 4];
        for (to, from) in all.iter_mut().zip(pixel.chunks(bytes_each)) {
            *to = sample(from);
        }
        let [first, second, third, fourth] = all;
        match colour {
            ColorType::GrayscaleAlpha => over_white(first, second),
            ColorType::Rgb => luma([first, second, third]),
            ColorType::Rgba => over_white(luma([first, second, third]), fourth),
            ColorType::Grayscale | ColorType::Indexed => first,
        }
    };
    let greys = decoded.chunks(samples * bytes_each);
    Ok(Pixels {
        width,
        height,
        greys: greys.map(|pixel| grey(pixel) as u16).collect(),
    })
}

/// Luma of ITU-R BT.709-6, item 3.2, of red, green and blue unchanged from the file, from 0 to 65,535.
fn luma([red, green, blue]: [u32; 3]) -> u32 {
    (2126 * red + 7152 * green + 722 * blue + 5000) / 10_000
}

/// A grey with an opacity, over white; both from 0 to 65,535.
fn over_white(grey: u32, opacity: u32) -> u32 {
    const WHITE: u32 = u16::MAX as u32;
    (grey * opacity + WHITE * (WHITE - opacity) + WHITE / 2) / WHITE
}

/// Reads a PGM, whose pixels are bytes or words, the upper byte first, or else numbers.
fn pgm(bytes: &[u8], is_binary: bool) -> Result<Pixels, String> {
    let mut at = 2;
    let mut number = |what: &str, most: u32| {
        loop {
            match bytes.get(at) {
                Some(b'#') => {
                    at += bytes[at..]
                        .iter()
                        .position(|byte| *byte == b'\n')
                        .unwrap_or(bytes.len() - at);
                }
                Some(byte) if byte.is_ascii_whitespace() => at += 1,
                _ => break,
            }
        }
        let digits = bytes[at..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        let found = std::str::from_utf8(&bytes[at..at + digits])
            .ok()
            .and_then(|digits| digits.parse().ok());
        at += digits;
        match found {
            Some(number) if number <= most => Ok((number, at)),
            Some(number) => Err(format!("has {number} as {what}; allowed: up to {most}")),
            None => Err(format!(
                "is no whole PGM: byte {at} should be {what}; allowed: whole numbers"
            )),
        }
    };
    let (width, _) = number("its width", GREATEST_PIXELS)?;
    let (height, _) = number("its height", GREATEST_PIXELS)?;
    let (white, after) = number("the value of white", u16::MAX.into())?;
    let count = sized(width, height)?;
    if white == 0 {
        return Err("has 0 as the value of white; allowed: 1 to 65535".to_owned());
    }
    let scaled = |value: u32| ((value * u32::from(u16::MAX) + white / 2) / white) as u16;
    let above = |value: u32| format!("has a pixel of {value}; allowed: up to {white}, its value of white");
    let greys: Vec<u16> = if is_binary {
        let bytes_each = if white > 255 { 2 } else { 1 };
        // One blank ends the header.
        let pixels = bytes.get(after + 1..).unwrap_or_default();
        if pixels.len() < count * bytes_each {
            return Err(format!(
                "is no whole PGM: it has {} bytes of pixels; allowed: {}",
                pixels.len(),
                count * bytes_each
            ));
        }
        let values = pixels.chunks(bytes_each).take(count);
        let values = values.map(|bytes| bytes.iter().fold(0, |value, byte| 256 * value + u32::from(*byte)));
        let checked = values.map(|value| {
            if value <= white {
                Ok(scaled(value))
            } else {
                Err(above(value))
            }
        });
        checked.collect::<Result<_, _>>()?
    } else {
        // Before there is memory for them: each takes two bytes.
        if (bytes.len() - after) / 2 + 1 < count {
            return Err(format!(
                "is no whole PGM: it ends before its {count} pixels; allowed: all of them"
            ));
        }
        let checked = (0..count).map(|_| {
            let (value, _) = number("a pixel", u16::MAX.into())?;
            if value <= white {
                Ok(scaled(value))
            } else {
                Err(above(value))
            }
        });
        checked.collect::<Result<_, String>>()?
    };
    Ok(Pixels { width, height, greys })
}

/// A PNG of 8-bit greys, row after row from the upper left pixel; for tests.
#[cfg(test)]
pub(crate) fn written(width: u32, height: u32, colour: ColorType, depth: BitDepth, samples: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    if colour == ColorType::Indexed {
        encoder.set_palette(vec![0, 0, 0, 255, 0, 0, 255, 255, 255]);
    }
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(samples).expect("pixels");
    writer.finish().expect("an end");
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn greys(bytes: &[u8]) -> Vec<u16> {
        read(bytes).expect("a picture").greys
    }

    #[test]
    fn all_kinds_of_png_give_their_greys() {
        let png = |colour, depth, samples: &[u8]| greys(&written(2, 1, colour, depth, samples));
        assert_eq!(png(ColorType::Grayscale, BitDepth::Eight, &[0, 128]), [0, 128 * 257]);
        assert_eq!(
            png(ColorType::Grayscale, BitDepth::Sixteen, &[1, 2, 255, 255]),
            [258, 65535]
        );
        assert_eq!(png(ColorType::Grayscale, BitDepth::One, &[0b0100_0000]), [0, 65535]);
        assert_eq!(png(ColorType::Grayscale, BitDepth::Four, &[0x5f]), [0x5555, 65535]);
        // Red has 2126 of 10000.
        assert_eq!(
            png(ColorType::Rgb, BitDepth::Eight, &[255, 0, 0, 255, 255, 255]),
            [13933, 65535]
        );
        assert_eq!(png(ColorType::Indexed, BitDepth::Two, &[0b0110_0000]), [13933, 65535]);
        // Black that is not there, and half of it.
        assert_eq!(
            png(ColorType::GrayscaleAlpha, BitDepth::Eight, &[0, 0, 0, 255]),
            [65535, 0]
        );
        assert_eq!(
            png(ColorType::Rgba, BitDepth::Eight, &[0, 0, 0, 51, 0, 0, 0, 0]),
            [52428, 65535]
        );
    }

    #[test]
    fn both_kinds_of_pgm_give_their_greys() {
        assert_eq!(greys(b"P5\n# map\n3 1\n255\n\x00\xcd\xfe"), [0, 205 * 257, 254 * 257]);
        assert_eq!(greys(b"P5 1 2 1023 \x03\xff\x00\x00"), [65535, 0]);
        assert_eq!(greys(b"P2 2 2 15 # white\n0 15\n5 10"), [0, 65535, 21845, 43690]);
    }

    #[test]
    fn hostile_files_are_refused() {
        let whole = written(8, 8, ColorType::Rgb, BitDepth::Eight, &[7; 192]);
        for cut in 0..whole.len() - 12 {
            assert!(read(&whole[..cut]).is_err(), "{cut} bytes");
        }
        let mut huge = whole.clone();
        huge[16..24].fill(0x7f);
        let crc = crc32(&huge[12..29]);
        huge[29..33].copy_from_slice(&crc.to_be_bytes());
        for (bytes, problem) in [
            (&huge[..], "pixels; allowed: 1 to 16777216 in all"),
            (b"GIF89a", "is no picture that can be read"),
            (b"", "is no picture that can be read"),
            (b"P5", "should be its width"),
            (b"P5 99999999999 1 255 ", "should be its width"),
            (b"P5 16777216 2 255 ", "has 16777216 x 2 pixels"),
            (b"P5 0 2 255 ", "has 0 x 2 pixels"),
            (b"P5 4 4 255 abc", "has 3 bytes of pixels; allowed: 16"),
            (b"P5 1 1 0 a", "the value of white; allowed: 1 to 65535"),
            (b"P5 1 1 65536 aa", "has 65536 as the value of white"),
            (b"P5 1 1 9 a", "has a pixel of 97; allowed: up to 9"),
            (b"P2 4000 4000 9 1", "ends before its 16000000 pixels"),
            (b"P2 2 1 9 1 x", "should be a pixel"),
            (b"P2 1 1 9 10", "has a pixel of 10"),
        ] {
            let text = read(bytes).expect_err("a refusal");
            assert!(text.contains(problem), "{text}");
        }
        for at in 0..whole.len() {
            for bit in 0..8 {
                let mut other = whole.clone();
                other[at] ^= 1 << bit;
                // Whatever it is now, it ends.
                let _ = read(&other);
            }
        }
    }

    /// The checksum of a PNG's chunks.
    fn crc32(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(!0, |mut crc: u32, byte| {
            crc ^= u32::from(*byte);
            for _ in 0..8 {
                crc = (crc >> 1) ^ (0xedb8_8320 & 0_u32.wrapping_sub(crc & 1));
            }
            crc
        })
    }
}
