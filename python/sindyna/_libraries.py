"""Candidate terms: PySINDy's libraries, and formulas."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations, combinations_with_replacement
from typing import Any

from ._formula import Names
from ._params import Parameters
from ._trace import arity, traced

Recipe = dict[str, Any] | str


class FeatureLibrary(Parameters):
    """A recipe for candidate terms. ``a + b`` is one after the other, ``a * b`` every product of both."""

    def _recipe(self, names: Names) -> Recipe:
        raise NotImplementedError

    def _labels(self, names: Names) -> dict[str, str]:
        """Names of terms that differ from their formulas."""
        return {}

    def __add__(self, other: FeatureLibrary) -> ConcatLibrary:
        return ConcatLibrary([self, other])

    def __mul__(self, other: FeatureLibrary) -> TensoredLibrary:
        return TensoredLibrary([self, other])


class PolynomialLibrary(FeatureLibrary):
    """
    Products of variables up to a degree: ``1, x0, x1, x0^2, x0 x1, x1^2``.

    Parameters
    ----------
    degree : int
        Largest sum of powers.
    include_interaction : bool
        Whether products of different variables are included.
    interaction_only : bool
        Refused if true: there is no such library in the engine.
    include_bias : bool
        Whether the constant 1 is included.

    Examples
    --------
    >>> import sindyna
    >>> sindyna.PolynomialLibrary(degree=3, include_bias=False)
    PolynomialLibrary(degree=3, include_bias=False)
    """

    def __init__(
        self,
        degree: int = 2,
        include_interaction: bool = True,
        interaction_only: bool = False,
        include_bias: bool = True,
    ) -> None:
        self.degree = degree
        self.include_interaction = include_interaction
        self.interaction_only = interaction_only
        self.include_bias = include_bias

    def _recipe(self, names: Names) -> Recipe:
        if self.interaction_only:
            raise NotImplementedError(
                "interaction_only=True is not supported; write the products as FormulaLibrary(['x0*x1', …])"
            )
        degree = whole("degree", self.degree, 0)
        return {
            "polynomial": {
                "degree": degree,
                "interaction": bool(self.include_interaction),
                "bias": bool(self.include_bias),
            }
        }


class FourierLibrary(FeatureLibrary):
    """
    sin(k a) and cos(k a) of every variable a, k = 1, …, ``n_frequencies``.

    Parameters
    ----------
    n_frequencies : int
        Number of frequencies.
    include_sin, include_cos : bool
        Both must be true: the engine has them together.
    """

    def __init__(self, n_frequencies: int = 1, include_sin: bool = True, include_cos: bool = True) -> None:
        self.n_frequencies = n_frequencies
        self.include_sin = include_sin
        self.include_cos = include_cos

    def _recipe(self, names: Names) -> Recipe:
        if not (self.include_sin and self.include_cos):
            raise NotImplementedError(
                "include_sin and include_cos must both be true; else write FormulaLibrary(['sin(x0)', …])"
            )
        return {"fourier": {"n_frequencies": whole("n_frequencies", self.n_frequencies, 1)}}


class IdentityLibrary(FeatureLibrary):
    """The variables themselves."""

    def __init__(self) -> None:
        pass

    def _recipe(self, names: Names) -> Recipe:
        return "identity"


class FormulaLibrary(FeatureLibrary):
    """
    Terms written by hand over the names of states and inputs.

    Parameters
    ----------
    formulas : sequence of str
        Terms such as ``"v^2*sin(x)"``: numbers, names, ``+ - * / ^`` with whole exponents, parentheses, and the functions sin, cos, tan,
        exp, log, sqrt, abs, sign, tanh.

    Examples
    --------
    >>> import sindyna
    >>> library = sindyna.FormulaLibrary(["1", "sin(th)"]) + sindyna.IdentityLibrary()
    """

    def __init__(self, formulas: Sequence[str] = ()) -> None:
        self.formulas = formulas

    def _recipe(self, names: Names) -> Recipe:
        return {"formulas": [names.formula(text) for text in self.formulas]}


class CustomLibrary(FeatureLibrary):
    """
    Functions of one or more variables, applied to all combinations of variables.

    Parameters
    ----------
    library_functions : sequence of callable
        Functions such as ``lambda x: np.exp(-x)`` or ``lambda x, y: np.sin(x + y)``. They are called once, with symbols, to learn their
        formula: arithmetic, whole powers and the functions of `FormulaLibrary` are understood, anything else is refused.
    function_names : sequence of callable, optional
        What the terms are called, as functions of the names of their variables.
    interaction_only : bool
        Whether functions of several variables leave out combinations of a variable with itself.
    include_bias : bool
        Whether the constant 1 is included.
    """

    def __init__(
        self,
        library_functions: Sequence[Callable[..., Any]] = (),
        function_names: Sequence[Callable[..., str]] | None = None,
        interaction_only: bool = True,
        include_bias: bool = False,
    ) -> None:
        self.library_functions = library_functions
        self.function_names = function_names
        self.interaction_only = interaction_only
        self.include_bias = include_bias

    def _terms(self, names: Names) -> list[tuple[str, str]]:
        if self.function_names is not None and len(self.function_names) != len(self.library_functions):
            raise ValueError(
                f"{len(self.library_functions)} library_functions need as many function_names, got {len(self.function_names)}"
            )
        terms = [("1", "1")] if self.include_bias else []
        choose = combinations if self.interaction_only else combinations_with_replacement
        for i, function in enumerate(self.library_functions):
            for symbols in choose(list(names.by_symbol), arity(function)):
                formula = traced(function, symbols)
                given = [names.name(symbol) for symbol in symbols]
                label = (
                    self.function_names[i](*given) if self.function_names is not None else f"f{i}({','.join(given)})"
                )
                terms.append((formula, label))
        return terms

    def _recipe(self, names: Names) -> Recipe:
        return {"formulas": [formula for formula, _ in self._terms(names)]}

    def _labels(self, names: Names) -> dict[str, str]:
        return dict(self._terms(names))


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


class GeneralizedLibrary(FeatureLibrary):
    """
    Libraries over some of the variables each, one after the other.

    Parameters
    ----------
    libraries : sequence of FeatureLibrary
        The libraries.
    tensor_array : None
        Refused otherwise; write ``a * b`` for products.
    inputs_per_library : sequence of sequences of int, optional
        Per library the columns it sees, states first, then inputs.
    """

    def __init__(
        self,
        libraries: Sequence[FeatureLibrary] = (),
        tensor_array: None = None,
        inputs_per_library: Sequence[Sequence[int]] | None = None,
    ) -> None:
        self.libraries = libraries
        self.tensor_array = tensor_array
        self.inputs_per_library = inputs_per_library

    def _recipe(self, names: Names) -> Recipe:
        if self.tensor_array is not None:
            raise NotImplementedError("tensor_array is not supported; write products of libraries as a * b")
        if self.inputs_per_library is None:
            return ConcatLibrary(self.libraries)._recipe(names)
        if len(self.inputs_per_library) != len(self.libraries):
            raise ValueError(
                f"{len(self.libraries)} libraries need as many inputs_per_library, got {len(self.inputs_per_library)}"
            )
        parts = []
        for library, inputs in zip(self.libraries, self.inputs_per_library, strict=True):
            chosen = list(dict.fromkeys(whole("inputs_per_library", i, 0) for i in inputs))
            parts.append({"of": {"inputs": chosen, "library": known(library)._recipe(names)}})
        return {"concat": parts}

    def _labels(self, names: Names) -> dict[str, str]:
        return {formula: label for library in self.libraries for formula, label in library._labels(names).items()}


def known(library: Any) -> FeatureLibrary:
    """Refuses what is no library of ours."""
    if isinstance(library, FeatureLibrary):
        return library
    raise NotImplementedError(
        f"{library!r} is no feature library of sindyna; there are {', '.join(c.__name__ for c in FeatureLibrary.__subclasses__())}"
    )


def whole(name: str, value: Any, least: int) -> int:
    """A whole number of at least so much."""
    if isinstance(value, bool) or not hasattr(value, "__index__") or value.__index__() < least:
        raise ValueError(f"{name} must be a whole number of at least {least}, got {value!r}")
    return int(value.__index__())
