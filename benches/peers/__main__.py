"""Runs one measurement: `scripts/peers NAME [OPTIONS]`, or `python -m peers` in benches/. Options are the function's arguments."""

import argparse
import importlib
import inspect

from .shared import seeds_of

# Name: module and function. Modules are imported when they are asked for: their packages need not all be installed.
MEASUREMENTS = {
    "versions": ("shared", "tell_versions"),
    "pipeline": ("pipeline", "pipeline"),
    "baseline": ("agents", "baseline"),
    "dqn-ppo": ("agents", "dqn_ppo"),
    "sb3-updates": ("speed", "sb3_updates"),
    "sbx-updates": ("speed", "sbx_updates"),
    "torch-ensemble": ("torch_ensemble", "torch_ensemble"),
    "gymnasium-steps": ("speed", "gymnasium_steps"),
    "pysindy-steps": ("speed", "pysindy_steps"),
    "best-subset": ("best_subset", "best_subset"),
    "undeclared-pysindy": ("undeclared_pysindy", "undeclared_pysindy"),
    "python-fit": ("package", "fit"),
    "python-envs": ("package", "envs"),
    "python-gymnasium": ("package", "controllers"),
    "python-sb3": ("package", "sb3"),
}


def add(parser: argparse.ArgumentParser, function) -> None:
    """An option for each argument that has a default, whose type it has; the others are positional."""
    for name, parameter in inspect.signature(function).parameters.items():
        default, option = parameter.default, "--" + name.replace("_", "-")
        if default is inspect.Parameter.empty:
            parser.add_argument(name)
        elif default is False:
            parser.add_argument(option, action="store_true")
        elif isinstance(default, (list, tuple)):
            parser.add_argument(option, type=lambda text: text.split(","), default=default, metavar="NAMES")
        elif isinstance(default, range):
            parser.add_argument(option, type=seeds_of, default=default, metavar="N|LIST", help="such as 10 or 0-9,100-199")
        else:
            parser.add_argument(option, type=type(default), default=default, help=f"[default: {default}]")


def main() -> None:
    parser = argparse.ArgumentParser(prog="peers", description=__doc__, epilog="Measurements: " + ", ".join(MEASUREMENTS))
    parser.add_argument("measurement", choices=MEASUREMENTS, metavar="NAME")
    parser.add_argument("rest", nargs=argparse.REMAINDER, metavar="...")
    asked = parser.parse_args()
    module, name = MEASUREMENTS[asked.measurement]
    function = getattr(importlib.import_module(f".{module}", __package__), name)
    options = argparse.ArgumentParser(prog=f"peers {asked.measurement}", description=inspect.getdoc(function),
                                      formatter_class=argparse.RawDescriptionHelpFormatter)
    add(options, function)
    function(**vars(options.parse_args(asked.rest)))


if __name__ == "__main__":
    main()
