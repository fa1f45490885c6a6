//! The equations of motion as a script of another program: CasADi, JAX, SymPy, MATLAB, Modelica.
//!
//! ```text
//! q′ = v,   M(q) a + G(t, q)ᵀ λ = f(t, q, v, u, λ),   G a = −γ(t, q, v) − 2 s (G v + ∂g/∂t) − s² g
//! ```
//!
//! The last two terms draw what integration leaves of g back to zero. Source: J. Baumgarte, Stabilization of
//! constraints and integrals of motion in dynamical systems, Comput. Methods Appl. Mech. Eng. 1 (1972).

mod modelica;

use std::fmt::Write;

use bksim_analysis::{AnalysisError, Equations, equations};
use bksim_expr::{Program, Quantity, ScriptBody, ScriptLanguage};
use bksim_sim::Mechanism;

use crate::core::expected;
use crate::source::comment;
use crate::variable::identifier;

/// A program that reads scripts.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ScriptKind {
    /// CasADi in Python.
    Casadi,
    /// JAX in Python.
    Jax,
    /// SymPy in Python.
    Sympy,
    /// MATLAB and Octave.
    Matlab,
    /// Modelica.
    Modelica,
}

/// A script, and the equations in it.
#[derive(Clone, Debug)]
pub struct Script {
    /// The equations.
    pub equations: Equations,
    /// Names of files with their texts.
    pub files: Vec<(String, String)>,
}

/// Relative tolerance of the motion that scripts compare theirs with.
const TIGHT: f64 = 1e-12;

/// The equations of `mechanism` as a script; the parameters `inputs` are arguments, those of `[io]` where there are none.
///
/// # Errors
/// [`AnalysisError`] is the fault of a mechanism without a start, of an unknown input, or of equations that are more than
/// functions of the state.
///
/// # Panics
/// Where the function has other names than its tape, which is a bug.
pub fn script(
    mechanism: &Mechanism,
    inputs: &[String],
    kind: ScriptKind,
) -> Result<Script, AnalysisError> {
    let equations = equations(mechanism, inputs)?;
    // Motion with contacts is none of these equations alone.
    let motion =
        if equations.contacts.is_empty() { expected(mechanism, TIGHT) } else { Vec::new() };
    let program = equations.function.tape.program(&equations.function.signature);
    let program = program.expect("a signature is made for its tape");
    let parts = Parts { name: &mechanism.model.name, equations: &equations, program, motion };
    let id = identifier(&mechanism.model.name);
    let files = match kind {
        ScriptKind::Modelica => modelica::files(&parts, &id, mechanism.model.solve.t_end),
        ScriptKind::Matlab => vec![(format!("{id}.m"), parts.matlab(&id))],
        ScriptKind::Casadi => {
            vec![parts.python(&id, "casadi", include_str!("../scripts/casadi.py"))]
        }
        ScriptKind::Jax => vec![parts.python(&id, "jax", include_str!("../scripts/jax.py"))],
        ScriptKind::Sympy => vec![parts.python(&id, "sympy", include_str!("../scripts/sympy.py"))],
    };
    Ok(Script { equations, files })
}

/// Everything that scripts are made of.
struct Parts<'a> {
    name: &'a str,
    equations: &'a Equations,
    program: Program<'a>,
    motion: Vec<(f64, Vec<f64>, Vec<f64>)>,
}

