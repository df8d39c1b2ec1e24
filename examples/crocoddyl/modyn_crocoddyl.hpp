/// Crocoddyl's states, action models and residuals over a robot's class by `modyn generate --target cpp`, for Crocoddyl 3.2.
///
/// `Robot` needs the functions `step_semi_implicit`, `knot`, `integrate`, `integrate_derivatives`, `difference` and
/// `difference_derivatives`; residuals of frames need `link_pose` and `jacobian`, contacts `constrained_forward_dynamics` and
/// `constrained_knot`. Names, arguments, residuals and time steps are those of Crocoddyl's classes, without Pinocchio's model.
/// Coordinates are in modyn's order: a floating base is x, y, z, qx, qy, qz, qw with velocities in its own axes, as in Pinocchio.
#ifndef MODYN_CROCODDYL_HPP
#define MODYN_CROCODDYL_HPP

#include <pinocchio/spatial/explog.hpp>
#include <pinocchio/spatial/se3.hpp>

#include <crocoddyl/core/action-base.hpp>
#include <crocoddyl/core/costs/cost-sum.hpp>
#include <crocoddyl/core/residual-base.hpp>
#include <crocoddyl/core/state-base.hpp>

#include <array>
#include <cstddef>
#include <memory>
#include <ostream>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace modyn {

using VectorIn = Eigen::Ref<const Eigen::VectorXd>;
using MatrixOut = Eigen::Ref<Eigen::MatrixXd>;

