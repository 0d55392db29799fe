"""Where episodes end, from the ends that were recorded."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from . import _sindyna
from ._gym import Array
from ._task import SPARE, Episode, Episodes, Symbols, endings


@dataclass(frozen=True)
class Box:
    """Where states are while an episode goes on."""

    #: The condition that ends one, over people's names.
    condition: str
    #: What tells it.
    note: str
    #: Numbers of states, and how far down and up they may go.
    limits: dict[int, tuple[float, float]]

    def holds(self, x: Array) -> Any:
        """Whether states (N, n) are in it."""
        return np.all([(x[:, i] >= low) & (x[:, i] <= high) for i, (low, high) in self.limits.items()], axis=0)


def identified(symbols: Symbols, episodes: Episodes) -> Box | None:
    """
    The box that states left whenever an episode was terminated, and never else. None if none was terminated.

    Raises
    ------
    ValueError
        If the data do not tell one such box.
    """
    seen = endings(symbols.observed, episodes)
    if seen is None:
        return None
    ended, rest = _states(symbols, episodes)
    low, high = rest.min(axis=0), rest.max(axis=0)
    beyond = (ended < low) | (ended > high)
    n = len(symbols.states)
    boxes: list[tuple[int, ...]] = []
    for size in range(1, n + 1):
        boxes = [some for some in combinations(range(n), size) if beyond[:, some].any(axis=1).all()]
        if boxes:
            break
    if not boxes:
        raise ValueError(
            f"episodes were terminated where no state was beyond what it was elsewhere: give terminated= as a condition or as a function of next_obs ({seen})"
        )
    # An end that several states explain tells of none of them.
    alone = beyond[:, boxes[0]].sum(axis=1) == 1
    sides = {i: _sides(ended[alone, i], rest[:, i]) for i in boxes[0]}
    n_sides = sum(len(one) for one in sides.values())
    if len(boxes) > 1 or len(ended) < n_sides + SPARE:
        several = " or ".join(" and ".join(symbols.states[i] for i in some) for some in boxes)
        raise ValueError(
            f"episodes were terminated, and the data do not determine where: {len(ended)} ends, where {several} left what was seen elsewhere. Collect more "
            f"real_steps, or give terminated=, a condition such as 'abs(next_{symbols.observed[0]}) > 1' or a function of next_obs ({seen})"
        )
    limits = {i: _limits(one) for i, one in sides.items()}
    condition = " or ".join(_condition(symbols.states[i], *ends) for i, ends in limits.items())
    return Box(condition, f"episodes end if {condition}: found from {len(ended)} ends ({seen})", limits)


def agrees(symbols: Symbols, box: Box, episode: Episode) -> bool:
    """Whether an episode ended where the box says, and nowhere else."""
    ended, rest = _states(symbols, [episode])
    return bool(box.holds(rest).all()) and not box.holds(ended).any()


def _states(symbols: Symbols, episodes: Episodes) -> tuple[Array, Array]:
    """States at ends, and all others; angles that are seen as cosine and sine between -pi and pi."""
    ended, rest = [], []
    for observations, _, _, end in episodes:
        x = _sindyna.states(json.dumps(symbols.system), observations)
        for i, state in enumerate(symbols.system["states"]):
            if len(state["seen"]) == 2:
                x[:, i] = (x[:, i] + np.pi) % (2 * np.pi) - np.pi
        cut = len(x) - (end == "terminated")
        rest.append(x[:cut])
        ended.append(x[cut:])
    return np.vstack(ended), np.vstack(rest)


def _sides(ended: Array, rest: Array) -> dict[str, tuple[float, float]]:
    """On which sides a state left its range, and between which values it ends there: the last that was inside, the first that was not."""
    sides = {}
    above, below = ended[ended > rest.max()], ended[ended < rest.min()]
    if len(above):
        sides[">"] = (float(rest.max()), float(above.min()))
    if len(below):
        sides["<"] = (float(below.max()), float(rest.min()))
    return sides


def _limits(sides: dict[str, tuple[float, float]]) -> tuple[float, float]:
    """How far down and up a state may go; as far on both sides if the data allow it."""
    if len(sides) == 2:
        (inside, outside), (other_outside, other_inside) = sides[">"], sides["<"]
        low, high = max(inside, -other_inside), min(outside, -other_outside)
        if 0.0 < low < high:
            limit = _round(low, high)
            return -limit, limit
    above = _round(*sides[">"]) if ">" in sides else math.inf
    return (-_round(-sides["<"][1], -sides["<"][0]) if "<" in sides else -math.inf), above


def _condition(name: str, low: float, high: float) -> str:
    if low == -high:
        return f"abs(next_{name}) > {high:.15g}"
    below = [f"next_{name} < {low:.15g}"] if math.isfinite(low) else []
    return " or ".join([*below, *([f"next_{name} > {high:.15g}"] if math.isfinite(high) else [])])


def _round(low: float, high: float) -> float:
    """The number with the fewest digits from one to below the other, the nearest to their middle: people end episodes at round numbers."""
    middle = 0.5 * (low + high)
    for digits in range(17):
        number = round(middle, digits - 1 - math.floor(math.log10(abs(middle) or 1.0)))
        if low <= number < high:
            return number
    return low
