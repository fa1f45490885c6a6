//! `bksim cad from-toml`: a drawing of a model that has none.

use bksim::cad::write::from_model::{ModelSource, Unwritten, from_model};
use bksim::sim::pose::{Pose, Poses};

use super::written;
use crate::args::changes::Changes;
use crate::args::draw::FromToml;
use crate::args::{DrawingArgs, ModelArgs};
use crate::exit::{Failure, Status};
use crate::origin::label_of;
use crate::render;
use crate::source::{derive, load};

pub(super) fn run(args: &FromToml, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    written::check(&args.written, &[&args.model])?;
    let drawing = DrawingArgs::default();
    let model = ModelArgs { model: args.model.clone(), set: Changes(args.set.clone()), drawing };
    let loaded = load(&model, nesting)?;
    let source = loaded.source;
    written::refuse_inputs(&args.written.output, &source.files())?;
    let mechanism = derive(&source, loaded.model)?;
    let start = mechanism.start().map_err(|rejected| source.rejected(rejected.0))?;
    let path = &args.written.output;
    let poses = Poses::compile(&mechanism.model, &mechanism.system)
        .map_err(|e| Failure::writing(path, &e))?
        .at(&mechanism.parameters, [(&start.q[..], &start.v[..])])
        .remove(0);
    let poses: Vec<_> = poses.iter().map(Pose::in_plane).collect();
    let drawn = ModelSource {
        text: &source.text,
        model: &mechanism.model,
        poses: &poses,
        release: args.style.dxf_version,
        unit: &args.style.units,
    };
    let bytes = from_model(&drawn).map_err(|unwritten| match unwritten {
        Unwritten::Model(fault) => source.rejected(vec![*fault]).into(),
        Unwritten::Write(error) => Failure::writing(path, &error),
    })?;
    if !as_json {
        render::print_all(&source, &loaded.warnings);
    }
    let diagnostics = render::json_all(&source, &loaded.warnings);
    let label = label_of(&source.path);
    let destination = (&args.written, label.as_str());
    written::write("cad from-toml", destination, bytes, &diagnostics, as_json)
}
