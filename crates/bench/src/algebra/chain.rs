//! The chain of links in absolute angles, from its formulas instead of a model.
//!
//! ```text
//! x_b = Σ_{k<b} l_k cos θ_k + a_b cos θ_b,  y_b likewise with sines
//! T = ½ Σ_b (m_b (ẋ_b² + ẏ_b²) + I_b ω_b²),  V = g Σ_b m_b y_b
//! ```

use bksim_expr::{Expr, Pool, SymbolId};

use crate::error::BenchError;

/// Equations with their state and parameters.
pub(super) struct Equations<'p> {
    pub(super) pool: &'p Pool,
    pub(super) outputs: Vec<Expr>,
    pub(super) state: Vec<SymbolId>,
    pub(super) parameters: Vec<SymbolId>,
}

/// Symbols of one link.
struct Link {
    length: Expr,
    centre: Expr,
    mass: Expr,
    inertia: Expr,
    angle: SymbolId,
    rate: SymbolId,
}

/// Form of h.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Bias {
    /// With sines of the differences of angles.
    Folded,
    /// With sines and cosines of the angles.
    Unfolded,
}

/// Passes M (lower triangle), h and ∂V/∂θ of a chain of `n` links to `use_them`.
pub(super) fn with_equations<T>(
    n: usize,
    bias: Bias,
    use_them: impl FnOnce(&Equations<'_>) -> Result<T, BenchError>,
) -> Result<T, BenchError> {
    let pool = Pool::new();
    let links: Vec<Link> = (1..=n)
        .map(|i| {
            let symbol = |name: &str| pool.symbol(&format!("{name}{i}"));
            let id = |e: Expr| pool.symbol_id(e).ok_or(BenchError::Data("a symbol"));
            Ok(Link {
                length: symbol("l"),
                centre: symbol("a"),
                mass: symbol("m"),
                inertia: symbol("I"),
                angle: id(symbol("t"))?,
                rate: id(symbol("w"))?,
            })
        })
        .collect::<Result<_, BenchError>>()?;
    let gravity = pool.symbol("g");
    let state: Vec<SymbolId> = links.iter().flat_map(|link| [link.angle, link.rate]).collect();
    let outputs = outputs(&pool, &links, gravity, &state, bias);
    let parameters = links
        .iter()
        .flat_map(|link| [link.length, link.centre, link.mass, link.inertia])
        .chain([gravity])
        .filter_map(|e| pool.symbol_id(e))
        .collect();
    use_them(&Equations { pool: &pool, outputs, state, parameters })
}

/// M (lower triangle), h and ∂V/∂θ.
fn outputs(
    pool: &Pool,
    links: &[Link],
    gravity: Expr,
    state: &[SymbolId],
    form: Bias,
) -> Vec<Expr> {
    let n = links.len();
    let angles: Vec<SymbolId> = links.iter().map(|link| link.angle).collect();
    let rate = |i: usize| pool.symbol_expr(links[i].rate);

    // Positions of the centres of mass, and the potential.
    let position = |b: usize, function: &dyn Fn(Expr) -> Expr| {
        let along = |k: usize, reach: Expr| pool.mul(reach, function(pool.symbol_expr(angles[k])));
        let inner = (0..b).map(|k| along(k, links[k].length));
        pool.sum(inner.chain([along(b, links[b].centre)]).collect::<Vec<_>>())
    };
    let positions: Vec<[Expr; 2]> =
        (0..n).map(|b| [position(b, &|e| pool.cos(e)), position(b, &|e| pool.sin(e))]).collect();
    let weight = |b: usize| pool.product([gravity, links[b].mass, positions[b][1]]);
    let potential = pool.sum((0..n).map(weight).collect::<Vec<_>>());

    // M_ij = Σ_b m_b J_bi · J_bj + I_i δ_ij
    let entry = |i: usize, j: usize| {
        let body = |b: usize| {
            let [x, y] =
                positions[b].map(|c| pool.mul(pool.diff(c, angles[i]), pool.diff(c, angles[j])));
            pool.mul(links[b].mass, pool.add(x, y))
        };
        let own = if i == j { links[i].inertia } else { pool.zero() };
        pool.sum((i..n).map(body).chain([own]).collect::<Vec<_>>())
    };
    let lower: Vec<Expr> = (0..n).flat_map(|i| (0..=i).map(move |j| entry(i, j))).collect();
    let lower = pool.collect_all(&lower, state);
    let mass = |i: usize, j: usize| lower[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)];

    // h_i = d/dt ∂T/∂ω_i − ∂T/∂θ_i without accelerations
    let momenta: Vec<Expr> = (0..n)
        .map(|i| pool.sum((0..n).map(|j| pool.mul(mass(i, j), rate(j))).collect::<Vec<_>>()))
        .collect();
    let energy = (0..n).map(|i| pool.product([pool.rational(1, 2), momenta[i], rate(i)]));
    let energy = pool.sum(energy.collect::<Vec<_>>());
    let motion: Vec<(SymbolId, Expr)> = (0..n).map(|i| (angles[i], rate(i))).collect();
    let bias: Vec<Expr> = (0..n)
        .map(|i| pool.sub(pool.total_derivative(momenta[i], &motion), pool.diff(energy, angles[i])))
        .collect();

    // All outputs, with terms in the state collected.
    let mut outputs = lower;
    let bias = pool.collect_all(&bias, state);
    outputs.extend(bias.into_iter().map(|h| match form {
        Bias::Folded => h,
        Bias::Unfolded => pool.unfold_angles(h),
    }));
    outputs.extend(pool.collect_all(&pool.gradient(potential, &angles), state));
    outputs
}
