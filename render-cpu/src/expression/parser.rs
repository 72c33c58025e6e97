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
use super::syntax::{Atom, NameKind, NamePattern, NameTest, Node, VertexTest, kind, light};

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

struct Parser<'a> {
    text: &'a str,
    chars: Vec<char>,
    at: usize,
    depth: usize,
    from_camera: bool,
}

impl Parser<'_> {
    fn error(&self, message: impl Into<String>) -> ExpressionError {
        self.error_at(self.at, message)
    }

    fn error_at(&self, position: usize, message: impl Into<String>) -> ExpressionError {
        ExpressionError::new(self.text, position, message)
    }

    fn peek(&self) -> Option<char> {
        self.chars.get(self.at).copied()
    }

    fn skip_space(&mut self) {
        while self.peek().is_some_and(char::is_whitespace) {
            self.at += 1;
        }
    }

    /// Takes the character if it is the next one.
    fn take(&mut self, c: char) -> bool {
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
            let (least, most) = match self.peek() {
                Some('*') => (0, None),
                Some('+') => (1, None),
                Some('?') => (0, Some(1)),
                Some('{') => self.counts()?,
                _ => return Ok(node),
            };
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
            Some('[') => Ok(Node::Atom(self.set()?)),
            Some('*' | '+' | '?' | '{') => Err(self.error("there is nothing to repeat")),
            _ => {
                let mut test = self.vertex()?;
                self.suffixes(&mut test)?;
                Ok(Node::Atom(Atom::one(test)))
            }
        }
    }

    /// `[...]`, a set of vertices.
    fn set(&mut self) -> Result<Atom, ExpressionError> {
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

    /// A letter, a dot or `<...>`.
    fn vertex(&mut self) -> Result<VertexTest, ExpressionError> {
        let start = self.at;
        let Some(c) = self.peek() else {
            return Err(self.error("something is missing here"));
        };
        if c == '<' {
            return self.labelled();
        }
        let test = self.letter(c).ok_or_else(|| self.unknown(c))?;
        let ends = if self.from_camera { 'E' } else { 'C' };
        if c == ends {
            let message = if self.from_camera {
                "E is the sensor in expressions from the light; from the camera it is C"
            } else {
                "C begins an expression from the camera; from the light the sensor is E"
            };
            return Err(self.error_at(start, message));
        }
        self.at += 1;
        Ok(test)
    }

    fn letter(&self, c: char) -> Option<VertexTest> {
        let mut test = VertexTest::of(match c {
            '.' => kind::ANY,
            'L' | 'O' | 'B' => kind::LIGHT,
            'E' | 'C' => kind::SENSOR,
            'D' => kind::DIFFUSE,
            'G' => kind::GLOSSY,
            'S' => kind::SPECULAR,
            'X' => kind::SURFACE,
            'R' => kind::REFLECTED,
            'T' => kind::TRANSMITTED,
            _ => return None,
        });
        test.lights = match c {
            'O' => light::OBJECT,
            'B' => light::BACKGROUND,
            _ => light::ANY,
        };
        Some(test)
    }

    fn unknown(&self, c: char) -> ExpressionError {
        self.error(match c {
            'V' => "volumes scatter nothing here, so that no path has a V".to_owned(),
            's' => "what passes straight through a mask is no vertex".to_owned(),
            c => format!(
                "'{}' is none of L O B (light), D G S X (surface), R T, . and {}",
                c.escape_debug(),
                if self.from_camera {
                    "C (camera)"
                } else {
                    "E (sensor)"
                }
            ),
        })
    }

    /// `<` type, scattering, labels `>`.
    fn labelled(&mut self) -> Result<VertexTest, ExpressionError> {
        let start = self.at;
        self.at += 1;
        let mut test = VertexTest::of(kind::ANY);
        for part in 0..2 {
            self.skip_space();
            let here = self.at;
            match self.peek() {
                None => return Err(self.error_at(start, "this < is not closed")),
                Some('>' | '\'' | '"') => break,
                Some('[') => {
                    let set = self.set()?;
                    let union = set.tests.iter().fold(0, |kinds, t| kinds | t.kinds);
                    if set.tests.iter().any(|t| !t.names.is_empty()) {
                        return Err(self.error_at(here, "labels stand behind both letters"));
                    }
                    test.kinds &= if set.is_negated { !union } else { union };
                }
                Some(c) => {
                    let is_place = match part {
                        0 => "RTLOBCE.".contains(c),
                        _ => "DGS.".contains(c),
                    };
                    let own = self.letter(c).filter(|_| is_place);
                    let Some(own) = own else {
                        if c == 'V' || c == 's' {
                            return Err(self.unknown(c));
                        }
                        return Err(self.error(match part {
                            0 => "expected one of R T L O B C . first",
                            _ => "expected one of D G S . second",
                        }));
                    };
                    test.kinds &= own.kinds;
                    test.lights &= own.lights;
                    self.at += 1;
                }
            }
        }
        loop {
            self.skip_space();
            match self.peek() {
                None => return Err(self.error_at(start, "this < is not closed")),
                Some('>') => break,
                Some('.') => self.at += 1,
                Some('\'' | '"') => {
                    let (pattern, here) = self.quoted()?;
                    let pattern = self.pattern(&pattern, here)?;
                    test.names.push(NameTest {
                        patterns: vec![(pattern, here)],
                        is_negated: false,
                    });
                }
                Some(_) => return Err(self.error("expected a label in quotes, or >")),
            }
        }
        self.at += 1;
        if test.kinds == 0 {
            return Err(self.error_at(start, "no vertex is both"));
        }
        Ok(test)
    }

    /// What may stand right behind a letter.
    fn suffixes(&mut self, test: &mut VertexTest) -> Result<(), ExpressionError> {
        loop {
            self.superscript(test)?;
            let behind = self.chars.get(self.at + 1).copied();
            match self.peek() {
                Some('[') if !self.from_camera => self.names(test)?,
                Some('{')
                    if behind.is_some_and(|c| !c.is_ascii_digit() && c != ',' && c != ' ') =>
                {
                    self.region(test)?;
                }
                _ => return Ok(()),
            }
        }
    }

    /// `^R` or `^T`.
    fn superscript(&mut self, test: &mut VertexTest) -> Result<(), ExpressionError> {
        let start = self.at;
        if !self.take('^') {
            return Ok(());
        }
        test.kinds &= match self.peek() {
            Some('R') => kind::REFLECTED,
            Some('T') => kind::TRANSMITTED,
            _ => return Err(self.error("expected R or T behind ^")),
        };
        if test.kinds == 0 {
            return Err(self.error_at(start, "no vertex is both"));
        }
        self.at += 1;
        Ok(())
    }

    /// `[name, ...]` behind a letter.
    fn names(&mut self, test: &mut VertexTest) -> Result<(), ExpressionError> {
        let start = self.at;
        if test.kinds == kind::SENSOR {
            return Err(self.error("the sensor has no names"));
        }
        self.at += 1;
        let is_negated = self.take('^');
        let mut patterns = Vec::new();
        loop {
            self.skip_space();
            let here = self.at;
            let (name, here) = match self.peek() {
                None => return Err(self.error_at(start, "this [ is not closed")),
                Some('\'' | '"') => self.quoted()?,
                Some(_) => {
                    while self.peek().is_some_and(|c| !"],".contains(c)) {
                        self.at += 1;
                    }
                    let name: String = self.chars[here..self.at].iter().collect();
                    (name.trim().to_owned(), here)
                }
            };
            patterns.push((self.pattern(&name, here)?, here));
            self.skip_space();
            match self.peek() {
                Some(',') => self.at += 1,
                Some(']') => break,
                None => return Err(self.error_at(start, "this [ is not closed")),
                Some(_) => return Err(self.error("expected , or ] behind the name")),
            }
        }
        self.at += 1;
        test.names.push(NameTest {
            patterns,
            is_negated,
        });
        Ok(())
    }

    /// Text in quotes, and where it begins.
    fn quoted(&mut self) -> Result<(String, usize), ExpressionError> {
        let start = self.at;
        let quote = self.chars[start];
        let rest = &self.chars[start + 1..];
        let Some(length) = rest.iter().position(|c| *c == quote) else {
            return Err(self.error("this quote is not closed"));
        };
        self.at = start + length + 2;
        Ok((rest[..length].iter().collect(), start + 1))
    }

    fn pattern(&self, name: &str, here: usize) -> Result<NamePattern, ExpressionError> {
        let kinds = [
            ("object:", NameKind::Object),
            ("material:", NameKind::Material),
            ("emitter:", NameKind::Emitter),
        ];
        let prefixed = kinds.into_iter().find_map(|(prefix, kind)| {
            name.strip_prefix(prefix)
                .map(|rest| (kind, rest.trim_start()))
        });
        let (kind, glob) = prefixed.unwrap_or((NameKind::Any, name));
        if glob.is_empty() {
            return Err(self.error_at(here, "expected a name"));
        }
        // Brackets are no pattern here, and stars in a row are one.
        let mut escaped = String::new();
        for c in glob.chars() {
            match c {
                '[' | ']' => escaped.extend(['[', c, ']']),
                '*' if escaped.ends_with('*') => {}
                c => escaped.push(c),
            }
        }
        let glob = glob::Pattern::new(&escaped)
            .map_err(|e| self.error_at(here, format!("this is no pattern of names: {}", e.msg)))?;
        Ok(NamePattern { kind, glob })
    }

    /// `{name}` behind a letter.
    fn region(&mut self, test: &mut VertexTest) -> Result<(), ExpressionError> {
        let start = self.at;
        if test.kinds & !kind::SURFACE != 0 {
            return Err(self.error("regions are of vertices on surfaces: D, G, S or X"));
        }
        self.at += 1;
        let (name, here) = if matches!(self.peek(), Some('\'' | '"')) {
            self.quoted()?
        } else {
            let here = self.at;
            while self.peek().is_some_and(|c| c != '}') {
                self.at += 1;
            }
            let name: String = self.chars[here..self.at].iter().collect();
            (name.trim().to_owned(), here)
        };
        if !self.take('}') {
            return Err(self.error_at(start, "this { is not closed"));
        }
        if name.is_empty() {
            return Err(self.error_at(here, "expected the name of a region"));
        }
        test.regions.push((name, here));
        Ok(())
    }
}
