"""`DiscreteSINDy`: maps from sample to sample."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, ClassVar, TypeVar

from ._data import Array
from ._library import FeatureLibrary
from ._optimizers import Optimizer
from ._sindy import SINDy

Map = TypeVar("Map", bound="DiscreteSINDy")


class DiscreteSINDy(SINDy):
    """
    A map from sample to sample: `SINDy` with ``discrete_time=True``.

    Parameters
    ----------
    optimizer : BestSubset, STLSQ or LeastSquares, optional
        How coefficients are found.
    feature_library : FeatureLibrary, optional
        Candidate terms; polynomials of degree 2 by default.
    feature_names : list of str, optional
        Names of states, and of inputs after them.
    t_default : float
        Sampling interval [s] where `fit` is told none.
    terms : list of str, optional
        Candidate terms beside those of the library.
    controls : int or list of str, optional
        How many of the last columns of ``x`` are inputs, or which.

    Examples
    --------
    >>> import numpy as np, sindyna
    >>> x = [0.3]
    >>> for _ in range(50):
    ...     x.append(3.7 * x[-1] * (1 - x[-1]))
    >>> sindyna.DiscreteSINDy().fit(np.array(x)).print()
    (x0)[k+1] = 3.700 x0 + -3.700 x0^2
    """

    def __init__(
        self,
        optimizer: Optimizer | None = None,
        feature_library: FeatureLibrary | None = None,
        *,
        feature_names: Sequence[str] | None = None,
        t_default: float = 1.0,
        terms: Sequence[str] | None = None,
        controls: int | list[str] | None = None,
    ) -> None:
        super().__init__(
            optimizer,
            feature_library,
            feature_names=feature_names,
            t_default=t_default,
            discrete_time=True,
            terms=terms,
            controls=controls,
        )

    _ROUTED: ClassVar = {"fit": ("t", "u", "x_next", "feature_names"), "predict": ("u",), "score": ("t", "u", "x_next")}

    def fit(self: Map, x: Any, t: Any = None, x_next: Any = None, u: Any = None, feature_names: Any = None) -> Map:
        """
        Finds the map behind samples.

        Parameters
        ----------
        x, t, u, feature_names
            As in `SINDy.fit`.
        x_next : array (T, n), or list of these, optional
            The states after those of ``x``, with inputs of as many rows; the next samples by default.

        Returns
        -------
        self
        """
        return super().fit(x, t, x_next, u, feature_names)

    def score(
        self,
        x: Any,
        t: Any = None,
        x_next: Any = None,
        u: Any = None,
        metric: Callable[[Array, Array], float] | None = None,
    ) -> float:
        """
        How well `predict` explains the next states.

        Parameters
        ----------
        x, t, u, x_next
            As in `fit`.
        metric : callable, optional
            A function of true and predicted states (N, n); the coefficient of determination, averaged over states, by default.

        Returns
        -------
        float
            1 is perfect.
        """
        return super().score(x, t, x_next, u, metric)
