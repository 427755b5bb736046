//! Statements of an OBJ file: lines joined where they end in a backslash.

use std::io::{self, BufRead, Read as _};

/// The statements of a reader, one after the other.
pub(super) struct Lines<R> {
    reader: R,
    text: Vec<u8>,
    /// Lines read so far.
    count: usize,
}

/// One statement without its comment.
pub(super) struct Statement<'a> {
    /// The number of its first line, from 1.
    pub(super) line: usize,
    text: &'a [u8],
}

/// What comes next.
pub(super) enum Next<'a> {
    Statement(Statement<'a>),
    End,
    /// It has more bytes than allowed.
    TooLong {
        line: usize,
    },
}

impl<R: BufRead> Lines<R> {
    pub(super) fn new(reader: R) -> Self {
        Self { reader, text: Vec::new(), count: 0 }
    }

    /// The next statement, if it has at most `most` bytes.
    pub(super) fn next(&mut self, most: u64) -> io::Result<Next<'_>> {
        self.text.clear();
        let line = self.count + 1;
        let mut is_comment = false;
        loop {
            let start = self.text.len();
            let room = most.saturating_sub(self.text.len() as u64);
            let read = self.reader.by_ref().take(room.saturating_add(1)).read_until(b'\n', &mut self.text)?;
            if read == 0 {
                break;
            }
            self.count += 1;
            if read as u64 > room {
                return Ok(Next::TooLong { line });
            }
            while let Some(b'\n' | b'\r') = self.text.last() {
                self.text.pop();
            }
            // Only what is new is searched, since a statement may go on for a million lines.
            is_comment |= self.text.get(start..).is_some_and(|new| new.contains(&b'#'));
            // Comments do not go on: one that ends in a folder's name would take the next line with it.
            if self.text.last() != Some(&b'\\') || is_comment {
                return Ok(Next::Statement(Statement { line, text: &self.text }));
            }
            if let Some(last) = self.text.last_mut() {
                *last = b' ';
            }
        }
        Ok(if self.text.is_empty() { Next::End } else { Next::Statement(Statement { line, text: &self.text }) })
    }
}

impl<'a> Statement<'a> {
    /// Its words.
    pub(super) fn words(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        let text = self.text.split(|&byte| byte == b'#').next().unwrap_or_default();
        let start = if self.line == 1 { text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text) } else { text };
        start.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
    }
}
