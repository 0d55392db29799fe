"""Behaviours that PySINDy's own tests ask for, where they are about differential equations, maps and control; docs/pysindy.md lists them."""

import numpy as np
import pytest

import sindyna as ps
from systems import assert_found, follow, lorenz

#: Rates, start, seconds, samples, coefficients: systems that PySINDy brings along for its tests.
ODES = {
    "lotka": (lambda s, z: [5 * z[0] - z[0] * z[1], -5 * z[1] + z[0] * z[1]], [3.0, 4.0], 2.0, 400, [{"x0": 5, "x0 x1": -1}, {"x1": -5, "x0 x1": 1}]),
    "van der pol": (lambda s, z: [z[1], 0.5 * (1 - z[0] ** 2) * z[1] - z[0]], [2.0, 0.5], 12.0, 600, [{"x1": 1}, {"x0": -1, "x1": 0.5, "x0^2 x1": -0.5}]),
    "duffing": (lambda s, z: [z[1], -0.2 * z[1] - 0.05 * z[0] - z[0] ** 3], [1.5, 0.0], 15.0, 600, [{"x1": 1}, {"x0": -0.05, "x1": -0.2, "x0^3": -1}]),
    "linear": (lambda s, z: [-0.1 * z[0] + 2 * z[1], -2 * z[0] - 0.1 * z[1]], [2.0, 0.0], 8.0, 400, [{"x0": -0.1, "x1": 2}, {"x0": -2, "x1": -0.1}]),
    "cubic": (lambda s, z: [-0.1 * z[0] ** 3 + 2 * z[1] ** 3, -2 * z[0] ** 3 - 0.1 * z[1] ** 3], [2.0, 0.0], 6.0, 600, [{"x0^3": -0.1, "x1^3": 2}, {"x0^3": -2, "x1^3": -0.1}]),
    "rossler": (lambda s, z: [-z[1] - z[2], z[0] + 0.2 * z[1], 0.2 + z[2] * (z[0] - 5.7)], [5.0, 3.0, 0.0], 15.0, 1000, [{"x1": -1, "x2": -1}, {"x0": 1, "x1": 0.2}, {"1": 0.2, "x2": -5.7, "x0 x2": 1}]),
}  # fmt: skip


@pytest.mark.parametrize("name", ODES)
def test_systems_of_its_tests_are_found_with_their_coefficients(name):
    rate, start, end, n, equations = ODES[name]
    t = np.linspace(0, end, n)
    model = ps.SINDy(ps.STLSQ(threshold=0.02, alpha=1e-8), ps.PolynomialLibrary(3)).fit(
        follow(rate, start, t), t=t, x_dot=np.array([rate(0, z) for z in follow(rate, start, t)])
    )
    assert_found(model, equations, 1e-6)


def test_names_of_features_with_inputs():
    t, x = lorenz(n=60)
    u = np.column_stack([np.sin(t), np.cos(3 * t)])
    assert len(ps.SINDy(ps.STLSQ()).fit(x, t=t, u=u).get_feature_names()) == 21
    assert ps.SINDy(ps.STLSQ(), ps.PolynomialLibrary(1)).fit(x, t=t, u=u[:, :1]).get_feature_names() == [
        "1",
        "x0",
        "x1",
        "x2",
        "u0",
    ]


def test_inputs_are_found_and_their_last_row_is_not_needed():
    t = np.arange(0, 4, 0.01)
    u = np.sin(2 * t)[:, None] ** 2

    def rate(s, z):
        return [10 * (z[1] - z[0]) + np.sin(2 * s) ** 2, z[0] * (28 - z[2]) - z[1], z[0] * z[1] - 8 / 3 * z[2]]

    x = follow(rate, [-8, 8, 27], t)
    x_dot = np.array([rate(s, z) for s, z in zip(t, x, strict=True)])
    model = ps.SINDy(ps.STLSQ(threshold=0.5)).fit(x, t=t, u=u, x_dot=x_dot)
    assert_found(
        model, [{"x0": -10, "x1": 10, "u0": 1}, {"x0": 28, "x1": -1, "x0 x2": -1}, {"x2": -8 / 3, "x0 x1": 1}], 1e-6
    )
    assert np.abs(model.predict(x, u) - x_dot).max() < 1e-6
    with pytest.raises(ValueError, match="row"):
        ps.SINDy(ps.STLSQ()).fit(x, t=t, u=u[:-5])
    with pytest.raises(TypeError, match="input"):
        model.predict(x)


def test_several_trajectories_are_one_regression():
    t, first = lorenz(n=300)
    second = follow(
        lambda s, z: [10 * (z[1] - z[0]), z[0] * (28 - z[2]) - z[1], z[0] * z[1] - 8 / 3 * z[2]], [5, -3, 20], t[:200]
    )
    model = ps.SINDy(ps.STLSQ()).fit([first, second], t=[t, t[:200]])
    assert model.score([first, second], t=[t, t[:200]]) > 0.999
    assert model.complexity == 7
    assert [len(p) for p in model.predict([first, second])] == [300, 200]


@pytest.mark.parametrize("forced", [False, True])
def test_the_logistic_map(forced):
    rng = np.random.default_rng(0)
    u = rng.uniform(-0.05, 0.05, size=(150, 1)) if forced else np.zeros((150, 0))
    x = [0.5]
    for i in range(149):
        x.append(3.6 * x[-1] * (1 - x[-1]) + float(u[i].sum()))
    model = ps.DiscreteSINDy(ps.STLSQ(threshold=0.05, alpha=1e-8)).fit(np.array(x)[:, None], u=u if forced else None)
    assert_found(model, [{"x0": 3.6, "x0^2": -3.6, **({"u0": 1} if forced else {})}], 1e-9)
    assert model.score(np.array(x)[:, None], u=u if forced else None) > 1 - 1e-12
    followed = model.simulate(np.array([0.5]), 20, u=u[:20] if forced else None)
    assert followed[:, 0] == pytest.approx(x[:20], abs=1e-9)


