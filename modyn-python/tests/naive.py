"""The mechanics of a robot by the textbook, which shares no code with modyn: world axes, no recursion but that over the links,
extended precision, and derivatives by complex steps.

Arguments and results may have a first axis for several states; a complex step is the argument `dx`, a displacement in tangent
space.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

REAL, COMPLEX = np.longdouble, np.clongdouble
#: The imaginary part of a complex step, whose square is nothing beside 1.
STEP = REAL(1e-100)
#: By type of joint: the numbers of coordinates and velocities.
SIZES = {"fixed": (0, 0), "revolute": (1, 1), "continuous": (1, 1), "prismatic": (1, 1), "universal": (2, 2),
         "planar": (3, 3), "spherical": (4, 3), "floating": (7, 6)}


@dataclass
class Link:
    """A link and the joint that connects it to the link `parent`; -1 is the world."""

    parent: int
    kind: str
    xyz: tuple = (0.0, 0.0, 0.0)
    rpy: tuple = (0.0, 0.0, 0.0)
    axis: tuple = (1.0, 0.0, 0.0)
    axis2: tuple = (1.0, 0.0, 0.0)
    mass: float = 0.0
    com: tuple = (0.0, 0.0, 0.0)
    #: xx, xy, xz, yy, yz, zz about the centre of mass, in the link's axes.
    inertia: tuple = (0.0,) * 6
    #: The leader's index, multiplier and offset.
    mimic: tuple | None = None
    armature: float = 0.0
    damping: float = 0.0
    friction: float = 0.0


@dataclass
class Constraint:
    """A loop joint or a contact, whose first frame is the world's (link -1)."""

    kind: str
    links: tuple
    xyz: tuple
    rpy: tuple
    axis: tuple = (1.0, 0.0, 0.0)


def skew(v):
    x, y, z = np.moveaxis(np.asarray(v), -1, 0)
    zero = 0 * x
    return np.stack([np.stack(row, -1) for row in ([zero, -z, y], [z, zero, -x], [-y, x, zero])], -2)


def times(matrix, vector):
    return (matrix @ vector[..., None])[..., 0]


def transposed(matrix):
    return np.swapaxes(matrix, -1, -2)


def about(axis, angle):
    k, angle = skew(axis), np.asarray(angle)[..., None, None]
    return np.eye(3, dtype=REAL) + np.sin(angle) * k + (1 - np.cos(angle)) * (k @ k)


def unit(axis):
    axis = np.array(axis, REAL)
    return axis / np.sqrt(axis @ axis)


def from_rpy(rpy):
    roll, pitch, yaw = np.array(rpy, REAL)
    x, y, z = np.eye(3, dtype=REAL)
    return about(z, yaw) @ about(y, pitch) @ about(x, roll)


def to_rpy(matrix):
    return (np.arctan2(matrix[2, 1], matrix[2, 2]), np.arctan2(-matrix[2, 0], np.hypot(matrix[2, 1], matrix[2, 2])),
            np.arctan2(matrix[1, 0], matrix[0, 0]))


def from_quaternion(q):
    v, w = q[..., :3], q[..., 3, None, None]
    return np.eye(3, dtype=REAL) + 2 * w * skew(v) + 2 * skew(v) @ skew(v)


def plane(axis):
    """The smallest rotation that brings z to the axis."""
    if axis[2] == -1:
        return np.diag(np.array([1, -1, -1], REAL))
    k = np.cross([0, 0, 1], axis)
    return np.eye(3, dtype=REAL) + skew(k) + skew(k) @ skew(k) / (1 + axis[2])


def solve(matrix, sides):
    """Solves for the columns of `sides`, of a matrix whose condition number is below 1e15."""
    matrix, sides = np.asarray(matrix, REAL), np.asarray(sides, REAL)
    inverse = np.linalg.inv(matrix.astype(float)).astype(REAL)
    x = inverse @ sides
    for _ in range(6):
        x = x + inverse @ (sides - matrix @ x)
    return x


