"""Command lines after slips of a hand: arguments of experiments and commands, drawn from a seed."""

import random

LINES = [
    ["+experiment=table3", "samples=40,70", "repetitions=2", "optimizer.population=30"],
    ["+experiment=identify", "measurement=synthetic", "measurement.relative=0.05", "problem.sensors=[0.1,0.5]"],
    ["+experiment=diagnose", "measurement.hidden=[runout]", "study.effects=[runout,mass]", "output=results/x"],
    ["method=direct", "optimizer=de,pso", "optimizer.de.population=20", "seed=range(0,5)", "workers=1"],
    ["grid=[{label: A, samples: 40},{label: B, samples: [70, 100]}]", "cross=[{measurement.floor: 0.1}]", "label=A"],
    ["problem=drawn", "problem.family=one_disk", "problem.instance=1,2", "measurement=drawn", "own_seeds=instance"],
    ["status", "run"],
    ["explain", "0123abcd", "run"],
    ["collect", "run"],
    ["compare", "run", "run", "--out", "both"],
    ["merge", "run", "run", "--out", "both"],
    ["export", "csv", "run", "--out", "courses"],
    ["export", "measurement", "--out", "run.csv", "problem=three_disk"],
    ["import", "run.csv", "--format", "csv", "--out", "new.csv"],
    ["import", "rotor", "model.toml", "--out", "rotor.yaml"],
    ["draw", "problem=three_disk", "problem.mesh=13"],
    ["new", "optimizer", "my_search", "--file"],
    ["help", "optimizer", "de"],
    ["help", "table3", "samples"],
    ["completion", "bash"],
    ["--version"],
]
TOKENS = [
    *(
        "",
        "=",
        "==",
        ",",
        ",,",
        "[",
        "]",
        "{",
        "}",
        "(",
        ")",
        "'",
        '"',
        "\\",
        "$",
        "${",
        "${x}",
        "${name}",
        "+",
        "++",
        "~",
        "-",
        "--",
        "*",
    ),
    *(
        "null",
        "nan",
        "inf",
        "-inf",
        "true",
        "1e400",
        "-1",
        "0",
        "1.5",
        "1,5",
        "0x10",
        "9" * 40,
        "a" * 500,
        "#" * 300,
        "..",
        "/",
        "/dev/null",
    ),
    *(
        "glob(*)",
        "range(0,10)",
        "range(5,1)",
        "range(0,1e9)",
        "choice(a,b)",
        "shuffle(1,2)",
        "tag(a,1)",
        "interval(0,1)",
        "sort(1,2)",
    ),
    *(
        "µ",
        "→",
        "\udce4",
        "\x1b[31m",
        "\n",
        "\t",
        "\0",
        "日本",
        "e\u0301",
        "?",
        "%s",
        "{0}",
        "<b>",
        "&",
        ";",
        "|",
        "`",
        "@x",
        "a@b",
    ),
    *(
        "optimizer",
        "dee",
        "samples",
        "hydra.mode=RUN",
        "--config-dir",
        "--cfg",
        "job",
        "-m",
        "-q",
        "-v",
        "-h",
        "--help",
        "plugins=[nope.py]",
    ),
]


def mutated(seed):
    """A command line with one to three slips, or of two lines."""
    draw = random.Random(seed)
    words = list(draw.choice(LINES))
    for _ in range(draw.choice((1, 1, 2, 3))):
        words = draw.choice((_token, _token, _inserted, _left_out, _twice, _cut, _swapped, _other_line))(draw, words)
    return words


def _token(draw, words):
    at = draw.randrange(len(words)) if words else 0
    word = words[at] if words else ""
    key, sign, value = word.partition("=")
    changed = draw.choice(
        (draw.choice(TOKENS), f"{key}{sign}{draw.choice(TOKENS)}", f"{draw.choice(TOKENS)}{sign}{value}")
    )
    return [*words[:at], changed, *words[at + 1 :]]


def _inserted(draw, words):
    at = draw.randint(0, len(words))
    if words and draw.random() < 0.5:
        word = words[min(at, len(words) - 1)]
        inside = draw.randint(0, len(word))
        return [*words[:at], word[:inside] + draw.choice(TOKENS) + word[inside:], *words[at + 1 :]]
    return [*words[:at], draw.choice(TOKENS), *words[at:]]


def _left_out(draw, words):
    at = draw.randint(0, len(words))
    return [*words[:at], *words[at + 1 :]]


def _twice(draw, words):
    return [*words, draw.choice(words)] if words else words


def _cut(draw, words):
    at = draw.randrange(len(words)) if words else 0
    return [*words[:at], words[at][: draw.randint(0, len(words[at]))], *words[at + 1 :]] if words else words


def _swapped(draw, words):
    return draw.sample(words, len(words))


def _other_line(draw, words):
    return [*words, *draw.choice(LINES)]
