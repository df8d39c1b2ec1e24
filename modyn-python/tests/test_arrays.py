"""Arguments and results: shapes, memory, `out`, errors."""

import ctypes
import gc
import subprocess
import sys
import tracemalloc

import numpy as np
import pytest
from conftest import GOLDEN, close, signatures, states

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


def test_no_states(panda):
    """Results of no states have their shapes, as those of several arrays do."""
    q, qd, _, tau = states(panda, 0)
    poses = panda.link_poses(q)
    assert poses.rotation.shape == (0, len(panda.link_names), 3, 3) and poses.translation.shape == (0, len(panda.link_names), 3)
    assert panda.step_semi_implicit(q, qd, tau, 0.01).qd.shape == (0, panda.nv)
    assert panda.link_poses(q, out=poses) is poses


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
    for wrong in (fewer, copies, derivatives.qdd, derivatives._replace(dqdd_dq=derivatives.dqdd_dqd)):
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


def at_odd_address(shape, dtype=float):
    """Returns an array in C order whose numbers are not aligned."""
    size = int(np.prod(shape)) * np.dtype(dtype).itemsize
    array = np.zeros(size + 1, np.uint8)[1:].view(dtype).reshape(shape)
    assert not array.flags.aligned or array.size == 0
    return array


def fields(result):
    return result if isinstance(result, tuple) else (result,)


def calls(robot, n):
    """Returns the arguments of each function for n states, or for one state with `None`."""
    q, qd, qdd, tau = (x if n else x[0] for x in states(robot, n or 1))
    own = {"q": q, "from_": q, "qd": qd, "qdd": qdd, "tau": tau, "dt": 0.01, "uniforms": np.full_like(qd, 0.5)}
    rng = np.random.default_rng(4)
    found = {}
    for name, arguments, link in signatures(robot, "panda_hand"):
        lead = (n,) if n else ()
        given = [own.get(k, rng.normal(size=(*lead, *shape)) if default is None else default) for k, shape, default in arguments]
        found[name] = (*given, *link)
    return found


@pytest.mark.parametrize("options", [{}, {"scalar": "f32"}, {"machine_code": False}])
@pytest.mark.parametrize("n", [None, 5])
def test_out_at_an_odd_address_is_written(n, options):
    robot = modyn.load(GOLDEN / "panda.urdf", joint_friction="none", **options)
    written = 0
    for name, arguments in calls(robot, n).items():
        function = getattr(robot, name)
        expected = function(*arguments)
        if isinstance(expected, tuple) or np.ndim(expected) == 0:
            continue
        out = at_odd_address(expected.shape, expected.dtype)
        assert function(*arguments, out=out) is out
        assert np.array_equal(out, expected), name
        written += 1
    assert written > 20, written


@pytest.mark.parametrize("n", [None, 5])
def test_arguments_at_odd_addresses_are_read(panda, n):
    for name, arguments in calls(panda, n).items():
        function = getattr(panda, name)
        odd = []
        for x in arguments:
            if isinstance(x, np.ndarray):
                odd.append(at_odd_address(x.shape))
                odd[-1][...] = x
            else:
                odd.append(x)
        for a, b in zip(fields(function(*odd)), fields(function(*arguments))):
            assert np.array_equal(a, b), name
    q, qd, _, tau = states(panda, 3)
    odd = at_odd_address((3, 4, 7))
    odd[...] = tau[:, None]
    found, expected = (panda.rollout(q, qd, x, 0.01) for x in (odd, np.repeat(tau[:, None], 4, 1)))
    assert all(np.array_equal(a, b) for a, b in zip(found, expected))
    by_odd = panda.rollout_vjp(q, qd, odd, 0.01, np.ones((4, 7)), np.ones((4, 7)))
    close(by_odd.controls, panda.rollout_vjp(q, qd, np.repeat(tau[:, None], 4, 1), 0.01, np.ones((4, 7)), np.ones((4, 7))).controls, 0)


