//! The module of a live page: a [`Session`] behind three functions that a script calls.
//!
//! ```text
//! request(n)            room for a request of n bytes; its place
//! answer()              answers the request that was written there; the place of
//!                       n_json u32, n_numbers u32, then the JSON in UTF-8, then the numbers from the next multiple of 8
//! ```
//!
//! A page has one session, and one thread that calls it.
#![expect(
    unsafe_code,
    reason = "functions that scripts call must be exported by their plain names"
)]

use std::cell::RefCell;

use bksim_edit::Session;

/// A session with the bytes that go in and out.
#[derive(Default)]
struct Module {
    session: Session,
    request: Vec<u8>,
    /// Whole words, so that numbers are where a script can look at them.
    answer: Vec<u64>,
}

thread_local! {
    static MODULE: RefCell<Module> = RefCell::default();
}

/// Room for a request of `n` bytes.
// SAFETY: no other function of this name is linked into the module.
#[unsafe(no_mangle)]
pub extern "C" fn request(n: usize) -> *mut u8 {
    MODULE.with_borrow_mut(|module| {
        module.request.clear();
        module.request.resize(n, 0);
        module.request.as_mut_ptr()
    })
}

/// Answers the request that was written into its room.
// SAFETY: no other function of this name is linked into the module.
#[unsafe(no_mangle)]
pub extern "C" fn answer() -> *const u64 {
    MODULE.with_borrow_mut(|module| {
        let Module { session, request, answer } = module;
        let found = session.answer(&String::from_utf8_lossy(request));
        let json = found.json.to_string();
        let n_words = json.len().div_ceil(size_of::<u64>());
        answer.clear();
        answer.reserve(1 + n_words + found.numbers.len());
        answer.push(json.len() as u64 | (found.numbers.len() as u64) << 32);
        for word in json.as_bytes().chunks(size_of::<u64>()) {
            let mut bytes = [0; size_of::<u64>()];
            bytes[..word.len()].copy_from_slice(word);
            answer.push(u64::from_le_bytes(bytes));
        }
        answer.extend(found.numbers.iter().map(|number| number.to_bits()));
        answer.as_ptr()
    })
}
