"""The law of equation (5) in plane strain, in closed form: W = c/2 |F|^2 + g(J) up to a constant.

Arrays may be NumPy's or JAX's; `xp` is the module. The batch is the last axis.
"""

import numpy as np

C1, C2, LAMBDA = 0.1256, 0.01012, 10.12


def tangent(xp, f):
    """J, P_iJ and A_iJkL of F [2, 2, B]; nested lists of arrays [B]."""
    c = C1 + C2
    jacobian = f[0][0] * f[1][1] - f[0][1] * f[1][0]
    log = xp.log(jacobian)
    cube = xp.exp(log * (-1.0 / 3.0))
    # g = c2/2 J^2 - 3/2 c1 J^(2/3) - 3/2 c2 J^(4/3) + lambda (ln J)^2
    inverse = 1.0 / jacobian
    slope = C2 * jacobian - C1 * cube - 2.0 * C2 / cube + 2.0 * LAMBDA * log * inverse
    curvature = (
        C2 + (C1 * cube - 2.0 * C2 / cube) * inverse / 3.0 + 2.0 * LAMBDA * (1.0 - log) * inverse * inverse
    )
    cofactor = [[f[1][1], -f[1][0]], [-f[0][1], f[0][0]]]
    permutation = [[0.0, 1.0], [-1.0, 0.0]]
    two = range(2)
    piola = [[c * f[i][j] + slope * cofactor[i][j] for j in two] for i in two]
    component = lambda i, j, k, l: (
        curvature * (cofactor[i][j] * cofactor[k][l])
        + slope * (permutation[i][k] * permutation[j][l])
        + c * float(i == k and j == l)
    )
    a = [[[[component(i, j, k, l) for l in two] for k in two] for j in two] for i in two]
    return jacobian, piola, a


def speed_squared():
    """c^2: the largest acoustic eigenvalue of the material in the reference state, which is isotropic, over the density 1."""
    _, _, a = tangent(np, np.eye(2)[:, :, None])
    return max(a[0][0][0][0][0], a[0][1][0][1][0])
