"""Requirements on both engines: every test with the fixture `engine` or `run` is run on each of them."""

import pytest

from linkages import Status, simulate


@pytest.fixture(params=["compiled", "drake"])
def engine(request):
    return request.param


@pytest.fixture
def run(engine, system_of):
    """Run a machine, given as SDF and TOML text, to its end."""

    def simulated(sdf, toml, overrides=None):
        result = simulate(system_of(sdf, toml, overrides), engine)
        assert result.status is Status.OK
        return result

    return simulated
