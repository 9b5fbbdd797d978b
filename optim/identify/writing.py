"""Results of an identification as text, and as an experiment with the values that were found."""

from __future__ import annotations

from pathlib import Path

from linkages.base.brief import cell, counted
from linkages.input.files.toml import leaves
from linkages.input.model.editing import edited
from optim.identify.load import Identification
from optim.identify.result import IdentificationResult


def format_identification(found: IdentificationResult) -> str:
    """Format a result as lines of text.

    Parameters
    ----------
    found : IdentificationResult
        From `optim.identify`.

    Examples
    --------
    >>> import optim
    >>> found = optim.identify(optim.load_identification("slider_crank_fit"))
    >>> optim.format_identification(found).splitlines()[0]
    'Slider-crank: clearance, viscosity and mass from two sensors'
    """
    first = max(
        20, *(2 + len(name) for name in [*found["parameters"], *found["nuisance"], *found["residual"]["columns"]])
    )
    lines = [found["title"], f"{'unknown':{first}s}{'value':>13s}{'deviation':>13s}{'95 % interval':>28s}  unit"]
    for name, one in found["parameters"].items():
        if one["interval"]:
            low, high = one["interval"]
            known = f"{cell(one['deviation'], 13)}{f'{low:.6g} to {high:.6g}':>28s}"
        else:
            known = f"{'not identifiable':>41s}"
        lines.append(f"{name:{first}s}{cell(one['value'], 13, '.6g')}{known}  {one['unit']}")
        if "profile_interval" in one:
            low, high = one["profile_interval"]
            lines.append(f"{'  profile':{first}s}{'':26s}{f'{low:.6g} to {high:.6g}':>28s}  {one['profile_runs']} runs")
        if "posterior" in found:
            sampled = found["posterior"]["parameters"][name]
            low, high = sampled["interval"]
            known = f"{cell(sampled['deviation'], 13)}{f'{low:.6g} to {high:.6g}':>28s}"
            lines.append(f"{'  posterior':{first}s}{cell(sampled['median'], 13, '.6g')}{known}")
    for name, sensor in found["nuisance"].items():
        lines.append(f"{name:{first}s}{cell(sensor['value'], 13, '.6g')}{cell(sensor['deviation'], 13)}")
    residual = found["residual"]
    lines += ["", f"{'column':{first}s}{'samples':>13s}{'rms':>13s}{'deviation':>13s}{'chi-square':>13s}"]
    for k, name in enumerate(residual["columns"]):
        row = (residual[key][k] for key in ("rms", "deviation", "chi_square"))
        lines.append(f"{name:{first}s}{residual['samples'][k]:13d}{''.join(cell(x, 13) for x in row)}")
    lines.append(
        f"fitted up to {found['fitted_until']:.6g} s; {counted(found['runs'], 'run')}, {found['wall_time']:.1f} s"
    )
    accuracy = found["accuracy"]
    if accuracy["used"] < accuracy["given"]:
        lines.append(
            f"solver.accuracy is {accuracy['used']:g} in these runs, not {accuracy['given']:g}: their error would shift"
            " the values"
        )
    if "posterior" in found:
        sampled = found["posterior"]
        length = f"{sampled['autocorrelation_times']:.3g} autocorrelation times"
        lines.append(f"posterior: {counted(sampled['runs'], 'run')} of {sampled['walkers']} walkers, {length}")
    if found["starts"]["count"] > 1:
        lines.append(f"{found['starts']['same']} of {found['starts']['count']} starts found these values")
    if found["prediction"] is not None:
        rows = ", ".join(f"{name} {cell(x, 0).strip()}" for name, x in found["prediction"]["rms"].items())
        lines.append(f"prediction after it, rms: {rows}")
    for name, other in found.get("alternatives", {}).items():
        rows = ", ".join(f"{key} {cell(x, 0).strip()}" for key, x in other["prediction"]["rms"].items())
        lines.append(f"model {name}: rms of the prediction {rows}")
    if "best_alternative" in found:
        lines.append(f"model {found['best_alternative']} predicts best")
    for name, away in found.get("other_laws", {}).items():
        lines.append(f"other laws that predict nearly as well change {name} by {away:.2g}")
    for pair in found["correlated"]:
        lines.append(
            f"strongly correlated ({pair['correlation']:.3f}): {pair['together']}; with one given, the other has"
            f" {pair['apart']:.2g} times its deviation"
        )
    for mixture in found["mixtures"]:
        lines.append(f"the data leave open: {mixture}")
    if found["sensors"]:
        lines.append(f"a further sensor with 1 % noise would determine it: {' or '.join(found['sensors'])}")
    for name, size in zip(residual["columns"], residual["model_error"], strict=True):
        if size is not None:
            lines.append(f"error of the model in {name}, rms: {cell(size, 0).strip()}")
    lines.append(found["assumed"])
    return "\n".join(lines + [f"warning: {one}" for one in found["warnings"]])


def fitted_experiment(task: Identification, found: IdentificationResult, target: Path) -> str:
    """Return the text of the experiment with the values that were found; comments state their deviations."""
    values = dict(leaves(task.file.set))
    origins = dict.fromkeys(values, f"set ({task.source.name})")
    for one in found["parameters"].values():
        values[one["path"]] = one["value"]
        certain = f"identified, +- {one['deviation']:.2g}" if one["deviation"] else "identified, but not identifiable"
        origins[one["path"]] = f"{certain} ({task.source.name})"
    return edited(task.system.experiment, values, target, origins)
