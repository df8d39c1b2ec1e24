/// A Python module with a robot's states, residuals and action models for Crocoddyl, by Crocoddyl's own Boost.Python.
#ifndef MODYN_CROCODDYL_PYTHON_HPP
#define MODYN_CROCODDYL_PYTHON_HPP

#include <eigenpy/eigenpy.hpp>

#include <crocoddyl/multibody/friction-cone.hpp>

#include <cmath>
#include <string>

#include "modyn_crocoddyl.hpp"

namespace modyn::python {

namespace bp = boost::python;
using StatePointer = std::shared_ptr<crocoddyl::StateAbstract>;
using ResidualPointer = std::shared_ptr<crocoddyl::ResidualModelAbstract>;
using SumPointer = std::shared_ptr<crocoddyl::CostModelSum>;

/// The place of a name in a table of C, such as `arm7_link_names`.
template <const auto &Names> std::size_t find(const std::string &name) {
    std::size_t place = 0;
    for (const char *other : Names) {
        if (name == other) return place;
        ++place;
    }
    throw std::invalid_argument("modyn: the robot has no `" + name + "`");
}

/// Adds a state with the methods that Crocoddyl gives its own states.
template <class Model> void expose_state() {
    using Vector = const Eigen::VectorXd &;
    bp::class_<Model, bp::bases<crocoddyl::StateAbstract>, std::shared_ptr<Model>>("State")
        .def("zero", &Model::zero)
        .def("rand", &Model::rand)
        .def("diff", +[](Model &state, Vector x0, Vector x1) { return state.diff_dx(x0, x1); })
        .def("integrate", +[](Model &state, Vector x, Vector dx) { return state.integrate_x(x, dx); })
        .def("Jdiff", +[](Model &state, Vector x0, Vector x1) {
            const auto derivatives = state.Jdiff_Js(x0, x1);
            return bp::make_tuple(derivatives[0], derivatives[1]);
        })
        .def("Jintegrate", +[](Model &state, Vector x, Vector dx) {
            const auto derivatives = state.Jintegrate_Js(x, dx);
            return bp::make_tuple(derivatives[0], derivatives[1]);
        })
        .def("JintegrateTransport", &Model::JintegrateTransport);
}

/// Adds an action model that `make` constructs, with the methods that Crocoddyl gives its own.
template <class Model, class Make> void expose_action(const char *name, Make make) {
    using Data = const std::shared_ptr<crocoddyl::ActionDataAbstract> &;
    using Vector = const Eigen::VectorXd &;
    bp::class_<Model, bp::bases<crocoddyl::ActionModelAbstract>, std::shared_ptr<Model>>(name, bp::no_init)
        .def("__init__", bp::make_constructor(make))
        .def("createData", &Model::createData)
        .def("calc", +[](Model &model, Data data, Vector x, Vector u) { model.calc(data, x, u); })
        .def("calc", +[](Model &model, Data data, Vector x) { model.calc(data, x); })
        .def("calcDiff", +[](Model &model, Data data, Vector x, Vector u) { model.calcDiff(data, x, u); })
        .def("calcDiff", +[](Model &model, Data data, Vector x) { model.calcDiff(data, x); });
}

/// Adds `State`, `ResidualModelState`, `ResidualModelFrame...` and `ActionModel` to the module.
template <class Robot, const auto &LinkNames> void expose() {
    bp::import("crocoddyl");
    expose_state<State<Robot>>();
    bp::def("ResidualModelState", +[](StatePointer state, const Eigen::VectorXd &reference) {
        return ResidualPointer(std::make_shared<ResidualModelState<Robot>>(state, reference));
    });
    bp::def("ResidualModelFrameTranslation", +[](StatePointer state, const std::string &link, const Eigen::VectorXd &reference) {
        const auto place = static_cast<typename Robot::Link>(find<LinkNames>(link));
        return ResidualPointer(std::make_shared<ResidualModelFrameTranslation<Robot>>(state, place, reference));
    });
    bp::def("ResidualModelFrameRotation", +[](StatePointer state, const std::string &link, const Eigen::MatrixXd &reference) {
        const auto place = static_cast<typename Robot::Link>(find<LinkNames>(link));
        return ResidualPointer(std::make_shared<ResidualModelFrameRotation<Robot>>(state, place, reference));
    });
    bp::def("ResidualModelFramePlacement", +[](StatePointer state, const std::string &link, const pinocchio::SE3 &reference) {
        const auto place = static_cast<typename Robot::Link>(find<LinkNames>(link));
        return ResidualPointer(std::make_shared<ResidualModelFramePlacement<Robot>>(state, place, reference));
    });
    expose_action<ActionModel<Robot>>("ActionModel", +[](StatePointer state, SumPointer costs, double dt) {
        return std::make_shared<ActionModel<Robot>>(state, costs, dt);
    });
}

/// Adds `ContactActionModel` and `ResidualModelContactFrictionCone` to the module.
template <class Robot, const auto &ContactNames> void expose_contacts() {
    // `gains` are the stiffness towards the ground, 1/s^2, and the damping, 1/s, as in Crocoddyl's contacts.
    using Model = ContactActionModel<Robot>;
    const auto make = +[](StatePointer state, SumPointer costs, double dt, const bp::list &contacts, const Eigen::VectorXd &gains) {
        typename Model::Active active{};
        for (bp::ssize_t i = 0; i < bp::len(contacts); ++i) {
            const std::string name = bp::extract<std::string>(contacts[i]);
            active[find<ContactNames>(name)] = true;
        }
        auto settings = Robot::default_constraint_settings();
        for (auto &target : settings.targets) {
            target.alpha = gains[1] / 2;
            target.beta = std::sqrt(gains[0]);
        }
        return std::make_shared<Model>(state, costs, dt, active, settings);
    };
    expose_action<Model>("ContactActionModel", make);
    bp::def("ResidualModelContactFrictionCone", +[](StatePointer state, const std::string &contact, const crocoddyl::FrictionCone &cone) {
        using Residual = ResidualModelContactFrictionCone<Robot, crocoddyl::FrictionCone>;
        return ResidualPointer(std::make_shared<Residual>(state, find<ContactNames>(contact), cone));
    });
}

}

#endif
