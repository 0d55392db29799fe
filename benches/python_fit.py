"""The Python package beside PySINDy, in one run: fits, predictions, simulations, medians of repeats that take turns.

Needs both in one environment (`pip install pysindy==2.1.0` and the wheel that `maturin build --release` makes in python/).
Prints JSON, and writes it to a file if one is named. Usage: python python_fit.py [FILE]
"""
import json
import os
import platform
import statistics
import sys
import time
import warnings

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"
import numpy as np  # noqa: E402
import pysindy as ps  # noqa: E402
import sindyna  # noqa: E402
from scipy.integrate import solve_ivp  # noqa: E402

warnings.filterwarnings("ignore")

TRUE = np.zeros((3, 10))
TRUE[0, [1, 2]], TRUE[1, [1, 2, 6]], TRUE[2, [3, 5]] = (-10, 10), (28, -1, -1), (-8 / 3, 1)


def lorenz(n, dt, noise):
    t = dt * np.arange(n)
    rate = lambda s, z: [10 * (z[1] - z[0]), z[0] * (28 - z[2]) - z[1], z[0] * z[1] - 8 / 3 * z[2]]  # noqa: E731
    x = solve_ivp(rate, (0, t[-1]), [-8, 8, 27], t_eval=t, rtol=1e-10, atol=1e-10).y.T
    return t, x + noise * np.random.default_rng(0).normal(size=x.shape)


def seconds(calls, repeats, number=1):
    """Median seconds of each call; they take turns."""
    taken = [[] for _ in calls]
    for call in calls:
        call()
    for _ in range(repeats):
        for own, call in zip(taken, calls):
            begun = time.perf_counter()
            for _ in range(number):
                call()
            own.append((time.perf_counter() - begun) / number)
    return [statistics.median(own) for own in taken]


def compared(ours, theirs, repeats, number=1):
    a, b = seconds([ours, theirs], repeats, number)
    return {"sindyna_s": a, "pysindy_s": b, "ratio": b / a, "repeats": repeats}


def same(module, threshold=0.1):
    """The same regression in either module."""
    return module.SINDy(
        optimizer=module.STLSQ(threshold=threshold),
        feature_library=module.PolynomialLibrary(degree=2),
        differentiation_method=module.FiniteDifference(),
    )


report = {}
for n, repeats in ((100, 30), (5000, 20)):
    t, x = lorenz(n, 0.002, 0.0)
    report[f"STLSQ fit, Lorenz, {n} samples"] = compared(
        lambda: same(sindyna).fit(x, t=t), lambda: same(ps).fit(x, t=t), repeats
    )
    report[f"STLSQ fit, Lorenz, {n} samples, ten in a turn"] = compared(
        lambda: same(sindyna).fit(x, t=t), lambda: same(ps).fit(x, t=t), repeats // 2, 10
    )
ours, theirs = same(sindyna).fit(x, t=t), same(ps).fit(x, t=t)
report["largest difference of coefficients"] = float(np.abs(ours.coefficients() - theirs.coefficients()).max())
one = x[:1]
report["predict, one state"] = compared(lambda: ours.predict(one), lambda: theirs.predict(one), 30, 50)
many = np.tile(x, (2, 1))
report["predict, 10,000 states"] = compared(lambda: ours.predict(many), lambda: theirs.predict(many), 30)
report["simulate, 1,000 times"] = compared(lambda: ours.simulate(x[0], t[:1000]), lambda: theirs.simulate(x[0], t[:1000]), 5)

# The default of each, on noise: another job, and other answers.
t, x = lorenz(500, 0.01, 0.2)
a, b = sindyna.SINDy(), ps.SINDy()
found = compared(lambda: a.fit(x, t=t), lambda: b.fit(x, t=t), 5)
names = a.get_feature_names()
columns = [names.index(name) for name in ("x0", "x1", "x2", "x0 x1", "x0 x2")]
every, wanted = a.coefficients(), np.zeros_like(a.coefficients())
wanted[:, columns] = TRUE[:, [1, 2, 3, 5, 6]]
found["sindyna_terms_right"] = bool(np.array_equal(every != 0, wanted != 0))
found["pysindy_terms_right"] = bool(np.array_equal(b.coefficients() != 0, TRUE != 0))
found["sindyna_largest_error"] = float(np.abs(every - wanted).max())
found["pysindy_largest_error"] = float(np.abs(b.coefficients() - TRUE).max())
report["default fit, Lorenz with noise 0.2, 500 samples"] = found

result = {
    "command": "python benches/python_fit.py",
    "versions": {"python": platform.python_version(), "numpy": np.__version__, "pysindy": ps.__version__, "sindyna": sindyna.__version__},
    "results": report,
}
text = json.dumps(result, indent=1)
print(text)
if len(sys.argv) > 1:
    with open(sys.argv[1], "w", encoding="utf-8") as file:
        file.write(text + "\n")
