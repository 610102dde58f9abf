//! −2 ln L = Σ_b [n_b ln S_b + Σ(c − aβ)²/S_b] (+ ln|Σ a aᵀ/S|, restricted), minimized by Fisher scoring in the variances.
//!
//! Each step is a non-negative least squares of the bins' powers on the terms' shapes with weights n/S²; correlation
//! times join as ln T_c. Regressors are profiled out at every S. Sources: [Whittle1953], [PattersonThompson1971] for the
//! restricted likelihood.

use super::bins::{BinnedLog, dot};
use super::fill::FilledBins;
use super::linear::{bounded_least_squares, cholesky, cholesky_solve, inverse};
use super::spectra::GaussMarkovShape;
use std::f64::consts::PI;
use std::ops::Range;
use std::sync::Arc;

/// Index of Q, N, B, K among the parameters; Gauss–Markov term i has its variance at 4 + 2i, ln(T_c/dt) after it.
pub(crate) const Q: usize = 0;
pub(crate) const N: usize = 1;
pub(crate) const B: usize = 2;
pub(crate) const K: usize = 3;
pub(crate) const FIRST_GM: usize = 4;
pub(crate) const PARAMETERS: usize = 8;

/// Shapes of the Gauss–Markov terms; empty where there is none.
type Shapes = [Arc<Vec<f64>>; 2];
/// Variances (in units of the scale²) and ln(T_c/dt) of the terms.
pub(crate) type Parameters = [f64; PARAMETERS];
/// Which parameters a fit may move; the others keep their value (a variance of 0: not there).
pub(crate) type Free = [bool; PARAMETERS];

/// The bins of one log inside a problem, with its own regressors.
#[derive(Debug, Clone)]
struct Group {
    bins: Range<usize>,
    columns: usize,
    ya: Vec<f64>,
    aa: Vec<f64>,
    /// The log's step over that of the parameters.
    step: f64,
}

/// What the ends of a finite log change in a bin: (πj)², the segment's length, (−1)^j (0 between whole numbers).
#[derive(Debug, Clone, Default)]
struct Ends {
    a2: Vec<f64>,
    n: Vec<f64>,
    sign: Vec<f64>,
}

/// Bins of one or several logs with common noise terms.
#[derive(Debug, Clone)]
pub(crate) struct Problem {
    pub u: Arc<Vec<f64>>,
    nodes: Arc<[Vec<f64>; 3]>,
    ends: Arc<Ends>,
    /// Coefficients of each bin, each counted by its weight.
    pub count: Arc<Vec<f64>>,
    /// What a coefficient of each bin counts.
    weight: Arc<Vec<f64>>,
    filled: Option<Arc<FilledBins>>,
    yy: Vec<f64>,
    basis: Arc<[Vec<f64>; 4]>,
    groups: Vec<Group>,
    /// Bounds of ln(T_c/dt) in the fit.
    pub log_time: (f64, f64),
    /// ln(T_c/dt) from which a process is reported.
    pub shortest: f64,
    /// Whether ln|Σ a aᵀ/S| is added.
    pub restricted: bool,
}

/// The minimum found.
#[derive(Debug, Clone)]
pub(crate) struct Solution {
    pub parameters: Parameters,
    /// −2 ln L but for a constant.
    pub objective: f64,
    /// Coefficients of the regressors, per group.
    pub beta: Vec<Vec<f64>>,
    /// Their covariance given the spectrum, per group.
    pub beta_covariance: Vec<Vec<f64>>,
}

struct Evaluation {
    objective: f64,
    /// Mean residual power of each bin, with the leverage of the regressors where the likelihood is restricted.
    power: Vec<f64>,
    beta: Vec<Vec<f64>>,
    covariance: Vec<Vec<f64>>,
}

