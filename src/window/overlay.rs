//! Text over the picture: panels of lines, drawn on the CPU.

use crate::output::font;

const TEXT: [u8; 3] = [240, 240, 240];
const PANEL: [u8; 3] = [12, 12, 16];
/// Opacity of a panel.
const SHADE: u8 = 190;
/// Space around lines and between them, in font pixels.
const GAP: u32 = 3;

/// Where a panel lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Corner {
    TopLeft,
    BottomLeft,
    Middle,
}

/// A line, with a box of a colour before it where it is part of a legend.
pub(super) type Line = (String, Option<[u8; 3]>);

/// An RGBA image; nothing where alpha is 0.
pub(super) struct Overlay {
    size: [u32; 2],
    words: Vec<u32>,
    /// Pixels of a font pixel.
    scale: u32,
}

impl Overlay {
    pub(super) fn new(size: [u32; 2]) -> Self {
        // readable on large screens, and room for numbers in small windows
        let scale = (size[1] / 360).clamp(1, 4);
        Self { size, words: vec![0; size[0] as usize * size[1] as usize], scale }
    }

    /// The image, row by row.
    pub(super) fn words(&self) -> &[u32] {
        &self.words
    }

    /// Draws lines on a panel; long ones go on in the next line, and what has no room is left out.
    pub(super) fn panel(&mut self, corner: Corner, lines: &[Line]) {
        if lines.is_empty() {
            return;
        }
        let (gap, advance, row) = (GAP * self.scale, font::ADVANCE * self.scale, (font::HEIGHT + GAP) * self.scale);
        let room = (self.size[0].saturating_sub(4 * gap) / advance) as usize;
        let lines: Vec<_> = lines.iter().flat_map(|line| wrapped(line, room)).collect();
        let letters = |(text, swatch): &Line| text.chars().count() + if swatch.is_some() { 2 } else { 0 };
        let widest = lines.iter().map(letters).max().unwrap_or(0) as u32;
        let (width, height) = (widest * advance + 2 * gap, lines.len() as u32 * row + gap);
        let [left, top] = match corner {
            Corner::TopLeft => [gap, gap],
            Corner::BottomLeft => [gap, self.size[1].saturating_sub(height + gap)],
            Corner::Middle => [self.size[0].saturating_sub(width) / 2, self.size[1].saturating_sub(height) / 2],
        };
        self.fill([left, top], [width, height], PANEL, SHADE);
        for (i, (text, swatch)) in lines.iter().enumerate() {
            let y = top + gap + i as u32 * row;
            let mut x = left + gap;
            if let Some(color) = swatch {
                let side = font::HEIGHT * self.scale;
                self.fill([x, y], [side, side], *color, 255);
                x += 2 * advance;
            }
            self.text([x, y], text);
        }
    }

    fn text(&mut self, [x, y]: [u32; 2], text: &str) {
        for (i, c) in text.chars().enumerate() {
            let left = x + i as u32 * font::ADVANCE * self.scale;
            for (row, bits) in font::glyph(c).iter().enumerate() {
                for column in (0..font::WIDTH).filter(|column| bits >> (font::WIDTH - 1 - column) & 1 != 0) {
                    let at = [left + column * self.scale, y + row as u32 * self.scale];
                    self.fill(at, [self.scale; 2], TEXT, 255);
                }
            }
        }
    }

    /// Fills a rectangle; what lies outside is left out.
    fn fill(&mut self, [x, y]: [u32; 2], [width, height]: [u32; 2], [r, g, b]: [u8; 3], alpha: u8) {
        let word = u32::from_le_bytes([r, g, b, alpha]);
        let [left, right] = [x, x.saturating_add(width)].map(|x| x.min(self.size[0]) as usize);
        for row in y..y.saturating_add(height).min(self.size[1]) {
            let first = row as usize * self.size[0] as usize;
            self.words[first + left..first + right].fill(word);
        }
    }
}

/// The line in pieces of at most `room` letters, broken between words where there are any; later pieces are indented.
fn wrapped((text, swatch): &Line, room: usize) -> Vec<Line> {
    let room = room.saturating_sub(if swatch.is_some() { 2 } else { 0 }).max(8);
    let mut pieces = vec![String::new()];
    for word in text.split(' ') {
        let piece = pieces.last().map_or(0, |piece| piece.chars().count());
        if piece > 0 && piece + 1 + word.chars().count() > room {
            pieces.push(format!(" {word}"));
        } else if let Some(last) = pieces.last_mut() {
            if piece > 0 {
                last.push(' ');
            }
            last.push_str(word);
        }
    }
    pieces.into_iter().map(|piece| (piece.chars().take(room).collect(), *swatch)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(size: [u32; 2], corner: Corner, text: &str) -> Overlay {
        let mut overlay = Overlay::new(size);
        overlay.panel(corner, &[(text.to_owned(), None)]);
        overlay
    }

    #[test]
    fn panels_lie_in_their_corners() {
        let at = |overlay: &Overlay, x: u32, y: u32| overlay.words[(y * overlay.size[0] + x) as usize] >> 24;
        let top = drawn([100, 60], Corner::TopLeft, "i");
        assert!(at(&top, 4, 4) > 0 && at(&top, 4, 55) == 0 && at(&top, 99, 0) == 0);
        let bottom = drawn([100, 60], Corner::BottomLeft, "i");
        assert!(at(&bottom, 4, 55) > 0 && at(&bottom, 4, 4) == 0);
        let middle = drawn([100, 60], Corner::Middle, "i");
        assert!(at(&middle, 50, 30) > 0 && at(&middle, 4, 4) == 0);
        assert!(drawn([100, 60], Corner::Middle, "").words.iter().all(|word| word >> 24 != 255), "no letter");
    }

    #[test]
    fn no_size_is_too_small() {
        for size in [[1, 1], [3, 200], [200, 3], [16, 16]] {
            for corner in [Corner::TopLeft, Corner::BottomLeft, Corner::Middle] {
                drawn(size, corner, "many words and averyveryverylongone");
            }
        }
    }

    #[test]
    fn long_lines_go_on_in_the_next() {
        let line = ("one two three four".to_owned(), None);
        let texts = |room| wrapped(&line, room).into_iter().map(|(text, _)| text).collect::<Vec<_>>();
        assert_eq!(texts(99), ["one two three four"]);
        assert_eq!(texts(9), ["one two", " three", " four"]);
    }
}
