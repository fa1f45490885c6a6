//! [`Session`]: a model that a page edits, by requests and answers in JSON.
//!
//! ```text
//! {"do": "open", "text": "…", "name": "…"}          {"do": "edit", "edit": {…}, "moving": true}
//! {"do": "undo"}  {"do": "redo"}  {"do": "settle"}
//! {"do": "grab", "body": 1, "point": [x, y, z]}     {"do": "drag", "to": [x, y, z]}    {"do": "release"}
//! {"do": "pose", "pose": "start"}                   {"do": "start_here"}
//! {"do": "live", "t": 0.8}                          {"do": "pull", "body": 1, "point": [x, y, z]}
//! {"do": "step", "dt": 0.02, "to": [x, y, z]}       {"do": "rest"}
//! {"do": "picture", "numbers": […], "view": {…}}
//! {"do": "solve"}  {"do": "freedoms"}  {"do": "equations"}  {"do": "assemblies"}  {"do": "limits"}
//! {"do": "coordinates"}
//! ```
//!
//! The first six answer with the state of the text; a fault is `{"fault": {…}}`, and nothing has changed then. Poses
//! and motions are numbers apart from the JSON, 18 for each body.

use bksim_model::diagnostic::Diagnostic;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::controls::{controls, elements};
use crate::document::Document;
use crate::edit::Edit;
use crate::live::{Live, hold_of};
use crate::places::Places;
use crate::pose::{Posed, limit_words};
use crate::reading::{Readings, own_place_of, readings, rejected};
use crate::solver::Solver;
use crate::start::start_here;
use crate::view::View;
use crate::written::{faults, forces, joints, points, written_fault};
use crate::{answers, codes};

/// Most of a driven motion that is run again when its text changes, s.
const LONGEST_REPEAT: f64 = 30.0;

/// A request of a page.
#[derive(Clone, PartialEq, Debug, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
enum Request {
    Open {
        text: String,
        name: String,
    },
    Edit {
        edit: Edit,
        #[serde(default)]
        moving: bool,
    },
    Undo {},
    Redo {},
    Settle {},
    Grab {
        body: usize,
        point: [f64; 3],
    },
    Drag {
        to: [f64; 3],
    },
    Release {},
    Pose {
        pose: Place,
    },
    StartHere {},
    Live {
        #[serde(default)]
        t: Option<f64>,
    },
    Pull {
        body: usize,
        point: [f64; 3],
    },
    Step {
        dt: f64,
        #[serde(default)]
        to: Option<[f64; 3]>,
    },
    Rest {},
    /// The picture of poses as SVG.
    Picture {
        numbers: Vec<f64>,
        view: View,
    },
    Solve {},
    Freedoms {},
    Coordinates {},
    Limits {},
    Equations {},
    Assemblies {},
}

/// A pose to go to.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Place {
    Start,
}

/// An answer: JSON, and numbers apart from it.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Answer {
    /// The answer.
    pub json: Value,
    /// Poses, 18 numbers for each body, or a motion.
    pub numbers: Vec<f64>,
}

/// A model that is edited, posed and solved.
#[derive(Default)]
pub struct Session {
    name: String,
    document: Document,
    /// The pose of the last text that had one.
    posed: Option<Posed>,
    /// True if it is of the text as it is now.
    is_current: bool,
    /// True if the text is a whole model, with masses.
    is_whole: bool,
    faults: Vec<Diagnostic>,
    solver: Solver,
    /// The motion that goes on, if one does.
    live: Option<Live>,
}

