#!/usr/bin/env python3
"""The whole job by two builds of sindyna, run in turn: is the newer one slower?

Runs `train TASK --seed S --threads 1` with both, one after the other, for every task and seed, and compares CPU seconds of the process (which hold all of a run: steps, identification,
training, evaluation of 100 episodes), which other work on the machine disturbs little. Ratios are of neighbours in time. Writes results/paired-jobs.json.

Usage: benches/paired_jobs.py OLDER NEWER [--seeds 100-119] [--tasks pendulum ...]
Needs: nothing but the two programs.
"""
import argparse
import json
import pathlib
import resource
import statistics
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
TASKS = ["pendulum", "mountain-car", "inverted-pendulum", "cart-pole", "cart-pole-swing-up"]


def seconds(program, task, seed):
    """CPU seconds of a run, and whether it solved the task."""
    with tempfile.TemporaryDirectory() as folder:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        command = [program, "train", task, "--seed", str(seed), "--threads", "1", "--quiet", "--out", f"{folder}/run"]
        code = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, code == 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("older")
    parser.add_argument("newer")
    parser.add_argument("--tasks", nargs="+", default=TASKS)
    parser.add_argument("--seeds", default="100-119")
    args = parser.parse_args()
    first, _, last = args.seeds.partition("-")
    versions = [subprocess.run([p, "--version"], capture_output=True, text=True).stdout.strip() for p in (args.older, args.newer)]
    tasks = []
    for task in args.tasks:
        runs = [(seconds(args.older, task, s), seconds(args.newer, task, s)) for s in range(int(first), int(last or first) + 1)]
        ratios = [new / old for (old, _), (new, _) in runs]
        olds, news = ([pair[i][0] for pair in runs] for i in (0, 1))
        tasks.append({"task": task, "seeds": len(runs), "solved": [sum(pair[i][1] for pair in runs) for i in (0, 1)],
                      "median_seconds": [round(statistics.median(olds), 3), round(statistics.median(news), 3)],
                      "sum_seconds": [round(sum(olds), 2), round(sum(news), 2)],
                      "ratio_median": round(statistics.median(ratios), 3), "ratios": [round(r, 3) for r in sorted(ratios)]})
        print(json.dumps({k: v for k, v in tasks[-1].items() if k != "ratios"}), flush=True)
    document = {"command": "benches/paired_jobs.py OLDER NEWER", "versions": versions, "seeds": args.seeds, "tasks": tasks}
    (ROOT / "results" / "paired-jobs.json").write_text(json.dumps(document, indent=1) + "\n")


if __name__ == "__main__":
    main()
