#!/usr/bin/env python3
"""What mutations in half-vector space are worth, and what they cost.

    python3 benches/half-vectors.py target/release/halflight FOLDER PART ... [--seconds 30] [--seeds 2]

Parts; FOLDER/SCENE/scene.xml are scenes with references FOLDER/reference/SCENE.exr:
  race        hslt and memlt at equal processor time on these scenes: errors and their ratio, acceptance
  displaced   improved over original: time to equal error on a displaced mesh of a million triangles, and on FOLDER's glossy-chain
  roughness   local over global: time to equal CIE76 error on coated plastic, measured metal and diffracting metal
  cost        mutations per second of processor time over samples of path on these scenes, and for chains of 2 to 10 inner vertices
  shares      what half-vector mutations alone spend their time on (Linux perf)

Errors are relative squared errors less the reference's own variance, whole and without the worst one of a thousand pixels. Times to
equal error come from a power law through errors at three times. Scenes and references of displaced and roughness are made
in a folder of their own (--work), and kept there for the next run.
"""

import argparse
import array
import importlib.util
import json
import math
import os
import pathlib
import re
import signal
import struct
import subprocess
import tempfile
import time

HERE = pathlib.Path(__file__).parent
SCENES = "torus,glass-sphere-lamp,veach-bidir,ring,glossy-chain,door-ajar"


def module(name):
    """Another script of this folder."""
    spec = importlib.util.spec_from_file_location(name.replace("-", "_"), HERE / f"{name}.py")
    loaded = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(loaded)
    return loaded


EQUAL_TIME = module("equal-time")


def run(command):
    """Processor seconds of a command that ends by itself, and what it prints."""
    with tempfile.TemporaryFile("w+") as text:
        child = subprocess.Popen(command, stdout=text, stderr=subprocess.STDOUT)
        _, status, usage = os.wait4(child.pid, 0)
        text.seek(0)
        printed = text.read()
    if status != 0:
        raise SystemExit(f"{' '.join(command)} failed: {printed}")
    return usage.ru_utime + usage.ru_stime, printed


def for_a_time(command, seconds):
    """Runs a render until it has had the processor time; what it prints."""
    with tempfile.TemporaryFile("w+") as text:
        child = subprocess.Popen(command + ["--time", "10h", "--threads", "1", "-v"], stdout=text, stderr=subprocess.STDOUT)
        while (spent := EQUAL_TIME.processor_seconds(child.pid)) is not None and spent < seconds:
            if os.waitid(os.P_PID, child.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT):
                break
            time.sleep(0.05)
        child.send_signal(signal.SIGTERM)
        os.wait4(child.pid, 0)
        text.seek(0)
        return text.read()


def metrics(halflight, image, reference):
    """Errors of an image, less the reference's own variance where they are squares."""
    _, text = run([halflight, "compare", image, reference, "--json"])
    found = json.loads(text)["metrics"]
    own = found.get("reference-variance", 0.0)
    return {
        "error": found["relative-mse"] - own,
        "trimmed": found.get("trimmed-relative-mse", found["relative-mse"]) - own,
        "cie76": found["cie76"],
    }


def render(options, scene, arguments, seconds, seed):
    """Errors of one render, and the lines of its mutations."""
    with tempfile.TemporaryDirectory() as folder:
        image = os.path.join(folder, "image.exr")
        command = [options.halflight, "render", str(scene), "--no-png", "--seed", str(seed), "-o", image] + arguments
        text = for_a_time(command, seconds)
        found = metrics(options.compare, image, options.reference(scene))
    return found, text


def acceptance(text, name):
    """Accepted share of a mutation, percent."""
    found = re.search(rf"{name}: \d+ proposals, [\d.]+ % with light, ([\d.]+) % accepted", text)
    return float(found.group(1)) if found else math.nan


