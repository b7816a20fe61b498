"""Tests that what the detector of a stream remembers never changes a box."""

import sys

import numpy as np
import pytest

from grader.course.lessons import load_reference
from tests.prerequisites import NUMBA
from utils import scenes

NAME = "13_compiled_loops"
FUNCTIONS = (
    "best_plane",
    "detect_compiled",
    "detect_stream",
    "give_up_early",
    "misses_below",
    "remember_road",
    "search_from_scratch",
    "trust_last",
)
LEVEL = np.array([0.0, 0.0, 1.0, 1.73])


@pytest.fixture(scope="module")
def python_functions():
    """The lesson's functions in plain Python, even if Numba is installed."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "numba", None)
        load_reference.cache_clear()
        functions = load_reference(NAME, *FUNCTIONS)
    load_reference.cache_clear()
    return functions


@pytest.fixture(scope="module")
def city():
    """Three full scans of a drive through a street."""
    return [frame.cloud for frame in scenes.city_block(frames=3)]


def tilted(cloud, degrees):
    """Turn a cloud about the y axis, as if the car's nose pointed up."""
    x, y, z = cloud[:, :3].T
    sine, cosine = np.sin(np.radians(degrees)), np.cos(np.radians(degrees))
    return np.column_stack([x * cosine + z * sine, y, z * cosine - x * sine])


def difficult_stream(city):
    """Return scans between which the road stays, disappears, jumps and comes back."""
    first, second, third = city
    nowhere = np.full_like(second, np.nan)
    return [first, second, first[:0], nowhere, third, tilted(third, 4), tilted(second, -5),
            third + [0, 0, 0.4, 0], first[:, :3], first]  # fmt: skip


def distances_to_samples(points, samples):
    """Return the distance of each point from the plane of each sample; NaN if it has no plane."""
    p, q, r = points[samples].transpose(1, 0, 2)
    normals = np.cross(q - p, r - p)
    lengths = np.linalg.norm(normals, axis=1)
    with np.errstate(invalid="ignore"):
        normals /= np.where(lengths > 1e-9, lengths, np.nan)[:, None]
    return np.abs(np.einsum("sk,nsk->sn", normals, points[:, None] - p))


@pytest.mark.parametrize("seed", range(4))
def test_no_memory_changes_the_plane(python_functions, seed):
    rng = np.random.default_rng(seed)
    points = np.round(rng.uniform(-10, 10, (700, 3)) * [1, 1, 0.08], 1)
    samples = rng.integers(0, 700, (30, 3))
    samples[[0, 4]] = [[5, 5, 9], [8, 2, 8]]  # twice the same point
    counts = (distances_to_samples(points, samples) <= 0.23).sum(axis=1)
    best = samples[counts.argmax()]
    samples = np.vstack([samples, best[::-1], best[[1, 2, 0]]])  # ties, which the first must win
    plane, count = python_functions.best_plane(points, samples, 0.23)
    assert count == counts.max() < 700
    assert np.allclose(points[best] @ plane[:3] + plane[3], 0)
    for road in (np.zeros(4), plane, -plane, LEVEL, [1.0, 0, 0, 0], [0, 0, 1.0, 99]):
        found = python_functions.remember_road(points, samples, 0.23, np.array(road))
        assert np.array_equal(found[0], plane) and found[1] == count


def test_a_search_without_any_plane_finds_none(python_functions):
    points, samples = np.ones((5, 3)), np.array([[0, 1, 2], [2, 3, 4]])
    plane, count, _ = python_functions.remember_road(points, samples, 0.2, LEVEL)
    assert plane.tolist() == [0, 0, 0, 0] and count == 0


@pytest.mark.parametrize("limit", [1, 200, 600, 2000])
def test_counting_ends_soon_after_the_limit(python_functions, limit):
    heights = np.random.default_rng(6).choice([-1.73, 0.0], 2000)
    points = np.column_stack([np.zeros((2000, 2)), heights])
    starts = np.arange(0, 2000, 128)
    missed, visited = python_functions.misses_below(points, starts, LEVEL, 0.2, limit)
    assert missed == (heights[:visited] == 0).sum()
    assert visited == 2000 or (heights[: visited - 128] == 0).sum() < limit <= missed
    backwards = python_functions.misses_below(points, starts[::-1], LEVEL, 0.2, 9999)
    assert backwards == ((heights == 0).sum(), 2000)


