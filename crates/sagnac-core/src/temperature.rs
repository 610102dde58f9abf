//! Dependence of bias and scale factor on temperature: b(T) = c_0 + Σ_{i≥1} c_i θ^i, θ = T − T0.
//!
//! The polynomial is about the reference temperature T0, not about 0 °C, so that the fixed
//! part is the value at T0. In its place, or beside it, a natural cubic spline in T may
//! stand. Outside the temperature range the nearer end counts.
//! Lecture slides 4 and 5 ("often modeled as a function of temperature"); [IEEE1293], [IEEE952].

use crate::{Real, flags, vector::Vector};

/// The highest power of θ.
pub const MAX_POWER: usize = 8;
/// The most knots a spline can have.
pub const MAX_KNOTS: usize = 16;
/// The range that counts where a model states none, °C.
pub const DEFAULT_RANGE_C: [f64; 2] = [-40.0, 85.0];

/// What temperature adds to the three axes of a bias or a scale factor.
///
/// ```
/// use sagnac_core::{TemperatureDependence, Thermal};
///
/// // +0.4 units a kelvin on x, about T0 = 25 °C.
/// let mut of_bias = TemperatureDependence::default();
/// of_bias.polynomial[0] = [0.4, 0.0, 0.0];
/// let thermal = Thermal::new(&of_bias, 25.0, None);
/// assert_eq!(thermal.at(35.0)[0], 4.0);
/// assert_eq!(thermal.at(25.0)[0], 0.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct TemperatureDependence<T> {
    /// c_1 … c_8: row i − 1 holds the coefficients of θ^i for x, y, z (unit of the term / Kⁱ).
    pub polynomial: [Vector<T>; MAX_POWER],
    /// A spline in T, added to the polynomial (which is zero in files that have a spline).
    pub spline: Option<TemperatureSpline<T>>,
    /// Where this holds, °C: wins over the model's range.
    pub range_c: Option<[T; 2]>,
}

impl<T: Real> TemperatureDependence<T> {
    /// The highest power with a coefficient that is not zero; 0 where there is none.
    pub fn order(&self) -> usize {
        let mut order = 0;
        for (i, row) in self.polynomial.iter().enumerate() {
            if row.iter().any(|c| *c != T::ZERO) {
                order = i + 1;
            }
        }
        order
    }

    /// Whether temperature changes anything.
    pub fn is_present(&self) -> bool {
        self.order() > 0 || self.spline.is_some()
    }

    /// The range that counts for this table: its own, else the model's, else the spline's knots.
    pub fn effective_range_c(&self, of_model: Option<[T; 2]>) -> Option<[T; 2]> {
        self.range_c
            .or(of_model)
            .or(self.spline.as_ref().map(TemperatureSpline::range_c))
    }
}

/// What is wrong with the knots of a spline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SplineError {
    /// Fewer than two knots, or more than [`MAX_KNOTS`].
    Count {
        /// How many were given.
        found: usize,
    },
    /// As many values as knots are needed.
    Lengths {
        /// Knots given.
        knots: usize,
        /// Values given.
        values: usize,
    },
    /// The knots do not rise, or one is not finite.
    Order {
        /// The place of the first such knot, from 0.
        at: usize,
    },
}

impl core::fmt::Display for SplineError {
    fn fmt(&self, out: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Count { found } => {
                write!(out, "a spline has 2 to {MAX_KNOTS} knots, this one {found}")
            }
            Self::Lengths { knots, values } => {
                write!(out, "{knots} knots need as many values, found {values}")
            }
            Self::Order { at } => write!(out, "knot {} is not above the one before it", at + 1),
        }
    }
}

impl core::error::Error for SplineError {}

/// One piece of a spline: Σ_i c_i (T − start)^i, i = 0…3, from `start_c` to the next piece.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Segment<T> {
    /// Where the piece begins, °C.
    pub start_c: T,
    /// c_0 … c_3 of each axis.
    pub coefficients: [Vector<T>; 4],
}

/// A natural cubic spline in temperature (second derivative zero at both ends), held outside.
///
/// ```
/// use sagnac_core::TemperatureSpline;
///
/// let spline = TemperatureSpline::new(&[0.0, 10.0, 20.0], &[[0.0; 3], [1.0; 3], [0.0; 3]])?;
/// assert_eq!(spline.at(10.0)[1], 1.0);
/// assert_eq!(spline.at(5.0)[1], 0.6875); // 11/16, as the natural spline has it
/// assert_eq!(spline.at(50.0)[1], 0.0);
/// # Ok::<(), sagnac_core::SplineError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TemperatureSpline<T> {
    segments: [Segment<T>; MAX_KNOTS - 1],
    count: usize,
    end_c: T,
}

