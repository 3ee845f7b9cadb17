//! Text, numbers and pictures as parts of a page.

use std::fmt::Write;

/// Text that is shown as it is, in an element or in a quoted attribute.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\'' => out += "&#39;",
            _ => out.push(c),
        }
    }
    out
}

/// Puts each value in the place of its `{{name}}`, in one pass: what a value holds is not looked at again.
pub fn filled(template: &str, values: &[(&str, String)]) -> String {
    let mut out = String::new();
    for (i, piece) in template.split("{{").enumerate() {
        let place = (i > 0).then(|| piece.split_once("}}")).flatten();
        let value = place.and_then(|(name, rest)| Some((values.iter().find(|(n, _)| *n == name)?, rest)));
        match value {
            Some(((_, value), rest)) => {
                out += value;
                out += rest;
            }
            None => {
                out += if i > 0 { "{{" } else { "" };
                out += piece;
            }
        }
    }
    out
}

/// A cell of a table that sorts by its value rather than its text; one that is not finite sorts last.
pub fn number_cell(value: f64, text: &str) -> String {
    if value.is_finite() {
        format!("<td data-value=\"{value}\">{}</td>", escaped(text))
    } else {
        "<td data-value=\"\" title=\"nothing to measure it by\">–</td>".to_owned()
    }
}

/// A file as an address that holds it.
pub fn data_uri(media_type: &str, bytes: &[u8]) -> String {
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4 + 32);
    // writing to a string does not fail
    let _ = write!(out, "data:{media_type};base64,");
    base64(bytes, &mut out);
    out
}

/// RFC 4648 base64 with padding.
fn base64(bytes: &[u8], out: &mut String) {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for chunk in bytes.chunks(3) {
        let byte = |i: usize| u32::from(chunk.get(i).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for i in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * i) & 63) as usize];
            out.push(if i <= chunk.len() { digit.into() } else { '=' });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_leave_its_place() {
        assert_eq!(escaped("a < b & \"c\" > 'd'"), "a &lt; b &amp; &quot;c&quot; &gt; &#39;d&#39;");
        let nasty = escaped("<img src=x onerror=alert(1)>.glb");
        assert_eq!(nasty, "&lt;img src=x onerror=alert(1)&gt;.glb");
        assert_eq!(escaped("rmsm:bias=-3 ü"), "rmsm:bias=-3 ü");
    }

    #[test]
    fn values_take_their_places_once() {
        let values = [("a", "{{b}}".to_owned()), ("b", "2".to_owned())];
        assert_eq!(filled("x {{a}} y {{b}}{{b}} z", &values), "x {{b}} y 22 z");
        assert_eq!(filled("{{b}", &values), "{{b}");
        assert_eq!(filled("{{none}} {{b}}", &values), "{{none}} 2");
    }

    #[test]
    fn numbers_sort_by_all_their_digits() {
        assert_eq!(number_cell(0.123_456_789, "0.12"), "<td data-value=\"0.123456789\">0.12</td>");
        assert_eq!(number_cell(1e-9, "0.0000"), "<td data-value=\"0.000000001\">0.0000</td>");
        for value in [f64::INFINITY, f64::NAN] {
            assert!(number_cell(value, "inf").starts_with("<td data-value=\"\""), "{value}");
        }
    }

    /// The vectors of RFC 4648, section 10.
    #[test]
    fn base64_of_all_lengths() {
        for (bytes, text) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(data_uri("text/plain", bytes.as_bytes()), format!("data:text/plain;base64,{text}"));
        }
        assert_eq!(data_uri("a", &[0xfb, 0xff, 0xfe]), "data:a;base64,+//+");
    }
}
