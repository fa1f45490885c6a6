//! [`Model`]: what the author wrote, as plain data; no state, no equations.
//!
//! Every number is an [`Expr`] of the model's [`Pool`] over the parameter symbols, in SI units and
//! radians, so that the equations keep the author's names. Loads and drives may also use *signals*:
//! symbols that stand for a [`Measure`] of the motion and are replaced when the equations are made.
//!
//! Geometry is three-dimensional throughout; a planar model has z = 0 and all axes along ±z.

use bksim_expr::{Expr, Pool, PoolSnapshot, SymbolId};

use crate::assembly::ChosenAssembly;
use crate::belt::Belt;
use crate::body::{Anchor, Body, Space};
use crate::compliance::Compliance;
use crate::contact::ContactPair;
use crate::coupling::Coupling;
use crate::curve::{CamLaw, Curve};
use crate::diagnostic::Span;
use crate::drive::Drive;
use crate::ids::ParameterId;
use crate::io::Io;
use crate::joint::Joint;
use crate::load::Load;
use crate::load_case::LoadCase;
use crate::measure::{Initial, Orientation, Signal};
use crate::range::StatedRange;
use crate::rope::Rope;
use crate::solve::SolveOptions;
use crate::state::{Clock, HeldChange, HeldSignal, NamedSignal, State};
use crate::table::{MeasuredCurve, NamedFunction, TableCall};

/// A whole mechanism as its author stated it; `Model<PoolSnapshot>` is the same for all threads at once.
#[derive(Debug)]
pub struct Model<P = Pool> {
    /// Name of the mechanism; the file name without extension unless stated.
    pub name: String,
    /// Owns every expression of the model.
    pub pool: P,
    /// The time symbol `t`.
    pub time: SymbolId,
    /// In file order, except that each comes after those its definition uses.
    pub parameters: Vec<Parameter>,
    /// Planar or spatial.
    pub space: Space,
    /// Which joints are cut unless a joint says otherwise.
    pub coordinates: CoordinatePolicy,
    /// The ground first, then in file order.
    pub bodies: Vec<Body>,
    /// In file order.
    pub joints: Vec<Joint>,
    /// In file order.
    pub loads: Vec<Load>,
    /// In file order.
    pub couplings: Vec<Coupling>,
    /// The curves that points follow.
    pub curves: Vec<Curve>,
    /// The laws of motion of cams.
    pub laws: Vec<CamLaw>,
    /// Belts around any number of wheels, in file order.
    pub belts: Vec<Belt>,
    /// Ropes over pulleys, in file order.
    pub ropes: Vec<Rope>,
    /// Outlines that may touch, in file order.
    pub contacts: Vec<ContactPair>,
    /// Symbols that stand for what positions are where the start puts them: stated or guessed, else zero.
    pub at_start: Vec<Signal>,
    /// In file order.
    pub drives: Vec<Drive>,
    /// Quantities that are integrated with the motion, in file order.
    pub states: Vec<State>,
    /// Named expressions: signals, each after those it uses, then outputs, each after those it uses.
    pub named_signals: Vec<NamedSignal>,
    /// Clocks, in file order.
    pub clocks: Vec<Clock>,
    /// Signals that are held: those computed at ticks, each after those it uses, then those latched by events.
    pub held: Vec<HeldSignal>,
    /// Symbols of counts of half turns that are zero, as in questions about single poses: each direction is within half
    /// a turn of that of the start.
    pub uncounted: Vec<SymbolId>,
    /// Tables, laws and paths that are functions by name, in the order of their first use.
    pub functions: Vec<NamedFunction>,
    /// Tables of one argument, in file order.
    pub measured: Vec<MeasuredCurve>,
    /// Calls of tables that have no value beyond their rows.
    pub table_calls: Vec<TableCall>,
    /// Symbols used in expressions of loads and drives, and what they measure.
    pub signals: Vec<Signal>,
    /// Names of the forces that [`Measure::Force`](crate::Measure::Force) measures: of couplings, and of ropes that may
    /// become slack.
    pub force_names: Vec<String>,
    /// The names of loads between two points that results may use.
    pub line_names: Vec<String>,
    /// Stated and guessed values of the start.
    pub initial: Vec<Initial>,
    /// Orientations of bodies among them.
    pub orientations: Vec<Orientation>,
    /// The assembly that the start is to have, if one is chosen.
    pub assembly: Option<ChosenAssembly>,
    /// Settings of the solution.
    pub solve: SolveOptions,
    /// Parameters that are functions of the motion, with a law that the run is given: none in a model
    /// that was read.
    pub inputs: Vec<ParameterId>,
    /// Inputs and outputs where a question names none.
    pub io: Io,
    /// How joints yield that repeat others; all others are rigid.
    pub compliances: Vec<Compliance>,
    /// Ranges of numbers, for sliders and searches.
    pub ranges: Vec<StatedRange>,
    /// The load cases that the file has, in file order; the chosen one is in the model already.
    pub cases: Vec<LoadCase>,
}

