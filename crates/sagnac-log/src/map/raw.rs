//! What a format hands to the mapping: columns by index and name, in the source's own units.

use crate::text::number::TimeKind;
use crate::{Block, Error, Topic};

/// What a column's cells hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Cells {
    #[default]
    Numbers,
    /// Text and no numbers.
    Text,
    /// ISO 8601 dates.
    Dates,
    /// The last column has neither name nor value: the rows end by a separator.
    Nothing,
}

/// A column as the format knows it.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct RawColumn {
    /// Name, empty where the source has none.
    pub(crate) name: String,
    /// Unit as the source writes it.
    pub(crate) unit: Option<String>,
    /// True where the unit is that of the format's own time stamps, which no user has to name.
    pub(crate) is_own_unit: bool,
    /// The channel it is by the format's own definition (`gyro_x`, `time`), with its unit known.
    pub(crate) channel: Option<String>,
    /// Its values in the first rows, for checks and hints.
    pub(crate) preview: Vec<f64>,
    pub(crate) cells: Cells,
    /// Its header, unit and all, as the source writes it.
    pub(crate) header: String,
}

impl RawColumn {
    /// Whether it holds text and no numbers; dates are text.
    pub(crate) fn is_text(&self) -> bool {
        matches!(self.cells, Cells::Text | Cells::Dates)
    }

    pub(crate) fn is_date(&self) -> bool {
        self.cells == Cells::Dates
    }
}

/// What a format found.
#[derive(Debug, Clone, Default)]
pub(crate) struct RawLayout {
    pub(crate) format: String,
    pub(crate) columns: Vec<RawColumn>,
    /// True where columns have names that a user could write.
    pub(crate) has_names: bool,
    pub(crate) rate_hz: Option<f64>,
    pub(crate) topics: Vec<Topic>,
    pub(crate) topic: Option<String>,
    pub(crate) frame: Option<String>,
    /// `frame_id` of ROS messages.
    pub(crate) frame_id: Option<String>,
    pub(crate) covariances: Option<[[f64; 9]; 2]>,
    pub(crate) samples: Option<u64>,
    pub(crate) notes: Vec<String>,
    /// True where the cells of a row can be had as text.
    pub(crate) has_cells: bool,
    /// Where the header stands, for errors ("line 1").
    pub(crate) header_place: Option<String>,
}

/// What the mapping wants of a format.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Plan {
    /// Column of time and how it is read.
    pub(crate) time: Option<(usize, TimeKind)>,
    /// Columns wanted, in this order.
    pub(crate) columns: Vec<usize>,
    /// Of these, whether a cell of text is a missing value rather than an error.
    pub(crate) is_lenient: Vec<bool>,
    /// Columns wanted as text, where the format has them.
    pub(crate) texts: Vec<usize>,
}

/// A format, before mapping.
pub(crate) trait RawReader {
    fn raw(&self) -> &RawLayout;
    /// Fixes what `read_raw` delivers. Called once, before the first block.
    fn select(&mut self, plan: Plan) -> Result<(), Error>;
    /// The next rows; `false` at the end.
    fn read_raw(&mut self, block: &mut Block) -> Result<bool, Error>;
}
