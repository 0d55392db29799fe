"""Arrays, lists and data frames as trajectories."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _sindyna

Array = npt.NDArray[np.float64]

#: Differences between intervals that rounding of times makes.
_EVEN = 1e-6
#: Part of the intervals that must be alike for longer ones to be gaps between trajectories.
_MOST = 0.9


@dataclass(frozen=True)
class Trajectory:
    """One uninterrupted recording."""

    #: Times (T,) from 0 on [s].
    t: Array
    #: States (T, n).
    x: Array
    #: Inputs (T, k), or (T - 1, k) where they are held between samples.
    u: Array
    #: Derivatives (T, n), if they are known.
    x_dot: Array | None = None

    @cached_property
    def dt(self) -> float | None:
        """The sampling interval [s]; none where it varies."""
        if len(self.t) < 2:
            return None
        return _sindyna.interval(self.t, _EVEN)


def is_list(x: Any) -> bool:
    """Whether these are several trajectories."""
    return isinstance(x, (list, tuple)) and len(x) > 0 and (hasattr(x[0], "ndim") or is_frame(x[0]))


def is_frame(x: Any) -> bool:
    """Whether this is a data frame, without importing pandas."""
    return hasattr(x, "columns") and hasattr(x, "to_numpy")


def columns(x: Any) -> list[str] | None:
    """The names of a data frame's columns."""
    first = x[0] if is_list(x) else x
    return [str(name) for name in first.columns] if is_frame(first) else None


def matrix(name: str, values: Any) -> Array:
    """A float64 matrix, rows of time.

    Raises
    ------
    ValueError
        If it is not, or has a value that is not finite.
    """
    array: Array
    if type(values) is np.ndarray and values.dtype == np.float64:
        array = values
    else:
        try:
            raw = np.asarray(values.to_numpy() if is_frame(values) else values)
            if raw.dtype.kind == "c":
                raise ValueError("got complex ones")
            array = raw.astype(np.float64, copy=False)
        except (TypeError, ValueError) as error:
            raise ValueError(f"{name} must be an array of real numbers: {error}") from None
    if array.ndim == 1:
        array = array.reshape(-1, 1)
    if array.ndim != 2:
        raise ValueError(f"{name} must have shape (samples, signals), got {array.shape}")
    if not _sindyna.finite(array):
        row, column = np.argwhere(~np.isfinite(array))[0]
        raise ValueError(
            f"{name} is {array[row, column]} in row {row}, column {column}; leave such samples out and give their times, or interpolate"
        )
    return array


def _times(name: str, t: Any, n_rows: int) -> Array:
    if isinstance(t, (str, bytes)):
        raise ValueError(f"{name} must be a number or times, got {t!r}")
    array = np.asarray(t, dtype=np.float64)
    if array.ndim == 0:
        dt = float(array)
        if not (np.isfinite(dt) and dt > 0.0):
            raise ValueError(f"{name} must be finite and > 0 s as a sampling interval, got {dt}")
        return np.arange(n_rows, dtype=np.float64) * dt
    if array.ndim != 1 or len(array) != n_rows:
        raise ValueError(
            f"{name} must be a number or one time for each of the {n_rows} rows of x, got shape {array.shape}"
        )
    if not _sindyna.increasing(array):
        if not np.isfinite(array).all():
            raise ValueError(f"{name} is {array[~np.isfinite(array)][0]} in row {int(np.argmax(~np.isfinite(array)))}")
        row = int(np.argmax(np.diff(array) <= 0.0)) + 1
        raise ValueError(
            f"{name} must increase: {array[row]} s of row {row} does not come after {array[row - 1]} s; give several trajectories as a list"
        )
    return array - array[0] if len(array) else array


def _index_times(x: Any) -> Any:
    """The index of a data frame as times, where it is one."""
    index = getattr(x, "index", None)
    values = getattr(index, "to_numpy", lambda: None)()
    if values is None or values.dtype.kind not in "fmM":
        return None
    if values.dtype.kind == "f":
        return values
    return (values - values[0]) / np.timedelta64(1, "ns") * 1e-9


