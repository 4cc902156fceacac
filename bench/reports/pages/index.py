"""The page over all results of a folder.

It has the kind, date and finding of each result, and how many runs failed or have not ended.

It is made of the beginnings of the pages and of small pictures, so that writing it again costs little. It holds all of
them itself, and requests nothing.
"""

from __future__ import annotations

import base64
import io
import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from PIL import Image

from bench.plan.plan import PLAN_FILE
from bench.reports.pages import bundle
from bench.reports.pages.document import FACTS, FACTS_WITHIN, PAGE, facts_of
from bench.reports.pages.made_by import command_line
from bench.reports.pages.prose import safe, unbroken
from bench.storage.files import replace_file
from ksmea.errors import SettingError, shortened
from ksmea.settings.regular_files import open_regular
from ksmea.show.text import capital

RESULTS = "results"  # folder whose index is kept by itself
DEPTHS = ("*", "*/*")  # below the folder: experiments, and those that an experiment includes
LONGEST = 300  # characters of what was found
COUNTS = ("failed", "unfinished")  # runs, shown if there are any
MOST_UNFILTERED = 10  # rows; of more a reader can choose by words
MOST_PICTURES = 30  # rows with a picture, the latest ones
SMALL, N_COLOUR = (240, 134), 64  # px, and colours of a picture: about 8 kB
DARKER = 3.0  # exponent of each colour's part of white
PICTURES = (
    "finding.png",
    "location.png",
    "rotor.png",
    "_factors.png",
    "_solved.png",
)  # ends of names of what shows most
# A picture in an index, and the file and its time that it was made of
IN_INDEX = re.compile(r'<img alt="" data-of="([^"]*)" src="data:image/png;base64,([A-Za-z0-9+/=]*)">')


def write_index_above(output: Path) -> None:
    """Write the index of the folder `results` that holds an experiment's folder.

    If there is an index in the folder above, that one is written. Failure to write has no other consequence.
    """
    folder = output.absolute()
    root = next((each for each in folder.parents if each.name == RESULTS), folder.parent)
    if root.name == RESULTS or _is_index(root / PAGE):
        try:
            write_index(root)
        except (OSError, SettingError):  # a folder of others: the experiment's own page is written
            return


def write_index(folder: Path) -> Path:
    """Write the index of a folder; `SettingError` if a page of another kind stands there."""
    path = folder / PAGE
    if path.exists() and not _is_index(path):
        raise SettingError(f"{path}: expected an index of results or none, found another page; move it away")
    replace_file(path, index_page(folder))
    return path


def index_page(folder: Path) -> bytes:
    """The index of all experiments whose results lie in a folder, the latest first."""
    found = {place: page_facts(folder / place) for place in _experiments(folder)}
    ordered = sorted(found.items(), key=lambda item: (str(item[1].get("when", "")), str(item[0])), reverse=True)
    counted = [each for each in COUNTS if any(facts.get(each) for facts in found.values())]
    known = _pictures_in(folder / PAGE)
    images = [_image(folder, place, known) if "study" in each else "" for place, each in ordered[:MOST_PICTURES]]
    images += [""] * (len(ordered) - len(images))
    rows = "".join(_row(place, each, counted, image) for (place, each), image in zip(ordered, images, strict=True))
    head = "".join(
        f'<th scope="col"{attribute}>{name}</th>'
        for name, attribute in (
            ("results", ""), ("", ""), ("found", ""), ("runs", ' class="number"'),
            *((each, ' class="number"') for each in counted), ("when", ""), ("study", ""),
        )
    )  # fmt: skip
    table = (
        f'<div class="scroll" tabindex="0" role="region" aria-label="results"><table class="index"><thead><tr>{head}</tr></thead>'
        f"<tbody>{rows}</tbody></table></div>"
    )
    body = table if found else "<p>No results yet: python -m bench help shows what there is to run.</p>"
    script, style = bundle.asset("page.js"), bundle.asset("page.css")
    policy = (
        f"default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src {bundle.digest_of(script.encode())}"
    )
    field = '<p class="filter" hidden><label>Only rows with <input type="search" data-filter></label></p>'
    only = field if len(found) > MOST_UNFILTERED else ""
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8">\n<meta name="{FACTS}" content="{safe(INDEX)}">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{safe(policy)}">'
        f'<meta name="viewport" content="width=device-width, initial-scale=1"><title>Results</title><style>{style}</style></head>\n'
        f"<body><header><h1>Results</h1><p>{len(found)} in {safe(folder.absolute().name)}</p></header>\n<main>{only}{body}</main>\n"
        f"<script>{script}</script></body></html>\n"
    ).encode()


INDEX = json.dumps({"index": True})  # the facts of an index itself


