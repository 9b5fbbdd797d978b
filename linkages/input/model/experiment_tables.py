"""The tables of an experiment: joint models and their laws, numerical settings."""

from __future__ import annotations

from typing import Annotated, Literal, get_args

from pydantic import Field, field_validator

from linkages.base.errors import InputError
from linkages.elements.contact_tables import ContactTable, FrictionTable, check_states
from linkages.elements.law_tables import LawTable, parameter_field
from linkages.input.files import fits
from linkages.input.files.table_keys import OneOf
from linkages.input.files.toml import Finite, NonNegative, Positive, Table, TwoOf
from linkages.laws import FILMS
from linkages.laws.film.surface.grooves import Groove, check_grooves, no_load
from linkages.laws.heat import COLDEST, CONDUCTANCE, FRESH, HOTTEST, INLET, SPECIFIC_HEAT, SURROUNDINGS, Heat
from linkages.laws.viscosity import ISO_VG

#: Least and most cells of a film with history, around it and along half its length.
FILM_CELLS = (16, 240), (2, 20)
#: Error of the force of a film with history, over its largest force, from which a run chooses the film step.
FILM_ACCURACY = 0.003

Fraction = Annotated[float, Field(gt=0, lt=1)]
Viscosity = Annotated[float, Field(gt=0, le=1e9)]  # pitch has 2e8 Pa s


class SmallEccentricity(Table):
    """The paper's correction of the film near the centre, Chen 2025 eqs. (12)-(13): force times eps^power below ratio.

    Use it only to replicate the paper: the film is regular there without it, and with it a centred journal has nearly
    no support.
    """

    ratio: Fraction = Field(description="eps_0, below which the correction acts [1]")
    power: NonNegative = Field(description="m, 0 to 5 [1]")


class Mixed(Table):
    """Transition between film and contact, for mixed joints."""

    law: Literal["blend", "greenwood-tripp"] = Field(description="blend of Chen 2025 eq. (15), or asperities")
    transition: Positive | None = Field(None, description="blend: penetration E_0 from which only the contact acts [m]")
    film_limit: Fraction = Field(0.99, description="largest eccentricity ratio at which the film is evaluated [1]")
    roughness: Positive | None = Field(None, description="asperities: standard deviation of either surface [m]")
    density: Positive | None = Field(None, description="asperities: summits per area [1/m2]")
    tip_radius: Positive | None = Field(None, description="asperities: radius of the summits [m]")

    def _complete(self) -> None:
        needed = ("transition",) if self.law == "blend" else ("roughness", "density", "tip_radius")
        missing = [key for key in needed if getattr(self, key) is None]
        if missing:
            raise ValueError(f"{self.law} needs {' and '.join(missing)}")


class Oil(Table):
    """A mineral oil by its ISO VG grade, at a temperature: gives the viscosity."""

    grade: int = Field(description='ISO VG grade, such as 46 or "ISO VG 46": kinematic viscosity at 40 C [mm2/s]')
    temperature: Annotated[float, Field(ge=COLDEST, le=HOTTEST)] = Field(
        description="temperature of the film; with a heat balance its first guess [degC]"
    )
    density: Positive = Field(870.0, description="density at 15 C [kg/m3]")

    @field_validator("grade", mode="before")
    @classmethod
    def _of_iso(cls, given: object) -> object:
        number = given.removeprefix("ISO VG ") if isinstance(given, str) else ""
        grade = int(number) if number.isdecimal() else given
        if isinstance(grade, int) and grade not in ISO_VG:
            raise ValueError(f"ISO VG {grade} is no grade; one of {', '.join(map(str, ISO_VG))}")
        return grade


class HeatBalance(Table):
    """Lumped heat balance of a film over a cycle: film power against the flow out of the ends and conduction.

    ``linkages simulate`` repeats the run until the temperature settles; other commands use the oil's temperature.
    """

    inlet: float = parameter_field(INLET)
    conductance: float = parameter_field(CONDUCTANCE, CONDUCTANCE.default)
    surroundings: float | None = parameter_field(SURROUNDINGS, None)
    specific_heat: float = parameter_field(SPECIFIC_HEAT, SPECIFIC_HEAT.default)
    fresh: float = parameter_field(FRESH, FRESH.default)

    def of(self, oil: Oil) -> Heat:
        """Return the heat balance of an oil."""
        return Heat(oil.grade, density_15=oil.density, **dict(self))


