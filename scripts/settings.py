#!/usr/bin/env python3
"""How many updates, and how much processor time, settings of training need to reach the mark in the model.

Runs `sindyna train TASK` with the stopping rule taken out and a trial every 250 updates, for every variant and seed, one
after the other on one thread, and prints a table: updates until the first trial at or above the mark, until the first of
three in a row, and processor milliseconds until the first. Processor time is that of the whole run, identification
included, shared among its updates.

Usage: scripts/settings.py [--tasks ...] [--seeds 1000-1007] [--updates 4000] VARIANT...
A variant is settings of config.toml with spaces between, such as "sac.batch_size=256 sac.polyak=0.005"; "" is the defaults.
Needs: cargo, nothing else. Seeds below 1000 are left for judging, not for choosing.
"""
import argparse
import json
import math
import pathlib
import resource
import statistics
import subprocess
import tempfile

from study import TASKS, build, parse_seeds, table

NO_STOP = ["--set", "optimality.trial_every=250", "--set", "optimality.patience=1000000"]


def run(binary, task, seed, updates, settings):
    """The trials (updates, mean return), the mark, and processor seconds per update."""
    options = [word for setting in settings for word in ("--set", setting)]
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "run"
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        subprocess.run([binary, "train", task, "--seed", str(seed), "--threads", "1", "--quiet", "--out", out,
                        "--max-updates", str(updates), *NO_STOP, *options], stdout=subprocess.DEVNULL)
        seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
        events = [json.loads(line) for line in (out / "events.jsonl").read_text().splitlines()]
        mark = json.loads((out / "summary.json").read_text())["threshold"]
    trials = [(e["updates"], e["model_return"]) for e in events if e["event"] == "trial"]
    return trials, mark, seconds / trials[-1][0]


def reached(trials, mark, in_a_row):
    """Updates at the first of so many trials in a row that reach the mark."""
    for i in range(len(trials) - in_a_row + 1):
        if all(value >= mark for _, value in trials[i:i + in_a_row]):
            return trials[i][0]
    return math.inf


def shown(values):
    return f"{statistics.median(values):.0f} ({max(values):.0f})"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tasks", nargs="+", default=TASKS)
    parser.add_argument("--seeds", type=parse_seeds, default=range(1000, 1008), help="such as 1000-1007")
    parser.add_argument("--updates", type=int, default=4000, help="of every run")
    parser.add_argument("variants", nargs="+")
    args = parser.parse_args()
    binary = build("sindyna") / "sindyna"
    rows = []
    for variant in args.variants:
        for task in args.tasks:
            runs = [run(binary, task, seed, args.updates, variant.split()) for seed in args.seeds]
            first = [reached(trials, mark, 1) for trials, mark, _ in runs]
            each = 1e3 * statistics.mean(seconds for *_, seconds in runs)
            rows.append([f"`{variant}`" if variant else "defaults", task, shown(first),
                         shown([reached(trials, mark, 3) for trials, mark, _ in runs]),
                         f"{each * statistics.median(first):.0f}",
                         f"{statistics.mean(max(value for _, value in trials) for trials, *_ in runs):.1f}"])
    print("\n".join(table(["settings", "task", "updates to the mark, median (most)", "to three in a row",
                           "processor ms to the mark", "best return, mean"], rows)))


if __name__ == "__main__":
    main()
