//! `[ground]` and `[bodies.…]`: mass properties, points and outlines.

use bksim_expr::Expr;

use super::codes;
use super::gather::{coordinate_names, sub_tables};
use super::reader::{Fields, Reader};
use super::replay::Constant;
use super::tree::{Node, Table, Value};
use super::units::Quantity;
use super::value::{Scalar, Scope};
use crate::body::{Body, Inertia};
use crate::diagnostic::{Code, Diagnostic, Span};
use crate::ids::{PointId, Vector};

/// Keys of the ground.
pub(super) const GROUND_KEYS: [&str; 3] = ["points", "outline", "shapes"];
/// Keys of a body.
pub(super) const BODY_KEYS: &[&str] = &[
    "mass",
    "density",
    "thickness",
    "com",
    "inertia",
    "points",
    "outline",
    "shapes",
    "coordinates",
    "free",
    "as_stated",
    "flexible",
];

/// The facts of a body for the checks of the whole model.
#[derive(Debug, Default)]
#[expect(clippy::struct_excessive_bools, reason = "each is a fact by itself")]
pub(super) struct BodyFacts {
    /// True if the author wrote `free = true`.
    pub(super) is_free: bool,
    /// True if the author wrote `as_stated = true`: an inertia that no body has is a warning.
    pub(super) is_as_stated: bool,
    /// Mass, kg.
    pub(super) mass: Option<(f64, Span)>,
    /// True if the mass follows from a density.
    pub(super) has_density: bool,
    /// Every position of the body with a value: points, corners; m.
    pub(super) positions: Vec<Position>,
    /// True if the author says that the inertia is meant as it is, however it looks.
    pub(super) is_inertia_meant: bool,
    /// Position of the centre of mass, where one is stated.
    pub(super) com_span: Option<Span>,
    /// Values of the points, by their ids.
    pub(super) points: Vec<Option<[f64; 3]>>,
}

impl BodyFacts {
    /// A fault of an inertia that no body has: an error, or a warning where it is to be taken as stated.
    pub(super) fn weigh(&self, code: Code, message: String) -> Diagnostic {
        if self.is_as_stated {
            Diagnostic::warning(code, message)
        } else {
            Diagnostic::error(code, message)
        }
    }
}

/// A vector of the file and its value.
#[derive(Clone, Debug)]
pub(super) struct Position {
    pub(super) value: [Constant; 3],
    /// True if a component other than zero is a bare number.
    pub(super) is_bare: bool,
    pub(super) span: Span,
}

impl Position {
    /// Numbers of the position, for messages and warnings.
    pub(super) fn numbers(&self) -> [f64; 3] {
        self.value.map(Constant::look)
    }
}

/// A vector of the file.
#[derive(Clone, Debug)]
pub(super) struct VectorValue {
    pub(super) components: Vector,
    /// Value of the position when it does not change with the motion.
    pub(super) position: Option<Position>,
    pub(super) span: Span,
}

