"""Bad input is refused with value, bound and hint; hostile names and files are harmless; models survive files."""

import json
import re

import numpy as np
import pytest
import sympy

import sindyna
from sindyna import _formula
from systems import PENDULUM, assert_found, lorenz, pendulum


def lorenz_model(**kwargs):
    t, x = lorenz(n=200)
    return sindyna.SINDy(**kwargs).fit(x, t=t), t, x


@pytest.mark.parametrize(
    ("x", "kwargs", "match"),
    [
        (np.full((50, 2), np.nan), {}, r"x is nan in row 0, column 0"),
        (np.where(np.arange(100).reshape(50, 2) == 7, np.inf, 1.0), {}, r"x is inf in row 3, column 1"),
        (np.ones((2, 3, 4)), {}, r"shape \(samples, signals\), got \(2, 3, 4\)"),
        (np.ones((50, 2)) * 1j, {}, "real numbers"),
        ([["a", "b"]], {}, "real numbers"),
        (np.ones((0, 2)), {}, "no rows"),
        ([], {}, "no samples"),
        (np.random.default_rng(0).normal(size=(3, 4)), {}, "too few|few"),
        (np.ones((1, 2)), {}, "at least two"),
        (np.ones((50, 2)), {"t": np.arange(49.0)}, r"each of the 50 rows of x, got shape \(49,\)"),
        (np.ones((50, 2)), {"t": np.zeros(50)}, "must increase"),
        (np.ones((50, 2)), {"t": -0.1}, "finite and > 0 s"),
        (np.ones((50, 2)), {"t": "1"}, "a number or times"),
        (np.ones((50, 2)), {"t": np.r_[np.nan, np.arange(1.0, 50.0)]}, "t is nan in row 0"),
        (np.ones((50, 2)), {"t": np.r_[np.arange(49.0), np.inf]}, "t is inf in row 49"),
        ([np.ones((50, 2))] * 2, {"t": [None, 0.1]}, r"t\[0\] is None"),
        (np.ones((50, 2)), {"t": np.r_[np.arange(49.0), np.nan]}, "t is nan in row 49"),
        (np.ones((50, 2)), {"u": np.ones(30)}, "a row for each of the 50 rows of x"),
        (np.ones((50, 2)), {"u": np.full(50, np.nan)}, "u is nan"),
        (np.ones((50, 2)), {"x_dot": np.ones((50, 3))}, r"x_dot must have the shape of x, \(50, 2\), got \(50, 3\)"),
        ([np.ones((50, 2)), np.ones((50, 3))], {}, "trajectory 1 has 3 states"),
        ([np.ones((50, 2))] * 2, {"t": [0.1]}, "t must be a list of 2, got 1"),
        ([np.ones((50, 2))] * 2, {"u": np.ones(50)}, "u must be a list of 2"),
        (np.ones((50, 2)), {"feature_names": ["a"]}, "name the 2 states"),
        (np.ones((50, 2)), {"feature_names": ["a", "a"]}, "a name of its own"),
    ],
)
def test_bad_samples_are_refused(x, kwargs, match):
    for model in (sindyna.SINDy(), sindyna.SINDy(sindyna.STLSQ())):
        if match in ("too few|few", "at least two") and model.optimizer is not None:
            continue
        with pytest.raises(ValueError, match=match):
            model.fit(x, **{"t": 0.1, **kwargs})


@pytest.mark.parametrize(
    ("kwargs", "match"),
    [
        ({"angles": ["phi"]}, "no state 'phi'; states: th, w"),
        ({"angles": "th"}, "must be a list"),
        ({"rates": {"w": "w"}}, "cannot be the rate"),
        ({"rates": ["w"]}, "must be a dict"),
        ({"known": {"w": "-9.81*sin(phi)"}}, "named 'phi'; variables: th, w, u"),
        ({"known": {"w": "sin(th"}}, r"sin\(th"),
        ({"known": {"q": "th"}}, "no state 'q'"),
        ({"require": {"w": ["2*u"]}}, "is not a single term"),
        ({"sign": {"w": {"w": "minus"}}}, "'\\+' or '-'"),
        ({"noise": "some"}, "'auto', 'none'"),
        ({"noise": {"w": -1.0}}, "finite and at least 0"),
        ({"terms": ["w*abs(v)"]}, "named 'v'"),
        ({"intersample": "cubic"}, "'zoh'"),
        ({"optimizer": sindyna.BestSubset(max_size=0)}, "max_size"),
        ({"optimizer": sindyna.STLSQ().set_params(threshold=-1.0)}, "threshold must be finite and at least 0"),
        ({"optimizer": sindyna.STLSQ().set_params(max_iter=0)}, "max_iter"),
        ({"optimizer": sindyna.STLSQ(), "feature_library": sindyna.PolynomialLibrary(2.5)}, "degree"),
        ({"controls": 1}, "inputs are given twice"),
    ],
)
def test_bad_settings_are_refused_when_they_are_used(kwargs, match):
    t, x, u = pendulum(n=60)
    with pytest.raises(ValueError, match=match):
        sindyna.SINDy(**kwargs).fit(x, t=t, u=u, feature_names=["th", "w", "u"])


