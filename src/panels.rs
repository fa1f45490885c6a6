//! [`Sheet`]: small pictures of one mechanism next to each other, such as all its assemblies.
//!
//! As SVG, motions move: their frames lie on each other, and a style sheet shows one after the other. Elsewhere both ends of a
//! motion are drawn as ghosts.

use std::fmt::Write;

use bksim_analysis::{Mark, Panel, Panels};
use bksim_scene::{
    Align, Arrow, Camera, Color, Extras, Item, Picture, Scene, Theme, picture, svg, titled_svg,
};
use bksim_sim::pose::Pose;

/// Width and height of a panel below its title, px.
const AREA: [f32; 2] = [300.0, 230.0];
/// Height of a title, px; letters that fit into a line of it, and their height.
const TITLE: f32 = 40.0;
const LETTERS: usize = 44;
const TEXT: f32 = 12.0;
/// Panels next to each other.
const COLUMNS: usize = 3;
/// Space around a mechanism, part of its panel.
const MARGIN: f64 = 0.12;
/// Azimuth and elevation of the view of a spatial mechanism, degrees.
const VIEW: [f64; 2] = [35.0, 25.0];
/// Seconds that a motion to and fro takes.
const PERIOD_S: f64 = 2.0;
/// Length of an arrow, px.
const ARROW: f64 = 48.0;

/// Panels with the scene and the camera that they share.
#[derive(Clone, Debug)]
pub struct Sheet<'a> {
    panels: &'a [Panel],
    scene: Scene,
    camera: Camera,
    theme: Theme,
}

impl<'a> Sheet<'a> {
    /// All panels seen alike: the camera takes in every pose.
    pub fn of(panels: &'a Panels, theme: Theme) -> Self {
        let Panels { model, parameters, panels } = panels;
        let motion: Vec<Vec<Pose>> = panels.iter().flat_map(|p| p.frames.iter().cloned()).collect();
        let scene = Scene::of_motion(model, parameters, &motion);
        let size = AREA.map(f64::from);
        let camera = if scene.is_planar {
            Camera::planar(size)
        } else {
            let [azimuth, elevation] = VIEW.map(f64::to_radians);
            Camera::spatial(size, azimuth, elevation)
        };
        let points = motion.iter().flat_map(|poses| outermost(&scene, poses));
        let camera = camera.fitted(points.collect::<Vec<_>>(), MARGIN);
        Self { panels, scene, camera, theme }
    }

    /// Width and height, px.
    fn size(&self) -> [f32; 2] {
        let n = self.panels.len().max(1);
        let (columns, rows) = (n.min(COLUMNS), n.div_ceil(COLUMNS));
        [columns as f32 * AREA[0], rows as f32 * (AREA[1] + TITLE)]
    }

    /// The upper left corner of a panel.
    fn corner(k: usize) -> [f32; 2] {
        [(k % COLUMNS) as f32 * AREA[0], (k / COLUMNS) as f32 * (AREA[1] + TITLE)]
    }

    /// The title of a panel, in at most two lines.
    fn title(&self, k: usize) -> Vec<Item> {
        let [x, y] = Self::corner(k);
        let line = |(row, text): (usize, String)| Item::Text {
            at: [x + 12.0, y + 16.0 + row as f32 * 1.3 * TEXT],
            align: Align::Start,
            text,
            size: TEXT,
            color: self.theme.text,
        };
        wrapped(&self.panels[k].title).into_iter().enumerate().map(line).collect()
    }

    /// A frame of a panel, in the panel's own place.
    fn frame(&self, panel: &Panel, poses: &[Pose], ghosts: Vec<Vec<Pose>>) -> Picture {
        let arrows = panel.marks.iter().map(|mark| self.arrow(mark)).collect();
        let extras = Extras { arrows, ghosts, has_labels: true, ..Extras::default() };
        picture(&self.scene, poses, &extras, &self.camera, &self.theme)
    }

    /// A condition as an arrow: solid where others keep it already, hollow where it is one of these.
    fn arrow(&self, mark: &Mark) -> Arrow {
        let long = ARROW / self.camera.scale;
        let color: Color = self.theme.palette[if mark.is_moment { 4 } else { 1 }];
        let vector = mark.along.map(|x| long * x);
        Arrow { color, from: mark.at, vector, is_hollow: !mark.is_repeated }
    }

