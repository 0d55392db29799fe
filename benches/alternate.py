"""What the benchmarks share: building, running pinned to one core, medians, spreads, and what machine it was.

Only ratios of figures taken in turn in one run mean anything on a machine that has other things to do.
"""
import importlib.metadata
import json
import os
import pathlib
import platform
import statistics
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
PEERS = ["gymnasium", "pysindy", "numpy", "stable_baselines3", "sbx-rl", "torch", "jax", "mkl", "mujoco"]
ONE_THREAD = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "RAYON_NUM_THREADS")}
ONE_THREAD["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"


def build(*options):
    """Builds with `options`; the folder with the programs, which the variable BUILT can name where they are built already."""
    if "BUILT" in os.environ:
        return pathlib.Path(os.environ["BUILT"])
    subprocess.run(["cargo", "build", "--release", "--quiet", *options], cwd=ROOT, check=True)
    metadata = subprocess.run(["cargo", "metadata", "--format-version=1", "--no-deps"], cwd=ROOT, check=True,
                              capture_output=True)
    return pathlib.Path(json.loads(metadata.stdout)["target_directory"]) / "release"


def pinned(command, core):
    """`command` held to one core, where the system can."""
    return [*(["taskset", "-c", str(core)] if sys.platform == "linux" else []), *map(str, command)]


def run(command, core, environment=None):
    """Stdout of `command` on one core and one thread, and the seconds it took."""
    start = time.perf_counter()
    done = subprocess.run(pinned(command, core), cwd=ROOT, env=os.environ | ONE_THREAD | (environment or {}),
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    seconds = time.perf_counter() - start
    # 1: ran, but missed its target.
    if done.returncode not in (0, 1) or (done.returncode and "sindyna" not in str(command[0])):
        sys.exit(f"{' '.join(map(str, command))} failed:\n{done.stderr}")
    return done.stdout, seconds


def json_lines(text):
    return [json.loads(line) for line in text.splitlines() if line.startswith("{")]


def summary(values):
    """Median, least and largest."""
    return {"median": digits(statistics.median(values)), "least": digits(min(values)), "largest": digits(max(values)),
            "repeats": len(values)}


def ratios(ours, theirs):
    """Of neighbours in time, so that what else the machine does cancels."""
    return summary([a / b for a, b in zip(ours, theirs)])


def digits(value):
    """Four are enough."""
    return None if value == float("inf") else float(f"{value:.4g}")


def machine():
    """Processor, cores and system."""
    model = platform.machine()
    info = pathlib.Path("/proc/cpuinfo")
    if info.exists():
        fields = dict(line.split(":", 1) for line in info.read_text().split("\n\n")[0].splitlines() if ":" in line)
        fields = {name.strip(): value.strip() for name, value in fields.items()}
        model = f"{fields.get('model name', model)}, family {fields.get('cpu family', '?')}"
        has = fields.get("flags", "").split()
        model += "".join(f", {name}" for name, flag in (("AVX2", "avx2"), ("AVX-512", "avx512f")) if flag in has)
    return f"{model}, {os.cpu_count()} cores, {platform.system()}"


def circumstances():
    """What has to stand beside every figure."""
    def first_line(*command):
        return subprocess.run(command, cwd=ROOT, capture_output=True, text=True).stdout.strip()

    versions = {}
    for name in PEERS:
        try:
            versions[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            pass
    changed = first_line("git", "status", "--porcelain", "--untracked-files=no", "crates", "Cargo.lock")
    return {"machine": machine(), "commit": first_line("git", "rev-parse", "--short=12", "HEAD") + ("+" if changed else ""),
            "date": time.strftime("%Y-%m-%d"), "rustc": first_line("rustc", "--version"), "python": platform.python_version(),
            "versions": versions}


def write(name, document):
    """results/NAME, with the circumstances."""
    path = ROOT / "results" / name
    path.write_text(json.dumps(circumstances() | document, indent=1, ensure_ascii=False) + "\n")
    print(f"wrote {path.relative_to(ROOT)}", file=sys.stderr)


def say(text):
    print(text, file=sys.stderr, flush=True)
