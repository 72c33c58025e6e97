"""BSDFs over arrays: known values, samples against densities, bounds, errors."""

import numpy as np
import pytest

import halflight
from halflight import Bsdf, Event, regularize


def sphere(n, seed=1):
    """Uniform directions and the density of each."""
    v = np.random.default_rng(seed).normal(size=(n, 3))
    return v / np.linalg.norm(v, axis=-1, keepdims=True), 1 / (4 * np.pi)


def test_lambert_has_its_value_everywhere():
    bsdf = Bsdf("diffuse", reflectance=[0.8, 0.4, 0.2])
    wo = [[0, 0, 1], [0, 0.6, 0.8], [0, 0.6, -0.8]]
    expected = np.array([[0.8, 0.4, 0.2], [0.8, 0.4, 0.2], [0, 0, 0]]) / np.pi
    np.testing.assert_allclose(bsdf.eval([0, 0, 1], wo), expected, rtol=1e-6)
    np.testing.assert_allclose(bsdf.pdf([0, 0, 1], wo), np.array([1, 0.8, 0]) / np.pi, rtol=1e-6)


def test_shapes_broadcast():
    bsdf = Bsdf("roughconductor", material="Au", alpha=0.3)
    wi = np.array([[0, 0, 1], [0, 0.6, 0.8]])
    wo = np.array([[[0, 0, 1]], [[0.6, 0, 0.8]], [[0, -0.6, 0.8]]])
    table = bsdf.eval(wi, wo)
    assert table.shape == (3, 2, 3) and table.dtype == np.float32
    np.testing.assert_array_equal(table[2, 1], bsdf.eval(wi[1], wo[2, 0]))
    assert bsdf.pdf(wi[0], wo[0, 0]).shape == ()
    with pytest.raises(ValueError, match="wi has the shape"):
        bsdf.eval([0, 1], [0, 0, 1])
    with pytest.raises(ValueError, match="broadcast"):
        bsdf.eval(np.ones((2, 3)), np.ones((5, 3)))


@pytest.mark.parametrize(
    "bsdf",
    [
        Bsdf("roughconductor", material="Au", alpha=0.4),
        Bsdf("roughplastic", alpha=0.3, distribution="ggx"),
        Bsdf("roughdielectric", int_ior=1.5, alpha=0.5),
        Bsdf("blendbsdf", weight=0.3, bsdf={"type": "diffuse"}, bsdf_2={"type": "roughconductor", "alpha": 0.5}),
    ],
    ids=repr,
)
def test_samples_follow_density_and_value(bsdf):
    n = 400_000
    wi = np.array([0.48, 0.36, 0.8])
    u = np.random.default_rng(3).random((n, 3))
    sample = bsdf.sample(wi, u)
    kept = sample.pdf > 0
    value, pdf = bsdf.eval_cosine_pdf(wi, sample.wo[kept])
    np.testing.assert_allclose(pdf, sample.pdf[kept], rtol=2e-3)
    np.testing.assert_allclose(value / pdf[:, None], sample.weight[kept], rtol=2e-3, atol=1e-5)
    # The same integral with directions of another density.
    wo, density = sphere(n)
    other = bsdf.eval_cosine_pdf(wi, wo)[0][:, 0] / density
    mean = np.where(kept, sample.weight[:, 0], 0)
    deviation = np.hypot(other.std(), mean.std()) / np.sqrt(n)
    assert abs(other.mean() - mean.mean()) < 5 * deviation
    # Both reflect, and the dielectric transmits too.
    assert np.any(sample.event & Event.REFLECTION)
    assert np.any(sample.event & Event.TRANSMISSION) == ("roughdielectric" in repr(bsdf))


