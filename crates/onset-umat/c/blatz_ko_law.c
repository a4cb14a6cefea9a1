/* The law of Blatz and Ko for a foamed rubber, W = mu/2 (I2/J^2 + 2 J - 5), with the interface of onset_law.h:
 *
 *   P = mu (J F^-T - F^-T C^-1),   C = F^T F
 *
 * properties[0] = mu, in units of stress. No state variables.
 *
 *     onset law-header > onset_law.h
 *     cc -shared -fPIC -O2 -I. -o blatz_ko_law.so blatz_ko_law.c
 */
#include "onset_law.h"
#include <stdio.h>

int32_t onset_law(const double *F_start, const double *F, double time, double dt, const double *properties,
                  int32_t property_count, double *state, int32_t state_count, double *W, double *P, double *A)
{
    (void)F_start, (void)time, (void)dt, (void)state, (void)state_count;
    if (property_count != 1) {
        fprintf(stderr, "expected one property, the shear modulus\n");
        return 1;
    }
    const double mu = properties[0];
    double G[9], D[9]; /* F^-1 and C^-1 = F^-1 F^-T */
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) {
            const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            G[3 * c + r] = F[3 * r1 + c1] * F[3 * r2 + c2] - F[3 * r1 + c2] * F[3 * r2 + c1];
        }
    const double J = F[0] * G[0] + F[1] * G[3] + F[2] * G[6];
    for (int n = 0; n < 9; n++)
        G[n] /= J;
    for (int I = 0; I < 3; I++)
        for (int K = 0; K < 3; K++) {
            D[3 * I + K] = 0;
            for (int k = 0; k < 3; k++)
                D[3 * I + K] += G[3 * I + k] * G[3 * K + k];
        }
    /* H_iJ = (F^-T C^-1)_iJ = G_Ki D_KJ */
    double H[9];
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            H[3 * i + k] = 0;
            for (int K = 0; K < 3; K++)
                H[3 * i + k] += G[3 * K + i] * D[3 * K + k];
        }
    *W = 0.5 * mu * (D[0] + D[4] + D[8] + 2 * J - 5);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            P[3 * i + k] = mu * (J * G[3 * k + i] - H[3 * i + k]);
    /* dG_Ji = -G_Jk dF_kL G_Li, and E_ik = (F^-T F^-1)_ik = G_Mi G_Mk */
    double E[9];
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            E[3 * i + k] = 0;
            for (int M = 0; M < 3; M++)
                E[3 * i + k] += G[3 * M + i] * G[3 * M + k];
        }
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            for (int I = 0; I < 3; I++)
                for (int K = 0; K < 3; K++)
                    A[27 * i + 9 * I + 3 * k + K] =
                        mu * (J * (G[3 * K + k] * G[3 * I + i] - G[3 * I + k] * G[3 * K + i]) + G[3 * K + i] * H[3 * k + I] +
                              E[3 * i + k] * D[3 * K + I] + H[3 * i + K] * G[3 * I + k]);
    return 0;
}
