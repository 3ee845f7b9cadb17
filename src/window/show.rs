//! What the picture shows.

use super::palette::STATES;
use crate::output::false_color::LEVELS;

/// The picture, or an inner state in false colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Show {
    Shaded,
    Visibility,
    Level,
    Page,
    State,
    Atlas,
}

const ALL: [Show; 6] = [Show::Shaded, Show::Visibility, Show::Level, Show::Page, Show::State, Show::Atlas];

impl Show {
    pub(super) fn name(self) -> &'static str {
        match self {
            Show::Shaded => "shaded",
            Show::Visibility => "visibility",
            Show::Level => "level of each pixel",
            Show::Page => "page of each pixel",
            Show::State => "state of each pixel's page",
            Show::Atlas => "atlas",
        }
    }

    /// Whether it needs a method with pages.
    pub(super) fn of_pages(self) -> bool {
        !matches!(self, Show::Shaded | Show::Visibility)
    }

    /// The word that `window/shade.comp` knows it by.
    pub(super) fn word(self) -> u32 {
        ALL.iter().position(|&show| show == self).unwrap_or(0) as u32
    }

    /// The next or the one before, of those that a method with or without pages has.
    pub(super) fn step(self, forward: bool, pages: bool) -> Show {
        let count = if pages { ALL.len() } else { 2 };
        let at = (self.word() as usize).min(count - 1);
        ALL[(at + if forward { 1 } else { count - 1 }) % count]
    }

    /// What its colours mean.
    pub(super) fn legend(self, levels: &[u32]) -> Vec<(String, [u8; 3])> {
        match self {
            Show::State => STATES.map(|(name, color)| (name.to_owned(), color)).to_vec(),
            Show::Level | Show::Atlas => {
                levels.iter().map(|&level| (format!("{level}"), LEVELS[level as usize % LEVELS.len()])).collect()
            }
            _ => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_go_round_those_of_the_method() {
        let round = |pages: bool, forward: bool| {
            std::iter::successors(Some(Show::Shaded), move |show| Some(show.step(forward, pages)))
        };
        assert_eq!(round(true, true).take(7).collect::<Vec<_>>(), [&ALL[..], &ALL[..1]].concat());
        assert_eq!(round(true, false).nth(1), Some(Show::Atlas));
        assert_eq!(round(false, true).take(3).collect::<Vec<_>>(), [Show::Shaded, Show::Visibility, Show::Shaded]);
        assert_eq!(Show::Atlas.step(true, false), Show::Shaded);
        assert!((0..).zip(ALL).all(|(word, show)| show.word() == word));
    }
}
