//! [`OutputFile`]: a file that a command writes, without harm to what is there already.
//!
//! Nothing is written over by chance: a file that exists takes `--force`, unless bksim made it from the same model,
//! and then keeps its content until the new one is whole; an input is never written over, by whichever of its names. Two commands that write
//! one file at the same time are told apart, as files are created exclusively.

use std::fs::{self, File};
use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use tempfile::{Builder, NamedTempFile};

use crate::exit::Failure;
use crate::leftover::{PART, lock, name_all, prefix_of};

/// A file to be written.
#[derive(Debug)]
pub struct OutputFile {
    path: PathBuf,
    found: Found,
}

/// State of the path when the command began.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Found {
    Nothing,
    /// A file, which may be replaced.
    File,
    /// A device or a pipe, which is written to as it is.
    Device,
}

/// A file that is being written.
#[derive(Debug)]
pub struct Written {
    path: PathBuf,
    place: Place,
    /// Bytes that have been written.
    n_bytes: Arc<AtomicU64>,
}

#[derive(Debug)]
enum Place {
    /// Under its own name.
    Own(File),
    /// Next to it, under another name, with what was found under its own.
    Temporary(NamedTempFile, Found),
}

impl OutputFile {
    /// Refuses a path that exists, unless it `may_be_replaced`, that is an input, of this kind, or that has no directory;
    /// `undone` tells what has not been done: "nothing was solved".
    ///
    /// # Errors
    /// The first of these faults.
    pub fn plan(
        path: &Path,
        (kind, inputs): (&str, &[&Path]),
        may_be_replaced: bool,
        undone: &str,
    ) -> Result<Self, Failure> {
        let directory = directory(path);
        if !directory.is_dir() {
            let there = directory.display();
            let what = format!("cannot be written: there is no directory `{there}`; {undone}");
            let help = format!("make it with `mkdir -p {there}`");
            return Err(Failure::file(path, what, Some(help)));
        }
        if let Some(there) = missing_target(path) {
            let what =
                format!("is a link to `{}`, which does not exist; {undone}", there.display());
            let help = "remove the link, or name another file with -o".to_owned();
            return Err(Failure::file(path, what, Some(help)));
        }
        if inputs.iter().any(|input| is_same_file(path, input)) {
            let what = format!("is the {kind} itself and would be overwritten; {undone}");
            return Err(Failure::file(path, what, Some("name another file with -o".to_owned())));
        }
        let found = match fs::metadata(path) {
            Err(_) => Found::Nothing,
            Ok(known) if known.is_dir() => {
                let what = format!("is a directory; {undone}");
                return Err(Failure::file(path, what, Some("name a file in it".to_owned())));
            }
            Ok(known) if !known.is_file() => Found::Device,
            Ok(known) if !may_be_replaced => return Err(foreign(path, &known, undone)),
            Ok(_) => Found::File,
        };
        Ok(Self { path: path.to_owned(), found })
    }

    /// Refuses what was there when the command began, unless it `may_be_replaced`: for commands that know it only
    /// when their results are there.
    ///
    /// # Errors
    /// As [`OutputFile::plan`] of such a file.
    pub fn check_again(&self, may_be_replaced: bool, undone: &str) -> Result<(), Failure> {
        match fs::metadata(&self.path) {
            Ok(known) if self.found == Found::File && !may_be_replaced => {
                Err(foreign(&self.path, &known, undone))
            }
            _ => Ok(()),
        }
    }

    /// True of a file; false of a device or a pipe, which cannot be read again.
    pub fn is_regular(&self) -> bool {
        self.found != Found::Device
    }

    /// The path that it will have.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Opens a file that can be read while it grows: under its own name where nothing has it. It stays
    /// when it is not finished.
    ///
    /// # Errors
    /// [`Failure::File`], also when another command has begun to write it meanwhile.
    pub fn create_growing(&self) -> Result<Written, Failure> {
        name_all(directory(&self.path), &self.path);
        if self.found != Found::Nothing {
            let mut written = self.created()?;
            // What is in it may be all that there is of a long run.
            if let Place::Temporary(file, _) = &mut written.place {
                file.disable_cleanup(true);
            }
            return Ok(written);
        }
        let file = File::create_new(&self.path).map_err(|error| uncreated(&self.path, &error))?;
        Ok(Written::at(self.path.clone(), Place::Own(file)))
    }

    /// Opens a file that takes its name once it is whole. One that an interrupt ends is removed.
    ///
    /// # Errors
    /// [`Failure::File`].
    pub fn create(&self) -> Result<Written, Failure> {
        name_all(directory(&self.path), &self.path);
        self.created()
    }

    fn created(&self) -> Result<Written, Failure> {
        let path = self.path.clone();
        let place = if self.found == Found::Device {
            let file = File::options().write(true).open(&path);
            Place::Own(file.map_err(|error| Failure::writing(&path, &error))?)
        } else {
            let create = || temporary_in(directory(&path), &path);
            #[cfg(unix)]
            let temporary = crate::unfinished::guarded(create);
            #[cfg(not(unix))]
            let temporary = create();
            Place::Temporary(temporary.map_err(|e| Failure::writing(&path, &e))?, self.found)
        };
        Ok(Written::at(path, place))
    }
}

