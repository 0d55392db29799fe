"""What training hands over: equations, a policy, and what both are worth."""

from __future__ import annotations

import base64
import json
import os
from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from . import _show, _sindyna
from ._files import exported, written
from ._fit import Fitted
from ._formula import Names, OwnNames
from ._gym import Array
from ._report import Report

FORMAT = 1
KIND = "controller"

#: Files of a run that its task is made of.
FILES = ("task.toml", "model.xml")


class Interval(NamedTuple):
    """Where the mean return of the evaluation is predicted to be."""

    low: float
    high: float
    #: The value expected.
    mean: float
    #: Probability that the interval holds the mean return.
    level: float


class Policy:
    """The best action for what is observed, for one observation or many at once."""

    def __init__(self, inner: _sindyna.Policy, first: int = 0, shape: tuple[int, ...] | None = None) -> None:
        self._inner, self._first, self._shape = inner, first, shape

    def __call__(self, observation: Any) -> Any:
        """
        The best action.

        Parameters
        ----------
        observation : array (m,) or (N, m)
            One observation, or many.

        Returns
        -------
        array (k,) or (N, k), or int, or array (N,) of int
            Real actions in the shape of the environment's; numbers of actions where they are numbered.
        """
        values = np.asarray(observation, dtype=np.float64)
        m = self._inner.n_observations
        many = values.ndim == 2 and values.shape[1] == m
        if not many and values.size != m:
            raise ValueError(f"the policy observes {m} values, or an array (N, {m}), got shape {values.shape}")
        if not np.isfinite(values).all():
            raise ValueError("an observation must be finite")
        actions = self._inner.act(np.ascontiguousarray(values.reshape(-1, m)))
        if self._inner.n_numbered is not None:
            numbers = self._first + actions[:, 0].astype(np.int64)
            return numbers if many else int(numbers[0])
        shape = self._shape or (actions.shape[1],)
        return actions.reshape(-1, *shape) if many else actions[0].reshape(shape)

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> Any:
        """The best action as Stable-Baselines3's evaluation asks for it: ``(action, None)``."""
        return self(observation), state

    def __reduce__(self) -> Any:
        return Policy, (self._inner, self._first, self._shape)


