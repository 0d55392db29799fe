"""Gradients of SAC's three losses by float64 PyTorch autograd, for crates/rl.

The losses are written here from their equations (arXiv:1812.05905, eqs. 5, 7, 18; log-std clamp and 1e-6 as common).
Some rows saturate tanh, some leave the range of the log standard deviation, some terminate.
"""

import math

import torch
from torch import nn

from record import digits, grid, linears, short, to_float32, write

OBSERVED, ACTIONS, HIDDEN, ROWS = 3, 2, [32, 32], 64
DISCOUNT, TEMPERATURE, TARGET_ENTROPY = 0.97, 0.3, -1.5


def mlp(inputs, outputs):
    widths = [inputs, *HIDDEN, outputs]
    layers = []
    for before, after in zip(widths, widths[1:]):
        layers += [nn.Linear(before, after), nn.ReLU()]
    net = nn.Sequential(*layers[:-1])
    for p in net.parameters():
        to_float32(p)
    return net


def draw(actor, observations, noise):
    mean, log_std = actor(observations).chunk(2, dim=1)
    log_std = log_std.clamp(-20, 2)
    u = mean + log_std.exp() * noise
    density = torch.distributions.Normal(mean, log_std.exp()).log_prob(u).sum(1)
    action = torch.tanh(u)
    return action, density - torch.log(1 - action**2 + 1e-6).sum(1)


def value(critic, observations, actions):
    return critic(torch.cat([observations, actions], 1)).squeeze(1)


def flat(layers, of):
    return [{"weight": of(l.weight), "bias": of(l.bias)} for l in layers]


def main():
    torch.set_default_dtype(torch.float64)
    torch.manual_seed(20)
    actor = mlp(OBSERVED, 2 * ACTIONS)
    with torch.no_grad():
        linears(actor)[-1].weight[ACTIONS:] *= 16  # so that some log standard deviations leave -20..2
    critics = [mlp(OBSERVED + ACTIONS, 1) for _ in range(2)]
    targets = [mlp(OBSERVED + ACTIONS, 1) for _ in range(2)]

    observations = torch.randn(ROWS, OBSERVED)
    observations[::8] *= 20.0
    observations = grid(observations)
    next_observations = grid(observations + 0.1 * torch.randn(ROWS, OBSERVED))
    actions = grid(torch.rand(ROWS, ACTIONS) * 2 - 1)
    rewards = grid(torch.randn(ROWS))
    terminated = (torch.rand(ROWS) < 0.2).double()
    noise = [grid(torch.randn(ROWS, ACTIONS)) for _ in range(2)]
    log_temperature = torch.tensor(math.log(TEMPERATURE), requires_grad=True)

    drawn, log_prob = draw(actor, observations, noise[0])
    with torch.no_grad():
        head = actor(observations)[:, ACTIONS:]
        clamped = [int((head < -20).sum()), int((head > 2).sum())]
        saturated = int((drawn.abs() > 1 - 1e-7).sum())
        assert min(*clamped, saturated, int(terminated.sum())) > 2, "the batch must reach every special case"
        next_drawn, next_log_prob = draw(actor, next_observations, noise[1])
        best = torch.minimum(*(value(t, next_observations, next_drawn) for t in targets))
        y = rewards + DISCOUNT * (1 - terminated) * (best - TEMPERATURE * next_log_prob)

    temperature_loss = -(log_temperature * (log_prob + TARGET_ENTROPY).detach()).mean()
    temperature_loss.backward()
    critic_loss = 0.5 * sum(((value(c, observations, actions) - y) ** 2).mean() for c in critics)
    critic_loss.backward()
    critic_gradients = [flat(linears(c), lambda p: digits(p.grad)) for c in critics]
    lesser = torch.minimum(*(value(c, observations, drawn) for c in critics))
    actor_loss = (TEMPERATURE * log_prob - lesser).mean()
    actor_loss.backward()

    write(
        "gradients",
        f"PyTorch {torch.__version__}",
        "BSD-3-Clause (PyTorch)",
        1e-5,
        "of the gradient's norm: float32 networks hold 1e-7 per operation, sums over 64 rows and 32 units lose about "
        "two digits of it; a wrong term shows at 1e-2 or more",
        {
            "discount": DISCOUNT,
            "temperature": TEMPERATURE,
            "target_entropy": TARGET_ENTROPY,
            "clamped_low_and_high": clamped,
            "saturated": saturated,
            "actor": flat(linears(actor), short),
            "critics": [flat(linears(c), short) for c in critics],
            "targets": [flat(linears(t), short) for t in targets],
            "observations": observations.tolist(),
            "actions": actions.tolist(),
            "rewards": rewards.tolist(),
            "next_observations": next_observations.tolist(),
            "terminated": terminated.tolist(),
            "noise": torch.cat(noise).tolist(),
            "losses": {
                "temperature": temperature_loss.item(),
                "critic": critic_loss.item(),
                "actor": actor_loss.item(),
            },
            "temperature_gradient": log_temperature.grad.item(),
            "critic_gradients": critic_gradients,
            "actor_gradients": flat(linears(actor), lambda p: digits(p.grad)),
        },
    )


if __name__ == "__main__":
    main()
