//! From a log to curves, in one sweep and constant memory.
//!
//! Where samples are denser than pixels, they are drawn, thinned so that no peak is lost. Where they
//! are sparser, the motion between them is: all that has a value at every instant is computed at
//! the pixels' own times, and on both sides of an instant at which the motion jumps.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use bksim::log::export::rows;
use bksim::log::{Header, LogError, LogReader, NotUnique, Record, Selection};
use bksim::measured::Measured;
use bksim::overview::floor;
use bksim::playback::RunLog;
use bksim::record::{Channels, INPUTS, Signal};
use bksim::sim::run::{Replay, Sample};
use bksim_plot::{Envelope, Point, Trace};

use bksim_cli::exit::Failure;
use bksim_cli::source::logged::measured;

use super::choose::Quantity;
use super::player::Player;
use super::table::Rows;

/// Instants at which the motion is computed: a few more than a picture has pixels.
const N_OVER_TIME: usize = 1200;
/// Number of samples where one zooms in: a fifth of the time still has a value per pixel.
const N_ZOOMED: usize = 6_000;
/// Number of samples of a curve in the plane, which may go round often.
const N_IN_PLANE: usize = 6000;

/// A log or a table to draw.
pub(super) struct Run {
    /// The file that was named.
    pub(super) path: PathBuf,
    contents: Contents,
    pub(super) header: Header,
    /// True if its end was read; known after [`Run::curves`].
    pub(super) is_complete: bool,
    /// Why its curves join samples where they could be finer.
    pub(super) coarse_because: Option<String>,
    /// From when on which channels are not unique, in the order of the run.
    not_unique: Vec<NotUnique>,
    /// Quantities that are computed from its samples.
    measured: Option<Measured>,
    /// By unit the largest size of all its channels; known after [`Run::curves`].
    largest: BTreeMap<String, f64>,
}

/// Where samples come from.
enum Contents {
    /// A log.
    Log(PathBuf),
    /// Rows of a table, without a motion between them.
    Table(Rows),
}

/// Values of a quantity along a run.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Drawn {
    pub(super) points: Vec<Point>,
    /// Values that were read or computed.
    pub(super) n_values: u64,
    /// The smallest and the largest.
    pub(super) range: Option<[f64; 2]>,
    /// True if they were computed from the motion between samples.
    pub(super) is_dense: bool,
}

/// The part of a run to be drawn.
pub(super) struct CurveRequest<'a> {
    pub(super) quantities: Vec<&'a Quantity>,
    /// The abscissa; the time if none.
    pub(super) x: Option<&'a Quantity>,
    /// First and last time, s; may be infinite.
    pub(super) span: [f64; 2],
    /// True if a part of it may be shown as large as the whole.
    pub(super) is_zoomed: bool,
}

impl CurveRequest<'_> {
    fn n_instants(&self) -> usize {
        match (self.x, self.is_zoomed) {
            (Some(_), _) => N_IN_PLANE,
            (None, true) => N_ZOOMED,
            (None, false) => N_OVER_TIME,
        }
    }
}

fn open(path: &Path) -> Result<LogReader<BufReader<File>>, LogError> {
    LogReader::open(BufReader::with_capacity(1 << 18, File::open(path)?))
}

impl Run {
    pub(super) fn open(path: &Path, file: &Path) -> Result<Self, LogError> {
        let header = open(file)?.header().clone();
        Ok(Self::of(path, header, Contents::Log(file.to_owned())))
    }

    /// A table as a run that has nothing but samples.
    pub(super) fn of_table(path: &Path, (header, rows): (Header, Rows)) -> Self {
        Self::of(path, header, Contents::Table(rows))
    }

    /// True of a quantity that is computed from the samples, under the name of a measure.
    pub(super) fn is_measured(&self, name: &str) -> bool {
        self.measured.as_ref().is_some_and(|measured| measured.position(name).is_some())
    }

    fn of(path: &Path, header: Header, contents: Contents) -> Self {
        Self {
            path: path.to_owned(),
            contents,
            header,
            is_complete: false,
            coarse_because: None,
            not_unique: Vec::new(),
            measured: None,
            largest: BTreeMap::new(),
        }
    }

