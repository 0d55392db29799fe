#!/usr/bin/env python3
"""Writes lorenz.csv: the Lorenz system, 1,000 samples in ten seconds, with sensors whose noise has a standard deviation of 0.1.

Usage: examples/logs/make_lorenz.py
"""
import pathlib
import random

STEP, FINE, ROWS, SIGMA = 0.01, 10, 1000, 0.1


def rates(x, y, z):
    return 10 * (y - x), x * (28 - z) - y, x * y - 8 / 3 * z


def after(state, step):
    """One step of the classical Runge–Kutta method."""
    moved = lambda k, h: [s + h * d for s, d in zip(state, k)]
    a = rates(*state)
    b = rates(*moved(a, step / 2))
    c = rates(*moved(b, step / 2))
    d = rates(*moved(c, step))
    return [s + step / 6 * (p + 2 * q + 2 * r + t) for s, p, q, r, t in zip(state, a, b, c, d)]


def main():
    rng, state = random.Random(0), [-8.0, 7.0, 27.0]
    with (pathlib.Path(__file__).parent / "lorenz.csv").open("w", newline="\n") as file:
        file.write("t,x,y,z\n")
        for row in range(ROWS):
            file.write(f"{row * STEP:.2f}," + ",".join(f"{s + rng.gauss(0, SIGMA):.3f}" for s in state) + "\n")
            for _ in range(FINE):
                state = after(state, STEP / FINE)


if __name__ == "__main__":
    main()
