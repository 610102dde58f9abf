//! `[catalog]`: what the catalogue says about a sensor besides its numbers.

/// A quantity for which the sources disagree.
#[derive(Debug, Clone, PartialEq)]
pub struct Conflict {
    /// The parameter path without axis.
    pub parameter: String,
    /// The value used, as text.
    pub used: String,
    /// The values not used.
    pub others: Vec<OtherValue>,
}

/// A value that was not used.
#[derive(Debug, Clone, PartialEq)]
pub struct OtherValue {
    /// As printed.
    pub value: String,
    /// As printed.
    pub unit: String,
    /// Where it is printed.
    pub source: String,
}

/// The table `[catalog]` of a model file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CatalogTable {
    /// `D` data sheet, `M` measured, `S` second hand: the worst among the numbers used.
    pub quality: Option<String>,
    /// USD: `<10`, `10-100`, `100-1000`, `1000-10000`, `10000-100000`, `>100000`.
    pub price_class: Option<String>,
    /// The printed source of the price.
    pub price_evidence: Option<String>,
    /// Everything that is no number of the model.
    pub notes: Vec<String>,
    /// Where the sources disagree.
    pub conflicts: Vec<Conflict>,
}

/// The price classes, cheapest first.
pub const PRICE_CLASSES: [&str; 6] = [
    "<10",
    "10-100",
    "100-1000",
    "1000-10000",
    "10000-100000",
    ">100000",
];
