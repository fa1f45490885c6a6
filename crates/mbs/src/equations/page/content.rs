//! The sections of a page, in order.

use bksim_expr::{Certificate, Expr, Operations, SymbolId};

use super::{Body, Cell, Label, Section, Style, Subject, Writer, number, unit};
use crate::coordinate::{Coordinate, CoordinateKind, Owner};
use crate::equations::{
    ContactText, Counts, FunctionText, Level, ReadingForm, RowName, contact_texts, functions,
};
use crate::system::Derivation;
use bksim_model::{BodyId, JointId, NamedSignal, Space, StateId};

/// The form as the style wants it: typeset, multipliers are λ₁, λ₂ …
pub(super) fn form_for(subject: &Subject<'_>, style: Style) -> ReadingForm {
    let is_typeset = matches!(style, Style::Latex | Style::Typst | Style::MathMl);
    let names = if is_typeset { multiplier_names(subject) } else { Vec::new() };
    subject.form.renamed(&subject.model.pool, &names)
}

/// Each multiplier with its Greek name, unless the model has taken one of those.
fn multiplier_names(subject: &Subject<'_>) -> Vec<(SymbolId, Expr)> {
    let pool = &subject.model.pool;
    let is_taken = |name: &str| {
        subject.model.parameters.iter().any(|p| p.name == name)
            || subject.system.coordinates().iter().any(|c| c.name == name)
    };
    let names: Vec<String> =
        (1..=subject.multipliers.len()).map(|k| format!("lambda{k}")).collect();
    if names.iter().any(|name| is_taken(name)) {
        return Vec::new();
    }
    let lambdas = subject.system.constraints.iter().map(|c| c.lambda);
    lambdas.zip(names.iter().map(|name| pool.symbol(name))).collect()
}

/// All sections of a page; those that would be empty are left out.
pub(super) fn sections(writer: &Writer<'_>, levels: &[Level]) -> Vec<Section> {
    // The mechanism, its constants, its equations, then their proof.
    let model = writer.subject.model;
    let mut sections = vec![
        table(
            "bodies",
            &["name", "mass, kg", "centre of mass, m", "moment of inertia, kg m²"],
            bodies(writer),
        ),
        table("joints", &["name", "kind", "between", "role"], joints(&writer.subject)),
        table("coordinates", &["symbol", "in the model", "meaning", "unit"], coordinates(writer)),
        table("parameters", &["symbol", "in the model", "value", "unit"], parameters(writer)),
        formulas("named constants", groups(writer, true)),
        formulas(named_in_motion(writer.subject.system.derivation), groups(writer, false)),
        formulas(
            "kinetic energy",
            vec![writer.formula(
                Label::Left(writer.letter("T", "total")),
                &writer.subject.form.kinetic_energy,
                String::new(),
            )],
        ),
        formulas(
            "potential energy",
            vec![writer.formula(
                Label::Left(writer.letter("V", "total")),
                &writer.subject.form.potential_energy,
                String::new(),
            )],
        ),
        formulas("equations of motion", equations(writer)),
        formulas("constraints", constraints(writer)),
        formulas("functions", function_pieces(writer)),
        formulas("outputs", outputs(writer)),
        table("contacts", &["name", "law", "of", "multiplier", "limit"], contacts(writer)),
        table("multipliers", &["symbol", "in the model", "force of", "unit"], multipliers(writer)),
        table(
            "operations",
            &["equations", "multiply", "add", "divide", "call", "written out"],
            operations(&writer.subject),
        ),
        Section { title: "certificate", body: Body::Words(certificates(&writer.subject)) },
    ];
    for (title, is_step) in [("constraints", false), ("potential energy", true)] {
        let after = sections.iter().position(|section| section.title == title);
        let at = after.map_or(sections.len(), |at| at + 1);
        let further = levels.iter().filter(|level| level.is_step == is_step);
        let further = further.map(|level| formulas(level.title, of_level(writer, level)));
        sections.splice(at..at, further);
    }
    // Sections without content.
    if model.parameters.is_empty() {
        sections.retain(|section| section.title != "parameters");
    }
    sections.retain(|section| match &section.body {
        Body::Table { rows, .. } => !rows.is_empty(),
        Body::Formulas(formulas) => !formulas.is_empty(),
        Body::Words(words) => !words.is_empty(),
    });
    sections
}

