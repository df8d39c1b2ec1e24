//! The work of every reader grows in proportion to the text. Each text doubles along an axis on
//! which a reader could look at everything again for each element. Steps are counted
//! (`src/work.rs`), so that the test does not depend on a clock.

use std::fmt::Write as _;
use std::path::PathBuf;

use modyn_read::internals::counted_steps;
use modyn_read::{FileStore, Ground, ReadOptions, read};

/// The first size of a text.
const SIZE: usize = 400;

/// The largest ratio of the steps of a text and of half of it. A hull of n points takes n log n
/// steps.
const MAX_RATIO: f64 = 2.5;

/// A text whose size is a parameter.
struct Case {
    name: &'static str,
    /// The name of the file, whose ending selects the format.
    file: &'static str,
    text: fn(usize) -> String,
    /// Another file that the text names.
    other: Option<OtherFile>,
}

/// A file whose size is a parameter.
struct OtherFile {
    name: &'static str,
    content: fn(usize) -> Vec<u8>,
}

impl Case {
    const fn new(name: &'static str, file: &'static str, text: fn(usize) -> String) -> Self {
        Self { name, file, text, other: None }
    }

    const fn with(self, name: &'static str, content: fn(usize) -> Vec<u8>) -> Self {
        Self { other: Some(OtherFile { name, content }), ..self }
    }

    /// Returns the steps of reading, and the errors.
    fn steps(&self, size: usize) -> (usize, String) {
        let text = (self.text)(size);
        let other =
            self.other.as_ref().map(|file| (PathBuf::from(file.name), (file.content)(size)));
        let options = ReadOptions {
            folder: Some(PathBuf::new()),
            files: FileStore::in_memory(other),
            shapes: true,
            ground: self.file.ends_with("urdf").then(Ground::default),
            ..ReadOptions::default()
        };
        let before = counted_steps();
        let errors = match read(&text, self.file, &options) {
            Ok(reading) => reading.model.links().first().map_or("no links", |_| "").to_owned(),
            Err(errors) => errors.to_string(),
        };
        (counted_steps() - before, errors)
    }
}

/// Returns a pattern many times, with `#` replaced by the number and `+` by the next one.
fn repeated(count: usize, pattern: &str) -> String {
    (0..count).fold(String::new(), |text, i| {
        text + &pattern.replace('#', &i.to_string()).replace('+', &(i + 1).to_string())
    })
}

const INERTIAL: &str = "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial>";

/// Returns a URDF of a chain of this number of joints.
fn urdf(joints: usize, inside: &str) -> String {
    let links = repeated(joints + 1, &format!("<link name='l#'>{INERTIAL}</link>"));
    let joint = "<joint name='j#' type='continuous'><parent link='l#'/><child link='l+'/></joint>";
    format!("<robot name='r'>{links}{}{inside}</robot>", repeated(joints, joint))
}

/// Returns a xacro.
fn xacro(inside: &str) -> String {
    let text = urdf(1, inside);
    text.replace("<robot name='r'>", "<robot name='r' xmlns:xacro='http://ros.org/wiki/xacro'>")
}

fn sdf(inside: &str) -> String {
    let links = "<link name='l'/><link name='m'/>";
    let joint = "<joint name='j' type='revolute'><parent>l</parent><child>m</child><axis><xyz>0 0 1</xyz></axis></joint>";
    format!("<sdf version='1.12'><model name='r'>{links}{joint}{inside}</model></sdf>")
}

/// Returns an MJCF with this number of hinges.
fn mjcf(hinges: usize, inside: &str) -> String {
    let body = "<body name='b#'><joint name='j#' type='hinge'/><geom size='1'/></body>";
    format!("<mujoco><worldbody>{}</worldbody>{inside}</mujoco>", repeated(hinges, body))
}

/// Returns an MJCF of one body with these geoms.
fn geoms(assets: &str, geoms: &str) -> String {
    format!(
        "<mujoco><asset>{assets}</asset><worldbody><body><joint type='hinge'/><inertial pos='0 0 0' mass='1' \
         diaginertia='1 1 1'/>{geoms}</body></worldbody></mujoco>"
    )
}

/// Returns a URDF whose link shows a mesh.
fn shown(file: &str) -> String {
    let visual = format!("<visual><geometry><mesh filename='{file}'/></geometry></visual>");
    urdf(1, "").replace("<link name='l0'>", &format!("<link name='l0'>{visual}"))
}

