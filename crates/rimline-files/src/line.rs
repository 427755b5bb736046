//! Statements of a file of text, such as an OBJ: lines, joined where they end in a backslash.
//! A line ends in LF, CR LF or CR.

use std::io::{self, BufRead, ErrorKind};

/// The statements of a reader, one after the other.
pub(crate) struct Statements<R> {
    reader: R,
    text: Vec<u8>,
    /// Whether a backslash at the end of a line joins it with the next one even without a blank before it.
    joins_words: bool,
    /// Lines read so far.
    count: usize,
    /// Whether the last line was read, and has no end. It is a statement all the same.
    pub(crate) is_cut: bool,
}

/// One statement, with its comment.
pub(crate) struct Statement<'a> {
    /// The number of its first line, from 1.
    pub(crate) line: usize,
    text: &'a [u8],
}

/// Result of reading the next statement.
pub(crate) enum Next<'a> {
    Statement(Statement<'a>),
    End,
    /// It has more bytes than allowed. The rest of it was not read.
    TooLong {
        line: usize,
    },
}

impl<R: BufRead> Statements<R> {
    pub(crate) fn new(reader: R) -> Self {
        Self { reader, text: Vec::new(), joins_words: true, count: 0, is_cut: false }
    }

    /// Lines are joined only where a blank stands before the backslash: the name of a folder may end in one, too.
    pub(crate) fn with_folders(reader: R) -> Self {
        Self { joins_words: false, ..Self::new(reader) }
    }

    /// The next statement, of at most `most` bytes with the end of its line.
    pub(crate) fn next(&mut self, most: u64) -> io::Result<Next<'_>> {
        self.text.clear();
        let line = self.count + 1;
        let mut is_comment = false;
        loop {
            let start = self.text.len();
            let room = most.saturating_sub(self.text.len() as u64);
            let read = self.line(room)?;
            if read == 0 {
                break;
            }
            self.count += 1;
            if read > room {
                return Ok(Next::TooLong { line });
            }
            // Only what is new is searched, since a statement may go on for a million lines.
            is_comment |= self.text.get(start..).is_some_and(|new| new.contains(&b'#'));
            // Comments do not go on: one may end in a folder's name, such as `C:\models\`.
            let goes_on = match &self.text[..] {
                [.., b' ' | b'\t', b'\\'] => true,
                [.., b'\\'] => self.joins_words,
                _ => false,
            };
            if !goes_on || is_comment {
                return Ok(Next::Statement(Statement { line, text: &self.text }));
            }
            if let Some(last) = self.text.last_mut() {
                *last = b' ';
            }
        }
        Ok(if self.text.is_empty() { Next::End } else { Next::Statement(Statement { line, text: &self.text }) })
    }

    /// Appends the next line without its end. Returns its bytes with the end, and stops where they are more than `room`.
    fn line(&mut self, room: u64) -> io::Result<u64> {
        let mut read = 0_u64;
        while read <= room {
            let chunk = filled(&mut self.reader)?;
            let most = usize::try_from(room.saturating_sub(read).saturating_add(1)).unwrap_or(usize::MAX);
            let chunk = &chunk[..chunk.len().min(most)];
            let end = memchr::memchr2(b'\n', b'\r', chunk);
            let line_part = &chunk[..end.unwrap_or(chunk.len())];
            self.text.extend_from_slice(line_part);
            let is_return = chunk.get(line_part.len()) == Some(&b'\r');
            let used = line_part.len() + usize::from(end.is_some());
            self.reader.consume(used);
            read += used as u64;
            if is_return {
                return Ok(read + self.rest_of_end()?);
            }
            if end.is_some() || used == 0 {
                self.is_cut |= end.is_none() && read > 0;
                break;
            }
        }
        Ok(read)
    }

    /// Consumes the rest of a line's end after a CR: the LF of the same end, or other CRs. Such CRs end empty lines,
    /// unless a LF follows: some programs write CR CR LF. Returns 1 for a LF.
    fn rest_of_end(&mut self) -> io::Result<u64> {
        let mut empty = 0;
        loop {
            let next = filled(&mut self.reader)?.first().copied();
            if let Some(b'\r' | b'\n') = next {
                self.reader.consume(1);
            }
            match next {
                Some(b'\n') => return Ok(1),
                Some(b'\r') => empty += 1,
                _ => {
                    self.count += empty;
                    return Ok(0);
                }
            }
        }
    }
}

/// Fills the reader's buffer and returns it. Retries when interrupted, like `BufRead::read_until`.
fn filled(reader: &mut impl BufRead) -> io::Result<&[u8]> {
    while let Err(error) = reader.fill_buf() {
        if error.kind() != ErrorKind::Interrupted {
            return Err(error);
        }
    }
    reader.fill_buf()
}

impl<'a> Statement<'a> {
    /// Its words, without the comment.
    pub(crate) fn words(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        self.words_of(self.text.split(|&byte| byte == b'#').next().unwrap_or_default())
    }

    /// The words behind the first one, which are a name. Names may have a `#`, as `Material #25` has: one that begins a word
    /// begins a comment only if no digit follows.
    pub(crate) fn name(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        let is_named = |word: &&[u8]| word.first() != Some(&b'#') || word.get(1).is_some_and(u8::is_ascii_digit);
        self.words_of(self.text).skip(1).take_while(is_named)
    }

    fn words_of(&self, text: &'a [u8]) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        let start = if self.line == 1 { text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text) } else { text };
        start.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
    }
}

/// Text without a byte order mark and blanks before it.
pub(crate) fn text(start: &[u8]) -> &[u8] {
    start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start).trim_ascii_start()
}

/// The first N numbers of some words, and how many there are. Else the first word that is no number.
pub(crate) fn numbers<'a, T: Copy + Default, const N: usize>(
    words: impl Iterator<Item = &'a [u8]>,
    number: impl Fn(&str) -> Option<T>,
) -> Result<([T; N], usize), &'a [u8]> {
    let (mut numbers, mut count) = ([T::default(); N], 0);
    for word in words {
        let found = std::str::from_utf8(word).ok().and_then(&number).ok_or(word)?;
        if let Some(slot) = numbers.get_mut(count) {
            *slot = found;
        }
        count += 1;
    }
    Ok((numbers, count))
}

/// The beginning of a word, for a message.
pub(crate) fn shown(word: &[u8]) -> String {
    String::from_utf8_lossy(&word[..word.len().min(160)]).chars().take(40).collect()
}
