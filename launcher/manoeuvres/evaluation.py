"""How much longer vehicles take than alone: the report's FK (Gulliver 2025, eq. 4.1)."""

from dataclasses import dataclass

from launcher.manoeuvres.network import Impairment
from launcher.manoeuvres.scenario import Scenario
from launcher.manoeuvres.scene import Minds, Scene, SceneRun
from protocol.lab import SimulatedNetwork

RUNS = 10
UNTIL_S = 120.0
NORMAL = Impairment(SimulatedNetwork(delay_s=0.005, jitter_s=0.01, loss=0.01))
"""The laboratory's wireless network on a good day."""


@dataclass(frozen=True, slots=True)
class Delay:
    """Of one scenario: the quotient, of the vehicle that was delayed most, the least distance of outlines (m), and the last
    run."""

    fk: float
    robot: str
    gap_min_m: float
    contacts: int
    double_holds: int
    last: SceneRun


def delay(scenario: Scenario, minds: Minds, runs: int = RUNS) -> Delay:
    """FK = max(KF) / max(FFT) over the runs, of the vehicle for which it is largest."""
    met = [Scene(scenario, minds, impairment=NORMAL, seed=seed).run(UNTIL_S) for seed in range(runs)]
    quotients: dict[str, float] = {}
    for entrant in scenario.entrants:
        alone = scenario.alone(entrant.robot)
        free = [
            Scene(alone, minds, impairment=NORMAL, seed=seed).run(UNTIL_S).passings[entrant.robot].took_s
            for seed in range(runs)
        ]
        quotients[entrant.robot] = max(run.passings[entrant.robot].took_s for run in met) / max(free)
    worst = max(quotients, key=lambda robot: quotients[robot])
    return Delay(
        quotients[worst],
        worst,
        min(run.gap_min_m for run in met),
        sum(run.contacts for run in met),
        sum(run.double_holds for run in met),
        met[-1],
    )