impl Problem {
    /// A problem of the logs' bins; `restricted` as in the field.
    pub(crate) fn new(logs: &[&BinnedLog], restricted: bool) -> Self {
        let mut u = Vec::new();
        let mut nodes: [Vec<f64>; 3] = Default::default();
        let mut ends = Ends::default();
        let mut count = Vec::new();
        let mut weight = Vec::new();
        let mut yy = Vec::new();
        let mut basis: [Vec<f64>; 4] = Default::default();
        let mut groups = Vec::with_capacity(logs.len());
        // The longest log and the highest frequency, in steps of the parameters.
        let (mut longest, mut top) = (0.0_f64, 0.0_f64);
        for log in logs {
            let start = u.len();
            let step = log.step.unwrap_or(1.0);
            longest = log.n.iter().fold(longest, |l, n| l.max(n * step));
            top = log.u.iter().fold(top, |t, u| t.max(u / step));
            u.extend_from_slice(&log.u);
            for (k, all) in nodes.iter_mut().enumerate() {
                all.extend(log.nodes.iter().map(|n| n[k]));
            }
            ends.a2.extend(log.j.iter().map(|j| (PI * j).powi(2)));
            ends.n.extend_from_slice(&log.n);
            ends.sign.extend(log.j.iter().map(|j| {
                if j.fract() != 0.0 {
                    0.0
                } else if j % 2.0 == 0.0 {
                    1.0
                } else {
                    -1.0
                }
            }));
            count.extend_from_slice(&log.count);
            weight.extend_from_slice(&log.weight);
            yy.extend_from_slice(&log.yy);
            for (all, own) in basis.iter_mut().zip(&log.basis) {
                all.extend_from_slice(own);
            }
            groups.push(Group {
                bins: start..u.len(),
                columns: log.columns,
                ya: log.ya.clone(),
                aa: log.aa.clone(),
                step,
            });
        }
        let mut out = Self {
            u: Arc::new(u),
            nodes: Arc::new(nodes),
            ends: Arc::new(ends),
            count: Arc::new(count),
            weight: Arc::new(weight),
            filled: FilledBins::of(logs).map(Arc::new),
            yy,
            basis: Arc::new(basis),
            groups,
            log_time: (0.0, 0.0),
            shortest: 0.0,
            restricted,
        };
        out.bound_times((longest, top), logs.iter().any(|log| log.fast));
        out
    }

    /// The same bins with only the `keep` columns of every group.
    pub(crate) fn with_columns(&self, keep: &[usize], restricted: bool) -> Self {
        let mut out = self.clone();
        out.restricted = restricted;
        for group in &mut out.groups {
            let (p, q) = (group.columns, keep.len());
            let bins = group.bins.len();
            let mut ya = Vec::with_capacity(bins * q);
            let mut aa = Vec::with_capacity(bins * q * q);
            for b in 0..bins {
                for &i in keep {
                    ya.push(group.ya[b * p + i]);
                }
                for &i in keep {
                    for &k in keep {
                        aa.push(group.aa[(b * p + i) * p + k]);
                    }
                }
            }
            group.columns = q;
            group.ya = ya;
            group.aa = aa;
        }
        out
    }

    /// The same bins with column `column` taken out at the coefficient `value` (first group only).
    pub(crate) fn with_held_column(&self, column: usize, value: f64) -> Self {
        let mut out = self.clone();
        if let Some(group) = out.groups.first_mut() {
            let p = group.columns;
            for (k, b) in group.bins.clone().enumerate() {
                out.yy[b] += value * value * group.aa[(k * p + column) * p + column]
                    - 2.0 * value * group.ya[k * p + column];
                for i in 0..p {
                    group.ya[k * p + i] -= value * group.aa[(k * p + column) * p + i];
                }
            }
        }
        let keep: Vec<usize> = (0..self.columns()).filter(|&i| i != column).collect();
        out.with_columns(&keep, self.restricted)
    }

    /// Columns of the first group.
    pub(crate) fn columns(&self) -> usize {
        self.groups.first().map_or(0, |g| g.columns)
    }

    /// Number of coefficients.
    pub(crate) fn coefficients(&self) -> f64 {
        self.count.iter().sum()
    }

    /// Coefficients of each bin, every one counted in full.
    pub(crate) fn plain_count(&self) -> Vec<f64> {
        self.count
            .iter()
            .zip(self.weight.iter())
            .map(|(n, w)| n / w)
            .collect()
    }

