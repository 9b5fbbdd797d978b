"""Finds the private numerical constants of a folder that no test notices.

Run as a script: ``python tests/constants.py linkages/results tests/test_results.py tests/test_validity.py``. The tests run
once, to see which of them enter the functions that read a constant; then, for each constant times 3 and over 3, those
tests again until one fails. Without tests it lists the constants and who reads them.

A constant in compiled code, or one that is read as its module is imported, cannot be changed in this way: it is named.
"""

from __future__ import annotations

import argparse
import ast
import importlib
import json
import os
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

_ROOT = Path(__file__).resolve().parents[1]
_FACTORS = 3.0, 1.0 / 3.0
_KERNELS = {"kernel", "inlined_kernel", "lazy_kernel", "bound", "formula"}
_PATIENCE = 60.0, 20.0  # [s], and times the usual time of the tests: then a run hangs


@dataclass(frozen=True)
class Constant:
    """A number of a module: where it stands, and the functions that read it by file and first line."""

    file: str
    line: int
    name: str
    value: float
    comment: str
    readers: tuple[tuple[str, int], ...]
    compiled: bool
    at_import: bool

    @property
    def module(self) -> str:
        """Return the name of the module."""
        return self.file.removesuffix(".py").replace("/", ".")

    def times(self, factor: float) -> float:
        """Return a changed value; integers change by one at least."""
        changed = self.value * factor
        if isinstance(self.value, float):
            return changed
        return max(round(changed), 1) if round(changed) != self.value else self.value + (1 if factor > 1.0 else -1)


def constants(folder: str) -> Iterator[Constant]:
    """Yield the private numbers of the modules of a folder."""
    texts = {path: path.read_text(encoding="utf-8") for path in _modules()}
    for path, text in texts.items():
        if folder not in (str(path.relative_to(_ROOT)), *map(str, path.relative_to(_ROOT).parents)):
            continue
        lines = text.splitlines()
        for node in ast.parse(text).body:
            if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
                name, value = node.targets[0].id, _number(node.value)
                if value is not None and (name.startswith("_") or path.stem == "numerics"):
                    comment = lines[node.lineno - 1].partition("#")[2] or lines[node.lineno - 2].lstrip("#: ")
                    reading = {other: one for other, one in texts.items() if name in one}
                    yield _constant(reading, path, node.lineno, name, value, comment.strip())


def _modules() -> Iterator[Path]:
    for package in ("linkages", "optim"):
        yield from sorted((_ROOT / package).rglob("*.py"))


def _number(node: ast.expr) -> float | None:
    """Evaluate a number that is written out; None for anything else."""
    try:
        value = eval(compile(ast.Expression(node), "", "eval"), {"__builtins__": {}}, {})
    except Exception:
        return None
    return value if isinstance(value, int | float) and not isinstance(value, bool) else None


def _constant(texts: dict[Path, str], path: Path, line: int, name: str, value: float, comment: str) -> Constant:
    readers, compiled, at_import = [], False, False
    module = ".".join(path.relative_to(_ROOT).with_suffix("").parts)
    for other, text in texts.items():
        tree = ast.parse(text) if other == path or module.rpartition(".")[2] in text else None
        if tree is None or (other != path and not _imports(tree, module, name)):
            continue
        for node in tree.body:
            for outer, reads in _reading(node, name):
                at_import |= reads and outer is None
                if reads and outer is not None:
                    readers.append((str(other.relative_to(_ROOT)), _first_line(outer)))
                    compiled |= any(_called(one) in _KERNELS for one in outer.decorator_list)
    return Constant(
        str(path.relative_to(_ROOT)), line, name, value, comment, tuple(dict.fromkeys(readers)), compiled, at_import
    )


def _imports(tree: ast.Module, module: str, name: str) -> bool:
    """Check whether a module imports a name, or the module that holds it."""
    package, _, last = module.rpartition(".")
    return any(
        (node.module == module and any(one.name == name for one in node.names))
        or (node.module == package and any(one.name == last for one in node.names))
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom)
    )


def _reading(node: ast.AST, name: str, outer: Any = None) -> Iterator[tuple[Any, bool]]:
    """Yield each function of a part of a module, None for none, and whether its own lines read a name."""
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
        for one in (*node.args.defaults, *node.decorator_list):
            yield from _reading(one, name, outer)
        for one in node.body:
            yield from _reading(one, name, node)
        return
    reads = isinstance(node, ast.Name) and node.id == name and isinstance(node.ctx, ast.Load)
    reads |= isinstance(node, ast.Attribute) and node.attr == name
    if reads:
        yield outer, True
    for child in ast.iter_child_nodes(node):
        yield from _reading(child, name, outer)


def _first_line(node: Any) -> int:
    return min([node.lineno, *(one.lineno for one in node.decorator_list)])


def _called(node: ast.expr) -> str:
    node = node.func if isinstance(node, ast.Call) else node
    return node.id if isinstance(node, ast.Name) else getattr(node, "attr", "")


