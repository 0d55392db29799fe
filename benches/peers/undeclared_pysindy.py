"""PySINDy on logs whose noise nobody declares: how often its terms are the true ones."""

import itertools
import json
import os
import pathlib
import re
import time
import warnings

from .shared import ONE_THREAD, tell, write

# NumPy reads this when it is imported.
os.environ |= ONE_THREAD

import numpy as np
import pysindy as ps

warnings.filterwarnings("ignore")
ABOUT = """The logs are written by `undeclared --set reported --export FOLDER` of crates/bench. For each, and for each equation that does not only say that
a state is the rate of another (those rows are given), STLSQ and ensembles of STLSQ (bagging, 20 models, median) are fitted to
smoothed finite differences (Savitzky–Golay, 11 samples, degree 3: PySINDy's default) of the smoothed states. Candidates: polynomials to
degree 3 of states and inputs, in which an angle stands as sin and cos, and as itself too if it does not go round; squares of cosines are
left out, being 1 less those of sines. An input in the middle of two samples of different values is their mean; first and last samples
are not used. The threshold is one of 25, of coefficients as they are or of those of columns of unit length (normalize_columns): the one with the
least corrected Akaike criterion (AICc), the one with the least Bayesian criterion (BIC), and, apart, whichever gives the true terms, which
only who knows them can choose; for that, unsmoothed differences of order 4 are tried as well. Equations choose for themselves."""
THRESHOLDS = np.logspace(-4, 4, 25)
RIDGE = 1e-8
MODELS = 20
POINTS = 500
HOW = ("aic", "bic", "best")
FUNCTIONS = {name: getattr(np, name) for name in ("sin", "cos", "tan", "exp", "log", "sqrt", "abs", "sign", "tanh")}


def value(text, columns):
    """A term over named columns."""
    rows = len(next(iter(columns.values())))
    code = text.replace("^", "**").replace(" ", "*") if "(" not in text else text.replace("^", "**")
    return np.broadcast_to(np.asarray(eval(code, {"__builtins__": {}}, FUNCTIONS | columns), float), rows)


class Truth:
    """The true rates at random points, and whether a sum of terms can be one of them."""

    def __init__(self, about):
        rng = np.random.default_rng(0)
        names, bounds = about["states"] + about["inputs"], about["bounds"]
        self.columns = {n: rng.uniform(low, high, POINTS) for n, (low, high) in zip(names, bounds)}
        n = len(about["states"])
        mass, right = np.tile(np.eye(n), (POINTS, 1, 1)), np.zeros((POINTS, n))
        for i, row in enumerate(about["truth"]):
            for term in row:
                part = term["coefficient"] * value(term["text"], self.columns)
                if term["rate"] is None:
                    right[:, i] += part
                else:
                    mass[:, i, term["rate"]] -= part
        self.rates = np.linalg.solve(mass, right[:, :, None])[:, :, 0]
        self.sizes = [len(row) for row in about["truth"]]

    def is_right(self, i, terms):
        """As `undeclared` judges: satisfied with one set of coefficients, all needed, no more terms than the truth."""
        if not terms or len(terms) > self.sizes[i]:
            return False
        a = np.column_stack([value(t, self.columns) for t in terms])
        norms, target = np.linalg.norm(a, axis=0), self.rates[:, i]
        if not np.all(np.isfinite(norms) & (norms > 0)):
            return False
        x, _, rank, _ = np.linalg.lstsq(a / norms, target, rcond=1e-7)
        spread, left = target.std(), target - a / norms @ x
        return rank == len(terms) and np.sqrt(np.mean(left**2)) < 1e-9 * spread and np.all(np.abs(x) / np.sqrt(POINTS) > 1e-7 * spread)


def recordings(path, about):
    """Per recording: states (T, n) and inputs (T, k), the last row of which is empty."""
    table = np.genfromtxt(path, delimiter=",", skip_header=1, ndmin=2)
    n = len(about["states"])
    for number in np.unique(table[:, 0]):
        rows = table[table[:, 0] == number]
        yield rows[:, 2:2 + n], rows[:, 2 + n:]


def prepared(path, about, differentiator):
    """z = (x; u) by name, and ẋ, on the inner samples of all recordings."""
    parts, rates = [], []
    for x, u in recordings(path, about):
        t = about["dt"] * np.arange(len(x))
        rate = np.asarray(differentiator(x, t))
        z = np.hstack([np.asarray(differentiator.smoothed_x_)[1:-1], 0.5 * (u[:-2] + u[1:-1])])
        keep = np.isfinite(rate[1:-1]).all(axis=1)
        parts.append(z[keep])
        rates.append(rate[1:-1][keep])
    names = about["states"] + about["inputs"]
    return dict(zip(names, np.vstack(parts).T)), np.vstack(rates)


