//! The N-four-bar as one equation: on the branch of parallelograms all uprights turn by θ, clockwise
//! from upright,
//!
//! ```text
//! ((N + 1)/3 + N) θ″ = ((N + 1)/2 + N) g sin θ,   θ(0) = 0,  θ′(0) = 1
//! ```
//!
//! (IFToMM benchmark A02: links of 1 m and 1 kg, g = 9.81 m/s².)

use bksim::dae::{Control, Index, Layout, NotFinite, Ode, Settings, Start, Tolerance, solve_ode};

/// θ(t), rad, to about ten digits.
pub(crate) fn angle(n: usize, t: f64) -> f64 {
    let settings = Settings { rtol: 1e-13, atol: Tolerance::Scalar(1e-13), ..Settings::default() };
    let start = Start { t: 0.0, y: vec![0.0, 1.0], ydot: vec![0.0; 2] };
    let end = solve_ode(Uprights::new(n), start, t, settings, &mut |_| Control::Continue);
    end.map_or(f64::NAN, |end| end.y[0])
}

/// The equation, y = (θ, θ′).
struct Uprights {
    layout: Layout,
    /// θ″ / sin θ, 1/s².
    stiffness: f64,
}

impl Uprights {
    fn new(n: usize) -> Self {
        let (uprights, beams) = (n as f64 + 1.0, n as f64);
        let stiffness = 9.81 * (uprights / 2.0 + beams) / (uprights / 3.0 + beams);
        Self { layout: Layout::from_groups(&[(2, Index::One)]), stiffness }
    }
}

impl Ode for Uprights {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn derivative(&mut self, _t: f64, y: &[f64], ydot: &mut [f64]) -> Result<(), NotFinite> {
        ydot[0] = y[1];
        ydot[1] = self.stiffness * y[0].sin();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::angle;

    /// Closed form by elliptic functions, 22 digits.
    #[test]
    fn angles_are_those_of_the_closed_form() {
        for (n, expected) in
            [(2, 31.750_597_186_986_102), (10, 31.621_729_822_781_873), (40, 31.597_433_743_985_74)]
        {
            let found = angle(n, 10.0);
            assert!((found - expected).abs() < 1e-9, "N = {n}: {found}");
        }
    }
}
