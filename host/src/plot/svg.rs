//! The shapes as SVG.

use super::drawing::{Anchor, Colour, Drawing, Shape, Text};
use std::fmt::{self, Write};

pub(super) fn write(drawing: &Drawing) -> String {
    let mut out = String::new();
    match write_all(&mut out, drawing) {
        Ok(()) => out,
        Err(fmt::Error) => unreachable!("a String takes whatever is written"),
    }
}

fn write_all(out: &mut String, drawing: &Drawing) -> fmt::Result {
    let (width, height) = (drawing.width, drawing.height);
    writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"Noto Sans, DejaVu Sans, Helvetica, Arial, sans-serif\">"
    )?;
    for shape in &drawing.shapes {
        match shape {
            Shape::Line(points, stroke) => {
                write!(out, "<polyline fill=\"none\" stroke-linejoin=\"round\" ")?;
                colour(out, "stroke", stroke.colour)?;
                write!(out, " stroke-width=\"{}\"", stroke.width)?;
                if stroke.dashed {
                    write!(out, " stroke-dasharray=\"5 3\"")?;
                }
                write!(out, " points=\"")?;
                for [x, y] in points {
                    write!(out, "{x:.2},{y:.2} ")?;
                }
                writeln!(out, "\"/>")?;
            }
            Shape::Rect([x, y, width, height], fill) => {
                write!(
                    out,
                    "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" "
                )?;
                colour(out, "fill", *fill)?;
                writeln!(out, "/>")?;
            }
            Shape::Disc([x, y], radius, fill) => {
                write!(out, "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius}\" ")?;
                colour(out, "fill", *fill)?;
                writeln!(out, "/>")?;
            }
            Shape::Text(text) => label(out, text)?,
            Shape::Raster([x, y, width, height], raster) => {
                // pixels that cannot be encoded are pixels that are not there
                if let Some(bytes) = super::png::encode(raster) {
                    write!(
                        out,
                        "<image x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" \
                         preserveAspectRatio=\"none\" href=\"data:image/png;base64,"
                    )?;
                    base64(out, &bytes);
                    writeln!(out, "\"/>")?;
                }
            }
        }
    }
    writeln!(out, "</svg>")
}

/// RFC 4648, section 4.
fn base64(out: &mut String, bytes: &[u8]) {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for group in bytes.chunks(3) {
        let byte = |k: usize| u32::from(group.get(k).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for digit in 0..4 {
            let index = (bits >> (18 - 6 * digit)) & 63;
            let digit = if digit <= group.len() {
                usize::try_from(index).ok().and_then(|at| DIGITS.get(at))
            } else {
                None
            };
            out.push(digit.map_or('=', |c| char::from(*c)));
        }
    }
}

fn label(out: &mut String, text: &Text) -> fmt::Result {
    let [x, y] = text.at;
    let anchor = match text.anchor {
        Anchor::Start => "start",
        Anchor::Middle => "middle",
        Anchor::End => "end",
    };
    write!(
        out,
        "<text x=\"{x:.2}\" y=\"{y:.2}\" font-size=\"{}\" text-anchor=\"{anchor}\" ",
        text.size
    )?;
    colour(out, "fill", text.colour)?;
    if text.upwards {
        write!(out, " transform=\"rotate(-90 {x:.2} {y:.2})\"")?;
    }
    write!(out, ">")?;
    for c in text.words.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            // XML has no place for control characters
            c if c.is_control() => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    writeln!(out, "</text>")
}

fn colour(out: &mut String, attribute: &str, colour: Colour) -> fmt::Result {
    let [r, g, b] = colour.rgb;
    write!(out, "{attribute}=\"#{r:02x}{g:02x}{b:02x}\"")?;
    if colour.opacity < 1.0 {
        write!(out, " {attribute}-opacity=\"{}\"", colour.opacity)?;
    }
    Ok(())
}

#[cfg(test)]
mod test {
    use super::base64;

    #[test]
    fn base64_is_that_of_the_standard() {
        // RFC 4648, section 10
        for (plain, expected) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            let mut got = String::new();
            base64(&mut got, plain.as_bytes());
            assert_eq!(got, expected);
        }
    }
}
