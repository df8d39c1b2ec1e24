//! Functions of users: their errors, and the text that they become. `tests/tests/user_functions.rs` has their numbers.

use modyn_codegen::TimeStepInput;
use modyn_codegen::graph::Expr;
use modyn_codegen::{
    Builder, Function, FusedFunction, Interpreter, Rotor, Scalar, Target, UserArgument,
    UserDerivatives, UserError, UserFunction,
};

fn robot(name: &str) -> Builder {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../robots");
    let text = std::fs::read_to_string(format!("{folder}/{name}.urdf")).expect("a robot");
    Builder::new().urdf_text(text, format!("{name}.urdf")).functions([])
}

/// The squared distance from a link's origin to a target, and the kinetic energy by the velocities.
struct Reach {
    link: &'static str,
    derivatives: UserDerivatives,
}

const REACH: Reach = Reach { link: "hand", derivatives: UserDerivatives::Second };

impl UserFunction<3> for Reach {
    fn docs(&self) -> String {
        "Returns the cost of reaching.\nNo comment ends here: */ /* \u{7} { }".into()
    }

    fn arguments(&self) -> [UserArgument; 3] {
        [UserArgument::Q, UserArgument::QD, UserArgument::numbers("target", 3)]
    }

    fn derivatives(&self) -> UserDerivatives {
        self.derivatives
    }

    fn evaluate<S: Scalar>(
        &self,
        robot: &mut Interpreter<S>,
        [q, qd, target]: [&[S]; 3],
    ) -> Result<Vec<S>, UserError> {
        let frame = robot.model().link_index(self.link);
        let frame = frame.ok_or_else(|| format!("there is no link `{}`", self.link))?;
        let pose = robot.link_pose(q, frame)?;
        let squares = pose.translation.iter().zip(target).map(|(&x, &t)| (x - t) * (x - t));
        Ok(vec![squares.fold(robot.kinetic_energy(q, qd)?, |sum, square| sum + square)])
    }
}

/// A function of these arguments that returns their first numbers, or something else.
struct Other<F, const N: usize> {
    arguments: [UserArgument; N],
    results: F,
}

impl<F: Fn(usize) -> Vec<f64>, const N: usize> UserFunction<N> for Other<F, N> {
    fn docs(&self) -> String {
        "Returns numbers.".into()
    }

    fn arguments(&self) -> [UserArgument; N] {
        self.arguments
    }

    fn evaluate<S: Scalar>(
        &self,
        robot: &mut Interpreter<S>,
        arguments: [&[S]; N],
    ) -> Result<Vec<S>, UserError> {
        let factors = (self.results)(robot.model().nv());
        Ok(factors.into_iter().map(|factor| S::from_f64(factor) * arguments[0][0]).collect())
    }
}

fn refused(builder: Builder) -> String {
    builder.generate().expect_err("an error").to_string()
}

#[test]
fn names_with_an_error_are_refused() {
    for (name, message) in [
        ("type", "function `type`: its name is a keyword"),
        ("Reach", "function `Reach`: its name is not in snake case"),
        ("", "is not in snake case"),
        ("jacobian_cost", "its name begins with that of the function `jacobian`"),
        ("link", "generated code has another `link`"),
    ] {
        let found = refused(robot("arm7").function(name, REACH));
        assert!(found.contains(message), "{name}: {found}");
    }
    let control = |name: &str| FusedFunction::new(name).function(Function::MassMatrix);
    for (own, fused, message) in [
        ("reach", "reach", "function `reach`: its name belongs to fused function `reach`"),
        (
            "reach",
            "reach_vjp",
            "function `reach`: `reach_vjp` belongs to fused function `reach_vjp`",
        ),
        (
            "reach",
            "reach_jvp_batch",
            "fused function `reach_jvp_batch`: its name belongs to function `reach`",
        ),
    ] {
        let builder = robot("arm7").function(own, REACH).fused([control(fused)]);
        let found = refused(builder);
        assert!(found.contains(message), "{own}, {fused}: {found}");
    }
    let twice = robot("arm7").function("reach", REACH).function("reach_jvp", REACH);
    let found = refused(twice);
    assert!(
        found.contains("function `reach_jvp`: its name belongs to function `reach`"),
        "{found}"
    );
    robot("arm7").function("reach", REACH).function("reaching", REACH).generate().expect("good");
}

