#!/usr/bin/env python3
"""A pendulum with friction as a program that sindyna speaks to: a line of JSON in, a line of JSON out (docs/pipe.md).

A rig would do the same: set the torque in `step`, wait for the end of the interval, and tell what the encoder shows.
"""
import json
import math
import sys

DT, STEPS = 0.05, 4


def rates(theta, omega, u):
    """θ̇ and ω̇ of a point mass of 1 kg on a rod of 1 m, with friction; θ = 0 is upright."""
    return omega, 9.81 * math.sin(theta) - 0.1 * omega + u


def step(theta, omega, u):
    """The state one interval later: Runge–Kutta steps of fourth order with the torque held."""
    h = DT / STEPS
    for _ in range(STEPS):
        a, b = rates(theta, omega, u)
        c, d = rates(theta + h / 2 * a, omega + h / 2 * b, u)
        e, f = rates(theta + h / 2 * c, omega + h / 2 * d, u)
        g, k = rates(theta + h * e, omega + h * f, u)
        theta, omega = theta + h / 6 * (a + 2 * c + 2 * e + g), omega + h / 6 * (b + 2 * d + 2 * f + k)
    return theta, omega


def main():
    theta, omega = math.pi, 0.0
    for line in sys.stdin:
        request = json.loads(line)
        if request["type"] == "close":
            return
        if request["type"] == "spec":
            answer = {"states": ["θ", "ω"], "controls": ["u"], "dt": DT}
        elif request["type"] == "reset":
            theta, omega = request["start"]
            answer = {"state": [theta, omega]}
        elif request["type"] == "step":
            theta, omega = step(theta, omega, request["control"][0])
            answer = {"state": [theta, omega]}
        else:
            answer = {"error": f"unknown request {request['type']}"}
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
