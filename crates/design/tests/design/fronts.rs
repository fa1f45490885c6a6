//! Fronts of two objectives, and their searches that are stopped.

use std::sync::atomic::{AtomicUsize, Ordering};

use bksim_design::{DesignError, OptimizeWish, Optimized, Source, Watch, optimize};

use crate::optima::{arm, is_close, solved};

#[test]
fn a_front_trades_one_objective_for_another() {
    // Least of k² and of (k − 1000)² in N/m: points on the line between, at a share s of the way b = (1 − s)² · 10⁶
    // with bounds b evenly apart.
    let question = r#"minimize = ["(k/(1 N/m))^2", "(k/(1 N/m) - 1000)^2"]
vary = { k = ["0.001 N/m", "2000 N/m"] }
points = 5"#;
    let found = solved(&arm(question));
    let front = found.front.as_ref().expect("a front");
    assert_eq!(front.points.len(), 5, "{front:?}");
    for (k, point) in front.points.iter().enumerate() {
        let bound = 1e6 * (1.0 - 0.25 * k as f64);
        is_close(point.values[1].max(1.0), bound.max(1.0), 1e-5);
        assert!((point.quantities["k"] - (1000.0 - bound.sqrt())).abs() < 0.01, "{point:?}");
    }
    // Nearest to both least values: x² = a, (1000 − x)² = b, least a² + b² at x = 500; of these points the fourth.
    assert_eq!(front.compromise, 3);
    assert!((found.after - front.points[3].values[0]).abs() < 1e-6);
}

#[test]
fn a_front_that_is_stopped_anywhere_goes_on_to_the_same_bytes() {
    let question = r#"minimize = ["(k/(1 N/m))^2", "(k/(1 N/m) - 1000)^2"]
vary = { k = ["0.001 N/m", "2000 N/m"] }
points = 5"#;
    let text = arm(question);
    let source = Source { text: text.clone(), name: "model".to_owned(), ..Source::default() };
    let wish = OptimizeWish::of_model(&text).expect("a question");
    let json = |found: &Optimized| serde_json::to_string(found).expect("JSON");
    let n_asked = AtomicUsize::new(0);
    let counting = Watch {
        stop: &|| {
            n_asked.fetch_add(1, Ordering::Relaxed);
            false
        },
        ..Watch::default()
    };
    let whole = optimize(&source, &wish, counting).expect("a front");
    let n_asked = n_asked.into_inner();
    assert!(whole.unfinished.is_none());
    let mut n_stopped = 0;
    for at in (0..n_asked).step_by(1 + n_asked / 25) {
        let asked = AtomicUsize::new(0);
        let stop = || asked.fetch_add(1, Ordering::Relaxed) >= at;
        let watch = Watch { stop: &stop, ..Watch::default() };
        let stopped = match optimize(&source, &wish, watch) {
            Ok(stopped) => stopped,
            Err(DesignError::Stopped) => continue,
            Err(error) => panic!("{error}"),
        };
        let read: Optimized = serde_json::from_str(&json(&stopped)).expect("an answer");
        let Some(unfinished) = read.unfinished else { continue };
        n_stopped += 1;
        let mut on = OptimizeWish { resume: Some(unfinished), ..wish.clone() };
        let resumed = optimize(&source, &on, Watch::default()).expect("a front");
        assert_eq!(json(&resumed), json(&whole), "stopped at {at}");
        assert_eq!(resumed.model, whole.model);
        // Another question is refused.
        on.points = Some(7);
        let error = optimize(&source, &on, Watch::default()).expect_err("another question");
        assert!(error.to_string().contains("another question"), "{error}");
    }
    assert!(n_stopped > 5, "{n_stopped} of {n_asked}");
}
