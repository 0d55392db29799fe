"""How fast updates and model steps are in other libraries; the program `peers` of crates/bench runs these in turn with ours."""

import statistics
import time

from .shared import tell


def sac(library, net, **options):
    """SAC on Pendulum-v1 that has begun to learn, and its steps with updates per second."""
    model = library.SAC("MlpPolicy", "Pendulum-v1", policy_kwargs={"net_arch": [net, net]}, learning_starts=100, seed=0, **options)
    model.learn(300)
    start = time.perf_counter()
    model.learn(600, reset_num_timesteps=False)
    return model, 600 / (time.perf_counter() - start)


def alone(model, steps):
    """Updates alone per second."""
    from stable_baselines3.common.logger import configure
    model.set_logger(configure(None, []))
    start = time.perf_counter()
    model.train(gradient_steps=steps, batch_size=256)
    return steps / (time.perf_counter() - start)


def sb3_updates(net):
    """Stable-Baselines3's SAC on Pendulum-v1, batch 256: updates alone per second, and environment step with update."""
    import stable_baselines3
    import torch
    torch.set_num_threads(1)
    model, both = sac(stable_baselines3, int(net), device="cpu")
    tell(updates_per_s=alone(model, 600), with_steps_per_s=both)


def sbx_updates(net):
    """SBX's SAC (JAX) on Pendulum-v1, batch 256: updates alone per second, in one compiled scan of 1000, and environment step with update."""
    import sbx
    model, both = sac(sbx, int(net))
    alone(model, 1000)
    tell(updates_per_s=statistics.median(alone(model, 1000) for _ in range(3)), with_steps_per_s=both)


def gymnasium_steps(environment):
    """Nanoseconds of a step of Gymnasium's environment, without wrappers."""
    import gymnasium
    env = gymnasium.make(environment).unwrapped
    env.reset(seed=0)
    env.action_space.seed(0)
    actions = [env.action_space.sample() * 0 for _ in range(200)]
    times = []
    for _ in range(50):
        env.reset()
        start = time.perf_counter()
        for action in actions:
            env.step(action)
        times.append((time.perf_counter() - start) * 1e9 / len(actions))
    tell(median_ns=statistics.median(times), least_ns=min(times))


def pysindy_steps(task):
    """Nanoseconds of PySINDy's predict for the pipeline's model of a task: of one state, and of each of 10,000 at once."""
    import gymnasium
    import numpy as np
    import pysindy as ps

    from .pipeline import TASKS, collect, library
    x, u, y = collect(task, gymnasium.make(TASKS[task]["env"]), 200, 0)
    model = ps.DiscreteSINDy(feature_library=library(task), optimizer=ps.STLSQ(threshold=0.0009, alpha=1e-8))
    model.fit(x, t=1, u=u, x_next=y)

    def median_ns(rows, repeats):
        states, inputs = np.resize(x, (rows, x.shape[1])), np.resize(u, (rows, u.shape[1]))
        times = []
        for _ in range(repeats):
            start = time.perf_counter()
            model.predict(states, u=inputs)
            times.append((time.perf_counter() - start) * 1e9 / rows)
        return statistics.median(times)

    tell(one_ns=median_ns(1, 200), many_ns=median_ns(10_000, 10))
