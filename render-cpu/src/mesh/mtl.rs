//! Material libraries of OBJ files (MTL).
//!
//! Read are `newmtl`, `Kd`, `Ks`, `Ns`, `Ni`, `illum`, `d`, `Tr`, `map_Kd`, `map_Ks`, `map_d`, `map_bump` and `bump`, with options of
//! maps (`mtl_map`); ambient colours mean nothing here, and of everything else the reader is told ([`MtlMaterial::warnings`]).
//! [`MtlMaterial::bsdf`] makes of a material what Mitsuba 0.6 makes of it:
//!
//! | `illum` | plugin |
//! |---|---|
//! | 2, with `Ks` and `Ns` above zero | `phong` |
//! | 4, 6, 7, 9 | `dielectric`, of the index `Ni` where that is above one |
//! | 5, 8 | `conductor` of aluminium |
//! | others | `diffuse` |
//!
//! around which a bump map and an opacity below one, or a map of it, put `bumpmap` and `mask`. Colours are linear.

pub use super::mtl_map::Map;
use super::obj_lines::Lines;
use super::text::{number, plain};

/// Largest index of refraction that is one.
const MAX_INDEX: f32 = 5.0;

/// A material.
#[derive(Clone, Debug, PartialEq)]
pub struct MtlMaterial {
    /// Its name.
    pub name: String,
    /// Its first line.
    pub line: u64,
    /// What of it is not used as written: a line, and a sentence.
    pub warnings: Vec<(u64, String)>,
    diffuse: [f32; 3],
    specular: [f32; 3],
    exponent: f32,
    index: f32,
    opacity: f32,
    model: u32,
    diffuse_map: Option<Map>,
    specular_map: Option<Map>,
    opacity_map: Option<Map>,
    bump_map: Option<Map>,
}

/// The materials of a library, in the order of the file; of several with one name the last.
pub fn read(bytes: &[u8]) -> Vec<MtlMaterial> {
    let bytes = plain(bytes);
    let mut lines = Lines::new(&bytes);
    let mut materials: Vec<MtlMaterial> = Vec::new();
    while let Some((number, line)) = lines.next() {
        let line = line.trim_ascii();
        let end = line.iter().position(u8::is_ascii_whitespace);
        let (keyword, rest) = line.split_at(end.unwrap_or(line.len()));
        let rest = rest.trim_ascii();
        if keyword.eq_ignore_ascii_case(b"newmtl") {
            let name = String::from_utf8_lossy(rest);
            let mut material = MtlMaterial::new(&name, number);
            if let Some(index) = materials.iter().position(|m| m.name == name) {
                let what = "it is defined twice; this is the one that counts".to_owned();
                material.warnings.push((number, what));
                materials.remove(index);
            }
            materials.push(material);
        } else if let Some(material) = materials.last_mut() {
            material.set(&String::from_utf8_lossy(keyword), rest, number);
        }
    }
    for material in &mut materials {
        material.say_lost_highlight();
    }
    materials
}

impl MtlMaterial {
    fn new(name: &str, line: u64) -> MtlMaterial {
        MtlMaterial {
            name: name.to_owned(),
            line,
            warnings: Vec::new(),
            diffuse: [0.0; 3],
            specular: [0.0; 3],
            exponent: 0.0,
            index: 1.0,
            opacity: 1.0,
            model: 0,
            diffuse_map: None,
            specular_map: None,
            opacity_map: None,
            bump_map: None,
        }
    }