def test_calls_that_do_not_fit_the_model_are_refused():
    model, t, x = lorenz_model()
    with pytest.raises(ValueError, match="x must have 3 columns"):
        model.predict(x[:, :2])
    with pytest.warns(UserWarning, match="no inputs"):
        assert np.array_equal(model.predict(x, u=np.ones(len(x))), model.predict(x))
    with pytest.raises(ValueError, match="x0 must be 3 finite numbers"):
        model.simulate([1.0], t)
    with pytest.warns(UserWarning, match="no inputs"):
        assert np.array_equal(model.simulate(x[0], t, u=np.ones(len(t))), model.simulate(x[0], t))
    with pytest.raises(ValueError, match="increasing"):
        model.simulate(x[0], t[::-1])
    with pytest.raises(ValueError, match="horizon"):
        model.compare(x, t, horizon=0)
    t, x, u = pendulum(n=100)
    driven = sindyna.SINDy(angles=["x0"]).fit(x, t=t, u=u)
    for without in (lambda: driven.simulate(x[0], t), lambda: driven.predict(x), lambda: driven.score(x, t)):
        with pytest.raises(TypeError, match="give them as u"):
            without()
    with pytest.raises(ValueError, match=r"u must have shape \(100, 1\)"):
        driven.simulate(x[0], t, u[:50])
    with pytest.raises(ZeroDivisionError):
        driven.simulate(x[0], t, lambda s: 1 / 0)
    with pytest.raises(ValueError, match="must give 1 numbers, got 2"):
        driven.simulate(x[0], t, lambda s: [s, s])


def test_blow_up_is_an_error_with_its_time():
    t = 0.01 * np.arange(90)
    x = 1 / (1 - t)
    model = sindyna.SINDy(sindyna.STLSQ(), sindyna.FormulaLibrary(["x0^2"])).fit(x, t=t, x_dot=x**2)
    with pytest.raises(ArithmeticError, match=r"t = 0\.99|t = 1"):
        model.simulate([1.0], np.linspace(0, 2, 50))


def test_solutions_are_as_exact_as_asked():
    t, x = lorenz(n=200)
    rate = np.column_stack(
        [10 * (x[:, 1] - x[:, 0]), x[:, 0] * (28 - x[:, 2]) - x[:, 1], x[:, 0] * x[:, 1] - 8 / 3 * x[:, 2]]
    )
    model = sindyna.SINDy().fit(x, t=t, x_dot=rate)
    coarse = np.abs(model.simulate(x[0], t, rtol=1e-4, atol=1e-6) - x).max()
    fine = np.abs(model.simulate(x[0], t, rtol=1e-10, atol=1e-12) - x).max()
    assert fine < 1e-6 < coarse < 1.0
    # Sparse times are stepped over, not jumped over.
    sparse = model.simulate(x[0], t[::50], rtol=1e-10, atol=1e-12)
    assert np.abs(sparse - x[::50]).max() < 1e-6


HOSTILE = ['"', "'); import os; os.abort() #", "a\nb", "lambda", "x 1", "}", "\\", "$^2$", "sin", "x1", "θ̇", "​"]


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_names_are_only_names(name, tmp_path):
    t, x, u = pendulum(n=150, noise=0.002)
    names = [name, "w", "u"]
    model = sindyna.SINDy(angles=[name], rates={"w": name}, known={"w": f"-9.81*sin({name})"})
    model.fit(x, t=t, u=u, feature_names=names)
    equation = model.report_.equations[1]
    assert set(equation.terms) >= {f"sin({name})", "u"}
    assert list(model.feature_names_in_) == names
    path = tmp_path / "model.json"
    model.save(path)
    loaded = sindyna.SINDy.load(path)
    assert loaded.equations(9) == model.equations(9)
    assert np.array_equal(loaded.predict(x, u), model.predict(x, u))
    assert loaded.known == model.known
    assert isinstance(model._repr_latex_(), str)
    assert sympy.Symbol(name) in model.to_sympy()[1].free_symbols
    import matplotlib as mpl

    mpl.use("Agg")
    figure = model.plot(x, t, u)
    figure.savefig(tmp_path / "figure.png")
    assert str(model.report_)


