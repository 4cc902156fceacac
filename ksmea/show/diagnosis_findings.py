"""Findings of a diagnosis in words, as its text and its page say them.

Title, meaning, certainty, checks, and other explanations.

Noise that an explanation needs, relative to the best one, is exp(Δ/2n) if the noise is estimated, and √(1 + Δ/χ²) if it
is known: Δ is the rise of the deviance above the best one, n the number of real data, and χ² the weighted sum of squares of the best
one. Both are ratios of the rms residual; the likelihood of n data of one unknown variance is n ln s².
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from operator import attrgetter

from ksmea.measurement.notation import Notation
from ksmea.records.diagnosis import MAX_SPLIT, CurvesRecord, DiagnosisRecord, FitQualityRecord, TrialRecord
from ksmea.records.estimate import EstimateRecord, NoiseLevelRecord
from ksmea.records.extension import EffectRecord
from ksmea.records.statement import StatementRecord
from ksmea.show import statements
from ksmea.show.location_words import in_short, over_the_shaft
from ksmea.show.readings import DECIMALS, PLAIN, speed_unit
from ksmea.show.statements import ANGLE, UNSAID, half_width, with_unit
from ksmea.show.text import capital, number, two_digits
from ksmea.units import MICROMETRE

ADEQUATE, UNSEEN, LOCATED, UNKNOWN, AMBIGUOUS = "adequate", "not observable", "located", "unknown", "ambiguous"
MISREAD = "misread"
NEAR = 6.0  # ΔBIC within which two explanations cannot be distinguished (Kass & Raftery 1995)
LEAST_FLOOR = 0.01 * MICROMETRE  # of noise that is said
RESOLUTION = 4001  # simulated residuals of the lack-of-fit test, with the measured ones: its smallest p is one of them
EVERYWHERE = (UNSAID, "all bearings")  # locations that the name of a cause implies
WHOLE = 3.0  # of a half-width: a number has no decimals
ALIKE = 2.0  # factor within which relative half-widths are said together
TIMES, UP_TO = "\N{MULTIPLICATION SIGN}", "\N{EN DASH}"
AGREES = "the machine itself agrees with the model."
MOST_MULTIPLE = 1e3  # noise that is said; beyond it nobody compares
FAR = 1.3  # times the noise, below which odds say more
MOST_ODDS = 1e6
SPLIT = "the further measurement that is proposed distinguishes it"


@dataclass(frozen=True)
class Other:
    """Explanation that is not the best one, at its best location, with the noise relative to the best one."""

    trial: TrialRecord
    words: str
    multiple: float
    behind: float  # ΔBIC of the best one less its own
    is_near: bool  # it cannot be distinguished from the best one


def title(record: DiagnosisRecord, notation: Notation = PLAIN) -> str:
    """The finding as a sentence, with size, angle and place."""
    match record.verdict:
        case "adequate":
            return f"The model explains the data{_how_well(record)}"
        case "not observable":
            return "No evidence against the model, but these data would hardly show any"
        case "located" if record.location is not None:
            return f"Something that no known effect describes acts on the shaft: a {in_short(record.location)}"
        case "ambiguous":
            return f"{_either(record, notation)}: these data cannot distinguish them"
        case "misread":
            return capital(record.reading.split(":")[0])
        case "unknown" if record.location is not None and record.location.is_spread:
            return f"Something is not in the model, {over_the_shaft(record.location)}"
        case "unknown":
            return f"Something {where(record.lack_of_fit.before, notation)} is not in the model; no cause and no pair explains it"
    return " and ".join(_said(effect, notation) for effect in record.applied)


def meaning(record: DiagnosisRecord, notation: Notation = PLAIN) -> str:
    """Meaning of the title for the model and the machine, in a few sentences."""
    test = record.lack_of_fit
    if record.verdict == MISREAD:
        return f"{capital(record.reading)}. Read so, the residuals are consistent with noise ({chance(test.before)}). The values below are of data read so: {AGREES}"
    if record.verdict in (ADEQUATE, UNSEEN):
        return f"The residuals are consistent with noise ({chance(test.before)}). The values below hold."
    rejected = f"The model as given does not fit: its residuals are not noise ({chance(test.before)})"
    if test.before.p >= test.level:
        rejected = (
            f"The residuals of the model as given could be noise ({chance(test.before)}), but the effect is significant"
        )
    if not record.is_explained:
        largest = f"They are largest {where(test.before, notation)}"
        if beside(record):
            return f"{rejected}. {largest}. The values below hold whatever it is."
        return f"{rejected}. {largest}. The values below belong to a wrong model."
    with_cause = (
        ""
        if test.after is None
        else f" With {'this cause' if len(record.applied) == 1 else 'both causes'} the residuals are consistent with noise ({chance(test.after)})."
    )
    if record.verdict == AMBIGUOUS and record.applied:
        with_cause += f" Best fit: {' and '.join(_said(effect, notation) for effect in record.applied)}."
    doubt = "".join(
        f" But {name.replace('_', ' ')} ends at its physical limit: a part that acts much like it is possible, too."
        for name in at_limits(record)
    )
    if record.predictive_gain is not None and not record.predictive_gain.is_supported:
        doubt += " Speeds that were left out do not confirm it: another run would."
    return f"{rejected}.{with_cause}{doubt}{_of_measurement(record)}"


def at_limits(record: DiagnosisRecord) -> list[str]:
    """Sizes of the best explanation that lie on a physical limit, by name."""
    if not record.is_explained or not record.applied or not record.ranking:
        return []
    return [part.name for part in record.ranking[0].parameters if part.at_limit]


def _of_measurement(record: DiagnosisRecord) -> str:
    """A sentence if every cause that is named or may be is an error of the measurement; '' otherwise."""
    effects = [effect for each in record.explanations for effect in each.effects]
    stated = [effect.statement for effect in (effects if record.verdict == AMBIGUOUS else record.applied)]
    if not stated or not all(each is not None and each.is_of_measurement for each in stated):
        return ""
    subject = "Either" if record.verdict == AMBIGUOUS else "This" if len(stated) == 1 else "Each"
    return f" {subject} is an error of the measurement: {AGREES}"


def certainty(record: DiagnosisRecord, notation: Notation = PLAIN) -> Iterator[tuple[str, str]]:
    """How sure the finding is: at most four numbers, each with its meaning and whether that is good."""
    statement = record.applied[0].statement if record.is_explained and record.applied else None
    if statement is not None and (ends := statements.intervals(statement, notation)):
        has_angle = any(
            f"{{{name}" in statement.sentence and size.angle is not None for name, size in statement.sizes.items()
        )
        of_which = f", if it is {statement.words}" if record.verdict == AMBIGUOUS else ""
        yield ends, f"95 % interval of the size{' and angle' if has_angle else ''}{of_which}"
    if record.is_explained and (found := others(record)):
        least = found[0]
        count = len({trial.effect for trial in record.ranking}) - len(record.named or record.ambiguity_group[:1])
        which = f"the next of {count} other causes" if count > 1 else "the only other cause"
        of = f"{least.words}, {which}"
        if least.is_near:
            yield _times(least.multiple), f"as much noise is needed for {of}: not ruled out"
        elif least.multiple >= FAR:
            yield _times(least.multiple), f"as much noise is needed for {of}: ruled out"
        else:
            yield (
                f"{odds(least.behind)} to 1",
                f"odds by BIC against {of}: the data fit it with {_times(least.multiple)} the noise",
            )
    if (gain := record.predictive_gain) is not None and record.is_explained:
        too_few = "" if gain.is_supported else ": too few to confirm it"
        blocks = f"blocks of speeds, left out of the fit, are predicted better with the cause than as given{too_few}"
        yield f"{gain.n_better} of {len(gain.by_block)}", blocks
    if record.verdict in (ADEQUATE, UNSEEN) and (seen := list(record.min_detectable.values())):
        shown = sum(any(part.observable for part in parts) for parts in seen)
        yield f"{shown} of {len(seen)}", "kinds of faults would have shown in these data"
    quality = record.lack_of_fit.after if record.is_explained else record.lack_of_fit.before
    if quality is not None:
        level = record.noise.after if record.is_explained and record.noise.after is not None else record.noise.before
        fit = "no lack of fit" if quality.p >= record.lack_of_fit.level else "lack of fit"
        noise = f"noise {_noise(level, notation)}{'' if record.noise.known else ', estimated from the residuals'}"
        yield chance(quality), f"{fit} (rejected below {record.lack_of_fit.level:g}); {noise}"


def checks(record: DiagnosisRecord) -> list[str]:
    """Checks on the machine, a sentence for each effect that is named or may be."""
    effects = record.applied if record.verdict != AMBIGUOUS else [each.effects[0] for each in record.explanations[:2]]
    stated = [effect.statement for effect in effects if effect.statement is not None] if record.is_explained else []
    return list(dict.fromkeys(each.advice for each in stated if each.advice))


def others(record: DiagnosisRecord) -> list[Other]:
    """All effects but the named ones at their best locations, least noise first; empty without curves."""
    best = _best(record)
    if best is None or record.curves is None:
        return []
    drop, bic = best
    found: dict[str, Other] = {}
    for trial in record.ranking:
        if trial.effect not in record.named and trial.effect not in found:
            behind = bic - trial.delta_bic
            near = behind <= NEAR or trial.effect in record.ambiguity_group
            multiple = _needed(record, drop - trial.deviance_drop)
            found[trial.effect] = Other(trial, cause(trial), multiple, behind, near)
    return sorted(found.values(), key=attrgetter("multiple"))


def as_given(record: DiagnosisRecord) -> float | None:
    """The noise that the model as given needs, relative to the best explanation; None without one."""
    best = _best(record)
    return None if best is None or record.curves is None else _needed(record, best[0])


def look_alikes(record: DiagnosisRecord) -> Iterator[str]:
    """Lines on effects that can look like the named one: ruled out by these data, or how to separate them."""
    if not record.is_explained:
        return
    by_name = {each.trial.effect: each for each in others(record)}
    known = {name: by_name[name] for name in record.aliases if name in by_name}
    ruled_out = [each for each in known.values() if not each.is_near]
    if ruled_out:
        said = ", ".join(f"{each.words} ({against(each)})" for each in ruled_out)
        yield f"Ruled out by these data, although it can look like it: {said}."
    for name, each in known.items():
        if each.is_near:
            how = SPLIT if _is_split(record, name) else record.aliases[name]
            yield f"{capital(each.words)} cannot be ruled out: {how}."


def _is_split(record: DiagnosisRecord, name: str) -> bool:
    """Whether a further measurement is proposed that distinguishes this explanation."""
    labels = [*dict.fromkeys(each.label for each in record.explanations)][:MAX_SPLIT]
    return record.split is not None and name in labels and not any(name in pair for pair in record.split.together)


def against(other: Other) -> str:
    """How much worse another cause explains the data: '× 6.9 the noise', or odds where that is little."""
    return (
        f"{_times(other.multiple)} the noise" if other.multiple >= FAR else f"odds {odds(other.behind)} to 1 against it"
    )


def file_line(record: DiagnosisRecord, notation: Notation = PLAIN) -> str:
    """Data in a line: source, speeds, probes and units; '' without curves."""
    curves = record.curves
    if curves is None:
        return record.source
    ends = " to ".join(_speed(end, notation, notation.speed) for end in (min(curves.speed), max(curves.speed)))
    phase = f", phase {notation.phase}" if _has_phase(curves) else ""
    names = ", ".join(notation.name(each) for each in curves.channels)
    parts = [record.source, f"{len(curves.speed)} speeds, {ends}", f"probes {names}", f"{notation.unit}{phase}"]
    return " · ".join(filter(None, parts))


def beside(record: DiagnosisRecord) -> list[EstimateRecord]:
    """Unknowns fitted with a located unknown force, with intervals over all its places; otherwise empty."""
    if record.verdict != LOCATED or record.location is None:
        return []
    return [each.over_sites for each in record.location.coefficients if each.over_sites is not None]


def where(quality: FitQualityRecord, notation: Notation = PLAIN) -> str:
    """Where most of a misfit sits: 'at 3820–5730 rpm in x at 0.1 m'."""
    low, high = (_speed(end, notation) for end in quality.band)
    return f"at {low}{UP_TO}{high} {notation.speed} in {notation.name(quality.channel)}"


def _speed(speed: float, notation: Notation, unit: str = "") -> str:
    return with_unit(speed / speed_unit(notation), unit, WHOLE * 10.0 ** -DECIMALS[notation.speed])


def chance(quality: FitQualityRecord) -> str:
    """Value of p in words: 'p = 0.31'; 'p ≤ 1/4001', with its statistic, at the simulation's resolution."""
    if not math.isclose(quality.p * RESOLUTION, 1.0, rel_tol=1e-6):
        return f"p = {two_digits(quality.p)}"
    lowest = [name for name, p in quality.p_by_statistic.items() if p <= min(quality.p_by_statistic.values())]
    return f"p ≤ 1/{RESOLUTION}" + (f", by {lowest[0]}" if len(lowest) == 1 else "")


