//! `bksim cam`: the motion, pressure angle and curvature of a cam, and its profile as a drawing.

use std::path::{Path, PathBuf};

use bksim::analysis::{CamProfile, CamReport, CamRequest, Located, cam, quantity};
use bksim::cad::write::profile::{Outline, dxf, svg};
use bksim::model::FollowerKind;
use serde_json::{Value, json};

use super::answer::{AnswerFile, failed, lines, shown, table_json};
use crate::args::analysis::Cam as Args;
use crate::commands::analysis::answer::Asked;
use crate::exit::{Failure, Status};
use crate::output::{counted, number};
use crate::output_file::OutputFile;
use crate::source::load_geometry;
use crate::waiting::waiting;

const COMMAND: &str = "cam";

/// The kinds of file that an answer can be written as.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Kind {
    Csv,
    Dxf,
    Svg,
}

pub(crate) fn run(args: &Args, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let file = args.file.as_ref().map(|path| -> Result<(OutputFile, Kind), Failure> {
        let kind = kind_of(path)?;
        Ok((AnswerFile::plan(path, args.force, &[&args.model.model])?, kind))
    });
    let file = file.transpose()?;
    let loaded = load_geometry(&args.model, nesting)?;
    let about = |(file, kind)| (AnswerFile::about(&loaded, file, args.force), kind);
    let file = file.map(about);
    let (source, model) = (loaded.source, loaded.model);
    let failed = failed(&source);
    let cutter = args.cutter.as_ref().map(|text| quantity(text, "m")).transpose();
    let cutter = cutter.map_err(&failed)?;
    if cutter.is_some_and(|radius| radius <= 0.0) {
        return Err(Failure::usage(
            "the radius of a cutter is above 0",
            "write `--cutter \"5 mm\"`",
        ));
    }
    let request = CamRequest { curve: args.curve.clone(), n_rows: usize::from(args.rows), cutter };
    let report = waiting("examining the cam", || cam(&model, &request)).map_err(&failed)?;
    let content = file.map(|(file, kind)| content(&report, file, kind)).transpose()?;
    let warnings: Vec<_> = loaded.warnings.into_iter().chain(report.warnings.clone()).collect();
    let answer = (COMMAND, told_json(&report), told(&model.name, &report));
    Asked::told(&source, &warnings, content, answer, as_json)
}

fn kind_of(path: &Path) -> Result<Kind, Failure> {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    match ending.as_str() {
        "csv" => Ok(Kind::Csv),
        "dxf" => Ok(Kind::Dxf),
        "svg" => Ok(Kind::Svg),
        _ => {
            let message = format!("`{}` is neither CSV, DXF nor SVG", path.display());
            Err(Failure::usage(message, "end its name with .csv, .dxf or .svg"))
        }
    }
}

/// The file, what is written into it, and that in a few words.
fn content(
    report: &CamReport,
    file: AnswerFile,
    kind: Kind,
) -> Result<(AnswerFile, Vec<u8>, String), Failure> {
    if kind == Kind::Csv {
        let rows = counted(report.table.rows.len(), "row", "rows");
        let bytes = file.csv(&report.table);
        return Ok((file, bytes, rows));
    }
    let Some(profile) = &report.profile else {
        let help = "write `-o FILE.csv` for its table, or name a curve of type `cam`";
        return Err(Failure::usage(format!("the law `{}` has no profile", report.name), help));
    };
    let outline = |line: &bksim::analysis::CamLine| Outline {
        layer: line.name.to_uppercase(),
        corners: line.points.clone(),
        is_closed: line.is_closed,
    };
    let outlines: Vec<Outline> = profile.lines.iter().map(outline).collect();
    let circles = [profile.base_circle];
    let bytes = match kind {
        Kind::Svg => svg(&outlines, &circles).into_bytes(),
        _ => dxf(&outlines, &circles)
            .map_err(|error| Failure::writing(PathBuf::from(file.path()).as_path(), &error))?,
    };
    let names: Vec<&str> = profile.lines.iter().map(|line| line.name).collect();
    Ok((file, bytes, format!("{} in mm", names.join(", "))))
}

