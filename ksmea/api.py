"""Python API: problems and measurements by name or file, and the studies of them.

The command line's studies call the same functions (`ksmea.studies`). Here their settings are arguments and their records come
as results. Problem and measurement are aligned first (`ksmea.problem.alignment`): the problem is evaluated at the measurement's
speeds and channels, or the two are rejected.

Longer than 400 lines: each study is documented with its arguments, units and an example.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np

from ksmea.errors import SettingError
from ksmea.extended_model import extended_yaml, located_yaml
from ksmea.loaded_problem import YAML, LoadedProblem
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.noise import Noise
from ksmea.numerics.one_thread import one_blas_thread
from ksmea.numerics.parallel import Workers
from ksmea.plugins import registry
from ksmea.plugins.identification import Method, Streams
from ksmea.plugins.optimizer import Optimizer
from ksmea.plugins.source import MeasurementSource
from ksmea.plugins.surrogate import Surrogate
from ksmea.problem.alignment import aligned
from ksmea.problem.case import Case
from ksmea.problem.problem import Problem
from ksmea.records.hidden import HiddenEffect
from ksmea.results import (
    BalanceResult,
    DiagnosisResult,
    IdentifiabilityResult,
    IdentificationResult,
    LocationResult,
    PlanResult,
)
from ksmea.settings.settings import own_fields
from ksmea.show.diagnosis_text import about_extension
from ksmea.show.location_text import about_extension as about_law
from ksmea.studies.balance import BalanceOptions
from ksmea.studies.balance import balance as balancing
from ksmea.studies.design_point import DesignPoint
from ksmea.studies.diagnose import DiagnosisOptions, Report, diagnosis
from ksmea.studies.identifiability import IdentifiabilityOptions, identifiability_study
from ksmea.studies.identification_details import detailed_identification, location_options
from ksmea.studies.identify import IdentificationOptions
from ksmea.studies.library import library
from ksmea.studies.locate import LocationOptions, location
from ksmea.studies.planning import PlanningOptions, planning_study
from ksmea.units import MICROMETRE

Seed = int | np.random.Generator
Studied = TypeVar("Studied", bound=Callable[..., Any])


def _seeded_by_rng(function: Studied) -> Studied:
    """The function, with an error that names `rng` if it is called with `seed`."""

    @wraps(function)
    def called(*arguments: Any, **settings: Any) -> Any:
        if "seed" in settings:
            raise SettingError(f"seed: expected a seed as rng, got seed=…; write rng={settings['seed']!r}")
        return function(*arguments, **settings)

    return cast(Studied, called)


def read_measurement(path: str | Path, **settings: Any) -> Measurement:
    """Read a measured run from a CSV file, or several runs of one machine from a YAML file.

    Args:
        path: CSV file (`measurements/file.py` describes its columns), or YAML file of a campaign, ending in .yaml or .yml
            (`measurements/campaign.py`).
        **settings: settings of `measurement=file` or `measurement=campaign`, such as `incomplete="drop"` and `speed_from=…`. A
            file of an instrument needs its `format`, such as "system1", and settings for what it does not state
            (docs/own_data.md).

    Returns:
        Measurement with speeds in rad/s and values (n_speed, n_channel) in m 0-peak.

    Raises:
        SettingError: the file cannot be read, or a setting does not exist or does not fit it.

    >>> import ksmea
    >>> measurement = ksmea.read_measurement("docs/examples/run_up.csv")
    >>> str(measurement.kind), measurement.values.shape
    ('complex', (90, 2))
    """
    plugin = "campaign" if Path(path).suffix in YAML else "file"
    source: MeasurementSource = registry.create("measurement", plugin, {"path": str(path), **settings})
    return source.read()


@dataclass(frozen=True)
class SyntheticData:
    """Synthetic measurement, with the true values and hidden effects that it was made from.

    A study uses the measurement alone.

    Args:
        measurement: noisy values as a file would give them.
        truth: true values of the unknowns by name, in their units.
        hidden: effects in the data that the problem's model lacks.
    """

    measurement: Measurement
    truth: Mapping[str, float]
    hidden: tuple[HiddenEffect, ...]


@_seeded_by_rng
@one_blas_thread
def synthetic_measurement(
    problem: LoadedProblem,
    *,
    relative: float = 0.0,
    floor: float = 0.0,
    kind: str = "amplitude",
    hidden: Sequence[str] = (),
    rng: Seed = 0,
    **settings: Any,
) -> SyntheticData:
    """Measurement computed with the problem's own model, with Gaussian noise.

    The true values are the published ones, unless `truth` is set.

    Args:
        problem: problem of `load_problem`.
        relative: standard deviation of the noise as a fraction of each value.
        floor: standard deviation of the noise without any response, µm.
        kind: "amplitude" or "complex".
        hidden: names of effects that are in the data but not in the model; locations and sizes are drawn.
        rng: seed or generator.
        **settings: further settings of `measurement=synthetic`: truth, sizes, noise_known, phase_known, mesh, route …

    Returns:
        Measurement with the true values and hidden effects that it was made from.

    Raises:
        SettingError: an argument is out of its range, or an effect has no location on the problem.

    >>> import ksmea
    >>> rotor = ksmea.load_problem("three_disk")
    >>> data = ksmea.synthetic_measurement(rotor, relative=0.05, kind="complex", hidden=["runout"], rng=3)
    >>> data.measurement.values.shape, [each.effect for each in data.hidden]
    ((53, 2), ['runout'])
    """
    settings = {"relative": relative, "floor": floor, "kind": kind, "hidden": list(hidden), **settings}
    source: MeasurementSource = registry.create("measurement", "synthetic", settings)
    noise, of_hidden = _generator(rng).spawn(2)
    seed = int(of_hidden.integers(2**63))  # what is hidden is drawn for the data, and drawn again to be told
    truth = source.true_values(problem.settings)
    measurement = source.measure(problem.settings, truth, noise, np.random.default_rng(seed))
    found = source.hidden_effects(problem.settings, np.random.default_rng(seed))
    units = {item.name: item.si_per_unit for item in aligned(problem.problem, measurement).parameters}
    return SyntheticData(measurement, {name: truth[name] / unit for name, unit in units.items()}, tuple(found))


Data = Measurement | SyntheticData


@_seeded_by_rng
@one_blas_thread
def identify(
    problem: LoadedProblem | Problem,
    measurement: Data,
    method: str | Method = "direct",
    *,
    surrogate: str | Surrogate = "kriging",
    optimizer: str | Optimizer | None = None,
    samples: int = 100,
    rng: Seed = 0,
    intervals: str = "profile",
    level: float = 0.95,
    unmodelled: str | float = "",
    **settings: Any,
) -> IdentificationResult:
    """Identify the unknowns of a problem from a measurement, each with a confidence interval.

    Args:
        problem: problem of `load_problem`, or one made by hand.
        measurement: measured or synthetic data.
        method: registered name – "direct" searches the true model, "ksmea" a surrogate of it that is refined – or a method
            made by hand, which brings its own parts.
        surrogate: surrogate of a method that is given by name, if it uses one.
        optimizer: optimiser of a method that is given by name. Default: least squares from many starts ("lm") for "direct",
            differential evolution ("de") for every other method.
        samples: number of samples of the first surrogate, if the method uses one.
        rng: seed or generator.
        intervals: "profile", "information" or "none" (`ksmea.studies.identify.IdentificationOptions`).
        level: confidence level of the intervals, such as 0.95.
        unmodelled: position (m) of an unmodelled force, or "auto" for all sites. The unknowns are then also estimated together
            with that force, which makes these estimates valid although the model is wrong. Default: empty, no such force.
        **settings: settings of the named method.

    Returns:
        Values with intervals, each in the unit of its unknown.

    Raises:
        SettingError: problem and measurement do not belong together, there are fewer data than unknowns, or a name or setting
            is wrong.
        ArithmeticError: an identified value is not finite.

    Source:
        Intervals: D. M. Bates and D. G. Watts, Nonlinear Regression Analysis and Its Applications, 1988, chapter 6,
        doi 10.1002/9780470316757; D. J. Venzon and S. H. Moolgavkar, Appl. Stat. 37 (1988) 87–94, doi 10.2307/2347496.

    >>> import ksmea
    >>> rotor = ksmea.load_problem("three_disk")
    >>> data = ksmea.synthetic_measurement(rotor, relative=0.05)
    >>> result = ksmea.identify(rotor, data)
    >>> result["kxx"].low < 50.0 < result["kxx"].high
    True
    """
    case = _case(problem, measurement)
    if isinstance(method, str):
        parts = {
            "surrogate": _plugin("surrogate", surrogate),
            "optimizer": _plugin("optimizer", optimizer or ("lm" if method == "direct" else "de")),
            "samples": samples,
        }
        chosen: Method = registry.create("method", method, settings, parts)
    elif settings:
        raise SettingError(f"identify: expected the settings inside the method, got {', '.join(settings)} as well")
    else:
        chosen = method
    chosen.validate(case.problem)
    generator = _generator(rng)
    options = IdentificationOptions(intervals=intervals, level=level, details=True)
    beside = location_options(str(unmodelled), level)
    streams, rng = Streams(*generator.spawn(3)), generator.spawn(1)[0]
    record = detailed_identification(case, chosen, streams, rng, options, beside=beside)
    return IdentificationResult(record)


@_seeded_by_rng
@one_blas_thread
def identifiability(
    problem: LoadedProblem,
    *,
    relative: float = 0.0,
    floor: float = 0.0,
    kind: str = "amplitude",
    noise_known: bool = True,
    values: Mapping[str, float] | None = None,
    measurement: Data | None = None,
    rng: Seed = 0,
    **settings: Any,
) -> IdentifiabilityResult:
    """Precision of the unknowns from data on the problem's speeds and channels, and from varied data.

    Args:
        problem: problem of `load_problem`.
        relative: standard deviation of the noise as a fraction of each value.
        floor: standard deviation of the noise without any response, µm.
        kind: "amplitude" or "complex".
        noise_known: whether the noise level is known to the later identification.
        values: values of unknowns at which the problem is linearised, by name and in their units. Default: published values,
            and midpoints of the limits of unknowns without one, which a remark lists.
        measurement: data whose most likely values and noise are used in place of the noise, kind and values above, and to which
            further data are added.
        rng: seed or generator, for the fit to `measurement`.
        **settings: settings of `study=identifiability`: level, variations …

    Returns:
        Cramér–Rao lower bound (CRLB) of each unknown, now and with varied data.

    Raises:
        SettingError: the noise is absent, or a value or setting is wrong.

    Source:
        S. M. Kay, Fundamentals of Statistical Signal Processing: Estimation Theory, 1993, eq. 3.24.

    >>> import ksmea
    >>> result = ksmea.identifiability(ksmea.load_problem("three_disk"), relative=0.1, variations=[])
    >>> [f"{item.name} {100 * item.crlb / item.true:.2f} %" for item in result.record.parameters[:2]]
    ['kxx 0.11 %', 'kyy 0.11 %']
    """
    options = IdentifiabilityOptions(**settings)
    if measurement is None:
        point = _design_point(problem, values, _noise(relative, floor), kind, noise_known)
    else:
        point = _most_likely(problem, measurement, rng)
    return IdentifiabilityResult(identifiability_study(point, options))


@_seeded_by_rng
@one_blas_thread
def plan(
    problem: LoadedProblem,
    target: str | None = None,
    *,
    relative: float = 0.0,
    floor: float = 0.0,
    kind: str = "amplitude",
    noise_known: bool = True,
    values: Mapping[str, float] | None = None,
    measurement: Data | None = None,
    rng: Seed = 0,
    **settings: Any,
) -> PlanResult:
    """Speeds, probes and trial unbalance to add, so that unknowns become known best.

    Args:
        problem: problem of `load_problem`.
        target: name of the unknown to determine. Default: all unknowns together, by the volume of their confidence ellipsoid.
        relative: standard deviation of the noise as a fraction of each value.
        floor: standard deviation of the noise without any response, µm.
        kind: "amplitude" or "complex".
        noise_known: whether the noise level is known to the later identification.
        values: values of unknowns at which the problem is linearised, by name and in their units. Default: published values,
            and midpoints of the limits of unknowns without one.
        measurement: data whose most likely values and noise are used in place of the noise, kind and values above, and to which
            further data are added.
        rng: seed or generator, for the fit to `measurement`.
        **settings: settings of `study=plan`: add, sensors, band …

    Returns:
        Additions of each family in their order, with the CRLBs after each.

    Raises:
        SettingError: the noise is absent, or a target, value or setting is wrong.

    Source:
        V. V. Fedorov, Theory of Optimal Experiments, 1972; A. C. Atkinson, A. N. Donev and R. D. Tobias, Optimum Experimental
        Designs, with SAS, 2007.

    >>> import ksmea
    >>> result = ksmea.plan(ksmea.load_problem("three_disk"), "cyy", relative=0.1, add=2, sensors=0, trial_phases=[])
    >>> [family.family for family in result.record.families]
    ['speeds']
    """
    options = PlanningOptions(target=target, **settings)
    if measurement is None:
        point = _design_point(problem, values, _noise(relative, floor), kind, noise_known)
    else:
        point = _most_likely(problem, measurement, rng)
    return PlanResult(planning_study(point, options))


@_seeded_by_rng
@one_blas_thread
def diagnose(
    problem: LoadedProblem,
    measurement: Data,
    *,
    effects: Sequence[str] = (),
    without: Sequence[str] = (),
    rng: Seed = 0,
    workers: int = 1,
    **settings: Any,
) -> DiagnosisResult:
    """Misfit of a model to a measurement, the effect that explains it, and the gain of the extension.

    A diagnosis takes from a second to a minute.

    Args:
        problem: problem of `load_problem`.
        measurement: measured or synthetic data.
        effects: names of the effects to try; ["none"] tries no effect. Default: all registered ones.
        without: names of effects to leave out.
        rng: seed or generator.
        workers: number of processes that share the work; the result does not depend on it. Two take little more than half of
            the time of one.
        **settings: settings of `study=diagnose`: level, blocks, starts …

    Returns:
        Verdict, ranked effects, sizes with intervals and the extended model.

    Raises:
        SettingError: problem and measurement do not belong together, no effect has a location on the problem, or a name or
            setting is wrong.

    Source:
        Predictive gain: A. Vehtari, A. Gelman and J. Gabry, Stat. Comput. 27 (2017) 1413–1432, doi 10.1007/s11222-016-9696-4.
        Averages of explanations: K. P. Burnham and D. R. Anderson, Model Selection and Multimodel Inference, 2002,
        doi 10.1007/b97636.

    >>> import ksmea
    >>> rotor = ksmea.load_problem("three_disk", sensors=[0.1, 0.5, 1.0])
    >>> data = ksmea.synthetic_measurement(rotor, relative=0.05, floor=0.1, kind="complex", noise_known=False)
    >>> ksmea.diagnose(rotor, data, effects=["runout", "mass"]).verdict
    'adequate'
    """
    case = _case(problem, measurement)
    options = DiagnosisOptions(**settings)
    shared = _workers(workers)
    chosen, left_out = library(effects, without, case.measurement, case.problem)
    report = Report(left_out)
    record = diagnosis(case, chosen, _generator(rng), options=options, report=report, workers=shared)
    return DiagnosisResult(record, extended_yaml(problem.name, _own(problem), record, about_extension(record)))


@_seeded_by_rng
@one_blas_thread
def locate(
    problem: LoadedProblem | Problem, measurement: Data, *, rng: Seed = 0, workers: int = 1, **settings: Any
) -> LocationResult:
    """Sites at which an unknown force, moment or reading, free at every speed, explains the data.

    It assumes no effect. The unknowns fitted with the force are valid although the model is wrong.

    Args:
        problem: problem of `load_problem`, or one made by hand.
        measurement: complex data of three channels or more.
        rng: seed or generator.
        workers: largest number of processes that share the sites; the result does not depend on it.
        **settings: settings of `study=locate`: level, positions (m), kinds …

    Returns:
        Accepted sites, the force over speed, and the unknowns estimated with it.

    Raises:
        SettingError: problem and measurement do not belong together, there are too few data, or a setting is wrong.

    Source:
        Elimination of the force: G. H. Golub and V. Pereyra, Inverse Problems 19 (2003) R1–R26, doi 10.1088/0266-5611/19/2/201.
        Noise level: H. D. Patterson and R. Thompson, Biometrika 58 (1971) 545–554, doi 10.1093/biomet/58.3.545.

    >>> import ksmea
    >>> rotor = ksmea.load_problem("three_disk", sensors=[0.1, 0.5, 1.0], n_speed=27)
    >>> data = ksmea.synthetic_measurement(rotor, relative=0.05, kind="complex", hidden=["unbalance"], rng=1)
    >>> found = ksmea.locate(rotor, data, positions=[0.2, 1.0], kinds=["force"])
    >>> found.record.kind, found.sites
    ('force', (1.0,))
    """
    case, shared = _case(problem, measurement), _workers(workers)
    record = location(case, _generator(rng), options=LocationOptions(**settings), workers=shared)
    if not isinstance(problem, LoadedProblem):
        return LocationResult(record)
    return LocationResult(record, located_yaml(problem.name, _own(problem), record, about_law(record)))


@_seeded_by_rng
@one_blas_thread
def balance(measurement: Data, *, rng: Seed = 0, **settings: Any) -> BalanceResult:
    """Influence coefficients, unknown weights and correction weights of a campaign, without a rotor model.

    Args:
        measurement: runs with weights, at nominally equal speeds. Amplitudes without phases are enough for one plane. A weight
            without `g_mm` is unknown.
        rng: seed or generator.
        **settings: settings of `study=balance`: drift, leave_out, level …

    Returns:
        Coefficients (µm per unit of weights), weights and corrections with their intervals.

    Raises:
        SettingError: data without weights, runs that do not separate the planes, or a wrong setting.

    Source:
        Corrections: Goodman, J. Eng. Ind. 86 (1964) 273–279, eq. (7).

    >>> import ksmea
    >>> found = ksmea.balance(ksmea.read_measurement("docs/examples/balancing.yaml"))
    >>> {position: (round(size, 1), round(angle)) for position, (size, angle) in found.correction.items()}
    {0.2: (40.1, -104), 0.4: (25.2, 140)}
    """
    record = balancing(_measurement(measurement), _generator(rng), options=BalanceOptions(**settings))
    return BalanceResult(record)


def _workers(count: int) -> Workers:
    if isinstance(count, bool) or not isinstance(count, int) or count < 1:
        raise SettingError(f"workers: expected a whole number of processes from 1 on, got {count!r}")
    return Workers(count)


def _own(problem: LoadedProblem) -> dict[str, Any]:
    """The settings of a problem by name."""
    return {field.name: getattr(problem.settings, field.name) for field in own_fields(type(problem.settings))}


def _generator(rng: Seed) -> np.random.Generator:
    return np.random.default_rng(rng)


def _noise(relative: float, floor: float) -> Noise:
    noise = Noise(relative, floor * MICROMETRE)
    if noise.is_absent:
        raise SettingError(
            "noise: expected some, without which every unknown is known exactly, got none; give relative=0.05 or floor=0.1 (µm)"
        )
    return noise


def _design_point(
    problem: LoadedProblem, values: Mapping[str, float] | None, noise: Noise, kind: str, noise_known: bool
) -> DesignPoint:
    """Planned data at values of the unknowns, with remarks on assumed ones."""
    taken = problem.middles(values)
    said = (
        f"no value is known of {', '.join(taken)}: the middles of the limits are taken, the geometric ones where these lie a decade"
        f" or more apart; give yours: values={{{next(iter(taken), '')!r}: …}}"
    )
    remarks = (said,) if taken else ()
    x = problem.x({**taken, **(values or {})})
    return DesignPoint(problem.problem, x, noise, kind, noise_known, remarks=remarks)


def _most_likely(problem: LoadedProblem, data: Data, rng: Seed) -> DesignPoint:
    return DesignPoint.of_measurement(_case(problem, data), _generator(rng))


def _measurement(data: Data) -> Measurement:
    found = data.measurement if isinstance(data, SyntheticData) else data
    if not isinstance(found, Measurement):
        raise SettingError(
            "measurement: expected one of ksmea.read_measurement or ksmea.synthetic_measurement, got"
            f" {type(found).__name__}; ksmea.read_measurement(path) reads a file"
        )
    return found


def _case(problem: LoadedProblem | Problem, data: Data) -> Case:
    found = problem.problem if isinstance(problem, LoadedProblem) else problem
    if not isinstance(found, Problem):
        raise SettingError(
            f"problem: expected one of ksmea.load_problem or a ksmea.Problem, got {type(found).__name__}"
        )
    return Case.of(found, _measurement(data))


def _plugin(group: str, chosen: str | Surrogate | Optimizer) -> Any:
    return registry.create(group, chosen, {}) if isinstance(chosen, str) else chosen
