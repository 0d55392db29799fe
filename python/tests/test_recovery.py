"""Known equations are found, with their coefficients and honest standard errors."""

import numpy as np
import pytest

import sindyna
from systems import LORENZ, PENDULUM, VAN_DER_POL, assert_found, found, lorenz, pendulum, van_der_pol


def test_clean_lorenz_is_recovered_to_rounding():
    t, x = lorenz()
    model = sindyna.SINDy().fit(x, t=t, feature_names=["x", "y", "z"])
    assert_found(model, LORENZ, 1e-6)
    assert model.report_.certainty in ("adequate", "exact")


@pytest.mark.parametrize("seed", [0, 1])
def test_noisy_lorenz_is_recovered_with_noise_nobody_declared(seed):
    t, x = lorenz(noise=0.2, seed=seed)
    model = sindyna.SINDy().fit(x, t=t, feature_names=["x", "y", "z"])
    assert_found(model, LORENZ, 0.05)
    for name, sigma in model.report_.noise.items():
        assert abs(sigma - 0.2) < 0.03, (name, sigma)
    truth = model.coefficients() * 0.0
    names = model.get_feature_names()
    for i, row in enumerate(LORENZ):
        for term, value in row.items():
            truth[i, names.index(term)] = value
    errors, used = model.standard_errors_, model.coefficients() != 0.0
    assert np.isfinite(errors[used]).all()
    assert np.isnan(errors[~used]).all()
    assert (np.abs(model.coefficients() - truth)[used] < 4.5 * errors[used]).all()


def test_noisy_van_der_pol_is_recovered():
    t, x = van_der_pol(noise=0.02)
    model = sindyna.SINDy(rates={"v": "x"}).fit(x, t=t, feature_names=["x", "v"])
    assert_found(model, VAN_DER_POL, 0.02)
    assert model.report_.equations[0].declared
    assert not model.report_.equations[1].declared


def test_a_driven_pendulum_is_recovered_from_arrays_and_predicts():
    t, x, u = pendulum(noise=0.01)
    model = sindyna.SINDy(angles=["th"], rates={"w": "th"})
    assert model.fit(x, t=t, u=u, feature_names=["th", "w", "u"]) is model
    assert_found(model, PENDULUM, 0.02)
    _, clean, u = pendulum(seed=5)
    assert np.abs(model.simulate(clean[0], t, u) - clean).max() < 0.3
    assert (model.compare(clean, t, u, horizon=25) > 0.95).all()
    a, b = model.linearize([0.0, 0.0])
    assert np.abs(a - [[0, 1], [-9.81, -0.4]]).max() < 0.1
    assert np.abs(b - [[0], [2]]).max() < 0.05


def test_clean_stepped_data_are_exact():
    x = [np.array([0.3, -0.2])]
    u = np.sin(0.9 * np.arange(20))
    for g in u:
        x.append(x[-1] + 0.1 * np.array([x[-1][1], g / 2]))
    model = sindyna.SINDy(rates={"v": "x"}).fit(np.array(x), t=0.1, u=u, feature_names=["x", "v", "g"])
    assert model.report_.certainty == "exact"
    assert model.report_.noise == {"x": 0.0, "v": 0.0}
    assert_found(model, [{"v": 1.0}, {"g": 0.5}], 1e-9)
    assert np.abs(model.simulate(x[0], 21, u) - x).max() < 1e-12
    assert np.abs(model.step(np.array(x[:-1]), u[:, None]) - x[1:]).max() < 1e-12
    with pytest.raises(ValueError, match=r"stepped by 0.1 s"):
        model.simulate(x[0], 0.05 * np.arange(5), u[:5])


def test_uneven_times_are_taken_as_they_are():
    rng = np.random.default_rng(3)
    t = np.cumsum(rng.uniform(0.005, 0.025, size=500))
    _, x = lorenz()
    from systems import follow

    x = follow(lambda s, z: [10 * (z[1] - z[0]), z[0] * (28 - z[2]) - z[1], z[0] * z[1] - 8 / 3 * z[2]], x[0], t)
    noisy = x + 0.05 * rng.normal(size=x.shape)
    model = sindyna.SINDy().fit(noisy, t=t, feature_names=["x", "y", "z"])
    assert_found(model, LORENZ, 0.03)
    assert model.dt_ == pytest.approx(np.median(np.diff(t)))


