"""Print the lowest declared versions of the package's dependencies as constraints for pip."""

import re
import tomllib

with open("pyproject.toml", "rb") as file:
    project = tomllib.load(file)["project"]
for line in [*project["dependencies"], *project["optional-dependencies"]["export"]]:
    name, lowest = re.match(r"([\w.-]+)>=([\d.]+)", line).groups()
    print(f"{name}=={lowest}")
