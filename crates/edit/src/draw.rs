//! Elements that are drawn: links, pins, guides, springs, forces, motors.

use crate::draft::{Draft, written_text};
use crate::edit::{EditError, End};
use crate::names::{fresh, fresh_point};
use crate::numbers::{angle, length, rounded, written};
use crate::scan::Kind;

/// Mass of a drawn link.
const MASS: &str = "1 kg";
/// Stiffness of a drawn spring.
const STIFFNESS: &str = "500 N/m";
/// Damping of a drawn damper.
const DAMPING: &str = "20 N s/m";
/// Speed of a drawn motor.
const SPEED: &str = "60 rpm";
/// Free fall.
const GRAVITY: &str = "9.81 m/s^2";

/// Keys and values of a new table.
type Pairs = Vec<(String, String)>;

fn pairs(of: &[(&str, String)]) -> Pairs {
    of.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect()
}

fn quoted(text: &str) -> String {
    written_text(text)
}

fn two(a: &str, b: &str) -> String {
    format!("[{}, {}]", quoted(a), quoted(b))
}

/// A place as TOML.
fn place([x, y]: [f64; 2]) -> String {
    let coordinate = |x: f64| if x == 0.0 { "0".to_owned() } else { quoted(&length(x)) };
    format!("[{}, {}]", coordinate(x), coordinate(y))
}

/// A named point of a body or of the ground; gives its full name.
///
/// # Errors
/// [`EditError`] where there is no such body.
pub(crate) fn point(draft: &mut Draft, body: &str, at: [f64; 2]) -> Result<String, EditError> {
    let path: Vec<&str> = if body == "ground" { vec!["ground"] } else { vec!["bodies", body] };
    let places = draft.places()?;
    if body != "ground" && places.below(&path).next().is_none() {
        return Err(EditError::missing(&[body]));
    }
    let name = fresh_point(&places, &path);
    let path = [&path[..], &["points", &name]].concat();
    draft.set(&path, &place(at))?;
    Ok(format!("{body}.{name}"))
}

/// The named point of an end, which is made where there is none.
fn named(draft: &mut Draft, end: &End) -> Result<String, EditError> {
    match (&end.on, end.local) {
        (None, _) => point(draft, "ground", end.world),
        (Some(body), _) if body == "ground" => point(draft, "ground", end.world),
        (Some(name), None) => {
            let known = name.split('.').next().unwrap_or_default();
            let places = draft.places()?;
            let is_known = known == "ground" || places.below(&["bodies", known]).next().is_some();
            if is_known { Ok(name.clone()) } else { Err(EditError::missing(&[name])) }
        }
        (Some(body), Some(local)) => point(draft, body, local),
    }
}

/// The next free letter for a joint.
fn joint_name(draft: &Draft) -> Result<String, EditError> {
    let places = draft.places()?;
    let all = crate::names::given(&places);
    let is_free = |name: &String| all.iter().all(|(_, own)| own != name);
    let letters = ('A'..='Z').map(|letter| letter.to_string());
    Ok(letters.into_iter().find(is_free).unwrap_or_else(|| fresh(&places, "J")))
}

fn joint(draft: &mut Draft, of: &[(&str, String)]) -> Result<(), EditError> {
    let name = joint_name(draft)?;
    draft.add_table(&["joints", &name], &pairs(of))
}

/// Refuses a joint of a body with itself.
fn apart(from: &str, to: &str) -> Result<(), EditError> {
    let [from, to] = [from, to].map(|end| end.split('.').next().unwrap_or_default());
    if from == to { Err(EditError::SelfJoint { body: from.to_owned() }) } else { Ok(()) }
}

/// A pin between two ends.
pub(crate) fn pin(draft: &mut Draft, from: &End, to: &End) -> Result<(), EditError> {
    let (from, to) = (named(draft, from)?, named(draft, to)?);
    apart(&from, &to)?;
    joint(draft, &[("type", quoted("revolute")), ("between", two(&from, &to))])
}

/// A pin between the ground and an end.
pub(crate) fn ground(draft: &mut Draft, at: &End) -> Result<(), EditError> {
    let support = point(draft, "ground", at.world)?;
    let end = named(draft, at)?;
    apart(&support, &end)?;
    joint(draft, &[("type", quoted("revolute")), ("between", two(&support, &end))])
}

/// A guide for an end: through the place `guide` of its body, or in the ground through the end's own place.
pub(crate) fn slide(
    draft: &mut Draft,
    at: &End,
    direction: f64,
    guide: Option<&End>,
) -> Result<(), EditError> {
    let support = match guide {
        Some(guide) => named(draft, guide)?,
        None => point(draft, "ground", at.world)?,
    };
    let end = named(draft, at)?;
    apart(&support, &end)?;
    let of = [
        ("type", quoted("slot")),
        ("between", two(&support, &end)),
        ("direction", quoted(&angle(direction))),
    ];
    joint(draft, &of)
}

