//! Frequency response of a linear system, with its poles and zeros.
//!
//! ```text
//! H(i ω) = C (i ω − A)⁻¹ B + D
//! zeros of one input and one output:  det [ A − s   b ] = 0
//!                                         [ cᵀ      d ]
//! ```
//!
//! The zeros are generalised eigenvalues: with a shift σ, those of (P − σ N)⁻¹ N are 1/(s − σ). As many are finite as
//! there are states, less the number of derivatives of the output before the input is seen.

use bksim_model::Model;
use bksim_sim::Svd;
use nalgebra::{Complex, DMatrix};

use crate::about::About;
use crate::channels::Channels;
use crate::eigenvalues::eigenvalues;
use crate::error::AnalysisError;
use crate::linear::{Linear, linearize};
use crate::table::{Column, Table};

/// Frequencies in even steps of their logarithm, rad/s.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Frequencies {
    /// The lowest, above zero.
    pub from: f64,
    /// The highest.
    pub to: f64,
    /// How many, at least one.
    pub n: usize,
}

/// The response of outputs to inputs.
#[derive(Clone, PartialEq, Debug)]
pub struct Response {
    /// The system.
    pub linear: Linear,
    /// rad/s.
    pub omega: Vec<f64>,
    /// Of each input, of each output.
    pub transfers: Vec<Transfer>,
}

/// The response of one output to one input.
#[derive(Clone, PartialEq, Debug)]
pub struct Transfer {
    /// The input.
    pub input: String,
    /// The output.
    pub output: String,
    /// |H|, in the unit of the output over that of the input.
    pub gain: Vec<f64>,
    /// arg H, rad, without jumps; that of the first frequency lies in −π … π.
    pub phase: Vec<f64>,
    /// Zeros, 1/s: real and imaginary part.
    pub zeros: Vec<[f64; 2]>,
}

/// Finds the frequency response of `model` about a state; frequencies that are not given reach a decade beyond
/// the poles.
///
/// # Errors
/// [`AnalysisError`] as [`linearize`]; without inputs or outputs there is no response.
pub fn bode(
    model: Model,
    about: About,
    channels: &Channels,
    frequencies: Option<Frequencies>,
) -> Result<Response, AnalysisError> {
    let channels = &channels.or_stated(&model);
    if channels.inputs.is_empty() || channels.outputs.is_empty() {
        return Err(AnalysisError::NoChannels);
    }
    let linear = linearize(model, about, channels)?;
    let frequencies = frequencies.unwrap_or_else(|| around(&linear.poles));
    let last = (frequencies.n - 1).max(1) as f64;
    let ratio = frequencies.to / frequencies.from;
    let omega: Vec<f64> =
        (0..frequencies.n).map(|k| frequencies.from * ratio.powf(k as f64 / last)).collect();
    let responses: Vec<DMatrix<Complex<f64>>> = omega.iter().map(|&w| at(&linear, w)).collect();

    let mut transfers = Vec::new();
    for (j, input) in linear.inputs.iter().enumerate() {
        for (i, output) in linear.outputs.iter().enumerate() {
            let values: Vec<Complex<f64>> = responses.iter().map(|h| h[(i, j)]).collect();
            let mut phase: Vec<f64> = values.iter().map(|h| h.arg()).collect();
            for k in 1..phase.len() {
                phase[k] = phase[k - 1] + crate::rows::wrapped(phase[k] - phase[k - 1]);
            }
            transfers.push(Transfer {
                input: input.clone(),
                output: output.name.clone(),
                gain: values.iter().map(|h| h.norm()).collect(),
                phase,
                zeros: zeros(&linear, j, i),
            });
        }
    }
    Ok(Response { linear, omega, transfers })
}

/// From a decade below the slowest pole to one above the fastest.
fn around(poles: &[[f64; 2]]) -> Frequencies {
    let sizes = poles.iter().map(|[re, im]| re.hypot(*im));
    let largest = sizes.clone().fold(0.0, f64::max);
    let sizes: Vec<f64> = sizes.filter(|size| *size > 1e-9 * largest).collect();
    let least = sizes.iter().copied().fold(f64::INFINITY, f64::min);
    let (least, largest) = if sizes.is_empty() { (1.0, 1.0) } else { (least, largest) };
    Frequencies { from: 0.1 * least, to: 10.0 * largest, n: 201 }
}

/// H(i ω); at an undamped pole itself infinite.
fn at(linear: &Linear, omega: f64) -> DMatrix<Complex<f64>> {
    let complex = |matrix: &DMatrix<f64>| matrix.map(|x| Complex::new(x, 0.0));
    let n = linear.a.nrows();
    let s = DMatrix::from_diagonal_element(n, n, Complex::new(0.0, omega));
    let solved = (s - complex(&linear.a)).lu().solve(&complex(&linear.b));
    let infinite = || DMatrix::from_element(n, linear.b.ncols(), Complex::new(f64::INFINITY, 0.0));
    complex(&linear.c) * solved.unwrap_or_else(infinite) + complex(&linear.d)
}

/// Parts of what a product of matrices can be below which it counts as zero.
const NOTHING: f64 = 1e-11;

