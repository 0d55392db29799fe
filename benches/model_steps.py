#!/usr/bin/env python3
"""A step of the learned model: ours, PySINDy's predict, and the step of Gymnasium's environment, in turn on one core.

Writes results/model-steps.json. Ours are of the model of `sindyna train TASK --seed 0` (crates/bench/examples/model_steps.rs).

Usage: .venv-peers/bin/python benches/model_steps.py [--rounds 5] [--core 1]      (scripts/peers_install makes .venv-peers)
"""
import argparse
import pathlib
import sys
import tempfile

from alternate import ROOT, build, json_lines, ratios, run, say, summary, write

ENVIRONMENTS = {"pendulum": "Pendulum-v1", "mountain-car": "MountainCarContinuous-v0", "cart-pole": "CartPole-v1",
                "inverted-pendulum": "InvertedPendulum-v5"}


def learn(binary, task, folder, core):
    """A model file, and the equations in it."""
    out = pathlib.Path(folder) / task
    run([binary, "train", task, "--max-updates", 8, "--quiet", "--out", out], core)
    return out / "model.json"


def measure(release, task, rounds, core):
    def python(script, argument):
        return json_lines(run([sys.executable, ROOT / "benches" / script, argument], core)[0])[-1]

    one, many, best, gymnasium, predict, predict_many = [], [], [], [], [], []
    with tempfile.TemporaryDirectory() as folder:
        model = learn(release / "sindyna", task, folder, core)
        for _ in range(rounds):
            ours = json_lines(run([release / "examples" / "model_steps", model], core)[0])[-1]
            one.append(ours["one"]["median_ns"])
            many.append(ours["many"]["median_ns"])
            best.append(ours["many"]["least_ns"])
            gymnasium.append(python("gymnasium_steps.py", ENVIRONMENTS[task])["median_ns"])
            pysindy = python("pysindy_steps.py", task)
            predict.append(pysindy["one_ns"])
            predict_many.append(pysindy["many_ns"])
    say(f"{task}: one {one}, many {many}")
    return {"task": task, "nanoseconds": {
                "ours_one": summary(one), "ours_many": summary(many), "ours_many_at_best": summary(best),
                "gymnasium_one": summary(gymnasium), "pysindy_one": summary(predict), "pysindy_of_10000": summary(predict_many)},
            "million_steps_per_second": summary([1e3 / ns for ns in many]),
            "gymnasium_over_ours": ratios(gymnasium, one), "pysindy_over_ours": ratios(predict, one),
            "pysindy_of_10000_over_ours_many": ratios(predict_many, many)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--core", type=int, default=1)
    args = parser.parse_args()
    release = build("-p", "sindyna", "-p", "sindyna-bench", "--bins", "--examples")
    write("model-steps.json", {"command": "benches/model_steps.py " + " ".join(sys.argv[1:]),
                               "tasks": [measure(release, task, args.rounds, args.core) for task in ENVIRONMENTS]})


if __name__ == "__main__":
    main()
