//! [`Source`]: the origin of a window's motion; and [`Loader`], which reads it on a thread of its
//! own, at first and whenever one of its files changes.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use crate::show::Show;
use bksim_load::Watch;

/// Time without further changes after which a changed file is read again.
const QUIET: Duration = Duration::from_millis(120);

/// Time after which a file that never stops changing is read again, such as a log that is being
/// written.
const PATIENCE: Duration = Duration::from_secs(1);

/// Reads the files of a window, and solves a model.
pub type Load = Box<dyn FnMut(&Task) -> Loaded + Send>;

/// Writes values of parameters into the file of a model, or says why it cannot.
pub type Save = Box<dyn Fn(&[(String, String)]) -> Result<(), String>>;

/// The origin of a window's motion.
pub struct Source {
    /// Path or name in the window's title.
    pub name: String,
    /// The files to watch from the beginning.
    pub files: Vec<PathBuf>,
    /// True if [`Task::values`] are taken: of a model, not of a log.
    pub takes_values: bool,
    /// Writes values that the window has changed into the file; `None` where there is no file to write.
    pub save: Option<Save>,
    /// Reads the files, and solves a model; called on a thread of its own.
    pub load: Load,
}

/// The result of reading the files once.
#[derive(Debug, Default)]
pub struct Loaded {
    /// The motion, as far as there is one.
    pub show: Option<Box<Show>>,
    /// The fault, as text of several lines; a motion that stops early has one, too.
    pub fault: Option<String>,
    /// The files that were read; a change of any of them starts another reading.
    pub files: Vec<PathBuf>,
    /// True if it was given up because of [`Task::is_stopped`]: there is nothing to show then.
    pub is_abandoned: bool,
}

/// Work in the background: its progress, and whether it should stop.
#[derive(Debug, Default)]
pub struct Task {
    is_stopped: AtomicBool,
    is_busy: AtomicBool,
    is_closed: AtomicBool,
    /// Fraction of the work that is done, as the bits of an `f64`.
    part: AtomicU64,
    /// Parameters that the window has changed, with their values as text.
    values: Mutex<BTreeMap<String, String>>,
}

impl Task {
    /// Whether the work has become useless: a file has changed, or the window was closed.
    pub fn is_stopped(&self) -> bool {
        self.is_stopped.load(Ordering::Relaxed)
    }

    /// Sets the fraction of the work that is done, 0 to 1.
    pub fn set_part(&self, part: f64) {
        self.part.store(part.to_bits(), Ordering::Relaxed);
    }

    /// Parameters that the window has changed, with their values as text.
    pub fn values(&self) -> Vec<(String, String)> {
        let values = self.values.lock().unwrap_or_else(PoisonError::into_inner);
        values.iter().map(|(name, value)| (name.clone(), value.clone())).collect()
    }

    fn set_value(&self, name: String, value: String) {
        self.values.lock().unwrap_or_else(PoisonError::into_inner).insert(name, value);
    }

    fn forget_values(&self) {
        self.values.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }

    /// The fraction of the work that is done, 0 to 1, while there is work.
    pub(super) fn part(&self) -> Option<f64> {
        let is_busy = self.is_busy.load(Ordering::Relaxed);
        is_busy.then(|| f64::from_bits(self.part.load(Ordering::Relaxed)))
    }

    /// True if the window was closed.
    fn is_closed(&self) -> bool {
        self.is_closed.load(Ordering::Relaxed)
    }

    fn stop(&self) {
        self.is_stopped.store(true, Ordering::Relaxed);
    }

    fn begin(&self) {
        self.set_part(0.0);
        self.is_stopped.store(false, Ordering::Relaxed);
        self.is_busy.store(true, Ordering::Relaxed);
    }

    fn end(&self) {
        self.is_busy.store(false, Ordering::Relaxed);
    }
}

