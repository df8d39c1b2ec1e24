// MuJoCo's smooth dynamics: FOLDER ROBOT QUANTITY REPETITIONS MODEL forward|pieces. `forward` calls mj_forward;
// `pieces` calls only the functions that accelerations need.
#include <mujoco/mujoco.h>

#include "harness.hpp"

namespace {

// A state in MuJoCo's order. For a floating base: q has the quaternion as w x y z, linear velocities are in world axes,
// angular velocities in the base's axes.
struct Turned {
    Numbers q, qd, tau, qdd;
};

struct Robot {
    const mjModel *model;
    bool floating;
    // The index of each of modyn's coordinates (velocities).
    std::vector<int> q, v;

    Robot(const mjModel *model, const Joints &joints) : model(model), floating(joints.floating()) {
        for (const std::string &name : joints.names) {
            const bool base = name == "floating_base";
            const int id = base ? 0 : mj_name2id(model, mjOBJ_JOINT, name.c_str());
            if (id < 0) throw std::runtime_error("no joint " + name);
            for (int k = 0; k < (base ? 7 : 1); ++k) q.push_back(model->jnt_qposadr[id] + k);
            for (int k = 0; k < (base ? 6 : 1); ++k) v.push_back(model->jnt_dofadr[id] + k);
        }
        if (floating) std::rotate(&q[3], &q[4], &q[7]);
    }

    static Numbers placed(const Numbers &x, const std::vector<int> &order) {
        Numbers out(x.size());
        for (std::size_t k = 0; k < x.size(); ++k) out[order[k]] = x[k];
        return out;
    }

    // Rotates from the base's axes to the world's, or back.
    static void turn(const Numbers &q, double *x, bool back) {
        double quaternion[4], out[3];
        mju_copy4(quaternion, &q[3]);
        if (back) mju_negQuat(quaternion, quaternion);
        mju_rotVecQuat(out, x, quaternion);
        mju_copy3(x, out);
    }

    // The difference between the classical and the spatial acceleration, in the base's axes.
    static void add_cross(const Numbers &own_qd, double *x, double sign) {
        double cross[3];
        mju_cross(cross, &own_qd[3], &own_qd[0]);
        mju_addToScl3(x, cross, sign);
    }

    Turned turned(const State &state) const {
        Numbers qdd = state.qdd;
        if (floating) add_cross(state.qd, qdd.data(), 1);
        Turned out{placed(state.q, q), placed(state.qd, v), placed(state.tau, v), placed(qdd, v)};
        if (floating)
            for (Numbers *x : {&out.qd, &out.tau, &out.qdd}) turn(out.q, x->data(), false);
        return out;
    }

    Numbers back(const double *x) const {
        Numbers out;
        for (int k : v) out.push_back(x[k]);
        return out;
    }
};

} // namespace

int main(int count, char **arguments) {
    const Job job(count, arguments);
    const std::string how = job.argument(count, arguments, 6);
    const mjModel *model = mj_loadModel(arguments[5], nullptr);
    mjData *data = mj_makeData(model);
    const Robot robot(model, job.joints);
    std::vector<Turned> states;
    for (const State &state : job.states) states.push_back(robot.turned(state));
    const int n = model->nv;
    Numbers result(n);

    const auto position = [&](std::size_t i) {
        mju_copy(data->qpos, states[i].q.data(), model->nq);
        mj_kinematics(model, data);
        mj_comPos(model, data);
    };
    const auto velocity = [&](std::size_t i) {
        mju_copy(data->qvel, states[i].qd.data(), n);
        mj_comVel(model, data);
    };
    // Converts forces or accelerations of a floating base from world axes.
    const auto own = [&](std::size_t i, bool acceleration) {
        if (robot.floating) Robot::turn(states[i].q, result.data(), true);
        Numbers out = robot.back(result.data());
        if (robot.floating && acceleration) Robot::add_cross(job.states[i].qd, out.data(), -1);
        return out;
    };

    if (job.quantity == "forward_dynamics") {
        const auto whole = [&](std::size_t i) {
            mju_copy(data->qpos, states[i].q.data(), model->nq);
            mju_copy(data->qvel, states[i].qd.data(), n);
            mju_copy(data->qfrc_applied, states[i].tau.data(), n);
            mj_forward(model, data);
            mju_copy(result.data(), data->qacc, n);
        };
        const auto pieces = [&](std::size_t i) {
            position(i);
            mj_makeM(model, data);
            mj_factorM(model, data);
            velocity(i);
            mj_rne(model, data, 0, data->qfrc_bias);
            mju_sub(data->qfrc_smooth, states[i].tau.data(), data->qfrc_bias, n);
            mj_solveM(model, data, result.data(), data->qfrc_smooth, 1);
        };
        const auto out = [&](std::size_t i) { return own(i, true); };
        how == "forward" ? run(job, whole, out) : run(job, pieces, out);
    } else if (job.quantity == "inverse_dynamics") {
        run(
            job,
            [&](std::size_t i) {
                position(i);
                velocity(i);
                mju_copy(data->qacc, states[i].qdd.data(), n);
                mj_rne(model, data, 1, result.data());
            },
            [&](std::size_t i) { return own(i, false); });
    } else if (job.quantity == "mass_matrix") {
        // As a sparse lower triangle.
        run(
            job,
            [&](std::size_t i) {
                position(i);
                mj_makeM(model, data);
            },
            [&](std::size_t i) {
                // Columns of the full matrix: in world axes, so the rows and columns of a floating base are rotated.
                Numbers out;
                for (int k = 0; k < n; ++k) {
                    Numbers unit(n);
                    unit[k] = 1;
                    unit = Robot::placed(unit, robot.v);
                    if (robot.floating) Robot::turn(states[i].q, unit.data(), false);
                    mj_mulM(model, data, result.data(), unit.data());
                    const Numbers column = own(i, false);
                    out.insert(out.end(), column.begin(), column.end());
                }
                return out;
            });
    } else
        throw std::runtime_error("no quantity " + job.quantity);
}
