"""Records rollouts of the original tasks, for crates/training/src/task_file/rewards.rs.

Usage: python scripts/golden/dm_control/rewards.py > crates/training/tests/golden/planning_tasks.json
Needs dm_control 1.0.50 (Apache-2.0), gymnasium 1.4.0 (MIT) and mujoco 3.17.0 (Apache-2.0).
"""

import json
import sys
from importlib.metadata import version

import gymnasium
import numpy as np
from dm_control import suite

STEPS = 60
FEW = 20


def of_suite(domain, task, state, steps=STEPS):
    """Rows (x, u, x', reward) of random actions."""
    rows, rng = [], np.random.default_rng(0)
    for seed in range(2):
        env = suite.load(domain, task, task_kwargs={"random": seed})
        env.reset()
        if seed == 1:
            near_goal(env, domain)
        for _ in range(steps):
            x = state(env.physics)
            u = rng.uniform(-1.0, 1.0, env.action_spec().shape)
            reward = env.step(u).reward
            rows.append([list(map(float, v)) for v in (x, u, state(env.physics), [reward])])
    return rows


def near_goal(env, domain):
    """Puts the system where a sparse reward is paid."""
    with env.physics.reset_context():
        if domain == "reacher":
            qpos = env.physics.data.qpos
            target = env.physics.named.model.geom_pos["target"]
            x, y = (0.12 * (np.cos(qpos[0]) + np.cos(qpos.sum())), 0.12 * (np.sin(qpos[0]) + np.sin(qpos.sum())))
            target[0], target[1] = x + 0.02, y - 0.01
        else:
            env.physics.data.qpos[:] = 0.005 if domain == "point_mass" else 0.05


def moving(physics):
    return np.concatenate([physics.data.qpos, physics.data.qvel])


def reacher(physics):
    qpos, qvel = physics.data.qpos, physics.data.qvel
    x, y = physics.named.data.geom_xpos["target", :2]
    return [*qpos, np.arctan2(y, x), np.hypot(x, y), *qvel, 0.0, 0.0]


def double_pendulum():
    env, rows = gymnasium.make("InvertedDoublePendulum-v5").unwrapped, []
    rng = np.random.default_rng(0)
    for seed in range(4):
        env.reset(seed=seed)
        for _ in range(STEPS):
            x = np.concatenate([env.data.qpos, env.data.qvel])
            u = rng.uniform(-0.2, 0.2, 1)
            _, reward, terminated, _, _ = env.step(u)
            after = np.concatenate([env.data.qpos, env.data.qvel])
            rows.append([list(map(float, v)) for v in (x, u, after, [reward])])
            if terminated:
                break
    return rows


def reacher_v5():
    env, rows = gymnasium.make("Reacher-v5").unwrapped, []
    rng = np.random.default_rng(0)
    for seed in range(2):
        env.reset(seed=seed)
        for _ in range(FEW):
            x = np.concatenate([env.data.qpos, env.data.qvel])
            u = rng.uniform(-1.0, 1.0, 2)
            reward = env.step(u)[1]
            after = np.concatenate([env.data.qpos, env.data.qvel])
            rows.append([list(map(float, v)) for v in (x, u, after, [reward])])
    return rows


def main():
    rows = {
        "acrobot_swingup": of_suite("acrobot", "swingup", moving),
        "pendulum_swingup": of_suite("pendulum", "swingup", moving),
        "cartpole_swingup": of_suite("cartpole", "swingup", moving),
        "cartpole_swingup_sparse": of_suite("cartpole", "swingup_sparse", moving),
        "cartpole_balance": of_suite("cartpole", "balance", moving, FEW),
        "cartpole_two_poles": of_suite("cartpole", "two_poles", moving, FEW),
        "cartpole_three_poles": of_suite("cartpole", "three_poles", moving, FEW),
        "point_mass": of_suite("point_mass", "easy", moving, FEW),
        "reacher_easy": of_suite("reacher", "easy", reacher),
        "reacher_hard": of_suite("reacher", "hard", reacher),
        "inverted_double_pendulum": double_pendulum(),
        "reacher_v5": reacher_v5(),
    }
    tools = {name: version(name) for name in ("dm_control", "gymnasium", "mujoco")}
    command = "python scripts/golden/dm_control/rewards.py"
    licence = "dm_control and mujoco Apache-2.0, gymnasium MIT"
    tolerance = "rewards to 1e-12: the same formulas in another order of operations"
    head = {"tools": tools, "command": command, "licence": licence, "tolerance": tolerance}
    lines = [f" {json.dumps(key)}: [\n  " + ",\n  ".join(map(json.dumps, of)) + "\n ]" for key, of in rows.items()]
    head_text = ",\n".join(f" {json.dumps(key)}: {json.dumps(value)}" for key, value in head.items())
    sys.stdout.write("{\n" + head_text + ",\n" + ",\n".join(lines) + "\n}\n")


main()
