"""Equations as people, LaTeX and SymPy read them, and figures."""

from __future__ import annotations

import re
from typing import Any

from . import _formula
from ._fit import Fitted
from ._report import Equation, Summand


def coefficient(value: float, precision: int) -> str:
    """A coefficient with so many decimals, or digits where decimals would hide it."""
    text = f"{value:.{precision}f}"
    return f"{value:.{precision}e}" if value != 0.0 and float(text) == 0.0 else text


def equation(own: Equation, precision: int) -> str:
    """The right-hand side of an equation."""
    told = [coefficient(s.coefficient, precision) + ("" if s.term == "1" else f" {s.term}") for s in own.summands]
    return " + ".join(told) or coefficient(0.0, precision)


def left(fitted: Fitted, name: str) -> str:
    """What stands before the equals sign."""
    return f"({name})[k+1]" if fitted.model.form == "discrete" else f"({name})'"


def latex(fitted: Fitted) -> str:
    """All equations, aligned."""
    names = {name: _formula.latex_name(name) for name in (*fitted.names.states, *fitted.names.inputs)}

    def by_symbol(symbol: str) -> str:
        name = fitted.names.name(symbol)
        return names.get(name, _formula.latex_name(name))

    def summand(s: Summand, first: bool) -> str:
        size = _formula.latex_number(abs(s.coefficient))
        sign = ("-" if s.coefficient < 0 else "") if first else (" - " if s.coefficient < 0 else " + ")
        term = "" if s.tree == ("num", 1.0) else _formula.latex(s.tree, by_symbol)
        if s.tree[0] in ("add", "sub", "neg"):
            term = rf"\left({term}\right)"
        rate = "" if s.rate is None else rf"\dot{{{names[s.rate]}}}"
        factors = [part for part in (term, rate) if part]
        if size == "1" and factors:
            return sign + r" \, ".join(factors)
        return sign + r" \, ".join([size, *factors])

    rows = []
    for own in fitted.report.equations:
        name = names[own.state]
        before = rf"{name}_{{k+1}}" if fitted.model.form == "discrete" else rf"\dot{{{name}}}"
        after = "".join(summand(s, i == 0) for i, s in enumerate(own.summands)) or "0"
        rows.append(f"{before} &= {after}")
    return "$$\\begin{aligned}\n" + " \\\\\n".join(rows) + "\n\\end{aligned}$$"


def sympy(fitted: Fitted) -> list[Any]:
    """The right-hand sides as SymPy expressions, solved for derivatives."""
    import sympy as sp

    symbols = {symbol: sp.Symbol(name) for symbol, name in fitted.names.by_symbol.items()}
    n = len(fitted.names.states)
    explicit, implicit = [sp.Integer(0)] * n, sp.eye(n)
    for i, own in enumerate(fitted.report.equations):
        for s in own.summands:
            term = sp.Float(s.coefficient, 17) * _formula.sympy(s.tree, symbols.__getitem__, symbols.__getitem__)
            if s.rate is None:
                explicit[i] = explicit[i] + term
            else:
                implicit[i, fitted.names.states.index(s.rate)] -= term
    if implicit == sp.eye(n):
        return explicit
    return list(implicit.LUsolve(sp.Matrix(explicit)))


def plot(states: list[str], times: list[Any], measured: list[Any], followed: list[Any]) -> Any:
    """A figure with a panel for each state: samples, and what the equations make of them."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(
        len(states), 1, sharex=True, squeeze=False, figsize=(7.0, 1.2 + 1.6 * len(states)), layout="constrained"
    )
    for i, (name, axis) in enumerate(zip(states, axes[:, 0], strict=True)):
        for j, (t, x, model) in enumerate(zip(times, measured, followed, strict=True)):
            axis.plot(t, x[:, i], ".", color="0.6", markersize=3, label="samples" if j == 0 else None)
            axis.plot(t, model[:, i], color="C0", linewidth=1.2, label="equations" if j == 0 else None)
        axis.set_ylabel(re.sub(r"([$\\])", r"\\\1", name).replace("\n", " "))
    axes[-1, 0].set_xlabel("time [s]")
    axes[0, 0].legend(loc="upper right", fontsize="small")
    return figure
