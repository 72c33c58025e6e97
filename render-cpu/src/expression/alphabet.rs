//! The letters of expressions over a scene: vertices that no atom tells apart are one letter.
//!
//! A surface vertex is told by the kind of scattering, the classes of its shape and of its instance, and the regions that it
//! lies in; shapes that fit the same patterns of names are one class.

use super::error::ExpressionError;
use super::names::{SceneNames, is_named, light_kind, name, object_of_emitter, region};
use super::syntax::{Atom, NameKind, NamePattern, NameTest, VertexTest, kind};
use halflight_kernel::path::expression::{MAX_REGIONS, Region, scattering};
use halflight_kernel::path::scattered::kinds_of_lobe;
use halflight_kernel::scene::{NONE, Tables};
use std::collections::{BTreeSet, HashMap};

/// Most entries of the table of letters.
const MAX_ENTRIES: usize = 1 << 16;

/// The letters, and which atoms accept them.
pub(super) struct Alphabet {
    /// Class of each shape.
    pub shapes: Vec<u32>,
    /// Class of each instance.
    pub instances: Vec<u32>,
    /// Number of classes of instances.
    pub instance_classes: u32,
    /// The regions that atoms name.
    pub regions: Vec<Region>,
    /// Letter of a surface vertex, in the order of the kernel's table.
    pub letters: Vec<u32>,
    /// Letter of each emitter.
    pub emitters: Vec<u32>,
    /// Letter of the sensor.
    pub sensor: u32,
    /// By letter: whether each atom accepts it.
    pub accepted: Vec<Vec<bool>>,
}

/// A vertex for the tests of atoms: which patterns fit its names, and what else it is.
struct Candidate<'a> {
    kinds: u8,
    lights: u8,
    fits: &'a [bool],
    inside: u32,
}

/// Everything that atoms refer to.
struct References {
    patterns: HashMap<NamePattern, usize>,
    regions: HashMap<String, usize>,
}

impl Alphabet {
    /// Of the atoms of expressions, each with the text of its expression for messages.
    ///
    /// # Errors
    /// A name or a region that the scene does not have; too many of them.
    pub fn new(
        atoms: &[(Atom, String)],
        tables: &Tables<'_>,
        names: &SceneNames,
    ) -> Result<Alphabet, ExpressionError> {
        let mut references = References {
            patterns: HashMap::new(),
            regions: HashMap::new(),
        };
        let mut regions = Vec::new();
        for (atom, text) in atoms {
            for test in &atom.tests {
                for (pattern, at) in test.names.iter().flat_map(|n| &n.patterns) {
                    if is_name(pattern) && !is_named(pattern, tables, names) {
                        return Err(ExpressionError::new(text, *at, nothing_named(pattern)));
                    }
                    let next = references.patterns.len();
                    references.patterns.entry(pattern.clone()).or_insert(next);
                }
                for (wanted, at) in &test.regions {
                    if references.regions.contains_key(wanted) {
                        continue;
                    }
                    let error = |message: String| ExpressionError::new(text, *at, message);
                    let found = region(tables, names, wanted).ok_or_else(|| {
                        error(format!("the scene has no shape \"{wanted}\" for a region"))
                    })?;
                    if regions.len() == MAX_REGIONS {
                        return Err(error(format!("more than {MAX_REGIONS} regions")));
                    }
                    references.regions.insert(wanted.clone(), regions.len());
                    regions.push(found);
                }
            }
        }
        let mut patterns: Vec<(&NamePattern, usize)> =
            references.patterns.iter().map(|(p, i)| (p, *i)).collect();
        patterns.sort_by_key(|(_, i)| *i);
        let fits = |object: &str, material: &str, emitter: &str| -> Vec<bool> {
            let of = |p: &NamePattern| match p.kind {
                NameKind::Any => [object, material, emitter]
                    .iter()
                    .any(|n| !n.is_empty() && p.glob.matches(n)),
                NameKind::Object => !object.is_empty() && p.glob.matches(object),
                NameKind::Material => !material.is_empty() && p.glob.matches(material),
                NameKind::Emitter => !emitter.is_empty() && p.glob.matches(emitter),
            };
            patterns.iter().map(|(p, _)| of(p)).collect()
        };
        let (shapes, shape_fits) = classes(tables.shapes.iter().enumerate().map(|(i, shape)| {
            let material = name(&names.materials, shape.material as usize);
            fits(name(&names.shapes, i), material, "")
        }));
        let (instances, instance_fits) =
            classes((0..tables.instances.len()).map(|i| fits(name(&names.instances, i), "", "")));
        let subsets = 1usize << regions.len();
        let entries = shape_fits.len() * instance_fits.len() * subsets * scattering::COUNT as usize;
        if entries > MAX_ENTRIES {
            let text = atoms.first().map_or("", |(_, text)| text);
            let message = "these expressions tell too many objects and regions apart";
            return Err(ExpressionError::new(text, 0, message));
        }
        let mut found: HashMap<Vec<bool>, u32> = HashMap::new();
        let mut accepted: Vec<Vec<bool>> = Vec::new();
        let mut letter = |candidate: &Candidate<'_>| -> u32 {
            let accepts: Vec<bool> = atoms
                .iter()
                .map(|(atom, _)| references.accepts(atom, candidate))
                .collect();
            *found.entry(accepts).or_insert_with_key(|accepts| {
                accepted.push(accepts.clone());
                accepted.len() as u32 - 1
            })
        };
        let mut letters = Vec::with_capacity(entries);
        for shape in &shape_fits {
            for instance in &instance_fits {
                let both: Vec<bool> = shape.iter().zip(instance).map(|(a, b)| *a || *b).collect();
                for inside in 0..subsets {
                    for kind in 0..scattering::COUNT {
                        letters.push(letter(&Candidate {
                            kinds: 1 << kind,
                            lights: 0,
                            fits: &both,
                            inside: inside as u32,
                        }));
                    }
                }
            }
        }
        let mut emitters = Vec::with_capacity(tables.emitters.len());
        for (i, emitter) in tables.emitters.iter().enumerate() {
            let object = object_of_emitter(names, emitter.shape);
            emitters.push(letter(&Candidate {
                kinds: kind::LIGHT,
                lights: light_kind(emitter.kind),
                fits: &fits(object, "", name(&names.emitters, i)),
                inside: 0,
            }));
        }
        let sensor = letter(&Candidate {
            kinds: kind::SENSOR,
            lights: 0,
            fits: &vec![false; patterns.len()],
            inside: 0,
        });
        Ok(Alphabet {
            instance_classes: instance_fits.len() as u32,
            shapes,
            instances,
            regions,
            letters,
            emitters,
            sensor,
            accepted,
        })
    }
}

