#!/usr/bin/env python3
"""Writes docs/performance.md from the result files of benches/.

Usage: scripts/performance.py
Needs: nothing but updates.json, whole-job.json, ensemble.json, model-steps.json, parts.json, solve-rate-100.json, growth.json
and footprint.json in results, which the commands named on the page write; a section whose file is missing is left out.
"""
import json

from study import ROOT, number, table

# The bars of the page: ratios that sindyna set itself.
WHOLE_JOB, STEPS, ONE_STEP, MEMORY, BINARY, BUILD, SOLVED = 20, 20, 100, 200, 30, 240, 0.99
ENSEMBLE = 3
UPDATES = {64: {"products": 0.75, "sbx": 1.8, "sb3": 12}, 256: {"products": 0.85, "sbx": 1.25, "sb3": 2.5}}


def load(name):
    path = ROOT / "results" / name
    return json.loads(path.read_text()) if path.exists() else None


def spread(entry, form="{:.3g}"):
    """Median (least–largest)."""
    shown = [form.format(number(entry[key])) for key in ("median", "least", "largest")]
    return f"{shown[0]} ({shown[1]}–{shown[2]})"


def judged(reached):
    return "reached" if reached else "**short**"


def origin(document):
    versions = ", ".join(f"{name} {version}" for name, version in document["versions"].items())
    return (f"`{document['command'].strip()}`, commit {document['commit']}, {document['date']}, {document['machine']}, "
            f"{document['rustc'].split(' (')[0]}" + (f"; {versions}" if versions else "") + ".")


def whole_job(document):
    def peer(entry):
        if entry["median"] is None:
            return f"> {entry['more_than']:.0f} ({entry['solved']} of {entry['runs']} solved)"
        return f"{entry['median']:.1f} ({entry['solved']} of {entry['runs']} solved)"

    def at_least(task, value):
        return ("≥ " if task["ratio_is_at_least"] else "") + spread(value, "{:.0f}")

    tasks = document["tasks"]
    return [
        "## The whole job",
        "",
        "From nothing to a policy that solves the real task, one core: a rollout, identification, training in the model."
        f" {origin(document)}",
        "",
        *table(["task", "ours [s]", "solved", "peers [s], median", "better peer", "ratio", f"bar {WHOLE_JOB}",
                "at equal networks and batch"],
               [[t["task"], spread(t["ours"]), f"{t['ours']['solved']} of {t['ours']['runs']}",
                 "; ".join(f"{name} {peer(entry)}" for name, entry in t["peers"].items()), t["better_peer"],
                 at_least(t, t["ratio"]), judged(t["ratio"]["median"] >= WHOLE_JOB),
                 f"{at_least(t, t['equal']['ratio'])} ({t['equal']['hidden'][0]}×{t['equal']['hidden'][1]}, {t['equal']['batch']})"]
                for t in tasks]),
        "",
        "Ours is the whole process with an evaluation of 100 real episodes. A peer's seconds leave out imports and real"
        f" evaluations and end at the first evaluation that reaches the mark; it is given up after {document['cap_seconds']:.0f} s,"
        " which then stands in the ratio (≥). Ratios are of neighbours in time, their median taken over seeds. Peers have 200 real steps, ours 10. At equal networks all else is ours: learning"
        " rate, targets' rate, updates per imagined step, stopping rule. So that last column is what the kernel and the"
        " settings give without smaller networks and batches.",
        "",
        "Where our seconds go (medians):",
        "",
        *table(["task", "identification", "training", "evaluation", "updates", "at equal networks: updates, seconds"],
               [[t["task"], *(f"{t['parts_of_ours'][p]['median']:.3g}" for p in ("identify", "train", "evaluate")),
                 f"{t['updates_of_ours']['median']:.0f}", f"{t['equal']['updates']['median']:.0f}, {t['equal']['median']:.3g}"]
                for t in tasks]),
        "",
    ]


