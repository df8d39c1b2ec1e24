//! Fused functions: their numbers of operations compared with the sums over their functions, the errors of the option
//! `fused`, and the generated text.

use modyn_codegen::options::Value;
use modyn_codegen::plan::{Kernels, Planned};
use modyn_codegen::{Base, Builder, Function, FusedFunction, Generated, Planning, Target};

fn robot(name: &str) -> Builder {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../robots");
    let text = std::fs::read_to_string(format!("{folder}/{name}.urdf")).expect("a robot");
    Builder::new().urdf_text(text, format!("{name}.urdf"))
}

fn with(builder: Builder, fused: &str) -> Builder {
    let value = Value::parse(fused).expect("a value");
    builder.set("fused", &value).unwrap_or_else(|fault| panic!("{}", fault.message))
}

/// Returns the operations of a planned function on scalars; those of a link for a function of one link.
fn operations(planning: &Planning, planned: &Planned, link: Option<usize>) -> usize {
    let program = match (&planned.kernels, link) {
        (Kernels::Straight { scalar, .. }, _) => scalar,
        (Kernels::ByLink(programs), Some(link)) => {
            &programs[planning.plan.frames.programs()[link].program]
        }
        _ => panic!("{}", planned.name),
    };
    program.operations_per_call().total()
}

/// The functions of a controller, of these links.
fn control(links: &[&str]) -> FusedFunction {
    let fused =
        FusedFunction::new("control").function(Function::MassMatrix).function(Function::BiasForces);
    let of_links = [Function::Jacobian, Function::JacobianDotQd, Function::LinkPose];
    let all = links.iter().flat_map(|link| of_links.map(|function| (function, *link)));
    all.fold(fused, |fused, (function, link)| fused.of_link(function, link))
}

/// The operations of a fused function.
#[derive(Debug, PartialEq, Eq)]
struct Counts {
    robot: &'static str,
    fused: usize,
    /// The sum of the operations of its functions.
    sum: usize,
    /// The operations of the poses of its links, which the functions of a link share.
    poses: usize,
}

/// Returns the operations of the fused function of a controller.
fn counts(robot_name: &'static str, base: Base, links: &[&str]) -> Counts {
    let functions = [
        Function::MassMatrix,
        Function::BiasForces,
        Function::Jacobian,
        Function::JacobianDotQd,
        Function::LinkPose,
    ];
    let builder = robot(robot_name).base(base).functions(functions).fused([control(links)]);
    let planning = builder.plan().expect("good");
    let all = &planning.plan.functions;
    let of = |function: Function, link: Option<&str>| {
        let planned = all.iter().find(|planned| planned.function == Some(function));
        let link = link.map(|link| planning.model.link_index(link).expect("a link"));
        operations(&planning, planned.expect("planned"), link)
    };
    let fused = all.iter().find(|planned| planned.function.is_none()).expect("planned");
    let mut found = Counts {
        robot: robot_name,
        fused: operations(&planning, fused, None),
        sum: of(Function::MassMatrix, None) + of(Function::BiasForces, None),
        poses: 0,
    };
    for &link in links {
        let [jacobian, rate, pose] =
            [Function::Jacobian, Function::JacobianDotQd, Function::LinkPose]
                .map(|function| of(function, Some(link)));
        found.sum += jacobian + rate + pose;
        found.poses += pose;
    }
    found
}

/// The present counts. Enter a count that falls; a count that rises is a regression.
const FROZEN: [Counts; 4] = [
    Counts { robot: "arm7", fused: 1061, sum: 1335, poses: 134 },
    Counts { robot: "quadruped", fused: 682, sum: 748, poses: 54 },
    Counts { robot: "quadruped", fused: 1937, sum: 2333, poses: 216 },
    Counts { robot: "humanoid", fused: 7374, sum: 9020, poses: 668 },
];

#[test]
fn counts_are_as_frozen() {
    let found = [
        counts("arm7", Base::Fixed, &["hand"]),
        counts("quadruped", Base::Fixed, &["front_left_foot", "hind_right_foot"]),
        counts("quadruped", Base::Floating, &["front_left_foot", "hind_right_foot"]),
        counts("humanoid", Base::Floating, &["left_hand", "right_hand"]),
    ];
    assert_eq!(
        found, FROZEN,
        "\nA count that falls is to be entered; one that rises is a regression."
    );
    // The Jacobian of a link needs the pose of the link, which costs nothing beside it.
    for Counts { robot, fused, sum, poses } in FROZEN {
        assert!(fused + poses <= sum, "{robot}: {fused}, the sum of the functions is {sum}");
    }
}

