"""The Python package beside PySINDy, Gymnasium and Stable-Baselines3; needs its wheel in the same environment."""

import importlib
import json
import os
import statistics
import time
import warnings

from .shared import ONE_THREAD, ROOT, circumstances, earlier, tell, write

# NumPy reads this when it is imported.
os.environ |= ONE_THREAD

import numpy as np
import sindyna

warnings.filterwarnings("ignore")

TRUE = np.zeros((3, 10))
TRUE[0, [1, 2]], TRUE[1, [1, 2, 6]], TRUE[2, [3, 5]] = (-10, 10), (28, -1, -1), (-8 / 3, 1)


def lorenz(n, dt, noise):
    t = dt * np.arange(n)
    from scipy.integrate import solve_ivp

    def rate(_, z):
        return [10 * (z[1] - z[0]), z[0] * (28 - z[2]) - z[1], z[0] * z[1] - 8 / 3 * z[2]]

    x = solve_ivp(rate, (0, t[-1]), [-8, 8, 27], t_eval=t, rtol=1e-10, atol=1e-10).y.T
    return t, x + noise * np.random.default_rng(0).normal(size=x.shape)


def seconds(calls, repeats, number=1):
    """Median seconds of each call; they take turns."""
    taken = [[] for _ in calls]
    for call in calls:
        call()
    for _ in range(repeats):
        for own, call in zip(taken, calls):
            begun = time.perf_counter()
            for _ in range(number):
                call()
            own.append((time.perf_counter() - begun) / number)
    return [statistics.median(own) for own in taken]


def compared(ours, theirs, repeats, number=1):
    a, b = seconds([ours, theirs], repeats, number)
    return {"sindyna_s": a, "pysindy_s": b, "ratio": b / a, "repeats": repeats}


def same(module, threshold=0.1):
    """The same regression in either module."""
    return module.SINDy(
        optimizer=module.STLSQ(threshold=threshold),
        feature_library=module.PolynomialLibrary(degree=2),
        differentiation_method=module.FiniteDifference(),
    )


def fit():
    """The package beside PySINDy: fits, predictions, simulations, medians of repeats that take turns. Writes python/benchmark.json."""
    import pysindy as ps

    report = {}
    for n, repeats in ((100, 30), (5000, 20)):
        t, x = lorenz(n, 0.002, 0.0)
        report[f"STLSQ fit, Lorenz, {n} samples"] = compared(
            lambda x=x, t=t: same(sindyna).fit(x, t=t), lambda x=x, t=t: same(ps).fit(x, t=t), repeats
        )
        report[f"STLSQ fit, Lorenz, {n} samples, ten in a turn"] = compared(
            lambda x=x, t=t: same(sindyna).fit(x, t=t), lambda x=x, t=t: same(ps).fit(x, t=t), repeats // 2, 10
        )
    ours, theirs = same(sindyna).fit(x, t=t), same(ps).fit(x, t=t)
    report["largest difference of coefficients"] = float(np.abs(ours.coefficients() - theirs.coefficients()).max())
    one = x[:1]
    report["predict, one state"] = compared(lambda: ours.predict(one), lambda: theirs.predict(one), 30, 50)
    many = np.tile(x, (2, 1))
    report["predict, 10,000 states"] = compared(lambda: ours.predict(many), lambda: theirs.predict(many), 30)
    report["simulate, 1,000 times"] = compared(lambda: ours.simulate(x[0], t[:1000]), lambda: theirs.simulate(x[0], t[:1000]), 5)

    # The default of each, on noise: another job, and other answers.
    t, x = lorenz(500, 0.01, 0.2)
    a, b = sindyna.SINDy(), ps.SINDy()
    found = compared(lambda: a.fit(x, t=t), lambda: b.fit(x, t=t), 5)
    names = a.get_feature_names()
    columns = [names.index(name) for name in ("x0", "x1", "x2", "x0 x1", "x0 x2")]
    every, wanted = a.coefficients(), np.zeros_like(a.coefficients())
    wanted[:, columns] = TRUE[:, [1, 2, 3, 5, 6]]
    found["sindyna_terms_right"] = bool(np.array_equal(every != 0, wanted != 0))
    found["pysindy_terms_right"] = bool(np.array_equal(b.coefficients() != 0, TRUE != 0))
    found["sindyna_largest_error"] = float(np.abs(every - wanted).max())
    found["pysindy_largest_error"] = float(np.abs(b.coefficients() - TRUE).max())
    report["default fit, Lorenz with noise 0.2, 500 samples"] = found
    made = circumstances()
    path = ROOT / "python" / "benchmark.json"
    path.write_text(json.dumps({"command": made["command"], "versions": made["versions"], "results": report}, indent=1) + "\n")


