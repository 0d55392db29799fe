"""Tasks that a file describes, the same that the command reads: their controllers, and what was learned as an environment."""

from __future__ import annotations

import base64
import json
import os
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from . import _sindyna
from ._controller import Controller
from ._data import is_frame


def of_file(
    task_file: str | os.PathLike[str],
    data: Any,
    model: str | os.PathLike[str] | None,
    seed: int,
    settings: Sequence[str],
    max_real_steps: int | None,
) -> Controller:
    """A controller for the task in a file: on its own simulator, on a log, or in what was identified before."""
    if data is not None and model is not None:
        raise ValueError("data are identified, a model was identified before: give one of them")
    with tempfile.TemporaryDirectory() as folder:
        logs = _logs(data, Path(folder))
        known = None if model is None else os.fspath(model)
        outcome, files, names, dt = _sindyna.train_file(
            os.fspath(task_file), logs, known, seed, list(settings), max_real_steps
        )
    states, inputs, observed = names
    summary, found, policy = json.loads(outcome.summary), outcome.identified, outcome.policy
    return Controller(
        {
            "system": None,
            "observed": observed,
            "states": states,
            "inputs": inputs,
            "task": {"dt": dt, "files": {name: bytes(content).decode("utf-8") for name, content in files}},
            "told": {"reward": None, "terminated": None},
            "ends_by_function": False,
            "first": 0,
            "shape": None,
            "model": None if found is None else json.loads(found[0].to_json()),
            "account": None if found is None else json.loads(found[1]),
            "summary": summary,
            "policy": None if policy is None else base64.b64encode(policy.to_bytes()).decode("ascii"),
            "resets": summary["real_episodes"],
            "notes": [],
        }
    )


def _logs(data: Any, folder: Path) -> list[str]:
    """Files of logs: those named, or one in ``folder`` with the rows of a data frame."""
    if data is None:
        return []
    if is_frame(data):
        path = folder / "data.csv"
        data.to_csv(path, index=data.index.name is not None)
        return [str(path)]
    named = [data] if isinstance(data, (str, os.PathLike)) else data
    if not isinstance(named, (list, tuple)) or not all(isinstance(path, (str, os.PathLike)) for path in named):
        raise TypeError(
            "with a task file, data are the path of a log, a list of paths, or a data frame with its states and inputs as columns"
        )
    return [os.fspath(path) for path in named]
