"""The functions of random robots beside a textbook's mechanics (`naive.py`), by machine code and by evaluated programs.

`MODYN_SEEDS=1000..1100 pytest tests/test_random.py -s` takes other seeds, and shows how many states were left out.

The tolerances and the limits of the first two rules were fixed before the first comparison:

- A number may differ by `DIRECT` of its array's largest number and 1. Where the mass matrix or the constraints are solved for,
  by `SOLVED` times the condition numbers of both, if that is more.
- A state is left out of the functions that solve for constraints if its rank is not defined: an eigenvalue of J M^-1 J^T, whose
  rows are divided by the roots of their constraints' mobilities, is within `UNDEFINED` (docs/contacts.md).
- `constrained_inverse_dynamics` has the second rule for the squared singular values of the base's columns. There the lengths, and the
  weights of what no contact can carry, are modyn's own.
- A state whose rows contradict each other, by more than `CONTRADICTION` of the accelerations, is left out of the derivatives,
  which are not defined there (docs/contacts.md).

Hessians, time steps and derivatives of coordinates have references in Rust's tests; the suite of back ends (`modyn-jit/tests/conformance`)
compares every function of the package with those.
"""

import os
from collections import Counter
from dataclasses import replace

import numpy as np
from naive import REAL, SIZES, STEP, Constraint, Link, Naive, solve, to_rpy

import modyn

DIRECT, SOLVED = 1e-10, 1e-13
UNDEFINED = 1e-13, 1e-6
CONTRADICTION = 1e-8
STATES = 2


def seeds():
    first, end = os.environ.get("MODYN_SEEDS", "0..8").split("..")
    return range(int(first), int(end))


def body(rng):
    """The mass, the centre of mass and the inertia of six point masses."""
    points, masses = rng.normal(size=(6, 3)) * 0.2 + rng.normal(size=3) * 0.1, rng.uniform(0.1, 1, 6)
    com = masses @ points / masses.sum()
    arms = points - com
    tensor = sum(m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, arms))
    return {"mass": masses.sum(), "com": tuple(com), "inertia": tuple(tensor[np.triu_indices(3)])}


def joint(rng, kind, aligned):
    """The placement and the axes of a joint: in general position, at right angles, or of a mechanism in a plane."""
    axis, axis2 = rng.normal(size=(2, 3))
    xyz, rpy = rng.uniform(-0.5, 0.5, 3), rng.uniform(-3, 3, 3)
    if aligned:
        axis, axis2 = rng.permutation(np.eye(3))[:2] * rng.choice([-1, 1])
        xyz, rpy = xyz * rng.integers(0, 2, 3), rng.integers(-1, 3, 3) * np.pi / 2
    if aligned == "planar":
        axis, rpy = np.eye(3)[0 if kind == "prismatic" else 2], rpy * [0, 0, 1]
    axes = {name: tuple(v / np.linalg.norm(v)) for name, v in (("axis", axis), ("axis2", axis2))}
    return {"kind": kind, "xyz": tuple(xyz), "rpy": tuple(rpy), **axes}


