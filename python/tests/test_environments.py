"""Environments: the simulator's lives, and the interfaces as their own checkers have them."""

import copy
import pickle
import re
import subprocess
import sys
import warnings

import gymnasium
import numpy as np
import pytest
from conftest import EXPERIMENTS
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

import oneiro
from oneiro.gym import Env, VectorEnv

MODES = list(AutoresetMode)


@pytest.fixture
def kheperax():
    """Lives in a maze, by three rays and two bumpers."""
    return oneiro.Experiment.load(EXPERIMENTS / "kheperax.toml", set={"cycles": 30})


@pytest.fixture
def ending():
    """Lives whose battery may run down at different times."""
    return oneiro.Experiment.load(EXPERIMENTS / "homing.toml")


def lives(exp, count, seed):
    """Traces and fitness of a controller."""
    genomes = np.random.default_rng(5).uniform(-3, 3, (count, exp.genes)).astype(np.float32)
    return oneiro.evaluate(exp, genomes, seed=seed, episodes=2, backend="cpu", traces=True)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", ["avoidance", "ending", "kheperax"])
def test_steps_are_a_controllers_life(name, mode, request):
    exp = request.getfixturevalue(name)
    count = 20
    outcome = lives(exp, count, 7)
    envs = VectorEnv(exp, count, mode)
    observations, infos = envs.reset(seed=7)
    assert infos == {}
    cycle, life = np.zeros(count, int), np.zeros(count, int)
    each, ended = np.arange(count), np.zeros((count, 2), bool)
    sensors = [column for column in outcome.traces.dtype.names if column.startswith("sensor_")]
    waits = np.zeros(count, bool)
    for step in range(10_000):
        # The observation, the action and the reward of each life that goes on; those of lives that have ended may be anything.
        living = (life < 2) & ~waits
        traces = outcome.traces[each, np.minimum(life, 1)]
        lengths = outcome.lengths[each, np.minimum(life, 1)]
        now = traces[each, np.minimum(cycle, traces.shape[1] - 1)]
        seen = np.stack([now[sensor] for sensor in sensors], axis=1)
        assert (observations[living] == seen[living]).all(), step
        told = 2.0 * np.stack([now["output_left"], now["output_right"]], axis=1).astype(np.float64) - 1.0
        observations, rewards, terminated, truncated, infos = envs.step(told)
        assert (rewards[living] == now["reward"][living]).all() and (rewards[waits] == 0).all()
        cycle[~waits] += 1
        done = terminated | truncated
        over = living & (cycle == lengths)
        assert (done[living] == over[living]).all() and not done[waits].any()
        for env in np.flatnonzero(over):
            final = infos["final_info"] if mode is AutoresetMode.SAME_STEP else infos
            assert final["_fitness"][env] and final["fitness"][env] == outcome.fitness[env, life[env]]
            assert terminated[env] == (lengths[env] < traces.shape[1]) == (not truncated[env])
            ended[env, life[env]] = True
        waits[:] = False
        if mode is AutoresetMode.DISABLED and done.any():
            with pytest.raises(oneiro.InputError, match="some episodes have ended"):
                envs.step(told)
            observations, _ = envs.reset(options={"reset_mask": done})
        if mode is AutoresetMode.NEXT_STEP:
            waits = done.copy()
        elif mode is AutoresetMode.SAME_STEP and done.any():
            assert (infos["_final_obs"] == done).all()
        life[done] += 1
        cycle[done] = 0
        if ended.all():
            break
    assert ended.all()
    if name == "ending":
        assert (outcome.lengths < outcome.traces.shape[2]).any()


def test_a_life_that_ends_in_its_last_cycle_is_terminated(ending):
    outcome = lives(ending, 20, 7)
    genome = int(np.argmin(outcome.lengths[:, 0]))
    length = int(outcome.lengths[genome, 0])
    assert length < outcome.traces.shape[2]
    short = oneiro.Experiment.load(EXPERIMENTS / "homing.toml", set={"cycles": length})
    envs = VectorEnv(short, 20, AutoresetMode.DISABLED)
    envs.reset(seed=7)
    for cycle in range(length):
        trace = outcome.traces[:, 0, cycle]
        told = 2.0 * np.stack([trace["output_left"], trace["output_right"]], axis=1).astype(np.float64) - 1.0
        _, _, terminated, truncated, _ = envs.step(told)
        assert (terminated[genome], truncated[genome]) == (cycle + 1 == length, False)
    assert truncated.any() and not (terminated & truncated).any()


