//! [`State`] and [`Acceleration`]: the unknowns of the equations of motion at one instant.

/// Positions and velocities at one instant.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct State {
    /// Time, s.
    pub t: f64,
    /// Generalised coordinates, nq, rad or m.
    pub q: Vec<f64>,
    /// Velocities, nq, rad/s or m/s.
    pub v: Vec<f64>,
}

/// A borrowed [`State`]: functions take it from wherever the numbers lie, without a copy.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct StateRef<'a> {
    /// Time, s.
    pub t: f64,
    /// Generalised coordinates, nq, rad or m.
    pub q: &'a [f64],
    /// Velocities, nq, rad/s or m/s.
    pub v: &'a [f64],
}

/// Accelerations and multipliers that belong to a [`State`].
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Acceleration {
    /// Accelerations, nq, rad/s² or m/s².
    pub a: Vec<f64>,
    /// Multipliers, nc, N or N m.
    pub lambda: Vec<f64>,
}

/// A borrowed [`Acceleration`].
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct AccelerationRef<'a> {
    /// Accelerations, nq, rad/s² or m/s².
    pub a: &'a [f64],
    /// Multipliers, nc, N or N m.
    pub lambda: &'a [f64],
}

impl State {
    /// Numbers of the state, borrowed.
    pub fn as_ref(&self) -> StateRef<'_> {
        StateRef { t: self.t, q: &self.q, v: &self.v }
    }
}

impl StateRef<'_> {
    /// A copy with numbers of its own.
    pub fn to_state(self) -> State {
        State { t: self.t, q: self.q.to_vec(), v: self.v.to_vec() }
    }
}

impl Acceleration {
    /// Room for the accelerations and multipliers of a mechanism.
    pub fn zeros(nq: usize, nc: usize) -> Self {
        Self { a: vec![0.0; nq], lambda: vec![0.0; nc] }
    }

    /// Numbers of the acceleration, borrowed.
    pub fn as_ref(&self) -> AccelerationRef<'_> {
        AccelerationRef { a: &self.a, lambda: &self.lambda }
    }
}
