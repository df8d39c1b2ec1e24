// Pinocchio's algorithms, from its headers: FOLDER ROBOT QUANTITY REPETITIONS MODEL.
#include "model.hpp"

#include <pinocchio/algorithm/aba-derivatives.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/constrained-dynamics-derivatives.hpp>
#include <pinocchio/algorithm/constrained-dynamics.hpp>
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

// The accelerations, and their derivatives by q, qd and tau.
Numbers with_derivatives(const pinocchio::Data &data, const MatrixXd &by_tau, const std::vector<int> &order) {
    Numbers out;
    append(out, data.ddq, order);
    append_matrix(out, data.ddq_dq, order);
    append_matrix(out, data.ddq_dv, order);
    append_matrix(out, by_tau, order);
    return out;
}

// The contacts as Pinocchio's constraints; functions without contacts have none.
struct Constraints {
    PINOCCHIO_STD_VECTOR_WITH_EIGEN_ALLOCATOR(pinocchio::RigidConstraintModel) models;
    PINOCCHIO_STD_VECTOR_WITH_EIGEN_ALLOCATOR(pinocchio::RigidConstraintData) data;
    // The constraints are independent, so that one step without regularization is exact.
    pinocchio::ProximalSettings settings{1e-12, 0.0, 1};

    Constraints(const pinocchio::Model &model, pinocchio::Data &of, const std::vector<Contact> &contacts) {
        for (const Contact &contact : contacts) {
            const auto type = contact.surface ? pinocchio::CONTACT_6D : pinocchio::CONTACT_3D;
            models.emplace_back(type, model, contact.joint, contact.placement, pinocchio::LOCAL_WORLD_ALIGNED);
            data.emplace_back(models.back());
        }
        pinocchio::initConstraintDynamics(model, of, models, data);
    }

    void solve(const pinocchio::Model &model, pinocchio::Data &of, const VectorXd &q, const VectorXd &qd,
               const VectorXd &tau) {
        pinocchio::constraintDynamics(model, of, q, qd, tau, models, data, settings);
    }

    void differentiate(const pinocchio::Model &model, pinocchio::Data &of) {
        pinocchio::computeConstraintDynamicsDerivatives(model, of, models, data, settings);
    }
};

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
    const bool constrained = job.quantity.rfind("constrained_", 0) == 0;
    const auto held = constrained ? read_contacts(job.argument(count, arguments, 5)) : std::vector<Contact>();
    Constraints contacts(model, data, held);
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
            [&](int) { return with_derivatives(data, data.Minv, order.v); });
    else if (job.quantity == "constrained_forward_dynamics")
        run(
            job, [&](int i) { contacts.solve(model, data, q[i], qd[i], tau[i]); },
            [&](int) {
                Numbers out;
                append(out, data.ddq, order.v);
                return out;
            });
    else if (job.quantity == "constrained_forward_dynamics_derivatives")
        run(
            job,
            [&](int i) {
                contacts.solve(model, data, q[i], qd[i], tau[i]);
                contacts.differentiate(model, data);
            },
            [&](int) { return with_derivatives(data, data.ddq_dtau, order.v); });
    else
        throw std::runtime_error("no quantity " + job.quantity);
}
