"""Seeded trials: a scene with many vehicles, wrong clocks, a network that fails, minds that die and begin anew."""

from dataclasses import dataclass

import numpy as np

from agents.manoeuvres.traffic import ZoneMap
from launcher.manoeuvres.catalogue import SCENES, many
from launcher.manoeuvres.minds import Cooperative, Mind
from launcher.manoeuvres.network import Cut, Impairment
from launcher.manoeuvres.scenario import Entrant, Scenario
from launcher.manoeuvres.scene import Crash, Scene, SceneRun
from protocol.lab import SimulatedNetwork

TROUBLES = ("loss", "bursts", "cuts", "crashes", "all")
HEALS_S = 40.0
"""From here on the network is a good one."""
UNTIL_S = 160.0
MOST_VEHICLES = 8


@dataclass(frozen=True, slots=True)
class Trial:
    """One seed's: `trouble` is what goes wrong, `clocks_s` how far each vehicle's clock is wrong."""

    seed: int
    trouble: str
    scenario: Scenario
    impairment: Impairment
    crashes: tuple[Crash, ...]
    clocks_s: dict[str, float]


def draw_trial(seed: int) -> Trial:
    """Every fifth seed has the same trouble, every fifth five the same scene."""
    rng = np.random.default_rng([seed, 1])
    trouble = TROUBLES[seed % len(TROUBLES)]
    scene = SCENES[seed // len(TROUBLES) % len(SCENES)]
    scenario = many(scene, int(rng.integers(2, MOST_VEHICLES + 1)), seed)
    robots = [entrant.robot for entrant in scenario.entrants]
    network = SimulatedNetwork(delay_s=0.02)
    if trouble in ("loss", "bursts", "all"):
        network = SimulatedNetwork(
            loss=float(rng.uniform(0, 0.5)),
            delay_s=float(rng.uniform(0, 0.3)),
            jitter_s=float(rng.uniform(0, 0.1)),
            duplication=float(rng.uniform(0, 0.2)),
        )
    cuts: list[Cut] = []
    if trouble in ("bursts", "cuts", "all"):
        cuts += [Cut(start_s, start_s + 2.0) for start_s in rng.uniform(2, 30, 4).tolist()]
    if trouble in ("cuts", "all"):
        start_s = float(rng.uniform(2, 25))
        cuts.append(Cut(start_s, start_s + float(rng.uniform(2, 10)), _any(robots, rng), _any(robots, rng)))
    crashes: list[Crash] = []
    if trouble in ("crashes", "all"):
        crashes += [
            Crash(_any(robots, rng), at_s, at_s + float(rng.uniform(0.1, 6.0)))
            for at_s in rng.uniform(4, 30, 2).tolist()
        ]
    clocks_s = {robot: float(rng.normal(0.0, 0.5)) for robot in robots}
    return Trial(seed, trouble, scenario, Impairment(network, tuple(cuts), HEALS_S), tuple(crashes), clocks_s)


def conduct(trial: Trial) -> SceneRun:
    """The trial's run, until all are through or UNTIL_S."""

    def mind(scenario: Scenario, entrant: Entrant, zones: ZoneMap, now_s: float) -> Mind:
        return Cooperative(scenario, entrant, zones, now_s, clock_s=trial.clocks_s[entrant.robot])

    scene = Scene(trial.scenario, mind, impairment=trial.impairment, crashes=trial.crashes, seed=trial.seed)
    return scene.run(UNTIL_S)


def _any(robots: list[str], rng: np.random.Generator) -> str:
    return robots[int(rng.integers(len(robots)))]