def test_discrete_directions_have_probabilities_and_no_values():
    glass = Bsdf("dielectric", int_ior=1.5, ext_ior=1.0)
    sample = glass.sample([0, 0.6, 0.8], [[0.0, 0.5, 0.5], [0.999, 0.5, 0.5]])
    assert np.all(sample.event & Event.DELTA)
    assert np.all(glass.eval([0, 0.6, 0.8], sample.wo) == 0)
    np.testing.assert_allclose(sample.pdf.sum(), 1, rtol=1e-5)
    np.testing.assert_allclose(sorted(sample.eta), [1, 1.5], rtol=1e-6)
    transmitted = sample.wo[np.argmax(sample.eta)]
    np.testing.assert_allclose(transmitted[1], -0.6 / 1.5, rtol=1e-5)
    # Radiance is scaled by 1 / eta^2, importance is not.
    scaled = sample.weight[np.argmax(sample.eta), 0]
    unscaled = Bsdf("dielectric", int_ior=1.5, ext_ior=1.0, importance=True).sample([0, 0.6, 0.8], [0.999, 0.5, 0.5])
    np.testing.assert_allclose(unscaled.weight[0] / scaled, 1.5**2, rtol=1e-5)


def test_local_roughness_of_beckmann_is_alpha():
    bsdf = Bsdf("roughconductor", distribution="beckmann", alpha=0.25, material="none")
    wo = np.array([[0, 0.1, 1], [0.3, 0, 1], [0.5, 0.5, 1.0]])
    wo /= np.linalg.norm(wo, axis=-1, keepdims=True)
    np.testing.assert_allclose(bsdf.local_roughness([0, 0, 1], wo), 0.25, rtol=1e-4)
    assert Bsdf("diffuse").local_roughness([0, 0, 1], [0, 0, 1]) == 1000


def test_regularised_values_stay_below_tau():
    mirror = Bsdf("conductor", material="none")
    wi, _ = sphere(100_000, seed=5)
    wi[:, 2] = np.abs(wi[:, 2])
    wo = wi * [-1, -1, 1]
    for tau in (1.0, 30.0, 1e3):
        value, pdf = mirror.regularized(wi, wo, tau)
        f = value / np.maximum(wo[:, 2:], 1e-6)
        assert f.max() <= tau * 1.001 and f.max() > 0.1 * tau
        assert np.all(pdf > 0)
    assert mirror.bound() == regularize.TAU_MAX
    rough = Bsdf("roughconductor", material="none", alpha=0.3, distribution="ggx")
    np.testing.assert_allclose(rough.bound(), regularize.reflection_bound(0.3), rtol=1e-5)


def test_bsdfs_are_found_by_name_and_in_files(scenes):
    gold = Bsdf.find("Au")
    np.testing.assert_array_equal(
        gold.eval([0, 0, 1], [0, 0.6, 0.8]), Bsdf("roughconductor", material="Au").eval([0, 0, 1], [0, 0.6, 0.8])
    )
    ball = Bsdf.find(scenes / "material-ball.xml", id="material")
    assert np.any(ball.eval([0, 0, 1], [0, 0, 1]) > 0)
    with pytest.raises(ValueError, match="did you mean"):
        Bsdf.find("Auu")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((("no such plugin",), {}), "no such plugin"),
        ((("diffuse",), {"reflektance": 0.5}), "reflektance"),
        ((("roughconductor",), {"alpha": "rough"}), "alpha"),
        ((("diffuse",), {"reflectance": [1, 2]}), "reflectance"),
        ((("coating",), {"bsdf": {"reflectance": 0.5}}), '"type"'),
    ],
)
def test_what_plugins_do_not_take_is_an_error(arguments, message):
    positional, named = arguments
    with pytest.raises(ValueError, match=message):
        Bsdf(*positional, **named)


def test_textures_are_looked_up_at_uv():
    def color(uv):
        board = {"type": "checkerboard", "color0": [0.5, 0.5, 0.5], "color1": [0.1, 0.1, 0.1]}
        return Bsdf("diffuse", reflectance=board, uv=uv).eval([0, 0, 1], [0, 0, 1])[0] * np.pi

    assert sorted([color((0.25, 0.25)), color((0.75, 0.25))]) == pytest.approx([0.1, 0.5], rel=1e-5)


def test_errors_of_bsdfs_in_scenes_are_those_of_scenes():
    with pytest.raises(halflight.SceneError) as caught:
        Bsdf("roughdielectric", int_ior=-1.0)
    assert caught.value.element is not None
