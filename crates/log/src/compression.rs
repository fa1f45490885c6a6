//! Compression of chunks: zstd, whose C sources no WebAssembly module is built of; there, chunks are written as they are
//! and compressed ones are refused.

use crate::LogError;
use mcap::WriteOptions;

/// Options of a writer whose chunks are compressed where that can be done.
#[cfg(not(target_family = "wasm"))]
pub(crate) fn compressed(options: WriteOptions) -> WriteOptions {
    options
        // A quarter of the time of the usual level, for files some four per cent larger. The library hands it on as a
        // signed number, and levels below zero are zstd's fast ones.
        .compression_level((-1_i32).cast_unsigned())
        // The bytes must not depend on the number of processors.
        .compression_threads(0)
}

/// Options of a writer whose chunks are not compressed.
#[cfg(target_family = "wasm")]
pub(crate) fn compressed(options: WriteOptions) -> WriteOptions {
    options.compression(None)
}

/// Opens compressed chunks.
#[cfg(not(target_family = "wasm"))]
pub(crate) struct Decompressor(zstd::bulk::Decompressor<'static>);

#[cfg(not(target_family = "wasm"))]
impl Decompressor {
    pub(crate) fn new() -> Result<Self, LogError> {
        Ok(Self(zstd::bulk::Decompressor::new()?))
    }

    /// The contents of a chunk of zstd, at most `size` bytes.
    pub(crate) fn open(&mut self, data: &[u8], size: usize) -> Result<Vec<u8>, LogError> {
        let broken = |error| LogError::damaged(format!("a chunk does not decompress: {error}"));
        self.0.decompress(data, size).map_err(broken)
    }
}

/// Refuses compressed chunks.
#[cfg(target_family = "wasm")]
pub(crate) struct Decompressor;

#[cfg(target_family = "wasm")]
impl Decompressor {
    #[expect(clippy::unnecessary_wraps, reason = "the other one may fail")]
    pub(crate) fn new() -> Result<Self, LogError> {
        Ok(Self)
    }

    #[expect(clippy::unused_self, reason = "the other one has state")]
    pub(crate) fn open(&mut self, _: &[u8], _: usize) -> Result<Vec<u8>, LogError> {
        Err(LogError::Compressed)
    }
}
