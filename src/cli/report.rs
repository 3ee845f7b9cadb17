//! `report.html`: a comparison as one page that opens without a network and without any other file.

mod html;
mod shell;

pub use shell::this_command;

use super::failure::Failure;
use super::figures::{self, Figure};
use super::results::{Comparison, Row};
use super::sweep::Plot;
use html::{data_uri, escaped, filled, number_cell};
use umbrage::Light;
use umbrage::methods::{METHODS, MethodInfo, MethodSpec};
use umbrage::output::{OutputError, Picture, encode_png};

const TEMPLATE: &str = include_str!("report/page.html");

/// Name of the reference among the pictures.
const REFERENCE: &str = "ray traced (the reference)";

/// What the page shows.
pub struct Report<'a> {
    pub comparison: &'a Comparison<'a>,
    /// The method of each row.
    pub specs: &'a [&'a MethodSpec],
    /// What the times are, in sentences.
    pub times: &'a str,
    /// The scene in ray-traced light.
    pub reference: &'a Picture,
    pub shots: &'a [Shot<'a>],
    pub plots: &'a [Plot],
    /// What was typed.
    pub command: &'a str,
}

/// What one method's shadows look like.
pub struct Shot<'a> {
    pub method: &'a str,
    pub picture: Picture,
    pub difference: Picture,
}

/// The text of the page.
pub fn page(report: &Report) -> Result<String, Failure> {
    let comparison = report.comparison;
    let view = serde_json::to_string_pretty(comparison.view).map_err(|error| Failure::other(error.to_string()))?;
    let names = std::iter::once(REFERENCE).chain(report.shots.iter().map(|shot| shot.method));
    let choices = names.enumerate().map(|(i, name)| format!("<option value=\"{i}\">{}</option>", escaped(name)));
    Ok(filled(
        TEMPLATE,
        &[
            ("scene", escaped(comparison.scene)),
            ("what", escaped(&what(comparison))),
            ("times", escaped(report.times.trim())),
            ("table", table(report)),
            ("by_light", by_light(report)),
            ("sampling", sampling(report)),
            ("pictured", pictured(report.shots.len(), comparison.rows.len())),
            ("choices", choices.collect()),
            ("runs", runs(report)?),
            ("plots", plots(report.plots)),
            ("settings", settings(report.specs)),
            ("view", escaped(&view)),
            ("command", escaped(report.command)),
            ("device", escaped(&comparison.device)),
            ("driver", escaped(&comparison.driver)),
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("legend", legend(comparison)),
        ],
    ))
}

/// What was looked at, in one sentence.
fn what(comparison: &Comparison) -> String {
    let [width, height] = comparison.view.size;
    let kind = |light: &Light| match light {
        Light::Directional { .. } => "directional",
        Light::Spot { .. } => "spot",
        Light::Point { .. } => "point",
        Light::Area { .. } => "area",
        _ => "other",
    };
    let lights = ["directional", "spot", "point", "area", "other"].into_iter().filter_map(|name| {
        let count = comparison.view.lights.iter().filter(|light| kind(light) == name).count();
        (count > 0).then(|| format!("{count} {name} light{}", if count > 1 { "s" } else { "" }))
    });
    let swept = comparison.sweep.map_or(String::new(), |s| format!(", {} swept over {}", s.key, s.values.join(", ")));
    format!("{width} x {height} pixels, {}{swept}.", lights.collect::<Vec<_>>().join(", "))
}

/// A table whose headings sort it. Of each row: its first cells, then its figures.
fn sortable(first: &[&str], rows: Vec<(String, Vec<Figure>)>) -> String {
    let figures = rows.first().map_or(&[][..], |(_, figures)| figures);
    let heading = |name| format!("<th scope=\"col\" aria-sort=\"none\"><button type=\"button\">{name}</button></th>");
    let headings = first.iter().copied().chain(figures.iter().map(|figure| figure.column.name)).map(heading);
    let headings: String = headings.collect();
    let rows = rows.into_iter().map(|(cells, figures)| {
        let figures: String = figures.iter().map(|figure| number_cell(figure.value, &figure.text())).collect();
        format!("<tr>{cells}{figures}</tr>\n")
    });
    let rows: String = rows.collect();
    format!("<table class=\"sortable\">\n<thead><tr>{headings}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table>")
}

