//! A picture as SVG.

use std::fmt::{self, Write};

use crate::{Align, Color, Item, Picture, Stroke};

/// Writes a picture: one element per item, numbers in hundredths of a pixel, the same bytes for the
/// same picture.
pub fn svg(picture: &Picture) -> String {
    Document { picture, title: None }.to_string()
}

/// Like [`svg`], with a title, which screen readers speak and pointers show.
pub fn titled_svg(picture: &Picture, title: &str) -> String {
    Document { picture, title: Some(title) }.to_string()
}

struct Document<'a> {
    picture: &'a Picture,
    title: Option<&'a str>,
}

impl fmt::Display for Document<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.picture.size.map(Number);
        write!(
            f,
            r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" stroke-linecap="round" stroke-linejoin="round" font-family="sans-serif""#
        )?;
        match self.title {
            Some(title) => writeln!(f, " role=\"img\">\n<title>{}</title>", Escaped(title))?,
            None => f.write_str(">\n")?,
        }
        if let Some(background) = self.picture.background {
            let fill = Fill(background);
            writeln!(f, r#"<rect width="{width}" height="{height}"{fill}/>"#)?;
        }
        for item in &self.picture.items {
            writeln!(f, "{}", Element(item))?;
        }
        f.write_str("</svg>\n")
    }
}

struct Element<'a>(&'a Item);

impl fmt::Display for Element<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Item::Region { rings, fill } => {
                f.write_str(r#"<path d=""#)?;
                rings.iter().try_for_each(|ring| path(f, ring, true))?;
                write!(f, r#"" fill-rule="evenodd"{}/>"#, Fill(*fill))
            }
            Item::Line { points, is_closed, stroke } => {
                f.write_str(r#"<path d=""#)?;
                path(f, points, *is_closed)?;
                write!(f, r#"" fill="none"{}/>"#, Outline(*stroke))
            }
            Item::Text { at: [x, y], align, text, size, color } => {
                let anchor = match align {
                    Align::Start => "",
                    Align::Middle => r#" text-anchor="middle""#,
                    Align::End => r#" text-anchor="end""#,
                };
                let [x, y, size] = [*x, *y, *size].map(Number);
                let (fill, text) = (Fill(*color), Escaped(text));
                write!(f, r#"<text x="{x}" y="{y}" font-size="{size}"{anchor}{fill}>{text}</text>"#)
            }
        }
    }
}

/// Writes points joined by lines; points that are not finite are left out.
fn path(f: &mut fmt::Formatter<'_>, points: &[[f32; 2]], is_closed: bool) -> fmt::Result {
    let mut command = 'M';
    for &[x, y] in points.iter().filter(|p| p.iter().all(|x| x.is_finite())) {
        write!(f, "{command}{} {}", Number(x), Number(y))?;
        // After the first point, coordinates alone mean further lines.
        command = if command == 'M' { 'L' } else { ' ' };
    }
    f.write_str(if is_closed && command != 'M' { "Z" } else { "" })
}

/// A number in hundredths, without trailing zeros.
struct Number(f32);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Far outside of any picture, a number that every reader can parse.
        let x = if self.0.is_nan() { 0.0 } else { self.0.clamp(-1e7, 1e7) };
        let text = format!("{x:.2}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        f.write_str(if text == "-0" { "0" } else { text })
    }
}

struct Fill(Color);

impl fmt::Display for Fill {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, r#" fill="{}""#, self.0.hex())?;
        opacity(f, "fill", self.0)
    }
}

struct Outline(Stroke);

impl fmt::Display for Outline {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Stroke { color, width } = self.0;
        write!(f, r#" stroke="{}" stroke-width="{}""#, color.hex(), Number(width))?;
        opacity(f, "stroke", color)
    }
}

fn opacity(f: &mut fmt::Formatter<'_>, of: &str, color: Color) -> fmt::Result {
    if color.opacity() < 1.0 {
        write!(f, r#" {of}-opacity="{}""#, Number(color.opacity()))?;
    }
    Ok(())
}

/// Text with the characters escaped that are markup in XML, and replaced that it does not allow.
struct Escaped<'a>(&'a str);

impl fmt::Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for c in self.0.chars() {
            match c {
                '&' => f.write_str("&amp;")?,
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '"' => f.write_str("&quot;")?,
                '\u{fffe}' | '\u{ffff}' => f.write_char(char::REPLACEMENT_CHARACTER)?,
                c if c.is_control() && c != '\t' => f.write_char(' ')?,
                c => f.write_char(c)?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet(items: Vec<Item>) -> Picture {
        Picture { size: [200.0, 100.0], background: Some(Color::opaque(0xff_ff_ff)), items }
    }

    fn check(item: Item, expected: &str) {
        let text = svg(&sheet(vec![item]));
        roxmltree::Document::parse(&text).expect("valid XML");
        let line = text.lines().rev().nth(1).expect("a line per item");
        assert_eq!(line, expected);
    }

    const RED: Color = Color::opaque(0xff_00_00);

    #[test]
    fn every_item_is_one_element() {
        check(
            Item::Region {
                rings: vec![vec![[0.0, 0.0], [10.006, 0.0], [0.0, -0.001]]],
                fill: RED.with_opacity(0.5),
            },
            r##"<path d="M0 0L10.01 0 0 0Z" fill-rule="evenodd" fill="#ff0000" fill-opacity="0.5"/>"##,
        );
        check(
            Item::Line {
                points: vec![[1.0, 2.0], [3.5, 4.25]],
                is_closed: false,
                stroke: Stroke { color: RED, width: 1.5 },
            },
            r##"<path d="M1 2L3.5 4.25" fill="none" stroke="#ff0000" stroke-width="1.5"/>"##,
        );
        check(
            Item::Text {
                at: [5.0, 6.0],
                align: Align::End,
                text: "a<b & \"c\"\u{1}".into(),
                size: 13.0,
                color: RED,
            },
            r##"<text x="5" y="6" font-size="13" text-anchor="end" fill="#ff0000">a&lt;b &amp; &quot;c&quot; </text>"##,
        );
    }

    #[test]
    fn what_is_no_number_leaves_valid_xml() {
        check(
            Item::Line {
                points: vec![[f32::NAN, 1.0], [f32::INFINITY, 2.0], [3e38, -3e38]],
                is_closed: true,
                stroke: Stroke { color: RED, width: f32::NAN },
            },
            r##"<path d="M10000000 -10000000Z" fill="none" stroke="#ff0000" stroke-width="0"/>"##,
        );
    }

    #[test]
    fn a_title_names_the_picture() {
        let text = titled_svg(&sheet(Vec::new()), "Crank & slider");
        let document = roxmltree::Document::parse(&text).expect("valid XML");
        let title = document.descendants().find(|node| node.has_tag_name("title"));
        // Names of elements carry the namespace of SVG.
        let title =
            title.or_else(|| document.descendants().find(|n| n.tag_name().name() == "title"));
        assert_eq!(title.and_then(|node| node.text()), Some("Crank & slider"));
    }
}