    /// Mean power of each bin as measured, regressors not taken out.
    pub(crate) fn raw_power(&self) -> Vec<f64> {
        self.yy
            .iter()
            .zip(self.count.iter())
            .map(|(y, n)| y / n)
            .collect()
    }

    /// Shape of a Gauss–Markov term in every bin.
    pub(crate) fn gauss_markov_basis(&self, log_time: f64) -> Vec<f64> {
        let mut out = vec![0.0; self.u.len()];
        for group in &self.groups {
            self.gauss_markov_of(group, (-log_time).exp() * group.step, &mut out);
        }
        out
    }

    /// The same in the bins of one log, whose step is `h` correlation times.
    fn gauss_markov_of(&self, group: &Group, h: f64, out: &mut [f64]) {
        let shape = GaussMarkovShape::new(h);
        let [low, middle, high] = &*self.nodes;
        let bins = group.bins.clone();
        match &self.filled {
            None => {
                for b in bins.clone() {
                    let sum = 5.0 * shape.at(low[b])
                        + 8.0 * shape.at(middle[b])
                        + 5.0 * shape.at(high[b]);
                    out[b] = sum / 18.0;
                }
            }
            Some(filled) => {
                for b in bins.clone() {
                    out[b] = filled.coherent(b, &shape, [low[b], middle[b], high[b]]);
                }
            }
        }
        // Expected over spectrum at the lowest coefficients: 1 − 2κ(1 − q)/(κ² + π²j²), κ = T/T_c, q = e^{−κ}(−1)^j.
        let ends = &*self.ends;
        let (mut kappa, mut decay) = (0.0, 1.0);
        for b in bins.clone() {
            let own = ends.n[b] * h;
            if own != kappa {
                kappa = own;
                decay = if kappa < 40.0 { (-kappa).exp() } else { 0.0 };
            }
            out[b] *=
                1.0 - 2.0 * kappa * (1.0 - decay * ends.sign[b]) / (kappa * kappa + ends.a2[b]);
        }
        if let Some(filled) = &self.filled {
            filled.add_scattered(out, bins, &shape);
        }
    }

    /// Shape of the single term `index` (Q, N, B, K).
    pub(crate) fn basis(&self, index: usize) -> &[f64] {
        &self.basis[index]
    }

    /// Spectrum of the parameters in every bin, in units of the scale².
    pub(crate) fn spectrum(&self, parameters: &Parameters) -> Vec<f64> {
        let shapes = self.shapes(parameters);
        self.spectrum_of(parameters, &shapes)
    }

    fn shapes(&self, parameters: &Parameters) -> Shapes {
        self.all_shapes(parameters, &[false; PARAMETERS], None)
    }

    fn spectrum_of(&self, parameters: &Parameters, shapes: &Shapes) -> Vec<f64> {
        let mut s = vec![1e-300; self.u.len()];
        for k in 0..4 {
            if parameters[k] > 0.0 {
                for (s, phi) in s.iter_mut().zip(&self.basis[k]) {
                    *s += parameters[k] * phi;
                }
            }
        }
        for (i, shape) in shapes.iter().enumerate() {
            let v = parameters[FIRST_GM + 2 * i];
            if v > 0.0 {
                for (s, phi) in s.iter_mut().zip(shape.iter()) {
                    *s += v * phi;
                }
            }
        }
        s
    }

