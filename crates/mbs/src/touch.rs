//! Places where outlines touch: distance, direction, and how far they reach.
//!
//! A point, corner or disc with the centre Q and the radius r meets an edge from A with the unit normal n to its left,
//! the inside of a ring of radius R about C, or a disc of that kind from outside:
//!
//! ```text
//! edge    φ = r − n·d                    n                  d = Q − A
//! ring    φ = (d·d − ρ²)/2ρ, ρ = R − r   n = −d/ρ           d = Q − C
//! disc    φ = (ρ² − d·d)/2ρ, ρ = R + r   n = d/ρ
//! curve   φ = − n·d                      n across it    d from its place that is nearest
//! ```
//!
//! φ is the penetration where it is zero, with its right slopes, and has no root that vanishes; n is the direction of the
//! force on the mover. Friction is along t = (n_y, −n_x): the speed of the mover along t against the base is that of the
//! second body along the first, whichever of them the mover belongs to.
//!
//! In space a plane through A with the normal n is as an edge, balls and the inside of spheres are as discs and rings. Friction is
//! along two directions t₁ and t₂ across n: those of a plane are fixed in its body, and those of a ball follow n, without
//! a jump but where n is far below the plane of x and y,
//!
//! ```text
//! t₁ = (1 − n_x²/(1 + n_z), − n_x n_y/(1 + n_z), − n_x),   t₂ = n × t₁        and for n_z < −1/2 with 1 − n_z likewise
//! ```
//!
//! Source: J. R. Frisvad, *Building an orthonormal basis from a 3D unit vector without normalization* (2012).

use bksim_expr::{Expr, Function, Pool};

use crate::constraint::{Constraint, Source};
use crate::force::{Wrench, powers};
use crate::joint::Lifted;
use crate::kinematics::Kinematics;
use crate::spatial;
use bksim_model::{
    Anchor, Base, BodyId, ContactId, ContactPair, ContactPart, LoadId, Model, Opposed, Place,
    Reach, Space, Vector,
};

/// A corner may be turned by this sine beyond where its own edge lies on the edge that it meets.
const TURNED: (i64, i64) = (3, 10);
/// Speed, m/s, below which the direction of a slip is that in which it began.
const AT_REST: f64 = 1e-12;
/// How deep, as a part of its length, an edge of an open chain is felt by a point.
const DEPTH: (i64, i64) = (1, 4);

/// A place in the axes of the ground.
pub(crate) struct Touching {
    /// φ, m.
    pub(crate) penetration: Expr,
    /// Distance of the outlines, m; negative where they overlap.
    gap: Expr,
    /// Positive where the place is one: the mover is before the edge, and not past its ends.
    pub(crate) reach: Expr,
    /// Unit vector on the mover.
    normal: Vector,
    /// Where they touch.
    at: Vector,
    /// A point of the line along which they rub.
    along: Vector,
    /// Unit vectors along which they rub, the second in space alone.
    ways: [Vector; 2],
    mover: BodyId,
    base: BodyId,
    is_second: bool,
}

