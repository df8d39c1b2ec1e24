"""Reading: options, errors with places, warnings, names, pickles."""

import copy
import pickle

import numpy as np
import pytest
from conftest import GOLDEN, ROBOTS, chain, close, states

import modyn

PENDULUM = """<robot name="pendulum">
  <link name="world"/>
  <joint name="pivot" type="revolute">
    <parent link="world"/><child link="rod"/><axis xyz="0 1 0"/>
    <limit lower="-1.5" upper="2" velocity="3" effort="4"/>
  </joint>
  <link name="rod"><inertial><origin xyz="0 0 -0.5"/><mass value="2"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
</robot>
"""


def test_a_pendulum():
    robot = modyn.loads(PENDULUM)
    inertia = 0.1 + 2 * 0.5**2
    for q, qd, tau in [(0.3, 0.1, 0.7), (-1.0, 2.0, -3.0)]:
        expected = (tau - 2 * 9.81 * 0.5 * np.sin(q)) / inertia
        close(robot.forward_dynamics([q], [qd], [tau]), [expected])
    assert (robot.name, robot.nq, robot.nv) == ("pendulum", 1, 1)
    assert robot.joint_names == ["pivot"] and robot.link_names == ["world", "rod"]
    assert robot.coordinate_names == ["pivot"] and robot.velocity_names == ["pivot"]
    limits = robot.limits
    assert (limits.lower, limits.upper, limits.velocity, limits.effort) == (-1.5, 2, 3, 4)
    assert repr(robot) == "<modyn.Robot 'pendulum', nq = 1, nv = 1>"


def test_names_of_a_floating_base():
    robot = modyn.load(GOLDEN / "solo12.urdf", base="floating", joint_friction="none")
    assert (robot.nq, robot.nv) == (19, 18)
    assert [joint.type for joint in robot.joints[:2]] == ["floating", "revolute"]
    assert robot.joints[0].q == slice(0, 7) and robot.joints[0].v == slice(0, 6)
    assert len(robot.coordinate_names) == 19 and robot.coordinate_names[3].endswith(".qx")
    robot.check_configuration(robot.neutral())
    with pytest.raises(ValueError, match="length"):
        robot.check_configuration(2 * robot.neutral())


def test_a_wrong_description_has_its_place(tmp_path):
    path = tmp_path / "wrong.urdf"
    path.write_text(PENDULUM.replace('mass value="2"', 'mass value="-2"'))
    with pytest.raises(modyn.DescriptionError) as caught:
        modyn.load(path)
    error = caught.value
    assert (error.code, error.file, error.line) == ("negative-mass", str(path), 7)
    assert error.column > 1
    assert str(error).startswith(f"{path}:7:{error.column}: error[negative-mass]: link `rod`")
    [diagnostic] = error.diagnostics
    assert diagnostic.severity == "error" and diagnostic.subject == "link `rod`" and diagnostic.help
    assert isinstance(error, ValueError)
    other = pickle.loads(pickle.dumps(error))
    assert str(other) == str(error) and other.line == 7


def test_all_faults_are_reported():
    text = PENDULUM.replace('mass value="2"', 'mass value="x"').replace('child link="rod"', 'child link="rood"')
    with pytest.raises(modyn.DescriptionError) as caught:
        modyn.loads(text, file="a.urdf")
    assert len(caught.value.diagnostics) >= 2
    assert all(fault.file == "a.urdf" and fault.line for fault in caught.value.diagnostics)


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(FileNotFoundError) as caught:
        modyn.load(tmp_path / "none.urdf")
    assert caught.value.filename == str(tmp_path / "none.urdf")
    assert str(caught.value) == f"[Errno 2] No such file or directory: {str(tmp_path / 'none.urdf')!r}"
    with pytest.raises((IsADirectoryError, modyn.DescriptionError)):
        modyn.load(tmp_path)
    binary = tmp_path / "binary.urdf"
    binary.write_bytes(b"<robot>\n\xff")
    with pytest.raises(modyn.DescriptionError) as caught:
        modyn.load(binary)
    assert (caught.value.code, caught.value.line) == ("not-text", 2)


def test_warnings_of_a_description():
    with pytest.warns(modyn.DescriptionWarning, match="friction") as caught:
        modyn.load(GOLDEN / "panda.urdf")
    assert caught[0].message.diagnostic.severity == "warning"


