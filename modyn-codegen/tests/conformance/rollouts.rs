//! Kernels for graphics processors: CUDA's rollouts, compiled for the host, compute what loops of generated C do; `of_cuda`
//! compares the numbers of functions. `modyn-gpu` runs WGSL's.

use std::process::Command;

use modyn_codegen::emit::RolloutBuffer;
use modyn_codegen::{
    Base, Builder, Contact, ContactKind, Function, GpuLanguage, LoopEnd, RolloutForces,
    RolloutOptions, Target,
};

use modyn_runtime::spatial::Pose;
use modyn_runtime::{ContactSurface, StepSettings};

use crate::conformance::c::{STRICT, write};
use crate::conformance::{command, contact, folder, kinds, robot};

/// Compiles the C text of `builder`, a text of CUDA and a program that includes both, and runs the program.
fn build(name: &str, builder: &Builder, (kernels, main): (&str, &str)) {
    let folder = folder(name);
    write(&builder.clone().type_name("Ours").emit(Target::C).expect("good"), &folder);
    let files =
        [("kernels.cu", kernels), ("shim.h", include_str!("../cuda_shim.h")), ("main.cpp", main)];
    for (file, text) in files {
        std::fs::write(folder.join(file), text).expect("writes");
    }
    command(Command::new("gcc").args(STRICT).args(["-c", "ours.c"]).current_dir(&folder));
    let options = ["-std=c++17", "-O1", "-Wall", "-Wno-unused-function", "-Wno-unused-variable"];
    let mut compile = Command::new("g++");
    compile.args(options).args(["main.cpp", "ours.o", "-lm", "-o", "main"]);
    command(compile.current_dir(&folder));
    assert_eq!(command(&mut Command::new(folder.join("main"))), "done\n", "{name}");
}

/// Two feet of the quadruped.
fn feet() -> [Contact; 2] {
    let point = |name: &str, link: &str, xyz: [f64; 3]| Contact {
        name: name.into(),
        kind: ContactKind::Point,
        end: LoopEnd { link: link.into(), xyz, rpy: [0.0; 3] },
    };
    [
        point("left", "front_left_foot", [0.0, 0.01, -0.02]),
        point("right", "hind_right_foot", [0.03, -0.01, 0.02]),
    ]
}

/// Returns the place of the quaternion of a floating base among the coordinates.
fn quaternion_of(builder: &Builder) -> i32 {
    let model = builder.plan().expect("good").model;
    let (_, quaternion) = model.quaternions().next().expect("a floating base");
    i32::try_from(quaternion).expect("small")
}

/// Run-time parameters are common to all states; WGSL has them as a buffer, too.
#[test]
fn texts_name_their_buffers() {
    let builder = robot("arm6").functions([Function::GravityTorques]).runtime_gravity();
    let cuda = builder.emit(Target::Cuda).expect("good");
    assert!(cuda.text().contains("arm6_gravity_torques(const double *__restrict__ q, const double *__restrict__ params, double *__restrict__ out, unsigned int count)"), "{}", cuda.text());
    assert!(cuda.text().contains("params[2]") && cuda.text().contains("q[1 * n]"));
    let wgsl = builder.emit(Target::Wgsl).expect("good");
    for line in [
        "@group(0) @binding(1) var<storage, read> arm6_gravity_torques_params: array<f32>;",
        "@group(0) @binding(2) var<storage, read_write> arm6_gravity_torques_out: array<f32>;",
        "@group(0) @binding(3) var<uniform> arm6_gravity_torques_count: vec4<u32>;",
    ] {
        assert!(wgsl.text().contains(line), "{line}");
    }
    let [kernel] = &*wgsl.kernels else { panic!("one kernel") };
    assert_eq!((kernel.result, kernel.arguments.len()), (6, 2));
    assert!(kernel.arguments[1].common && !kernel.arguments[0].common);
}

