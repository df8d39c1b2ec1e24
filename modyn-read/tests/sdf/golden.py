"""Writes what Drake (PyPI `drake`) computes for the models of this folder, without damping.

The first lines name the joints with their numbers of coordinates and velocities. For each of three random states follow
lines with q, qd, bias forces, mass matrix by columns, and the pose of each frame (rotation by rows, then the position). States
are in modyn's conventions: a floating joint has position, quaternion x y z w, and velocities in the link's axes.
"""

import xml.etree.ElementTree as ElementTree
from importlib.metadata import version
from pathlib import Path

import numpy
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import FrameIndex, JointIndex, MultibodyForces

KINDS = {"quaternion_floating": (7, 6), "ball_rpy": (4, 3)}


def short(plant, element, outer):
    """The name within the world's only model, as `arm::elbow`, or in a world with several that move, as `left::arm::elbow`.
    Drake moves joints and frames to the models that they are attached to."""
    if element.name() in outer:
        return outer[element.name()]
    scope = plant.GetModelInstanceName(element.model_instance())
    parts = [part for part in [*scope.split("::"), element.name()] if part]
    return "::".join(parts if None in outer else parts[1:])


def outer_names(tree):
    """The full names of the joints and frames of the world's models, with `None` if several models move."""
    models = [model for path in ("model", "world/model") for model in tree.findall(path)]
    moving = [model for model in models if model.findtext("static") != "true"]
    several = len(moving) > 1
    names = {None: None} if several else {}
    for model in moving:
        for element in [*model.findall("joint"), *model.findall("frame")]:
            name = element.get("name")
            names[name] = f"{model.get('name')}::{name}" if several else name
    names.update((joint.get("name"), joint.get("name")) for joint in tree.findall("world/joint"))
    return names


def write(path):
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(str(path))
    tree = ElementTree.parse(path)
    gravity = tree.find("world/gravity")
    gravity = [0, 0, -9.81] if gravity is None else [float(word) for word in gravity.text.split()]
    plant.mutable_gravity_field().set_gravity_vector(gravity)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    outer = outer_names(tree)
    followers = {}
    for joint in tree.iter("joint"):
        mimic = joint.find("axis/mimic")
        if mimic is not None:
            number = lambda name, default: float(mimic.findtext(name, default))
            ratio = number("multiplier", 1)
            followers[joint.get("name")] = mimic.get("joint"), ratio, number("offset", 0) - ratio * number("reference", 0)
    joints = [plant.get_joint(JointIndex(i)) for i in range(plant.num_joints())]
    moving = [joint for joint in joints if joint.num_velocities() > 0]
    lines = [f"# Drake {version('drake')}: joints; q, qd, bias forces, mass matrix, poses"]
    own, nq, nv = {}, 0, 0
    for joint in moving:
        kind = joint.type_name()
        name = short(plant, joint, outer)
        if kind == "quaternion_floating":
            name = "::".join([*name.split("::")[:-1], "floating_base"] if None in outer else ["floating_base"])
        if name in followers:
            continue
        sizes = KINDS.get(kind, (joint.num_positions(), joint.num_velocities()))
        own[name] = joint, nq, nv
        nq, nv = nq + sizes[0], nv + sizes[1]
        lines.append(f"joint {name} {sizes[0]} {sizes[1]}")
    random = numpy.random.default_rng(1)
    for _ in range(3):
        q, qd = random.uniform(-1, 1, nq), random.uniform(-1, 1, nv)
        theirs = numpy.zeros(plant.num_positions())
        # The velocities are G qd, the accelerations G qdd + rest.
        g, rest = numpy.zeros((plant.num_velocities(), nv)), numpy.zeros(plant.num_velocities())
        for name, (joint, at, v) in own.items():
            kind, there, there_v = joint.type_name(), joint.position_start(), joint.velocity_start()
            if kind in KINDS:
                start = at + KINDS[kind][0] - 4
                q[start:start + 4] /= numpy.linalg.norm(q[start:start + 4])
                x, y, z, w = q[start:start + 4]
                rotation = RotationMatrix(Quaternion(numpy.array([w, x, y, z])))
            if kind == "quaternion_floating":
                theirs[there:there + 7] = [w, x, y, z, *q[at:at + 3]]
                g[there_v:there_v + 3, v + 3:v + 6] = g[there_v + 3:there_v + 6, v:v + 3] = rotation.matrix()
                rest[there_v + 3:there_v + 6] = rotation.matrix() @ numpy.cross(qd[v + 3:v + 6], qd[v:v + 3])
            elif kind == "ball_rpy":
                theirs[there:there + 3] = RollPitchYaw(rotation).vector()
                g[there_v:there_v + 3, v:v + 3] = rotation.matrix()
            else:
                n = joint.num_positions()
                theirs[there:there + n] = q[at:at + n]
                g[there_v:there_v + n, v:v + n] = numpy.eye(n)
        for name, (leader, ratio, offset) in followers.items():
            joint, (_, at, v) = plant.GetJointByName(name), own[leader]
            theirs[joint.position_start()] = ratio * q[at] + offset
            g[joint.velocity_start(), v] = ratio
        plant.SetPositions(context, theirs)
        plant.SetVelocities(context, g @ qd)
        forces = MultibodyForces(plant)
        plant.CalcForceElementsContribution(context, forces)
        damping = numpy.zeros(plant.num_velocities())
        for joint in moving:
            there = joint.velocity_start()
            damping[there:there + joint.num_velocities()] = joint.default_damping_vector()
        bias = g.T @ (plant.CalcInverseDynamics(context, rest, forces) - damping * (g @ qd))
        matrix = g.T @ plant.CalcMassMatrix(context) @ g
        for numbers in (q, qd, bias, matrix.T.flatten()):
            lines.append(" ".join(repr(float(number)) for number in numbers))
        for index in range(plant.num_frames()):
            frame = plant.get_frame(FrameIndex(index))
            body = frame.body()
            if frame.name().endswith(("__", "_parent", "_child", "_F", "_M")) or body == plant.world_body() or body.name() == "plane":
                continue
            pose = frame.CalcPoseInWorld(context)
            numbers = [*pose.rotation().matrix().flatten(), *pose.translation()]
            text = " ".join(repr(float(number)) for number in numbers)
            lines.append(f"pose {short(plant, frame, outer)} {text}")
    path.with_suffix(".txt").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    for model in ("extensions.urdf", "frames.sdf", "nested.sdf", "old.sdf", "reversed.sdf", "solids.sdf", "world.sdf"):
        write(Path(__file__).with_name(model))
