"""Renders: the command's bits, arguments, progress, interrupts, threads."""

import _thread
import os
import signal
import threading
import time

import numpy as np
import pytest

import halflight


def test_radiance_is_that_of_the_command_to_the_bit(scenes, command):
    scene = scenes / "cornell-box.xml"
    folder = command(
        "render", scene, "--spp", 6, "--seed", 3, "--width", 48, "--aov", "albedo,variance,depth",
        "-o", "out.exr", "--no-png",
    )  # fmt: skip
    written = halflight.read(folder / "out.exr")
    image = halflight.load(scene, width=48).render(spp=6, seed=3, layers=["albedo", "depth"])
    assert set(image.layers) == {"radiance", "albedo", "depth", "variance", "samples"}
    assert set(written.layers) == set(image.layers)
    for layer in image.layers:
        np.testing.assert_array_equal(image[layer], written[layer], err_msg=layer)
    assert np.any(image.radiance > 0)
    wanted = {k: v for k, v in written.metadata.items() if k != "renderSeconds"}
    assert {k: v for k, v in image.metadata.items() if k != "renderSeconds"} == wanted


def test_integrator_and_sample_range_are_those_of_the_command(spheres, command):
    folder = command(
        "render", spheres, "--samples", "3..7", "--integrator", "direct", "--sampler", "sobol",
        "-o", "out.exr", "--no-png",
    )  # fmt: skip
    scene = halflight.load(spheres, sampler="sobol")
    image = scene.render("direct", samples=(3, 7))
    np.testing.assert_array_equal(image.radiance, halflight.read(folder / "out.exr").radiance)
    assert image.metadata["sampleRanges"] == "0:3..7"
    # The next render has the scene's own integrator again.
    assert scene.integrator == "path"
    assert np.any(scene.render(samples=(3, 7)).radiance != image.radiance)


@pytest.mark.parametrize("integrator", ["bdpt", "ptracer", "ao"])
def test_every_driver_is_the_command_s(spheres, command, integrator):
    folder = command(
        "render", spheres, "--spp", 3, "--integrator", integrator, "--aov", "variance", "-o", "out.exr", "--no-png"
    )
    image = halflight.load(spheres).render(integrator, spp=3)
    written = halflight.read(folder / "out.exr")
    for layer in ("radiance", "variance"):
        np.testing.assert_array_equal(image[layer], written[layer], err_msg=layer)
    assert image.metadata["integrator"] == integrator


def test_shapes_types_and_statistics(spheres):
    image = halflight.load(spheres).render(spp=16, layers=["normal", "uv"])
    assert (image.width, image.height, image.spp) == (40, 30, 16)
    assert image.radiance.shape == (30, 40, 3) and image.radiance.dtype == np.float32
    assert image["normal"].shape == (30, 40, 3) and image["uv"].shape == (30, 40, 2)
    assert image.samples.dtype == np.uint32 and np.all(image.samples == 16)
    assert image.variance.shape == (30, 40, 3) and np.all(image.variance >= 0)
    assert not image.interrupted
    # No copies: what is written into the array is in the image.
    image.radiance[0, 0] = 7
    assert np.all(np.asarray(image)[0, 0] == 7)


def test_variance_is_that_of_the_mean(spheres):
    scene = halflight.load(spheres)
    runs = [scene.render(spp=8, seed=seed) for seed in range(40)]
    spread = np.var([run.radiance for run in runs], axis=0, ddof=1).mean()
    claimed = np.mean([run.variance for run in runs])
    # The relative deviation of the former is about sqrt(2 / 39 / pixels that differ): a percent.
    assert abs(spread / claimed - 1) < 0.05


def test_the_scene_says_how_long_without_arguments(spheres):
    scene = halflight.load(spheres)
    assert scene.spp == 4
    assert scene.render().spp == 4


def test_a_time_ends_a_render(spheres):
    start = time.monotonic()
    image = halflight.load(spheres).render(time=0.3)
    assert time.monotonic() - start >= 0.3
    # The pass that the time ends leaves some pixels with more samples than others.
    assert image.samples.min() >= 1
    assert np.isclose(image.samples.mean(), image.spp)


@pytest.mark.parametrize(
    "arguments",
    [
        {"spp": 0},
        {"spp": 4, "time": 1.0},
        {"samples": (3, 3)},
        {"samples": (-1, 3)},
        {"time": 0.0},
        {"integrator": "no such thing"},
        {"layers": ["no such thing"]},
    ],
)
def test_arguments_that_mean_nothing_are_refused(spheres, arguments):
    with pytest.raises(ValueError):
        halflight.load(spheres).render(**arguments)


def test_progress_is_told_and_ends_at_one(spheres):
    seen = []
    halflight.load(spheres).render(spp=100, progress=seen.append)
    assert seen and seen[-1].fraction == 1.0 and seen[-1].samples == 100
    assert [p.samples for p in seen] == sorted(p.samples for p in seen)
    assert all(0 < p.noise <= 1 and p.seconds > 0 for p in seen)


def test_an_exception_of_progress_ends_the_render(spheres):
    class Enough(Exception):
        pass

    def stop(progress):
        raise Enough

    with pytest.raises(Enough):
        halflight.load(spheres).render(spp=100_000_000, progress=stop)


@pytest.fixture
def heeded_interrupts():
    """Ctrl-C raises KeyboardInterrupt, also where the tests run in the background of a shell, which ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_an_interrupt_returns_what_there_is(spheres, heeded_interrupts):
    scene = halflight.load(spheres)
    timer = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    start = time.monotonic()
    image = scene.render(spp=100_000_000)
    assert image.interrupted
    # Long before a pass of two seconds would be over; the rest is for slow machines.
    assert time.monotonic() - start < 1.7
    done = image.samples
    assert 1 <= done.min() == done.max() < 100_000_000
    # What there is, is a render of that many samples.
    again = scene.render(spp=int(done.max()))
    np.testing.assert_array_equal(image.radiance, again.radiance)


def test_an_interrupt_within_progress_is_one_too(spheres, heeded_interrupts):
    image = halflight.load(spheres).render(spp=100_000_000, progress=lambda _: _thread.interrupt_main())
    assert image.interrupted and image.samples.min() >= 1


def test_two_threads_render_at_once_without_the_lock(spheres):
    scene = halflight.load(spheres)
    expected = [scene.render(spp=32, seed=seed).radiance for seed in (1, 2)]
    found = [None, None]
    ticks = 0

    def work(i):
        found[i] = scene.render(time=0.4) and scene.render(spp=32, seed=i + 1).radiance

    threads = [threading.Thread(target=work, args=(i,)) for i in range(2)]
    start = time.monotonic()
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        ticks += 1
        time.sleep(0.01)
    # This thread went on meanwhile, which it could not if the renders held the lock.
    assert ticks > 10 and time.monotonic() - start < 60
    for i in range(2):
        np.testing.assert_array_equal(found[i], expected[i])
