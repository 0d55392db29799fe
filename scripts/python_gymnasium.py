#!/usr/bin/env python3
"""Controllers of Gymnasium's environments from ten steps each, by the Python package: ten lines of Python, ten seeds, 100 episodes.

Usage: scripts/python_gymnasium.py [--seeds N] [--only ENV]
Needs: the Python package with its extra `gymnasium`, and gymnasium[classic-control,mujoco]. Writes results/python-gymnasium.json, run by run.
"""
import argparse
import json
import time
import warnings

import gymnasium
import numpy as np
import sindyna

from study import ROOT

#: What a user says of each environment: which values are angles, what pays, what ends an episode. Nothing else is told.
TASKS = {
    "Pendulum-v1": {},
    "CartPole-v1": {"angles": [2], "reward": "1", "terminated": "abs(next_x0) > 2.4 or abs(next_x2) > 12*pi/180"},
    "MountainCarContinuous-v0": {"reward": "100*terminated - 0.1*u^2", "terminated": "next_x0 >= 0.45 and next_x1 >= 0"},
    "InvertedPendulum-v5": {"angles": [1], "reward": "1 - terminated", "terminated": "abs(next_x1) > 0.2"},
    "MountainCar-v0": {"reward": "-1", "terminated": "next_x0 >= 0.5 and next_x1 >= 0"},
    "Acrobot-v1": {"angles": [(0, 1), (2, 3)], "reward": "terminated - 1", "terminated": "-cos(next_angle) - cos(next_angle + next_angle2) > 1"},
}

#: Mean returns from which a task counts as solved, where Gymnasium has none: those of `sindyna tasks`.
THRESHOLDS = {"Pendulum-v1": -180.0}


def run(name, seed):
    begun = time.perf_counter()
    try:
        found = sindyna.learn(name, seed=seed, threshold=THRESHOLDS.get(name), **TASKS[name])
    except ValueError as error:
        return {"environment": name, "seed": seed, "error": str(error)}
    low, high, mean, _ = found.predicted_return or (None, None, None, None)
    return {
        "environment": name,
        "seed": seed,
        "real_steps": found.real_steps,
        "resets": found.resets,
        "certainty": found.report_.certainty,
        "equations": found.equations,
        "mean_return": found.mean_return,
        "worst_return": float(np.min(found.returns)),
        "predicted": [low, mean, high],
        "inside": low is not None and low <= found.mean_return <= high,
        "threshold": found.summary["threshold"],
        "solved": found.solved,
        "seconds": round(time.perf_counter() - begun, 1),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--only", choices=TASKS)
    asked = parser.parse_args()
    warnings.filterwarnings("ignore", module="gymnasium")
    path = ROOT / "results" / "python-gymnasium.json"
    runs = json.loads(path.read_text())["runs"] if path.exists() else []
    for name in [asked.only] if asked.only else TASKS:
        for seed in range(asked.seeds):
            if any((r["environment"], r["seed"]) == (name, seed) for r in runs):
                continue
            runs.append(run(name, seed))
            print(json.dumps(runs[-1]), flush=True)
            about = {"command": "scripts/python_gymnasium.py", "sindyna": sindyna.__version__, "gymnasium": gymnasium.__version__}
            path.write_text(json.dumps({"about": about, "runs": runs}, indent=1, ensure_ascii=False) + "\n")


if __name__ == "__main__":
    main()
