"""Docstrings, comments, messages and shipped files use the terms of the glossary."""

import ast
import io
import re
import tokenize
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("linkages", "optim", "tests", "benchmarks", "docs")
#: Files whose whole text is prose, or has it in comments and titles.
TEXTS = ("sdf/*.sdf", "sdf/*.toml", "optim/studies/*.toml", "linkages/**/*.html", "notebooks/*.ipynb", "*.md")


def replaced_words() -> list[str]:
    """Return the words that a term of the glossary replaced."""
    terms = tomllib.loads((ROOT / "tests" / "replaced_words.toml").read_text(encoding="utf-8"))
    return [word for words in terms.values() for word in words]


def prose(text: str) -> Iterator[tuple[int, str]]:
    """Yield line and text of each comment, and of each string with a space: docstrings and messages."""
    comments = (t for t in tokenize.generate_tokens(io.StringIO(text).readline) if t.type == tokenize.COMMENT)
    yield from ((token.start[0], token.string) for token in comments)
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value.strip():
            yield node.lineno, node.value


@pytest.fixture
def pattern() -> re.Pattern[str]:
    words = replaced_words()
    assert len(words) >= 20
    return re.compile(rf"\b({'|'.join(map(re.escape, words))})\b", re.IGNORECASE)


@pytest.mark.parametrize("folder", FOLDERS)
def test_no_replaced_word_returns(folder, pattern):
    found = [
        f"{path.relative_to(ROOT)}:{line}: {hit[0]}"
        for path in sorted((ROOT / folder).rglob("*.py"))
        for line, text in prose(path.read_text(encoding="utf-8"))
        if (hit := pattern.search(" ".join(re.sub(r"`[^`]*`", "", text).split())))
    ]
    assert not found, "tests/replaced_words.toml has the terms"


@pytest.mark.parametrize("files", TEXTS)
def test_no_replaced_word_is_in_shipped_files(files, pattern):
    texts = {path: " ".join(path.read_text(encoding="utf-8").split()) for path in sorted(ROOT.glob(files))}
    assert texts
    found = [f"{path.relative_to(ROOT)}: {hit[0]}" for path, text in texts.items() if (hit := pattern.search(text))]
    assert not found, "tests/replaced_words.toml has the terms"
