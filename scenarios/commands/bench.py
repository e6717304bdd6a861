"""`calot bench`: measure a part of Calot; a new bench is a class in *_benches, and a line here."""

import os
from dataclasses import dataclass
from typing import Annotated

from tyro.conf import OmitSubcommandPrefixes, subcommand

from scenarios.commands.folder_options import require_kernel_cache
from scenarios.commands.policy_benches import (
    BenchController,
    BenchPlanner,
    Corrections,
    Distances,
    Faults,
    Obedience,
    Safety,
    WhatIf,
)
from scenarios.commands.world_benches import (
    Accuracy,
    BenchStack,
    BenchWorld,
    Parallel,
    Population,
    Robustness,
)

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


@dataclass(frozen=True, kw_only=True)
class Bench:
    """Measure a part of Calot on this machine."""

    part: OmitSubcommandPrefixes[
        Annotated[BenchWorld, subcommand("world")]
        | Annotated[BenchStack, subcommand("stack")]
        | Annotated[Accuracy, subcommand("accuracy")]
        | Annotated[Robustness, subcommand("robustness")]
        | Annotated[Parallel, subcommand("parallel")]
        | Annotated[Safety, subcommand("safety")]
        | Annotated[BenchController, subcommand("controller")]
        | Annotated[Obedience, subcommand("obedience")]
        | Annotated[BenchPlanner, subcommand("planner")]
        | Annotated[Corrections, subcommand("corrections")]
        | Annotated[WhatIf, subcommand("what-if")]
        | Annotated[Distances, subcommand("distances")]
        | Annotated[Population, subcommand("population")]
        | Annotated[Faults, subcommand("faults")]
    ]

    def execute(self) -> int:
        """Measure and report; return the part's exit code."""
        os.environ.update(dict.fromkeys(ONE_THREAD, "1"))  # read when the libraries are imported
        require_kernel_cache()
        return self.part.execute()