def updates(document):
    rows, detail = [], []
    for size in document["sizes"]:
        bars, width = UPDATES[size["width"]], f"{size['width']}×{size['width']}"
        share = size["share_of_fastest_products"]
        for name, measured, bar in [
            ("share of the fastest bare products, by medians", share["median"], bars["products"]),
            ("the same by the best window of each", share["best"], bars["products"]),
            ("times SBX's scan", size["ours_over_sbx"], bars["sbx"]),
            ("times Stable-Baselines3", size["ours_over_sb3"], bars["sb3"]),
        ]:
            rows.append([width, name, spread(measured), bar, judged(measured["median"] >= bar)])
        flop = size["mflop_per_update"]
        for name, rate in size["in_turn_in_one_process"].items():
            detail.append([width, name, spread(rate, "{:.0f}"), f"{rate['median'] * flop / 1e3:.0f}"])
    return [
        "## Updates of SAC",
        "",
        f"Batch 256, one thread. {origin(document)}",
        "",
        *table(["networks", "ours", "median (least–largest)", "bar", ""], rows),
        "",
        "The mark: the matrix products of one update whose results are used, in the same order and on the same shapes, by"
        " other libraries, in turn with whole updates in one process (`product_ceiling`):",
        "",
        *table(["networks", "what", "per second", "GFLOP/s"], detail),
        "",
        "MKL chooses slower paths on this maker's processors than on another's; there this table has to be made anew. What"
        " an update is besides products, and what was tried: [notes](notes/2026-11-21-update-kernel.md). On ARM the kernels are"
        " vectors of four with a fused product, which the compiler makes NEON of: they are checked for `aarch64-unknown-linux-gnu`"
        " and were never run or measured there.",
        "",
    ]


def ensemble(document):
    return [
        "## Ensembles of networks",
        "",
        f"Training, batch 256, one thread. {origin(document)}",
        "",
        *table(["preset", "networks", "parameters", "ours [examples/s]", "PyTorch [examples/s]", "its fused Adam [examples/s]",
                "times PyTorch", f"bar {ENSEMBLE}", "times its fused Adam", "an imagined step of ours [µs]"],
               [[p["preset"], p["members"], p["parameters"],
                 *(spread(p["examples_per_second"][who], "{:.0f}") for who in ("ours", "torch_plain", "torch_fused")),
                 spread(p["ours_over_torch_plain"]), judged(p["ours_over_torch_plain"]["median"] >= ENSEMBLE),
                 spread(p["ours_over_torch_fused"]),
                 spread(p["microseconds_per_imagined_step"])] for p in document["presets"]]),
        "",
        "PyTorch has all networks in one batched product, and Adam as it comes or fused (`benches/ensemble_torch.py`). An"
        " example is a row of one batch, of which every network sees one of its own.",
        "",
    ]


def parts(document):
    names = list(document["tasks"][0]["shares"])
    return [
        "## Parts of a run",
        "",
        f"Where the time of `train` goes, whole process on one thread, medians of {document['seeds']} seeds. {origin(document)}",
        "",
        *table(["task", *names], [[t["task"], *(f"{100 * t['shares'][name]:.1f} %" for name in names)] for t in document["tasks"]]),
        "",
        "*Model* is imagination, trials of the policy in the model, and what little identification steps; of these, trials are by"
        " far the most: a turn of imagination pays for an update, a trial is 100 whole episodes after every 250 updates."
        " They step 25 at a time and in as many groups as there are threads. *Loops over networks' numbers* are Adam, what a"
        " policy draws, and policies acting in trials. What imagination alone takes: [notes](notes/2026-11-21-parts-of-a-run.md).",
        "",
    ]


def steps(document):
    rows = []
    for t in document["tasks"]:
        ns = t["nanoseconds"]
        rows.append([t["task"], spread(ns["ours_one"]), spread(ns["ours_many"]), spread(t["million_steps_per_second"]),
                     spread(t["gymnasium_over_ours"]), spread(t["pysindy_over_ours"], "{:.0f}"),
                     spread(t["pysindy_of_10000_over_ours_many"], "{:.0f}")])
    pendulum = next(t for t in document["tasks"] if t["task"] == "pendulum")
    fast = pendulum["million_steps_per_second"]["median"]
    one = pendulum["nanoseconds"]["ours_one"]["median"]
    return [
        "## Steps of the model",
        "",
        origin(document),
        "",
        *table(["model of", "one after the other [ns]", "side by side [ns]", "million/s side by side",
                "times Gymnasium's step", "times PySINDy's predict of one", "times its predict of 10,000, per state"], rows),
        "",
        f"Bars, for the pendulum: {STEPS} million steps per second and core: {fast:.3g}, {judged(fast >= STEPS)}; one step under"
        f" {ONE_STEP} ns: {one:.3g}, {judged(one < ONE_STEP)}. *Side by side* is a loop of single calls over independent states.",
        "",
    ]