def test_observations_are_new(kheperax):
    envs = VectorEnv(kheperax, 3)
    first, _ = envs.reset(seed=1)
    kept = first.copy()
    second, rewards, *_ = envs.step(envs.action_space.sample())
    rewards_kept = rewards.copy()
    envs.step(envs.action_space.sample())
    assert (first == kept).all() and (rewards == rewards_kept).all()
    assert not np.shares_memory(first, second)
    assert first.dtype == np.float32 and rewards.dtype == np.float64 and first in envs.observation_space


def test_seeds(avoidance):
    envs = VectorEnv(avoidance, 4)
    one, _ = envs.reset(seed=1)
    next_life, _ = envs.reset()
    again, _ = envs.reset(seed=1)
    assert (one == again).all() and (one != next_life).any() and len({row.tobytes() for row in one}) > 1
    # A list gives each environment the lives of a single one.
    listed, _ = envs.reset(seed=[5, 6, 5, None])
    env = Env(avoidance)
    assert (listed[0] == env.reset(seed=5)[0]).all() and (listed[2] == listed[0]).all()
    assert (listed[1] == env.reset(seed=6)[0]).all()
    other = VectorEnv(avoidance, 4)
    assert (other.reset()[0] != VectorEnv(avoidance, 4).reset()[0]).any()
    for seed in [-1, [1, 2], "x", 2**63]:
        with pytest.raises(oneiro.InputError):
            envs.reset(seed=seed)


class Refusing:
    """Native episodes on a device that has failed."""

    def __init__(self, native):
        self.native = native

    def __getattr__(self, name):
        return getattr(self.native, name)

    def step(self, *arguments):
        raise oneiro.InputError("refused")


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_what_is_refused_changes_nothing(mode):
    """Of two alike, one also gets seeds, actions and options that are refused, in turn and while some of its episodes have ended."""
    exp = oneiro.Experiment.load(EXPERIMENTS / "discrimination.toml", set={"cycles": 60})
    plain, disturbed = VectorEnv(exp, 6, mode), VectorEnv(exp, 6, mode)
    generator = np.random.default_rng(3)
    assert (plain.reset(seed=4)[0] == disturbed.reset(seed=4)[0]).all()
    partly_ended = 0
    for step in range(300):
        for refused in [np.full((6, 2), np.nan), np.zeros((5, 2))]:
            with pytest.raises(oneiro.InputError):
                disturbed.step(refused)
        if step % 50 == 0:
            none = np.zeros(6, bool)
            for wrong in [
                {"seed": [77, *[-1] * 5]},
                {"options": {"rest_mask": ~none}},
                {"options": {"reset_mask": none}},
            ]:
                with pytest.raises(oneiro.InputError):
                    disturbed.reset(**wrong)
        actions = generator.uniform(-1, 1, (6, 2))
        native = disturbed._episodes.native
        disturbed._episodes.native = Refusing(native)
        with pytest.raises(oneiro.InputError, match="refused"):
            disturbed.step(actions)
        disturbed._episodes.native = native
        told = [envs.step(actions) for envs in (plain, disturbed)]
        for one, other in zip(told[0][:4], told[1][:4], strict=True):
            assert (one == other).all(), step
        done = told[0][2] | told[0][3]
        partly_ended += int(done.any() and not done.all())
    assert partly_ended > 5
    # Episodes that go on keep their seed and number, whatever is given for them.
    mask = np.array([True, False, True, False, False, False])
    for envs, seed in [(plain, [9, None, 9, None, None, None]), (disturbed, 9 * np.ones(6, int))]:
        envs.reset(seed=seed, options={"reset_mask": mask})
    assert (plain.reset()[0] == disturbed.reset()[0]).all()


