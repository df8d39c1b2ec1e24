/* The arm's hand moves to a pose by acados, whose external functions call the arm's generated C: no CasADi. The optimum is that of
   examples/crocoddyl/arm.py. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "acados/utils/types.h"
#include "acados_c/external_function_interface.h"
#include "acados_c/ocp_nlp_interface.h"
#include "blasfeo_d_aux.h"

#include "arm7.h"

enum { KNOTS = 30, NV = ARM7_NV, NX = 2 * NV, NU = NV, NUX = NU + NX, NY_LAST = 6 + NX + NV, NY = NY_LAST + NU };
static const double DT = 0.02;
static const double LOWER[NV] = {-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973};
static const double UPPER[NV] = {2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973};
static const double START[NX] = {0, -0.785, 0, -2.356, 0, 1.571, 0.785};
static const double GOAL[NV] = {0.5, -0.2, -0.2, -1.9, 0.3, 2.0, 0.5};
static arm7_pose_t goal;
static double hold[NU];

/* The entries of an argument x or u, which acados keeps in one vector. */
static void unpack(int size, const void *argument, double *numbers) {
    const struct blasfeo_dvec_args *at = argument;
    blasfeo_unpack_dvec(size, at->x, at->xi, numbers, 1);
}

/* disc_dyn_fun: x' of x and u. */
static int step(void **in, void **out, void *parameters) {
    const struct blasfeo_dvec_args *next = out[0];
    double x[NX], u[NU];
    arm7_step_t after;
    (void)parameters;
    unpack(NX, in[0], x);
    unpack(NU, in[1], u);
    arm7_step_semi_implicit(x, x + NV, u, &DT, &after);
    blasfeo_pack_dvec(NV, after.q, 1, next->x, next->xi);
    blasfeo_pack_dvec(NV, after.qd, 1, next->x, next->xi + NV);
    return 0;
}

/* disc_dyn_fun_jac: x', and the transpose of its derivatives with respect to u, then x. */
static int step_and_derivatives(void **in, void **out, void *parameters) {
    const struct blasfeo_dvec_args *next = out[0];
    const struct blasfeo_dmat_args *transposed = out[1];
    double x[NX], u[NU], by_ux[NX][NUX] = {{0}};
    arm7_knot_t knot;
    (void)parameters;
    unpack(NX, in[0], x);
    unpack(NU, in[1], u);
    arm7_knot(x, x + NV, u, &DT, &knot);
    for (int i = 0; i < NV; ++i) {
        double *velocity = by_ux[NV + i], *position = by_ux[i];
        memcpy(velocity, knot.dqd_dtau[i], sizeof knot.dqd_dtau[i]);
        memcpy(velocity + NU, knot.dqd_dq[i], sizeof knot.dqd_dq[i]);
        memcpy(velocity + NU + NV, knot.dqd_dqd[i], sizeof knot.dqd_dqd[i]);
        for (int j = 0; j < NUX; ++j) position[j] = DT * velocity[j];
        position[NU + i] += 1;
        x[i] += DT * knot.qd[i];
    }
    blasfeo_pack_dvec(NV, x, 1, next->x, next->xi);
    blasfeo_pack_dvec(NV, knot.qd, 1, next->x, next->xi + NV);
    /* acados has columns: a row here is a column of the transpose. */
    blasfeo_pack_dmat(NUX, NX, by_ux[0], NUX, transposed->A, transposed->ai, transposed->aj);
    return 0;
}

