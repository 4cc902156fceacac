"""Forces on a rotor that depend on the motion of their sites otherwise than linearly.

All of them together, at all harmonics.

At each harmonic h of the rotation the sites are seen by their receptances at hΩ, with bearings, supports and linear forces as they
act there. A force that is alike in opposite directions on a motion that unbalance excites has odd harmonics.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from ksmea.nonlinear.contact import on_sites
from ksmea.nonlinear.laws import NonlinearLaw
from ksmea.nonlinear.steady_motion import SiteForce, SiteMotion, steady_force
from problems.rotor.extension.site_law import Force
from problems.rotor.finite_elements.assembly import assemble_free
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.response.dense import bearings_and_readings, dynamic_stiffness

AtOrder = Callable[[int], ComplexArray]


def with_nonlinear_forces(
    columns: ComplexArray,
    forces: Sequence[Force],
    seen: Sequence[Channel],
    speed: Array,
    at_order: AtOrder,
    near: ComplexArray | None = None,
) -> tuple[ComplexArray, ComplexArray | None]:
    """Motion (n, n_speed, n_seen, 1) with nonlinear forces acting, at all harmonics of the channels.

    `columns` (n, n_speed, n_seen, 1 + n_unit) are the motion without these forces and the responses to unit forces in x
    and y at all sites. `at_order` gives responses to the unit forces at another harmonic: of the seen channels, and
    behind them of the sites, (n, n_speed, n_seen + n_unit, n_unit). `near` (n_speed, n_order, n_unit) is a motion of
    the sites; the steady motion next to it is found.

    Also returns the motion of the sites, (n, n_speed, n_order, n_unit); None without forces. Raises `SettingError` if
    there are further columns: a nonlinear rotor has no response to loads alone.
    """
    if not forces:
        return columns, None
    sites = [site for site, _ in forces]
    laws = [site.law for site in sites if isinstance(site.law, NonlinearLaw)]
    rows = [seen.index(channel) for site in sites for channel in site.channels]
    if columns.shape[-1] > 1 + len(rows):
        raise SettingError(
            f"effects: expected a law that is linear in the motion together with loads, got {laws[0].name}"
        )
    orders = sorted({order for site in sites for order in site.orders} - {1})
    further = {order: at_order(order) for order in orders}
    alone = columns[:, :, rows, 0]
    begins = np.ones(alone.shape[:2]) if any(law.turns for law in laws) else _begins(alone)
    turned = begins[..., None, None] ** np.array([1, *further])[:, None]  # of each order
    motion = SiteMotion(
        speed,
        alone / begins[..., None],
        columns[:, :, rows, 1:],
        near=None if near is None else near / turned[:, :, : near.shape[1]],
        further={order: responses[:, :, len(seen) :] for order, responses in further.items()},
    )
    at_sites = [law for site, law in zip(sites, laws) for _ in site.positions]
    values = [coefficients for site, coefficients in forces for _ in site.positions]
    n_coefficient = [each.shape[1] for each in values]
    stiffens = np.stack([law.stiffens(coefficients) for law, (_, coefficients) in zip(laws, forces)])
    force = SiteForce(
        on_sites([law.on_orbit for law in at_sites], n_coefficient),
        np.concatenate(values, axis=1),
        _all_alike(stiffens),
        sites[0].goes_up,
        any(law.has_corners for law in laws),
    )
    found = steady_force(force, motion)
    acting = found.harmonics * turned
    moved = columns[..., :1] + columns[..., 1:] @ acting[:, :, 0, :, None]
    for index, responses in enumerate(further.values(), start=1):
        moved = moved + responses[:, :, : len(seen)] @ acting[:, :, index, :, None]
    return moved, found.motion * turned


def _begins(motion: ComplexArray) -> ComplexArray:
    """e^{iφ} of the largest coordinate of a motion (n, n_speed, m).

    Orbits are sampled from there on, so that forces do not depend on the phase origin.
    """
    largest = np.take_along_axis(motion, np.argmax(np.abs(motion), axis=-1)[..., None], axis=-1)[..., 0]
    return np.asarray(np.exp(1j * np.angle(largest)))


def responses_at_order(
    columns: ComplexArray, linear: Sequence[Force], n_seen: int, speed: Array, order: int
) -> ComplexArray:
    """Responses that `with_nonlinear_forces` requests at an order, with forces by linear laws acting.

    `columns` (n, n_speed, n_seen + n_unit, n_unit) are the responses without these forces to unit forces at the sites
    of linear laws and behind them of the others, seen by the channels and at the same sites.
    """
    for site, coefficients in linear:
        per_force, rows = columns[..., :2], columns[:, :, n_seen : n_seen + 2]
        columns = np.delete(np.delete(columns, (0, 1), axis=3), (n_seen, n_seen + 1), axis=2)
        if site.law.follows_motion:
            stiffness = np.stack([site.stiffness_at(each[None], speed, order) for each in coefficients])
            force = -np.linalg.solve(np.eye(2) + stiffness @ rows[..., :2], stiffness @ rows[..., 2:])
            columns = columns + np.delete(per_force, (n_seen, n_seen + 1), axis=2) @ force
    return columns


def dense_motion(
    rotor: Rotor,
    speed: Array,
    seen: tuple[Sequence[Channel], Sequence[Channel]],
    bearings: Callable[[float], ComplexArray],
    force: ComplexArray,
    forces: tuple[Sequence[Force], Sequence[Force]],
) -> ComplexArray:
    """Motion (n_speed, n_seen) of one set by solving with the whole dynamic stiffness.

    `force` (n_speed, n_dof) are nodal forces; `seen` are the channels by name and where their probes are; `bearings`
    gives impedances between all ports (n_port, n_port, n_speed) at a harmonic; `forces` are the forces that are linear
    in the motion, and the others.
    """
    (linear, nonlinear), (named, looking) = forces, seen
    free = assemble_free(rotor)
    sites = [site.rows(rotor) for site, _ in nonlinear]
    units = [np.broadcast_to(rows.T, (len(speed), *rows.T.shape)) for rows in sites]

    def stiffness_at(order: int) -> tuple[ComplexArray, ComplexArray]:
        """The dynamic stiffness, and rows of the channels."""
        of_bearings, rows_read = bearings_and_readings(rotor, speed, looking, bearings(order), order)
        stiffness = dynamic_stiffness(free, speed, order) + of_bearings
        for site, coefficients in linear:
            if site.law.follows_motion:
                rows = site.rows(rotor)
                stiffness = stiffness + rows.T @ site.stiffness_at(coefficients, speed, order) @ rows
        return stiffness, rows_read

    def at_order(order: int) -> ComplexArray:
        stiffness, rows_read = stiffness_at(order)
        at_sites = (np.broadcast_to(rows, (len(speed), *rows.shape)) for rows in sites)
        read = np.concatenate([rows_read, *at_sites], axis=1)
        return (read @ np.linalg.solve(stiffness, np.concatenate(units, axis=2)))[None]

    for site, coefficients in linear:
        force = force + site.at_rest(coefficients, speed) @ site.rows(rotor)
    stiffness, rows_read = stiffness_at(1)
    moved = np.linalg.solve(stiffness, np.concatenate([force[..., None], *units], axis=2))
    columns = (rows_read @ moved)[None]
    return with_nonlinear_forces(columns, nonlinear, named, speed, at_order)[0][0, :, :, 0]


def _all_alike(stiffens: Array) -> Array:
    """Which way forces (n_force, n) bend together, (n,); nan where they do not agree."""
    lowest, highest = stiffens.min(axis=0), stiffens.max(axis=0)
    return np.where(lowest * highest < 0, np.nan, lowest + highest).clip(-1, 1)
