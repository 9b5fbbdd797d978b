"""Files and ``--set`` values with something wrong in them: one line of refusal or finite numbers, and soon."""

from __future__ import annotations

import copy
import json
import random
import re
import signal
import time
import tomllib
import xml.etree.ElementTree as ET
from collections import Counter
from contextlib import contextmanager

import numpy as np
import pytest
from shipped import NAMES

import linkages
import optim
from linkages.cli.main import main
from linkages.errors import InputError, RunError
from linkages.files.shipped import data_folder
from linkages.files.toml import leaves
from linkages.model.experiment import keys
from optim.problem.shipped import studies_folder

LOADED, SIMULATED = 500, 40  # mutants of every run of the tests
LONGEST = 20  # s for one mutant

MACHINES = [path for path in sorted(data_folder().glob("*.sdf")) if path.stem != "three_rrr"]
EXPERIMENTS = [data_folder() / f"{name}.toml" for name in NAMES]
STUDIES = sorted(studies_folder().glob("*.toml"))

ET.register_namespace("linkages", "urn:linkages:sdf")
NUMBER = re.compile(rb"(?<![\w.\"])[-+]?\d+(\.\d*)?([eE][-+]?\d+)?(?![\w.\"])")
VALUES = """nan inf -inf 1e400 1e308 -1e308 1e200 1e150 1e100 -1e100 1e60 1e49 -1e49 1e30 1e20 -1e20 1e12 1e9 1e6 -1e6 1e4 1e3
-1 -0.0 0 1 2 0.5 1e-3 1e-9 -1e-9 1e-12 1e-20 1e-30 1e-49 1e-60 1e-150 1e-200 5e-324 true text "text" "" [] {} [[1]]
1979-05-27 [1,2] [1e300,0,0] {x=1} "nan" world "a\\u0000/b" ../../.. . / 1_000 0b1""".split()  # noqa: SIM905
VALUES += [
    "9" * 400,
    "-" + "9" * 5000,
    "0x" + "f" * 5000,
    "[" * 3000,
    "[" * 60 + "]" * 60,
    '"' + "x" * 300 + '"',
    "1 2 3 4 5 6",
]
FACTORS = (-1.0, 0.5, 0.99, 1.01, 2.0, 10.0, *(10.0**power for power in range(-48, 49, 3)))
ENCODINGS = """utf-16 utf-16-le utf-32 utf-7 latin-1 cp037 cp1252 shift_jis gb18030 big5 euc-kr iso2022_jp base64 hex rot13 zlib idna
punycode unicode_escape raw_unicode_escape undefined mbcs koi8-r nonsense""".split()  # noqa: SIM905
PATHS = sorted({path.replace("NAME", name) for path, _ in keys() for name in ("A", "O", "O1", "B")})