def race(options):
    print("| scene | hslt | memlt | RMSE, hslt over memlt | without the worst | accepted: half-vector, manifold |")
    print("|---" * 6 + "|")
    for scene in options.scenes.split(","):
        path = pathlib.Path(options.folder) / scene / "scene.xml"
        means, accepted = {}, {}
        for integrator, mutation in (("hslt", "half-vector"), ("memlt", "manifold")):
            runs = [render(options, path, ["--integrator", integrator], options.seconds, 1 + i) for i in range(options.seeds)]
            means[integrator] = {k: sum(r[k] for r, _ in runs) / len(runs) for k in ("error", "trimmed")}
            accepted[integrator] = acceptance(runs[0][1], mutation)
        ratios = [math.sqrt(means["hslt"][k] / means["memlt"][k]) for k in ("error", "trimmed")]
        cells = [f"{means[i]['error']:.4g} / {means[i]['trimmed']:.4g}" for i in ("hslt", "memlt")]
        shares = f"{accepted['hslt']:.1f} %, {accepted['memlt']:.1f} %"
        print(f"| {scene} | {cells[0]} | {cells[1]} | {ratios[0]:.2f} | {ratios[1]:.2f} | {shares} |", flush=True)


def curves(options, scene, variants, times):
    """Errors of variants over time, and the time of the first over that of the second for the same error."""
    kinds = ("error", "trimmed", "cie76")
    found = {}
    for name, arguments in variants:
        for seconds in times:
            runs = [render(options, scene, arguments, seconds, 1 + i)[0] for i in range(options.seeds)]
            found[name, seconds] = {k: sum(r[k] for r in runs) / len(runs) for k in kinds}
    for name, _ in variants:
        cells = [", ".join(f"{found[name, t][k]:.4g}" for k in kinds) for t in times]
        print(f"| {scene.stem} | {name} | " + " | ".join(cells) + " |", flush=True)
    first, second = (name for name, _ in variants)
    ratios = []
    for kind in kinds:
        # One slope for both, by least squares; the offset of their lines over it is the logarithm of the ratio of times.
        logs = {n: [math.log(max(found[n, t][kind], 1e-9)) for t in times] for n in (first, second)}
        at = [math.log(t) for t in times]
        middle = sum(at) / len(at)
        mean = {n: sum(v) / len(v) for n, v in logs.items()}
        slope = sum((x - middle) * (y - mean[n]) for n in logs for x, y in zip(at, logs[n])) / (2 * sum((x - middle) ** 2 for x in at))
        ratio = math.exp((mean[first] - mean[second]) / -slope) if slope < -0.05 else math.nan
        ratios.append(f"{ratio:.2f} (slope {slope:.2f})")
    print(f"| {scene.stem} | **time, {first} over {second}** | " + ", ".join(f"{k} {r}" for k, r in zip(kinds, ratios)) + " |", flush=True)


NICHE = """<scene version="3.0.0">
<integrator type="{integrator}"><integer name="max_depth" value="10"/><integer name="group_mutations" value="16"/>
<integer name="chains" value="32"/></integrator>
<sensor type="perspective"><float name="fov" value="48"/><string name="fov_axis" value="x"/>
<transform name="to_world"><lookat origin="0, 1.15, 3.3" target="0, 0.75, 0" up="0, 1, 0"/></transform>
<film type="hdrfilm"><integer name="width" value="128"/><integer name="height" value="96"/><rfilter type="box"/></film></sensor>
<bsdf type="twosided" id="own">{material}</bsdf>
<bsdf type="twosided" id="screen"><bsdf type="diffuse"><rgb name="reflectance" value="0.3, 0.3, 0.32"/></bsdf></bsdf>
{floor}
<shape type="rectangle"><transform name="to_world"><scale x="1.4" y="1"/><translate y="1" z="-1.4"/></transform><ref id="own"/></shape>
<shape type="rectangle"><transform name="to_world"><scale x="1.4" y="1"/><rotate y="1" angle="90"/><translate x="-1.4" y="1"/></transform>
<ref id="screen"/></shape>
<shape type="rectangle"><transform name="to_world"><scale x="0.5" y="0.35"/><translate x="0.6" y="1.45" z="0.2"/></transform><ref id="screen"/></shape>
<shape type="sphere"><point name="center" x="-0.45" y="0.42" z="-0.35"/><float name="radius" value="0.35"/><ref id="own"/></shape>
<shape type="sphere"><point name="center" x="0.4" y="0.32" z="0.25"/><float name="radius" value="0.25"/><ref id="own"/></shape>
<shape type="rectangle"><transform name="to_world"><scale value="0.12"/><rotate x="1" angle="150"/><translate x="0.6" y="1.5" z="-0.2"/></transform>
<emitter type="area"><rgb name="radiance" value="60, 55, 50"/></emitter></shape></scene>
"""

