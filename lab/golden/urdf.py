"""A URDF as a Pinocchio model, with modyn's joint types and loop joints, which Pinocchio's reader does not have.

Nothing here is modyn's: each joint is a joint model of Pinocchio, placed as docs/conventions.md says.
"""

import dataclasses
import xml.etree.ElementTree as ElementTree

import numpy
import pinocchio

IDENTITY = pinocchio.SE3.Identity()


def numbers(text):
    return numpy.array([float(word) for word in text.split()])


def pose(element):
    """The placement that the attributes xyz and rpy of an element describe."""
    if element is None:
        return IDENTITY
    xyz, rpy = (numbers(element.get(name, "0 0 0")) for name in ("xyz", "rpy"))
    return pinocchio.SE3(pinocchio.rpy.rpyToMatrix(rpy), xyz)


def unit(element):
    axis = numbers(element.get("xyz")) if element is not None else numpy.array([1.0, 0.0, 0.0])
    return axis / numpy.linalg.norm(axis)


def inertia(link):
    """The inertia of a link about its origin; None if it has none."""
    element = link.find("inertial")
    if element is None:
        return None
    entries = element.find("inertia")
    xx, xy, xz, yy, yz, zz = (float(entries.get(name)) for name in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"))
    tensor = numpy.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    mass = float(element.find("mass").get("value"))
    return pose(element.find("origin")).act(pinocchio.Inertia(mass, numpy.zeros(3), tensor))


def to_axis(axis):
    """The smallest rotation that brings z to the axis."""
    return pinocchio.Quaternion.FromTwoVectors(numpy.array([0.0, 0.0, 1.0]), axis).toRotationMatrix()


@dataclasses.dataclass
class Loop:
    """A loop joint: its type, a joint and a placement on it for each of its two frames, and the axis."""
    kind: str
    ends: list
    axis: numpy.ndarray


@dataclasses.dataclass
class Mechanism:
    """A model of Pinocchio, whose joints stand in modyn's order."""
    model: pinocchio.Model
    #: By joint of a moving link: the rotation of Pinocchio's body frame against the link's.
    turned: dict
    loops: list
    #: The links, fixed ones too, and the moving ones.
    links: list
    moving: list


def parse(text):
    """The mechanism that a URDF describes; its joints must stand depth first."""
    root = ElementTree.fromstring(text.encode())
    links = {link.get("name"): link for link in root.findall("link")}
    joints = root.findall("joint")
    children = {joint.find("child").get("link") for joint in joints}
    base = next(name for name in links if name not in children)
    mechanism = Mechanism(pinocchio.Model(), {}, [], [], [])
    model = mechanism.model
    #: By link: its joint and its placement on that joint's body.
    places = {}

    def place(name, joint, placement):
        places[name] = joint, placement
        model.addFrame(pinocchio.Frame(name, joint, placement, pinocchio.FrameType.BODY))
        body = inertia(links[name])
        if body is not None and joint > 0:
            model.appendBodyToJoint(joint, body, placement)
        mechanism.links.append(name)
        for element in joints:
            if element.find("parent").get("link") == name:
                attach(element, joint, placement)

    def attach(element, parent, placement):
        name, kind = element.get("name"), element.get("type")
        child = element.find("child").get("link")
        origin = placement * pose(element.find("origin"))
        if kind == "fixed":
            return place(child, parent, origin)
        axis, turned = unit(element.find("axis")), numpy.eye(3)
        match kind:
            case "revolute" | "continuous":
                made = pinocchio.JointModelRevoluteUnaligned(axis)
            case "prismatic":
                made = pinocchio.JointModelPrismaticUnaligned(axis)
            case "universal":
                parent = model.addJoint(parent, pinocchio.JointModelRevoluteUnaligned(axis), origin, name + ".first")
                made, origin = pinocchio.JointModelRevoluteUnaligned(unit(element.find("axis2"))), IDENTITY
            case "planar":
                # Pinocchio's plane is x-y.
                made, turned = pinocchio.JointModelPlanar(), to_axis(axis)
            case "spherical":
                made = pinocchio.JointModelSpherical()
            case "floating":
                made = pinocchio.JointModelFreeFlyer()
            case _:
                raise ValueError(f"joint `{name}` is `{kind}`")
        joint = model.addJoint(parent, made, origin * pinocchio.SE3(turned, numpy.zeros(3)), name)
        mechanism.turned[joint] = turned
        mechanism.moving.append(child)
        return place(child, joint, pinocchio.SE3(turned.T, numpy.zeros(3)))

    place(base, 0, IDENTITY)
    for element in root.findall("loop_joint"):
        ends = []
        for end in (element.find("link1"), element.find("link2")):
            joint, placement = places[end.get("link")]
            ends.append((joint, placement * pose(end)))
        mechanism.loops.append(Loop(element.get("type"), ends, unit(element.find("axis"))))
    return mechanism
