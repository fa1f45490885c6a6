//! Equations to be read: in which angles, and with which parts besides those of motion.

use std::collections::HashMap;

use bksim_expr::SymbolId;
use bksim_mbs::assemble::in_absolute_angles;
use bksim_mbs::equations::page::{Page, Style, Subject};
use bksim_mbs::equations::{
    Equations, Level, Notation, Proof, ReadingForm, drive_effort, free_bodies, levels, levels_at,
    proof, steps,
};
use bksim_mbs::quantity::coordinate_quantities;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::diagnostic::Rejected;
use bksim_runlog::describe;
use bksim_sim::Mechanism;
use serde_json::Value;

/// Contents of a page of equations.
#[derive(Clone, Copy, Default, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "each is a part that is there or not")]
pub struct Contents {
    /// True if angles are those of the bodies against the ground, not those of the joints; in the plane.
    pub in_absolute_angles: bool,
    /// True if constants that take more than one operation have names of their own.
    pub has_named_constants: bool,
    /// True if the derivation is added step by step.
    pub has_steps: bool,
    /// True if the velocity and acceleration equations of the constraints are added, with the numbers of the start.
    pub has_levels: bool,
    /// True if the balances of each body that is cut free are added.
    pub has_free_bodies: bool,
    /// True if the effort of the only drive is added in explicit form.
    pub has_effort: bool,
}

/// Why equations cannot be had as they are asked for.
#[derive(thiserror::Error, Debug)]
pub enum Unreadable {
    /// The angles of bodies are no coordinates here: in space, or with bodies that bend.
    #[error("there are no equations in the angles of the bodies here")]
    NoAbsoluteAngles,
    /// The equations are found body by body, without a kinetic energy that is written out.
    #[error("this mechanism has no derivation step by step")]
    NoSteps,
    /// No single drive, or motions, stops, friction and repeated joints besides it.
    #[error("the effort of a drive has no explicit form here")]
    NoEffort,
    /// The mechanism has no start, whose numbers are asked for.
    #[error(transparent)]
    Rejected(#[from] Rejected),
}

/// The equations of a mechanism with all parts that are asked for.
#[derive(Debug)]
pub struct Reading<'m> {
    mechanism: &'m Mechanism,
    /// The equations in other angles than the mechanism's own.
    other: Option<SymbolicSystem>,
    form: ReadingForm,
    proof: Proof,
    further: Vec<Level>,
}

impl<'m> Reading<'m> {
    /// Derives all of it.
    ///
    /// # Errors
    /// [`Unreadable`] if a part does not exist for this mechanism.
    pub fn of(mechanism: &'m Mechanism, contents: Contents) -> Result<Self, Unreadable> {
        let Mechanism { model, system: own, .. } = mechanism;
        let other = if contents.in_absolute_angles {
            let found = in_absolute_angles(model, own);
            Some(found.ok_or(Unreadable::NoAbsoluteAngles)?)
        } else {
            None
        };
        let system = other.as_ref().unwrap_or(own);
        let form = if contents.has_named_constants {
            ReadingForm::grouped(model, system)
        } else {
            ReadingForm::plain(model, system)
        };
        let further = further(mechanism, system, &form, contents)?;
        let proof = proof(model, system, &form);
        Ok(Self { mechanism, other, form, proof, further })
    }

    /// The equations as an object, without further parts.
    pub fn json(&self) -> Value {
        describe::equations(self.mechanism, self.system(), &self.form, &self.proof)
    }

    /// The equations in a notation: formulas, or a whole document.
    pub fn written(&self, style: Style, is_document: bool) -> String {
        let Mechanism { model, compiled, .. } = self.mechanism;
        let system = self.system();
        let subject = Subject {
            model,
            system,
            coordinates: &coordinate_quantities(model, system),
            multipliers: &compiled.multipliers,
            form: &self.form,
            proof: &self.proof,
        };
        let page = Page::with_levels(&subject, style, &self.further);
        if is_document { page.document() } else { page.formulas() }
    }

    /// T, V, the left sides of the equations and of the constraints, without their names.
    pub fn formulas(&self, notation: Notation) -> Equations {
        self.form.write(&self.mechanism.model, notation)
    }

    fn system(&self) -> &SymbolicSystem {
        self.other.as_ref().unwrap_or(&self.mechanism.system)
    }
}

/// The parts that are asked for besides the equations of motion.
fn further(
    mechanism: &Mechanism,
    system: &SymbolicSystem,
    form: &ReadingForm,
    contents: Contents,
) -> Result<Vec<Level>, Unreadable> {
    let model = &mechanism.model;
    let some = |found: Vec<Level>, none| if found.is_empty() { Err(none) } else { Ok(found) };
    let mut all = Vec::new();
    if contents.has_steps {
        all.extend(some(steps(model, system, form), Unreadable::NoSteps)?);
    }
    if contents.has_levels {
        let values = start_values(mechanism, system)?;
        all.extend(levels(model, system));
        all.extend(levels_at(model, system, &|symbol| values.get(&symbol).copied()));
    }
    if contents.has_free_bodies {
        all.push(free_bodies(model, system));
    }
    if contents.has_effort {
        let found = drive_effort(model, system, form).into_iter().collect();
        all.extend(some(found, Unreadable::NoEffort)?);
    }
    Ok(all)
}

/// Values of all symbols at the start, those of the coordinates of `system` among them.
fn start_values(
    mechanism: &Mechanism,
    system: &SymbolicSystem,
) -> Result<HashMap<SymbolId, f64>, Rejected> {
    let Mechanism { model, parameters, .. } = mechanism;
    let start = mechanism.start()?;
    let own = model.parameters.iter().map(|parameter| parameter.symbol);
    let mut values: HashMap<SymbolId, f64> = own.zip(parameters.iter().copied()).collect();
    values.insert(model.time, model.solve.t_start);
    let own = mechanism.system.coordinates().iter();
    for ((coordinate, &q), &v) in own.zip(&start.q).zip(&start.v) {
        values.extend([(coordinate.q, q), (coordinate.v, v)]);
    }
    for (i, coordinate) in system.coordinates().iter().enumerate() {
        let Some(angle) = system.kinematics.absolute_angle(i) else { continue };
        let at_start = |e| model.pool.evaluate(e, &|symbol| values.get(&symbol).copied());
        let [q, v] = angle.by_joints.map(|e| at_start(e).unwrap_or(f64::NAN));
        values.extend([(coordinate.q, q), (coordinate.v, v)]);
    }
    Ok(values)
}
