"""Evolutions by other optimisers, recorded."""

import json

import numpy as np
import pytest

import oneiro


def recorder(exp, folder, **more):
    return oneiro.Recorder(exp, seed=5, out=folder / "recorded", optimiser="guesses 1.0", backend="cpu", **more)


def guesses(exp, generation):
    return np.random.default_rng(generation).uniform(-1, 1, (12, exp.genes)).astype(np.float32)


@pytest.mark.parametrize("common", [True, False])
def test_generations_are_recorded_and_live_again(avoidance, tmp_path, common):
    own = recorder(avoidance, tmp_path, episodes=2, common_starts=common)
    assert own.luckiest is None
    for generation in range(3):
        assert own.generation == generation
        outcome = own.evaluate(guesses(avoidance, generation))
        keys = [[generation, 0 if common else number] for number in range(12)]
        expected = oneiro.evaluate(
            avoidance, guesses(avoidance, generation), seed=5, keys=keys, episodes=2, backend="cpu"
        )
        assert np.array_equal(outcome.fitness, expected.fitness)
    again = oneiro.Recorder.open(own.path)
    genomes, fitness = again.recorded(2)
    assert np.array_equal(genomes, guesses(avoidance, 2)) and np.array_equal(fitness, outcome.fitness)
    scores = np.array(again.scores)
    best = again.luckiest
    assert (best.generation, best.individual) == np.unravel_index(scores.argmax(), scores.shape)
    assert np.array_equal(best.genome, guesses(avoidance, best.generation)[best.individual])
    assert again.audit(share=0.25) == {"individuals": 9, "episodes": 18}
    assert again.audit(share=1) == {"individuals": 36, "episodes": 72}
    about = json.loads((own.path / "recorder.json").read_text())
    assert about["optimiser"] == "guesses 1.0" and "not promised" in about["promise"]
    assert (own.path / "experiment.toml").read_text() == avoidance.to_toml()


def test_a_bit_that_differs_is_found(avoidance, tmp_path):
    own = recorder(avoidance, tmp_path)
    own.evaluate(guesses(avoidance, 0))
    genomes, fitness = own.recorded(0)
    fitness.view(np.uint32)[7, 0] ^= 1
    np.savez(own.path / "generation-000000.npz", genomes=genomes, fitness=fitness)
    with pytest.raises(oneiro.FailedError, match="generation 0, individual 7: .* are now"):
        own.audit(share=1)


def test_what_follows_a_saved_state_is_dropped(avoidance, tmp_path):
    own = recorder(avoidance, tmp_path)
    own.evaluate(guesses(avoidance, 0))
    own.save({"next": 1})
    own.evaluate(guesses(avoidance, 1))
    own.evaluate(guesses(avoidance, 2))
    again = oneiro.Recorder.open(own.path, backend="cpu")
    assert again.restore() == {"next": 1}
    assert again.generation == own.generation == 1


def test_what_is_wrong_is_said(avoidance, tmp_path):
    own = recorder(avoidance, tmp_path)
    with pytest.raises(oneiro.InputError, match="is not empty; allowed: a new directory"):
        recorder(avoidance, tmp_path)
    with pytest.raises(oneiro.InputError, match="allowed: after save"):
        own.restore()
    with pytest.raises(oneiro.InputError, match="doesn't exist; allowed: a directory of a Recorder"):
        oneiro.Recorder.open(tmp_path / "nothing")
    with pytest.raises(oneiro.InputError, match=r"have the shape \[5\]; allowed: \[n, genes\]"):
        own.evaluate(np.zeros(5))
    own.evaluate(guesses(avoidance, 0))
    with pytest.raises(oneiro.InputError, match="generation: is 1; allowed: 0 to 0"):
        own.recorded(1)
    with pytest.raises(oneiro.InputError, match="share: is 0; allowed"):
        own.audit(share=0)
    (own.path / "optimiser.pickle").write_bytes(b"\x80\x05")
    with pytest.raises(oneiro.CorruptError, match="is damaged"):
        own.restore()
    (own.path / "generation-000000.npz").write_bytes(b"PK")
    with pytest.raises(oneiro.CorruptError, match="is damaged"):
        own.recorded(0)
    (own.path / "generation-000000.npz").rename(own.path / "generation-000001.npz")
    with pytest.raises(oneiro.CorruptError, match="generations are missing"):
        own.audit()
