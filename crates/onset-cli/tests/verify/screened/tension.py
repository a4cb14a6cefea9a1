"""A square of PySPH whose rim moves as x = (1 + rate t) X.

Arguments: file, rate, time step, duration, artificial stress, artificial viscosity.
"""

import sys

import numpy as np

FILE = sys.argv[1]
RATE, STEP, DURATION, STRESS, VISCOSITY = map(float, sys.argv[2:])
# PySPH reads the arguments of the program.
sys.argv = sys.argv[:1]

from pysph.base.kernels import CubicSpline  # noqa: E402
from pysph.solver.application import Application  # noqa: E402
from pysph.solver.solver import Solver  # noqa: E402
from pysph.sph.basic_equations import (  # noqa: E402
    ContinuityEquation,
    IsothermalEOS,
    MonaghanArtificialViscosity,
    VelocityGradient2D,
)
from pysph.sph.equation import Equation, Group  # noqa: E402
from pysph.sph.integrator import PECIntegrator  # noqa: E402
from pysph.sph.integrator_step import SolidMechStep  # noqa: E402
from pysph.sph.solid_mech.basic import (  # noqa: E402
    HookesDeviatoricStressRate,
    MomentumEquationWithStress,
    MonaghanArtificialStress,
    get_particle_array_elastic_dynamics,
)

SIDE, FRAMES = 20, 40
YOUNG, POISSON = 1.0, 0.3
SHEAR = YOUNG / 2 / (1 + POISSON)
SOUND = (YOUNG / 3 / (1 - 2 * POISSON)) ** 0.5


class Hold(Equation):
    """Particles of the rim keep their velocities, and no velocity is smoothed."""

    def loop(self, d_idx, d_au, d_av, d_held):
        pass

    def post_loop(self, d_idx, d_au, d_av, d_held, d_ax, d_ay, d_u, d_v):
        if d_held[d_idx] > 0.5:
            d_au[d_idx] = 0.0
            d_av[d_idx] = 0.0
        d_ax[d_idx] = d_u[d_idx]
        d_ay[d_idx] = d_v[d_idx]


X = np.stack(np.meshgrid(np.arange(SIDE), np.arange(SIDE), indexing="ij"), -1).reshape(-1, 2).astype(float)
HELD = (X.min(1) < 2.5) | (X.max(1) > SIDE - 3.5)
NOISE = np.random.default_rng(1).normal(0, 1e-5, X.shape)
V = RATE * (X - (SIDE - 1) / 2) + ~HELD[:, None] * NOISE


class Square(Application):
    def create_particles(self):
        ones = np.ones(len(X))
        constants = {"c0_ref": SOUND, "rho_ref": 1.0, "G": SHEAR, "n": 4.0, "wdeltap": CubicSpline(dim=2).kernel(rij=1.0, h=1.3)}
        square = get_particle_array_elastic_dynamics(
            name="square", x=X[:, 0], y=X[:, 1], m=ones, rho=ones, h=1.3 * ones, u=V[:, 0], v=V[:, 1], constants=constants
        )
        square.add_property("held", data=HELD.astype(float))
        square.add_property("number", data=np.arange(len(X)).astype(float))
        square.add_property("cs", data=SOUND * ones)
        return [square]

    def create_equations(self):
        own, pairs = {"dest": "square", "sources": None}, {"dest": "square", "sources": ["square"]}
        return [
            Group([IsothermalEOS(**own, rho0=1.0, c0=SOUND, p0=0.0), VelocityGradient2D(**pairs), MonaghanArtificialStress(**own, eps=STRESS)]),
            Group(
                [
                    ContinuityEquation(**pairs),
                    MomentumEquationWithStress(**pairs),
                    HookesDeviatoricStressRate(**own),
                    MonaghanArtificialViscosity(**pairs, alpha=VISCOSITY, beta=0.0),
                ]
            ),
            Group([Hold(**pairs)]),
        ]

    def create_solver(self):
        integrator = PECIntegrator(square=SolidMechStep())
        return Solver(
            kernel=CubicSpline(dim=2), dim=2, integrator=integrator, dt=STEP, tf=DURATION, pfreq=10**9, adaptive_timestep=False, fixed_h=True
        )

    def post_step(self, solver):
        if solver.count % round(DURATION / STEP / FRAMES) == 0:
            square = self.particles[0]
            order = np.argsort(square.number)
            of = {name: np.array(square.get(name))[order] for name in ("x", "y", "u", "v", "s00", "s11", "s01", "p")}
            frames.append(
                (
                    solver.t,
                    np.stack([of["x"], of["y"], 0 * of["x"]], 1),
                    np.stack([of["u"], of["v"], 0 * of["u"]], 1),
                    np.stack([of["s00"] - of["p"], of["s11"] - of["p"], of["s01"]], 1),
                )
            )


frames = []
Square(fname="square").run(["--disable-output"])
time, position, velocity, stress = (np.array(each) for each in zip(*frames))
reference = np.c_[X, 0 * X[:, 0]]
np.savez(FILE, time=time, reference=reference, position=position, velocity=velocity, stress=stress, held=HELD.astype(float))