def test_options(tmp_path):
    moon = modyn.loads(PENDULUM, gravity=[0, 0, -1.62])
    close(moon.gravity, [0, 0, -1.62])
    close(moon.gravity_torques([0.5]), [2 * 1.62 * 0.5 * np.sin(0.5)])
    assert modyn.loads(chain(0), base="floating").nv == 6 + 6
    geared = modyn.loads(PENDULUM, rotors={"pivot": (1e-4, 100)})
    close(geared.mass_matrix([0.2]), [[0.6 + 1.0]])
    same = modyn.loads(PENDULUM, rotors='["pivot": (0.0001, 100)]')
    close(same.mass_matrix([0.2]), [[1.6]])
    panda = {f: modyn.load(GOLDEN / "panda.urdf", joint_friction=f) for f in ("none", "viscous", "smooth(0.01)")}
    q, qd, qdd, _ = (x[0] for x in states(panda["none"], 1))
    forces = [robot.inverse_dynamics(q, qd, qdd) for robot in panda.values()]
    assert np.abs(forces[1] - forces[0]).max() > 1e-3 and np.abs(forces[2] - forces[0]).max() > 1e-3


@pytest.mark.parametrize(
    "options, error, message",
    [
        ({"bse": "fixed"}, TypeError, "no option `bse`; did you mean `base`"),
        ({"functions": "all"}, TypeError, "no option `functions`; there are: gravity, base"),
        ({"friction": "none"}, TypeError, "the option `friction` is named `joint_friction` now"),
        ({"share": True}, TypeError, "no option `share`"),
        ({"base": "flying"}, ValueError, "option `base`: expected `auto` or `fixed` or `floating`"),
        ({"gravity": 3}, ValueError, "option `gravity`: expected three numbers"),
        ({"rotors": {"pivot": object()}}, ValueError, "option `rotors`: .* has another type; for example rotors="),
        ({"rotors": {"pivit": (1, 1)}}, modyn.DescriptionError, "pivit"),
        ({"payload": ["hand"]}, modyn.DescriptionError, "hand"),
        ({"fused": {"both": ["mas_matrix"]}}, ValueError, "did you mean `mass_matrix`"),
        ({"modules": [["rod", "bar"]]}, modyn.DescriptionError, "bar"),
        (
            {"contacts": {"toe": "rod"}},
            ValueError,
            r'option `contacts`: the value has another form than in contacts={"fingertip": \("point", "hand", \[0, 0, 0.2\]\)}. '
            "Frames of links",
        ),
        ({"contacts": '["toe": rod]'}, ValueError, r'expected `"name": point\("link"\)`'),
        ({"contacts": {"toe": ("pont", "rod")}}, ValueError, "expected `point` or `surface`; for example contacts="),
        ({"fused": {"both": [3]}}, ValueError, r'another form than in fused={"control": \["mass_matrix", '),
        ({"ground": ("plane", [0, 0, 1])}, ValueError, r'another form than in ground=\("plane", \[0, 0, 0.1\], \[0, 0, 1\]\)'),
        ({"ground": "wall"}, ValueError, r"expected `plane` or `plane\(\[x, y, z\], \[nx, ny, nz\]\)`"),
        ({"actuators": {"pivot": ("position", 20)}}, ValueError, r'another form than in actuators={"elb\*": \("position", 20, 0.5, {'),
        ({"actuators": {"pivot": ("motor", {"delay": 0.5})}}, ValueError, "a whole number of steps: `delay = 2`; for example"),
        ({"actuators": '"pivot": servo'}, ValueError, r'expected `"joint": position\(kp, kd\)`'),
        ({"actuators": {"pivit": "motor"}}, modyn.DescriptionError, "did you mean `pivot`"),
        ({"joint_friction": ("smooth", "fast")}, ValueError, r'expected a number; for example joint_friction=\("smooth", 0.01\)'),
        ({"joint_friction": ("smooth",)}, ValueError, r'another form than in joint_friction=\("smooth", 0.01\)'),
    ],
)
def test_wrong_options(options, error, message):
    with pytest.raises(error, match=message):
        modyn.loads(PENDULUM, **options)


