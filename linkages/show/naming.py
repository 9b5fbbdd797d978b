"""Names of outputs and of values in words, the same in all media; the path stands beside them or in a tooltip."""

from __future__ import annotations

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
    "inertia": "moment of inertia",
    "youngs_modulus": "Young's modulus",
    "poissons_ratio": "Poisson's ratio",
}
_SHORTENED = (("pose yaw", "angle"), ("pose ", "position "), ("com ", "centre of mass "))
_COORDINATE, _SYMBOL = "q.", 2  # start of the name of a coordinate, most letters of a symbol such as x


def output_in_words(name: str) -> str:
    """Write the name of an output in words.

    Examples
    --------
    >>> from linkages.show.naming import output_in_words
    >>> output_in_words("slider7.ax"), output_in_words("ideal.A.force"), output_in_words("q.C2")
    ('Acceleration x of slider7', 'Ideal force of A', 'Coordinate of C2')
    """
    if name.startswith("ideal."):
        return f"Ideal {_uncapitalised(output_in_words(name.removeprefix('ideal.')))}"
    if name.startswith(_COORDINATE):
        return f"Coordinate of {name.removeprefix(_COORDINATE)}"
    owner, *rest = name.split(".")
    return f"{_sentence(' '.join(map(_word, rest)))} of {owner}" if rest else _sentence(_word(owner))


def value_in_words(path: str) -> str:
    """Write the dotted path of a value of an experiment or its machine in words.

    Examples
    --------
    >>> from linkages.show.naming import value_in_words
    >>> value_in_words("joints.A.clearance"), value_in_words("sdf.links.link6.mass"), value_in_words("sdf.parameters.r")
    ('Clearance of A', 'Mass of link6', 'Parameter r')
    """
    kind, *names = path.removeprefix("sdf.").split(".")
    if not names:
        return _sentence(_word(kind))
    name, *keys = names
    if not keys:
        return f"Parameter {name}" if kind == "parameters" else f"{_sentence(_word(name))} ({kind})"
    text = " ".join(key if len(key) <= _SYMBOL else _word(key) for key in keys)
    for long, short in _SHORTENED:
        text = text.replace(long, short)
    return f"{_sentence(text)} of {name}"


def _word(key: str) -> str:
    return _WORDS.get(key, key.replace("_", " "))


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:]


def _uncapitalised(text: str) -> str:
    return text[:1].lower() + text[1:]
