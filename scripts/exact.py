#!/usr/bin/env python3
"""How often the equations found are the true ones, from clean data.

Runs the program `exact` of crates/bench for every task and number of real steps, and for other systems, and writes
results/exact.json, docs/exact.md and docs/exact.svg. What was run before is taken from runs/exact; delete that folder after a
change of the identifier.

Usage: scripts/exact.py [--seeds 0-99] [--other-seeds 0-4] [--other-steps 100 200] [--jobs 1]
Needs: cargo, nothing else.
"""
import argparse
import json
import math
import sys

from figure import panels
from study import ROOT, TASKS, build, commit, each, lines, middle, number, parse_seeds, rounded, short, table, worst

STEPS = [5, 6, 8, 10, 15, 20, 30, 50]
BAR = 10
OTHERS = ["cart-pole-swing-up", "driven-pendulum", "van-der-pol", "lorenz", "lotka-volterra", "two-link-arm",
          "rotary-pendulum"]
OTHER_STEPS = [100, 200]
EXACT = 1e-4


def summary(rows):
    """What the rows of one system and number of steps come to."""
    fitted = [r for r in rows if "refused" not in r]
    is_exact = {r["seed"]: worst(r.get("deviation")) < EXACT for r in rows}
    scores = [abs(z) for r in fitted for z in r["standardised_errors"]]
    errors = [e for r in fitted for e in r["relative_errors"]]
    seconds = [r["seconds"] for r in fitted]
    rival = {}
    for name in ("stlsq", "stlsq_best"):
        deviations = [worst(r[name]) for r in rows]
        rival[name] = {"exact": sum(d < EXACT for d in deviations), "median_deviation": rounded(middle(deviations))}
    failed = [r for r in fitted if not is_exact[r["seed"]]]
    return {
        "system": rows[0]["system"], "steps": rows[0]["steps"], "seeds": len(rows),
        "exact": sum(is_exact.values()),
        "true_terms": sum(r["true_terms"] for r in fitted),
        "true_terms_shown": sum(r["true_terms_shown"] for r in fitted),
        "refused": len(rows) - len(fitted),
        "not_exact_and_said_so": sum(not r["explained"] for r in failed),
        "not_exact_and_not_said": sum(r["explained"] for r in failed),
        "resets": {"median": middle(r["resets"] for r in rows), "largest": max(r["resets"] for r in rows)},
        "deviation": {"median": rounded(middle(worst(r["deviation"]) for r in fitted)),
                      "largest": rounded(max((worst(r["deviation"]) for r in fitted), default=math.inf))},
        "coefficients": {"median_relative_error": rounded(middle(errors)),
                         "largest_relative_error": rounded(max(errors, default=math.inf))},
        "standardised_errors": {"count": len(scores), "median": rounded(middle(scores)),
                                **{f"within_{k}": rounded(sum(z <= k for z in scores) / len(scores)) if scores else None
                                   for k in (1, 2, 3)}},
        "seconds": {"median": rounded(middle(seconds)), "largest": rounded(max(seconds, default=math.inf))},
        **rival,
        "examples_not_exact": [
            {"seed": r["seed"], "deviation": rounded(worst(r["deviation"])), "explained": r["explained"],
             "equations": r["equations"]} for r in failed[:2]],
    }


def of(group, count):
    return f"{count} of {group['seeds']}"


