"""Writes MuJoCo's binary model from the output of pinocchio_model.py.

The inertias are set after MuJoCo's compiler ran, which would refuse or change those of some links.

    mujoco_model.py MODEL OUTPUT
"""

import sys
from collections import defaultdict

import mujoco
import numpy

OFF = "contact constraint equality frictionloss limit spring damper actuation sensor".split()


class Joint:
    def __init__(self, line):
        self.name, parent, self.kind, *numbers = line.split()
        self.parent = int(parent)
        numbers = numpy.array([float(number) for number in numbers])
        parts = numpy.split(numbers, [3, 12, 15, 16, 19])
        self.axis, rotation, self.position, mass, self.center, inertia = parts
        self.rotation, self.inertia = rotation.reshape(3, 3), inertia.reshape(3, 3)
        self.mass = float(mass[0])

    def element(self):
        """The joint as XML."""
        if self.kind == "FreeFlyer":
            return f'<freejoint name="{self.name}"/>'
        kind = "hinge" if self.kind.startswith("R") else "slide"
        axis = self.axis if self.kind.endswith("Unaligned") else numpy.eye(3)["XYZ".index(self.kind[1])]
        return f'<joint name="{self.name}" type="{kind}" axis="{text(axis)}"/>'


def text(numbers):
    return " ".join(repr(float(number)) for number in numbers)


def quaternion(rotation):
    out = numpy.zeros(4)
    mujoco.mju_mat2Quat(out, rotation.flatten())
    return out


def body(index, joints, children):
    joint = joints[index - 1]
    inside = "".join(body(child, joints, children) for child in children[index])
    return (
        f'<body name="{joint.name}" pos="{text(joint.position)}" quat="{text(quaternion(joint.rotation))}">'
        f'<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>{joint.element()}{inside}</body>'
    )


def principal(inertia):
    """Moments, and the quaternion of right-handed axes."""
    moments, axes = numpy.linalg.eigh(inertia)
    return moments, quaternion(axes * numpy.sign(numpy.linalg.det(axes)))


def main():
    source, output = sys.argv[1:]
    joints = [Joint(line) for line in open(source)]
    children = defaultdict(list)
    for index, joint in enumerate(joints, 1):
        children[joint.parent].append(index)
    bodies = "".join(body(root, joints, children) for root in children[0])
    flags = " ".join(f'{name}="disable"' for name in OFF)
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option gravity="0 0 -9.81"><flag {flags}/></option>'
        f"<worldbody>{bodies}</worldbody></mujoco>"
    )
    for joint in joints:
        index = model.body(joint.name).id
        model.body_mass[index], model.body_ipos[index] = joint.mass, joint.center
        model.body_inertia[index], model.body_iquat[index] = principal(joint.inertia)
        # Not known to be simple any more.
        model.body_sameframe[index] = mujoco.mjtSameFrame.mjSAMEFRAME_NONE
        model.body_simple[index] = 0
    model.dof_simplenum[:] = 0
    mujoco.mj_setConst(model, mujoco.MjData(model))
    mujoco.mj_saveModel(model, output)


if __name__ == "__main__":
    main()