/* The rotation vector of the hand's rotation in the goal's axes, and its derivative with respect to a rotation about world axes. */
static void rotation_error(const arm7_pose_t *hand, double vector[3], double by_world[3][3]) {
    double error[3][3], square[3][3], local[3][3];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            error[i][j] = 0;
            for (int k = 0; k < 3; ++k) error[i][j] += goal.rotation[k][i] * hand->rotation[k][j];
        }
    const double twice[3] = {error[2][1] - error[1][2], error[0][2] - error[2][0], error[1][0] - error[0][1]};
    const double sine = 0.5 * sqrt(twice[0] * twice[0] + twice[1] * twice[1] + twice[2] * twice[2]);
    const double angle = atan2(sine, 0.5 * (error[0][0] + error[1][1] + error[2][2] - 1));
    const double scale = angle < 1e-6 ? 0.5 : 0.5 * angle / sine;
    for (int i = 0; i < 3; ++i) vector[i] = scale * twice[i];
    const double cross[3][3] = {{0, -vector[2], vector[1]}, {vector[2], 0, -vector[0]}, {-vector[1], vector[0], 0}};
    const double second = angle < 1e-3 ? 1.0 / 12 : (1 - 0.5 * angle / tan(0.5 * angle)) / (angle * angle);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            square[i][j] = 0;
            for (int k = 0; k < 3; ++k) square[i][j] += cross[i][k] * cross[k][j];
            local[i][j] = (i == j) + 0.5 * cross[i][j] + second * square[i][j];
        }
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            by_world[i][j] = 0;
            for (int k = 0; k < 3; ++k) by_world[i][j] += local[i][k] * hand->rotation[j][k];
        }
}

/* The residuals of x and u: the hand's place and rotation, the posture, velocities, passed joint limits, torques. The last knot has
   no u. A row of `by_ux` has the derivatives with respect to u, then x; null if they are not wanted. */
static void residuals(const double *x, const double *u, double *y, double (*by_ux)[NUX]) {
    const int nu = u ? NU : 0, position = nu;
    double turn[3][3], jacobian[6 * NV]; /* by columns */
    arm7_pose_t hand;
    arm7_link_pose(x, ARM7_LINK_GRASP_POINT, &hand);
    for (int i = 0; i < 3; ++i) y[i] = hand.translation[i] - goal.translation[i];
    rotation_error(&hand, y + 3, turn);
    for (int i = 0; i < NX; ++i) y[6 + i] = x[i] - START[i];
    for (int i = 0; i < NV; ++i) y[6 + NX + i] = fmax(0, x[i] - UPPER[i]) + fmin(0, x[i] - LOWER[i]);
    for (int i = 0; i < nu; ++i) y[NY_LAST + i] = u[i] - hold[i];
    if (!by_ux) return;
    arm7_jacobian(x, ARM7_LINK_GRASP_POINT, jacobian);
    for (int j = 0; j < NV; ++j)
        for (int i = 0; i < 3; ++i) {
            by_ux[i][position + j] = jacobian[6 * j + i];
            for (int k = 0; k < 3; ++k) by_ux[3 + i][position + j] += turn[i][k] * jacobian[6 * j + 3 + k];
        }
    for (int i = 0; i < NX; ++i) by_ux[6 + i][position + i] = 1;
    for (int i = 0; i < NV; ++i) by_ux[6 + NX + i][position + i] = y[6 + NX + i] != 0;
    for (int i = 0; i < nu; ++i) by_ux[NY_LAST + i][i] = 1;
}

/* nls_y_fun and nls_y_fun_jac. */
static int cost(void **in, void **out, void *parameters) {
    double x[NX], u[NU], y[NY];
    (void)parameters;
    unpack(NX, in[0], x);
    unpack(NU, in[1], u);
    residuals(x, u, y, NULL);
    blasfeo_pack_dvec(NY, y, 1, out[0], 0);
    return 0;
}

static int cost_and_derivatives(void **in, void **out, void *parameters) {
    double x[NX], u[NU], y[NY], by_ux[NY][NUX] = {{0}};
    (void)parameters;
    unpack(NX, in[0], x);
    unpack(NU, in[1], u);
    residuals(x, u, y, by_ux);
    blasfeo_pack_dvec(NY, y, 1, out[0], 0);
    blasfeo_pack_dmat(NUX, NY, by_ux[0], NUX, out[1], 0, 0);
    return 0;
}

static int last_cost(void **in, void **out, void *parameters) {
    double x[NX], y[NY_LAST];
    (void)parameters;
    unpack(NX, in[0], x);
    residuals(x, NULL, y, NULL);
    blasfeo_pack_dvec(NY_LAST, y, 1, out[0], 0);
    return 0;
}

