//! Sensitivities of explicit equations: the variational equations beside the equations.
//!
//! ```text
//! y′ = f(t, y),   s_k′ = ∂f/∂y s_k + ∂f/∂p_k,   s_k = ∂y/∂p_k      HNW1 §I.14
//! ```

use crate::system::Ode;
use crate::{Index, Layout, NotFinite, Start};

/// Explicit equations that know their derivatives.
pub trait VariationalOde: Ode {
    /// Number of parameters.
    fn n_parameters(&self) -> usize;

    /// Writes `∂f/∂y s_k + ∂f/∂p_k` to `out` for every parameter; `s` and `out` hold one vector of
    /// length `n` after the other.
    ///
    /// # Errors
    /// [`NotFinite`] names the first row of `f` whose derivatives have no finite value.
    fn variation(&mut self, t: f64, y: &[f64], s: &[f64], out: &mut [f64])
    -> Result<(), NotFinite>;
}

/// Equations with their variational equations, `(y, s_1, s_2, …)`, as one system for
/// [`crate::ExplicitSolver`].
///
/// The error test looks at the sensitivities too, with the tolerances given for them: one number
/// for all, or one for each of the `n (1 + n_parameters)` unknowns. [`Ode::project`] moves `y`
/// alone, by its error.
pub struct Variational<S> {
    system: S,
    n: usize,
    layout: Layout,
}

impl<S: VariationalOde> Variational<S> {
    /// With sensitivities to all parameters.
    pub fn new(system: S) -> Self {
        let (n, count) = (system.layout().n(), system.n_parameters());
        let own = system.layout();
        let by_parameter =
            (0..count).flat_map(|k| (0..n).map(move |i| format!("∂{}/∂p[{k}]", own.name(i))));
        let names = (0..n).map(|i| own.name(i)).chain(by_parameter).collect();
        let layout = Layout::new(vec![Index::One; n * (1 + count)]).with_names(names);
        Self { system, n, layout }
    }

    /// The start of both; `s` holds one vector of length `n` per parameter.
    pub fn start(start: &Start, s: &[Vec<f64>]) -> Start {
        let y = [start.y.as_slice(), &s.concat()].concat();
        Start { t: start.t, ydot: vec![0.0; y.len()], y }
    }

    /// `∂y/∂p_k` in a state of both.
    pub fn sensitivity<'a>(&self, state: &'a [f64], k: usize) -> &'a [f64] {
        &state[(k + 1) * self.n..(k + 2) * self.n]
    }
}

impl<S: VariationalOde> Ode for Variational<S> {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn derivative(&mut self, t: f64, y: &[f64], ydot: &mut [f64]) -> Result<(), NotFinite> {
        let (y, s) = y.split_at(self.n);
        let (ydot, sdot) = ydot.split_at_mut(self.n);
        self.system.derivative(t, y, ydot)?;
        self.system.variation(t, y, s, sdot)
    }

    fn project(&mut self, t: f64, y: &mut [f64]) -> Result<(), NotFinite> {
        self.system.project(t, &mut y[..self.n])
    }
}
