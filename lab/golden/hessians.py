"""Contracted Hessians of inverse and forward dynamics, exact, by CasADi from recursive Newton-Euler equations of their own.

A tree in general position with a floating, a spherical, two revolute and a prismatic joint. Coordinates are displaced along
the exponential map: near zero, exp(d) is 1 + d + d^2 / 2, which is exact for second derivatives.
"""

import xml.etree.ElementTree as ElementTree

import casadi
import numpy

from mechanisms import Writer

NAME, SEED, STATES = "hessians", 21, 3
#: The joints: type, and how many links towards the base they leave.
JOINTS = [("floating", 0), ("revolute", 0), ("spherical", 0), ("prismatic", 1), ("revolute", 0)]
VELOCITIES = {"floating": 6, "spherical": 3, "revolute": 1, "prismatic": 1}
GRAVITY = numpy.array([0.0, 0.0, -9.81])


def tree():
    """The URDF."""
    writer = Writer(NAME, SEED, "A tree in general position, for Hessians.")
    path = ["base"]
    for number, (kind, leaves) in enumerate(JOINTS):
        del path[len(path) - leaves:]
        writer.joint(f"joint{number}", kind, path[-1], f"link{number}")
        path.append(f"link{number}")
    return writer.finished()


def skew(v):
    return casadi.vertcat(casadi.horzcat(0, -v[2], v[1]), casadi.horzcat(v[2], 0, -v[0]), casadi.horzcat(-v[1], v[0], 0))


def rotation(rpy):
    (a, b, c), (x, y, z) = numpy.cos(rpy), numpy.sin(rpy)
    about = (numpy.array([[1, 0, 0], [0, a, -x], [0, x, a]]), numpy.array([[b, 0, y], [0, 1, 0], [-y, 0, b]]),
             numpy.array([[c, -z, 0], [z, c, 0], [0, 0, 1]]))
    return about[2] @ about[1] @ about[0]


def attitude(quaternion):
    x, y, z, w = quaternion
    return numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def numbers(element, name):
    return numpy.array([float(word) for word in element.get(name).split()])


class Body:
    """A link with its joint, as the URDF has them."""

    def __init__(self, joint, links):
        origin, child = joint.find("origin"), links[joint.find("child").get("link")]
        self.kind, self.parent = joint.get("type"), joint.find("parent").get("link")
        self.orientation, self.at = rotation(numbers(origin, "rpy")), numbers(origin, "xyz")
        axis = joint.find("axis")
        self.axis = None if axis is None else numbers(axis, "xyz") / numpy.linalg.norm(numbers(axis, "xyz"))
        inertial = child.find("inertial")
        self.mass, self.centre = float(inertial.find("mass").get("value")), numbers(inertial.find("origin"), "xyz")
        entry = {key: float(value) for key, value in inertial.find("inertia").items()}
        tensor = numpy.array([[entry["ixx"], entry["ixy"], entry["ixz"]], [entry["ixy"], entry["iyy"], entry["iyz"]],
                              [entry["ixz"], entry["iyz"], entry["izz"]]])
        orientation = rotation(numbers(inertial.find("origin"), "rpy"))
        self.tensor, self.name = orientation @ tensor @ orientation.T, child.get("name")

    def place(self, q, d):
        """The rotation and the translation of the joint at coordinates that are displaced by d."""
        if self.kind == "revolute":
            k, angle = skew(self.axis), q[0] + d[0]
            return casadi.SX.eye(3) + casadi.sin(angle) * k + (1 - casadi.cos(angle)) * k @ k, casadi.SX.zeros(3)
        if self.kind == "prismatic":
            return casadi.SX.eye(3), self.axis * (q[0] + d[0])
        w = d[-3:]
        turned = attitude(q[-4:]) @ (casadi.SX.eye(3) + skew(w) + skew(w) @ skew(w) / 2)
        if self.kind == "spherical":
            return turned, casadi.SX.zeros(3)
        return turned, q[:3] + attitude(q[-4:]) @ (d[:3] + skew(w) @ d[:3] / 2)

    def motion(self, v):
        """The angular and the linear velocity across the joint, in the link's axes."""
        none = casadi.SX.zeros(3)
        return {"revolute": lambda: (self.axis * v[0], none), "prismatic": lambda: (none, self.axis * v[0]),
                "spherical": lambda: (v, none), "floating": lambda: (v[3:], v[:3])}[self.kind]()

    def force(self, moment, force):
        """The joint forces of a wrench at the link's origin."""
        return {"revolute": lambda: casadi.dot(self.axis, moment), "prismatic": lambda: casadi.dot(self.axis, force),
                "spherical": lambda: moment, "floating": lambda: casadi.vertcat(force, moment)}[self.kind]()