impl Touching {
    pub(crate) fn of(model: &Model, kinematics: &Kinematics, place: &Place) -> Self {
        let pool = &model.pool;
        let point = |anchor| kinematics.anchor(model, anchor);
        let center = point(place.mover.center);
        let radius = place.mover.radius;
        let origin = point(place.base.anchor());
        let d = spatial::sub(pool, &center, &origin);
        let scaled = |s, v: &Vector| spatial::scale(pool, s, v);
        let mut reaches = Vec::new();
        let mut ways = None;
        let (penetration, gap, normal, at, along) = match &place.base {
            Base::Plane(plane) => {
                let frame = kinematics.frame(model, plane.anchor).rotation;
                let turned = |v: &Vector| frame.apply(pool, v);
                let normal = turned(&plane.normal);
                ways = Some(spatial::perpendicular(pool, &plane.normal).map(|way| turned(&way)));
                let above = pool.simplify(spatial::dot(pool, &normal, &d));
                let penetration = pool.sub(radius, above);
                let at = spatial::sub(pool, &center, &scaled(radius, &normal));
                (penetration, pool.neg(penetration), normal, at, at)
            }
            Base::Edge { ends, reach } => {
                let (way, length) = direction(model, kinematics, *ends);
                let normal = spatial::cross(pool, &spatial::z_axis(pool), &way);
                let above = pool.simplify(spatial::dot(pool, &normal, &d));
                let penetration = pool.sub(radius, above);
                match reach {
                    Reach::Endless => (),
                    Reach::Ends => {
                        let foot = pool.simplify(spatial::dot(pool, &way, &d));
                        // A disc is before the edge as long as its centre is; a point a little beyond it, too.
                        let depth = if pool.is_zero(radius) {
                            pool.mul(pool.rational(DEPTH.0, DEPTH.1), length)
                        } else {
                            radius
                        };
                        reaches.extend([
                            foot,
                            pool.sub(length, foot),
                            pool.sub(depth, penetration),
                        ]);
                    }
                    Reach::Within(others) => reaches.extend(others.iter().map(|&ends| {
                        let (way, _) = direction(model, kinematics, ends);
                        let normal = spatial::cross(pool, &spatial::z_axis(pool), &way);
                        let from = spatial::sub(pool, &center, &point(ends[0]));
                        let other = spatial::dot(pool, &normal, &from);
                        pool.simplify(pool.sub(above, other))
                    })),
                }
                let at = spatial::sub(pool, &center, &scaled(radius, &normal));
                (penetration, pool.neg(penetration), normal, at, origin)
            }
            Base::Ring(ring) => {
                let room = pool.sub(ring.radius, radius);
                let (penetration, distance) = circle(pool, &d, room);
                let normal = scaled(pool.neg(pool.div(pool.one(), room)), &d);
                let to = scaled(pool.div(ring.radius, room), &d);
                let at = spatial::add(pool, &origin, &to);
                (penetration, pool.sub(room, distance), normal, at, at)
            }
            Base::Curve { joint, .. } => {
                let joint = &model.joints[joint.0];
                let sides = kinematics.sides(model, joint);
                let Lifted { gap, normal, at } =
                    Lifted::of(pool, joint, &sides).expect("a joint that lifts");
                (pool.neg(gap), gap, normal, at, at)
            }
            Base::Round { round, wedge } => {
                let sum = pool.add(round.radius, radius);
                let (outside, distance) = circle(pool, &d, sum);
                let normal = scaled(pool.div(pool.one(), sum), &d);
                let at = spatial::add(pool, &origin, &scaled(round.radius, &normal));
                // Between the normals of the edges next to a corner: past the end of one, before the start of the other.
                for (end, sense) in wedge.iter().zip([1, -1]) {
                    let Some(end) = *end else { continue };
                    let ends = if sense == 1 { [end, round.center] } else { [round.center, end] };
                    let (way, _) = direction(model, kinematics, ends);
                    let foot = pool.mul(pool.int(sense), spatial::dot(pool, &way, &d));
                    reaches.push(pool.simplify(foot));
                }
                (pool.neg(outside), pool.sub(distance, sum), normal, at, at)
            }
        };
        // The edges of a corner are before what it meets.
        if matches!(place.base, Base::Edge { .. } if !reaches.is_empty()) {
            for &neighbor in &place.neighbors {
                let ends = [place.mover.center, neighbor];
                let (way, _) = direction(model, kinematics, ends);
                let above = spatial::dot(pool, &normal, &way);
                reaches.push(pool.simplify(pool.add(above, pool.rational(TURNED.0, TURNED.1))));
            }
        }
        let least = |a, b| pool.call(Function::Min, &[a, b]).expect("two arguments");
        let reach = reaches.into_iter().reduce(least).unwrap_or(pool.one());
        let ways = ways.unwrap_or_else(|| match model.space {
            Space::Spatial => across(pool, &normal),
            Space::Planar => [[normal[1], pool.neg(normal[0]), normal[2]], spatial::z_axis(pool)],
        });
        let [mover, base] = [place.mover.center.body, place.base.anchor().body];
        let is_second = place.is_second;
        Self { penetration, gap, reach, normal, at, along, ways, mover, base, is_second }
    }

    fn pair(&self, pool: &Pool, force: Vector, at: Vector) -> Vec<Wrench> {
        let moment = spatial::zero(pool);
        vec![
            Wrench { body: self.mover, force, at, moment },
            Wrench { body: self.base, force: spatial::neg(pool, &force), at, moment },
        ]
    }

    /// Of a unit force that pushes the bodies apart.
    pub(crate) fn pushing(&self, pool: &Pool) -> Vec<Wrench> {
        self.pair(pool, self.normal, self.at)
    }

    /// Of a unit friction along one of its directions.
    fn rubbing(&self, pool: &Pool, way: usize) -> Vec<Wrench> {
        self.pair(pool, self.ways[way], self.along)
    }

    /// Of a unit torque of rolling resistance, counter-clockwise on the second body.
    pub(crate) fn rolling(&self, pool: &Pool) -> Vec<Wrench> {
        let moment = spatial::z_axis(pool);
        let pair = if self.is_second { [self.mover, self.base] } else { [self.base, self.mover] };
        let force = spatial::zero(pool);
        let back = spatial::neg(pool, &moment);
        let of = |(body, moment)| Wrench { body, force, at: self.at, moment };
        pair.into_iter().zip([moment, back]).map(of).collect()
    }