class Mutator:
    """Makes mutants, the same ones for the same seed."""

    def __init__(self, seed: int) -> None:
        self.dice = random.Random(seed)

    def mutant(self, data: bytes) -> bytes:
        """Change a file in one or two places."""
        xml = data.lstrip().startswith(b"<")
        ways = [self.number] * 8 + [self.byte, self.piece, self.line, self.line, self.deep, self.encoded]
        ways += [self.element] * 4 if xml else [self.value] * 4
        for _ in range(self.dice.choice((1, 1, 2))):
            data = self.dice.choice(ways)(data)
        return data

    def setting(self, text: str) -> str:
        """Make an item of ``--set`` for an experiment with this text."""
        own = [path for path, _ in leaves(tomllib.loads(text))]
        machine = [
            f"sdf.links.{link}.{key}" for link in ("crank", "link2") for key in ("mass", "com.x", "inertia", "pose.x")
        ]
        path = self.dice.choice((self.dice.choice(own), self.dice.choice(PATHS), self.dice.choice(machine)))
        if self.dice.random() < 0.05:
            path = self.dice.choice(
                (path + ".x", path[:-1], ".", "a" + ".a" * 2000, "sdf" + ".a" * 2000, "", path.upper())
            )
        return f"{path}={self.dice.choice(VALUES)}"

    def number(self, data: bytes) -> bytes:
        """Replace or scale a number."""
        found = list(NUMBER.finditer(data))
        if not found:
            return data
        place = self.dice.choice(found)
        if self.dice.random() < 0.5:
            return self.put(data, place.span())
        return self.put(data, place.span(), b"%.6g" % (float(place[0]) * self.dice.choice(FACTORS)))

    def value(self, data: bytes) -> bytes:
        """Replace a value of TOML, whatever it is."""
        found = list(re.finditer(rb"(?<=[=])[^=#\n]+", data))
        return self.put(data, self.dice.choice(found).span()) if found else data

    def put(self, data: bytes, span: tuple[int, int], value: bytes = b"") -> bytes:
        return data[: span[0]] + b" " + (value or self.dice.choice(VALUES).encode()) + b" " + data[span[1] :]

    def byte(self, data: bytes) -> bytes:
        """Flip bits of a byte."""
        changed = bytearray(data)
        if changed:
            changed[self.dice.randrange(len(changed))] ^= self.dice.randrange(1, 256)
        return bytes(changed)

    def piece(self, data: bytes) -> bytes:
        """Drop, double or move a piece."""
        i, j, k = sorted(self.dice.randrange(len(data) + 1) for _ in range(3))
        return self.dice.choice((data[:i] + data[j:], data[:j] + data[i:], data[:i] + data[j:k] + data[i:j] + data[k:]))

    def line(self, data: bytes) -> bytes:
        """Drop, double or swap lines."""
        lines = data.split(b"\n")
        i, j = (self.dice.randrange(len(lines)) for _ in range(2))
        match self.dice.randrange(3):
            case 0:
                del lines[i]
            case 1:
                lines.insert(j, lines[i])
            case _:
                lines[i], lines[j] = lines[j], lines[i]
        return b"\n".join(lines)

    def deep(self, data: bytes) -> bytes:
        """Nest deep, somewhere."""
        n, at = self.dice.choice((30, 150, 2000, 50_000)), self.dice.randrange(len(data) + 1)
        pairs = (
            (b"<a>", b"</a>"),
            (b"[", b"]"),
            (b"{a=", b"}"),
            (b"[a.", b"]"),
            (b"a.", b"b=1"),
            (b"(", b")"),
            (b"<!--", b"-->"),
        )
        left, right = self.dice.choice(pairs)
        if right == b"]" and self.dice.random() < 0.5:
            return data + b"\n[sdf" + b".a" * n + b"]\nx = 1\n"
        return data[:at] + left * n + self.dice.choice((b"", right * n)) + data[at:]

    def encoded(self, data: bytes) -> bytes:
        """Say another encoding, or use one."""
        name = self.dice.choice(ENCODINGS)
        said = re.sub(rb"^(<\?xml[^>]*\?>)?", b'<?xml version="1.0" encoding="%s"?>' % name.encode(), data, count=1)
        try:
            return self.dice.choice((said, said, data.decode("utf-8").encode(name), said.decode("utf-8").encode(name)))
        except (LookupError, ValueError):
            return said

    def element(self, data: bytes) -> bytes:
        """Drop, double, move, nest or empty an element, or change an attribute."""
        try:
            root = ET.fromstring(data)
        except (ET.ParseError, ValueError, LookupError):
            return data
        parents = [(parent, child) for parent in root.iter() for child in parent]
        if not parents:
            return data
        (parent, child), (other, _) = self.dice.choice(parents), self.dice.choice(parents)
        match self.dice.randrange(6):
            case 0:
                parent.remove(child)
            case 1:
                parent.append(copy.deepcopy(child))
            case 2:
                other.append(copy.deepcopy(child))
            case 3:
                for _ in range(self.dice.choice((1, 200))):
                    shell = ET.Element(child.tag, child.attrib)
                    shell.append(child)
                    child = shell
                parent.append(child)
            case 4:
                child.text = self.dice.choice(("", "world", "__model__", *VALUES)).replace("\0", "")
            case _:
                names = [*child.attrib, "relative_to", "degrees", "rotation_format", "attached_to", "expressed_in"]
                words = [element.get("name", "") for element in root.iter()] + [
                    "",
                    "world",
                    "__model__",
                    "true",
                    "quat_xyzw",
                ]
                child.set(self.dice.choice(names), self.dice.choice(words))
        return ET.tostring(root)


