//! Reads what stands for one vertex in a path expression: letters, `<...>`, superscripts, names and regions.

use super::error::ExpressionError;
use super::parser::Parser;
use super::syntax::{NameKind, NamePattern, NameTest, VertexTest, kind, light};

impl Parser<'_> {
    /// A letter, a dot or `<...>`.
    pub fn vertex(&mut self) -> Result<VertexTest, ExpressionError> {
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
        self.skip_space();
        if self.peek() == Some('>') {
            return Err(self.error_at(start, "nothing stands between < and >; any vertex is ."));
        }
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
                    let kind = self.letter(c).filter(|_| is_place);
                    let Some(kind) = kind else {
                        if c == 'V' || c == 's' {
                            return Err(self.unknown(c));
                        }
                        return Err(self.error(match part {
                            0 => "expected one of R T L O B C . first",
                            _ => "expected one of D G S . second",
                        }));
                    };
                    test.kinds &= kind.kinds;
                    test.lights &= kind.lights;
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
    pub fn suffixes(&mut self, test: &mut VertexTest) -> Result<(), ExpressionError> {
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
    pub fn superscript(&mut self, test: &mut VertexTest) -> Result<(), ExpressionError> {
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
                Some('^') => {
                    let message = "^ stands once, before all names: none of them is meant";
                    return Err(self.error(message));
                }
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