fn info(spec: &MethodSpec) -> Option<&'static MethodInfo> {
    METHODS.iter().find(|method| method.name == spec.name)
}

/// What is typed for a method, in lines that end between its keys.
fn typed(method: &str) -> String {
    format!("<code>{}</code>", escaped(method).replace(':', ":<wbr>").replace(',', ",<wbr>"))
}

fn table(report: &Report) -> String {
    let rows = report.comparison.rows.iter().zip(report.specs).enumerate().map(|(i, (row, spec))| {
        // once is enough for the runs of a sweep
        let again = report.specs[..i].iter().any(|before| before.name == spec.name);
        let about = info(spec)
            .filter(|_| !again)
            .map_or(String::new(), |m| format!("<small>{} ({})</small>", escaped(m.summary), escaped(m.source)));
        (format!("<th scope=\"row\">{}{about}</th>", typed(row.method)), figures::of_row(row))
    });
    sortable(&["method"], rows.collect())
}

/// The errors of each light, where there are several.
fn by_light(report: &Report) -> String {
    if report.comparison.view.lights.len() < 2 {
        return String::new();
    }
    of_lights(report, "Errors by light", |row| row.errors.lights.iter().map(figures::of_errors).collect())
}

/// How large texels look, where methods tell.
fn sampling(report: &Report) -> String {
    if report.comparison.rows.iter().all(|row| row.sampling.is_empty()) {
        return String::new();
    }
    of_lights(report, "How large texels look", |row| row.sampling.iter().map(figures::of_sampling).collect())
}

/// A table with a row for each method and light.
fn of_lights(report: &Report, title: &str, figures: impl Fn(&Row) -> Vec<Vec<Figure>>) -> String {
    let rows = report.comparison.rows.iter().flat_map(|row| {
        figures(row).into_iter().enumerate().map(|(light, figures)| {
            let method = format!("<th scope=\"row\">{}</th>", typed(row.method));
            (method + &number_cell(light as f64, &light.to_string()), figures)
        })
    });
    let table = sortable(&["method", "light"], rows.collect());
    format!(
        "<h2>{title}</h2>\n<p class=\"soft\">Lights are counted from 0, as in view.json.</p>\n<div class=\"wide\">{table}</div>"
    )
}

/// Which of the runs have pictures.
fn pictured(shown: usize, runs: usize) -> String {
    let of_all = if shown < runs {
        format!("Of the {runs} runs {shown} are shown, at equal distances in the order of the table. ")
    } else {
        String::new()
    };
    of_all
        + "The slider moves the edge between two pictures, each of the scene in the light that a method lets through."
}

/// All pictures, each embedded once.
fn runs(report: &Report) -> Result<String, OutputError> {
    let image = |class: &str, what: &str, picture: &Picture| -> Result<String, OutputError> {
        let (Picture { width, height, .. }, uri) = (picture, data_uri("image/png", &encode_png(picture)?));
        let alt = escaped(what);
        Ok(format!("<img class=\"{class}\" alt=\"{alt}\" width=\"{width}\" height=\"{height}\" src=\"{uri}\">\n"))
    };
    let figure = |name: &str, images: String| {
        format!(
            "<figure class=\"run\">\n<figcaption>{}</figcaption>\n<div>\n{images}</div>\n</figure>\n",
            escaped(name)
        )
    };
    let mut text = figure(REFERENCE, image("picture", REFERENCE, report.reference)?);
    for Shot { method, picture, difference } in report.shots {
        let picture = image("picture", method, picture)?;
        let difference = image("difference", &format!("where {method} differs from ray tracing"), difference)?;
        text += &figure(method, picture + &difference);
    }
    Ok(text)
}

fn plots(plots: &[Plot]) -> String {
    if plots.is_empty() {
        return String::new();
    }
    // in a page an SVG element needs no namespace
    let figure = |plot: &Plot| {
        let svg = plot.svg.replacen(" xmlns=\"http://www.w3.org/2000/svg\"", " role=\"img\"", 1);
        format!("<figure class=\"plot\" tabindex=\"0\">{svg}</figure>\n")
    };
    let figures: String = plots.iter().map(figure).collect();
    format!("<section>\n<h2>Plots</h2>\n{figures}</section>\n")
}

