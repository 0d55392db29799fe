#!/usr/bin/env python3
"""Standard errors of coefficients against the truth: do 95 % intervals cover, and is the error no more than the data must leave?

Runs the program `undeclared` of crates/bench on three systems with noise that is not declared, over many seeds, and writes
results/coverage.json and docs/coverage.md.

Usage: scripts/coverage.py [--systems lorenz van-der-pol duffing] [--noise 0.01] [--samples 300] [--seeds 0-199]
Needs: cargo, nothing else.
"""
import argparse
import json
import math
import sys

from study import ROOT, build, commit, lines, parse_seeds, rounded, table

# Of a standard normal number 95 % lie within this.
WITHIN = 1.959964


def summary(name, rows):
    """Coverage and efficiency of one system."""
    right = [r for r in rows if r["right"]]
    z = [v for r in right for e in r["equations"] for v in e["standardised"] or []]
    adequate = sum(r["adequate"] for r in right)
    return {"system": name, "seeds": len(rows), "right": len(right), "right_and_adequate": adequate, "coefficients": len(z),
            "coverage": rounded(sum(abs(v) < WITHIN for v in z) / len(z)),
            "error_over_bound": rounded(math.sqrt(sum(v * v for v in z) / len(z)))}


def page(document):
    """docs/coverage.md."""
    rows = [[g["system"], g["seeds"], g["right"], g["right_and_adequate"], g["coefficients"], f"{100 * g['coverage']:.1f} %",
             f"{g['error_over_bound']:.2f}"] for g in document["groups"]]
    head = ["system", "seeds", "right terms", "of these adequate", "coefficients", "95 % intervals that cover", "error / bound"]
    text = ["# Standard errors", "",
            f"Written by `{document['command']}` from `results/coverage.json`, with the identifier of commit {document['commit']}."
            f" {document['samples']} samples, noise of {100 * document['noise']:g} % of each state's standard deviation, not declared."
            " Logs and systems are those of [undeclared noise](undeclared.md).", "",
            "*Error / bound*: RMS of (found − true)/standard error. The standard error is the square root of the diagonal of the inverse"
            " Fisher information of all samples together (Cramér, Rao), with the noise as it was estimated. Runs with wrong terms have"
            " no true coefficients and are left out.", "", *table(head, rows)]
    return "\n".join(text) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--systems", nargs="+", default=["lorenz", "van-der-pol", "duffing"])
    parser.add_argument("--noise", type=float, default=0.01)
    parser.add_argument("--samples", type=int, default=300)
    parser.add_argument("--seeds", type=parse_seeds, default=range(200), help="such as 0-199")
    args = parser.parse_args()
    program = build("sindyna-bench") / "undeclared"
    seeds = f"{args.seeds[0]}-{args.seeds[-1]}"
    groups = []
    for name in args.systems:
        options = ["--systems", name, "--noise", f"{args.noise:g}", "--samples", args.samples, "--seeds", seeds]
        stem = f"{name}-{args.noise:g}-{args.samples}-{seeds}.jsonl"
        groups.append(summary(name, lines(program, options, ROOT / "runs" / "coverage" / stem)))
    document = {"command": " ".join(["scripts/coverage.py", *sys.argv[1:]]), "commit": commit(), "noise": args.noise,
                "samples": args.samples, "groups": groups}
    (ROOT / "results" / "coverage.json").write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n")
    (ROOT / "docs" / "coverage.md").write_text(page(document))


if __name__ == "__main__":
    main()
