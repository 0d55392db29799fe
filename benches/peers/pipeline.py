"""The job as one does it today in Python: Gymnasium rollout -> PySINDy -> SB3/SBX agent in the model -> real check."""

import time
import warnings

import gymnasium as gym
import numpy as np
import pysindy as ps

from .shared import tell

warnings.filterwarnings("ignore")

TASKS = {
    "pendulum": {"env": "Pendulum-v1", "threshold": -180.0, "every": 250, "sac": {"learning_rate": 1e-3}},
    "mountain-car": {
        "env": "MountainCarContinuous-v0", "threshold": 90.0, "every": 1000,
        "sac": {"learning_rate": 3e-4, "buffer_size": 50000, "batch_size": 512, "ent_coef": 0.1, "train_freq": 32, "gradient_steps": 32,
                 "gamma": 0.9999, "tau": 0.01, "learning_starts": 0, "use_sde": True,
                 "policy_kwargs": {"log_std_init": -3.67, "net_arch": [64, 64]}}},
    "inverted-pendulum": {"env": "InvertedPendulum-v5", "threshold": 950.0, "every": 500, "sac": {}},
    "cart-pole": {
        "env": "CartPole-v1", "threshold": 475.0, "every": 1000, "copies": 8,
        "ppo": {"n_steps": 32, "batch_size": 256, "gae_lambda": 0.8, "gamma": 0.98, "n_epochs": 20, "ent_coef": 0.0,
                 "learning_rate": lambda left: 0.001 * left, "clip_range": lambda left: 0.2 * left},
        "dqn": {"learning_rate": 2.3e-3, "batch_size": 64, "buffer_size": 100000, "learning_starts": 1000, "gamma": 0.99,
                 "target_update_interval": 10, "train_freq": 256, "gradient_steps": 128, "exploration_fraction": 0.16,
                 "exploration_final_eps": 0.04, "policy_kwargs": {"net_arch": [256, 256]}}},
}
POLYNOMIAL = ("inverted-pendulum", "cart-pole")


def to_state(name, obs):
    if name == "pendulum":
        return np.array([np.arctan2(obs[1], obs[0]), obs[2]])
    return np.asarray(obs, dtype=float)


def wrap(name, s):
    if name == "pendulum":
        s = s.copy()
        s[..., 0] = (s[..., 0] + np.pi) % (2 * np.pi) - np.pi
    return s


def control(space, action):
    """What the system receives: -1 or 1 for numbered actions."""
    if isinstance(space, gym.spaces.Discrete):
        return np.array([2.0 * float(action) - 1.0])
    return np.clip(action, space.low, space.high)


class ModelEnv(gym.Env):
    """The learned model behind Gymnasium's interface; reward, resets and ends are the task's own."""

    def __init__(self, name, real, coefficients, features, seed):
        self.name, self.real, self.C, self.features = name, real, coefficients, features
        self.observation_space, self.action_space = real.observation_space, real.action_space
        self.limit = real.spec.max_episode_steps

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        obs, info = self.real.reset(seed=seed)
        self.s, self.t = to_state(self.name, obs), 0
        return obs, info

    def step(self, action):
        a = control(self.action_space, action)
        before = self.s
        s = self.C @ self.features(np.r_[before, a])
        self.t += 1
        terminated = False
        if self.name == "pendulum":
            s[1] = np.clip(s[1], -8, 8)
            th = wrap("pendulum", before)[0]
            reward = -(th ** 2 + 0.1 * before[1] ** 2 + 0.001 * float(a[0]) ** 2)
            obs = np.array([np.cos(s[0]), np.sin(s[0]), s[1]], dtype=np.float32)
        elif self.name == "mountain-car":
            s[1] = np.clip(s[1], -0.07, 0.07)
            s[0] = np.clip(s[0], -1.2, 0.6)
            if s[0] <= -1.2 and s[1] < 0:
                s[1] = 0.0
            terminated = bool(s[0] >= 0.45 and s[1] >= 0)
            reward = (100.0 if terminated else 0.0) - 0.1 * float(a[0]) ** 2
            obs = s.astype(np.float32)
        elif self.name == "cart-pole":
            terminated = bool(not np.isfinite(s).all() or abs(s[0]) > 2.4 or abs(s[2]) > 12 * 2 * np.pi / 360)
            reward, obs = 1.0, np.nan_to_num(s).astype(np.float32)
        else:
            terminated = bool(not np.isfinite(s).all() or abs(s[1]) > 0.2)
            reward = 0.0 if terminated else 1.0
            obs = s
        self.s = s
        return obs, reward, terminated, self.t >= self.limit, {}