@dataclass
class Naive:
    """A robot. Its links stand depth first."""

    links: list
    gravity: tuple = (0.0, 0.0, -9.81)
    constraints: list = field(default_factory=list)
    #: The velocity at which smooth friction changes its sign.
    width: float = 0.1

    def __post_init__(self):
        self.places, self.nq, self.nv = [], 0, 0
        for link in self.links:
            if link.mimic:
                leader, multiplier, offset = link.mimic
                place = (*self.places[leader][:2], REAL(multiplier), REAL(offset))
            else:
                place = (self.nq, self.nv, REAL(1), REAL(0))
                self.nq, self.nv = self.nq + SIZES[link.kind][0], self.nv + SIZES[link.kind][1]
            self.places.append(place)
        self.moving = []
        for link in self.links:
            self.moving.append(link.kind != "fixed" or (link.parent >= 0 and self.moving[link.parent]))

    @cached_property
    def parameters(self):
        """The mass, the first moment and the inertia about the origin of each link that moves; zero for others."""
        mass = np.array([link.mass if moves else 0.0 for link, moves in zip(self.links, self.moving)], REAL)
        com = np.array([link.com for link in self.links], REAL)
        at = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])
        tensor = np.array([np.array(link.inertia, REAL)[at] * moves for link, moves in zip(self.links, self.moving)])
        return mass, mass[:, None] * com, tensor - mass[:, None, None] * skew(com) @ skew(com)

    def motion(self, q, qd=None, qdd=None, dx=None):
        """By link: rotation, origin, angular velocity, velocity, angular acceleration, acceleration of the origin, and the
        joint's motions: entry of qd, ratio, direction of rotation and of translation."""
        zero = np.zeros(self.nv, REAL)
        q = np.asarray(q, REAL)
        qd, qdd, dx = (zero if x is None else np.asarray(x) for x in (qd, qdd, dx))
        out, none = [], np.zeros(3, REAL)
        for link, (at, v, ratio, offset) in zip(self.links, self.places):
            parent = out[link.parent] if link.parent >= 0 else (np.eye(3, dtype=REAL), *[none] * 5)
            axes, origin, omega, velocity, alpha, acceleration = parent[:6]
            before = origin + times(axes, np.array(link.xyz, REAL))
            axes = axes @ from_rpy(link.rpy)
            axis, after, shift, motions = unit(link.axis), axes, none, []
            change = lambda k: ratio * (q[..., at + k] + dx[..., v + k]) + offset
            turned = lambda skip: axes @ from_quaternion(q[..., at + skip:at + skip + 4]) @ (
                np.eye(3, dtype=REAL) + skew(dx[..., v + skip:v + skip + 3]))
            match link.kind:
                case "revolute" | "continuous":
                    after = axes @ about(axis, change(0))
                    motions = [(times(axes, axis), none, 0)]
                case "prismatic":
                    shift = times(axes, axis) * change(0)[..., None]
                    motions = [(none, times(axes, axis), 0)]
                case "universal":
                    between = axes @ about(axis, change(0))
                    after = between @ about(unit(link.axis2), change(1))
                    motions = [(times(axes, axis), none, 0), (times(between, unit(link.axis2)), none, 1)]
                case "planar":
                    x, y, normal = (times(axes, column) for column in plane(axis).T)
                    shift = x * change(0)[..., None] + y * change(1)[..., None]
                    after = axes @ about(axis, change(2))
                    motions = [(none, x, 0), (none, y, 0), (normal, none, 0)]
                case "spherical":
                    after = turned(0)
                    motions = [(after[..., k], none, 3) for k in range(3)]
                case "floating":
                    after = turned(3)
                    moved = times(from_quaternion(q[..., at + 3:at + 7]), dx[..., v:v + 3])
                    shift = times(axes, q[..., at:at + 3] + moved)
                    motions = [(none, after[..., k], 6) for k in range(3)] + [(after[..., k], none, 6) for k in range(3)]
            arm = before + shift - origin
            spin = [omega]
            for k, (angular, _, _) in enumerate(motions):
                spin.append(spin[-1] + angular * (ratio * qd[..., v + k])[..., None])
            velocity = velocity + np.cross(omega, arm)
            acceleration = acceleration + np.cross(alpha, arm) + np.cross(omega, np.cross(omega, arm))
            for k, (angular, linear, carrier) in enumerate(motions):
                rate, change = (ratio * x[..., v + k, None] for x in (qd, qdd))
                velocity = velocity + linear * rate
                alpha = alpha + angular * change + np.cross(spin[carrier], angular) * rate
                acceleration = acceleration + linear * change + np.cross(spin[carrier] + omega, linear) * rate
            entries = [(v + k, ratio, angular, linear) for k, (angular, linear, _) in enumerate(motions)]
            out.append((after, origin + arm, spin[-1], velocity, alpha, acceleration, entries))
        return out

    def torques(self, motion, wrenches):
        """The joint forces of wrenches (moment, force) on the links at their origins, in world axes."""
        wrenches, tau = list(wrenches), [COMPLEX(0)] * self.nv
        for i in reversed(range(len(self.links))):
            moment, force = wrenches[i]
            for v, ratio, angular, linear in motion[i][6]:
                tau[v] = tau[v] + ratio * ((angular * moment).sum(-1) + (linear * force).sum(-1))
            parent = self.links[i].parent
            if parent >= 0:
                arm = motion[i][1] - motion[parent][1]
                wrenches[parent] = (wrenches[parent][0] + moment + np.cross(arm, force), wrenches[parent][1] + force)
        return np.stack(np.broadcast_arrays(*tau), -1)

    def inverse_dynamics(self, q, qd=None, qdd=None, dx=None, *, gravity=True, joints=True):
        """The joint forces; those of rotors, damping and friction are left out without `joints`."""
        motion = self.motion(q, qd, qdd, dx)
        tau = self.torques(motion, self.wrenches(motion, np.array(self.gravity, REAL) * gravity))
        for link, (_, v, ratio, _) in zip(self.links, self.places) if joints else ():
            for k in range(v, v + SIZES[link.kind][1]):
                if qdd is not None:
                    tau[..., k] += ratio**2 * link.armature * qdd[..., k]
                if qd is not None:
                    rate = ratio * qd[..., k]
                    smooth = rate / np.sqrt(rate**2 + self.width**2)
                    tau[..., k] += ratio * (link.damping * rate + link.friction * smooth)
        return tau

    def mass_matrix(self, q):
        return self.inverse_dynamics(q, None, np.eye(self.nv, dtype=REAL), gravity=False).real

    def forward_dynamics(self, q, qd, tau):
        return solve(self.mass_matrix(q), tau - self.inverse_dynamics(q, qd).real)

    def moments(self, motion):
        """By link: the mass, the centre of mass times the mass, and the inertia, about the origin in world axes."""
        for (axes, *_), mass, first, second in zip(motion, *self.parameters):
            yield mass, times(axes, first), axes @ second @ transposed(axes)

    def wrenches(self, motion, fall):
        """By link: the moment and the force that its acceleration needs under gravity."""
        for (_, _, omega, _, alpha, a, _), (m, c, inertia) in zip(motion, self.moments(motion)):
            a = a - fall
            moment = np.cross(c, a) + times(inertia, alpha) + np.cross(omega, times(inertia, omega))
            yield moment, m * a + np.cross(alpha, c) + np.cross(omega, np.cross(omega, c))

    def center(self, q, dx=None):
        motion = self.motion(q, dx=dx)
        return sum(m * x[1] + c for x, (m, c, _) in zip(motion, self.moments(motion))) / self.parameters[0].sum()

    def potential_energy(self, q):
        return -self.parameters[0].sum() * (self.center(q) @ np.array(self.gravity, REAL))

    def momentum(self, q, qd, qdd=None, dx=None):
        """The momentum about the centre of mass and its rate, linear, then angular."""
        motion, center = self.motion(q, qd, qdd, dx), self.center(q, dx)
        momentum = rate = 0
        both = zip(motion, self.moments(motion), self.wrenches(motion, np.zeros(3, REAL)))
        for (_, p, omega, v, *_), (m, c, inertia), (moment, force) in both:
            arm = p - center
            linear, angular = m * v + np.cross(omega, c), np.cross(c, v) + times(inertia, omega)
            momentum = momentum + np.concatenate(np.broadcast_arrays(linear, angular + np.cross(arm, linear)), -1)
            rate = rate + np.concatenate(np.broadcast_arrays(force, moment + np.cross(arm, force)), -1)
        return momentum, rate

    def external(self, q, wrenches, dx=None, *, world):
        """The joint forces of wrenches on the links at their origins, forces first, in the links' own or in world axes."""
        motion = self.motion(q, dx=dx)
        wrenches = np.asarray(wrenches, REAL)
        parts = [(w[3:], w[:3]) if world else (times(x[0], w[3:]), times(x[0], w[:3])) for x, w in zip(motion, wrenches)]
        return self.torques(motion, parts)

    def twist(self, q, link, qd, dx=None, *, world=True):
        """The velocity of a link, linear, then angular."""
        axes, _, omega, v, *_ = self.motion(q, qd, dx=dx)[link]
        both = v, omega
        if not world:
            both = (times(transposed(axes), x) for x in both)
        return np.concatenate(np.broadcast_arrays(*both), -1)

    def link_acceleration(self, q, qd, qdd, link, *, world=True):
        axes, _, _, _, alpha, a, _ = self.motion(q, qd, qdd)[link]
        return np.concatenate([a, alpha]) if world else np.concatenate([axes.T @ a, axes.T @ alpha])

    # Constraints: rows of linear components, then of angular components times the length.

    def ends(self, constraint, motion):
        """By end: axes, origin, angular velocity, velocity, angular acceleration, acceleration."""
        none = np.zeros(3, REAL)
        for link, xyz, rpy in zip(constraint.links, constraint.xyz, constraint.rpy):
            axes, p, omega, v, alpha, a = motion[link][:6] if link >= 0 else (np.eye(3, dtype=REAL), *[none] * 5)
            arm = times(axes, np.array(xyz, REAL))
            yield (axes @ from_rpy(rpy), p + arm, omega, v + np.cross(omega, arm), alpha,
                   a + np.cross(alpha, arm) + np.cross(omega, np.cross(omega, arm)))

    def directions(self, constraint):
        """The constrained directions of translation and of rotation, as the rows of two matrices."""
        across = np.linalg.svd(np.array(unit(constraint.axis), float)[None])[2][1:].astype(REAL)
        across -= np.outer(across @ unit(constraint.axis), unit(constraint.axis))
        whole, none = np.eye(3, dtype=REAL), np.zeros((0, 3), REAL)
        match constraint.kind:
            case "spherical" | "point":
                return whole, none
            case "fixed" | "surface":
                return whole, whole
            case "revolute" | "continuous":
                return whole, across
            case "prismatic":
                return across, whole

    def relative(self, constraint, q, qd=None, qdd=None, dx=None):
        """The displacement, velocity and acceleration of the second frame relative to the first, in the first frame's axes,
        linear, then angular; all components."""
        (axes, p, w, v, al, a), (axes2, p2, w2, v2, al2, a2) = self.ends(constraint, self.motion(q, qd, qdd, dx))
        arm, moved = p2 - p, v2 - v
        slip = moved - np.cross(w, arm)
        change = a2 - a - np.cross(al, arm) - np.cross(w, moved) - np.cross(w, slip)
        spin = al2 - al - np.cross(w, w2 - w)
        turned, displaced = transposed(axes) @ axes2, times(transposed(axes), arm)
        if -1 in constraint.links:
            # The ground is the plane z = 0.
            angle, displaced = np.cross([0, 0, 1], turned[..., 2]), displaced * [0, 0, 1]
        elif constraint.kind in ("revolute", "continuous"):
            angle = np.cross(unit(constraint.axis), times(turned, unit(constraint.axis)))
        else:
            odd = turned - transposed(turned)
            angle = np.stack([odd[..., 2, 1], odd[..., 0, 2], odd[..., 1, 0]], -1) / 2
        own = lambda *both: np.concatenate(np.broadcast_arrays(*(times(transposed(axes), x) for x in both)), -1)
        place = np.concatenate(np.broadcast_arrays(displaced, angle), -1)
        return place, own(slip, w2 - w), own(change, spin)

    def rows(self, constraint, length, twist):
        """The constrained components, those of rotation times the length."""
        linear, angular = self.directions(constraint)
        return np.concatenate([twist[..., :3] @ linear.T, twist[..., 3:] @ angular.T * length], -1)

    def along_rows(self, lengths, rows, power):
        """By constraint, the sum of its directions times the rows' numbers, rotations times this power of the length."""
        for constraint, length in zip(self.constraints, lengths):
            linear, angular = self.directions(constraint)
            own, rows = np.split(rows, [len(linear) + len(angular)])
            yield np.concatenate([linear.T @ own[:len(linear)], angular.T @ own[len(linear):] * length**power])

    def length(self, constraint):
        """The characteristic length, as docs/internals/constraints.md defines it."""
        neutral = np.zeros(self.nq, REAL)
        for link, place in zip(self.links, self.places):
            if link.kind in ("spherical", "floating"):
                neutral[place[0] + SIZES[link.kind][0] - 1] = 1
        motion, carrier = self.motion(neutral), []
        for i, link in enumerate(self.links):
            carrier.append(i if link.kind != "fixed" else carrier[link.parent] if link.parent >= 0 else -1)
        mass, first, second = self.parameters

        def gyration(i):
            own = [k for k in range(len(self.links)) if carrier[k] == i]
            squares = 0
            for k in own:
                arm = motion[k][1] - motion[i][1]
                squares += np.trace(second[k]) / 2 + 2 * arm @ (motion[k][0] @ first[k]) + mass[k] * (arm @ arm)
            return np.sqrt(squares / mass[own].sum())

        distance = lambda x, y: np.sqrt((x - y) @ (x - y))
        ends = [[carrier[link] if link >= 0 else -1, end[1]] for link, end in zip(constraint.links, self.ends(constraint, motion))]
        length = REAL(0)
        while ends[0][0] != ends[1][0]:
            later = max(ends, key=lambda end: end[0])
            i, point = later
            length += distance(point, motion[i][1]) + gyration(i)
            parent = self.links[i].parent
            later[:] = [carrier[parent] if parent >= 0 else -1, motion[i][1]]
        return length if -1 in constraint.links else length + distance(ends[0][1], ends[1][1])

    def forces(self, constraint, wrench, q, dx=None):
        """The joint forces of a wrench on the second link, in the first frame's axes, and its opposite on the first."""
        motion = self.motion(q, dx=dx)
        (axes, *_), (_, p2, *_) = self.ends(constraint, motion)
        force, moment = times(axes, wrench[..., :3]), times(axes, wrench[..., 3:])
        on = [(np.zeros(3, REAL), np.zeros(3, REAL)) for _ in self.links]
        for link, sign in zip(constraint.links, (-1, 1)):
            if link >= 0:
                arm = p2 - motion[link][1]
                on[link] = (on[link][0] + sign * (moment + np.cross(arm, force)), on[link][1] + sign * force)
        return self.torques(motion, on)

    def by_tangent(self, of, size=None):
        """The derivatives of `of(step)`, whose steps are rows of a matrix: column k is that along entry k."""
        size = size or self.nv
        changes = of(1j * STEP * np.eye(size, dtype=REAL)).imag / STEP
        changes = changes if changes.ndim > 1 else changes[None]
        return np.moveaxis(np.broadcast_to(changes, (size, *changes.shape[1:])), 0, -1)
