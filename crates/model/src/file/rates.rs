//! States whose `start` has no unit: that of their `rate` gives them one, before anything uses them.
//!
//! ```text
//! rate = "0.3 m - S.position", start = 0      a state in m s
//! ```

use super::dimension::Dimension;
use super::gather::sub_tables;
use super::names::{Meaning, Names};
use super::reader::Reader;
use super::sampled::names_used;
use super::tree::{Node, Table};
use super::units::Quantity;
use super::value::{Kind, Lowered, Scope};

/// A state whose dimension is open.
pub(super) struct OpenState<'t> {
    /// Place among the values of the reader.
    pub(super) value_idx: usize,
    /// Rate of the state.
    rate: &'t Node,
}

impl Reader<'_> {
    /// The states without a dimension that have a rate.
    pub(super) fn open_states<'t>(&self, root: &'t Table) -> Vec<OpenState<'t>> {
        let states = sub_tables(root, "states").into_iter().enumerate();
        let open = states.filter_map(|(value_idx, (_, _, table))| {
            let is_open = self.values[value_idx].as_ref()?.kind == Kind::Bare;
            let rate = &table?.get("rate")?.node;
            is_open.then_some(OpenState { value_idx, rate })
        });
        open.collect()
    }

    /// Gives states the dimension of their rate times a second, where that has one by what is known so far; those
    /// that stay open are left in the list. Faults are left to the reading of the rates themselves.
    pub(super) fn infer_states(&mut self, open: &mut Vec<OpenState<'_>>) {
        let second = Quantity::TIME.dimension();
        loop {
            let n_before = open.len();
            let mut is_left = Vec::with_capacity(n_before);
            for state in &*open {
                let (n_faults, n_calls) = (self.faults.len(), self.table_calls.len());
                let rate = self.lowered(state.rate, "a rate", Scope::Load);
                let is_faulty = self.faults.len() > n_faults;
                self.faults.truncate(n_faults);
                self.table_calls.truncate(n_calls);
                let rate = rate.filter(|_| !is_faulty);
                let (Some(Lowered { kind: Kind::Known(dimension), is_angle, .. }), Some(value)) =
                    (rate, self.values[state.value_idx].as_mut())
                else {
                    is_left.push(true);
                    continue;
                };
                is_left.push(false);
                let dimension = dimension.times(second);
                value.kind = Kind::Known(dimension);
                value.is_angle = is_angle && dimension == Dimension::NONE;
            }
            let mut is_left = is_left.into_iter();
            open.retain(|_| is_left.next().unwrap_or(true));
            if open.is_empty() || open.len() == n_before {
                return;
            }
        }
    }

    /// The signals that the rates of these open states use, each state with those of the states that it uses: names
    /// that should be known before the state is used.
    pub(super) fn names_behind(&mut self, open: &[OpenState<'_>], used: &[&str]) -> Vec<String> {
        let state = |names: &Names, name: &str| match names.plain(name) {
            Some(Meaning::Value(idx)) => open.iter().position(|state| state.value_idx == idx),
            _ => None,
        };
        let mut seen = vec![false; open.len()];
        let mut names = Vec::new();
        let mut next: Vec<usize> =
            used.iter().filter_map(|name| state(&self.names, name)).collect();
        while let Some(idx) = next.pop() {
            if std::mem::replace(&mut seen[idx], true) {
                continue;
            }
            let Some(quoted) = open[idx].rate.text(self.text) else { continue };
            let n_faults = self.faults.len();
            let syntax = self.parse(&quoted, "a rate", "0.5");
            self.faults.truncate(n_faults);
            let Some(syntax) = syntax else { continue };
            for name in names_used(&syntax).concat() {
                next.extend(state(&self.names, name));
                names.push(name.to_owned());
            }
        }
        names
    }
}
