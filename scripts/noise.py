#!/usr/bin/env python3
"""What sensor noise costs: equations, coefficients, regulators. Controllers trained in the equations are in scripts/loop.py.

For every task, noise level, number of real steps and seed, the program `noise` of crates/bench identifies the equations (and
lets linear-quadratic regulators act, where the task is to balance), without being told how noisy the sensors are and again told so. Writes
results/noise.json, docs/noise.md and docs/noise.svg. What was run before is taken from runs/noise; delete that folder after a
change of the identifier.

Usage: scripts/noise.py [--seeds 0-19] [--jobs 1] [--tasks cart-pole] [--noises 0.01] [--steps 100]
Needs: cargo, nothing else.
"""
import argparse
import json
import math
import sys

from figure import panels
from study import ROOT, TASKS, build, commit, each, lines, middle, number, parse_seeds, plain, rounded, short, table, worst

NOISES = [0.001, 0.01, 0.05]
STEPS = [100, 300, 1000]
BALANCED = ["cart-pole", "inverted-pendulum"]
RUNS = ROOT / "runs" / "noise"


def summary(rows, told):
    """What the seeds of one task, noise level and number of steps come to; `told` are those of an identifier told the noise."""
    fitted = [r for r in rows if "refused" not in r]
    first = rows[0]
    scores = [abs(z) for r in fitted for z in r["standardised_errors"]]
    errors = [e for r in fitted for e in r["relative_errors"]]

    def deviations(name, key):
        return rounded(middle(number(r[name][key]) if r.get(name) else math.inf for r in rows))

    group = {
        "task": first["system"], "noise": first["noise"], "steps": first["steps"], "seeds": len(rows),
        "refused": len(rows) - len(fitted), "true_terms": sum(r["true_terms"] for r in fitted),
        "true_terms_shown": sum(r["true_terms_shown"] for r in fitted),
        "resets": middle(r["resets"] for r in rows),
        "median_relative_error": rounded(middle(errors)),
        "largest_relative_error": rounded(max(errors, default=math.inf)),
        "standard_errors_within_2": rounded(sum(z <= 2 for z in scores) / len(scores)) if scores else None,
        "worst_deviation": {name: deviations(name, "worst") for name in ("deviation", "stlsq", "stlsq_best")},
        "rms_deviation": {name: deviations(name, "rms") for name in ("deviation", "stlsq", "stlsq_best")},
        "told": {"true_terms": sum(r.get("true_terms", False) for r in told),
                 "rms_deviation": rounded(middle(number(r["deviation"]["rms"]) if r.get("deviation") else math.inf for r in told)),
                 "seconds": rounded(middle(r["seconds"] for r in told if "seconds" in r))},
        "largest_worst_deviation": rounded(max(worst(r.get("deviation")) for r in rows)),
        "seconds": {"median": rounded(middle(r["seconds"] for r in fitted)),
                    "largest": rounded(max((r["seconds"] for r in fitted), default=math.inf))},
    }
    if "regulators" in first:
        names = ("least_squares", "identified", "true_system")
        group["regulators"] = {
            name: {"median_return": kept(middle(number_or_zero(r["regulators"][name]) for r in rows)),
                   "lowest_return": kept(min(number_or_zero(r["regulators"][name]) for r in rows)),
                   "none": sum(r["regulators"][name] is None for r in rows)} for name in names}
    return group


def kept(value):
    """A return to two decimals; None for what is not finite."""
    return round(value, 2) if value is not None and math.isfinite(value) else None


def number_or_zero(value):
    """A regulator there is none of earns nothing."""
    return 0.0 if value is None else value


