#!/usr/bin/env python3
"""What `train` does with its time, by a sampling profile of the whole process on one thread. Writes results/parts.json.

Usage: benches/parts.py [--seeds 5] [--core 1]
Needs: cargo, and Linux's perf.
"""
import argparse
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile

from alternate import ONE_THREAD, ROOT, build, digits, pinned, say, write

TASKS = ["pendulum", "mountain-car", "cart-pole", "inverted-pendulum"]

# The first that matches a symbol has its samples.
PARTS = {
    "products of updates": r"sindyna_rl::kernel",
    "drawing batches": r"replay::Replay::sample",
    "model": r"sindyna_sindy|dynamics::Held|_(sin|cos|sincos|tan)_fma",
    "true system and sensors": r"sindyna_envs|Sensors|Simulated|Imagined|Bounded|Region",
    "loops over networks' numbers": r"vectorize",
    "the rest of updates": r"sindyna_rl::",
}


def shares(binary, task, seed, core, folder):
    data = pathlib.Path(folder) / "perf.data"
    train = [binary, "train", task, "--quiet", "--threads", "1", "--seed", str(seed), "--out", pathlib.Path(folder) / f"{task}-{seed}"]
    subprocess.run(pinned(["perf", "record", "-q", "-F", "5000", "-o", data, *train], core), cwd=ROOT, env=os.environ | ONE_THREAD,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    report = subprocess.run(["perf", "report", "-i", data, "--no-children", "--stdio", "-s", "symbol"], capture_output=True,
                            text=True, check=True).stdout
    found = dict.fromkeys([*PARTS, "other"], 0.0)
    for percent, symbol in re.findall(r"^\s*([\d.]+)%\s+\[.\]\s+(.+?)\s*$", report, re.M):
        part = next((part for part, pattern in PARTS.items() if re.search(pattern, symbol)), "other")
        found[part] += float(percent) / 100
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--core", type=int, default=1)
    args = parser.parse_args()
    binary = build() / "sindyna"
    tasks = []
    with tempfile.TemporaryDirectory() as folder:
        for task in TASKS:
            runs = [shares(binary, task, seed, args.core, folder) for seed in range(args.seeds)]
            tasks.append({"task": task, "shares": {part: digits(statistics.median(run[part] for run in runs)) for part in runs[0]}})
            say(tasks[-1])
    write("parts.json", {"command": "benches/parts.py " + " ".join(sys.argv[1:]), "seeds": args.seeds, "tasks": tasks})


if __name__ == "__main__":
    main()