def inverse_dynamics(bodies, q, d, v, a):
    """The joint forces, by Newton and Euler, with spatial accelerations in the links' axes."""
    found, wrenches, at, coordinate = {"base": [casadi.SX.zeros(3)] * 3 + [-casadi.SX(GRAVITY)]}, {}, 0, 0
    spans = {}
    for body in bodies:
        span = slice(at, at + VELOCITIES[body.kind])
        spans[body.name], at = span, span.stop
        count = span.stop - span.start + (1 if body.kind in ("spherical", "floating") else 0)
        own, offset = body.place(q[coordinate:coordinate + count], d[span])
        coordinate += count
        orientation, place = body.orientation @ own, body.at + body.orientation @ offset
        w, u, dw, du = found[body.parent]
        w, u = orientation.T @ w, orientation.T @ (u + casadi.cross(w, place))
        dw, du = orientation.T @ dw, orientation.T @ (du + casadi.cross(dw, place))
        (jw, ju), (aw, au) = body.motion(v[span]), body.motion(a[span])
        w, u = w + jw, u + ju
        dw, du = dw + aw + casadi.cross(w, jw), du + au + casadi.cross(w, ju) + casadi.cross(u, jw)
        found[body.name] = [w, u, dw, du]
        # The classical acceleration of the centre of mass, and the wrench at the link's origin.
        acceleration = du + casadi.cross(w, u) + casadi.cross(dw, body.centre)
        acceleration += casadi.cross(w, casadi.cross(w, body.centre))
        force = body.mass * acceleration
        moment = body.tensor @ dw + casadi.cross(w, body.tensor @ w) + casadi.cross(body.centre, force)
        wrenches[body.name] = [moment, force, orientation, place]
    tau = {}
    for body in reversed(bodies):
        moment, force, orientation, place = wrenches[body.name]
        tau[body.name] = body.force(moment, force)
        if body.parent in wrenches:
            force = orientation @ force
            wrenches[body.parent][0] += orientation @ moment + casadi.cross(place, force)
            wrenches[body.parent][1] += force
    return casadi.vertcat(*(tau[body.name] for body in bodies))


def blocks(scalar, d, v, x):
    """The gradient and the blocks of the Hessian, at no displacement."""
    hessian, gradient = casadi.hessian(scalar, casadi.vertcat(d, v, x))
    n = d.shape[0]
    parts = {"gradient": gradient, "dq_dq": hessian[:n, :n], "dq_dqd": hessian[:n, n:2 * n],
             "dqd_dqd": hessian[n:2 * n, n:2 * n], "dq_dx": hessian[:n, 2 * n:], "rest": hessian[n:, 2 * n:]}
    return {key: casadi.substitute(part, d, 0) for key, part in parts.items()}


def hessians(urdf):
    """The file: states, with the blocks of the Hessians by columns; x is qdd of inverse dynamics, tau of forward dynamics."""
    robot = ElementTree.fromstring(urdf)
    links = {link.get("name"): link for link in robot.findall("link")}
    bodies = [Body(joint, links) for joint in robot.findall("joint")]
    n, random, states = sum(VELOCITIES[body.kind] for body in bodies), numpy.random.default_rng(SEED + 1), []
    d, v, x = (casadi.SX.sym(name, n) for name in "dvx")
    for _ in range(STATES):
        parts = []
        for body in bodies:
            part = random.uniform(-2, 2, {"floating": 7, "spherical": 4}.get(body.kind, 1))
            if len(part) > 1:
                part[-4:] /= numpy.linalg.norm(part[-4:])
            parts.append(part)
        q = numpy.concatenate(parts)
        qd, qdd, tau, w = (random.uniform(-size, size, n) for size in (1.5, 3.0, 10.0, 1.0))
        inverse = inverse_dynamics(bodies, q, d, v, x)
        bias = casadi.substitute(inverse, x, 0)
        forward = casadi.solve(casadi.jacobian(inverse, x), x - bias)
        state = {"q": q, "v": qd, "a": qdd, "tau": tau, "w": w}
        for name, value, at in (("inverse", inverse, qdd), ("forward", forward, tau)):
            found = blocks(casadi.dot(casadi.SX(w), value), d, v, x)
            evaluate = casadi.Function("blocks", [v, x], [casadi.substitute(value, d, 0), *found.values()])
            value, *found = (numpy.array(casadi.DM(part)) for part in evaluate(qd, at))
            found = dict(zip(["gradient", "dq_dq", "dq_dqd", "dqd_dqd", "dq_dx", "rest"], found))
            assert numpy.abs(found.pop("rest")).max() < 1e-9
            state[name] = {"value": value.ravel(), **{key: part.ravel(order="F") for key, part in found.items()}}
        states.append({key: part.tolist() if isinstance(part, numpy.ndarray) else
                       {name: entries.tolist() for name, entries in part.items()} for key, part in state.items()})
    return {"robot": NAME, "urdf": f"{NAME}.urdf", "states": states, "generator": f"casadi {casadi.__version__}"}
