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

// The words of a line.
struct Words {
    std::istringstream words;

    std::string word() {
        std::string word;
        words >> word;
        return word;
    }
    // Not `words >> double`, which may lose the last bit.
    double number() { return std::stod(word()); }
    Eigen::Vector3d vector() {
        const double x = number(), y = number(), z = number();
        return Eigen::Vector3d(x, y, z);
    }
    Eigen::Matrix3d matrix() {
        Eigen::Matrix3d rows;
        for (int i = 0; i < 3; ++i) rows.row(i) = vector();
        return rows;
    }
};

// A contact: whether it is a surface, the joint that carries it, and its place on the joint.
struct Contact {
    bool surface;
    pinocchio::JointIndex joint;
    pinocchio::SE3 placement;
};

inline std::vector<Contact> read_contacts(const std::string &path) {
    std::vector<Contact> contacts;
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        Words words{std::istringstream(line)};
        if (words.word() != "contact") continue;
        const bool surface = words.word() == "surface";
        const pinocchio::JointIndex joint = std::stoul(words.word());
        const Eigen::Matrix3d rotation = words.matrix();
        contacts.push_back({surface, joint, pinocchio::SE3(rotation, words.vector())});
    }
    return contacts;
}

inline pinocchio::Model read(const std::string &path) {
    using Eigen::Matrix3d, Eigen::Vector3d;
    pinocchio::Model model;
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        Words words{std::istringstream(line)};
        const std::string name = words.word();
        if (name == "contact") continue;
        const pinocchio::JointIndex parent = std::stoul(words.word());
        const std::string kind = words.word();
        const Vector3d axis = words.vector();
        const Matrix3d rotation = words.matrix();
        const Vector3d translation = words.vector();
        const double mass = words.number();
        const Vector3d center = words.vector();
        const Matrix3d inertia = words.matrix();
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
