"""Limits and fits of ISO 286-1:2010 up to 500 mm: deviations a to zc of shafts, A to ZC of holes, IT1 to IT18."""

from __future__ import annotations

import re
from bisect import bisect_left
from typing import NamedTuple

from linkages.base.errors import InputError

_Two = tuple[float, float]

#: Upper limits of the ranges of sizes [mm]; the fine ones for the deviations a, b, c, r, s.
_RANGES = (3, 6, 10, 18, 30, 50, 80, 120, 180, 250, 315, 400, 500)
_FINE = (3, 6, 10, 14, 18, 24, 30, 40, 50, 65, 80, 100, 120, 140, 160, 180, 200, 225, 250, 280, 315, 355, 400, 450, 500)

#: Standard tolerances IT1 to IT18 [um], a line for each range: Table 1.
_TOLERANCES = (
    (0.8, 1.2, 2, 3, 4, 6, 10, 14, 25, 40, 60, 100, 140, 250, 400, 600, 1000, 1400),
    (1, 1.5, 2.5, 4, 5, 8, 12, 18, 30, 48, 75, 120, 180, 300, 480, 750, 1200, 1800),
    (1, 1.5, 2.5, 4, 6, 9, 15, 22, 36, 58, 90, 150, 220, 360, 580, 900, 1500, 2200),
    (1.2, 2, 3, 5, 8, 11, 18, 27, 43, 70, 110, 180, 270, 430, 700, 1100, 1800, 2700),
    (1.5, 2.5, 4, 6, 9, 13, 21, 33, 52, 84, 130, 210, 330, 520, 840, 1300, 2100, 3300),
    (1.5, 2.5, 4, 7, 11, 16, 25, 39, 62, 100, 160, 250, 390, 620, 1000, 1600, 2500, 3900),
    (2, 3, 5, 8, 13, 19, 30, 46, 74, 120, 190, 300, 460, 740, 1200, 1900, 3000, 4600),
    (2.5, 4, 6, 10, 15, 22, 35, 54, 87, 140, 220, 350, 540, 870, 1400, 2200, 3500, 5400),
    (3.5, 5, 8, 12, 18, 25, 40, 63, 100, 160, 250, 400, 630, 1000, 1600, 2500, 4000, 6300),
    (4.5, 7, 10, 14, 20, 29, 46, 72, 115, 185, 290, 460, 720, 1150, 1850, 2900, 4600, 7200),
    (6, 8, 12, 16, 23, 32, 52, 81, 130, 210, 320, 520, 810, 1300, 2100, 3200, 5200, 8100),
    (7, 9, 13, 18, 25, 36, 57, 89, 140, 230, 360, 570, 890, 1400, 2300, 3600, 5700, 8900),
    (8, 10, 15, 20, 27, 40, 63, 97, 155, 250, 400, 630, 970, 1550, 2500, 4000, 6300, 9700),
)
#: Fundamental deviations of shafts [um], Tables 4 and 5: upper ones, negative, of a to h; lower ones of k to zc.
_NONE = (0,) * 6  # of the smallest sizes, for which a deviation is not defined
_BELOW = {
    "a": (
        270, 270, 280, 290, 290, 300, 300, 310, 320, 340, 360, 380, 410, 460, 520,
        580, 660, 740, 820, 920, 1050, 1200, 1350, 1500, 1650,
    ),
    "b": (
        140, 140, 150, 150, 150, 160, 160, 170, 180, 190, 200, 220, 240, 260, 280,
        310, 340, 380, 420, 480, 540, 600, 680, 760, 840,
    ),
    "c": (60, 70, 80, 95, 95, 110, 110, 120, 130, 140, 150, 170, 180, 200, 210, 230, 240, 260, 280, 300, 330, 360, 400,
          440, 480),
    "cd": (34, 46, 56),
    "d": (20, 30, 40, 50, 65, 80, 100, 120, 145, 170, 190, 210, 230),
    "e": (14, 20, 25, 32, 40, 50, 60, 72, 85, 100, 110, 125, 135),
    "ef": (10, 14, 18),
    "f": (6, 10, 13, 16, 20, 25, 30, 36, 43, 50, 56, 62, 68),
    "fg": (4, 6, 8),
    "g": (2, 4, 5, 6, 7, 9, 10, 12, 14, 15, 17, 18, 20),
    "h": (0,) * 13,
}  # fmt: skip
_ABOVE = {
    "k": (0, 1, 1, 1, 2, 2, 2, 3, 3, 4, 4, 4, 5),
    "m": (2, 4, 6, 7, 8, 9, 11, 13, 15, 17, 20, 21, 23),
    "n": (4, 8, 10, 12, 15, 17, 20, 23, 27, 31, 34, 37, 40),
    "p": (6, 12, 15, 18, 22, 26, 32, 37, 43, 50, 56, 62, 68),
    "r": (10, 15, 19, 23, 23, 28, 28, 34, 34, 41, 43, 51, 54, 63, 65, 68, 77, 80, 84, 94, 98, 108, 114, 126, 132),
    "s": (14, 19, 23, 28, 28, 35, 35, 43, 43, 53, 59, 71, 79, 92, 100, 108, 122, 130, 140, 158, 170, 190, 208, 232,
          252),
    "t": (*_NONE[:6], 41, 48, 54, 66, 75, 91, 104, 122, 134, 146, 166, 180, 196, 218, 240, 268, 294, 330, 360),
    "u": (18, 23, 28, 33, 33, 41, 48, 60, 70, 87, 102, 124, 144, 170, 190, 210, 236, 258, 284, 315, 350, 390, 435, 490,
          540),
    "v": (*_NONE[:4], 39, 47, 55, 68, 81, 102, 120, 146, 172, 202, 228, 252, 284, 310, 340, 385, 425, 475, 530, 595,
          660),
    "x": (20, 28, 34, 40, 45, 54, 64, 80, 97, 122, 146, 178, 210, 248, 280, 310, 350, 385, 425, 475, 525, 590, 660,
          740, 820),
    "y": (*_NONE[:5], 63, 75, 94, 114, 144, 174, 214, 254, 300, 340, 380, 425, 470, 520, 580, 650, 730, 820, 920,
          1000),
    "z": (26, 35, 42, 50, 60, 73, 88, 112, 136, 172, 210, 258, 310, 365, 415, 465, 520, 575, 640, 710, 790, 900, 1000,
          1100, 1250),
    "za": (32, 42, 52, 64, 77, 98, 118, 148, 180, 226, 274, 335, 400, 470, 535, 600, 670, 740, 820, 920, 1000, 1150,
           1300, 1450, 1600),
    "zb": (40, 50, 67, 90, 108, 136, 160, 200, 242, 300, 360, 445, 525, 620, 700, 780, 880, 960, 1050, 1200, 1300,
           1500, 1650, 1850, 2100),
    "zc": (60, 80, 97, 130, 150, 188, 218, 274, 325, 405, 480, 585, 690, 800, 900, 1000, 1150, 1250, 1350, 1550, 1700,
           1900, 2100, 2400, 2600),
}  # fmt: skip
#: Lower deviations of shafts j by grade, upper ones of holes J [um], a value for each range.
_SHAFT_J = {
    5: (-2, -2, -2, -3, -4, -5, -7, -9, -11, -13, -16, -18, -20),
    6: (-2, -2, -2, -3, -4, -5, -7, -9, -11, -13, -16, -18, -20),
    7: (-4, -4, -5, -6, -8, -10, -12, -15, -18, -21, -26, -28, -32),
    8: (-6,),
}
_HOLE_J = {
    6: (2, 5, 5, 6, 8, 10, 13, 16, 18, 22, 25, 29, 33),
    7: (4, 6, 8, 10, 12, 14, 18, 22, 26, 30, 36, 39, 43),
    8: (6, 10, 12, 15, 20, 24, 28, 34, 41, 47, 55, 60, 66),
}
_LETTERS = ", ".join((*_BELOW, "j", "js", *_ABOVE))
_FIT = re.compile(
    r"\s*(?P<size>\d+(?:\.\d+)?)\s*(?P<hole>[A-Z]+)(?P<of_hole>\d+)\s*/\s*(?P<shaft>[a-z]+)(?P<of_shaft>\d+)\s*"
)
_MICROMETRE = 1e-6