def test_rewards_are_the_change_of_a_score():
    exp = oneiro.Experiment.load(EXPERIMENTS / "road-sign.toml")
    envs = VectorEnv(exp, 8)
    envs.reset(seed=1)
    total, generator = np.zeros(8), np.random.default_rng(1)
    fitness = np.full(8, np.nan)
    while np.isnan(fitness).any():
        _, rewards, _, _, infos = envs.step(np.array([1.0, 1.0]) - generator.uniform(0, 0.3, (8, 2)))
        going = np.isnan(fitness)
        total[going] += rewards[going]
        if infos:
            ended = infos["_fitness"] & going
            fitness[ended] = infos["fitness"][ended]
    assert np.allclose(total, fitness, atol=1e-6) and (fitness > 0).any()


def test_a_robots_own_readings_are_0_to_1(avoidance, kheperax):
    for exp in (avoidance, kheperax):
        assert (Env(exp).observation_space.low == 0).all() and (Env(exp).observation_space.high == 1).all()
    # Its eight sensors, and custom ones.
    space = Env(oneiro.Experiment.example("homing")).observation_space
    assert (space.high[:8] == 1).all() and (space.high[8:] == 1000).all() and len(space.high) > 8


@pytest.mark.parametrize("name", ["automode-foraging", "evostick-foraging", "discrimination"])
def test_observations_are_in_their_space(name):
    exp = oneiro.Experiment.load(EXPERIMENTS / f"{name}.toml")
    if "robot.count" in exp.settings:
        from oneiro.pettingzoo import VectorEnv as Arenas

        envs = Arenas(exp, 2)
    else:
        envs = VectorEnv(exp, 2)
    space = envs.single_observation_space
    robots = (envs.robots,) if "robot.count" in exp.settings else ()
    generator = np.random.default_rng(1)
    observations, _ = envs.reset(seed=1)
    beyond = 0.0
    for _ in range(300):
        rows = observations.reshape(-1, observations.shape[-1])
        assert all(space.contains(row) for row in rows), rows
        beyond = max(beyond, np.abs(rows).max())
        observations = envs.step(generator.uniform(-1, 1, (2, *robots, 2)))[0]
    # Vectors of the reference model are longer than 1.
    assert (beyond > 1) == (name == "automode-foraging")


def test_what_is_refused(avoidance):
    envs = VectorEnv(avoidance, 2)
    with pytest.raises(oneiro.InputError, match="haven't begun"):
        envs.step(np.zeros((2, 2)))
    envs.reset(seed=1)
    with pytest.raises(oneiro.InputError, match=r"actions: have the shape \[2\]; allowed: \[2, 2\]"):
        envs.step(np.zeros(2))
    with pytest.raises(oneiro.InputError, match=r"actions\[0\]\[0\]: is nan; allowed: -1 to 1"):
        envs.step(np.full((2, 2), np.nan))
    with pytest.raises(oneiro.InputError, match="reset_mask"):
        envs.reset(options={"reset_mask": [True, False]})
    with pytest.raises(oneiro.InputError, match="num_envs: is 0"):
        VectorEnv(avoidance, 0)
    with pytest.raises(oneiro.InputError, match="is of the foraging study"):
        VectorEnv(oneiro.Experiment.load(EXPERIMENTS / "odowd2014-over.toml"))
    with pytest.raises(
        oneiro.InputError, match="is a swarm; allowed: single robots here, and swarms in oneiro.pettingzoo"
    ):
        VectorEnv(oneiro.Experiment.load(EXPERIMENTS / "aggregation.toml"))
    with pytest.raises(oneiro.InputError, match="actions: have the shape"):
        Env(avoidance).step(np.zeros(3))
    with pytest.raises(NotImplementedError):
        envs.set_attr("exp", [1, 2])


@pytest.mark.parametrize("name", ["avoidance", "ending", "kheperax"])
def test_gymnasiums_checker(name, request):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # It has no id to be made from.
        warnings.filterwarnings("ignore", message=".*environment.*spec.*|.*not.*gym.make.*")
        check_env(Env(request.getfixturevalue(name)), skip_render_check=True)


