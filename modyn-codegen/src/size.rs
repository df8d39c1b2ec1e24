//! The estimated size of a robot's text, computed before the text is made.

use modyn_runtime::model::{Model, ModuleTree};

use crate::diagnostics::{Code, Diagnostic};
use crate::plan::{Function, MAX_OWN_FUNCTIONS};

/// The largest number of bytes of generated text, by [`estimate`].
pub const MAX_BYTES: f64 = 32e6;

/// The properties of a robot that the sizes of its functions depend on. A joint of several degrees of freedom counts as
/// several joints in part.
struct Measures {
    /// The number of moving links.
    links: f64,
    /// The number of moving links with a moving parent. Links on the world have hardly any dynamics.
    carried: f64,
    /// The sum over the moving links of their numbers of ancestors.
    depths: f64,
    /// The sum of the squares of these numbers.
    squares: f64,
    /// The number of entries of the mass matrix.
    entries: f64,
    /// The sum over the modules of the cubes of their degrees of freedom.
    pivots: f64,
    /// The number of links of the description.
    frames: f64,
    /// The number of functions of one link: own functions, and functions that links share.
    kernels: f64,
    /// The sum over these functions of the link's number of ancestors.
    chains: f64,
    /// The number of links that share a function.
    rows: f64,
    /// The number of degrees of freedom.
    nv: f64,
    /// The number of floating joints.
    bases: f64,
    /// The number of constraint rows.
    constraint_rows: f64,
    /// The sum over the frames of constraints of the numbers of ancestors of their links.
    reach: f64,
    /// The sum over the rows of constraints of the numbers of ancestors of their links.
    row_reach: f64,
}

impl Measures {
    #[allow(clippy::cast_precision_loss)]
    fn new(model: &Model, modules: &ModuleTree) -> Self {
        let weights =
            model.links().iter().map(|link| 0.75 + 0.25 * link.joint.joint_type.nv() as f64);
        let weights: Vec<f64> = weights.collect();
        let mut depths: Vec<f64> = Vec::with_capacity(weights.len());
        for (link, weight) in model.links().iter().zip(&weights) {
            // Parents come before their children.
            depths.push(weight + link.parent.map_or(0.0, |parent| depths[parent]));
        }
        let carried = model.links().iter().zip(&weights).filter(|(link, _)| link.parent.is_some());
        let mut on_body = vec![0_usize; weights.len() + 1];
        for frame in model.frames() {
            on_body[frame.link.map_or(weights.len(), |link| link)] += 1;
        }
        let kernels = |frames: usize| frames.min(MAX_OWN_FUNCTIONS + 1) as f64;
        let pivot = |module: &modyn_runtime::model::Module| {
            let dofs = model.links()[module.links.clone()].iter().map(|l| l.joint.joint_type.nv());
            (dofs.sum::<usize>() as f64).powi(3)
        };
        let depth = |frame: usize| model.frames()[frame].link.map_or(0.0, |link| depths[link]);
        let loops = model.loop_constraints().iter().map(|constraint| {
            let [first, second] = &constraint.ends;
            (constraint.kind.rows() as f64, depth(first.frame) + depth(second.frame))
        });
        let contacts = model.contacts().iter();
        let contacts = contacts.map(|c| (c.kind.rows() as f64, depth(c.end.frame)));
        let constraints: Vec<(f64, f64)> = loops.chain(contacts).collect();
        Self {
            links: weights.iter().sum(),
            carried: carried.map(|(_, weight)| weight).sum(),
            depths: depths.iter().zip(&weights).map(|(depth, weight)| depth * weight).sum(),
            squares: depths
                .iter()
                .zip(&weights)
                .map(|(depth, weight)| depth * depth * weight)
                .sum(),
            entries: (model.nv() as f64).powi(2),
            pivots: modules.modules().iter().map(pivot).sum(),
            frames: model.frames().len() as f64,
            kernels: on_body.iter().map(|&frames| kernels(frames)).sum(),
            chains: on_body
                .iter()
                .zip(&depths)
                .map(|(&frames, depth)| kernels(frames) * depth)
                .sum(),
            rows: on_body.iter().map(|&n| n.saturating_sub(MAX_OWN_FUNCTIONS) as f64).sum(),
            nv: model.nv() as f64,
            bases: model.links().iter().filter(|link| link.joint.joint_type.nv() == 6).count()
                as f64,
            constraint_rows: model.constraint_rows() as f64,
            reach: constraints.iter().map(|(_, depth)| depth).sum(),
            row_reach: constraints.iter().map(|(rows, depth)| rows * depth).sum(),
        }
    }

