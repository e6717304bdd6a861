"""Check that an organ can be simulated: refuse broken elements and unsupported parts."""

from __future__ import annotations

import numpy as np

from tissue_sim.mechanics.topology import components
from tissue_sim.patient.mesh_checks import require_indices, require_sound_elements
from tissue_sim.patient.organ import Organ


def require_sound_organ(organ: Organ) -> None:
    """Refuse an organ that has broken elements or an unsupported part.

    Ties and strands join parts. A single body may be free. Of several parts, each must be joined to
    the rest, or attached at fixed vertices, at the liver bed or by the ligament.

    Raises:
        ValueError: the organ is refused; the message names the element or the part.
    """
    require_sound_elements(organ.vertices, organ.tets)
    n = len(organ.vertices)
    for name in ("tie_vertex", "tie_corners", "bed_vertices", "ligament_vertices", "remnants"):
        require_indices(name, getattr(organ, name), n, "tissue")
    ties = np.column_stack([organ.tie_vertex, organ.tie_corners[:, 0]]).reshape(-1, 2)
    joints = np.concatenate([ties, organ.remnants]).astype(np.int32)
    label = components(n, np.concatenate([organ.tets, joints[:, [0, 1, 1, 1]]]))
    held = set(label[organ.fixed].tolist()) | set(label[organ.anchored].tolist())
    loose = set(label.tolist()) - held
    if loose and len(set(label.tolist())) > 1:
        part = np.flatnonzero(label == min(loose))
        raise ValueError(
            f"mesh of the tissue: the part of {len(part)} vertices around vertex {part[0]} is "
            "neither held nor joined to the rest"
        )
