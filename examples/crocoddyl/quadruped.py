"""A quadruped trots: by Crocoddyl with Pinocchio, and with modyn's knots."""
import sys

import crocoddyl
import numpy as np
import pinocchio

import solo12
from compare import knot_difference, print_times, same_optimum, sqp, state_difference

KNOTS, DT, SPEED, STANCE, SWING = 40, 0.02, 0.2, 3, 10
PERIOD, CONTROLS, GAINS = 2 * (STANCE + SWING), 12, np.array([0.0, 50.0])
FEET = ["front_left", "front_right", "hind_left", "hind_right"]
SECOND = [False, True, True, False]  # which feet swing in the second half of a period

model = pinocchio.buildModelFromUrdf(sys.argv[1], pinocchio.JointModelFreeFlyer())
model.damping[:] = 0
data = model.createData()
frames = [model.getFrameId(foot + "_foot") for foot in FEET]
standing = np.r_[pinocchio.neutral(model), np.zeros(18)]
for leg in range(4):
    bend = 0.7 if leg < 2 else -0.7
    standing[8 + 3 * leg : 10 + 3 * leg] = bend, -2 * bend
pinocchio.framesForwardKinematics(model, data, standing[:19])
standing[2] = -data.oMf[frames[0]].translation[2]
pinocchio.framesForwardKinematics(model, data, standing[:19])
HOME = [data.oMf[frame].translation.copy() for frame in frames]


def stage(knot):
    """The state to follow, the feet on the ground, and the places of the feet."""
    reference, active, places = standing.copy(), [], []
    reference[0] += SPEED * DT * knot
    reference[19] = SPEED
    for foot in range(4):
        within = knot % PERIOD - (2 * STANCE + SWING if SECOND[foot] else STANCE)
        share = min(max(within / SWING, 0.0), 1.0)
        lift = 0.05 * np.sin(np.pi * share)
        places.append(HOME[foot] + [SPEED * PERIOD * DT * (knot // PERIOD + share), 0, lift])
        active.append(not 0 <= within < SWING)
    return reference, active, places


def costs(state, library, knot):
    """Crocoddyl's costs, of residuals by either library. The last state has only the cost of the state."""
    total = crocoddyl.CostModelSum(state, CONTROLS)
    reference, active, places = stage(knot)

    def add(name, residual, weight, activation=None):
        activation = activation or crocoddyl.ActivationModelQuad(residual.nr)
        total.addCost(name, crocoddyl.CostModelResidual(state, activation, residual), weight)

    weights = crocoddyl.ActivationModelWeightedQuad(np.array([100.0] * 6 + [1.0] * 12 + [2.0] * 6 + [0.02] * 12))
    add("state", library["state"](reference), 0.5 if knot == KNOTS else 1.0, weights)
    if knot == KNOTS:
        return total
    add("control", crocoddyl.ResidualModelControl(state, CONTROLS), 0.05)
    cone = crocoddyl.FrictionCone(np.eye(3), 0.3, 4, False)
    for foot in range(4):
        if active[foot]:
            bounds = crocoddyl.ActivationBounds(cone.lb, cone.ub)
            add("cone " + FEET[foot], library["cone"](foot, cone), 0.1, crocoddyl.ActivationModelQuadraticBarrier(bounds))
        else:
            add("place " + FEET[foot], library["place"](foot, places[foot]), 1e3)
    return total


multibody, state = crocoddyl.StateMultibody(model), solo12.State()


def by_pinocchio(knot):
    residuals = {
        "state": lambda reference: crocoddyl.ResidualModelState(multibody, reference, CONTROLS),
        "cone": lambda foot, cone: crocoddyl.ResidualModelContactFrictionCone(multibody, frames[foot], cone, CONTROLS),
        "place": lambda foot, place: crocoddyl.ResidualModelFrameTranslation(multibody, frames[foot], place, CONTROLS),
    }
    contacts = crocoddyl.ContactModelMultiple(multibody, CONTROLS)
    for foot, on in enumerate(stage(knot)[1]):
        if on:
            contacts.addContact(FEET[foot], crocoddyl.ContactModel3D(
                multibody, frames[foot], np.zeros(3), pinocchio.LOCAL_WORLD_ALIGNED, CONTROLS, GAINS))
    dynamics = crocoddyl.DifferentialActionModelContactFwdDynamics(
        multibody, crocoddyl.ActuationModelFloatingBase(multibody), contacts, costs(multibody, residuals, knot), 0.0, True)
    return crocoddyl.IntegratedActionModelEuler(dynamics, 0.0 if knot == KNOTS else DT)


def by_modyn(knot):
    residuals = {
        "state": lambda reference: solo12.ResidualModelState(state, reference),
        "cone": lambda foot, cone: solo12.ResidualModelContactFrictionCone(state, FEET[foot], cone),
        "place": lambda foot, place: solo12.ResidualModelFrameTranslation(state, FEET[foot] + "_foot", place),
    }
    active = [foot for foot, on in zip(FEET, stage(knot)[1]) if on]
    return solo12.ContactActionModel(state, costs(state, residuals, knot), 0.0 if knot == KNOTS else DT, active, GAINS)


theirs = by_pinocchio(0)
hold = theirs.quasiStatic(theirs.createData(), standing)
states, controls = [standing] * (KNOTS + 1), [hold] * KNOTS
problems = {name: crocoddyl.ShootingProblem(standing, [make(knot) for knot in range(KNOTS)], make(KNOTS))
            for name, make in {"Pinocchio": by_pinocchio, "modyn": by_modyn}.items()}
apart = [state_difference(state, multibody)]
for knot in 0, STANCE, 2 * STANCE + SWING:  # four feet on the ground, and two
    apart.append(knot_difference(by_modyn(knot), by_pinocchio(knot), states, controls))
print(f"\n{by_modyn(STANCE)}: states and knots differ by at most {np.max(apart):.0e}")
assert np.max(apart) < 1e-8
print_times(problems, *same_optimum("Quadruped, FDDP", problems, states, controls))
same_optimum("Quadruped, SQP of mim_solvers", problems, states, controls, sqp)
