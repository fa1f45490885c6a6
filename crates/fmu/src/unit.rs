//! [`Unit`]: a functional mock-up unit as files.

use std::fmt::Write;

use sha2::{Digest, Sha256};

use crate::core::Core;
use crate::description::{Version, description};
use crate::source::{literal, quoted};
use crate::variable::Variable;

/// Parts of the source that only units have: the states of model exchange, then what both versions share.
const PARTS: [&str; 2] = [include_str!("../c/choice.c"), include_str!("../c/unit.c")];

/// A kind of machine that units have programs for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Platform {
    /// Folder of its programs in units of FMI 3.0.
    pub name: &'static str,
    /// Name of the platform in units of FMI 2.0.
    pub old_name: &'static str,
    /// Ending of its libraries.
    pub ending: &'static str,
}

impl Platform {
    /// All that have a name in either version.
    pub const ALL: [Self; 4] = [
        Self { name: "x86_64-linux", old_name: "linux64", ending: "so" },
        Self { name: "aarch64-linux", old_name: "aarch64-linux", ending: "so" },
        Self { name: "x86_64-darwin", old_name: "darwin64", ending: "dylib" },
        Self { name: "aarch64-darwin", old_name: "aarch64-darwin", ending: "dylib" },
    ];

    /// The machine of this architecture and system, in Rust's words.
    pub fn of(architecture: &str, system: &str) -> Option<Self> {
        let system = if system == "macos" { "darwin" } else { system };
        let name = format!("{architecture}-{system}");
        Self::ALL.into_iter().find(|platform| platform.name == name)
    }
}

/// A functional mock-up unit.
pub struct Unit {
    /// Mechanism of the unit.
    pub core: Core,
    /// The version of the standard.
    pub version: Version,
    /// The whole source, one C99 file.
    pub source: String,
    /// The text by which importers know that description and program belong together.
    pub token: String,
}

impl Unit {
    /// The unit of a mechanism.
    pub fn new(mut core: Core, version: Version) -> Self {
        let step = "step of co-simulation; 0 lets it follow from the tolerance";
        core.values.push(Variable::new("solver.step", "s", step));
        let body = body(&core, version);
        let hash = Sha256::digest(body.as_bytes());
        let digits: String = hash[..16].iter().fold(String::new(), |mut digits, byte| {
            let _ = write!(digits, "{byte:02x}");
            digits
        });
        let parts = [0..8, 8..12, 12..16, 16..20, 20..32].map(|range| &digits[range]);
        let token = format!("{{{}}}", parts.join("-"));
        let source = format!("#define BK_TOKEN {}\n{body}", quoted(&token));
        Self { core, version, source, token }
    }

    /// Path of the source within the unit.
    pub fn source_path(&self) -> String {
        format!("sources/{}.c", self.core.identifier)
    }

    /// All files with their paths, with a program that the source was compiled to.
    pub fn files(&self, program: Option<(Platform, Vec<u8>)>) -> Vec<(String, Vec<u8>)> {
        let id = &self.core.identifier;
        let mut files = vec![(
            "modelDescription.xml".to_owned(),
            description(&self.core, self.version, &self.token).into_bytes(),
        )];
        files.push((self.source_path(), self.source.clone().into_bytes()));
        if self.version == Version::Three {
            let build = format!(
                "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiBuildDescription fmiVersion=\"3.0\">\n  \
                 <BuildConfiguration modelIdentifier=\"{id}\">\n    \
                 <SourceFileSet language=\"C99\">\n      <SourceFile name=\"{id}.c\"/>\n    </SourceFileSet>\n  \
                 </BuildConfiguration>\n</fmiBuildDescription>\n"
            );
            files.push(("sources/buildDescription.xml".to_owned(), build.into_bytes()));
        }
        if let Some((platform, bytes)) = program {
            let folder = match self.version {
                Version::Two => platform.old_name,
                Version::Three => platform.name,
            };
            files.push((format!("binaries/{folder}/{id}.{}", platform.ending), bytes));
        }
        files
    }
}

/// The source without its token.
fn body(core: &Core, version: Version) -> String {
    let mut out = format!(
        "#define BK_IDENTIFIER {}\n#define BK(name) unit_##name\n#define BK_API static\n\n{}\n\
         typedef unit_state bk_state;\ntypedef unit_model bk_model;\n\n",
        quoted(&core.identifier),
        core.structs("unit")
    );
    out.push_str(&core.shared_source(&(core.functions.clone() + &core.unit_functions)));
    let sizes: Vec<String> = core.tables.sizes.iter().map(|&size| literal(size)).collect();
    let _ =
        writeln!(out, "static const double bk_size[{}] = {{{}}};", sizes.len(), sizes.join(", "));
    let places: Vec<String> = core.calculated.iter().map(|(place, _)| place.to_string()).collect();
    let listed = if places.is_empty() { "0".to_owned() } else { places.join(", ") };
    let _ = writeln!(
        out,
        "#define BK_NYO {}\nstatic const int bk_calculated[{}] = {{{listed}}};\n\n\
         static double bk_fixed_step(const bk_model *m) {{\n    return m->s.value[BK_NV - 1];\n}}\n",
        core.n_outputs,
        places.len().max(1)
    );
    out.push_str(&Core::shared_parts());
    for part in PARTS {
        out.push('\n');
        out.push_str(part);
    }
    out.push('\n');
    out.push_str(match version {
        Version::Two => include_str!("../c/fmi2.c"),
        Version::Three => include_str!("../c/fmi3.c"),
    });
    out
}
