//! No call panics, for any sizes, indices, numbers and models: it returns an error or a result.
#![cfg(feature = "alloc")]

use modyn_runtime::equations::constraints::{
    ConstrainedOutputs, ProjectionOutputs, ResidualOutputs,
};
use modyn_runtime::equations::derivatives::CentroidalOutputs;
use modyn_runtime::equations::identification::BaseParameters;
use modyn_runtime::equations::{ForwardInput, Motion, State};
use modyn_runtime::joint::JointType;
use modyn_runtime::model::{
    Joint, JointDynamics, JointFriction, Limits, Link, LoopConstraint, LoopConstraintEnd,
    LoopConstraintKind, Mimic, Model, ModuleTree, MovingLink,
};
use modyn_runtime::spatial::{Momentum, Twist, Vector3, Wrench};
use modyn_runtime::{
    ConstraintSettings, Forces, ForwardDerivatives, Inertial, Interpreter, Pose, conventions,
};

/// A source of pseudo-random small numbers.
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        usize::try_from(self.0 >> 40).unwrap_or(0) % n
    }

    /// Returns mostly ordinary numbers, and sometimes NaN, infinities and extreme ones.
    fn number(&mut self) -> f64 {
        const ODD: [f64; 8] = [
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            0.0,
            -0.0,
            1e300,
            -1e-300,
            f64::MIN_POSITIVE,
        ];
        match self.below(40) {
            0 => ODD[self.below(ODD.len())],
            _ => self.below(2000) as f64 / 1000.0 - 1.0,
        }
    }

    fn numbers<const N: usize>(&mut self) -> [f64; N] {
        std::array::from_fn(|_| self.number())
    }

    /// Returns an index that is mostly below `n`.
    fn index(&mut self, n: usize) -> usize {
        match self.below(20) {
            0 => usize::MAX,
            1 => n,
            _ => self.below(n.max(1)),
        }
    }

    fn axis(&mut self) -> [f64; 3] {
        const AXES: [[f64; 3]; 4] =
            [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.6, 0.0, 0.8], [0.0, 0.6, -0.8]];
        match self.below(20) {
            0 => self.numbers(),
            _ => AXES[self.below(4)],
        }
    }

    fn pose(&mut self) -> Pose<f64> {
        let rotation = match self.below(20) {
            0 => [self.numbers(), self.numbers(), self.numbers()],
            _ => conventions::rotation_from_quaternion([0.5, -0.5, 0.5, 0.5]),
        };
        Pose { rotation, translation: self.numbers() }
    }

    fn inertial(&mut self) -> Inertial {
        match self.below(4) {
            0 => Inertial::default(),
            1 => Inertial {
                mass: self.number(),
                center_of_mass: self.numbers(),
                inertia: self.numbers(),
            },
            _ => Inertial {
                mass: 1.0,
                center_of_mass: self.numbers(),
                inertia: [0.2, 0.0, 0.0, 0.3, 0.0, 0.25],
            },
        }
    }

    fn joint(&mut self, name: String, links: usize) -> Joint {
        let joint_type = JointType::ALL[self.below(JointType::ALL.len())];
        let mut joint = Joint::new(name, joint_type, self.axis(), self.pose());
        joint.second_axis = self.axis();
        if self.below(3) == 0 {
            let [lower, upper, velocity, effort] = self.numbers().map(Some);
            joint.limits = Some(Limits { lower, upper, velocity, effort });
        }
        if self.below(6) == 0 {
            let [multiplier, offset] = self.numbers();
            joint.mimic = Some(Mimic { leader: self.index(links), multiplier, offset });
        }
        if self.below(4) == 0 {
            let [armature, damping, friction] = self.numbers().map(f64::abs);
            joint.dynamics = JointDynamics { armature, damping, friction };
        }
        joint
    }

    /// Returns a model from parts that may be invalid.
    fn model(&mut self) -> Option<Model> {
        let count = self.below(7);
        let links: Vec<MovingLink> = (0..count)
            .map(|i| MovingLink {
                name: format!("link{}", if self.below(40) == 0 { 0 } else { i }),
                parent: match self.below(12) {
                    0 => Some(self.index(count)),
                    1 => None,
                    _ => i.checked_sub(1),
                },
                joint: self.joint(format!("joint{i}"), count),
                inertial: self.inertial(),
            })
            .collect();
        let frames = (0..self.below(9)).map(|i| Link {
            name: format!("frame{i}"),
            moving_link: (self.below(4) > 0).then(|| self.index(count)),
            pose: self.pose(),
            inertial: self.inertial(),
        });
        let frames: Vec<Link> = frames.collect();
        let ends = frames.len();
        let mut model = Model::new("model", [0.0, 0.0, -9.81], links, frames).ok()?;
        let gravity = self.numbers();
        if let Ok(other) = model.clone().with_gravity(gravity) {
            model = other;
        }
        let friction = [
            JointFriction::None,
            JointFriction::Viscous,
            JointFriction::Coulomb,
            JointFriction::Smooth(self.number()),
        ];
        if let Ok(other) = model.clone().with_joint_friction(friction[self.below(4)]) {
            model = other;
        }
        let closures = (0..self.below(3)).map(|i| {
            let mut end = || LoopConstraintEnd { link: self.index(ends), pose: self.pose() };
            let ends = [end(), end()];
            let axis = self.axis();
            let kinds = [
                LoopConstraintKind::Point,
                LoopConstraintKind::Rigid,
                LoopConstraintKind::Revolute(axis),
                LoopConstraintKind::Prismatic(axis),
            ];
            LoopConstraint { name: format!("loop{i}"), kind: kinds[self.below(4)], ends }
        });
        let closures = closures.collect();
        Some(model.clone().with_loop_constraints(closures).unwrap_or(model))
    }
}