def buffers(count):
    """Returns pairs of functions that make arrays of a place in one memory, each by another way."""
    memory = bytearray(8 * count)
    whole = np.frombuffer(memory)
    address = whole.ctypes.data
    by_buffer = lambda first, n: np.frombuffer(memory)[first : first + n]
    by_view = lambda first, n: whole[first : first + n]
    by_address = lambda first, n: np.ctypeslib.as_array((ctypes.c_double * n).from_address(address + 8 * first))
    return memory, [(by_buffer, by_buffer), (by_view, by_buffer), (by_address, by_view), (by_buffer, by_address)]


def test_out_with_the_memory_of_an_argument_is_refused(panda):
    n = 100
    q, qd, _, tau = states(panda, n)
    for k, name in enumerate(["q", "qd", "tau"]):
        memory, ways = buffers(7 * (3 * n))
        for of_argument, of_out in ways:
            given = [q, qd, tau]
            argument = of_argument(7 * n, 7 * n).reshape(n, 7)
            argument[:] = given[k]
            given[k] = argument
            expected = panda.forward_dynamics(*given)
            for first in (7 * (n - 2), 7 * n, 7 * (2 * n - 1), 1):
                with pytest.raises(ValueError, match="`out` of `forward_dynamics` overlaps an argument") as error:
                    panda.forward_dynamics(*given, out=of_out(first, 7 * n).reshape(n, 7))
                assert f"`{name}`" in str(error.value) or "used by another call" in str(error.value)
                assert np.array_equal(argument, [q, qd, tau][k])
            # Memory beside that of the argument is allowed.
            for first in (0, 14 * n):
                out = of_out(first, 7 * n).reshape(n, 7)
                panda.forward_dynamics(*given, out=out)
                assert np.array_equal(out, expected)
            assert np.array_equal(argument, [q, qd, tau][k])
        del memory


def test_interrupts_of_arguments_stay_interrupts(panda):
    class Array:
        def __init__(self, error):
            self.error = error

        def __array__(self, *_, **__):
            raise self.error

    z = np.zeros(7)
    for error, expected in [(KeyboardInterrupt(), KeyboardInterrupt), (MemoryError(), MemoryError), (ValueError("no"), TypeError)]:
        with pytest.raises(expected):
            panda.forward_dynamics(Array(error), z, z)
        with pytest.raises(expected):
            panda.rollout(Array(error), z, np.zeros((3, 7)), 0.01)


MEMORY = """
import resource, sys, numpy as np, modyn
robot = modyn.load(sys.argv[1], joint_friction="none")
z, one = np.zeros(7), np.zeros((1, 7))
robot.forward_dynamics_derivatives(one, z, z)
robot.mass_matrix(one), robot.rollout(one, z, np.zeros((2, 7)), 1e-3), robot.rollout_vjp(one, z, np.zeros((2, 7)), 1e-3, np.zeros((2, 7)), np.zeros((2, 7)))
q = np.zeros((400_000, 7))
used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + 100_000_000, used + 100_000_000))
for call in (
    lambda: robot.forward_dynamics_derivatives(q, z, z),
    lambda: robot.mass_matrix(q),
    lambda: robot.rollout(q, z, np.zeros((1000, 7)), 1e-3),
    lambda: robot.rollout(q[:2000], z, np.zeros((2000, 1, 3, 7)), 1e-3),
    lambda: robot.rollout(q, z, np.zeros((2**14, 1, 3, 7)), 1e-3),
    lambda: robot.rollout_vjp(q, z, np.zeros((1000, 7)), 1e-3, np.zeros((1000, 7)), np.zeros((1000, 7))),
):
    try:
        call()
    except MemoryError as error:
        print("MemoryError", error)
"""


def test_results_beyond_memory_are_memory_errors():
    run = subprocess.run([sys.executable, "-c", MEMORY, str(GOLDEN / "panda.urdf")], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert run.stdout.count("MemoryError") == 6, run.stdout
