//! Hostile descriptions are refused with a short message, or read in linear time.
//!
//! Size shows linearity, not a clock: with a million elements, a quadratic loop would not end. Long chains of joints
//! and of mimics, and deep nesting, are in `reading.rs`.

use std::fmt::Write as _;
use std::path::PathBuf;

use modyn_read::diagnostics::sanitize_for_display;
use modyn_read::diagnostics::{Code, Diagnostics};
use modyn_read::{FileStore, ReadOptions, expand_xacro, read};

/// The number of repetitions: `MODYN_TEST_MANY=1000000 cargo test --release` sets a million.
fn many() -> usize {
    std::env::var("MODYN_TEST_MANY").ok().and_then(|many| many.parse().ok()).unwrap_or(100_000)
}

fn refused(text: &str) -> Diagnostics {
    let found = read(text, "hostile.urdf", &ReadOptions::default()).expect_err("refused");
    // The displayed text has a bound, for any number of errors.
    assert!(found.to_string().len() < 100_000, "{} bytes", found.to_string().len());
    found
}

fn codes(found: &Diagnostics) -> Vec<Code> {
    found.iter().map(|d| d.code).collect()
}

fn robot(inside: &str) -> String {
    format!("<robot name='r'>{inside}</robot>")
}

/// Returns a pattern many times, with `#` replaced by the number.
fn repeated(count: usize, pattern: &str) -> String {
    (0..count).fold(String::new(), |text, i| text + &pattern.replace('#', &i.to_string()))
}

#[test]
fn entities_do_not_expand() {
    let mut laughs = String::from("<?xml version='1.0'?><!DOCTYPE robot [<!ENTITY l0 'ha'>");
    for i in 1..10 {
        write!(laughs, "<!ENTITY l{i} '{}'>", format!("&l{};", i - 1).repeat(10))
            .expect("a string");
    }
    laughs += "]>";
    assert_eq!(codes(&refused(&(laughs + &robot("<link name='&l9;'/>")))), [Code::Dtd]);
    // An undeclared entity is an error, too.
    assert_eq!(codes(&refused(&robot("<link name='&l9;'/>"))), [Code::MalformedXml]);
}

/// A file that names other files: the reader opens none of them, and their names are no error.
#[test]
fn nothing_else_is_read() {
    for outside in [
        "<!DOCTYPE robot SYSTEM 'file:///etc/passwd'>",
        "<!DOCTYPE robot [<!ENTITY x SYSTEM 'file:///etc/passwd'>]>",
        "<!DOCTYPE robot [<!ENTITY % x SYSTEM 'http://localhost/x.dtd'> %x;]>",
    ] {
        let text = format!("{outside}{}", robot("<link name='a'/>"));
        assert_eq!(codes(&refused(&text)), [Code::Dtd], "{outside}");
    }
    let mesh = "<visual><geometry><mesh filename='file:///no/such/mesh.stl'/></geometry></visual>\
                <collision><geometry><mesh filename='../../../../etc/passwd'/></geometry></collision>";
    let text = PENDULUM.replace("<inertial>", &format!("{mesh}<inertial>"));
    let text = text
        .replace("<robot name='r'>", "<robot name='r' xmlns:xi='http://www.w3.org/2001/XInclude'>");
    let included = "<xi:include href='file:///etc/passwd' parse='text'/></robot>";
    let reading = |text: &str| read(text, "r.urdf", &ReadOptions::default()).expect("good");
    let found = reading(&text.replace("</robot>", included));
    assert_eq!(found.model, reading(PENDULUM).model);
    assert_eq!(found.warnings.iter().map(|one| one.code).collect::<Vec<_>>(), [Code::Include]);
}

const PENDULUM: &str = "<robot name='r'><link name='a'/><link name='b'><inertial><mass value='1'/>\
    <inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>\
    <joint name='j' type='continuous'><parent link='a'/><child link='b'/></joint></robot>";

