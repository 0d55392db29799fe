"""Logs in place of an environment."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from . import _sindyna
from ._data import is_frame, is_list, trajectories


class Log:
    """Samples and inputs of a system that is not at hand."""

    def __init__(self, data: Any, inputs: Any, dt: float | None, names: Sequence[str] | None) -> None:
        given = None if inputs is None else [str(name) for name in inputs]
        framed = is_frame(data) or (is_list(data) and is_frame(data[0]))
        if framed:
            if not given:
                raise ValueError("inputs must name the columns of the data frame that are inputs")
            x, u, controls = data, None, given
        elif isinstance(data, (tuple, list)) and len(data) == 2:
            (x, u), controls = data, None
        else:
            raise TypeError("data must be (samples, inputs) or a data frame")
        if dt is None or not (np.isfinite(dt) and dt > 0.0):
            raise ValueError(f"dt, the seconds from sample to sample, must be finite and above 0, got {dt}")
        self.dt = float(dt)
        self.episodes = trajectories(x, self.dt, u, None, default_dt=self.dt, controls=controls)
        m, k = self.episodes[0].x.shape[1], self.episodes[0].u.shape[1]
        if k == 0:
            raise ValueError("there are no inputs, so there is nothing to control")
        first = x[0] if is_list(x) else x
        columns = [str(c) for c in first.columns if str(c) not in (given or [])] if framed else None
        self.names = [str(name) for name in names or columns or [f"x{i}" for i in range(m)]]
        self.inputs = given or (["u"] if k == 1 else [f"u{i}" for i in range(k)])
        every = [*self.names, *self.inputs]
        if (
            len(self.names) != m
            or len(self.inputs) != k
            or len(set(every)) != m + k
            or not all(n.isidentifier() for n in every)
        ):
            raise ValueError(f"{m} samples and {k} inputs need different names of letters, digits and _, got {every}")
        u = np.vstack([one.u for one in self.episodes])
        self.bounds = [(None, None)] * m
        ranges = (
            [inputs[name] for name in given]
            if isinstance(inputs, Mapping) and given
            else list(zip(u.min(axis=0), u.max(axis=0), strict=True))
        )
        self.low, self.high = ([float(ends[i]) for ends in ranges] for i in (0, 1))
        for name, low, high, values in zip(self.inputs, self.low, self.high, u.T, strict=True):
            if not low < high or values.min() < low or values.max() > high:
                raise ValueError(
                    f"{name} must go from low to high and hold what the log has, {values.min()} to {values.max()}; got {low} to {high}"
                )

    def system(self, dt: float, max_steps: int) -> dict[str, Any]:
        """What is declared before anything is recognised: every sampled value is a state."""
        return {
            "bounds": self.bounds,
            "states": [{"seen": [i], "angle": False, "rate_of": None} for i in range(len(self.names))],
            "actions": {"box": {"low": self.low, "high": self.high}},
            "float32": False,
            "dt": dt,
            "max_steps": max_steps,
            "threshold": None,
        }

    def data(self, max_steps: int) -> _sindyna.Data:
        """The log as steps without rewards."""
        episodes = [
            (
                np.ascontiguousarray(one.x),
                np.ascontiguousarray(one.u[: len(one.x) - 1]),
                np.zeros(len(one.x) - 1),
                "cut",
            )
            for one in self.episodes
        ]
        return _sindyna.Data(json.dumps(self.system(self.dt, max_steps)), episodes)
