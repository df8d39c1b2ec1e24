//! Prints rollouts: a thread integrates the motion of one state over many steps, and keeps the
//! state in registers.
//!
//! The programs become functions on a thread's own arrays ([`Storage::Own`]). A kernel for each
//! time step among them calls it in a loop, together with the user's functions.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::constrained::{ConstrainedStep, StepArguments};
use super::{
    Dialect, GpuArgument, GpuKernel, GpuLanguage, Kernel, Storage, dialect, function, head, kernels,
};
use crate::emit::PlannedRobot;
use crate::plan::{CARRIED, Function, PLANNED, Plan, Sizes};

/// The functions of the user in rollouts, as texts in the language of the kernels.
///
/// The texts may call the device function of each function of the robot (`arm_link_pose_hand`),
/// which takes and returns arrays, and define functions of their own. See the guide `docs/gpu.md`
/// for the signatures.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RolloutOptions {
    /// The text of the function `cost`, whose sum over the steps is a result.
    pub cost: Option<String>,
    /// The joint forces as a function of the state and of controls; without it the controls are the
    /// joint forces.
    pub forces: Option<RolloutForces>,
    /// The text of the function `active_contacts`: the contacts that may be active in a step. With it, and
    /// with `constrained_forward_dynamics` and `integrate` among the robot's functions, there is a
    /// kernel of steps that hold these contacts.
    pub active_contacts: Option<String>,
}

/// The user's function `forces` in rollouts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RolloutForces {
    /// The text of the function.
    pub text: String,
    /// The number of controls of a step.
    pub controls: usize,
}

/// A buffer of a rollout's kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RolloutBuffer {
    /// The coordinates of the initial states.
    StartQ,
    /// The velocities of the initial states.
    StartQd,
    /// The states of the actuators in the initial states: the argument `act` of `step_actuated`. The
    /// other kernels do not read it.
    StartAct,
    /// The controls: control `j` of step `k` of rollout `i` of `n` is number
    /// `(k controls + j) n + i`.
    Controls,
    /// The settings of the time step's function, common to all rollouts.
    Settings,
    /// Numbers for the user's functions, common to all rollouts.
    Data,
    /// The run-time parameters, common to all rollouts.
    Parameters,
    /// The final states: the coordinates, then the velocities.
    Out,
    /// The cost of each rollout.
    Costs,
    /// The state after each step, if it is stored: scalar `j` of step `k` of rollout `i` of `n`,
    /// each with `s` scalars, is number `(k s + j) n + i`.
    Trajectory,
}

impl RolloutBuffer {
    /// Returns the name in the text.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::StartQ => "start_q",
            Self::StartQd => "start_qd",
            Self::StartAct => "start_act",
            Self::Controls => "controls",
            Self::Settings => "settings",
            Self::Data => "data",
            Self::Parameters => "params",
            Self::Out => "out",
            Self::Costs => "costs",
            Self::Trajectory => "trajectory",
        }
    }

    /// Returns whether the kernel writes the buffer.
    #[must_use]
    pub fn is_result(self) -> bool {
        matches!(self, Self::Out | Self::Costs | Self::Trajectory)
    }
}

/// The text of a robot's rollouts.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct RolloutSource {
    /// The language.
    pub language: GpuLanguage,
    /// The prefix of all names.
    pub prefix: String,
    /// The text of one file.
    pub text: String,
    /// The kernels, one for each time step, in the order of the text.
    pub rollouts: Vec<GpuRollout>,
    /// The number of coordinates.
    pub nq: usize,
    /// The number of degrees of freedom.
    pub nv: usize,
    /// The number of the states of the actuators; zero without a kernel of `step_actuated`.
    pub activations: usize,
    /// The number of run-time parameters.
    pub parameters: usize,
    /// The buffers of each kernel. In WGSL their bindings in group 0 are counted in this order, and
    /// after them comes a uniform: the numbers of rollouts, steps and initial states, whether the
    /// trajectory is stored (`u32` each), and the time step (`f32`). Rollout `i` starts from
    /// initial state `i` modulo their number.
    pub buffers: Vec<RolloutBuffer>,
}

