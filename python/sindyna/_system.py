"""Systems of one's own, written as equations."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from . import _sindyna
from ._formula import translated
from ._task import Ends, Reward, Symbols, functions_of


class System:
    """
    A system written as equations, with a task: an environment to be learned, or to train others in.

    Whoever learns it is told what is observed, not the equations.

    Parameters
    ----------
    states : list of str
        Names of the states.
    equations : dict
        ``{"th": "w", "w": "-9.81*sin(th) + u"}``: the rate of each state; its next value for a map.
    inputs : dict
        ``{"u": (-2, 2)}``: names of the inputs and their ranges.
    reward : str or callable
        The reward of a step: a formula over states, inputs, states after the step (``next_th``) and ``terminated``, or a function of arrays
        (obs, action, next_obs).
    start : dict
        ``{"th": (-0.1, 0.1)}``: where states begin; at 0 by default.
    dt : float
        Seconds from step to step, in which inputs are held.
    terminated : str or callable, optional
        Which states end an episode, as a condition such as ``abs(next_th) > 1`` or a function of next_obs.
    angles : list of str, optional
        States that are angles; they are observed as ``cos_th`` and ``sin_th``.
    max_steps : int
        Steps of an episode.
    map : bool
        Whether the equations give next values, not rates.

    Examples
    --------
    >>> import sindyna
    >>> cart = sindyna.System(["x", "v"], {"x": "v", "v": "2*u - 0.5*v"}, {"u": (-1, 1)}, "-x^2 - 0.1*u^2", {"x": (-1, 1)}, dt=0.1)
    >>> controller = sindyna.learn(cart, evaluation_episodes=10)
    >>> controller.equations
    ["(x)' = 1.000000 v", "(v)' = -0.500000 v + 2.000000 u"]
    """

    def __init__(
        self,
        states: Sequence[str],
        equations: Mapping[str, str],
        inputs: Mapping[str, tuple[float, float]],
        reward: Reward,
        start: Mapping[str, tuple[float, float]] | None = None,
        *,
        dt: float,
        terminated: Ends | None = None,
        angles: Sequence[str] = (),
        max_steps: int = 200,
        map: bool = False,
    ) -> None:
        self.states = [str(name) for name in states]
        names = [*self.states, *inputs]
        bad = [name for name in names if not name.isidentifier() or names.count(name) > 1]
        if bad or not self.states or not inputs:
            raise ValueError(
                f"states and inputs need different names of letters, digits and _, and there must be some; got {names}"
            )
        for what, given in (("equations", equations), ("start", start or {}), ("angles", dict.fromkeys(angles))):
            unknown = set(given) - set(self.states)
            if unknown or (what == "equations" and len(given) != len(self.states)):
                raise ValueError(f"{what} must be of the states {self.states}, got {list(given)}")
        low, high = ([float(ends[i]) for ends in inputs.values()] for i in (0, 1))
        if not all(a < b for a, b in zip(low, high, strict=True)):
            raise ValueError(f"inputs must go from low to high, got {dict(inputs)}")
        self.dt, self.max_steps, self.angles = float(dt), int(max_steps), list(angles)
        self.reward, self.terminated, self.inputs = reward, terminated, list(inputs)
        self.names: list[str] = []
        seen: list[dict[str, Any]] = []
        for name in self.states:
            values = [f"cos_{name}", f"sin_{name}"] if name in self.angles else [name]
            at = list(range(len(self.names), len(self.names) + len(values)))
            self.names += values
            seen.append({"seen": at, "angle": name in self.angles, "rate_of": None})
        self._declared = {
            "bounds": [(None, None)] * len(self.names),
            "states": seen,
            "actions": {"box": {"low": low, "high": high}},
            "float32": False,
            "dt": self.dt,
            "max_steps": self.max_steps,
            "threshold": None,
        }
        symbols = Symbols(self.names, self.states, self._declared, self.inputs)
        variables = {name: symbols.all[name] for name in names}
        self._equations = [translated(equations[name], variables) for name in self.states]
        self._map = bool(map)
        self._starts = [tuple(float(v) for v in (start or {}).get(name, (0.0, 0.0))) for name in self.states]
        formulas, self._functions, _ = functions_of(symbols, reward, terminated, first=0)
        self._task = {"starts": self._starts, **formulas}
        # What cannot be read is told here, not later.
        self._batch(1)

    def _batch(self, copies: int) -> _sindyna.Batch:
        return _sindyna.written(
            json.dumps(self._declared), json.dumps(self._task), self._equations, self._map, copies, *self._functions
        )

    def env(self) -> Any:
        """
        The system as a `gymnasium.Env`, which needs Gymnasium.

        Returns
        -------
        gymnasium.Env
        """
        from .envs import BatchEnv

        return BatchEnv(self._batch(1))

    def vector_env(self, num_envs: int) -> Any:
        """
        Copies of `env`, stepped side by side.

        Parameters
        ----------
        num_envs : int
            How many.

        Returns
        -------
        gymnasium.vector.VectorEnv
        """
        from .envs import BatchVectorEnv

        return BatchVectorEnv(self._batch(num_envs), num_envs)