class Controller:
    """
    Equations, a policy trained inside them, and what both are worth.

    Attributes
    ----------
    policy : callable
        The best action for an observation, or for many.
    equations : list of str
        The equations of motion.
    report_ : Report
        Standard errors, doubts, noise and fit of the equations.
    predicted_return : Interval or None
        Where the mean return of the evaluation was predicted to be, before it was made.
    returns : array (N,)
        Return of each episode of the evaluation; none without a system.
    real_steps, resets : int
        Steps and resets of the system before the evaluation.
    reward, terminated : str or None
        The formulas that the policy was trained for; None where they were functions.
    notes : list of str
        What was decided without being asked for.
    """

    def __init__(
        self,
        document: dict[str, Any],
        functions: tuple[Callable[..., Any] | None, Callable[..., Any] | None] = (None, None),
    ) -> None:
        self._document, self._functions = document, functions

    @cached_property
    def _model(self) -> _sindyna.Model:
        if self._document["model"] is None:
            raise ValueError("no equations were found")
        return _sindyna.Model.from_json(json.dumps(self._document["model"]))

    @cached_property
    def _fitted(self) -> Fitted:
        own = self._document
        # Equations of a task file are over people's names.
        names = (Names if own["system"] else OwnNames)(own["states"], own["inputs"])
        return Fitted(names, (self._model, json.dumps(own["account"])), n_trajectories=own["resets"])

    @cached_property
    def policy(self) -> Policy:
        own = self._document
        if own["policy"] is None:
            raise ValueError(f"training produced no policy: {self._training['failure'] or 'it was not trained'}")
        return Policy(_sindyna.Policy.from_bytes(base64.b64decode(own["policy"])), own["first"], self._shape)

    @property
    def _shape(self) -> tuple[int, ...] | None:
        """The shape of an action; none where actions are numbered."""
        shape = self._document["shape"]
        return None if shape is None else tuple(shape)

    @property
    def equations(self) -> list[str]:
        if self._document["account"] is None:
            return list(self._document["summary"]["identification"]["equations"])
        fitted = self._fitted
        return [f"{_show.left(fitted, e.state)} = {_show.equation(e, 6)}" for e in self.report_.equations]

    @property
    def report_(self) -> Report:
        if self._document["account"] is None:
            raise AttributeError("a run of the command has its report in report.html and identify.json")
        return self._fitted.report

    @property
    def summary(self) -> dict[str, Any]:
        """The run in numbers, as `summary.json` of the command has it."""
        return dict(self._document["summary"])

    @property
    def _training(self) -> dict[str, Any]:
        return dict(self._document["summary"]["training"])

    @property
    def predicted_return(self) -> Interval | None:
        told = self._training["prediction"]
        return None if told is None else Interval(told["low"], told["high"], told["mean"], told["level"])

    @property
    def returns(self) -> Array:
        told = self._document["summary"]["evaluation"]
        return np.array(told["returns"] if told else [], dtype=np.float64)

    @property
    def mean_return(self) -> float | None:
        """Mean of `returns`; None without an evaluation."""
        return float(self.returns.mean()) if len(self.returns) else None

    @property
    def solved(self) -> bool | None:
        """Whether the mean return reaches the threshold; None without a threshold or an evaluation."""
        solved: bool | None = self._document["summary"]["solved"]
        return solved

    @property
    def real_steps(self) -> int:
        return int(self._document["summary"]["real_steps"])

    @property
    def resets(self) -> int:
        return int(self._document["resets"])

    @property
    def reward(self) -> str | None:
        reward: str | None = self._document["told"]["reward"]
        return reward

    @property
    def terminated(self) -> str | None:
        terminated: str | None = self._document["told"]["terminated"]
        return terminated

    @property
    def notes(self) -> list[str]:
        return list(self._document["notes"])

    def _batch(self, copies: int) -> _sindyna.Batch:
        own, (reward, terminated) = self._document, self._functions
        if own["system"] is None and own["task"] is not None:
            files = [(name, text.encode()) for name, text in own["task"]["files"].items()]
            return _sindyna.learned_file(files, own["task"]["dt"], self._model, copies)
        if own["system"] is None:
            return _sindyna.learned_builtin(own["summary"]["task"], self._model, copies)
        if (own["told"]["reward"] is None and reward is None) or (own["ends_by_function"] and terminated is None):
            raise ValueError(
                "this controller was loaded from a file, and files hold no functions: give sindyna.load(path, reward=…, terminated=…)"
            )
        return _sindyna.learned(
            json.dumps(own["system"]), json.dumps(own["task"]), self._model, copies, reward, terminated
        )

    def env(self) -> Any:
        """
        The learned equations with the task as a `gymnasium.Env`, which needs Gymnasium.

        Returns
        -------
        gymnasium.Env
        """
        from .envs import BatchEnv

        return BatchEnv(self._batch(1), self._document["first"], self._shape)

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

        return BatchVectorEnv(self._batch(num_envs), num_envs, self._document["first"], self._shape)

    def export(self, to: str, path: str | os.PathLike[str] | None = None) -> str | bytes:
        """
        Equations and policy as a program that needs nothing of sindyna.

        Parameters
        ----------
        to : str
            ``"python"``, ``"c"``, ``"javascript"``, ``"rust"``, ``"latex"``, ``"casadi"``, ``"onnx"`` or ``"fmu"``.
        path : str or path, optional
            File to write. Of ONNX the policy goes to a file of its own beside it: ``a.policy.onnx`` beside ``a.onnx``.

        Returns
        -------
        str or bytes
            The program (bytes of ONNX, without the policy, and of an FMU): ``act(o)`` is the action for an observation, with scaling and limits inside, ``step(x, u)`` the state one step later.
            Actions differ from `policy` by at most 1e-6 of their range.
        """
        own = self._document
        policy = self.policy._inner if own["policy"] is not None else None
        return exported(self._model, policy, (own["states"], own["inputs"], own["observed"]), to, path)

    def save(self, path: str | os.PathLike[str]) -> None:
        """
        Writes everything but functions as JSON: equations, policy, task, returns.

        Parameters
        ----------
        path : str or path
            The file.
        """
        written(path, {"format": FORMAT, "sindyna": _sindyna.__version__, "class": KIND, **self._document})

    def __str__(self) -> str:
        lines = [*self.equations, ""]
        if self._document["account"] is not None and self.report_.certainty == "doubted":
            lines.append("the equations may be wrong: see report_; angles=, rates= or more real_steps may help")
        own = f"that of {self.summary['task']}" if self._document["system"] is None else "a function"
        lines.append(f"reward: {self.reward or own}" + (f", ends if {self.terminated}" if self.terminated else ""))
        if self.predicted_return is not None:
            low, high, mean, level = self.predicted_return
            lines.append(f"predicted mean return: {mean:.4g} ({100 * level:.0f} % interval {low:.4g} to {high:.4g})")
        if self.mean_return is not None:
            judged = {None: "", True: ": solved", False: ": not solved"}[self.solved]
            lines.append(f"mean return of {len(self.returns)} episodes: {self.mean_return:.4g}{judged}")
        lines.append(f"real steps: {self.real_steps}, resets: {self.resets}")
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"<Controller: {len(self._document['states'])} states, {self.real_steps} real steps, mean return {self.mean_return}>"


