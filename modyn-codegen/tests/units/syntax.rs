//! Visibilities and paths of the options.

use modyn_codegen::internals::{KEYWORDS, is_path, is_visibility};

#[test]
fn visibilities_and_paths_are_checked() {
    for good in ["", " ", "pub", "pub(crate)", "pub ( in crate :: robots )", "pub(super)"] {
        assert!(is_visibility(good), "{good}");
    }
    for bad in ["public", "pub struct X; pub", "crate", "pub()", "pub(in)", "pub(in 1)", "pub("] {
        assert!(!is_visibility(bad), "{bad}");
    }
    for good in ["pub(in self)", "pub(in super::super)", "pub(in crate)", "pub(in super::a)"] {
        assert!(is_visibility(good), "{good}");
    }
    for bad in ["pub(in a)", "pub(in ::a)", "pub(in crate::fn)", "pub(in Self)"] {
        assert!(!is_visibility(bad), "{bad}");
    }
}

/// Accepted paths compile as imports, and paths that do not compile are rejected.
#[test]
fn paths_are_those_that_can_be_imported() {
    let good = [
        "::modyn",
        "modyn",
        "crate::a::b",
        ":: a :: r#b",
        "self::a",
        "super::super::a",
        "crate",
        "self::super::a",
        "r#fn::a",
        "union::auto",
        "\u{e9}t\u{e9}",
        "a::_b",
        "::r#gen",
    ];
    for path in good {
        assert!(is_path(path), "{path}");
        syn::parse_str::<syn::ItemUse>(&format!("use {path} as __modyn;")).expect(path);
    }
    let bad = [
        "",
        "::",
        "a::",
        "a b",
        "a; b",
        "a-b",
        "1a",
        "a::crate",
        "_",
        "a::<b>",
        "$crate",
        "fn",
        "a::fn",
        "::fn::a",
        "self",
        "super",
        "a::self",
        "a::super::b",
        "::crate",
        "::self::a",
        "::super",
        "Self",
        "Self::a",
        "crate::self::a",
        "r#crate",
        "r#self::a",
        "r#_",
        "gen",
        "a::dyn::b",
        "\u{24b6}",
        "a\u{b2}",
        "a::::b",
        "super::crate",
        "r#",
        "r# a",
        "a as b",
    ];
    for path in bad {
        assert!(!is_path(path), "{path}");
    }
    let keywords = KEYWORDS.iter().filter(|&&word| word != "crate");
    for word in keywords {
        assert!(!is_path(word) && !is_path(&format!("a::{word}")), "{word}");
    }
}