    /// Of one unit of friction against this motion.
    pub(crate) fn against(&self, pool: &Pool, opposed: Opposed) -> Vec<Wrench> {
        match opposed {
            Opposed::Slip => self.rubbing(pool, 0),
            Opposed::Across => self.rubbing(pool, 1),
            Opposed::Roll => self.rolling(pool),
        }
    }
}

/// Two unit vectors across a unit vector and each other.
///
/// # Panics
/// Never: comparisons have two operands.
fn across(pool: &Pool, [x, y, z]: &Vector) -> [Vector; 2] {
    let [x, y, z] = [*x, *y, *z];
    let one = pool.one();
    // About the pole that is farther: s is the sign of z there.
    let about = |s: Expr| -> [Vector; 2] {
        let a = pool.neg(pool.div(one, pool.add(s, z)));
        let b = pool.mul(pool.mul(x, y), a);
        let s_times = |e: Expr| pool.mul(s, e);
        let first = pool.add(one, s_times(pool.mul(pool.powi(x, 2), a)));
        let second = pool.add(s, pool.mul(pool.powi(y, 2), a));
        [[first, s_times(b), pool.neg(s_times(x))], [b, second, pool.neg(y)]]
    };
    let [above, below] = [about(one), about(pool.int(-1))];
    let is_above = pool.call(Function::Gt, &[z, pool.rational(-1, 2)]).expect("two arguments");
    let choose =
        |k: usize| std::array::from_fn(|i| pool.select(is_above, above[k][i], below[k][i]));
    [choose(0), choose(1)]
}

/// The unit vector along a slip w = (w₁, w₂) of these rates, which `began` along the unit vector d = (ς₁, ς₂).
///
/// With e across d and ρ = (w · e)/(w · d) it is d + ρ e over its length: w/|w| as long as w · d > 0, d where w = 0, and goes on
/// smoothly past the rest to which friction brings the bodies.
pub(crate) fn way_of_slip(pool: &Pool, [c, s]: [Expr; 2], [w1, w2]: [Expr; 2]) -> [Expr; 2] {
    let forward = pool.add(pool.mul(c, w1), pool.mul(s, w2));
    let sideways = pool.sub(pool.mul(c, w2), pool.mul(s, w1));
    let square = pool.add(pool.powi(forward, 2), pool.float(AT_REST * AT_REST));
    let slope = pool.div(pool.mul(forward, sideways), square);
    let length = pool.sqrt(pool.add(pool.one(), pool.powi(slope, 2)));
    let first = pool.sub(c, pool.mul(s, slope));
    let second = pool.add(s, pool.mul(c, slope));
    [first, second].map(|part| pool.div(part, length))
}

/// The penetration (d·d − ρ²)/2ρ and |d|.
fn circle(pool: &Pool, d: &Vector, radius: Expr) -> (Expr, Expr) {
    let square = pool.simplify(spatial::dot(pool, d, d));
    let difference = pool.sub(square, pool.powi(radius, 2));
    (pool.div(difference, pool.mul(pool.int(2), radius)), pool.sqrt(square))
}

/// The unit vector from one point of a body to another, and their distance, which is constant.
fn direction(model: &Model, kinematics: &Kinematics, ends: [Anchor; 2]) -> (Vector, Expr) {
    let pool = &model.pool;
    let own = |anchor: Anchor| {
        let points = &model.bodies[anchor.body.0].points;
        anchor.point.map_or(spatial::zero(pool), |point| points[point.0].position)
    };
    let across = spatial::sub(pool, &own(ends[1]), &own(ends[0]));
    let length = pool.simplify(pool.sqrt(spatial::dot(pool, &across, &across)));
    let [from, to] = ends.map(|anchor| kinematics.anchor(model, anchor));
    let way = spatial::sub(pool, &to, &from);
    (spatial::scale(pool, pool.div(pool.one(), length), &way), length)
}

/// The speed of bodies against each other that a wrench of one gives its power at.
pub(crate) fn speed_along(model: &Model, kinematics: &Kinematics, wrenches: &[Wrench]) -> Expr {
    let pool = &model.pool;
    let terms = powers(model, kinematics, wrenches).into_iter().zip(&kinematics.coordinates);
    let terms = terms.map(|(terms, coordinate)| {
        pool.mul(pool.simplify(pool.sum(terms)), pool.symbol_expr(coordinate.v))
    });
    pool.sum(terms.collect::<Vec<_>>())
}

/// True of the row of a place of this track.
pub(crate) fn is_on_track(
    model: &Model,
    source: Source,
    (contact, track): (ContactId, usize),
) -> bool {
    let Source::Stop(load) = source else { return false };
    let together = &model.contacts[contact.0].tracks[track];
    let touch = model.loads[load.0].kind.touch();
    touch.is_some_and(|(of, place)| of == contact && together.contains(&place))
}

