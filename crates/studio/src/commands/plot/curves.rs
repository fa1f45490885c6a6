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
use bksim::sim::run::{Replay, Sample, Segment};
use bksim_plot::{Envelope, Point, Trace};

use bksim_cli::exit::Failure;
use bksim_cli::source::logged::measured;

use super::choose::Quantity;

/// Instants at which the motion is computed: a few more than a picture has pixels.
const N_OVER_TIME: usize = 1200;
/// The same where one zooms in: a fifth of the time still has a value per pixel.
const N_ZOOMED: usize = 6_000;
/// The same for a curve in the plane, which may go round often.
const N_IN_PLANE: usize = 6000;
/// A coordinate that differs by more between two segments jumps, relative to its size.
const JUMP: f64 = 1e-6;

/// A log to draw.
pub(super) struct Run {
    /// The file that was named.
    pub(super) path: PathBuf,
    /// The log.
    file: PathBuf,
    pub(super) header: Header,
    /// Whether its end was read; known after [`Run::curves`].
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

/// Values of a quantity along a run.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Drawn {
    pub(super) points: Vec<Point>,
    /// Values that were read or computed.
    pub(super) n_values: u64,
    /// The smallest and the largest.
    pub(super) range: Option<[f64; 2]>,
    /// Whether they were computed from the motion between samples.
    pub(super) is_dense: bool,
}

