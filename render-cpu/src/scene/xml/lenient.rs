//! Scene files that are not well-formed XML, but that Mitsuba's readers accept.
//!
//! Mitsuba 2 and 3 read with pugixml, which is more lenient than the XML recommendation; version 0.6 (Xerces) checks more but
//! supports document types. [`repair`] rewrites a text so that a conforming reader accepts it:
//! - the XML declaration is removed (the text is decoded already), so that white space may precede it;
//! - a document type is removed, unless it declares entities, which scenes do not need and hostile files misuse;
//! - comments become blank, since they may contain `--`;
//! - an `&` that begins no reference, and a `<` within an attribute, become references;
//! - attributes that follow each other without white space are separated.
//!
//! Removed text is replaced by blanks and line feeds, so that lines and columns in messages remain those of the file; an
//! insertion moves only the columns behind it on its line.

use std::borrow::Cow;

/// The text, well-formed where it was only nearly so.
pub fn repair(text: &str) -> Cow<'_, str> {
    let mut repairer = Repairer {
        text,
        at: 0,
        copied: 0,
        output: String::new(),
    };
    while repairer.at < text.len() {
        repairer.step();
    }
    if repairer.copied == 0 {
        return Cow::Borrowed(text);
    }
    repairer.output.push_str(&text[repairer.copied..]);
    Cow::Owned(repairer.output)
}

struct Repairer<'a> {
    text: &'a str,
    /// Where reading has come to; always at the first byte of a character.
    at: usize,
    /// What has been written to the output.
    copied: usize,
    output: String,
}

impl<'a> Repairer<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
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
        let Some(special) = rest.find(['<', '&']) else {
            self.at = self.text.len();
            return;
        };
        self.at += special;
        let rest = self.rest();
        if rest.starts_with('&') {
            self.ampersand();
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
        } else {
            self.at += 1;
            self.tag();
        }
    }

    /// An element's tag, after its first character.
    fn tag(&mut self) {
        while let Some(special) = self.rest().find(['>', '"', '\'']) {
            let quote = self.rest()[special..].chars().next();
            self.at += special + 1;
            let Some(quote @ ('"' | '\'')) = quote else {
                return;
            };
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
        while let Some(special) = self.rest().find([quote, '<', '&']) {
            self.at += special;
            if self.rest().starts_with(quote) {
                self.at += 1;
                return true;
            }
            if self.rest().starts_with('<') {
                self.replace(1, "&lt;");
            } else {
                self.ampersand();
            }
        }
        self.at = self.text.len();
        false
    }

    /// An ampersand, which may begin a reference.
    fn ampersand(&mut self) {
        if is_reference(self.rest()) {
            self.at += 1;
        } else {
            self.replace(1, "&amp;");
        }
    }
}

/// Whether a text that begins with an ampersand begins with a reference to a character.
fn is_reference(text: &str) -> bool {
    // The longest is &#x10FFFF;
    let Some(end) = text.bytes().take(12).position(|b| b == b';') else {
        return false;
    };
    let name = &text[1..end];
    if matches!(name, "lt" | "gt" | "amp" | "quot" | "apos") {
        return true;
    }
    let code = match (name.strip_prefix("#x"), name.strip_prefix('#')) {
        (Some(digits), _) => u32::from_str_radix(digits, 16).ok(),
        (None, Some(digits)) => digits.parse().ok(),
        (None, None) => None,
    };
    code.and_then(char::from_u32).is_some()
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
        assert_eq!(repair(text), text);
        assert!(matches!(repair(text), std::borrow::Cow::Borrowed(_)));
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
            ("é<!--é--><a/>", "é        <a/>"),
        ] {
            assert_eq!(repair(text), repaired, "{text}");
        }
        // Entities stay for the reader to refuse.
        let hostile = "<!DOCTYPE a [<!ENTITY x \"y\">]><a>&x;</a>";
        assert!(repair(hostile).contains("<!ENTITY"));
    }
}
