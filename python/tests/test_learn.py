"""Controllers: equations of environments, policies trained in them, returns on the real ones, learned models as environments."""

import json
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import sindyna
import sindyna.envs

FEW = {"evaluation_episodes": 20}


@pytest.fixture(scope="module")
def pendulum():
    return sindyna.learn("Pendulum-v1", seed=1, **FEW)


@pytest.fixture(scope="module")
def cart_pole():
    return sindyna.learn(
        "CartPole-v1",
        seed=1,
        angles=[2],
        reward="1",
        terminated="abs(next_x0) > 2.4 or abs(next_x2) > 0.20943951",
        **FEW,
    )


def test_a_pendulum_is_swung_up_after_ten_steps_with_a_reward_that_is_found(pendulum):
    assert pendulum.equations == ["(angle)' = 1.000000 x2", "(x2)' = 3.000000 u + 15.000000 sin(angle)"]
    assert pendulum.reward == "-angle^2 - 0.1*x2^2 - 0.001*u^2"
    assert (pendulum.real_steps, pendulum.resets) == (10, 21)
    assert len(pendulum.returns) == 20
    assert pendulum.mean_return > -230
    low, high, mean, level = pendulum.predicted_return
    assert low < mean < high
    assert level == 0.9
    # Upright and still, nothing is to be done; beside it, the torque goes against the lean.
    actions = pendulum.policy(
        np.array([[1.0, 0.0, 0.0], [np.cos(0.3), np.sin(0.3), 0.0], [np.cos(0.3), -np.sin(0.3), 0.0]])
    )
    assert actions.shape == (3, 1)
    assert abs(actions[0, 0]) < 1.0
    assert actions[1, 0] < -1.0 < 1.0 < actions[2, 0]
    assert pendulum.policy([1.0, 0.0, 0.0]) == pytest.approx(actions[0], abs=1e-6)


def test_equations_and_policy_are_written_as_a_program(pendulum, cart_pole, tmp_path):
    for controller, name in [(pendulum, "swing"), (cart_pole, "balance")]:
        path = tmp_path / f"{name}.py"
        text = controller.export("python", path)
        assert path.read_text(encoding="utf-8") == text
        module = {}
        exec(compile(text, str(path), "exec"), module)
        rng = np.random.default_rng(0)
        observations = rng.uniform(-1.0, 1.0, (50, controller.policy._inner.n_observations))
        actions = np.asarray(module["act"](observations)).reshape(50, -1)[:, 0]
        np.testing.assert_allclose(actions, np.asarray(controller.policy(observations)).reshape(50), atol=1e-5)
    assert "sindyna_act" in pendulum.export("c")
    graph = pendulum.export("onnx", tmp_path / "swing.onnx")
    assert (tmp_path / "swing.onnx").read_bytes() == graph
    assert b"Tanh" in (tmp_path / "swing.policy.onnx").read_bytes()
    with pytest.raises(ValueError, match="no language named `fortran`; known: `python`, `c`"):
        pendulum.export("fortran")


def test_numbered_actions_are_controlled(cart_pole):
    assert cart_pole.report_.certainty == "exact"
    assert cart_pole.solved
    assert cart_pole.mean_return >= 475
    assert cart_pole.policy([0.0, 0.0, 0.1, 1.0]) == 1
    assert cart_pole.policy([0.0, 0.0, -0.1, -1.0]) == 0
    assert cart_pole.policy(np.zeros((5, 4))).dtype == np.int64


def test_one_seed_one_controller(pendulum, tmp_path):
    pendulum.save(tmp_path / "a.json")
    sindyna.learn("Pendulum-v1", seed=1, **FEW).save(tmp_path / "b.json")
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()


