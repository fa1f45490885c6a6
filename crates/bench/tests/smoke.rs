//! Every suite runs by itself: no Python, no compiler, small sizes.

use std::process::Command;

use serde_json::Value;

#[test]
fn all_suites_run_without_peers() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::temp_dir().join(format!("bksim-bench-smoke-{}.json", std::process::id()));
    let output = Command::new(env!("CARGO_BIN_EXE_bksim-bench"))
        .args(["algebra", "--quick", "--without-peers", "--json"])
        .arg(&path)
        .output()?;
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let document: Value = serde_json::from_str(&std::fs::read_to_string(&path)?)?;
    std::fs::remove_file(&path)?;

    let suites = document["suites"].as_array().ok_or("a list of suites")?;
    let numbers = |name: &str| suites.iter().find(|s| s["suite"] == name).map(|s| &s["numbers"]);
    let is_positive = |value: &Value| value.as_f64().is_some_and(|number| number > 0.0);
    for (suite, path) in [
        ("folding", "/all/median_s"),
        ("counts", "/slider-crank/pin of the slider cut/printed"),
        ("counts", "/two-link chain/absolute angles/shared"),
        ("derivation", "/N=2/ours_s"),
        ("gradient", "/no two sines equal/ours_s"),
        ("evaluation", "/slider_crank/times/interpreter/min_s"),
        ("evaluation", "/five_link/times/JIT/min_s"),
        ("evaluation", "/andrews/times/batch of 1000/min_s"),
    ] {
        let found = numbers(suite).and_then(|numbers| numbers.pointer(path));
        assert!(found.is_some_and(is_positive), "{suite}{path}: {found:?}");
    }
    // The numbers of outputs are those of the C sources.
    for (name, expected) in [("slider_crank", 27), ("five_link", 53), ("andrews", 67)] {
        let found = numbers("evaluation").map(|numbers| &numbers[name]["n_outputs"]);
        assert_eq!(found, Some(&Value::from(expected)), "{name}");
    }
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("peers are switched off"), "{text}");
    Ok(())
}
