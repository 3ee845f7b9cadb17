//! What keys do.

use winit::keyboard::{Key, KeyCode, NamedKey, PhysicalKey};

/// What a key asks for once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Command {
    Help,
    Overlay,
    /// The next method or the one before.
    Turn {
        forward: bool,
    },
    /// A method by its place.
    Method(usize),
    Exact,
    Filter,
    /// Finer or coarser pages.
    Bias {
        finer: bool,
    },
    /// Half or twice the atlas.
    Atlas {
        larger: bool,
    },
    Freeze,
    Show {
        forward: bool,
    },
    Play,
    Reset,
    Screenshot,
    Close,
}

/// The help: what to press, and for what.
pub(super) const HELP: [(&str, &str); 18] = [
    ("W A S D", "fly"),
    ("Q E", "down, up"),
    ("Shift", "faster"),
    ("wheel", "speed"),
    ("right drag", "look"),
    ("left drag, arrows", "sun"),
    ("R", "back to the first view"),
    ("Tab, 1 to 9", "method"),
    ("X", "exact on, off"),
    ("G", "filter"),
    ("- +", "coarser, finer (bias)"),
    (", .", "half, twice the atlas or map"),
    ("V, Shift+V", "what is shown"),
    ("F", "freeze the pages"),
    ("Space", "play, pause"),
    ("P, F12", "screenshot"),
    ("F1, F2", "help, numbers"),
    ("Esc", "close"),
];

/// The command of a key; letters by what is printed on them.
pub(super) fn command(key: &Key, shift: bool) -> Option<Command> {
    Some(match key {
        Key::Named(NamedKey::F1) => Command::Help,
        Key::Named(NamedKey::F2) => Command::Overlay,
        Key::Named(NamedKey::F12) => Command::Screenshot,
        Key::Named(NamedKey::Tab) => Command::Turn { forward: !shift },
        Key::Named(NamedKey::Space) => Command::Play,
        Key::Named(NamedKey::Escape) => Command::Close,
        Key::Character(text) => match text.to_lowercase().as_str() {
            "x" => Command::Exact,
            "g" => Command::Filter,
            "-" | "_" => Command::Bias { finer: false },
            "+" | "=" => Command::Bias { finer: true },
            "," | "<" => Command::Atlas { larger: false },
            "." | ">" => Command::Atlas { larger: true },
            "v" => Command::Show { forward: !shift },
            "f" => Command::Freeze,
            "r" => Command::Reset,
            "p" => Command::Screenshot,
            digit => match digit.parse() {
                Ok(place @ 1..=9) => Command::Method(place - 1),
                _ => return None,
            },
        },
        _ => return None,
    })
}

/// Keys that act as long as they are held.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Held(u32);

impl Held {
    pub(super) const FORWARD: Held = Held(1);
    pub(super) const BACK: Held = Held(1 << 1);
    pub(super) const LEFT: Held = Held(1 << 2);
    pub(super) const RIGHT: Held = Held(1 << 3);
    pub(super) const UP: Held = Held(1 << 4);
    pub(super) const DOWN: Held = Held(1 << 5);
    pub(super) const FAST: Held = Held(1 << 6);
    pub(super) const SUN_LEFT: Held = Held(1 << 7);
    pub(super) const SUN_RIGHT: Held = Held(1 << 8);
    pub(super) const SUN_UP: Held = Held(1 << 9);
    pub(super) const SUN_DOWN: Held = Held(1 << 10);

    /// What a key does while it is held: those of flight by their place, so that they lie together on any keyboard.
    pub(super) fn of(key: &Key, place: PhysicalKey) -> Option<Held> {
        let code = match (key, place) {
            (Key::Named(NamedKey::ArrowLeft), _) => return Some(Held::SUN_LEFT),
            (Key::Named(NamedKey::ArrowRight), _) => return Some(Held::SUN_RIGHT),
            (Key::Named(NamedKey::ArrowUp), _) => return Some(Held::SUN_UP),
            (Key::Named(NamedKey::ArrowDown), _) => return Some(Held::SUN_DOWN),
            (Key::Named(NamedKey::Shift), _) => return Some(Held::FAST),
            (_, PhysicalKey::Code(code)) => code,
            _ => return None,
        };
        Some(match code {
            KeyCode::KeyW => Held::FORWARD,
            KeyCode::KeyS => Held::BACK,
            KeyCode::KeyA => Held::LEFT,
            KeyCode::KeyD => Held::RIGHT,
            KeyCode::KeyE => Held::UP,
            KeyCode::KeyQ => Held::DOWN,
            _ => return None,
        })
    }

    /// What either holds.
    pub(super) fn and(self, other: Held) -> Held {
        Held(self.0 | other.0)
    }

    pub(super) fn has(self, key: Held) -> bool {
        self.0 & key.0 != 0
    }

    pub(super) fn set(&mut self, key: Held, down: bool) {
        self.0 = if down { self.0 | key.0 } else { self.0 & !key.0 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn typed(text: &str) -> Option<Command> {
        command(&Key::Character(text.into()), false)
    }

    #[test]
    fn letters_mean_the_same_with_caps_lock() {
        for (small, large) in [("x", "X"), ("v", "V"), ("p", "P"), ("f", "F")] {
            assert!(typed(small).is_some() && typed(small) == typed(large), "{small}");
        }
        assert_eq!(command(&Key::Character("V".into()), true), Some(Command::Show { forward: false }));
        assert_eq!([typed("1"), typed("9")], [Some(Command::Method(0)), Some(Command::Method(8))]);
        assert_eq!(["0", "y", "", "10"].map(typed), [None; 4]);
    }

    /// A key that flies asks for nothing else.
    #[test]
    fn no_key_does_two_things() {
        for letter in ["w", "a", "s", "d", "q", "e"] {
            assert_eq!(typed(letter), None, "{letter}");
        }
    }

    /// Every key that the help names does something.
    #[test]
    fn the_help_is_true() {
        let named = |key: &str| match key {
            "Tab" => NamedKey::Tab,
            "Space" => NamedKey::Space,
            "Esc" => NamedKey::Escape,
            "F1" => NamedKey::F1,
            "F2" => NamedKey::F2,
            "F12" => NamedKey::F12,
            other => panic!("{other}"),
        };
        for (keys, _) in &HELP[6..] {
            for key in keys.split([' ', ',']).filter(|key| !key.is_empty() && !["to", "Shift+V"].contains(key)) {
                let pressed = if key.len() == 1 { Key::Character(key.into()) } else { Key::Named(named(key)) };
                assert!(command(&pressed, false).is_some(), "{key}");
            }
        }
        for key in [",", "."] {
            assert!(typed(key).is_some());
        }
    }

    #[test]
    fn held_keys_are_told_apart() {
        let mut held = Held::default();
        held.set(Held::FORWARD, true);
        held.set(Held::FAST, true);
        held.set(Held::FORWARD, false);
        assert!(held.has(Held::FAST) && !held.has(Held::FORWARD) && !held.has(Held::BACK));
    }
}
