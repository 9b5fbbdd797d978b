"""The documentation of the laws agrees with the code, and its example works."""

import importlib.util
import math
import re
from pathlib import Path

import numpy as np
import pytest
from joint_records import joint
from laws_page import MOTIONS, bearing_ratio, markdown

from linkages.laws import CONTACTS
from linkages.laws.contact import contact_laws
from linkages.laws.contact.material import effective_restitution
from linkages.laws.film.films import film_force
from linkages.laws.friction import friction_coefficient

ROOT = Path(__file__).parents[2]


def test_laws_table_is_fresh():
    """Regenerate with ``python docs/make_laws.py``."""
    assert (ROOT / "docs" / "laws.md").read_text(encoding="utf-8") == markdown()


def test_every_law_is_in_the_table():
    text = markdown()
    for name in (*CONTACTS, "finite, guembel", "greenwood-tripp", "lugre", "walther"):
        assert f"| {name} |" in text


@pytest.mark.parametrize(("motion", "expected"), [("rotation", (2.9, 2.4, 1.4)), ("separation", (3.0, 5.3, 10.25))])
def test_the_long_film_is_too_strong_at_the_slenderness_of_chen_2025(motion, expected):
    """Chen et al. (2025) assume L/D > 2 and have 1.33: up to three times in rotation, ten and more in separation."""
    ratios = [bearing_ratio("long", 4.0 / 3.0, eps, motion) for eps in (0.05, 0.5, 0.9)]
    assert ratios == pytest.approx(expected, abs=0.05)
    assert motion in MOTIONS


PAGE = (ROOT / "docs" / "extend.md").read_text(encoding="utf-8")
SCRIPT, IN_PACKAGE = (re.findall(r"```python\n(.*?)```", part, flags=re.S) for part in PAGE.split("## In the package"))


@pytest.mark.usefixtures("own_registries")
def test_laws_of_a_script_as_the_page_says():
    """Run the page, and use its laws."""
    space = {}
    exec("\n".join(SCRIPT), space)
    run = space["run"]
    clearance = space["system"].laws["clearance"][0]
    assert np.hypot(run["B.ex"], run["B.ey"]).max() > clearance  # it did touch
    force = contact_laws.contact_force(1e-6, 0.1, 0.1, joint(contact="viscoelastic", my_stiffness=1e10))
    assert force == pytest.approx(1e10 * (1e-9 + 1.5 * 2e-7 * 1e-3 * 0.1))
    small_loss = CONTACTS["small-loss"]
    for e in (0.98, 0.99):  # exact for small losses: the error is of second order
        assert effective_restitution(small_loss.factor(e)) == pytest.approx(e, abs=(1.0 - e) ** 2)
    smooth = joint(friction="smooth", mu=0.1, v_s=1e-3)
    assert friction_coefficient(1e-3, smooth) == pytest.approx(0.1 / math.sqrt(2.0))
    assert space["soft"].law_states.names == ("creep", "bristle")
    assert abs(space["derivatives"].evaluate([0.002])[space["path"]]["B.ex"][0]) > 0.0
    assert len(set(space["batch"].peak.ravel())) == 3
    gains = {"gain": 1.0, "leakage": 1.0}
    leaky, long = (
        film_force(joint(film=name, **(gains if name == "leaky" else {})), 0.5, 1.0, 2.0, 1.0, np.empty(0))
        for name in ("leaky", "long")
    )
    assert leaky == pytest.approx((0.5 * long[0], 0.5 * long[1], long[2]))


def test_adding_a_law_to_the_package_as_the_page_says(tmp_path):
    """Add the page's line to a copy of the module, and use the law."""
    (entry,) = IN_PACKAGE
    source = Path(contact_laws.__file__).read_text(encoding="utf-8")
    path = tmp_path / "extended_contacts.py"
    path.write_text(source.replace("\nCONTACTS = {\n", f"\nCONTACTS = {{\n{entry}"), encoding="utf-8")
    spec = importlib.util.spec_from_file_location("extended_contacts", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    law = module.CONTACTS["small-loss"]
    record = joint()
    law.fill(record, {"exponent": 1.5, "restitution": 0.8, "stiffness": 1e10})
    assert module.contact_force(1e-6, 0.1, 0.1, record) == pytest.approx(10.0 * (1.0 + 1.5 * 0.36 / 1.512))
