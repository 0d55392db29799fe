"""Examples written for PySINDy run with the import changed, and its numbers come out."""

import numpy as np
import pytest

import sindyna
import sindyna as ps
from systems import assert_found, lorenz, pendulum


def readme_data():
    t = np.linspace(0, 1, 100)
    return t, np.stack((3 * np.exp(-2 * t), 0.5 * np.exp(t)), axis=-1)


def test_the_readmes_first_example(capsys):
    t, x = readme_data()
    model = ps.SINDy(feature_names=["x", "y"])
    model.fit(x, t=t)
    model.print()
    assert capsys.readouterr().out == "(x)' = -2.000 x\n(y)' = 1.000 y\n"
    assert np.abs(model.simulate(x[0], t) - x).max() < 1e-5
    assert model.score(x, t=t) > 0.9999


def test_thresholded_least_squares_has_pysindys_numbers():
    # PySINDy 2.1.0, default model: the third significant digit of these is what its threshold left after the last solve.
    t, x = readme_data()
    model = ps.SINDy(optimizer=ps.STLSQ()).fit(x, t=t, feature_names=["x", "y"])
    names = model.get_feature_names()
    assert names == ["1", "x", "y", "x^2", "x y", "y^2"]
    expected = np.zeros((2, 6))
    expected[0, 1], expected[1, 0], expected[1, 2], expected[1, 5] = (
        -2.000119452993,
        -2.773341650601e-5,
        1.000085704596,
        -4.029690185249e-5,
    )
    assert np.abs(model.coefficients() - expected).max() < 1e-10
    assert model.score(x, t=t) == pytest.approx(0.9999999962946119, abs=1e-13)
    assert model.equations()[1] == "-2.773e-05 + 1.000 y + -4.030e-05 y^2"
    assert model.complexity == 4


def test_lorenz_by_thresholding_has_pysindys_numbers():
    t = np.arange(0, 10, 0.002)
    from systems import follow

    def rate(s, z):
        return [10 * (z[1] - z[0]), z[0] * (28 - z[2]) - z[1], z[0] * z[1] - 2.66667 * z[2]]

    x = follow(rate, [-8, 8, 27], t[:2000])
    model = ps.SINDy(
        optimizer=ps.STLSQ(),
        feature_library=ps.PolynomialLibrary(degree=2),
        differentiation_method=ps.FiniteDifference(),
    )
    model.fit(x, t=t[:2000], feature_names=["x", "y", "z"])
    assert_found(model, [{"x": -10, "y": 10}, {"x": 28, "y": -1, "x z": -1}, {"z": -2.66667, "x y": 1}], 0.01)


def test_control_inputs_are_features_of_a_library():
    t, x, u = pendulum()
    library = ps.PolynomialLibrary(degree=1) + ps.FourierLibrary()
    model = ps.SINDy(optimizer=ps.STLSQ(threshold=0.2), feature_library=library)
    model.fit(x, t=t, u=u)
    assert model.get_feature_names()[:4] == ["1", "x0", "x1", "u0"]
    assert model.get_feature_names()[4:6] == ["sin(1 x0)", "cos(1 x0)"]
    assert (model.n_features_in_, model.n_control_features_, model.n_output_features_) == (3, 1, 10)
    assert model.predict(x, u=u).shape == x.shape
    # Array inputs do not shorten the simulation.
    assert model.simulate(x[0], t[:50], u=u[:50]).shape == (50, 2)


def test_libraries_are_pysindys():
    t, x = lorenz(n=50)

    def names(library):
        return ps.SINDy(ps.LeastSquares(alpha=1e-6), library).fit(x[:, :2], t=t).get_feature_names()

    assert names(ps.PolynomialLibrary(3, include_bias=False)) == [
        "x0",
        "x1",
        "x0^2",
        "x0 x1",
        "x1^2",
        "x0^3",
        "x0^2 x1",
        "x0 x1^2",
        "x1^3",
    ]
    assert names(ps.PolynomialLibrary(2, include_interaction=False)) == ["1", "x0", "x1", "x0^2", "x1^2"]
    assert names(ps.IdentityLibrary() * ps.FourierLibrary()) == [
        f"{a} {f}(1 {b})" for a in ("x0", "x1") for b in ("x0", "x1") for f in ("sin", "cos")
    ]
    custom = ps.CustomLibrary(
        [lambda x: np.exp(-(x**2)), lambda x, y: np.sin(x + y)],
        [lambda s: f"exp(-{s}^2)", lambda s, r: f"sin({s}+{r})"],
    )
    assert names(custom) == ["exp(-x0^2)", "exp(-x1^2)", "sin(x0+x1)"]
    assert names(
        ps.GeneralizedLibrary([ps.IdentityLibrary(), ps.PolynomialLibrary(2)], inputs_per_library=[[0], [1]])
    ) == ["x0", "1", "x1", "x1^2"]
    assert names(ps.FormulaLibrary(["x0*sin(x1)"])) == ["x0*sin(x1)"]


