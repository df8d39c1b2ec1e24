//! Comments and the first element of an XML document.

use modyn_read::internals::{blank_comments, first_element};

#[test]
fn the_first_element_is_found() {
    let text = "\u{feff}<?xml version='1.0'?>\n<!-- <robot> -->\n<!DOCTYPE a>\n<mujoco\nmodel='m'>";
    assert_eq!(first_element(text), Some("mujoco"));
    assert_eq!(first_element("<robot/>"), Some("robot"));
    for text in ["", "robot", "<!-- <robot>", "<", "< robot>"] {
        assert_eq!(first_element(text), None, "{text}");
    }
}

#[test]
fn blanking_moves_nothing() {
    let text = "\n<!-- \u{e9} -- --><?xml version='1.0'?>\n<a b='<!-- > -->'><![CDATA[<!-- -->]]></a><!---->";
    let (tidy, _) = blank_comments(text);
    assert_eq!(tidy.len(), text.len());
    assert_eq!(tidy.find("<a b='<!-- > -->'><![CDATA[<!-- -->]]></a>"), text.find("<a b="));
    assert!(!tidy.contains("<?xml"));
    assert_eq!(
        blank_comments("<?xml version='1.0'?><a/><!-- ").0,
        "<?xml version='1.0'?><a/><!-- "
    );
}
