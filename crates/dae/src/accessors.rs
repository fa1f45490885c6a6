//! Accessors that both solvers have.

/// Methods of a solver that show its fields `t`, `y`, `ydot`, `t_end`, `h`, `stats` and `system`.
macro_rules! accessors {
    ($system:ident) => {
        /// Time reached.
        pub fn t(&self) -> f64 {
            self.t
        }

        /// State at the time reached.
        pub fn y(&self) -> &[f64] {
            &self.y
        }

        /// Derivative at the time reached.
        pub fn ydot(&self) -> &[f64] {
            &self.ydot
        }

        /// Time at which the run is to end.
        pub fn t_end(&self) -> f64 {
            self.t_end
        }

        /// Size of the next step, signed.
        pub fn h(&self) -> f64 {
            self.h
        }

        /// Work done so far; evaluations of an explicit `f` are counted as residuals.
        pub fn stats(&self) -> &Stats {
            &self.stats
        }

        /// The system being solved.
        pub fn system_mut(&mut self) -> &mut $system {
            &mut self.system
        }
    };
}

pub(crate) use accessors;