/// Two wheels that mesh, as large as each other.
pub(crate) fn gear(
    draft: &mut Draft,
    between: &[String; 2],
    distance: f64,
    phase: f64,
) -> Result<(), EditError> {
    let places = draft.places()?;
    let joints = places.elements("joints");
    if let Some(unknown) = between.iter().find(|joint| !joints.contains(joint)) {
        return Err(EditError::missing(&[unknown]));
    }
    // Wheels turn about pins of one carrier, and each is another body.
    let bodies = |joint: &String| {
        let text = |key: &[&str]| {
            let path = [&["joints", joint.as_str()], key].concat();
            places.find(&path).and_then(|place| places.quoted(place))
        };
        let is_pin = text(&["type"]) == Some("revolute");
        let body = |end| text(&["between", end]).and_then(|end| end.split('.').next());
        is_pin.then(|| [body("0"), body("1")])
    };
    let is_carried = match between.each_ref().map(bodies) {
        [Some(first), Some(second)] => {
            first != second && first.iter().any(|body| body.is_some() && second.contains(body))
        }
        _ => false,
    };
    if !is_carried || between[0] == between[1] || !(distance > 0.0 && distance.is_finite()) {
        return Err(EditError::NoGear { between: between.clone() });
    }
    let (name, radius) = (fresh(&places, "gear"), fresh(&places, "r"));
    draft.set(&["parameters", &radius], &quoted(&length(0.5 * distance)))?;
    let other = format!("{} - {radius}", length(distance));
    let mut of = vec![
        ("type", quoted("gear")),
        ("between", two(&between[0], &between[1])),
        ("radii", two(&radius, &other)),
    ];
    if phase.abs() > 1e-6 {
        of.push(("phase", quoted(&angle(phase))));
    }
    draft.add_table(&["couplings", &name], &pairs(&of))
}

/// A link between two ends. Its frame begins at `from`, with x along it.
pub(crate) fn link(draft: &mut Draft, from: &End, to: &End) -> Result<(), EditError> {
    let [dx, dy] = [to.world[0] - from.world[0], to.world[1] - from.world[1]];
    let places = draft.places()?;
    let (body, l) = (fresh(&places, "link"), fresh(&places, "l"));
    let middle = [0, 1].map(|i| f64::midpoint(from.world[i], to.world[i]));
    draft.set(&["parameters", &l], &quoted(&length(dx.hypot(dy))))?;

    // The body, with the free ends that would keep it from being a model.
    let half = format!("{l}/2");
    let mut of = vec![
        ("mass", quoted(MASS)),
        ("com", format!("[{}, 0]", quoted(&half))),
        ("inertia", quoted(&format!("{MASS}*{l}^2/12"))),
        ("points", format!("{{ A = [0, 0], B = [{}, 0] }}", quoted(&l))),
    ];
    if from.on.is_none() && to.on.is_none() {
        of.push(("free", "true".to_owned()));
    }
    draft.add_table(&["bodies", &body], &pairs(&of))?;
    let guess = format!(
        "{{ guess = {{ x = {}, y = {}, angle = {} }} }}",
        quoted(&length(middle[0])),
        quoted(&length(middle[1])),
        quoted(&angle(dy.atan2(dx)))
    );
    draft.set(&["initial", &body], &guess)?;

    pins(draft, &body, &[(from, "A".to_owned()), (to, "B".to_owned())])
}

/// Pins of a new body where its ends meet others.
fn pins(draft: &mut Draft, body: &str, ends: &[(&End, String)]) -> Result<(), EditError> {
    for (end, own) in ends.iter().filter(|(end, _)| end.on.is_some()) {
        let on = named(draft, end)?;
        let own = format!("{body}.{own}");
        joint(draft, &[("type", quoted("revolute")), ("between", two(&on, &own))])?;
    }
    Ok(())
}

/// A plate with corners. Its frame begins at the first of them, parallel to the ground.
pub(crate) fn plate(draft: &mut Draft, corners: &[End]) -> Result<(), EditError> {
    let Some(first) = corners.first().filter(|_| corners.len() > 2) else {
        return Err(EditError::missing(&["corners"]));
    };
    let body = fresh(&draft.places()?, "plate");
    let own = |end: &End| [0, 1].map(|i| end.world[i] - first.world[i]);
    let places: Vec<[f64; 2]> = corners.iter().map(own).collect();
    let (com, per_mass) = centroid(&places);
    let letters: Vec<String> = (0..places.len()).map(corner_name).collect();
    let points: Vec<String> =
        letters.iter().zip(&places).map(|(name, at)| format!("{name} = {}", place(*at))).collect();
    let outline: Vec<String> = places.iter().map(|at| place(*at)).collect();
    let inertia = format!("{MASS}*{} m^2", written(rounded(per_mass)));
    let mut of = vec![
        ("mass", quoted(MASS)),
        ("com", place(com)),
        ("inertia", quoted(&inertia)),
        ("points", format!("{{ {} }}", points.join(", "))),
        ("outline", format!("[{}]", outline.join(", "))),
    ];
    if corners.iter().all(|corner| corner.on.is_none()) {
        of.push(("free", "true".to_owned()));
    }
    draft.add_table(&["bodies", &body], &pairs(&of))?;
    let at = [0, 1].map(|i| quoted(&length(first.world[i] + com[i])));
    let guess = format!("{{ guess = {{ x = {}, y = {}, angle = 0 }} }}", at[0], at[1]);
    draft.set(&["initial", &body], &guess)?;
    let ends: Vec<(&End, String)> = corners.iter().zip(letters).collect();
    pins(draft, &body, &ends)
}

