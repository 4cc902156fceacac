"""Verdict of a diagnosis and a location in its data.

It is `located` in place of `unknown`, or of names that are elsewhere.

Effects may stand for a cause that the library lacks: a damper to the ground between the bearings looks like unequal bearings with
damping along the shaft. If a location is sharp and no explanation acts there alone, a force that follows a law at one of its places
is compared with the explanation by evidence, and effects are named only if they explain the data better.

Nor is a location sharp if few channels see a weak cause: a stop then looks like an added mass whose misfit passes as noise. If the
misfit of an explanation is barely likely, laws are sought as well, and one with clearly more evidence takes its name away.
"""

from __future__ import annotations

import dataclasses

from ksmea.diagnosis.diagnosis import Diagnosis
from ksmea.diagnosis.trials import NEAR, Explanation
from ksmea.location.location import Location
from ksmea.records.diagnosis import DiagnosisRecord
from ksmea.records.location import LocationRecord


def with_location(record: DiagnosisRecord, where: LocationRecord) -> DiagnosisRecord:
    """Diagnosis with the findings without the library, which decide if no effect explains the data."""
    found = dataclasses.replace(record, location=where)
    if record.verdict != "unknown" or not where.is_local:
        return found
    return dataclasses.replace(found, verdict="located", stability=None)  # that was of a model which is wrong


def is_elsewhere(found: Diagnosis, sites: Location) -> bool:
    """Whether effects are named, but act elsewhere than where a sharp location finds something.

    Args:
        found: diagnosis.
        sites: location in its data, without laws.
    """
    machine = found.baseline.problem.machine

    def acts_there(explanation: Explanation) -> bool:
        places = [candidate.effect.places(machine) for candidate in explanation.applied]
        return all(len(at) and all(map(sites.accepts, at)) for at in places)

    return bool(found.explanations) and sites.is_sharp and not any(map(acts_there, found.explanations))


DOUBTFUL = 0.05  # p of the misfit of an explanation below which laws are sought


def seeks_laws(found: Diagnosis, sites: Location) -> bool:
    """Whether the verdict may depend on a law of the unknown force.

    Args:
        found: diagnosis.
        sites: location in its data, without laws.
    """
    return (found.verdict == "unknown" and not sites.is_anywhere) or is_elsewhere(found, sites) or is_doubtful(found)


def is_doubtful(found: Diagnosis) -> bool:
    """Whether effects are named, but one in twenty right explanations at most misfits as much."""
    return bool(found.explanations) and found.best_quality is not None and found.best_quality.p < DOUBTFUL


def is_one_law(found: Diagnosis, where: LocationRecord, sites: Location) -> bool:
    """Whether a law takes the place of named effects.

    At a local place where these do not act it has to explain the data about as well, otherwise clearly better.

    Args:
        found: diagnosis.
        where: location in its data; only where laws were sought can one be found.
        sites: location without laws.
    """
    if not found.explanations or where.extension is None or where.extension.delta_bic is None:
        return False
    as_good = where.is_local and is_elsewhere(found, sites)
    return where.extension.delta_bic > found.explanations[0].delta_bic + (-NEAR if as_good else NEAR)


def without_names(found: Diagnosis) -> Diagnosis:
    """A diagnosis whose effects explain nothing: the verdict is `unknown`, until a location decides."""
    return dataclasses.replace(
        found,
        verdict="unknown",
        named=(),
        ambiguity_group=(),
        locations=(),
        best=None,
        applied=(),
        best_estimate=None,
        best_quality=None,
        predictive_gain=None,
        split=None,
        collinearity={},
        explanations=(),
        averaged=None,
    )


def remark_on(found: Diagnosis, where: LocationRecord) -> str:
    """The explanation that was given up for a law, in a sentence.

    Args:
        found: diagnosis that named it.
        where: location with the law.
    """
    law = where.law
    assert law is not None, "an explanation is given up for a law alone"
    names = " with ".join(found.explanations[0].names)
    place = f"{law.position:g} m"
    if where.is_local:
        return f"{names} would fit, but {law.law} at {place} explains the data as well, and an unknown {law.kind} is located there"
    return f"{names} would fit, but {law.law}, as at {place}, explains the data better"
