//! Python with NumPy: a function that broadcasts over arrays.

use super::{Dialect, Program, listed};
use crate::op::Function;
use std::fmt::Write;

struct Python;

impl Dialect for Python {
    // A NumPy scalar: plain Python floats raise where others give infinities.
    fn literal(&self, value: f64) -> String {
        if value.is_finite() {
            format!("np.float64({value:?})")
        } else if value.is_nan() {
            "np.float64(np.nan)".to_owned()
        } else {
            format!("np.float64({}np.inf)", if value < 0.0 { "-" } else { "" })
        }
    }

    fn call(&self, function: Function, [a, b, c]: [&str; 3]) -> String {
        let name = match function {
            Function::Asin => "arcsin",
            Function::Acos => "arccos",
            Function::Atan => "arctan",
            Function::Ln => "log",
            Function::Sign => {
                return format!("np.where({a} > 0, 1.0, np.where({a} < 0, -1.0, {a}))");
            }
            Function::Atan2 => return format!("np.arctan2({a}, {b})"),
            Function::Min => return format!("np.where(({a} <= {b}) | np.isnan({a}), {a}, {b})"),
            Function::Max => return format!("np.where(({a} >= {b}) | np.isnan({a}), {a}, {b})"),
            Function::Lt => return format!("np.where({a} < {b}, 1.0, 0.0)"),
            Function::Le => return format!("np.where({a} <= {b}, 1.0, 0.0)"),
            Function::Gt => return format!("np.where({a} > {b}, 1.0, 0.0)"),
            Function::Ge => return format!("np.where({a} >= {b}, 1.0, 0.0)"),
            Function::If => {
                return format!("np.where(np.isnan({a}), {a}, np.where({a} == 0, {c}, {b}))");
            }
            _ => function.name(),
        };
        format!("np.{name}({a})")
    }

    fn power(&self, base: &str, exponent: &str) -> String {
        format!("np.power({base}, {exponent})")
    }

    fn declaration(&self, name: &str, value: &str) -> String {
        format!("{name} = {value}")
    }
}

impl Program<'_> {
    /// The tape as a Python module; run as a program it tests itself.
    ///
    /// `inputs` and `parameters` are sequences of numbers or arrays, or arrays whose first axis
    /// counts the quantities; the outputs have the shape to which all of them broadcast.
    pub fn to_python(&self) -> String {
        // The legend, and the function up to its statements.
        let name = &self.names.function;
        let mut code: String = self
            .legend()
            .iter()
            .map(|line| format!("# {line}").trim_end().to_owned() + "\n")
            .collect();
        let _ = write!(
            code,
            "\nimport numpy as np\n\n\ndef {name}(inputs, parameters=()):\n    \
             \"\"\"All outputs, stacked along the first axis; arrays broadcast.\"\"\"\n    \
             inputs = [np.asarray(value, dtype=np.float64) for value in inputs]\n    \
             parameters = [np.asarray(value, dtype=np.float64) for value in parameters]\n    \
             with np.errstate(all=\"ignore\"):\n        \
             shape = np.broadcast_shapes((), *(value.shape for value in inputs + parameters))\n"
        );
        for statement in self.statements(&Python) {
            let _ = writeln!(code, "        {statement}");
        }
        // The outputs, and the points of the test; a tuple of one needs its comma.
        let mut results = self.results(&Python).join(", ");
        if self.tape.n_outputs() == 1 {
            results.push(',');
        }
        let _ = write!(
            code,
            "        results = ({results})\n    outputs = np.empty((len(results),) + shape)\n    \
             for index, result in enumerate(results):\n        outputs[index] = result\n    return outputs\n\n\n\
             if __name__ == \"__main__\":\n    points = [\n"
        );
        for point in &self.points {
            let [inputs, parameters, outputs] =
                [&point.inputs, &point.parameters, &point.outputs].map(|v| listed(&Python, v));
            let _ = writeln!(code, "        ([{inputs}], [{parameters}], [{outputs}]),");
        }
        let tolerance = self.tolerance();
        let _ = write!(
            code,
            "    ]\n    for inputs, parameters, expected in points:\n        found = {name}(inputs, parameters)\n        \
             np.testing.assert_allclose(found, expected, rtol={tolerance})\n        \
             many = {name}([np.full((2, 3), value) for value in inputs], parameters)\n        \
             assert many.shape[0] == len(expected)\n        \
             for row, value in zip(many, found):\n            \
             np.testing.assert_allclose(row, np.full(row.shape, value), rtol={tolerance})\n"
        );
        code
    }
}
