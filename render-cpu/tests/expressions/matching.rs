//! Expressions against a matcher that tries all ways.

use crate::matcher::{Test, Tree, Vertex, matched, path, tree};
use crate::scenes::{NAMED, scene};
use halflight::expression::compile;
use halflight::scene::build::Scene;
use proptest::prelude::*;
use std::sync::OnceLock;

fn named() -> &'static Scene {
    static SCENE: OnceLock<Scene> = OnceLock::new();
    SCENE.get_or_init(|| scene(NAMED))
}

/// Between the ends, as no path matches anything else.
fn whole(tree: &Tree) -> Tree {
    Tree::Then(vec![
        Tree::One(Test::Light),
        tree.clone(),
        Tree::One(Test::Sensor),
    ])
}

fn brute(tree: &Tree, path: &[Vertex]) -> bool {
    tree.ends(path, 0).contains(&path.len())
}

/// Texts without their outer parentheses, because the first letter tells the notation.
fn text(tree: &Tree, from_camera: bool) -> String {
    let text = tree.text(from_camera);
    text[1..text.len() - 1].to_owned()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

    #[test]
    fn automata_agree_with_a_matcher_that_tries_everything(
        trees in prop::collection::vec(tree(), 1..4),
        from_camera in prop::collection::vec(any::<bool>(), 4),
        paths in prop::collection::vec(path(), 1..8),
    ) {
        let scene = named();
        let tables = scene.tables.view();
        let wholes: Vec<Tree> = trees.iter().map(whole).collect();
        let texts: Vec<String> = wholes.iter().zip(&from_camera).map(|(t, c)| text(t, *c)).collect();
        let texts: Vec<&str> = texts.iter().map(String::as_str).collect();
        let compiled = match compile(&texts, false, &tables, &scene.names) {
            Ok(compiled) => compiled,
            // An expression that no path matches, as with a light among surfaces, or one that is too complex.
            Err(error) => {
                let allowed = ["no path of this scene", "too complex", "too many orders"];
                prop_assert!(allowed.iter().any(|m| error.message.contains(m)), "{error}");
                if error.message.contains("no path") {
                    let index = texts.iter().position(|t| *t == error.text).unwrap();
                    prop_assert!(paths.iter().all(|p| !brute(&wholes[index], p)), "{error}");
                }
                return Ok(());
            }
        };
        for path in &paths {
            let bits = wholes.iter().enumerate();
            let expected = bits.fold(0, |bits, (i, t)| bits | u32::from(brute(t, path)) << i);
            for (way, found) in matched(&compiled.view(), &tables, path).into_iter().enumerate() {
                prop_assert_eq!(found, expected, "{:?} {:?} divided at {}", texts, path, way);
            }
        }
    }

    #[test]
    fn the_first_expression_can_be_a_condition(only in tree(), other in tree(), paths in prop::collection::vec(path(), 1..8)) {
        let scene = named();
        let tables = scene.tables.view();
        let wholes = [whole(&only), whole(&other)];
        let texts: Vec<String> = wholes.iter().map(|t| text(t, false)).collect();
        let texts: Vec<&str> = texts.iter().map(String::as_str).collect();
        let Ok(compiled) = compile(&texts, true, &tables, &scene.names) else {
            return Ok(());
        };
        for path in &paths {
            let (first, second) = (brute(&wholes[0], path), brute(&wholes[1], path));
            let expected = u32::from(first) | u32::from(first && second) << 1;
            for found in matched(&compiled.view(), &tables, path) {
                prop_assert_eq!(found, expected, "{:?} {:?}", texts, path);
            }
        }
    }
}

/// Whether an expression matches a path, given as kinds of scattering on shapes.
fn matches(text: &str, light: usize, surfaces: &[(u32, usize, bool)]) -> bool {
    let scene = named();
    let tables = scene.tables.view();
    let compiled = compile(&[text], false, &tables, &scene.names).unwrap();
    let mut path = vec![Vertex::Light(light)];
    path.extend(
        surfaces
            .iter()
            .map(|(kind, shape, in_door)| Vertex::Surface {
                kind: *kind,
                shape: *shape,
                in_door: *in_door,
            }),
    );
    path.push(Vertex::Sensor);
    matched(&compiled.view(), &tables, &path)[0] == 1
}

#[test]
fn expressions_of_the_papers_and_of_other_renderers_mean_what_they_say() {
    use halflight_kernel::path::expression::scattering::*;
    let (dr, gr, sr, st) = (
        (DIFFUSE_REFLECTION, 0, false),
        (GLOSSY_REFLECTION, 1, false),
        (SPECULAR_REFLECTION, 2, false),
        (SPECULAR_TRANSMISSION, 2, false),
    );
    // The thesis: diffuse reflection, glass, and the ring at last.
    let thesis = "L D^R S^T+ X[ring] E";
    assert!(matches(thesis, 0, &[dr, st, st, gr]));
    assert!(!matches(thesis, 0, &[dr, gr]));
    assert!(!matches(thesis, 0, &[dr, st, sr]));
    // Arnold: indirect light of one lamp on diffuse surfaces.
    let arnold = "C<RD>.*<L.'key'>";
    assert!(matches(arnold, 0, &[gr, st, dr]));
    assert!(!matches(arnold, 1, &[gr, st, dr]));
    assert!(!matches(arnold, 0, &[dr, st]));
    // RenderMan's caustics, and everything.
    assert!(matches("CD[GS]+L", 1, &[st, gr, dr]));
    assert!(!matches("CD[GS]+L", 1, &[st, dr, dr]));
    assert!(matches("C.*", 2, &[]) && matches("L.*E", 2, &[dr]));
    // Light from infinity, and light of objects.
    assert!(matches("CD+B", 2, &[dr]) && !matches("CD+B", 0, &[dr]));
    assert!(matches("CD+O", 0, &[dr]) && !matches("CD+O", 1, &[dr]));
    // Regions, and names of materials.
    assert!(matches(
        "L X{door} D E",
        0,
        &[(DIFFUSE_REFLECTION, 3, true), dr]
    ));
    assert!(!matches("L X{door} D E", 0, &[dr, dr]));
    assert!(matches("L X[material:glass] D E", 0, &[sr, dr]));
    assert!(!matches("L X[^glass] D E", 0, &[sr, dr]));
}
