//! The laws and the profiles of cams: peak factors, pressure angles, curvature, and where a profile is undercut.
//!
//! ```text
//! ρ     radius of curvature of the path of the follower's point, of a flat face that of the profile;
//!       positive where it is convex
//! flat                    ρ > 0          else the faces cut away what they touched before
//! roller of the radius r  ρ > r          where ρ is positive
//! ```
//!
//! Source: R. L. Norton, *Cam Design and Manufacturing Handbook* (2009), chapters 2 and 7.

mod place;
mod search;
mod warnings;

use bksim_model::diagnostic::Diagnostic;
use bksim_model::{Cam, CamLaw, Curve, FollowerKind, LawSegment, Model};

use crate::error::AnalysisError;
use crate::table::{Column, Table};

use self::place::{Place, Places};
use self::search::{Interval, least, stretches};
use self::warnings::{hollow, undercut};

pub use self::search::Located;

/// Points of a drawn line in a full turn.
const N_DRAWN: usize = 720;
/// Ends nearer to each other than this part of the base circle meet.
const MEETS: f64 = 1e-9;
/// Steps of a search for the smallest base circle, by this factor.
const STEP: f64 = 1.03;
/// Largest and smallest base circle that is looked at, in those that are written.
const REACH: f64 = 1e3;

/// A question about a cam.
#[derive(Clone, PartialEq, Debug)]
pub struct CamRequest {
    /// A profile or a law; the only one of the model if it is not named.
    pub curve: Option<String>,
    /// Rows of the table over a turn.
    pub n_rows: usize,
    /// Radius of a cutter, m.
    pub cutter: Option<f64>,
}

/// The answer.
#[derive(Clone, Debug)]
pub struct CamReport {
    /// Name of the curve.
    pub name: String,
    /// Name of its law.
    pub law: String,
    /// Lifts are angles.
    pub is_angle: bool,
    /// Of every rise and return.
    pub peaks: Vec<Peaks>,
    /// Of a curve that is a profile.
    pub profile: Option<CamProfile>,
    /// Over a turn.
    pub table: Table,
    /// Undercuts, and hollows that the cutter does not fit into.
    pub warnings: Vec<Diagnostic>,
}

/// The largest velocity, acceleration and jerk of a part of a law.
#[derive(Clone, PartialEq, Debug)]
pub struct Peaks {
    /// Angle at its beginning, rad.
    pub from: f64,
    /// rad.
    pub over: f64,
    /// m or rad.
    pub rise: f64,
    /// Word of the law.
    pub law: &'static str,
    /// By the angle of the cam, m or rad.
    pub largest: [f64; 3],
    /// Of a rise of one over an angle of one.
    pub factors: [f64; 3],
}

/// A profile as a whole.
#[derive(Clone, PartialEq, Debug)]
pub struct CamProfile {
    /// The part of the follower that touches it.
    pub kind: FollowerKind,
    /// Radius of the base circle, m.
    pub base_circle: f64,
    /// Radius of the roller, m.
    pub roller: Option<f64>,
    /// The sharpest convex place: its radius of curvature, m, at an angle, rad; below zero where it is undercut.
    pub least_radius: Option<Located>,
    /// Largest pressure angles of rise and return, rad; those of returns are negative. None of a face.
    pub steepest: Option<[Located; 2]>,
    /// Ends of the way of the contact on a face, m, from the foot of the perpendicular from the axis, to the right as
    /// the follower rises.
    pub face: Option<[f64; 2]>,
    /// The smallest base circle that is not undercut, m, and the angle, rad, where it nearly is; none where none that
    /// the follower reaches is too small, or every one.
    pub smallest_base_circle: Option<Located>,
    /// Angles, rad, between which it is undercut.
    pub undercuts: Vec<[f64; 2]>,
    /// True where it ends at its beginning.
    pub is_closed: bool,
    /// The profile, the path of a roller's centre, and the path of the centre of the cutter.
    pub lines: Vec<CamLine>,
}

/// A curve on a cam, in its frame.
#[derive(Clone, PartialEq, Debug)]
pub struct CamLine {
    /// `profile`, `pitch` or `cutter`.
    pub name: &'static str,
    /// m, each with the angle by which the curve turns on the way to the next one, rad.
    pub points: Vec<([f64; 2], f64)>,
    /// The last point is before the first again.
    pub is_closed: bool,
}

/// A curve of type `cam` with what it is made of.
type Profiled<'m> = (&'m Curve, &'m Cam);

