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
    with pytest.raises(ValueError, match="input"):
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