class Fit(NamedTuple):
    """Limits of a fit, each as (lower, upper).

    Attributes
    ----------
    hole, shaft : (float, float)
        Deviations of the diameters from the nominal size [m].
    clearance : (float, float)
        Difference of the diameters [m]; negative: interference. The radial clearance of a joint is half of it.
    """

    hole: _Two
    shaft: _Two
    clearance: _Two


def fit(text: str) -> Fit:
    """Return the limits of an ISO fit (ISO 286-1:2010, Tables 1 to 5).

    Parameters
    ----------
    text : str
        Nominal size [mm], hole and shaft, such as "30 H7/f7"; sizes to 500 mm, all letters of the standard.

    Raises
    ------
    InputError
        If the text is no fit, or the standard does not define it.

    Examples
    --------
    >>> import linkages
    >>> limits = linkages.fit("30 H7/f7")
    >>> [round(1e6 * value) for pair in limits for value in pair]  # um
    [0, 21, -41, -20, 20, 62]
    """
    found = _FIT.fullmatch(text)
    if found is None:
        raise InputError("fit", f'"{text}"', 'is no fit; write size [mm], hole and shaft, such as "30 H7/f7"')
    size = float(found["size"])
    if not 0.0 < size <= _RANGES[-1]:
        raise InputError("fit", f'"{text}"', f"has the size {size:g} mm; allowed is more than 0, at most 500 mm")
    hole = _limits(text, size, found["hole"], int(found["of_hole"]))
    shaft = _limits(text, size, found["shaft"], int(found["of_shaft"]))
    limits = hole, shaft, (hole[0] - shaft[1], hole[1] - shaft[0])
    return Fit(*((_MICROMETRE * lower, _MICROMETRE * upper) for lower, upper in limits))