#[test]
fn arguments_with_an_error_are_refused() {
    let numbers = |name: &'static str| UserArgument::numbers(name, 2).variable();
    for (other, message) in [
        (numbers("Target"), "the argument \"Target\" has no name of lower-case words"),
        (numbers("x1"), "the argument \"x1\" has no name of lower-case words"),
        (numbers("a__b"), "the argument \"a__b\" has no name of lower-case words"),
        (numbers(""), "the argument \"\" has no name of lower-case words"),
        (numbers("self"), "the argument \"self\" has no name of lower-case words"),
        (numbers("double"), "generated code has another `double`"),
        (numbers("out"), "generated code has another `out`"),
        (numbers("own_function"), "generated code has another `own_function`"),
        (numbers("qd"), "the argument `qd` has another meaning in other functions"),
        (numbers("cotangent"), "the argument `cotangent` has another meaning"),
        (UserArgument::numbers("target", 0), "the argument `target` has no numbers"),
        (UserArgument::Q, "two arguments have the name `q`"),
        (
            UserArgument::velocities("tangent_q"),
            "its derivatives have another argument `tangent_q`",
        ),
    ] {
        let arguments = [UserArgument::Q, other];
        let found = refused(
            robot("arm7").function("own_function", Other { arguments, results: |_| vec![1.0] }),
        );
        assert!(found.contains("function `own_function`: ") && found.contains(message), "{found}");
    }
    let arguments = ["x", "x_x", "x_x_x"].map(numbers);
    let found = refused(robot("arm7").function("own", Other { arguments, results: |_| vec![1.0] }));
    let message = "function `own`: two blocks of its Hessian have the name `hess_x_x_x_x`";
    assert!(found.contains(message), "{found}");
}

/// Returns a number of another trace, whatever `S` is.
struct Foreign(Expr);

impl UserFunction<1> for Foreign {
    fn docs(&self) -> String {
        "Returns a number of another trace.".into()
    }

    fn arguments(&self) -> [UserArgument; 1] {
        [UserArgument::Q]
    }

    fn evaluate<S: Scalar>(
        &self,
        _: &mut Interpreter<S>,
        [q]: [&[S]; 1],
    ) -> Result<Vec<S>, UserError> {
        let stored: &dyn std::any::Any = &self.0;
        Ok(vec![stored.downcast_ref::<S>().copied().unwrap_or(q[0])])
    }
}

#[test]
fn functions_that_cannot_be_traced_are_refused() {
    let link = |link| Reach { link, ..REACH };
    let found = refused(robot("arm7").function("reach", link("hnd")));
    assert!(found.contains("function `reach`: there is no link `hnd`"), "{found}");
    let mut kept = None;
    let _ = modyn_codegen::graph::Graph::trace(|| {
        kept = Some(Expr::input(0));
        Vec::new()
    });
    let found = refused(robot("arm7").function("stored", Foreign(kept.expect("traced"))));
    assert!(found.contains("function `stored`: it used an expression of another trace"), "{found}");
    let arguments = [UserArgument::Q, UserArgument::QD];
    for (results, message) in [
        (Vec::new(), "it has no results"),
        (vec![f64::NAN], "it has a constant that is not a finite number"),
        (vec![1.0, f64::INFINITY], "it has a constant that is not a finite number"),
    ] {
        let results = move |_| results.clone();
        let function = Other { arguments, results };
        let found = refused(robot("arm7").function("numbers", function));
        assert!(found.contains(message), "{found}");
    }
    // All errors at once, and none of a function whose robot is wrong.
    let builder = robot("arm7").function("one", link("a")).function("two", link("b"));
    let found = refused(builder);
    assert!(found.contains("link `a`") && found.contains("link `b`"), "{found}");
}

