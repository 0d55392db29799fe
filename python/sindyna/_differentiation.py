"""Derivatives of samples, for regressions as PySINDy makes them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from . import _sindyna
from ._data import Array, Trajectory, matrix, trajectories
from ._params import Parameters, whole


class Differentiation(Parameters):
    """How derivatives are estimated from samples."""

    def _differentiate(self, x: Array, t: Array, dt: float | None) -> tuple[Array, Array]:
        """Samples (T, n) as the library is to see them, and their derivatives. ``dt`` is none where samples are uneven."""
        raise NotImplementedError

    def __call__(self, x: Any, t: Any = 1.0) -> Array:
        """
        Derivatives of samples.

        Parameters
        ----------
        x : array (T,) or (T, n)
            Samples.
        t : float or array (T,)
            Sampling interval [s], or times [s].

        Returns
        -------
        array
            Derivatives, in the shape of ``x``.
        """
        (one,) = trajectories(x, t, None, None, default_dt=1.0, controls=None)
        found = self._differentiate(np.ascontiguousarray(one.x), one.t, one.dt)
        self.smoothed_x_, x_dot = (values.reshape(np.shape(x)) for values in found)
        return x_dot


def derivatives(method: Differentiation | Callable[..., Any] | None, one: Trajectory) -> tuple[Array, Array]:
    """Samples (T, n) as the library is to see them, and their derivatives by ``method``: ours, or a function of samples and times."""
    x = np.ascontiguousarray(one.x)
    if method is None or isinstance(method, Differentiation):
        return (method or FiniteDifference())._differentiate(x, one.t, one.dt)
    x_dot = matrix("what differentiation_method gives", method(x, one.t))
    if x_dot.shape != x.shape:
        raise ValueError(f"differentiation_method must give derivatives of shape {x.shape}, got {x_dot.shape}")
    return x, np.ascontiguousarray(x_dot)


def finite_order(method: Differentiation | Callable[..., Any] | None) -> int | None:
    """The order of finite differences; none of other methods."""
    if method is None:
        return 2
    return method._checked() if type(method) is FiniteDifference else None


class FiniteDifference(Differentiation):
    """
    Finite differences, with PySINDy's stencils and ends.

    Parameters
    ----------
    order : int
        Order of accuracy, from 1 to 12; only 2 for uneven samples.
    d : int
        Refused unless 1: the first derivative.
    axis : int
        Refused unless 0 or -2: rows are time.
    is_uniform : bool
        No effect: whether samples are even is seen from the times.
    drop_endpoints, periodic : bool
        Refused if true.

    Examples
    --------
    >>> import sindyna
    >>> sindyna.FiniteDifference(order=4)
    FiniteDifference(order=4)
    """

    def __init__(
        self,
        order: int = 2,
        d: int = 1,
        axis: int = 0,
        is_uniform: bool = False,
        drop_endpoints: bool = False,
        periodic: bool = False,
    ) -> None:
        whole("order", order, 1)
        whole("d", d, 1)
        self.order = order
        self.d = d
        self.axis = axis
        self.is_uniform = is_uniform
        self.drop_endpoints = drop_endpoints
        self.periodic = periodic

    def _checked(self) -> int:
        """The order, where nothing else is asked for."""
        for name, supported in (("d", (1,)), ("axis", (0, -2)), ("drop_endpoints", (False,)), ("periodic", (False,))):
            if getattr(self, name) not in supported:
                raise NotImplementedError(
                    f"FiniteDifference supports {name}={supported[0]} only, got {getattr(self, name)!r}"
                )
        return whole("order", self.order, 1)

    def _differentiate(self, x: Array, t: Array, dt: float | None) -> tuple[Array, Array]:
        order = self._checked()
        if dt is not None:
            return x, _sindyna.differentiate(x, dt, order)
        if order != 2:
            raise NotImplementedError(f"FiniteDifference of uneven samples has order 2, got order={order}")
        if len(x) < 3:
            raise ValueError(f"a trajectory of {len(x)} samples is too short, at least 3 are needed")
        return x, np.gradient(x, t, axis=0, edge_order=2)


class SmoothedFiniteDifference(Differentiation):
    """
    Savitzky-Golay smoothing, then finite differences of order 2; the library sees the smoothed samples.

    Parameters
    ----------
    smoother_kws : dict, optional
        ``window_length`` (odd, 11 by default) and ``polyorder`` (3); others are refused.
    save_smooth : bool
        Whether the library sees the smoothed samples, not those given.
    """

    def __init__(self, smoother_kws: dict[str, int] | None = None, save_smooth: bool = True) -> None:
        self.smoother_kws = smoother_kws
        self.save_smooth = save_smooth

    def _differentiate(self, x: Array, t: Array, dt: float | None) -> tuple[Array, Array]:
        settings: dict[str, Any] = {"window_length": 11, "polyorder": 3, **(self.smoother_kws or {})}
        unknown = set(settings) - {"window_length", "polyorder"}
        if unknown:
            raise NotImplementedError(
                f"smoother_kws supports window_length and polyorder, got {', '.join(sorted(unknown))}"
            )
        if dt is None:
            raise NotImplementedError(
                "SmoothedFiniteDifference needs evenly spaced samples; FiniteDifference(order=2) and the default optimizer do not"
            )
        window, degree = (
            whole("window_length", settings["window_length"], 1),
            whole("polyorder", settings["polyorder"], 0),
        )
        smoothed, x_dot = _sindyna.smoothed(x, dt, window, degree)
        return smoothed if self.save_smooth else x, x_dot