impl Session {
    /// The answer to a request.
    pub fn answer(&mut self, request: &str) -> Answer {
        let request: Request = match serde_json::from_str(request) {
            Ok(request) => request,
            Err(error) => {
                let fault = Diagnostic::error(codes::MISSING, format!("no request: {error}"));
                return self.fault(&fault);
            }
        };
        match request {
            Request::Open { text, name } => {
                // Equations that are known serve other values of the same model.
                let solver = std::mem::take(&mut self.solver);
                *self = Self { name, document: Document::new(&text), solver, ..Self::default() };
                self.read();
                self.state()
            }
            Request::Edit { edit, moving } => self.edit(&edit, moving),
            Request::Undo {} => self.back_or_forth(Document::undo),
            Request::Redo {} => self.back_or_forth(Document::redo),
            Request::Settle {} => {
                self.document.settle();
                Answer { json: json!({}), ..Answer::default() }
            }
            Request::Grab { body, point } => self.with_pose(|posed| {
                let fault = posed.grab(body, point).err().map(|error| error.to_string());
                json!({ "refused": fault })
            }),
            Request::Drag { to } => self.with_pose(|posed| {
                let dragged = posed.to(to);
                let limit = dragged.limit.as_ref().map(limit_words);
                let transmissions = posed.transmissions();
                json!({ "distance": dragged.distance, "limit": limit, "transmissions": transmissions })
            }),
            Request::Release {} => self.with_pose(|posed| {
                posed.release();
                json!({})
            }),
            Request::Pose { pose: Place::Start } => self.with_pose(|posed| {
                posed.go_to_start();
                json!({})
            }),
            Request::StartHere {} => self.start_here(),
            Request::Live { t } => self.begin_live(t),
            Request::Pull { body, point } => self.pull(body, point),
            Request::Step { dt, to } => self.step(dt, to),
            Request::Rest {} => self.rest(),
            Request::Picture { numbers, view } => {
                let svg = self.posed.as_mut().map(|posed| posed.svg(&numbers, &view));
                Answer { json: json!({ "svg": svg }), numbers: Vec::new() }
            }
            Request::Solve {} => self.solve(),
            Request::Freedoms {} => self.of_mechanism(answers::freedoms),
            Request::Coordinates {} => self.with_pose(|posed| posed.coordinates()),
            Request::Limits {} => self.limits(),
            Request::Equations {} => {
                self.of_mechanism(|mechanism| Ok(answers::equations(mechanism)))
            }
            Request::Assemblies {} => self.assemblies(),
        }
    }

    /// The text as it is now.
    pub fn text(&self) -> &str {
        self.document.text()
    }

    fn edit(&mut self, edit: &Edit, is_moving: bool) -> Answer {
        let made =
            if is_moving { self.document.apply_moving(edit) } else { self.document.apply(edit) };
        match made {
            Ok(()) => {
                self.read();
                self.state()
            }
            Err(error) => self.fault(&error.diagnostic(self.document.text())),
        }
    }

    fn back_or_forth(&mut self, step: fn(&mut Document) -> bool) -> Answer {
        if step(&mut self.document) {
            self.read();
        }
        self.state()
    }

    /// Reads the text; the pose stays near the one that it was.
    fn read(&mut self) {
        if self.document.text().trim().is_empty() {
            // An empty plane is no fault.
            *self = Self {
                name: std::mem::take(&mut self.name),
                document: std::mem::take(&mut self.document),
                solver: std::mem::take(&mut self.solver),
                ..Self::default()
            };
            return;
        }
        let read = readings(self.document.text(), &self.name);
        self.faults.clone_from(&read.faults);
        self.is_whole = read.model.is_some();
        self.is_current = false;
        let expansion = read.expansion;
        let Some(model) = read.model.or(read.geometry) else { return };
        match Posed::of(model) {
            Ok(mut posed) => {
                let is_moved = |old: &&Posed| {
                    old.q().iter().zip(old.start()).any(|(a, b)| (a - b).abs() > 1e-9)
                };
                if let Some(old) = self.posed.as_ref().filter(is_moved) {
                    posed.go_near(old);
                }
                self.posed = Some(posed);
                self.is_current = true;
                self.go_on();
            }
            Err(error) => {
                let faults = rejected(&error).into_iter();
                self.faults.extend(faults.map(|fault| own_place_of(fault, expansion.as_ref())));
            }
        }
    }

