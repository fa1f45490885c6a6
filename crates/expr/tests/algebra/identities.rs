//! The trigonometric folding suite: every item keeps its value, and folds to its ideal cost.

use crate::common::cost;
use bksim_expr::{Pool, SymbolId};
use serde_json::Value;

#[test]
fn suite_folds_to_the_ideal_cost() {
    let suite: Value =
        serde_json::from_str(include_str!("../data/identities.json")).expect("valid JSON");
    let mut report = Vec::new();
    let (mut n_folded, mut n_items) = (0, 0);
    for item in suite["items"].as_array().expect("a list") {
        let pool = Pool::new();
        let text = |key: &str| item[key].as_str().expect("text");
        let input = pool.parse(text("input")).expect("valid expression");
        let simple = pool.simplify(input);
        let sample = |symbol: SymbolId| item["sample"][pool.symbol_name(symbol)].as_f64();
        let value = pool.evaluate(simple, &sample).expect("all symbols given");
        let expected = item["value"].as_f64().expect("a number");
        let (id, found) = (text("id"), cost(&pool, simple));
        let difference = (value - expected).abs();
        assert!(difference <= 1e-12 * expected.abs().max(1.0), "{id}: {value} is not {expected}");
        let certificate = pool.certificate(input, simple);
        assert!(certificate.is_equal(), "{id}: {certificate:?}");
        n_items += 1;
        let ideal = item["cost_ideal"].as_u64().expect("a number");
        if found <= ideal {
            n_folded += 1;
        } else {
            let simple = pool.to_text(simple);
            report.push(format!("{id}: {found} > {ideal}: {simple}, ideal {}", text("ideal")));
        }
    }
    assert!(n_folded >= n_items, "{n_folded} of {n_items} folded: {report:#?}");
}
