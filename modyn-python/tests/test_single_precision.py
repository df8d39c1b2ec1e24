"""Robots in single precision: arrays of float32, against double precision within bounds that the conditioning gives."""

import copy
import gc
import pickle
import tracemalloc

import numpy as np
import pytest
from conftest import GOLDEN, ROBOTS, chain, close, states

import modyn

EPSILON = np.finfo(np.float32).eps

FEET = {name: ("point", link) for name, link in (("left", "FL_FOOT"), ("right", "HR_FOOT"))}


def both(load, source, **options):
    """Returns a robot in double and in single precision."""
    return load(source, **options), load(source, scalar="f32", **options)


def single_states(robot, n, seed=0):
    """Returns n random states that both precisions have."""
    return [x.astype(np.float32) for x in states(robot, n, seed)]


def flat(result):
    """Returns the arrays of a result."""
    if not isinstance(result, tuple):
        return [result]
    return [array for field in result for array in flat(field)]


@pytest.mark.parametrize(
    "source, options",
    [
        (GOLDEN / "panda.urdf", {}),
        (GOLDEN / "solo12.urdf", {"base": "floating"}),
        (chain(3), {"base": "floating"}),
        (chain(8, joints=9, branches=3), {}),
    ],
)
def test_against_double_precision(source, options):
    load = modyn.loads if isinstance(source, str) else modyn.load
    if load is modyn.load:
        options = {"joint_friction": "none", **options}
    double, single = both(load, source, **options)
    n = 20
    q, qd, qdd, tau = single_states(double, n, seed=5)
    exact = [x.astype(float) for x in (q, qd, qdd, tau)]
    mass = double.mass_matrix(exact[0])
    bias = double.bias_forces(exact[0], exact[1])
    unit = 16 * EPSILON
    # The rounding of a sum is relative to its terms.
    terms = np.einsum("nij,nj->ni", np.abs(mass), np.abs(exact[2])) + np.abs(bias)
    error = single.inverse_dynamics(q, qd, qdd) - double.inverse_dynamics(*exact[:3])
    assert (np.abs(error) <= unit * terms.max(axis=1, keepdims=True)).all() and error.any()
    found = single.mass_matrix(q)
    assert found.dtype == np.float32 and found.shape == mass.shape
    assert (np.abs(found - mass) <= unit * np.abs(mass).max(axis=(1, 2), keepdims=True)).all()
    # Forward dynamics: the inverse of the mass matrix amplifies the rounding of the forces (Higham 2002, sect. 7.2).
    expected = double.forward_dynamics(exact[0], exact[1], exact[3])
    terms = np.einsum("nij,nj->ni", np.abs(mass), np.abs(expected)) + np.abs(bias) + np.abs(exact[3])
    bound = unit * np.einsum("nij,nj->ni", np.abs(np.linalg.inv(mass)), terms)
    assert (np.abs(single.forward_dynamics(q, qd, tau) - expected) <= bound).all()
    # One state has other instructions than many, with the same bound.
    for i in range(n):
        one = single.forward_dynamics(q[i], qd[i], tau[i])
        assert one.dtype == np.float32 and (np.abs(one - expected[i]) <= bound[i]).all()
    link = double.link_names[-1]
    pose, expected = single.link_pose(q, link), double.link_pose(exact[0], link)
    close(pose.rotation, expected.rotation, unit)
    close(pose.translation, expected.translation, unit)
    close(single.jacobian(q, link), double.jacobian(exact[0], link), unit)


def test_all_results_are_single_precision():
    """Functions with all forms of results, for one state and for many."""
    double, single = both(modyn.load, GOLDEN / "panda.urdf", joint_friction="none")
    assert double.dtype == np.float64 and single.dtype == np.float32
    assert double.neutral().dtype == np.float64 and single.neutral().dtype == np.float32
    q, qd, qdd, tau = single_states(double, 5)
    forces = np.ones((5, len(double.link_names), 6), np.float32)
    calls = {
        "link_poses": (q,),
        "forward_dynamics_derivatives": (q, qd, tau),
        "inverse_dynamics_vjp": (q, qd, qdd, tau),
        "regressor": (q, qd, qdd),
        "generalized_forces_local": (q, forces),
        "step_rk4": (q, qd, tau, np.full(5, 0.01, np.float32)),
        "kinetic_energy": (q, qd),
    }
    for name, arguments in calls.items():
        many = getattr(single, name)(*arguments)
        one = getattr(single, name)(*(x[2] for x in arguments))
        expected = getattr(double, name)(*arguments)
        if name == "kinetic_energy":
            assert type(one) is float and one == np.float32(one)
        for array, state, exact in zip(flat(many), flat(one), flat(expected)):
            assert array.dtype == np.float32 and exact.dtype == np.float64, name
            assert name == "kinetic_energy" or state.dtype == np.float32
            close(array, exact, 1e-2)
            close(state, exact[2], 1e-2)
    other = modyn.load(GOLDEN / "panda.urdf", joint_friction="none", scalar="f32", fused={"both": ["mass_matrix", "bias_forces"]})
    found = other.both(q, qd)
    assert found.mass_matrix.dtype == found.bias_forces.dtype == np.float32
    close(found.mass_matrix, double.mass_matrix(q), 1e-5)
    close(found.bias_forces, double.bias_forces(q, qd), 1e-4)