/// A fused function of one function has its operations.
#[test]
fn a_fused_function_of_one_costs_what_the_function_costs() {
    for function in [Function::MassMatrix, Function::InverseDynamics, Function::StepSemiImplicit] {
        let builder = robot("arm6").functions([function]);
        let planning = builder.fused([FusedFunction::new("one").function(function)]).plan();
        let planning = planning.expect("good");
        let [alone, fused] = &*planning.plan.functions else { panic!("two") };
        let [alone, fused] = [alone, fused].map(|one| operations(&planning, one, None));
        assert_eq!(alone, fused, "{function:?}");
    }
}

/// Returns the first error, and its place in the value.
fn refused(value: &str) -> (usize, String) {
    let value = Value::parse(value).expect("a value");
    let fault = Builder::new().set("fused", &value).expect_err("an error");
    (fault.at, fault.message)
}

#[test]
fn values_with_an_error_are_refused_at_their_place() {
    for (value, at, message) in [
        ("mass_matrix", 0, "expected `name: (function"),
        ("control: mass_matrix", 9, "expected `name: (function"),
        ("control: ()", 0, "fused function `control`: it has no functions; name some"),
        ("control: (mass_matrix, mas_matrix)", 23, "`mas_matrix`; did you mean `mass_matrix`?"),
        (
            "control: (fly)",
            10,
            "there is no function `fly`; a fused function can have: forward_dynamics, ",
        ),
        ("control: (mass_matrix, jacobian)", 23, "is a function of one link; name the link"),
        (
            "control: (mass_matrix(\"hand\"))",
            10,
            "is not a function of one link; write `mass_matrix`",
        ),
        ("control: (jacobian(a, b))", 10, "expected one link: `jacobian(\"link\")`"),
        ("control: (mass_matrix_batch)", 10, "is a function of many states; write `mass_matrix`"),
        (
            "control: (normalize_configuration, random_configuration)",
            35,
            "`random_configuration` has no state as argument",
        ),
        ("control: (mass_matrix, brge, mass_matrix)", 29, "the field `mass_matrix`; name it once"),
        ("control: (jacobian(a), jacobian(a))", 23, "the field `jacobian_a`; name it once"),
        ("control: (jacobian(\"a.1\"), jacobian(a_1))", 27, "have the same name in snake case"),
        (
            "control: batch(mass_matrix, forward_dynamics_external_local)",
            28,
            "the argument `forces`",
        ),
        ("control: batch(brge)", 15, "`brge` has no form for many states in a fused function"),
        (
            "type: (mass_matrix)",
            0,
            "fused function `type`: its name is a keyword; `type_` is not one",
        ),
        ("Control: (mass_matrix)", 0, "its name is not in snake case; `control` is"),
        ("two__words: (mass_matrix)", 0, "not in snake case; `two_words` is"),
        ("mass_matrix: (mass_matrix)", 0, "begins with that of the function `mass_matrix`"),
        ("jacobian_hand: (mass_matrix)", 0, "begins with that of the function `jacobian`"),
        ("link: (mass_matrix)", 0, "generated code has another `link`"),
    ] {
        let (found_at, found) = refused(value);
        assert!(found.contains(message), "{value}: {found}");
        assert_eq!(found_at, at, "{value}: {found}");
    }
}

#[test]
fn robots_with_an_error_are_refused() {
    let errors = |builder: Builder, fused: &str| {
        let errors = with(builder, fused).generate().expect_err("an error");
        errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
    };
    for (fused, messages) in [
        (
            "control: (jacobian(\"hnd\"), link_pose(\"elsewhere\"))",
            &[
                "fused function `control`: link `hnd` does not exist",
                "did you mean `hand`?",
                "link `elsewhere` does not exist",
                "name a link of the description",
            ][..],
        ),
        (
            "control: (impact_dynamics)",
            &["only robots with closed loops or contacts have the function `impact_dynamics`"],
        ),
        (
            "a: (mass_matrix), a: (brge)",
            &["fused function `a`: its name belongs to fused function `a`"],
        ),
        // Their types would have one name.
        (
            "a1: (mass_matrix), a_1: (brge)",
            &["fused function `a_1`: its name belongs to fused function `a1`"],
        ),
        (
            "a: batch(mass_matrix), a_batch: (brge)",
            &["`a_batch`: its name belongs to fused function `a`"],
        ),
        (
            "a: (mass_matrix), a_chunk12: (brge)",
            &["`a_chunk12`: its name belongs to fused function `a`"],
        ),
    ] {
        let found = errors(robot("arm7"), fused);
        for message in messages {
            assert!(found.contains(message), "{fused}: {found}");
        }
    }
    with(robot("arm7"), "a: (mass_matrix), a_b: (brge), ab: (brge)").generate().expect("good");
    // Fused functions of `Builder` are checked as values are.
    let fused = FusedFunction::new("Self").function(Function::RandomConfiguration);
    let errors = robot("arm7").fused([fused]).generate().expect_err("errors").to_string();
    for message in
        ["`Self`: its name is a keyword", "`random_configuration` has no state as argument"]
    {
        assert!(errors.contains(message), "{errors}");
    }
}

