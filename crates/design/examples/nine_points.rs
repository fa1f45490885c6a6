//! Writes the solutions of Alt's problem for displacements in general position, from which all others are found.
//!
//! ```sh
//! cargo run --release -p bksim-design --example nine_points -- crates/design/src/synthesis/nine_points.bin
//! ```

fn main() -> std::io::Result<()> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "nine_points.bin".to_owned());
    let reached = |n: usize| eprintln!("{n} triples");
    let all = bksim_design::general_solutions(1, &reached);
    let bytes: Vec<u8> = all.iter().flat_map(|c| [c.re, c.im]).flat_map(f64::to_le_bytes).collect();
    std::fs::write(path, bytes)
}
