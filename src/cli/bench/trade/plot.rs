//! Curves in logarithmic axes: groups of panels on one sheet, as SVG with its text as text.

use std::fmt::Write as _;
use std::ops::Range;

/// Okabe and Ito's colours, which colour-blind people can tell apart as well; without yellow, which white hides.
const COLORS: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#000", "#56b4e9", "#e69f00"];
/// Panels side by side at most.
const COLUMNS: usize = 4;
/// Pixels of a panel, and of it what lies around its axes: left, top, right, bottom.
const PANEL: [f64; 2] = [320.0, 236.0];
const AROUND: [f64; 4] = [52.0, 26.0, 10.0, 40.0];
const MARGIN: f64 = 14.0;
/// Height of a group's title, and of a line of its legend.
const TITLE: f64 = 30.0;
const LEGEND_LINE: f64 = 20.0;
/// Width of a character of a legend, at most on average; and of its mark with what is around it.
const CHARACTER: f64 = 6.6;
const LEGEND_MARK: f64 = 46.0;

/// Classes: h title of a group, t of a panel, e at the end of a line, m in the middle; g grid, a axes, l level;
/// p curves, r single renders, d dots, f rings.
const STYLE: &str = "text{font:12px sans-serif}.h{font-size:16px;font-weight:bold}.t{font-weight:bold}.e{text-anchor:end}\
.m{text-anchor:middle}path,circle{fill:none}.g{stroke:#e0e0e0}.a{stroke:#000}.l{stroke:#555;stroke-dasharray:6 4}\
.p{stroke-width:2.5}.r{opacity:.35}.d{stroke-width:5.5;stroke-linecap:round}.f{stroke-width:1.5}";

/// Points `[x, y]`; those that are not positive are not drawn.
pub type Curve = Vec<[f64; 2]>;

/// All plots of a page.
pub struct Sheet {
    pub groups: Vec<Group>,
}

/// Panels with a legend in common.
pub struct Group {
    pub title: String,
    /// Of the curves of each panel, in order.
    pub names: Vec<String>,
    pub panels: Vec<Panel>,
}

/// One pair of axes.
pub struct Panel {
    pub title: String,
    pub x_title: &'static str,
    pub y_title: &'static str,
    /// A level to reach.
    pub level: Option<f64>,
    pub lines: Vec<Line>,
}

/// What is drawn in one colour.
pub struct Line {
    pub median: Curve,
    /// The single renders, drawn thinly.
    pub renders: Vec<Curve>,
    /// Marked by rings.
    pub front: Curve,
}

impl Sheet {
    /// The sheet as a file.
    pub fn svg(&self) -> String {
        let most = self.groups.iter().map(|group| group.panels.len()).max().unwrap_or(0);
        let width = 2.0 * MARGIN + PANEL[0] * most.clamp(1, COLUMNS) as f64;
        let mut body = String::new();
        let mut y = MARGIN;
        for group in &self.groups {
            y = group.draw(&mut body, y, width);
        }
        let height = y + MARGIN;
        let mut colors = String::new();
        for (index, color) in COLORS.iter().enumerate() {
            let _ = write!(colors, ".c{index}{{stroke:{color}}}");
        }
        // White behind it: pages may be dark.
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\">\n<style>{STYLE}{colors}</style>\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n{body}</svg>\n"
        )
    }
}

impl Group {
    /// Draws it from `y` on, returns where it ends.
    fn draw(&self, body: &mut String, y: f64, width: f64) -> f64 {
        text(body, "h", [MARGIN, y + 20.0], &self.title);
        let mut at = [MARGIN, y + TITLE + 12.0];
        for (index, name) in self.names.iter().enumerate() {
            let entry = LEGEND_MARK + CHARACTER * name.chars().count() as f64;
            if at[0] + entry > width && at[0] > MARGIN {
                at = [MARGIN, at[1] + LEGEND_LINE];
            }
            let _ = writeln!(
                body,
                "<path class=\"p {}\" d=\"M{} {}h22\"/>",
                color(index),
                number(at[0]),
                number(at[1] - 4.0)
            );
            text(body, "n", [at[0] + 28.0, at[1]], name);
            at[0] += entry;
        }
        let top = at[1] + MARGIN;
        for (index, panel) in self.panels.iter().enumerate() {
            let (column, row) = (index % COLUMNS, index / COLUMNS);
            let corner = [MARGIN + PANEL[0] * column as f64, top + PANEL[1] * row as f64];
            panel.draw(body, corner);
        }
        top + PANEL[1] * self.panels.len().div_ceil(COLUMNS) as f64
    }
}