class Case:
    """A random robot: its description, its options and its mechanics."""

    def __init__(self, seed):
        self.rng = rng = np.random.default_rng(seed)
        self.floating = rng.random() < (0.8 if seed % 4 == 3 else 0.5)
        self.aligned = rng.choice(["", "", "right angles"])
        self.dynamics = rng.random() < 0.3
        self.links = [Link(-1, "floating", **body(rng))] if self.floating else []
        self.loops, self.contacts, self.q = [], [], None
        match ("tree", "limbs", "loops", "contacts")[seed % 4]:
            case "tree":
                self.tree(int(rng.integers(2, 6)))
                self.mimics()
            case "limbs":
                self.limbs()
            case "loops":
                self.aligned = rng.choice([self.aligned, "planar"])
                self.tree(int(rng.integers(3, 8)))
                self.close(rng.random() < 0.6)
            case "contacts":
                rng.choice([self.limbs, lambda: self.tree(int(rng.integers(2, 7)))])()
                self.touch()
        self.naive = Naive(self.links, constraints=[*self.loops, *self.contacts])

    def random(self):
        """Random coordinates."""
        naive = Naive(self.links)
        q = self.rng.uniform(-2, 2, naive.nq)
        for link, (at, *_) in zip(self.links, naive.places):
            if link.kind in ("spherical", "floating"):
                quaternion = q[at + SIZES[link.kind][0] - 4:][:4]
                quaternion /= np.linalg.norm(quaternion)
        return q

    def kind(self):
        if self.aligned == "planar":
            return str(self.rng.choice(["revolute", "revolute", "prismatic"]))
        kinds = ["revolute", "revolute", "continuous", "prismatic", "universal", "planar", "spherical", "fixed"]
        return str(self.rng.choice(kinds))

    def add(self, parent, kind):
        rng = self.rng
        dynamics = {"armature": rng.uniform(0, 0.2), "damping": rng.uniform(0, 1), "friction": rng.uniform(0, 1)}
        dynamics = dynamics if self.dynamics and SIZES[kind][1] == 1 else {}
        self.links.append(Link(parent, **joint(rng, kind, self.aligned), **body(rng), **dynamics))
        return len(self.links) - 1

    def tree(self, count):
        path = [len(self.links) - 1]
        for _ in range(count):
            path = path[:self.rng.integers(1, len(path) + 1)] if self.rng.random() < 0.4 else path
            path.append(self.add(path[-1], self.kind()))
        if not any(SIZES[link.kind][1] for link in self.links):
            self.add(path[-1], "revolute")

    def limbs(self):
        """Limbs of the same joint types on a trunk: equal ones, mirrored ones, or of other numbers."""
        rng, trunk = self.rng, len(self.links) - 1
        if rng.random() < 0.5:
            trunk = self.add(trunk, self.kind())
        kinds = [str(rng.choice(["revolute", "revolute", "prismatic"])) for _ in range(rng.integers(1, 4))]
        likeness, first = rng.integers(0, 3), None
        for k in range(rng.integers(2, 6)):
            start, parent = len(self.links), trunk
            for kind in kinds:
                parent = self.add(parent, kind)
            if first is None:
                first = self.links[start:]
            elif likeness < 2:
                for i, link in enumerate(first):
                    place = self.links[start + i].xyz if i == 0 else link.xyz
                    if likeness == 1:
                        link = mirrored(link)
                    parent = trunk if i == 0 else start + i - 1
                    self.links[start + i] = replace(link, parent=parent, xyz=place)

    def mimics(self):
        single = [i for i, link in enumerate(self.links) if SIZES[link.kind][1] == 1]
        for i in single[1:]:
            if self.rng.random() < 0.4:
                self.links[i].mimic = single[0], self.rng.uniform(-1.5, 1.5), self.rng.uniform(-1, 1)

    def close(self, closed):
        """Adds one or two loops; `closed`, if they are at the coordinates `q` of all states."""
        rng = self.rng
        pairs = [(i, j) for j in range(len(self.links)) for i in range(j) if self.between(i, j)]
        for _ in range(rng.integers(1, 3) if pairs else 0):
            places, turns = rng.uniform(-0.3, 0.3, (2, 3)), rng.uniform(-3, 3, (2, 3))
            axis = rng.normal(size=3)
            kind = str(rng.choice(["spherical", "fixed", "revolute", "prismatic"]))
            if self.aligned == "planar":
                turns, axis = turns * [0, 0, 1], np.eye(3)[0 if kind == "prismatic" else 2]
            axis = tuple(axis / np.linalg.norm(axis))
            self.loops.append(Constraint(kind, pairs[rng.integers(len(pairs))], list(places), list(turns), axis))
        if closed:
            naive = Naive(self.links)
            self.q = self.random()
            motion = naive.motion(self.q)
            for loop in self.loops:
                axes, origin, *_ = next(naive.ends(loop, motion))
                own, place, *_ = motion[loop.links[1]]
                loop.xyz[1] = (own.T @ (origin - place)).astype(float)
                loop.rpy[1] = np.array(to_rpy(own.T @ axes), float)

    def touch(self):
        """Adds contacts of the last links of limbs or branches."""
        rng = self.rng
        parents = {link.parent for link in self.links}
        naive = Naive(self.links)
        for i, link in enumerate(self.links):
            if i not in parents and naive.moving[i] or rng.random() < 0.1 and naive.moving[i]:
                own = [(0.0,) * 3, rng.uniform(-0.2, 0.2, 3)], [(0.0,) * 3, rng.uniform(-3, 3, 3)]
                self.contacts.append(Constraint(str(rng.choice(["point", "point", "surface"])), (-1, i), *own))

    def between(self, i, j):
        """Whether a joint moves the two links relative to each other."""
        ancestors = lambda k: {k, *ancestors(self.links[k].parent)} if k >= 0 else set()
        return any(SIZES[self.links[k].kind][1] for k in ancestors(i) ^ ancestors(j))

    def name(self, i):
        return "base" if i == -1 or self.floating and i == 0 else f"link{i}"

    def urdf(self):
        numbers = lambda values: " ".join(f"{x:.17g}" for x in values)
        text = ['<robot name="random">', "" if self.floating else '<link name="base"/>']
        for i, link in enumerate(self.links):
            entries = " ".join(f'{name}="{x:.17g}"' for name, x in zip(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), link.inertia))
            text.append(f'<link name="{self.name(i)}"><inertial><origin xyz="{numbers(link.com)}"/>'
                        f'<mass value="{link.mass:.17g}"/><inertia {entries}/></inertial></link>')
            if self.floating and i == 0:
                continue
            axes = f'<axis xyz="{numbers(link.axis)}"/>' * (link.kind not in ("fixed", "spherical"))
            axes += f'<axis2 xyz="{numbers(link.axis2)}"/>' * (link.kind == "universal")
            more = ""
            if self.dynamics and SIZES[link.kind][1] == 1:
                more = f'<dynamics damping="{link.damping:.17g}" friction="{link.friction:.17g}" armature="{link.armature:.17g}"/>'
            if link.kind in ("revolute", "prismatic"):
                more += '<limit lower="-3" upper="3" effort="9" velocity="9"/>'
            if link.mimic:
                leader, multiplier, offset = link.mimic
                more += f'<mimic joint="joint{leader}" multiplier="{multiplier:.17g}" offset="{offset:.17g}"/>'
            text.append(f'<joint name="joint{i}" type="{link.kind}"><parent link="{self.name(link.parent)}"/>'
                        f'<child link="{self.name(i)}"/><origin xyz="{numbers(link.xyz)}" rpy="{numbers(link.rpy)}"/>'
                        f'{axes}{more}</joint>')
        for k, loop in enumerate(self.loops):
            axis = f'<axis xyz="{numbers(loop.axis)}"/>' * (loop.kind in ("revolute", "prismatic"))
            ends = "".join(f'<link{n} link="{self.name(i)}" xyz="{numbers(xyz)}" rpy="{numbers(rpy)}"/>'
                           for n, i, xyz, rpy in zip((1, 2), loop.links, loop.xyz, loop.rpy))
            text.append(f'<loop_joint name="loop{k}" type="{loop.kind}">{ends}{axis}</loop_joint>')
        for k, contact in enumerate(self.contacts):
            text.append(f'<contact_frame name="contact{k}" type="{contact.kind}" link="{self.name(contact.links[1])}" '
                        f'xyz="{numbers(contact.xyz[1])}" rpy="{numbers(contact.rpy[1])}"/>')
        return "\n".join([*text, "</robot>"])

    def load(self, **options):
        base = "floating" if self.floating else "fixed"
        friction = ("smooth", self.naive.width) if self.dynamics else "none"
        return modyn.loads(self.urdf(), base=base, joint_friction=friction, **options)


