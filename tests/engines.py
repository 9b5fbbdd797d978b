"""Marks of tests that run on both engines; see `conformance`."""

import pytest

#: Run on both, but on Drake among the slow tests.
slow_on_drake = pytest.mark.parametrize("engine", ["compiled", pytest.param("drake", marks=pytest.mark.slow)])
