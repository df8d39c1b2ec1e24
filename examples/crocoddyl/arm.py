"""The arm's hand moves to a pose: by Crocoddyl with Pinocchio, with modyn's knots, and with modyn's knots and a cost in C++."""
import sys

import crocoddyl
import numpy as np
import pinocchio

import arm7
from compare import crocoddyls, knot_difference, print_times, same_optimum, sqp, state_difference

KNOTS, DT = 30, 0.02
FRAME = "grasp_point"
RUNNING = dict(place=10.0, turn=1.0, posture=1e-2, velocity=1e-2, control=1e-4, limit=1e2)
LAST = dict(place=1e2, turn=1e1, posture=1e-2, velocity=1.0, control=0.0, limit=1e2)

model = pinocchio.buildModelFromUrdf(sys.argv[1])
model.damping[:] = 0
data = model.createData()
start = np.array([0, -0.785, 0, -2.356, 0, 1.571, 0.785] + [0] * 7)
hold = pinocchio.computeGeneralizedGravity(model, data, start[:7]).copy()
frame = model.getFrameId(FRAME)
pinocchio.framesForwardKinematics(model, data, np.array([0.5, -0.2, -0.2, -1.9, 0.3, 2.0, 0.5]))
goal = data.oMf[frame].copy()


def costs(state, place, turn, residual_of_state, weights):
    """Crocoddyl's costs, of residuals by either library."""
    total = crocoddyl.CostModelSum(state)

    def add(name, residual, weight, activation=None):
        activation = activation or crocoddyl.ActivationModelQuad(residual.nr)
        total.addCost(name, crocoddyl.CostModelResidual(state, activation, residual), weight)

    by_entry = np.array([weights["posture"]] * 7 + [weights["velocity"]] * 7)
    far = np.full(7, 1e10)
    bounds = crocoddyl.ActivationBounds(np.r_[model.lowerPositionLimit, -far], np.r_[model.upperPositionLimit, far])
    add("place", place, weights["place"])
    add("turn", turn, weights["turn"])
    add("state", residual_of_state(state, start), 1.0, crocoddyl.ActivationModelWeightedQuad(by_entry))
    add("limits", residual_of_state(state, np.zeros(14)), weights["limit"], crocoddyl.ActivationModelQuadraticBarrier(bounds))
    if weights["control"]:
        add("control", crocoddyl.ResidualModelControl(state, hold), weights["control"])
    return total


multibody, state = crocoddyl.StateMultibody(model), arm7.State()


def integrated(costs, dt):
    actuation = crocoddyl.ActuationModelFull(multibody)
    return crocoddyl.IntegratedActionModelEuler(crocoddyl.DifferentialActionModelFreeFwdDynamics(multibody, actuation, costs), dt)


def by_pinocchio(dt, weights):
    place = crocoddyl.ResidualModelFrameTranslation(multibody, frame, goal.translation)
    turn = crocoddyl.ResidualModelFrameRotation(multibody, frame, goal.rotation)
    return integrated(costs(multibody, place, turn, crocoddyl.ResidualModelState, weights), dt)


def by_modyn(dt, weights):
    place = arm7.ResidualModelFrameTranslation(state, FRAME, goal.translation)
    turn = arm7.ResidualModelFrameRotation(state, FRAME, goal.rotation)
    return arm7.ActionModel(state, costs(state, place, turn, arm7.ResidualModelState, weights), dt)


def in_cpp(dt, weights):
    task = dict(place=goal.translation, rotation=goal.rotation, posture=start[:7], torques=hold,
                lower=model.lowerPositionLimit, upper=model.upperPositionLimit)
    return arm7.ReachActionModel(state, task, weights, dt)


def of_placement(state, residual):
    total = crocoddyl.CostModelSum(state)
    total.addCost("placement", crocoddyl.CostModelResidual(state, residual), 1.0)
    return total


states, controls = [start] * (KNOTS + 1), [hold] * KNOTS
theirs = by_pinocchio(DT, RUNNING)
placements = (arm7.ActionModel(state, of_placement(state, arm7.ResidualModelFramePlacement(state, FRAME, goal)), DT),
              integrated(of_placement(multibody, crocoddyl.ResidualModelFramePlacement(multibody, frame, goal)), DT))
apart = [state_difference(state, multibody), knot_difference(by_modyn(DT, RUNNING), theirs, states, controls),
         knot_difference(in_cpp(DT, RUNNING), theirs, states, controls), knot_difference(*placements, states, controls)]
print(f"{by_modyn(DT, RUNNING)}: states and knots differ by at most {np.max(apart):.0e}")
assert np.max(apart) < 1e-9

problems = {name: crocoddyl.ShootingProblem(start, [make(DT, RUNNING)] * KNOTS, make(0.0, LAST)) for name, make in
            {"Pinocchio": by_pinocchio, "modyn": by_modyn, "modyn, the cost in C++": in_cpp}.items()}
optimum = same_optimum("Arm, FDDP", problems, states, controls)
print_times(problems, *optimum)
same_optimum("Arm, SQP of mim_solvers", problems, states, controls, sqp)
for share in 1.0, 0.3:
    for problem in problems.values():
        for action in problem.runningModels:
            action.u_lb, action.u_ub = (sign * share * model.effortLimit for sign in (-1, 1))
    same_optimum(f"Arm, Box-FDDP, torques up to {share:.0%} of the motors'", problems, states, controls,
                 crocoddyls(crocoddyl.SolverBoxFDDP))
