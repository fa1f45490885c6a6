//! Every suite runs without Python and a compiler, at small sizes.

use std::process::Command;

use serde_json::Value;

/// Runs a subcommand in its quick form; returns its suites as JSON, and its output.
fn quick(subcommand: &str) -> Result<(Vec<Value>, String), Box<dyn std::error::Error>> {
    let name = format!("bksim-bench-smoke-{subcommand}-{}.json", std::process::id());
    let path = std::env::temp_dir().join(name);
    let output = Command::new(env!("CARGO_BIN_EXE_bksim-bench"))
        .args([subcommand, "--quick", "--without-peers", "--json"])
        .arg(&path)
        .output()?;
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let document: Value = serde_json::from_str(&std::fs::read_to_string(&path)?)?;
    std::fs::remove_file(&path)?;
    let suites = document["suites"].as_array().ok_or("a list of suites")?;
    Ok((suites.clone(), String::from_utf8_lossy(&output.stdout).into_owned()))
}

/// A number of a suite.
fn number(suites: &[Value], suite: &str, path: &str) -> f64 {
    let numbers = suites.iter().find(|s| s["suite"] == suite).map(|s| &s["numbers"]);
    numbers.and_then(|numbers| numbers.pointer(path)).and_then(Value::as_f64).unwrap_or(f64::NAN)
}

#[test]
fn our_integrators_reach_the_digits_of_their_tolerance() -> Result<(), Box<dyn std::error::Error>> {
    let (suites, text) = quick("precision")?;
    for problem in ["pendulum", "caraxis", "andrews", "slidercrank"] {
        for method in ["bksim radau", "bksim auto"] {
            let run = |idx: usize, name: &str| {
                number(&suites, problem, &format!("/{method}/{idx}/{name}"))
            };
            // The last run has a tolerance of 1e-6.
            let digits = run(2, "digits/0");
            assert!(digits > 5.5 && run(2, "seconds") > 0.0, "{problem}, {method}: {digits}");
            assert!(
                digits > run(0, "digits/0") && run(2, "n_residual") > 0.0,
                "{problem}, {method}"
            );
        }
    }
    assert!(text.contains("DOP853: peers are switched off"), "{text}");
    Ok(())
}

#[test]
fn waits_have_times_and_goals() -> Result<(), Box<dyn std::error::Error>> {
    let (suites, text) = quick("waits")?;
    let took = number(&suites, "waits", "/derive six bodies with three damped springs/cpu_s");
    assert!(took > 0.0 && text.contains("derive the Stewart platform"), "{text}");
    Ok(())
}

#[test]
fn mechanisms_run_and_scale_without_peers() -> Result<(), Box<dyn std::error::Error>> {
    let (suites, _) = quick("mechanisms")?;
    let error = number(&suites, "mechanisms", "/bksim, model file to log/0/error");
    assert!(error < 1e-4, "error {error:e} rad at a tolerance of 1e-6");

    let (suites, _) = quick("scale")?;
    let memory = |name: &str| number(&suites, "scale", &format!("/{name}/peak_kib"));
    assert!(memory("Chain 20") > 0.0 && memory("FourBar 20") > 0.0, "{suites:?}");

    let (suites, text) = quick("balls")?;
    for row in ["3, bksim, relative", "3, bksim, absolute"] {
        let error = number(&suites, "balls", &format!("/{row}/runs/3/error"));
        assert!(error < 1e-6, "{row}: {error:e} m\n{text}");
    }
    for row in
        ["PUMA 560, bksim, relative", "six legs, bksim, relative", "six legs, bksim, absolute"]
    {
        let error = number(&suites, "machines", &format!("/{row}/runs/3/error"));
        assert!(error < 1e-8, "{row}: {error:e}\n{text}");
    }

    Ok(())
}

#[test]
fn a_sweep_and_single_runs_do_the_same_cases() -> Result<(), Box<dyn std::error::Error>> {
    let (suites, text) = quick("sweep")?;
    let over = number(&suites, "sweep", "/table_over_solve");
    assert!(over > 0.5 && number(&suites, "sweep", "/integration_s") > 0.0, "{text}");
    Ok(())
}
