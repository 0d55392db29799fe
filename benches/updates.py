#!/usr/bin/env python3
"""Updates of SAC per second: ours, SBX's scan, Stable-Baselines3's, and the matrix products of an update by other libraries.

One thread on one core, batch 256, in turn. Writes results/updates.json. Ours are taken over whole runs, as the peers' are.

Usage: .venv-peers/bin/python benches/updates.py [--rounds 5] [--core 1]      (scripts/peers_install makes .venv-peers)
"""
import argparse
import re
import sys

from alternate import ROOT, build, json_lines, run, say, summary, write

WIDTHS = [64, 256]


def ours(examples, width, core):
    text, _ = run([examples / "updates_per_second", width], core)
    real = next(line for line in text.splitlines() if line.startswith(f"{width}x{width}") and "numbered" not in line)
    return float(re.search(r"\((\d+) over all\)", real)[1])


def peer(name, width, core):
    return json_lines(run([sys.executable, ROOT / "benches" / f"{name}_sac_updates.py", 1, width], core)[0])[-1]


def ceiling(examples, width, rounds, core):
    """Rates of whole updates and of the bare products of one, as product_ceiling prints them."""
    mkl = sorted((ROOT / sys.prefix / "lib").glob("libmkl_rt.so*"))
    text, _ = run([examples / "product_ceiling", width, rounds], core, {"MKL_RT": str(mkl[-1])} if mkl else {})
    rates = {name.strip(): {"median": float(median), "best": float(best)} for name, median, best
             in re.findall(r"^(.+?)\s+(\d+)/s \(best\s+(\d+)\)", text, re.M)}
    products = float(re.search(r"([\d.]+) MFLOP", text)[1])
    return rates, products


def measure(examples, width, rounds, core):
    rates = {"ours": [], "sbx": [], "sb3": []}
    with_steps, factors = {"sbx": [], "sb3": []}, {"sbx": [], "sb3": []}
    shares, ceilings = {"median": [], "best": []}, []
    for round_number in range(rounds):
        for name in ("sbx", "sb3"):
            # Ours before and after each peer, so that each ratio is of neighbours.
            before = ours(examples, width, core)
            one = peer(name, width, core)
            after = ours(examples, width, core)
            rates["ours"] += [before, after]
            factors[name].append((before + after) / 2 / one["updates_per_s"])
            rates[name].append(one["updates_per_s"])
            with_steps[name].append(one["with_steps_per_s"])
        found, products = ceiling(examples, width, 100, core)
        ceilings.append(found)
        libraries = [name for name in found if name.startswith("products")]
        for how in shares:
            shares[how].append(max(r[how] for n, r in found.items() if n.startswith("update"))
                               / max(found[n][how] for n in libraries))
        say(f"{width}x{width} round {round_number + 1}: ours {rates['ours'][-2:]}, sbx {rates['sbx'][-1]:.0f}, "
            f"sb3 {rates['sb3'][-1]:.0f}, share of the products {shares['median'][-1]:.2f}")
    return {
        "width": width, "batch": 256, "mflop_per_update": products,
        "updates_per_second": {name: summary(values) for name, values in rates.items()},
        "with_environment_step_per_second": {name: summary(values) for name, values in with_steps.items()},
        "ours_over_sbx": summary(factors["sbx"]), "ours_over_sb3": summary(factors["sb3"]),
        "share_of_fastest_products": {how: summary(values) for how, values in shares.items()},
        "in_turn_in_one_process": {name: summary([c[name]["median"] for c in ceilings]) for name in ceilings[0]},
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--core", type=int, default=1)
    args = parser.parse_args()
    examples = build("-p", "sindyna-rl", "--examples") / "examples"
    write("updates.json", {"command": "benches/updates.py " + " ".join(sys.argv[1:]),
                           "sizes": [measure(examples, width, args.rounds, args.core) for width in WIDTHS]})


if __name__ == "__main__":
    main()