    fn set(&mut self, keyword: &str, rest: &[u8], line: u64) {
        let mut said = Vec::new();
        match keyword.to_ascii_lowercase().as_str() {
            "kd" => color(keyword, rest, &mut self.diffuse, &mut said),
            "ks" => color(keyword, rest, &mut self.specular, &mut said),
            "ns" => value(keyword, rest, &mut self.exponent, &mut said),
            "ni" => value(keyword, rest, &mut self.index, &mut said),
            "d" => {
                let rest = match rest.strip_prefix(b"-halo") {
                    Some(rest) => {
                        said.push("the opacity (d -halo) is the same in all directions".into());
                        rest.trim_ascii_start()
                    }
                    None => rest,
                };
                value(keyword, rest, &mut self.opacity, &mut said);
                self.clamp_opacity(keyword, &mut said);
            }
            "tr" => {
                let mut transparency = 1.0 - self.opacity;
                value(keyword, rest, &mut transparency, &mut said);
                self.opacity = 1.0 - transparency;
                self.clamp_opacity(keyword, &mut said);
            }
            "illum" => {
                let mut model = self.model as f32;
                value(keyword, rest, &mut model, &mut said);
                self.model = model as u32;
                if !(0.0..=10.0).contains(&model) {
                    said.push(format!("there is no model {model} (illum); it is diffuse"));
                }
            }
            "map_kd" => self.diffuse_map = map(keyword, rest, line, &mut said),
            "map_ks" => self.specular_map = map(keyword, rest, line, &mut said),
            "map_d" => self.opacity_map = map(keyword, rest, line, &mut said),
            "map_bump" | "bump" => self.bump_map = map(keyword, rest, line, &mut said),
            // Light from nowhere, and how sharp a mirror of an image is.
            "" | "ka" | "map_ka" | "sharpness" => {}
            // Exporters write what changes nothing, too.
            "ke" if numbers(rest).iter().all(|v| *v == 0.0) => {}
            "tf" if numbers(rest).iter().all(|v| *v == 1.0) => {}
            "ke" => said.push(
                "its light (Ke) is left out: in a scene, shapes shine by an area emitter".into(),
            ),
            _ => said.push(format!(
                "\"{}\" is not supported and is left out",
                keyword.escape_debug()
            )),
        }
        self.warnings
            .extend(said.into_iter().map(|what| (line, what)));
    }

    fn clamp_opacity(&mut self, keyword: &str, said: &mut Vec<String>) {
        if !(0.0..=1.0).contains(&self.opacity) {
            said.push(format!("{keyword} is clamped to [0, 1]"));
            self.opacity = self.opacity.clamp(0.0, 1.0);
        }
    }

    /// Whether it shines by Phong's model where that is asked for.
    fn has_highlight(&self) -> bool {
        self.exponent > 0.0 && self.has_specular()
    }

    fn has_specular(&self) -> bool {
        self.specular_map.is_some() || self.specular.iter().any(|v| *v > 0.0)
    }

    fn say_lost_highlight(&mut self) {
        let is_shiny = matches!(self.model, 4..=9) || self.model == 2 && self.has_highlight();
        if self.has_specular() && !is_shiny {
            let what =
                "its highlight (Ks) is left out: that takes illum 2 and an exponent Ns above 0";
            self.warnings.push((self.line, what.to_owned()));
        }
    }

    /// Its maps, which may be taken away.
    pub fn maps(&mut self) -> [&mut Option<Map>; 4] {
        [
            &mut self.diffuse_map,
            &mut self.specular_map,
            &mut self.opacity_map,
            &mut self.bump_map,
        ]
    }

