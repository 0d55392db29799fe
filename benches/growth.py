#!/usr/bin/env python3
"""How cost grows: an update with the width of the networks and with the batch, a model step with the number of its terms,
and runs with the number of seeds on one core and on two.

Writes results/growth.json. Sizes are measured in turn, so that only ratios within a table mean anything.

Usage: benches/growth.py [--rounds 3] [--core 1]
Needs: cargo, nothing else.
"""
import argparse
import concurrent.futures
import json
import pathlib
import subprocess
import sys
import tempfile
import time

from alternate import build, digits, json_lines, run, say, summary, write

TERMS = [1, 2, 4, 8, 16, 32, 64]
SEEDS = [1, 2, 4, 8]


def model(terms):
    """ẋ = v, v̇ a sum of `terms` sines and cosines, stepped as the pendulum is."""
    waves = [f"{'sin' if i % 2 else 'cos'}({i // 2 + 1}*x)" for i in range(terms)]
    accelerations = [{"term": i + 1, "coefficient": 0.1 / (i + 1)} for i in range(terms)]
    return {"format": 2, "form": "semi_implicit", "dt": 0.05, "states": ["x", "v"], "controls": ["u"], "terms": ["v", *waves],
            "equations": [[{"term": 0, "coefficient": 1.0}], accelerations], "kinematic": [True, False],
            "n_features": terms + 1}


def steps(release, rounds, core):
    with tempfile.TemporaryDirectory() as folder:
        paths = [pathlib.Path(folder) / f"{terms}.json" for terms in TERMS]
        for path, terms in zip(paths, TERMS):
            path.write_text(json.dumps(model(terms)))
        found = [json_lines(run([release / "examples" / "model_steps", *paths], core)[0]) for _ in range(rounds)]
    return [{"terms": terms, "nanoseconds": summary([lines[i]["many"]["median_ns"] for lines in found])}
            for i, terms in enumerate(TERMS)]


def updates(release, rounds, core):
    found = [json_lines(run([release / "examples" / "cost_of_update"], core)[0]) for _ in range(rounds)]
    return [{"width": first["width"], "batch": first["batch"],
             "microseconds": summary([lines[i]["microseconds"] for lines in found])} for i, first in enumerate(found[0])]


def seeds(release, count, at_once):
    """Seconds for so many runs of pendulum, each on one thread, so many at once."""
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(at_once) as pool:
        start = time.perf_counter()
        commands = [[release / "sindyna", "train", "pendulum", "--quiet", "--threads", "1", "--seed", str(1000 + seed),
                     "--out", pathlib.Path(folder) / str(seed)] for seed in range(count)]
        list(pool.map(lambda command: subprocess.run(command, stdout=subprocess.DEVNULL), commands))
        return time.perf_counter() - start


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--core", type=int, default=1)
    args = parser.parse_args()
    release = build("-p", "sindyna", "-p", "sindyna-bench", "-p", "sindyna-rl", "--bins", "--examples")
    many = {(count, at_once): [] for count in SEEDS for at_once in (1, 2)}
    for _ in range(args.rounds):
        for count, at_once in many:
            many[count, at_once].append(seeds(release, count, at_once))
    say({key: [digits(v) for v in values] for key, values in many.items()})
    write("growth.json", {
        "command": "benches/growth.py " + " ".join(sys.argv[1:]), "updates": updates(release, args.rounds, args.core),
        "model_steps": steps(release, args.rounds, args.core),
        "seeds": [{"seeds": count, "at_once": at_once, "seconds": summary(values)} for (count, at_once), values in many.items()]})


if __name__ == "__main__":
    main()