/// A text begins with the names of the coordinates and velocities in order, and with the sizes that functions of the user
/// can name.
#[test]
fn texts_begin_with_names_and_sizes() {
    let builder = robot("quadruped").functions([Function::StepSemiImplicit]).base(Base::Floating);
    let model = builder.generate().expect("good").model;
    let options = RolloutOptions::default();
    for (language, sizes) in [
        (GpuLanguage::Cuda, ["#define QUADRUPED_NQ 19", "#define QUADRUPED_NV 18"]),
        (GpuLanguage::Wgsl, ["const QUADRUPED_NQ = 19u;", "const QUADRUPED_NV = 18u;"]),
    ] {
        let kernels = builder.emit(language.into()).expect("good");
        let (rollouts, _) = builder.emit_rollouts(language, &options).expect("good");
        for text in [kernels.text(), &rollouts.text] {
            let (head, _) = text.split_once("\n\n").expect("an empty line after the head");
            let names = |title: &str| {
                let (_, list) = head.split_once(&format!("// {title}: ")).expect(title);
                let (list, _) = list.split_once(".\n").expect("an end");
                list.replace("\n//  ", "").split(", ").map(String::from).collect::<Vec<_>>()
            };
            let coordinates = names("Coordinates q");
            assert_eq!(coordinates, model.coordinate_names());
            assert_eq!((coordinates.len(), &*coordinates[6]), (19, "floating_base.qw"));
            let velocities = names("Velocities qd, accelerations and joint forces");
            assert_eq!(velocities, model.velocity_names());
            assert_eq!((velocities.len(), &velocities[6]), (18, &coordinates[7]));
            for size in sizes {
                assert!(head.lines().any(|line| line == size), "{size}\n{head}");
            }
        }
    }
}

/// A program that computes rollouts by the kernel, and by C's functions in a loop. The first quaternion of `q` begins at
/// `quaternion`, if it is not negative. `forces` and `cost` are statements that compute `tau` and `sum` by C.
fn rollout_harness(
    (robot, step, starts): (&str, &str, usize),
    quaternion: i32,
    arguments: [&str; 2],
    (forces, cost): (&str, &str),
) -> String {
    let [data, costs] = arguments;
    // Functions of tests take numbers, those of C a struct.
    let made = ["step", "step_actuated", "step_constrained"].contains(&step);
    let next = if made { "next" } else { "(ours_step_t *)next" };
    format!(
        "#include <cmath>\n#include <cstdio>\n#include <limits>\n#include <vector>\n#include \"shim.h\"\nusing namespace std;\n\
         extern \"C\" {{\n#include \"ours.h\"\n}}\n#include \"kernels.cu\"\n\
         static unsigned long long seed = 1;\n\
         static double number() {{\n\
         seed = seed * 6364136223846793005ULL + 1442695040888963407ULL;\n\
         return (double)(seed >> 33) / 1073741824.0 - 1.0;\n}}\n\
         int main() {{\nconst unsigned n = 21, steps = 12, starts = {starts};\nblockDim.x = 8;\n\
         const int nq = OURS_NQ, nv = OURS_NV, size = nq + nv;\nconst double dt[1] = {{ 0.004 }};\n\
         vector<double> q(nq * starts), qd(nv * starts), data = {{ 0.7, 0.3, 0.2, -0.4, 0.9 }};\n\
         vector<double> params = {{ 0.3, -0.8, -9.1 }};\n\
         for (double &x : q) x = number();\nfor (double &x : qd) x = number();\n\
         for (unsigned i = 0; i < starts && {quaternion} >= 0; ++i) {{ double s = 0;\n\
         for (int j = {quaternion}; j < {quaternion} + 4; ++j) s += q[j * starts + i] * q[j * starts + i];\n\
         for (int j = {quaternion}; j < {quaternion} + 4; ++j) q[j * starts + i] /= sqrt(s); }}\n\
         vector<double> controls({robot}_CONTROLS * steps * n), out(size * n), costs(n), trajectory(size * steps * n);\n\
         for (double &x : controls) x = number();\n\
         for (int recorded = 0; recorded < 2; ++recorded) {{\n\
         for (unsigned i = 0; i < 24; ++i) {{ blockIdx.x = i / 8; threadIdx.x = i % 8;\n\
         theirs_{rollout}(q.data(), qd.data(), controls.data(), {data}out.data(), {costs}\
         recorded ? trajectory.data() : 0, dt[0], steps, starts, n); }}\n\
         double worst = 0, moved = 0;\n\
         for (unsigned i = 0; i < n; ++i) {{\n\
         double s[size], u[{robot}_CONTROLS], tau[nv], sum = 0;\n\
         for (int j = 0; j < size; ++j) s[j] = j < nq ? q[j * starts + i % starts] : qd[(j - nq) * starts + i % starts];\n\
         for (unsigned k = 0; k < steps; ++k) {{\n\
         for (int j = 0; j < {robot}_CONTROLS; ++j) u[j] = controls[(k * {robot}_CONTROLS + j) * n + i];\n\
         {forces}\n\
         double next[size];\nours_{step}(s, s + nq, tau, dt, {next});\n\
         for (int j = 0; j < size; ++j) {{ moved = fmax(moved, fabs(next[j] - s[j])); s[j] = next[j]; }}\n\
         {cost}\n\
         for (int j = 0; j < size && recorded; ++j)\n\
         worst = fmax(worst, fabs(trajectory[(k * size + j) * n + i] - s[j]) / fmax(1, fabs(s[j])));\n}}\n\
         for (int j = 0; j < size; ++j) worst = fmax(worst, fabs(out[j * n + i] - s[j]) / fmax(1, fabs(s[j])));\n\
         worst = fmax(worst, fabs(costs[i] - sum) / fmax(1, fabs(sum)));\n}}\n\
         if (!(worst < 1e-11) || !(moved > 1e-3)) {{ printf(\"%g %g\\n\", worst, moved); return 0; }}\n}}\n\
         printf(\"done\\n\");\nreturn 0;\n}}\n",
        rollout = step.replacen("step", "rollout", 1),
    )
}

