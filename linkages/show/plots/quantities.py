"""Numbers for people: four significant digits with a readable unit, changes in words; files keep all digits."""

from __future__ import annotations

import math

from linkages.show.plots.style import engineering, readable

MANIFOLD = 2.0  # ratio from which a change is a multiple
_NEARLY = 0.99  # part of a whole from which what is lacking has two digits
SAME = 1e-4  # relative change that is neglected


def number(value: float | None, digits: int = 4) -> str:
    """Write a number with a true minus; "-" for none.

    Examples
    --------
    >>> from linkages.show.plots.quantities import number
    >>> number(-0.0123456), number(796.8312), number(None), number(1234567.0)
    ('−0.01235', '796.8', '-', '1.235e6')
    """
    if value is None or not math.isfinite(value):
        return "-"
    text = f"{value:.{digits}g}"
    if "e" in text:
        power = int(text.partition("e")[2])
        noise = text if power > 0 else f"{value:.2g}"  # 1.2e-12
        text = f"{float(text):.0f}" if 0 <= power < digits + 2 else noise  # 13130
    mantissa, e, exponent = text.partition("e")
    return mantissa.replace("-", "−") + (f"e{int(exponent)}" if e else "")


def quantity(value: float, si: str, digits: int = 4) -> str:
    """Write a number of an SI unit with the most readable unit.

    Examples
    --------
    >>> from linkages.show.plots.quantities import quantity
    >>> quantity(1.65e-4, "m"), quantity(13134.0, "N"), quantity(0.0119, "s", 3)
    ('165 µm', '13.13 kN', '11.9 ms')
    """
    if si == "s":
        unit, factor = ("ms", 1e3) if 0.0 < abs(value) < 1.0 else ("s", 1.0)
    else:
        unit, factor = readable(si, abs(value)) if si == "rad" else engineering(si, abs(value))
    return f"{number(factor * value, digits)} {unit}".rstrip()


def share(part: float) -> str:
    """Write a part of a whole in per cent; near the whole with two digits of what is lacking.

    Examples
    --------
    >>> from linkages.show.plots.quantities import share
    >>> share(0.0008832), share(3e-5), share(0.0), share(0.4776)
    ('0.088 %', '< 0.01 %', '0 %', '48 %')
    >>> share(0.99871), share(1.0), share(1.2)
    ('99.87 %', '100 %', '120 %')
    """
    if part == 0.0:
        return "0 %"
    if _NEARLY < part < 1.0:
        return f"{100.0 * part:.{min(1 - math.floor(math.log10(100.0 * (1.0 - part))), 6)}f} %"
    return "< 0.01 %" if abs(part) < 1e-4 else f"{number(100.0 * part, 2)} %"


def change(now: float, before: float, than: str = "ideal") -> str:
    """Tell how a value differs from the ideal one, or from another one; empty without one that is above zero.

    Examples
    --------
    >>> from linkages.show.plots.quantities import change
    >>> change(797.0, 3.32), change(13.134, 13.128), change(1.0, 1.00001), change(1.0, 0.0)
    ('240 times ideal', '0.046 % above ideal', 'as ideal', '')
    >>> change(0.91, 1.0, "nominal")
    '9 % below nominal'
    """
    if not before > 0.0 or not math.isfinite(before) or not math.isfinite(now):
        return ""
    ratio = now / before
    if ratio >= MANIFOLD:
        return f"{number(ratio, 3)} times {than}"
    if abs(ratio - 1.0) < SAME:
        return f"as {than}"
    return f"{share(abs(ratio - 1.0))} {'above' if ratio > 1.0 else 'below'} {than}"


def uncertain(value: float, deviation: float, si: str) -> str:
    """Write a value and its deviation in the same readable unit, the deviation with two digits.

    Examples
    --------
    >>> from linkages.show.plots.quantities import uncertain
    >>> uncertain(1.9987e-4, 3.1e-7, "m"), uncertain(0.1234, 0.05, "1")
    ('199.87 ± 0.31 µm', '0.123 ± 0.050')
    """
    unit, factor = engineering(si, abs(value))
    return f"{uncertain_number(factor * value, factor * deviation)} {unit}".rstrip()


def uncertain_number(value: float, deviation: float) -> str:
    """Write a value and its deviation with the same decimals."""
    if not deviation > 0.0 or not math.isfinite(deviation):
        return number(value)
    decimals = 1 - math.floor(math.log10(deviation))
    if not 0 <= decimals <= 6 or abs(value) >= 1e6:
        return f"{number(value)} ± {number(deviation, 2)}"
    return f"{value:.{decimals}f} ± {deviation:.{decimals}f}".replace("-", "−")
