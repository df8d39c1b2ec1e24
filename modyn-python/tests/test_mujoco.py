"""The functions beside MuJoCo, from the same MJCF."""

import importlib.util
import json
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest
from conftest import GOLDEN, ROOT, chain, close, states

import modyn

# A floating base with a ball joint, hinges and a slide, in general position.
WALKER = """
<mujoco model="walker">
  <compiler angle="radian" autolimits="true"/>
  <option gravity="0.4 -0.7 -9.1"/>
  <worldbody>
    <body name="trunk" pos="0.1 0.2 0.3" quat="0.5 0.1 -0.7 0.2">
      <freejoint name="base"/>
      <inertial pos="0.02 -0.03 0.05" quat="0.9 0.1 0.3 0.2" mass="3" diaginertia="0.1 0.15 0.2"/>
      <body name="arm" pos="0.2 -0.1 0.3" quat="0.2 0.7 0.1 -0.4">
        <joint name="shoulder" type="ball"/>
        <inertial pos="0.1 0.2 -0.1" quat="0.5 -0.5 0.2 0.1" mass="1.2" diaginertia="0.03 0.02 0.04"/>
        <body name="hand" pos="0.1 0.3 -0.2" quat="0.8 0.3 0.2 0.1">
          <joint name="slider" type="slide" axis="0.6 0 0.8" armature="0.3"/>
          <inertial pos="0.03 -0.05 0.02" mass="0.6" fullinertia="0.01 0.012 0.013 0.001 -0.002 0.0015"/>
        </body>
      </body>
      <body name="leg" pos="-0.3 0.1 -0.2" quat="0.3 -0.2 0.8 0.4">
        <joint name="hip" type="hinge" axis="0 0.6 0.8" armature="0.2"/>
        <inertial pos="0.05 0.02 -0.2" quat="0.7 0.1 0.1 0.6" mass="2" diaginertia="0.05 0.06 0.02"/>
        <body name="foot" pos="0.1 -0.1 -0.4" quat="0.6 0.4 -0.3 0.2">
          <joint name="knee" type="hinge" axis="0.8 0 -0.6"/>
          <inertial pos="0 0.1 -0.1" mass="0.8" diaginertia="0.01 0.02 0.015"/>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


@pytest.fixture
def both():
    robot = modyn.loads(WALKER, file="walker.xml")
    model = mujoco.MjModel.from_xml_string(WALKER)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    return robot, model, mujoco.MjData(model), modyn.conventions.MuJoCo(robot, model)


def test_dynamics(both):
    robot, model, data, theirs = both
    close(robot.gravity, model.opt.gravity)
    q, qd, qdd, tau = states(robot, 7)
    accelerations = robot.forward_dynamics(q, qd, tau)
    forces = robot.inverse_dynamics(q, qd, qdd)
    for i in range(len(q)):
        data.qpos[:], data.qvel[:] = theirs.to_qpos(q[i]), theirs.to_qvel(q[i], qd[i])
        data.qfrc_applied[:] = theirs.to_qfrc(q[i], tau[i])
        mujoco.mj_forward(model, data)
        close(accelerations[i], theirs.from_qacc(q[i], qd[i], data.qacc), 1e-8)
        close(robot.link_pose(q[i], "foot").translation, data.body("foot").xpos)
        close(robot.link_pose(q[i], "hand").rotation, data.body("hand").xmat.reshape(3, 3))
        data.qfrc_applied[:] = 0
        data.qacc[:] = theirs.to_qacc(q[i], qd[i], qdd[i])
        mujoco.mj_inverse(model, data)
        close(forces[i], theirs.from_qfrc(q[i], data.qfrc_inverse), 1e-9)


def described(name, base):
    """Returns MuJoCo's model of a real robot's URDF, without friction; a floating base is a joint of the world."""
    tree = ElementTree.parse(GOLDEN / f"{name}.urdf").getroot()
    ElementTree.SubElement(ElementTree.SubElement(tree, "mujoco"), "compiler", fusestatic="false")
    if base == "floating":
        children = {joint.find("child").get("link") for joint in tree.findall("joint")}
        root = next(link.get("name") for link in tree.findall("link") if link.get("name") not in children)
        ElementTree.SubElement(tree, "link", name="world")
        joint = ElementTree.SubElement(tree, "joint", name="free", type="floating")
        ElementTree.SubElement(joint, "parent", link="world")
        ElementTree.SubElement(joint, "child", link=root)
    model = mujoco.MjSpec.from_string(ElementTree.tostring(tree, encoding="unicode")).compile()
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    model.dof_damping[:] = 0
    return model


@pytest.mark.parametrize("name, base", [("panda", "fixed"), ("solo12", "floating"), ("g1", "floating")])
def test_real_robots(name, base):
    """The same URDF in both: the mass matrix, the bias forces and the accelerations of moving states."""
    robot = modyn.load(GOLDEN / f"{name}.urdf", base=base, joint_friction="none")
    model = described(name, base)
    data, theirs = mujoco.MjData(model), modyn.conventions.MuJoCo(robot, model)
    close(robot.gravity, model.opt.gravity)
    q, qd, _, tau = states(robot, 5, seed=3)
    accelerations, mass = robot.forward_dynamics(q, qd, tau), robot.mass_matrix(q)
    zero = np.zeros(robot.nv)
    for i in range(len(q)):
        data.qpos[:], data.qvel[:] = theirs.to_qpos(q[i]), theirs.to_qvel(q[i], qd[i])
        data.qfrc_applied[:] = theirs.to_qfrc(q[i], tau[i])
        mujoco.mj_forward(model, data)
        close(accelerations[i], theirs.from_qacc(q[i], qd[i], data.qacc), 1e-8)
        # Forces of unit velocities: the columns of both mass matrices, in the frames of modyn.
        for k, unit in enumerate(np.eye(robot.nv)):
            column = np.zeros(model.nv)
            mujoco.mj_mulM(model, data, column, theirs.to_qvel(q[i], unit))
            close(mass[i][:, k], theirs.from_qfrc(q[i], column), 1e-9)
        # A free joint has another acceleration there: the derivative of its velocity in world axes.
        data.qacc[:] = theirs.to_qacc(q[i], qd[i], zero)
        data.qfrc_applied[:] = 0
        mujoco.mj_inverse(model, data)
        close(robot.bias_forces(q[i], qd[i]), theirs.from_qfrc(q[i], data.qfrc_inverse), 1e-9)


def test_states_there_and_back(both):
    robot, _, _, theirs = both
    q, qd, qdd, tau = states(robot, 5, seed=4)
    close(theirs.from_qpos(theirs.to_qpos(q)), q)
    close(theirs.from_qvel(q, theirs.to_qvel(q, qd)), qd)
    close(theirs.from_qacc(q, qd, theirs.to_qacc(q, qd, qdd)), qdd)
    close(theirs.from_qfrc(q, theirs.to_qfrc(q, tau)), tau)
    # One state is a row of many.
    close(theirs.to_qacc(q[2], qd[2], qdd[2]), theirs.to_qacc(q, qd, qdd)[2])
    with pytest.raises(ValueError, match="`q` has the shape"):
        theirs.to_qpos(q[:, 1:])


def test_another_model_is_refused(panda):
    model = mujoco.MjModel.from_xml_string(WALKER)
    with pytest.raises(ValueError, match="no revolute joint `panda_joint1`"):
        modyn.conventions.MuJoCo(panda, model)
    assert np.isfinite(panda.neutral()).all()


def test_keyframes_are_mujocos():
    keys = """<actuator><position name="held" joint="hip" kp="20"/><general joint="knee" dyntype="filter" dynprm="0.1"/></actuator>
        <keyframe><key name="home" qpos="1 2 3  .5 .5 .5 -.5  .8 .1 -.2 .3  .1 .2 .3" qvel="1 2 3 4 5 6  7 8 9  -1 -2 -3" ctrl="0.4 0.5"
        act="0.25"/><key name="drawn"/></keyframe></mujoco>"""
    text = WALKER.replace("</mujoco>", keys).replace("<option", '<option timestep="0.005"')
    robot, model = modyn.loads(text, file="walker.xml"), mujoco.MjModel.from_xml_string(text)
    conventions = modyn.conventions.MuJoCo(robot, model)
    assert list(robot.keyframes) == ["home", "drawn"]
    assert robot.time_step == model.opt.timestep == 0.005
    for name, key in robot.keyframes.items():
        assert (robot.keyframe(name).q == key.q).all()
        robot.check_configuration(key.q)
        theirs = model.key(name)
        assert np.allclose(conventions.to_qpos(key.q), theirs.qpos, rtol=0, atol=1e-12)
        assert np.allclose(conventions.to_qvel(key.q, key.qd), theirs.qvel, rtol=0, atol=1e-12)
        assert (key.ctrl == theirs.ctrl).all() and (key.act == theirs.act).all()
    with pytest.raises(KeyError, match="`away`; there are: home, drawn"):
        robot.keyframe("away")
    single = modyn.loads(text, file="walker.xml", scalar="f32")
    assert single.keyframe("home").ctrl.dtype == np.float32


def test_schema():
    """The compiler's table of MJCF is tested with the schema of this MuJoCo."""
    folder = ROOT / "modyn-read" / "tests" / "mjcf"
    spec = importlib.util.spec_from_file_location("schema", folder / "schema.py")
    schema = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(schema)
    assert schema.FILE.read_text() == schema.schema()


