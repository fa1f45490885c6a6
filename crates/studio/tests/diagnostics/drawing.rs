//! Drawings as lists of their entities, in the words of a CAD program, and as DXF.
//!
//! ```text
//! units mm
//! LWPOLYLINE layer=BK_BODY_arm points="0,0 300,0 300,20 0,20"
//! CIRCLE layer=BK_JOINTS at=10,10 radius=5
//! INSERT block=BK_BODY at=150,10 NAME=arm MASS="2 kg"
//!   1001 BKSIM
//! ```
//!
//! The first line says `units mm`, or `units none`. Then one line is an entity: its type, its properties
//! in lower case, and attributes in upper case. A polyline is closed unless it says `closed=no`.
//! A line that is indented is one more group of the entity above, a code and a value. What stands between
//! `BLOCK name=bolt` and `ENDBLK` is the definition of a block; `LAYER name=old off=yes` is a layer that is not
//! shown.

/// A group of a DXF file: its code and its value.
type Group = (String, String);

/// The drawing of a list, as a DXF file of the release 2000 with nothing else in it.
pub(crate) fn dxf(list: &str) -> Result<String, String> {
    let mut lines = list.lines();
    let unit = lines.next().and_then(|line| line.strip_prefix("units "));
    let unit = match unit.ok_or("the first line must be `units mm`")? {
        "none" => None,
        "inch" => Some("1"),
        "mm" => Some("4"),
        "cm" => Some("5"),
        "m" => Some("6"),
        other => return Err(format!("unknown unit `{other}`")),
    };
    let (mut entities, mut definitions) = (Vec::new(), Vec::new());
    let (mut inserted, mut defined) = (Vec::new(), Vec::new());
    let mut is_in_block = false;
    let mut layers = Vec::new();
    for line in lines {
        if let Some(layer) = line.strip_prefix("LAYER name=") {
            let (name, off) =
                layer.split_once(" off=yes").map_or((layer, false), |(it, _)| (it, true));
            let colour = if off { "-7" } else { "7" };
            layers.extend([group_of("0", "LAYER"), group_of("2", name)]);
            layers.extend([group_of("70", "0"), group_of("62", colour)]);
            continue;
        }
        let groups = if is_in_block { &mut definitions } else { &mut entities };
        if let Some(group) = line.strip_prefix("  ") {
            let (code, value) = group.split_once(' ').unwrap_or((group, ""));
            groups.push(group_of(code, value));
        } else if let Some(name) = line.strip_prefix("BLOCK name=") {
            definitions.extend(block_of(name));
            defined.push(name.to_owned());
            is_in_block = true;
        } else if line == "ENDBLK" {
            groups.extend([group_of("0", line), group_of("8", "0")]);
            is_in_block = false;
        } else {
            add_entity(&words(line), groups, &mut inserted)?;
        }
    }
    for name in inserted {
        // The blocks that have a meaning are known by their names alone.
        if !defined.contains(&name) {
            definitions.extend(block_of(&name));
            definitions.extend([group_of("0", "ENDBLK"), group_of("8", "0")]);
            defined.push(name);
        }
    }
    let mut groups = header(unit);
    if !layers.is_empty() {
        let mut table = vec![group_of("0", "TABLE"), group_of("2", "LAYER")];
        table.append(&mut layers);
        table.push(group_of("0", "ENDTAB"));
        groups.extend(section("TABLES", table));
    }
    groups.extend(section("BLOCKS", definitions));
    groups.extend(section("ENTITIES", entities));
    groups.push(group_of("0", "EOF"));
    Ok(groups.iter().map(|(code, value)| format!("{code}\n{value}\n")).collect::<Vec<_>>().concat())
}

fn group_of(code: &str, value: &str) -> Group {
    (code.to_owned(), value.to_owned())
}

fn section(name: &str, inside: Vec<Group>) -> Vec<Group> {
    let mut groups = vec![group_of("0", "SECTION"), group_of("2", name)];
    groups.extend(inside);
    groups.push(group_of("0", "ENDSEC"));
    groups
}

fn header(unit: Option<&str>) -> Vec<Group> {
    let mut groups = vec![group_of("9", "$ACADVER"), group_of("1", "AC1015")];
    if let Some(unit) = unit {
        groups.extend([group_of("9", "$INSUNITS"), group_of("70", unit)]);
    }
    section("HEADER", groups)
}

