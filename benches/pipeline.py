"""The job as one does it today in Python: Gymnasium rollout -> PySINDy -> SB3/SBX agent in the model -> real check.

Prints one JSON line per evaluation: wall seconds since the start (imports and evaluations left out), steps taken in the
model, mean return of 10 episodes in the real environment; ends at the first evaluation at or above the threshold, after
--steps, or after --seconds.

Usage: python pipeline.py {pendulum,mountain-car,inverted-pendulum,cart-pole} [--seed 0] [--backend sb3|sbx] [--steps N]
cart-pole has numbered actions, for which neither library has SAC: there sb3 and sbx are their PPO, sb3-dqn and sbx-dqn
their DQN, with the settings tuned for it in RL Baselines3 Zoo.
The model gets --real-steps real steps (200 unless told), more than the paper needs, because PySINDy's STLSQ
seldom finds a usable model of these systems from the paper's 20 to 50.
"""
import argparse
import json
import time
import warnings

import gymnasium as gym
import numpy as np
import pysindy as ps

warnings.filterwarnings("ignore")

TASKS = {
    "pendulum": dict(env="Pendulum-v1", threshold=-180.0, every=250, sac=dict(learning_rate=1e-3)),
    "mountain-car": dict(
        env="MountainCarContinuous-v0", threshold=90.0, every=1000,
        sac=dict(learning_rate=3e-4, buffer_size=50000, batch_size=512, ent_coef=0.1, train_freq=32, gradient_steps=32,
                 gamma=0.9999, tau=0.01, learning_starts=0, use_sde=True,
                 policy_kwargs=dict(log_std_init=-3.67, net_arch=[64, 64]))),
    "inverted-pendulum": dict(env="InvertedPendulum-v5", threshold=950.0, every=500, sac=dict()),
    "cart-pole": dict(
        env="CartPole-v1", threshold=475.0, every=1000, copies=8,
        ppo=dict(n_steps=32, batch_size=256, gae_lambda=0.8, gamma=0.98, n_epochs=20, ent_coef=0.0,
                 learning_rate=lambda left: 0.001 * left, clip_range=lambda left: 0.2 * left),
        dqn=dict(learning_rate=2.3e-3, batch_size=64, buffer_size=100000, learning_starts=1000, gamma=0.99,
                 target_update_interval=10, train_freq=256, gradient_steps=128, exploration_fraction=0.16,
                 exploration_final_eps=0.04, policy_kwargs=dict(net_arch=[256, 256]))),
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


def identify(name, X, U, Y):
    if name in POLYNOMIAL:
        lib = ps.PolynomialLibrary(3)
    else:
        lib = ps.PolynomialLibrary(2, include_interaction=False) + ps.FourierLibrary(n_frequencies=3)
    Z = np.hstack([X, U])
    lib.fit(Z)
    theta = np.asarray(lib.transform(Z))
    opt = ps.STLSQ(threshold=0.0009, alpha=1e-8).fit(theta, Y)
    C = np.asarray(opt.coef_)
    if name in POLYNOMIAL:
        powers = np.asarray(lib.powers_)
        features = lambda z: np.prod(z ** powers, axis=1)
    else:
        def features(z):
            parts = [[1.0], z, z ** 2]
            for k in (1, 2, 3):
                parts.append(np.column_stack([np.sin(k * z), np.cos(k * z)]).ravel())
            return np.concatenate(parts)
    assert np.allclose(features(Z[0]), theta[0])
    return C, features


def main():
    p = argparse.ArgumentParser()
    p.add_argument("task", choices=TASKS)
    p.add_argument("--seed", type=int, default=0)
    p.add_argument("--backend", default="sb3", choices=["sb3", "sbx", "sb3-dqn", "sbx-dqn"])
    p.add_argument("--steps", type=int, default=60000)
    p.add_argument("--real-steps", type=int, default=200)
    p.add_argument("--seconds", type=float, default=float("inf"), help="give up after so many, evaluations left out")
    p.add_argument("--threads", type=int, default=1)
    o = p.parse_args()
    task = TASKS[o.task]
    t0 = time.time()
    library, _, algorithm = o.backend.partition("-")
    algorithm = algorithm or ("sac" if "sac" in task else "ppo")
    if library == "sb3":
        import torch
        torch.set_num_threads(o.threads)
        import stable_baselines3 as agents
    else:
        import sbx as agents
    make_agent = getattr(agents, algorithm.upper())
    from stable_baselines3.common.callbacks import BaseCallback
    from stable_baselines3.common.evaluation import evaluate_policy
    from stable_baselines3.common.monitor import Monitor
    from stable_baselines3.common.vec_env import DummyVecEnv

    imports = time.time() - t0
    t0 = time.time()
    real = gym.make(task["env"])
    X, U, Y = collect(o.task, real, o.real_steps, o.seed)
    C, features = identify(o.task, X, U, Y)
    fit = time.time() - t0
    print(json.dumps(dict(imports=round(imports, 2), fit=round(fit, 3), nonzero=int((C != 0).sum()), parameters=int(C.size))), flush=True)
    copies = task.get("copies", 1) if algorithm == "ppo" else 1
    env = DummyVecEnv([lambda: Monitor(ModelEnv(o.task, gym.make(task["env"]), C, features, o.seed))] * copies)
    check = gym.make(task["env"])

    class Check(BaseCallback):
        spent = 0.0

        def _on_step(self):
            if self.num_timesteps % task["every"]:
                return True
            t = time.time()
            check.reset(seed=10_000 + o.seed)
            r, _ = evaluate_policy(self.model, check, 10, deterministic=True, warn=False)
            self.spent += time.time() - t
            print(json.dumps(dict(task=o.task, backend=o.backend, seed=o.seed, steps=self.num_timesteps,
                                  mean_return=round(float(r), 2), solved=bool(r >= task["threshold"]), wall_s=round(time.time() - t0 - self.spent, 2))), flush=True)
            return bool(r < task["threshold"]) and t - t0 - self.spent < o.seconds

    make_agent("MlpPolicy", env, seed=o.seed, **task[algorithm]).learn(o.steps, callback=Check())


if __name__ == "__main__":
    main()