/// An arm with run-time gravity, three controls, forces and a cost that call functions of the robot, and each rollout from
/// its own state.
#[test]
#[ignore = "slow: g++ compiles a robot"]
fn rollouts_are_loops_of_steps() {
    let functions = [
        Function::StepSemiImplicit,
        Function::StepRk4,
        Function::GravityTorques,
        Function::LinkPose,
    ];
    let builder = robot("arm7").functions(functions).runtime_gravity();
    let user = "const theirs_real *q, const theirs_real *qd, const theirs_real *u, unsigned int step, \
                const theirs_real *data, const theirs_real *params";
    let forces = RolloutForces {
        text: format!(
            "static __device__ void forces({user}, theirs_real *tau)\n{{\n    theirs_gravity_torques(q, params, tau);\n    \
             for (int j = 0; j < 7; ++j) {{ tau[j] += data[0] * u[j % 3] - data[1] * qd[j]; }}\n}}\n"
        ),
        controls: 3,
    };
    let cost = format!(
        "static __device__ theirs_real cost({user})\n{{\n    theirs_real pose[12];\n    \
         theirs_link_pose_hand(q, pose);\n    theirs_real sum = (step + 1) * data[0] * u[2] * u[2] + qd[6] * data[1];\n    \
         for (int j = 0; j < 3; ++j) {{ sum += (pose[9 + j] - data[2 + j]) * (pose[9 + j] - data[2 + j]); }}\n    \
         return sum;\n}}\n"
    );
    let options = RolloutOptions { cost: Some(cost), forces: Some(forces), active_contacts: None };
    let theirs = builder.clone().type_name("Theirs");
    let (source, _) = theirs.emit_rollouts(GpuLanguage::Cuda, &options).expect("good");
    let names: Vec<&str> = source.rollouts.iter().map(|rollout| &*rollout.name).collect();
    assert_eq!(names, ["theirs_rollout_semi_implicit", "theirs_rollout_rk4"]);
    let forces = "ours_gravity_torques_with(s, params.data(), tau);\n\
                  for (int j = 0; j < nv; ++j) tau[j] += 0.7 * u[j % 3] - 0.3 * s[nq + j];";
    let cost = "ours_pose_t pose;\nours_link_pose(s, OURS_LINK_HAND, &pose);\n\
                sum += (k + 1) * 0.7 * u[2] * u[2] + 0.3 * s[nq + 6];\n\
                for (int j = 0; j < 3; ++j) sum += pow(pose.translation[j] - data[2 + j], 2);";
    for step in ["step_semi_implicit", "step_rk4"] {
        let arguments = ["data.data(), params.data(), ", "costs.data(), "];
        let main = rollout_harness(("ARM", step, 21), -1, arguments, (forces, cost));
        let main = main.replace("ARM_CONTROLS", "3");
        // C's functions with run-time parameters have names of their own.
        let described = format!("ours_{step}(s, s + nq, tau, dt, (ours_step_t *)next)");
        let with =
            format!("ours_{step}_with(s, s + nq, tau, dt, params.data(), (ours_step_t *)next)");
        assert!(main.contains(&described));
        let main = main.replace(&described, &with);
        build(&format!("rollout_{step}"), &builder, (&source.text, &main));
    }
}

