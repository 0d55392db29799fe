"""Terms as small trees: read from the engine's text, written for people, for LaTeX and for SymPy.

Nothing here evaluates text as code: names of signals may hold quotes, newlines and keywords.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

#: Functions of terms and how many arguments they have.
ARGUMENTS = {
    **dict.fromkeys(("sin", "cos", "tan", "exp", "log", "sqrt", "abs", "sign", "tanh", "atan"), 1),
    **{"max": 2, "min": 2, "clip": 3},
}
FUNCTIONS = tuple(ARGUMENTS)
_RAISED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
_TOKEN = re.compile(
    r"\s*(?:(?P<number>[0-9]+\.?[0-9]*(?:[eE][+-]?[0-9]+)?)|d(?P<rate>[^\W\d⁰¹²³⁴⁵⁶⁷⁸⁹][^\W⁰¹²³⁴⁵⁶⁷⁸⁹]*)/dt\b|(?P<name>[^\W\d⁰¹²³⁴⁵⁶⁷⁸⁹][^\W⁰¹²³⁴⁵⁶⁷⁸⁹]*)"
    r"|(?P<raised>[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)|(?P<sign>[-+*/^(),·−]))"
)

#: A term: ("num", 2.0), ("var", "x0"), ("rate", "x0"), ("neg", a), ("add" | "sub" | "mul" | "div", a, b), ("pow", a, n), ("call", "sin", a),
#: ("call", "max", a, b).
Tree = tuple[Any, ...]


class _Reader:
    def __init__(self, text: str) -> None:
        self.tokens: list[tuple[str, str]] = []
        at, text = 0, text.strip()
        while at < len(text):
            match = _TOKEN.match(text, at)
            if match is None or match.lastgroup is None:
                raise ValueError(f"cannot read {text!r} at position {at + 1}")
            self.tokens.append((match.lastgroup, match.group(match.lastgroup)))
            at = match.end()
        self.at = 0

    def peek(self) -> tuple[str, str]:
        return self.tokens[self.at] if self.at < len(self.tokens) else ("end", "")

    def take(self) -> tuple[str, str]:
        token = self.peek()
        self.at += 1
        return token

    def sum(self) -> Tree:
        tree = self.product()
        while self.peek()[1] in ("+", "-", "−") and self.peek()[0] == "sign":
            kind = "add" if self.take()[1] == "+" else "sub"
            tree = (kind, tree, self.product())
        return tree

    def product(self) -> Tree:
        tree = self.signed()
        while True:
            kind, text = self.peek()
            if kind == "sign" and text in "*·":
                self.take()
                tree = ("mul", tree, self.signed())
            elif kind == "sign" and text == "/":
                self.take()
                tree = ("div", tree, self.signed())
            elif kind in ("name", "rate", "number") or (kind, text) == ("sign", "("):
                tree = ("mul", tree, self.power())
            else:
                return tree

    def signed(self) -> Tree:
        if self.peek() in (("sign", "-"), ("sign", "−")):
            self.take()
            return ("neg", self.signed())
        return self.power()

    def power(self) -> Tree:
        tree = self.atom()
        while True:
            kind, text = self.peek()
            if kind == "raised":
                self.take()
                tree = ("pow", tree, int(text.translate(_RAISED)))
            elif (kind, text) == ("sign", "^"):
                self.take()
                negative = self.peek() in (("sign", "-"), ("sign", "−"))
                if negative:
                    self.take()
                exponent = self.take()[1]
                tree = ("pow", tree, -int(exponent) if negative else int(exponent))
            else:
                return tree

    def atom(self) -> Tree:
        kind, text = self.take()
        if kind == "number":
            return ("num", float(text))
        if kind == "rate":
            return ("rate", text)
        if (kind, text) == ("sign", "("):
            tree = self.sum()
            self.expect(")")
            return tree
        if kind != "name":
            raise ValueError(f"{text or 'the end'!r} is unexpected")
        if text not in FUNCTIONS:
            return ("var", text)
        if ARGUMENTS[text] > 1:
            return ("call", text, *self.arguments(ARGUMENTS[text]))
        raised = self.take()[1].translate(_RAISED) if self.peek()[0] == "raised" else None
        if self.peek() == ("sign", "("):
            argument = self.atom()
        elif self.peek()[0] == "number":
            argument = ("mul", self.atom(), self.atom())
        else:
            argument = self.atom()
        call: Tree = ("call", text, argument)
        return call if raised is None else ("pow", call, int(raised))

    def arguments(self, n: int) -> list[Tree]:
        found = []
        for before in ["(", *[","] * (n - 1)]:
            self.expect(before)
            found.append(self.sum())
        self.expect(")")
        return found

    def expect(self, sign: str) -> None:
        _, text = self.take()
        if text != sign:
            raise ValueError(f"{text or 'the end'!r} is unexpected where {sign!r} is due")


def read(text: str) -> Tree:
    """The tree of a term as the engine writes it, plainly or for people."""
    reader = _Reader(text)
    tree = reader.sum()
    if reader.peek()[0] != "end":
        raise ValueError(f"{reader.peek()[1]!r} is unexpected in {text!r}")
    return tree


def shifted(tree: Tree, offsets: dict[str, float]) -> Tree:
    """The tree with offsets added to its variables."""
    if tree[0] == "var" and offsets.get(tree[1], 0.0) != 0.0:
        offset = offsets[tree[1]]
        return ("add", tree, ("num", offset)) if offset > 0 else ("sub", tree, ("num", -offset))
    return tuple(shifted(part, offsets) if isinstance(part, tuple) else part for part in tree)


def number(value: float, digits: int = 6) -> str:
    """A number with at most so many significant digits."""
    return f"{value:.{digits}g}"


def plain(tree: Tree, name: Callable[[str], str]) -> str:
    """The term in PySINDy's notation: factors joined by a space, powers as ``x^2``."""
    kind = tree[0]
    if kind == "num":
        return number(tree[1])
    if kind == "var":
        return name(tree[1])
    if kind == "rate":
        return f"({name(tree[1])})'"

    def factor(part: Tree) -> str:
        text = plain(part, name)
        return f"({text})" if part[0] in ("add", "sub", "neg", "div") or (part[0] == "num" and part[1] < 0) else text

    if kind == "neg":
        return f"-{factor(tree[1])}"
    if kind == "add":
        return f"{plain(tree[1], name)} + {plain(tree[2], name)}"
    if kind == "sub":
        return f"{plain(tree[1], name)} - {factor(tree[2])}"
    if kind == "mul":
        return f"{factor(tree[1])} {factor(tree[2])}"
    if kind == "div":
        below = factor(tree[2])
        return f"{factor(tree[1])}/{f'({below})' if tree[2][0] == 'mul' else below}"
    if kind == "pow":
        base = plain(tree[1], name)
        simple = tree[1][0] in ("var", "call", "rate")
        return f"{base if simple else f'({base})'}^{tree[2]}"
    return f"{tree[1]}({', '.join(plain(part, name) for part in tree[2:])})"


