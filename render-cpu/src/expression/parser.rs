//! Reads path expressions in both notations.
//!
//! ```text
//! choice   = sequence { "|" sequence }
//! sequence = { repeat }
//! repeat   = primary { "*" | "+" | "?" | "{n}" | "{n,}" | "{,m}" | "{n,m}" }
//! primary  = "(" choice ")" | "." | set | "<" type scattering { label } ">" | letter { "^R" | "^T" | names | region }
//! set      = "[" [ "^" ] { letter | "." | "<" ... ">" } "]"
//! names    = "[" [ "^" ] name { "," name } "]"
//! region   = "{" name "}"
//! ```
//!
//! From the light (the thesis): begins with L, ends with E; `[` right behind a letter holds names. From the camera (OSL,
//! RenderMan, Arnold): begins with C, ends at a light; `[` is always a set, names stand as labels in `<>`.
//!
//! By hand, because the grammar has ten productions, `[` and `{` depend on what stands before and behind them, and every
//! mistake shall be told in the words of the notation with its position; parser libraries save none of that here.

use super::error::ExpressionError;
use super::syntax::{Atom, Node};

/// Deepest nesting of parentheses.
const MAX_DEPTH: usize = 64;

/// Most repetitions that can be asked for.
const MAX_REPEAT: u32 = 64;

/// Most operators of repetition behind one another.
const MAX_OPERATORS: usize = 4;

/// Longest expression, in characters.
const MAX_LENGTH: usize = 4096;

/// The syntax tree of an expression, read from the light whatever the notation.
///
/// # Errors
/// The first mistake.
pub fn parse(text: &str) -> Result<Node, ExpressionError> {
    let chars: Vec<char> = text.chars().collect();
    if chars.len() > MAX_LENGTH {
        let message = format!("more than {MAX_LENGTH} characters");
        return Err(ExpressionError::new(text, MAX_LENGTH, message));
    }
    let first = chars.iter().find(|c| !c.is_whitespace() && **c != '(');
    let Some(first) = first else {
        let message = "an expression begins with L, from the light, or with C, from the camera";
        return Err(ExpressionError::new(text, chars.len(), message));
    };
    let from_camera = *first == 'C';
    let mut parser = Parser {
        text,
        chars,
        at: 0,
        depth: 0,
        from_camera,
    };
    let node = parser.choice()?;
    parser.skip_space();
    if parser.peek().is_some() {
        return Err(parser.error("this ) closes nothing"));
    }
    Ok(if from_camera { node.reversed() } else { node })
}

/// The text, and how far it is read.
pub(super) struct Parser<'a> {
    text: &'a str,
    pub chars: Vec<char>,
    pub at: usize,
    depth: usize,
    pub from_camera: bool,
}

