//! Line charts as SVG.

use super::axis::{Axis, Scale, least_and_greatest};
use super::{OutputError, write_file};
use plotters::prelude::{
    ChartBuilder, Circle, EmptyElement, IntoDrawingArea, LineSeries, PathElement, RGBColor, SVGBackend,
    SeriesLabelPosition, Text, WHITE,
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
const LEGEND: f64 = 0.06;
/// Room beside the outermost marks.
const BORDER: f64 = 0.05;
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
#[derive(Debug, Clone, Copy, Default)]
pub struct Chart<'a> {
    /// Above the chart.
    pub title: &'a str,
    /// Below the horizontal axis, with its unit.
    pub x_label: &'a str,
    /// Beside the vertical axis, with its unit.
    pub y_label: &'a str,
    /// Of the horizontal axis.
    pub x_scale: Scale,
    /// Of the vertical axis, which starts at 0 where it is linear.
    pub y_scale: Scale,
    /// Drawn in this order; the later ones lie on top.
    pub lines: &'a [Line],
}

/// One line of a chart.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Line {
    /// What the legend says.
    pub label: String,
    /// x and y, joined in this order. Values that are not finite are left out.
    pub points: Vec<(f64, f64)>,
    /// What is written beside each point; empty: nothing.
    pub notes: Vec<String>,
}

/// The text of an SVG file; fails when the chart cannot be drawn.
pub fn draw_svg(chart: &Chart) -> Result<String, OutputError> {
    let mut text = String::new();
    draw(&mut text, chart).map_err(|error| OutputError { path: "chart".to_owned(), what: error.to_string() })?;
    Ok(text)
}

/// Writes a chart; fails when it cannot be drawn or the file cannot be written.
pub fn write_svg(path: &Path, chart: &Chart) -> Result<(), OutputError> {
    let text = draw_svg(chart).map_err(|error| OutputError::new(path, error.what))?;
    write_file(path, text.as_bytes())
}

fn draw(text: &mut String, chart: &Chart) -> Result<(), Box<dyn std::error::Error>> {
    let lines: Vec<Vec<(f64, f64)>> = chart.lines.iter().map(|line| thinned(&shown(line, chart))).collect();
    let [x, y] =
        [|p: &(f64, f64)| p.0, |p: &(f64, f64)| p.1].map(|of| least_and_greatest(lines.iter().flatten().map(of)));
    let y = match chart.y_scale {
        Scale::Linear => (0.0, if y.1 > 0.0 { y.1 } else { 1.0 }),
        Scale::Log => y,
    };
    // marks at the border would be cut
    let side = if lines.iter().any(|points| points.len() <= MARKED) { BORDER } else { 0.0 };
    let low = if chart.y_scale == Scale::Log { BORDER } else { 0.0 };
    let (x, y) = (
        Axis::new(chart.x_scale, x, side, side),
        Axis::new(chart.y_scale, y, low, BORDER + LEGEND * lines.len() as f64),
    );

    let area = SVGBackend::with_string(text, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let mut context = ChartBuilder::on(&area)
        .caption(chart.title, ("sans-serif", 20).into_font())
        .margin(12)
        .x_label_area_size(46)
        .y_label_area_size(76)
        .build_cartesian_2d(x, y)?;
    context
        .configure_mesh()
        .x_desc(chart.x_label)
        .y_desc(chart.y_label)
        .label_style(("sans-serif", 14))
        .axis_desc_style(("sans-serif", 16))
        .light_line_style(WHITE)
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
        let font = ("sans-serif", 13).into_font().color(&color);
        let notes = line.points.iter().zip(&line.notes).filter(|(point, _)| places(chart, point));
        context.draw_series(
            notes.map(|(&point, note)| EmptyElement::at(point) + Text::new(note.clone(), (6, -14), font.clone())),
        )?;
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

/// Whether both axes have a place for a point.
fn places(chart: &Chart, point: &(f64, f64)) -> bool {
    chart.x_scale.shows(point.0) && chart.y_scale.shows(point.1)
}

fn shown(line: &Line, chart: &Chart) -> Vec<(f64, f64)> {
    line.points.iter().copied().filter(|point| places(chart, point)).collect()
}

fn thinned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    if points.len() <= 2 * COLUMNS {
        return points.to_vec();
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
        let chart = Chart { title: "a < b & c", x_label: "frame", y_label: "ms", lines, ..Chart::default() };
        draw(&mut text, &chart).unwrap();
        text
    }

    #[test]
    fn labels_are_there_and_escaped() {
        let svg = text(&[Line {
            label: "rmsm<1>".to_owned(),
            points: vec![(0.0, 1.0), (1.0, 2.0)],
            notes: vec!["8".to_owned(), "16>".to_owned()],
        }]);
        for part in ["a &lt; b &amp; c", "rmsm&lt;1&gt;", "16&gt;", "frame", "ms", "</svg>"] {
            assert!(svg.contains(part), "{part}");
        }
    }

    #[test]
    fn odd_lines_are_drawn() {
        let line = |points: &[(f64, f64)]| Line { label: "l".to_owned(), points: points.to_vec(), notes: Vec::new() };
        for points in [&[][..], &[(5.0, 3.0)], &[(0.0, 0.0), (1.0, 0.0)], &[(0.0, f64::INFINITY), (1.0, f64::NAN)]] {
            let svg = text(&[line(points)]);
            assert!(svg.ends_with("</svg>\n") && !svg.contains("NaN") && !svg.contains("inf"), "{points:?}");
            let (mut text, lines) = (String::new(), [line(points)]);
            draw(&mut text, &Chart { lines: &lines, x_scale: Scale::Log, y_scale: Scale::Log, ..Chart::default() })
                .unwrap();
            assert!(text.ends_with("</svg>\n") && !text.contains("NaN") && !text.contains("inf"), "{points:?}");
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
}