def test_several_trajectories_are_fitted_together_and_nothing_crosses_their_borders():
    runs = [lorenz(n=200, noise=0.05, seed=i, x0=x0) for i, x0 in enumerate([(-8, 8, 27), (5, 5, 15), (1, -3, 30)])]
    model = sindyna.SINDy().fit([x for _, x in runs], t=0.01, feature_names=["x", "y", "z"])
    assert_found(model, LORENZ, 0.05)
    assert model.report_.n_trajectories == 3
    other = sindyna.SINDy().fit([x for _, x in runs], t=[t for t, _ in runs], feature_names=["x", "y", "z"])
    assert found(other) == found(model)


def test_what_is_known_required_forbidden_or_signed_is_respected():
    t, x, u = pendulum(n=200, noise=0.02)
    names = ["th", "w", "u"]
    base = {"angles": ["th"], "rates": {"w": "th"}}
    model = sindyna.SINDy(**base, known={"w": "-9.81*sin(th) + 2*u"}).fit(x, t=t, u=u, feature_names=names)
    equation = model.report_.equations[1]
    assert equation.n_known == 2
    assert found(model)[1]["u"] == 2.0
    assert found(model)[1]["sin(th)"] == -9.81
    assert abs(found(model)[1]["w"] + 0.4) < 0.05
    assert [e == 0.0 for e in equation.standard_errors] == [False, True, True]
    model = sindyna.SINDy(**base, require={"w": ["w^2"]}).fit(x, t=t, u=u, feature_names=names)
    assert "w^2" in found(model)[1]
    model = sindyna.SINDy(**base, forbid={"w": "u"}).fit(x, t=t, u=u, feature_names=names)
    assert "u" not in found(model)[1]
    assert not model.report_.equations[1].adequate
    model = sindyna.SINDy(**base, sign={"w": {"w": "+"}}).fit(x, t=t, u=u, feature_names=names)
    assert found(model)[1].get("w", 1.0) > 0.0


def test_noise_can_be_denied_or_declared():
    t, x, u = pendulum(n=200, noise=0.01)
    base = {"angles": ["th"], "rates": {"w": "th"}}
    names = ["th", "w", "u"]
    denied = sindyna.SINDy(**base, noise="none").fit(x, t=t, u=u, feature_names=names)
    assert "rounding" in denied.report_.equations[1].doubt
    declared = sindyna.SINDy(**base, noise={"th": 0.01, "w": 0.01}).fit(x, t=t, u=u, feature_names=names)
    assert_found(declared, PENDULUM, 0.03)
    with pytest.raises(ValueError, match="one standard deviation for each of the 2 states"):
        sindyna.SINDy(noise=[0.1]).fit(x, t=t)


def test_inputs_that_go_in_straight_lines_are_told_apart_from_held_ones():
    t = 0.05 * np.arange(400)
    from scipy.integrate import solve_ivp

    def u(s):
        return np.sin(1.3 * s) + np.cos(2.9 * s)

    x = solve_ivp(lambda s, z: [-z[0] + 2 * u(s)], (0, t[-1]), [0.5], t_eval=t, rtol=1e-10, atol=1e-10).y.T
    noisy = x + 0.005 * np.random.default_rng(0).normal(size=x.shape)
    held = sindyna.SINDy().fit(noisy, t=t, u=u(t), feature_names=["x", "u"])
    linear = sindyna.SINDy(intersample="foh").fit(noisy, t=t, u=u(t), feature_names=["x", "u"])
    assert_found(linear, [{"x": -1.0, "u": 2.0}], 0.01)
    assert abs(found(held)[0]["u"] - 2.0) > abs(found(linear)[0]["u"] - 2.0)
    assert np.abs(linear.simulate(x[0], t, u(t)) - x).max() < 0.02
    assert np.abs(linear.simulate(x[0], t, u) - x).max() < 0.02


def test_a_map_is_found_by_regression():
    x = np.empty((60, 1))
    x[0] = 0.3
    for i in range(59):
        x[i + 1] = 3.7 * x[i] * (1 - x[i])
    for model in (sindyna.SINDy(discrete_time=True), sindyna.DiscreteSINDy(), sindyna.DiscreteSINDy(sindyna.STLSQ())):
        model.fit(x)
        assert np.abs(model.coefficients() - [[0, 3.7, -3.7]]).max() < 1e-9
        assert model.score(x) > 1 - 1e-12
        assert np.abs(model.simulate([0.3], 5) - x[:5]).max() < 1e-9
        assert np.abs(model.predict(x[:-1]) - x[1:]).max() < 1e-9