    /// Returns the estimated size of a function in bytes. The factors were fitted to chains and trees of 6 to 48 joints in
    /// general position.
    fn bytes(&self, function: Function) -> f64 {
        let &Self { links, carried, depths, squares, entries, pivots, nv, .. } = self;
        let &Self { frames, kernels, chains, rows, .. } = self;
        let &Self { bases, constraint_rows, reach, row_reach, .. } = self;
        let factors = 1000.0 * depths + 130.0 * squares + 40.0 * entries + 25.0 * pivots;
        // A function of one link: its operations, its results, and the calls for links that share it.
        let of_link = |step: f64, results: f64| step * chains + results * kernels + 250.0 * rows;
        let wrenches = 1500.0 * frames;
        match function.batched().unwrap_or(function) {
            Function::ForwardDynamics => 14_000.0 * carried + 600.0 * links,
            Function::InverseDynamics | Function::BiasForces => 8000.0 * carried + 600.0 * links,
            Function::GravityTorques => 900.0 * links,
            Function::MassMatrix => 1400.0 * depths + 10.0 * entries,
            Function::CoriolisMatrix => 3000.0 * (depths + carried) + 60.0 * entries,
            Function::Brge => factors,
            Function::KineticEnergy => 1800.0 * carried + 100.0 * links,
            Function::PotentialEnergy => 500.0 * links,
            Function::ForwardDynamicsExternal | Function::ForwardDynamicsExternalWorld => {
                14_000.0 * carried + wrenches
            }
            Function::InverseDynamicsExternal | Function::InverseDynamicsExternalWorld => {
                6000.0 * carried + wrenches
            }
            Function::GeneralizedForces => 900.0 * depths + 60.0 * entries + wrenches,
            Function::GeneralizedForcesWorld => {
                1500.0 * depths + 2000.0 * links + 60.0 * entries + wrenches
            }
            Function::InverseDynamicsDerivatives => 5000.0 * (depths + carried) + 100.0 * entries,
            Function::ForwardDynamicsDerivatives => {
                5000.0 * depths + 600.0 * squares + 100.0 * entries
            }
            Function::ConstrainedForwardDynamics => {
                1200.0 * depths
                    + 70.0 * squares
                    + 30.0 * entries
                    + 850.0 * reach
                    + 2200.0 * row_reach
                    + 15.0 * constraint_rows.powi(2) * nv
                    + 60.0 * constraint_rows.powi(3)
            }
            Function::ProjectConstraints | Function::ContactImpulse => {
                140.0 * squares
                    + 850.0 * reach
                    + 1800.0 * row_reach
                    + 35.0 * constraint_rows.powi(2) * nv
                    + 50.0 * constraint_rows.powi(3)
            }
            Function::OperationalInertia => {
                140.0 * squares
                    + 950.0 * reach
                    + 1200.0 * row_reach
                    + 55.0 * constraint_rows.powi(2) * nv
                    + 170.0 * constraint_rows.powi(3)
            }
            Function::ConstrainedForwardDynamicsDerivatives => {
                1400.0 * depths
                    + 800.0 * squares
                    + 90.0 * nv.powi(3)
                    + 9000.0 * reach
                    + 5000.0 * row_reach
                    + 120.0 * constraint_rows * entries
                    + 500.0 * constraint_rows.powi(2) * nv
            }
            Function::ConstrainedInverseDynamics => {
                3300.0 * carried + 57_000.0 * bases.powi(2) + 300.0 * reach + 150.0 * row_reach
            }
            Function::ConstraintJacobian => 1200.0 * reach + 45.0 * row_reach,
            Function::ConstraintBiasAcceleration => 800.0 * reach + 50.0 * row_reach,
            Function::ConstraintResidual => 400.0 * reach + 300.0 * row_reach,
            Function::Regressor => 2200.0 * depths + 120.0 * squares + 60.0 * entries,
            Function::CenterOfMass => 600.0 * links,
            Function::CenterOfMassJacobian => 1200.0 * links,
            Function::CentroidalMomentumMatrix => 4000.0 * links,
            Function::CentroidalMomentum => 3200.0 * links,
            Function::LinkPoses => 1500.0 * (links + frames - rows) + 250.0 * rows,
            Function::LinkPose => of_link(1400.0, 600.0),
            Function::LinkVelocity | Function::LocalLinkVelocity => of_link(1300.0, 300.0),
            Function::LinkAcceleration | Function::LocalLinkAcceleration => of_link(2100.0, 300.0),
            Function::Jacobian | Function::LocalJacobian => of_link(1600.0, 150.0 * nv),
            Function::JacobianTimeDerivative | Function::LocalJacobianTimeDerivative => {
                of_link(4500.0, 150.0 * nv)
            }
            Function::BiasAcceleration | Function::LocalBiasAcceleration => of_link(1900.0, 300.0),
            Function::InverseDynamicsVjp | Function::InverseDynamicsJvp => {
                24_000.0 * carried + 1800.0 * links
            }
            Function::ForwardDynamicsVjp | Function::ForwardDynamicsJvp => {
                40_000.0 * carried + 3000.0 * links
            }
            Function::StepSemiImplicit => 14_000.0 * carried + 800.0 * links,
            Function::StepRk4 => 56_000.0 * carried + 3200.0 * links,
            Function::StepSemiImplicitDerivatives => {
                5000.0 * depths + 600.0 * squares + 350.0 * entries
            }
            Function::IntegrateDerivatives | Function::DifferenceDerivatives => {
                100.0 * links + 30.0 * nv.powi(2)
            }
            Function::Random => 200.0 * links,
            _ => 100.0 * links,
        }
    }
}