/// A logarithmic axis: a range of values, and the pixels that its ends are at.
struct Axis {
    range: Range<f64>,
    pixels: [f64; 2],
}

impl Axis {
    fn at(&self, value: f64) -> f64 {
        let share = (value / self.range.start).ln() / (self.range.end / self.range.start).ln();
        self.pixels[0] + share * (self.pixels[1] - self.pixels[0])
    }

    /// Where lines with numbers are: 1, 2, 5, 10, ..., as many as keep `gap` pixels apart.
    fn ticks(&self, gap: f64) -> Vec<f64> {
        let two_digits: Vec<f64> = (10..100).map(|step| f64::from(step) / 10.0).collect();
        let steps: [&[f64]; 6] = [
            &two_digits,
            &[1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0],
            &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0],
            &[1.0, 2.0, 5.0],
            &[1.0, 3.0],
            &[1.0],
        ];
        let decades = self.range.start.log10().floor() as i32..=self.range.end.log10().ceil() as i32;
        let within = |steps: &[f64]| -> Vec<f64> {
            let all =
                decades.clone().flat_map(|decade| steps.iter().map(move |step| step * 10f64.powi(decade)));
            all.filter(|tick| self.range.contains(tick)).collect()
        };
        let fits = |ticks: &Vec<f64>| {
            ticks.windows(2).all(|pair| (self.at(pair[1]) - self.at(pair[0])).abs() >= gap)
        };
        steps.into_iter().map(within).find(fits).unwrap_or_else(|| within(&[1.0]))
    }
}

impl Panel {
    fn draw(&self, body: &mut String, [left, top]: [f64; 2]) {
        let [from_left, from_top, from_right, from_bottom] = AROUND;
        let [x0, x1] = [left + from_left, left + PANEL[0] - from_right];
        let [y0, y1] = [top + PANEL[1] - from_bottom, top + from_top];
        text(body, "t", [x0, y1 - 8.0], &self.title);
        text(body, "m", [0.5 * (x0 + x1), y0 + 32.0], self.x_title);
        let at = [left + 14.0, 0.5 * (y0 + y1)].map(number);
        let _ = writeln!(
            body,
            "<text class=\"m\" transform=\"translate({} {}) rotate(-90)\">{}</text>",
            at[0],
            at[1],
            escaped(self.y_title)
        );
        let Some([x, y]) = self.ranges() else { return };
        let (x, y) = (Axis { range: x, pixels: [x0, x1] }, Axis { range: y, pixels: [y0, y1] });
        let mut grid = String::new();
        for tick in x.ticks(36.0) {
            let _ = write!(grid, "M{} {}V{}", number(x.at(tick)), number(y0), number(y1));
            text(body, "m", [x.at(tick), y0 + 15.0], &digits(tick));
        }
        for tick in y.ticks(16.0) {
            let _ = write!(grid, "M{} {}H{}", number(x0), number(y.at(tick)), number(x1));
            text(body, "e", [x0 - 5.0, y.at(tick) + 4.0], &digits(tick));
        }
        path(body, "g", &grid);
        path(body, "a", &format!("M{} {}V{}H{}", number(x0), number(y1), number(y0), number(x1)));
        if let Some(level) = self.level {
            path(body, "l", &format!("M{} {}H{}", number(x0), number(y.at(level)), number(x1)));
        }
        let place = |point: &[f64; 2]| format!("{} {}", number(x.at(point[0])), number(y.at(point[1])));
        for (index, line) in self.lines.iter().enumerate() {
            let color = color(index);
            let places = |curve: &Curve| visible(curve).map(place).collect::<Vec<_>>();
            let renders: String = line.renders.iter().map(|render| joined(&places(render))).collect();
            path(body, &format!("r {color}"), &renders);
            path(body, &format!("p {color}"), &joined(&places(&line.median)));
            let dots: String = places(&line.median).iter().map(|at| format!("M{at}h0")).collect();
            path(body, &format!("d {color}"), &dots);
            for point in visible(&line.front) {
                let (cx, cy) = (number(x.at(point[0])), number(y.at(point[1])));
                let _ = writeln!(body, "<circle class=\"f {color}\" cx=\"{cx}\" cy=\"{cy}\" r=\"6\"/>");
            }
        }
    }