def cause(trial: TrialRecord) -> str:
    """An effect with its location: 'unbalance at 1 m', 'rotor mass'."""
    words = trial.words or trial.effect.replace("_", " ")
    return words if trial.location in EVERYWHERE else f"{words} {_at(trial.location)}"


def verdict_line(record: DiagnosisRecord) -> str:
    """Verdict with its cause, 'Verdict: named – runout (at 0.1 m)', and any doubt by left-out data."""
    return f"{_verdict(record)}{_doubt(record)}"


def _verdict(record: DiagnosisRecord) -> str:
    if record.verdict == "located" and record.location is not None:
        return f"Verdict: located – an unknown {in_short(record.location)}"
    if record.verdict == MISREAD:
        return f"Verdict: misread – {record.reading.split(':')[0]}"
    if record.verdict == UNKNOWN and record.location is not None and record.location.is_spread:
        return f"Verdict: unknown – {over_the_shaft(record.location)}"
    return f"Verdict: {record.verdict}" + (f" – {applied(record)}" if record.is_explained else "")


def _doubt(record: DiagnosisRecord) -> str:
    gain = record.predictive_gain
    is_doubtful = record.is_explained and gain is not None and not gain.is_supported
    return "; left-out data do not confirm it" if is_doubtful else ""


def applied(record: DiagnosisRecord) -> str:
    """The effects of the extended model with their locations."""
    return " and ".join(f"{effect.name} ({effect.location})" for effect in record.applied)