def test_a_saved_motor_has_the_same_limit():
    """MuJoCo saves a `<motor>` as `<general>`."""
    text = """
    <mujoco model="m"><worldbody><body><joint name="j" axis="0 1 0"/><geom size="0.1" pos="0.2 0 0"/></body></worldbody>
      <actuator>{}</actuator></mujoco>"""
    for actuator in ('<motor joint="j" gear="50" ctrlrange="-2 2"/>', '<general joint="j" gainprm="30" ctrlrange="-2 2"/>'):
        spec = mujoco.MjSpec.from_string(text.format(actuator))
        data = mujoco.MjData(model := spec.compile())
        data.ctrl[:] = 1e6
        mujoco.mj_forward(model, data)
        saved = spec.to_xml()
        assert "<motor" not in saved
        for description in (text.format(actuator), saved):
            close(modyn.loads(description, file="m.xml").limits.effort, data.qfrc_actuator)


@pytest.mark.parametrize("flag", ["limit", "spring", "damper", "frictionloss", "constraint", "equality", "gravity", "spring damper"])
def test_switches(flag):
    """The joint forces without controls, with a switch off."""
    switches = " ".join(f'{name}="disable"' for name in flag.split())
    text = f"""
    <mujoco model="m"><option><flag {switches}/></option><worldbody>
      <body name="a" gravcomp="0.5"><joint name="a" axis="0 1 0" damping="0.5" frictionloss="0.3" stiffness="3" springref="30"/>
        <geom size="0.1" pos="0.2 0 0"/></body>
      <body name="b"><joint name="b" axis="0 1 0" armature="0.1"/><geom size="0.1" pos="0.2 0 0"/></body></worldbody>
      <equality><joint joint1="b" joint2="a" polycoef="0 2 0 0 0"/></equality></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    couples = flag not in ("constraint", "equality")
    robot = modyn.loads(text, file="m.xml", joint_friction="coulomb")
    assert robot.nv == (1 if couples else 2)
    data.qvel[0] = 1
    mujoco.mj_forward(model, data)
    bias = robot.bias_forces(np.zeros(robot.nv), np.eye(robot.nv)[0])
    loss = 0 if flag in ("frictionloss", "constraint") else 0.3
    theirs = data.qfrc_bias - data.qfrc_passive
    close(bias[0] - loss, theirs[0] + (2 * theirs[1] if couples else 0))


GRIPPER = """
<mujoco model="gripper">
  <worldbody><body name="palm"><joint {wrist} axis="0 0 1"/><inertial pos="0.01 0.02 0.03" mass="1" diaginertia="0.01 0.01 0.01"/>
    <body name="l" pos="0 0.1 0"><joint name="left" type="slide" axis="0 1 0"/><inertial pos="0 0 0.05" mass="0.2" diaginertia="0.001 0.001 0.001"/>
      <body name="tip" pos="0 0 0.1"><joint type="ball"/><inertial pos="0.1 0 0" mass="0.1" diaginertia="0.002 0.002 0.001"/></body>
    </body>
    <body name="r" pos="0 -0.1 0"><joint name="right" type="slide" axis="0 -1 0"/><inertial pos="0 0 0.05" mass="0.2" diaginertia="0.001 0.001 0.001"/></body>
  </body></worldbody>
  <equality><joint joint1="right" joint2="left" polycoef="0.01 0.7 0 0 0"/></equality>
