#!/usr/bin/env python3
"""Steps per second of learned and built-in environments, beside Gymnasium's own.

Usage: benches/python_envs.py
Needs: the Python package (a release wheel) and gymnasium[classic-control]. Writes results/python-envs.json: medians of repeats that take turns.
"""
import json
import os
import pathlib
import platform
import statistics
import time

import gymnasium
import numpy as np
import sindyna
import sindyna.envs
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv

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


def main():
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
    result = {
        "about": {"copies": COPIES, "repeats": REPEATS, "seconds": SECONDS, "cores": os.cpu_count(), "machine": platform.processor() or platform.machine(),
                  "gymnasium": gymnasium.__version__, "numpy": np.__version__, "unit": "steps of all copies per second"},
        "cases": {name: {"median": statistics.median(v), "least": min(v), "largest": max(v)} for name, v in found.items()},
    }
    for env, _ in cases.values():
        env.close()
    path = pathlib.Path(__file__).resolve().parent.parent / "results" / "python-envs.json"
    path.write_text(json.dumps(result, indent=1) + "\n")
    for name, v in result["cases"].items():
        print(f"{name:40} {v['median']:12.3g} ({v['least']:.3g} to {v['largest']:.3g})")


if __name__ == "__main__":
    main()
