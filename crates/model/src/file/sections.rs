//! The way through a file, section by section, and the keys at its top.

use super::bodies::BodyFacts;
use super::friction::Connections;
use super::misplaced::{misplaced, renamed};
use super::reader::{Fields, Reader};
use super::tree::{Entry, Table, Value};
use super::units::{self, FileUnits, find_unit};
use super::words::closest;
use super::{MAX_DIAGNOSTICS, Source, codes};
use crate::body::{Body, Space};
use crate::diagnostic::Diagnostic;
use crate::io::Io;
use crate::joint::Joint;
use crate::load::Load;
use crate::model::{CoordinatePolicy, Model};

/// Sections of a model file, in the order in which they are documented.
pub const SECTIONS: &[&str] = &[
    "name",
    "drawing",
    "use",
    "space",
    "coordinates",
    "units",
    "parameters",
    "tables",
    "curves",
    "ground",
    "bodies",
    "joints",
    "couplings",
    "conditions",
    "contacts",
    "states",
    "clocks",
    "signals",
    "outputs",
    "loads",
    "drives",
    "initial",
    "solve",
    "io",
    "ranges",
    "cases",
    "optimize",
    "fit",
    "tolerance",
];

impl Reader<'_> {
    /// The way through the file: one section per line; `promoted` are values of it that became parameters.
    pub(super) fn read_model(
        &mut self,
        root: &Table,
        promoted: &[Entry],
        source: &Source<'_>,
    ) -> Option<Model> {
        let top = Fields::open(self, root, "the model".to_owned(), 0..0, SECTIONS);
        if let Some(node) = top.get("drawing") {
            self.report(
                Diagnostic::error(codes::DRAWING_ALONE, "the drawing that this model names was not read")
                    .at(node.span.clone(), "a file, in quotes")
                    .help("give the name of a file, such as `drawing = \"press.dxf\"`, and open the model with `bksim`"),
            );
            self.topology_unknown = true;
            return None;
        }
        if let Some(node) = top.get("use") {
            self.report(
                Diagnostic::error(codes::BAD_PART, "the parts that this model uses were not read")
                    .at(node.span.clone(), "models of other files")
                    .help("open the model with `bksim`, or put it together with `bksim expand`"),
            );
            self.topology_unknown = true;
            return None;
        }
        // Units, names and parameters, on which everything depends.
        self.read_units(root);
        self.gather_names(root);
        let time = self.define_time();
        self.gather_parameters(root, promoted, source.overrides);
        self.gather_coordinates(root);
        self.gather_controllers(root);
        self.read_parameters();
        self.read_tables(root);
        self.read_curves(root);

        // The sections, in the order in which they refer to each other.
        let mut bodies = self.read_bodies(root);
        let mut joints = self.read_joints(root);
        self.build_flexible(root, &mut bodies, &mut joints);
        self.turn_slides(&mut bodies, &mut joints);
        self.joint_ends = joints
            .iter()
            .map(|joint| joint.as_ref().map(|j| [j.predecessor, j.successor]))
            .collect();
        self.joint_bodies =
            self.joint_ends.iter().map(|ends| ends.map(|ends| ends.map(|end| end.body))).collect();
        let mut controllers = self.read_controllers(root);
        let couplings = self.read_couplings(root);
        self.read_results(root, &mut controllers);
        controllers.signals.append(&mut self.belt_signals);
        controllers.signals.sort_by_key(|signal| signal.is_output);
        self.check_forces(&couplings);
        let connections = Connections { joints: &joints, couplings: &couplings };
        let mut loads = self.read_loads(root, &connections);
        // Couplings on one side come last: their rows are found from the end.
        self.rope_loads.sort_by_key(Load::is_coupling);
        loads.append(&mut self.rope_loads);
        let contacts = self.read_contacts(root, &mut bodies, &mut loads);
        let drives = self.read_drives(root);
        let (mut initial, orientations, assembly) = self.read_initial(root);
        self.start_in_play(&mut initial);
        initial.extend(controllers.initial);
        let solve = self.read_solve(root);
        let io = self.read_io(root);
        self.read_formulas();
        let ranges = self.read_ranges(root);
        let space = self.read_space(&top);
        self.check_space_of_contacts(space, &contacts);
        let coordinates = self.read_policy(&top);
        let name = self.read_name(&top).unwrap_or_else(|| source.name.to_owned());
        // Checks of the whole; a model only where there was no error.
        self.check_whole(&bodies);
        self.sort_faults();

        if self.faults.iter().any(Diagnostic::is_error) {
            return None;
        }
        self.recorded = Some(self.parameter_values());
        let (bodies, facts): (Vec<Option<Body>>, Vec<BodyFacts>) = bodies.into_iter().unzip();
        let bodies: Option<Vec<Body>> = bodies.into_iter().collect();
        let joints: Option<Vec<Joint>> = joints.into_iter().collect();
        let mut model = Model {
            name,
            time,
            parameters: self.take_parameters(),
            space,
            coordinates,
            bodies: bodies?,
            joints: joints?,
            couplings,
            curves: self.take_curves(),
            laws: std::mem::take(&mut self.laws),
            loads,
            belts: std::mem::take(&mut self.belts),
            ropes: std::mem::take(&mut self.ropes),
            contacts,
            at_start: std::mem::take(&mut self.at_start),
            drives,
            states: controllers.states,
            named_signals: controllers.signals,
            clocks: controllers.clocks,
            held: controllers.held.into_iter().chain(std::mem::take(&mut self.counts)).collect(),
            uncounted: Vec::new(),
            functions: std::mem::take(&mut self.functions),
            measured: std::mem::take(&mut self.measured),
            table_calls: std::mem::take(&mut self.table_calls),
            signals: std::mem::take(&mut self.names.signals),
            line_names: std::mem::take(&mut self.names.lines),
            force_names: std::mem::take(&mut self.names.forces).into_iter().map(|f| f.0).collect(),
            initial,
            orientations,
            assembly,
            solve,
            inputs: Vec::new(),
            io: Io::default(),
            compliances: Vec::new(),
            ranges,
            cases: std::mem::take(&mut self.cases),
            pool: std::mem::take(&mut self.pool),
        };
        model.io = self.known_io(&model, io);
        self.check_plausible(&model, &facts, top.has("space"));
        self.cases.clone_from(&model.cases);
        self.check_cases(source);
        self.sort_faults();
        (!self.faults.iter().any(Diagnostic::is_error)).then_some(model)
    }

    /// Reports misspelt sections, and reads each as the one it was meant to be; sections that hold
    /// named tables must be tables.
    pub(super) fn check_sections(&mut self, root: &mut Table) {
        Fields::open(self, root, "the model".to_owned(), 0..0, SECTIONS);
        let mut free: Vec<&str> =
            SECTIONS.iter().copied().filter(|section| root.get(section).is_none()).collect();
        let mut misspelt = Vec::new();
        for entry in &mut root.entries {
            if SECTIONS.contains(&entry.key.as_str()) {
                continue;
            }
            self.topology_unknown = true;
            if misplaced("the model", &entry.key).is_some() {
                continue;
            }
            let renamed = renamed("the model", &entry.key, &free);
            if let Some(meant) = renamed.or_else(|| closest(&entry.key, &free)) {
                free.retain(|section| *section != meant);
                meant.clone_into(&mut entry.key);
            } else if let (Some(meant), Value::Table(table)) =
                (closest(&entry.key, SECTIONS), &mut entry.node.value)
            {
                misspelt.push((meant, std::mem::take(&mut table.entries)));
            }
        }
        // What stands in a section that is there by its own name, too, is among its tables.
        for (meant, entries) in misspelt {
            let Some(Value::Table(table)) = root.get_mut(meant).map(|e| &mut e.node.value) else {
                continue;
            };
            let is_new = |entry: &Entry| table.get(&entry.key).is_none();
            let entries: Vec<Entry> = entries.into_iter().filter(is_new).collect();
            table.entries.extend(entries);
        }
        root.entries.retain(|entry| SECTIONS.contains(&entry.key.as_str()));
        let examples =
            [("bodies", "crank"), ("joints", "A"), ("loads", "gravity"), ("drives", "motor")];
        for (section, name) in examples {
            let Some(entry) = root.get(section) else { continue };
            if !matches!(entry.node.value, Value::Table(_)) {
                let help = format!("write a table for each, such as `[{section}.{name}]`");
                let what = format!("`{section}`");
                self.wrong_kind(&entry.node, &what, "a table", &entry.node.value, &help);
                self.topology_unknown = true;
            }
        }
    }

    fn read_units(&mut self, root: &Table) {
        let Some(entry) = root.get("units") else { return };
        let Some(table) = self.table(&entry.node, "`units`") else { return };
        let keys = FileUnits::KEYS.map(|(key, _)| key);
        let span = entry.key_span.clone();
        let fields = Fields::open(self, table, "`[units]`".to_owned(), span, &keys);
        for (idx, (key, quantity)) in FileUnits::KEYS.iter().enumerate() {
            let Some(node) = fields.get(key) else { continue };
            let fitting: Vec<(&str, &units::Unit)> = units::UNITS
                .iter()
                .filter(|unit| {
                    unit.dimension == quantity.dimension() && unit.is_angle == quantity.is_angle()
                })
                .map(|unit| (unit.name, unit))
                .collect();
            if let Some(unit) = self.choice(node, &fields.what(key), &fitting) {
                self.units.set(idx, unit);
            } else {
                // The author meant some unit: do not warn about bare numbers on top.
                self.units.set(idx, find_unit(fitting[0].0).unwrap_or(fitting[0].1));
            }
        }
    }

    fn read_name(&mut self, top: &Fields<'_>) -> Option<String> {
        let node = top.get("name")?;
        Some(self.text_of(node, "`name`", "slider-crank")?.text.to_owned())
    }

    fn read_space(&mut self, top: &Fields<'_>) -> Space {
        let choices = [("planar", Space::Planar), ("spatial", Space::Spatial)];
        let stated = top.get("space").and_then(|node| self.choice(node, "`space`", &choices));
        match (stated, self.spatial.clone()) {
            (Some(Space::Planar), Some(location)) => {
                self.report(
                    Diagnostic::error(
                        codes::NOT_PLANAR,
                        "a planar model has a part that leaves the plane",
                    )
                    .at(location, "not in the plane z = 0, or an axis not along z")
                    .help("remove the z part, or write `space = \"spatial\"`"),
                );
                Space::Planar
            }
            (Some(space), _) => space,
            (None, Some(_)) => Space::Spatial,
            (None, None) => Space::Planar,
        }
    }

    fn read_policy(&mut self, top: &Fields<'_>) -> CoordinatePolicy {
        let choices = [
            ("auto", CoordinatePolicy::Auto),
            ("relative", CoordinatePolicy::Relative),
            ("absolute", CoordinatePolicy::Absolute),
        ];
        top.get("coordinates")
            .and_then(|node| self.choice(node, "`coordinates`", &choices))
            .unwrap_or_default()
    }

    fn check_whole(&mut self, bodies: &[(Option<Body>, BodyFacts)]) {
        let ends: Vec<_> = self.joint_bodies.iter().copied().flatten().collect();
        self.check_topology(bodies, &ends);
        self.check_size(bodies);
    }

    /// File order, each fault once; faults of the whole model come last.
    fn sort_faults(&mut self) {
        let location =
            |fault: &Diagnostic| fault.labels.first().map_or(usize::MAX, |label| label.span.start);
        self.faults.sort_by_key(location);
        let mut kept: Vec<Diagnostic> = Vec::new();
        let mut n_hidden = 0;
        for fault in self.faults.drain(..) {
            if kept.iter().rev().take(8).any(|known| *known == fault) {
                continue;
            }
            // An error must stay visible, or the model would be missing without a reason.
            let is_needed = fault.is_error() && !kept.iter().any(Diagnostic::is_error);
            if kept.len() < MAX_DIAGNOSTICS || is_needed {
                kept.push(fault);
            } else {
                n_hidden += 1;
            }
        }
        if let (true, Some(last)) = (n_hidden > 0, kept.last_mut()) {
            last.notes.push(format!("{n_hidden} more faults follow"));
        }
        self.faults = kept;
    }
}
