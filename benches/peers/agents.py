"""Agents of Stable-Baselines3 that learn on the system: real steps until they solve it."""

import json
import math
import os
import statistics
from concurrent.futures import ProcessPoolExecutor

from .shared import ONE_THREAD, earlier, say, tell, write

ENVIRONMENTS = {
    "pendulum": "Pendulum-v1",
    "mountain-car": "MountainCarContinuous-v0",
    "inverted-pendulum": "InvertedPendulum-v5",
}
EPISODES = 100
THRESHOLD = 475.0
EVERY = {"dqn": 1_000, "ppo": 1_024}
SETTINGS = {
    "dqn": {"learning_rate": 2.3e-3, "batch_size": 64, "buffer_size": 100_000, "learning_starts": 1_000, "gamma": 0.99,
            "target_update_interval": 10, "train_freq": 256, "gradient_steps": 128, "exploration_fraction": 0.16,
            "exploration_final_eps": 0.04, "policy_kwargs": {"net_arch": [256, 256]}},
    "ppo": {"n_steps": 32, "batch_size": 256, "gae_lambda": 0.8, "gamma": 0.98, "n_epochs": 20, "ent_coef": 0.0, "learning_rate": 1e-3, "clip_range": 0.2},
}
# The budget over which the zoo anneals exploration (DQN), learning rate and clip range (PPO).
ZOO_STEPS = {"dqn": 50_000, "ppo": 100_000}
PPO_ENVIRONMENTS = 8


def mean_return(model, env, episodes, first):
    """Of episodes from start states drawn anew."""
    sums = []
    for episode in range(episodes):
        observation, _ = env.reset(seed=first + episode)
        total, over = 0.0, False
        while not over:
            action, _ = model.predict(observation, deterministic=True)
            observation, reward, terminated, truncated, _ = env.step(action)
            total, over = total + float(reward), terminated or truncated
        sums.append(total)
    return statistics.mean(sums)


def baseline(task, seed, settings):
    """One run of Stable-Baselines3's SAC with the settings, as JSON, that `sindyna compare` left."""
    import gymnasium as gym
    import torch
    from stable_baselines3 import SAC

    torch.set_num_threads(1)
    seed, settings = int(seed), json.loads(settings)
    sac, schedule = settings["sac"], settings["schedule"]
    checks = schedule["checks"]

    class Real(gym.Wrapper):
        """Tells when an episode began, and scales what it pays."""

        fresh = True

        def reset(self, **more):
            self.fresh = True
            return self.env.reset(**more)

        def step(self, action):
            observation, reward, *rest = self.env.step(action)
            return observation, reward * sac["reward_scale"], *rest

    class Holding(SAC):
        """Holds an explored action for so many steps, as ours does."""

        left, held = 0, None

        def _sample_action(self, learning_starts, action_noise=None, n_envs=1):
            if real.fresh or self.left == 0:
                real.fresh, self.left = False, schedule["held_steps"]
                self.held = super()._sample_action(learning_starts, action_noise, n_envs)
            self.left -= 1
            return self.held

    real, env = Real(gym.make(ENVIRONMENTS[task])), gym.make(ENVIRONMENTS[task])
    model = Holding(
        "MlpPolicy", real, seed=seed, device="cpu", learning_rate=sac["learning_rate"], gamma=sac["discount"],
        tau=sac["polyak"], batch_size=sac["batch_size"], ent_coef=f"auto_{sac['initial_temperature']}",
        target_entropy=sac.get("target_entropy", "auto"), buffer_size=schedule["real_steps"],
        learning_starts=schedule["first_steps"], train_freq=1, gradient_steps=schedule["updates_per_step"],
        policy_kwargs={"net_arch": sac["hidden"]})
    curve, solved = [], None
    for steps in range(checks["every"], schedule["real_steps"] + 1, checks["every"]):
        model.learn(checks["every"], reset_num_timesteps=steps == checks["every"])
        mean = mean_return(model, env, checks["episodes"], 100_000 * (seed + 1) + steps)
        curve.append([steps, mean])
        if mean >= checks["until"]:
            solved = steps
            break
    final = mean_return(model, env, EPISODES, 100_000 * (seed + 1) + 50_000)
    tell(**{"seed": seed, "solved_after": solved, "return": final, "curve": curve})


def middle(runs):
    """Median of steps; none where more than half of the runs never solve the task."""
    found = statistics.median([r["solved_after"] or math.inf for r in runs])
    return found if math.isfinite(found) else None


def annealed(initial):
    """`initial`, falling linearly to 0 at the end of learning."""
    return lambda left: initial * left


def one_of_zoo(case):
    """One agent with one seed: its learning curve, and the real steps after which it solved the task."""
    agent, seed, budget = case
    import gymnasium as gym
    import torch
    from stable_baselines3 import DQN, PPO
    from stable_baselines3.common.callbacks import BaseCallback
    from stable_baselines3.common.env_util import make_vec_env

    torch.set_num_threads(1)
    curve, env = [], gym.make("CartPole-v1")

    class Checks(BaseCallback):
        def _on_step(self):
            if self.num_timesteps % EVERY[agent] == 0:
                curve.append([self.num_timesteps, mean_return(self.model, env, EPISODES, 100_000 * (seed + 1) + self.num_timesteps)])
            return not curve or curve[-1][1] < THRESHOLD

    settings = dict(SETTINGS[agent])
    if agent == "ppo":
        settings |= {name: annealed(settings[name]) for name in ("learning_rate", "clip_range")}
        model = PPO("MlpPolicy", make_vec_env("CartPole-v1", PPO_ENVIRONMENTS, seed=seed), seed=seed, device="cpu", **settings)
    else:
        model = DQN("MlpPolicy", make_vec_env("CartPole-v1", 1, seed=seed), seed=seed, device="cpu", **settings)
    model.learn(min(budget, ZOO_STEPS[agent]), callback=Checks())
    solved = curve[-1][0] if curve and curve[-1][1] >= THRESHOLD else None
    return {"agent": agent, "seed": seed, "solved_after": solved, "curve": curve}


def dqn_ppo(seeds=range(10), jobs=2, budget=100_000, out="dqn-ppo"):
    """Stable-Baselines3's DQN and PPO on CartPole-v1, whose actions are numbered: real steps until solved, at most those of the zoo.

    The same protocol as `sindyna compare`: checks of a hundred episodes from start states drawn anew, every so many real steps; solved at
    the first whose mean return reaches 475. Hyper-parameters are those of the RL Zoo for CartPole-v1. Writes results/OUT.json; seeds
    that are in it are not run again.
    """
    os.environ |= ONE_THREAD
    runs = earlier(out)
    done = {(r["agent"], r["seed"]) for r in runs}
    cases = [(agent, seed, budget) for agent in SETTINGS for seed in seeds if (agent, seed) not in done]
    with ProcessPoolExecutor(jobs) as pool:
        for found in pool.map(one_of_zoo, cases):
            say(f"{found['agent']} seed {found['seed']}: {found['solved_after']}")
            runs.append(found)
            agents = {}
            for agent in dict.fromkeys(r["agent"] for r in runs):
                of_agent = [r for r in runs if r["agent"] == agent]
                solved = sum(r["solved_after"] is not None for r in of_agent)
                agents[agent] = {"seeds": len(of_agent), "solved": solved, "median_steps": middle(of_agent)}
            write(out, threshold=THRESHOLD, settings=SETTINGS, agents=agents, runs=runs)
