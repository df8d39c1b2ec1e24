"""Contacts: `constraintDynamics`, `impulseDynamics` and `computeConstraintDynamicsDerivatives` with points and surfaces
of floating robots, checked by a dense solution and by differences.

Reference frames are LOCAL_WORLD_ALIGNED, so forces and their derivatives are in world axes. Active surfaces are at rest:
Pinocchio holds the spatial acceleration of a 6D contact and the classical acceleration of a 3D contact, which differ
where a contact moves.
"""

import dataclasses

import numpy
import pinocchio

from quantities import symmetric

WORLD = pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
#: Absolute accuracy, relative accuracy, mu, most iterations.
PROXIMAL = (1e-14, 1e-12, 1e-6, 100)
#: `impulseDynamics` solves once, so its result is off by about mu times the impulse divided by the least mobility.
PROXIMAL_IMPULSE = (1e-14, 1e-12, 1e-13, 1)
RESTITUTION = 0.3


@dataclasses.dataclass
class Contact:
    """A frame on a link, as modyn's option `contacts` has it."""
    name: str
    kind: str
    link: str
    xyz: list
    rpy: list

    @property
    def rows(self):
        return 3 if self.kind == "point" else 6

    def placement(self):
        return pinocchio.SE3(pinocchio.rpy.rpyToMatrix(numpy.array(self.rpy)), numpy.array(self.xyz))


FEET = [Contact(foot, "point", f"{foot}_FOOT", [0.003, side * 0.008, -0.01], [0.2, -0.4, 0.7])
        for foot, side in (("FL", 1), ("FR", -1), ("HL", 1), ("HR", -1))]
SOLES = [Contact("left_sole", "surface", "left_ankle_roll_link", [0.04, 0.01, -0.03], [0.1, -0.2, 0.3]),
         Contact("right_sole", "surface", "right_ankle_roll_link", [0.04, -0.01, -0.03], [-0.1, -0.2, 0.5]),
         Contact("hand", "point", "left_rubber_hand", [0.1, 0.02, -0.03], [0.3, 0.2, 0.1])]
#: By file: the robot, its contacts, and the active contacts of each state.
ROBOTS = {
    "contacts_solo12": ("solo12", FEET, [["FL", "FR", "HL", "HR"], ["FL", "HR"], ["FR", "HL", "HR"], ["HL"]]),
    "contacts_g1": ("g1", SOLES, [["left_sole", "right_sole"], ["right_sole"], ["left_sole", "right_sole", "hand"]]),
}


