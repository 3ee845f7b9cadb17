//! The command that was typed, in words that a POSIX shell takes back.

/// The command of this process, with `umbrage` for the program.
pub fn this_command() -> String {
    let arguments = std::env::args_os().skip(1);
    let words = arguments.map(|argument| quoted(&argument.to_string_lossy()));
    std::iter::once("umbrage".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}

/// A word in quotes where a shell would otherwise read more than a word in it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=,+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn plain_words_stay_as_they_are() {
        for word in
            ["compare", "../scenes/town.glb", "--methods", "rmsm:bias=-3,uniform", "resolution=512..8192", "+@%_"]
        {
            assert_eq!(quoted(word), word);
        }
    }

    #[test]
    fn what_means_something_to_a_shell_is_quoted() {
        assert_eq!(quoted(""), "''");
        assert_eq!(quoted("my town.glb"), "'my town.glb'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
        assert_eq!(quoted("größe"), "'größe'");
        for word in
            ["a;b", "$HOME", "`id`", "a\nb", "*", "~", "#a", "<img src=x onerror=alert(1)>.glb", "a\\b", "\"", "!"]
        {
            assert_eq!(quoted(word), format!("'{word}'"));
        }
    }

    /// A shell gives back the very words.
    #[test]
    #[cfg(unix)]
    fn a_shell_takes_them_back() {
        let words = ["", "it's", "a  b", "$HOME `id` \\ \"", "new\nline", "<img src=x onerror=alert(1)>.glb", "-n"];
        let line = words.map(quoted).join(" ");
        let script = format!("printf '%s\\0' {line}");
        let output = std::process::Command::new("sh").args(["-c", &script]).output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        assert_eq!(text.split_terminator('\0').collect::<Vec<_>>(), words);
    }
}
