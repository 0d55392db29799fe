"""Controllers for tasks that files describe, and ends of episodes that data tell."""

import gymnasium
import numpy as np
import pytest

import sindyna

TASK = """
name = "cart"
{simulator}
max_steps = 60

[[state]]
name = "x"
start = [-1.0, 1.0]

[[state]]
name = "v"
start = [-0.5, 0.5]
rate_of = "x"

[[control]]
name = "u"
low = -1.0
high = 1.0

[task]
reward = "-next_x^2 - 0.05*v^2 - 0.01*u^2"
terminated = "abs(next_x) > 4"
"""

EQUATIONS = """dt = 0.1
[parameters]
c = 0.4
[equations]
v = "3*u - c*v"
"""


def task(simulator=""):
    """The text of a task file: keys of a table come after all others."""
    head, _, tables = TASK.partition("[[state]]")
    lines, _, equations = simulator.partition("[parameters]")
    text = head.format(simulator=lines)
    return text + (f"[parameters]{equations}" if equations else "") + "[[state]]" + tables


@pytest.fixture(scope="module")
def cart(tmp_path_factory):
    path = tmp_path_factory.mktemp("task") / "cart.toml"
    path.write_text(task(EQUATIONS), encoding="utf-8")
    return sindyna.learn(task_file=path, seed=1, evaluation_episodes=20)


def moved(x, u, n=200):
    """The state after 0.1 s, by small steps."""
    for _ in range(n):
        x = x + 0.1 / n * np.array([x[1] + 0.05 / n * (3 * u - 0.4 * x[1]), 3 * u - 0.4 * x[1]])
    return x


def test_a_task_file_gives_equations_policy_and_report(cart, tmp_path):
    assert cart.equations == ["(x)' = 1.000000 v", "(v)' = -0.400000 v + 3.000000 u"]
    assert cart.report_.certainty == "exact"
    assert cart.real_steps == 10
    assert len(cart.returns) == 20
    assert cart.predicted_return.low < cart.mean_return < cart.predicted_return.high
    assert cart.policy([0.5, 0.0])[0] < 0.0 < cart.policy([-0.5, 0.0])[0]
    cart.save(tmp_path / "cart.json")
    for one in (cart, sindyna.load(tmp_path / "cart.json")):
        env = one.env()
        env.reset(options={"state": [0.3, -0.2]})
        seen, paid, ended, *_ = env.step([0.5])
        expected = moved(np.array([0.3, -0.2]), 0.5)
        assert seen == pytest.approx(expected, abs=1e-3)
        assert paid == pytest.approx(-(seen[0] ** 2) - 0.05 * 0.04 - 0.01 * 0.25)
        assert not ended
        env.reset(options={"state": [3.99, 5.0]})
        assert env.step([0.0])[2]
    assert one.equations == cart.equations


def test_a_log_and_a_task_file_are_enough(tmp_path):
    path = tmp_path / "cart.toml"
    path.write_text(task(), encoding="utf-8")
    draw, x, u = np.random.default_rng(3), np.array([0.5, 0.0]), 0.0
    rows = []
    for i in range(200):
        u = float(draw.uniform(-1, 1)) if i % 5 == 0 else u
        rows.append((0.1 * i, *x, u))
        x = moved(x, u)
    log = tmp_path / "log.csv"
    np.savetxt(log, rows, delimiter=",", header="t,x,v,u", comments="", fmt="%.9g")
    pandas = pytest.importorskip("pandas")
    quick = {"seed": 1, "settings": ["optimality.max_updates=1000"]}
    controller = sindyna.learn(task_file=path, data=log, **quick)
    assert (controller.mean_return, controller.real_steps) == (None, 199)
    terms = {s.term: s.coefficient for s in controller.report_.equations[1].summands}
    assert terms["u"] == pytest.approx(3.0, rel=1e-2)
    assert terms["v"] == pytest.approx(-0.4, rel=1e-2)
    frame = pandas.read_csv(log)
    assert sindyna.learn(task_file=path, data=frame, **quick).equations == controller.equations
    # Rates that the file declares and the log does not have are those that were not measured.
    alone = sindyna.learn(task_file=path, data=frame.drop(columns="v"), **quick)
    terms = {s.term: s.coefficient for s in alone.report_.equations[1].summands}
    assert terms["u"] == pytest.approx(3.0, rel=2e-2)
    assert alone.policy([0.5, 0.0])[0] < 0.0


@pytest.mark.parametrize(
    ("kwargs", "match"),
    [
        ({"reward": "-x^2", "dt": 0.1}, "a task file says all of the task: reward, dt cannot be given"),
        ({"data": "no.csv", "model": "nowhere"}, "give one of them"),
        ({"model": "nowhere"}, "cannot read nowhere/config.toml"),
        ({"data": "no.csv"}, r"cannot read no\.csv"),
        ({"settings": ["sac.hiden=[4]"]}, "hiden"),
    ],
)
def test_what_a_task_file_does_not_go_with_is_refused(tmp_path, kwargs, match):
    path = tmp_path / "cart.toml"
    path.write_text(task(EQUATIONS if "settings" in kwargs else ""), encoding="utf-8")
    with pytest.raises(ValueError, match=match):
        sindyna.learn(task_file=path, **kwargs)
    with pytest.raises(ValueError, match="needs a task_file"):
        sindyna.learn("Pendulum-v1", model="nowhere")


class Rail(gymnasium.Env):
    """A cart that falls off its rail at 1.2 on either side; where it hits a bumper at -0.4, another way, it does not."""

    observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (2,), np.float64)
    action_space = gymnasium.spaces.Box(-1, 1, (1,), np.float32)
    dt = 0.1

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.x = self.np_random.uniform([-0.8, -1.0], [0.8, 1.0])
        return self.x.copy(), {}

    def step(self, action):
        paid = 1.0 - self.x[1] ** 2
        self.x = moved(self.x, float(np.clip(action[0], -1, 1)), n=20)
        return self.x.copy(), paid, bool(abs(self.x[0]) > 1.2), False, {}


def test_ends_are_found_where_the_data_tell_them():
    controller = sindyna.learn(Rail(), names=["x", "v"], max_steps=50, real_steps=400, seed=2, evaluation_episodes=20)
    sign, _, limit = controller.terminated.partition(" > ")
    assert sign == "abs(next_x)"
    assert float(limit) == pytest.approx(1.2, abs=0.05)
    assert controller.reward == "1 - v^2"
    assert any("an episode of the policy" in note for note in controller.notes)
    assert controller.mean_return > 40
    with pytest.raises(ValueError, match=r"do not determine where: \d ends"):
        sindyna.learn(Rail(), names=["x", "v"], max_steps=50, real_steps=150, seed=2)
