//! The body of a tape in sections, each of which becomes one function of machine code.

use crate::tape::{Action, Tape};

/// Instructions of one function: at worst 40 kB of stack, where all values are alive at once.
pub(super) const SECTION: usize = 5_000;

/// The body of a tape in sections, and what passes between them.
pub(super) struct Body<'a> {
    pub(super) tape: &'a Tape,
    pub(super) sections: Vec<Section>,
    /// By result of the body, from its first register on: whether a later section uses it.
    pub(super) is_used_later: Vec<bool>,
    /// Outputs by the register that holds them, in ascending order.
    pub(super) outputs: Vec<(usize, usize)>,
}

/// A part of a body.
#[derive(Clone, Copy)]
pub(super) struct Section {
    /// Its first instruction, and the one after its last.
    pub(super) instructions: [usize; 2],
    /// Register of its first result.
    pub(super) first: usize,
}

impl<'a> Body<'a> {
    pub(super) fn of(tape: &'a Tape) -> Self {
        let (mut sections, mut first) = (Vec::new(), tape.first_body);
        let mut is_used_later = vec![false; tape.n_registers - tape.first_body];
        let mut instructions = 0;
        // An empty body has one section, too: its outputs are stored there.
        for section in tape.body.chunks(SECTION).chain(tape.body.is_empty().then_some(&[][..])) {
            let own = first;
            let mut used = |register: u32| {
                let register = register as usize;
                if (tape.first_body..own).contains(&register) {
                    is_used_later[register - tape.first_body] = true;
                }
            };
            for instruction in section {
                if instruction.action == Action::Turn {
                    tape.angles_of(instruction).iter().copied().for_each(&mut used);
                } else {
                    [instruction.a, instruction.b, instruction.c].into_iter().for_each(&mut used);
                }
                first += instruction.n_results();
            }
            let end = instructions + section.len();
            sections.push(Section { instructions: [instructions, end], first: own });
            instructions = end;
        }
        let mut outputs: Vec<(usize, usize)> =
            tape.outputs.iter().map(|&register| register as usize).zip(0..).collect();
        outputs.sort_unstable();
        Self { tape, sections, is_used_later, outputs }
    }
}
