from collections.abc import Callable, Sequence
from typing import Any, final

import numpy as np
import numpy.typing as npt

_Array = npt.NDArray[np.float64]
_Flags = npt.NDArray[np.bool_]

__all__ = [
    "Batch",
    "Data",
    "Model",
    "Outcome",
    "Policy",
    "Regression",
    "__version__",
    "builtin",
    "collect",
    "differentiate",
    "export",
    "feature_names",
    "features",
    "identify",
    "learned",
    "learned_builtin",
    "learned_file",
    "paid",
    "regress",
    "smoothed",
    "states",
    "train",
    "train_file",
    "written",
]

__version__: str

def export(
    model: Model, policy: Policy | None, names: tuple[Sequence[str], Sequence[str], Sequence[str]], language: str
) -> tuple[str | bytes, bytes | None]: ...
def identify(recordings: Sequence[tuple[_Array, _Array, _Array]], settings: str) -> tuple[Model, str]: ...
def regress(
    trajectories: Sequence[tuple[_Array, _Array, _Array | None]], settings: str
) -> tuple[Model, Regression]: ...
def differentiate(x: _Array, dt: float, order: int) -> _Array: ...
def smoothed(x: _Array, dt: float, window: int, degree: int) -> tuple[_Array, _Array]: ...
def features(library: str, z: _Array, n_controls: int) -> _Array: ...
def feature_names(library: str, n_states: int, n_controls: int) -> list[str]: ...

@final
class Model:
    @staticmethod
    def from_json(text: str) -> Model: ...
    def to_json(self) -> str: ...
    def __reduce__(self) -> tuple[Callable[[str], Model], tuple[str]]: ...
    @property
    def form(self) -> str: ...
    @property
    def dt(self) -> float: ...
    def right_side(self, x: _Array, u: _Array) -> _Array: ...
    def step(self, x: _Array, u: _Array) -> _Array: ...
    def stepped(self, x0: _Array, u: _Array) -> _Array: ...
    def solve(
        self,
        x0: _Array,
        t: _Array,
        u: _Array,
        call: Callable[[float], Sequence[float]] | None,
        linear: bool,
        rtol: float,
        atol: float,
    ) -> _Array: ...
    def ahead(self, x: _Array, u: _Array, dt: _Array, horizon: int | None = None) -> _Array: ...
    def jacobians(self, x: _Array, u: _Array) -> tuple[_Array, _Array]: ...

@final
class Regression:
    @property
    def empty(self) -> list[int]: ...
    @property
    def unsettled(self) -> list[int]: ...
    def account(self) -> str: ...

@final
class Data:
    def __new__(cls, system: str, episodes: Sequence[tuple[_Array, _Array, _Array, str]]) -> Data: ...
    @property
    def n_steps(self) -> int: ...
    @property
    def n_resets(self) -> int: ...
    def episodes(self) -> list[tuple[_Array, _Array, _Array, str]]: ...
    def recognise(
        self,
        names: Sequence[str],
        dt: float,
        angles: Sequence[str],
        circles: Sequence[tuple[str, str]] | None,
        rates: Sequence[tuple[str, str]] | None,
    ) -> str: ...

@final
class Policy:
    @staticmethod
    def from_bytes(bytes: bytes) -> Policy: ...
    def to_bytes(self) -> bytes: ...
    def __reduce__(self) -> tuple[Callable[[bytes], Policy], tuple[bytes]]: ...
    @property
    def n_observations(self) -> int: ...
    @property
    def n_numbered(self) -> int | None: ...
    def act(self, observations: _Array) -> _Array: ...

@final
class Outcome:
    @property
    def summary(self) -> str: ...
    @property
    def identified(self) -> tuple[Model, str] | None: ...
    @property
    def policy(self) -> Policy | None: ...
    @property
    def data(self) -> Data: ...

@final
class Batch:
    @property
    def dt(self) -> float: ...
    @property
    def max_steps(self) -> int: ...
    @property
    def bounds(self) -> list[tuple[float, float]]: ...
    @property
    def float32(self) -> bool: ...
    @property
    def action_bounds(self) -> tuple[list[float], list[float]] | None: ...
    @property
    def n_actions(self) -> int: ...
    def reset(self, seed: int | None = None, which: Sequence[bool] | None = None) -> _Array: ...
    def reset_to(self, states: _Array) -> _Array: ...
    def states(self) -> _Array: ...
    def step(self, actions: _Array, autoreset: bool) -> tuple[_Array, _Array, _Flags, _Flags, _Flags]: ...

def collect(object: Any, system: str, steps: int, seed: int, random: bool) -> Data: ...
def states(system: str, observations: _Array) -> _Array: ...
def train(
    system: str,
    task: str,
    data: Data,
    seed: int,
    settings: Sequence[str],
    max_real_steps: int | None = None,
    object: Any | None = None,
    reward: Callable[[_Array, _Array, _Array], Any] | None = None,
    terminated: Callable[[_Array], Any] | None = None,
    evaluated: bool = True,
) -> Outcome: ...
def builtin(name: str, copies: int) -> Batch: ...
def learned(
    system: str,
    task: str,
    model: Model,
    copies: int,
    reward: Callable[[_Array, _Array, _Array], Any] | None = None,
    terminated: Callable[[_Array], Any] | None = None,
) -> Batch: ...
def train_file(
    path: str,
    logs: Sequence[str],
    model: str | None,
    seed: int,
    settings: Sequence[str],
    max_real_steps: int | None = None,
) -> tuple[Outcome, list[tuple[str, bytes]], tuple[list[str], list[str], list[str]], float]: ...
def learned_file(files: Sequence[tuple[str, bytes]], dt: float, model: Model, copies: int) -> Batch: ...
def learned_builtin(name: str, model: Model, copies: int) -> Batch: ...
def written(
    system: str,
    task: str,
    equations: Sequence[str],
    map: bool,
    copies: int,
    reward: Callable[[_Array, _Array, _Array], Any] | None = None,
    terminated: Callable[[_Array], Any] | None = None,
) -> Batch: ...
def paid(
    system: str,
    task: str,
    data: Data,
    reward: Callable[[_Array, _Array, _Array], Any] | None = None,
    terminated: Callable[[_Array], Any] | None = None,
) -> Data: ...
