"""Parameters that laws declare: refused in one line, listed, dumped; taken to other processes."""

import subprocess
import sys

import cloudpickle
import numpy as np
import pytest
from joint_records import joint
from machines import four_bar
from numba import config

import linkages
from linkages import InputError, laws
from linkages.input.files.table_keys import described_keys
from linkages.input.model.experiment import Experiment, value_unit
from linkages.laws import CONTACTS, FRICTIONS, Parameter
from linkages.laws.contact.contact_laws import contact_force
from linkages.laws.declared import BUILT_IN_PARAMETERS, REGISTRIES
from linkages.laws.parameters import SLOTS

compiled_only = pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")
B = "joints.B.contact"
FILE = linkages.find_file("slider_crank_dry.toml")


def spring(delta, ddelta, ddelta0, joint):
    return joint.my_stiffness * delta + joint.my_damping * ddelta


OWN = (
    Parameter("my_stiffness", "N/m", None, "stiffness", gt=0.0),
    Parameter("my_damping", "N s/m", 2.0, "damping", ge=0.0, le=5.0),
)


@pytest.fixture(autouse=True)
def _mine(own_registries):
    laws.register_contact("mine", spring, parameters=OWN)


def test_the_function_reads_its_parameters_by_name():
    assert contact_force(0.5, 0.25, 0.0, joint(contact="mine", my_stiffness=8.0, my_damping=4.0)) == 5.0


REFUSED = {
    "missing": ({}, rf"^slider_crank_dry\.toml: {B}\.my_stiffness: is missing \(stiffness \[N/m\]\)$"),
    "below its range": (
        {"my_stiffness": 0.0},
        rf"^argument: {B}\.my_stiffness: is 0\.0; it should be greater than 0 \(stiffness \[N/m\]\)$",
    ),
    "above its range": (
        {"my_stiffness": 1.0, "my_damping": 6},
        r"my_damping: is 6; it should be less than or equal to 5",
    ),
    "no number": ({"my_stiffness": "stiff"}, "my_stiffness: is 'stiff'; it should be a number"),
    "wrong unit": ({"my_stiffness": "3 N"}, 'my_stiffness: is "3 N"; it must be measured in N/m, or'),
    "misspelt": ({"my_stifness": 1.0}, r'my_stifness: unknown key; did you mean "my_stiffness"\?$'),
    "of another law": (
        {"law": "hertz", "my_stiffness": 1.0},
        r"my_stiffness: is a parameter of mine; hertz has: exponent$",
    ),
    "an unknown law": ({"law": "mien", "my_stiffness": 1.0}, r'law: "mien" is unknown; did you mean "mine"\?$'),
}


@pytest.mark.parametrize(("values", "problem"), REFUSED.values(), ids=REFUSED)
def test_wrong_values_are_refused_in_one_line(values, problem):
    with pytest.raises(InputError, match=problem) as refused:
        linkages.load(FILE, {f"{B}.{key}": value for key, value in ({"law": "mine"} | values).items()})
    assert len(str(refused.value).splitlines()) == 1


def test_a_law_with_parameters_needs_no_common_keys(experiment_file):
    """The table is complete with the law's own keys; its unit agrees with the declaration."""
    table = '[joints.B]\nmodel = "dry"\nclearance = 1e-4\n[joints.B.contact]\nlaw = "mine"\nmy_stiffness = "3 kN/mm"\n'
    sdf = four_bar()
    system = linkages.load(experiment_file(sdf, "duration = 1.0\n" + table))
    assert system.value(f"{B}.my_stiffness") == 3e6
    assert system.value(f"{B}.my_damping") == 2.0
    with pytest.raises(InputError, match=r"joints\.B\.contact: restitution is missing"):
        linkages.load(experiment_file(sdf, "duration = 1.0\n" + table.replace("mine", "hertz").partition("my_")[0]))


def test_a_law_of_another_file_is_replaced_by_its_path():
    """Keys of built-in laws are allowed with any law."""
    system = linkages.load(FILE, {f"{B}.exponent": 1.2, f"{B}.law": "johnson", "joints.B.friction.law": "lugre"})
    assert system.value(f"{B}.exponent") == 1.2
    assert system.value("joints.B.friction.bristle_stiffness") == 1e5


def test_keys_units_and_meanings_are_listed():
    rows = [(path, meaning) for path, meaning in described_keys(Experiment) if ".my_" in path]
    assert (f"{B.replace('B', 'NAME')}.my_stiffness", "mine: stiffness [N/m]; > 0; required") in rows
    assert ("stops.NAME.contact.my_damping", "mine: damping [N s/m]; >= 0 and <= 5; default 2.0") in rows
    assert value_unit(f"{B}.my_stiffness") == "N/m"


def test_what_is_not_given_is_not_dumped_as_given():
    """The description of a contact in a store: every key of the built-in laws, whatever the law."""
    contact = linkages.load(FILE).experiment.joints["B"].contact
    assert contact.model_dump() == {
        "law": "lankarani-nikravesh", "restitution": 0.9, "youngs_modulus": 207e9, "poissons_ratio": 0.3,
        "stiffness": None, "yield_strength": None, "exponent": 1.5, "damping": 0.0, "clip": True,
        "branch_stiffness": 0.0, "relaxation": 1e-4,
    }  # fmt: skip
    assert contact.model_dump(exclude_unset=True).keys() == {"law", "restitution", "youngs_modulus", "poissons_ratio"}


