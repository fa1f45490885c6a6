//! Output at given times.

/// Times at which output is wanted, handed out as steps pass them.
///
/// ```
/// let mut times = bksim_dae::OutputTimes::new(&[0.0, 0.5, 1.0, 1.5]);
/// assert_eq!(times.due(0.9, 0.9), [0.0, 0.5]);
/// assert_eq!(times.due(1.5, 0.6), [1.0, 1.5]);
/// ```
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct OutputTimes<'a> {
    left: &'a [f64],
}

impl<'a> OutputTimes<'a> {
    /// Times in the order in which the run meets them: descending when it goes backwards.
    pub fn new(times: &'a [f64]) -> Self {
        Self { left: times }
    }

    /// The times up to `t1`, the end of a step of signed size `h`; each is handed out once.
    pub fn due(&mut self, t1: f64, h: f64) -> &'a [f64] {
        let n = self.left.iter().take_while(|&&t| (t1 - t) * h.signum() >= 0.0).count();
        let (due, left) = self.left.split_at(n);
        self.left = left;
        due
    }
}
