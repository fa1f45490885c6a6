//! The C code of a [`Core`]: sizes, the struct of the state, tables, functions, and the parts that are the same for all.

use std::fmt::Write;

use bksim_expr::c_prelude;

use crate::core::Core;

/// The parts that every program has, in order.
const SHARED: [&str; 6] = [
    include_str!("../c/state.c"),
    include_str!("../c/modes.c"),
    include_str!("../c/impact.c"),
    include_str!("../c/settle.c"),
    include_str!("../c/start.c"),
    include_str!("../c/step.c"),
];

/// Events that may follow each other within one call.
const MOST_EVENTS: usize = 100_000;
/// Steps of Newton's method in an implicit step.
const NEWTON_STEPS: usize = 7;
/// Relative tolerance of steps unless another one is asked for.
pub(crate) const TOLERANCE: f64 = 1e-8;

/// A number as C writes it.
pub(crate) fn literal(value: f64) -> String {
    if value.is_finite() { format!("{value:?}") } else { "HUGE_VAL".to_owned() }
}

/// A text as C writes it.
pub(crate) fn quoted(text: &str) -> String {
    let plain = |c: char| match c {
        '"' | '\\' => format!("\\{c}"),
        '?' => "\\?".to_owned(),
        c if c.is_control() => " ".to_owned(),
        c => c.to_string(),
    };
    format!("\"{}\"", text.chars().map(plain).collect::<String>())
}

/// Text without what would end a comment.
pub(crate) fn comment(text: &str) -> String {
    let line: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    line.replace("*/", "* /").replace("/*", "/ *").replace('\\', "/")
}

impl Core {
    /// Sizes, functions and tables.
    pub(crate) fn shared_source(&self, functions: &str) -> String {
        let sizes = &self.sizes;
        let mut out = c_prelude(functions);
        out.push_str("#include <float.h>\n#include <string.h>\n\n");
        let n = sizes.nq + sizes.nc;
        let tables = &self.tables;
        let n_modes: usize =
            tables.contacts.iter().map(|(.., is_friction)| if *is_friction { 3 } else { 1 }).sum();
        let held = sizes.n_own + sizes.n_switches + n_modes;
        let longest = (self.experiment[1] - self.experiment[0]).abs() / 20.0;
        let numbers = [
            ("NQ", sizes.nq),
            ("NC", sizes.nc),
            ("N", n),
            ("NB", sizes.n_bilateral),
            ("NF", sizes.n_free),
            ("RANK", sizes.nq - sizes.n_free),
            ("NM", tables.mass.len()),
            ("NJ", tables.jacobian.len()),
            ("NK", sizes.n_switches),
            ("NT", sizes.n_contacts),
            ("NZ", sizes.n_switches + sizes.n_contacts),
            ("NH", sizes.n_held),
            ("NS", tables.held.sampled.len()),
            ("NR", tables.held.latches.len()),
            ("NCLOCKS", sizes.n_clocks),
            ("NL", sizes.n_pressing),
            ("NI", sizes.n_initial),
            ("NOWN", sizes.n_own),
            ("NP", held + sizes.n_held),
            ("HELD", held),
            ("NV", self.values.len()),
            ("NU", self.n_inputs),
            ("NY", self.outputs.len()),
            ("NCALCULATED", self.calculated.len()),
            ("ROWS", self.n_rows()),
            ("LARGEST", n.max(3 * sizes.nq)),
            ("METHOD", usize::from(self.is_stiff)),
            ("MOST_EVENTS", MOST_EVENTS),
            ("NEWTON_STEPS", NEWTON_STEPS),
        ];
        for (name, value) in numbers {
            let _ = writeln!(out, "#define BK_{name} {value}");
        }
        let reals = [
            ("ATOL", self.atol),
            ("TOLERANCE", TOLERANCE),
            ("T_START", self.experiment[0]),
            ("LONGEST_STEP", if longest > 0.0 { longest } else { 1.0 }),
        ];
        for (name, value) in reals {
            let _ = writeln!(out, "#define BK_{name} {}", literal(value));
        }
        out.push_str("#define BK_ROOM(n) ((n) > 0 ? (n) : 1)\n\n");
        out.push_str(functions);
        out.push_str(&self.c_tables());
        out
    }

    /// The parts that are the same for all mechanisms.
    pub(crate) fn shared_parts() -> String {
        SHARED.join("\n")
    }

    fn n_rows(&self) -> usize {
        self.sizes.nc.max(self.sizes.n_bilateral + self.sizes.n_initial).max(1)
    }