/// A file that somebody else has made.
fn foreign(path: &Path, known: &fs::Metadata, undone: &str) -> Failure {
    let written = known.modified().ok().map_or_else(String::new, |time| {
        format!(", written {}", humantime::format_rfc3339_seconds(time))
    });
    let what = format!("exists ({} bytes{written}); {undone}", known.len());
    let help = "add --force to overwrite it, or name another file with -o".to_owned();
    Failure::file(path, what, Some(help))
}

/// Writes a whole file. One that exists keeps its content until the new one is whole, and its permissions;
/// a link to it stays one.
///
/// # Errors
/// [`Failure::File`].
pub fn put(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let write = || -> io::Result<()> {
        let mut written = Written::replacing(path)?;
        written.write_all(bytes)?;
        written.persist()
    };
    write().map_err(|error| Failure::writing(path, &error))
}

/// Endings of formats that people know; a file with another one may hold anything.
const KNOWN_ENDINGS: [&str; 23] = [
    "apng", "csv", "dwg", "dxf", "gif", "htm", "html", "jpeg", "jpg", "json", "mcap", "mp4",
    "parquet", "pdf", "png", "svg", "tex", "toml", "tsv", "txt", "typ", "webp", "xlsx",
];

/// Refuses a name whose ending promises another format than `ours`, of which the first is named.
///
/// # Errors
/// [`Failure::Usage`].
pub fn check_ending(path: &Path, ours: &[&str]) -> Result<(), Failure> {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    if ours.contains(&ending.as_str()) || !KNOWN_ENDINGS.contains(&ending.as_str()) {
        return Ok(());
    }
    let [name, own] = [&ending, ours[0]].map(str::to_ascii_uppercase);
    let message = format!("`{}` would be no {name}: this command writes {own}", path.display());
    Err(Failure::usage(message, &format!("end the name with .{}", ours[0])))
}

impl Written {
    /// A file in the place of what is at `path`, if anything is.
    ///
    /// # Errors
    /// A file that cannot be made next to it.
    pub fn replacing(path: &Path) -> io::Result<Self> {
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        if fs::metadata(&path).is_ok_and(|known| !known.is_file()) {
            let file = File::options().write(true).open(&path)?;
            return Ok(Self::at(path, Place::Own(file)));
        }
        let temporary = temporary_in(directory(&path), &path)?;
        if let Ok(known) = fs::metadata(&path) {
            temporary.as_file().set_permissions(known.permissions())?;
        }
        Ok(Self::at(path, Place::Temporary(temporary, Found::File)))
    }

    fn at(path: PathBuf, place: Place) -> Self {
        Self { path, place, n_bytes: Arc::default() }
    }

    /// The number of bytes that have been written, which goes on counting.
    pub fn n_bytes(&self) -> Arc<AtomicU64> {
        self.n_bytes.clone()
    }

    /// Where what has been written so far lies.
    pub fn path_now(&self) -> &Path {
        match &self.place {
            Place::Own(_) => &self.path,
            Place::Temporary(file, _) => file.path(),
        }
    }

    /// Gives the file its name; it is on the disk then.
    ///
    /// # Errors
    /// [`Failure::File`], also when another command has written it meanwhile.
    pub fn finish(self) -> Result<(), Failure> {
        let path = self.path.clone();
        self.persist().map_err(|error| uncreated(&path, &error))
    }

    /// Moves the file to its place; see [`Written::finish`].
    ///
    /// # Errors
    /// As the system says them.
    pub fn persist(self) -> io::Result<()> {
        let Self { path, place, .. } = self;
        match place {
            // A device need not be one that can be synchronised.
            Place::Own(file) => drop(file.sync_all()),
            Place::Temporary(file, found) => {
                file.as_file().sync_all()?;
                let temporary = file.path().to_owned();
                let persisted = match found {
                    Found::Nothing => file.persist_noclobber(&path),
                    Found::File | Found::Device => file.persist(&path),
                };
                persisted.map_err(|error| error.error)?;
                #[cfg(unix)]
                crate::unfinished::release(&temporary);
            }
        }
        Ok(())
    }
}

impl Write for Written {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let n = match &mut self.place {
            Place::Own(file) => file.write(bytes)?,
            Place::Temporary(file, _) => file.write(bytes)?,
        };
        self.n_bytes.fetch_add(n as u64, Ordering::Relaxed);
        Ok(n)
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.place {
            Place::Own(file) => file.flush(),
            Place::Temporary(file, _) => file.flush(),
        }
    }
}

impl Seek for Written {
    fn seek(&mut self, position: io::SeekFrom) -> io::Result<u64> {
        match &mut self.place {
            Place::Own(file) => file.seek(position),
            Place::Temporary(file, _) => file.seek(position),
        }
    }
}

