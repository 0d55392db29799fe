"""Kills a long training at random moments and resumes it: is the record the same, and how much of the time is lost?

A run that is never stopped is the measure. Each of the others is killed (SIGKILL) at a moment drawn uniformly over that time, then resumed from its
checkpoint with `sindyna train --resume`. All files of the two records but timing.json must be the same, byte for byte. Time is CPU time of both processes
over that of the run that was never stopped: it does not depend on what else the machine does.

Usage: scripts/resume.py [--binary target/release/sindyna] [--kills 20] [--seed 0] [--out results/resume.json] [TRAIN OPTIONS]
"""
import argparse
import json
import random
import resource
import shutil
import signal
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

LONG = ["cart-pole-swing-up", "--noise", "0.01", "--real-steps", "300", "--set", "sac.hidden=[256,256]"]


def cpu():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run(command, kill_after=None):
    """CPU and wall seconds of the command, which is killed after so many seconds if it still runs; and whether it was."""
    before, begun = cpu(), time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        process.wait(kill_after)
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGKILL)
        process.wait()
    return cpu() - before, time.monotonic() - begun, process.returncode == -signal.SIGKILL


def record(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir()) if path.name != "timing.json"}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", default="target/release/sindyna")
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("results/resume.json"))
    args, train = parser.parse_known_args()
    binary, moments = str(Path(args.binary).resolve()), random.Random(args.seed)
    train = train or LONG
    work = Path(tempfile.mkdtemp(prefix="resume-"))
    begin = lambda name: [binary, "train", *train, "--quiet", "--out", str(work / name)]
    cpu_seconds, wall, _ = run(begin("whole"))
    whole = record(work / "whole")
    kills = []
    for number in range(args.kills):
        moment, folder = moments.uniform(0, wall), work / f"killed-{number}"
        first, _, killed = run(begin(folder.name), moment)
        checkpoint = folder / "checkpoint.bin"
        size = checkpoint.stat().st_size if checkpoint.exists() else 0
        again = 0.0
        if killed:
            # Before the record began there is nothing to resume.
            resumable = (folder / "config.toml").exists()
            again, _, _ = run([binary, "train", "--resume", str(folder), "--quiet"] if resumable else begin(folder.name))
        same = record(folder) == whole
        lost = (first + again) / cpu_seconds - 1
        kills.append({"after_seconds": round(moment, 2), "killed": killed, "checkpoint_bytes": size, "same": same, "lost": round(lost, 4)})
        print(f"{moment:6.2f} s of {wall:.1f}: {'same' if same else 'OTHER'} bytes, {100 * lost:+.1f} % of the time", flush=True)
        shutil.rmtree(folder)
    shutil.rmtree(work)
    lost = [kill["lost"] for kill in kills if kill["killed"]]
    result = {"command": "scripts/resume.py", "train": train, "wall_seconds": round(wall, 1), "cpu_seconds": round(cpu_seconds, 1),
              "same": sum(kill["same"] for kill in kills), "of": len(kills),
              "lost_median": statistics.median(lost), "lost_most": max(lost), "kills": kills}
    args.out.write_text(json.dumps(result, indent=1) + "\n")
    print(json.dumps({key: value for key, value in result.items() if key != "kills"}))


if __name__ == "__main__":
    main()
