"""What a library of candidate terms is, and how libraries are put together."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np

from . import _sindyna
from ._data import Array, matrix
from ._errors import NotFittedError
from ._formula import Names
from ._params import Parameters
from ._sklearn import Tagged

Recipe = dict[str, Any] | str
Self = TypeVar("Self", bound="FeatureLibrary")


class FeatureLibrary(Tagged, Parameters):
    """
    A recipe for candidate terms. ``a + b`` is one after the other, ``a * b`` every product of both.

    `SINDy` reads the recipe alone. By itself a library is a transformer as scikit-learn has them.
    """

    #: Number of variables that `fit` saw.
    n_features_in_: int

    def _recipe(self, names: Names) -> Recipe:
        raise NotImplementedError

    def _labels(self, names: Names) -> dict[str, str]:
        """Names of terms that differ from their formulas."""
        return {}

    def fit(self: Self, x: Any, y: Any = None) -> Self:
        """
        Learns how many variables there are.

        Parameters
        ----------
        x : array (N, n)
            Values of the variables.

        Returns
        -------
        self
        """
        width = _values(x).shape[1]
        self._named(width)
        self.n_features_in_ = width
        return self

    def transform(self, x: Any) -> Array:
        """
        The terms.

        Parameters
        ----------
        x : array (N, n)
            Values of the variables.

        Returns
        -------
        array (N, F)
        """
        values = _values(x)
        if values.shape[1] != self._width():
            raise ValueError(
                f"this {type(self).__name__} was fitted to {self._width()} variables, got {values.shape[1]}"
            )
        recipe = self._recipe(_numbered(values.shape[1]))
        return _sindyna.features(json.dumps(recipe), np.ascontiguousarray(values), 0)

    def fit_transform(self, x: Any, y: Any = None) -> Array:
        """
        `fit`, then `transform`.

        Returns
        -------
        array (N, F)
        """
        return self.fit(x).transform(x)

    def get_feature_names(self, input_features: Sequence[str] | None = None) -> list[str]:
        """
        The terms, in PySINDy's notation.

        Parameters
        ----------
        input_features : list of str, optional
            Names of the variables; ``x0, x1, …`` by default.

        Returns
        -------
        list of str (F,)
        """
        width = self._width()
        if input_features is not None and len(input_features) != width:
            raise ValueError(f"there are {width} variables, got {len(input_features)} names")
        return self._named(width, input_features)

    @property
    def n_output_features_(self) -> int:
        """Number of terms."""
        return len(self._named(self._width()))

    @property
    def size(self) -> int:
        """Number of terms."""
        return self.n_output_features_

    def _width(self) -> int:
        width = getattr(self, "n_features_in_", None)
        if width is None:
            raise NotFittedError(f"this {type(self).__name__} is not fitted yet; call fit first")
        return int(width)

    def _named(self, width: int, given: Sequence[str] | None = None) -> list[str]:
        names = _numbered(width, given)
        listed = _sindyna.feature_names(json.dumps(self._recipe(names)), width, 0)
        labels = self._labels(names)
        return [labels.get(text) or names.told(text) for text in listed]

    def __add__(self, other: FeatureLibrary) -> ConcatLibrary:
        return ConcatLibrary([self, other])

    def __mul__(self, other: FeatureLibrary) -> TensoredLibrary:
        return TensoredLibrary([self, other])


def _numbered(width: int, given: Sequence[str] | None = None) -> Names:
    return Names([f"x{i}" for i in range(width)] if given is None else given, [])


def _values(x: Any) -> Array:
    """Variables (N, n); of a sparse array all of them."""
    return matrix("x", x.toarray() if hasattr(x, "toarray") else x)


class ConcatLibrary(FeatureLibrary):
    """One library after the other."""

    def __init__(self, libraries: Sequence[FeatureLibrary] = ()) -> None:
        self.libraries = libraries

    def _recipe(self, names: Names) -> Recipe:
        return {"concat": [known(library)._recipe(names) for library in self.libraries]}

    def _labels(self, names: Names) -> dict[str, str]:
        return {formula: label for library in self.libraries for formula, label in library._labels(names).items()}


class TensoredLibrary(FeatureLibrary):
    """Every product of a term of each library; the first is the outer loop."""

    def __init__(self, libraries: Sequence[FeatureLibrary] = ()) -> None:
        self.libraries = libraries

    def _recipe(self, names: Names) -> Recipe:
        if not self.libraries:
            raise ValueError("TensoredLibrary needs at least one library")
        first, *others = [known(library)._recipe(names) for library in self.libraries]
        for other in others:
            first = {"tensor": [first, other]}
        return first


def known(library: Any) -> FeatureLibrary:
    """Refuses what is no library of ours."""
    if isinstance(library, FeatureLibrary):
        return library
    raise NotImplementedError(
        f"{library!r} is no feature library of sindyna; there are {', '.join(c.__name__ for c in FeatureLibrary.__subclasses__())}"
    )
