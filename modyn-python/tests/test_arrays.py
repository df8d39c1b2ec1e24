"""Arguments and results: shapes, memory, `out`, errors."""

import gc
import tracemalloc

import numpy as np
import pytest
from conftest import close, states

import modyn


def test_shapes_decide(panda):
    q, qd, _, tau = states(panda, 5)
    assert panda.forward_dynamics(q[0], qd[0], tau[0]).shape == (7,)
    assert panda.forward_dynamics(q, qd, tau).shape == (5, 7)
    assert panda.forward_dynamics(q[:0], qd[:0], tau[:0]).shape == (0, 7)
    assert panda.forward_dynamics(q[:1], qd[:1], tau[:1]).shape == (1, 7)
    assert panda.jacobian(q[0], "panda_hand").shape == (6, 7)
    assert panda.jacobian(q, "panda_hand").shape == (5, 6, 7)
    assert panda.regressor(q, qd, qd).shape == (5, 7, 70)
    assert panda.kinetic_energy(q, qd).shape == (5,)
    step = panda.step_semi_implicit_derivatives(q, qd, tau, 0.01)
    assert (step.q.shape, step.a.shape, step.b.shape) == ((5, 7), (5, 14, 14), (5, 14, 7))
    # One state of an argument serves all states of another.
    close(panda.forward_dynamics(q, qd[0], tau), [panda.forward_dynamics(x, qd[0], t) for x, t in zip(q, tau)], 1e-8)
    dt = np.linspace(0.001, 0.1, 5)
    moved = panda.step_rk4(q, qd, tau, dt)
    close(moved.qd[3], panda.step_rk4(q[3], qd[3], tau[3], dt[3]).qd, 1e-8)


def test_anything_that_is_an_array_of_numbers(panda):
    (q,), (qd,), _, (tau,) = states(panda, 1)
    expected = panda.forward_dynamics(q, qd, tau)
    close(panda.forward_dynamics(list(q), tuple(qd), tau), expected)
    twice = np.repeat(q, 2)
    close(panda.forward_dynamics(twice[::2], qd, tau), expected)
    many = np.asfortranarray(np.tile(q, (3, 1)))
    close(panda.forward_dynamics(many, qd, tau), np.tile(expected, (3, 1)), 1e-8)
    single = panda.forward_dynamics(q.astype(np.float32), qd, tau)
    close(single, panda.forward_dynamics(q.astype(np.float32).astype(float), qd, tau))
    close(panda.gravity_torques([0, 1, 0, -1, 0, 1, 0]), panda.gravity_torques([0.0, 1, 0, -1, 0, 1, 0]))
    # Bytes in the other order, and memory that is not aligned.
    close(panda.forward_dynamics(q.astype(">f8"), qd, tau), expected)
    odd = np.zeros(7 * 8 + 1, np.uint8)[1:].view(float)
    odd[:] = q
    close(panda.forward_dynamics(odd, qd, tau), expected)


@pytest.mark.parametrize(
    "q, error, message",
    [
        (np.zeros(6), ValueError, r"`q` of `forward_dynamics` has the shape \(6,\); expected \(7,\), or \(n, 7\) for n states"),
        (np.zeros((7, 1)), ValueError, r"has the shape \(7, 1\)"),
        (np.zeros((2, 3, 7)), ValueError, r"has the shape \(2, 3, 7\)"),
        (0.0, ValueError, r"has the shape \(\)"),
        ("abc", TypeError, "`q` of `forward_dynamics` must be an array of real numbers"),
        (None, TypeError, "`forward_dynamics` needs the argument `q`"),
        (np.zeros(7, complex), TypeError, "must be an array of real numbers"),
        ([object()] * 7, TypeError, "must be an array of real numbers"),
    ],
)
def test_wrong_arguments_are_named(panda, q, error, message):
    with pytest.raises(error, match=message):
        panda.forward_dynamics(q, np.zeros(7), np.zeros(7))


def test_states_must_agree(panda):
    with pytest.raises(ValueError, match="`qd` of `forward_dynamics` has 3 states, and `q` has 2"):
        panda.forward_dynamics(np.zeros((2, 7)), np.zeros((3, 7)), np.zeros(7))


