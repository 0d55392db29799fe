#!/usr/bin/env python3
"""Identification from data whose noise nobody declares: how often right, how often wrong without saying so.

Runs the program `undeclared` of crates/bench for every system, noise and number of samples, and writes results/undeclared.json
(with --set functions results/undeclared-functions.json, with --set absolute results/undeclared-absolute.json, with --positions
results/undeclared-positions.json) and docs/undeclared.md; with --set development it prints its table instead, since nothing is reported on those. What was run before is taken
from runs/undeclared; delete that folder after a change of the identifier. What PySINDy makes of the same logs is added to the page
if results/undeclared-pysindy.json and results/undeclared-pysindy-ensembles.json are there (benches/undeclared_pysindy.py).

Usage: scripts/undeclared.py [--set reported] [--systems lorenz ...] [--noise 0 0.001 0.01 0.05] [--samples 100 300 1000 3000]
       [--seeds 0-9] [--limit 60] [--jobs 1]
Needs: cargo, nothing else.
"""
import argparse
import json
import subprocess
import sys

from study import ROOT, build, commit, each, lines, middle, parse_seeds, rounded, short, table

REPORTED = ROOT / "results" / "undeclared.json"
FUNCTIONS = ROOT / "results" / "undeclared-functions.json"
ABSOLUTE = ROOT / "results" / "undeclared-absolute.json"
POSITIONS = ROOT / "results" / "undeclared-positions.json"
OTHERS = [
    ("Terms with parameters inside", FUNCTIONS, "Saturation, growth, reaction: systems not used in development before the first version of this table, {by}. A term"
     " is right if its parameter is within 30 %."),
    ("States far from zero", ABSOLUTE, "Temperatures in kelvins, altitudes, speeds near 314 rad/s: {by}. Results on two-rooms and lake showed faults that were mended"
     " since; the other three are held out."),
    ("Without the rates", POSITIONS, "The same systems without the states that are rates of others, {by}: the method is told which these are, not their values. None of"
     " these logs was looked at during development, some systems of these kinds were."),
]
PEERS = {"STLSQ": ROOT / "results" / "undeclared-pysindy.json",
         "STLSQ and ensembles of it": ROOT / "results" / "undeclared-pysindy-ensembles.json"}


def summary(rows):
    """What the rows of one system, noise and number of samples come to."""
    count = lambda holds: sum(bool(holds(r)) for r in rows)
    wrong = [r for r in rows if not r["right"] and r["equations"]]
    worst = lambda r: [{k: e[k] for k in ("state", "missing", "spurious")} for e in r["equations"] if not e["right"]]
    return {
        **{k: rows[0][k] for k in ("system", "noise", "samples")}, "seeds": len(rows),
        "right": count(lambda r: r["right"]),
        "right_and_adequate": count(lambda r: r["right"] and r["adequate"]),
        "wrong_but_adequate": count(lambda r: not r["right"] and r["adequate"]),
        **{k.replace("-", "_"): count(lambda r: r["outcome"] == k) for k in ("refused", "timed-out", "crashed")},
        "seconds": rounded(middle(r["seconds"] for r in rows if r["seconds"] is not None)),
        "coefficient_error": rounded(middle(r["coefficient_error"] for r in rows if r["right"])),
        "deviation": rounded(middle(r["deviation"] for r in rows if r["deviation"] is not None)),
        "first_wrong": {"seed": wrong[0]["seed"], "equations": worst(wrong[0])} if wrong else None,
    }


def cell(group):
    """Right, wrong without saying so, seconds."""
    if group is None:
        return "—"
    late = f", {group['timed_out']} late" if group["timed_out"] else ""
    seconds = f"{short(group['seconds'])} s" if group["seconds"] is not None else "—"
    return f"**{group['right']}** ({group['wrong_but_adequate']}), {seconds}{late}"


def level(noise):
    return f"{100 * noise:g} %" if noise else "none"


def grid(groups, show):
    """Systems and noise downwards, samples across."""
    by = {(g["system"], g["noise"], g["samples"]): g for g in groups}
    distinct = lambda key: list(dict.fromkeys(g[key] for g in groups))
    samples = sorted(distinct("samples"))
    rows = [[name, level(noise), *(show(by.get((name, noise, n))) for n in samples)]
            for name in distinct("system") for noise in sorted(distinct("noise"))]
    return table(["system", "noise", *(f"{n} samples" for n in samples)], rows)


