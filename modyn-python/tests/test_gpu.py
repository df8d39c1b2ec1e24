"""Kernels on a graphics processor, against the functions of the same robot. They need the feature `gpu`, and any processor
that Vulkan has: in CI, Mesa's software processor. With the variable `MODYN_GPU`, a build without the feature fails."""

import os

import numpy as np
import pytest
from conftest import GOLDEN, ROBOTS, ROOT, blocks, close, states

import modyn
from modyn import _modyn

HAS_GPU = hasattr(_modyn, "GpuRobot")
needs_gpu = pytest.mark.skipif(not HAS_GPU and "MODYN_GPU" not in os.environ, reason="built without the feature `gpu`")


@pytest.mark.skipif(HAS_GPU, reason="built with the feature `gpu`")
def test_a_build_without_kernels_names_the_feature(panda):
    with pytest.raises(RuntimeError, match="--features gpu"):
        panda.gpu()


@needs_gpu
def test_functions_agree_with_the_robot(panda):
    q, qd, qdd, tau = states(panda, 100)
    kernels = panda.gpu()
    assert kernels.processor
    device = [kernels.upload(x) for x in (q, qd, tau)]
    found = kernels.run("forward_dynamics", *device)
    assert len(found) == 100 and "100 states, 7 numbers" in repr(found)
    close(found.numpy(), panda.forward_dynamics(q, qd, tau), 1e-4)
    close(kernels.run("inverse_dynamics", q, qd, qdd).numpy(), panda.inverse_dynamics(q, qd, qdd), 1e-5)
    # Results are arguments; a number of NumPy's is one state for all.
    again = kernels.run("inverse_dynamics", device[0], device[1], found)
    close(again.numpy(), tau, 1e-4)
    close(kernels.run("mass_matrix", q).numpy(), panda.mass_matrix(q), 1e-5)
    close(kernels.run("bias_forces", q, qd[3]).numpy(), panda.bias_forces(q, qd[3]), 1e-5)
    close(kernels.run("jacobian", q, link="panda_hand").numpy(), panda.jacobian(q, "panda_hand"), 1e-5)
    derivatives = kernels.run("forward_dynamics_derivatives", *device).numpy()
    for found, expected in zip(derivatives, panda.forward_dynamics_derivatives(q, qd, tau)):
        close(found, expected, 1e-3)
    assert type(derivatives) is modyn.ForwardDynamicsDerivatives and derivatives.dqdd_dq.dtype == np.float32


@needs_gpu
def test_the_page(monkeypatch):
    """The program of docs/gpu.md."""
    monkeypatch.chdir(ROOT)
    (program,) = blocks("docs/gpu.md")
    session = {}
    exec(compile(program, "gpu.md", "exec"), session)
    robot, q, qd, tau, torques = (session[name] for name in ("robot", "Q", "QD", "TAU", "torques"))
    close(session["qdd"].numpy(), robot.forward_dynamics(q, qd, tau), 1e-3)
    expected = robot.rollout(q[0], qd[0], torques, 0.01, trajectory=False)
    close(session["results"].state.numpy(), np.hstack([expected.q, expected.qd]), 1e-3)


@needs_gpu
def test_run_time_parameters():
    robot = modyn.load(GOLDEN / "panda.urdf", joint_friction="none", runtime_gravity=True, payload=["panda_hand"])
    q, *_ = states(robot, 20)
    kernels = robot.gpu()
    close(kernels.run("gravity_torques", q).numpy(), robot.gravity_torques(q), 1e-5)
    robot.set_gravity([1.0, -2.0, 3.0])
    robot.set_payload("panda_hand", 2.0, [0.1, 0.2, 0.3])
    expected = robot.gravity_torques(q)
    close(kernels.run("gravity_torques", q).numpy(), expected, 1e-5)
    assert np.abs(expected).max() > 1