def test_a_controller_survives_its_file(cart_pole, tmp_path):
    path = tmp_path / "controller.json"
    cart_pole.save(path)
    back = sindyna.load(path)
    seen = np.random.default_rng(0).uniform(-1, 1, size=(50, 4))
    assert (back.policy(seen) == cart_pole.policy(seen)).all()
    assert str(back) == str(cart_pole)
    assert back.equations == cart_pole.equations
    assert back.env().reset(seed=3)[0] == pytest.approx(cart_pole.env().reset(seed=3)[0], abs=0)
    document = json.loads(path.read_text(encoding="utf-8"))
    for broken in (
        "",
        "[]",
        {**document, "class": "SINDy"},
        {**document, "format": 9},
        {**document, "policy": "AAAA"},
        {"format": 1, "class": "controller"},
    ):
        path.write_text(broken if isinstance(broken, str) else json.dumps(broken), encoding="utf-8")
        with pytest.raises(ValueError, match=r"controller\.json"):
            sindyna.load(path)


def test_a_learned_model_steps_as_the_environment_does(pendulum, cart_pole):
    for controller, name in ((pendulum, "Pendulum-v1"), (cart_pole, "CartPole-v1")):
        real, model = gymnasium.make(name), controller.env()
        with warnings.catch_warnings():
            # Gymnasium warns of bounds that its own environments have.
            warnings.simplefilter("ignore", UserWarning)
            check_env(model, skip_render_check=True)
        first, _ = real.reset(seed=5)
        state = (
            np.array([np.arctan2(first[1], first[0]), first[2]])
            if name == "Pendulum-v1"
            else np.array(real.unwrapped.state)
        )
        shown, _ = model.reset(options={"state": state})
        assert shown == pytest.approx(first, abs=1e-6)
        assert shown.dtype == first.dtype
        model.action_space.seed(0)
        for _ in range(30):
            action = model.action_space.sample()
            (o, reward, ended, cut, _), (p, paid, over, out, _) = model.step(action), real.step(action)
            assert o == pytest.approx(p, abs=2e-4)
            assert reward == pytest.approx(paid, abs=1e-4)
            assert (ended, cut) == (over, out)
            if ended:
                break


def test_a_vector_of_learned_models_is_the_same_as_each_of_them(cart_pole):
    many, one = cart_pole.vector_env(3), cart_pole.env()
    seen, _ = many.reset(seed=7)
    first, _ = one.reset(seed=8)
    assert seen.shape == (3, 4)
    assert (seen[1] == first).all()
    ended = 0
    for step in range(60):
        seen, rewards, terminated, truncated, _ = many.step(np.full(3, step % 7 == 0, dtype=int))
        if ended:
            assert rewards[1] == 0.0
            assert not terminated[1]
            break
        o, reward, over, cut, _ = one.step(int(step % 7 == 0))
        assert (seen[1] == o).all()
        assert (rewards[1], terminated[1], truncated[1]) == (reward, over, cut)
        ended += over
    assert ended == 1


def test_functions_are_rewards_too():
    def reward(obs, action, next_obs):
        return 100.0 * (next_obs[:, 0] >= 0.45) - 0.1 * action[:, 0] ** 2

    controller = sindyna.learn(
        "MountainCarContinuous-v0",
        seed=1,
        reward=reward,
        terminated="next_x0 >= 0.45",
        settings=["optimality.trial_episodes=10"],
        **FEW,
    )
    assert controller.mean_return > 90
    assert controller.report_.certainty == "exact"
    assert controller.reward is None
    assert any("a step is taken as 1 s" in note for note in controller.notes)
    env = controller.env()
    env.reset(options={"state": [0.44, 0.05]})
    _, paid, ended, *_ = env.step([0.5])
    assert (paid, ended) == (pytest.approx(100 - 0.1 * 0.25), True)


def test_functions_without_comparisons_become_formulas(pendulum):
    def reward(obs, action, next_obs):
        return np.cos(0 * obs[:, 2]) * obs[:, 0] - 0.1 * np.square(obs[:, 2]) - 0.001 * (action**2).sum(axis=1)

    controller = sindyna.learn("Pendulum-v1", seed=1, reward=reward, **FEW)
    assert controller.reward.startswith("((")
    assert controller.terminated is None
    env = controller.env()
    env.reset(options={"state": [0.5, 2.0]})
    assert env.step([1.5])[1] == pytest.approx(np.cos(0.5) - 0.4 - 0.001 * 1.5**2)


