"""Numbers from Mitsuba 3 (3.9.1, scalar_rgb) for cameras, emitters and filters: writes cameras.csv, emitters.csv,
environment.csv and filters.csv beside itself. Run: python light.py"""

import os

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
T = mi.ScalarTransform4f
HERE = os.path.dirname(os.path.abspath(__file__))
LOOK = T().look_at(origin=[1, 2, 3], target=[4, 1, -2], up=[0, 1, 0.2])


def rows(transform):
    return list(np.array(transform.matrix)[:3].flatten())


def write(name, header, lines):
    with open(os.path.join(HERE, name), "w") as f:
        f.write("# python light.py, Mitsuba %s\n" % mi.__version__)
        f.write(header + "\n")
        for line in lines:
            f.write(",".join("%.9g" % x for x in line) + "\n")


def cameras():
    axes = ["x", "y", "diagonal", "smaller", "larger"]
    full = (0, 0, None, None)
    cases = []
    for axis in range(5):
        for size in ((40, 30), (30, 40)):
            cases.append(("perspective", 45.0, axis, size, full, (0, 0), 0, 0, (0.01, 1e4), LOOK))
    crop = (10, 5, 20, 15)
    cases.append(("perspective", 60.0, 0, (40, 30), crop, (0, 0), 0, 0, (0.5, 20), LOOK))
    cases.append(("perspective", 60.0, 1, (40, 30), full, (0.1, -0.2), 0, 0, (0.5, 20), LOOK))
    cases.append(("perspective", 60.0, 1, (40, 30), crop, (0.1, -0.2), 0, 0, (0.5, 20), LOOK))
    cases.append(("thinlens", 45.0, 0, (40, 30), full, (0, 0), 0.2, 3.0, (0.01, 1e4), LOOK))
    cases.append(("thinlens", 45.0, 0, (40, 30), crop, (0, 0), 0.5, 7.0, (0.5, 20), LOOK))
    cases.append(("orthographic", 45.0, 0, (40, 30), full, (0, 0), 0, 0, (0.01, 1e4), LOOK @ T().scale([2, 3, 1])))
    cases.append(("orthographic", 45.0, 0, (30, 40), crop, (0, 0), 0, 0, (0.5, 20), LOOK @ T().scale([2, 2, 4])))
    lines = []
    for kind, fov, axis, size, window, offset, aperture, focus, clip, to_world in cases:
        window = (window[0], window[1], window[2] or size[0], window[3] or size[1])
        film = {"type": "hdrfilm", "width": size[0], "height": size[1], "rfilter": {"type": "box"},
                "crop_offset_x": window[0], "crop_offset_y": window[1],
                "crop_width": window[2], "crop_height": window[3]}
        d = {"type": kind, "film": film, "to_world": to_world, "near_clip": clip[0], "far_clip": clip[1]}
        if kind != "orthographic":
            d.update(fov=fov, fov_axis=axes[axis])
        if kind == "perspective":
            d.update(principal_point_offset_x=offset[0], principal_point_offset_y=offset[1])
        if kind == "thinlens":
            d.update(aperture_radius=aperture, focus_distance=focus)
        sensor = mi.load_dict(d)
        for p in ((0, 0), (0.2, 0.3), (0.9, 0.6)):
            for u in ((0.3, 0.8), (0.95, 0.1)):
                ray, weight = sensor.sample_ray(0, 0.5, mi.Point2f(*p), mi.Point2f(*u))
                number = {"perspective": 0, "thinlens": 1, "orthographic": 2}[kind]
                lines.append([number, fov, axis, *size, *window, *offset, aperture, focus, *clip, *rows(to_world),
                              *p, *u, *ray.o, *ray.d, ray.maxt])
    write("cameras.csv", "kind,fov,axis,film(2),crop(4),principal_point(2),aperture,focus,clip(2),to_world(12),"
          "sample(2),lens(2),origin(3),direction(3),maxt", lines)


