//! `modelDescription.xml` of a unit.
//!
//! Value references and the order of variables: time; states; their rates; event indicators; what can be read,
//! outputs first; what can be set, inputs first; parameters that follow from others.

use std::collections::BTreeSet;
use std::fmt::Write;

use bksim_model::file::WrittenUnit;

use crate::core::Core;
use crate::source::TOLERANCE;
use crate::variable::Variable;

/// Version of the program that wrote the unit.
const TOOL: &str = concat!("bksim ", env!("CARGO_PKG_VERSION"));

/// Instants of the default experiment.
const STEPS: f64 = 500.0;

/// A version of the standard.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Version {
    /// FMI 2.0.
    Two,
    /// FMI 3.0.
    Three,
}

/// A row of the list of variables.
struct Row {
    variable: Variable,
    causality: &'static str,
    variability: &'static str,
    initial: Option<&'static str>,
    /// Place of the state that it is the rate of.
    derivative: Option<usize>,
}

impl Row {
    fn new(variable: &Variable, causality: &'static str, initial: Option<&'static str>) -> Self {
        let is_fixed = matches!(causality, "parameter" | "calculatedParameter");
        let variability = if is_fixed { "fixed" } else { "continuous" };
        let mut variable = variable.clone();
        if variable.unit.is_empty() {
            "1".clone_into(&mut variable.unit);
        }
        Self { variable, causality, variability, initial, derivative: None }
    }

    fn has_start(&self) -> bool {
        matches!(self.causality, "parameter" | "input")
    }
}

/// The description of a unit.
pub(crate) fn description(core: &Core, version: Version, token: &str) -> String {
    let rows = rows(core);
    match version {
        Version::Two => second(core, token, &rows),
        Version::Three => third(core, token, &rows),
    }
}

fn rows(core: &Core) -> Vec<Row> {
    let calculated = Some("calculated");
    let n_free = core.sizes.n_free;
    let mut rows = vec![Row::new(&Variable::new("time", "s", "time"), "independent", None)];
    let states = &core.states[..2 * n_free];
    rows.extend(states.iter().map(|state| Row::new(state, "local", calculated)));
    for (k, rate) in core.states[n_free..].iter().enumerate() {
        let name = format!("der({})", states[k].name);
        let rate =
            Variable { name, description: format!("rate of {}", states[k].name), ..rate.clone() };
        rows.push(Row { derivative: Some(1 + k), ..Row::new(&rate, "local", calculated) });
    }
    for k in 0..core.sizes.n_switches + core.sizes.n_contacts {
        let name = format!("event[{}]", k + 1);
        let variable = Variable::new(&name, "", "event indicator: falls to zero at an event");
        rows.push(Row::new(&variable, "local", calculated));
    }
    for (k, output) in core.outputs.iter().enumerate() {
        let causality = if k < core.n_outputs { "output" } else { "local" };
        rows.push(Row::new(output, causality, calculated));
    }
    for (k, value) in core.values.iter().enumerate() {
        let is_input = k < core.n_inputs;
        let initial = if is_input { None } else { Some("exact") };
        rows.push(Row::new(value, if is_input { "input" } else { "parameter" }, initial));
    }
    let calculated_rows = core.calculated.iter();
    rows.extend(
        calculated_rows.map(|(_, variable)| Row::new(variable, "calculatedParameter", calculated)),
    );
    rows
}

fn escaped(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// `structured` where all names are made of identifiers and dots, else `flat`.
fn convention(rows: &[Row]) -> &'static str {
    let is_word = |word: &str| {
        let word = word.split_once('[').map_or(word, |(word, _)| word);
        word.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            && word.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
    };
    let is_plain = |row: &Row| {
        let name = row.variable.name.trim_start_matches("der(").trim_end_matches(')');
        name.split('.').all(is_word)
    };
    if rows.iter().all(is_plain) { "structured" } else { "flat" }
}

