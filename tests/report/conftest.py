import pytest
from machines import four_bar

from linkages.cli.main import main

#: A film in one joint, dry contact in another, and a title that HTML must not swallow.
TOML = """mechanism = "machine.sdf"
title = "Crank & rocker <A lubricated, B dry>"
duration = 0.02  # s, assumed
outputs = ["follower.omega", "coupler.ax"]
[drives.O]
speed = 15.0  # rad/s, assumed: <sources> & all
[joints.A]
model = "lubricated"
film = "long"
clearance = 1e-4  # m, radial, Table 7
viscosity = 0.1
[joints.B]
model = "dry"
clearance = 1e-4
contact = {law = "lankarani-nikravesh", restitution = 0.9, youngs_modulus = 2e11}
"""


@pytest.fixture(scope="session")
def results_folder(tmp_path_factory):
    """Everything that ``linkages simulate`` writes, with a value replaced on the command line; read only."""
    folder = tmp_path_factory.mktemp("report")
    (folder / "machine.sdf").write_text(four_bar())
    (folder / "rocker.toml").write_text(TOML)
    options = ["--duration", "0.006", "--set", "joints.B.clearance=1.5e-4", "--out", str(folder / "out")]
    assert main(["simulate", str(folder / "rocker.toml"), *options]) == 0
    return folder / "out"
