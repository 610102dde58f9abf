//! Price classes in USD: the printed one, or our estimate from the gyro's bias.

use crate::catalog_table::PRICE_CLASSES;
use crate::model::Model;
use sagnac_core::Sensor;

/// A price class and what it rests on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PriceClass {
    /// One of [`PRICE_CLASSES`].
    pub class: &'static str,
    /// The printed source, or `estimated from gyro bias`.
    pub evidence: String,
}

/// USD for a euro.
const USD_PER_EUR: f64 = 1.1;

impl PriceClass {
    /// The place among the classes, cheapest first.
    pub fn rank(&self) -> usize {
        PRICE_CLASSES
            .iter()
            .position(|class| *class == self.class)
            .unwrap_or(PRICE_CLASSES.len())
    }

    /// The printed price in USD, its lower and upper end, where the evidence begins with one: `20000-30000 USD, …`.
    pub fn printed_usd(&self) -> Option<(f64, f64)> {
        let mut words = self.evidence.split_whitespace();
        let number = words.next()?;
        let factor = match words.next()?.trim_end_matches([',', ':']) {
            "USD" => 1.0,
            "EUR" => USD_PER_EUR,
            _ => return None,
        };
        let (low, high) = number.split_once('-').unwrap_or((number, number));
        let usd = |text: &str| Some(text.parse::<f64>().ok()? * factor).filter(|v| *v > 0.0);
        Some((usd(low)?, usd(high)?))
    }

    /// The letter of the evidence: `D` data sheet, `M` measured, `S` second hand.
    pub fn letter(&self) -> Option<&'static str> {
        ["D", "M", "S"]
            .into_iter()
            .find(|letter| self.evidence.contains(&format!(": {letter}: ")))
    }
}

/// 1 deg/h in rad/s.
const DEG_PER_H: f64 = std::f64::consts::PI / 180.0 / 3600.0;

/// The price class: printed, else from the in-run (else the run-to-run) gyro bias; none without either.
///
/// Ours: above 100 deg/h `<10`, above 10 `10-100`, above 1 `100-1000`, above 0.1 `1000-10000`, above 0.005
/// `10000-100000`, else `>100000`.
pub fn price_class(model: &Model) -> Option<PriceClass> {
    let table = model.catalog();
    if let Some(class) = table.and_then(|table| table.price_class.as_deref()) {
        let class = PRICE_CLASSES.iter().find(|known| **known == class)?;
        let evidence = table
            .and_then(|table| table.price_evidence.clone())
            .unwrap_or_else(|| "stated in the model".to_string());
        return Some(PriceClass { class, evidence });
    }
    let largest = |of: &dyn Fn(usize) -> Option<f64>| (0..3).filter_map(of).max_by(f64::total_cmp);
    let in_run = largest(&|axis| model.instability_floor(Sensor::Gyro, axis));
    let run_to_run = || largest(&|axis| model.under(Sensor::Gyro, "bias.stability", axis)?.value);
    let bias_deg_h = in_run.or_else(run_to_run)? / DEG_PER_H;
    let place = [100.0, 10.0, 1.0, 0.1, 0.005]
        .iter()
        .position(|limit| bias_deg_h > *limit)
        .unwrap_or(5);
    Some(PriceClass {
        class: PRICE_CLASSES[place],
        evidence: "estimated from gyro bias".to_string(),
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::price_class;
    use crate::catalogue::Catalogue;

    #[test]
    fn printed_prices_are_read_from_their_evidence() {
        let of = |name: &str| price_class(&Catalogue::embedded().find(name).unwrap()).unwrap();
        assert_eq!(of("HG4930").printed_usd(), Some((8000.0, 8000.0)));
        assert_eq!(of("HG4930").letter(), Some("S"));
        assert_eq!(of("LN-200S").printed_usd(), Some((20_000.0, 30_000.0)));
        let (euro, _) = of("Xsens MTi-630").printed_usd().unwrap();
        assert!((euro - 1100.0).abs() < 1e-9);
        assert_eq!(of("HG9900").printed_usd(), None, "estimated");
    }
}
