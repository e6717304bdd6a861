"""Define the configuration of a diffusion policy, which is saved in the checkpoint."""

from __future__ import annotations

from dataclasses import dataclass

from planner.learning.networks import Layers, SomeSteps, Steps, Weight, Width

WORDS_SIZE = 384  # of a sentence's embedding
PROCEDURE = "clip and cut both tubes"  # the only command that a wordless policy gets


@dataclass(frozen=True, kw_only=True)
class PolicyConfig:
    """Shapes of a policy; times are in control steps.

    Attributes:
        horizon: Length of a chunk.
        history: Age of each observed frame, the present one (0) first.
        past: Number of motions before a chunk that are an input.
        play: Number of motions of a chunk that are played before the next chunk takes over.
        max_delay: Largest number of motions that are played while the next chunk is computed. These
            motions are the last ones of the past.
        sampling_steps: Number of denoising steps of one chunk.
        guidance: Weight of classifier-free guidance (Ho and Salimans, arXiv 2207.12598): how far a
            chunk goes beyond the commanded one, away from the one without a command. 0 is none.
        wordless: The policy gets no instructions: SRT-H's ablation "no hierarchy".
        condition_width, condition_blocks: Sizes of the encoder of observations and words.
        denoiser_width, denoiser_blocks: Sizes of the denoiser.

    Raises:
        ValueError: The shapes do not fit together.
    """

    horizon: Steps = 16
    history: tuple[Steps, ...] = (0, 3)
    past: Steps = 5
    play: Steps = 6
    max_delay: Steps = 4
    sampling_steps: SomeSteps = 2
    condition_width: Width = 512
    condition_blocks: Layers = 2
    denoiser_width: Width = 256
    denoiser_blocks: Layers = 2
    guidance: Weight = 0.0
    wordless: bool = False

    def __post_init__(self) -> None:
        if not self.history or self.history[0] != 0 or min(self.history) < 0:
            raise ValueError(f"history must begin with the present frame, 0; got {self.history}")
        if not 0 <= self.max_delay <= min(self.past, self.play):
            raise ValueError(
                f"max_delay must be 0 to {min(self.past, self.play)}, as no more motions are given"
                f" with a chunk or played of one; got {self.max_delay}"
            )
        if not 1 <= self.play <= self.horizon:
            raise ValueError(f"play must be 1 to {self.horizon} motions, got {self.play}")
