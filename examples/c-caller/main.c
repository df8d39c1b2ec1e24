/* Calls the 7-joint arm: inverse dynamics undoes forward dynamics, the mass matrix gives the kinetic
 * energy, and an array that is too short draws a warning (-DWRONG_SIZE). */
#include <math.h>
#include <stdio.h>

#include "arm7.h"

int main(void) {
#ifdef WRONG_SIZE
    double q[ARM7_NQ - 1] = {0};
#else
    double q[ARM7_NQ] = {0.1, -0.4, 0.9, -1.7, 0.3, 1.2, -0.8};
#endif
    double qd[ARM7_NV] = {0.5, -0.2, 0.1, 0.7, -0.9, 0.4, 1.1};
    double tau[ARM7_NV] = {3, -20, 1, 15, 0.5, 1, -0.1};
    double qdd[ARM7_NV], back[ARM7_NV], mass[ARM7_NV * ARM7_NV];
    double jacobian[6 * ARM7_NV];
    double worst = 0, energy = 0;

    arm7_forward_dynamics(q, qd, tau, qdd);
    arm7_inverse_dynamics(q, qd, qdd, back);
    arm7_mass_matrix(q, mass);
    for (int i = 0; i < ARM7_NV; i++) {
        worst = fmax(worst, fabs(back[i] - tau[i]));
        for (int j = 0; j < ARM7_NV; j++) energy += 0.5 * qd[i] * mass[i * ARM7_NV + j] * qd[j];
    }
    double off = fabs(energy - arm7_kinetic_energy(q, qd));
    for (int i = 0; i < ARM7_NV; i++) printf("%.17g\n", qdd[i]);
    if (!arm7_jacobian(q, ARM7_LINK_RIGHT_FINGER, jacobian)) return 3;
    if (arm7_jacobian(q, ARM7_LINKS, jacobian)) return 4;
    fprintf(stderr, "torques differ by %g, energies by %g\n", worst, off);
    return worst < 1e-11 && off < 1e-12 ? 0 : 1;
}