def totals(groups):
    """One line per noise over all systems and numbers of samples."""
    lines = []
    for noise in sorted({g["noise"] for g in groups}):
        of = [g for g in groups if g["noise"] == noise]
        add = lambda key: sum(g[key] for g in of)
        lines.append([level(noise), add("seeds"), add("right"), add("wrong_but_adequate"), add("refused"), add("timed_out"),
                      add("crashed")])
    return table(["noise", "runs", "right", "wrong, claimed adequate", "refused", "over the limit", "crashed"], lines)


def page(document):
    """docs/undeclared.md."""
    groups, seeds = document["groups"], document["groups"][0]["seeds"]
    text = [
        "# Data whose noise nobody declares",
        "",
        f"Written by `{document['command']}` from `results/undeclared.json`, with the identifier of commit"
        f" {document['commit']}. A log of N samples, in recordings of 60 to 100 from random"
        " starts under inputs that are half sines and half steps, held over each sample; Gaussian noise on every state, in parts of"
        " its standard deviation over the log. The method is told the names of the columns, which state is an angle and which the"
        " rate of another; not the noise, and no terms. Not held out: during the development of this version faults were looked into on some of these systems and seeds (docs/notes).",
        "",
        "*Right*: every equation has exactly the true terms (of implicit equations: any set of terms that the true rates satisfy with"
        " exactly one set of coefficients, none of them zero, since those can be written in several ways). A term beside the true ones"
        " is wrong however small its coefficient. *Claimed adequate*: the method says that residuals are at rounding, or that"
        f" they are white and no other terms explain the data as well. A run over {document['limit']:g} s counts as wrong. Processor time of all threads.",
        "",
        "## All systems",
        "",
        *totals(groups),
        "",
        "## System by system",
        "",
        f"Of {seeds}: **right** (wrong, claimed adequate), median time.",
        "",
        *grid(groups, cell),
    ]
    for title, path, about in OTHERS:
        if path.exists():
            other = json.loads(path.read_text())
            by = f"by `{other['command']}` with the identifier of commit {other['commit']}"
            text += ["", f"## {title}", "", f"{about.format(by=by)} Of {other['groups'][0]['seeds']}.", "", *totals(other["groups"]), "",
                     *grid(other["groups"], cell)]
    for title, path in PEERS.items():
        if path.exists():
            peer = json.loads(path.read_text())
            count = peer["groups"][0]["seeds"]
            text += ["", f"## PySINDy on the same logs: {title}", "", f"{peer['about']} Of {count} log{'s' * (count > 1)} a cell.", "",
                     *grid(peer["groups"], lambda g: "—" if g is None else g["cell"])]
    return "\n".join(text) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--set", choices=["reported", "functions", "absolute", "development"], default="reported")
    parser.add_argument("--systems", nargs="+", help="only these")
    parser.add_argument("--positions", action="store_true", help="without the states that are rates of others")
    parser.add_argument("--noise", nargs="+", type=float, default=[0, 0.001, 0.01, 0.05])
    parser.add_argument("--samples", nargs="+", type=int, default=[100, 300, 1000, 3000])
    parser.add_argument("--seeds", type=parse_seeds, default=range(10), help="such as 0-9")
    parser.add_argument("--limit", type=float, default=60, help="seconds a run may take")
    parser.add_argument("--jobs", type=int, default=1, help="programs at a time; times are those of one")
    args = parser.parse_args()
    program = build("sindyna-bench") / "undeclared"
    listed = subprocess.run([program, "--set", args.set, "--list"], check=True, capture_output=True, text=True).stdout.split()
    cases = [(s, e, n) for s in args.systems or listed for e in args.noise for n in args.samples]
    seeds = f"{args.seeds[0]}-{args.seeds[-1]}"

    def run(name, noise, samples):
        options = [*(["--positions"] if args.positions else []), "--systems", name, "--noise", f"{noise:g}", "--samples", samples, "--seeds", seeds, "--limit", args.limit]
        stem = ("positions-" if args.positions else "") + f"{name}-{noise:g}-{samples}-{seeds}-{args.limit:g}.jsonl"
        rows = lines(program, options, ROOT / "runs" / "undeclared" / stem)
        return summary(rows) if rows else None

    groups = [group for group in each(args.jobs, run, cases) if group]
    if args.set == "development":
        print("\n".join([*totals(groups), "", *grid(groups, cell)]))
        return
    command = " ".join(["scripts/undeclared.py", *sys.argv[1:]])
    document = {"command": command, "commit": commit(), "limit": args.limit, "groups": groups}
    of_set = {"reported": REPORTED, "functions": FUNCTIONS, "absolute": ABSOLUTE}
    written = POSITIONS if args.positions else of_set[args.set]
    written.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n")
    (ROOT / "docs" / "undeclared.md").write_text(page(json.loads(REPORTED.read_text())))


if __name__ == "__main__":
    main()
