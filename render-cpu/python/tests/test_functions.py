"""Half vectors and regularisation over arrays, against their definitions in float64."""

import numpy as np
import pytest

from halflight import half_vector, regularize


def directions(n, seed, below=False):
    v = np.random.default_rng(seed).normal(size=(n, 3))
    v /= np.linalg.norm(v, axis=-1, keepdims=True)
    v[:, 2] = -np.abs(v[:, 2]) if below else np.abs(v[:, 2])
    return v


def test_half_vectors_are_sums_of_directions():
    wi, wo = directions(1000, 1), directions(1000, 2, below=True)
    for eta, other in ((1.0, directions(1000, 3)), (1.5, wo), (1 / 1.3, wo)):
        h, length = half_vector.half_vector(wi, other, eta)
        H = wi + eta * other
        np.testing.assert_allclose(length, np.linalg.norm(H, axis=-1), rtol=1e-5)
        np.testing.assert_allclose(np.abs(np.sum(h * H, axis=-1)), length, rtol=1e-5)
        assert np.all(h[:, 2] >= 0)


def test_scattered_directions_have_their_half_vector():
    wi, m = directions(2000, 4), directions(2000, 5)
    wo, valid = half_vector.refract(wi, m, 1.4)
    h, _ = half_vector.half_vector(wi[valid], wo[valid], 1.4, m[valid])
    np.testing.assert_allclose(np.abs(np.sum(h * m[valid], axis=-1)), 1, atol=1e-5)
    wo = half_vector.reflect(wi, m)
    np.testing.assert_allclose(wo, 2 * np.sum(wi * m, axis=-1, keepdims=True) * m - wi, atol=1e-6)
    _, valid = half_vector.refract([0, 0.8, 0.6], [0, 0, 1], 1 / 1.5)
    assert not valid


@pytest.mark.parametrize("eta", [1.0, 1.5])
def test_solid_angle_per_half_vector_is_a_derivative(eta):
    """Areas of small triangles of half vectors and of the directions that they scatter to, in float64."""
    rng = np.random.default_rng(6)
    wi = np.array([0.36, 0.48, 0.8])

    def scatter(m):
        m = m / np.linalg.norm(m)
        if eta == 1.0:
            return 2 * np.dot(wi, m) * m - wi
        c = np.dot(wi, m)
        return (c * m - wi) / eta - np.sqrt(1 - (1 - c * c) / eta**2) * m

    for _ in range(50):
        m = np.array([0, 0, 1]) + 0.3 * rng.normal(size=3)
        m /= np.linalg.norm(m)
        s = np.cross(m, [1, 0, 0])
        s /= np.linalg.norm(s)
        t = np.cross(m, s)
        e = 1e-5
        du = (scatter(m + e * s) - scatter(m - e * s)) / (2 * e)
        dv = (scatter(m + e * t) - scatter(m - e * t)) / (2 * e)
        expected = np.linalg.norm(np.cross(du, dv))
        found = half_vector.solid_angle_per_half_vector(wi, scatter(m), eta)
        assert found == pytest.approx(expected, rel=1e-3)


def test_charts_are_inverse_and_have_their_jacobians():
    h = 0.9 * np.random.default_rng(7).uniform(-0.7, 0.7, size=(500, 2))
    slope = half_vector.slope_of_projected(h)
    np.testing.assert_allclose(half_vector.projected_of_slope(slope), h, atol=1e-6)
    cosine = np.sqrt(1 - np.sum(h * h, axis=-1))
    np.testing.assert_allclose(slope, h / cosine[:, None], rtol=1e-4, atol=1e-6)
    np.testing.assert_allclose(half_vector.projected_per_half_vector(cosine), cosine, rtol=1e-6)
    np.testing.assert_allclose(half_vector.slope_per_half_vector(cosine), cosine**-3, rtol=1e-5)


def test_steps_are_those_of_a_gaussian():
    alpha = np.array([0.01, 0.1, 0.5])
    np.testing.assert_allclose(half_vector.mean_step(alpha, 1.0), alpha / np.sqrt(np.pi), rtol=1e-5)
    # E|x| = sigma sqrt(2 / pi).
    deviation = half_vector.bsdf_deviation(alpha)
    np.testing.assert_allclose(half_vector.mean_step(alpha), deviation * np.sqrt(2 / np.pi), rtol=1e-5)


