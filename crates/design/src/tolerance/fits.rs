//! Limits of ISO 286 by their letters: `H7`, `g6`, `js5`, `ZC9`.
//!
//! ```text
//! shafts a to h   es = table           ei = es − IT          js   ± IT/2
//! shafts j to zc  ei = table           es = ei + IT          k    of grades 4 to 7, else 0
//! holes A to H    EI = −es             ES = EI + IT
//! holes K to ZC   ES = −ei + Δ         EI = ES − IT          Δ = IT − IT of the grade before
//! ```
//!
//! Δ belongs to sizes above 3 mm, to K, M and N up to grade 8 and to P to ZC up to grade 7. The table `fits.txt` has, by the
//! largest size of a step in mm, the standard tolerances IT1 to IT18 and the fundamental deviations in µm.
//!
//! Source: ISO 286-1:2010, tables 1 to 5, the values rounded as there.

/// Rows of steps; the first row has the names of the columns.
const TABLE: &str = include_str!("fits.txt");

/// Letters of shafts above the nominal size, in their order.
const ABOVE: [&str; 14] = ["m", "n", "p", "r", "s", "t", "u", "v", "x", "y", "z", "za", "zb", "zc"];

/// Value of the table in the step of a size, µm; none of sizes above 500 mm.
fn of_step(size: f64, name: &str) -> Option<f64> {
    /// Sizes that the author writes in inches meet no step to the last bit.
    const ROUNDING: f64 = 1e-9;
    let column = TABLE.lines().next()?.split_whitespace().position(|known| known == name)?;
    let mut steps = TABLE.lines().skip(1).map(str::split_whitespace);
    let mut step = steps.find_map(|cells| {
        let most: f64 = cells.clone().next()?.parse().ok()?;
        (size <= most + ROUNDING && size > 0.0).then_some(cells)
    })?;
    step.nth(column)?.parse().ok()
}

/// Lower and upper deviation of a size by its letters, both in m; none of other letters, grades and sizes.
pub(super) fn limits(letters: &str, nominal: f64) -> Option<[f64; 2]> {
    const MICROMETRE: f64 = 1e-6;
    let digits = letters.find(|c: char| c.is_ascii_digit())?;
    let (class, written) = letters.split_at(digits);
    let grade: u32 = written.parse().ok()?;
    let size = nominal * 1e3;
    let of = |name: &str| of_step(size, name);
    let width = of(written)?;
    let is_hole = class.starts_with(|c: char| c.is_ascii_uppercase());
    let shaft = class.to_ascii_lowercase();
    if class != shaft && class != class.to_ascii_uppercase() {
        return None;
    }
    // The lower end, or the upper one less the width.
    let low = match (shaft.as_str(), is_hole) {
        ("js", _) => -0.5 * width,
        ("j", true) => of(letters)? - width,
        ("j", false) => of(if grade == 5 { "j6" } else { letters })?,
        ("h", true) => 0.0,
        ("h", false) => -width,
        ("k", false) => {
            if (4..=7).contains(&grade) {
                of("k")?
            } else {
                0.0
            }
        }
        ("k", true) if grade > 8 => (size <= 3.0).then_some(-width)?,
        // One value that the standard rounds in another way.
        ("m", true) if grade == 6 && (250.0..=315.0).contains(&size) && size > 250.0 => {
            -9.0 - width
        }
        ("n", true) if grade > 8 && size > 3.0 => -width,
        (name, true) if name == "k" || ABOVE.contains(&name) => {
            let last = if matches!(name, "k" | "m" | "n") { 8 } else { 7 };
            let is_less = size > 3.0 && (3..=last).contains(&grade);
            let delta = if is_less { width - of(&(grade - 1).to_string())? } else { 0.0 };
            -of(name)? + delta - width
        }
        (name, false) if ABOVE.contains(&name) => of(name)?,
        (name, _) => {
            let upper = of(name).filter(|_| name.len() <= 2 && !name.starts_with('j'))?;
            if is_hole { -upper } else { upper - width }
        }
    };
    Some([low * MICROMETRE, (low + width) * MICROMETRE])
}

#[cfg(test)]
mod tests {
    use super::limits;

    /// Values of published tables of fits.
    #[test]
    fn common_fits_have_their_published_limits() {
        let check = |letters: &str, mm: f64, expected: [f64; 2]| {
            let found =
                limits(letters, mm * 1e-3).map(|both| both.map(|x| (x * 1e7).round() / 10.0));
            assert_eq!(found, Some(expected), "{mm} {letters}");
        };
        check("H7", 25.0, [0.0, 21.0]);
        check("g6", 25.0, [-20.0, -7.0]);
        check("f7", 40.0, [-50.0, -25.0]);
        check("H8", 50.0, [0.0, 39.0]);
        check("h6", 10.0, [-9.0, 0.0]);
        check("k6", 60.0, [2.0, 21.0]);
        check("p6", 100.0, [37.0, 59.0]);
        check("js5", 3.0, [-2.0, 2.0]);
        check("D10", 16.0, [50.0, 120.0]);
        check("H11", 500.0, [0.0, 400.0]);
        check("P7", 25.0, [-35.0, -14.0]);
        check("N9", 8.0, [-36.0, 0.0]);
        check("N9", 3.0, [-29.0, -4.0]);
        check("K7", 40.0, [-18.0, 7.0]);
        check("M8", 40.0, [-34.0, 5.0]);
        check("M6", 300.0, [-41.0, -9.0]);
        check("J7", 40.0, [-11.0, 14.0]);
        check("j5", 20.0, [-4.0, 5.0]);
        check("k9", 20.0, [0.0, 52.0]);
        check("R7", 70.0, [-62.0, -32.0]);
        check("s6", 90.0, [71.0, 93.0]);
        check("u6", 160.0, [190.0, 215.0]);
        check("U7", 45.0, [-86.0, -61.0]);
        check("c11", 45.0, [-290.0, -130.0]);
        check("B12", 16.0, [150.0, 330.0]);
        check("ZC8", 20.0, [-221.0, -188.0]);
        check("zc9", 450.0, [2400.0, 2555.0]);
        check("X9", 3.0, [-45.0, -20.0]);
        check("H4", 20.0, [0.0, 6.0]);
        let none = [("H7", 501.0), ("q6", 20.0), ("H", 20.0), ("t6", 20.0), ("h19", 20.0)];
        for (letters, mm) in none.into_iter().chain([("K9", 20.0), ("Za6", 20.0), ("j66", 20.0)]) {
            assert_eq!(limits(letters, mm * 1e-3), None, "{letters} {mm}");
        }
    }
}
