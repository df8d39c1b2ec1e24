//! The constants of a generated type: names, modules, and the operations of its functions.

use std::collections::BTreeMap;

use modyn_codegen::Function;
use modyn_fleet::{PARTS, ROBOTS};
use modyn_runtime::model::Joint;
use modyn_runtime::quantities::Sizes;
use modyn_runtime::{Interpreter, OperationCount};
use modyn_tests::compiled::{Compiled, Consts, TypeConstants};
use modyn_tests::fleet::{FLEET, Part, Spec};
use syn::{BinOp, Block, Expr, ExprCall, File, Item, ItemFn, Stmt, UnOp};

#[test]
fn a_part_has_the_robots_of_the_table() {
    for &(part, robots) in PARTS {
        let expected = FLEET.iter().filter(|spec| spec.part == part);
        assert_eq!(
            robots.iter().map(|robot| &robot.spec).collect::<Vec<_>>(),
            expected.collect::<Vec<_>>()
        );
    }
    if cfg!(feature = "whole") {
        assert!(Part::ALL.iter().all(|part| PARTS.iter().any(|(built, _)| built == part)));
        assert_eq!(ROBOTS.len(), FLEET.len());
    }
}

#[test]
fn constants_are_the_models() {
    for robot in ROBOTS.iter() {
        let model = robot.spec.model();
        for consts in robot.consts {
            let Consts { name, nq, nv, joint_names, link_names, .. } = consts;
            assert_eq!(name, model.name());
            assert_eq!([nq, nv], [model.nq(), model.nv()], "{name}");
            let joints: Vec<&str> =
                model.moving_links().iter().map(|l| l.joint.name.as_str()).collect();
            assert_eq!(joint_names, joints, "{name}");
            let links: Vec<&str> = model.links().iter().map(|f| f.name.as_str()).collect();
            assert_eq!(link_names, links, "{name}");
            assert_eq!(consts.coordinate_names, model.coordinate_names(), "{name}");
            assert_eq!(consts.velocity_names, model.velocity_names(), "{name}");
        }
        assert_eq!(robot.gravity, model.gravity(), "{}", robot.name());
        let [own, of_the_trait] = robot.consts;
        assert_eq!(own, of_the_trait);
    }
}

