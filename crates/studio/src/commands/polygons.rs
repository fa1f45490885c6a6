//! `bksim polygons` with a picture: both polygons next to each other, the vectors listed below.

mod labels;

use std::path::Path;

use bksim::analysis::{Polygon, PolygonVector, Polygons, VectorPart};
use bksim_cli::args::analysis::Polygons as Args;
use bksim_cli::commands::analysis::polygons::{run as answer, vector_name};
use bksim_cli::exit::{Failure, Status};
use bksim_cli::output::number;
use bksim_plot::{Format, Size, convert};
use bksim_scene::{Align, Color, Item, Picture, Stroke, Theme, titled_svg};

use self::labels::Labels;

/// Width and height of the area of a polygon, px.
const AREA: [f32; 2] = [480.0, 420.0];
/// Space around a polygon in its area, px.
const MARGIN: f32 = 56.0;
/// Height of the title of a polygon, and of a row of its list, px.
const TITLE: f32 = 34.0;
const ROW: f32 = 20.0;
/// Height of letters, px.
const TEXT: f32 = 13.0;

/// Draws the polygons that are asked for.
pub(crate) fn run(args: &Args, path: &Path, json: bool, nesting: usize) -> Result<Status, Failure> {
    let format = Format::of(path);
    let draw = |name: &str, found: &Polygons| {
        let picture = picture(found);
        let [width, height] = picture.size.map(f64::from);
        let drawn = convert(&titled_svg(&picture, name), format, Size { width, height }, name);
        drawn.map_err(|error| Failure::file(path, format!("cannot be drawn: {error}"), None))
    };
    answer(args, Some(&draw), json, nesting)
}

/// Both polygons.
fn picture(found: &Polygons) -> Picture {
    let theme = Theme::LIGHT;
    let polygons = [
        (&found.velocity, "velocities", "v", "m/s"),
        (&found.acceleration, "accelerations", "a", "m/s²"),
    ];
    let n_rows = polygons.iter().map(|(polygon, ..)| polygon.vectors.len()).max().unwrap_or(0);
    let height = TITLE + AREA[1] + ROW * (n_rows as f32 + 1.5);
    let mut items = Vec::new();
    for (k, (polygon, title, letter, unit)) in polygons.into_iter().enumerate() {
        let drawn = Drawn { left: k as f32 * AREA[0], theme: &theme, polygon, letter, unit };
        items.extend(drawn.items(title));
    }
    Picture { size: [2.0 * AREA[0], height], background: Some(theme.background), items }
}

/// One polygon at its place in the picture.
struct Drawn<'a> {
    left: f32,
    theme: &'a Theme,
    polygon: &'a Polygon,
    letter: &'a str,
    unit: &'a str,
}

/// From the plane of a polygon to the picture.
struct Map {
    scale: f64,
    /// The value in the middle of the area.
    middle: [f64; 2],
    centre: [f32; 2],
}

impl Map {
    #[expect(clippy::cast_possible_truncation, reason = "pixels")]
    fn at(&self, p: [f64; 2]) -> [f32; 2] {
        let [dx, dy] = [0, 1].map(|i| (self.scale * (p[i] - self.middle[i])) as f32);
        [self.centre[0] + dx, self.centre[1] - dy]
    }
}