/// A floating quadruped, whose controls are its joint forces; several rollouts start from one state.
#[test]
#[ignore = "slow: g++ compiles a robot"]
fn rollouts_of_a_floating_robot() {
    let builder = robot("quadruped").functions([Function::StepSemiImplicit]).base(Base::Floating);
    let theirs = builder.clone().type_name("Theirs");
    let options = RolloutOptions::default();
    let (source, _) = theirs.emit_rollouts(GpuLanguage::Cuda, &options).expect("good");
    let quaternion = quaternion_of(&builder);
    let forces = "for (int j = 0; j < nv; ++j) tau[j] = u[j];";
    let main =
        rollout_harness(("LEGS", "step_semi_implicit", 4), quaternion, ["", ""], (forces, ""));
    let main = main.replace("LEGS_CONTROLS", "nv");
    build("rollout_floating", &builder, (&source.text, &main));
}

/// Feet of a quadruped on tilted and moving ground: a foot is proposed by its height or by the number of the step, and
/// released where it would pull.
#[test]
#[ignore = "slow: g++ compiles a robot"]
fn rollouts_that_hold_contacts() {
    let functions = [Function::ConstrainedForwardDynamics, Function::Integrate, Function::LinkPose];
    let builder = robot("quadruped").functions(functions).base(Base::Floating).contacts(feet());
    let theirs = builder.clone().type_name("Theirs");
    let proposed = "static __device__ void active_contacts(const theirs_real *q, const theirs_real *qd, const theirs_real *u, \
                    unsigned int step, const theirs_real *data, theirs_real *active)\n{\n    theirs_real pose[12];\n    \
                    theirs_link_pose_front_left_foot(q, pose);\n    active[0] = pose[11] < data[1] ? 1 : 0;\n    \
                    active[1] = step % 3 != 0 ? 1 : 0;\n}\n";
    let options =
        RolloutOptions { active_contacts: Some(proposed.into()), ..RolloutOptions::default() };
    let (source, _) = theirs.emit_rollouts(GpuLanguage::Cuda, &options).expect("good");
    let [rollout] = &*source.rollouts else { panic!("one kernel") };
    assert_eq!((&*rollout.name, rollout.settings), ("theirs_rollout_constrained", 52));
    let quaternion = quaternion_of(&builder);
    let step = "static vector<double> settings;\nstatic unsigned current, held, released;\n\
        static void ours_step_constrained(const double *q, const double *qd, const double *tau, const double *dt, double *next)\n{\n\
        const int nq = OURS_NQ, nv = OURS_NV;\nours_pose_t pose;\nours_constrained_forward_dynamics_t r;\ndouble moved[nv];\n\
        ours_link_pose(q, OURS_LINK_FRONT_LEFT_FOOT, &pose);\n\
        double active[2] = { pose.translation[2] < 0.3 ? 1.0 : 0.0, current % 3 != 0 ? 1.0 : 0.0 };\n\
        for (int sweep = 0; sweep < 2; ++sweep) {\n\
        ours_constrained_forward_dynamics(q, qd, tau, active, (const ours_constraint_settings_t *)settings.data(), &r);\n\
        for (int c = 0; c < 2; ++c) { const double *f = r.wrenches[c].force, *ground = settings.data() + 4 + 24 * c;\n\
        held += active[c] > 0;\n\
        if (f[0] * ground[2] + f[1] * ground[5] + f[2] * ground[8] < 0) { released += active[c] > 0; active[c] = 0; } }\n}\n\
        for (int j = 0; j < nv; ++j) { next[nq + j] = qd[j] + dt[0] * r.qdd[j]; moved[j] = dt[0] * next[nq + j]; }\n\
        ours_integrate(q, moved, next);\n}\n";
    let fill = "settings = { 10, 8, 1e-10, 1e-10 };\n\
        for (int c = 0; c < 2; ++c) { const double a = 0.3 - 0.5 * c, s = sin(a), k = cos(a);\n\
        const double target[24] = { 1, 0, 0, 0, k, -s, 0, s, k, 0.1, 0.2, -0.1, 0.1, 0, 0.2, 0.1, -0.2, 0.3, 0.5, 20, 15, 1e-3, 0, 1 };\n\
        settings.insert(settings.end(), target, target + 24); }\n";
    let forces = "for (int j = 0; j < nv; ++j) tau[j] = u[j];\ncurrent = k;";
    let arguments = ["settings.data(), data.data(), ", ""];
    let main =
        rollout_harness(("LEGS", "step_constrained", 21), quaternion, arguments, (forces, ""));
    let main = main.replace("LEGS_CONTROLS", "nv");
    let main = main.replace("int main() {\n", &format!("{step}int main() {{\n{fill}"));
    let done = "printf(\"done\\n\");";
    assert!(main.contains(done) && main.contains(fill));
    let both = "printf(released > 20 && held > 5 * released / 4 ? \"done\\n\" : \"%u of %u\\n\", released, held);";
    build("rollout_constrained", &builder, (&source.text, &main.replace(done, both)));
}

