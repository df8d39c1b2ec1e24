//! The estimated size of the text.

use modyn_codegen::internals::{Selected, estimate};
use modyn_codegen::{
    Base, Builder, CodeForm, Contact, ContactKind, Function, LoopEnd, ModuleChoice,
};
use modyn_runtime::model::ModuleTree;

/// Returns a chain of joints in general position with this number of links fixed to each link.
fn chain(joints: usize, fixed: usize) -> String {
    let origin = "<origin xyz='0.1 0.2 0.3' rpy='0.3 0.2 -0.4'/>";
    let mut urdf = String::from("<robot name='chain'><link name='0'/>");
    for i in 1..=joints {
        urdf += &format!(
            "<joint name='{i}' type='continuous'>{origin}<axis xyz='0.6 0.48 0.64'/><parent link='{}'/>\
             <child link='{i}'/></joint><link name='{i}'><inertial>{origin}<mass value='1'/>\
             <inertia ixx='1' iyy='1.1' izz='1.2' ixy='0' ixz='0' iyz='0'/></inertial></link>",
            i - 1
        );
        for k in 0..fixed {
            urdf += &format!(
                "<link name='{i}.{k}'/><joint name='{i}.{k}' type='fixed'>{origin}<parent link='{i}'/>\
                 <child link='{i}.{k}'/></joint>"
            );
        }
    }
    urdf + "</robot>"
}

/// The estimate is never less than half of the size of the text. For robots with simple axes it is at most six times
/// the size.
#[test]
fn the_estimate_matches_the_written_text() {
    let robot = |name: &str| {
        let path = format!("{}/../robots/{name}.urdf", env!("CARGO_MANIFEST_DIR"));
        std::fs::read_to_string(path).expect("a robot")
    };
    let robots = ["double_pendulum", "arm6", "quadruped", "joint_zoo", "four_bar"].map(robot);
    let all: Vec<Function> = Function::ALL.to_vec();
    let lists = [
        &all[..],
        Function::DEFAULT,
        &[Function::ForwardDynamics],
        &[Function::ForwardDynamicsDerivatives],
        &[Function::StepRk4Derivatives],
        &[Function::LinkPose, Function::Jacobian],
        &[Function::LinkPoses],
        &[Function::ForwardDynamicsExternal],
        &[],
    ];
    let made = [chain(11, 0), chain(3, 100), chain(8, 16)];
    for (i, urdf) in robots.into_iter().chain(made).enumerate() {
        // All functions of the robots that are not small take seconds each.
        let is_small = i == 0 || i == 4;
        for functions in lists.into_iter().skip(usize::from(!is_small)) {
            let builder = Builder::new().urdf_text(&*urdf, "robot.urdf");
            let builder = builder.functions(functions.iter().copied());
            let generated = builder.generate().expect("good");
            let (model, length) = (&generated.model, generated.text.len() as f64);
            let (bytes, _) =
                estimate(model, &ModuleTree::chains(model), Selected::straight(functions));
            let ratio = bytes / length;
            println!("{i} {} functions: {length} bytes, estimated {ratio:.2}", functions.len());
            assert!((0.5..6.0).contains(&ratio), "{i}: {bytes} instead of {length}");
        }
    }
}

/// The estimate of loops over the bodies is from half to six times the size of the text, for chains of any length and for
/// trees. Bundles are straight-line code beside loops.
#[test]
fn the_estimate_is_of_the_loops() {
    let robot = |name: &str| {
        let path = format!("{}/../robots/{name}.urdf", env!("CARGO_MANIFEST_DIR"));
        std::fs::read_to_string(path).expect("a robot")
    };
    let chains = [4, 28, 150, 400].map(|joints| (chain(joints, 0), Base::Fixed));
    let trees = ["arm6", "quadruped"].map(|name| (robot(name), Base::Fixed));
    let floating = [(robot("quadruped"), Base::Floating)];
    for (i, (urdf, base)) in chains.into_iter().chain(trees).chain(floating).enumerate() {
        for functions in [
            &[Function::ForwardDynamics][..],
            &[Function::InverseDynamics],
            &[Function::ForwardDynamics, Function::InverseDynamics],
        ] {
            let builder = Builder::new().urdf_text(&*urdf, "robot.urdf").base(base);
            let builder = builder.modules(ModuleChoice::Links).code(CodeForm::Small);
            let generated = builder.functions(functions.iter().copied()).generate().expect("good");
            let (model, length) = (&generated.model, generated.text.len() as f64);
            let selected = Selected { functions, bundled: &[], has_loops: true };
            let modules = ModuleTree::links(model);
            let (bytes, _) = estimate(model, &modules, selected);
            println!("{i} {functions:?}: {length} bytes, estimated {:.2}", bytes / length);
            assert!((0.5..6.0).contains(&(bytes / length)), "{i}: {bytes} instead of {length}");
            let bundled = Selected { functions: &[], bundled: functions, has_loops: true };
            let straight = estimate(model, &modules, Selected::straight(functions));
            assert_eq!(estimate(model, &modules, bundled).0, straight.0);
        }
    }
}

/// The estimate of each function of constraints alone, for points and surfaces on a chain and on a quadruped, is from
/// half to twice the size of the text.
#[test]
fn the_estimate_is_of_the_constraints() {
    let quadruped = format!("{}/../robots/quadruped.urdf", env!("CARGO_MANIFEST_DIR"));
    let quadruped = std::fs::read_to_string(quadruped).expect("a robot");
    let robots = [
        (chain(8, 0), Base::Fixed, vec!["8"], ContactKind::Surface),
        (chain(8, 0), Base::Fixed, vec!["8", "6"], ContactKind::Point),
        (quadruped, Base::Floating, vec!["hind_left_foot"], ContactKind::Point),
    ];
    for (i, (urdf, base, links, kind)) in robots.into_iter().enumerate() {
        let contact = |link: &&str| {
            let end = LoopEnd { link: (*link).into(), xyz: [0.1, 0.2, -0.3], rpy: [0.1, 0.2, 0.3] };
            Contact { name: format!("on {link}"), kind, end }
        };
        let builder = Builder::new().urdf_text(urdf, "robot.urdf").base(base);
        let builder = builder.contacts(links.iter().map(contact));
        for function in Function::ALL.iter().filter(|function| function.row().of_constraints) {
            let generated = builder.clone().functions([*function]).generate().expect("good");
            let (model, length) = (&generated.model, generated.text.len() as f64);
            let (bytes, _) =
                estimate(model, &ModuleTree::chains(model), Selected::straight(&[*function]));
            let ratio = bytes / length;
            println!("{i} {}: {length} bytes, estimated {ratio:.2}", function.name());
            assert!((0.5..2.0).contains(&ratio), "{i} {function:?}: {bytes} instead of {length}");
        }
    }
}