/// News from the background.
#[derive(Debug)]
pub(super) enum News {
    /// The files have been read, which took so many seconds.
    Loaded(Loaded, f64),
    /// Changes of the files will not be noticed, for this reason.
    Unwatched(String),
}

/// A source on a thread of its own.
pub(super) struct Loader {
    pub(super) task: Arc<Task>,
    /// True if values of parameters can be changed in the window.
    pub(super) takes_values: bool,
    save: Option<Save>,
    news: Receiver<News>,
    changed: Sender<Change>,
}

/// Why the files are read again.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Change {
    /// One of them has changed.
    File,
    /// The window has changed a value.
    Value,
}

impl Loader {
    /// Starts to load; `wake` is called when there is news.
    pub(super) fn start(mut source: Source, wake: impl Fn() + Send + 'static) -> Self {
        let task = Arc::new(Task::default());
        let (sender, news) = channel();
        let changes = channel();
        let changed = changes.0.clone();
        let shared = Arc::clone(&task);
        let (takes_values, save) = (source.takes_values, source.save.take());
        let Source { files, load, .. } = source;
        task.begin();
        thread::spawn(move || keep_loading(&files, load, &shared, &sender, changes, &wake));
        Self { task, takes_values, save, news, changed }
    }

    /// Loads again with another value of a parameter.
    pub(super) fn set_value(&self, name: String, value: String) {
        self.task.set_value(name, value);
        self.task.stop();
        let _ = self.changed.send(Change::Value);
    }

    /// The parameters with other values than in the file, if there is a file to write them into.
    pub(super) fn unsaved(&self) -> Vec<(String, String)> {
        if self.save.is_some() { self.task.values() } else { Vec::new() }
    }

    /// Writes the changed values into the file, which is then read again.
    ///
    /// # Errors
    /// A sentence that says why they cannot be written.
    pub(super) fn save(&self) -> Result<(), String> {
        let values = self.unsaved();
        match &self.save {
            Some(save) if !values.is_empty() => save(&values),
            _ => Ok(()),
        }
    }

    /// Loads again with the values of the file.
    pub(super) fn revert(&self) {
        self.task.forget_values();
        self.task.stop();
        let _ = self.changed.send(Change::Value);
    }

    /// The news since the last call.
    pub(super) fn news(&self) -> impl Iterator<Item = News> {
        self.news.try_iter()
    }
}

impl Drop for Loader {
    fn drop(&mut self) {
        self.task.is_closed.store(true, Ordering::Relaxed);
        self.task.stop();
        let _ = self.changed.send(Change::Value);
    }
}

/// Loads, waits for a change, and loads again, until nobody listens.
fn keep_loading(
    files: &[PathBuf],
    mut load: Load,
    task: &Arc<Task>,
    news: &Sender<News>,
    (changed, changes): (Sender<Change>, Receiver<Change>),
    wake: &dyn Fn(),
) {
    let stopped = Arc::clone(task);
    // A change of a file makes the reading under way useless.
    let watch = Watch::new(move || {
        stopped.stop();
        let _ = changed.send(Change::File);
    });
    let mut watch = match watch {
        Ok(watch) => Some(watch),
        Err(error) => {
            let _ = news.send(News::Unwatched(error.to_string()));
            None
        }
    };
    if let Some(watch) = &mut watch {
        watch.set_files(files);
    }
    loop {
        task.begin();
        let begun = Instant::now();
        let loaded = load(task);
        task.end();
        if let Some(watch) = &mut watch {
            watch.set_files(&loaded.files);
        }
        if !loaded.is_abandoned {
            let seconds = begun.elapsed().as_secs_f64();
            if news.send(News::Loaded(loaded, seconds)).is_err() {
                return;
            }
            wake();
        }
        match changes.recv() {
            Ok(Change::File) => {
                wait_for_quiet(&changes);
                // The file has the last word.
                task.forget_values();
            }
            // Of the ways of a slider the newest is enough.
            Ok(Change::Value) => while changes.try_recv().is_ok() {},
            Err(_) => return,
        }
        if task.is_closed() {
            return;
        }
    }
}

