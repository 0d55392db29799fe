"""Our model-free baseline beside Stable-Baselines3's SAC with the same settings: real steps until solved, and what is reached.

Runs `sindyna compare --methods sac`, reads the settings it left, and trains Stable-Baselines3 with them under the same
protocol: checks of a hundred episodes from new start states at the same intervals, solved at the first that reaches the threshold, a hundred
episodes at the end. Steps do not depend on how busy the machine is. What is done is kept under --work and not done twice; in --out
other tasks stay as they are.

Usage: .venv-peers/bin/python benches/baselines.py [--seeds 20] [--tasks pendulum,...] [--jobs 2] [--out results/baselines.json]
"""
import argparse
import json
import os
import random
import statistics
import subprocess
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ENVIRONMENTS = {
    "pendulum": "Pendulum-v1",
    "mountain-car": "MountainCarContinuous-v0",
    "inverted-pendulum": "InvertedPendulum-v5",
}
RESAMPLES = 10_000
EPISODES = 100


def peer(task, seed, settings):
    """One run of Stable-Baselines3."""
    import gymnasium as gym
    import numpy as np
    import torch
    from stable_baselines3 import SAC

    torch.set_num_threads(1)
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

    def returns(model, episodes, first):
        env = gym.make(ENVIRONMENTS[task])
        sums = []
        for episode in range(episodes):
            observation, _ = env.reset(seed=first + episode)
            total, over = 0.0, False
            while not over:
                action, _ = model.predict(observation, deterministic=True)
                observation, reward, terminated, truncated, _ = env.step(action)
                total, over = total + float(reward), terminated or truncated
            sums.append(total)
        return sums

    real = Real(gym.make(ENVIRONMENTS[task]))
    model = Holding(
        "MlpPolicy", real, seed=seed, device="cpu", learning_rate=sac["learning_rate"], gamma=sac["discount"],
        tau=sac["polyak"], batch_size=sac["batch_size"], ent_coef=f"auto_{sac['initial_temperature']}",
        target_entropy=sac.get("target_entropy", "auto"), buffer_size=schedule["real_steps"],
        learning_starts=schedule["first_steps"], train_freq=1, gradient_steps=schedule["updates_per_step"],
        policy_kwargs=dict(net_arch=sac["hidden"]))
    curve, solved = [], None
    for steps in range(checks["every"], schedule["real_steps"] + 1, checks["every"]):
        model.learn(checks["every"], reset_num_timesteps=steps == checks["every"])
        mean = statistics.mean(returns(model, checks["episodes"], 100_000 * (seed + 1) + steps))
        curve.append([steps, mean])
        if mean >= checks["until"]:
            solved = steps
            break
    final = statistics.mean(returns(model, EPISODES, 100_000 * (seed + 1) + 50_000))
    return {"seed": seed, "solved_after": solved, "return": final, "curve": curve}


def ours(binary, tasks, seeds, work, jobs):
    """Settings and runs of our program, by task."""
    folder = work / "ours"
    subprocess.run([binary, "compare", "--tasks", ",".join(tasks), "--methods", "sac", "--seeds", str(seeds),
                    "--threads", str(jobs), "--out", str(folder)], check=True, stdout=subprocess.DEVNULL)
    found = {}
    for task in tasks:
        runs = folder / "runs" / task / "sac"
        settings = tomllib.loads((runs / "settings.toml").read_text())
        outcomes = [json.loads((runs / f"seed-{seed}.json").read_text()) for seed in range(seeds)]
        found[task] = settings, [{"seed": o["seed"], "solved_after": o["solved_after"],
                                  "return": statistics.mean(o["returns"])} for o in outcomes]
    return found


def theirs(task, seed, settings, work):
    """The peer's run in a process of its own, or what it left before."""
    path = work / "sb3" / task / f"seed-{seed}.json"
    wanted = json.dumps(settings, sort_keys=True)
    if path.exists():
        kept = json.loads(path.read_text())
        if kept["settings"] == wanted:
            return kept["run"]
    quiet = {**os.environ, "OMP_NUM_THREADS": "1"}
    text = subprocess.run([sys.executable, __file__, "--one", task, str(seed), wanted], check=True,
                          capture_output=True, text=True, env=quiet).stdout
    run = json.loads(text.splitlines()[-1])
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(".part")
    part.write_text(json.dumps({"settings": wanted, "run": run}))
    part.replace(path)
    print(f"sb3 {task} seed {seed}: {run['solved_after']}, {run['return']:.1f}", file=sys.stderr, flush=True)
    return run


def interval(a, b, of):
    """95 % of the bootstrap's values of `of`, a function of resampled runs of both."""
    draw = random.Random(0)
    values = sorted(of(draw.choices(a, k=len(a)), draw.choices(b, k=len(b))) for _ in range(RESAMPLES))
    return [values[int(0.025 * RESAMPLES)], values[int(0.975 * RESAMPLES) - 1]]


def median_steps(runs):
    return statistics.median([r["solved_after"] or float("inf") for r in runs])


def ratio(a, b):
    a, b = median_steps(a), median_steps(b)
    # Where both never solve it, neither needs more steps.
    return 1.0 if a == b else a / b


def finite(value):
    """The same with null for what never ends, which JSON cannot say."""
    if isinstance(value, dict):
        return {key: finite(v) for key, v in value.items()}
    if isinstance(value, list):
        return [finite(v) for v in value]
    return None if value in (float("inf"), float("-inf")) else value


def versions():
    from importlib.metadata import version
    return {name: version(name) for name in ("stable_baselines3", "gymnasium", "torch", "mujoco")}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--one", nargs=3, metavar=("TASK", "SEED", "SETTINGS"), help=argparse.SUPPRESS)
    parser.add_argument("--tasks", default=",".join(ENVIRONMENTS))
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--binary", default="target/release/sindyna")
    parser.add_argument("--work", type=Path, default=Path("runs/baselines"))
    parser.add_argument("--out", type=Path, default=Path("results/baselines.json"))
    args = parser.parse_args()
    if args.one:
        task, seed, settings = args.one
        print(json.dumps(peer(task, int(seed), json.loads(settings))))
        return
    result = json.loads(args.out.read_text()) if args.out.exists() else {"tasks": {}}
    result["versions"] = versions()
    found = ours(args.binary, args.tasks.split(","), args.seeds, args.work, args.jobs)
    made_by = tomllib.loads((args.work / "ours" / "compare.toml").read_text())
    for task, (settings, mine) in found.items():
        with ThreadPoolExecutor(args.jobs) as pool:
            peers = list(pool.map(lambda seed: theirs(task, seed, settings, args.work), range(args.seeds)))
        mean = lambda runs: statistics.mean(r["return"] for r in runs)
        result["tasks"][task] = {
            "command": f"benches/baselines.py --tasks {task} --seeds {args.seeds}", "made_by": made_by,
            "settings": settings, "sindyna": mine, "stable_baselines3": peers,
            "median_steps": [median_steps(mine), median_steps(peers)],
            "ratio_of_medians": ratio(mine, peers), "ratio_interval": interval(mine, peers, ratio),
            "mean_return": [mean(mine), mean(peers)],
            "return_difference_interval": interval(mine, peers, lambda a, b: mean(a) - mean(b)),
        }
        print(task, json.dumps({k: v for k, v in result["tasks"][task].items() if k[0] in "mr"}), flush=True)
        args.out.write_text(json.dumps(finite(result), indent=1) + "\n")


if __name__ == "__main__":
    main()
