//! Values of parameters with which a start closes at all the values that it states: lengths of rods, places of pins.
//!
//! ```text
//! Φ(x, p) = 0     rows of joints and drives, and of every stated position
//! [Φ_x Φ_p] (δx, δp) = −Φ,  the smallest such step        Φ_p by central differences
//! ```

use bksim_model::{Measure, Model, ParameterId};
use bksim_sim::Svd;
use nalgebra::{DMatrix, DVector};

use crate::error::AnalysisError;
use crate::loaded::varied;
use crate::positions::Positions;
use crate::rows::{Clock, Rows};
use crate::table::{Column, Table};

/// Values with which a start closes.
#[derive(Clone, PartialEq, Debug)]
pub struct Closing {
    /// Each parameter with the value that closes, and its own, SI.
    pub values: Vec<(Column, f64, f64)>,
    /// Everything that the pose shows then.
    pub pose: Vec<(String, f64, &'static str)>,
}

/// Largest row of a start that is closed, in radians and longest links.
const CLOSED: f64 = 1e-11;
/// Part of the largest singular value below which parameters are not determined.
const OPEN: f64 = 1e-9;

/// The values of the parameters `names` with which the start of `model` closes.
///
/// # Errors
/// [`AnalysisError`] where no values close it, or more than one set does.
pub fn closing(mut model: Model, names: &[String]) -> Result<Closing, AnalysisError> {
    let parameter = |name: &String| {
        let found = model.parameters.iter().position(|p| p.name == *name);
        found.map(ParameterId).ok_or_else(|| AnalysisError::UnknownParameter { name: name.clone() })
    };
    let free: Vec<ParameterId> = names.iter().map(parameter).collect::<Result<_, _>>()?;
    // What is stated is asked for here; the start itself takes it as a guess.
    let mut stated = Vec::new();
    for initial in model.initial.iter_mut().filter(|i| !i.is_guess && !i.measure.is_velocity()) {
        initial.is_guess = true;
        stated.push((initial.measure, initial.value));
    }
    model.assembly = None;
    let positions = Positions::of(model)?;
    let measures: Vec<Measure> = stated.iter().map(|(measure, _)| *measure).collect();
    let rows = positions.rows(&measures, &[], Clock::Held)?;
    let mut search = Search { positions: &positions, free: &free, stated: &stated, rows };
    let own: Vec<f64> = free.iter().map(|id| positions.mechanism.parameters[id.0]).collect();
    let (q, p) = search.solution(&own, names)?;

    let parameters = search.parameters(&p);
    let mut scalars = positions.scalars(positions.quantities())?;
    scalars.set_parameters(&parameters);
    let values = scalars.values(positions.t(), &q);
    let shown = positions.quantities().iter().zip(values);
    let column = |id: &ParameterId| {
        let parameter = &positions.model().parameters[id.0];
        Column::new(parameter.name.clone(), parameter.unit.clone())
    };
    let values = free.iter().zip(p.iter().zip(&own));
    Ok(Closing {
        values: values.map(|(id, (value, own))| (column(id), *value, *own)).collect(),
        pose: shown.map(|(q, value)| (q.names[0].clone(), value, q.unit)).collect(),
    })
}

/// A search for positions and parameters.
struct Search<'a> {
    positions: &'a Positions,
    free: &'a [ParameterId],
    stated: &'a [(Measure, bksim_expr::Expr)],
    rows: Rows,
}

impl Search<'_> {
    /// Values of all parameters, those that follow from the free ones among them.
    fn parameters(&self, p: &[f64]) -> Vec<f64> {
        let own = &self.positions.mechanism.parameters;
        let mut all = own.clone();
        let changed = varied(self.positions.model(), own, self.free, p);
        all[..changed.len()].copy_from_slice(&changed);
        all
    }

    /// Rows with their slopes at a position, and values of the free parameters.
    fn at(&mut self, x: &[f64], p: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let model = self.positions.model();
        let parameters = self.parameters(p);
        let value = |symbol| {
            let known = model.parameters.iter().position(|of| of.symbol == symbol)?;
            Some(parameters[known])
        };
        let stated = self.stated.iter();
        let u: Vec<f64> =
            stated.map(|(_, e)| model.pool.evaluate(*e, &value).unwrap_or(f64::NAN)).collect();
        self.rows.set_parameters(&parameters);
        let at = self.rows.at(self.positions.t(), x, &u);
        (at.value, at.jacobian)
    }

    /// Position and parameters that close all rows, by Gauss and Newton.
    fn solution(
        &mut self,
        own: &[f64],
        names: &[String],
    ) -> Result<(Vec<f64>, Vec<f64>), AnalysisError> {
        const MOST: usize = 80;
        const LONGEST: f64 = 0.3;
        let (n, n_free) = (self.rows.n(), self.free.len());
        let mut x = self.rows.scaled(&self.positions.q);
        let mut p = own.to_vec();
        let unit: Vec<f64> =
            own.iter().map(|p| if *p == 0.0 { self.positions.size } else { p.abs() }).collect();
        let unclosed = || AnalysisError::NotClosed { names: names.to_vec() };
        for _ in 0..MOST {
            let (value, slopes) = self.at(&x, &p);
            let mut all = DMatrix::zeros(slopes.nrows(), n + n_free);
            all.columns_mut(0, n).copy_from(&slopes);
            for k in 0..n_free {
                let step = 1e-6 * unit[k];
                let mut aside = |sign: f64| {
                    let mut p = p.clone();
                    p[k] += sign * step;
                    self.at(&x, &p).0
                };
                let slope = (aside(1.0) - aside(-1.0)) * (0.5 / 1e-6);
                all.column_mut(n + k).copy_from(&slope);
            }
            let svd = Svd::new(&all).ok_or_else(unclosed)?;
            if value.amax() < CLOSED {
                let floor = OPEN * svd.largest();
                let rank = svd.singular_values.iter().filter(|s| **s > floor).count();
                if rank < n + n_free {
                    let n_open = n + n_free - rank;
                    return Err(AnalysisError::OpenStart { n: n_open, names: names.to_vec() });
                }
                return Ok((self.rows.unscaled(&x), p));
            }
            let step = svd.solve(&-value, 1e-10 * svd.largest());
            let size = step.norm();
            if !size.is_finite() {
                return Err(unclosed());
            }
            let share = (LONGEST / size).min(1.0);
            x.iter_mut().zip(step.iter()).for_each(|(x, step)| *x += share * step);
            for k in 0..n_free {
                p[k] += share * step[n + k] * unit[k];
            }
        }
        Err(unclosed())
    }
}

impl Closing {
    /// One row: the parameters, then the pose.
    pub fn table(&self) -> Table {
        let heads = self.values.iter().map(|(column, ..)| column.clone());
        let pose = self.pose.iter().map(|(name, _, unit)| Column::new(name.clone(), *unit));
        let values = self.values.iter().map(|(_, value, _)| *value);
        let row = values.chain(self.pose.iter().map(|(_, value, _)| *value)).collect();
        Table { columns: heads.chain(pose).collect(), rows: vec![row] }
    }
}
