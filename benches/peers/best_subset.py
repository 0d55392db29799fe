"""Best subset against abess and STLSQ on designs drawn here."""

import json
import os
import statistics
import subprocess
import tempfile
import time

from .shared import ONE_THREAD, build, write

# NumPy reads this when it is imported.
os.environ |= ONE_THREAD

import numpy as np
from abess import LinearRegression

DATA_SETS = 10
REPEATS = 3

# name, rows, columns, true terms, correlation of neighbours, signal to noise
DESIGNS = [
    ("Gaussian, SNR 10", 200, 100, 10, 0.0, 10.0),
    ("Gaussian, SNR 1", 200, 100, 10, 0.0, 1.0),
    ("0.5-correlated, SNR 10", 200, 100, 10, 0.5, 10.0),
    ("0.5-correlated, SNR 2", 200, 100, 10, 0.5, 2.0),
    ("0.9-correlated, SNR 10", 200, 50, 8, 0.9, 10.0),
    ("fewer rows, SNR 10", 40, 100, 4, 0.0, 10.0),
    ("fewer rows, 0.9-correlated", 40, 100, 4, 0.9, 10.0),
    ("Lorenz, degree 5, noise 1 %", 500, 56, 3, None, 100.0),
    ("Lorenz, degree 5, noise 10 %", 500, 56, 3, None, 10.0),
]


def design(seed, n, p, k, rho, snr):
    """Columns with correlation rho^|i - j|, coefficients ±(0.5..1.5) on k columns drawn at random."""
    rng = np.random.default_rng(seed)
    x = rng.standard_normal((n, p))
    for j in range(1, p):
        x[:, j] = rho * x[:, j - 1] + np.sqrt(1 - rho**2) * x[:, j]
    truth = sorted(rng.choice(p, k, replace=False).tolist())
    beta = np.zeros(p)
    beta[truth] = rng.uniform(0.5, 1.5, k) * rng.choice([-1, 1], k)
    signal = x @ beta
    y = signal + rng.standard_normal(n) * signal.std() / np.sqrt(snr)
    return x, y, truth


def lorenz(seed, n, ratio):
    """All monomials of the Lorenz system's states up to degree 5; the target is ẏ = 28 x − x z − y with noise."""
    rng = np.random.default_rng(seed)

    def rate(s):
        return np.array([10 * (s[1] - s[0]), s[0] * (28 - s[2]) - s[1], s[0] * s[1] - 8 / 3 * s[2]])

    state = np.array([-8.0, 7.0, 27.0]) + rng.standard_normal(3)
    states = []
    for _ in range(n):
        states.append(state)
        a = rate(state)
        b = rate(state + 0.01 * a)
        c = rate(state + 0.01 * b)
        d = rate(state + 0.02 * c)
        state = state + 0.02 / 6 * (a + 2 * b + 2 * c + d)
    states = np.array(states)
    powers = [(i, j, k) for i in range(6) for j in range(6 - i) for k in range(6 - i - j)]
    x = np.stack([np.prod(states ** np.array(power), axis=1) for power in powers], axis=1)
    target = np.array([rate(s)[1] for s in states])
    y = target + target.std() / ratio * rng.standard_normal(n)
    return x, y, sorted(powers.index(t) for t in [(1, 0, 0), (1, 0, 1), (0, 1, 0)])


def median_time(run):
    """The last result of some runs and the median of their times [s]."""
    seconds = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        result = run()
        seconds.append(time.perf_counter() - start)
    return result, statistics.median(seconds)


def run_abess(x, y, k):
    """Support of size k, the times of the path 0..k and of the one size."""
    def fit(sizes):
        model = LinearRegression(support_size=sizes, fit_intercept=False, ic_type="ebic", thread=1)
        model.fit(x, y)
        return sorted(np.flatnonzero(model.coef_).tolist())

    _, path_seconds = median_time(lambda: fit(list(range(k + 1))))
    support, seconds = median_time(lambda: fit([k]))
    return support, path_seconds, seconds