impl Alphabet {
    /// The letters of surface vertices that the lobes of the scene's materials allow.
    pub fn scattered(&self, tables: &Tables<'_>) -> Vec<u32> {
        let kinds = scattering::COUNT as usize;
        let places = self.instance_classes as usize * (1 << self.regions.len());
        let mut found = BTreeSet::new();
        for (shape, class) in tables.shapes.iter().zip(&self.shapes) {
            let Some(material) = tables.materials.get(shape.material as usize) else {
                continue;
            };
            let lobes = material.first_lobe..material.first_lobe + material.lobe_count;
            let may = lobes.fold(0, |may, lobe| {
                let record = &tables.lobes[lobe as usize];
                let own = kinds_of_lobe(record.kind);
                // A perturbed frame has other sides than the surface.
                let is_perturbed = record.frame != NONE;
                let sides = if is_perturbed { both_sides(own) } else { own };
                may | sides
            });
            let first = *class as usize * places;
            for place in first..first + places {
                let of_place = &self.letters[place * kinds..(place + 1) * kinds];
                let own = of_place.iter().enumerate();
                found.extend(
                    own.filter(|(kind, _)| may >> kind & 1 != 0)
                        .map(|(_, l)| *l),
                );
            }
        }
        found.into_iter().collect()
    }
}

/// The kinds of scattering of the bits, to both sides.
fn both_sides(kinds: u32) -> u32 {
    let reflections = 1 << scattering::DIFFUSE_REFLECTION
        | 1 << scattering::GLOSSY_REFLECTION
        | 1 << scattering::SPECULAR_REFLECTION;
    kinds | (kinds & reflections) << 1 | kinds >> 1 & reflections
}

impl References {
    fn accepts(&self, atom: &Atom, candidate: &Candidate<'_>) -> bool {
        atom.tests.iter().any(|test| self.holds(test, candidate)) != atom.is_negated
    }

    fn holds(&self, test: &VertexTest, candidate: &Candidate<'_>) -> bool {
        let is_light = candidate.kinds == kind::LIGHT;
        let fits = |names: &NameTest| {
            let mut patterns = names.patterns.iter();
            patterns.any(|(p, _)| candidate.fits[self.patterns[p]]) != names.is_negated
        };
        test.kinds & candidate.kinds != 0
            && (!is_light || test.lights & candidate.lights != 0)
            && test.names.iter().all(fits)
            && (test.regions.iter()).all(|(r, _)| candidate.inside >> self.regions[r] & 1 != 0)
    }
}

/// Whether a pattern is a name, which the scene must have, and not one that may fit nothing.
fn is_name(pattern: &NamePattern) -> bool {
    !pattern.glob.as_str().contains(['*', '?'])
}

/// That nothing has a name.
fn nothing_named(pattern: &NamePattern) -> String {
    let glob = pattern.glob.as_str();
    let kind = match pattern.kind {
        NameKind::Any => "nothing",
        NameKind::Object => "no object",
        NameKind::Material => "no material",
        NameKind::Emitter => "no emitter",
    };
    let known = ["object", "material", "emitter"];
    let hint = match glob.split_once(':') {
        Some((before, _)) if pattern.kind == NameKind::Any && !known.contains(&before) => {
            "; before a colon stands object, material or emitter"
        }
        _ => "",
    };
    format!("the scene has {kind} named \"{glob}\"{hint}")
}

/// Numbers equal values; returns the number of each and the values by number.
fn classes(values: impl Iterator<Item = Vec<bool>>) -> (Vec<u32>, Vec<Vec<bool>>) {
    let mut found: HashMap<Vec<bool>, u32> = HashMap::new();
    let mut list = Vec::new();
    let numbers = values
        .map(|value| {
            *found.entry(value).or_insert_with_key(|value| {
                list.push(value.clone());
                list.len() as u32 - 1
            })
        })
        .collect();
    (numbers, list)
}