</mujoco>
"""


@pytest.mark.parametrize("wrist", ['name="wrist"', ""])
def test_mimic_joints_and_joints_without_a_name(wrist):
    text = GRIPPER.format(wrist=wrist)
    robot = modyn.loads(text, file="gripper.xml", joint_friction="none")
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    assert (robot.nv, model.nv) == (5, 6)
    theirs = modyn.conventions.MuJoCo(robot, model)
    q, qd, qdd, tau = states(robot, 6)
    close(theirs.from_qpos(theirs.to_qpos(q)), q)
    close(theirs.from_qvel(q, theirs.to_qvel(q, qd)), qd)
    close(theirs.from_qacc(q, qd, theirs.to_qacc(q, qd, qdd)), qdd)
    close(theirs.from_qfrc(q, theirs.to_qfrc(q, tau)), tau)
    mass = np.zeros((model.nv, model.nv))
    for i in range(len(q)):
        data.qpos[:], data.qvel[:] = theirs.to_qpos(q[i]), theirs.to_qvel(q[i], qd[i])
        mujoco.mj_forward(model, data)
        poses = robot.link_poses(q[i])
        for name in ("palm", "l", "tip", "r"):
            close(poses.translation[robot.link_names.index(name)], data.body(name).xpos)
        mujoco.mj_fullM(model, data, mass)
        # Of the accelerations alone: a mimic joint's force acts on its leader.
        close(theirs.from_qfrc(q[i], mass @ theirs.to_qacc(q[i], 0 * qd[i], qdd[i])), robot.mass_matrix(q[i]) @ qdd[i])
        close(theirs.to_qvel(q[i], qd[i]) @ (mass @ theirs.to_qvel(q[i], qd[i])), qd[i] @ robot.mass_matrix(q[i]) @ qd[i])


def test_joints_that_do_not_fit_are_named():
    text = GRIPPER.format(wrist="")
    robot = modyn.loads(text, file="gripper.xml", joint_friction="none")
    other = mujoco.MjModel.from_xml_string(text.replace('<joint  axis="0 0 1"/>', '<joint type="slide" axis="0 0 1"/>'))
    with pytest.raises(ValueError, match="next joint without a name of MuJoCo's model, which is prismatic, have other types: give the joints"):
        modyn.conventions.MuJoCo(robot, other)
    without = mujoco.MjModel.from_xml_string(text.replace('name="right"', 'name="other"').replace('joint1="right"', 'joint1="other"'))
    with pytest.raises(ValueError, match="no coordinates of MuJoCo's joint `other`"):
        modyn.conventions.MuJoCo(robot, without)


def solve_exactly(model, step):
    """Lets MuJoCo solve each step of this time to the end."""
    model.opt.timestep, model.opt.tolerance, model.opt.ls_tolerance = step, 0, 1e-12
    model.opt.iterations, model.opt.ls_iterations = 300, 100


def of_golden(file, scene):
    """Returns a scene of the reference data, its robot, MuJoCo's model and the settings, whose steps are solved to the end."""
    case = json.loads((GOLDEN / f"{file}.json").read_text())[scene]
    robot = modyn.loads(case["mjcf"], file="floor.xml", unsupported_forces="warn", mimic="independent")
    model = mujoco.MjModel.from_xml_string(case["mjcf"])
    solve_exactly(model, case["step"])
    settings = robot.step_settings()
    settings.tolerance = 1e-13
    return case, robot, model, settings