class Trial:
    """A plugin of pytest that runs the collected tests with changed constants, each time in a process of its own."""

    def __init__(self, found: list[Constant], seconds: float, out: Callable[[str], None]) -> None:
        self._found, self._seconds, self._out = found, seconds, out

    def pytest_runtestloop(self, session: Any) -> bool:
        """Take the place of the usual loop over the tests."""
        with tempfile.TemporaryDirectory() as folder:
            kept = Path(folder, "entered.json")
            in_child(lambda: kept.write_text(json.dumps(entered(session.items))) > 0, 3600.0)
            seen = json.loads(kept.read_text()) if kept.exists() else {}
        for one in self._found:
            self._out(f"{one.file}:{one.line} {one.name} = {one.value:g}: {self._noticed(session.items, one, seen)}")
        return True

    def _noticed(self, items: list[Any], one: Constant, seen: dict[str, Any]) -> str:
        wanted = {f"{file}:{line}" for file, line in one.readers}
        near = sorted((entry["seconds"], k) for k, entry in seen.items() if wanted & set(entry["functions"]))
        chosen, total = [], 0.0
        for seconds, k in near:
            if total + seconds <= self._seconds or not chosen:
                chosen.append(items[int(k)])
                total += seconds
        if not chosen:
            return "NO TEST ENTERS" + (" (compiled)" if one.compiled else "") + (" (at import)" * one.at_import)
        words = []
        for factor in _FACTORS:
            failed = in_child(lambda f=factor: fails(chosen, one, one.times(f)), _PATIENCE[0] + _PATIENCE[1] * total)
            words.append(f"x{factor:.2g} {'noticed' if failed else 'UNNOTICED'}")
        return f"{', '.join(words)}; {len(chosen)} of {len(near)} tests, {total:.1f} s"


def entered(items: list[Any]) -> dict[str, Any]:
    """Run all tests; return seconds and entered functions of each that passes, by its number."""
    result = {}
    for k, item in enumerate(items):
        functions: set[str] = set()

        def look(frame: Any, *_: object, functions: set[str] = functions) -> None:
            file = frame.f_code.co_filename
            if file.startswith(f"{_ROOT}/linkages/") or file.startswith(f"{_ROOT}/optim/"):
                functions.add(f"{file.removeprefix(f'{_ROOT}/')}:{frame.f_code.co_firstlineno}")

        begun = time.perf_counter()
        threading.settrace(look)
        sys.settrace(look)
        good = passes(item, items[k + 1] if k + 1 < len(items) else None)
        sys.settrace(None)
        if good:
            result[str(k)] = {"seconds": time.perf_counter() - begun, "functions": sorted(functions)}
    return result


def passes(item: Any, following: Any) -> bool:
    """Run a test; check that it passes."""
    from _pytest.runner import runtestprotocol

    return not any(report.failed for report in runtestprotocol(item, log=False, nextitem=following))


def fails(items: list[Any], one: Constant, value: float) -> bool:
    """Change a constant wherever it is read, run tests, and check whether one fails."""
    for file in {one.file, *(file for file, _ in one.readers)}:
        module = importlib.import_module(file.removesuffix(".py").removesuffix("/__init__").replace("/", "."))
        if hasattr(module, one.name):
            setattr(module, one.name, value)
    pairs = zip(items, [*items[1:], None], strict=True)
    return not all(passes(item, following) for item, following in pairs)


def in_child(task: Callable[[], bool], limit: float) -> bool:
    """Run a task in a copy of this process; return its answer, or true if it takes longer than a limit [s]."""
    child = os.fork()
    if child == 0:
        os.setpgid(0, 0)
        answer = True
        try:
            answer = task()
        finally:
            os._exit(1 if answer else 0)
    end = time.monotonic() + limit
    while time.monotonic() < end:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            return os.waitstatus_to_exitcode(status) != 0
        time.sleep(0.02)
    os.kill(child, 9)
    os.waitpid(child, 0)
    return True


def main() -> int:
    """List the constants of a folder, or try them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder")
    parser.add_argument("tests", nargs="*", help="files of tests, and further words for pytest")
    parser.add_argument("--seconds", type=float, default=10.0, help="of tests for a constant; default: %(default)s")
    options = parser.parse_args()
    found = list(constants(options.folder.rstrip("/")))
    if not options.tests:
        for one in found:
            where = ", ".join(f"{file}:{line}" for file, line in one.readers)
            print(f"{one.file}:{one.line} {one.name} = {one.value:g} | {one.comment} | {where}")
        return 0
    import pytest

    out = os.fdopen(os.dup(1), "w", buffering=1)  # pytest captures the usual one
    trial = Trial([one for one in found if not one.compiled], options.seconds, lambda text: print(text, file=out))
    for one in found:
        if one.compiled:
            print(f"{one.file}:{one.line} {one.name} = {one.value:g}: compiled", file=out)
    return int(pytest.main([*options.tests, "-n", "0", "-p", "no:cacheprovider", "-p", "no:randomly"], plugins=[trial]))


if __name__ == "__main__":
    sys.exit(main())