impl<P> Model<P> {
    /// Model with its expressions kept in another pool.
    fn with_pool<Q>(&self, pool: Q) -> Model<Q> {
        Model {
            pool,
            name: self.name.clone(),
            time: self.time,
            parameters: self.parameters.clone(),
            space: self.space,
            coordinates: self.coordinates,
            bodies: self.bodies.clone(),
            joints: self.joints.clone(),
            loads: self.loads.clone(),
            couplings: self.couplings.clone(),
            curves: self.curves.clone(),
            laws: self.laws.clone(),
            belts: self.belts.clone(),
            ropes: self.ropes.clone(),
            contacts: self.contacts.clone(),
            at_start: self.at_start.clone(),
            drives: self.drives.clone(),
            states: self.states.clone(),
            named_signals: self.named_signals.clone(),
            clocks: self.clocks.clone(),
            held: self.held.clone(),
            uncounted: self.uncounted.clone(),
            functions: self.functions.clone(),
            measured: self.measured.clone(),
            table_calls: self.table_calls.clone(),
            signals: self.signals.clone(),
            force_names: self.force_names.clone(),
            line_names: self.line_names.clone(),
            initial: self.initial.clone(),
            orientations: self.orientations.clone(),
            assembly: self.assembly.clone(),
            solve: self.solve.clone(),
            inputs: self.inputs.clone(),
            io: self.io.clone(),
            compliances: self.compliances.clone(),
            ranges: self.ranges.clone(),
            cases: self.cases.clone(),
        }
    }
}

impl Model {
    /// Name of a point of a body, `crank.P`; that of the body for its origin.
    pub fn anchor_name(&self, anchor: Anchor) -> String {
        let body = &self.bodies[anchor.body.0];
        match anchor.point {
            Some(point) => format!("{}.{}", body.name, body.points[point.0].name),
            None => body.name.clone(),
        }
    }

    /// All couplings, and the teeth with play.
    pub fn all_couplings(&self) -> impl Iterator<Item = &Coupling> {
        // One of the two sides of each pair.
        let sides = self.loads.iter().filter(|load| load.kind.is_back_flank() != Some(true));
        self.couplings.iter().chain(sides.filter_map(Load::teeth))
    }

    /// True where the motion follows a measure: where a load, a state or a value that is held depends on it. What
    /// outputs alone name is measured, no more.
    pub fn acts(&self, signal: &Signal) -> bool {
        let of_loads = self.loads.iter().flat_map(|load| load.kind.expressions());
        let of_states = self.states.iter().map(|state| state.rate);
        let of_held = self.held.iter().flat_map(|held| match &held.change {
            HeldChange::Tick { value, .. } => vec![*value],
            HeldChange::Event { rows } => {
                rows.iter().flat_map(|row| [row.condition, row.value]).collect()
            }
            HeldChange::HalfTurn { .. } => Vec::new(),
        });
        let mut all = of_loads.chain(of_states).chain(of_held);
        all.any(|expr| self.pool.depends_on(expr, signal.symbol))
    }

    /// Counts no half turns of ropes and belts from here on: for questions that no run answers.
    pub fn forget_turns(&mut self) {
        let counts = self.held.extract_if(.., |signal| signal.is_count());
        self.uncounted.extend(counts.map(|signal| signal.held));
    }

    /// Forgets what the author says about cuts; the parts of beams, which no cut can take apart, stay whole.
    pub fn forget_cuts(&mut self) {
        for (idx, joint) in self.joints.iter_mut().enumerate() {
            let beam = self.bodies[joint.predecessor.body.0].flexible.as_ref();
            let is_of_beam = beam.is_some_and(|beam| {
                beam.shapes().any(|shape| shape.0 == idx) || beam.has_part(joint.successor.body)
            });
            if !is_of_beam {
                joint.cut = None;
            }
        }
    }

    /// A copy that threads can share.
    pub fn snapshot(&self) -> Model<PoolSnapshot> {
        self.with_pool(self.pool.snapshot())
    }
}

impl Model<PoolSnapshot> {
    /// A model of its own, with which expressions can be made.
    pub fn to_model(&self) -> Model {
        self.with_pool(self.pool.to_pool())
    }
}

/// A named number.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Name as written.
    pub name: String,
    /// Symbol in the pool.
    pub symbol: SymbolId,
    /// Definition of the parameter: a number, or an expression of other parameters.
    pub definition: Expr,
    /// Value of the parameter, SI.
    pub value: f64,
    /// SI unit as text (`"m/s^2"`), empty when the author gave none.
    pub unit: String,
    /// Position of the value in the model text.
    pub span: Span,
}

/// The choice of the joints that are cut.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum CoordinatePolicy {
    /// bksim chooses and reports.
    #[default]
    Auto,
    /// Fewest cuts: joint coordinates along a spanning tree.
    Relative,
    /// Every joint is cut: each body has its own coordinates.
    Absolute,
}
