"""3D scenes: cameras, layers, the pictures of both renderers, and the interactive view."""

import base64
import itertools
import json
import os
import re
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.prerequisites import PATIENCE
from utils.scene3d import CAMERAS, LAYERS, Camera, Scene, builders, opengl, output, solids, viewer
from utils.scene3d.cameras import as_camera, clip_to_front
from utils.scene3d.eye_dome import eye_dome
from utils.scene3d.parts import Label, Points, Segments, cut_into_dashes

PROJECT = Path(__file__).resolve().parent.parent
SIZE = (240, 136)
RENDERERS = ("pyvista", "matplotlib")
BOX = np.array([[x, y, z] for z in (-1.7, 0.0) for y in (1, 3) for x in (4, 8)], dtype=float)


@pytest.fixture(params=RENDERERS)
def renderer(request):
    if request.param == "pyvista" and opengl.problem():
        pytest.skip(opengl.problem())
    return request.param


@pytest.fixture
def street():
    rng = np.random.default_rng(0)
    return rng.uniform((-20, -8, -1.8, 0), (40, 8, 1, 1), (3000, 4))


class Node:
    def __init__(self, point, left=None, right=None):
        self.point, self.left, self.right = point, left, right


def everything(cloud):
    tree = Node((0.0, 0.0, -1.0), Node((-5.0, 2.0, 0.0)), Node((9.0, -2.0, 0.0)))
    return (
        Scene("Everything")
        .add_road(1.8)
        .add_cars(BOX[None])
        .add_rays(cloud, most=50)
        .add_cloud(cloud)
        .add_cloud(cloud[::4], layer="filtered_cloud")
        .add_plane(cloud[cloud[:, 2] < -1], (0, 0, 1, 1.7))
        .add_obstacles(cloud[cloud[:, 2] > 0])
        .add_kd_tree(tree)
        .add_clusters(cloud, np.arange(len(cloud)) % 5)
        .add_ego_car()
        .add_boxes(BOX[None], names=True)
        .add_oriented_boxes(BOX[None] - (9, 0, 0))
        .add_trails([BOX[:3], BOX[:1]])
    )


# Cameras -------------------------------------------------------------------------------------


def test_the_four_cameras_have_their_documented_positions():
    places = {name: (camera.position, camera.target) for name, camera in CAMERAS.items()}
    assert places == {
        "XY": ((-16, -16, 16), (1, 1, 0)),
        "TopDown": ((0, 0, 16), (1, 0, 1)),
        "Side": ((0, -16, 0), (0, 0, 1)),
        "FPS": ((-10, 0, 0), (0, 0, 1)),
    }


@pytest.mark.parametrize("name", CAMERAS)
def test_a_camera_sees_its_target_in_the_middle_and_left_on_the_left(name):
    camera = CAMERAS[name]
    seen = camera.to_camera(camera.target)
    np.testing.assert_allclose(camera.to_pixels(seen, SIZE), (120, 68), atol=1e-9)
    side = {"Side": (-1, 0, 0)}.get(name, (0, 1, 0))  # towards the left of the picture
    neighbour = camera.to_pixels(camera.to_camera(np.add(camera.target, side)), SIZE)
    assert neighbour[0] < 120


def test_a_camera_is_found_in_any_case_and_an_unknown_one_is_reported():
    assert as_camera("topdown") is CAMERAS["TopDown"]
    with pytest.raises(ValueError, match="XY, TopDown, Side, FPS"):
        as_camera("birdseye")
    with pytest.raises(ValueError, match="must not be parallel"):
        Camera((0, 0, 5), (0, 0, 0)).axes()


def test_moving_a_camera_away_keeps_its_view():
    camera = CAMERAS["XY"].farther(2)
    assert camera.target == (1, 1, 0)
    np.testing.assert_allclose(camera.position, (-33, -33, 32))


def test_lines_are_cut_off_behind_the_camera():
    ends = np.array([[(0, 0, -1), (0, 0, 1)], [(0, 0, -1), (0, 0, -2)], [(1, 0, 1), (1, 0, 2)]])
    kept = clip_to_front(ends.astype(float))
    assert len(kept) == 2
    assert kept[:, :, 2].min() == pytest.approx(0.05)


# Solids --------------------------------------------------------------------------------------


