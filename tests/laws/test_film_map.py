"""The film map against the solver, passivity of all films, and the cache on disk."""

import hashlib
import math
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from joint_records import joint

from linkages.laws import FILMS
from linkages.laws.film import map_cache
from linkages.laws.film.closed_form import half_film_long
from linkages.laws.film.film_map import CAVITATIONS, EPS_LIMIT, build_map, finite_film, solve_scaled, table_limit
from linkages.laws.film.films import film_force
from linkages.laws.film.map_cache import cache_directory, load_map, map_path

SLENDERNESS = 0.04 / 0.03  # Chen 2025 Table 5


# the map by Reynolds' rule takes ten seconds and more to build
_RULES = [pytest.param(rule, marks=pytest.mark.slow if rule == "reynolds" else ()) for rule in CAVITATIONS]


@pytest.fixture(scope="module", params=_RULES)
def rule_and_table(request):
    return request.param, build_map(SLENDERNESS, request.param)


def map_errors(rule, table, largest, count=150, slenderness=SLENDERNESS):
    """Differences from the solver at random points with eps up to `largest`, in units of |F_long|."""
    random = np.random.default_rng(7)
    errors = []
    for x, y in random.uniform((0.0, 0.0), (-math.log1p(-largest), math.pi), (count, 2)):
        eps = -math.expm1(-x)
        deps, ew = math.cos(y), 2.0 * math.sin(y) / (1.0 - eps * eps) ** 0.25
        f_n, f_t, _ = finite_film(eps, deps, ew, table)
        scale = math.hypot(*half_film_long(eps, deps, ew, slenderness)[:2])
        exact = solve_scaled(eps, slenderness, rule, np.array([y]))[0]
        errors.append(math.hypot(f_n / scale - exact[0], f_t / scale - exact[1]))
    return max(errors)


def test_map_against_the_solver(rule_and_table):
    """Interpolation error; Reynolds' free boundary moves by mesh lines, which no smooth spline follows."""
    rule, table = rule_and_table
    assert map_errors(rule, table, 0.99) < {"guembel": 5e-4, "reynolds": 1e-3}[rule]


@pytest.mark.slow
def test_map_of_a_long_bearing_against_the_solver():
    """Under Reynolds' condition the middle of the film is wet all around in a part of the map."""
    assert map_errors("reynolds", build_map(16.0, "reynolds"), 0.99, slenderness=16.0) < 1e-3


def test_map_at_its_nodes_is_the_solver(rule_and_table):
    rule, table = rule_and_table
    step = -math.log1p(-EPS_LIMIT) / 48.0
    for i, j in ((0, 0), (7, 48), (20, 30), (48, 5)):
        eps, y = -math.expm1(-i * step), j * math.pi / 48.0
        deps, ew = math.cos(y), 2.0 * math.sin(y) / (1.0 - eps * eps) ** 0.25
        exact = solve_scaled(eps, SLENDERNESS, rule, np.linspace(0.0, math.pi, 49))[j]
        scale = math.hypot(*half_film_long(eps, deps, ew, SLENDERNESS)[:2])
        assert finite_film(eps, deps, ew, table)[0] == pytest.approx(scale * exact[0], abs=1e-9 * scale)


def test_the_slenderness_of_chen_2025_is_not_long():
    """L/D = 1.33, rotation: the long film is 2.9, 2.4 and 1.4 times too strong at eps = 0.05, 0.5, 0.9."""
    table = build_map(SLENDERNESS, "guembel", nodes=33)
    for eps, ratio in ((0.05, 2.9), (0.5, 2.4), (0.9, 1.4)):
        finite, long = finite_film(eps, 0.0, eps, table), half_film_long(eps, 0.0, eps, SLENDERNESS)
        assert math.hypot(*long[:2]) / math.hypot(*finite[:2]) == pytest.approx(ratio, abs=0.05)


@settings(max_examples=400)
@given(eps=st.floats(0.0, 1.2), direction=st.floats(-math.pi, math.pi), size=st.floats(1e-3, 1e3))
def test_map_is_passive_odd_and_homogeneous(rule_and_table, eps, direction, size):
    _, table = rule_and_table
    deps, ew = math.cos(direction), 2.0 * math.sin(direction)
    f_n, f_t, extent = finite_film(eps, deps, ew, table)
    assert f_n * deps - 0.5 * f_t * ew < 0.0
    assert extent > 0.0
    assert finite_film(eps, deps, -ew, table) == pytest.approx((f_n, -f_t, extent), rel=1e-12, abs=1e-12)
    scaled = finite_film(eps, size * deps, size * ew, table)
    # in a direction the force may vanish, hence the absolute part
    force = math.hypot(f_n, f_t)
    assert scaled[:2] == pytest.approx((size * f_n, size * f_t), abs=1e-9 * size * force)