fn table(title: &'static str, header: &[&'static str], rows: Vec<Vec<Cell>>) -> Section {
    Section { title, body: Body::Table { header: header.to_vec(), rows } }
}

fn formulas(title: &'static str, formulas: Vec<super::Formula>) -> Section {
    Section { title, body: Body::Formulas(formulas) }
}

fn words(text: impl Into<String>) -> Cell {
    Cell::Words(text.into())
}

fn bodies(writer: &Writer<'_>) -> Vec<Vec<Cell>> {
    let model = writer.subject.model;
    let formula = |e: Expr| writer.printer.expr(e);
    let value = |e: Expr| match model.pool.as_number(e) {
        Some(value) => Cell::Words(number(value.to_f64())),
        None => Cell::Formula(formula(e)),
    };
    let n_axes = if model.space == Space::Planar { 2 } else { 3 };
    let row = |body: &bksim_model::Body| {
        let about = match body.inertia.about {
            Some(point) => format!(" about {}", body.points[point.0].name),
            None => String::new(),
        };
        let com: Vec<String> = body.com[..n_axes].iter().map(|&e| formula(e)).collect();
        let moments = match model.space {
            Space::Planar => vec![formula(body.inertia.moments[2])],
            Space::Spatial => body.inertia.moments.iter().map(|&e| formula(e)).collect(),
        };
        vec![
            Cell::Code(body.name.clone()),
            value(body.mass),
            Cell::Formula(com.join(writer.comma())),
            Cell::Formula(format!("{}{}", moments.join(writer.comma()), writer.words(&about))),
        ]
    };
    model.bodies.iter().skip(1).map(row).collect()
}

fn joints(subject: &Subject<'_>) -> Vec<Vec<Cell>> {
    let model = subject.model;
    let row = |(joint_idx, joint): (usize, &bksim_model::Joint)| {
        let kind = joint.kind.facts().name;
        let is_cut = subject.system.tree.cuts.contains(&JointId(joint_idx));
        let tree = &subject.system.tree;
        let is_own = |owner: Owner| match owner {
            Owner::Joint(id, _) => id == JointId(joint_idx),
            Owner::Quaternion(body, _) => tree.joint_of(body) == Some(JointId(joint_idx)),
            Owner::Body(..) | Owner::State(_) => false,
        };
        let names = subject.system.coordinates().iter().filter(|c| is_own(c.owner));
        let names: Vec<&str> = names.map(|c| c.name.as_str()).collect();
        let role = match (is_cut, names.as_slice()) {
            (true, _) => "constraint".to_owned(),
            (false, []) => "fixed".to_owned(),
            (false, names) => format!("coordinate {}", names.join(", ")),
        };
        vec![
            Cell::Code(joint.name.clone()),
            words(kind),
            Cell::Code(format!(
                "{}, {}",
                model.anchor_name(joint.predecessor),
                model.anchor_name(joint.successor)
            )),
            words(role),
        ]
    };
    model.joints.iter().enumerate().map(row).collect()
}

fn coordinates(writer: &Writer<'_>) -> Vec<Vec<Cell>> {
    let Subject { model, system, .. } = writer.subject;
    let row = |(i, quantity): (usize, &crate::quantity::Quantity)| {
        let coordinate = &system.coordinates()[i];
        let meaning = match system.kinematics.absolute_angle(i) {
            Some(angle) => {
                let [body, ground] = [angle.body.0, 0].map(|body| &model.bodies[body].name);
                format!("angle of {body} against {ground}")
            }
            None => meaning(&writer.subject, coordinate),
        };
        vec![
            Cell::Formula(writer.printer.symbol(coordinate.q)),
            Cell::Code(quantity.name.clone()),
            words(meaning),
            words(&quantity.unit),
        ]
    };
    writer.subject.coordinates.iter().enumerate().map(row).collect()
}