impl Reader<'_> {
    /// Reads the ground and all bodies, in the order of their ids.
    pub(super) fn read_bodies(&mut self, root: &Table) -> Vec<(Option<Body>, BodyFacts)> {
        let mut bodies = vec![self.read_ground(root)];
        for (name, span, table) in sub_tables(root, "bodies") {
            if name == "ground" {
                continue;
            }
            let Some(table) = table else {
                self.not_a_table("body", name, &span);
                bodies.push((None, BodyFacts { is_free: true, ..BodyFacts::default() }));
                continue;
            };
            let fields = Fields::open(self, table, format!("body `{name}`"), span, BODY_KEYS);
            bodies.push(self.read_body(name, &fields));
        }
        bodies
    }

    fn read_ground(&mut self, root: &Table) -> (Option<Body>, BodyFacts) {
        let mut facts = BodyFacts::default();
        let mut ground = self.plain_body("ground", 0..0);
        if let Some(entry) = root.get("ground") {
            ground.span = entry.key_span.clone();
            if let Some(table) = self.table(&entry.node, "`ground`") {
                let owner = "the ground".to_owned();
                let fields = Fields::open(self, table, owner, entry.key_span.clone(), &GROUND_KEYS);
                ground.points = self.read_points(&fields, &mut facts);
                ground.outline = self.read_outline(&fields, &mut facts).unwrap_or_default();
                ground.solids = self.read_shapes(&fields, &mut facts).unwrap_or_default();
            }
        }
        (Some(ground), facts)
    }

    pub(super) fn plain_body(&self, name: &str, span: Span) -> Body {
        let zero = [self.pool.zero(); 3];
        Body {
            name: name.to_owned(),
            mass: self.pool.zero(),
            com: zero,
            inertia: Inertia { moments: zero, products: zero, about: None },
            points: Vec::new(),
            outline: Vec::new(),
            solids: Vec::new(),
            flexible: None,
            coordinate_names: Vec::new(),
            span,
            mass_span: None,
            inertia_span: None,
        }
    }

    fn read_body(&mut self, name: &str, fields: &Fields<'_>) -> (Option<Body>, BodyFacts) {
        let before = self.faults.len();
        let mut facts = BodyFacts::default();
        let mut body = self.plain_body(name, fields.span.clone());
        facts.is_free =
            fields.get("free").and_then(|node| self.flag(node, &fields.what("free"))) == Some(true);
        facts.is_as_stated =
            fields.get("as_stated").and_then(|node| self.flag(node, &fields.what("as_stated")))
                == Some(true);
        body.points = self.read_points(fields, &mut facts);
        let outline = self.read_outline(fields, &mut facts);
        let own_mass = ["mass", "com", "inertia", "density"];
        let is_stated_twice = own_mass.iter().any(|key| fields.conflict(self, key, "flexible"));
        let is_bent = fields.has("flexible");
        if let Some(node) = fields.get("flexible")
            && !matches!(node.value, Value::Table(_))
        {
            let help = "write for example `flexible = { length = \"1 m\", section = [\"20 mm\", \"5 mm\"], material = \"steel\" }`";
            self.wrong_kind(node, &fields.what("flexible"), "a table", &node.value, help);
        }
        let excluded = ["mass", "com", "inertia"].map(|key| fields.conflict(self, key, "density"));
        if is_bent || is_stated_twice {
            // Its mass is that of its parts.
        } else if fields.has("density") && !excluded.contains(&true) {
            if fields.has("shapes") {
                self.read_density_of_shapes(fields, &mut body, &mut facts);
            } else {
                self.read_density(fields, outline.as_deref(), &mut body, &mut facts);
            }
        } else if !fields.has("density") {
            self.read_mass(fields, &mut body, &mut facts);
            let mut com = None;
            if let Some(node) = fields.get("com") {
                com = self.vector(node, Quantity::LENGTH, &fields.what("com"), Scope::Constant);
                body.com = com.as_ref().map_or(body.com, |com| com.components);
                facts.com_span = Some(node.span.clone());
                facts.positions.extend(com.as_ref().and_then(|com| com.position.clone()));
            }
            let com = match fields.get("com") {
                Some(_) => com.and_then(|com| com.position).map(|position| position.numbers()),
                None => Some([0.0; 3]),
            };
            self.read_inertia(fields, com, &mut body, &mut facts);
        }
        if !fields.has("density") {
            body.solids = self.read_shapes(fields, &mut facts).unwrap_or_default();
        }
        body.outline = outline.unwrap_or_default();
        if let Some(node) = fields.get("coordinates") {
            body.coordinate_names = self.read_coordinate_names(node, fields, &[3, 6]);
        }
        let good = self.faults[before..].iter().all(|fault| !fault.is_error());
        (good.then_some(body), facts)
    }

    /// Names of coordinates, of which there must be one of the given numbers.
    pub(super) fn read_coordinate_names(
        &mut self,
        node: &Node,
        fields: &Fields<'_>,
        counts: &[usize],
    ) -> Vec<String> {
        let names = coordinate_names(node, self.text);
        let written = if let Value::Array(values) = &node.value { values.len() } else { 1 };
        if names.len() != written || !counts.contains(&written) {
            let expected = match counts {
                [1] => "one name in quotes".to_owned(),
                [n, ..] => format!("an array of {n} names"),
                [] => "no names: the joint has no motion".to_owned(),
            };
            let what = fields.what(if fields.get("coordinates").is_some() {
                "coordinates"
            } else {
                "coordinate"
            });
            let help = "for example \"phi\", or [\"x\", \"y\", \"phi\"] for a body";
            self.wrong_kind(node, &what, &expected, &node.value, help);
            return Vec::new();
        }
        names.into_iter().map(|(name, _)| name).collect()
    }

    fn read_mass(&mut self, fields: &Fields<'_>, body: &mut Body, facts: &mut BodyFacts) {
        let help = "write for example `mass = \"1 kg\"`, or `density` with `shapes`, or with an \
                    `outline` and its `thickness`";
        let node = fields.get("mass");
        let node = if self.needs_masses { fields.require(self, "mass", help) } else { node };
        let Some(node) = node else { return };
        let what = fields.what("mass");
        let Some(mass) = self.scalar(node, Quantity::MASS, &what, Scope::Constant) else { return };
        body.mass = mass.expr;
        body.mass_span = Some(mass.span.clone());
        self.has_vanished(&what, &mass);
        if let Some(value) = mass.value {
            let is_good = self.constants.is_not_below(value, Constant::written(0.0));
            let value = value.look();
            if !is_good {
                self.report(
                    Diagnostic::error(codes::BAD_MASS, format!("{what} is {value} kg"))
                        .at(mass.span.clone(), "must be greater than 0, or 0 for a massless link")
                        .help(format!("write \"{} kg\", or 0 for a massless link", -value)),
                );
            }
            facts.mass = Some((value, mass.span));
        }
    }

    fn read_inertia(
        &mut self,
        fields: &Fields<'_>,
        com: Option<[f64; 3]>,
        body: &mut Body,
        facts: &mut BodyFacts,
    ) {
        // The value, and the point it is about.
        let Some(node) = fields.get("inertia") else { return };
        let mut value_node = node;
        let mut is_meant = false;
        if let Value::Table(table) = &node.value {
            let owner = fields.what("inertia");
            if let Some(array) = self.tensor_of_table(table) {
                let expected = "one moment, or those of the tensor in an array";
                let help = format!("write `inertia = {array}`");
                self.wrong_kind(node, &owner, expected, &node.value, &help);
                return;
            }
            let keys = ["value", "about", "as_stated"];
            let inner = Fields::open(self, table, owner, node.span.clone(), &keys);
            let help = "write for example { value = \"0.2 kg m^2\", about = \"A\" }";
            let Some(value) = inner.require(self, "value", help) else { return };
            value_node = value;
            if let Some(node) = inner.get("as_stated") {
                let what = format!("`as_stated` of {}", fields.what("inertia"));
                is_meant = self.flag(node, &what) == Some(true);
            }
            if let Some(about) = inner.get("about") {
                let Some(point) = self.own_point(about, fields, body) else { return };
                body.inertia.about = Some(point);
            }
        }
        let what = fields.what("inertia");
        // One, three or six components.
        let components: Vec<Scalar> = match &value_node.value {
            Value::Array(values) if [3, 6].contains(&values.len()) => values
                .iter()
                .filter_map(|node| self.scalar(node, Quantity::INERTIA, &what, Scope::Constant))
                .collect(),
            Value::Array(values) => {
                let help = "write one moment, [ixx, iyy, izz], or [ixx, iyy, izz, ixy, iyz, izx]";
                let message = format!("{what}: expected 1, 3 or 6 values, found {}", values.len());
                self.report(
                    Diagnostic::error(codes::WRONG_KIND, message)
                        .at(value_node.span.clone(), "")
                        .help(help),
                );
                return;
            }
            _ => self
                .scalar(value_node, Quantity::INERTIA, &what, Scope::Constant)
                .into_iter()
                .collect(),
        };
        if components.iter().any(|component| self.has_vanished(&what, component)) {
            return;
        }
        // Into the body, once they are plausible.
        body.inertia_span = Some(value_node.span.clone());
        match components.as_slice() {
            [izz] => body.inertia.moments[2] = izz.expr,
            [xx, yy, zz, rest @ ..] => {
                body.inertia.moments = [xx.expr, yy.expr, zz.expr];
                if let [xy, yz, zx] = rest {
                    body.inertia.products = [xy.expr, yz.expr, zx.expr];
                }
            }
            _ => return,
        }
        facts.is_inertia_meant = is_meant;
        self.check_inertia(fields, &components, com, body, facts);
    }

    /// The array that says what a table of a tensor's entries by their names does, such as `{ ixx = 1, iyy = 2,
    /// izz = 3 }`; `None` for other tables.
    fn tensor_of_table(&self, table: &Table) -> Option<String> {
        let written = |name: &str| {
            let other: String = name.chars().rev().collect();
            let is_named = |key: &str| {
                let key = key.to_lowercase();
                let key = key.trim_start_matches(['i', 'j']).trim_start_matches('_');
                key == name || key == other
            };
            let entry = table.entries.iter().find(|entry| is_named(&entry.key));
            entry.map(|entry| self.text[entry.node.span.clone()].to_owned())
        };
        let moments = ["xx", "yy", "zz"].map(written);
        moments.iter().any(Option::is_some).then(|| {
            let products = ["xy", "yz", "zx"].map(written);
            let n_written = if products.iter().any(Option::is_some) { 6 } else { 3 };
            let all = moments.into_iter().chain(products).take(n_written);
            let all: Vec<String> = all.map(|entry| entry.unwrap_or_else(|| "0".into())).collect();
            format!("[{}]", all.join(", "))
        })
    }

    /// The point of the body itself that a text names.
    fn own_point(&mut self, node: &Node, fields: &Fields<'_>, body: &Body) -> Option<PointId> {
        let quoted = self.text_of(node, &format!("`about` in {}", fields.owner), "A")?;
        let names: Vec<&str> = body.points.iter().map(|point| point.name.as_str()).collect();
        let own = quoted.text.strip_prefix(&format!("{}.", body.name)).unwrap_or(quoted.text);
        let found = names.iter().position(|name| *name == own).map(PointId);
        if found.is_none() {
            let location = quoted.span_of(&(0..quoted.text.len()));
            let message = format!("{} has no point `{own}`", fields.owner);
            let label = (location, "no point of the body has this name");
            self.unknown(codes::UNKNOWN_POINT, message, label, (own, &names));
        }
        found
    }

    /// A vector of two or three components.
    pub(super) fn vector(
        &mut self,
        node: &Node,
        quantity: Quantity,
        what: &str,
        scope: Scope,
    ) -> Option<VectorValue> {
        let example = example_vector(node, quantity);
        let values = self.array(node, what, "[x, y] or [x, y, z]", &example)?;
        self.check_commas_of_vector(node, values, what);
        if !(2..=3).contains(&values.len()) {
            let expected = "[x, y] or [x, y, z]";
            self.wrong_kind(node, what, expected, &node.value, &format!("for example {example}"));
            return None;
        }
        let read: Vec<Option<Scalar>> =
            values.iter().map(|node| self.scalar(node, quantity, what, scope)).collect();
        let scalars: Vec<Scalar> = read.into_iter().collect::<Option<_>>()?;
        let mut components = [self.pool.zero(); 3];
        let mut value = Some([Constant::written(0.0); 3]);
        for (idx, scalar) in scalars.iter().enumerate() {
            components[idx] = scalar.expr;
            value = value.zip(scalar.value).map(|(mut all, one)| {
                all[idx] = one;
                all
            });
        }
        if !self.pool.is_zero(components[2]) && self.spatial.is_none() {
            self.spatial = Some(scalars[2].span.clone());
        }
        let is_bare = scalars
            .iter()
            .any(|scalar| scalar.is_bare && scalar.value.is_none_or(|value| value.look() != 0.0));
        let position = value.map(|value| Position { value, is_bare, span: node.span.clone() });
        Some(VectorValue { components, position, span: node.span.clone() })
    }

    /// Sums with the pool's own folding.
    pub(super) fn total(&self, terms: &[Expr]) -> Expr {
        self.pool.sum(terms.iter().copied())
    }
}

/// A vector in place of what is none: gravity downwards, a direction along an axis.
fn example_vector(node: &Node, quantity: Quantity) -> String {
    let noun = quantity.noun;
    let axis = match &node.value {
        Value::Text(text) => ["x", "y", "z"].iter().position(|axis| text == axis),
        _ => None,
    };
    match (&node.value, axis) {
        (_, Some(0)) if noun == Quantity::NUMBER.noun => "[1, 0]".to_owned(),
        (_, Some(1)) if noun == Quantity::NUMBER.noun => "[0, 1]".to_owned(),
        (_, Some(_)) if noun == Quantity::NUMBER.noun => "[0, 0, 1]".to_owned(),
        _ if noun == Quantity::NUMBER.noun => "[1, 0]".to_owned(),
        (Value::Number { digits, .. }, _) if noun == Quantity::ACCELERATION.noun => {
            format!("[0, -{}]", digits.trim_start_matches(['-', '+']))
        }
        _ if noun == Quantity::ACCELERATION.noun => {
            format!("[0, \"-{}\"]", quantity.example)
        }
        _ => format!("[\"{0}\", \"{0}\"]", quantity.example),
    }
}
