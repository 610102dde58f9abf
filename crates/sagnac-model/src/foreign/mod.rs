//! Files of other tools read back: as models, and judged number by number.

pub mod audit;
mod convention;
mod flat;
mod import;
mod readings;

pub use audit::{Audit, AuditEntry, Mistake, Ratio, Verdict, audit};
pub use convention::Quantity;
pub use import::{Imported, import};
