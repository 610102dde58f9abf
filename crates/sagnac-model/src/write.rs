//! Changing a model: the typed numbers and the document change together, and nothing else in the file does.

use crate::calibration::Calibration;
use crate::entry::Entry;
use crate::error::Error;
use crate::model::{Model, Process, SensorTexts, ThermalTerm};
use crate::path::ParameterPath;
use crate::read::problem_of;
use crate::schema::{Kind, LEAVES, Shape};
use crate::units::{Dimension, Unit, format_number};
use sagnac_core::{Output, Sensor};
use toml_edit::{Array, InlineTable, Item, Table, TableLike, Value};

impl Model {
    /// What a parameter measures in this model: the resolution of increments is an angle or a speed.
    pub fn dimension(&self, path: ParameterPath) -> Dimension {
        if path.leaf().key == "resolution" && self.output(path.sensor()) == Output::Increment {
            return match path.sensor() {
                Sensor::Gyro => Dimension::ANGLE,
                Sensor::Accel => Dimension::SPEED,
            };
        }
        path.dimension()
    }

    /// Sets a parameter: of the path's axis, or of all where it names none.
    ///
    /// ```
    /// use sagnac_model::{Entry, Model};
    /// use sagnac_model::units::Dimension;
    /// let mut model = Model::new("unit 7");
    /// model.set("gyro.noise.angle_random_walk.x", Entry::estimate(1e-4, 1e-6, [9.8e-5, 1.02e-4], Dimension::ANGLE_RANDOM_WALK))?;
    /// model.set("gyro.noise.rate_random_walk", Entry::limit(1e-7, Dimension::RATE_RANDOM_WALK))?;
    /// let again = Model::parse(&model.to_toml(), "unit7.toml")?;
    /// assert_eq!(again.get("gyro.noise.angle_random_walk.x").unwrap().sigma, Some(1e-6));
    /// # Ok::<(), sagnac_model::Error>(())
    /// ```
    ///
    /// # Errors
    /// An unknown path, or a value that the parameter cannot take (negative noise, not finite, …).
    pub fn set(&mut self, path: &str, entry: Entry) -> Result<(), Error> {
        self.set_at(path.parse()?, entry)
    }

    /// As [`Model::set`], by a path that was parsed.
    pub fn set_at(&mut self, path: ParameterPath, mut entry: Entry) -> Result<(), Error> {
        let dimension = self.dimension(path);
        if let Some(problem) = problem_of(&entry, path.leaf().sign, dimension) {
            return Err(Error::BadValue {
                path: path.to_string(),
                problem: format!("cannot be set: {problem}"),
            });
        }
        if !entry.unit.measures(dimension) {
            entry.unit = Unit::field(dimension);
        }
        for element in path.elements() {
            self.entries.insert(element, entry.clone());
        }
        self.sensors[path.sensor().index()].present = true;
        self.write_leaf(path);
        Ok(())
    }

    /// Takes a parameter out: of the path's axis, or of all.
    pub fn remove(&mut self, path: ParameterPath) {
        for element in path.elements() {
            self.entries.remove(&element);
        }
        self.write_leaf(path);
    }

    /// Renames the sensor.
    pub fn set_name(&mut self, name: &str) {
        self.name = name.to_string();
        self.set_root("name", text(name));
    }

    /// Says who makes it.
    pub fn set_manufacturer(&mut self, manufacturer: &str) {
        self.manufacturer = Some(manufacturer.to_string());
        self.set_root("manufacturer", text(manufacturer));
    }

    /// Sets the sampling rate \[Hz\].
    pub fn set_sample_rate_hz(&mut self, rate_hz: f64) -> Result<(), Error> {
        self.set_sample_rate(Entry::of(rate_hz, Dimension::FREQUENCY))
    }

    /// Sets the sampling rate with its source.
    pub fn set_sample_rate(&mut self, entry: Entry) -> Result<(), Error> {
        if !entry
            .value
            .is_some_and(|rate| rate.is_finite() && rate > 0.0)
        {
            return Err(Error::BadValue {
                path: "sample_rate".into(),
                problem: "must be above zero".into(),
            });
        }
        self.set_root("sample_rate", cell(&entry, Dimension::FREQUENCY));
        self.sample_rate = Some(entry);
        Ok(())
    }

    /// Sets T0 [°C].
    pub fn set_reference_temperature_c(&mut self, temperature_c: f64) {
        let entry = Entry::of(temperature_c, Dimension::TEMPERATURE);
        self.set_root(
            "reference_temperature",
            cell(&entry, Dimension::TEMPERATURE),
        );
        self.reference_temperature = Some(entry);
    }

    /// Sets where the temperature terms hold [°C].
    pub fn set_temperature_range_c(&mut self, range_c: [f64; 2]) {
        self.temperature_range_c = Some(range_c);
        self.set_root("temperature_range", temperatures(&range_c));
    }

