//! `[tables.…]`: measured values as functions of one variable or of two.
//!
//! A table is a function with its name in the equations.

use bksim_expr::{Expr, Function, Number};

use super::codes;
use super::dimension::Dimension;
use super::grids::{MeasuredTable, TableForm};
use super::monotone::{leaves_rows, monotone};
use super::names::PREVIOUS;
use super::pieces::{Beyond, Columns, Interpolation, spline, straight};
use super::reader::{Fields, Reader};
use super::surfaces::Rows;
use super::tree::{Node, Quoted, Table, Value};
use super::value::{Kind, Lowered, Scope};
use crate::diagnostic::{Diagnostic, Span};
use crate::message::short;
use crate::table::{MeasuredCurve, TableCall};

/// Part of the range of all values by which a spline may leave those of two rows between them.
const LEAVES: f64 = 0.02;

/// Keys of a table of values.
pub(super) const TABLE_KEYS: [&str; 4] = ["points", "units", "interpolation", "extrapolate"];

impl Reader<'_> {
    /// Gathers the names of all tables, and reads those that are without fault.
    pub(super) fn read_tables(&mut self, root: &Table) {
        for (name, span, table) in self.own_tables(root, "table") {
            if !self.usable_name(name, &span, "table") || self.is_taken(name, &span) {
                continue;
            }
            let form = self.read_table(name, table, span);
            if let Some(TableForm::Columns(columns)) = &form {
                let units = [0, 1].map(|k| unit_of(columns.kinds[k], columns.are_angles[k]));
                let (name, pieces) = (name.to_owned(), columns.function_pieces());
                self.measured.push(MeasuredCurve { name, units, pieces });
            }
            self.tables.push(MeasuredTable { name: name.to_owned(), form });
        }
    }

    /// Reports a name that a function has.
    pub(super) fn is_taken(&mut self, name: &str, span: &Span) -> bool {
        let is_taken = Function::from_name(name).is_some() || name == PREVIOUS;
        if is_taken {
            self.report(
                Diagnostic::error(codes::NAME_CLASH, format!("the name `{name}` is already taken"))
                    .at(span.clone(), "this needs a name of its own")
                    .note(format!("`{name}` is a function"))
                    .help(format!("rename it, for example `{name}_1`")),
            );
        }
        is_taken
    }

    fn read_table(&mut self, name: &str, table: &Table, span: Span) -> Option<TableForm> {
        let owner = format!("table `{name}`");
        let fields = Fields::open(self, table, owner, span, &TABLE_KEYS);
        let ways = [
            ("smooth", Interpolation::Smooth),
            ("monotone", Interpolation::Monotone),
            ("linear", Interpolation::Linear),
        ];
        let way = match fields.get("interpolation") {
            Some(node) => self.choice(node, &fields.what("interpolation"), &ways)?,
            None => Interpolation::Smooth,
        };
        let ends = [
            ("refused", Beyond::Refused),
            ("constant", Beyond::Constant),
            ("linear", Beyond::Linear),
        ];
        let beyond = match fields.get("extrapolate") {
            Some(node) => self.choice(node, &fields.what("extrapolate"), &ends)?,
            None => Beyond::Refused,
        };
        let help = "write for example `points = [[0, 12], [100, 9.5], [150, 0]]`";
        let node = fields.require(self, "points", help)?;
        let rows = self.table_rows(node, &fields)?;
        if rows.kinds.len() == 3 {
            return self.read_grid(node, rows, (way, beyond), &fields).map(TableForm::Grid);
        }

        // A row that does not follow the one before is named by its number.
        let points: Vec<[f64; 2]> = rows.points.iter().map(|(row, _)| [row[0], row[1]]).collect();
        for row_idx in 1..points.len() {
            let [before, here] = [points[row_idx - 1][0], points[row_idx][0]];
            if here <= before {
                let message = format!(
                    "row {} of {} does not follow the one before: {} after {}",
                    row_idx + 1,
                    fields.owner,
                    short(here),
                    short(before)
                );
                self.report(
                    Diagnostic::error(codes::BAD_TABLE, message)
                        .at(rows.points[row_idx].1.clone(), "must have a larger argument")
                        .help("sort the rows by their arguments, each once"),
                );
                return None;
            }
        }
        if points.len() < 2 {
            let message = format!("`points` of {} has {} rows", fields.owner, points.len());
            self.report(
                Diagnostic::error(codes::BAD_TABLE, message)
                    .at(node.span.clone(), "needs two at least")
                    .help(help),
            );
            return None;
        }
        let pieces = match way {
            Interpolation::Linear => straight(&points),
            Interpolation::Monotone => monotone(&points),
            Interpolation::Smooth => spline(&points),
        };
        if way == Interpolation::Smooth
            && let Some((k, value)) = leaves_rows(&points, &pieces, LEAVES)
        {
            self.warn_of_spline(&fields.owner, (k, value), (&points, &rows));
        }
        Some(TableForm::Columns(Columns {
            kinds: [rows.kinds[0], rows.kinds[1]],
            are_angles: [rows.are_angles[0], rows.are_angles[1]],
            x: points.iter().map(|point| point[0]).collect(),
            pieces,
            beyond,
        }))
    }

    /// Warns of a spline that leaves the values of two rows between them.
    fn warn_of_spline(
        &mut self,
        owner: &str,
        (k, value): (usize, f64),
        (points, rows): (&[[f64; 2]], &Rows),
    ) {
        let unit = unit_of(rows.kinds[1], rows.are_angles[1]);
        let [from, to] = [k, k + 1].map(|row| short(points[row][1]));
        let is_low = value < points[k][1];
        let way = if is_low { "falls" } else { "rises" };
        let message = format!(
            "the spline of {owner} {way} to {} {unit} between rows {} and {}, from {from} to {to} {unit}",
            short(value),
            k + 1,
            k + 2
        );
        self.report(
            Diagnostic::warning(codes::LEAVES_ROWS, message.trim_end().to_owned())
                .at(rows.points[k].1.clone(), "from here to the next row")
                .help("write `interpolation = \"monotone\"`, or add rows where they are far apart"),
        );
    }

    /// The rows of a table in SI: of two numbers, or of three.
    fn table_rows(&mut self, node: &Node, fields: &Fields<'_>) -> Option<Rows> {
        let what = fields.what("points");
        let nodes = self.array(node, &what, "an array of rows", "[[0, 12], [100, 9.5]]")?;
        let n = match nodes.first().map(|row| &row.value) {
            Some(Value::Array(row)) if row.len() == 3 => 3,
            _ => 2,
        };
        let units = self.table_units(fields, n)?;
        let mut kinds: Vec<Option<Kind>> =
            units.iter().map(|unit| unit.as_ref().map(|unit| unit.kind)).collect();
        let is_angle = |unit: &Option<Lowered>| unit.as_ref().is_some_and(|unit| unit.is_angle);
        let mut are_angles: Vec<bool> = units.iter().map(is_angle).collect();
        let (numbers, help) = match n {
            2 => ("two numbers", "write the argument, then the value, for example [100, 9.5]"),
            _ => {
                ("three numbers", "write both arguments, then the value, for example [100, 2, 9.5]")
            }
        };
        let mut points = Vec::new();
        for (row_idx, row) in nodes.iter().enumerate() {
            let what = format!("row {} of {}", row_idx + 1, fields.owner);
            let cells = match &row.value {
                Value::Array(cells) if cells.len() == n => cells,
                other => {
                    self.wrong_kind(row, &what, numbers, other, help);
                    return None;
                }
            };
            let mut point = Vec::with_capacity(n);
            for (i, node) in cells.iter().enumerate() {
                let value = self.table_value(node, &what, units[i].as_ref())?;
                let known = *kinds[i].get_or_insert(value.kind);
                are_angles[i] |= value.is_angle;
                if known != value.kind {
                    self.report(
                        Diagnostic::error(
                            codes::BAD_TABLE,
                            format!("{what} has another dimension than the rows before"),
                        )
                        .at(node.span.clone(), "not as above")
                        .help("give all values of a column one unit, or write `units = [\"deg\", \"N\"]`"),
                    );
                    return None;
                }
                let constant = value.value?;
                point.push(self.constants.pinned(constant));
            }
            points.push((point, row.span.clone()));
        }
        let kinds = kinds.into_iter().map(|kind| kind.unwrap_or(Kind::Bare)).collect();
        Some(Rows { kinds, are_angles, points })
    }

    /// One of each unit, where the table states them.
    fn table_units(&mut self, fields: &Fields<'_>, n: usize) -> Option<Vec<Option<Lowered>>> {
        let Some(node) = fields.get("units") else { return Some(vec![None; n]) };
        let what = fields.what("units");
        let (expected, example) = match n {
            2 => ("the units of both columns", "[\"deg\", \"N\"]"),
            _ => ("the units of three columns", "[\"rpm\", \"\", \"N m\"]"),
        };
        let nodes = self.array(node, &what, expected, example)?;
        if nodes.len() != n {
            let help = format!("write for example `units = {example}`");
            self.wrong_kind(node, &what, expected, &node.value, &help);
            return None;
        }
        let mut unit = |node: &Node| {
            let quoted = self.text_of(node, &what, "deg")?;
            if quoted.text.trim().is_empty() {
                let one = Lowered::number(&self.pool, Number::from(1), node.span.clone());
                return Some(one);
            }
            let text = format!("1 {}", quoted.text);
            let quoted = Quoted { text: &text, whole: quoted.whole.clone(), start: None };
            let syntax = self.parse(&quoted, &what, "1 deg")?;
            self.lower(&syntax, &quoted, &what, Scope::Constant)
        };
        let units: Vec<Option<Lowered>> = nodes.iter().map(&mut unit).collect();
        units.iter().all(Option::is_some).then_some(units)
    }

    /// A value of a row; a bare one is in the unit of its column.
    fn table_value(&mut self, node: &Node, what: &str, unit: Option<&Lowered>) -> Option<Lowered> {
        let value = self.lowered(node, what, Scope::Constant)?;
        let (Some(unit), Kind::Bare) = (unit, value.kind) else { return Some(value) };
        let both = value.value.zip(unit.value);
        let product = both.map(|(a, b)| self.constants.multiply(a, b));
        Some(Lowered { value: product, kind: unit.kind, is_angle: unit.is_angle, ..value })
    }

    /// The table of this name, if there is one.
    pub(super) fn table_named(&self, name: &str) -> Option<usize> {
        self.tables.iter().position(|table| table.name == name)
    }

    /// The value of a table at an argument.
    pub(super) fn look_up(
        &mut self,
        table_idx: usize,
        arguments: &[Lowered],
        span: Span,
        what: &str,
    ) -> Option<Lowered> {
        let MeasuredTable { name, form } = self.tables[table_idx].clone();
        // A table that could not be read was reported there.
        let form = form?;
        let (n, example) = match form {
            TableForm::Columns(_) => (1, "x"),
            TableForm::Grid(_) => (2, "x, y"),
        };
        if arguments.len() != n {
            let plural = if n == 1 { "" } else { "s" };
            let message = format!("`{name}` takes {n} argument{plural}, found {}", arguments.len());
            self.report(
                Diagnostic::error(codes::EXPRESSION, message)
                    .at(span, "")
                    .help(format!("give it what it takes: `{name}({example})`")),
            );
            return None;
        }
        let columns = match form {
            TableForm::Columns(columns) => columns,
            TableForm::Grid(grid) => {
                let [x, y] = [0, 1].map(|i| {
                    let of = (grid.kinds[i], grid.are_angles[i]);
                    self.table_argument(&name, of, &arguments[i], what)
                });
                return Some(self.look_up_grid(&name, &grid, [&x?, &y?], span));
            }
        };
        let of = (columns.kinds[0], columns.are_angles[0]);
        let argument = self.table_argument(&name, of, &arguments[0], what)?;
        let value = argument.value.map(|value| {
            let x = self.constants.pinned(value);
            super::replay::Constant::written(columns.at(x))
        });
        if value.is_none() && columns.beyond == Beyond::Refused {
            let range = [columns.x[0], columns.x[columns.x.len() - 1]];
            self.note_call(&name, (argument.expr, range), of, &span);
        }
        let function = self.function_of_columns(&name, "x", &columns);
        let expr = self.pool.apply(function, &[argument.expr]);
        let is_angle = columns.are_angles[1];
        Some(Lowered { is_angle, ..Lowered::new(expr, columns.kinds[1], value, span) })
    }

    /// Takes note of a call whose argument must stay within a table.
    pub(super) fn note_call(
        &mut self,
        table: &str,
        (argument, range): (Expr, [f64; 2]),
        (kind, is_angle): (Kind, bool),
        span: &Span,
    ) {
        let unit = unit_of(kind, is_angle);
        let (table, span) = (table.to_owned(), span.clone());
        self.table_calls.push(TableCall { table, argument, range, unit, span });
    }

    /// An argument in the dimension of its column.
    fn table_argument(
        &mut self,
        name: &str,
        (kind, is_angle): (Kind, bool),
        argument: &Lowered,
        what: &str,
    ) -> Option<Lowered> {
        match (kind, argument.kind) {
            (Kind::Known(dimension), Kind::Bare) => Some(self.adopt(argument, dimension, is_angle)),
            (Kind::Known(own), Kind::Known(found)) if own != found => {
                let message = format!(
                    "{what}: table `{name}` takes {}, found {}",
                    super::value::describe(own, is_angle),
                    super::value::describe(found, argument.is_angle)
                );
                self.report(
                    Diagnostic::error(codes::WRONG_DIMENSION, message)
                        .at(argument.span.clone(), "")
                        .help("convert the argument, or change `units` of the table"),
                );
                None
            }
            (Kind::Bare, Kind::Known(found)) if found != Dimension::NONE => {
                let message = format!("{what}: the argument of table `{name}` has no unit");
                self.report(
                    Diagnostic::error(codes::WRONG_DIMENSION, message)
                        .at(argument.span.clone(), format!("in {found}"))
                        .help("state `units` of the table, for example `units = [\"mm\", \"N\"]`"),
                );
                None
            }
            _ => Some(argument.clone()),
        }
    }
}

/// The SI unit of a column; empty for a number without one.
fn unit_of(kind: Kind, is_angle: bool) -> String {
    match kind {
        Kind::Known(Dimension::NONE) if is_angle => "rad".to_owned(),
        Kind::Known(dimension) => dimension.to_string(),
        Kind::Bare => String::new(),
    }
}