/// Returns points of a sphere.
fn sphere(points: usize) -> impl Iterator<Item = [f64; 3]> {
    (0..points).map(move |i| {
        let z = 2.0 * (i as f64 + 0.5) / points as f64 - 1.0;
        let (sin, cos) = (2.399_963_229_728_653 * i as f64).sin_cos();
        [(1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z]
    })
}

fn vertices(points: usize) -> String {
    sphere(points).fold(String::new(), |mut text, [x, y, z]| {
        write!(text, "{x} {y} {z} ").expect("a string");
        text
    })
}

fn binary_stl(triangles: usize) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend(u32::try_from(triangles).expect("few").to_le_bytes());
    for i in 0..triangles {
        let i = i as f32;
        let corners = [0.0, 0.0, 1.0, i, 0.0, 0.0, i, 1.0, 0.0, i, 0.0, 1.0];
        bytes.extend(corners.iter().flat_map(|x: &f32| x.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn obj(corners: usize) -> Vec<u8> {
    let polygon = "v 0 0 #\nv 1 0 #\nv 2 1 #\nv 1 2 #\nv 0 2 #\nf -5 -4 -3 -2 -1\n";
    repeated(corners / 5, polygon).into()
}

/// Returns a COLLADA file of many nodes that show one geometry of many parts.
fn dae(nodes: usize) -> Vec<u8> {
    let part =
        "<triangles><input semantic='VERTEX' source='#v' offset='0'/><p>0 1 2</p></triangles>";
    let geometry = format!(
        "<geometry id='g'><mesh><source id='s'><float_array id='a'>0 0 0 1 0 0 0 1 0 0 0 1</float_array>\
         <technique_common><accessor source='#a' stride='3'/></technique_common></source>\
         <vertices id='v'><input semantic='POSITION' source='#s'/></vertices>{}</mesh></geometry>",
        part.repeat(nodes)
    );
    let node = "<translate>0 0 1</translate>".repeat(nodes);
    format!(
        "<COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema'><library_geometries>{geometry}</library_geometries>\
         <library_visual_scenes><visual_scene id='w'>{}<node>{node}<instance_geometry url='#g'/></node></visual_scene>\
         </library_visual_scenes><scene><instance_visual_scene url='#w'/></scene></COLLADA>",
        "<node/>".repeat(nodes)
    )
    .into()
}

const CASES: &[Case] = &[
    Case::new("a chain", "r.urdf", |n| urdf(n, "")),
    Case::new("contacts on the last link", "r.urdf", |n| {
        urdf(n, &repeated(n, &format!("<contact_frame name='c#' type='point' link='l{n}'/>")))
    }),
    Case::new("contacts on links that do not exist", "r.urdf", |n| {
        urdf(n, &repeated(n, "<contact_frame name='c#' type='point' link='k#'/>"))
    }),
    Case::new("loops", "r.urdf", |n| {
        let end = |name, link| format!("<link{name} link='{link}'/>");
        let both = end("1", format!("l{n}")) + &end("2", "l0".into());
        urdf(n, &repeated(n, &format!("<loop_joint name='k#' type='spherical'>{both}</loop_joint>")))
    }),
    Case::new("constraints whose names are taken", "r.urdf", |n| {
        let text = urdf(n, &repeated(n, &format!(
            "<drake:ball_constraint><drake:ball_constraint_body_A name='l0'/><drake:ball_constraint_body_B name='l{n}'/>\
             <drake:ball_constraint_p_AP value='0 0 0'/><drake:ball_constraint_p_BQ value='0 0 0'/></drake:ball_constraint>"
        )));
        let text = text.replace("<robot ", "<robot xmlns:drake='http://drake.mit.edu' ");
        text.replace("name='j", "name='ball_constraint_")
    }),
    Case::new("followers", "r.urdf", |n| {
        let text = urdf(n + 1, "");
        (0..n).fold(text, |text, i| {
            let (joint, mimic) = (format!("<child link='l{}'/>", i + 2), format!("<mimic joint='j{i}'/>"));
            text.replacen(&joint, &(joint.clone() + &mimic), 1)
        })
    }),
    Case::new("visuals with materials of the robot", "r.urdf", |n| {
        let text = urdf(n, &repeated(n, "<material name='m#'><color rgba='1 0 0 1'/></material>"));
        let visual = "<visual><geometry><sphere radius='1'/></geometry><material name='m";
        (0..n).fold(text, |text, i| {
            let link = format!("<link name='l{i}'>");
            text.replacen(&link, &format!("{link}{visual}{}'/></visual>", n - 1 - i), 1)
        })
    }),
    Case::new("collisions with friction", "r.urdf", |n| {
        let collision = "<collision name='c'><geometry><sphere radius='1'/></geometry></collision>";
        let gazebo = "<gazebo reference='l#'><mu1>0.5</mu1><mu2>0.5</mu2></gazebo>";
        let links = format!("{collision}{INERTIAL}");
        urdf(n, &repeated(n, gazebo)).replace(INERTIAL, &links)
    }),
    Case::new("a hull that touches the ground", "r.urdf", |_| {
        let mesh = "<collision><geometry><mesh filename='m.obj'/></geometry></collision>";
        urdf(1, "").replace("<link name='l1'>", &format!("<link name='l1'>{mesh}"))
    })
    .with("m.obj", |n| {
        let corners = sphere(n).map(|[x, y, z]| format!("v {x} {y} {z}\n"));
        (corners.collect::<String>() + "f 1 2 3\n").into()
    }),
    Case::new("transmissions", "r.urdf", |n| {
        urdf(n, &repeated(n, "<transmission name='t#'><joint name='j#'/><actuator name='a'><mechanicalReduction>2</mechanicalReduction>\
             <motorInertia>1</motorInertia></actuator></transmission>"))
    }),
    Case::new("unknown elements", "r.urdf", |n| urdf(n, &repeated(n, "<lunk name='l#'/>"))),
    Case::new("macros", "r.urdf.xacro", |n| {
        let body = "<xacro:macro name='m' params='i'><link name='k${i}'/></xacro:macro>";
        xacro(&(body.to_owned() + &repeated(n, "<xacro:if value='0'><xacro:m i='#'/></xacro:if>")))
    }),
    Case::new("properties", "r.urdf.xacro", |n| {
        xacro(&repeated(n, "<xacro:property name='p+' value='${1 + #}'/><xacro:property name='q' value='${p+ * 2}'/>"))
    }),
    Case::new("a list of YAML", "r.urdf.xacro", |_| {
        xacro("<xacro:property name='y' value=\"${xacro.load_yaml('y.yaml')}\"/>\
               <material name='${len(y)}'/>")
    })
    .with("y.yaml", |n| repeated(n, "- {a: #, b: [#, +]}\n").into()),
    Case::new("a map of YAML", "r.urdf.xacro", |_| {
        xacro("<xacro:property name='y' value=\"${xacro.load_yaml('y.yaml')}\"/>\
               <material name=\"${y['k1']}\"/>")
    })
    .with("y.yaml", |n| repeated(n, "k#: &a# [#, +]\nm#: *a#\n").into()),
    Case::new("dictionaries that are compared", "r.urdf.xacro", |_| {
        let dict = "dict((str(i), i) for i in y)";
        let lists = "<xacro:property name='y' value=\"${xacro.load_yaml('y.yaml')}\"/>";
        xacro(&format!("{lists}<material name='${{{dict} == {dict}}}'/>"))
    })
    .with("y.yaml", |n| repeated(n, "- #\n").into()),
    Case::new("frames", "r.sdf", |n| {
        sdf(&repeated(n, "<frame name='f#'><pose relative_to='f+'>0 0 1e-3 0 0 0</pose></frame>").replace(
            &format!("relative_to='f{n}'"), "relative_to='l'",
        ))
    }),
    Case::new("frames on frames", "r.sdf", |n| {
        sdf(&repeated(n, "<frame name='f#' attached_to='f+'/>").replace(&format!("attached_to='f{n}'"), "attached_to='l'"))
    }),
    Case::new("models in models", "r.sdf", |n| {
        sdf(&repeated(n, "<model name='m#'><link name='k'/></model>"))
    }),
    Case::new("links, joints and visuals", "r.sdf", |n| {
        let visual = "<visual name='v'><geometry><sphere><radius>1</radius></sphere></geometry></visual>";
        let axis = "<axis><xyz>0 0 1</xyz></axis>";
        sdf(&(repeated(n, &format!("<link name='k#'>{visual}</link>"))
            + &repeated(n, &format!("<joint name='i#' type='revolute'><parent>l</parent><child>k#</child>{axis}</joint>"))))
    }),
    Case::new("collisions on a plane", "r.sdf", |n| {
        let shape = |shape: &str| {
            format!("<collision name='c'><geometry>{shape}</geometry></collision>")
        };
        let plane = format!("<model name='p'><static>1</static><link name='l'>{}</link></model>", shape("<plane/>"));
        let links = repeated(n, &format!("<link name='l#'>{}</link>", shape("<box><size>1 1 1</size></box>")));
        format!("<sdf version='1.12'><world name='w'>{plane}<model name='r'>{links}</model></world></sdf>")
    }),
    Case::new("unknown elements", "r.sdf", |n| sdf(&repeated(n, "<jiont name='i#'/>"))),
    Case::new("welds of one name", "r.xml", |n| {
        mjcf(n + 1, &format!("<equality>{}</equality>", repeated(n, "<weld name='w' body1='b#' body2='b+'/>")))
    }),
    Case::new("couplings", "r.xml", |n| {
        mjcf(n + 1, &format!("<equality>{}</equality>", repeated(n, "<joint joint1='j+' joint2='j#'/>")))
    }),
    Case::new("constraints of one long tendon", "r.xml", |n| {
        let tendon = repeated(n, "<joint joint='j#' coef='1'/>");
        let constraints = repeated(n, "<tendon tendon1='t'/>");
        mjcf(n, &format!("<tendon><fixed name='t'>{tendon}</fixed></tendon><equality>{constraints}</equality>"))
    }),
    Case::new("constraints of short tendons", "r.xml", |n| {
        let tendons = repeated(n, "<fixed name='t#'><joint joint='j#' coef='1'/><joint joint='j+' coef='1'/></fixed>");
        let constraints = repeated(n, "<tendon tendon1='t#'/>");
        mjcf(n + 1, &format!("<tendon>{tendons}</tendon><equality>{constraints}</equality>"))
    }),
    Case::new("tendons of one joint", "r.xml", |n| {
        let tendon = "<joint joint='j0' coef='1'/>".repeat(n);
        mjcf(n, &format!("<tendon><fixed name='t'>{tendon}</fixed></tendon><equality><tendon tendon1='t'/></equality>"))
    }),
    Case::new("classes", "r.xml", |n| {
        let classes = repeated(n, "<default class='c#'><geom size='1'/></default>");
        let bodies = repeated(n, "<body childclass='c#'><joint type='hinge'/><geom/></body>");
        format!("<mujoco><default>{classes}</default><worldbody>{bodies}</worldbody></mujoco>")
    }),
    Case::new("meshes", "r.xml", |n| {
        geoms(&repeated(n, "<mesh name='m#' vertex='0 0 0 1 0 0 0 1 0 0 0 1'/>"), &repeated(n, "<geom type='mesh' mesh='m#'/>"))
    }),
    Case::new("height fields", "r.xml", |n| {
        let text = geoms(&repeated(n, "<hfield name='h#' size='1 1 1 1'/>"), &repeated(n, "<geom type='hfield' hfield='h#'/>"));
        text.replace("<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>", "<geom size='1'/>")
    }),
    Case::new("materials", "r.xml", |n| {
        geoms(&repeated(n, "<material name='m#' rgba='1 0 0 1'/>"), &repeated(n, "<geom size='1' material='m#'/>"))
    }),
    Case::new("sites with names of bodies", "r.xml", |n| {
        mjcf(n, "").replace("<geom size='1'/>", "<geom size='1'/><site name='b1'/>")
    }),
    Case::new("copies", "r.xml", |n| {
        format!("<mujoco><worldbody><replicate count='{n}' offset='1 0 0'><body name='b'><joint type='hinge'/><geom size='1'/></body>\
                 </replicate></worldbody></mujoco>")
    }),
    Case::new("actuators", "r.xml", |n| {
        mjcf(n, &format!("<actuator>{}</actuator>", repeated(n, "<motor name='a#' joint='j#'/>")))
    }),
    Case::new("unknown attributes", "r.xml", |n| {
        mjcf(n, "").replace("<geom size='1'/>", "<geom size='1' siez='1'/>")
    }),
    Case::new("a hull", "r.xml", |n| {
        let mesh = format!("<mesh name='m' inertia='convex' vertex='{}'/>", vertices(n));
        geoms(&mesh, "<geom type='mesh' mesh='m'/>").replace("<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>", "")
    }),
    Case::new("binary STL", "r.urdf", |_| shown("m.stl")).with("m.stl", binary_stl),
    Case::new("STL as text", "r.urdf", |_| shown("m.stl")).with("m.stl", |n| {
        let facet = "facet normal 0 0 1 outer loop vertex # 0 0 vertex # 1 0 vertex # 0 1 endloop endfacet ";
        format!("solid m {} endsolid", repeated(n, facet)).into()
    }),
    Case::new("OBJ", "r.urdf", |_| shown("m.obj")).with("m.obj", obj),
    Case::new("COLLADA", "r.urdf", |_| shown("m.dae")).with("m.dae", dae),
];

#[test]
fn twice_the_text_is_twice_the_work() {
    let mut faults = String::new();
    for case in CASES {
        let [half, whole, twice] = [1, 2, 4].map(|factor| case.steps(factor * SIZE));
        let ratios = [(&half, &whole), (&whole, &twice)].map(|(a, b)| b.0 as f64 / a.0 as f64);
        let error = twice.1.lines().next().unwrap_or_default().to_owned();
        println!(
            "{:12} {:40} {:9} {:.2} {:.2} {error}",
            case.file, case.name, half.0, ratios[0], ratios[1]
        );
        // A text that is not looked at shows nothing.
        if half.0 < SIZE || ratios.iter().any(|ratio| *ratio > MAX_RATIO) {
            writeln!(faults, "{} ({}): {} steps, {ratios:.2?}", case.name, case.file, half.0)
                .expect("a string");
        }
    }
    assert!(faults.is_empty(), "{faults}");
}