COPIES, SECONDS, REPEATS = 1024, 0.5, 5


def rate(env, actions):
    """Steps of all copies in a second."""
    env.reset(seed=0)
    for _ in range(3):
        env.step(actions)
    steps, begun = 0, time.perf_counter()
    while time.perf_counter() - begun < SECONDS:
        env.step(actions)
        steps += env.num_envs
    return steps / (time.perf_counter() - begun)


def envs():
    """Steps per second of learned and built-in environments, beside Gymnasium's own. Writes results/python-envs.json."""
    import gymnasium
    import sindyna.envs
    from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv

    learned = sindyna.learn("Pendulum-v1", evaluation_episodes=1)
    pole = sindyna.learn("CartPole-v1", angles=[2], reward="1", terminated="abs(next_x0) > 2.4 or abs(next_x2) > 12*pi/180", evaluation_episodes=1)
    torque = np.zeros((COPIES, 1), dtype=np.float32)
    push = np.arange(COPIES) % 2
    cases = {
        "Pendulum, learned": (learned.vector_env(COPIES), torque),
        "Pendulum, built in": (gymnasium.make_vec("sindyna/Pendulum-v0", num_envs=COPIES), torque),
        "Pendulum-v1, SyncVectorEnv": (SyncVectorEnv([lambda: gymnasium.make("Pendulum-v1")] * COPIES), torque),
        "Pendulum-v1, AsyncVectorEnv": (AsyncVectorEnv([lambda: gymnasium.make("Pendulum-v1")] * COPIES), torque),
        "CartPole, learned": (pole.vector_env(COPIES), push),
        "CartPole, built in": (gymnasium.make_vec("sindyna/CartPole-v0", num_envs=COPIES), push),
        "CartPole-v1, SyncVectorEnv": (SyncVectorEnv([lambda: gymnasium.make("CartPole-v1")] * COPIES), push),
        "CartPole-v1, AsyncVectorEnv": (AsyncVectorEnv([lambda: gymnasium.make("CartPole-v1")] * COPIES), push),
        "CartPole-v1, Gymnasium's vector entry": (gymnasium.make_vec("CartPole-v1", num_envs=COPIES, vectorization_mode="vector_entry_point"), push),
    }
    found = {name: [] for name in cases}
    for _ in range(REPEATS):
        for name, case in cases.items():
            found[name].append(rate(*case))
    for env, _ in cases.values():
        env.close()
    about = {"copies": COPIES, "repeats": REPEATS, "seconds": SECONDS, "unit": "steps of all copies per second"}
    cases = {name: {"median": statistics.median(v), "least": min(v), "largest": max(v)} for name, v in found.items()}
    write("python-envs", about=about, cases=cases)


#: What a user says of each environment: which values are angles, what pays, what ends an episode. Nothing else is told.
TASKS = {
    "Pendulum-v1": {},
    "CartPole-v1": {"angles": [2], "reward": "1", "terminated": "abs(next_x0) > 2.4 or abs(next_x2) > 12*pi/180"},
    "MountainCarContinuous-v0": {"reward": "100*terminated - 0.1*u^2", "terminated": "next_x0 >= 0.45 and next_x1 >= 0"},
    "InvertedPendulum-v5": {"angles": [1], "reward": "1 - terminated", "terminated": "abs(next_x1) > 0.2"},
    "MountainCar-v0": {"reward": "-1", "terminated": "next_x0 >= 0.5 and next_x1 >= 0"},
    "Acrobot-v1": {"angles": [(0, 1), (2, 3)], "reward": "terminated - 1", "terminated": "-cos(next_angle) - cos(next_angle + next_angle2) > 1"},
}