class Standing:
    """A floating robot with some active contacts."""

    def __init__(self, path, contacts):
        self.model = pinocchio.buildModelFromUrdf(str(path), pinocchio.JointModelFreeFlyer())
        self.contacts, self.frames, self.constraints = contacts, [], pinocchio.StdVec_RigidConstraintModel()
        for contact in contacts:
            link = self.model.frames[self.model.getFrameId(contact.link, pinocchio.FrameType.BODY)]
            place = link.placement * contact.placement()
            frame = pinocchio.Frame(f"contact {contact.name}", link.parentJoint, place, pinocchio.FrameType.OP_FRAME)
            self.frames.append(self.model.addFrame(frame))
            kind = pinocchio.ContactType.CONTACT_3D if contact.rows == 3 else pinocchio.ContactType.CONTACT_6D
            self.constraints.append(
                pinocchio.RigidConstraintModel(kind, self.model, link.parentJoint, place, WORLD))

    def data(self):
        """Memory for Pinocchio's solvers."""
        data, contents = self.model.createData(), pinocchio.StdVec_RigidConstraintData()
        contents.extend([constraint.createData() for constraint in self.constraints])
        pinocchio.initConstraintDynamics(self.model, data, self.constraints, contents)
        return data, contents

    def forces(self, contents):
        """Of all contacts, linear first; a point has three."""
        pairs = zip(self.contacts, contents)
        return numpy.concatenate([found.contact_force.vector[:contact.rows] for contact, found in pairs])

    def accelerations(self, q, v, tau):
        data, contents = self.data()
        settings = pinocchio.ProximalSettings(*PROXIMAL)
        qdd = pinocchio.constraintDynamics(self.model, data, q, v, tau, self.constraints, contents, settings).copy()
        return numpy.concatenate([qdd, self.forces(contents)]), (data, contents, settings)

    def derivatives(self, q, v, tau):
        """Of accelerations and of forces, by q, v and tau."""
        _, (data, contents, settings) = self.accelerations(q, v, tau)
        pinocchio.computeConstraintDynamicsDerivatives(self.model, data, self.constraints, contents, settings)
        parts = ((data.ddq_dq, data.dlambda_dq), (data.ddq_dv, data.dlambda_dv), (data.ddq_dtau, data.dlambda_dtau))
        return [numpy.vstack(pair) for pair in parts]

    def impact(self, q, v, restitution):
        data, contents = self.data()
        settings = pinocchio.ProximalSettings(*PROXIMAL_IMPULSE)
        after = pinocchio.impulseDynamics(self.model, data, q, v, self.constraints, contents, restitution, settings)
        return numpy.concatenate([after.copy(), self.forces(contents)])

    def rows(self, q, v):
        """The Jacobian of the active contacts and the acceleration without joint accelerations, in world axes."""
        data = self.model.createData()
        pinocchio.forwardKinematics(self.model, data, q, v, numpy.zeros(self.model.nv))
        pinocchio.computeJointJacobians(self.model, data, q)
        pinocchio.updateFramePlacements(self.model, data)
        pairs = list(zip(self.contacts, self.frames))
        jacobian = [pinocchio.getFrameJacobian(self.model, data, frame, WORLD)[:contact.rows]
                    for contact, frame in pairs]
        bias = [pinocchio.getFrameClassicalAcceleration(self.model, data, frame, WORLD).vector[:contact.rows]
                for contact, frame in pairs]
        return numpy.vstack(jacobian), numpy.concatenate(bias)

    def dense(self, q, force, wanted):
        """x and f of M x = force + J^T f, J x = wanted, and J."""
        jacobian = self.rows(q, numpy.zeros(self.model.nv))[0]
        mass = symmetric(pinocchio.crba(self.model, self.model.createData(), q))
        n, m = self.model.nv, len(wanted)
        matrix = numpy.block([[mass, -jacobian.T], [jacobian, numpy.zeros((m, m))]])
        return numpy.linalg.solve(matrix, numpy.concatenate([force, wanted])), mass

    def difference(self, q, v, tau):
        """The largest difference of this state's results to dense solutions and to differences."""
        def relative(found, expected):
            return float(numpy.abs(found - expected).max() / max(1.0, numpy.abs(expected).max()))

        n = self.model.nv
        bias = pinocchio.nonLinearEffects(self.model, self.model.createData(), q, v)
        dense, mass = self.dense(q, tau - bias, -self.rows(q, v)[1])
        found = self.accelerations(q, v, tau)[0]
        worst = max(relative(found[:n], dense[:n]), relative(found[n:], dense[n:]))
        found, jacobian = self.impact(q, v, RESTITUTION), self.rows(q, v)[0]
        dense, _ = self.dense(q, mass @ v, -RESTITUTION * jacobian @ v)
        worst = max(worst, relative(found[:n], dense[:n]), relative(found[n:], dense[n:]))

        by_differences = []
        # Results are quadratic in v and linear in tau, so long steps have no error but rounding.
        moves = ((2e-4, lambda step: (pinocchio.integrate(self.model, q, step), v, tau)),
                 (0.1, lambda step: (q, v + step, tau)), (1.0, lambda step: (q, v, tau + step)))
        for length, move in moves:
            columns = []
            for unit in numpy.eye(n):
                def slope(step):
                    ahead, back = (self.accelerations(*move(s * unit))[0] for s in (step, -step))
                    return (ahead - back) / (2 * step)
                near, far = slope(length), slope(2 * length)
                columns.append(near + (near - far) / 3)
            by_differences.append(numpy.array(columns).T)
        for found, expected in zip(self.derivatives(q, v, tau), by_differences):
            worst = max(worst, relative(found[:n], expected[:n]), relative(found[n:], expected[n:]))
        return worst

    def by_contact(self, rows):
        """The rows of each contact, by name."""
        ends = numpy.cumsum([contact.rows for contact in self.contacts])
        return dict(zip((contact.name for contact in self.contacts), numpy.split(rows, ends[:-1])))


def state(path, contacts, random):
    """A state in general position and what Pinocchio finds there; how much that differs from the checks."""
    robot = Standing(path, contacts)
    model = robot.model
    n = model.nv
    q = pinocchio.integrate(model, pinocchio.neutral(model), random.uniform(-0.8, 0.8, n))
    before = random.uniform(-1.5, 1.5, n)
    jacobian = robot.rows(q, before)[0]
    # Surfaces rest; points move.
    ends = numpy.cumsum([contact.rows for contact in contacts])
    held = jacobian[[k for contact, end in zip(contacts, ends) if contact.rows == 6 for k in range(end - 6, end)]]
    v = before - numpy.linalg.pinv(held) @ (held @ before) if len(held) else before
    tau = random.uniform(-1.0, 1.0, n) * (9.81 * pinocchio.computeTotalMass(model) / 4)
    # Before a bouncing impact contacts move along z alone, since modyn bounces along the normal.
    sideways = numpy.array([k for contact, end in zip(contacts, ends) for k in range(end - contact.rows, end)
                            if k != end - contact.rows + 2])
    falling = before - numpy.linalg.pinv(jacobian[sideways]) @ (jacobian[sideways] @ before)

    found = robot.accelerations(q, v, tau)[0]
    impact, bounce = robot.impact(q, before, 0.0), robot.impact(q, falling, RESTITUTION)
    result = {"active": [contact.name for contact in contacts], "q": q, "q_angle": q[7:], "v": v, "tau": tau,
              "qdd": found[:n], "forces": robot.by_contact(found[n:]),
              "before": before, "after": impact[:n], "impulses": robot.by_contact(impact[n:]),
              "falling": falling, "bounced": bounce[:n], "bounce_impulses": robot.by_contact(bounce[n:])}
    for by, derivative in zip(("q", "v", "tau"), robot.derivatives(q, v, tau)):
        result[f"dqdd_d{by}"], result[f"dforces_d{by}"] = derivative[:n], robot.by_contact(derivative[n:])
    return result, robot.difference(q, v, tau)


def states(name, golden):
    """All states of a file, and the largest difference to the checks."""
    urdf, contacts, masks = ROBOTS[name]
    random = numpy.random.default_rng(17)
    made = [state(golden / f"{urdf}.urdf", [contact for contact in contacts if contact.name in mask], random)
            for mask in masks]
    return [found for found, _ in made], max(difference for _, difference in made)