impl<T: Real> TemperatureSpline<T> {
    /// The spline through `values` (x, y, z) at `knots_c` (°C).
    ///
    /// # Errors
    /// [`SplineError`] where there are fewer than 2 or more than 16 knots, where they do not
    /// rise, or where the two lists differ in length.
    pub fn new(knots_c: &[T], values: &[Vector<T>]) -> Result<Self, SplineError> {
        let n = knots_c.len();
        if !(2..=MAX_KNOTS).contains(&n) {
            return Err(SplineError::Count { found: n });
        }
        if values.len() != n {
            return Err(SplineError::Lengths {
                knots: n,
                values: values.len(),
            });
        }
        for (at, pair) in knots_c.windows(2).enumerate() {
            if let [a, b] = pair
                && !(a < b && a.is_finite() && b.is_finite())
            {
                return Err(SplineError::Order { at: at + 1 });
            }
        }
        let mut x = [T::ZERO; MAX_KNOTS];
        let mut y = [[T::ZERO; 3]; MAX_KNOTS];
        for ((to, from), (value_to, value)) in
            x.iter_mut().zip(knots_c).zip(y.iter_mut().zip(values))
        {
            *to = *from;
            *value_to = *value;
        }
        let mut segments = [Segment::default(); MAX_KNOTS - 1];
        for axis in 0..3 {
            let second = second_derivatives(&x, &y, n, axis);
            for i in 0..n.min(MAX_KNOTS) - 1 {
                let h = x[i + 1] - x[i];
                let slope = (y[i + 1][axis] - y[i][axis]) / h;
                let six = T::from_f64(6.0);
                let segment = &mut segments[i];
                segment.start_c = x[i];
                segment.coefficients[0][axis] = y[i][axis];
                segment.coefficients[1][axis] =
                    slope - h * (second[i] + second[i] + second[i + 1]) / six;
                segment.coefficients[2][axis] = second[i] * T::HALF;
                segment.coefficients[3][axis] = (second[i + 1] - second[i]) / (six * h);
            }
        }
        Ok(Self {
            segments,
            count: n - 1,
            end_c: x[(n - 1).min(MAX_KNOTS - 1)],
        })
    }

    /// From the first to the last knot, °C.
    pub fn range_c(&self) -> [T; 2] {
        [self.segments[0].start_c, self.end_c]
    }

    /// The pieces, in order.
    pub fn segments(&self) -> &[Segment<T>] {
        self.segments.get(..self.count).unwrap_or(&[])
    }

    /// The values at a temperature, held outside the knots; NaN for NaN.
    #[inline]
    pub fn at(&self, temperature_c: T) -> Vector<T> {
        let t = temperature_c.held(self.segments[0].start_c, self.end_c);
        let mut piece = &self.segments[0];
        for (i, segment) in self.segments.iter().enumerate() {
            if i < self.count && segment.start_c <= t {
                piece = segment;
            }
        }
        let u = t - piece.start_c;
        let c = &piece.coefficients;
        let mut value = [T::ZERO; 3];
        for axis in 0..3 {
            value[axis] = c[0][axis] + u * (c[1][axis] + u * (c[2][axis] + u * c[3][axis]));
        }
        value
    }

    /// The same spline in the other precision, or in this one.
    pub fn convert<S: Real>(&self) -> TemperatureSpline<S> {
        TemperatureSpline {
            segments: self.segments.map(|segment| Segment {
                start_c: S::from_f64(segment.start_c.to_f64()),
                coefficients: segment
                    .coefficients
                    .map(|row| row.map(|c| S::from_f64(c.to_f64()))),
            }),
            count: self.count,
            end_c: S::from_f64(self.end_c.to_f64()),
        }
    }
}

/// Second derivatives at the knots: the tridiagonal system of the natural spline (Thomas).
fn second_derivatives<T: Real>(
    x: &[T; MAX_KNOTS],
    y: &[Vector<T>; MAX_KNOTS],
    n: usize,
    axis: usize,
) -> [T; MAX_KNOTS] {
    let mut upper = [T::ZERO; MAX_KNOTS];
    let mut right = [T::ZERO; MAX_KNOTS];
    let two = T::ONE + T::ONE;
    let six = T::from_f64(6.0);
    let last = n.min(MAX_KNOTS) - 1;
    for i in 1..last {
        let before = x[i] - x[i - 1];
        let after = x[i + 1] - x[i];
        let bend = (y[i + 1][axis] - y[i][axis]) / after - (y[i][axis] - y[i - 1][axis]) / before;
        let pivot = two * (before + after) - before * upper[i - 1];
        upper[i] = after / pivot;
        right[i] = (six * bend - before * right[i - 1]) / pivot;
    }
    let mut second = [T::ZERO; MAX_KNOTS];
    for i in (1..last).rev() {
        second[i] = right[i] - upper[i] * second[i + 1];
    }
    second
}