def test_functions_become_formulas_that_have_their_values():
    rng = np.random.default_rng(0)
    x = rng.uniform(0.5, 2.0, size=(40, 2))
    functions = [lambda a: 2 / a - np.sqrt(a) * a**-2, lambda a, b: abs(a - 3) * np.tanh(-b) / (1 + np.square(b))]
    truth = [functions[0](x[:, 0]), functions[0](x[:, 1]), functions[1](x[:, 0], x[:, 1])]
    x_dot = np.column_stack([truth[0] - 2 * truth[2], 3 * truth[1]])
    model = ps.SINDy(ps.LeastSquares(), ps.CustomLibrary(functions)).fit(x, t=0.1, x_dot=x_dot)
    assert np.abs(model.coefficients() - [[1, 0, -2], [0, 3, 0]]).max() < 1e-9
    assert np.abs(model.predict(x) - x_dot).max() < 1e-9


def test_the_larger_the_smaller_and_limits_become_formulas():
    x = np.random.default_rng(1).uniform(-2.0, 2.0, size=(60, 2))
    functions = [lambda a: np.maximum(a - 0.4, 0), lambda a, b: np.clip(a, -1, 1) * np.minimum(a, b)]
    x_dot = np.column_stack([functions[0](x[:, 0]), 2 * functions[1](x[:, 0], x[:, 1])])
    model = ps.SINDy(ps.LeastSquares(), ps.CustomLibrary(functions)).fit(x, t=0.1, x_dot=x_dot)
    assert np.abs(model.coefficients() - [[1, 0, 0], [0, 0, 2]]).max() < 1e-9
    assert np.abs(model.predict(x) - x_dot).max() < 1e-9


def test_known_derivatives_are_regressed():
    _, x = lorenz(n=300)
    rate = np.column_stack(
        [10 * (x[:, 1] - x[:, 0]), x[:, 0] * (28 - x[:, 2]) - x[:, 1], x[:, 0] * x[:, 1] - 8 / 3 * x[:, 2]]
    )
    for optimizer in (None, ps.STLSQ()):
        model = ps.SINDy(optimizer).fit(x, t=0.01, x_dot=rate, feature_names=["x", "y", "z"])
        assert_found(model, [{"x": -10, "y": 10}, {"x": 28, "y": -1, "x z": -1}, {"z": -8 / 3, "x y": 1}], 1e-8)
        assert model.score(x, x_dot=rate) > 1 - 1e-12


@pytest.mark.parametrize(
    ("model", "match"),
    [
        (ps.SINDy(ps.STLSQ(initial_guess=np.zeros(3))), "initial_guess"),
        (ps.SINDy(ps.STLSQ(verbose=True)), "verbose"),
        (ps.SINDy(ps.STLSQ(), noise="none"), "noise='none'"),
        (ps.SINDy(ps.STLSQ(), angles=["x0"]), "angles"),
        (ps.SINDy(discrete_time=True, known={"x0": "x0"}), "known"),
        (ps.SINDy(differentiation_method=ps.FiniteDifference(d=2)), "d=1"),
        (ps.SINDy(ps.STLSQ(), ps.CustomLibrary([lambda x: np.sinh(x)])), "sinh"),
        (ps.SINDy(ps.STLSQ(), ps.CustomLibrary([lambda x: x**1.7])), "whole numbers"),
        (ps.SINDy(ps.STLSQ(), ps.CustomLibrary([lambda x: x if x > 0 else 0])), "formula"),
        (ps.SINDy(object()), "optimizer"),
        (ps.SINDy(feature_library=object()), "library"),
        (ps.SINDy(differentiation_method=object()), "differentiation_method"),
    ],
)
def test_what_the_engine_cannot_do_is_refused_with_the_reason(model, match):
    t, x = lorenz(n=60)
    with pytest.raises(NotImplementedError, match=match):
        model.fit(x, t=t)


def test_names_of_pysindy_that_are_not_here_say_what_to_use():
    with pytest.raises(AttributeError, match="STLSQ and LeastSquares"):
        _ = ps.SR3
    with pytest.raises(AttributeError, match="no attribute"):
        _ = ps.nothing_of_the_kind
    assert not hasattr(sindyna, "WeakPDELibrary")


def test_smoothed_differences_and_uneven_times_serve_thresholding():
    t, x = lorenz(n=1000, noise=0.05)
    names = ["x", "y", "z"]
    smooth = ps.SINDy(ps.STLSQ(threshold=0.5), differentiation_method=ps.SmoothedFiniteDifference()).fit(
        x, t=t, feature_names=names
    )
    plain = ps.SINDy(ps.STLSQ(threshold=0.5), differentiation_method=ps.FiniteDifference()).fit(
        x, t=t, feature_names=names
    )
    assert smooth.score(x, t=t) > plain.score(x, t=t)
    keep = np.sort(np.random.default_rng(0).choice(1000, 700, replace=False))
    uneven = ps.SINDy(ps.STLSQ(threshold=0.5)).fit(lorenz(n=1000)[1][keep], t=t[keep], feature_names=names)
    assert abs(uneven.coefficients()[0, 1] + 10) < 0.5
    with pytest.raises(NotImplementedError, match="order"):
        ps.SINDy(ps.STLSQ(), differentiation_method=ps.FiniteDifference(order=4)).fit(x[keep], t=t[keep])
