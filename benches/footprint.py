#!/usr/bin/env python3
"""What sindyna costs besides time: peak memory of train, size of the binary, a build from clean, and which crates they are.

Writes results/footprint.json. The clean build goes to a folder of its own and takes minutes; --no-build leaves it out and
keeps what the file says of it.

Usage: benches/footprint.py [--no-build] [--jobs 2]
Needs: Linux, cargo; nm (binutils) for the sizes by crate.
"""
import argparse
import json
import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time

from alternate import ROOT, build, digits, say, write

TASKS = ["pendulum", "mountain-car", "inverted-pendulum", "cart-pole"]
LARGEST = 15


def peak_memory(binary, task, folder, threads):
    """MiB the process held at most, as the system told the last time it was asked."""
    out = pathlib.Path(folder) / f"{task}-{threads}"
    child = subprocess.Popen([binary, "train", task, "--quiet", "--threads", str(threads), "--out", out],
                             stdout=subprocess.DEVNULL)
    peak = 0.0
    # The account at the end (getrusage) would begin with this interpreter's own size.
    status = pathlib.Path(f"/proc/{child.pid}/status")
    while child.poll() is None:
        found = re.search(r"VmHWM:\s+(\d+) kB", status.read_text())
        peak = max(peak, float(found[1]) / 2**10) if found else peak
        time.sleep(0.005)
    return digits(peak)


def sizes_by_crate(binary):
    """KiB of code and data per crate, the largest; what a generic became counts where its symbol says."""
    if not shutil.which("nm"):
        return None
    lines = subprocess.run(["nm", "--demangle", "--print-size", binary], capture_output=True, text=True).stdout.splitlines()
    sizes = {}
    for line in lines:
        found = re.match(r"\S+ (\S+) [tTrRdDbBwWvV] (.+)", line)
        if found:
            name = re.search(r"(?:^|[<&\s(])([a-z_][a-z0-9_]*)(?:\[[0-9a-f]+\])?::", found[2])
            crate = name[1] if name else "other (C, tables)"
            sizes[crate] = sizes.get(crate, 0) + int(found[1], 16)
    ordered = sorted(sizes.items(), key=lambda pair: -pair[1])
    return {crate: digits(size / 1024) for crate, size in ordered[:LARGEST]}


def clean_build(jobs, folder):
    """Wall and processor seconds of a build from nothing in `folder`, and seconds per crate."""
    environment = {k: v for k, v in os.environ.items() if k != "CARGO_BUILD_JOBS"} | {"CARGO_TARGET_DIR": folder}
    command = ["cargo", "build", "--release", "--quiet", "--timings", "--jobs", str(jobs)]
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(command, cwd=ROOT, env=environment, check=True, stdout=subprocess.DEVNULL)
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    page = (pathlib.Path(folder) / "cargo-timings" / "cargo-timing.html").read_text()
    seconds = {}
    for unit in json.loads(re.search(r"UNIT_DATA = (\[.*?\]);\n", page, re.S)[1]):
        seconds[unit["name"]] = seconds.get(unit["name"], 0) + unit["duration"]
    ordered = sorted(seconds.items(), key=lambda pair: -pair[1])
    return {"jobs": jobs, "wall_seconds": digits(wall), "crates": len(seconds),
            "processor_seconds": digits(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime),
            "slowest_crates_seconds": {name: digits(value) for name, value in ordered[:LARGEST]}}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--no-build", action="store_true", help="leave the clean build out")
    parser.add_argument("--jobs", type=int, default=2)
    args = parser.parse_args()
    earlier = ROOT / "results" / "footprint.json"
    kept = json.loads(earlier.read_text()).get("clean_build") if earlier.exists() else None
    with tempfile.TemporaryDirectory() as folder:
        built = kept if args.no_build else clean_build(args.jobs, folder)
        binary = (build() if args.no_build else pathlib.Path(folder) / "release") / "sindyna"
        memory = {task: {f"{threads} threads": peak_memory(binary, task, folder, threads) for threads in (1, 2)} for task in TASKS}
        megabytes, sizes = digits(binary.stat().st_size / 1e6), sizes_by_crate(binary)
    say(f"peak memory [MiB]: {memory}")
    write("footprint.json", {
        "command": "benches/footprint.py " + " ".join(sys.argv[1:]), "peak_memory_mib": memory,
        "binary_mb": megabytes, "binary_kib_by_crate": sizes, "clean_build": built})


if __name__ == "__main__":
    main()
