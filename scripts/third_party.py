#!/usr/bin/env python3
"""Writes THIRD-PARTY.md: the crates that are compiled into the command, with their licences, and what else is not ours.

Usage: scripts/third_party.py [--check]

--check writes nothing; it fails if the file is out of date or a licence is none that deny.toml allows. Needs cargo and Python 3.11.
"""

import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "THIRD-PARTY.md"

HEAD = """# Third parties

Made by `scripts/third_party.py`. sindyna itself is under MIT or Apache-2.0, at your choice.

## Data and facts in this repository

| what | from | licence |
|---|---|---|
| dynamics, rewards and limits of CartPole, MountainCarContinuous, Pendulum and InvertedPendulum, written anew in `crates/envs`; their reference trajectories | Gymnasium 1.4, © 2016 OpenAI, © 2022 Farama Foundation | MIT |
| reference results in `crates/sindy/tests/golden` | computed with PySINDy 2.1.0 | MIT |
| reference updates in `crates/rl/tests/golden` | computed with PyTorch and Stable-Baselines3 | BSD-3-Clause; MIT |
| the font in which figures become pixels, of the crate `dejavu` | DejaVu fonts, © 2003 Bitstream, Inc. (Bitstream Vera), © 2006 Tavmjong Bah (Arev); changes are in the public domain | Bitstream Vera and Arev font licences |

The fonts may be used, copied, embedded and distributed freely, not sold by themselves, and changed versions must not be called Bitstream, Vera, Tavmjong Bah or Arev.

## Crates compiled into the command

Each carries the text of its licence; `cargo vendor` puts all of them side by side.

| crate | version | licence |
|---|---|---|
"""


def metadata() -> dict:
    """The packages of the workspace and how they depend on each other."""
    command = ["cargo", "metadata", "--format-version", "1", "--locked"]
    return json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout)


def compiled(graph: dict) -> list[dict]:
    """The packages of others that the command `sindyna` is compiled from, or with."""
    packages = {package["id"]: package for package in graph["packages"]}
    nodes = {node["id"]: node for node in graph["resolve"]["nodes"]}
    open_ones = [id for id, package in packages.items() if package["name"] == "sindyna" and not package["source"]]
    seen = set(open_ones)
    while open_ones:
        for dependency in nodes[open_ones.pop()]["deps"]:
            tests_alone = all(kind["kind"] == "dev" for kind in dependency["dep_kinds"])
            if not tests_alone and dependency["pkg"] not in seen:
                seen.add(dependency["pkg"])
                open_ones.append(dependency["pkg"])
    found = [packages[id] for id in seen if packages[id]["source"]]
    return sorted(found, key=lambda package: (package["name"], package["version"]))


def is_allowed(expression: str, allowed: set[str]) -> bool:
    """Whether one choice of an SPDX expression is among those `allowed`."""
    expression = expression.replace("/", " OR ").strip()
    for word, of_all in ((" OR ", any), (" AND ", all)):
        parts = apart(expression, word)
        if len(parts) > 1:
            return of_all(is_allowed(part, allowed) for part in parts)
    if expression.startswith("("):
        return is_allowed(expression[1:-1], allowed)
    return expression in allowed


def apart(expression: str, word: str) -> list[str]:
    """The parts of an expression between the `word` that stands in no parentheses."""
    parts = [""]
    for piece in re.split(f"({word}|[()])", expression):
        if piece == word and parts[-1].count("(") == parts[-1].count(")"):
            parts.append("")
        else:
            parts[-1] += piece
    return parts


def main() -> int:
    packages = compiled(metadata())
    allowed = set(tomllib.loads((ROOT / "deny.toml").read_text())["licenses"]["allow"])
    refused = [f"{p['name']}: {p['license']}" for p in packages if not is_allowed(p["license"] or "none", allowed)]
    if refused:
        print("licences that deny.toml does not allow:", *refused, sep="\n  ", file=sys.stderr)
        return 1
    rows = [f"| {p['name']} | {p['version']} | {p['license'].replace('/', ' OR ')} |\n" for p in packages]
    page = HEAD + "".join(rows)
    if "--check" in sys.argv:
        if PAGE.read_text() != page:
            print("THIRD-PARTY.md is out of date: run scripts/third_party.py", file=sys.stderr)
            return 1
        return 0
    PAGE.write_text(page)
    return 0


if __name__ == "__main__":
    sys.exit(main())