fn meaning(subject: &Subject<'_>, coordinate: &Coordinate) -> String {
    let model = subject.model;
    let what = match coordinate.kind {
        CoordinateKind::Angle => "angle",
        CoordinateKind::Length => "position",
        CoordinateKind::Quaternion => "part of the quaternion",
        CoordinateKind::Integral => "integral of the state",
    };
    let in_joint = |JointId(j): JointId| {
        let joint = &model.joints[j];
        let name = |id: BodyId| &model.bodies[id.0].name;
        let (from, to) = (name(joint.predecessor.body), name(joint.successor.body));
        format!("{what} of {to} against {from} in joint {}", joint.name)
    };
    let of_body = |what: &str, BodyId(b): BodyId| format!("{what} of {}", model.bodies[b].name);
    match coordinate.owner {
        Owner::Joint(joint, _) => in_joint(joint),
        Owner::Quaternion(body, _) => match subject.system.tree.joint_of(body) {
            Some(joint) => in_joint(joint),
            None => of_body(what, body),
        },
        Owner::State(StateId(state)) => format!("{what} {}", model.states[state].name),
        Owner::Body(body, motion_idx) => {
            let axis = ["x", "y", "z"].get(motion_idx).filter(|_| what == "position");
            let what = axis.map_or(what.to_owned(), |axis| format!("{axis} of the centre of mass"));
            of_body(&what, body)
        }
    }
}

fn parameters(writer: &Writer<'_>) -> Vec<Vec<Cell>> {
    let row = |p: &bksim_model::Parameter| {
        vec![
            Cell::Formula(writer.printer.symbol(p.symbol)),
            Cell::Code(p.name.clone()),
            Cell::Number(number(p.value)),
            words(unit(&p.unit)),
        ]
    };
    writer.subject.model.parameters.iter().map(row).collect()
}

/// The title of the names that change with the motion.
fn named_in_motion(derivation: Derivation) -> &'static str {
    match derivation {
        Derivation::Lagrange => "named roots",
        Derivation::Recursion => "recursion over the bodies, in their axes",
    }
}

fn groups(writer: &Writer<'_>, is_constant: bool) -> Vec<super::Formula> {
    let Subject { model, form, .. } = writer.subject;
    let value = |symbol| model.parameters.iter().find(|p| p.symbol == symbol).map(|p| p.value);
    let formula = |group: &crate::equations::Group| {
        let name = writer.printer.symbol(group.symbol);
        let found = model.pool.evaluate(group.definition(&model.pool), &value);
        let remark = match found {
            Ok(value) => format!("{} {}", number(value), unit(&group.unit)).trim_end().to_owned(),
            Err(_) => unit(&group.unit),
        };
        writer.formula(Label::Left(name), &group.terms, remark)
    };
    form.groups.iter().filter(|group| group.is_constant == is_constant).map(formula).collect()
}

fn equations(writer: &Writer<'_>) -> Vec<super::Formula> {
    let coordinates = writer.subject.system.coordinates().iter().enumerate();
    coordinates.map(|(i, c)| writer.equation(Label::Zero(writer.printer.symbol(c.q)), i)).collect()
}

fn constraints(writer: &Writer<'_>) -> Vec<super::Formula> {
    let Subject { form, .. } = writer.subject;
    let names = multiplier_symbols(writer);
    let rows = form.constraints.iter().zip(names);
    rows.map(|(terms, name)| writer.formula(Label::Zero(name), terms, String::new())).collect()
}

/// Characters by which `d/dt ∂L/∂q̇` is longer than the name of an equation.
const LONGER_NAME: usize = 8;

/// The equations of a level, multipliers by their names in the page.
fn of_level(writer: &Writer<'_>, level: &Level) -> Vec<super::Formula> {
    let Subject { model, system, form, .. } = writer.subject;
    let pool = &model.pool;
    let names = form.trailing[2 * system.coordinates().len()..].iter();
    let names = names.map(|&lambda| pool.symbol_expr(lambda));
    let names: Vec<_> = system.constraints.iter().map(|row| row.lambda).zip(names).collect();
    // The names of steps are longer.
    let n_label = writer.n_label + if level.is_step { LONGER_NAME } else { 0 };
    let writer = &Writer { n_label, ..*writer };
    let formula = |&(name, left): &(RowName, Expr)| {
        let name = match name {
            RowName::Symbol(name) => RowName::Symbol(pool.substitute(name, &names)),
            other => other,
        };
        let left = pool.substitute(left, &names);
        let name = writer.row_name(name);
        let label = if level.is_step { Label::Left(name) } else { Label::Zero(name) };
        writer.formula(label, &[left], String::new())
    };
    level.rows.iter().map(formula).collect()
}

