
import numpy as np
from pysph.base.kernels import CubicSpline
from pysph.base.nnps import DomainManager
from pysph.solver.application import Application
from pysph.solver.solver import Solver
from pysph.sph.basic_equations import (
    ContinuityEquation,
    IsothermalEOS,
    VelocityGradient2D,
    XSPHCorrection,
)
from pysph.sph.equation import Group
from pysph.sph.integrator import PECIntegrator
from pysph.sph.integrator_step import SolidMechStep
from pysph.sph.solid_mech.basic import (
    HookesDeviatoricStressRate,
    MomentumEquationWithStress,
    MonaghanArtificialStress,
    get_particle_array_elastic_dynamics,
)


class Wave(Application):
    def create_domain(self):
        # No particle lies on the boundary, where rounding would decide its side.
        low_x, low_y = -0.25 * SPACING, -0.25 * SPACING
        return DomainManager(
            xmin=low_x, xmax=low_x + LENGTH_X, ymin=low_y, ymax=low_y + LENGTH_Y,
            periodic_in_x=True, periodic_in_y=True,
        )

    def create_particles(self):
        # The first line holds the case; column names follow in the second line.
        table = np.genfromtxt("particles.csv", delimiter=",", skip_header=1, names=True)
        solid = get_particle_array_elastic_dynamics(
            name="solid", x=table["x"], y=table["y"], u=table["vx"], v=table["vy"],
            m=table["mass"], rho=table["mass"] / table["volume"],
            h=np.full(len(table), SMOOTHING),
            constants={
                "c0_ref": SOUND, "rho_ref": DENSITY, "n": EXPONENT,
                "wdeltap": CubicSpline(dim=2).kernel(rij=SPACING, h=SMOOTHING),
            },
        )
        # The constructor computes G from E and nu.
        solid.G[0] = SHEAR
        solid.s00[:], solid.s11[:], solid.s22[:] = DEVIATOR_X, DEVIATOR_Y, DEVIATOR_Z
        solid.add_property("number", data=table["id"])
        solid.add_property("cs", data=np.full(len(table), SOUND))
        self.file = open("wave.csv", "w")
        self.file.write("# onset case %s\ntime,id,x,y\n" % CASE)
        self.write(solid, 0.0)
        return [solid]

    def create_equations(self):
        return [
            Group(equations=[
                IsothermalEOS("solid", sources=None, rho0=DENSITY, c0=SOUND, p0=PRESSURE),
                VelocityGradient2D("solid", sources=["solid"]),
                MonaghanArtificialStress("solid", sources=None, eps=ARTIFICIAL_STRESS),
            ], real=False),
            Group(equations=[
                ContinuityEquation("solid", sources=["solid"]),
                MomentumEquationWithStress("solid", sources=["solid"]),
                HookesDeviatoricStressRate("solid", sources=None),
                XSPHCorrection("solid", sources=["solid"], eps=0.0),
            ]),
        ]

    def create_solver(self):
        return Solver(
            kernel=CubicSpline(dim=2), dim=2, integrator=PECIntegrator(solid=SolidMechStep()),
            dt=TIME_STEP, tf=TIME_STEP * STEPS, pfreq=10**9, adaptive_timestep=False, fixed_h=True,
        )

    def write(self, solid, time):
        numbers, x, y = (solid.get(name, only_real_particles=True) for name in ("number", "x", "y"))
        for number, a, b in sorted(zip(numbers, x, y)):
            self.file.write("%.17g,%d,%.17g,%.17g\n" % (time, number, a, b))

    def post_step(self, solver):
        # The solver counts the step after this call.
        count = solver.count + 1
        if count % EVERY == 0:
            self.write(self.particles[0], count * TIME_STEP)

    def post_process(self, *arguments):
        self.file.close()


if __name__ == "__main__":
    wave = Wave()
    wave.run()
    wave.file.close()