    /// Of x and y, with a margin; `None` where there is nothing to draw.
    fn ranges(&self) -> Option<[Range<f64>; 2]> {
        let curves =
            self.lines.iter().flat_map(|line| line.renders.iter().chain([&line.median, &line.front]));
        let points: Vec<&[f64; 2]> = curves.flat_map(visible).collect();
        (!points.is_empty()).then(|| {
            [0, 1].map(|axis| {
                let level = self.level.filter(|_| axis == 1);
                let values = points.iter().map(|point| point[axis]).chain(level);
                let (low, high) = values
                    .fold((f64::INFINITY, 0f64), |(low, high), value| (low.min(value), high.max(value)));
                low / 1.15..high * 1.15
            })
        })
    }
}

/// Points that logarithmic axes have a place for.
fn visible(curve: &Curve) -> impl Iterator<Item = &[f64; 2]> {
    curve.iter().filter(|point| point.iter().all(|value| *value > 0.0 && value.is_finite()))
}

fn color(index: usize) -> String {
    format!("c{}", index % COLORS.len())
}

fn joined(places: &[String]) -> String {
    if places.is_empty() { String::new() } else { format!("M{}", places.join("L")) }
}

fn path(body: &mut String, class: &str, data: &str) {
    if !data.is_empty() {
        let _ = writeln!(body, "<path class=\"{class}\" d=\"{data}\"/>");
    }
}

fn text(body: &mut String, class: &str, [x, y]: [f64; 2], text: &str) {
    let _ = writeln!(
        body,
        "<text class=\"{class}\" x=\"{}\" y=\"{}\">{}</text>",
        number(x),
        number(y),
        escaped(text)
    );
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}

/// Pixels, to a tenth.
fn number(value: f64) -> String {
    let text = format!("{value:.1}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

/// A tick's value with as few digits as it has, two at most.
fn digits(value: f64) -> String {
    let digits = (1.0 - value.log10().floor()).max(0.0) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet(curve: Curve, name: &str) -> String {
        let line = || Line { median: curve.clone(), renders: vec![curve.clone()], front: Vec::new() };
        let panel = |title: &str| Panel {
            title: title.into(),
            x_title: "seconds",
            y_title: "MAPE, %",
            level: Some(12.0),
            lines: vec![line()],
        };
        let group = |panels| Group { title: "a title".into(), names: vec![name.into()], panels };
        Sheet { groups: vec![group(vec![panel("a"), panel("b")]), group(vec![panel("c")])] }.svg()
    }

    #[test]
    fn a_sheet_has_every_panel_and_each_legend_once() {
        let svg = sheet(vec![[1.0, 50.0], [10.0, 5.0]], "a < b & c");
        assert_eq!(svg.matches("MAPE, %").count(), 3);
        assert_eq!(svg.matches(">a &lt; b &amp; c</text>").count(), 2);
        assert!(
            ["a", "b", "c"]
                .iter()
                .all(|title| svg.contains("class=\"t\" x=") && svg.contains(&format!(">{title}</text>")))
        );
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }

    /// Nothing to draw, or nothing that logarithms know, draws no curve.
    #[test]
    fn curves_without_points_are_left_out() {
        for curve in [vec![], vec![[0.0, 1.0], [1.0, f64::INFINITY], [f64::NAN, 1.0]]] {
            let svg = sheet(curve, "a");
            assert!(!svg.contains("NaN") && !svg.contains("class=\"p c0\" d=\"M66"), "{svg}");
            assert_eq!(svg.matches("class=\"d ").count(), 0, "{svg}");
        }
    }

    #[test]
    fn ticks_are_round_and_apart() {
        let ticks = |range: Range<f64>, pixels: f64| Axis { range, pixels: [0.0, pixels] }.ticks(30.0);
        assert_eq!(ticks(0.9..110.0, 250.0), [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0]);
        assert_eq!(ticks(10.5..14.2, 250.0), [11.0, 12.0, 13.0, 14.0]);
        assert_eq!(ticks(0.5..2e6, 250.0).len(), 7);
        assert_eq!([0.02, 0.15, 1.5, 20.0, 1e4].map(digits), ["0.02", "0.15", "1.5", "20", "10000"]);
    }
}
