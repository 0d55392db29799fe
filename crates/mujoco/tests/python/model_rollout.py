"""Step one of Gymnasium's models with Python MuJoCo and print the states as hexadecimal float64.

Usage: python model_rollout.py MODEL FRAME_SKIP STEPS
First line: the version of MuJoCo and the model's file; then a state (qpos, qvel) a line: after the reset and after
every step. The control is sin(0.1 i + j) at step i for actuator j. An episode of fifty steps runs before the one that
is printed, so that what a reset has to clear is there.
"""
import math
import pathlib
import struct
import sys

import gymnasium
import mujoco

name, frame_skip, steps = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
path = pathlib.Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets" / f"{name}.xml"
model = mujoco.MjModel.from_xml_path(str(path))
data = mujoco.MjData(model)
rest = data.qpos.copy()


def reset():
    mujoco.mj_resetData(model, data)
    data.qpos[:] = rest
    data.qvel[:] = [0.01 * (j + 1) for j in range(model.nv)]
    mujoco.mj_forward(model, data)


def step(i):
    data.ctrl[:] = [math.sin(0.1 * i + j) for j in range(model.nu)]
    mujoco.mj_step(model, data, nstep=frame_skip)
    mujoco.mj_rnePostConstraint(model, data)


def show():
    print(*(struct.pack(">d", v).hex() for v in (*data.qpos, *data.qvel)))


print(mujoco.__version__, path)
reset()
for i in range(50):
    step(i)
reset()
show()
for i in range(steps):
    step(i)
    show()
