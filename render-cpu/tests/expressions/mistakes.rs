//! Bad expressions: one message, with the place.

use crate::scenes::{NAMED, scene};
use halflight::expression::{compile, parse};
use proptest::prelude::*;

#[test]
fn mistakes_are_told_with_their_place() {
    let scene = scene(NAMED);
    let tables = scene.tables.view();
    let cases = [
        ("", 0, "begins with L"),
        ("L Q E", 2, "'Q' is none of"),
        ("L D C", 4, "the sensor is E"),
        ("C D E", 4, "from the camera it is C"),
        ("L (D E", 2, "this ( is not closed"),
        ("L D) E", 3, "closes nothing"),
        ("L [DG E", 2, "this [ is not closed"),
        ("L [] E", 2, "this set is empty"),
        ("L (* D) E", 3, "nothing to repeat"),
        ("L D{3,2} E", 3, "larger than the second"),
        ("L D{99} E", 4, "at most 64"),
        ("L D{} E", 4, "expected the name of a region"),
        ("L D {} E", 4, "expected {n}"),
        ("L D^X E", 4, "expected R or T"),
        ("L R^T E", 3, "no vertex is both"),
        ("L D[rign] E", 4, "nothing named \"rign\""),
        ("L D[] E", 4, "expected a name"),
        ("L D['a E", 4, "quote is not closed"),
        ("L D{window} E", 4, "no shape \"window\""),
        ("L{door} D E", 1, "regions are of vertices on surfaces"),
        ("L D E[cam]", 5, "the sensor has no names"),
        ("C<RQ>L", 3, "expected one of D G S ."),
        ("C<RDL", 4, "expected a label"),
        ("C<RD", 1, "this < is not closed"),
        ("C<>L", 1, "nothing stands between < and >"),
        ("C< >L", 1, "nothing stands between < and >"),
        ("L * E", 2, "do not repeat"),
        ("L ** E", 2, "do not repeat"),
        ("L D E+", 5, "do not repeat"),
        ("L[key]* E", 6, "do not repeat"),
        ("C.* [BO]{2,}", 8, "do not repeat"),
        ("C<VD>L", 2, "volumes"),
        ("C<Ts>L", 3, "no vertex"),
        ("L D", 3, "it does not end with E"),
        ("L X", 3, "it does not end with E"),
        ("C(D|G)", 6, "it does not end with L"),
        ("L E D", 4, "none comes to this vertex"),
        ("D D E", 0, "none comes to this vertex"),
        ("CDL D", 4, "none comes to this vertex"),
        ("L X[nosuch*] E", 4, "nothing whose name fits \"nosuch*\""),
        ("L D* X[a?, b?]+ E", 7, "nothing whose name fits \"a?\""),
        (
            "C D <.'nosuch*'> L",
            7,
            "nothing whose name fits \"nosuch*\"",
        ),
        ("L X[^*] E", 2, "none comes to this vertex"),
        ("L X[material:ring] E", 4, "no material named \"ring\""),
        ("L X[object:glass] E", 4, "no object named \"glass\""),
        ("L[emitter:lamp] D E", 2, "no emitter named \"lamp\""),
        (
            "L X[foo:bar] E",
            4,
            "before a colon stands object, material or emitter",
        ),
        ("L X[^ring, ^ball] E", 11, "^ stands once, before all names"),
        ("L X[ring, ^ball] E", 10, "^ stands once, before all names"),
        ("C D E?", 4, "from the camera it is C"),
        ("L D****** E", 8, "too many repetitions"),
        ("L (((D{64}){64}){64}) E", 0, "more than 1024"),
    ];
    for (text, position, message) in cases {
        let error = match compile(&[text], false, &tables, &scene.names) {
            Err(error) => error,
            Ok(_) => panic!("{text} is accepted"),
        };
        assert!(error.message.contains(message), "{error}");
        assert_eq!(error.position, position, "{error}");
        assert_eq!(error.to_string().lines().count(), 1);
    }
    let deep = format!("L {}D{} E", "(".repeat(65), ")".repeat(65));
    assert!(parse(&deep).unwrap_err().message.contains("too deeply"));
    let long = "L".repeat(5000);
    assert!(parse(&long).unwrap_err().message.contains("4096"));
}

#[test]
fn too_many_expressions_are_told() {
    let scene = scene(NAMED);
    let texts = vec!["L.*E"; 33];
    let error = compile(&texts, false, &scene.tables.view(), &scene.names).unwrap_err();
    assert!(error.message.contains("more than 32"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, ..ProptestConfig::default() })]

    /// Whatever the text, it is read or refused, in one line, with a place within it.
    #[test]
    fn no_text_is_too_bad(text in r#"[LCE]?[LCEDGSXRTOB.<>\[\]{}()^'|*+?,0-9 dor\u{e9}]{0,40}"#) {
        let scene = scene(NAMED);
        if let Err(error) = compile(&[&text], false, &scene.tables.view(), &scene.names) {
            prop_assert!(error.position <= text.chars().count(), "{error}");
            prop_assert_eq!(error.to_string().lines().count(), 1);
        }
    }
}