def collect(name, env, n, seed):
    rng = np.random.default_rng(seed)
    X, U, Y = [], [], []
    obs, _ = env.reset(seed=seed)
    a = None
    for t in range(n):
        if name == "inverted-pendulum":
            a = np.array([(1.0 if t % 2 else -1.0) * rng.uniform(0.05, 0.6)])
        elif name == "cart-pole":
            a = np.asarray(rng.integers(2))
        elif t % 5 == 0:
            a = rng.uniform(env.action_space.low, env.action_space.high)
        before = to_state(name, obs)
        obs, _, term, trunc, _ = env.step(int(a) if name == "cart-pole" else a.astype(np.float32))
        after = to_state(name, obs)
        if name == "pendulum":
            after[0] = before[0] + (after[0] - before[0] + np.pi) % (2 * np.pi) - np.pi
        X.append(before), U.append(control(env.action_space, a)), Y.append(after)
        if term or trunc:
            obs, _ = env.reset()
    return np.array(X), np.array(U), np.array(Y)


def library(name):
    """Candidate terms."""
    if name in POLYNOMIAL:
        return ps.PolynomialLibrary(3)
    return ps.PolynomialLibrary(2, include_interaction=False) + ps.FourierLibrary(n_frequencies=3)


def identify(name, X, U, Y):
    """Coefficients by STLSQ, and the terms as a function."""
    lib, Z = library(name), np.hstack([X, U])
    lib.fit(Z)
    theta = np.asarray(lib.transform(Z))
    opt = ps.STLSQ(threshold=0.0009, alpha=1e-8).fit(theta, Y)
    C = np.asarray(opt.coef_)
    if name in POLYNOMIAL:
        powers = np.asarray(lib.powers_)

        def features(z):
            return np.prod(z ** powers, axis=1)
    else:
        def features(z):
            parts = [[1.0], z, z ** 2]
            for k in (1, 2, 3):
                parts.append(np.column_stack([np.sin(k * z), np.cos(k * z)]).ravel())
            return np.concatenate(parts)
    assert np.allclose(features(Z[0]), theta[0])
    return C, features


def pipeline(task, seed=0, backend="sb3", steps=60000, real_steps=200, seconds=float("inf"), threads=1):
    """The whole job by PySINDy and an agent of another library: one JSON line per evaluation.

    Wall seconds are since the start, imports and evaluations left out; steps are those in the model, the return is the mean of 10 episodes
    in the real environment. Ends at the first evaluation at or above the threshold, after so many steps or seconds. Backends: sb3, sbx;
    cart-pole has numbered actions, for which neither has SAC: there they are their PPO, sb3-dqn and sbx-dqn their DQN, with the settings
    tuned for it in RL Baselines3 Zoo. The model gets 200 real steps, more than the paper needs, because PySINDy's STLSQ seldom finds a
    usable model of these systems from the paper's 20 to 50.
    """
    about, begun = TASKS[task], time.time()
    library, _, algorithm = backend.partition("-")
    algorithm = algorithm or ("sac" if "sac" in about else "ppo")
    if library == "sb3":
        import stable_baselines3 as agents
        import torch
        torch.set_num_threads(threads)
    else:
        import sbx as agents
    from stable_baselines3.common.callbacks import BaseCallback
    from stable_baselines3.common.evaluation import evaluate_policy
    from stable_baselines3.common.monitor import Monitor
    from stable_baselines3.common.vec_env import DummyVecEnv

    imports, begun = time.time() - begun, time.time()
    real = gym.make(about["env"])
    coefficients, features = identify(task, *collect(task, real, real_steps, seed))
    tell(imports=round(imports, 2), fit=round(time.time() - begun, 3), nonzero=int((coefficients != 0).sum()), parameters=coefficients.size)
    copies = about.get("copies", 1) if algorithm == "ppo" else 1
    env = DummyVecEnv([lambda: Monitor(ModelEnv(task, gym.make(about["env"]), coefficients, features, seed))] * copies)
    check = gym.make(about["env"])

    class Check(BaseCallback):
        spent = 0.0

        def _on_step(self):
            if self.num_timesteps % about["every"]:
                return True
            now = time.time()
            check.reset(seed=10_000 + seed)
            mean, _ = evaluate_policy(self.model, check, 10, deterministic=True, warn=False)
            self.spent += time.time() - now
            tell(task=task, backend=backend, seed=seed, steps=self.num_timesteps, mean_return=round(float(mean), 2),
                 solved=bool(mean >= about["threshold"]), wall_s=round(time.time() - begun - self.spent, 2))
            return bool(mean < about["threshold"]) and now - begun - self.spent < seconds

    getattr(agents, algorithm.upper())("MlpPolicy", env, seed=seed, **about[algorithm]).learn(steps, callback=Check())
