"""No module of the package knows one that knows it, also where types alone are meant."""

import ast
import pathlib

import sindyna


def known(path):
    """The modules of the package that the file at ``path`` imports."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level == 1:
            yield from [node.module.partition(".")[0]] if node.module else [alias.name for alias in node.names]
        if isinstance(node, ast.ImportFrom) and node.level == 0 and (node.module or "").startswith("sindyna"):
            yield node.module.partition(".")[2].partition(".")[0] or "__init__"
        if isinstance(node, ast.Import):
            yield from (
                alias.name.partition(".")[2] or "__init__" for alias in node.names if alias.name.startswith("sindyna")
            )


def test_no_module_knows_one_that_knows_it():
    files = sorted(pathlib.Path(sindyna.__file__).parent.glob("*.py"))
    direct = {path.stem: set(known(path)) for path in files}
    assert direct["_quality"] >= {"_fit", "_data"}, "the modules that a file imports were not read"
    for name in direct:
        reached, ahead = set(), [name]
        while ahead:
            further = direct.get(ahead.pop(), set()) - reached
            reached |= further
            ahead += further
        assert name not in reached, f"{name} knows itself, by way of {sorted(reached)}"
