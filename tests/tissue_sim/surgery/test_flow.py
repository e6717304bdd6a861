"""Tests of outflow: Poiseuille in a thin tube, an orifice at a hole, and both in series."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tissue_sim.surgery.flow import BILE, BLOOD, DISCHARGE, FlowSegment, Fluid, outflow_m3_s

PRESSURES_PA = st.floats(1.0, 3e4)
LENGTHS_M = st.floats(1e-4, 0.05)
AREAS_M2 = st.floats(1e-9, 1e-4)


@pytest.mark.parametrize("fluid", [BILE, BLOOD])
def test_a_thin_tube_obeys_poiseuille(fluid: Fluid) -> None:
    """Use a Reynolds number of 1e-3: the jet's share is 4 Re radius / length, about 1e-6."""
    radius, length, pressure = 2e-6, 0.02, 1e3
    expected = np.pi * radius**4 * pressure / (8 * fluid.viscosity_pa_s * length)
    way = [FlowSegment(length_m=length, area_m2=np.pi * radius**2)]
    assert outflow_m3_s(fluid, pressure, way) == pytest.approx(expected, rel=1e-4)


def test_a_hole_without_length_obeys_the_orifice_law() -> None:
    pressure, area = 1e3, 5e-6
    expected = DISCHARGE * area * np.sqrt(2 * pressure / BILE.density_kg_m3)
    way = [FlowSegment(length_m=0.0, area_m2=area)]
    assert outflow_m3_s(BILE, pressure, way) == pytest.approx(expected, rel=1e-12)


@given(pressure=PRESSURES_PA, stretches=st.lists(st.tuples(LENGTHS_M, AREAS_M2), min_size=1))
def test_the_losses_add_up_to_the_pressure(
    pressure: float, stretches: list[tuple[float, float]]
) -> None:
    way = [FlowSegment(length_m=length, area_m2=area) for length, area in stretches]
    rate = outflow_m3_s(BLOOD, pressure, way)
    friction = sum(8 * np.pi * BLOOD.viscosity_pa_s * n / a**2 * rate for n, a in stretches)
    speed = rate / (DISCHARGE * min(a for _, a in stretches))
    assert friction + 0.5 * BLOOD.density_kg_m3 * speed**2 == pytest.approx(pressure, rel=1e-9)


@given(pressure=PRESSURES_PA, length=LENGTHS_M, area=AREAS_M2, share=st.floats(0.05, 0.95))
def test_a_narrower_path_has_less_flow(
    pressure: float, length: float, area: float, share: float
) -> None:
    wide, narrow = (FlowSegment(length_m=length, area_m2=a) for a in (area, share * area))
    rates = [outflow_m3_s(BILE, pressure, way) for way in ([wide], [wide, narrow], [narrow])]
    assert rates[0] > rates[1]
    assert rates[0] > rates[2]
