#!/usr/bin/env python3
"""Best subset against abess and STLSQ: how often each finds the true terms, and in what time.

Draws the designs, gives the same rows to abess (Zhu et al. 2020, PNAS 117(52), from PyPI) and to the example
`best_subset_cost`, and writes results/best-subset.json and docs/best-subset.md. Each solver is told the true number of
terms k; STLSQ gets every threshold of two sweeps, on the columns as they are and scaled to unit length,
and counts as right if any of them is. Times are medians of repeats in
the same run, one thread each: best subset is the whole path of sizes 0..k with its proofs, abess its path of sizes 0..k,
STLSQ the sum over the sweep.

Usage: scripts/best_subset.py      (makes a virtual environment in target/venv-best-subset; about two minutes)
"""

import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / "target" / "venv-best-subset"
PACKAGES = ["numpy", "abess"]
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


def reexec_in_venv():
    """Runs this script again with the Python that has the packages."""
    python = VENV / "bin" / "python"
    if Path(sys.prefix) == VENV:
        return
    if not python.exists():
        venv.create(VENV, with_pip=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", *PACKAGES], check=True)
    threads = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
    os.execve(python, [str(python), __file__, *sys.argv[1:]], {**os.environ, **threads})


def design(np, seed, n, p, k, rho, snr):
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


def lorenz(np, seed, n, ratio):
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


def run_abess(np, x, y, k):
    """Support of size k, the times of the path 0..k and of the one size."""
    from abess import LinearRegression

    def fit(sizes):
        model = LinearRegression(support_size=sizes, fit_intercept=False, ic_type="ebic", thread=1)
        model.fit(x, y)
        return sorted(np.flatnonzero(model.coef_).tolist())

    _, path_seconds = median_time(lambda: fit(list(range(k + 1))))
    support, seconds = median_time(lambda: fit([k]))
    return support, path_seconds, seconds


def run_example(tasks):
    """What the example finds for the tasks."""
    subprocess.run(["cargo", "build", "--release", "-p", "sindyna-sindy", "--example", "best_subset_cost"],
                   cwd=ROOT, check=True)
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    program = target / "release" / "examples" / "best_subset_cost"
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump(tasks, file)
        file.flush()
        found = json.loads(subprocess.run([program, file.name], check=True, capture_output=True).stdout)
    costs = json.loads(subprocess.run([program], check=True, capture_output=True).stdout)
    return found, costs


def main():
    reexec_in_venv()
    import abess
    import numpy as np

    tasks, truths, abess_found = [], [], []
    for name, n, p, k, rho, snr in DESIGNS:
        for seed in range(DATA_SETS):
            x, y, truth = lorenz(np, seed, n, snr) if rho is None else design(np, seed, n, p, k, rho, snr)
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
            abess_found.append(run_abess(np, x, y, k))
    found, costs = run_example(tasks)
    rows = []
    for at, (name, n, p, k, rho, snr) in enumerate(DESIGNS):
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
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True)
    result = {
        "command": "scripts/best_subset.py",
        "commit": commit.stdout.strip(),
        "versions": {"abess": abess.__version__, "numpy": np.__version__, "python": platform.python_version()},
        "data_sets": DATA_SETS,
        "comparison": rows,
        "costs": costs,
    }
    (ROOT / "results" / "best-subset.json").write_text(json.dumps(result, indent=1) + "\n")
    (ROOT / "docs" / "best-subset.md").write_text(page(result))


def page(result):
    """The page of tables."""
    lines = [
        "# Best subset: recovery and cost",
        "",
        f"Written by `scripts/best_subset.py` from `results/best-subset.json` ({result['data_sets']} data sets per design,"
        f" abess {result['versions']['abess']}). Every solver is told the true number of terms; STLSQ counts as right if"
        " any of 80 thresholds is, half of them on columns of unit length. Times are medians for one thread; best subset is the whole path with its"
        " proofs and the triangle, abess its path over the same sizes, which proves nothing.",
        "",
        "| design | rows × columns, terms | best subset | abess | STLSQ | abess misses the best | all sizes proved | median [ms] | slowest [ms] |"
        " time / abess |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for row in result["comparison"]:
        recovered, seconds = row["recovered"], row["median_seconds"]
        lines.append(
            f"| {row['design']} | {row['rows']} × {row['columns']}, {row['terms']} | {recovered['best_subset']:.0%} |"
            f" {recovered['abess']:.0%} | {recovered['stlsq']:.0%} | {row['abess_residual_is_larger']:.0%} |"
            f" {row['proved']:.0%} |"
            f" {1e3 * (seconds['best_subset_path'] + seconds['triangle']):.1f} | {1e3 * row['slowest_seconds']:.1f} |"
            f" {row['median_ratio_to_abess_path']:.2g} |")
    titles = {
        "cases": "What a proof costs", "bounds": "What each bound gives", "growth": "How the cost grows",
    }
    for part, title in titles.items():
        lines += ["", f"## {title}", "",
                  "| case | rows × columns | sizes up to | bound | proved up to | operations | ratio | seconds |",
                  "|---|---|---|---|---|---|---|---|"]
        first = {}
        for case in result["costs"][part]:
            if "sizes" not in case:
                lines.append(f"| {case['case']} | {case['rows']} × {case['features']} | {case['sizes_tried'] - 1} | all |"
                             f" {case['proved_up_to']} | | | {case['seconds']:.4f} |")
                continue
            base = first.setdefault(case["case"], case["operations"])
            lines.append(
                f"| {case['case']} | {case['rows']} × {case['features']} | {case['terms']} | {case['bound']} |"
                f" {case['proved_up_to']} | {case['operations']:.2e} | {case['operations'] / base:.3g} |"
                f" {case['seconds']:.4f} |")
    lines += ["", "Operations are pairs of columns looked at and their like; the ratio is to the first row of the same"
              " name. Seconds are one machine's."]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