def test_angles_behind_unnamed_values_have_names_of_their_own():
    env = gymnasium.make("Acrobot-v1")
    with pytest.raises(
        ValueError, match=r"named 'nothing'; variables: angle, x0, x1, angle2, x2, x3, x4, x5, u, next_angle"
    ):
        sindyna.learn(env, angles=[(0, 1), (2, 3)], real_steps=20, reward="nothing", start_resets=2)


class Slope(gymnasium.Env):
    """A ball on a slope that is tilted; paid as `pay` says."""

    observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (2,), np.float64)
    action_space = gymnasium.spaces.Box(-1, 1, (1,), np.float32)
    dt = 0.1

    def __init__(self, pay=lambda x, u: 0.0, ends=lambda x: False):
        self.pay, self.ends, self.x = pay, ends, np.zeros(2)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.x = self.np_random.uniform(-0.5, 0.5, size=2)
        return self.x.copy(), {}

    def step(self, action):
        push, paid = float(action[0]), self.pay(self.x, action[0])
        self.x = self.x + 0.1 * np.array([self.x[1], 2 * push - 0.3 * self.x[1]])
        return self.x.copy(), paid, bool(self.ends(self.x)), False, {}


@pytest.mark.parametrize(
    ("env", "kwargs", "match"),
    [
        (Slope(), {"max_steps": 50}, "reward was 0 in every step"),
        (Slope(lambda x, u: 1.0), {"max_steps": 50}, "nothing can be learned"),
        (Slope(lambda x, u: float(np.exp(np.sin(9 * x[0])))), {"max_steps": 50}, "no formula of few terms"),
        (Slope(lambda x, u: -(x[0] ** 2), lambda x: abs(x[1]) > 0.6), {"max_steps": 50}, "give terminated="),
        (Slope(lambda x, u: -(x[0] ** 2)), {}, "give max_steps="),
        (Slope(lambda x, u: -(x[0] ** 2)), {"max_steps": 50, "reward": "-y^2"}, "named 'y'"),
        (Slope(lambda x, u: -(x[0] ** 2)), {"max_steps": 50, "real_steps": 0}, "real_steps"),
        (Slope(lambda x, u: -(x[0] ** 2)), {"max_steps": 50, "start": {"q": (0, 1)}}, "no state is called 'q'"),
        (Slope(lambda x, u: -(x[0] ** 2)), {"max_steps": 50, "names": ["a"]}, "2 different names"),
        (Slope(lambda x, u: -(x[0] ** 2)), {"max_steps": 50, "settings": ["sac.hiden=[4]"]}, "hiden"),
    ],
)
def test_what_cannot_be_told_is_refused_with_advice(env, kwargs, match):
    with pytest.raises(ValueError, match=match):
        sindyna.learn(env, **kwargs)


def test_no_more_steps_are_made_than_are_allowed():
    env = Slope(lambda x, u: -(x[0] ** 2))
    controller = sindyna.learn(
        env,
        max_steps=50,
        real_steps=20,
        max_real_steps=20,
        reward="-x0^2",
        settings=["optimality.max_updates=500"],
        **FEW,
    )
    assert controller.real_steps == 20
    with pytest.raises(ValueError, match="max_real_steps must be a whole number of at least 20, got 10"):
        sindyna.learn(env, max_steps=50, real_steps=20, max_real_steps=10, reward="-x0^2")


class Walk(Slope):
    """Steps to four sides, or none."""

    action_space = gymnasium.spaces.Discrete(5, start=1)

    def step(self, action):
        assert self.action_space.contains(action)
        paid = -float(self.x @ self.x)
        self.x = self.x + 0.1 * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])[action - 1]
        return self.x.copy(), paid, False, False, {}


