//! Small pictures on a sheet: `bksim kinematics --assemblies -o FILE` and `bksim doctor -o FILE`.

use std::path::Path;

use bksim::analysis::Panels;
use bksim::panels::Sheet;
use bksim_cli::exit::Failure;
use bksim_plot::{Format, Size, convert};
use bksim_scene::{Theme, titled_svg};

/// The function that draws panels as the contents of a file with this ending.
pub(crate) fn drawing(path: &Path) -> impl Fn(&str, &Panels) -> Result<Vec<u8>, Failure> + '_ {
    let format = Format::of(path);
    move |name, panels| {
        let sheet = Sheet::of(panels, Theme::LIGHT);
        if format == Format::Svg {
            return Ok(sheet.moving(name).into_bytes());
        }
        let still = sheet.still();
        let [width, height] = still.size.map(f64::from);
        let drawn = convert(&titled_svg(&still, name), format, Size { width, height }, name);
        drawn.map_err(|error| Failure::file(path, format!("cannot be drawn: {error}"), None))
    }
}
