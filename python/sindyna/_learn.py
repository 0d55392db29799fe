"""From a system to a controller: steps, equations, a policy trained inside them, and its returns on the system."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from . import _gym, _log, _sindyna, _task_file
from ._controller import Controller
from ._system import System
from ._task import Ends, Reward, Symbols
from ._trained import Wanted, trained


def learn(
    env: Any = None,
    *,
    task_file: str | os.PathLike[str] | None = None,
    data: Any = None,
    model: str | os.PathLike[str] | None = None,
    inputs: Sequence[str] | Mapping[str, tuple[float, float]] | None = None,
    real_steps: int = 10,
    seed: int = 0,
    reward: Reward | None = None,
    terminated: Ends | None = None,
    names: Sequence[str] | None = None,
    angles: Sequence[Any] | None = None,
    rates: Mapping[str, str] | None = None,
    controls: Sequence[Sequence[float]] | None = None,
    dt: float | None = None,
    start: Mapping[str, tuple[float, float]] | None = None,
    start_resets: int = 20,
    max_steps: int | None = None,
    max_real_steps: int | None = None,
    threshold: float | None = None,
    evaluation_episodes: int = 100,
    settings: Sequence[str] = (),
) -> Controller:
    """
    Learns to control a system from a few steps of it: an environment, what a task file describes, or a log.

    The environment is stepped `real_steps` times; equations of motion are identified; a policy is trained inside them; its returns on the
    environment are predicted, and measured. Where something speaks against the equations, more steps are made, up to `max_real_steps`.

    Parameters
    ----------
    env : gymnasium.Env, str or System, optional
        The environment, or its name. Observations are a Box that shows all of the state, actions a Box or Discrete.
    task_file : str or path, optional
        A file that describes the task and, unless there are data, its simulator: the one that the command `sindyna train --task-file` takes. It says what is paid, when episodes end,
        names, starts and bounds, so none of these is given here.
    data : tuple of arrays, or DataFrame, optional
        A log in place of an environment: samples (T, m) and inputs (T, k) or (T - 1, k), held from sample to sample, or lists of these; or a
        data frame whose columns ``inputs`` are inputs. Needs `dt`, `reward` and `max_steps`; `start` where episodes begin elsewhere than the log. With a task
        file the path of a CSV file, a list of paths, or a data frame.
    model : str or path, optional
        With a task file: a directory that `sindyna identify` left, in whose equations the policy is trained.
    inputs : list or dict, optional
        Of a log: names of its inputs, or names and ranges ``{"u": (-2, 2)}``; the ranges of the log by default.
    real_steps : int
        Steps before anything is learned.
    seed : int
        Seed of everything random; with the same seed the result is the same.
    reward : str or callable, optional
        The reward of a step: a formula over what is observed (``x0``), after the step (``next_x0``), the action (``u``) and ``terminated``; or a function
        of arrays (obs, action, next_obs), a row per step. Found from the data where none is given; refused where a few terms do not explain it.
    terminated : str or callable, optional
        Which observations end an episode for good, as a condition such as ``abs(next_x2) > 0.2`` or a function of next_obs (N, m). By default none
        does; where episodes were terminated, a box of states that all ends left and nothing else, if the data tell one. An episode of the policy then has to end as
        the box says; else it is found again with more episodes.
    names : list of str, optional
        Names of the observed values; ``x0, x1, …`` by default.
    angles : list, optional
        Observed values that are angles [rad], by name or number; pairs are cosine and sine of one. Pairs are recognised.
    rates : dict, optional
        ``{"w": "angle"}``: w is the rate of angle. Recognised where nothing is given.
    controls : array (actions, k), optional
        Inputs of numbered actions; by default two or three push evenly from -1 to 1, more are inputs of their own.
    dt : float, optional
        Seconds from step to step; as the environment tells, or as rates tell.
    start : dict, optional
        ``{"x": (low, high)}``: where states begin. What is not given is estimated from resets.
    start_resets : int
        Resets from which start states are estimated.
    max_steps : int, optional
        Steps of an episode; as the environment tells by default.
    max_real_steps : int, optional
        Steps at most in all; as many as it takes by default.
    threshold : float, optional
        Mean return from which the task counts as solved; as the environment tells by default. The learner is not told.
    evaluation_episodes : int
        Episodes of the evaluation.
    settings : list of str
        Settings of the command `sindyna train`, such as ``"sac.hidden=[32, 32]"``.

    Returns
    -------
    Controller

    Raises
    ------
    ValueError
        If no equations are found, or the reward cannot be told from the data.
    """
    if task_file is not None:
        own = {"env": env, "inputs": inputs, "reward": reward, "terminated": terminated, "names": names, "angles": angles, "rates": rates, "controls": controls, "dt": dt, "start": start, "max_steps": max_steps, "threshold": threshold}  # fmt: skip
        said = [name for name, value in own.items() if value is not None]
        if said:
            raise ValueError(f"a task file says all of the task: {', '.join(said)} cannot be given beside it")
        chosen = [f"evaluation_episodes={_whole('evaluation_episodes', evaluation_episodes, 1)}", *settings]
        if data is None and model is None:
            chosen.insert(0, f"warmup.rollout_len={_whole('real_steps', real_steps, 1)}")
        most = None if max_real_steps is None else _whole("max_real_steps", max_real_steps, 1)
        return _task_file.of_file(task_file, data, model, _whole("seed", seed, 0), chosen, most)
    if model is not None:
        raise ValueError("an identified model needs a task_file, which defines the reward")
    if (env is None) == (data is None):
        raise ValueError("learn needs an environment, data or a task_file, and not both")
    if data is not None:
        log = _log.Log(data, inputs, dt, names)
        chosen = [*settings, f"evaluation_episodes={_whole('evaluation_episodes', evaluation_episodes, 1)}"]
        return _of_log(log, (reward, terminated), (angles, rates), start, max_steps, _whole("seed", seed, 0), chosen)
    if isinstance(env, System):
        reward, terminated = reward or env.reward, terminated or env.terminated
        angles = [(f"cos_{name}", f"sin_{name}") for name in env.angles] if angles is None else angles
        names, max_steps, env = names or env.names, max_steps or env.max_steps, env.env()
    made = _gym.made(env)
    plain = _gym.Plain(made, controls)
    observed = _observed(names, plain.n_values)
    seed, real_steps = _whole("seed", seed, 0), _whole("real_steps", real_steps, 1)
    length = _gym.horizon(made, max_steps)
    candidates = [_interval(dt)] if dt is not None else _gym.intervals(made)
    data = _sindyna.collect(plain, json.dumps(plain.system(candidates[0], length)), real_steps, seed, plain.is_random)
    system, states, notes = _recognised(plain, data, observed, (candidates, length), angles, rates)
    told = threshold if threshold is not None else getattr(getattr(made, "spec", None), "reward_threshold", None)
    system["threshold"] = None if told is None else float(told)
    data = _sindyna.Data(json.dumps(system), data.episodes())
    symbols = Symbols(observed, states, system)
    given = {} if start is None else dict(start)
    resets = start_resets if set(states) - set(given) else 0
    starts = _starts(plain, system, states, data, given, _whole("start_resets", resets, 0), seed)
    chosen = [f"evaluation_episodes={_whole('evaluation_episodes', evaluation_episodes, 1)}"]
    chosen += [*(["warmup.explorer=random"] if plain.is_random else []), *settings]
    most = None if max_real_steps is None else _whole("max_real_steps", max_real_steps, real_steps)
    wanted = Wanted(symbols, starts, reward, terminated, plain, seed, chosen, most, notes, resets)
    return trained(wanted, data)


def _of_log(
    log: _log.Log,
    task: tuple[Reward | None, Ends | None],
    known: tuple[Sequence[Any] | None, Mapping[str, str] | None],
    start: Mapping[str, tuple[float, float]] | None,
    max_steps: int | None,
    seed: int,
    chosen: list[str],
) -> Controller:
    """A controller from a log alone."""
    (reward, terminated), (angles, rates) = task, known
    if reward is None or max_steps is None:
        raise ValueError("a log defines neither reward nor length of an episode: give reward= and max_steps=")
    length = _whole("max_steps", max_steps, 1)
    system, states, notes = _recognised(log, log.data(length), log.names, ([log.dt], length), angles, rates)
    data = _sindyna.Data(json.dumps(system), log.data(length).episodes())
    symbols = Symbols(log.names, states, system, log.inputs)
    starts = _starts(None, system, states, data, {} if start is None else dict(start), 0, seed)
    return trained(Wanted(symbols, starts, reward, terminated, None, seed, chosen, None, notes), data)


def _observed(names: Sequence[str] | None, n: int) -> list[str]:
    if names is None:
        return [f"x{i}" for i in range(n)]
    given = [str(name) for name in names]
    if len(given) != n or len(set(given)) != n or not all(name.isidentifier() for name in given):
        raise ValueError(f"names must be {n} different names of letters, digits and _, got {given}")
    return given


def _whole(name: str, value: Any, least: int) -> int:
    if isinstance(value, bool) or int(value) != value or value < least:
        raise ValueError(f"{name} must be a whole number of at least {least}, got {value!r}")
    return int(value)


def _interval(dt: float) -> float:
    if not (np.isfinite(dt) and dt > 0.0):
        raise ValueError(f"dt must be finite and above 0, got {dt}")
    return float(dt)


def _named(value: Any, observed: Sequence[str]) -> str:
    """The name of an observed value that is given by name or number."""
    if isinstance(value, (int, np.integer)) and 0 <= value < len(observed):
        return observed[int(value)]
    if value in observed:
        return str(value)
    raise ValueError(f"no observed value is called {value!r}; there are {', '.join(observed)}")


def _recognised(
    plain: Any,
    data: _sindyna.Data,
    observed: list[str],
    timing: tuple[list[float], int],
    angles: Sequence[Any] | None,
    rates: Mapping[str, str] | None,
) -> tuple[dict[str, Any], list[str], list[str]]:
    """The system with its states, their names, and what was decided: of several sampling intervals the one at which most states are rates of others."""
    intervals, length = timing
    pairs = [a for a in angles or [] if isinstance(a, (tuple, list))]
    single = [_named(a, observed) for a in angles or [] if not isinstance(a, (tuple, list))]
    circles = [(_named(cosine, observed), _named(sine, observed)) for cosine, sine in pairs] or None
    declared = None if rates is None else [(str(rate), str(of)) for rate, of in rates.items()]
    best: dict[str, Any] = {}
    for dt in intervals:
        told = json.loads(data.recognise(observed, dt, single, circles, declared))
        told["n_rates"] = sum(state["rate_of"] is not None for state in told["states"])
        if not best or told["n_rates"] > best["n_rates"]:
            best = {**told, "dt": dt}
    notes = list(best["notes"])
    if best["dt"] != intervals[0]:
        notes.append(
            f"a step is taken as {best['dt']:g} s, not {intervals[0]:.4g} s: only then is one observed value the rate of another"
        )
    named: list[str] = []
    for name in best["names"]:
        # Angles behind unnamed cosines and sines are called alike.
        free = (f"{name}{i}" if i > 1 else name for i in range(1, len(observed) + 2))
        named.append(next(one for one in free if one not in named))
    return {**plain.system(best["dt"], length), "states": best["states"]}, named, notes


def _starts(
    plain: Any,
    system: dict[str, Any],
    states: list[str],
    data: _sindyna.Data,
    given: dict[str, Any],
    resets: int,
    seed: int,
) -> dict[str, Any]:
    """Ranges in which states begin: as given, else those of resets, widened to be expected of a uniform distribution, with the number of these samples."""
    for name in given:
        if name not in states:
            raise ValueError(f"start: no state is called {name!r}; there are {', '.join(states)}")
    first = [observations[0] for observations, *_ in data.episodes()]
    draw = np.random.default_rng(seed)
    first += [plain.reset(int(draw.integers(2**31))) for _ in range(resets)]
    text = json.dumps(system)
    x = np.vstack([_sindyna.states(text, np.ascontiguousarray(o[None])) for o in first])
    low, high = x.min(axis=0), x.max(axis=0)
    wider = 0.5 * (high - low) * ((len(x) + 1) / max(len(x) - 1, 1) - 1.0)
    ranges: list[tuple[float, float]] = []
    samples: list[int | None] = []
    for i, (name, state) in enumerate(zip(states, system["states"], strict=True)):
        if name in given:
            least, most = (float(v) for v in given[name])
            if not (least <= most and np.isfinite([least, most]).all()):
                raise ValueError(f"start: {name} must begin within (low, high), both finite, got {given[name]}")
            ranges.append((least, most))
            samples.append(None)
            continue
        least, most = float(low[i] - wider[i]), float(high[i] + wider[i])
        if len(state["seen"]) == 2 and most - least > 2 * np.pi:
            least, most = -float(np.pi), float(np.pi)
        if len(state["seen"]) == 1:
            bound = system["bounds"][state["seen"][0]]
            least = least if bound[0] is None else max(least, bound[0])
            most = most if bound[1] is None else min(most, bound[1])
        ranges.append((least, most))
        samples.append(len(x))
    return {"starts": ranges, "samples": samples}
