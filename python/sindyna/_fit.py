"""From arrays to equations: which part of the engine does it, and what it is told."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any, Protocol

import numpy as np

from . import _known, _report, _sindyna
from ._data import Array, Trajectory, columns, trajectories, without_gaps
from ._differentiation import Differentiation, derivatives, finite_order
from ._errors import ConvergenceWarning
from ._formula import Names
from ._libraries import FormulaLibrary, PolynomialLibrary
from ._library import ConcatLibrary, FeatureLibrary, known
from ._optimizers import BestSubset, Optimizer


class Asked(Protocol):
    """The parameters of a `SINDy` that a fit reads."""

    optimizer: Optimizer | None
    feature_library: FeatureLibrary | None
    differentiation_method: Differentiation | Callable[..., Any] | None
    t_default: float
    discrete_time: bool
    noise: str | Mapping[str, float] | Sequence[float]
    angles: Iterable[str] | None
    rates: Mapping[str, str] | None
    known: _known.Formulas | None
    require: _known.Formulas | None
    forbid: _known.Formulas | None
    sign: Mapping[str, Mapping[str, Any]] | None
    terms: Sequence[str] | None
    intersample: str
    controls: int | list[str] | None


@dataclass
class Fitted:
    """Everything a fit leaves behind; never changed afterwards."""

    names: Names
    #: The equations, and the engine's account of them as JSON; or what gives both when somebody asks.
    found: tuple[_sindyna.Model, str] | _sindyna.Regression
    labels: dict[str, str] = field(default_factory=dict)
    n_trajectories: int = 1

    @cached_property
    def model(self) -> _sindyna.Model:
        return self.found[0] if isinstance(self.found, tuple) else self.found.model()

    @cached_property
    def account(self) -> dict[str, Any]:
        return dict(json.loads(self.found[1] if isinstance(self.found, tuple) else self.found.account()))

    def __getstate__(self) -> dict[str, Any]:
        return {
            "names": self.names,
            "found": (self.model, json.dumps(self.account)),
            "labels": self.labels,
            "n_trajectories": self.n_trajectories,
        }

    @cached_property
    def document(self) -> dict[str, Any]:
        return dict(json.loads(self.model.to_json()))

    @cached_property
    def report(self) -> _report.Report:
        return _report.report(
            self.account, self.document, self.model.form, self.names, self.labels, self.n_trajectories
        )

    @cached_property
    def features(self) -> list[str]:
        listed = _report.listed(self.account, self.names, self.labels)
        # Terms with parameters inside are called by what was found.
        for equation, own in zip(self.report.equations, self.account["report"]["equations"], strict=True):
            for summand, j in zip(equation.summands, own["support"], strict=True):
                listed[j] = summand.term
        return listed

    def matrix(self, what: str, missing: float) -> Array:
        """Coefficients or their standard errors as a matrix (n, F)."""
        equations = self.account["report"]["equations"]
        out = np.full((len(equations), len(self.account["report"]["features"])), missing)
        for i, (equation, own) in enumerate(zip(self.report.equations, equations, strict=True)):
            for summand, j in zip(equation.summands, own["support"], strict=True):
                out[i, j] = getattr(summand, what)
        return out


def named(x: Any, u: Any, feature_names: Any, controls: int | list[str] | None, n: int, k: int) -> Names:
    """The names of states and inputs."""
    if feature_names is not None:
        given = [str(name) for name in feature_names]
        if len(given) not in (n, n + k):
            raise ValueError(f"feature_names must name the {n} states and {k} inputs, got {len(given)}: {given}")
        states, inputs = given[:n], given[n:] or [f"u{i}" for i in range(k)]
    else:
        own = columns(x)
        if own is None and (told := columns(u)) is None:
            return _numbered(n, k)
        if own is None:
            states, inputs = [f"x{i}" for i in range(n)], told or []
        elif isinstance(controls, list):
            states, inputs = [name for name in own if name not in controls], list(controls)
        else:
            states, inputs = own[:n], own[n:] or columns(u) or [f"u{i}" for i in range(k)]
    every = [*states, *inputs]
    for i, name in enumerate(every):
        if not name or name in every[:i]:
            raise ValueError(f"every state and input needs a name of its own; {name!r} is not one of {every}")
    return Names(states, inputs)


@lru_cache
def _numbered(n: int, k: int) -> Names:
    """The names of states and inputs that have none."""
    return Names([f"x{i}" for i in range(n)], [f"u{i}" for i in range(k)])


def fit(model: Asked, x: Any, t: Any, x_dot: Any, u: Any, feature_names: Any) -> Fitted:
    """Fits the equations behind samples."""
    optimizer = BestSubset() if model.optimizer is None else model.optimizer
    if not isinstance(optimizer, Optimizer):
        raise NotImplementedError(
            f"optimizer={optimizer!r} is not supported; there are BestSubset (the default), STLSQ and LeastSquares"
        )
    if model.differentiation_method is not None and not callable(model.differentiation_method):
        raise NotImplementedError(
            f"differentiation_method={model.differentiation_method!r} is not supported; there are FiniteDifference and SmoothedFiniteDifference, functions of "
            "samples and times, or give x_dot"
        )
    if model.intersample not in ("zoh", "foh"):
        raise ValueError(
            f"intersample must be 'zoh' (inputs are held) or 'foh' (straight lines between samples), got {model.intersample!r}"
        )
    solver = optimizer._solver()
    data = trajectories(x, t, u, x_dot, default_dt=model.t_default, controls=model.controls)
    names = named(x, u, feature_names, model.controls, data[0].x.shape[1], data[0].u.shape[1])
    if not model.discrete_time:
        data = [part for one in data for part in without_gaps(one)]
    estimate = (
        isinstance(optimizer, BestSubset)
        and model.differentiation_method is None
        and x_dot is None
        and not model.discrete_time
    )
    try:
        if estimate:
            return _identified(model, data, names, solver)
        return _regressed(model, data, names, solver)
    except ValueError as error:
        raise ValueError(names.told(str(error))) from None


def _labels(model: Asked, names: Names) -> dict[str, str]:
    return {} if model.feature_library is None else known(model.feature_library)._labels(names)


def _identified(model: Asked, data: list[Trajectory], names: Names, solver: dict[str, Any]) -> Fitted:
    """Equations of motion with noise that nobody has declared."""
    dts = [one.dt for one in data]
    steps = np.concatenate([np.diff(one.t) for one in data]) if data else np.zeros(0)
    if not len(steps):
        raise ValueError("every trajectory has one sample only: at least two are needed to see a change")
    even = dts[0] is not None and all(dt is not None and abs(dt - dts[0]) <= 1e-9 * dts[0] for dt in dts)
    dt = float(dts[0]) if even and dts[0] is not None else float(np.median(steps))
    declared, rounding_only = _known.noise(model.noise, names)
    settings = {
        "n_states": len(names.states),
        "n_controls": len(names.inputs),
        "dt": dt,
        "angles": _known.angles(model.angles, names),
        "rates": _known.rates(model.rates, names),
        "library": None if model.feature_library is None else known(model.feature_library)._recipe(names),
        "terms": [names.formula(term) for term in model.terms or ()],
        "declared_noise": declared,
        "rounding_only": rounding_only,
        "constraints": _known.constraints(model.known, model.require, model.forbid, model.sign, names),
        "max_size": solver["best_subset"]["max_size"],
    }
    recordings = []
    for one in data:
        if len(one.t) < 2:
            continue
        times: Array = np.arange(len(one.t), dtype=np.float64) * dt if even else one.t
        recordings.append((times, np.ascontiguousarray(one.x), np.ascontiguousarray(_held(model, one))))
    return Fitted(names, _sindyna.identify(recordings, json.dumps(settings)), {}, len(data))


def _held(model: Asked, one: Trajectory) -> Array:
    """Inputs (T - 1, k) as if held from sample to sample."""
    if model.intersample == "zoh" or not one.u.shape[1]:
        return one.u[: len(one.x) - 1]
    if len(one.u) != len(one.x):
        raise ValueError(f"intersample='foh' needs an input for each of the {len(one.x)} samples, got {len(one.u)}")
    return (one.u[:-1] + one.u[1:]) / 2.0


#: Arguments that only the estimator understands, with their defaults.
_ESTIMATOR_ONLY = {
    "noise": "auto",
    "angles": None,
    "rates": None,
    "known": None,
    "require": None,
    "forbid": None,
    "sign": None,
    "intersample": "zoh",
}


def _regressed(model: Asked, data: list[Trajectory], names: Names, solver: dict[str, Any]) -> Fitted:
    """One regression of derivatives or next states."""
    for name, default in _ESTIMATOR_ONLY.items():
        value = getattr(model, name)
        if value is default:
            continue
        if not (isinstance(value, type(default)) and value == default) and value not in ({}, [], ()):
            why = "discrete_time=True" if model.discrete_time else "this optimizer, differentiation_method or x_dot"
            raise NotImplementedError(
                f"{name}={value!r} is for the default optimizer given samples alone, not for {why}"
            )
    library = PolynomialLibrary() if model.feature_library is None else known(model.feature_library)
    if model.terms:
        library = ConcatLibrary([library, FormulaLibrary(model.terms)])
    if model.discrete_time and model.differentiation_method is not None:
        raise NotImplementedError(
            f"differentiation_method={model.differentiation_method!r} has no meaning in discrete time"
        )
    dt = next((one.dt for one in data if one.dt is not None), model.t_default)
    order = finite_order(model.differentiation_method)
    # The engine differentiates by itself what is even.
    alone = model.discrete_time or (order is not None and all(one.dt == dt for one in data))
    prepared = data if alone else [differentiated(model.differentiation_method, one) for one in data]
    rows = []
    for one in prepared:
        inputs = one.u
        if len(inputs) < len(one.x):
            if (not model.discrete_time or one.x_dot is not None) and inputs.shape[1]:
                raise ValueError(f"u must have an input for each of the {len(one.x)} samples, got {len(inputs)}")
            inputs = np.vstack([inputs, np.zeros((len(one.x) - len(inputs), inputs.shape[1]))])
        rows.append((np.ascontiguousarray(one.x), np.ascontiguousarray(inputs), one.x_dot))
    settings = {
        "library": library._recipe(names),
        "solver": solver,
        "discrete": bool(model.discrete_time),
        "order": order or 2,
        "dt": dt,
    }
    if sum(len(x) - (model.discrete_time and known_next is None) for x, _, known_next in rows) < 2:
        raise ValueError("there are fewer than 2 rows to fit equations to")
    regression = _sindyna.regress(rows, settings)
    if "stlsq" in solver:
        _warned(regression, names)
    return Fitted(names, regression, _labels(model, names), len(data))


def _warned(regression: _sindyna.Regression, names: Names) -> None:
    """Warns of what thresholding came to."""
    told = {i: names.states[i] for i in regression.empty}
    if told:
        text = f"the threshold leaves no term in the equation of {', '.join(told.values())}: make it smaller"
        warnings.warn(text, UserWarning, stacklevel=5)
    if regression.unsettled:
        text = (
            f"STLSQ did not converge for {', '.join(names.states[i] for i in regression.unsettled)}: increase max_iter"
        )
        warnings.warn(text, ConvergenceWarning, stacklevel=5)


def differentiated(method: Differentiation | Callable[..., Any] | None, one: Trajectory) -> Trajectory:
    """A trajectory with derivatives."""
    if one.x_dot is not None:
        return one
    x, x_dot = derivatives(method, one)
    return replace(one, x=x, x_dot=x_dot)
