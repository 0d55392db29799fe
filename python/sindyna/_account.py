"""What a fitted model tells: equations, coefficients, names."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import _show
from ._data import Array
from ._errors import NotFittedError
from ._fit import Fitted
from ._report import Report


class Account:
    """What was found."""

    _fitted: Fitted | None = None

    def _known_model(self) -> Fitted:
        fitted: Fitted | None = getattr(self, "_fitted", None)
        if fitted is None:
            raise NotFittedError(f"this {type(self).__name__} is not fitted yet; call fit first")
        return fitted

    def equations(self, precision: int = 3) -> list[str]:
        """
        The right-hand sides as text.

        Parameters
        ----------
        precision : int
            Decimals of coefficients; those that would round to zero are written as ``1.000e-05``, and none is left out.

        Returns
        -------
        list of str
            One for each state.
        """
        return [_show.equation(own, precision) for own in self._known_model().report.equations]

    def print(self, lhs: list[str] | None = None, precision: int = 3, **print_kwargs: Any) -> None:
        """
        Prints the equations.

        Parameters
        ----------
        lhs : list of str, optional
            Left-hand sides.
        precision : int
            Decimals of coefficients.
        **print_kwargs
            Arguments of the built-in ``print``.
        """
        fitted = self._known_model()
        before = lhs or [_show.left(fitted, name) for name in fitted.names.states]
        for left, right in zip(before, self.equations(precision), strict=True):
            print(f"{left} = {right}", **print_kwargs)

    def coefficients(self) -> Array:
        """
        The coefficients of all candidate terms.

        Returns
        -------
        array (n, F)
            A row for each state, a column for each of `get_feature_names`.
        """
        return self._known_model().matrix("coefficient", 0.0)

    @property
    def coef_(self) -> Array:
        """The coefficients (n, F)."""
        return self.coefficients()

    @property
    def standard_errors_(self) -> Array:
        """Standard errors of the coefficients (n, F); NaN for terms that are not in the equation, or where they are not known."""
        return self._known_model().matrix("standard_error", np.nan)

    @property
    def report_(self) -> Report:
        """What was found, and how much to believe it."""
        return self._known_model().report

    def get_feature_names(self) -> list[str]:
        """
        The candidate terms, in PySINDy's notation.

        Returns
        -------
        list of str (F,)
        """
        return list(self._known_model().features)

    @property
    def feature_names_in_(self) -> Any:
        """Names of states, then of inputs: an array of str (n + k,)."""
        names = self._known_model().names
        return np.array([*names.states, *names.inputs], dtype=object)

    @property
    def n_features_in_(self) -> int:
        """Number of states and inputs."""
        return len(self.feature_names_in_)

    @property
    def n_control_features_(self) -> int:
        """Number of inputs."""
        return len(self._known_model().names.inputs)

    @property
    def n_output_features_(self) -> int:
        """Number of candidate terms."""
        return len(self._known_model().account["report"]["features"])

    @property
    def complexity(self) -> int:
        """Number of coefficients that are not zero."""
        return sum(len(own.summands) for own in self.report_.equations)

    @property
    def dt_(self) -> float:
        """Sampling interval [s] of the data; the median of uneven ones."""
        return self._known_model().model.dt

    def to_sympy(self) -> list[Any]:
        """
        The right-hand sides as SymPy expressions, solved for derivatives.

        Returns
        -------
        list of sympy.Expr
            One for each state, over symbols called like states and inputs.
        """
        return _show.sympy(self._known_model())

    def _repr_latex_(self) -> str | None:
        fitted: Fitted | None = getattr(self, "_fitted", None)
        return None if fitted is None else _show.latex(fitted)