class WearTable(Table):
    """Wear of a dry or mixed joint by Archard's law, and its initial wear.

    Depths are along the part's radius, at equally spaced angles in the part's frame, counted from x_P in the reference
    configuration; between these angles the profile is a cubic B-spline with these control depths.
    """

    coefficient: Positive = Field(description="k of dV = k N |v_t| dt [m2/N]; 1 mm3/(N m) is 1e-9 m2/N")
    side: Literal["bearing", "journal", "both"] = Field("bearing", description="body that wears")
    share: Fraction | None = Field(None, description="both: share of the bearing in the worn volume [1]")
    hardness: TwoOf[Positive] | None = Field(
        None, description="both, instead of share: hardness of bearing and journal; the softer body wears more [Pa]"
    )
    nodes: Annotated[int, Field(ge=24, le=7200)] = Field(
        360, description="number of points of a profile around the circumference"
    )
    bearing_depth: list[NonNegative] | None = Field(None, description="initial wear of the bearing: `nodes` depths [m]")
    journal_depth: list[NonNegative] | None = Field(None, description="initial wear of the journal: `nodes` depths [m]")

    def _complete(self) -> None:
        shares = [key for key in ("share", "hardness") if getattr(self, key) is not None]
        if self.side == "both" and len(shares) != 1:
            raise ValueError('side "both" needs share or hardness' + (", not both" if shares else ""))
        if self.side != "both" and shares:
            raise ValueError(f'{shares[0]} belongs to side "both"; remove it')
        for key in ("bearing_depth", "journal_depth"):
            given = getattr(self, key)
            if given is not None and len(given) != self.nodes:
                raise ValueError(f"{key} has {len(given)} depths for {self.nodes} nodes; give as many")

    @property
    def coefficients(self) -> tuple[float, float]:
        """Return the coefficients of bearing and journal [m2/N]; their sum is `coefficient`."""
        part = {"bearing": 1.0, "journal": 0.0, "both": self.share or 0.0}[self.side]
        if self.hardness is not None:
            part = self.hardness[1] / sum(self.hardness)
        return part * self.coefficient, (1.0 - part) * self.coefficient

    @property
    def depths(self) -> tuple[list[float], list[float]]:
        """Return the control depths of bearing and journal [m]; empty for a round part."""
        bearing, journal = (depths or [] for depths in (self.bearing_depth, self.journal_depth))
        return bearing if any(bearing) else [], journal if any(journal) else []


class GrooveTable(Table):
    """A feed groove or hole in the bearing."""

    angle: Finite = Field(description="of its middle in the bearing's frame, from x_P in the reference pose [rad]")
    extent: Positive = Field(description="angle that it extends over, at most a turn [rad]")
    length: Annotated[float, Field(gt=0, le=1)] = Field(1.0, description="share of the bearing's length [1]")
    pressure: NonNegative = Field(0.0, description="supply pressure, gauge [Pa]")
    position: Finite = Field(0.0, description="axial, of its middle, from the bearing's; share of the length [1]")
    shape: Literal["groove", "hole"] = Field("groove", description="rectangle, or ellipse of this extent and length")

    @property
    def groove(self) -> Groove:
        """The groove as the solver takes it."""
        return Groove(self.angle, self.extent, self.length, self.pressure, self.position, self.shape == "hole")

    def _complete(self) -> None:
        check_grooves((self.groove,), 0.0)


class FilmHistory(Table):
    """A mass-conserving film whose content is part of the state, instead of a quasi-static map; compiled engine."""

    content: Annotated[float, Field(ge=0, le=1)] = Field(1.0, description="film content at t = 0 [1]")
    step: Positive | None = Field(
        None,
        description="film step, constant without accuracy, otherwise the longest one; runs take steps of up to a "
        "quarter [s]; default: chosen by accuracy, up to 1/200 turn of the fastest drive",
    )
    accuracy: Fraction | None = Field(
        None,
        description="error of the film's force over the largest force so far, from which a run chooses the film step; "
        f"default without step: {FILM_ACCURACY} [1]",
    )
    cells: TwoOf[int] = Field(
        [48, 4],
        description="cells around the film and along half its length, default 48 and 4; edges of grooves add some",
    )

    @field_validator("cells")
    @classmethod
    def _in_range(cls, cells: list[int]) -> list[int]:
        for count, (least, most), where in zip(cells, FILM_CELLS, ("around", "along"), strict=True):
            if not least <= count <= most:
                raise ValueError(f"{count} cells {where}: must be {least} to {most}")
        return cells


