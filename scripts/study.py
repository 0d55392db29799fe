"""What the scripts of the studies share: building, running a program once per case, reading its lines."""
import concurrent.futures
import json
import math
import pathlib
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
TASKS = ["cart-pole", "mountain-car", "pendulum", "inverted-pendulum"]


def parse_seeds(text):
    """`0-19`, or `3`."""
    first, _, last = text.partition("-")
    return range(int(first), int(last or first) + 1)


def build(*packages):
    """Builds the packages; the folder with their programs."""
    options = [word for package in packages for word in ("-p", package)]
    subprocess.run(["cargo", "build", "--release", "--quiet", *options], cwd=ROOT, check=True)
    metadata = subprocess.run(["cargo", "metadata", "--format-version=1", "--no-deps"], cwd=ROOT, check=True,
                              capture_output=True)
    return pathlib.Path(json.loads(metadata.stdout)["target_directory"]) / "release"


def commit():
    """Short hash of what is checked out."""
    command = ["git", "rev-parse", "--short=12", "HEAD"]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True).stdout.strip()


def lines(program, arguments, path):
    """The JSON lines `program` prints, from `path` if it was run before; written there once it has ended."""
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        out = subprocess.run([program, *map(str, arguments)], check=True, stdout=subprocess.PIPE).stdout
        part = path.with_suffix(".part")
        part.write_bytes(out)
        part.rename(path)
        print(path.name, file=sys.stderr, flush=True)
    return [json.loads(line) for line in path.read_text().splitlines()]


def each(jobs, function, cases):
    """[function(*case) for case in cases], `jobs` at a time."""
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        return list(pool.map(lambda case: function(*case), cases))


def number(value):
    """A JSON number; what was infinite or NaN is null there."""
    return math.inf if value is None else value


def worst(deviation):
    """Largest error over the box; infinite without a model."""
    return number(deviation["worst"]) if deviation else math.inf


def middle(values):
    """Median, None of nothing."""
    values = list(values)
    return statistics.median(values) if values else None


def rounded(value):
    """Three digits are enough for a result file; None for what is not finite."""
    return float(f"{value:.3g}") if value is not None and math.isfinite(value) else None


def short(value):
    """A number as a table shows it."""
    return "—" if value is None else f"{value:.2g}" if 1e-3 <= abs(value) < 1e4 or value == 0 else f"{value:.1e}"


def plain(value):
    """A return as a table shows it."""
    return "—" if value is None else f"{value:.1f}"


def table(head, rows):
    """A Markdown table."""
    return ["| " + " | ".join(head) + " |", "|" + "---|" * len(head), *("| " + " | ".join(map(str, r)) + " |" for r in rows)]
