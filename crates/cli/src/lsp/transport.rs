//! Messages over standard input and output, within bounds: a client that announces more than any model has, or sends
//! headers without end, is refused before anything is made of it.

use std::io::{self, BufRead, Read};
use std::sync::{Arc, OnceLock};
use std::thread::{self, JoinHandle};

use crossbeam_channel::bounded;
use lsp_server::{Connection, Message};

/// Most bytes of a message: twice those of the largest model, as quotes and line ends are escaped.
const MOST_MESSAGE: u64 = 128 << 20;
/// Most bytes of a line of a header, and most lines.
const MOST_LINE: u64 = 4096;
const MOST_LINES: usize = 64;

/// The two threads behind a connection.
pub(super) struct Threads {
    reader: JoinHandle<()>,
    writer: JoinHandle<io::Result<()>>,
    /// Why no more can be read, unless the client has ended.
    unread: Arc<OnceLock<String>>,
}

/// A connection over standard input and output.
pub(super) fn stdio() -> (Connection, Threads) {
    let (sender, outgoing) = bounded::<Message>(0);
    let writer = thread::spawn(move || {
        let mut out = io::stdout().lock();
        outgoing.into_iter().try_for_each(|message| message.write(&mut out))
    });
    let (incoming, receiver) = bounded::<Message>(0);
    let unread = Arc::new(OnceLock::new());
    let why = Arc::clone(&unread);
    let reader = thread::spawn(move || {
        let mut input = io::stdin().lock();
        loop {
            match read(&mut input) {
                Ok(Some(message)) => {
                    let is_last =
                        matches!(&message, Message::Notification(n) if n.method == "exit");
                    if incoming.send(message).is_err() || is_last {
                        return;
                    }
                }
                Ok(None) => return,
                Err(fault) => {
                    // Known before the connection ends.
                    let _ = why.set(fault);
                    return;
                }
            }
        }
    });
    (Connection { sender, receiver }, Threads { reader, writer, unread })
}

impl Threads {
    /// Why the client cannot be understood, if that is so.
    pub(super) fn unread(&self) -> Option<String> {
        self.unread.get().cloned()
    }

    /// Waits until all has been written.
    ///
    /// # Errors
    /// Standard output that cannot be written.
    pub(super) fn join(self) -> io::Result<()> {
        // They end by themselves: a panic is a bug, and has been printed.
        let _ = self.reader.join();
        self.writer.join().unwrap_or(Ok(()))
    }
}

/// The next message; `None` at the end of the input.
///
/// # Errors
/// What is wrong with it, in words.
fn read(input: &mut impl BufRead) -> Result<Option<Message>, String> {
    let Some(length) = length(input)? else { return Ok(None) };
    if length > MOST_MESSAGE {
        return Err(format!("a message of {length} bytes is announced, {MOST_MESSAGE} are taken"));
    }
    let mut text = Vec::new();
    input.take(length).read_to_end(&mut text).map_err(|error| error.to_string())?;
    if (text.len() as u64) < length {
        return Err(format!("its last message has {} bytes of {length}", text.len()));
    }
    serde_json::from_slice(&text).map(Some).map_err(|error| format!("no message: {error}"))
}

/// The length of a message by its header; `None` at the end of the input.
fn length(input: &mut impl BufRead) -> Result<Option<u64>, String> {
    let mut length = None;
    for _ in 0..MOST_LINES {
        let mut line = Vec::new();
        let read = input.take(MOST_LINE).read_until(b'\n', &mut line);
        read.map_err(|error| error.to_string())?;
        if line.is_empty() {
            return Ok(None);
        }
        if line.last() != Some(&b'\n') {
            return Err("a header without end".to_owned());
        }
        let line = String::from_utf8_lossy(&line);
        let line = line.trim();
        if line.is_empty() {
            return length.map(Some).ok_or_else(|| "a header without `Content-Length`".to_owned());
        }
        let Some((name, value)) = line.split_once(':') else {
            return Err("a header without `:`".to_owned());
        };
        if name.eq_ignore_ascii_case("Content-Length") {
            let value = value.trim();
            let number = value.parse::<u64>();
            length = Some(number.map_err(|_| format!("`Content-Length: {value}` is no size"))?);
        }
    }
    Err(format!("a header of more than {MOST_LINES} lines"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_read_within_bounds() {
        let exit = r#"{"jsonrpc":"2.0","method":"exit"}"#;
        let mut good = format!("Content-Length: {}\r\nOther: x\r\n\r\n{exit}", exit.len());
        let found = read(&mut good.as_bytes()).expect("a message");
        assert!(matches!(found, Some(Message::Notification(n)) if n.method == "exit"));
        assert!(read(&mut &b""[..]).expect("the end").is_none());
        good.truncate(good.len() - 1);
        for (bad, word) in [
            ("Content-Length: 99999999999999\r\n\r\n", "99999999999999 bytes"),
            ("Content-Length: 99999999999999999999\r\n\r\n", "no size"),
            ("Content-Length: -1\r\n\r\n", "no size"),
            ("Content-Length: 2\r\n\r\n{}", "no message"),
            ("\r\n", "without `Content-Length`"),
            ("hello\n", "without `:`"),
            (&"x".repeat(1 << 20), "without end"),
            (&"a: b\r\n".repeat(1000), "64 lines"),
            (good.as_str(), "its last message has"),
        ] {
            let fault = read(&mut bad.as_bytes()).expect_err(word);
            assert!(fault.contains(word), "{fault}");
        }
    }
}