/// A kernel of rollouts.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct GpuRollout {
    /// The name of the entry point.
    pub name: String,
    /// The name of the function of a time step; `constrained_forward_dynamics` for a semi-implicit
    /// Euler step that closes the loops and holds contacts. `step` starts from the accelerations of
    /// the step before; the first step starts from zeros. `step_actuated` also has the states of the
    /// actuators, which begin with `start_act`, and no applied forces.
    pub step: &'static str,
    /// The number of controls of a step.
    pub controls: usize,
    /// The number of settings of that function, in the order of `ConstraintSettings`, or of
    /// `StepSettings` for `step`; zero for functions without settings.
    pub settings: usize,
    /// The number of statements of a time step, without the statements of the user's functions.
    pub statements: usize,
}

/// A rollout, as dialects print it.
pub(super) struct Rollout<'a> {
    /// The prefix of all names.
    pub prefix: &'a str,
    /// The name of the kernel.
    pub name: &'a str,
    /// The documentation.
    pub docs: &'a str,
    /// The buffers.
    pub buffers: &'a [RolloutBuffer],
}

/// Returns the text of the rollouts of a plan.
pub(in crate::emit) fn print(
    robot: &PlannedRobot<'_>,
    language: GpuLanguage,
    options: &RolloutOptions,
) -> RolloutSource {
    let PlannedRobot { model, plan, .. } = *robot;
    let prefix = &*robot.prefix();
    let dialect = dialect(language, robot.options.scalar, Storage::Own, prefix);
    let mut used = BTreeSet::new();
    let mut functions = String::new();
    let kernels = kernels(plan, model, prefix);
    for kernel in &kernels {
        functions += &function::print(&*dialect, kernel, &mut used);
    }
    let sizes = &plan.sizes;
    let parameters = plan.functions.iter().map(|planned| planned.parameters).max().unwrap_or(0);
    let has_functions =
        options.cost.is_some() || options.forces.is_some() || options.active_contacts.is_some();
    let constrained = constrained_step(&kernels, plan, options);
    let of_table = plan.functions.iter().filter_map(|planned| {
        let kernel = kernels.iter().find(|kernel| kernel.description.function == planned.name)?;
        let step = Step::OfTable { step: &kernel.description, rollout: planned.rollout()? };
        // The user's function returns joint forces.
        let fits = options.forces.is_none() || step.planned().name == "tau";
        fits.then_some(step)
    });
    let steps: Vec<Step<'_>> = of_table.chain(constrained.map(Step::Constrained)).collect();
    let has_settings = steps.iter().any(|step| step.settings() > 0);
    let activations = steps.iter().map(|step| step.len_of("act")).max().unwrap_or(0);
    let optional = [
        (RolloutBuffer::StartQ, true),
        (RolloutBuffer::StartQd, true),
        (RolloutBuffer::StartAct, activations > 0),
        (RolloutBuffer::Controls, true),
        (RolloutBuffer::Settings, has_settings),
        (RolloutBuffer::Data, has_functions),
        (RolloutBuffer::Parameters, parameters > 0),
        (RolloutBuffer::Out, true),
        (RolloutBuffer::Costs, options.cost.is_some()),
        (RolloutBuffer::Trajectory, true),
    ];
    let buffers: Vec<RolloutBuffer> =
        optional.into_iter().filter_map(|(buffer, has)| has.then_some(buffer)).collect();
    let used_buffers = dialect.shared_buffers().iter().filter(|buffer| buffers.contains(buffer));
    let shared: Vec<String> = used_buffers.map(|buffer| dialect.buffer(*buffer)).collect();
    let mut rollouts = Vec::new();
    let mut loops = String::new();
    for step in &steps {
        let name = format!("{prefix}_{}", step.rollout());
        let body = body(&*dialect, step, sizes, options, &shared);
        let rollout = Rollout { prefix, name: &name, docs: &docs(options), buffers: &buffers };
        loops += &dialect.rollout_kernel(&rollout, &body);
        let controls = step.controls(options);
        let settings = step.settings();
        let statements = step.statements();
        let step = step.function().function;
        rollouts.push(GpuRollout { name, step, controls, settings, statements });
    }
    let shared_text = Rollout { prefix, name: "", docs: "", buffers: &buffers };
    let head = head(&*dialect, model, prefix);
    let mut text = head + &dialect.preamble(&used) + &dialect.rollout_head(&shared_text);
    text += &functions;
    let texts = options.forces.iter().map(|forces| &forces.text);
    for user in texts.chain(&options.active_contacts).chain(&options.cost) {
        let _ = write!(text, "{}\n\n", user.trim_end());
    }
    text += &loops;
    let prefix = prefix.into();
    let nq = sizes.nq;
    let nv = sizes.nv;
    RolloutSource { language, prefix, text, rollouts, nq, nv, activations, parameters, buffers }
}