@settings(max_examples=300)
@given(
    name=st.sampled_from(sorted(set(FILMS) - {"finite"})),
    eps=st.floats(0.0, EPS_LIMIT),
    direction=st.floats(-math.pi, math.pi),
    slenderness=st.floats(0.05, 4.0),
)
def test_closed_form_films_are_passive(name, eps, direction, slenderness):
    """Up to the largest eps of the maps: nearer to the wall the short film's terms cancel to round-off."""
    deps, ew = math.cos(direction), 2.0 * math.sin(direction)
    f_n, f_t, _ = film_force(joint(film=name), eps, deps, ew, slenderness, np.empty(0))
    assert f_n * deps - 0.5 * f_t * ew < 0.0


def test_map_is_continuous_over_its_lines_and_clipped_at_its_limit(rule_and_table):
    _, table = rule_and_table
    assert table_limit(table) == pytest.approx(EPS_LIMIT, rel=1e-12)
    assert finite_film(0.9999, 0.3, 0.5, table) == finite_film(table_limit(table), 0.3, 0.5, table)
    assert finite_film(1.5, 0.3, 0.5, table) == finite_film(table_limit(table), 0.3, 0.5, table)
    step = table[5] / 48.0
    for i in (1, 10, 47):
        below, above = -math.expm1(-i * step * (1.0 - 1e-12)), -math.expm1(-i * step * (1.0 + 1e-12))
        assert finite_film(below, 0.3, 0.5, table) == pytest.approx(finite_film(above, 0.3, 0.5, table), rel=1e-8)
    assert np.isfinite(finite_film(0.5, 0.0, 0.0, table)).all()  # a journal at rest
    assert finite_film(0.5, 0.0, 0.0, table)[:2] == (0.0, 0.0)


def test_progress_is_told():
    told = []
    build_map(1.0, nodes=5, progress=told.append)
    assert told == pytest.approx([0.2, 0.4, 0.6, 0.8, 1.0])


def test_bad_inputs_are_refused():
    with pytest.raises(ValueError, match="must be one of guembel, reynolds"):
        build_map(1.0, "jfo")
    with pytest.raises(ValueError, match="at least 5"):
        build_map(1.0, nodes=4)
    with pytest.raises(ValueError, match="slenderness"):
        build_map(-1.0, nodes=5)


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """Cache in a new directory, and a count of the maps that are built."""
    monkeypatch.setenv("LINKAGES_CACHE", str(tmp_path / "maps"))
    built = []

    def counted(*arguments):
        built.append(arguments)
        return build_map(*arguments)

    monkeypatch.setattr(map_cache, "build_map", counted)
    return built


def test_cache_keeps_maps_apart_and_reads_them_back(cache, tmp_path):
    first = load_map(0.5, nodes=9)
    assert np.array_equal(load_map(0.5, nodes=9), first)
    assert len(cache) == 1
    load_map(0.5000000000000001, nodes=9)
    load_map(0.5, "reynolds", nodes=9)
    load_map(0.5, nodes=11)
    assert len(cache) == 4
    assert cache_directory() == tmp_path / "maps"
    assert len(list(cache_directory().iterdir())) == 4  # and no part files


def damaged(data, how):
    if how == "truncated":
        return data[:-100]
    if how == "bit":
        return data[:-50] + bytes([data[-50] ^ 1]) + data[-49:]
    if how == "empty":
        return b""
    payload = data[32:]
    table = np.frombuffer(payload[-8 * (6 + 3 * 121) :]).copy()
    if how == "nan":
        table[50] = math.nan
    elif how == "version":
        table[0] += 1.0
    elif how == "slenderness":
        table[1] = 0.6
    changed = payload[: -table.nbytes] + table.tobytes()
    if how == "not an array":
        changed = b"pickled?"
    if how == "shape":
        changed = changed[:128].replace(b"(369,)", b"(368,)") + changed[128:]
    return hashlib.sha256(map_cache._IDENTITY + changed).digest() + changed


@pytest.mark.parametrize("how", ["truncated", "bit", "empty", "nan", "version", "slenderness", "not an array", "shape"])
def test_damaged_maps_are_built_again(cache, how):
    """Also where the checksum is right, as with a file made by other code."""
    table = load_map(0.5, nodes=9)
    path = map_path(0.5, nodes=9)
    sound = path.read_bytes()
    path.write_bytes(damaged(sound, how))
    assert path.read_bytes() != sound
    assert np.array_equal(load_map(0.5, nodes=9), table)
    assert len(cache) == 2
    assert path.read_bytes() == sound


def test_a_cache_that_cannot_be_written_costs_a_warning(cache, tmp_path, monkeypatch):
    (tmp_path / "file").write_text("not a directory")
    monkeypatch.setenv("LINKAGES_CACHE", str(tmp_path / "file" / "maps"))
    with pytest.warns(UserWarning, match="film map not stored"):
        table = load_map(0.5, nodes=9)
    assert table_limit(table) == pytest.approx(EPS_LIMIT)


def test_the_default_cache_is_the_platforms(monkeypatch, tmp_path):
    monkeypatch.delenv("LINKAGES_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr("sys.platform", "linux")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert cache_directory() == tmp_path / "linkages"
