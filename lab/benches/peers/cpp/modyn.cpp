// The harness around a C function of modyn's: FOLDER ROBOT QUANTITY REPETITIONS. FUNCTION is its name, and OF_Q is
// defined if its only argument is q.
#include "harness.hpp"

#ifdef OF_Q
extern "C" void FUNCTION(const double *, double *);
static void call(const State &state, const Numbers &, Numbers &out) { FUNCTION(state.q.data(), out.data()); }
#else
extern "C" void FUNCTION(const double *, const double *, const double *, double *);
static void call(const State &state, const Numbers &last, Numbers &out) {
    FUNCTION(state.q.data(), state.qd.data(), last.data(), out.data());
}
#endif

int main(int count, char **arguments) {
    const Job job(count, arguments);
    const bool inverse = job.quantity == "inverse_dynamics";
    Numbers results(job.reference.size() / CHECKED);
    run(
        job,
        [&](std::size_t i) { call(job.states[i], inverse ? job.states[i].qdd : job.states[i].tau, results); },
        [&](std::size_t) { return results; });
}