/// The clones that Crocoddyl asks for. The scalar of generated code is fixed: only the clone of double exists.
#define MODYN_CLONES(Base, Class)                                                                                              \
    std::shared_ptr<Base> cloneAsDouble() const override { return std::make_shared<Class>(*this); }                            \
    std::shared_ptr<Base> cloneAsFloat() const override { throw std::runtime_error("modyn: the scalar of " #Class " is double"); } \
    MODYN_CLONE_AD(Base, Class)
#ifdef CROCODDYL_WITH_CODEGEN
#define MODYN_CLONE_AD(Base, Class)                                                                                            \
    std::shared_ptr<Base> cloneAsADDouble() const override { throw std::runtime_error("modyn: the scalar of " #Class " is double"); }
#else
#define MODYN_CLONE_AD(Base, Class)
#endif

/// The state of a robot: q, then qd.
template <class Robot>
class State : public crocoddyl::StateAbstract {
public:
    static constexpr int nq = Robot::nq, nv = Robot::nv;
    /// Whether the first joint is a floating base.
    static constexpr bool floating = nq == nv + 1;
    static_assert(nq == nv || floating, "the only quaternion is that of a floating base, the first joint");

    /// Throws if the robot has a quaternion, but not that of a floating base at the first joint.
    State() : crocoddyl::StateAbstract(nq + nv, 2 * nv) {
        if constexpr (floating) {
            typename Robot::template Vector<nv> half_turn = Robot::template Vector<nv>::Zero();
            half_turn[3] = 3.141592653589793;
            const auto turned = Robot::integrate(zero().template head<nq>(), half_turn);
            if (!(turned[3] > 0.999)) throw std::invalid_argument("modyn: the only quaternion is not that of a first, floating joint");
        }
    }

    MODYN_CLONES(crocoddyl::StateBase, State)

    Eigen::VectorXd zero() const override {
        Eigen::VectorXd x = Eigen::VectorXd::Zero(nq + nv);
        if (floating) x[6] = 1;
        return x;
    }

    Eigen::VectorXd rand() const override {
        Eigen::VectorXd x(nq + nv);
        integrate(zero(), Eigen::VectorXd::Random(2 * nv), x);
        return x;
    }

    void diff(const VectorIn &x0, const VectorIn &x1, Eigen::Ref<Eigen::VectorXd> dx) const override {
        dx.template head<nv>() = Robot::difference(x0.template head<nq>(), x1.template head<nq>());
        dx.template tail<nv>() = x1.template tail<nv>() - x0.template tail<nv>();
    }

    void integrate(const VectorIn &x, const VectorIn &dx, Eigen::Ref<Eigen::VectorXd> result) const override {
        result.template head<nq>() = Robot::integrate(x.template head<nq>(), dx.template head<nv>());
        result.template tail<nv>() = x.template tail<nv>() + dx.template tail<nv>();
    }

    void Jdiff(const VectorIn &x0, const VectorIn &x1, MatrixOut Jfirst, MatrixOut Jsecond,
               const crocoddyl::Jcomponent which = crocoddyl::both) const override {
        const auto by = Robot::difference_derivatives(x0.template head<nq>(), x1.template head<nq>());
        if (which != crocoddyl::second) assign(Jfirst, by.dv_dfrom, -1, crocoddyl::setto);
        if (which != crocoddyl::first) assign(Jsecond, by.dv_dto, 1, crocoddyl::setto);
    }

    void Jintegrate(const VectorIn &x, const VectorIn &dx, MatrixOut Jfirst, MatrixOut Jsecond,
                    const crocoddyl::Jcomponent which = crocoddyl::both,
                    const crocoddyl::AssignmentOp how = crocoddyl::setto) const override {
        const auto by = Robot::integrate_derivatives(x.template head<nq>(), dx.template head<nv>());
        if (which != crocoddyl::second) assign(Jfirst, by.dq_dq, 1, how);
        if (which != crocoddyl::first) assign(Jsecond, by.dq_dv, 1, how);
    }

    void JintegrateTransport(const VectorIn &x, const VectorIn &dx, MatrixOut Jin, const crocoddyl::Jcomponent which) const override {
        const auto by = Robot::integrate_derivatives(x.template head<nq>(), dx.template head<nv>());
        Jin.template topRows<nv>() = ((which == crocoddyl::first ? by.dq_dq : by.dq_dv) * Jin.template topRows<nv>()).eval();
    }

private:
    /// Sets, adds or subtracts the derivatives of a state: `position` of the coordinates, and 1 or -1 of the velocities.
    template <class Matrix>
    static void assign(MatrixOut &result, const Matrix &position, double velocity, crocoddyl::AssignmentOp how) {
        if (how == crocoddyl::setto) result.setZero();
        const double sign = how == crocoddyl::rmfrom ? -1 : 1;
        result.template topLeftCorner<nv, nv>() += sign * position;
        result.diagonal().template tail<nv>().array() += sign * velocity;
    }
};

namespace internal {

/// A(q, qd) by columns from derivatives by rows: Fx and Fu of the state after the step.
template <class Robot, class Knot>
void linearize(const Knot &knot, double dt, Eigen::MatrixXd &Fx, Eigen::MatrixXd &Fu) {
    constexpr int nv = Robot::nv;
    const Eigen::Index nu = Fu.cols();
    auto velocity = Fx.template bottomRows<nv>();
    velocity.template leftCols<nv>() = knot.dqd_dq;
    velocity.template rightCols<nv>() = knot.dqd_dqd;
    // The rows of the motors are the columns of the motors: the matrix is symmetric.
    Fu.template bottomRows<nv>() = knot.dqd_dtau.bottomRows(nu).transpose();
    Fx.template topRows<nv>() = dt * velocity;
    Fu.template topRows<nv>() = dt * Fu.template bottomRows<nv>();
    if constexpr (State<Robot>::floating) {
        Fx.template topRows<6>() = dt * (knot.dq_dv[0] * velocity.template topRows<6>());
        Fu.template topRows<6>() = dt * (knot.dq_dv[0] * Fu.template middleRows<6>(nv));
        Fx.template topLeftCorner<6, 6>() += knot.dq_dq[0];
        Fx.diagonal().segment(6, nv - 6).array() += 1;
    } else {
        Fx.diagonal().template head<nv>().array() += 1;
    }
}

}

/// A semi-implicit step of a robot with its cost: Crocoddyl's `IntegratedActionModelEuler` of a
/// `DifferentialActionModelFreeFwdDynamics`.
///
/// The controls are the joint forces; those of a floating base are zero. `Cost` is Crocoddyl's sum of costs, one of Crocoddyl's
/// cost models, or any class with their `createData`, `calc` and `calcDiff`. The cost of a step is multiplied by `dt`.
template <class Robot, class Cost = crocoddyl::CostModelSum>
class ActionModel : public crocoddyl::ActionModelAbstract {
public:
    static constexpr int nq = Robot::nq, nv = Robot::nv;
    /// The number of controls.
    static constexpr int nu = State<Robot>::floating ? nv - 6 : nv;
    using DataAbstract = std::shared_ptr<crocoddyl::ActionDataAbstract>;
    using CostData = decltype(std::declval<Cost &>().createData(std::declval<crocoddyl::DataCollectorAbstract *>()));

    ActionModel(std::shared_ptr<crocoddyl::StateAbstract> state, std::shared_ptr<Cost> cost, double dt)
        : crocoddyl::ActionModelAbstract(std::move(state), nu), cost(std::move(cost)), dt(dt) {}

    MODYN_CLONES(crocoddyl::ActionModelBase, ActionModel)

    /// `shared` is what the costs read besides the state and the controls.
    struct Data : crocoddyl::ActionDataAbstract {
        Data(ActionModel &model, std::unique_ptr<crocoddyl::DataCollectorAbstract> shared)
            : crocoddyl::ActionDataAbstract(static_cast<crocoddyl::ActionModelAbstract *>(&model)), shared(std::move(shared)),
              cost_data(model.cost->createData(this->shared.get())) {}
        std::unique_ptr<crocoddyl::DataCollectorAbstract> shared;
        CostData cost_data;
    };

    DataAbstract createData() override {
        return std::make_shared<Data>(*this, std::make_unique<crocoddyl::DataCollectorAbstract>());
    }
    bool checkData(const DataAbstract &data) override { return std::dynamic_pointer_cast<Data>(data) != nullptr; }

    void calc(const DataAbstract &data, const VectorIn &x, const VectorIn &u) override {
        auto &d = static_cast<Data &>(*data);
        const auto next = Robot::step_semi_implicit(x.template head<nq>(), x.template tail<nv>(), forces(u), dt);
        d.xnext.template head<nq>() = next.q;
        d.xnext.template tail<nv>() = next.qd;
        cost->calc(d.cost_data, x, u);
        d.cost = dt * d.cost_data->cost;
    }

    /// The last state of a problem has its cost, and no step.
    void calc(const DataAbstract &data, const VectorIn &x) override {
        auto &d = static_cast<Data &>(*data);
        d.xnext = x;
        cost->calc(d.cost_data, x);
        d.cost = d.cost_data->cost;
    }

    void calcDiff(const DataAbstract &data, const VectorIn &x, const VectorIn &u) override {
        auto &d = static_cast<Data &>(*data);
        const auto knot = Robot::knot(x.template head<nq>(), x.template tail<nv>(), forces(u), dt);
        internal::linearize<Robot>(knot, dt, d.Fx, d.Fu);
        cost->calcDiff(d.cost_data, x, u);
        weigh(d);
    }

    void calcDiff(const DataAbstract &data, const VectorIn &x) override {
        auto &d = static_cast<Data &>(*data);
        d.Fx.setIdentity();
        cost->calcDiff(d.cost_data, x);
        d.Lx = d.cost_data->Lx;
        d.Lxx = d.cost_data->Lxx;
    }

    void print(std::ostream &out) const override { out << "modyn::ActionModel {dt=" << dt << ", nu=" << nu << "}"; }

    const std::shared_ptr<Cost> &get_costs() const { return cost; }
    double get_dt() const { return dt; }

    /// The joint forces of controls.
    static typename Robot::template Vector<nv> forces(const VectorIn &u) {
        typename Robot::template Vector<nv> tau;
        if constexpr (nu < nv) tau.template head<nv - nu>().setZero();
        tau.template tail<nu>() = u;
        return tau;
    }

protected:
    /// Copies the costs' derivatives, times `dt`.
    void weigh(Data &d) const {
        d.Lx = dt * d.cost_data->Lx;
        d.Lu = dt * d.cost_data->Lu;
        d.Lxx = dt * d.cost_data->Lxx;
        d.Lxu = dt * d.cost_data->Lxu;
        d.Luu = dt * d.cost_data->Luu;
    }

    std::shared_ptr<Cost> cost;
    double dt;
};

/// The contacts of a step, which residuals of forces read.
template <class Robot>
struct Contacts : crocoddyl::DataCollectorAbstract {
    /// The wrench on each contact's link, in world axes.
    decltype(Robot::ConstrainedKnot::wrenches) wrenches;
    /// The derivatives, during `calcDiff`; else null.
    const typename Robot::ConstrainedKnot *knot = nullptr;
};

/// A semi-implicit step of a robot with active contacts, and its cost: Crocoddyl's `IntegratedActionModelEuler` of a
/// `DifferentialActionModelContactFwdDynamics`. Contacts that are not active have no force.
template <class Robot, class Cost = crocoddyl::CostModelSum>
class ContactActionModel : public ActionModel<Robot, Cost> {
    using Base = ActionModel<Robot, Cost>;
    using typename Base::Data;
    using typename Base::DataAbstract;
    static constexpr int nq = Robot::nq, nv = Robot::nv;

public:
    using Settings = typename Robot::ConstraintSettings;
    /// An entry for each contact.
    using Active = std::array<bool, std::tuple_size<decltype(Settings::targets)>::value>;
    static_assert(std::tuple_size<decltype(Robot::ConstrainedKnot::wrenches)>::value == std::tuple_size<Active>::value,
                  "residuals of forces count contacts: the robot has no loops");

    ContactActionModel(std::shared_ptr<crocoddyl::StateAbstract> state, std::shared_ptr<Cost> cost, double dt, const Active &active,
                       const Settings &settings = Robot::default_constraint_settings())
        : Base(std::move(state), std::move(cost), dt), active(active), settings(settings) {}

    MODYN_CLONES(crocoddyl::ActionModelBase, ContactActionModel)

    DataAbstract createData() override { return std::make_shared<Data>(*this, std::make_unique<Contacts<Robot>>()); }

    using Base::calc;
    using Base::calcDiff;

    void calc(const DataAbstract &data, const VectorIn &x, const VectorIn &u) override {
        auto &d = static_cast<Data &>(*data);
        const auto q = x.template head<nq>();
        const auto found = Robot::constrained_forward_dynamics(q, x.template tail<nv>(), this->forces(u), active, settings);
        const typename Robot::template Vector<nv> qd = x.template tail<nv>() + this->dt * found.qdd;
        d.xnext.template head<nq>() = Robot::integrate(q, this->dt * qd);
        d.xnext.template tail<nv>() = qd;
        static_cast<Contacts<Robot> &>(*d.shared).wrenches = found.wrenches;
        this->cost->calc(d.cost_data, x, u);
        d.cost = this->dt * d.cost_data->cost;
    }

    void calcDiff(const DataAbstract &data, const VectorIn &x, const VectorIn &u) override {
        auto &d = static_cast<Data &>(*data);
        auto &contacts = static_cast<Contacts<Robot> &>(*d.shared);
        const auto knot =
            Robot::constrained_knot(x.template head<nq>(), x.template tail<nv>(), this->forces(u), this->dt, active, settings);
        internal::linearize<Robot>(knot, this->dt, d.Fx, d.Fu);
        contacts.knot = &knot;
        this->cost->calcDiff(d.cost_data, x, u);
        contacts.knot = nullptr;
        this->weigh(d);
    }

    void print(std::ostream &out) const override {
        out << "modyn::ContactActionModel {dt=" << this->dt << ", nu=" << Base::nu << ", active=";
        for (const bool on : active) out << on;
        out << "}";
    }

    const Active &get_active() const { return active; }
    void set_active(const Active &value) { active = value; }

private:
    Active active;
    Settings settings;
};

/// The rows of a friction cone for the force of a contact: Crocoddyl's `ResidualModelContactFrictionCone`. `Cone` is
/// Crocoddyl's `FrictionCone`, in world axes.
template <class Robot, class Cone>
class ResidualModelContactFrictionCone : public crocoddyl::ResidualModelAbstract {
public:
    using DataAbstract = std::shared_ptr<crocoddyl::ResidualDataAbstract>;

    /// `contact` is an entry of `Robot::Contact`.
    ResidualModelContactFrictionCone(std::shared_ptr<crocoddyl::StateAbstract> state, std::size_t contact, const Cone &cone)
        : crocoddyl::ResidualModelAbstract(std::move(state), cone.get_A().rows(), ActionModel<Robot>::nu, true, true, true),
          contact(contact), cone(cone) {}

    MODYN_CLONES(crocoddyl::ResidualModelBase, ResidualModelContactFrictionCone)

    void calc(const DataAbstract &data, const VectorIn &, const VectorIn &) override {
        data->r = cone.get_A() * static_cast<const Contacts<Robot> &>(*data->shared).wrenches[contact].force;
    }

    void calcDiff(const DataAbstract &data, const VectorIn &, const VectorIn &) override {
        const auto &knot = *static_cast<const Contacts<Robot> &>(*data->shared).knot;
        constexpr int nv = Robot::nv, nu = ActionModel<Robot>::nu;
        data->Rx.template leftCols<nv>() = cone.get_A() * knot.dwrenches_dq[contact].template topRows<3>();
        data->Rx.template rightCols<nv>() = cone.get_A() * knot.dwrenches_dqd[contact].template topRows<3>();
        data->Ru = cone.get_A() * knot.dwrenches_dtau[contact].template topRightCorner<3, nu>();
    }

    /// There is no force at the end of a problem.
    void calc(const DataAbstract &data, const VectorIn &) override { data->r.setZero(); }
    void calcDiff(const DataAbstract &data, const VectorIn &) override { data->Rx.setZero(); }

    void print(std::ostream &out) const override { out << "modyn::ResidualModelContactFrictionCone"; }
    const Cone &get_reference() const { return cone; }
    void set_reference(const Cone &value) { cone = value; }

private:
    std::size_t contact;
    Cone cone;
};

/// The difference of the state from a reference.
template <class Robot>
class ResidualModelState : public crocoddyl::ResidualModelAbstract {
public:
    using DataAbstract = std::shared_ptr<crocoddyl::ResidualDataAbstract>;

    ResidualModelState(std::shared_ptr<crocoddyl::StateAbstract> state, Eigen::VectorXd reference, std::size_t nu = ActionModel<Robot>::nu)
        : crocoddyl::ResidualModelAbstract(state, 2 * Robot::nv, nu, true, true, false), reference(std::move(reference)) {}

    MODYN_CLONES(crocoddyl::ResidualModelBase, ResidualModelState)

    void calc(const DataAbstract &data, const VectorIn &x, const VectorIn &) override { state_->diff(reference, x, data->r); }

    void calcDiff(const DataAbstract &data, const VectorIn &x, const VectorIn &) override {
        state_->Jdiff(reference, x, data->Rx, data->Rx, crocoddyl::second);
    }

    /// The Jacobian is 1, except for a floating base.
    void calcCostDiff(const std::shared_ptr<crocoddyl::CostDataAbstract> &cost, const DataAbstract &residual,
                      const std::shared_ptr<crocoddyl::ActivationDataAbstract> &activation, const bool = true) override {
        cost->Lx = activation->Ar;
        cost->Lxx.diagonal() = activation->Arr.diagonal();
        if constexpr (State<Robot>::floating) {
            const Eigen::Matrix<double, 6, 6> base = residual->Rx.template topLeftCorner<6, 6>();
            const Eigen::Matrix<double, 6, 1> curvature = activation->Arr.diagonal().template head<6>();
            cost->Lx.template head<6>() = base.transpose() * activation->Ar.template head<6>();
            cost->Lxx.template topLeftCorner<6, 6>() = base.transpose() * curvature.asDiagonal() * base;
        }
    }

    void print(std::ostream &out) const override { out << "modyn::ResidualModelState"; }
    const Eigen::VectorXd &get_reference() const { return reference; }
    void set_reference(const Eigen::VectorXd &value) { reference = value; }

private:
    Eigen::VectorXd reference;
};

namespace internal {

/// A residual of the pose of a link and a reference.
template <class Robot, class Reference>
class ResidualModelFrame : public crocoddyl::ResidualModelAbstract {
public:
    using Link = typename Robot::Link;
    using DataAbstract = std::shared_ptr<crocoddyl::ResidualDataAbstract>;

    ResidualModelFrame(std::shared_ptr<crocoddyl::StateAbstract> state, std::size_t rows, Link link, const Reference &reference,
                       std::size_t nu)
        : crocoddyl::ResidualModelAbstract(std::move(state), rows, nu, true, false, false), link(link), reference(reference) {}

    struct Data : crocoddyl::ResidualDataAbstract {
        Data(crocoddyl::ResidualModelAbstract *model, crocoddyl::DataCollectorAbstract *shared) : crocoddyl::ResidualDataAbstract(model, shared) {}
        typename Robot::Pose pose; // of the link in the world
        pinocchio::SE3 error = pinocchio::SE3::Identity(); // of the link in the reference
    };

    DataAbstract createData(crocoddyl::DataCollectorAbstract *const shared) override { return std::make_shared<Data>(this, shared); }

    Link get_link() const { return link; }
    const Reference &get_reference() const { return reference; }
    void set_reference(const Reference &value) { reference = value; }

protected:
    typename Robot::Pose pose(const VectorIn &x) const { return Robot::link_pose(x.template head<Robot::nq>(), link); }
    typename Robot::template Matrix<6, Robot::nv> jacobian(const VectorIn &x) const {
        return Robot::jacobian(x.template head<Robot::nq>(), link);
    }
    Link link;
    Reference reference;
};

}

/// The displacement of a link's origin from a reference, in world axes.
template <class Robot>
class ResidualModelFrameTranslation : public internal::ResidualModelFrame<Robot, Eigen::Vector3d> {
    using Base = internal::ResidualModelFrame<Robot, Eigen::Vector3d>;

public:
    ResidualModelFrameTranslation(std::shared_ptr<crocoddyl::StateAbstract> state, typename Base::Link link,
                                  const Eigen::Vector3d &reference, std::size_t nu = ActionModel<Robot>::nu)
        : Base(std::move(state), 3, link, reference, nu) {}

    MODYN_CLONES(crocoddyl::ResidualModelBase, ResidualModelFrameTranslation)

    void calc(const typename Base::DataAbstract &data, const VectorIn &x, const VectorIn &) override {
        data->r = this->pose(x).translation - this->reference;
    }

    void calcDiff(const typename Base::DataAbstract &data, const VectorIn &x, const VectorIn &) override {
        data->Rx.template leftCols<Robot::nv>() = this->jacobian(x).template topRows<3>();
    }

    void print(std::ostream &out) const override { out << "modyn::ResidualModelFrameTranslation"; }
};

/// The rotation vector of a link's rotation relative to a reference, in the reference's axes.
template <class Robot>
class ResidualModelFrameRotation : public internal::ResidualModelFrame<Robot, Eigen::Matrix3d> {
    using Base = internal::ResidualModelFrame<Robot, Eigen::Matrix3d>;

public:
    ResidualModelFrameRotation(std::shared_ptr<crocoddyl::StateAbstract> state, typename Base::Link link,
                               const Eigen::Matrix3d &reference, std::size_t nu = ActionModel<Robot>::nu)
        : Base(std::move(state), 3, link, reference, nu) {}

    MODYN_CLONES(crocoddyl::ResidualModelBase, ResidualModelFrameRotation)

    void calc(const typename Base::DataAbstract &data, const VectorIn &x, const VectorIn &) override {
        auto &d = static_cast<typename Base::Data &>(*data);
        d.pose = this->pose(x);
        d.error.rotation() = this->reference.transpose() * d.pose.rotation;
        d.r = pinocchio::log3(d.error.rotation());
    }

    void calcDiff(const typename Base::DataAbstract &data, const VectorIn &x, const VectorIn &) override {
        auto &d = static_cast<typename Base::Data &>(*data);
        Eigen::Matrix3d log = Eigen::Matrix3d::Zero();
        pinocchio::Jlog3(d.error.rotation(), log);
        const Eigen::Matrix3d from_world = log * d.pose.rotation.transpose();
        d.Rx.template leftCols<Robot::nv>() = from_world * this->jacobian(x).template bottomRows<3>();
    }

    void print(std::ostream &out) const override { out << "modyn::ResidualModelFrameRotation"; }
};

/// The logarithm of a link's pose relative to a reference: linear, then angular.
template <class Robot>
class ResidualModelFramePlacement : public internal::ResidualModelFrame<Robot, pinocchio::SE3> {
    using Base = internal::ResidualModelFrame<Robot, pinocchio::SE3>;

public:
    ResidualModelFramePlacement(std::shared_ptr<crocoddyl::StateAbstract> state, typename Base::Link link,
                                const pinocchio::SE3 &reference, std::size_t nu = ActionModel<Robot>::nu)
        : Base(std::move(state), 6, link, reference, nu) {}

    MODYN_CLONES(crocoddyl::ResidualModelBase, ResidualModelFramePlacement)

    void calc(const typename Base::DataAbstract &data, const VectorIn &x, const VectorIn &) override {
        auto &d = static_cast<typename Base::Data &>(*data);
        d.pose = this->pose(x);
        d.error = this->reference.actInv(pinocchio::SE3(d.pose.rotation, d.pose.translation));
        d.r = pinocchio::log6(d.error).toVector();
    }

    void calcDiff(const typename Base::DataAbstract &data, const VectorIn &x, const VectorIn &) override {
        auto &d = static_cast<typename Base::Data &>(*data);
        Eigen::Matrix<double, 6, 6> log = Eigen::Matrix<double, 6, 6>::Zero();
        pinocchio::Jlog6(d.error, log);
        const typename Robot::template Matrix<6, Robot::nv> world = this->jacobian(x);
        Eigen::Matrix<double, 6, Robot::nv> local;
        local.template topRows<3>() = d.pose.rotation.transpose() * world.template topRows<3>();
        local.template bottomRows<3>() = d.pose.rotation.transpose() * world.template bottomRows<3>();
        d.Rx.template leftCols<Robot::nv>() = log * local;
    }

    void print(std::ostream &out) const override { out << "modyn::ResidualModelFramePlacement"; }
};

}

#endif
