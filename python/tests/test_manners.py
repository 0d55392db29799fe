"""scikit-learn's manners: parameters, clones, pipelines, searches; and copies, pickles, threads, signals."""

import copy
import os
import pickle
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pandas as pd
import pytest
import sklearn
from sklearn.base import clone
from sklearn.exceptions import NotFittedError as SklearnNotFitted
from sklearn.model_selection import GridSearchCV, KFold, TimeSeriesSplit
from sklearn.pipeline import Pipeline
from sklearn.preprocessing import FunctionTransformer
from sklearn.utils.validation import check_is_fitted

import sindyna
from systems import LORENZ, PENDULUM, assert_found, lorenz, pendulum


def test_parameters_are_got_set_shown_and_cloned():
    model = sindyna.SINDy(sindyna.STLSQ(threshold=0.2), noise="auto", angles=["th"])
    params = model.get_params()
    assert params["optimizer__threshold"] == 0.2
    assert params["angles"] == ["th"]
    assert "optimizer__threshold" not in model.get_params(deep=False)
    assert model.set_params(optimizer__threshold=0.3, angles=None) is model
    assert model.optimizer.threshold == 0.3
    assert repr(model) == "SINDy(optimizer=STLSQ(threshold=0.3))"
    twin = clone(model)
    assert twin is not model
    assert twin.optimizer is not model.optimizer
    assert repr(twin) == repr(model)
    with pytest.raises(ValueError, match="no parameter 'treshold'"):
        model.set_params(optimizer__treshold=1)
    with pytest.raises(ValueError, match="no parameter 'optimiser'"):
        model.set_params(optimiser=None)


def test_fitting_changes_no_parameter():
    t, x = lorenz(n=100)
    model = sindyna.SINDy(sindyna.STLSQ(), sindyna.PolynomialLibrary(2))
    before = repr(sorted(model.get_params().items(), key=lambda item: item[0]))
    model.fit(x, t=t, feature_names=["a", "b", "c"])
    assert repr(sorted(model.get_params().items(), key=lambda item: item[0])) == before
    assert list(model.feature_names_in_) == ["a", "b", "c"]


def test_an_unfitted_model_says_so():
    model = sindyna.SINDy()
    for ask in (lambda: model.predict([[1.0]]), model.coefficients, lambda: model.report_, lambda: model.save("x")):
        with pytest.raises(sindyna.NotFittedError, match="call fit first"):
            ask()
    with pytest.raises(SklearnNotFitted):
        check_is_fitted(model)
    t, x = lorenz(n=100)
    check_is_fitted(model.fit(x, t=t))
    assert clone(model).__sklearn_is_fitted__() is False


def test_a_pipeline_ends_in_a_model():
    _, x = lorenz(n=200)
    scale = FunctionTransformer(lambda x: x / 10.0)
    pipeline = Pipeline([("scale", scale), ("sindy", sindyna.SINDy(sindyna.STLSQ(threshold=0.3), t_default=0.01))])
    pipeline.fit(x)
    assert abs(pipeline["sindy"].coefficients()[0, 1] + 10) < 0.1
    assert pipeline.score(x) > 0.99
    assert pipeline.predict(x).shape == x.shape


@pytest.mark.filterwarnings("ignore:the threshold leaves no term")
def test_a_search_over_folds_carries_inputs_as_columns():
    _, x, u = pendulum(n=400)
    model = sindyna.SINDy(
        sindyna.STLSQ(),
        sindyna.PolynomialLibrary(1) + sindyna.FourierLibrary(),
        sindyna.FiniteDifference(),
        t_default=0.02,
        controls=1,
    )
    search = GridSearchCV(model, {"optimizer__threshold": [0.05, 0.2, 5.0]}, cv=TimeSeriesSplit(3), error_score="raise")
    search.fit(np.hstack([x, u]))
    assert search.best_params_["optimizer__threshold"] != 5.0
    assert search.best_score_ > 0.9
    assert search.best_estimator_.n_control_features_ == 1


@pytest.mark.filterwarnings("ignore:the threshold leaves no term")
def test_a_search_routes_inputs_and_times():
    t, x, u = pendulum(n=400)
    model = sindyna.SINDy(sindyna.STLSQ(), sindyna.PolynomialLibrary(1) + sindyna.FourierLibrary())
    with sklearn.config_context(enable_metadata_routing=True):
        model.set_fit_request(t=True, u=True).set_score_request(t=True, u=True)
        search = GridSearchCV(model, {"optimizer__threshold": [0.05, 5.0]}, cv=KFold(4), error_score="raise")
        search.fit(x, t=t, u=u)
    assert search.best_params_["optimizer__threshold"] == 0.05
    assert search.best_score_ > 0.9
    with pytest.raises(TypeError, match="no argument 'v'"):
        model.set_fit_request(v=True)


def test_a_search_splits_lists_of_trajectories():
    runs = [np.hstack(pendulum(n=100, noise=0.005, seed=i, x0=(0.5 * i, 0.0))[1:]) for i in range(4)]
    model = sindyna.SINDy(angles=["th"], rates={"w": "th"}, t_default=0.02, controls=1, feature_names=["th", "w", "u"])
    search = GridSearchCV(model, {"terms": [None, ["w*abs(w)"]]}, cv=KFold(2), error_score="raise").fit(runs)
    assert_found(search.best_estimator_, PENDULUM, 0.05)


