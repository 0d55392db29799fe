#!/usr/bin/env python3
"""Controllers under noise that nobody declares: how often a task is solved, how many real steps it takes, and whether the prediction holds.

Runs `sindyna train TASK --noise F --real-steps R --seed S` with the defaults for every task, noise, number of first real steps and seed.
Writes results/loop.json and docs/loop.md. What was run before is taken from runs/loop; delete that folder after a change of the
identifier or the trainer.

Usage: scripts/loop.py [--seeds 0-19] [--jobs 1] [--tasks cart-pole] [--noises 0 0.001] [--steps 10 100] [--out loop] [-- OPTIONS OF train]
Needs: cargo, nothing else.
"""
import argparse
import json
import pathlib
import shutil
import subprocess
import sys

from study import ROOT, TASKS, build, commit, each, middle, parse_seeds, plain, rounded, short, table

FIVE = [*TASKS, "cart-pole-swing-up"]
NOISES = [0.0, 0.001, 0.01, 0.05]
STEPS = [10, 100, 300, 1000]
RUNS = ROOT / "runs" / "loop"


def name(task):
    """What a task is called, where it is a task file: by that."""
    return pathlib.Path(task).stem


def train(program, task, noise, steps, seed, options):
    """What came of a training run, from its record if it was run before."""
    out = RUNS / f"{name(task)}-{noise:g}-{steps}-{seed}"
    path = out / "summary.json"
    if not path.exists() or json.loads(path.read_text())["interrupted"]:
        shutil.rmtree(out, ignore_errors=True)
        command = [program, "train", *(["--task-file", task] if task.endswith(".toml") else [task]), "--noise", f"{noise:g}", "--real-steps", steps, "--seed", seed, "--out", out,
                   "--quiet", "--threads", "1", *options]
        done = subprocess.run(list(map(str, command)), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        print(f"{out.name}: exit code {done.returncode}", file=sys.stderr, flush=True)
        if done.returncode not in (0, 1):
            return {"refused": done.stderr.strip().splitlines()[0] if done.stderr.strip() else "no reason was given"}
    record = json.loads(path.read_text())
    evaluation, training = record["evaluation"] or {}, record["training"]
    prediction, confirmation = training["prediction"], training["confirmation"]
    earned = evaluation.get("mean_return")
    return {
        "seed": seed, "return": earned, "solved": record["solved"], "threshold": record["threshold"],
        "real_steps": record["real_steps"], "real_episodes": record["real_episodes"], "updates": training["updates"],
        "prediction": prediction and [prediction["mean"], prediction["low"], prediction["high"]],
        "held": prediction is not None and prediction["low"] - 1e-9 <= earned <= prediction["high"] + 1e-9,
        "kept": confirmation and confirmation["kept"],
        "seconds": json.loads((out / "timing.json").read_text())["wall_seconds"],
    }


def warned(run):
    """Whether the run said beforehand that the task may not be solved: its interval reaches below the threshold, or a promise was broken."""
    return run.get("prediction") is None or run["threshold"] is None or run["prediction"][1] < run["threshold"] or run["kept"] is False


def summary(task, noise, steps, runs):
    done = [r for r in runs if "refused" not in r]
    # Task files without `solved_at` have nothing to fail at.
    failed = [r for r in done if r["solved"] is False or r["return"] is None]
    returns = [r["return"] for r in done if r["return"] is not None]
    predicted = [r for r in done if r["prediction"]]
    return {
        "task": name(task), "noise": noise, "steps": steps, "seeds": len(runs), "refused": len(runs) - len(done),
        "solved": sum(bool(r["solved"]) for r in done), "target": any(r["threshold"] is not None for r in done),
        "failed_without_a_word": [r["seed"] for r in failed if not warned(r)],
        "failed": [r["seed"] for r in failed],
        "median_return": rounded(middle(returns)), "lowest_return": rounded(min(returns, default=float("inf"))),
        "real_steps": {"median": middle(r["real_steps"] for r in done), "most": max((r["real_steps"] for r in done), default=None)},
        "real_episodes": {"median": middle(r["real_episodes"] for r in done), "most": max((r["real_episodes"] for r in done), default=None)},
        "predicted": len(predicted), "held": sum(r["held"] for r in predicted),
        "promises": sum(r["kept"] is not None for r in done), "kept": sum(bool(r["kept"]) for r in done),
        "median_updates": middle(r["updates"] for r in done), "median_seconds": rounded(middle(r["seconds"] for r in done)),
        "runs": [{k: v for k, v in r.items() if k not in ("threshold", "seconds")} for r in runs],
    }


def page(document):
    """docs/loop.md."""
    groups = document["groups"]
    predicted, held = (sum(g[k] for g in groups) for k in ("predicted", "held"))
    failed, silent = sum(len(g["failed"]) for g in groups), sum(len(g["failed_without_a_word"]) for g in groups)
    rows = [[g["task"], f"{100 * g['noise']:g} %" if g["noise"] else "none", g["steps"], f"**{g['solved']}** of {g['seeds']}" if g.get("target", True) else f"{g['seeds'] - g['refused']} of {g['seeds']} ended",
             f"{plain(g['median_return'])} ({plain(g['lowest_return'])})",
             f"{g['real_steps']['median']:g} ({g['real_steps']['most']})",
             f"{g['real_episodes']['median']:g} ({g['real_episodes']['most']})",
             f"{g['held']} of {g['predicted']}", short(g["median_seconds"])] for g in groups]
    return "\n".join([
        "# Controllers under noise", "",
        f"Written by `{document['command']}` from `results/{document['stem']}.json`, with commit {document['commit']}. Noise is Gaussian, independent from"
        " step to step, on every observation of the system, in training and in evaluation; its standard deviation is the given part of each channel's scale. The"
        " learner is told neither this nor the scales nor what return counts as solved. Defaults throughout: where equations explain the data down to"
        " rounding, the system is not asked again; from 40 first steps on half of them, and all that is collected later, is what the models that the data allow disagree on; where something speaks against them, as many steps are collected again, and a policy that is optimal in"
        " the model has a real episode to confirm it. *Real steps* and *episodes* count all of that, before the evaluation of 100 episodes.", "",
        f"The 90 % interval of the return that is predicted before the evaluation holds it in **{held} of {predicted}** runs"
        f" ({100 * held / max(predicted, 1):.0f} %). Of {failed} runs that did not solve their task {failed - silent} had said that they may not: the interval reached"
        " below the threshold, or a real episode had broken the promise.", "",
        *table(["task", "noise", "first real steps", "solved", "return, median (lowest)", "real steps, median (most)", "episodes", "interval holds", "seconds, median"], rows),
        "",
        "*Seconds* are wall-clock times of one thread, on a machine that did other work as well.", *document.get("notes", []),
    ]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=parse_seeds, default=range(20), help="such as 0-19")
    parser.add_argument("--jobs", type=int, default=1, help="programs at a time")
    parser.add_argument("--tasks", nargs="+", default=FIVE)
    parser.add_argument("--noises", nargs="+", type=float, default=NOISES)
    parser.add_argument("--steps", nargs="+", type=int, default=STEPS)
    parser.add_argument("--out", default="loop", help="stem of the files in results and docs")
    parser.add_argument("options", nargs="*", help="options passed on to `sindyna train`, after --")
    args = parser.parse_args()
    program = build("sindyna") / "sindyna"
    # Without noise nothing is gained by more steps than ten.
    cells = [(t, f, r) for t in args.tasks for f in args.noises for r in args.steps if f > 0 or r == min(args.steps)]
    cases = [(*cell, s) for cell in cells for s in args.seeds]
    done = dict(zip(cases, each(args.jobs, lambda *case: train(program, *case, args.options), cases)))
    groups = [summary(*cell, [done[*cell, s] for s in args.seeds]) for cell in cells]
    command = " ".join(["scripts/loop.py", *sys.argv[1:]])
    document = {"command": command, "commit": commit(), "stem": args.out, "options": args.options, "groups": groups}
    (ROOT / "results" / f"{args.out}.json").write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n")
    (ROOT / "docs" / f"{args.out}.md").write_text(page(document))


if __name__ == "__main__":
    main()
