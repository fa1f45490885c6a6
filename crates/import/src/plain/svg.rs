//! SVG as a [`Sheet`]: what the shapes of a picture show, in millimetres where it says how large it is, y up.
//!
//! Groups, `use`, transforms and styles are resolved. Curves of Bézier that are parts of a circle but for their thickness
//! are arcs: programs that draw know no others. A filling with a pattern is a hatching.

use std::collections::HashMap;
use std::str::FromStr as _;

use bksim_cad::drawing::{Handle, Location};
use bksim_cad::geometry::{Affine, Path, Point};
use bksim_cad::read::{Dash, Drawn, Filled, Sheet, Words, pattern};
use bksim_model::diagnostic::Diagnostic;
use roxmltree::{Document, Node, ParsingOptions};
use svgtypes::{Length, LengthUnit, NumberListParser, Paint, Transform, ViewBox};

use super::outlines;
use crate::codes;
use crate::xml;

/// Most elements, those that `use` repeats included, and how deep these may be.
const MAX_ELEMENTS: usize = 50_000;
const MAX_DEPTH: usize = 64;
/// Pixels of a millimetre.
const PER_MM: f64 = 96.0 / 25.4;
/// Part by which the numbers of a map are rounded, so that a turned circle stays one.
const ROUNDED: f64 = 1e-4;
/// Height of capital letters by the size of their font.
const CAPITALS: f64 = 0.7;

/// How an area is filled.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Fill {
    /// Not, or in white, which hides what is below.
    None,
    Solid,
    Pattern,
}

/// All that an element takes over from those around it.
#[derive(Clone)]
struct Scope {
    map: Affine,
    fill: Fill,
    has_stroke: bool,
    stroke_width: f64,
    dashes: Vec<f64>,
    /// Arrows at the beginning and at the end of lines.
    arrows: [bool; 2],
    font_size: f64,
    /// Part of a text that is before its place.
    anchor: f64,
    depth: usize,
}

struct Reader<'d> {
    document: &'d Document<'d>,
    styles: simplecss::StyleSheet<'d>,
    ids: HashMap<&'d str, Node<'d, 'd>>,
    sheet: Sheet,
    n_shapes: u64,
}

/// The sheet of a picture, and true if its size on paper is known: then it is in millimetres, else in its own units.
pub(super) fn read(text: &str, takes_own_unit: bool) -> Result<(Sheet, bool), Vec<Diagnostic>> {
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| {
        let (at, message) = xml::fault_of(text, &error);
        let fault = Diagnostic::error(codes::NOT_XML, message).at(at..at, "");
        vec![fault.help("mend the file here: each element is closed, each value is in quotes")]
    })?;
    let all = || document.descendants().filter(Node::is_element);
    let mut styles = simplecss::StyleSheet::new();
    for style in all().filter(|node| is(*node, "style")) {
        style.text().into_iter().for_each(|rules| styles.parse_more(rules));
    }
    let ids = all().filter_map(|node| Some((node.attribute("id")?, node))).collect();
    let mut reader =
        Reader { document: &document, styles, ids, sheet: Sheet::default(), n_shapes: 0 };
    let (map, has_size) = page(document.root_element(), takes_own_unit);
    reader.walk(map);
    Ok((reader.sheet, has_size))
}

/// Map of the units of a picture to those of the sheet, and true if these are millimetres.
fn page(root: Node<'_, '_>, takes_own_unit: bool) -> (Affine, bool) {
    let size = ["width", "height"].map(|key| {
        let length = root.attribute(key).and_then(|value| Length::from_str(value).ok());
        length.filter(|length| {
            !matches!(length.unit, LengthUnit::None | LengthUnit::Px | LengthUnit::Percent)
        })
    });
    let size = size.map(|length| length.and_then(|length| pixels(length, 0.0)));
    let window = root.attribute("viewBox").and_then(|value| ViewBox::from_str(value).ok());
    let own = window.map(|window| [window.w, window.h]);
    let scales = [0, 1].map(|k| {
        let size = size[k]?;
        Some(own.map_or(1.0, |own| size / own[k]) / PER_MM)
    });
    let scale = match scales {
        [Some(x), Some(y)] => Some(x.min(y)),
        [x, y] => x.or(y),
    };
    let scale = scale.filter(|scale| !takes_own_unit && scale.is_finite() && *scale > 0.0);
    let [left, bottom] = match (window, size[1]) {
        (Some(window), _) => [window.x, window.y + window.h],
        (None, height) => [0.0, height.unwrap_or_default()],
    };
    let by = scale.unwrap_or(1.0);
    let map = Affine { x: [by, 0.0], y: [0.0, -by], origin: [-by * left, by * bottom] };
    (map, scale.is_some())
}