/// The way a kernel computes the state after a time step.
enum Step<'a> {
    /// By a function of the table.
    OfTable { step: &'a GpuKernel, rollout: String },
    /// By a semi-implicit Euler step with constrained accelerations.
    Constrained(ConstrainedStep<'a>),
}

impl<'a> Step<'a> {
    /// Returns the name of the kernel without the robot's.
    fn rollout(&self) -> &str {
        match self {
            Self::OfTable { rollout, .. } => rollout,
            Self::Constrained(_) => "rollout_constrained",
        }
    }

    /// Returns the function whose settings the kernel has.
    fn function(&self) -> &'a GpuKernel {
        match self {
            Self::OfTable { step, .. } => step,
            Self::Constrained(step) => step.dynamics,
        }
    }

    /// Returns the argument that the plan has for each step.
    fn planned(&self) -> &'a GpuArgument {
        let mut arguments = self.function().arguments.iter();
        let is_planned =
            |argument: &&GpuArgument| PLANNED.iter().any(|(name, _)| argument.name == *name);
        arguments.find(is_planned).expect("a time step has forces")
    }

    /// Returns the number of controls of a step.
    fn controls(&self, options: &RolloutOptions) -> usize {
        options.forces.as_ref().map_or(self.planned().len, |forces| forces.controls)
    }

    /// Returns the number of settings.
    fn settings(&self) -> usize {
        let mut arguments = self.function().arguments.iter();
        arguments.find(|argument| is_settings(argument)).map_or(0, |argument| argument.len)
    }

    /// Returns the number of scalars of the argument of this name; zero without it.
    fn len_of(&self, name: &str) -> usize {
        let mut arguments = self.function().arguments.iter();
        arguments.find(|argument| argument.name == name).map_or(0, |argument| argument.len)
    }

    fn statements(&self) -> usize {
        match self {
            Self::OfTable { step, .. } => step.statements,
            Self::Constrained(step) => step.dynamics.statements + step.integrate.statements,
        }
    }
}

fn is_settings(argument: &GpuArgument) -> bool {
    argument.name.ends_with("settings")
}

/// Returns the step that closes the loops and holds contacts, if the robot has its functions, and
/// the user proposes the active contacts where there are some.
fn constrained_step<'a>(
    kernels: &'a [Kernel<'_>],
    plan: &Plan,
    options: &RolloutOptions,
) -> Option<ConstrainedStep<'a>> {
    let kernel_of = |function: Function| {
        let mut all = kernels.iter().map(|kernel| &kernel.description);
        all.find(|kernel| kernel.function == function.name())
    };
    let dynamics = kernel_of(Function::ConstrainedForwardDynamics)?;
    let integrate = kernel_of(Function::Integrate)?;
    let contacts = plan.sizes.contacts;
    let loops = plan.sizes.constraints - contacts;
    let Sizes { nq, nv, .. } = plan.sizes;
    let step = ConstrainedStep { nq, nv, dynamics, integrate, loops, contacts };
    (options.active_contacts.is_some() == (contacts > 0)).then_some(step)
}

/// Returns the documentation of a kernel.
fn docs(options: &RolloutOptions) -> String {
    let mut text = String::from(
        "// Integrates the motion of one state in each thread, over many steps. Rollout i starts \
         from initial state i modulo\n\
         // `starts`. Number j of step k of n rollouts is number (k size + j) n + i of `controls` \
         and of `trajectory`. `out`\n\
         // and the sets of `trajectory` are the coordinates, then the velocities, after a step.\n",
    );
    if options.cost.is_some() {
        text += "// `costs` are the sums of `cost` over the steps.\n";
    }
    text
}