/// A [`TemperatureDependence`] made ready: its range settled and its order counted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thermal<T> {
    polynomial: [Vector<T>; MAX_POWER],
    order: usize,
    spline: Option<TemperatureSpline<T>>,
    reference_c: T,
    range_c: Option<[T; 2]>,
}

impl<T: Real> Thermal<T> {
    /// Ready for use with the model's T0 and range, °C.
    pub fn new(
        of: &TemperatureDependence<T>,
        reference_c: T,
        model_range_c: Option<[T; 2]>,
    ) -> Self {
        Self {
            polynomial: of.polynomial,
            order: of.order(),
            spline: of.spline,
            reference_c,
            range_c: of.effective_range_c(model_range_c),
        }
    }

    /// Whether temperature changes anything.
    pub fn is_present(&self) -> bool {
        self.order > 0 || self.spline.is_some()
    }

    /// The range that counts, °C, where one is stated.
    pub fn range_c(&self) -> Option<[T; 2]> {
        self.range_c
    }

    /// A temperature held at the ends of the range, °C.
    pub fn held(&self, temperature_c: T) -> T {
        match self.range_c {
            Some([low, high]) => temperature_c.held(low, high),
            None => temperature_c,
        }
    }

    /// The coefficients of θ … θ^order.
    pub fn polynomial(&self) -> &[Vector<T>] {
        self.polynomial.get(..self.order).unwrap_or(&[])
    }

    /// The spline, where there is one.
    pub fn spline(&self) -> Option<&TemperatureSpline<T>> {
        self.spline.as_ref()
    }

    /// What is added at a temperature (°C): x, y, z; NaN for NaN where anything depends on it.
    #[inline]
    pub fn at(&self, temperature_c: T) -> Vector<T> {
        let mut sum = [[T::ZERO]; 3];
        self.add_to(&[temperature_c], &mut sum);
        [sum[0][0], sum[1][0], sum[2][0]]
    }

    /// What temperature adds, added to N samples of each axis.
    #[inline(always)]
    pub fn add_to<const N: usize>(&self, temperature_c: &[T; N], to: &mut [[T; N]; 3]) {
        if !self.is_present() {
            return;
        }
        if let ([row], None) = (self.polynomial(), &self.spline) {
            // The usual case in one pass; without a range every temperature is within it.
            let (row, reference_c) = (*row, self.reference_c);
            let [low, high] = self.range_c.unwrap_or([-T::INFINITY, T::INFINITY]);
            for i in 0..N {
                let theta = temperature_c[i].held(low, high) - reference_c;
                for axis in 0..3 {
                    to[axis][i] += row[axis] * theta;
                }
            }
            return;
        }
        let mut t = *temperature_c;
        if let Some([low, high]) = self.range_c {
            for i in 0..N {
                t[i] = t[i].held(low, high);
            }
        }
        let mut sum = [[T::ZERO; N]; 3];
        let reference_c = self.reference_c;
        for row in self.polynomial().iter().rev() {
            let row = *row;
            for i in 0..N {
                let theta = t[i] - reference_c;
                for axis in 0..3 {
                    sum[axis][i] = (sum[axis][i] + row[axis]) * theta;
                }
            }
        }
        if let Some(spline) = &self.spline {
            for i in 0..N {
                let more = spline.at(t[i]);
                for axis in 0..3 {
                    sum[axis][i] += more[axis];
                }
            }
        }
        for axis in 0..3 {
            for i in 0..N {
                to[axis][i] += sum[axis][i];
            }
        }
    }

    /// Sets the flags of samples outside the stated range, or, where none is stated, beyond
    /// −40…85 °C. NaN sets none.
    #[inline(always)]
    pub(crate) fn flag<const N: usize>(&self, temperature_c: &[T; N], to: &mut [u32; N]) {
        if !self.is_present() {
            return;
        }
        let ([low, high], bit) = match self.range_c {
            Some(range) => (range, flags::TEMPERATURE),
            None => (DEFAULT_RANGE_C.map(T::from_f64), flags::OUTSIDE_VALIDITY),
        };
        for i in 0..N {
            let t = temperature_c[i];
            if t < low || t > high {
                to[i] |= bit;
            }
        }
    }
}
