"""Stable-Baselines3's DQN and PPO on CartPole-v1, whose actions are numbered: real steps until solved.

The same protocol as `sindyna compare`: checks of a hundred episodes from start states drawn anew, every so many real steps; solved at the
first whose mean return reaches 475. Hyper-parameters are those of the RL Zoo for CartPole-v1. Writes results/dqn-ppo.json; seeds that are in it are not run again.

Usage: .venv-peers/bin/python benches/dqn_ppo.py [--seeds 10] [--jobs 2] [--budget 100000] [--out results/dqn-ppo.json]
"""
import argparse
import json
import os
import statistics
import sys
from concurrent.futures import ProcessPoolExecutor
from importlib.metadata import version
from pathlib import Path

THRESHOLD = 475.0
EPISODES = 100
EVERY = {"dqn": 1_000, "ppo": 1_024}
SETTINGS = {
    "dqn": dict(learning_rate=2.3e-3, batch_size=64, buffer_size=100_000, learning_starts=1_000, gamma=0.99, target_update_interval=10,
                train_freq=256, gradient_steps=128, exploration_fraction=0.16, exploration_final_eps=0.04,
                policy_kwargs=dict(net_arch=[256, 256])),
    "ppo": dict(n_steps=32, batch_size=256, gae_lambda=0.8, gamma=0.98, n_epochs=20, ent_coef=0.0, learning_rate=1e-3, clip_range=0.2),
}
# The budget over which the zoo anneals exploration (DQN), learning rate and clip range (PPO).
ZOO_STEPS = {"dqn": 50_000, "ppo": 100_000}
PPO_ENVIRONMENTS = 8


def annealed(initial):
    """`initial`, falling linearly to 0 at the end of learning."""
    return lambda left: initial * left


def mean_return(model, seed):
    import gymnasium as gym
    env = gym.make("CartPole-v1")
    sums = []
    for episode in range(EPISODES):
        observation, _ = env.reset(seed=seed + episode)
        total, over = 0.0, False
        while not over:
            action, _ = model.predict(observation, deterministic=True)
            observation, reward, terminated, truncated, _ = env.step(action)
            total, over = total + float(reward), terminated or truncated
        sums.append(total)
    return statistics.mean(sums)


def run(case):
    """One agent with one seed: its learning curve, and the real steps after which it solved the task."""
    agent, seed, budget = case
    import torch
    from stable_baselines3 import DQN, PPO
    from stable_baselines3.common.callbacks import BaseCallback
    from stable_baselines3.common.env_util import make_vec_env

    torch.set_num_threads(1)
    curve = []

    class Checks(BaseCallback):
        def _on_step(self):
            if self.num_timesteps % EVERY[agent] == 0:
                curve.append([self.num_timesteps, mean_return(self.model, 100_000 * (seed + 1) + self.num_timesteps)])
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


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--budget", type=int, default=100_000, help="real steps, at most; those of the zoo where fewer")
    parser.add_argument("--out", type=Path, default=Path("results/dqn-ppo.json"))
    args = parser.parse_args()
    os.environ["OMP_NUM_THREADS"] = "1"
    runs = json.loads(args.out.read_text())["runs"] if args.out.exists() else []
    done = {(r["agent"], r["seed"]) for r in runs}
    cases = [(agent, seed, args.budget) for agent in SETTINGS for seed in range(args.seeds) if (agent, seed) not in done]
    with ProcessPoolExecutor(args.jobs) as pool:
        for found in pool.map(run, cases):
            print(f"{found['agent']} seed {found['seed']}: {found['solved_after']}", file=sys.stderr, flush=True)
            runs.append(found)
            agents = {}
            for agent in SETTINGS:
                steps = sorted(r["solved_after"] or float("inf") for r in runs if r["agent"] == agent)
                if steps:
                    median = statistics.median(steps)
                    agents[agent] = {"seeds": len(steps), "solved": sum(s < float("inf") for s in steps),
                                     "median_steps": median if median < float("inf") else None}
            document = {"command": " ".join(["benches/dqn_ppo.py", *sys.argv[1:]]), "threshold": THRESHOLD, "settings": SETTINGS,
                        "versions": {name: version(name) for name in ("stable_baselines3", "gymnasium", "torch")},
                        "agents": agents, "runs": runs}
            args.out.write_text(json.dumps(document, indent=1) + "\n")


if __name__ == "__main__":
    main()