/// What each method ran with.
fn settings(specs: &[&MethodSpec]) -> String {
    let row =
        |spec: &&MethodSpec| format!("<tr><td>{}</td><td>{}</td></tr>\n", typed(&spec.text), typed(&effective(spec)));
    let rows: String = specs.iter().map(row).collect();
    format!(
        "<table class=\"texts\">\n<thead><tr><th scope=\"col\">method</th><th scope=\"col\">with all its settings</th></tr>\
         </thead>\n<tbody>\n{rows}</tbody>\n</table>"
    )
}

/// A method with the values of all its keys: those typed, else the defaults.
fn effective(spec: &MethodSpec) -> String {
    let parameters = info(spec).map_or(&[][..], |method| method.parameters);
    let missing = |key| !spec.parameters.iter().any(|(typed, _)| typed == key);
    let defaults = parameters.iter().filter(|p| missing(p.key));
    defaults.fold(spec.clone(), |spec, p| spec.with(p.key, p.default)).text
}

fn legend(comparison: &Comparison) -> String {
    let sampling = comparison.rows.iter().flat_map(|row| &row.sampling).take(1).flat_map(figures::of_sampling);
    let figures: Vec<_> = comparison.rows.first().into_iter().flat_map(figures::of_row).chain(sampling).collect();
    figures
        .iter()
        .map(|Figure { column, .. }| format!("<dt>{}</dt><dd>{}</dd>\n", escaped(column.name), escaped(column.meaning)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::measure::{Spread, Tail, Timings};
    use crate::cli::results::{Errors, LightErrors, SamplingErrors};
    use crate::cli::sweep::{Sweep, Variant};
    use umbrage::Camera;
    use umbrage::lab::View;
    use umbrage::methods;

    const NASTY: &str = "<img src=x onerror=alert(1)>\"'&{{table}}.glb";

    fn errors(mismatch: f64) -> Errors {
        let [edge_error, off_edge, acne, leak, lost] = [f64::INFINITY, 0.5, 0.25, 0.25, 0.0];
        Errors { mismatch, edge_error, off_edge, acne, leak, lost, decided_pixels: 100, edge_pixels: 0 }
    }

    /// A page of two methods and two lights, in which all that comes from outside is nasty.
    fn page_of(shots: usize, plots: &[Plot]) -> String {
        let nasty = MethodSpec { text: NASTY.into(), name: NASTY.into(), parameters: Vec::new() };
        let specs = [nasty, MethodSpec::parse("uniform:resolution=64").unwrap()];
        let variants = specs.clone().map(|spec| Variant { spec, swept: None });
        let view = View {
            camera: Camera {
                eye: [0.0; 3].into(),
                target: [0.0, 0.0, 1.0].into(),
                up: [0.0, 1.0, 0.0].into(),
                fov_y_deg: 60.0,
                near: 0.1,
                far: 10.0,
            },
            lights: [[0.0, -1.0, 0.0], [1.0, -1.0, 0.0]].map(|d| Light::directional(d.into())).into(),
            size: [2, 1],
            time_s: 0.0,
        };
        let row = |(variant, ms)| {
            let errors = LightErrors { all: errors(0.000_012), lights: vec![errors(1.0), errors(2.0)] };
            let row = Row::new(variant, &Timings::default(), &[("map", 3 << 20)], errors);
            Row { ms: Spread { min: ms, median: ms, max: ms }, ..row }
        };
        let texels = |side| Tail { median: side, p95: 2.0 * side, worst: f64::INFINITY };
        let sweep = Sweep { key: "resolution".into(), values: vec!["64".into()] };
        let mut comparison = Comparison {
            device: NASTY.into(),
            driver: NASTY.into(),
            scene: NASTY,
            view: &view,
            sweep: Some(&sweep),
            rows: variants.iter().zip([9.0, 10.123_456]).map(row).collect(),
        };
        // the second method tells of the first light alone
        comparison.rows[1].sampling = vec![SamplingErrors {
            undersampled: 12.5,
            storage_factor: 47.125,
            s: texels(0.5),
            t: texels(0.75),
            perspective_s: texels(0.25),
            perspective_t: texels(0.25),
        }];
        let picture = Picture::filled(2, 1, [1, 2, 3]);
        let shot = |method| Shot { method, picture: picture.clone(), difference: picture.clone() };
        let shots: Vec<_> = specs.iter().take(shots).map(|spec| shot(spec.text.as_str())).collect();
        page(&Report {
            comparison: &comparison,
            specs: &specs.each_ref(),
            times: NASTY,
            reference: &picture,
            shots: &shots,
            plots,
            command: NASTY,
        })
        .unwrap()
    }

    #[test]
    fn nothing_from_outside_becomes_part_of_the_page() {
        let page = page_of(2, &[]);
        let tags = |tag: &str| page.matches(tag).count();
        assert_eq!(
            (tags("<img src"), tags("<script"), tags("onerror=alert(1)&gt;")),
            (0, 1, tags("onerror")),
            "{page}"
        );
        // title, heading, times, two tables with two lights, two choices, two captions, settings twice, alternative texts twice,
        // command, device, driver
        assert!(tags("&lt;img src=x onerror=alert(1)&gt;&quot;&#39;&amp;{{table}}.glb") >= 15, "{page}");
        assert_eq!(page.matches("{{").count(), page.matches("{{table}}").count(), "a place without a value: {page}");
        assert_eq!(tags("src=\"data:image/png;base64,"), tags("src=\""), "{page}");
    }

    #[test]
    fn tables_sort_by_values_that_are_not_rounded() {
        let page = page_of(2, &[]);
        for cell in [
            "<td data-value=\"9\">9.00</td>",
            "<td data-value=\"10.123456\">10.12</td>",
            "<td data-value=\"3\">3.0</td>",
            "<td data-value=\"0.000012\">0.0000</td>",
            "<td data-value=\"\"",
        ] {
            assert!(page.contains(cell), "{cell} is not in {page}");
        }
        assert!(page.contains("Errors by light") && page.contains("<td data-value=\"1\">1</td>"), "{page}");
        assert!(
            page.contains("<h2>How large texels look</h2>") && page.contains("<td data-value=\"47.125\">47.12</td>")
        );
        assert!(page.contains("<dt>storage factor</dt>"), "{page}");
        // one row a method, one a method and light, one where texels are known, each with a heading for every cell
        assert_eq!(page.matches("<tr><th scope=\"row\">").count(), 2 + 4 + 1);
        assert_eq!(page.matches("aria-sort=\"none\"><button").count(), 8 + 6 + 8);
    }

    #[test]
    fn what_is_shown_is_said() {
        let page = page_of(1, &[Plot { file: "a.svg".into(), svg: "<svg width=\"1\">curve</svg>".into() }]);
        assert!(page.contains("Of the 2 runs 1 are shown") && page.contains("curve</svg></figure>"), "{page}");
        assert!(page.contains("2 x 1 pixels, 2 directional lights, resolution swept over 64."), "{page}");
        for (name, meaning) in [("edge_error %", "shadow edges"), ("lost %", "nothing is left")] {
            assert!(page.contains(&format!("<dt>{name}</dt><dd>")) && page.contains(meaning), "{name}");
        }
        let page = page_of(2, &[]);
        assert!(!page.contains("Of the 2 runs") && !page.contains("<h2>Plots</h2>"), "{page}");
    }

    #[test]
    fn settings_hold_every_key_and_can_be_typed_again() {
        for method in METHODS {
            let all = effective(&MethodSpec::parse(method.name).unwrap());
            let spec = MethodSpec::parse(&all).unwrap();
            methods::check(&spec).unwrap();
            let keys: Vec<_> = spec.parameters.iter().map(|(key, _)| key.as_str()).collect();
            assert_eq!(keys, method.parameters.iter().map(|p| p.key).collect::<Vec<_>>());
        }
        let spec = MethodSpec::parse("uniform:filter=pcf").unwrap();
        assert!(effective(&spec).starts_with("uniform:filter=pcf,resolution=4096,"), "{}", effective(&spec));
    }
}