def test_vectors_of_gymnasium(kheperax):
    """Those of single environments, in this process and in others, step as ours do."""
    ours = VectorEnv(kheperax, 3)
    seeds = [4, 5, 6]
    expected, _ = ours.reset(seed=seeds)
    actions = [ours.action_space.sample() for _ in range(40)]
    steps = [ours.step(action) for action in actions]
    for kind in (gymnasium.vector.SyncVectorEnv, gymnasium.vector.AsyncVectorEnv):
        for context in [None] if kind is gymnasium.vector.SyncVectorEnv else ["fork", "spawn"]:
            more = {} if context is None else {"context": context}
            envs = kind([lambda: Env(kheperax)] * 3, **more)
            assert envs.single_observation_space == ours.single_observation_space
            assert (envs.reset(seed=seeds)[0] == expected).all()
            for action, step in zip(actions, steps, strict=True):
                observations, rewards, terminated, truncated, _ = envs.step(action)
                assert (observations == step[0]).all() and (rewards == step[1]).all()
                assert (terminated == step[2]).all() and (truncated == step[3]).all()
            envs.close()


def test_wrappers_of_gymnasium(kheperax):
    envs = gymnasium.wrappers.vector.RecordEpisodeStatistics(VectorEnv(kheperax, 2))
    envs.reset(seed=1)
    for _ in range(30):
        *_, infos = envs.step(envs.action_space.sample())
    assert infos["episode"]["l"].tolist() == [30, 30]


def test_outputs_that_become_actions_are_the_same_commands(kheperax):
    """Also as the least that isn't rounded, in another order of bytes and of axes; and only those actions are."""
    outputs = np.array([[2.0**-29, 0.3], [0.7, 1.0], [0.5, 0.0]], np.float32)
    told = 2.0 * outputs.astype(np.float64) - 1.0
    seen = []
    for actions in [told, told.tolist(), told.astype(">f8"), np.asfortranarray(told), np.nextafter(told, 0.0)[:, ::-1]]:
        envs = VectorEnv(kheperax, 3)
        envs.reset(seed=1)
        for _ in range(10):
            observations, *_ = envs.step(actions)
        seen.append([observations, np.stack(envs.get_attr("pose"))])
    for observations, poses in seen[1:4]:
        assert (observations == seen[0][0]).all() and (poses == seen[0][1]).all()
    assert (seen[4][1] != seen[0][1]).any()


def test_episodes_that_end_have_their_fitness_and_pose(kheperax):
    """The pose is where the episode's measures say that it ended."""
    genomes = np.random.default_rng(5).uniform(-3, 3, (6, kheperax.genes)).astype(np.float32)
    measures = ["end_x_mm", "end_y_mm"]
    outcome = oneiro.evaluate(kheperax, genomes, seed=7, descriptors=measures, traces=True, backend="cpu")
    for mode in MODES:
        envs = VectorEnv(kheperax, 6, mode)
        envs.reset(seed=7)
        for cycle in range(30):
            trace = outcome.traces[:, 0, cycle]
            told = 2.0 * np.stack([trace["output_left"], trace["output_right"]], axis=1).astype(np.float64) - 1.0
            *_, infos = envs.step(told)
        final = infos["final_info"] if mode is AutoresetMode.SAME_STEP else infos
        assert final["_pose"].all() and (final["pose"][:, :2] == outcome.descriptors[:, 0]).all()
        if mode is AutoresetMode.NEXT_STEP:
            assert envs.get_attr("fitness") == tuple(outcome.fitness[:, 0])
            assert (np.stack(envs.call("pose")) == final["pose"]).all()
    env = Env(kheperax)
    env.reset(seed=7)
    for cycle in range(30):
        trace = outcome.traces[0, 0, cycle]
        told = 2.0 * np.array([trace["output_left"], trace["output_right"]], np.float64) - 1.0
        *_, info = env.step(told)
    assert info["fitness"] == outcome.fitness[0, 0] and (info["pose"][:2] == outcome.descriptors[0, 0]).all()


