//! `flexible` of a body: a beam, put together from bodies, joints and springs that exist.
//!
//! The body itself has no mass and carries the frame. Each shape is a body without mass on a joint whose spring has the
//! stiffness of the shape, and the mass is at the places of Gauss's quadrature, where all products of shapes have their
//! exact integrals. All of them have names, so that results, starts and loads name them as any others.

use bksim_expr::Expr;

use super::beam_parts::Parts;
use super::bodies::BodyFacts;
use super::codes;
use super::gather::sub_tables;
use super::names::{BodyName, JointName};
use super::reader::{Fields, Reader};
use super::replay::Constant;
use super::tree::{Node, Table, Value};
use super::units::Quantity;
use super::value::Scope;
use crate::body::{Anchor, Body, Point};
use crate::diagnostic::{Diagnostic, Span};
use crate::flexible::{Flexible, gauss, short_fraction};
use crate::ids::{BodyId, JointId, PointId};
use crate::joint::{Joint, JointKind, JointType};
use crate::load::{Load, LoadKind};

/// Keys of a flexible body.
const FLEXIBLE_KEYS: [&str; 19] = [
    "length",
    "section",
    "A",
    "I",
    "I_across",
    "edge",
    "edge_across",
    "material",
    "E",
    "density",
    "EI",
    "EI_across",
    "EA",
    "rho",
    "modes",
    "across",
    "axial",
    "damping",
    "stiffening",
];

/// Shapes where the author states no number of them.
const DEFAULT_MODES: usize = 7;
/// Most shapes of a kind: beyond, they hardly differ in what numbers can hold.
const MAX_MODES: usize = 12;

/// Materials with modulus, Pa, and density, kg/m³: common values of handbooks.
const MATERIALS: [(&str, [f64; 2]); 5] = [
    ("steel", [2.1e11, 7850.0]),
    ("aluminium", [7.0e10, 2700.0]),
    ("titanium", [1.1e11, 4430.0]),
    ("brass", [1.05e11, 8500.0]),
    ("copper", [1.2e11, 8960.0]),
];

/// Kinds of shapes, with the letter of their names.
const KINDS: [(&str, &str, usize); 3] =
    [("modes", "q", DEFAULT_MODES), ("across", "r", 0), ("axial", "u", 0)];

/// Stiffnesses, mass and section of a beam.
pub(super) struct Section {
    pub(super) length: Expr,
    /// Second moments in both planes and the area, as far as they are known.
    pub(super) moduli: [Option<Expr>; 3],
    /// Distances of the outermost fibres in both planes.
    pub(super) edges: [Option<Expr>; 2],
    length_value: Option<f64>,
    /// EI in both planes and EA.
    pub(super) stiffness: [Option<Expr>; 3],
    /// Mass per length, kg/m.
    line_mass: Expr,
    /// Moment of inertia about the axis per length, kg m.
    polar: Option<Expr>,
}

