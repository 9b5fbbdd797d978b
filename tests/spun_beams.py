"""Beams that are spun up, clamped at the axis, and how far a geometrically exact beam bends then."""

import numpy as np
from machines import bar, beam, joint, model


def spun(length, modulus, area, second_moment, density):
    """A beam that is spun up to 6 rad/s in 15 s, clamped at the axis."""
    section = f"""<linkages:section><linkages:area>{area}</linkages:area>
<linkages:second_moment>{second_moment}</linkages:second_moment><linkages:height>0.1</linkages:height></linkages:section>"""
    material = f"""<linkages:material><linkages:youngs_modulus>{modulus}</linkages:youngs_modulus>
<linkages:poisson>0.3</linkages:poisson><linkages:density>{density}</linkages:density></linkages:material>"""
    own = beam("rod", "rod_tip", section, material)
    body = bar("rod", length, "__model__", mass=density * area * length, inner=own) + joint("O", "world", "rod")
    return model("spun", body)


SPIN = """duration = 15.0
[drives.O]
formula = "6*(t**2/30 + 15/39.47841760435743*(cos(0.41887902047863906*t) - 1))"
[links.rod]
model = "flexible"
damping = 0.0
{keys}
[solver]
accuracy = 1e-9
"""
#: Beam; least deflection of the tip [m], and those at 5 and 10 s, of a geometrically exact beam; bound: slope^2/2.
SPUN = {
    "Simo and Vu-Quoc": ((10.0, 2.8e10, 1e-3, 5e-7, 1200.0), (-0.5737864, -0.4684418, -0.3627645), 4e-3),
    "Kane": ((8.0, 6.895e10, 7.2968e-5, 8.2181e-9, 2766.67), (-0.7506395, -0.6232259, -0.4373666), 1.2e-2),
}


def tip_of(run):
    """Least deflection of the tip from the clamp's tangent [m], and those at 5 and 10 s."""
    values = run.evaluate(np.linspace(0.0, 15.0, 3001))
    tip = values["rod_tip.y"] * np.cos(values["q.O"]) - values["rod_tip.x"] * np.sin(values["q.O"])
    return np.array([tip.min(), tip[1000], tip[2000]])
