"""A problem of optimal control, solved by acados with its exact Hessian, for dynamics by modyn or by CasADi's expressions."""

import contextlib
import io
import os

import casadi as ca
import numpy as np

KNOTS, TIME = 20, 0.6


def solve(name, folder, dynamics, start, discrete=False, library=None):
    """Returns the states and the forces of all knots, and the number of iterations.

    `dynamics` is a function of `q`, `qd` and `tau`: the accelerations, or the next state if `discrete`. `library` is the
    path of the shared library that it calls, `libNAME.so`.
    """
    # acados prints what it does, also while it is imported.
    with contextlib.redirect_stdout(io.StringIO()):
        from acados_template import AcadosModel, AcadosOcp, AcadosOcpSolver

        n = len(start) // 2
        model = AcadosModel()
        model.name = name
        model.x, model.u = ca.MX.sym("x", 2 * n), ca.MX.sym("u", n)
        q, qd = model.x[:n], model.x[n:]
        if discrete:
            model.disc_dyn_expr = ca.vertcat(*dynamics(q, qd, model.u, TIME / KNOTS))
        else:
            model.f_expl_expr = ca.vertcat(qd, dynamics(q, qd, model.u))
        ocp = AcadosOcp(acados_path=os.environ["ACADOS_SOURCE_DIR"])
        ocp.model, ocp.dims.N, ocp.code_export_directory = model, KNOTS, f"{folder}/{name}"
        cost, constraints, options = ocp.cost, ocp.constraints, ocp.solver_options
        cost.cost_type = cost.cost_type_e = "LINEAR_LS"
        cost.Vx, cost.Vu = np.eye(3 * n, 2 * n), np.eye(3 * n, n, -2 * n)
        cost.W, cost.yref = np.diag([5.0] * n + [0.5] * n + [0.01] * n), np.zeros(3 * n)
        cost.Vx_e, cost.W_e, cost.yref_e = np.eye(2 * n), 20 * np.eye(2 * n), np.zeros(2 * n)
        constraints.x0 = np.array(start)
        constraints.idxbu, constraints.lbu, constraints.ubu = np.arange(n), np.full(n, -15.0), np.full(n, 15.0)
        options.tf, options.nlp_solver_type, options.hessian_approx = TIME, "SQP", "EXACT"
        options.qp_solver, options.regularize_method = "PARTIAL_CONDENSING_HPIPM", "MIRROR"
        options.integrator_type = "DISCRETE" if discrete else "ERK"
        options.nlp_solver_max_iter, options.print_level = 100, 0
        if library:
            options.model_external_shared_lib_dir = os.path.dirname(library)
            options.model_external_shared_lib_name = os.path.basename(library)[len("lib") : -len(".so")]
        solver = AcadosOcpSolver(ocp, json_file=f"{folder}/{name}.json", verbose=False)
        status = solver.solve()
        assert status == 0, f"{name}: acados returned {status}"
        states = np.array([solver.get(k, "x") for k in range(KNOTS + 1)])
        forces = np.array([solver.get(k, "u") for k in range(KNOTS)])
        return states, forces, solver.get_stats("sqp_iter").item()
