//! The light of the sky and the sun on a clear day, as an image over the sphere of directions.
//!
//! The sky is Hosek and Wilkie's model (2012, "An Analytic Model for Full Spectral Sky-Dome Radiance") in its RGB form, from
//! the crate `hw-skymodel`; the sun's disk has the radiance of Preetham, Shirley and Smits ([`sun`]), whose irradiance is kept
//! while its disk, smaller than a texel, is spread over four. The image has +y up, as of [`halflight_kernel::scene::emitter`]'s
//! environments: column i at the azimuth 2 pi (i + 1/2) / w from -z towards +x, row j at the polar angle pi j / (h - 1).
//! Below the horizon it is black. Radiance in W/(m^2 sr nm) per channel.

pub mod sun;
pub mod sun_position;

use glam::DVec3;
use hw_skymodel::rgb::{Channel, SkyParams, SkyState};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Sum of the luminous efficiency over the wavelengths, which the RGB form of the sky has as a factor (Mitsuba 0.6).
const RGB_SCALE: f64 = 1.0 / 106.856_980;

/// Points of the sun's disk.
const DISK_POINTS: u32 = 4096;

/// A day's light.
#[derive(Clone, Copy, Debug)]
pub struct Daylight {
    /// From 1 (clear) to 10 (hazy).
    pub turbidity: f64,
    /// Reflectance of the ground, per channel.
    pub albedo: [f32; 3],
    /// Unit vector to the sun, +y up.
    pub to_sun: DVec3,
    /// Factor on the polar angles of the sky and the sun: above 1 the sky reaches below the horizon.
    pub stretch: f64,
    /// Whether the sky continues below the horizon, darkening towards the nadir.
    pub extend: bool,
    /// Factor on the sky, or nothing for none.
    pub sky_scale: Option<f64>,
    /// Factor on the sun, or nothing for none.
    pub sun_scale: Option<f64>,
    /// Half of the angle under which the sun is seen, radians.
    pub sun_radius: f64,
}

impl Daylight {
    /// The image, `width` x `height` texels of three channels, rows from the zenith down.
    ///
    /// # Errors
    /// A sentence, when a parameter is out of the model's domain.
    pub fn image(&self, width: u32, height: u32) -> Result<Vec<f32>, String> {
        let mut image = vec![0.0_f32; 3 * width as usize * height as usize];
        if let Some(scale) = self.sky_scale {
            self.add_sky(scale * RGB_SCALE, width, height, &mut image)?;
        }
        if let Some(scale) = self.sun_scale
            && self.to_sun.y > 0.0
        {
            self.add_sun(scale, width, height, &mut image);
        }
        Ok(image)
    }

    fn add_sky(
        &self,
        scale: f64,
        width: u32,
        height: u32,
        image: &mut [f32],
    ) -> Result<(), String> {
        let elevation = self.to_sun.y.clamp(-1.0, 1.0).asin();
        if elevation < 0.0 {
            return Err("the sun is below the horizon, where the model of the sky ends".into());
        }
        let sky = SkyState::new(&SkyParams {
            elevation: elevation as f32,
            turbidity: self.turbidity as f32,
            albedo: self.albedo,
        })
        .map_err(|error| error.to_string())?;
        for row in 0..height {
            let seen = polar_angle(row, height);
            let mut theta = seen / self.stretch;
            if theta >= FRAC_PI_2 {
                if !self.extend {
                    break;
                }
                theta = FRAC_PI_2 - 1e-4;
            }
            let fade = if self.extend {
                let t = (2.0 - 2.0 * seen / PI).clamp(0.0, 1.0);
                t * t * (3.0 - 2.0 * t)
            } else {
                1.0
            };
            for column in 0..width {
                let (sin_phi, cos_phi) = azimuth(column, width).sin_cos();
                let direction =
                    DVec3::new(theta.sin() * sin_phi, theta.cos(), -theta.sin() * cos_phi);
                let gamma = direction.dot(self.to_sun).clamp(-1.0, 1.0).acos() as f32;
                let at = 3 * (row as usize * width as usize + column as usize);
                for (c, channel) in [Channel::R, Channel::G, Channel::B].into_iter().enumerate() {
                    let radiance =
                        f64::from(sky.radiance(theta as f32, gamma, channel)) * scale * fade;
                    image[at + c] += radiance.max(0.0) as f32;
                }
            }
        }
        Ok(())
    }

