"""A rotor with all its effects: impedances of its bearings, forces on it, readings of its probes.

Values of all unknowns are rows of x (n, d), SI: first the rotor's own unknowns, then the unknowns of each effect.
"""

from __future__ import annotations

import itertools
from collections import OrderedDict
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from ksmea.numerics.differences import recent
from ksmea.problem.load import Load
from problems.rotor.extension.changed_rotor import ChangedRotor
from problems.rotor.extension.hooks import RotorHooks
from problems.rotor.extension.local_change import LocalChanges, most_kept
from problems.rotor.extension.run_up import Sweep
from problems.rotor.extension.site_law import Force, SiteLaw, split_by_law, with_linear_forces
from problems.rotor.finite_elements.bearing import Support, in_series_with, ports_on
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.loads import unit_loads
from problems.rotor.response.links import Impedance
from problems.rotor.response.model import impedances_of
from problems.rotor.response.receptance import (
    FactoredShaft,
    Reduction,
    ShaftMotion,
    at_harmonic,
    reduce_rotor,
    shaft_motion,
)
from problems.rotor.response.unknowns import Inputs

MAX_REDUCTIONS = 64  # kept of rotors that an effect has changed
MAX_LOCAL = 2  # kept of rotors that are also seen from where effects change them
MAX_MOTIONS = 2  # kept of whole shafts: large ones have 100 MB


