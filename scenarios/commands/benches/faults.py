"""The bench of what must not hurt."""

from dataclasses import dataclass
from typing import Annotated, Literal

from scenarios.commands.benches.show import show
from scenarios.commands.options.arguments import at_least
from scenarios.files.exit_codes import FAILED
from scenarios.files.outside_text import Terminal


@dataclass(frozen=True, kw_only=True)
class Faults:
    """Tamper with what Calot reads, by chance, and count how it ends."""

    kind: Literal["files"] = "files"
    """Which faults."""
    inputs: Annotated[int, at_least(1)] = 5000
    """Number of tampered inputs."""
    seed: Annotated[int, at_least(0)] = 0
    """Seed of the edits; an input of a seed is always the same."""

    def execute(self) -> int:
        """Try and report; return 1 if an input hurt."""
        from scenarios.bench.faults.kinds import KINDS
        from scenarios.bench.faults.trial import summary_lines, tally_table

        with Terminal(stderr=True).status("tampering"):
            tallies = KINDS[self.kind](self.inputs, self.seed)
        show([tally_table(tallies), *summary_lines(tallies)])
        return 0 if all(tally.is_good for tally in tallies.values()) else FAILED