    /// Sets where one temperature term holds [°C].
    pub fn set_own_temperature_range_c(
        &mut self,
        sensor: Sensor,
        term: ThermalTerm,
        range_c: [f64; 2],
    ) {
        self.texts(sensor).temperature_range_c[term.index()] = Some(range_c);
        self.with_table(sensor, &[term.key()], |table| {
            insert(table, "temperature_range", temperatures(&range_c));
        });
    }

    /// Sets a natural cubic spline: knots [°C] and x, y, z at each; it takes the place of a polynomial.
    pub fn set_spline(
        &mut self,
        sensor: Sensor,
        term: ThermalTerm,
        knots_c: &[f64],
        values: &[[f64; 3]],
    ) -> Result<(), Error> {
        let name = format!("{}.{}.temperature_spline", sensor.key(), term.key());
        if let Err(error) = sagnac_core::TemperatureSpline::new(knots_c, values) {
            return Err(Error::BadValue {
                path: name,
                problem: format!("cannot be set: {error}"),
            });
        }
        self.clear_temperature(sensor, term);
        self.texts(sensor).knots_c[term.index()] = Some(knots_c.to_vec());
        self.with_table(sensor, &[term.key(), "temperature_spline"], |table| {
            insert(table, "knots", temperatures(knots_c));
        });
        for (number, row) in values.iter().enumerate() {
            for (axis, value) in ["x", "y", "z"].iter().zip(row) {
                let path: ParameterPath = format!("{name}.{}.{axis}", number + 1).parse()?;
                let dimension = path.dimension();
                self.entries.insert(path, Entry::of(*value, dimension));
                if number + 1 == values.len() {
                    self.write_leaf(path);
                }
            }
        }
        Ok(())
    }

    /// Takes polynomial and spline of a term out.
    pub fn clear_temperature(&mut self, sensor: Sensor, term: ThermalTerm) {
        let gone = |path: &ParameterPath| {
            path.sensor() == sensor
                && path.leaf().table.first() == Some(&term.key())
                && matches!(path.leaf().kind, Kind::Powers | Kind::Spline)
        };
        self.entries.retain(|path, _| !gone(path));
        self.texts(sensor).knots_c[term.index()] = None;
        if self.sensors[sensor.index()].present {
            self.with_table(sensor, &[term.key()], |table| {
                table.remove("temperature");
                table.remove("temperature_spline");
            });
        }
    }

    /// Says what kind of sensor it is.
    pub fn set_technology(&mut self, sensor: Sensor, technology: &str) {
        self.texts(sensor).technology = Some(technology.to_string());
        self.with_table(sensor, &[], |table| {
            insert(table, "technology", text(technology));
        });
    }

    /// Says whether it delivers rates or increments; a resolution is to be set afterwards.
    pub fn set_output(&mut self, sensor: Sensor, output: Output) {
        self.texts(sensor).output = Some(output);
        let word = if output == Output::Rate {
            "rate"
        } else {
            "increment"
        };
        self.with_table(sensor, &[], |table| insert(table, "output", text(word)));
    }

    /// Chooses the process of the bias instability.
    pub fn set_process(&mut self, sensor: Sensor, process: Process) {
        self.texts(sensor).process = Some(process);
        self.with_table(sensor, &["bias", "instability"], |table| {
            insert(table, "process", text(process.key()));
        });
    }

    /// Adds what a calibration estimated together.
    pub fn push_calibration(&mut self, calibration: Calibration) {
        let mut table = Table::new();
        table.insert("method", text(&calibration.method));
        for (key, value) in [
            ("source", &calibration.source),
            ("frame", &calibration.frame),
            ("note", &calibration.note),
        ] {
            if let Some(value) = value {
                table.insert(key, text(value));
            }
        }
        table.insert(
            "names",
            lines(
                calibration
                    .names
                    .iter()
                    .map(|name| Value::from(name.as_str())),
            ),
        );
        if let Some(covariance) = &calibration.covariance {
            table.insert(
                "covariance",
                lines(
                    covariance
                        .iter()
                        .map(|row| Value::Array(row.iter().map(|number| float(*number)).collect())),
                ),
            );
        }
        if let Some(dof) = calibration.dof {
            table.insert("dof", Item::Value(float(dof)));
        }
        if !calibration.held.is_empty() {
            table.insert(
                "held",
                lines(
                    calibration
                        .held
                        .iter()
                        .map(|name| Value::from(name.as_str())),
                ),
            );
        }
        let blocks = self
            .document
            .entry("calibration")
            .or_insert(Item::ArrayOfTables(toml_edit::ArrayOfTables::new()));
        if let Some(blocks) = blocks.as_array_of_tables_mut() {
            blocks.push(table);
        } else if let Some(blocks) = blocks.as_array_mut() {
            blocks.push(table.into_inline_table());
        }
        self.calibrations.push(calibration);
    }