def test_the_stream_has_the_boxes_of_its_frames(python_functions, city):
    scans = [scan[::40] for scan in difficult_stream(city)]
    before = [scan.copy() for scan in scans]
    by_numpy = load_reference("12_streaming_obstacles").detect_obstacles
    streams = [
        python_functions.detect_stream(scans, search)
        for search in (python_functions.give_up_early, python_functions.remember_road)
    ]
    for number, (scan, (early, _), (remembered, _)) in enumerate(zip(scans, *streams, strict=True)):
        alone, others = python_functions.detect_compiled(scan), by_numpy(scan)
        assert np.array_equal(early, alone) and np.array_equal(remembered, alone), number
        assert len(alone) == len(others) and (len(alone) > 3) == (number not in (2, 3)), number
        # The yaws of lesson 12 differ, but its floors and roofs contain the same points.
        assert np.allclose(alone[:, [0, 4], 2], others[:, [0, 4], 2], atol=1e-9), number
    for scan, unchanged in zip(scans, before, strict=True):
        assert np.array_equal(scan, unchanged, equal_nan=True)


def test_trust_in_the_last_road_changes_boxes(python_functions, city):
    scans = [scan[::40] for scan in (*city, tilted(city[2], 3))]
    found = python_functions.detect_stream(scans, python_functions.trust_last)
    same = [
        np.array_equal(boxes, python_functions.detect_compiled(scan))
        for (boxes, _), scan in zip(found, scans, strict=True)
    ]
    assert same[0] and not all(same[1:3]) and not same[3]


def below_ground_level(cloud):
    """Return the points among which the detector searches for the road."""
    x, y, z = cloud[:, :3].T
    return cloud[(x > -15) & (x < 35) & (y > -7) & (y < 9) & (z > -3) & (z < -1.2), :3]


def test_the_memory_saves_work_while_it_is_right(python_functions, city, monkeypatch):
    def count_by_numpy(points, plane, tolerance):
        return np.count_nonzero(np.abs(points @ plane[:3] + plane[3]) <= tolerance)

    # A loop in plain Python would take minutes.
    monkeypatch.setitem(python_functions.best_plane.__globals__, "count_near", count_by_numpy)
    searches = ("search_from_scratch", "give_up_early", "remember_road")
    road, work = np.zeros(4), []
    for cloud in (*city, tilted(city[2], 3), tilted(city[2], 3)):
        low = below_ground_level(cloud)
        samples = np.random.default_rng(0).integers(0, len(low), (50, 3))
        found = [getattr(python_functions, name)(low, samples, 0.2, road) for name in searches]
        assert all(np.array_equal(plane, found[0][0]) for plane, _, _ in found)
        road = found[0][0]
        work.append([computed / found[0][2] for _, _, computed in found])
    from_scratch, early, remembered = np.transpose(work)
    assert (from_scratch == 1).all() and (early < 0.7).all()
    assert remembered[0] == pytest.approx(early[0] + 1 / 50, rel=0.01)  # nothing to remember yet
    steady = [1, 2, 4]
    assert (remembered[steady] < early[steady]).all()
    assert remembered[steady].sum() < 0.9 * early[steady].sum()
    assert 0.95 < remembered[3] / early[3] < 1.2  # the road has jumped
    assert (from_scratch - early).sum() > 2 * (early - remembered).sum()  # most of the gain


def test_most_voxels_are_new_in_the_next_frame(city):
    occupied = []
    for x, y, z in (cloud[:, :3].T for cloud in city[:2]):
        kept = (x > -15) & (x < 35) & (y > -7) & (y < 9) & (z > -1.2) & (z < 1)
        occupied.append({*map(tuple, np.floor(np.array([x, y, z]).T[kept] / 0.2).tolist())})
    assert len(occupied[1]) > 1000
    assert len(occupied[1] - occupied[0]) > len(occupied[1]) / 2


@pytest.mark.slow
def test_the_compiled_stream_has_the_boxes_of_its_frames(city):
    pytest.importorskip("numba", reason=NUMBA)
    functions = load_reference(NAME, *FUNCTIONS)
    scans = difficult_stream(city)
    found = functions.detect_stream(scans, functions.remember_road)
    for (boxes, computed), scan in zip(found, scans, strict=True):
        assert np.array_equal(boxes, functions.detect_compiled(scan))
        assert (len(boxes) > 10) == (computed > 0) == np.isfinite(scan).any()
