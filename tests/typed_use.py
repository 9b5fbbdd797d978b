"""Wrong uses of public functions: mypy reports each of them, or an ignored error that is none."""

import linkages
import optim

system: int = linkages.load("seven_bar.toml")  # type: ignore[assignment]
run: int = linkages.simulate(linkages.load("seven_bar.toml"))  # type: ignore[assignment]
study: int = optim.load_study("study.toml")  # type: ignore[assignment]
