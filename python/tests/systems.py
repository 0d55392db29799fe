"""True systems, integrated by SciPy to 1e-10."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp


def follow(rate, x0, t, u=None):
    """States (T, n) at times t (T,), under inputs u (T, k) held from sample to sample."""
    if u is None:
        return solve_ivp(rate, (t[0], t[-1]), x0, t_eval=t, rtol=1e-10, atol=1e-10).y.T
    x = [np.asarray(x0, dtype=float)]
    for i in range(len(t) - 1):
        step = solve_ivp(lambda s, z, i=i: rate(s, z, u[i]), (t[i], t[i + 1]), x[-1], rtol=1e-10, atol=1e-10)
        x.append(step.y[:, -1])
    return np.array(x)


def lorenz(n=500, dt=0.01, noise=0.0, seed=0, x0=(-8.0, 8.0, 27.0)):
    t = dt * np.arange(n)
    x = follow(lambda s, z: [10 * (z[1] - z[0]), z[0] * (28 - z[2]) - z[1], z[0] * z[1] - 8 / 3 * z[2]], x0, t)
    return t, x + noise * np.random.default_rng(seed).normal(size=x.shape)


LORENZ = [{"x": -10.0, "y": 10.0}, {"x": 28.0, "y": -1.0, "x z": -1.0}, {"z": -8 / 3, "x y": 1.0}]


def van_der_pol(n=600, dt=0.02, noise=0.0, seed=0, x0=(1.0, 0.5)):
    t = dt * np.arange(n)
    x = follow(lambda s, z: [z[1], 2.0 * (1 - z[0] ** 2) * z[1] - z[0]], x0, t)
    return t, x + noise * np.random.default_rng(seed).normal(size=x.shape)


VAN_DER_POL = [{"v": 1.0}, {"x": -1.0, "v": 2.0, "x^2 v": -2.0}]


def pendulum(n=400, dt=0.02, noise=0.0, seed=0, x0=(0.5, 0.0)):
    """A pendulum with friction and a torque, which is held from sample to sample."""
    t = dt * np.arange(n)
    rng = np.random.default_rng(seed + 100)
    u = np.repeat(rng.uniform(-4, 4, size=n // 10 + 1), 10)[:n, None]
    x = follow(lambda s, z, v: [z[1], -9.81 * np.sin(z[0]) - 0.4 * z[1] + 2 * v[0]], x0, t, u)
    return t, x + noise * np.random.default_rng(seed).normal(size=x.shape), u


PENDULUM = [{"w": 1.0}, {"sin(th)": -9.81, "w": -0.4, "u": 2.0}]


def found(model):
    """Terms and coefficients of every equation; factors of a product in the order of the alphabet."""
    return [{" ".join(sorted(s.term.split(" "))): s.coefficient for s in e.summands} for e in model.report_.equations]


def assert_found(model, truth, tolerance):
    """The model has the true terms and no others, with coefficients within the relative tolerance."""
    got = found(model)
    wanted = [{" ".join(sorted(term.split(" "))): c for term, c in row.items()} for row in truth]
    assert [set(row) for row in got] == [set(row) for row in wanted], got
    for row, true in zip(got, wanted, strict=True):
        for term, value in true.items():
            assert abs(row[term] - value) < tolerance * abs(value), (term, row[term], value)