def test_swapped_symbols_stay_apart():
    t, x = lorenz(n=300, noise=0.02)
    model = sindyna.SINDy().fit(x, t=t, feature_names=["x2", "x0", "x1"])
    assert set(model.report_.equations[2].terms) == {"x1", "x2 x0"}


@pytest.mark.parametrize(
    "model",
    [
        sindyna.SINDy(angles=["x0"], rates={"x1": "x0"}, noise={"x0": 0.001}),
        sindyna.SINDy(
            sindyna.STLSQ(0.2), sindyna.PolynomialLibrary(1) + sindyna.FourierLibrary(), sindyna.FiniteDifference(4)
        ),
        sindyna.SINDy(
            sindyna.STLSQ(0.2), sindyna.CustomLibrary([lambda a: a, np.sin], [lambda s: s, lambda s: f"SIN({s})"])
        ),
        sindyna.DiscreteSINDy(sindyna.LeastSquares()),
    ],
)
def test_a_saved_model_is_the_same_to_the_last_bit(model, tmp_path):
    t, x, u = pendulum(n=150, noise=0.001)
    model.fit(x, t=t, u=u)
    model.save(tmp_path / "model.json")
    loaded = sindyna.SINDy.load(tmp_path / "model.json")
    assert type(loaded) is type(model)
    assert loaded.predict(x, u).tobytes() == model.predict(x, u).tobytes()
    assert loaded.simulate(x[0], 20 if model.report_.stepping[0] != "c" else t[:20], u[:20]).tobytes() == (
        model.simulate(x[0], 20 if model.report_.stepping[0] != "c" else t[:20], u[:20]).tobytes()
    )
    assert loaded.get_feature_names() == model.get_feature_names()
    assert np.array_equal(loaded.standard_errors_, model.standard_errors_, equal_nan=True)
    assert str(loaded.report_) == str(model.report_)
    # What was loaded can be fitted again.
    again = loaded.fit(x, t=t, u=u)
    assert np.allclose(again.coefficients(), model.coefficients())


def test_broken_files_are_refused(tmp_path):
    model, _, _ = lorenz_model()
    path = tmp_path / "model.json"
    model.save(path)
    document = json.loads(path.read_text(encoding="utf-8"))
    for broken in (
        "",
        "[]",
        "{}",
        json.dumps({**document, "format": 99}),
        json.dumps({**document, "model": {}}),
        json.dumps({**document, "states": ["a"]}),
        json.dumps({**document, "params": {"optimizer": {"class": "os.system", "params": {}}}}),
        json.dumps({**document, "account": {**document["account"], "report": {}}}),
    ):
        path.write_text(broken, encoding="utf-8")
        with pytest.raises(ValueError, match=r"model\.json"):
            sindyna.SINDy.load(path)
    with pytest.raises(FileNotFoundError):
        sindyna.SINDy.load(tmp_path / "nothing.json")


def test_sympy_has_the_values_of_the_model():
    t, x, u = pendulum(n=200, noise=0.003)
    model = sindyna.SINDy(angles=["th"], terms=["w*abs(w)"], require={"w": "w*abs(w)"}).fit(
        x, t=t, u=u, feature_names=["th", "w", "u"]
    )
    expressions = model.to_sympy()
    functions = [sympy.lambdify([sympy.Symbol(n) for n in ("th", "w", "u")], e, "numpy") for e in expressions]
    values = np.column_stack([f(x[:, 0], x[:, 1], u[:, 0]) for f in functions])
    assert np.abs(values - model.predict(x, u)).max() < 1e-12 * np.abs(values).max()


def test_implicit_equations_are_solved_for_rates():
    # A cart with a pole: each acceleration depends on the other.
    from systems import follow

    t = 0.02 * np.arange(400)
    force = np.repeat(np.random.default_rng(0).uniform(-6, 6, size=40), 10)[:, None]

    def rate(s, z, f):
        _, v, th, w = z
        sin, cos = np.sin(th), np.cos(th)
        a = (f[0] + 0.1 * 0.5 * w**2 * sin - 0.1 * 9.81 * sin * cos) / (1.0 + 0.1 * sin**2)
        return [v, a, w, (9.81 * sin - a * cos) / 0.5]

    x = follow(rate, [0, 0, np.pi - 0.5, 0], t, force)
    model = sindyna.SINDy(angles=["th"], rates={"v": "x", "w": "th"}).fit(
        x, t=t, u=force, feature_names=["x", "v", "th", "w", "F"]
    )
    truth = np.array([rate(0, z, f) for z, f in zip(x, force, strict=True)])
    assert np.abs(model.predict(x, force) - truth).max() < 1e-3
    symbols = [sympy.Symbol(n) for n in model.feature_names_in_]
    values = np.column_stack(
        [
            np.broadcast_to(sympy.lambdify(symbols, e, "numpy")(*np.hstack([x, force]).T), len(x))
            for e in model.to_sympy()
        ]
    )
    assert np.abs(values - model.predict(x, force)).max() < 1e-9
    assert any(s.rate for e in model.report_.equations for s in e.summands)
    assert "\\dot{" in model._repr_latex_()


