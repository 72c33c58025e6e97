//! Scene files that are not well-formed XML, but that Mitsuba's readers accept.
//!
//! Mitsuba 2 and 3 read with pugixml, which is more lenient than the XML recommendation; version 0.6 (Xerces) checks more but
//! supports document types. [`repair`] rewrites a text so that a conforming reader accepts it:
//! - the XML declaration is removed (the text is decoded already), so that white space may precede it;
//! - a document type is removed, unless it declares entities, which scenes do not need and hostile files misuse;
//! - comments become blank, since they may contain `--`;
//! - an `&` that begins no reference, and a `<` within an attribute, become references;
//! - attributes that follow each other without white space are separated;
//! - characters that XML forbids, and references to them, become blanks;
//! - text outside of the outermost element, whatever follows it, and attributes that an element has already are removed, which
//!   is said.
//!
//! Removed text is replaced by blanks and line feeds, so that lines and columns in messages remain those of the file; an
//! insertion moves only the columns behind it on its line.

use std::borrow::Cow;

/// Most sentences about one file.
const MAX_NOTES: usize = 100;

/// A text that is well-formed where it was only nearly so.
pub struct Repaired<'a> {
    /// The text.
    pub text: Cow<'a, str>,
    /// What was left out, each with its line, counted from 1.
    pub notes: Vec<(u32, &'static str)>,
}

/// The text, well-formed where it was only nearly so.
pub fn repair(text: &str) -> Repaired<'_> {
    let mut repairer = Repairer {
        text,
        at: 0,
        copied: 0,
        output: String::new(),
        depth: 0,
        has_root: false,
        notes: Vec::new(),
    };
    while repairer.at < text.len() {
        repairer.step();
    }
    let notes = std::mem::take(&mut repairer.notes);
    if repairer.copied == 0 {
        let text = Cow::Borrowed(text);
        return Repaired { text, notes };
    }
    repairer.output.push_str(&text[repairer.copied..]);
    let text = Cow::Owned(repairer.output);
    Repaired { text, notes }
}

/// Whether XML forbids a character.
fn is_control(c: char) -> bool {
    (c < ' ' && !matches!(c, '\t' | '\n' | '\r')) || matches!(c, '\u{fffe}' | '\u{ffff}')
}

struct Repairer<'a> {
    text: &'a str,
    /// Where reading has come to; always at the first byte of a character.
    at: usize,
    /// What has been written to the output.
    copied: usize,
    output: String,
    /// Open elements.
    depth: usize,
    /// Whether the outermost element has begun.
    has_root: bool,
    notes: Vec<(u32, &'static str)>,
}