    fn evaluate(&self, s: &[f64]) -> Evaluation {
        let mut objective = 0.0;
        for b in 0..s.len() {
            objective += self.count[b] * s[b].ln() + self.yy[b] / s[b];
        }
        let mut power = self.raw_power();
        let mut beta = Vec::with_capacity(self.groups.len());
        let mut covariance = Vec::with_capacity(self.groups.len());
        for group in &self.groups {
            let p = group.columns;
            if p == 0 {
                beta.push(Vec::new());
                covariance.push(Vec::new());
                continue;
            }
            let mut m = vec![0.0; p * p];
            let mut h = vec![0.0; p];
            for (k, b) in group.bins.clone().enumerate() {
                let w = 1.0 / s[b];
                for i in 0..p {
                    h[i] += w * group.ya[k * p + i];
                }
                for i in 0..p * p {
                    m[i] += w * group.aa[k * p * p + i];
                }
            }
            // Columns that the bins hardly see are held at zero by their own tiny information.
            for i in 0..p {
                if m[i * p + i] <= 0.0 {
                    m[i * p + i] = 1e-300;
                }
            }
            let Some(inv) = inverse(&m, p) else {
                objective += 1e30;
                beta.push(vec![0.0; p]);
                covariance.push(vec![0.0; p * p]);
                continue;
            };
            let coefficients: Vec<f64> = (0..p)
                .map(|i| (0..p).map(|k| inv[i * p + k] * h[k]).sum())
                .collect();
            objective -= (0..p).map(|i| h[i] * coefficients[i]).sum::<f64>();
            if self.restricted {
                objective -= log_determinant(&inv, p);
            }
            for (k, b) in group.bins.clone().enumerate() {
                let mut change = 0.0;
                for i in 0..p {
                    change -= 2.0 * coefficients[i] * group.ya[k * p + i];
                    for l in 0..p {
                        let a = group.aa[(k * p + i) * p + l];
                        change += coefficients[i] * coefficients[l] * a;
                        if self.restricted {
                            change += inv[i * p + l] * a;
                        }
                    }
                }
                power[b] += change / self.count[b];
            }
            beta.push(coefficients);
            covariance.push(inv);
        }
        Evaluation {
            objective,
            power,
            beta,
            covariance,
        }
    }

    /// Mean residual power of each bin with the regressors of `solution` taken out.
    pub(crate) fn residual_power(&self, solution: &Solution) -> Vec<f64> {
        let mut plain = self.clone();
        plain.restricted = false;
        plain.evaluate(&self.spectrum(&solution.parameters)).power
    }

    /// −2 ln L of given parameters.
    pub(crate) fn objective(&self, parameters: &Parameters) -> f64 {
        self.evaluate(&self.spectrum(parameters)).objective
    }

    /// A start from the measured powers alone, smoothed.
    pub(crate) fn start(&self, free: &Free) -> Parameters {
        let raw = self.raw_power();
        let mut smooth = vec![0.0; raw.len()];
        for group in &self.groups {
            let range = group.bins.clone();
            let mut order: Vec<usize> = range.collect();
            order.sort_by(|&a, &b| self.u[a].total_cmp(&self.u[b]));
            for (place, &b) in order.iter().enumerate() {
                let (from, to) = (place.saturating_sub(4), (place + 5).min(order.len()));
                let mut sum = 0.0;
                let mut count = 0.0;
                for &o in &order[from..to] {
                    let n = self.count[o].min(8.0);
                    sum += n * raw[o].max(1e-300).ln();
                    count += n;
                }
                smooth[b] = (sum / count).exp();
            }
        }
        let mut parameters = [0.0; PARAMETERS];
        let linear: Vec<usize> = (0..4).filter(|&k| free[k]).collect();
        let k = linear.len();
        let mut h = vec![0.0; k * k];
        let mut c = vec![0.0; k];
        for b in 0..raw.len() {
            let w = self.count[b] / (smooth[b] * smooth[b]);
            for (p, &i) in linear.iter().enumerate() {
                c[p] += w * raw[b] * self.basis[i][b];
                for (q, &l) in linear.iter().enumerate() {
                    h[p * k + q] += w * self.basis[i][b] * self.basis[l][b];
                }
            }
        }
        let x = bounded_least_squares(&h, &c, &vec![true; k]);
        for (p, &i) in linear.iter().enumerate() {
            parameters[i] = x[p];
        }
        if parameters.iter().all(|&v| v <= 0.0) {
            let mean = self.yy.iter().sum::<f64>() / self.coefficients().max(1.0);
            for &i in linear.iter().take(1) {
                parameters[i] = mean;
            }
        }
        parameters
    }

    /// Minimizes over the free parameters from `start`.
    pub(crate) fn fit(&self, start: &Parameters, free: &Free) -> Solution {
        self.fit_limited(start, free, 60)
    }