    /// True of a table.
    pub(super) fn is_table(&self) -> bool {
        matches!(self.contents, Contents::Table(_))
    }

    /// True where it has all channels of a quantity.
    pub(super) fn has(&self, quantity: &Quantity) -> bool {
        let all = Selection::all(&self.header);
        let is_there = |name: &String| all.columns().iter().any(|column| column.name == *name);
        quantity.channels.iter().all(is_there)
    }

    /// The size below which values of this unit are nothing but rounding.
    pub(super) fn floor(&self, unit: &str) -> f64 {
        floor(unit, self.largest.get(unit).copied().unwrap_or(0.0))
    }

    /// Adds the quantities of these names that the log does not have as channels.
    ///
    /// # Errors
    /// As [`measured`].
    pub(super) fn measure(&mut self, names: &[String]) -> Result<(), Failure> {
        let Contents::Log(file) = &self.contents else { return Ok(()) };
        self.measured = measured(file, &self.header, names, "drawn")?;
        if self.measured.is_some() {
            let log = self.samples(file).map_err(|e| super::bad_log(&self.path, &e))?;
            self.header = log.header().clone();
        }
        Ok(())
    }

    /// The log from its beginning, with the quantities that are computed from it.
    fn samples(&self, file: &Path) -> Result<LogReader<BufReader<File>>, LogError> {
        let log = open(file)?;
        Ok(match &self.measured {
            Some(measured) => log.making(measured.making()),
            None => log,
        })
    }

    /// Hands the samples of one time after the other to `put`. True where the end was read, and from when on which
    /// channels are not unique.
    fn each_row(
        &self,
        selection: &Selection,
        put: &mut dyn FnMut(f64, &[Option<f64>]),
    ) -> Result<(bool, Vec<NotUnique>), LogError> {
        let file = match &self.contents {
            Contents::Log(file) => file,
            Contents::Table(table) => {
                table.each(selection, put);
                return Ok((true, Vec::new()));
            }
        };
        let exported = rows(self.samples(file)?, selection, |t, cells| {
            put(t, cells);
            Ok(())
        })?;
        Ok((exported.end.is_some(), exported.not_unique))
    }

    /// The curves of the quantities, in their order; none for one that the run does not have.
    pub(super) fn curves(
        &mut self,
        wish: &CurveRequest<'_>,
    ) -> Result<Vec<Option<Drawn>>, LogError> {
        let mut sampled = self.sampled(wish)?;
        let is_dense = |pen: &Pen| pen.n_values > wish.n_instants() as u64;
        if sampled.pens.iter().flatten().any(|pen| !is_dense(pen))
            && let Err(why) = self.computed(wish, &mut sampled)
        {
            self.coarse_because = Some(why);
        }
        Ok(sampled.pens.into_iter().map(|pen| pen.map(Pen::into_drawn)).collect())
    }

    /// True if a quantity is one of many solutions at time `t`, s.
    pub(super) fn is_shared_at(&self, quantity: &Quantity, t: f64) -> bool {
        let forward = self.header.direction();
        let begun = self.not_unique.iter().rev().find(|change| (t - change.t) * forward >= 0.0);
        let now = begun.or(self.not_unique.first());
        let is_shared =
            |now: &NotUnique| quantity.channels.iter().any(|name| now.channels.contains(name));
        now.is_some_and(is_shared)
    }

    /// True if a quantity is one of many solutions at any time.
    pub(super) fn is_ever_shared(&self, quantity: &Quantity) -> bool {
        let times = self.not_unique.iter().map(|change| change.t);
        times.into_iter().any(|t| self.is_shared_at(quantity, t))
    }

