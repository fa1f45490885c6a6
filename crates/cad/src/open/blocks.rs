//! How many entities a drawing has once every insert is replaced by its block.

use std::collections::BTreeMap;

use bksim_model::diagnostic::Diagnostic;

use super::feed::Record;
use super::guard::{MOST_ENTITIES, SHOWN, at_value, describe};
use crate::codes;
use crate::tags::Tags;

/// A block: its own entities, and the inserts among them.
#[derive(Default)]
struct Block {
    n_own: u64,
    inserts: Vec<BlockInsert>,
}

struct BlockInsert {
    block: String,
    /// Rows times columns.
    n_copies: u64,
    record: usize,
}

/// Our blocks begin with this; their inserts have all that they say in their attributes.
const PREFIX: &str = "BK_";

/// Checks that no block holds itself and that the drawing has a bearable number of entities; returns
/// warnings about inserts of blocks that are not there.
///
/// Blocks within blocks multiply: twenty of them, each inserting the next one twice, are a million
/// copies.
pub(super) fn check(
    tags: &Tags,
    blocks: &[Record],
    entities: &[Record],
) -> Result<Vec<Diagnostic>, Diagnostic> {
    let mut known: BTreeMap<String, Block> = BTreeMap::new();
    let mut name = String::new();
    let (mut open, mut unended) = (None, Vec::new());
    for record in blocks {
        if tags.is_word(record.tags.start, "BLOCK") {
            name = block_name(tags, record);
            known.insert(name.clone(), Block::default());
            unended.extend(open.replace(record));
        } else if tags.is_word(record.tags.start, "ENDBLK") {
            open = None;
        } else if let Some(block) = known.get_mut(&name) {
            add(tags, block, record);
        }
    }
    let mut model = Block::default();
    for record in entities {
        add(tags, &mut model, record);
    }

    let sizes = sizes(&known).map_err(|(block, record)| holds_itself(tags, &block, record))?;
    let n_entities = size(&model, &sizes);
    if n_entities > MOST_ENTITIES {
        let message = format!("the drawing has {n_entities} entities, those of inserts counted");
        return Err(Diagnostic::error(codes::TOO_LARGE, message)
            .note(format!("{} stand in the drawing itself", model.n_own))
            .note(format!("at most {MOST_ENTITIES} are read"))
            .help("save what belongs to the mechanism as a drawing of its own"));
    }
    unended.extend(open);
    let mut warnings: Vec<Diagnostic> = unended.iter().map(|it| no_end(tags, it)).collect();
    warnings.truncate(SHOWN);
    warnings.extend(undefined(tags, &model, &known));
    Ok(warnings)
}

/// A block without `ENDBLK`.
fn no_end(tags: &Tags, block: &Record) -> Diagnostic {
    let name = block_name(tags, block);
    let message = format!("the block `{name}` has no `ENDBLK`: it ends where the next one begins");
    let fault = Diagnostic::warning(codes::NO_BLOCK_END, message)
        .note(describe(tags, block.tags.clone()))
        .help("open the drawing in a CAD program, and save it again");
    at_value(fault, tags, block.tags.start, "this block")
}

/// Warnings about inserts of blocks that are not there, of those that the model space shows.
fn undefined(tags: &Tags, model: &Block, known: &BTreeMap<String, Block>) -> Vec<Diagnostic> {
    let mut warnings = Vec::new();
    let mut waiting = vec![model];
    let mut is_met = std::collections::BTreeSet::new();
    while let Some(block) = waiting.pop() {
        for insert in &block.inserts {
            match known.get(&insert.block) {
                Some(inner) if is_met.insert(&insert.block) => waiting.push(inner),
                Some(_) => (),
                None if insert.block.starts_with(PREFIX) => (),
                None => warnings.push(no_block(tags, insert)),
            }
        }
    }
    warnings.truncate(SHOWN);
    warnings
}

fn no_block(tags: &Tags, insert: &BlockInsert) -> Diagnostic {
    let message = format!("the drawing has no block `{}`: its insert shows nothing", insert.block);
    let record = tags.record_from(insert.record).unwrap_or(insert.record..insert.record + 1);
    let fault = Diagnostic::warning(codes::NO_BLOCK, message)
        .note(describe(tags, record))
        .help("delete the insert, or define the block (an external reference must be bound first)");
    at_value(fault, tags, insert.record, "inserted here")
}

fn add(tags: &Tags, block: &mut Block, record: &Record) {
    block.n_own += 1;
    if !tags.is_word(record.tags.start, "INSERT") {
        return;
    }
    let count = |code: i16| {
        let mut own = record.tags.clone().take_while(|&idx| tags.code(idx) < 1000);
        let stated = own.find(|&idx| tags.code(idx) == code).and_then(|idx| tags.integer(idx));
        u64::try_from(stated.unwrap_or(1)).unwrap_or(1).max(1)
    };
    block.inserts.push(BlockInsert {
        block: block_name(tags, record),
        n_copies: count(70).saturating_mul(count(71)),
        record: record.tags.start,
    });
}

fn block_name(tags: &Tags, record: &Record) -> String {
    let name = record.tags.clone().find(|&idx| tags.code(idx) == 2);
    name.map_or_else(String::new, |idx| tags.text(idx).trim().to_uppercase())
}

/// The size of a block, once all of its inserts are known; a block that is not there has none.
fn size(block: &Block, sizes: &BTreeMap<&str, u64>) -> u64 {
    block.inserts.iter().fold(block.n_own, |total, insert| {
        let one = sizes.get(insert.block.as_str()).copied().unwrap_or(0);
        total.saturating_add(one.saturating_mul(insert.n_copies))
    })
}

/// The sizes of all blocks, innermost first; or a block that holds itself, and the insert there.
fn sizes(blocks: &BTreeMap<String, Block>) -> Result<BTreeMap<&str, u64>, (String, usize)> {
    let mut sizes: BTreeMap<&str, u64> = BTreeMap::new();
    // A depth-first walk with a stack of its own: nesting may be deeper than the machine's stack.
    for root in blocks.keys() {
        let mut path: Vec<(&str, usize)> = vec![(root, 0)];
        let mut on_path = std::collections::BTreeSet::from([root.as_str()]);
        while let Some((name, next)) = path.last_mut() {
            let inserts = blocks.get(*name).map_or(&[][..], |block| &block.inserts);
            if sizes.contains_key(*name) || *next == inserts.len() {
                let name = *name;
                if let Some(block) = blocks.get(name) {
                    let known = size(block, &sizes);
                    sizes.insert(name, known);
                } else {
                    // A block that is not there has no entities.
                    sizes.insert(name, 0);
                }
                on_path.remove(name);
                path.pop();
                continue;
            }
            let insert = &inserts[*next];
            *next += 1;
            if !on_path.insert(&insert.block) {
                return Err((insert.block.clone(), insert.record));
            }
            path.push((&insert.block, 0));
        }
    }
    Ok(sizes)
}

fn holds_itself(tags: &Tags, block: &str, insert: usize) -> Diagnostic {
    let message = format!("the block `{block}` is inserted within itself");
    let record = tags.record_from(insert).unwrap_or(insert..insert + 1);
    let fault = Diagnostic::error(codes::BLOCK_IN_ITSELF, message)
        .note(describe(tags, record))
        .help("delete this insert");
    at_value(fault, tags, insert, "inserted here")
}
