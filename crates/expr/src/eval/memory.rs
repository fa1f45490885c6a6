//! [`Memory`]: memory that holds machine code and can be executed.

use memmap2::{Mmap, MmapMut};

/// Memory with the bytes of one function, which is freed when dropped.
pub(super) struct Memory(Mmap);

impl Memory {
    /// Copies the bytes of a function to memory that can be executed and no longer written; `None` where the system
    /// provides none.
    pub(super) fn of(bytes: &[u8]) -> Option<Self> {
        let mut writable = MmapMut::map_anon(bytes.len()).ok()?;
        writable.copy_from_slice(bytes);
        writable.make_exec().ok().map(Self)
    }

    /// Address of the function.
    pub(super) fn address(&self) -> *const u8 {
        self.0.as_ptr()
    }
}
