//! Values that several subcommands take, as text.

use std::time::Duration;

use glam::DVec3;

use crate::film::{Exposure, MAX_STOPS, Region};

/// A point or a direction as `X,Y,Z`.
pub fn parse_point(text: &str) -> Result<DVec3, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) if DVec3::new(x, y, z).is_finite() => Ok(DVec3::new(x, y, z)),
        _ => Err("a point is X,Y,Z in scene units, such as 0,1.5,-2".into()),
    }
}

/// A picture's size as `WIDTHxHEIGHT`.
pub fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let parts = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    match parts {
        Some([width, height]) if width > 0 && height > 0 => Ok([width, height]),
        _ => Err("a size is WIDTHxHEIGHT in pixels, such as 1280x720".into()),
    }
}

/// A part of a picture as `X,Y,WIDTH,HEIGHT`.
pub fn parse_crop(text: &str) -> Result<Region, String> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, width, height]) => Ok(Region::new(x, y, width, height)),
        _ => Err("a part is X,Y,WIDTH,HEIGHT in pixels, such as 0,0,640,360".into()),
    }
}

/// A duration such as `30s`, `1.5m`, `2h`, or plain seconds.
pub fn parse_duration(text: &str) -> Result<Duration, String> {
    let (number, unit) = match text.find(|c: char| c.is_ascii_alphabetic()) {
        Some(at) => text.split_at(at),
        None => (text, "s"),
    };
    let factor = match unit {
        "ms" => 1e-3,
        "s" => 1.0,
        "m" | "min" => 60.0,
        "h" => 3600.0,
        _ => return Err("a duration is a number with s, m or h, such as 30s".into()),
    };
    let seconds = number.parse::<f64>().map_err(|_| "a duration is a number with s, m or h, such as 30s")?;
    Duration::try_from_secs_f64(seconds * factor).map_err(|error| error.to_string())
}

/// A probability, above 0 and at most 1.
pub fn parse_probability(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(value) if value > 0.0 && value <= 1.0 => Ok(value),
        _ => Err("a probability is a number above 0 and at most 1, such as 0.3".into()),
    }
}

/// An exposure in stops.
pub fn parse_stops(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(stops) if stops.abs() <= MAX_STOPS => Ok(stops),
        _ => Err(format!("an exposure is a number of stops from -{MAX_STOPS} to {MAX_STOPS}, such as -1.5")),
    }
}

/// An exposure in stops, or `auto`.
pub fn parse_exposure(text: &str) -> Result<Exposure, String> {
    match text {
        "auto" => Ok(Exposure::Auto),
        _ => parse_stops(text).map(Exposure::Stops).map_err(|error| format!("{error}, or auto")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_as_users_write_them() {
        assert_eq!(parse_size("1280x720"), Ok([1280, 720]));
        assert_eq!(parse_crop("0, 1,640,360"), Ok(Region::new(0, 1, 640, 360)));
        assert_eq!(parse_point("0,1.5, -2e3"), Ok(DVec3::new(0.0, 1.5, -2e3)));
        assert_eq!(parse_probability("1"), Ok(1.0));
        assert_eq!(parse_stops("-1.5"), Ok(-1.5));
        assert_eq!(parse_exposure("100"), Ok(Exposure::Stops(100.0)));
        assert_eq!(parse_exposure("auto"), Ok(Exposure::Auto));
        for (text, seconds) in [("30s", 30.0), ("1.5m", 90.0), ("2h", 7200.0), ("250ms", 0.25), ("7", 7.0)] {
            assert_eq!(parse_duration(text), Ok(Duration::from_secs_f64(seconds)), "{text}");
        }
    }

    #[test]
    fn what_is_no_value_is_refused_with_an_example() {
        for text in ["0x4", "4", "4x", "-4x4", "4x4x4"] {
            assert!(parse_size(text).unwrap_err().contains("1280x720"), "{text}");
        }
        for text in ["0,0,8", "0,0,8,-8", "0,0,8,8,8"] {
            assert!(parse_crop(text).unwrap_err().contains("0,0,640,360"), "{text}");
        }
        for text in ["1,2", "1,2,inf", "1,2,x", "1,2,3,4"] {
            assert!(parse_point(text).unwrap_err().contains("0,1.5,-2"), "{text}");
        }
        for text in ["s", "3d", "one minute"] {
            assert!(parse_duration(text).unwrap_err().contains("30s"), "{text}");
        }
        assert!(parse_duration("-3s").is_err() && parse_duration("nan").is_err());
        for text in ["nan", "inf", "-100.5", "200", "1e39", "bright"] {
            assert!(parse_stops(text).unwrap_err().contains("-100 to 100"), "{text}");
            assert!(parse_exposure(text).unwrap_err().contains("auto"), "{text}");
        }
        for text in ["0", "1.5", "nan", "half"] {
            assert!(parse_probability(text).unwrap_err().contains("0.3"), "{text}");
        }
    }
}