/// A function of forces or energies of a robot without inertia is refused by its name; one of poses is not.
#[test]
fn functions_that_need_inertia_are_refused_without() {
    let text = include_str!("../../modyn-read/tests/good/kinematics_only.urdf");
    let builder = Builder::new().urdf_text(text, "r.urdf").functions([]);
    let link = Reach { link: "hand", ..REACH };
    let builder = builder.function("pose", Of { forces: false }).function("reach", link);
    let builder = builder.function("force", Of { forces: true });
    let found = builder.clone().generate().expect_err("an error").into_vec();
    let found: Vec<String> = found.iter().map(ToString::to_string).collect();
    assert_eq!(found.len(), 2, "{found:?}");
    for (found, name) in found.iter().zip(["reach", "force"]) {
        let message =
            format!("function `{name}` needs inertia, and joints `shoulder`, `wrist` move none");
        assert!(found.contains("kinematics-only") && found.contains(&message), "{found}");
    }
    let rotors = ["shoulder", "wrist"].map(|joint| Rotor::new(joint, 1.0, 1.0));
    builder.rotors(rotors).generate().expect("rotors have inertia");
}

/// The height of a link, or the accelerations under gravity.
struct Of {
    forces: bool,
}

impl UserFunction<1> for Of {
    fn docs(&self) -> String {
        "Returns numbers.".into()
    }

    fn arguments(&self) -> [UserArgument; 1] {
        [UserArgument::Q]
    }

    fn evaluate<S: Scalar>(
        &self,
        robot: &mut Interpreter<S>,
        [q]: [&[S]; 1],
    ) -> Result<Vec<S>, UserError> {
        if !self.forces {
            return Ok(vec![robot.link_pose(q, 1)?.translation[2]]);
        }
        let still = vec![S::zero(); robot.model().nv()];
        let mut qdd = still.clone();
        robot.forward_dynamics(q, &still, &still, &mut qdd)?;
        Ok(qdd)
    }
}

/// The sum of squares of all products of two velocities, of which there are many.
struct Long;

impl UserFunction<1> for Long {
    fn docs(&self) -> String {
        "Returns a long sum.".into()
    }

    fn arguments(&self) -> [UserArgument; 1] {
        [UserArgument::numbers("u", 400).variable()]
    }

    fn evaluate<S: Scalar>(
        &self,
        _: &mut Interpreter<S>,
        [u]: [&[S]; 1],
    ) -> Result<Vec<S>, UserError> {
        let sines: Vec<S> = u.iter().map(|u| u.sin_cos().0).collect();
        let sum = |x: S| sines.iter().fold(S::zero(), |sum, &s| sum + (s - x) * (s * x));
        Ok(vec![sines.iter().fold(S::zero(), |all, &x| all + sum(x).sqrt())])
    }
}

#[test]
fn long_functions_are_refused() {
    let found = refused(robot("double_pendulum").function("long", Long));
    assert!(found.contains("function `long`: `long") && found.contains("operations"), "{found}");
    assert!(found.contains("UserFunction::derivatives"), "{found}");
}

