#!/usr/bin/env python3
"""PySINDy's own tests, run on sindyna, test by test.

Downloads the source distribution of PySINDy into a temporary folder, and runs its tests there with `shim.py` in the place of PySINDy; nothing of it is kept.
Needs: the Python package, scipy, scikit-learn, derivative, hypothesis, pytest<8 and pytest-lazy-fixture, pip.
Usage: python run.py [FILE]   (docs/python-pysindy-tests.md by default)
"""

import collections
import os
import pathlib
import re
import subprocess
import sys
import tarfile
import tempfile
import xml.etree.ElementTree as tree

VERSION = "2.1.0"
HERE = pathlib.Path(__file__).resolve().parent

#: Files of tests that are about other things than equations of samples.
ELSEWHERE = {
    "test_notebooks.py": "notebooks of PySINDy's documentation",
    "test_axes.py": "PySINDy's arrays with named axes",
    "test_utils.py": "PySINDy's helper functions",
    "test_odes.py": "PySINDy's collection of systems",
    "test_trapping.py": "the optimizer TrappingSR3",
    "test_scikit_time.py": "the interface of deeptime",
}

#: Tests that do not pass, and why that is so: sindyna does it otherwise on purpose.
OTHERWISE = {
    "test_simulate_with_vector_control_input": "`simulate` gives as many rows as times, PySINDy one less where inputs are an array",
    "test_bad_t": "a list of times is taken as times, PySINDy refuses it",
}

#: Tests that do not pass, and what they are about that sindyna does not have.
WITHOUT = {
    "test_order_error": "second derivatives, which are refused when they are used",
    "test_nd_differentiation": "samples of fields, with more than two axes",
    "test_polynomial_combinations": "a private function of PySINDy",
    "test_tensored_library": "a private function of PySINDy",
}

#: Tests that pass, and say nothing of sindyna.
OF_OTHERS = dict.fromkeys(
    (
        "test_wrapper_equivalence_with_dxdt",
        "test_derivative_output_shape",
        "test_sindy_derivative_kwarg_update",
        "test_bad_t_values",
    ),
    "the package `derivative`, which the shim calls",
)

#: The same of what `STLSQ` cannot do.
ALONE = "'STLSQ' object has no attribute", "STLSQ.__init__() got an unexpected keyword argument 'copy_X'"


def tests(folder):
    """The outcome and the reason of every test."""
    subprocess.run(
        [
            sys.executable,
            "-m",
            "pip",
            "download",
            "-q",
            "--no-deps",
            "--no-build-isolation",
            "--no-binary",
            ":all:",
            f"pysindy=={VERSION}",
            "-d",
            folder,
        ],
        check=True,
    )
    (archive,) = pathlib.Path(folder).glob("pysindy-*.tar.gz")
    with tarfile.open(archive) as file:
        file.extractall(folder, filter="data")
    root = pathlib.Path(folder) / f"pysindy-{VERSION}" / "test"
    ignored = [f"--ignore-glob={root}/*{name}" for name in ELSEWHERE]
    found = pathlib.Path(folder) / "found.xml"
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-p",
        "shim",
        "-p",
        "no:cacheprovider",
        "-c",
        os.devnull,
        f"--rootdir={root}",
        f"--junitxml={found}",
    ]
    told = subprocess.run(
        [*command, *ignored, str(root)],
        env={**os.environ, "PYTHONPATH": str(HERE)},
        check=False,
        capture_output=True,
        text=True,
    )
    if not found.exists():
        raise SystemExit(told.stdout + told.stderr)
    for case in tree.parse(found).iter("testcase"):
        file = case.get("classname").split(".")[-1]
        name = case.get("name")
        bad = [part for part in case if part.tag in ("failure", "error")]
        skipped = case.find("skipped")
        if skipped is not None:
            yield file, name, "not applicable", skipped.get("message")
        elif bad:
            yield file, name, "failed", bad[0].get("message").splitlines()[0]
        else:
            yield file, name, "passed", ""


def page(found):
    """The outcomes as Markdown."""
    counts = collections.Counter((file, outcome) for file, _, outcome, _ in found)
    outcomes = ["passed", "otherwise", "failed", "not applicable"]
    yield "# PySINDy's tests on sindyna"
    yield ""
    yield f"The tests of PySINDy {VERSION}'s source distribution, run on `sindyna` by another name for the import: `python python/pysindy_tests/run.py` writes this page."
    yield "`python/pysindy_tests/shim.py` stands for PySINDy: its classes are sindyna's with PySINDy's defaults. A test is not applicable where it uses something that"
    yield "sindyna does not have or refuses with a reason; *otherwise* are tests that fail because sindyna does it otherwise on purpose."
    yield ""
    yield f"| file | {' | '.join(outcomes)} |"
    yield "|---|" + "---|" * len(outcomes)
    for file in dict.fromkeys(file for file, *_ in found):
        yield f"| `{file}` | {' | '.join(str(counts[file, outcome]) for outcome in outcomes)} |"
    yield f"| all | {' | '.join(str(sum(n for (_, told), n in counts.items() if told == outcome)) for outcome in outcomes)} |"
    yield ""
    yield "Not run: " + "; ".join(f"`{name}` ({why})" for name, why in ELSEWHERE.items()) + "."
    for outcome in ("otherwise", "failed", "not applicable"):
        rows = [(file, name, why) for file, name, told, why in found if told == outcome]
        if rows:
            yield ""
            yield f"## {outcome.capitalize()}"
            yield ""
            yield "| test | reason |"
            yield "|---|---|"
            grouped = collections.defaultdict(list)
            for file, name, why in rows:
                grouped[file, name.partition("[")[0], why].append(name)
            for (file, name, why), same in grouped.items():
                times = f" ({len(same)} times)" if len(same) > 1 else ""
                yield f"| `{file}::{name}`{times} | {why} |"


def plain(why):
    """A reason without what differs from run to run, in one cell of a table."""
    why = re.sub(r"^(Skipped: |refused: |[\w.]*Error: )+", "", why or "")
    return re.sub(r"0x[0-9a-f]+", "…", why).replace("|", "\\|").replace("\n", " ")[:200]


def judged(name, outcome, why):
    """The outcome of a test, and why it is so."""
    if outcome == "passed" and name in OF_OTHERS:
        return "not applicable", OF_OTHERS[name]
    if outcome == "failed" and name in OTHERWISE:
        return "otherwise", OTHERWISE[name]
    if outcome == "failed" and name in WITHOUT:
        return "not applicable", WITHOUT[name]
    if outcome == "failed" and why.startswith(ALONE):
        return "not applicable", "an optimizer is a setting of a fit, it makes no regression by itself"
    return outcome, why


def main():
    path = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else HERE.parent.parent / "docs" / "python-pysindy-tests.md"
    with tempfile.TemporaryDirectory() as folder:
        found = []
        for file, name, outcome, why in tests(folder):
            found.append((file, name, *judged(name.partition("[")[0], outcome, plain(why))))
    path.write_text("\n".join(page(found)) + "\n", encoding="utf-8")
    counts = collections.Counter(outcome for *_, outcome, _ in found)
    print(", ".join(f"{outcome}: {n}" for outcome, n in counts.items()))
    return 1 if counts["failed"] else 0


if __name__ == "__main__":
    sys.exit(main())
