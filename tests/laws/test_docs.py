"""The documentation of the laws is that of the code, and its example works."""

import importlib.util
import re
from pathlib import Path

import pytest

from linkages.laws import contact
from linkages.laws.table import MOTIONS, long_bearing_ratio, markdown

ROOT = Path(__file__).parents[2]


def test_laws_table_is_fresh():
    """Regenerate with ``python docs/make_laws.py``."""
    assert (ROOT / "docs" / "laws.md").read_text(encoding="utf-8") == markdown()


def test_every_law_is_in_the_table():
    text = markdown()
    for name in (*contact.CONTACTS, "finite, guembel", "greenwood-tripp", "lugre", "walther"):
        assert f"| {name} |" in text


@pytest.mark.parametrize(("motion", "largest"), [("rotation", 2.9), ("separation", 11.3)])
def test_the_long_film_is_too_strong_at_the_slenderness_of_chen_2025(motion, largest):
    """Chen et al. (2025) assume L/D > 2 and have 1.33: up to three times in rotation, ten and more in separation."""
    ratios = [long_bearing_ratio(4.0 / 3.0, eps, motion) for eps in (0.05, 0.5, 0.9, 0.95)]
    assert max(ratios) == pytest.approx(largest, rel=0.02)
    assert motion in MOTIONS


def test_adding_a_law_as_the_page_says(tmp_path):
    """Apply the page's three edits to a copy of the module, and use the law."""
    page = (ROOT / "docs" / "extend_contact_law.md").read_text(encoding="utf-8")
    function, entry, branch = (
        re.sub(r"^    ", "", block, flags=re.M)
        for block in re.findall(r"```python\n(.*?)    ```", page, flags=re.S)
    )
    added = [line for part in (function, entry, branch) for line in part.splitlines()]
    assert len(added) <= 20
    source = Path(contact.__file__).read_text(encoding="utf-8")
    source = source.replace("class Contact(NamedTuple)", f"{function}\n\nclass Contact(NamedTuple)")
    source = source.replace("CONTACTS = {\n", f"CONTACTS = {{\n    {entry}")
    indented = re.sub(r"^", "    ", branch.rstrip(), flags=re.M)
    source = source.replace(
        "    return chi_lankarani_nikravesh(e)", f"{indented}\n    return chi_lankarani_nikravesh(e)"
    )
    path = tmp_path / "extended_contact.py"
    path.write_text(source, encoding="utf-8")
    spec = importlib.util.spec_from_file_location("extended_contact", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    law = module.CONTACTS["small-loss"]
    assert law.code not in {known.code for known in contact.CONTACTS.values()}
    force = module.contact_force(law.code, 1e-6, 0.1, 0.1, 1e10, 1.5, 0.8, 0.0, 0.0, 0.0, 1.0)
    assert force == pytest.approx(10.0 * (1.0 + 1.5 * 0.36 / 1.512))