def footprint(document):
    memory = max(v for task in document["peak_memory_mib"].values() for v in task.values())
    build = document.get("clean_build")
    text = [
        "## Footprint",
        "",
        origin(document),
        "",
        f"- Peak memory of `train`, the largest of all tasks on one and two threads: {memory:.0f} MiB (bar {MEMORY}:"
        f" {judged(memory < MEMORY)}).",
        f"- The binary with default features: {document['binary_mb']:.1f} MB (bar {BINARY}:"
        f" {judged(document['binary_mb'] < BINARY)}).",
    ]
    if build:
        text += [f"- A build from clean with {build['jobs']} jobs: {build['wall_seconds']:.0f} s, {build['processor_seconds']:.0f} s"
                 f" of processor time (bar {BUILD} s: {judged(build['wall_seconds'] < BUILD)}); {build['crates']} crates. The machine"
                 " had other things to do, which the processor time leaves out."]
    text += [""]
    heads, columns = [], []
    if document["binary_kib_by_crate"]:
        heads += ["crate", "KiB in the binary"]
        columns.append(list(document["binary_kib_by_crate"].items()))
    if build:
        heads += ["crate", "seconds of the build"]
        columns.append(list(build["slowest_crates_seconds"].items()))
    rows = [[cell for pair in row for cell in (f"`{pair[0]}`", f"{pair[1]:.0f}")] for row in zip(*columns)]
    return text + (table(heads, rows) + [""] if rows else [])


def growth(document):
    cases = document["updates"]
    base = next(c for c in cases if (c["width"], c["batch"]) == (64, 128))["microseconds"]["median"]

    def relative(case):
        return [f"{case['microseconds']['median']:.0f}", f"{case['microseconds']['median'] / base:.2f}"]

    alone = {s["at_once"]: s["seconds"]["median"] for s in document["seeds"] if s["seeds"] == 1}
    return [
        "## How cost grows",
        "",
        origin(document),
        "",
        "An update, batch 128, against the width of both hidden layers; and at 64×64 against the batch:",
        "",
        *table(["width", "µs", "times 64×64"], [[c["width"], *relative(c)] for c in cases if c["batch"] == 128]),
        "",
        *table(["batch", "µs", "times batch 128"],
               [[c["batch"], *relative(c)] for c in sorted(cases, key=lambda c: c["batch"]) if c["width"] == 64]),
        "",
        "A model step (two states, sines and cosines) against the number of terms:",
        "",
        *table(["terms", "ns"], [[s["terms"], spread(s["nanoseconds"])] for s in document["model_steps"]]),
        "",
        "Runs of `train pendulum` with so many seeds, a process on one thread each, all seeds together against one alone:",
        "",
        *table(["seeds", "at once", "seconds", "times one seed"],
               [[s["seeds"], s["at_once"], spread(s["seconds"]), f"{s['seconds']['median'] / alone[s['at_once']]:.1f}"]
                for s in document["seeds"]]),
        "",
    ]


def solve_rate(document):
    rows = []
    for task in dict.fromkeys(r["task"] for r in document["runs"]):
        runs = [r for r in document["runs"] if r["task"] == task]
        solved = sum(bool(r["solved"]) for r in runs)
        returns = [r["mean_return"] for r in runs]
        rows.append([task, f"{solved} of {len(runs)}", f"{sum(returns) / len(returns):.1f} ({min(returns):.1f})",
                     judged(solved >= SOLVED * len(runs))])
    seeds = [r["seed"] for r in document["runs"]]
    return ["## Solved", "",
            f"Real evaluation of 100 episodes, seeds {min(seeds)} to {max(seeds)}, 10 real steps each"
            f" (`scripts/solve_rate.py --seeds {min(seeds)}-{max(seeds)} --out results/solve-rate-100`, commit {document['commit']});"
            f" bar {100 * SOLVED:.0f} %:", "",
            *table(["task", "solved", "return, mean (lowest)", ""], rows), ""]


def main():
    sections = {"whole-job.json": whole_job, "updates.json": updates, "ensemble.json": ensemble,
                "model-steps.json": steps, "parts.json": parts,
                "solve-rate-100.json": solve_rate, "growth.json": growth, "footprint.json": footprint}
    text = [
        "# Performance",
        "",
        "Written by `scripts/performance.py` from `results/`. Every table is of one run in which all that is compared took turns;"
        " medians, with the least and the largest of the repeats. The machine was shared with other work, so only ratios mean"
        " anything. `scripts/peers_install` installs the peers.",
        "",
    ]
    for name, section in sections.items():
        document = load(name)
        text += section(document) if document else []
    (ROOT / "docs" / "performance.md").write_text("\n".join(text).rstrip() + "\n")


if __name__ == "__main__":
    main()
