"""modyn's functions in CasADi, beside CasADi's own derivatives of the textbook's expressions."""

import contextlib
import ctypes
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

import casadi as ca
import numpy as np

import acados_problem
import ocp
from textbook import Robot

MODYN = os.environ["MODYN"]
FOLDER = os.path.dirname(os.path.abspath(__file__))
WORK = tempfile.mkdtemp()
WARNINGS = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O1", "-fPIC", "-shared"]


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
    return done.stdout


def timed(call):
    start = time.perf_counter()
    result = call()
    return time.perf_counter() - start, result


def compiled(path, functions, *options, name=None, flags=()):
    """Returns the path of the library of a robot's functions."""
    name = name or os.path.basename(path).removesuffix(".urdf")
    source, library = f"{WORK}/{name}.c", f"{WORK}/{name}.so"
    run(MODYN, "generate", path, "--target", "casadi", "--functions", f"[{functions}]", "-o", source, *options)
    run(os.environ.get("CC", "cc"), *WARNINGS, *flags, source, "-o", library, "-lm")
    return library


def symbols(robot, *names):
    sizes = {"q": robot.nq}
    return [ca.SX.sym(name, sizes.get(name, robot.nv)) for name in names]


class Comparison(unittest.TestCase):
    def same(self, found, expected, place, tolerance=1e-9):
        found, expected = ca.DM(found).full(), ca.DM(expected).full()
        self.assertEqual(found.shape, expected.shape, place)
        scale = max(1, abs(expected).max(initial=0))
        self.assertTrue(np.isfinite(found).all(), place)
        self.assertLessEqual(abs(found - expected).max(initial=0), tolerance * scale, place)

    def all_the_same(self, ours, theirs, x, patterns=True, second=True, tolerance=1e-9):
        """Compares values, first and second derivatives, and the patterns of Jacobians."""
        generator = np.random.default_rng(3)
        self.assertEqual((ours.name_in(), ours.name_out()), (theirs.name_in(), theirs.name_out()))
        y = ours(*x) if ours.n_out() > 1 else (ours(*x),)
        for k, expected in enumerate(theirs.call(x)):
            self.same(y[k], expected, f"{ours.name()} {k}", tolerance)
        outs = [ca.DM(*ours.size_out(k)) for k in range(ours.n_out())]
        seeds = [ca.DM(generator.uniform(-1, 1, theirs.size_out(k))) for k in range(ours.n_out())]
        seeds = [ca.project(seed, ours.sparsity_out(k)) for k, seed in enumerate(seeds)]
        changes = [generator.uniform(-1, 1, ours.size_in(k)) for k in range(ours.n_in())]
        cases = [
            (ours.jacobian(), theirs.jacobian(), [*x, *outs]),
            (ours.forward(1), theirs.forward(1), [*x, *outs, *changes]),
            (ours.reverse(1), theirs.reverse(1), [*x, *outs, *seeds]),
            (ours.reverse(1).jacobian(), theirs.reverse(1).jacobian(), [*x, *outs, *seeds, *([0] * len(x))]),
        ]
        for own, other, given in cases[: 4 if second else 3]:
            self.assertIn("External", own.class_name(), own.name())
            for k, (found, expected) in enumerate(zip(own.call(given), other.call(given))):
                self.same(found, expected, f"{own.name()} {own.name_out(k)}", tolerance)
                if patterns and "jac_" in own.name():
                    # A nonzero of ours is one of theirs: structural zeros are never fewer.
                    outside = own.sparsity_out(k).nnz() > other.sparsity_out(k).nnz()
                    self.assertFalse(outside, f"{own.name()} {own.name_out(k)}")

    def test_a_fixed_arm(self):
        path = f"{ocp.ROBOTS}/arm7.urdf"
        library = compiled(path, "forward_dynamics, inverse_dynamics, mass_matrix, link_pose, step_semi_implicit")
        robot = Robot(path)
        q, qd, tau, qdd = symbols(robot, "q", "qd", "tau", "qdd")
        x = robot.random(np.random.default_rng(1))
        load = lambda name: ca.external(f"arm7_{name}", library)
        forward = ca.Function("f", [q, qd, tau], [robot.forward_dynamics(q, qd, tau)], ["q", "qd", "tau"], ["qdd"])
        self.all_the_same(load("forward_dynamics"), forward, x)
        tau_of = robot.inverse_dynamics(q, qd, qdd)
        self.all_the_same(
            load("inverse_dynamics"), ca.Function("f", [q, qd, qdd], [tau_of], ["q", "qd", "qdd"], ["tau"]), x)
        mass = ca.Function("f", [q], [ca.jacobian(tau_of, qdd)], ["q"], ["mass_matrix"])
        self.all_the_same(load("mass_matrix"), mass, x[:1], patterns=False)
        pose = ca.Function("f", [q], list(robot.link_pose(q, "left_finger")), ["q"], ["rotation", "translation"])
        self.all_the_same(load("link_pose_left_finger"), pose, x[:1], patterns=False)
        dt = ca.SX.sym("dt")
        after = qd + dt * robot.forward_dynamics(q, qd, tau)
        step = ca.Function(
            "f", [q, qd, tau, dt], [q + dt * after, after], ["q", "qd", "tau", "dt"], ["q_next", "qd_next"])
        self.all_the_same(load("step_semi_implicit"), step, [*x, 0.02])

    def test_quaternions_and_a_floating_base(self):
        path = f"{FOLDER}/joints.urdf"
        for floating in (False, True):
            name = "floating" if floating else "joints"
            library = compiled(
                path, "forward_dynamics, inverse_dynamics, velocity_to_qdot",
                *(["--base", "floating"] if floating else []), "--type-name", name.capitalize(), name=name)
            robot = Robot(path, floating)
            q, qd, tau, qdd = symbols(robot, "q", "qd", "tau", "qdd")
            x = robot.random(np.random.default_rng(2))
            functions = [
                ("forward_dynamics", [q, qd, tau], robot.forward_dynamics(q, qd, tau), "qdd"),
                ("inverse_dynamics", [q, qd, qdd], robot.inverse_dynamics(q, qd, qdd), "tau"),
                ("velocity_to_qdot", [q, qd], robot.velocity_to_qdot(q, qd), "qdot"),
            ]
            for function, given, result, out in functions:
                names = [one[0].name().rsplit("_", 1)[0] for one in given]
                theirs = ca.Function("f", given, [result], names, [out])
                # Ours have zeros of their own: the derivative along a quaternion is zero at length 1 only.
                self.all_the_same(ca.external(f"{name}_{function}", library), theirs, x[: len(given)])

    def test_the_implicit_midpoint_rule(self):
        """modyn's fixed number of iterations leaves an error of order dt^7."""
        for robot_name, second in (("cart_pole", True), ("joints", False)):
            path = f"{FOLDER}/{robot_name}.urdf"
            library = compiled(path, "step_implicit_midpoint", name=f"midpoint_{robot_name}")
            robot = Robot(path)
            x = [*robot.random(np.random.default_rng(4)), 0.005]
            ours = ca.external(f"{robot_name}_step_implicit_midpoint", library)
            self.all_the_same(
                ours, robot.implicit_midpoint(), x, patterns=False, second=second, tolerance=1e-8)

    def test_null_arguments_are_zeros(self):
        path = f"{ocp.ROBOTS}/arm7.urdf"
        robot, library = Robot(path), compiled(path, "forward_dynamics", name="null")
        function = ctypes.CDLL(library).jac_arm7_forward_dynamics
        pointers = ctypes.POINTER(ctypes.c_double)
        n, work = robot.nv, (ctypes.c_double * 1000)()
        load = ca.external("arm7_forward_dynamics", library)
        results = [(ctypes.c_double * n * n)() for _ in range(3)]
        for wanted in range(8):
            for result in results:
                ctypes.memset(result, 0, ctypes.sizeof(result))
            given = (pointers * 4)()
            res = (pointers * 3)()
            for k in range(3):
                if wanted >> k & 1:
                    res[k] = ctypes.cast(results[k], pointers)
            self.assertEqual(function(given, res, None, work, 0), 0)
            expected = load.jacobian()(*[np.zeros(n)] * 3, 0)
            for k in range(3):
                found = np.array(results[k]).ravel()[: expected[k].nnz()]
                nonzeros = np.array(expected[k].nonzeros())
                self.assertTrue(np.array_equal(found, nonzeros if wanted >> k & 1 else 0 * nonzeros))

    @unittest.skipUnless("ACADOS_SOURCE_DIR" in os.environ, "the package of acados is for Linux on x86-64")
    def test_acados(self):
        """With exact Hessians, acados takes the same steps to the same optimum as with CasADi's expressions."""
        path, start = f"{ocp.ROBOTS}/double_pendulum.urdf", [0.9, -0.6, 0.4, 0.3]
        robot, given = Robot(path), symbols(Robot(path), "q", "qd", "tau")
        q, qd, _ = given
        dt, qdd = ca.SX.sym("dt"), robot.forward_dynamics(*given)
        library = f"{WORK}/libpendulum.so"
        # The solver's library finds this one by its path.
        compiled(path, "forward_dynamics, step_semi_implicit", name="libpendulum", flags=[f"-Wl,-soname,{library}"])
        after = qd + dt * qdd
        cases = [
            ("forward_dynamics", ca.Function("f", given, [qdd])),
            ("step_semi_implicit", ca.Function("f", [*given, dt], [q + dt * after, after])),
        ]
        for name, theirs in cases:
            ours = ca.external(f"double_pendulum_{name}", library)
            discrete = name.startswith("step")
            found = acados_problem.solve(f"modyn_{name}", WORK, ours, start, discrete, library)
            expected = acados_problem.solve(f"casadi_{name}", WORK, theirs, start, discrete)
            for own, other in zip(found[:2], expected[:2]):
                self.same(own, other, name, 1e-6)
            self.assertEqual(found[2], expected[2], name)
            self.assertGreater(found[2], 2, "the problem is not linear")

    def test_acados_signatures(self):
        """acados prints expressions with CasADi, over int, and links the library of external functions."""
        path = f"{ocp.ROBOTS}/arm7.urdf"
        robot, library = Robot(path), compiled(path, "forward_dynamics", name="acados")
        n = robot.nv
        x, u, p = ca.MX.sym("x", 2 * n), ca.MX.sym("u", n), ca.MX.sym("p", 0)
        sx, su, lam = ca.MX.sym("Sx", 2 * n, 2 * n), ca.MX.sym("Su", 2 * n, n), ca.MX.sym("lam", 2 * n)

        def functions(dynamics):
            """The functions of an explicit model, as acados makes them of `f_expl_expr`."""
            f = ca.vertcat(x[n:], dynamics(x[:n], x[n:], u))
            vde_x = ca.jtimes(f, x, sx)
            vde_u = ca.jacobian(f, u) + ca.jtimes(f, x, su)
            adjoint = ca.jtimes(f, ca.vertcat(x, u), lam, True)
            s = ca.vertcat(ca.horzcat(sx, su), ca.horzcat(ca.DM(n, 2 * n), ca.DM.eye(n)))
            hessian = ca.mtimes([s.T, ca.jacobian(adjoint, ca.vertcat(x, u)), s])
            return [
                ca.Function("expl_ode_fun", [x, u, p], [f]),
                ca.Function("expl_vde_forw", [x, sx, su, u, p], [f, vde_x, vde_u]),
                ca.Function("expl_vde_adj", [x, lam, u, p], [adjoint]),
                ca.Function("expl_ode_hess", [x, sx, su, lam, u, p], [adjoint, hessian]),
            ]

        q, qd, tau = symbols(robot, "q", "qd", "tau")
        theirs = functions(ca.Function("f", [q, qd, tau], [robot.forward_dynamics(q, qd, tau)]))
        ours = functions(ca.external("arm7_forward_dynamics", library))
        generator = ca.CodeGenerator("model.c", {"casadi_int": "int", "casadi_real": "double"})
        for function in ours:
            generator.add(function)
        generator.generate(WORK + "/")
        run("cc", "-O1", "-fPIC", "-shared", f"{WORK}/model.c", library, f"-Wl,-rpath,{WORK}", "-o", f"{WORK}/model.so", "-lm")
        model, numbers = ctypes.CDLL(f"{WORK}/model.so"), np.random.default_rng(5)
        pointers = ctypes.POINTER(ctypes.c_double)
        for own, other in zip(ours, theirs):
            name = own.name()
            sizes = [ctypes.c_int() for _ in range(4)]
            self.assertEqual(getattr(model, f"{name}_work")(*map(ctypes.byref, sizes)), 0)
            sz_arg, sz_res, sz_iw, sz_w = (size.value for size in sizes)
            given = [numbers.uniform(-1, 1, own.size_in(k)) for k in range(own.n_in())]
            columns = [np.asfortranarray(value).ravel("F").copy() for value in given]
            results = [np.zeros(own.nnz_out(k)) for k in range(own.n_out())]
            arg, res = (pointers * sz_arg)(), (pointers * sz_res)()
            for k, value in enumerate(columns):
                arg[k] = value.ctypes.data_as(pointers)
            for k, value in enumerate(results):
                res[k] = value.ctypes.data_as(pointers)
            call = getattr(model, name)
            self.assertEqual(call(arg, res, (ctypes.c_int * (sz_iw + 1))(), (ctypes.c_double * (sz_w + 1))(), 0), 0)
            for k, expected in enumerate(other.call(given)):
                self.same(ca.DM(own.sparsity_out(k), results[k]), expected, f"{name} {k}")

    def test_acados_calls_over_int(self):
        """`-Dcasadi_int=int`: sizes and patterns as acados reads them."""
        path = f"{ocp.ROBOTS}/arm7.urdf"
        library = ctypes.CDLL(compiled(path, "forward_dynamics", name="int", flags=["-Dcasadi_int=int"]))
        name = "jac_arm7_forward_dynamics"
        for end in ("n_in", "n_out"):
            getattr(library, f"{name}_{end}").restype = ctypes.c_int
        self.assertEqual((getattr(library, f"{name}_n_in")(), getattr(library, f"{name}_n_out")()), (4, 3))
        pattern = getattr(library, f"{name}_sparsity_out")
        pattern.restype = ctypes.POINTER(ctypes.c_int)
        dense, sparse = pattern(2), pattern(0)
        self.assertEqual(dense[:3], [7, 7, 1])
        # The first joint's angle has no effect on the accelerations.
        self.assertEqual(sparse[:5], [7, 7, 0, 0, 7])
        self.assertEqual(sparse[9], 42)

    def test_names_do_not_collide(self):
        """Two robots in one program: all names that a library exports have the robot's prefix."""
        library = compiled(f"{ocp.ROBOTS}/double_pendulum.urdf", "forward_dynamics", name="exported")
        listed = subprocess.run(["nm", "-D", "--defined-only", library], capture_output=True, text=True).stdout
        for line in listed.splitlines():
            name = line.split()[-1]
            self.assertRegex(name, r"^(jac_|fwd1_|adj1_|jac_adj1_)?double_pendulum_forward_dynamics")

    def test_optimal_control(self):
        for problem in (ocp.SWING_UP, ocp.REACHING):
            library = compiled(problem.path, "forward_dynamics", name=f"ocp_{problem.robot}")
            ours = ca.external(f"{problem.robot}_forward_dynamics", library, {"enable_forward": False})
            solver, bounds = problem.solver(ours)
            called = [one.name() for one in solver.get_function("nlp_hess_l").find_functions()]
            self.assertIn(f"jac_adj1_{problem.robot}_forward_dynamics", called)
            ours_time, found = timed(lambda: solver(**bounds))
            self.assertTrue(solver.stats()["success"], problem.robot)
            # IPOPT with CasADi's expressions takes the same iterations to the same solution.
            robot = Robot(problem.path)
            q, qd, tau = symbols(robot, "q", "qd", "tau")
            expressions = ca.Function("f", [q, qd, tau], [robot.forward_dynamics(q, qd, tau)])
            theirs, _ = problem.solver(expressions)
            theirs_time, expected = timed(lambda: theirs(**bounds))
            self.assertTrue(theirs.stats()["success"], problem.robot)
            iterations = [one.stats()["iter_count"] for one in (solver, theirs)]
            self.assertEqual(*iterations, problem.robot)
            self.same(found["x"], np.array(expected["x"]), problem.robot, 1e-6)
            self.same(found["f"], np.array(expected["f"]), problem.robot, 1e-8)
            # For information: times are no test.
            print(f"{problem.robot}: {iterations[0]} iterations, {ours_time:.3f} s with modyn's functions, "
                  f"{theirs_time:.3f} s with CasADi's expressions", file=sys.stderr)
            # The conditions of an optimum hold for CasADi's derivatives.
            defects, jacobian = theirs.get_function("nlp_jac_g")(found["x"], [])
            _, gradient = theirs.get_function("nlp_grad_f")(found["x"], [])
            self.same(defects, np.zeros(defects.shape), problem.robot, 1e-6)
            stationary = ca.vec(gradient) + jacobian.T @ found["lam_g"] + found["lam_x"]
            self.same(stationary, np.zeros(stationary.shape), problem.robot, 1e-5)


    def programs(self, language):
        """Makes a folder with the robots; returns it, and the programs of docs/casadi.md in a language."""
        with open(f"{FOLDER}/../../docs/casadi.md") as page:
            found = re.findall(rf"```{language}\n(.*?)```", page.read(), re.DOTALL)
        place = tempfile.mkdtemp(dir=WORK)
        os.symlink(os.path.realpath(ocp.ROBOTS), f"{place}/robots")
        return place, found

    def compiled(self, page, commands):
        """Runs the commands of the page that write and compile a robot: the command is not on the path, and optimisation takes long."""
        commands = re.sub("-O[12]", "-O0", commands)
        run("bash", "-c", f"set -e; cd {page}; modyn() {{ '{MODYN}' \"$@\"; }}; {commands}")

    @contextlib.contextmanager
    def within(self, folder):
        """Programs load their library from `./`."""
        before = os.getcwd()
        os.chdir(folder)
        try:
            yield
        finally:
            os.chdir(before)

    def test_the_programs_of_the_page(self):
        place, programs = self.programs("python")
        _, commands = self.programs("console")
        self.compiled(place, commands[0])
        session = {}
        with self.within(place):
            exec(programs[0], session)
        self.assertEqual(session["jacobian"].shape, (7, 7))
        self.assertEqual([session[name].shape for name in ("rotation", "position")], [(3, 3), (3, 1)])
        if "ACADOS_SOURCE_DIR" in os.environ:
            exec(programs[1], session)
            self.assertEqual(session["ocp"].model.f_expl_expr.shape, (14, 1))

    def test_the_legged_robot_of_the_page(self):
        place, programs = self.programs("python")
        _, commands = self.programs("console")
        self.compiled(place, commands[2])
        session = {}
        with self.within(place):
            exec(programs[2], session)
        # The forces of the last step carry the weight, and all of them the change of the momentum.
        pushes = session["solution"].value(session["F"])[2::3].sum(axis=0)
        self.assertTrue(np.all(pushes > 20) and pushes[0] > pushes[-1] + 5, pushes)

    @unittest.skipUnless(shutil.which("octave-cli"), "Octave is not installed")
    def test_the_programs_for_matlab(self):
        place, programs = self.programs("matlab")
        run("bash", "-c", f"cd {place} && '{MODYN}' generate robots/arm7.urdf --target matlab -o +arm7")
        checks = "assert(isequal(size(M), [7 7 1000])); assert(isequal(size(hand.rotation), [3 3]));"
        with open(f"{place}/page.m", "w") as file:
            file.write("\n".join([*programs, checks]))
        shown = run("octave-cli", "--norc", "--quiet", "--eval", f"cd {place}; page")
        self.assertIn("FORWARD_DYNAMICS", shown)


if __name__ == "__main__":
    unittest.main()