def test_a_box_has_the_same_edges_whatever_the_order_of_its_corners():
    def lengths(box):
        ends = solids.edges_of(solids.order_corners(box[None]))
        return np.sort(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))

    for order in itertools.islice(itertools.permutations(range(8)), 0, None, 997):
        np.testing.assert_allclose(lengths(BOX[list(order)]), [1.7] * 4 + [2] * 4 + [4] * 4)


def test_a_block_car_fills_its_box_and_has_a_shorter_roof():
    lower, upper = solids.block_car(solids.order_corners(BOX[None])[0])
    np.testing.assert_allclose([lower.min(axis=0), upper.max(axis=0)], [(4, 1, -1.7), (7, 3, 0)])
    assert np.ptp(upper[:, 0]) == pytest.approx(2)
    assert np.ptp(lower[:, 0]) == pytest.approx(4)


@pytest.mark.parametrize("plane", [(0, 0, 1, 1.7), (1, 0, 0, -3), (0.1, -0.2, 2, 3)])
def test_corners_of_a_plane_patch_are_on_the_plane(plane, street):
    triangles, grid = solids.plane_patch(plane, street[:, :3])
    for points in (triangles.reshape(-1, 3), grid.reshape(-1, 3)):
        np.testing.assert_allclose(points @ plane[:3] + plane[3], 0, atol=1e-9)


def test_a_plane_without_direction_is_refused(street):
    with pytest.raises(ValueError, match="four finite numbers"):
        Scene().add_plane(street, (0, 0, 0, 1))


def test_splitting_planes_of_a_kd_tree_end_even_with_a_cycle():
    root = Node((0, 0, 0), Node((-5, 1, 0)), Node((5, -1, 0)))
    root.left.left = root  # a cycle, such as a wrong `insert` may build
    cuts = list(solids.kd_cuts(root, (-10, -10, -10), (10, 10, 10), depth=5))
    assert [cut.axis for cut in cuts] == [0, 1, 1]
    assert cuts[1].corners[:, 0].max() == 0  # the left child's plane ends at the root's plane
    assert set(cuts[1].corners[:, 1]) == {1}


def test_dashes_begin_and_end_with_the_line():
    pieces = cut_into_dashes(np.array([[(0.0, 0, 0), (2.0, 0, 0)]]), dash=0.25)
    assert pieces[0, 0, 0] == 0 and pieces[-1, 1, 0] == 2
    assert (pieces[:, 1, 0] - pieces[:, 0, 0]).sum() < 1.3


# Layers -------------------------------------------------------------------------------


def test_every_switch_removes_its_part(street):
    scene = everything(street)
    assert {part.layer for part in scene.parts} == set(LAYERS)
    for name in LAYERS:
        assert name not in {part.layer for part in scene.switch(**{name: False}).parts}
        scene.switch(**{name: True})
    assert {part.layer for part in scene.only("boxes", "clusters").parts} == {"boxes", "clusters"}


def test_a_trail_connects_its_positions():
    (part,) = Scene().add_trails([BOX[:3], BOX[4:5], np.empty((0, 3))]).parts
    np.testing.assert_array_equal(part.ends, [BOX[:2], BOX[1:3]])
    assert part.name == "1 trail"
    assert not len(Scene().add_trails([]).parts[0].ends)


def test_an_unknown_layer_is_refused_with_the_known_names():
    for attempt in (
        lambda: Scene().switch(box=False),
        lambda: Scene().only("points"),
        lambda: Scene().add_cloud(np.zeros((1, 3)), layer="cloud"),
    ):
        with pytest.raises(ValueError, match="oriented_boxes"):
            attempt()


def test_clusters_differ_by_colour_and_by_number(street):
    labels = np.repeat([0, 1, 2], 1000)
    parts = Scene().add_clusters(street, labels).parts
    members, noise = (part for part in parts if isinstance(part, Points))
    assert len(np.unique(members.colours, axis=0)) == 2 and len(noise.xyz) == 1000
    assert noise.size < members.size
    assert [part.text for part in parts if isinstance(part, Label)] == ["1", "2"]


def test_the_ego_car_is_magenta_plane_and_obstacles_are_green_and_red(street):
    scene = Scene().add_ego_car().add_plane(street).add_obstacles(street)
    red, green, blue = builders.rgb_bytes(builders.MAGENTA)
    assert min(red, blue) > 2 * green
    plane, obstacles = (part.colours[0] for part in scene.parts if isinstance(part, Points))
    assert plane.argmax() == 1 and obstacles.argmax() == 0