def _mean_clearance(text: str) -> float:
    """Return the mean radial clearance of a fit [m]; ValueError for an interference."""
    try:
        least, most = fits.fit(text).clearance
    except InputError as problem:
        raise ValueError(f"fit {problem.where} {problem.problem}") from None
    if least < 0.0:
        raise ValueError(f'fit "{text}" can have interference; give a fit with clearance, such as "30 H7/f7"')
    return 0.25 * (least + most)


class JointModel(LawTable):
    """Model of a joint that has a bearing or a slot in the SDF file."""

    law_kind, law_key = "film", "film"

    model: Literal["ideal", "dry", "lubricated", "mixed"] = Field(description="joint model; wear needs dry or mixed")
    clearance: Positive | None = Field(None, description="radial clearance c [m]")
    fit: str | None = Field(
        None, description='where clearance is not given: ISO fit, such as "30 H7/f7"; c is half of its mean play'
    )
    film: Annotated[str, OneOf(FILMS)] = Field("finite", description="film law")
    cavitation: Literal["guembel", "reynolds", "mass-conserving"] = Field(
        "guembel", description="cavitation rule of the finite film; mass-conserving needs a groove"
    )
    groove: GrooveTable | None = Field(None, description="lubricated and mixed: feed groove of the finite film")
    grooves: dict[str, GrooveTable] = Field({}, description="further feed grooves or holes, by any names")
    tilt: TwoOf[Finite] = Field(
        [0.0, 0.0],
        description="lubricated: slope of the journal's axis in the bearing's frame, displacement along x_P and y_P (of"
        " the reference pose) per length along the normal [1]",
    )
    history: FilmHistory | None = Field(
        None, description="lubricated: the content of the mass-conserving film is part of the state"
    )
    viscosity: Viscosity | None = Field(None, description="dynamic viscosity [Pa s]")
    oil: Oil | None = Field(None, description="oil, instead of a viscosity")
    heat: HeatBalance | None = Field(None, description="lumped heat balance of the oil in a finite film")
    contact: ContactTable | None = Field(None, description="dry and mixed: normal contact")
    friction: FrictionTable | None = Field(None, description="dry and mixed: friction; default: none")
    mixed: Mixed | None = Field(None, description="mixed: combination of film and contact")
    shear_torque: bool = Field(True, description="whether the film's shear torque acts")
    shear_film: Literal["full", "half"] = Field("full", description="extent of the sheared film")
    small_eccentricity: SmallEccentricity | None = Field(None, description="the paper's correction near the centre")
    wear: WearTable | None = Field(None, description="dry and mixed: wear of bearing and journal")
    worn: str | None = Field(
        None, description="dry and mixed: wear.json of `linkages wear`, whose profiles this joint has at the start"
    )
    offset: TwoOf[Finite] = Field(
        [0.0, 0.0],
        description="journal's centre from the bearing's at t = 0, plane axes [m]; guide: offset [m], tilt [rad]",
    )

    def _complete(self) -> None:
        super()._complete()
        if self.viscosity is not None and self.oil is not None:
            raise ValueError("give viscosity or oil, not both")
        if self.fit is not None and self.clearance is None:
            self.__dict__["clearance"] = _mean_clearance(self.fit)  # not a value that was given
        needed: dict[str, object] = {"clearance": self.clearance} if self.has_play else {}
        needed |= {"viscosity": self.viscosity or self.oil} if self.has_film else {}
        needed |= {"contact": self.contact} if self.can_touch else {}
        needed |= {"mixed": self.mixed} if self.model == "mixed" else {}
        if missing := [key for key, given in needed.items() if given is None]:
            raise ValueError(f'model "{self.model}" needs {" and ".join(missing)}')
        self._check_groove()
        self._check_special()
        self._check_heat()
        if self.wear is not None and self.model == "lubricated":
            raise ValueError("wear needs a contact; make the model dry or mixed")
        asperities = self.mixed is not None and self.mixed.law == "greenwood-tripp"
        if self.can_touch:
            check_states(self.contact, self.friction)
        if self.model == "mixed" and asperities and self.contact and self.contact.youngs_modulus is None:
            raise ValueError("greenwood-tripp needs the contact's youngs_modulus")

    def _check_groove(self) -> None:
        if not self.has_film:
            return
        if not self.feed:
            if self.cavitation == "mass-conserving" and self.film == "finite":
                raise ValueError(no_load())
            return
        if self.film != "finite":
            raise ValueError('groove needs film "finite"')
        if self.cavitation == "guembel":
            raise ValueError('groove needs cavitation "reynolds" or "mass-conserving"')
        check_grooves(self.feed, 0.0)

    def _check_special(self) -> None:
        """Check tilt and history, each of which needs one model of the film."""
        for what, given, rule in (
            ("tilt", self.is_tilted, "guembel"),
            ("history", self.has_history, "mass-conserving"),
        ):
            if given and (self.model, self.film, self.cavitation) != ("lubricated", "finite", rule):
                raise ValueError(f'{what} needs model "lubricated", film "finite" and cavitation "{rule}"')
            if given and self.small_eccentricity is not None:
                raise ValueError(f"{what} and small_eccentricity exclude each other")

    def _check_heat(self) -> None:
        if self.heat is None or not self.has_film:
            return
        if self.oil is None:
            raise ValueError("heat needs oil, for the viscosity at a temperature")
        if self.film != "finite":
            raise ValueError(f'heat needs film "finite": film "{self.film}" has no flow out of its ends')
        if not self.shear_torque:
            raise ValueError("heat needs shear_torque = true: shear is most of the film's power")

    @property
    def feed(self) -> tuple[Groove, ...]:
        """Grooves and holes of the film."""
        tables = [*([] if self.groove is None else [self.groove]), *self.grooves.values()]
        return tuple(table.groove for table in tables) if self.has_film else ()

    @property
    def can_touch(self) -> bool:
        """Whether journal and bearing can be in contact."""
        return self.model in ("dry", "mixed")

    @property
    def has_film(self) -> bool:
        """Whether there is oil between journal and bearing."""
        return self.model in ("lubricated", "mixed")

    @property
    def is_tilted(self) -> bool:
        """Whether the journal is tilted in a film."""
        return self.has_film and any(self.tilt)

    @property
    def has_history(self) -> bool:
        """Whether the content of the film is part of the state."""
        return self.has_film and self.history is not None

    @property
    def is_worn(self) -> bool:
        """Whether journal or bearing is no longer round."""
        return self.can_touch and self.wear is not None and any(self.wear.depths)

    @property
    def has_play(self) -> bool:
        """Whether journal and bearing can move apart."""
        return self.model != "ideal"