#: Mean returns from which a task counts as solved, where Gymnasium has none: those of `sindyna tasks`.
THRESHOLDS = {"Pendulum-v1": -180.0}


def controller(name, seed):
    begun = time.perf_counter()
    try:
        found = sindyna.learn(name, seed=seed, threshold=THRESHOLDS.get(name), **TASKS[name])
    except ValueError as error:
        return {"environment": name, "seed": seed, "error": str(error)}
    low, high, mean, _ = found.predicted_return or (None, None, None, None)
    return {
        "environment": name,
        "seed": seed,
        "real_steps": found.real_steps,
        "resets": found.resets,
        "certainty": found.report_.certainty,
        "equations": found.equations,
        "mean_return": found.mean_return,
        "worst_return": float(np.min(found.returns)),
        "predicted": [low, mean, high],
        "inside": low is not None and low <= found.mean_return <= high,
        "threshold": found.summary["threshold"],
        "solved": found.solved,
        "seconds": round(time.perf_counter() - begun, 1),
    }


def controllers(seeds=range(10), only=tuple(TASKS)):
    """Controllers of Gymnasium's environments from ten steps each: ten lines of Python, ten seeds, 100 episodes.

    Writes results/python-gymnasium.json, run by run; what is in it is not run again.
    """
    runs = earlier("python-gymnasium")
    for name in only:
        for seed in seeds:
            if not any((r["environment"], r["seed"]) == (name, seed) for r in runs):
                runs.append(controller(name, seed))
                tell(**runs[-1])
                write("python-gymnasium", runs=runs)


def sac_in_equations(made, seed, steps):
    """SAC for so many steps in the equations found from ten steps of Pendulum-v1; 100 episodes on Pendulum-v1 itself."""
    import gymnasium
    from stable_baselines3.common.env_checker import check_env
    from stable_baselines3.common.evaluation import evaluate_policy
    from stable_baselines3.common.monitor import Monitor

    found = sindyna.learn("Pendulum-v1", seed=seed)
    check_env(found.env())
    begun = time.perf_counter()
    agent = made("MlpPolicy", Monitor(found.env()), seed=seed, learning_rate=1e-3, policy_kwargs={"net_arch": [64, 64]})
    agent.learn(steps)
    true = Monitor(gymnasium.make("Pendulum-v1"))
    true.reset(seed=1000 + seed)
    returns, _ = evaluate_policy(agent, true, 100, return_episode_rewards=True)
    learned = Monitor(found.env())
    learned.reset(seed=1000 + seed)
    predicted, _ = evaluate_policy(agent, learned, 100, return_episode_rewards=True)
    return {
        "seed": seed,
        "real_steps": found.real_steps,
        "steps_in_the_learned_environment": steps,
        "mean_return": float(np.mean(returns)),
        "mean_return_in_the_learned_environment": float(np.mean(predicted)),
        "sindyna's_own_policy": found.mean_return,
        "solved": bool(np.mean(returns) >= -200.0),
        "seconds": round(time.perf_counter() - begun, 1),
    }


def sb3(seeds=range(3), steps=15000, sbx=False):
    """Stable-Baselines3's SAC, or that of SBX, trained in a learned environment, judged on the true one.

    Writes results/python-sb3.json or results/python-sbx.json, run by run.
    """
    import torch

    torch.set_num_threads(1)
    agents = importlib.import_module("sbx" if sbx else "stable_baselines3")
    runs = []
    for seed in seeds:
        runs.append(sac_in_equations(agents.SAC, seed, steps))
        tell(**runs[-1])
        write("python-sbx" if sbx else "python-sb3", runs=runs)