    /// As `fit`, with at most `steps` steps.
    pub(crate) fn fit_limited(&self, start: &Parameters, free: &Free, steps: usize) -> Solution {
        let mut parameters = *start;
        // A start without any power has no likelihood.
        if parameters[..4].iter().all(|&v| v <= 0.0)
            && parameters[FIRST_GM] <= 0.0
            && parameters[FIRST_GM + 2] <= 0.0
        {
            parameters = self.start(free);
        }
        let mut shapes = self.all_shapes(&parameters, free, None);
        let mut s = self.spectrum_of(&parameters, &shapes);
        let mut now = self.evaluate(&s);
        for _ in 0..steps {
            let (indices, x) = self.step(&parameters, free, &shapes, &s, &now.power);
            let mut delta = [0.0; PARAMETERS];
            for (&i, &value) in indices.iter().zip(&x) {
                delta[i] = if is_time(i) {
                    value.clamp(-0.7, 0.7)
                } else {
                    value - parameters[i]
                };
            }
            let mut length = 1.0;
            let mut gained = None;
            while length > 1e-4 {
                let mut next = parameters;
                for &i in &indices {
                    next[i] += length * delta[i];
                    if is_time(i) {
                        next[i] = next[i].clamp(self.log_time.0, self.log_time.1);
                    } else {
                        next[i] = next[i].max(0.0);
                    }
                }
                let next_shapes = self.all_shapes(&next, free, Some((&parameters, &shapes)));
                let next_s = self.spectrum_of(&next, &next_shapes);
                let tried = self.evaluate(&next_s);
                if tried.objective < now.objective
                    || tried.objective.is_nan() != now.objective.is_nan()
                {
                    gained = Some((
                        now.objective - tried.objective,
                        next,
                        next_shapes,
                        next_s,
                        tried,
                    ));
                    break;
                }
                length *= 0.4;
            }
            let Some((gain, next, next_shapes, next_s, tried)) = gained else {
                break;
            };
            parameters = next;
            shapes = next_shapes;
            s = next_s;
            now = tried;
            if gain < 2e-5 {
                break;
            }
        }
        Solution {
            parameters,
            objective: now.objective,
            beta: now.beta,
            beta_covariance: now.covariance,
        }
    }

    /// Shapes of every Gauss–Markov term that is there or may come; those of `known` are taken over where T_c stands.
    fn all_shapes(
        &self,
        parameters: &Parameters,
        free: &Free,
        known: Option<(&Parameters, &Shapes)>,
    ) -> Shapes {
        [0, 1].map(|i| {
            let at = FIRST_GM + 2 * i;
            if parameters[at] <= 0.0 && !free[at] {
                return Arc::default();
            }
            match known {
                Some((old, shapes))
                    if old[at + 1] == parameters[at + 1] && !shapes[i].is_empty() =>
                {
                    Arc::clone(&shapes[i])
                }
                _ => Arc::new(self.gauss_markov_basis(parameters[at + 1])),
            }
        })
    }

