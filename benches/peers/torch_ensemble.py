"""An ensemble of networks in PyTorch, of the shape of `ensemble_speed`'s."""

import time

import torch
from torch.nn import functional

from .shared import tell

ROWS, EPOCHS, BATCH, INPUTS, TARGETS = 5120, 4, 256, 4, 4
PRESETS = {"paper": (5, torch.relu), "janner": (7, functional.silu)}
WIDTHS = [INPUTS, 200, 200, 200, 200, 2 * TARGETS]
DECAYS = [2.5e-5, 5e-5, 7.5e-5, 7.5e-5, 1e-4]
# The default is a loop over tensors; the better of the two is told.
ADAMS = {"plain": {}, "fused": {"fused": True}}


def wave(width, phase):
    return torch.sin(1.7 * torch.arange(ROWS * width, dtype=torch.float64) + phase).reshape(ROWS, width).float()


def torch_ensemble(preset):
    """Training examples per second of a plain ensemble, one thread.

    All members at once by torch.baddbmm on the CPU; an example is a row of one batch, of which every member sees one of its own.
    """
    torch.set_num_threads(1)
    torch.manual_seed(0)
    members, activation = PRESETS[preset]
    weights, biases = [], []
    for inputs, outputs in zip(WIDTHS, WIDTHS[1:]):
        reach = 1 / inputs**0.5
        weight = torch.nn.init.trunc_normal_(torch.empty(members, inputs, outputs), std=0.5 * reach, a=-reach, b=reach)
        weights.append(weight.requires_grad_())
        biases.append(torch.zeros(members, 1, outputs, requires_grad=True))
    high = torch.full((1, TARGETS), 0.5, requires_grad=True)
    low = torch.full((1, TARGETS), -10.0, requires_grad=True)
    groups = [{"params": [w], "weight_decay": d} for w, d in zip(weights, DECAYS)]
    groups += [{"params": [*biases, high, low], "weight_decay": 0.0}]
    inputs_table, targets_table = wave(INPUTS, 0.0), wave(TARGETS, 1.0)

    def loss_of(x, y):
        for weight, bias in zip(weights[:-1], biases[:-1]):
            x = activation(torch.baddbmm(bias, x, weight))
        mean, log_var = torch.baddbmm(biases[-1], x, weights[-1]).chunk(2, dim=-1)
        log_var = high - functional.softplus(high - log_var)
        log_var = low + functional.softplus(log_var - low)
        nll = ((mean - y).square() * torch.exp(-log_var) + log_var).mean(dim=(1, 2)).sum()
        return nll + 0.01 * (high.sum() - low.sum())

    def epochs(adam, count):
        samples = torch.randint(ROWS, (members, ROWS))
        for _ in range(count):
            for start in range(0, ROWS, BATCH):
                rows = samples[:, start : start + BATCH]
                adam.zero_grad()
                loss_of(inputs_table[rows], targets_table[rows]).backward()
                adam.step()
            samples = samples.gather(1, torch.rand(members, ROWS).argsort(dim=1))

    rates = {}
    for name, options in ADAMS.items():
        adam = torch.optim.Adam(groups, lr=1e-3, **options)
        epochs(adam, 1)
        start = time.perf_counter()
        epochs(adam, EPOCHS)
        rates[f"{name}_adam_per_s"] = ROWS * EPOCHS / (time.perf_counter() - start)
    parameters = sum(p.numel() for p in [*weights, *biases, high, low])
    tell(torch=torch.__version__, parameters=parameters, members=members, **rates)