/// Definitions of all units that occur.
fn units(rows: &[Row]) -> String {
    let names: BTreeSet<&str> = rows.iter().map(|row| row.variable.unit.as_str()).collect();
    let mut out = String::from("  <UnitDefinitions>\n");
    for name in names {
        let exponents = WrittenUnit::parse(name).and_then(|unit| unit.exponents());
        let [kg, m, s, a] = exponents.unwrap_or_default();
        let mut base = String::new();
        for (word, power) in [("kg", kg), ("m", m), ("s", s), ("A", a)] {
            if power != 0 {
                let _ = write!(base, " {word}=\"{power}\"");
            }
        }
        if name == "rad" {
            base.push_str(" rad=\"1\"");
        }
        let _ = writeln!(out, "    <Unit name=\"{}\"><BaseUnit{base}/></Unit>", escaped(name));
    }
    out.push_str("  </UnitDefinitions>\n");
    out
}

/// The type of variables with a unit: importers that take no units of variables take those of types.
fn type_of(unit: &str) -> String {
    escaped(&format!("quantity in {unit}"))
}

/// Definitions of the types of all variables.
fn types(rows: &[Row]) -> String {
    let names: BTreeSet<&str> = rows.iter().map(|row| row.variable.unit.as_str()).collect();
    let mut out = String::from("  <TypeDefinitions>\n");
    for name in names {
        let (of, unit) = (type_of(name), escaped(name));
        let _ = writeln!(out, "    <Float64Type name=\"{of}\" unit=\"{unit}\"/>");
    }
    out.push_str("  </TypeDefinitions>\n");
    out
}

fn experiment(core: &Core) -> String {
    let [start, stop] = core.experiment;
    let step = (stop - start) / STEPS;
    let stop = if stop > start {
        format!(" stopTime=\"{stop:?}\" tolerance=\"{TOLERANCE:?}\" stepSize=\"{step:?}\"")
    } else {
        String::new()
    };
    format!("  <DefaultExperiment startTime=\"{start:?}\"{stop}/>\n")
}

/// Places of rows by what they are: outputs, rates of states, event indicators, and what is computed at the start.
fn places(core: &Core, rows: &[Row]) -> [Vec<usize>; 4] {
    let all = || rows.iter().enumerate();
    let outputs = all().filter(|(_, row)| row.causality == "output").map(|(k, _)| k);
    let rates = all().filter(|(_, row)| row.derivative.is_some()).map(|(k, _)| k);
    let first = 1 + 4 * core.sizes.n_free;
    let events = first..first + core.sizes.n_switches + core.sizes.n_contacts;
    let is_computed = |(k, row): &(usize, &Row)| {
        matches!(row.causality, "output" | "calculatedParameter") || (1..first).contains(k)
    };
    let computed = all().filter(is_computed).map(|(k, _)| k);
    [outputs.collect(), rates.collect(), events.collect(), computed.collect()]
}

fn third(core: &Core, token: &str, rows: &[Row]) -> String {
    let (name, id) = (escaped(&core.name), &core.identifier);
    let mut out = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"3.0\" modelName=\"{name}\" \
         instantiationToken=\"{}\" generationTool=\"{TOOL}\" variableNamingConvention=\"{}\">\n  \
         <ModelExchange modelIdentifier=\"{id}\" needsCompletedIntegratorStep=\"true\" \
         canGetAndSetFMUState=\"true\" canSerializeFMUState=\"true\" providesDirectionalDerivatives=\"true\"/>\n  \
         <CoSimulation modelIdentifier=\"{id}\" canHandleVariableCommunicationStepSize=\"true\" \
         canGetAndSetFMUState=\"true\" canSerializeFMUState=\"true\" mightReturnEarlyFromDoStep=\"true\" \
         hasEventMode=\"true\"/>\n",
        escaped(token),
        convention(rows)
    );
    out.push_str(&units(rows));
    out.push_str(&types(rows));
    out.push_str("  <LogCategories><Category name=\"logStatusError\"/></LogCategories>\n");
    out.push_str(&experiment(core));
    out.push_str("  <ModelVariables>\n");
    for (k, row) in rows.iter().enumerate() {
        let _ = write!(out, "    <Float64 {}", attributes(row, k));
        let _ = write!(out, " declaredType=\"{}\"", type_of(&row.variable.unit));
        if row.has_start() {
            let _ = write!(out, " start=\"{:?}\"", row.variable.start);
        }
        if let Some(state) = row.derivative {
            let _ = write!(out, " derivative=\"{state}\"");
        }
        out.push_str("/>\n");
    }
    out.push_str("  </ModelVariables>\n  <ModelStructure>\n");
    let [outputs, rates, events, computed] = places(core, rows);
    let parts = [
        ("Output", outputs),
        ("ContinuousStateDerivative", rates),
        ("InitialUnknown", computed),
        ("EventIndicator", events),
    ];
    for (word, places) in parts {
        for place in places {
            let _ = writeln!(out, "    <{word} valueReference=\"{place}\"/>");
        }
    }
    out.push_str("  </ModelStructure>\n</fmiModelDescription>\n");
    out
}