FLOOR = """<shape type="rectangle"><transform name="to_world"><scale value="1.4"/><rotate x="1" angle="-90"/></transform><ref id="own"/></shape>"""
DISPLACED = """<shape type="ply"><string name="filename" value="big.ply"/><transform name="to_world"><scale value="1.4"/>
<rotate x="1" angle="-90"/></transform><ref id="own"/></shape>"""
GOLD = """<bsdf type="roughconductor"><rgb name="eta" value="0.143, 0.375, 1.442"/><rgb name="k" value="3.983, 2.386, 1.603"/>
<string name="distribution" value="ggx"/><float name="alpha" value="0.1"/></bsdf>"""
MATERIALS = {
    "coated-plastic": """<bsdf type="roughplastic"><rgb name="diffuse_reflectance" value="0.3, 0.1, 0.08"/><string name="distribution" value="ggx"/>
<float name="alpha" value="0.06"/></bsdf>""",
    "measured-metal": """<bsdf type="merl"><string name="filename" value="metal.binary"/></bsdf>""",
    "diffracting-metal": """<bsdf type="ctd"/>""",
}


def write_measured(path):
    """A metal in the format of the MERL database: a narrow lobe on a broad one, as measured metals have, over a little diffuse light."""
    cells = (90, 30, 24)
    scale = (1500.0, 1500.0 / 1.15, 1500.0 / 1.66)
    values = [array.array("d") for _ in range(3)]
    for h in range(cells[0]):
        theta = ((h + 0.5) / cells[0]) ** 2 * math.pi / 2
        c2 = math.cos(theta) ** 2
        ggx = [a * a / (math.pi * (c2 * (a * a - 1) + 1) ** 2) for a in (0.04, 0.25)]
        for d in range(cells[1]):
            fresnel = (1 - math.cos((d + 0.5) / cells[1] * math.pi / 2)) ** 5
            for channel, base in enumerate((0.7, 0.65, 0.6)):
                value = (base + (1 - base) * fresnel) * (0.6 * ggx[0] + 0.4 * ggx[1]) / 4 + 0.02
                values[channel].extend([value * scale[channel]] * cells[2])
    path.write_bytes(struct.pack("<3i", *cells) + b"".join(v.tobytes() for v in values))


def made(options, name, material, floor, integrator="hslt"):
    """A scene of the working folder and its reference, by bidirectional path tracing."""
    folder = pathlib.Path(options.work)
    scene = folder / f"{name}.xml"
    scene.write_text(NICHE.format(material=material, floor=floor, integrator=integrator))
    reference = options.reference(scene)
    if not os.path.exists(reference):
        run([options.halflight, "render", str(scene), "-q", "--no-png", "--integrator", "path", "--seed", "99", "--spp", str(options.reference_spp), "-o", reference])
    return scene


def displaced(options):
    folder = pathlib.Path(options.work)
    if not (folder / "big.ply").exists():
        subprocess.run(["python3", HERE / "large-mesh.py", "--side", "724", folder], check=True)
    print("| scene | mutation | " + " | ".join(f"{t:g} s" for t in options.times) + " |")
    print("|---" * (2 + len(options.times)) + "|")
    variants = [("improved", ["--direct-samples", "0"]), ("original", ["--direct-samples", "0", "--hslt", "original"])]
    curves(options, made(options, "displaced-metal", GOLD, DISPLACED), variants, options.times)
    chain = folder / "glossy-chain.xml"
    text = (pathlib.Path(options.folder) / "glossy-chain" / "scene.xml").read_text()
    chain.write_text(re.sub(r'(<integrator type=")[^"]*(">)', r'\1hslt\2<integer name="group_mutations" value="16"/>', text, count=1))
    options.references[str(chain)] = os.path.join(options.folder, "reference", "glossy-chain.exr")
    curves(options, chain, variants, options.times)


