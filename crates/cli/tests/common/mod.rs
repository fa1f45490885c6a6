//! Running the command in a directory of its own; for the tests of `bksim-studio`, too.
//!
//! Each test binary uses a part of it.
#![allow(dead_code, reason = "each test binary uses a part of this module")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::{env, fs, process};

/// The crate's directory.
pub(crate) const CRATE: &str = env!("CARGO_MANIFEST_DIR");

/// The program under test: that of the package which the test belongs to.
pub(crate) const PROGRAM: &str =
    match (option_env!("CARGO_BIN_EXE_bksim"), option_env!("CARGO_BIN_EXE_bksim-studio")) {
        (Some(program), _) | (None, Some(program)) => program,
        (None, None) => panic!("the package has a program"),
    };

/// A directory that goes with the test.
pub(crate) struct Scratch(PathBuf);

impl Scratch {
    pub(crate) fn new() -> Self {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let n = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = env::temp_dir().join(format!("bksim-test-{}-{n}", process::id()));
        fs::create_dir_all(&path).expect("a directory for the test");
        Self(path)
    }

    pub(crate) fn path(&self) -> &Path {
        &self.0
    }

    pub(crate) fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.0.join(name), bytes).expect("a file of the test");
    }

    /// The command, in this directory, without colours.
    pub(crate) fn bksim(&self) -> Command {
        let mut command = Command::new(PROGRAM);
        command.current_dir(&self.0).env("NO_COLOR", "1").env("LC_ALL", "C");
        // Without it, drivers of graphics cards complain on stderr.
        command.env("XDG_RUNTIME_DIR", &self.0);
        command
    }

    /// Runs it with arguments separated by blanks.
    pub(crate) fn run(&self, arguments: &str) -> Output {
        let arguments = arguments.split_whitespace();
        self.bksim().args(arguments).output().expect("bksim starts")
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// An MCAP file of some other program, with one topic of two messages.
pub(crate) fn other_mcap() -> Vec<u8> {
    let options = mcap::WriteOptions::new().profile("ros2").library("some writer");
    let mut writer = options.create(std::io::Cursor::new(Vec::new())).expect("a writer");
    let schema = writer.add_schema("demo.Chatter", "jsonschema", b"{}").expect("a schema");
    let channel =
        writer.add_channel(schema, "/chatter", "json", &std::collections::BTreeMap::new());
    let channel_id = channel.expect("a channel");
    for sequence in 0..2 {
        let time = u64::from(sequence);
        let header = mcap::records::MessageHeader {
            channel_id,
            sequence,
            log_time: time,
            publish_time: time,
        };
        writer.write_to_known_channel(&header, b"{}").expect("a message");
    }
    writer.finish().expect("an end");
    writer.into_inner().into_inner()
}
