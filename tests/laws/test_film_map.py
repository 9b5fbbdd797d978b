"""The film map against the solver, passivity of all films, and the cache on disk."""

import hashlib
import math
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from joint_records import joint, map_quantities

from linkages.base.disk import cache_directory
from linkages.laws import FILMS
from linkages.laws.film import film_map
from linkages.laws.film.closed_form import half_film_long
from linkages.laws.film.film_map import CAVITATIONS, EPS_LIMIT, MapCase, build_map, load_map, map_path
from linkages.laws.film.films import film_force
from linkages.laws.film.map_nodes import solve_plain
from linkages.laws.film.map_table import head_of, ratios, table_limit

SLENDERNESS = 0.04 / 0.03  # Chen 2025 Table 5


# the map by Reynolds' rule takes ten seconds to build
_RULES = [pytest.param(rule, marks=pytest.mark.slow if rule == "reynolds" else ()) for rule in CAVITATIONS]


@pytest.fixture(scope="module", params=_RULES)
def rule_and_table(request):
    return request.param, build_map(MapCase(SLENDERNESS, request.param))


def map_errors(rule, table, largest, count=150, slenderness=SLENDERNESS):
    """Differences from the solver at random points with eps up to `largest`, in units of |F_long|."""
    random = np.random.default_rng(7)
    errors = []
    for x, y in random.uniform((0.0, 0.0), (-math.log1p(-largest), math.pi), (count, 2)):
        eps = -math.expm1(-x)
        deps, ew = math.cos(y), 2.0 * math.sin(y) / (1.0 - eps * eps) ** 0.25
        f_n, f_t, *_ = map_quantities(eps, deps, ew, 0.0, table)
        scale = math.hypot(*half_film_long(eps, deps, ew, slenderness)[:2])
        exact = solve_plain(eps, slenderness, rule, np.array([y]))[0]
        errors.append(math.hypot(f_n / scale - exact[0], f_t / scale - exact[1]))
    return max(errors)


def test_map_against_the_solver(rule_and_table):
    """Interpolation error; Reynolds' free boundary moves by mesh lines, which no smooth spline follows."""
    rule, table = rule_and_table
    assert map_errors(rule, table, 0.99) < {"guembel": 5e-4, "reynolds": 1e-3}[rule]


@pytest.mark.slow
def test_map_of_a_long_bearing_against_the_solver():
    """Under Reynolds' condition the middle of the film is wet all around in a part of the map."""
    assert map_errors("reynolds", build_map(MapCase(16.0, "reynolds")), 0.99, slenderness=16.0) < 1e-3


def test_map_at_its_nodes_is_the_solver(rule_and_table):
    """Force and flow; nodes below 0 in y are mirror images."""
    rule, table = rule_and_table
    for i, j in ((0, 0), (7, 48), (20, 30), (40, -30), (56, 5)):
        eps, y = float(ratios(head_of(table))[i]), j * math.pi / 48.0
        deps, ew = math.cos(y), 2.0 * math.sin(y) / (1.0 - eps * eps) ** 0.25
        exact = solve_plain(eps, SLENDERNESS, rule, np.linspace(0.0, math.pi, 49))[abs(j)]
        scale = math.hypot(*half_film_long(eps, deps, ew, SLENDERNESS)[:2])
        f_n, f_t, _, flow = map_quantities(eps, deps, ew, 0.0, table)
        assert f_n == pytest.approx(scale * exact[0], abs=1e-9 * scale)
        assert f_t == pytest.approx(math.copysign(scale * exact[1], f_t), abs=1e-9 * scale)
        assert flow == pytest.approx(exact[3], rel=1e-9)


@settings(max_examples=400)
@given(eps=st.floats(0.0, 1.2), direction=st.floats(-math.pi, math.pi), size=st.floats(1e-3, 1e3))
def test_map_is_passive_odd_and_homogeneous(rule_and_table, eps, direction, size):
    _, table = rule_and_table
    deps, ew = math.cos(direction), 2.0 * math.sin(direction)
    f_n, f_t, extent, flow = map_quantities(eps, deps, ew, 0.0, table)
    assert f_n * deps - 0.5 * f_t * ew < 0.0
    assert extent > 0.0
    mirrored = map_quantities(eps, deps, -ew, 0.0, table)
    assert mirrored == pytest.approx((f_n, -f_t, extent, flow), rel=1e-9, abs=1e-9 * math.hypot(f_n, f_t))
    scaled = map_quantities(eps, size * deps, size * ew, 0.0, table)
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
    assert map_quantities(0.9999, 0.3, 0.5, 0.0, table) == map_quantities(table_limit(table), 0.3, 0.5, 0.0, table)
    assert map_quantities(1.5, 0.3, 0.5, 0.0, table) == map_quantities(table_limit(table), 0.3, 0.5, 0.0, table)
    for i in (1, 10, 47):
        node = float(ratios(head_of(table))[i])
        below, above = node - 1e-13, node + 1e-13
        assert map_quantities(below, 0.3, 0.5, 0.0, table) == pytest.approx(
            map_quantities(above, 0.3, 0.5, 0.0, table), rel=1e-8
        )
    assert np.isfinite(map_quantities(0.5, 0.0, 0.0, 0.0, table)).all()  # a journal at rest
    assert map_quantities(0.5, 0.0, 0.0, 0.0, table)[:2] == (0.0, 0.0)


