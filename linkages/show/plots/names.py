"""Names of quantities in words, the same in all media: "clearance of A" for ``joints.A.clearance``.

Texts begin with a small letter, as within a sentence; `sentence` begins one. The dotted paths remain the names in files
and on command lines.
"""

from __future__ import annotations

#: Words of keys and quantities that are not words by themselves.
_WORDS = {
    "x": "position x",
    "y": "position y",
    "vx": "velocity x",
    "vy": "velocity y",
    "ax": "acceleration x",
    "ay": "acceleration y",
    "omega": "angular velocity",
    "alpha": "angular acceleration",
    "fx": "force x",
    "fy": "force y",
    "ex": "eccentricity x",
    "ey": "eccentricity y",
    "compression": "largest compressive force",
    "bending": "largest bending moment",
    "stress": "largest stress",
    "stress_place": "place of the largest stress",
    "deflection_place": "place of the largest deflection",
    "inertia": "moment of inertia",
    "youngs_modulus": "Young's modulus",
    "poissons_ratio": "Poisson's ratio",
    "rms": "root mean square",
}
#: Parts of paths of machines, and their words.
_PLACES = {"pose yaw": "angle", "pose ": "position ", "com ": "centre of mass "}
_INSIDE = ("force", "stress", "bending", "compression")  # quantities in their owner, not of it
_STATISTICS = ("peak", "mean", "rms", "min", "max")
_SHORT = 2  # letters of a key that is a symbol, such as x and ra


def name_of_output(output: str) -> str:
    """Name an output of a run.

    Examples
    --------
    >>> from linkages.show.plots.names import name_of_output
    >>> name_of_output("A.force"), name_of_output("slider7.ax"), name_of_output("strain_energy")
    ('force in A', 'acceleration x of slider7', 'strain energy')
    """
    owner, dot, quantity = output.rpartition(".")
    if not dot:
        return _spaced(output)
    return f"{_word(quantity)} {'in' if quantity in _INSIDE else 'of'} {owner}"


def name_of_number(key: str) -> str:
    """Name a characteristic number of a run by its key.

    Examples
    --------
    >>> from linkages.show.plots.names import name_of_number
    >>> name_of_number("A.force.peak"), name_of_number("slider.ax.rms"), name_of_number("O.work")
    ('peak of the force in A', 'root mean square of the acceleration x of slider', 'work of O')
    """
    output, _, kind = key.rpartition(".")
    return f"{_word(kind)} of the {name_of_output(output)}" if kind in _STATISTICS else name_of_output(key)


def name_of_value(path: str) -> str:
    """Name a value of a machine or an experiment by its dotted path.

    Examples
    --------
    >>> from linkages.show.plots.names import name_of_value
    >>> name_of_value("sdf.links.link6.mass"), name_of_value("joints.B.wear.coefficient")
    ('mass of link6', 'wear coefficient of B')
    >>> name_of_value("sdf.frames.rod_B.pose.x"), name_of_value("duration")
    ('position x of rod_B', 'duration')
    """
    kind, *rest = path.removeprefix("sdf.").split(".")
    if not rest:
        return _word(kind)
    owner, *keys = rest
    if not keys:
        return f"parameter {owner}" if kind == "parameters" else f"{_word(owner)} of the {_spaced(kind)}"
    text = " ".join(key if len(key) <= _SHORT else _word(key) for key in keys)
    for part, word in _PLACES.items():
        text = text.replace(part, word)
    return f"{text} of {owner}"


def sentence(text: str) -> str:
    """Begin a text with a capital letter, unless its first word is a name such as ax."""
    return text[:1].upper() + text[1:]


def _word(key: str) -> str:
    return _WORDS.get(key) or _spaced(key)


def _spaced(key: str) -> str:
    return key.replace("_", " ")