/// The XML parser compares each attribute with the attributes before it; reading 170 kB took minutes.
#[test]
fn attributes_and_namespaces_have_an_end() {
    let attributes = repeated(many(), " a#=''");
    let namespaces = repeated(many(), " xmlns:a#='u#'");
    for many in [attributes, namespaces] {
        assert_eq!(codes(&refused(&format!("<robot name='r'{many}/>"))), [Code::Excessive]);
    }
    // Any number of elements may declare few attributes each.
    let few = repeated(many(), "<link xmlns:x='u' name='l'/>");
    assert!(codes(&refused(&robot(&few))).iter().all(|&code| code != Code::Excessive));
    let all = repeated(255, " xmlns:a#='u#'");
    let copies = format!("<robot name='r'{all}>{}</robot>", "<x xmlns:q='1'/>".repeat(10_000));
    assert_eq!(codes(&refused(&copies)), [Code::NoLink, Code::NotRead]);
    // Text, comments and values that look like attributes are not counted.
    let quotes = "''".repeat(1000);
    let text =
        PENDULUM.replace("<link name='a'/>", &format!("<!--{quotes}-->{quotes}<link name='a'/>"));
    let text = text.replace("name='r'", &format!("name='r' x=\"{quotes}\""));
    assert!(read(&text, "r.urdf", &ReadOptions::default()).is_ok());
}

#[test]
fn elements_nested_without_end() {
    for (open, close) in [("<a>", "</a>"), ("<link name='a'>", "</link>")] {
        refused(&robot(&(open.repeat(many()) + &close.repeat(many()))));
    }
}

#[test]
fn openings_that_nothing_closes() {
    for open in
        ["<", "<a b='", "<!--", "<![CDATA[", "<?xml ", "<?xml ?>", "<a>", "&", "<robot><x y='>' "]
    {
        let found = refused(&open.repeat(many()));
        assert!(codes(&found) == [Code::MalformedXml], "{open}: {found}");
    }
}

#[test]
fn very_much_in_one_place() {
    let numbers =
        PENDULUM.replace("<parent", &format!("<axis xyz='{}'/><parent", "1 ".repeat(many())));
    assert_eq!(codes(&refused(&numbers)), [Code::NumberCount]);
    let digits = |mass: &str| PENDULUM.replace("mass value='1'", &format!("mass value='{mass}'"));
    assert_eq!(codes(&refused(&digits(&"1".repeat(many())))), [Code::NotFinite]);
    let zeros = format!("0.{}1", "0".repeat(many()));
    assert!(!codes(&refused(&digits(&zeros))).contains(&Code::BadNumber));
    let parts =
        "<parent link='b'/><child link='a'/><axis/><limit/><mimic joint='j'/>".repeat(many() / 10);
    refused(&PENDULUM.replace("<parent", &format!("{parts}<parent")));
}

/// Long names are allowed.
#[test]
fn names_without_end() {
    let name = "\u{202e}\"x".repeat(many() / 5);
    let text = PENDULUM.replace("'r'", &format!("'{name}'"));
    let reading = read(&text, "r.urdf", &ReadOptions::default()).expect("odd");
    assert_eq!(reading.model.name(), name);
    assert!(!sanitize_for_display(&name).contains('\u{202e}'));
}

/// Each element has errors of its own. All are found; the first hundred are shown.
#[test]
fn as_many_errors_as_parts() {
    let n = many() / 2;
    let links = repeated(n, "<link name='l#'/>");
    let joints = |kind: &str, parent: &str| {
        repeated(n - 1, "<joint name='j#' type='K'><parent link='P'/><child link='l#'/></joint>")
            .replace('K', kind)
            .replace('P', parent)
    };
    // The last link is the root; the others are point masses on their axes.
    let point = "<inertial><mass value='1'/><inertia ixx='0' iyy='0' izz='0' ixy='0' ixz='0' iyz='0'/></inertial>";
    let points = repeated(n, &format!("<link name='l#'>{point}</link>"))
        + &joints("revolute", &format!("l{}", n - 1));
    for (text, least) in [
        (robot(&"<joint/>".repeat(n / 4)), n),
        (robot(&"<link name='a'/>".repeat(n)), n - 1),
        (robot(&(links + &joints("revolte", "nowhere"))), n),
        (robot(&points), n - 1),
    ] {
        let found = refused(&text);
        assert!(found.iter().count() >= least, "{} of {least}: {found}", found.iter().count());
        assert!(found.to_string().contains("... and "));
    }
}

/// The interpreter accepts these robots.
#[test]
fn a_forest_of_joints() {
    let mut text = String::from("<robot name='r'><link name='l0'/>");
    let inertial = "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial>";
    for i in 1..=many() {
        // A chain, and a star.
        let parent = if i % 2 == 0 { 0 } else { i / 2 };
        write!(
            text,
            "<link name='l{i}'>{inertial}</link><joint name='j{i}' type='revolute'><parent link='l{parent}'/>\
             <child link='l{i}'/></joint>"
        )
        .expect("a string");
    }
    text += "</robot>";
    let model = read(&text, "r.urdf", &ReadOptions::default()).expect("large, but good").model;
    assert_eq!(model.moving_links().len(), many());
}

