//! Lines of the grids of plots: at round numbers, as many as have room, and three at least.

use egui_plot::{GridInput, GridMark};

/// Space between labels, in smallest spaces of the grid.
const ROOM: f64 = 1.6;

/// The lines of an axis; each has a label.
#[expect(clippy::needless_pass_by_value, reason = "the signature that plots ask for")]
pub(super) fn marks(input: GridInput) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few hundred")]
    let most = ((high - low) / (ROOM * input.base_step_size)).clamp(0.0, 100.0) as usize;
    let values = bksim_plot::round_numbers(low, high, most);
    let step = values.windows(2).map(|pair| pair[1] - pair[0]).fold(high - low, f64::min);
    let mark = |value| GridMark { value, step_size: step };
    values.into_iter().map(mark).collect()
}

/// The number at a line, with the decimals that tell it from its neighbours.
pub(super) fn label(mark: GridMark) -> String {
    let GridMark { value, step_size: step } = mark;
    if !(step.is_finite() && step > 0.0) || value.abs() < 1e-6 * step {
        return "0".to_owned();
    }
    let power = (step.log10() + 1e-9).floor();
    if !(-4.0..6.0).contains(&power) || value.abs() >= 1e6 {
        // As many digits as the step asks for.
        let digits = (value.abs().log10().floor() - power).clamp(0.0, 9.0);
        return format!("{value:.*e}", whole(digits));
    }
    format!("{value:.*}", whole((-power).max(0.0)))
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 9")]
fn whole(digits: f64) -> usize {
    digits as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_tell_neighbours_apart_and_zero_has_no_sign() {
        let cases = [
            ((-0.0, 0.5), "0"),
            ((-1e-17, 0.2), "0"),
            ((0.5, 0.5), "0.5"),
            ((1.5, 0.5), "1.5"),
            ((-0.25, 0.05), "-0.25"),
            ((15000.0, 5000.0), "15000"),
            ((2e-7, 1e-7), "2e-7"),
            ((1.5e7, 5e6), "1.5e7"),
        ];
        for ((value, step_size), expected) in cases {
            assert_eq!(label(GridMark { value, step_size }), expected);
        }
    }

    #[test]
    fn an_axis_of_any_length_has_three_labels() {
        for (low, high) in [(0.0, 1.0), (-0.013, 0.027), (99.0, 104.0), (1e-9, 3e-9)] {
            // 30 to 3000 pixels, where the grid wants 28 between lines.
            for pixels in [30.0, 80.0, 200.0, 700.0, 3000.0] {
                let base_step_size = (high - low) * 28.0 / pixels;
                let found = marks(GridInput { bounds: (low, high), base_step_size });
                assert!(found.len() >= 3, "{low} to {high} on {pixels}: {found:?}");
                let room = pixels / found.len() as f64;
                assert!(room > 28.0 || found.len() <= 6, "{low} to {high} on {pixels}: {found:?}");
            }
        }
    }
}
