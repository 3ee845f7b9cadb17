//! How far a visibility image is from the reference, split by what kind of error it is.

use super::{Reference, TruthError};

/// Errors of one visibility image. Shares are in percent; of decided pixels where nothing else is said. All are 0 when no
/// pixel is decided.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Metrics {
    /// Decided pixels that differ from the reference.
    pub mismatch: f64,
    /// Differing decided pixels per decided edge pixel: 0 when nothing differs, infinite when something differs and the
    /// reference has no decided edge pixel.
    pub edge_error: f64,
    /// Decided pixels that differ and are not explained by an edge of both images within 1.5 px.
    pub off_edge: f64,
    /// The falsely shadowed part of `off_edge`.
    pub acne: f64,
    /// The falsely lit part of `off_edge`.
    pub leak: f64,
    /// Decided pixels shadowed in the reference with no shadowed result pixel within 1.5 px; a part of `leak`.
    pub lost: f64,
    /// Pixels that are decided.
    pub decided_pixels: u64,
    /// Decided pixels whose reference value differs from a 4-neighbour's.
    pub edge_pixels: u64,
    /// Decided pixels that differ from the reference.
    pub differing: u64,
    /// Pixels behind `off_edge`.
    pub off_edge_pixels: u64,
    /// Pixels behind `acne`.
    pub acne_pixels: u64,
    /// Pixels behind `leak`.
    pub leak_pixels: u64,
    /// Pixels behind `lost`.
    pub lost_pixels: u64,
}

/// What a pixel of a result is, seen against the reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PixelClass {
    /// No surface.
    Sky,
    /// A surface whose reference is not decided; never counted.
    Undecided,
    /// Decided, lit in both.
    Lit,
    /// Decided, shadowed in both.
    Shadowed,
    /// Decided and different, explained by an edge of both images within 1.5 px.
    OnEdge,
    /// Decided, falsely shadowed, not on an edge.
    Acne,
    /// Decided, falsely lit, not on an edge, with a shadowed result pixel within 1.5 px.
    Leak,
    /// Decided, falsely lit, with no shadowed result pixel within 1.5 px: also a leak.
    Lost,
}

/// Compares a visibility image (1 lit, 0 shadowed, lit at 0.5 and above) with the reference.
///
/// Pixels without a surface, with n.l <= 0 or out of the light's reach count as shadowed in both images, whatever `result`
/// holds there.
/// Fails when `result` is empty, has another size than the reference, or holds a value that is not finite.
pub fn compare(result: &[f32], reference: &Reference) -> Result<Metrics, TruthError> {
    let classes = classify(result, reference)?;
    let count = |class: PixelClass| classes.iter().filter(|&&c| c == class).count() as u64;
    let (acne_pixels, lost_pixels) = (count(PixelClass::Acne), count(PixelClass::Lost));
    let leak_pixels = count(PixelClass::Leak) + lost_pixels;
    let counts = Metrics {
        decided_pixels: reference.decided.iter().filter(|&&d| d).count() as u64,
        edge_pixels: edge_pixels(reference),
        differing: count(PixelClass::OnEdge) + acne_pixels + leak_pixels,
        off_edge_pixels: acne_pixels + leak_pixels,
        acne_pixels,
        leak_pixels,
        lost_pixels,
        ..Metrics::default()
    };
    Ok(counts.with_shares())
}

impl Metrics {
    /// The shares that follow from the counts.
    fn with_shares(self) -> Self {
        let decided = self.decided_pixels;
        let share = |n: u64| if decided == 0 { 0.0 } else { 100.0 * n as f64 / decided as f64 };
        Self {
            mismatch: share(self.differing),
            edge_error: match (self.differing, self.edge_pixels) {
                (0, _) => 0.0,
                (_, 0) => f64::INFINITY,
                (d, e) => 100.0 * d as f64 / e as f64,
            },
            off_edge: share(self.off_edge_pixels),
            acne: share(self.acne_pixels),
            leak: share(self.leak_pixels),
            lost: share(self.lost_pixels),
            ..self
        }
    }
}

/// Several images as one: the counts are summed, the shares are those of the sums.
impl std::iter::Sum for Metrics {
    fn sum<I: Iterator<Item = Self>>(images: I) -> Self {
        let add = |a: Self, b: Self| Self {
            decided_pixels: a.decided_pixels + b.decided_pixels,
            edge_pixels: a.edge_pixels + b.edge_pixels,
            differing: a.differing + b.differing,
            off_edge_pixels: a.off_edge_pixels + b.off_edge_pixels,
            acne_pixels: a.acne_pixels + b.acne_pixels,
            leak_pixels: a.leak_pixels + b.leak_pixels,
            lost_pixels: a.lost_pixels + b.lost_pixels,
            ..a
        };
        images.fold(Self::default(), add).with_shares()
    }
}

