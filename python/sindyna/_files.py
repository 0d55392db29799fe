"""Fitted models as JSON files."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from . import _differentiation, _libraries, _library, _optimizers, _sindyna
from ._fit import Fitted
from ._formula import Names
from ._params import Parameters

FORMAT = 2

_CLASSES: dict[str, type[Parameters]] = {
    c.__name__: c
    for base in (_library.FeatureLibrary, _optimizers.Optimizer, _differentiation.Differentiation)
    for c in base.__subclasses__()
}


def _written(value: Any, names: Names) -> Any:
    if isinstance(value, _libraries.CustomLibrary):
        formulas = [names.told(formula) for formula, _ in value._terms(names)]
        value = _libraries.FormulaLibrary(formulas)
    if isinstance(value, Parameters):
        inner = {name: _written(v, names) for name, v in value.get_params(deep=False).items()}
        return {"class": type(value).__name__, "params": inner}
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Mapping):
        return {"dict": [[_written(k, names), _written(v, names)] for k, v in value.items()]}
    if isinstance(value, (list, tuple)):
        return [_written(v, names) for v in value]
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    raise TypeError(f"{value!r} cannot be written as JSON")


def _read(value: Any) -> Any:
    if isinstance(value, dict) and "dict" in value:
        return {_read(k): _read(v) for k, v in value["dict"]}
    if isinstance(value, dict):
        return _CLASSES[value["class"]](**{name: _read(v) for name, v in value["params"].items()})
    if isinstance(value, list):
        return [_read(v) for v in value]
    return value


def written(path: str | os.PathLike[str], document: dict[str, Any]) -> None:
    """Writes a document as JSON, under a temporary name first."""
    written_text(path, json.dumps(document, indent=1, ensure_ascii=False))


def exported(
    model: _sindyna.Model,
    policy: _sindyna.Policy | None,
    names: tuple[list[str], list[str], list[str]],
    to: str,
    path: str | os.PathLike[str] | None,
) -> str | bytes:
    """A program of equations and policy, written to a file where one is named, and the policy beside it where it needs one of its own."""
    program, apart = _sindyna.export(model, policy, names, to)
    if path is not None:
        written_bytes(path, program.encode() if isinstance(program, str) else program)
        if apart is not None:
            written_bytes(Path(path).with_suffix(f".policy{Path(path).suffix}"), apart)
    return program


def written_text(path: str | os.PathLike[str], text: str) -> None:
    """Writes a text, under a temporary name first."""
    written_bytes(path, text.encode())


def written_bytes(path: str | os.PathLike[str], contents: bytes) -> None:
    """Writes a file, under a temporary name first."""
    target = Path(path)
    temporary = target.with_name(f"{target.name}.{os.getpid()}.tmp")
    try:
        temporary.write_bytes(contents)
        temporary.replace(target)
    finally:
        temporary.unlink(missing_ok=True)


def save(path: str | os.PathLike[str], kind: str, params: dict[str, Any], fitted: Fitted) -> None:
    """Writes a fitted model, under a temporary name first."""
    document = {
        "format": FORMAT,
        "sindyna": _sindyna.__version__,
        "class": kind,
        "params": {name: _written(value, fitted.names) for name, value in params.items()},
        "states": fitted.names.states,
        "inputs": fitted.names.inputs,
        "labels": fitted.labels,
        "n_trajectories": fitted.n_trajectories,
        "model": fitted.document,
        "account": fitted.account,
    }
    written(path, document)


def load(path: str | os.PathLike[str]) -> tuple[str, dict[str, Any], Fitted]:
    """Reads a fitted model: the name of its class, its parameters, the rest."""
    try:
        document = json.loads(Path(path).read_text(encoding="utf-8"))
        version = document["format"]
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(f"{path} is not a model of sindyna: {error}") from None
    if version != FORMAT:
        raise ValueError(f"{path} has format {version!r}, this version of sindyna reads {FORMAT}")
    try:
        names = Names(document["states"], document["inputs"])
        model = _sindyna.Model.from_json(json.dumps(document["model"]))
        fitted = Fitted(names, (model, json.dumps(document["account"])), document["labels"], document["n_trajectories"])
        params = {name: _read(value) for name, value in document["params"].items()}
        kind = str(document["class"])
        # What does not fit together is told here, not later.
        _ = fitted.report, fitted.features
    except (ValueError, KeyError, TypeError, IndexError, AttributeError) as error:
        raise ValueError(f"{path} is an incomplete model of sindyna: {error!r}") from None
    return kind, params, fitted
