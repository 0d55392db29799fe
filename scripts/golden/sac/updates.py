"""Whole SAC updates by Stable-Baselines3's own `SAC.train`, for crates/rl.

Three things are replaced, none of them arithmetic of the update: the replay buffer hands out recorded batches, the
normal numbers are recorded ones, and observations are not cast to float32, so that the reference runs in float64.
Ten updates come first; networks, targets and Adam's moments are then rounded in place to float32 numbers and
recorded; five more updates follow, whose losses and parameters are the golden values.
"""

import types

import gymnasium
import numpy as np
import stable_baselines3
import torch
import torch.distributions.normal
from stable_baselines3 import SAC
from stable_baselines3.common import policies

from record import digits, grid, linears, short, to_float32, write

OBSERVED, ACTIONS, HIDDEN, ROWS, BEFORE, UPDATES = 3, 2, [32, 32], 64, 10, 5
SETTINGS = {"learning_rate": 3e-4, "gamma": 0.99, "tau": 0.005}


class Dummy(gymnasium.Env):
    """Spaces, and nothing that would ever be stepped."""

    observation_space = gymnasium.spaces.Box(-10, 10, (OBSERVED,), np.float64)
    action_space = gymnasium.spaces.Box(-1, 1, (ACTIONS,), np.float64)

    def reset(self, *, seed=None, options=None):
        return np.zeros(OBSERVED), {}

    def step(self, action):
        raise NotImplementedError


def batch(generator):
    draw = lambda *shape: grid(torch.randn(*shape, generator=generator))
    observations = draw(ROWS, OBSERVED)
    actions = grid(torch.rand(ROWS, ACTIONS, generator=generator) * 2 - 1)
    return types.SimpleNamespace(
        observations=observations,
        actions=actions,
        next_observations=grid(observations + 0.1 * draw(ROWS, OBSERVED)),
        dones=(torch.rand(ROWS, 1, generator=generator) < 0.15).double(),
        rewards=grid(-observations.pow(2).sum(1, keepdim=True) - 0.1 * actions.pow(2).sum(1, keepdim=True)),
        discounts=None,
    )


def networks(model):
    actor = model.actor
    # The two heads are one layer on our side: means, then logarithms of standard deviations.
    yield "actor", [[l] for l in linears(actor.latent_pi)] + [[actor.mu, actor.log_std]]
    for i in range(2):
        yield f"critic_{i}", [[l] for l in linears(model.critic.q_networks[i])]
        yield f"target_{i}", [[l] for l in linears(model.critic_target.q_networks[i])]


def layers(net, of):
    return [
        {part: of(torch.cat([getattr(l, part) for l in parallel])) for part in ("weight", "bias")} for parallel in net
    ]


def moments(net, optimizer, key):
    return [
        {part: short(torch.cat([optimizer.state[getattr(l, part)][key] for l in parallel])) for part in ("weight", "bias")}
        for parallel in net
    ]


