"""Rewards and ends of episodes: formulas over people's names, or what data tell of them."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from itertools import combinations_with_replacement
from typing import Any

import numpy as np

from . import _sindyna
from ._formula import translated
from ._gym import Array
from ._trace import of_rows

#: Observations (T + 1, m), actions (T, values), rewards (T,) and the end of an episode.
Episode = tuple[Array, Array, Array, str]
Episodes = list[Episode]

#: A formula, or a function of (obs, action, next_obs), each with a row per step.
Reward = str | Callable[[Any, Any, Any], Any]
#: A condition, or a function of next_obs.
Ends = str | Callable[[Any], Any]
#: Functions that take the place of formulas.
Functions = tuple[Callable[[Any, Any, Any], Any] | None, Callable[[Any], Any] | None]

#: Residual of a reward that is explained, as a part of its spread; rounding of observations to float32 leaves 1e-7.
EXPLAINED = 1e-4

#: Steps more than terms that a reward is found from.
SPARE = 3


class Symbols:
    """The names that formulas of a task may hold, and the engine's symbols for them."""

    def __init__(
        self,
        observed: Sequence[str],
        states: Sequence[str],
        system: dict[str, Any],
        inputs: Sequence[str] | None = None,
    ) -> None:
        self.system = system
        actions = system["actions"]
        n_inputs = len(actions["box"]["low"]) if "box" in actions else len(actions["numbered"][0])
        self.inputs = list(inputs) if inputs else [f"u{i}" for i in range(n_inputs)] if n_inputs > 1 else ["u"]
        self.states, self.observed = list(states), list(observed)
        own: dict[str, str] = {}
        for i, (name, declared) in enumerate(zip(states, system["states"], strict=True)):
            own[name] = f"x{i}"
            if len(declared["seen"]) == 2:
                cosine, sine = declared["seen"]
                own |= {observed[cosine]: f"cos(x{i})", observed[sine]: f"sin(x{i})"}
        taken = sorted(set(own) & {*self.inputs, "terminated", "and", "or", "pi"})
        if taken:
            raise ValueError(f"observations cannot be called {', '.join(taken)}: that means something else in formulas")
        self.after = {f"next_{name}": symbol.replace("x", "next_x") for name, symbol in own.items()}
        controls = {name: f"u{i}" for i, name in enumerate(self.inputs)}
        self.words = {"and": "and", "or": "or", "pi": repr(float(np.pi))}
        self.all = {**own, **controls, **self.after, "terminated": "terminated", **self.words}

    def of_function(self, function: Any) -> str | None:
        """The formula of a reward that is a function, where it has one."""
        if "box" not in self.system["actions"]:
            return None
        return of_rows(function, self.observed, self.inputs, [f"next_{name}" for name in self.observed])

    def reward(self, text: str) -> str:
        """A reward over people's names as one over symbols."""
        return translated(text, self.all)

    def condition(self, text: str) -> str:
        """A condition on what is observed after a step."""
        return translated(text, {**self.after, **self.words})


def _candidates(symbols: Symbols, episodes: Episodes, after: bool) -> tuple[list[str], Array, Array]:
    """Names and values (T, F) of the terms that a reward may have, and the rewards (T,)."""
    rows, rewards = [], []
    declared = symbols.system["states"]
    for observations, actions, reward, end in episodes:
        states = _sindyna.states(json.dumps(symbols.system), observations)
        x = states[1:] if after else states[:-1]
        for i, state in enumerate(declared):
            if len(state["seen"]) == 2:
                x[:, i] = (x[:, i] + np.pi) % (2 * np.pi) - np.pi
        u = (
            actions
            if "box" in symbols.system["actions"]
            else np.array(symbols.system["actions"]["numbered"])[actions[:, 0].astype(int)]
        )
        ended = np.zeros(len(reward))
        ended[-1:] = end == "terminated"
        rows.append(np.hstack([x, u, ended[:, None]]))
        rewards.append(reward)
    z, target = np.vstack(rows), np.concatenate(rewards)
    prefix = "next_" if after else ""
    names = [prefix + name for name in symbols.states] + symbols.inputs
    values = {name: z[:, i] for i, name in enumerate(names)}
    terms = {"1": np.ones(len(z)), **values}
    for (a, first), (b, second) in combinations_with_replacement(values.items(), 2):
        terms[f"{a}^2" if a == b else f"{a}*{b}"] = first * second
    for name, state in zip(symbols.states, declared, strict=True):
        if state["angle"]:
            terms |= {
                f"cos({prefix}{name})": np.cos(values[prefix + name]),
                f"sin({prefix}{name})": np.sin(values[prefix + name]),
            }
    terms["terminated"] = z[:, -1]
    # What never changes is the constant again.
    kept = {name: v for name, v in terms.items() if name == "1" or np.ptp(v) > 0.0}
    return list(kept), np.column_stack(list(kept.values())), target


