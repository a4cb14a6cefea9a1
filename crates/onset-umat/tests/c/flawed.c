/* The law of Blatz and Ko without its tangent, with a flaw: properties[1]. */
#include "../../include/onset_law.h"
#include <math.h>
#include <stdio.h>

int32_t onset_law(const double *F_start, const double *F, double time, double dt, const double *properties,
                  int32_t property_count, double *state, int32_t state_count, double *W, double *P, double *A)
{
    (void)F_start, (void)property_count, (void)state_count, (void)W;
    const int flaw = (int)properties[1];
    double G[9], piola[9];
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) {
            const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            G[3 * c + r] = F[3 * r1 + c1] * F[3 * r2 + c2] - F[3 * r1 + c2] * F[3 * r2 + c1];
        }
    const double J = F[0] * G[0] + F[1] * G[3] + F[2] * G[6];
    for (int n = 0; n < 9; n++)
        G[n] /= J;
    for (int i = 0; i < 3; i++)
        for (int I = 0; I < 3; I++) {
            piola[3 * i + I] = J * G[3 * I + i];
            for (int K = 0; K < 3; K++)
                for (int k = 0; k < 3; k++)
                    piola[3 * i + I] -= G[3 * K + i] * G[3 * K + k] * G[3 * I + k];
        }
    for (int i = 0; i < 3; i++)
        for (int I = 0; I < 3; I++)
            P[3 * i + I] = properties[0] * (flaw == 1 ? piola[3 * I + i] : piola[3 * i + I]);
    if (flaw == 2) { /* a tangent whose indices are in the wrong order */
        for (int n = 0; n < 81; n++)
            A[n] = 0;
        for (int i = 0; i < 3; i++)
            for (int I = 0; I < 3; I++)
                A[27 * i + 9 * i + 3 * I + I] = 1 + F[1];
    }
    if (flaw == 3) {
        fprintf(stderr, "no response at F_11 = %g\n", F[0]);
        return 300;
    }
    if (flaw == 4)
        state[0] = time, state[1] = dt;
    if (flaw == 5)
        P[4] = NAN;
    if (flaw == 6)
        state[0] += F[0] - F_start[0];
    if (flaw == 7) /* rounding of an iterative law */
        P[1] += 1e-8 * properties[0];
    if (flaw == 8)
        A[0] = 1;
    return 0;
}
