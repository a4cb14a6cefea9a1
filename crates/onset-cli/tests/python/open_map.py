"""Opens the store of a map as a user would, and prints its content as one JSON document.

Any warning is a failure: a store must open without one.
"""

import json
import sys
import warnings

import numpy as np
import xarray as xr

warnings.simplefilter("error")


def words(flags):
    """Meanings of CF flags for each state; None if nothing has been computed."""
    meaning = dict(zip(flags.attrs["flag_values"], flags.attrs["flag_meanings"].split()))
    return [meaning.get(int(flag)) for flag in flags.values.ravel()]


dataset = xr.open_zarr(sys.argv[1])
assert dataset.identical(xr.open_zarr(sys.argv[1], consolidated=False))
dataset.load()
verdicts = words(dataset.verdict)
nearest = dataset.sel({dimension: 1.0 for dimension in dataset.verdict.dims}, method="nearest")
vectors = {name for name, field in dataset.items() if "component" in field.dims}
computed = dataset.verdict >= 0
lengths = np.sqrt((dataset.acoustic_direction**2).sum("component")).where(computed)
print(
    json.dumps(
        {
            "dimensions": dict(dataset.sizes),
            "order": list(dataset.verdict.dims),
            "conventions": dataset.attrs["Conventions"],
            "study": dataset.attrs["study"],
            "tolerance": dataset.attrs["tolerance"],
            "units": {name: variable.attrs.get("units") for name, variable in dataset.variables.items()},
            "unnamed": [name for name, variable in dataset.variables.items() if "long_name" not in variable.attrs],
            "vectors": sorted(vectors),
            "verdicts": {word: verdicts.count(word) for word in set(verdicts) - {None}},
            "to do": verdicts.count(None),
            "undeformed": words(nearest.verdict)[0],
            "directions are unit vectors": bool(np.allclose(lengths.values[computed.values], 1.0)),
            "numbers where nothing was computed": int(np.isfinite(dataset.growth_rate.where(~computed)).sum()),
        }
    )
)
