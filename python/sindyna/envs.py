"""Learned equations, and the systems that come along, as environments of Gymnasium; stepped in batches by the engine.

Importing this module makes the systems that come along known to Gymnasium, as ``sindyna/Pendulum-v0`` and so on;
``gymnasium.make("sindyna.envs:sindyna/Pendulum-v0")`` imports it by itself.
"""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from . import _sindyna

#: Our systems by Gymnasium's names for ours.
BUILTIN = {
    "Pendulum-v0": "pendulum",
    "CartPole-v0": "cart-pole",
    "MountainCarContinuous-v0": "mountain-car",
    "InvertedPendulum-v0": "inverted-pendulum",
    "CartPoleSwingUp-v0": "cart-pole-swing-up",
}


class _Spaces:
    """Spaces of a batch, and actions as the engine takes them."""

    def __init__(self, batch: _sindyna.Batch, first: int, shape: tuple[int, ...] | None) -> None:
        self.dtype: Any = np.float32 if batch.float32 else np.float64
        low, high = np.array(batch.bounds, dtype=np.float64).T
        self.observation = spaces.Box(low.astype(self.dtype), high.astype(self.dtype), dtype=self.dtype)
        bounds = batch.action_bounds
        if bounds is None:
            self.first = first
            self.action: Any = spaces.Discrete(batch.n_actions, start=first)
        else:
            self.first = 0
            ends = [np.array(end, dtype=np.float32).reshape(shape or -1) for end in bounds]
            self.action = spaces.Box(*ends, dtype=np.float32)

    def actions(self, given: Any, copies: int) -> Any:
        return np.ascontiguousarray(np.asarray(given, dtype=np.float64).reshape(copies, -1) - self.first)

    def observed(self, values: Any) -> Any:
        return values.astype(self.dtype, copy=False)


def _entropy() -> int:
    """A seed where none is given."""
    return int(np.random.SeedSequence().generate_state(1)[0])


class BatchEnv(gymnasium.Env[Any, Any]):
    """One copy of a system that the engine steps."""

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012

    def __init__(self, batch: _sindyna.Batch, first: int = 0, shape: tuple[int, ...] | None = None) -> None:
        self._batch, self._spaces, self._begun = batch, _Spaces(batch, first, shape), False
        self.observation_space, self.action_space = self._spaces.observation, self._spaces.action
        self.dt = batch.dt
        self.metadata = {"render_modes": [], "render_fps": max(1, round(1.0 / batch.dt))}

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """The first observation of an episode; ``options={"state": x}`` begins it in the state x (n,)."""
        super().reset(seed=seed)
        if seed is None and not self._begun:
            seed = _entropy()
        self._begun = True
        shown = self._batch.reset(seed)
        if options and "state" in options:
            shown = self._batch.reset_to(np.asarray(options["state"], dtype=np.float64).reshape(1, -1))
        return self._spaces.observed(shown)[0], {"state": self.state}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Observation (m,), reward, terminated, truncated and info with the state; ``diverged`` where the equations left the finite numbers."""
        shown, rewards, terminated, truncated, diverged = self._batch.step(self._spaces.actions(action, 1), False)
        info = {"state": self.state, **({"diverged": True} if diverged[0] else {})}
        return self._spaces.observed(shown)[0], float(rewards[0]), bool(terminated[0]), bool(truncated[0]), info

    @property
    def state(self) -> Any:
        """The state (n,), which observations may show otherwise."""
        return self._batch.states()[0]


class BatchVectorEnv(VectorEnv[Any, Any, Any]):
    """Copies of a system that the engine steps side by side; the step after the end of an episode begins the next one."""

    def __init__(
        self, batch: _sindyna.Batch, num_envs: int, first: int = 0, shape: tuple[int, ...] | None = None
    ) -> None:
        self._batch, self._spaces, self._begun = batch, _Spaces(batch, first, shape), False
        self.num_envs = num_envs
        self.single_observation_space, self.single_action_space = self._spaces.observation, self._spaces.action
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """First observations (N, m); copy i draws from the seed ``seed + i``. ``options={"reset_mask": flags}`` resets some of them alone."""
        if isinstance(seed, (list, tuple)):
            raise ValueError("seed must be one number: copy i draws from seed + i")
        if seed is None and not self._begun:
            seed = _entropy()
        self._begun = True
        which = None if not options or "reset_mask" not in options else [bool(flag) for flag in options["reset_mask"]]
        return self._spaces.observed(self._batch.reset(seed, which)), {}

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Observations (N, m), rewards, terminated, truncated (N,)."""
        shown, rewards, terminated, truncated, diverged = self._batch.step(
            self._spaces.actions(actions, self.num_envs), True
        )
        info = {"diverged": diverged} if diverged.any() else {}
        return self._spaces.observed(shown), rewards, terminated, truncated, info


class BuiltinEnv(BatchEnv):
    """A system that comes along."""

    def __init__(self, name: str, render_mode: None = None) -> None:
        super().__init__(_sindyna.builtin(name, 1))
        self.render_mode = render_mode


class BuiltinVectorEnv(BatchVectorEnv):
    """Copies of a system that comes along."""

    def __init__(
        self, name: str, num_envs: int = 1, max_episode_steps: int | None = None, render_mode: None = None
    ) -> None:
        batch = _sindyna.builtin(name, num_envs)
        if max_episode_steps not in (None, batch.max_steps):
            raise ValueError(f"max_episode_steps of {name} is {batch.max_steps}, got {max_episode_steps}")
        super().__init__(batch, num_envs)
        self.render_mode = render_mode


for _name, _system in BUILTIN.items():
    gymnasium.register(
        f"sindyna/{_name}",
        entry_point="sindyna.envs:BuiltinEnv",
        vector_entry_point="sindyna.envs:BuiltinVectorEnv",
        max_episode_steps=_sindyna.builtin(_system, 1).max_steps,
        kwargs={"name": _system},
    )