def alike(record: DiagnosisRecord) -> tuple[str, ...]:
    """The effects, or where these explain the data the pairs of them, that explain the data about as well."""
    pairs = dict.fromkeys(each.label for each in record.explanations if len(each.effects) > 1)
    return tuple(pairs) or record.ambiguity_group


def _at(location: str) -> str:
    return location if location.startswith("at ") else f"({location})"


def _said(effect: EffectRecord, notation: Notation) -> str:
    """The statement of an effect; of an older record its name and location."""
    return statements.sentence(_stated(effect), notation)


def _stated(effect: EffectRecord) -> StatementRecord:
    if effect.statement is not None:
        return effect.statement
    words = effect.name.replace("_", " ")
    return StatementRecord(words, f"{capital(words)} {_at(effect.location)}", place=effect.location)


def _either(record: DiagnosisRecord, notation: Notation) -> str:
    """The explanations, each once and without its sizes: 'unbalance at 1 m or residual bow'."""
    found: dict[str, str] = {}
    for each in record.explanations:
        stated = [_stated(effect) for effect in each.effects]
        words = " with ".join(
            one.words if one.place in ("", UNSAID) else f"{one.words} {_at(statements.place(one.place, notation))}"
            for one in stated
        )
        found.setdefault(" with ".join(one.words for one in stated), words)
    names = list(found.values()) or [name.replace("_", " ") for name in record.ambiguity_group]
    if len(names) == 1:
        return capital(f"{names[0]} ({' or '.join(statements.place(each, notation) for each in record.locations)})")
    return capital(f"{', '.join(names[:-1])} or {names[-1]}")