impl Drawn<'_> {
    fn items(&self, title: &str) -> Vec<Item> {
        let mut items = vec![self.text([self.left + 16.0, 24.0], title, 1.15 * TEXT)];
        let Some(map) = self.map() else {
            let at = [self.left + 16.0, TITLE + 20.0];
            items.push(self.text(at, "nothing moves", TEXT));
            return items;
        };
        // Arrows, then points, then names where there is room.
        for vector in &self.polygon.vectors {
            items.extend(self.arrow(&map, vector));
        }
        let pole = map.at([0.0; 2]);
        items.extend(self.dot(pole));
        for vertex in &self.polygon.vertices {
            items.extend(self.dot(map.at(vertex.at)));
        }
        items.extend(self.names(&map));
        items.extend(self.scale_bar(&map));
        items.extend(self.list());
        items
    }

    /// The map that puts all vectors into the area.
    fn map(&self) -> Option<Map> {
        let vertices = self.polygon.vertices.iter().map(|vertex| vertex.at);
        let vectors = self.polygon.vectors.iter().flat_map(|vector| [vector.from, vector.to]);
        let (mut low, mut high) = ([0.0_f64; 2], [0.0_f64; 2]);
        for p in vertices.chain(vectors) {
            for i in 0..2 {
                (low[i], high[i]) = (low[i].min(p[i]), high[i].max(p[i]));
            }
        }
        let room = AREA.map(|side| f64::from(side - 2.0 * MARGIN));
        let scale = (room[0] / (high[0] - low[0])).min(room[1] / (high[1] - low[1]));
        let middle = [0, 1].map(|i| 0.5 * (low[i] + high[i]));
        let centre = [self.left + 0.5 * AREA[0], TITLE + 0.5 * AREA[1]];
        (scale.is_finite() && scale > 0.0).then_some(Map { scale, middle, centre })
    }

    fn color(&self, vector: &PolygonVector) -> Color {
        let palette = &self.theme.palette;
        match (vector.part, &vector.of.1) {
            (VectorPart::Whole, None) => palette[0],
            (VectorPart::Whole, Some(_)) => palette[1],
            (VectorPart::Normal, _) => palette[2],
            (VectorPart::Tangential, _) => palette[3],
            (VectorPart::Coriolis, _) => palette[4],
            (VectorPart::Sliding, _) => palette[5],
        }
    }

    fn arrow(&self, map: &Map, vector: &PolygonVector) -> Vec<Item> {
        let [a, b] = [vector.from, vector.to].map(|p| map.at(p));
        let color = self.color(vector);
        let long = (b[0] - a[0]).hypot(b[1] - a[1]);
        if long < 1e-3 {
            return Vec::new();
        }
        let head = 11.0_f32.min(0.6 * long);
        let [ux, uy] = [(b[0] - a[0]) / long, (b[1] - a[1]) / long];
        let neck = [b[0] - head * ux, b[1] - head * uy];
        let half = 0.33 * head;
        let corner = |side: f32| [neck[0] - side * half * uy, neck[1] + side * half * ux];
        let stroke = Stroke { color, width: 1.8 };
        vec![
            Item::Line { points: vec![a, neck], is_closed: false, stroke },
            Item::Region { rings: vec![vec![b, corner(1.0), corner(-1.0)]], fill: color },
        ]
    }

    fn dot(&self, [x, y]: [f32; 2]) -> Vec<Item> {
        let ring = (0..16_u8).map(|k| {
            let (sin, cos) = (f32::from(k) * std::f32::consts::TAU / 16.0).sin_cos();
            [x + 2.6 * cos, y + 2.6 * sin]
        });
        let ring: Vec<[f32; 2]> = ring.collect();
        let stroke = Stroke { color: self.theme.text, width: 1.2 };
        vec![
            Item::Region { rings: vec![ring.clone()], fill: self.theme.background },
            Item::Line { points: ring, is_closed: true, stroke },
        ]
    }

    /// Names of points, then of vectors; those of vectors only where nothing is hidden: the list has them all.
    fn names(&self, map: &Map) -> Vec<Item> {
        let lines = self.polygon.vectors.iter().map(|v| [map.at(v.from), map.at(v.to)]).collect();
        let area = [self.left + 4.0, TITLE, self.left + AREA[0] - 4.0, TITLE + AREA[1] - 30.0];
        let mut labels = Labels::new(area, TEXT, lines);
        let mut items = Vec::new();
        let prime = if self.letter == "a" { "'" } else { "" };
        let pole = ("o".to_owned(), [0.0; 2]);
        let short = |name: &str| {
            let word = |name: &str| {
                let (joint, rest) = name.split_once(' ').unwrap_or((name, ""));
                let last = joint.rsplit('.').next().unwrap_or(joint).to_lowercase();
                if rest.is_empty() { last } else { format!("{last} {rest}") }
            };
            let own = word(name);
            let twins =
                self.polygon.vertices.iter().filter(|other| word(&other.name) == own).count();
            if twins > 1 || own == "o" { name.to_owned() } else { own }
        };
        // Points at one place share a name.
        let mut named: Vec<(String, [f64; 2])> = vec![pole];
        for vertex in &self.polygon.vertices {
            let name = short(&vertex.name);
            let near = |(_, at): &&mut (String, [f64; 2])| {
                (at[0] - vertex.at[0]).hypot(at[1] - vertex.at[1]) * map.scale < 1.0
            };
            match named.iter_mut().find(near) {
                Some((known, _)) => known.extend([", ", name.as_str()]),
                None => named.push((name, vertex.at)),
            }
        }
        for (_, at) in &named {
            labels.keep_free(map.at(*at));
        }
        for (name, at) in named {
            let text = format!("{name}{prime}");
            if let Some(at) = labels.beside(map.at(at), &text) {
                items.push(self.text(at, &text, TEXT));
            }
        }
        for vector in &self.polygon.vectors {
            let text = vector_name(self.letter, vector);
            let ends = [vector.from, vector.to].map(|p| map.at(p));
            if let Some(at) = labels.along(ends, &text) {
                items.push(Item::Text {
                    at,
                    align: Align::Start,
                    text,
                    size: 0.92 * TEXT,
                    color: self.color(vector),
                });
            }
        }
        items
    }

    /// A bar of a round value below the polygon.
    fn scale_bar(&self, map: &Map) -> Vec<Item> {
        let most = 0.3 * f64::from(AREA[0]) / map.scale;
        let ten = 10f64.powf(most.log10().floor());
        let value = [5.0, 2.0, 1.0].into_iter().find(|f| f * ten <= most).unwrap_or(1.0) * ten;
        #[expect(clippy::cast_possible_truncation, reason = "pixels")]
        let width = (value * map.scale) as f32;
        let (x, y) = (self.left + 16.0, TITLE + AREA[1] - 8.0);
        let stroke = Stroke { color: self.theme.faint, width: 1.5 };
        let points = vec![[x, y - 4.0], [x, y], [x + width, y], [x + width, y - 4.0]];
        let text = format!("{} {}", number(value), self.unit);
        vec![
            Item::Line { points, is_closed: false, stroke },
            self.text([x + width + 8.0, y], &text, 0.92 * TEXT),
        ]
    }

    /// The vectors with their values and directions.
    fn list(&self) -> Vec<Item> {
        let mut items = Vec::new();
        for (k, vector) in self.polygon.vectors.iter().enumerate() {
            let y = TITLE + AREA[1] + ROW * (k as f32 + 1.0);
            let x = self.left + 16.0;
            let stroke = Stroke { color: self.color(vector), width: 2.5 };
            let points = vec![[x, y - 4.0], [x + 16.0, y - 4.0]];
            items.push(Item::Line { points, is_closed: false, stroke });
            let d = [vector.to[0] - vector.from[0], vector.to[1] - vector.from[1]];
            let size = format!("{} {}", brief(d[0].hypot(d[1])), self.unit);
            let angle = format!("{}°", brief(d[1].atan2(d[0]).to_degrees()));
            let name = vector_name(self.letter, vector);
            for (column, text) in [(26.0, name), (250.0, size), (380.0, angle)] {
                items.push(self.text([x + column, y], &text, TEXT));
            }
        }
        items
    }

    fn text(&self, at: [f32; 2], text: &str, size: f32) -> Item {
        let color = self.theme.text;
        Item::Text { at, align: Align::Start, text: text.to_owned(), size, color }
    }
}

/// Five digits are enough to read.
fn brief(x: f64) -> String {
    let rounded = format!("{x:.4e}").parse::<f64>().unwrap_or(x);
    number(rounded)
}
