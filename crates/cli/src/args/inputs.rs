//! The files that a command reads its model from.

use std::path::PathBuf;

use super::Command;

impl Command {
    /// The files whose changes concern the command: models, and logs that are read in place of one.
    pub(crate) fn inputs(&self) -> Vec<PathBuf> {
        let model = match self {
            Self::Check(args) | Self::Assemble(args) => &args.model.model,
            Self::Expand(args) => &args.model,
            Self::Equations(args) => &args.model.model,
            Self::Kinematics(args) => &args.model.model,
            Self::Curves(args) => &args.model.model,
            Self::Polygons(args) => &args.model.model,
            Self::Static(args) => &args.model.model,
            Self::Linearize(args) => &args.model.model,
            Self::Modes(args) => &args.model.model,
            Self::Bode(args) => &args.model.model,
            Self::Verify(args) => &args.model.model,
            Self::Gradient(args) => &args.model.model,
            Self::Doctor(args) => &args.model.model,
            Self::Inverse(args) => &args.model.model,
            Self::Cam(args) => &args.model.model,
            Self::Code(args) => &args.model.model,
            Self::Fmu(args) => &args.model.model,
            Self::Solve(args) => &args.model.model,
            Self::Sweep(args) => &args.model,
            Self::Optimize(args) => &args.model.model,
            Self::Fit(args) => return [args.data.clone(), vec![args.model.model.clone()]].concat(),
            Self::Tolerance(args) => &args.model.model,
            Self::Synthesize(args) => &args.task,
            Self::Render(args) => &args.input,
            Self::Export(args) => &args.run.input,
            Self::Info(args) => &args.run.input,
            Self::Report(args) => &args.run.input,
            Self::Sheet(args) => &args.run.input,
            Self::Page(args) => &args.run.input,
            Self::Plot(args) => return args.files(),
            Self::New(_)
            | Self::Parts(_)
            | Self::View(_)
            | Self::Edit(_)
            | Self::Expr(_)
            | Self::Cad(_)
            | Self::Import(_)
            | Self::Explain(_)
            | Self::Lsp
            | Self::Schema(_)
            | Self::Completions(_)
            | Self::Man(_) => return Vec::new(),
        };
        vec![model.clone()]
    }
}