@pytest.mark.parametrize("scene", range(48))
@pytest.mark.filterwarnings("ignore:.*in `step`")
def test_motions_on_a_floor(scene):
    """Motions of 50 steps of random robots over planes, each step from the accelerations of the last one; some joints have
    ranges narrower than twice their margin, so that both limits act."""
    case, robot, model, settings = of_golden("floors", scene)
    data, theirs = mujoco.MjData(model), modyn.conventions.MuJoCo(robot, model)
    assert len(settings.surfaces) == len(robot.touching_shape_names) > 0
    start = case["states"][0]
    q, qd, tau = (np.array(start[name]) for name in ("q", "qd", "tau"))
    data.qpos[:], data.qvel[:] = theirs.to_qpos(q), theirs.to_qvel(q, qd)
    # Forces on joints alone are the same in both orders of a free base.
    data.qfrc_applied[:] = tau
    qdd = np.zeros(robot.nv)
    for _ in range(50):
        x = robot.step(q, qd, tau, case["step"], qdd, settings)
        mujoco.mj_step(model, data)
        q, qd, qdd = x.q, x.qd, x.qdd
        velocity = theirs.to_qvel(q, qd)
        assert abs(velocity - data.qvel).max() <= 1e-6 * max(1, abs(data.qvel).max())
    close(theirs.to_qpos(q), data.qpos, 1e-6)


