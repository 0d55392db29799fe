"""A controller for a task on a system of which steps are known."""

from __future__ import annotations

import base64
import json
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from . import _ends, _sindyna
from ._controller import Controller
from ._task import SPARE, Ends, Functions, Reward, Symbols, functions_of, identified, never_ends


@dataclass(frozen=True)
class Wanted:
    """What a controller is trained for, and how."""

    symbols: Symbols
    starts: dict[str, Any]
    reward: Reward | None
    terminated: Ends | None
    #: The environment as plain arrays; None for a log.
    plain: Any
    seed: int
    settings: list[str]
    max_real_steps: int | None
    notes: list[str]
    #: Resets made for start states.
    resets: int = 0


@dataclass(frozen=True)
class Attempt:
    """What training came to, and for which task."""

    outcome: _sindyna.Outcome
    task: dict[str, Any]
    functions: Functions
    reward: str | None


def trained(wanted: Wanted, data: _sindyna.Data) -> Controller:
    """The controller, trained on what ``data`` tell and on as many more steps as it takes."""
    box = _ends.identified(wanted.symbols, data.episodes()) if wanted.terminated is None else None
    if box is None:
        return _controller(wanted, _attempt(wanted, data))
    if wanted.plain is None:
        found = replace(wanted, terminated=box.condition, notes=[*wanted.notes, box.note])
        return _controller(found, _attempt(found, data))
    draw = np.random.default_rng(wanted.seed)
    while True:
        found = replace(wanted, terminated=box.condition)
        policy = _attempt(found, data, evaluated=False).outcome.policy
        if policy is None:
            return _controller(found, _attempt(found, data))

        def episode(policy: _sindyna.Policy = policy) -> Any:
            return wanted.plain.episode(policy, wanted.symbols.system["max_steps"], int(draw.integers(2**31)))

        # Where the data never were, episodes may end, too.
        first = episode()
        if _ends.agrees(wanted.symbols, box, first):
            steps = len(first[1])
            note = f"{box.note}; an episode of the policy, {steps} steps, agrees with it"
            found = replace(found, notes=[*wanted.notes, note], resets=wanted.resets + 1)
            return _controller(found, _attempt(found, data), steps)
        more = [first, *(episode() for _ in range(SPARE))]
        data = _sindyna.Data(json.dumps(wanted.symbols.system), [*data.episodes(), *more])
        if wanted.max_real_steps is not None and data.n_steps > wanted.max_real_steps:
            raise ValueError(
                f"an episode of the policy ended otherwise than by {box.condition}, and max_real_steps is reached: give terminated="
            )
        again = _ends.identified(wanted.symbols, data.episodes())
        box = box if again is None else again


def _attempt(wanted: Wanted, data: _sindyna.Data, evaluated: bool = True) -> Attempt:
    """Trains for a task whose ends are known."""
    symbols, system, plain = wanted.symbols, json.dumps(wanted.symbols.system), wanted.plain
    found = identified(symbols, data.episodes()) if wanted.reward is None else wanted.reward
    if isinstance(found, str) and never_ends(found, wanted.terminated):
        raise ValueError(
            f"every step is paid {found}, and no episode was terminated: nothing can be learned. Give terminated=, or reward=, or collect more real_steps"
        )
    formulas, functions, told = functions_of(symbols, found, wanted.terminated, 0 if plain is None else plain.first)
    task = {**wanted.starts, **formulas}
    if plain is None:
        data = _sindyna.paid(system, json.dumps(task), data, *functions)
    outcome = _sindyna.train(
        system,
        json.dumps(task),
        data,
        wanted.seed,
        wanted.settings,
        wanted.max_real_steps,
        plain,
        *functions,
        evaluated=evaluated,
    )
    return Attempt(outcome, task, functions, told)


def _controller(wanted: Wanted, attempt: Attempt, confirmed: int = 0) -> Controller:
    """The controller of an attempt, before whose evaluation ``confirmed`` more steps were made."""
    symbols, plain, terminated = wanted.symbols, wanted.plain, wanted.terminated
    summary, known, policy = json.loads(attempt.outcome.summary), attempt.outcome.identified, attempt.outcome.policy
    summary["real_steps"] += confirmed
    shape = None if plain is None or plain.shape is None else list(plain.shape)
    return Controller(
        {
            "system": symbols.system,
            "observed": symbols.observed,
            "states": symbols.states,
            "inputs": symbols.inputs,
            "task": attempt.task,
            "told": {"reward": attempt.reward, "terminated": terminated if isinstance(terminated, str) else None},
            "ends_by_function": callable(terminated),
            "first": 0 if plain is None else plain.first,
            "shape": shape,
            "model": None if known is None else json.loads(known[0].to_json()),
            "account": None if known is None else json.loads(known[1]),
            "summary": summary,
            "policy": None if policy is None else base64.b64encode(policy.to_bytes()).decode("ascii"),
            "resets": summary["real_episodes"] + wanted.resets,
            "notes": wanted.notes,
        },
        attempt.functions,
    )