/// Equality of the files that two paths lead to, through links of either kind, too.
pub fn is_same_file(a: &Path, b: &Path) -> bool {
    same_file::is_same_file(a, b).unwrap_or(false)
}

fn directory(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Target of a link that leads nowhere.
fn missing_target(path: &Path) -> Option<PathBuf> {
    if path.exists() { None } else { fs::read_link(path).ok() }
}

/// A new file next to `path`, as other people may read it.
fn temporary_in(directory: &Path, path: &Path) -> io::Result<NamedTempFile> {
    let prefix = prefix_of(path);
    let mut builder = Builder::new();
    builder.prefix(&prefix).suffix(PART);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Less what the user's mask takes away.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let file = builder.tempfile_in(directory)?;
    lock(file.as_file());
    Ok(file)
}

fn uncreated(path: &Path, error: &io::Error) -> Failure {
    if error.kind() == io::ErrorKind::AlreadyExists {
        let what = "exists: another command has begun to write it meanwhile".to_owned();
        return Failure::file(path, what, Some("name another file with -o".to_owned()));
    }
    Failure::writing(path, error)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(path: &Path, inputs: &[&Path], force: bool) -> Result<OutputFile, String> {
        OutputFile::plan(path, ("model", inputs), force, "nothing was done").map_err(|failure| {
            match failure {
                Failure::File { what, .. } => what,
                other => panic!("{other:?}"),
            }
        })
    }

    fn write(mut file: Written, text: &str) {
        file.write_all(text.as_bytes()).expect("written");
        file.finish().expect("finished");
    }

    #[test]
    fn of_two_that_write_one_new_file_one_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("log");
        let [first, second] = [(); 2].map(|()| plan(&path, &[], false).expect("free"));
        let growing = first.create_growing().expect("created");
        assert!(second.create_growing().is_err(), "the log is being written");
        write(growing, "first");
        let third = second.create().expect("next to it");
        assert!(third.finish().is_err(), "it exists by now");
        assert_eq!(fs::read_to_string(&path).expect("a file"), "first");
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1, "nothing is left");
    }

    #[test]
    fn what_is_replaced_stays_until_the_new_one_is_whole() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("log");
        fs::write(&path, "old").expect("written");
        assert!(plan(&path, &[], false).expect_err("it exists").starts_with("exists (3 bytes"));
        let output = plan(&path, &[], true).expect("it may be replaced");
        let mut new = output.create_growing().expect("created");
        new.write_all(b"new").expect("written");
        assert_eq!(fs::read_to_string(&path).expect("a file"), "old");
        new.finish().expect("finished");
        assert_eq!(fs::read_to_string(&path).expect("a file"), "new");
        drop(output.create().expect("created"));
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1, "nothing is left");
        drop(output.create_growing().expect("created"));
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 2, "it may be needed");
    }

    #[test]
    fn an_ending_promises_a_format() {
        let is_refused = |name: &str, ours: &[&str]| check_ending(Path::new(name), ours).is_err();
        assert!(is_refused("run.csv", &["mcap"]) && is_refused("run.PDF", &["html", "htm"]));
        for name in ["run.mcap", "run.MCAP", "run", "run.log", "/dev/null", ".mcap", "run.2"] {
            assert!(!is_refused(name, &["mcap"]), "{name}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_link_that_leads_nowhere_is_called_one_and_another_stays() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        symlink("nowhere", at("link")).expect("a link");
        for force in [false, true] {
            let said = plan(&at("link"), &[], force).expect_err("it leads nowhere");
            assert_eq!(said, "is a link to `nowhere`, which does not exist; nothing was done");
        }
        fs::write(at("nowhere"), "old").expect("written");
        put(&at("link"), b"new").expect("written");
        assert!(fs::symlink_metadata(at("link")).expect("a link").is_symlink());
        assert_eq!(fs::read_to_string(at("nowhere")).expect("a file"), "new");
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 2, "nothing is left");
    }

    #[cfg(unix)]
    #[test]
    fn an_input_is_known_by_each_of_its_names() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        fs::write(at("model"), "text").expect("written");
        fs::hard_link(at("model"), at("hard")).expect("a link");
        symlink(at("model"), at("soft")).expect("a link");
        for name in ["model", "hard", "soft"] {
            let refused = plan(&at(name), &[&at("model")], true).expect_err("it is the model");
            assert!(refused.starts_with("is the model itself"), "{name}: {refused}");
        }
        write(plan(&at("new"), &[], false).expect("free").create().expect("created"), "");
        write(plan(&at("grown"), &[], false).expect("free").create_growing().expect("made"), "");
        let mode = |name: &str| fs::metadata(at(name)).expect("a file").permissions().mode();
        assert_eq!(mode("new"), mode("grown"), "others may read it alike");
        // A device stays one.
        write(plan(Path::new("/dev/null"), &[], true).expect("it is").create().expect("open"), "x");
        assert!(!fs::metadata("/dev/null").expect("it is").is_file());
    }
}
