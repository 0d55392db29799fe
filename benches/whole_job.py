#!/usr/bin/env python3
"""The whole job, sindyna train against pipeline.py with Stable-Baselines3 and with SBX, until the task is solved.

One core each, in turn: ours, a peer, ours, the other peer, for every seed. Ours is the whole process, from its start to its
end, with an evaluation of 100 real episodes; a peer's seconds leave out its imports and its evaluations on the real system,
and end at the first of those evaluations (10 episodes) at or above the threshold. A peer that takes longer than --cap counts
as infinite (as the cap in ratios), a run of ours that does not solve as well. The bar is judged against the peer with the lesser median.
On cart-pole, which has numbered actions, the peers are PPO; DQN (pipeline.py --backend sb3-dqn) took longer when tried.

At equal networks: ours again, once per seed, with the peer's hidden layers and batch size and all else as it is.
Writes results/whole-job.json. Seeds that were run before are taken from runs/whole-job; delete that folder after a change.

Usage: .venv-peers/bin/python benches/whole_job.py [--tasks ...] [--seeds 0-4] [--cap 45] [--core 1]
(scripts/peers_install makes .venv-peers)
"""
import argparse
import json
import math
import pathlib
import statistics
import sys
import tempfile

from alternate import ROOT, build, digits, json_lines, run, say, summary, write

BACKENDS = ["sb3", "sbx"]
# What the peers learn with: hidden layers and batch of pipeline.py's agents.
SIZES = {"pendulum": ([256, 256], 256), "mountain-car": ([64, 64], 512), "inverted-pendulum": ([256, 256], 256),
         "cart-pole": ([64, 64], 256)}


def seeds_of(text):
    first, _, last = text.partition("-")
    return range(int(first), int(last or first) + 1)


def ours(binary, task, seed, core, options=()):
    """Seconds of the process, infinite if the real system was not solved; and what the record says."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "run"
        _, seconds = run([binary, "train", task, "--seed", seed, "--threads", 1, "--quiet", "--out", out, *options], core)
        record = json.loads((out / "summary.json").read_text())
        timing = json.loads((out / "timing.json").read_text())
    return {"seconds": seconds if record["solved"] else math.inf, "updates": record["training"]["updates"],
            "mean_return": record["evaluation"]["mean_return"],
            **{part: timing[f"{part}_seconds"] for part in ("identify", "train", "evaluate")}}


def peer(backend, task, seed, core, cap):
    """Seconds until the first evaluation at or above the threshold; infinite if there was none within `cap`."""
    script = ROOT / "benches" / "pipeline.py"
    lines = json_lines(run([sys.executable, script, task, "--seed", seed, "--backend", backend, "--seconds", cap], core)[0])
    last = lines[-1]
    return last["wall_s"] if last.get("solved") else math.inf


def median(values):
    return statistics.median(values)


def described(values, cap):
    """Median and range of seconds; what was not solved is null, `more_than` the cap."""
    solved = [v for v in values if math.isfinite(v)]
    return {"median": digits(median(values)), "least": digits(min(values)), "largest": digits(max(values)),
            "solved": len(solved), "runs": len(values), "more_than": cap if len(solved) < len(values) else None}


def one_seed(binary, task, seed, cap, core):
    """All runs of a seed, in turn."""
    path = ROOT / "runs" / "whole-job" / f"{task}-{seed}.json"
    if path.exists():
        return json.loads(path.read_text())
    hidden, batch = SIZES[task]
    runs = {"ours": [], "peers": {}}
    for backend in BACKENDS:
        runs["ours"].append(ours(binary, task, seed, core))
        runs["peers"][backend] = peer(backend, task, seed, core, cap)
    runs["equal"] = ours(binary, task, seed, core, ["--set", f"sac.hidden={hidden}", "--batch-size", batch])
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(runs))
    say(f"{task} seed {seed}: ours {[round(o['seconds'], 2) for o in runs['ours']]}, at equal networks "
        f"{runs['equal']['seconds']:.2f}, " + ", ".join(f"{b} {t:.1f}" for b, t in runs["peers"].items()))
    return runs


def measure(binary, task, seeds, cap, core):
    runs = [one_seed(binary, task, seed, cap, core) for seed in seeds]
    own, equal = [o for r in runs for o in r["ours"]], [r["equal"] for r in runs]
    theirs = {backend: [r["peers"][backend] for r in runs] for backend in BACKENDS}
    better = min(theirs, key=lambda backend: (median(theirs[backend]), sum(min(t, cap) for t in theirs[backend])))
    hidden, batch = SIZES[task]
    seconds, equal_seconds = [o["seconds"] for o in own], [o["seconds"] for o in equal]

    def ratio(mine):
        """Over seeds, each of runs that were neighbours: what else the machine does differs more than seeds do."""
        return summary([min(peer, cap) / own for peer, own in zip(theirs[better], mine)])

    place = BACKENDS.index(better)
    return {
        "task": task, "ours": described(seconds, None), "peers": {b: described(t, cap) for b, t in theirs.items()},
        "better_peer": better, "ratio": ratio([r["ours"][place]["seconds"] for r in runs]), "ratio_is_at_least": not math.isfinite(median(theirs[better])),
        "parts_of_ours": {part: summary([o[part] for o in own]) for part in ("identify", "train", "evaluate")},
        "updates_of_ours": summary([o["updates"] for o in own]),
        "mean_returns_of_ours": [digits(r["ours"][0]["mean_return"]) for r in runs],
        "equal": {"hidden": hidden, "batch": batch, **described(equal_seconds, None), "ratio": ratio(equal_seconds),
                  "updates": summary([o["updates"] for o in equal])},
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tasks", nargs="+", choices=SIZES, default=list(SIZES))
    parser.add_argument("--seeds", type=seeds_of, default=range(5), help="such as 0-4")
    parser.add_argument("--cap", type=float, default=45.0, help="seconds after which a peer is given up")
    parser.add_argument("--core", type=int, default=1)
    args = parser.parse_args()
    binary = build() / "sindyna"
    tasks = [measure(binary, task, args.seeds, args.cap, args.core) for task in args.tasks]
    write("whole-job.json", {"command": "benches/whole_job.py " + " ".join(sys.argv[1:]), "cap_seconds": args.cap,
                             "tasks": tasks})


if __name__ == "__main__":
    main()