#: What a file of a controller holds, besides its head.
_PARTS = {"system", "observed", "states", "inputs", "task", "told", "ends_by_function", "first", "shape", "model", "account", "summary", "policy", "resets", "notes"}  # fmt: skip


def load(
    path: str | os.PathLike[str],
    *,
    reward: Callable[..., Any] | None = None,
    terminated: Callable[..., Any] | None = None,
) -> Controller:
    """
    Reads a controller that `Controller.save` wrote, or a run of the command `sindyna train`. Nothing that is read is run.

    Parameters
    ----------
    path : str or path
        The file, or the directory of the run.
    reward, terminated : callable, optional
        The functions it was trained with, which are in no file; needed for `env` alone.

    Returns
    -------
    Controller
    """
    if Path(path).is_dir():
        return _of_run(Path(path))
    try:
        document = json.loads(Path(path).read_text(encoding="utf-8"))
        version, kind = document["format"], document["class"]
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(f"{path} is not a controller of sindyna: {error!r}") from None
    if kind != KIND:
        raise ValueError(f"{path} holds a {kind}, not a controller: read it with sindyna.{kind}.load")
    if version != FORMAT:
        raise ValueError(f"{path} has format {version!r}, this version of sindyna reads {FORMAT}")
    try:
        controller = Controller({part: document[part] for part in _PARTS}, (reward, terminated))
        # What does not fit together is told here, not later.
        _ = (
            document["account"] and controller.report_,
            controller.equations,
            controller.returns,
            document["policy"] and controller.policy,
        )
    except (ValueError, KeyError, TypeError, IndexError, AttributeError) as error:
        raise ValueError(f"{path} is an incomplete controller of sindyna: {error!r}") from None
    return controller


def _of_run(path: Path) -> Controller:
    """The controller of a run of the command."""

    def read(name: str) -> bytes:
        file = path / name
        if not file.is_file():
            raise ValueError(f"{path} is not a run of `sindyna train` with a policy: it has no {name}")
        return file.read_bytes()

    try:
        summary, model = json.loads(read("summary.json")), json.loads(read("model.json"))
        policy = base64.b64encode(read("policy.safetensors")).decode("ascii")
        document = dict.fromkeys(_PARTS) | {
            "observed": [],
            "states": list(model["states"]),
            "inputs": list(model["controls"]),
            "told": {"reward": None, "terminated": None},
            "first": 0,
            "model": model,
            "summary": summary,
            "policy": policy,
            "task": _task_of(path, model["dt"]),
            "resets": summary["real_episodes"],
            "notes": [],
        }
        controller = Controller(document)
        _ = controller.policy, controller.returns, controller.equations
    except (KeyError, TypeError) as error:
        raise ValueError(f"{path} is not a complete run: {error!r}") from None
    return controller


def _task_of(path: Path, dt: float) -> dict[str, Any] | None:
    """The task that the files of a run describe; None for a task that comes along."""
    files = {name: (path / name).read_text(encoding="utf-8") for name in FILES if (path / name).is_file()}
    return {"dt": dt, "files": files} if FILES[0] in files else None
