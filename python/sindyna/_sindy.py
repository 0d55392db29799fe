"""`SINDy`: samples in, equations out."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, ClassVar, TypeVar

import numpy as np

from . import _files, _show
from ._account import Account
from ._data import Array, columns, is_list, trajectories
from ._differentiation import Differentiation
from ._fit import Fitted, differentiated, fit
from ._known import Formulas
from ._library import FeatureLibrary
from ._optimizers import Optimizer
from ._params import Parameters
from ._simulate import simulate
from ._sklearn import Manners

Self = TypeVar("Self", bound="SINDy")
Map = TypeVar("Map", bound="DiscreteSINDy")


class SINDy(Account, Manners, Parameters):
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

    def _inputs(self, fitted: Fitted, x: Any, u: Any, name: str) -> tuple[Array, Array]:
        own = columns(x)
        if (
            own is not None
            and (known := own[: len(fitted.names.states)]) != fitted.names.states
            and not isinstance(self.controls, list)
        ):
            raise ValueError(f"the columns of {name} are {known}, the model was fitted to {fitted.names.states}")
        u = _needed(fitted, u)
        given = trajectories(
            x, 1.0, u, None, default_dt=1.0, controls=self.controls, n_inputs=len(fitted.names.inputs)
        )[0]
        n = len(fitted.names.states)
        if given.x.shape[1] != n:
            raise ValueError(f"{name} must have {n} columns ({', '.join(fitted.names.states)}), got {given.x.shape[1]}")
        if len(given.u) != len(given.x) and given.u.shape[1]:
            raise ValueError(f"u must have a row for each of the {len(given.x)} rows of {name}, got {len(given.u)}")
        return np.ascontiguousarray(given.x), np.ascontiguousarray(given.u)

    def predict(self, x: Any, u: Any = None) -> Any:
        """
        Derivatives at states; next states of a map.

        Parameters
        ----------
        x : array (N, n), DataFrame, or list of these
            States.
        u : array (N, k), or list of these, optional
            Inputs.

        Returns
        -------
        array (N, n), or list of these
            Derivatives [unit of the state per second], or next states.
        """
        fitted = self._known_model()
        if is_list(x):
            us = [None] * len(x) if u is None else u
            if len(us) != len(x):
                raise ValueError(
                    f"x is a list of {len(x)} trajectories, so u must be a list of {len(x)}, got {len(us)}"
                )
            return [self.predict(one, inputs) for one, inputs in zip(x, us, strict=True)]
        states, inputs = self._inputs(fitted, x, u, "x")
        return fitted.model.right_side(states, inputs)

    def step(self, x: Any, u: Any = None) -> Array:
        """
        States after one sampling interval, in which inputs are held, stepped as the equations were identified.

        Parameters
        ----------
        x : array (N, n)
            States.
        u : array (N, k), optional
            Inputs.

        Returns
        -------
        array (N, n)
            States `dt_` seconds later; NaN where they leave the finite numbers.
        """
        fitted = self._known_model()
        return fitted.model.step(*self._inputs(fitted, x, u, "x"))

    def simulate(
        self,
        x0: Any,
        t: Any,
        u: Any = None,
        *,
        rtol: float = 1e-8,
        atol: float = 1e-10,
        stop_condition: Callable[[Array], Any] | None = None,
    ) -> Array:
        """
        States from a start on. As many rows as times, also with inputs.

        Parameters
        ----------
        x0 : array (n,)
            State at the first time.
        t : array (T,), or int
            Times [s] of equations in continuous time. For a map, and for equations that are stepped by Euler, the number of samples, or times
            one sampling interval apart.
        u : array (T, k) or (T - 1, k), or callable, optional
            Inputs at these times, held or in straight lines between them (``intersample``); or a function of time that gives k numbers.
        rtol, atol : float
            Relative and absolute errors allowed in each step of the solver (continuous time only).
        stop_condition : callable, optional
            A function of a state (n,); the first state after the start for which it is true is the last one told.

        Returns
        -------
        array (T, n)
            States.

        Raises
        ------
        ArithmeticError
            If the states leave the finite numbers.
        """
        fitted = self._known_model()
        states = simulate(fitted, self.intersample, x0, t, _needed(fitted, u), rtol, atol)
        stops = (i for i in range(1, len(states)) if stop_condition is not None and stop_condition(states[i]))
        return states[: next(stops, len(states)) + 1]

    def _judged(self, x: Any, t: Any, x_dot: Any, u: Any) -> tuple[Fitted, list[Any]]:
        fitted = self._known_model()
        u = _needed(fitted, u)
        data = trajectories(
            x, t, u, x_dot, default_dt=fitted.model.dt, controls=self.controls, n_inputs=len(fitted.names.inputs)
        )
        if data[0].x.shape[1] != len(fitted.names.states):
            raise ValueError(f"x must have {len(fitted.names.states)} states, got {data[0].x.shape[1]}")
        return fitted, data

    def score(
        self,
        x: Any,
        t: Any = None,
        x_dot: Any = None,
        u: Any = None,
        metric: Callable[[Array, Array], float] | None = None,
    ) -> float:
        """
        How well `predict` explains derivatives, or next states of a map: those given, or estimated from samples (``differentiation_method``, or finite differences).

        Noise in the samples counts against the score, however good the equations are: see `compare` for a measure that is about trajectories.

        Parameters
        ----------
        x, t, x_dot, u
            As in `fit`. Without times, samples are `dt_` apart.
        metric : callable, optional
            A function of true and predicted derivatives (N, n); the coefficient of determination, averaged over states, by default.

        Returns
        -------
        float
            1 is perfect.
        """
        fitted, data = self._judged(x, t, x_dot, u)
        true, predicted = [], []
        for one in data:
            if fitted.model.form == "discrete":
                known = one.x_dot is not None
                states, target = (one.x, one.x_dot) if known else (one.x[:-1], one.x[1:])
                states, target = states[: len(one.u)], target[: len(one.u)]
                inputs = one.u[: len(states)]
            else:
                moved = differentiated(self, one)
                if moved.x_dot is None:
                    continue
                states, target = moved.x[: len(one.u)], moved.x_dot[: len(one.u)]
                inputs = one.u[: len(states)]
            true.append(target)
            predicted.append(fitted.model.right_side(np.ascontiguousarray(states), np.ascontiguousarray(inputs)))
        y, f = np.concatenate(true), np.concatenate(predicted)
        return float((metric or _r2)(y, f))

    def compare(self, x: Any, t: Any = None, u: Any = None, horizon: int | None = None) -> Array:
        """
        How well the equations predict trajectories: 1 - |x - x_model| / |x - mean x| of each state.

        Parameters
        ----------
        x, t, u
            As in `fit`.
        horizon : int, optional
            How many steps ahead each sample is predicted; from the first sample of its trajectory by default.

        Returns
        -------
        array (n,)
            1 is perfect, 0 no better than the mean.
        """
        _, data = self._judged(x, t, None, u)
        ahead = self._ahead(data, horizon)
        measured, predicted = np.concatenate([one.x[1:] for one in data]), np.concatenate([a[1:] for a in ahead])
        missed = np.linalg.norm(measured - predicted, axis=0)
        moved = np.linalg.norm(measured - measured.mean(axis=0), axis=0)
        result: Array = 1.0 - missed / moved
        return result

    def _ahead(self, data: list[Any], horizon: int | None) -> list[Array]:
        fitted = self._known_model()
        if horizon is not None and (horizon != int(horizon) or horizon < 1):
            raise ValueError(f"horizon must be a whole number of at least 1, got {horizon!r}")
        return [
            fitted.model.ahead(one.x, np.ascontiguousarray(one.u[: len(one.x) - 1]), np.diff(one.t), horizon)
            for one in data
        ]

    def linearize(self, x: Any, u: Any = None) -> tuple[Array, Array]:
        """
        Jacobians of the right-hand sides at one state and input, exact from the terms.

        Parameters
        ----------
        x : array (n,)
            State.
        u : array (k,), optional
            Input; zero by default.

        Returns
        -------
        tuple of array (n, n) and array (n, k)
            Derivatives with respect to the state and to the input.
        """
        fitted = self._known_model()
        inputs = np.zeros(len(fitted.names.inputs)) if u is None else np.asarray(u, dtype=np.float64).reshape(-1)
        return fitted.model.jacobians(np.asarray(x, dtype=np.float64).reshape(-1), inputs)

    def plot(self, x: Any, t: Any = None, u: Any = None, horizon: int | None = None) -> Any:
        """
        Draws samples and what the equations make of them.

        Parameters
        ----------
        x, t, u, horizon
            As in `compare`.

        Returns
        -------
        matplotlib.figure.Figure
        """
        fitted, data = self._judged(x, t, None, u)
        return _show.plot(
            fitted.names.states, [one.t for one in data], [one.x for one in data], self._ahead(data, horizon)
        )

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
        model = DiscreteSINDy(**params) if kind == "DiscreteSINDy" else SINDy(**params)
        model._fitted = fitted
        return model


def _needed(fitted: Fitted, u: Any) -> Any:
    """Inputs, where the model has any."""
    if u is not None and not fitted.names.inputs:
        warnings.warn("the model has no inputs: u is left out", UserWarning, stacklevel=3)
        return None
    return u


def _r2(true: Array, predicted: Array) -> float:
    left = ((true - predicted) ** 2).sum(axis=0)
    total = ((true - true.mean(axis=0)) ** 2).sum(axis=0)
    # A derivative that never changes is explained wholly or not at all.
    each = np.where(total > 0.0, 1.0 - left / np.where(total > 0.0, total, 1.0), np.where(left > 0.0, 0.0, 1.0))
    return float(each.mean())


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