def test_reference_boxes_are_dashed(street):
    plain, broken = (
        next(part for part in scene.parts if isinstance(part, Segments))
        for scene in (Scene().add_boxes(BOX[None]), Scene().add_boxes(BOX[None], reference=True))
    )
    assert len(plain.ends) == 12 and len(broken.ends) > 24 and broken.is_dashed


def test_rows_and_boxes_with_nan_are_omitted_and_the_input_is_unchanged(street):
    street[5] = np.nan
    before = street.copy()
    boxes = np.stack([BOX, np.full((8, 3), np.nan)])
    scene = Scene().add_cloud(street).add_boxes(boxes, names=["a", "b"])
    assert len(scene.parts[0].xyz) == len(street) - 1
    assert [part.text for part in scene.parts if isinstance(part, Label)] == ["a"]
    np.testing.assert_array_equal(street, before)


@pytest.mark.parametrize("boxes", [BOX, np.zeros((2, 4, 3)), "boxes"])
def test_boxes_of_another_shape_are_refused(boxes):
    with pytest.raises(ValueError, match=r"\(N, 8, 3\)"):
        Scene().add_boxes(boxes)


def test_names_must_match_the_boxes():
    with pytest.raises(ValueError, match="one name per box"):
        Scene().add_boxes(BOX[None], names=["a", "b"])


# Pictures ------------------------------------------------------------------------------------


@pytest.mark.parametrize("camera", CAMERAS)
def test_a_point_is_drawn_at_its_projected_position(renderer, camera):
    place = np.array([[2.0, 1.0, -1.0]])
    scene = Scene().add_cloud(place, colour="#FF0000", size=5).only("data_points")
    image = scene.picture(camera, size=(320, 180), renderer=renderer).astype(int)
    red = (image[..., 0] > 150) & (image[..., 1] < 110) & (np.arange(180)[:, None] > 30)
    down, across = np.nonzero(red)
    known = CAMERAS[camera]
    expected = known.to_pixels(known.to_camera(place), (320, 180))[0]
    np.testing.assert_allclose((across.mean() + 0.5, down.mean() + 0.5), expected, atol=1.6)


def test_a_scene_with_all_layers_is_drawn_by_every_camera(renderer, street):
    scene = everything(street)
    pictures = [scene.picture(name, size=SIZE, renderer=renderer) for name in CAMERAS]
    for image in pictures:
        assert image.shape == (136, 240, 3) and image.dtype == np.uint8
        assert 0.05 < (image < 250).any(axis=-1).mean() < 1
    assert not np.array_equal(pictures[0], pictures[1])


def test_every_layer_changes_the_picture(renderer, street):
    scene = everything(street)
    for name in LAYERS:
        image = scene.only(name).picture("XY", size=SIZE, renderer=renderer)
        assert (image[50:] < 240).any(), name


@pytest.mark.parametrize("rows", [0, 1])
def test_an_empty_scene_and_tiny_clouds_are_drawn(renderer, street, rows):
    cloud = street[:rows, :3]
    scene = Scene().add_cloud(cloud).add_clusters(cloud, np.ones(rows, int)).add_rays(cloud)
    scene.add_boxes(np.empty((0, 8, 3))).add_cars([]).add_plane(cloud, (0, 0, 1, 0))
    scene.add_kd_tree(None)
    assert scene.picture(size=SIZE, renderer=renderer).shape == (136, 240, 3)
    assert Scene().picture(size=SIZE, renderer=renderer).min() == 255


def test_both_renderers_draw_the_same_picture(street):
    if opengl.problem():
        pytest.skip(opengl.problem())
    scene = Scene().add_cloud(street, size=4).only("data_points")
    first, second = (scene.picture("XY", size=SIZE, renderer=name) < 200 for name in RENDERERS)
    overlap = (first & second).any(-1).sum() / (first | second).any(-1).sum()
    assert overlap > 0.8


def test_a_full_scan_is_drawn_in_seconds(renderer):
    cloud = np.random.default_rng(0).normal(size=(120_000, 4)) * (20, 20, 1, 1)
    start = time.perf_counter()
    Scene().add_cloud(cloud).picture("XY", renderer=renderer)
    assert time.perf_counter() - start < PATIENCE  # usually less than one second