/// The part of a run to be drawn.
pub(super) struct CurveRequest<'a> {
    pub(super) quantities: Vec<&'a Quantity>,
    /// The abscissa; the time if none.
    pub(super) x: Option<&'a Quantity>,
    /// First and last time, s; may be infinite.
    pub(super) span: [f64; 2],
    /// Whether a part of it may be shown as large as the whole.
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
        Ok(Self {
            path: path.to_owned(),
            file: file.to_owned(),
            header,
            is_complete: false,
            coarse_because: None,
            not_unique: Vec::new(),
            measured: None,
            largest: BTreeMap::new(),
        })
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
        self.measured = measured(&self.file, &self.header, names, "drawn")?;
        if self.measured.is_some() {
            let log = self.samples().map_err(|e| super::bad_log(&self.path, &e))?;
            self.header = log.header().clone();
        }
        Ok(())
    }

    /// The log from its beginning, with the quantities that are computed from it.
    fn samples(&self) -> Result<LogReader<BufReader<File>>, LogError> {
        let log = open(&self.file)?;
        Ok(match &self.measured {
            Some(measured) => log.making(measured.making()),
            None => log,
        })
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

    /// Whether a quantity is one of many solutions at time `t`, s.
    pub(super) fn is_shared_at(&self, quantity: &Quantity, t: f64) -> bool {
        let forward = self.header.direction();
        let begun = self.not_unique.iter().rev().find(|change| (t - change.t) * forward >= 0.0);
        let now = begun.or(self.not_unique.first());
        let is_shared =
            |now: &NotUnique| quantity.channels.iter().any(|name| now.channels.contains(name));
        now.is_some_and(is_shared)
    }

    /// Whether a quantity is one of many solutions at any time.
    pub(super) fn is_ever_shared(&self, quantity: &Quantity) -> bool {
        let times = self.not_unique.iter().map(|change| change.t);
        times.into_iter().any(|t| self.is_shared_at(quantity, t))
    }

    /// Curves through the samples.
    fn sampled(&mut self, wish: &CurveRequest<'_>) -> Result<Sampled, LogError> {
        // A pen for each quantity that this log has.
        let all = Selection::all(&self.header);
        let has = |quantity: &Quantity| {
            let is_there = |name: &String| all.columns().iter().any(|column| column.name == *name);
            quantity.channels.iter().all(is_there)
        };
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
        let exported = rows(self.samples()?, &selection, |t, cells| {
            if t < wish.span[0] || t > wish.span[1] {
                return Ok(());
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
            let Some(x) = x else { return Ok(()) };
            for (pen, places) in pens.iter_mut().zip(&places) {
                let Some(pen) = pen else { continue };
                if let Some(y) = size(places.iter().map(|&place| cells[place])) {
                    pen.push([x, y]);
                }
            }
            Ok(())
        })?;
        self.is_complete = exported.end.is_some();
        self.largest = largest;
        self.not_unique = exported.not_unique;
        Ok(Sampled { pens, span })
    }

    /// Replaces curves of few samples by the motion between them; the text is why it cannot.
    fn computed(&self, wish: &CurveRequest<'_>, sampled: &mut Sampled) -> Result<(), String> {
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
        let span = [first, last];
        let mut player = Player { replay, draw, span, n_instants, next: 0, last: None, states };
        let mut reader =
            open(&self.file).map_err(|e| e.to_string())?.only(&bksim::log::Request::MOTION);
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

/// Computes samples at evenly spaced instants, from segments as they come.
struct Player<'a, F> {
    replay: Replay<'a>,
    draw: F,
    /// From where to where.
    span: [f64; 2],
    /// In how many parts the instants cut it.
    n_instants: usize,
    /// Number of the next instant.
    next: usize,
    /// The segment before, if there is one.
    last: Option<Segment>,
    /// States at the boundary of two segments.
    states: [Vec<f64>; 2],
}

impl<F: FnMut(&Sample)> Player<'_, F> {
    fn instant(&self, idx: usize) -> f64 {
        let part = idx as f64 / self.n_instants as f64;
        self.span[0] + part * (self.span[1] - self.span[0])
    }

    /// Whether `t` lies in the span, whichever way that goes.
    fn is_inside(&self, t: f64) -> bool {
        (t - self.span[0]) * (self.span[1] - t) >= 0.0
    }

    fn play(&mut self, segment: &bksim::log::Segment) -> Result<(), String> {
        let bksim::log::Segment { t, t_end, values, modes, dependent } = segment;
        let own = Segment {
            t0: *t,
            t1: *t_end,
            values: values.clone(),
            modes: modes.clone(),
            dependent: dependent.iter().map(|&row| row as usize).collect(),
        };
        if let Some(last) = self.last.take()
            && self.is_inside(own.t0)
            && self.jumps(&last, &own)
        {
            self.draw_at(&last, last.t1)?;
            self.draw_at(&own, own.t0)?;
        }
        let forward = (self.span[1] - self.span[0]).signum();
        while self.next <= self.n_instants && (self.instant(self.next) - own.t1) * forward < 0.0 {
            let t = self.instant(self.next);
            // What lies before the first segment has no value.
            if own.contains(t) {
                self.draw_at(&own, t)?;
            }
            self.next += 1;
        }
        self.last = Some(own);
        Ok(())
    }

    /// The end of the last segment belongs to no other.
    fn finish(&mut self) -> Result<(), String> {
        let Some(last) = self.last.take() else { return Ok(()) };
        let forward = (self.span[1] - self.span[0]).signum();
        let end = if (self.span[1] - last.t1) * forward < 0.0 { self.span[1] } else { last.t1 };
        if self.is_inside(end) && last.contains(end) { self.draw_at(&last, end) } else { Ok(()) }
    }

    fn jumps(&mut self, last: &Segment, own: &Segment) -> bool {
        if last.modes != own.modes || last.dependent != own.dependent || last.t1 != own.t0 {
            return true;
        }
        let n = self.states[0].len();
        let is_whole = |segment: &Segment| n > 0 && segment.values.len().is_multiple_of(n);
        if !is_whole(last) || !is_whole(own) {
            return false;
        }
        let [before, after] = &mut self.states;
        last.at(last.t1, before);
        own.at(own.t0, after);
        before.iter().zip(after).any(|(a, b)| (*a - *b).abs() > JUMP * a.abs().max(1.0))
    }

    fn draw_at(&mut self, segment: &Segment, t: f64) -> Result<(), String> {
        let sample = self.replay.at(segment, t).map_err(|e| e.to_string())?;
        (self.draw)(sample);
        Ok(())
    }
}