    /// One scoring step: the free parameters' indices and their new variances (for T_c: the change of its logarithm).
    fn step(
        &self,
        parameters: &Parameters,
        free: &Free,
        shapes: &Shapes,
        s: &[f64],
        power: &[f64],
    ) -> (Vec<usize>, Vec<f64>) {
        let mut indices = Vec::with_capacity(PARAMETERS);
        let mut derivatives: [Vec<f64>; 2] = Default::default();
        for i in 0..PARAMETERS {
            if !free[i] {
                continue;
            }
            if is_time(i) {
                if parameters[i - 1] <= 0.0 {
                    continue;
                }
                let g = (i - FIRST_GM) / 2;
                derivatives[g] = self.time_derivative(parameters, g, &shapes[g]);
            }
            indices.push(i);
        }
        let columns: Vec<&[f64]> = indices
            .iter()
            .map(|&i| match i {
                0..4 => self.basis[i].as_slice(),
                _ if is_time(i) => derivatives[(i - FIRST_GM) / 2].as_slice(),
                _ => shapes[(i - FIRST_GM) / 2].as_slice(),
            })
            .collect();
        // What the held parameters give stays out of the target.
        let mut held = s.to_vec();
        for (&i, column) in indices.iter().zip(&columns) {
            if !is_time(i) && parameters[i] > 0.0 {
                for (h, phi) in held.iter_mut().zip(*column) {
                    *h -= parameters[i] * phi;
                }
            }
        }
        let k = indices.len();
        let mut h = vec![0.0; k * k];
        let mut c = vec![0.0; k];
        let weight: Vec<f64> = self.count.iter().zip(s).map(|(n, s)| n / (s * s)).collect();
        for (h, p) in held.iter_mut().zip(power) {
            *h = p - *h;
        }
        let mut weighted = vec![0.0; s.len()];
        for p in 0..k {
            for ((out, w), phi) in weighted.iter_mut().zip(&weight).zip(columns[p]) {
                *out = w * phi;
            }
            c[p] = dot(&weighted, &held);
            for q in 0..=p {
                let value = dot(&weighted, columns[q]);
                h[p * k + q] = value;
                h[q * k + p] = value;
            }
        }
        let bounded: Vec<bool> = indices.iter().map(|&i| !is_time(i)).collect();
        let x = bounded_least_squares(&h, &c, &bounded);
        (indices, x)
    }

    fn time_derivative(&self, parameters: &Parameters, g: usize, shape: &[f64]) -> Vec<f64> {
        const STEP: f64 = 1e-4;
        let at = FIRST_GM + 2 * g;
        self.gauss_markov_basis(parameters[at + 1] + STEP)
            .iter()
            .zip(shape)
            .map(|(a, b)| parameters[at] * (a - b) / STEP)
            .collect()
    }

    /// Information matrix ½ Σ n ∂ln S/∂θ_a ∂ln S/∂θ_b of the parameters at `indices` (variances and ln T_c).
    pub(crate) fn information(&self, parameters: &Parameters, indices: &[usize]) -> Vec<f64> {
        let mut wanted = [false; PARAMETERS];
        for &i in indices {
            wanted[i] = true;
        }
        let shapes = self.all_shapes(parameters, &wanted, None);
        let s = self.spectrum_of(parameters, &shapes);
        let columns: Vec<Vec<f64>> = indices
            .iter()
            .map(|&i| {
                if i < 4 {
                    self.basis[i].clone()
                } else if is_time(i) {
                    let g = (i - FIRST_GM) / 2;
                    self.time_derivative(parameters, g, &shapes[g])
                } else {
                    shapes[(i - FIRST_GM) / 2].to_vec()
                }
            })
            .collect();
        let k = indices.len();
        let mut out = vec![0.0; k * k];
        for p in 0..k {
            for q in 0..=p {
                let sum: f64 = (0..s.len())
                    .map(|b| 0.5 * self.count[b] / (s[b] * s[b]) * columns[p][b] * columns[q][b])
                    .sum();
                out[p * k + q] = sum;
                out[q * k + p] = sum;
            }
        }
        out
    }
}

/// Whether a parameter is the logarithm of a correlation time.
pub(crate) fn is_time(index: usize) -> bool {
    index > FIRST_GM && (index - FIRST_GM) % 2 == 1
}

fn log_determinant(matrix: &[f64], n: usize) -> f64 {
    let scale: Vec<f64> = (0..n).map(|i| matrix[i * n + i].sqrt()).collect();
    let mut unit = matrix.to_vec();
    for i in 0..n {
        for j in 0..n {
            unit[i * n + j] /= scale[i] * scale[j];
        }
    }
    let diagonal: f64 = scale.iter().map(|s| 2.0 * s.ln()).sum();
    cholesky(&unit, n).map_or(0.0, |l| {
        diagonal + (0..n).map(|i| 2.0 * l[i * n + i].ln()).sum::<f64>()
    })
}

/// Solves the small normal equations of a local fit; none where they are singular.
pub(crate) fn solve(matrix: &[f64], right: &[f64]) -> Option<Vec<f64>> {
    cholesky(matrix, right.len()).map(|l| cholesky_solve(&l, right))
}
