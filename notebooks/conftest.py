"""All notebooks but one are slow: `make test-all` runs them."""

import pytest

SLOW = ("01_field_and_physics", "02_plan_and_act", "04_train", "05_results")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark them before what is marked slow is left out."""
    for item in items:
        if item.path.suffix == ".ipynb" and item.path.stem in SLOW:
            item.add_marker(pytest.mark.slow)
