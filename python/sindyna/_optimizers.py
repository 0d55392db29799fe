"""How coefficients are found: sindyna's estimator, and thresholding as PySINDy has it."""

from __future__ import annotations

import math
from typing import Any

from ._params import Parameters, whole


class Optimizer(Parameters):
    """How coefficients are found."""

    def _solver(self) -> dict[str, Any]:
        raise NotImplementedError


class BestSubset(Optimizer):
    """
    The default: the equations with the best score among all subsets of the candidate terms.

    Given samples alone, it is sindyna's estimator: noise that nobody declares is estimated together with the equations, which are fitted to
    whole trajectories. With ``differentiation_method``, with derivatives (``x_dot``) or in discrete time it is one best-subset regression
    for each state.

    Parameters
    ----------
    max_size : int, optional
        Largest number of terms in an equation that regressions try.
    """

    def __init__(self, max_size: int | None = None) -> None:
        self.max_size = max_size

    def _solver(self) -> dict[str, Any]:
        size = None if self.max_size is None else whole("max_size", self.max_size, 1)
        return {"best_subset": {"max_size": size}}


class STLSQ(Optimizer):
    """
    Sequentially thresholded least squares: ridge regression, drop every coefficient below the threshold, repeat. Numbers are those of PySINDy.

    Parameters
    ----------
    threshold : float
        Smallest magnitude of a coefficient that is kept.
    alpha : float
        Weight of the ridge term.
    max_iter : int
        Largest number of rounds.
    ridge_kw, initial_guess, sparse_ind : None
        Refused otherwise.
    normalize_columns : bool
        Whether columns are scaled to unit length before coefficients are compared with the threshold.
    verbose : bool
        Refused if true.
    unbias : bool
        Whether kept coefficients are fitted again without the ridge term.

    Examples
    --------
    >>> import sindyna
    >>> sindyna.STLSQ(threshold=0.2).get_params()["alpha"]
    0.05
    """

    def __init__(
        self,
        threshold: float = 0.1,
        alpha: float = 0.05,
        max_iter: int = 20,
        ridge_kw: None = None,
        normalize_columns: bool = False,
        initial_guess: None = None,
        verbose: bool = False,
        sparse_ind: None = None,
        unbias: bool = True,
    ) -> None:
        # Refused here already, but kept as given: scikit-learn clones by what was given.
        at_least_zero("threshold", threshold)
        at_least_zero("alpha", alpha)
        whole("max_iter", max_iter, 1)
        self.threshold = threshold
        self.alpha = alpha
        self.max_iter = max_iter
        self.ridge_kw = ridge_kw
        self.normalize_columns = normalize_columns
        self.initial_guess = initial_guess
        self.verbose = verbose
        self.sparse_ind = sparse_ind
        self.unbias = unbias

    def _solver(self) -> dict[str, Any]:
        for name in ("ridge_kw", "initial_guess", "sparse_ind"):
            if getattr(self, name) is not None:
                raise NotImplementedError(f"STLSQ has no {name} in sindyna, got {getattr(self, name)!r}; leave it None")
        if self.verbose:
            raise NotImplementedError("STLSQ has no progress output; leave verbose=False and read report_")
        return {
            "stlsq": {
                "threshold": at_least_zero("threshold", self.threshold),
                "ridge": at_least_zero("alpha", self.alpha),
                "max_iterations": whole("max_iter", self.max_iter, 1),
                "normalised": bool(self.normalize_columns),
                "unbiased": bool(self.unbias),
            }
        }


class LeastSquares(Optimizer):
    """
    All candidate terms, by least squares.

    Parameters
    ----------
    alpha : float
        Weight of a ridge term.
    """

    def __init__(self, alpha: float = 0.0) -> None:
        self.alpha = alpha

    def _solver(self) -> dict[str, Any]:
        return {"least_squares": {"ridge": at_least_zero("alpha", self.alpha)}}


def at_least_zero(name: str, value: Any) -> float:
    """A finite number of at least 0."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not (math.isfinite(number) and number >= 0.0):
        raise ValueError(f"{name} must be finite and at least 0, got {value!r}")
    return number
