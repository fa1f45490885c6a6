//! Warnings about profiles.

use bksim_model::diagnostic::Diagnostic;
use bksim_model::message::short;
use bksim_model::{Cam, FollowerKind};

use super::place::Places;
use super::search::{Interval, least};
use super::{CamProfile, CamRequest};
use crate::codes;

/// A warning about a profile that is undercut.
pub(super) fn undercut(name: &str, cam: &Cam, profile: &CamProfile) -> Option<Diagnostic> {
    let &[from, to] = profile.undercuts.first()?;
    let degrees = |angle: f64| short(angle.to_degrees());
    let why = match profile.kind {
        FollowerKind::Flat => "its radius of curvature is below 0 there",
        _ => "the path of the roller's centre is bent more than the roller there",
    };
    let message = format!(
        "the profile `{name}` is undercut from {} deg to {} deg",
        degrees(from),
        degrees(to)
    );
    let help = match profile.smallest_base_circle {
        // Rounded up, so that it is enough.
        Some(least) => {
            let step = 10f64.powf(least.value.log10().floor() - 3.0);
            let enough = short(1e3 * (least.value / step).ceil() * step);
            format!("make the base circle larger: `base_circle = \"{enough} mm\"` is enough")
        }
        None => "choose a law with a smaller acceleration, or a smaller roller".to_owned(),
    };
    let fault = Diagnostic::warning(codes::UNDERCUT, message);
    Some(fault.at(cam.span.clone(), "too small for this law").note(why).help(help))
}

/// A warning about a cutter that cuts into the sides of a hollow.
pub(super) fn hollow(
    places: &Places,
    turn: &[Interval],
    request: &CamRequest,
    cam: &Cam,
    profile: &CamProfile,
) -> Option<Diagnostic> {
    let radius = request.cutter?;
    let depth = |at: f64| {
        let place = places.at(at);
        // The radius of a hollow; what is convex has none.
        place.map_or(f64::NAN, |p| if p.radius() < 0.0 { -p.radius() } else { f64::INFINITY })
    };
    let least = least(turn, &depth).filter(|least| least.value < radius)?;
    if !profile.undercuts.is_empty() {
        return None;
    }
    let message = format!(
        "a cutter of {} mm does not fit into the hollow at {} deg",
        short(1e3 * radius),
        short(least.at.to_degrees())
    );
    let step = 10f64.powf(least.value.log10().floor() - 3.0);
    let fits = short(1e3 * (least.value / step).floor() * step);
    let fault = Diagnostic::warning(codes::CUTTER, message);
    Some(
        fault
            .at(cam.span.clone(), "hollow for this base circle")
            .help(format!("take `--cutter \"{fits} mm\"`")),
    )
}