def page(groups, command, stem):
    """The page of tables, with the names of its files."""
    percent = lambda g: f"{100 * g['noise']:g} %"
    head = ["task", "noise", "real steps"]
    key = lambda g: [g["task"], percent(g), g["steps"]]
    text = [
        "# Under noise",
        "",
        f"Written by `{command}` from `results/{stem}.json`, {groups[0]['seeds']} seed{'s' * (groups[0]['seeds'] > 1)} a row."
        " Noise is Gaussian, independent from step to step, on every observation of the system, in training and in"
        " evaluation; its standard deviation is the given part of each channel's scale. Real steps are those of the default warm-up.",
    ]
    text += [
        "", "## Equations", "",
        f"![Error of the accelerations against real steps]({stem}.svg)", "",
        *table([*head, "true terms (shown)", "told σ", "coefficients' relative error, median (largest)", "within 2 standard errors",
                "accelerations' error, rms (worst)", "told σ, rms", "STLSQ", "STLSQ, best threshold", "fit [s], median (largest)"],
               [[*key(g), f"{g['true_terms']} ({g['true_terms_shown']}) of {g['seeds']}", g["told"]["true_terms"],
                 f"{short(g['median_relative_error'])} ({short(g['largest_relative_error'])})",
                 short(g["standard_errors_within_2"]),
                 *(cell for n in ("deviation", "stlsq", "stlsq_best") for cell in
                   [f"{short(g['rms_deviation'][n])} ({short(g['worst_deviation'][n])})"]
                   + ([short(g["told"]["rms_deviation"])] if n == "deviation" else [])),
                 f"{short(g['seconds']['median'])} ({short(g['seconds']['largest'])})"] for g in groups]),
        "",
        "The size of the noise is estimated; in the columns *told σ* the identifier knows it.",
        "",
        "Errors of accelerations (velocity increments for mountain-car) are over 10,000 states and inputs from the task's box, as"
        " parts of the true ones' standard deviation there; medians over seeds. Coefficients are compared where the terms are"
        " the true ones. *STLSQ*: the same candidate terms with the paper's threshold, on increments; *best threshold*: the"
        " nearest to the truth of 11 thresholds, on increments and on central differences, which only who knows the truth can choose.",
    ]
    regulated = [g for g in groups if "regulators" in g]
    if regulated:
        cell = lambda g, name: (lambda r: f"{plain(r['median_return'])} ({plain(r['lowest_return'])})")(g["regulators"][name])
        text += [
            "", "## Least squares and a regulator, on the same data", "",
            *table([*head, "least squares + LQR", "our equations + LQR", "true system + LQR"],
                   [[*key(g), *(cell(g, name) for name in ("least_squares", "identified", "true_system"))] for g in regulated]),
            "", "Mean return of 20 episodes on the noisy true system: median (lowest) over seeds; where there is no"
            " regulator, 0. Least squares is x⁺ = x + Δt (A x + B u). The regulators weigh every channel by its scale and act on"
            " the noisy observation as it is.",
        ]
    return "\n".join(text) + "\n"


def chart(groups, noises, steps):
    """RMS errors of the accelerations against the number of steps."""
    charts = {}
    for task in dict.fromkeys(g["task"] for g in groups):
        at = {(g["noise"], g["steps"]): g["rms_deviation"] for g in groups if g["task"] == task}
        charts[task] = {f"{100 * noise:g} %": [at[noise, r]["deviation"] for r in steps] for noise in noises}
        charts[task][f"STLSQ, best threshold, {100 * noises[0]:g} %"] = [at[noises[0], r]["stlsq_best"] for r in steps]
    return panels(charts, steps, "real steps", "error of accelerations", (1e-4, 10.0), logarithmic=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=parse_seeds, default=range(20), help="such as 0-19")
    parser.add_argument("--jobs", type=int, default=1, help="programs at a time")
    parser.add_argument("--tasks", nargs="+", default=TASKS)
    parser.add_argument("--noises", nargs="+", type=float, default=NOISES)
    parser.add_argument("--steps", nargs="+", type=int, default=STEPS)
    parser.add_argument("--out", default="noise", help="stem of the files in results and docs")
    args = parser.parse_args()
    folder = build("sindyna-bench")

    def identified(task, noise, steps, seed):
        arguments = [task, f"{noise:g}", steps, seed, seed, *(["--regulate"] if task in BALANCED else [])]
        return lines(folder / "noise", arguments, RUNS / f"{task}-{noise:g}-{steps}-{seed}.jsonl")[0]

    def identified_told(task, noise, steps, seed):
        arguments = [task, f"{noise:g}", steps, seed, seed, "--declared"]
        return lines(folder / "noise", arguments, RUNS / "told" / f"{task}-{noise:g}-{steps}-{seed}.jsonl")[0]

    cases = [(t, f, r, s) for t in args.tasks for f in args.noises for r in args.steps for s in args.seeds]
    found = dict(zip(cases, each(args.jobs, identified, cases)))
    told = dict(zip(cases, each(args.jobs, identified_told, cases)))
    groups = []
    for t in args.tasks:
        for f in args.noises:
            for r in args.steps:
                of = lambda records, *key: [records[t, *key, s] for s in args.seeds if (t, *key, s) in records]
                groups.append(summary(of(found, f, r), of(told, f, r)))
    command = " ".join(["scripts/noise.py", *sys.argv[1:]])
    document = {"command": command, "commit": commit(), "groups": groups}
    (ROOT / "results" / f"{args.out}.json").write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n")
    (ROOT / "docs" / f"{args.out}.md").write_text(page(groups, command, args.out))
    (ROOT / "docs" / f"{args.out}.svg").write_text(chart(groups, args.noises, args.steps))


if __name__ == "__main__":
    main()