static int last_cost_and_derivatives(void **in, void **out, void *parameters) {
    double x[NX], y[NY_LAST], by_ux[NY_LAST][NUX] = {{0}};
    (void)parameters;
    unpack(NX, in[0], x);
    residuals(x, NULL, y, by_ux);
    blasfeo_pack_dvec(NY_LAST, y, 1, out[0], 0);
    blasfeo_pack_dmat(NX, NY_LAST, by_ux[0], NUX, out[1], 0, 0);
    return 0;
}

static void create(external_function_param_generic *function, int (*call)(void **, void **, void *)) {
    external_function_param_generic_set_fun(function, (void *)call);
    external_function_param_generic_create(function, 0);
}

/* Solves for torques of at most `share` of the motors'. Returns whether acados finds the cost `expected`. */
static int solve(double share, double expected) {
    static const double LIMIT[NU] = {87, 87, 87, 87, 12, 12, 12};
    ocp_nlp_plan_t *plan = ocp_nlp_plan_create(KNOTS);
    plan->nlp_solver = SQP;
    plan->ocp_qp_solver_plan.qp_solver = PARTIAL_CONDENSING_HPIPM;
    plan->regularization = NO_REGULARIZE;
    for (int k = 0; k <= KNOTS; ++k) {
        plan->nlp_cost[k] = NONLINEAR_LS;
        plan->nlp_constraints[k] = BGH;
        if (k < KNOTS) plan->nlp_dynamics[k] = DISCRETE_MODEL;
    }
    ocp_nlp_config *config = ocp_nlp_config_create(*plan);
    ocp_nlp_dims *dims = ocp_nlp_dims_create(config);
    int nx[KNOTS + 1], nu[KNOTS + 1], zero[KNOTS + 1] = {0}, index[NX];
    for (int i = 0; i < NX; ++i) index[i] = i;
    for (int k = 0; k <= KNOTS; ++k) {
        nx[k] = NX;
        nu[k] = k < KNOTS ? NU : 0;
    }
    ocp_nlp_dims_set_opt_vars(config, dims, "nx", nx);
    ocp_nlp_dims_set_opt_vars(config, dims, "nu", nu);
    ocp_nlp_dims_set_opt_vars(config, dims, "nz", zero);
    ocp_nlp_dims_set_opt_vars(config, dims, "ns", zero);
    for (int k = 0; k <= KNOTS; ++k) {
        int ny = k < KNOTS ? NY : NY_LAST, nbx = k == 0 ? NX : 0;
        ocp_nlp_dims_set_cost(config, dims, k, "ny", &ny);
        ocp_nlp_dims_set_constraints(config, dims, k, "nbx", &nbx);
        ocp_nlp_dims_set_constraints(config, dims, k, "nbxe", &nbx);
        ocp_nlp_dims_set_constraints(config, dims, k, "nbu", &nu[k]);
    }

    external_function_param_generic functions[6];
    create(&functions[0], step);
    create(&functions[1], step_and_derivatives);
    create(&functions[2], cost);
    create(&functions[3], cost_and_derivatives);
    create(&functions[4], last_cost);
    create(&functions[5], last_cost_and_derivatives);
    ocp_nlp_in *in = ocp_nlp_in_create(config, dims);
    double lower[NU], upper[NU], y_reference[NY] = {0}, start[NX];
    memcpy(start, START, sizeof start);
    for (int i = 0; i < NU; ++i) {
        upper[i] = share * LIMIT[i];
        lower[i] = -upper[i];
    }
    for (int k = 0; k <= KNOTS; ++k) {
        const int last = k == KNOTS, ny = last ? NY_LAST : NY;
        double weights[NY * NY] = {0}, scaling = last ? 1 : DT, time_step = DT;
        for (int i = 0; i < ny; ++i)
            weights[i * (ny + 1)] = i < 3 ? (last ? 100 : 10) : i < 6 ? (last ? 10 : 1) : i < 6 + NV ? 1e-2 : i < 6 + NX ? (last ? 1 : 1e-2)
                                  : i < NY_LAST ? 100 : 1e-4;
        ocp_nlp_cost_model_set(config, dims, in, k, "W", weights);
        ocp_nlp_cost_model_set(config, dims, in, k, "yref", y_reference);
        ocp_nlp_cost_model_set(config, dims, in, k, "scaling", &scaling);
        ocp_nlp_cost_model_set(config, dims, in, k, "nls_y_fun", &functions[last ? 4 : 2]);
        ocp_nlp_cost_model_set(config, dims, in, k, "nls_y_fun_jac", &functions[last ? 5 : 3]);
        if (last) continue;
        ocp_nlp_in_set(config, dims, in, k, "Ts", &time_step);
        ocp_nlp_dynamics_model_set(config, dims, in, k, "disc_dyn_fun", &functions[0]);
        ocp_nlp_dynamics_model_set(config, dims, in, k, "disc_dyn_fun_jac", &functions[1]);
        ocp_nlp_constraints_model_set(config, dims, in, k, "idxbu", index);
        ocp_nlp_constraints_model_set(config, dims, in, k, "lbu", lower);
        ocp_nlp_constraints_model_set(config, dims, in, k, "ubu", upper);
    }
    ocp_nlp_constraints_model_set(config, dims, in, 0, "idxbx", index);
    ocp_nlp_constraints_model_set(config, dims, in, 0, "idxbxe", index);
    ocp_nlp_constraints_model_set(config, dims, in, 0, "lbx", start);
    ocp_nlp_constraints_model_set(config, dims, in, 0, "ubx", start);

    void *options = ocp_nlp_solver_opts_create(config, dims);
    double tolerance = 1e-9;
    int most = 200, silent = 0;
    const char *tolerances[] = {"tol_stat", "tol_eq", "tol_ineq", "tol_comp"};
    for (int i = 0; i < 4; ++i) ocp_nlp_solver_opts_set(config, options, tolerances[i], &tolerance);
    ocp_nlp_solver_opts_set(config, options, "max_iter", &most);
    ocp_nlp_solver_opts_set(config, options, "print_level", &silent);
    ocp_nlp_solver_opts_set(config, options, "globalization", "fixed_step");
    ocp_nlp_out *out = ocp_nlp_out_create(config, dims);
    ocp_nlp_solver *solver = ocp_nlp_solver_create(config, dims, options);
    for (int k = 0; k <= KNOTS; ++k) {
        ocp_nlp_out_set(config, dims, out, k, "x", start);
        if (k < KNOTS) ocp_nlp_out_set(config, dims, out, k, "u", hold);
    }
    ocp_nlp_precompute(solver, in, out);
    const int status = ocp_nlp_solve(solver, in, out);
    double value, total, functions_time;
    int iterations;
    ocp_nlp_eval_cost(solver, in, out);
    ocp_nlp_get(config, solver, "cost_value", &value);
    ocp_nlp_get(config, solver, "sqp_iter", &iterations);
    ocp_nlp_get(config, solver, "time_tot", &total);
    ocp_nlp_get(config, solver, "time_lin", &functions_time);
    printf("torques up to %3.0f %%: cost %.12f, status %d, %d iterations of %.0f us, of which functions %.0f us\n", 100 * share, value, status,
           iterations, 1e6 * total / iterations, 1e6 * functions_time / iterations);

    ocp_nlp_solver_destroy(solver);
    ocp_nlp_out_destroy(out);
    ocp_nlp_solver_opts_destroy(options);
    ocp_nlp_in_destroy(in);
    for (int i = 0; i < 6; ++i) external_function_param_generic_free(&functions[i]);
    ocp_nlp_dims_destroy(dims);
    ocp_nlp_config_destroy(config);
    ocp_nlp_plan_destroy(plan);
    return status == 0 && fabs(value - expected) < 1e-8;
}

int main(void) {
    const double still[NV] = {0};
    arm7_link_pose(GOAL, ARM7_LINK_GRASP_POINT, &goal);
    arm7_bias_forces(START, still, hold);
    const int whole = solve(1, 0.094170254815), limited = solve(0.3, 0.107380173085);
    return whole && limited ? 0 : 1;
}