def test_bounds_are_those_of_the_paper():
    alpha = np.array([0.05, 0.2, 0.7])
    ggx = 4 / alpha**2 / (4 * np.pi * alpha**2)
    np.testing.assert_allclose(regularize.reflection_bound(alpha), ggx, rtol=1e-5)
    beckmann = 4 * np.pi / alpha**2 / (4 * np.pi * alpha**2)
    np.testing.assert_allclose(regularize.reflection_bound(alpha, distribution="beckmann"), beckmann, rtol=1e-5)
    v_cavity = 1 / (4 * np.pi * alpha**2)
    np.testing.assert_allclose(regularize.reflection_bound(alpha, masking="v-cavity"), v_cavity, rtol=1e-5)
    K = 1.5**2 / 0.5**2
    np.testing.assert_allclose(regularize.refraction_bound(alpha, 1.5), 4 * K * ggx, rtol=1e-5)
    assert np.all(regularize.tight_refraction_bound(alpha, 1.5) <= regularize.refraction_bound(alpha, 1.5))
    # The smaller alpha bounds masking.
    both = regularize.reflection_bound(0.4, 0.1)
    assert both == pytest.approx(1 / (np.pi * 0.4 * 0.1) * 4 / 0.1**2 / 4, rel=1e-5)


@pytest.mark.parametrize("distribution", ["ggx", "beckmann", "phong"])
def test_alpha_hat_inverts_the_bounds(distribution):
    tau = np.array([0.9, 10.0, 1e4])
    alpha = regularize.alpha_hat(tau, distribution=distribution)
    bound = regularize.reflection_bound(alpha, distribution=distribution)
    np.testing.assert_allclose(bound[alpha < 1], tau[alpha < 1], rtol=1e-4)
    alpha = regularize.alpha_hat(1e4, 1.5, distribution=distribution)
    assert regularize.tight_refraction_bound(alpha, 1.5, distribution=distribution) == pytest.approx(1e4, rel=1e-3)


@pytest.mark.parametrize(("distribution", "limit"), [("ggx", 1.0), ("beckmann", 0.7)])
def test_brute_force_stays_below_the_bound_and_comes_near(distribution, limit):
    """Values of f = D G1 G1 / (4 cos cos) at mirror pairs, where the bound is attained at grazing angles."""
    cosine = np.geomspace(1e-5, 1, 4000)
    for alpha in np.linspace(0.05, limit, 8):
        D = regularize.microfacet_distribution(1.0, alpha, distribution=distribution)
        G = regularize.smith_g1(cosine, alpha, distribution=distribution)
        value = D * G.astype(np.float64) ** 2 / (4 * cosine**2)
        bound = regularize.reflection_bound(alpha, distribution=distribution)
        assert value.max() <= bound * 1.001
        assert value.max() >= bound * 0.95


def test_schedules_are_those_of_their_formulas():
    n = np.array([1, 2, 10, 1000])
    tau = regularize.tau(5.0, n)
    assert tau[0] == pytest.approx(5.0, rel=1e-5) and np.all(np.diff(tau) > 0)
    t = np.sqrt(4 * np.pi * 5 - 1) / (2 * np.pi * 5 - 1) * n ** (-1 / 6)
    q = np.sqrt(1 + t * t)
    np.testing.assert_allclose(tau, q * (1 + q) / (2 * np.pi * t * t), rtol=1e-4)
    np.testing.assert_allclose(regularize.power_law(2.0, n, 0.25), 2 * n**-0.25, rtol=1e-5)
    np.testing.assert_allclose(regularize.geometric(2.0, n, 1e-3), 2 * 0.999**n, rtol=1e-5)
    with pytest.raises(ValueError, match="whole numbers"):
        regularize.tau(5.0, [0.5])
    with pytest.raises(ValueError, match="whole numbers"):
        regularize.tau(5.0, -1)


@pytest.mark.parametrize("kind", ["constant", "parabolic", "quartic", "perlin"])
def test_mollifiers_have_mass_one_and_their_moments(kind):
    t = (np.arange(100_000) + 0.5) / 100_000
    shells = {1: 2 * np.ones_like(t), 2: 2 * np.pi * t, 3: 4 * np.pi * t**2}
    for dimensions, shell in shells.items():
        K = regularize.mollifier(t, kind, dimensions).astype(np.float64)
        second, square = regularize.mollifier_moments(kind, dimensions)
        assert np.mean(K * shell) == pytest.approx(1, rel=1e-4)
        assert np.mean(K * shell * t**2) / dimensions == pytest.approx(second, rel=1e-4)
        assert np.mean(K**2 * shell) == pytest.approx(square, rel=1e-4)


@pytest.mark.parametrize(
    "call",
    [
        lambda: regularize.reflection_bound(0.1, distribution="gauss"),
        lambda: regularize.reflection_bound(0.1, masking="none"),
        lambda: regularize.mollifier(0.5, "box"),
        lambda: regularize.mollifier(0.5, dimensions=4),
        lambda: half_vector.slope_of_projected([1, 2, 3]),
    ],
)
def test_what_is_not_known_is_a_value_error(call):
    with pytest.raises(ValueError):
        call()