    fn c_tables(&self) -> String {
        let tables = &self.tables;
        let mut out = String::new();
        let mut ints = |name: &str, values: Vec<usize>| {
            let listed: Vec<String> = values.iter().map(ToString::to_string).collect();
            let listed = if listed.is_empty() { "0".to_owned() } else { listed.join(", ") };
            let n = values.len().max(1);
            let _ = writeln!(out, "static const int bk_{name}[{n}] = {{{listed}}};");
        };
        ints("mass_row", tables.mass.iter().map(|at| at[0]).collect());
        ints("mass_column", tables.mass.iter().map(|at| at[1]).collect());
        ints("jacobian_row", tables.jacobian.iter().map(|at| at[0]).collect());
        ints("jacobian_column", tables.jacobian.iter().map(|at| at[1]).collect());
        ints("pressing_row", tables.pressing_rows.clone());
        ints("initial_level", tables.levels.clone());
        if self.sizes.n_switches + self.sizes.n_contacts > 0 {
            ints("is_timed", tables.timed.iter().map(|&timed| usize::from(timed)).collect());
            ints("contact_row", tables.contacts.iter().map(|contact| contact.0).collect());
            // Compilers look at what cannot be reached too: without contacts the place is one that there is.
            let at = tables.contacts.iter().map(|contact| contact.1);
            let at: Vec<usize> =
                at.chain(tables.contacts.is_empty().then_some(self.sizes.n_own)).collect();
            ints("contact_at", at);
            let friction = tables.contacts.iter().map(|contact| usize::from(contact.2));
            ints("is_friction", friction.collect());
        }
        let held = &tables.held;
        if !held.sampled.is_empty() {
            ints("sampled_signal", held.sampled.iter().map(|at| at[0]).collect());
            ints("sampled_clock", held.sampled.iter().map(|at| at[1]).collect());
        }
        if !held.latches.is_empty() {
            ints("latch_signal", held.latches.clone());
        }
        let mut reals = |name: &str, values: &[f64]| {
            let listed: Vec<String> = values.iter().map(|&value| literal(value)).collect();
            let listed = if listed.is_empty() { "0.0".to_owned() } else { listed.join(", ") };
            let n = values.len().max(1);
            let _ = writeln!(out, "static const double bk_{name}[{n}] = {{{listed}}};");
        };
        reals("q0", &tables.q);
        reals("v0", &tables.v);
        reals("modes0", &tables.modes);
        reals("default", &self.values.iter().map(|value| value.start).collect::<Vec<_>>());
        for (name, n) in [("sample", held.sampled.len()), ("latch", held.latches.len())] {
            if n > 0 {
                let listed: Vec<String> = (0..n).map(|k| format!("bk_{name}{k}")).collect();
                let listed = listed.join(", ");
                let _ = writeln!(
                    out,
                    "static void (*const bk_{name}_values[{n}])(const double *, const double *, double *) = {{{listed}}};"
                );
            }
        }
        out.push('\n');
        out
    }

    /// The structs of a model, under names that begin with `prefix`.
    pub(crate) fn structs(&self, prefix: &str) -> String {
        let sizes = &self.sizes;
        let (nq, nc) = (sizes.nq, sizes.nc);
        let n = nq + nc;
        let n_z = sizes.n_switches + sizes.n_contacts;
        let n_modes = self.tables.modes.len();
        let mut out =
            "typedef struct {\n    double t, t_start, tick, step, tolerance, fixed, base_t;\n"
                .to_owned();
        let state = [
            ("q", nq),
            ("v", nq),
            ("a", nq),
            ("lambda", nc),
            ("p", sizes.n_own + n_modes),
            ("value", self.values.len()),
            ("target", sizes.n_initial),
            ("previous", sizes.n_held),
            ("clocks", 2 * sizes.n_clocks),
            ("raise", n_z),
            ("base_q", nq),
            ("x", 2 * sizes.n_free),
        ];
        for (name, size) in state {
            let _ = writeln!(out, "    double {name}[{}];", size.max(1));
        }
        let _ = writeln!(
            out,
            "    int method, locates, has_changed, phase, is_stale, is_at_event;\n    \
             int free[{}], follows[{}], holding[{}];\n    char active[{}];\n}} {prefix}_state;\n",
            sizes.n_free.max(1),
            (nq - sizes.n_free.min(nq)).max(1),
            self.tables.held.latches.len().max(1),
            nc.max(1)
        );
        out.push_str(
            "/* Room for computing; nothing in it outlives a call. */\ntypedef struct {\n",
        );
        let rows = self.n_rows().max(nc);
        let work = [
            ("mass", nq * nq),
            ("g", nc * nq),
            ("gap", nc),
            ("g_rate", nc),
            ("force", nq),
            ("gamma", nc),
            ("slopes", nq * sizes.n_pressing),
            ("k", n * n),
            ("zeros", n.max(nq + 1)),
            ("rows", rows * nq),
            ("indicators", sizes.n_switches + 4 * sizes.n_contacts),
            ("drift", nc),
            ("newton", 9 * nq * nq),
            ("outputs", self.outputs.len()),
        ];
        for (name, size) in work {
            let _ = writeln!(out, "    double {name}[{}];", size.max(1));
        }
        let _ = writeln!(
            out,
            "    int pivot[{}], newton_pivot[{}], has_outputs;\n    \
             {prefix}_state before, from, fallen, outputs_of;\n}} {prefix}_work;\n\n\
             typedef struct {{\n    {prefix}_state s;\n    {prefix}_work w;\n}} {prefix}_model;\n",
            n.max(1),
            3 * nq
        );
        out
    }
}