#: Names of integration methods in experiments: implicit methods for stiff equations, explicit methods. The first of
#: each kind belongs to the compiled engine, the others to Drake; see `linkages.engines.methods`.
Implicit = Literal["radau_iia_5", "radau3", "radau1", "implicit_euler"]
Method = Literal[Implicit, "dormand_prince_5_4", "runge_kutta5", "runge_kutta3", "bogacki_shampine3"]
IMPLICIT = get_args(Implicit)


class RunWindow(Table):
    """A part of a run."""

    start: NonNegative = Field(description="start [s]")
    end: Positive = Field(description="end [s]")

    def _complete(self) -> None:
        if self.end <= self.start:
            raise ValueError("end must be after start")


class SolverTable(Table):
    """Numerical settings; the defaults suit lubricated joints."""

    integrator: Method | None = Field(
        None,
        description="integration method; default with films or states of laws radau_iia_5 (Drake: radau3), else"
        " dormand_prince_5_4 (Drake: runge_kutta5)",
    )
    accuracy: Annotated[float, Field(gt=0, le=0.1)] = Field(1e-7, description="relative accuracy [1]")
    max_step: Positive | None = Field(
        None, description="largest step; default on Drake 2e-3, with possible contacts 2e-5; compiled engine: none [s]"
    )
    max_steps: Annotated[int, Field(ge=1, le=5_000_000)] | None = Field(
        None, description="largest number of steps; a run that needs more ends there; default: 5,000,000 [1]"
    )
    resolve_vibrations: bool = Field(
        False,
        description="compiled engine: an implicit method follows vibrations of flexible links that are small against "
        "the accuracy of positions, as an explicit one does; otherwise it damps them",
    )
    stabilisation: NonNegative = Field(50.0, description="Drake: decay rate of drive and loop errors [1/s]")
