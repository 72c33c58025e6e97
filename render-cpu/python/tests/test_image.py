"""Images: files, arrays, comparisons."""

import numpy as np
import pytest

import halflight


def test_files_hold_all_layers(spheres, tmp_path):
    image = halflight.load(spheres).render(spp=4, layers=["albedo", "depth"])
    image.write(tmp_path / "image.exr")
    read = halflight.read(tmp_path / "image.exr")
    assert set(read.layers) == set(image.layers)
    for layer in image.layers:
        np.testing.assert_array_equal(read[layer], image[layer], err_msg=layer)
    assert read.metadata == image.metadata
    assert "albedo" in read and "normal" not in read
    with pytest.raises(KeyError, match="normal"):
        read["normal"]


def test_files_that_are_none_are_os_errors(tmp_path):
    with pytest.raises(OSError, match="nothing.exr"):
        halflight.read(tmp_path / "nothing.exr")
    (tmp_path / "text.exr").write_text("no image")
    with pytest.raises(OSError, match="text.exr"):
        halflight.read(tmp_path / "text.exr")


def test_numpy_takes_images(spheres):
    image = halflight.load(spheres).render(spp=1)
    assert np.asarray(image) is image.radiance
    assert np.array(image) is not image.radiance
    assert np.asarray(image, dtype=np.float64).dtype == np.float64
    assert np.mean(image) == image.radiance.mean()


def test_equal_images_differ_in_nothing(spheres):
    image = halflight.load(spheres).render(spp=4)
    comparison = halflight.compare(image, image)
    assert comparison["mse"] == 0 and comparison["flip"] == 0
    assert comparison.passes and comparison["z-test"] == 0
    assert np.all(comparison.error_map() == 0)


def test_seeds_agree_and_scenes_do_not(spheres):
    scene = halflight.load(spheres)
    a, b = scene.render(spp=64, seed=1), scene.render(spp=64, seed=2)
    same = halflight.compare(a, b)
    assert same.passes and abs(same.mean_z) < 0.2
    scene.parameters["clay.reflectance"] = 0.45
    other = halflight.compare(scene.render(spp=64, seed=2), b)
    assert not other.passes and other["z-test"] > 1


def test_metrics_are_those_of_their_definitions():
    rng = np.random.default_rng(7)
    a, b = rng.random((2, 24, 32, 3), dtype=np.float32)
    comparison = halflight.compare(a, b)
    assert comparison["mse"] == pytest.approx(np.mean((a.astype(float) - b) ** 2), rel=1e-6)
    relative = np.mean(np.abs(a.astype(float) - b) / (b + 0.01), axis=-1)
    np.testing.assert_allclose(comparison.error_map("relative"), relative, rtol=1e-5)
    assert comparison.passes is None and comparison.mean_z is None
    with pytest.raises(KeyError, match="variance"):
        comparison["z-test"]
    with pytest.raises(ValueError, match="known"):
        comparison["no such metric"]
    with pytest.raises(ValueError, match="no error map"):
        comparison.error_map("no such map")


def test_paths_images_and_arrays_compare_alike(spheres, tmp_path):
    image = halflight.load(spheres).render(spp=4)
    image.write(tmp_path / "image.exr")
    other = np.zeros_like(image.radiance)
    values = [halflight.compare(x, other)["mse"] for x in (image, tmp_path / "image.exr", image.radiance)]
    assert values[0] == values[1] == values[2] > 0


@pytest.mark.parametrize("other", [np.zeros((3, 4)), np.zeros((2, 2, 3)), "nothing.exr"])
def test_what_cannot_be_compared_is_refused(other):
    with pytest.raises((ValueError, OSError)):
        halflight.compare(np.ones((4, 4, 3)), other)
