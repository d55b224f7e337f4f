//! Curves in logarithmic axes, as SVG.

use std::ops::Range;

use plotters::prelude::*;

use crate::cli::CliError;

/// Pixels of the picture.
const SIZE: (u32, u32) = (800, 500);
/// Okabe and Ito's colours, which colour-blind people can tell apart as well; yellow is left out, on white nobody sees it.
const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(0, 0, 0),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
];

/// Points `[x, y]`, both positive.
pub type Curve = Vec<[f64; 2]>;

/// An integrator.
pub struct Line {
    pub name: String,
    pub median: Curve,
    /// The single renders, drawn thinly.
    pub renders: Vec<Curve>,
    /// Marked by rings.
    pub front: Curve,
}

/// A picture of several.
pub struct Plot<'a> {
    pub title: String,
    pub x_title: &'a str,
    pub y_title: &'a str,
    /// A level to reach.
    pub level: Option<f64>,
    pub lines: Vec<Line>,
}

impl Plot<'_> {
    /// The picture as a file.
    ///
    /// # Errors
    /// What the library reports; none is known.
    pub fn svg(&self) -> Result<String, CliError> {
        let mut svg = String::new();
        self.draw(SVGBackend::with_string(&mut svg, SIZE))
            .map_err(|error| CliError::Plot { title: self.title.clone(), cause: error.to_string() })?;
        Ok(svg)
    }

    fn draw(&self, backend: SVGBackend) -> Result<(), Box<dyn std::error::Error + '_>> {
        // White behind it: pages may be dark.
        let area = backend.into_drawing_area();
        area.fill(&WHITE)?;
        let [x, y] = self.ranges();
        let mut chart = ChartBuilder::on(&area)
            .caption(&self.title, ("sans-serif", 20))
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(64)
            .build_cartesian_2d(
                x.clone().log_scale().with_key_points(ticks(&x)),
                y.clone().log_scale().with_key_points(ticks(&y)),
            )?;
        chart
            .configure_mesh()
            .x_desc(self.x_title)
            .y_desc(self.y_title)
            .axis_desc_style(("sans-serif", 15))
            .label_style(("sans-serif", 13))
            .x_label_formatter(&|x| tick(*x))
            .y_label_formatter(&|y| tick(*y))
            .bold_line_style(BLACK.mix(0.12))
            .light_line_style(TRANSPARENT)
            .draw()?;
        if let Some(level) = self.level {
            let ends = [(x.start, level), (x.end, level)];
            chart.draw_series(DashedLineSeries::new(ends, 6, 4, BLACK.mix(0.6).into()))?;
        }
        for (index, line) in self.lines.iter().enumerate() {
            let color = COLORS[index % COLORS.len()];
            let points = |curve: &Curve| curve.iter().map(|&[x, y]| (x, y)).collect::<Vec<_>>();
            for render in &line.renders {
                chart.draw_series(LineSeries::new(points(render), color.mix(0.3)))?;
            }
            chart
                .draw_series(LineSeries::new(points(&line.median), color.stroke_width(3)))?
                .label(&line.name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(3)));
            let dots = points(&line.median).into_iter();
            chart.draw_series(dots.map(|at| Circle::new(at, 3, color.filled())))?;
            let rings = points(&line.front).into_iter();
            chart.draw_series(rings.map(|at| Circle::new(at, 6, color.stroke_width(2))))?;
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE.mix(0.85))
            .border_style(BLACK.mix(0.3))
            .label_font(("sans-serif", 14))
            .draw()?;
        area.present()?;
        Ok(())
    }

    /// Of x and y, with a margin.
    fn ranges(&self) -> [Range<f64>; 2] {
        let curves = self.lines.iter().flat_map(|line| line.renders.iter().chain([&line.median]));
        let points: Vec<[f64; 2]> = curves.flatten().copied().collect();
        [0, 1].map(|axis| {
            let level = self.level.filter(|_| axis == 1);
            let values = points.iter().map(|point| point[axis]).chain(level);
            let (low, high) =
                values.fold((f64::INFINITY, 0f64), |(low, high), value| (low.min(value), high.max(value)));
            low / 1.15..high * 1.15
        })
    }
}

/// Where lines with numbers are: 1, 2, 5, 10, ..., or powers of ten where those are many.
fn ticks(range: &Range<f64>) -> Vec<f64> {
    let decades = range.start.log10().floor() as i32..=range.end.log10().ceil() as i32;
    let steps: &[f64] = match decades.clone().count() {
        0..=3 => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0],
        4..=6 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    let all = decades.flat_map(|decade| steps.iter().map(move |step| step * 10f64.powi(decade)));
    all.filter(|tick| range.contains(tick)).collect()
}

/// As few digits as say it.
fn tick(value: f64) -> String {
    let digits = (1.0 - value.log10().floor()).max(0.0) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}
