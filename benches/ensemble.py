#!/usr/bin/env python3
"""Training examples per second of an ensemble of networks, one thread on one core, in turn with PyTorch's. Writes results/ensemble.json.

Usage: .venv-peers/bin/python benches/ensemble.py [--rounds 7] [--core 1]      (scripts/peers_install makes .venv-peers)
"""
import argparse
import re
import sys

from alternate import ROOT, build, json_lines, run, say, summary, write

PRESETS = ["janner", "paper"]
# PyTorch's optimiser as it comes, and its fastest.
ADAMS = ["plain", "fused"]


def ours(examples, preset, core):
    text, _ = run([examples / "ensemble_speed", preset], core)
    return float(re.search(r": (\d+) examples/s", text)[1]), float(re.search(r"([\d.]+) µs per imagined step", text)[1])


def measure(examples, preset, rounds, core):
    rates, torch, steps = [], [], []
    factors = {adam: [] for adam in ADAMS}
    for number in range(rounds):
        # Ours before and after, so that each ratio is of neighbours.
        before, step = ours(examples, preset, core)
        torch.append(json_lines(run([sys.executable, ROOT / "benches" / "ensemble_torch.py", preset], core)[0])[-1])
        after, _ = ours(examples, preset, core)
        rates += [before, after]
        steps.append(step)
        for adam, found in factors.items():
            found.append((before + after) / 2 / torch[-1][f"{adam}_adam_per_s"])
        times = ", ".join(f"{found[-1]:.2f} times that with its {adam} Adam" for adam, found in factors.items())
        say(f"{preset} round {number + 1}: ours {rates[-2:]}, torch {torch[-1]['examples_per_s']:.0f}, {times}")
    return {"preset": preset, "members": torch[-1]["members"], "parameters": torch[-1]["parameters"],
            "examples_per_second": {"ours": summary(rates), **{
                f"torch_{adam}": summary([t[f"{adam}_adam_per_s"] for t in torch]) for adam in ADAMS}},
            **{f"ours_over_torch_{adam}": summary(found) for adam, found in factors.items()},
            "microseconds_per_imagined_step": summary(steps)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--core", type=int, default=1)
    args = parser.parse_args()
    examples = build("-p", "sindyna-rl", "--examples") / "examples"
    write("ensemble.json", {"command": "benches/ensemble.py " + " ".join(sys.argv[1:]),
                            "presets": [measure(examples, preset, args.rounds, args.core) for preset in PRESETS]})


if __name__ == "__main__":
    main()
