"""`SINDy`: samples in, equations out."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeVar

from . import _files
from ._differentiation import Differentiation
from ._fit import fit
from ._known import Formulas
from ._library import FeatureLibrary
from ._optimizers import Optimizer
from ._params import Parameters
from ._quality import Quality
from ._sklearn import Manners

Self = TypeVar("Self", bound="SINDy")


class SINDy(Quality, Manners, Parameters):
    """
    Sparse identification of nonlinear dynamics: equations of motion from samples.

    By default the noise of every channel is estimated together with the equations, whole trajectories are fitted, every coefficient has a
    standard error, and `report_` tells what speaks against the result. With another optimizer, a differentiation method, known derivatives,
    or in discrete time it is one regression, as PySINDy makes it.

    Parameters
    ----------
    optimizer : BestSubset, STLSQ or LeastSquares, optional
        How coefficients are found; `BestSubset`, sindyna's own estimator, by default.
    feature_library : FeatureLibrary, optional
        Candidate terms. By default the estimator has its own: polynomials, sines and cosines of angles, friction, saturation and others; a
        regression has polynomials of degree 2.
    differentiation_method : FiniteDifference, SmoothedFiniteDifference or callable, optional
        How derivatives are estimated; a function of samples (T, n) and times (T,) gives derivatives (T, n). The estimator needs none.
    feature_names : list of str, optional
        Names of states, and of inputs after them, where `fit` is told none.
    t_default : float
        Sampling interval [s] where `fit` is told no times.
    discrete_time : bool
        Whether the equations are a map from sample to sample, fitted by one regression.
    noise : "auto", "none", dict or sequence
        What is believed of the errors of samples: they are estimated ("auto"); there are none but rounding ("none"), and an equation that leaves
        more is called an approximation; or they have at least these standard deviations, by state, in its unit.
    angles : list of str, optional
        States that are angles [rad]: terms are their sines and cosines.
    rates : dict, optional
        Which state is the rate of which: ``{"w": "th"}`` says that w is the time derivative of th, which is then not fitted.
    known : dict, optional
        Parts of equations, coefficients included: ``{"w": "-9.81*sin(th)"}``. The rest is looked for.
    require, forbid : dict, optional
        Terms an equation has, or does not have: ``{"w": ["u"]}``.
    sign : dict, optional
        Signs of coefficients: ``{"w": {"w": "-"}}``.
    terms : list of str, optional
        Candidate terms beside those of the library: ``["v*abs(v)"]``.
    intersample : "zoh" or "foh"
        What inputs do between samples: they are held, or go in straight lines.
    controls : int or list of str, optional
        How many of the last columns of ``x`` are inputs, or which columns of a DataFrame. For cross-validation, which splits ``x`` alone.

    Examples
    --------
    A damped oscillator, seen with noise that nobody declares:

    >>> import numpy as np, sindyna
    >>> t = 0.02 * np.arange(1000)
    >>> x = np.exp(-0.1 * t) * np.cos(2 * t)
    >>> v = np.exp(-0.1 * t) * (-0.1 * np.cos(2 * t) - 2 * np.sin(2 * t))
    >>> noisy = np.column_stack([x, v]) + 0.01 * np.random.default_rng(0).normal(size=(1000, 2))
    >>> model = sindyna.SINDy(rates={"v": "x"}).fit(noisy, t=t, feature_names=["x", "v"])
    >>> model.print(precision=1)
    (x)' = 1.0 v
    (v)' = -4.0 x + -0.2 v
    >>> model.report_.certainty
    'adequate'
    """

    def __init__(
        self,
        optimizer: Optimizer | None = None,
        feature_library: FeatureLibrary | None = None,
        differentiation_method: Differentiation | Callable[..., Any] | None = None,
        feature_names: Sequence[str] | None = None,
        t_default: float = 1.0,
        discrete_time: bool = False,
        *,
        noise: str | Mapping[str, float] | Sequence[float] = "auto",
        angles: Iterable[str] | None = None,
        rates: Mapping[str, str] | None = None,
        known: Formulas | None = None,
        require: Formulas | None = None,
        forbid: Formulas | None = None,
        sign: Mapping[str, Mapping[str, Any]] | None = None,
        terms: Sequence[str] | None = None,
        intersample: str = "zoh",
        controls: int | list[str] | None = None,
    ) -> None:
        self.optimizer = optimizer
        self.feature_library = feature_library
        self.differentiation_method = differentiation_method
        self.feature_names = feature_names
        self.t_default = t_default
        self.discrete_time = discrete_time
        self.noise = noise
        self.angles = angles
        self.rates = rates
        self.known = known
        self.require = require
        self.forbid = forbid
        self.sign = sign
        self.terms = terms
        self.intersample = intersample
        self.controls = controls

    def fit(self: Self, x: Any, t: Any = None, x_dot: Any = None, u: Any = None, feature_names: Any = None) -> Self:
        """
        Finds the equations behind samples. Releases the interpreter's lock; Ctrl-C ends it and leaves what was fitted before.

        Parameters
        ----------
        x : array (T, n), DataFrame, or list of these
            Samples of states, rows of time; a list for several trajectories. A DataFrame names the states.
        t : float, array (T,), or list of these, optional
            Sampling interval [s], or times [s], which need not be even. By default the index of a DataFrame if that is times, else
            ``t_default``. Where a few samples are missing from even ones, the trajectory is cut there.
        x_dot : array (T, n), or list of these, optional
            Known derivatives, next states of a map; then they are regressed.
        u : array (T, k) or (T - 1, k), DataFrame, or list of these, optional
            Inputs, at the times of the samples.
        feature_names : list of str, optional
            Names of states, and of inputs after them; those of the constructor, or of a DataFrame, by default.

        Returns
        -------
        self
        """
        self._fitted = fit(self, x, t, x_dot, u, self.feature_names if feature_names is None else feature_names)
        return self

    def save(self, path: str | os.PathLike[str]) -> None:
        """
        Writes the fitted model as JSON, with every digit. Functions of a `CustomLibrary` are written as formulas.

        Parameters
        ----------
        path : str or path
            The file.
        """
        _files.save(path, type(self).__name__, self.get_params(deep=False), self._known_model())

    def export(self, to: str, path: str | os.PathLike[str] | None = None) -> str | bytes:
        """
        The equations as a program that needs nothing of sindyna.

        Parameters
        ----------
        to : str
            ``"python"``, ``"c"``, ``"javascript"``, ``"rust"``, ``"latex"``, ``"casadi"``, ``"onnx"`` or ``"fmu"``.
        path : str or path, optional
            File to write.

        Returns
        -------
        str or bytes
            The program: ``rhs(x, u)`` gives the rates, ``step(x, u)`` the state one sampling interval later. ONNX and FMU are bytes.

        Examples
        --------
        >>> import numpy as np, sindyna
        >>> model = sindyna.SINDy().fit(np.exp(-2.0 * np.arange(0.0, 2.0, 0.01))[:, None], t=0.01)
        >>> "def rhs(x, u" in str(model.export("python"))
        True
        """
        fitted = self._known_model()
        return _files.exported(fitted.model, None, (fitted.names.states, fitted.names.inputs, []), to, path)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> SINDy:
        """
        Reads a model that `save` wrote. Nothing in the file is run.

        Parameters
        ----------
        path : str or path
            The file.

        Returns
        -------
        SINDy
            The same model: its predictions are the same to the last bit.
        """
        kind, params, fitted = _files.load(path)
        kinds = {one.__name__: one for one in SINDy.__subclasses__()}
        model = kinds.get(kind, SINDy)(**params)
        model._fitted = fitted
        return model
