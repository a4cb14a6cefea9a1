"""Is this instability physical or numerical?

``onset`` takes a material and a particle method (SPH, total-Lagrangian SPH, RKPM, peridynamics, MPM and their relatives) and gives the answer for every
state of deformation, with the evidence. The commands of ``onset`` are functions here::

    import onset
    sph = onset.Method("updated-sph", lattice="square", kernel="cubic-spline", support=2.6)
    rubber = onset.Material("neo-hooke", mu=0.4, lambda_=2.0)
    answer = onset.state(rubber, sph, stretch=(1.1, 1.0))
    print(answer.verdict, answer.growth_rate, answer.wave_vector)

Answers have named attributes; ``print`` prints the text of the command, and ``plot()`` draws them. Settings are keyword arguments with the names of the keys
of study files. Errors are ``onset.OnsetError`` with the text and the hint of the command.
"""

from ._answers import (
    Answer,
    Audit,
    Bands,
    Boundary,
    Card,
    Comparison,
    Criteria,
    Dispersion,
    Fit,
    Limit,
    Localization,
    Mapped,
    Modes,
    Path,
    Recommendation,
    Record,
    Report,
    Screening,
    Simulation,
    State,
    Tuning,
    Verdicts,
    Waves,
    Zoo,
)
from ._ask import (
    audit,
    bands,
    boundary,
    card,
    compare,
    criteria,
    dispersion,
    dynamical_matrix,
    fit,
    keys,
    limit,
    localize,
    map,
    map_into,
    models,
    modes,
    omega_squared,
    open_map,
    path,
    recommend,
    screen,
    simulate,
    state,
    tune,
    verdicts,
    waves,
    zoo,
)
from ._errors import InputError, MachineError, OnsetError, SettingError
from ._exports import Mode
from ._onset import version as _version
from ._settings import Material, Method, Study

__version__ = _version()

__all__ = [
    "Answer",
    "Audit",
    "Bands",
    "Boundary",
    "Card",
    "Comparison",
    "Criteria",
    "Dispersion",
    "Fit",
    "InputError",
    "Limit",
    "Localization",
    "MachineError",
    "Mapped",
    "Material",
    "Method",
    "Mode",
    "Modes",
    "OnsetError",
    "Path",
    "Recommendation",
    "Record",
    "Report",
    "Screening",
    "SettingError",
    "Simulation",
    "State",
    "Study",
    "Tuning",
    "Verdicts",
    "Waves",
    "Zoo",
    "audit",
    "bands",
    "boundary",
    "card",
    "compare",
    "criteria",
    "dispersion",
    "dynamical_matrix",
    "fit",
    "keys",
    "limit",
    "localize",
    "map",
    "map_into",
    "models",
    "modes",
    "omega_squared",
    "open_map",
    "path",
    "recommend",
    "screen",
    "simulate",
    "state",
    "tune",
    "verdicts",
    "waves",
    "zoo",
]