    /// Where the sun is shown: its polar angle is stretched like that of the sky.
    pub fn shown_sun(&self) -> DVec3 {
        let theta = self.to_sun.y.clamp(-1.0, 1.0).acos() * self.stretch;
        let across = DVec3::new(self.to_sun.x, 0.0, self.to_sun.z).normalize_or_zero();
        across * theta.sin() + DVec3::Y * theta.cos()
    }

    fn add_sun(&self, scale: f64, width: u32, height: u32, image: &mut [f32]) {
        let theta = self.to_sun.y.clamp(-1.0, 1.0).acos();
        let radiance = sun::radiance(theta, self.turbidity);
        let solid_angle = TAU * (1.0 - sun::RADIUS.cos());
        let energy = solid_angle / f64::from(DISK_POINTS) * scale;
        let to_sun = self.shown_sun();
        let (x, z) = to_sun.any_orthonormal_pair();
        for i in 0..DISK_POINTS {
            // A spiral of equal areas (Vogel 1979).
            let r = self.sun_radius * ((f64::from(i) + 0.5) / f64::from(DISK_POINTS)).sqrt();
            let turn = TAU * 0.618_033_988_749_895 * f64::from(i);
            let across = x * turn.cos() + z * turn.sin();
            let direction = to_sun * r.cos() + across * r.sin();
            splat(
                direction,
                radiance.map(|v| v * energy),
                width,
                height,
                image,
            );
        }
    }
}

fn polar_angle(row: u32, height: u32) -> f64 {
    PI * f64::from(row) / f64::from(height - 1)
}

fn azimuth(column: u32, width: u32) -> f64 {
    TAU * (f64::from(column) + 0.5) / f64::from(width)
}