    /// The BSDF as XML of version 0.6, with its maps by name.
    pub fn bsdf(&self) -> String {
        let value = |name: &str, color: [f32; 3], map: &Option<Map>| match map {
            Some(map) => map.texture(name),
            None => {
                let [r, g, b] = color.map(|v| v.clamp(0.0, 1.0));
                format!("<rgb name=\"{name}\" value=\"{r} {g} {b}\"/>")
            }
        };
        let mut bsdf = match self.model {
            2 if self.has_highlight() => format!(
                "<bsdf type=\"phong\">{}{}<float name=\"exponent\" value=\"{}\"/></bsdf>",
                value("diffuseReflectance", self.diffuse, &self.diffuse_map),
                value("specularReflectance", self.specular, &self.specular_map),
                self.exponent
            ),
            4 | 6 | 7 | 9 if self.index > 1.0 && self.index <= MAX_INDEX => format!(
                "<bsdf type=\"dielectric\"><float name=\"intIOR\" value=\"{}\"/></bsdf>",
                self.index
            ),
            4 | 6 | 7 | 9 => "<bsdf type=\"dielectric\"/>".to_owned(),
            5 | 8 => "<bsdf type=\"conductor\"><string name=\"material\" value=\"Al\"/></bsdf>"
                .to_owned(),
            _ => format!(
                "<bsdf type=\"diffuse\">{}</bsdf>",
                value("reflectance", self.diffuse, &self.diffuse_map)
            ),
        };
        if let Some(map) = &self.bump_map {
            let scale = match map.height {
                1.0 => String::new(),
                height => format!("<float name=\"scale\" value=\"{height}\"/>"),
            };
            let texture = map.texture("");
            bsdf = format!("<bsdf type=\"bumpmap\">{scale}{texture}{bsdf}</bsdf>");
        }
        if self.opacity < 1.0 || self.opacity_map.is_some() {
            let opacity = value("opacity", [self.opacity; 3], &self.opacity_map);
            bsdf = format!("<bsdf type=\"mask\">{opacity}{bsdf}</bsdf>");
        }
        bsdf
    }
}

/// The numbers that a line begins with.
fn numbers(rest: &[u8]) -> Vec<f32> {
    let words = rest
        .split(u8::is_ascii_whitespace)
        .filter(|w| !w.is_empty());
    words
        .map_while(number::<f32>)
        .filter(|v| v.is_finite())
        .collect()
}

/// A number of a line.
fn value(keyword: &str, rest: &[u8], value: &mut f32, said: &mut Vec<String>) {
    match numbers(rest).first() {
        Some(number) => *value = *number,
        None => said.push(format!("{keyword} is no number: \"{}\"", show(rest))),
    }
}

/// A colour of three numbers, or of one for all channels.
fn color(keyword: &str, rest: &[u8], color: &mut [f32; 3], said: &mut Vec<String>) {
    *color = match numbers(rest)[..] {
        [r, g, b, ..] => [r, g, b],
        [grey] => [grey; 3],
        _ => {
            said.push(format!("{keyword} is no RGB colour: \"{}\"", show(rest)));
            return;
        }
    };
    if color.iter().any(|v| !(0.0..=1.0).contains(v)) {
        said.push(format!("{keyword} is clamped to [0, 1]"));
    }
}

/// A map, with what is not understood of it.
fn map(keyword: &str, rest: &[u8], line: u64, said: &mut Vec<String>) -> Option<Map> {
    let (map, unknown) = Map::read(rest, line);
    for option in unknown {
        said.push(format!("the option {option} of {keyword} is left out"));
    }
    if map.is_none() {
        said.push(format!("{keyword} names no file"));
    }
    map
}