    /// Curves through the samples.
    fn sampled(&mut self, wish: &CurveRequest<'_>) -> Result<Sampled, LogError> {
        // A pen for each quantity that this log has.
        let all = Selection::all(&self.header);
        let has = |quantity: &Quantity| self.has(quantity);
        let mut pens: Vec<_> = wish
            .quantities
            .iter()
            .map(|quantity| has(quantity).then(|| Pen::new(wish.x.is_some())))
            .collect();
        if wish.x.is_some_and(|x| !has(x)) {
            pens.fill_with(|| None);
        }
        // The columns that they need.
        let present = wish.quantities.iter().zip(&pens).filter(|(_, pen)| pen.is_some());
        let names = present.map(|(quantity, _)| *quantity).chain(wish.x.filter(|x| has(x)));
        let names: Vec<&String> = names.flat_map(|quantity| &quantity.channels).collect();
        if names.is_empty() {
            return Ok(Sampled { pens, span: None });
        }
        // What the sizes of all channels of their units are.
        let units: Vec<&str> =
            wish.quantities.iter().map(|quantity| quantity.unit.as_str()).collect();
        let alike = all.columns().iter().filter(|column| units.contains(&column.unit.as_str()));
        let names: Vec<&String> =
            names.into_iter().chain(alike.map(|column| &column.name)).collect();
        let selection = Selection::new(&self.header, &names)?;
        let mut largest: BTreeMap<String, f64> = BTreeMap::new();
        let cells_of = |quantity: &Quantity| -> Vec<usize> {
            let place =
                |name: &String| selection.columns().iter().position(|column| column.name == *name);
            quantity.channels.iter().filter_map(place).collect()
        };
        let places: Vec<_> = wish.quantities.iter().map(|quantity| cells_of(quantity)).collect();
        let x_places = wish.x.map(cells_of);

        // One pass over the samples.
        let mut span: Option<[f64; 2]> = None;
        let (is_complete, not_unique) = self.each_row(&selection, &mut |t, cells| {
            if t < wish.span[0] || t > wish.span[1] {
                return;
            }
            span.get_or_insert([t, t])[1] = t;
            for (column, cell) in selection.columns().iter().zip(cells) {
                let size = cell.map_or(0.0, f64::abs);
                if size.is_finite() && size > largest.get(&column.unit).copied().unwrap_or(0.0) {
                    largest.insert(column.unit.clone(), size);
                }
            }
            let x = match &x_places {
                None => Some(t),
                Some(places) => size(places.iter().map(|&place| cells[place])),
            };
            let Some(x) = x else { return };
            for (pen, places) in pens.iter_mut().zip(&places) {
                let Some(pen) = pen else { continue };
                if let Some(y) = size(places.iter().map(|&place| cells[place])) {
                    pen.push([x, y]);
                }
            }
        })?;
        self.is_complete = is_complete;
        self.largest = largest;
        self.not_unique = not_unique;
        Ok(Sampled { pens, span })
    }

