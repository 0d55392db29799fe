"""What both generators share: numbers that float32 holds exactly, and the birth certificate of a golden file."""

import datetime
import json
import pathlib
import sys

import numpy as np
import torch

FOLDER = pathlib.Path(__file__).resolve().parents[3] / "crates" / "rl" / "tests" / "golden"


def grid(values):
    """Rounds to multiples of 1/1024: exact in float32, float64 and a short decimal alike."""
    return torch.round(values * 1024) / 1024


def to_float32(tensor):
    """Rounds a float64 tensor in place to the nearest float32 numbers."""
    with torch.no_grad():
        tensor.copy_(tensor.float().double())


def short(tensor):
    """The tensor as nested lists with the fewest digits that still name its float32 numbers."""
    array = tensor.detach().numpy().astype(np.float32)
    return np.vectorize(lambda v: float(str(v)), otypes=[float])(array).tolist()


def digits(tensor, n=10):
    """The float64 tensor as nested lists with n significant digits."""
    array = tensor.detach().numpy()
    return np.vectorize(lambda v: float(f"{v:.{n - 1}e}"), otypes=[float])(array).tolist()


def linears(module):
    """The linear layers of a module, in order."""
    return [m for m in module.modules() if isinstance(m, torch.nn.Linear)]


def write(name, tool, licence, tolerance, reason, content):
    """Writes tests/golden/<name>.json with its certificate first."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    certificate = {
        "tool": tool,
        "command": "python " + " ".join(["scripts/golden/sac/" + pathlib.Path(sys.argv[0]).name, *sys.argv[1:]]),
        "python": sys.version.split()[0],
        "date": datetime.date.today().isoformat(),
        "licence": licence,
        "tolerance": tolerance,
        "tolerance_reason": reason,
    }
    path = FOLDER / f"{name}.json"
    path.write_text(json.dumps({**certificate, **content}, separators=(",", ":")) + "\n")
    print(f"{path.name}: {path.stat().st_size} bytes")
