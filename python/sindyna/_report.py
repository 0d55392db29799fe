"""What was found, and how much to believe it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ._data import Array
from ._formula import Names, Tree, plain, read, shifted


@dataclass(frozen=True)
class Summand:
    """One summand of an equation."""

    #: The term in PySINDy's notation, such as ``x0 x1`` or ``sin(th)``.
    term: str
    #: Its coefficient.
    coefficient: float
    #: The standard error of that: NaN where it is not known, infinite where the data do not determine it, 0 where it was given.
    standard_error: float
    tree: Tree
    #: The state by whose derivative the term is multiplied, if any: the equation is then implicit.
    rate: str | None = None


@dataclass(frozen=True)
class Equation:
    """The account of the equation of one state."""

    #: The state.
    state: str
    #: Its summands.
    summands: tuple[Summand, ...]
    #: Whether it leaves no more than the noise, or rounding, explains, and no other terms are as good.
    adequate: bool
    #: What speaks against it, if anything.
    doubt: str | None
    #: Root mean square of what it leaves, in the unit of the left-hand side.
    residual: float
    #: Whether it was declared (``rates``), not fitted.
    declared: bool
    #: How many of the summands, the last ones, were given (``known``).
    n_known: int
    #: Parameters inside its terms: the term, the value, its standard error.
    parameters: tuple[tuple[str, float, float], ...]
    #: Other sets of terms that the data do not distinguish from these.
    equally_good: tuple[tuple[str, ...], ...]

    @property
    def terms(self) -> tuple[str, ...]:
        """Its terms."""
        return tuple(s.term for s in self.summands)

    @property
    def coefficients(self) -> Array:
        """Their coefficients (n_terms,)."""
        return np.array([s.coefficient for s in self.summands])

    @property
    def standard_errors(self) -> Array:
        """The standard errors of these (n_terms,)."""
        return np.array([s.standard_error for s in self.summands])


@dataclass(frozen=True)
class Report:
    """The account of a fit."""

    #: ``exact`` (nothing but rounding is left), ``adequate`` (nothing but noise), ``ambiguous`` (other terms are as good) or
    #: ``doubted`` (something speaks against an equation), ``not judged`` (one regression, which knows nothing of errors).
    certainty: str
    #: One account per state.
    equations: tuple[Equation, ...]
    #: Standard deviation of the noise of each state, in its unit; zero where rounding explains the data; None where it was not estimated.
    noise: dict[str, float] | None
    #: Part of the variance of each state's noise that grows with the square of its value; None where it was not estimated.
    noise_growing: dict[str, float] | None
    #: Fit of each state, 1 - |x - x_model| / |x - mean x|, along each recording from an estimated start; None where it was not estimated.
    fit: dict[str, float] | None
    #: How the equations are stepped from sample to sample.
    stepping: str
    #: Steps that went into the fit.
    rows: int
    #: Steps left out because they do not follow the equations of all the others.
    rows_astray: int
    #: Trajectories, after gaps were cut.
    n_trajectories: int
    #: Condition number of the candidate terms, or of the fit's sensitivities.
    condition: float
    #: Whether the search for terms tried all it would.
    search_complete: bool
    #: What the data do not show, in sentences.
    warnings: tuple[str, ...]

    @property
    def doubts(self) -> dict[str, str | None]:
        """What speaks against the equation of each state; None where nothing does."""
        return {equation.state: equation.doubt for equation in self.equations}

    @property
    def equally_good(self) -> dict[str, tuple[tuple[str, ...], ...]]:
        """Sets of terms that explain the data as well as those of the equation of each state."""
        return {equation.state: equation.equally_good for equation in self.equations}

    def __str__(self) -> str:
        lines = [f"certainty: {self.certainty}; {self.stepping}; {self.rows} steps"]
        lines += [f"warning: {text}" for text in self.warnings]
        for equation in self.equations:
            if equation.declared:
                lines.append(f"\n({equation.state})' is {equation.terms[0]}, as declared")
                continue
            verdict = (
                "adequate"
                if equation.adequate
                else f"not adequate: {equation.doubt}"
                if equation.doubt
                else "not judged: one regression"
                if self.certainty == "not judged"
                else "an approximation"
            )
            lines.append(f"\n({equation.state})': {verdict}")
            for i, s in enumerate(equation.summands):
                given = i + equation.n_known >= len(equation.summands)
                error = ", as given" if given else "" if math.isnan(s.standard_error) else f" ± {s.standard_error:.1e}"
                lines.append(f"  {s.term:<24} {s.coefficient: .6e}{error}")
            lines += [f"  {f'in {term}':<24} {value: .6e} ± {error:.1e}" for term, value, error in equation.parameters]
            lines += [f"  equally good: {', '.join(other)}" for other in equation.equally_good]
        if self.noise is not None:
            noises = ", ".join(f"{name} {sigma:.2e}" for name, sigma in self.noise.items())
            lines.append(f"\nnoise: {noises}")
        if self.fit is not None:
            lines.append(f"fit: {', '.join(f'{name} {_percent(fit)}' for name, fit in self.fit.items())}")
        return "\n".join(lines)


def _percent(fit: float) -> str:
    return "- (nothing to fit)" if math.isnan(fit) else f"{100 * fit:.1f} %"


def _number(value: Any) -> float:
    return math.inf if value is None else float(value)


def feature(text: str, names: Names) -> str:
    """A candidate term of the engine, in PySINDy's notation."""
    try:
        return plain(read(text), names.name)
    except (ValueError, IndexError):
        return names.told(text)


