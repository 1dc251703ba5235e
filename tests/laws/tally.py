"""Seeds of the laws, and the book in which every comparison is entered."""

from __future__ import annotations

from dataclasses import dataclass, field

from tests.laws.model_failures import told_failure

# A law holds within this many units of eps cond: the solution's own sensitivity to its data is one unit, and
# the data, some hundred rounded operations each, are good to a few eps.
BOUND = 100.0
CHUNK = 10


def chunks(number: int) -> list[range]:
    """Seeds 0 .. number - 1 in chunks, so that tests can run side by side."""
    return [range(start, min(start + CHUNK, number)) for start in range(0, number, CHUNK)]


def name_of(seeds: range) -> str:
    """What a chunk is called among the cases of a test."""
    return f"{seeds.start}-{seeds.stop - 1}"


@dataclass(slots=True)
class Tally:
    """Errors in units of what rounding explains."""

    bound: float = BOUND
    entries: list[tuple[float, int, str]] = field(default_factory=list)

    def enter(self, seed: int, law: str, error: float | None) -> None:
        """Enter an error; None means that the law does not apply, NaN that it is broken."""
        if error is not None:
            self.entries.append((float(error) if error == error else float("inf"), seed, law))

    def close(self, title: str, *, may_be_empty: bool = False) -> None:
        """Print how many were compared, the share above one unit and the worst; assert that all hold."""
        if may_be_empty and not self.entries:
            return
        assert self.entries, "nothing was compared"
        worst = max(self.entries)
        share = sum(error > 1 for error, _, _ in self.entries) / len(self.entries)
        print(
            f"{title}: {len(self.entries)} compared, {share:.1%} above 1, worst {worst[0]:.2g} (seed {worst[1]}, {worst[2]})"
        )
        broken = sorted((entry for entry in self.entries if not entry[0] <= self.bound), reverse=True)
        told = [f"seed {seed}: {law}: {error:.3g}" for error, seed, law in broken[:12]]
        # The worst failure is kept as a model file; one is enough to work on.
        assert not broken, [*told, told_failure(broken[0][1])]
