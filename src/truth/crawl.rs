//! How much shadows flicker from one frame to the next beyond what the reference does.

use super::{Reference, TruthError, metrics};

/// Flips between two consecutive frames, in percent of the pixels that are decided in both; all 0 when there is none.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Crawl {
    /// Pixels whose visibility, lit at 0.5 and above, changes in the result.
    pub flips: f64,
    /// The same in the reference.
    pub reference_flips: f64,
    /// Pixels that change in the result and not in the reference.
    pub crawl: f64,
    /// Pixels that are decided in both frames.
    pub decided_pixels: u64,
}

/// Several lights as one: shares of all their decided pixels.
impl std::iter::Sum for Crawl {
    fn sum<I: Iterator<Item = Self>>(lights: I) -> Self {
        let add = |a: Self, b: Self| {
            let decided_pixels = a.decided_pixels + b.decided_pixels;
            let mean = |x: f64, y: f64| {
                (x * a.decided_pixels as f64 + y * b.decided_pixels as f64) / decided_pixels.max(1) as f64
            };
            Self {
                flips: mean(a.flips, b.flips),
                reference_flips: mean(a.reference_flips, b.reference_flips),
                crawl: mean(a.crawl, b.crawl),
                decided_pixels,
            }
        };
        lights.fold(Self::default(), add)
    }
}

/// One frame: what a method computed, one value a pixel, 1 lit, 0 shadowed; and the reference.
type Frame<'a> = (&'a [f32], &'a Reference);

/// Compares two consecutive frames pixel by pixel. Pixels with n.l <= 0 or out of the light's reach count as shadowed, as in
/// [`super::compare`].
///
/// Fails as [`super::compare`] does for either frame, and when the frames differ in size.
pub fn crawl(before: Frame, after: Frame) -> Result<Crawl, TruthError> {
    let sizes = [before, after].map(|(_, reference)| [reference.width, reference.height]);
    if sizes[0] != sizes[1] {
        let [[w0, h0], [w1, h1]] = sizes;
        return Err(TruthError::new(format!("the frames have {w0}x{h0} and {w1}x{h1} pixels, the same is needed")));
    }
    for (result, reference) in [before, after] {
        metrics::check(result, reference)?;
    }
    let lit = |(result, reference): Frame, i: usize| reference.facing[i] && result[i] >= 0.5;
    let truth = |(_, reference): Frame, i: usize| reference.visibility[i] != 0;
    let (mut decided, mut flips, mut reference_flips, mut crawl) = (0u64, 0u64, 0u64, 0u64);
    for i in (0..after.0.len()).filter(|&i| before.1.decided[i] && after.1.decided[i]) {
        let flip = lit(before, i) != lit(after, i);
        let reference_flip = truth(before, i) != truth(after, i);
        decided += 1;
        flips += u64::from(flip);
        reference_flips += u64::from(reference_flip);
        crawl += u64::from(flip && !reference_flip);
    }
    let share = |n: u64| if decided == 0 { 0.0 } else { 100.0 * n as f64 / decided as f64 };
    Ok(Crawl {
        flips: share(flips),
        reference_flips: share(reference_flips),
        crawl: share(crawl),
        decided_pixels: decided,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A reference of one row; `None` is not decided.
    fn reference(pixels: &[Option<u8>]) -> Reference {
        Reference {
            width: pixels.len() as u32,
            height: 1,
            visibility: pixels.iter().map(|p| p.unwrap_or(0)).collect(),
            decided: pixels.iter().map(Option::is_some).collect(),
            hit: vec![true; pixels.len()],
            facing: vec![true; pixels.len()],
        }
    }

    fn of(before: Frame, after: Frame) -> Crawl {
        crawl(before, after).unwrap()
    }

    #[test]
    fn flips_are_told_from_crawl() {
        let first = reference(&[Some(1), Some(1), Some(0), Some(0), None]);
        let second = reference(&[Some(1), Some(0), Some(0), Some(1), Some(1)]);
        // pixel 0 crawls, 1 flips rightly, 2 crawls, 3 misses the reference's flip, 4 is not decided before
        let crawl = of((&[1.0, 1.0, 0.4, 0.0, 0.0], &first), (&[0.0, 0.0, 0.5, 0.0, 1.0], &second));
        assert_eq!(crawl, Crawl { flips: 75.0, reference_flips: 50.0, crawl: 50.0, decided_pixels: 4 });
    }

    #[test]
    fn the_reference_itself_does_not_crawl() {
        let (first, second) = (reference(&[Some(1), Some(0)]), reference(&[Some(0), Some(0)]));
        let crawl = of((&first.visibility_image(), &first), (&second.visibility_image(), &second));
        assert_eq!((crawl.flips, crawl.reference_flips, crawl.crawl), (50.0, 50.0, 0.0));
    }

    #[test]
    fn pixels_turned_away_are_shadowed_whatever_the_result_says() {
        let mut turned = reference(&[Some(0)]);
        turned.facing[0] = false;
        assert_eq!(of((&[1.0], &turned), (&[0.0], &turned)).flips, 0.0);
    }

    #[test]
    fn nothing_decided_is_no_flip() {
        let none = reference(&[None, None]);
        assert_eq!(of((&[0.0, 1.0], &none), (&[1.0, 0.0], &none)), Crawl::default());
    }

    #[test]
    fn lights_weigh_by_their_decided_pixels() {
        let one = Crawl { flips: 8.0, reference_flips: 4.0, crawl: 2.0, decided_pixels: 30 };
        let other = Crawl { flips: 0.0, reference_flips: 0.0, crawl: 6.0, decided_pixels: 10 };
        let sum: Crawl = [one, Crawl::default(), other].into_iter().sum();
        assert_eq!(sum, Crawl { flips: 6.0, reference_flips: 3.0, crawl: 3.0, decided_pixels: 40 });
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let (one, two) = (reference(&[Some(1)]), reference(&[Some(1), Some(1)]));
        assert!(crawl((&[1.0], &one), (&[1.0, 1.0], &two)).is_err());
        assert!(crawl((&[1.0], &one), (&[], &one)).is_err());
        assert!(crawl((&[f32::NAN], &one), (&[1.0], &one)).is_err());
    }
}
