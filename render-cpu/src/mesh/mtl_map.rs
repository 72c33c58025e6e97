//! Maps in material libraries of OBJ files: a file behind options.
//!
//! Of the options, `-s` and `-o` scale and move the coordinates, in this order; `-clamp on` repeats the border; `-imfchan` takes
//! one channel; `-bm` is the height of a bump. Those that filter (`-blendu`, `-blendv`, `-boost`, `-texres`) change nothing here; of
//! the others the reader is told.

/// A map of a material.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Its file, with slashes between folders.
    pub file: String,
    /// The line of the library that names it.
    pub line: u64,
    scale: [f32; 2],
    offset: [f32; 2],
    is_clamped: bool,
    channel: Option<char>,
    pub(super) height: f32,
}

impl Map {
    /// The map of what stands behind a keyword, and the options that are not understood.
    pub(super) fn read(rest: &[u8], line: u64) -> (Option<Map>, Vec<String>) {
        let text = String::from_utf8_lossy(rest);
        let mut map = Map {
            file: String::new(),
            line,
            scale: [1.0; 2],
            offset: [0.0; 2],
            is_clamped: false,
            channel: None,
            height: 1.0,
        };
        let mut unknown = Vec::new();
        let mut words = text.trim();
        while let Some(option) = words.strip_prefix('-') {
            let Some((name, after)) = option.split_once(char::is_whitespace) else {
                return (None, unknown);
            };
            // Numbers follow these, up to three, and one word the others.
            let most = match name {
                "o" | "s" | "t" => 3,
                "mm" => 2,
                _ => 1,
            };
            words = after.trim_start();
            let mut values = Vec::new();
            for i in 0..most {
                let Some((word, after)) = words.split_once(char::is_whitespace) else {
                    break;
                };
                if i > 0 && word.parse::<f32>().is_err() {
                    break;
                }
                values.push(word);
                words = after.trim_start();
            }
            if !map.set(name, &values) {
                unknown.push(format!("-{name} {}", values.join(" ")));
            }
        }
        // Programs on Windows write its separators.
        map.file = words.replace('\\', "/");
        ((!words.is_empty()).then_some(map), unknown)
    }

    /// Whether an option is understood, which is remembered.
    fn set(&mut self, name: &str, values: &[&str]) -> bool {
        let number = |i: usize| values.get(i).and_then(|v| v.parse::<f32>().ok());
        let number = |i: usize| number(i).filter(|v| v.is_finite());
        match (name, values) {
            ("s", [_, ..]) => {
                self.scale = [number(0).unwrap_or(1.0), number(1).unwrap_or(1.0)];
                number(0).is_some()
            }
            ("o", [_, ..]) => {
                self.offset = [number(0).unwrap_or(0.0), number(1).unwrap_or(0.0)];
                number(0).is_some()
            }
            ("bm", [_]) => {
                self.height = number(0).unwrap_or(1.0);
                number(0).is_some()
            }
            ("clamp", [switch]) => {
                self.is_clamped = *switch == "on";
                true
            }
            ("imfchan", ["r" | "g" | "b"]) => {
                self.channel = values[0].chars().next();
                true
            }
            ("imfchan", ["m"]) => {
                self.channel = Some('a');
                true
            }
            ("blendu" | "blendv" | "boost" | "texres", _) => true,
            ("cc", [switch]) => *switch == "off",
            ("mm", _) => number(0).unwrap_or(0.0) == 0.0 && number(1).unwrap_or(1.0) == 1.0,
            ("t", _) => (0..3).all(|i| number(i).unwrap_or(0.0) == 0.0),
            _ => false,
        }
    }

    /// The map as a bitmap in XML of version 0.6, under a name if it has one.
    pub(super) fn texture(&self, name: &str) -> String {
        let file = self
            .file
            .replace('&', "&amp;")
            .replace('<', "&lt;")
            .replace('"', "&quot;");
        let mut properties = format!("<string name=\"filename\" value=\"{file}\"/>");
        let ([su, sv], [ou, ov]) = (self.scale, self.offset);
        if (self.scale, self.offset) != ([1.0; 2], [0.0; 2]) {
            // The file's coordinates start at the bottom of the image: 1 - (s (1 - v) + o).
            for (name, value) in [
                ("uscale", su),
                ("vscale", sv),
                ("uoffset", ou),
                ("voffset", 1.0 - sv - ov),
            ] {
                properties += &format!("<float name=\"{name}\" value=\"{value}\"/>");
            }
        }
        if self.is_clamped {
            properties += "<string name=\"wrapMode\" value=\"clamp\"/>";
        }
        if let Some(channel) = self.channel {
            properties += &format!("<string name=\"channel\" value=\"{channel}\"/>");
        }
        let name = match name {
            "" => String::new(),
            name => format!(" name=\"{name}\""),
        };
        format!("<texture type=\"bitmap\"{name}>{properties}</texture>")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_of_maps_are_read() {
        let read = |text: &str| Map::read(text.as_bytes(), 1);
        let file = |text: &str| read(text).0.map(|map| map.file).unwrap_or_default();
        assert_eq!(file("wood.png"), "wood.png");
        assert_eq!(file("-s 2 2 1 -o 0.5 a b\\my wood.png"), "a b/my wood.png");
        assert_eq!(file("-bm 0.3 -clamp on bump.png"), "bump.png");
        assert_eq!(file("-s 2 wood.png"), "wood.png");
        assert_eq!(file("-mm 0 1 wood.png"), "wood.png");
        assert_eq!(read(""), (None, vec![]));
        assert_eq!(read("-clamp").0, None);
        assert_eq!(read("-mm 0.2 1 -type sphere a.png").1.len(), 2);
        assert_eq!(read("-blendu on -mm 0 1 -cc off a.png").1.len(), 0);
        let (map, _) = read("-s 2 4 1 -o 0.5 0.25 0 -imfchan g -clamp on a.png");
        let xml = map
            .map(|map| map.texture("reflectance"))
            .unwrap_or_default();
        for part in [
            "name=\"uscale\" value=\"2\"",
            "name=\"vscale\" value=\"4\"",
            "name=\"uoffset\" value=\"0.5\"",
            "name=\"voffset\" value=\"-3.25\"",
            "value=\"clamp\"",
            "name=\"channel\" value=\"g\"",
        ] {
            assert!(xml.contains(part), "{xml}");
        }
    }
}
