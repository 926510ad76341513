"""The published systems, each an honest implementation of its method in the terms of the reports (GulliView 2024 and 2025)."""

from tests.bench.baselines.gulliview2023 import GulliView2023
from tests.bench.baselines.gulliview2024 import GulliView2024
from tests.bench.baselines.gulliview2025 import GulliView2025
from tests.bench.baselines.method import Baseline

__all__ = ["Baseline", "GulliView2023", "GulliView2024", "GulliView2025"]
