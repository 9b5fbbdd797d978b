"""Hooks of pytest for environments without Drake: tests that need it are skipped with that reason.

A test needs Drake if it imports pydrake, has the mark `drake`, or reaches the package's refusal of what needs Drake.
What must work without Drake is tested by `test_without_drake`, in every environment.
"""

import doctest

import pytest

from linkages.base import packages

MISSING = not packages.installed("pydrake")
REASON = "Drake is not installed"
_refuse = packages._missing


def _skip_what_needs_drake(package, source, where):
    if package == "pydrake":
        pytest.skip(REASON)
    return _refuse(package, source, where)


def _needs_drake(problem):
    return MISSING and isinstance(problem, ImportError) and (problem.name or "").startswith("pydrake")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item):
    if MISSING and item.get_closest_marker("drake"):
        pytest.skip(REASON)
    return (yield from _or_skip())


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item):
    return (yield from _or_skip())


def _or_skip():
    try:
        return (yield)
    except ImportError as problem:
        if _needs_drake(problem):
            pytest.skip(REASON)
        raise


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector):
    report = yield
    problem = getattr(getattr(report, "call", None), "excinfo", None)
    if report.outcome == "failed" and problem and _needs_drake(problem.value.__cause__):
        report.outcome, report.longrepr = "skipped", (str(collector.path), 1, f"Skipped: {REASON}")
    return report


class ExampleRunner(doctest.DocTestRunner):
    """Runs examples of docstrings; one that needs Drake skips its test."""

    def report_unexpected_exception(self, out, test, example, exc_info):
        if isinstance(exc_info[1], pytest.skip.Exception) or _needs_drake(exc_info[1]):
            pytest.skip(REASON)
        super().report_unexpected_exception(out, test, example, exc_info)


@pytest.fixture(autouse=True, scope="session")  # fixtures of modules may need Drake
def skip_without_drake():
    with pytest.MonkeyPatch.context() as patch:
        if MISSING:
            patch.setattr(packages, "_missing", _skip_what_needs_drake)
        yield
