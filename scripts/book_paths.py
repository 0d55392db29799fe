"""A preprocessor of mdBook: links to files outside docs/, which are no part of the book, become the paths of these files."""

import json
import posixpath
import re
import sys

LINK = re.compile(r"(?<!!)\[([^\]]+)\]\((\.\./[^)\s]+)\)")


def shown(link: re.Match[str], folder: str) -> str:
    """The text of a link, and the path in the repository."""
    text, path = link[1], posixpath.normpath(posixpath.join("docs", folder, link[2]))
    if path.startswith("docs/"):
        return link[0]
    return f"`{path}`" if text.strip("`") == path else f"{text} (`{path}`)"


def rewrite(item: object) -> None:
    """Rewrites all chapters in `item`."""
    if isinstance(item, list):
        for one in item:
            rewrite(one)
    elif isinstance(item, dict):
        if isinstance(item.get("content"), str):
            folder = posixpath.dirname(item.get("source_path") or "")
            item["content"] = LINK.sub(lambda link: shown(link, folder), item["content"])
        for one in item.values():
            rewrite(one)


if sys.argv[1:2] != ["supports"]:
    _context, book = json.load(sys.stdin)
    rewrite(book)
    json.dump(book, sys.stdout)
