"""Stable-Baselines3's SAC on Pendulum-v1: updates alone per second, and environment step with update.

Prints one JSON line. Usage: python sb3_sac_updates.py THREADS NET; networks NET×NET, batch 256.
"""
import json
import sys
import time

import torch
from stable_baselines3 import SAC
from stable_baselines3.common.logger import configure

threads, net = int(sys.argv[1]), int(sys.argv[2])
torch.set_num_threads(threads)
model = SAC("MlpPolicy", "Pendulum-v1", policy_kwargs=dict(net_arch=[net, net]), learning_starts=100, seed=0, device="cpu")
model.learn(300)
start = time.perf_counter()
model.learn(600, reset_num_timesteps=False)
both = 600 / (time.perf_counter() - start)
model.set_logger(configure(None, []))
start = time.perf_counter()
model.train(gradient_steps=600, batch_size=256)
print(json.dumps(dict(peer="sb3", net=net, updates_per_s=600 / (time.perf_counter() - start), with_steps_per_s=both)))