def test_arrays_are_read_and_written_where_they_are():
    _, single = both(modyn.load, GOLDEN / "panda.urdf", joint_friction="none")
    q, qd, _, tau = single_states(single, 4000)
    out = np.empty_like(q)
    assert single.forward_dynamics(q, qd, tau, out=out) is out
    linear = single.forward_dynamics_derivatives(q, qd, tau)
    expected = linear.dqdd_dq.copy()
    linear.dqdd_dq[:] = 0.0
    assert single.forward_dynamics_derivatives(q, qd, tau, out=linear) is linear
    assert np.array_equal(linear.dqdd_dq, expected)
    gc.collect()
    tracemalloc.start()
    for _ in range(3):
        single.forward_dynamics(q, qd, tau, out=out)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # The arrays of one call would be 112 kB.
    assert peak < 20_000, peak
    strange = np.empty((7, 8000), np.float32).T[::2]
    assert single.forward_dynamics(q, qd, tau, out=strange) is strange and np.array_equal(strange, out)


def test_other_numbers_are_converted_and_other_outputs_refused():
    double, single = both(modyn.load, GOLDEN / "panda.urdf", joint_friction="none")
    (q,), (qd,), _, (tau,) = single_states(double, 1)
    expected = single.forward_dynamics(q, qd, tau)
    for other in (q.astype(float), q.tolist(), q.astype(">f4")):
        assert np.array_equal(single.forward_dynamics(other, qd, tau), expected)
    with pytest.raises(TypeError, match="`out` of `forward_dynamics` must be an array of float32"):
        single.forward_dynamics(q, qd, tau, out=np.empty(7))
    with pytest.raises(TypeError, match="`out` of `forward_dynamics` must be an array of float64"):
        double.forward_dynamics(q, qd, tau, out=np.empty(7, np.float32))
    wrong = double.forward_dynamics_derivatives(q, qd, tau)
    with pytest.raises(ValueError, match="`ForwardDynamicsDerivatives` that an earlier call"):
        single.forward_dynamics_derivatives(q, qd, tau, out=wrong)
    with pytest.raises(TypeError, match="`q` of `forward_dynamics` must be an array of real numbers"):
        single.forward_dynamics(q.astype(complex), qd, tau)
    with pytest.raises(ValueError, match="option `scalar`: expected `f64` or `f32`"):
        modyn.load(GOLDEN / "panda.urdf", joint_friction="none", scalar="f16")


def test_the_conditioning_is_checked():
    """A load of ten tonnes on a link of ten grams, both about one axis."""
    link = '<link name="{0}"><inertial><mass value="{1}"/><inertia ixx="{1}" iyy="{1}" izz="{1}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    joint = '<joint name="j{1}" type="continuous"><parent link="{0}"/><child link="{1}"/><axis xyz="0 1 0"/></joint>'
    links = link.format("a", 1), link.format("b", 0.01), link.format("c", 1e4)
    uneven = f'<robot name="uneven">{"".join(links)}{joint.format("a", "b")}{joint.format("b", "c")}</robot>'
    modyn.loads(uneven)
    with pytest.warns(modyn.DescriptionWarning, match="single precision"):
        modyn.loads(uneven, scalar="f32")


def test_parameters_pickles_and_evaluation():
    options = {"runtime_gravity": True, "payload": ["link5"], "runtime_inertia": ["link2"]}
    double, single = both(modyn.loads, chain(4), **options)
    slow = modyn.loads(chain(4), scalar="f32", machine_code=False, **options)
    for robot in (double, single, slow):
        robot.set_gravity([1.0, -2.0, 3.0])
        robot.set_payload("link5", 2.5, [0.1, -0.2, 0.3])
        robot.set_inertia("link2", 1.0, [0.1, 0.2, 0.3], [0.1, 0, 0, 0.1, 0, 0.1])
    state = [x[0] for x in single_states(double, 1)][:3]
    expected = double.inverse_dynamics(*state)
    for robot in (single, slow, pickle.loads(pickle.dumps(single)), copy.deepcopy(single)):
        assert robot.dtype == np.float32
        found = robot.inverse_dynamics(*state)
        assert found.dtype == np.float32
        close(found, expected, 1e-5)
    many = slow.inverse_dynamics(*(np.tile(x, (3, 1)) for x in state))
    assert many.dtype == np.float32
    close(many[2], expected, 1e-5)
    for slow_pose, pose in zip(slow.link_poses(state[0]), double.link_poses(state[0])):
        close(slow_pose, pose, 1e-5)
    close(slow.jacobian(state[0], "link5"), double.jacobian(state[0], "link5"), 1e-5)
    with pytest.raises(ValueError, match="mass"):
        single.set_payload("link5", -1.0)


def test_settings_have_the_tolerances_of_the_scalar():
    """The default settings and those of the class are the same, in both precisions."""
    for scalar in ("f64", "f32"):
        robot = modyn.load(GOLDEN / "solo12.urdf", base="floating", joint_friction="none", contacts=FEET, scalar=scalar)
        state = [x[0] for x in single_states(robot, 1)]
        q, qd, tau = state[0], state[1], state[3]
        settings = modyn.ConstraintSettings([modyn.ContactTarget(), modyn.ContactTarget()])
        found = robot.constrained_forward_dynamics(q, qd, tau, settings=settings)
        expected = robot.constrained_forward_dynamics(q, qd, tau)
        assert found.rank == 6 and all(np.array_equal(a, b) for a, b in zip(found, expected))
        other = modyn.ConstraintSettings(settings.targets, rounding=0.9)
        assert robot.constrained_forward_dynamics(q, qd, tau, settings=other).rank < 6
    assert np.asarray(settings, np.float32)[3] == np.float32(1e-5)
    assert np.asarray(settings)[3] == 1e-10
    # A redundant loop: its dependent rows are rounding alone, whose size depends on the precision.
    double, single = both(modyn.load, ROBOTS / "four_bar.urdf", joint_friction="none")
    state = [x[0] for x in single_states(double, 1)]
    ranks = [robot.constrained_forward_dynamics(state[0], state[1], state[3]).rank for robot in (double, single)]
    assert ranks[0] == ranks[1] < 6