def test_attributes_of_each(kheperax):
    envs = VectorEnv(kheperax, 3)
    envs.reset(seed=1)
    envs.step(envs.action_space.sample())
    assert envs.get_attr("cycles") == (1, 1, 1)
    assert envs.call("observation_space") == (envs.single_observation_space,) * 3
    assert envs.get_attr("exp") == (kheperax,) * 3 and envs.call("render") == (None,) * 3
    with pytest.raises(AttributeError):
        envs.get_attr("nothing")


def ids():
    return {name for name in gymnasium.registry if name.startswith("oneiro/")}


def test_ids_of_gymnasium(kheperax):
    """Each experiment that ships with a single robot has one."""
    single = []
    for path in EXPERIMENTS.glob("*.toml"):
        text = path.read_text()
        if "[swarm]" not in text and not is_swarm(text) and path.stem != "Cargo":
            single.append("".join(word.capitalize() for word in path.stem.split("-")))
    assert ids() == {f"oneiro/{name}-v0" for name in ["Experiment", *single]} and len(single) > 10
    env = gymnasium.make("oneiro/Kheperax-v0", set={"cycles": 30})
    assert env.unwrapped.exp == kheperax and (env.reset(seed=1)[0] == Env(kheperax).reset(seed=1)[0]).all()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make("oneiro/Kheperax-v0").unwrapped, skip_render_check=True)
    path = EXPERIMENTS / "kheperax.toml"
    envs = gymnasium.make_vec(
        "oneiro/Experiment-v0", num_envs=3, path=path, set={"cycles": 30}, autoreset_mode="SameStep"
    )
    assert isinstance(envs, VectorEnv) and envs.autoreset_mode is AutoresetMode.SAME_STEP
    assert (envs.reset(seed=4)[0] == VectorEnv(kheperax, 3).reset(seed=4)[0]).all()
    with pytest.raises(oneiro.InputError, match="allowed: one of `path` and `experiment`"):
        gymnasium.make("oneiro/Experiment-v0")
    code = "import gymnasium; print(gymnasium.make('oneiro.gym:oneiro/Kheperax-v0').spec.id)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "oneiro/Kheperax-v0\n"


def is_swarm(text):
    return re.search(r"^\[robot\]\n[^\[]*^count = ", text, re.MULTILINE) is not None


SWARMS = sorted(path.stem for path in EXPERIMENTS.glob("*.toml") if is_swarm(path.read_text()))


def test_there_are_swarms():
    assert len(SWARMS) >= 14


@pytest.mark.parametrize("name", SWARMS)
def test_a_swarms_controllers_have_its_fitness(name):
    """Controllers that stand alone, each with a robot's readings, have the fitness of the episode in the simulator."""
    exp = oneiro.Experiment.load(EXPERIMENTS / f"{name}.toml", set={"cycles": 45})
    # Each robot's controller is compiled.
    exp = exp.with_({"robot.count": min(exp.settings["robot.count"], 4)})
    arenas = 2
    limits = np.clip(exp.bounds, -4, 4)
    genomes = np.random.default_rng(5).uniform(*limits.T, (arenas, exp.genes)).astype(np.float32)
    expected = oneiro.evaluate(exp, genomes, seed=3, backend="cpu").fitness[:, 0]
    envs, env = oneiro.pettingzoo.VectorEnv(exp, arenas, "Disabled"), oneiro.pettingzoo.ParallelEnv(exp)
    observations, _ = envs.reset(seed=3)
    first, _ = env.reset(seed=3)
    assert (env.state() == envs.state()[0]).all() and env.state().any()
    controllers = [oneiro.Controller(exp, genomes, number=robot) for robot in range(envs.robots)]
    for controller in controllers:
        controller.reset(seed=3, keys=np.arange(arenas))
    fitness = {}
    while len(fitness) < arenas:
        outputs = np.stack([each.step(observations[:, robot]) for robot, each in enumerate(controllers)], axis=1)
        told = 2.0 * outputs.astype(np.float64) - 1.0
        if env.agents:
            assert (np.stack(list(first.values())) == observations[0]).all()
            first, alone, *_, info = env.step(dict(zip(env.agents, told[0], strict=True)))
        observations, rewards, terminated, truncated, infos = envs.step(told)
        assert 0 in fitness or list(alone.values()) == rewards[0].tolist()
        done = terminated | truncated
        if done.any():
            assert infos["pose"].shape == (arenas, envs.robots, 3)
            fitness |= {int(arena): infos["fitness"][arena] for arena in np.flatnonzero(done) if arena not in fitness}
            # The others go on; those that begin anew are not compared.
            observations, _ = envs.reset(options={"reset_mask": done})
    assert [fitness[arena] for arena in range(arenas)] == expected.tolist()
    assert info["robot_0"]["fitness"] == expected[0] and not env.agents


