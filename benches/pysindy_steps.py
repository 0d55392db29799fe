"""Nanoseconds of PySINDy's predict for the pipeline's model of a task: of one state, and of each of 10,000 at once.

Prints one JSON line. Usage: python pysindy_steps.py TASK
"""
import json
import os
import statistics
import sys
import time
import warnings

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"
import gymnasium  # noqa: E402
import numpy as np  # noqa: E402
import pysindy as ps  # noqa: E402
from pipeline import POLYNOMIAL, TASKS, collect  # noqa: E402

warnings.filterwarnings("ignore")
task = sys.argv[1]
x, u, y = collect(task, gymnasium.make(TASKS[task]["env"]), 200, 0)
if task in POLYNOMIAL:
    library = ps.PolynomialLibrary(3)
else:
    library = ps.PolynomialLibrary(2, include_interaction=False) + ps.FourierLibrary(n_frequencies=3)
model = ps.DiscreteSINDy(feature_library=library, optimizer=ps.STLSQ(threshold=0.0009, alpha=1e-8))
model.fit(x, t=1, u=u, x_next=y)


def median_ns(rows, repeats):
    states, inputs = np.resize(x, (rows, x.shape[1])), np.resize(u, (rows, u.shape[1]))
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        model.predict(states, u=inputs)
        times.append((time.perf_counter() - start) * 1e9 / rows)
    return statistics.median(times)


print(json.dumps(dict(one_ns=median_ns(1, 200), many_ns=median_ns(10_000, 10))))
