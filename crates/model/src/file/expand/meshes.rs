//! `shapes = [{ type = "mesh", file = "part.stl" }]`: corners and faces from a file of STL or OBJ.
//!
//! The contents of the file become `corners` and `faces` of the shape, as an author may write them too.

use std::fmt::Write;
use std::io::Cursor;

use super::super::codes;
use super::super::tree::{Entry, Node, Table, Value};
use super::uses::beside;
use super::{Expander, Unopened};
use crate::diagnostic::{Diagnostic, Span};
use crate::mesh::Mesh;

/// Bytes of a binary STL file before its triangles, and of each triangle.
const STL_BYTES: [usize; 2] = [84, 50];

/// The faces that a mesh may have: each is painted in each picture.
pub(crate) const MOST_FACES: usize = 20_000;

/// True of shapes with a file.
pub(super) fn is_of_file(body: &Table) -> bool {
    let Some(Node { value: Value::Array(shapes), .. }) = body.get("shapes").map(|e| &e.node) else {
        return false;
    };
    shapes.iter().any(|shape| shape.table().is_some_and(|keys| keys.get("file").is_some()))
}

impl Expander<'_> {
    /// Puts the corners and faces of other files into the shapes that name them.
    pub(super) fn read_meshes(&mut self, root: &mut Table, by: &str) {
        for section in &mut root.entries {
            let Value::Table(table) = &mut section.node.value else { continue };
            match section.key.as_str() {
                "ground" => self.meshes_of("ground", table, by),
                "bodies" => {
                    for Entry { key, node, .. } in &mut table.entries {
                        if let Value::Table(body) = &mut node.value {
                            self.meshes_of(key, body, by);
                        }
                    }
                }
                _ => (),
            }
        }
    }

    fn meshes_of(&mut self, body: &str, keys: &mut Table, by: &str) {
        let Some(shapes) = keys.get_mut("shapes") else { return };
        let Value::Array(shapes) = &mut shapes.node.value else { return };
        for shape in shapes {
            let Value::Table(keys) = &mut shape.value else { continue };
            let Some(place) = keys.entries.iter().position(|entry| entry.key == "file") else {
                continue;
            };
            let file = keys.entries.remove(place);
            if let Some(own) = keys.get("corners").or(keys.get("faces")) {
                self.report(
                    Diagnostic::error(
                        codes::KEY_CONFLICT,
                        format!(
                            "`file` and `{}` of a mesh of `{body}` exclude each other",
                            own.key
                        ),
                    )
                    .at(file.key_span, "")
                    .help("keep one of them"),
                );
                continue;
            }
            let Some([corners, faces]) = self.mesh_of(body, &file.node, by) else { continue };
            for (key, node) in [("corners", corners), ("faces", faces)] {
                let key_span = file.key_span.clone();
                keys.entries.push(Entry { key: key.to_owned(), key_span, node });
            }
        }
    }

    /// The corners and faces of a file.
    fn mesh_of(&mut self, body: &str, node: &Node, by: &str) -> Option<[Node; 2]> {
        let Value::Text(file) = &node.value else {
            self.report(
                Diagnostic::error(
                    codes::WRONG_KIND,
                    format!("`file` of a mesh of `{body}` is no text"),
                )
                .at(node.span.clone(), "the name of a file, in quotes")
                .help("write for example `file = \"part.stl\"`"),
            );
            return None;
        };
        let path = beside(by, file);
        let found = self.opened(&path).and_then(|bytes| mesh_in(&path, &bytes));
        let mesh = match found {
            Ok(mesh) => mesh,
            Err(Unopened { why, help }) => {
                let usual = "name a file of STL or OBJ in the folder of the model, or below it";
                self.report(
                    Diagnostic::error(codes::BAD_MESH, format!("the mesh `{path}` {why}"))
                        .at(node.span.clone(), "this file")
                        .help(help.unwrap_or_else(|| usual.to_owned())),
                );
                return None;
            }
        };
        let n_nodes = 4 * (mesh.corners.len() + mesh.faces.len());
        if !self.pays_for(n_nodes, body, node.span.clone()) {
            return None;
        }
        let mut writer = Writer { text: String::new(), start: self.sources.len() };
        let corners = writer.rows(&mesh.corners);
        let faces = writer.rows(&mesh.faces.iter().map(|face| face.map(index)).collect::<Vec<_>>());
        self.keep(&path, writer.text);
        Some([corners, faces])
    }
}