def _trees(document: dict[str, Any]) -> list[Tree]:
    symbols = document["states"]
    offsets = dict(zip(symbols, document.get("offsets") or [0.0] * len(symbols), strict=True))
    return [shifted(read(text), offsets) for text in document["terms"]]


_STEPPING = {
    "euler": "stepped by Euler, {dt:g} s",
    "semi_implicit": "stepped by semi-implicit Euler, {dt:g} s",
    "continuous": "continuous time",
    "discrete": "a map from sample to sample",
}


def _stepping(form: str, document: dict[str, Any]) -> str:
    """How one interval is made of the equations; simulators may take several steps from sample to sample."""
    scheme = document.get("scheme")
    substeps = scheme.get("semi_implicit_euler", {}).get("substeps", 1) if isinstance(scheme, dict) else 1
    several = f", {substeps} steps" if substeps > 1 else ""
    return _STEPPING[form].format(dt=document["dt"] / substeps) + several


def report(
    account: dict[str, Any],
    document: dict[str, Any],
    form: str,
    names: Names,
    labels: dict[str, str],
    n_trajectories: int,
) -> Report:
    """The report of the engine's account and its model."""
    told = account["report"]
    trees = _trees(document)
    regression = told["noise"] == "NotEstimated"
    equations = []
    for i, (own, entries) in enumerate(zip(told["equations"], document["equations"], strict=True)):
        errors = [_number(e) for e in own["standard_errors"]]
        if len(errors) != len(entries):
            errors = [math.nan] * len(entries)
        summands = []
        for at, (entry, j, error) in enumerate(zip(entries, own["support"], errors, strict=True)):
            rate = None if entry.get("rate") is None else names.states[entry["rate"]]
            tree = trees[entry["term"]]
            if regression:
                text = _listed(told["features"][j], names, labels)
            elif tree == ("num", 1.0) and rate is not None:
                text = f"({rate})'"
            else:
                text = plain(tree, names.name) + ("" if rate is None else f" ({rate})'")
            given = at + own["n_known"] >= len(entries)
            summands.append(Summand(text, entry["coefficient"], 0.0 if given else error, tree, rate))
        equations.append(
            Equation(
                state=names.states[i],
                summands=tuple(summands),
                adequate=own["reached_floor"],
                doubt=account["doubts"][i],
                residual=_number(own["residual"]),
                declared=document["kinematic"][i],
                n_known=own["n_known"],
                parameters=tuple(
                    (feature(told["features"][p["term"]], names), p["value"], _number(p["standard_error"]))
                    for p in own["parameters"]
                ),
                equally_good=tuple(
                    tuple(feature(told["features"][j], names) for j in other) for other in own["equally_good"]
                ),
            )
        )

    def by_state(values: list[Any]) -> dict[str, float] | None:
        return dict(zip(names.states, map(_number, values), strict=True)) if values else None

    noise = by_state(told["noise_deviations"])
    if noise is None and not regression:
        noise = dict.fromkeys(names.states, 0.0)
    return Report(
        certainty="not judged" if regression and account["certainty"] == "doubted" else account["certainty"],
        equations=tuple(equations),
        noise=noise,
        noise_growing=by_state(told["noise_growing"]),
        fit=by_state([math.nan if value is None else value for value in told["fit"]]),
        stepping=_stepping(form, document),
        rows=told["rows"],
        rows_astray=told["rows_astray"],
        n_trajectories=n_trajectories,
        condition=_number(told["condition"]),
        search_complete=told["search_complete"],
        warnings=tuple(names.told(text) for text in told["warnings"]),
    )


def _listed(text: str, names: Names, labels: dict[str, str]) -> str:
    """A term of a library, which has PySINDy's name already."""
    return labels.get(text) or names.told(text)


def listed(account: dict[str, Any], names: Names, labels: dict[str, str]) -> list[str]:
    """All candidate terms, in PySINDy's notation."""
    told = account["report"]
    if told["noise"] == "NotEstimated":
        return [_listed(text, names, labels) for text in told["features"]]
    return [feature(text, names) for text in told["features"]]
