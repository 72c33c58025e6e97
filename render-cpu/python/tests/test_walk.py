"""Walks on the specular manifold, against chains that are known."""

import numpy as np
import pytest

import halflight
from halflight import WalkStatus

SCENE = """<scene version="3.0.0">
    <sensor type="perspective"><float name="fov" value="40"/></sensor>
    <emitter type="constant"/>
    <bsdf type="dielectric" id="glass"><float name="int_ior" value="1.5"/></bsdf>
    <bsdf type="conductor" id="mirror"/>
    {shapes}
</scene>
"""

FLOOR = """<shape type="rectangle"><transform name="to_world"><scale value="10"/></transform>
    <ref id="mirror"/></shape>"""
BALL = """<shape type="sphere"><ref id="mirror"/></shape>"""
SLAB = """<shape type="cube"><transform name="to_world"><scale x="10" y="10" z="0.5"/></transform>
    <ref id="glass"/></shape>"""


@pytest.fixture
def scene(tmp_path):
    def load(shapes):
        path = tmp_path / "scene.xml"
        path.write_text(SCENE.format(shapes=shapes))
        return halflight.load(path)

    return load


def test_a_plane_mirror_reflects_where_the_image_of_the_end_is_seen(scene):
    rng = np.random.default_rng(2)
    start = rng.uniform([-2, -2, 0.5], [2, 2, 2], size=(500, 3))
    end = rng.uniform([-2, -2, 0.5], [2, 2, 2], size=(500, 3))
    guess = np.zeros((500, 1, 3))
    walks = scene(FLOOR).walk(start, guess, end, "R")
    assert walks.converged.all()
    share = start[:, 2:] / (start[:, 2:] + end[:, 2:])
    expected = start + share * (end - start)
    expected[:, 2] = 0
    np.testing.assert_allclose(walks.positions[:, 0], expected, atol=2e-3)
    assert np.abs(walks.half_vectors).max() < 1e-3
    # Without curvature the term is that of the unfolded segment, 1 / distance^2: both ends are points, without a cosine.
    image = end * [1, 1, -1]
    distance = np.linalg.norm(image - start, axis=-1)
    np.testing.assert_allclose(walks.geometry_term, distance**-2, rtol=5e-3)


def test_on_a_ball_the_normal_is_the_half_vector(scene):
    rng = np.random.default_rng(3)
    start, end = rng.uniform([-2, -3, -1], [2, -2, 1], size=(2, 300, 3))
    walks = scene(BALL).walk(start, [[[0, 0, 0]]], end, "R")
    assert walks.converged.mean() > 0.95
    x = walks.positions[walks.converged, 0].astype(np.float64)
    np.testing.assert_allclose(np.linalg.norm(x, axis=-1), 1, atol=1e-4)
    i, o = start[walks.converged] - x, end[walks.converged] - x
    h = i / np.linalg.norm(i, axis=-1, keepdims=True) + o / np.linalg.norm(o, axis=-1, keepdims=True)
    sine = np.linalg.norm(np.cross(h, x), axis=-1) / np.linalg.norm(h, axis=-1)
    assert sine.max() < 1e-3


def test_through_a_slab_light_is_displaced_as_snell_has_it(scene):
    start, end = np.array([0.0, 0.3, 3.0]), np.array([1.5, 0.0, -2.0])
    walks = scene(SLAB).walk(start, [[0.5, 0, 0.5], [0.7, 0, -0.5]], end, "TT")
    assert walks.status == WalkStatus.CONVERGED and walks.status.shape == ()
    x, y = walks.positions.astype(np.float64)
    assert x[2] == pytest.approx(0.5, abs=1e-4) and y[2] == pytest.approx(-0.5, abs=1e-4)
    sines = [np.linalg.norm(d[:2]) / np.linalg.norm(d) for d in (x - start, y - x, end - y)]
    assert sines[0] == pytest.approx(1.5 * sines[1], abs=1e-3)
    assert sines[0] == pytest.approx(sines[2], abs=1e-3)


def test_half_vectors_other_than_the_normal_are_reached(scene):
    wanted = np.array([0.1, -0.2])
    walks = scene(FLOOR).walk([0, 0, 1], [[0, 0, 0]], [1, 0.5, 1], "R", half_vectors=[wanted])
    assert walks.converged
    np.testing.assert_allclose(walks.half_vectors[0], wanted, atol=1e-3)


def test_chains_that_cannot_begin_say_so(scene):
    plane = scene(FLOOR)
    assert plane.walk([0, 0, 1], [[0, 0, 5]], [1, 0, 1], "R").status == WalkStatus.NO_START
    assert plane.walk([0, 0, 1], [[0, 0, 0]], [1, 0, 1], "T").status == WalkStatus.NO_START
    for events, via in (("X", [[0, 0, 0]]), ("", [[0, 0, 0]]), ("RR", [[0, 0, 0]]), ("R" * 9, np.zeros((9, 3)))):
        with pytest.raises(ValueError):
            plane.walk([0, 0, 1], via, [1, 0, 1], events)