def _limits(text: str, size: float, name: str, grade: int) -> _Two:
    """Return lower and upper deviation of a hole (capital letter) or shaft [um]."""
    letter, row = name.lower(), _TOLERANCES[bisect_left(_RANGES, size)]
    if letter not in _BELOW and letter not in _ABOVE and letter not in ("j", "js"):
        raise InputError("fit", f'"{text}"', f"has the deviation {name}; known are {_LETTERS}, for holes as capitals")
    if not 1 <= grade <= len(row):
        raise InputError("fit", f'"{text}"', f"has the grade {grade}; allowed are 1 to {len(row)}")
    if size <= 1.0 and (grade >= 14 or letter in ("a", "b") or (name == "N" and grade > 8)):
        raise InputError("fit", f'"{text}"', f"has {name}{grade}, which is not defined up to 1 mm; give another class")
    width = row[grade - 1]
    if letter == "js":
        return -0.5 * width, 0.5 * width
    if letter == "j":
        return _limits_j(text, size, name, grade, width)
    if letter in _BELOW:
        distance = _defined(text, size, name, _BELOW[letter])
        return (distance, distance + width) if name.isupper() else (-distance - width, -distance)
    if name.isupper():
        upper = _upper(text, size, name, grade, row)
        return upper - width, upper
    lower = 0.0 if letter == "k" and not 4 <= grade <= 7 else _defined(text, size, name, _ABOVE[letter])
    return lower, lower + width


def _upper(text: str, size: float, name: str, grade: int, row: tuple[float, ...]) -> float:
    """Return the upper deviation of a hole K to ZC [um]: the shaft's, reversed, plus Delta for fine grades.

    Delta is the difference between the tolerances of the grade and the next finer one (Tables 2 and 3).
    """
    shaft = -_defined(text, size, name, _ABOVE[name.lower()])
    if size <= _RANGES[0]:
        return shaft
    if name == "K" and grade > 8:
        raise InputError("fit", f'"{text}"', f"has {name}{grade}, which is not defined above 3 mm; give K8 or finer")
    if name == "N" and grade > 8:
        return 0.0
    if name == "M" and grade == 6 and 250.0 < size <= 315.0:  # exception of Table 2
        return -9.0
    fine = grade <= (8 if name in ("K", "M", "N") else 7)
    return shaft + (row[grade - 1] - row[grade - 2] if fine and grade >= 3 else 0.0)


def _limits_j(text: str, size: float, name: str, grade: int, width: float) -> _Two:
    """Return the deviations of a shaft j or a hole J [um], which few grades have."""
    values = (_HOLE_J if name == "J" else _SHAFT_J).get(grade, ())
    if bisect_left(_RANGES, size) >= len(values):
        raise InputError("fit", f'"{text}"', f"has {name}{grade}, which is not defined for this size; give js or JS")
    one = float(values[bisect_left(_RANGES, size)])
    return (one - width, one) if name == "J" else (one, one + width)


def _defined(text: str, size: float, name: str, values: tuple[int, ...]) -> float:
    """Return the deviation of a size; InputError if the standard has none (h is zero everywhere, k up to 3 mm)."""
    ranges = _FINE if len(values) == len(_FINE) else _RANGES
    place = bisect_left(ranges, size)
    if place >= len(values) or (name.lower() in ("t", "v", "y") and not values[place]):
        limits = {"t": "above 24", "v": "above 14", "y": "above 18"}
        allowed = limits.get(name.lower(), "up to 10")
        raise InputError("fit", f'"{text}"', f"has {name}, which is defined {allowed} mm; give another class")
    return float(values[place])
