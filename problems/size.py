"""How large a rotor model may be: what a slip of the pen makes of a file must neither fill the memory nor take hours.

A model takes a dynamic stiffness matrix of n_dof = 4 (n_element + 1) rows per speed, and n_dof³ operations to solve it.
"""

from __future__ import annotations

from ksmea.errors import SettingError
from problems.rotor.mesh import DOF_PER_NODE

MAX_ELEMENTS = 1000  # of a shaft; a detailed turbine model has a hundred
MAX_SPEEDS = 100_000
MAX_SUPPORTS = 200  # bearings, and as many unbalance planes
MAX_THINGS = 1000  # disks, probes, unknowns, materials: of each
MAX_ENTRIES = 2 * 10**7  # of all matrices, n_speed n_dof²: 1 GB while they are made
MAX_WORK = 2 * 10**10  # n_speed n_dof³: some 10 s


def check_size(n_element: int, n_speed: int) -> None:
    """Raise `SettingError` where a model with so many elements and speeds is larger than any use of it."""
    if n_element > MAX_ELEMENTS:
        raise SettingError(f"mesh: expected at most {MAX_ELEMENTS} elements in all, got {n_element}; take fewer")
    n_dof = DOF_PER_NODE * (max(n_element, 1) + 1)
    most = min(MAX_ENTRIES // n_dof**2, MAX_WORK // n_dof**3, MAX_SPEEDS)
    if n_speed > most:
        hint = "take fewer of either" if most else "take fewer elements"
        raise SettingError(f"speeds: expected at most {most} with {n_element} elements, got {n_speed}; {hint}")


def check_ports(n_element: int, n_speed: int, *, n_bearing: int, n_plane: int, n_probe: int) -> None:
    """Raise `SettingError` where the motions per force at all speeds would fill the memory."""
    n_row = max(DOF_PER_NODE * (n_element + 1), 2 * n_bearing + n_probe)
    most = MAX_ENTRIES // (n_row * (2 * n_bearing + n_plane))
    if n_speed > most:
        raise SettingError(
            f"speeds: expected at most {most} with {n_probe} probes, {n_bearing} bearings, {n_plane} planes, got {n_speed};"
            " take fewer of any"
        )