def test_scenes_are_drawn_into_given_axes(street):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("agg")
    import matplotlib.pyplot as plt

    _, (left, right) = plt.subplots(1, 2)
    assert everything(street).draw("TopDown", axes=left) is left
    assert left.collections and not right.collections
    plt.close("all")


def test_eye_dome_lighting_darkens_points_behind_an_edge_and_not_the_background():
    image = np.full((9, 9, 3), 200, np.uint8)
    depth = np.full((9, 9), np.inf)
    depth[:, 2:5], depth[:, 5:7] = 10.0, 20.0
    lit = eye_dome(image, depth)
    assert (lit[4, 5] < 150).all()  # darker just behind the edge of the near wall
    assert (lit[4, [2, 3, 4, 7, 8, 0]] == 200).all()  # wall and background stay bright


# Output -------------------------------------------------------------------------------


def test_pictures_and_views_are_saved_by_suffix(tmp_path, street):
    scene = everything(street)
    for suffix in (".png", ".jpg", ".webp"):
        path = scene.save(tmp_path / f"scene{suffix}", "FPS", size=SIZE)
        assert Image.open(path).size == SIZE
    assert scene.save(tmp_path / "scene.html").read_text("utf-8").startswith("<!doctype html>")
    with pytest.raises(ValueError, match=".html"):
        scene.save(tmp_path / "scene.pdf")


def test_a_saved_picture_has_a_white_background(tmp_path, street):
    path = Scene().add_cloud(street[:50]).save(tmp_path / "scene.png", size=SIZE)
    assert (np.asarray(Image.open(path).convert("RGB"))[60, :3] == 255).all()


def test_an_impossible_size_of_a_picture_is_refused():
    for size in ((0, 100), (100, 90_000)):
        with pytest.raises(ValueError, match="pixels wide and high"):
            Scene().picture(size=size)


def test_the_notebook_gets_an_image_with_a_description(street):
    scene = Scene('A "quoted" street').add_cloud(street).add_boxes(BOX[None])
    bundle = scene._repr_mimebundle_()
    assert bundle["text/html"].startswith('<img src="data:image/png;base64,')
    assert "A &quot;quoted&quot; street" in bundle["text/html"]
    assert "3,000 data points" in bundle["text/plain"] and "1 boxes" in bundle["text/plain"]
    assert Scene(alt="Mine").add_cloud(street).describe() == "Mine"


def test_show_displays_in_a_notebook(monkeypatch, street):
    shown = []
    monkeypatch.setattr(output, "in_notebook", lambda: True)
    monkeypatch.setattr("IPython.display.display", lambda data, raw: shown.append(data))
    scene = Scene("Street").add_cloud(street)
    assert scene.show("Side", size=SIZE, alt="From the side") is None
    scene.show(interactive=True, size=SIZE)
    assert 'alt="From the side"' in shown[0]["text/html"]
    assert shown[1]["text/html"].startswith("<iframe srcdoc=")


def test_show_names_an_alternative_without_notebook_and_screen(monkeypatch, capsys, street):
    monkeypatch.setattr(opengl, "has_screen", lambda: False)
    Scene().add_cloud(street).show()
    assert 'scene.save("scene.png")' in capsys.readouterr().out


# The interactive view ------------------------------------------------------------------------


def content_of(page):
    found = re.search(r'<script type="application/json" id="scene">(.*?)</script>', page, re.S)
    return json.loads(found[1])


def test_the_view_has_at_most_20_000_points_and_half_a_megabyte(street):
    cloud = np.random.default_rng(0).uniform(-60, 60, (120_000, 3))
    page = viewer.page(Scene().add_cloud(cloud).add_obstacles(street), CAMERAS["XY"], "")
    content = content_of(page)
    colours = [base64.b64decode(part["colours"]) for part in content["points"]]
    assert sum(map(len, colours)) / 3 <= viewer.MAX_POINTS
    assert "16% of 123,000 points shown" in content["note"]
    assert len(page) < 500_000


def test_noise_has_smaller_dots_than_clusters_in_the_view(street):
    labels = np.ones(len(street), int)
    labels[:9] = 0
    scene = Scene().add_clusters(street, labels)
    clusters, noise = content_of(viewer.page(scene, CAMERAS["XY"], ""))["points"]
    assert noise["size"] < clusters["size"]


