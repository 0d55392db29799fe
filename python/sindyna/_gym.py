"""Gymnasium's environments as plain arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _sindyna

Array = npt.NDArray[np.float64]

#: Observed values, at most: equations for more are never found.
MOST_VALUES = 64

#: Numbered actions that lie on one line: to one side, to the other, and nothing between.
FEW_ACTIONS = 3


def made(env: Any) -> Any:
    """The environment itself, or the one that Gymnasium knows by this name."""
    if not isinstance(env, str):
        if not (hasattr(env, "observation_space") and hasattr(env, "step")):
            raise TypeError(f"env must be a gymnasium.Env or the name of one, got {type(env).__name__}")
        return env
    try:
        import gymnasium
    except ImportError as error:
        raise ImportError("environments by name need Gymnasium: pip install 'gymnasium[classic-control]'") from error
    return gymnasium.make(env)


class Plain:
    """
    An environment whose observations, actions and rewards are plain numbers.

    Actions are handed over as float64, so that what is recorded is what was applied.
    """

    def __init__(self, env: Any, controls: Sequence[Sequence[float]] | None = None) -> None:
        self.env = env
        seen, done = env.observation_space, env.action_space
        if not hasattr(seen, "low"):
            raise TypeError(
                f"observations must be a Box, got {type(seen).__name__}: wrap the environment, "
                "for example in gymnasium.wrappers.FlattenObservation"
            )
        self.n_values = int(np.prod(seen.shape))
        if not 1 <= self.n_values <= MOST_VALUES:
            raise ValueError(
                f"observations must have 1 to {MOST_VALUES} values, got {self.n_values}: equations are found for states, not for images"
            )
        self.float32 = seen.dtype == np.float32
        low, high = np.ravel(seen.low).astype(float), np.ravel(seen.high).astype(float)
        # Some declare the largest number there is where they mean no bound.
        self.bounds = [
            (float(a) if abs(a) < 1e30 else None, float(b) if abs(b) < 1e30 else None)
            for a, b in zip(low, high, strict=True)
        ]
        self.first, self.shape = 0, None
        if hasattr(done, "n"):
            self.first = int(getattr(done, "start", 0))
            self.actions: dict[str, Any] = {"numbered": _controls(int(done.n), controls)}
        elif hasattr(done, "low"):
            if controls is not None:
                raise ValueError("controls are the inputs of numbered actions; these actions are real")
            low, high = np.ravel(done.low).astype(float), np.ravel(done.high).astype(float)
            if not (np.isfinite(low).all() and np.isfinite(high).all()):
                raise ValueError(
                    f"actions must have finite bounds, got {low} to {high}: wrap the environment in gymnasium.wrappers.RescaleAction"
                )
            self.shape = done.shape
            self.actions = {"box": {"low": low.tolist(), "high": high.tolist()}}
        else:
            raise TypeError(f"actions must be a Box or Discrete, got {type(done).__name__}")

    @property
    def is_random(self) -> bool:
        """Whether there are so many numbered actions that the first and the last do not tell what the others do."""
        return len(self.actions.get("numbered", ())) > FEW_ACTIONS

    def system(self, dt: float, max_steps: int) -> dict[str, Any]:
        """What is declared before any data are there: every observed value is a state."""
        return {
            "bounds": self.bounds,
            "states": [{"seen": [i], "angle": False, "rate_of": None} for i in range(self.n_values)],
            "actions": self.actions,
            "float32": bool(self.float32),
            "dt": dt,
            "max_steps": max_steps,
            "threshold": None,
        }

    def reset(self, seed: int) -> Array:
        """The first observation (m,) of an episode."""
        first, _ = self.env.reset(seed=seed)
        return self._values(first)

    def step(self, action: Array) -> tuple[Array, float, bool, bool]:
        """Observation (m,), reward, terminated and truncated after one step."""
        given: Any = self.first + int(action[0]) if self.shape is None else action.reshape(self.shape)
        observation, reward, terminated, truncated, _ = self.env.step(given)
        return self._values(observation), float(reward), bool(terminated), bool(truncated)

    def episode(self, policy: _sindyna.Policy, max_steps: int, seed: int) -> tuple[Array, Array, Array, str]:
        """Observations (T + 1, m), actions (T, values), rewards (T,) and the end of one episode of a policy."""
        observations, actions, rewards = [self.reset(seed)], [], []
        end = "truncated"
        for _ in range(max_steps):
            actions.append(policy.act(np.ascontiguousarray(observations[-1][None]))[0])
            observation, reward, terminated, truncated = self.step(actions[-1])
            observations.append(observation)
            rewards.append(reward)
            if terminated or truncated:
                end = "terminated" if terminated else "truncated"
                break
        return np.vstack(observations), np.vstack(actions), np.array(rewards), end

    def _values(self, observation: Any) -> Array:
        return np.asarray(observation, dtype=np.float64).reshape(-1)


def _controls(n: int, given: Sequence[Sequence[float]] | None) -> list[list[float]]:
    """Inputs of numbered actions: two or three push evenly from one side to the other; of more, each is an input of its own but the first."""
    if given is not None:
        rows = [[float(v) for v in np.ravel(row)] for row in given]
        if len(rows) != n or len({len(row) for row in rows}) != 1:
            raise ValueError(
                f"controls must have as many inputs for each of the {n} actions, got {len(rows)} rows: {rows}"
            )
        return rows
    if n <= FEW_ACTIONS:
        return [[float(v)] for v in np.linspace(-1.0, 1.0, n)]
    return [[float(i == j) for j in range(1, n)] for i in range(n)]


def intervals(env: Any) -> list[float]:
    """Sampling intervals [s] that an environment may have, the likeliest first."""
    bare = getattr(env, "unwrapped", env)
    told = [getattr(bare, "dt", None), getattr(bare, "tau", None)]
    frames = (getattr(bare, "metadata", None) or {}).get("render_fps")
    told.append(1.0 / frames if frames else None)
    found = [float(dt) for dt in told if isinstance(dt, (int, float, np.number)) and 0.0 < float(dt) < 1e6]
    return list(dict.fromkeys([*found, 1.0]))


def horizon(env: Any, given: int | None) -> int:
    """Steps after which an episode is cut off."""
    told = given if given is not None else getattr(getattr(env, "spec", None), "max_episode_steps", None)
    if told is None:
        raise ValueError("the environment has no maximum number of steps: give max_steps=")
    if int(told) != told or not 1 <= told <= 10_000_000:
        raise ValueError(f"max_steps must be a whole number of 1 to 10000000, got {told}")
    return int(told)
