//! Curves that are straight in logarithms where nothing disturbs them, such as error against time: between their points,
//! and a little beyond. Points are `[x, y]`, both positive, `x` increasing.

/// How far a curve is continued beyond its ends, as a factor on x.
pub const REACH: f64 = 4.0;
/// Points at an end that the line beyond it is fitted to.
const FITTED: usize = 4;

/// Where a curve comes down to a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Crossing {
    /// Between two points, or on one.
    Measured(f64),
    /// Beyond an end, by no more than [`REACH`].
    Extrapolated(f64),
    /// Before the first point, which is at this x, by an unknown distance.
    AtMost(f64),
    /// Not as far as the curve can be continued.
    Never,
}

/// A value of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Value {
    pub value: f64,
    /// Beyond an end.
    pub extrapolated: bool,
}

/// From which x on the curve stays at or below `y`.
pub fn crossing(points: &[[f64; 2]], y: f64) -> Crossing {
    let Some(first) = points.first() else { return Crossing::Never };
    let Some(above) = points.iter().rposition(|point| point[1] > y) else {
        let beyond = falling(&points[..points.len().min(FITTED)]).map(|line| line.x(y));
        return match beyond {
            _ if first[1] == y => Crossing::Measured(first[0]),
            Some(x) if (first[0] / REACH..=first[0]).contains(&x) => Crossing::Extrapolated(x),
            _ => Crossing::AtMost(first[0]),
        };
    };
    match points.get(above + 1) {
        Some(&[x1, y1]) => {
            let [x0, y0] = points[above];
            Crossing::Measured(x0 * (x1 / x0).powf((y / y0).ln() / (y1 / y0).ln()))
        }
        None => {
            let last = points[above];
            match continued(points, y) {
                Some(x) if x <= REACH * last[0] => Crossing::Extrapolated(x.max(last[0])),
                _ => Crossing::Never,
            }
        }
    }
}

/// Where the curve would come down to `y` beyond its end, however far that is; `None` where it does not come down.
pub fn continued(points: &[[f64; 2]], y: f64) -> Option<f64> {
    falling(&points[points.len().saturating_sub(FITTED)..]).map(|line| line.x(y))
}

/// The curve's value at `x`; `None` beyond [`REACH`], and beyond the ends of a curve of one point.
pub fn value(points: &[[f64; 2]], x: f64) -> Option<Value> {
    let measured = |value: f64| Some(Value { value, extrapolated: false });
    let after = points.partition_point(|point| point[0] < x);
    if let Some(&[_, y]) = points.get(after).filter(|point| point[0] == x) {
        return measured(y);
    }
    let (first, last) = (points.first()?, points.last()?);
    let end = match after {
        0 if x >= first[0] / REACH => &points[..points.len().min(FITTED)],
        n if n == points.len() && x <= REACH * last[0] => &points[points.len().saturating_sub(FITTED)..],
        n if n == 0 || n == points.len() => return None,
        n => {
            let ([x0, y0], [x1, y1]) = (points[n - 1], points[n]);
            return measured(y0 * (y1 / y0).powf((x / x0).ln() / (x1 / x0).ln()));
        }
    };
    fit(end).map(|line| Value { value: line.y(x), extrapolated: true })
}

/// Slope of the line through the points in logarithms, by least squares; `None` for less than two.
pub fn slope(points: &[[f64; 2]]) -> Option<f64> {
    fit(points).map(|line| line.slope)
}

/// ln y = height + slope ln x.
struct Line {
    height: f64,
    slope: f64,
}

impl Line {
    fn x(&self, y: f64) -> f64 {
        ((y.ln() - self.height) / self.slope).exp()
    }

    fn y(&self, x: f64) -> f64 {
        (self.height + self.slope * x.ln()).exp()
    }
}

fn falling(points: &[[f64; 2]]) -> Option<Line> {
    fit(points).filter(|line| line.slope < 0.0)
}

/// Least squares in logarithms; `None` for a single point.
fn fit(points: &[[f64; 2]]) -> Option<Line> {
    let count = points.len() as f64;
    let mean = |axis: usize| points.iter().map(|point| point[axis].ln()).sum::<f64>() / count;
    let (x, y) = (mean(0), mean(1));
    let products = |axis: usize, centre: f64| {
        points.iter().map(|point| (point[0].ln() - x) * (point[axis].ln() - centre)).sum::<f64>()
    };
    let slope = products(1, y) / products(0, x);
    slope.is_finite().then_some(Line { height: y - slope * x, slope })
}

/// Of each of several curves, which points are on their common front (Pareto's): at that x no other curve has come lower,
/// and none was as low before. A curve stays at its last point where it ends.
pub fn front(curves: &[Vec<[f64; 2]>]) -> Vec<Vec<usize>> {
    let lowest = |curve: &[[f64; 2]], x: f64| match (curve.first(), curve.last()) {
        (Some(first), Some(last)) if x >= first[0] => value(curve, x.min(last[0])).map(|found| found.value),
        _ => None,
    };
    let beats = |curve: &[[f64; 2]], [x, y]: [f64; 2]| {
        let was_there = curve.last().is_some_and(|last| last[0] < x && last[1] <= y);
        was_there || lowest(curve, x).is_some_and(|other| other < y)
    };
    let on_front = |own: usize, point: [f64; 2]| {
        curves.iter().enumerate().all(|(index, curve)| index == own || !beats(curve, point))
    };
    let places = |(own, curve): (usize, &Vec<[f64; 2]>)| {
        (0..curve.len()).filter(|&place| on_front(own, curve[place])).collect()
    };
    curves.iter().enumerate().map(places).collect()
}