/// The class of every pixel; rules and errors as for [`compare`].
pub fn classify(result: &[f32], reference: &Reference) -> Result<Vec<PixelClass>, TruthError> {
    check(result, reference)?;
    let lit: Vec<bool> = result.iter().zip(&reference.facing).map(|(&v, &facing)| facing && v >= 0.5).collect();
    let truth = |i: usize| reference.visibility[i] != 0;
    let (width, height) = (reference.width as usize, reference.height as usize);
    let class = |i: usize| match (reference.hit[i], reference.decided[i], lit[i], truth(i)) {
        (false, ..) => PixelClass::Sky,
        (_, false, ..) => PixelClass::Undecided,
        (_, _, true, true) => PixelClass::Lit,
        (_, _, false, false) => PixelClass::Shadowed,
        (_, _, result_lit, reference_lit) => {
            let (x, y) = (i % width, i / width);
            // offsets with dx^2 + dy^2 <= 1.5^2 are the 3x3 neighbourhood
            let near = |matches: &dyn Fn(usize) -> bool| {
                (y.saturating_sub(1)..(y + 2).min(height))
                    .any(|ny| (x.saturating_sub(1)..(x + 2).min(width)).any(|nx| matches(ny * width + nx)))
            };
            let reference_follows = near(&|j| truth(j) == result_lit);
            let result_follows = near(&|j| lit[j] == reference_lit);
            match (reference_follows && result_follows, result_lit) {
                (true, _) => PixelClass::OnEdge,
                (false, false) => PixelClass::Acne,
                (false, true) if result_follows => PixelClass::Leak,
                (false, true) => PixelClass::Lost,
            }
        }
    };
    Ok((0..lit.len()).map(class).collect())
}

/// Root of the mean squared difference over the pixels with `counted`, for fractional visibility; 0 when none counts.
///
/// Fails when the lists differ in length, are empty, or hold a value that is not finite.
pub fn rmse(result: &[f32], reference: &[f32], counted: &[bool]) -> Result<f64, TruthError> {
    if result.is_empty() || result.len() != reference.len() || result.len() != counted.len() {
        return Err(TruthError::new(format!(
            "the images have {} and {} pixels and {} flags, the same number above 0 is needed",
            result.len(),
            reference.len(),
            counted.len()
        )));
    }
    check_finite(result)?;
    check_finite(reference)?;
    let squares =
        result.iter().zip(reference).zip(counted).filter(|(_, c)| **c).map(|((a, b), _)| f64::from(a - b).powi(2));
    let (sum, n) = squares.fold((0.0, 0u64), |(sum, n), s| (sum + s, n + 1));
    Ok(if n == 0 { 0.0 } else { (sum / n as f64).sqrt() })
}

fn edge_pixels(reference: &Reference) -> u64 {
    let (width, height) = (reference.width as usize, reference.height as usize);
    let v = &reference.visibility;
    let is_edge = |i: usize| {
        let (x, y) = (i % width, i / width);
        (x > 0 && v[i - 1] != v[i])
            || (x + 1 < width && v[i + 1] != v[i])
            || (y > 0 && v[i - width] != v[i])
            || (y + 1 < height && v[i + width] != v[i])
    };
    (0..v.len()).filter(|&i| reference.decided[i] && is_edge(i)).count() as u64
}

pub(super) fn check(result: &[f32], reference: &Reference) -> Result<(), TruthError> {
    let want = reference.width as usize * reference.height as usize;
    let lists = [
        ("the result", result.len()),
        ("the reference's visibility", reference.visibility.len()),
        ("the reference's decided list", reference.decided.len()),
        ("the reference's surface list", reference.hit.len()),
        ("the reference's facing list", reference.facing.len()),
    ];
    if let Some((name, len)) = lists.iter().find(|(_, len)| *len != want || want == 0) {
        return Err(TruthError::new(format!(
            "{name} has {len} pixels, {}x{} above 0 are needed",
            reference.width, reference.height
        )));
    }
    check_finite(result)
}

fn check_finite(image: &[f32]) -> Result<(), TruthError> {
    match image.iter().position(|v| !v.is_finite()) {
        Some(i) => Err(TruthError::new(format!("visibility of pixel {i} is {}, a finite number is needed", image[i]))),
        None => Ok(()),
    }
}