def image(w, h):
    return np.array([[[((7 * i + 5 * j + 3 * c) % 11) / 10 + 0.05 for c in range(3)] for i in range(w)]
                     for j in range(h)], dtype=np.float32)


def emitters():
    to_world = T().look_at(origin=[1, 2, 3], target=[0, 0, 0], up=[0, 1, 0])
    texture = {"type": "bitmap", "bitmap": mi.Bitmap(image(5, 3)), "raw": True, "filter_type": "nearest"}
    color = {"type": "rgb", "value": [1, 2, 3]}
    cases = [
        (1, 0, (0, 0), {"type": "point", "intensity": color, "to_world": to_world}),
        (2, 0, (22.5, 30), {"type": "spot", "intensity": color, "cutoff_angle": 30.0, "to_world": to_world}),
        (2, 1, (10, 50), {"type": "spot", "intensity": color, "cutoff_angle": 50.0, "beam_width": 10.0,
                          "texture": texture, "to_world": to_world}),
        (3, 1, (40, 0), {"type": "projector", "irradiance": texture, "scale": 1.0, "fov": 40.0,
                         "to_world": to_world}),
        (4, 0, (0, 0), {"type": "directional", "irradiance": color, "to_world": to_world}),
    ]
    points = [(0, 0, 0), (0.3, 0.4, 0.9), (0.9, 0.2, 0.7), (1, 1, -1), (0.3, 0.9, 0.4), (1.2, 0.2, 0.7),
              (0.1, -0.3, 0.2), (3, 4, 5), (-1.5, 0.3, 2), (0.2, 2.2, 1.1)]
    lines = []
    for kind, textured, angles, d in cases:
        emitter = mi.load_dict(d)
        for p in points:
            it = mi.SurfaceInteraction3f()
            it.p = mi.Point3f(p)
            ds, weight = emitter.sample_direction(it, mi.Point2f(0.5, 0.5), True)
            lines.append([kind, textured, *angles, *rows(to_world), *p, *ds.d, ds.dist, *weight])
    write("emitters.csv", "kind,textured,angles(2),to_world(12),point(3),direction(3),distance,radiance(3)", lines)


def environment():
    lines = []
    rng = np.random.default_rng(7)
    for w, h, to_world in ((4, 3, T()), (6, 4, T().rotate([0.6, 0, 0.8], 50)), (5, 5, T().scale([-1, 1, 1]))):
        emitter = mi.load_dict({"type": "envmap", "bitmap": mi.Bitmap(image(w, h)), "to_world": to_world,
                                "scale": 2.0})
        for _ in range(40):
            d = rng.normal(size=3)
            d /= np.linalg.norm(d)
            si = mi.SurfaceInteraction3f()
            si.wi = -mi.Vector3f(d)
            si.t = float("inf")
            lines.append([w, h, *rows(to_world), *d, *emitter.eval(si)])
    write("environment.csv", "width,height,to_world(12),direction(3),radiance(3)", lines)


def filters():
    cases = [(0, (0.5, 0, 0), {"type": "box"}), (1, (1, 0, 0), {"type": "tent"}),
             (2, (2, 0.5, 0), {"type": "gaussian"}), (2, (1.2, 0.3, 0), {"type": "gaussian", "stddev": 0.3}),
             (3, (2, 1 / 3, 1 / 3), {"type": "mitchell"}), (3, (2, 0.2, 0.7), {"type": "mitchell", "B": 0.2, "C": 0.7}),
             (4, (2, 0, 0), {"type": "catmullrom"}), (5, (3, 0, 0), {"type": "lanczos"})]
    lines = []
    for kind, parameters, d in cases:
        f = mi.load_dict(d)
        for i in range(16):
            x = parameters[0] * (i + 0.5) / 16
            lines.append([kind, *parameters, x, f.eval(x)])
    write("filters.csv", "kind,parameters(3),x,value", lines)


cameras()
emitters()
environment()
filters()
