"""SBX's SAC (JAX) on Pendulum-v1: updates alone per second, in one compiled scan of 1000, and environment step with update.

Prints one JSON line. Usage: python sbx_sac_updates.py THREADS NET; networks NET×NET, batch 256.
"""
import json
import os
import statistics
import sys
import time

threads, net = sys.argv[1], int(sys.argv[2])
eigen = "false" if threads == "1" else "true"
os.environ["XLA_FLAGS"] = f"--xla_cpu_multi_thread_eigen={eigen} intra_op_parallelism_threads={threads}"
from sbx import SAC  # noqa: E402
from stable_baselines3.common.logger import configure  # noqa: E402

model = SAC("MlpPolicy", "Pendulum-v1", policy_kwargs=dict(net_arch=[net, net]), learning_starts=100, seed=0)
model.learn(300)
start = time.perf_counter()
model.learn(600, reset_num_timesteps=False)
both = 600 / (time.perf_counter() - start)
model.set_logger(configure(None, []))
model.train(gradient_steps=1000, batch_size=256)
rates = []
for _ in range(3):
    start = time.perf_counter()
    model.train(gradient_steps=1000, batch_size=256)
    rates.append(1000 / (time.perf_counter() - start))
print(json.dumps(dict(peer="sbx", net=net, updates_per_s=statistics.median(rates), with_steps_per_s=both)))