/// The name of a corner: A to Z, then by number.
fn corner_name(idx: usize) -> String {
    let letter =
        u8::try_from(idx).ok().and_then(|idx| (idx < 26).then_some(char::from(b'A' + idx)));
    letter.map_or_else(|| format!("P{idx}"), String::from)
}

/// Centroid of a polygon and its polar second moment about it over its area; of corners in line, their mean and a
/// rod's.
fn centroid(corners: &[[f64; 2]]) -> ([f64; 2], f64) {
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    let (mut area, mut first, mut second) = (0.0, [0.0; 2], 0.0);
    for (a, b) in sides {
        let cross = a[0] * b[1] - a[1] * b[0];
        area += 0.5 * cross;
        for i in 0..2 {
            first[i] += cross * (a[i] + b[i]) / 6.0;
            second += cross * (a[i] * a[i] + a[i] * b[i] + b[i] * b[i]) / 12.0;
        }
    }
    let n = f64::from(u32::try_from(corners.len()).unwrap_or(u32::MAX));
    let mean = [0, 1].map(|i| corners.iter().map(|corner| corner[i]).sum::<f64>() / n);
    let spread = |about: [f64; 2]| {
        let squares = corners.iter().map(|c| (c[0] - about[0]).powi(2) + (c[1] - about[1]).powi(2));
        squares.fold(0.0, f64::max)
    };
    if area.abs() <= 1e-9 * spread(mean) {
        return (mean, spread(mean) / 3.0);
    }
    let com = first.map(|moment| moment / area);
    (com, second / area - com[0] * com[0] - com[1] * com[1])
}

fn load(draft: &mut Draft, stem: &str, of: &[(&str, String)]) -> Result<(), EditError> {
    let name = fresh(&draft.places()?, stem);
    draft.add_table(&["loads", &name], &pairs(of))
}

/// A spring between two ends.
pub(crate) fn spring(draft: &mut Draft, from: &End, to: &End) -> Result<(), EditError> {
    let distance = (to.world[0] - from.world[0]).hypot(to.world[1] - from.world[1]);
    let (from, to) = (named(draft, from)?, named(draft, to)?);
    let of = [
        ("type", quoted("spring")),
        ("between", two(&from, &to)),
        ("stiffness", quoted(STIFFNESS)),
        ("length", quoted(&length(distance))),
    ];
    load(draft, "spring", &of)
}

/// A damper between two ends.
pub(crate) fn damper(draft: &mut Draft, from: &End, to: &End) -> Result<(), EditError> {
    let (from, to) = (named(draft, from)?, named(draft, to)?);
    let of =
        [("type", quoted("damper")), ("between", two(&from, &to)), ("damping", quoted(DAMPING))];
    load(draft, "damper", &of)
}

/// A force on an end.
pub(crate) fn force(draft: &mut Draft, at: &End, vector: [f64; 2]) -> Result<(), EditError> {
    let on = named(draft, at)?;
    let newtons = vector.map(|f| quoted(&format!("{} N", written(rounded(f)))));
    let of = [
        ("type", quoted("force")),
        ("on", quoted(&on)),
        ("vector", format!("[{}]", newtons.join(", "))),
    ];
    load(draft, "force", &of)
}

/// Gravity along −y.
pub(crate) fn gravity(draft: &mut Draft) -> Result<(), EditError> {
    let acceleration = format!("[0, {}]", quoted(&format!("-{GRAVITY}")));
    let places = draft.places()?;
    let is_free = places.below(&["loads", "gravity"]).next().is_none();
    let name = if is_free { "gravity".to_owned() } else { fresh(&places, "gravity") };
    let of = [("type", quoted("gravity")), ("acceleration", acceleration)];
    draft.add_table(&["loads", &name], &pairs(&of))
}

/// A drive that turns a joint evenly.
pub(crate) fn motor(draft: &mut Draft, joint: &str, from: f64) -> Result<(), EditError> {
    let places = draft.places()?;
    if !places.elements("joints").iter().any(|own| own == joint) {
        return Err(EditError::missing(&[joint]));
    }
    let (name, speed) = (fresh(&places, "motor"), fresh(&places, "speed"));
    let has_parameters =
        places.find(&["parameters"]).is_none_or(|place| place.kind == Kind::Header);
    if !has_parameters {
        return Err(EditError::NoTable { path: "parameters".to_owned() });
    }
    draft.set(&["parameters", &speed], &quoted(SPEED))?;
    let motion = format!("{} + {speed}*t", angle(from));
    let of = [("joint", quoted(joint)), ("motion", quoted(&motion))];
    draft.add_table(&["drives", &name], &pairs(&of))
}
