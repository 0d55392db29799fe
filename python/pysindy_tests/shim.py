"""PySINDy's names over `sindyna`: a plugin of pytest that makes ``import pysindy`` find them.

Names that sindyna has are its own classes, with PySINDy's defaults and arguments. Any other name is an `Absent` one: it can be called and
handed on, so that tests can be collected, and a test that uses it is skipped with its name.
"""

import importlib.abc
import importlib.machinery
import sys
import types
import unittest.mock
import warnings

import numpy as np
import pytest
import sklearn.exceptions

import sindyna

#: Packages that PySINDy's tests import for what sindyna does not have.
FOREIGN = ("jax", "cvxpy")


#: What sindyna says of samples with more than two axes.
FIELDS = "must have shape (samples, signals), got"

#: Names of what is absent that the running test used.
USED = []


def absent(name):
    pytest.skip(f"not here: {name}")


class Absent:
    """Something of PySINDy that sindyna does not have; classes that tests derive from it are absent too."""

    def __init__(self, *args, **kwargs):
        self.name = getattr(type(self), "NAME", args[0] if args else "?")
        USED.append(self.name)

    def __call__(self, *args, **kwargs):
        return Absent(self.name)

    def __getattr__(self, name):
        if name.startswith("__") or name in ("NAME", "pytestmark", "_pytestfixturefunction"):
            raise AttributeError(name)
        absent(self.name)

    def __add__(self, other):
        return Absent(self.name)

    __mul__ = __add__


class AbsentClass(type):
    def __getattr__(cls, name):
        if name.startswith("__") or name == "NAME":
            raise AttributeError(name)
        absent(cls.NAME)


def absent_class(name):
    return AbsentClass(name, (Absent,), {"NAME": name})


def told(error):
    """The error as scikit-learn's, where it has one."""
    return sklearn.exceptions.NotFittedError(str(error))


class Model:
    """What PySINDy's models do otherwise: defaults, and arguments by other names."""

    def fit(self, *args, **kwargs):
        for part in (self.optimizer, self.feature_library, getattr(self, "differentiation_method", None)):
            if isinstance(part, Absent):
                absent(part.name)
            if type(part).__module__.startswith("sklearn"):
                absent("regressions of scikit-learn as optimizers")
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            super().fit(*args, **kwargs)
        for one in caught:
            same = one.category is sindyna.ConvergenceWarning
            warnings.warn(
                str(one.message), sklearn.exceptions.ConvergenceWarning if same else one.category, stacklevel=2
            )
        return self

    def _known_model(self):
        try:
            return super()._known_model()
        except sindyna.NotFittedError as error:
            raise told(error) from None

    def simulate(
        self,
        x0,
        t,
        u=None,
        integrator="solve_ivp",
        stop_condition=None,
        interpolator=None,
        integrator_kws=None,
        interpolator_kws=None,
    ):
        if integrator not in ("solve_ivp", "odeint"):
            raise ValueError(f"there is no integrator {integrator}")
        allowed = {name: value for name, value in (integrator_kws or {}).items() if name in ("rtol", "atol")}
        return super().simulate(x0, t, u, stop_condition=stop_condition, **allowed)


class SINDy(Model, sindyna.SINDy):
    def __init__(self, optimizer=None, feature_library=None, differentiation_method=None):
        super().__init__(
            sindyna.STLSQ() if optimizer is None else optimizer,
            sindyna.PolynomialLibrary() if feature_library is None else feature_library,
            sindyna.FiniteDifference() if differentiation_method is None else differentiation_method,
        )


class DiscreteSINDy(Model, sindyna.DiscreteSINDy):
    def __init__(self, optimizer=None, feature_library=None):
        super().__init__(
            sindyna.STLSQ() if optimizer is None else optimizer,
            sindyna.PolynomialLibrary() if feature_library is None else feature_library,
        )


class FiniteDifference(sindyna.FiniteDifference):
    def _differentiate(self, x, t=1.0, *dt):
        # The engine hands over the interval too; PySINDy's tests call it with samples and times.
        return super()._differentiate(x, t, *dt) if dt else self(x, t)


class SmoothedFiniteDifference(sindyna.SmoothedFiniteDifference):
    def _differentiate(self, x, t=1.0, *dt):
        return super()._differentiate(x, t, *dt) if dt else self(x, t)


