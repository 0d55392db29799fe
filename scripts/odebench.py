#!/usr/bin/env python3
"""ODEBench: 63 published ordinary differential equations, identified from one start and judged from another.

Runs the program `odebench` of crates/bench on clean and noisy, whole and thinned data, and writes results/odebench.json and docs/odebench.md.

Usage: scripts/odebench.py [--seed 0] [--limit 10] [--jobs 2]
Needs: cargo, nothing else.
"""
import argparse
import json
import subprocess
import sys

from study import ROOT, build, commit, rounded, short, table

KEPT = ["id", "description", "outcome", "adequate", "recovered", "reconstruction", "generalisation", "deviation", "seconds"]


def share(value):
    return f"{100 * value:.0f} %"


def page(document):
    """docs/odebench.md."""
    kind = lambda s: [f"{100 * s['noise']:g} %", share(s["dropped"])]
    totals = [[*kind(s), share(s["reconstruction_accurate"]), share(s["generalisation_accurate"]), s["recovered"], s["adequate"],
               s["adequate_but_not_recovered"], s["timed_out"], short(s["seconds"]), short(s["wall_seconds"])] for s in document["summaries"]]
    rows = [[r["id"], r["description"], *(short(r[k]) for k in ("reconstruction", "generalisation")), "yes" if r["recovered"] else "",
             "yes" if r["adequate"] else "", short(r["deviation"]), r["outcome"] if r["seconds"] is None else short(r["seconds"])]
            for r in document["runs"] if r["noise"] == 0 and r["dropped"] == 0]
    return "\n".join([
        "# ODEBench",
        "",
        f"Written by `{document['command']}` from `results/odebench.json`, with the identifier of commit {document['commit']}. 63 equations of one to four dimensions (ODEFormer, d'Ascoli et al., 2024;"
        " crates/bench/data), 512 samples over 10 s from the first start, equations judged by the motion they predict from the first start"
        " (*reconstruction*) and from the second, which was not seen (*generalisation*). Noise multiplies each sample by 1 + 0.05 ε; samples are"
        " dropped at random. The method is told names alone. ODEFormer prints R² > 0.9 for 66 % and 33 %.",
        "",
        "*Recovered*: exactly the true terms. An adequate equation that is not recovered may have the true rates in other terms; its deviation,"
        " the RMS error of its rates over their spread, tells. Seconds of a problem are processor time;"
        f" {document['summaries'][0]['jobs']} problems were identified at a time, each on one core; a run over {document['limit']:g} s counts as failed.",
        "",
        *table(["noise", "dropped", "reconstruction R² > 0.9", "generalisation R² > 0.9", "recovered", "called adequate",
                "adequate, not recovered", "over the limit", "processor time, all 63, s", "wall time, s"], totals),
        "",
        "## Clean, all samples",
        "",
        *table(["", "", "R² same start", "R² other start", "recovered", "adequate", "deviation", "s"], rows),
    ]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--limit", type=float, default=10, help="seconds a run may take")
    parser.add_argument("--jobs", type=int, help="problems at a time (as many as there are processors)")
    args = parser.parse_args()
    program = build("sindyna-bench") / "odebench"
    jobs = [] if args.jobs is None else ["--jobs", str(args.jobs)]
    out = subprocess.run([program, "--seed", str(args.seed), "--limit", str(args.limit), *jobs], check=True, stdout=subprocess.PIPE).stdout
    lines = [json.loads(line) for line in out.splitlines()]
    summaries = [line["summary"] for line in lines if "summary" in line]
    number = lambda value: rounded(value) if isinstance(value, float) else value
    runs = [{k: number(line.get(k)) for k in ["noise", "dropped", *KEPT]} for line in lines if "summary" not in line]
    document = {"command": " ".join(["scripts/odebench.py", *sys.argv[1:]]), "commit": commit(), "limit": args.limit,
                "summaries": summaries, "runs": runs}
    (ROOT / "results" / "odebench.json").write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n")
    (ROOT / "docs" / "odebench.md").write_text(page(document))


if __name__ == "__main__":
    main()