/// Returns the body of a rollout's kernel. `shared` are the buffers that functions receive.
fn body(
    dialect: &dyn Dialect,
    step: &Step<'_>,
    sizes: &Sizes,
    options: &RolloutOptions,
    shared: &[String],
) -> String {
    let Sizes { nq, nv, .. } = *sizes;
    let mut text = String::new();
    let numbers = |buffer: RolloutBuffer, len: usize, place: &dyn Fn(usize) -> String| {
        let buffer = dialect.buffer(buffer);
        (0..len).map(|j| format!("{buffer}[{}]", place(j))).collect::<Vec<String>>()
    };
    let in_step = |size: usize| move |j: usize| format!("(step * {size} + {j}) * n + state");
    let arguments = |names: &[&str]| {
        names
            .iter()
            .map(|name| String::from(*name))
            .chain(shared.iter().cloned())
            .collect::<Vec<_>>()
    };
    let start = |j: usize| format!("{j} * starts + start");
    let states = [
        ("q", RolloutBuffer::StartQ, nq),
        ("qd", RolloutBuffer::StartQd, nv),
        ("act", RolloutBuffer::StartAct, step.len_of("act")),
    ];
    for (name, buffer, len) in states.into_iter().filter(|(.., len)| *len > 0) {
        let _ = writeln!(text, "    {}", dialect.array(name, &numbers(buffer, len, &start)));
    }
    if options.cost.is_some() {
        let _ = writeln!(text, "    {}", dialect.zero("sum"));
    }
    let settings = step.settings();
    if settings > 0 {
        let settings = dialect.shared_array(RolloutBuffer::Settings, settings);
        text.extend(settings.map(|line| format!("    {line}\n")));
    }
    let named = |names: &[&str]| match step {
        Step::OfTable { step, .. } => {
            step.arguments.iter().filter(|argument| names.contains(&&*argument.name)).collect()
        }
        Step::Constrained(_) => Vec::new(),
    };
    let carried: Vec<&GpuArgument> = named(&CARRIED);
    for GpuArgument { name, len, .. } in named(&["applied", "warm_start"]) {
        let zeros = vec![dialect.literal(0.0); *len];
        let _ = writeln!(text, "    {}", dialect.array(name, &zeros));
    }
    let _ = writeln!(text, "    {}", dialect.counting("step", "steps"));
    let mut line = |line: String| {
        let _ = writeln!(text, "        {line}");
    };
    let controls = step.controls(options);
    line(dialect.array("u", &numbers(RolloutBuffer::Controls, controls, &in_step(controls))));
    let forces = if options.forces.is_some() { "tau" } else { "u" };
    if options.forces.is_some() {
        line(dialect.call_into("tau", nv, "forces", &arguments(&["q", "qd", "u", "step"])));
    }
    let parameters = dialect.buffer(RolloutBuffer::Parameters);
    let passed = |function: &GpuKernel| {
        let is_passed = function.arguments.iter().any(|argument| argument.common);
        let passed = shared.iter().filter(|name| is_passed && **name == parameters);
        passed.cloned().collect::<Vec<String>>()
    };
    let state = |j: usize| if j < nq { format!("q[{j}]") } else { format!("qd[{}]", j - nq) };
    match step {
        Step::OfTable { step, .. } => {
            let of_state = step.arguments.iter().filter(|argument| !argument.common);
            let names = of_state.map(|argument| match &*argument.name {
                "tau" => forces.into(),
                "ctrl" => "u".into(),
                _ if is_settings(argument) => RolloutBuffer::Settings.name().into(),
                name => name.into(),
            });
            let of_step: Vec<String> = names.chain(passed(step)).collect();
            line(dialect.call_into("next", step.result, &step.name, &of_step));
            (0..nq + nv).for_each(|j| line(format!("{} = next[{j}];", state(j))));
            let mut first = nq + nv;
            for GpuArgument { name, len, .. } in &carried {
                (0..*len).for_each(|j| line(format!("{name}[{j}] = next[{}];", first + j)));
                first += len;
            }
        }
        Step::Constrained(step) => {
            let user = arguments(&["q", "qd", "u", "step"]);
            let passed = passed(step.dynamics);
            let arguments = StepArguments { forces, user: &user, parameters: &passed };
            step.lines(dialect, &arguments).into_iter().for_each(&mut line);
        }
    }
    if options.cost.is_some() {
        line(format!("sum += cost({});", arguments(&["q", "qd", "u", "step"]).join(", ")));
    }
    line(format!("if ({}) {{", dialect.is_recorded()));
    let places = numbers(RolloutBuffer::Trajectory, nq + nv, &in_step(nq + nv));
    for (j, place) in places.iter().enumerate() {
        line(format!("    {place} = {};", state(j)));
    }
    line("}".into());
    text += "    }\n";
    let places = numbers(RolloutBuffer::Out, nq + nv, &|j| format!("{j} * n + state"));
    for (j, place) in places.iter().enumerate() {
        let _ = writeln!(text, "    {place} = {};", state(j));
    }
    if options.cost.is_some() {
        let _ = writeln!(text, "    {}[state] = sum;", dialect.buffer(RolloutBuffer::Costs));
    }
    text
}