/// Adds irradiance from a direction to the four texels around it.
fn splat(direction: DVec3, irradiance: [f64; 3], width: u32, height: u32, image: &mut [f32]) {
    let u = direction.x.atan2(-direction.z) / TAU;
    let x = (u - u.floor()) * f64::from(width) - 0.5;
    let step = PI / f64::from(height - 1);
    let y = direction.y.clamp(-1.0, 1.0).acos() / step;
    let (left, top) = (x.floor(), y.floor().min(f64::from(height - 2)));
    for (column, row) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let share = |offset: f64, k: u32| if k == 0 { 1.0 - offset } else { offset };
        let weight = share(x - left, column) * share(y - top, row);
        let column = (left as i64 + i64::from(column)).rem_euclid(i64::from(width)) as usize;
        let row = top as usize + row as usize;
        // Solid angle of a texel's share of what is interpolated; at the poles that of a cone.
        let across = (step * row as f64).sin().max(step / 6.0);
        let solid_angle = step * across * TAU / f64::from(width);
        let at = 3 * (row * width as usize + column);
        for c in 0..3 {
            image[at + c] += (irradiance[c] * weight / solid_angle) as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn day() -> Daylight {
        Daylight {
            turbidity: 3.0,
            albedo: [0.3; 3],
            to_sun: DVec3::new(1.0, 1.0, 0.0).normalize(),
            stretch: 1.0,
            extend: false,
            sky_scale: None,
            sun_scale: Some(1.0),
            sun_radius: sun::RADIUS,
        }
    }

    /// Integral of the image over the sphere, by its bilinear weights.
    fn sum(image: &[f32], width: u32, height: u32) -> [f64; 3] {
        let mut sum = [0.0; 3];
        let step = PI / f64::from(height - 1);
        for row in 0..height {
            let across = (step * f64::from(row)).sin().max(step / 6.0);
            for column in 0..width {
                let at = 3 * (row as usize * width as usize + column as usize);
                for c in 0..3 {
                    sum[c] += f64::from(image[at + c]) * step * across * TAU / f64::from(width);
                }
            }
        }
        sum
    }

    #[test]
    fn the_sun_keeps_its_irradiance_wherever_it_stands_and_however_large() {
        let radiance = sun::radiance(45.0_f64.to_radians(), 3.0);
        for radius in [1.0, 4.0] {
            for turn in [0.0_f64, 0.3, 2.0] {
                let day = Daylight {
                    to_sun: DVec3::new(turn.cos(), 1.0, turn.sin()).normalize(),
                    sun_radius: sun::RADIUS * radius,
                    ..day()
                };
                let sum = sum(&day.image(256, 128).unwrap(), 256, 128);
                for c in 0..3 {
                    let expected = radiance[c] * TAU * (1.0 - sun::RADIUS.cos());
                    assert!((sum[c] / expected - 1.0).abs() < 1e-3, "{sum:?} {expected}");
                }
            }
        }
    }

    #[test]
    fn a_sun_below_the_horizon_gives_no_sky() {
        let night = Daylight {
            to_sun: DVec3::new(0.0, -0.1, 1.0).normalize(),
            ..day()
        };
        assert!(night.image(8, 4).unwrap().iter().all(|&v| v == 0.0));
        let sky = Daylight {
            sky_scale: Some(1.0),
            ..night
        };
        assert!(sky.image(8, 4).unwrap_err().contains("below the horizon"));
    }

    #[test]
    fn an_extended_sky_fades_below_the_horizon_and_a_stretched_one_moves_down() {
        let day = Daylight {
            sky_scale: Some(1.0),
            sun_scale: None,
            ..day()
        };
        let (width, height) = (32, 65);
        let row = |day: &Daylight, row: usize| {
            let image = day.image(width, height).unwrap();
            image[3 * 32 * row..3 * 32 * (row + 1)].iter().sum::<f32>()
        };
        let extended = Daylight {
            extend: true,
            ..day
        };
        assert_eq!(row(&day, 40), 0.0);
        assert!(row(&extended, 40) > row(&extended, 50) && row(&extended, 50) > row(&extended, 60));
        assert!(row(&extended, 60) > 0.0);
        let stretched = Daylight {
            stretch: 1.5,
            ..day
        };
        assert!(row(&stretched, 40) > 0.0 && row(&stretched, 50) == 0.0);
        let angle = |v: DVec3| v.y.acos().to_degrees();
        assert!((angle(stretched.shown_sun()) - 67.5).abs() < 1e-9);
        assert!((day.shown_sun() - day.to_sun).length() < 1e-12);
    }

    /// Values of Mitsuba 3.9.1, `sunsky` without the sun, at the directions of texels.
    #[test]
    fn the_sky_is_that_of_another_renderer() {
        let oracle = include_str!("../../../tests/oracle/sky.csv");
        let mut compared = 0;
        for line in oracle.lines().filter(|l| !l.starts_with(['#', 't'])) {
            let v: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
            let elevation = v[1].to_radians();
            // There +z is up and the sun in the plane y = 0; the mirror image does not matter to the model.
            let day = Daylight {
                turbidity: v[0],
                albedo: [v[2] as f32; 3],
                to_sun: DVec3::new(elevation.cos(), elevation.sin(), 0.0),
                sky_scale: Some(1.0),
                sun_scale: None,
                ..day()
            };
            let (width, height) = (720, 361);
            let image = day.image(width, height).unwrap();
            let u = v[3].atan2(v[4]) / TAU;
            let column = ((u - u.floor()) * f64::from(width)).floor() as usize;
            let row = (v[5].acos() / PI * f64::from(height - 1)).round() as usize;
            for c in 0..3 {
                let ours = f64::from(image[3 * (row * width as usize + column) + c]);
                // The texel is up to a quarter of a degree away.
                let error = (ours - v[6 + c]).abs() / v[6 + c];
                assert!(error < 0.02, "{line}: {ours}");
            }
            compared += 1;
        }
        assert_eq!(compared, 15);
    }
}
