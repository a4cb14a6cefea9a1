/* A constitutive law for onset, in C or in any language that can export a C function.
 *
 * Compile a shared library that contains the function `onset_law`:
 *
 *     cc -shared -fPIC -O2 -o law.so law.c
 *
 * and use it with material.model=library, material.library=law.so.
 *
 * All calls are three-dimensional. Tensors are stored row by row: F[3*i + J] is F_iJ, with the index i of the current and the
 * index J of the reference configuration. (Fortran stores by columns: an array F(3, 3) holds the transpose.)
 * The library runs in a process of its own; each process calls the function from one thread.
 */
#ifndef ONSET_LAW_H
#define ONSET_LAW_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Computes the response at the end of an increment of deformation.
 *
 *   F_start         deformation gradient at the start of the increment; the first increment starts at the identity
 *   F               deformation gradient at the end
 *   time, dt        time at the end, and duration of the increment; the whole path lasts from 0 to 1
 *   properties      material.properties
 *   state           state variables (material.state-variables): at the start of the increment on entry, at its end on return;
 *                   zero before the first increment
 *   W               on return the energy per reference volume (may be left as it is)
 *   P               on return the first Piola-Kirchhoff stress, P[3*i + J] = dW/dF_iJ for a law with an energy
 *   A               on return its derivative, A[27*i + 9*J + 3*k + L] = dP_iJ/dF_kL. If no number of A is set, the derivative
 *                   is computed from central differences of P.
 *
 * Returns 0, or another number if there is no response: onset then stops with the last lines printed on standard error.
 */
int32_t onset_law(const double *F_start, const double *F, double time, double dt,
                  const double *properties, int32_t property_count,
                  double *state, int32_t state_count,
                  double *W, double *P, double *A);

#ifdef __cplusplus
}
#endif

#endif