#[test]
fn the_text_has_functions_and_types() {
    let builder = robot("arm7").type_name("Arm").runtime_gravity();
    let generated = builder.clone().function_batch("reach", REACH).generate().expect("good");
    for line in [
        "/// No comment ends here: * / / *   { }",
        "pub fn reach(q: &[f64; 7], qd: &[f64; 7], target: &[f64; 3]) -> f64 {",
        "pub fn reach_jvp(q: &[f64; 7], qd: &[f64; 7], target: &[f64; 3], tangent_q: &[f64; 7], tangent_qd: &[f64; 7]) -> ArmReachJvp<f64> {",
        "/// Returns the value of `reach`, and the gradients of `reach`. Derivatives with respect to `q` are in tangent",
        "pub fn reach_gradient(q: &[f64; 7], qd: &[f64; 7], target: &[f64; 3]) -> ArmReachGradient<f64> {",
        "pub struct ArmReachHessian<T = f64> {",
        "    /// The gradient of `reach` with respect to `q`.",
        "    pub grad_q: [T; 7],",
        "    /// The second derivatives of `reach` with respect to `q` (rows) and `qd` (columns), by columns.",
        "    pub hess_q_qd: [[T; 7]; 7],",
        "pub fn reach_hessian_batch(",
        "/// - function `reach(q, qd, target)` of the user, also for many states",
    ] {
        assert!(generated.text.contains(line), "{line}");
    }
    // Neither a pose nor a velocity depends on gravity.
    assert!(!generated.text.contains("reach_with"));
    for none in ["pub fn reach_vjp", "pub fn reach_jacobian", "tangent_target", "grad_target"] {
        assert!(!generated.text.contains(none), "{none}");
    }
    let first = Reach { derivatives: UserDerivatives::First, ..REACH };
    let names = |builder: Builder| {
        let generated = builder.generate().expect("good");
        generated.operations.into_iter().map(|(name, _)| name).collect::<Vec<_>>()
    };
    assert_eq!(
        names(builder.clone().function("reach", first)),
        ["reach", "reach_jvp", "reach_gradient"]
    );
    let none = Reach { derivatives: UserDerivatives::None, ..REACH };
    assert_eq!(names(builder.clone().function("reach", none)), ["reach"]);
    // A function of constants has no derivatives.
    let arguments = [UserArgument::Q.constant(), UserArgument::number("u")];
    let constant = Other { arguments, results: |n| vec![1.0; n] };
    assert_eq!(names(builder.function("constant", constant)), ["constant"]);
}

#[test]
fn casadi_has_no_functions_of_users() {
    let errors = robot("arm7").function("reach", REACH).emit(Target::Casadi);
    let errors = errors.map(|_| ()).expect_err("an error");
    assert!(errors.to_string().contains("`CasADi` has no functions of users"), "{errors}");
}

/// The velocities after a Runge-Kutta step.
struct Step;

impl UserFunction<4> for Step {
    fn docs(&self) -> String {
        "Returns the velocities after a Runge-Kutta step.".into()
    }

    fn arguments(&self) -> [UserArgument; 4] {
        [
            UserArgument::Q,
            UserArgument::QD,
            UserArgument::TAU,
            UserArgument::numbers("time_step", 1),
        ]
    }

    fn derivatives(&self) -> UserDerivatives {
        UserDerivatives::First
    }

    fn evaluate<S: Scalar>(
        &self,
        robot: &mut Interpreter<S>,
        [q, qd, tau, time_step]: [&[S]; 4],
    ) -> Result<Vec<S>, UserError> {
        let (mut next_q, mut next_qd) = (q.to_vec(), qd.to_vec());
        robot.step_rk4(
            TimeStepInput { q, qd, tau, dt: time_step[0] },
            &mut next_q,
            &mut next_qd,
        )?;
        Ok(next_qd)
    }
}

/// The adjoint of a function of the table by a function of the user: at most five times its operations, fewer than its
/// matrices take.
#[test]
fn functions_of_the_table_have_adjoints_by_functions_of_users() {
    let builder = robot("arm7").function("advance", Step);
    let builder = builder.functions([Function::StepRk4, Function::StepRk4Derivatives]);
    let generated = builder.generate().expect("good");
    let count = |name: &str| {
        let (_, count) = generated.operations.iter().find(|(own, _)| *own == name).expect(name);
        count.total()
    };
    let [step, matrices, vjp, jvp] =
        ["advance", "step_rk4_derivatives", "advance_vjp", "advance_jvp"].map(count);
    assert!(vjp < 5 * step && jvp < 5 * step && vjp < matrices, "{step} {matrices} {vjp} {jvp}");
    for form in ["pub fn advance_vjp(", "pub fn advance_jvp(", "time_step: &[f64; 1]"] {
        assert!(generated.text.contains(form), "{form}");
    }
}

