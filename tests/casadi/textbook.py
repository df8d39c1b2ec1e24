"""The dynamics of a URDF as CasADi expressions, from the textbook and from nothing of modyn.

`inverse_dynamics` is the recursive Newton-Euler algorithm in world axes. `forward_dynamics` is the articulated-body
algorithm in the links' axes (Featherstone 2008, "Rigid Body Dynamics Algorithms", tables 5.1 and 7.1). The two share the
reading of the file and the poses of joints only. Quaternions are x, y, z, w; they are scaled to length 1 first. Velocities
of spherical and floating joints are in the moved axes.
"""

import xml.etree.ElementTree as xml

import casadi as ca
import numpy as np

GRAVITY = np.array([0, 0, -9.81])
# The numbers of coordinates and of velocities.
SIZES = {"revolute": (1, 1), "continuous": (1, 1), "prismatic": (1, 1), "spherical": (4, 3), "floating": (7, 6), "fixed": (0, 0)}


def numbers(element, name, default):
    text = element.get(name) if element is not None else None
    return np.array([float(word) for word in text.split()]) if text is not None else np.array(default, float)


def rotation_of_rpy(rpy):
    (sr, sp, sy), (cr, cp, cy) = np.sin(rpy), np.cos(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def origin(element):
    found = element.find("origin") if element is not None else None
    return rotation_of_rpy(numbers(found, "rpy", [0, 0, 0])), numbers(found, "xyz", [0, 0, 0])


def cross(a):
    return ca.vertcat(
        ca.horzcat(0, -a[2], a[1]), ca.horzcat(a[2], 0, -a[0]), ca.horzcat(-a[1], a[0], 0)
    )


class Joint:
    """A joint with the link that it moves: type, parent (an index, -1 for the root), placement, axis, inertia."""

    def __init__(self, element, kind, parent, link):
        self.kind, self.parent = kind, parent
        self.child = link.get("name")
        self.placement = origin(element)
        axis = numbers(element.find("axis") if element is not None else None, "xyz", [1, 0, 0])
        self.axis = axis / np.linalg.norm(axis)
        inertial = link.find("inertial")
        rotation, self.center = origin(inertial)
        self.mass = float(inertial.find("mass").get("value")) if inertial is not None else 0.0
        self.inertia = np.zeros((3, 3))
        if inertial is not None:
            at = inertial.find("inertia")
            xx, xy, xz, yy, yz, zz = (float(at.get(n)) for n in ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"])
            self.inertia = rotation @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ rotation.T

    def motion(self, q):
        """Returns the rotation and the displacement of the joint."""
        if self.kind in ("revolute", "continuous"):
            k = cross_numbers(self.axis)
            return ca.DM.eye(3) + ca.sin(q) * k + (1 - ca.cos(q)) * (k @ k), ca.DM.zeros(3)
        if self.kind == "prismatic":
            return ca.DM.eye(3), q * self.axis
        if self.kind == "fixed":
            return ca.DM.eye(3), ca.DM.zeros(3)
        moved, q = (q[:3], q[3:]) if self.kind == "floating" else (ca.DM.zeros(3), q)
        q = q / ca.norm_2(q)
        v, w = q[:3], q[3]
        return ca.DM.eye(3) + 2 * w * cross(v) + 2 * cross(v) @ cross(v), moved

    def subspace(self):
        """Returns the twists of unit velocities in the moved axes: angular parts, linear parts."""
        zero, eye = np.zeros((3, 3)), np.eye(3)
        return {
            "revolute": (self.axis[:, None], np.zeros((3, 1))),
            "continuous": (self.axis[:, None], np.zeros((3, 1))),
            "prismatic": (np.zeros((3, 1)), self.axis[:, None]),
            "spherical": (eye, zero),
            "floating": (np.hstack([zero, eye]), np.hstack([eye, zero])),
            "fixed": (np.zeros((3, 0)), np.zeros((3, 0))),
        }[self.kind]


class Robot:
    """A robot of the file `path`, depth first in the order of the file, with its root fixed or floating."""

    def __init__(self, path, floating=False):
        root = xml.parse(path).getroot()
        links = {link.get("name"): link for link in root.findall("link")}
        joints = root.findall("joint")
        children = {joint.find("child").get("link") for joint in joints}
        (base,) = [name for name in links if name not in children]
        self.joints = [Joint(None, "floating" if floating else "fixed", -1, links[base])]

        def add(name, index):
            for joint in joints:
                if joint.find("parent").get("link") == name:
                    child = joint.find("child").get("link")
                    self.joints.append(Joint(joint, joint.get("type"), index, links[child]))
                    add(child, len(self.joints) - 1)

        add(base, 0)
        self.q, self.v, q, v = [], [], 0, 0
        for joint in self.joints:
            nq, nv = SIZES[joint.kind]
            self.q.append(slice(q, q + nq))
            self.v.append(slice(v, v + nv))
            q, v = q + nq, v + nv
        self.nq, self.nv = q, v

    def poses(self, q):
        """Returns the rotation and the position of each link in the world."""
        poses = []
        for joint, at in zip(self.joints, self.q):
            rotation, position = joint.motion(q[at])
            placed, offset = joint.placement
            rotation, position = placed @ rotation, offset + placed @ position
            if joint.parent >= 0:
                r, p = poses[joint.parent]
                rotation, position = r @ rotation, p + r @ position
            poses.append((rotation, position))
        return poses

    def link_pose(self, q, link):
        return self.poses(q)[[joint.child for joint in self.joints].index(link)]

    def inverse_dynamics(self, q, qd, qdd):
        poses, motions, tau = self.poses(q), [], [None] * len(self.joints)
        zero = ca.DM.zeros(3)
        for joint, (r, p), at in zip(self.joints, poses, self.v):
            angular, linear = joint.subspace()
            w0, a0, alpha0, p0 = zero, zero - GRAVITY, zero, zero
            if joint.parent >= 0:
                w0, alpha0, a0 = motions[joint.parent]
                p0 = poses[joint.parent][1]
            spin, slide = r @ (angular @ qd[at]), r @ (linear @ qd[at])
            w, arm = w0 + spin, p - p0
            alpha = alpha0 + ca.cross(w0, spin) + r @ (angular @ qdd[at])
            speed = ca.cross(w0, arm) + slide
            a = a0 + ca.cross(alpha0, arm) + ca.cross(w0, speed) + ca.cross(w, slide) + r @ (linear @ qdd[at])
            motions.append((w, alpha, a))
        wrenches = [(zero, zero)] * len(self.joints)
        for i in reversed(range(len(self.joints))):
            joint, (r, p), (w, alpha, a) = self.joints[i], poses[i], motions[i]
            c, inertia = r @ joint.center, r @ joint.inertia @ r.T
            force = joint.mass * (a + ca.cross(alpha, c) + ca.cross(w, ca.cross(w, c)))
            moment = inertia @ alpha + ca.cross(w, inertia @ w) + ca.cross(c, force)
            n, f = moment + wrenches[i][0], force + wrenches[i][1]
            angular, linear = joint.subspace()
            tau[i] = angular.T @ (r.T @ n) + linear.T @ (r.T @ f)
            if joint.parent >= 0:
                n0, f0 = wrenches[joint.parent]
                wrenches[joint.parent] = n0 + n + ca.cross(p - poses[joint.parent][1], f), f0 + f
        return ca.vertcat(*tau)

    def forward_dynamics(self, q, qd, tau):
        """Returns the accelerations; spatial vectors are angular, then linear, in the links' axes."""
        bodies = []
        for joint, at, k in zip(self.joints, self.q, self.v):
            rotation, position = joint.motion(q[at])
            placed, offset = joint.placement
            e, r = (placed @ rotation).T, offset + placed @ position
            transform = ca.blockcat([[e, ca.DM(3, 3)], [-e @ cross(r), e]])
            s = ca.sparsify(ca.DM(np.vstack(joint.subspace())))
            velocity = s @ qd[k]
            if joint.parent >= 0:
                velocity = transform @ bodies[joint.parent]["v"] + velocity
            bias = spatial_cross(velocity) @ (s @ qd[k])
            h = cross(ca.DM(joint.mass * joint.center))
            inertia = ca.sparsify(ca.DM(
                np.block([
                    [joint.inertia + joint.mass * -cross_numbers(joint.center) @ cross_numbers(joint.center), np.array(h)],
                    [np.array(h.T), joint.mass * np.eye(3)],
                ])
            ))
            momentum = inertia @ velocity
            bodies.append({"x": transform, "s": s, "v": velocity, "c": bias, "i": inertia,
                           "p": -spatial_cross(velocity).T @ momentum})
        for i in reversed(range(len(self.joints))):
            body, joint = bodies[i], self.joints[i]
            # A massless link without freedom, as a world is, needs no solution.
            body["u"] = body["i"] @ body["s"]
            body["d"] = body["s"].T @ body["u"]
            body["t"] = tau[self.v[i]] - body["s"].T @ body["p"]
            if joint.parent >= 0:
                inertia, p = body["i"], body["p"]
                if body["s"].shape[1]:
                    gain = solve(body["d"], body["u"].T)
                    inertia = inertia - body["u"] @ gain
                    p = p + inertia @ body["c"] + body["u"] @ solve(body["d"], body["t"])
                else:
                    p = p + inertia @ body["c"]
                parent = bodies[joint.parent]
                parent["i"] = parent["i"] + body["x"].T @ inertia @ body["x"]
                parent["p"] = parent["p"] + body["x"].T @ p
        accelerations, qdd = [], []
        for i, (joint, body) in enumerate(zip(self.joints, bodies)):
            before = ca.vertcat(ca.DM.zeros(3), -GRAVITY) if joint.parent < 0 else accelerations[joint.parent]
            a = body["x"] @ before + body["c"]
            if body["s"].shape[1]:
                own = solve(body["d"], body["t"] - body["u"].T @ a)
                qdd.append(own)
                a = a + body["s"] @ own
            accelerations.append(a)
        return ca.vertcat(*qdd)

    def velocity_to_qdot(self, q, qd):
        rates = []
        for joint, at, k in zip(self.joints, self.q, self.v):
            x, v = q[at], qd[k]
            if joint.kind == "floating":
                rates.append(joint.motion(x)[0] @ v[:3])
                x, v = x[3:], v[3:]
            if joint.kind in ("floating", "spherical"):
                x = x / ca.norm_2(x)
                v = ca.vertcat(x[3] * v + ca.cross(x[:3], v), -ca.dot(x[:3], v)) / 2
            rates.append(v)
        return ca.vertcat(*rates)

    def integrate(self, q, v):
        """Returns the coordinates after unit time at the constant velocities v: exponential maps of SO(3) and SE(3)."""
        after = []
        for joint, at, k in zip(self.joints, self.q, self.v):
            x, d = q[at], v[k]
            if joint.kind not in ("floating", "spherical"):
                after.append(x + d)
                continue
            rotation = d[-3:]
            angle = ca.norm_2(rotation)
            if joint.kind == "floating":
                k1, k2 = (1 - ca.cos(angle)) / angle**2, (angle - ca.sin(angle)) / angle**3
                w = cross(rotation)
                after.append(x[:3] + joint.motion(x)[0] @ (d[:3] + k1 * (w @ d[:3]) + k2 * (w @ (w @ d[:3]))))
                x = x[3:]
            x = x / ca.norm_2(x)
            u, c = ca.sin(angle / 2) / angle * rotation, ca.cos(angle / 2)
            after.append(ca.vertcat(x[3] * u + c * x[:3] + ca.cross(x[:3], u), x[3] * c - ca.dot(x[:3], u)))
        return ca.vertcat(*after)

    def implicit_midpoint(self):
        """Returns the step of the implicit midpoint rule, whose equations CasADi's root finder solves."""
        names = {"q": self.nq, "qd": self.nv, "tau": self.nv, "dt": 1, "a": self.nv}
        q, qd, tau, dt, a = (ca.SX.sym(name, size) for name, size in names.items())
        middle = qd + dt / 2 * a
        unmet = self.inverse_dynamics(self.integrate(q, dt / 2 * middle), middle, a) - tau
        given = ca.vertcat(q, qd, tau, dt)
        solver = ca.rootfinder("midpoint", "newton", {"x": a, "p": given, "g": unmet}, {"abstol": 1e-13})
        after = ca.Function("after", [a, given], [self.integrate(q, dt * middle), qd + dt * a])
        given = [ca.MX.sym(name, names[name]) for name in ("q", "qd", "tau", "dt")]
        found = solver(np.zeros(self.nv), ca.vertcat(*given))
        step = after(found, ca.vertcat(*given))
        return ca.Function("step", given, list(step), ["q", "qd", "tau", "dt"], ["q_next", "qd_next"])

    def random(self, generator):
        """Returns coordinates with quaternions of other lengths than 1, velocities and forces or accelerations."""
        return [generator.uniform(-1.5, 1.5, size) for size in (self.nq, self.nv, self.nv)]


def cross_numbers(a):
    return np.array(ca.DM(cross(ca.DM(a))))


def spatial_cross(v):
    w, l = v[:3], v[3:]
    return ca.blockcat([[cross(w), ca.DM(3, 3)], [cross(l), cross(w)]])


def solve(a, b):
    """Returns a^-1 b for a symmetric positive definite matrix: by division, or by Cholesky's factors."""
    if a.shape[0] == 1:
        return b / a
    n = a.shape[0]
    lower = [[0] * n for _ in range(n)]
    for i in range(n):
        for j in range(i + 1):
            rest = a[i, j] - sum(lower[i][k] * lower[j][k] for k in range(j))
            lower[i][j] = ca.sqrt(rest) if i == j else rest / lower[j][j]
    rows = []
    for i in range(n):
        rows.append((b[i, :] - sum(lower[i][k] * rows[k] for k in range(i))) / lower[i][i])
    for i in reversed(range(n)):
        rows[i] = (rows[i] - sum(lower[k][i] * rows[k] for k in range(i + 1, n))) / lower[i][i]
    return ca.vertcat(*rows)
