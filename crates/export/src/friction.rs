//! Steps with dry friction: what each language writes after its function of the rates over signs that are given.

use sindyna_sindy::export::Friction;

/// What the places `{name}` of a text are filled with.
struct Places(Vec<(&'static str, String)>);

impl Places {
    /// What is the same in all languages: `joined` writes an array.
    fn of(friction: &Friction, joined: fn(&[String]) -> String) -> Self {
        let speeds: Vec<String> = friction.speeds().map(|i| i.to_string()).collect();
        Self(vec![
            ("joints", friction.joints.len().to_string()),
            ("speeds", joined(&speeds)),
            ("substeps", friction.substeps.to_string()),
            ("sweeps", Friction::SWEEPS.to_string()),
            ("settled", format!("{:?}", Friction::SETTLED)),
        ])
    }

    fn with(mut self, name: &'static str, text: impl Into<String>) -> Self {
        self.0.push((name, text.into()));
        self
    }

    fn fill(self, text: &str) -> String {
        self.0.iter().fold(text.to_owned(), |text, (name, by)| text.replace(&format!("{{{name}}}"), by))
    }
}

/// A line for each position, which `line` writes of the number of its joint and its own.
fn positions(friction: &Friction, line: fn(usize, usize) -> String) -> String {
    friction.positions().map(|(j, i)| format!("        {}\n", line(j, i))).collect()
}

/// The body of `sindyna_step` in C over `sindyna_rates_held`; `dt` is the control interval and `pass` what rates are given first.
pub(super) fn c(friction: &Friction, dt: &str, pass: &str) -> String {
    let line = |j: usize, i: usize| {
        format!(
            "next[{i}] = sign[{j}] == 0.0 && v[{j}] == 0.0 ? before[{i}] : next[{i}] + 0.5 * h * (v[{j}] - loose[{j}]);"
        )
    };
    let places = Places::of(friction, |speeds| format!("{{ {} }}", speeds.join(", ")));
    places.with("positions", positions(friction, line)).with("dt", dt).with("pass", pass).fill(C)
}

const C: &str = "    enum { JOINTS = {joints} };
    /* Speeds with dry friction. Their signs are held over a part; friction stops what turns, and holds what rests. */
    static const int speed[JOINTS] = {speeds};
    double k1[STATES], k2[STATES], k3[STATES], k4[STATES], at[STATES], before[STATES], with[INPUTS + JOINTS];
    double taken[JOINTS][JOINTS], sign[JOINTS], acts[JOINTS], v[JOINTS], loose[JOINTS];
    const double h = {dt} / {substeps};
    int part, sweep, moves, i, j;
    for (i = 0; i < STATES; i++) next[i] = x[i];
    for (i = 0; i < INPUTS; i++) with[i] = u[i];
    for (part = 0; part < {substeps}; part++) {
        for (i = 0; i < STATES; i++) before[i] = next[i];
        for (j = 0; j < JOINTS; j++) with[INPUTS + j] = sign[j] = sign_of(next[speed[j]]);
        sindyna_rates_held({pass}next, with, k1);
        for (i = 0; i < STATES; i++) at[i] = next[i] + 0.5 * h * k1[i];
        sindyna_rates_held({pass}at, with, k2);
        for (i = 0; i < STATES; i++) at[i] = next[i] + 0.5 * h * k2[i];
        sindyna_rates_held({pass}at, with, k3);
        for (i = 0; i < STATES; i++) at[i] = next[i] + h * k3[i];
        sindyna_rates_held({pass}at, with, k4);
        for (i = 0; i < STATES; i++) next[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        moves = 0;
        for (j = 0; j < JOINTS; j++) {
            acts[j] = sign[j];
            v[j] = loose[j] = next[speed[j]];
            if (sign[j] == 0.0 || v[j] * sign[j] < 0.0) moves = 1;
            with[INPUTS + j] = 0.0;
        }
        if (!moves) continue;
        /* What the friction of joint j takes from speed i, and the part of it that acts. */
        sindyna_rates_held({pass}before, with, k1);
        for (j = 0; j < JOINTS; j++) {
            with[INPUTS + j] = 1.0;
            sindyna_rates_held({pass}before, with, k2);
            with[INPUTS + j] = 0.0;
            for (i = 0; i < JOINTS; i++) taken[i][j] = h * (k1[speed[i]] - k2[speed[i]]);
        }
        for (sweep = 0; moves && sweep < {sweeps}; sweep++) {
            moves = 0;
            for (j = 0; j < JOINTS; j++) {
                double wanted, change;
                if (!(taken[j][j] > 0.0)) continue;
                wanted = acts[j] + v[j] / taken[j][j];
                wanted = wanted < -1.0 ? -1.0 : wanted > 1.0 ? 1.0 : wanted;
                change = wanted - acts[j];
                acts[j] = wanted;
                for (i = 0; i < JOINTS; i++) v[i] -= taken[i][j] * change;
                if (fabs(change) > {settled}) moves = 1;
            }
        }
        for (j = 0; j < JOINTS; j++) {
            if (taken[j][j] > 0.0 && fabs(acts[j]) < 1.0) v[j] = 0.0;
            next[speed[j]] = v[j];
        }
{positions}    }
";

/// The body of `step` in JavaScript over `ratesHeld`.
pub(super) fn javascript(friction: &Friction) -> String {
    let line = |j: usize, i: usize| {
        format!("x[{i}] = sign[{j}] === 0.0 && v[{j}] === 0.0 ? before[{i}] : x[{i}] + 0.5 * h * (v[{j}] - free[{j}]);")
    };
    let places = Places::of(friction, |speeds| format!("[{}]", speeds.join(", ")));
    places.with("positions", positions(friction, line)).fill(JAVASCRIPT)
}

const JAVASCRIPT: &str = "    // Speeds with dry friction. Their signs are held over a part; friction stops what turns, and holds what rests.
    const speeds = {speeds};
    const h = DT / {substeps};
    const ahead = (x, by, k) => x.map((value, i) => value + by * k[i]);
    for (let part = 0; part < {substeps}; part++) {
        const before = x;
        const sign = speeds.map((i) => Math.sign(x[i]));
        const held = [...u, ...sign];
        const k1 = ratesHeld(x, held);
        const k2 = ratesHeld(ahead(x, 0.5 * h, k1), held);
        const k3 = ratesHeld(ahead(x, 0.5 * h, k2), held);
        const k4 = ratesHeld(ahead(x, h, k3), held);
        x = x.map((value, i) => value + (h / 6.0) * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        const free = speeds.map((i) => x[i]);
        if (!sign.some((s, j) => s === 0.0 || free[j] * s < 0.0)) continue;
        // What the friction of joint j takes from speed i, and the part of it that acts.
        const smooth = ratesHeld(before, [...u, ...speeds.map(() => 0.0)]);
        const taken = speeds.map((_, j) => {
            const rubbed = ratesHeld(before, [...u, ...speeds.map((_, i) => (i === j ? 1.0 : 0.0))]);
            return speeds.map((i) => h * (smooth[i] - rubbed[i]));
        });
        const v = free.slice();
        const acts = sign.slice();
        for (let sweep = 0, moves = true; moves && sweep < {sweeps}; sweep++) {
            moves = false;
            for (let j = 0; j < v.length; j++) {
                if (!(taken[j][j] > 0.0)) continue;
                const wanted = Math.min(Math.max(acts[j] + v[j] / taken[j][j], -1.0), 1.0);
                const change = wanted - acts[j];
                acts[j] = wanted;
                for (let i = 0; i < v.length; i++) v[i] -= taken[j][i] * change;
                if (Math.abs(change) > {settled}) moves = true;
            }
        }
        speeds.forEach((i, j) => {
            if (taken[j][j] > 0.0 && Math.abs(acts[j]) < 1.0) v[j] = 0.0;
            x[i] = v[j];
        });
{positions}    }
    return x;
";

/// The body of `step` in Rust over `rates_held`.
pub(super) fn rust(friction: &Friction) -> String {
    let line = |j: usize, i: usize| {
        format!(
            "x[{i}] = if sign[{j}] == 0.0 && v[{j}] == 0.0 {{ before[{i}] }} else {{ x[{i}] + 0.5 * h * (v[{j}] - free[{j}]) }};"
        )
    };
    let places = Places::of(friction, |speeds| format!("[{}]", speeds.join(", ")));
    places.with("positions", positions(friction, line)).fill(RUST)
}

const RUST: &str = "    const JOINTS: usize = {joints};
    // Speeds with dry friction. Their signs are held over a part; friction stops what turns, and holds what rests.
    const SPEEDS: [usize; JOINTS] = {speeds};
    let h = DT / {substeps} as f64;
    let ahead = |x: &[f64; N], by: f64, k: &[f64; N]| -> [f64; N] { std::array::from_fn(|i| x[i] + by * k[i]) };
    let with = |signs: &[f64; JOINTS]| -> [f64; K + JOINTS] { std::array::from_fn(|i| if i < K { u[i] } else { signs[i - K] }) };
    let mut x = *x;
    for _ in 0..{substeps} {
        let before = x;
        let sign: [f64; JOINTS] = std::array::from_fn(|j| sign_of(x[SPEEDS[j]]));
        let held = with(&sign);
        let k1 = rates_held(&x, &held);
        let k2 = rates_held(&ahead(&x, 0.5 * h, &k1), &held);
        let k3 = rates_held(&ahead(&x, 0.5 * h, &k2), &held);
        let k4 = rates_held(&ahead(&x, h, &k3), &held);
        x = std::array::from_fn(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        let free: [f64; JOINTS] = std::array::from_fn(|j| x[SPEEDS[j]]);
        if !(0..JOINTS).any(|j| sign[j] == 0.0 || free[j] * sign[j] < 0.0) {
            continue;
        }
        // What the friction of joint j takes from speed i, and the part of it that acts.
        let smooth = rates_held(&before, &with(&[0.0; JOINTS]));
        let taken: [[f64; JOINTS]; JOINTS] = std::array::from_fn(|j| {
            let rubbed = rates_held(&before, &with(&std::array::from_fn(|i| if i == j { 1.0 } else { 0.0 })));
            SPEEDS.map(|i| h * (smooth[i] - rubbed[i]))
        });
        let (mut v, mut acts) = (free, sign);
        for _ in 0..{sweeps} {
            let mut moves = false;
            for j in (0..JOINTS).filter(|j| taken[*j][*j] > 0.0) {
                let wanted = (acts[j] + v[j] / taken[j][j]).clamp(-1.0, 1.0);
                let change = wanted - acts[j];
                acts[j] = wanted;
                (0..JOINTS).for_each(|i| v[i] -= taken[j][i] * change);
                moves |= change.abs() > {settled};
            }
            if !moves {
                break;
            }
        }
        for j in 0..JOINTS {
            if taken[j][j] > 0.0 && acts[j].abs() < 1.0 {
                v[j] = 0.0;
            }
            x[SPEEDS[j]] = v[j];
        }
{positions}    }
    x
";

/// The body of the function that makes `F` in CasADi, over `held`: in a graph every sweep is made, of one joint one.
pub(super) fn casadi(friction: &Friction) -> String {
    let line = |j: usize, i: usize| {
        format!(
            "after[{i}] = ca.if_else(turns, ca.if_else(ca.logic_and(sign[{j}] == 0.0, v[{j}] == 0.0), at[{i}], after[{i}] + 0.5 * h * (v[{j}] - free[{j}])), after[{i}])"
        )
    };
    let sweeps = if friction.joints.len() == 1 { 1 } else { Friction::SWEEPS };
    let places = Places::of(friction, |speeds| format!("[{}]", speeds.join(", ")));
    let places = places.with("positions", positions(friction, line)).with("made", sweeps.to_string());
    places.fill(CASADI)
}

const CASADI: &str =
    "    # Speeds with dry friction. Their signs are held over a part; friction stops what turns, and holds what rests.
    speeds = {speeds}
    joints = {joints}
    v, acts, taken = ca.SX.sym(\"v\", joints), ca.SX.sym(\"acts\", joints), ca.SX.sym(\"taken\", joints, joints)
    swept, acting = ca.SX(v), ca.SX(acts)
    for j in range(joints):
        holds = taken[j, j] > 0.0
        wanted = ca.fmin(ca.fmax(acting[j] + swept[j] / ca.if_else(holds, taken[j, j], 1.0), -1.0), 1.0)
        change = ca.if_else(holds, wanted - acting[j], 0.0)
        acting[j] += change
        swept -= taken[:, j] * change
    sweep = ca.Function(\"sweep\", [v, acts, taken], [swept, acting])
    h = DT / {substeps}
    for _ in range({substeps}):
        sign = ca.sign(at[speeds])
        given = ca.vertcat(u, sign)
        k1 = held(at, given)
        k2 = held(at + 0.5 * h * k1, given)
        k3 = held(at + 0.5 * h * k2, given)
        k4 = held(at + h * k3, given)
        after = at + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        free = after[speeds]
        turns = ca.mmax(ca.logic_or(sign == 0.0, free * sign < 0.0))
        # What the friction of joint j takes from speed i, and the part of it that acts.
        smooth = held(at, ca.vertcat(u, ca.MX.zeros(joints)))
        unit = ca.DM.eye(joints)
        taken = ca.horzcat(*[h * (smooth - held(at, ca.vertcat(u, unit[:, j])))[speeds] for j in range(joints)])
        v, acts = free, sign
        for _ in range({made}):
            v, acts = sweep(v, acts, taken)
        rests = ca.logic_and(ca.diag(taken) > 0.0, ca.fabs(acts) < 1.0)
        v = ca.if_else(rests, 0.0, v)
{positions}        after[speeds] = ca.if_else(turns, v, free)
        at = after
";
