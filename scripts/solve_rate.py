#!/usr/bin/env python3
"""Train every task with the defaults on several seeds and tabulate what came of it.

Runs `sindyna train TASK --seed S` one after the other, gathers summary.json and timing.json of each run, and writes
results/solve-rate.json (the figures, with version, commit and machine) and results/solve-rate.md (the table).

Usage: scripts/solve_rate.py [--tasks pendulum mountain-car inverted-pendulum cart-pole] [--seeds 0-9] [-- OPTIONS OF train]
Needs: cargo, nothing else.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent


def parse_seeds(text):
    first, _, last = text.partition("-")
    return range(int(first), int(last or first) + 1)


def train(binary, task, seed, options, folder):
    out = folder / f"{task}-{seed}"
    command = [binary, "train", task, "--seed", str(seed), "--out", out, "--quiet", *options]
    code = subprocess.run(command, stdout=subprocess.DEVNULL).returncode
    if code not in (0, 1):
        sys.exit(f"{task} seed {seed} ended with exit code {code}")
    summary = json.loads((out / "summary.json").read_text())
    timing = json.loads((out / "timing.json").read_text())
    evaluation = summary["evaluation"] or {"mean_return": None, "std_return": None}
    return {
        "task": task, "seed": seed, "solved": summary["solved"], "threshold": summary["threshold"],
        "mean_return": evaluation["mean_return"], "std_return": evaluation["std_return"],
        "model_return": summary["training"]["model_return"], "real_steps": summary["real_steps"],
        "real_episodes": summary["real_episodes"], "updates": summary["training"]["updates"],
        "converged": summary["training"]["converged"],
        "nonzero": (summary["identification"] or {}).get("nonzero"),
        "equations": (summary["identification"] or {}).get("equations"),
        "wall_seconds": timing["wall_seconds"], "machine": timing["machine"], "threads": timing["threads"],
    }


def table(runs):
    lines = [
        "| task | solved | real steps | resets | return, mean over seeds (lowest) | mark | updates, median | seconds, median (largest) |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for task in dict.fromkeys(r["task"] for r in runs):
        rows = [r for r in runs if r["task"] == task]
        returns = [r["mean_return"] for r in rows if r["mean_return"] is not None]
        returned = f"{statistics.mean(returns):.1f} ({min(returns):.1f})" if returns else "none"
        seconds = [r["wall_seconds"] for r in rows]
        lines.append(
            f"| {task} | {sum(bool(r['solved']) for r in rows)} of {len(rows)} | {max(r['real_steps'] for r in rows)} "
            f"| {min(r['real_episodes'] for r in rows)}–{max(r['real_episodes'] for r in rows)} | {returned} "
            f"| {rows[0]['threshold']} | {statistics.median(r['updates'] for r in rows):.0f} "
            f"| {statistics.median(seconds):.1f} ({max(seconds):.1f}) |"
        )
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tasks", nargs="+", default=["pendulum", "mountain-car", "inverted-pendulum", "cart-pole"])
    parser.add_argument("--seeds", type=parse_seeds, default=range(10), help="such as 0-9")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "results" / "solve-rate", help="stem of the two files")
    parser.add_argument("options", nargs="*", help="options passed on to `sindyna train`, after --")
    args = parser.parse_args()

    subprocess.run(["cargo", "build", "--release", "--quiet"], cwd=ROOT, check=True)
    metadata = subprocess.run(["cargo", "metadata", "--format-version=1", "--no-deps"], cwd=ROOT, check=True, capture_output=True)
    binary = pathlib.Path(json.loads(metadata.stdout)["target_directory"]) / "release" / "sindyna"
    commit = subprocess.run(["git", "rev-parse", "--short=12", "HEAD"], cwd=ROOT, capture_output=True, text=True).stdout.strip()
    runs = []
    with tempfile.TemporaryDirectory() as folder:
        for task in args.tasks:
            for seed in args.seeds:
                run = train(binary, task, seed, args.options, pathlib.Path(folder))
                runs.append(run)
                print(f"{task} seed {seed}: return {run['mean_return']}, solved {run['solved']}, "
                      f"{run['wall_seconds']:.1f} s", file=sys.stderr, flush=True)
    version = subprocess.run([binary, "--version"], capture_output=True, text=True).stdout.strip()
    document = {"version": version, "commit": commit, "options": args.options, "runs": runs}
    args.out.parent.mkdir(parents=True, exist_ok=True)
    args.out.with_suffix(".json").write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n")
    header = f"`scripts/solve_rate.py {' '.join(sys.argv[1:])}`".replace(" `", "`").replace(f"{ROOT}/", "")
    text = f"{header}, {version} ({commit}), {runs[0]['machine']}\n\n{table(runs)}"
    args.out.with_suffix(".md").write_text(text)
    print(text)


if __name__ == "__main__":
    main()