/// Bytes for a message: printable and not too long.
fn show(bytes: &[u8]) -> String {
    bytes[..bytes.len().min(40)].escape_ascii().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn materials_are_those_of_their_models() {
        let text = b"# comment\nKd 1 1 1\nnewmtl a b\nKd 0.1 0.2 0.3\nillum 2\nKs 0.5 0.5 0.5\nNs 20\n\
            newmtl glass\nillum 7\nnewmtl mirror\nillum 5\nd 0.25\nnewmtl flat\nKd 0.7\nKs 0 0 0\nNs 9\nillum 2\nmap_Kd a&b.png\n\
            map_bump -bm 3 h.png\nnewmtl water\nillum 4\nNi 1.33\n";
        let materials = read(text);
        let names: Vec<&str> = materials.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names, ["a b", "glass", "mirror", "flat", "water"]);
        let lines: Vec<u64> = materials.iter().map(|m| m.line).collect();
        assert_eq!(lines, [3, 8, 10, 13, 20]);
        assert!(materials.iter().all(|m| m.warnings.is_empty()));
        let xml: Vec<String> = materials.iter().map(MtlMaterial::bsdf).collect();
        assert!(
            xml[0].contains("phong")
                && xml[0].contains("\"0.1 0.2 0.3\"")
                && xml[0].contains("\"20\"")
        );
        assert_eq!(xml[1], "<bsdf type=\"dielectric\"/>");
        assert!(
            xml[2].contains("mask")
                && xml[2].contains("\"0.25 0.25 0.25\"")
                && xml[2].contains("Al")
        );
        assert!(xml[3].starts_with("<bsdf type=\"bumpmap\"><float name=\"scale\" value=\"3\"/>"));
        assert!(xml[3].contains("a&amp;b.png") && xml[3].contains("diffuse"));
        assert!(xml[4].contains("intIOR\" value=\"1.33\""));
    }

    #[test]
    fn of_two_materials_with_a_name_the_last_counts() {
        let materials = read(b"newmtl a\nKd 1 0 0\nPr 1\nnewmtl b\nnewmtl a\nKd 0 1 0\n");
        let names: Vec<&str> = materials.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names, ["b", "a"]);
        assert!(materials[1].bsdf().contains("\"0 1 0\""));
        let [(5, what)] = &materials[1].warnings[..] else {
            panic!("{:?}", materials[1].warnings);
        };
        assert!(what.contains("twice"), "{what}");
    }

    #[test]
    fn what_is_not_read_is_said() {
        // What changes nothing is not worth a word.
        let silent = "newmtl a\nKa 1 1 1\nKe 0 0 0\nTf 1 1 1\nNi 1.5\nmap_Kd -blendu on a.png\n\n";
        assert!(read(silent.as_bytes())[0].warnings.is_empty());
        for (line, words) in [
            ("Ke 1 0 0", "light (Ke)"),
            ("map_Ke a.png", "\"map_Ke\""),
            ("disp a.png", "\"disp\""),
            ("norm a.png", "\"norm\""),
            ("Tf 1 0 0", "\"Tf\""),
            ("Pr 0.5", "\"Pr\""),
            ("blub", "\"blub\""),
            ("Kd xyz 0.3 0.3 0.3", "no RGB colour: \"xyz"),
            ("Kd 0,8 0,1 0,1", "no RGB colour: \"0,8"),
            ("Kd 2 0 0", "clamped"),
            ("d -halo 0.5", "halo"),
            ("d half", "no number"),
            ("d 2", "d is clamped"),
            ("Tr -0.5", "Tr is clamped"),
            ("illum 12", "no model 12"),
            ("map_Kd -mm 0.5 1 a.png", "-mm 0.5 1"),
            ("map_Kd", "names no file"),
        ] {
            let materials = read(format!("newmtl a\n{line}\n").as_bytes());
            let said = &materials[0].warnings;
            assert_eq!(said.len(), 1, "{line}: {said:?}");
            assert!(said[0].0 == 2 && said[0].1.contains(words), "{said:?}");
        }
        for (lines, is_lost) in [
            ("illum 3\nKs 1 1 1\nNs 500", true),
            ("Kd 0.3 0.3 0.3\nKs 0.5 0.5 0.5\nNs 100", true),
            ("illum 2\nKs 0.5 0.5 0.5", true),
            ("illum 2\nKs 0.5 0.5 0.5\nNs 100", false),
            ("illum 5\nKs 1 1 1", false),
            ("illum 3\nKs 0 0 0", false),
        ] {
            let said = &read(format!("newmtl a\n{lines}\n").as_bytes())[0].warnings;
            let is_said = said
                .iter()
                .any(|(_, what)| what.contains("(Ks) is left out"));
            assert_eq!(is_said, is_lost, "{lines}: {said:?}");
        }
    }
}
