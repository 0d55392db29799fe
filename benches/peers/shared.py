"""What the measurements share: building, result files, and what machine it was."""

import contextlib
import importlib.metadata
import json
import os
import pathlib
import platform
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
RESULTS = ROOT / "results"
PEERS = ["gymnasium", "pysindy", "numpy", "stable_baselines3", "sbx-rl", "torch", "jax", "mkl", "mujoco", "abess", "sindyna"]
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


def seeds_of(text):
    """`10` is the first ten, `0-9,100-199` ranges, as `sindyna compare` reads them."""
    if text.isdigit():
        return range(int(text))
    ends = [part.partition("-") for part in text.split(",")]
    return [seed for first, _, last in ends for seed in range(int(first), int(last or first) + 1)]


def build(*options):
    """Builds with `options`; the folder with the programs, which the variable BUILT can name where they are built already."""
    if "BUILT" in os.environ:
        return pathlib.Path(os.environ["BUILT"])
    subprocess.run(["cargo", "build", "--release", "--quiet", *options], cwd=ROOT, check=True)
    found = subprocess.run(["cargo", "metadata", "--format-version=1", "--no-deps"], cwd=ROOT, check=True, capture_output=True)
    return pathlib.Path(json.loads(found.stdout)["target_directory"]) / "release"


def tell(**found):
    """One JSON line on standard output."""
    print(json.dumps(found), flush=True)


def say(text):
    print(text, file=sys.stderr, flush=True)


def machine():
    """Processor, cores and system."""
    info = pathlib.Path("/proc/cpuinfo")
    lines = info.read_text().split("\n\n")[0].splitlines() if info.exists() else []
    fields = {name.strip(): value.strip() for name, _, value in (line.partition(":") for line in lines)}
    has = fields.get("flags", "").split()
    vectors = "".join(f", {name}" for name, flag in (("AVX2", "avx2"), ("AVX-512", "avx512f")) if flag in has)
    model = fields.get("model name", platform.machine())
    return f"{model}, family {fields.get('cpu family', '?')}{vectors}, {os.cpu_count()} cores, {platform.system()}"


def versions():
    """Of the packages that are here."""
    found = {}
    for name in PEERS:
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            found[name] = importlib.metadata.version(name)
    return found


def tell_versions():
    """The versions of the peers."""
    tell(**versions())


def circumstances():
    """What has to stand beside every figure."""
    def said(*command):
        return subprocess.run(command, cwd=ROOT, capture_output=True, text=True).stdout.strip()

    changed = said("git", "status", "--porcelain", "--untracked-files=no", "crates", "Cargo.lock")
    return {"machine": machine(), "commit": said("git", "rev-parse", "--short=12", "HEAD") + ("+" if changed else ""),
            "date": time.strftime("%Y-%m-%d"), "rustc": said("rustc", "--version"), "python": platform.python_version(),
            "versions": versions(), "command": " ".join(["scripts/peers", *sys.argv[1:]])}


def write(stem, **document):
    """results/STEM.json, with the circumstances, whole or not at all."""
    path = RESULTS / f"{stem}.json"
    part = path.with_suffix(".part")
    part.write_text(json.dumps(circumstances() | document, indent=1, ensure_ascii=False) + "\n")
    part.replace(path)
    say(f"wrote {path.relative_to(ROOT)}")


def earlier(stem, key="runs"):
    """What stands in results/STEM.json under `key`."""
    path = RESULTS / f"{stem}.json"
    return json.loads(path.read_text())[key] if path.exists() else []
