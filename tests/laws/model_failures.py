"""A law that is broken, as a small model in a file: what is kept of a failure."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import symbody as sb
from tests.laws.mechanisms import random_mechanism
from tests.laws.model_files import model_with_state
from tests.laws.model_laws import errors_of
from tests.laws.shrinking import CORPUS, shrunk, write_to_corpus

SECONDS = 60.0


def breaks(model: sb.Model, law: str) -> bool:
    """Whether a law of `model_laws` is broken; models whose equations cannot be formed or assembled break none."""
    try:
        return law in errors_of(model, only={law.partition(":")[0]}).broken
    except (sb.SymbodyError, np.linalg.LinAlgError):
        return False


def written_failure(
    model: sb.Model, what: str, seconds: float = SECONDS, folder: Path = CORPUS
) -> Path | None:
    """The file of a small model that breaks the same law as this one breaks most; None if it breaks none."""
    broken = errors_of(model).broken
    if not broken:
        return None
    law = max(broken, key=lambda word: broken[word])
    small = shrunk(model, lambda other: breaks(other, law), seconds)
    error = errors_of(small, only={law.partition(":")[0]}).broken.get(law, np.nan)
    comment = f"{law} were off by {error:.3g} times what rounding explains.\nShrunk from {what}."
    return write_to_corpus(small, law, what, comment, folder)


def told_failure(seed: int) -> str:
    """Where the failure of a random mechanism was written to, or why it was not."""
    try:
        path = written_failure(model_with_state(random_mechanism(seed)), f"random {seed}")
    except sb.SymbodyError as error:
        return f"seed {seed} could not be shrunk: as a model file it is refused: {error}"
    if path is None:
        return f"seed {seed} could not be shrunk: the failure does not show at the level of a model file"
    return f"seed {seed} shrunk to tests/corpus/{path.name}"