UNFIT = {
    "taken by the record": ([Parameter("stiffness", "N/m", 1.0, "")], '"stiffness": the name is taken'),
    "no name": ([Parameter("my stiffness", "N/m", 1.0, "")], "must be letters, digits and underscores"),
    "twice": ([OWN[0], OWN[0]], '"my_stiffness" is declared twice'),
    "another unit": (
        [Parameter("exponent", "m", 1.0, "")],
        r"other contact laws have this key in 1; choose another name",
    ),
    "default out of range": ([Parameter("x", "1", -1.0, "", gt=0.0)], 'x": its default -1 must be > 0'),
    "above nothing": ([Parameter("x", "1", 1.0, "", above="y")], 'is above "y", which is not declared'),
    "too many": ([Parameter(f"x{k}", "1", 1.0, "") for k in range(SLOTS + 1)], "has 9 parameters; at most 8"),
    "no declaration": (["x"], "'x' is not a linkages.laws.Parameter"),
}


@pytest.mark.parametrize(("parameters", "problem"), UNFIT.values(), ids=UNFIT)
def test_unfit_declarations_are_refused(parameters, problem):
    with pytest.raises(ValueError, match=problem):
        laws.register_contact("unfit", lambda delta, ddelta, ddelta0, joint: delta, parameters=parameters)
    assert "unfit" not in CONTACTS


@compiled_only
def test_a_force_that_reads_what_its_law_neither_declares_nor_needs_is_refused():
    def force(delta, ddelta, ddelta0, joint):
        return joint.stiffness * delta

    with pytest.raises(ValueError, match=r"reads joint\.stiffness, which it neither declares nor needs; declare"):
        laws.register_contact("unfit", force, parameters=OWN)
    laws.register_contact("fit", force, parameters=OWN, needs=["stiffness"])
    with pytest.raises(InputError, match="give youngs_modulus or stiffness"):
        linkages.load(FILE, {f"{B}.law": "fit", f"{B}.my_stiffness": 1.0, f"{B}.youngs_modulus": None})


def test_a_law_that_declares_nothing_has_the_parameters_of_the_built_in_ones():
    laws.register_friction("old", lambda v, joint: joint.mu_d * v / (joint.v_1 + joint.v_0))
    assert FRICTIONS["old"].parameters == BUILT_IN_PARAMETERS["friction"]
    system = linkages.load(FILE, {"joints.B.friction.law": "old", "joints.B.friction.v_1": 3e-4})
    assert system.laws["friction_1"][0] == 3e-4


def test_the_magnitude_of_a_state_follows_from_the_parameters_of_its_law():
    state = laws.State("bristle", "m", lambda values: 0.2 / values["top"], start=3e-6)
    laws.register_friction("bristly", lambda v, bristle, joint: (joint.top * bristle, v - bristle), states=[state],
                           parameters=[Parameter("top", "1/m", 1e5, "stiffness")])  # fmt: skip
    system = linkages.load(FILE, {"joints.B.friction.law": "bristly", "joints.B.friction.top": 2e4})
    assert system.law_states.names == ("bristle",)
    assert system.law_states.scales == pytest.approx([1e-5], rel=1e-15)
    assert system.law_states.starts == pytest.approx([3e-6], rel=1e-15)
    assert system.law_states.remembered(0) == (np.inf, 0.0, 0.0, 3e-6)  # after the speed of approach, at the last place


@pytest.mark.parametrize("kind", REGISTRIES)
def test_each_key_of_a_kind_has_one_unit_and_one_default(kind):
    """So the value of a key that is not given does not change with the law."""
    found = {}
    for law in REGISTRIES[kind].values():
        for parameter in law.parameters:
            told = parameter.unit, parameter.default
            assert found.setdefault(parameter.name, told) == told


RUN = """
import pathlib, pickle, sys
import linkages
system = pickle.loads(pathlib.Path(sys.argv[1]).read_bytes())
again = system.replaced({"joints.B.contact.my_damping": 0.0})
print([repr(float(linkages.simulate(s, "compiled")["B.force"].max())) for s in (system, again)])
"""


@compiled_only
def test_a_system_takes_its_parameters_to_another_process(tmp_path):
    system = linkages.load(FILE, {"duration": 0.001, f"{B}.law": "mine", f"{B}.my_stiffness": 1e8})
    again = system.replaced({f"{B}.my_damping": 0.0})
    here = [repr(float(linkages.simulate(s, "compiled")["B.force"].max())) for s in (system, again)]
    cloudpickle.register_pickle_by_value(sys.modules[__name__])
    try:
        (tmp_path / "system").write_bytes(cloudpickle.dumps(system))
    finally:
        cloudpickle.unregister_pickle_by_value(sys.modules[__name__])
    command = [sys.executable, "-c", RUN, str(tmp_path / "system")]
    there = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert there.strip() == str(here)
    assert here[0] != here[1]