@pytest.mark.parametrize("name, example", [(name, example) for name, example, *_ in modyn._modyn.options_table()])
def test_examples_of_options_are_values(name, example):
    """The examples in the documentation of options, for a robot with the links and joints that they name."""
    text = '<robot name="all"><link name="body"/>'
    for parent, joint, link in [
        ("body", "shoulder", "upper_arm"),
        ("upper_arm", "elbow", "forearm"),
        ("forearm", "wrist", "hand"),
        ("hand", "left", "rod"),
        ("rod", "right", "crank"),
    ]:
        text += (
            f'<joint name="{joint}" type="continuous"><parent link="{parent}"/><child link="{link}"/><axis xyz="0 1 0"/></joint>'
            f'<link name="{link}"><inertial><origin xyz="0.2 0 0"/><mass value="1"/>'
            '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        )
    value = eval(example, {})
    if name == "modules":
        value[-1] += ["rod", "crank"]
    if name == "base":
        text = text.replace('<link name="body"/>', '''<link name="body"><inertial><mass value="1"/>
            <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>''')
    if name == "ground":
        text = text.replace('<link name="hand">', '''<link name="hand"><collision name="palm"><geometry><sphere radius="0.1"/></geometry></collision>''')
    robot = modyn.loads(text + "</robot>", **{name: value})
    assert robot.touching_shape_names == {"ground": ["palm"], "contacts": ["fingertip"]}.get(name, [])
    assert robot.nv == (11 if name == "base" else 5)
    assert robot.control_names == (["elbow"] if name == "actuators" else [])


def test_parameters_that_change():
    robot = modyn.loads(chain(4), runtime_gravity=True, payload=["link5"], runtime_inertia="link2")
    fixed = modyn.loads(chain(4))
    q, qd, qdd, tau = (x[0] for x in states(robot, 1))
    before = robot.inverse_dynamics(q, qd, qdd)
    close(before, fixed.inverse_dynamics(q, qd, qdd))
    robot.forward_dynamics(q, qd, tau)
    robot.set_gravity(np.array([1.0, -2.0, 3.0]))
    tilted = modyn.loads(chain(4), gravity=(1.0, -2.0, 3.0))
    close(robot.inverse_dynamics(q, qd, qdd), tilted.inverse_dynamics(q, qd, qdd))
    close(robot.forward_dynamics(q, qd, tau), tilted.forward_dynamics(q, qd, tau), 1e-8)
    robot.set_payload("link5", 2.5, [0.1, -0.2, 0.3])
    # A point mass adds J^T m J, and its weight.
    jacobian, pose = robot.jacobian(q, "link5"), robot.link_pose(q, "link5")
    lever = pose.rotation @ [0.1, -0.2, 0.3]
    velocity = jacobian[:3] + np.cross(jacobian[3:], lever, axis=0)
    close(robot.mass_matrix(q), fixed.mass_matrix(q) + 2.5 * velocity.T @ velocity)
    # Functions that are compiled later know the change, too.
    close(robot.gravity_torques(q), tilted.gravity_torques(q) - 2.5 * velocity.T @ [1.0, -2.0, 3.0])
    factors = robot.brge(q)
    close(factors.u() @ factors.d() @ factors.u().T, robot.mass_matrix(q))
    other = pickle.loads(pickle.dumps(robot))
    close(other.inverse_dynamics(q, qd, qdd), robot.inverse_dynamics(q, qd, qdd))
    with pytest.raises(ValueError, match="mass"):
        robot.set_payload("link5", -1.0)
    with pytest.raises(ValueError, match="link `link1` has no payload; load the robot with payload="):
        robot.set_payload("link1", 1.0)
    with pytest.raises(ValueError, match="there is no link `lnk5`; did you mean `link"):
        robot.set_payload("lnk5", 1.0)
    with pytest.raises(ValueError, match=r"`gravity` of `set_gravity` has the shape \(2,\)"):
        robot.set_gravity([0, 0])
    with pytest.raises(ValueError, match="finite"):
        robot.set_gravity([0, 0, np.inf])
    with pytest.raises(ValueError, match="gravity is a constant"):
        fixed.set_gravity([0, 0, 0])
    robot.set_inertia("link2", 1.0, [0.1, 0.2, 0.3], [0.1, 0, 0, 0.1, 0, 0.1])
    assert np.abs(robot.mass_matrix(q) - other.mass_matrix(q)).max() > 1e-3


def test_parameters_of_functions_without_machine_code():
    """Products in both modes and a step, with run-time gravity, have more arguments than machine code can have."""
    options = {"runtime_gravity": True, "payload": "link4", "runtime_inertia": "link1"}
    options["fused"] = {"both": ["forward_dynamics_jvp", "forward_dynamics_vjp", "step_rk4"]}
    robot, slow = modyn.loads(chain(6), **options), modyn.loads(chain(6), machine_code=False, **options)
    q, qd, qdd, tau = (x[0] for x in states(robot, 1))
    state, direction = (q, qd, tau), (qd, tau, qdd)
    before = robot.forward_dynamics_jvp(*state, *direction)
    with pytest.warns(modyn.MachineCodeWarning, match="evaluated, which is slow: `both` has 9 arrays"):
        together = robot.both(*state, *direction, qdd, 0.01)
    close(together.forward_dynamics_jvp.tangent_qdd, before.tangent_qdd, 1e-8)
    for other in (robot, slow):
        other.set_gravity([0.5, 1.5, -3.0])
        other.set_payload("link4", 1.5, [0.3, 0.1, -0.2])
        other.set_inertia("link1", 2.0, [0.1, 0.2, 0.3], [0.1, 0, 0, 0.1, 0, 0.1])
    after = robot.forward_dynamics_jvp(*state, *direction)
    assert np.abs(after.tangent_qdd - before.tangent_qdd).max() > 1e-3
    close(after.qdd, robot.forward_dynamics(*state), 1e-8)
    close(slow.forward_dynamics(*state), robot.forward_dynamics(*state), 1e-8)
    linear = robot.forward_dynamics_derivatives(*state)
    close(after.tangent_qdd, linear.dqdd_dq @ direction[0] + linear.dqdd_dqd @ direction[1] + linear.dqdd_dtau @ direction[2], 1e-8)
    for wrong, message in [(("link4", -1.0), "mass"), (("link2", 1.0), "link `link2` has no payload")]:
        with pytest.raises(ValueError, match=message):
            slow.set_payload(*wrong)


def test_pickles_and_copies(panda):
    q, qd, _, tau = states(panda, 3)
    for other in (pickle.loads(pickle.dumps(panda)), copy.copy(panda), copy.deepcopy(panda)):
        assert np.array_equal(other.forward_dynamics(q, qd, tau), panda.forward_dynamics(q, qd, tau))
        assert other.link_names == panda.link_names
    derivatives = panda.forward_dynamics_derivatives(q, qd, tau)
    again = pickle.loads(pickle.dumps(derivatives))
    assert type(again) is modyn.ForwardDynamicsDerivatives and np.array_equal(again.dqdd_dq, derivatives.dqdd_dq)


def test_fused(panda):
    robot = modyn.load(
        GOLDEN / "panda.urdf",
        joint_friction="none",
        fused={"control": ["mass_matrix", "bias_forces", ("jacobian", "panda_hand"), ("link_pose", "panda_hand")]},
    )
    q, qd, *_ = states(robot, 4)
    assert robot.fused_names == ["control"] and "control" in dir(robot)
    for i in range(4):
        state = robot.control(q[i], qd=qd[i])
        close(state.mass_matrix, panda.mass_matrix(q[i]))
        close(state.bias_forces, panda.bias_forces(q[i], qd[i]))
        close(state.jacobian_panda_hand, panda.jacobian(q[i], "panda_hand"))
        close(state.link_pose_panda_hand.rotation, panda.link_pose(q[i], "panda_hand").rotation)
    many = robot.control(q, qd)
    close(many.jacobian_panda_hand, panda.jacobian(q, "panda_hand"))
    assert robot.control(q, qd, out=many) is many
    with pytest.raises(TypeError, match="needs the argument `qd`"):
        robot.control(q)
    with pytest.raises(TypeError, match="takes q, qd, not"):
        robot.control(q, qd, tau=q)
    with pytest.raises(TypeError, match="argument `q` twice"):
        robot.control(q, qd, q=q)
    with pytest.raises(AttributeError, match="did you mean `mass_matrix`"):
        robot.mas_matrix
    assert not hasattr(panda, "control")


def test_the_factorization(panda):
    (q,), _, _, (tau,) = states(panda, 1)
    factors = panda.brge(q)
    mass = panda.mass_matrix(q)
    close(factors.u() @ factors.d() @ factors.u().T, mass)
    close(factors.inverse() @ mass, np.eye(7), 1e-9)
    close(factors.solve(tau), np.linalg.solve(mass, tau), 1e-9)
    close(factors.log_determinant(), np.linalg.slogdet(mass)[1])
    close(factors.u_inverse() @ factors.u(), np.eye(7))
    close(factors.d_inverse() @ factors.d(), np.eye(7), 1e-9)
    links = [[f"panda_link{i}"] for i in range(1, 8)]
    for modules in ("links", links, str(links).replace("'", '"')):
        single = modyn.load(GOLDEN / "panda.urdf", joint_friction="none", modules=modules).brge(q)
        assert np.count_nonzero(np.abs(single.d()) > 1e-12) == 7


def test_loops_and_contacts():
    """A closed loop stays closed, and a foot on the ground does not accelerate."""
    loop = modyn.load(ROBOTS / "four_bar.urdf", joint_friction="none")
    assert loop.loop_constraint_names
    robot = modyn.load(
        GOLDEN / "solo12.urdf",
        base="floating",
        joint_friction="none",
        contacts={name: ("point", link) for name, link in (("left", "FL_FOOT"), ("right", "HR_FOOT"))},
    )
    assert robot.contact_names == ["left", "right"]
    (q,), (qd,), _, (tau,) = states(robot, 1)
    exact = modyn.ContactTarget(alpha=0.0, beta=0.0)
    settings = modyn.ConstraintSettings([exact, exact])
    found = robot.constrained_forward_dynamics(q, qd, tau, settings=settings)
    assert found.wrenches.shape == (2, 6) and found.rank == 6
    for link in ("FL_FOOT", "HR_FOOT"):
        close(robot.link_acceleration(q, qd, found.qdd, link)[:3], np.zeros(3), 1e-8)
    one = robot.constrained_forward_dynamics(q, qd, tau, [0, 1], settings)
    assert one.rank == 3 and np.abs(robot.link_acceleration(q, qd, one.qdd, "FL_FOOT")[:3]).max() > 0.1
    assert not one.wrenches[0].any()
    jacobian = robot.constraint_jacobian(q)
    assert jacobian.shape == (2, 6, 18)
    close(jacobian[1, :3], robot.jacobian(q, "HR_FOOT")[:3])
    power = found.wrenches.ravel() @ jacobian.reshape(12, 18)
    close(robot.mass_matrix(q) @ found.qdd, tau - robot.bias_forces(q, qd) + power, 1e-8)
    many = robot.constrained_forward_dynamics(np.tile(q, (3, 1)), qd, tau, settings=settings)
    close(many.qdd, np.tile(found.qdd, (3, 1)), 1e-8)
    derivatives = robot.constrained_forward_dynamics_derivatives(q, qd, tau, settings=settings)
    assert derivatives.dwrenches_dtau.shape == (2, 6, 18)
    step = np.zeros(18)
    step[7] = 1e-5
    ahead, behind = (
        robot.constrained_forward_dynamics(q, qd, tau + s * step, settings=settings).wrenches for s in (1, -1)
    )
    close(derivatives.dwrenches_dtau[:, :, 7], (ahead - behind) / 2e-5, 1e-6)


def test_functions_that_a_robot_does_not_have(panda):
    with pytest.raises(ValueError, match="only robots with closed loops or contacts"):
        panda.constraint_jacobian(np.zeros(7))


def test_pictures(panda):
    svg = panda._repr_html_()
    assert svg.startswith("<svg") and "panda_joint" not in svg and "mass matrix" in svg
    q, *_ = states(panda, 20)
    animation = modyn.show(panda, q, dt=0.05)
    assert animation.page.startswith("<!doctype html>") and "0.95" in animation.page
    assert animation._repr_html_().startswith("<iframe srcdoc=")
    assert '"ground":' not in animation.page and '"ground":-0.25' in modyn.show(panda, q, ground=-0.25).page
    with pytest.raises(ValueError, match="`ground` must be finite"):
        modyn.show(panda, q, ground=np.nan)
    with pytest.raises(ValueError, match="as many times as states"):
        modyn.show(panda, q, times=[0.0, 1.0])
    with pytest.raises(ValueError, match="`trajectory`"):
        modyn.show(panda, q[:, :5])