/// Each piece of the functions by name, and where it holds.
fn function_pieces(writer: &Writer<'_>) -> Vec<super::Formula> {
    let Subject { model, form, .. } = writer.subject;
    let formula = |piece: FunctionText| {
        let call = writer.printer.expr(piece.call);
        let of = |(&argument, &[from, to]): (&Expr, &[f64; 2])| {
            let name = model.pool.to_text(argument);
            match (from.is_finite(), to.is_finite()) {
                (false, false) => None,
                (true, false) => Some(format!("{name} from {} on", number(from))),
                (false, true) => Some(format!("{name} up to {}", number(to))),
                (true, true) => Some(format!("{name} from {} to {}", number(from), number(to))),
            }
        };
        let ranges = piece.arguments.iter().zip(&piece.ranges).filter_map(of);
        let remark = ranges.collect::<Vec<_>>().join(", ");
        writer.formula(Label::Left(call), &piece.terms, remark)
    };
    functions(model, form).into_iter().map(formula).collect()
}

/// The outputs as the author wrote them, in the measures of the motion.
fn outputs(writer: &Writer<'_>) -> Vec<super::Formula> {
    let outputs = writer.subject.model.named_signals.iter().filter(|signal| signal.is_output);
    let formula = |output: &NamedSignal| {
        writer.formula(Label::Left(writer.name(&output.name)), &[output.value], output.unit.clone())
    };
    outputs.map(formula).collect()
}

/// The multipliers as they stand in the formulas.
fn multiplier_symbols(writer: &Writer<'_>) -> Vec<String> {
    let n_coordinates = writer.subject.system.coordinates().len();
    let trailing = &writer.subject.form.trailing;
    trailing[2 * n_coordinates..].iter().map(|&lambda| writer.printer.symbol(lambda)).collect()
}

fn contacts(writer: &Writer<'_>) -> Vec<Vec<Cell>> {
    let Subject { model, system, .. } = writer.subject;
    let texts = contact_texts(model, system, &writer.printer, &multiplier_symbols(writer));
    let row = |text: ContactText| {
        vec![
            Cell::Code(text.name),
            words(text.law),
            Cell::Formula(text.quantity),
            Cell::Formula(text.multiplier),
            Cell::Formula(text.limits.join(writer.comma())),
        ]
    };
    texts.into_iter().map(row).collect()
}

fn multipliers(writer: &Writer<'_>) -> Vec<Vec<Cell>> {
    let names = multiplier_symbols(writer).into_iter();
    let row = |(m, name): (&crate::quantity::Quantity, String)| {
        vec![
            Cell::Formula(name),
            Cell::Code(m.name.clone()),
            words(m.description.replace('`', "")),
            words(unit(&m.unit)),
        ]
    };
    writer.subject.multipliers.iter().zip(names).map(row).collect()
}

fn operations(subject: &Subject<'_>) -> Vec<Vec<Cell>> {
    let row = |name: &str, counts: Counts| {
        let Operations { multiplications, additions, divisions, calls } = counts.shared;
        let mut row = vec![words(name)];
        let all = [multiplications, additions, divisions, calls, counts.printed.total()];
        row.extend(all.map(|n| Cell::Number(n.to_string())));
        row
    };
    let work = subject.proof.work;
    let mut rows = vec![row("derived", work.derived), row("simplified", work.simplified)];
    if !subject.form.groups.is_empty() {
        rows.push(row("with names", work.shown));
    }
    rows
}

fn certificates(subject: &Subject<'_>) -> Vec<String> {
    let proof = subject.proof;
    let mut lines = vec![sentence(
        proof.derivation,
        "the equations derived from T and V without simplification",
    )];
    if !subject.form.groups.is_empty() {
        lines.push(sentence(proof.grouping, "the equations with all names put back"));
    }
    lines
}

fn sentence(certificate: Certificate, what: &str) -> String {
    let Certificate { n_points, worst_double, worst_extended, is_rounded } = certificate;
    // More bits then show how constants were rounded.
    let rounded = if is_rounded { " (constants have 16 digits)" } else { "" };
    if n_points == 0 {
        return format!("not compared with {what}: no point has values");
    }
    let verdict = if certificate.is_equal() { "equal to" } else { "differ from" };
    format!(
        "{verdict} {what} at {n_points} random points: \
         within {worst_double:.1e} in f64, {worst_extended:.1e} with 106 bits{rounded}"
    )
}