def test_many_numbered_actions_are_inputs_of_their_own():
    walk = sindyna.learn(Walk(), max_steps=40, real_steps=30, names=["x", "y"], seed=2, **FEW)
    assert walk.equations == ["(x)' = 1.000000 u0 + -1.000000 u1", "(y)' = 1.000000 u2 + -1.000000 u3"]
    assert walk.reward == "-x^2 - y^2"
    assert walk.real_steps == 30
    assert walk.policy([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]]).tolist() == [3, 2, 5, 4]
    env = walk.env()
    assert env.action_space == Walk.action_space
    env.reset(options={"state": [0.5, 0.5]})
    assert env.step(3)[0] == pytest.approx([0.4, 0.5])


def test_exceptions_of_environments_and_rewards_come_through():
    def broken(obs, action, next_obs):
        raise ZeroDivisionError("my own")

    with pytest.raises(ZeroDivisionError, match="my own"):
        sindyna.learn(Slope(), max_steps=50, reward=broken)
    with pytest.raises(ZeroDivisionError, match="division"):
        sindyna.learn(Slope(lambda x, u: 1 / 0), max_steps=50)


@pytest.mark.parametrize("name", ["Pendulum", "CartPole", "MountainCarContinuous"])
def test_systems_that_come_along_are_gymnasiums_step_for_step(name):
    theirs = gymnasium.make(f"{name}-{'v1' if name != 'MountainCarContinuous' else 'v0'}")
    ours = gymnasium.make(f"sindyna.envs:sindyna/{name}-v0")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        check_env(ours.unwrapped, skip_render_check=True)
    ours.action_space.seed(2)
    for seed in range(3):
        (o, _), (p, _) = ours.reset(seed=seed), theirs.reset(seed=seed)
        assert (o == p).all()
        assert o.dtype == p.dtype
        for _ in range(250):
            action = ours.action_space.sample()
            (o, reward, ended, cut, _), (p, paid, over, out, _) = ours.step(action), theirs.step(action)
            assert np.abs(o - p).max() <= 1e-6
            assert reward == pytest.approx(paid, abs=1e-6)
            assert (ended, cut) == (over, out)
            if ended or cut:
                break


def test_copies_of_a_system_that_comes_along_are_stepped_side_by_side():
    many = gymnasium.make_vec("sindyna/Pendulum-v0", num_envs=5)
    one = gymnasium.make("sindyna/Pendulum-v0")
    seen, _ = many.reset(seed=3)
    assert (seen[2] == one.reset(seed=5)[0]).all()
    for step in range(20):
        push = np.full((5, 1), np.sin(step), dtype=np.float32)
        assert (many.step(push)[0][2] == one.step(push[0])[0]).all()


def hinge(**kwargs):
    """A damped hinge in a plane without gravity, pushed by u."""
    return sindyna.System(
        ["th", "w"],
        {"th": "w", "w": "-0.4*w + 3*u"},
        {"u": (-1, 1)},
        "-th^2 - 0.05*w^2 - 0.01*u^2",
        {"th": (-1, 1), "w": (-0.5, 0.5)},
        **{"dt": 0.1, "max_steps": 60, **kwargs},
    )


def test_a_system_of_ones_own_moves_by_its_equations():
    env = hinge().env()
    env.reset(options={"state": [0.3, -0.2]})
    moved, paid, *_ = env.step([0.5])
    # The exact solution of w' = -0.4 w + 1.5.
    w = 3.75 + (-0.2 - 3.75) * np.exp(-0.04)
    th = 0.3 + 0.1 * 3.75 + (-0.2 - 3.75) * (1 - np.exp(-0.04)) / 0.4
    assert moved == pytest.approx([th, w], abs=1e-9)
    assert paid == pytest.approx(-0.09 - 0.05 * 0.04 - 0.01 * 0.25)
    shown, _ = hinge(angles=["th"]).env().reset(options={"state": [0.3, -0.2]})
    assert shown == pytest.approx([np.cos(0.3), np.sin(0.3), -0.2])
    counter = sindyna.System(
        ["n"], {"n": "n + u"}, {"u": (0, 2)}, "n", dt=1, map=True, terminated="next_n >= 3"
    ).vector_env(2)
    counter.reset(seed=0)
    assert [counter.step(np.full((2, 1), 2.0))[2].tolist() for _ in range(3)] == [[False] * 2, [True] * 2, [False] * 2]


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"equations": {"th": "w"}}, "equations must be of the states"),
        ({"equations": {"th": "w", "w": "-9.8*sin(q)"}}, "named 'q'"),
        ({"inputs": {"u": (1, 1)}}, "from low to high"),
        ({"inputs": {"th": (0, 1)}}, "different names"),
        ({"reward": "-x"}, "named 'x'"),
        ({"terminated": "next_th"}, "0 comparisons"),
        ({"angles": ["q"]}, "angles must be of the states"),
        ({"start": {"th": (1, 0)}}, "range of start values"),
    ],
)
def test_systems_that_cannot_be_are_refused(change, match):
    whole = {
        "states": ["th", "w"],
        "equations": {"th": "w", "w": "u"},
        "inputs": {"u": (-1, 1)},
        "reward": "-th^2",
        "dt": 0.1,
    }
    sindyna.System(**whole)
    with pytest.raises(ValueError, match=match):
        sindyna.System(**{**whole, **change})


