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

#[cfg(test)]
mod tests {
    use super::*;

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
