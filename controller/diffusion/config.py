"""The configuration of a diffusion policy; it is saved in the checkpoint."""

from __future__ import annotations

from dataclasses import dataclass

from planner.learning.sizes import Layers, SomeSteps, Steps, Width

WORDS_SIZE = 384  # of a sentence's embedding
PROCEDURE = "clip and cut both tubes"  # the only text that a wordless policy hears


@dataclass(frozen=True, kw_only=True)
class PolicyConfig:
    """Shapes; times are in control steps.

    Attributes:
        horizon: length of a chunk.
        history: how long ago each observed frame was, the present one (0) first.
        past: how many motions before a chunk are an input.
        play: how many motions of a chunk are played before the next chunk takes over.
        max_delay: the most motions that are played while the next chunk is computed; they are
            the last ones of the past.
        sampling_steps: denoising steps of one chunk.
        wordless: it hears no instructions: SRT-H's ablation "no hierarchy".
        condition_width, condition_blocks: of the encoder of observations and words.
        denoiser_width, denoiser_blocks: of the denoiser.

    Raises:
        ValueError: the shapes do not fit together.
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

    def heard(self, text: str) -> str:
        """Return the text that the policy hears of an instruction."""
        return PROCEDURE if self.wordless else text