/// The sum of the forces of the places of a track.
pub(crate) fn pressing(
    model: &Model,
    constraints: &[Constraint],
    track: (ContactId, usize),
) -> Expr {
    let rows = constraints.iter().filter(|row| is_on_track(model, row.source, track));
    model.pool.sum(rows.map(|row| model.pool.symbol_expr(row.lambda)).collect::<Vec<_>>())
}

/// A quantity of a contact as an expression of t, q, v and λ.
///
/// # Panics
/// Never: comparisons have two operands.
pub fn part(
    model: &Model,
    kinematics: &Kinematics,
    constraints: &[Constraint],
    contact: ContactId,
    part: ContactPart,
) -> Expr {
    let pool = &model.pool;
    let pair: &ContactPair = &model.contacts[contact.0];
    let is_spatial = pair.is_spatial(pool.zero());
    // Of the forces that press, or of friction against one motion.
    let lambdas = |wanted: Option<Opposed>| -> Expr {
        let of = |row: &&Constraint| {
            let (Source::Stop(LoadId(load)) | Source::Friction(LoadId(load))) = row.source else {
                return false;
            };
            let load = &model.loads[load];
            let opposed = load.kind.rub().map(|(_, _, opposed)| opposed);
            load.contact() == Some(contact) && opposed == wanted
        };
        let rows = constraints.iter().filter(of).map(|row| pool.symbol_expr(row.lambda));
        pool.sum(rows.collect::<Vec<_>>())
    };
    match part {
        ContactPart::Force => lambdas(None),
        ContactPart::Friction if is_spatial => {
            // The size of the sum over all places.
            let ways =
                |track: &Vec<usize>| Touching::of(model, kinematics, &pair.places[track[0]]).ways;
            let forces = constraints.iter().filter_map(|row| {
                let Source::Friction(LoadId(load)) = row.source else { return None };
                let (of, track, opposed) = model.loads[load].kind.rub()?;
                let way = ways(&pair.tracks[track])[usize::from(opposed == Opposed::Across)];
                (of == contact).then(|| spatial::scale(pool, pool.symbol_expr(row.lambda), &way))
            });
            let total = forces.fold(spatial::zero(pool), |sum, one| spatial::add(pool, &sum, &one));
            pool.sqrt(spatial::dot(pool, &total, &total))
        }
        ContactPart::Friction => lambdas(Some(Opposed::Slip)),
        ContactPart::Rolling => lambdas(Some(Opposed::Roll)),
        ContactPart::Gap => {
            let gap = |place: &Place| {
                let touching = Touching::of(model, kinematics, place);
                if pool.is_one(touching.reach) {
                    return touching.gap;
                }
                // Past its ends an edge is no nearer than its first corner.
                let ends = [place.mover.center, place.base.anchor()];
                let [a, b] = ends.map(|anchor| kinematics.anchor(model, anchor));
                let apart = spatial::sub(pool, &a, &b);
                let apart =
                    pool.sub(pool.sqrt(spatial::dot(pool, &apart, &apart)), place.mover.radius);
                let reaches = pool.call(Function::Ge, &[touching.reach, pool.zero()]);
                pool.select(reaches.expect("two arguments"), touching.gap, apart)
            };
            let least = |a, b| pool.call(Function::Min, &[a, b]).expect("two arguments");
            pair.places.iter().map(gap).reduce(least).unwrap_or(pool.zero())
        }
        ContactPart::Slip => {
            // Of each track the speed while it is pressed, and whether it is.
            let slip = |track: usize| {
                let pressed = pressing(model, constraints, (contact, track));
                let first = pair.tracks[track][0];
                let touching = Touching::of(model, kinematics, &pair.places[first]);
                let along = |way| speed_along(model, kinematics, &touching.rubbing(pool, way));
                let speed = if is_spatial {
                    pool.sqrt(pool.add(pool.powi(along(0), 2), pool.powi(along(1), 2)))
                } else {
                    along(0)
                };
                let is_pressed = pool.call(Function::Gt, &[pressed, pool.zero()]);
                let is_pressed = is_pressed.expect("two arguments");
                let while_pressed = |value: Expr| pool.select(is_pressed, value, pool.zero());
                (while_pressed(speed), while_pressed(pool.one()))
            };
            let (speeds, pressed): (Vec<_>, Vec<_>) = (0..pair.tracks.len()).map(slip).unzip();
            let total = pool.sum(speeds);
            if pressed.len() < 2 {
                return total;
            }
            // The mean over those that are.
            pool.div(total, pool.max(pool.one(), pool.sum(pressed)))
        }
    }
}
