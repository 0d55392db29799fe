"""Formulas of Python functions, learned by calling them with symbols."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

_UNARY = {
    "sin": "sin", "cos": "cos", "tan": "tan", "exp": "exp", "log": "log", "sqrt": "sqrt", "absolute": "abs", "fabs": "abs",
    "sign": "sign", "tanh": "tanh", "arctan": "atan",
}  # fmt: skip
_OF_TWO = {"maximum": "max", "fmax": "max", "minimum": "min", "fmin": "min"}
_BINARY = {"add": "+", "subtract": "-", "multiply": "*", "divide": "/", "true_divide": "/"}


class Traced:
    """A number that remembers how it was computed."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **kwargs: Any) -> Any:
        name = ufunc.__name__
        if method == "__call__" and not kwargs:
            if name in _UNARY:
                return Traced(f"{_UNARY[name]}({_text(inputs[0])})")
            if name in _OF_TWO:
                return Traced(f"{_OF_TWO[name]}({_text(inputs[0])}, {_text(inputs[1])})")
            if name in _BINARY:
                return _both(inputs[0], _BINARY[name], inputs[1])
            if name in ("power", "float_power"):
                return _text_power(inputs[0], inputs[1])
            if name == "square":
                return _text_power(inputs[0], 2)
            if name == "reciprocal":
                return _both(1.0, "/", inputs[0])
            if name == "negative":
                return -inputs[0]
        raise NotImplementedError(f"numpy.{name} is not among the functions of terms")

    def __add__(self, other: Any) -> Traced:
        return _both(self, "+", other)

    def __radd__(self, other: Any) -> Traced:
        return _both(other, "+", self)

    def __sub__(self, other: Any) -> Traced:
        return _both(self, "-", other)

    def __rsub__(self, other: Any) -> Traced:
        return _both(other, "-", self)

    def __mul__(self, other: Any) -> Traced:
        return _both(self, "*", other)

    def __rmul__(self, other: Any) -> Traced:
        return _both(other, "*", self)

    def __truediv__(self, other: Any) -> Traced:
        return _both(self, "/", other)

    def __rtruediv__(self, other: Any) -> Traced:
        return _both(other, "/", self)

    def __neg__(self) -> Traced:
        return Traced(f"(-({self.text}))")

    def __pos__(self) -> Traced:
        return self

    def __abs__(self) -> Traced:
        return Traced(f"abs({self.text})")

    def clip(self, low: Any, high: Any, **_: Any) -> Traced:
        """What `numpy.clip` calls."""
        return Traced(f"clip({self.text}, {_text(low)}, {_text(high)})")

    def __pow__(self, other: Any) -> Traced:
        return _text_power(self, other)


def _method(function: str) -> Callable[[Traced], Traced]:
    return lambda self: Traced(f"{function}({self.text})")


# What NumPy calls for each element of an array of objects.
for _function in ("sin", "cos", "tan", "exp", "log", "sqrt", "tanh", "arctan"):
    setattr(Traced, _function, _method(_UNARY[_function]))


def of_rows(function: Callable[..., Any], *rows: Sequence[str]) -> str | None:
    """The formula of a function of arrays with a row per step; none if it does something that a term cannot, comparisons among them."""
    try:
        result = function(*(np.array([[Traced(symbol) for symbol in row]], dtype=object) for row in rows))
        (value,) = np.asarray(result, dtype=object).reshape(-1)
    except Exception:
        return None
    if isinstance(value, Traced):
        return value.text
    return repr(float(value)) if isinstance(value, (int, float)) else None


def _text(value: Any) -> str:
    return value.text if isinstance(value, Traced) else f"({float(value)!r})"


def _both(a: Any, sign: str, b: Any) -> Traced:
    return Traced(f"({_text(a)}{sign}{_text(b)})")


def _text_power(base: Any, exponent: Any) -> Traced:
    if isinstance(exponent, Traced) or not float(exponent).is_integer():
        half = not isinstance(exponent, Traced) and float(exponent) == 0.5
        if half:
            return Traced(f"sqrt({_text(base)})")
        raise NotImplementedError("exponents of terms are whole numbers or 0.5")
    return Traced(f"({_text(base)})^{int(exponent)}")


def arity(function: Callable[..., Any]) -> int:
    """How many variables a function has."""
    code = getattr(function, "__code__", None)
    if code is not None:
        return int(code.co_argcount)
    return int(getattr(function, "nin", 1))


def traced(function: Callable[..., Any], symbols: Sequence[str]) -> str:
    """The formula of a function over symbols.

    Raises
    ------
    NotImplementedError
        If the function does something that a term cannot.
    """
    hint = "write the term as a formula: FormulaLibrary(['sin(x0)'])"
    try:
        result = function(*[Traced(symbol) for symbol in symbols])
    except Exception as error:
        raise NotImplementedError(f"{function!r} cannot be read as a formula ({error}); {hint}") from error
    if isinstance(result, (int, float)):
        return repr(float(result))
    if not isinstance(result, Traced):
        raise NotImplementedError(f"{function!r} gives {type(result).__name__}, not a formula; {hint}")
    return result.text
