"""Cases of a parametrised test that only `make test-all` runs."""

from typing import Any

import pytest


def slow(*case: Any) -> Any:
    """Return a case, marked as slow."""
    return pytest.param(*case, marks=pytest.mark.slow)
