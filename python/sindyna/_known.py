"""What a user knows of a system beforehand, checked and in the engine's terms."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from ._formula import Names

Formulas = Mapping[str, str | Iterable[str]]


def _state(parameter: str, name: Any, names: Names) -> int:
    if isinstance(name, str) and name in names.states:
        return names.states.index(name)
    if isinstance(name, int) and not isinstance(name, bool) and 0 <= name < len(names.states):
        return name
    raise ValueError(f"{parameter}: there is no state {name!r}; states: {', '.join(names.states)}")


def angles(value: Iterable[str] | None, names: Names) -> list[int]:
    """Numbers of the states that are angles."""
    if isinstance(value, str):
        raise ValueError(f"angles must be a list of states, got {value!r}; write angles=[{value!r}]")
    return [_state("angles", name, names) for name in value or ()]


def rates(value: Mapping[str, str] | None, names: Names) -> list[tuple[int, int]]:
    """Pairs of a state and the state whose rate it is."""
    if value is not None and not isinstance(value, Mapping):
        raise ValueError(f"rates must be a dict such as {{'w': 'th'}} (w is the rate of th), got {value!r}")
    pairs = [(_state("rates", rate, names), _state("rates", of, names)) for rate, of in (value or {}).items()]
    for rate, of in pairs:
        if rate == of or sum(other == of for _, other in pairs) > 1:
            raise ValueError(f"rates: {names.states[rate]!r} cannot be the rate of {names.states[of]!r}")
    return pairs


def _formulas(parameter: str, value: Formulas | None, names: Names) -> list[tuple[int, str]]:
    if value is not None and not isinstance(value, Mapping):
        raise ValueError(
            f"{parameter} must be a dict of states and formulas, such as {{'w': '-9.81*sin(th)'}}, got {value!r}"
        )
    found = []
    for state, formulas in (value or {}).items():
        i = _state(parameter, state, names)
        for formula in [formulas] if isinstance(formulas, str) else formulas:
            found.append((i, names.formula(formula)))
    return found


def constraints(
    known: Formulas | None,
    require: Formulas | None,
    forbid: Formulas | None,
    sign: Mapping[str, Mapping[str, Any]] | None,
    names: Names,
) -> list[tuple[int, str, str]]:
    """What is known of equations: the state, the kind, the formula."""
    found = [(i, "known", formula) for i, formula in _formulas("known", known, names)]
    found += [(i, "require", formula) for i, formula in _formulas("require", require, names)]
    found += [(i, "forbid", formula) for i, formula in _formulas("forbid", forbid, names)]
    for state, terms in (sign or {}).items():
        i = _state("sign", state, names)
        if not isinstance(terms, Mapping):
            raise ValueError(
                f"sign must be a dict of states and dicts, such as {{'w': {{'w': '-'}}}}, got {terms!r} for {state!r}"
            )
        for term, value in terms.items():
            kinds = {"+": "positive", "-": "negative", 1: "positive", -1: "negative"}
            if value not in kinds:
                raise ValueError(f"sign of {term!r} must be '+' or '-', got {value!r}")
            found.append((i, kinds[value], names.formula(term)))
    return found


def noise(value: Any, names: Names) -> tuple[list[float] | None, bool]:
    """Standard deviations believed at least (n), and whether only rounding is."""
    if isinstance(value, str):
        if value in ("auto", "none"):
            return None, value == "none"
        raise ValueError(f"noise must be 'auto', 'none', or standard deviations by state, got {value!r}")
    if isinstance(value, Mapping):
        sigma = [0.0] * len(names.states)
        for name, deviation in value.items():
            sigma[_state("noise", name, names)] = _deviation(name, deviation)
    else:
        sigma = [_deviation(name, v) for name, v in zip(names.states, value, strict=False)]
        if len(sigma) != len(names.states) or len(value) != len(sigma):
            raise ValueError(
                f"noise must have one standard deviation for each of the {len(names.states)} states, got {len(value)}"
            )
    return (sigma if any(sigma) else None), False


def _deviation(name: Any, value: Any) -> float:
    try:
        sigma = float(value)
    except (TypeError, ValueError):
        sigma = -1.0
    if not 0.0 <= sigma < float("inf"):
        raise ValueError(f"noise of {name!r} must be finite and at least 0, got {value!r}")
    return sigma
