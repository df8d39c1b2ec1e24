//! Functions of closed loops on nalgebra's vectors are those on arrays.

use modyn::{ConstraintSettings, Nalgebra, Robot};
use nalgebra::SVector;

modyn::modyn!(
    "../../../robots/four_bar.urdf",
    functions = [constrained_forward_dynamics, constraint_residual, project_constraints],
);

type Vectors = Nalgebra<FourBar>;

#[test]
fn nalgebra_calls_of_closed_loops_are_the_array_calls() {
    let (q, qd, tau) = ([0.3, 1.2, 2.0], [1.0, -2.0, 0.5], [0.2, 0.0, -0.1]);
    let settings = ConstraintSettings::<f64>::DEFAULT;
    let [q_vector, qd_vector, tau_vector] = [q, qd, tau].map(SVector::from);

    let expected = <FourBar as Robot>::constrained_forward_dynamics(&q, &qd, &tau, (), &settings);
    let found =
        Vectors::constrained_forward_dynamics(&q_vector, &qd_vector, &tau_vector, (), &settings);
    assert!(expected.qdd.iter().all(|x| x.abs() > 1e-3), "{:?}", expected.qdd);
    assert_eq!((found.qdd.as_slice(), found.wrenches), (&expected.qdd[..], expected.wrenches));
    assert_eq!((found.residuals, found.rank), (expected.residuals, expected.rank));

    let expected = <FourBar as Robot>::constraint_residual(&q, &qd, &settings);
    assert_eq!(Vectors::constraint_residual(&q_vector, &qd_vector, &settings), expected);

    let expected = <FourBar as Robot>::project_constraints(&q, &qd, (), &settings);
    let found = Vectors::project_constraints(&q_vector, &qd_vector, (), &settings);
    assert!(expected.step_q.iter().any(|x| x.abs() > 1e-3), "{:?}", expected.step_q);
    assert_eq!(found.step_q.as_slice(), expected.step_q);
    assert_eq!((found.step_qd.as_slice(), found.rank), (&expected.step_qd[..], expected.rank));
}