def mirrored(link):
    """The link mirrored at the plane y = 0."""
    flip = lambda v: (v[0], -v[1], v[2])
    xx, xy, xz, yy, yz, zz = link.inertia
    rpy, axis = (-link.rpy[0], link.rpy[1], -link.rpy[2]), tuple(-x for x in flip(link.axis))
    return replace(link, xyz=flip(link.xyz), rpy=rpy, axis=axis, com=flip(link.com), inertia=(xx, -xy, xz, yy, -yz, zz))


class State:
    """A random state of a case, and the results of its functions by the textbook.

    Each function is a tuple: name, arguments, expected results, whether the mass matrix is solved for, and optionally a function
    from its result to what is compared.
    """

    def __init__(self, case, rng):
        self.case, self.naive, self.rng = case, case.naive, rng
        self.q = case.random() if case.q is None else case.q
        scales = np.array([1, 3, 5, 1, 1, 1])[:, None]
        self.qd, self.qdd, self.tau, self.x, self.y, self.z = rng.normal(size=(6, self.naive.nv)) * scales
        self.mass = self.naive.mass_matrix(self.q)
        self.inverse = np.linalg.inv(self.mass.astype(float))
        self.condition = np.linalg.cond(self.mass.astype(float))
        self.rows_condition, self.left_out = 1.0, []

    def tree(self):
        naive, mass, q, qd, qdd, tau, n = self.naive, self.mass, self.q, self.qd, self.qdd, self.tau, self.naive.nv
        x, y, z, by, eye = self.x, self.y, self.z, naive.by_tangent, np.eye(self.naive.nv, dtype=REAL)
        force, gravity = naive.inverse_dynamics(q, qd, qdd).real, naive.inverse_dynamics(q, joints=False).real
        yield "inverse_dynamics", (q, qd, qdd), force, False
        yield "bias_forces", (q, qd), naive.inverse_dynamics(q, qd).real, False
        yield "gravity_torques", (q,), gravity, False
        yield "mass_matrix", (q,), mass, False
        yield "kinetic_energy", (q, qd), qd @ mass @ qd / 2, False
        yield "potential_energy", (q,), naive.potential_energy(q), False
        # C qd, and C + C^T, the rate of the mass matrix.
        velocity = naive.inverse_dynamics(q, qd, gravity=False, joints=False).real
        rate = naive.inverse_dynamics(q, None, eye, 1j * STEP * qd, gravity=False).imag / STEP
        yield "coriolis_matrix", (q, qd), (velocity, rate), False, lambda c: (c @ qd, c + c.T)
        theirs = self.robot.parameters
        yield "regressor", (q, qd, qdd), naive.inverse_dynamics(q, qd, qdd, joints=False).real, False, lambda y: y @ theirs

        slopes = lambda qdd: (by(lambda dx: naive.inverse_dynamics(q, qd, qdd, dx)),
                              by(lambda dx: naive.inverse_dynamics(q, qd + dx, qdd)))
        dq, dqd = slopes(qdd)
        yield "inverse_dynamics_derivatives", (q, qd, qdd), (dq, dqd), False
        yield "inverse_dynamics_vjp", (q, qd, qdd, x), (force, x @ dq, x @ dqd, mass @ x), False
        yield "inverse_dynamics_jvp", (q, qd, qdd, x, y, z), (force, dq @ x + dqd @ y + mass @ z), False
        moved, inverse = naive.forward_dynamics(q, qd, tau), solve(mass, eye)
        dq, dqd = (-inverse @ part for part in slopes(moved))
        yield "forward_dynamics", (q, qd, tau), moved, True
        yield "forward_dynamics_derivatives", (q, qd, tau), (moved, dq, dqd, inverse), True
        yield "forward_dynamics_vjp", (q, qd, tau, x), (moved, x @ dq, x @ dqd, inverse @ x), True
        yield "forward_dynamics_jvp", (q, qd, tau, x, y, z), (moved, dq @ x + dqd @ y + inverse @ z), True
        dt, rates = 0.01, qd + 0.01 * moved
        yield "step_semi_implicit", (q, qd, tau, dt), rates, True, lambda step: step.qd
        stepped = np.array(dt * rates, float)
        ends = self.robot.integrate(q, stepped)
        yield "step_semi_implicit", (q, qd, tau, dt), ends, True, lambda step: step.q
        yield "difference", (q, ends), stepped, False

        count, base = len(self.case.links), 0 if self.case.floating else 1
        wrenches = self.rng.normal(size=(count + base, 6)) * 5
        for end, world in ("_local", False), ("", True):
            of = lambda dx=None: naive.external(q, wrenches[base:], dx, world=world)
            outside = of().real
            yield f"generalized_forces{end}", (q, wrenches), (outside, by(of)), False
            yield f"inverse_dynamics_external{end}", (q, qd, qdd, wrenches), force - outside, False
            yield f"forward_dynamics_external{end}", (q, qd, tau, wrenches), naive.forward_dynamics(q, qd, tau + outside), True

        yield "center_of_mass", (q,), naive.center(q), False
        yield "center_of_mass_jacobian", (q,), by(lambda dx: naive.center(q, dx)), False
        momentum, rate = naive.momentum(q, qd, qdd)
        yield "centroidal_momentum", (q, qd), momentum, False
        yield "centroidal_momentum_matrix", (q,), naive.momentum(q, eye)[0].T, False
        yield "centroidal_momentum_rate", (q, qd, qdd), rate, False
        changes = [by(lambda dx: naive.momentum(q, qd, qdd, dx)[k]) for k in (0, 1)]
        changes.append(by(lambda dx: naive.momentum(q, qd + dx, qdd)[1]))
        yield "centroidal_momentum_derivatives", (q, qd, qdd), (momentum, rate, *changes), False

        poses = [(np.eye(3), np.zeros(3))] * base + [link[:2] for link in naive.motion(q)]
        yield "link_poses", (q,), tuple(np.array(part) for part in zip(*poses)), False
        for i in {0, count // 2, count - 1}:
            link = i + base
            yield "link_pose", (q, link), poses[link], False
            for end, world in ("", True), ("_local", False):
                twist = lambda *state: naive.twist(q, i, *state, world=world)
                jacobian = np.broadcast_to(twist(eye), (n, 6)).T
                rate = np.broadcast_to(twist(eye, 1j * STEP * qd).imag / STEP, (n, 6)).T
                yield f"link_velocity{end}", (q, qd, link), twist(qd), False
                yield f"jacobian{end}", (q, link), jacobian, False
                yield f"jacobian_time_derivative{end}", (q, qd, link), rate, False
                yield f"jacobian_dot_qd{end}", (q, qd, link), rate @ qd, False
                acceleration = naive.link_acceleration(q, qd, qdd, i, world=world)
                yield f"link_acceleration{end}", (q, qd, qdd, link), acceleration, False

    def constrained(self):
        """The functions of constraints. `left_out` has the reasons why the state is left out of some."""
        naive, mass, q, qd, qdd, tau, n = self.naive, self.mass, self.q, self.qd, self.qdd, self.tau, self.naive.nv
        each, eye, zero = naive.constraints, np.eye(self.naive.nv, dtype=REAL), np.zeros(self.naive.nv)
        lengths = [naive.length(c) for c in each]
        # Displacements, velocities or accelerations of all constraints; all rows; and twists or wrenches from rows.
        relative = lambda k, *state: [naive.relative(c, *state)[k] for c in each]
        rows = lambda twists: np.concatenate([naive.rows(*both) for both in zip(each, lengths, twists)], -1)
        twists = lambda rows, power: np.array(list(naive.along_rows(lengths, rows, power)))
        motions = [np.broadcast_to(twist, (n, 6)) for twist in relative(1, q, eye)]
        jacobian, scales = rows(motions).T, []
        for c, length, motion in zip(each, lengths, motions):
            own = naive.rows(c, length, motion)
            # The mobility of contacts of a floating robot is that of the rows, else that of all directions.
            whole = own if self.case.floating and -1 in c.links else motion * np.repeat([length, 1], 3)
            whole = whole.astype(float)
            scales += [np.sqrt(np.trace(whole.T @ self.inverse @ whole)) or 1.0] * own.shape[1]
        place, velocity = rows(relative(0, q)), rows(relative(1, q, qd))
        yield "constraint_jacobian", (q,), twists(jacobian, -1), False
        yield "constraint_jacobian_dot_qd", (q, qd), twists(rows(relative(2, q, qd)), -1), False
        yield "constraint_residual", (q, qd), (twists(place, -1), twists(velocity, -1)), False
        force = naive.inverse_dynamics(q, qd, qdd).real
        if self.contacts_on_base:
            # The wrenches of smallest norm that carry the base, whose six entries are the first, forces before moments.
            units = np.repeat([1, len(lengths) / sum(lengths)], 3)
            base = (jacobian[:, :6] * units).astype(float)
            squares = np.linalg.svd(base)[1]**2
            squares /= squares.max()
            if within(squares):
                self.left_out.append("rank of the base's columns")
            else:
                carried = np.linalg.pinv(base.T, rcond=1e-5) @ (force[:6] * units).astype(float)
                forces = force - jacobian.T @ carried, twists(carried, 1), (squares > UNDEFINED[1]).sum()
                yield "constrained_inverse_dynamics", (q, qd, qdd), forces, True
        else:
            yield "constrained_inverse_dynamics", (q, qd, qdd), (force, np.zeros((len(each), 6)), 0), False

        scaled = jacobian.astype(float) / np.array(scales)[:, None]
        values = np.linalg.eigvalsh(scaled @ self.inverse @ scaled.T)
        if within(values):
            self.left_out.append("rank")
            return
        rank = (values > UNDEFINED[1]).sum()
        self.rows_condition = 1 / values[values > UNDEFINED[1]].min(initial=1.0)
        basis = np.linalg.svd(jacobian.astype(float))[0][:, :rank]
        independent = basis.T @ jacobian
        matrix = np.block([[mass, -independent.T], [independent, np.zeros((rank, rank))]])

        def solved(force, sides):
            """The accelerations and the multipliers under joint forces, for right-hand sides of the rows."""
            both = solve(matrix, np.concatenate([force, basis.T @ sides]))
            return both[:n], basis @ both[n:]

        stabilized = lambda *state: rows([a + 2 * 20 * v + 20**2 * x for x, v, a in zip(*(relative(k, *state) for k in range(3)))])
        if self.case.q is not None:
            # The loops are closed, and stay closed.
            qd = np.array(qd - solved(zero, velocity)[0], float)
            velocity = rows(relative(1, q, qd))
        target = -stabilized(q, qd)
        moved, forces = solved(tau - naive.inverse_dynamics(q, qd).real, target)
        missed, wrenches = jacobian @ moved - target, twists(forces, 1)
        yield "constrained_forward_dynamics", (q, qd, tau), (moved, wrenches, twists(missed, -1), rank), True
        change, impulses = solved(zero, -velocity)
        yield "impact_dynamics", (q, qd), (qd + change, twists(impulses, 1), rank), True
        yield "project_constraints", (q, qd), (solved(zero, -place)[0], change, rank), True
        # The directions of the rows of a hinge or a slider are not unique.
        if all(c.kind not in ("revolute", "prismatic") for c in each):
            units = np.concatenate([naive.rows(c, length, np.ones(6)) for c, length in zip(each, lengths)])
            delassus = jacobian @ solve(mass, jacobian.T) / np.outer(units, units)
            inertia = basis @ solve(independent @ solve(mass, independent.T), basis.T) * np.outer(units, units)
            yield "operational_space_inertia", (q,), (delassus, inertia, rank), True
        if np.abs(missed).max(initial=0) > CONTRADICTION * (1 + np.abs(target).max(initial=0)):
            self.left_out.append("contradiction")
            return
        held = lambda dx: sum(naive.forces(c, wrench, q, dx) for c, wrench in zip(each, wrenches))
        by = naive.by_tangent
        changes = [
            solved(-by(lambda dx: naive.inverse_dynamics(q, qd, moved, dx) - held(dx)),
                   -by(lambda dx: stabilized(q, qd, moved, dx))),
            solved(-by(lambda dx: naive.inverse_dynamics(q, qd + dx, moved)), -by(lambda dx: stabilized(q, qd + dx, moved))),
            solved(eye, 0 * jacobian),
        ]
        moves, pushes = zip(*changes)
        results = moved, wrenches, *moves, *(twists(push, 1) for push in pushes), rank
        yield "constrained_forward_dynamics_derivatives", (q, qd, tau), results, True

    @property
    def contacts_on_base(self):
        return self.case.floating and self.case.contacts


def within(values):
    return ((values > UNDEFINED[0]) & (values < UNDEFINED[1])).any()


def arrays(results):
    return results if isinstance(results, tuple) else (results,)


def check(case, seed, counts):
    """Compares all functions of a case, and returns the disagreements."""
    robots = case.load(), case.load(machine_code=False)
    rng, wrong = np.random.default_rng(seed + 1), []

    def compare(state, name, arguments, expected, solved, part=lambda result: result):
        tolerance = max(DIRECT, SOLVED * state.condition * state.rows_condition * solved)
        for robot, kind in zip(robots, ("machine code", "program")):
            result = part(getattr(robot, name)(*arguments))
            for k, (found, right) in enumerate(zip(arrays(result), arrays(expected), strict=True)):
                right = np.asarray(right, float)
                assert np.shape(found) == right.shape, (name, k, np.shape(found), right.shape)
                counts["comparisons"] += 1
                difference = np.abs(found - right).max(initial=0.0) / (1 + np.abs(right).max(initial=0.0))
                if not difference <= tolerance:
                    wrong.append(f"seed {seed}: {name} {k} by {kind}: {difference:.1e} > {tolerance:.1e}")

    for _ in range(STATES):
        state = State(case, rng)
        state.robot = robots[1]
        counts["states"] += 1
        for function in state.tree():
            compare(state, *function)
        if case.naive.constraints:
            counts["states with constraints"] += 1
            for function in state.constrained():
                compare(state, *function)
            counts.update(f"left out ({reason})" for reason in state.left_out)
    return wrong


def test_random_robots():
    counts, wrong = Counter(), []
    for seed in seeds():
        counts["robots"] += 1
        try:
            wrong += check(Case(seed), seed, counts)
        except Exception as error:
            wrong.append(f"seed {seed}: {type(error).__name__}: {error}")
    print(*(f"{name}: {count}" for name, count in counts.items()), sep=", ")
    assert not wrong, "\n".join(wrong)


def test_near_a_change_of_rank():
    """The foot of a leg of two links is held. docs/contacts.md has the angles of the knee at which the row along the leg is dropped."""
    case = Case(3)
    thigh = Link(-1, "revolute", (0.1, 0.2, 0.3), (0.3, 0.7, -0.4), (0.0, 1.0, 0.0), **body(case.rng))
    shank = Link(0, "revolute", (0.0, 0.0, -0.4), axis=(0.0, 1.0, 0.0), **body(case.rng))
    foot = Constraint("point", (-1, 1), [(0.0,) * 3, (0.0, 0.0, -0.4)], [(0.0,) * 3] * 2)
    case.links, case.contacts, case.floating, case.dynamics = [thigh, shank], [foot], False, False
    case.naive = Naive(case.links, constraints=case.contacts)
    exact = modyn.ConstraintSettings(targets=[modyn.ContactTarget()], tolerance=1e-14, rounding=1e-14)
    for robot in case.load(), case.load(machine_code=False):
        for angle, rank in (0.1, 2), (1e-3, 2), (1e-5, 1), (0.0, 1):
            state = State(case, np.random.default_rng(1))
            state.q = np.array([0.4, angle])
            arguments = state.q, state.qd, state.tau
            found = robot.constrained_forward_dynamics(*arguments)
            assert found.rank == rank, angle
            if angle == 1e-5:
                # What was not met shows, and a smaller tolerance holds the row: the accelerations are large.
                assert np.abs(found.residuals).max() > 1 > 1e-3 * np.abs(found.qdd).max()
                held = robot.constrained_forward_dynamics(*arguments, settings=exact)
                assert held.rank == 2 and np.abs(held.qdd).max() > 1e5
