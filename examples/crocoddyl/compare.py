"""Action models side by side: their knots in random states, their optima, and the times of a solver's parts."""
import time

import crocoddyl  # before mim_solvers, which finds its libraries then
import mim_solvers
import numpy as np


def relative(ours, theirs):
    return np.linalg.norm(np.subtract(ours, theirs)) / (1 + np.linalg.norm(theirs))


def knot_difference(ours, theirs, states, controls):
    """The largest relative difference of two action models' results, near the states of a motion."""
    random = np.random.default_rng(1)
    datas = [ours.createData(), theirs.createData()]
    largest = []

    def compare(*names):
        largest.extend(relative(*(getattr(data, name) for data in datas)) for name in names)

    for x, u in zip(states, controls):
        x = theirs.state.integrate(x, 0.3 * random.standard_normal(theirs.state.ndx))
        u = u + random.standard_normal(theirs.nu)
        for model, data in zip((ours, theirs), datas):
            model.calc(data, x, u)
            model.calcDiff(data, x, u)
        compare("xnext", "cost", "Fx", "Fu", "Lx", "Lu", "Lxx", "Lxu", "Luu")
        for model, data in zip((ours, theirs), datas):
            model.calc(data, x)
            model.calcDiff(data, x)
        compare("cost", "Lx", "Lxx")
    return np.max(largest)  # NaN if any is


def state_difference(ours, theirs):
    """The largest difference of two states' operators, at random states."""
    random = np.random.default_rng(2)
    largest = [relative(ours.zero(), theirs.zero())]
    for _ in range(20):
        # A logarithm is not smooth at half a revolution.
        x = theirs.integrate(theirs.zero(), random.uniform(-1, 1, theirs.ndx))
        dx = random.uniform(-1, 1, theirs.ndx)
        y = theirs.integrate(x, dx)
        largest.append(relative(ours.integrate(x, dx), y))
        largest.append(relative(ours.diff(x, y), theirs.diff(x, y)))
        for name, to in (("Jdiff", y), ("Jintegrate", dx)):
            largest.extend(relative(*pair) for pair in zip(getattr(ours, name)(x, to), getattr(theirs, name)(x, to)))
        for which in (crocoddyl.Jcomponent.first, crocoddyl.Jcomponent.second):
            matrices = [np.eye(theirs.ndx), np.eye(theirs.ndx)]
            for state, matrix in zip((ours, theirs), matrices):
                state.JintegrateTransport(x, dx, matrix, which)
            largest.append(relative(*matrices))
    return np.max(largest)


def crocoddyls(solver):
    """Solves problems by one of Crocoddyl's solvers."""

    def solve(problem, states, controls):
        found = solver(problem)
        found.th_stop = 1e-14
        found.solve(states, controls, 200, False, 1e-9)
        return found

    return solve


def sqp(problem, states, controls):
    """Solves problems by mim_solvers."""
    found = mim_solvers.SolverSQP(problem)
    found.termination_tolerance = 1e-8
    found.solve(states, controls, 200, False)
    return found


def same_optimum(title, problems, states, controls, solve=crocoddyls(crocoddyl.SolverFDDP)):
    """Prints the optima of problems by name. Fails unless they are the first problem's within 1e-8."""
    print(f"\n| {title} | cost | iterations | largest difference of states |\n|---|---|---|---|")
    first = None
    for name, problem in problems.items():
        found = solve(problem, states, controls)
        first = first or found
        apart = max(np.abs(x - y).max() for x, y in zip(found.xs, first.xs))
        print(f"| {name} | {found.cost:.12f} | {found.iter} | {apart:.0e} |")
        assert abs(found.cost - first.cost) < 1e-8 and apart < 1e-5 and found.iter < 200
    return list(first.xs), list(first.us)


def print_times(problems, states, controls, rounds=101):
    """Prints the median processor times of the parts of an iteration, with the problems in turn, on one thread."""
    rows = {"`calc`": [], "`calcDiff`": [], "`solve` of one iteration": []}
    solvers = {}
    for name, problem in problems.items():
        problem.nthreads = 1
        solvers[name] = crocoddyl.SolverFDDP(problem)
        solvers[name].th_stop = 1e-300
    calls = {name: [lambda p=problem: p.calc(states, controls), lambda p=problem: p.calcDiff(states, controls),
                    lambda s=solvers[name]: s.solve(states, controls, 1, False, 1e-9)] for name, problem in problems.items()}
    times = {(name, part): [] for name in problems for part in range(3)}
    for _ in range(rounds):
        for name in problems:
            for part, call in enumerate(calls[name]):
                before = time.thread_time()
                call()
                times[name, part].append(1e6 * (time.thread_time() - before))
    print(f"\n| us, {len(controls)} knots | " + " | ".join(problems) + " |\n|---|" + "---|" * len(problems))
    for part, row in enumerate(rows):
        medians = [np.median(times[name, part]) for name in problems]
        print(f"| {row} | {medians[0]:.0f} | " + " | ".join(f"{m:.0f} (1/{medians[0] / m:.1f})" for m in medians[1:]) + " |")