/// Calls every method with slices of right and wrong sizes; the results are ignored.
fn call(interpreter: &mut Interpreter<f64>, dice: &mut Dice) {
    let model = interpreter.model().clone();
    let (nq, nv, frames) = (model.nq(), model.nv(), model.links().len());
    // One slice in four has a wrong size.
    let sizes: Vec<usize> = (0..64).map(|_| [0, 0, 0, 0, 0, 0, 1, 7][dice.below(8)]).collect();
    let mut next = sizes.into_iter().cycle();
    let mut size = |n: usize| match next.next() {
        Some(1) => n + 1,
        Some(7) => n.saturating_sub(1),
        _ => n,
    };
    let mut vector = |n: usize| -> Vec<f64> { (0..size(n)).map(|_| dice.number()).collect() };
    for _ in 0..6 {
        let (q, other) = (vector(nq), vector(nq));
        let [qd, qdd, tau] = [(); 3].map(|()| vector(nv));
        let mut a = vector(nv);
        let mut b = vector(nv);
        let [mut c, mut d, mut e] = [(); 3].map(|()| vector(nv * nv));
        let mut moved = vector(nq);
        let mut regressor = vector(nv * 10 * model.moving_links().len());
        let wrench = |x: f64| Wrench { moment: Vector3([x; 3]), force: Vector3([1.0, x, -x]) };
        let wrenches: Vec<Wrench<f64>> = vector(frames).into_iter().map(wrench).collect();
        let mut poses = vec![Pose::identity(); vector(frames).len()];
        let mut twists = vec![Twist::zero(); vector(nv).len()];
        let loops = model.loop_constraints().len();
        let mut loop_wrenches = vec![Wrench::zero(); vector(loops).len()];
        let mut displacements = vec![Twist::zero(); vector(loops).len()];
        let mut velocities = vec![Twist::zero(); vector(loops).len()];
        let mut points = vec![Vector3::zero(); vector(nv).len()];
        let frame = match vector(3).len() {
            2 => usize::MAX,
            4 => frames,
            n => n % frames.max(1),
        };
        let r = &mut *interpreter;
        r.forward_dynamics(&q, &qd, &tau, &mut a).ok();
        r.inverse_dynamics(&q, &qd, &qdd, &mut b).ok();
        r.bias_forces(&q, &qd, &mut a).ok();
        r.gravity_torques(&q, &mut b).ok();
        r.mass_matrix(&q, &mut c).ok();
        for forces in [Forces::InLinkAxes(&wrenches), Forces::InWorldAxes(&wrenches)] {
            r.forward_dynamics_external(&q, &qd, &tau, forces, &mut a).ok();
            r.inverse_dynamics_external(&q, &qd, &qdd, forces, &mut b).ok();
        }
        r.kinetic_energy(&q, &qd).ok();
        r.potential_energy(&q).ok();
        let settings = ConstraintSettings::<f64>::DEFAULT;
        let input = ForwardInput { q: &q, qd: &qd, tau: &tau };
        let state = State { q: &q, qd: &qd };
        let motion = Motion { q: &q, qd: &qd, qdd: &qdd };
        let outputs = ConstrainedOutputs {
            qdd: &mut a,
            wrenches: &mut loop_wrenches,
            residuals: &mut displacements,
        };
        r.constrained_forward_dynamics(input, &[], &settings, outputs).ok();
        let outputs =
            ResidualOutputs { displacements: &mut displacements, velocities: &mut velocities };
        r.constraint_residual(state, &settings, outputs).ok();
        let outputs = ProjectionOutputs { step_q: &mut a, step_qd: &mut b };
        r.project_constraints(state, &[], &settings, outputs).ok();
        r.inverse_dynamics_derivatives(&q, &qd, &qdd, &mut c, &mut d).ok();
        let outputs = ForwardDerivatives {
            qdd: &mut a,
            dqdd_dq: &mut c,
            dqdd_dqd: &mut d,
            dqdd_dtau: &mut e,
        };
        r.forward_dynamics_derivatives(&q, &qd, &tau, outputs).ok();
        r.regressor(&q, &qd, &qdd, &mut regressor).ok();
        r.link_poses(&q, &mut poses).ok();
        r.link_pose(&q, frame).ok();
        r.link_velocity(&q, &qd, frame).ok();
        r.link_velocity_local(&q, &qd, frame).ok();
        r.link_acceleration(&q, &qd, &qdd, frame).ok();
        r.link_acceleration_local(&q, &qd, &qdd, frame).ok();
        r.jacobian(&q, frame, &mut twists).ok();
        r.jacobian_local(&q, frame, &mut twists).ok();
        r.jacobian_dot_qd(&q, &qd, frame).ok();
        r.jacobian_dot_qd_local(&q, &qd, frame).ok();
        r.center_of_mass(&q).ok();
        r.center_of_mass_jacobian(&q, &mut points).ok();
        r.centroidal_momentum(&q, &qd).ok();
        r.centroidal_momentum_rate(motion).ok();
        let (mut values, mut columns) =
            ([Momentum::zero(); 2], [0; 3].map(|_| vec![Momentum::zero(); qd.len()]));
        let ([momentum, rate], [dmomentum_dq, drate_dq, drate_dqd]) = (&mut values, &mut columns);
        let outputs = CentroidalOutputs { momentum, rate, dmomentum_dq, drate_dq, drate_dqd };
        r.centroidal_momentum_derivatives(motion, outputs).ok();
        r.integrate(&q, &qd, &mut moved).ok();
        r.difference(&q, &other, &mut a).ok();
        r.velocity_to_qdot(&q, &qd, &mut moved).ok();
        r.normalize_configuration(&mut moved).ok();
        r.neutral(&mut moved).ok();
        r.random_configuration(|| 0.7, &mut moved).ok();
        r.check_configuration(&q).ok();
        r.denoc(&q).ok();
        r.decomposition(&q).ok();
        if let Ok(mut brge) = r.brge(&q) {
            brge.solve(&tau).ok();
            brge.solve_in_place(&mut a).ok();
            let matrices = [brge.u(), brge.d(), brge.u_inverse(), brge.d_inverse(), brge.inverse()];
            assert!(matrices.iter().all(|matrix| matrix.len() == nv * nv));
            let _ = brge.log_determinant();
            for module in [0, 1, frame, usize::MAX] {
                assert_eq!(
                    brge.pivot_block(module).is_some(),
                    brge.condition_number(module).is_some()
                );
            }
            brge.update(r, &other).ok();
        }
    }
    for _ in 0..8 {
        let (frame, inertial) = (dice.index(frames), dice.inertial());
        interpreter.set_inertial(frame, &inertial).ok();
        interpreter.set_payload(frame, &dice.inertial()).ok();
        interpreter.set_gravity(dice.numbers());
    }
}