    /// Replaces curves of few samples by the motion between them; the text is why it cannot.
    fn computed(&self, wish: &CurveRequest<'_>, sampled: &mut Sampled) -> Result<(), String> {
        let Contents::Log(file) = &self.contents else { return Ok(()) };
        let Some([first, last]) = sampled.span.filter(|[first, last]| first != last) else {
            return Ok(());
        };
        if self.header.topics.iter().any(|topic| topic.name == INPUTS) {
            // Between samples nothing is known of inputs.
            return Ok(());
        }
        let log = RunLog::unlogged(self.header.clone(), Vec::new());
        let mechanism = log.mechanism().map_err(|e| format!("its model is refused: {e}"))?;
        let (channels, n_instants) = (Channels::new(&mechanism), wish.n_instants());
        let mut measured = self.measured.clone();
        let place = |name: &String| measured.as_ref().and_then(|of| of.position(name));
        let sources = |quantity: &Quantity| -> Option<Vec<Source>> {
            let source = |name: &String| {
                let logged = channels.signal(name).map(Source::Channel);
                logged.or_else(|| place(name).map(Source::Measured))
            };
            quantity.channels.iter().map(source).collect()
        };
        let x_sources = match wish.x {
            None => None,
            // An abscissa that has values at samples alone leaves nothing to compute.
            Some(x) => Some(match sources(x) {
                None => return Ok(()),
                some => some.unwrap_or_default(),
            }),
        };
        let mut pens: Vec<Option<(Pen, Vec<Source>)>> = Vec::new();
        for (pen, quantity) in sampled.pens.iter().zip(&wish.quantities) {
            let few = pen.as_ref().is_some_and(|pen| pen.n_values <= n_instants as u64);
            let sources = sources(quantity).filter(|_| few);
            pens.push(sources.map(|sources| (Pen::new(wish.x.is_some()), sources)));
        }
        if pens.iter().all(Option::is_none) {
            return Ok(());
        }
        let draw = |sample: &Sample| {
            let values = measured.as_mut().map(|measured| measured.at(sample)).unwrap_or_default();
            let value_of = |source: &Source| match *source {
                Source::Channel(signal) => Some(channels.value(signal, sample)),
                Source::Measured(place) => values.get(place).copied(),
            };
            let value = |sources: &[Source]| size(sources.iter().map(value_of));
            let x = x_sources.as_ref().map_or(Some(sample.t), |sources| value(sources));
            for (pen, sources) in pens.iter_mut().flatten() {
                if let Some((x, y)) = x.zip(value(sources)) {
                    pen.push([x, y]);
                }
            }
        };
        let replay = Replay::new(&mechanism.compiled, &mechanism.parameters);
        let n_state = 2 * mechanism.compiled.nq();
        let states = [vec![0.0; n_state], vec![0.0; n_state]];
        let mut player = Player::new((replay, states), [first, last], n_instants, draw);
        let mut reader = open(file).map_err(|e| e.to_string())?.only(&bksim::log::Request::MOTION);
        while let Some(record) = reader.next_record().map_err(|e| e.to_string())? {
            if let Record::Segment(segment) = record {
                player.play(segment)?;
            }
        }
        player.finish()?;
        // A log without its motion has samples all the same.
        for (own, pen) in sampled.pens.iter_mut().zip(pens) {
            if let Some((mut pen, _)) = pen.filter(|(pen, _)| pen.n_values > 0) {
                pen.is_dense = true;
                *own = Some(pen);
            }
        }
        Ok(())
    }
}

/// Where the value of a channel comes from at an instant between samples.
#[derive(Clone, Copy)]
enum Source {
    /// A channel of the log.
    Channel(Signal),
    /// A quantity that is computed from it, by its place among them.
    Measured(usize),
}

struct Sampled {
    pens: Vec<Option<Pen>>,
    /// First and last time that was drawn.
    span: Option<[f64; 2]>,
}

/// One number as it is, several as the length of their vector.
fn size(values: impl ExactSizeIterator<Item = Option<f64>>) -> Option<f64> {
    let is_one = values.len() == 1;
    let mut values = values;
    if is_one {
        return values.next().flatten();
    }
    values.try_fold(0.0, |size: f64, value| Some(size.hypot(value?)))
}

/// Draws one curve.
struct Pen {
    line: Line,
    n_values: u64,
    range: Option<[f64; 2]>,
    is_dense: bool,
}

enum Line {
    OverTime(Envelope),
    InPlane(Trace),
}

impl Pen {
    fn new(in_plane: bool) -> Self {
        let line = if in_plane {
            Line::InPlane(Trace::default())
        } else {
            Line::OverTime(Envelope::default())
        };
        Self { line, n_values: 0, range: None, is_dense: false }
    }

    fn push(&mut self, point: Point) {
        self.n_values += 1;
        let y = point[1];
        if y.is_finite() {
            let [low, high] = self.range.get_or_insert([y, y]);
            (*low, *high) = (low.min(y), high.max(y));
        }
        match &mut self.line {
            Line::OverTime(envelope) => envelope.push(point),
            Line::InPlane(trace) => trace.push(point),
        }
    }

    fn into_drawn(self) -> Drawn {
        let points = match self.line {
            Line::OverTime(envelope) => envelope.into_points(),
            Line::InPlane(trace) => trace.into_points(),
        };
        let Self { n_values, range, is_dense, .. } = self;
        Drawn { points, n_values, range, is_dense }
    }
}