/// Answers a question about a law or a profile.
///
/// # Errors
/// [`AnalysisError::UnknownCam`], and [`AnalysisError::Compile`].
pub fn cam(model: &Model, request: &CamRequest) -> Result<CamReport, AnalysisError> {
    let (law, profile) = chosen(model, request.curve.as_deref())?;
    let places = Places::compile(model, law, profile)?;
    let turn = turn_of(law);
    let mut report = CamReport {
        name: profile.map_or(&law.name, |(curve, _)| &curve.name).clone(),
        law: law.name.clone(),
        is_angle: law.is_angle,
        peaks: peaks(&places, law),
        profile: None,
        table: table(&places, &turn, request),
        warnings: Vec::new(),
    };
    if let Some((_, cam)) = profile {
        let profile = whole(&places, &turn, request.cutter);
        report.warnings.extend(undercut(&report.name, cam, &profile));
        report.warnings.extend(hollow(&places, &turn, request, cam, &profile));
        report.profile = Some(profile);
    }
    Ok(report)
}

/// The law, and the profile if there is one.
fn chosen<'m>(
    model: &'m Model,
    name: Option<&str>,
) -> Result<(&'m CamLaw, Option<Profiled<'m>>), AnalysisError> {
    let profiles = model.curves.iter().filter_map(|curve| Some((curve, curve.cam.as_ref()?)));
    let profiles: Vec<Profiled<'m>> = profiles.collect();
    let of_profile = |&(curve, cam): &Profiled<'m>| (&model.laws[cam.law.0], Some((curve, cam)));
    let found = match name {
        Some(name) => {
            let law = || Some((model.laws.iter().find(|law| law.name == name)?, None));
            let profile = profiles.iter().find(|(curve, _)| curve.name == name);
            profile.map(of_profile).or_else(law)
        }
        None => match (profiles.as_slice(), model.laws.as_slice()) {
            ([only], _) => Some(of_profile(only)),
            ([], [only]) => Some((only, None)),
            _ => None,
        },
    };
    let known = || {
        let profiles = profiles.iter().map(|(curve, _)| curve.name.clone());
        profiles.chain(model.laws.iter().map(|law| law.name.clone())).collect()
    };
    found.ok_or_else(|| AnalysisError::UnknownCam { name: name.map(str::to_owned), known: known() })
}

/// The parts of a turn between which formulas change, as far as the law goes.
fn turn_of(law: &CamLaw) -> Vec<Interval> {
    let over: f64 = law.segments.iter().map(|segment| segment.over).sum();
    let borders = law.segments.iter().flat_map(|segment| &segment.borders);
    let mut borders: Vec<f64> = borders.copied().chain([over]).collect();
    borders.dedup();
    search::intervals(&borders, std::f64::consts::TAU)
}

fn peaks(places: &Places, law: &CamLaw) -> Vec<Peaks> {
    let peaks = law.segments.iter().filter_map(|segment| {
        let mut borders = segment.borders.clone();
        borders.push(segment.from + segment.over);
        let within = search::intervals(&borders, f64::INFINITY);
        let largest = [1, 2, 3].map(|order| {
            let size = |at: f64| -places.lift(at)[order].abs();
            least(&within, &size).map_or(f64::NAN, |located| -located.value)
        });
        let unit = |order: i32| segment.over.powi(order) / segment.rise.abs();
        let [velocity, acceleration, jerk] = largest;
        let factors = [velocity * unit(1), acceleration * unit(2), jerk * unit(3)];
        let LawSegment { from, over, rise, .. } = *segment;
        Some(Peaks { from, over, rise, law: segment.law?, largest, factors })
    });
    peaks.collect()
}

/// The columns: angle and motion; of a profile its point, pressure angle and curvature.
fn table(places: &Places, turn: &[Interval], request: &CamRequest) -> Table {
    let lift = if places.is_angle { "rad" } else { "m" };
    let mut columns = vec![Column::new("angle", "rad")];
    columns
        .extend(["lift", "velocity", "acceleration", "jerk"].map(|name| Column::new(name, lift)));
    let kind = places.kind();
    if let Some(kind) = kind {
        columns.extend(["x", "y", "radius"].map(|name| Column::new(name, "m")));
        match kind {
            FollowerKind::Flat => columns.push(Column::new("contact", "m")),
            FollowerKind::Knife => columns.push(Column::new("pressure_angle", "rad")),
            FollowerKind::Roller => {
                columns.push(Column::new("pressure_angle", "rad"));
                let pitch = ["pitch_x", "pitch_y", "pitch_radius"];
                columns.extend(pitch.map(|name| Column::new(name, "m")));
            }
        }
        if request.cutter.is_some() {
            columns.extend(["cutter_x", "cutter_y"].map(|name| Column::new(name, "m")));
        }
    }
    let last = turn.last().map_or(0.0, |interval| interval.to);
    let n = request.n_rows.max(2);
    let row = |k: usize| {
        let at = last * k as f64 / (n - 1) as f64;
        let mut row = vec![at];
        row.extend(places.lift(at));
        let Some(place) = places.at(at) else { return row };
        row.extend(place.profile());
        row.push(place.radius());
        match kind {
            Some(FollowerKind::Flat) => row.push(place.contact),
            Some(FollowerKind::Knife) => row.push(place.pressure),
            _ => {
                row.push(place.pressure);
                row.extend(place.at);
                row.push(1.0 / place.bend);
            }
        }
        row.extend(request.cutter.iter().flat_map(|&radius| place.outside(radius)));
        row
    };
    Table { columns, rows: (0..n).map(row).collect() }
}