def _how_well(record: DiagnosisRecord) -> str:
    """'; kxx and kyy are known to 0.1 %, cxx and cyy to 7 %'; '' where no interval is closed."""
    widths = {
        row.name: half / abs(row.before.value)
        for row in record.coefficients
        if row.before is not None
        and row.before.unit != ANGLE
        and (half := half_width(row.before.shown)) is not None
        and row.before.value
    }
    groups: list[list[str]] = []
    for name in sorted((each for each in widths if widths[each] < 1), key=widths.__getitem__):
        if groups and widths[name] <= ALIKE * widths[groups[-1][0]]:
            groups[-1].append(name)
        else:
            groups.append([name])
    if not groups:
        return ""
    said = [f"{_listed(group)}{{}} to {number(100 * widths[group[-1]], 1)} %" for group in groups]
    verb = " is known" if len(groups[0]) == 1 else " are known"
    return "; " + ", ".join([said[0].format(verb), *(each.format("") for each in said[1:])])


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _best(record: DiagnosisRecord) -> tuple[float, float] | None:
    """Deviance drop and ΔBIC of the best explanation; None where nothing is explained."""
    if record.explanations:
        return record.explanations[0].deviance_drop, record.explanations[0].delta_bic
    if record.is_explained and record.ranking:
        return record.ranking[0].deviance_drop, record.ranking[0].delta_bic
    return None


