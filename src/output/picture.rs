//! Pictures in memory: pixels, rectangles, text, rows of labelled pictures.

use super::font;

const TEXT: [u8; 3] = [235, 235, 235];
const PAPER: [u8; 3] = [24, 24, 28];
/// Space around text and between tiles, in pixels.
const GAP: u32 = 4;

/// What the colours of [`super::difference`] mean.
pub const DIFFERENCE_LEGEND: [(&str, [u8; 3]); 5] = [
    ("on edge", [255, 214, 0]),
    ("acne", [255, 40, 30]),
    ("leak", [40, 110, 255]),
    ("lost", [255, 40, 255]),
    ("undecided", [52, 96, 60]),
];

/// An RGB image, sRGB, 8 bits a channel.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Three bytes a pixel, row 0 at the top.
    pub rgb: Vec<u8>,
}

impl Picture {
    /// A picture of one colour.
    pub fn filled(width: u32, height: u32, color: [u8; 3]) -> Picture {
        Picture { width, height, rgb: color.repeat(width as usize * height as usize) }
    }

    /// The colour of a pixel; `None` outside.
    pub fn get(&self, x: u32, y: u32) -> Option<[u8; 3]> {
        let at = self.index(x, y)?;
        self.rgb.get(at..at + 3)?.try_into().ok()
    }

    /// Sets a pixel; does nothing outside.
    pub fn set(&mut self, x: u32, y: u32, color: [u8; 3]) {
        if let Some(pixel) = self.index(x, y).and_then(|at| self.rgb.get_mut(at..at + 3)) {
            pixel.copy_from_slice(&color);
        }
    }

    /// Fills a rectangle; what lies outside is left out.
    pub fn fill(&mut self, x: u32, y: u32, width: u32, height: u32, color: [u8; 3]) {
        for py in y..y.saturating_add(height).min(self.height) {
            for px in x..x.saturating_add(width).min(self.width) {
                self.set(px, py, color);
            }
        }
    }

    /// Copies `other` with its upper left corner at (x, y); what lies outside is left out.
    pub fn paste(&mut self, other: &Picture, x: u32, y: u32) {
        for oy in 0..other.height {
            for ox in 0..other.width {
                if let Some(color) = other.get(ox, oy) {
                    self.set(x.saturating_add(ox), y.saturating_add(oy), color);
                }
            }
        }
    }

    /// Draws `text` with its upper left corner at (x, y), each font pixel `scale` pixels wide. Characters outside
    /// printable ASCII appear as a box. Returns the x after the text.
    pub fn text(&mut self, x: u32, y: u32, scale: u32, color: [u8; 3], text: &str) -> u32 {
        let mut left = x;
        for c in text.chars() {
            for (row, bits) in font::glyph(c).iter().enumerate() {
                for column in (0..font::WIDTH).filter(|column| bits >> (font::WIDTH - 1 - column) & 1 != 0) {
                    self.fill(left + column * scale, y + row as u32 * scale, scale, scale, color);
                }
            }
            left = left.saturating_add(font::ADVANCE * scale);
        }
        left
    }

    /// The picture with a strip below it that names `entries` by coloured boxes, in as many rows as are needed.
    pub fn with_legend<S: AsRef<str>>(&self, entries: &[(S, [u8; 3])]) -> Picture {
        let scale = text_scale(self.width);
        let (line, swatch) = (font::HEIGHT * scale, font::HEIGHT * scale);
        let mut places = Vec::new();
        let (mut x, mut y) = (GAP, GAP);
        for (name, _) in entries {
            let width = swatch + GAP + text_width(name.as_ref(), scale) + 2 * GAP;
            if x > GAP && x + width > self.width {
                (x, y) = (GAP, y + line + GAP);
            }
            places.push((x, y));
            x += width;
        }
        let mut out = Picture::filled(self.width, self.height + y + line + GAP, PAPER);
        out.paste(self, 0, 0);
        for ((name, color), (x, y)) in entries.iter().zip(places) {
            out.fill(x, self.height + y, swatch, line, *color);
            out.text(x + swatch + GAP, self.height + y, scale, TEXT, name.as_ref());
        }
        out
    }

    fn index(&self, x: u32, y: u32) -> Option<usize> {
        (x < self.width && y < self.height).then(|| 3 * (y as usize * self.width as usize + x as usize))
    }
}

/// Places pictures with their labels above them in a grid of `columns` columns (0: all in one row). Every cell is as
/// large as the largest picture; labels that do not fit are cut.
pub fn side_by_side(tiles: &[(&str, &Picture)], columns: usize) -> Picture {
    let columns = if columns == 0 { tiles.len() } else { columns.min(tiles.len()) }.max(1) as u32;
    let rows = (tiles.len() as u32).div_ceil(columns);
    let width = tiles.iter().map(|(_, p)| p.width).max().unwrap_or(0);
    let height = tiles.iter().map(|(_, p)| p.height).max().unwrap_or(0);
    let scale = text_scale(width);
    let bar = font::HEIGHT * scale + 2 * GAP;
    let mut out = Picture::filled(columns * (width + GAP) + GAP, rows * (height + bar) + GAP, PAPER);
    for (k, (label, picture)) in tiles.iter().enumerate() {
        let (column, row) = (k as u32 % columns, k as u32 / columns);
        let (x, y) = (GAP + column * (width + GAP), row * (height + bar));
        let fitting: String = label.chars().take((width / (font::ADVANCE * scale)) as usize).collect();
        out.text(x, y + GAP, scale, TEXT, &fitting);
        out.paste(picture, x, y + bar);
    }
    out
}

/// Font pixels grow with the picture so that labels stay readable when it is shown smaller.
fn text_scale(width: u32) -> u32 {
    (width / 400 + 1).min(4)
}

fn text_width(text: &str, scale: u32) -> u32 {
    text.chars().count() as u32 * font::ADVANCE * scale
}