fn sdf(inside: &str) -> String {
    format!("<sdf version='1.12'><model name='m'>{inside}</model></sdf>")
}

/// Each pose is relative to the next one; the last is relative to the first, or to the model.
#[test]
fn poses_relative_to_poses_without_end() {
    let n = many();
    let frames = (0..n).fold(String::from("<link name='l'/>"), |text, i| {
        text + &format!(
            "<frame name='f{i}'><pose relative_to='f{}'>0 0 1e-9 0 0 0</pose></frame>",
            i + 1
        )
    });
    let cycle = sdf(&format!("{frames}<frame name='f{n}'><pose relative_to='f0'/></frame>"));
    assert!(codes(&refused(&cycle)).contains(&Code::FrameCycle));
    let chain = sdf(&format!("{frames}<frame name='f{n}'/>"));
    let model = read(&chain, "hostile.sdf", &ReadOptions::default()).expect("a long chain").model;
    let first = model.links().iter().find(|link| link.name == "f0").expect("the first");
    let z = first.pose.translation[2];
    assert!((z - 1e-9 * n as f64).abs() < 1e-9, "{z}");
    // The same for links that frames are attached to.
    let frames = (0..n).fold(String::from("<link name='l'/>"), |text, i| {
        text + &format!(
            "<frame name='f{i}' attached_to='f{}'><pose relative_to='l'/></frame>",
            i + 1
        )
    });
    let cycle = sdf(&format!(
        "{frames}<frame name='f{n}' attached_to='f0'><pose relative_to='l'/></frame>"
    ));
    assert!(codes(&refused(&cycle)).contains(&Code::FrameCycle));
}

#[test]
fn models_in_models_without_end() {
    let n = 5000;
    let deep = "<model name='a'><link name='l'/>".repeat(n) + &"</model>".repeat(n);
    assert!(codes(&refused(&sdf(&deep))).contains(&Code::Excessive));
    // Each part repeats the names of the models around it.
    let long = "n".repeat(many());
    let links = repeated(many() / 10, "<link name='l#'/>");
    let text = sdf(&format!("<model name='{long}'>{links}</model>"));
    assert!(codes(&refused(&text)).contains(&Code::Excessive));
    let name = "a::".repeat(many());
    let text = sdf(&format!("<link name='l'/><frame name='f' attached_to='{name}'/>"));
    assert!(codes(&refused(&text)).contains(&Code::FrameName));
}

/// Files that include files twice: a thousand are read, not 2^40.
#[test]
fn includes_without_end() {
    let folder = std::env::temp_dir().join(format!("modyn-includes-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    for i in 0..40 {
        let include =
            |name| format!("<include><uri>f{}.sdf</uri><name>{name}</name></include>", i + 1);
        let text = sdf(&format!("<link name='l'/>{}{}", include("a"), include("b")));
        std::fs::write(folder.join(format!("f{i}.sdf")), text).expect("a file");
    }
    std::fs::write(folder.join("f40.sdf"), sdf("<link name='l'/>")).expect("a file");
    let text = std::fs::read_to_string(folder.join("f0.sdf")).expect("a file");
    let options = ReadOptions { folder: Some(folder.clone()), ..ReadOptions::default() };
    let found = read(&text, "f0.sdf", &options).expect_err("refused");
    let _ = std::fs::remove_dir_all(&folder);
    let shown = found.to_string();
    assert!(shown.contains("more than 1000 files are included"), "{shown}");
    assert!(found.iter().count() < 2000, "{}", found.iter().count());
}

/// Runs a function in a thread whose stack has this many bytes.
fn with_stack<T: Send>(bytes: usize, run: impl FnOnce() -> T + Send) -> T {
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(bytes).spawn_scoped(scope, run);
        thread.expect("a thread").join().expect("no panic")
    })
}