def page_facts(folder: Path) -> Mapping[str, Any]:
    """Facts stated on an experiment's page; without a page, the name in its plan and how to make the page."""
    page = folder / PAGE
    found = facts_of(_beginning(page)) if page.is_file() else None
    if found is not None and "index" not in found:
        return found
    again = {"headline": f"no page yet: {command_line(['collect', _name(folder)])}"}
    try:
        head = json.loads(_beginning(folder / PLAN_FILE, lines=1))
    except (ValueError, RecursionError):
        return again
    return {"name": head.get("name", ""), **again} if isinstance(head, dict) else again


def _name(folder: Path) -> str:
    """Argument by which `collect` finds a folder: its path within `results`, or the path as given."""
    whole = folder.absolute()
    root = next((each for each in whole.parents if each.name == RESULTS), None)
    return str(folder) if root is None else whole.relative_to(root).as_posix()


def _experiments(folder: Path) -> list[Path]:
    """Folders of experiments and others with a page of this project, as paths from the folder.

    Drawings are an example of the latter.
    """
    plans = {path for depth in DEPTHS for path in folder.glob(f"{depth}/{PLAN_FILE}") if path.is_file()}
    pages = {path for depth in DEPTHS for path in folder.glob(f"{depth}/{PAGE}") if _is_page(path)}
    return sorted({path.parent.relative_to(folder) for path in plans | pages})


def _is_page(path: Path) -> bool:
    facts = facts_of(_beginning(path)) if path.is_file() else None
    return facts is not None and "study" in facts


def _is_index(path: Path) -> bool:
    return path.is_file() and (facts_of(_beginning(path)) or {}).get("index") is True


def _beginning(path: Path, lines: int = 0) -> str:
    """The first characters of a file, or its first line; '' where it cannot be read."""
    try:
        with open_regular(path) as file:
            return (file.readline() if lines else file.read(FACTS_WITHIN)).decode("utf-8", "replace")
    except (OSError, SettingError):
        return ""


def _row(place: Path, facts: Mapping[str, Any], counted: Sequence[str], image: str) -> str:
    """A row of the table; of what is counted a number above 0."""
    name = str(place)
    has_page = "study" in facts
    shown = f'<a href="{safe(quote(place.as_posix()))}/{PAGE}">{safe(name)}</a>' if has_page else safe(name)
    when = str(facts.get("when", ""))[:16].replace("T", " ")
    found = unbroken(safe(capital(shortened(str(facts.get("headline", "")), LONGEST))))
    n_run = facts.get("runs", "")
    numbers = (
        f'<td class="number" data-label="{label}">{safe(number)}</td>'
        for label, number in (
            ("run" if n_run == 1 else "runs", n_run),
            *((each, facts.get(each) or "") for each in counted),
        )
    )
    texts = (f'<td class="when">{safe(when)}</td>', f"<td>{safe(facts.get('study', ''))}</td>")
    cells = [f'<td class="name">{shown}</td>', f'<td class="small">{image}</td>', f'<td class="long">{found}</td>']
    cells += [*numbers, *texts]
    return f"<tr>{''.join(cells)}</tr>"


def _pictures_in(index: Path) -> dict[str, str]:
    """Small pictures that an index has already, by what they were made of."""
    if not _is_index(index):
        return {}
    try:
        with open_regular(index) as content:
            return dict(IN_INDEX.findall(content.read().decode("utf-8", "replace")))
    except (OSError, SettingError):
        return {}


def _image(root: Path, place: Path, known: Mapping[str, str]) -> str:
    """A small picture of the finding of a page's folder; empty without one that can be read.

    One that is `known` is not made again, so that an index of many costs little at the end of each experiment.
    """
    folder = root / place
    there = sorted(path.name for path in folder.glob("*.png"))
    file = next((each for end in PICTURES for each in there if each.endswith(end)), next(iter(there), None))
    if file is None:
        return ""
    try:
        of = safe(f"{(place / file).as_posix()} {(folder / file).stat().st_mtime_ns}")
        if (data := known.get(of)) is None:
            with open_regular(folder / file) as content, Image.open(content) as whole:
                data = base64.b64encode(_small(whole)).decode()
    except (OSError, SettingError, ValueError, Image.DecompressionBombError):
        return ""
    return f'<img alt="" data-of="{of}" src="data:image/png;base64,{data}">'


def _small(whole: Image.Image) -> bytes:
    """The upper part of a picture in few colours, some kilobytes that the index holds itself.

    It is darker than the whole: thin lines are pale where they are made small.
    """
    width, height = SMALL
    scaled = whole.convert("RGB").resize((width, max(round(width * whole.height / whole.width), 1)))
    scaled = scaled.point([round(255 * (level / 255) ** DARKER) for level in range(256)] * len(scaled.getbands()))
    content = io.BytesIO()
    scaled.crop((0, 0, width, min(height, scaled.height))).quantize(N_COLOUR).save(content, format="PNG", optimize=True)
    return content.getvalue()
