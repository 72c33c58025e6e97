"""Values and densities of Mitsuba 3's `measured` on synthetic files: writes measured.csv beside itself. Run: python measured.py

Run it until two runs agree: in one run of six, single rows of the isotropic file come out otherwise."""

import os
import tempfile

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
HERE = os.path.dirname(os.path.abspath(__file__))
THETA = np.float32([0, 0.4, 0.9, 1.4])


def nodes(width, height):
    x, y = np.meshgrid(np.linspace(0, 1, width), np.linspace(0, 1, height))
    return x, y


def write(path, phi, relative):
    """The formulas of ../../measured_adaptive.rs as a tensor file."""
    x, y = nodes(7, 5)
    ndf = np.exp(-6 * x * x) * (1 + 0.3 * np.cos(2 * np.pi * y)) + 0.1
    x, y = nodes(6, 4)
    sigma = 0.3 + 0.4 * (1 - x * x) + 0.05 * np.cos(2 * np.pi * y)
    vndf, luminance, rgb = [], [], []
    for p in phi:
        for t in THETA:
            x, y = nodes(9, 8)
            vndf.append(x * (0.2 + np.exp(-8 * (x - 0.3 * np.sin(t)) ** 2) * (1 + 0.5 * np.cos(2 * np.pi * y - p))))
            x, y = nodes(6, 6)
            value = 0.3 + 0.5 * x * (1 - y) + 0.2 * np.sin(t) + 0.05 * np.cos(p)
            luminance.append(value)
            rgb.append([scale * value + slope * y for scale, slope in ((0.3, 0.02), (0.2, 0.0), (0.1, 0.05))])
    shape = (len(phi), len(THETA))
    f = lambda a, *s: np.float32(a).reshape(*shape, *s)
    mi.tensor_io.write(path, description="synthetic", phi_i=np.float32(phi), theta_i=THETA, ndf=np.float32(ndf),
                       sigma=np.float32(sigma), vndf=f(vndf, 8, 9), luminance=f(luminance, 6, 6), rgb=f(rgb, 3, 6, 6),
                       jacobian=np.uint8([relative]))


CASES = [([0], 1), ([-np.pi, -2, -1, 0], 1), ([-np.pi, -2.4, -np.pi / 2], 0), ([-np.pi, -1, 1, np.pi], 1)]

if __name__ == "__main__":
    lines = []
    for number, (phi, relative) in enumerate(CASES):
        path = os.path.join(tempfile.mkdtemp(), "synthetic.bsdf")
        write(path, phi, relative)
        bsdf = mi.load_dict({"type": "measured", "filename": path})
        random = np.random.default_rng(number)
        si = mi.SurfaceInteraction3f()
        context = mi.BSDFContext()
        n = 0
        while n < 60:
            wi, wo = random.normal(size=3), random.normal(size=3)
            wi[2], wo[2] = abs(wi[2]), abs(wo[2])
            wi, wo = np.float32(wi / np.linalg.norm(wi)), np.float32(wo / np.linalg.norm(wo))
            if min(wi[2], wo[2]) < 0.05:
                continue
            si.wi = mi.Vector3f(*wi.tolist())
            out = mi.Vector3f(*wo.tolist())
            f = bsdf.eval(context, si, out)
            lines.append([number, *wi, *wo, *np.array(f), bsdf.pdf(context, si, out)])
            n += 1
    with open(os.path.join(HERE, "measured.csv"), "w") as file:
        file.write("# python measured.py, Mitsuba %s\nfile,wi(3),wo(3),f_cos(3),pdf\n" % mi.__version__)
        for line in lines:
            file.write(",".join("%.9g" % v for v in line) + "\n")
