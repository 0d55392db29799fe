#!/usr/bin/env python3
"""Stable-Baselines3's SAC, or that of SBX, trained in a learned environment, judged on the true one.

Usage: scripts/python_sb3.py [--seeds N] [--steps N] [--sbx]
Needs: the Python package with its extra `sb3`, for SBX `sbx-rl` too. Writes results/python-sb3.json or results/python-sbx.json, run by run.
"""
import argparse
import json
import time

import gymnasium
import numpy as np
import sindyna
import stable_baselines3
import torch
from stable_baselines3.common.env_checker import check_env
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor

from study import ROOT


def run(made, seed, steps):
    """SAC for so many steps in the equations found from ten steps of Pendulum-v1; 100 episodes on Pendulum-v1 itself."""
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
    promised, _ = evaluate_policy(agent, learned, 100, return_episode_rewards=True)
    return {
        "seed": seed,
        "real_steps": found.real_steps,
        "steps_in_the_learned_environment": steps,
        "mean_return": float(np.mean(returns)),
        "mean_return_in_the_learned_environment": float(np.mean(promised)),
        "sindyna's_own_policy": found.mean_return,
        "solved": bool(np.mean(returns) >= -200.0),
        "seconds": round(time.perf_counter() - begun, 1),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--steps", type=int, default=15000)
    parser.add_argument("--sbx", action="store_true")
    asked = parser.parse_args()
    torch.set_num_threads(1)
    if asked.sbx:
        import sbx as agents
    else:
        agents = stable_baselines3
    name = "sbx" if asked.sbx else "sb3"
    path = ROOT / "results" / f"python-{name}.json"
    runs = []
    for seed in range(asked.seeds):
        runs.append(run(agents.SAC, seed, asked.steps))
        print(json.dumps(runs[-1]), flush=True)
        about = {"command": "scripts/python_sb3.py" + " --sbx" * asked.sbx, "stable_baselines3": stable_baselines3.__version__}
        about |= {"sbx": agents.__version__} if asked.sbx else {"torch": torch.__version__}
        path.write_text(json.dumps({"about": about, "runs": runs}, indent=1) + "\n")


if __name__ == "__main__":
    main()