def roughness(options):
    folder = pathlib.Path(options.work)
    write_measured(folder / "metal.binary")
    print("| scene | roughness | " + " | ".join(f"{t:g} s" for t in options.times) + " |")
    print("|---" * (2 + len(options.times)) + "|")
    variants = [("local", ["--direct-samples", "0"]), ("global", ["--direct-samples", "0", "--roughness", "global"])]
    for name, material in MATERIALS.items():
        curves(options, made(options, name, material, FLOOR), variants, options.times)


def sheets(count):
    """A floor that is seen and lit through panes of slightly rough glass: paths of so many interfaces between the camera and the floor."""
    panes = "".join(
        f"""<shape type="rectangle"><transform name="to_world"><scale value="3"/><translate z="{1.6 - 0.12 * i:.3f}"/></transform>
<bsdf type="roughdielectric"><float name="alpha" value="0.05"/><float name="{'int' if i % 2 == 0 else 'ext'}_ior" value="1.2"/>
<float name="{'ext' if i % 2 == 0 else 'int'}_ior" value="1"/></bsdf></shape>"""
        for i in range(count)
    )
    return f"""<scene version="3.0.0"><integrator type="hslt"><integer name="max_depth" value="{count + 2}"/><integer name="direct_samples" value="0"/>
<boolean name="bidirectional_mutation" value="false"/><boolean name="hide_emitters" value="true"/><integer name="luminance_samples" value="50000"/>
<integer name="group_mutations" value="32"/></integrator>
<sensor type="perspective"><float name="fov" value="40"/><transform name="to_world"><lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
<film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="64"/><rfilter type="box"/></film></sensor>
<shape type="rectangle"><transform name="to_world"><scale value="3"/></transform><bsdf type="diffuse"/></shape>
<shape type="rectangle"><transform name="to_world"><scale value="0.3"/><rotate x="1" angle="180"/><translate x="1.7" z="0.35"/></transform>
<emitter type="area"><rgb name="radiance" value="20"/></emitter></shape>{panes}</scene>"""


def rate(options, scene, arguments, few, many):
    """Samples or mutations per second of processor time, from the difference of two runs, by the numbers that they made."""
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for spp in (few, many):
            image = os.path.join(folder, "image.exr")
            command = [options.halflight, "render", str(scene), "--no-png", "--threads", "1", "-v", "--spp", str(spp), "-o", image]
            seconds, text = run(command + arguments)
            proposals = sum(int(n) for n in re.findall(r": (\d+) proposals", text))
            found.append((seconds, proposals))
    (t0, n0), (t1, n1) = found
    return (t1 - t0), n1 - n0, text


def alone(options, name):
    """A scene of the folder with half-vector mutations alone."""
    source = pathlib.Path(options.folder) / name
    text = (source / "scene.xml").read_text()
    own = (
        '<boolean name="bidirectional_mutation" value="false"/><integer name="direct_samples" value="0"/>'
        '<integer name="luminance_samples" value="50000"/><integer name="group_mutations" value="32"/>'
    )
    text = re.sub(r'(<integrator type=")[^"]*(">)', rf"\1hslt\2{own}", text, count=1)
    text = re.sub(r'(name="filename" value=")', rf"\1{source.resolve()}/", text)
    scene = pathlib.Path(options.work) / f"cost-{name}.xml"
    scene.write_text(text)
    return scene


# Names of functions by what they do, the first that fits.
PARTS = (
    ("rays", r"CpuTraverse|accel"),
    ("solving", r"block_tridiagonal|block_elimination|manifold::(constraint|chain|half_vector)|scattering_measure"),
    ("walks", r"manifold::"),
    ("BSDFs", r"bsdf"),
    ("surfaces", r"scene::(surface|mesh|shape|camera|emitter)"),
    ("evaluation of paths", r"path::|measure"),
    ("the mutation itself", r"half_vector"),
    ("copies", r"memmove|memcpy|memset"),
)