/// Waits until no more changes come, or patience is over.
fn wait_for_quiet(changes: &Receiver<Change>) {
    let begun = Instant::now();
    while begun.elapsed() < PATIENCE && changes.recv_timeout(QUIET).is_ok() {}
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;
    use std::{env, fs, process};

    use super::*;

    /// A directory that is removed after the test.
    struct TestDirectory(PathBuf);

    impl Drop for TestDirectory {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    fn next(loader: &Loader) -> String {
        let News::Loaded(loaded, _) =
            loader.news.recv_timeout(Duration::from_secs(20)).expect("news within 20 s")
        else {
            panic!("files are watched");
        };
        loaded.fault.expect("the text of the file")
    }

    #[test]
    fn every_way_of_saving_loads_again_and_stops_a_reading_under_way() {
        let name = format!("bksim-view-watch-{}", process::id());
        let directory = TestDirectory(env::temp_dir().join(name));
        fs::create_dir_all(&directory.0).expect("a directory");
        let file = directory.0.join("model.toml");
        fs::write(&file, "one").expect("written");
        let stops = Arc::new(Mutex::new(0));
        let (counted, read) = (Arc::clone(&stops), file.clone());
        let load = move |task: &Task| {
            let text = fs::read_to_string(&read).unwrap_or_default();
            // Long work: it is given up when the file changes.
            while text == "slow" && !task.is_stopped() {
                thread::sleep(Duration::from_millis(2));
            }
            let is_abandoned = task.is_stopped() && text == "slow";
            *counted.lock().expect("no panic") += usize::from(is_abandoned);
            Loaded { fault: Some(text), files: vec![read.clone()], is_abandoned, show: None }
        };
        let source = Source {
            name: "model".into(),
            files: vec![file.clone()],
            takes_values: true,
            save: None,
            load: Box::new(load),
        };
        let loader = Loader::start(source, || ());
        assert_eq!(next(&loader), "one");

        fs::write(&file, "two").expect("written in place");
        assert_eq!(next(&loader), "two");
        let temporary = directory.0.join(".model.toml.swp");
        fs::write(&temporary, "three").expect("written next to it");
        fs::rename(&temporary, &file).expect("moved over it");
        assert_eq!(next(&loader), "three");
        fs::rename(&file, directory.0.join("model.toml~")).expect("kept");
        fs::write(&file, "slow").expect("written again");
        while loader.task.part().is_none() {
            thread::sleep(Duration::from_millis(2));
        }
        fs::write(&file, "four").expect("written in place");
        assert_eq!(next(&loader), "four");
        assert!(*stops.lock().expect("no panic") >= 1, "the slow work was given up");
    }

    #[test]
    fn a_value_of_the_window_is_loaded_at_once_and_written_when_asked() {
        let load = |task: &Task| Loaded {
            fault: Some(format!("{:?}", task.values())),
            ..Loaded::default()
        };
        let saved = std::rc::Rc::new(std::cell::RefCell::new(Vec::new()));
        let taken = std::rc::Rc::clone(&saved);
        let save = move |values: &[(String, String)]| {
            taken.borrow_mut().extend_from_slice(values);
            Ok(())
        };
        let source = Source {
            name: String::new(),
            files: Vec::new(),
            takes_values: true,
            save: Some(Box::new(save)),
            load: Box::new(load),
        };
        let loader = Loader::start(source, || ());
        assert_eq!(next(&loader), "[]");
        loader.set_value("a".to_owned(), "2 m".to_owned());
        assert_eq!(next(&loader), "[(\"a\", \"2 m\")]");
        assert!(saved.borrow().is_empty());
        assert_eq!(loader.save(), Ok(()));
        assert_eq!(*saved.borrow(), loader.unsaved());
        loader.revert();
        assert_eq!(next(&loader), "[]");
        assert!(loader.unsaved().is_empty());
    }
}