# A floating robot with a shape of each kind, in general position.
COLLISIONS = """
<robot name="r">
  <link name="trunk">
    <inertial><origin xyz="0.01 0.02 0.03"/><mass value="2"/>
      <inertia ixx="0.02" iyy="0.03" izz="0.025" ixy="0.001" ixz="0.002" iyz="-0.001"/></inertial>
    <collision name="hull"><origin xyz="0.1 0.02 0.03" rpy="0.3 -0.4 0.5"/><geometry><box size="0.2 0.3 0.1"/></geometry></collision>
    <collision><origin xyz="-0.1 0.1 0.2"/><geometry><sphere radius="0.1"/></geometry></collision>
  </link>
  <joint name="hip" type="continuous"><parent link="trunk"/><child link="leg"/><origin xyz="0.1 0 -0.2" rpy="0.1 0.2 0.3"/>
    <axis xyz="0 1 0"/></joint>
  <link name="leg">
    <inertial><origin xyz="0 0.01 -0.1"/><mass value="1"/><inertia ixx="0.01" iyy="0.012" izz="0.011" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0 -0.2" rpy="0.2 0.7 -0.1"/><geometry><capsule radius="0.05" length="0.3"/></geometry></collision>
  </link>
  <joint name="ankle" type="fixed"><parent link="leg"/><child link="foot"/><origin xyz="0.05 0 -0.3" rpy="0.3 0.1 0.2"/></joint>
  <link name="foot">
    <inertial><origin xyz="0.02 0 0.01"/><mass value="0.3"/><inertia ixx="0.001" iyy="0.002" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision name="sole"><origin xyz="0.1 0 0" rpy="0 0.3 0"/><geometry><cylinder radius="0.1" length="0.05"/></geometry></collision>
  </link>
  <link name="world"/>
  <joint name="free" type="floating"><parent link="world"/><child link="trunk"/></joint>
</robot>
"""


@pytest.mark.parametrize("seed", range(6))
def test_collisions_of_a_urdf_touch_the_ground(seed):
    """MuJoCo reads the same URDF, and gets a plane: motions of 50 steps."""
    point, normal = [0.1, -0.2, 0.05], [0.1, -0.2, 1.3]
    robot = modyn.loads(COLLISIONS, ground=("plane", point, normal))
    assert robot.touching_shape_names == ["hull", "trunk_collision_1", "leg_collision_1", "sole"]
    # A link that is fixed to another one keeps a mobility of its own.
    compiler = '<mujoco><compiler fusestatic="false"/></mujoco></robot>'
    spec = mujoco.MjSpec.from_string(COLLISIONS.replace("</robot>", compiler))
    # Links of the robot do not touch each other.
    for geom in spec.geoms:
        geom.conaffinity = 0
    plane = spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1], pos=point, contype=0)
    plane.alt.type, plane.alt.zaxis = mujoco.mjtOrientation.mjORIENTATION_ZAXIS, normal
    model = spec.compile()
    solve_exactly(model, 0.002)
    data = mujoco.MjData(model)
    theirs = modyn.conventions.MuJoCo(robot, model)
    settings = robot.step_settings()
    settings.tolerance = 1e-13
    [q], [qd], _, _ = states(robot, 1, seed=seed)
    q[:3], tau = [0, 0, 0.3], np.zeros(robot.nv)
    data.qpos[:], data.qvel[:] = theirs.to_qpos(q), theirs.to_qvel(q, qd)
    qdd, touching = np.zeros(robot.nv), 0
    for _ in range(50):
        x = robot.step(q, qd, tau, 0.002, qdd, settings)
        mujoco.mj_step(model, data)
        q, qd, qdd = x.q, x.qd, x.qdd
        touching += data.ncon > 0
        velocity = theirs.to_qvel(q, qd)
        assert abs(velocity - data.qvel).max() <= 1e-6 * max(1, abs(data.qvel).max())
    assert touching > 10