def test_progress_is_told():
    told = []
    build_map(MapCase(1.0, nodes=(5, 8, 1)), progress=told.append)
    assert told == pytest.approx([0.2, 0.4, 0.6, 0.8, 1.0])


def test_bad_inputs_are_refused():
    with pytest.raises(ValueError, match="must be one of guembel, reynolds"):
        build_map(MapCase(1.0, "jfo"))
    with pytest.raises(ValueError, match="at least 5"):
        build_map(MapCase(1.0, nodes=(4, 8, 1)))
    with pytest.raises(ValueError, match="slenderness"):
        build_map(MapCase(-1.0, nodes=(5, 8, 1)))


def small(*inputs):
    """Inputs of a map with few nodes."""
    return MapCase(*inputs, nodes=(9, 8, 1))


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """Cache in a new directory, and a count of the maps that are built."""
    monkeypatch.setenv("LINKAGES_CACHE", str(tmp_path / "maps"))
    built = []

    def counted(*arguments):
        built.append(arguments)
        return build_map(*arguments)

    monkeypatch.setattr(film_map, "build_map", counted)
    return built


def test_cache_keeps_maps_apart_and_reads_them_back(cache, tmp_path):
    first = load_map(small(0.5))
    assert np.array_equal(load_map(small(0.5)), first)
    assert len(cache) == 1
    load_map(small(0.5000000000000001))
    load_map(small(0.5, "reynolds"))
    load_map(small(0.5)._replace(nodes=(11, 8, 1)))
    assert len(cache) == 4
    assert cache_directory() == tmp_path / "maps"
    files = [path for path in cache_directory().iterdir() if path.is_file()]
    assert len(files) == 4  # and no part files


def test_listeners_hear_of_maps_that_are_built(cache, monkeypatch):
    """Not of stored ones."""
    heard = []
    monkeypatch.setattr(film_map, "_told", [])
    film_map.tell(lambda case: lambda done: heard.append((case.slenderness, done)))
    for _ in range(2):
        load_map(small(0.6))
    assert [slenderness for slenderness, _ in heard] == [0.6] * 9
    assert [done for _, done in heard] == pytest.approx(np.arange(1, 10) / 9)


def damaged(data, how):
    if how == "truncated":
        return data[:-100]
    if how == "bit":
        return data[:-50] + bytes([data[-50] ^ 1]) + data[-49:]
    if how == "empty":
        return b""
    table = np.frombuffer(data[32:]).copy()
    if how == "nan":
        table[50] = math.nan
    elif how == "version":
        table[0] += 1.0
    elif how == "slenderness":
        table[1] = 0.6
    changed = {"not numbers": b"pickled?", "shape": table[:-1].tobytes()}.get(how, table.tobytes())
    return hashlib.sha256(film_map._IDENTITY + changed).digest() + changed


@pytest.mark.parametrize("how", ["truncated", "bit", "empty", "nan", "version", "slenderness", "not numbers", "shape"])
def test_damaged_maps_are_built_again(cache, how):
    """Also where the checksum is right, as with a file made by other code."""
    table = load_map(small(0.5))
    path = map_path(small(0.5))
    sound = path.read_bytes()
    path.write_bytes(damaged(sound, how))
    assert path.read_bytes() != sound
    assert np.array_equal(load_map(small(0.5)), table)
    assert len(cache) == 2
    assert path.read_bytes() == sound


def test_a_cache_that_cannot_be_written_costs_a_warning(cache, tmp_path, monkeypatch):
    (tmp_path / "file").write_text("not a directory")
    monkeypatch.setenv("LINKAGES_CACHE", str(tmp_path / "file" / "maps"))
    with pytest.warns(UserWarning, match="film map not stored"):
        table = load_map(small(0.5))
    assert table_limit(table) == pytest.approx(EPS_LIMIT)


def test_the_default_cache_is_the_platforms(monkeypatch, tmp_path):
    monkeypatch.delenv("LINKAGES_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr("sys.platform", "linux")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert cache_directory() == tmp_path / "linkages"