def run(dtype):
    """The recorded start, batches, noise, losses and ends; `dtype` float32 runs the same updates as users do."""
    torch.set_default_dtype(torch.float64)
    torch.manual_seed(30)
    policies.preprocess_obs = lambda obs, *_, **__: obs
    model = SAC("MlpPolicy", Dummy(), policy_kwargs={"net_arch": HIDDEN}, seed=30, device="cpu", **SETTINGS)
    model.set_logger(stable_baselines3.common.logger.configure(format_strings=[]))
    model.policy.double()
    model.log_ent_coef = torch.zeros(1, requires_grad=True)
    model.ent_coef_optimizer = torch.optim.Adam([model.log_ent_coef], lr=SETTINGS["learning_rate"])

    generator = torch.Generator().manual_seed(31)
    batches = [batch(generator) for _ in range(BEFORE + UPDATES)]
    noise = [grid(torch.randn(ROWS, ACTIONS, generator=generator)) for _ in range(2 * (BEFORE + UPDATES))]
    queue = {"batch": iter(batches), "noise": iter(noise)}
    model.replay_buffer = types.SimpleNamespace(sample=lambda size, env=None: next(queue["batch"]))

    def recorded_normal(shape, dtype, device):
        drawn = next(queue["noise"])
        assert drawn.shape == shape
        return drawn.to(dtype)

    torch.distributions.normal._standard_normal = recorded_normal
    model.train(gradient_steps=BEFORE, batch_size=ROWS)

    optimizers = {"actor": model.actor.optimizer, "critic": model.critic.optimizer}
    for net in (model.actor, model.critic, model.critic_target):
        for p in net.parameters():
            to_float32(p)
    for optimizer in optimizers.values():
        for state in optimizer.state.values():
            to_float32(state["exp_avg"])
            to_float32(state["exp_avg_sq"])
    start = {name: layers(net, short) for name, net in networks(model)}
    adam = {
        name: {key: moments(net, optimizers[name.split("_")[0]], key) for key in ("exp_avg", "exp_avg_sq")}
        for name, net in networks(model)
        if not name.startswith("target")
    }
    steps = {int(s["step"]) for o in optimizers.values() for s in o.state.values()}
    assert steps == {BEFORE}
    alpha = model.ent_coef_optimizer.state[model.log_ent_coef]
    temperature = {
        "log_value": model.log_ent_coef.item(),
        "exp_avg": alpha["exp_avg"].item(),
        "exp_avg_sq": alpha["exp_avg_sq"].item(),
    }
    if dtype == torch.float32:
        model.policy.float()
        for optimizer in optimizers.values():
            for state in optimizer.state.values():
                state["exp_avg"], state["exp_avg_sq"] = state["exp_avg"].float(), state["exp_avg_sq"].float()
        for b in batches:
            for field in ("observations", "actions", "next_observations", "dones", "rewards"):
                setattr(b, field, getattr(b, field).float())
        model.log_ent_coef.data = model.log_ent_coef.data.float()
        alpha["exp_avg"], alpha["exp_avg_sq"] = alpha["exp_avg"].float(), alpha["exp_avg_sq"].float()
        torch.set_default_dtype(torch.float32)

    losses, ends = [], {}
    for update in range(1, UPDATES + 1):
        model.train(gradient_steps=1, batch_size=ROWS)
        logged = model.logger.name_to_value
        losses.append({k: float(logged[f"train/{k}"]) for k in ("critic_loss", "actor_loss", "ent_coef_loss", "ent_coef")})
        if update in (1, UPDATES):
            ends[update] = {
                "log_temperature": model.log_ent_coef.item(),
                "networks": {name: layers(net, digits) for name, net in networks(model)},
            }
    return start, adam, temperature, batches[BEFORE:], noise[2 * BEFORE :], losses, ends


def worst(losses, reference):
    return max(abs(a[k] / b[k] - 1) for a, b in zip(losses, reference) for k in b)


def main():
    *_, single_losses, _ = run(torch.float32)
    start, adam, temperature, batches, noise, losses, ends = run(torch.float64)
    single = worst(single_losses, losses)
    print(f"float32 run of the same updates: losses differ by {single:.1e}")
    write(
        "updates",
        f"Stable-Baselines3 {stable_baselines3.__version__}, PyTorch {torch.__version__}",
        "MIT (Stable-Baselines3), BSD-3-Clause (PyTorch)",
        {"losses": 1e-6, "parameters": 1e-5},
        "losses relative, parameters relative to their vector's norm; the reference is float64, and its own float32 run "
        f"of the same updates differs in the losses by {single:.1e}",
        {
            "settings": {**SETTINGS, "hidden": HIDDEN, "target_entropy": -float(ACTIONS)},
            "steps_before": BEFORE,
            "start": start,
            "adam": adam,
            "temperature": temperature,
            "batches": [
                {
                    "observations": b.observations.tolist(),
                    "actions": b.actions.tolist(),
                    "rewards": b.rewards.flatten().tolist(),
                    "next_observations": b.next_observations.tolist(),
                    "terminated": b.dones.flatten().tolist(),
                    "noise": torch.cat(noise[2 * i : 2 * i + 2]).tolist(),
                }
                for i, b in enumerate(batches)
            ],
            "losses": losses,
            "after": {str(k): v for k, v in ends.items()},
        },
    )


if __name__ == "__main__":
    main()
