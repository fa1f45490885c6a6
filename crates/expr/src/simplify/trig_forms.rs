//! Forms of a trigonometric polynomial other than its Fourier form: halved angles and products,
//! where they are cheaper.

use super::best::Best;
use super::cost::{Cost, CostModel};
use super::factor::{Preference, factored};
use super::poly::Poly;
use super::rules::HALVINGS;
use super::trig::{doubled_angles, halve, products};

/// Terms up to which each halved angle is tried by its cost.
const MAX_TRIED_TERMS: usize = 48;
/// Doubled angles tried in one expression.
const MAX_TRIED_ANGLES: usize = 8;
/// Terms above which no products are sought.
const MAX_PAIRED_TERMS: usize = 160;

/// Considers the forms of a Fourier form with halved angles and with products; the Fourier form itself has been
/// considered.
pub(super) fn consider_trigonometric(model: &CostModel, fourier: &Poly, best: &mut Best) {
    let products = paired(model, fourier);
    if products != *fourier {
        best.consider_factored(model, &products);
    }
    if doubled_angles(model.pool, fourier).is_empty() {
        return;
    }
    if fourier.len() > MAX_TRIED_TERMS {
        let halved = halved_where_shorter(model, fourier);
        best.consider_factored(model, &halved);
        return;
    }
    let halved = halved_where_cheaper(model, fourier, best);
    best.consider_factored(model, &paired(model, &halved));
}

/// The polynomial with pairs of its terms as products.
fn paired(model: &CostModel, poly: &Poly) -> Poly {
    if model.meter.has_ended() || poly.len() > MAX_PAIRED_TERMS {
        return poly.clone();
    }
    model.meter.spend(poly.len() * poly.len());
    products(model.pool, poly)
}

/// Halves each doubled angle in the way that leaves the fewest terms, if fewer than before.
fn halved_where_shorter(model: &CostModel, fourier: &Poly) -> Poly {
    let mut poly = fourier.clone();
    for angle in doubled_angles(model.pool, fourier) {
        if model.meter.has_ended() {
            break;
        }
        model.meter.spend(HALVINGS.len() * poly.len());
        let options = HALVINGS.iter().map(|&halving| halve(model.pool, &poly, angle, halving));
        if let Some(shortest) = options.min_by_key(Vec::len)
            && shortest.len() < poly.len()
        {
            poly = shortest;
        }
    }
    poly
}

/// Halves each doubled angle in the cheapest way, if cheaper than before.
fn halved_where_cheaper(model: &CostModel, fourier: &Poly, best: &mut Best) -> Poly {
    let pool = model.pool;
    let mut poly = fourier.clone();
    let from_e = factored(pool, &poly, Preference::Frequent);
    let mut lowest = model.cost(from_e);
    for angle in doubled_angles(pool, fourier).into_iter().take(MAX_TRIED_ANGLES) {
        let from = poly.clone();
        for halving in HALVINGS {
            model.meter.spend(from.len());
            let option = halve(pool, &from, angle, halving);
            // Any form that is written out is cheaper than this.
            let mut own = Best { e: from_e, cost: Cost::MAX };
            own.consider_factored(model, &option);
            if own.cost < lowest {
                lowest = own.cost;
                poly = option;
            }
            best.take(own);
        }
    }
    poly
}
