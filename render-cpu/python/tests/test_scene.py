"""Scenes: what they say, their parameters, their errors."""

import numpy as np
import pytest

import halflight


def test_a_scene_says_what_it_holds(spheres):
    scene = halflight.load(spheres)
    assert scene.size == (40, 30)
    assert scene.triangles == 2
    assert scene.plugins["shape sphere"] == 1 and scene.plugins["bsdf diffuse"] == 1
    assert scene.warnings == []
    assert (scene.integrator, scene.sampler, scene.seed) == ("path", "independent", 0)
    assert halflight.load(spheres, size=(8, 6)).size == (8, 6)
    assert halflight.load(spheres, width=20).size == (20, 15)
    assert halflight.load(spheres, crop=(3, 2, 10, 7)).size == (10, 7)


def test_keywords_are_the_parameters_of_the_file(spheres):
    scene = halflight.load(spheres, fov=20)
    assert scene.parameters["sensor.fov"] == 20
    assert halflight.load(spheres, defines={"fov": 25.5}).parameters["sensor.fov"] == 25.5
    with pytest.raises(ValueError, match="fow"):
        halflight.load(spheres, fow=20)


def test_parameters_are_listed_with_their_values(spheres):
    parameters = halflight.load(spheres).parameters
    assert parameters["sky.radiance"] == pytest.approx((0.5, 0.7, 1.0))
    assert parameters["clay.reflectance"] == pytest.approx((0.5, 0.3, 0.2))
    assert parameters["integrator.max_depth"] == 4
    assert parameters["slab.filename"] == "slab.ply"
    assert parameters["sensor.to_world"].shape == (4, 4)
    np.testing.assert_allclose(parameters["sensor.to_world"][:, 3], [0, -6, 1, 1])
    assert len(parameters) == len(list(parameters)) == len(dict(parameters))


def edited(path, old, new):
    text = path.read_text()
    assert text.count(old) == 1
    other = path.with_name("edited.xml")
    other.write_text(text.replace(old, new))
    return halflight.load(other)


@pytest.mark.parametrize(
    ("name", "value", "old", "new"),
    [
        ("clay.reflectance", (0.1, 0.6, 0.2), 'value="0.5, 0.3, 0.2"', 'value="0.1, 0.6, 0.2"'),
        ("clay.reflectance", 0.25, 'value="0.5, 0.3, 0.2"', 'value="0.25, 0.25, 0.25"'),
        ("sky.radiance", (2, 2, 1), 'value="0.5, 0.7, 1.0"', 'value="2, 2, 1"'),
        ("sensor.fov", 25.0, 'value="$fov"', 'value="25"'),
        ("integrator.max_depth", 2, 'value="4"/></integrator>', 'value="2"/></integrator>'),
        (
            "sensor.to_world",
            [[-1, 0, 0, 0], [0, 0, 1, -7], [0, 1, 0, 0], [0, 0, 0, 1]],
            '<lookat origin="0, -6, 1" target="0, 0, 0" up="0, 0, 1"/>',
            '<matrix value="-1 0 0 0  0 0 1 -7  0 1 0 0  0 0 0 1"/>',
        ),
    ],
)
def test_a_changed_parameter_is_an_edited_file_to_the_bit(spheres, name, value, old, new):
    scene = halflight.load(spheres)
    before = scene.render(spp=2).radiance
    scene.parameters[name] = value
    # Files are not read again.
    mesh = spheres.with_name("slab.ply")
    contents = mesh.read_text()
    mesh.write_text("not a mesh any more")
    after = scene.render(spp=2).radiance
    mesh.write_text(contents)
    np.testing.assert_array_equal(after, edited(spheres, old, new).render(spp=2).radiance)
    assert np.any(after != before)


def test_several_parameters_change_together_or_not_at_all(spheres):
    scene = halflight.load(spheres)
    with pytest.raises(TypeError, match=r"clay\.reflectance"):
        scene.parameters.update({"sensor.fov": 20.0, "clay.reflectance": "red"})
    assert scene.parameters["sensor.fov"] == 40
    scene.parameters.update({"sensor.fov": 20.0, "clay.reflectance": 0.5})
    assert scene.parameters["sensor.fov"] == 20
    assert scene.parameters["clay.reflectance"] == (0.5, 0.5, 0.5)


def test_a_name_that_is_not_there_is_a_key_error(spheres):
    parameters = halflight.load(spheres).parameters
    with pytest.raises(KeyError, match=r"did you mean .*clay\.reflectance"):
        parameters["clay.reflectanse"] = 0.5
    with pytest.raises(KeyError):
        parameters["clay.reflectanse"]
    for value in ("wide", float("nan"), None, [1, 2]):
        with pytest.raises(TypeError):
            parameters["sensor.fov"] = value


def test_a_value_that_the_plugin_does_not_take_is_an_error_of_the_scene(spheres):
    scene = halflight.load(spheres)
    scene.parameters["sensor.fov"] = 400.0
    with pytest.raises(halflight.SceneError) as caught:
        scene.render(spp=1)
    assert caught.value.line == 5 and caught.value.file == spheres


def test_errors_name_file_line_and_element(spheres):
    spheres.write_text(spheres.read_text().replace('"0.5, 0.3, 0.2"', '"red"'))
    with pytest.raises(halflight.SceneError) as caught:
        halflight.load(spheres)
    error = caught.value
    assert isinstance(error, ValueError)
    assert error.file == spheres and error.line == 12 and error.column > 1
    assert error.element == '<rgb name="reflectance">'
    assert str(error).startswith(f"{spheres}:12:")


def test_a_missing_file_is_an_error_of_the_scene_without_a_line(tmp_path):
    with pytest.raises(halflight.SceneError) as caught:
        halflight.load(tmp_path / "nothing.xml")
    assert caught.value.line is None and caught.value.file == tmp_path / "nothing.xml"


def test_warnings_are_listed_or_errors_when_strict(spheres):
    spheres.write_text(spheres.read_text().replace('type="diffuse"', 'type="diffuse" ').replace(
        "<shape type=\"sphere\">", '<shape type="sphere"><float name="raduis" value="2"/>'))
    warnings = halflight.load(spheres).warnings
    assert len(warnings) == 1 and "raduis" in warnings[0] and "spheres.xml:13:" in warnings[0]
    with pytest.raises(halflight.SceneError, match="raduis"):
        halflight.load(spheres, strict=True)
