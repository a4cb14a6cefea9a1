"""The wave vectors of a map with what scales its frequencies."""

import numpy as np

from . import lattice, material


class Zone:
    """Wave vectors without k = 0; the last one is repeated to fill a multiple."""

    def __init__(self, resolution, symmetry, multiple=1):
        fractions = lattice.zone_grid(resolution, symmetry)
        padding = -len(fractions) % multiple
        self.fractions = np.concatenate([fractions, np.repeat(fractions[-1:], padding, axis=0)])
        # Factor from omega^2 to the scaled measure: 1 / (c^2 |k|_h^2).
        self.scale = 1.0 / (material.speed_squared() * lattice.laplacian(self.fractions))


def finished(zone, minimum, index, largest, fastest):
    """Columns: scaled minimum, its k_1, k_2, largest Re omega^2, largest growth rate."""
    k = lattice.wave_vectors(zone.fractions[np.nan_to_num(index).astype(np.int64)])
    k[np.isnan(minimum)] = np.nan
    return np.column_stack([minimum, k, largest, np.sqrt(np.maximum(fastest, 0.0))])
