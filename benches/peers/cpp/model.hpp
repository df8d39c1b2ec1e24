// Pinocchio's model, as ../pinocchio_model.py wrote it, and its order of joints against modyn's.
#pragma once

#include <pinocchio/fwd.hpp>

#include <pinocchio/multibody.hpp>

#include <sstream>

#include "harness.hpp"

inline pinocchio::JointModel joint_of(const std::string &kind, const Eigen::Vector3d &axis) {
    using namespace pinocchio;
    if (kind == "RX") return JointModelRX();
    if (kind == "RY") return JointModelRY();
    if (kind == "RZ") return JointModelRZ();
    if (kind == "PX") return JointModelPX();
    if (kind == "PY") return JointModelPY();
    if (kind == "PZ") return JointModelPZ();
    if (kind == "RevoluteUnaligned") return JointModelRevoluteUnaligned(axis);
    if (kind == "PrismaticUnaligned") return JointModelPrismaticUnaligned(axis);
    if (kind == "FreeFlyer") return JointModelFreeFlyer();
    throw std::runtime_error("no joint " + kind);
}

inline pinocchio::Model read(const std::string &path) {
    using Eigen::Matrix3d, Eigen::Vector3d;
    pinocchio::Model model;
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::string name, kind, number;
        pinocchio::JointIndex parent;
        words >> name >> parent >> kind;
        // Not `words >> double`, which may lose the last bit.
        const auto next = [&] {
            words >> number;
            return std::stod(number);
        };
        const auto vector = [&] {
            const double x = next(), y = next(), z = next();
            return Vector3d(x, y, z);
        };
        const auto matrix = [&] {
            Matrix3d rows;
            for (int i = 0; i < 3; ++i) rows.row(i) = vector();
            return rows;
        };
        const Vector3d axis = vector();
        const Matrix3d rotation = matrix();
        const Vector3d translation = vector();
        const double mass = next();
        const Vector3d center = vector();
        const Matrix3d inertia = matrix();
        const auto joint = model.addJoint(parent, joint_of(kind, axis),
                                          pinocchio::SE3(rotation, translation), name);
        model.appendBodyToJoint(joint, pinocchio::Inertia(mass, center, inertia));
    }
    return model;
}

// The index of each of modyn's coordinates (velocities) in Pinocchio's vectors.
struct Order {
    std::vector<int> q, v;

    Order(const pinocchio::Model &model, const Joints &joints) {
        for (const std::string &name : joints.names) {
            const auto id = name == "floating_base" ? 1 : model.getJointId(name);
            for (int k = 0; k < model.nqs[id]; ++k) q.push_back(model.idx_qs[id] + k);
            for (int k = 0; k < model.nvs[id]; ++k) v.push_back(model.idx_vs[id] + k);
        }
        if (int(q.size()) != model.nq || int(v.size()) != model.nv)
            throw std::runtime_error("not the same joints");
    }
};