class SINDyDerivative(sindyna.FiniteDifference.__mro__[2]):
    """Derivatives by the package `derivative`, as a function of samples and times."""

    def __init__(self, **kwargs):
        self.kwargs = kwargs

    def set_params(self, **params):
        self.kwargs = params.get("kwargs", {**self.kwargs, **params})
        return self

    def get_params(self, deep=True):
        return {**self.kwargs, "kwargs": self.kwargs} if deep else dict(self.kwargs)

    def __call__(self, x, t=1.0):
        from derivative import dxdt

        if np.ndim(t) == 0 and t <= 0:
            raise ValueError(f"t must be above 0, got {t}")
        self.smoothed_x_ = x
        return dxdt(x, np.arange(len(x)) * t if np.ndim(t) == 0 else t, axis=0, **self.kwargs)

    _differentiate = __call__


def lorenz(t, x, sigma=10, beta=8 / 3, rho=28):
    return [sigma * (x[1] - x[0]), x[0] * (rho - x[2]) - x[1], x[0] * x[1] - beta * x[2]]


def lorenz_control(t, x, u_fun, sigma=10, beta=8 / 3, rho=28):
    u = np.ravel(u_fun(t))
    first, second, third = lorenz(t, x, sigma, beta, rho)
    return [first + u[0], second, third - u[1]]


def logistic_map(x, mu):
    return mu * x * (1 - x)


def logistic_map_control(x, mu, u):
    return mu * x * (1 - x) + u


def logistic_map_multicontrol(x, mu, u):
    return mu * x * (1 - x) + u[0] * u[1]


def enzyme(t, x, jx=0.6, vmax=1.5, km=0.3):
    return jx - vmax * x / (km + x)


def _width(library, own=sindyna.PolynomialLibrary._width):
    try:
        return own(library)
    except sindyna.NotFittedError as error:
        raise told(error) from None


sindyna.PolynomialLibrary.__mro__[1]._width = _width


OURS = {
    name: getattr(sindyna, name)
    for name in [
        "STLSQ",
        "PolynomialLibrary",
        "FourierLibrary",
        "IdentityLibrary",
        "CustomLibrary",
        "ConcatLibrary",
        "TensoredLibrary",
        "GeneralizedLibrary",
    ]
} | {
    f.__name__: f
    for f in (
        SINDy,
        DiscreteSINDy,
        FiniteDifference,
        SmoothedFiniteDifference,
        SINDyDerivative,
        lorenz,
        lorenz_control,
        logistic_map,
        logistic_map_control,
        logistic_map_multicontrol,
        enzyme,
    )
}


class Module(types.ModuleType):
    """A module of PySINDy: our names, and absent ones for the rest."""

    __path__ = ()

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        if self.__name__.split(".")[0] in FOREIGN:
            return unittest.mock.MagicMock(name=f"{self.__name__}.{name}")
        if name in OURS:
            return OURS[name]
        return absent_class(name) if name[0].isupper() else Absent(name)


class Finder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in ("pysindy", *FOREIGN):
            return importlib.machinery.ModuleSpec(name, self, is_package=True)
        return None

    def create_module(self, spec):
        return Module(spec.name)

    def exec_module(self, module):
        pass


sys.meta_path.insert(0, Finder())


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item, call):
    """A test that fails on what sindyna refuses with a reason, or does not have, is skipped with that reason."""
    result = yield
    report = result.get_result()
    if call.excinfo is not None and call.excinfo.errisinstance(NotImplementedError):
        report.outcome = "skipped"
        report.longrepr = (str(item.path), 0, f"refused: {call.excinfo.value}")
    elif report.outcome == "failed" and (USED or FIELDS in str(call.excinfo.value)):
        report.outcome = "skipped"
        why = f"not here: {', '.join(sorted(set(USED)))}" if USED else "samples of fields, with more than two axes"
        report.longrepr = (str(item.path), 0, why)


def pytest_runtest_setup(item):
    USED.clear()
    given = getattr(item, "callspec", None)
    USED.extend(value.name for value in (given.params.values() if given else ()) if isinstance(value, Absent))
    USED.extend(value.NAME for value in (given.params.values() if given else ()) if isinstance(value, AbsentClass))
