//! Files of other tools read back: as models, and judged number by number.

pub mod audit;
mod convention;
mod correct;
mod expression;
mod flat;
mod import;
mod mistake;
mod notes;
mod readings;

pub use audit::{Audit, AuditEntry, Ratio, Verdict, audit};
pub use convention::Quantity;
pub use import::{Imported, import};
pub use mistake::Mistake;