def latex(tree: Tree, name: Callable[[str], str]) -> str:
    """The term for LaTeX; ``name`` gives names that LaTeX can read."""
    kind = tree[0]
    if kind == "num":
        return latex_number(tree[1])
    if kind == "var":
        return name(tree[1])
    if kind == "rate":
        return rf"\dot{{{name(tree[1])}}}"

    def factor(part: Tree) -> str:
        text = latex(part, name)
        return rf"\left({text}\right)" if part[0] in ("add", "sub", "neg") else text

    if kind == "neg":
        return f"-{factor(tree[1])}"
    if kind == "add":
        return f"{latex(tree[1], name)} + {latex(tree[2], name)}"
    if kind == "sub":
        return f"{latex(tree[1], name)} - {factor(tree[2])}"
    if kind == "mul":
        return rf"{factor(tree[1])} \, {factor(tree[2])}"
    if kind == "div":
        return rf"\frac{{{latex(tree[1], name)}}}{{{latex(tree[2], name)}}}"
    if kind == "pow":
        base = latex(tree[1], name)
        return f"{base}^{{{tree[2]}}}" if tree[1][0] == "var" else rf"\left({base}\right)^{{{tree[2]}}}"
    function, argument = tree[1], ", ".join(latex(part, name) for part in tree[2:])
    if function == "abs":
        return rf"\left|{argument}\right|"
    if function == "sqrt":
        return rf"\sqrt{{{argument}}}"
    function = "arctan" if function == "atan" else function
    head = rf"\operatorname{{{function}}}" if function in ("sign", "clip") else f"\\{function}"
    return rf"{head}\left({argument}\right)"


def latex_number(value: float, digits: int = 6) -> str:
    """A number for LaTeX."""
    mantissa, _, exponent = number(value, digits).partition("e")
    return rf"{mantissa} \cdot 10^{{{int(exponent)}}}" if exponent else mantissa


_ESCAPED = {c: f"\\{c}" for c in "#$%&_{}"} | {
    "\\": r"\textbackslash{}",
    "^": r"\^{}",
    "~": r"\~{}",
    "\n": " ",
    "\r": " ",
}


def latex_name(name: str) -> str:
    """A signal's name for LaTeX, whatever is in it."""
    if re.fullmatch(r"[^\W\d_]", name):
        return name
    match = re.fullmatch(r"([^\W\d_])_?(\d+)", name)
    if match:
        return f"{match[1]}_{{{match[2]}}}"
    text = "".join(_ESCAPED.get(c, c) for c in name)
    return rf"\mathrm{{{text}}}" if re.fullmatch(r"\w+", name) else rf"\text{{{text}}}"


