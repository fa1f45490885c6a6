//! Reference data of the test problems, from `tests/data`.

use std::collections::HashMap;

use serde_json::Value;

/// One test problem as published: parameters, start and end values.
pub struct Reference {
    json: Value,
    /// Parsed once: residuals ask for them.
    parameters: HashMap<String, f64>,
}

fn number(value: &Value) -> f64 {
    value.as_str().and_then(|text| text.parse().ok()).expect("numbers are stored as text")
}

impl Reference {
    pub fn load(name: &str) -> Self {
        let path = format!("{}/tests/data/{name}.json", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("the data file is part of the crate");
        let json: Value = serde_json::from_str(&text).expect("the data file is JSON");
        let parameters = json["parameters"].as_object().expect("a table").iter();
        // Some are formulas for the reader.
        let parsed = |(name, value): (&String, &Value)| {
            Some((name.clone(), value.as_str()?.parse::<f64>().ok()?))
        };
        Self { parameters: parameters.filter_map(parsed).collect(), json }
    }

    pub fn t_end(&self) -> f64 {
        number(&self.json["tend"])
    }

    pub fn parameter(&self, name: &str) -> f64 {
        self.parameters[name]
    }

    /// `initial` values of `q`, `v`, `a` or `lam`.
    pub fn initial(&self, name: &str) -> Vec<f64> {
        Self::vector(&self.json["initial"][name])
    }

    /// End values of `q`, `v`, `a` or `lam`.
    pub fn end(&self, name: &str) -> Vec<f64> {
        Self::vector(&self.json["reference"][name])
    }

    fn vector(value: &Value) -> Vec<f64> {
        value.as_array().expect("a vector").iter().map(number).collect()
    }
}