def test_a_log_is_enough_for_a_controller():
    env, draw = hinge().env(), np.random.default_rng(4)
    samples, pushes = [env.reset(seed=1)[0]], []
    for step in range(40):
        pushes.append([draw.uniform(-1, 1) if step % 4 == 0 else pushes[-1][0]])
        samples.append(env.step(pushes[-1])[0])
    x, u = np.array(samples), np.array(pushes)
    told = {
        "dt": 0.1,
        "reward": "-x0^2 - 0.05*x1^2 - 0.01*u^2",
        "max_steps": 60,
        "start": {"x0": (-1, 1), "x1": (-0.5, 0.5)},
    }
    controller = sindyna.learn(data=(x, u), inputs={"u": (-1, 1)}, **told)
    assert controller.equations == ["(x0)' = 1.000000 x1", "(x1)' = -0.400000 x1 + 3.000000 u"]
    assert (controller.real_steps, len(controller.returns), controller.mean_return) == (40, 0, None)
    _low, _high, mean, _ = controller.predicted_return
    returns = []
    for seed in range(20):
        observation, _ = env.reset(seed=seed)
        paid, cut = 0.0, False
        while not cut:
            observation, reward, _, cut, _ = env.step(controller.policy(observation))
            paid += reward
        returns.append(paid)
    assert np.mean(returns) == pytest.approx(mean, rel=0.5)
    assert np.mean(returns) > -12
    for wrong, match in (({"reward": None}, "give reward="), ({"dt": None}, "dt"), ({"max_steps": None}, "max_steps")):
        with pytest.raises(ValueError, match=match):
            sindyna.learn(data=(x, u), **{**told, **wrong})
    with pytest.raises(ValueError, match="not both"):
        sindyna.learn("Pendulum-v1", data=(x, u))


def test_a_run_of_the_command_is_loaded(pendulum, tmp_path):
    own = pendulum._document
    model = json.dumps(own["model"])
    for symbol, name in (("x0", "θ"), ("x1", "ω"), ("u0", "u")):
        model = model.replace(symbol, name)
    summary = {**own["summary"], "task": "pendulum"}
    for name, content in (("model.json", model), ("summary.json", json.dumps(summary))):
        (tmp_path / name).write_text(content, encoding="utf-8")
    with pytest.raises(ValueError, match="no policy"):
        sindyna.load(tmp_path)
    (tmp_path / "policy.safetensors").write_bytes(pendulum.policy._inner.to_bytes())
    run = sindyna.load(tmp_path)
    assert run.policy([0.9, 0.1, 0.0]) == pendulum.policy([0.9, 0.1, 0.0])
    assert "reward: that of pendulum" in str(run)
    run.save(tmp_path / "run.json")
    assert sindyna.load(tmp_path / "run.json").equations == run.equations
    one, other = run.env(), pendulum.env()
    for env in (one, other):
        env.reset(options={"state": [0.5, 0.1]})
    assert one.step([1.0])[0] == pytest.approx(other.step([1.0])[0], abs=1e-6)
