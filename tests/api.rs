//! The public surface of the library, as `api.txt` has it: what `src/lib.rs` re-exports for hosts, with fields, variants and
//! signatures. A change of it shows in review; `UPDATE_API=1 cargo test --test api` writes the file anew.

use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Before free functions.
const FREE: &str = "free ";

/// All source files below a folder, in order.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    let found = entries.into_iter().flat_map(|path| if path.is_dir() { sources(&path) } else { vec![path] });
    found.filter(|path| path.extension().is_some_and(|e| e == "rs")).collect()
}

/// Names that `pub use` of the root module gives, those of the lab left out.
fn names() -> Vec<String> {
    let text = fs::read_to_string(root().join("src/lib.rs")).unwrap();
    let uses = text.split("\npub use ").skip(1).map(|rest| rest.split(';').next().unwrap().to_owned());
    let list = uses.flat_map(|path| {
        let (_, tail) = path.rsplit_once("::").unwrap_or(("", path.as_str()));
        let inside =
            path.split_once('{').map_or(tail.to_owned(), |(_, list)| list.trim_end_matches(['}', '\n', ' ']).into());
        inside.split(',').map(|name| name.trim().to_owned()).filter(|n| !n.is_empty()).collect::<Vec<_>>()
    });
    let mut list: Vec<String> = list.collect();
    list.sort();
    list
}

/// Code without comments, attributes and bodies of functions, one item a line; free functions begin with a mark.
fn items(text: &str) -> Vec<String> {
    let mut out = Vec::new();
    let mut item = String::new();
    let code = text.lines().filter(|l| !l.trim_start().starts_with("//") && !l.trim_start().starts_with("#["));
    let mut lines = code.map(|line| (line.starts_with("pub") && line.contains("fn "), line.trim()));
    while let Some((free, line)) = lines.next() {
        if item.is_empty() && !line.starts_with("pub ") && !line.starts_with("impl") {
            continue;
        }
        if free {
            item.push_str(FREE);
        }
        item.push_str(line);
        item.push(' ');
        let ends = line.ends_with('{') || line.ends_with(';') || line.ends_with("},") || line.ends_with('}');
        let field =
            line.ends_with(',') && !item.contains("fn ") && !item.contains("struct ") && !item.contains("enum ");
        if ends || field {
            if item.contains("enum ") && line.ends_with('{') {
                // variants belong to it
                for (_, line) in lines.by_ref().take_while(|(_, l)| *l != "}") {
                    item.push_str(line);
                    item.push(' ');
                }
            }
            out.push(item.trim_end_matches([' ', '{', ';', ',']).trim().to_owned());
            item.clear();
        }
    }
    out
}

/// The listing: each name with its definition, then public fields and functions.
fn listing() -> String {
    let library = ["camera.rs", "casters.rs", "config.rs", "error.rs", "host.rs", "light.rs", "engine", "gpu"];
    let files = library.iter().flat_map(|name| {
        let path = root().join("src").join(name);
        if path.is_dir() { sources(&path) } else { vec![path] }
    });
    let all: Vec<String> = files.flat_map(|file| items(&fs::read_to_string(file).unwrap())).collect();
    let mut out = String::new();
    for name in names() {
        let word = |text: &str, kind: &str| {
            text.split(kind)
                .nth(1)
                .is_some_and(|rest| rest.split(|c: char| !c.is_alphanumeric() && c != '_').next() == Some(&name))
        };
        let defines = |item: &&String| {
            item.trim_start_matches(FREE).starts_with("pub ")
                && ["struct ", "enum ", " fn ", "const "].iter().any(|kind| word(item, kind))
        };
        let at = all.iter().position(|item| defines(&item)).unwrap_or_else(|| panic!("{name} is defined nowhere"));
        out.push_str(&format!("{}\n", all[at].trim_start_matches(FREE)));
        // fields follow the struct
        let fields =
            all[at + 1..].iter().take_while(|i| i.starts_with("pub ") && !i.contains("fn ") && !i.contains("struct "));
        let fields = fields.filter(|i| i.contains(": ") && !i.starts_with("pub const") && !i.starts_with("pub static"));
        if all[at].contains("struct ") && !all[at].contains('(') {
            fields.for_each(|field| out.push_str(&format!("    {}\n", &field[4..])));
        }
        let mut own = false;
        for item in &all {
            if item.starts_with("impl") {
                let of = item.trim_start_matches("impl").trim_start_matches("<'_>").trim();
                own = of.split(['<', ' ']).next() == Some(&name) && !item.contains(" for ");
            } else if own && (item.contains("fn ") || item.starts_with("pub const ")) && item.starts_with("pub ") {
                out.push_str(&format!("    {}\n", &item[4..]));
            } else if !item.contains("fn ") && !item.starts_with("pub const ") {
                own = false;
            }
        }
        out.push('\n');
    }
    out
}

#[test]
fn the_surface_is_the_committed_one() {
    let file = root().join("api.txt");
    let now = listing();
    if std::env::var_os("UPDATE_API").is_some() {
        fs::write(&file, &now).unwrap();
    }
    let before = fs::read_to_string(&file).unwrap_or_default();
    let (old, new): (Vec<_>, Vec<_>) = (before.lines().collect(), now.lines().collect());
    let gone: Vec<_> = old.iter().filter(|line| !new.contains(line)).collect();
    let added: Vec<_> = new.iter().filter(|line| !old.contains(line)).collect();
    assert!(before == now, "api.txt: gone {gone:#?}, added {added:#?}; UPDATE_API=1 writes it anew");
}

/// Defaults are documented where a host looks for them: at each field.
#[test]
fn documented_defaults_are_those_of_the_code() {
    let source = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/src/config.rs")).unwrap();
    let values = format!("{:?}", umbrage::Config::new([1, 1]));
    let mut lines = source.lines().map(str::trim);
    let mut checked = 0;
    while let Some(line) = lines.next() {
        let Some(documented) = line.strip_prefix("/// Default: ").and_then(|rest| rest.strip_suffix('.')) else {
            continue;
        };
        let field = lines.next().and_then(|line| line.strip_prefix("pub ")).expect("a field follows its default");
        let name = field.split(':').next().unwrap();
        let value = values.split(&format!("{name}: ")).nth(1).unwrap().split([',', ' ']).next().unwrap();
        let documented = match documented {
            "64 MiB" => (64u64 << 20).to_string(),
            "that of 32768" => umbrage::Config::table_bytes(32768).to_string(),
            link if link.starts_with('[') => link.rsplit(':').next().unwrap().trim_end_matches(['`', ']']).to_owned(),
            plain => plain.to_owned(),
        };
        assert!(
            value == documented || value == format!("{documented}.0"),
            "{name} is {value}, documented {documented}"
        );
        checked += 1;
    }
    // all fields but the size
    assert_eq!(checked, values.matches(": ").count() - 1);
}
