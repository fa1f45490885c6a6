//! The solver of a mechanism: a header, one C99 file, and a program that tests it.

use std::collections::BTreeSet;
use std::fmt::Write;

use crate::core::Core;
use crate::source::{comment, literal};
use crate::variable::{Variable, identifier};

/// The part of the solver that the header declares.
const CALLS: &str = include_str!("../c/solver.c");

/// Largest difference from what bksim computes that the test allows, relative to one and the value.
const ALLOWED: &str = "1e-6";

/// A solver in C.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Solver {
    /// Name of the files without their endings.
    pub name: String,
    /// Declarations, with the names of all values.
    pub header: String,
    /// The solver.
    pub source: String,
    /// A program that runs it and compares it with bksim.
    pub test: String,
}

/// The solver of `core`.
pub fn solver(core: &Core) -> Solver {
    let id = format!("{}_solver", core.identifier);
    let mut source = format!(
        "#include \"{id}.h\"\n\n#define BK(name) {id}_##name\n#define BK_API\n\
         typedef {id}_state bk_state;\ntypedef {id}_model bk_model;\n\n"
    );
    source.push_str(&core.shared_source(&core.functions));
    source.push_str(&Core::shared_parts());
    source.push('\n');
    source.push_str(CALLS);
    Solver { header: header(core, &id), source, test: test(core, &id), name: id }
}

fn header(core: &Core, id: &str) -> String {
    let upper = id.to_uppercase();
    let mut out = format!(
        "#ifndef {upper}_H\n#define {upper}_H\n\n/**\n * {}: start, steps and events, without allocation and \
         without globals.\n *\n\
         *     static {id}_model m;\n *     {id}_init(&m);              the values of the model\n\
         *     {id}_set(&m, ..., x);       others\n\
         *     if ({id}_start(&m)) ...     closes the loops; 0 where all is well\n\
         *     if ({id}_step(&m, 0.001)) ...\n *     {id}_outputs(&m, y);\n *\n\
         * All numbers are in SI units and radians. Compile with -std=c99 or -ffp-contract=off. */\n\n\
         #ifdef __cplusplus\nextern \"C\" {{\n#endif\n\n",
        comment(&core.name)
    )
    .replace("\n*", "\n *");
    enumeration(&mut out, &upper, "VALUE", ("Values that can be set", &core.values), true);
    enumeration(&mut out, &upper, "OUTPUT", ("Outputs", &core.outputs), false);
    out.push_str("/* The state: a copy of it is all that a run goes on from. */\n");
    out.push_str(&core.structs(id));
    let _ = write!(
        out,
        "\n/* Takes the values of the model. */\nvoid {id}_init({id}_model *m);\n\
         /* Sets a value by its number; loads follow at once, all else at the next start. */\n\
         void {id}_set({id}_model *m, int value, double x);\ndouble {id}_get(const {id}_model *m, int value);\n\
         /* Finds the start; not 0 where the loops cannot be closed. */\nint {id}_start({id}_model *m);\n\
         /* Moves on by one step of size h, events included; not 0 where it cannot. With m->s.locates = 0 events\n\
         \x20* are passed at the ends of steps, so that all steps cost the same. m->s.method = 1 is implicit. */\n\
         int {id}_step({id}_model *m, double h);\n\
         /* Moves to a time by steps that keep m->s.tolerance. */\nint {id}_advance({id}_model *m, double t_end);\n\
         double {id}_time(const {id}_model *m);\n\
         void {id}_outputs(const {id}_model *m, double *y);\n\n\
         #ifdef __cplusplus\n}}\n#endif\n\n#endif\n"
    );
    out
}

/// Numbers of variables by name, with their units and defaults.
fn enumeration(
    out: &mut String,
    upper: &str,
    kind: &str,
    (title, variables): (&str, &[Variable]),
    has_default: bool,
) {
    let _ = writeln!(out, "/* {title}, by number. */\nenum {{");
    let mut taken = BTreeSet::from([format!("{kind}S")]);
    for variable in variables {
        let mut name = format!("{kind}_{}", identifier(&variable.name));
        while !taken.insert(name.clone()) {
            name.push('_');
        }
        let unit = if variable.unit.is_empty() { "1" } else { &variable.unit };
        let default =
            if has_default { format!(", {}", literal(variable.start)) } else { String::new() };
        let text =
            comment(&format!("{}: {}, {unit}{default}", variable.name, variable.description));
        let _ = writeln!(out, "    {upper}_{name}, /* {text} */");
    }
    let _ = writeln!(out, "    {upper}_{kind}S = {}\n}};\n", variables.len());
}

fn test(core: &Core, id: &str) -> String {
    let nq = core.sizes.nq;
    let rows = core.expected.iter().map(|(t, q, v)| {
        let numbers: Vec<String> =
            std::iter::once(t).chain(q).chain(v).map(|&x| literal(x)).collect();
        format!("        {{{}}},\n", numbers.join(", "))
    });
    let rows: String = rows.collect();
    let n = core.expected.len();
    let rows = if n == 0 { "        {0.0},\n".to_owned() } else { rows };
    format!(
        "#include \"{id}.h\"\n\n#include <math.h>\n#include <stdio.h>\n#include <string.h>\n\n\
         static {id}_model m, again;\n\n\
         /* Time, coordinates and velocities as bksim computes them. */\n\
         int main(void) {{\n    static const double expected[{}][{}] = {{\n{rows}    }};\n    \
         int failed = 0, row, i;\n    \
         {id}_init(&m);\n    m.s.tolerance = 1e-10;\n    \
         if ({id}_start(&m)) {{\n        fprintf(stderr, \"no start\\n\");\n        return 1;\n    }}\n    \
         for (row = 0; row < {n}; row++) {{\n        \
         again = m;\n        \
         if ({id}_advance(&m, expected[row][0]) || {id}_advance(&again, expected[row][0])) {{\n            \
         fprintf(stderr, \"no motion to %g\\n\", expected[row][0]);\n            return 1;\n        }}\n        \
         for (i = 0; i < {nq}; i++) {{\n            \
         const double q = expected[row][1 + i], v = expected[row][1 + {nq} + i];\n            \
         printf(\"%.17g %.17g\\n\", m.s.q[i], m.s.v[i]);\n            \
         if (!(fabs(m.s.q[i] - q) <= {ALLOWED} * (1.0 + fabs(q))) || !(fabs(m.s.v[i] - v) <= {ALLOWED} * (1.0 + fabs(v)))) {{\n                \
         fprintf(stderr, \"coordinate %d at %g is %.17g, %.17g, not %.17g, %.17g\\n\", i, expected[row][0], m.s.q[i],\n                        \
         m.s.v[i], q, v);\n                failed = 1;\n            }}\n            \
         if (memcmp(&m.s.q[i], &again.s.q[i], sizeof(double)) != 0) {{\n                \
         fprintf(stderr, \"a copy moves otherwise\\n\");\n                failed = 1;\n            }}\n        \
         }}\n    }}\n    \
         fputs(failed ? \"FAILED\\n\" : \"all coordinates and rates as expected\\n\", stderr);\n    return failed;\n}}\n",
        n.max(1),
        1 + 2 * nq
    )
}
