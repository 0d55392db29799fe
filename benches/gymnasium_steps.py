"""Nanoseconds of a step of Gymnasium's environment, without wrappers. Prints one JSON line.

Usage: python gymnasium_steps.py ENVIRONMENT
"""
import json
import statistics
import sys
import time

import gymnasium

env = gymnasium.make(sys.argv[1]).unwrapped
env.reset(seed=0)
env.action_space.seed(0)
actions = [env.action_space.sample() * 0 for _ in range(200)]
times = []
for _ in range(50):
    env.reset()
    start = time.perf_counter()
    for action in actions:
        env.step(action)
    times.append((time.perf_counter() - start) * 1e9 / len(actions))
print(json.dumps(dict(median_ns=statistics.median(times), least_ns=min(times))))