def test_a_map_is_found_from_pairs_of_states_too():
    x = np.random.default_rng(1).uniform(0.1, 0.9, size=(60, 1))
    u = np.random.default_rng(2).uniform(-0.1, 0.1, size=(60, 1))
    after = 3.6 * x * (1 - x) + u
    model = ps.DiscreteSINDy(ps.STLSQ(threshold=0.05, alpha=1e-8)).fit(x, 1, after, u)
    assert_found(model, [{"x0": 3.6, "x0^2": -3.6, "u0": 1}], 1e-9)
    assert model.score(x, 1, after, u) > 1 - 1e-12
    assert model.score(x, 1, 1 - after, u) < 0.9
    with pytest.raises(ValueError, match="60 samples"):
        ps.DiscreteSINDy(ps.STLSQ()).fit(x, 1, after, u[:-1])


def test_a_simulation_ends_where_a_condition_holds():
    t, x = lorenz(n=300)
    model = ps.SINDy(ps.STLSQ()).fit(x, t=t)
    whole = model.simulate(x[0], t)
    some = model.simulate(x[0], t, stop_condition=lambda z: z[0] > 0)
    assert 1 < len(some) < len(t)
    assert np.array_equal(some, whole[: len(some)])
    assert some[-1, 0] > 0
    assert (some[1:-1, 0] <= 0).all()


def test_thresholding_warns_of_what_it_came_to():
    t, x = lorenz(n=100)
    with pytest.warns(UserWarning, match="no term in the equation of x0, x1, x2"):
        ps.SINDy(ps.STLSQ(threshold=1e4)).fit(x, t=t)
    with pytest.warns(ps.ConvergenceWarning, match="max_iter"):
        ps.SINDy(ps.STLSQ(max_iter=1)).fit(x, t=t)


def test_derivatives_come_from_any_function_of_samples_and_times():
    t, x = lorenz(n=400)
    ours = ps.SINDy(ps.STLSQ()).fit(x, t=t)
    theirs = ps.SINDy(ps.STLSQ(), differentiation_method=lambda x, t: np.gradient(x, t, axis=0, edge_order=2)).fit(
        x, t=t
    )
    assert np.abs(ours.coefficients() - theirs.coefficients()).max() < 1e-8
    assert np.abs(ps.FiniteDifference()(x, t) - np.gradient(x, t, axis=0, edge_order=2)).max() < 1e-9
    with pytest.raises(ValueError, match="shape"):
        ps.SINDy(ps.STLSQ(), differentiation_method=lambda x, t: x[:-1]).fit(x, t=t)


def test_settings_that_mean_nothing_are_refused_when_they_are_made():
    for made in (
        lambda: ps.STLSQ(threshold=-1),
        lambda: ps.STLSQ(max_iter=0),
        lambda: ps.FourierLibrary(n_frequencies=2.2),
        lambda: ps.FourierLibrary(include_sin=False, include_cos=False),
        lambda: ps.FiniteDifference(order=0),
        lambda: ps.CustomLibrary([np.sin, np.cos], [str]),
    ):
        with pytest.raises(ValueError):
            made()


def test_libraries_are_transformers():
    x = np.random.default_rng(0).uniform(1, 2, size=(20, 3))
    a, b, c = x.T
    library = ps.PolynomialLibrary(2, interaction_only=True)
    with pytest.raises(ps.NotFittedError):
        library.transform(x)
    assert np.abs(library.fit_transform(x) - np.column_stack([a**0, a, b, c, a * b, a * c, b * c])).max() < 1e-12
    assert library.get_feature_names(["a", "b", "c"]) == ["1", "a", "b", "c", "a b", "a c", "b c"]
    assert library.powers_.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [1, 0, 1], [0, 1, 1]]
    with pytest.raises(ValueError, match="3 variables"):
        library.transform(x[:, 1:])
    cosines = ps.FourierLibrary(2, include_sin=False).fit(x)
    assert np.abs(cosines.transform(x) - np.cos(np.hstack([x, 2 * x]))).max() < 1e-12
    assert cosines.get_feature_names()[3:] == ["cos(2 x0)", "cos(2 x1)", "cos(2 x2)"]


def test_products_of_libraries_over_some_variables():
    x = np.random.default_rng(0).uniform(1, 2, size=(20, 3))
    a, b, c = x.T
    custom = ps.CustomLibrary([lambda s: 1 / s], [lambda s: f"1/{s}"])
    library = ps.GeneralizedLibrary([ps.IdentityLibrary(), custom], [[1, 1]], [[1, 2], [0]]).fit(x)
    assert np.abs(library.transform(x) - np.column_stack([b, c, 1 / a, b / a, c / a])).max() < 1e-12
    assert library.n_output_features_ == 5
    for row in ([1, 0], [1, 1, 1], [1, 2]):
        with pytest.raises(ValueError, match="tensor_array"):
            ps.GeneralizedLibrary([ps.IdentityLibrary(), custom], [row]).fit(x)
    with pytest.raises(ValueError, match="number 3"):
        ps.GeneralizedLibrary([ps.IdentityLibrary()], inputs_per_library=[[3]]).fit(x)
