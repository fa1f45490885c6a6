//! `[curves.…]`: paths that points follow, by a formula or through points; and laws of motion.

use bksim_expr::Expr;

use super::codes;
use super::grids::{MeasuredTable, TableForm};
use super::pieces::{Columns, spline};
use super::reader::{Fields, Reader};
use super::tree::{Node, Table, Value};
use super::units::Quantity;
use super::value::{Kind, Scope};
use crate::curve::Curve;
use crate::diagnostic::{Diagnostic, Span};
use crate::ids::{CurveId, Vector};

/// The types of curve and their keys.
pub(super) const CURVES: [(&str, &[&str]); 4] = [
    ("formula", &["type", "formula", "parameter", "range"]),
    ("points", &["type", "points"]),
    ("cam-law", &["type", "segments", "turns"]),
    ("cam", &["type", "law", "base_circle", "follower", "sense"]),
];

impl Reader<'_> {
    /// Reads all curves: laws as functions, which formulas of paths may call, then paths for the joints that follow
    /// them.
    pub(super) fn read_curves(&mut self, root: &Table) {
        let is_law = |table: &Table| match table.get("type").map(|entry| &entry.node.value) {
            Some(Value::Text(word)) => word == "cam-law",
            _ => false,
        };
        let mut curves = self.own_tables(root, "curve");
        curves.sort_by_key(|(.., table)| !is_law(table));
        for (name, span, table) in curves {
            if !self.usable_name(name, &span, "curve") || self.is_taken(name, &span) {
                continue;
            }
            let owner = format!("curve `{name}`");
            let opened = Fields::of_type(self, table, owner, span, &CURVES);
            let Some((word, fields)) = opened else {
                self.curves.push((name.to_owned(), None));
                continue;
            };
            if word == "cam-law" {
                let form = self.read_law(name, &fields).map(TableForm::Columns);
                self.tables.push(MeasuredTable { name: name.to_owned(), form });
                continue;
            }
            let curve = match word {
                "formula" => self.read_formula(name, &fields),
                "cam" => self.read_cam(name, &fields),
                _ => self.read_path(name, &fields),
            };
            self.curves.push((name.to_owned(), curve));
        }
    }

    /// A point for each value of a parameter.
    fn read_formula(&mut self, name: &str, fields: &Fields<'_>) -> Option<Curve> {
        let parameter_name = match fields.get("parameter") {
            Some(node) => self.text_of(node, &fields.what("parameter"), "u")?.text.to_owned(),
            None => "p".to_owned(),
        };
        let help = "write for example `formula = [\"0.5 m*cos(p)\", \"0.3 m*sin(p)\"]`";
        let node = fields.require(self, "formula", help)?;
        let range = self.curve_range(fields);
        // Not an identifier, so that no name of the model can meet it.
        let symbol = self.pool.symbol(&format!("'along {name}"));
        self.local = Some((parameter_name.clone(), symbol));
        let vector = self.vector(node, Quantity::LENGTH, &fields.what("formula"), Scope::Constant);
        self.local = None;
        let (position, range) = (vector?.components, range?);
        let parameter = self.pool.symbol_id(symbol).expect("a symbol was just made");
        if !position.iter().any(|&component| self.pool.depends_on(component, parameter)) {
            self.report(
                Diagnostic::error(
                    codes::NO_CURVE,
                    format!("{} does not depend on its parameter `{parameter_name}`", fields.owner),
                )
                .at(node.span.clone(), "a single point")
                .help(help),
            );
            return None;
        }
        Some(Curve { name: name.to_owned(), parameter, position, range, cam: None })
    }

    /// First and last parameter, 0 and 2π if not stated.
    fn curve_range(&mut self, fields: &Fields<'_>) -> Option<[Expr; 2]> {
        let Some(node) = fields.get("range") else {
            return Some([self.pool.zero(), self.pool.mul(self.pool.int(2), self.pool.pi())]);
        };
        let what = fields.what("range");
        let nodes = self.array(node, &what, "an array of two numbers", "[0, \"2*pi\"]")?;
        let [from, to] = nodes else {
            self.wrong_kind(node, &what, "an array of two numbers", &node.value, "[0, \"2*pi\"]");
            return None;
        };
        let ends = [from, to].map(|n| self.scalar(n, Quantity::ANGLE, &what, Scope::Constant));
        let [Some(from), Some(to)] = ends else { return None };
        let (first, last) = (self.constants.pinned(from.value?), self.constants.pinned(to.value?));
        if first >= last {
            self.report(
                Diagnostic::error(codes::NO_CURVE, format!("{what} has no length"))
                    .at(node.span.clone(), "must ascend")
                    .help("write the smaller value first"),
            );
            return None;
        }
        Some([from.expr, to.expr])
    }

    /// A smooth curve through points, whose parameter counts them from 0.
    fn read_path(&mut self, name: &str, fields: &Fields<'_>) -> Option<Curve> {
        let help = "write for example `points = [[0, 0], [\"10 mm\", \"5 mm\"], [\"20 mm\", 0]]`";
        let node = fields.require(self, "points", help)?;
        let what = fields.what("points");
        let nodes = self.array(node, &what, "an array of points", "[[0, 0], [\"10 mm\", 0]]")?;
        let points: Option<Vec<[f64; 3]>> = nodes
            .iter()
            .enumerate()
            .map(|(idx, node)| {
                self.path_point(node, &format!("point {} of {}", idx + 1, fields.owner))
            })
            .collect();
        let points = points?;
        let same = points.windows(2).position(|pair| pair[0] == pair[1]);
        let fault = match same {
            Some(idx) => Some((
                format!("points {} and {} of {} are one", idx + 1, idx + 2, fields.owner),
                nodes[idx + 1].span.clone(),
            )),
            None if points.len() < 2 => {
                Some((format!("{what} has {} points", points.len()), node.span.clone()))
            }
            None => None,
        };
        if let Some((message, location)) = fault {
            self.report(
                Diagnostic::error(codes::NO_CURVE, message)
                    .at(location, "a curve needs two points at least, each another")
                    .help(help),
            );
            return None;
        }
        let last = points.len() - 1;
        let symbol = self.pool.symbol(&format!("'along {name}"));
        let mut component = |axis: usize| {
            if points.iter().all(|point| point[axis] == 0.0) {
                return self.pool.zero();
            }
            let knots: Vec<[f64; 2]> =
                points.iter().enumerate().map(|(k, point)| [k as f64, point[axis]]).collect();
            let x = knots.iter().map(|knot| knot[0]).collect();
            let columns = Columns::endless([Kind::Bare; 2], [false; 2], x, spline(&knots));
            let of = format!("{name}.{}", ["x", "y", "z"][axis]);
            let function = self.function_of_columns(&of, "p", &columns);
            self.pool.apply(function, &[symbol])
        };
        let position: Vector = [0, 1, 2].map(&mut component);
        let parameter = self.pool.symbol_id(symbol).expect("a symbol was just made");
        let end = i64::try_from(last).unwrap_or(i64::MAX);
        let range = [self.pool.zero(), self.pool.int(end)];
        Some(Curve { name: name.to_owned(), parameter, position, range, cam: None })
    }

    fn path_point(&mut self, node: &Node, what: &str) -> Option<[f64; 3]> {
        let vector = self.vector(node, Quantity::LENGTH, what, Scope::Constant)?;
        let position = vector.position?;
        Some(position.value.map(|value| self.constants.pinned(value)))
    }

    /// The curve that a joint names under a key.
    pub(super) fn curve_of(&mut self, fields: &Fields<'_>, key: &str) -> Option<CurveId> {
        let help = format!("write `{key} = \"track\"` with the name of a curve");
        let node = fields.require(self, key, &help)?;
        let quoted = self.text_of(node, &fields.what(key), "track")?;
        let found = self.curves.iter().position(|(name, _)| name == quoted.text);
        if let Some(idx) = found {
            // One that could not be read was reported there.
            let read = self.curves[..idx].iter().filter(|(_, curve)| curve.is_some()).count();
            return self.curves[idx].1.as_ref().map(|_| CurveId(read));
        }
        let names: Vec<String> = self.curves.iter().map(|(name, _)| name.clone()).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let message = format!(
            "{} refers to unknown curve `{}`",
            fields.owner,
            super::words::cut(quoted.text)
        );
        let location: Span = quoted.span_of(&(0..quoted.text.len()));
        self.unknown(
            codes::UNKNOWN_CURVE,
            message,
            (location, "no path has this name"),
            (quoted.text, &names),
        );
        None
    }

    /// A path that could be read.
    pub(super) fn curve(&self, id: CurveId) -> Option<&Curve> {
        self.curves.iter().filter_map(|(_, curve)| curve.as_ref()).nth(id.0)
    }

    /// The paths that could be read, in the order of their ids.
    pub(super) fn take_curves(&mut self) -> Vec<Curve> {
        std::mem::take(&mut self.curves).into_iter().filter_map(|(_, curve)| curve).collect()
    }
}