def candidates(columns, about):
    """Θ and the names of its columns."""
    basis = {}
    for name in columns:
        role = about["roles"][about["states"].index(name)] if name in about["states"] else "plain"
        if role in ("turning", "angle"):
            basis[f"sin({name})"], basis[f"cos({name})"] = np.sin(columns[name]), np.cos(columns[name])
        if role != "turning":
            basis[name] = columns[name]
    library = ps.PolynomialLibrary(degree=3)
    theta = np.asarray(library.fit_transform(np.column_stack(list(basis.values()))))
    terms = [name.replace(" ", "*") for name in library.get_feature_names(list(basis))]
    kept = [j for j, name in enumerate(terms) if not re.search(r"cos\(\w+\)\^", name)]
    return theta[:, kept], [terms[j] for j in kept]


def supports(theta, target, ensemble, rng):
    """Per set of terms that some threshold leaves: (AICc, BIC)."""
    found = {}
    for threshold, unit in itertools.product(THRESHOLDS, (False, True)):
        optimizer = ps.STLSQ(threshold=threshold, alpha=RIDGE, normalize_columns=unit)
        if ensemble:
            np.random.seed(rng.integers(2**31))
            optimizer = ps.EnsembleOptimizer(opt=optimizer, bagging=True, n_models=MODELS)
        try:
            coefficients = np.ravel(optimizer.fit(theta, target[:, None]).coef_)
        except (ValueError, np.linalg.LinAlgError):
            continue
        chosen = tuple(np.flatnonzero(coefficients))
        n, k = len(target), len(chosen)
        if n > k + 1:
            fit = n * np.log(max(np.mean((target - theta @ coefficients) ** 2), 1e-300))
            scores = fit + 2 * k + 2 * k * (k + 1) / (n - k - 1), fit + k * np.log(n)
            found[chosen] = min(scores, found.get(chosen, scores))
    return found


def measured(path, about, ensembles):
    """One log: for each method, whether AICc and whether hindsight find every equation."""
    truth, rng, start = Truth(about), np.random.default_rng(0), time.process_time()
    methods = {"stlsq": False} | ({"ensemble": True} if ensembles else {})
    right = {f"{name}_{how}": True for name in methods for how in HOW}
    kinds = [ps.SmoothedFiniteDifference(), ps.FiniteDifference(order=4)]
    data = [prepared(path, about, kind) for kind in kinds]
    designs = [candidates(columns, about) for columns, _ in data]
    for i in about["judged"]:
        for name, ensemble in methods.items():
            best = False
            for number, ((theta, terms), (_, rates)) in enumerate(zip(designs, data)):
                tried = supports(theta, rates[:, i], ensemble, rng)
                is_right = {chosen: truth.is_right(i, [terms[j] for j in chosen]) for chosen in tried}
                best |= any(is_right.values())
                if number == 0:
                    for place, how in enumerate(("aic", "bic")):
                        chosen = min(tried, key=lambda c: tried[c][place], default=None)
                        right[f"{name}_{how}"] &= bool(is_right.get(chosen))
            right[f"{name}_best"] &= best
    return right | {"seconds": time.process_time() - start}


def undeclared_pysindy(folder, out="undeclared-pysindy", skip_ensembles=False):
    """PySINDy on the logs in a folder, one JSON line per log, and groups in results/OUT.json.

    `cargo run --release -p sindyna-bench --bin undeclared -- --export FOLDER` writes the logs. Equations with a mass matrix cannot be said
    by PySINDy's candidates and are never right.
    """
    groups = {}
    for csv in sorted(pathlib.Path(folder).glob("*.csv")):
        about = json.loads(csv.with_suffix(".json").read_text())
        noise, samples, seed = csv.stem[len(about["system"]) + 1:].split("-")
        case = {"system": about["system"], "noise": float(noise), "samples": int(samples)}
        row = measured(csv, about, not skip_ensembles)
        tell(**case, seed=int(seed), **row)
        groups.setdefault(tuple(case.values()), []).append(case | row)
    found = []
    for rows in groups.values():
        sums = {k: sum(r[k] for r in rows) for k in rows[0] if k.endswith(HOW)}
        seconds = float(f"{np.median([r['seconds'] for r in rows]):.3g}")
        of = [m for m in ("stlsq", "ensemble") if f"{m}_aic" in sums]
        cell = "; ".join("/".join(str(sums[f"{m}_{how}"]) for how in HOW) for m in of) + f", {seconds:g} s"
        keys = {k: rows[0][k] for k in ("system", "noise", "samples")}
        found.append(keys | {"seeds": len(rows)} | sums | {"seconds": seconds, "cell": cell})
    about = ("PySINDy 2.1.0, explicit equations. Right with the threshold that AICc chooses / that BIC chooses / with the best of all, of"
             " STLSQ; then of ensembles; median time for all thresholds. " + " ".join(ABOUT.split()))
    write(out, about=about, pysindy=ps.__version__, groups=found)