    /// Takes all calibrations out.
    pub fn clear_calibrations(&mut self) {
        self.calibrations.clear();
        self.document.remove("calibration");
    }

    fn texts(&mut self, sensor: Sensor) -> &mut SensorTexts {
        let texts = &mut self.sensors[sensor.index()];
        texts.present = true;
        texts
    }

    fn set_root(&mut self, key: &str, item: Item) {
        insert(self.document.as_table_mut(), key, item);
    }

    /// Changes a table of a sensor, which is made where it does not exist.
    fn with_table(
        &mut self,
        sensor: Sensor,
        keys: &[&str],
        change: impl FnOnce(&mut dyn TableLike),
    ) {
        let mut table: &mut dyn TableLike = self.document.as_table_mut();
        for key in std::iter::once(sensor.key()).chain(keys.iter().copied()) {
            let item = table
                .entry(key)
                .or_insert_with(|| Item::Table(Table::new()));
            // The reader refuses anything else in this place.
            let Some(inner) = item.as_table_like_mut() else {
                return;
            };
            table = inner;
        }
        change(table);
    }

    /// Writes what the entries of a key now are into the document.
    fn write_leaf(&mut self, path: ParameterPath) {
        let leaf = path.leaf();
        let sensor = path.sensor();
        if leaf.kind == Kind::Listed {
            return self.write_list(path);
        }
        let count = if leaf.kind == Kind::Value {
            1
        } else {
            self.count(path)
        };
        let rows: Vec<Item> = (0..count)
            .map(|row| {
                let number = if leaf.kind == Kind::Value { 0 } else { row + 1 };
                let base = ParameterPath::new(sensor, path.leaf_index(), number, None);
                leaf_item(&self.entries_of(base), leaf.shape, self.dimension(base))
            })
            .collect();
        let empty = !self
            .entries
            .keys()
            .any(|other| other.sensor() == sensor && other.leaf_index() == path.leaf_index());
        let item = match leaf.kind {
            Kind::Value => rows.into_iter().next().unwrap_or_default(),
            _ => lines(rows.into_iter().filter_map(|row| row.into_value().ok())),
        };
        self.with_table(sensor, leaf.table, |table| {
            if empty {
                table.remove(leaf.key);
            } else {
                insert(table, leaf.key, item);
            }
        });
    }

    fn entries_of(&self, base: ParameterPath) -> Vec<Option<&Entry>> {
        base.elements()
            .into_iter()
            .map(|element| self.entries.get(&element))
            .collect()
    }

    /// Writes a whole list of processes.
    fn write_list(&mut self, path: ParameterPath) {
        let sensor = path.sensor();
        let table = path.leaf().table;
        let keys: Vec<usize> = (0..LEAVES.len())
            .filter(|index| LEAVES[*index].table == table && LEAVES[*index].kind == Kind::Listed)
            .collect();
        let count = keys
            .iter()
            .map(|index| self.count(ParameterPath::new(sensor, *index, 1, None)))
            .max()
            .unwrap_or(0);
        let items = (1..=count).map(|number| {
            let mut inline = InlineTable::new();
            for index in &keys {
                let base = ParameterPath::new(sensor, *index, number, None);
                let leaf = base.leaf();
                let entries = self.entries_of(base);
                if entries.iter().any(Option::is_some)
                    && let Ok(value) =
                        leaf_item(&entries, leaf.shape, base.dimension()).into_value()
                {
                    inline.insert(leaf.key, value);
                }
            }
            Value::InlineTable(inline)
        });
        let item = lines(items);
        let Some((key, outer)) = table.split_last() else {
            return;
        };
        self.with_table(sensor, outer, |target| {
            if count == 0 {
                target.remove(key);
            } else {
                insert(target, key, item);
            }
        });
    }
}

/// Replaces a value and keeps the comment behind it.
fn insert(table: &mut dyn TableLike, key: &str, mut item: Item) {
    if let (Some(Item::Value(old)), Item::Value(new)) = (table.get(key), &mut item) {
        *new.decor_mut() = old.decor().clone();
    }
    if let Some(old) = table.get_mut(key) {
        *old = item;
    } else {
        table.insert(key, item);
    }
}

fn text(value: &str) -> Item {
    toml_edit::value(value)
}

/// A float that TOML reads as a float, in its shortest form.
fn float(number: f64) -> Value {
    let written = format_number(number);
    let written = if written.contains(['.', 'e']) {
        written
    } else {
        format!("{written}.0")
    };
    written.parse().unwrap_or_else(|_| Value::from(number))
}

