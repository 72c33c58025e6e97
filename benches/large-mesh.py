#!/usr/bin/env python3
"""Writes the large mesh of the measurements, big.ply, and a scene of it, big.xml, into a folder.

    python3 benches/large-mesh.py [--side 708] FOLDER

A bumpy plane of 999,698 triangles (708 vertices on a side, or as many as --side says) without vertex normals, of bumps as wide as the plane down to a dozen triangles, grey,
under a constant sky; 19 MB.
"""

import argparse
import math
import pathlib
import struct

HEADER = """ply
format binary_little_endian 1.0
element vertex {vertices}
property float x
property float y
property float z
element face {faces}
property list uchar int vertex_indices
end_header
"""
SCENE = """<scene version="3.0.0">
    <integrator type="path"/>
    <sensor type="perspective">
        <float name="fov" value="40"/>
        <transform name="to_world"><lookat origin="0, -2.4, 1.4" target="0, 0, 0" up="0, 0, 1"/></transform>
        <sampler type="independent"><integer name="sample_count" value="64"/></sampler>
        <film type="hdrfilm"><integer name="width" value="400"/><integer name="height" value="300"/></film>
    </sensor>
    <emitter type="constant"><rgb name="radiance" value="1"/></emitter>
    <shape type="ply">
        <string name="filename" value="big.ply"/>
        <bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf>
    </shape>
</scene>
"""


def height(x, y):
    """The height of the plane over a point of [-1, 1]^2."""
    wide = 0.05 * math.sin(13 * x) * math.cos(11 * y)
    middle = 0.02 * math.sin(57 * x + 3) * math.cos(49 * y)
    return wide + middle + 0.005 * math.sin(201 * x) * math.sin(190 * y)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--side", type=int, default=708)
    options = parser.parse_args()
    folder, side = options.folder, options.side
    folder.mkdir(parents=True, exist_ok=True)
    at = [2 * i / (side - 1) - 1 for i in range(side)]
    vertices = bytearray()
    for x in at:
        for y in at:
            vertices += struct.pack("<3f", x, y, height(x, y))
    cells = [i * side + j for i in range(side - 1) for j in range(side - 1)]
    faces = bytearray()
    for a in cells:
        faces += struct.pack("<B3i", 3, a, a + side, a + 1)
    for a in cells:
        faces += struct.pack("<B3i", 3, a + 1, a + side, a + side + 1)
    header = HEADER.format(vertices=side * side, faces=2 * len(cells))
    (folder / "big.ply").write_bytes(header.encode() + vertices + faces)
    (folder / "big.xml").write_text(SCENE)


if __name__ == "__main__":
    main()