impl Parts<'_> {
    /// Lines on what these equations are not.
    fn notes(&self) -> Vec<String> {
        let Equations { calculated, left_out, contacts, .. } = self.equations;
        let list = |names: &[String], text: &str| {
            (!names.is_empty()).then(|| comment(&format!("{text}: {}.", names.join(", "))))
        };
        let notes = [
            list(
                calculated,
                "Parameters that follow from others in the model, and are numbers here",
            ),
            list(
                left_out,
                "Multipliers left out, since their conditions follow from the others at the start",
            ),
            list(
                contacts,
                "Stops are open and friction does not stick, whatever the state; the model has",
            ),
        ];
        notes.into_iter().flatten().collect()
    }

    /// A script of Python: tables of the model, its function, then what one library makes of them.
    fn python(&self, id: &str, library: &str, template: &str) -> (String, String) {
        let equations = self.equations;
        let body = self.program.body(ScriptLanguage::Python);
        let file = format!("{id}_{library}.py");
        let mut tables = String::new();
        for (title, quantities) in [
            ("COORDINATES", &equations.coordinates),
            ("RATES", &equations.rates),
            ("MULTIPLIERS", &equations.multipliers),
        ] {
            let rows = quantities.iter().map(|q| format!("({}, {})", text(&q.name), text(&q.unit)));
            table(&mut tables, title, rows);
        }
        let values = &equations.function.parameters;
        let parameters = equations.function.signature.parameters.iter().zip(values);
        let row = |(q, value): (&Quantity, &f64)| {
            format!("({}, {}, {})", text(&q.name), text(&q.unit), python_number(*value))
        };
        table(&mut tables, "PARAMETERS", parameters.map(row));
        table(&mut tables, "INPUTS", equations.inputs.iter().map(|(q, value)| row((q, value))));
        let place = |[row, column]: &[usize; 2]| format!("({row}, {column})");
        table(&mut tables, "MASS", equations.mass.iter().map(place));
        table(&mut tables, "JACOBIAN", equations.jacobian.iter().map(place));
        let _ = writeln!(tables, "PRESSING = {:?}", equations.pressing);
        let (t, q, v) = &equations.start;
        let _ = writeln!(
            tables,
            "START = ({}, {}, {})",
            python_number(*t),
            python_list(q),
            python_list(v)
        );
        let points = self.program.test_points().iter().map(|point| {
            let [inputs, parameters, outputs] =
                [&point.inputs, &point.parameters, &point.outputs].map(|x| python_list(x));
            format!("({inputs}, {parameters}, {outputs})")
        });
        table(&mut tables, "POINTS", points);
        let motion = self.motion.iter();
        let motion = motion.map(|(t, q, v)| {
            format!("({}, {}, {})", python_number(*t), python_list(q), python_list(v))
        });
        table(&mut tables, "MOTION", motion);
        let notes = joined(self.notes().iter(), "\n", "\n");
        let filled = template
            .replace("@NAME@", &comment(self.name).replace('"', "'"))
            .replace("@FILE@", &file)
            .replace("@MODULE@", &format!("{id}_{library}"))
            .replace("@NOTES@", &notes.replace('"', "'"))
            .replace("@TABLES@", &tables)
            .replace("@BODY@", &python_body(&body));
        (file, filled)
    }

    /// A function of MATLAB that gives functions and values of the model.
    fn matlab(&self, id: &str) -> String {
        let equations = self.equations;
        let body = self.program.body(ScriptLanguage::Matlab);
        let cell = |quantities: &mut dyn Iterator<Item = &Quantity>, of: fn(&Quantity) -> &str| {
            let names: Vec<String> =
                quantities.map(|q| format!("'{}'", of(q).replace('\'', "''"))).collect();
            format!("{{{}}}", names.join(", "))
        };
        let places = |places: &[[usize; 2]]| {
            let rows: Vec<String> =
                places.iter().map(|[i, j]| format!("{} {}", i + 1, j + 1)).collect();
            format!("[{}]", rows.join("; "))
        };
        let column = |values: &mut dyn Iterator<Item = f64>| {
            let numbers: Vec<String> = values.map(matlab_number).collect();
            format!("[{}]", numbers.join("; "))
        };
        let rows = |rows: Vec<Vec<f64>>| {
            let rows: Vec<String> = rows
                .into_iter()
                .map(|row| row.into_iter().map(matlab_number).collect::<Vec<_>>().join(" "))
                .collect();
            format!("[{}]", rows.join("; ...\n    "))
        };
        let (t, q, v) = &equations.start;
        let points = self.program.test_points();
        let chosen = |of: fn(&bksim_expr::TestPoint) -> &Vec<f64>| {
            rows(points.iter().map(|point| of(point).clone()).collect())
        };
        let motion = self.motion.iter();
        let motion: Vec<Vec<f64>> =
            motion.map(|(t, q, v)| [&[*t], q.as_slice(), v].concat()).collect();
        let signature = &equations.function.signature;
        let mut statements = body.arguments.clone();
        statements.extend(body.operations.iter().map(|(_, statement)| statement.clone()));
        let statements = joined(statements.iter(), "    ", "\n");
        let notes = joined(self.notes().iter(), "%\n% ", "\n");
        let inputs = || equations.inputs.iter().map(|(q, _)| q);
        include_str!("../scripts/model.m")
            .replace("@ID@", id)
            .replace("@NAME@", &comment(self.name))
            .replace("@NOTES@", &notes)
            .replace("@COORDINATES@", &cell(&mut equations.coordinates.iter(), |q| &q.name))
            .replace("@UNITS@", &cell(&mut equations.coordinates.iter(), |q| &q.unit))
            .replace("@RATES@", &cell(&mut equations.rates.iter(), |q| &q.name))
            .replace("@MULTIPLIERS@", &cell(&mut equations.multipliers.iter(), |q| &q.name))
            .replace("@INPUTS@", &cell(&mut inputs(), |q| &q.name))
            .replace("@PARAMETERS@", &cell(&mut signature.parameters.iter(), |q| &q.name))
            .replace("@P@", &column(&mut equations.function.parameters.iter().copied()))
            .replace("@U@", &column(&mut equations.inputs.iter().map(|(_, value)| *value)))
            .replace("@T0@", &matlab_number(*t))
            .replace("@Q0@", &column(&mut q.iter().copied()))
            .replace("@V0@", &column(&mut v.iter().copied()))
            .replace("@MASS@", &places(&equations.mass))
            .replace("@JACOBIAN@", &places(&equations.jacobian))
            .replace("@PRESSING@", &column(&mut equations.pressing.iter().map(|&k| (k + 1) as f64)))
            .replace("@POINT_INPUTS@", &chosen(|point| &point.inputs))
            .replace("@POINT_PARAMETERS@", &chosen(|point| &point.parameters))
            .replace("@POINT_OUTPUTS@", &chosen(|point| &point.outputs))
            .replace("@MOTION@", &rows(motion))
            .replace("@STATEMENTS@", &statements)
            .replace("@RESULTS@", &body.results.join("; ...\n    "))
    }
}