def _needed(record: DiagnosisRecord, rise: float) -> float:
    """Noise that an explanation needs, relative to the best one, whose deviance is lower by `rise`."""
    curves, after = record.curves, record.lack_of_fit.after
    assert curves is not None, "others() needs curves"
    n = len(curves.speed) * len(curves.channels) * (2 if _has_phase(curves) else 1)
    if record.noise.known and after is not None:
        return math.sqrt(1 + max(rise, 0.0) / (n * max(after.reduced_chi2, 1e-12)))
    return math.exp(min(max(rise, 0.0) / (2 * n), math.log(MOST_MULTIPLE)))


def _times(multiple: float) -> str:
    more = "more than " if multiple >= MOST_MULTIPLE else ""
    return f"{TIMES} {more}{number(multiple, 2) if multiple >= 1.05 else f'{multiple:.2f}'}"


def odds(behind: float, at_most: str = "more than 1\u00a0000\u00a0000") -> str:
    """Odds of the better of two explanations, exp(ΔBIC/2) (Kass & Raftery 1995), with two digits."""
    most = 2 * math.log(MOST_ODDS)
    odds = math.exp(min(behind, most) / 2)
    digits = f"{round(odds, 1 - math.floor(math.log10(odds))):,.0f}".replace(",", "\u00a0")
    return at_most if behind >= most else digits


def _noise(level: NoiseLevelRecord, notation: Notation) -> str:
    """'6.2 % of each reading + 0.009 mil pp'."""
    parts = [f"{two_digits(100 * level.relative)} % of each reading"] if level.relative else []
    if level.floor > LEAST_FLOOR or not parts:
        parts.append(f"{two_digits(notation.vibration(level.floor))} {notation.unit}")
    return " + ".join(parts)


def _has_phase(curves: CurvesRecord) -> bool:
    return isinstance(curves.responses.measured[0][0], tuple)