/// A list: in one line where it is short, else a line an entry.
fn lines(values: impl Iterator<Item = Value>) -> Item {
    let mut array: Array = values.collect();
    let length: usize = array.iter().map(|value| value.to_string().len() + 2).sum();
    if length > 120 {
        for value in array.iter_mut() {
            value.decor_mut().set_prefix("\n    ");
        }
        array.set_trailing("\n");
        array.set_trailing_comma(true);
    } else {
        array.fmt();
    }
    Item::Value(Value::Array(array))
}

fn temperatures(values_c: &[f64]) -> Item {
    lines(
        values_c
            .iter()
            .map(|value| Value::from(Dimension::TEMPERATURE.format(*value))),
    )
}

/// The item of a key: as short as the entries allow.
fn leaf_item(entries: &[Option<&Entry>], shape: Shape, dimension: Dimension) -> Item {
    let present: Vec<&Entry> = entries.iter().flatten().copied().collect();
    let all = present.len() == entries.len();
    let same = present.windows(2).all(|pair| pair[0] == pair[1]);
    let single = matches!(shape, Shape::Axes) || (shape == Shape::Elements && present.len() > 1);
    if single
        && all
        && same
        && let Some(entry) = present.first()
    {
        return cell(entry, dimension);
    }
    // One table of arrays where all entries say the same kinds of things.
    let kinds = |entry: &Entry| entry.quantities().map(|(_, value)| value.is_some());
    let shared = present.windows(2).all(|pair| {
        kinds(pair[0]) == kinds(pair[1])
            && pair[0].source == pair[1].source
            && pair[0].note == pair[1].note
    });
    if let Some(first) = present
        .first()
        .filter(|first| shared && !first.is_bare() && (all || shape == Shape::Elements))
    {
        let mut table = InlineTable::new();
        for (at, (key, value)) in first.quantities().into_iter().enumerate() {
            if value.is_some() {
                let dimension = if key == "sigma" {
                    sigma_dimension(dimension)
                } else {
                    dimension
                };
                let values: Vec<Option<Value>> = entries
                    .iter()
                    .map(|entry| {
                        let entry = entry.as_ref()?;
                        Some(Value::from(
                            dimension.format_in(entry.quantities()[at].1?, &entry.unit),
                        ))
                    })
                    .collect();
                table.insert(key, arranged(values, shape));
            }
        }
        append_texts(&mut table, first);
        return Item::Value(Value::InlineTable(table));
    }
    let values = entries
        .iter()
        .map(|entry| {
            entry
                .as_ref()
                .and_then(|entry| cell(entry, dimension).into_value().ok())
        })
        .collect();
    Item::Value(arranged(values, shape))
}

/// Values in the arrangement of their shape; what is not known is an empty table, or left out of a table of elements.
fn arranged(values: Vec<Option<Value>>, shape: Shape) -> Value {
    if shape == Shape::Elements {
        let mut table = InlineTable::new();
        for (key, value) in shape.suffixes().iter().zip(values) {
            if let Some(value) = value {
                table.insert(*key, value);
            }
        }
        return Value::InlineTable(table);
    }
    let columns = match shape {
        Shape::Products => 6,
        _ => 3,
    };
    let cells: Vec<Value> = values
        .into_iter()
        .map(|value| value.unwrap_or_else(|| Value::InlineTable(InlineTable::new())))
        .collect();
    let rows: Vec<Value> = cells
        .chunks(columns)
        .map(|row| Value::Array(row.iter().cloned().collect()))
        .collect();
    match <[Value; 1]>::try_from(rows) {
        Ok([row]) => row,
        Err(rows) => lines(rows.into_iter())
            .into_value()
            .unwrap_or_else(|_| Value::Array(Array::new())),
    }
}

fn sigma_dimension(dimension: Dimension) -> Dimension {
    if dimension.is_absolute_temperature() {
        Dimension::TEMPERATURE_DIFFERENCE
    } else {
        dimension
    }
}

/// One entry: a text, or a table where it says more.
fn cell(entry: &Entry, dimension: Dimension) -> Item {
    let written =
        |value: f64, dimension: Dimension| Value::from(dimension.format_in(value, &entry.unit));
    if entry.is_bare() {
        return Item::Value(written(entry.simulated(), dimension));
    }
    let mut table = InlineTable::new();
    for (key, value) in entry.quantities() {
        if let Some(value) = value {
            let dimension = if key == "sigma" {
                sigma_dimension(dimension)
            } else {
                dimension
            };
            table.insert(key, written(value, dimension));
        }
    }
    append_texts(&mut table, entry);
    Item::Value(Value::InlineTable(table))
}

fn append_texts(table: &mut InlineTable, entry: &Entry) {
    for (key, value) in [("source", &entry.source), ("note", &entry.note)] {
        if let Some(value) = value {
            table.insert(key, Value::from(value.as_str()));
        }
    }
}