/// The deepest SDFs that are read fit into a small stack, in one file and in a file for each model.
#[test]
fn the_deepest_models_of_an_sdf_fit_into_a_small_stack() {
    let sdf = |inside: &str| format!("<sdf version='1.12'>{inside}</sdf>");
    let link = "<link name='l'><inertial><mass>1</mass></inertial></link>";
    let read_small = |text: &str, stack: usize, files: FileStore| {
        let options = ReadOptions { folder: Some(PathBuf::new()), files, ..ReadOptions::default() };
        with_stack(stack, || read(text, "deep.sdf", &options).map_err(|errors| errors.to_string()))
    };
    for (depth, is_read) in [(65, true), (66, false), (many(), false)] {
        let nested = ["<model name='m'>".repeat(depth), link.into(), "</model>".repeat(depth)];
        let result = read_small(&sdf(&nested.concat()), 64 << 10, FileStore::default());
        assert!(result.is_ok() == is_read, "{depth}: {:?}", result.err());
    }
    let included = |i: usize| format!("<include><uri>f{i}.sdf</uri></include>");
    let files = (1..70).map(|i| {
        let text = sdf(&format!("<model name='m'>{link}{}</model>", included(i + 1)));
        (PathBuf::from(format!("f{i}.sdf")), text.into_bytes())
    });
    let world = sdf(&format!("<model name='m'>{link}{}</model>", included(1)));
    let error = read_small(&world, 256 << 10, FileStore::in_memory(files)).expect_err("too deep");
    assert!(error.contains("models are nested more than 64 deep"), "{error}");
}

/// Returns the text of a xacro.
fn xacro(inside: &str) -> String {
    format!("<robot name='r' xmlns:xacro='http://ros.org/wiki/xacro'>{inside}</robot>")
}

/// Returns the error of a xacro that is expanded with a small stack.
fn refused_xacro(inside: &str) -> String {
    with_stack(256 << 10, || {
        let options = ReadOptions::default();
        let refused = expand_xacro(&xacro(inside), "hostile.xacro", &options);
        refused.expect_err("refused").to_string()
    })
}

/// The depth is counted before any recursion, in parts that nothing expands as well.
#[test]
fn elements_of_a_xacro_nested_without_end() {
    for (before, open, close, after) in [
        ("", "<a>", "</a>", ""),
        ("<xacro:macro name='m'>", "<a>", "</a>", "</xacro:macro>"),
        ("<xacro:property name='p'>", "<a>", "</a>", "</xacro:property>"),
        ("<xacro:macro name='m' params='*b'/><xacro:m>", "<a>", "</a>", "</xacro:m>"),
        ("<xacro:macro name='m' params='*b'/>", "<xacro:m>", "</xacro:m>", ""),
        ("", "<xacro:if value='1'>", "</xacro:if>", ""),
        ("", "<xacro:unless value='1'>", "</xacro:unless>", ""),
        ("", "<xacro:element xacro:name='a'>", "</xacro:element>", ""),
        ("", "<xacro:include filename='a'>", "</xacro:include>", ""),
    ] {
        for depth in [150, many()] {
            let nested = [before, &open.repeat(depth), &close.repeat(depth), after].concat();
            let error = refused_xacro(&nested);
            assert!(error.contains("elements are nested more than 150 deep"), "{open}: {error}");
            assert!(error.contains("hostile.xacro:1:"), "{open}: {error}");
            assert!(error.contains("beside each other"), "{open}: {error}");
        }
    }
}

/// The deepest xacros that are read fit into the stack of a thread.
#[test]
fn the_deepest_xacros_fit_into_the_stack_of_a_thread() {
    let expanded = |inside: &str| {
        let text = xacro(inside);
        with_stack(2 << 20, || expand_xacro(&text, "deep.xacro", &ReadOptions::default()))
    };
    for (open, close) in [
        ("<a>", "</a>"),
        ("<xacro:if value='1'>", "</xacro:if>"),
        ("<xacro:unless value='0'>", "</xacro:unless>"),
    ] {
        let nested = open.repeat(148) + &close.repeat(148);
        assert!(expanded(&nested).is_ok(), "{open}");
    }
    // A sum is as deep as its terms, and each property is the innermost term of the next one.
    let sums: String = (1..100)
        .map(|i| {
            let sum = format!("p{}{}", i - 1, "+1".repeat(480));
            format!("<xacro:property name='p{i}' value='${{{sum}}}'/>")
        })
        .collect();
    let within = |expression: &str| {
        let start = format!("<xacro:property name='p0' value='1'/>{sums}");
        let value = format!("<b c='${{{expression}}}'/>");
        expanded(&[start, "<a>".repeat(147), value, "</a>".repeat(147)].concat())
    };
    assert!(within("p1").is_ok());
    let error = within("p99").expect_err("too deep").to_string();
    assert!(error.contains("operations are nested more than 600 deep"), "{error}");
}

