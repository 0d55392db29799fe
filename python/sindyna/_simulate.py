"""States that follow the equations."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ._data import Array, matrix
from ._fit import Fitted
from ._optimizers import at_least_zero


def simulate(fitted: Fitted, intersample: str, x0: Any, t: Any, u: Any, rtol: float, atol: float) -> Array:
    """States (T, n) from a start on; see `SINDy.simulate`."""
    n, k = len(fitted.names.states), len(fitted.names.inputs)
    start = np.asarray(x0, dtype=np.float64).reshape(-1)
    if start.shape != (n,) or not np.isfinite(start).all():
        raise ValueError(f"x0 must be {n} finite numbers ({', '.join(fitted.names.states)}), got {x0!r}")
    steps = fitted.model.form != "continuous"
    times: Array
    if np.ndim(t) == 0:
        if not steps or int(t) != t or t < 1:
            raise ValueError(
                f"t must be times [s] of equations in continuous time, or a number of samples of others, got {t!r}"
            )
        times = np.arange(int(t), dtype=np.float64) * fitted.model.dt
    else:
        times = np.asarray(t, dtype=np.float64)
        if times.ndim != 1 or not len(times) or not np.isfinite(times).all() or (np.diff(times) <= 0).any():
            raise ValueError(f"t must be increasing, finite times (T,), got an array of shape {times.shape}")
    call = u if callable(u) else None
    if k and u is None:
        raise TypeError(f"the model has {k} inputs ({', '.join(fitted.names.inputs)}); give them as u")
    inputs = np.zeros((len(times), k))
    if call is None and u is not None:
        inputs = matrix("u", u)
        if inputs.shape[1] != k or len(inputs) not in (len(times), len(times) - 1):
            raise ValueError(f"u must have shape ({len(times)}, {k}), got {inputs.shape}")
        if intersample == "foh" and not steps and len(inputs) != len(times):
            raise ValueError(f"intersample='foh' needs an input for each of the {len(times)} times, got {len(inputs)}")
    if not steps:
        of_time: Callable[[float], list[float]] | None = None
        if call is not None:
            of_time = lambda s: np.asarray(call(s), dtype=np.float64).ravel().tolist()  # noqa: E731
        linear = intersample == "foh"
        return fitted.model.solve(
            start,
            times,
            np.ascontiguousarray(inputs),
            of_time,
            linear,
            at_least_zero("rtol", rtol),
            at_least_zero("atol", atol),
        )
    dt = fitted.model.dt
    if (np.abs(np.diff(times) - dt) > 1e-6 * dt).any():
        raise ValueError(
            f"these equations are stepped by {dt:g} s ({fitted.report.stepping}), so times must be {dt:g} s apart; or give their number"
        )
    if call is not None:
        inputs = np.array([np.asarray(call(s), dtype=np.float64).ravel() for s in times[:-1]]).reshape(
            len(times) - 1, -1
        )
        if len(inputs) and inputs.shape[1] != k:
            raise ValueError(f"u must give {k} numbers, got {inputs.shape[1]}")
        inputs = inputs.reshape(-1, k)
    return fitted.model.stepped(start, np.ascontiguousarray(inputs[: len(times) - 1]))