/// Name, reference, meaning, causality, variability and initial.
fn attributes(row: &Row, place: usize) -> String {
    let Row { variable, causality, variability, initial, .. } = row;
    let initial = initial.map_or(String::new(), |initial| format!(" initial=\"{initial}\""));
    format!(
        "name=\"{}\" valueReference=\"{place}\" description=\"{}\" causality=\"{causality}\" \
         variability=\"{variability}\"{initial}",
        escaped(&variable.name),
        escaped(&variable.description)
    )
}

fn second(core: &Core, token: &str, rows: &[Row]) -> String {
    let (name, id) = (escaped(&core.name), &core.identifier);
    let sources = format!("<SourceFiles><File name=\"{id}.c\"/></SourceFiles>");
    let abilities = "canGetAndSetFMUstate=\"true\" canSerializeFMUstate=\"true\"";
    let mut out = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"2.0\" modelName=\"{name}\" \
         guid=\"{}\" generationTool=\"{TOOL}\" variableNamingConvention=\"{}\" numberOfEventIndicators=\"{}\">\n  \
         <ModelExchange modelIdentifier=\"{id}\" {abilities} providesDirectionalDerivative=\"true\">{sources}\
         </ModelExchange>\n  \
         <CoSimulation modelIdentifier=\"{id}\" canHandleVariableCommunicationStepSize=\"true\" {abilities}>{sources}\
         </CoSimulation>\n",
        escaped(token),
        convention(rows),
        core.sizes.n_switches + core.sizes.n_contacts
    );
    out.push_str(&units(rows));
    out.push_str("  <LogCategories><Category name=\"logStatusError\"/></LogCategories>\n");
    out.push_str(&experiment(core));
    out.push_str("  <ModelVariables>\n");
    for (k, row) in rows.iter().enumerate() {
        let _ = write!(out, "    <ScalarVariable {}>", attributes(row, k));
        let _ = write!(out, "<Real unit=\"{}\"", escaped(&row.variable.unit));
        if row.has_start() {
            let _ = write!(out, " start=\"{:?}\"", row.variable.start);
        }
        if let Some(state) = row.derivative {
            let _ = write!(out, " derivative=\"{}\"", state + 1);
        }
        out.push_str("/></ScalarVariable>\n");
    }
    out.push_str("  </ModelVariables>\n  <ModelStructure>\n");
    let [outputs, rates, _, computed] = places(core, rows);
    for (word, places) in
        [("Outputs", outputs), ("Derivatives", rates), ("InitialUnknowns", computed)]
    {
        if places.is_empty() {
            continue;
        }
        let _ = writeln!(out, "    <{word}>");
        for place in places {
            let _ = writeln!(out, "      <Unknown index=\"{}\"/>", place + 1);
        }
        let _ = writeln!(out, "    </{word}>");
    }
    out.push_str("  </ModelStructure>\n</fmiModelDescription>\n");
    out
}
