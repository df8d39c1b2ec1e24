"""Messages for users of Python: each names the place, what is wrong and what would be right, and following it works."""

import pathlib
import re
import zipfile

import numpy as np
import pytest
from conftest import close

import modyn

ARM = (
    '<robot name="arm"><link name="b"/><link name="a"><inertial><origin xyz="0.1 0 0"/><mass value="1"/>'
    '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link><joint name="j" type="revolute">'
    '<parent link="b"/><child link="a"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'
)
TIP = {"tip": ("point", "a", [0, 0, 0])}


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(ARM)
    return path


@pytest.mark.parametrize("text", [ARM, "\n  " + ARM, ARM.replace("><", ">\n<"), ARM * 20, ARM.encode()])
def test_load_of_a_text_names_loads(text):
    with pytest.raises(ValueError, match="use `modyn.loads`") as error:
        modyn.load(text)
    assert len(str(error.value)) < 200
    assert modyn.loads(ARM).nq == 1


def test_load_takes_paths_of_every_kind(file):
    for path in (file, str(file), bytes(file)):
        assert modyn.load(path).nq == 1


def test_loads_of_a_path_names_load(file):
    for path in (str(file), "arm.urdf", "folder/model.xml"):
        with pytest.raises(ValueError, match="use `modyn.load` for the path of a file") as error:
            modyn.loads(path)
        assert path in str(error.value)
    for other, kind in ((file, type(file).__name__), (ARM.encode(), "bytes"), (None, "NoneType")):
        with pytest.raises(TypeError, match=f"not {kind}; `modyn.load` takes the path"):
            modyn.loads(other)


def test_options_take_paths_and_types_of_numpy(file):
    robot = modyn.load(file, packages={"x": pathlib.Path(".")}, joint_friction="none")
    assert robot.nq == 1
    for scalar in (np.float32, np.dtype("float32"), "f32"):
        assert modyn.load(file, scalar=scalar).dtype == np.float32
    for scalar in (float, np.float64, "f64"):
        assert modyn.load(file, scalar=scalar).dtype == np.float64
    assert np.array_equal(modyn.load(file, gravity=np.array([0, 0, -1.62], np.float32)).gravity, np.float32([0, 0, -1.62]).astype(float))
    assert modyn.load(file, runtime_gravity=np.True_).set_gravity([0, 0, -1]) is None


@pytest.mark.parametrize("name, value", [("packages", object()), ("scalar", np.int32), ("xacro_args", "m:=3"), ("gravity", object()), ("contacts", {"tip": object()})])
def test_options_of_another_form_show_the_value_and_an_example(file, name, value):
    with pytest.raises(ValueError, match=f"option `{name}`: .*for example {name}=|option `{name}`: .*its form is"):
        modyn.load(file, **{name: value})


