// Pinocchio's algorithms, from its headers: FOLDER ROBOT QUANTITY REPETITIONS MODEL.
#include "model.hpp"

#include <pinocchio/algorithm/aba-derivatives.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/rnea.hpp>

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// Converts from modyn's order to Pinocchio's.
VectorXd placed(const Numbers &numbers, const std::vector<int> &order) {
    VectorXd x(numbers.size());
    for (std::size_t k = 0; k < order.size(); ++k) x[order[k]] = numbers[k];
    return x;
}

// Converts back to modyn's order; returns the numbers after `out`.
template <class Vector> void append(Numbers &out, const Vector &x, const std::vector<int> &order) {
    for (int k : order) out.push_back(x[k]);
}

void append_matrix(Numbers &out, const MatrixXd &x, const std::vector<int> &order) {
    for (int column : order)
        for (int row : order) out.push_back(x(row, column));
}

} // namespace

int main(int count, char **arguments) {
    const Job job(count, arguments);
    const pinocchio::Model model = read(job.argument(count, arguments, 5));
    const Order order(model, job.joints);
    pinocchio::Data data(model);
    data.M.setZero();
    std::vector<VectorXd> q, qd, tau, qdd;
    for (const State &state : job.states) {
        q.push_back(placed(state.q, order.q));
        qd.push_back(placed(state.qd, order.v));
        tau.push_back(placed(state.tau, order.v));
        qdd.push_back(placed(state.qdd, order.v));
    }
    if (job.quantity == "forward_dynamics")
        run(
            job, [&](int i) { pinocchio::aba(model, data, q[i], qd[i], tau[i]); },
            [&](int) {
                Numbers out;
                append(out, data.ddq, order.v);
                return out;
            });
    else if (job.quantity == "inverse_dynamics")
        run(
            job, [&](int i) { pinocchio::rnea(model, data, q[i], qd[i], qdd[i]); },
            [&](int) {
                Numbers out;
                append(out, data.tau, order.v);
                return out;
            });
    else if (job.quantity == "mass_matrix")
        // Fills the upper triangle only.
        run(
            job, [&](int i) { pinocchio::crba(model, data, q[i], pinocchio::Convention::LOCAL); },
            [&](int) {
                Numbers out;
                const MatrixXd whole = data.M.selfadjointView<Eigen::Upper>();
                append_matrix(out, whole, order.v);
                return out;
            });
    else if (job.quantity == "forward_dynamics_derivatives")
        run(
            job,
            [&](int i) { pinocchio::computeABADerivatives(model, data, q[i], qd[i], tau[i]); },
            [&](int) {
                Numbers out;
                append(out, data.ddq, order.v);
                append_matrix(out, data.ddq_dq, order.v);
                append_matrix(out, data.ddq_dv, order.v);
                append_matrix(out, data.Minv, order.v);
                return out;
            });
    else
        throw std::runtime_error("no quantity " + job.quantity);
}