/// A pendulum that swings against a tilted floor and its stop.
#[test]
fn rollouts_by_a_solver() {
    let toe = contact("toe", ContactKind::Point, "lower", [0.1, 0.2, -0.3]);
    solver_conforms("pendulum", &robot("double_pendulum").contacts([toe]), -1);
}

#[test]
#[ignore = "slow: g++ compiles a robot"]
fn rollouts_by_a_solver_of_a_floating_robot() {
    let foot = |link: &str| contact(link, ContactKind::Point, link, [0.0; 3]);
    let feet = ["front_left_foot", "front_right_foot", "hind_left_foot", "hind_right_foot"];
    let builder = robot("quadruped").base(Base::Floating).contacts(feet.map(foot));
    solver_conforms("quadruped", &builder, quaternion_of(&builder));
}

/// Returns the settings of a step, for contacts with a tilted floor.
fn tilted(contacts: usize) -> Vec<f64> {
    let [sine, cosine] = [0.3_f64.sin(), 0.3_f64.cos()];
    let plane = Pose {
        rotation: [[1.0, 0.0, 0.0], [0.0, cosine, -sine], [0.0, sine, cosine]],
        translation: [0.1, 0.2, -0.4],
    };
    let surface = ContactSurface { plane, friction: 0.6, ..ContactSurface::<f64>::GROUND };
    let common = StepSettings::<f64, [ContactSurface<f64>; 0]>::DEFAULT.numbers();
    let surfaces = (0..contacts).flat_map(|_| surface.numbers());
    common.into_iter().chain(surfaces).collect()
}

