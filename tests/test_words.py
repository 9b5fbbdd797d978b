"""Docstrings, comments and messages use the terms of the glossary."""

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("linkages", "optim", "tests", "benchmarks")


def replaced_words() -> list[str]:
    """Return the words of the glossary's last table, which a term replaced."""
    table = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8").split("## Replaced words")[1]
    rows = re.findall(r"^\| ([^|]+) \| [^|]+ \|$", table, re.MULTILINE)[1:]
    return [word for row in rows for word in row.split(", ")]


def prose(text: str) -> Iterator[tuple[int, str]]:
    """Yield line and text of each comment, and of each string with a space: docstrings and messages."""
    comments = (t for t in tokenize.generate_tokens(io.StringIO(text).readline) if t.type == tokenize.COMMENT)
    yield from ((token.start[0], token.string) for token in comments)
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value.strip():
            yield node.lineno, node.value


@pytest.mark.parametrize("folder", FOLDERS)
def test_no_replaced_word_returns(folder):
    words = replaced_words()
    assert len(words) >= 20
    pattern = re.compile(rf"\b({'|'.join(map(re.escape, words))})\b", re.IGNORECASE)
    found = [
        f"{path.relative_to(ROOT)}:{line}: {hit[0]}"
        for path in sorted((ROOT / folder).rglob("*.py"))
        for line, text in prose(path.read_text(encoding="utf-8"))
        if (hit := pattern.search(" ".join(re.sub(r"`[^`]*`", "", text).split())))
    ]
    assert not found, "docs/glossary.md has the terms"