def page(groups, command):
    """docs/exact.md."""
    tasks = [g for g in groups if g["system"] in TASKS]
    others = [g for g in groups if g["system"] in OTHERS]
    bar = [g for g in tasks if g["steps"] == BAR]
    text = [
        "# Exact equations from ten steps",
        "",
        f"Written by `{command}` from `results/exact.json`. Every row is `Identifier::new(&spec).identify(&data)` with nothing"
        " set, on data of the default warm-up (`Swings`), which are those of `sindyna train TASK --seed S`.",
        "",
        "*Exact*: over 10,000 states and inputs drawn from the task's box (declared bounds, else the channels' scales), the"
        " model's accelerations (velocity increments for mountain-car) differ from the true ones by less than 1e-4 of their"
        " standard deviation there, in every equation and on every point. *True terms*: the true rates satisfy the equations found with"
        " one set of coefficients, none of them zero; in brackets, how often true terms are at least among the sets the report"
        " shows. Implicit equations of motion can be written in several ways, and each counts.",
        "",
        f"## {BAR} real steps",
        "",
        *table(["task", "exact", "true terms (shown)", "deviation, median (largest)", "resets, median (most)",
                "fit [ms], median (largest)"],
               [[g["system"], of(g, g["exact"]), f"{g['true_terms']} ({g['true_terms_shown']})",
                 f"{short(g['deviation']['median'])} ({short(g['deviation']['largest'])})",
                 f"{g['resets']['median']:g} ({g['resets']['largest']})",
                 f"{1e3 * number(g['seconds']['median']):.1f} ({1e3 * number(g['seconds']['largest']):.0f})"] for g in bar]),
        "",
        "Resets are counted with the first; an episode that ends is followed by another within the same ten steps. Times are"
        " processor time of one thread.",
        "",
        "## Against the number of steps",
        "",
        "![Share of seeds against real steps](exact.svg)",
        "",
        *table(["task", "real steps", "exact", "true terms (shown)", "refused", "not exact and said so", "not exact and not said",
                "STLSQ exact", "STLSQ exact, best threshold"],
               [[g["system"], g["steps"], of(g, g["exact"]), f"{g['true_terms']} ({g['true_terms_shown']})", g["refused"],
                 g["not_exact_and_said_so"], g["not_exact_and_not_said"], g["stlsq"]["exact"], g["stlsq_best"]["exact"]]
                for g in tasks]),
        "",
        "*Refused*: fewer steps than a model linear in states and inputs has unknowns. *Said so*: the report tells that"
        " residuals are larger than the sensors' rounding explains (`reached_floor` is false). *STLSQ*: sequentially thresholded least"
        " squares on increments with the same candidate terms and the paper's threshold of 0.0009; *best threshold*: the nearest to"
        " the truth of 11 thresholds from 1e-4 to 10, on increments and on central differences, which only who knows the truth"
        " can choose.",
        "",
        "## Coefficients, and what rounding allows",
        "",
        "The reported standard errors are the Cramér–Rao bound for observations rounded as the spec declares. If they are"
        " right, 68 % of the errors (estimate − truth)/(standard error) are within 1, 95 % within 2, and the median magnitude is 0.67.",
        "",
        *table(["task", "real steps", "relative error, median (largest)", "errors counted", "within 1", "within 2", "within 3",
                "median"],
               [[g["system"], g["steps"],
                 f"{short(g['coefficients']['median_relative_error'])} ({short(g['coefficients']['largest_relative_error'])})",
                 g["standardised_errors"]["count"],
                 *(short(g["standardised_errors"][k]) for k in ("within_1", "within_2", "within_3", "median"))]
                for g in tasks if g["true_terms"] and g["steps"] in (8, 10, 20, 50)]),
        "",
        "Errors are not counted where the standard error is below 1e-11 of the coefficient, to which the true coefficients"
        " themselves are computed from the true rates: the inverted pendulum shows float64, and what is left there is the rounding of the"
        " computation.",
        "",
        *too_small(tasks),
        "## Other systems, same defaults",
        "",
        *table(["system", "samples", "exact", "true terms (shown)", "not exact and said so", "not exact and not said",
                "deviation, median", "STLSQ, best threshold", "fit [s], median (largest)"],
               [[g["system"], g["steps"], of(g, g["exact"]), f"{g['true_terms']} ({g['true_terms_shown']})",
                 g["not_exact_and_said_so"], g["not_exact_and_not_said"], short(g["deviation"]["median"]),
                 short(g["stlsq_best"]["median_deviation"]),
                 f"{short(g['seconds']['median'])} ({short(g['seconds']['largest'])})"] for g in others]),
        "",
        "Exact without the true terms means terms beside the true ones with coefficients too small to matter.",
    ]
    for g in others:
        said = [e for e in g["examples_not_exact"] if not e["explained"]]
        if g["steps"] == max(o["steps"] for o in others) and said:
            text += ["", f"`{g['system']}` from {g['steps']} samples is *not determined* for {g['not_exact_and_said_so']} of"
                     f" {g['seeds']} seeds: residuals stay above what rounding and the integrator explain, so the report does not"
                     f" claim it. Seed {said[0]['seed']}:", "", "```", *said[0]["equations"], "```"]
    return "\n".join(text) + "\n"


def too_small(tasks):
    """What is to be said where standard errors promise too much."""
    shares = {}
    for g in tasks:
        if g["standardised_errors"]["count"] >= 50:
            shares.setdefault(g["system"], []).append(g["standardised_errors"]["within_2"])
    low = {name: min(values) for name, values in shares.items() if min(values) < 0.9}
    if not low:
        return []
    named = ", ".join(f"{name} (down to {100 * share:.0f} % within 2)" for name, share in low.items())
    return [f"Standard errors are too small for {named}. On mountain-car the rounding is not the sensors' alone: the state itself is"
            " rounded to float32 after every step, as Gymnasium does it, so errors add up from step to step, while the bound takes"
            " each for an error of one observation.", ""]


def chart(groups):
    """Shares of seeds against the number of steps."""
    charts = {}
    for task in TASKS:
        by_steps = {g["steps"]: g for g in groups if g["system"] == task}
        share = lambda value: [value(by_steps[r]) / by_steps[r]["seeds"] if r in by_steps else None for r in STEPS]
        charts[task] = {
            "exact": share(lambda g: g["exact"]), "true terms": share(lambda g: g["true_terms"]),
            "STLSQ, best threshold": share(lambda g: g["stlsq_best"]["exact"]),
            "STLSQ": share(lambda g: g["stlsq"]["exact"]),
        }
    return panels(charts, STEPS, "real steps", "share of seeds", (0.0, 1.0))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=parse_seeds, default=range(100), help="such as 0-99")
    parser.add_argument("--other-seeds", type=parse_seeds, default=range(5), help="of the other systems")
    parser.add_argument("--other-steps", nargs="+", type=int, default=OTHER_STEPS, help="samples of the other systems")
    parser.add_argument("--jobs", type=int, default=1, help="programs at a time; times are those of one")
    args = parser.parse_args()
    program = build("sindyna-bench") / "exact"
    cases = [(task, r, args.seeds) for task in TASKS for r in STEPS]
    cases += [(name, r, args.other_seeds) for name in OTHERS for r in args.other_steps]

    def run(name, steps, seeds):
        stem = f"{name}-{steps}-{seeds[0]}-{seeds[-1]}.jsonl"
        return summary(lines(program, [name, steps, seeds[0], seeds[-1]], ROOT / "runs" / "exact" / stem))

    groups = each(args.jobs, run, cases)
    command = " ".join(["scripts/exact.py", *sys.argv[1:]])
    document = {"command": command, "commit": commit(), "exact_below": EXACT, "groups": groups}
    (ROOT / "results" / "exact.json").write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n")
    (ROOT / "docs" / "exact.md").write_text(page(groups, command))
    (ROOT / "docs" / "exact.svg").write_text(chart(groups))


if __name__ == "__main__":
    main()