#[test]
fn no_argument_makes_it_panic() {
    let mut before: Vec<Interpreter<f64>> = Vec::new();
    let mut sound = 0;
    for seed in 0..1500 {
        let mut dice = Dice(seed);
        let Some(model) = dice.model() else { continue };
        sound += 1;
        for link in [0, 1, model.moving_links().len(), usize::MAX] {
            assert!(model.q_range(link).len() >= model.v_range(link).len());
            assert_eq!(
                model.inertial_parameters(link).is_some(),
                link < model.moving_links().len()
            );
            assert!(link < model.moving_links().len() || model.mimic(link).is_none());
        }
        let list: Vec<Vec<String>> = (0..dice.below(4))
            .map(|_| (0..dice.below(4)).map(|_| format!("link{}", dice.below(8))).collect())
            .collect();
        ModuleTree::from_names(&model, &list).ok();
        if seed % 10 == 0 {
            let base = BaseParameters::new(&model);
            assert_eq!(base.values(&model).len(), base.regressor_columns().len());
        }
        let trees = [ModuleTree::links(&model), ModuleTree::chains(&model)];
        let mut interpreter =
            Interpreter::with_modules(model, trees[dice.below(2)].clone()).expect("its own");
        // Factorizations and module trees of other robots.
        let q = vec![0.3; interpreter.model().nq()];
        let mut brge = interpreter.brge(&q).expect("the length");
        for other in &before {
            let q = vec![0.3; other.model().nq()];
            brge.update(other, &q).ok();
            let foreign = Interpreter::<f64>::with_modules(other.model().clone(), trees[0].clone());
            foreign.and_then(|other| other.eliminating_by(&trees[1])).ok();
        }
        call(&mut interpreter, &mut dice);
        before.push(interpreter);
        if before.len() > 12 {
            before.remove(dice.below(12));
        }
    }
    assert!(sound > 100, "only {sound} models were sound");
}