def trajectories(
    x: Any,
    t: Any,
    u: Any,
    x_dot: Any,
    *,
    default_dt: float,
    controls: int | list[str] | None,
    n_inputs: int | None = None,
) -> list[Trajectory]:
    """All trajectories, checked; the last columns of ``x`` may be inputs.

    Raises
    ------
    ValueError
        If shapes do not fit each other or values are not finite.
    """
    several = is_list(x)
    xs: Sequence[Any] = x if several else [x]
    if isinstance(x, (list, tuple)) and len(x) == 0:
        raise ValueError("x is empty: there are no samples")

    def each(name: str, values: Any) -> Sequence[Any]:
        if values is None:
            return [None] * len(xs)
        if not several:
            return [values]
        shared = name == "t" and (np.ndim(values) == 0 if not isinstance(values, (list, tuple)) else False)
        if shared or (name == "t" and isinstance(values, np.ndarray) and values.dtype != object):
            return [values] * len(xs)
        if not isinstance(values, (list, tuple)) or len(values) != len(xs):
            got = f"{len(values)}" if isinstance(values, (list, tuple)) else type(values).__name__
            raise ValueError(f"x is a list of {len(xs)} trajectories, so {name} must be a list of {len(xs)}, got {got}")
        missing = [i for i, value in enumerate(values) if value is None]
        if missing:
            raise ValueError(f"{name}[{missing[0]}] is None: give {name} for every trajectory, or for none")
        return values

    found = []
    for i, (one, time, inputs, rates) in enumerate(
        zip(xs, each("t", t), each("u", u), each("x_dot", x_dot), strict=True)
    ):
        label = (lambda name, i=i: f"{name}[{i}]") if several else (lambda name: name)
        states = matrix(label("x"), one)
        if len(states) == 0:
            raise ValueError(f"{label('x')} has no rows")
        if time is None:
            time = _index_times(one) if is_frame(one) else None
        times = _times(label("t"), default_dt if time is None else time, len(states))
        if controls:
            if inputs is not None:
                raise ValueError("inputs are given twice: by u, and by controls as columns of x")
            states, given = _split(one, states, controls)
        elif inputs is not None:
            given = matrix(label("u"), inputs)
        else:
            given = np.zeros((len(states), 0))
        if given.shape[1] and len(given) not in (len(states), len(states) - 1):
            raise ValueError(
                f"{label('u')} must have a row for each of the {len(states)} rows of {label('x')} (or one less), got {len(given)}"
            )
        derivatives = None if rates is None else matrix(label("x_dot"), rates)
        if derivatives is not None and derivatives.shape != states.shape:
            raise ValueError(
                f"{label('x_dot')} must have the shape of {label('x')}, {states.shape}, got {derivatives.shape}"
            )
        found.append(Trajectory(times, states, given, derivatives))
    for i, one in enumerate(found):
        if one.x.shape[1] != found[0].x.shape[1] or one.u.shape[1] != found[0].u.shape[1]:
            raise ValueError(
                f"trajectory {i} has {one.x.shape[1]} states and {one.u.shape[1]} inputs, trajectory 0 has {found[0].x.shape[1]} and {found[0].u.shape[1]}"
            )
    if n_inputs and u is None and not controls:
        raise TypeError(f"the model has {n_inputs} inputs; give them as u")
    if n_inputs is not None and found[0].u.shape[1] != n_inputs:
        raise ValueError(f"the model has {n_inputs} inputs, got {found[0].u.shape[1]}; give them as u")
    return found


def _split(x: Any, values: Array, controls: int | list[str]) -> tuple[Array, Array]:
    width = values.shape[1]
    if isinstance(controls, list):
        names = columns(x)
        if names is None:
            raise ValueError(
                f"controls={controls!r} are names of columns, so x must be a DataFrame; give their number for an array"
            )
        missing = [name for name in controls if name not in names]
        if missing:
            raise ValueError(f"x has no column {missing[0]!r}; columns: {', '.join(names)}")
        last = [names.index(name) for name in controls]
        first = [i for i in range(width) if i not in last]
        return values[:, first], values[:, last]
    if not 0 < controls < width:
        raise ValueError(f"controls={controls} columns of x are inputs, so x needs more columns than that, got {width}")
    return values[:, : width - controls], values[:, width - controls :]


def without_gaps(trajectory: Trajectory) -> list[Trajectory]:
    """A trajectory cut where samples are missing, if all others are evenly spaced: what cross-validation leaves of one.

    Intervals that are no whole multiple of the common one are no gaps.
    """
    if len(trajectory.t) < 4 or trajectory.dt is not None:
        return [trajectory]
    steps = np.diff(trajectory.t)
    usual = float(np.median(steps))
    even = np.abs(steps - usual) <= _EVEN * usual
    longer = steps > usual * (1.0 + _EVEN)
    if even.mean() < _MOST or not np.all(even | longer):
        return [trajectory]
    parts, first = [], 0
    for last in [*np.flatnonzero(longer), len(trajectory.t) - 1]:
        rows = slice(first, int(last) + 1)
        x_dot = None if trajectory.x_dot is None else trajectory.x_dot[rows]
        times = trajectory.t[rows]
        parts.append(replace(trajectory, t=times - times[0], x=trajectory.x[rows], u=trajectory.u[rows], x_dot=x_dot))
        first = int(last) + 1
    return parts