def run_example(tasks):
    """What our solver finds for the tasks, and what its proofs cost."""
    program = build("-p", "sindyna-sindy", "--example", "best_subset_cost") / "examples" / "best_subset_cost"
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump(tasks, file)
        file.flush()
        found = json.loads(subprocess.check_output([program, file.name]))
    costs = json.loads(subprocess.check_output([program]))
    return found, costs


def best_subset():
    """How often best subset, abess and STLSQ find the true terms, and in what time.

    Draws the designs, gives the same rows to abess (Zhu et al. 2020, PNAS 117(52)) and to the example `best_subset_cost`, and writes
    results/best-subset.json. Each solver is told the true number of terms k; STLSQ gets every threshold of two sweeps, on the columns as
    they are and scaled to unit length, and counts as right if any of them is. Times are medians of repeats in the same run, one thread
    each: best subset is the whole path of sizes 0..k with its proofs, abess its path of sizes 0..k, STLSQ the sum over the sweep. About
    two minutes.
    """
    tasks, truths, abess_found = [], [], []
    for _, n, p, k, rho, snr in DESIGNS:
        for seed in range(DATA_SETS):
            x, y, truth = lorenz(seed, n, snr) if rho is None else design(seed, n, p, k, rho, snr)
            norms = np.linalg.norm(x, axis=0)
            xi = np.abs(np.linalg.lstsq(x / norms, y, rcond=None)[0])
            tasks.append({
                "rows": np.column_stack([x, y]).tolist(),
                "terms": k,
                "normalised": np.geomspace(1e-3 * xi.max(), xi.max(), 40).tolist(),
                "as_they_are": np.geomspace(1e-4, 1, 40).tolist(),
                "repeats": REPEATS,
            })
            truths.append(truth)
            abess_found.append(run_abess(x, y, k))
    found, costs = run_example(tasks)
    rows = []
    for at, (name, n, p, k, *_) in enumerate(DESIGNS):
        of_design = range(at * DATA_SETS, (at + 1) * DATA_SETS)
        best = [found[i]["sizes"][-1] for i in of_design]
        ratio = [(found[i]["seconds"] + found[i]["factor_seconds"]) / abess_found[i][1] for i in of_design]
        worse = 0
        for i, b in zip(of_design, best):
            data = np.array(tasks[i]["rows"])
            support = abess_found[i][0]
            residual = data[:, -1] - data[:, support] @ np.linalg.lstsq(data[:, support], data[:, -1], rcond=None)[0]
            worse += bool(residual @ residual > b["rss"] * (1 + 1e-6))
        rows.append({
            "design": name, "rows": n, "columns": p, "terms": k,
            "recovered": {
                "best_subset": sum(b["support"] == truths[i] for i, b in zip(of_design, best)) / DATA_SETS,
                "abess": sum(abess_found[i][0] == truths[i] for i in of_design) / DATA_SETS,
                "stlsq": sum(any(s["support"] == truths[i] for s in found[i]["stlsq"]) for i in of_design) / DATA_SETS,
            },
            "proved": sum(all(s["proved"] for s in found[i]["sizes"]) for i in of_design) / DATA_SETS,
            "largest_gap": max(s["gap"] for i in of_design for s in found[i]["sizes"]),
            "abess_residual_is_larger": worse / DATA_SETS,
            "median_seconds": {
                "best_subset_path": statistics.median(found[i]["seconds"] for i in of_design),
                "triangle": statistics.median(found[i]["factor_seconds"] for i in of_design),
                "abess_path": statistics.median(abess_found[i][1] for i in of_design),
                "abess_one_size": statistics.median(abess_found[i][2] for i in of_design),
                "stlsq_sweep": statistics.median(sum(s["seconds"] for s in found[i]["stlsq"]) for i in of_design),
            },
            "slowest_seconds": max(found[i]["seconds"] + found[i]["factor_seconds"] for i in of_design),
            "median_ratio_to_abess_path": statistics.median(ratio),
            "median_operations": statistics.median(sum(s["operations"] for s in found[i]["sizes"]) for i in of_design),
        })
    write("best-subset", data_sets=DATA_SETS, comparison=rows, costs=costs)