impl Reader<'_> {
    /// Gathers the names of the parts of flexible bodies, after those of all others.
    pub(super) fn gather_flexible(&mut self, root: &Table) {
        for (name, span, table) in sub_tables(root, "bodies") {
            let Some(Value::Table(table)) =
                table.and_then(|table| table.get("flexible")).map(|entry| &entry.node.value)
            else {
                continue;
            };
            let Some(body) = self.names.body(name) else { continue };
            let counts = KINDS.map(|(key, _, default)| count(table, key).unwrap_or(default));
            let mut shapes = [Vec::new(), Vec::new(), Vec::new()];
            for (kind, (_, letter, _)) in KINDS.iter().enumerate() {
                let word = if kind == 2 { "prismatic" } else { "revolute" };
                for k in 1..=counts[kind] {
                    let names =
                        [format!("{name}_{letter}{k}"), format!("{name}_shape_{letter}{k}")];
                    shapes[kind].push(self.add_part(names, word, &span));
                }
            }
            let n_masses = counts.into_iter().max().unwrap_or(0) + 2;
            let mut masses = Vec::new();
            for k in 1..=n_masses {
                let names = [format!("{name}_hold{k}"), format!("{name}_mass{k}")];
                masses.push(self.add_part(names, "weld", &span));
            }
            let names = [format!("{name}_hold_end"), format!("{name}_end")];
            let end = self.add_part(names, "weld", &span);
            let points = self.names.bodies[body.0].points.clone();
            let section = |point: String| {
                self.add_part(
                    [format!("{name}_hold_{point}"), format!("{name}_at_{point}")],
                    "weld",
                    &span,
                )
            };
            let sections = points.into_iter().map(section).collect();
            self.flexible.push(Parts { body, shapes, masses, end, sections });
        }
    }

    fn add_part(
        &mut self,
        [joint, body]: [String; 2],
        word: &str,
        span: &Span,
    ) -> (JointId, BodyId) {
        if self.names.body(&body).is_some() || self.names.joint(&joint).is_some() {
            let message = format!("`{joint}` or `{body}` is a part of a flexible body");
            self.report(
                Diagnostic::error(codes::DUPLICATE, message)
                    .at(span.clone(), "this body has parts of these names")
                    .help(format!("rename what you called `{joint}` or `{body}`")),
            );
        }
        let known = JointType::of_word(word);
        let (kind, freedoms) = known.map(|of| (of.word, of.motions)).unzip();
        let ids = (JointId(self.names.joints.len()), BodyId(self.names.bodies.len()));
        self.names.add_body(BodyName { name: body, points: Vec::new(), span: span.clone() });
        self.names.add_joint(JointName { name: joint, kind, freedoms, has_radius: false });
        ids
    }

    /// The parts of all flexible bodies, with the springs of their shapes.
    pub(super) fn build_flexible(
        &mut self,
        root: &Table,
        bodies: &mut Vec<(Option<Body>, BodyFacts)>,
        joints: &mut Vec<Option<Joint>>,
    ) {
        for parts in std::mem::take(&mut self.flexible) {
            let n_parts = parts.shapes.iter().map(Vec::len).sum::<usize>()
                + parts.masses.len()
                + parts.sections.len()
                + 1;
            let good = self.build(root, &parts, bodies, joints);
            // Faults are reported; what follows counts on the parts.
            if good.is_none() {
                bodies.extend(
                    (0..n_parts)
                        .map(|_| (None, BodyFacts { is_free: true, ..BodyFacts::default() })),
                );
                joints.extend((0..n_parts).map(|_| None));
                self.topology_unknown = true;
            }
        }
    }

    fn build(
        &mut self,
        root: &Table,
        parts: &Parts,
        bodies: &mut Vec<(Option<Body>, BodyFacts)>,
        joints: &mut Vec<Option<Joint>>,
    ) -> Option<()> {
        let of = self.names.bodies[parts.body.0].name.clone();
        let (_, span, table) =
            sub_tables(root, "bodies").into_iter().find(|(name, ..)| *name == of)?;
        let node = &table?.get("flexible")?.node;
        let Value::Table(table) = &node.value else { return None };
        let owner = format!("`flexible` of body `{of}`");
        let fields = Fields::open(self, table, owner, node.span.clone(), &FLEXIBLE_KEYS);
        for (key, ..) in KINDS {
            self.check_count(&fields, key)?;
        }
        let section = self.section(&fields, parts)?;
        let damping = match fields.get("damping") {
            Some(node) => {
                let what = fields.what("damping");
                let time = self.scalar(node, Quantity::TIME, &what, Scope::Constant)?;
                self.check_positive(&what, &time, Quantity::TIME).then_some(time.expr)?
            }
            None => self.pool.zero(),
        };
        let is_stiffened = match fields.get("stiffening") {
            Some(node) => self.flag(node, &fields.what("stiffening"))?,
            None => true,
        };
        if !parts.shapes[1].is_empty() && self.spatial.is_none() {
            self.spatial = fields.get("across").map(|node| node.span.clone());
        }
        let (body, facts) = bodies.get(parts.body.0)?;
        let mut xis = self.places(&of, (body.as_ref()?, facts), &section)?;

        // Shapes: a body without mass on a joint with a spring.
        let pool = &self.pool;
        let (zero, one) = (pool.zero(), pool.one());
        let [x, y, z] = [[one, zero, zero], [zero, pool.neg(one), zero], [zero, zero, one]];
        let root_anchor = Anchor { body: parts.body, point: None };
        let joint = |name: &str, kind, predecessor, body, axis| Joint {
            name: name.to_owned(),
            kind,
            predecessor,
            successor: Anchor { body, point: None },
            axis,
            alignment: Vec::new(),
            armature: zero,
            cut: Some(false),
            coordinate_names: Vec::new(),
            span: span.clone(),
        };
        let mut made = Vec::new();
        let mut springs = Vec::new();
        for (kind, shapes) in parts.shapes.iter().enumerate() {
            let Some(modulus) = section.stiffness[kind] else { continue };
            for (k, &(id, body)) in (0_i64..).zip(shapes) {
                let name = &self.names.joints[id.0].name;
                let divisor = pool.mul(section.length, pool.int(2 * k + 1));
                let stiffness = pool.div(modulus, divisor);
                let (kind, axis) = match kind {
                    0 => (JointKind::Revolute, z),
                    1 => (JointKind::Revolute, y),
                    _ => (JointKind::Prismatic { angle: zero }, x),
                };
                springs.push(Load {
                    name: name.clone(),
                    kind: LoadKind::JointSpring {
                        joint: id,
                        motion_idx: 0,
                        stiffness,
                        unloaded: zero,
                        damping: pool.mul(damping, stiffness),
                    },
                    span: span.clone(),
                });
                made.push((joint(name, kind, root_anchor, body, axis), body, zero, zero));
            }
        }
        let own = bodies[parts.body.0].0.as_ref()?;
        let names: Vec<String> = own.points.iter().map(|point| point.name.clone()).collect();
        self.log_sections(&of, parts, &section, (&names, &xis), &span);

        // Places of the mass.
        let pool = &self.pool;
        let mut places = Vec::new();
        let n_points = bodies[parts.body.0].0.as_ref()?.points.len();
        let mut hold = |id: JointId, body: BodyId, x: Expr| {
            let name = &self.names.joints[id.0].name;
            let point = Some(PointId(n_points + places.len()));
            places.push(Point {
                name: name.clone(),
                position: [x, zero, zero],
                orientation: Vec::new(),
            });
            let anchor = Anchor { body: parts.body, point };
            joint(name, JointKind::Weld { angle: zero }, anchor, body, z)
        };
        let mut held = Vec::new();
        for ((xi, weight), &(id, body)) in gauss(parts.masses.len()).into_iter().zip(&parts.masses)
        {
            let share = pool.mul(pool.float(weight), section.length);
            let weld = hold(id, body, pool.mul(pool.float(xi), section.length));
            let polar = section.polar.map_or(zero, |polar| pool.mul(polar, share));
            held.push((weld, body, pool.mul(section.line_mass, share), polar));
            xis.push(xi);
        }
        let (id, body) = parts.end;
        held.push((hold(id, body, section.length), body, zero, zero));
        xis.push(1.0);
        for (k, &(id, body)) in parts.sections.iter().enumerate() {
            let anchor = Anchor { body: parts.body, point: Some(PointId(k)) };
            let name = &self.names.joints[id.0].name;
            let weld = joint(name, JointKind::Weld { angle: zero }, anchor, body, z);
            held.push((weld, body, zero, zero));
        }
        made.extend(held);
        let bent = Flexible {
            length: section.length,
            bending: parts.shapes[0].iter().map(|(id, _)| *id).collect(),
            across: parts.shapes[1].iter().map(|(id, _)| *id).collect(),
            axial: parts.shapes[2].iter().map(|(id, _)| *id).collect(),
            is_stiffened,
            n_points,
            places: xis,
            masses: parts.masses.iter().map(|(_, id)| *id).collect(),
            end: parts.end.1,
            sections: parts.sections.iter().map(|(_, id)| *id).collect(),
        };
        for (joint, body, mass, polar) in made {
            let mut own = self.plain_body(&self.names.bodies[body.0].name, span.clone());
            own.mass = mass;
            own.inertia.moments[0] = polar;
            bodies.push((Some(own), BodyFacts::default()));
            joints.push(Some(joint));
        }
        let carrier = bodies[parts.body.0].0.as_mut()?;
        carrier.points.extend(places);
        carrier.flexible = Some(bent);
        self.rope_loads.extend(springs);
        Some(())
    }

    /// Places of the author's points along a beam, from 0 to 1; reports those that are not on it, or at places that
    /// change with parameters.
    fn places(
        &mut self,
        name: &str,
        (body, facts): (&Body, &BodyFacts),
        section: &Section,
    ) -> Option<Vec<f64>> {
        let mut places = Vec::new();
        for (point, value) in body.points.iter().zip(&facts.points) {
            let pool = &self.pool;
            let x = point.position[0];
            let xi = (*value)?[0] / section.length_value?;
            let part = match short_fraction(xi) {
                Some((numerator, denominator)) => pool.rational(numerator, denominator),
                None => pool.float(xi),
            };
            let is_number = [x, section.length].iter().all(|&e| pool.as_number(e).is_some());
            let rest = pool.simplify(pool.sub(x, pool.mul(part, section.length)));
            if (-1e-12..=1.0 + 1e-12).contains(&xi) && (is_number || pool.is_zero(rest)) {
                places.push(xi);
                continue;
            }
            let message = format!("point `{}` is at no fixed part of `{name}`", point.name);
            self.report(
                Diagnostic::error(codes::NOT_ON_BEAM, message)
                    .at(body.span.clone(), "this body bends")
                    .help("write its x as a part of the `length`, such as `\"L/2\"` where `length = \"L\"`, from 0 to the whole"),
            );
        }
        (places.len() == body.points.len()).then_some(places)
    }

    /// Reports a number of shapes that is none.
    fn check_count(&mut self, fields: &Fields<'_>, key: &str) -> Option<()> {
        let Some(node) = fields.get(key) else { return Some(()) };
        if number(node).is_some_and(|n| n <= MAX_MODES && (n > 0 || key != "modes")) {
            return Some(());
        }
        let message = format!("{} is no number of shapes", fields.what(key));
        self.report(
            Diagnostic::error(codes::BAD_FLEXIBLE, message)
                .at(node.span.clone(), format!("must be a whole number up to {MAX_MODES}"))
                .help(format!("write for example `{key} = 4`")),
        );
        None
    }

    /// Stiffnesses and mass from the section and the material, or as stated.
    fn section(&mut self, fields: &Fields<'_>, parts: &Parts) -> Option<Section> {
        const AREA: Quantity = Quantity::AREA;
        let conflicts = [
            ("section", "A"),
            ("section", "I"),
            ("section", "I_across"),
            ("section", "edge"),
            ("section", "edge_across"),
            ("material", "E"),
            ("material", "density"),
            ("EI", "I"),
            ("EI_across", "I_across"),
            ("rho", "density"),
        ];
        if conflicts.iter().any(|(one, other)| fields.conflict(self, one, other)) {
            return None;
        }
        let size = |reader: &mut Self, key: &str, quantity: Quantity| match fields.get(key) {
            Some(node) => {
                let what = fields.what(key);
                let scalar = reader.scalar(node, quantity, &what, Scope::Constant)?;
                reader.check_positive(&what, &scalar, quantity).then_some(Some(scalar.expr))
            }
            None => Some(None),
        };
        fields.require(
            self,
            "length",
            "write for example `length = \"1 m\"`, along x from the root",
        )?;
        let what = fields.what("length");
        let length =
            self.scalar(fields.get("length")?, Quantity::LENGTH, &what, Scope::Constant)?;
        self.check_positive(&what, &length, Quantity::LENGTH).then_some(())?;
        let stated = [
            size(self, "EI", Quantity::BENDING)?,
            size(self, "EI_across", Quantity::BENDING)?,
            size(self, "EA", Quantity::FORCE)?,
        ];
        let mut moduli = [
            size(self, "I", Quantity::AREA_MOMENT)?,
            size(self, "I_across", Quantity::AREA_MOMENT)?,
            size(self, "A", AREA)?,
        ];
        let mut edges =
            [size(self, "edge", Quantity::LENGTH)?, size(self, "edge_across", Quantity::LENGTH)?];
        if let Some(node) = fields.get("section") {
            let what = fields.what("section");
            let nodes = self.array(node, &what, "width and thickness", "[\"20 mm\", \"5 mm\"]")?;
            let [width, thickness] = nodes else {
                let help = "write the width along z, then the thickness along y";
                self.wrong_kind(node, &what, "width and thickness", &node.value, help);
                return None;
            };
            let mut side = |node: &Node| {
                let side = self.scalar(node, Quantity::LENGTH, &what, Scope::Constant)?;
                self.check_positive(&what, &side, Quantity::LENGTH).then_some(side.expr)
            };
            let [width, thickness] = [side(width)?, side(thickness)?];
            let pool = &self.pool;
            let twelfth = pool.rational(1, 12);
            let second = |a: Expr, b: Expr| pool.product([twelfth, a, pool.powi(b, 3)]);
            let half = pool.rational(1, 2);
            edges = [Some(pool.mul(half, thickness)), Some(pool.mul(half, width))];
            moduli = [
                Some(second(width, thickness)),
                Some(second(thickness, width)),
                Some(pool.mul(width, thickness)),
            ];
        }
        let [mut modulus, mut density] =
            [size(self, "E", Quantity::MODULUS)?, size(self, "density", Quantity::DENSITY)?];
        if let Some(node) = fields.get("material") {
            let [e, rho] = self.choice(node, &fields.what("material"), &MATERIALS)?;
            (modulus, density) = (Some(self.pool.float(e)), Some(self.pool.float(rho)));
        }
        let line_mass = size(self, "rho", Quantity::LINE_MASS)?;
        let pool = &self.pool;
        let both = |a: Option<Expr>, b: Option<Expr>| Some(pool.mul(a?, b?));
        let stiffness: [Option<Expr>; 3] =
            std::array::from_fn(|k| stated[k].or_else(|| both(modulus, moduli[k])));
        let polar = match moduli {
            [Some(i), Some(across), _] if !parts.shapes[1].is_empty() => {
                density.map(|density| pool.mul(density, pool.add(i, across)))
            }
            _ => None,
        };
        let line_mass = line_mass.or_else(|| both(density, moduli[2]));
        let missing = ["EI", "EI_across", "EA"]
            .into_iter()
            .enumerate()
            .find(|&(k, _)| !parts.shapes[k].is_empty() && stiffness[k].is_none());
        let missing = missing.map(|(_, key)| key).or(line_mass.is_none().then_some("rho"));
        if let Some(key) = missing {
            let (what, help) = match key {
                "rho" => ("mass", "`rho`, the mass per length, or `density` with `A` or `section`"),
                "EA" => ("stiffness along itself", "`EA`, or `E` with `A` or `section`"),
                "EI" => ("stiffness of bending", "`EI`, or `E` with `I` or `section`"),
                _ => ("stiffness across", "`EI_across`, or `E` with `I_across` or `section`"),
            };
            let message = format!("{} has no {what}", fields.owner);
            self.report(
                Diagnostic::error(codes::BAD_FLEXIBLE, message)
                    .at(fields.span.clone(), format!("`{key}` is not known"))
                    .help(format!("write {help}")),
            );
            return None;
        }
        let length_value = length.value.map(Constant::look);
        let length = length.expr;
        Some(Section {
            length,
            length_value,
            moduli,
            edges,
            stiffness,
            line_mass: line_mass?,
            polar,
        })
    }
}

/// A number of shapes as written.
fn count(table: &Table, key: &str) -> Option<usize> {
    let n = number(&table.get(key)?.node)?;
    (n <= MAX_MODES).then_some(n)
}

fn number(node: &Node) -> Option<usize> {
    let Value::Number { value, digits } = &node.value else { return None };
    if *value < 0.0 { None } else { digits.parse().ok() }
}
