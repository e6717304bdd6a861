"""Run many environments as one gymnasium vector environment.

Without pictures, the environments are threads of this process. Pictures are drawn under the
interpreter lock, so with pictures each environment is a process of a fork server. After a plain
fork, drawing hangs.
"""

from __future__ import annotations

import multiprocessing
import os
from concurrent.futures import Future, ThreadPoolExecutor, wait
from functools import partial
from typing import Any

import gymnasium as gym
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv, VectorEnv
from gymnasium.vector.utils import iterate

from tissue_sim.environment import make_single
from tissue_sim.environment_options import BLIND_MODES
from tissue_sim.main_guard import require_main_guard


def make_vec(num_envs: int, *, obs_mode: str = "state", **options: Any) -> VectorEnv:
    """Make a vector environment of Calot-Cholecystectomy-v1.

    Args:
        num_envs: number of environments.
        obs_mode: "state", or a mode with pictures such as "rgb".
        options: further options of `gym.make`, the same for all.

    Raises:
        ValueError: `num_envs` is not a whole number from 1 on, or `gym.make` refuses an option.
        MainGuardError: processes are needed, and the script that calls this has no main guard.
    """
    if not isinstance(num_envs, int) or num_envs < 1:
        raise ValueError(f"num_envs = {num_envs!r} must be a whole number of 1 or more")
    makers = [partial(make_single, obs_mode=obs_mode, **options)] * num_envs
    if obs_mode in BLIND_MODES:
        return ThreadVectorEnv(makers)
    require_main_guard()
    multiprocessing.set_forkserver_preload(["tissue_sim.environment"])
    return AsyncVectorEnv(makers, context="forkserver")


class ThreadVectorEnv(SyncVectorEnv):
    """A `SyncVectorEnv` of gymnasium whose steps run on as many threads as there are cores."""

    def __init__(self, makers: list[Any], *, threads: int | None = None) -> None:
        self._pool = ThreadPoolExecutor(threads or len(os.sched_getaffinity(0)))
        self.envs: list[_Ahead]  # pyright: ignore[reportIncompatibleVariableOverride]
        super().__init__([partial(_Ahead, maker, self._pool) for maker in makers])

    def step(self, actions: Any) -> Any:
        """Advance every environment by one control period, or reset it if its episode has ended.

        Raises:
            ValueError: an action is invalid; the other environments have moved.
            ArithmeticError: an environment's tissue did not stay finite.
        """
        own = iterate(self.action_space, actions)
        for env, action, ended in zip(self.envs, own, self._autoreset_envs, strict=True):
            if not ended:
                env.begin(action)
        try:
            return super().step(actions)
        finally:
            for env in self.envs:
                env.forget()

    def close_extras(self, **kwargs: Any) -> None:
        """Stop the threads and close the environments."""
        self._pool.shutdown()
        super().close_extras(**kwargs)


class _Ahead(gym.Wrapper):
    """Begins a step on a thread; the next `step` waits for it and returns its result.

    If no step was begun, `step` takes one.
    """

    def __init__(self, maker: Any, pool: ThreadPoolExecutor) -> None:
        super().__init__(maker())
        self._pool = pool
        self._begun: Future[Any] | None = None

    def begin(self, action: Any) -> None:
        self._begun = self._pool.submit(self.env.step, action)

    def step(self, action: Any) -> Any:
        """Return the result of the step that was begun, or take a step.

        Raises:
            ValueError: the action is invalid; nothing has moved.
        """
        begun, self._begun = self._begun, None
        return self.env.step(action) if begun is None else begun.result()

    def forget(self) -> None:
        """Wait for a begun step whose result nobody has requested, and discard the result."""
        begun, self._begun = self._begun, None
        if begun is not None:
            wait([begun])