impl<'a> Repairer<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    /// Warns of something at this position.
    fn note(&mut self, what: &'static str) {
        if self.notes.len() < MAX_NOTES {
            let line = self.text[..self.at].matches('\n').count() + 1;
            self.notes.push((line as u32, what));
        }
    }

    /// Replaces the text up to byte `end` of what is left.
    fn replace(&mut self, end: usize, with: &str) {
        self.output.push_str(&self.text[self.copied..self.at]);
        self.output.push_str(with);
        self.at += end;
        self.copied = self.at;
    }

    /// Replaces the text up to byte `end` of what is left by blanks and its line feeds.
    fn blank(&mut self, end: usize) {
        let blanks: String = self.rest()[..end]
            .chars()
            .map(|c| if c == '\n' { '\n' } else { ' ' })
            .collect();
        self.replace(end, &blanks);
    }

    /// Processes text between elements.
    fn step(&mut self) {
        let rest = self.rest();
        if self.depth == 0 {
            let end = rest.find('<').unwrap_or(rest.len());
            if end > 0 {
                return self.outside(end);
            }
        }
        let special = |c: char| matches!(c, '<' | '&') || is_control(c);
        let Some(special) = rest.find(special) else {
            self.at = self.text.len();
            return;
        };
        self.at += special;
        let rest = self.rest();
        if rest.starts_with('&') {
            self.ampersand();
        } else if rest.starts_with(is_control) {
            self.control();
        } else if let Some(comment) = rest.strip_prefix("<!--") {
            match comment.find("-->") {
                Some(end) => self.blank(4 + end + 3),
                None => self.at = self.text.len(),
            }
        } else if rest.starts_with("<![CDATA[") {
            self.at += rest.find("]]>").unwrap_or(rest.len());
        } else if rest.starts_with("<?") {
            match rest.find("?>") {
                Some(end) if rest.starts_with("<?xml") => self.blank(end + 2),
                Some(end) => self.at += end + 2,
                None => self.at = self.text.len(),
            }
        } else if rest.starts_with("<!DOCTYPE") {
            match document_type_end(rest) {
                Some(end) if !rest[..end].contains("<!ENTITY") => self.blank(end),
                Some(end) => self.at += end,
                None => self.at = self.text.len(),
            }
        } else if self.has_root && self.depth == 0 {
            self.note("what stands behind the outermost element is left out");
            self.blank(rest.len());
        } else {
            self.at += 1;
            self.tag();
        }
    }

    /// Text outside of the outermost element, of `end` bytes.
    fn outside(&mut self, end: usize) {
        let text = &self.rest()[..end];
        if text.chars().all(char::is_whitespace) {
            self.at += end;
            return;
        }
        if let Some(start) = text.find(|c: char| !c.is_whitespace() && !is_control(c)) {
            let before = self.at;
            self.at += start;
            self.note("text outside of the outermost element is left out");
            self.at = before;
        }
        self.blank(end);
    }

    /// A character that XML forbids.
    fn control(&mut self) {
        let length = self.rest().chars().next().map_or(0, char::len_utf8);
        self.replace(length, " ");
    }

    /// An element's tag, after its first character.
    fn tag(&mut self) {
        let is_closing = self.rest().starts_with('/');
        let mut names: Vec<&str> = Vec::new();
        while let Some(special) = self.rest().find(['>', '"', '\'']) {
            let rest = self.rest();
            let before = &rest[..special];
            let quote = rest[special..].chars().next();
            let Some(quote @ ('"' | '\'')) = quote else {
                self.at += special + 1;
                self.has_root = true;
                if is_closing {
                    self.depth = self.depth.saturating_sub(1);
                } else if !before.ends_with('/') {
                    self.depth += 1;
                }
                return;
            };
            let name = before.trim_end().trim_end_matches('=').trim_end();
            let name = &name[name
                .rfind(|c: char| c.is_ascii_whitespace())
                .map_or(0, |at| at + 1)..];
            let value = &rest[special + 1..];
            if names.contains(&name)
                && !name.is_empty()
                && let Some(end) = value.find(quote)
            {
                self.note("an attribute is there twice; the first one counts");
                let start = special - (before.len() - before.rfind(name).unwrap_or(special));
                self.at += start;
                self.blank(special - start + 1 + end + 1);
                continue;
            }
            names.push(name);
            self.at += special + 1;
            if !self.quoted(quote) {
                return;
            }
            let next = self.rest().chars().next();
            if next.is_some_and(|c| !c.is_whitespace() && !matches!(c, '/' | '>' | '?')) {
                self.replace(0, " ");
            }
        }
        self.at = self.text.len();
    }

    /// An attribute's value, after its opening quote; whether it ends.
    fn quoted(&mut self, quote: char) -> bool {
        let special = |c: char| c == quote || matches!(c, '<' | '&') || is_control(c);
        while let Some(special) = self.rest().find(special) {
            self.at += special;
            if self.rest().starts_with(quote) {
                self.at += 1;
                return true;
            }
            if self.rest().starts_with('<') {
                self.replace(1, "&lt;");
            } else if self.rest().starts_with('&') {
                self.ampersand();
            } else {
                self.control();
            }
        }
        self.at = self.text.len();
        false
    }

    /// An ampersand, which may begin a reference.
    fn ampersand(&mut self) {
        match reference(self.rest()) {
            Reference::None => self.replace(1, "&amp;"),
            Reference::Allowed => self.at += 1,
            Reference::Forbidden(length) => self.replace(length, " "),
        }
    }
}

/// What an ampersand begins.
enum Reference {
    /// No reference.
    None,
    /// A reference to a character.
    Allowed,
    /// A reference, of this length, to a character that XML forbids.
    Forbidden(usize),
}

