"""Files of other programs, imported: their experiments here, and the same fall on Drake's own plant."""

import re

import linkages


def experiment(machine, text, duration=0.3):
    """Make the system of an experiment written next to its mechanism."""
    path = machine.with_suffix(".toml")
    path.write_text(f'mechanism = "{machine.name}"\nduration = {duration}\n{text}[solver]\naccuracy = 1e-10\n')
    return linkages.load(path)


def written(said):
    """The lines that the import prints for the experiment."""
    return "".join(f"{line}\n" for line in re.findall("write it into the experiment as (.*)", said))


def angles_on_drake(text, kind, gravity, duration, joints, add=lambda plant: None):
    """Angles of joints after a fall from rest, on Drake's plant of a text; `add` adds what its parser does not read."""
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator

    plant = MultibodyPlant(0.0)
    plant.mutable_gravity_field().set_gravity_vector(gravity)
    Parser(plant).AddModelsFromString(text, kind)
    add(plant)
    plant.Finalize()
    simulator = Simulator(plant)
    ResetIntegratorFromFlags(simulator, "runge_kutta3", 1e-3)
    simulator.get_mutable_integrator().set_target_accuracy(1e-10)
    simulator.AdvanceTo(duration)
    return [plant.GetJointByName(name).get_angle(simulator.get_context()) for name in joints]
