//! Material libraries of OBJ files (MTL).
//!
//! Read are `newmtl`, `Kd`, `Ks`, `Ns`, `illum`, `d`, `Tr`, `map_Kd`, `map_Ks`, `map_d`, `map_bump` and `bump`; options of maps are skipped, and
//! so is everything else. [`MtlMaterial::bsdf`] makes of a material what Mitsuba 0.6 makes of it:
//!
//! | `illum` | plugin |
//! |---|---|
//! | 2, with `Ks` and `Ns` above zero | `phong` |
//! | 4, 6, 7, 9 | `dielectric` |
//! | 5, 8 | `conductor` of aluminium |
//! | others | `diffuse` |
//!
//! around which a bump map and an opacity below one, or a map of it, put `bumpmap` and `mask`. Colours are linear.

use super::obj_lines::Lines;
use super::text::{number, plain};

/// A material.
#[derive(Clone, Debug, PartialEq)]
pub struct MtlMaterial {
    /// Its name.
    pub name: String,
    diffuse: [f32; 3],
    specular: [f32; 3],
    exponent: f32,
    opacity: f32,
    model: u32,
    diffuse_map: Option<String>,
    specular_map: Option<String>,
    opacity_map: Option<String>,
    bump_map: Option<String>,
}

/// The materials of a library, in the order of the file.
pub fn read(bytes: &[u8]) -> Vec<MtlMaterial> {
    let bytes = plain(bytes);
    let mut lines = Lines::new(&bytes);
    let mut materials: Vec<MtlMaterial> = Vec::new();
    while let Some((_, line)) = lines.next() {
        let line = line.trim_ascii();
        let end = line.iter().position(u8::is_ascii_whitespace);
        let (keyword, rest) = line.split_at(end.unwrap_or(line.len()));
        let rest = rest.trim_ascii();
        if keyword.eq_ignore_ascii_case(b"newmtl") {
            materials.push(MtlMaterial::new(&String::from_utf8_lossy(rest)));
        } else if let Some(material) = materials.last_mut() {
            material.set(&keyword.to_ascii_lowercase(), rest);
        }
    }
    materials
}

impl MtlMaterial {
    fn new(name: &str) -> MtlMaterial {
        MtlMaterial {
            name: name.to_owned(),
            diffuse: [0.0; 3],
            specular: [0.0; 3],
            exponent: 0.0,
            opacity: 1.0,
            model: 0,
            diffuse_map: None,
            specular_map: None,
            opacity_map: None,
            bump_map: None,
        }
    }

    fn set(&mut self, keyword: &[u8], rest: &[u8]) {
        let first = || unit(rest).next();
        match keyword {
            b"kd" => self.diffuse = color(rest).unwrap_or(self.diffuse),
            b"ks" => self.specular = color(rest).unwrap_or(self.specular),
            b"ns" => self.exponent = first().unwrap_or(0.0),
            b"d" => self.opacity = first().unwrap_or(1.0),
            b"tr" => self.opacity = 1.0 - first().unwrap_or(0.0),
            b"illum" => self.model = first().unwrap_or(0.0) as u32,
            b"map_kd" => self.diffuse_map = file_of_map(rest),
            b"map_ks" => self.specular_map = file_of_map(rest),
            b"map_d" => self.opacity_map = file_of_map(rest),
            b"map_bump" | b"bump" => self.bump_map = file_of_map(rest),
            _ => {}
        }
    }