#[test]
fn enums_are_the_names_in_their_order() {
    for robot in ROBOTS.iter() {
        let [Consts { joint_names, link_names, .. }, _] = robot.consts;
        let numbered =
            |names: &[&'static str]| names.iter().copied().enumerate().collect::<Vec<_>>();
        assert_eq!((robot.joints)(), numbered(joint_names), "{}", robot.name());
        assert_eq!((robot.links)(), numbered(link_names), "{}", robot.name());
    }
}

#[test]
fn joints_know_their_place() {
    for robot in ROBOTS.iter() {
        let model = robot.spec.model();
        let places = (0..model.moving_links().len()).map(|i| [model.q_range(i), model.v_range(i)]);
        assert_eq!((robot.ranges)(), places.collect::<Vec<_>>(), "{}", robot.name());
    }
}

#[test]
fn numbers_are_the_models() {
    for robot in ROBOTS.iter() {
        let (model, name) = (robot.spec.model(), robot.name());
        let links = 0..model.moving_links().len();
        let parameters: Vec<f64> =
            links.filter_map(|i| model.inertial_parameters(i)).flatten().collect();
        let TypeConstants { parameters: found, armature, damping, friction } = robot.type_constants;
        assert_eq!(found, parameters, "{name}");
        let [Consts { limits, .. }, _] = robot.consts;
        assert_eq!([limits.lower.len(), limits.upper.len()], [model.nq(); 2], "{name}");
        for numbers in [limits.velocity, limits.effort, armature, damping, friction] {
            assert_eq!(numbers.len(), model.nv(), "{name}");
        }
        for (i, Joint { mimic, limits: stated, dynamics, .. }) in
            model.moving_links().iter().map(|link| &link.joint).enumerate()
        {
            // A mimic joint has no entry.
            if mimic.is_some() {
                continue;
            }
            let effort = stated.and_then(|limits| limits.effort).unwrap_or(f64::INFINITY);
            for k in model.q_range(i) {
                let found = [limits.lower[k], limits.upper[k]];
                assert_eq!(found, model.coordinate_range(i), "{name}");
            }
            for k in model.v_range(i) {
                let found = [limits.velocity[k], limits.effort[k]];
                assert_eq!(found, [model.velocity_limit(i), effort], "{name}");
                let found = [armature[k], damping[k], friction[k]];
                assert_eq!(
                    found,
                    [dynamics.armature, dynamics.damping, dynamics.friction],
                    "{name}"
                );
            }
        }
    }
}

#[test]
fn neutral_coordinates_are_the_interpreters() {
    for robot in ROBOTS.iter() {
        let interpreter = Interpreter::<f64>::new(robot.spec.model());
        let mut expected = vec![f64::NAN; robot.consts[0].nq];
        interpreter.neutral(&mut expected).expect("the length is right");
        assert_eq!((robot.neutral)(), [expected.clone(), expected], "{}", robot.name());
    }
}

#[test]
fn modules_are_those_that_were_asked_for() {
    for robot in ROBOTS.iter() {
        let (model, name) = (robot.spec.model(), robot.name());
        let expected = robot.spec.modules(&model);
        let [Consts { modules, .. }, _] = robot.consts;
        assert_eq!(modules.len(), expected.modules().len(), "{name}");
        for (found, expected) in modules.iter().zip(expected.modules()) {
            let links = &model.moving_links()[expected.links.clone()];
            assert_eq!(found.parent, expected.parent, "{name}");
            assert_eq!(found.children, expected.children, "{name}");
            let dofs: Vec<usize> = expected
                .links
                .clone()
                .filter(|&i| model.mimic(i).is_none())
                .flat_map(|i| model.v_range(i))
                .collect();
            let range = found.first..found.first + found.dofs;
            assert_eq!(range.collect::<Vec<_>>(), dofs, "{name}");
            let names: Vec<&str> = links.iter().map(|link| link.name.as_str()).collect();
            assert_eq!(found.links, names, "{name}");
            let names: Vec<&str> = links.iter().map(|link| link.joint.name.as_str()).collect();
            assert_eq!(found.joints, names, "{name}");
        }
    }
}

/// Hash maps and addresses in the compiler do not change the text. Only small robots, since the compiler runs
/// unoptimised here.
#[test]
fn another_process_compiles_the_same_text() {
    let small = ROBOTS.iter().filter(|robot| robot.consts[0].nv <= 9);
    let mut robots = 0;
    for robot in small {
        let generated = robot.spec.builder().generate();
        let generated = generated.unwrap_or_else(|errors| panic!("{}: {errors}", robot.name()));
        assert!(generated.text == robot.text, "{} is not the same", robot.name());
        assert_eq!(generated.model, robot.spec.model(), "{}", robot.name());
        assert_eq!(generated.operations, robot.operations, "{}", robot.name());
        robots += 1;
    }
    assert!(robots >= 20, "{robots}");
}

#[test]
fn announced_operations_equal_the_executed_ones() {
    for robot in ROBOTS.iter() {
        let functions = Functions::of(robot);
        for &(name, announced) in robot.operations {
            // Limbs that share code are a loop, and so is the solver of a step.
            let function = Function::from_name(name).expect("an announced function");
            if function.row().has_solver || has_loops(robot, name) {
                let is_loop = robot.spec.share || function.row().has_solver;
                assert!(is_loop, "{}: `{name}`", robot.name());
                continue;
            }
            assert_eq!(functions.most(name), announced, "{}: `{name}`", robot.name());
        }
        let default = || Function::DEFAULT.to_vec();
        let functions = if robot.spec.all { Spec::all_functions().collect() } else { default() };
        let names: Vec<&str> = robot.operations.iter().map(|(name, _)| *name).collect();
        let model = robot.spec.model();
        let own = functions.iter().filter(|f| f.fits(&Sizes::new(&model, 0)));
        assert_eq!(names, own.map(|f| f.name()).collect::<Vec<_>>());
    }
}

/// Returns whether the private function of this name has a loop over a table.
fn has_loops(robot: &Compiled, name: &str) -> bool {
    let mut functions = robot.text.split("\nfn ");
    let text = functions.find(|text| text.starts_with(&format!("{name}<")));
    text.is_some_and(|text| text.contains("for (constants0, places0) in "))
}

/// Functions without an announced count are straight-line code as well.
#[test]
fn factors_are_used_by_straight_lines() {
    for robot in ROBOTS.iter() {
        let functions = Functions::of(robot);
        for name in ["u", "d"] {
            assert_eq!(functions.count(name), OperationCount::default(), "{}", robot.name());
        }
        let n = robot.consts[0].nv;
        for name in ["u_inverse", "d_inverse", "inverse", "solve"] {
            let OperationCount { sin_cos, divisions, others, .. } = functions.count(name);
            assert_eq!([sin_cos, divisions, others], [0; 3], "{}", robot.name());
        }
        assert_eq!(functions.count("log_determinant").others, n, "{}", robot.name());
    }
}

/// The private functions of a generated text.
struct Functions(BTreeMap<String, ItemFn>);

impl Functions {
    fn of(robot: &Compiled) -> Self {
        let File { items, .. } = syn::parse_file(robot.text).expect("generated Rust");
        let hidden = items.into_iter().filter_map(|item| match item {
            Item::Const(item) => Some(*item.expr),
            _ => None,
        });
        let statements = hidden.flat_map(|expr| match expr {
            Expr::Block(block) => block.block.stmts,
            _ => panic!("{}: a constant that is no block", robot.name()),
        });
        let functions = statements.filter_map(|statement| match statement {
            Stmt::Item(Item::Fn(function)) => Some((function.sig.ident.to_string(), function)),
            _ => None,
        });
        Self(functions.collect())
    }

    /// Returns the operators and calls that the function executes, its chunks included; the function must be
    /// straight-line code.
    fn count(&self, name: &str) -> OperationCount {
        let mut count = OperationCount::default();
        let function = self.0.get(name).unwrap_or_else(|| panic!("no function `{name}`"));
        self.block(&function.block, &mut count);
        count
    }

    /// Returns the operators and calls of a function; for functions of one link, of the most expensive link.
    fn most(&self, name: &str) -> OperationCount {
        let by_link = |i: usize| format!("{name}_{i}");
        // The announced operations are those of one state without vectors.
        let scalar = format!("{name}_scalar");
        if let Some(name) = [&scalar, name].into_iter().find(|&name| self.0.contains_key(name)) {
            return self.count(name);
        }
        let counts =
            (0..).map(by_link).take_while(|name| self.0.contains_key(name)).map(|n| self.count(&n));
        counts.max_by_key(OperationCount::total).unwrap_or_else(|| panic!("no function `{name}`"))
    }

    fn block(&self, block: &Block, count: &mut OperationCount) {
        for statement in &block.stmts {
            match statement {
                Stmt::Local(local) => {
                    let value = local.init.as_ref().expect("a `let` with a value");
                    assert!(value.diverge.is_none(), "no `else`");
                    self.expr(&value.expr, count);
                }
                Stmt::Expr(value, None) => self.expr(value, count),
                _ => panic!("a statement of another kind"),
            }
        }
    }

    fn expr(&self, expr: &Expr, count: &mut OperationCount) {
        match expr {
            Expr::Path(_) | Expr::Lit(_) => {}
            Expr::Paren(inner) => self.expr(&inner.expr, count),
            Expr::Reference(inner) => self.expr(&inner.expr, count),
            // A value of an earlier chunk, with a literal index.
            Expr::Index(index) if matches!(*index.index, Expr::Lit(_)) => {
                self.expr(&index.expr, count);
            }
            Expr::Block(inner) => self.block(&inner.block, count),
            Expr::Array(array) => array.elems.iter().for_each(|item| self.expr(item, count)),
            Expr::Tuple(tuple) => tuple.elems.iter().for_each(|item| self.expr(item, count)),
            Expr::Struct(made) => {
                made.fields.iter().for_each(|field| self.expr(&field.expr, count));
            }
            Expr::Unary(unary) => {
                assert!(matches!(unary.op, UnOp::Neg(_) | UnOp::Deref(_)), "an operator");
                self.expr(&unary.expr, count);
            }
            Expr::Binary(binary) => {
                match binary.op {
                    BinOp::Mul(_) => count.multiplications += 1,
                    BinOp::Add(_) | BinOp::Sub(_) => count.additions += 1,
                    BinOp::Div(_) => count.divisions += 1,
                    _ => panic!("another operator"),
                }
                self.expr(&binary.left, count);
                self.expr(&binary.right, count);
            }
            Expr::Call(call) => self.call(call, count),
            _ => panic!("no straight line"),
        }
    }

    fn call(&self, call: &ExprCall, count: &mut OperationCount) {
        let Expr::Path(path) = &*call.func else {
            panic!("a call of an expression that is not a path")
        };
        let names: Vec<String> = path.path.segments.iter().map(|s| s.ident.to_string()).collect();
        match names.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
            ["k"] | ["f64", "from"] => {}
            ["T", "recip"] => count.divisions += 1,
            ["T", "mul_add"] => {
                count.multiplications += 1;
                count.additions += 1;
            }
            ["T", "sin_cos"] => count.sin_cos += 1,
            ["T", "sin_cos_all"] => {
                let Some(Expr::Array(angles)) = call.args.first() else { panic!("no array") };
                count.sin_cos += angles.elems.len();
            }
            ["T", "sqrt" | "ln" | "abs" | "max" | "select_nonnegative" | "atan2"] => {
                count.others += 1;
            }
            ["__modyn", "spatial", "Vector3"] => {}
            [part] => {
                *count = *count + self.count(part);
            }
            _ => panic!("a call of {}", names.join("::")),
        }
        call.args.iter().for_each(|argument| self.expr(argument, count));
    }
}
