#!/usr/bin/env python3
"""Writes spring.csv: a mass on a spring with friction, pushed at random, as sensors with noise would log it. Usage: python3 make_log.py"""

import random

MASS, STIFFNESS, FRICTION = 1.0, 2.0, 0.3  # kg, N/m, N·s/m
STEP, SUBSTEPS, ROWS = 0.05, 50, 400
NOISE = 0.001, 0.002  # m, m/s

random.seed(0)
x, v, force = 0.4, 0.0, 0.0
with open("spring.csv", "w", encoding="utf-8") as log:
    log.write("t [s],x [m],v [m/s],F [N]\n")
    for row in range(ROWS):
        if row % 8 == 0:
            force = round(random.uniform(-1.0, 1.0), 3)
        seen = x + random.gauss(0.0, NOISE[0]), v + random.gauss(0.0, NOISE[1])
        log.write(f"{row * STEP:.2f},{seen[0]:.5f},{seen[1]:.5f},{force}\n")
        for _ in range(SUBSTEPS):
            h = STEP / SUBSTEPS  # the midpoint rule
            x_half = x + 0.5 * h * v
            v_half = v + 0.5 * h * (force - STIFFNESS * x - FRICTION * v) / MASS
            x += h * v_half
            v += h * (force - STIFFNESS * x_half - FRICTION * v_half) / MASS