    /// All panels in one picture; of a motion both ends are ghosts.
    pub fn still(&self) -> Picture {
        let mut items = Vec::new();
        for (k, panel) in self.panels.iter().enumerate() {
            let Some(first) = panel.frames.first() else { continue };
            let n = panel.frames.len();
            let ends: &[usize] = if n > 1 { &[n / 4, 3 * n / 4] } else { &[] };
            let ghosts = ends.iter().map(|&frame| panel.frames[frame].clone()).collect();
            let [x, y] = Self::corner(k);
            let drawn = self.frame(panel, first, ghosts);
            items.extend(drawn.items.into_iter().map(|item| moved(item, [x, y + TITLE])));
            items.extend(self.title(k));
        }
        Picture { size: self.size(), background: Some(self.theme.background), items }
    }

    /// An SVG with this title, in which motions move.
    pub fn moving(&self, name: &str) -> String {
        let titles = (0..self.panels.len()).flat_map(|k| self.title(k)).collect();
        let background = Some(self.theme.background);
        let mut text = titled_svg(&Picture { size: self.size(), background, items: titles }, name);
        text.truncate(text.rfind("</svg>").unwrap_or(text.len()));
        let n = self.panels.iter().map(|panel| panel.frames.len()).max().unwrap_or(1);
        if n > 1 {
            text.push_str(&style(n));
        }
        for (k, panel) in self.panels.iter().enumerate() {
            let [x, y] = Self::corner(k);
            for (frame, poses) in panel.frames.iter().enumerate() {
                let drawn = self.frame(panel, poses, Vec::new());
                let drawn = svg(&Picture { background: None, ..drawn });
                let class = match panel.frames.len() {
                    1 => String::new(),
                    n => {
                        let delay = PERIOD_S * frame as f64 / n as f64;
                        format!(r#" class="f" style="animation-delay:{delay:.4}s""#)
                    }
                };
                let place = format!(r#"transform="translate({x} {})""#, y + TITLE);
                text.extend(["<g ", &place, &class, ">\n", &drawn, "</g>\n"]);
            }
        }
        text.push_str("</svg>\n");
        text
    }
}

/// The style sheet that shows one of `n` frames after the other; the first stands where nothing moves.
fn style(n: usize) -> String {
    let share = 100.0 / n as f64;
    let mut text = String::from("<style>\n.f{visibility:hidden}\n");
    let _ = writeln!(text, ".f{{animation:f {PERIOD_S}s step-end infinite}}");
    let _ = writeln!(
        text,
        "@keyframes f{{0%{{visibility:visible}}{share:.4}%{{visibility:hidden}}}}\n</style>"
    );
    text
}

/// Words in at most two lines.
fn wrapped(title: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in title.split_inclusive(' ') {
        let last = lines.len() - 1;
        let is_full = lines[last].chars().count() + word.trim_end().chars().count() > LETTERS;
        if is_full && !lines[last].is_empty() && last == 0 {
            lines.push(word.to_owned());
        } else {
            lines[last].push_str(word);
        }
    }
    lines
}

/// The outermost points of all shapes in a pose.
fn outermost(scene: &Scene, poses: &[Pose]) -> Vec<[f64; 3]> {
    let shapes = scene.shapes.iter().flat_map(|shape| {
        let pose = &poses[shape.body];
        shape.form.reach().into_iter().map(move |p| pose.place(p))
    });
    let spans = scene.spans.iter().flat_map(|span| span.ends);
    let spans = spans.map(|end| poses[end.body].place(end.position));
    shapes.chain(spans).filter(|p| p.iter().all(|x| x.is_finite())).collect()
}

/// An item at another place.
fn moved(item: Item, [dx, dy]: [f32; 2]) -> Item {
    let at = |[x, y]: [f32; 2]| [x + dx, y + dy];
    let all = |points: Vec<[f32; 2]>| -> Vec<[f32; 2]> { points.into_iter().map(at).collect() };
    match item {
        Item::Region { rings, fill } => {
            Item::Region { rings: rings.into_iter().map(all).collect(), fill }
        }
        Item::Line { points, is_closed, stroke } => {
            Item::Line { points: all(points), is_closed, stroke }
        }
        Item::Text { at: place, align, text, size, color } => {
            Item::Text { at: at(place), align, text, size, color }
        }
    }
}