#[expect(clippy::cast_precision_loss, reason = "below 2^52")]
fn index(corner: usize) -> f64 {
    corner as f64
}

/// Rows of numbers as text and as nodes with their places in it.
struct Writer {
    text: String,
    /// Of the text among all files.
    start: usize,
}

impl Writer {
    fn rows(&mut self, rows: &[[f64; 3]]) -> Node {
        let from = self.text.len();
        let mut nodes = Vec::with_capacity(rows.len());
        for row in rows {
            let from = self.text.len();
            let numbers = row.iter().map(|&value| {
                let from = self.text.len();
                // Counts stand without a fraction.
                let is_written = write!(self.text, "{value}");
                debug_assert!(is_written.is_ok(), "text grows");
                let digits = self.text[from..].trim_start_matches('-').to_owned();
                let span = self.span_from(from);
                self.text.push(' ');
                Node { span, value: Value::Number { value, digits } }
            });
            let numbers = numbers.collect();
            nodes.push(Node { span: self.span_from(from), value: Value::Array(numbers) });
            self.text.push('\n');
        }
        Node { span: self.span_from(from), value: Value::Array(nodes) }
    }

    fn span_from(&self, from: usize) -> Span {
        self.start + from..self.start + self.text.len()
    }
}

/// The triangles of an STL or OBJ file, by the ending of its name.
///
/// # Errors
/// The reason why there are none, worded to follow the file's name.
pub fn triangles(path: &str, bytes: &[u8]) -> Result<Vec<[[f64; 3]; 3]>, String> {
    read(path, bytes).map_err(|unopened| unopened.why)
}

/// The triangles of a file by the ending of its name.
fn read(path: &str, bytes: &[u8]) -> Result<Vec<Triangle>, Unopened> {
    let ending = path.rsplit('.').next().unwrap_or_default().to_ascii_lowercase();
    match ending.as_str() {
        "stl" => stl(bytes),
        "obj" => obj(bytes).map_err(damaged),
        _ => Err("is neither STL nor OBJ by the ending of its name".into()),
    }
}

/// The mesh of a file by the ending of its name; why there is none, worded to follow the file's name.
fn mesh_in(path: &str, bytes: &[u8]) -> Result<Mesh, Unopened> {
    let triangles = read(path, bytes)?;
    if triangles.is_empty() {
        return Err("has no faces".into());
    }
    if triangles.len() > MOST_FACES {
        let n = triangles.len();
        return Err(format!(
            "has {n} faces; {MOST_FACES} are possible, so let its program simplify it"
        )
        .into());
    }
    if triangles.iter().flatten().flatten().any(|x| !x.is_finite()) {
        return Err("has a corner that is no place".into());
    }
    Ok(Mesh::of_triangles(triangles))
}

type Triangle = [[f64; 3]; 3];

/// The triangles of an STL file. It is binary if its length is that of the triangles that it counts: some binary
/// files begin with the word of the others.
fn stl(bytes: &[u8]) -> Result<Vec<Triangle>, Unopened> {
    let [head, each] = STL_BYTES;
    let counted = bytes.get(head - 4..head).and_then(|count| count.try_into().ok());
    let n_counted = counted.map(|count| u32::from_le_bytes(count) as usize);
    let length = n_counted.and_then(|n| n.checked_mul(each)?.checked_add(head));
    let is_text = bytes.starts_with(b"solid");

    // Trailing bytes occur, missing ones are a damage.
    if length.is_some_and(|length| length == bytes.len() || length < bytes.len() && !is_text) {
        let nameless = [&[0; STL_BYTES[0] - 4], &bytes[head - 4..]].concat();
        return read_stl(nameless);
    }
    if !is_text {
        return Err(cut_short(bytes.len(), n_counted, length));
    }
    // The reader asks for a name after the first word.
    read_stl([b"solid ", &bytes[b"solid".len()..]].concat())
}

