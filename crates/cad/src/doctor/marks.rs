//! The findings of a drawing as marks in a copy of it.

use super::{DOCTOR_LAYER, Report};
use crate::write::Mark;
use crate::write::graft::Addition;

/// The size of a mark over the diagonal of the drawing.
const SIZE: f64 = 1.0 / 60.0;

/// A circle around each place, with the number of the finding, its code and its words next to the first.
pub fn marks(report: &Report) -> Addition {
    const RED: u8 = 1;
    let [low, high] = report.extent;
    let diagonal = (high[0] - low[0]).hypot(high[1] - low[1]);
    let size = SIZE * if diagonal > 0.0 { diagonal } else { 1.0 };
    let mut drawn = Vec::new();
    let mut n_apart = 0.0;
    for (idx, finding) in report.findings.iter().enumerate() {
        let (number, fault) = (idx + 1, &finding.fault);
        let words = format!("{number} {}: {}", fault.code.0, fault.message);
        for place in &finding.places {
            drawn.push(Mark::Circle(place.at, size));
        }
        // What has no place stands above the drawing.
        let at = if let Some(place) = finding.places.first() {
            [place.at[0] + 1.2 * size, place.at[1] + 0.4 * size]
        } else {
            n_apart += 1.0;
            [low[0], high[1] + 1.5 * size * n_apart]
        };
        drawn.push(Mark::text(at, 0.6 * size, words));
        for (place, others) in finding.places.iter().skip(1).zip(2..) {
            let at = [place.at[0] + 1.2 * size, place.at[1] + 0.4 * size];
            drawn.push(Mark::text(at, 0.6 * size, format!("{number} {}, {others}", fault.code.0)));
        }
    }
    Addition::on_layer(DOCTOR_LAYER, RED, drawn)
}
