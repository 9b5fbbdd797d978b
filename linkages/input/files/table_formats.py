"""Columns with units for other programs: pandas, xarray, CSV, MATLAB, Parquet, NetCDF."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkages.base.packages import needed

if TYPE_CHECKING:  # the command line imports this module for the names of the formats, and must start fast
    from linkages.base.arrays import Array

    Columns = dict[str, Array]

_ROWS = 1000  # rows of a CSV file that are written at once
_LONGEST = 63  # most characters of a name in MATLAB


def dataframe(columns: Columns, units: Mapping[str, str]) -> Any:
    """Make a pandas DataFrame over the column "time"; ``attrs["units"]`` has the units."""
    frame = needed("pandas", "to_dataframe").DataFrame(dict(columns)).set_index("time")
    frame.attrs["units"] = dict(units)
    return frame


def dataset(columns: Columns, units: Mapping[str, str], attributes: Mapping[str, str]) -> Any:
    """Make an xarray Dataset over the column "time"; each variable has ``attrs["units"]``."""
    xarray = needed("xarray", "to_xarray")
    made = {name: ("time", values, _unit(units, name)) for name, values in columns.items()}
    time = made.pop("time")
    return xarray.Dataset(made, coords={"time": time}, attrs=dict(attributes))


def _unit(units: Mapping[str, str], name: str) -> dict[str, str]:
    return {"units": units[name]} if name in units else {}


def write_csv(path: Path, columns: Columns, units: Mapping[str, str], attributes: Mapping[str, str]) -> None:
    """Write comma-separated values; headings are ``name [unit]``; numbers are exact."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(f"{name} [{units[name]}]" if name in units else name for name in columns)
        last = len(next(iter(columns.values())))
        for first in range(0, last, _ROWS):  # numbers of Python take four times the columns' memory
            part = slice(first, first + _ROWS)
            writer.writerows(zip(*(values[part].tolist() for values in columns.values()), strict=True))


def write_mat(path: Path, columns: Columns, units: Mapping[str, str], attributes: Mapping[str, str]) -> None:
    """Write a MATLAB file: ``A.force`` is a field of the structure ``A``; also ``units`` and ``about``."""
    from scipy.io import savemat

    content: dict[str, Any] = {}
    for name, values in columns.items():
        _put(content, name.split("."), values)
        _put(content, ["units", *name.split(".")], units.get(name, ""))
    _put(content, ["about"], {_field(name): text for name, text in attributes.items()})
    savemat(path, content, appendmat=False, long_field_names=True, do_compression=True, oned_as="column")


def _put(content: dict[str, Any], parts: list[str], value: Any) -> None:
    """Put a value into nested structures; a duplicate name gets an underscore."""
    name = _field(parts[0])
    last = len(parts) == 1
    while name in content and (last or not isinstance(content[name], dict)):
        name += "_"
    if last:
        content[name] = value
    else:
        _put(content.setdefault(name, {}), parts[1:], value)


def _field(name: str) -> str:
    plain = re.sub(r"\W", "_", name, flags=re.ASCII)
    return (plain if plain[:1].isalpha() else f"x{plain}")[:_LONGEST]


def write_parquet(path: Path, columns: Columns, units: Mapping[str, str], attributes: Mapping[str, str]) -> None:
    """Write Apache Parquet; the metadata of each field has the unit."""
    pyarrow, parquet = needed("pyarrow", "parquet"), needed("pyarrow.parquet", "parquet")
    arrays = {name: pyarrow.array(values) for name, values in columns.items()}
    fields = [pyarrow.field(name, x.type, metadata=_unit(units, name) or None) for name, x in arrays.items()]
    schema = pyarrow.schema(fields, metadata=dict(attributes))
    parquet.write_table(pyarrow.table(list(arrays.values()), schema=schema), path)


def write_netcdf(path: Path, columns: Columns, units: Mapping[str, str], attributes: Mapping[str, str]) -> None:
    """Write NetCDF (version 3, which all readers support); names have no slash. Takes the columns out of `columns`."""
    from scipy.io import netcdf_file

    with netcdf_file(path, "w", version=2) as file:
        for name, text in attributes.items():
            setattr(file, name, text.encode())
        file.createDimension("time", len(columns["time"]))
        for name in [*columns]:  # the file is in memory until it is closed, and each column once only
            variable = file.createVariable(name.replace("/", "_"), "d", ("time",))
            variable[:] = columns.pop(name)
            for attribute, text in _unit(units, name).items():
                setattr(variable, attribute, text.encode())


#: Function and file suffix of each format.
FORMATS: dict[str, tuple[Callable[[Path, Columns, Mapping[str, str], Mapping[str, str]], None], str]] = {
    "csv": (write_csv, ".csv"),
    "mat": (write_mat, ".mat"),
    "parquet": (write_parquet, ".parquet"),
    "netcdf": (write_netcdf, ".nc"),
}