/// The fault of a binary file that is shorter than its faces.
fn cut_short(n_bytes: usize, n_faces: Option<usize>, length: Option<usize>) -> Unopened {
    let why = match (n_faces, length) {
        (Some(n_faces), Some(length)) => format!(
            "ends at byte {n_bytes}: the {n_faces} faces that it counts would end at byte {length}"
        ),
        _ => format!(
            "ends at byte {n_bytes}, before the count of its faces at byte {}",
            STL_BYTES[0]
        ),
    };
    damaged(why)
}

/// The fault of a file that its program did not write whole.
fn damaged(why: String) -> Unopened {
    let help = "export the mesh again, as binary STL, text that begins with `solid`, or OBJ";
    Unopened { why, help: Some(help.to_owned()) }
}

fn read_stl(bytes: Vec<u8>) -> Result<Vec<Triangle>, Unopened> {
    let (n_bytes, n_lines) = (bytes.len(), bytes.split(|byte| *byte == b'\n').count());
    let why = |error: std::io::Error| {
        let why = error.to_string();
        damaged(match why.split_once("EOF while expecting ") {
            Some((_, what)) => format!("ends in line {n_lines}, byte {n_bytes}, before a {what}"),
            None => format!("cannot be read: {why}"),
        })
    };
    let mut cursor = Cursor::new(bytes);
    let read = stl_io::create_stl_reader(&mut cursor).map_err(why)?;
    let triangles: Result<Vec<_>, _> = read.map(|triangle| triangle.map(exact)).collect();
    triangles.map_err(why)
}

/// The corners of a triangle as the decimal numbers that they were written as.
fn exact(triangle: stl_io::Triangle) -> Triangle {
    let number = |x: f32| x.to_string().parse().unwrap_or(f64::NAN);
    triangle.vertices.map(|corner| corner.0.map(number))
}

/// The triangles of an OBJ file: of its lines those of corners and of faces, which are cut into fans.
fn obj(bytes: &[u8]) -> Result<Vec<Triangle>, String> {
    let text = std::str::from_utf8(bytes).map_err(|_| "is no text".to_owned())?;
    let mut corners: Vec<[f64; 3]> = Vec::new();
    let mut triangles = Vec::new();
    for (line_idx, line) in text.lines().enumerate() {
        let at = |what: &str| format!("has {what} in line {}", line_idx + 1);
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let mut number = || words.next()?.parse().ok();
                let corner = number().zip(number()).zip(number());
                let ((x, y), z) = corner.ok_or_else(|| at("no three numbers"))?;
                corners.push([x, y, z]);
            }
            Some("f") => {
                let ring: Option<Vec<[f64; 3]>> =
                    words.map(|word| corner_of(&corners, word)).collect();
                let ring = ring.ok_or_else(|| at("a face of corners that it does not have"))?;
                let [first, rest @ ..] = ring.as_slice() else { return Err(at("an empty face")) };
                if rest.len() < 2 {
                    return Err(at("a face with fewer than three corners"));
                }
                triangles.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
            }
            _ => (),
        }
    }
    Ok(triangles)
}

/// The corner that `7/1/2` names: counted from 1, or back from the last.
fn corner_of(corners: &[[f64; 3]], word: &str) -> Option<[f64; 3]> {
    let number: i64 = word.split('/').next()?.parse().ok()?;
    let place = match usize::try_from(number) {
        Ok(number) => number.checked_sub(1)?,
        Err(_) => corners.len().checked_sub(usize::try_from(number.unsigned_abs()).ok()?)?,
    };
    corners.get(place).copied()
}