/// A length in pixels; `None` of parts of what is around.
fn pixels(length: Length, font_size: f64) -> Option<f64> {
    let unit = match length.unit {
        LengthUnit::None | LengthUnit::Px => 1.0,
        LengthUnit::Mm => PER_MM,
        LengthUnit::Cm => 10.0 * PER_MM,
        LengthUnit::In => 96.0,
        LengthUnit::Pt => 96.0 / 72.0,
        LengthUnit::Pc => 16.0,
        LengthUnit::Em => font_size,
        LengthUnit::Ex => 0.5 * font_size,
        LengthUnit::Percent => return None,
    };
    Some(length.number * unit)
}

/// A map with few digits that is a similarity but for them, as one.
fn similar(map: Affine) -> Affine {
    let sense = map.determinant().signum();
    let x = [0.5 * (map.x[0] + sense * map.y[1]), 0.5 * (map.x[1] - sense * map.y[0])];
    let off = [map.x[0] - x[0], map.x[1] - x[1]];
    if off[0].hypot(off[1]) > ROUNDED * x[0].hypot(x[1]) {
        return map;
    }
    Affine { x, y: [-sense * x[1], sense * x[0]], origin: map.origin }
}

fn is(node: Node<'_, '_>, name: &str) -> bool {
    node.tag_name().name() == name
}

/// An element as rules of styles see it.
struct Styled<'d>(Node<'d, 'd>);

impl simplecss::Element for Styled<'_> {
    fn parent_element(&self) -> Option<Self> {
        self.0.parent_element().map(Self)
    }

    fn prev_sibling_element(&self) -> Option<Self> {
        self.0.prev_sibling_element().map(Self)
    }

    fn has_local_name(&self, name: &str) -> bool {
        is(self.0, name)
    }

    fn attribute_matches(&self, name: &str, operator: simplecss::AttributeOperator<'_>) -> bool {
        self.0.attribute(name).is_some_and(|value| operator.matches(value))
    }

    fn pseudo_class_matches(&self, class: simplecss::PseudoClass<'_>) -> bool {
        class == simplecss::PseudoClass::FirstChild && self.0.prev_sibling_element().is_none()
    }
}

impl<'d> Reader<'d> {
    /// Reads all that is shown, in the order of the file.
    fn walk(&mut self, map: Affine) {
        let scope = Scope {
            map,
            fill: Fill::Solid,
            has_stroke: false,
            stroke_width: 1.0,
            dashes: Vec::new(),
            arrows: [false; 2],
            font_size: 16.0,
            anchor: 0.0,
            depth: 0,
        };
        let mut open = vec![(self.document.root_element(), scope)];
        let mut budget = MAX_ELEMENTS;
        while let Some((node, around)) = open.pop() {
            budget = budget.saturating_sub(1);
            if budget == 0 {
                return;
            }
            let tag = node.tag_name().name();
            let is_first = node.parent_element().is_none();
            let (is_shown, mut scope) = self.scope(node, around);
            if !is_shown || scope.depth > MAX_DEPTH {
                continue;
            }
            match tag {
                "svg" | "symbol" if !is_first => scope.map = window(node, &scope),
                "svg" | "g" | "a" | "switch" => (),
                "text" | "tspan" | "textPath" => self.text(node, &scope),
                "use" => {
                    let href = node.attributes().find(|attribute| attribute.name() == "href");
                    let of = href.and_then(|href| href.value().strip_prefix('#'));
                    let shift = ["x", "y"].map(|name| length(node, name, &scope));
                    scope.map =
                        Affine::translation(shift.map(Option::unwrap_or_default)).then(&scope.map);
                    open.extend(of.and_then(|id| self.ids.get(id)).map(|&of| (of, scope)));
                    continue;
                }
                _ => {
                    self.shape(node, &scope);
                    continue;
                }
            }
            // Symbols are shown where they are used.
            let inner = node.children().filter(|child| child.is_element() && !is(*child, "symbol"));
            let inner: Vec<Node<'d, 'd>> = inner.collect();
            open.extend(inner.into_iter().rev().map(|child| (child, scope.clone())));
        }
    }