/// The operations of a cost and its derivatives: of the value, of the gradient and of the Hessian.
#[test]
fn counts_are_as_frozen() {
    let generated = robot("arm7").function("reach", REACH).generate().expect("good");
    let count = |name: &str| {
        let (_, count) = generated.operations.iter().find(|(own, _)| *own == name).expect("a form");
        count.total()
    };
    assert_eq!(
        ["reach", "reach_jvp", "reach_gradient", "reach_hessian"].map(count),
        [294, 720, 655, 4269],
        "\nA count that falls is to be entered; one that rises is a regression."
    );
}

#[test]
fn fused_functions_share_the_work_of_functions() {
    let builder = robot("arm7").type_name("Arm").function("reach", REACH);
    let stage = FusedFunction::new("stage")
        .own_function("reach_gradient")
        .function(Function::StepSemiImplicitDerivatives)
        .own_function("reach_hessian")
        .batch();
    let hand = FusedFunction::new("hand").of_link(Function::LinkPose, "hand").own_function("reach");
    let builder = builder.functions([Function::StepSemiImplicitDerivatives, Function::LinkPose]);
    let builder = builder.fused([stage, hand]);
    let generated = builder.generate().expect("good");
    for line in [
        "pub fn stage(q: &[f64; 7], qd: &[f64; 7], tau: &[f64; 7], dt: f64, target: &[f64; 3]) -> ArmStage<f64> {",
        "pub struct ArmStage<T = f64> {",
        "    pub reach_gradient: ArmReachGradient<T>,",
        "    pub reach_hessian: ArmReachHessian<T>,",
        "pub fn stage_batch(",
        "/// - fused function `stage`, also for many states: `reach_gradient`, \
         `step_semi_implicit_derivatives`, `reach_hessian`",
    ] {
        assert!(generated.text.contains(line), "{line}");
    }
    let operations = |name: &str| {
        let found = generated.operations.iter().find(|(other, _)| *other == name);
        found.expect(name).1.total()
    };
    let members = ["reach_gradient", "reach_hessian", "step_semi_implicit_derivatives"];
    assert_eq!((operations("stage"), members.map(operations)), (8656, [655, 4269, 4469]));
    let members = ["link_pose", "reach"];
    assert_eq!((operations("hand"), members.map(operations)), (390, [134, 294]));
}

#[test]
fn fused_functions_with_an_error_are_refused() {
    let fused = |builder: Builder, name: &str| {
        let stage = FusedFunction::new("stage").function(Function::ForwardDynamicsHessian);
        refused(builder.fused([stage.own_function(name)]))
    };
    let found = fused(robot("arm7").function("reach", REACH), "reach_gradiant");
    assert!(
        found.contains("fused function `stage`: there is no function `reach_gradiant` of yours"),
        "{found}"
    );
    assert!(found.contains("did you mean `reach_gradient`?"), "{found}");
    let found = fused(robot("arm7"), "cost");
    assert!(found.contains("add it with `Builder::function`"), "{found}");
    // The weights of three results, and of seven accelerations.
    let arguments = [UserArgument::Q, UserArgument::QD];
    let three = Other { arguments, results: |_| vec![1.0; 3] };
    let found = fused(robot("arm7").function("three", three), "three_vjp");
    let message = "`forward_dynamics_hessian` and `three_vjp` have different arguments `cotangent`";
    assert!(found.contains(message), "{found}");
    // A link that is not there is found beside an error of the function.
    let stage =
        FusedFunction::new("stage").of_link(Function::LinkPose, "hnd").own_function("reach");
    let found =
        refused(robot("arm7").function("reach", Reach { link: "hnd", ..REACH }).fused([stage]));
    assert!(found.contains("fused function `stage`: link `hnd` does not exist"), "{found}");
    assert!(found.contains("function `reach`: there is no link `hnd`"), "{found}");
}
