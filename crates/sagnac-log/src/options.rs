//! How a log is to be read: the options that every command shares.

/// The options `--columns --rate --topic --start --end --axes`, as the user wrote them or already as numbers.
#[derive(Debug, Clone, PartialEq, Default)]
#[allow(
    clippy::struct_excessive_bools,
    reason = "independent switches, named where they are set"
)]
pub struct ReadOptions {
    /// `--columns 'time=0:us, gyro=4,5,6:deg/s'`.
    pub columns: Option<String>,
    /// `--rate`, in Hz. Overrides the stamps.
    pub rate_hz: Option<f64>,
    /// `--topic`.
    pub topic: Option<String>,
    /// Takes the first of several topics instead of refusing, for a look at what is there.
    pub any_topic: bool,
    /// Hands on the columns that `columns` does not name, as they are.
    pub keep_others: bool,
    /// Keeps the columns that are no channels as text, cell by cell as they are ([`crate::Layout::texts`]),
    /// where the format is a table of text: for writing them to CSV again.
    pub keep_text: bool,
    /// `--start`, seconds from the first sample.
    pub start_s: Option<f64>,
    /// `--end`, seconds from the first sample.
    pub end_s: Option<f64>,
    /// `--axes 'x=-y, y=x, z=z'`.
    pub axes: Option<String>,
    /// The log is still being written: rows are handed on as they come, a text table is recognized by its first rows.
    pub is_live: bool,
    /// Threads that may parse at once; 0: as many as the machine has.
    pub threads: usize,
}