@pytest.mark.parametrize("seed", range(6))
def test_actuators_of_a_urdf(seed):
    """The option `actuators` beside `<position>`, `<velocity>` and `<motor>`: MuJoCo reads the same URDF, whose spheres fall onto a
    plane. Some forces are at their limits."""
    sphere = '<collision><origin xyz="0.05 -0.1 0.02"/><geometry><sphere radius="0.1"/></geometry></collision></link>'
    text = chain(seed, joints=6).replace("</inertial></link>", "</inertial>" + sphere)
    free = '<link name="world"/><joint name="free" type="floating"><parent link="world"/><child link="base"/></joint>'
    text = text.replace("</robot>", free + "</robot>")
    actuators = {
        "joint0": ("position", 60, 2),
        "joint1": ("position", 60, 2),
        "*2": ("velocity", 3, {"effort": 25}),
        "joint3": ("position", 200, 5, {"effort": 8}),
        "j*4": "motor",
    }
    robot = modyn.loads(text, ground="plane", actuators=actuators, joint_friction="none")
    assert robot.control_names == [name for name in robot.velocity_names if name in [f"joint{k}" for k in range(5)]]
    spec = mujoco.MjSpec.from_string(text.replace("</robot>", '<mujoco><compiler fusestatic="false"/></mujoco></robot>'))
    for geom in spec.geoms:
        geom.conaffinity = 0
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1], contype=0)
    efforts = {"joint2": 25, "joint3": 8}
    for name in robot.control_names:
        # The effort limit of the URDF is 10; the option replaces it.
        effort = efforts.get(name, 10)
        spec.joint(name).actfrcrange, spec.joint(name).actfrclimited = [-effort, effort], True
        actuator = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        actuator.forcerange = [-effort, effort]
        if name == "joint2":
            actuator.set_to_velocity(kv=3)
        elif name == "joint4":
            actuator.set_to_motor()
        else:
            kp, kv = (200, 5) if name == "joint3" else (60, 2)
            actuator.set_to_position(kp=kp, kv=kv)
    model = spec.compile()
    solve_exactly(model, 0.002)
    data = mujoco.MjData(model)
    theirs = modyn.conventions.MuJoCo(robot, model)
    settings = robot.step_settings()
    settings.tolerance = 1e-13
    [q], [qd], _, _ = states(robot, 1, seed=seed)
    controls = np.random.default_rng(seed).normal(size=(50, 5)) * np.where(np.array(robot.control_names) == "joint4", 12, 1)
    q[:3] = [0, 0, 0.0]
    data.qpos[:], data.qvel[:] = theirs.to_qpos(q), theirs.to_qvel(q, qd)
    motion = robot.rollout(q, qd, controls, 0.002, step="actuated", settings=settings)
    limited, touching = 0, 0
    for k, ctrl in enumerate(controls):
        data.ctrl[:] = ctrl
        mujoco.mj_step(model, data)
        velocity = theirs.to_qvel(motion.q[k], motion.qd[k])
        assert abs(velocity - data.qvel).max() <= 1e-6 * max(1, abs(data.qvel).max()), k
        limited += (abs(data.actuator_force) == [efforts.get(name, 10) for name in robot.control_names]).sum()
        touching += data.ncon > 0
    close(theirs.to_qpos(motion.q[-1]), data.qpos, 1e-6)
    assert 10 < limited < 240 and touching > 5


