"""Audit of the elastic laws of felupe and matADi: `python validation/laws.py`, with onset, felupe and matadi installed.

Prints the table `validation/laws.md`: each law with its parameters, the outcome of `onset.audit`, and the largest error of its tangent. Laws with state variables are omitted, because they are not functions of the deformation gradient.
"""

import argparse
from importlib.metadata import version
from pathlib import Path

import felupe
import matadi
import onset
from felupe.constitution.tensortrax.models import hyperelastic
from matadi import models

BULK = 5.0
AXES = {"r1": [1.0, 0.0, 0.0], "r2": [0.0, 1.0, 0.0], "r3": [0.0, 0.0, 1.0]}
ORTHOTROPIC = {"mu": [1.0, 1.1, 1.2], "lmbda": [2.0, 2.1, 2.2, 0.9, 1.0, 1.1], **AXES}

# Isochoric energies of both packages, with a volumetric part; constants of a rubber.
ISOCHORIC = {
    "neo_hooke": {"mu": 1.0},
    "mooney_rivlin": {"C10": 0.4, "C01": 0.1},
    "yeoh": {"C10": 0.5, "C20": -0.05, "C30": 0.02},
    "third_order_deformation": {"C10": 0.4, "C01": 0.1, "C11": 0.02, "C20": -0.05, "C30": 0.01},
    "ogden": {"mu": [1.0, 0.2], "alpha": [1.7, -1.5]},
    "arruda_boyce": {"C1": 1.0, "limit": 3.2},
    "extended_tube": {"Gc": 0.2, "Ge": 0.2, "beta": 0.2, "delta": 0.1},
    "van_der_waals": {"mu": 1.0, "limit": 5.0, "a": 0.3, "beta": 0.5},
    "miehe_goektepe_lulei": {"mu": 0.3, "N": 25.0, "U": 9.9, "p": 1.5, "q": 0.6},
    "alexander": {"C1": 0.3, "C2": 0.1, "C3": 0.05, "gamma": 1.5, "k": 0.01},
    "anssari_benam_bucchi": {"mu": 0.3, "N": 22.0},
    "lopez_pamies": {"mu": [0.3, 0.1], "alpha": [1.0, 4.0]},
}
# Energies of felupe with a volumetric part of their own.
COMPRESSIBLE = {
    "blatz_ko": {"mu": 1.0},
    "storakers": {"mu": [1.0, 0.2], "alpha": [2.0, -2.0], "beta": [0.5, 0.5]},
    "saint_venant_kirchhoff": {"mu": 1.0, "lmbda": 2.0},
    "saint_venant_kirchhoff_orthotropic": ORTHOTROPIC,
}
# Laws of felupe with a stress in closed form.
CLASSES = {
    "NeoHooke": {"mu": 1.0, "bulk": BULK},
    "NeoHookeCompressible": {"mu": 1.0, "lmbda": 2.0},
    "LinearElastic": {"E": 1.0, "nu": 0.3},
    "LinearElasticLargeStrain": {"E": 1.0, "nu": 0.3},
    "LinearElasticOrthotropic": {"E": [1.0, 1.1, 1.2], "nu": [0.3, 0.2, 0.25], "G": [0.4, 0.5, 0.6]},
    "LinearElasticTensorNotation": {"E": 1.0, "nu": 0.3},
    "Volumetric": {"bulk": BULK},
}
# Energies of matADi with other arguments than those of felupe.
OF_MATADI = {
    **{name: ISOCHORIC[name] for name in ISOCHORIC if hasattr(models, name)},
    "neo_hooke": {"C10": 0.5},
    "saint_venant_kirchhoff": {"mu": 1.0, "lmbda": 2.0},
    "linear_elastic": {"mu": 1.0, "lmbda": 2.0},
    "fiber": {"E": 1.0, "angle": 30.0},
    "fiber_family": {"E": 1.0, "angle": 30.0},
    "holzapfel_gasser_ogden": {"c": 0.4, "k1": 1.0, "k2": 0.8, "kappa": 0.1, "angle": 40.0},
}
WITH_VOLUME = {"saint_venant_kirchhoff", "linear_elastic"}


def laws():
    """Package, name, parameters and object of each law."""
    volume = felupe.Volumetric(bulk=BULK)
    for name, parameters in ISOCHORIC.items():
        law = felupe.Hyperelastic(getattr(hyperelastic, name), **parameters)
        yield "felupe", name, {**parameters, "bulk": BULK}, law & volume
    for name, parameters in COMPRESSIBLE.items():
        yield "felupe", name, parameters, felupe.Hyperelastic(getattr(hyperelastic, name), **parameters)
    for name, parameters in CLASSES.items():
        yield "felupe", name, parameters, getattr(felupe.constitution, name)(**parameters)
    for name, parameters in OF_MATADI.items():
        if name in WITH_VOLUME:
            yield "matadi", name, parameters, matadi.MaterialHyperelastic(getattr(models, name), **parameters)
        else:
            law = matadi.MaterialHyperelastic(with_volume(getattr(models, name)), bulk=BULK, **parameters)
            yield "matadi", name, {**parameters, "bulk": BULK}, law


def with_volume(energy):
    """Energy of matADi with its volumetric energy."""
    return lambda F, bulk, **parameters: energy(F, **parameters) + models.volumetric(matadi.math.det(F), bulk)


def row(package, name, parameters, law):
    """Line of the table, and whether the law is consistent."""
    told = ", ".join(f"{key} {value}" for key, value in parameters.items())
    try:
        audit = onset.audit(onset.Material(law))
    except onset.OnsetError:
        return f"| {package} | `{name}` | {told} | failed: not finite at or near the reference state | |", False
    failed = [check["name"] for check in audit.checks if check["outcome"] == "failed"]
    outcome = "consistent" if audit.consistent else "failed: " + ", ".join(failed)
    return f"| {package} | `{name}` | {told} | {outcome} | {audit.tangent['expected_error']:.1e} |", audit.consistent


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--out", help="file of the table; printed without it")
    asked = parser.parse_args()
    rows = [row(*law) for law in laws()]
    consistent = sum(own for _, own in rows)
    text = [
        "# Elastic laws of felupe and matADi",
        "",
        "Written by `python validation/laws.py --out validation/laws.md`; do not edit.",
        "",
        f"`onset.audit` of {len(rows)} laws of felupe {version('felupe')} and matADi {version('matadi')}, at 38 states with strains of 0.1: objectivity, stress against "
        "energy, continuity, closed loops, symmetries, and the tangent against differences of the stress. Isochoric laws have a volumetric part.",
        "",
        "A failed check has a reason in each case. Laws of small strains are not objective. Eigenvalues of matADi are perturbed, so that a small stress "
        "remains in the reference state. Fibers alone have no stiffness across them.",
        "",
        f"Consistent: {consistent} of {len(rows)}.",
        "",
        "| package | law | parameters | audit | error of the tangent |",
        "|---|---|---|---|---:|",
        *(line for line, _ in rows),
    ]
    if asked.out:
        Path(asked.out).write_text("\n".join(text) + "\n")
    else:
        print("\n".join(text))


if __name__ == "__main__":
    main()
