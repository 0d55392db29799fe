"""Equations of motion from noisy data: sparse identification of nonlinear dynamics.

`SINDy` is the door: ``SINDy().fit(x, t=t)`` finds the equations behind samples of states, the noise of every channel, standard errors, and
what speaks against the result. Names and manners are those of PySINDy and scikit-learn.
"""

from __future__ import annotations

from typing import Any

from ._controller import Controller, Interval, Policy, load
from ._differentiation import FiniteDifference, SmoothedFiniteDifference
from ._discrete import DiscreteSINDy
from ._errors import ConvergenceWarning, NotFittedError
from ._learn import learn
from ._libraries import (
    CustomLibrary,
    FormulaLibrary,
    FourierLibrary,
    GeneralizedLibrary,
    IdentityLibrary,
    PolynomialLibrary,
)
from ._library import ConcatLibrary, TensoredLibrary
from ._optimizers import STLSQ, BestSubset, LeastSquares
from ._report import Equation, Report, Summand
from ._sindy import SINDy
from ._sindyna import __version__
from ._system import System

__all__ = [
    "STLSQ",
    "BestSubset",
    "ConcatLibrary",
    "Controller",
    "ConvergenceWarning",
    "CustomLibrary",
    "DiscreteSINDy",
    "Equation",
    "FiniteDifference",
    "FormulaLibrary",
    "FourierLibrary",
    "GeneralizedLibrary",
    "IdentityLibrary",
    "Interval",
    "LeastSquares",
    "NotFittedError",
    "Policy",
    "PolynomialLibrary",
    "Report",
    "SINDy",
    "SmoothedFiniteDifference",
    "Summand",
    "System",
    "TensoredLibrary",
    "__version__",
    "learn",
    "load",
]

#: Names of PySINDy that are not here, and what to use.
_REFUSED = {
    **dict.fromkeys(
        [
            "SR3",
            "ConstrainedSR3",
            "StableLinearSR3",
            "TrappingSR3",
            "SSR",
            "FROLS",
            "MIOSR",
            "SBR",
            "WrappedOptimizer",
            "EvidenceGreedy",
        ],
        "optimizers are BestSubset (the default), STLSQ and LeastSquares; constraints are the arguments known, require, forbid and sign of SINDy",
    ),
    "EnsembleOptimizer": "the default optimizer estimates standard errors: read report_.equations[i].standard_errors",
    **dict.fromkeys(
        ["PDELibrary", "WeakPDELibrary", "WeakSINDy"],
        "partial differential equations and the weak form are not supported",
    ),
    **dict.fromkeys(
        ["SINDyPI", "ParallelImplicitSINDy"],
        "the default optimizer tries terms that hold derivatives of states by itself",
    ),
    **dict.fromkeys(
        ["SINDyDerivative", "SpectralDerivative"],
        "use FiniteDifference or SmoothedFiniteDifference, or give x_dot; the default optimizer needs no derivatives",
    ),
    "ParameterizedLibrary": "give parameters as inputs, and write a library of formulas",
}


def __getattr__(name: str) -> Any:
    if name in _REFUSED:
        raise AttributeError(f"sindyna has no {name}: {_REFUSED[name]}")
    raise AttributeError(f"module 'sindyna' has no attribute {name!r}")
