// Traces Pinocchio's algorithms on CasADi's symbols, and writes C in modyn's order of joints:
// FOLDER ROBOT QUANTITY cse|plain MODEL writes ROBOT_QUANTITY.c to the current folder.
#include <pinocchio/autodiff/casadi.hpp>

#include "model.hpp"

#include <pinocchio/algorithm/aba-derivatives.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/rnea.hpp>

using casadi::SX;
using Vector = Eigen::Matrix<SX, Eigen::Dynamic, 1>;
using Matrix = Eigen::Matrix<SX, Eigen::Dynamic, Eigen::Dynamic>;

namespace {

// Rounds numbers that are nearly 0, 1 or -1 to these values.
constexpr double NEAR = 1e-9;

void snap(double &number) {
    for (double whole : {-1.0, 0.0, 1.0})
        if (std::abs(number - whole) < NEAR) number = whole;
}

// Rounds the numbers of the placements, so that CasADi can leave out zeros and ones.
void snap(pinocchio::Model &model) {
    for (auto &placement : model.jointPlacements) {
        for (double &number : placement.rotation().reshaped()) snap(number);
        for (double &number : placement.translation())
            if (std::abs(number) < NEAR) number = 0;
    }
}

// Symbols in modyn's order, and the same symbols in Pinocchio's order.
struct Symbols {
    SX own;
    Vector placed;

    Symbols(const std::string &name, const std::vector<int> &order)
        : own(SX::sym(name, order.size())), placed(order.size()) {
        for (std::size_t k = 0; k < order.size(); ++k) placed[order[k]] = SX(own(k));
    }
};

template <class V> SX vector(const V &x, const std::vector<int> &order) {
    SX out = SX::zeros(order.size());
    for (std::size_t k = 0; k < order.size(); ++k) out(k) = x[order[k]];
    return out;
}

template <class M> SX matrix(const M &x, const std::vector<int> &order, bool upper = false) {
    SX out = SX::zeros(order.size(), order.size());
    for (std::size_t i = 0; i < order.size(); ++i)
        for (std::size_t j = 0; j < order.size(); ++j) {
            const bool swap = upper && order[i] > order[j];
            out(i, j) = swap ? x(order[j], order[i]) : x(order[i], order[j]);
        }
    return out;
}

} // namespace

int main(int count, char **arguments) {
    if (count != 6) throw std::runtime_error("FOLDER ROBOT QUANTITY cse|plain MODEL");
    const std::string robot = arguments[2], quantity = arguments[3], how = arguments[4];
    const Joints joints(arguments[1], robot);
    pinocchio::Model numbers = read(arguments[5]);
    const Order order(numbers, joints);
    snap(numbers);

    const auto model = numbers.cast<SX>();
    pinocchio::DataTpl<SX> data(model);
    const Symbols q("q", order.q), qd("qd", order.v), x("x", order.v);
    std::vector<SX> inputs{q.own, qd.own, x.own}, outputs;
    if (quantity == "forward_dynamics") {
        pinocchio::aba(model, data, q.placed, qd.placed, x.placed);
        outputs = {vector(data.ddq, order.v)};
    } else if (quantity == "inverse_dynamics") {
        pinocchio::rnea(model, data, q.placed, qd.placed, x.placed);
        outputs = {vector(data.tau, order.v)};
    } else if (quantity == "mass_matrix") {
        data.M.setZero();
        pinocchio::crba(model, data, q.placed, pinocchio::Convention::LOCAL);
        inputs = {q.own};
        outputs = {matrix(data.M, order.v, true)};
    } else if (quantity == "forward_dynamics_derivatives") {
        pinocchio::computeABADerivatives(model, data, q.placed, qd.placed, x.placed);
        outputs = {vector(data.ddq, order.v), matrix(data.ddq_dq, order.v),
                   matrix(data.ddq_dv, order.v), matrix(data.Minv, order.v)};
    } else
        throw std::runtime_error("no quantity " + quantity);
    if (how == "cse") outputs = cse(outputs);
    const casadi::Function function("function", inputs, outputs);
    function.generate(robot + "_" + quantity + ".c");
    std::printf("%lld instructions\n", function.n_instructions());
}
