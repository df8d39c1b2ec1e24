/// The Python module `arm7`: the arm's action models for Crocoddyl, one of them with a cost in C++.
#include "python.hpp"
#include "reach.hpp"

namespace {

using ReachModel = modyn::ActionModel<Arm7, ReachCost>;

std::shared_ptr<ReachModel> reach(modyn::python::StatePointer state, boost::python::dict task, boost::python::dict weights, double dt) {
    const auto vector = [&](const char *name) { return boost::python::extract<Eigen::VectorXd>(task[name])(); };
    const auto number = [&](const char *name) { return boost::python::extract<double>(weights[name])(); };
    const Task of{vector("place"), boost::python::extract<Eigen::MatrixXd>(task["rotation"])(), vector("posture"), vector("torques"),
                  vector("lower"), vector("upper")};
    const Weights by{number("place"), number("turn"), number("posture"), number("velocity"), number("control"), number("limit")};
    return std::make_shared<ReachModel>(state, std::make_shared<ReachCost>(of, by), dt);
}

}

BOOST_PYTHON_MODULE(arm7) {
    modyn::python::expose<Arm7, arm7_link_names>();
    modyn::python::expose_action<ReachModel>("ReachActionModel", reach);
}
