// The harness around a C function that CasADi generated: FOLDER ROBOT QUANTITY REPETITIONS.
#include "harness.hpp"

extern "C" {
using casadi_int = long long int;
int function(const double **in, double **out, casadi_int *iw, double *w, int memory);
int function_work(casadi_int *in, casadi_int *out, casadi_int *iw, casadi_int *w);
}

int main(int count, char **arguments) {
    const Job job(count, arguments);
    casadi_int ins, outs, integers, doubles;
    function_work(&ins, &outs, &integers, &doubles);
    std::vector<casadi_int> iw(integers + 1);
    Numbers w(doubles + 1);
    const std::size_t n = job.joints.nv, size = job.reference.size() / CHECKED;
    Numbers results(size);
    const bool derivatives = job.quantity == "forward_dynamics_derivatives";
    const bool inverse = job.quantity == "inverse_dynamics";
    run(
        job,
        [&](std::size_t i) {
            const State &state = job.states[i];
            const double *in[16] = {state.q.data(), state.qd.data(),
                                    (inverse ? state.qdd : state.tau).data()};
            double *out[16] = {results.data()};
            if (derivatives)
                for (int k = 0; k < 3; ++k) out[k + 1] = results.data() + n + k * n * n;
            function(in, out, iw.data(), w.data(), 0);
        },
        [&](std::size_t) { return results; });
}
