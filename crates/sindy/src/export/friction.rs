//! Steps with dry friction in Python.

use super::Friction;

/// Constants, and the functions `_part` and `step` over `_rates`, of equations with `k` controls; `parameters` are those of `step`.
pub(super) fn python(friction: &Friction, k: usize, parameters: &str) -> String {
    let list = |items: Vec<String>| format!("[{}]", items.join(", "));
    let speeds = list(friction.speeds().map(|i| i.to_string()).collect());
    let positions = list(friction.positions().map(|(j, i)| format!("({j}, {i})")).collect());
    let input = match k {
        0 => "np.zeros(x.shape[:-1] + (0,))".to_owned(),
        k => format!("np.broadcast_to(control, x.shape[:-1] + ({k},))"),
    };
    PYTHON
        .replace("{speeds}", &speeds)
        .replace("{positions}", &positions)
        .replace("{sweeps}", &Friction::SWEEPS.to_string())
        .replace("{settled}", &format!("{:?}", Friction::SETTLED))
        .replace("{substeps}", &friction.substeps.to_string())
        .replace("{input}", &input)
        .replace("{parameters}", parameters)
}

const PYTHON: &str = r#"# Speeds with dry friction, and the positions whose rate one of them is, each after its place there.
SPEEDS = {speeds}
POSITIONS = {positions}


def _part(x, u, h):
    """The state a time h later: Runge-Kutta with signs held; friction stops what turns, and holds what rests."""

    def rates(x, signs):
        return _rates(x, np.concatenate([u, signs], axis=-1))

    signs = np.sign(x[..., SPEEDS])
    k1 = rates(x, signs)
    k2 = rates(x + 0.5 * h * k1, signs)
    k3 = rates(x + 0.5 * h * k2, signs)
    k4 = rates(x + h * k3, signs)
    moved = x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    free = moved[..., SPEEDS]
    turns = ((signs == 0.0) | (free * signs < 0.0)).any(axis=-1, keepdims=True)
    if not turns.any():
        return moved
    # What the friction of each joint (last axis) takes from each speed, and the parts of it that act.
    none = np.zeros_like(signs)
    smooth = rates(x, none)
    taken = [h * (smooth - rates(x, none + one))[..., SPEEDS] for one in np.eye(len(SPEEDS))]
    own = np.stack([t[..., j] for j, t in enumerate(taken)], axis=-1)
    holds = own > 0.0
    own = np.where(holds, own, 1.0)
    parts, v = signs.copy(), free.copy()
    for _ in range({sweeps}):
        settled = True
        for j in range(len(SPEEDS)):
            wanted = np.clip(parts[..., j] + v[..., j] / own[..., j], -1.0, 1.0)
            change = np.where(holds[..., j], wanted - parts[..., j], 0.0)
            parts[..., j] += change
            v -= taken[j] * change[..., np.newaxis]
            settled = settled and not (turns[..., 0] & (np.abs(change) > {settled})).any()
        if settled:
            break
    v = np.where(holds & (np.abs(parts) < 1.0), 0.0, v)
    held = moved.copy()
    held[..., SPEEDS] = v
    for j, i in POSITIONS:
        stays = (signs[..., j] == 0.0) & (v[..., j] == 0.0)
        held[..., i] = np.where(stays, x[..., i], moved[..., i] + 0.5 * h * (v - free)[..., j])
    return np.where(turns, held, moved)


def step({parameters}):
    """The state one control interval later: Runge-Kutta with dry friction, u held."""
    state, control, out = _arguments(x, u)
    x = state + out
    u = {input}
    for _ in range({substeps}):
        x = _part(x, u, DT / {substeps})
    return x
"#;