    /// All that a page shows of the text.
    fn state(&mut self) -> Answer {
        let text = self.document.text();
        let places = Places::of_whole(text);
        let [can_undo, can_redo] = self.document.can_undo_and_redo();
        let ranges = self.posed.as_ref().map_or(&[][..], |posed| &posed.model().ranges);
        let mut json = json!({
            "text": text,
            "can_undo": can_undo,
            "can_redo": can_redo,
            "is_current": self.is_current,
            "is_whole": self.is_whole,
            "faults": faults(text, &self.faults),
            "controls": places.as_ref().map(|places| controls(places, ranges)),
            "elements": places.as_ref().map(elements),
        });
        let mut numbers = Vec::new();
        if let Some(posed) = self.posed.as_mut().filter(|_| self.is_current) {
            json["scene"] = posed.scene();
            json["joints"] = joints(posed);
            json["points"] = points(posed);
            json["forces"] = forces(posed);
            numbers = posed.numbers();
        }
        Answer { json, numbers }
    }

    fn fault(&self, fault: &Diagnostic) -> Answer {
        let json = json!({ "fault": written_fault(self.document.text(), fault) });
        Answer { json, numbers: Vec::new() }
    }

    fn with_pose(&mut self, of: impl FnOnce(&mut Posed) -> Value) -> Answer {
        let Some(posed) = &mut self.posed else {
            return Answer { json: json!({}), numbers: Vec::new() };
        };
        let json = of(posed);
        Answer { json, numbers: posed.numbers() }
    }

    fn start_here(&mut self) -> Answer {
        let edits = match (Places::of_whole(self.document.text()), &mut self.posed) {
            (Some(places), Some(posed)) if self.is_current => start_here(&places, posed),
            _ => Vec::new(),
        };
        if edits.is_empty() {
            return self.state();
        }
        let answer = self.edit(&Edit::Several { edits }, false);
        if let Some(posed) = &mut self.posed {
            posed.go_to_start();
        }
        if answer.json.get("fault").is_some() { answer } else { self.state() }
    }

    /// A motion without an end, from time `t` of that of the model, or from the pose that is shown.
    fn begin_live(&mut self, t: Option<f64>) -> Answer {
        let found = readings(self.document.text(), &self.name);
        let begun = match (found.model, &mut self.posed, t) {
            (Some(model), _, Some(t)) => Live::begin(model, t),
            // Drives begin where they begin.
            (Some(model), Some(posed), None) if model.drives.is_empty() => {
                Live::begin_in(model, posed, None)
            }
            (Some(model), ..) => Live::begin(model, 0.0),
            (None, ..) => Err(found.faults),
        };
        self.take_live(begun)
    }

    fn take_live(&mut self, begun: Result<Live, Vec<Diagnostic>>) -> Answer {
        match begun {
            Ok(live) => {
                self.live = Some(live);
                self.of_live(true)
            }
            Err(found) => {
                self.live = None;
                let fault = found.iter().find(|fault| fault.is_error()).or(found.first());
                let fault = fault.map(|fault| written_fault(self.document.text(), fault));
                Answer { json: json!({ "fault": fault }), numbers: Vec::new() }
            }
        }
    }

    /// Where the motion is that goes on.
    fn of_live(&mut self, is_there: bool) -> Answer {
        let Some(live) = &mut self.live else { return Answer::default() };
        let json = json!({ "t": live.t(), "is_there": is_there, "energy": live.energy() });
        Answer { json, numbers: live.numbers() }
    }

    /// Takes hold of a body that moves.
    fn pull(&mut self, body: usize, point: [f64; 3]) -> Answer {
        let found = readings(self.document.text(), &self.name);
        let (Some(model), Some(live), Some(posed)) = (found.model, &self.live, &self.posed) else {
            return Answer { json: json!({}), numbers: Vec::new() };
        };
        let Some(hold) = hold_of(&model, body, point).filter(|hold| !live.holds(*hold)) else {
            return self.of_live(true);
        };
        let held = Live::held(model, hold, posed.size(), &live.left());
        self.take_live(held)
    }

    fn step(&mut self, dt: f64, to: Option<[f64; 3]>) -> Answer {
        let Some(live) = &mut self.live else {
            return Answer { json: json!({}), numbers: Vec::new() };
        };
        match live.step(dt, to) {
            Ok(is_there) => self.of_live(is_there),
            Err(fault) => {
                let mut answer = self.of_live(true);
                answer.json["fault"] = written_fault(self.document.text(), &fault);
                answer
            }
        }
    }