/// Whether a text that begins with an ampersand begins with a reference to a character.
fn reference(text: &str) -> Reference {
    // The longest is &#x10FFFF;
    let Some(end) = text.bytes().take(12).position(|b| b == b';') else {
        return Reference::None;
    };
    let name = &text[1..end];
    if matches!(name, "lt" | "gt" | "amp" | "quot" | "apos") {
        return Reference::Allowed;
    }
    let code = match (name.strip_prefix("#x"), name.strip_prefix('#')) {
        (Some(digits), _) => u32::from_str_radix(digits, 16).ok(),
        (None, Some(digits)) => digits.parse().ok(),
        (None, None) => None,
    };
    match code.and_then(char::from_u32) {
        None => Reference::None,
        Some(c) if is_control(c) => Reference::Forbidden(end + 1),
        Some(_) => Reference::Allowed,
    }
}

/// The length of a document type, its internal subset included.
fn document_type_end(text: &str) -> Option<usize> {
    let mut depth = 0_usize;
    for (at, c) in text.char_indices() {
        match c {
            '[' => depth += 1,
            ']' => depth = depth.saturating_sub(1),
            '>' if depth == 0 => return Some(at + 1),
            _ => {}
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::repair;

    #[test]
    fn well_formed_text_is_left_alone() {
        let text = "<a b=\"1 &amp; &#38; &#x26;\" c='x'>\n<b/>text<![CDATA[ a & b < c ]]></a>";
        let repaired = repair(text);
        assert_eq!(repaired.text, text);
        assert!(matches!(repaired.text, std::borrow::Cow::Borrowed(_)));
        assert!(repaired.notes.is_empty());
    }

    #[test]
    fn what_is_not_well_formed_is_repaired_in_place() {
        for (text, repaired) in [
            ("<a b=\"R&D\"/>", "<a b=\"R&amp;D\"/>"),
            (
                "<a b=\"1&2;&nbsp;&#x;&#xD800;\"/>",
                "<a b=\"1&amp;2;&amp;nbsp;&amp;#x;&amp;#xD800;\"/>",
            ),
            ("<a b='x<y>z'/>", "<a b='x&lt;y>z'/>"),
            ("<a b=\"1\"c=\"2\"/>", "<a b=\"1\" c=\"2\"/>"),
            ("<a>x & y</a>", "<a>x &amp; y</a>"),
            (
                "<a><!-- x -- y\n-- --><b/></a>",
                "<a>           \n      <b/></a>",
            ),
            (
                "\n <?xml version='1.0'?><a/>",
                "\n                      <a/>",
            ),
            (
                "<!DOCTYPE a SYSTEM \"x\">\n<a/>",
                "                       \n<a/>",
            ),
            (
                "<!DOCTYPE a [ <!ELEMENT a ANY> ]><a/>",
                "                                 <a/>",
            ),
            ("<a b=\"&", "<a b=\"&amp;"),
            ("<!-- open", "<!-- open"),
            ("<a>é<!--é--></a>", "<a>é        </a>"),
            ("<a>\u{c}</a>\0", "<a> </a> "),
            ("<a b=\"x\u{1}y&#1;z\"/>", "<a b=\"x y z\"/>"),
        ] {
            let result = repair(text);
            assert_eq!(result.text, repaired, "{text}");
            assert!(result.notes.is_empty(), "{text}: {:?}", result.notes);
        }
        // Entities stay for the reader to refuse.
        let hostile = "<!DOCTYPE a [<!ENTITY x \"y\">]><a>&x;</a>";
        assert!(repair(hostile).text.contains("<!ENTITY"));
    }

    #[test]
    fn what_is_left_out_is_said_with_its_line() {
        for (text, repaired, line) in [
            ("x <a/>", "  <a/>", 1),
            ("<a>\n<b/></a>\n end", "<a>\n<b/></a>\n    ", 3),
            ("<a/>\n<a>\n</a>", "<a/>\n   \n    ", 2),
            ("<a\nb='1' b='2' c='3'/>", "<a\nb='1'       c='3'/>", 2),
            ("<a b=\"1\" b = \"&\"/>", "<a b=\"1\"        />", 1),
        ] {
            let result = repair(text);
            assert_eq!(result.text, repaired, "{text}");
            assert_eq!(result.notes.len(), 1, "{text}: {:?}", result.notes);
            assert_eq!(result.notes[0].0, line, "{text}");
        }
        // Blanks of other alphabets separate nothing.
        assert!(repair("<a\u{a0}b=\"1\" \u{2003}c='2'/>").notes.is_empty());
        // Names within values are none.
        let text = "<a x='b=1' b='2'><a b='3'/></a>";
        assert!(repair(text).notes.is_empty());
    }
}