def identified(symbols: Symbols, episodes: Episodes) -> str:
    """
    The reward as a sparse formula over people's names: the fewest terms that leave nothing but rounding.

    Raises
    ------
    ValueError
        If no such formula explains the rewards.
    """
    best = np.inf
    for after in (False, True):
        names, terms, target = _candidates(symbols, episodes, after)
        spread = float(np.ptp(target)) or float(np.abs(target).max())
        if spread == 0.0:
            break
        scale = np.abs(terms).max(axis=0)
        rates = np.zeros_like(terms)
        rates[:, 0] = target
        settings = {
            "library": "identity",
            "solver": {"best_subset": {"max_size": 8}},
            "discrete": False,
            "order": 2,
            "dt": 1.0,
        }
        found = _sindyna.regress([(terms / scale, np.zeros((len(terms), 0)), rates)], settings)
        for step in json.loads(found.account())["report"]["equations"][0]["path"]:
            support = step["support"]
            if len(support) + SPARE > len(target):
                break
            coefficients = np.linalg.lstsq(terms[:, support], target, rcond=None)[0]
            left = float(np.sqrt(np.mean((target - terms[:, support] @ coefficients) ** 2))) / spread
            best = min(best, left)
            if support and left <= EXPLAINED:
                short = _rounded(coefficients, terms[:, support], target)
                parts = [_summand(float(c), names[j]) for c, j in zip(short, support, strict=True)]
                return " + ".join(parts).replace("+ -", "- ")
    if not np.isfinite(best):
        raise ValueError(
            "the reward was 0 in every step, so it cannot be identified: give reward= as a formula or as a function of (obs, action, next_obs)"
        )
    raise ValueError(
        f"no formula of few terms explains the rewards seen (the best leaves {100 * best:.2g} % of their spread): "
        f"give reward= as a formula over {', '.join(symbols.states + symbols.inputs)} and next_…, or as a function of (obs, action, next_obs), or collect more real_steps"
    )


def _rounded(coefficients: Any, terms: Array, target: Array) -> Any:
    """The coefficients with as few digits as explain the rewards as well as all of them."""
    left = np.linalg.norm(target - terms @ coefficients)
    for digits in range(1, 16):
        short = np.array([float(f"{c:.{digits - 1}e}") for c in coefficients])
        # Rounding of observations moves coefficients by about what it leaves.
        if np.linalg.norm(target - terms @ short) <= 2.0 * left:
            return short
    return coefficients


def _summand(coefficient: float, name: str) -> str:
    if name == "1":
        return f"{coefficient:.15g}"
    if abs(coefficient) == 1.0:
        return f"{'-' if coefficient < 0 else ''}{name}"
    return f"{coefficient:.15g}*{name}"


def endings(observed: Sequence[str], episodes: Episodes) -> str | None:
    """What was observed where episodes were terminated, for people; nothing if none was."""
    last = [o[-1] for o, _, _, end in episodes if end == "terminated"]
    if not last:
        return None
    rest = np.vstack([o[:-1] if end == "terminated" else o for o, _, _, end in episodes])
    ended = np.vstack(last)

    def told(i: int) -> str:
        ranges = [f"{v[:, i].min():.4g} to {v[:, i].max():.4g}" for v in (ended, rest)]
        return f"{observed[i]} was {ranges[0]} there, {ranges[1]} elsewhere"

    return "; ".join(told(i) for i in range(len(observed)))


def functions_of(
    symbols: Symbols, reward: Reward, terminated: Ends | None, first: int
) -> tuple[dict[str, str | None], Functions, str | None]:
    """Formulas over symbols, functions where there are none, and the reward as a formula for people, if it is one. Numbered actions begin at `first`."""
    told = reward if isinstance(reward, str) else symbols.of_function(reward)
    formulas = {
        "reward": "0" if told is None else symbols.reward(told),
        "terminated": symbols.condition(terminated) if isinstance(terminated, str) else None,
    }
    paid = None if isinstance(reward, str) or told is not None else _with_actions(reward, symbols.system, first)
    return formulas, (paid, terminated if callable(terminated) else None), told


def _with_actions(function: Callable[..., Any], system: dict[str, Any], first: int) -> Callable[..., Any]:
    """The function with actions as the environment has them."""
    if "box" in system["actions"]:
        return function
    return lambda obs, action, next_obs: function(obs, first + action[:, 0].astype(np.int64), next_obs)


def never_ends(reward: str | None, terminated: Any) -> bool:
    """Whether neither reward nor end depends on what is done."""
    if reward is None or terminated is not None:
        return False
    try:
        float(reward)
    except ValueError:
        return False
    return True
