//! The arguments of `bksim cad body|joint|load|drive`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::DrawingArgs;

#[derive(Subcommand, Debug)]
pub(crate) enum Change {
    /// Attach something new to entities of a drawing.
    Add(Statement),
    /// Change keys of what is attached, wherever it stands.
    Set(Statement),
    /// Remove what is attached: its data, or its block.
    Remove(Named),
}

#[derive(Args, Debug)]
pub(crate) struct Named {
    /// The drawing (DXF, DWG).
    pub(crate) drawing: PathBuf,
    /// Name of the body, joint, load or drive.
    pub(crate) name: String,
    /// Handle of an entity, as the command LIST of CAD programs shows it; may be repeated.
    #[arg(long = "entity", value_name = "HANDLE", value_parser = handle)]
    pub(crate) entities: Vec<u64>,
    /// Kind of the element: `prismatic`, `spring`, …; needed for new loads, a revolute for new joints.
    #[arg(long, value_name = "KIND")]
    pub(crate) kind: Option<String>,
    /// The drawing that is written, in place of the one that was read.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Overwrite an existing file.
    #[arg(long)]
    pub(crate) force: bool,
    #[command(flatten)]
    pub(crate) reading: DrawingArgs,
}

#[derive(Args, Debug)]
pub(crate) struct Statement {
    #[command(flatten)]
    pub(crate) named: Named,
    /// Keys as in a model file: `mass="1.2 kg"`; `KEY=` alone removes a key.
    #[arg(value_name = "KEY=VALUE", value_parser = key_and_value)]
    pub(crate) values: Vec<(String, String)>,
    /// Point of the statement, drawing units.
    #[arg(long, value_name = "X,Y", value_parser = point, allow_hyphen_values = true)]
    pub(crate) at: Option<[f64; 2]>,
    /// Second point of the statement: the other end of a spring.
    #[arg(long, value_name = "X,Y", value_parser = point, allow_hyphen_values = true)]
    pub(crate) to: Option<[f64; 2]>,
    /// Direction of the statement: an angle in degrees, or a vector.
    #[arg(long, value_name = "DEG|X,Y", value_parser = direction, allow_hyphen_values = true)]
    pub(crate) axis: Option<[f64; 2]>,
}

fn handle(text: &str) -> Result<u64, String> {
    u64::from_str_radix(text, 16).map_err(|_| "expected hexadecimal digits, such as 2F".to_owned())
}

fn key_and_value(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.trim().is_empty() => {
            Ok((key.trim().to_owned(), value.trim().to_owned()))
        }
        _ => Err("expected KEY=VALUE, such as mass=\"1.2 kg\"".to_owned()),
    }
}

fn number(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|number: &f64| number.is_finite())
}

fn point(text: &str) -> Result<[f64; 2], String> {
    let pair = text.split_once(',').and_then(|(x, y)| Some([number(x)?, number(y)?]));
    pair.ok_or_else(|| "expected two numbers, such as 120,-35.5".to_owned())
}

fn direction(text: &str) -> Result<[f64; 2], String> {
    if let Some(angle_deg) = number(text) {
        return Ok(unit_vector(angle_deg));
    }
    let vector = point(text).map_err(|_| "expected degrees or two numbers, such as 30 or 0,1")?;
    if vector == [0.0, 0.0] { Err("a direction is not 0,0".to_owned()) } else { Ok(vector) }
}

/// Quarter turns are exact, so that an axis of 90° is the y axis to the last bit.
fn unit_vector(angle_deg: f64) -> [f64; 2] {
    let turned = angle_deg.rem_euclid(360.0);
    match [0.0, 90.0, 180.0, 270.0].iter().position(|quarter| *quarter == turned) {
        Some(0) => [1.0, 0.0],
        Some(1) => [0.0, 1.0],
        Some(2) => [-1.0, 0.0],
        Some(_) => [0.0, -1.0],
        None => {
            let (sin, cos) = turned.to_radians().sin_cos();
            [cos, sin]
        }
    }
}
