"""One thread a core."""

import os
from concurrent.futures import ThreadPoolExecutor

CORES = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()


def in_threads(work, items, cores=CORES):
    """The results of `work` on the items, in their order."""
    with ThreadPoolExecutor(cores) as executor:
        return list(executor.map(work, items))