def shares(options):
    print("| scene | mutation | " + " | ".join(name for name, _ in PARTS) + " | rest |")
    print("|---" * (3 + len(PARTS)) + "|")
    for name in options.scenes.split(","):
        scene = alone(options, name)
        for variant, arguments in (("broken up", []), ("whole paths", ["--hslt", "original"])):
            data = os.path.join(options.work, "perf.data")
            command = ["perf", "record", "-q", "-o", data, "-F", "499", options.halflight, "render", str(scene), "-q", "--no-png"]
            run(command + ["--threads", "1", "--spp", "64", "-o", os.path.join(options.work, "shares.exr")] + arguments)
            report = ["perf", "report", "-i", data, "--stdio", "--no-children", "-F", "overhead,sym"]
            text = subprocess.run(report, capture_output=True, text=True, check=True).stdout
            sums = dict.fromkeys([n for n, _ in PARTS] + ["rest"], 0.0)
            for share, symbol in re.findall(r"^\s+([\d.]+)%\s+\[.\]\s+(.*)$", text, re.MULTILINE):
                part = next((n for n, pattern in PARTS if re.search(pattern, symbol)), "rest")
                sums[part] += float(share)
            print(f"| {name} | {variant} | " + " | ".join(f"{v:.0f} %" for v in sums.values()) + " |", flush=True)


def cost(options):
    print("| scene | path samples, million/s | half-vector mutations | over path | original | over path |")
    print("|---" * 6 + "|")
    folder = pathlib.Path(options.work)
    pixels = module("samples-per-second").pixels
    for name in options.scenes.split(","):
        source = pathlib.Path(options.folder) / name
        scene = alone(options, name)
        count = pixels(options.halflight, str(scene))
        seconds, _, _ = rate(options, source / "scene.xml", ["--integrator", "path"], 1, 33)
        path = 32 * count / seconds / 1e6
        cells = []
        for arguments in ([], ["--hslt", "original"]):
            seconds, made, _ = rate(options, scene, arguments, 32, 96)
            cells += [f"{made / seconds / 1e6:.3f}", f"{made / seconds / 1e6 / path:.3f}"]
        print(f"| {name} | {path:.3f} | " + " | ".join(cells) + " |", flush=True)
    print("\n| inner vertices | whole paths, us per mutation | accepted | walks that find a path | iterations |")
    print("|---" * 5 + "|")
    for panes in range(1, 10):
        scene = folder / "sheets.xml"
        scene.write_text(sheets(panes))
        seconds, made, text = rate(options, scene, ["--hslt", "original"], 32, 96)
        walks = re.search(r"walks, ([\d.]+ %) found in ([\d.]+) iterations", text)
        found = walks.groups() if walks else ("", "")
        print(f"| {panes + 1} | {1e6 * seconds / made:.2f} | {acceptance(text, 'half-vector'):.1f} % | {found[0]} | {found[1]} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("halflight")
    parser.add_argument("folder")
    parser.add_argument("parts", nargs="+", choices=("race", "displaced", "roughness", "cost", "shares"))
    parser.add_argument("--scenes", default=SCENES)
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--times", default="8,16,32", help="of the curves, seconds of processor time")
    parser.add_argument("--reference-spp", type=int, default=16384)
    parser.add_argument("--compare", help="the program that compares images, if it is another")
    parser.add_argument("--work", help="folder of the scenes that are made")
    options = parser.parse_args()
    options.times = [float(t) for t in options.times.split(",")]
    options.compare = options.compare or options.halflight
    options.work = options.work or tempfile.mkdtemp()
    options.references = {}
    pathlib.Path(options.work).mkdir(parents=True, exist_ok=True)

    def reference(scene):
        own = pathlib.Path(options.folder) / "reference" / f"{scene.parent.name}.exr"
        return options.references.get(str(scene), str(own if scene.name == "scene.xml" else scene.with_suffix(".exr")))

    options.reference = reference
    for part in options.parts:
        globals()[part](options)


if __name__ == "__main__":
    main()