def test_the_view_keeps_positions_to_the_millimetre(street):
    part = content_of(viewer.page(Scene().add_cloud(street), CAMERAS["XY"], ""))["points"][0]
    steps = np.frombuffer(base64.b64decode(part["xyz"]), "<u2").reshape(-1, 3)
    np.testing.assert_allclose(part["low"] + steps * part["step"], street[:, :3], atol=1e-3)


def test_the_view_needs_no_other_file_and_accepts_any_title(street):
    title = "</script><script>alert(1)</script>"
    page = viewer.page(Scene(title).add_cloud(street), Camera((9, 9, 9), (0, 0, 0)), '"&<')
    assert page.count("</script>") == 2  # one for the data and one for the program
    assert "http" not in page and "src=" not in page
    content = content_of(page)
    assert content["title"] == title and content["alt"] == '"&<'
    assert content["camera"] == viewer.OWN and viewer.OWN in content["cameras"]


def test_hidden_layers_stay_hidden_in_the_view(street):
    scene = everything(street).switch(clusters=False)
    layers = {
        layer["name"]: layer
        for layer in content_of(viewer.page(scene, CAMERAS["XY"], ""))["layers"]
    }
    assert set(layers) == set(LAYERS)
    assert not layers["clusters"]["on"] and layers["boxes"]["on"]


def test_a_picture_replaces_the_view_where_scripts_do_not_run(street):
    scene = Scene().add_cloud(street)
    bundle = output.bundle_of(scene, "XY", True, SIZE, None, "A street.")
    outside = bundle["text/html"].split("</iframe>")[1]
    assert '<img src="data:image/png' in outside and "trust the notebook" in outside
    assert "hidden = true" in bundle["text/html"]


# Machines without OpenGL ------------------------------------------------------------------------


def run(program, **environment):
    return subprocess.run(
        [sys.executable, "-c", program], cwd=PROJECT, capture_output=True, text=True, timeout=600,
        env=os.environ | environment,
    )  # fmt: skip


DRAW = """
import sys
{before}
import numpy as np
from utils.scene3d import Scene
scene = Scene().add_cloud(np.ones((9, 3)))
print(scene.picture(size=(64, 64)).shape, scene.picture("FPS", size=(64, 64)).shape)
{after}
"""


def test_importing_utils_loads_no_heavy_package():
    heavy = "[name for name in sys.modules if name.split('.')[0] in {}]"
    program = (
        f"import sys, utils; print({heavy.format(('pyvista', 'vtkmodules', 'matplotlib'))}); "
        f"import utils.scene3d; print({heavy.format(('pyvista', 'vtkmodules'))})"
    )
    assert run(program).stdout.split() == ["[]", "[]"]


@pytest.mark.slow
@pytest.mark.parametrize("screen", ["", ":99"])
def test_standard_error_stays_empty_and_the_environment_unchanged(screen):
    if opengl.problem():
        pytest.skip(opengl.problem())
    after = f"import os; print(sorted(set({list(opengl.WITHOUT_SCREEN)}) & set(os.environ)))"
    done = run(DRAW.format(before="", after=after), DISPLAY=screen)
    assert done.stderr == ""
    assert done.stdout.splitlines() == ["(64, 64, 3) (64, 64, 3)", "[]"]


def test_matplotlib_replaces_a_missing_pyvista_and_says_so_once():
    done = run(DRAW.format(before="sys.modules['pyvista'] = None", after=""))
    assert done.stderr == ""
    assert done.stdout.splitlines() == [opengl.NOT_INSTALLED, "(64, 64, 3) (64, 64, 3)"]


@pytest.mark.slow
def test_matplotlib_replaces_a_missing_opengl_without_a_crash():
    before = """
from utils.scene3d import opengl
opengl._window_class_name = lambda: opengl.LAST_RESORT
opengl._has_osmesa = lambda: False
sys.platform = "linux"
"""
    pytest.importorskip("pyvista")
    done = run(DRAW.format(before=before, after="print(opengl.has_screen())"), DISPLAY=":0")
    assert done.stderr == ""
    assert done.stdout.splitlines() == [opengl.NO_OPENGL, "(64, 64, 3) (64, 64, 3)", "False"]


def test_an_unknown_renderer_is_refused():
    with pytest.raises(ValueError, match="pyvista"):
        Scene().picture(renderer="vtk")
