"""Many environments as one gymnasium vector environment.

Without pictures they are threads of this process. With pictures, which are drawn under the
interpreter lock, each is a process started by a fork server: after a plain fork, drawing hangs.
"""

from __future__ import annotations

import multiprocessing
import os
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from typing import Any

import gymnasium as gym
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv, VectorEnv
from gymnasium.vector.utils import iterate

from tissue_sim.environment import BLIND_MODES, make_single


def make_vec(num_envs: int, *, obs_mode: str = "state", **options: Any) -> VectorEnv:
    """Make a vector environment of Calot-Cholecystectomy-v1.

    Args:
        num_envs: how many.
        obs_mode: "state", or one with pictures such as "rgb".
        options: further options of `gym.make`, the same for all.
    """
    makers = [partial(make_single, obs_mode=obs_mode, **options)] * num_envs
    if obs_mode in BLIND_MODES:
        return ThreadVectorEnv(makers)
    multiprocessing.set_forkserver_preload(["tissue_sim.environment"])
    return AsyncVectorEnv(makers, context="forkserver")


class ThreadVectorEnv(SyncVectorEnv):
    """gymnasium's `SyncVectorEnv`, whose steps run on as many threads as there are cores."""

    def __init__(self, makers: list[Any], *, threads: int | None = None) -> None:
        self._pool = ThreadPoolExecutor(threads or len(os.sched_getaffinity(0)))
        self.envs: list[_Ahead]  # pyright: ignore[reportIncompatibleVariableOverride]
        super().__init__([partial(_Ahead, maker, self._pool) for maker in makers])

    def step(self, actions: Any) -> Any:
        """Advance every environment by one control period, or reset it if its episode has ended."""
        own = iterate(self.action_space, actions)
        for env, action, ended in zip(self.envs, own, self._autoreset_envs, strict=True):
            if not ended:
                env.begin(action)
        return super().step(actions)

    def close_extras(self, **kwargs: Any) -> None:
        """End the threads and the environments."""
        self._pool.shutdown()
        super().close_extras(**kwargs)


class _Ahead(gym.Wrapper):
    """Begins a step on a thread; the step that follows waits for it."""

    def __init__(self, maker: Any, pool: ThreadPoolExecutor) -> None:
        super().__init__(maker())
        self._pool = pool
        self._answer: Future[Any]

    def begin(self, action: Any) -> None:
        self._answer = self._pool.submit(self.env.step, action)

    def step(self, action: Any) -> Any:
        return self._answer.result()
