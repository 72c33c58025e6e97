//! Lines of an OBJ file, without comments and with continued lines joined.

/// Logical lines without comments, each with the number of its first physical line.
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    number: u64,
    joined: Vec<u8>,
}

impl<'a> Lines<'a> {
    /// All lines of a file.
    pub(super) fn new(bytes: &'a [u8]) -> Lines<'a> {
        Lines {
            rest: bytes,
            number: 0,
            joined: Vec::new(),
        }
    }

    /// The number of the next logical line, counted from 1, and its bytes.
    pub(super) fn next(&mut self) -> Option<(u64, &[u8])> {
        let (mut line, mut continued) = self.physical()?;
        let first = self.number;
        if continued {
            self.joined.clear();
            while continued {
                self.joined.extend_from_slice(line);
                self.joined.push(b' ');
                (line, continued) = self.physical().unwrap_or((b"", false));
            }
            self.joined.extend_from_slice(line);
            return Some((first, &self.joined));
        }
        Some((first, line))
    }

    /// The next line up to its comment or end, and whether a backslash continues it.
    fn physical(&mut self) -> Option<(&'a [u8], bool)> {
        if self.rest.is_empty() {
            return None;
        }
        self.number += 1;
        let end = self.rest.iter().position(|&b| b == b'\n' || b == b'\r');
        let line = &self.rest[..end.unwrap_or(self.rest.len())];
        let next = match end {
            None => self.rest.len(),
            Some(end) if self.rest[end..].starts_with(b"\r\n") => end + 2,
            Some(end) => end + 1,
        };
        self.rest = &self.rest[next..];
        // A comment ends with its line, even if it ends in a backslash, as paths of directories do.
        if let Some(comment) = comment_start(line) {
            return Some((&line[..comment], false));
        }
        match line.trim_ascii_end() {
            [start @ .., b'\\'] => Some((start, true)),
            _ => Some((line, false)),
        }
    }
}

/// Where a comment begins: at a `#` that no other character touches from the left.
fn comment_start(line: &[u8]) -> Option<usize> {
    (0..line.len()).find(|&i| line[i] == b'#' && (i == 0 || line[i - 1].is_ascii_whitespace()))
}
