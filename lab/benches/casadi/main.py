"""Solves two optimal control problems by IPOPT with modyn's functions and with CasADi's, evaluated and compiled, as a table."""

import os
import subprocess
import tempfile
import time

import casadi as ca

import ocp
from textbook import Robot

TITLES = ["problem", "functions", "size of the Hessian's code", "iterations", "cost", "preparation, s", "solution, s",
          "of which functions, s"]


def timed(call):
    start = time.perf_counter()
    result = call()
    return time.perf_counter() - start, result


def compile_c(source, library, level="-O2"):
    command = [os.environ.get("CC", "cc"), level, "-march=native", "-fPIC", "-shared", source, "-o", library, "-lm"]
    subprocess.run(command, check=True)


def of_modyn(problem, folder):
    source, library = (f"{folder}/{problem.robot}.{end}" for end in ("c", "so"))
    command = [os.environ["MODYN"], "generate", problem.path, "--target", "casadi", "--functions", "[forward_dynamics]"]
    subprocess.run([*command, "-o", source], check=True, capture_output=True)
    compile_c(source, library)
    lines = open(source).read().split("static void jac_adj1_")
    statements = sum(part.count("const double x") for part in lines[1:])
    function = ca.external(f"{problem.robot}_forward_dynamics", library, {"enable_forward": False})
    return function, f"{statements} statements"


def of_casadi(problem, _folder):
    robot = Robot(problem.path)
    q, qd, tau = (ca.SX.sym(name, robot.nv) for name in ("q", "qd", "tau"))
    given = [q, qd, tau]
    function = ca.Function("forward_dynamics", given, [robot.forward_dynamics(*given)], ["q", "qd", "tau"], ["qdd"])
    return function, f"{function.reverse(1).jacobian().n_instructions()} instructions"


def of_casadi_compiled(problem, folder):
    """Returns the C that CasADi generates from the expressions and their derivatives, compiled."""
    function, size = of_casadi(problem, folder)
    source = f"{problem.robot}_expressions.c"
    generator = ca.CodeGenerator(source)
    reverse = function.reverse(1)
    for part in (function, function.jacobian(), reverse, reverse.jacobian()):
        generator.add(part)
    generator.generate(f"{folder}/")
    library = f"{folder}/{problem.robot}_expressions.so"
    # gcc takes three minutes for the arm with -O1, and did not end within nine with -O2.
    compile_c(f"{folder}/{source}", library, "-O1")
    return ca.external(function.name(), library, {"enable_forward": False}), size


def main():
    print("| " + " | ".join(TITLES) + " |\n|" + "---|" * len(TITLES))
    problems = [("swing-up of a cart-pole", ocp.SWING_UP, 25), ("`arm7` reaches a posture", ocp.REACHING, 4)]
    with tempfile.TemporaryDirectory() as folder:
        for title, problem, rounds in problems:
            contenders = []
            makers = {"modyn": of_modyn, "CasADi's expressions": of_casadi, "CasADi's C, compiled": of_casadi_compiled}
            for name, make in makers.items():
                function, size = make(problem, folder)
                preparation, (solver, bounds) = timed(lambda: problem.solver(function))
                contenders.append({"name": name, "size": size, "preparation": preparation, "solve": (solver, bounds), "best": None})
            # In turns, so that a busy machine disturbs all alike.
            for _ in range(rounds):
                for one in contenders:
                    solver, bounds = one["solve"]
                    solution, found = timed(lambda: solver(**bounds))
                    stats = solver.stats()
                    assert stats["success"], stats["return_status"]
                    inside = sum(value for key, value in stats.items() if key.startswith("t_wall_nlp_"))
                    row = (solution, inside, stats["iter_count"], float(found["f"]))
                    one["best"] = min(one["best"], row) if one["best"] else row
            for one in contenders:
                solution, inside, iterations, cost = one["best"]
                cells = [f"{title}, {problem.knots} knots", one["name"], one["size"], iterations, f"{cost:.6f}",
                         f"{one['preparation']:.2f}", f"{solution:.3f}", f"{inside:.3f}"]
                print("| " + " | ".join(map(str, cells)) + " |", flush=True)
            ours, *others = (one["best"] for one in contenders)
            for theirs in others:
                assert ours[2] == theirs[2], (ours[2], theirs[2])
                assert abs(ours[3] - theirs[3]) <= 1e-6 * abs(theirs[3]), (ours[3], theirs[3])


main()
