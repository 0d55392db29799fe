"""Gradients of SAC-Discrete's three losses by float64 PyTorch autograd, for crates/rl.

The losses are written here from their equations (arXiv:1910.07207, section 3 and Algorithm 1), with sums over the
actions. Some rows are all but certain of an action, some terminate.
"""

import math

import torch
from torch import nn

from record import digits, grid, linears, short, to_float32, write

OBSERVED, ACTIONS, HIDDEN, ROWS = 3, 3, [32, 32], 64
DISCOUNT, TEMPERATURE, TARGET_ENTROPY = 0.97, 0.3, 0.6 * math.log(ACTIONS)


def mlp():
    widths = [OBSERVED, *HIDDEN, ACTIONS]
    layers = []
    for before, after in zip(widths, widths[1:]):
        layers += [nn.Linear(before, after), nn.ReLU()]
    return nn.Sequential(*layers[:-1])


def flat(net, of):
    return [{"weight": of(l.weight), "bias": of(l.bias)} for l in linears(net)]


def main():
    torch.set_default_dtype(torch.float64)
    torch.manual_seed(40)
    actor, critics, targets = mlp(), [mlp(), mlp()], [mlp(), mlp()]
    with torch.no_grad():
        linears(actor)[-1].weight.mul_(16)  # so that some actions are all but certain
    for net in (actor, *critics, *targets):
        for p in net.parameters():
            to_float32(p)

    observations = torch.randn(ROWS, OBSERVED)
    observations[::8] *= 20.0
    observations = grid(observations)
    next_observations = grid(observations + 0.1 * torch.randn(ROWS, OBSERVED))
    actions = torch.randint(ACTIONS, (ROWS,))
    rewards = grid(torch.randn(ROWS))
    terminated = (torch.rand(ROWS) < 0.2).double()
    log_temperature = torch.tensor(math.log(TEMPERATURE), requires_grad=True)

    log_probs = torch.log_softmax(actor(observations), 1)
    probs = log_probs.exp()
    with torch.no_grad():
        certain = int((probs.max(1).values > 1 - 1e-7).sum())
        assert min(certain, int(terminated.sum()), *torch.bincount(actions)) > 2, "the batch must reach every special case"
        next_log_probs = torch.log_softmax(actor(next_observations), 1)
        best = torch.minimum(*(t(next_observations) for t in targets))
        next_values = (next_log_probs.exp() * (best - TEMPERATURE * next_log_probs)).sum(1)
        y = rewards + DISCOUNT * (1 - terminated) * next_values

    temperature_loss = -(probs.detach() * log_temperature * (log_probs.detach() + TARGET_ENTROPY)).sum(1).mean()
    temperature_loss.backward()
    critic_loss = 0.5 * sum(((c(observations).gather(1, actions[:, None]).squeeze(1) - y) ** 2).mean() for c in critics)
    critic_loss.backward()
    critic_gradients = [flat(c, lambda p: digits(p.grad)) for c in critics]
    lesser = torch.minimum(*(c(observations) for c in critics)).detach()
    actor_loss = (probs * (TEMPERATURE * log_probs - lesser)).sum(1).mean()
    actor_loss.backward()

    write(
        "discrete",
        f"PyTorch {torch.__version__}",
        "BSD-3-Clause (PyTorch)",
        1e-5,
        "of the gradient's norm: float32 networks hold 1e-7 per operation, sums over 64 rows and 32 units lose about "
        "two digits of it; a wrong term shows at 1e-2 or more",
        {
            "discount": DISCOUNT,
            "temperature": TEMPERATURE,
            "target_entropy": TARGET_ENTROPY,
            "all_but_certain": certain,
            "actor": flat(actor, short),
            "critics": [flat(c, short) for c in critics],
            "targets": [flat(t, short) for t in targets],
            "observations": observations.tolist(),
            "actions": actions.double()[:, None].tolist(),
            "rewards": rewards.tolist(),
            "next_observations": next_observations.tolist(),
            "terminated": terminated.tolist(),
            "losses": {
                "temperature": temperature_loss.item(),
                "critic": critic_loss.item(),
                "actor": actor_loss.item(),
            },
            "temperature_gradient": log_temperature.grad.item(),
            "critic_gradients": critic_gradients,
            "actor_gradients": flat(actor, lambda p: digits(p.grad)),
        },
    )


if __name__ == "__main__":
    main()