def sympy(tree: Tree, symbol: Callable[[str], Any], rate: Callable[[str], Any]) -> Any:
    """The term as a SymPy expression."""
    import sympy as sp

    def of(part: Tree) -> Any:
        return sympy(part, symbol, rate)

    kind = tree[0]
    if kind == "num":
        return sp.Integer(int(tree[1])) if float(tree[1]).is_integer() and abs(tree[1]) < 1e6 else sp.Float(tree[1])
    if kind == "var":
        return symbol(tree[1])
    if kind == "rate":
        return rate(tree[1])
    if kind == "neg":
        return -of(tree[1])
    if kind == "pow":
        return of(tree[1]) ** tree[2]
    if kind == "call":
        arguments = [of(part) for part in tree[2:]]
        if tree[1] == "clip":
            return sp.Min(sp.Max(arguments[0], arguments[1]), arguments[2])
        named: dict[str, Any] = {"abs": sp.Abs, "sign": sp.sign, "max": sp.Max, "min": sp.Min}
        return (named.get(tree[1]) or getattr(sp, tree[1]))(*arguments)
    a, b = of(tree[1]), of(tree[2])
    return {"add": lambda: a + b, "sub": lambda: a - b, "mul": lambda: a * b, "div": lambda: a / b}[kind]()


def translated(text: str, symbols: Mapping[str, str]) -> str:
    """A formula with the symbols of people's names in their places.

    Raises
    ------
    ValueError
        If it holds a name there is not.
    """
    if not isinstance(text, str):
        raise TypeError(f"a formula is text, got {text!r}")

    def bounded(name: str) -> str:
        before = r"(?<!\w)" if re.match(r"\w", name) else ""
        # A raised digit is an exponent.
        after = r"(?![^\W⁰¹²³⁴⁵⁶⁷⁸⁹])" if re.match(r"\w", name[-1]) else ""
        function = r"(?!\s*\()" if name in FUNCTIONS else ""
        return before + re.escape(name) + after + function

    found = "|".join(bounded(name) for name in sorted(symbols, key=len, reverse=True))
    parts, at = [], 0
    for match in re.finditer(found, text):
        parts += [(text[at : match.start()], False), (symbols[match.group()], True)]
        at = match.end()
    parts.append((text[at:], False))
    for part, known in parts:
        words = [] if known else re.findall(r"[^\W\d]\w*", re.sub(r"\d\.?[eE][+-]?\d", "0", part))
        unknown = next((word for word in words if word not in FUNCTIONS), None)
        if unknown is not None:
            raise ValueError(
                f"{text!r}: no variable or function named {unknown!r}; variables: {', '.join(symbols)}; functions: {', '.join(FUNCTIONS)}"
            )
    return "".join(part for part, _ in parts)


class Names:
    """The names people gave to states and inputs, and the engine's symbols x0, x1, …, u0, u1, … for them."""

    def __init__(self, states: Sequence[str], inputs: Sequence[str]) -> None:
        self.states, self.inputs = list(states), list(inputs)
        symbols = [f"x{i}" for i in range(len(states))] + [f"u{i}" for i in range(len(inputs))]
        self.by_symbol = dict(zip(symbols, [*states, *inputs], strict=True))
        self.by_name = {name: symbol for symbol, name in self.by_symbol.items()}

    def only(self, chosen: Sequence[int]) -> Names:
        """The same names, of which only some are there to make terms of."""
        some = Names(self.states, self.inputs)
        symbols = list(self.by_symbol)
        some.by_symbol = {symbols[i]: self.by_symbol[symbols[i]] for i in chosen}
        return some

    def name(self, symbol: str) -> str:
        """The name behind a symbol; other symbols, such as a parameter's, stay."""
        return self.by_symbol.get(symbol, symbol)

    def formula(self, text: str) -> str:
        """A formula over people's names as one over symbols.

        Raises
        ------
        ValueError
            If it holds a name there is not.
        """
        return translated(text, self.by_name)

    def told(self, message: str) -> str:
        """What the engine says, with people's names."""
        message = re.sub(r" ?\(position \d+\)| at position \d+,?", "", message)
        return re.sub(r"(?<![^\W⁰¹²³⁴⁵⁶⁷⁸⁹])[xu][0-9]+(?![0-9A-Za-z_])", lambda m: self.name(m.group()), message)


class OwnNames(Names):
    """Names of states and inputs that are symbols of the engine themselves: those of a task file."""

    def __init__(self, states: Sequence[str], inputs: Sequence[str]) -> None:
        super().__init__(states, inputs)
        self.by_symbol = {name: name for name in [*states, *inputs]}
        self.by_name = dict(self.by_symbol)

    def told(self, message: str) -> str:
        """What the engine says."""
        return message