def test_rewards_of_robots():
    """A mission's rewards are everyone's; those of a task are each robot's; a score that is no sum of rewards rewards its changes."""

    def earned(name):
        exp = oneiro.Experiment.load(EXPERIMENTS / f"{name}.toml", set={"cycles": 60})
        envs = oneiro.pettingzoo.VectorEnv(exp, 4, "SameStep")
        envs.reset(seed=1)
        rng, sums = np.random.default_rng(1), np.zeros((4, envs.robots))
        for _ in range(60):
            *_, infos = (step := envs.step(rng.uniform(-1, 1, (4, envs.robots, 2))))
            sums += step[1]
        return sums, infos["final_info"]["fitness"]

    shared, fitness = earned("aggregation")
    assert (shared == shared[:, :1]).all() and np.allclose(shared[:, 0], fitness, rtol=1e-5) and (fitness < 0).all()
    exp = oneiro.Experiment.load(EXPERIMENTS / "evostick-foraging.toml", set={"cycles": 400})
    envs = oneiro.pettingzoo.VectorEnv(exp, 8, "SameStep")
    envs.reset(seed=1)
    sums = np.zeros((8, envs.robots))
    for cycle in range(400):
        told = np.full((8, envs.robots, 2), 1.0)
        told[:, :, 1] = 1.0 - 0.8 * (cycle // 40 % 2)
        *_, infos = (step := envs.step(told))
        sums += step[1]
    assert (sums.sum(axis=1) == infos["final_info"]["fitness"]).all() and sums.any() and (sums != sums[:, :1]).any()
    scored, fitness = earned("gather")
    assert (scored == scored[:, :1]).all() and scored.any() and (scored[:, 0] <= fitness).all()


def test_a_swarms_environment_passes_pettingzoos_tests():
    pettingzoo = pytest.importorskip("pettingzoo.test")
    exp = oneiro.Experiment.load(EXPERIMENTS / "gather.toml", set={"robot.count": 3, "cycles": 30})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pettingzoo.parallel_api_test(oneiro.pettingzoo.ParallelEnv(exp), num_cycles=70)
        pettingzoo.parallel_seed_test(lambda: oneiro.pettingzoo.ParallelEnv(exp), num_cycles=20)
    env = oneiro.pettingzoo.ParallelEnv(exp)
    env.reset(seed=1)
    assert env.state().shape == env.state_space.shape == (3, 3)
    assert env.possible_agents == ["robot_0", "robot_1", "robot_2"] and len(env.readings) == 4
    with pytest.raises(oneiro.InputError, match="allowed: ParallelEnv"):
        oneiro.pettingzoo.VectorEnv(oneiro.Experiment.load(EXPERIMENTS / "odowd2014-over.toml"))
    with pytest.raises(oneiro.InputError, match="it has a single robot, not a swarm"):
        oneiro.pettingzoo.VectorEnv(oneiro.Experiment.load(EXPERIMENTS / "kheperax.toml"))


def test_pettingzoos_tests():
    pettingzoo = pytest.importorskip("pettingzoo.test")
    exp = oneiro.Experiment.load(EXPERIMENTS / "odowd2014-over.toml", set={"swarm.robots": 3, "swarm.minutes": 1})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pettingzoo.parallel_api_test(oneiro.pettingzoo.ParallelEnv(exp), num_cycles=700)
        pettingzoo.parallel_seed_test(lambda: oneiro.pettingzoo.ParallelEnv(exp), num_cycles=20)
    env = oneiro.pettingzoo.ParallelEnv(exp)
    observations, _ = env.reset(seed=1)
    steps, earned = 0, 0.0
    while env.agents:
        observations, rewards, terminated, truncated, _ = env.step(
            {agent: np.array([0.8, 0.9 if observations[agent][:2].max() < 0.1 else -0.5]) for agent in env.agents}
        )
        steps += 1
        earned += sum(rewards.values())
        assert not any(terminated.values())
    assert steps == 600 and all(truncated.values())
    assert env.step({}) == ({}, {}, {}, {}, {})
    assert len(env.readings) == 13
    assert env.state().shape == (3, 3) and (np.abs(env.state()[:, :2]) > 1).any()
    first = env.reset(seed=1)[0]
    following, again = env.reset()[0], env.reset(seed=1)[0]
    assert any((first[agent] != following[agent]).any() for agent in env.agents)
    assert all((first[agent] == again[agent]).all() for agent in env.agents)
    with pytest.raises(oneiro.InputError, match="allowed: one for each of"):
        env.step({"robot_0": np.zeros(2)})
    with pytest.raises(oneiro.InputError, match="it has a single robot, not a swarm"):
        oneiro.pettingzoo.ParallelEnv(oneiro.Experiment.load(EXPERIMENTS / "kheperax.toml"))


def test_stable_baselines(kheperax):
    sb3 = pytest.importorskip("stable_baselines3")
    from stable_baselines3.common.env_checker import check_env as check
    from stable_baselines3.common.vec_env import SubprocVecEnv

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check(Env(kheperax))
    envs = oneiro.sb3.VecEnv(kheperax, 3)
    envs.seed(4)
    there = SubprocVecEnv([lambda: Env(kheperax)] * 3, start_method="spawn")
    there.seed(4)
    assert (envs.reset() == there.reset()).all()
    for _ in range(70):
        actions = np.stack([envs.action_space.sample() for _ in range(3)])
        ours, theirs = envs.step(actions), there.step(actions)
        for one, other in zip(ours[:3], theirs[:3], strict=True):
            assert (one == other).all()
        for one, other in zip(ours[3], theirs[3], strict=True):
            assert one.get("TimeLimit.truncated", False) == other["TimeLimit.truncated"]
            assert ("terminal_observation" in one) == ("terminal_observation" in other)
            if "terminal_observation" in one:
                assert (one["terminal_observation"] == other["terminal_observation"]).all()
    there.close()
    learner = sb3.PPO("MlpPolicy", envs, n_steps=32, batch_size=96, n_epochs=1, seed=1, device="cpu")
    learner.learn(192)
    assert learner.num_timesteps == 192


def test_experiments_pickle_in_environments(kheperax):
    env = Env(pickle.loads(pickle.dumps(kheperax)))
    assert (env.reset(seed=1)[0] == Env(kheperax).reset(seed=1)[0]).all()


def test_threads_wait_for_each_other(avoidance):
    """Objects that several threads use at once: each does what is asked, in some order."""
    import threading

    envs = VectorEnv(avoidance, 64)
    envs.reset(seed=1)
    evolution = oneiro.Evolution(avoidance, seed=1)
    controller = oneiro.Controller(avoidance, evolution.ask()[:8])
    failures, native = [], envs._episodes.native

    def work():
        try:
            for _ in range(15):
                native.step(None, np.zeros((64, 1, 2), np.float32), None)
                native.state()
                evolution.ask()
                evolution.state()
                controller.step(np.zeros((8, len(controller.inputs))))
        except Exception as error:
            failures.append(error)

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not failures
    assert (native.state()[3] == 60).all() and controller.cycle == 60


@pytest.mark.parametrize("name", ["discrimination", "khepera-sensor-noise", "map-maze", "aggregation"])
def test_environments_go_on_after_pickling(name):
    """A copy in the middle of an episode has the same future."""
    from oneiro import pettingzoo

    exp = oneiro.Experiment.load(EXPERIMENTS / f"{name}.toml")
    is_swarm = "robot.count" in exp.settings
    envs = (pettingzoo.VectorEnv if is_swarm else VectorEnv)(exp, 5)
    one = pettingzoo.ParallelEnv(exp) if is_swarm else Env(exp)
    shape = envs.action_space.shape
    generator = np.random.default_rng(2)

    def alone(actions):
        if is_swarm:
            return dict(zip(one.agents, actions[0], strict=True))
        return actions[0]

    envs.reset(seed=1)
    one.reset(seed=1)
    for _ in range(30):
        actions = generator.uniform(-1, 1, shape)
        envs.step(actions)
        one.step(alone(actions))
    for copied in (lambda it: pickle.loads(pickle.dumps(it)), copy.deepcopy):
        twin, other = copied(envs), copied(one)
        # The original goes on next to its copy.
        states = ([*own.native.state(), own.native.poses()] for own in (envs._episodes, twin._episodes))
        assert all((ours == theirs).all() for ours, theirs in zip(*states, strict=True))
        for _ in range(40):
            actions = generator.uniform(-1, 1, shape)
            for ours, theirs in zip(envs.step(actions)[:4], twin.step(actions)[:4], strict=True):
                assert (ours == theirs).all()
            ours, theirs = one.step(alone(actions))[0], other.step(alone(actions))[0]
            assert str(ours) == str(theirs)
    assert (envs.reset()[0] == twin.reset()[0]).all()


def test_vectors_of_swarms_have_what_vectors_have():
    from oneiro import pettingzoo

    exp = oneiro.Experiment.load(EXPERIMENTS / "aggregation.toml")
    envs = pettingzoo.VectorEnv(exp, 3, "SameStep")
    observations, _ = envs.reset(seed=1)
    robots, readings = envs.robots, len(envs.readings)
    assert envs.observation_space.shape == (3, robots, readings) == observations.shape
    assert envs.single_observation_space.shape == (readings,) and envs.single_action_space.shape == (2,)
    assert envs.action_space.shape == (3, robots, 2) and envs.action_space.contains(envs.action_space.sample())
    assert envs.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    envs.step(envs.action_space.sample())
    assert envs.get_attr("cycles") == (1, 1, 1) and envs.get_attr("pose")[2].shape == (robots, 3)
    assert (np.stack(envs.get_attr("pose")) == envs.state()).all()
    assert envs.call("robots") == (robots,) * 3 and envs.call("render") == (None,) * 3
    with pytest.raises(NotImplementedError):
        envs.set_attr("exp", [1, 2, 3])


WRONG = ["abc", object(), [[1, 2], [3]], {"a": 1}, 1j, np.zeros((2, 2), complex), np.array(["x"])]


@pytest.mark.parametrize("value", WRONG, ids=lambda value: str(type(value).__name__))
def test_values_of_other_kinds_are_refused_by_name(kheperax, value):
    genomes = np.zeros((2, kheperax.genes))
    env, envs = Env(kheperax), VectorEnv(kheperax, 2)
    env.reset(seed=1)
    envs.reset(seed=1)
    evolution = oneiro.Evolution(kheperax, seed=1)
    controller = oneiro.Controller(kheperax, genomes[0])
    calls = {
        "genomes": lambda: oneiro.evaluate(kheperax, value, seed=1),
        "seed": lambda: oneiro.evaluate(kheperax, genomes, seed=value),
        "keys": lambda: oneiro.evaluate(kheperax, genomes, seed=1, keys=value),
        "episodes": lambda: oneiro.evaluate(kheperax, genomes, seed=1, episodes=value),
        "descriptors": lambda: oneiro.evaluate(kheperax, genomes, seed=1, descriptors=value),
        "exp": lambda: oneiro.evaluate(value, genomes, seed=1),
        "fitness": lambda: evolution.tell(value),
        "actions": lambda: env.step(value),
        "actions of several": lambda: envs.step(value),
        "readings": lambda: controller.step(value),
        "num_envs": lambda: VectorEnv(kheperax, value),
        "exp of an environment": lambda: Env(value),
        "exp of an evolution": lambda: oneiro.Evolution(value, seed=1),
        "set": lambda: kheperax.with_(value),
    }
    for name, call in calls.items():
        if isinstance(value, dict) and name in ("genomes", "set"):
            continue
        with pytest.raises(oneiro.InputError, match=rf"^{name.split()[0]}\b"):
            call()