@contextmanager
def at_most(seconds: int):
    """Press Ctrl-C if it lasts longer."""
    before = signal.signal(signal.SIGALRM, lambda *_: signal.raise_signal(signal.SIGINT))
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def write(mutator: Mutator, folder, kind: str):
    """Write a mutant of an experiment with its machine, or of a study; returns the file and the settings for it."""
    for path in (*MACHINES, *EXPERIMENTS):
        if not (folder / path.name).exists():
            (folder / path.name).write_bytes(path.read_bytes())
    experiment = mutator.dice.choice(STUDIES if kind == "study" else EXPERIMENTS)
    text = experiment.read_text(encoding="utf-8")
    file, settings = folder / "mutant.toml", []
    if kind == "machine":
        name = tomllib.loads(text)["mechanism"]
        (folder / "mutant.sdf").write_bytes(mutator.mutant((data_folder() / name).read_bytes()))
        text = text.replace(f'"{name}"', '"mutant.sdf"')
    elif kind == "setting":
        settings = [mutator.setting(text) for _ in range(mutator.dice.choice((1, 1, 2)))]
    file.write_bytes(text.encode() if kind in ("machine", "setting") else mutator.mutant(text.encode()))
    return file, settings


def numbers(content):
    """Every number in nested tables."""
    if isinstance(content, dict):
        content = list(content.values())
    if isinstance(content, list):
        for value in content:
            yield from numbers(value)
    elif isinstance(content, float):
        yield content


def load_mutants(count: int, seed: int, folder) -> Counter:
    """Load mutants; returns how often each end came, and fails at the first with another one."""
    mutator, ends = Mutator(seed), Counter()
    for k in range(count):
        kind = mutator.dice.choice(("machine", "machine", "experiment", "experiment", "setting", "study"))
        file, settings = write(mutator, folder, kind)
        try:
            with at_most(LONGEST):
                if kind == "study":
                    study = optim.load_study(file)
                    found = [study.lower, study.upper, study.nominal, *study.designs.values()]
                else:
                    system = linkages.load(file, dict(item.split("=", 1) for item in settings))
                    found = [system.gravity, *system.motions(np.zeros(1))]
                    found += [system.tree.bodies[name] for name in ("mass", "inertia")]
            ends["taken"] += 1
        except (InputError, RunError) as problem:
            ends["one line" if "\n" not in str(problem) else "many lines"] += 1
            continue
        assert all(np.isfinite(values).all() for values in found), (seed, k, kind, settings)
    return ends


def simulate_mutants(count: int, seed: int, folder, capsys, seconds: float = np.inf) -> Counter:
    """Simulate mutants for as long as there are seconds; returns how often each exit status came."""
    mutator, ends, started = Mutator(seed), Counter(), time.monotonic()
    for k in range(count):
        if time.monotonic() - started > seconds:
            break
        file, settings = write(mutator, folder, mutator.dice.choice(("machine", "experiment", "setting")))
        out = folder / f"out{k}"
        words = [
            "simulate",
            str(file),
            "--engine",
            "compiled",
            "--no-plots",
            "--no-animation",
            "--duration",
            "0.01",
            "--out",
            str(out),
        ]
        with at_most(LONGEST):
            status = main([*words, *(word for item in settings for word in ("--set", item))])
        said = capsys.readouterr().err.splitlines()
        assert status in (0, 1, 2), (seed, k)
        assert len(said) == 1 or status != 2, (seed, k, said)
        if (out / "summary.json").exists():
            summary = json.loads((out / "summary.json").read_text(), parse_constant=lambda word: pytest.fail(word))
            if summary["status"] == "ok":
                assert None not in [output["peak"] for output in summary["outputs"].values()], (seed, k)
            assert np.isfinite(list(numbers(summary))).all()
        ends[status] += 1
    return ends


@pytest.mark.slow
def test_mutants_are_loaded_or_refused_in_one_line(tmp_path):
    ends = load_mutants(LOADED, 1, tmp_path)
    assert set(ends) == {"taken", "one line"}
    assert min(ends.values()) > 0.1 * LOADED


@pytest.mark.slow
def test_mutants_are_simulated_to_finite_numbers_or_refused(tmp_path, capsys):
    ends = simulate_mutants(SIMULATED, 1, tmp_path, capsys)
    assert min(ends[0], ends[2]) > 0.1 * SIMULATED
