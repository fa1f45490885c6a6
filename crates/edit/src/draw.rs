//! Elements that are drawn: links, pins, guides, springs, forces, motors.

use crate::draft::{Draft, written_text};
use crate::edit::{EditError, End};
use crate::names::{fresh, fresh_point};
use crate::numbers::{angle, length, rounded, written};
use crate::places::Kind;

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

/// A pin between two ends.
pub(crate) fn pin(draft: &mut Draft, from: &End, to: &End) -> Result<(), EditError> {
    let (from, to) = (named(draft, from)?, named(draft, to)?);
    joint(draft, &[("type", quoted("revolute")), ("between", two(&from, &to))])
}

/// A pin between the ground and an end.
pub(crate) fn ground(draft: &mut Draft, at: &End) -> Result<(), EditError> {
    let support = point(draft, "ground", at.world)?;
    let end = named(draft, at)?;
    joint(draft, &[("type", quoted("revolute")), ("between", two(&support, &end))])
}

/// A guide in the ground for an end.
pub(crate) fn slide(draft: &mut Draft, at: &End, direction: f64) -> Result<(), EditError> {
    let support = point(draft, "ground", at.world)?;
    let end = named(draft, at)?;
    let of = [
        ("type", quoted("slot")),
        ("between", two(&support, &end)),
        ("direction", quoted(&angle(direction))),
    ];
    joint(draft, &of)
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

    // Pins where it meets others.
    for (end, own) in [(from, "A"), (to, "B")] {
        if end.on.is_some() {
            let on = named(draft, end)?;
            let own = format!("{body}.{own}");
            joint(draft, &[("type", quoted("revolute")), ("between", two(&on, &own))])?;
        }
    }
    Ok(())
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
    let has_parameters = places.find(&["parameters"]).is_none_or(|place| place.kind == Kind::Table);
    if !has_parameters {
        return Err(EditError::NoTable { path: "parameters".to_owned() });
    }
    draft.set(&["parameters", &speed], &quoted(SPEED))?;
    let motion = format!("{} + {speed}*t", angle(from));
    let of = [("joint", quoted(joint)), ("motion", quoted(&motion))];
    draft.add_table(&["drives", &name], &pairs(&of))
}
