//! Line charts as SVG.

use super::{OutputError, write_file};
use plotters::prelude::{
    ChartBuilder, Circle, IntoDrawingArea, LineSeries, PathElement, RGBColor, SVGBackend, SeriesLabelPosition, WHITE,
};
use plotters::style::{Color, IntoFont};
use std::path::Path;

/// Size of a chart in pixels.
const SIZE: (u32, u32) = (1200, 520);
/// Most columns of a line; each keeps its least and its greatest value, so that no peak is lost.
const COLUMNS: usize = 1000;
/// Points of a line up to which each is marked.
const MARKED: usize = 60;
/// Room above the lines for each entry of the legend, over the greatest value.
const LEGEND: f64 = 0.05;
/// Colours that people of any colour vision tell apart (Okabe and Ito).
const COLORS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
    RGBColor(150, 140, 20),
];

/// A chart with one or more lines over a common axis.
#[derive(Debug, Clone, Copy)]
pub struct Chart<'a> {
    /// Above the chart.
    pub title: &'a str,
    /// Below the horizontal axis, with its unit.
    pub x_label: &'a str,
    /// Beside the vertical axis, which starts at 0, with its unit.
    pub y_label: &'a str,
    /// Drawn in this order; the later ones lie on top.
    pub lines: &'a [Line],
}

/// One line of a chart.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Line {
    /// What the legend says.
    pub label: String,
    /// x and y, x ascending. Values that are not finite are left out.
    pub points: Vec<(f64, f64)>,
}

/// Writes a chart; fails when the file cannot be written.
pub fn write_svg(path: &Path, chart: &Chart) -> Result<(), OutputError> {
    let mut text = String::new();
    draw(&mut text, chart).map_err(|error| OutputError::new(path, error))?;
    write_file(path, text.as_bytes())
}

fn draw(text: &mut String, chart: &Chart) -> Result<(), Box<dyn std::error::Error>> {
    let lines: Vec<Vec<(f64, f64)>> = chart.lines.iter().map(|line| thinned(&line.points)).collect();
    let [x, y] = [|p: &(f64, f64)| p.0, |p: &(f64, f64)| p.1].map(|of| {
        let values = || lines.iter().flatten().map(of);
        [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
    });
    let (left, right) = if x[0] < x[1] { (x[0], x[1]) } else { (0.0, 1.0) };
    let top = if y[1] > 0.0 && y[1].is_finite() { y[1] * (1.05 + LEGEND * lines.len() as f64) } else { 1.0 };

    let area = SVGBackend::with_string(text, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let mut context = ChartBuilder::on(&area)
        .caption(chart.title, ("sans-serif", 20).into_font())
        .margin(12)
        .x_label_area_size(46)
        .y_label_area_size(76)
        .build_cartesian_2d(left..right, 0.0..top)?;
    context
        .configure_mesh()
        .x_desc(chart.x_label)
        .y_desc(chart.y_label)
        .label_style(("sans-serif", 14))
        .axis_desc_style(("sans-serif", 16))
        .light_line_style(WHITE)
        .x_label_formatter(&|x| short(*x, right - left))
        .y_label_formatter(&|y| short(*y, top))
        .draw()?;
    for (k, (line, points)) in chart.lines.iter().zip(&lines).enumerate() {
        let color = COLORS[k % COLORS.len()];
        // lines that coincide show as bands
        let style = color.stroke_width(if k == 0 { 3 } else { 2 });
        context
            .draw_series(LineSeries::new(points.iter().copied(), style))?
            .label(&line.label)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 22, y)], color.stroke_width(3)));
        if points.len() <= MARKED {
            context.draw_series(points.iter().map(|&point| Circle::new(point, 3, color.filled())))?;
        }
    }
    context
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .legend_area_size(30)
        .background_style(WHITE.mix(0.85))
        .border_style(RGBColor(160, 160, 160))
        .label_font(("sans-serif", 14))
        .draw()?;
    area.present()?;
    Ok(())
}

/// As many decimals as steps of a tenth of the range need.
fn short(value: f64, range: f64) -> String {
    let decimals = (1.0 - range.log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.decimals$}")
}

fn thinned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let points: Vec<_> = points.iter().copied().filter(|p| p.0.is_finite() && p.1.is_finite()).collect();
    if points.len() <= 2 * COLUMNS {
        return points;
    }
    let column = |column: &[(f64, f64)]| {
        let least = column.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1));
        let greatest = column.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1));
        let mut pair = [least, greatest].map(Option::unwrap_or_default);
        pair.sort_by(|a, b| a.0.total_cmp(&b.0));
        pair
    };
    points.chunks(points.len().div_ceil(COLUMNS)).flat_map(column).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(lines: &[Line]) -> String {
        let mut text = String::new();
        draw(&mut text, &Chart { title: "a < b & c", x_label: "frame", y_label: "ms", lines }).unwrap();
        text
    }

    #[test]
    fn labels_are_there_and_escaped() {
        let svg = text(&[Line { label: "rmsm<1>".to_owned(), points: vec![(0.0, 1.0), (1.0, 2.0)] }]);
        for part in ["a &lt; b &amp; c", "rmsm&lt;1&gt;", "frame", "ms", "</svg>"] {
            assert!(svg.contains(part), "{part}");
        }
    }

    #[test]
    fn odd_lines_are_drawn() {
        let line = |points: &[(f64, f64)]| Line { label: "l".to_owned(), points: points.to_vec() };
        for points in [&[][..], &[(5.0, 3.0)], &[(0.0, 0.0), (1.0, 0.0)], &[(0.0, f64::INFINITY), (1.0, f64::NAN)]] {
            let svg = text(&[line(points)]);
            assert!(svg.ends_with("</svg>\n") && !svg.contains("NaN") && !svg.contains("inf"), "{points:?}");
        }
        assert!(text(&[]).contains("</svg>"));
        assert!(text(&vec![line(&[(0.0, 1.0), (2.0, 1e-9)]); 20]).contains("</svg>"));
    }

    #[test]
    fn thinning_keeps_peaks() {
        let mut points: Vec<_> = (0..100_000).map(|i| (f64::from(i), 1.0)).collect();
        points[77_777].1 = 50.0;
        points[123].1 = 0.5;
        let thin = thinned(&points);
        assert!(thin.len() <= 2 * COLUMNS && thin.is_sorted_by(|a, b| a.0 <= b.0));
        assert!(thin.contains(&(77_777.0, 50.0)) && thin.contains(&(123.0, 0.5)));
    }

    #[test]
    fn labels_of_axes_are_short() {
        assert_eq!([short(20.0, 300.0), short(2.5, 10.0), short(0.25, 0.9)], ["20", "2", "0.25"]);
    }
}