    /// A property of an element: of its own style, of a rule, or an attribute.
    fn property(&self, node: Node<'d, 'd>, name: &str) -> Option<&'d str> {
        let inline = node.attribute("style").and_then(|style| {
            let all = simplecss::DeclarationTokenizer::from(style);
            all.filter(|of| of.name == name).last().map(|of| of.value)
        });
        let of_rules = || {
            let rules = self.styles.rules.iter().filter(|of| of.selector.matches(&Styled(node)));
            let mut all = rules.flat_map(|rule| &rule.declarations).rev();
            all.find(|of| of.name == name).map(|of| of.value)
        };
        inline.or_else(of_rules).or_else(|| node.attribute(name)).map(str::trim)
    }

    /// Scope of an element within another one, and true if it is shown.
    fn scope(&self, node: Node<'d, 'd>, around: Scope) -> (bool, Scope) {
        let property = |name: &str| self.property(node, name).filter(|value| *value != "inherit");
        let mut scope = Scope { depth: around.depth + 1, ..around };
        if let Some(own) = property("transform").and_then(|of| Transform::from_str(of).ok()) {
            let own = Affine { x: [own.a, own.b], y: [own.c, own.d], origin: [own.e, own.f] };
            scope.map = similar(own.then(&scope.map));
        }
        if let Some(paint) = property("fill").and_then(|value| Paint::from_str(value).ok()) {
            scope.fill = self.fill(&paint);
        }
        if let Some(paint) = property("stroke").and_then(|value| Paint::from_str(value).ok()) {
            scope.has_stroke = !matches!(paint, Paint::None);
        }
        if let Some(dashes) = property("stroke-dasharray") {
            scope.dashes = NumberListParser::from(dashes).map_while(Result::ok).collect();
        }
        let length = |name: &str| {
            property(name)
                .and_then(|value| Length::from_str(value).ok())
                .and_then(|length| pixels(length, scope.font_size))
        };
        scope.stroke_width = length("stroke-width").unwrap_or(scope.stroke_width);
        scope.font_size = length("font-size").unwrap_or(scope.font_size);
        for (arrow, end) in scope.arrows.iter_mut().zip(["marker-start", "marker-end"]) {
            *arrow = property(end).map_or(*arrow, |marker| marker != "none");
        }
        if let Some(anchor) = property("text-anchor") {
            scope.anchor = match anchor {
                "middle" => 0.5,
                "end" => 1.0,
                _ => 0.0,
            };
        }
        let is_hidden = property("display") == Some("none")
            || matches!(property("visibility"), Some("hidden" | "collapse"));
        (!is_hidden, scope)
    }

    fn fill(&self, paint: &Paint<'_>) -> Fill {
        match paint {
            Paint::None => Fill::None,
            Paint::Color(color) if [color.red, color.green, color.blue] == [255; 3] => Fill::None,
            Paint::FuncIRI(id, _) if self.ids.get(id).is_some_and(|of| is(*of, "pattern")) => {
                Fill::Pattern
            }
            _ => Fill::Solid,
        }
    }

    fn location(&mut self, node: Node<'d, 'd>, at: Point) -> Location {
        self.n_shapes += 1;
        let line = self.document.text_pos_at(node.range().start).row as usize;
        Location {
            kind: node.tag_name().name().to_owned(),
            handle: Some(Handle(self.n_shapes)),
            layer: String::new(),
            at,
            lines: Some([line, line]),
        }
    }

    fn shape(&mut self, node: Node<'d, 'd>, scope: &Scope) {
        let length = |name: &str| length(node, name, scope);
        let Some(paths) = outlines::paths(node, &length) else { return };
        let drawn = paths.into_iter().map(|path| path.transformed(&scope.map));
        let (fit, unfit): (Vec<Path>, Vec<Path>) =
            drawn.filter(|path| !path.curves.is_empty()).partition(|path| path.check().is_ok());
        let Some(at) = fit.first().and_then(Path::start_point) else {
            if !unfit.is_empty() {
                let location = self.location(node, [0.0; 2]);
                self.sheet.unread.push(location);
            }
            return;
        };
        let location = self.location(node, at);
        // What is filled without a border is an area, but for dots.
        let is_dot = |path: &Path| path.curves.len() == 1 && path.is_closed;
        let is_area = !scope.has_stroke && !fit.iter().all(is_dot);
        if scope.fill == Fill::Pattern || scope.fill == Fill::Solid && is_area {
            let closed = fit.iter().filter(|path| path.curves.len() > 1 || path.is_closed);
            let borders: Vec<Path> = closed.cloned().collect();
            let has_pattern = scope.fill == Fill::Pattern;
            self.sheet.fills.push(Filled { borders, has_pattern, location: location.clone() });
        }
        if !scope.has_stroke && (scope.fill == Fill::None || is_area) {
            return;
        }
        self.arrows(&fit, scope, &location);
        let dash = dash_of(&scope.dashes);
        let strokes = fit.into_iter().map(|path| Drawn { path, dash, location: location.clone() });
        self.sheet.strokes.extend(strokes);
    }

    /// Arrows at the ends of lines as the triangles that they are.
    fn arrows(&mut self, paths: &[Path], scope: &Scope, location: &Location) {
        let size = 4.0 * scope.stroke_width * scope.map.x[0].hypot(scope.map.x[1]);
        for path in paths.iter().filter(|path| !path.is_closed) {
            let ends = [path.start_point(), path.reversed().start_point()];
            let inner = [
                path.curves.first().map(|curve| curve.point(1.0)),
                path.curves.last().map(|curve| curve.point(0.0)),
            ];
            for ((has_arrow, tip), inner) in scope.arrows.iter().zip(ends).zip(inner) {
                if let (true, Some(tip), Some(inner)) = (has_arrow, tip, inner) {
                    let borders = vec![outlines::arrow(tip, inner, size)];
                    let location = location.clone();
                    self.sheet.fills.push(Filled { borders, has_pattern: false, location });
                }
            }
        }
    }

    fn text(&mut self, node: Node<'d, 'd>, scope: &Scope) {
        let own = node.children().filter(Node::is_text).filter_map(|child| child.text());
        let own: String = own.collect();
        let text = own.split_whitespace().collect::<Vec<_>>().join(" ");
        let place = |at: Node<'d, 'd>, name: &str| {
            let first = NumberListParser::from(at.attribute(name)?).next()?;
            first.ok()
        };
        let place = ["x", "y"].map(|name| {
            let mut around = node.ancestors().take_while(Node::is_element);
            around.find_map(|at| place(at, name)).unwrap_or_default()
        });
        if text.is_empty() {
            return;
        }
        let width = 0.5 * scope.font_size * text.chars().count() as f64;
        let at = scope.map.point([place[0] - scope.anchor * width, place[1]]);
        let height = CAPITALS * scope.font_size * scope.map.y[0].hypot(scope.map.y[1]);
        let location = self.location(node, at);
        self.sheet.words.push(Words { at, text, height, location });
    }
}

