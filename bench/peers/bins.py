"""States of the Eulerian map by their stretches, so that each bin has a short list of neighbors."""

import numpy as np

from . import eulerian
from .states import HIGH, LOW


class Bins:
    """`count` by `count` bins of the domain of stretches; without bins in which every state has lost its neighbors."""

    def __init__(self, count):
        self.count = count
        self.neighborhoods = {}
        # The slowest bins, with the most neighbors, come first.
        for number in range(count * count):
            smallest = LOW + (HIGH - LOW) * np.array(divmod(number, count)) / count
            if not eulerian.is_lost(smallest):
                self.neighborhoods[number] = eulerian.neighborhood(smallest)

    def map(self, work, states, batch, cores, in_threads):
        """Four columns of `work` on batches (number of the bin, stretches [2, batch]); NaN where neighbors are lost."""
        cells = np.clip(((states - LOW) / (HIGH - LOW) * self.count).astype(np.int64), 0, self.count - 1)
        numbers = cells @ np.array([self.count, 1])
        order = np.argsort(numbers, kind="stable")
        edges = np.searchsorted(numbers[order], np.arange(self.count**2 + 1))
        items, members = [], []
        for number in self.neighborhoods:
            inside = order[edges[number] : edges[number + 1]]
            for start in range(0, len(inside), batch):
                own = inside[start : start + batch]
                filled = np.concatenate([own, np.repeat(own[-1:], batch - len(own))])
                items.append((number, np.ascontiguousarray(states[filled].T)))
                members.append(own)
        columns = np.full((4, len(states)), np.nan)
        for own, part in zip(members, in_threads(work, items, cores)):
            for column, values in zip(columns, part):
                column[own] = values[: len(own)]
        return columns
