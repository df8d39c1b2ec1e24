"""Displacements of coordinates, and their derivatives, by Pinocchio."""

import numpy
import pinocchio

#: The states, and the angles of their rotations.
ANGLES = (0.0, 1e-6, 0.05, 0.7, 2.2, 3.0)


def model():
    """A floating, a spherical, a revolute and a prismatic joint."""
    joints = (pinocchio.JointModelFreeFlyer(), pinocchio.JointModelSpherical(), pinocchio.JointModelRX(),
              pinocchio.JointModelPX())
    chain = pinocchio.Model()
    for number, joint in enumerate(joints):
        chain.addJoint(number, joint, pinocchio.SE3.Identity(), f"joint{number}")
    return chain


def displacements():
    """The file: coordinates, a displacement, other coordinates, and the derivatives at them; matrices by rows."""
    chain, random, states = model(), numpy.random.default_rng(17), []
    for angle in ANGLES:
        def displacement():
            v = random.uniform(-1.0, 1.0, chain.nv)
            for at in (3, 6):
                v[at:at + 3] *= angle / numpy.linalg.norm(v[at:at + 3])
            return v

        q = random.uniform(-1.0, 1.0, chain.nq)
        for at in (3, 7):
            q[at:at + 4] /= numpy.linalg.norm(q[at:at + 4])
        v, to = displacement(), pinocchio.integrate(chain, q, displacement())
        integrate = pinocchio.dIntegrate(chain, q, v)
        difference = pinocchio.dDifference(chain, q, to)
        states.append({"q": q.tolist(), "v": v.tolist(), "to": to.tolist(),
                       "integrate_dq": integrate[0].tolist(), "integrate_dv": integrate[1].tolist(),
                       "difference_dfrom": difference[0].tolist(), "difference_dto": difference[1].tolist()})
    return {"states": states, "generator": f"pinocchio {pinocchio.__version__}"}