/// Each step starts from the accelerations of the last.
fn solver_conforms(name: &str, builder: &Builder, quaternion: i32) {
    let builder = &builder.clone().functions([Function::Step]);
    let theirs = builder.clone().type_name("Theirs");
    let options = RolloutOptions::default();
    let (source, _) = theirs.emit_rollouts(GpuLanguage::Cuda, &options).expect("good");
    let [rollout] = &*source.rollouts else { panic!("one kernel") };
    let contacts = builder.plan().expect("good").model.touching_shapes().len();
    let settings = tilted(contacts);
    assert_eq!((&*rollout.name, rollout.settings), ("theirs_rollout", settings.len()));
    let numbers = settings.iter().map(f64::to_string).collect::<Vec<String>>().join(", ");
    let step = format!(
        "static vector<double> settings = {{ {numbers} }};\nstatic unsigned current, pushed;\n\
        static void ours_step(const double *q, const double *qd, const double *tau, const double *dt, double *next)\n{{\n\
        const int n = OURS_NQ + OURS_NV, forces = 3 * {contacts};\n\
        static double start[OURS_NV];\nours_step_solution_t solution;\nconst double *r = (const double *)&solution;\n\
        for (int j = 0; j < OURS_NV && current == 0; ++j) start[j] = 0;\n\
        ours_step(q, qd, tau, dt, start, (const ours_step_settings_t *)settings.data(), &solution);\n\
        for (int j = 0; j < n; ++j) next[j] = r[j];\n\
        for (int j = 0; j < OURS_NV; ++j) start[j] = r[n + j];\n\
        for (int j = 0; j < forces; ++j) pushed += r[n + OURS_NV + j] != 0;\n}}\n"
    );
    let forces = "for (int j = 0; j < nv; ++j) tau[j] = u[j];\ncurrent = k;";
    let arguments = ["settings.data(), ", ""];
    let starts = if quaternion < 0 { 21 } else { 4 };
    let main = rollout_harness(("LEGS", "step", starts), quaternion, arguments, (forces, ""));
    let main = main.replace("LEGS_CONTROLS", "nv");
    let main = main.replace("int main() {\n", &format!("{step}int main() {{\n"));
    let done = "printf(\"done\\n\");";
    assert!(main.contains(done) && main.contains(&step));
    let both = "printf(pushed > 200 ? \"done\\n\" : \"%u\\n\", pushed);";
    // The solver ends at a tolerance.
    let main = main.replace(done, both).replace("worst < 1e-11", "worst < 1e-9");
    build(&format!("rollout_solver_{name}"), builder, (&source.text, &main));
}

/// Each step starts from the accelerations and the activations of the last.
#[test]
#[ignore = "slow: g++ compiles a robot"]
fn rollouts_under_controls() {
    for name in ["actuators", "motors"] {
        let case = kinds().into_iter().find(|case| case.name == name).expect("a kind");
        let builder = case.builder.functions([Function::StepActuated]);
        let model = builder.plan().expect("good").model;
        let [controls, activations] = [model.control_names().len(), model.activation_names().len()];
        let theirs = builder.clone().type_name("Theirs");
        let options = RolloutOptions::default();
        let (source, _) = theirs.emit_rollouts(GpuLanguage::Cuda, &options).expect("good");
        let [rollout] = &*source.rollouts else { panic!("one kernel") };
        assert_eq!((&*rollout.name, rollout.controls), ("theirs_rollout_actuated", controls));
        let has_act = activations > 0;
        assert_eq!(source.activations, activations);
        assert_eq!(source.buffers.contains(&RolloutBuffer::StartAct), has_act);
        let act = if has_act { "act, " } else { "" };
        let step = format!(
            "static vector<double> settings = {{ 1e-12, 1 }};\nstatic unsigned current, first;\n\
            static const double *given;\nstatic vector<double> acts;\n\
            static void ours_step_actuated(const double *q, const double *qd, const double *, const double *dt, double *next)\n{{\n\
            const int n = OURS_NQ + OURS_NV, na = {activations};\n\
            static double start[OURS_NV], act[na + 1], applied[OURS_NV];\nours_actuated_step_t solution;\nconst double *r = (const double *)&solution;\n(void)act;\n\
            for (int j = 0; j < OURS_NV && current == 0; ++j) start[j] = 0;\n\
            for (int j = 0; j < na && current == 0; ++j) act[j] = acts[j * 4 + first];\n\
            ours_step_actuated(q, qd, given, dt, {act}applied, start, (const ours_step_settings_t *)settings.data(), &solution);\n\
            for (int j = 0; j < n; ++j) next[j] = r[j];\n\
            for (int j = 0; j < na; ++j) act[j] = r[n + j];\n\
            for (int j = 0; j < OURS_NV; ++j) start[j] = r[n + na + j];\n}}\n"
        );
        let forces = "tau[0] = 0; given = u;\ncurrent = k; first = i % starts;";
        let arguments = ["settings.data(), ", ""];
        let main = rollout_harness(("GRIPPER", "step_actuated", 4), -1, arguments, (forces, ""));
        let main = main.replace("GRIPPER_CONTROLS", &controls.to_string());
        let given = ["qd.data(), controls.data()", "vector<double> controls("];
        assert!(given.iter().all(|text| main.contains(text)));
        let start = if has_act { "qd.data(), acts.data(), controls.data()" } else { given[0] };
        let filled = format!(
            "acts.resize({activations} * starts);\nfor (double &x : acts) x = number();\n{}",
            given[1]
        );
        let main = main.replace(given[0], start).replace(given[1], &filled);
        let main = main.replace("int main() {\n", &format!("{step}int main() {{\n"));
        let main = main.replace("worst < 1e-11", "worst < 1e-9");
        build(&format!("rollout_{name}"), &builder, (&source.text, &main));
    }
}

