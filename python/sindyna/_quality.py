"""How well fitted equations explain samples."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from . import _show
from ._data import Array, trajectories
from ._differentiation import Differentiation
from ._fit import Fitted, differentiated
from ._predictions import Predictions, needed


class Quality(Predictions):
    """How well the equations explain samples."""

    differentiation_method: Differentiation | Callable[..., Any] | None

    def _judged(self, x: Any, t: Any, x_dot: Any, u: Any) -> tuple[Fitted, list[Any]]:
        fitted = self._known_model()
        u = needed(fitted, u)
        data = trajectories(
            x, t, u, x_dot, default_dt=fitted.model.dt, controls=self.controls, n_inputs=len(fitted.names.inputs)
        )
        if data[0].x.shape[1] != len(fitted.names.states):
            raise ValueError(f"x must have {len(fitted.names.states)} states, got {data[0].x.shape[1]}")
        return fitted, data

    def score(
        self,
        x: Any,
        t: Any = None,
        x_dot: Any = None,
        u: Any = None,
        metric: Callable[[Array, Array], float] | None = None,
    ) -> float:
        """
        How well `predict` explains derivatives, or next states of a map: those given, or estimated from samples (``differentiation_method``, or finite differences).

        Noise in the samples counts against the score, however good the equations are: see `compare` for a measure that is about trajectories.

        Parameters
        ----------
        x, t, x_dot, u
            As in `fit`. Without times, samples are `dt_` apart.
        metric : callable, optional
            A function of true and predicted derivatives (N, n); the coefficient of determination, averaged over states, by default.

        Returns
        -------
        float
            1 is perfect.
        """
        fitted, data = self._judged(x, t, x_dot, u)
        true, predicted = [], []
        for one in data:
            if fitted.model.form == "discrete":
                known = one.x_dot is not None
                states, target = (one.x, one.x_dot) if known else (one.x[:-1], one.x[1:])
                states, target = states[: len(one.u)], target[: len(one.u)]
                inputs = one.u[: len(states)]
            else:
                moved = differentiated(self.differentiation_method, one)
                if moved.x_dot is None:
                    continue
                states, target = moved.x[: len(one.u)], moved.x_dot[: len(one.u)]
                inputs = one.u[: len(states)]
            true.append(target)
            predicted.append(fitted.model.right_side(np.ascontiguousarray(states), np.ascontiguousarray(inputs)))
        y, f = np.concatenate(true), np.concatenate(predicted)
        return float((metric or _r2)(y, f))

    def compare(self, x: Any, t: Any = None, u: Any = None, horizon: int | None = None) -> Array:
        """
        How well the equations predict trajectories: 1 - |x - x_model| / |x - mean x| of each state.

        Parameters
        ----------
        x, t, u
            As in `fit`.
        horizon : int, optional
            How many steps ahead each sample is predicted; from the first sample of its trajectory by default.

        Returns
        -------
        array (n,)
            1 is perfect, 0 no better than the mean.
        """
        _, data = self._judged(x, t, None, u)
        ahead = self._ahead(data, horizon)
        measured, predicted = np.concatenate([one.x[1:] for one in data]), np.concatenate([a[1:] for a in ahead])
        missed = np.linalg.norm(measured - predicted, axis=0)
        moved = np.linalg.norm(measured - measured.mean(axis=0), axis=0)
        result: Array = 1.0 - missed / moved
        return result

    def _ahead(self, data: list[Any], horizon: int | None) -> list[Array]:
        fitted = self._known_model()
        if horizon is not None and (horizon != int(horizon) or horizon < 1):
            raise ValueError(f"horizon must be a whole number of at least 1, got {horizon!r}")
        return [
            fitted.model.ahead(one.x, np.ascontiguousarray(one.u[: len(one.x) - 1]), np.diff(one.t), horizon)
            for one in data
        ]

    def plot(self, x: Any, t: Any = None, u: Any = None, horizon: int | None = None) -> Any:
        """
        Draws samples and what the equations make of them.

        Parameters
        ----------
        x, t, u, horizon
            As in `compare`.

        Returns
        -------
        matplotlib.figure.Figure
        """
        fitted, data = self._judged(x, t, None, u)
        return _show.plot(
            fitted.names.states, [one.t for one in data], [one.x for one in data], self._ahead(data, horizon)
        )


def _r2(true: Array, predicted: Array) -> float:
    left = ((true - predicted) ** 2).sum(axis=0)
    total = ((true - true.mean(axis=0)) ** 2).sum(axis=0)
    # A derivative that never changes is explained wholly or not at all.
    each = np.where(total > 0.0, 1.0 - left / np.where(total > 0.0, total, 1.0), np.where(left > 0.0, 0.0, 1.0))
    return float(each.mean())