def test_links_are_named(panda):
    with pytest.raises(ValueError, match="no link `panda_hnd`; did you mean `panda_hand`"):
        panda.jacobian(np.zeros(7), "panda_hnd")
    with pytest.raises(ValueError, match="no link 99"):
        panda.jacobian(np.zeros(7), 99)
    with pytest.raises(TypeError, match="name of a link"):
        panda.jacobian(np.zeros(7), 1.5)
    with pytest.raises(TypeError, match="link"):
        panda.jacobian(np.zeros(7))


def addresses(result):
    arrays = result if isinstance(result, tuple) else (result,)
    return [array.__array_interface__["data"][0] for array in arrays]


@pytest.mark.parametrize("n", [None, 6])
def test_out_is_written_in_place(panda, n):
    q, qd, _, tau = (x if n else x[0] for x in states(panda, n or 1))
    calls = {
        "forward_dynamics": (q, qd, tau),
        "mass_matrix": (q,),
        "regressor": (q, qd, tau),
        "forward_dynamics_derivatives": (q, qd, tau),
        "link_poses": (q,),
        "step_rk4": (q, qd, tau, 0.01),
    }
    for name, arguments in calls.items():
        function = getattr(panda, name)
        expected = function(*arguments)
        out = function(*(np.zeros_like(x) for x in arguments))
        before = addresses(out)
        found = function(*arguments, out=out)
        assert found is out and addresses(out) == before, name
        for a, b in zip(found, expected):
            assert np.array_equal(a, b), name
    jacobian = panda.jacobian(q, "panda_hand")
    out = np.zeros_like(jacobian)
    assert panda.jacobian(q, "panda_hand", out=out) is out
    assert np.array_equal(out, jacobian)


def test_out_allocates_nothing(panda):
    q, qd, _, tau = states(panda, 4000)
    out = np.empty_like(q)
    matrix = panda.mass_matrix(q)
    panda.forward_dynamics(q, qd, tau, out=out)
    gc.collect()
    tracemalloc.start()
    for _ in range(3):
        panda.forward_dynamics(q, qd, tau, out=out)
        panda.mass_matrix(q, out=matrix)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # NumPy reports its arrays: those of one call would be 224 kB.
    assert peak < 20_000, peak


def test_out_of_another_order_is_filled(panda):
    q, qd, _, tau = states(panda, 6)
    expected = panda.mass_matrix(q)
    for out in (np.empty((6, 7, 7)), np.empty((7, 7, 6)).transpose(2, 0, 1), np.empty((12, 7, 14))[::2, :, ::2]):
        assert panda.mass_matrix(q, out=out) is out
        assert np.array_equal(out, expected)


def test_out_must_fit(panda):
    q, qd, _, tau = states(panda, 6)
    with pytest.raises(ValueError, match=r"`out` of `forward_dynamics` has the shape \(7,\); expected \(6, 7\)"):
        panda.forward_dynamics(q, qd, tau, out=np.empty(7))
    for wrong in (np.empty((6, 7), np.float32), [0.0] * 7, "abc"):
        with pytest.raises(TypeError, match="`out` of `forward_dynamics` must be an array of float64"):
            panda.forward_dynamics(q, qd, tau, out=wrong)
    frozen = np.empty((6, 7))
    frozen.flags.writeable = False
    with pytest.raises(ValueError, match="cannot be written"):
        panda.forward_dynamics(q, qd, tau, out=frozen)
    with pytest.raises(ValueError, match="overlaps an argument"):
        panda.forward_dynamics(q, qd, tau, out=tau)
    derivatives = panda.forward_dynamics_derivatives(q, qd, tau)
    fewer = panda.forward_dynamics_derivatives(q[:3], qd[:3], tau[:3])
    copies = type(derivatives)(*(field.copy() for field in derivatives))
    for wrong in (fewer, copies, derivatives.qdd, derivatives._replace(dq=derivatives.dqd)):
        with pytest.raises(ValueError, match="`ForwardDynamicsDerivatives` that an earlier call"):
            panda.forward_dynamics_derivatives(q, qd, tau, out=wrong)


def test_results_outlive_the_robot():
    urdf = (
        '<robot name="p"><link name="a"/><joint name="j" type="continuous"><parent link="a"/><child link="b"/>'
        '<axis xyz="0 1 0"/></joint><link name="b"><inertial><origin xyz="0 0 -0.5"/><mass value="2"/>'
        '<inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>'
    )
    robot = modyn.loads(urdf)
    poses = robot.link_poses([0.5])
    del robot
    gc.collect()
    close(poses.rotation[1] @ [0, 0, 1], [np.sin(0.5), 0, np.cos(0.5)])