/// The user's function of a rollout returns joint forces, and a step under controls has none.
#[test]
fn steps_under_controls_have_no_forces_of_the_user() {
    let case = kinds().into_iter().find(|case| case.name == "motors").expect("a kind");
    let forces = Some(RolloutForces { text: String::new(), controls: 1 });
    let options = RolloutOptions { forces, ..RolloutOptions::default() };
    let builder = case.builder.functions([Function::StepActuated]);
    let error = builder.emit_rollouts(GpuLanguage::Wgsl, &options).expect_err("no step");
    assert!(error.to_string().contains("`forces`"), "{error}");
}

/// Closed loops alone: no function of the user.
#[test]
#[ignore = "slow: g++ compiles a robot"]
fn rollouts_that_close_loops() {
    let functions = [Function::ConstrainedForwardDynamics, Function::Integrate];
    let builder = robot("five_bar").functions(functions);
    let theirs = builder.clone().type_name("Theirs");
    let options = RolloutOptions::default();
    let (source, _) = theirs.emit_rollouts(GpuLanguage::Cuda, &options).expect("good");
    assert_eq!(
        (&*source.rollouts[0].name, source.rollouts[0].settings),
        ("theirs_rollout_constrained", 4)
    );
    let step = "static const double settings[4] = { 20, 15, 1e-10, 1e-10 };\n\
        static void ours_step_constrained(const double *q, const double *qd, const double *tau, const double *dt, double *next)\n{\n\
        const int nq = OURS_NQ, nv = OURS_NV;\nours_constrained_forward_dynamics_t r;\ndouble moved[nv];\n\
        ours_constrained_forward_dynamics(q, qd, tau, (const ours_constraint_settings_t *)settings, &r);\n\
        for (int j = 0; j < nv; ++j) { next[nq + j] = qd[j] + dt[0] * r.qdd[j]; moved[j] = dt[0] * next[nq + j]; }\n\
        ours_integrate(q, moved, next);\n}\n";
    let forces = "for (int j = 0; j < nv; ++j) tau[j] = u[j];";
    let arguments = ["settings, ", ""];
    let main = rollout_harness(("BARS", "step_constrained", 21), -1, arguments, (forces, ""));
    let main = main.replace("BARS_CONTROLS", "nv");
    let main = main.replace("int main() {\n", &format!("{step}int main() {{\n"));
    build("rollout_loops", &builder, (&source.text, &main));
}

/// A rollout of contacts without contacts or their functions is an error with a remedy.
#[test]
fn contacts_of_rollouts_need_their_functions() {
    let builder = robot("arm6").functions([Function::StepSemiImplicit]);
    let options =
        RolloutOptions { active_contacts: Some(String::new()), ..RolloutOptions::default() };
    let error = builder.emit_rollouts(GpuLanguage::Wgsl, &options).expect_err("no contacts");
    assert!(error.to_string().contains("`constrained_forward_dynamics` and"), "{error}");
}

/// What a rollout lacks is an error with a remedy.
#[test]
fn rollouts_need_a_step_and_controls() {
    let builder = robot("arm6").functions([Function::ForwardDynamics]);
    let options = RolloutOptions::default();
    let error = builder.emit_rollouts(GpuLanguage::Wgsl, &options).expect_err("no step");
    assert!(error.to_string().contains("step_semi_implicit"), "{error}");
    let forces = Some(RolloutForces { text: String::new(), controls: 0 });
    let options = RolloutOptions { forces, ..options };
    let builder = builder.functions([Function::StepSemiImplicit]);
    let error = builder.emit_rollouts(GpuLanguage::Wgsl, &options).expect_err("no control");
    assert!(error.to_string().contains("at least 1"), "{error}");
}