def test_arguments_of_xacro_by_the_example(tmp_path):
    path = tmp_path / "arm.xacro"
    path.write_text(ARM.replace("<robot ", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" ').replace('<link name="b"/>', '<xacro:arg name="m" default="1"/><link name="b"/>').replace('mass value="1"', 'mass value="$(arg m)"'))
    with pytest.raises(ValueError, match="option `xacro_args`") as error:
        modyn.load(path, xacro_args="m:=3")
    example = re.search(r"xacro_args=(\{.*\})", str(error.value))[1]
    assert eval(example)  # noqa: S307
    assert modyn.load(path, xacro_args={"m": 3}).parameters[0] == 3


def test_joints_stop_in_steps():
    robot = modyn.loads(ARM, joint_friction="none")
    still = np.zeros(1)
    # Soft limits give way a little.
    moved = robot.rollout(still, still + 5, np.zeros((500, 1)), 0.001, step="step")
    assert 1 < moved.q.max() < 1.05 and moved.q[-1] < 1
    motion = robot.simulate(lambda *_: still, still, still + 5, 0.001, 500)
    assert np.allclose(motion.q, moved.q, rtol=0, atol=1e-9)


def test_active_contacts_by_name():
    robot = modyn.loads(ARM, joint_friction="none", contacts=TIP)
    z = np.zeros(1)
    for other in ([True, False], np.zeros(0), np.array([0.5, 0.5]), [["tip"]], {"tip": 1}):
        with pytest.raises((TypeError, ValueError), match=r"active contacts are names, as in `\[\"left\", \"right\"\]`, or booleans in the order of `contact_names`"):
            robot.constrained_forward_dynamics(z, z, z, other)
    with pytest.raises(ValueError, match="`active` of `constrained_forward_dynamics` names `top`, which is no contact of this robot; `contact_names` has `tip`"):
        robot.constrained_forward_dynamics(z, z, z, ["top"])


def test_settings_of_another_robot_or_function():
    robot = modyn.loads(ARM, joint_friction="none", contacts=TIP)
    z = np.zeros(1)
    two = modyn.ConstraintSettings(targets=[modyn.ContactTarget()] * 2)
    with pytest.raises(ValueError, match="`settings` of `constrained_forward_dynamics` has 2 targets; expected one for each name of `contact_names`"):
        robot.constrained_forward_dynamics(z, z, z, settings=two)
    with pytest.raises(ValueError, match=r"`settings` of `step` has 0 surfaces; expected those that `step_settings\(\)` has, in their order"):
        robot.step(z, z, z, 1e-3, settings=modyn.StepSettings())
    with pytest.raises(TypeError, match="`settings` of `step` is a `ConstraintSettings`; expected `StepSettings`"):
        robot.step(z, z, z, 1e-3, settings=two)
    with pytest.raises(TypeError, match="`settings` of `constrained_forward_dynamics` is a `StepSettings`; expected `ConstraintSettings`"):
        robot.constrained_forward_dynamics(z, z, z, settings=robot.step_settings())
    # As the messages say.
    one = modyn.ConstraintSettings(targets=[modyn.ContactTarget() for _ in robot.contact_names])
    assert np.isfinite(robot.constrained_forward_dynamics(z, z, z, settings=one).qdd).all()
    assert np.isfinite(robot.step(z, z, z, 1e-3, settings=robot.step_settings()).qdd).all()


@pytest.mark.parametrize("machine_code", [True, False])
def test_active_contacts_by_name_are_those_by_booleans(machine_code):
    points = {name: ("point", "a", [0.1 * i, 0, 0]) for i, name in enumerate(("left", "middle", "right"), 1)}
    robot = modyn.loads(ARM, joint_friction="none", contacts=points, machine_code=machine_code)
    q, zero = np.full(1, 0.3), np.zeros(1)
    for names in ([], ["left"], ["right", "left"], ("middle",), "middle", np.array(["left", "right"]), list(robot.contact_names)):
        named = [names] if isinstance(names, str) else list(names)
        active = np.array([float(name in named) for name in robot.contact_names])
        found, expected = (robot.constrained_forward_dynamics(q, zero, zero, contacts) for contacts in (names, active))
        for one, other in zip(found, expected):
            np.testing.assert_array_equal(one, other)
    # One set holds for each of several states.
    many = robot.constrained_forward_dynamics(np.full((3, 1), 0.3), np.zeros((3, 1)), np.zeros((3, 1)), ["left"])
    one = robot.constrained_forward_dynamics(q, zero, zero, ["left"])
    np.testing.assert_allclose(many[0], np.stack([one[0]] * 3))


def test_an_inertia_as_a_matrix():
    robot = modyn.loads(ARM, payload=["a"], joint_friction="none")
    with pytest.raises(ValueError, match=r"`inertia` of `set_payload` has the shape \(3, 3\); expected \(6,\): ixx, ixy, ixz, iyy, iyz, izz$"):
        robot.set_payload("a", 1.0, [0, 0, 0], np.eye(3))
    robot.set_payload("a", 1.0, [0, 0, 0], [1, 0, 0, 1, 0, 1])
    with pytest.raises(ValueError, match=r"`center_of_mass` of `set_payload` has the shape \(2, 3\); expected \(3,\)$"):
        robot.set_payload("a", 1.0, np.zeros((2, 3)))


def test_other_kinds_of_files(tmp_path):
    pointer = tmp_path / "pointer.urdf"
    pointer.write_text("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n")
    with pytest.raises(modyn.DescriptionError, match="pointer of Git LFS.*(\n.*)*git lfs pull"):
        modyn.load(pointer)
    archive = tmp_path / "arm.mjz"
    with zipfile.ZipFile(archive, "w") as files:
        files.writestr("arm.xml", "<mujoco/>")
    with pytest.raises(modyn.DescriptionError, match="zip archive.*(\n.*)*unzip"):
        modyn.load(archive)


def test_parameters_and_gravity_follow_changes():
    robot = modyn.loads(ARM, runtime_inertia=["a"], payload=["a"], runtime_gravity=True, joint_friction="none")
    described = robot.parameters
    q, qd, qdd = [0.3], [0.7], [1.1]
    balanced = lambda: close(robot.regressor(q, qd, qdd) @ robot.parameters, robot.inverse_dynamics(q, qd, qdd), 1e-13)
    balanced()
    robot.set_gravity([0, 0, -1.62])
    assert np.array_equal(robot.gravity, [0, 0, -1.62])
    robot.set_inertia("a", 3.0, [0.1, 0.2, 0], [1, 0, 0.1, 1, 0, 1.2])
    balanced()
    robot.set_payload("a", 2.0, [0.3, 0, 0.1])
    balanced()
    base = robot.base_parameters()
    close(robot.regressor(q, qd, qdd)[:, base.columns] @ base.values, robot.inverse_dynamics(q, qd, qdd), 1e-12)
    robot.set_payload("a", 0.0)
    robot.set_inertia("a", 1.0, [0.1, 0, 0], [1, 0, 0, 1, 0, 1])
    close(robot.parameters, described, 1e-15)


def snake(joints):
    """Returns the URDF of a chain."""
    link = '<link name="l{}"><inertial><origin xyz="0.03 0 0"/><mass value="0.3"/><inertia ixx="1e-4" ixy="0" ixz="0" iyy="2e-4" iyz="0" izz="2e-4"/></inertial></link>'
    joint = '<joint name="j{0}" type="continuous"><parent link="l{0}"/><child link="l{1}"/><origin xyz="0.06 0 0"/><axis xyz="0 {2} {3}"/></joint>'
    joints = [joint.format(i, i + 1, i % 2, 1 - i % 2) for i in range(joints)]
    return '<robot name="snake">' + "".join(link.format(i) for i in range(len(joints) + 1)) + "".join(joints) + "</robot>"


def test_functions_that_are_too_long_are_interpreted():
    robot = modyn.loads(snake(100), base="floating", payload=["l50"])
    q, z = robot.neutral(), np.zeros(robot.nv)
    with pytest.warns(modyn.MachineCodeWarning, match="`forward_dynamics_derivatives` of 101 joints is too long"):
        found = robot.forward_dynamics_derivatives(q, z, z)
    for mass in (0.0, 0.2):
        robot.set_payload("l50", mass)
        found = robot.forward_dynamics_derivatives(q, z, z)
        close(found.qdd, robot.forward_dynamics(q, z, z), 1e-7)
        many = robot.forward_dynamics_derivatives(np.stack([q, q]), z, z)
        assert np.array_equal(many.dqdd_dq[1], found.dqdd_dq)
        step = 1e-6
        dq = z.copy()
        dq[40] = 1.0
        ends = [robot.forward_dynamics(robot.integrate(q, sign * step * dq), z, z) for sign in (1, -1)]
        close(found.dqdd_dq[:, 40], (ends[0] - ends[1]) / (2 * step), 1e-4)
