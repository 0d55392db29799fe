#!/usr/bin/env python3
"""The whole job by two builds of sindyna, run in turn: is the newer one slower?

Runs `train TASK --seed S --threads 1` with both for every task and seed and compares CPU seconds of the process, which hold all of a run (steps, identification, training, evaluation of
100 episodes) and which other work on the machine disturbs little. Ratios are of neighbours in time. Writes results/paired-jobs.json.

Usage: benches/paired_jobs.py OLDER NEWER [--commits OLDER NEWER] [--seeds 100-119] [--tasks pendulum ...]
Needs: nothing but the two programs.
"""
import argparse
import resource
import subprocess
import tempfile

from alternate import digits, ratios, say, summary, write

TASKS = ["pendulum", "mountain-car", "inverted-pendulum", "cart-pole", "cart-pole-swing-up"]


def cpu():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def job(program, task, seed):
    """CPU seconds of a run, and whether it solved the task."""
    with tempfile.TemporaryDirectory() as folder:
        before = cpu()
        command = [program, "train", task, "--seed", str(seed), "--threads", "1", "--quiet", "--out", f"{folder}/run"]
        done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return cpu() - before, done.returncode == 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("older")
    parser.add_argument("newer")
    parser.add_argument("--commits", nargs=2, help="what the two programs were built from")
    parser.add_argument("--tasks", nargs="+", default=TASKS)
    parser.add_argument("--seeds", default="100-119")
    args = parser.parse_args()
    first, _, last = args.seeds.partition("-")
    tasks = {}
    for task in args.tasks:
        pairs = [(job(args.older, task, s), job(args.newer, task, s)) for s in range(int(first), int(last or first) + 1)]
        older, newer = ([pair[i][0] for pair in pairs] for i in (0, 1))
        tasks[task] = {"solved": [sum(pair[i][1] for pair in pairs) for i in (0, 1)], "older": summary(older), "newer": summary(newer),
                       "sums": [digits(sum(older)), digits(sum(newer))], "newer_over_older": ratios(newer, older)}
        say(f"{task}: {tasks[task]}")
    write("paired-jobs.json", {"seeds": args.seeds, "commits": args.commits, "cpu_seconds": tasks})


if __name__ == "__main__":
    main()