/// A rollout in C is a loop of steps, from which the state, the numbers of the next step's start and the trajectory come.
#[test]
fn rollouts_in_c_are_loops_of_steps() {
    let tip = Contact {
        name: "tip".into(),
        kind: ContactKind::Point,
        end: LoopEnd { link: "lower".into(), xyz: [0.1, 0.0, -0.4], rpy: [0.0; 3] },
    };
    let builder = robot("double_pendulum").contacts([tip]);
    let builder = builder.functions([Function::StepRk4, Function::Step]).runtime_gravity();
    let folder = folder("rollouts_in_c");
    write(&builder.type_name("Ours").emit(Target::C).expect("good"), &folder);
    let soft = tilted(1);
    let soft = soft.iter().map(f64::to_string).collect::<Vec<String>>().join(", ");
    let main = "#include <stdio.h>\n#include <string.h>\n#include \"ours.h\"\n\
        enum { N = OURS_NQ + OURS_NV, STEPS = 60 };\n\
        static const double gravity[3] = { 0.3, 0.2, -9.0 }, dt[1] = { 0.01 };\n\
        static const double numbers[] = { SOFT };\n\
        static double controls[STEPS * OURS_NV], moved[2][N], one[STEPS * N], all[STEPS * N];\n\
        int main(void) {\n\
        const ours_step_settings_t *const soft = (const ours_step_settings_t *)numbers;\n\
        ours_step_solution_t next;\n\
        int ground, k, pushed = 0, j;\n\
        for (k = 0; k < STEPS * OURS_NV; ++k) controls[k] = k % 7 * 0.01;\n\
        for (ground = 0; ground < 2; ++ground) {\n\
        double state[N] = { 0 }, start[2][3] = { { 0 } };\n\
        state[0] = 1.2; state[1] = 0.4; state[OURS_NQ] = -0.5;\n\
        memcpy(moved[0], state, sizeof state); memcpy(moved[1], state, sizeof state);\n\
        for (k = 0; k < STEPS; ++k) {\n\
        const double *tau = &controls[k * OURS_NV]; double *s = moved[0];\n\
        if (ground) ours_step_with(s, s + OURS_NQ, tau, dt, start[0], soft, gravity, &next);\n\
        else ours_step_rk4_with(s, s + OURS_NQ, tau, dt, gravity, (ours_step_t *)&next);\n\
        memcpy(s, &next, sizeof moved[0]); memcpy(&one[k * N], &next, sizeof moved[0]);\n\
        if (ground) memcpy(start[0], next.qdd, sizeof next.qdd);\n\
        for (j = 0; ground && j < 3; ++j) pushed += next.forces[0][j] != 0;\n}\n\
        for (k = 0; k < 2; ++k) { double *s = moved[1], *trajectory = k ? all + N * (STEPS / 2) : all;\n\
        const double *tau = &controls[k * OURS_NV * (STEPS / 2)];\n\
        if (ground) ours_rollout(STEPS / 2, tau, dt, soft, gravity, s, s + OURS_NQ, start[1], trajectory);\n\
        else ours_rollout_rk4(STEPS / 2, tau, dt, gravity, s, s + OURS_NQ, trajectory);\n}\n\
        if (memcmp(one, all, sizeof one) || memcmp(moved[0], moved[1], sizeof moved[0]) || memcmp(start[0], start[1], sizeof start[0])) puts(\"differs\");\n}\n\
        if (pushed > 4) puts(\"done\"); else printf(\"%d\\n\", pushed);\nreturn 0;\n}\n";
    std::fs::write(folder.join("main.c"), main.replace("SOFT", &soft)).expect("writes");
    let mut gcc = Command::new("gcc");
    gcc.args(STRICT).args(["-O1", "main.c", "ours.c", "-o", "main", "-lm"]);
    command(gcc.current_dir(&folder));
    assert_eq!(command(&mut Command::new(folder.join("main"))), "done\n");
}