@needs_gpu
def test_rollouts_are_loops_of_steps():
    robot = modyn.load(ROBOTS / "quadruped.urdf", base="floating")
    (q, qd, _, tau), n, steps, dt = states(robot, 3), 10, 7, 0.002
    controls = np.random.default_rng(5).normal(size=(n, steps, robot.nv))
    cost = """
    fn cost(q: array<f32, 19>, qd: array<f32, 18>, u: array<f32, 18>, step: u32) -> f32 {
        return data[0] * q[2] + data[1] * u[4] + f32(step);
    }"""
    rollout = robot.gpu().rollout(cost=cost)
    results = rollout.run(q, qd, controls, dt, data=[2.0, 0.5], trajectory=True)
    found = results.trajectory.numpy()
    assert found.shape == (n, steps, 37)
    now = [np.resize(q, (n, 19)), np.resize(qd, (n, 18))]
    total = np.zeros(n)
    for k in range(steps):
        now = robot.step_semi_implicit(*now, controls[:, k], dt)
        close(found[:, k], np.hstack(now), 1e-4)
        total += 2.0 * now[0][:, 2] + 0.5 * controls[:, k, 4] + k
    close(results.state.numpy(), found[:, -1], 0)
    close(results.cost.numpy(), total, 1e-4)
    assert rollout.run(q[0], qd[0], robot.gpu().upload(controls), dt, data=[1.0, 1.0]).trajectory is None


@needs_gpu
def test_rollouts_that_hold_contacts():
    """A foot that is held stays where it is."""
    robot = modyn.load(
        ROBOTS / "quadruped.urdf", base="floating", contacts={"foot": ("point", "front_left_foot", [0, 0, 0])}
    )
    active = """
    fn active_contacts(q: array<f32, 19>, qd: array<f32, 18>, u: array<f32, 18>, step: u32) -> array<f32, 1> {
        return array<f32, 1>(data[0]);
    }"""
    rollout = robot.gpu().rollout(["constrained_forward_dynamics", "integrate"], active_contacts=active)
    q = robot.neutral()
    ground = modyn.ContactTarget(translation=robot.link_pose(q, "front_left_foot").translation)
    settings = modyn.ConstraintSettings([ground])
    run = lambda held: rollout.run(
        q, np.zeros(18), np.zeros((1, 30, 18)), 0.002, step="constrained_forward_dynamics", settings=settings, data=[held]
    ).state.numpy()[0, :19]
    foot = lambda q: robot.link_pose(q.astype(float), "front_left_foot").translation
    assert np.abs(foot(run(1.0)) - ground.translation).max() < 1e-3
    assert foot(run(0.0))[2] < ground.translation[2] - 0.01


@needs_gpu
def test_what_does_not_fit_is_named(panda):
    kernels = panda.gpu()
    q = np.zeros((3, 7))
    for error, message, call in [
        (ValueError, "there is no function `forward_dynamic`; did you mean", lambda: kernels.run("forward_dynamic", q)),
        (TypeError, "`mass_matrix` takes q, and 2 arguments", lambda: kernels.run("mass_matrix", q, q)),
        (TypeError, "`link_pose` needs `link`", lambda: kernels.run("link_pose", q)),
        (TypeError, "`mass_matrix` takes no link", lambda: kernels.run("mass_matrix", q, link=0)),
        (ValueError, r"`q` of `mass_matrix` has the shape \(3, 6\)", lambda: kernels.run("mass_matrix", q[:, :6])),
        (ValueError, "7 numbers a state as `q`, not 6", lambda: kernels.run("mass_matrix", kernels.upload(q[:, :6]))),
        (ValueError, "for 3 and for 2 states", lambda: kernels.run("bias_forces", q, q[:2])),
        (ValueError, "only robots with", lambda: kernels.run("constraint_jacobian", q)),
        (ValueError, "`forces` needs `controls`", lambda: kernels.rollout(forces="fn forces() {}")),
        (modyn.DescriptionError, "step_semi_implicit", lambda: kernels.rollout(["mass_matrix"])),
        (RuntimeError, "unknown", lambda: kernels.rollout(cost="fn cost() -> f32 { return unknown; }")),
        (ValueError, r"expected \(n, steps, 7\)", lambda: kernels.rollout().run(q[0], q[0], q, 0.01)),
    ]:
        with pytest.raises(error, match=message):
            call()
