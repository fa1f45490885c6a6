//! Writes a platform in general position with its forty poses, from which those of all others are found.
//!
//! ```sh
//! cargo run --release -p bksim-analysis --example platform -- crates/analysis/src/platform/start.bin
//! ```

fn main() -> std::io::Result<()> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "start.bin".to_owned());
    let all = bksim_analysis::general_points(1);
    let bytes: Vec<u8> = all.iter().flat_map(|c| [c.re, c.im]).flat_map(f64::to_le_bytes).collect();
    std::fs::write(path, bytes)
}
