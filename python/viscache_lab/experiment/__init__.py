"""The frame of all experiments: declaration, registry, trial, runner, verdicts and pages."""

from viscache_lab.experiment.checks import Case, Check
from viscache_lab.experiment.claim_rules import Claim
from viscache_lab.experiment.registry import BENCHES, FAMILIES, FIGURES, Experiment, Registry
from viscache_lab.experiment.rows import Band, Row
from viscache_lab.experiment.trial import Trial

__all__ = [
    "BENCHES", "FAMILIES", "FIGURES", "Band", "Case", "Check", "Claim", "Experiment", "Registry",
    "Row", "Trial",
]  # fmt: skip