@dataclass(frozen=True, eq=False)
class RotorWithEffects(ChangedRotor):
    """A rotor and effects, by their hooks (`problems/rotor/extension/hooks.py`)."""

    def channels_with(self, changing: Array) -> tuple[Channel, ...]:
        """The seen channels where effects put their probes, by the values of the costly unknowns."""
        own = looking = self.base.channels
        for effect, theta in self._changing(changing):
            if effect.moves_probes:
                looking = effect.moved(looking, own, theta)
        looking = tuple(self._on_shaft(channel) for channel in looking)
        return (*looking, *self.seen_channels[len(own) :])

    def _on_shaft(self, channel: Channel) -> Channel:
        """A probe that several changes together would move beyond an end of the shaft looks at that end."""
        within = min(max(channel.position, 0.0), self.base.rotor.length)
        return channel if within == channel.position else replace(channel, position=within)

    @cached_property
    def impedances(self) -> tuple[Impedance, ...]:
        """All that the rotor's own unknowns or an effect may set."""
        n_bearing = len(self.base.rotor.bearings)
        needed = set(impedances_of(self.base.rotor, self.base.unknowns, of_all_bearings=True))
        if any(effect.couples_axes for effect in self.effects):
            bearings = range(n_bearing)
            needed |= {Impedance(bearing, row, column) for bearing in bearings for row in (0, 1) for column in (0, 1)}
        if self.couples_bearings:
            pairs = itertools.permutations(range(n_bearing), 2)
            entries = {(item.row, item.column) for item in needed if item.link < n_bearing}
            needed |= {Impedance(one, *entry, other) for (one, other), entry in itertools.product(pairs, entries)}
        return tuple(sorted(needed, key=lambda item: (item.row_port, item.column_port)))

    @property
    def couples_bearings(self) -> bool:
        return any(effect.couples_bearings for effect in self.effects)

    def impedances_and_sizes(self, x: Array, harmonic: float = 1.0) -> tuple[ComplexArray, ComplexArray]:
        """Impedances and sizes of unbalance for sets (n, d), effects and supports included.

        The impedances (n_impedance, n, n_speed), N/m, at a harmonic, and how large the unbalance of each plane and each
        load of effects are, (n, n_plane + n_load).
        """
        own, of_effects = self.parts(x)
        inputs = self.base.inputs(own)
        sizes = np.concatenate([inputs.complex_unbalance, *self.sizes(of_effects)], axis=1)
        is_whole = self.couples_bearings  # one matrix of all ports, or one of each bearing
        felt = (self.port_impedance if is_whole else self._films_on_supports)(
            inputs, self.base.speed, of_effects, harmonic
        )
        pedestals = inputs.pedestal_impedances(
            (item.bearing for item in self.impedances if item.of_pedestal), harmonic * self.base.speed
        )
        found = []
        for item in self.impedances:
            if item.of_pedestal:
                found.append(pedestals[item.bearing][item.row, item.column])
            elif is_whole:
                moved = item.bearing if item.moved is None else item.moved
                found.append(felt[2 * item.bearing + item.row, 2 * moved + item.column])
            else:
                found.append(felt[item.bearing, item.row, item.column])
        return np.stack(found), sizes

    def port_impedance(
        self, inputs: Inputs, speed: Array, of_effects: list[Array], harmonic: float = 1.0
    ) -> ComplexArray:
        """Impedances between all ports of bearings and seals, (n_port, n_port, n, n_speed) N/m.

        They are from motion against the housing to the force on any other port, effects and their supports included.
        """
        films, n_bearing = self._films(inputs, speed, of_effects, harmonic), len(self.base.rotor.bearings)
        of_bearings = ports_on(self.supports(of_effects), films[:n_bearing], harmonic * speed)
        n_own, n_port = len(of_bearings), 2 * len(films)
        whole = np.zeros((n_port, n_port, *of_bearings.shape[2:]), dtype=complex)
        whole[:n_own, :n_own] = of_bearings
        for seal, own in enumerate(films[n_bearing:], start=n_bearing):
            whole[2 * seal : 2 * seal + 2, 2 * seal : 2 * seal + 2] = own
        return whole

    def _films_on_supports(
        self, inputs: Inputs, speed: Array, of_effects: list[Array], harmonic: float
    ) -> ComplexArray:
        """Impedances that the shaft feels at each bearing and seal in a motion at a harmonic.

        They are (n_supported, 2, 2, n, n_speed) N/m, of n sets of inputs, effects and their supports included except
        for the common support of all bearings.
        """
        films, n_bearing = self._films(inputs, speed, of_effects, harmonic), len(self.base.rotor.bearings)
        if supports := self.supports(of_effects):
            carried = in_series_with(supports, films[:n_bearing], harmonic * speed)
            return np.concatenate([carried, films[n_bearing:]])
        return films

    def _films(self, inputs: Inputs, speed: Array, of_effects: list[Array], harmonic: float) -> ComplexArray:
        """Impedance of bearings and seals alone, at a harmonic of each speed."""
        films = at_harmonic(self.bearing_impedance(inputs, speed, of_effects), harmonic)
        if inputs.own.has_mass:
            films = films - inputs.bearings_at(speed)[2] * (harmonic * speed) ** 2
        if (added := self.bearing_inertia(of_effects)) is not None:
            films = films.copy()
            films[: len(self.base.rotor.bearings)] -= added[..., None] * (harmonic * speed) ** 2
        return films

    def bearing_inertia(self, of_effects: list[Array]) -> Array | None:
        """Mass (2, 2, n), kg, that effects add to each bearing; None if they add none."""
        found = [effect.bearing_inertia(values) for effect, values in zip(self.effects, of_effects)]
        parts = [each for each in found if each is not None]
        return np.eye(2)[..., None] * np.sum(parts, axis=0) if parts else None

    def bearing_impedance(self, inputs: Inputs, speed: Array, of_effects: list[Array]) -> ComplexArray:
        """K + iΩC of bearings and seals, the bearings as effects change them, at spin speeds (n_speed,) rad/s."""
        stiffness, damping, _ = inputs.bearings_at(speed)
        whole, n_bearing = stiffness + 1j * speed * damping, len(self.base.rotor.bearings)
        impedance = whole[:n_bearing]
        for effect, values in self._in_stages(of_effects):
            impedance = effect.impedance(impedance, speed, values)
        return impedance if len(whole) == n_bearing else np.concatenate([impedance, whole[n_bearing:]])

    def supports(self, of_effects: list[Array]) -> list[Support]:
        """Supports of the bearings, from the bearing to the ground."""
        found = (effect.support(values) for effect, values in self._in_stages(of_effects))
        return [support for support in found if support is not None]

    def loads(self, rotor: Rotor) -> ComplexArray | None:
        loads = [effect.loads(rotor, self.base.speed) for effect in self.effects if effect.has_loads]
        return np.concatenate(loads, axis=2) if loads else None

    def sizes(self, of_effects: list[Array]) -> list[ComplexArray]:
        return [effect.load_sizes(values) for effect, values in zip(self.effects, of_effects) if effect.has_loads]

    def further_forces(self, rotor: Rotor, loads: tuple[Load, ...], harmonic: float = 1.0) -> ComplexArray | None:
        """Nodal forces (n_speed, n_dof, n) of all loads other than the unbalance planes.

        Loads of effects, which are 1X, unit loads at the sites of laws, and the given loads.
        """
        forces = [] if (own := self.loads(rotor)) is None else [own * (harmonic == 1)]
        units = self.unit_loads_with(loads)
        forces += [unit_loads(rotor, units, len(self.base.speed))] if units else []
        return np.concatenate(forces, axis=2) if forces else None

    def unit_loads_with(self, loads: tuple[Load, ...]) -> tuple[Load, ...]:
        return (*(load for each in self.site_laws for load in each.loads), *loads)

    @cached_property
    def site_laws(self) -> tuple[SiteLaw, ...]:
        """The laws of forces that effects add at sites, in the order in which they enter."""
        return tuple(site for forces in self.forces([np.empty(0)] * len(self.effects)) for site, _ in forces)

    def forces(self, of_effects: list[Array]) -> tuple[list[Force], list[Force]]:
        """These with their coefficients: by laws that are linear in the motion, and by others."""
        sites = ((effect.site_law(), values) for effect, values in zip(self.effects, of_effects))
        return split_by_law([(site, values) for site, values in sites if site])

    def sweeps(self, of_effects: list[Array]) -> list[Sweep]:
        found = (effect.sweep(values) for effect, values in zip(self.effects, of_effects))
        return [sweep for sweep in found if sweep is not None]

    @cached_property
    def seen_channels(self) -> tuple[Channel, ...]:
        """Channels, and after them all further channels that effects use.

        Effects compute readings from them, or a force may follow their motion.
        """
        needed = dict.fromkeys(
            channel for effect in self.effects for channel in effect.needed_channels(self.base.channels)
        )
        needed |= dict.fromkeys(channel for each in self.site_laws for channel in each.channels)
        return (*self.base.channels, *(channel for channel in needed if channel not in self.base.channels))

    def observed(self, response: ComplexArray, of_effects: list[Array]) -> ComplexArray:
        """Readings of the probes for the motion (n, n_speed, n_seen) at the seen channels."""
        for effect, values in self._in_stages(of_effects):
            response = effect.observed(response, self.seen_channels, self.base.speed, values)
        return response[..., : len(self.base.channels)]

    def shown(self, columns: ComplexArray, x: Array) -> ComplexArray:
        """Readings of the probes (n, n_speed, n_channel, 1 + n_load), with the forces of the laws acting.

        They are in m and m per unit, for sets (n, d). `columns` (n, n_speed, n_seen, 1 + n_site_load + n_load) are the
        motion and the responses to unit forces at the sites of laws, which are linear, and to unit loads.
        """
        of_effects = self.parts(x)[1]
        acting = with_linear_forces(columns, self.forces(of_effects)[0], self.seen_channels, self.base.speed)
        motion = self.observed(acting[..., 0], of_effects)
        if acting.shape[-1] == 1:
            return motion[..., None]
        at_rest = self.observed(np.zeros_like(acting[..., 0]), of_effects)  # runout is read at rest too
        per_load = [self.observed(each, of_effects) - at_rest for each in np.moveaxis(acting[..., 1:], -1, 0)]
        return np.stack([motion, *per_load], axis=-1)

    @property
    def shows_motion(self) -> bool:
        """Whether no force follows a law and the probes show the motion as it is."""
        return not self.site_laws and all(type(each).observed is RotorHooks.observed for each in self.effects)

    def reduction(self, changing: tuple[float, ...], loads: tuple[Load, ...], harmonic: float = 1.0) -> Reduction:
        """The rotor, as its effects have changed it, seen from its ports.

        Unit loads come last, and act alone at a harmonic, where their sites are read behind the channels.
        """
        base, seen = self.base, self.channels_with(np.array(changing))

        def reduced() -> Reduction:
            if harmonic == 1 and (known := self.at_changes(changing, loads)) is not None:
                return known[0].without_dof(known[1])
            rotor, units = self.changed_rotor(base.rotor, np.array(changing)), self.unit_loads_with(loads)
            rows = unit_loads(rotor, units, 1)[0].T.real if units and harmonic != 1 else None  # that no channel reads
            forces = self.further_forces(rotor, loads, harmonic)
            is_base = harmonic == 1 and replace(rotor, housing_probes=base.rotor.housing_probes) == base.rotor
            shaft = base.factored(self.impedances) if is_base else None
            if not np.any(self.of_probes[self.costly]):
                return self._reduced(shaft, rotor, seen, forces, rows, harmonic)
            of_rotor = tuple(np.where(self.of_probes[self.costly], 0.0, changing))
            move = partial(shaft_motion, rotor, self.impedances, base.speed, forces, harmonic=harmonic)
            move = move if shaft is None else partial(shaft.under, forces)
            return recent(self._motions, (of_rotor, loads, harmonic), move, MAX_MOTIONS).read_by(rotor, seen, rows)

        if not self._shapes_reduction:
            kept = base.reductions_beside_effects
            return recent(kept, (self.impedances, seen, loads, harmonic), reduced, MAX_REDUCTIONS)
        return recent(self._reductions, (changing, loads, harmonic), reduced, MAX_REDUCTIONS)

    def _reduced(
        self,
        shaft: FactoredShaft | None,
        rotor: Rotor,
        channels: tuple[Channel, ...],
        forces: ComplexArray | None,
        rows: Array | None,
        harmonic: float = 1.0,
    ) -> Reduction:
        """The reduction of a rotor, by its factors if these are kept."""
        if shaft is not None:
            return shaft.under(forces).read_by(rotor, channels, rows)
        speed = self.base.speed
        return reduce_rotor(rotor, self.impedances, speed, channels, forces, rows=rows, harmonic=harmonic)

    def at_changes(self, changing: tuple[float, ...], loads: tuple[Load, ...]) -> tuple[LocalChanges, Reduction] | None:
        """The few places at which effects change the rotor, and its reduction that is also seen from there.

        None if they change it at many places, or more of it than its matrices.
        """
        changes = recent(self._changes, loads, partial(self._local_changes, loads), MAX_LOCAL)
        if changes is None:
            return None
        make = partial(self._seen_from, changes, np.array(changing))
        return recent(self._at_changes, (changing, loads), make, MAX_LOCAL)

    def _seen_from(self, changes: LocalChanges, changing: Array) -> tuple[LocalChanges, Reduction] | None:
        found = changes.reduction_of(self.changed_rotor(self.base.rotor, changing))
        return None if found is None else (changes, found)

    def _local_changes(self, loads: tuple[Load, ...]) -> LocalChanges | None:
        if not len(self.costly) or np.any(self.of_probes[self.costly]) or self.loads_follow_rotor:
            return None
        lower, upper = (limits[self.costly] for limits in (self.parameters.lower, self.parameters.upper))
        least = np.clip(0.0, lower, upper)
        is_base = not np.any(least) and not any(effect.is_held for effect in self.changing_rotor)
        try:
            rotors = [self.changed_rotor(self.base.rotor, each) for each in (least, lower, upper, (lower + upper) / 2)]
        except SettingError:  # limits of several effects may leave no rotor
            return None
        units, speed = self.unit_loads_with(loads), self.base.speed
        key = (rotors[0], *rotors[1:3], self.impedances, self.seen_channels, units)

        def seen(forces: ComplexArray, rows: Array) -> Reduction:
            shaft = self.base.factored(self.impedances) if is_base else None
            return self._reduced(shaft, rotors[0], self.seen_channels, forces, rows)

        make = partial(LocalChanges.between, rotors[0], rotors[1:], seen, self.seen_channels, units, len(speed))
        return recent(self.base.local_changes, key, make, most_kept(len(speed)))

    @cached_property
    def _changes(self) -> OrderedDict[tuple[Load, ...], LocalChanges | None]:
        return OrderedDict()

    @cached_property
    def _at_changes(
        self,
    ) -> OrderedDict[tuple[tuple[float, ...], tuple[Load, ...]], tuple[LocalChanges, Reduction] | None]:
        return OrderedDict()

    @cached_property
    def _reductions(self) -> OrderedDict[tuple[tuple[float, ...], tuple[Load, ...], float], Reduction]:
        return OrderedDict()

    @cached_property
    def _motions(self) -> OrderedDict[tuple[tuple[float, ...], tuple[Load, ...], float], ShaftMotion]:
        """Motions of the whole shaft that probes are read from, wherever they stand."""
        return OrderedDict()

    @property
    def _shapes_reduction(self) -> bool:
        """Whether effects change the rotor or load it.

        Others, at whatever places, share the reductions of the rotor behind.
        """
        return bool(self.site_laws or self.changing_rotor) or any(effect.has_loads for effect in self.effects)

    def _in_stages(self, of_effects: list[Array]) -> list[tuple[RotorHooks, Array]]:
        """The effects with their values in the order in which they act."""
        return sorted(zip(self.effects, of_effects), key=lambda pair: pair[0].stage)
