"""Train a small policy that adapts period, lift and height on rough ground, and compare it with the fixed gait.

python examples/09_train_policy.py        # some ten minutes; writes policy.onnx for `gaitsmith walk --policy`

The cross-entropy method: draw policies, keep the best quarter, draw the next ones around these. Seeds of the final
comparison are never trained on.
"""

from pathlib import Path

import numpy as np

from gaitsmith.learning import GaitTemplateEnv, Perceptron, write_policy

TERRAIN = {"speed": (0.5, 0.0), "terrain": "boxes:0.09", "duration": 20.0}
HIDDEN = 2
HELD_OUT = 10_000  # seeds from here on are for the comparison
RANGES = {"period": (0.25, 0.45), "lift": (0.06, 0.2), "height": (0.6, 0.72)}


def walk(environment: GaitTemplateEnv, policy: Perceptron | None, seed: int) -> tuple[float, bool]:
    """Time that one episode walked, s, and whether it stood; without a policy the card's gait is kept."""
    seen, _ = environment.reset(seed=seed)
    gait = environment.seen.index(f"present.{environment.card.adjusted[0].name}")
    while True:
        action = seen[gait:] if policy is None else policy.act(seen.astype(float))
        seen, _, fell, over, info = environment.step(np.asarray(action, dtype=np.float32))
        if fell or over:
            return info["time"], not fell


def train(environment: GaitTemplateEnv, generations: int, population: int, episodes: int) -> Perceptron:
    """The mean policy after some generations."""
    card, random = environment.card, np.random.default_rng(0)
    size = Perceptron.size(card, HIDDEN)
    mean, spread = np.zeros(size), np.full(size, 0.1)
    spread[-len(card.adjusted) :] = 0.6  # the constant part counts most
    for generation in range(generations):
        drawn = mean + spread * random.standard_normal((population, size))
        seeds = range(generation * episodes, (generation + 1) * episodes)
        walked = np.array(
            [np.mean([walk(environment, Perceptron.of(card, HIDDEN, row), seed)[0] for seed in seeds]) for row in drawn]
        )
        best = drawn[np.argsort(-walked)[: max(2, population // 4)]]
        mean, spread = best.mean(axis=0), np.maximum(0.7 * spread, best.std(axis=0))
        print(f"generation {generation + 1}: walked {walked.mean():.2f} s on average, the best {walked.max():.2f} s")
    return Perceptron.of(card, HIDDEN, mean)


def main(
    generations: int = 5, population: int = 16, episodes: int = 6, held_out: int = 40, out: str = "policy.onnx"
) -> tuple[float, float]:
    environment = GaitTemplateEnv("bhr_b2", scenario=TERRAIN, adjust=tuple(RANGES), ranges=RANGES)
    policy = train(environment, generations, population, episodes)
    write_policy(out, policy)
    seeds = range(HELD_OUT, HELD_OUT + held_out)
    fixed, learned = (np.mean([walk(environment, which, seed)[1] for seed in seeds]) for which in (None, policy))
    print(f"stood on {held_out} grounds not trained on: fixed gait {fixed:.0%}, policy {learned:.0%}")
    print(f"gaitsmith walk --policy {Path(out).name} --terrain {TERRAIN['terrain']}")
    return float(fixed), float(learned)


if __name__ == "__main__":
    main()