/// Texts one after the other, each between two others.
fn joined<T: AsRef<str>>(texts: impl Iterator<Item = T>, before: &str, after: &str) -> String {
    let mut out = String::new();
    for text in texts {
        out.extend([before, text.as_ref(), after]);
    }
    out
}

/// A list of Python, an element a line.
fn table(out: &mut String, title: &str, rows: impl Iterator<Item = String>) {
    let rows = joined(rows, "    ", ",\n");
    let rows = if rows.is_empty() { rows } else { format!("\n{rows}") };
    let _ = writeln!(out, "{title} = [{rows}]");
}

/// Statements of a function, and what it gives.
fn python_body(body: &ScriptBody) -> String {
    let operations = body.operations.iter().map(|(_, statement)| statement);
    let statements = body.arguments.iter().chain(operations);
    let statements = joined(statements, "    ", "\n");
    format!("{statements}    return [{}]", body.results.join(", "))
}

fn text(text: &str) -> String {
    format!("\"{}\"", comment(text).replace('"', "'"))
}

fn python_number(value: f64) -> String {
    format!("{value:?}").replace("NaN", "nan")
}

fn python_list(values: &[f64]) -> String {
    let numbers: Vec<String> = values.iter().map(|&value| python_number(value)).collect();
    format!("[{}]", numbers.join(", "))
}

fn matlab_number(value: f64) -> String {
    format!("{value:?}").replace("inf", "Inf")
}
