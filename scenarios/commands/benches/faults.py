"""The bench that tampers with inputs, and with running commands."""

from dataclasses import dataclass
from typing import Annotated, Literal

from scenarios.commands.benches.show import show
from scenarios.commands.options.arguments import at_least
from scenarios.files.exit_codes import FAILED
from scenarios.files.outside_text import Terminal


@dataclass(frozen=True, kw_only=True)
class Faults:
    """Tamper with what Calot reads, by chance, and count how it ends."""

    kind: Literal["files", "texts", "clients", "processes"] = "files"
    """Which faults."""
    inputs: Annotated[int | None, at_least(1)] = None
    """Number of faults; by default 5000 files or texts, 500 clients of a page, 60 commands."""
    seed: Annotated[int, at_least(0)] = 0
    """Seed of the edits; an input of a seed is always the same."""

    def execute(self) -> int:
        """Try and report; return 1 if an input did harm."""
        from scenarios.bench.faults.kinds import KINDS
        from scenarios.bench.faults.trial import summary_lines, tally_table

        with Terminal(stderr=True).status("tampering"):
            kind = KINDS[self.kind]
            tallies = kind.tally(self.inputs or kind.inputs, self.seed)
        show([tally_table(tallies), *summary_lines(tallies)])
        return 0 if all(tally.is_good for tally in tallies.values()) else FAILED