    /// Ends the motion that goes on; the pose stays where it is.
    fn rest(&mut self) -> Answer {
        if let (Some(live), Some(posed)) = (self.live.take(), &mut self.posed) {
            live.left().bring(posed);
        }
        self.with_pose(|_| json!({}))
    }

    /// Lets the motion go on with a text that has changed: in the pose near to where it is, with its rates.
    fn go_on(&mut self) {
        let (Some(live), Some(posed)) = (self.live.take(), &mut self.posed) else { return };
        let left = live.left();
        let Some(model) = readings(self.document.text(), &self.name).model else { return };
        let next = if live.is_driven() || !model.drives.is_empty() {
            Live::begin(model, left.t().min(LONGEST_REPEAT))
        } else {
            left.bring(posed);
            Live::begin_in(model, posed, Some(&left))
        };
        self.live = next.ok();
    }

    fn solve(&mut self) -> Answer {
        let Readings { whole, model, faults: found, expansion, .. } =
            readings(self.document.text(), &self.name);
        let Some(model) = model else {
            let faults = faults(self.document.text(), &found);
            return Answer { json: json!({ "faults": faults }), numbers: Vec::new() };
        };
        let text = self.document.text();
        let own = |fault: Diagnostic| own_place_of(fault, expansion.as_ref());
        match self.solver.solve(&whole, &self.name, model) {
            Ok(moved) => {
                let found: Vec<Diagnostic> = moved.faults.into_iter().map(own).collect();
                let curves: Vec<Value> = moved
                    .curves
                    .iter()
                    .map(|(name, unit, _)| json!({ "name": name, "unit": unit }))
                    .collect();
                let mut numbers = moved.times.clone();
                numbers.extend(moved.curves.iter().flat_map(|(.., values)| values));
                numbers.extend(moved.frames);
                numbers.extend(moved.forces.numbers);
                let json = json!({
                    "n_frames": moved.times.len(),
                    "curves": curves,
                    "forces": moved.forces.rows,
                    "scene": moved.scene,
                    "faults": faults(text, &found),
                    "is_derived": moved.is_derived,
                });
                Answer { json, numbers }
            }
            Err(found) => {
                let found: Vec<Diagnostic> = found.into_iter().map(own).collect();
                Answer { json: json!({ "faults": faults(text, &found) }), numbers: Vec::new() }
            }
        }
    }

    /// An answer that the equations give.
    fn of_mechanism(
        &mut self,
        of: impl FnOnce(&bksim_sim::Mechanism) -> Result<Value, Vec<Diagnostic>>,
    ) -> Answer {
        let Readings { model, faults: found, expansion, .. } =
            readings(self.document.text(), &self.name);
        let derived = match model {
            Some(model) => {
                bksim_sim::Mechanism::derive(model, Vec::new()).map_err(|rejected| rejected.0)
            }
            None => Err(found),
        };
        let json = derived.and_then(|mechanism| of(&mechanism)).unwrap_or_else(|found| {
            let own = |fault: Diagnostic| own_place_of(fault, expansion.as_ref());
            let found: Vec<Diagnostic> = found.into_iter().map(own).collect();
            json!({ "faults": faults(self.document.text(), &found) })
        });
        Answer { json, numbers: Vec::new() }
    }

    fn limits(&mut self) -> Answer {
        let Readings { model, geometry, .. } = readings(self.document.text(), &self.name);
        let json = model.or(geometry).map_or_else(|| json!({}), crate::limits::limits);
        Answer { json, numbers: Vec::new() }
    }

    fn assemblies(&mut self) -> Answer {
        let Readings { model, geometry, .. } = readings(self.document.text(), &self.name);
        let nothing = Answer { json: json!({ "assemblies": [] }), numbers: Vec::new() };
        let (Some(model), Some(posed)) = (model.or(geometry), &mut self.posed) else {
            return nothing;
        };
        match answers::ways(model, posed) {
            Ok((json, numbers)) => Answer { json, numbers },
            Err(found) => {
                let json = json!({ "faults": faults(self.document.text(), &found) });
                Answer { json, numbers: Vec::new() }
            }
        }
    }
}