#[test]
fn the_text_has_a_function_and_a_type() {
    let fused = "control: batch(mass_matrix, bias_forces, jacobian(\"hand\"), link_pose(\"hand\"))";
    let builder = with(robot("arm7").functions([]).runtime_gravity(), fused).type_name("Arm");
    let Generated { text, operations, static_operations, .. } = builder.generate().expect("good");
    for line in [
        "pub struct ArmControl<T = f64> {",
        "    /// The result of `jacobian` of link `hand`.",
        "    pub jacobian_hand: [::modyn::spatial::Twist<T>; 7],",
        "pub fn control(q: &[f64; 7], qd: &[f64; 7]) -> ArmControl<f64> {",
        "pub fn control_with(params: &ArmParams, q: &[f64; 7], qd: &[f64; 7]) -> ArmControl<f64> {",
        "pub fn control_each(",
        "pub const CONTROL_OPERATIONS: __modyn::OperationCount",
        "/// - fused function `control`, also for many states: `mass_matrix`, `bias_forces`,",
    ] {
        assert!(text.contains(line), "{line}\n{text}");
    }
    let names: Vec<&str> = operations.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, ["control", "control_batch"]);
    assert_eq!(static_operations[0].0, "control");
    // The trait of all robots has no fused functions.
    assert!(!text.contains("fn control<T: __modyn::Scalar>(params: &Self::Params<T>"));
}

/// Names of links with any characters end no comment.
#[test]
fn hostile_names_stay_in_comments() {
    let name = "a*/b` \u{202e}{x}";
    let urdf = format!(
        "<robot name='r'><link name='w'/><joint name='j' type='continuous'><parent link='w'/><child link='{name}'/>\
         </joint><link name='{name}'><inertial><mass value='1'/>\
         <inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link></robot>"
    );
    let fused = FusedFunction::new("state").of_link(Function::Jacobian, name);
    let builder = Builder::new().urdf_text(urdf, "r.urdf").functions([]).fused([fused]);
    let text = builder.clone().c_functions("r").generate().expect("good").text;
    syn::parse_file(&text).expect("Rust");
    assert!(text.contains("    pub jacobian_a_b_x: [::modyn::spatial::Twist<T>; 1],"), "{text}");
    let files = builder.emit(Target::C).expect("good").files;
    assert!(files[1].text.contains("`jacobian` of link `a__b_ __x_`"), "{}", files[1].text);
    for text in files.into_iter().map(|file| file.text) {
        assert_eq!(text.matches("/*").count(), text.matches("*/").count());
    }
}

/// A fused function of the factors has their type, and one of contacts their set.
#[test]
fn types_of_the_robot_are_in_the_text() {
    let builder = robot("quadruped").base(Base::Floating).functions([]);
    let contacts = Value::parse("foot: point(\"front_left_foot\")").expect("a value");
    let builder = builder.set("contacts", &contacts).expect("good").type_name("Dog");
    let fused =
        "all: (brge, constrained_forward_dynamics, impact_dynamics, operational_space_inertia)";
    let text = with(builder, fused).generate().expect("good").text;
    syn::parse_file(&text).expect("Rust");
    for part in [
        "struct DogUduFactorization<",
        "pub brge: DogUduFactorization<T>,",
        "active: DogContacts, settings: &",
    ] {
        assert!(text.contains(part), "{part}");
    }
}

/// In a batch of a fused function, each state has its set of contacts, and all share the settings.
#[test]
fn batches_of_fused_functions_with_contacts() {
    let builder = robot("quadruped").base(Base::Floating).functions([]);
    let contacts = Value::parse("foot: point(\"front_left_foot\")").expect("a value");
    let builder = builder.set("contacts", &contacts).expect("good").type_name("Dog");
    let text = with(builder, "feet: batch(impact_dynamics, gravity_torques)");
    let text = text.generate().expect("good").text;
    syn::parse_file(&text).expect("Rust");
    for part in [
        "active: [&[bool]; 1], settings: &__modyn::ConstraintSettings<f64, ",
        "active: &[DogContacts], settings: &__modyn::ConstraintSettings<f64, ",
        "__modyn::batch::run_parallel_flagged(",
    ] {
        assert!(text.contains(part), "{part}");
    }
}
