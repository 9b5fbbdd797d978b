"""Files, ``--set`` values and results with something wrong in them, made at random, the same ones for the same seed."""

from __future__ import annotations

import copy
import json
import random
import re
import tomllib
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

from shipped import BENT, NAMES, STUDIES_FOLDER

from linkages.input.files.shipped import data_folder
from linkages.input.files.table_keys import table_keys
from linkages.input.files.toml import leaves
from linkages.input.model.experiment import Experiment

MACHINES = [path for path in sorted(data_folder().glob("*.sdf")) if not path.stem.startswith("three_rrr")]
EXPERIMENTS = [data_folder() / f"{name}.toml" for name in (*NAMES, *BENT)]
STUDIES = sorted(STUDIES_FOLDER.glob("*.toml"))

ET.register_namespace("linkages", "urn:linkages:sdf")
NUMBER = re.compile(rb"(?<![\w.\"])[-+]?\d+(\.\d*)?([eE][-+]?\d+)?(?![\w.\"])")
VALUES = """nan inf -inf 1e400 1e308 -1e308 1e200 1e150 1e100 -1e100 1e60 1e49 -1e49 1e30 1e20 -1e20 1e12 1e9 1e6 -1e6 1e4 1e3
-1 -0.0 0 1 2 0.5 1e-3 1e-9 -1e-9 1e-12 1e-20 1e-30 1e-49 1e-60 1e-150 1e-200 5e-324 true text "text" "" [] {} [[1]]
1979-05-27 [1,2] [1e300,0,0] {x=1} "nan" world "a\\u0000/b" ../../.. . / 1_000 0b1 "finite" "reynolds" "dry" "mixed"
"lubricated" "ideal" "none" "radau3" "runge_kutta5" "prismatic" "fixed" """.split()  # noqa: SIM905
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
PATHS = sorted({path.replace("NAME", name) for path, _ in table_keys(Experiment) for name in ("A", "O", "O1", "B")})


def nested(content: Any) -> list[Any]:
    """Find the tables and lists of JSON that have something in them, the outer ones first."""
    if not isinstance(content, dict | list) or not content:
        return []
    inner = content.values() if isinstance(content, dict) else content
    return [content, *(found for part in inner for found in nested(part))]


class Mutator:
    """Makes mutants, the same ones for the same seed."""

    def __init__(self, seed: int | str) -> None:
        self.dice = random.Random(seed)

    def mutant(self, data: bytes) -> bytes:
        """Change a file in one or two places."""
        xml = data.lstrip().startswith(b"<")
        ways = [self.number] * 8 + [self.byte, self.piece, self.line, self.line, self.deep, self.encoded]
        ways += [self.element] * 4 if xml else [self.value] * 4
        for _ in range(self.dice.choice((1, 1, 2))):
            data = self.dice.choice(ways)(data)
        return data

    def damage(self, data: bytes) -> bytes:
        """Change a binary file: a few bytes, a slice, a block or the end."""
        at, size = self.dice.randrange(len(data)), self.dice.choice((16, 512, 4096))
        match self.dice.randrange(6):
            case 0:
                return self.piece(data)
            case 1:
                return data[:at] + self.dice.randbytes(size) + data[at + size :]
            case 2:
                return data[:at] + bytes(size) + data[at + size :]
            case 3:
                return data[:at]
        for _ in range(self.dice.choice((1, 1, 2, 8))):
            data = self.byte(data)
        return data

    def result(self, name: str, data: bytes) -> bytes:
        """Change a file of results."""
        ways = [self.damage, self.json] if name.endswith(".json") else [self.damage]
        if not name.endswith((".npz", ".png", ".block")):
            ways.append(self.mutant)
        return self.dice.choice(ways)(data)

    def json(self, data: bytes) -> bytes:
        """Drop, double, rename or replace a value of JSON."""
        whole = json.loads(data)
        places = [
            (where, key) for where in nested(whole) for key in (where if isinstance(where, dict) else range(len(where)))
        ]
        (where, key), (other, name) = self.dice.choice(places), self.dice.choice(places)
        match self.dice.randrange(4):
            case 0:
                del where[key]
            case 1:
                where[key] = copy.deepcopy(other[name])
            case 2 if isinstance(where, dict):
                where[f"{key}x"] = where.pop(key)
            case _:
                where[key] = self.dice.choice(
                    (None, True, "", "x", "\ud800", -1, 0, 0.5, 1e308, float("nan"), 10**400, [], {}, [[]])
                )
        return json.dumps(whole).encode()

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
        """Drop, double or move a slice."""
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


def write(mutator: Mutator, folder: Path, kind: str) -> tuple[Path, list[str]]:
    """Write a mutant of an experiment, its machine or a study, or an experiment; returns it and its settings."""
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