fn kind_word(kind: FollowerKind) -> &'static str {
    match kind {
        FollowerKind::Knife => "knife",
        FollowerKind::Roller => "roller",
        FollowerKind::Flat => "flat",
    }
}

fn told(name: &str, report: &CamReport) -> String {
    let mut text = match &report.profile {
        Some(profile) => format!(
            "{name}: profile {} of a {} follower by the law {}",
            report.name,
            kind_word(profile.kind),
            report.law
        ),
        None => format!("{name}: law {}", report.name),
    };
    let unit = if report.is_angle { "rad" } else { "m" };
    let row = |peaks: &bksim::analysis::Peaks| {
        let motion = [
            peaks.law.to_owned(),
            shown(peaks.from, "rad"),
            shown(peaks.over, "rad"),
            shown(peaks.rise, unit),
        ];
        motion.into_iter().chain(peaks.factors.map(number)).collect()
    };
    let heads = ["law", "from", "over", "rise", "velocity", "acceleration", "jerk"];
    let rows = report.peaks.iter().map(row).collect();
    text.extend([format!("\n\npeak factors\n{}", lines(&heads, rows))]);
    if let Some(profile) = &report.profile {
        text.extend(["\n\n".to_owned(), told_profile(profile)]);
    }
    text
}

fn told_profile(profile: &CamProfile) -> String {
    let mut rows: Vec<[String; 3]> = Vec::new();
    let mut row = |what: &str, value: String, place: Option<f64>| {
        let place = place.map_or(String::new(), |at| format!("at {}", shown(at, "rad")));
        rows.push([what.to_owned(), value, place]);
    };
    let length = |value: f64| shown(value, "m");
    row("base circle", length(profile.base_circle), None);
    if let Some(Located { value, at }) = profile.smallest_base_circle {
        row("smallest without undercut", length(value), Some(at));
    }
    if let Some(radius) = profile.roller {
        row("roller", length(radius), None);
    }
    if let Some([rise, fall]) = &profile.steepest {
        row("pressure angle, rise", shown(rise.value, "rad"), Some(rise.at));
        row("pressure angle, return", shown(fall.value, "rad"), Some(fall.at));
    }
    if let Some([left, right]) = profile.face {
        row("face", format!("{} to {}", length(left), length(right)), None);
    }
    if let Some(least) = &profile.least_radius {
        row("sharpest radius", length(least.value), Some(least.at));
    }
    for [from, to] in &profile.undercuts {
        row("undercut", format!("{} to {}", shown(*from, "rad"), shown(*to, "rad")), None);
    }
    if !profile.is_closed {
        row("ends", "the profile does not end where it begins".to_owned(), None);
    }
    // What has no place may be longer.
    let placed = rows.iter().filter(|row| !row[2].is_empty());
    let second = placed.map(|row| row[1].chars().count()).max().unwrap_or(0);
    let first = rows.iter().map(|row| row[0].chars().count()).max().unwrap_or(0);
    let line = |[what, value, place]: &[String; 3]| {
        format!("  {what:first$}  {value:second$}  {place}").trim_end().to_owned()
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}

fn told_json(report: &CamReport) -> Value {
    let located = |located: &Located| json!({ "value": located.value, "at": located.at });
    let peaks = report.peaks.iter().map(|peaks| {
        json!({
            "law": peaks.law,
            "from": peaks.from,
            "over": peaks.over,
            "rise": peaks.rise,
            "largest": peaks.largest,
            "factors": peaks.factors,
        })
    });
    let profile = report.profile.as_ref().map(|profile| {
        json!({
            "follower": kind_word(profile.kind),
            "base_circle": profile.base_circle,
            "roller": profile.roller,
            "smallest_base_circle": profile.smallest_base_circle.as_ref().map(located),
            "least_radius": profile.least_radius.as_ref().map(located),
            "pressure_angles": profile.steepest.as_ref().map(|both| both.each_ref().map(located)),
            "face": profile.face,
            "undercuts": profile.undercuts,
            "closed": profile.is_closed,
        })
    });
    json!({
        "name": report.name,
        "law": report.law,
        "peaks": peaks.collect::<Vec<_>>(),
        "profile": profile,
        "table": table_json(&report.table),
    })
}
