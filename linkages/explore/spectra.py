"""Power spectral densities of columns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import get_window, welch

from linkages.base.arguments import validated
from linkages.base.arrays import Array
from linkages.base.brief import Brief
from linkages.base.errors import InputError
from linkages.results.divergence import dense
from linkages.results.trajectory import Trajectory


@dataclass(frozen=True, repr=False)
class Spectrum(Brief):
    """One-sided power spectral density of a column; made by `spectrum`.

    Attributes
    ----------
    name : str
        Name of the column.
    frequency : (nf,) array
        Frequencies [Hz].
    density : (nf,) array
        Density, in the column's unit squared, per Hz; its integral is the column's variance.
    """

    name: str
    frequency: Array
    density: Array

    def _facts(self) -> tuple[str, dict[str, str]]:
        count, last = len(self.frequency), self.frequency[-1] if len(self.frequency) else 0.0
        strongest = self.frequency[self.density.argmax()] if count else 0.0
        return f"{self.name}, {count:,} frequencies up to {last:g} Hz", {"largest density at": f"{strongest:g} Hz"}


@validated
def spectrum(
    run: Trajectory, name: str, start: float = 0.0, samples: int = 8192, segments: int = 1, window: str = "hann"
) -> Spectrum:
    """Compute the power spectral density by Welch's method, from equidistant samples of the dense output.

    Frequencies above half the sampling rate, samples/(2 (end - start)), alias to lower ones: contacts last tens of
    microseconds and need equally fine samples.

    Parameters
    ----------
    run : Trajectory
        Run with dense output.
    name : str
        Name of the column; its mean is removed.
    start : float
        Start of the evaluated time range [s].
    samples : int
        Number of equidistant samples from the start to the end of the run.
    segments : int
        Averaged segments, overlapping by half: more give a smoother density with less resolution.
    window : str
        Name of a window of `scipy.signal.get_window` without parameters.

    Returns
    -------
    Spectrum
        Frequencies [Hz] and densities [unit of the column squared, per Hz], (nf,) arrays.

    Raises
    ------
    InputError
        If the time range, the column, the number of samples or the window is invalid.

    Examples
    --------
    >>> import linkages
    >>> motion = linkages.ideal(linkages.load(linkages.find_file("seven_bar.toml")))
    >>> density = linkages.spectrum(motion, "slider7.x", samples=1024)
    >>> float(density.frequency[density.density.argmax()])  # Hz: crank 1's
    0.5
    """
    end = float(run.time[-1])
    if not 0.0 <= start < end:
        raise InputError("argument", "start", f"is {start:g} s; the run lasts from 0 to {end:g} s")
    if segments < 1 or samples < 8 * segments:
        raise InputError("argument", "samples", f"{samples} are too few for {segments} segments; 8 for each")
    try:
        get_window(window, 8)
    except ValueError:
        known = 'such as "boxcar", "hann", "hamming" or "blackman"'
        reason = f'"{window}" is unknown or needs parameters; allowed are windows of scipy.signal without any, {known}'
        raise InputError("argument", "window", reason) from None
    times = np.linspace(start, end, samples, endpoint=False)
    _ = run[name]  # raises if the column is unknown
    values = dense(run)(times)[name]
    length = samples if segments == 1 else 2 * samples // (segments + 1)
    rate = samples / (end - start)
    frequency, density = welch(values, rate, window, nperseg=length, detrend="constant")
    return Spectrum(name, frequency, density)