def test_rows_left_out_are_gaps_and_no_steps():
    t, x = lorenz(n=500)
    keep = np.r_[0:200, 300:500]
    model = sindyna.SINDy().fit(x[keep], t=t[keep], feature_names=["x", "y", "z"])
    assert model.report_.n_trajectories == 2
    assert_found(model, LORENZ, 1e-5)


def test_data_frames_name_states_and_inputs():
    t, x, u = pendulum(noise=0.005)
    frame = pd.DataFrame(x, columns=["th", "w"], index=pd.Index(t))
    inputs = pd.DataFrame(u, columns=["u"])
    base = {"angles": ["th"], "rates": {"w": "th"}}
    model = sindyna.SINDy(**base).fit(frame, u=inputs)
    assert list(model.feature_names_in_) == ["th", "w", "u"]
    assert_found(model, PENDULUM, 0.02)
    together = frame.assign(u=u[:, 0])[["u", "th", "w"]]
    other = sindyna.SINDy(**base, controls=["u"]).fit(together)
    assert other.equations(9) == model.equations(9)
    assert np.array_equal(other.predict(together), model.predict(frame, inputs))
    stamped = frame.set_index(
        pd.Timestamp("2026-01-01") + pd.to_timedelta((t * 1e9).round().astype("int64"), unit="ns")
    )
    assert_found(sindyna.SINDy(**base).fit(stamped, u=inputs), PENDULUM, 0.02)
    with pytest.raises(ValueError, match="the model was fitted to"):
        model.predict(frame[["w", "th"]], inputs)
    with pytest.raises(ValueError, match="no column 'v'"):
        sindyna.SINDy(controls=["v"]).fit(frame)


def test_copies_and_pickles_predict_the_same():
    t, x = lorenz(n=200, noise=0.05)
    model = sindyna.SINDy().fit(x, t=t)
    for twin in (copy.deepcopy(model), pickle.loads(pickle.dumps(model))):
        assert np.array_equal(twin.predict(x), model.predict(x))
        assert twin.report_ == model.report_


def interrupted_after(delay, call):
    """Seconds from Ctrl-C to the KeyboardInterrupt."""
    # A process in the background inherits that Ctrl-C is ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    sent = []

    def press():
        time.sleep(delay)
        sent.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=press).start()
    with pytest.raises(KeyboardInterrupt):
        call()
    return time.perf_counter() - sent[0]


@pytest.mark.parametrize("delay", [0.1, 0.6])
def test_ctrl_c_ends_a_fit_within_a_fifth_of_a_second_and_loses_nothing(delay):
    t, x = lorenz(n=100)
    model = sindyna.SINDy().fit(x, t=t)
    before = model.equations(9)
    hard = np.cumsum(np.random.default_rng(1).normal(size=(3000, 6)), axis=0)
    assert interrupted_after(delay, lambda: model.fit(hard, t=0.01)) < 0.2
    assert model.equations(9) == before


def test_ctrl_c_ends_a_simulation():
    t, x = lorenz(n=100)
    model = sindyna.SINDy().fit(x, t=t)
    assert interrupted_after(0.1, lambda: model.simulate(x[0], np.linspace(0, 1e5, 1000))) < 0.2


@pytest.mark.parametrize("delay", [0.05, 1.5])
def test_ctrl_c_ends_learning(delay):
    assert interrupted_after(delay, lambda: sindyna.learn("Pendulum-v1", evaluation_episodes=10_000)) < 0.2


def test_two_fits_in_two_threads_run_in_parallel():
    # Other programs may have all cores, so seconds prove nothing: short fits end, and this thread counts, while a long one goes on.
    t, x = lorenz(n=600, noise=0.1)
    long = threading.Thread(target=lambda: sindyna.SINDy().fit(x, t=t))
    short = threading.Thread(target=lambda: [sindyna.SINDy(sindyna.STLSQ()).fit(x[:100], t=t[:100]) for _ in range(5)])
    long.start()
    short.start()
    short.join()
    assert long.is_alive()
    counted = 0
    while long.is_alive():
        counted += 1
        time.sleep(0.001)
    assert counted > 5


def test_import_is_quick_and_imports_numpy_alone(tmp_path):
    code = (
        "import sys, time, numpy; before = set(sys.modules); begun = time.perf_counter(); import sindyna; "
        "took = time.perf_counter() - begun; "
        "heavy = {'pandas', 'sklearn', 'sympy', 'matplotlib', 'scipy'} & set(sys.modules); print(took, *heavy)"
    )
    results = [
        subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path
        ).stdout.split()
        for _ in range(3)
    ]
    assert min(float(r[0]) for r in results) < 0.2
    assert all(len(r) == 1 for r in results), results


def test_thousands_of_fits_leak_nothing():
    resource = pytest.importorskip("resource")
    t = 0.1 * np.arange(30)
    x = np.column_stack([np.exp(-t), np.exp(-2 * t)])

    def rss():
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * resource.getpagesize()

    if not os.path.exists("/proc/self/statm"):
        pytest.skip("no /proc here")
    model = sindyna.SINDy(sindyna.STLSQ())
    small = sindyna.SINDy()

    def fits(n):
        for i in range(n):
            model.fit(x, t=t)
            model.predict(x)
            if i % 50 == 0:
                small.fit(x, t=t)
                _ = small.report_, small.simulate(x[0], t)

    fits(500)
    before = rss()
    fits(10_000)
    assert rss() - before < 8e6