impl Parser<'_> {
    pub fn error(&self, message: impl Into<String>) -> ExpressionError {
        self.error_at(self.at, message)
    }

    pub fn error_at(&self, position: usize, message: impl Into<String>) -> ExpressionError {
        ExpressionError::new(self.text, position, message)
    }

    pub fn peek(&self) -> Option<char> {
        self.chars.get(self.at).copied()
    }

    pub fn skip_space(&mut self) {
        while self.peek().is_some_and(char::is_whitespace) {
            self.at += 1;
        }
    }

    /// Takes the character if it is the next one.
    pub fn take(&mut self, c: char) -> bool {
        let is_next = self.peek() == Some(c);
        self.at += usize::from(is_next);
        is_next
    }

    fn choice(&mut self) -> Result<Node, ExpressionError> {
        let mut choices = vec![self.sequence()?];
        while self.take('|') {
            choices.push(self.sequence()?);
        }
        Ok(match choices.len() {
            1 => choices.remove(0),
            _ => Node::Choice(choices),
        })
    }

    fn sequence(&mut self) -> Result<Node, ExpressionError> {
        let mut nodes = Vec::new();
        loop {
            self.skip_space();
            match self.peek() {
                None | Some('|' | ')') => return Ok(Node::Sequence(nodes)),
                Some(_) => nodes.push(self.repeat()?),
            }
        }
    }

    fn repeat(&mut self) -> Result<Node, ExpressionError> {
        let mut node = self.primary()?;
        for _ in 0..=MAX_OPERATORS {
            self.skip_space();
            let start = self.at;
            let (least, most) = match self.peek() {
                Some('*') => (0, None),
                Some('+') => (1, None),
                Some('?') => (0, Some(1)),
                Some('{') => self.counts()?,
                _ => return Ok(node),
            };
            if most != Some(1)
                && let Node::Atom(atom, _) = &node
                && atom.is_end()
            {
                let message = "a path has one light and one sensor, which do not repeat; .* stands for any vertices";
                return Err(self.error_at(start, message));
            }
            self.at += 1;
            node = Node::Repeat(Box::new(node), least, most);
        }
        Err(self.error("too many repetitions of the same"))
    }

    /// `{n,m}` up to its last brace.
    fn counts(&mut self) -> Result<(u32, Option<u32>), ExpressionError> {
        let start = self.at;
        self.at += 1;
        self.skip_space();
        let least = self.number()?;
        self.skip_space();
        let most = if self.take(',') {
            self.skip_space();
            self.number()?
        } else {
            least
        };
        self.skip_space();
        let is_range = self.chars[start..self.at].contains(&',');
        if self.peek() != Some('}') || (least.is_none() && most.is_none()) {
            return Err(self.error_at(
                start,
                "expected {n}, {n,}, {,m} or {n,m}; a region stands right behind its letter",
            ));
        }
        let (least, most) = match (least, most) {
            (least, None) if is_range => (least.unwrap_or(0), None),
            (least, most) => (least.unwrap_or(0), most),
        };
        if most.is_some_and(|most| most < least) {
            return Err(self.error_at(start, "the first number is larger than the second"));
        }
        if most.unwrap_or(least) > MAX_REPEAT {
            let message = format!("at most {MAX_REPEAT} repetitions can be counted");
            return Err(self.error_at(start, message));
        }
        Ok((least, most))
    }

    fn number(&mut self) -> Result<Option<u32>, ExpressionError> {
        let start = self.at;
        while self.peek().is_some_and(|c| c.is_ascii_digit()) {
            self.at += 1;
        }
        if start == self.at {
            return Ok(None);
        }
        let digits: String = self.chars[start..self.at].iter().collect();
        let number = digits.parse().ok().filter(|n| *n <= MAX_REPEAT);
        let message = format!("at most {MAX_REPEAT} repetitions can be counted");
        number
            .map(Some)
            .ok_or_else(|| self.error_at(start, message))
    }

    fn primary(&mut self) -> Result<Node, ExpressionError> {
        match self.peek() {
            Some('(') => {
                let start = self.at;
                self.at += 1;
                self.depth += 1;
                if self.depth > MAX_DEPTH {
                    return Err(self.error_at(start, "parentheses are nested too deeply"));
                }
                let node = self.choice()?;
                if !self.take(')') {
                    return Err(self.error_at(start, "this ( is not closed"));
                }
                self.depth -= 1;
                Ok(node)
            }
            Some('[') => {
                let start = self.at;
                Ok(Node::Atom(self.set()?, start))
            }
            Some('*' | '+' | '?' | '{') => Err(self.error("there is nothing to repeat")),
            _ => {
                let start = self.at;
                let mut test = self.vertex()?;
                self.suffixes(&mut test)?;
                Ok(Node::Atom(Atom::one(test), start))
            }
        }
    }

    /// `[...]`, a set of vertices.
    pub fn set(&mut self) -> Result<Atom, ExpressionError> {
        let start = self.at;
        self.at += 1;
        let is_negated = self.take('^');
        let mut tests = Vec::new();
        loop {
            self.skip_space();
            match self.peek() {
                None => return Err(self.error_at(start, "this [ is not closed")),
                Some(']') => break,
                Some(_) => {
                    let mut test = self.vertex()?;
                    self.superscript(&mut test)?;
                    tests.push(test);
                }
            }
        }
        self.at += 1;
        if tests.is_empty() {
            return Err(self.error_at(start, "this set is empty"));
        }
        Ok(Atom { tests, is_negated })
    }
}