/// The profile over a turn.
fn whole(places: &Places, turn: &[Interval], cutter: Option<f64>) -> CamProfile {
    let base = places.base;
    let of = |value: &dyn Fn(&Place) -> f64, at: f64| places.at(at).map_or(f64::NAN, |p| value(&p));
    let kind = places.kind().unwrap_or(FollowerKind::Knife);
    let is_flat = kind == FollowerKind::Flat;

    // Convex places alone are sharp.
    let sharp = |place: &Place| {
        let radius = place.radius();
        if radius > 0.0 || place.margin() < 0.0 { radius } else { f64::INFINITY }
    };
    let least_radius =
        least(turn, &|at| of(&sharp, at)).filter(|located| located.value.is_finite());
    let extreme = |sign: f64, value: &dyn Fn(&Place) -> f64| {
        let found = least(turn, &|at| sign * of(value, at));
        found.map_or(Located { value: f64::NAN, at: f64::NAN }, |l| Located {
            value: sign * l.value,
            ..l
        })
    };
    let pressure = |sign| extreme(sign, &|place| place.pressure);
    let contact = |sign| extreme(sign, &|place| place.contact).value;

    let margin = |at: f64| of(&|place| place.margin(), at);
    let first = places.at(0.0).map(|place| place.profile());
    let end = turn.last().map_or(0.0, |interval| interval.to);
    let last = places.at(end).map(|place| place.profile());
    let is_closed = first.zip(last).is_some_and(|(p, q)| {
        (p[0] - q[0]).hypot(p[1] - q[1]) <= MEETS * base && end > std::f64::consts::PI
    });
    CamProfile {
        kind,
        base_circle: base,
        roller: (kind == FollowerKind::Roller).then_some(places.roller),
        least_radius,
        steepest: (!is_flat).then(|| [pressure(-1.0), pressure(1.0)]),
        face: is_flat.then(|| [contact(1.0), contact(-1.0)]),
        smallest_base_circle: smallest_base(places, turn),
        undercuts: stretches(turn, &margin),
        is_closed,
        lines: lines(places, end, is_closed, cutter),
    }
}

fn lines(places: &Places, end: f64, is_closed: bool, cutter: Option<f64>) -> Vec<CamLine> {
    let n = N_DRAWN;
    let found: Vec<Place> = (0..=n).filter_map(|k| places.at(end * k as f64 / n as f64)).collect();
    let drawn = |name: &'static str, point: &dyn Fn(&Place) -> [f64; 2]| {
        let turning = found.windows(2).map(|pair| {
            let [[a, b], [c, d]] = [pair[0].normal, pair[1].normal];
            (a * d - b * c).atan2(a * c + b * d)
        });
        let points =
            found.iter().zip(turning.chain([0.0])).map(|(place, turn)| (point(place), turn));
        let mut points: Vec<([f64; 2], f64)> = points.collect();
        if is_closed {
            points.pop();
        }
        CamLine { name, points, is_closed }
    };
    let mut lines = vec![drawn("profile", &Place::profile)];
    if places.kind() == Some(FollowerKind::Roller) {
        lines.push(drawn("pitch", &|place| place.at));
    }
    lines.extend(cutter.map(|radius| drawn("cutter", &move |place| place.outside(radius))));
    lines
}

/// The smallest base circle from the written one on, downwards while nothing is undercut, upwards while something is.
fn smallest_base(places: &Places, turn: &[Interval]) -> Option<Located> {
    if places.kind() == Some(FollowerKind::Knife) {
        return None;
    }
    let worst = |base: f64| {
        let margin = |at: f64| places.at_base(at, base).map_or(f64::NAN, |place| place.margin());
        least(turn, &margin).filter(|located| located.value.is_finite())
    };
    let is_good = |base: f64| worst(base).is_some_and(|located| located.value >= 0.0);
    let goes_down = is_good(places.base);
    let factor = if goes_down { 1.0 / STEP } else { STEP };
    let (mut known, mut next) = (places.base, places.base * factor);
    while is_good(next) == goes_down {
        if !(1.0 / REACH..REACH).contains(&(next / places.base)) {
            return None;
        }
        (known, next) = (next, next * factor);
    }
    let (mut bad, mut good) = if goes_down { (next, known) } else { (known, next) };
    while good.next_down() > bad {
        let middle = f64::midpoint(bad, good);
        if middle <= bad || middle >= good {
            break;
        }
        *(if is_good(middle) { &mut good } else { &mut bad }) = middle;
    }
    // Below, the follower does not reach its cam at all.
    worst(bad)?;
    worst(good).map(|located| Located { value: good, ..located })
}