/// Returns the estimated size of a robot's text in bytes, and the sizes of its functions, the largest first.
pub fn estimate(
    model: &Model,
    modules: &ModuleTree,
    functions: &[Function],
) -> (f64, Vec<(Function, f64)>) {
    let measures = Measures::new(model, modules);
    let selected = functions.iter().filter(|f| f.fits(model.constraints(), model.contacts().len()));
    let mut sizes: Vec<_> = selected.map(|&f| (f, measures.bytes(f))).collect();
    sizes.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    // Enums, names and tables have a line or two for each joint and link.
    let tables = 15_000.0 + 500.0 * measures.links + 600.0 * measures.frames;
    (tables + sizes.iter().map(|(_, bytes)| bytes).sum::<f64>(), sizes)
}

/// Returns an error if the text of this robot would be too large.
pub fn too_large(
    model: &Model,
    modules: &ModuleTree,
    functions: &[Function],
) -> Option<Diagnostic> {
    let (bytes, sizes) = estimate(model, modules, functions);
    if bytes <= MAX_BYTES {
        return None;
    }
    let megabytes = |bytes: f64| format!("{:.0} MB", bytes / 1e6);
    let largest = sizes.iter().take(3).filter(|(_, bytes)| *bytes > MAX_BYTES / 10.0);
    let largest: Vec<String> =
        largest.map(|(f, bytes)| format!("`{}` {}", f.name(), megabytes(*bytes))).collect();
    let largest =
        if largest.is_empty() { String::new() } else { format!(" ({})", largest.join(", ")) };
    let longest = modules.modules().iter().map(|module| &module.links).max_by_key(|l| l.len())?;
    let message = format!(
        "code for {} moving joints and {} links would be about {} of text{largest}, more than {}; the \
         longest module has {} links, from `{}` to `{}`",
        model.links().len(),
        model.frames().len(),
        megabytes(bytes),
        megabytes(MAX_BYTES),
        longest.len(),
        model.links()[longest.start].name,
        model.links()[longest.end - 1].name,
    );
    let by_links = ModuleTree::links(model);
    // As few functions as necessary, the largest first.
    let mut rest = bytes;
    let dropped = sizes.iter().take_while(|(_, bytes)| {
        let needed = rest > MAX_BYTES;
        rest -= bytes;
        needed
    });
    let dropped: Vec<String> =
        dropped.map(|(function, _)| format!("`{}`", function.name())).collect();
    let help = if estimate(model, &by_links, functions).0 <= MAX_BYTES {
        "divide it: `modules = links`; or use `modyn::Interpreter`, which has no such limit".into()
    } else if rest <= MAX_BYTES && dropped.len() <= 4 {
        format!(
            "leave {} out of the option `functions`; or use `modyn::Interpreter`, which has no such limit",
            dropped.join(", ")
        )
    } else {
        "use `modyn::Interpreter`, which has no such limit, or select fewer functions, or remove links that \
         nothing needs"
            .into()
    };
    Some(Diagnostic::error(Code::TooLarge, message).with_help(help))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Base, Builder, Contact, ContactKind, LoopEnd};

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
            &[Function::LinkPose, Function::Jacobian],
            &[Function::LinkPoses],
            &[Function::ForwardDynamicsExternal],
            &[],
        ];
        let made = [chain(12, 0), chain(3, 100), chain(10, 20)];
        for (i, urdf) in robots.into_iter().chain(made).enumerate() {
            for functions in lists {
                let builder = Builder::new().urdf_text(&*urdf, "robot.urdf");
                let builder = builder.functions(functions.iter().copied());
                let generated = builder.generate().expect("good");
                let (model, length) = (&generated.model, generated.text.len() as f64);
                let (bytes, _) = estimate(model, &ModuleTree::chains(model), functions);
                let ratio = bytes / length;
                println!("{i} {} functions: {length} bytes, estimated {ratio:.2}", functions.len());
                assert!((0.5..6.0).contains(&ratio), "{i}: {bytes} instead of {length}");
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
            (quadruped.clone(), Base::Floating, vec!["hind_left_foot"], ContactKind::Point),
            (quadruped, Base::Floating, vec!["hind_left_foot", "trunk"], ContactKind::Surface),
        ];
        for (i, (urdf, base, links, kind)) in robots.into_iter().enumerate() {
            let contact = |link: &&str| {
                let end =
                    LoopEnd { link: (*link).into(), xyz: [0.1, 0.2, -0.3], rpy: [0.1, 0.2, 0.3] };
                Contact { name: format!("on {link}"), kind, end }
            };
            let builder = Builder::new().urdf_text(urdf, "robot.urdf").base(base);
            let builder = builder.contacts(links.iter().map(contact));
            for function in Function::ALL.iter().filter(|function| function.is_of_constraints()) {
                let generated = builder.clone().functions([*function]).generate().expect("good");
                let (model, length) = (&generated.model, generated.text.len() as f64);
                let (bytes, _) = estimate(model, &ModuleTree::chains(model), &[*function]);
                let ratio = bytes / length;
                println!("{i} {}: {length} bytes, estimated {ratio:.2}", function.name());
                assert!(
                    (0.5..2.0).contains(&ratio),
                    "{i} {function:?}: {bytes} instead of {length}"
                );
            }
        }
    }
}