/// The beginning of a block's definition.
fn block_of(name: &str) -> [Group; 6] {
    let [x, y] = [group_of("10", "0"), group_of("20", "0")];
    [group_of("0", "BLOCK"), group_of("8", "0"), group_of("2", name), group_of("70", "2"), x, y]
}

/// Words between blanks; `"` holds some together.
fn words(line: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut is_quoted = false;
    for letter in line.chars() {
        match letter {
            '"' => is_quoted = !is_quoted,
            ' ' if !is_quoted => words.push(String::new()),
            _ => words.last_mut().expect("there is one from the start").push(letter),
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Adds the groups of one entity, and the name of the block that it inserts.
fn add_entity(
    words: &[String],
    groups: &mut Vec<Group>,
    inserted: &mut Vec<String>,
) -> Result<(), String> {
    let [kind, rest @ ..] = words else { return Ok(()) };
    let pair = |word: &'_ String| {
        let (key, value) = word.split_once('=').ok_or_else(|| format!("`{word}` says nothing"))?;
        Ok::<_, String>((key.to_owned(), value.to_owned()))
    };
    let pairs: Vec<(String, String)> = rest.iter().map(pair).collect::<Result<_, _>>()?;
    let find =
        |key: &str| pairs.iter().find(|(name, _)| name == key).map(|(_, value)| value.as_str());
    let layer = find("layer").unwrap_or("0");
    groups.push(group_of("0", kind));
    if let Some(handle) = find("handle") {
        groups.push(group_of("5", handle));
    }
    groups.push(group_of("8", layer));
    let mut attributes = Vec::new();
    for (key, value) in &pairs {
        match key.as_str() {
            "layer" | "handle" | "closed" => (),
            "at" => groups.extend(point("10", "20", value)?),
            "to" => groups.extend(point("11", "21", value)?),
            "radius" | "height" => groups.push(group_of("40", value)),
            "text" => groups.push(group_of("1", value)),
            "rotation" | "from" => groups.push(group_of("50", value)),
            "until" => groups.push(group_of("51", value)),
            "scale" => groups.push(group_of("41", value)),
            "block" => {
                groups.push(group_of("2", value));
                inserted.push(value.clone());
            }
            "points" => {
                let points: Vec<&str> = value.split(' ').collect();
                let closed = if find("closed") == Some("no") { "0" } else { "1" };
                groups.push(group_of("90", &points.len().to_string()));
                groups.push(group_of("70", closed));
                for at in points {
                    groups.extend(point("10", "20", at)?);
                }
            }
            name if name
                .bytes()
                .all(|b| b.is_ascii_uppercase() || b == b'_' || b.is_ascii_digit()) =>
            {
                attributes.extend([group_of("0", "ATTRIB"), group_of("8", layer)]);
                attributes.extend(point("10", "20", "0,0")?);
                attributes.extend([group_of("40", "1"), group_of("1", value), group_of("2", name)]);
            }
            _ => return Err(format!("unknown property `{key}`")),
        }
    }
    if !attributes.is_empty() {
        groups.push(group_of("66", "1"));
        groups.extend(attributes);
        groups.extend([group_of("0", "SEQEND"), group_of("8", layer)]);
    }
    Ok(())
}

fn point(x_code: &str, y_code: &str, at: &str) -> Result<[Group; 2], String> {
    let (x, y) = at.split_once(',').ok_or_else(|| format!("`{at}` is no point `x,y`"))?;
    Ok([group_of(x_code, x), group_of(y_code, y)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_entity_becomes_its_groups() {
        let list = "units none\nCIRCLE layer=\"a b\" at=1,2 radius=3\n  1001 BKSIM\n";
        let circle = "0\nCIRCLE\n8\na b\n10\n1\n20\n2\n40\n3\n1001\nBKSIM\n";
        assert!(dxf(list).is_ok_and(|text| text.contains(circle)));
        assert!(dxf("units none\nCIRCLE colour=red\n").is_err());
        assert!(dxf("CIRCLE at=1,2 radius=3\n").is_err());
    }
}
