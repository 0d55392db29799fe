"""Play Gymnasium's InvertedPendulum-v5 and print every step, floats as hexadecimal float64.

Usage: python gymnasium_rollout.py SEED STEPS
First line: the version of MuJoCo. Then a line per step: action, reward, terminated, truncated and the observation; a
line of its own, with the observation only, after every reset. The random numbers go on from episode to episode.
"""
import math
import struct
import sys

import gymnasium
import mujoco
import numpy as np


def show(*values):
    print(*(struct.pack(">d", float(v)).hex() for v in values))


seed, steps = int(sys.argv[1]), int(sys.argv[2])
print(mujoco.__version__)
env = gymnasium.make("InvertedPendulum-v5")
observation, _ = env.reset(seed=seed)
show(*observation)
for i in range(steps):
    # Balances, but for a push of some steps now and then.
    push = 3.0 if i % 120 > 110 else 0.0
    action = 0.5 * observation[0] + 5 * observation[1] + 0.6 * observation[2] + observation[3]
    action = np.array([np.clip(action + 0.1 * math.sin(i) + push, -3, 3)], dtype=np.float32)
    observation, reward, terminated, truncated, _ = env.step(action)
    show(action[0], reward, terminated, truncated, *observation)
    if terminated or truncated:
        observation, _ = env.reset()
        show(*observation)
