//! The position of the sun at a location and time.
//!
//! Blanco-Muriel, Alarcon-Padilla, Lopez-Moratalla and Lara-Coira 2001, "Computing the Solar Vector": ecliptic, celestial and
//! local coordinates with the parallax, good to half a minute of arc between 1999 and 2015.

use glam::DVec3;

/// A location on the earth, and its local time.
#[derive(Clone, Copy, Debug)]
pub struct LocationAndTime {
    /// Degrees to the north.
    pub latitude: f64,
    /// Degrees to the east.
    pub longitude: f64,
    /// Hours that the local time is ahead of universal time.
    pub timezone: f64,
    /// Year, month and day of the Gregorian calendar.
    pub date: [i64; 3],
    /// Hour, minute and second.
    pub time: [f64; 3],
}

impl Default for LocationAndTime {
    /// Tokyo on an afternoon of July 2010, as in Mitsuba.
    fn default() -> LocationAndTime {
        LocationAndTime {
            latitude: 35.6894,
            longitude: 139.6917,
            timezone: 9.0,
            date: [2010, 7, 10],
            time: [15.0, 0.0, 0.0],
        }
    }
}

impl LocationAndTime {
    /// Polar angle from the zenith, and azimuth from the north towards the east, radians.
    pub fn sun(&self) -> (f64, f64) {
        let [year, month, day] = self.date;
        let [hour, minute, second] = self.time;
        let hours = hour - self.timezone + (minute + second / 60.0) / 60.0;
        // Julian day, by integer divisions that cut off.
        let early = (month - 14) / 12;
        let noon = 1461 * (year + 4800 + early) / 4 + 367 * (month - 2 - 12 * early) / 12
            - 3 * ((year + 4900 + early) / 100) / 4
            + day
            - 32075;
        let days = noon as f64 - 0.5 + hours / 24.0 - 2_451_545.0;

        let node = 2.1429 - 0.001_039_459_4 * days;
        let longitude = 4.895_063_0 + 0.017_202_791_698 * days;
        let anomaly = 6.240_060_0 + 0.017_201_969_9 * days;
        let ecliptic =
            longitude + 0.033_416_07 * anomaly.sin() + 0.000_348_94 * (2.0 * anomaly).sin()
                - 0.000_113_4
                - 0.000_020_3 * node.sin();
        let obliquity = 0.409_092_8 - 6.2140e-9 * days + 0.000_039_6 * node.cos();

        let ascension = (obliquity.cos() * ecliptic.sin()).atan2(ecliptic.cos());
        let declination = (obliquity.sin() * ecliptic.sin()).asin();

        let sidereal = 6.697_424_324_2 + 0.065_709_828_3 * days + hours;
        let hour_angle = (sidereal * 15.0 + self.longitude).to_radians() - ascension;
        let latitude = self.latitude.to_radians();
        let cos_zenith = latitude.cos() * hour_angle.cos() * declination.cos()
            + declination.sin() * latitude.sin();
        let zenith = cos_zenith.clamp(-1.0, 1.0).acos();
        let azimuth = (-hour_angle.sin())
            .atan2(declination.tan() * latitude.cos() - latitude.sin() * hour_angle.cos());
        // Mean radius of the earth over the astronomical unit.
        let parallax = 6371.01 / 149_597_890.0 * zenith.sin();
        (zenith + parallax, azimuth.rem_euclid(std::f64::consts::TAU))
    }

    /// Unit vector to the sun with +y up, -z to the north and +x to the east.
    pub fn to_sun(&self) -> DVec3 {
        let (zenith, azimuth) = self.sun();
        DVec3::new(
            azimuth.sin() * zenith.sin(),
            zenith.cos(),
            -azimuth.cos() * zenith.sin(),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(latitude: f64, longitude: f64, date: [i64; 3], hour: f64) -> (f64, f64) {
        let observer = LocationAndTime {
            latitude,
            longitude,
            timezone: 0.0,
            date,
            time: [hour, 0.0, 0.0],
        };
        let (zenith, azimuth) = observer.sun();
        (zenith.to_degrees(), azimuth.to_degrees())
    }

    /// Directions of Mitsuba 3.9.1's `sunsky`, there with the south along x, the west along y and z up.
    #[test]
    fn directions_are_those_of_another_renderer() {
        for (latitude, hour, expected) in [
            (35.6894, 15.0, [0.0513854, 0.691748, 0.720308]),
            (35.6894, 9.0, [0.0956952, -0.614786, 0.782867]),
            (-35.0, 12.0, [-0.84035, 0.0543873, 0.539308]),
        ] {
            let observer = LocationAndTime {
                latitude,
                time: [hour, 0.0, 0.0],
                ..LocationAndTime::default()
            };
            let [x, y, z] = expected;
            // Single precision there leaves some seconds of the day open.
            let error = (observer.to_sun() - DVec3::new(-y, z, x))
                .abs()
                .max_element();
            assert!(error < 5e-4, "{latitude} {hour}: {}", observer.to_sun());
        }
    }

    #[test]
    fn solstices_and_equinoxes() {
        // At noon of true solar time, which differs from the clock by the equation of time, below 17 minutes or 4.2 degrees.
        let (zenith, azimuth) = at(50.0, 0.0, [2010, 6, 21], 12.03);
        assert!((zenith - (50.0 - 23.44)).abs() < 0.05, "{zenith}");
        assert!((azimuth - 180.0).abs() < 0.5, "{azimuth}");
        let (zenith, _) = at(50.0, 0.0, [2010, 12, 21], 11.97);
        assert!((zenith - (50.0 + 23.44)).abs() < 0.05, "{zenith}");
        // The sun rises in the east and sets in the west at an equinox, wherever one is.
        for latitude in [0.0, 40.0, -30.0] {
            let (zenith, azimuth) = at(latitude, 0.0, [2010, 3, 20], 6.125);
            assert!(
                (zenith - 90.0).abs() < 0.6 && (azimuth - 90.0).abs() < 0.6,
                "{zenith} {azimuth}"
            );
            let (_, azimuth) = at(latitude, 0.0, [2010, 3, 20], 18.125);
            assert!((azimuth - 270.0).abs() < 0.6, "{azimuth}");
        }
        // South of the tropics the sun is in the north at noon.
        let (_, azimuth) = at(-35.0, 0.0, [2010, 6, 21], 12.03);
        assert!(!(1.0..=359.0).contains(&azimuth), "{azimuth}");
    }
}
