"""Two optimal control problems, by direct collocation with trapezoids, for any function of forward dynamics."""

import os

import casadi as ca
import numpy as np

FOLDER = os.path.dirname(os.path.abspath(__file__))
ROBOTS = f"{FOLDER}/../../robots"


class Problem:
    """A motion from rest to rest of least effort: start and goal, knots, duration in s, largest forces."""

    def __init__(self, path, start, goal, knots, duration, limits):
        self.path, self.robot = path, os.path.basename(path).removesuffix(".urdf")
        self.start, self.goal, self.limits = (np.array(x, float) for x in (start, goal, limits))
        self.knots, self.duration = knots, duration

    def solver(self, dynamics, iterations=1000):
        """Returns the solver with IPOPT on exact derivatives, and its arguments."""
        n, knots = len(self.start), self.knots
        step = self.duration / (knots - 1)
        q, qd, tau = (ca.MX.sym(name, n, knots) for name in ("q", "qd", "tau"))
        qdd = dynamics.map(knots)(q, qd, tau)

        def defects(x, rate):
            return ca.vec(x[:, 1:] - x[:, :-1] - step / 2 * (rate[:, 1:] + rate[:, :-1]))

        effort = step * (1e-2 * ca.sumsqr(tau) + 1e-3 * ca.sumsqr(qd))
        program = {"x": ca.veccat(q, qd, tau), "f": effort, "g": ca.vertcat(defects(q, qd), defects(qd, qdd))}
        options = {"ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": False, "ipopt.tol": 1e-8,
                   "ipopt.max_iter": iterations}
        upper = np.full((3, knots, n), np.inf)
        upper[2] = self.limits
        lower = -upper
        for knot, position in ((0, self.start), (-1, self.goal)):
            lower[0, knot] = upper[0, knot] = position
            lower[1, knot] = upper[1, knot] = 0
        guess = np.zeros((3, knots, n))
        guess[0] = np.linspace(self.start, self.goal, knots)
        bounds = {"lbx": lower.ravel(), "ubx": upper.ravel(), "lbg": 0, "ubg": 0, "x0": guess.ravel()}
        return ca.nlpsol("solver", "ipopt", program, options), bounds


# The force on the cart alone swings up the pole.
SWING_UP = Problem(f"{FOLDER}/cart_pole.urdf", [0, 0], [0, np.pi], 101, 2.0, [20, 0])
REACHING = Problem(
    f"{ROBOTS}/arm7.urdf",
    [0.1, -0.5, 0.2, -2.0, 0.1, 1.5, 0.3],
    [1.2, 0.4, -0.5, -1.2, 0.6, 2.0, -0.4],
    41,
    1.0,
    [87, 87, 87, 87, 12, 12, 12],
)