/// Returns an MJCF.
fn mjcf(inside: &str) -> String {
    format!("<mujoco model='m'>{inside}</mujoco>")
}

fn hinges(count: usize) -> String {
    let body = "<body name='b#'><joint name='j#' type='hinge'/><geom size='1'/></body>";
    format!("<worldbody>{}</worldbody>", repeated(count, body))
}

/// Every constraint looks for the names of its ends among all names.
#[test]
fn constraints_between_many_bodies() {
    let n = many() / 5;
    let welds = (1..n)
        .fold(String::new(), |text, i| text + &format!("<weld body1='b{}' body2='b{i}'/>", i - 1));
    let couplings = (1..n).fold(String::new(), |text, i| {
        text + &format!("<joint joint1='j{i}' joint2='j{}' polycoef='0 1 0 0 0'/>", i - 1)
    });
    for (constraints, loops) in [(welds, n - 1), (couplings, 0)] {
        let text = mjcf(&format!("{}<equality>{constraints}</equality>", hinges(n)));
        let model = read(&text, "hostile.xml", &ReadOptions::default()).expect("large").model;
        assert_eq!(model.loop_constraints().len(), loops);
    }
}

/// Each element looks at the elements of its class and of the classes around that.
#[test]
fn classes_without_end() {
    let n = many() / 2;
    let classes = repeated(n, "<default class='c#'><geom size='1'/></default>");
    let bodies = repeated(n, "<body childclass='c#'><joint type='hinge'/><geom/></body>");
    let text = mjcf(&format!("<default>{classes}</default><worldbody>{bodies}</worldbody>"));
    let model = read(&text, "hostile.xml", &ReadOptions::default()).expect("large").model;
    assert_eq!(model.moving_links().len(), n);
    let geoms = "<geom size='1'/>".repeat(many());
    let text = mjcf(&format!("<default>{geoms}</default><worldbody/>"));
    assert!(codes(&refused(&text)).contains(&Code::Excessive));
}

/// Each keyframe has a coordinate of each joint, and each copy a name.
#[test]
fn products_of_counts() {
    let keys = repeated(20_000, "<key name='k#'/>");
    let text = mjcf(&format!("{}<keyframe>{keys}</keyframe>", hinges(1000)));
    let found = refused(&text);
    assert_eq!(codes(&found), [Code::Excessive]);
    assert!(found.to_string().contains("20000 keyframes of 1000 coordinates"), "{found}");
    let copies = |name: &str| {
        mjcf(&format!(
            "<worldbody><replicate count='30000'><body name='{name}'><joint type='hinge'/>\
             <geom size='1'/></body></replicate></worldbody>"
        ))
    };
    let found = refused(&copies(&"p".repeat(20_000)));
    assert!(codes(&found).contains(&Code::Excessive), "{found}");
    assert!(found.to_string().contains("short names"), "{found}");
    assert!(read(&copies("p"), "hostile.xml", &ReadOptions::default()).is_ok());
    // Elements beyond the limit are not left out without a word.
    let found = refused(&copies("p").replace("30000", "900000"));
    assert!(codes(&found).contains(&Code::Excessive), "{found}");
}

/// Points on two circles: quickhull makes facets for each pair of them.
#[test]
fn hulls_of_circles() {
    let hull = |count: usize| {
        let points = (0..count).fold(String::new(), |text, i| {
            let angle = i as f64 * std::f64::consts::TAU / count as f64;
            text + &format!("{:.12} {:.12} {} ", angle.cos(), angle.sin(), i % 2)
        });
        let text = mjcf(&format!(
            "<asset><mesh name='m' inertia='convex' vertex='{points}'/></asset><worldbody><body>\
             <joint type='hinge'/><geom type='mesh' mesh='m'/></body></worldbody>"
        ));
        read(&text, "hostile.xml", &ReadOptions::default())
    };
    let mass = hull(2000).expect("a drum").model.moving_links()[0].inertial.mass;
    assert!((mass / (1000.0 * std::f64::consts::PI) - 1.0).abs() < 1e-4, "{mass}");
    let found = hull(many()).expect_err("too long").to_string();
    assert!(found.contains("has a convex hull of too many vertices in common planes"), "{found}");
}