def stop(x):
    """The force of a stop with play: nothing between -0.3 and 0.3."""
    return np.maximum(x - 0.3, 0) - np.maximum(-x - 0.3, 0)


def test_kinks_are_found_and_written_for_people_latex_and_sympy():
    from systems import follow

    t = 0.02 * np.arange(300)
    force = np.repeat(np.random.default_rng(3).uniform(-4, 4, size=60), 5)[:, None]
    x = follow(lambda s, z, f: [z[1], -20 * stop(z[0]) - 0.5 * z[1] + f[0]], [0.1, 0.0], t, force)
    noisy = x + 1e-4 * np.random.default_rng(4).normal(size=x.shape)
    model = sindyna.SINDy(rates={"v": "x"}).fit(noisy, t=t, u=force, feature_names=["x", "v", "F"])
    found = {s.term: s.coefficient for s in model.report_.equations[1].summands}
    (kink,) = set(found) - {"v", "F"}
    edge = re.fullmatch(r"max\(x - (0\.\d+), 0\) - max\(-(0\.\d+) - x, 0\)", kink)
    assert edge
    assert all(abs(float(at) - 0.3) < 1e-3 for at in edge.groups())
    assert max(abs(found[kink] + 20), abs(found["v"] + 0.5), abs(found["F"] - 1)) < 0.05
    assert rf"\max\left(x - {edge[1]}, 0\right)" in model._repr_latex_()
    own = model.to_sympy()[1]
    assert own.has(sympy.Max)
    value = sympy.lambdify(sympy.symbols("x v F"), own, "numpy")(*np.hstack([x, force]).T)
    assert np.abs(value - model.predict(x, force)[:, 1]).max() < 1e-9


@pytest.mark.parametrize(
    ("text", "shown", "at"),
    [
        ("max(x0 − 0.4, 0)", "max(a - 0.4, 0)", [0.0, 0.6]),
        ("min(x0, 2)·max(−x0, 1)", "min(a, 2) max(-a, 1)", [-1.0, 1.0]),
        ("clip(2·x0, −1, 1)²", "clip(2 a, -1, 1)^2", [1.0, 1.0]),
    ],
)
def test_functions_of_several_terms_are_read(text, shown, at):
    tree = _formula.read(text)
    assert _formula.plain(tree, lambda _: "a") == shown
    a = sympy.Symbol("a")
    value = sympy.lambdify(a, _formula.sympy(tree, lambda _: a, lambda _: a))
    assert [float(value(v)) for v in (-1.0, 1.0)] == pytest.approx(at)
    for broken in ("max(x0)", "max(x0, 0", "min x0", "clip(x0, 1)"):
        with pytest.raises(ValueError, match="unexpected"):
            _formula.read(broken)


def test_latex_is_what_is_shown_in_notebooks():
    t, x, u = pendulum()
    model = sindyna.SINDy(angles=["th"], rates={"w": "th"}, known={"w": "-9.81*sin(th)"}).fit(
        x, t=t, u=u, feature_names=["th", "w", "u_1"]
    )
    text = model._repr_latex_()
    assert text.startswith("$$\\begin{aligned}\n\\dot{\\mathrm{th}} &= w \\\\")
    assert "9.81 \\, \\sin\\left(\\mathrm{th}\\right)" in text
    assert "u_{1}" in text
    assert sindyna.SINDy()._repr_latex_() is None


def test_numpy_types_lists_and_memory_orders_are_the_same_data():
    t, x, u = pendulum(n=120, noise=0.005)
    base = sindyna.SINDy(angles=["x0"]).fit(x, t=t, u=u)
    for same in (np.asfortranarray(x), x.tolist(), x[::1]):
        assert sindyna.SINDy(angles=["x0"]).fit(same, t=t, u=u[:-1]).equations(9) == base.equations(9)
    assert np.array_equal(base.predict(x[::2], u[::2]), base.predict(x, u)[::2])
    assert np.array_equal(base.predict([x, x[:5]], [u, u[:5]])[1], base.predict(x[:5], u[:5]))
    big = np.vstack([x] * 100)
    assert np.array_equal(base.predict(big, np.vstack([u] * 100))[-120:], base.predict(x, u))


def test_an_even_grid_may_begin_at_any_time():
    t, x, u = pendulum(n=150)
    late = sindyna.SINDy(angles=["th"], rates={"w": "th"}).fit(x, t=t + 1.7e9, u=u, feature_names=["th", "w", "u"])
    assert_found(late, PENDULUM, 1e-3)
