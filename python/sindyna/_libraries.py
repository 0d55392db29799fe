"""Candidate terms: PySINDy's libraries, and formulas."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations, combinations_with_replacement
from typing import Any

import numpy as np
import numpy.typing as npt

from ._formula import Names
from ._library import FeatureLibrary, Recipe, known
from ._params import whole
from ._trace import arity, traced


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
        Whether powers of variables are left out.
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
        degree = whole("degree", self.degree, 0)
        if self.interaction_only and not self.include_interaction:
            raise ValueError("include_interaction=False and interaction_only=True leave nothing out and nothing in")
        if self.interaction_only:
            return {"formulas": [formula for formula, _ in self._products(names)]}
        return {
            "polynomial": {
                "degree": degree,
                "interaction": bool(self.include_interaction),
                "bias": bool(self.include_bias),
            }
        }

    def _products(self, names: Names) -> list[tuple[str, str]]:
        """Products of different variables, as formulas and as names."""
        chosen = [
            one for size in range(1, whole("degree", self.degree, 0) + 1) for one in combinations(names.by_symbol, size)
        ]
        products = [("*".join(one), " ".join(names.name(symbol) for symbol in one)) for one in chosen]
        return [("1", "1"), *products] if self.include_bias else products

    def _labels(self, names: Names) -> dict[str, str]:
        return dict(self._products(names)) if self.interaction_only else {}

    @property
    def powers_(self) -> npt.NDArray[np.int64]:
        """The power of each variable in each term (F, n)."""
        # Where one variable is 2 and all others are 1, a term is 2 to the power of that variable.
        return np.log2(self.transform(1.0 + np.eye(self._width()))).round().astype(np.int64).T


class FourierLibrary(FeatureLibrary):
    """
    sin(k a) and cos(k a) of every variable a, k = 1, …, ``n_frequencies``.

    Parameters
    ----------
    n_frequencies : int
        Number of frequencies.
    include_sin, include_cos : bool
        Whether there are sines, and cosines.
    """

    def __init__(self, n_frequencies: int = 1, include_sin: bool = True, include_cos: bool = True) -> None:
        whole("n_frequencies", n_frequencies, 1)
        self.n_frequencies = n_frequencies
        self.include_sin = include_sin
        self.include_cos = include_cos
        if not (include_sin or include_cos):
            raise ValueError("include_sin=False and include_cos=False leave no term")

    def _recipe(self, names: Names) -> Recipe:
        if self.include_sin and self.include_cos:
            return {"fourier": {"n_frequencies": whole("n_frequencies", self.n_frequencies, 1)}}
        return {"formulas": list(self._labels(names))}

    def _labels(self, names: Names) -> dict[str, str]:
        if self.include_sin and self.include_cos:
            return {}
        function = "sin" if self.include_sin else "cos"
        waves = range(1, whole("n_frequencies", self.n_frequencies, 1) + 1)
        return {f"{function}({k}*{s})": f"{function}({k} {names.name(s)})" for k in waves for s in names.by_symbol}


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
        self._check()

    def _check(self) -> None:
        if self.function_names is not None and len(self.function_names) != len(self.library_functions):
            raise ValueError(
                f"{len(self.library_functions)} library_functions need as many function_names, got {len(self.function_names)}"
            )

    def _terms(self, names: Names) -> list[tuple[str, str]]:
        self._check()
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


class GeneralizedLibrary(FeatureLibrary):
    """
    Libraries over some of the variables each, one after the other.

    Parameters
    ----------
    libraries : sequence of FeatureLibrary
        The libraries.
    tensor_array : sequence of sequences of int, optional
        A row for every product that is added: 1 for each library that is a factor of it, 0 for the others.
    inputs_per_library : sequence of sequences of int, optional
        Per library the columns it sees, states first, then inputs.
    """

    def __init__(
        self,
        libraries: Sequence[FeatureLibrary] = (),
        tensor_array: Sequence[Sequence[int]] | None = None,
        inputs_per_library: Sequence[Sequence[int]] | None = None,
    ) -> None:
        self.libraries = libraries
        self.tensor_array = tensor_array
        self.inputs_per_library = inputs_per_library

    def _recipe(self, names: Names) -> Recipe:
        count = len(self.libraries)
        if not count:
            raise ValueError("GeneralizedLibrary needs at least one library")
        if self.inputs_per_library is not None and len(self.inputs_per_library) != count:
            raise ValueError(f"{count} libraries need as many inputs_per_library, got {len(self.inputs_per_library)}")
        every = range(len(names.by_symbol))
        parts: list[Recipe] = []
        for library, inputs in zip(self.libraries, self.inputs_per_library or [every] * count, strict=True):
            chosen = list(dict.fromkeys(whole("inputs_per_library", i, 0) for i in inputs))
            if chosen and max(chosen) >= len(every):
                raise ValueError(f"inputs_per_library: there are {len(every)} variables, got number {max(chosen)}")
            parts.append(_over(known(library), chosen, names))
        return {"concat": [*parts, *(self._product(row, parts) for row in self.tensor_array or ())]}

    def _product(self, row: Any, parts: list[Recipe]) -> Recipe:
        if np.ndim(row) != 1 or len(row) != len(parts) or any(flag not in (0, 1) for flag in row) or sum(row) < 2:
            raise ValueError(
                f"a row of tensor_array must have a 0 or 1 for each of the {len(parts)} libraries, and two 1 or more, got {row!r}"
            )
        first, *others = [part for part, flag in zip(parts, row, strict=True) if flag]
        for other in others:
            first = {"tensor": [first, other]}
        return first

    def _labels(self, names: Names) -> dict[str, str]:
        return {formula: label for library in self.libraries for formula, label in library._labels(names).items()}


def _over(library: FeatureLibrary, chosen: list[int], names: Names) -> Recipe:
    """The recipe of a library that sees some of the variables."""
    own = library._recipe(names.only(chosen))
    # Formulas name their variables.
    return own if isinstance(own, dict) and "formulas" in own else {"of": {"inputs": chosen, "library": own}}
