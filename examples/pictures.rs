//! Used by tools/view_test. `pictures A.png B.png`: the mean difference of a channel and the share of pixels in which a channel
//! differs by more than 16, both in percent. `pictures A.png`: width, height and the mean of red, green and blue in percent.

use image::RgbImage;
use std::process::ExitCode;

/// Difference of a channel that is seen.
const SEEN: u8 = 16;

fn read(path: &str) -> Result<RgbImage, String> {
    image::open(path).map(|image| image.into_rgb8()).map_err(|error| format!("{path}: {error}"))
}

fn means(path: &str) -> Result<String, String> {
    let image = read(path)?;
    let pixels = f64::from(image.width()) * f64::from(image.height());
    let mean = |k: usize| image.pixels().map(|p| f64::from(p[k])).sum::<f64>() / pixels / 2.55;
    Ok(format!("{} {} {:.3} {:.3} {:.3}", image.width(), image.height(), mean(0), mean(1), mean(2)))
}

fn differences(a: &str, b: &str) -> Result<String, String> {
    let (first, second) = (read(a)?, read(b)?);
    if first.dimensions() != second.dimensions() {
        return Err(format!("{a} has {:?} pixels, {b} {:?}", first.dimensions(), second.dimensions()));
    }
    let channels = || first.as_raw().iter().zip(second.as_raw()).map(|(a, b)| a.abs_diff(*b));
    let pixels = first.pixels().zip(second.pixels());
    let seen = pixels.filter(|(a, b)| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > SEEN)).count();
    let mean = channels().map(f64::from).sum::<f64>() / channels().count() as f64;
    let share = 100.0 * seen as f64 / (first.width() as f64 * f64::from(first.height()));
    Ok(format!("{:.4} {share:.4}", mean / 2.55))
}

fn main() -> ExitCode {
    let files: Vec<_> = std::env::args().skip(1).collect();
    let said = match &files[..] {
        [a] => means(a),
        [a, b] => differences(a, b),
        _ => Err(format!("{} pictures were given, one or two are needed", files.len())),
    };
    match said {
        Ok(text) => {
            println!("{text}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
