"""What the tests share: the example scenes, the command to compare with, a scene small enough to be rendered often."""

import os
import pathlib
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[3]

SPHERES = """<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="4"/></integrator>
    <sensor type="perspective">
        <float name="fov" value="$fov"/>
        <transform name="to_world"><lookat origin="0, -6, 1" target="0, 0, 0" up="0, 0, 1"/></transform>
        <sampler type="independent"><integer name="sample_count" value="4"/></sampler>
        <film type="hdrfilm"><integer name="width" value="40"/><integer name="height" value="30"/></film>
    </sensor>
    <default name="fov" value="40"/>
    <emitter type="constant" id="sky"><rgb name="radiance" value="0.5, 0.7, 1.0"/></emitter>
    <bsdf type="diffuse" id="clay"><rgb name="reflectance" value="0.5, 0.3, 0.2"/></bsdf>
    <shape type="sphere"><ref id="clay"/></shape>
    <shape type="ply" id="slab"><string name="filename" value="slab.ply"/><ref id="clay"/></shape>
</scene>
""".replace('<default name="fov" value="40"/>', "").replace(
    "<integrator", '<default name="fov" value="40"/>\n    <integrator', 1
)

SLAB = """ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
-4 -4 -1
4 -4 -1
4 4 -1
-4 4 -1
4 0 1 2 3
"""


@pytest.fixture
def scenes():
    """Folder of the example scenes."""
    return ROOT / "render-cpu" / "scenes"


@pytest.fixture
def spheres(tmp_path):
    """A scene file with a mesh beside it."""
    (tmp_path / "slab.ply").write_text(SLAB)
    path = tmp_path / "spheres.xml"
    path.write_text(SPHERES)
    return path


@pytest.fixture
def command(tmp_path):
    """Runs the command `halflight` in a folder of the test and returns that folder."""
    candidates = [
        os.environ.get("HALFLIGHT_COMMAND"),
        ROOT / "target" / "debug" / "halflight",
        ROOT / "target" / "release" / "halflight",
    ]
    program = next((p for p in candidates if p and os.path.exists(p)), None)
    if program is None:
        if os.environ.get("HALFLIGHT_REQUIRE_COMMAND"):
            pytest.fail("the command halflight is not built, and HALFLIGHT_REQUIRE_COMMAND is set")
        pytest.skip("the command halflight is not built (cargo build -p halflight)")

    def run(*arguments):
        subprocess.run([program, "--quiet", *map(str, arguments)], cwd=tmp_path, check=True)
        return tmp_path

    return run