    /// The BSDF as XML of version 0.6, with its maps by name.
    pub fn bsdf(&self) -> String {
        let has_highlight = self.exponent > 0.0
            && (self.specular_map.is_some() || self.specular.iter().any(|v| *v > 0.0));
        let value = |name: &str, color: [f32; 3], map: &Option<String>| match map {
            Some(file) => texture(&format!(" name=\"{name}\""), file),
            None => {
                let [r, g, b] = color.map(|v| v.clamp(0.0, 1.0));
                format!("<rgb name=\"{name}\" value=\"{r} {g} {b}\"/>")
            }
        };
        let mut bsdf = match self.model {
            2 if has_highlight => format!(
                "<bsdf type=\"phong\">{}{}<float name=\"exponent\" value=\"{}\"/></bsdf>",
                value("diffuseReflectance", self.diffuse, &self.diffuse_map),
                value("specularReflectance", self.specular, &self.specular_map),
                self.exponent
            ),
            4 | 6 | 7 | 9 => "<bsdf type=\"dielectric\"/>".to_owned(),
            5 | 8 => "<bsdf type=\"conductor\"><string name=\"material\" value=\"Al\"/></bsdf>"
                .to_owned(),
            _ => format!(
                "<bsdf type=\"diffuse\">{}</bsdf>",
                value("reflectance", self.diffuse, &self.diffuse_map)
            ),
        };
        if let Some(file) = &self.bump_map {
            bsdf = format!("<bsdf type=\"bumpmap\">{}{bsdf}</bsdf>", texture("", file));
        }
        if self.opacity < 1.0 || self.opacity_map.is_some() {
            let opacity = self.opacity.clamp(0.0, 1.0);
            let opacity = value("opacity", [opacity; 3], &self.opacity_map);
            bsdf = format!("<bsdf type=\"mask\">{opacity}{bsdf}</bsdf>");
        }
        bsdf
    }
}

/// The numbers of a line that are usable.
fn unit(rest: &[u8]) -> impl Iterator<Item = f32> {
    let words = rest
        .split(u8::is_ascii_whitespace)
        .filter(|w| !w.is_empty());
    words.map_while(number::<f32>).filter(|v| v.is_finite())
}

/// A colour of three numbers, or of one for all channels.
fn color(rest: &[u8]) -> Option<[f32; 3]> {
    let numbers: Vec<f32> = unit(rest).take(3).collect();
    match numbers[..] {
        [r, g, b] => Some([r, g, b]),
        [grey] => Some([grey; 3]),
        _ => None,
    }
}

/// The file of a map, behind its options.
fn file_of_map(rest: &[u8]) -> Option<String> {
    let text = String::from_utf8_lossy(rest);
    let mut words = text.trim();
    while let Some(option) = words.strip_prefix('-') {
        let (name, after) = option.split_once(char::is_whitespace)?;
        // Numbers follow these, up to three, and one word the others.
        let is_vector = matches!(name, "o" | "s" | "t");
        let most = match name {
            _ if is_vector => 3,
            "mm" => 2,
            _ => 1,
        };
        words = after.trim_start();
        for i in 0..most {
            let Some((word, after)) = words.split_once(char::is_whitespace) else {
                break;
            };
            if i > 0 && word.parse::<f32>().is_err() {
                break;
            }
            words = after.trim_start();
        }
    }
    // Programs on Windows write its separators.
    (!words.is_empty()).then(|| words.replace('\\', "/"))
}

/// A bitmap as XML.
fn texture(name: &str, file: &str) -> String {
    let file = file
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('"', "&quot;");
    format!("<texture type=\"bitmap\"{name}><string name=\"filename\" value=\"{file}\"/></texture>")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_of_maps_are_skipped() {
        let file = |text: &str| file_of_map(text.as_bytes()).unwrap_or_default();
        assert_eq!(file("wood.png"), "wood.png");
        assert_eq!(file("-s 2 2 1 -o 0.5 a b\\my wood.png"), "a b/my wood.png");
        assert_eq!(file("-bm 0.3 -clamp on bump.png"), "bump.png");
        assert_eq!(file("-s 2 wood.png"), "wood.png");
        assert_eq!(file("-mm 0 1 wood.png"), "wood.png");
        assert_eq!(file_of_map(b""), None);
        assert_eq!(file_of_map(b"-clamp"), None);
    }

    #[test]
    fn materials_are_those_of_their_models() {
        let text = b"# comment\nKd 1 1 1\nnewmtl a b\nKd 0.1 0.2 0.3\nillum 2\nKs 0.5 0.5 0.5\nNs 20\n\
            newmtl glass\nillum 7\nnewmtl mirror\nillum 5\nd 0.25\nnewmtl flat\nKd 0.7\nKs 0 0 0\nNs 9\nillum 2\nmap_Kd a&b.png\n\
            map_bump h.png\n";
        let materials = read(text);
        let names: Vec<&str> = materials.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names, ["a b", "glass", "mirror", "flat"]);
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
        assert!(xml[3].starts_with("<bsdf type=\"bumpmap\">") && xml[3].contains("a&amp;b.png"));
        assert!(xml[3].contains("diffuse"));
    }
}