@pytest.mark.parametrize("scene", range(19))
@pytest.mark.filterwarnings("ignore:.*in `step`")
def test_motions_under_controls(scene):
    """Motions of 50 steps of random robots over planes with actuators of all kinds, by each integrator. Each step starts from
    the accelerations and the activations of the last one."""
    case, robot, model, settings = of_golden("actuated", scene)
    data, theirs = mujoco.MjData(model), modyn.conventions.MuJoCo(robot, model)
    start = case["states"][0]
    q, qd, ctrl, act, applied = (np.array(start[name]) for name in ("q", "qd", "ctrl", "act", "applied"))
    data.qpos[:], data.qvel[:], data.act[:] = theirs.to_qpos(q), theirs.to_qvel(q, qd), act
    data.qfrc_applied[:] = applied
    controls = ctrl * np.cos(0.1 * np.arange(50))[:, None]
    motion = robot.rollout(q, qd, controls, case["step"], step="actuated", act=act, applied=applied, settings=settings)
    qdd = np.zeros(robot.nv)
    for k, ctrl in enumerate(controls):
        x = robot.step_actuated(q, qd, ctrl, case["step"], act, applied, qdd, settings)
        data.ctrl[:] = ctrl
        mujoco.mj_step(model, data)
        q, qd, act, qdd = x.q, x.qd, x.act, x.qdd
        velocity = theirs.to_qvel(q, qd)
        assert abs(velocity - data.qvel).max() <= 1e-6 * max(1, abs(data.qvel).max()), k
        close(act, data.act, 1e-6)
        for found, expected in zip(motion, x):
            close(found[k], expected, 1e-7)
    close(theirs.to_qpos(q), data.qpos, 1e-6)


@pytest.mark.parametrize("scene", (1, 2, 10))
@pytest.mark.filterwarnings("ignore:.*in `step`")
def test_derivatives_under_controls(scene):
    """A and B of the first step of these robots, beside MuJoCo's differences."""
    case, robot, model, settings = of_golden("actuated", scene)
    data, theirs = mujoco.MjData(model), modyn.conventions.MuJoCo(robot, model)
    n, compared = robot.nv, 0

    def to_theirs(q, qd):
        """Returns the matrix from changes of a state to MuJoCo's, whose free joints have linear displacements and velocities in
        the world."""
        matrix = np.eye(2 * n + len(act))
        for k, unit in enumerate(np.eye(n)):
            matrix[:n, k] = matrix[n : 2 * n, n + k] = theirs.to_qvel(q, unit)
            ends = (theirs.to_qvel(robot.integrate(q, change * unit), qd) for change in (1e-5, -1e-5))
            matrix[n : 2 * n, k] = np.subtract(*ends) / 2e-5
        return matrix

    for start in case["states"]:
        q, qd, ctrl, act, applied = (np.array(start[name]) for name in ("q", "qd", "ctrl", "act", "applied"))
        x = robot.step_actuated_derivatives(q, qd, ctrl, case["step"], act, applied, None, settings)
        states = 2 * n + len(act)
        fine, coarse = (np.zeros((states, states + len(ctrl))) for _ in range(2))
        for columns, change in ((fine, 1e-6), (coarse, 4e-6)):
            data.qpos[:], data.qvel[:], data.act[:] = theirs.to_qpos(q), theirs.to_qvel(q, qd), act
            data.ctrl[:], data.qfrc_applied[:], data.qacc_warmstart[:] = ctrl, applied, 0
            by_state, by_control = np.zeros((states, states)), np.zeros((states, len(ctrl)))
            mujoco.mjd_transitionFD(model, data, change, True, by_state, by_control, None, None)
            columns[:] = np.concatenate([by_state, by_control], 1)
        columns = to_theirs(x.q, x.qd) @ np.concatenate([x.a @ np.linalg.inv(to_theirs(q, qd)), x.b], 1)
        # Where two laws meet there are two derivatives, and differences are between them.
        smooth = (np.abs(fine - coarse) <= 1e-4 * (1 + np.abs(fine))).all(0)
        # Of controls beyond their range the differences are zero, also where the range does not act.
        low, high = model.actuator_ctrlrange.T
        smooth[states:] &= ~(model.actuator_ctrllimited.astype(bool) & ((ctrl < low) | (ctrl > high)))
        assert np.abs(fine - columns)[:, smooth].max(initial=0) <= 1e-3 * (1 + np.abs(fine).max())
        compared += smooth.sum()
    assert compared > 0.5 * len(case["states"]) * (states + len(ctrl))
