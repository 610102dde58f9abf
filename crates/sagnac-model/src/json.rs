//! A model as JSON: the tables and texts of its file.

use crate::model::Model;
use serde_json::{Map, Number, Value as Json};
use toml_edit::{Item, TableLike, Value};

impl Model {
    /// The file as JSON: tables are objects, quantities stay texts with units.
    pub fn to_json(&self) -> Json {
        table(self.document.as_table())
    }
}

fn table(members: &dyn TableLike) -> Json {
    Json::Object(
        members
            .iter()
            .filter(|(_, item)| !item.is_none())
            .map(|(key, value)| (key.to_string(), item(value)))
            .collect::<Map<_, _>>(),
    )
}

fn item(item: &Item) -> Json {
    match item {
        Item::None => Json::Null,
        Item::Value(inner) => value(inner),
        Item::Table(inner) => table(inner),
        Item::ArrayOfTables(tables) => {
            Json::Array(tables.iter().map(|inner| table(inner)).collect())
        }
    }
}

fn value(value_: &Value) -> Json {
    match value_ {
        Value::String(text) => Json::String(text.value().clone()),
        Value::Integer(number) => Json::Number((*number.value()).into()),
        Value::Float(number) => Number::from_f64(*number.value()).map_or(Json::Null, Json::Number),
        Value::Boolean(flag) => Json::Bool(*flag.value()),
        Value::Datetime(date) => Json::String(date.value().to_string()),
        Value::Array(array) => Json::Array(array.iter().map(value).collect()),
        Value::InlineTable(inner) => table(inner),
    }
}
