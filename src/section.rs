//! Section planes as people write them: `x = 20 mm`, `[1, 1, 0] > [10, 0, 5] mm`.

use bksim_analysis::quantity;
use bksim_scene::{CutSide, Section};

/// Message about a text that is no section plane.
const EXPECTED: &str =
    "expected a plane such as `x = 20 mm`, `z < 0` or `[1, 1, 0] = [10, 0, 5] mm`";

/// The section plane of a text: an axis or a normal; the side that is kept; and the distance from the origin along
/// the normal, or a point of the plane.
///
/// After `=` the side nearer to the eye is left out, after `<` what lies in the direction of the normal, after `>`
/// the other side. Lengths are in metres or have a unit.
///
/// ```
/// let section = bksim::section::parse("z > 20 mm").expect("a plane");
/// assert_eq!((section.normal(), section.offset), ([0.0, 0.0, -1.0], -0.02));
/// ```
///
/// # Errors
/// A message about the text where it is no plane.
pub fn parse(text: &str) -> Result<Section, String> {
    read(text).ok_or_else(|| EXPECTED.to_owned())
}

fn read(text: &str) -> Option<Section> {
    let at = text.find(['=', '<', '>'])?;
    let (direction, relation, rest) = (text[..at].trim(), &text[at..=at], &text[at + 1..]);
    // `<=` and `>=` are the same planes.
    let place = rest.strip_prefix('=').filter(|_| relation != "=").unwrap_or(rest).trim();
    let normal = match direction {
        "x" => [1.0, 0.0, 0.0],
        "y" => [0.0, 1.0, 0.0],
        "z" => [0.0, 0.0, 1.0],
        _ => vector(direction, "1").filter(|normal| *normal != [0.0; 3])?,
    };
    let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
    let point = if place.starts_with('[') {
        vector(place, "m")?
    } else {
        let distance = quantity(place, "m").ok()?;
        normal.map(|x| distance * x / length)
    };
    let side = if relation == "=" { CutSide::Nearer } else { CutSide::Above };
    let section = Section::new(normal, point, side)?;
    Some(if relation == ">" { section.reversed() } else { section })
}

/// `[10, 0, 5] mm` or `[1 cm, 0, 5 mm]` in the unit `si`.
fn vector(text: &str, si: &str) -> Option<[f64; 3]> {
    let (inner, unit) = text.strip_prefix('[')?.split_once(']')?;
    let mut parts = inner.split(',');
    let mut part = || {
        let part = parts.next()?.trim();
        // A unit behind the bracket is that of numbers that have none.
        let is_bare = part.parse::<f64>().is_ok();
        let unit = if is_bare { unit } else { "" };
        quantity(&format!("{part} {unit}"), si).ok()
    };
    let vector = [part()?, part()?, part()?];
    parts.next().is_none().then_some(vector)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_have_an_axis_or_a_normal_a_side_and_a_place() {
        use CutSide::{Above, Nearer};
        let root = 2f64.sqrt();
        for (text, normal, offset, side) in [
            ("x = 20 mm", [1.0, 0.0, 0.0], 0.02, Nearer),
            ("y=-0.5", [0.0, 1.0, 0.0], -0.5, Nearer),
            ("z < 2 cm", [0.0, 0.0, 1.0], 0.02, Above),
            ("z >= 2 cm", [0.0, 0.0, -1.0], -0.02, Above),
            ("[0, -2, 0] = [0, 1, 7] m", [0.0, -1.0, 0.0], -1.0, Nearer),
            ("[1, 1, 0] <= [10 mm, 1 cm, 3]", [1.0 / root, 1.0 / root, 0.0], 0.01 * root, Above),
            ("[1, 1, 0] = 20 mm", [1.0 / root, 1.0 / root, 0.0], 0.02, Nearer),
        ] {
            let section = parse(text).unwrap_or_else(|why| panic!("{text}: {why}"));
            assert_eq!((section.normal(), section.side), (normal, side), "{text}");
            assert!((section.offset - offset).abs() < 1e-15, "{text}: {}", section.offset);
        }
    }

    #[test]
    fn what_is_no_plane_is_refused_with_one_that_is() {
        for text in [
            "",
            "x",
            "x = ",
            "x = 2 s",
            "w = 1",
            "[0, 0, 0] = 1",
            "[1, 0] = 1",
            "[1, 0, 0, 0] = 1",
            "x = [1, 2] mm",
            "x = 1 m m",
            "[1, 0, 0 = 1",
            "x = nan",
            "x < > 1",
            "[1 m, 0, 0] = 1",
        ] {
            assert!(parse(text).is_err_and(|why| why.contains("`x = 20 mm`")), "{text}");
        }
    }
}