/// A shift, in units in which poles have about the size one, that is hardly a zero.
const SHIFT: f64 = 0.618_033_988_749_894_9;

/// The zeros from one input to one output, ascending by size.
fn zeros(linear: &Linear, input: usize, output: usize) -> Vec<[f64; 2]> {
    let n = linear.a.nrows();
    // In a unit of time in which the poles have about the size one; rates are per that unit.
    let sizes = linear.poles.iter().map(|[re, im]| re.hypot(*im)).filter(|size| *size > 0.0);
    let (sum, count) = sizes.fold((0.0, 0.0), |(sum, n), size| (sum + size.ln(), n + 1.0));
    let rate: f64 = if count > 0.0 { f64::exp(sum / count) } else { 1.0 };
    let unit = |i: usize| if i < n / 2 { 1.0 } else { rate };
    let a = DMatrix::from_fn(n, n, |i, k| linear.a[(i, k)] * unit(k) / (unit(i) * rate));
    let b = DMatrix::from_fn(n, 1, |i, _| linear.b[(i, input)] / (unit(i) * rate));
    let c = DMatrix::from_fn(1, n, |_, k| linear.c[(output, k)] * unit(k));
    let d = linear.d[(output, input)];
    let (size_b, size_c) = (b.norm().max(1e-300), c.norm().max(1e-300));
    let (b, c, d) = (&b / size_b, &c / size_c, d / (size_b * size_c));

    // Number of integrations from the input to the output.
    let mut power = b.clone();
    let mut steps = 0;
    if d.abs() <= NOTHING {
        loop {
            steps += 1;
            let seen = (&c * &power)[(0, 0)].abs();
            if seen > NOTHING * power.norm() {
                break;
            }
            if steps >= n {
                return Vec::new();
            }
            power = &a * power;
        }
    }
    let n_finite = n - steps;
    if n_finite == 0 {
        return Vec::new();
    }
    let mut whole = DMatrix::zeros(n + 1, n + 1);
    whole.view_mut((0, 0), (n, n)).copy_from(&a);
    whole.view_mut((0, n), (n, 1)).copy_from(&b);
    whole.view_mut((n, 0), (1, n)).copy_from(&c);
    whole[(n, n)] = if d.abs() <= NOTHING { 0.0 } else { d };
    let mut unit = DMatrix::identity(n + 1, n + 1);
    unit[(n, n)] = 0.0;
    let Some(inverse) = (&whole - &unit * SHIFT).try_inverse() else { return Vec::new() };
    let product = inverse * &unit;
    if product.iter().any(|x| !x.is_finite()) {
        return Vec::new();
    }
    let mut values = eigenvalues(&product);
    values.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
    values.truncate(n_finite);
    let mut found: Vec<Complex<f64>> = values
        .into_iter()
        .map(|value| Complex::new(SHIFT, 0.0) + value.inv())
        .map(|s| polished(&whole, &unit, s) * rate)
        .collect();
    found.sort_by(|a, b| a.norm().total_cmp(&b.norm()).then(a.im.total_cmp(&b.im)));
    // What is left by rounding of a pure frequency, or of a real zero, is none.
    let clean = |part: f64, size: f64| if part.abs() <= 1e-12 * size { 0.0 } else { part };
    found.iter().map(|s| [clean(s.re, s.norm()), clean(s.im, s.norm())]).collect()
}

/// A zero after Newton's steps on uᴴ (P − s N) x = 0, with the singular vectors.
fn polished(whole: &DMatrix<f64>, unit: &DMatrix<f64>, s: Complex<f64>) -> Complex<f64> {
    let complex = |matrix: &DMatrix<f64>| matrix.map(|x| Complex::new(x, 0.0));
    let (whole, unit) = (complex(whole), complex(unit));
    let is_real = s.im == 0.0;
    let mut best = s;
    for _ in 0..3 {
        let pencil = &whole - &unit * best;
        let Some(svd) = Svd::new(&pencil) else { return best };
        let last = svd.last();
        let (left, x) = (svd.u.column(last).adjoint(), svd.v_t.row(last).adjoint());
        let slope = (&left * &unit * &x)[(0, 0)];
        let step = (&left * pencil * &x)[(0, 0)] / slope;
        if !(step.re.is_finite() && step.im.is_finite()) || step.norm() > 1e-4 * best.norm() {
            return best;
        }
        best += step;
        if is_real {
            best.im = 0.0;
        }
    }
    best
}

impl Response {
    /// A row for each frequency: ω, then gain and phase of each pair.
    pub fn table(&self) -> Table {
        let mut columns = vec![Column::new("omega", "rad/s")];
        for transfer in &self.transfers {
            let pair = format!("{}/{}", transfer.output, transfer.input);
            columns.push(Column::new(format!("gain {pair}"), ""));
            columns.push(Column::new(format!("phase {pair}"), "rad"));
        }
        let row = |k: usize| {
            let parts = self.transfers.iter().flat_map(|t| [t.gain[k], t.phase[k]]);
            std::iter::once(self.omega[k]).chain(parts).collect()
        };
        Table { columns, rows: (0..self.omega.len()).map(row).collect() }
    }
}
