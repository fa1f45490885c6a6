//! [`Memory`]: memory that can be executed, and the reasons why a tape has none.

#![expect(unsafe_code, reason = "memory with machine code is freed by hand")]

use cranelift_codegen::ir::types::I64;
use cranelift_codegen::ir::{AbiParam, Signature};
use cranelift_codegen::settings::{self, Configurable};
use cranelift_jit::{JITBuilder, JITModule};
#[cfg(target_arch = "x86_64")]
use cranelift_module::{FuncId, Linkage};
use cranelift_module::{Module, ModuleError, default_libcall_names};
use std::sync::Mutex;

/// Reason why a tape is not compiled to machine code; the interpreter takes any tape.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum JitError {
    /// Compiling would take longer and more memory than any run gains.
    #[error("{found} instructions are more than the {limit} that are compiled to machine code")]
    TooLong {
        /// Instructions of the tape's body.
        found: usize,
        /// The most that are compiled.
        limit: usize,
    },
    /// There is no code generator for this processor.
    #[error("no machine code for this processor: {reason}")]
    Host {
        /// Message of the code generator.
        reason: &'static str,
    },
    /// The code generator failed.
    #[error("the code generator failed: {0}")]
    Generator(#[from] Box<ModuleError>),
}

/// Longest body that is compiled: some two seconds, and as many bytes of code as ten times its instructions.
pub(super) const MOST_INSTRUCTIONS: usize = 500_000;

/// Memory with machine code; always present until dropped.
pub(super) struct Memory(Mutex<Option<JITModule>>);

impl Memory {
    /// The memory of a module whose functions are finished.
    pub(super) fn holding(module: JITModule) -> Self {
        Self(Mutex::new(Some(module)))
    }

    /// Memory with the bytes of a function, and its address.
    ///
    /// # Errors
    /// [`JitError`] when there is none.
    #[cfg(target_arch = "x86_64")]
    pub(super) fn of(bytes: &[u8]) -> Result<(Self, *const u8), JitError> {
        let mut module = module([])?;
        let mut define = || {
            let signature = signature(&module);
            let id = module.declare_function("tape", Linkage::Export, &signature);
            let id = id.map_err(Box::new)?;
            module.define_function_bytes(id, 32, bytes, &[]).map_err(Box::new)?;
            module.finalize_definitions().map_err(Box::new)?;
            Ok::<FuncId, Box<ModuleError>>(id)
        };
        let address = define().map(|id| module.get_finalized_function(id));
        Ok((Self::holding(module), address?))
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        let module = self.0.get_mut().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some(module) = module.take() {
            // SAFETY: functions in this memory are only called through borrows of its owner.
            unsafe { module.free_memory() };
        }
    }
}

/// A module for this processor that knows the addresses of these names.
pub(super) fn module(
    symbols: impl IntoIterator<Item = (&'static str, *const u8)>,
) -> Result<JITModule, JitError> {
    let mut flags = settings::builder();
    for (name, value) in [
        ("opt_level", "none"),
        ("is_pic", "false"),
        ("use_colocated_libcalls", "false"),
        ("enable_verifier", if cfg!(debug_assertions) { "true" } else { "false" }),
        ("unwind_info", "false"),
        // Large frames are touched page by page in line; the default is a call into nowhere.
        ("probestack_strategy", "inline"),
    ] {
        flags.set(name, value).expect("a setting of the code generator");
    }
    let host = cranelift_native::builder().map_err(|reason| JitError::Host { reason })?;
    let isa = host
        .finish(settings::Flags::new(flags))
        .map_err(|fault| Box::new(ModuleError::Compilation(fault)))?;
    let mut builder = JITBuilder::with_isa(isa, default_libcall_names());
    builder.symbols(symbols);
    Ok(JITModule::new(builder))
}

/// Three pointers and no result.
pub(super) fn signature(module: &JITModule) -> Signature {
    let mut signature = module.make_signature();
    signature.params.extend([AbiParam::new(I64); 3]);
    signature
}
