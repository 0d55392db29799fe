"""What fitted equations predict: derivatives, next states, trajectories."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from ._account import Account
from ._data import Array, columns, is_list, trajectories
from ._fit import Fitted
from ._simulate import simulate


class Predictions(Account):
    """What the equations predict."""

    intersample: str
    controls: int | list[str] | None

    def _inputs(self, fitted: Fitted, x: Any, u: Any, name: str) -> tuple[Array, Array]:
        own = columns(x)
        if (
            own is not None
            and (known := own[: len(fitted.names.states)]) != fitted.names.states
            and not isinstance(self.controls, list)
        ):
            raise ValueError(f"the columns of {name} are {known}, the model was fitted to {fitted.names.states}")
        u = needed(fitted, u)
        given = trajectories(
            x, 1.0, u, None, default_dt=1.0, controls=self.controls, n_inputs=len(fitted.names.inputs)
        )[0]
        n = len(fitted.names.states)
        if given.x.shape[1] != n:
            raise ValueError(f"{name} must have {n} columns ({', '.join(fitted.names.states)}), got {given.x.shape[1]}")
        if len(given.u) != len(given.x) and given.u.shape[1]:
            raise ValueError(f"u must have a row for each of the {len(given.x)} rows of {name}, got {len(given.u)}")
        return np.ascontiguousarray(given.x), np.ascontiguousarray(given.u)

    def predict(self, x: Any, u: Any = None) -> Any:
        """
        Derivatives at states; next states of a map.

        Parameters
        ----------
        x : array (N, n), DataFrame, or list of these
            States.
        u : array (N, k), or list of these, optional
            Inputs.

        Returns
        -------
        array (N, n), or list of these
            Derivatives [unit of the state per second], or next states.
        """
        fitted = self._known_model()
        if is_list(x):
            us = [None] * len(x) if u is None else u
            if len(us) != len(x):
                raise ValueError(
                    f"x is a list of {len(x)} trajectories, so u must be a list of {len(x)}, got {len(us)}"
                )
            return [self.predict(one, inputs) for one, inputs in zip(x, us, strict=True)]
        states, inputs = self._inputs(fitted, x, u, "x")
        return fitted.model.right_side(states, inputs)

    def step(self, x: Any, u: Any = None) -> Array:
        """
        States after one sampling interval, in which inputs are held, stepped as the equations were identified.

        Parameters
        ----------
        x : array (N, n)
            States.
        u : array (N, k), optional
            Inputs.

        Returns
        -------
        array (N, n)
            States `dt_` seconds later; NaN where they leave the finite numbers.
        """
        fitted = self._known_model()
        return fitted.model.step(*self._inputs(fitted, x, u, "x"))

    def simulate(
        self,
        x0: Any,
        t: Any,
        u: Any = None,
        *,
        rtol: float = 1e-8,
        atol: float = 1e-10,
        stop_condition: Callable[[Array], Any] | None = None,
    ) -> Array:
        """
        States from a start on. As many rows as times, also with inputs.

        Parameters
        ----------
        x0 : array (n,)
            State at the first time.
        t : array (T,), or int
            Times [s] of equations in continuous time. For a map, and for equations that are stepped by Euler, the number of samples, or times
            one sampling interval apart.
        u : array (T, k) or (T - 1, k), or callable, optional
            Inputs at these times, held or in straight lines between them (``intersample``); or a function of time that gives k numbers.
        rtol, atol : float
            Relative and absolute errors allowed in each step of the solver (continuous time only).
        stop_condition : callable, optional
            A function of a state (n,); the first state after the start for which it is true is the last one told.

        Returns
        -------
        array (T, n)
            States.

        Raises
        ------
        ArithmeticError
            If the states leave the finite numbers.
        """
        fitted = self._known_model()
        states = simulate(fitted, self.intersample, x0, t, needed(fitted, u), rtol, atol)
        stops = (i for i in range(1, len(states)) if stop_condition is not None and stop_condition(states[i]))
        return states[: next(stops, len(states)) + 1]

    def linearize(self, x: Any, u: Any = None) -> tuple[Array, Array]:
        """
        Jacobians of the right-hand sides at one state and input, exact from the terms.

        Parameters
        ----------
        x : array (n,)
            State.
        u : array (k,), optional
            Input; zero by default.

        Returns
        -------
        tuple of array (n, n) and array (n, k)
            Derivatives with respect to the state and to the input.
        """
        fitted = self._known_model()
        inputs = np.zeros(len(fitted.names.inputs)) if u is None else np.asarray(u, dtype=np.float64).reshape(-1)
        return fitted.model.jacobians(np.asarray(x, dtype=np.float64).reshape(-1), inputs)


def needed(fitted: Fitted, u: Any) -> Any:
    """Inputs, where the model has any."""
    if u is not None and not fitted.names.inputs:
        warnings.warn("the model has no inputs: u is left out", UserWarning, stacklevel=3)
        return None
    return u
