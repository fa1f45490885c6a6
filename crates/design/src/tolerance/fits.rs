//! Limits of ISO 286 by their letters: `H7`, `g6`, `js5`.
//!
//! A table has the standard tolerances and the fundamental deviations for sizes up to 500 mm, in micrometres. A hole `D` to `H` has the
//! deviation of the shaft below it with the other sign.
//!
//! Source: ISO 286-1:2010, tables 1, 2, 4 and 5, the values rounded as there.

/// Largest size of each step, mm.
const STEPS: [f64; 13] =
    [3.0, 6.0, 10.0, 18.0, 30.0, 50.0, 80.0, 120.0, 180.0, 250.0, 315.0, 400.0, 500.0];

/// Standard tolerances IT5 to IT13 of each step, µm.
const GRADES: [[f64; 13]; 9] = [
    [4.0, 5.0, 6.0, 8.0, 9.0, 11.0, 13.0, 15.0, 18.0, 20.0, 23.0, 25.0, 27.0],
    [6.0, 8.0, 9.0, 11.0, 13.0, 16.0, 19.0, 22.0, 25.0, 29.0, 32.0, 36.0, 40.0],
    [10.0, 12.0, 15.0, 18.0, 21.0, 25.0, 30.0, 35.0, 40.0, 46.0, 52.0, 57.0, 63.0],
    [14.0, 18.0, 22.0, 27.0, 33.0, 39.0, 46.0, 54.0, 63.0, 72.0, 81.0, 89.0, 97.0],
    [25.0, 30.0, 36.0, 43.0, 52.0, 62.0, 74.0, 87.0, 100.0, 115.0, 130.0, 140.0, 155.0],
    [40.0, 48.0, 58.0, 70.0, 84.0, 100.0, 120.0, 140.0, 160.0, 185.0, 210.0, 230.0, 250.0],
    [60.0, 75.0, 90.0, 110.0, 130.0, 160.0, 190.0, 220.0, 250.0, 290.0, 320.0, 360.0, 400.0],
    [100.0, 120.0, 150.0, 180.0, 210.0, 250.0, 300.0, 350.0, 400.0, 460.0, 520.0, 570.0, 630.0],
    [140.0, 180.0, 220.0, 270.0, 330.0, 390.0, 460.0, 540.0, 630.0, 720.0, 810.0, 890.0, 970.0],
];

/// Grade of the first row of [`GRADES`].
const FIRST_GRADE: usize = 5;

/// Upper deviations of shafts, µm, the sign left out.
const ABOVE: [(&str, [f64; 13]); 5] = [
    ("d", [20.0, 30.0, 40.0, 50.0, 65.0, 80.0, 100.0, 120.0, 145.0, 170.0, 190.0, 210.0, 230.0]),
    ("e", [14.0, 20.0, 25.0, 32.0, 40.0, 50.0, 60.0, 72.0, 85.0, 100.0, 110.0, 125.0, 135.0]),
    ("f", [6.0, 10.0, 13.0, 16.0, 20.0, 25.0, 30.0, 36.0, 43.0, 50.0, 56.0, 62.0, 68.0]),
    ("g", [2.0, 4.0, 5.0, 6.0, 7.0, 9.0, 10.0, 12.0, 14.0, 15.0, 17.0, 18.0, 20.0]),
    ("h", [0.0; 13]),
];

/// Lower deviations of shafts, µm; `k` of the grades 5 to 7.
const BELOW: [(&str, [f64; 13]); 4] = [
    ("k", [0.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0, 5.0]),
    ("m", [2.0, 4.0, 6.0, 7.0, 8.0, 9.0, 11.0, 13.0, 15.0, 17.0, 20.0, 21.0, 23.0]),
    ("n", [4.0, 8.0, 10.0, 12.0, 15.0, 17.0, 20.0, 23.0, 27.0, 31.0, 34.0, 37.0, 40.0]),
    ("p", [6.0, 12.0, 15.0, 18.0, 22.0, 26.0, 32.0, 37.0, 43.0, 50.0, 56.0, 62.0, 68.0]),
];

/// Lower and upper deviation of a size by its letters, both in m; none of other letters, grades and sizes.
pub(super) fn limits(letters: &str, nominal: f64) -> Option<[f64; 2]> {
    const MICROMETRE: f64 = 1e-6;
    /// Sizes that the author writes in inches meet no step to the last bit.
    const ROUNDING: f64 = 1e-9;
    let digits = letters.find(|c: char| c.is_ascii_digit())?;
    let (class, grade) = letters.split_at(digits);
    let row = grade.parse::<usize>().ok()?.checked_sub(FIRST_GRADE)?;
    let size = nominal * 1e3;
    let step = STEPS.iter().position(|&step| size <= step + ROUNDING).filter(|_| size > 0.0)?;
    let width = GRADES.get(row)?[step];
    let of = |table: &[(&str, [f64; 13])], class: &str| {
        table.iter().find(|(known, _)| *known == class).map(|(_, values)| values[step])
    };
    let lower_case = class.to_ascii_lowercase();
    let is_hole = class.starts_with(|c: char| c.is_ascii_uppercase());
    let [low, high] = if class == "js" || class == "JS" {
        [-0.5 * width, 0.5 * width]
    } else if let Some(off) = of(&ABOVE, &lower_case) {
        if is_hole { [off, off + width] } else { [-off - width, -off] }
    } else if is_hole {
        // Holes with an excess have corrections by grade.
        return None;
    } else {
        let off = of(&BELOW, class)?;
        let off = if class == "k" && row > 2 { 0.0 } else { off };
        [off, off + width]
    };
    Some([low * MICROMETRE, high * MICROMETRE])
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
        for (letters, mm) in [("P7", 25.0), ("H7", 501.0), ("H4", 20.0), ("q6", 20.0), ("H", 20.0)]
        {
            assert_eq!(limits(letters, mm * 1e-3), None, "{letters} {mm}");
        }
    }
}