/// The length that an attribute is.
fn length(node: Node<'_, '_>, name: &str, scope: &Scope) -> Option<f64> {
    let length = Length::from_str(node.attribute(name)?.trim()).ok()?;
    pixels(length, scope.font_size)
}

/// Map of a picture or a symbol in another one.
fn window(node: Node<'_, '_>, scope: &Scope) -> Affine {
    let number = |name: &str| length(node, name, scope);
    let shift = Affine::translation([number("x").unwrap_or(0.0), number("y").unwrap_or(0.0)]);
    let view = node.attribute("viewBox").and_then(|value| ViewBox::from_str(value).ok());
    let inner = match (view, number("width"), number("height")) {
        (Some(view), Some(width), Some(height)) => {
            let by = (width / view.w).min(height / view.h);
            Affine::translation([-view.x, -view.y]).then(&Affine::scaling(by, by))
        }
        _ => Affine::IDENTITY,
    };
    inner.then(&shift).then(&scope.map)
}

/// Look of a line by its dashes and gaps.
fn dash_of(dashes: &[f64]) -> Dash {
    if dashes.iter().all(|length| *length <= 0.0) {
        return Dash::Solid;
    }
    // An odd number of lengths is taken twice.
    let twice = if dashes.len() % 2 == 1 { 2 } else { 1 };
    let all = dashes.iter().cycle().take(twice * dashes.len()).enumerate();
    pattern(&all.map(|(k, length)| if k % 2 == 0 { *length } else { -*length }).collect::<Vec<_>>())
}
